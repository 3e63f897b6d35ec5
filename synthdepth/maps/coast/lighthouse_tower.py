"""A lighthouse's tower: walls and windows, gallery, lantern room."""

import dataclasses

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.lofts import fan, lathe, sheet
from synthdepth.maps.gardens.parts import DARK, circle
from synthdepth.maps.geometry import (
    Geometry,
    box,
    copies,
    join,
    quads,
    tube,
    yaw_matrix,
)

WHITEWASH = (0.72, 0.72, 0.69)
_WALL, _RAIL = "building", "barrier"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Lighthouse:
    """A tower and what stands beside it.

    Attributes:
        height_m: of the gallery's floor above the ground.
        foot_radius_m, top_radius_m: of the tower.
        sides: 8 for an octagonal tower, more for a round one.
        pattern: "plain", "bands" or "spiral".
        material: "plaster" or "brick".
        colour, second: (3,) linear reflectance of the tower and of its bands.
        bands: number of stripes.
        trim: of the gallery, the lantern and the door.
        house_style: of the keeper's house.
        seed: of the small choices.
    """

    height_m: float
    foot_radius_m: float
    top_radius_m: float
    sides: int
    pattern: str
    material: str
    colour: tuple[float, float, float]
    second: tuple[float, float, float]
    bands: int
    trim: tuple[float, float, float]
    house_style: str
    seed: int


def radius_m(p: Lighthouse, z) -> np.ndarray:
    """Radius of the tower at height z: a straight batter with a flare at the foot."""
    t = np.clip(np.asarray(z, np.float64) / p.height_m, 0, 1)
    flare = 0.12 * p.foot_radius_m * np.clip(1 - t / 0.14, 0, 1) ** 2
    return p.foot_radius_m + t * (p.top_radius_m - p.foot_radius_m) + flare


def _ring(p: Lighthouse, radius, z: float, turn=None) -> np.ndarray:
    """Points of the tower's section, (sides + 1, 3) [m]."""
    a = 2 * np.pi * (np.arange(p.sides + 1) + 0.5) / p.sides if turn is None else turn
    # An octagon's corners stand out so that its flats keep the radius.
    r = radius / np.cos(np.pi / p.sides)
    return np.column_stack([r * np.cos(a), r * np.sin(a), np.full(len(a), z)])


def tower(p: Lighthouse) -> Geometry:
    """The walls, in their colours, from 0.6 m below the ground to the gallery."""
    white, second = np.array(p.colour), np.array(p.second)
    levels = np.linspace(-0.6, p.height_m, 41)
    if p.pattern == "bands":
        edges = np.linspace(0, p.height_m, 2 * p.bands)
        levels = np.unique(
            np.concatenate([[-0.6], edges, np.linspace(0.3, 0.14 * p.height_m, 5), levels[6::3]])
        )
    grid = np.stack([_ring(p, float(radius_m(p, z)), z) for z in levels])
    middle = (levels[1:] + levels[:-1]) / 2
    columns = np.arange(p.sides)
    if p.pattern == "bands":
        dark = (np.floor(middle / p.height_m * (2 * p.bands - 1)).astype(int) % 2 == 1)[:, None]
        dark = np.broadcast_to(dark, (len(middle), p.sides))
    elif p.pattern == "spiral":
        turns = 1.6 + 0.3 * p.bands
        phase = middle[:, None] / p.height_m * turns + columns / p.sides
        dark = phase % 1 < 0.5
    else:
        dark = np.zeros((len(middle), p.sides), bool)
    corner = np.stack([grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]], axis=2)
    # Rain and salt stain the foot and the lee of the gallery.
    stain = (
        1 - 0.16 * np.exp(-np.maximum(middle, 0) / 1.2) - 0.1 * np.exp(-(p.height_m - middle) / 1.5)
    )
    tint = np.where(dark[..., None], second, white) * stain[:, None, None]
    width = 2 * np.pi * p.foot_radius_m / p.sides
    u = np.broadcast_to(columns * width, dark.shape)
    v = np.broadcast_to(levels[:-1, None], dark.shape)
    uv = np.stack([u, v], -1).reshape(-1, 2)
    return quads(corner.reshape(-1, 4, 3), tint.reshape(-1, 3), uv_origin=uv)


