"""What stands in the way of traffic: cones, barriers, skips."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.parts import (
    BLACK,
    BLUE,
    DARK_STEEL,
    GREEN,
    ORANGE,
    RED,
    STEEL,
    TIMBER,
    WHITE,
    YELLOW,
    Surfaces,
    boxes,
    choice,
    extruded,
    item,
    lathe,
    turned,
)
from synthdepth.maps.furniture.posters import decals, lettering
from synthdepth.maps.geometry import box, geometry, join, tube


def traffic_cone(rng: np.random.Generator) -> Surfaces:
    """A cone of 0.5-0.75 m with two reflective bands."""
    high = float(rng.choice([0.5, 0.7, 0.75]))
    orange = np.array(ORANGE) * rng.uniform(0.8, 1.1)

    def radius(z: float) -> float:
        return 0.16 - 0.13 * z / high

    cone = lathe([(radius(0.03), 0.03), (radius(high), high), (0.02, high + 0.005)], 12, orange)
    bands = [
        lathe([(radius(z) + 0.004, z), (radius(z + w) + 0.004, z + w)], 12, WHITE)
        for z, w in ((0.35 * high, 0.18 * high), (0.68 * high, 0.12 * high))
    ]
    foot = box((0.38, 0.38, 0.035), (0, 0, 0), orange * 0.8)
    return item(paint=[cone, *bands, foot])


def skip(rng: np.random.Generator) -> Surfaces:
    """A builders' skip with rubble, or a wheeled dumpster with lids."""
    colour = choice(rng, (YELLOW, GREEN, BLUE, (0.25, 0.05, 0.03), (0.12, 0.13, 0.13)))
    if rng.random() < 0.55:
        long, wide, high = 3.4, 1.7, 1.25
        ends = np.array(
            [[-0.28, 0.06], [0.28, 0.06], [0.5, 0.75], [0.5, high], [-0.5, high], [-0.5, 0.75]]
        ) * [long, 1]
        low, top = 0.62 * wide / 2, wide / 2
        half = np.interp(ends[:, 1], [0.06, high], [low, top])
        ring = [np.column_stack([ends[:, 0], s * half, ends[:, 1]]) for s in (-1, 1)]
        i = np.arange(6)
        n = (i + 1) % 6
        rim = np.concatenate([np.stack([i, 6 + i, 6 + n], 1), np.stack([i, 6 + n, n], 1)])
        rim = rim[(i != 3)[np.tile(i, 2)]]
        fan = np.arange(1, 5)
        sides = np.concatenate(
            [np.stack([0 * fan, fan, fan + 1], 1), 6 + np.stack([0 * fan, fan + 1, fan], 1)]
        )
        hull = geometry(np.concatenate(ring), np.concatenate([rim, sides])[:, ::-1], tint=colour)
        edge = np.array(
            [
                [-long / 2, -wide / 2, high],
                [long / 2, -wide / 2, high],
                [long / 2, wide / 2, high],
                [-long / 2, wide / 2, high],
            ]
        )
        rails = beams(edge, np.roll(edge, -1, 0), 0.07, 0.07, colour)
        y = np.array([-0.8, -0.3, 0.3, 0.8])
        ribs = [
            beams(
                np.column_stack([y, 0 * y + s * (low + 0.08), 0 * y + 0.2]),
                np.column_stack([y, 0 * y + s * (top + 0.03), 0 * y + high]),
                0.06,
                0.08,
                colour,
            )
            for s in (-1, 1)
        ]
        skids = boxes((1.7, 0.12, 0.12), [[0, s * 0.35, -0.04] for s in (-1, 1)], DARK_STEEL)
        lugs = [
            round_bars([[x, -wide / 2 - 0.16, 0.9]], [[x, wide / 2 + 0.16, 0.9]], 0.03, STEEL)
            for x in (-1.2, 1.2)
        ]
        place_m = rng.uniform([-1.4, -0.65, 0.85], [1.4, 0.65, 1.12], (46, 3))
        place_m[:, 2] += 0.28 * (1 - (place_m[:, 0] / 1.6) ** 2) * (1 - (place_m[:, 1] / 0.8) ** 2)
        rubble = [
            turned(
                box(rng.uniform(0.12, 0.5, 3) * [1, 0.7, 0.5], (0, 0, -0.1)),
                rng.uniform(0, 6.3),
                p,
                rng.uniform(-0.6, 0.6),
            )
            for p in place_m
        ]
        boards = beams(
            place_m[:7] + [0, 0, 0.1], place_m[7:14] + [0, 0, 0.25], 0.12, 0.025, TIMBER[1]
        )
        fill = box((2.9, 1.35, 0.05), (0, 0, 0.95))
        return item(
            paint=[hull, rails, *ribs, skids, *lugs],
            concrete=[*rubble[:30]],
            brick=[join(rubble[30:]).tinted((0.25, 0.11, 0.07))],
            soil=[fill],
            wood=[boards],
        )
    body = extruded(
        [(-0.52, 0.16), (0.42, 0.16), (0.55, 0.9), (0.55, 1.12), (-0.55, 1.32), (-0.55, 0.9)],
        1.8,
        colour,
    )
    z = np.array([0.35, 0.62, 0.9])
    ribs = boxes((0.06, 1.82, 0.06), np.column_stack([[0.455, 0.505, 0.545], 0 * z, z]), colour)
    pivots = [
        round_bars([[0.0, s * 0.9, 0.9]], [[0.0, s * 1.02, 0.9]], 0.05, STEEL) for s in (-1, 1)
    ]
    lids = [
        turned(
            box((1.16, 0.88, 0.04), (0, 0, 0), BLACK),
            0,
            (0.0, s * 0.45, 1.235),
            0.18 if rng.random() < 0.7 else -0.3,
        )
        for s in (-1, 1)
    ]
    wheel = turned(lathe([(0.09, -0.025), (0.09, 0.025)], 10), np.pi / 2, (0, 0, 0), np.pi / 2)
    wheels = [wheel.moved([a, b, 0.085]) for a in (-0.38, 0.34) for b in (-0.7, 0.7)]
    forks = boxes(
        (0.05, 0.09, 0.1), [[a, b, 0.1] for a in (-0.38, 0.34) for b in (-0.7, 0.7)], STEEL
    )
    return item(paint=[body, ribs, *pivots, *lids, forks], rubber=wheels)


