"""Where to go: the remaining cost to a goal from everywhere, over a grid at cruise altitude.

A planner that sees only the next seconds is caught by courtyards and cul-de-sacs. The cost to go
leads it around them, along a way that keeps about the preferred clearance.
"""

import numpy as np
from scipy.ndimage import map_coordinates
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from synthdepth.flight.clearance import Clearance

_CELL_M = 2.5
_MOST_CELLS = 50_000  # larger grids get larger cells
_AROUND_M = 60.0  # how far the grid goes beyond start and goal
_BLOCKED = 30.0  # cost of a metre without room: finite, so that every cell knows a way out
# Half of the 16 neighbours; the other half by symmetry. Eight alone would bend routes to 45 deg.
_NEIGHBOURS = ((1, 0), (0, 1), (1, 1), (1, -1), (2, 1), (1, 2), (2, -1), (1, -2))


def shortfall(clearance_m: np.ndarray, preferred_m: float) -> np.ndarray:
    """How much of the preferred clearance is missing, 0 to 1."""
    return np.clip(1 - clearance_m / preferred_m, 0.0, 1.0)


class Guide:
    """Cost to go [m of free, well-spaced way] to a goal.

    Attributes:
        goal: (2,) float64 [m].
    """

    def __init__(
        self,
        clearance: Clearance,
        start: np.ndarray,
        goal: np.ndarray,
        altitude_m: float,
        preferred_m: float,
        needed_m: float,
    ):
        self.goal = np.asarray(goal[:2], np.float64)
        ends = np.stack([start[:2], goal[:2]])
        low = np.maximum(ends.min(axis=0) - _AROUND_M, clearance.bounds[0])
        high = np.minimum(ends.max(axis=0) + _AROUND_M, clearance.bounds[1])
        cell = max(_CELL_M, float(np.sqrt(np.prod(high - low) / _MOST_CELLS)))
        shape = np.maximum(np.ceil((high - low) / cell).astype(int), 2)
        self._low, self._cell_m = low, cell
        x, y = (low[k] + (np.arange(shape[k]) + 0.5) * cell for k in range(2))
        cells = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        z = clearance.ground_m(cells) + altitude_m
        points = np.column_stack([cells, z])
        room = np.where(clearance.covered(points), 0.0, clearance.obstacle_m(points))
        # People fly where there is something to see: far from everything costs a little, too.
        away = np.clip(np.log(np.maximum(room, 1e-3) / (2 * preferred_m)) / np.log(8), 0, 1)
        cost = 1 + 4 * shortfall(room, preferred_m) ** 2 + 0.5 * away
        cost = np.where(room < needed_m, _BLOCKED, cost).reshape(shape)
        room = room.reshape(shape)
        self._cost = cost
        index = np.arange(cost.size).reshape(shape)
        rows, cols, weights = [], [], []
        for dx, dy in _NEIGHBOURS:
            a = np.s_[: shape[0] - dx, max(0, -dy) : shape[1] - max(0, dy)]
            b = np.s_[dx:, max(0, dy) : shape[1] + min(0, dy)]
            rows.append(index[a].ravel())
            cols.append(index[b].ravel())
            length = cell * np.hypot(dx, dy)
            metre = (cost[a] + cost[b]) / 2
            # A way through a wall is at least as long as its ends are far from the wall.
            metre = np.where(room[a] + room[b] < length, _BLOCKED, metre)
            weights.append((length * metre).ravel())
        entries = np.concatenate(weights), (np.concatenate(rows), np.concatenate(cols))
        graph = coo_array(entries, shape=(cost.size, cost.size)).tocsr()
        at = np.clip(((self.goal - low) / cell).astype(int), 0, shape - 1)
        to_go = dijkstra(graph, directed=False, indices=index[tuple(at)])
        self._to_go = to_go.reshape(shape)

    def _cell(self, points: np.ndarray) -> np.ndarray:
        return ((points[:, :2] - self._low) / self._cell_m - 0.5).T

    def cost_to_go(self, points: np.ndarray) -> np.ndarray:
        """Remaining cost (n,) [m] from points (n, 2 or 3) [m]."""
        cell = self._cell(points)
        outside = np.maximum(-cell, cell - np.array(self._cost.shape)[:, None] + 1).max(axis=0)
        inside = map_coordinates(self._to_go, cell, order=1, mode="nearest")
        return inside + 2 * self._cell_m * np.maximum(outside, 0)

    def cost(self, points: np.ndarray) -> np.ndarray:
        """Cost of a metre (n,) at points (n, 2 or 3) [m]; 1 where flying is easy."""
        return map_coordinates(self._cost, self._cell(points), order=1, mode="nearest")

    def course_rad(self, point: np.ndarray, radius_m: float) -> float:
        """The course from a point (2 or 3,) towards the least cost to go at this distance."""
        angle = np.arange(48) * (2 * np.pi / 48)
        ring = point[:2] + radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)
        if np.linalg.norm(self.goal - point[:2]) <= radius_m:
            return float(np.arctan2(*(self.goal - point[:2])[::-1]))
        return float(angle[self.cost_to_go(ring).argmin()])
