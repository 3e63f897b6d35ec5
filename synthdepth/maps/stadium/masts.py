"""Floodlight masts: tapered tubes and lattice towers with tilted heads."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.geometry import Model, box, copies, join, merge, quads, tube

_STEEL = (0.3, 0.31, 0.32)
_DARK = (0.05, 0.052, 0.055)
_FACE_M = (0.46, 0.5)  # height and width of a lamp's face


def _heads(at: np.ndarray, drop_rad: float, glow) -> Model:
    """Lamps at `at` (k, 3), facing +x, bent down by `drop_rad`."""
    c, s = np.cos(drop_rad), np.sin(drop_rad)
    bend = np.array([[[c, 0, s], [0, 1, 0], [-s, 0, c]]])
    h, w = _FACE_M
    case = box((0.2, w + 0.06, h + 0.06), (-0.11, 0, -h / 2 - 0.03), _DARK)
    bracket = box((0.1, 0.08, 0.12), (-0.24, 0, -0.06), _STEEL)
    face = quads([[[0, -w / 2, -h / 2], [0, w / 2, -h / 2], [0, w / 2, h / 2], [0, -w / 2, h / 2]]])
    turn = np.repeat(bend, len(at), axis=0)
    return {
        ("paint", "pole"): copies(join([case, bracket]), at, rotation=turn),
        ("floodlight", "pole"): copies(face.tinted(glow), at, rotation=turn),
    }


def training_mast(rng: np.random.Generator, height_m: float, lamps: int) -> Model:
    """A slim column, 8 to 16 m, with a crossarm of lamps that face +x."""
    levels = np.array([-0.1, 0.0, 0.6, height_m])
    radius = np.array([0.13, 0.13, 0.1, 0.05]) * np.clip(height_m / 12, 0.8, 1.4)
    column = tube(np.column_stack([0 * levels, 0 * levels, levels]), radius, 8)
    y = (np.arange(lamps) - (lamps - 1) / 2) * 0.75
    arm = beams([[0, y[0] - 0.25, height_m]], [[0, y[-1] + 0.25, height_m]], 0.08, 0.08)
    door = box((0.02, 0.1, 0.4), (0.135, 0, 0.8))
    steel = join([column, arm, door]).tinted(_STEEL)
    at = np.column_stack([np.full(lamps, 0.38), y, np.full(lamps, height_m - 0.05)])
    glow = (0.7, 0.7, 0.68)
    return merge([{("paint", "pole"): steel}, _heads(at, np.radians(rng.uniform(28, 40)), glow)])


def _lattice(height_m: float, foot_m: float, head_m: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Starts and ends (k, 3) of the bracing of a four-legged tower, and its bays' number."""
    bays = max(round(height_m / 2.4), 4)
    # Bays get shorter as the tower narrows.
    z = height_m * (1 - (1 - np.arange(bays + 1) / bays) ** 1.25)
    half = np.interp(z, [0, height_m], [foot_m / 2, head_m / 2])
    sign = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
    ring = np.concatenate(
        [half[:, None, None] * sign, np.broadcast_to(z[:, None, None], (bays + 1, 4, 1))], axis=2
    )
    nxt = np.roll(ring, -1, axis=1)
    start = [ring[1:], ring[:-1], nxt[:-1]]
    end = [nxt[1:], nxt[1:], ring[1:]]
    return (
        np.concatenate([s.reshape(-1, 3) for s in start]),
        np.concatenate([e.reshape(-1, 3) for e in end]),
        bays,
    )


