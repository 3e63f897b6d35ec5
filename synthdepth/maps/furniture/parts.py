"""What street furniture is put together from: turned solids, plates, boxes, tints."""

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.geometry import Geometry, box, copies, geometry, join, quads, yaw_matrix

Surfaces = dict[tuple[str, str], Geometry]
LABEL = "street_furniture"

STEEL, DARK_STEEL = (0.30, 0.31, 0.32), (0.06, 0.063, 0.066)
BLACK, WHITE = (0.022, 0.023, 0.024), (0.62, 0.62, 0.60)
RED, BLUE, YELLOW = (0.32, 0.025, 0.02), (0.02, 0.055, 0.2), (0.52, 0.34, 0.02)
ORANGE, GREEN = (0.55, 0.12, 0.015), (0.02, 0.09, 0.045)
WARM_LAMP, COOL_LAMP = (0.62, 0.52, 0.36), (0.62, 0.64, 0.62)
COATS = (
    (0.022, 0.024, 0.024), (0.05, 0.055, 0.058), (0.016, 0.045, 0.030), (0.020, 0.035, 0.075),
    (0.16, 0.165, 0.165), (0.085, 0.035, 0.022),
)  # fmt: skip
TIMBER = ((0.21, 0.12, 0.06), (0.29, 0.20, 0.12), (0.25, 0.22, 0.18), (0.13, 0.075, 0.045))


def choice(rng: np.random.Generator, colours) -> tuple[float, float, float]:
    """One of some colours, a little lighter or darker."""
    light = rng.uniform(0.85, 1.15)
    return tuple(np.clip(np.array(colours[rng.integers(len(colours))]) * light, 0.01, 0.8))


def item(label: str = LABEL, **parts: list[Geometry]) -> Surfaces:
    """A model of one label from lists of geometry by material."""
    return {(material, label): join(group) for material, group in parts.items() if group}


def lathe(profile, sides: int = 10, tint=(1.0, 1.0, 1.0), at=(0.0, 0.0, 0.0)) -> Geometry:
    """A solid of revolution from (radius, height) pairs, its outside to the right of the way up.

    A profile that comes down again inside makes a bowl. Both ends are closed.
    """
    radius, height = np.asarray(profile, np.float64).T
    n = len(radius)
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    ring = np.stack([np.cos(turn), np.sin(turn), np.zeros(sides + 1)], axis=-1)
    v = radius[:, None, None] * ring + height[:, None, None] * np.array([0, 0, 1.0])
    along = np.concatenate([[0], np.hypot(np.diff(radius), np.diff(height)).cumsum()])
    uv = np.stack(np.broadcast_arrays(turn * radius.mean(), along[:, None]), axis=-1)
    index = np.arange(n * (sides + 1)).reshape(n, sides + 1)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    fan = np.arange(1, sides - 1)
    top = index[-1, 0]
    faces = np.concatenate(
        [
            np.stack([a, b, c, a, c, d], axis=-1).reshape(-1, 3),
            np.stack([0 * fan, fan + 1, fan], 1),
            top + np.stack([0 * fan, fan, fan + 1], 1),
        ]
    )
    return geometry(v.reshape(-1, 3) + np.asarray(at), faces, uv.reshape(-1, 2), tint)


def disc(radius: float, at, tint, sides: int = 16, inner: float = 0.0) -> Geometry:
    """A flat disc, or a ring, that faces up."""
    turn = 2 * np.pi * np.arange(sides) / sides
    rim = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(sides)])
    i, nxt = np.arange(sides), (np.arange(sides) + 1) % sides
    if inner > 0:
        v = np.concatenate([rim * inner, rim * radius])
        faces = np.concatenate(
            [np.stack([i, sides + i, sides + nxt], 1), np.stack([i, sides + nxt, nxt], 1)]
        )
    else:
        v = np.concatenate([rim * radius, np.zeros((1, 3))])
        faces = np.stack([np.full(sides, sides), i, nxt], 1)
    return geometry(v + np.asarray(at), faces, v[:, :2], tint)


def boxes(size, base, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """Boxes of `size` (3,) or (k, 3), their bases centred on `base` (k, 3) [m]; one tint or k."""
    base = np.asarray(base, np.float64).reshape(-1, 3)
    size = np.broadcast_to(np.asarray(size, np.float64), base.shape)
    tint = np.broadcast_to(np.asarray(tint, np.float64), base.shape)
    return copies(box((1, 1, 1)), base, scale=size, tint=tint)


def turned(part: Geometry, yaw_rad=0.0, at=(0.0, 0.0, 0.0), tip_rad: float = 0.0) -> Geometry:
    """A part tipped forwards about y (top towards +x), then turned about z, then moved."""
    c, s = np.cos(tip_rad), np.sin(tip_rad)
    tip = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    return copies(part, np.asarray(at)[None], rotation=(yaw_matrix(yaw_rad) @ tip)[None])


def ringed(part: Geometry, count: int, radius: float = 0.0) -> Geometry:
    """Copies of a part evenly about z, each moved out by `radius` along its own x."""
    turn = 2 * np.pi * np.arange(count) / count
    out = radius * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    return copies(part, out, rotation=yaw_matrix(turn))


def extruded(outline, length_m: float, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """A convex profile (k, 2) of (x, z), counter-clockwise seen from -y, extruded along y."""
    ring = np.asarray(outline, np.float64)
    k = len(ring)
    ends = [np.column_stack([ring[:, 0], np.full(k, y), ring[:, 1]]) for y in (-0.5, 0.5)]
    v = np.concatenate(ends) * [1, length_m, 1]
    i, nxt = np.arange(k), (np.arange(k) + 1) % k
    # Each side has corners of its own: its texture runs along the length.
    sides = np.stack([v[i], v[k + i], v[k + nxt], v[nxt]], axis=1)[:, ::-1]
    fan = np.arange(1, k - 1)
    caps = np.concatenate(
        [np.stack([0 * fan, fan, fan + 1], 1), k + np.stack([0 * fan, fan + 1, fan], 1)]
    )
    width = np.linalg.norm(ring[nxt] - ring, axis=1)
    start = np.cumsum(width) - width
    u = np.stack([start, start, start + width, start + width], axis=1)[:, ::-1]
    v_along = np.array([0, length_m, length_m, 0])[::-1]
    uv = np.stack([u, np.broadcast_to(v_along, u.shape)], axis=-1)
    quad = 4 * np.arange(k)[:, None]
    faces = np.concatenate([quad + [0, 1, 2], quad + [0, 2, 3]])
    return join(
        [geometry(sides, faces, uv.reshape(-1, 2), tint), geometry(v, caps, v[:, ::2], tint)]
    )


def hoop(radius: float, bar_m: float, sides: int = 16, bar_sides: int = 4) -> Geometry:
    """A ring of round bar in the x-z plane about the origin."""
    turn = np.linspace(0, 2 * np.pi, sides + 1)
    ring = radius * np.column_stack([np.cos(turn), np.zeros(sides + 1), np.sin(turn)])
    return round_bars(ring[:-1], ring[1:], bar_m, sides=bar_sides)


def lamp_face(size, at, tint) -> Geometry:
    """The face of a lamp under a ceiling: a quad that shines down."""
    x, y, z = np.asarray(size)[0] / 2, np.asarray(size)[1] / 2, at[2]
    return quads(
        [
            [
                [at[0] - x, at[1] + y, z],
                [at[0] + x, at[1] + y, z],
                [at[0] + x, at[1] - y, z],
                [at[0] - x, at[1] - y, z],
            ]
        ],
        tint,
    )
