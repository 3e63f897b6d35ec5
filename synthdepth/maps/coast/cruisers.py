"""Motor cruisers of 7.5 to 12 m."""

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.coast.boat_parts import (
    BLACK,
    Parts,
    add,
    cabin,
    cleats,
    fenders,
    finished,
    put,
    side_rails,
    windscreen,
)
from synthdepth.maps.coast.hulls import Hull, deck, rub_rail, skin
from synthdepth.maps.coast.lofts import both_sides, sheet
from synthdepth.maps.coast.small_craft import BOTTOMS, HULL_COLOURS
from synthdepth.maps.gardens.parts import draw_colour, draw_timber
from synthdepth.maps.geometry import Model, box, tube

_WHITE = np.array([0.7, 0.7, 0.67])


def cabin_cruiser(rng: np.random.Generator) -> Model:
    """A motor cruiser of 7.5 to 12 m: raked cabin, perhaps a flybridge, radar arch, rails."""
    length = rng.uniform(7.5, 12.0)
    k = length / 9.5
    hull = Hull(
        length_m=length,
        beam_m=0.345 * length,
        sheer_m=(0.95 * k, 1.08 * k, 1.55 * k),
        keel_m=(0.45 * k, 0.5 * k, 0.15),
        transom=0.92,
        section="chine",
        stem_rake_m=1.7 * k,
        bow_power=2.3,
        widest=0.36,
        stern_rake_m=-0.1,
    )
    white = _WHITE * rng.uniform(0.94, 1.05)
    accent = draw_colour(rng, HULL_COLOURS[3:8])
    dark_hull = rng.random() < 0.25
    parts: Parts = {}
    add(
        parts,
        "car_paint",
        skin(
            hull,
            [
                (0.08, draw_colour(rng, BOTTOMS)),
                (0.18, accent),
                ("sheer-0.32", accent if dark_hull else white),
                ("sheer-0.24", accent),
                ("sheer", white),
            ],
            20,
        ),
        deck(hull, white * 0.94, wells=[(0.04, 0.28, 0.42 * hull.beam_m, 0.42 * k)], camber_m=0.1),
    )
    add(parts, "paint", rub_rail(hull, 0.032, (0.3, 0.3, 0.3), below_m=0.04))
    s = np.array([0.29, 0.42, 0.55, 0.68, 0.8])
    foot = hull.edge(s)
    base = foot.copy()
    base[:, 1] *= [0.84, 0.84, 0.82, 0.7, 0.34]
    base[:, 2] -= 0.03
    # A low forward cabin, and the wheelhouse standing in its after part.
    low_top = base + np.column_stack(
        [
            [0, 0, -0.05, -0.12, -0.3],
            -0.06 * np.ones(5) * k,
            np.array([0.55, 0.55, 0.5, 0.38, 0.1]) * k,
        ]
    )
    low_top[:, 1] = np.maximum(low_top[:, 1], 0.12)
    cabin(parts, base, low_top, white, panes=[(2, 0.1, 0.9, 0.35, 0.8), (3, 0.1, 0.6, 0.35, 0.75)])
    z = float(low_top[1, 2]) - 0.08
    x = np.array([s[0] - 0.5, s[1] - 0.5, s[2] - 0.48, s[2] - 0.455]) * length
    w = np.array([0.4, 0.41, 0.385, 0.3]) * hull.beam_m
    wheel_base = np.column_stack([x, w, np.full(4, z)])
    rake = rng.uniform(0.5, 0.9) * k
    high = 1.0 * k + 0.12
    wheel_top = wheel_base + np.column_stack([[0, 0, -rake, -rake], -0.1 * w, np.full(4, high)])
    panes = [
        (0, 0.08, 0.94, 0.28, 0.85),
        (1, 0.06, 0.92, 0.22, 0.85),
        (2, 0.08, 0.95, 0.15, 0.85),
        (3, 0.03, 0.485, 0.15, 0.85),
        (3, 0.515, 0.97, 0.15, 0.85),
    ]
    rim = cabin(parts, wheel_base, wheel_top, white, panes=panes, roof_m=0.06)
    roof = float(rim[:, 2].max())
    aft = np.array([x[0] - 0.12 * length, x[0] + 0.02])
    add(parts, "paint", box((np.ptp(aft), 1.7 * w[0], 0.07), (aft.mean(), 0, roof - 0.08), white))
    props = np.array([[aft[0] + 0.1, 0.78 * w[0], 0.9 * k]])
    add(
        parts,
        "metal",
        both_sides(round_bars(props, props * [1, 1, 0] + [0, 0, roof - 0.05], 0.022)),
    )
    if rng.random() < 0.5:  # flybridge
        mid = np.array([x[0] + 0.06 * length, 0, roof])
        plan = [
            [mid[0] + 0.14 * length, 0, roof],
            [mid[0] + 0.12 * length, 0.55 * w[0], roof],
            [mid[0] - 0.02 * length, 0.72 * w[0], roof],
            [mid[0] - 0.13 * length, 0.74 * w[0], roof],
        ]
        low = np.array(plan)
        wall = np.stack([low, low + [0.08, 0, 0.5 * k]])
        add(
            parts,
            "paint",
            both_sides(sheet(wall[:, ::-1], white)),
            box((0.5, 0.9 * w[0], 0.5 * k), (mid[0], 0, roof), white * 0.95),
        )
        put(parts, windscreen(low[:3] + [0.06, 0, 0.5 * k], 0.25, 0.15), (0, 0, 0))
        roof += 0.5 * k
    xa = x[0] - 0.02 * length
    wa = 0.8 * w[0]
    arch = [
        [xa + 0.3, wa, roof - 0.15],
        [xa - 0.2, 0.92 * wa, roof + 0.55],
        [xa - 0.3, 0.6 * wa, roof + 0.72],
        [xa - 0.3, -0.6 * wa, roof + 0.72],
        [xa - 0.2, -0.92 * wa, roof + 0.55],
        [xa + 0.3, -wa, roof - 0.15],
    ]
    add(
        parts,
        "paint",
        tube(arch, 0.06, 6, white),
        tube([[xa - 0.3, 0, roof + 0.75], [xa - 0.3, 0, roof + 0.95]], [0.24, 0.2], 10, white),
    )
    add(
        parts,
        "paint",
        round_bars(
            [[xa - 0.3, 0.5 * wa, roof + 0.7], [xa - 0.3, -0.4 * wa, roof + 0.7]],
            [[xa - 0.8, 0.5 * wa, roof + 2.7], [xa - 0.35, -0.4 * wa, roof + 1.6]],
            0.007,
            (0.6, 0.6, 0.58),
            4,
        ),
    )
    cushion = draw_colour(rng, [(0.6, 0.58, 0.52), (0.05, 0.08, 0.2), (0.35, 0.3, 0.24)])
    bench = (-0.43 * length, 0, 0.42 * k)
    add(
        parts,
        "fabric",
        box((0.5 * k, 0.7 * hull.beam_m, 0.42 * k), bench, cushion),
        box(
            (0.9 * k, 0.5 * hull.beam_m, 0.09),
            (0.27 * length, 0, float(low_top[3, 2]) - 0.02),
            cushion,
        ),
    )
    add(
        parts,
        "wood",
        box(
            (0.55 * k, 0.82 * hull.beam_m, 0.05), (-length / 2 - 0.2 * k, 0, 0.22), draw_timber(rng)
        ),
    )
    ladder = np.array([[-length / 2 - 0.5 * k, y, 0.15] for y in (0.3, 0.6)])
    add(
        parts,
        "metal",
        round_bars(ladder - [0, 0, 0.5], ladder + [0, 0, 0.6], 0.014),
        side_rails(hull, 0.42, 1.0, 0.55 * k, inset_m=0.06, wires=1, spacing_m=0.95),
        cleats(hull, [0.03, 0.5, 0.9]),
    )
    add(parts, "paint", box((0.5, 0.06, 0.1), (0.47 * length, 0, 1.56 * k), BLACK))
    fenders(rng, parts, hull, int(rng.integers(2, 4)))
    return finished(parts)


CRUISERS = {"cabin_cruiser": cabin_cruiser}
