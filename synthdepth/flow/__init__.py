"""Optical flow between frame t and t-1, and its embedding into the picture a network is given."""

from synthdepth.flow.dense_lucas_kanade import DenseLucasKanade
from synthdepth.flow.dis import Dis
from synthdepth.flow.embed import (
    INTERVALS,
    PX_AT_WHITE,
    embed,
    flow_channels,
    flow_image,
    flow_luminance,
    heat_map,
)
from synthdepth.flow.farneback import Farneback
from synthdepth.flow.lucas_kanade import LucasKanade
from synthdepth.flow.methods import METHODS, estimate_flow
from synthdepth.flow.truth import end_point_error, flow_from_depth

__all__ = [
    "INTERVALS",
    "METHODS",
    "PX_AT_WHITE",
    "DenseLucasKanade",
    "Dis",
    "Farneback",
    "LucasKanade",
    "embed",
    "end_point_error",
    "estimate_flow",
    "flow_channels",
    "flow_from_depth",
    "flow_image",
    "flow_luminance",
    "heat_map",
]
