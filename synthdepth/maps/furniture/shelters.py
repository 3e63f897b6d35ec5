"""Street furniture that one stands in or in front of: shelters, columns, telephone boxes."""

import itertools

import numpy as np

from synthdepth.maps.bars import beams
from synthdepth.maps.furniture.parts import (
    BLACK,
    COATS,
    COOL_LAMP,
    DARK_STEEL,
    LABEL,
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
from synthdepth.maps.geometry import Geometry, box, join, quads, tube


def _pane(a, b, low: float, high: float) -> Geometry:
    """An upright pane from (x, y) `a` to `b`: one quad."""
    (ax, ay), (bx, by) = a, b
    return quads([[[ax, ay, low], [bx, by, low], [bx, by, high], [ax, ay, high]]])


def bus_shelter(rng: np.random.Generator) -> Surfaces:
    """A glass shelter of 3.6-4.8 m open towards +x, with a lit poster at one end, and its pole."""
    long, deep, high = rng.uniform(3.6, 4.8), rng.uniform(1.35, 1.6), 2.35
    coat, bays = choice(rng, COATS), int(rng.integers(3, 5))
    y = np.linspace(-long / 2, long / 2, bays + 1)
    back, front = -deep / 2, deep / 2
    posts = boxes((0.07, 0.07, high + 0.04), np.column_stack([0 * y + back, y, 0 * y - 0.04]), coat)
    corner = boxes(
        (0.07, 0.07, high + 0.04), [[front - 0.35, s * (long / 2), -0.04] for s in (1,)], coat
    )
    rails = beams(
        [[back, -long / 2, z] for z in (0.22, 1.15, 2.2)],
        [[back, long / 2, z] for z in (0.22, 1.15, 2.2)],
        0.045,
        0.045,
        coat,
    )
    end_rails = beams(
        [[back, long / 2, z] for z in (0.22, 2.2)],
        [[front - 0.35, long / 2, z] for z in (0.22, 2.2)],
        0.045,
        0.045,
        coat,
    )
    glass = [
        _pane((back, a + 0.035), (back, b - 0.035), z0, z1)
        for a, b in itertools.pairwise(y)
        for z0, z1 in ((0.245, 1.125), (1.175, 2.175))
    ]
    glass.append(_pane((back + 0.04, long / 2), (front - 0.39, long / 2), 0.245, 2.175))
    if rng.random() < 0.65:
        # Clear panes show nothing of themselves; only tinted ones are surfaces.
        glass = []
    # Frosted bands that keep people from walking into the panes.
    dots = [
        decals([[a + 0.05, v, b - 0.05, v + 0.05]], WHITE, 1.2).moved([back, 0, 0])
        for a, b in itertools.pairwise(y)
        for v in (1.3, 1.52)
    ]
    arch = rng.random() < 0.4
    if arch:
        turn = np.linspace(0.15 * np.pi, 0.85 * np.pi, 7)
        top = np.column_stack(
            [1.12 * deep / 1.78 * np.cos(turn), high - 0.28 + 0.62 * np.sin(turn)]
        )
        under = top - [0, 0.04]
        roof = join(
            [
                extruded([under[i + 1], under[i], top[i], top[i + 1]], long + 0.3, coat)
                for i in range(6)
            ]
        )
    else:
        roof = box((deep + 0.25, long + 0.3, 0.13), (0.04, 0, high), coat)
        roof = join([roof, box((deep + 0.16, long + 0.2, 0.03), (0.04, 0, high + 0.13), STEEL)])
    lamps = [
        lamp_face((0.1, 0.9), (0.1, s * long * 0.25, high - 0.012), COOL_LAMP) for s in (-1, 1)
    ]
    wood = choice(rng, TIMBER)
    seat = beams(
        *[[[back + x, s * long * 0.3, 0.45] for x in (0.2, 0.32, 0.44)] for s in (-1, 1)],
        0.1,
        0.035,
        wood,
    )
    legs = boxes((0.3, 0.05, 0.47), [[back + 0.32, s * long * 0.2, -0.04] for s in (-1, 1)], coat)
    plan = box((0.02, 0.5, 0.72), (back + 0.035, 0.25 * long, 1.22), (0.55, 0.55, 0.53))
    lines = decals(
        [[-0.18, 0.05 + 0.06 * i, 0.18 - 0.1 * (i % 3 == 0), 0.085 + 0.06 * i] for i in range(10)],
        (0.1, 0.1, 0.12),
        1,
    ).moved([back + 0.045, 0.25 * long, 1.24])
    wood_parts = [seat]
    ad = _lightbox(rng, 1.32, 1.9, coat)
    ad = {k: turned(g, np.pi / 2, (front - 0.75, -long / 2 - 0.0, 0)) for k, g in ad.items()}
    flag = _stop_flag(rng)
    flag = {k: g.moved([front - 0.1, long / 2 + 0.9, 0]) for k, g in flag.items()}
    paint = [
        posts,
        corner,
        rails,
        end_rails,
        *dots,
        roof,
        legs,
        plan,
        lines,
        ad["paint", LABEL],
        flag["paint", LABEL],
    ]
    return item(paint=paint, glass=glass, lamp=lamps, wood=wood_parts)


def _lightbox(rng: np.random.Generator, wide: float, high: float, coat) -> Surfaces:
    """A poster case seen from both sides, its poster 0.35 m above the ground, facing +x and -x."""
    case = box((0.16, wide, high + 0.2), (0, 0, 0.25), coat)
    feet = boxes((0.1, 0.12, 0.35), [[0, s * wide * 0.35, -0.05] for s in (-1, 1)], coat)
    front = poster(rng, wide - 0.16, high).moved([0.082, 0, 0.35])
    back = turned(poster(rng, wide - 0.16, high), np.pi, (-0.082, 0, 0.35))
    return item(paint=[case, feet, front, back])


def _stop_flag(rng: np.random.Generator) -> Surfaces:
    """A stop's pole with its flag and timetable."""
    pole = tube([[0, 0, -0.05], [0, 0, 3.0]], 0.035, 7, STEEL)
    plate = box(
        (0.03, 0.42, 0.5),
        (0, 0.26, 2.45),
        choice(rng, ((0.03, 0.09, 0.3), (0.04, 0.2, 0.1), (0.4, 0.05, 0.03))),
    )
    text = decals(lettering("BUS", 0.13), WHITE, 1).moved([0.015, 0.26, 2.75])
    number = decals(lettering(str(rng.integers(2, 98)), 0.12), WHITE, 1).moved([0.015, 0.26, 2.56])
    times = box((0.03, 0.24, 0.34), (0.05, 0, 1.3), WHITE)
    return item(paint=[pole, plate, text, number, times])


def advertising_column(rng: np.random.Generator) -> Surfaces:
    """A Litfass column, 3.5-4.2 m, with posters all round and a crown."""
    radius, high, coat = rng.uniform(0.55, 0.7), rng.uniform(2.6, 3.0), choice(rng, COATS[:4])
    base = lathe([(radius + 0.1, -0.05), (radius + 0.1, 0.35), (radius + 0.02, 0.45)], 24, coat)
    drum = lathe([(radius, 0.4), (radius, high + 0.45)], 24, (0.30, 0.30, 0.29))
    crown = lathe(
        [
            (radius + 0.03, high + 0.4),
            (radius + 0.16, high + 0.55),
            (radius + 0.16, high + 0.68),
            (0.72 * radius, high + 0.78),
            (0.55 * radius, high + 0.98),
            (0.2 * radius, high + 1.12),
            (0.05, high + 1.16),
            (0.05, high + 1.3),
            (0.012, high + 1.42),
        ],
        24,
        coat,
    )
    around = 2 * np.pi * radius
    count = 4
    bills = []
    for k in range(count):
        wide, tall = around / count - 0.04, high - 0.15
        split = rng.random() < 0.4
        for part in range(2 if split else 1):
            h = tall / 2 - 0.02 if split else tall
            bill = poster(rng, wide, h, radius)
            bills.append(turned(bill, 2 * np.pi * k / count, (0, 0, 0.5 + part * tall / 2)))
    lamps = []
    for k in range(4):
        turn = 2 * np.pi * (k + 0.5) / 4
        at = (radius + 0.09) * np.array([np.cos(turn), np.sin(turn)])
        lamps.append(lamp_face((0.1, 0.1), (at[0], at[1], high + 0.46), WARM_LAMP))
    return item(paint=[base, drum, crown, *bills], lamp=lamps)


def phone_box(rng: np.random.Generator) -> Surfaces:
    """A glazed booth of 2.3-2.5 m, its door towards +x: cast iron and red, or plain steel."""
    classic = rng.random() < 0.5
    coat = (0.30, 0.022, 0.02) if classic else choice(rng, COATS)
    half, high = 0.43, 2.1
    posts = boxes(
        (0.1, 0.1, high + 0.05),
        [[a, b, -0.05] for a in (-half + 0.02, half - 0.02) for b in (-half + 0.02, half - 0.02)],
        coat,
    )
    plinth = box((2 * half - 0.02, 2 * half - 0.02, 0.16), (0, 0, -0.03), coat)
    lintel = box((2 * half, 2 * half, 0.3), (0, 0, high - 0.1), coat)
    roof = (
        lathe(
            [(0.6, high + 0.2), (0.6, high + 0.24), (0.45, high + 0.34), (0.1, high + 0.42)],
            4,
            coat,
        )
        if classic
        else None
    )
    paint, glass = [posts, plinth, lintel], []
    paint.append(
        turned(roof, np.pi / 4)
        if classic
        else box((0.95, 0.95, 0.07), (0, 0, high + 0.2), DARK_STEEL)
    )
    rows, columns = (8, 3) if classic else (2, 1)
    z = np.linspace(0.16, high - 0.1, rows + 1)
    inner = half - 0.08
    for k in range(4):
        if k == 2:
            continue
        turn = k * np.pi / 2
        bars = [
            beams(
                [[half - 0.03, -inner, v] for v in z[1:-1]],
                [[half - 0.03, inner, v] for v in z[1:-1]],
                0.03,
                0.025,
                coat,
            )
        ]
        split = np.array([-0.55, 0.55]) * inner if columns == 3 else np.zeros(0)
        if len(split):
            bars.append(
                boxes((0.03, 0.025, z[-1] - z[0]), [[half - 0.03, v, z[0]] for v in split], coat)
            )
        edges = np.concatenate([[-inner], split, [inner]])
        # The classic's panes are clear: one sees the bars alone. The plain one's are tinted.
        for low, top in itertools.pairwise(() if classic else z):
            for a, b in itertools.pairwise(edges):
                glass.append(turned(_pane((half - 0.034, a), (half - 0.034, b), low, top), turn))
        paint += [turned(b, turn) for b in bars]
        word = decals(lettering("TELEPHONE", 0.09), (0.03, 0.03, 0.03) if classic else WHITE, 2)
        sign = decals(
            [[-0.32, -0.075, 0.32, 0.075]], (0.58, 0.56, 0.5) if classic else (0.03, 0.06, 0.2), 1
        )
        paint.append(turned(join([sign, word]).moved([half, 0, high + 0.05]), turn))
    back = box((0.04, 2 * inner, high - 0.25), (-half + 0.03, 0, 0.14), coat)
    set_ = box((0.16, 0.3, 0.5), (-half + 0.13, 0.05, 1.1), BLACK)
    handset = tube([[-half + 0.23, -0.14, 1.52], [-half + 0.23, -0.14, 1.3]], 0.025, 5, BLACK)
    handle = box((0.03, 0.03, 0.2), (half + 0.015, -inner + 0.02, 1.0), STEEL)
    lamp = lamp_face((0.3, 0.3), (0, 0, high - 0.112), WARM_LAMP)
    return item(paint=[*paint, back, set_, handset, handle], glass=glass, lamp=[lamp])
