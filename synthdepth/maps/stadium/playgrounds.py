"""A playground and a skate park.

Each returns a `Piece` for a rectangle about the origin; its size comes in along x and y [m].
"""

import numpy as np
import shapely

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.geometry import Geometry, Model, box, join, place, quads, tube
from synthdepth.maps.placement import points_along, points_within
from synthdepth.maps.stadium.courts import edge_tufts, enclosure, rectangle
from synthdepth.maps.stadium.piece import Patch, Piece

_STEEL = (0.3, 0.31, 0.32)
_TIMBER = (0.3, 0.21, 0.12)
_PLAY_TINTS = ((0.35, 0.05, 0.03), (0.45, 0.3, 0.03), (0.03, 0.11, 0.24), (0.05, 0.16, 0.06))
_LIP_RADIUS_M = 2.4  # of a quarter pipe


def _bent_sheet(profile: np.ndarray, half_width: float, tint) -> Geometry:
    """A sheet along y, bent to a profile (k, 2) of x and z."""
    ring = [np.insert(profile, 1, s * half_width, axis=1) for s in (-1, 1)]
    return quads(np.stack([ring[0][:-1], ring[0][1:], ring[1][1:], ring[1][:-1]], 1), tint)


def _tower(rng: np.random.Generator) -> Model:
    """A play tower with a slide towards +x, a ladder and a roof."""
    deck = rng.uniform(1.2, 1.8)
    tint = np.array(_PLAY_TINTS)[rng.permutation(4)]
    feet = np.array([[x, y, -0.05] for x in (-0.7, 0.7) for y in (-0.7, 0.7)])
    posts = beams(feet, feet + [0, 0, deck + 1.9], 0.1, 0.1)
    floor = box((1.5, 1.5, 0.06), (0, 0, deck))
    sides = [
        beams([[-0.7, s * 0.7, deck + h]], [[0.7, s * 0.7, deck + h]], 0.05, 0.12)
        for s in (-1, 1)
        for h in (0.3, 0.6, 0.9)
    ]
    ridge, eaves = deck + 2.5, deck + 1.85
    roof = quads(
        [
            [
                [s * 0.95, -s * 0.95, eaves],
                [s * 0.95, s * 0.95, eaves],
                [0, s * 0.95, ridge],
                [0, -s * 0.95, ridge],
            ]
            for s in (-1, 1)
        ],
        tint[0],
    )
    slide_x = np.linspace(0.7, 0.7 + 1.7 * deck, 7)
    drop = deck * (1 - np.clip((slide_x - 0.7) / (1.45 * deck), 0, 1) ** 1.15) + 0.12
    profile = np.column_stack([slide_x, drop])
    chute = _bent_sheet(profile, 0.27, tint[1])
    lips = [
        tube(np.column_stack([slide_x, np.full(7, s * 0.28), drop + 0.14]), 0.025, 5, tint[1])
        for s in (-1, 1)
    ]
    rungs_z = np.arange(0.3, deck + 0.1, 0.3)
    rungs = np.column_stack(
        [-0.78 - 0.25 * (1 - rungs_z / deck), np.full(len(rungs_z), -0.35), rungs_z]
    )
    ladder = round_bars(rungs, rungs * [1, -1, 1], 0.018, tint[2], 5)
    rails = round_bars(
        [[-1.05, s * 0.35, 0] for s in (-1, 1)],
        [[-0.72, s * 0.35, deck + 0.9] for s in (-1, 1)],
        0.022,
        tint[2],
        5,
    )
    return {
        ("wood", "obstacle"): join([posts, floor, *sides]).tinted(_TIMBER),
        ("paint", "obstacle"): join([roof, chute, *lips, ladder, rails]),
    }


