"""What is painted on a city's streets and what wears them: lines, zebras, arrows, repairs, lids."""

import numpy as np

from synthdepth.maps.downtown.grid import Grid
from synthdepth.maps.geometry import Geometry, Model, geometry, quads

_PATCH_LIFT_M, _PAINT_LIFT_M, _COVER_LIFT_M = 0.006, 0.012, 0.016
_REACH_M = 420.0
_LINE_M, _DASH_M, _GAP_M = 0.12, 3.0, 9.0
# From where the other street's kerb has straightened out: crossing, its depth, stop line.
_CROSSING_M, _CROSSING_DEPTH_M, _STOP_M, _STOP_WIDTH_M = 2.2, 3.2, 4.9, 0.4
_BAR_M = 0.5  # of a zebra, and the gap between its bars
_BAY_M = 5.6
_WHITE, _YELLOW = (0.6, 0.6, 0.57), (0.55, 0.36, 0.06)
_LID_M, _LID_CORNERS = 0.33, 12


def crossing_m(grid: Grid) -> np.ndarray:
    """Where the pedestrian crossings of the edges are: distance (e, 2) [m] from either end."""
    return grid.setback_m + _CROSSING_M


def street_markings(rng: np.random.Generator, grid: Grid) -> Model:
    """Lane lines, crossings, stop lines, arrows and parking bays; repairs and manhole covers."""
    near = np.linalg.norm((grid.start + grid.end) / 2, axis=1) < _REACH_M
    paint, colour = [np.zeros((0, 4, 2))], [np.zeros((0, 3))]
    patches, covers = [np.zeros((0, 4, 2))], [np.zeros((0, 2))]
    for edge in np.flatnonzero(near & (grid.length_m > 12)):
        for rectangles, tint in _edge_paint(grid, edge):
            paint.append(rectangles)
            colour.append(np.broadcast_to(tint, (len(rectangles), 3)))
        repairs, lids = _edge_wear(rng, grid, edge)
        patches.append(repairs)
        covers.append(lids)
    paint, colour = np.concatenate(paint), np.concatenate(colour)
    patches, lids = np.concatenate(patches), np.concatenate(covers)
    worn = rng.uniform(0.65, 1.0, (len(paint), 1))
    shade = rng.choice([0.55, 0.7, 1.25, 1.4], (len(patches), 1)) * np.ones(3)
    return {
        ("road_paint", "road"): _laid(paint, _PAINT_LIFT_M, colour * worn),
        ("asphalt", "road"): _laid(patches, _PATCH_LIFT_M, shade),
        ("paint", "road"): _lids(lids),
    }


def _laid(rectangles: np.ndarray, z: float, tint: np.ndarray) -> Geometry:
    level = np.full((*rectangles.shape[:2], 1), z)
    return quads(np.concatenate([rectangles, level], axis=2), tint, rectangles[:, 0] % 50)


def _lids(centres: np.ndarray) -> Geometry:
    turn = 2 * np.pi * np.arange(_LID_CORNERS) / _LID_CORNERS
    rim = _LID_M * np.stack([np.cos(turn), np.sin(turn)], 1)
    v = np.concatenate([centres[:, None], centres[:, None] + rim], axis=1)
    step = np.arange(_LID_CORNERS)
    fan = np.stack([np.zeros_like(step), 1 + step, 1 + (step + 1) % _LID_CORNERS], 1)
    faces = (fan + (_LID_CORNERS + 1) * np.arange(len(centres))[:, None, None]).reshape(-1, 3)
    v = np.concatenate([v, np.full((*v.shape[:2], 1), _COVER_LIFT_M)], axis=2)
    return geometry(v, faces, tint=(0.07, 0.068, 0.065))


def _boxes(grid: Grid, edge: int, s_m, left_m, length_m, width_m) -> np.ndarray:
    """Rectangles (k, 4, 2) around points along an edge, `length_m` along it."""
    s, left, length, width = np.broadcast_arrays(
        *(np.atleast_1d(np.asarray(x, float)) for x in (s_m, left_m, length_m, width_m))
    )
    return np.stack(
        [
            grid.at(np.full(len(s), edge), s + a * length / 2, left + b * width / 2)
            for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
        ],
        axis=1,
    )


