"""Small things along a pavement: bins, hydrants, bollards, boxes, planters, covers."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.parts import (
    BLACK,
    BLUE,
    COATS,
    DARK_STEEL,
    GREEN,
    RED,
    STEEL,
    TIMBER,
    WHITE,
    YELLOW,
    Surfaces,
    boxes,
    choice,
    disc,
    extruded,
    item,
    lathe,
    ringed,
    turned,
)
from synthdepth.maps.furniture.posters import decals, lettering, poster
from synthdepth.maps.geometry import box, copies, geometry, join, merge, tube
from synthdepth.maps.vegetation.shrubs import bushes, flowers


def litter_bin(rng: np.random.Generator) -> Surfaces:
    """A public bin, 0.9-1.1 m: slatted, of sheet steel with a hood, or hung on a post."""
    coat, kind = choice(rng, COATS), rng.integers(4)
    if kind == 0:
        wood = choice(rng, TIMBER)
        slat = box((0.022, 0.085, 0.72), (0, 0, 0.10), wood)
        rings = [lathe([(0.255, z), (0.255, z + 0.03)], 16, coat) for z in (0.16, 0.70)]
        liner = lathe([(0.22, 0.05), (0.23, 0.80), (0.19, 0.801), (0.19, 0.5)], 14, DARK_STEEL)
        base = lathe([(0.14, -0.03), (0.14, 0.06)], 10, coat)
        legs = [
            round_bars([[s * 0.25, 0, 0.75]], [[s * 0.25, 0, 1.02]], 0.012, coat) for s in (-1, 1)
        ]
        lid = lathe([(0.27, 1.0), (0.27, 1.03), (0.12, 1.09), (0.02, 1.1)], 16, coat)
        return item(wood=[ringed(slat, 16, 0.27)], paint=[*rings, liner, base, *legs, lid])
    if kind == 1:
        body = box((0.46, 0.52, 0.86), (0, 0, 0.06), coat)
        foot = box((0.40, 0.46, 0.1), (0, 0, -0.03), BLACK)
        hood = extruded(
            [(-0.25, 0.92), (0.25, 0.92), (0.25, 1.12), (0.14, 1.20), (-0.14, 1.20), (-0.25, 1.12)],
            0.56,
            coat,
        )
        mouth = box((0.012, 0.34, 0.13), (0.249, 0, 0.97), BLACK)
        plate = decals([[-0.1, 0.5, 0.1, 0.7]], WHITE, 1).moved([0.23, 0, 0])
        text = decals(lettering("BIN", 0.07), BLACK, 2).moved([0.23, 0, 0.6])
        return item(paint=[body, foot, hood, mouth, plate, text])
    if kind == 2:
        colour = choice(rng, (GREEN, (0.45, 0.2, 0.02), STEEL, DARK_STEEL))
        post = tube([[-0.22, 0, -0.05], [-0.22, 0, 1.2]], 0.03, 6, STEEL)
        bucket = lathe(
            [(0.14, 0.42), (0.18, 0.50), (0.2, 0.95), (0.18, 0.951), (0.15, 0.6)], 12, colour
        )
        arm = [box((0.06, 0.05, 0.04), (-0.2, 0, z)) for z in (0.55, 0.85)]
        return item(paint=[post, bucket, join(arm).tinted(STEEL)])
    shell = lathe([(0.24, -0.03), (0.26, 0.02), (0.26, 0.78), (0.27, 0.8), (0.27, 0.84)], 16, coat)
    dome = lathe([(0.265, 1.04), (0.26, 1.10), (0.20, 1.19), (0.09, 1.24), (0.01, 1.25)], 16, coat)
    stays = ringed(box((0.02, 0.06, 0.24), (0, 0, 0.82), coat), 4, 0.24)
    dark = lathe([(0.225, 0.845), (0.225, 0.85)], 14, BLACK)
    band = lathe([(0.264, 0.6), (0.264, 0.68)], 16, choice(rng, (WHITE, GREEN, YELLOW)))
    return item(paint=[shell, dome, stays, dark, band])


def hydrant(rng: np.random.Generator) -> Surfaces:
    """A pillar hydrant of cast iron, 0.75 m, its large outlet to the front."""
    colour = choice(rng, (RED, RED, YELLOW, (0.30, 0.31, 0.3)))
    cap_tint = choice(rng, (colour, WHITE, STEEL, BLUE))
    barrel = lathe(
        [
            (0.15, -0.05),
            (0.15, 0.045),
            (0.10, 0.06),
            (0.092, 0.12),
            (0.088, 0.46),
            (0.13, 0.475),
            (0.13, 0.505),
            (0.115, 0.52),
            (0.115, 0.57),
            (0.095, 0.64),
            (0.05, 0.69),
            (0.03, 0.70),
            (0.03, 0.74),
        ],
        12,
        colour,
    )
    bolts = [
        ringed(lathe([(0.014, z), (0.014, z + 0.03)], 6, colour), 8, r)
        for z, r in ((0.04, 0.128), (0.50, 0.115))
    ]
    outlet = lathe(
        [(0.06, 0.07), (0.06, 0.11), (0.075, 0.115), (0.075, 0.16), (0.028, 0.165), (0.028, 0.19)],
        8,
        cap_tint,
    )
    large = lathe(
        [(0.075, 0.07), (0.075, 0.11), (0.095, 0.115), (0.095, 0.17), (0.03, 0.175), (0.03, 0.2)],
        8,
        cap_tint,
    )
    caps = [turned(large, 0, (0, 0, 0.36), np.pi / 2)]
    caps += [turned(outlet, s * np.pi / 2, (0, 0, 0.40), np.pi / 2) for s in (1, -1)]
    sag = np.array([[0.0, 0.175, 0.39], [0.05, 0.15, 0.30], [0.09, 0.06, 0.28], [0.10, 0.0, 0.32]])
    chains = [tube(sag * [1, s, 1], 0.006, 3, DARK_STEEL) for s in (1, -1)]
    return item(paint=[barrel, *bolts, *caps, *chains])


def bollard(rng: np.random.Generator) -> Surfaces:
    """A bollard of 0.85-1.05 m: plain steel with a band, cast iron, timber or concrete."""
    kind, coat = rng.integers(4), choice(rng, COATS)
    if kind == 0:
        post = lathe([(0.055, -0.08), (0.055, 0.96), (0.03, 0.98)], 10, coat)
        bands = [lathe([(0.058, z), (0.058, z + 0.06)], 10, WHITE) for z in (0.80,)]
        return item(paint=[post, *bands])
    if kind == 1:
        profile = [
            (0.11, -0.08),
            (0.11, 0.10),
            (0.085, 0.13),
            (0.07, 0.20),
            (0.062, 0.72),
            (0.085, 0.74),
            (0.085, 0.78),
            (0.055, 0.81),
            (0.075, 0.87),
            (0.06, 0.93),
            (0.015, 0.96),
        ]
        return item(paint=[lathe(profile, 10, coat)])
    if kind == 2:
        wood = choice(rng, TIMBER)
        post = box((0.15, 0.15, 1.0), (0, 0, -0.1), wood)
        point = lathe([(0.104, 0.9), (0.02, 0.97)], 4, wood)
        turn = np.pi / 4
        return item(
            wood=[post, turned(point, turn)], paint=[box((0.158, 0.158, 0.05), (0, 0, 0.76), WHITE)]
        )
    profile = [(0.17, -0.08), (0.17, 0.6), (0.155, 0.72), (0.11, 0.81), (0.04, 0.85)]
    return item(concrete=[lathe(profile, 12)])


def planter(rng: np.random.Generator) -> Surfaces:
    """A trough or a bowl of concrete, timber or steel, with shrubs and flowers."""
    long, wide, high = rng.uniform(0.9, 1.7), rng.uniform(0.5, 0.8), rng.uniform(0.42, 0.6)
    kind = rng.integers(3)
    x = np.array([-1, 1, 0, 0]) * (wide / 2 - 0.035)
    y = np.array([0, 0, -1, 1]) * (long / 2 - 0.035)
    size = np.array([[0.07, long, high]] * 2 + [[wide - 0.14, 0.07, high]] * 2)
    walls = boxes(size, np.column_stack([x, y, np.full(4, -0.04)]))
    soil = box((wide - 0.13, long - 0.13, 0.05), (0, 0, high - 0.16))
    parts: dict = {("soil", "street_furniture"): soil}
    if kind == 0:
        parts["concrete", "street_furniture"] = walls
    elif kind == 1:
        wood = choice(rng, TIMBER)
        z = np.array([0.06, 0.2, 0.34, 0.48])
        z = z[z < high - 0.02]
        edge = 0.5 * np.array([wide, long]) + 0.012
        level = np.repeat(z, 2)
        s = np.tile([1, -1], len(z))
        front = np.column_stack([s * edge[0], 0 * s - edge[1], level])
        side = np.column_stack([0 * s - edge[0], s * edge[1], level])
        boards = [
            beams(front, front * [1, -1, 1], 0.025, 0.13, wood),
            beams(side, side * [-1, 1, 1], 0.025, 0.13, wood),
        ]
        corner = np.array([[a, b] for a in (-1, 1) for b in (-1, 1)]) * (edge - 0.02)
        posts = boxes((0.08, 0.08, high + 0.06), np.column_stack([corner, np.full(4, -0.03)]), wood)
        parts["wood", "street_furniture"] = join([*boards, posts])
        parts["paint", "street_furniture"] = walls.tinted(DARK_STEEL)
    else:
        parts["paint", "street_furniture"] = walls.tinted(
            choice(rng, ((0.09, 0.045, 0.025), *COATS))
        )
    count = max(2, round(long / 0.45))
    spots = np.column_stack(
        [
            rng.normal(0, 0.03, count),
            (np.arange(count) + 0.5) / count * long - long / 2,
            np.full(count, high - 0.12),
        ]
    )
    spots[:, 1] *= 0.85
    plants = [bushes(rng, spots, rng.uniform(0.4, 0.65, count), 0.0, 1)]
    beds = rng.uniform(
        [-wide / 2 + 0.1, -long / 2 + 0.1], [wide / 2 - 0.1, long / 2 - 0.1], (14, 2)
    )
    at = np.column_stack([beds, np.full(14, high - 0.12)])
    plants.append(flowers(rng, at, rng.uniform(0.16, 0.3, 14)))
    return merge([parts, *plants])


def mailbox(rng: np.random.Generator) -> Surfaces:
    """A letter box of the post: a blue vault on legs, a red pillar, or a yellow box on a post."""
    kind = rng.integers(3)
    if kind == 0:
        turn = np.linspace(0, np.pi, 8)
        vault = [
            (-0.25, 0.18),
            (0.25, 0.18),
            *((0.25 * np.cos(t), 1.0 + 0.25 * np.sin(t)) for t in turn),
        ]
        body = extruded(vault, 0.55, BLUE)
        legs = boxes(
            (0.05, 0.05, 0.24), [[a, b, -0.04] for a in (-0.21, 0.21) for b in (-0.23, 0.23)], BLUE
        )
        flap = turned(
            box((0.02, 0.42, 0.16), (0, 0, 0), (0.03, 0.08, 0.26)), 0, (0.245, 0, 1.0), -0.25
        )
        stripe = [box((0.512, 0.56, 0.03), (0, 0, 0.24), RED)]
        text = decals(lettering("MAIL", 0.11), WHITE, 1).moved([0.25, 0, 0.72])
        return item(paint=[body, legs, flap, *stripe, text])
    if kind == 1:
        red = choice(rng, (RED,))
        pillar = lathe(
            [
                (0.26, -0.05),
                (0.26, 0.16),
                (0.235, 0.19),
                (0.23, 1.33),
                (0.27, 1.36),
                (0.275, 1.42),
                (0.24, 1.47),
                (0.12, 1.54),
                (0.02, 1.56),
            ],
            16,
            red,
        )
        base = lathe([(0.265, -0.05), (0.265, 0.15)], 16, BLACK)
        slot = box((0.02, 0.22, 0.035), (0.222, 0, 1.20), BLACK)
        hood = box((0.05, 0.28, 0.02), (0.235, 0, 1.25), red)
        plate = box((0.014, 0.15, 0.2), (0.226, 0, 0.9), WHITE)
        door = box((0.012, 0.24, 0.55), (0.225, 0, 0.30), tuple(0.8 * np.array(red)))
        return item(paint=[pillar, base, slot, hood, plate, door])
    colour = choice(rng, (YELLOW, YELLOW, RED, BLUE))
    post = tube([[-0.02, 0, -0.05], [-0.02, 0, 0.86]], 0.04, 6, STEEL)
    body = extruded(
        [(-0.16, 0.8), (0.16, 0.8), (0.16, 1.18), (0.05, 1.27), (-0.16, 1.27)], 0.45, colour
    )
    slot = box((0.012, 0.30, 0.04), (0.157, 0, 1.1), BLACK)
    plate = box((0.012, 0.2, 0.12), (0.157, 0, 0.9), WHITE)
    return item(paint=[post, body, slot, plate])


def parking_meter(rng: np.random.Generator) -> Surfaces:
    """A single-space meter on a post, or a pay station with a solar panel."""
    coat = choice(rng, COATS)
    if rng.random() < 0.55:
        post = tube([[0, 0, -0.05], [0, 0, 1.08]], 0.03, 7, STEEL)
        head = lathe(
            [(0.05, 1.05), (0.095, 1.10), (0.11, 1.25), (0.10, 1.36), (0.06, 1.43), (0.02, 1.45)],
            10,
            coat,
        )
        head = copies(head, np.zeros((1, 3)), scale=np.array([[0.72, 1.0, 1.0]]))
        screen = box((0.012, 0.10, 0.06), (0.077, 0, 1.26), (0.2, 0.24, 0.2))
        slot = box((0.012, 0.05, 0.05), (0.072, 0, 1.14), STEEL)
        return item(paint=[post, head, screen, slot])
    body = box((0.24, 0.34, 1.45), (0, 0, -0.04), coat)
    head = turned(box((0.03, 0.28, 0.34), (0, 0, 0), STEEL), 0, (0.125, 0, 1.03), -0.12)
    screen = box((0.012, 0.2, 0.11), (0.129, 0, 1.22), (0.03, 0.05, 0.04))
    keys = boxes(
        (0.014, 0.03, 0.03),
        [[0.128, (i - 1) * 0.05, 1.06 + 0.045 * j] for i in range(3) for j in range(3)],
        BLACK,
    )
    tray = box((0.02, 0.16, 0.1), (0.12, 0, 0.78), BLACK)
    badge = decals(lettering("P", 0.2), WHITE, 2).moved([0.12, 0, 0.5])
    ground = decals([[-0.14, 0.36, 0.14, 0.64]], BLUE, 1).moved([0.12, 0, 0])
    pole = tube([[-0.05, 0, 1.4], [-0.05, 0, 1.75]], 0.025, 6, STEEL)
    panel = turned(
        box((0.34, 0.42, 0.02), (0, 0, 0), (0.02, 0.025, 0.05)), 0, (-0.05, 0, 1.75), 0.5
    )
    return item(paint=[body, head, screen, keys, tray, badge, ground, pole, panel])


def manhole(rng: np.random.Generator) -> Surfaces:
    """A cast cover in its frame, flush with the road: decals 6 mm above it."""
    iron = np.array([0.075, 0.07, 0.066]) * rng.uniform(0.7, 1.3)
    radius = float(rng.choice([0.31, 0.36]))
    cover = disc(radius, (0, 0, 0.006), iron, 20)
    frame = disc(radius + 0.07, (0, 0, 0.006), iron * 1.3, 20, radius + 0.012)
    gap = disc(radius + 0.012, (0, 0, 0.006), iron * 0.35, 20, radius)
    # Raised studs worn bright.
    if rng.random() < 0.5:
        grid = (np.stack(np.meshgrid(*[np.arange(-5, 6)] * 2), -1).reshape(-1, 2)) * 0.06
        grid = grid[np.hypot(*grid.T) < radius - 0.05]
        flat = np.column_stack([grid, np.full(len(grid), 0.005)])
        studs = boxes((0.034, 0.034, 0.007), flat, iron * 1.7)
    else:
        studs = join(
            [disc(r + 0.022, (0, 0, 0.012), iron * 1.7, 20, r) for r in (0.06, 0.13, 0.2, 0.27)]
        )
    return item("road", paint=[cover, frame, gap, studs])


def newspaper_box(rng: np.random.Generator) -> Surfaces:
    """Two to four coin boxes for newspapers, side by side on their stands."""
    paint, glass = [], []
    count = int(rng.integers(2, 5))
    for k in range(count):
        y = (k - (count - 1) / 2) * 0.52 + rng.normal(0, 0.01)
        colour = choice(rng, (RED, BLUE, YELLOW, GREEN, BLACK, WHITE, (0.25, 0.27, 0.3)))
        at = np.array([rng.normal(0, 0.02), y, 0])
        body = extruded(
            [(-0.2, 0.42), (0.2, 0.42), (0.2, 0.88), (0.12, 1.12), (-0.2, 1.16)], 0.46, colour
        )
        stand = [
            box((0.1, 0.1, 0.45), (0, 0, -0.02), DARK_STEEL),
            box((0.4, 0.4, 0.03), (0, 0, 0.0), DARK_STEEL),
        ]
        sheet = box((0.008, 0.3, 0.26), (0.203, 0, 0.56), (0.5, 0.49, 0.46))
        lines = decals(lettering("NEWS", 0.06), BLACK, 1).moved([0.208, 0, 0.77])
        photo = decals([[-0.12, 0.59, 0.02, 0.71]], (0.16, 0.15, 0.14), 1).moved([0.208, 0, 0])
        frame = [box((0.02, 0.03, 0.34), (0.205, s * 0.185, 0.52), colour) for s in (-1, 1)]
        coin = box((0.06, 0.1, 0.12), (0.14, 0.0, 1.02), STEEL)
        paint += [p.moved(at) for p in (body, *stand, sheet, lines, photo, *frame, coin)]
    return item(paint=paint, glass=glass)


def electric_box(rng: np.random.Generator) -> Surfaces:
    """A cabinet of the grid or of the signals, with doors, louvres and often a bill stuck on."""
    wide, high = rng.uniform(0.7, 1.5), rng.uniform(1.0, 1.5)
    coat = choice(
        rng, ((0.30, 0.32, 0.30), (0.07, 0.12, 0.08), (0.36, 0.35, 0.31), (0.2, 0.21, 0.21))
    )
    body = box((0.42, wide, high), (0, 0, 0.08), coat)
    roof = box((0.48, wide + 0.06, 0.05), (0, 0, high + 0.08), tuple(0.9 * np.array(coat)))
    gaps = boxes((0.012, 0.012, high - 0.1), [[0.208, 0, 0.13]], BLACK)
    handles = boxes(
        (0.03, 0.025, 0.14), [[0.215, s * 0.08, 0.6 * high] for s in (-1, 1)], DARK_STEEL
    )
    rows = np.array(
        [[0.206, s * wide / 4, z] for s in (-1, 1) for z in np.arange(0.18, 0.36, 0.035)]
    )
    louvres = boxes((0.014, 0.3 * wide, 0.012), rows, DARK_STEEL)
    sign = geometry(
        [
            [0.216, 0.25 * wide - 0.07, 0.78 * high],
            [0.216, 0.25 * wide + 0.07, 0.78 * high],
            [0.216, 0.25 * wide, 0.78 * high + 0.13],
        ],
        [[0, 1, 2]],
        tint=YELLOW,
    )
    paint = [body, roof, gaps, handles, louvres, sign]
    for _ in range(int(rng.integers(0, 3))):
        bill = poster(rng, 0.21, 0.3)
        paint.append(turned(bill, 0, (0.211, rng.uniform(-0.3, 0.1) * wide, 0.45 * high)))
    return item(paint=paint, concrete=[box((0.5, wide + 0.08, 0.18), (0, 0, -0.08))])