def _climber(rng: np.random.Generator) -> Model:
    """A pyramid of ropes on a mast."""
    high, reach = rng.uniform(3.5, 5.5), rng.uniform(2.6, 3.6)
    mast = tube([[0, 0, -0.1], [0, 0, high]], 0.08, 8, _STEEL)
    turn = 2 * np.pi * np.arange(6) / 6
    foot = np.column_stack([reach * np.cos(turn), reach * np.sin(turn), 0 * turn])
    top = np.tile([[0, 0, high - 0.1]], (6, 1))
    a, b = [foot], [top]
    for level in np.arange(0.12, 0.9, 0.13):
        ring = foot + level * (top - foot)
        a.append(ring)
        b.append(np.roll(ring, -1, 0))
        a.append(ring)
        b.append(np.tile([[0, 0, level * high]], (6, 1)))
    tint = np.array(_PLAY_TINTS)[rng.integers(4)]
    return {
        ("paint", "obstacle"): join([mast]),
        ("fabric", "obstacle"): round_bars(np.concatenate(a), np.concatenate(b), 0.011, tint, 3),
    }


def _sand_box(x: float, y: float) -> Model:
    """Eight sleepers around sand."""
    turn = np.arange(9) * np.pi / 4
    ring = np.column_stack([x + 2.2 * np.cos(turn), y + 2.2 * np.sin(turn), np.full(9, 0.1)])
    return {("wood", "obstacle"): beams(ring[:-1], ring[1:], 0.14, 0.28, _TIMBER)}


def playground(rng: np.random.Generator, size) -> Piece:
    """Towers, ropes, swings, seesaws and benches on safety rubber and bark."""
    field = rectangle(size, 1.0)
    wave = 1 + 0.12 * np.sin(np.arange(24) * 2 * np.pi / 24 * 3 + rng.uniform(0, 6))
    turn = 2 * np.pi * np.arange(24) / 24
    blob = shapely.Polygon(
        np.column_stack([np.cos(turn) * size[0] * 0.43, np.sin(turn) * size[1] * 0.43])
        * wave[:, None]
    ).intersection(field)
    tint = np.array([(0.2, 0.06, 0.04), (0.05, 0.11, 0.16), (0.25, 0.17, 0.07)])[rng.integers(3)]
    spots = points_within(rng, blob.buffer(-2.5), 7, 6.0)
    models, furniture, sand = [], [], []
    makers = [_tower, _climber, _tower]
    for k, (x, y) in enumerate(spots):
        turn_k = rng.uniform(0, 6.28)
        if k < len(makers):
            models.append(place(makers[k](rng), (x, y, 0), turn_k))
        elif k < 5:
            furniture.append(("swing", np.array([[x, y, turn_k]])))
        else:
            sand.append(shapely.Point(x, y).buffer(2.2))
            models.append(_sand_box(x, y))
    patches = [Patch(area=blob, surface=("rubber_floor", "ground"), tint=tuple(tint), rank=3)]
    if sand:
        patches.append(
            Patch(
                area=shapely.union_all(sand),
                surface=("gravel", "ground"),
                tint=(1.3, 1.2, 1.0),
                rank=4,
            )
        )
    models += enclosure(rng, np.subtract(size, 1.2), str(rng.choice(["picket", "chain_link"])), 1.1)
    kids = points_within(rng, blob, 5, 2.0)
    benches = points_along(rectangle(size, 2.2).exterior, 16.0, rng)
    heading = np.arctan2(-benches[:, 1], -benches[:, 0])
    furniture.append(("bench", np.column_stack([benches, heading])))
    return Piece(
        models=models,
        patches=patches,
        people=[("standing", "", np.column_stack([kids, rng.uniform(0, 6, len(kids))]))],
        furniture=furniture,
        trees=points_along(rectangle(size, 0.2).exterior, 13.0, rng),
        tufts=np.concatenate(
            [edge_tufts(rng, np.subtract(size, 1.2)), points_along(blob.exterior, 0.4, rng)]
        ),
        keep_clear=[field],
    )


