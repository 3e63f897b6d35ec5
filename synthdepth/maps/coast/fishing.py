"""Working boats: inshore fishing boats and trawlers."""

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.coast.boat_parts import (
    BLACK,
    Parts,
    add,
    cabin,
    cleats,
    finished,
    side_rails,
)
from synthdepth.maps.coast.hulls import Hull, deck, lining, rub_rail, skin
from synthdepth.maps.coast.lofts import ROPE, both_sides, coil, lathe, net, sheet
from synthdepth.maps.coast.small_craft import BOTTOMS
from synthdepth.maps.gardens.parts import draw_colour, draw_timber
from synthdepth.maps.geometry import Geometry, Model, box, copies, join, quads, tube

_HULLS = (
    (0.02, 0.05, 0.16),
    (0.03, 0.1, 0.06),
    (0.3, 0.04, 0.03),
    (0.02, 0.1, 0.16),
    (0.6, 0.6, 0.57),
    (0.03, 0.03, 0.035),
    (0.36, 0.2, 0.03),
    (0.05, 0.22, 0.28),
)
_WHITE = np.array([0.62, 0.62, 0.59])
_NET_COLOURS = ((0.03, 0.12, 0.09), (0.03, 0.07, 0.2), (0.34, 0.14, 0.04), (0.1, 0.1, 0.09))
_RED, _GREEN = (0.5, 0.06, 0.04), (0.05, 0.4, 0.15)


def _net_heap(rng: np.random.Generator, radius: float, high: float, tint) -> Geometry:
    """A heap of netting: a lumpy dome of dark cloth with cords lying over it."""
    n = 14
    turn = np.linspace(0, 2 * np.pi, n + 1)
    rows = []
    for t in np.linspace(0, 1, 6):
        lump = 1 + 0.14 * np.sin(3 * turn + 9 * t) + 0.08 * np.cos(5 * turn + 4 * t)
        r = radius * np.cos(t * np.pi / 2) ** 0.7 * lump
        rows.append(
            np.column_stack(
                [
                    r * np.cos(turn),
                    r * np.sin(turn),
                    high * np.sin(t * np.pi / 2) * (1 + 0.1 * np.sin(2 * turn)),
                ]
            )
        )
    grid = np.stack(rows)
    grid[:, -1] = grid[:, 0]
    grid[-1, :] = grid[-1].mean(axis=0)
    floats = grid[1:4].reshape(-1, 3)[rng.permutation(3 * (n + 1))[:7]]
    corks = copies(
        lathe([0.03, 0.06, 0.06, 0.03], [-0.06, -0.02, 0.02, 0.06], 6, (0.5, 0.22, 0.04)), floats
    )
    cords = net(grid * [1.02, 1.02, 1.03], 0.03, np.multiply(tint, 1.9))
    return join([sheet(grid, tint), cords, corks])


def _gantry(x: float, half: float, foot: float, head: float, tint) -> Geometry:
    """Two legs that lean together and a crossbeam with blocks hanging from it."""
    legs = round_bars(
        [[x - 0.25, half, foot], [x - 0.25, -half, foot]],
        [[x, 0.8 * half, head], [x, -0.8 * half, head]],
        0.07,
        tint,
        8,
    )
    braces = round_bars(
        [[x + 0.9, half, foot], [x + 0.9, -half, foot]],
        [[x, 0.8 * half, head - 0.3], [x, -0.8 * half, head - 0.3]],
        0.045,
        tint,
        6,
    )
    bar = round_bars([[x, -0.86 * half, head]], [[x, 0.86 * half, head]], 0.07, tint, 8)
    blocks = [
        box((0.12, 0.06, 0.26), (x, y, head - 0.42), BLACK) for y in (0.5 * half, -0.5 * half, 0.0)
    ]
    hooks = [
        box((0.03, 0.03, 0.18), (x, y, head - 0.2), BLACK) for y in (0.5 * half, -0.5 * half, 0.0)
    ]
    return join([legs, braces, bar, *blocks, *hooks])


