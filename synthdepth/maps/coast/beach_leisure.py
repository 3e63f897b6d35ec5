"""What bathers bring to a beach: parasols, towels, loungers, windbreaks, boards."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.lofts import between, lathe, sheet
from synthdepth.maps.gardens.parts import WHITE, circle, draw_colour, draw_timber
from synthdepth.maps.geometry import (
    Geometry,
    Model,
    box,
    copies,
    cross,
    join,
    merge,
    quads,
    tube,
    yaw_matrix,
)
from synthdepth.maps.materials.coast import COAST_MEAN

LABEL = "street_furniture"
CLOTHS = np.array(
    [
        [0.5, 0.06, 0.045],
        [0.03, 0.1, 0.32],
        [0.55, 0.38, 0.05],
        [0.04, 0.26, 0.28],
        [0.1, 0.3, 0.1],
        [0.5, 0.22, 0.05],
        [0.42, 0.12, 0.2],
        [0.3, 0.42, 0.5],
        [0.5, 0.46, 0.36],
        [0.05, 0.06, 0.09],
    ]
)
PALE = np.array([0.64, 0.63, 0.58])


def two_cloths(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Two colours for stripes: mostly a colour and white."""
    a = draw_colour(rng, CLOTHS)
    return a, (PALE if rng.random() < 0.7 else draw_colour(rng, CLOTHS))


def _tilted(model: Model, about_y_rad: float) -> Model:
    c, s = np.cos(about_y_rad), np.sin(about_y_rad)
    turn = np.array([[[c, 0, s], [0, 1, 0], [-s, 0, c]]])
    return {key: copies(part, np.zeros((1, 3)), rotation=turn) for key, part in model.items()}


def put(model: Model, at, yaw_rad: float) -> Model:
    """A model set down at `at` (3,) [m]."""
    turn = yaw_matrix(yaw_rad)[None]
    return {key: copies(part, [at], rotation=turn) for key, part in model.items()}


