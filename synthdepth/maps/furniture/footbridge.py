"""Footbridges with their stairs and railings."""

import itertools

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.lattice import between, lattice
from synthdepth.maps.furniture.parts import (
    COATS,
    DARK_STEEL,
    STEEL,
    Surfaces,
    boxes,
    choice,
    lathe,
    turned,
)
from synthdepth.maps.geometry import Geometry, box, join, merge, tube


def railing(path, tint, height_m: float = 1.1, pitch_m: float = 0.13) -> Geometry:
    """Handrail, bottom rail, posts and balusters along a polyline (k, 3) [m]."""
    p = np.asarray(path, np.float64)
    parts = []
    for a, b in itertools.pairwise(p):
        length = np.linalg.norm(b - a)
        count = max(2, round(length / pitch_m))
        t = np.linspace(0, 1, count + 1)[:, None]
        foot = a + t * (b - a)
        up = np.array([0, 0, height_m])
        post = np.arange(count + 1) % round(1.6 / pitch_m) == 0
        parts += [
            round_bars(foot[~post] + [0, 0, 0.1], foot[~post] + up, 0.008, sides=4),
            round_bars(foot[post] - [0, 0, 0.02], foot[post] + up, 0.024, sides=5),
            round_bars([a + up, a + [0, 0, 0.1]], [b + up, b + [0, 0, 0.1]], 0.022),
        ]
    return join(parts).tinted(tint)


def _stairs(rise_m: float, width_m: float, tint) -> tuple[Surfaces, float]:
    """A flight with a landing half way, down along +x from (0, 0, 0); and its length [m].

    Treads of 0.30 m and risers of about 0.165 m between steel strings.
    """
    count = 2 * max(2, round(rise_m / 0.33))
    riser, tread, landing = rise_m / count, 0.30, 1.4
    k = np.arange(count)
    x = tread * k + landing * (k >= count // 2)
    z = -riser * (k + 1)
    steps = boxes((tread + 0.02, width_m, 0.06), np.column_stack([x + tread / 2, 0 * x, z - 0.06]))
    mid = tread * count / 2
    flat = box((landing, width_m, 0.1), (mid + landing / 2, 0, z[count // 2 - 1] - 0.10))
    length = tread * count + landing
    low = -riser * count / 2
    line = np.array([[0, 0, 0], [mid, 0, low], [mid + landing, 0, low], [length, 0, -rise_m]])
    strings, rails = [], []
    for s in (-1, 1):
        edge = line + [0, s * (width_m / 2 + 0.03), -0.08]
        strings.append(beams(edge[:-1], edge[1:], 0.05, 0.28, tint))
        rails.append(railing(line + [0, s * (width_m / 2), 0.02], tint, 1.05, 0.26))
    posts = [
        tube(
            [
                [mid + landing / 2, s * width_m * 0.35, low - 0.1],
                [mid + landing / 2, s * width_m * 0.35, -rise_m - 0.1],
            ],
            0.09,
            7,
            STEEL,
        )
        for s in (-1, 1)
    ]
    parts = {
        ("concrete", "pavement"): join([steps, flat]),
        ("paint", "building"): join([*strings, *posts]),
        ("paint", "barrier"): join(rails),
    }
    return parts, length


def footbridge(rng: np.random.Generator, *, span_m: float, clearance_m: float) -> Surfaces:
    """A footbridge along x, centred, with a flight of stairs at both ends that turns along y.

    Steel trusses (some roofed) or a concrete girder on columns. Beyond the span it takes 2.6 m at
    either end; the stairs reach 2 * clearance + 3 m to one side.

    Args:
        rng: of its make.
        span_m: between the columns at its ends [m].
        clearance_m: free height below [m].
    """
    wide, half = rng.uniform(2.2, 2.8), span_m / 2
    colour = choice(rng, (*COATS, (0.16, 0.24, 0.3), (0.4, 0.4, 0.38)))
    truss = rng.random() < 0.6
    deep = 0.35 if truss else 0.8
    floor = clearance_m + deep
    ends = half + 2.4
    slab = box((2 * ends, wide, 0.16), (0, 0, floor - 0.16))
    paint, concrete, rails, roof = [], [slab], [], []
    if truss:
        panels = max(6, round(span_m / 2.0))
        top = floor + (2.6 if rng.random() < 0.5 else 1.35)
        for s in (-1, 1):
            y = s * (wide / 2 + 0.12)
            side = np.array([[-half, y, floor - 0.2], [-half, y, top]])
            paint.append(lattice(between(side, side + [span_m, 0, 0], panels), 0.09, 0.05, colour))
        x = np.linspace(-half, half, panels + 1)
        cross = [(floor - 0.26, 0.06)] + ([(top, 0.045)] if top - floor > 2 else [])
        for z, r in cross:
            paint.append(
                round_bars(
                    np.column_stack([x, 0 * x - wide / 2 - 0.12, 0 * x + z]),
                    np.column_stack([x, 0 * x + wide / 2 + 0.12, 0 * x + z]),
                    r,
                    colour,
                )
            )
        if top - floor > 2 and rng.random() < 0.5:
            roof.append(box((span_m + 0.8, wide + 0.7, 0.06), (0, 0, top + 0.08), DARK_STEEL))
    else:
        concrete.append(box((2 * half + 1.0, 0.62 * wide, deep - 0.14), (0, 0, floor - deep)))
        edge = [[-ends, s * (wide / 2), floor - 0.2] for s in (-1, 1)]
        paint.append(beams(edge, [[ends, e[1], e[2]] for e in edge], 0.08, 0.3, colour))
    for s in (-1, 1):
        y = s * (wide / 2 - 0.04)
        rails.append(railing([[-half, y, floor], [half, y, floor]], colour, 1.15))
    side = float(rng.choice([-1, 1]))
    stairs = []
    for e in (-1, 1):
        # Landing beyond the column, stairs off its side, rails round the rest.
        x0, x1 = e * half, e * ends
        turn = side if rng.random() < 0.7 else -side
        rails.append(
            railing(
                [
                    [x0, -turn * (wide / 2 - 0.04), floor],
                    [x1, -turn * (wide / 2 - 0.04), floor],
                    [x1, turn * (wide / 2 - 0.04), floor],
                ],
                colour,
                1.15,
            )
        )
        flight, _ = _stairs(floor, 1.9, colour)
        at = np.array([(x0 + x1) / 2 + e * 0.15, turn * wide / 2, floor])
        stairs.append({k: turned(g, turn * np.pi / 2, at) for k, g in flight.items()})
        radius = 0.32 if not truss else 0.2
        for y in (-0.3 * wide, 0.3 * wide):
            concrete.append(lathe([(radius, -0.1), (radius, floor - deep)], 10, at=(x0, y, 0)))
        concrete.append(box((0.7, wide, 0.35), (x0, 0, floor - deep - 0.3)))
        concrete.append(
            lathe(
                [(0.16, -0.1), (0.16, floor - 0.16)],
                8,
                at=(e * (ends - 0.3), -turn * 0.3 * wide, 0),
            )
        )
    bridge = {
        ("concrete", "building"): join(concrete),
        ("paint", "building"): join([*paint, *roof]),
        ("paint", "barrier"): join(rails),
    }
    return merge([bridge, *stairs])
