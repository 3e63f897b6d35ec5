"""Sailing yachts and catamarans of 8 to 13.5 m."""

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.coast.boat_parts import (
    Parts,
    add,
    cabin,
    cleats,
    fenders,
    finished,
    furled_main,
    mast_and_rigging,
    set_sail,
    side_rails,
)
from synthdepth.maps.coast.hulls import Hull, deck, rub_rail, skin
from synthdepth.maps.coast.lofts import both_sides, net, railing, sheet
from synthdepth.maps.coast.small_craft import BOTTOMS, CANVAS, HULL_COLOURS, SAILCLOTH
from synthdepth.maps.gardens.parts import draw_colour, draw_timber
from synthdepth.maps.geometry import Geometry, Model, box, copies, join, tube

_WHITE = np.array([0.7, 0.7, 0.67])


def _wheel(x: float, y: float, z: float, radius: float) -> Geometry:
    turn = np.linspace(0, 2 * np.pi, 17)
    rim = np.column_stack([np.full(17, x), y + radius * np.cos(turn), z + radius * np.sin(turn)])
    spokes = round_bars(np.repeat([[x, y, z]], 4, 0), rim[[2, 6, 10, 14]], 0.008, sides=3)
    return join([tube(rim, 0.013, 4, capped=False), spokes])


def _hood(x: float, width: float, z: float, deep: float, high: float, tint) -> Geometry:
    """A spray hood: cloth over hoops, open aft, its forward edge on the deck at x + deep."""
    turn = np.linspace(0, np.pi, 9)
    rows = []
    for t, lift in ((0.0, 0.06), (0.25, 0.7), (0.55, 0.95), (1.0, 1.0)):
        y = width / 2 * np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** 0.6
        rows.append(
            np.column_stack(
                [np.full(9, x + deep * (1 - t)), y, z + high * lift * np.sin(turn) ** 0.5]
            )
        )
    return sheet(np.stack(rows)[::-1], tint)


