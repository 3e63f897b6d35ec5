"""Where people sit: benches, picnic and café tables; and where they leave bicycles."""

import itertools

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.parts import (
    COATS,
    STEEL,
    TIMBER,
    Surfaces,
    choice,
    disc,
    hoop,
    item,
    lathe,
    turned,
)
from synthdepth.maps.geometry import Geometry, box, geometry, join, tube

_BRIGHT = (
    (0.40, 0.04, 0.03),
    (0.5, 0.47, 0.40),
    (0.03, 0.16, 0.09),
    (0.04, 0.09, 0.25),
    (0.50, 0.33, 0.06),
    (0.12, 0.12, 0.125),
    (0.30, 0.07, 0.06),
)


def _slats(x, z, length_m: float, tint, width_m=0.095, thick_m=0.035) -> Geometry:
    """Boards along y at points (x, z) of their middles."""
    x, z = np.broadcast_arrays(np.asarray(x, float), np.asarray(z, float))
    half = np.full(len(x), length_m / 2)
    return beams(
        np.column_stack([x, -half, z]), np.column_stack([x, half, z]), width_m, thick_m, tint
    )


def bench(rng: np.random.Generator) -> Surfaces:
    """A bench of one of four kinds; its seat is 0.45 m high and 1.5-2 m long."""
    return _BENCHES[rng.integers(len(_BENCHES))](rng)


def _park_bench(rng: np.random.Generator) -> Surfaces:
    """Timber slats on frames of cast iron, with arms and a leaning back."""
    length, wood, iron = rng.uniform(1.5, 2.0), choice(rng, TIMBER), choice(rng, COATS[:3])
    seat = _slats([0.20, 0.09, -0.02, -0.13], [0.425, 0.43, 0.425, 0.42], length, wood)
    back = [
        turned(_slats([0], [0], length, wood), 0, (x, 0, z), 1.35)
        for x, z in ((-0.235, 0.58), (-0.27, 0.70), (-0.305, 0.82))
    ]
    frames = []
    for y in np.linspace(-0.42, 0.42, 3 if length > 1.8 else 2) * length:
        paths = [
            [[0.26, y, -0.04], [0.22, y, 0.22], [0.23, y, 0.40]],
            [[-0.32, y, -0.04], [-0.22, y, 0.25], [-0.19, y, 0.42], [-0.34, y, 0.90]],
            [[0.24, y, 0.40], [-0.2, y, 0.395]],
            [[0.23, y, 0.38], [0.25, y, 0.64], [0.10, y, 0.66], [-0.25, y, 0.63]],
        ]
        frames += [tube(p, 0.022, 5, iron) for p in paths]
    return item(wood=[seat, *back], paint=frames)


def _block_bench(rng: np.random.Generator) -> Surfaces:
    """Slats on two blocks of concrete, without a back."""
    length, wood = rng.uniform(1.6, 2.2), choice(rng, TIMBER)
    seat = _slats(np.linspace(-0.2, 0.2, 4), 0.43, length, wood, 0.1, 0.05)
    feet = [box((0.42, 0.28, 0.45), (0, s * length * 0.33, -0.05)) for s in (-1, 1)]
    return item(wood=[seat], concrete=feet)


def _wire_bench(rng: np.random.Generator) -> Surfaces:
    """Seat and back of bent steel rods on two legs."""
    length, coat = rng.uniform(1.4, 1.9), choice(rng, COATS)
    profile = np.array([[0.27, 0.40], [0.22, 0.44], [-0.14, 0.41], [-0.22, 0.52], [-0.32, 0.86]])
    y = np.linspace(-length / 2, length / 2, 19)
    at = np.stack(
        [np.column_stack([np.full(len(y), px), y, np.full(len(y), pz)]) for px, pz in profile]
    )
    rods = [round_bars(a, b, 0.006, coat, 4) for a, b in itertools.pairwise(at)]
    rails = [round_bars(p[0], p[-1], 0.013, coat, 5) for p in at]
    legs = []
    for s in (-1, 1):
        foot = s * length * 0.36
        legs += [
            tube(
                [[0.2, foot, -0.03], [0.16, foot, 0.42], [-0.12, foot, 0.40], [-0.24, foot, -0.03]],
                0.02,
                5,
                coat,
            ),
            tube([[-0.16, foot, 0.40], [-0.31, foot, 0.84]], 0.018, 5, coat),
        ]
    return item(paint=[*rods, *rails, *legs])


