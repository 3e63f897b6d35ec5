"""The generator as it predicts fastest: norms folded away, weights in the type they compute in."""

import copy

import torch
from torch import nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from synthdepth.pix2pix.generator import UNetGenerator


def for_inference(generator: UNetGenerator, *, dtype: torch.dtype = torch.float32) -> UNetGenerator:
    """A copy that predicts the same without batch norms or dropout, and takes no gradients.

    With running statistics a batch norm scales and shifts each channel: the convolution before it
    can do that by its weights. Norms of other kinds look at the picture and stay.

    Args:
        generator: left as it is.
        dtype: of the weights. On CPUs with AMX or AVX512-BF16 bfloat16 takes half the time, at an
            error of about 0.1 % of the range. Autocast takes longer than float32 there: it
            converts 54 million weights for each picture. The code is float32 all the same.
    """
    fast = copy.deepcopy(generator).eval().requires_grad_(False)
    for block in (*fast.encoders, *fast.decoders):
        if isinstance(getattr(block, "norm", None), nn.BatchNorm2d):
            transposed = isinstance(block.conv, nn.ConvTranspose2d)
            block.conv = fuse_conv_bn_eval(block.conv, block.norm, transpose=transposed)
            del block.norm
    return fast.to(dtype)
