"""Fences, low walls and gates along a polyline draped on the ground.

A fence is unrolled: s along the path, v up, w out of its face (to the left of the path). Boards,
posts and wires are placed in (s, v, w) as arrays and mapped to the world at once.
"""

import dataclasses
from collections.abc import Callable

import numpy as np

from synthdepth.maps.bars import BOX_FACES, beams, prisms, round_bars
from synthdepth.maps.geometry import Geometry, box, copies, geometry, join, place, yaw_matrix

Surfaces = dict[tuple[str, str], Geometry]
_LABEL = "barrier"
_POST_SPACING_M = 2.4
_LEAN_DEG = 1.0


@dataclasses.dataclass(frozen=True)
class _Run:
    """A fence's path cut into panels of up to 2.4 m, with a lean at every post.

    Attributes:
        posts: (n + 1, 3) feet of the posts [m].
        lean: (n + 1,) outward shift per metre of height.
        normal: (n, 3) of each panel, unit, horizontal, to the left of the path.
        length: (n,) of each panel [m].
    """

    posts: np.ndarray
    lean: np.ndarray
    normal: np.ndarray
    length: np.ndarray

    def at(self, panel, s, v, w) -> np.ndarray:
        """World points (..., 3) of panel indices, distance s along the panel, v and w [m]."""
        t = (s / self.length[panel])[..., None]
        foot = self.posts[panel] + t * (self.posts[panel + 1] - self.posts[panel])
        lean = self.lean[panel] + t[..., 0] * (self.lean[panel + 1] - self.lean[panel])
        out = foot + (w + v * lean)[..., None] * self.normal[panel]
        out[..., 2] += v
        return out

    def along_panels(self, spacing_m: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Panel index, s and pitch, (m,) each, of things set evenly about `spacing_m` apart."""
        count = np.maximum(np.round(self.length / spacing_m), 1).astype(int)
        panel = np.repeat(np.arange(len(count)), count)
        index = np.arange(len(panel)) - np.repeat(np.cumsum(count) - count, count)
        pitch = (self.length / count)[panel]
        return panel, (index + 0.5) * pitch, pitch

    def uprights(
        self, panel, s, half_m, v0, v1, w0, w1, tint, pointed_m=0.0, sheet=False
    ) -> Geometry:
        """Boards standing in the fence between w0 and w1; with a point above v1, or flat.

        `sheet` leaves only one face of each, for fences that are never seen from near.
        """
        k = len(panel)
        v0, v1, w0, w1, half = (
            np.broadcast_to(np.asarray(x, float), k) for x in (v0, v1, w0, w1, half_m)
        )
        ds = np.stack([s + half, s - half, s - half, s + half], 1)
        dw = np.stack([w1, w1, w0, w0], 1)
        p = panel[:, None]
        if sheet:
            ds = np.stack([s + half, s - half, s - half, s, s + half], 1)
            v = np.stack([v0, v0, v1, v1 + pointed_m, v1], 1)
            corners = self.at(p, ds, v, np.repeat(w1[:, None], 5, 1))
            faces = np.array([[0, 1, 2], [0, 2, 4], [2, 3, 4]])
            if not pointed_m:
                corners, faces = corners[:, [0, 1, 2, 4]], np.array([[0, 1, 2], [0, 2, 3]])
            return prisms(corners, v1 - v0, tint, faces)
        low = self.at(p, ds, np.repeat(v0[:, None], 4, 1), dw)
        high = self.at(p, ds, np.repeat(v1[:, None], 4, 1), dw)
        if not pointed_m:
            # The end in the ground stays open.
            return prisms(np.concatenate([low, high], 1), v1 - v0, tint, BOX_FACES[:10])
        tip = self.at(p, s[:, None], (v1 + pointed_m)[:, None], ((w0 + w1) / 2)[:, None])
        faces = np.concatenate([BOX_FACES[:8], [[4, 5, 8], [5, 6, 8], [6, 7, 8], [7, 4, 8]]])
        return prisms(np.concatenate([low, high, tip], 1), v1 - v0, tint, faces)

    def rails(self, v, w, width_m: float, height_m: float, tint) -> Geometry:
        """Bars from post to post at each height of `v` (r,)."""
        n = len(self.length)
        panel = np.tile(np.arange(n), len(v))
        height = np.repeat(np.asarray(v, float), n)
        o = np.full(len(panel), float(w))
        a = self.at(panel, np.zeros(len(panel)), height, o)
        b = self.at(panel, self.length[panel], height, o)
        return beams(a, b, width_m, height_m, tint)

    def post_feet(self) -> tuple[np.ndarray, np.ndarray]:
        """Panel and s of every post."""
        n = len(self.length)
        panel = np.minimum(np.arange(n + 1), n - 1)
        return panel, np.where(np.arange(n + 1) < n, 0.0, self.length[-1])


def _run(rng: np.random.Generator, path: np.ndarray, spacing_m: float) -> _Run:
    p = np.asarray(path, np.float64).reshape(-1, 3)
    leg = np.linalg.norm(np.diff(p[:, :2], axis=0), axis=1)
    p = p[np.concatenate([[True], leg > 0.05])]
    if len(p) < 2:
        raise ValueError("a fence's path needs 2 different points or more")
    leg = np.linalg.norm(np.diff(p[:, :2], axis=0), axis=1)
    count = np.maximum(np.ceil(leg / spacing_m - 0.05), 1).astype(int)
    which = np.repeat(np.arange(len(count)), count)
    index = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    t = (index / count[which])[:, None]
    posts = np.concatenate([p[which] + t * (p[which + 1] - p[which]), p[-1:]])
    step = np.diff(posts, axis=0)
    length = np.linalg.norm(step[:, :2], axis=1)
    normal = np.column_stack([-step[:, 1], step[:, 0], np.zeros(len(step))]) / length[:, None]
    lean = np.tan(np.radians(np.clip(rng.normal(0, 0.6, len(posts)), -_LEAN_DEG, _LEAN_DEG)))
    return _Run(posts, lean, normal, length)


def _wood_tint(rng: np.random.Generator) -> np.ndarray:
    """Fresh pine, red cedar stain, or silvered by weather."""
    tints = np.array([[0.36, 0.25, 0.14], [0.24, 0.13, 0.075], [0.29, 0.265, 0.235]])
    return tints[rng.integers(3)] * rng.uniform(0.8, 1.15)


def _varied(rng: np.random.Generator, tint, count: int, spread: float) -> np.ndarray:
    return np.asarray(tint) * np.clip(rng.normal(1, spread, (count, 1)), 0.6, 1.4)


def _picket(rng: np.random.Generator, path: np.ndarray, height: float, detail: int) -> Surfaces:
    run = _run(rng, path, _POST_SPACING_M)
    white = rng.random() < 0.65
    tint = np.array([0.68, 0.68, 0.65]) if white else _wood_tint(rng)
    panel, s, _ = run.along_panels(0.125)
    n = len(panel)
    top = height - 0.06 + rng.normal(0, 0.004, n)
    boards = run.uprights(
        panel,
        s,
        0.036,
        0.06,
        top,
        0.028,
        0.048,
        _varied(rng, tint, n, 0.05),
        pointed_m=0.06,
        sheet=not detail,
    )
    rails = run.rails([0.28, height - 0.25], 0.0, 0.052, 0.07, tint * 0.95)
    post, at = run.post_feet()
    posts = run.uprights(post, at, 0.045, -0.15, height + 0.04, -0.045, 0.045, tint, pointed_m=0.03)
    return {("paint" if white else "wood", _LABEL): join([boards, rails, posts])}


def _board(rng: np.random.Generator, path: np.ndarray, height: float, detail: int) -> Surfaces:
    run = _run(rng, path, _POST_SPACING_M)
    tint = _wood_tint(rng)
    panel, s, pitch = run.along_panels(0.15)
    n = len(panel)
    # Every second board on the far side of the rails in a "good neighbour" fence.
    both_sides = rng.random() < 0.3
    far = (np.arange(n) % 2 == 1) & both_sides
    w0 = np.where(far, -0.045, 0.026)
    half = pitch / 2 + (0.012 if both_sides else -0.004)
    top = height + rng.normal(0, 0.007, n)
    boards = run.uprights(
        panel, s, half, 0.04, top, w0, w0 + 0.019, _varied(rng, tint, n, 0.1), sheet=not detail
    )
    rails = run.rails([0.3, height / 2, height - 0.25], 0.0, 0.05, 0.09, tint * 0.9)
    post, at = run.post_feet()
    posts = run.uprights(
        post, at, 0.05, -0.15, height + 0.05, -0.075, 0.025, _varied(rng, tint, len(post), 0.08)
    )
    return {("wood", _LABEL): join([boards, rails, posts])}


def _post_and_rail(
    rng: np.random.Generator, path: np.ndarray, height: float, _detail: int
) -> Surfaces:
    run = _run(rng, path, 2.7)
    tint = _wood_tint(rng)
    count = 3 if height > 1.0 else 2
    levels = np.linspace(0.3, height - 0.12, count)
    rails = run.rails(levels, 0.0, 0.045, 0.13, tint)
    post, at = run.post_feet()
    posts = run.uprights(
        post, at, 0.065, -0.15, height, -0.065, 0.065, _varied(rng, tint, len(post), 0.1),
        pointed_m=0.03,
    )  # fmt: skip
    return {("wood", _LABEL): join([rails, posts])}


_MESH_SPACING_M = 0.15
_MESH_WIRE_M = 0.0045


def _chain_link(rng: np.random.Generator, path: np.ndarray, height: float, detail: int) -> Surfaces:
    """Coarse diamonds of flat wires: about the sight-through of a real 50 mm mesh of 3 mm wire."""
    run = _run(rng, path, 3.0)
    grey = np.array([0.30, 0.31, 0.31]) if rng.random() < 0.7 else np.array([0.02, 0.05, 0.03])
    coarser = 1 if detail else 2  # the same share of the sight blocked by fewer wires
    spacing, wire = coarser * _MESH_SPACING_M, coarser * _MESH_WIRE_M
    low, high = 0.04, height - 0.04
    rise = high - low
    count = np.ceil((run.length + rise) / spacing).astype(int)
    panel = np.repeat(np.arange(len(count)), count)
    index = np.arange(len(panel)) - np.repeat(np.cumsum(count) - count, count)
    shift = (index + 0.5) * spacing - rise  # s where the wire leaves the bottom
    s0, s1 = np.maximum(shift, 0), np.minimum(shift + rise, run.length[panel])
    keep = s1 - s0 > 0.02
    panel, shift, s0, s1 = panel[keep], shift[keep], s0[keep], s1[keep]
    strips = []
    for side in (1, -1):
        a = s0 if side > 0 else run.length[panel] - s0
        b = s1 if side > 0 else run.length[panel] - s1
        va, vb = low + s0 - shift, low + s1 - shift
        w = np.full(len(a), 0.032 + 0.003 * side)
        # A ribbon in the plane of the mesh, widened across its run.
        d = wire / 2 * np.sqrt(0.5)
        ring = [
            run.at(panel, np.clip(x + i * side * d, 0, run.length[panel]), v - i * d, w)
            for x, v, i in ((a, va, 1), (b, vb, 1), (b, vb, -1), (a, va, -1))
        ]
        corners = np.stack(ring, axis=1)
        k = len(corners)
        strips.append(
            geometry(
                corners,
                np.array([[0, 1, 2], [0, 2, 3]])[None] + 4 * np.arange(k)[:, None, None],
                np.tile([[0, 0], [1, 0], [1, 0.01], [0, 0.01]], (k, 1)),
                grey,
            )
        )
    post, at = run.post_feet()
    feet = run.at(post, at, np.full(len(post), -0.12), np.zeros(len(post)))
    tops = run.at(post, at, np.full(len(post), height + 0.05), np.zeros(len(post)))
    posts = round_bars(feet, tops, 0.03, grey)
    n = len(run.length)
    rail = [
        run.at(np.arange(n), s, np.full(n, height), np.zeros(n))
        for s in (0 * run.length, run.length)
    ]
    return {("paint", _LABEL): join([*strips, posts, round_bars(*rail, 0.021, grey)])}


def _wall(rng: np.random.Generator, path: np.ndarray, height: float, _detail: int) -> Surfaces:
    """A brick wall with a coping and a pier at every bend and end."""
    run = _run(rng, path, 6.0)
    run = dataclasses.replace(run, lean=np.zeros_like(run.lean))
    tint = np.array([[0.24, 0.12, 0.085], [0.3, 0.22, 0.15], [0.2, 0.17, 0.15]])[rng.integers(3)]
    n = len(run.length)
    panel = np.arange(n)

    def course(v0: float, v1: float, half: float) -> np.ndarray:
        """Corners (n, 8, 3): two ends of a bar that follows the ground."""
        ends = [
            np.stack([run.at(panel, s, np.full(n, v), np.full(n, w)) for v, w in ring], axis=1)
            for s, ring in (
                (0 * run.length, ((v0, half), (v0, -half), (v1, -half), (v1, half))),
                (run.length, ((v0, half), (v0, -half), (v1, -half), (v1, half))),
            )
        ]
        return np.concatenate(ends, axis=1)

    def bar(v0: float, v1: float, half: float, colour) -> Geometry:
        corners = course(v0, v1, half)
        # Own corners for each face: brick rows need u along the wall and v up.
        faces = [[1, 5, 6, 2], [4, 0, 3, 7], [2, 6, 7, 3]]
        parts = []
        start = np.cumsum(run.length) - run.length
        for face in faces:
            quad = corners[:, face]
            u = np.stack([0 * start, run.length, run.length, 0 * start], 1) + start[:, None]
            v = np.tile([v0, v0, v1, v1], (n, 1))
            i = 4 * np.arange(n)[:, None]
            tri = np.concatenate([i + [0, 1, 2], i + [0, 2, 3]], axis=1)
            parts.append(geometry(quad, tri, np.stack([u, v], -1), colour))
        return join(parts)

    p = np.asarray(path, np.float64).reshape(-1, 3)
    yaw = np.arctan2(run.normal[:1, 1], run.normal[:1, 0])[0]
    turned = np.repeat(yaw_matrix(yaw)[None], len(p), axis=0)
    piers = copies(box((0.36, 0.36, height + 0.3)), p - [0, 0, 0.2], rotation=turned)
    caps = copies(box((0.44, 0.44, 0.08)), p + [0, 0, height + 0.1], rotation=turned)
    grey = (0.95, 0.95, 0.95)
    return {
        ("brick", _LABEL): join([bar(-0.2, height - 0.06, 0.11, tint), piers.tinted(tint)]),
        ("concrete", _LABEL): join([bar(height - 0.065, height, 0.14, grey), caps]),
    }


@dataclasses.dataclass(frozen=True)
class FenceKind:
    """A kind of fence: its builder (rng, path, height, detail) and its range of heights [m]."""

    build: Callable[[np.random.Generator, np.ndarray, float, int], Surfaces]
    height_m: tuple[float, float]


FENCES = {
    "picket": FenceKind(_picket, (0.9, 1.2)),
    "board": FenceKind(_board, (1.6, 1.9)),
    "chain_link": FenceKind(_chain_link, (1.2, 1.8)),
    "post_and_rail": FenceKind(_post_and_rail, (0.95, 1.3)),
    "wall": FenceKind(_wall, (0.5, 1.0)),
}


def fence(
    rng: np.random.Generator,
    path: np.ndarray,
    kind: str,
    height_m: float | None = None,
    *,
    detail: int = 1,
) -> Surfaces:
    """A fence along a polyline.

    Args:
        rng: the lane of the fences.
        path: (k, 3) on the ground [m], k >= 2; rails are on the path's right.
        kind: key of `FENCES`.
        height_m: drawn from the kind's range when none.
        detail: 1 for boards with all their sides, 0 for fences seen from 80 m and beyond.

    Returns:
        Geometry by (material, label).
    """
    if kind not in FENCES:
        raise KeyError(f"fence {kind!r} is not one of {sorted(FENCES)}")
    drawn = float(rng.uniform(*FENCES[kind].height_m))
    return FENCES[kind].build(rng, path, drawn if height_m is None else height_m, detail)


def gate(
    rng: np.random.Generator, start: np.ndarray, end: np.ndarray, kind: str, height_m: float
) -> Surfaces:
    """A gate hung between two points (3,) [m], in the style of a fence, perhaps ajar."""
    if kind not in FENCES:
        raise KeyError(f"fence {kind!r} is not one of {sorted(FENCES)}")
    a, b = np.asarray(start, np.float64), np.asarray(end, np.float64)
    width = float(np.linalg.norm(b[:2] - a[:2]))
    material, tint = {
        "picket": ("paint", np.array([0.68, 0.68, 0.65])),
        "board": ("wood", _wood_tint(rng)),
        "post_and_rail": ("wood", _wood_tint(rng)),
    }.get(kind, ("paint", np.array([0.03, 0.032, 0.034])))
    leaf_w, low, top = width - 0.14, 0.08, height_m - 0.03
    x0, x1 = 0.0, leaf_w
    spacing, half = (0.15, 0.071) if kind == "board" else (0.12, 0.036)
    if kind in ("chain_link", "wall"):
        half = 0.01
    corners = np.array([[x0, 0, low], [x1, 0, low], [x1, 0, top], [x0, 0, top]])
    inner = np.array([[x0 + 0.05, 0, low + 0.1], [x1 - 0.05, 0, top - 0.12]])
    frame = beams(corners, np.roll(corners, -1, axis=0), 0.045, 0.07, tint * 0.92)
    brace = beams(inner[:1], inner[1:], 0.03, 0.07, tint * 0.92)
    if kind == "post_and_rail":
        z = np.linspace(low, top, 5)[1:-1]
        bars = beams(
            np.column_stack([0 * z, 0 * z, z]), np.column_stack([0 * z + x1, 0 * z, z]),
            0.03, 0.09, tint,
        )  # fmt: skip
    else:
        x = np.arange(spacing / 2, leaf_w - spacing / 4, spacing)
        n = len(x)
        bars = beams(
            np.column_stack([x, np.full(n, 0.035), np.full(n, low)]),
            np.column_stack([x, np.full(n, 0.035), np.full(n, top + 0.02)]),
            2 * half, 0.02, _varied(rng, tint, n, 0.05),
        )  # fmt: skip
    leaf = {(material, _LABEL): join([frame, brace, bars])}
    yaw = float(np.arctan2(b[1] - a[1], b[0] - a[0]))
    ajar = float(np.radians(rng.choice([0.0, 0.0, 0.0, rng.uniform(15, 80)])))
    hinge = a + yaw_matrix(yaw) @ [0.07, 0, 0]
    posts = join([box((0.1, 0.1, height_m + 0.25), q - [0, 0, 0.15], tint) for q in (a, b)])
    placed = place(leaf, hinge, yaw + ajar)[material, _LABEL]
    return {(material, _LABEL): join([placed, posts])}
