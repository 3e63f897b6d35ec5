"""Tower cranes: lattice mast, slewing cab, jib, counter-jib, stays, hook."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.lattice import between, lattice, square_rings
from synthdepth.maps.furniture.parts import (
    DARK_STEEL,
    STEEL,
    Surfaces,
    boxes,
    choice,
    item,
    lathe,
    turned,
)
from synthdepth.maps.furniture.posters import decals, lettering
from synthdepth.maps.geometry import Geometry, box, join, merge, quads

_COLOURS = (
    (0.52, 0.33, 0.02),
    (0.52, 0.33, 0.02),
    (0.42, 0.05, 0.03),
    (0.55, 0.54, 0.5),
    (0.05, 0.13, 0.36),
)
_AIRCRAFT_RED = (0.75, 0.05, 0.04)


def aircraft_lamp(at) -> Surfaces:
    """A red obstruction lamp on a small foot: a lantern at (3,) [m]."""
    x, y, z = at
    foot = lathe([(0.09, z), (0.09, z + 0.12)], 6, DARK_STEEL, (x, y, 0))
    globe = lathe(
        [(0.10, z + 0.12), (0.12, z + 0.24), (0.05, z + 0.36)], 6, _AIRCRAFT_RED, (x, y, 0)
    )
    return {("paint", "obstacle"): foot, ("signal", "obstacle"): globe}


def _cab(colour) -> tuple[Geometry, Geometry]:
    """The operator's cab, 1.5 by 1.3 by 2.1 m, on the origin, windows towards +x."""
    frame = [
        box((1.5, 1.3, 0.55), (0, 0, 0), colour),
        box((1.6, 1.4, 0.12), (0, 0, 2.0), colour),
        boxes((0.08, 0.08, 1.5), [[a, b, 0.52] for a in (-0.7, 0.7) for b in (-0.6, 0.6)], colour),
        box((0.06, 1.2, 1.5), (-0.7, 0, 0.52), colour),
    ]
    z0, z1 = 0.56, 2.0
    glass = quads(
        [
            [[0.74, -0.56, z0], [0.74, 0.56, z0], [0.74, 0.56, z1], [0.74, -0.56, z1]],
            [[-0.66, -0.63, z0], [0.66, -0.63, z0], [0.66, -0.63, z1], [-0.66, -0.63, z1]],
            [[0.66, 0.63, z0], [-0.66, 0.63, z0], [-0.66, 0.63, z1], [0.66, 0.63, z1]],
        ]
    )
    return join(frame), glass


def tower_crane(rng: np.random.Generator, *, height_m: float, jib_m: float) -> Surfaces:
    """A hammerhead tower crane, its jib along +x.

    Args:
        rng: of its make, and of where its trolley and hook are.
        height_m: of the jib's underside above the ground [m].
        jib_m: reach of the jib from the mast's axis [m].
    """
    colour = choice(rng, _COLOURS)
    half = 0.8 if height_m < 45 else 1.0
    top = height_m - 2.2
    mast = lattice(
        square_rings(np.linspace(-0.2, top, max(6, round(top / (2.1 * half)))), half),
        0.085,
        0.04,
        colour,
    )
    ladder = _ladder(top, half)
    foot = box((5.5, 5.5, 0.9), (0, 0, -0.3))
    ballast = boxes((1.3, 3.6, 0.7), [[s * 1.9, 0, 0.6] for s in (-1, 1)])
    slew = [
        lathe(
            [
                (1.25 * half + 0.3, top),
                (1.25 * half + 0.3, top + 0.5),
                (1.1 * half, top + 0.6),
                (1.1 * half, top + 1.0),
            ],
            16,
            DARK_STEEL,
        )
    ]
    deck = box((3.0, 2.8, 0.1), (0, 0, top + 1.0), STEEL)
    head = lattice(
        between(square_rings([top + 1.0], [0.75])[0], square_rings([height_m + 7.5], [0.14])[0], 6),
        0.08,
        0.035,
        colour,
    )
    apex = np.array([0, 0, height_m + 7.5])
    # Jib: a triangle with one chord above; it thins towards its tip.
    deep = 1.35
    root = np.array([[0.9, -0.6, height_m], [0.9, 0.6, height_m], [0.9, 0, height_m + deep]])
    tip = np.array(
        [
            [jib_m, -0.6, height_m + 0.01 * jib_m],
            [jib_m, 0.6, height_m + 0.01 * jib_m],
            [jib_m, 0, height_m + 0.01 * jib_m + 0.85],
        ]
    )
    panels = max(6, round(jib_m / 1.5))
    jib = lattice(between(root, tip, panels), 0.055, 0.026, colour, open_faces=())
    back = 0.32 * jib_m
    counter = []
    for s in (-0.6, 0.6):
        side = np.array([[-0.9, s, height_m], [-0.9, s, height_m + 0.7]])
        counter.append(
            lattice(
                between(side, side - [back, 0, 0], max(4, round(back / 1.4))), 0.05, 0.025, colour
            )
        )
    x = -np.arange(1.0, back, 1.4)
    counter.append(
        beams(
            np.column_stack([x, 0 * x - 0.6, 0 * x + height_m]),
            np.column_stack([x, 0 * x + 0.6, 0 * x + height_m]),
            0.08,
            0.08,
            colour,
        )
    )
    walk = box((back - 1.0, 0.9, 0.03), (-0.5 * back - 0.6, 0, height_m + 0.05), STEEL)
    blocks = boxes(
        (0.42, 1.5, 2.4), [[-back + 0.2 + 0.48 * k, 0, height_m - 1.7] for k in range(4)]
    )
    winch = box((1.8, 1.1, 0.9), (-0.62 * back, 0, height_m + 0.08), (0.2, 0.2, 0.2))
    drum = turned(
        lathe([(0.35, -0.6), (0.35, 0.6)], 10, DARK_STEEL),
        np.pi / 2,
        (-0.62 * back + 1.4, 0, height_m + 0.5),
        np.pi / 2,
    )
    stays = [
        round_bars(
            [apex], [[r * jib_m, 0, height_m + 0.01 * r * jib_m + deep - 0.5 * r]], 0.035, STEEL
        )
        for r in (0.38, 0.78)
    ] + [
        round_bars(
            [apex, apex], [[-back + 0.6, s, height_m + 0.7] for s in (-0.6, 0.6)], 0.035, STEEL
        )
    ]
    cab, glass = _cab((0.6, 0.6, 0.58))
    at = np.array([1.0, -1.75, top + 1.1])
    board = join(
        [
            box((3.0, 0.05, 0.9), (-0.5 * back, s * 0.66, height_m - 0.1), (0.58, 0.57, 0.54))
            for s in (-1, 1)
        ]
    )
    words = decals(lettering("NOVABAU", 0.5), (0.3, 0.03, 0.03), 1)
    words = join(
        [turned(words, s * np.pi / 2, (-0.5 * back, s * 0.69, height_m + 0.35)) for s in (-1, 1)]
    )
    reach = rng.uniform(0.3, 0.85) * jib_m
    parts = merge(
        [
            item(
                "obstacle",
                paint=[
                    mast,
                    ladder,
                    *slew,
                    deck,
                    head,
                    jib,
                    *counter,
                    walk,
                    winch,
                    drum,
                    cab.moved(at),
                    board,
                    words,
                ],
                concrete=[foot, ballast, blocks],
                glass=[glass.moved(at)],
            ),
            {("paint", "wire"): join(stays)},
            _hook(rng, reach, height_m, colour),
            aircraft_lamp(apex),
            aircraft_lamp((jib_m, 0, height_m + 0.01 * jib_m + 0.85)),
            aircraft_lamp((-back, 0, height_m + 0.7)),
        ]
    )
    return parts


