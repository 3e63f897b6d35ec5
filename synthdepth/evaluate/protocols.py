"""Evaluation protocols by name: which pixels count, and what is done to a prediction first.

Published figures of one model differ by several per cent between programs that all say "KITTI,
Eigen split, 80 m". So a protocol is a record of every choice, named after the program it follows,
and every result says its own.
"""

import dataclasses
import math
from collections.abc import Iterable

import numpy as np

from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.boundaries import boundary_counts
from synthdepth.evaluate.metrics import HIGHEST_M, LOWEST_M, METRICS, sum_terms, usable_depth
from synthdepth.evaluate.prepare import (
    CROPS,
    KB_SHAPE,
    crop_slices,
    fill_background,
    kb_slices,
    median_ratio,
    resize_linear,
)

FRAMES = ("full", "kb")
RESIZES = {
    "corners": "depth, bilinear, corners aligned",
    "edges": "depth, bilinear, edges aligned",
    "disparity": "disparity, bilinear, edges aligned, then 1/x",
}
SCALINGS = ("metric", "median")

_PAPER = ("rmse", "abs_rel", "delta_1", "delta_2", "delta_3")
_SELF_SUPERVISED = ("abs_rel", "sq_rel", "rmse", "rmse_log", "delta_1", "delta_2", "delta_3")
_SUPERVISED = (*_SELF_SUPERVISED, "log10")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Protocol:
    """Every choice of an evaluation.

    Attributes:
        name: of the protocol.
        follows: whose program does it so.
        frame: what is evaluated and cropped: "full" the whole picture, "kb" the part that the
            KITTI benchmark shows, 352 rows at the bottom and 1216 columns in the middle.
        crop: one of `CROPS`, within the frame.
        truth_m: true depth that counts, between these [m].
        inclusive: whether the two ends count.
        saturated: whether pixels count whose true depth is only known to be beyond the range.
        least_pixels: pictures with fewer pixels that count are left out.
        resize: how a prediction of another size is brought to the frame's: one of `RESIZES`.
        fill: whether missing predictions are filled as KITTI's devkit does.
        scaling: "metric": none; "median": each picture's median to the truth's, before the clamp.
        clamp_m: what predictions are clamped to [m]; None: not at all (what is no depth is made
            one, or logarithms would not exist); inf as its upper end: the truth's range.
        flip_averaged: whether its authors average each prediction with the mirrored picture's. To
            do so is for whoever predicts.
        truth: ground truth it is for: "dense", or the `depth` of KITTI's reader.
        metrics: which it prints, of `METRICS`.
    """

    name: str
    follows: str
    frame: str = "full"
    crop: str = "none"
    truth_m: tuple[float, float] = (0.0, math.inf)
    inclusive: bool = False
    saturated: bool = True
    least_pixels: int = 1
    resize: str = "edges"
    fill: bool = False
    scaling: str = "metric"
    clamp_m: tuple[float, float] | None = None
    flip_averaged: bool = False
    truth: str = "groundtruth"
    metrics: tuple[str, ...] = _SUPERVISED

    def __post_init__(self):
        for what, value, allowed in (
            ("frame", self.frame, FRAMES),
            ("crop", self.crop, CROPS),
            ("resize", self.resize, RESIZES),
            ("scaling", self.scaling, SCALINGS),
            *(("metric", name, METRICS) for name in self.metrics),
        ):
            if value not in allowed:
                raise SynthdepthError(f"{what} {value!r}: allowed are {', '.join(allowed)}")

    def __str__(self) -> str:
        """All of it on one line."""
        low, high = self.truth_m
        sign = "<=" if self.inclusive else "<"
        below = "" if math.isinf(high) else f" {sign} {high:g} m"
        frame = "full picture" if self.frame == "full" else "benchmark frame 1216x352"
        clamp = "not clamped"
        if self.clamp_m is not None:
            least, most = self.clamp_m
            most = "the truth's range" if math.isinf(most) else f"{most:g} m"
            clamp = f"clamped to {least:g} ... {most}"
        return ", ".join(
            [
                f"{self.name}: {frame}",
                "no crop" if self.crop == "none" else f"{self.crop.capitalize()} crop",
                f"{low:g} {sign} truth{below}",
                *(["without saturated pixels"] if not self.saturated else []),
                *([f"at least {self.least_pixels} pixels"] if self.least_pixels > 1 else []),
                f"resized as {RESIZES[self.resize]}",
                *(["missing predictions filled"] if self.fill else []),
                "scaled by medians" if self.scaling == "median" else "metric",
                clamp,
                f"truth {self.truth}",
                f"follows {self.follows}",
            ]
        )


