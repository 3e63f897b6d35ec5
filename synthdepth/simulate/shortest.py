"""The shortest way from start to goal that a drone fits through: what flown ways are compared with.

A* on the surveyed air finds on which side of what to pass; then the way is pulled taut against the
triangles themselves. What comes out is proven free by the test that decides collisions, so it is
never shorter than what can be flown; `shortest_way` says how much longer it may be.
"""

import heapq
import itertools
import math
from collections.abc import Callable

import numpy as np

from synthdepth.simulate.collision import Mesh
from synthdepth.simulate.survey import CELL_M, Air

_PIECE_M = 4.0  # of ways that are tested at once
_STEP = 2  # cells; the one between is looked at, too
_ROUNDS = 40
_GAIN_M = 0.01  # a round that wins less is the last one
_CUT_GAIN_M = 0.002  # likewise a cut: else corners multiply
_CUTS = 0.5 ** np.arange(9)

# Whether straight ways (n, 3) to (n, 3) are free: (n,) bool.
IsFree = Callable[[np.ndarray, np.ndarray], np.ndarray]


def free_ways(
    mesh: Mesh,
    ground_m: Callable[[np.ndarray], np.ndarray],
    altitude_m: tuple[float, float],
    radius_m: float,
) -> IsFree:
    """A test of straight ways: whether a sphere touches nothing on them and keeps to altitudes.

    Contacts are exact; altitudes are looked at every 4 m.
    """

    def is_free(start: np.ndarray, end: np.ndarray) -> np.ndarray:
        pieces = np.ceil(np.linalg.norm(end - start, axis=1) / _PIECE_M).astype(np.int64)
        pieces = np.maximum(pieces, 1)
        way = np.repeat(np.arange(len(start)), pieces)
        number = np.arange(len(way)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
        first, last = (
            start[way] + ((number + k) / pieces[way])[:, None] * (end - start)[way] for k in (0, 1)
        )
        above = last[:, 2] - ground_m(last[:, :2])
        wrong = (above < altitude_m[0] - 0.5) | (above > altitude_m[1] + 0.5)
        free = np.bincount(way[wrong], minlength=len(start)) == 0
        asked = free[way]
        share = mesh.first_contact(first[asked], last[asked], radius_m)[0]
        free[way[asked][np.isfinite(share)]] = False
        return free

    return is_free


def shortest_way(
    start_m: np.ndarray, goal_m: np.ndarray, goal_radius_m: float, air: Air, is_free: IsFree
) -> np.ndarray | None:
    """The shortest free way to a goal's circle.

    It is free for certain. It may be longer than the shortest possible one by some per cent, for
    ways through gaps that are narrower than about 4 m may be missed, and of ways on different sides
    of an obstacle whose lengths on the grid differ by less than its error (8 %) the longer one may
    be taken. Where the straight way is free it is exact.

    Args:
        start_m, goal_m: (3,) float64 [m].
        goal_radius_m: a goal is reached this near, seen from above.
        air: of the scene.
        is_free: from `free_ways`.

    Returns:
        (k, 3) float64 corners [m] from the start to the circle; None if none was found.
    """
    way = np.stack([start_m, goal_m])
    if not is_free(way[:1], way[1:])[0]:
        found = _search(start_m, goal_m, goal_radius_m, air, is_free)
        if found is None:
            return None
        # On to the middle of the circle: a way that ends anywhere on it would not be pulled taut.
        middle = np.array([[*goal_m[:2], found[-1, 2]]])
        if is_free(found[-1:], middle)[0]:
            found = np.concatenate([found, middle])
        way = _taut(found, is_free)
    return until_circle(way, goal_m, goal_radius_m)


def way_length(way: np.ndarray) -> float:
    """Length [m] of a way (k, 3)."""
    return float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())


