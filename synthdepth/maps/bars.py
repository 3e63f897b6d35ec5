"""Many bars, boards and rods at once, from arrays of their ends or corners."""

import numpy as np

from synthdepth.maps.geometry import Geometry, cross, geometry, tube

# Faces of a box given as two rings of four corners, counter-clockwise seen from the second.
BOX_FACES = np.array(
    [[0, 1, 5], [0, 5, 4], [1, 2, 6], [1, 6, 5], [2, 3, 7], [2, 7, 6], [3, 0, 4], [3, 4, 7],
     [4, 5, 6], [4, 6, 7], [3, 2, 1], [3, 1, 0]]
)  # fmt: skip


def beams(start, end, width_m, height_m, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """Straight bars of rectangular section, 12 triangles each, grain along v.

    Args:
        start, end: (k, 3) centres of the end faces [m].
        width_m: horizontal side of the section, scalar or (k,).
        height_m: the other side, scalar or (k,).
        tint: (3,) or (k, 3).
    """
    a = np.asarray(start, np.float64).reshape(-1, 3)
    b = np.asarray(end, np.float64).reshape(-1, 3)
    k = len(a)
    length = np.linalg.norm(b - a, axis=1)
    along = (b - a) / length[:, None]
    flat = cross(along, [0, 0, 1.0])
    size = np.linalg.norm(flat, axis=1, keepdims=True)
    flat = np.where(size > 1e-6, flat / np.maximum(size, 1e-6), [1.0, 0, 0])
    up = cross(flat, along)
    w = np.broadcast_to(np.asarray(width_m, np.float64), k)[:, None] / 2 * flat
    h = np.broadcast_to(np.asarray(height_m, np.float64), k)[:, None] / 2 * up
    ring = np.stack([-w - h, w - h, w + h, -w + h], axis=1)
    v = np.concatenate([a[:, None] + ring, b[:, None] + ring], axis=1)
    return prisms(v, length, tint)


def prisms(corners: np.ndarray, length: np.ndarray, tint, faces=BOX_FACES) -> Geometry:
    """Bars from their corners.

    Args:
        corners: (k, n, 3) [m]; the first n // 2 have v = 0, the others v = `length`.
        length: (k,) [m].
        tint: (3,) or (k, 3).
        faces: (m, 3) into the corners of one bar.
    """
    k, n = corners.shape[:2]
    # Each bar on its own strip of the texture.
    across = np.array([0, 0.1, 0.1, 0.0] * 3)[:n] + 0.1 * np.arange(k)[:, None] % 2.0
    uv = np.zeros((k, n, 2))
    uv[..., 0] = across
    uv[:, n // 2 :, 1] = length[:, None]
    c = np.repeat(np.broadcast_to(np.asarray(tint, np.float32), (k, 3)), n, axis=0)
    return geometry(corners, faces[None] + n * np.arange(k)[:, None, None], uv, c)


def round_bars(start, end, radius_m: float, tint=(1.0, 1.0, 1.0), sides: int = 6) -> Geometry:
    """Round rods from `start` to `end`, each (k, 3) or (3,) [m], closed at both ends."""
    a = np.atleast_2d(np.asarray(start, np.float64))
    along = np.atleast_2d(np.asarray(end, np.float64)) - a
    k = len(a)
    unit = tube([[0, 0, 0], [0, 0, 1.0]], radius_m, sides)
    length = np.linalg.norm(along, axis=1, keepdims=True)
    # Any direction across the rod will do; two candidates, so that one is never along it.
    across = np.where(np.abs(along[:, 2:]) > 0.7 * length, [1.0, 0, 0], [0, 0, 1.0])
    side = cross(along, across)
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    other = cross(along, side) / length
    v = np.einsum("kij,nj->kni", np.stack([side, other, along], -1), unit.vertices) + a[:, None]
    uv = np.repeat(unit.uv[None], k, axis=0)
    uv[..., 1] *= length
    faces = unit.faces[None] + len(unit.vertices) * np.arange(k)[:, None, None]
    return geometry(v, faces, uv, tint)