def _quarter_pipe(lip: np.ndarray, face: float, wide: float) -> tuple[list, list]:
    """Concrete and steel of a quarter pipe whose lip's middle is at (3,); it falls along `face`."""
    at_x, at_y, high = lip
    bow = np.linspace(0, np.arccos(1 - high / _LIP_RADIUS_M), 8)
    x, z = np.sin(bow), 1 - np.cos(bow)
    run = np.column_stack([at_x + face * _LIP_RADIUS_M * (x[-1] - x), _LIP_RADIUS_M * z])
    back, half = at_x - face * 1.2, wide / 2
    panels = [
        [[at_x, -half, high], [at_x, half, high], [back, half, high], [back, -half, high]],
        [[back, -half, -0.1], [back, half, -0.1], [back, half, high], [back, -half, high]],
    ]
    for s in (-half, half):
        panels.append([[back, s, -0.1], [at_x, s, -0.1], [at_x, s, high], [back, s, high]])
        foot = np.column_stack([run[:, 0], np.full(8, s), np.full(8, -0.05)])
        edge = np.column_stack([run[:, 0], np.full(8, s), run[:, 1]])
        panels += list(np.stack([foot[:-1], foot[1:], edge[1:], edge[:-1]], 1))
    concrete = [_bent_sheet(run, half, (1.1, 1.1, 1.1)), quads(np.array(panels, float))]
    rail = np.array([[back + face * 0.05, s, high] for s in (-half, half)])
    posts = np.linspace(*rail, 5)
    up = np.array([0, 0, 1.0])
    steel = [
        round_bars([[at_x, -half, high]], [[at_x, half, high]], 0.03),
        round_bars(rail[[0, 0]] + [0.5 * up, up], rail[[1, 1]] + [0.5 * up, up], 0.022),
        round_bars(posts, posts + up, 0.022),
    ]
    shift = (0, at_y, 0)
    return [part.moved(shift) for part in concrete], [part.moved(shift) for part in steel]


def skate_park(rng: np.random.Generator, size) -> Piece:
    """Quarter pipes, a funbox, ledges and rails on smooth concrete."""
    x, y = np.array(size) / 2 - 1.5
    area = rectangle(size, 1.5)
    solids, metal = [], []
    for face, wide, shift in ((1, 1.2 * y, rng.uniform(-0.3, 0.3) * y), (-1, 1.5 * y, 0.0)):
        lip = np.array([face * (1.4 - x), shift, rng.uniform(1.0, 1.9)])
        concrete, steel = _quarter_pipe(lip, face, wide)
        solids += concrete
        metal += steel
    high, long = rng.uniform(0.5, 0.9), rng.uniform(3.4, 4.4)
    bank = np.array([[-long, 0], [-1.2, high], [1.2, high], [long, 0]])
    solids.append(_bent_sheet(bank, 1.6, (1, 1, 1)))
    sides = [np.insert(bank, 1, s, axis=1)[[0, 3, 2, 1]] for s in (-1.6, 1.6)]
    solids.append(quads(np.array(sides)))
    solids.append(box((2.4, 0.5, high + 0.45), (0, 1.0, -0.05)))
    for k in range(3):
        px, py = rng.uniform(-0.55, 0.55) * x, (k - 1) * 0.75 * y
        if abs(py) > 2.5:
            solids.append(box((rng.uniform(2.5, 4), 0.55, 0.5), (px, py, -0.05)))
        a, b = np.array([[px - 1.8, py + 1.4, 0.45], [px + 1.8, py + 1.4, 0.45]])
        metal.append(round_bars([a, a * [1, 1, 0], b * [1, 1, 0]], [b, a, b], 0.025))
    riders = points_within(rng, area.buffer(-2), 3, 3.0)
    return Piece(
        models=[{("concrete", "obstacle"): join(solids), ("metal", "obstacle"): join(metal)}],
        patches=[Patch(area=area, surface=("concrete", "pavement"), rank=3)],
        people=[("standing", "", np.column_stack([riders, rng.uniform(0, 6, len(riders))]))],
        trees=points_along(rectangle(size, 0.0).exterior, 12.0, rng),
        tufts=edge_tufts(rng, np.subtract(size, 3.0)),
        keep_clear=[area],
    )
