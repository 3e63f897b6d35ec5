"""Where a predictor is good and where not: metrics by range, class, flight, place and weather.

One pass over the pixels of a picture sums the terms of each range and class at once; every group is
a sum of those cells.
"""

import bisect
import dataclasses
import itertools
from collections.abc import Hashable, Iterable, Mapping

import numpy as np

from synthdepth.dataset.sample import Sample
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.accumulate import Accumulator, image_rows
from synthdepth.evaluate.boundaries import THRESHOLDS, boundary_counts
from synthdepth.evaluate.metrics import (
    HIGHEST_M,
    LOWEST_M,
    Metrics,
    known_truth,
    sum_terms,
    usable_depth,
)
from synthdepth.maps.world import LABELS

RANGE_EDGES_M = (0.0, 10.0, 25.0, 50.0, 100.0, 200.0)
ALTITUDE_EDGES_M = (0.0, 5.0, 15.0, 30.0, 60.0, 120.0)
SPEED_EDGES_MPS = (0.0, 3.0, 6.0, 10.0, 15.0, 25.0)

# What a path planner must not miss, and networks do: thin things.
THIN_CLASSES = ("wire", "pole")

AXES = ("all", "range", "class", "altitude", "speed", "map", "condition")


def band_names(edges: tuple[float, ...], unit: str) -> tuple[str, ...]:
    """Names of the bands between edges, and of what is beyond the last."""
    names = [f"{low:g}-{high:g} {unit}" for low, high in itertools.pairwise(edges)]
    return (*names, f"{edges[-1]:g} {unit} and more")


_RANGES = (*band_names(RANGE_EDGES_M, "m"), "saturated")
_CLASSES = (*LABELS, "unlabelled")
_SATURATED, _UNLABELLED = len(_RANGES) - 1, len(_CLASSES) - 1


@dataclasses.dataclass(frozen=True, kw_only=True)
class Group:
    """Pixels that are counted together.

    Attributes:
        axis: one of `AXES`.
        name: which of that axis, e.g. "10-25 m", "wire", "fog".
        saturated: whether pixels count whose depth is only known to be beyond the range.
    """

    axis: str
    name: str
    saturated: bool

    def __str__(self) -> str:
        return f"{self.axis}: {self.name}" + ("" if self.saturated else " (in range)")


def _pixel_groups() -> tuple[tuple[Group, ...], np.ndarray]:
    """Groups of pixels, and which cells (range, class) each is the sum of: (groups, cells)."""
    groups, members = [], []

    def take(axis: str, name: str, saturated: bool, ranges, classes) -> None:
        cells = np.zeros((len(_RANGES), len(_CLASSES)))
        cells[ranges, classes] = 1
        if not saturated:
            cells[_SATURATED] = 0
        groups.append(Group(axis=axis, name=name, saturated=saturated))
        members.append(cells.ravel())

    every = np.s_[:]
    for saturated in (True, False):
        take("all", "all", saturated, every, every)
        for number, name in enumerate(LABELS):
            take("class", name, saturated, every, number)
    for number, name in enumerate(_RANGES):
        take("range", name, number == _SATURATED, number, every)
    return tuple(groups), np.array(members)


_GROUPS, _MEMBERS = _pixel_groups()
_ALL = {group.saturated: k for k, group in enumerate(_GROUPS) if group.axis == "all"}


@dataclasses.dataclass(frozen=True, kw_only=True)
class GroupResult:
    """What a group gave.

    Attributes:
        group: which.
        images: means of the pictures' metrics, over pictures with a pixel of the group.
        pixels: the metrics of all its pixels at once.
        by_scene: (scenes, row) for `scene_intervals`.
    """

    group: Group
    images: Metrics
    pixels: Metrics
    by_scene: np.ndarray