def sailing_yacht(rng: np.random.Generator) -> Model:
    """A sloop of 8 to 13 m: coachroof, cockpit, wheel, fin keel, rails, rig of thin wires."""
    length = rng.uniform(8.0, 13.0)
    k = length / 10
    hull = Hull(
        length_m=length,
        beam_m=rng.uniform(0.31, 0.34) * length,
        sheer_m=(0.95 * k, 0.92 * k, 1.25 * k),
        keel_m=(0.08, 0.5 * k, 0.12),
        transom=0.72,
        section="round",
        stem_rake_m=rng.uniform(0.4, 1.3) * k,
        bow_power=2.0,
        stern_rake_m=rng.uniform(-0.5, 0.6) * k,
        widest=0.4,
    )
    colour = draw_colour(rng, HULL_COLOURS)
    stripe = draw_colour(rng, HULL_COLOURS[3:])
    if colour[0] < 0.4:
        stripe = _WHITE
    parts: Parts = {}
    teak = rng.random() < 0.4
    well = (0.08, 0.34, 0.62 * k, 0.48 * k)
    surface = deck(
        hull, draw_timber(rng) * 1.1 if teak else (0.62, 0.62, 0.58), wells=[well], camber_m=0.08
    )
    add(
        parts,
        "car_paint",
        skin(
            hull,
            [
                (0.06, draw_colour(rng, BOTTOMS)),
                (0.16, stripe),
                ("sheer-0.2", colour),
                ("sheer-0.14", stripe),
                ("sheer", colour),
            ],
            22,
        ),
    )
    add(parts, "wood" if teak else "paint", surface)
    add(
        parts,
        "metal" if not teak else "wood",
        rub_rail(hull, 0.022, draw_timber(rng) if teak else (0.9, 0.9, 0.9)),
    )
    # Fin keel and rudder.
    fin = _foil(0.06 * length, 1.5 * k, 1.1 * k, 0.14 * k, -0.45 * k, -1.75 * k)
    rudder = _foil(-0.43 * length, 0.5 * k, 0.35 * k, 0.07 * k, -0.02, -1.35 * k)
    add(parts, "paint", join([fin, rudder]).tinted(draw_colour(rng, BOTTOMS)))
    # Coachroof with long windows.
    s = np.array([0.355, 0.45, 0.55, 0.66, 0.735])
    foot = hull.edge(s)
    base = foot * [1, 1, 0] + np.column_stack([0 * s, 0 * s, hull.sheer(s) - 0.03])
    base[:, 1] = foot[:, 1] * np.array([0.66, 0.66, 0.64, 0.58, 0.3])
    high = np.array([0.44, 0.42, 0.38, 0.26, 0.09]) * k
    top = base + np.column_stack([-0.05 * k * np.arange(5) / 4, -0.14 * k * np.ones(5), high])
    top[:, 1] = np.maximum(top[:, 1], 0.1)
    panes = [(0, 0.12, 0.94, 0.3, 0.78), (1, 0.06, 0.94, 0.3, 0.78), (2, 0.2, 0.92, 0.3, 0.74)]
    cabin(parts, base, top, _WHITE * rng.uniform(0.92, 1.05), panes=panes, roof_m=0.05 * k)
    roof_z = float(top[2, 2])
    add(
        parts,
        "glass",
        copies(box((0.5 * k, 0.5 * k, 0.05)), [[0.22 * length, 0, roof_z - 0.1 * k]]),
    )
    x_hood = float(base[0, 0])
    if rng.random() < 0.75:
        cloth = draw_colour(rng, CANVAS)
        add(
            parts,
            "fabric",
            _hood(x_hood - 0.5 * k, 1.9 * k, float(top[0, 2]) - 0.05, 0.9 * k, 0.62 * k, cloth),
        )
    # Cockpit: benches, wheel on a pedestal.
    x_well = (np.array(well[:2]) - 0.5) * length
    for y in (0.47 * k, -0.47 * k):
        add(
            parts,
            "wood",
            box(
                (np.ptp(x_well) * 0.72, 0.3 * k, 0.05),
                (x_well[1] - 0.42 * np.ptp(x_well), y, 0.86 * k),
                draw_timber(rng),
            ),
        )
    x_wheel = x_well[0] + 0.3 * np.ptp(x_well)
    add(parts, "metal", _wheel(x_wheel, 0, 1.2 * k, 0.42 * k))
    add(
        parts,
        "paint",
        box((0.16 * k, 0.2 * k, 0.75 * k), (x_wheel + 0.14 * k, 0, 0.47 * k), _WHITE),
    )
    add(
        parts,
        "metal",
        side_rails(hull, 0.12, 0.86, 0.62, inset_m=0.07, lift_m=0.0, wires=1, spacing_m=1.9),
        side_rails(hull, 0.86, 1.0, 0.66, inset_m=0.07, wires=1, spacing_m=1.0),
        cleats(hull, [0.06, 0.55, 0.93]),
    )
    stern = hull.edge(np.array([0.01, 0.06, 0.12]), 0.07)
    pushpit = [
        tube(stern + [0, 0, 0.66], 0.0125, 5),
        round_bars(stern, stern + [0, 0, 0.66], 0.0125, sides=5),
    ]
    add(parts, "metal", both_sides(join(pushpit)))
    ring = np.linspace(0.5, 2 * np.pi - 0.5, 10)  # a horseshoe buoy on the pushpit
    buoy = np.column_stack([0 * ring, 0.2 * np.sin(ring), -0.2 * np.cos(ring)])
    add(
        parts,
        "fabric",
        copies(
            tube(buoy, 0.05, 6, (0.55, 0.32, 0.02)),
            [stern[1] * [1, rng.choice([-1, 1]), 1] + [0, 0, 0.5]],
        ),
    )
    foot_m = np.array([0.08 * length, 0, roof_z - 0.02])
    boom = 0.36 * length
    high_m = rng.uniform(1.22, 1.36) * length
    gooseneck = mast_and_rigging(
        parts, hull, foot_m, high_m, boom_m=boom, spreaders=2 if length > 9.5 else 1
    )
    bow = hull.edge(np.array([0.97]))[0] * [1, 0, 1]
    head = foot_m + [-0.01 * high_m, 0, 0.915 * high_m]
    cloth = draw_colour(rng, SAILCLOTH[:3])
    if rng.random() < 0.22:  # under sail
        end = gooseneck + [-0.94 * boom, 0.05, 0.1]
        add(
            parts,
            "fabric",
            set_sail(
                gooseneck + [-0.06, 0, 0.08],
                end,
                foot_m + [-0.1, 0, high_m - 0.2],
                0.1 * boom,
                cloth,
                roach=0.1,
            ),
            set_sail(
                bow + [-0.1, 0, 0.3], foot_m + [-0.6, 0.9 * k, 0.5], head, 0.1 * length / 2, cloth
            ),
        )
    else:
        cover = draw_colour(rng, CANVAS)
        add(parts, "fabric", furled_main(gooseneck, boom, cover))
        t = np.array([0.03, 0.12, 0.7, 0.96])[:, None]  # the headsail rolled on its stay
        roll = bow * (1 - t) + head * t
        add(
            parts,
            "fabric",
            tube(roll, [0.03, 0.075, 0.06, 0.025], 6, cloth * 0.95),
            tube(roll[1:3] + [0.02, 0, 0], 0.066, 6, cover),
        )
    if rng.random() < 0.6:
        pole = [stern[0] * [1, 0.7, 1], stern[0] * [1, 0.7, 1] + [-0.4, 0, 1.3]]
        add(parts, "wood", tube(pole, 0.014, 5, draw_timber(rng)))
        a, b = np.array(pole[1]), np.array(pole[1]) - [-0.13, 0, 0.45]
        drop = np.array([[-0.55, 0.15, -0.2]])
        flag = np.stack(
            [
                [b, b + drop[0] * 0.5 - [0, 0.1, 0], b + drop[0]],
                [a, a + drop[0] * 0.5 - [0, 0.1, 0], a + drop[0]],
            ]
        )
        add(parts, "fabric", sheet(flag, draw_colour(rng, [(0.4, 0.02, 0.02), (0.02, 0.05, 0.25)])))
    fenders(rng, parts, hull, int(rng.integers(2, 5)))
    return finished(parts)