def _plank_bench(rng: np.random.Generator) -> Surfaces:
    """Three thick planks and a back board on flat steel."""
    length, wood = rng.uniform(1.5, 1.9), choice(rng, TIMBER)
    seat = _slats([0.17, 0.0, -0.17], 0.42, length, wood, 0.155, 0.055)
    back = turned(_slats([0], [0], length, wood, 0.2, 0.045), 0, (-0.30, 0, 0.76), 1.4)
    steel = []
    for s in (-1, 1):
        y = s * length * 0.35
        steel += [
            beams(
                [[0.2, y, -0.03], [-0.2, y, -0.03]],
                [[0.2, y, 0.39], [-0.2, y, 0.39]],
                0.06,
                0.012,
                STEEL,
            ),
            beams([[0.24, y, 0.385]], [[-0.27, y, 0.385]], 0.06, 0.012, STEEL),
            beams([[-0.25, y, 0.385]], [[-0.345, y, 0.85]], 0.05, 0.012, STEEL),
        ]
    return item(wood=[seat, back], paint=steel)


_BENCHES = (_park_bench, _block_bench, _wire_bench, _plank_bench)


def picnic_table(rng: np.random.Generator) -> Surfaces:
    """A table and two benches of timber on A-frames, 1.8 m long along y."""
    wood, length = choice(rng, TIMBER), rng.uniform(1.7, 2.1)
    top = _slats(np.linspace(-0.31, 0.31, 5), 0.74, length, wood, 0.145, 0.04)
    seats = [_slats([s * 0.70, s * 0.85], 0.43, length, wood, 0.14, 0.04) for s in (-1, 1)]
    frame = []
    for y in (-0.36 * length, 0.36 * length):
        foot = np.array([[0.72, y, -0.04], [-0.72, y, -0.04]])
        head = np.array([[0.26, y, 0.72], [-0.26, y, 0.72]])
        frame += [beams(foot, head, 0.045, 0.09, wood)]
        for z, reach in ((0.39, 0.93), (0.70, 0.36)):
            frame.append(
                beams([[reach, y + 0.046, z]], [[-reach, y + 0.046, z]], 0.045, 0.07, wood)
            )
    return item(wood=[top, *seats, *frame])


def _bistro_chair(tint) -> Geometry:
    """A light chair looking along +x: seat at 0.45 m, bent back."""
    legs = [
        tube([[0.19, s * 0.19, 0.0], [0.17, s * 0.18, 0.45]], 0.011, 4, tint) for s in (-1, 1)
    ] + [
        tube(
            [[-0.22, s * 0.19, 0.0], [-0.17, s * 0.17, 0.45], [-0.25, s * 0.17, 0.86]],
            0.011,
            4,
            tint,
        )
        for s in (-1, 1)
    ]
    seat = box((0.40, 0.40, 0.025), (0, 0, 0.44), tint)
    z = np.array([0.56, 0.66, 0.76, 0.86])
    x = np.interp(z, [0.45, 0.86], [-0.17, -0.25])
    back = beams(
        np.column_stack([x, 0 * x - 0.18, z]),
        np.column_stack([x, 0 * x + 0.18, z]),
        0.012,
        0.05,
        tint,
    )
    return join([*legs, seat, back])


