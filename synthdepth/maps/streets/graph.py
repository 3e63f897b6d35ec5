"""Streets as a graph in the making: centrelines, where they meet, and what stands too near."""

import dataclasses

import numpy as np
from scipy import spatial

STEP_M = 4.0  # spacing of centreline points
JUNCTION_GAP_M = 46.0  # junctions nearer to each other than this are not built


@dataclasses.dataclass(frozen=True, kw_only=True)
class Street:
    """One street.

    Attributes:
        centreline: (n, 2) float64 [m].
        kind: "collector" or "local".
        width_m: of the carriageway, kerb to kerb.
    """

    centreline: np.ndarray
    kind: str
    width_m: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Network:
    """Streets and how they meet.

    Attributes:
        streets: the streets.
        junctions: (k, 2) [m].
        approaches: (a, 4), where a street ends on another: the junction's x, y [m], the street's
            index, and 0 or 1 for its first or last point.
        crossings: (c, 2) [m], where collectors cross.
        bulbs: (b, 3), x, y and radius [m] of the turning circles of cul-de-sacs.
    """

    streets: tuple[Street, ...]
    junctions: np.ndarray
    approaches: np.ndarray
    crossings: np.ndarray
    bulbs: np.ndarray


def resampled(line: np.ndarray, step_m: float = STEP_M) -> np.ndarray:
    """A polyline (n, 2) with points about `step_m` apart, both ends kept."""
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    t = np.linspace(0, s[-1], max(round(s[-1] / step_m), 1) + 1)
    return np.stack([np.interp(t, s, line[:, 0]), np.interp(t, s, line[:, 1])], 1)


def length_m(line: np.ndarray) -> float:
    """Length of a polyline (n, 2) [m]."""
    return float(np.linalg.norm(np.diff(line, axis=0), axis=1).sum())


def bend(rng, centre, heading, reach, heading_amplitude) -> np.ndarray:
    """A curve through `centre` whose heading swings by up to about `heading_amplitude` [rad]."""
    s = np.arange(-reach, reach, STEP_M)
    theta = np.full(len(s), heading)
    for share in (0.7, 0.45):
        wavelength = rng.uniform(560, 1200)
        theta += (
            heading_amplitude * share * np.sin(2 * np.pi * s / wavelength + rng.uniform(0, 6.3))
        )
    line = np.cumsum(np.stack([np.cos(theta), np.sin(theta)], 1) * STEP_M, axis=0)
    return line - line[len(line) // 2] + centre


class StreetGraph:
    """Collects streets; refuses what would come too near to another street or junction."""

    def __init__(self, half_m: float):
        self.half_m = half_m
        self.lines: list[np.ndarray] = []
        self.collector: list[bool] = []
        self.junctions: list[np.ndarray] = []
        self.approaches: list[tuple[float, float, int, int]] = []
        self.bulbs: list[tuple[np.ndarray, int]] = []
        self.links: list[tuple[int, int]] = []

    def add(self, line, collector=False) -> int:
        """Adds a street along a polyline (n, 2) [m]; its index."""
        self.lines.append(resampled(np.asarray(line, np.float64)))
        self.collector.append(collector)
        return len(self.lines) - 1

    def meet(self, point, street: int, end: int, other: int) -> None:
        """Records that `street` ends (0 first, 1 last point) on `other` at `point`."""
        self.junctions.append(np.asarray(point))
        self.approaches.append((point[0], point[1], street, end))
        self.links.append((street, other))

    def junction_near(self, point, gap=JUNCTION_GAP_M):
        """The nearest junction within `gap`, or None."""
        if not self.junctions:
            return None
        d = np.linalg.norm(np.asarray(self.junctions) - point, axis=1)
        return self.junctions[int(d.argmin())] if d.min() < gap else None

    def clear(self, points, gap_m, ignore=(), upto=None) -> bool:
        """Whether points (n, 2) keep `gap_m` from all streets but those ignored."""
        others = [p for i, p in enumerate(self.lines[:upto]) if i not in ignore]
        if not len(points) or not others:
            return True
        d, _ = spatial.cKDTree(np.concatenate(others)).query(points)
        return bool(d.min() > gap_m)


def join_street(net: StreetGraph, start: int, line: np.ndarray, end_on: int | None) -> bool:
    """Adds a street that leaves `start` at line[0]; refuses it near junctions and streets."""
    ignore = (start,) if end_on is None else (start, end_on)
    if net.junction_near(line[0]) is not None or not net.clear(line[9:-9], 46, ignore=ignore):
        return False
    if end_on is not None and net.junction_near(line[-1]) is not None:
        return False
    if end_on is None and not net.clear(line[-3:], 50, ignore=()):
        return False
    street = net.add(line)
    net.meet(line[0], street, 0, start)
    if end_on is not None:
        net.meet(line[-1], street, 1, end_on)
    else:
        net.bulbs.append((line[-1], street))
    return True