def towel(rng: np.random.Generator) -> Model:
    """A striped towel on the sand, a little rumpled, at times with a bag."""
    one, two = two_cloths(rng)
    length, width, n = rng.uniform(1.5, 1.85), rng.uniform(0.75, 0.95), 10
    x, y = np.meshgrid(
        np.linspace(-length / 2, length / 2, n + 1),
        np.linspace(-width / 2, width / 2, 5),
        indexing="ij",
    )
    z = (
        0.015
        + 0.012 * np.sin(5 * x + rng.uniform(0, 6)) * np.cos(6 * y + rng.uniform(0, 6))
        + rng.uniform(0, 0.008, x.shape)
    )
    z[-1] += rng.uniform(0, 0.05)
    p = np.stack([x, y, z], -1)
    wide = int(rng.integers(1, 4))
    pieces = [sheet(p[k : k + 2][::-1], one if (k // wide) % 2 else two) for k in range(n)]
    edge = np.concatenate([p[:, 0], p[-1, 1:], p[-2::-1, -1], p[0, -2:0:-1]])
    edge = np.concatenate([edge, edge[:1]])
    pieces.append(sheet(np.stack([edge * [1, 1, 0] - [0, 0, 0.03], edge]), one * 0.8))
    model: Model = {("fabric", LABEL): join(pieces)}
    if rng.random() < 0.4:
        bag = join(
            [
                box((0.42, 0.16, 0.3), (0, 0, -0.02)),
                tube(
                    [[-0.12, 0, 0.26], [-0.1, 0, 0.42], [0.1, 0, 0.42], [0.12, 0, 0.26]], 0.012, 4
                ),
            ]
        )
        model = merge(
            [
                model,
                put(
                    {("fabric", LABEL): bag.tinted(draw_colour(rng, CLOTHS))},
                    [-0.5 * length, 0.5 * width + 0.2, 0],
                    0.5,
                ),
            ]
        )
    return model


def cooler(rng: np.random.Generator) -> Model:
    """A cool box with its handle, and mostly a ball and sandals beside it."""
    tint = draw_colour(
        rng, [(0.03, 0.1, 0.32), (0.4, 0.05, 0.04), (0.05, 0.2, 0.22), (0.2, 0.2, 0.2)]
    )
    body = [
        box((0.34, 0.52, 0.34), (0, 0, -0.02), tint),
        box((0.36, 0.54, 0.07), (0, 0, 0.32), WHITE),
        tube(
            [[0, -0.28, 0.25], [0, -0.28, 0.46], [0, 0.28, 0.46], [0, 0.28, 0.25]], 0.014, 5, WHITE
        ),
    ]
    if rng.random() < 0.5:
        t = np.linspace(-np.pi / 2, np.pi / 2, 7)
        n, r = 9, rng.uniform(0.11, 0.2)
        turn = np.linspace(0, 2 * np.pi, n + 1)
        ball = np.stack(
            [
                np.column_stack(
                    [
                        r * np.cos(a) * np.cos(turn),
                        r * np.cos(a) * np.sin(turn),
                        0 * turn + r * np.sin(a) + r - 0.02,
                    ]
                )
                for a in t
            ]
        )
        one, two = two_cloths(rng)
        body += [
            sheet(ball[:, k : k + 2], one if k % 3 == 0 else (two if k % 3 == 1 else PALE)).moved(
                [0.7, 0.3, 0]
            )
            for k in range(n)
        ]
    shoes = [box((0.26, 0.09, 0.025), (-0.5, y, -0.005), (0.06, 0.05, 0.05)) for y in (0.1, 0.24)]
    return {("paint", LABEL): join(body + shoes)}


def parasol(rng: np.random.Generator) -> Model:
    """Eight gores in two colours with a scalloped valance, on a pole that leans from the sun."""
    radius, high = rng.uniform(0.9, 1.3), rng.uniform(1.95, 2.3)
    one, two = two_cloths(rng)
    if rng.random() < 0.3:
        two = one
    n, drop = 8, rng.uniform(0.3, 0.45)
    turn = 2 * np.pi * np.arange(n + 1) / n
    ring = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    levels = ((0.03, 0.0), (0.45, 0.3), (0.8, 0.7), (1.0, 1.0))
    rows = np.stack([ring * radius * r + [0, 0, high - drop * d] for r, d in levels])
    pieces = []
    for k in range(n):
        gore = rows[:, k : k + 2]
        # Cloth sags between its ribs.
        mid = gore.mean(axis=1) - np.array([[0, 0, 0], [0, 0, 0.015], [0, 0, 0.03], [0, 0, 0.03]])
        grid = np.stack([gore[:, 0], mid, gore[:, 1]], axis=1)
        tint = one if k % 2 == 0 else two
        pieces.append(sheet(grid, tint))
        rim = grid[-1]
        hem = rim * [1.005, 1.005, 1] - [0, 0, 0.15] + [[0, 0, 0.04], [0, 0, 0], [0, 0, 0.04]]
        pieces.append(sheet(np.stack([hem, rim]), tint * 0.95))
    ribs = round_bars(
        rows[0, :-1] - [0, 0, 0.02], rows[-1, :-1] - [0, 0, 0.01], 0.006, (0.5, 0.5, 0.5), 3
    )
    pole = tube([[0, 0, -0.35], [0, 0, high + 0.1]], 0.019, 6, WHITE)
    model = {("fabric", LABEL): join(pieces), ("paint", LABEL): join([pole, ribs])}
    model = _tilted(model, rng.uniform(-0.22, 0.22))
    things = [model]
    for _ in range(int(rng.integers(0, 3))):
        spot = [rng.uniform(-1.1, 1.1), rng.choice([-1, 1]) * rng.uniform(0.5, 1.1), 0]
        things.append(put(towel(rng), spot, rng.normal(0, 0.4)))
    if rng.random() < 0.4:
        things.append(put(cooler(rng), [rng.uniform(-0.4, 0.4), 0.3, 0], rng.uniform(0, 6)))
    return merge(things)


def lounger(rng: np.random.Generator) -> Model:
    """A sun lounger with its back raised; head towards -x."""
    frame = draw_timber(rng) if rng.random() < 0.5 else np.array(WHITE)
    material = "wood" if frame[0] < 0.45 else "paint"
    cloth, _ = two_cloths(rng)
    up = np.radians(rng.uniform(15, 60))
    hinge = np.array([-0.3, 0, 0.34])
    head = hinge + 0.75 * np.array([-np.cos(up), 0, np.sin(up)])
    parts, fabric = [], []
    for y in (0.3, -0.3):
        parts += [
            beams([[-0.95, y, 0.31]], [[1.0, y, 0.31]], 0.04, 0.06),
            beams([hinge + [0, y, 0]], [head + [0, y, 0]], 0.035, 0.05),
        ]
        parts += [box((0.05, 0.05, 0.36), (x, y * 1.05, -0.06)) for x in (0.85, -0.7)]
        parts.append(
            beams(
                [[-0.75, y * 0.9, 0.32]],
                [between(hinge, head, [0.6])[0] + [0, y * 0.9, -0.02]],
                0.025,
                0.03,
            )
        )
    slat = np.linspace(-0.22, 0.95, 10)
    parts.append(
        beams(
            np.column_stack([slat, 0 * slat - 0.31, 0 * slat + 0.35]),
            np.column_stack([slat, 0 * slat + 0.31, 0 * slat + 0.35]),
            0.08,
            0.018,
        )
    )
    for a, b in (
        (np.array([1.0, 0, 0.37]), hinge + [0, 0, 0.04]),
        (hinge + [-0.01, 0, 0.04], head + [-0.02, 0, 0.03]),
    ):
        along = (b - a) / np.linalg.norm(b - a)
        up_n = cross(along, [0, 1.0, 0])
        pad = beams([a + up_n * 0.02], [b + up_n * 0.02], 0.54, 0.05)
        fabric.append(pad)
    return {
        (material, LABEL): join(parts).tinted(frame),
        ("fabric", LABEL): join(fabric).tinted(cloth),
    }


def windbreak(rng: np.random.Generator) -> Model:
    """Striped canvas on five or six poles, bowed round its owners."""
    k = int(rng.integers(5, 7))
    span, high = rng.uniform(0.8, 1.0), rng.uniform(1.0, 1.25)
    bend = rng.uniform(0.15, 0.4)
    yaw = (np.arange(k - 1) - (k - 2) / 2) * bend + rng.normal(0, 0.08, k - 1)
    step = np.stack([np.sin(yaw) * -1.0, np.cos(yaw)], -1) * span
    at = np.concatenate([[[0, 0]], np.cumsum(step, axis=0)])
    at -= at.mean(axis=0)
    tilt = rng.normal(0, 0.03, (k, 2))
    foot = np.column_stack([at, np.full(k, -0.3)])
    head = np.column_stack([at + tilt, np.full(k, high + 0.08)])
    colours = [draw_colour(rng, CLOTHS) for _ in range(2)] + [PALE]
    pieces = []
    for i in range(k - 1):
        t = np.linspace(0, 1, 5)
        low, top = between(foot[i], foot[i + 1], t), between(head[i], head[i + 1], t)
        share = np.linspace(0.33 / (high + 0.38), 1 - 0.08 / (high + 0.38), 2)
        belly = 0.07 * np.sin(np.pi * t)[:, None] * np.array([np.cos(yaw[i]), np.sin(yaw[i]), 0])
        rows = np.stack(
            [
                low + s * (top - low) + belly - [0, 0, 0.02] * np.sin(np.pi * t)[:, None]
                for s in share
            ]
        )
        for j in range(4):
            pieces.append(sheet(rows[:, j : j + 2], colours[(4 * i + j) % 3]))
    poles = round_bars(foot, head, 0.014, draw_timber(rng), 5)
    return {("fabric", LABEL): join(pieces), ("wood", LABEL): poles}


def surfboards(rng: np.random.Generator) -> Model:
    """Boards planted in the sand, lying, or standing in a rack."""

    def board(length: float) -> Geometry:
        t = np.linspace(0, 1, 12)
        half = (
            0.5 * rng.uniform(0.46, 0.57) * np.sin(np.pi * np.clip(t * 0.94 + 0.06, 0, 1)) ** 0.55
        )
        half[-1] = 0.004
        rocker = 0.05 * (2 * t - 0.9) ** 2 * length / 2
        u = np.array([-1.0, -0.75, 0.0, 0.75, 1.0])
        x = (t - 0.5) * length

        def face(thick):
            z = rocker[:, None] + thick * (1 - np.abs(u) ** 3)[None]
            return np.stack([np.broadcast_to(x[:, None], z.shape), half[:, None] * u[None], z], -1)

        deck = face(0.035)
        stripe = draw_colour(rng, CLOTHS)
        base = PALE * 1.05 if rng.random() < 0.6 else draw_colour(rng, CLOTHS)
        parts = [
            sheet(deck[:, [0, 1]][::-1], base),
            sheet(deck[:, 1:4][::-1], base * 0.97 if rng.random() < 0.5 else stripe),
            sheet(deck[:, 3:][::-1], base),
            sheet(face(-0.03), base * 0.95),
        ]
        fins = [
            quads(
                np.array(
                    [
                        [
                            [-0.46 * length, y, -0.01],
                            [-0.46 * length + 0.12, y, -0.01],
                            [-0.46 * length + 0.02, y, -0.13],
                            [-0.46 * length - 0.03, y, -0.12],
                        ]
                    ]
                ),
                (0.03, 0.03, 0.03),
            )
            for y in (0.0, 0.1, -0.1)
        ]
        return join([*parts, *fins])

    form, parts, wood = rng.random(), [], []
    if form < 0.4:  # planted upright
        for i in range(int(rng.integers(1, 4))):
            length = rng.uniform(1.8, 2.7)
            lean = rng.normal(0.08, 0.06)
            c, s = np.cos(np.pi / 2 + lean), np.sin(np.pi / 2 + lean)
            up = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
            turn = yaw_matrix(rng.normal(0, 0.3)) @ up
            parts.append(
                copies(
                    board(length),
                    [[rng.normal(0, 0.1), 0.75 * i, length / 2 - 0.28]],
                    rotation=turn[None],
                )
            )
    elif form < 0.65:
        for i in range(int(rng.integers(1, 3))):
            turn = yaw_matrix(rng.normal(0, 0.25))
            parts.append(
                copies(board(rng.uniform(1.8, 2.8)), [[0, 0.8 * i, 0.06]], rotation=turn[None])
            )
    else:  # a rack
        count = int(rng.integers(4, 8))
        y = (np.arange(count) - (count - 1) / 2) * 0.3
        tilt = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
        c, s = np.cos(1.35), np.sin(1.35)
        stand = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]]) @ tilt
        for k in range(count):
            length = rng.uniform(1.9, 2.7)
            parts.append(
                copies(board(length), [[0.12, y[k], length / 2 - 0.03]], rotation=stand[None])
            )
        wide = y[-1] + 0.3
        timber = draw_timber(rng)
        for z, x in ((0.35, 0.22), (1.25, 0.02)):
            wood += [
                beams([[x + d, -wide, z]], [[x + d, wide, z]], 0.05, 0.08, timber)
                for d in (-0.34, 0.38)
            ]
        wood += [
            beams([[x, s * wide, -0.15]], [[x - 0.12, s * wide, 1.5]], 0.07, 0.07, timber)
            for s in (-1, 1)
            for x in (-0.16, 0.56)
        ]
        wood += [
            beams([[-0.3, s * wide, 1.28]], [[0.5, s * wide, 1.28]], 0.05, 0.08, timber)
            for s in (-1, 1)
        ]
    model: Model = {("car_paint", LABEL): join(parts)}
    return {**model, ("wood", LABEL): join(wood)} if wood else model


