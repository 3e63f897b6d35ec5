"""Everything that changes while a training runs: networks, optimisers, and where it stands."""

import dataclasses
from collections.abc import Iterator

import torch
from torch import nn

from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.discriminator import PatchDiscriminator
from synthdepth.pix2pix.generator import UNetGenerator
from synthdepth.pix2pix.layers import draw_weights
from synthdepth.seeding import derive_seed


@dataclasses.dataclass(kw_only=True)
class Progress:
    """Where a training stands.

    Attributes:
        epoch: the one under way, from 0.
        position: steps done in it.
        step: steps done in all.
        elapsed_s: time taken so far, over all runs.
        counted: steps since the last line of the log.
        log_bytes: size of the log.
        best: errors of the best validation so far, with its epoch; None before the first.
    """

    epoch: int = 0
    position: int = 0
    step: int = 0
    elapsed_s: float = 0.0
    counted: int = 0
    log_bytes: int = 0
    best: dict | None = None


class State:
    """The networks of a training with what goes with them.

    Args:
        config: of the training.
        device: where they lie.

    Attributes:
        generator, discriminator: as they are trained; no discriminator without `lambda_gan`.
        average: the generator's moving average; None without `ema`.
        generator_adam, discriminator_adam: their optimisers.
        terms: names of the losses.
        window: (terms,) float64, sums of the losses since the last line of the log.
        progress: where it stands.
    """

    def __init__(self, config: TrainConfig, device: torch.device):
        objective = config.objective
        rng = torch.Generator().manual_seed(derive_seed(config.seed, "weights"))
        # The networks bring pictures into the layout that is fastest. GPUs want weights in it too;
        # CPUs, measured, do not.
        layout = torch.channels_last if device.type == "cuda" else torch.preserve_format
        there = {"device": device, "memory_format": layout}

        def made(network: nn.Module) -> tuple[nn.Module, torch.optim.Adam]:
            network = draw_weights(network, rng).to(**there)
            betas = (config.beta1, config.beta2)
            adam = torch.optim.Adam(network.parameters(), lr=config.lr, betas=betas, fused=True)
            return network, adam

        self.generator, self.generator_adam = made(UNetGenerator(config.generator))
        self.discriminator = self.discriminator_adam = self.average = None
        if objective.lambda_gan > 0:
            network = PatchDiscriminator(config.discriminator)
            self.discriminator, self.discriminator_adam = made(network)
        if config.ema > 0:
            self.average = UNetGenerator(config.generator).to(**there).requires_grad_(False)
            self.average.load_state_dict(self.generator.state_dict())
            self.average.eval()
        terms = {"discriminator": objective.lambda_gan, "total": 1, "gan": objective.lambda_gan}
        terms |= {"l1": 1, "silog": objective.lambda_silog, "gradient": objective.lambda_gradient}
        self.terms = tuple(name for name, weight in terms.items() if weight > 0)
        self.window = torch.zeros(len(self.terms), dtype=torch.float64, device=device)
        self.progress = Progress()

    @property
    def model(self) -> UNetGenerator:
        """What is validated and saved: the average where there is one."""
        return self.generator if self.average is None else self.average

    @property
    def lr(self) -> float:
        """The learning rate."""
        return self.generator_adam.param_groups[0]["lr"]

    def set_lr(self, lr: float) -> None:
        """Set the learning rate of both networks."""
        for adam in (self.generator_adam, self.discriminator_adam):
            for group in adam.param_groups if adam else ():
                group["lr"] = lr

    def networks(self) -> Iterator[tuple[str, nn.Module, torch.optim.Adam | None]]:
        """(name, network, optimiser) of all that a checkpoint holds."""
        yield "generator", self.generator, self.generator_adam
        if self.discriminator is not None:
            yield "discriminator", self.discriminator, self.discriminator_adam
        if self.average is not None:
            yield "average", self.average, None


@torch.no_grad()
def follow(average: nn.Module, network: nn.Module, decay: float, step: int) -> None:
    """Moves an average of a network's weights a step on, in place; running statistics too.

    Args:
        average: a network of the same shape.
        network: the one that is trained.
        decay: how much of the average stays.
        step: which this is, from 1: at first less stays, so that the first weights fade.
    """
    keep = min(decay, (1 + step) / (10 + step))
    ours, theirs = average.state_dict(), network.state_dict()
    floats = [name for name, value in ours.items() if value.is_floating_point()]
    torch._foreach_lerp_([ours[n] for n in floats], [theirs[n] for n in floats], 1 - keep)
    for name in ours.keys() - set(floats):
        ours[name].copy_(theirs[name])
