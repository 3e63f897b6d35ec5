"""Triangle geometry in numpy: the one mesh type of the maps, the primitives, and copies.

Everything is built from arrays: thousands of leaves, windows or fence posts are one call, never a
Python loop over objects.
"""

import dataclasses
from collections.abc import Iterable, Mapping

import numpy as np


@dataclasses.dataclass(frozen=True)
class Geometry:
    """Triangles with texture coordinates and a colour multiplier.

    Attributes:
        vertices: (n, 3) float32 [m].
        faces: (m, 3) int32 into `vertices`, counter-clockwise seen from outside.
        uv: (n, 2) float32 texture coordinates in **metres** along the surface, v up; the material
            knows how many metres its texture spans.
        tint: (n, 3) float32 linear RGB, multiplies the material's texture.
    """

    vertices: np.ndarray
    faces: np.ndarray
    uv: np.ndarray
    tint: np.ndarray

    @property
    def triangles(self) -> np.ndarray:
        """(m, 3, 3) float32 corners [m]."""
        return self.vertices[self.faces]

    def tinted(self, tint) -> "Geometry":
        """The same geometry, its tint multiplied by `tint` (3,) or (n, 3)."""
        tinted = (self.tint * np.asarray(tint, np.float32)).astype(np.float32)
        return dataclasses.replace(self, tint=tinted)

    def moved(self, offset) -> "Geometry":
        """The same geometry, shifted by `offset` (3,) or (n, 3) [m]."""
        vertices = (self.vertices + np.asarray(offset, np.float64)).astype(np.float32)
        return dataclasses.replace(self, vertices=vertices)


# A thing in its own frame (origin on the ground below it, z up, x forward):
# its geometry by (material, label).
Model = Mapping[tuple[str, str], Geometry]


def cross(a, b) -> np.ndarray:
    """Cross products (..., 3) of vectors (..., 3).

    `np.cross` spends longer on its arguments than on a few hundred products.
    """
    a, b = np.asarray(a), np.asarray(b)
    x, y, z = a[..., 0], a[..., 1], a[..., 2]
    u, v, w = b[..., 0], b[..., 1], b[..., 2]
    first = y * w - z * v
    out = np.empty((*first.shape, 3), first.dtype)
    out[..., 0], out[..., 1], out[..., 2] = first, z * u - x * w, x * v - y * u
    return out


def geometry(vertices, faces, uv=None, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """A `Geometry` from anything array-like; `uv` defaults to x, y and `tint` is broadcast."""
    v = np.ascontiguousarray(vertices, np.float32).reshape(-1, 3)
    f = np.ascontiguousarray(faces, np.int32).reshape(-1, 3)
    t = v[:, :2] if uv is None else np.asarray(uv, np.float32).reshape(-1, 2)
    c = np.empty((len(v), 3), np.float32)
    c[:] = tint
    return Geometry(v, f, np.ascontiguousarray(t), c)


def join(parts: Iterable[Geometry]) -> Geometry:
    """All parts as one geometry; of nothing, an empty one."""
    parts = [p for p in parts if len(p.faces)]
    if not parts:
        return geometry(np.zeros((0, 3)), np.zeros((0, 3)))
    starts = np.cumsum([0] + [len(p.vertices) for p in parts[:-1]])
    return Geometry(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.faces + np.int32(s) for p, s in zip(parts, starts, strict=True)]),
        np.concatenate([p.uv for p in parts]),
        np.concatenate([p.tint for p in parts]),
    )


def merge(models: Iterable[Model]) -> dict[tuple[str, str], Geometry]:
    """All models as one, joined by (material, label)."""
    parts: dict[tuple[str, str], list[Geometry]] = {}
    for model in models:
        for key, part in model.items():
            parts.setdefault(key, []).append(part)
    return {key: join(part) for key, part in parts.items()}


def yaw_matrix(yaw_rad) -> np.ndarray:
    """Rotations about +Z: (..., 3, 3) float64."""
    yaw = np.asarray(yaw_rad, np.float64)
    c, s, o, i = np.cos(yaw), np.sin(yaw), np.zeros_like(yaw), np.ones_like(yaw)
    return np.stack(
        [np.stack([c, -s, o], -1), np.stack([s, c, o], -1), np.stack([o, o, i], -1)], -2
    )


def copies(part: Geometry, position, *, rotation=None, scale=1.0, tint=None) -> Geometry:
    """`k` transformed copies of a geometry as one.

    Args:
        part: the geometry, n vertices.
        position: (k, 3) [m].
        rotation: (k, 3, 3), or none.
        scale: scalar, (k,) or (k, 3), applied before the rotation. `uv` is left as it is.
        tint: (k, 3) colour multipliers, or none.
    """
    position = np.asarray(position, np.float32).reshape(-1, 3)
    k, n = len(position), len(part.vertices)
    scale = np.asarray(scale, np.float32)
    v = part.vertices[None]
    if scale.ndim or scale != 1:
        scale = np.broadcast_to(scale[:, None] if scale.ndim == 1 else scale, (k, 3))
        v = v * scale[:, None, :]
    if rotation is not None:
        v = v @ np.asarray(rotation, np.float32).transpose(0, 2, 1)
    v = v + position[:, None, :]
    f = part.faces[None] + (np.arange(k, dtype=np.int32) * np.int32(n))[:, None, None]
    c = np.empty((k, n, 3), np.float32)
    c[:] = part.tint
    if tint is not None:
        c *= np.asarray(tint, np.float32).reshape(k, 1, 3)
    uv = np.empty((k, n, 2), np.float32)
    uv[:] = part.uv
    return Geometry(
        np.ascontiguousarray(v.reshape(-1, 3), np.float32),
        f.reshape(-1, 3).astype(np.int32),
        uv.reshape(-1, 2),
        c.reshape(-1, 3),
    )


