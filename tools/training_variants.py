"""What each option of a training is worth: short trainings that differ in one thing from a base.

The base is the paper's method with a batch of 8 and a small network. All variants see the same
pairs and validate on the same scenes, which the training keeps back. "seed" is the base with other
first weights, order and noise: differences of its size mean nothing. Variants that are done are
not trained again.

python tools/training_variants.py --data data/neighborhood --out variants --json variants.json
"""

import dataclasses
import json
import time
from pathlib import Path

import torch
import tyro

from synthdepth.pix2pix.config import train_config
from synthdepth.pix2pix.train import train

# The paper's coding, and no average of the weights.
BASE = {
    "input.kind": "rgb",
    "generator.ngf": 16,
    "generator.depth": 7,
    "discriminator.ndf": 16,
    "batch_size": 8,
    "precision": "bf16",
    "validation_pairs": 0,
    "coding.kind": "linear",
    "ema": 0.0,
}
RESIZE = {"generator.upsample": "resize"}
COLOURS = {
    "augmentation.exposure_stops": 0.5,
    "augmentation.white_balance": 0.25,
    "augmentation.contrast": 0.3,
    "augmentation.noise": 4.0,
}
# What each of two options is worth beside the other.
LOG_AVERAGE = {"coding.kind": "log", "ema": 0.999}
VARIANTS = {
    "base": {},
    "seed": {"seed": 1},
    "log coding": {"coding.kind": "log"},
    "EMA 0.999": {"ema": 0.999},
    "no adversary": {"objective.lambda_gan": 0.0},
    "linear decay": {"decay": "linear"},
    "instance norm": {"generator.norm": "instance", "discriminator.norm": "instance"},
    "learning rate 0.001": {"lr": 1e-3},
    "embed, interval 5": {"input.kind": "embed"},
    "channels": {"input.kind": "channels"},
    "triangulated": {"input.kind": "triangulated"},
    "no dropout": {"generator.dropout": 0.0},
    "gradient loss 100": {"objective.lambda_gradient": 100.0},
    "SILog loss 10": {"objective.lambda_silog": 10.0},
    "resize convolutions": RESIZE,
    "colour augmentation": COLOURS,
    "log and EMA": LOG_AVERAGE,
    "log and EMA, seed": LOG_AVERAGE | {"seed": 1},
    "log and EMA, colours": LOG_AVERAGE | COLOURS,
    "log and EMA, colours, seed": LOG_AVERAGE | COLOURS | {"seed": 1},
    "log and EMA, resize": LOG_AVERAGE | RESIZE,
    "log and EMA, colours, resize": LOG_AVERAGE | COLOURS | RESIZE,
    "log and EMA, no adversary": LOG_AVERAGE | {"objective.lambda_gan": 0.0},
    "group norm": {"generator.norm": "group", "discriminator.norm": "group"},
    "no flip": {"augmentation.flip": 0.0},
    "float32": {"precision": "fp32"},
    "batch 1": {"batch_size": 1},
    "flow alone": {"input.kind": "flow"},
    "embed, DIS flow": {"input.kind": "embed", "input.flow": "dis"},
    "embed, interval 1": {"input.kind": "embed", "input.interval": 1},
    "embed, interval 9": {"input.kind": "embed", "input.interval": 9},
    "triangulated, DIS flow": {"input.kind": "triangulated", "input.flow": "dis"},
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to train.

    Attributes:
        data: datasets.
        out: folder of the trainings.
        only: names of variants; all without.
        epochs: of each.
        threads: of PyTorch.
        workers: processes that read ahead.
        json: where the figures go, after each variant.
    """

    data: tuple[Path, ...]
    out: Path
    only: tuple[str, ...] = tuple(VARIANTS)
    epochs: int = 4
    threads: int = 1
    workers: int = 1
    json: Path | None = None


def main(options: Options) -> None:
    torch.set_num_threads(options.threads)
    figures = {}
    for name in options.only:
        config = train_config(
            options=BASE
            | {
                "epochs": options.epochs,
                "validate_every": options.epochs,
                "workers": options.workers,
            }
            | VARIANTS[name]
        )
        out = options.out / name.replace(", ", "-").replace(" ", "_")
        start = time.process_time()
        report = train(config, options.data, out, device="cpu")
        spent = time.process_time() - start
        errors = {key: report.best[key] for key in ("rmse_m", "rel", "delta_1", "delta_2")}
        figures[name] = {key: round(value, 4) for key, value in errors.items()}
        if report.steps_now:
            figures[name]["cpu_ms_a_pair"] = round(
                1e3 * spent / (report.steps_now * config.batch_size), 1
            )
        print(f"{name:26}", "  ".join(f"{k} {v}" for k, v in figures[name].items()), flush=True)
        if options.json:
            options.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options))