def barrier_crowd(rng: np.random.Generator) -> Surfaces:
    """A crowd-control barrier of galvanised tube, 2.3 m long along y, 1.1 m high."""
    half, n = 1.15, int(rng.integers(15, 19))
    frame = tube(
        [
            [0, -half, 0.22],
            [0, -half, 1.0],
            [0, -half + 0.1, 1.1],
            [0, half - 0.1, 1.1],
            [0, half, 1.0],
            [0, half, 0.22],
        ],
        0.019,
        6,
    )
    low = round_bars([[0, -half, 0.22]], [[0, half, 0.22]], 0.019)
    y = np.linspace(-half, half, n + 2)[1:-1]
    rods = round_bars(
        np.column_stack([0 * y, y, 0 * y + 0.22]),
        np.column_stack([0 * y, y, 0 * y + 1.1]),
        0.008,
        sides=4,
    )
    feet = [
        tube(
            [[-0.3, s, 0.012], [-0.06, s, 0.05], [0, s, 0.22], [0.06, s, 0.05], [0.3, s, 0.012]],
            0.016,
            5,
        )
        for s in (-0.8, 0.8)
    ]
    hooks = [tube([[0, half, 0.9], [0, half + 0.07, 0.9], [0, half + 0.07, 0.8]], 0.009, 4)]
    parts = item("barrier", metal=[frame, low, rods, *feet, *hooks])
    if rng.random() < 0.25:
        banner = decals([[-0.9, 0.4, 0.9, 0.95]], choice(rng, (BLUE, RED, WHITE)), 4)
        text = decals(lettering("EVENT", 0.22), WHITE, 5).moved([0, 0, 0.68])
        parts["paint", "barrier"] = join([banner, text])
    return parts


def barrier_jersey(rng: np.random.Generator) -> Surfaces:
    """A jersey barrier, 0.81 m high and 2-3 m long along y, of concrete or of plastic."""
    long = rng.uniform(2.0, 3.2)
    profile = [
        (-0.30, -0.03),
        (0.30, -0.03),
        (0.30, 0.08),
        (0.17, 0.33),
        (0.085, 0.81),
        (-0.085, 0.81),
        (-0.17, 0.33),
        (-0.30, 0.08),
    ]
    flank = np.arctan2(0.085, 0.48)
    if rng.random() < 0.6:
        arrow = turned(
            box((0.008, 0.2, 0.14), (0, 0, 0), (0.55, 0.3, 0.02)),
            0,
            (0.128, 0.35 * long, 0.55),
            -flank,
        )
        return item("barrier", concrete=[_convex_halves(profile, long)], paint=[arrow])
    colour = choice(rng, ((0.5, 0.06, 0.03), (0.6, 0.58, 0.55), ORANGE))
    return item("barrier", paint=[_convex_halves(profile, long, colour)])


def _convex_halves(profile, long: float, tint=(1.0, 1.0, 1.0)):
    """A jersey profile is convex but for its waist: a foot and a stem."""
    p = np.array(profile)
    foot = p[[0, 1, 2, 3, 6, 7]]
    stem = p[[6, 3, 4, 5]]
    return join([extruded(foot, long, tint), extruded(stem, long, tint)])