def _wheelhouse(
    parts: Parts, x0: float, x1: float, half: float, z: float, high: float, tint, trim
) -> float:
    """A deckhouse with forward-leaning or upright windows; the roof's height [m]."""
    base = np.array([[x0, half, z], [x1 - 0.4 * half, 0.85 * half, z], [x1, 0.48 * half, z]])
    top = base + [0, 0, high]
    top[1:, 0] += 0.12
    top[:, 1] *= 0.96
    panes = [
        (0, 0.1, 0.36, 0.5, 0.84),
        (0, 0.42, 0.66, 0.5, 0.84),
        (0, 0.74, 0.93, 0.5, 0.84),
        (1, 0.1, 0.9, 0.5, 0.84),
        (2, 0.04, 0.48, 0.5, 0.84),
        (2, 0.52, 0.96, 0.5, 0.84),
    ]
    cabin(parts, base, top, tint, panes=panes, roof_m=0.0)
    roof = z + high
    add(
        parts,
        "paint",
        box((x1 - x0 + 0.5, 2 * half + 0.24, 0.07), ((x0 + x1) / 2 + 0.08, 0, roof - 0.01), trim),
        box((0.05, 0.64, min(1.75, high - 0.1)), (x0 - 0.02, 0.35 * half, z + 0.04), trim),
        tube([[x0 + 0.3, -0.6 * half, roof], [x0 + 0.3, -0.6 * half, roof + 0.9]], 0.07, 7, BLACK),
    )
    add(
        parts,
        "metal",
        round_bars([[x0 + 0.1, half + 0.04, z + 0.95]], [[x1 - 0.5, half + 0.04, z + 0.95]], 0.016),
    )
    return roof + 0.06


def _pole_mast(parts: Parts, foot, high: float, stays, tint) -> np.ndarray:
    """A steel mast with crosstree, radar, lights and wire stays; its head (3,)."""
    foot = np.asarray(foot, np.float64)
    head = foot + [0, 0, high]
    add(
        parts,
        "paint",
        tube([foot, head], [0.075, 0.045], 7, tint),
        round_bars([head - [0, 0.6, 0.3 * high]], [head - [0, -0.6, 0.3 * high]], 0.025, tint, 5),
        box((0.1, 0.95, 0.1), head - [-0.25, 0, 0.45 * high], _WHITE),
        box((0.3, 0.12, 0.06), head - [-0.15, 0, 0.45 * high + 0.06], tint),
        round_bars(
            [head, head - [0, 0.5, 0.3 * high]],
            [head + [0, 0, 1.2], head + [0, -0.5, 1.0]],
            0.006,
            _WHITE,
            3,
        ),
    )
    add(
        parts,
        "metal",
        round_bars(np.repeat(head[None], len(stays), 0), stays, 0.006, (0.5, 0.5, 0.5), 4),
    )
    lamp = quads(
        np.array([[[0.1, -0.06, 0], [0.1, 0.06, 0], [0.1, 0.06, 0.12], [0.1, -0.06, 0.12]]]),
        (0.7, 0.68, 0.6),
    )
    add(parts, "paint", box((0.1, 0.14, 0.14), head - [-0.05, 0, 0.22 * high], BLACK))
    add(parts, "lamp", copies(lamp, [head - [-0.005, 0, 0.22 * high - 0.01]]))
    return head


