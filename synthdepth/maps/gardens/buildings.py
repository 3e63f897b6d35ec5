"""Sheds, greenhouses and pools of gardens."""

import itertools

import numpy as np

from synthdepth.maps.bars import beams
from synthdepth.maps.gardens.parts import (
    LABEL,
    TIMBER,
    WHITE,
    circle,
    draw_colour,
)
from synthdepth.maps.geometry import Model, box, geometry, join, quads, tube


def _gable(width: float, depth: float, eaves: float, ridge: float, overhang: float) -> tuple:
    """Walls (quads with gables) and a two-slope roof slab; ridge along y, front towards +x."""
    x, y = depth / 2, width / 2
    low = -0.05
    walls = quads(
        [
            [[x, -y, low], [x, y, low], [x, y, eaves], [x, -y, eaves]],
            [[-x, y, low], [-x, -y, low], [-x, -y, eaves], [-x, y, eaves]],
            [[-x, -y, low], [x, -y, low], [x, -y, eaves], [-x, -y, eaves]],
            [[x, y, low], [-x, y, low], [-x, y, eaves], [x, y, eaves]],
        ]
    )
    tops = []
    for s in (1, -1):
        tri = np.array([[-s * x, s * y, eaves], [0, s * y, ridge], [s * x, s * y, eaves]])
        tops.append(geometry(tri, [[0, 1, 2]], tri[:, [0, 2]]))
    slope = (ridge - eaves) / x
    edge = x + overhang
    roof = []
    for s in (1, -1):
        low_z = ridge - slope * edge
        across = y + overhang
        upper = np.array(
            [[s * edge, -s * across, low_z], [s * edge, s * across, low_z],
             [0, s * across, ridge], [0, -s * across, ridge]]
        )  # fmt: skip
        under = upper[::-1]
        upper = upper + [0, 0, 0.06]
        front = np.stack([under[3], under[2], upper[1], upper[0]])
        side_a = np.stack([under[2], under[1], upper[2], upper[1]])
        side_b = np.stack([under[0], under[3], upper[0], upper[3]])
        roof.append(quads([upper, under, front, side_a, side_b]))
    return join([walls, *tops]), join(roof)


def shed(rng: np.random.Generator) -> Model:
    """Wooden shed with a gable roof, door and window towards +x."""
    width, depth = rng.uniform(1.8, 3.0), rng.uniform(1.5, 2.2)
    eaves = rng.uniform(1.75, 2.0)
    walls, roof = _gable(width, depth, eaves, eaves + 0.22 * depth, 0.12)
    colour = draw_colour(rng, [*TIMBER, (0.05, 0.09, 0.06), (0.12, 0.15, 0.17)])
    y = -width / 2 + 0.6
    trim = [box((0.04, 0.06, 1.72), (depth / 2 + 0.005, y + s * 0.4, 0.05)) for s in (1, -1)]
    trim.append(box((0.04, 0.86, 0.06), (depth / 2 + 0.005, y, 1.72)))
    door = box((0.03, 0.74, 1.67), (depth / 2, y, 0.05), colour * 0.85)
    pane_y = width / 2 - 0.45
    frame = box((0.05, 0.6, 0.55), (depth / 2, pane_y, 1.0), WHITE)
    pane = quads(
        [[[depth / 2 + 0.031, pane_y - s * 0.26, z] for s, z in
          ((1, 1.04), (-1, 1.04), (-1, 1.51), (1, 1.51))]]
    )  # fmt: skip
    return {
        ("wood", "building"): join([walls.tinted(colour), door]),
        ("shingle", "roof"): roof.tinted(draw_colour(rng, [(0.1, 0.1, 0.1), (0.14, 0.09, 0.07)])),
        ("paint", "building"): join([join(trim).tinted(colour * 0.7), frame]),
        ("glass", "building"): pane,
    }


