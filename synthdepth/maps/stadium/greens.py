"""What grows and stands between the pitches: groves, yards, the clubhouse's garden."""

import numpy as np
import shapely

from synthdepth.maps.geometry import Model, place, quads
from synthdepth.maps.placement import points_along, points_within
from synthdepth.maps.stadium.buildings import clubhouse, container, groundsman_shed, kiosk
from synthdepth.maps.stadium.courts import rectangle
from synthdepth.maps.stadium.nets import goal
from synthdepth.maps.stadium.piece import Patch, Piece
from synthdepth.maps.stadium.touchline import flags


def grove(rng: np.random.Generator, size, trees_per_hectare: float) -> Piece:
    """A lawn with trees, bushes, tables and long grass along its edge."""
    area = rectangle(size)
    inner = rectangle(size, min(1.2, 0.2 * min(size)))
    count = int(area.area * trees_per_hectare / 1e4 * rng.uniform(0.7, 1.3)) + 1
    narrow = min(size) < 16
    if narrow or rng.random() < 0.3:
        # An avenue: trees in rows.
        long = int(size[1] > size[0])
        rows = max(int(min(size) // 9), 1)
        offset = (np.arange(rows) - (rows - 1) / 2) * (min(size) / rows)
        step = rng.uniform(7, 11)
        s = np.arange(-max(size) / 2 + 3, max(size) / 2 - 2, step)
        a, b = (v.ravel() for v in np.meshgrid(s, offset, indexing="ij"))
        trees = np.column_stack([a, b] if long == 0 else [b, a]) + rng.normal(0, 0.4, (len(a), 2))
        trees = trees[rng.random(len(trees)) < 0.9]
    else:
        trees = points_within(rng, inner, count, 5.5)
    bushes = points_within(rng, inner, count // 2 + 1, 2.0)
    free = shapely.difference(inner, shapely.MultiPoint(trees).buffer(2.5)) if len(trees) else inner
    places = points_within(rng, free, int(area.area / 500), 6.0)
    turn = rng.uniform(0, 6.28, len(places))
    kinds = rng.choice(["picnic_table", "bench", "bench", "litter_bin"], len(places))
    furniture = [
        (str(kind), np.column_stack([places, turn])[kinds == kind]) for kind in np.unique(kinds)
    ]
    walkers = points_within(rng, free, int(area.area / 900), 5.0)
    long_grass = points_within(rng, area, int(min(area.area / 1.2, 3000)))
    below = trees.repeat(60, axis=0) + rng.normal(0, 2.4, (60 * len(trees), 2))
    return Piece(
        models=[fallen_leaves(rng, below)] if len(below) else [],
        trees=trees,
        bushes=bushes,
        tufts=long_grass,
        furniture=furniture,
        people=[("standing", "", np.column_stack([walkers, rng.uniform(0, 6, len(walkers))]))],
    )


def fallen_leaves(rng: np.random.Generator, positions: np.ndarray) -> Model:
    """Leaves and twigs (k, 2) on the lawn, brown, yellow and dull green."""
    k = len(positions)
    turn, size = rng.uniform(0, 2 * np.pi, k), rng.uniform(0.03, 0.08, k)
    along = np.column_stack([np.cos(turn), np.sin(turn), rng.normal(0, 0.3, k)]) * size[:, None]
    across = np.column_stack([-np.sin(turn), np.cos(turn), rng.normal(0, 0.4, k)])
    across *= (0.6 * size)[:, None]
    middle = np.column_stack([positions, rng.uniform(0.012, 0.03, k)])
    corners = np.stack([middle - along, middle - across, middle + along, middle + across], axis=1)
    colours = np.array(
        [(0.16, 0.1, 0.045), (0.24, 0.17, 0.05), (0.1, 0.075, 0.04), (0.1, 0.11, 0.04)]
    )
    tint = colours[rng.integers(4, size=k)] * rng.uniform(0.7, 1.2, (k, 1))
    return {("leaf", "ground"): quads(corners, tint)}


def club_garden(rng: np.random.Generator, size, colours: np.ndarray) -> Piece:
    """The clubhouse on its terrace, tables before it, a kiosk and flags; its front looks to -y."""
    length, depth = float(min(size[0] - 4, rng.uniform(18, 30))), float(rng.uniform(8, 11))
    y = size[1] / 2 - depth / 2 - 1.0
    models = [place(clubhouse(rng, length, depth, colours[0]), (0, y, 0), -np.pi / 2)]
    terrace = shapely.box(
        -size[0] / 2 + 0.5, -size[1] / 2 + 0.5, size[0] / 2 - 0.5, size[1] / 2 - 0.5
    )
    front = y - depth / 2 - 4.2
    seats = points_within(
        rng, shapely.box(-length / 2, -size[1] / 2 + 2, length / 2, front - 1), 8, 3.2
    )
    hut = (-size[0] / 2 + 3.0, -size[1] / 2 + 3.0, 0)
    models.append(place(kiosk(rng, colours[0]), hut, rng.choice([0.0, np.pi / 2])))
    models.append(
        flags(rng, np.array([[size[0] / 2 - 1.5, t] for t in (-4.0, 0.0, 4.0)]), 7.0, colours)
    )
    people = points_within(
        rng, shapely.box(-length / 2, -size[1] / 2 + 1, length / 2, front), 9, 1.0
    )
    racks = np.array([[size[0] / 2 - 4, front - 2, np.pi / 2]])
    return Piece(
        models=models,
        patches=[Patch(area=terrace, surface=("paving", "pavement"), rank=2)],
        furniture=[
            ("picnic_table", np.column_stack([seats[:5], rng.uniform(0, 6, len(seats[:5]))])),
            ("table", np.column_stack([seats[5:], rng.uniform(0, 6, len(seats[5:]))])),
            ("bicycle_rack", racks),
            ("litter_bin", np.array([[-length / 2 - 1, front, 0.0]])),
            (
                "planter",
                np.column_stack(
                    [np.linspace(-0.45, 0.45, 5) * length, np.full(5, front - 0.6), np.zeros(5)]
                ),
            ),
        ],
        people=[("standing", "", np.column_stack([people, rng.uniform(0, 6, len(people))]))],
        keep_clear=[terrace],
        trees=points_along(terrace.exterior, 15.0, rng),
    )


def yard(rng: np.random.Generator, size) -> Piece:
    """The groundsman's: a shed, containers, spare goals."""
    area = rectangle(size, 0.5)
    x, y = np.array(size) / 2
    models = [place(groundsman_shed(rng), (-x + 5.5, 0, 0), 0.0)]
    for k in range(int(rng.integers(1, 3))):
        models.append(place(container(rng), (x - 2.5 - 2.9 * k, y - 4.2, 0), rng.normal(0, 0.03)))
    for k in range(2):
        spare = goal(rng, 5.0, 2.0, portable=True)
        models.append(place(spare, (x - 3.5, -y + 3.5 + 1.4 * k, 0), np.pi / 2))
    return Piece(
        models=models,
        patches=[
            Patch(area=area, surface=(str(rng.choice(["gravel", "concrete"])), "pavement"), rank=2)
        ],
        tufts=points_along(area.exterior, 0.4, rng),
        keep_clear=[area],
    )