def fishing_boat(rng: np.random.Generator) -> Model:
    """An inshore boat of 6.5 to 10 m: wheelhouse forward, working deck, hauler, nets, flags."""
    length = rng.uniform(6.5, 10.0)
    k = length / 8
    hull = Hull(
        length_m=length,
        beam_m=0.36 * length,
        sheer_m=(0.85 * k, 0.8 * k, 1.5 * k),
        keel_m=(0.5 * k, 0.6 * k, 0.4 * k),
        transom=0.85,
        section="round",
        stem_rake_m=0.6 * k,
        bow_power=2.5,
        widest=0.4,
    )
    colour, trim = draw_colour(rng, _HULLS), draw_colour(rng, _HULLS)
    x0, x1 = rng.uniform(0.02, 0.06) * length, 0.26 * length
    parts: Parts = {}
    add(
        parts,
        "paint",
        skin(
            hull,
            [
                (0.08, draw_colour(rng, BOTTOMS)),
                (0.16, _WHITE),
                ("sheer-0.24", colour),
                ("sheer", trim),
            ],
            18,
        ),
        deck(
            hull,
            (0.2, 0.21, 0.2),
            wells=[(0.03, 0.5 + x0 / length + 0.02, 0.44 * hull.beam_m, 0.22 * k)],
            camber_m=0.06,
        ),
        rub_rail(hull, 0.045, BLACK),
        rub_rail(hull, 0.03, BLACK, below_m=0.24),
    )
    house = _WHITE * rng.uniform(0.9, 1.08)
    # Its foot lies a little below the deck, where the hull is still wide enough.
    roof = _wheelhouse(parts, x0, x1, 0.26 * hull.beam_m, 0.75 * k, 2.1, house, trim)
    edge = hull.edge(np.array([0.3, 0.97]))
    stays = [edge[0], edge[0] * [1, -1, 1], edge[1] * [1, 0, 1]]
    _pole_mast(parts, [x0 + 0.4, 0, roof - 0.05], 2.2 * k, stays, trim)
    if rng.random() < 0.7:
        add(parts, "paint", _gantry(-0.4 * length, 0.4 * hull.beam_m, 0.7 * k, 2.6 * k, trim))
    # Hauler, fish boxes, pots, nets and dan flags on the working deck.
    side = hull.edge(np.array([0.5]))[0]
    add(
        parts,
        "metal",
        tube(
            [[side[0], -side[1] + 0.1, 0.9 * k + 0.25], [side[0], -side[1] - 0.08, 0.9 * k + 0.25]],
            0.2,
            10,
        ),
    )
    add(
        parts,
        "paint",
        tube(
            [[side[0], -side[1] + 0.25, 0.25 * k], [side[0], -side[1] + 0.2, 0.95 * k + 0.2]],
            0.05,
            6,
            trim,
        ),
    )
    crates = [
        box(
            (0.75, 0.5, 0.26),
            (-0.12 * length + 0.03 * (i % 3), 0.2 * hull.beam_m, 0.22 * k + 0.27 * i),
            draw_colour(rng, [(0.35, 0.05, 0.04), (0.04, 0.12, 0.3), (0.4, 0.4, 0.38)]),
        )
        for i in range(int(rng.integers(1, 4)))
    ]
    add(parts, "paint", *crates)
    heap = _net_heap(rng, 0.55 * k, 0.5 * k, draw_colour(rng, _NET_COLOURS))
    add(
        parts,
        "fabric",
        copies(heap, [[-0.3 * length, -0.1 * hull.beam_m, 0.22 * k]]),
        copies(
            coil(0.22, 0.03, 4, draw_colour(rng, [ROPE, (0.05, 0.2, 0.25)])),
            [[-0.05 * length, -0.2 * hull.beam_m, 0.22 * k]],
        ),
    )
    count = int(rng.integers(2, 5))
    at = np.column_stack(
        [
            np.linspace(-0.46, -0.4, count) * length,
            np.full(count, 0.36 * hull.beam_m),
            np.full(count, 0.3 * k),
        ]
    )
    tip = at + [[-0.35, 0.1, 2.6 * k]] + rng.normal(0, 0.15, (count, 3))
    add(parts, "wood", round_bars(at, tip, 0.014, draw_timber(rng), 5))
    for p in tip:
        flag = np.array([[p - [0, 0, 0.4], p - [0.45, -0.05, 0.36]], [p, p - [0.47, 0.04, 0.02]]])
        add(
            parts,
            "fabric",
            sheet(flag, draw_colour(rng, [(0.45, 0.1, 0.02), BLACK, (0.05, 0.25, 0.1)])),
        )
    for y, light in ((0.27, _RED), (-0.27, _GREEN)):
        add(parts, "signal", box((0.1, 0.05, 0.1), (x1 - 0.2, y * hull.beam_m, roof), light))
    add(
        parts,
        "metal",
        side_rails(hull, 0.76, 1.0, 0.5, wires=1, spacing_m=0.8),
        cleats(hull, [0.08, 0.6, 0.9]),
    )
    for s in np.linspace(0.2, 0.7, 4):  # old tyres as fenders
        p = hull.edge(np.array([s]))[0]
        turn = np.linspace(0, 2 * np.pi, 13)
        ring = np.column_stack([0.22 * np.cos(turn), 0 * turn, 0.22 * np.sin(turn)])
        add(
            parts,
            "rubber",
            both_sides(copies(tube(ring, 0.075, 6, capped=False), [p + [0, 0.07, -0.3]])),
        )
    return finished(parts)


