"""What stands on a beach all summer: huts, lifeguards' towers, volleyball nets, flags."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.beach_leisure import CLOTHS, LABEL, PALE, put, two_cloths
from synthdepth.maps.coast.lofts import ROPE, between, lathe, railing, sheet
from synthdepth.maps.gardens.parts import WHITE, draw_colour, draw_timber
from synthdepth.maps.geometry import (
    Model,
    box,
    copies,
    join,
    merge,
    quads,
    tube,
    yaw_matrix,
)


def volleyball_net(rng: np.random.Generator) -> Model:
    """A beach volleyball net of 8.5 m along y: 10 cm mesh, tapes, antennas, guys, court."""
    half, top, deep = 4.25, rng.choice([2.24, 2.43]), 1.0
    post_y = half + 0.75
    pad = draw_colour(rng, CLOTHS)
    posts = [
        tube([[0, s * post_y, -0.6], [0, s * post_y, top + 0.12]], 0.045, 8, (0.45, 0.46, 0.46))
        for s in (-1, 1)
    ]
    pads = [lathe([0.13, 0.13], [-0.1, 1.7], 10, pad).moved([0, s * post_y, 0]) for s in (-1, 1)]
    y = np.linspace(-half, half, 13)
    dip = -0.035 * (1 - (y / half) ** 2)
    rows = []
    for z in np.linspace(0, deep, 11):
        p = np.column_stack([0 * y, y, top - deep + z + dip])
        rows.append(
            quads(
                np.stack(
                    [
                        p[:-1] - [0, 0, 0.002],
                        p[1:] - [0, 0, 0.002],
                        p[1:] + [0, 0, 0.002],
                        p[:-1] + [0, 0, 0.002],
                    ],
                    1,
                ),
                (0.05, 0.05, 0.055),
            )
        )
    yc = np.arange(-half, half + 0.01, 0.1)
    zc = top + -0.035 * (1 - (yc / half) ** 2)
    a, b = np.column_stack([0 * yc, yc, zc - deep]), np.column_stack([0 * yc, yc, zc])
    d = np.array([0, 0.002, 0])
    columns = quads(np.stack([a - d, a + d, b + d, b - d], 1), (0.05, 0.05, 0.055))
    tape = draw_colour(rng, [(0.55, 0.4, 0.04), (0.62, 0.62, 0.6), (0.03, 0.12, 0.35)])
    bands = []
    for z in (0.0, -deep):
        p = np.column_stack([0 * y + 0.003, y, top + z + dip])
        h = np.array([0, 0, 0.04])
        bands.append(quads(np.stack([p[:-1] - h, p[1:] - h, p[1:] + h, p[:-1] + h], 1), tape))
    for s in (-1, 1):
        bands.append(
            quads(
                np.array(
                    [
                        [
                            [0.004, s * half - 0.03, top - deep],
                            [0.004, s * half + 0.03, top - deep],
                            [0.004, s * half + 0.03, top],
                            [0.004, s * half - 0.03, top],
                        ]
                    ]
                ),
                tape,
            )
        )
    cords = round_bars(
        [[0, s * half, top - dz] for s in (-1, 1) for dz in (0.0, deep)]
        + [[0, s * post_y, top] for s in (-1, 1)],
        [[0, s * post_y, top - dz] for s in (-1, 1) for dz in (0.02, deep)]
        + [[0, s * (post_y + 1.6), -0.05] for s in (-1, 1)],
        0.004,
        ROPE,
        3,
    )
    antenna = [
        tube([[0.02, s * 4.0, top - deep], [0.02, s * 4.0, top + 0.8]], 0.006, 4, (0.5, 0.08, 0.06))
        for s in (-1, 1)
    ]
    court = np.array([[-8, -4, 0.012], [8, -4, 0.012], [8, 4, 0.012], [-8, 4, 0.012]])
    nxt = np.roll(court, -1, axis=0)
    lines = []
    for p, q in zip(court, nxt, strict=True):
        leg = between(p, q, np.linspace(0, 1, 9))
        lines.append(beams(leg[:-1], leg[1:], 0.05, 0.05, tape))
    return {
        ("paint", "pole"): join(posts),
        ("fabric", "barrier"): join([*rows, columns, *bands, cords, *pads]),
        ("paint", LABEL): join([*antenna, *lines]),
    }


def _hut(rng: np.random.Generator, width: float, deep: float, high: float) -> Model:
    """One gabled hut of boards on bearers, its doors towards +x."""
    colours = [
        (0.5, 0.14, 0.12),
        (0.1, 0.25, 0.4),
        (0.5, 0.4, 0.12),
        (0.2, 0.38, 0.26),
        (0.55, 0.54, 0.5),
        (0.36, 0.48, 0.52),
        (0.45, 0.3, 0.32),
        (0.04, 0.09, 0.2),
    ]
    tint, trim = draw_colour(rng, colours), np.array(WHITE)
    if rng.random() < 0.2:
        tint, trim = trim, tint
    door_tint = trim if rng.random() < 0.6 else draw_colour(rng, colours)
    floor, gable = 0.35, 0.42 * width
    x, y = deep / 2, width / 2
    wall = []
    striped = rng.random() < 0.25
    n = 10
    edge = np.linspace(-y, y, n + 1)
    peak = floor + high + gable * (1 - np.abs(edge) / y)
    for side in (1, -1):
        corner = np.stack(
            [
                np.column_stack([np.full(n, side * x), edge[:-1], np.full(n, floor)]),
                np.column_stack([np.full(n, side * x), edge[1:], np.full(n, floor)]),
                np.column_stack([np.full(n, side * x), edge[1:], peak[1:]]),
                np.column_stack([np.full(n, side * x), edge[:-1], peak[:-1]]),
            ],
            1,
        )
        tones = np.where((np.arange(n) % 2 == 0)[:, None] & striped, PALE, tint)
        wall.append(
            quads(
                corner if side > 0 else corner[:, [1, 0, 3, 2]],
                tones,
                np.column_stack([edge[:-1], 0 * edge[:-1]]),
            )
        )
        a = np.array([[-side * x, side * y, floor], [side * x, side * y, floor]])
        a = a[::-1]
        wall.append(
            quads(np.stack([a[0], a[1], a[1] + [0, 0, high], a[0] + [0, 0, high]])[None], tint)
        )
    over = 0.18
    roof = []
    for side in (1, -1):
        low = np.array([0, side * (y + 0.12), floor + high - 0.12 * gable / y])
        top = np.array([0, 0, floor + high + gable])
        up = np.array([0, side * gable, y]) / np.hypot(gable, y) * 0.06
        ends = [
            np.stack([low, top, top + up, low + up]) + [s, 0, 0]
            for s in (-x - over, x + 1.8 * over)
        ]
        p = np.stack(ends)
        roof += [
            quads(np.stack([p[0, i], p[1, i], p[1, (i + 1) % 4], p[0, (i + 1) % 4]])[None])
            for i in range(4)
        ]
        roof += [quads(p[e][None]) for e in (0, 1)]
        wall.append(
            beams(
                [[x + 1.8 * over - 0.02, low[1], low[2] - 0.02]],
                [[x + 1.8 * over - 0.02, 0, top[2] - 0.02]],
                0.04,
                0.16,
                trim,
            )
        )
    front = x + 0.02
    half = min(0.62, 0.62 * y)
    paint = []
    ajar = rng.random() < 0.35
    for s in (-1, 1):
        leaf = box((0.035, half, 1.85), (0, s * half / 2, 0), door_tint)
        if ajar:
            turn = yaw_matrix(s * rng.uniform(1.3, 2.6))
            leaf = copies(
                leaf.moved([0, -s * half, 0]),
                [[front + 0.03, s * half, floor + 0.05]],
                rotation=turn[None],
            )
        else:
            leaf = leaf.moved([front, s * 0.004, floor + 0.05])
        paint.append(leaf)
    if ajar:
        paint.append(
            quads(
                np.array(
                    [
                        [
                            [front - 0.008, -half, floor + 0.05],
                            [front - 0.008, half, floor + 0.05],
                            [front - 0.008, half, floor + 1.9],
                            [front - 0.008, -half, floor + 1.9],
                        ]
                    ]
                ),
                (0.025, 0.024, 0.022),
            )
        )
    paint += [box((0.05, 0.08, 1.95), (front, s * (half + 0.05), floor), trim) for s in (-1, 1)]
    paint.append(box((0.05, 2 * half + 0.18, 0.09), (front, 0, floor + 1.92), trim))
    paint += [
        box((0.08, 0.08, high), (sx * x, sy * y, floor), trim) for sx in (-1, 1) for sy in (-1, 1)
    ]
    timber = draw_timber(rng)
    wood = [
        box((deep + 0.9, width - 0.1, 0.06), (0.4, 0, floor - 0.07), timber),
        box((0.35, 1.0, 0.2), (x + 1.05, 0, -0.06), timber),
    ]
    wood += [
        box((0.14, 0.14, floor + 0.42), (sx * (x - 0.2), sy * (y - 0.2), -0.5), timber * 0.8)
        for sx in (-1, 0, 1)
        for sy in (-1, 1)
    ]
    return {
        ("siding", "building"): join(wall[:4]) if not striped else join([]),
        ("paint", "building"): join([*wall[4:], *paint, *(wall[:4] if striped else [])]),
        ("shingle", "roof"): join(roof).tinted(
            draw_colour(rng, [(0.1, 0.1, 0.105), (0.16, 0.1, 0.08), (0.2, 0.2, 0.19)])
        ),
        ("wood", "building"): join(wood),
    }


def _without_empty(model: Model) -> Model:
    return {key: part for key, part in model.items() if len(part.faces)}


def beach_hut(rng: np.random.Generator) -> Model:
    """A single hut, its doors towards +x."""
    return _without_empty(
        _hut(rng, rng.uniform(1.9, 2.4), rng.uniform(2.2, 2.7), rng.uniform(1.95, 2.15))
    )


def hut_row(rng: np.random.Generator) -> Model:
    """Five to eight huts side by side along y, each in its own colours."""
    count, width, deep, high = int(rng.integers(5, 9)), rng.uniform(1.9, 2.3), 2.4, 2.05
    y = (np.arange(count) - (count - 1) / 2) * (width + 0.55)
    return _without_empty(
        merge(put(_hut(rng, width, deep, high), [rng.normal(0, 0.03), q, 0], 0.0) for q in y)
    )


def lifeguard_tower(rng: np.random.Generator) -> Model:
    """A cabin on stilts with a deck, a ramp, a flag and a lifebuoy; or a high chair."""
    paint = draw_colour(
        rng,
        [
            (0.5, 0.12, 0.05),
            (0.55, 0.4, 0.06),
            (0.62, 0.62, 0.58),
            (0.2, 0.42, 0.5),
            (0.5, 0.07, 0.05),
        ],
    )
    timber, white = draw_timber(rng) * 1.1, np.array(WHITE)
    if rng.random() < 0.35:
        return _lifeguard_chair(rng, white if rng.random() < 0.5 else timber, paint)
    floor = rng.uniform(1.3, 2.0)
    wood = [box((3.9, 3.0, 0.12), (0.25, 0, floor - 0.12), timber)]
    for a in (-1.4, 0.2, 1.9):
        for b in (-1.25, 1.25):
            wood.append(
                beams([[a * 1.12, b * 1.12, -0.6]], [[a, b, floor - 0.1]], 0.16, 0.16, timber)
            )
    wood.append(
        beams(
            [[-1.45, -1.3, 0.1], [-1.45, 1.3, 0.1], [1.95, -1.3, 0.1], [1.95, 1.3, 0.1]],
            [
                [1.95, -1.25, floor - 0.2],
                [1.95, 1.25, floor - 0.2],
                [-1.45, -1.25, floor - 0.2],
                [-1.45, 1.25, floor - 0.2],
            ],
            0.06,
            0.14,
            timber * 0.9,
        )
    )
    cx, half_x, half_y, high = -0.55, 0.95, 1.1, 2.15
    base = np.array(
        [
            [cx - half_x, -half_y, floor],
            [cx + half_x, -half_y, floor],
            [cx + half_x, half_y, floor],
            [cx - half_x, half_y, floor],
        ]
    )
    nxt = np.roll(base, -1, axis=0)
    walls = quads(np.stack([base, nxt, nxt + [0, 0, high], base + [0, 0, high]], 1), paint)
    glass, trim = [], []
    for i in range(4):
        a, b = base[i], nxt[i]
        along = (b - a) / np.linalg.norm(b - a)
        normal = np.array([along[1], -along[0], 0]) * 0.012
        door = i == 3
        u0, u1, z0, z1 = (0.3, 0.72, 0.02, 1.95) if door else (0.14, 0.86, 0.95, 1.75)
        q = (
            np.stack(
                [a + (b - a) * u + [0, 0, z] for u, z in ((u0, z0), (u1, z0), (u1, z1), (u0, z1))]
            )
            + normal
        )
        (trim if door else glass).append(quads(q[None], white * 0.9 if door else (1, 1, 1)))
        trim.append(beams(q + normal, np.roll(q, -1, axis=0) + normal, 0.05, 0.07, white))
        if not door:
            trim.append(
                beams([(q[0] + q[1]) / 2 + normal], [(q[2] + q[3]) / 2 + normal], 0.04, 0.04, white)
            )
    roof = box((2.6, 2.9, 0.09), (cx + 0.15, 0, floor + high), white * 0.95)
    trim.append(box((0.03, 1.5, 0.4), (cx + 0.15 + 1.32, 0, floor + high - 0.02), paint * 0.8))
    deck_edge = np.array(
        [[-1.65, 1.45, floor], [2.15, 1.45, floor], [2.15, -1.45, floor], [-1.65, -1.45, floor]]
    )
    rails = railing(deck_edge, 0.95, white, spacing_m=1.0, radius_m=0.03, wires=2)
    ramp = [beams([[-1.65, 0, floor - 0.06]], [[-1.65 - 2.6 * floor, 0, -0.1]], 1.1, 0.07, timber)]
    for s in (-1, 1):
        a, b = (
            np.array([-1.65, s * 0.58, floor + 0.9]),
            np.array([-1.65 - 2.4 * floor, s * 0.58, 0.95]),
        )
        k = between(a, b, np.linspace(0, 1, 5))
        ramp += [
            beams([a], [b], 0.06, 0.08, white),
            round_bars(k - [0, 0, 1.05], k, 0.03, white, 5),
        ]
    turn = np.linspace(0, 2 * np.pi, 17)
    buoy = tube(
        np.column_stack(
            [np.full(17, 2.22), 0.75 + 0.3 * np.cos(turn), floor + 0.5 + 0.3 * np.sin(turn)]
        ),
        0.055,
        6,
        (0.5, 0.16, 0.03),
        capped=False,
    )
    pole = tube(
        [[cx, half_y + 0.05, floor], [cx, half_y + 0.05, floor + high + 2.2]], 0.025, 6, white
    )
    flag = _flag(rng, [cx, half_y + 0.05, floor + high + 2.15])
    return merge(
        [
            {
                ("wood", "building"): join([*wood, ramp[0]]),
                ("siding", "building"): walls,
                ("glass", "building"): join(glass),
                ("paint", "building"): join([*trim, roof]),
                ("paint", "barrier"): join([rails, *ramp[1:]]),
                ("paint", "pole"): pole,
                ("fabric", LABEL): buoy,
            },
            flag,
        ]
    )


def _lifeguard_chair(rng: np.random.Generator, tint, paint) -> Model:
    seat = rng.uniform(1.7, 2.2)
    parts = []
    for y in (0.5, -0.5):
        parts += [
            beams([[0.75, y * 1.3, -0.3]], [[0.3, y, seat + 0.6]], 0.09, 0.09),
            beams([[-0.75, y * 1.3, -0.3]], [[-0.3, y, seat + 1.1]], 0.09, 0.09),
        ]
        parts.append(beams([[0.36, y, seat + 0.3]], [[-0.36, y, seat + 0.3]], 0.06, 0.1))
        parts.append(
            beams(
                [[0.68, y * 1.25, 0.25], [-0.68, y * 1.25, 0.25]],
                [[-0.42, y, seat - 0.1], [0.42, y, seat - 0.1]],
                0.05,
                0.08,
            )
        )
    z = np.arange(0.2, seat, 0.33)
    x = np.interp(z, [-0.3, seat + 0.6], [0.75, 0.3])
    y = np.interp(z, [-0.3, seat + 0.6], [0.65, 0.5])
    parts.append(beams(np.column_stack([x, -y, z]), np.column_stack([x, y, z]), 0.05, 0.09))
    parts += [box((0.75, 1.1, 0.05), (0, 0, seat)), box((0.05, 1.05, 0.55), (-0.33, 0, seat + 0.3))]
    roof = box((1.5, 1.5, 0.06), (0, 0, seat + 1.9), paint)
    props = round_bars(
        [[sx * 0.35, sy * 0.5, seat + 0.5] for sx in (-1, 1) for sy in (-1, 1)],
        [[sx * 0.6, sy * 0.65, seat + 1.92] for sx in (-1, 1) for sy in (-1, 1)],
        0.025,
        WHITE,
        5,
    )
    return {("wood", LABEL): join(parts).tinted(tint), ("paint", LABEL): join([roof, props])}


def _flag(rng: np.random.Generator, top, width: float = 1.0, high: float = 0.7) -> Model:
    """A flag blown out from a pole's top in two colours."""
    u = np.linspace(0, 1, 9)
    yaw = rng.uniform(0, 2 * np.pi)
    away, side = np.array([np.cos(yaw), np.sin(yaw), 0]), np.array([-np.sin(yaw), np.cos(yaw), 0])
    droop = rng.uniform(0.05, 0.5)
    line = (
        u[:, None] * away * width
        + (0.09 * np.sin(7 * u + rng.uniform(0, 6)) * u)[:, None] * side
        - (droop * u**2)[:, None] * [0, 0, 1]
    )
    rows = [
        np.asarray(top) + line - [0, 0, high * t] + (0.03 * t * np.sin(9 * u))[:, None] * side
        for t in (1.0, 0.5, 0.0)
    ]
    pair = [
        ((0.5, 0.05, 0.04), (0.6, 0.45, 0.04)),
        ((0.05, 0.25, 0.08), (0.05, 0.25, 0.08)),
        ((0.5, 0.05, 0.04), (0.5, 0.05, 0.04)),
        ((0.03, 0.08, 0.3), (0.62, 0.62, 0.6)),
        ((0.6, 0.45, 0.04), (0.6, 0.45, 0.04)),
    ][rng.integers(5)]
    return {
        ("fabric", LABEL): join(
            [sheet(np.stack(rows[:2]), pair[1]), sheet(np.stack(rows[1:]), pair[0])]
        )
    }


