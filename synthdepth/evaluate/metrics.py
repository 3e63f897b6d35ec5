"""Depth metrics, all from one pass over the pixels.

Every metric is a function of sums of a few terms a pixel. Sums add: over pixels, groups of pixels,
images and machines; so one pass serves every metric, every breakdown and every average.

Symbols as in the literature: p predicted depth, g true depth, d = p - g, e = ln p - ln g. Names of
variants follow the programs that print them.
"""

import dataclasses
import math

import numpy as np

from synthdepth.evaluate.boundaries import boundary_counts, boundary_scores

# A depth that is no depth (NaN, zero, negative, infinite) counts as one of these [m], as BTS and
# ZoeDepth have it: NaN as the lowest, what is too far as the highest.
LOWEST_M, HIGHEST_M = 1e-3, 1e6

# What is added up over pixels.
TERMS = (
    "pixels",
    "unusable",  # predictions that are no depth at all: NaN, zero, negative
    "truth",  # g
    "error",  # d
    "abs_error",  # |d|
    "sq_error",  # d^2
    "abs_rel",  # |d| / g
    "sq_rel",  # d^2 / g
    "sq_rel_devkit",  # d^2 / g^2
    "log_error",  # e
    "abs_log_error",  # |e|
    "sq_log_error",  # e^2
    "sq_inverse_error",  # (1/p - 1/g)^2
    "delta_1",  # max(p/g, g/p) < 1.25
    "delta_2",
    "delta_3",
)
# Pixels computed at once: so few that what is between stays in the processor's cache.
_AT_ONCE = 8192
_TERM = {name: number for number, name in enumerate(TERMS)}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Metric:
    """What a metric is: for tables.

    Attributes:
        unit: "" where it has none.
        better: "lower", "higher", or "" where it only describes.
        formula: in the symbols of this module; E is the mean over pixels.
    """

    unit: str
    better: str
    formula: str


