"""Traffic lights, street name signs and sign gantries over roads."""

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.lattice import between, lattice
from synthdepth.maps.furniture.parts import (
    BLACK,
    COATS,
    DARK_STEEL,
    LABEL,
    STEEL,
    WHITE,
    Surfaces,
    boxes,
    choice,
    item,
    lathe,
    turned,
)
from synthdepth.maps.furniture.posters import decals, lettering
from synthdepth.maps.geometry import Geometry, box, geometry, join, merge, place, tube

# Lit lenses, and the same lenses when they are dark.
_LENSES = (
    ((0.80, 0.06, 0.04), (0.085, 0.014, 0.012)),
    ((0.80, 0.42, 0.04), (0.10, 0.060, 0.012)),
    ((0.10, 0.72, 0.36), (0.010, 0.055, 0.035)),
)
_STREETS = (
    "MAIN",
    "OAK",
    "PARK",
    "KING",
    "MILL",
    "LAKE",
    "CHURCH",
    "STATION",
    "BRIDGE",
    "5",
    "12",
    "BROAD",
    "ELM",
    "HARBOR",
)
_PLACES = (
    "AIRPORT",
    "CENTRE",
    "NORTH",
    "HARBOR",
    "STADIUM",
    "EAST 95",
    "WEST 12",
    "UNIVERSITY",
    "AIRPORT 8",
    "RING 4",
    "EXIT 24",
)
_BLUE, _GREEN = (0.015, 0.05, 0.22), (0.01, 0.11, 0.05)


def _facing_disc(radius: float, at, sides: int = 12) -> Geometry:
    """A disc in the y-z plane that faces +x."""
    turn = 2 * np.pi * np.arange(sides) / sides
    v = np.column_stack([np.zeros(sides), radius * np.cos(turn), radius * np.sin(turn)])
    fan = np.arange(1, sides - 1)
    return geometry(v + np.asarray(at), np.stack([0 * fan, fan, fan + 1], 1), v[:, 1:])


def _visor(radius: float, at) -> Geometry:
    """A tunnel over a lens, open below, longer at its top."""
    turn = np.radians(np.linspace(-35, 215, 9))
    rim = np.column_stack([np.cos(turn), np.sin(turn)]) * radius
    reach = 0.10 + 0.10 * np.clip(np.sin(turn), 0, 1)
    near = np.column_stack([np.zeros(9), rim])
    far = np.column_stack([reach, rim])
    i = np.arange(8)
    faces = np.concatenate([np.stack([i, 9 + i, 9 + i + 1], 1), np.stack([i, 9 + i + 1, i + 1], 1)])
    return geometry(np.concatenate([near, far]) + np.asarray(at), faces)


def signal_head(lit: int, coat, backplate: bool = True, lens_m: float = 0.3) -> Surfaces:
    """A head of three lenses facing +x, centred on the origin; `lit` is 0 red, 1 amber, 2 green."""
    pitch = lens_m + 0.045
    body = box((0.20, lens_m + 0.07, 3 * pitch + 0.03), (-0.1, 0, -1.5 * pitch - 0.015), coat)
    paint, signal = [body], []
    if backplate:
        w, h = lens_m + 0.34, 3 * pitch + 0.32
        rim = box((0.012, w, h), (-0.1, 0, -h / 2), BLACK)
        edge = join(
            [
                decals(
                    [[-w / 2, s * h / 2 - 0.025, w / 2, s * h / 2 + 0.025]], (0.5, 0.36, 0.05), 1
                )
                for s in (-0.97, 0.97)
            ]
        ).moved([-0.094, 0, 0])
        paint += [rim, edge]
    for k, (on, off) in enumerate(_LENSES):
        z = (1 - k) * pitch
        lens = _facing_disc(lens_m / 2 - 0.01, (0.008, 0, z))
        (signal if k == lit else paint).append(lens.tinted(on if k == lit else off))
        paint.append(_visor(lens_m / 2 + 0.008, (0, 0, z)).tinted(BLACK))
    return item(paint=paint, signal=signal)


