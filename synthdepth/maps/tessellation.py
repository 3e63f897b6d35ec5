"""Ground areas as triangles: cut along a grid, so that they follow the terrain without slivers."""

from collections.abc import Callable

import numpy as np
import shapely

from synthdepth.maps.geometry import Geometry, geometry

CELL_M = 15.625
SHEET_CELLS = 4  # areas are triangulated in squares of so many cells: large polygons take long


def _sheets(pieces: np.ndarray, owner: np.ndarray, axis: int, first: int, last: int):
    """Pieces cut across an axis at the multiples `first` < i < `last` of a sheet, by halving."""
    if last - first <= 1 or not len(pieces):
        return [pieces], [owner]
    middle = (first + last) // 2
    at = middle * SHEET_CELLS * CELL_M
    bounds = shapely.bounds(pieces)
    low, high = bounds[:, axis] < at, bounds[:, axis + 2] > at
    both = low & high
    lower, upper = [-1e4, -1e4, 1e4, 1e4], [-1e4, -1e4, 1e4, 1e4]
    lower[axis + 2] = upper[axis] = at
    cut_pieces, cut_owner = [], []
    for box, only, span in (
        (lower, low & ~high, (first, middle)),
        (upper, high & ~low, (middle, last)),
    ):
        cut = shapely.intersection(pieces[both], shapely.box(*box))
        cut, index = shapely.get_parts(cut, return_index=True)
        part, own = _sheets(
            np.concatenate([pieces[only], cut]),
            np.concatenate([owner[only], owner[both][index]]),
            axis,
            *span,
        )
        cut_pieces += part
        cut_owner += own
    return cut_pieces, cut_owner


