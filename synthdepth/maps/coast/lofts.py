"""Curved surfaces from rows of points, and the small parts that things of the coast share."""

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.geometry import Geometry, cross, geometry, join, quads, tube

ROPE = (0.32, 0.27, 0.18)
STEEL = (0.34, 0.35, 0.36)
GELCOAT = (0.72, 0.72, 0.69)
_NO_AREA_M2 = 1e-7


def sheet(points, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """A grid of points (n, m, 3) [m] as one surface with shared vertices.

    It faces (row direction) x (column direction) reversed: rows that run up and columns that run
    to the right, seen from outside, give outward normals. Cells without area are left out.
    `uv`: u along the columns, v along the rows [m].
    """
    p = np.asarray(points, np.float64)
    n, m = p.shape[:2]
    across = np.linalg.norm(np.diff(p, axis=1), axis=2).mean(axis=0)
    along = np.linalg.norm(np.diff(p, axis=0), axis=2).mean(axis=1)
    u = np.broadcast_to(np.concatenate([[0], np.cumsum(across)])[None], (n, m))
    v = np.broadcast_to(np.concatenate([[0], np.cumsum(along)])[:, None], (n, m))
    i = np.arange(n * m).reshape(n, m)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    faces = np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3)
    flat = p.reshape(-1, 3)
    corner = flat[faces]
    area = np.linalg.norm(cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    return geometry(flat, faces[area > _NO_AREA_M2], np.stack([u, v], -1), tint)


def mirrored(part: Geometry) -> Geometry:
    """The same part on the other side of the plane y = 0."""
    return geometry(
        part.vertices * np.float32([1, -1, 1]), part.faces[:, [0, 2, 1]], part.uv, part.tint
    )


def both_sides(part: Geometry) -> Geometry:
    """A part and its mirror image."""
    return join([part, mirrored(part)])


def fan(rim, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """A flat or nearly flat convex lid over a ring (k, 3), counter-clockwise seen from outside."""
    p = np.asarray(rim, np.float64)
    k = len(p)
    middle = p.mean(axis=0)
    faces = np.stack([np.arange(k), np.roll(np.arange(k), -1), np.full(k, k)], 1)
    return geometry(np.concatenate([p, middle[None]]), faces, tint=tint)


def lathe(radii, heights, sides: int, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """A closed solid of revolution about z; `radii` and `heights` (k,) [m], heights rising."""
    return tube([[0, 0, z] for z in heights], list(radii), sides, tint)


def between(start, end, share) -> np.ndarray:
    """Points at shares (k,) of the way from `start` to `end` (3,): (k, 3)."""
    t = np.asarray(share, np.float64)[:, None]
    return np.asarray(start, np.float64) * (1 - t) + np.asarray(end, np.float64) * t


def resampled(path, count: int) -> np.ndarray:
    """`count` points at even distances along a polyline (k, d): (count, d)."""
    p = np.asarray(path, np.float64)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    at = np.linspace(0, length[-1], count)
    return np.stack([np.interp(at, length, p[:, i]) for i in range(p.shape[1])], axis=1)


def net(points, cord_m: float, tint, every: int = 1) -> Geometry:
    """Cords along the rows and columns of a grid (n, m, 3) as thin crossed ribbons.

    Args:
        points: knots of the net [m].
        cord_m: width of a cord.
        tint: (3,).
        every: leave out all but each `every`th cord.
    """
    p = np.asarray(points, np.float64)
    rows, columns = p[::every], np.swapaxes(p, 0, 1)[::every]
    # Ribbons lie in the net: widened towards the cords that cross them.
    crossing = np.gradient(p, axis=0)[::every], np.swapaxes(np.gradient(p, axis=1), 0, 1)[::every]
    strips = []
    for cords, across in zip((rows, columns), crossing, strict=True):
        a, b = cords[:, :-1].reshape(-1, 3), cords[:, 1:].reshape(-1, 3)
        side = (across[:, :-1] + across[:, 1:]).reshape(-1, 3)
        along = b - a
        length = np.linalg.norm(along, axis=1, keepdims=True)
        along = along / np.maximum(length, 1e-9)
        side = side - along * np.einsum("ij,ij->i", side, along)[:, None]
        size = np.linalg.norm(side, axis=1, keepdims=True)
        keep = (length[:, 0] > 1e-3) & (size[:, 0] > 1e-6)
        a, b, side = a[keep], b[keep], (side * cord_m / 2 / np.maximum(size, 1e-9))[keep]
        strips.append(quads(np.stack([a - side, b - side, b + side, a + side], 1), tint))
    return join(strips)


def coil(radius_m: float, rope_m: float, turns: int, tint=ROPE) -> Geometry:
    """A coiled rope lying on z = 0: a helix that widens downwards."""
    t = np.linspace(0, 2 * np.pi * turns, 9 * turns + 1)
    r = radius_m * (0.75 + 0.25 * np.cos(t / 2.7))
    z = rope_m / 2 + 0.75 * rope_m * (t / (2 * np.pi)) * 0.8
    path = np.column_stack([r * np.cos(t), r * np.sin(t), z])
    return tube(path, rope_m / 2, 4, tint)


def sagging(start, end, sag_m: float, radius_m: float, tint=ROPE, segments: int = 8) -> Geometry:
    """A rope that hangs `sag_m` below the chord of its two ends (3,)."""
    t = np.linspace(0, 1, segments + 1)
    path = between(start, end, t)
    path[:, 2] -= 4 * sag_m * t * (1 - t)
    return tube(path, radius_m, 4, tint, capped=False)


def railing(
    path, height_m: float, tint, *, spacing_m: float = 1.2, radius_m: float = 0.0125, wires: int = 1
) -> Geometry:
    """Stanchions along a deck's edge (k, 3), a top tube, and thinner wires below it."""
    p = np.asarray(path, np.float64)
    length = np.linalg.norm(np.diff(p, axis=0), axis=1).sum()
    count = max(round(length / spacing_m), 1) + 1
    feet = resampled(p, count)
    posts = round_bars(feet - [0, 0, 0.02], feet + [0, 0, height_m], radius_m, tint, 5)
    line = resampled(p, max(count, 2 * len(p)))
    rails = [tube(line + [0, 0, height_m], radius_m, 5, tint)]
    for level in np.arange(1, wires + 1) / (wires + 1):
        rails.append(tube(line + [0, 0, level * height_m], 0.004, 3, tint, capped=False))
    return join([posts, *rails])


def pane(corners, shares, offset_m: float = 0.008) -> Geometry:
    """A window on part of a wall's quadrilateral, standing `offset_m` before it.

    Args:
        corners: (4, 3) lower left, lower right, upper right, upper left seen from outside [m].
        shares: (u0, u1, v0, v1), the window's edges as shares of the wall.
        offset_m: along the outward normal.
    """
    p = np.asarray(corners, np.float64)
    u0, u1, v0, v1 = shares

    def at(u: float, v: float) -> np.ndarray:
        return (1 - v) * ((1 - u) * p[0] + u * p[1]) + v * ((1 - u) * p[3] + u * p[2])

    normal = cross(p[1] - p[0], p[3] - p[0])
    normal *= offset_m / np.linalg.norm(normal)
    return quads(np.stack([at(u0, v0), at(u1, v0), at(u1, v1), at(u0, v1)])[None] + normal)
