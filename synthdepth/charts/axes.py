"""Axes with round numbers."""

import dataclasses
import math

import numpy as np


@dataclasses.dataclass(frozen=True, kw_only=True)
class Axis:
    """A linear or logarithmic axis with bins that begin and end on round numbers.

    Attributes:
        edges: of the bins, ascending.
        ticks: round values within the edges.
        log: whether equal factors are equally wide.
    """

    edges: np.ndarray
    ticks: tuple[float, ...]
    log: bool

    def place(self, value: float) -> float:
        """Where a value lies, 0 at the first edge and 1 at the last."""
        low, high = self.edges[0], self.edges[-1]
        if self.log:
            low, high, value = math.log(low), math.log(high), math.log(value)
        return (value - low) / (high - low)


def linear_axis(values: np.ndarray, bins: int = 24) -> Axis:
    """An axis from a round number below all values to one above, with about `bins` bins."""
    low, high = float(np.min(values)), float(np.max(values))
    step = round_step((high - low) / bins or 1.0)
    first, last = math.floor(low / step), max(math.ceil(high / step), math.floor(low / step) + 1)
    edges = step * np.arange(first, last + 1)
    wide = round_step((edges[-1] - edges[0]) / 5)
    ticks = wide * np.arange(math.ceil(edges[0] / wide - 1e-9), edges[-1] / wide + 1e-9)
    return Axis(edges=edges, ticks=tuple(float(t) for t in ticks), log=False)


def log_axis(low: float, high: float, bins: int = 36) -> Axis:
    """An axis of equal factors from `low` to `high`, both above 0."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    round_ones = [m * 10.0**d for d in decades for m in (1, 2, 5)]
    ticks = tuple(t for t in round_ones if low * 0.999 <= t <= high * 1.001)
    return Axis(edges=np.geomspace(low, high, bins + 1), ticks=ticks, log=True)


def round_step(least: float) -> float:
    """The next of ... 0.1 0.2 0.5 1 2 5 10 ... that is not below `least`."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(m * power for m in (1, 2, 5, 10) if m * power >= least * (1 - 1e-9))


def number_text(value: float) -> str:
    """A quantity to three digits, or to whole units where they are more."""
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"