def _pedestrian_head(walk: bool, coat) -> Surfaces:
    """Two square lenses facing +x, one lit with a figure's outline."""
    paint = [box((0.16, 0.32, 0.62), (-0.08, 0, -0.31), coat)]
    signal = []
    for k, (colour, z) in enumerate(((_LENSES[0], 0.15), (_LENSES[2], -0.15))):
        lit = walk == (k == 1)
        figure = np.array(
            [
                [-0.022, 0.08, 0.022, 0.115],
                [-0.045, 0.0, 0.045, 0.07],
                [-0.04, -0.11, -0.01, 0.0],
                [0.01, -0.11, 0.04, 0.0],
            ]
        )
        part = decals(figure + [0, z, 0, z], colour[0 if lit else 1], 2)
        (signal if lit else paint).append(part)
        paint.append(decals([[-0.13, z - 0.13, 0.13, z + 0.13]], (0.012, 0.012, 0.012), 1))
        hood = box((0.14, 0.32, 0.012), (0.07, 0, z + 0.14), BLACK)
        paint.append(hood)
    return item(paint=paint, signal=signal)


def traffic_light(rng: np.random.Generator, *, arm_m: float) -> Surfaces:
    """A signal pole whose lenses look along +x, towards the traffic that it stops.

    Args:
        rng: of its make and of what is lit.
        arm_m: reach of the mast arm over the road, along +y [m]; 0 for a pole alone.
    """
    lit = int(rng.choice([0, 2, 1], p=[0.5, 0.42, 0.08]))
    coat = choice(rng, ((0.022, 0.023, 0.024), (0.022, 0.023, 0.024), (0.42, 0.26, 0.02)))
    steel = choice(rng, (STEEL, STEEL, (0.05, 0.055, 0.055), (0.016, 0.04, 0.03)))
    tall = 3.5 if arm_m <= 0 else float(np.clip(5.6 + 0.05 * arm_m, 5.6, 6.5))
    thick = 0.055 if arm_m <= 0 else 0.10
    pole = [
        tube([[0, 0, -0.1], [0, 0, tall]], [thick * 1.25, thick * 0.9], 8, steel),
        lathe(
            [(2.4 * thick, -0.05), (2.4 * thick, 0.03), (1.6 * thick, 0.05), (1.4 * thick, 0.3)],
            8,
            steel,
        ),
    ]
    heads: list[tuple[Surfaces, tuple[float, float, float], float]] = []
    low = signal_head(lit, coat, bool(rng.random() < 0.5))
    heads.append((low, (thick + 0.24, 0, 2.85), 0.0))
    wires = []
    if arm_m > 0:
        z = tall - 0.35
        rise = 0.035 * arm_m
        arm = np.array([[0, 0, z], [0, 0.35 * arm_m, z + 0.7 * rise], [0, arm_m, z + rise]])
        pole.append(tube(arm, [0.075, 0.06, 0.04], 7, steel))
        plate = bool(rng.random() < 0.75)
        spots = [arm_m - 0.25] + ([arm_m - 3.6] if arm_m > 6.5 else [])
        for y in spots:
            at = np.interp(y, arm[:, 1], arm[:, 2])
            heads.append((signal_head(lit, coat, plate), (0.26, y, at - 0.1), 0.0))
            pole.append(box((0.24, 0.06, 0.06), (0.1, y, at - 0.03), steel))
        if rng.random() < 0.6:
            name = _STREETS[rng.integers(len(_STREETS))] + " ST"
            board = box((0.02, 0.18 * len(name) + 0.3, 0.42), (0, 0, -0.55), _GREEN)
            text = decals(lettering(name, 0.22), WHITE, 1).moved([0.01, 0, -0.34])
            y = max(1.2, 0.45 * arm_m)
            pole.append(join([board, text]).moved([0.06, y, np.interp(y, arm[:, 1], arm[:, 2])]))
        wires.append(
            box(
                (0.22, 0.12, 0.14),
                (0.0, arm_m * 0.7, np.interp(arm_m * 0.7, arm[:, 1], arm[:, 2]) + 0.06),
                WHITE,
            )
        )
    for height in (2.5, 3.2):
        pole.append(box((0.24, 0.05, 0.04), (thick + 0.06, 0, height), steel))
    walk = lit == 0
    ped = _pedestrian_head(walk, coat)
    side = float(rng.choice([-1, 1]))
    heads.append((ped, (0.0, side * (thick + 0.22), 2.45), side * np.pi / 2))
    pole.append(box((0.05, 0.2, 0.04), (0, side * (thick + 0.06), 2.43), steel))
    button = [
        box(
            (0.09, 0.10, 0.2),
            (0, side * (thick + 0.05), 1.0),
            choice(rng, ((0.5, 0.35, 0.03), BLACK)),
        ),
        box((0.04, 0.02, 0.04), (0, side * (thick + 0.105), 1.05), STEEL),
    ]
    sign = decals([[-0.1, 1.3, 0.1, 1.55]], WHITE, 1)
    mark = decals([[-0.05, 1.34, 0.05, 1.5]], BLACK, 2)
    button.append(turned(join([sign, mark]), side * np.pi / 2, (0, side * (thick + 0.02), 0)))
    cabinet = box((0.22, 0.3, 0.42), (-thick - 0.1, 0, 1.1), DARK_STEEL)
    placed = [place(h, at, yaw) for h, at, yaw in heads]
    extra = item(paint=[*button, cabinet, *wires])
    return merge([{("paint", "pole"): join(pole)}, extra, *placed])