def parasol(rng: np.random.Generator) -> Surfaces:
    """A parasol of 2.4-3.2 m with eight ribs and a valance, its edge at 2.1 m."""
    reach, colour = rng.uniform(1.2, 1.6), np.array(choice(rng, _BRIGHT))
    turn = 2 * np.pi * np.arange(9) / 8
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    rim = np.column_stack([reach * ring, np.full(9, 2.12)])
    hem = np.column_stack([reach * ring, np.full(9, 1.95)])
    i = np.arange(8)
    canopy = geometry(
        np.concatenate([rim, np.tile([[0, 0, 2.62]], (9, 1)), hem]),
        np.concatenate(
            [
                np.stack([i, i + 1, 9 + i], 1),
                np.stack([18 + i, 18 + i + 1, i + 1], 1),
                np.stack([18 + i, i + 1, i], 1),
            ]
        ),
        tint=colour,
    )
    striped = rng.random() < 0.3
    ribs = round_bars(np.tile([[0, 0, 2.58]], (8, 1)), rim[:-1] - [0, 0, 0.02], 0.008, STEEL, 4)
    pole = tube([[0, 0, 0.0], [0, 0, 2.66]], 0.022, 6, STEEL)
    foot = lathe([(0.28, -0.01), (0.28, 0.07), (0.05, 0.09), (0.035, 0.3)], 10, (0.1, 0.1, 0.1))
    part = (
        canopy
        if not striped
        else canopy.tinted(
            np.where(np.arange(27) % 2, 1.0, 0.55 / max(colour.max(), 0.06))[:, None].clip(0.2, 1.6)
        )
    )
    return item(fabric=[part], paint=[ribs, pole, foot])


def cafe_table(rng: np.random.Generator) -> Surfaces:
    """A bistro table with two to four chairs, now and then under a parasol."""
    metal, chair_tint = choice(rng, COATS), choice(rng, _BRIGHT)
    round_top = rng.random() < 0.6
    top = (
        lathe([(0.36, 0.72), (0.36, 0.75)], 14, choice(rng, ((0.5, 0.48, 0.44), *TIMBER)))
        if round_top
        else box((0.68, 0.68, 0.03), (0, 0, 0.72), choice(rng, TIMBER))
    )
    shade = rng.random() < 0.5
    stem = lathe([(0.24, -0.01), (0.23, 0.03), (0.035, 0.06), (0.03, 0.72)], 8, metal)
    paint = [top, stem]
    count = int(rng.integers(2, 5))
    for k in range(count):
        turn = 2 * np.pi * (k + 0.25) / count + rng.normal(0, 0.2)
        out = rng.uniform(0.62, 0.8)
        at = (out * np.cos(turn), out * np.sin(turn), 0)
        paint.append(turned(_bistro_chair(chair_tint), turn + np.pi + rng.normal(0, 0.3), at))
    for _ in range(int(rng.integers(0, 4))):
        x, y = rng.uniform(-0.22, 0.22, 2)
        paint.append(lathe([(0.035, 0.75), (0.04, 0.84)], 6, (0.6, 0.6, 0.58), (x, y, 0)))
    parts = item(paint=paint)
    if not shade:
        return parts
    cover = parasol(rng)
    return {
        ("paint", "street_furniture"): join(
            [parts["paint", "street_furniture"], cover["paint", "street_furniture"]]
        ),
        ("fabric", "street_furniture"): cover["fabric", "street_furniture"],
    }


