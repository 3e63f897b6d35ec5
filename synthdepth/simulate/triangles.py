"""Segments and moving spheres against triangles, in closed form, pair by pair.

A sphere's centre first touches a triangle where it first enters the triangle's Minkowski sum with
the ball: two triangles at the radius, three cylinders around the edges, three balls around the
corners (C. Ericson, "Real-Time Collision Detection", 2005, section 5.5.6). Of each the first
intersection is a linear or a quadratic equation.
"""

import numpy as np

from synthdepth.maps.geometry import cross


def segment_distance(start: np.ndarray, end: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Least distance between segments and triangles.

    Args:
        start, end: (k, 3) float64 [m]; may be equal.
        triangles: (k, 3, 3) float64 corners [m]; may be lines or points.

    Returns:
        (k,) float64 [m], 0 where they cross.
    """
    d = end - start
    normal = _normal(triangles)
    squared = np.minimum(
        _point_squared(start, triangles, normal), _point_squared(end, triangles, normal)
    )
    for i in range(3):
        corner, edge = triangles[:, i], triangles[:, (i + 1) % 3] - triangles[:, i]
        squared = np.minimum(squared, _to_segment_squared(corner, start, d))
        squared = np.minimum(squared, _lines_squared(start, d, corner, edge))
    # Through the face: the plane is crossed within the segment, inside the triangle.
    rate = _dot(d, normal)
    share = _divided(-_dot(start - triangles[:, 0], normal), rate)
    through = (share >= 0) & (share <= 1)
    through &= _inside(start + np.where(through, share, 0)[:, None] * d, triangles, normal)
    return np.sqrt(np.where(through, 0.0, squared))


def first_touch(
    start: np.ndarray, end: np.ndarray, radius_m: float, triangles: np.ndarray
) -> np.ndarray:
    """Share of the way at which spheres first touch triangles.

    Args:
        start, end: (k, 3) float64 centres [m]; may be equal.
        radius_m: of all spheres.
        triangles: (k, 3, 3) float64 corners [m].

    Returns:
        (k,) float64 in [0, 1]: 0 where they touch from the start; inf where they never do.
    """
    d = end - start
    normal = _normal(triangles)
    shares = [np.where(_point_squared(start, triangles, normal) <= radius_m**2, 0.0, np.inf)]
    height, rate = _dot(start - triangles[:, 0], normal), _dot(d, normal)
    for side in (-radius_m, radius_m) if radius_m else (0.0,):
        share = _divided(side - height, rate)
        counts = (share >= 0) & (share <= 1)
        at = start + np.where(counts, share, 0)[:, None] * d
        shares.append(np.where(counts & _inside(at, triangles, normal), share, np.inf))
    for i in range(3):
        corner, edge = triangles[:, i], triangles[:, (i + 1) % 3] - triangles[:, i]
        shares += [_ball(start - corner, d, radius_m), _tube(start - corner, d, edge, radius_m)]
    return np.minimum.reduce(shares)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", a, b)


def _divided(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """a / b; NaN where b is 0, which compares as false."""
    return a / np.where(b == 0, np.nan, b)


def _normal(triangles: np.ndarray) -> np.ndarray:
    """Unit normals (k, 3), 0 for triangles without area."""
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    normal = cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    longest = np.maximum(np.maximum(_dot(b - a, b - a), _dot(c - a, c - a)), _dot(c - b, c - b))
    # So thin that rounding turns the normal: its edges stand for it.
    return np.where(length > 1e-10 * longest[:, None], normal / np.maximum(length, 1e-300), 0.0)


def _inside(points: np.ndarray, triangles: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Whether points (k, 3), seen along the normal, lie within their triangles: (k,) bool."""
    inside = normal.any(axis=1)
    for i in range(3):
        corner = triangles[:, i]
        edge = triangles[:, (i + 1) % 3] - corner
        inside &= _dot(cross(edge, points - corner), normal) >= 0
    return inside


def _point_squared(points: np.ndarray, triangles: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Squared distances (k,) of points (k, 3) to triangles."""
    squared = np.full(len(points), np.inf)
    for i in range(3):
        corner = triangles[:, i]
        edge = triangles[:, (i + 1) % 3] - corner
        squared = np.minimum(squared, _to_segment_squared(points, corner, edge))
    height = _dot(points - triangles[:, 0], normal)
    return np.where(_inside(points, triangles, normal), height**2, squared)


def _to_segment_squared(points: np.ndarray, start: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Squared distances (k,) of points to segments from `start` by `d`, (k, 3) each."""
    q = points - start
    share = np.clip(np.nan_to_num(_divided(_dot(q, d), _dot(d, d))), 0, 1)
    q = q - share[:, None] * d
    return _dot(q, q)


def _lines_squared(p: np.ndarray, d: np.ndarray, q: np.ndarray, e: np.ndarray) -> np.ndarray:
    """Squared distances (k,) of lines p + s d and q + t e where both shares are within [0, 1];
    inf elsewhere, where an end is the nearest."""
    dd, ee, de, r = _dot(d, d), _dot(e, e), _dot(d, e), p - q
    dr, er = _dot(d, r), _dot(e, r)
    scale = dd * ee - de**2
    s, t = _divided(de * er - ee * dr, scale), _divided(dd * er - de * dr, scale)
    counts = (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    s, t = (np.where(counts, x, 0)[:, None] for x in (s, t))
    gap = r + s * d - t * e
    return np.where(counts, _dot(gap, gap), np.inf)


def _first_root(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    """The lesser root of a s^2 + 2 b s + c, of what comes nearer from outside; NaN without one."""
    discriminant = b * b - a * c
    root = np.sqrt(np.where((discriminant >= 0) & (b < 0), discriminant, np.nan))
    # c / (-b + root), not (-b - root) / a: nothing cancels.
    return _divided(c, root - b)


def _ball(q: np.ndarray, d: np.ndarray, radius_m: float) -> np.ndarray:
    """Share (k,) at which points q + s d first are within the radius of 0; inf without one."""
    share = _first_root(_dot(d, d), _dot(q, d), _dot(q, q) - radius_m**2)
    return np.where((share >= 0) & (share <= 1), share, np.inf)


def _tube(q: np.ndarray, d: np.ndarray, edge: np.ndarray, radius_m: float) -> np.ndarray:
    """Likewise, within the radius of the segment from 0 by `edge`, its ends' balls apart."""
    ee = _dot(edge, edge)
    along = [np.nan_to_num(_divided(_dot(x, edge), ee)) for x in (q, d)]
    q0, d0 = (x - s[:, None] * edge for x, s in zip((q, d), along, strict=True))
    share = _first_root(_dot(d0, d0), _dot(q0, d0), _dot(q0, q0) - radius_m**2)
    at = along[0] + np.where(np.isfinite(share), share, 0) * along[1]
    counts = (share >= 0) & (share <= 1) & (at >= 0) & (at <= 1)
    return np.where(counts, share, np.inf)
