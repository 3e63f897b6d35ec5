"""What stands about in gardens and on pavements: sheds, pools, swings, tables, bins, benches.

`GARDEN_ITEMS` holds every item with the radius it needs; `scatter` sets many down from a few
variants.
"""

import dataclasses
from collections.abc import Callable

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.gardens.buildings import greenhouse, paddling_pool, pool, shed
from synthdepth.maps.gardens.parts import (
    DARK,
    LABEL,
    STEEL,
    WHITE,
    circle,
    draw_colour,
    draw_timber,
)
from synthdepth.maps.geometry import (
    Geometry,
    Model,
    box,
    copies,
    geometry,
    join,
    merge,
    quads,
    tube,
    yaw_matrix,
)


def _lathe(radii, heights, sides: int, tint) -> Geometry:
    """A closed solid of revolution about z."""
    return tube([[0, 0, z] for z in heights], list(radii), sides, tint)


def _letter_box(rng: np.random.Generator) -> Model:
    """Roadside box on a post, slot towards +x."""
    colour = draw_colour(rng, [DARK, WHITE, (0.25, 0.02, 0.02), STEEL, (0.03, 0.07, 0.05)])
    width, turn = 0.17, np.linspace(0, np.pi, 6)
    arch = np.column_stack([width / 2 * np.cos(turn), 0.13 + width / 2 * np.sin(turn)])
    outline = np.concatenate([[[width / 2, 0]], arch, [[-width / 2, 0]]])
    n = len(outline)
    rear = np.column_stack([np.full(n, -0.24), outline[:, 0], outline[:, 1] + 1.05])
    front = rear + [0.48, 0, 0]
    nxt = np.roll(np.arange(n), -1)
    skin = quads(np.stack([rear, front, front[nxt], rear[nxt]], axis=1)[:-1])
    fan = np.stack([np.zeros(n - 2), np.arange(1, n - 1), np.arange(2, n)], 1).astype(int)
    ends = [geometry(front, fan), geometry(rear, fan[:, ::-1])]
    base = box((0.48, width, 0.02), (0, 0, 1.04))
    flag = box((0.02, 0.012, 0.2), (0.08, width / 2 + 0.01, 1.12), (0.4, 0.02, 0.02))
    return {
        ("paint", LABEL): join([join([skin, *ends, base]).tinted(colour), flag]),
        ("wood", LABEL): box((0.1, 0.1, 1.12), (-0.02, 0, -0.08), draw_timber(rng)),
    }


def _bins(rng: np.random.Generator) -> Model:
    """One to three wheeled bins, 240 litres, side by side, lids hinged at -x."""
    body_colours = [
        (0.03, 0.034, 0.033),
        (0.02, 0.06, 0.03),
        (0.015, 0.03, 0.08),
        (0.07, 0.05, 0.03),
    ]
    parts: list[Geometry] = []
    wheels: list[Geometry] = []
    count = int(rng.integers(1, 4))
    for i in range(count):
        y = (i - (count - 1) / 2) * 0.68 + rng.normal(0, 0.02)
        colour = draw_colour(rng, body_colours)
        lid = draw_colour(rng, [*body_colours, (0.4, 0.28, 0.02), (0.02, 0.06, 0.2)])
        low = np.array([[-0.2, -0.2], [0.22, -0.2], [0.22, 0.2], [-0.2, 0.2]])
        high = np.array([[-0.33, -0.28], [0.33, -0.28], [0.33, 0.28], [-0.33, 0.28]])
        bottom = np.column_stack([low, np.full(4, 0.05)])
        top = np.column_stack([high, np.full(4, 0.98)])
        nxt = [1, 2, 3, 0]
        sides = np.stack([bottom, bottom[nxt], top[nxt], top], axis=1)
        turn = yaw_matrix(rng.normal(0, 0.1))[None]
        group = join(
            [
                quads(np.concatenate([sides, bottom[None, ::-1]]), colour),
                box((0.72, 0.6, 0.07), (0.02, 0, 0.98), lid),
                round_bars([-0.4, -0.2, 0.99], [-0.4, 0.2, 0.99], 0.018, colour, 4),
                box((0.1, 0.08, 0.06), (0.19, 0, -0.01), colour),
            ]
        )
        parts.append(copies(group, [[0, y, 0]], rotation=turn))
        y_in, y_out = np.array([[-0.26], [0.2]]), np.array([[-0.2], [0.26]])
        hub = np.array([[-0.27, 0, 0.1]])
        tyre = round_bars(hub + y_in * [0, 1, 0], hub + y_out * [0, 1, 0], 0.11, sides=8)
        wheels.append(copies(tyre, [[0, y, 0]], rotation=turn))
    return {("paint", LABEL): join(parts), ("rubber", LABEL): join(wheels)}