def place(model: Model, position, yaw_rad=0.0) -> dict[tuple[str, str], Geometry]:
    """One model set down at `position` (3,) [m], turned by `yaw_rad` about +Z."""
    rotation = yaw_matrix(yaw_rad)[None]
    at = np.asarray(position, np.float64)[None]
    return {key: copies(part, at, rotation=rotation) for key, part in model.items()}


def quads(corners, tint=(1.0, 1.0, 1.0), uv_origin=(0.0, 0.0)) -> Geometry:
    """`k` quadrilaterals, two triangles each.

    Args:
        corners: (k, 4, 3) [m], counter-clockwise seen from outside: lower left, lower right, upper
            right, upper left.
        tint: (3,) or (k, 3).
        uv_origin: (2,) or (k, 2), texture coordinates [m] of the first corner. u runs along the
            first edge, v along the last.
    """
    p = np.asarray(corners, np.float64).reshape(-1, 4, 3)
    k = len(p)
    width = np.linalg.norm(p[:, 1] - p[:, 0], axis=1)
    height = np.linalg.norm(p[:, 3] - p[:, 0], axis=1)
    uv = np.zeros((k, 4, 2))
    uv[:, 1:3, 0] = width[:, None]
    uv[:, 2:, 1] = height[:, None]
    uv += np.asarray(uv_origin, np.float64)[..., None, :]
    faces = 4 * np.arange(k)[:, None] + [0, 1, 2, 0, 2, 3]
    c = np.empty((k, 4, 3), np.float32)
    c[:] = np.asarray(tint, np.float32)[..., None, :]
    return geometry(p, faces, uv, c.reshape(-1, 3))


def box(size, base=(0.0, 0.0, 0.0), tint=(1.0, 1.0, 1.0)) -> Geometry:
    """A box of `size` (3,) [m], its base rectangle centred on `base` (3,) [m]; 12 triangles."""
    x, y, z = np.asarray(size, np.float64) / [2, 2, 1]
    ring = np.array([[-x, -y], [x, -y], [x, y], [-x, y]])
    low = np.column_stack([ring, np.zeros(4)])
    high = np.column_stack([ring, np.full(4, z)])
    nxt = [1, 2, 3, 0]
    sides = np.stack([low, low[nxt], high[nxt], high], axis=1)
    faces = np.concatenate([sides, high[None], low[None, ::-1]])
    return quads(faces + np.asarray(base, np.float64), tint)


def tube(path, radius, sides: int = 6, tint=(1.0, 1.0, 1.0), capped: bool = True) -> Geometry:
    """A round bar along a polyline: pole, pipe, wire, trunk.

    Args:
        path: (k, 3) [m], k >= 2.
        radius: scalar or (k,) [m].
        sides: corners of the cross section.
        tint: (3,).
        capped: close both ends.
    """
    p = np.asarray(path, np.float64)
    r = np.broadcast_to(np.asarray(radius, np.float64), len(p))
    along = np.gradient(p, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # A fixed reference, not a Frenet frame, which flips where a path is straight.
    reference = np.eye(3)[np.argmin(np.abs(along).max(axis=0))]
    a = cross(along, reference)
    a /= np.linalg.norm(a, axis=1, keepdims=True)
    b = cross(along, a)
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    ring = np.cos(turn)[None, :, None] * a[:, None] + np.sin(turn)[None, :, None] * b[:, None]
    v = (p[:, None] + r[:, None, None] * ring).reshape(-1, 3)
    length = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
    u = np.broadcast_to(turn[None] * r.mean(), (len(p), sides + 1))
    uv = np.stack([u, np.broadcast_to(length[:, None], u.shape)], -1).reshape(-1, 2)
    row, col = np.meshgrid(np.arange(len(p) - 1), np.arange(sides), indexing="ij")
    i = (row * (sides + 1) + col).ravel()
    j = i + sides + 1
    f = np.concatenate([np.stack([i, i + 1, j + 1], 1), np.stack([i, j + 1, j], 1)])
    if capped:
        fan = np.arange(1, sides - 1)
        end = (len(p) - 1) * (sides + 1)
        start_cap = np.stack([np.zeros_like(fan), fan + 1, fan], 1)
        end_cap = np.stack([np.full_like(fan, end), end + fan, end + fan + 1], 1)
        f = np.concatenate([f, start_cap, end_cap])
    return geometry(v, f, uv, tint)


def vertex_normals(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Area-weighted unit vertex normals (n, 3) float32; +Z where a vertex has no area."""
    tri = vertices[faces].astype(np.float64)
    face = cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    normals = np.stack(
        [
            np.bincount(faces.ravel(), np.repeat(face[:, axis], 3), minlength=len(vertices))
            for axis in range(3)
        ],
        axis=1,
    )
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.where(length > 0, normals / np.maximum(length, 1e-30), [0, 0, 1.0]).astype(np.float32)