def bicycle(rng: np.random.Generator) -> Surfaces:
    """A bicycle of 1.75 m along x, standing upright, front wheel towards +x."""
    colour = choice(rng, (*_BRIGHT, *COATS, *COATS))
    r, rear, front = 0.335, np.array([-0.52, 0, 0.335]), np.array([0.53, 0, 0.335])
    crank, seat, head = (np.array(p) for p in ([-0.09, 0, 0.29], [-0.24, 0, 0.82], [0.36, 0, 0.84]))
    low_head = np.array([0.39, 0, 0.68])
    bars = [
        (crank, seat),
        (seat * [1, 1, 0.97], head),
        (crank, low_head),
        (rear, crank),
        (rear, seat * [1, 1, 0.94]),
        (low_head, front),
        (head, low_head),
    ]
    frame = round_bars([a for a, _ in bars], [b for _, b in bars], 0.016, colour, 5)
    black = (0.025, 0.025, 0.026)
    fittings = [
        tube([head, head + [-0.03, 0, 0.16]], 0.014, 5, STEEL),
        tube(
            head
            + np.array(
                [
                    [-0.16, 0.28, 0.15],
                    [-0.02, 0.24, 0.16],
                    [-0.02, -0.24, 0.16],
                    [-0.16, -0.28, 0.15],
                ]
            ),
            0.014,
            5,
            black,
        ),
        tube([seat, seat + [-0.04, 0, 0.15]], 0.013, 5, STEEL),
        box((0.26, 0.15, 0.05), seat + [-0.05, 0, 0.14], black),
        tube([crank + [0.12, 0.09, -0.1], crank + [0, 0.05, 0]], 0.012, 4, STEEL),
        tube([crank + [-0.12, -0.09, 0.1], crank + [0, -0.05, 0]], 0.012, 4, STEEL),
        turned(
            lathe([(0.09, -0.004), (0.09, 0.004)], 10, STEEL),
            np.pi / 2,
            crank + [0, -0.04, 0],
            np.pi / 2,
        ),
    ]
    if rng.random() < 0.4:
        basket = front + [0.05, 0, 0.42]
        fittings.append(box((0.26, 0.32, 0.24), basket, (0.07, 0.06, 0.05)))
    wheels, spokes = [], []
    for hub in (rear, front):
        wheels.append(hoop(r - 0.02, 0.02, 18).moved(hub))
        turn = np.linspace(0, 2 * np.pi, 9)[:-1]
        rim = hub + (r - 0.03) * np.column_stack([np.cos(turn), 0 * turn, np.sin(turn)])
        spokes.append(round_bars(np.tile(hub, (8, 1)), rim, 0.003, STEEL, 3))
    return item(paint=[frame, *fittings, *spokes], rubber=wheels)


def bicycle_rack(rng: np.random.Generator) -> Surfaces:
    """Three to six steel hoops side by side, and a few bicycles that lean on them."""
    count, pitch = int(rng.integers(3, 7)), rng.uniform(0.75, 1.0)
    y = (np.arange(count) - (count - 1) / 2) * pitch
    turn = np.linspace(np.pi, 0, 7)
    bend = np.column_stack([0.38 * np.cos(turn), 0 * turn, 0.45 + 0.33 * np.sin(turn)])
    path = np.concatenate([[[-0.38, 0, -0.06]], bend, [[0.38, 0, -0.06]]])
    metal = [tube(path + [0, at, 0], 0.024, 6) for at in y]
    plates = disc(0.07, (0, 0, 0.006), STEEL, 8)
    paint = [plates.moved([s * 0.38, at, 0]) for at in y for s in (-1, 1)]
    rubber = []
    for at in y[rng.random(count) < 0.45]:
        bike = bicycle(rng)
        lean = np.radians(rng.uniform(3, 6))
        tip = np.array(
            [[1, 0, 0], [0, np.cos(lean), -np.sin(lean)], [0, np.sin(lean), np.cos(lean)]]
        )
        flip = np.pi * bool(rng.random() < 0.3)
        for target, material in ((paint, "paint"), (rubber, "rubber")):
            part = turned(bike[material, "street_furniture"], flip)
            part = geometry(part.vertices @ tip.T, part.faces, part.uv, part.tint)
            target.append(part.moved([rng.normal(0, 0.04), at - 0.12, 0]))
    return item(metal=metal, paint=paint, rubber=rubber)
