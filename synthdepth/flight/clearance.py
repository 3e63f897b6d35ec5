"""How far a point is from everything in a world: a fast bound that never claims too much.

The distance to millions of triangles is bounded from below in two parts.

*Obstacles*: surfaces are covered by samples (a small triangle by the middle of its longest edge, a
large one by a lattice), snapped to a voxel grid and put into k-d trees: a fine one for the near
surroundings, a coarse one for the rest. The nearest sample's distance less the covering radius is
the bound.

*Floor*: what lies flat on the ground (terrain, roads, kerbs, lawn) would cost millions of samples.
It becomes a raster of its highest points instead, and everything under the raster counts as solid.
Steep ground stays among the obstacles.

The inside of a house is far from its walls, too, so a second raster tells what lies under a roof.
"""

import numpy as np
from scipy.ndimage import maximum_filter1d
from scipy.spatial import cKDTree

from synthdepth.flight.cover import CHUNK, cover
from synthdepth.maps.geometry import Geometry
from synthdepth.maps.world import World

# Obstacles: covering radius of the samples before snapping, and the voxel they are snapped to.
_COVER_M = 0.38
_VOXEL_M = 0.05
_NEAR_RADIUS_M = _COVER_M + np.sqrt(3) / 2 * _VOXEL_M + 1e-3  # 1e-3: float32 coordinates round
# The coarse tree's voxels are 2**4 fine ones wide.
_COARSE_BITS = 4
_FAR_RADIUS_M = _NEAR_RADIUS_M + np.sqrt(3) / 2 * _VOXEL_M * 2**_COARSE_BITS

# Floor: cell of the raster, covering radius of its samples, how far something may stand above the
# ground and how steep it may be. On steeper floors the raster's steps would be too coarse.
_CELL_M = 1.0
_FLOOR_COVER_M = 0.7
_LOW_M = 0.3
_SLOPE = 0.15
# Rings around a point: each stands for its inner radius and the highest floor up to its outer one.
_RINGS_M = (0.0, 1.0, 2.0, 4.0, 8.0, 16.0)

# What a drone under it is still outdoors; anything else above it counts as a roof.
_AIRY_LABELS = ("vegetation", "tree_trunk", "wire", "pole")


