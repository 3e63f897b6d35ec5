"""Points that cover triangles: every place on a surface is within a known radius of one."""

import numpy as np

CHUNK = 1 << 15  # triangles at a time: a few arrays of them stay in the cache
_LARGE_M = 16.0  # larger triangles are halved first, so that parts outside the box drop out


def _squared(vectors: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i->...", vectors, vectors)


def _turn(corners: np.ndarray) -> np.ndarray:
    """Corners (3, m, 3) of the same triangles, the first two at the longest edge."""
    edges = corners[[1, 2, 0]] - corners
    longest = _squared(edges).argmax(axis=0)
    turn = (longest + np.arange(3)[:, None]) % 3
    return corners[turn, np.arange(corners.shape[1])]


def _lattice(corners: np.ndarray, radius_m: float) -> tuple[np.ndarray, np.ndarray]:
    """`cover` for triangles that one point cannot cover; corners as `_turn` leaves them.

    The cells are parallelograms along the edges that meet at the widest angle. The halves of a
    rectangle so have the same cells, and nearly all of their points coincide.
    """
    a, b, c = corners
    e1, e2 = a - c, b - c
    l1, l2 = np.linalg.norm(e1, axis=1), np.linalg.norm(e2, axis=1)
    cosine = np.abs((e1 * e2).sum(axis=1)) / np.maximum(l1 * l2, 1e-12)
    side = 2 * radius_m / np.sqrt(2 + 2 * np.minimum(cosine, 1))  # longest diagonal 2 radius_m
    n1, n2 = (np.maximum(np.ceil(length / side), 1).astype(np.int32) for length in (l1, l2))
    count = n1 * n2
    top = (np.abs(e1[:, 2]) / n1 + np.abs(e2[:, 2]) / n2) / 2
    points, tops = [], []
    batches = np.searchsorted(np.cumsum(count), np.arange(0, count.sum(), CHUNK << 2))
    for i, j in zip(batches, [*batches[1:], len(count)], strict=True):
        which = np.repeat(np.arange(i, j), count[i:j])
        k = np.arange(len(which)) - np.repeat(np.cumsum(count[i:j]) - count[i:j], count[i:j])
        row, col = np.divmod(k, n2[which])
        touched = row / n1[which] + col / n2[which] < 1
        which, row, col = which[touched], row[touched], col[touched]
        s = ((row + 0.5) / n1[which]).astype(np.float32)[:, None]
        t = ((col + 0.5) / n2[which]).astype(np.float32)[:, None]
        middle = c[which] + s * e1[which] + t * e2[which]
        tops.append(middle[:, 2] + top[which])
        # A middle beyond ab moves to its nearest point of ab, no farther from any point inside.
        beyond = np.flatnonzero((s + t)[:, 0] > 1)
        start, edge = a[which[beyond]], (b - a)[which[beyond]]
        along = ((middle[beyond] - start) * edge).sum(axis=1) / (edge * edge).sum(axis=1)
        middle[beyond] = start + np.clip(along, 0, 1)[:, None] * edge
        points.append(middle)
    return np.concatenate(points), np.concatenate(tops)


def cover(
    corners: np.ndarray, radius_m: float, lower: np.ndarray, upper: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Points (k, 3) that cover triangles within `radius_m`, and the top (k,) of what each covers.

    Args:
        corners: (3, m, 3) float32, first, second and third corners [m].
        radius_m: every point of a triangle inside the box is this near one of its points.
        lower, upper: (3,) float32 corners of the box [m]; no point lies more than `radius_m`
            outside it.
    """
    points, tops = [np.zeros((0, 3), np.float32)], [np.zeros(0, np.float32)]
    rest = [corners[:, i : i + CHUNK] for i in range(0, corners.shape[1], CHUNK)]
    while rest:
        corners = _turn(rest.pop())
        a, b, c = corners
        middle = (a + b) * np.float32(0.5)
        half = _squared(b - middle)
        reach = np.maximum(half, _squared(c - middle))
        done = reach <= radius_m**2
        points.append(middle[done])
        tops.append(np.maximum(np.maximum(a[:, 2], b[:, 2]), c[:, 2])[done])
        large = half > _LARGE_M**2
        lattice = ~done & ~large
        if lattice.any():
            p, z = _lattice(corners[:, lattice], radius_m)
            points.append(p)
            tops.append(z)
        if large.any():
            a, b, c, middle = a[large], b[large], c[large], middle[large]
            halves = np.concatenate([[a, middle, c], [middle, b, c]], axis=1)
            near = (halves.max(axis=0) >= lower) & (halves.min(axis=0) <= upper)
            rest.append(halves[:, near.all(axis=1)])
    points, tops = np.concatenate(points), np.concatenate(tops)
    inside = np.logical_and.reduce(
        [
            (x >= low) & (x <= high)
            for x, low, high in zip(points.T, lower - radius_m, upper + radius_m, strict=True)
        ]
    )
    return points[inside], tops[inside]