def sandcastle(rng: np.random.Generator) -> Model:
    """A keep with towers, walls, a moat's bank, a bucket and a spade."""
    tint = np.array([0.21, 0.17, 0.115]) / COAST_MEAN * rng.uniform(0.85, 1.15)
    n = 12

    def tower(r, h):
        return lathe([r * 1.12, r, r, 0.25 * r], [-0.03, 0.6 * h, h, h + 0.02], n)

    side = rng.uniform(0.3, 0.5)
    corner = np.array([[sx * side, sy * side, 0] for sx in (-1, 1) for sy in (-1, 1)])
    parts = [copies(tower(0.1, 0.24), corner), tower(0.17, 0.34)]
    ring = corner[[0, 1, 3, 2]]
    parts.append(beams(ring + [0, 0, 0.05], np.roll(ring, -1, axis=0) + [0, 0, 0.05], 0.09, 0.16))
    bank = circle(2.05 * side, 0, 16)
    parts.append(
        tube(bank + [0, 0, -0.02], 0.1 * (1 + 0.2 * np.sin(np.arange(17) * 2.4)), 6, capped=False)
    )
    parts.append(copies(lathe([0.3, 0.26, 0.1], [-0.04, 0.02, 0.1], 10), [[2.4 * side, 0.4, 0]]))
    tint_b = draw_colour(rng, [(0.5, 0.05, 0.04), (0.03, 0.15, 0.4), (0.55, 0.4, 0.05)])
    bucket = [
        lathe([0.07, 0.1, 0.105], [-0.01, 0.19, 0.2], 10, tint_b).moved([0.5, -2.3 * side, 0]),
        beams([[0.8, -2 * side, 0.02]], [[1.1, -2.2 * side, 0.08]], 0.03, 0.02, tint_b),
    ]
    return {("sand", "obstacle"): join(parts).tinted(tint), ("paint", LABEL): join(bucket)}


LEISURE = {
    "parasol": parasol,
    "towel": towel,
    "lounger": lounger,
    "windbreak": windbreak,
    "cooler": cooler,
    "surfboards": surfboards,
    "sandcastle": sandcastle,
}