def _trampoline(rng: np.random.Generator) -> Model:
    """Round, 3 to 3.7 m across, with a safety net of coarse strands on six poles."""
    radius, bed, sides = rng.uniform(1.45, 1.85), 0.85, 18
    pad = draw_colour(rng, [(0.02, 0.07, 0.22), (0.02, 0.12, 0.06), (0.05, 0.05, 0.055)])
    inner, outer = circle(radius - 0.3, bed, sides), circle(radius, bed, sides)
    mat = geometry(
        np.concatenate([inner[:-1], [[0, 0, bed - 0.02]]]),
        np.stack([np.arange(sides), np.roll(np.arange(sides), -1), np.full(sides, sides)], 1),
        tint=(0.02, 0.02, 0.021),
    )
    cover = quads(
        np.stack([outer[:-1], outer[1:], inner[1:] + [0, 0, 0.03], inner[:-1] + [0, 0, 0.03]], 1),
        pad,
    )
    skirt = quads(
        np.stack([outer[:-1] - [0, 0, 0.1], outer[1:] - [0, 0, 0.1], outer[1:], outer[:-1]], 1), pad
    )
    turn = 2 * np.pi * np.arange(6) / 6
    at = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn]) * (radius + 0.02)
    posts = round_bars(at - [0, 0, 0.03], at + [0, 0, 2.55], 0.022, STEEL, 5)
    rings = [
        tube(circle(radius + 0.02, z, sides), 0.02, 4, STEEL, capped=False) for z in (0.8, 2.5)
    ]
    strand = 2 * np.pi * np.arange(60) / 60
    foot = np.column_stack([np.cos(strand), np.sin(strand), 0 * strand]) * radius + [0, 0, bed]
    side = np.column_stack([-np.sin(strand), np.cos(strand), 0 * strand]) * 0.003
    up = np.array([0, 0, 1.62])
    net = quads(np.stack([foot - side, foot + side, foot + side + up, foot - side + up], 1), DARK)
    return {
        ("fabric", LABEL): join([mat, cover, skirt, net]),
        ("paint", LABEL): join([posts, *rings]),
    }


def _chair(tint, wood: bool) -> Geometry:
    """A garden chair looking towards +x."""
    legs = [box((0.04, 0.04, 0.42 if x > 0 else 0.85), (x, y, -0.01), tint)
            for x in (0.2, -0.2) for y in (0.22, -0.22)]  # fmt: skip
    seat = box((0.46, 0.48, 0.035), (0, 0, 0.41), tint)
    slats = [box((0.025, 0.44, 0.09 if wood else 0.16), (-0.2, 0, z), tint) for z in (0.52, 0.7)]
    return join([*legs, seat, *slats])


def _table(rng: np.random.Generator) -> Model:
    """Table, four to six chairs and, mostly, a parasol."""
    wood = bool(rng.random() < 0.6)
    tint = draw_timber(rng) if wood else draw_colour(rng, [WHITE, DARK, (0.12, 0.12, 0.12)])
    length, width = rng.uniform(1.3, 1.9), 0.9
    parts = [box((length, width, 0.04), (0, 0, 0.71), tint)]
    parts += [box((0.07, 0.07, 0.73), (x * (length / 2 - 0.1), y * 0.36, -0.02), tint)
              for x in (1, -1) for y in (1, -1)]  # fmt: skip
    count = 2 if length < 1.6 else 3
    x = (np.arange(count) - (count - 1) / 2) * (length / count)
    at = np.concatenate([np.column_stack([x, np.full(count, s * 0.75), 0 * x]) for s in (1, -1)])
    at[:, :2] += rng.normal(0, 0.08, (2 * count, 2))
    yaw = np.repeat([-np.pi / 2, np.pi / 2], count) + rng.normal(0, 0.2, 2 * count)
    parts.append(copies(_chair(tint, wood), at, rotation=yaw_matrix(yaw)))
    model = {("wood" if wood else "paint", LABEL): join(parts)}
    if rng.random() < 0.7:
        cloth = draw_colour(
            rng, [(0.5, 0.45, 0.36), (0.2, 0.03, 0.03), (0.03, 0.1, 0.06), (0.04, 0.07, 0.16)]
        )
        rim, n = circle(1.35, 2.05, 8)[:-1], 8
        sag = np.array([0, 0, -0.12])
        apex = np.array([[0, 0, 2.5]])
        nxt = np.roll(np.arange(n), -1)
        cone = geometry(
            np.concatenate([rim, apex]), np.stack([np.arange(n), nxt, np.full(n, n)], 1), tint=cloth
        )
        fringe = quads(np.stack([rim + sag, rim[nxt] + sag, rim[nxt], rim], 1), cloth * 0.92)
        model["fabric", LABEL] = join([cone, fringe])
        rod = tube([[0, 0, -0.02], [0, 0, 2.52]], 0.022, 5, WHITE)
        foot = _lathe([0.26, 0.24, 0.05], [-0.02, 0.08, 0.12], 8, DARK)
        model["paint", LABEL] = join([*([model["paint", LABEL]] if not wood else []), rod, foot])
    return model