def street_name_sign(rng: np.random.Generator) -> Surfaces:
    """Street names on a post, 2.6-3.4 m: crossed blades, or one plate between two posts."""
    colour = choice(rng, (_GREEN, _BLUE, (0.03, 0.03, 0.032), (0.55, 0.55, 0.53)))
    ink = BLACK if colour[0] > 0.3 else WHITE
    names = [str(n) for n in rng.choice(_STREETS, 2, replace=False)]
    if rng.random() < 0.65:
        high = rng.uniform(2.6, 3.2)
        post = tube([[0, 0, -0.08], [0, 0, high + 0.52]], 0.03, 7, choice(rng, COATS + (STEEL,)))
        ball = lathe([(0.01, high + 0.5), (0.05, high + 0.53), (0.01, high + 0.59)], 7, STEEL)
        blades = []
        for k, name in enumerate(names):
            text = name + " ST" if name.isalpha() else name + " AVE"
            wide = 0.085 * len(text) + 0.16
            blade = box((0.024, wide, 0.2), (0, 0, -0.1), colour)
            words = decals(lettering(text, 0.11), ink, 1).moved([0.012, 0, 0])
            both = join([blade, words, turned(words, np.pi)])
            blades.append(turned(both, k * np.pi / 2, (0, 0, high + 0.14 + 0.23 * k)))
        return item(paint=[post, ball, *blades])
    text = names[0] + " STREET"
    wide = 0.1 * len(text) + 0.2
    plate = box((0.03, wide, 0.24), (0, 0, 0.5), colour)
    words = decals(lettering(text, 0.13), ink, 1).moved([0.015, 0, 0.62])
    posts = [
        tube([[-0.03, s * wide * 0.42, -0.08], [-0.03, s * wide * 0.42, 0.82]], 0.028, 6, STEEL)
        for s in (-1, 1)
    ]
    return item(paint=[plate, words, *posts])