_80 = {"truth_m": (1e-3, 80.0), "clamp_m": (1e-3, 80.0)}

PROTOCOLS: dict[str, Protocol] = {
    protocol.name: protocol
    for protocol in (
        Protocol(
            name="synthdepth",
            follows="this project: every pixel, saturated ones too",
            clamp_m=(LOWEST_M, math.inf),
            truth="dense",
            metrics=tuple(METRICS),
        ),
        Protocol(
            name="synthdepth-in-range",
            follows="this project: what is nearer than the range",
            saturated=False,
            clamp_m=(LOWEST_M, math.inf),
            truth="dense",
            metrics=tuple(METRICS),
        ),
        Protocol(
            name="paper",
            follows="equations 19-21 over all pixels; the paper states no cap and no crop",
            clamp_m=(LOWEST_M, math.inf),
            truth="dense",
            metrics=_PAPER,
        ),
        Protocol(
            name="eigen-garg-full-80",
            follows="BTS",
            crop="garg",
            metrics=(*_SUPERVISED, "silog_eigen"),
            resize="corners",
            **_80,
        ),
        Protocol(
            name="eigen-garg-kb-80",
            follows="AdaBins, ZoeDepth",
            frame="kb",
            crop="garg",
            metrics=(*_SUPERVISED, "silog_eigen"),
            resize="corners",
            flip_averaged=True,
            **_80,
        ),
        Protocol(
            name="eigen-crop-80",
            follows="BTS with --eigen_crop",
            crop="eigen",
            metrics=(*_SUPERVISED, "silog_eigen"),
            resize="corners",
            **_80,
        ),
        Protocol(
            name="benchmark",
            follows="KITTI's devkit for depth prediction",
            fill=True,
            metrics=("silog_devkit", "sq_rel_devkit", "abs_rel", "irmse", "rmse", "mae"),
        ),
        Protocol(
            name="monodepth2-eigen",
            follows="monodepth2, eval_split eigen",
            crop="garg",
            resize="disparity",
            scaling="median",
            truth="lidar velodyne_x",
            metrics=_SELF_SUPERVISED,
            **_80,
        ),
        Protocol(
            name="monodepth2-benchmark",
            follows="monodepth2, eval_split eigen_benchmark",
            clamp_m=(1e-3, 80.0),
            resize="disparity",
            scaling="median",
            metrics=_SELF_SUPERVISED,
        ),
        Protocol(
            name="depth-anything-80",
            follows="Depth Anything V2, metric_depth",
            truth_m=(1e-3, 80.0),
            inclusive=True,
            least_pixels=10,
            resize="corners",
            metrics=(*_SUPERVISED, "silog_half"),
        ),
        Protocol(
            name="unidepth",
            follows="UniDepth, KITTI with crop garg",
            frame="kb",
            crop="garg",
            truth_m=(0.0, 80.0),
            metrics=(*_SUPERVISED, "silog_unidepth"),
        ),
    )
}


def find_protocol(name: str) -> Protocol:
    """The protocol of a name; `name/median` and `name/metric` scale otherwise than it does.

    Raises:
        SynthdepthError: there is none of that name.
    """
    base, _, scaling = name.partition("/")
    if base not in PROTOCOLS or scaling not in ("", *SCALINGS):
        raise SynthdepthError(
            f"protocol {name!r}: allowed are {', '.join(PROTOCOLS)}, each also with /metric or "
            "/median behind it"
        )
    return with_scaling(PROTOCOLS[base], scaling) if scaling else PROTOCOLS[base]


