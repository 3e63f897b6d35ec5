"""Quads in wall frames, collected by material and built at once.

In a frame s runs along the wall, n points out of it and z is up; walking along +s the outside is
on the right. Shapes are made for thousands of cells (floor x bay) at a time.
"""

from collections.abc import Iterable, Iterator
from typing import NamedTuple

import numpy as np

from synthdepth.maps.geometry import Geometry, Model, cross, geometry, join

Key = tuple[str, str]


class Quads(NamedTuple):
    """`m` quads for each of `k` things, in their frames.

    Attributes:
        corners: (k, m, 4, 3) s, n, z [m], counter-clockwise seen from outside.
        plane: (m,) int8 which coordinates serve as u and v: 0 s and z, 1 n and z, 2 s and n.
    """

    corners: np.ndarray
    plane: np.ndarray

    def take(self, rows) -> "Quads":
        """The quads of some of the things."""
        return Quads(self.corners[rows], self.plane)


# Numbers of the planes (s, z), (n, z) and (s, n), whose coordinates serve as u and v.
_FRONT, _SIDE, _LEVEL = 0, 1, 2


def quads_of(columns, plane) -> Quads:
    """`Quads` from 12 m columns (s, n, z of each corner), each (k,) or a number."""
    sizes = [c.shape[0] for c in columns if isinstance(c, np.ndarray) and c.ndim]
    out = np.empty((len(columns), max(sizes, default=1)))
    for row, column in zip(out, columns, strict=True):
        row[:] = column
    return Quads(out.T.reshape(-1, len(columns) // 12, 4, 3), np.array(plane, np.int8))


def faces(s0, s1, z0, z1, n=0.0) -> Quads:
    """Rectangles that face outwards."""
    return quads_of((s0, n, z0, s1, n, z0, s1, n, z1, s0, n, z1), [_FRONT])


def ring(s0, s1, z0, z1, t0, t1, y0, y1, n=0.0) -> Quads:
    """What a rectangle t, y leaves of a larger one s, z: left, right, below, above."""
    left = (s0, n, z0, t0, n, z0, t0, n, z1, s0, n, z1)
    right = (t1, n, z0, s1, n, z0, s1, n, z1, t1, n, z1)
    below = (t0, n, z0, t1, n, z0, t1, n, y0, t0, n, y0)
    above = (t0, n, y1, t1, n, y1, t1, n, z1, t0, n, z1)
    return quads_of((*left, *right, *below, *above), [_FRONT] * 4)


def _sides(s0, s1, z0, z1, a, b, parts: str) -> tuple[list, list[int]]:
    """Columns and planes of a box's or a hole's faces."""
    made = {
        "f": lambda: (s0, b, z0, s1, b, z0, s1, b, z1, s0, b, z1),
        "k": lambda: (s1, a, z0, s0, a, z0, s0, a, z1, s1, a, z1),
        "l": lambda: (s0, a, z0, s0, b, z0, s0, b, z1, s0, a, z1),
        "r": lambda: (s1, b, z0, s1, a, z0, s1, a, z1, s1, b, z1),
        "t": lambda: (s0, b, z1, s1, b, z1, s1, a, z1, s0, a, z1),
        "b": lambda: (s0, a, z0, s1, a, z0, s1, b, z0, s0, b, z0),
    }
    columns = [c for part in parts for c in made[part]()]
    return columns, [_PLANES[part] for part in parts]


_PLANES = {"f": _FRONT, "k": _FRONT, "l": _SIDE, "r": _SIDE, "t": _LEVEL, "b": _LEVEL}


def tunnel(s0, s1, z0, z1, outer, inner, parts: str = "lrtb") -> Quads:
    """Sides of a hole from n = `outer` in to `inner`; swap the two for those of a block.

    `parts` are some of l(eft), r(ight), t(op) and b(ottom).
    """
    return quads_of(*_sides(s0, s1, z0, z1, outer, inner, parts))


def block(s0, s1, z0, z1, n0, n1, parts: str = "flrtb") -> Quads:
    """Boxes from n0 out to n1.

    `parts` are some of f(ront), l(eft), r(ight), t(op), b(ottom) and k (the back).
    """
    return quads_of(*_sides(s0, s1, z0, z1, n0, n1, parts))


def slopes(s0, s1, n0, z0, n1, z1) -> Quads:
    """Rectangles that lean: lower edge at (n0, z0), upper edge at (n1, z1)."""
    return quads_of((s0, n0, z0, s1, n0, z0, s1, n1, z1, s0, n1, z1), [_FRONT])


class Panels:
    """A growing set of quads by (material, label), in the frames of a building's walls.

    Attributes:
        frames: (w, 4) foot and unit direction of each wall, x, y, dx, dy [m].
    """

    def __init__(self, frames: np.ndarray) -> None:
        self.frames = np.asarray(frames, np.float64).reshape(-1, 4)
        self._numbers: dict[Key, int] = {}
        self._lots: list[tuple] = []
        self._parts: dict[Key, list[tuple[np.ndarray, np.ndarray, np.ndarray]]] = {}
        self._extra: list[tuple[Key, Geometry]] = []
        self._rods: dict[tuple[Key, int], list[tuple[np.ndarray, ...]]] = {}

    def add(
        self, key: Key, tint, quads: Quads, wall, shade=None, uv_shift=None, where=None
    ) -> None:
        """Add quads in the frames `wall`, (k,) or one number.

        Args:
            key: (material, label).
            tint: (3,), (k, 3) or (k, m, 3).
            quads: what.
            wall: which frame.
            shade: (4,) or (k, m, 4) multipliers of the corners' tint, or none.
            uv_shift: (k, 2) added to the texture coordinates [m], instead of each wall's own.
            where: (k,) bool, which of them; all when none.
        """
        if where is not None:
            quads = quads.take(where)
            tint, shade, uv_shift = (
                a[where] if np.ndim(a) > 1 and len(a) > 1 else a for a in (tint, shade, uv_shift)
            )
            wall = wall[where] if np.ndim(wall) else wall
        k = len(quads.corners)
        if k:
            number = self._numbers.setdefault(key, len(self._numbers))
            self._lots.append((number, k, quads, wall, tint, shade, uv_shift))

    def add_frame(self, origin, direction) -> int:
        """Number of a new frame at `origin` (2,) along the unit vector `direction` (2,)."""
        self.frames = np.vstack([self.frames, [*origin, *direction]])
        return len(self.frames) - 1

    def frames_of(self, polygon: np.ndarray) -> int:
        """Number of the first of new frames, one for each edge of a polygon (n, 2)."""
        along = np.roll(polygon, -1, axis=0) - polygon
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        self.frames = np.vstack([self.frames, np.column_stack([polygon, along])])
        return len(self.frames) - len(polygon)

    def in_world(self, quads: Quads, wall) -> np.ndarray:
        """(k, m, 4, 3) corners of quads of the frames `wall`, (k,) or one, in the world."""
        c = quads.corners
        x, y, dx, dy = np.moveaxis(self.frames[np.broadcast_to(wall, len(c))], 1, 0)[
            ..., None, None
        ]
        s, n = c[..., 0], c[..., 1]
        return np.stack([x + s * dx + n * dy, y + s * dy - n * dx, c[..., 2]], -1)

    def add_world(self, key: Key, corners, uv, tint) -> None:
        """Add quads (k, 4, 3) in world coordinates, uv (k, 4, 2), tint (k, 4, 3) or less."""
        t = np.broadcast_to(np.asarray(tint, np.float32), corners.shape)
        self._parts.setdefault(key, []).append((corners, uv, t))

    def add_geometry(self, key: Key, part: Geometry) -> None:
        """Add what is no quad: rods, tanks, wires, in world coordinates."""
        self._extra.append((key, part))

    def rods(self, key: Key, tint, start, stop, radius_m: float, sides: int = 5) -> None:
        """Round rods between points (k, 3) in world coordinates, closed at both ends."""
        a, b = np.atleast_2d(start), np.atleast_2d(stop)
        row = np.broadcast_to(np.array([*tint, radius_m]), (len(a), 4))
        self._rods.setdefault((key, sides), []).append((a, b, row))

    def model(self) -> Model:
        """Everything collected; what has no area is left out."""
        parts: dict[Key, list[Geometry]] = {}
        for key, part in self._framed():
            parts.setdefault(key, []).append(part)
        for key, lots in self._parts.items():
            corners, uv, tint = (np.concatenate(a) for a in zip(*lots, strict=True))
            parts.setdefault(key, []).append(_geometry(corners.astype(np.float32), uv, tint))
        for key, part in self._extra:
            parts.setdefault(key, []).append(part)
        for (key, sides), lots in self._rods.items():
            parts.setdefault(key, []).append(
                _rods(*(np.concatenate(a) for a in zip(*lots, strict=True)), sides)
            )
        return {key: join(lots) for key, lots in parts.items() if any(len(g.faces) for g in lots)}

    def _framed(self) -> Iterator[tuple[Key, Geometry]]:
        """Everything that was added in frames, one geometry for each (material, label)."""
        # In the order of their keys, so that each key's quads lie together.
        lots = sorted(self._lots, key=lambda lot: lot[0])
        count = sum(k * len(quads.plane) for _, k, quads, *_ in lots)
        c = np.empty((count, 4, 3))
        wall, plane = np.empty(count, int), np.empty(count, np.int8)
        shift, tint = np.empty((count, 2)), np.empty((count, 4, 3), np.float32)
        stops = np.zeros(len(self._numbers), int)
        start = 0
        for number, k, quads, w, colour, shade, uv_shift in lots:
            m = len(quads.plane)
            part = slice(start, start + k * m)
            c[part].reshape(k, m, 4, 3)[:] = quads.corners
            w = np.asarray(w)
            wall[part].reshape(k, m)[:] = w[:, None] if w.ndim else w
            plane[part].reshape(k, m)[:] = quads.plane
            # Each wall starts elsewhere in the texture.
            shift[part] = 0.0
            if uv_shift is None:
                shift[part, 0] = 3.7 * wall[part]
            else:
                shift[part].reshape(k, m, 2)[:] = uv_shift[:, None]
            colour = np.asarray(colour, np.float32)
            colour = colour[:, None] if colour.ndim == 2 else colour
            t = tint[part].reshape(k, m, 4, 3)
            t[:] = colour[..., None, :]
            if shade is not None:
                t *= np.asarray(shade, np.float32)[..., None]
            start = stops[number] = part.stop
        x, y, dx, dy = self.frames[wall].T[..., None]
        s, n = c[..., 0], c[..., 1]
        p = np.empty((count, 4, 3), np.float32)
        p[..., 0] = x + s * dx + n * dy
        p[..., 1] = y + s * dy - n * dx
        p[..., 2] = c[..., 2]
        u = np.where((plane == _SIDE)[:, None], n, s) + shift[:, :1]
        v = np.where((plane == _LEVEL)[:, None], n, c[..., 2]) + shift[:, 1:]
        uv = np.stack([u, v], axis=-1).astype(np.float32)
        start = 0
        for key, stop in zip(self._numbers, stops, strict=True):
            yield key, _geometry(p[start:stop], uv[start:stop], tint[start:stop])
            start = stop


_AREA_M2 = 1e-6


def _geometry(p: np.ndarray, uv: np.ndarray, tint: np.ndarray) -> Geometry:
    """Quads (k, 4, 3) as triangles, two and two; those without area are left out."""
    a, c = p[:, 1] - p[:, 0], p[:, 3] - p[:, 0]
    b = p[:, 2] - p[:, 0]
    first, second = _cross2(a, b) > 4 * _AREA_M2**2, _cross2(b, c) > 4 * _AREA_M2**2
    keep = first | second
    p, first, second = p[keep], first[keep], second[keep]
    start = 4 * np.arange(len(p), dtype=np.int32)[:, None]
    pairs = (start + np.array([0, 1, 2, 0, 2, 3], np.int32)).reshape(-1, 2, 3)
    order = pairs[np.stack([first, second], axis=1)]
    return Geometry(
        np.ascontiguousarray(p.reshape(-1, 3)),
        np.ascontiguousarray(order),
        np.ascontiguousarray(uv[keep].reshape(-1, 2), np.float32),
        np.ascontiguousarray(tint[keep].reshape(-1, 3), np.float32),
    )


def _rods(a: np.ndarray, b: np.ndarray, row: np.ndarray, sides: int) -> Geometry:
    """Rods from a to b (k, 3); `row` (k, 4) holds tints and radii."""
    along = b - a
    length = np.linalg.norm(along, axis=1, keepdims=True)
    across = np.where(np.abs(along[:, 2:]) > 0.7 * length, [1.0, 0, 0], [0, 0, 1.0])
    u = cross(along, across)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = cross(along / length, u)
    turn = 2 * np.pi * np.arange(sides) / sides
    radius = row[:, 3, None, None]
    rim = radius * (np.cos(turn)[:, None] * u[:, None] + np.sin(turn)[:, None] * v[:, None])
    points = np.concatenate([a[:, None] + rim, b[:, None] + rim], axis=1)
    i = np.arange(sides)
    j = (i + 1) % sides
    fan = np.arange(1, sides - 1)
    zero = np.zeros_like(fan)
    faces_of_one = np.concatenate(
        [
            np.stack([i, j, j + sides], 1),
            np.stack([i, j + sides, i + sides], 1),
            np.stack([zero, fan + 1, fan], 1),
            np.stack([zero + sides, fan + sides, fan + 1 + sides], 1),
        ]
    )
    k = len(a)
    uv = np.zeros((k, 2 * sides, 2))
    uv[..., 0] = np.tile(turn, 2) * row[:, 3:]
    uv[:, sides:, 1] = length
    return geometry(
        points,
        faces_of_one[None] + 2 * sides * np.arange(k)[:, None, None],
        uv,
        np.repeat(row[:, :3], 2 * sides, axis=0),
    )


def _cross2(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Squared length of a x b."""
    x = a[:, 1] * b[:, 2] - a[:, 2] * b[:, 1]
    y = a[:, 2] * b[:, 0] - a[:, 0] * b[:, 2]
    z = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return x * x + y * y + z * z


def mitres(polygon: np.ndarray) -> np.ndarray:
    """(n, 2) how far each corner of a CCW polygon (n, 2) moves when its edges move out by 1 m."""
    normal = outward(polygon)
    before = np.roll(normal, 1, axis=0)
    return (normal + before) / (1 + (normal * before).sum(1, keepdims=True))


def outward(polygon: np.ndarray) -> np.ndarray:
    """(n, 2) outward unit normals of the edges i -> i+1 of a CCW polygon."""
    along = np.roll(polygon, -1, axis=0) - polygon
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return np.stack([along[:, 1], -along[:, 0]], axis=1)


def sweep(
    panels: Panels, key: Key, tint, polygon: np.ndarray, profile: Iterable, edges=None, shade=None
) -> None:
    """A profile drawn along the edges of a polygon: cornice, parapet, kerb.

    Corners are mitred where both edges carry it; elsewhere it is cut square and closed.

    Args:
        panels: where to.
        key: (material, label).
        tint: (3,).
        polygon: (n, 2) CCW [m].
        profile: (k, 2) steps (out, z) [m], the surface on the right of the path seen from its
            start: upwards for an outer face.
        edges: (n,) bool, which carry it; all when none.
        shade: (k,) multipliers of the tint along the profile, or none.
    """
    n = len(polygon)
    profile = np.asarray(list(profile), np.float64)
    edges = np.ones(n, bool) if edges is None else np.asarray(edges, bool)
    normal, corner = outward(polygon), mitres(polygon)
    shade = np.ones(len(profile)) if shade is None else np.asarray(shade, np.float64)
    reach = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    i = np.flatnonzero(edges)
    j = (i + 1) % n
    before, after = edges[i - 1], edges[j]
    start = np.where(before[:, None], corner[i], normal[i])
    stop = np.where(after[:, None], corner[j], normal[i])
    a = np.empty((len(i), len(profile), 3))
    b = np.empty_like(a)
    for end, foot, direction in ((a, polygon[i], start), (b, polygon[j], stop)):
        end[..., :2] = foot[:, None] + profile[:, :1] * direction[:, None]
        end[..., 2] = profile[:, 1]
    p = np.stack([a[:, :-1], b[:, :-1], b[:, 1:], a[:, 1:]], axis=2)
    uv = np.empty((*p.shape[:3], 2))
    length = np.linalg.norm(polygon[j] - polygon[i], axis=1)[:, None, None]
    uv[..., 0] = 5.3 * i[:, None, None] + length * [0, 1, 1, 0]
    uv[..., 1] = profile[0, 1] + np.stack([reach[:-1], reach[:-1], reach[1:], reach[1:]], 1)
    t = np.stack([shade[:-1], shade[:-1], shade[1:], shade[1:]], 1)[..., None] * tint
    t = np.broadcast_to(t, p.shape)
    panels.add_world(key, p.reshape(-1, 4, 3), uv.reshape(-1, 4, 2), t.reshape(-1, 4, 3))
    if not np.ptp(profile[:, 0]):
        return
    # Ends that stand free are closed towards the wall's own plane.
    for k in np.flatnonzero(~before | ~after):
        for free, end, at, flip in ((~before[k], a[k], i[k], 1), (~after[k], b[k], j[k], -1)):
            if free:
                foot = end.copy()
                foot[:, :2] = polygon[at]
                cap = np.stack([foot[:-1], end[:-1], end[1:], foot[1:]], 1)[:, ::flip]
                cap_uv = np.stack([cap[..., 2], cap[..., 2] * 0 + [0, 1, 1, 0]], -1)
                panels.add_world(key, cap, cap_uv, tint)


def cover(panels: Panels, key: Key, tint, polygon: np.ndarray, z: float) -> None:
    """A level surface (roof, slab, terrace) over a convex polygon (n, 2) [m]."""
    n = len(polygon)
    p = np.column_stack([polygon, np.full(n, z)])
    for k in range(1, n - 1, 2):
        corners = p[[0, k, k + 1, min(k + 2, n - 1)]]
        panels.add_world(key, corners[None], corners[None, :, :2] - polygon[0], np.float32(tint))
