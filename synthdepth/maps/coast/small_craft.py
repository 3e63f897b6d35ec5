"""Small boats: dinghies, rowing boats, kayaks, inflatables, open motorboats."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.boat_parts import (
    BLACK,
    Parts,
    add,
    cleats,
    fenders,
    finished,
    furled_main,
    mast_and_rigging,
    outboard,
    put,
    set_sail,
    side_rails,
    windscreen,
)
from synthdepth.maps.coast.hulls import Hull, deck, lining, rub_rail, skin, strakes
from synthdepth.maps.coast.lofts import both_sides, coil, lathe, sheet
from synthdepth.maps.gardens.parts import draw_colour, draw_timber
from synthdepth.maps.geometry import Model, box, join, tube

HULL_COLOURS = (
    (0.72, 0.72, 0.69),
    (0.7, 0.68, 0.6),
    (0.66, 0.67, 0.66),
    (0.02, 0.035, 0.09),
    (0.03, 0.09, 0.16),
    (0.26, 0.03, 0.025),
    (0.03, 0.1, 0.07),
    (0.4, 0.5, 0.55),
    (0.5, 0.34, 0.04),
)
BOTTOMS = ((0.15, 0.03, 0.025), (0.02, 0.03, 0.06), (0.025, 0.025, 0.027), (0.03, 0.08, 0.09))
CANVAS = ((0.02, 0.04, 0.12), (0.5, 0.48, 0.42), (0.03, 0.09, 0.06), (0.14, 0.02, 0.025))
SAILCLOTH = ((0.72, 0.72, 0.68), (0.7, 0.68, 0.6), (0.68, 0.68, 0.66), (0.22, 0.06, 0.04))


def dinghy(rng: np.random.Generator) -> Model:
    """A sailing dinghy: open cockpit, stayed mast, sails set, stowed or taken off."""
    length = rng.uniform(3.3, 4.7)
    hull = Hull(
        length_m=length,
        beam_m=0.36 * length,
        sheer_m=(0.34, 0.32, 0.44),
        keel_m=(0.06, 0.13, 0.1),
        transom=0.78,
        section="round",
        stem_rake_m=0.3,
        bow_power=2.4,
        stern_rake_m=0.05,
    )
    colour = draw_colour(rng, HULL_COLOURS)
    inside = draw_timber(rng) * 1.15 if rng.random() < 0.3 else np.array([0.6, 0.6, 0.57])
    parts: Parts = {}
    add(
        parts,
        "car_paint",
        skin(hull, [(0.05, colour * 0.9 + 0.03), ("sheer", colour)], 16),
        deck(hull, inside, wells=[(0.08, 0.62, 0.27 * hull.beam_m, 0.08)], camber_m=0.05),
    )
    add(parts, "paint", rub_rail(hull, 0.022, (0.2, 0.2, 0.2)))
    thwart = box((0.2, 0.6 * hull.beam_m, 0.025), (0.02 * length, 0, 0.26), draw_timber(rng))
    tiller = beams([[-length / 2 - 0.04, 0, 0.46]], [[-length / 2 + 0.9, 0.05, 0.48]], 0.03, 0.03)
    rudder = box((0.2, 0.03, 0.75), (-length / 2 - 0.1, 0, -0.28))
    add(parts, "wood", thwart, join([tiller, rudder]).tinted(draw_timber(rng)))
    foot = np.array([0.19 * length, 0, 0.36])
    high = 1.45 * length
    boom = 0.56 * length
    gooseneck = mast_and_rigging(parts, hull, foot, high, boom_m=boom, backstay=False)
    state = rng.random()
    cloth = draw_colour(rng, SAILCLOTH)
    if state < 0.25:
        end = gooseneck + [-0.93 * boom, 0, 0.06]
        add(
            parts,
            "fabric",
            set_sail(
                gooseneck + [-0.02, 0, 0.05],
                end,
                foot + [-0.05, 0, high - 0.1],
                0.12 * boom,
                cloth,
                roach=0.12,
            ),
        )
        bow = hull.edge(np.array([0.95]))[0] * [1, 0, 1]
        add(
            parts,
            "fabric",
            set_sail(
                bow + [0, 0, 0.12],
                gooseneck + [-0.1, 0.28, -0.25],
                foot + [0.08, 0, 0.72 * high],
                0.18,
                cloth,
            ),
        )
    elif state < 0.8:
        add(parts, "fabric", furled_main(gooseneck, boom, draw_colour(rng, CANVAS + SAILCLOTH)))
    return finished(parts)


def rowing_boat(rng: np.random.Generator) -> Model:
    """A clinker-built or plain open boat with thwarts, oars and a coil of rope."""
    length = rng.uniform(3.2, 4.8)
    hull = Hull(
        length_m=length,
        beam_m=0.36 * length,
        sheer_m=(0.46, 0.36, 0.62),
        keel_m=(0.1, 0.15, 0.12),
        transom=0.62,
        section="round",
        stem_rake_m=0.32,
        bow_power=2.2,
        stern_rake_m=0.08,
    )
    painted = rng.random() < 0.65
    timber = draw_timber(rng)
    colour = draw_colour(rng, HULL_COLOURS) if painted else timber * 1.05
    parts: Parts = {}
    tints = np.repeat(colour[None], 8, axis=0) * rng.normal(1, 0.03, (8, 1))
    tints[:3] = draw_colour(rng, BOTTOMS) if painted else tints[:3] * 0.8
    tints[-1] = draw_colour(rng, HULL_COLOURS) if painted else timber * 1.2
    material = "paint" if painted else "wood"
    add(parts, material, strakes(hull, tints))
    inside = timber if rng.random() < 0.6 else np.array([0.5, 0.48, 0.42])
    add(parts, "wood", lining(hull, 0.0, inside))
    add(parts, "wood", rub_rail(hull, 0.024, timber * 0.8))
    for s, z in ((0.2, 0.28), (0.47, 0.22), (0.74, 0.3)):
        at = hull.points(s, z)
        add(parts, "wood", box((0.24, 2 * at[1] - 0.04, 0.03), (at[0], 0, z), timber * 1.1))
    # Ribs, keel, stem post.
    for s in np.linspace(0.12, 0.84, 8):
        z = np.linspace(0.02, float(hull.sheer(s)) - 0.03, 5)
        rib = hull.points(np.full(5, s), z)
        rib[:, 1] -= 0.036
        add(parts, "wood", both_sides(tube(rib, 0.014, 4, timber * 0.8)))
    keel = [[-0.46 * length, 0, -0.12], [0.36 * length, 0, -0.14]]
    add(parts, "wood", beams(keel[:1], keel[1:], 0.05, 0.1, timber * 0.7))
    # Oars, shipped on the thwarts; rowlocks.
    spread = rng.uniform(0.1, 0.3, 2)
    for side, y in zip((1, -1), spread, strict=True):
        a = np.array([-0.42 * length, side * y, 0.36])
        b = np.array([0.32 * length, side * (y - 0.06), 0.42])
        tip = b + (b - a) / np.linalg.norm(b - a) * 0.6
        add(
            parts,
            "wood",
            tube([a, b], 0.022, 6, timber * 1.25),
            beams([b], [tip], 0.15, 0.018, timber * 1.2),
        )
    lock = hull.edge(np.array([0.52]), 0.02)
    add(parts, "metal", both_sides(round_bars(lock, lock + [0, 0, 0.12], 0.012, sides=5)))
    rope = coil(0.16, 0.018, 3)
    put(parts, {"fabric": [rope]}, (0.37 * length, 0, 0.14))
    if rng.random() < 0.3:
        motor = outboard(draw_colour(rng, [BLACK, (0.3, 0.3, 0.3), (0.3, 0.02, 0.02)]), 0.75)
        put(parts, motor, (-length / 2 - 0.01, 0, 0.42))
    return finished(parts)


def kayak(rng: np.random.Generator) -> Model:
    """A sea kayak or a sit-on-top, in the bright colours of moulded plastic."""
    length = rng.uniform(3.6, 5.2)
    hull = Hull(
        length_m=length,
        beam_m=rng.uniform(0.58, 0.7),
        sheer_m=(0.24, 0.17, 0.3),
        keel_m=(0.04, 0.09, 0.05),
        transom=0.03,
        widest=0.5,
        bow_power=2.0,
        section="round",
        stem_rake_m=0.5,
        stern_rake_m=0.35,
    )
    bright = [
        (0.5, 0.06, 0.02),
        (0.55, 0.36, 0.02),
        (0.02, 0.14, 0.3),
        (0.05, 0.2, 0.06),
        (0.5, 0.16, 0.02),
        (0.6, 0.6, 0.58),
    ]
    colour = draw_colour(rng, bright)
    parts: Parts = {}
    add(
        parts,
        "car_paint",
        skin(hull, [(0.02, colour), ("sheer", colour)], 18),
        deck(hull, colour * 0.95, wells=[(0.38, 0.56, 0.21, 0.02)], camber_m=0.07),
    )
    t = np.linspace(0, 2 * np.pi, 17)
    x0 = (0.47 - 0.5) * length
    rim = np.column_stack([x0 + 0.1 * length * np.cos(t), 0.23 * np.sin(t), np.full(17, 0.255)])
    add(
        parts,
        "paint",
        tube(rim, 0.018, 5, BLACK, capped=False),
        rub_rail(hull, 0.012, BLACK),
        box((0.06, 0.36, 0.22), (x0 - 0.06 * length, 0, 0.06), BLACK),
    )
    for x, r in ((0.27 * length, 0.12), (-0.28 * length, 0.13)):
        put(
            parts,
            {"paint": [lathe([r, r, 0.9 * r], [-0.02, 0.025, 0.035], 12, BLACK)]},
            (x, 0, 0.24),
        )
    for x in (0.14, 0.19, -0.17, -0.22):  # deck lines
        w = float(hull.half_beam(0.5 + x)) - 0.04
        line = [[x * length, w, 0.2], [x * length + 0.06, 0, 0.27], [x * length, -w, 0.2]]
        add(parts, "paint", tube(line, 0.005, 3, BLACK, capped=False))
    a = np.array([-0.14 * length, 0.05, 0.31])
    b = a + [2.1, 0.25, 0.01]
    way = (b - a) / np.linalg.norm(b - a)
    add(
        parts,
        "paint",
        tube([a, b], 0.016, 6, (0.1, 0.1, 0.1)),
        beams([a - 0.45 * way, b], [a, b + 0.45 * way], 0.17, 0.012, draw_colour(rng, bright)),
    )
    return finished(parts)


def rib(rng: np.random.Generator) -> Model:
    """A rigid inflatable: V hull, tubes, console, seat, arch and an outboard."""
    length = rng.uniform(4.2, 7.2)
    beam = 0.38 * length**0.98
    tube_r = 0.055 * length**0.7 + 0.09
    hull = Hull(
        length_m=length * 0.95,
        beam_m=beam - 1.7 * tube_r,
        sheer_m=(0.3, 0.32, 0.55),
        keel_m=(0.25, 0.3, 0.12),
        transom=0.95,
        section="chine",
        stem_rake_m=0.9,
        bow_power=2.6,
        widest=0.35,
    )
    grey = draw_colour(
        rng, [(0.3, 0.3, 0.31), (0.05, 0.05, 0.055), (0.5, 0.12, 0.02), (0.45, 0.45, 0.43)]
    )
    parts: Parts = {}
    white = np.array([0.66, 0.66, 0.64])
    add(
        parts,
        "car_paint",
        skin(hull, [(0.06, white), ("sheer", white)], 16),
        deck(hull, (0.42, 0.42, 0.41), camber_m=0.0, drop_m=0.08),
    )
    half = beam / 2 - tube_r
    u = np.linspace(0, 1, 13)
    side = np.column_stack(
        [
            -length / 2 + u * (length - 0.9 * half),
            np.interp(u, [0, 0.6, 1], [half, half, 0.72 * half]),
            np.interp(u, [0, 0.55, 1], [0.34, 0.36, 0.62]),
        ]
    )
    side[:, 1] = half * (1 - 0.34 * np.clip((u - 0.55) / 0.45, 0, 1) ** 2)
    side[:, 2] = 0.34 + 0.34 * np.clip((u - 0.4) / 0.6, 0, 1) ** 2
    turn = np.linspace(0, np.pi / 2, 6)[1:]
    last = side[-1]
    bow = np.column_stack(
        [
            last[0] + 0.75 * half * np.sin(turn),
            last[1] * np.cos(turn),
            last[2] + 0.05 * np.sin(turn),
        ]
    )
    left = np.concatenate([side, bow])
    path = np.concatenate([left, left[-2::-1] * [1, -1, 1]])
    cone = np.concatenate(
        [[[-length / 2 - 0.35, half, 0.34]], path, [[-length / 2 - 0.35, -half, 0.34]]]
    )
    r = np.concatenate([[0.4 * tube_r], np.full(len(path), tube_r), [0.4 * tube_r]])
    add(parts, "car_paint", tube(cone, r, 10, grey))
    # A rubbing strake outside, a lifeline on top.
    out = path.copy()
    out[:, 1] += np.sign(out[:, 1]) * tube_r * 0.98
    out[np.abs(path[:, 1]) < 1e-6, 0] += tube_r
    add(parts, "paint", tube(out[1:-1], 0.03, 4, BLACK))
    line = path[1:-1] + [0, 0, tube_r * 0.98]
    line[:, 2] += 0.02 * (np.arange(len(line)) % 2)
    add(parts, "fabric", tube(line, 0.008, 3, (0.5, 0.5, 0.48), capped=False))
    x = 0.02 * length
    console = box((0.5, 0.62, 0.85), (x, 0, 0.24), white)
    add(
        parts,
        "paint",
        console,
        box((0.55, 0.5, 0.12), (x - 0.85, 0, 0.72), (0.05, 0.05, 0.055)),
        box((0.5, 0.4, 0.5), (x - 0.85, 0, 0.23), white),
        box((0.07, 0.5, 0.3), (x - 1.12, 0, 0.83), (0.05, 0.05, 0.055)),
    )
    screen = [[x + 0.2, 0, 1.09], [x + 0.17, 0.2, 1.09], [x - 0.1, 0.3, 1.09]]
    put(parts, windscreen(screen, 0.35, 0.12), (0, 0, 0))
    wheel = np.linspace(0, 2 * np.pi, 13)
    rim = np.column_stack([np.full(13, x - 0.3), 0.17 * np.cos(wheel), 0.95 + 0.17 * np.sin(wheel)])
    add(parts, "paint", tube(rim, 0.014, 4, BLACK, capped=False))
    xa = -length / 2 + 0.45
    arch = [
        [xa, half * 0.8, 0.5],
        [xa - 0.1, half * 0.72, 1.6],
        [xa - 0.12, half * 0.5, 1.85],
        [xa - 0.12, -half * 0.5, 1.85],
        [xa - 0.1, -half * 0.72, 1.6],
        [xa, -half * 0.8, 0.5],
    ]
    add(
        parts,
        "metal",
        tube(arch, 0.024, 6),
        round_bars([[xa - 0.12, 0.2, 1.85]], [[xa - 0.3, 0.2, 3.0]], 0.006, sides=3),
    )
    add(parts, "signal", box((0.08, 0.08, 0.08), (xa - 0.12, 0, 1.87), (0.7, 0.7, 0.6)))
    put(parts, outboard(BLACK, 1.25), (-length / 2 + 0.02, 0, 0.5))
    add(parts, "paint", box((0.06, hull.beam_m * 0.92, 0.4), (-length / 2 + 0.1, 0, 0.1), white))
    return finished(parts)


def motorboat(rng: np.random.Generator) -> Model:
    """An open runabout of 4.8 to 7.2 m: foredeck, windscreen, seats, rails, outboard."""
    length = rng.uniform(4.8, 7.2)
    hull = Hull(
        length_m=length,
        beam_m=0.375 * length,
        sheer_m=(0.62, 0.64, 0.86),
        keel_m=(0.3, 0.34, 0.12),
        transom=0.93,
        section="chine",
        stem_rake_m=0.17 * length,
        bow_power=2.3,
        widest=0.36,
        stern_rake_m=-0.05,
    )
    top, low = draw_colour(rng, HULL_COLOURS[:3]), draw_colour(rng, HULL_COLOURS)
    parts: Parts = {}
    half = 0.4 * hull.beam_m
    add(
        parts,
        "car_paint",
        skin(
            hull,
            [(0.08, draw_colour(rng, BOTTOMS)), (0.14, top), ("sheer-0.16", low), ("sheer", top)],
        ),
        deck(hull, top, wells=[(0.06, 0.58, half, 0.16)], camber_m=0.1),
    )
    add(parts, "paint", rub_rail(hull, 0.028, (0.1, 0.1, 0.1), below_m=0.03))
    x = 0.08 * length
    plan = [
        [x + 0.55, 0, 0.86],
        [x + 0.42, 0.26 * hull.beam_m, 0.82],
        [x + 0.0, 0.43 * hull.beam_m, 0.74],
        [x - 0.75, 0.44 * hull.beam_m, 0.68],
    ]
    put(parts, windscreen(plan, rng.uniform(0.42, 0.55), 0.4), (0, 0, 0))
    cushion = draw_colour(
        rng, [(0.6, 0.58, 0.52), (0.05, 0.08, 0.2), (0.3, 0.05, 0.04), (0.25, 0.25, 0.25)]
    )
    for y in (0.22 * hull.beam_m, -0.22 * hull.beam_m):
        add(
            parts,
            "fabric",
            box((0.48, 0.46, 0.14), (x - 0.85, y, 0.5), cushion),
            box((0.1, 0.46, 0.45), (x - 1.1, y, 0.56), cushion),
        )
        add(parts, "paint", box((0.3, 0.3, 0.36), (x - 0.85, y, 0.15), top))
    bench = -0.43 * length + 0.35
    add(
        parts,
        "fabric",
        box((0.5, 1.6 * half, 0.14), (bench, 0, 0.46), cushion),
        box((0.1, 1.6 * half, 0.36), (bench - 0.26, 0, 0.56), cushion),
    )
    add(
        parts,
        "paint",
        box((0.4, 1.5 * half, 0.32), (bench, 0, 0.15), top),
        box((0.16, 0.5 * hull.beam_m, 0.4), (x + 0.1, 0, 0.4), (0.05, 0.05, 0.052)),
    )
    wheel = np.linspace(0, 2 * np.pi, 13)
    rim = np.column_stack(
        [
            np.full(13, x - 0.1),
            0.22 * hull.beam_m + 0.17 * np.cos(wheel),
            0.78 + 0.17 * np.sin(wheel),
        ]
    )
    add(parts, "paint", tube(rim, 0.015, 4, BLACK, capped=False))
    add(
        parts,
        "metal",
        side_rails(hull, 0.66, 1.0, 0.28, lift_m=0.02, wires=0, spacing_m=0.7),
        cleats(hull, [0.08, 0.62, 0.92]),
    )
    add(parts, "signal", box((0.1, 0.05, 0.05), (0.47 * length, 0, 0.9), (0.4, 0.1, 0.08)))
    if rng.random() < 0.45:  # a bimini on bows
        canvas = draw_colour(rng, CANVAS)
        t = np.linspace(-1, 1, 7)
        x_bows = x + np.array([-0.2, -1.0, -1.9])
        arch = np.stack(
            [
                np.column_stack(
                    [np.full(7, a), t * 0.42 * hull.beam_m, 2.02 - 0.2 * np.abs(t) ** 3]
                )
                for a in x_bows
            ]
        )
        add(parts, "fabric", sheet(arch[:, ::-1], canvas))
        for a in arch[[0, 2]]:
            leg = np.concatenate(
                [
                    [[x - 1.0, -0.45 * hull.beam_m, 0.66]],
                    a - [0, 0, 0.02],
                    [[x - 1.0, 0.45 * hull.beam_m, 0.66]],
                ]
            )
            add(parts, "metal", tube(leg, 0.012, 5))
    put(
        parts,
        outboard(
            draw_colour(rng, [BLACK, (0.6, 0.6, 0.58), (0.1, 0.11, 0.12)]), rng.uniform(1.1, 1.4)
        ),
        (-length / 2 - 0.02, 0, 0.62),
    )
    if rng.random() < 0.6:
        fenders(rng, parts, hull, 2)
    return finished(parts)


SMALL_CRAFT = {
    "dinghy": dinghy,
    "rowing_boat": rowing_boat,
    "kayak": kayak,
    "rib": rib,
    "motorboat": motorboat,
}
