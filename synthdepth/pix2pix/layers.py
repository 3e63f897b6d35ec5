"""What both networks are made of: convolutions that halve and double, norms, first weights."""

import math

import torch
import torch.nn.functional as F
from torch import nn

# "batch" and "instance" are the original's; "group" does not depend on the batch and has a scale.
NORMS = {
    "batch": lambda channels: nn.BatchNorm2d(channels),
    "instance": lambda channels: nn.InstanceNorm2d(channels),
    "group": lambda channels: nn.GroupNorm(math.gcd(32, channels), channels),
}

INITIAL_STD = 0.02

# Up to this many pixels of the smaller side a convolution on the CPU is one matrix product.
SMALL_MAP = 64


class Halving(nn.Conv2d):
    """4x4 convolution of stride 2, from (B, I, H, W) to (B, O, H/2, W/2).

    On a map of few pixels the time goes into the weights, of which oneDNN first makes a copy in an
    order of its own, and again for each gradient. A matrix product reads them as they lie.
    """

    def __init__(self, before: int, after: int, *, bias: bool):
        super().__init__(before, after, 4, stride=2, padding=1, bias=bias)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Same result as `nn.Conv2d`, up to rounding."""
        height, width = x.shape[2] // 2, x.shape[3] // 2
        if not _is_small(x, height * width):
            return super().forward(x)
        patches = F.unfold(x, 4, padding=1, stride=2).transpose(1, 2)  # (B, HW/4, 16 I)
        # In two axes, or PyTorch might repeat the weights for each picture of the batch.
        y = F.linear(patches.flatten(0, 1), self.weight.flatten(1), self.bias)  # (BHW/4, O)
        return y.unflatten(0, (-1, height, width)).permute(0, 3, 1, 2)


class Doubling(nn.ConvTranspose2d):
    """4x4 transposed convolution of stride 2, from (B, I, H, W) to (B, O, 2H, 2W).

    For small maps see `Halving`.
    """

    def __init__(self, before: int, after: int, *, bias: bool):
        super().__init__(before, after, 4, stride=2, padding=1, bias=bias)

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Same result as `nn.ConvTranspose2d`, up to rounding."""
        height, width = x.shape[2:]
        if not _is_small(x, height * width):
            return super().forward(x)
        pixels = x.permute(0, 2, 3, 1).flatten(0, 2)  # (BHW, I)
        patches = pixels @ self.weight.flatten(1)  # (BHW, 16 O)
        patches = patches.unflatten(0, (-1, height * width)).transpose(1, 2)  # (B, 16 O, HW)
        y = F.fold(patches, (2 * height, 2 * width), 4, padding=1, stride=2)
        y = y if self.bias is None else y + self.bias[:, None, None]
        return y.contiguous(memory_format=torch.channels_last)


def _is_small(x: torch.Tensor, pixels: int) -> bool:
    return pixels <= SMALL_MAP and x.device.type == "cpu" and not torch.compiler.is_exporting()


def has_bias(norm: str) -> bool:
    """Whether a convolution before this norm has a bias: not if the norm brings its own."""
    return norm == "instance"


def draw_weights(network: nn.Module, rng: torch.Generator) -> nn.Module:
    """Draws all weights anew, in place, as Isola et al. 2017 do (section 6.2).

    Convolutions from N(0, 0.02), scales of norms from N(1, 0.02), biases 0.

    Args:
        network: on the CPU.
        rng: the only source of randomness.

    Returns:
        The network.
    """
    for module in network.modules():
        if isinstance(module, nn.Conv2d | nn.ConvTranspose2d):
            nn.init.normal_(module.weight, 0.0, INITIAL_STD, generator=rng)
        elif isinstance(module, nn.BatchNorm2d | nn.GroupNorm):
            nn.init.normal_(module.weight, 1.0, INITIAL_STD, generator=rng)
        else:
            continue
        if module.bias is not None:
            nn.init.zeros_(module.bias)
    return network


def at_least_float32(x: torch.Tensor) -> torch.Tensor:
    """The tensor in float32, or in float64 if it is: what the halves of autocast end in."""
    return x.to(torch.promote_types(x.dtype, torch.float32))