METRICS = {
    "mean_truth": Metric(unit="m", better="", formula="E[g]"),
    "bias": Metric(unit="m", better="", formula="E[d]"),
    "mae": Metric(unit="m", better="lower", formula="E|d|"),
    "rmse": Metric(unit="m", better="lower", formula="sqrt(E[d^2]), equation 19"),
    "abs_rel": Metric(unit="", better="lower", formula="E[|d| / g], equation 20"),
    "sq_rel": Metric(unit="m", better="lower", formula="E[d^2 / g], as most programs"),
    "sq_rel_devkit": Metric(unit="", better="lower", formula="E[d^2 / g^2], as KITTI's devkit"),
    "rmse_log": Metric(unit="", better="lower", formula="sqrt(E[e^2])"),
    "silog_eigen": Metric(
        unit="", better="lower", formula="100 sqrt(E[e^2] - E[e]^2), as BTS, AdaBins, ZoeDepth"
    ),
    "silog_devkit": Metric(
        unit="", better="lower", formula="sqrt(E[e^2] - E[e]^2), as KITTI's devkit"
    ),
    "silog_half": Metric(
        unit="", better="lower", formula="sqrt(E[e^2] - 0.5 E[e]^2), as Depth Anything V2"
    ),
    "silog_unidepth": Metric(unit="", better="lower", formula="100 std(e) over N - 1, as UniDepth"),
    "log10": Metric(unit="", better="lower", formula="E|log10 p - log10 g|"),
    "irmse": Metric(unit="1/km", better="lower", formula="1000 sqrt(E[(1/p - 1/g)^2])"),
    "delta_1": Metric(
        unit="", better="higher", formula="share of max(p/g, g/p) < 1.25, equation 21"
    ),
    "delta_2": Metric(unit="", better="higher", formula="... < 1.25^2"),
    "delta_3": Metric(unit="", better="higher", formula="... < 1.25^3"),
    "boundary_precision": Metric(
        unit="", better="higher", formula="share of the predicted depth edges that are there"
    ),
    "boundary_recall": Metric(
        unit="", better="higher", formula="share of the depth edges that are predicted"
    ),
    "boundary_f1": Metric(unit="", better="higher", formula="harmonic mean of the two"),
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Metrics:
    """Every metric of a picture, or averaged over many; None where it is undefined.

    With no pixel at all every metric is None. `silog_unidepth` needs two pixels, the boundary
    metrics a picture with a depth edge. Units are in `METRICS`.

    Attributes:
        pixels: how many counted.
        unusable: of them, whose prediction is no depth (NaN, zero or negative).
        images: how many pictures had a pixel that counts.
    """

    pixels: int = 0
    unusable: int = 0
    images: int = 0
    mean_truth: float | None = None
    bias: float | None = None
    mae: float | None = None
    rmse: float | None = None
    abs_rel: float | None = None
    sq_rel: float | None = None
    sq_rel_devkit: float | None = None
    rmse_log: float | None = None
    silog_eigen: float | None = None
    silog_devkit: float | None = None
    silog_half: float | None = None
    silog_unidepth: float | None = None
    log10: float | None = None
    irmse: float | None = None
    delta_1: float | None = None
    delta_2: float | None = None
    delta_3: float | None = None
    boundary_precision: float | None = None
    boundary_recall: float | None = None
    boundary_f1: float | None = None


def usable_depth(
    prediction: np.ndarray, lowest_m: float = LOWEST_M, highest_m: float = HIGHEST_M
) -> np.ndarray:
    """Predicted depth made finite and positive: clamped, with NaN at the lowest.

    Args:
        prediction: any shape [m], any values.
        lowest_m: smallest depth that is returned.
        highest_m: largest; what is infinite becomes this.

    Returns:
        float64, the same shape.
    """
    clamped = np.clip(np.asarray(prediction, np.float64), lowest_m, highest_m)
    clamped[np.isnan(clamped)] = lowest_m
    return clamped


def known_truth(truth: np.ndarray, mask: np.ndarray | None = None) -> np.ndarray:
    """Where there is a true depth to compare with: finite, positive and in the mask; bool."""
    known = (truth > 0) & (truth < np.inf)
    return known if mask is None else known & mask


def sum_terms(
    prediction: np.ndarray,
    truth: np.ndarray,
    groups: np.ndarray | None = None,
    group_count: int = 1,
    unusable: np.ndarray | None = None,
) -> np.ndarray:
    """The sums over pixels of every term.

    Args:
        prediction: (N,) [m], finite and positive: from `usable_depth`.
        truth: (N,) [m], finite and positive.
        groups: (N,) whole numbers below `group_count`: which group each pixel belongs to.
        group_count: number of groups.
        unusable: (N,) bool, which predictions were no depth before they were made one.

    Returns:
        (group_count, len(TERMS)) float64.
    """
    if groups is None:
        groups = np.zeros(len(truth), np.uint8)
    else:
        # Sorting once and adding up runs is faster than a bincount a term.
        small = np.asarray(groups, np.uint8 if group_count <= 256 else np.int32)
        order = np.argsort(small, kind="stable")
        prediction, truth, groups = prediction[order], truth[order], small[order]
        unusable = None if unusable is None else unusable[order]
    sums = np.zeros((group_count, len(TERMS)))
    for start in range(0, len(truth), _AT_ONCE):
        part = np.s_[start : start + _AT_ONCE]
        bad = None if unusable is None else unusable[part]
        _add_sorted(sums, prediction[part], truth[part], groups[part], bad)
    return sums


def _add_sorted(sums, prediction, truth, groups, unusable) -> None:
    """Add the terms of pixels that are sorted by their group."""
    starts = np.flatnonzero(np.diff(groups, prepend=~groups[:1]))
    present = groups[starts]
    p, g = np.asarray(prediction, np.float64), np.asarray(truth, np.float64)

    def add(name: str, term: np.ndarray) -> None:
        sums[present, _TERM[name]] += np.add.reduceat(term, starts, dtype=np.float64)

    d, ratio = p - g, p / g
    abs_d, e = np.abs(d), np.log(ratio)
    rel = abs_d / g
    inverse = rel / p  # |1/p - 1/g|
    worse = np.maximum(ratio, g / p)
    sums[present, _TERM["pixels"]] += np.diff(starts, append=len(g))
    if unusable is not None:
        add("unusable", unusable)
    add("truth", g)
    add("error", d)
    add("abs_error", abs_d)
    add("sq_error", d * d)
    add("abs_rel", rel)
    add("sq_rel", rel * abs_d)
    add("sq_rel_devkit", rel * rel)
    add("log_error", e)
    add("abs_log_error", np.abs(e))
    add("sq_log_error", e * e)
    add("sq_inverse_error", inverse * inverse)
    for n in (1, 2, 3):
        add(f"delta_{n}", worse < 1.25**n)


def metrics_of_sums(sums: np.ndarray) -> dict[str, np.ndarray]:
    """The metrics of sums of terms.

    Args:
        sums: (..., len(TERMS)).

    Returns:
        By name, (...) float64 each, NaN where undefined. The boundary metrics are not among them:
        they come from pairs of pixels.
    """
    n = sums[..., 0]
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = {name: sums[..., k] / n for name, k in _TERM.items()}
        sq_log, log = mean["sq_log_error"], mean["log_error"]
        # Rounding can push a variance of nothing below zero.
        variance = np.maximum(sq_log - log**2, 0)
        return {
            "mean_truth": mean["truth"],
            "bias": mean["error"],
            "mae": mean["abs_error"],
            "rmse": np.sqrt(mean["sq_error"]),
            "abs_rel": mean["abs_rel"],
            "sq_rel": mean["sq_rel"],
            "sq_rel_devkit": mean["sq_rel_devkit"],
            "rmse_log": np.sqrt(sq_log),
            "silog_eigen": 100 * np.sqrt(variance),
            "silog_devkit": np.sqrt(variance),
            "silog_half": np.sqrt(np.maximum(sq_log - 0.5 * log**2, 0)),
            "silog_unidepth": 100 * np.sqrt(variance * n / np.where(n > 1, n - 1, np.nan)),
            "log10": mean["abs_log_error"] / math.log(10),
            "irmse": 1000 * np.sqrt(mean["sq_inverse_error"]),
            "delta_1": mean["delta_1"],
            "delta_2": mean["delta_2"],
            "delta_3": mean["delta_3"],
        }


def record(values: dict[str, float], pixels: float, unusable: float, images: float) -> Metrics:
    """The `Metrics` of values by name, NaN or missing where undefined."""
    known = {name: float(value) for name, value in values.items() if not math.isnan(value)}
    return Metrics(pixels=int(pixels), unusable=int(unusable), images=int(images), **known)


def compute_metrics(
    prediction: np.ndarray,
    truth: np.ndarray,
    *,
    mask: np.ndarray | None = None,
    crop: tuple[slice, slice] | None = None,
    truth_within_m: tuple[float, float] = (0.0, math.inf),
    clamp_m: tuple[float, float] = (LOWEST_M, HIGHEST_M),
) -> Metrics:
    """Every metric of one picture.

    Args:
        prediction: (H, W) [m].
        truth: (H, W) [m]; zeros, NaN and infinities are pixels without ground truth.
        mask: (H, W) bool, which pixels count; all by default.
        crop: rows and columns that count.
        truth_within_m: only pixels whose true depth lies within, both ends included.
        clamp_m: what predictions are clamped to.
    """
    counts = known_truth(truth, mask)
    low, high = truth_within_m
    counts &= (truth >= low) & (truth <= high)
    if crop is not None:
        outside = np.ones(counts.shape, bool)
        outside[crop] = False
        counts &= ~outside
    p = usable_depth(prediction, *clamp_m)
    bad = ~(np.asarray(prediction) > 0)
    sums = sum_terms(p[counts], truth[counts], unusable=bad[counts])[0]
    values = metrics_of_sums(sums) | boundary_scores(boundary_counts(p, truth, counts))
    return record(values, sums[0], sums[1], min(sums[0], 1))
