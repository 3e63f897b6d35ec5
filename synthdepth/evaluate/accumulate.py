"""Averages over many pictures, streaming: memory does not grow with their number.

There are two averages and they differ: of each picture's metrics ("images", which KITTI programs
print) and of all pixels at once ("pixels"). Both come from one row of sums a picture; rows add, so
parts of a run merge in any order, and rows of a scene serve the bootstrap.
"""

import numpy as np

from synthdepth.evaluate.boundaries import THRESHOLDS, boundary_scores
from synthdepth.evaluate.metrics import METRICS, TERMS, Metrics, metrics_of_sums, record

AVERAGES = ("images", "pixels")

_NAMES = tuple(METRICS)
_EDGES = 3 * len(THRESHOLDS)
# A row: pictures; each metric's sum over pictures; in how many each is defined; the sums over
# pixels; the boundary counts.
_PARTS = np.cumsum([1, len(_NAMES), len(_NAMES), len(TERMS), _EDGES])
ROW_LENGTH = int(_PARTS[-1])


def image_rows(sums: np.ndarray, edges: np.ndarray | None = None) -> np.ndarray:
    """The row of a picture, or of each group of its pixels.

    Args:
        sums: (..., len(TERMS)), from `sum_terms`; what has no pixels gives a row of zeros.
        edges: (..., 3, len(THRESHOLDS)), from `boundary_counts`.

    Returns:
        (..., ROW_LENGTH) float64.
    """
    if edges is None:
        edges = np.zeros((*sums.shape[:-1], 3, len(THRESHOLDS)))
    values = metrics_of_sums(sums) | boundary_scores(edges)
    value = np.stack([values[name] for name in _NAMES], axis=-1)
    defined = ~np.isnan(value)
    parts = [
        sums[..., :1] > 0,
        np.where(defined, value, 0),
        defined,
        sums,
        edges.reshape(*sums.shape[:-1], _EDGES),
    ]
    return np.concatenate(parts, axis=-1)


def averages(rows: np.ndarray, average: str) -> dict[str, np.ndarray]:
    """The metrics of added-up rows.

    Args:
        rows: (..., ROW_LENGTH).
        average: one of `AVERAGES`.

    Returns:
        By name, (...) float64 each, NaN where undefined.
    """
    _, total, defined, sums, edges = np.split(rows, _PARTS[:-1], axis=-1)
    if average == "pixels":
        edges = edges.reshape(*edges.shape[:-1], 3, len(THRESHOLDS))
        return metrics_of_sums(sums) | boundary_scores(edges)
    if average != "images":
        raise ValueError(f"average {average!r}: allowed are {', '.join(AVERAGES)}")
    with np.errstate(invalid="ignore"):
        mean = total / defined
    return {name: mean[..., number] for number, name in enumerate(_NAMES)}


def average_record(row: np.ndarray, average: str) -> Metrics:
    """The `Metrics` of one added-up row (ROW_LENGTH,)."""
    sums = row[_PARTS[2] : _PARTS[3]]
    return record(averages(row, average), sums[0], sums[1], row[0])


class Accumulator:
    """Rows added up a scene, for averages and for the bootstrap.

    Attributes:
        rows: {scene: (ROW_LENGTH,)}.
    """

    def __init__(self) -> None:
        self.rows: dict[object, np.ndarray] = {}

    def add(self, row: np.ndarray, scene: object = None) -> None:
        """Count a picture.

        Args:
            row: (ROW_LENGTH,), from `image_rows`.
            scene: what the picture shows; pictures of one scene are not independent.
        """
        if scene in self.rows:
            self.rows[scene] += row
        else:
            self.rows[scene] = row.copy()

    def merge(self, other: "Accumulator") -> None:
        """Take over what another one has counted."""
        for scene, row in other.rows.items():
            self.add(row, scene)

    @property
    def by_scene(self) -> np.ndarray:
        """(scenes, ROW_LENGTH) float64, scenes in a fixed order."""
        ordered = [self.rows[scene] for scene in sorted(self.rows, key=str)]
        return np.array(ordered).reshape(-1, ROW_LENGTH)

    def metrics(self, average: str = "images") -> Metrics:
        """The averages over everything counted.

        Args:
            average: "images": the mean of the pictures' metrics, over pictures with a pixel that
                counts; "pixels": over all pixels at once.
        """
        return average_record(self.by_scene.sum(axis=0), average)


class ErrorHistogram:
    """How often each error p - g occurs (the paper's figure 14), streaming.

    Attributes:
        edges_m: (B + 1,) edges of the bins [m]; what lies outside is counted in the last ones.
        counts: (B,) int64.
    """

    def __init__(self, limit_m: float = 200.0, bins: int = 400) -> None:
        self.edges_m = np.linspace(-limit_m, limit_m, bins + 1)
        self.counts = np.zeros(bins, np.int64)

    def add(self, prediction: np.ndarray, truth: np.ndarray, mask: np.ndarray) -> None:
        """Count the pixels of a picture that are in the mask; (H, W) each, depths in metres."""
        error = np.asarray(prediction, np.float64)[mask] - truth[mask]
        place = (error - self.edges_m[0]) / (self.edges_m[1] - self.edges_m[0])
        place = np.clip(np.nan_to_num(place), 0, len(self.counts) - 1).astype(np.intp)
        self.counts += np.bincount(place, minlength=len(self.counts))

    def merge(self, other: "ErrorHistogram") -> None:
        """Take over what another one, of the same bins, has counted."""
        if not np.array_equal(self.edges_m, other.edges_m):
            raise ValueError("histograms of different bins cannot be merged")
        self.counts += other.counts
