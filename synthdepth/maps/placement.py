"""Setting things down: on the ground, along lines, within free space."""

from collections.abc import Mapping

import numpy as np
import shapely
from scipy.spatial import cKDTree

from synthdepth.maps.terrain import Terrain


def on_ground(terrain: Terrain, xy: np.ndarray) -> np.ndarray:
    """Points (n, 2) [m] set down on the terrain: (n, 3) [m]."""
    xy = np.asarray(xy, np.float64).reshape(-1, 2)
    return np.column_stack([xy, terrain.height_m(xy)])


def distance_to(bounds: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Horizontal distance (n,) [m] of points (n, 2 or 3) from the square that flights keep to.

    Levels of detail follow from it, never from a flight: a flight must not change its world.
    """
    xy = np.asarray(points)[:, :2]
    outside = np.maximum(np.maximum(bounds[0] - xy, xy - bounds[1]), 0)
    return np.hypot(outside[:, 0], outside[:, 1])


def draped_line(terrain: Terrain, line: np.ndarray, step_m: float = 4.0) -> np.ndarray:
    """A polyline (k, 2) [m] laid on the terrain with a point at least every `step_m`: (n, 3)."""
    path = shapely.segmentize(shapely.LineString(line), step_m)
    return on_ground(terrain, shapely.get_coordinates(path))


def points_along(line: shapely.Geometry, spacing_m: float, rng: np.random.Generator) -> np.ndarray:
    """Points (n, 2) [m] on one or more lines, about every `spacing_m`, shaken along it."""
    points = [np.zeros((0, 2))]
    for part in shapely.get_parts(line):
        corners = shapely.get_coordinates(part)
        length = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
        count = int(length[-1] / spacing_m)
        at = (np.arange(count) + rng.uniform(0, 1, count)) * spacing_m
        points.append(np.column_stack([np.interp(at, length, corners[:, k]) for k in (0, 1)]))
    return np.concatenate(points)


def points_within(
    rng: np.random.Generator, area: shapely.Geometry, count: int, apart_m: float = 0.0
) -> np.ndarray:
    """Up to `count` random points (n, 2) [m] in an area, no two nearer than `apart_m`.

    Fewer come back where the area has no room for more.
    """
    if area.is_empty or count <= 0:
        return np.zeros((0, 2))
    shapely.prepare(area)
    x0, y0, x1, y1 = area.bounds
    tries = rng.uniform([x0, y0], [x1, y1], (4 * count + 16, 2))
    tries = tries[shapely.contains_xy(area, tries[:, 0], tries[:, 1])]
    if apart_m > 0:
        # Of two that are too near the later one goes, even if a third would have removed the
        # earlier one: a little sparser than it could be, and free of loops.
        pairs = cKDTree(tries).query_pairs(apart_m, output_type="ndarray")
        keep = np.ones(len(tries), bool)
        keep[pairs.max(axis=1)] = False
        tries = tries[keep]
    return tries[:count]


def pick(rng: np.random.Generator, weights: Mapping[str, float]) -> str:
    """One of the names, drawn by weight."""
    share = np.array(list(weights.values()), float)
    return str(rng.choice(list(weights), p=share / share.sum()))