def _edge_paint(grid: Grid, edge: int) -> list[tuple[np.ndarray, tuple]]:
    """Rectangles and their colour, of one edge."""
    profile, length = grid.profile(edge), grid.length_m[edge]
    if profile.kind == "alley":
        return []
    junction = grid.degree[grid.node[edge]] >= 3
    first, last = np.where(junction, grid.setback_m[edge] + _STOP_M + 1.0, 1.0)
    run = length - first - last
    if run < 8:
        return []
    half = profile.carriageway_m / 2
    offsets = np.array([offset for offset, _ in profile.lanes])
    flows = np.array([flow for _, flow in profile.lanes])
    lane_m = float(np.diff(offsets).min()) if len(offsets) > 1 else 3.8
    made = []
    dashes = first + np.arange(0, max(run - _DASH_M, 0.1), _DASH_M + _GAP_M) + _DASH_M / 2
    for a, b, fa, fb in zip(offsets[:-1], offsets[1:], flows[:-1], flows[1:], strict=True):
        between = (a + b) / 2
        if fa == fb:
            made.append((_boxes(grid, edge, dashes, between, _DASH_M, _LINE_M), _WHITE))
            continue
        piece = np.arange(first, first + run, 10.0)
        size = np.minimum(10.0, first + run - piece)
        for aside in (-0.13, 0.13):
            lines = _boxes(grid, edge, piece + size / 2, between + aside, size, 0.1)
            made.append((lines, _YELLOW))
    for side, parks in zip((1, -1), profile.parking, strict=True):
        if parks:
            ticks = first + np.arange(0, run, _BAY_M)
            made.append((_boxes(grid, edge, ticks, side * (half - 1.1), 0.1, 2.1), _WHITE))
    for end in np.flatnonzero(junction):
        made += _end_paint(grid, edge, int(end), offsets[flows == (1 if end else -1)], lane_m)
    return made


def _end_paint(grid: Grid, edge: int, end: int, comes: np.ndarray, lane_m: float):
    """Zebra, and the stop lines and arrows of the lanes `comes` (k,) that lead to this end."""
    length = grid.length_m[edge]
    half = grid.profile(edge).carriageway_m / 2

    def at(from_end):
        return length - from_end if end else from_end

    bars = np.arange(-half + 0.45, half - 0.2, 2 * _BAR_M) + _BAR_M / 2
    place = at(crossing_m(grid)[edge, end])
    made = [(_boxes(grid, edge, place, bars, _CROSSING_DEPTH_M, _BAR_M), _WHITE)]
    stop = grid.setback_m[edge, end] + _STOP_M
    if len(comes):
        made += [
            (_boxes(grid, edge, at(stop), comes, _STOP_WIDTH_M, lane_m - 0.25), _WHITE),
            (_boxes(grid, edge, at(stop + 6.0), comes, 2.6, 0.16), _WHITE),
            (_boxes(grid, edge, at(stop + 4.4), comes, 0.5, 0.55), _WHITE),
        ]
    return made


def _edge_wear(rng: np.random.Generator, grid: Grid, edge: int) -> tuple[np.ndarray, np.ndarray]:
    """Repairs (k, 4, 2) of an edge's asphalt, and centres (m, 2) of its manhole covers."""
    half, length = grid.profile(edge).carriageway_m / 2, grid.length_m[edge]
    count = rng.poisson(length / 16)
    size = np.exp(rng.uniform(np.log([0.8, 0.6]), np.log([9.0, 2.2]), (count, 2)))
    size[:, 0] = np.minimum(size[:, 0], 0.6 * length)
    s = rng.uniform(size[:, 0] / 2 + 0.5, np.maximum(length - size[:, 0] / 2, size[:, 0] / 2 + 1))
    left = rng.uniform(-1, 1, count) * (half - size[:, 1] / 2 - 0.3)
    lids = rng.poisson(length / 30)
    where = grid.at(
        np.full(lids, edge), rng.uniform(2, length - 2, lids), rng.uniform(-0.8, 0.8, lids) * half
    )
    if not count:
        return np.zeros((0, 4, 2)), where
    return _boxes(grid, edge, s, left, *size.T), where
