"""Confidence intervals: how much the averages depend on the scenes that happened to be drawn.

Pictures of one scene are alike, so scenes are drawn again, with replacement, not pictures (cluster
bootstrap; Davison and Hinkley 1997, section 3.8; percentile intervals). With few scenes the
intervals are too narrow.
"""

import dataclasses

import numpy as np

from synthdepth.evaluate.accumulate import averages


@dataclasses.dataclass(frozen=True, kw_only=True)
class Interval:
    """A value and where it lies with the asked confidence.

    Attributes:
        value: over all scenes; None where undefined.
        low, high: ends of the interval; None with fewer than two scenes.
    """

    value: float | None
    low: float | None
    high: float | None


def scene_intervals(
    rng: np.random.Generator,
    by_scene: np.ndarray,
    *,
    average: str = "images",
    level: float = 0.95,
    draws: int = 2000,
) -> dict[str, Interval]:
    """Intervals of every metric.

    Args:
        rng: a lane, e.g. `lane(seed, "bootstrap")`.
        by_scene: (scenes, ROW_LENGTH), from `Accumulator.by_scene`.
        average: one of `AVERAGES`.
        level: of confidence.
        draws: how often the scenes are drawn again.
    """
    weights = _weights(rng, len(by_scene), draws)
    return _intervals(
        averages(by_scene.sum(axis=0), average), averages(weights @ by_scene, average), level
    )


def difference_intervals(
    rng: np.random.Generator,
    ours: np.ndarray,
    theirs: np.ndarray,
    *,
    average: str = "images",
    level: float = 0.95,
    draws: int = 2000,
) -> dict[str, Interval]:
    """Intervals of the difference of two predictors over the same scenes, drawn together.

    A difference whose interval leaves out 0 is one that these scenes can tell.

    Args:
        rng: a lane.
        ours, theirs: (scenes, ROW_LENGTH) each, of the same scenes in the same order.
        average, level, draws: as in `scene_intervals`.
    """
    if ours.shape != theirs.shape:
        raise ValueError(f"{len(ours)} scenes against {len(theirs)}: they must be the same")
    weights = _weights(rng, len(ours), draws)

    def differences(weight: np.ndarray) -> dict[str, np.ndarray]:
        one, other = averages(weight @ ours, average), averages(weight @ theirs, average)
        return {name: one[name] - other[name] for name in one}

    return _intervals(differences(np.ones(len(ours))), differences(weights), level)


def _weights(rng: np.random.Generator, scenes: int, draws: int) -> np.ndarray:
    """How often each draw takes each scene: (draws, scenes)."""
    if scenes < 2:
        return np.ones((0, scenes))
    return rng.multinomial(scenes, np.full(scenes, 1 / scenes), size=draws).astype(np.float64)


def _intervals(values, drawn, level) -> dict[str, Interval]:
    tails = [(1 - level) / 2, (1 + level) / 2]
    intervals = {}
    for name, value in values.items():
        known = drawn[name][~np.isnan(drawn[name])]
        low, high = np.quantile(known, tails).tolist() if len(known) else (None, None)
        value = None if np.isnan(value) else float(value)
        intervals[name] = Interval(value=value, low=low, high=high)
    return intervals
