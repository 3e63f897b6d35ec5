"""The discriminator: a PatchGAN that judges each patch of a picture with its depth.

Isola et al. 2017, section 6.1.2: C64-C128-C256-C512 and one channel of logits. With three layers a
logit sees 70x70 pixels.
"""

import dataclasses
from collections import OrderedDict

import torch
from torch import nn

from synthdepth.config import Config, choice, number
from synthdepth.pix2pix.layers import NORMS, at_least_float32, has_bias


@dataclasses.dataclass(frozen=True, kw_only=True)
class DiscriminatorConfig(Config):
    """Shape of the PatchGAN.

    Attributes:
        in_channels: of picture and depth together: 4 for RGB and depth.
        ndf: channels of the first layer.
        layers: halvings: 1, 2, 3, 4 see patches of 16, 34, 70, 142 pixels.
        norm: "batch", "instance" or "group".
    """

    in_channels: int = number(4, 2, 128)
    ndf: int = number(64, 1, 512)
    layers: int = number(3, 1, 6)
    norm: str = choice("batch", tuple(NORMS))


class PatchDiscriminator(nn.Module):
    """D(i, d) of equation 15, one logit a patch."""

    def __init__(self, config: DiscriminatorConfig):
        """Builds it with PyTorch's first weights; `layers.draw_weights` draws the original's."""
        super().__init__()
        self.config = config
        widths = [config.ndf * min(2**k, 8) for k in range(config.layers + 1)]
        # The first has no norm and thus a bias; the last keeps the size (less one pixel).
        self.blocks = nn.ModuleList([_block(config.in_channels, widths[0], stride=2, norm=None)])
        for k in range(1, config.layers + 1):
            stride = 2 if k < config.layers else 1
            self.blocks.append(_block(widths[k - 1], widths[k], stride=stride, norm=config.norm))
        self.head = nn.Conv2d(widths[-1], 1, 4, padding=1)

    def forward(self, image: torch.Tensor, depth: torch.Tensor) -> torch.Tensor:
        """Logits: positive where picture and depth look like training data.

        Args:
            image: (B, C, H, W), float, in [-1, 1], the generator's input.
            depth: (B, in_channels - C, H, W), float, in [-1, 1], true or generated.

        Returns:
            (B, 1, h, w), float32; 256x256 pixels give 30x30 logits.
        """
        x = torch.cat([image, depth], dim=1).contiguous(memory_format=torch.channels_last)
        for block in self.blocks:
            x = block(x)  # (B, ndf 2^k, H / 2^(k+1), W / 2^(k+1))
        return at_least_float32(self.head(x))


def _block(before: int, after: int, *, stride: int, norm: str | None) -> nn.Module:
    bias = norm is None or has_bias(norm)
    parts = OrderedDict(conv=nn.Conv2d(before, after, 4, stride=stride, padding=1, bias=bias))
    if norm is not None:
        parts["norm"] = NORMS[norm](after)
    parts["act"] = nn.LeakyReLU(0.2, inplace=True)
    return nn.Sequential(parts)
