"""Laying out the ground around a house: paving, fences, hedges, garden items, plants.

All of it in the house's frame (metres, +x to the street), in the plane.
"""

import dataclasses
import functools

import numpy as np
import shapely

from synthdepth.maps.gardens.items import GARDEN_ITEMS
from synthdepth.maps.houses.house import House
from synthdepth.maps.placement import pick, points_along, points_within
from synthdepth.maps.streets.lots import FRONT_GAP_M

_REAR_ITEMS = {
    "shed": 4,
    "trampoline": 2,
    "table": 4,
    "swing": 2,
    "greenhouse": 1,
    "paddling_pool": 1,
    "washing_line": 2,
    "goal": 1,
    "pool": 0.7,
}
# Fences and hedges at the street stand this far inside the lot.
_FRONT_EDGE_M = 0.7
_FAR_M = 200.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Site:
    """A house on its lot, in the house's frame.

    Attributes:
        house: the house.
        parcel: the lot's polygon.
        front_x: where the lot meets the street's land, on the house's axis [m].
        kerb_x: where the carriageway begins [m].
        path_half_m: half the width of the garden path.
    """

    house: House
    parcel: shapely.Polygon
    front_x: float
    kerb_x: float
    path_half_m: float

    @functools.cached_property
    def walls(self) -> shapely.Geometry:
        """What the house stands on."""
        return shapely.union_all(shapely.box(*np.array(self.house.footprint).T))

    @functools.cached_property
    def strips(self) -> list[shapely.Polygon]:
        """Paving: the drive reaches the carriageway, the path only the pavement."""
        x, y = self.house.entrance
        half, end = self.path_half_m, self.front_x + FRONT_GAP_M + 0.2
        strips = [shapely.box(x - 0.1, y - half, end, y + half)]
        garage = self.house.driveway
        if garage is not None:
            half = garage.width_m / 2 + 0.3
            strips.append(
                shapely.box(
                    garage.x_m - 0.3, garage.y_m - half, self.kerb_x + 0.4, garage.y_m + half
                )
            )
        return strips

    @functools.cached_property
    def paving(self) -> shapely.Geometry:
        """All paved ground."""
        return shapely.union_all(self.strips)

    @functools.cached_property
    def free(self) -> shapely.Geometry:
        """Ground for things and plants: off the walls, the paving and the lot's edge."""
        taken = shapely.union_all([self.walls.buffer(0.5), self.paving.buffer(0.3)])
        free = shapely.difference(self.parcel.buffer(-0.5), taken)
        shapely.prepare(free)
        return free


def garden_items(
    rng: np.random.Generator, site: Site, mean: float
) -> list[tuple[str, float, float, float]]:
    """Things in the garden that do not overlap: (name, x, y, heading)."""
    x0, y0, x1, y1 = site.house.bounds
    room = shapely.intersection(site.free, shapely.box(-_FAR_M, -_FAR_M, x0 - 0.6, _FAR_M))
    items = []
    for _ in range(int(rng.poisson(mean))):
        name = pick(rng, _REAR_ITEMS)
        radius = GARDEN_ITEMS[name].radius_m
        for x, y in points_within(rng, room.buffer(-radius), 1):
            heading = float(rng.choice([0.0, np.pi / 2, np.pi, -np.pi / 2]))
            items.append((name, float(x), float(y), heading))
            room = shapely.difference(room, shapely.Point(x, y).buffer(radius + 0.4))
    garage = site.house.driveway
    if garage is not None and rng.random() < 0.8:
        beside = garage.y_m + garage.width_m / 2 + 0.9
        items.append(("letter_box", site.front_x - 0.3, beside, 0.0))
    if rng.random() < 0.6:
        aside = shapely.intersection(site.free, shapely.box(x0, y0 - 1.6, x1, y1 + 1.6))
        items += [("bins", float(x), float(y), 0.0) for x, y in points_within(rng, aside, 1)]
    return items


def garden_trees(
    rng: np.random.Generator, site: Site, items: list[tuple[str, float, float, float]], mean: float
) -> np.ndarray:
    """Feet of trees (k, 2), clear of the house and of the garden's things."""
    taken = [shapely.Point(x, y).buffer(GARDEN_ITEMS[name].radius_m) for name, x, y, _ in items]
    room = shapely.difference(site.free, shapely.union_all([*taken, site.walls.buffer(3.0)]))
    return points_within(rng, room, int(rng.poisson(mean)), 4.0)


def garden_fence(rng: np.random.Generator, site: Site) -> list[np.ndarray]:
    """Fence lines (k, 2) along one side and half of the rear; the neighbours do the others."""
    x0, y0, x1, y1 = site.house.bounds
    ahead, middle = x0 + rng.uniform(0.3, 0.8) * (x1 - x0), (y0 + y1) / 2
    mine = shapely.union_all(
        [
            shapely.box(-_FAR_M, middle, ahead, _FAR_M),
            shapely.box(-_FAR_M, -_FAR_M, x0 - 3, middle),
        ]
    )
    line = shapely.intersection(site.parcel.buffer(-0.14).boundary, mine)
    merged = shapely.line_merge(line) if line.geom_type == "MultiLineString" else line
    return [shapely.get_coordinates(p) for p in shapely.get_parts(merged) if p.length > 2.5]


def front_lines(site: Site) -> list[np.ndarray]:
    """Where a fence or hedge can stand at the street: lines (2, 2), open at drive and path."""
    x = site.front_x - _FRONT_EDGE_M
    line = shapely.LineString([(x, -_FAR_M / 2), (x, _FAR_M / 2)])
    line = shapely.intersection(line, site.parcel.buffer(-0.3))
    line = shapely.difference(line, site.paving.buffer(0.35))
    return [shapely.get_coordinates(p) for p in shapely.get_parts(line) if p.length >= 1.5]


def garden_bushes(rng: np.random.Generator, site: Site) -> np.ndarray:
    """Bushes (k, 3), x, y and width: along the walls, a few in the front garden."""
    x1 = site.house.bounds[2]
    front = shapely.intersection(site.free, shapely.box(x1 - 1, -_FAR_M, _FAR_M, _FAR_M))
    along = points_along(site.walls.buffer(0.75).boundary, rng.uniform(4.0, 10.0), rng)
    points = np.concatenate([along, points_within(rng, front, int(rng.integers(0, 5)))])
    points = points[shapely.contains_xy(site.free, points[:, 0], points[:, 1])]
    return np.column_stack([points, rng.uniform(0.45, 1.3, len(points))])


def garden_tufts(rng: np.random.Generator, site: Site) -> np.ndarray:
    """Where the mower does not reach (k, 2): along the lot's edge and the walls."""
    edges = np.concatenate(
        [
            points_along(site.parcel.buffer(-0.25).boundary, 0.9, rng),
            points_along(site.walls.buffer(0.12).boundary, 0.8, rng),
        ]
    )
    return edges[~shapely.contains_xy(site.paving, edges[:, 0], edges[:, 1])]


def drive_cars(rng: np.random.Generator, site: Site) -> np.ndarray:
    """The car on the drive, if one is at home: (0 or 1, 3), x, y and heading."""
    garage = site.house.driveway
    if garage is None or site.front_x - garage.x_m < 5.6 or rng.random() > 0.55:
        return np.zeros((0, 3))
    y = garage.y_m + rng.uniform(-0.1, 0.1)
    if garage.width_m > 4:
        y += rng.choice([-1, 1]) * garage.width_m / 4
    return np.array([[garage.x_m + rng.uniform(3.0, 3.4), y, np.pi * rng.integers(2)]])
