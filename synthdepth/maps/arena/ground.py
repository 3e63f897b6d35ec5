"""The arena's ground at z = 0: patterned floors in zones, lanes between, worn lines on both."""

import numpy as np
import shapely

from synthdepth.maps.arena.plan import EDGE_M, LANE_M, Plot
from synthdepth.maps.geometry import Geometry, Model, geometry, join, merge, quads
from synthdepth.maps.tessellation import draped, sliced, triangulated

_DECAL_M = 0.006
_LINE_M = 0.15
_CELL_M = 12.0
_SOFT = ("grass", "gravel", "soil")


def arena_ground(rng: np.random.Generator, plots: list[Plot], half_size_m: float) -> Model:
    """Floors of the plots, lanes, and grass from the fence to the map's edge.

    Args:
        rng: of each floor's turn and shade.
        plots: the zones.
        half_size_m: half the side of the map.
    """
    zones = [_rectangle(plot.centre_m, plot.size_m) for plot in plots]
    fenced = shapely.box(-EDGE_M, -EDGE_M, EDGE_M, EDGE_M)
    models: list[Model] = [{(plot.floor, "ground"): _floor(rng, plot)} for plot in plots]
    lanes = fenced.difference(shapely.union_all(zones))
    models.append({("asphalt", "road"): _area(lanes)})
    square = shapely.box(-half_size_m, -half_size_m, half_size_m, half_size_m)
    models.append({("grass", "ground"): _area(square.difference(fenced))})
    near = [plot for plot in plots if plot.near]
    models.append({("road_paint", "road"): join([_lane_lines(near), *_zone_lines(rng, near)])})
    return merge(models)


def _rectangle(centre, size) -> shapely.Geometry:
    return shapely.box(*(centre - size / 2), *(centre + size / 2))


def _area(shape: shapely.Geometry) -> Geometry:
    corners, tag = triangulated([shape])
    corners, _ = sliced(corners, tag)
    return draped(corners, _level, uneven=0.1)


def _level(xy: np.ndarray) -> np.ndarray:
    return np.zeros(len(xy))


def _floor(rng: np.random.Generator, plot: Plot) -> Geometry:
    """A zone's floor, its pattern turned and shifted, patches darker and lighter."""
    x, y = (
        np.linspace(c - w / 2, c + w / 2, int(w / _CELL_M) + 2)
        for c, w in zip(plot.centre_m, plot.size_m, strict=True)
    )
    p = np.stack(np.meshgrid(x, y, indexing="ij"), -1)
    a, b, c, d = (q.reshape(-1, 2) for q in (p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]))
    corners = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    part = draped(corners, _level, uneven=0.1)
    loose = rng.random() < 0.3 or plot.floor in _SOFT
    turn = rng.uniform(0, np.pi) if loose else np.pi / 2 * rng.integers(0, 4)
    c, s = np.cos(turn), np.sin(turn)
    uv = part.vertices[:, :2].astype(np.float64) @ np.array([[c, -s], [s, c]])
    shade = rng.uniform(0.8, 1.12) * (1 + rng.uniform(-0.05, 0.05, 3))
    return geometry(part.vertices, part.faces, uv + rng.uniform(0, 20, 2), part.tint * shade)


def _strips(start, end, width: float, tint) -> Geometry:
    """Painted lines from start to end, each (k, 2) [m]."""
    a, b = np.asarray(start, float).reshape(-1, 2), np.asarray(end, float).reshape(-1, 2)
    along = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    side = width / 2 * np.column_stack([-along[:, 1], along[:, 0]])
    corners = np.stack([a - side, b - side, b + side, a + side], 1)
    z = np.full((*corners.shape[:2], 1), _DECAL_M)
    return quads(np.concatenate([corners, z], -1), tint, a)


def _lane_lines(plots: list[Plot]) -> Geometry:
    """Edge lines round the zones and dashes in the lanes along their sides."""
    parts = []
    for plot in plots:
        x0, y0 = plot.centre_m - plot.size_m / 2 - 0.35
        x1, y1 = plot.centre_m + plot.size_m / 2 + 0.35
        ring = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
        parts.append(_strips(ring, np.roll(ring, -1, axis=0), _LINE_M, (0.5, 0.5, 0.47)))
        dash = np.arange(y0 + 3, y1 - 3, 6.0)
        x = np.full(len(dash), x1 + LANE_M / 2 - 0.35)
        start = np.column_stack([x, dash])
        parts.append(_strips(start, start + [0, 2.5], 0.12, (0.5, 0.37, 0.08)))
    return join(parts)


def _zone_lines(rng: np.random.Generator, plots: list[Plot]) -> list[Geometry]:
    """Courts, bays and landing circles painted on the hard floors."""
    parts = []
    for plot in plots:
        if plot.floor in _SOFT:
            continue
        for _ in range(int(rng.integers(2, 6))):
            at = plot.centre_m + rng.uniform(-0.36, 0.36, 2) * plot.size_m
            tint = ((0.55, 0.55, 0.52), (0.5, 0.35, 0.05), (0.28, 0.05, 0.04))[rng.integers(3)]
            if rng.random() < 0.4:
                r = rng.uniform(1.5, 4.0)
                turn = np.linspace(0, 2 * np.pi, 33)
                ring = at + r * np.column_stack([np.cos(turn), np.sin(turn)])
                parts.append(_strips(ring[:-1], ring[1:], 0.2, tint))
                bars = np.array([[-0.4, -0.5, -0.4, 0.5], [0.4, -0.5, 0.4, 0.5]]) * r
                parts.append(_strips(at + bars[:, :2], at + bars[:, 2:], 0.25, tint))
                parts.append(
                    _strips(at + [-0.4 * r + 0.13, 0], at + [0.4 * r - 0.13, 0], 0.25, tint)
                )
            else:
                number, deep = int(rng.integers(3, 9)), rng.uniform(3, 6)
                x = np.arange(number) * rng.uniform(2.2, 3.2)
                low = at + np.column_stack([x - x.mean(), 0 * x])
                parts.append(_strips(low, low + [0, deep], 0.12, tint))
    return parts
