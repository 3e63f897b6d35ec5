"""The original Pix2Pix beside ours: outputs, losses, weights after some steps, seconds an image.

`--original` is a checkout of junyanz/pytorch-CycleGAN-and-pix2pix. Both begin with the same weights
and see the same pictures. Dropout is either off in both or draws the same noise for both: in the
order of the axes, since PyTorch's own order is that of memory, in which the two differ.

python tools/pix2pix_parity.py --original ../pytorch-CycleGAN-and-pix2pix --json parity.json
"""

import contextlib
import dataclasses
import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import torch
import tyro

from synthdepth.pix2pix.generator import UNetGenerator
from synthdepth.pix2pix.inference import for_inference
from synthdepth.pix2pix.objective import ObjectiveConfig, discriminator_loss, generator_losses
from synthdepth.pix2pix.original import (
    load_original_discriminator,
    load_original_generator,
    original_weights,
)
from synthdepth.pix2pix.target import DepthCoding

LR, BETAS = 2e-4, (0.5, 0.999)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to compare.

    Attributes:
        original: the checkout.
        size: of the pictures, pixels.
        ngf: channels of the first layer, of both networks.
        steps: of the optimisers, for parity; 0 leaves parity out.
        batches: batch sizes of the training to time.
        rounds: timings of each way, in turns; the best counts; 0 times nothing.
        threads: of PyTorch.
        json: where the figures go.
    """

    original: Path
    size: int = 256
    ngf: int = 64
    steps: int = 5
    batches: tuple[int, ...] = (1, 4, 8, 16)
    rounds: int = 5
    threads: int = 2
    json: Path | None = None


class Ours:
    """Our networks with the original's weights, and a step of theirs as in training."""

    def __init__(self, model, *, bfloat16: bool = False, fused: bool = True, dropout: bool = True):
        self.generator = load_original_generator(model.netG.state_dict())
        self.discriminator = load_original_discriminator(model.netD.state_dict())
        for module in self.generator.modules():
            if isinstance(module, torch.nn.Dropout) and not dropout:
                module.p = 0.0
        self.adams = [
            torch.optim.Adam(network.parameters(), lr=LR, betas=BETAS, fused=fused)
            for network in (self.generator, self.discriminator)
        ]
        self.half = torch.autocast("cpu", torch.bfloat16, enabled=bfloat16)

    def step(self, image: torch.Tensor, depth: torch.Tensor) -> dict[str, torch.Tensor]:
        """One step of the discriminator, one of the generator; the losses of both before them."""
        generator_adam, discriminator_adam = self.adams
        with self.half:
            fake = self.generator(image)
            self.discriminator.requires_grad_(True)
            # The original's order, in which the running statistics see them.
            fake_logits = self.discriminator(image, fake.detach())
            real_logits = self.discriminator(image, depth)
        loss = discriminator_loss(real_logits, fake_logits)
        discriminator_adam.zero_grad()
        loss.backward()
        discriminator_adam.step()

        self.discriminator.requires_grad_(False)
        with self.half:
            fake_logits = self.discriminator(image, fake)
        losses = generator_losses(
            fake_logits, fake, depth, config=ObjectiveConfig(), coding=DepthCoding(kind="linear")
        )
        generator_adam.zero_grad()
        losses["total"].backward()
        generator_adam.step()
        return {"discriminator": loss, **losses}


def original_model(options: Options, *, dropout: bool):
    """The original's own model class, with its own defaults for Pix2Pix."""
    sys.path.insert(0, str(options.original.resolve()))
    from models.pix2pix_model import Pix2PixModel

    settings = {
        "isTrain": True,
        "gpu_ids": [],
        "checkpoints_dir": "",
        "name": "",
        "preprocess": "none",
        "direction": "AtoB",
        "input_nc": 3,
        "output_nc": 1,
        "ngf": options.ngf,
        "ndf": options.ngf,
        "netG": "unet_256",
        "netD": "basic",
        "n_layers_D": 3,
        "norm": "batch",
        "no_dropout": not dropout,
        "init_type": "normal",
        "init_gain": 0.02,
        "gan_mode": "vanilla",
        "pool_size": 0,
        "lr": LR,
        "beta1": BETAS[0],
        "lambda_L1": 100.0,
    }
    with contextlib.redirect_stdout(None):
        return Pix2PixModel(SimpleNamespace(**settings))


def original_step(model, image: torch.Tensor, depth: torch.Tensor) -> dict[str, torch.Tensor]:
    """The original's step; its losses under our names."""
    model.set_input({"A": image, "B": depth, "A_paths": [], "B_paths": []})
    model.optimize_parameters()
    return {
        "discriminator": model.loss_D,
        "gan": model.loss_G_GAN,
        "l1": model.loss_G_L1 / 100.0,
        "total": model.loss_G,
    }


def ordered_dropout(x, p=0.5, training=True, inplace=False):
    """Dropout whose noise does not depend on the memory layout."""
    return x * (torch.rand(x.shape) >= p) / (1 - p) if training else x


