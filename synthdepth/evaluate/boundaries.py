"""Boundary error: are the depth edges where they should be, and no others?

The scale-invariant boundary F1 of Depth Pro (Bochkovskii et al. 2024, section 3.2): between two
neighbours there is an occluding edge if one is more than t times as far as the other. Precision and
recall compare predicted with true edges, side by side and direction by direction, for ten t from
1.05 to 1.25, and their average weights each t by itself. Needs dense truth.

Theirs averages the four directions' ratios; here the directions' counts are added first. A perfect
prediction then has 1 in every picture with an edge, and counts of pictures add up.
"""

import numpy as np

THRESHOLDS = np.linspace(1.05, 1.25, 10)
_LEVELS = np.log(THRESHOLDS)


def boundary_counts(
    prediction: np.ndarray, truth: np.ndarray, masks: np.ndarray | None = None
) -> np.ndarray:
    """How many edges are matched, predicted and true at each threshold.

    Args:
        prediction: (H, W) [m], finite and positive.
        truth: (H, W) [m], finite and positive where a mask is set.
        masks: (H, W) bool, or several of them (M, H, W); an edge counts if both its pixels do.

    Returns:
        (3, len(THRESHOLDS)) float64, or as many of these as masks.
    """
    masks = np.ones(truth.shape, bool) if masks is None else masks
    each = masks.reshape(-1, *truth.shape)
    log_p = np.log(prediction, dtype=np.float32)
    log_g = np.log(np.where(each.any(axis=0), truth, 1), dtype=np.float32)
    counts = np.zeros((len(each), 3, len(THRESHOLDS)))
    for near, far in ((np.s_[:, :-1], np.s_[:, 1:]), (np.s_[:-1], np.s_[1:])):
        # The logarithm of how many times as far one neighbour is; signed, as direction counts.
        step_p, step_g = log_p[far] - log_p[near], log_g[far] - log_g[near]
        edge = np.maximum(np.abs(step_p), np.abs(step_g)) > _LEVELS[0]
        step_p, step_g = step_p[edge], step_g[edge]
        size_p, size_g = np.abs(step_p), np.abs(step_g)
        matched = np.where(step_p * step_g > 0, np.minimum(size_p, size_g), 0)
        for mask, count in zip(each, counts, strict=True):
            both = mask[near][edge] & mask[far][edge]
            for row, size in enumerate((matched, size_p, size_g)):
                count[row] += _count_above(size[both])
    return counts.reshape(*masks.shape[:-2], *counts.shape[1:])


def _count_above(size: np.ndarray) -> np.ndarray:
    """How many values exceed each level."""
    passed = np.searchsorted(_LEVELS, size[size > _LEVELS[0]], side="left")
    histogram = np.bincount(passed, minlength=len(_LEVELS) + 1)
    return histogram[::-1].cumsum()[::-1][1:]


def boundary_scores(counts: np.ndarray) -> dict[str, np.ndarray]:
    """Precision, recall and F1 of counts, averaged over the thresholds.

    Args:
        counts: (..., 3, len(THRESHOLDS)).

    Returns:
        By name, (...) float64 each; NaN where no edge is there, and for precision where none is
        predicted.
    """
    matched, predicted, true = np.moveaxis(counts, -2, 0)
    return {
        "boundary_precision": _mean(matched, predicted),
        "boundary_recall": _mean(matched, true),
        "boundary_f1": np.where(true[..., 0] > 0, _mean(2 * matched, predicted + true), np.nan),
    }


def _mean(above: np.ndarray, below: np.ndarray) -> np.ndarray:
    """Mean of the ratios over the thresholds, each weighted by its threshold, where they exist."""
    exists = below > 0
    ratio = np.divide(above, below, out=np.zeros(above.shape), where=exists)
    weight = (exists * THRESHOLDS).sum(axis=-1)
    with np.errstate(invalid="ignore"):
        return (ratio * THRESHOLDS).sum(axis=-1) / weight