def openings(p: Lighthouse, rng: np.random.Generator) -> dict[tuple[str, str], list[Geometry]]:
    """The door with its steps, and windows that climb with the stair inside."""
    glass, frames, stone = [], [], []
    trim = np.array(p.trim) if max(p.trim) < 0.5 else np.array(DARK)
    at = [(0.0, 0.06, True)]
    count = max(int(p.height_m / 4.2), 2)
    step = np.pi / 4 if p.sides == 8 else rng.uniform(0.5, 1.1)
    at += [
        (
            2 * step * (k + 1) if p.sides == 8 else step * (k + 1),
            3.4 + k * (p.height_m - 6.5) / max(count - 1, 1),
            False,
        )
        for k in range(count)
    ]
    at += [(a + np.pi, z, False) for a, z, door in at[1::2] if not door]
    for a, z0, door in at:
        wide, high = (1.1, 2.3) if door else (0.62, 1.15)
        r0, r1 = float(radius_m(p, z0)), float(radius_m(p, z0 + high))
        away = np.array([np.cos(a), np.sin(a), 0.0])
        side = np.array([-np.sin(a), np.cos(a), 0.0])
        r = max(r0, r1) * (1.0 if p.sides == 8 else np.cos(0.5 * wide / r0)) + 0.01
        low = away * r + [0, 0, z0]
        depth = r0 - r1 + 0.12
        # A surround that stands out from the battered wall and holds the pane.
        thick, out = (0.2, 0.14) if door else (0.13, 0.1)
        bars = []
        for s in (-1, 1):
            bars.append((low + side * s * (wide / 2 + thick / 2), thick, high))
        for base, w, h in bars:
            stone.append(_block(base - away * depth, away, side, depth + out, w, h))
        stone.append(
            _block(
                low - away * depth + [0, 0, high], away, side, depth + out, wide + 2 * thick, thick
            )
        )
        stone.append(
            _block(
                low - away * depth - [0, 0, 0.12],
                away,
                side,
                depth + out + 0.06,
                wide + 2 * thick + 0.06,
                0.12,
            )
        )
        face = low + away * 0.02
        q = [
            face + side * -wide / 2,
            face + side * wide / 2,
            face + side * wide / 2 + [0, 0, high],
            face - side * wide / 2 + [0, 0, high],
        ]
        if door:
            frames.append(quads(np.stack(q)[None], trim * 1.3))
            for z in (0.35, 1.25):
                frames.append(_block(face + [0, 0, z], away, side, 0.025, 0.8, 0.7, trim * 1.6))
            for k in range(3):
                stone.append(
                    _block(
                        away * r0 + [0, 0, -0.35],
                        away,
                        side,
                        0.9 + 0.35 * (2 - k),
                        1.9 + 0.3 * (2 - k),
                        0.12 + 0.14 * k,
                    )
                )
        else:
            glass.append(quads(np.stack(q)[None]))
            mid = face + away * 0.02
            frames.append(
                beams(
                    [mid, mid - side * wide / 2 + [0, 0, high / 2]],
                    [mid + [0, 0, high], mid + side * wide / 2 + [0, 0, high / 2]],
                    0.035,
                    0.035,
                    WHITEWASH,
                )
            )
    white = np.array(WHITEWASH) * 0.92
    return {
        ("glass", _WALL): glass,
        ("paint", _WALL): frames,
        ("plaster", _WALL): [g.tinted(white) for g in stone],
    }


def _block(
    base, away, side, deep: float, wide: float, high: float, tint=(1.0, 1.0, 1.0)
) -> Geometry:
    """A box that starts at `base` and reaches `deep` away from the wall."""
    yaw = float(np.arctan2(away[1], away[0]))
    one = box((deep, wide, high), (deep / 2, 0, 0), tint)
    return copies(one, [base], rotation=yaw_matrix(yaw)[None])


def gallery(p: Lighthouse, z: float, radius: float, out: dict) -> None:
    """The flare below the gallery, its floor, brackets and railing."""
    r0 = float(radius_m(p, z))
    sides = p.sides if p.sides == 8 else 32
    flare = np.stack(
        [
            _ring(p, r, h)
            for r, h in (
                (r0, z - 0.75),
                (r0 + 0.14, z - 0.7),
                (r0 + 0.14, z - 0.5),
                (0.5 * (r0 + radius), z - 0.22),
                (radius, z - 0.2),
                (radius, z),
            )
        ]
    )
    out.setdefault(("plaster", _WALL), []).append(sheet(flare, np.array(WHITEWASH) * 0.97))
    out.setdefault(("concrete", "pavement"), []).append(
        fan(_ring(p, radius, z)[:-1], (0.8, 0.8, 0.8))
    )
    count = sides if sides == 8 else 16
    # An octagon's posts stand in its corners.
    half_side = np.pi / sides if sides == 8 else 0.0
    turned = yaw_matrix(half_side)
    rail_r = (radius / np.cos(half_side)) - 0.11
    ring = circle(rail_r, z, 2 * count) @ turned.T
    if sides == 8:
        ring[1::2] = (ring[:-1:2] + ring[2::2]) / 2
    trim = np.array(p.trim)
    rails = [
        tube(ring + [0, 0, h], 0.022 if h > 1 else 0.012, 5, trim, capped=False)
        for h in (0.14, 0.6, 1.12)
    ]
    posts = round_bars(ring[:-1:2] - [0, 0, 0.02], ring[:-1:2] + [0, 0, 1.15], 0.028, trim, 6)
    share = np.linspace(0, 2 * count, 8 * count, endpoint=False) + 0.25
    foot = np.stack([np.interp(share, np.arange(2 * count + 1), ring[:, i]) for i in range(3)], 1)
    balusters = round_bars(foot, foot + [0, 0, 1.12], 0.008, trim, 3)
    out.setdefault(("paint", _RAIL), []).append(join([*rails, posts, balusters]))
    turn = 2 * np.pi * np.arange(count) / count
    ends = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    brackets = beams(
        ends * (r0 + 0.05) + [0, 0, z - 0.62],
        ends * (radius - 0.12) + [0, 0, z - 0.26],
        0.1,
        0.12,
        np.array(WHITEWASH) * 0.9,
    )
    out[("plaster", _WALL)].append(brackets)