def _swing(rng: np.random.Generator) -> Model:
    """A-frame, 2.1 m high, with two seats that hang a little askew."""
    tint = draw_colour(rng, [(0.04, 0.1, 0.05), (0.03, 0.07, 0.2), (0.3, 0.03, 0.03), STEEL])
    y, high = 1.3, 2.1
    start, end = [], []
    for s in (1, -1):
        for x in (0.8, -0.8):
            start.append([x, s * (y + 0.15), -0.05])
            end.append([0, s * y, high])
    start.append([0, -y - 0.05, high])
    end.append([0, y + 0.05, high])
    frame = round_bars(start, end, 0.028, tint)
    seats, ropes_a, ropes_b = [], [], []
    for sy in (0.6, -0.6):
        x = rng.normal(0, 0.12)
        z = 0.45 + x * x / 3
        seats.append(
            box(
                (0.2, 0.46, 0.03),
                (x, sy, z),
                draw_colour(rng, [(0.02, 0.05, 0.2), (0.4, 0.25, 0.02)]),
            )
        )
        for d in (0.21, -0.21):
            ropes_a.append([0, sy + d, high])
            ropes_b.append([x, sy + d, z + 0.03])
    ropes = round_bars(ropes_a, ropes_b, 0.008, (0.25, 0.22, 0.16), 3)
    return {("paint", LABEL): join([frame, *seats, ropes])}


def _washing_line(rng: np.random.Generator) -> Model:
    """Two T-posts, three lines and some washing."""
    span, high = rng.uniform(4, 6), 1.9
    posts = [
        tube([[s * span / 2, 0, -0.05], [s * span / 2, 0, high]], 0.03, 6, STEEL) for s in (1, -1)
    ]
    arms = [
        tube([[s * span / 2, -0.6, high], [s * span / 2, 0.6, high]], 0.022, 5, STEEL)
        for s in (1, -1)
    ]
    y = np.array([-0.5, 0.0, 0.5])
    o = np.full(3, high)
    lines = round_bars(
        np.column_stack([o * 0 - span / 2, y, o]), np.column_stack([o * 0 + span / 2, y, o]), 0.004,
        (0.3, 0.3, 0.28), 3,
    )  # fmt: skip
    count = int(rng.integers(3, 8))
    x = (np.arange(count) + 0.5) / count * (span - 0.6) - (span - 0.6) / 2
    w = rng.uniform(0.3, 0.8, count) * (span - 0.6) / count
    h = rng.uniform(0.5, 1.4, count)
    row = y[rng.integers(3, size=count)]
    blow = rng.normal(0, 0.08, count)
    colours = np.array(
        [
            [0.6, 0.6, 0.58],
            [0.12, 0.2, 0.35],
            [0.35, 0.08, 0.08],
            [0.45, 0.38, 0.2],
            [0.05, 0.05, 0.06],
        ]
    )
    corners = np.stack(
        [
            np.stack([x + s * w, row + lean * blow, high - drop * h], -1)
            for s, lean, drop in ((-1, 1, 1), (1, 1, 1), (1, 0, 0), (-1, 0, 0))
        ],
        axis=1,
    )
    cloth = quads(corners, colours[rng.integers(len(colours), size=count)])
    return {("paint", LABEL): join([*posts, *arms, lines]), ("fabric", LABEL): cloth}


def _goal(rng: np.random.Generator) -> Model:
    """A child's football goal, open towards +x, with a coarse net."""
    width = rng.uniform(1.8, 3.0)
    high, deep = width * 0.55, width * 0.35
    y = width / 2
    start = [[0, y, -0.03], [0, -y, -0.03], [0, -y, high], [-deep, -y, 0.03]]
    end = [[0, y, high], [0, -y, high], [0, y, high], [-deep, y, 0.03]]
    for s in (1, -1):
        start += [[0, s * y, high], [0, s * y, 0.03]]
        end += [[-deep, s * y, 0.03], [-deep, s * y, 0.03]]
    frame = round_bars(start, end, 0.03, WHITE)
    t = np.arange(-y, y + 0.01, 0.12)
    back_a = np.column_stack([0 * t, t, 0 * t + high])
    back_b = np.column_stack([0 * t - deep, t, 0 * t + 0.03])
    u = np.linspace(0, 1, int(np.hypot(high, deep) / 0.12))[1:-1]
    row_a = np.column_stack([-deep * u, 0 * u - y, high + u * (0.03 - high)])
    row_b = row_a * [1, -1, 1]
    a, b = np.concatenate([back_a, row_a]), np.concatenate([back_b, row_b])
    flat = np.where(np.abs(b[:, 1:2] - a[:, 1:2]) > 0.1, [0.003, 0, 0.003], [0, 0.004, 0])
    net = quads(np.stack([a - flat, b - flat, b + flat, a + flat], 1), (0.55, 0.55, 0.53))
    return {("paint", LABEL): frame, ("fabric", LABEL): net}