class Breakdown:
    """Metrics of every group over a stream of samples; parts of a run merge.

    Predictions are clamped to the sample's range, as a depth beyond it is the truth there. Boundary
    metrics are those of whole pictures: ranges and classes have none.
    """

    def __init__(self) -> None:
        self._sums: dict[Group, Accumulator] = {}

    def add(self, prediction: np.ndarray, sample: Sample) -> None:
        """Count a picture.

        Args:
            prediction: (H, W) [m], of the sample's size.
            sample: with ground truth; `seg` and the fields of `meta` are used where they are.

        Raises:
            SynthdepthError: the prediction has another size.
        """
        truth, top = sample.depth_m, sample.max_depth_m
        if np.shape(prediction) != truth.shape:
            sizes = ["x".join(map(str, np.shape(a)[::-1])) for a in (truth, prediction)]
            raise SynthdepthError(
                f"{sample.key} has {sizes[0]} pixels, its prediction {sizes[1]}: they must be equal"
            )
        mask = known_truth(truth, sample.valid)
        saturated = truth >= top
        p = usable_depth(prediction, LOWEST_M, min(top, HIGHEST_M))
        cells = _range_numbers(truth, saturated) * len(_CLASSES) + _class_numbers(sample.seg, truth)
        sums = sum_terms(
            p[mask], truth[mask], cells[mask], _MEMBERS.shape[1], ~(prediction[mask] > 0)
        )
        edges = np.zeros((len(_GROUPS), 3, len(THRESHOLDS)))
        whole = [_ALL[True], _ALL[False]]
        edges[whole] = boundary_counts(p, truth, np.stack([mask, mask & ~saturated]))
        rows = image_rows(_MEMBERS @ sums, edges)
        scene = scene_of(sample)
        for group, row in zip(_GROUPS, rows, strict=True):
            self._count(group, row, scene)
        for axis, name in picture_groups(sample.meta):
            for with_saturated, k in _ALL.items():
                self._count(Group(axis=axis, name=name, saturated=with_saturated), rows[k], scene)

    def _count(self, group: Group, row: np.ndarray, scene: Hashable) -> None:
        # The first number counts pictures: 0 where the picture has no pixel of the group.
        if row[0]:
            self._sums.setdefault(group, Accumulator()).add(row, scene)

    def merge(self, other: "Breakdown") -> None:
        """Take over what another one has counted."""
        for group, accumulator in other._sums.items():
            self._sums.setdefault(group, Accumulator()).merge(accumulator)

    def results(self, axes: Iterable[str] = AXES) -> list[GroupResult]:
        """What each group that was met gave, axis by axis in a fixed order."""
        return [
            GroupResult(
                group=group,
                images=self._sums[group].metrics("images"),
                pixels=self._sums[group].metrics("pixels"),
                by_scene=self._sums[group].by_scene,
            )
            for group in sorted(self._sums, key=_order)
            if group.axis in axes
        ]


def scene_of(sample: Sample) -> Hashable:
    """What tells whether two samples show the same place: scene, KITTI drive, or the key itself."""
    meta = sample.meta
    if "scene_seed" in meta:
        return f"{meta.get('map', '')} {meta['scene_seed']}"
    return meta.get("drive", sample.key)


def picture_groups(meta: Mapping) -> list[tuple[str, str]]:
    """The groups (axis, name) that a whole picture belongs to, by what its metadata holds."""
    groups = [(axis, str(meta[axis])) for axis in ("map", "condition") if axis in meta]
    if "altitude_m" in meta:
        groups.append(("altitude", _band(meta["altitude_m"], ALTITUDE_EDGES_M, "m")))
    if "speed_mps" in meta:
        groups.append(("speed", _band(meta["speed_mps"], SPEED_EDGES_MPS, "m/s")))
    return groups


def _band(value: float, edges: tuple[float, ...], unit: str) -> str:
    return band_names(edges, unit)[max(bisect.bisect_right(edges, value) - 1, 0)]


def _range_numbers(truth: np.ndarray, saturated: np.ndarray) -> np.ndarray:
    number = np.zeros(truth.shape, np.intp)
    for edge in RANGE_EDGES_M[1:]:
        number += truth >= edge
    number[saturated] = _SATURATED
    return number


def _class_numbers(seg: np.ndarray | None, truth: np.ndarray) -> np.ndarray:
    if seg is None:
        return np.full(truth.shape, _UNLABELLED, np.intp)
    return np.minimum(seg, _UNLABELLED, dtype=np.intp)


def _order(group: Group) -> tuple:
    orders = {
        "range": _RANGES,
        "class": _CLASSES,
        "altitude": band_names(ALTITUDE_EDGES_M, "m"),
        "speed": band_names(SPEED_EDGES_MPS, "m/s"),
    }
    order = orders.get(group.axis, ())
    place = order.index(group.name) if group.name in order else 0
    return AXES.index(group.axis), place, group.name, not group.saturated