def lantern_room(
    p: Lighthouse, rng: np.random.Generator, z: float, radius: float, out: dict
) -> float:
    """Lantern room on a floor at z: low wall, glazing bars, lens, dome, vane; its top [m]."""
    trim = np.array(p.trim)
    n = 12
    high = rng.uniform(1.9, 2.5)
    wall = lathe(
        [radius, radius, radius + 0.06, radius + 0.06],
        [z - 0.05, z + 0.95, z + 0.96, z + 1.04],
        24,
        np.array(WHITEWASH) * 0.95,
    )
    base, top = circle(radius, z + 1.04, n), circle(radius, z + 1.04 + high, n)
    iron = [beams(base[:-1], top[:-1], 0.05, 0.05, trim)]
    for t in (0.0, 1 / 3, 2 / 3, 1.0):
        ring = base + t * (top - base)
        iron.append(beams(ring[:-1], ring[1:], 0.045, 0.045, trim))
    if rng.random() < 0.4:  # diagonal astragals
        iron.append(beams(base[:-1], top[1:], 0.03, 0.03, trim))
    # The lens: a barrel of glass rings on a pedestal, lit faces all round.
    mid = z + 1.04 + high / 2
    rings = np.linspace(-0.75, 0.75, 9)
    barrel_r = np.where(np.arange(9) % 2, 0.5, 0.56) * min(radius / 1.5, 1.2)
    barrel_r = barrel_r * np.sqrt(np.clip(1 - (rings / 1.05) ** 2, 0.2, 1))
    lens = lathe(barrel_r, mid + rings, 12)
    pedestal = lathe([0.35, 0.28, 0.28, 0.45], [z, z + 0.4, mid - 0.85, mid - 0.75], 10, DARK)
    r = float(barrel_r.max()) + 0.015
    face = np.array(
        [
            [r, -0.16, mid - 0.22],
            [r, 0.16, mid - 0.22],
            [r, 0.16, mid + 0.22],
            [r, -0.16, mid + 0.22],
        ]
    )
    lit = quads(face[None], (0.78, 0.72, 0.58))
    turn = 2 * np.pi * np.arange(8) / 8
    out.setdefault(("floodlight", _WALL), []).append(
        copies(lit, np.zeros((8, 3)), rotation=yaw_matrix(turn))
    )
    out.setdefault(("glass", _WALL), []).append(lens)
    t = np.linspace(0, 1, 8)
    dome_h = 0.75 * radius
    eave = z + 1.04 + high
    dome = lathe(
        [
            radius + 0.14,
            radius + 0.16,
            *(radius * 1.02 * np.cos(t[1:-1] * np.pi / 2)),
            0.16,
            0.14,
            0.2,
            0.2,
            0.1,
        ],
        [
            eave - 0.02,
            eave + 0.08,
            *(eave + 0.08 + dome_h * np.sin(t[1:-1] * np.pi / 2)),
            eave + 0.1 + dome_h,
            eave + 0.3 + dome_h,
            eave + 0.36 + dome_h,
            eave + 0.56 + dome_h,
            eave + 0.68 + dome_h,
        ],
        24,
        trim,
    )
    peak = eave + 0.68 + dome_h
    rod = round_bars(
        [[0, 0, peak - 0.05], [0.35, 0, peak - 0.3]],
        [[0, 0, peak + 2.1], [0.35, 0, peak + 1.2]],
        0.014,
        DARK,
        5,
    )
    arrow = [
        beams([[-0.5, 0, peak + 0.75]], [[0.5, 0, peak + 0.75]], 0.02, 0.02, DARK),
        box((0.3, 0.012, 0.24), (-0.42, 0, peak + 0.63), DARK),
    ]
    cross = beams(
        [[-0.3, 0, peak + 0.45], [0, -0.3, peak + 0.45]],
        [[0.3, 0, peak + 0.45], [0, 0.3, peak + 0.45]],
        0.016,
        0.016,
        DARK,
    )
    vane = copies(join(arrow), [[0, 0, 0]], rotation=yaw_matrix(rng.uniform(0, 6))[None])
    # Handrail round the lantern, and the conductor's strip down the tower.
    hand = tube(circle(radius + 0.1, z + 1.5, 24), 0.014, 4, trim, capped=False)
    strip_z = np.linspace(0.0, p.height_m - 0.8, 12)
    strip_r = radius_m(p, strip_z) + 0.03
    a = 2.0 if p.sides == 32 else np.pi / 2
    strip = tube(
        np.column_stack([strip_r * np.cos(a), strip_r * np.sin(a), strip_z]),
        0.012,
        3,
        (0.12, 0.16, 0.13),
        capped=False,
    )
    out.setdefault(("paint", _WALL), []).extend(
        [wall, *iron, pedestal, rod, vane, cross, hand, strip]
    )
    out.setdefault(("paint", "roof"), []).append(dome)
    return peak + 2.1
