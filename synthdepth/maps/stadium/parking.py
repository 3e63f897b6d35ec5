"""Car parks: double rows of bays, drives, islands with trees, lamps, cars and coaches."""

import numpy as np
import shapely

from synthdepth.maps.geometry import box, copies, place
from synthdepth.maps.stadium.courts import rectangle
from synthdepth.maps.stadium.markings import paint
from synthdepth.maps.stadium.piece import Patch, Piece
from synthdepth.maps.vehicles.vehicle import draw_vehicle, vehicle

BAY_M = (2.5, 5.0)
AISLE_M = 6.0
_ROW_M = 2 * BAY_M[1]


def car_park(rng: np.random.Generator, size, share: float, coaches: int) -> Piece:
    """A car park on a rectangle of `size` (2,) [m], its aisles along x.

    Args:
        rng: of who stands where.
        size: of the land.
        share: of the bays that are taken.
        coaches: parked in a row of their own at the -x end.
    """
    length, depth = np.asarray(size, float) - 1.0
    loose = rng.random() < 0.2
    area = rectangle((length, depth))
    # Rows of bays: one single row at each edge, double rows between, aisles in between.
    y, rows = -depth / 2, []
    facing = 1
    while True:
        need = BAY_M[1] + AISLE_M
        if y + need > depth / 2 + 0.2:
            break
        rows.append((y, facing))
        y += BAY_M[1] + AISLE_M
        if y + BAY_M[1] > depth / 2 + 0.2:
            break
        rows.append((y, -facing))
        y += BAY_M[1]
        if y + 1.6 + BAY_M[1] + AISLE_M <= depth / 2:
            y += 1.6
    x0, x1 = -length / 2 + (22.0 if coaches else 2.0), length / 2 - 6.0
    n = max(int((x1 - x0) // BAY_M[0]), 0)
    lines, cars, islands, trees, lamps, models = [], [], [], [], [], []
    for y0, face in rows:
        xs = x0 + np.arange(n + 1) * BAY_M[0]
        every = int(rng.integers(8, 15))
        island = (np.arange(n) + int(rng.integers(every))) % every == 0
        lines += [shapely.LineString([(x, y0 + 0.1), (x, y0 + BAY_M[1] - 0.1)]) for x in xs]
        k = np.flatnonzero(~island & (rng.random(n) < share))
        middle = xs[k] + BAY_M[0] / 2
        heading = np.where(rng.random(len(k)) < 0.65, 1, -1) * np.pi / 2 * face
        cars.append(
            np.column_stack(
                [
                    middle + rng.normal(0, 0.1, len(k)),
                    y0 + BAY_M[1] / 2 + rng.normal(0, 0.18, len(k)),
                    heading + rng.normal(0, 0.02, len(k)),
                ]
            )
        )
        for i in np.flatnonzero(island):
            a = xs[i]
            islands.append(
                shapely.box(a + 0.25, y0 + 0.3, a + BAY_M[0] - 0.25, y0 + BAY_M[1] - 0.3)
            )
            trees.append([a + BAY_M[0] / 2, y0 + BAY_M[1] / 2])
        if face > 0:
            lamp_x = np.arange(x0 + 8, x1, 24.0)
            lamps.append(
                np.column_stack(
                    [lamp_x, np.full(len(lamp_x), y0 + 0.05), np.full(len(lamp_x), np.pi / 2)]
                )
            )
    kerbs = shapely.union_all(islands) if islands else shapely.Polygon()
    patches = [
        Patch(
            area=area, surface=("gravel" if loose else "asphalt", "road"), rank=2, cell_m=(6.0, 6.0)
        ),
    ]
    if islands:
        rim = kerbs.difference(kerbs.buffer(-0.15, join_style="mitre"))
        patches.append(Patch(area=rim, surface=("concrete", "pavement"), rank=4))
        patches.append(Patch(area=kerbs, surface=("grass", "ground"), rank=3))
    if lines and not loose:
        strokes = shapely.union_all(shapely.buffer(lines, 0.05, cap_style="flat")).difference(
            kerbs.buffer(0.05)
        )
        models.append(paint(strokes, "road_paint", (0.55, 0.55, 0.52), "road"))
    lanes_y = np.arange(-depth / 2 + 2.0, depth / 2 - 1.5, 4.2)
    if coaches:
        edges = [*(lanes_y - 2.1), lanes_y[-1] + 2.1]
        lines += [shapely.LineString([(-length / 2 + 1, y), (-length / 2 + 15, y)]) for y in edges]
    for y in rng.permutation(lanes_y)[:coaches]:
        at = (-length / 2 + rng.uniform(7.6, 8.6), y, 0)
        models.append(
            place(
                vehicle(draw_vehicle(rng, "bus")),
                at,
                rng.choice([0.0, np.pi]) + rng.normal(0, 0.02),
            )
        )
    stops = np.concatenate([c[:, :2] for c in cars]) if cars else np.zeros((0, 2))
    walkers = stops[rng.random(len(stops)) < 0.05] + [1.3, rng.uniform(-2, 2)]
    edge = np.column_stack([np.arange(-length / 2 + 2, length / 2 - 2, 3.0)] * 2)
    edge[:, 1] = -depth / 2 - 0.3
    bollard = box((0.14, 0.14, 0.75), (0, 0, -0.1), (0.3, 0.2, 0.11))
    models.append(
        {
            ("wood", "street_furniture"): copies(
                bollard, np.column_stack([edge, np.zeros(len(edge))])
            )
        }
    )
    return Piece(
        models=models,
        patches=patches,
        cars=np.concatenate([*cars, np.zeros((0, 3))]),
        trees=np.array(trees).reshape(-1, 2),
        lamps=np.concatenate([*lamps, np.zeros((0, 3))]),
        people=[("walking", "", np.column_stack([walkers, rng.uniform(0, 6, len(walkers))]))],
        keep_clear=[area],
    )