def _ladder(top: float, half: float) -> Geometry:
    """A ladder with rungs inside the mast, and a platform every ten metres."""
    y = 0.5 * half
    z = np.arange(0.4, top, 0.4)
    rungs = round_bars(
        np.column_stack([0 * z - 0.2, 0 * z + y, z]),
        np.column_stack([0 * z + 0.2, 0 * z + y, z]),
        0.012,
        STEEL,
        3,
    )
    rails = round_bars(
        [[s, y, 0.2] for s in (-0.2, 0.2)], [[s, y, top] for s in (-0.2, 0.2)], 0.02, STEEL, 4
    )
    floors = np.arange(10, top, 10)
    decks = boxes(
        (1.5 * half, 0.8 * half, 0.04),
        np.column_stack([0 * floors, 0 * floors - 0.3 * half, floors]),
        STEEL,
    )
    return join([rungs, rails, decks])


def _hook(rng: np.random.Generator, reach: float, height_m: float, colour) -> Surfaces:
    """Trolley, four falls of rope, block and hook, with or without a load in slings."""
    z = height_m + 0.01 * reach
    down = z - rng.uniform(0.25, 0.75) * height_m
    trolley = [
        box((1.5, 1.5, 0.12), (reach, 0, z - 0.28), DARK_STEEL),
        boxes(
            (0.25, 0.12, 0.25),
            [[reach + a, b, z - 0.2] for a in (-0.6, 0.6) for b in (-0.66, 0.66)],
            DARK_STEEL,
        ),
    ]
    corner = np.array([[a, b] for a in (-0.3, 0.3) for b in (-0.12, 0.12)])
    high = np.column_stack([corner + [reach, 0], np.full(4, z - 0.25)])
    low = np.column_stack([0.8 * corner + [reach, 0], np.full(4, down + 0.5)])
    ropes = [round_bars(high, low, 0.014, DARK_STEEL, 3)]
    block = [
        box((0.7, 0.25, 0.55), (reach, 0, down), colour),
        lathe([(0.05, down - 0.3), (0.07, down - 0.1), (0.05, down)], 6, DARK_STEEL, (reach, 0, 0)),
    ]
    turn = np.linspace(0.5 * np.pi, -0.9 * np.pi, 7)
    ring = np.column_stack(
        [reach + 0.16 * np.cos(turn), 0 * turn, down - 0.45 + 0.16 * np.sin(turn)]
    )
    hook = round_bars(ring[:-1], ring[1:], 0.04, DARK_STEEL)
    wood = []
    if rng.random() < 0.5 and down > 12:
        load = down - 3.0
        slings = np.array([[reach + a, b, load] for a in (-1.2, 1.2) for b in (-0.4, 0.4)])
        ropes.append(
            round_bars(np.tile([[reach, 0, down - 0.6]], (4, 1)), slings, 0.012, DARK_STEEL, 3)
        )
        y = np.linspace(-0.45, 0.45, 5)
        for k in range(3):
            z_k = load - 0.12 - 0.13 * k
            wood.append(
                beams(
                    np.column_stack([0 * y + reach - 2.0, y, 0 * y + z_k]),
                    np.column_stack([0 * y + reach + 2.0, y, 0 * y + z_k]),
                    0.2,
                    0.12,
                    (0.3, 0.2, 0.12),
                )
            )
    return merge(
        [
            item("obstacle", paint=[*trolley, *block, hook], wood=wood),
            {("paint", "wire"): join(ropes)},
        ]
    )
