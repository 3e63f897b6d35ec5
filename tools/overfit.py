"""Can the network learn at all: train on a few pairs, and see how far it is off on the same pairs.

A trainer whose pairs, coding, losses or gradients are wrong does not come near; one that is right
learns eight pairs by heart.

python tools/overfit.py --data data/neighborhood --json overfit.json
"""

import dataclasses
import json
import tempfile
from pathlib import Path

import torch
import tyro

from synthdepth.pix2pix.checkpoint import load_generator
from synthdepth.pix2pix.config import train_config
from synthdepth.pix2pix.data import TrainingData
from synthdepth.pix2pix.distributed import processes
from synthdepth.pix2pix.train import train
from synthdepth.pix2pix.validation import ERRORS, picture_errors, predict_batch


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to train.

    Attributes:
        data: the dataset.
        pairs: how many.
        epochs: passes over them.
        input: what the network sees.
        coding: of depth, "log" or "linear".
        ngf: channels of the first layers.
        depth: of the U-Net: 7 for 128 pixels.
        threads: of PyTorch.
        json: where the figures go.
    """

    data: Path
    pairs: int = 8
    epochs: int = 1500
    input: str = "rgb"
    coding: str = "log"
    ngf: int = 32
    depth: int = 7
    threads: int = 2
    json: Path | None = None


def overfit(options: Options, out: Path) -> dict[str, float]:
    """Mean errors, names as in `ERRORS`, on the pairs that it was trained with."""
    config = train_config(
        options={
            "input.kind": options.input,
            "coding.kind": options.coding,
            "generator.ngf": options.ngf,
            "generator.depth": options.depth,
            # What is to be learnt by heart must not vary, and no statistics of a batch must differ
            # from those of use.
            "generator.dropout": 0.0,
            "generator.norm": "instance",
            "discriminator.norm": "instance",
            "discriminator.ndf": options.ngf,
            "augmentation.flip": 0.0,
            "input.rotation_deg": 0.0,
            "input.velocity_mps": 0.0,
            "input.velocity_share": 0.0,
            "batch_size": 4,
            "lr": 5e-4,
            # The average lags behind.
            "ema": 0.0,
            "decay": "linear",
            "precision": "bf16",
            "epochs": options.epochs,
            "validate_every": 0,
            "max_pairs": options.pairs,
            "workers": 0,
        }
    )
    train(config, [options.data], out, device="cpu")
    with processes("cpu") as place:
        batches = TrainingData(config, [options.data], place).batches(0)
        generator = load_generator(out)[0].eval()
        errors = []
        with torch.inference_mode():
            for batch in batches:
                depth_m = predict_batch(generator, batch, config, place.device)
                errors.append(picture_errors(depth_m, batch.depth_m, batch.valid))
    means = torch.cat(errors).mean(dim=0).tolist()
    return dict(zip(ERRORS, means, strict=True))


def main(options: Options) -> None:
    torch.set_num_threads(options.threads)
    with tempfile.TemporaryDirectory() as folder:
        figures = overfit(options, Path(folder) / "run")
    for name, value in figures.items():
        print(f"{name:10} {value:.4f}")
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options))