class Clearance:
    """Lower bounds of the distance to a world's surfaces, wires and leaves included.

    A bound never exceeds the true distance. It is at most 0.5 m short within `near_m` of an
    obstacle, 2 m beyond; over and beside sloping ground it is short by up to half a metre more.
    It never exceeds `reach_m`, and it falls to zero towards the edge of the volume that is known:
    the flight bounds widened by `reach_m`, up to `reach_m` above the highest flights.

    Attributes:
        bounds: (2, 2) float64, the world's flight bounds [m].
        ground_m: the world's ground height [m] at points (n, 2) [m] -> (n,).
        reach_m: the largest distance that is told apart [m].
        sample_count: number of obstacle samples.
    """

    def __init__(self, world: World, *, max_altitude_m: float = 40.0, reach_m: float = 30.0):
        self.bounds = np.asarray(world.flight_bounds, np.float64)
        self.ground_m = world.ground_m
        self.reach_m = float(reach_m)
        shape = np.ceil((self.bounds[1] - self.bounds[0] + 2 * reach_m) / _CELL_M).astype(int)
        low = self.bounds[0] - reach_m
        x, y = (low[k] + (np.arange(shape[k]) + 0.5) * _CELL_M for k in range(2))
        centres = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
        ground = np.asarray(self.ground_m(centres), np.float32).reshape(shape)
        self._lower = np.array([*low, ground.min() - reach_m])
        self._upper = np.array([*(low + shape * _CELL_M), ground.max() + max_altitude_m + reach_m])

        box = self._lower.astype(np.float32), self._upper.astype(np.float32)
        tall = box[0], np.array([*box[1][:2], np.inf], np.float32)
        floor, roof = np.full((2, *shape), -np.inf, np.float32)
        codes = [np.zeros(0, np.int64)]
        for (_, label), part in world.surfaces.items():
            solid, flat, high = self._split(part, ground)
            points, tops = cover(flat, _FLOOR_COVER_M, *box)
            np.maximum.at(floor, self._cells(points), tops)
            points, tops = cover(solid, _COVER_M, *box)
            codes.append(self._encode(points))
            if label not in _AIRY_LABELS:
                np.maximum.at(roof, self._cells(points), tops)
                points, tops = cover(high, _FLOOR_COVER_M, *tall)
                np.maximum.at(roof, self._cells(points), tops)
        codes = _unique(np.concatenate(codes))
        self.sample_count = len(codes)
        self._near = self._tree(codes, 0)
        self._far = self._tree(codes, _COARSE_BITS)
        self._rings = [
            _highest(floor, int(np.ceil((outer + _FLOOR_COVER_M) / _CELL_M)))
            for outer in [*_RINGS_M[1:], self.reach_m]
        ]
        self._roof = _highest(roof, 1)  # a cell beside: the lattice may skip one

    def covered(self, points: np.ndarray) -> np.ndarray:
        """Whether points (n, 3) [m] have a roof above them, or one a cell beside: (n,) bool."""
        points = np.asarray(points, np.float64)
        return points[:, 2] < self._roof[self._cells(points)]

    def obstacle_m(self, points: np.ndarray, near_m: float = 4.0) -> np.ndarray:
        """Lower bounds (n,) [m] of the distance from points (n, 3) [m] to all but the floor.

        Where the coarse tree says less than `near_m`, the fine one is asked.
        """
        p = np.ascontiguousarray(points, np.float64)
        far, _ = self._far.query(p, distance_upper_bound=self.reach_m + _FAR_RADIUS_M)
        bound = far - _FAR_RADIUS_M
        near = np.flatnonzero(bound < near_m)
        bound[near] = self._near.query(p[near])[0] - _NEAR_RADIUS_M
        edge = np.minimum(p - self._lower, self._upper - p).min(axis=1) - 0.01
        return np.clip(np.minimum(bound, edge), 0.0, self.reach_m)

    def floor_m(self, points: np.ndarray) -> np.ndarray:
        """Lower bounds (n,) [m] of the distance from points (n, 3) [m] to the floor."""
        points = np.asarray(points, np.float64)
        cells = self._cells(points)
        bound = np.full(len(points), self.reach_m)
        for inner, highest in zip(_RINGS_M, self._rings, strict=True):
            above = np.clip(points[:, 2] - highest[cells] - 1e-3, 0.0, self.reach_m)
            np.minimum(bound, np.hypot(inner, above), out=bound)
        return bound

    def __call__(self, points: np.ndarray, near_m: float = 4.0) -> np.ndarray:
        """Lower bounds (n,) float64 [m] of the distance from points (n, 3) [m] to anything."""
        return np.minimum(self.obstacle_m(points, near_m), self.floor_m(points))

    def _cells(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Raster cells of points (n, 2+): two arrays (n,), those outside on the border."""
        shape = np.round((self._upper - self._lower)[:2] / _CELL_M).astype(int)
        cells = ((points[:, :2] - self._lower[:2].astype(points.dtype)) / _CELL_M).astype(np.int32)
        return tuple(np.clip(cells, 0, shape - 1).T)

    def _split(self, part: Geometry, ground: np.ndarray) -> tuple[np.ndarray, ...]:
        """Corners (3, m, 3) of a surface's obstacle triangles, of its floor triangles, and of what
        is level above the known volume: high roofs."""
        solid, flat, high = ([np.zeros((3, 0, 3), np.float32)] for _ in range(3))
        lower, upper = self._lower.astype(np.float32), self._upper.astype(np.float32)
        for i in range(0, len(part.faces), CHUNK):
            a, b, c = corners = np.take(part.vertices, part.faces[i : i + CHUNK].T, axis=0)
            bottom, top = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
            near = (top >= lower) & (bottom <= upper)
            beside = near[:, 0] & near[:, 1]
            within, above = beside & near[:, 2], beside & (bottom[:, 2] > upper[2])
            size = top - bottom
            level = size[:, 2] <= np.maximum(0.35, _SLOPE * np.hypot(size[:, 0], size[:, 1]))
            level = np.flatnonzero(level & within & (top[:, 2] <= ground.max() + _LOW_M))
            at = self._cells(corners[:, level].reshape(-1, 3))
            raised = corners[:, level, 2] - ground[at].reshape(3, -1)
            level = level[(raised <= _LOW_M).all(axis=0)]
            flat.append(corners[:, level])
            within[level] = False
            solid.append(corners[:, within])
            normal = np.cross(b[above] - a[above], c[above] - a[above])
            lies = np.abs(normal[:, 2]) > 0.3 * np.linalg.norm(normal, axis=1)
            high.append(corners[:, np.flatnonzero(above)[lies]])
        return tuple(np.concatenate(x, axis=1) for x in (solid, flat, high))

    def _encode(self, points: np.ndarray) -> np.ndarray:
        """Voxels of points (n, 3) as sorted int64 codes, each once."""
        # 64: a sample may lie just outside the box.
        x, y, z = np.floor((points - self._lower) / _VOXEL_M).astype(np.int64).T + 64
        return _unique((x << 42) | (y << 21) | z)

    def _tree(self, codes: np.ndarray, bits: int) -> cKDTree:
        """The centres of the voxels that are 2**bits fine ones wide, as a tree."""
        keep = 0x1FFFFF >> bits << bits
        codes = _unique(codes & (keep << 42 | keep << 21 | keep)) if bits else codes
        voxel = np.stack([codes >> 42, (codes >> 21) & 0x1FFFFF, codes & 0x1FFFFF], axis=1)
        centres = self._lower + (voxel + 0.5 * 2**bits - 64) * _VOXEL_M
        # A sliding-midpoint tree builds twice as fast as a balanced one.
        return cKDTree(centres, leafsize=24, balanced_tree=False, compact_nodes=False)


def _unique(codes: np.ndarray) -> np.ndarray:
    codes = np.sort(codes)
    return codes[np.diff(codes, prepend=-1) != 0]


def _highest(raster: np.ndarray, cells: int) -> np.ndarray:
    """The maximum of a raster over the square that reaches this many cells from each cell."""
    for axis in range(2):
        size = 2 * cells + 1
        raster = maximum_filter1d(raster, size, axis=axis, mode="constant", cval=-np.inf)
    return raster
