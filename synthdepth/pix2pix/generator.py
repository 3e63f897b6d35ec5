"""The generator: a U-Net from a picture to depth in [-1, 1].

Isola et al., "Image-to-Image Translation with Conditional Adversarial Networks", CVPR 2017,
section 6.1.1: C64-C128-C256-C512-C512-C512-C512-C512 down, the mirror image up, and each encoder's
features joined to the decoder of the same size. The noise of equation 15 is dropout in the decoder.
"""

import dataclasses
from collections import OrderedDict

import torch
import torch.nn.functional as F
from torch import nn

from synthdepth.config import Config, choice, number
from synthdepth.pix2pix.layers import NORMS, Doubling, Halving, at_least_float32, has_bias

UPSAMPLINGS = ("transposed", "resize")


@dataclasses.dataclass(frozen=True, kw_only=True)
class GeneratorConfig(Config):
    """Shape of the U-Net. As it stands, it is the original's `unet_256`.

    Attributes:
        in_channels: of the picture: 3 for RGB.
        out_channels: 1 for depth.
        ngf: channels of the first layer; the deepest layers have 8 times as many.
        depth: how often the picture is halved: 8 brings 256 pixels to 1; 7 does 128, 9 does 512.
        norm: "batch" and "instance" as in the original, or "group", which no batch influences.
        dropout: share of features set to 0 in the decoder's blocks of 8 ngf channels, all but the
            innermost. It is the noise of the paper; 0 leaves it out.
        upsample: "transposed" convolutions as in the original, or "resize": nearest neighbour, then
            a 3x3 convolution, which leaves no checkerboard (Odena et al. 2016, Distill) and
            costs 2.25 times as much.
    """

    in_channels: int = number(3, 1, 64)
    out_channels: int = number(1, 1, 64)
    ngf: int = number(64, 1, 512)
    depth: int = number(8, 2, 10)
    norm: str = choice("batch", tuple(NORMS))
    dropout: float = number(0.5, 0.0, 0.9)
    upsample: str = choice("transposed", UPSAMPLINGS)

    @property
    def widths(self) -> list[int]:
        """Channels after each encoder."""
        return [self.ngf * min(2**k, 8) for k in range(self.depth)]


class UNetGenerator(nn.Module):
    """U-Net, for pictures of any size.

    A size that `2^depth` does not divide is padded on both sides to the next that it does, by
    reflection (by repeating the edge where the picture is smaller than the padding), and the output
    is cropped back: depth stays where its pixel is.
    """

    def __init__(self, config: GeneratorConfig):
        """Builds it with PyTorch's first weights; `layers.draw_weights` draws the original's."""
        super().__init__()
        self.config = config
        widths, innermost = config.widths, config.depth - 1
        self.encoders = nn.ModuleList()
        for k, width in enumerate(widths):
            before = widths[k - 1] if k > 0 else config.in_channels
            self.encoders.append(_encoder(config, before, width, plain=k in (0, innermost)))
        # Innermost first. All but the innermost read the encoder of their size as well.
        self.decoders = nn.ModuleList()
        for k in range(innermost, 0, -1):
            before = widths[k] if k == innermost else 2 * widths[k]
            noisy = k < innermost and widths[k - 1] == 8 * config.ngf
            self.decoders.append(_decoder(config, before, widths[k - 1], dropout=noisy))
        self.head = nn.Sequential(
            _upsampling(config, 2 * widths[0], config.out_channels, bias=True)
        )

    def forward(self, image: torch.Tensor) -> torch.Tensor:
        """Coded depth of a picture.

        Args:
            image: (B, in_channels, H, W), float, in [-1, 1].

        Returns:
            (B, out_channels, H, W), float32, in [-1, 1]: `target.DepthCoding` makes metres of it.
        """
        height, width = image.shape[-2:]
        top, bottom = padding_of(height, 2**self.config.depth)
        left, right = padding_of(width, 2**self.config.depth)
        # Channels last: on a CPU the convolutions are about twice as fast.
        x = image.to(self.head.conv.weight.dtype, memory_format=torch.channels_last)
        if top or bottom or left or right:
            fits = bottom < height and right < width
            x = F.pad(x, (left, right, top, bottom), mode="reflect" if fits else "replicate")

        skips = []
        for encoder in self.encoders:
            # In place though the decoders read it too: they take its ReLU, and relu(leaky_relu(x))
            # is relu(x), its gradient too.
            x = encoder(F.leaky_relu(x, 0.2, inplace=True) if skips else x)
            skips.append(x)  # (B, widths[k], H / 2^(k+1), W / 2^(k+1))

        x = F.relu(skips.pop())  # (B, 8 ngf, H / 2^depth, W / 2^depth)
        for decoder in self.decoders:
            # (B, 2 widths[k-1], H / 2^k, W / 2^k). A ReLU on each half, not on both at once: its
            # gradient is then a tensor of its own, of which a norm is ten times as fast.
            x = torch.cat([F.relu(skips.pop()), decoder(x)], dim=1)

        # float32 also under autocast: bfloat16 has steps of 0.4 m near 200 m.
        x = torch.tanh(at_least_float32(self.head(x)))  # (B, out_channels, H, W), still padded
        return x[..., top : top + height, left : left + width]


def _encoder(config: GeneratorConfig, before: int, after: int, *, plain: bool) -> nn.Sequential:
    """Halves the size: convolution and, unless plain, norm."""
    parts = OrderedDict(conv=Halving(before, after, bias=has_bias(config.norm)))
    if not plain:
        parts["norm"] = NORMS[config.norm](after)
    return nn.Sequential(parts)


def _decoder(config: GeneratorConfig, before: int, after: int, *, dropout: bool) -> nn.Sequential:
    """Doubles the size: convolution, norm, perhaps dropout, ReLU."""
    parts = _upsampling(config, before, after, bias=has_bias(config.norm))
    parts["norm"] = NORMS[config.norm](after)
    if dropout and config.dropout > 0:
        parts["dropout"] = nn.Dropout(config.dropout)
    parts["act"] = nn.ReLU(inplace=True)
    return nn.Sequential(parts)


def _upsampling(config: GeneratorConfig, before: int, after: int, *, bias: bool) -> OrderedDict:
    if config.upsample == "transposed":
        return OrderedDict(conv=Doubling(before, after, bias=bias))
    return OrderedDict(
        resize=nn.Upsample(scale_factor=2, mode="nearest"),
        conv=nn.Conv2d(before, after, 3, padding=1, bias=bias),
    )


def padding_of(size: int, multiple: int) -> tuple[int, int]:
    """Pixels to add before and after a side so that `multiple` divides it."""
    total = -size % multiple
    return total // 2, total - total // 2
