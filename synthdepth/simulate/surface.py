"""Points on triangles, close together: what maps from above and occupancy are made of."""

from collections.abc import Iterator

import numpy as np

from synthdepth.maps.geometry import cross

_CHUNK = 1 << 20  # points at a time
_LARGEST_M = 32.0  # edge of a triangle that is sampled whole


def surface_points(
    triangles: np.ndarray, low_m: np.ndarray, high_m: np.ndarray, spacing_m: float
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Points of all triangles within a box, about as far apart as asked.

    They lie on lines parallel to a triangle's longest edge, which is one of them: so slivers such
    as wires are met all along. No place is farther from a point than 1.12 spacings.

    Args:
        triangles: (m, 3, 3) corners [m].
        low_m, high_m: (3,) corners of the box [m]; triangles outside it are left out.
        spacing_m: between neighbours.

    Yields:
        (k, 3) float32 points [m], and the (k,) int64 triangles that they are on.
    """
    which = np.arange(len(triangles))
    for part in np.array_split(which, max(1, -(-len(which) // _CHUNK))):
        yield from _of_part(triangles[part], part, low_m, high_m, spacing_m)


def _of_part(triangles, which, low_m, high_m, spacing_m):
    corners, which = _cut(triangles, which, low_m, high_m)
    a, b, c = _longest_first(corners)
    length = np.linalg.norm(b - a, axis=1)
    height = np.linalg.norm(cross(b - a, c - a), axis=1) / np.maximum(length, 1e-9)
    rows = np.where(height > spacing_m / 2, np.ceil(height / spacing_m), 1).astype(np.int64)
    # Chunks of whole triangles; with some to spare, as rows towards the apex are shorter.
    filled = np.cumsum(rows * np.ceil(length / spacing_m + 1)) // _CHUNK
    for chunk in np.split(np.arange(len(which)), np.flatnonzero(np.diff(filled)) + 1):
        triangle = np.repeat(chunk, rows[chunk])
        share = _counted(rows[chunk]) / rows[triangle]
        across = np.ceil((1 - share) * length[triangle] / spacing_m).astype(np.int64)
        across = np.maximum(across, 1)
        along = (_counted(across) + 0.5) / np.repeat(across, across)
        triangle, share = np.repeat(triangle, across), np.repeat(share, across)[:, None]
        foot = a[triangle] + along[:, None] * (b - a)[triangle]
        points = ((1 - share) * foot + share * c[triangle]).astype(np.float32)
        inside = _within(points, points, low_m, high_m)
        yield points[inside], which[triangle[inside]]


def _counted(counts: np.ndarray) -> np.ndarray:
    """0, 1, ... up to each count, one after the other."""
    ends = np.cumsum(counts)
    return np.arange(ends[-1] if len(ends) else 0) - np.repeat(ends - counts, counts)


def _cut(triangles, which, low_m, high_m) -> tuple[np.ndarray, np.ndarray]:
    """Triangles that may reach into the box, large ones as quarters of quarters."""
    done = []
    while len(triangles):
        a, b, c = (triangles[:, k] for k in range(3))
        most, least = (f(f(a, b), c) for f in (np.maximum, np.minimum))
        reaches = _within(most, least, low_m, high_m)
        triangles, which = triangles[reaches], which[reaches]
        # No edge is longer than its box's diagonal.
        small = np.square((most - least)[reaches]) @ np.ones(3) <= _LARGEST_M**2
        done.append((triangles[small], which[small]))
        corners = triangles[~small]
        a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
        d, e, f = (a + b) / 2, (b + c) / 2, (c + a) / 2
        quarters = [(a, d, f), (d, b, e), (f, e, c), (d, e, f)]
        triangles = np.concatenate([np.stack(q, axis=1) for q in quarters])
        which = np.tile(which[~small], 4)
    if not done:
        return np.zeros((0, 3, 3)), np.zeros(0, np.int64)
    return tuple(np.concatenate(x) for x in zip(*done, strict=True))


def _within(most: np.ndarray, least: np.ndarray, low_m, high_m) -> np.ndarray:
    """Whether boxes (n, 3) reach into a box: (n,) bool."""
    reaches = np.ones(len(most), bool)
    for axis in range(3):  # column by column: numpy is slow at reducing rows of three
        reaches &= (most[:, axis] >= low_m[axis]) & (least[:, axis] < high_m[axis])
    return reaches


def _longest_first(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Corners (m, 3) each in float64, the longest edge from the first to the second."""
    corners = corners.astype(np.float64)
    edges = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=-1)
    first = edges.argmax(axis=1) if len(edges) else np.zeros(0, np.int64)
    each = np.arange(len(corners))
    return tuple(corners[each, (first + k) % 3] for k in range(3))