def stadium_mast(
    rng: np.random.Generator, height_m: float, kind: str, rows: int, columns: int, drop_rad: float
) -> Model:
    """A mast of 18 to 45 m whose head faces +x.

    Args:
        rng: of the lean of the head.
        height_m: of the shaft.
        kind: "lattice" or "tube".
        rows, columns: of lamps.
        drop_rad: how far the lamps look down.
    """
    parts = []
    if kind == "lattice":
        foot, head = 0.085 * height_m, 0.8
        sign = np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])
        low = np.column_stack([sign * foot / 2, np.full(4, -0.1)])
        high = np.column_stack([sign * head / 2, np.full(4, height_m)])
        parts.append(round_bars(low, high, 0.085, sides=6))
        start, end, _ = _lattice(height_m, foot, head)
        parts.append(round_bars(start, end, 0.035, sides=4))
        blocks = [box((0.9, 0.9, 0.4), (*xy, -0.1)) for xy in sign * foot / 2]
        base = join(blocks)
        reach = head / 2
    else:
        levels = np.array([-0.1, 0.0, 0.3 * height_m, 0.65 * height_m, height_m])
        radius = np.interp(levels, [0, height_m], [0.012 * height_m + 0.12, 0.16])
        parts.append(tube(np.column_stack([0 * levels, 0 * levels, levels]), radius, 12))
        base = box((1.6, 1.6, 0.45), (0, 0, -0.1))
        reach = 0.16
        # A ladder in hoops up its back.
        rungs = np.arange(3.0, height_m - 0.5, 0.6)
        x = -np.interp(rungs, levels, radius) - 0.12
        left = np.column_stack([x, np.full(len(rungs), -0.2), rungs])
        right = left * [1, -1, 1]
        parts.append(round_bars(left, right, 0.014, sides=3))
        for s in (-1, 1):
            parts.append(tube([[x[0], 0.2 * s, rungs[0]], [x[-1], 0.2 * s, rungs[-1]]], 0.02, 4))
    wide, tall = 0.62 * columns, 0.72 * rows
    lean = rng.uniform(0.08, 0.2)  # the head's frame leans forward
    z = height_m + 0.3 + 0.72 * np.arange(rows)
    x = reach + 0.15 + lean * (z - height_m)
    y = (np.arange(columns) - (columns - 1) / 2) * 0.62
    bars_a = np.column_stack([x, np.full(rows, -wide / 2), z])
    parts.append(beams(bars_a, bars_a * [1, -1, 1], 0.09, 0.09))
    stiles_y = np.linspace(-wide / 2 + 0.1, wide / 2 - 0.1, 4)
    foot_x, top_x = reach + 0.1, reach + 0.1 + lean * tall
    parts.append(
        beams(
            np.column_stack([np.full(4, foot_x), stiles_y, np.full(4, height_m - 0.1)]),
            np.column_stack([np.full(4, top_x), stiles_y, np.full(4, height_m + tall + 0.1)]),
            0.08,
            0.1,
        )
    )
    stays = [[-reach, t * 0.3, height_m - 0.1] for t in (-1, 1)]
    parts.append(
        round_bars(stays, [[top_x, t * wide * 0.3, height_m + 0.8 * tall] for t in (-1, 1)], 0.04)
    )
    # A platform with a rail behind the lamps.
    parts.append(box((1.0, wide, 0.05), (reach - 0.55, 0, height_m - 0.15)))
    rail_y = np.linspace(-wide / 2, wide / 2, max(columns // 2, 2) + 1)
    feet = np.column_stack(
        [np.full(len(rail_y), reach - 1.03), rail_y, np.full(len(rail_y), height_m)]
    )
    parts.append(round_bars(feet - [0, 0, 0.12], feet + [0, 0, 1.0], 0.02, sides=4))
    for up in (0.5, 1.0):
        parts.append(round_bars([feet[0] + [0, 0, up]], [feet[-1] + [0, 0, up]], 0.02, sides=4))
    at = np.stack(
        [
            np.repeat(x + 0.3, columns),
            np.tile(y, rows),
            np.repeat(z, columns),
        ],
        axis=1,
    )
    return merge(
        [
            {("paint", "pole"): join(parts).tinted(_STEEL), ("concrete", "pole"): base},
            _heads(at, drop_rad, (0.75, 0.76, 0.78)),
        ]
    )