def _hydrant(rng: np.random.Generator) -> Model:
    """A pillar hydrant, outlets to both sides."""
    tint = draw_colour(rng, [(0.36, 0.03, 0.02), (0.45, 0.3, 0.02), (0.3, 0.3, 0.3)])
    heights = [-0.05, 0.06, 0.06001, 0.5, 0.5001, 0.55, 0.65, 0.7, 0.75]
    radii = [0.16, 0.16, 0.095, 0.095, 0.13, 0.13, 0.1, 0.04, 0.03]
    body = _lathe(radii, heights, 10, tint)
    outlets = round_bars(
        [[0, -0.18, 0.42], [0, 0, 0.38]], [[0, 0.18, 0.42], [0.18, 0, 0.38]], 0.055, tint, 8
    )
    return {("paint", LABEL): join([body, outlets])}


def _bench(rng: np.random.Generator) -> Model:
    """A slatted park bench looking towards +x."""
    wood = draw_timber(rng)
    x = np.array([0.2, 0.07, -0.06, -0.19])
    slats = [box((0.11, 1.6, 0.035), (a, 0, 0.42), wood) for a in x]
    slats += [
        box((0.03, 1.6, 0.1), (-0.25 - 0.12 * (z - 0.5), 0, z), wood) for z in (0.52, 0.66, 0.8)
    ]
    iron = []
    for y in (-0.65, 0.65):
        iron += [
            box((0.05, 0.05, 0.44), (0.2, y, -0.03)),
            box((0.05, 0.05, 0.46), (-0.22, y, -0.03)),
            box((0.5, 0.05, 0.04), (0, y, 0.385)),
            beams([[-0.25, y, 0.4]], [[-0.31, y, 0.9]], 0.05, 0.04),
            box((0.48, 0.05, 0.03), (-0.02, y, 0.62)),
            box((0.04, 0.04, 0.2), (0.2, y, 0.43)),
        ]
    return {("wood", LABEL): join(slats), ("paint", LABEL): join(iron).tinted(DARK)}


@dataclasses.dataclass(frozen=True)
class GardenItem:
    """A kind of thing: its builder (draws and builds) and the radius of ground it needs [m]."""

    build: Callable[[np.random.Generator], Model]
    radius_m: float


GARDEN_ITEMS = {
    "letter_box": GardenItem(_letter_box, 0.35),
    "bins": GardenItem(_bins, 1.2),
    "trampoline": GardenItem(_trampoline, 2.0),
    "shed": GardenItem(shed, 2.1),
    "greenhouse": GardenItem(greenhouse, 2.3),
    "table": GardenItem(_table, 1.6),
    "swing": GardenItem(_swing, 1.8),
    "pool": GardenItem(pool, 5.7),
    "paddling_pool": GardenItem(paddling_pool, 2.4),
    "washing_line": GardenItem(_washing_line, 3.2),
    "goal": GardenItem(_goal, 1.9),
    "hydrant": GardenItem(_hydrant, 0.3),
    "bench": GardenItem(_bench, 0.95),
}


def garden_item(rng: np.random.Generator, name: str) -> Model:
    """One drawn item, a key of `GARDEN_ITEMS`, in its own frame (front towards +x)."""
    if name not in GARDEN_ITEMS:
        raise KeyError(f"garden item {name!r} is not one of {sorted(GARDEN_ITEMS)}")
    return GARDEN_ITEMS[name].build(rng)


def scatter(
    rng: np.random.Generator, name: str, positions, headings_rad, variants: int = 4
) -> dict[tuple[str, str], Geometry]:
    """Items of one kind at `positions` (k, 3) [m], fronts towards `headings_rad` (k,)."""
    at = np.asarray(positions, np.float64).reshape(-1, 3)
    rotation = yaw_matrix(np.broadcast_to(np.asarray(headings_rad, np.float64), len(at)))
    models = [garden_item(rng, name) for _ in range(min(variants, len(at)))]
    pick = rng.integers(max(len(models), 1), size=len(at))
    placed = []
    for index, model in enumerate(models):
        chosen = pick == index
        placed.append(
            {k: copies(p, at[chosen], rotation=rotation[chosen]) for k, p in model.items()}
        )
    return merge(placed)