def greenhouse(rng: np.random.Generator) -> Model:
    """Aluminium frame and panes on a low plinth."""
    width, depth, eaves = rng.uniform(2.4, 3.6), 1.95, 1.45
    ridge = eaves + 0.65
    walls, roof = _gable(width, depth, eaves, ridge, 0.0)
    x, y = depth / 2 + 0.012, width / 2 + 0.012
    steps = np.linspace(-y, y, max(int(width / 0.62), 3) + 1)
    foot = np.concatenate([np.column_stack([np.full(len(steps), s * x), steps]) for s in (1, -1)])
    low = np.column_stack([foot, np.zeros(len(foot))])
    high = np.column_stack([foot, np.full(len(foot), eaves + 0.065)])
    peak = np.column_stack([0 * foot[:, 0], foot[:, 1], np.full(len(foot), ridge + 0.075)])
    ends = [[s * d, t * y] for t in (1, -1) for s in (1, -1) for d in (0.33,)]
    end_low = np.column_stack([ends, np.zeros(4)])
    end_high = np.column_stack([ends, np.full(4, ridge - 0.2)])
    rows = [([s * x, -y, z], [s * x, y, z]) for s in (1, -1) for z in (0.75, eaves)]
    rows += [([-x, t * y, 0.75], [x, t * y, 0.75]) for t in (1, -1)]
    rows += [([0, -y, ridge + 0.06], [0, y, ridge + 0.06])]
    row_a, row_b = (np.array(e, float) for e in zip(*rows, strict=True))
    frame = beams(
        np.concatenate([low, high, end_low, row_a]),
        np.concatenate([high, peak, end_high, row_b]),
        0.03, 0.03, (0.55, 0.56, 0.56) if rng.random() < 0.6 else (0.03, 0.07, 0.045),
    )  # fmt: skip
    plinth = [box((depth + 0.1, 0.1, 0.15), (0, s * width / 2, -0.05)) for s in (1, -1)]
    plinth += [box((0.1, width - 0.1, 0.15), (s * depth / 2, 0, -0.05)) for s in (1, -1)]
    return {
        ("glass", "building"): join([walls, roof]),
        ("paint", "building"): frame,
        ("concrete", "building"): join(plinth),
    }


def pool(rng: np.random.Generator) -> Model:
    """A pool let into a raised stone surround; the water is 6 cm above the lawn."""
    length, width, edge = rng.uniform(6, 9), rng.uniform(3, 4.2), 0.5
    rim = []
    for s in (1, -1):
        rim.append(box((length + 2 * edge, edge, 0.22), (0, s * (width + edge) / 2, -0.08)))
        rim.append(box((edge, width, 0.22), (s * (length + edge) / 2, 0, -0.08)))
    nx, ny = 14, 8
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, nx) * length, np.linspace(-0.5, 0.5, ny) * width)
    z = 0.06 + rng.uniform(-0.004, 0.004, x.shape)
    i = np.arange(nx * ny).reshape(ny, nx)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    faces = np.stack([a, b, c, a, c, d], -1).reshape(-1, 3)
    tint = draw_colour(rng, [(0.06, 0.27, 0.34), (0.05, 0.22, 0.27), (0.1, 0.32, 0.36)])
    water = geometry(np.stack([x, y, z], -1), faces, tint=tint)
    rails = []
    for s in (0.25, -0.25):
        bend = np.array(
            [[0.25, 0.05], [0.25, 0.75], [0.12, 0.95], [-0.12, 0.95], [-0.3, 0.6], [-0.35, 0.0]]
        )
        rails.append(
            tube(np.column_stack([bend[:, 0] + length / 2, np.full(6, s), bend[:, 1]]), 0.02, 5)
        )
    return {
        ("concrete", "pavement"): join(rim),
        ("car_paint", "water"): water,
        ("metal", LABEL): join(rails),
    }


def paddling_pool(rng: np.random.Generator) -> Model:
    """A round pool that stands on the lawn."""
    radius, high = rng.uniform(1.2, 2.3), rng.uniform(0.5, 0.9)
    tint = draw_colour(rng, [(0.04, 0.12, 0.3), (0.12, 0.25, 0.35), (0.3, 0.3, 0.3)])
    outer, inner = radius, radius - 0.12
    sides = 20
    profile = [
        (outer, -0.03),
        (outer + 0.03, high * 0.5),
        (outer, high),
        (inner, high),
        (inner, high * 0.6),
    ]
    rings = [circle(r, z, sides) for r, z in profile]
    wall = quads(
        np.concatenate(
            [np.stack([a[:-1], a[1:], b[1:], b[:-1]], 1) for a, b in itertools.pairwise(rings)]
        ),
        tint,
    )
    level = circle(inner, high * 0.82, sides)[:-1]
    fan = np.stack([np.zeros(sides - 2), np.arange(1, sides - 1), np.arange(2, sides)], 1).astype(
        int
    )
    return {
        ("paint", LABEL): wall,
        ("car_paint", "water"): geometry(level, fan, tint=(0.06, 0.22, 0.3)),
    }
