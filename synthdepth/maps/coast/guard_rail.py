"""Barriers along coast roads: W-beams, cables, timber rails and stone walls."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.lofts import sheet
from synthdepth.maps.gardens.parts import draw_timber
from synthdepth.maps.geometry import Geometry, Model, join, quads
from synthdepth.maps.materials.coast import COAST_MEAN

_LABEL = "barrier"
# W-beam, EN 1317 profile A: depth towards the road and height [m], 0.31 m high and 83 mm deep.
_W_BEAM = np.array(
    [
        [0.0, 0.0],
        [0.02, 0.012],
        [0.083, 0.045],
        [0.083, 0.085],
        [0.01, 0.135],
        [0.01, 0.175],
        [0.083, 0.225],
        [0.083, 0.265],
        [0.02, 0.298],
        [0.0, 0.31],
    ]
)
_TOP_M = 0.75


class _Line:
    """Points along a polyline (k, 3): s along it, w to its left, z above it."""

    def __init__(self, line):
        p = np.asarray(line, np.float64).reshape(-1, 3)
        leg = np.linalg.norm(np.diff(p[:, :2], axis=0), axis=1)
        p = p[np.concatenate([[True], leg > 0.05])]
        self.points = p
        self.s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(p[:, :2], axis=0), axis=1))])
        along = np.gradient(p[:, :2], self.s, axis=0)
        self.along = along / np.linalg.norm(along, axis=1, keepdims=True)

    def at(self, s, w, z) -> np.ndarray:
        s, w, z = np.broadcast_arrays(*(np.asarray(x, np.float64) for x in (s, w, z)))
        x, y, ground = (np.interp(s, self.s, self.points[:, i]) for i in range(3))
        dx, dy = (np.interp(s, self.s, self.along[:, i]) for i in range(2))
        length = np.maximum(np.hypot(dx, dy), 1e-9)
        return np.stack([x - w * dy / length, y + w * dx / length, ground + z], -1)

    def posts(self, s, w, z0, z1, across_m: float, along_m: float, tint) -> Geometry:
        """Upright bars at s (k,), square to the line."""
        # `beams` turns an upright's section by its lean: a hair's breadth along the line.
        lean = np.where(s < self.s[-1] / 2, 1e-4, -1e-4)
        return beams(self.at(s, w, z0), self.at(s + lean, w, z1), across_m, along_m, tint)

    def stations(self, spacing_m: float) -> np.ndarray:
        return np.linspace(0, self.s[-1], max(int(np.ceil(self.s[-1] / spacing_m)), 1) + 1)


def _w_beam(rng: np.random.Generator, line: _Line, spacing: float) -> Model:
    """Galvanised beam on posts with spacers; its ends turned down into the ground."""
    s = line.stations(spacing)
    steps = np.unique(np.concatenate([line.stations(max(spacing, 2.0)), line.s]))
    steps = steps[np.concatenate([[True], np.diff(steps) > 0.05])]
    length = line.s[-1]
    # The last metres dip to the ground.
    ramp = min(4.0, 0.3 * length)
    steps = np.unique(np.concatenate([steps, [ramp / 2, ramp, length - ramp, length - ramp / 2]]))

    def drop(x):
        end = np.minimum(x, length - x)
        return (_TOP_M - 0.12) * np.clip(1 - end / ramp, 0, 1)

    profile = _W_BEAM
    grid = line.at(
        steps[:, None],
        -0.1 - profile[None, :, 0],
        _TOP_M - 0.31 + profile[None, :, 1] - drop(steps)[:, None],
    )
    rust = np.array([0.8, 0.66, 0.54]) if rng.random() < 0.25 else np.array([1.0, 1.0, 1.0])
    tint = rust * rng.uniform(0.6, 0.85)
    beam = sheet(np.swapaxes(grid, 0, 1), tint)
    post_s = s[(drop(s) < 0.3)]
    post = _TOP_M - 0.04 - drop(post_s)
    posts = [
        line.posts(post_s, 0.0, -0.4, post, 0.1, 0.012, tint * 0.8),
        line.posts(post_s, -0.055, -0.4, post, 0.01, 0.055, tint * 0.8),
        line.posts(post_s, 0.055, -0.4, post, 0.01, 0.055, tint * 0.8),
    ]
    spacer = beams(
        line.at(post_s, -0.1, post - 0.16), line.at(post_s, 0.0, post - 0.16), 0.15, 0.2, tint * 0.7
    )
    parts = {("metal", _LABEL): join([beam, *posts, spacer])}
    seen = post_s[:: max(int(12 / spacing), 1)]
    if len(seen):
        parts["paint", _LABEL] = line.posts(
            seen, -0.07, _TOP_M - 0.06, _TOP_M + 0.1, 0.08, 0.008, (0.6, 0.42, 0.05)
        )
    return parts


def _cable(rng: np.random.Generator, line: _Line, spacing: float) -> Model:
    """Three or four wire ropes on slim posts, anchored at both ends."""
    s = line.stations(spacing * rng.uniform(1.1, 1.4))
    levels = (0.45, 0.56, 0.67, 0.78)[int(rng.random() < 0.5) :]
    posts = round_bars(line.at(s, 0, -0.4), line.at(s, 0, 0.84), 0.045, (0.85, 0.85, 0.86), 6)
    caps = round_bars(line.at(s, 0, 0.84), line.at(s, 0, 0.88), 0.052, (0.55, 0.4, 0.05), 6)
    steps = np.unique(np.concatenate([s, line.s]))
    steps = steps[np.concatenate([[True], np.diff(steps) > 0.02])]
    length = line.s[-1]
    ropes = []
    for k, z in enumerate(levels):
        w = 0.055 if k % 2 else -0.055
        high = (
            z * np.clip(np.minimum(steps, length - steps) / min(2.5, 0.3 * length), -0.05, 1) - 0.02
        )
        ropes.append(
            round_bars(
                line.at(steps[:-1], w, high[:-1]),
                line.at(steps[1:], w, high[1:]),
                0.0095,
                (0.7, 0.7, 0.7),
                4,
            )
        )
    anchors = line.posts(np.array([0.0, length]), 0.0, -0.3, 0.12, 0.6, 0.6, (1.0, 1.0, 1.0))
    return {
        ("metal", _LABEL): join([posts, *ropes]),
        ("paint", _LABEL): caps,
        ("concrete", _LABEL): anchors,
    }


def _timber(rng: np.random.Generator, line: _Line, spacing: float) -> Model:
    """Round or squared posts with one heavy rail and a lighter one."""
    tint = draw_timber(rng) * 0.9
    s = line.stations(spacing)
    k = len(s)
    tones = tint * np.clip(rng.normal(1, 0.1, (k, 1)), 0.6, 1.4)
    parts = [line.posts(s, 0.0, -0.4, 0.86 + rng.normal(0, 0.01, k), 0.19, 0.19, tones)]
    tones = tint * np.clip(rng.normal(1.05, 0.1, (k - 1, 1)), 0.6, 1.4)
    if rng.random() < 0.5:
        parts.append(
            round_bars(
                line.at(s[:-1] - 0.03, -0.16, 0.62),
                line.at(s[1:] + 0.03, -0.16, 0.62),
                0.1,
                tint,
                8,
            )
        )
    else:
        parts.append(
            beams(
                line.at(s[:-1] - 0.02, -0.15, 0.64),
                line.at(s[1:] + 0.02, -0.15, 0.64),
                0.1,
                0.24,
                tones,
            )
        )
    parts.append(
        beams(
            line.at(s[:-1] - 0.02, -0.13, 0.26),
            line.at(s[1:] + 0.02, -0.13, 0.26),
            0.07,
            0.12,
            tones,
        )
    )
    return {("wood", _LABEL): join(parts)}


def _stones(rng: np.random.Generator, line: _Line, _spacing: float) -> Model:
    """A dry-laid wall of rough blocks, with upright coping stones, 0.8 m high."""
    tint = np.array([[0.22, 0.21, 0.19], [0.27, 0.24, 0.195], [0.17, 0.17, 0.175]])[rng.integers(3)]
    length = line.s[-1]
    parts = []
    half, high = 0.22, 0.72
    courses = 4
    for side in (-1, 1):
        for c in range(courses):
            z0 = -0.15 + c * (high + 0.15) / courses
            z1 = z0 + (high + 0.15) / courses
            k = max(int(length / rng.uniform(0.42, 0.55)), 1)
            cut = np.sort(
                np.concatenate(
                    [[0, length], (np.arange(1, k) + rng.uniform(-0.3, 0.3, k - 1)) * length / k]
                )
            )
            a, b = cut[:-1] + 0.008, cut[1:] - 0.008
            w = side * (half - 0.06 * (z0 / high))
            out = w + side * rng.uniform(-0.02, 0.035, k)
            inner = side * 0.1
            gap = 0.012
            tones = (
                tint * np.clip(rng.normal(1, 0.17, (k, 1)), 0.5, 1.6) * rng.normal(1, 0.02, (k, 3))
            )
            low, top = (
                z0 + gap / 2 + rng.uniform(0, 0.015, k),
                z1 - gap / 2 - rng.uniform(0, 0.015, k),
            )
            face = np.stack(
                [
                    line.at(a, out, low),
                    line.at(b, out, low),
                    line.at(b, out + side * rng.uniform(-0.02, 0.01, k), top),
                    line.at(a, out, top),
                ],
                1,
            )
            if side > 0:
                face = face[:, [1, 0, 3, 2]]
            start = np.column_stack([rng.uniform(0, 9, k), rng.uniform(0, 9, k)])
            parts.append(quads(face, tones, start))
            for p, q, x in ((0, 1, low), (3, 2, top)):
                back = [
                    line.at(b if side < 0 else a, inner, x),
                    line.at(a if side < 0 else b, inner, x),
                ]
                ledge = np.stack([face[:, p], face[:, q], back[0], back[1]], 1)
                parts.append(quads(ledge, tones * 0.9, start))
            for p, q, x in ((0, 3, a if side < 0 else b), (1, 2, b if side < 0 else a)):
                end = np.stack(
                    [face[:, p], line.at(x, inner, low), line.at(x, inner, top), face[:, q]], 1
                )
                parts.append(quads(end, tones * 0.85, start))
    core = beams(
        line.at(line.s[:-1], 0, 0.28), line.at(line.s[1:], 0, 0.28), 0.3, 0.86, tint * 0.25
    )
    k = max(int(length / 0.24), 1)
    s = (np.arange(k) + 0.5) * length / k
    tall = rng.uniform(0.16, 0.26, k)
    cope = _along(
        line,
        s,
        0.85 * length / k,
        rng.uniform(0.15, 0.19, k),
        high - 0.02,
        tall,
        tint * np.clip(rng.normal(1.05, 0.15, (k, 1)), 0.6, 1.5),
    )
    return {("rock", _LABEL): join([*parts, core, cope]).tinted(1 / COAST_MEAN)}


def _along(line: _Line, s, wide: float, half, z, tall, tint) -> Geometry:
    """Upright slabs across the line at s (k,)."""
    k = len(s)
    z = np.full(k, z)
    corner = []
    for zz in (z, z + tall):
        for ds, w in ((-1, -1), (1, -1), (1, 1), (-1, 1)):
            corner.append(
                line.at(
                    s + ds * wide / 2 * (1.0 if zz is z else 0.8),
                    w * half * (1.0 if zz is z else 0.85),
                    zz,
                )
            )
    c = np.stack(corner, 1)
    faces = [[0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7], [4, 5, 6, 7]]
    return join([quads(c[:, f], tint, np.column_stack([s * 1.7, s * 0.3])) for f in faces])


GUARD_RAILS = {"w_beam": _w_beam, "cable": _cable, "timber": _timber, "stone_wall": _stones}
_WEIGHTS = (0.55, 0.12, 0.15, 0.18)


def guard_rail(
    rng: np.random.Generator, line, kind: str | None = None, *, spacing_m: float = 2.0
) -> Model:
    """A barrier along a polyline on the ground; the road is on its right.

    Args:
        rng: the lane of the barriers.
        line: (k, 3) [m].
        kind: a key of `GUARD_RAILS`, or drawn.
        spacing_m: of the posts, 2 m near the flights, 4 m far from them.
    """
    if kind is None:
        kind = str(rng.choice(list(GUARD_RAILS), p=_WEIGHTS))
    if kind not in GUARD_RAILS:
        raise KeyError(f"guard rail {kind!r} is not one of {sorted(GUARD_RAILS)}")
    return GUARD_RAILS[kind](rng, _Line(line), spacing_m)