def _direction_board(rng: np.random.Generator, wide: float, high: float, colour) -> Geometry:
    """A direction sign facing +x, its lower edge centred on the origin: border, names, arrow."""
    panel = box((0.06, wide, high), (0, 0, 0), colour)
    m, w, h = 0.06, wide / 2, high
    border = [
        [-w + m, m, w - m, m + 0.05],
        [-w + m, h - m - 0.05, w - m, h - m],
        [-w + m, m, -w + m + 0.05, h - m],
        [w - m - 0.05, m, w - m, h - m],
    ]
    size = min(0.38, 0.16 * high)
    lines = [decals(border, WHITE, 1)]
    for k in range(int(rng.integers(2, 4))):
        text = _PLACES[rng.integers(len(_PLACES))]
        fit = min(size, 1.25 * wide * 0.78 / len(text))
        lines.append(
            decals(lettering(text, fit), WHITE, 1).moved(
                [0, 0.03 * wide, h - 0.22 * h - 0.24 * h * k]
            )
        )
    stem = decals([[-0.05, 0.16, 0.05, 0.42]], WHITE, 1).moved([0, -0.36 * wide, 0])
    tip = geometry(
        [[0.005, -0.18, 0.40], [0.005, 0.18, 0.40], [0.005, 0, 0.62]], [[0, 1, 2]], tint=WHITE
    ).moved([0, -0.36 * wide, 0])
    back = beams(
        [[-0.06, -w, z] for z in (0.25 * h, 0.75 * h)],
        [[-0.06, w, z] for z in (0.25 * h, 0.75 * h)],
        0.06,
        0.06,
        STEEL,
    )
    front = [part.moved([0.03, 0, 0]) for part in (*lines, stem, tip)]
    return join([panel, *front, back])


def overhead_gantry(rng: np.random.Generator, *, span_m: float) -> Surfaces:
    """A truss over a road along y, centred, with direction signs facing +x; clearance 5.4 m.

    Args:
        rng: of its signs.
        span_m: between the middles of its two columns [m].
    """
    low, high, half = 5.6, 6.8, span_m / 2
    steel = choice(rng, (STEEL, (0.36, 0.37, 0.37), (0.08, 0.085, 0.09)))
    section = np.array([[0.35, 0, low], [-0.35, 0, low], [-0.35, 0, high], [0.35, 0, high]])
    panels = max(4, round(span_m / 1.4))
    truss = lattice(
        between(section - [0, half, 0], section + [0, half, 0], panels), 0.06, 0.03, steel
    )
    columns = []
    for s in (-1, 1):
        foot = np.array([[0.5, s * half, -0.1], [-0.5, s * half, -0.1]])
        head = np.array([[0.35, s * half, high], [-0.35, s * half, high]])
        columns.append(lattice(between(foot, head, 6), 0.11, 0.04, steel))
    pads = boxes((1.7, 0.8, 0.6), [[0, s * half, -0.2] for s in (-1, 1)])
    colour = choice(rng, (_BLUE, _GREEN))
    count = max(1, int(span_m / 6.5))
    signs, lamps, walk = [], [], []
    for k in range(count):
        y = ((k + 0.5) / count - 0.5) * span_m * 0.86
        wide, tall = min(4.6, 0.8 * span_m / count), rng.uniform(2.0, 2.6)
        board = _direction_board(rng, wide, tall, colour)
        signs.append(board.moved([0.52, y, low - 0.15]))
        for s in (-0.3, 0.3):
            # Lamps on arms before the board's foot throw light up onto it: seen from below.
            walk.append(
                round_bars(
                    [[0.5, y + s * wide, low - 0.1]], [[1.3, y + s * wide, low - 0.2]], 0.02, steel
                )
            )
            body = box((0.16, 0.34, 0.1), (1.3, y + s * wide, low - 0.28), DARK_STEEL)
            walk.append(body)
            lamps.append(
                turned(
                    _facing_disc(0.09, (0, 0, 0), 8), np.pi, (1.215, y + s * wide, low - 0.22), -0.6
                )
            )
    return merge(
        [
            {("paint", "pole"): join([truss, *columns]), ("concrete", LABEL): pads},
            item(paint=[*signs, *walk], lamp=[join(lamps).tinted((0.62, 0.62, 0.58))]),
        ]
    )
