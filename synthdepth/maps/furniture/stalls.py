"""Where things are sold in the street: kiosks and market stalls."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.parts import (
    BLACK,
    COATS,
    DARK_STEEL,
    STEEL,
    TIMBER,
    WARM_LAMP,
    WHITE,
    Surfaces,
    boxes,
    choice,
    extruded,
    item,
    lamp_face,
    lathe,
    turned,
)
from synthdepth.maps.furniture.posters import decals, lettering, poster
from synthdepth.maps.geometry import Geometry, box, geometry, join, quads

_AWNINGS = (
    (0.40, 0.04, 0.03),
    (0.03, 0.16, 0.09),
    (0.04, 0.09, 0.25),
    (0.50, 0.33, 0.06),
    (0.5, 0.47, 0.40),
    (0.28, 0.06, 0.10),
)


def kiosk(rng: np.random.Generator) -> Surfaces:
    """A news-stand or snack kiosk of about 2.4 by 3.2 m, its counter and awning towards +x."""
    deep, wide, high = rng.uniform(2.0, 2.5), rng.uniform(2.6, 3.6), rng.uniform(2.5, 2.75)
    coat = choice(rng, COATS)
    x1 = deep / 2
    walls = [
        box((0.08, wide, high), (-x1 + 0.04, 0, -0.03), coat),
        box((0.08, wide, 1.0), (x1 - 0.04, 0, -0.03), coat),
        box((0.08, wide, high - 2.15), (x1 - 0.04, 0, 2.12), coat),
    ]
    for s in (-1, 1):
        walls.append(box((deep - 0.16, 0.08, high), (0, s * (wide / 2 - 0.04), -0.03), coat))
        walls.append(box((0.08, 0.12, high), (x1 - 0.04, s * (wide / 2 - 0.06), -0.03), coat))
    panels = boxes(
        (0.02, 0.42 * wide, 0.62),
        [[x1 + 0.005, s * wide / 4, 0.15] for s in (-1, 1)],
        tuple(np.clip(np.array(coat) * 1.7 + 0.01, 0, 0.7)),
    )
    counter = box((0.46, wide + 0.04, 0.05), (x1 + 0.1, 0, 0.97), STEEL)
    inside = box((0.02, wide - 0.2, 1.2), (x1 - 0.55, 0, 0.95), (0.1, 0.075, 0.05))
    goods_y = rng.uniform(-wide / 2 + 0.2, wide / 2 - 0.2, 40)
    goods_z = rng.choice([1.02, 1.35, 1.66], 40)
    goods = boxes(
        rng.uniform([0.02, 0.07, 0.1], [0.08, 0.22, 0.26], (40, 3)),
        np.column_stack([np.where(goods_z > 1.1, x1 - 0.5, x1 + 0.1), goods_y, goods_z]),
        np.array(_AWNINGS + COATS)[rng.integers(0, 12, 40)],
    )
    shelves = boxes((0.14, wide - 0.2, 0.025), [[x1 - 0.48, 0, z] for z in (1.325, 1.635)], WHITE)
    sign = choice(rng, _AWNINGS)
    band = box((0.06, wide + 0.1, 0.42), (x1 + 0.02, 0, high - 0.1), sign)
    word = ("NEWS", "KIOSK", "COFFEE", "TABAC", "SNACKS", "FLOWERS")[rng.integers(6)]
    ink = BLACK if sign[1] > 0.25 else WHITE
    text = decals(lettering(word, 0.24), ink, 1).moved([x1 + 0.05, 0, high + 0.11])
    roof = box((deep + 0.35, wide + 0.35, 0.12), (0.05, 0, high + 0.30), DARK_STEEL)
    crown = extruded(
        [
            (-x1, high + 0.42),
            (x1, high + 0.42),
            (0.3 * deep, high + 0.75),
            (-0.3 * deep, high + 0.75),
        ],
        wide * 0.9,
        coat,
    )
    lamps = [lamp_face((0.12, 0.7), (x1 - 0.3, s * wide * 0.25, 2.42), WARM_LAMP) for s in (-1, 1)]
    side = [turned(poster(rng, 0.9, 1.4), s * np.pi / 2, (0, s * wide / 2, 0.8)) for s in (-1, 1)]
    fabric = [_awning(rng, wide, 1.1, x1 + 0.055, high - 0.1)]
    return item(
        paint=[*walls, panels, counter, inside, goods, shelves, band, text, roof, crown, *side],
        fabric=fabric,
        lamp=lamps,
    )


def _awning(rng, wide: float, reach: float, x: float, z: float) -> Geometry:
    """Striped cloth that slopes out from (x, z) along +x, with a valance."""
    count = int(wide / 0.28)
    y = np.linspace(-wide / 2, wide / 2, count + 1)
    colour, pale = np.array(choice(rng, _AWNINGS)), np.array([0.58, 0.56, 0.5])
    plain = rng.random() < 0.35
    tint = np.where((np.arange(count) % 2 == 0)[:, None] | plain, colour, pale)
    a, b = y[:-1], y[1:]
    drop = 0.38 * reach
    out = [np.full(count, v) for v in (x + reach, z - drop, x, z)]
    slope = np.stack(
        [
            np.column_stack([out[0], a, out[1]]),
            np.column_stack([out[0], b, out[1]]),
            np.column_stack([out[2], b, out[3]]),
            np.column_stack([out[2], a, out[3]]),
        ],
        1,
    )
    hem = slope[:, :2] - [0, 0, 0.2]
    valance = np.stack([hem[:, 0], hem[:, 1], slope[:, 1], slope[:, 0]], 1)
    return quads(np.concatenate([slope, valance]), np.concatenate([tint, tint]))


def market_stall(rng: np.random.Generator) -> Surfaces:
    """A stall of 2.4-3.2 m under a striped roof of cloth; fruit in crates or goods, towards +x."""
    wide, deep, high = rng.uniform(2.4, 3.2), rng.uniform(1.6, 2.0), 2.2
    corner = np.array([[a * deep / 2, b * wide / 2, -0.03] for a in (-1, 1) for b in (-1, 1)])
    tops = np.column_stack([corner[:, :2], np.where(corner[:, 0] > 0, high, high + 0.0)])
    poles = round_bars(corner, tops, 0.02, STEEL)
    ridge = round_bars([[0, -wide / 2, high + 0.45]], [[0, wide / 2, high + 0.45]], 0.018, STEEL)
    eaves = round_bars(
        [tops[0], tops[2], tops[0], tops[1]], [tops[1], tops[3], tops[2], tops[3]], 0.016, STEEL
    )
    gable = round_bars(
        [tops[0], tops[1], tops[2], tops[3]],
        [[0, -wide / 2, high + 0.45], [0, wide / 2, high + 0.45]] * 2,
        0.016,
        STEEL,
    )
    cloth = [_awning(rng, wide + 0.3, deep / 2 + 0.3, 0.0, high + 0.47)]
    # The other side of the roof has the same stripes.
    cloth.append(
        geometry(
            cloth[0].vertices * [-1, 1, 1], cloth[0].faces[:, ::-1], cloth[0].uv, cloth[0].tint
        )
    )
    table = turned(box((1.0, wide - 0.15, 0.04), (0, 0, 0), TIMBER[1]), 0, (0.35, 0, 0.78), 0.22)
    trestles = [
        beams([[0.35 + s * 0.3, y, -0.02]], [[0.35 + s * 0.12, y, 0.76]], 0.05, 0.05, TIMBER[1])
        for s in (-1, 1)
        for y in (-0.35 * wide, 0.35 * wide)
    ]
    skirt = quads(
        [
            [
                [0.86, -wide / 2 + 0.08, 0.05],
                [0.86, wide / 2 - 0.08, 0.05],
                [0.85, wide / 2 - 0.08, 0.66],
                [0.85, -wide / 2 + 0.08, 0.66],
            ]
        ],
        choice(rng, ((0.03, 0.1, 0.05), (0.3, 0.28, 0.24), (0.2, 0.03, 0.03))),
    )
    crates, fruit = _crates(rng, wide)
    return item(
        paint=[poles, ridge, eaves, gable, fruit],
        fabric=[*cloth, skirt],
        wood=[table, *trestles, crates],
    )


def _crates(rng: np.random.Generator, wide: float) -> tuple[Geometry, Geometry]:
    """Two rows of sloping crates, each heaped with fruit of one colour."""
    colours = (
        (0.40, 0.04, 0.02),
        (0.50, 0.20, 0.02),
        (0.55, 0.40, 0.03),
        (0.10, 0.22, 0.03),
        (0.05, 0.12, 0.03),
        (0.20, 0.03, 0.08),
        (0.30, 0.18, 0.08),
    )
    count = int((wide - 0.2) / 0.5)
    woods, fruits = [], []
    ball = lathe([(0.022, -0.034), (0.042, 0.0), (0.016, 0.036)], 5)
    for x in (0.12, 0.58):
        for k in range(count):
            y = (k - (count - 1) / 2) * 0.5
            z = 0.80 - 0.22 * (x - 0.35) + 0.02
            side = boxes(
                [
                    [0.40, 0.015, 0.1],
                    [0.40, 0.015, 0.1],
                    [0.015, 0.44, 0.1],
                    [0.015, 0.44, 0.1],
                    [0.40, 0.44, 0.02],
                ],
                [[0, -0.22, 0], [0, 0.22, 0], [-0.2, 0, 0], [0.2, 0, 0], [0, 0, 0]],
                TIMBER[1],
            )
            woods.append(turned(side, 0, (x, y, z), 0.22))
            n = 20
            at = np.column_stack(
                [
                    rng.uniform(-0.16, 0.16, n),
                    rng.uniform(-0.18, 0.18, n),
                    rng.uniform(0.07, 0.12, n),
                ]
            )
            colour = np.array(colours[rng.integers(len(colours))])
            light = rng.uniform(0.7, 1.25, (n, 1))
            heap = join([ball.moved(p).tinted(colour * s) for p, s in zip(at, light, strict=True)])
            fruits.append(turned(heap, 0, (x, y, z), 0.22))
    return join(woods), join(fruits)