def beach_flag(rng: np.random.Generator) -> Model:
    """A flag on a pole of 4 to 7 m, or a tall feather banner."""
    if rng.random() < 0.3:
        high = rng.uniform(3.0, 4.2)
        t = np.linspace(0, 1, 10)
        path = np.column_stack(
            [
                0.75 * np.clip(t - 0.55, 0, 1) ** 2 * 4.2,
                0 * t,
                high * np.minimum(t, 1) - 0.25 * (t > 0.95),
            ]
        )
        one, two = two_cloths(rng)
        edge = path[2:] * [0, 0, 1] + [0.02, 0, 0]
        rows = np.stack(
            [
                edge
                + np.column_stack(
                    [
                        0.68 * np.sin(np.linspace(0.55, 1.5, 8) * 1.6) * 0.9,
                        0.06 * np.sin(5 * t[2:]),
                        -0.1 * t[2:],
                    ]
                ),
                np.maximum(path[2:], edge),
            ]
        )
        pieces = [sheet(rows[:, k : k + 2], one if k < 6 else two) for k in range(7)]
        return {
            ("fabric", LABEL): join(pieces),
            ("paint", "pole"): tube(
                np.concatenate([[[0, 0, -0.3]], path]), 0.014, 5, (0.2, 0.2, 0.2)
            ),
        }
    high = rng.uniform(4.0, 7.0)
    pole = lathe(
        [0.045, 0.04, 0.028, 0.028, 0.05, 0.02],
        [-0.5, 0.5, high, high + 0.02, high + 0.06, high + 0.12],
        8,
        WHITE,
    )
    halyard = round_bars([[0.06, 0, 1.1]], [[0.035, 0, high]], 0.004, (0.5, 0.5, 0.48), 3)
    return merge(
        [
            {("paint", "pole"): join([pole, halyard])},
            _flag(rng, [0, 0, high - 0.05], rng.uniform(1.0, 1.6), rng.uniform(0.7, 1.0)),
        ]
    )


BEACH_BUILDINGS = {
    "volleyball_net": volleyball_net,
    "beach_hut": beach_hut,
    "hut_row": hut_row,
    "lifeguard_tower": lifeguard_tower,
    "beach_flag": beach_flag,
}