def trawler(rng: np.random.Generator) -> Model:
    """A stern trawler of 12 to 17 m: high bow, bulwarks, wheelhouse, gantry, net drum, derrick."""
    length = rng.uniform(12.0, 17.0)
    k = length / 14
    hull = Hull(
        length_m=length,
        beam_m=0.33 * length,
        sheer_m=(1.7 * k, 1.6 * k, 3.2 * k),
        keel_m=(1.2 * k, 1.4 * k, 0.9 * k),
        transom=0.85,
        section="round",
        stem_rake_m=1.3 * k,
        bow_power=2.7,
        widest=0.42,
    )
    colour, trim = draw_colour(rng, _HULLS), draw_colour(rng, _HULLS)
    parts: Parts = {}
    add(
        parts,
        "paint",
        skin(
            hull,
            [
                (0.15, draw_colour(rng, BOTTOMS)),
                (0.28, _WHITE),
                ("sheer-0.5", colour),
                ("sheer-0.42", _WHITE),
                ("sheer", colour),
            ],
            22,
        ),
        deck(hull, (0.17, 0.15, 0.13), drop_m=0.75 * k, camber_m=0.1),
        lining(hull, 0.7 * k, _WHITE * 0.8, inset_m=0.14),
        rub_rail(hull, 0.06, trim),
        rub_rail(hull, 0.05, BLACK, below_m=0.7 * k),
    )
    z = 0.75 * k
    half = 0.3 * hull.beam_m
    house = _WHITE * rng.uniform(0.92, 1.08)
    x0, x1 = 0.02 * length, 0.26 * length
    low = _wheelhouse(parts, x0, x1, half, z + 0.1 * k, 2.2, house, trim)
    roof = _wheelhouse(
        parts, x0 + 0.1 * length, x1 - 0.2, 0.85 * half, low - 0.02, 2.15, house, trim
    )
    add(parts, "metal", *_roof_rail(x0 - 0.1, x0 + 0.1 * length, half, low))
    bow, quarter = hull.edge(np.array([0.97]))[0] * [1, 0, 1], hull.edge(np.array([0.3]))[0]
    head = _pole_mast(
        parts,
        [x0 + 0.16 * length, 0, roof - 0.05],
        3.4 * k,
        [bow, quarter, quarter * [1, -1, 1]],
        trim,
    )
    gx = -0.43 * length
    add(parts, "paint", _gantry(gx, 0.42 * hull.beam_m, z + 0.2, 5.2 * k, trim))
    # Wires from the mast to the gantry, and the derrick's boom.
    top = [[gx, y, 5.2 * k] for y in (0.3 * hull.beam_m, -0.3 * hull.beam_m)]
    boom_end = np.array([-0.2 * length, 0.08 * length, 5.6 * k])
    add(
        parts,
        "metal",
        round_bars(
            [*top, boom_end],
            [head - [0, 0, 0.8], head - [0, 0, 0.8], head - [0, 0, 0.2]],
            0.008,
            (0.5, 0.5, 0.5),
            4,
        ),
    )
    add(
        parts,
        "paint",
        tube([[x0 + 0.05 * length, 0, low + 0.3], boom_end], [0.08, 0.05], 6, trim),
        round_bars([boom_end], [boom_end - [0, 0, 2.2 * k]], 0.008, BLACK, 4),
        box((0.12, 0.08, 0.3), boom_end - [0, 0, 2.5 * k], (0.4, 0.28, 0.03)),
    )
    # Net drum with the net on it, winch, hatch, boxes.
    y = 0.3 * hull.beam_m
    drum = tube(
        [[-0.33 * length, -y, z + 0.8], [-0.33 * length, y, z + 0.8]],
        0.45 * k,
        12,
        draw_colour(rng, _NET_COLOURS),
    )
    add(
        parts,
        "fabric",
        drum,
        copies(
            _net_heap(rng, 0.9 * k, 0.6 * k, draw_colour(rng, _NET_COLOURS)),
            [[-0.2 * length, -0.06 * length, z - 0.02]],
        ),
    )
    for s in (-1, 1):
        add(
            parts,
            "paint",
            tube(
                [[-0.33 * length, s * y, z + 0.8], [-0.33 * length, s * (y + 0.06), z + 0.8]],
                0.75 * k,
                14,
                trim,
            ),
            box((0.3, 0.1, 0.9), (-0.33 * length, s * (y + 0.1), z - 0.02), trim),
        )
    add(
        parts,
        "paint",
        box((1.2, 1.4, 0.35), (-0.1 * length, 0, z), _WHITE * 0.8),
        box((0.8, 1.6, 0.8), (-0.02 * length - 0.3, 0, z), trim),
    )
    boxes = [
        box(
            (0.8, 0.5, 0.25),
            (-0.13 * length, 0.09 * length, z + 0.26 * i),
            draw_colour(rng, [(0.4, 0.25, 0.03), (0.04, 0.12, 0.3)]),
        )
        for i in range(4)
    ]
    doors = both_sides(
        box((1.2 * k, 0.08, 1.0 * k), (gx - 0.1, 0.4 * hull.beam_m, z + 0.3))
    )  # otter boards
    add(parts, "paint", *boxes, doors.tinted((0.1, 0.07, 0.05)))
    add(
        parts,
        "metal",
        side_rails(hull, 0.7, 1.0, 0.5, wires=1, spacing_m=1.2),
        cleats(hull, [0.1, 0.5, 0.88]),
    )
    add(parts, "rubber", *_tyres(hull))
    lamp = quads(
        np.array([[[0, -0.2, -0.02], [0, 0.2, -0.02], [-0.25, 0.2, -0.06], [-0.25, -0.2, -0.06]]]),
        (0.7, 0.68, 0.62),
    )
    add(parts, "lamp", copies(lamp, [[x0 - 0.2, 0.5, low - 0.03], [x0 - 0.2, -0.5, low - 0.03]]))
    return finished(parts)


def _tyres(hull: Hull) -> list[Geometry]:
    turn = np.linspace(0, 2 * np.pi, 13)
    ring = tube(
        np.column_stack([0.3 * np.cos(turn), 0 * turn, 0.3 * np.sin(turn)]), 0.1, 6, capped=False
    )
    at = hull.edge(np.linspace(0.15, 0.65, 4)) + [0, 0.1, -0.5]
    return [both_sides(copies(ring, at))]


def _roof_rail(x0: float, x1: float, half: float, z: float) -> list[Geometry]:
    """A rail of three sides round the after end of a roof."""
    path = np.array([[x1, half, z], [x0, half, z], [x0, -half, z], [x1, -half, z]])
    pieces = []
    for level in (0.5, 0.95):
        pieces.append(tube(path + [0, 0, level], 0.016, 5))
    feet = np.concatenate(
        [np.linspace(path[i], path[i + 1], 4)[:-1] for i in range(3)] + [path[-1:]]
    )
    return [*pieces, round_bars(feet, feet + [0, 0, 0.95], 0.016, sides=5)]


FISHING_BOATS = {"fishing_boat": fishing_boat, "trawler": trawler}