def _search(start_m, goal_m, goal_radius_m, air: Air, is_free: IsFree) -> np.ndarray | None:
    """A free way (k, 3) through cells, by A* (P. Hart et al., IEEE SSC 4, 1968)."""
    free = bytearray(air.free.tobytes())
    shape = air.free.shape
    first = _nearest_cell(start_m, air, is_free)
    if first is None:
        return None
    x, y = (air.low_m[axis] + (np.arange(shape[axis]) + 0.5) * CELL_M for axis in (0, 1))
    dx, dy = abs(x - goal_m[0])[:, None], abs(y - goal_m[1])[None]
    # As far as steps along and across go; no step in height brings one nearer.
    left = np.maximum(dx, dy) + (math.sqrt(2) - 1) * np.minimum(dx, dy)
    left = np.maximum(left - left[np.hypot(dx, dy) <= goal_radius_m].max(initial=0), 0)
    # A trifle more, so that of many ways of the same length one is followed to its end.
    left = (left * (1 + 1e-6)).ravel().tolist()
    there = (np.hypot(dx, dy) <= goal_radius_m).ravel().tolist()
    while True:
        cells = _a_star(free, shape, first, left, there)
        if cells is None:
            return None
        found = np.stack(np.unravel_index(cells, shape), axis=-1)
        way = np.concatenate([[start_m], air.centres(found)])
        blocked = np.flatnonzero(~is_free(way[:-1], way[1:]))
        if not len(blocked):
            return way
        # The survey was too hopeful here: the cell between is taken out.
        for k in blocked.tolist():
            free[(cells[k - 1] + cells[k]) // 2] = 0


def _nearest_cell(start_m, air: Air, is_free: IsFree) -> int | None:
    """The free cell nearest to a place, of those in a straight free way of it."""
    middle = np.floor((start_m - air.low_m) / CELL_M).astype(int)
    around = middle + np.array(list(itertools.product(range(-3, 4), repeat=3)))
    around = around[((around >= 0) & (around < air.free.shape)).all(axis=1)]
    around = around[air.free[tuple(around.T)]]
    centres = air.centres(around)
    around = around[is_free(np.tile(start_m, (len(centres), 1)), centres)]
    if not len(around):
        return None
    nearest = np.linalg.norm(air.centres(around) - start_m, axis=1).argmin()
    return int(np.ravel_multi_index(around[nearest], air.free.shape))


def _a_star(free: bytearray, shape, first: int, left: list, there: list) -> list[int] | None:
    """Cells from the first to one that is there, two cells a step, in 26 directions.

    Args:
        free: whether each cell is, x slowest and z fastest.
        shape: of the grid.
        first: where to begin.
        left: a column's least distance to the goal.
        there: whether a column is the goal's.
    """
    layers = shape[2]
    moves = []
    for offset in itertools.product((-1, 0, 1), repeat=3):
        if any(offset):
            near = (offset[0] * shape[1] + offset[1]) * layers + offset[2]
            moves.append((near, _STEP * near, _STEP * CELL_M * math.hypot(*offset)))
    best, came = {first: 0.0}, {first: first}
    heap, closed = [(left[first // layers], first)], set()
    while heap:
        _, cell = heapq.heappop(heap)
        if cell in closed:
            continue
        closed.add(cell)
        if there[cell // layers]:
            way = [cell]
            while came[way[-1]] != way[-1]:
                way.append(came[way[-1]])
            return way[::-1]
        so_far = best[cell]
        for near, far, cost in moves:
            then = cell + far
            if free[then] and free[cell + near]:
                length = so_far + cost
                if length < best.get(then, math.inf):
                    best[then], came[then] = length, cell
                    heapq.heappush(heap, (length + left[then // layers], then))
    return None


def _taut(way: np.ndarray, is_free: IsFree) -> np.ndarray:
    """A way pulled tight: without needless corners, and close around those that it needs."""
    way, length = _pulled(way, is_free), math.inf
    for _ in range(_ROUNDS):
        if length - way_length(way) < _GAIN_M or len(way) < 3:
            break
        length = way_length(way)
        way = _pulled(_cut_corners(way, is_free), is_free)
    return way


def _pulled(way: np.ndarray, is_free: IsFree) -> np.ndarray:
    """From each corner straight on to the farthest that bisection finds in a free straight way."""
    kept, at, last = [0], 0, len(way) - 1
    while at < last:
        near, far = at + 1, last + 1
        if is_free(way[at : at + 1], way[last:])[0]:
            near = last
        while far - near > 1 and near < last:
            middle = (near + far) // 2
            if is_free(way[at : at + 1], way[middle : middle + 1])[0]:
                near = middle
            else:
                far = middle
        at = near
        kept.append(at)
    return way[kept]


def _cut_corners(way: np.ndarray, is_free: IsFree) -> np.ndarray:
    """Every other corner replaced by the two ends of the longest free cut across it."""
    for odd in (0, 1):
        corner = np.arange(1 + odd, len(way) - 1, 2)
        if not len(corner):
            continue
        before, after = (way[corner + side] - way[corner] for side in (-1, 1))
        start, end = (
            (way[corner] + share[..., None] * to).reshape(-1, 3)
            for share, to in ((_CUTS[:, None], before), (_CUTS[:, None], after))
        )
        free = is_free(start, end).reshape(len(_CUTS), -1)
        parts, done = [], 0
        for k, at in enumerate(corner.tolist()):
            around = np.linalg.norm([before[k], after[k], after[k] - before[k]], axis=1)
            cuts = np.flatnonzero(free[:, k] & (_CUTS * (around @ [1, 1, -1]) > _CUT_GAIN_M))
            if len(cuts):
                ends = (way[at] + _CUTS[cuts[0]] * to[k] for to in (before, after))
                parts += [way[done:at], np.stack(list(ends))]
                done = at + 1
        way = np.concatenate([*parts, way[done:]])
    return way


def until_circle(way: np.ndarray, goal_m: np.ndarray, goal_radius_m: float) -> np.ndarray:
    """A way up to where it first enters the goal's circle."""
    for k in range(len(way) - 1):
        q, d = way[k, :2] - goal_m[:2], way[k + 1, :2] - way[k, :2]
        a, b, c = float(d @ d), float(q @ d), float(q @ q) - goal_radius_m**2
        if c <= 0:
            return way[: k + 1]
        if b < 0 and b * b >= a * c and (share := c / (-b + math.sqrt(b * b - a * c))) <= 1:
            return np.concatenate([way[: k + 1], [way[k] + share * (way[k + 1] - way[k])]])
    return way