def with_scaling(protocol: Protocol, scaling: str) -> Protocol:
    """A protocol with another scaling, which its name then says."""
    if scaling == protocol.scaling:
        return protocol
    base = protocol.name.partition("/")[0]
    return dataclasses.replace(protocol, scaling=scaling, name=f"{base}/{scaling}")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Compared:
    """The pixels of one picture that a protocol compares.

    Attributes:
        prediction: (H, W) float64 [m] in the protocol's frame, scaled and clamped.
        truth: (H, W) [m] in that frame.
        mask: (H, W) bool, which pixels count.
        unusable: (H, W) bool, where the prediction was no depth.
        ratio: what the prediction was multiplied by.
    """

    prediction: np.ndarray
    truth: np.ndarray
    mask: np.ndarray
    unusable: np.ndarray
    ratio: float

    def sums(self) -> np.ndarray:
        """The sums of the terms over the pixels that count, (len(TERMS),)."""
        arrays = (self.prediction, self.truth, self.unusable)
        p, g, unusable = (array[self.mask] for array in arrays)
        return sum_terms(p, g, unusable=unusable)[0]

    def edges(self) -> np.ndarray:
        """The boundary counts, (3, thresholds)."""
        return boundary_counts(self.prediction, self.truth, self.mask)


def compare(
    protocol: Protocol,
    prediction: np.ndarray,
    truth: np.ndarray,
    *,
    valid: np.ndarray | None = None,
    max_depth_m: float = math.inf,
    shows: str = "full",
) -> Compared:
    """Bring one prediction and its truth to where a protocol compares them.

    Args:
        protocol: which.
        prediction: (h, w) [m]; of any size: it is resized to what it shows.
        truth: (H, W) [m] of the whole picture; zeros, NaN and infinities are no ground truth.
        valid: (H, W) bool, where the truth is known.
        max_depth_m: where the truth saturates.
        shows: what the prediction is of: "full", or "kb" if the network was given the benchmark's
            part only. Such a one is pasted into the full frame; around it nothing is predicted.

    Raises:
        SynthdepthError: the prediction is no image, or the truth is smaller than the frame.
    """
    if np.ndim(prediction) != 2 or 0 in np.shape(prediction):
        raise SynthdepthError(
            f"a prediction of shape {np.shape(prediction)}: allowed is (height, width)"
        )
    if shows not in FRAMES:
        raise SynthdepthError(f"shows {shows!r}: allowed are {', '.join(FRAMES)}")
    if shows == "kb":
        part = resized(prediction, KB_SHAPE, protocol.resize)
        prediction = np.full(truth.shape, np.nan)
        prediction[kb_slices(truth.shape)] = part
    else:
        prediction = resized(prediction, truth.shape, protocol.resize)
    if protocol.frame == "kb":
        part = kb_slices(truth.shape)
        prediction, truth = prediction[part], truth[part]
        valid = None if valid is None else valid[part]
    mask = _mask(protocol, truth, valid, max_depth_m)
    if protocol.fill:
        prediction = fill_background(prediction)
    unusable = ~(prediction > 0)
    ratio = 1.0
    if protocol.scaling == "median" and mask.any():
        ratio = median_ratio(prediction[mask], truth[mask])
    low, high = protocol.clamp_m or (LOWEST_M, HIGHEST_M)
    if math.isinf(high):
        high = max_depth_m if math.isfinite(max_depth_m) else HIGHEST_M
    return Compared(
        prediction=usable_depth(prediction * ratio, low, high),
        truth=truth,
        mask=mask,
        unusable=unusable,
        ratio=ratio,
    )


def resized(prediction: np.ndarray, shape: tuple[int, int], resize: str) -> np.ndarray:
    """A prediction (h, w) [m] brought to (H, W) in one of the ways of `RESIZES`; float64."""
    if prediction.shape == tuple(shape):
        return np.asarray(prediction, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        if resize == "disparity":
            disparity = 1 / np.asarray(prediction, np.float64)
            return 1 / resize_linear(disparity, shape, corners=False)
        return resize_linear(prediction, shape, corners=resize == "corners")


def _mask(protocol, truth, valid, max_depth_m) -> np.ndarray:
    low, high = protocol.truth_m
    known = (truth > 0) & (truth < math.inf)
    if protocol.inclusive:
        known &= (truth >= low) & (truth <= high)
    else:
        known &= (truth > low) & (truth < high)
    if not protocol.saturated:
        known &= truth < max_depth_m
    if valid is not None:
        known &= valid
    mask = np.zeros(truth.shape, bool)
    crop = crop_slices(truth.shape, protocol.crop)
    mask[crop] = known[crop]
    return mask


def find_protocols(names: Iterable[str]) -> list[Protocol]:
    """The protocols of several names, each once."""
    return list(dict.fromkeys(find_protocol(name) for name in names))
