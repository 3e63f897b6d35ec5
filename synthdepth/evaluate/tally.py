"""Everything that is counted of one predictor, in one pass; parts of a run merge."""

import dataclasses
import heapq
import math
from collections.abc import Iterable

import numpy as np

from synthdepth.dataset.sample import Sample
from synthdepth.evaluate.accumulate import ErrorHistogram
from synthdepth.evaluate.breakdown import Breakdown, scene_of
from synthdepth.evaluate.evaluation import Evaluation
from synthdepth.evaluate.metrics import HIGHEST_M, LOWEST_M, known_truth, usable_depth
from synthdepth.evaluate.protocols import Protocol, resized

_DEPTH_BINS = 64
# Nearest depth of the comparison, as a share of the range.
_NEAREST = 1 / 200


class DepthHistogram:
    """How often a true and a predicted depth occur together, streaming.

    Attributes:
        edges_m: (B + 1,) edges of the bins [m], equal factors apart; what lies outside is counted
            in the first or last.
        counts: (B, B) int64, true depths first.
    """

    def __init__(self, far_m: float) -> None:
        self.edges_m = np.geomspace(_NEAREST * far_m, far_m, _DEPTH_BINS + 1)
        self.counts = np.zeros((_DEPTH_BINS, _DEPTH_BINS), np.int64)

    def add(self, prediction: np.ndarray, truth: np.ndarray) -> None:
        """Count pixels; (N,) each, positive [m]."""
        t, p = (self._bins(depth) for depth in (truth, prediction))
        found = np.bincount(t * _DEPTH_BINS + p, minlength=self.counts.size)
        self.counts += found.reshape(self.counts.shape)

    def merge(self, other: "DepthHistogram") -> None:
        """Take over what another one, of the same bins, has counted."""
        if not np.array_equal(self.edges_m, other.edges_m):
            raise ValueError("histograms of different bins cannot be merged")
        self.counts += other.counts

    def _bins(self, depth: np.ndarray) -> np.ndarray:
        low, high = self.edges_m[0], self.edges_m[-1]
        place = np.log(depth / low) * (_DEPTH_BINS / math.log(high / low))
        return np.clip(place, 0, _DEPTH_BINS - 1).astype(np.intp)


@dataclasses.dataclass(frozen=True, kw_only=True, order=True)
class Picture:
    """How one picture came out, over all pixels whose depth is known.

    Attributes:
        abs_rel: mean of |p - g| / g.
        rmse: [m].
        number: of the picture in the data.
        key: its name.
    """

    abs_rel: float
    rmse: float
    number: int
    key: str


class Tally:
    """What one predictor gave.

    Args:
        protocols: at least one.
        far_m: where charts end [m].
        worst: how many of the worst pictures to remember, by AbsRel.

    Attributes:
        evaluation: the protocols.
        breakdown: ranges, classes, flights, weather. Not for what a protocol scales or crops: it
            compares metres, all pixels.
        errors: of all pixels that have a truth; likewise.
        depths: true against predicted; likewise.
    """

    def __init__(self, protocols: Iterable[Protocol], far_m: float, worst: int) -> None:
        self.evaluation = Evaluation(protocols)
        self.breakdown = Breakdown()
        self.errors = ErrorHistogram(limit_m=far_m)
        self.depths = DepthHistogram(far_m)
        self._most, self._worst = worst, []

    @property
    def worst(self) -> list[Picture]:
        """The worst pictures, worst first."""
        return sorted(self._worst, reverse=True)

    def add(self, prediction: np.ndarray, sample: Sample, number: int, truth_is: str) -> None:
        """Count a picture.

        Args:
            prediction: (h, w) [m], of any size.
            sample: with ground truth.
            number: of the picture.
            truth_is: kind of its ground truth.
        """
        self.evaluation.add(
            prediction,
            sample.depth_m,
            valid=sample.valid,
            max_depth_m=sample.max_depth_m,
            scene=scene_of(sample),
            truth_is=truth_is,
        )
        mask = known_truth(sample.depth_m, sample.valid)
        if not mask.any():
            return
        prediction = resized(prediction, sample.depth_m.shape, "edges")
        self.breakdown.add(prediction, sample)
        p = usable_depth(prediction, LOWEST_M, min(sample.max_depth_m, HIGHEST_M))
        self.errors.add(p, sample.depth_m, mask)
        p, g = p[mask], sample.depth_m[mask].astype(np.float64)
        self.depths.add(p, g)
        picture = Picture(
            abs_rel=float(np.mean(np.abs(p - g) / g)),
            rmse=math.sqrt(np.mean((p - g) ** 2)),
            number=number,
            key=sample.key,
        )
        self._remember([picture])

    def merge(self, other: "Tally") -> None:
        """Take over what another one of the same arguments has counted."""
        self.evaluation.merge(other.evaluation)
        self.breakdown.merge(other.breakdown)
        self.errors.merge(other.errors)
        self.depths.merge(other.depths)
        self._remember(other._worst)

    def _remember(self, pictures: Iterable[Picture]) -> None:
        self._worst = heapq.nlargest(self._most, [*self._worst, *pictures])