def parity(options: Options, *, dropout: bool, dtype: torch.dtype) -> dict:
    """Largest differences between the two, for a batch of two.

    In float64 they tell whether both do the same. In float32 weights drift apart from rounding
    alone: the first steps of Adam are as long for a gradient of nearly 0 as for any.
    """
    torch.manual_seed(0)
    model = original_model(options, dropout=dropout)
    ours = Ours(model, fused=False, dropout=dropout)
    for network in (model.netG, model.netD, model.criterionGAN, ours.generator, ours.discriminator):
        network.to(dtype)
    pictures = 2 * torch.rand(options.steps, 2, 4, options.size, options.size, dtype=dtype) - 1
    image, depth = pictures[0, :, :3], pictures[0, :, 3:]
    figures = {"dropout": dropout, "dtype": str(dtype).removeprefix("torch.")}
    with torch.no_grad(), mock.patch("torch.nn.functional.dropout", ordered_dropout):
        for network in (model.netG, ours.generator):
            network.eval()
        figures["output_evaluated"] = difference(model.netG(image), ours.generator(image))
        for network in (model.netG, ours.generator):
            network.train()
        judged = model.netD(torch.cat([image, depth], 1))
        figures["logits"] = difference(judged, ours.discriminator(image, depth))
    # That moved running statistics of both discriminators alike; training goes on from there.

    figures["losses"] = 0.0
    with mock.patch("torch.nn.functional.dropout", ordered_dropout):
        for step, batch in enumerate(pictures):
            results = []
            for run in (lambda *x: original_step(model, *x), ours.step):
                torch.manual_seed(step)
                results.append(run(batch[:, :3], batch[:, 3:]))
            theirs, mine = results
            for name in theirs:
                figures["losses"] = max(figures["losses"], difference(theirs[name], mine[name]))
            if step == 0:
                figures["first_losses"] = {name: loss.item() for name, loss in theirs.items()}
    for name, network, theirs in (
        ("generator", ours.generator, model.netG),
        ("discriminator", ours.discriminator, model.netD),
    ):
        pairs = [
            (value.double(), theirs.state_dict()[key].double())
            for key, value in original_weights(network).items()
        ]
        figures[f"{name}_weights"] = max(difference(a, b) for a, b in pairs)
        square = sum(float((a - b).square().sum()) for a, b in pairs)
        figures[f"{name}_weights_rms"] = (square / sum(a.numel() for a, _ in pairs)) ** 0.5
    return figures


def difference(a: torch.Tensor, b: torch.Tensor) -> float:
    return float((a - b).detach().abs().max())


def timed(candidates: dict[str, Callable[[], object]], rounds: int) -> dict[str, dict[str, float]]:
    """Best wall and processor seconds of each, taken in turns, so that all see the same machine."""
    best = dict.fromkeys(candidates, (float("inf"), float("inf")))
    for turn in range(rounds + 1):
        for name, run in candidates.items():
            wall, cpu = time.perf_counter(), time.process_time()
            run()
            spent = (time.perf_counter() - wall, time.process_time() - cpu)
            if turn > 0:  # the first warms up
                best[name] = tuple(map(min, best[name], spent))
    return {name: {"wall_s": wall, "cpu_s": cpu} for name, (wall, cpu) in best.items()}


def training_speed(options: Options, batch: int) -> dict[str, dict[str, float]]:
    """Seconds a step."""
    model = original_model(options, dropout=True)
    x = 2 * torch.rand(batch, 4, options.size, options.size) - 1
    image, depth = x[:, :3].contiguous(), x[:, 3:].contiguous()
    ways = {
        "ours, plain Adam": Ours(model, fused=False),
        "ours": Ours(model),
        "ours, bfloat16": Ours(model, bfloat16=True),
    }
    candidates = {"original": lambda: original_step(model, image, depth)}
    candidates |= {name: lambda run=way: run.step(image, depth) for name, way in ways.items()}
    return timed(candidates, options.rounds)


def inference_speed(options: Options) -> dict[str, dict[str, float]]:
    """Seconds for one picture."""
    model = original_model(options, dropout=True)
    ours: UNetGenerator = load_original_generator(model.netG.state_dict()).eval()
    theirs = model.netG.eval()
    folded, half = for_inference(ours), for_inference(ours, dtype=torch.bfloat16)
    image = 2 * torch.rand(1, 3, options.size, options.size) - 1
    ways = {"original": theirs, "ours": ours, "ours, folded": folded, "ours, bfloat16": half}
    with torch.inference_mode():
        return timed({n: lambda run=way: run(image) for n, way in ways.items()}, options.rounds)


def main(options: Options) -> None:
    torch.set_num_threads(options.threads)
    figures = {}
    if options.steps > 0:
        cases = [(False, torch.float64), (True, torch.float64), (True, torch.float32)]
        figures["parity"] = [parity(options, dropout=drop, dtype=dtype) for drop, dtype in cases]
        print(json.dumps(figures["parity"], indent=1))
    if options.rounds > 0:
        figures["inference"] = inference_speed(options)
        show("inference", 1, figures["inference"])
        figures["training"] = {}
        for batch in options.batches:
            figures["training"][batch] = training_speed(options, batch)
            show("training", batch, figures["training"][batch])
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")


def show(what: str, batch: int, times: dict[str, dict[str, float]]) -> None:
    print(f"{what}, batch {batch}: seconds a picture, wall and processor, times the original")
    for name, row in times.items():
        faster = times["original"]["wall_s"] / row["wall_s"]
        print(f"  {name:18} {row['wall_s'] / batch:7.3f} {row['cpu_s'] / batch:7.3f} {faster:6.2f}")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