def _foil(x: float, root: float, tip: float, thick: float, z_top: float, z_low: float) -> Geometry:
    """A keel or rudder: a lens-shaped section between two heights, its nose at x + root / 2."""
    t = np.array([1, 0.8, 0.4, -0.3, -1.0])
    wide = np.array([0, 0.7, 1.0, 0.8, 0.0]) * thick / 2
    ring = np.column_stack(
        [np.concatenate([t, t[-2:0:-1]]) / 2, np.concatenate([wide, -wide[-2:0:-1]])]
    )
    ring = np.concatenate([ring, ring[:1]])
    high = np.column_stack([x + ring[:, 0] * root, ring[:, 1], np.full(len(ring), z_top)])
    low = np.column_stack(
        [x + ring[:, 0] * tip - 0.25 * root, ring[:, 1] * 0.8, np.full(len(ring), z_low)]
    )
    return join([sheet(np.stack([low, high])), sheet(np.stack([low[:5], low[[0, 7, 6, 5, 4]]]))])


def catamaran(rng: np.random.Generator) -> Model:
    """A cruising catamaran of 9.5 to 13.5 m: two hulls, bridge deck, saloon, rig, trampoline."""
    length = rng.uniform(9.5, 13.5)
    k = length / 11
    apart = 0.2 * length  # of a hull's middle from the boat's
    hull = Hull(
        length_m=length,
        beam_m=0.17 * length,
        sheer_m=(0.9 * k, 1.25 * k, 1.45 * k),
        keel_m=(0.25 * k, 0.5 * k, 0.3 * k),
        transom=0.75,
        section="round",
        stem_rake_m=0.15,
        stern_rake_m=-0.9 * k,
        bow_power=2.0,
    )
    parts: Parts = {}
    white = _WHITE * rng.uniform(0.95, 1.05)
    stripe = draw_colour(rng, HULL_COLOURS[3:])
    shell = join(
        [
            skin(
                hull,
                [
                    (0.08, draw_colour(rng, BOTTOMS)),
                    ("sheer-0.3", white),
                    ("sheer-0.22", stripe),
                    ("sheer", white),
                ],
                18,
            ),
            deck(hull, white * 0.93, camber_m=0.04),
        ]
    )
    at = np.array([[0, apart, 0], [0, -apart, 0]])
    add(parts, "car_paint", copies(shell, at))
    lights = [box((0.9 * k, 0.02, 0.22 * k), (x * k, 0, 0)) for x in (-1.6, -0.2, 1.2)]
    y = apart + float(hull.half_beam(0.45)) - 0.004
    add(parts, "glass", copies(join(lights), [[0, y, 0.72 * k], [0, -y, 0.72 * k]]))
    # The bridge deck between the hulls, and the saloon on it.
    add(
        parts,
        "paint",
        box((0.62 * length, 2 * apart, 0.42 * k), (-0.1 * length, 0, 0.82 * k), white),
    )
    z = 1.22 * k
    x = np.array([-0.26, -0.1, 0.06, 0.13, 0.17]) * length
    w = np.array([1.05, 1.08, 1.0, 0.7, 0.3]) * apart
    base = np.column_stack([x, w, np.full(5, z)])
    top = base + np.column_stack(
        [np.array([-0.4, -0.15, -0.3, -0.55, -0.7]) * k, -0.12 * w, np.full(5, 1.1 * k)]
    )
    panes = [
        (0, 0.1, 0.95, 0.25, 0.75),
        (1, 0.05, 0.95, 0.25, 0.75),
        (2, 0.06, 0.94, 0.25, 0.75),
        (3, 0.06, 0.94, 0.25, 0.75),
        (4, 0.06, 0.94, 0.25, 0.75),
    ]
    cabin(parts, base, top, white, panes=panes, roof_m=0.1)
    roof_z = z + 1.1 * k
    # Hard top over the cockpit, on posts.
    add(
        parts,
        "paint",
        box((0.17 * length, 1.9 * apart, 0.08), (-0.36 * length, 0, roof_z - 0.06), white),
    )
    posts = np.array([[-0.43 * length, y, 0.9 * k] for y in (0.85 * apart, -0.85 * apart)])
    add(
        parts,
        "metal",
        round_bars(posts, posts * [1, 1, 0] + [0, 0, roof_z], 0.025),
        _wheel(-0.3 * length, 0.7 * apart, z + 0.8 * k, 0.38 * k),
    )
    add(
        parts,
        "paint",
        box((0.14 * length, 1.5 * apart, 0.4 * k), (-0.34 * length, 0, z), white * 0.9),
    )
    # Crossbeam and trampoline forward.
    beam_x = 0.44 * length
    add(parts, "metal", tube([[beam_x, -apart, 1.3 * k], [beam_x, apart, 1.3 * k]], 0.07, 8))
    u, v = np.meshgrid(
        np.linspace(0.2 * length, beam_x, 12), np.linspace(-0.75, 0.75, 14) * apart, indexing="ij"
    )
    add(
        parts,
        "fabric",
        net(np.stack([u, v, np.full_like(u, 1.22 * k)], -1), 0.05, (0.5, 0.5, 0.48)),
    )
    outer = hull.edge(np.linspace(0.15, 0.97, 12), 0.06) + [0, apart, 0]
    add(parts, "metal", both_sides(railing(outer, 0.6, (1, 1, 1), spacing_m=1.9)))
    wide = Hull(
        length_m=length, beam_m=2 * y, sheer_m=hull.sheer_m, keel_m=hull.keel_m, transom=0.9
    )
    boom = 0.42 * length
    gooseneck = mast_and_rigging(
        parts,
        wide,
        [0.12 * length, 0, roof_z - 0.02],
        1.25 * length,
        boom_m=boom,
        spreaders=1,
        chain_y=y - 0.1,
        backstay=False,
    )
    cover = draw_colour(rng, CANVAS)
    add(parts, "fabric", furled_main(gooseneck, boom, cover))
    return finished(parts)


YACHTS = {"sailing_yacht": sailing_yacht, "catamaran": catamaran}