def triangulated(shapes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corners (t, 3, 2) of the polygons' triangles, counter-clockwise, and each one's polygon."""
    pieces, shape = shapely.get_parts(np.asarray(shapes, dtype=object), return_index=True)
    large = np.ptp(shapely.bounds(pieces).reshape(-1, 2, 2), axis=1).max(axis=1) > 100
    cut, own = pieces[large], shape[large]
    n = int(np.ceil(np.abs(shapely.bounds(cut)).max() / (SHEET_CELLS * CELL_M)))
    for axis in (0, 1):
        cut, own = map(np.concatenate, _sheets(cut, own, axis, -n, n))
    pieces = np.concatenate([pieces[~large], cut])
    shape = np.concatenate([shape[~large], own])
    flat = np.flatnonzero((shapely.get_type_id(pieces) == 3) & (shapely.area(pieces) > 1e-5))
    parts, index = shapely.get_parts(
        shapely.constrained_delaunay_triangles(pieces[flat]), return_index=True
    )
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    corners = np.where((_area_m2(corners) < 0)[:, None, None], corners[:, ::-1], corners)
    return corners, shape[flat[index]]


def _area_m2(corners: np.ndarray) -> np.ndarray:
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]) / 2


def _middle_line(c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which shapes with coordinates c (n, corners) straddle a grid line, and their middle one."""
    first = np.floor(c.min(axis=1) / CELL_M + 1e-7) + 1
    last = np.ceil(c.max(axis=1) / CELL_M - 1e-7) - 1
    return last >= first, (first + last) // 2 * CELL_M


def _meet(p: np.ndarray, q: np.ndarray, axis: int, line: np.ndarray) -> np.ndarray:
    """Where segments p-q (n, 2) cross coordinate `line`: the same from either end."""
    swap = ((p[:, 0] > q[:, 0]) | ((p[:, 0] == q[:, 0]) & (p[:, 1] > q[:, 1])))[:, None]
    a, b = np.where(swap, q, p), np.where(swap, p, q)
    span = b[:, axis] - a[:, axis]
    t = np.where(span == 0, 0.0, (line - a[:, axis]) / np.where(span == 0, 1.0, span))
    point = a + np.clip(t, 0, 1)[:, None] * (b - a)
    point[:, axis] = line
    return point


def sliced(corners: np.ndarray, tag: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Triangles (t, 3, 2) cut along the grid lines, each at its middle line until none is left."""
    done_corners, done_tag = [], []
    for axis in (0, 1):
        while len(corners):
            straddles, line = _middle_line(corners[:, :, axis])
            done_corners.append(corners[~straddles])
            done_tag.append(tag[~straddles])
            c, g, line = corners[straddles], tag[straddles], line[straddles]
            offset = c[:, :, axis] - line[:, None]
            above, below = offset > 1e-7, offset < -1e-7
            # The corner that is alone on its side comes first.
            alone = np.where(above.sum(1) == 1, above.argmax(1), below.argmax(1))
            c = np.take_along_axis(c, ((alone[:, None] + [0, 1, 2]) % 3)[:, :, None], axis=1)
            v0, v1, v2 = c[:, 0], c[:, 1], c[:, 2]
            p1, p2 = _meet(v0, v1, axis, line), _meet(v0, v2, axis, line)
            # The shorter diagonal of the part that two corners share.
            short = (np.linalg.norm(p1 - v2, axis=1) < np.linalg.norm(p2 - v1, axis=1))[:, None]
            corners = np.concatenate(
                [
                    np.stack([v0, p1, p2], 1),
                    np.stack([v1, v2, np.where(short, p1, p2)], 1),
                    np.stack([p1, np.where(short, v2, v1), p2], 1),
                ]
            )
            tag = np.concatenate([g, g, g])
            solid = _area_m2(corners) > 1e-6
            corners, tag = corners[solid], tag[solid]
        corners, tag = np.concatenate(done_corners), np.concatenate(done_tag)
        done_corners, done_tag = [], []
    return corners, tag


def sliced_segments(ends: np.ndarray) -> np.ndarray:
    """Segments (n, 2, 2) cut along the grid lines."""
    for axis in (0, 1):
        done = []
        while len(ends):
            straddles, line = _middle_line(ends[:, :, axis])
            done.append(ends[~straddles])
            p, q, line = ends[straddles, 0], ends[straddles, 1], line[straddles]
            m = _meet(p, q, axis, line)
            ends = np.concatenate([np.stack([p, m], 1), np.stack([m, q], 1)])
        ends = np.concatenate(done)
    return ends[np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1) > 1e-3]


def segments(lines) -> np.ndarray:
    """Segments (n, 2, 2) of rings and lines."""
    xy, index = shapely.get_coordinates(lines, return_index=True)
    return np.stack([xy[:-1], xy[1:]], 1)[index[1:] == index[:-1]]


def _patina(xy: np.ndarray, strength: float) -> np.ndarray:
    """A smooth unevenness (n,) about 1, in patches of 40 to 200 m."""
    x, y = xy.T
    wave = np.sin(x / 31 + 2 * np.sin(y / 57)) + np.sin(y / 23 + 2 * np.sin(x / 71))
    return 1 + strength * 0.5 * wave


def rings(area: shapely.Geometry) -> np.ndarray:
    """Rings of an area: outer ones counter-clockwise, holes clockwise."""
    return shapely.get_rings(shapely.orient_polygons(shapely.get_parts(area)))


def draped(
    corners: np.ndarray,
    height_m: Callable[[np.ndarray], np.ndarray],
    tint=(1.0, 1.0, 1.0),
    uneven: float = 0.06,
) -> Geometry:
    """Triangles (t, 3, 2) at `height_m`; tint (3,) or one for each triangle (t, 3)."""
    # What rounding to float32 would flatten is left out.
    solid = _area_m2(corners.astype(np.float32).astype(np.float64)) > 1e-7
    tint = np.broadcast_to(np.asarray(tint, np.float64), (len(corners), 3))[solid]
    corners = corners[solid]
    xy = corners.reshape(-1, 2)
    tint = np.repeat(tint, 3, axis=0)
    # Equal corners of equal tint are shared; the offset tells tints apart.
    key = (xy[:, 0] + 4096 * np.round(1000 * tint[:, 0])) + 1j * xy[:, 1]
    _, first, back = np.unique(key, return_index=True, return_inverse=True)
    xy = xy[first]
    colour = tint[first] * _patina(xy, uneven)[:, None]
    return geometry(np.column_stack([xy, height_m(xy)]), back.reshape(-1, 3), tint=colour)
