"""What stands on a lot: house, drive, fences, hedges and garden, or a park."""

import dataclasses
from typing import Protocol

import numpy as np
import shapely
from shapely import affinity

from synthdepth.maps.fences import fence
from synthdepth.maps.garden import GARDEN_ITEMS, scatter
from synthdepth.maps.geometry import Model, place
from synthdepth.maps.houses import House, draw_house, house
from synthdepth.maps.placement import (
    distance_to,
    draped_line,
    on_ground,
    points_along,
    points_within,
)
from synthdepth.maps.shrubs import hedge
from synthdepth.maps.street_lots import FRONT_GAP_M, Lot
from synthdepth.maps.street_plan import KERB_WIDTH_M, PAVEMENT_WIDTH_M, StreetPlan
from synthdepth.maps.terrain import Terrain

# Beyond this distance from the square of flights, houses are coarse and gardens are bare.
_NEAR_M = 40.0
# Beyond this one, fences are single sheets.
_FENCE_DETAIL_M = 5.0
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
_PARK_ITEMS = {"bench": 6, "swing": 2, "goal": 1}


class Character(Protocol):
    """What a lot needs to know of its suburb."""

    styles: tuple[str, ...]
    fence_kinds: tuple[str, ...]
    trees_per_lot: float
    fenced_share: float
    front_fence_share: float
    hedge_share: float
    garden_items_per_lot: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class LotPlan:
    """Where everything of one lot stands, in the plane; [m] and [rad].

    Attributes:
        lot: the parcel.
        house: the house, or None.
        position: (2,) of the house's origin; of the lot's front where there is none.
        yaw_rad: of the house, whose +x points to the street.
        paved: polygons (k, 2) of drive and path.
        trees: (k, 2).
        bushes: (k, 3) x, y and width.
        tufts: (k, 2).
        items: garden items as (name, x, y, heading).
        fences: (polyline (k, 2), kind).
        hedges: (polyline (k, 2), height, width).
        cars: (k, 3) x, y and heading.
    """

    lot: Lot
    house: House | None
    position: np.ndarray
    yaw_rad: float
    paved: list[np.ndarray] = dataclasses.field(default_factory=list)
    trees: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 2)))
    bushes: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 3)))
    tufts: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 2)))
    items: list[tuple[str, float, float, float]] = dataclasses.field(default_factory=list)
    fences: list[tuple[np.ndarray, str]] = dataclasses.field(default_factory=list)
    hedges: list[tuple[np.ndarray, float, float]] = dataclasses.field(default_factory=list)
    cars: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 3)))

    def to_world(self, local) -> np.ndarray:
        """Points (..., 2) of the house's frame in the world."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return np.asarray(local, np.float64) @ np.array([[c, s], [-s, c]]) + self.position

    def eaves(self, terrain: Terrain) -> np.ndarray | None:
        """Where a drop wire reaches the house: a front corner of its main block, (3,)."""
        if self.house is None:
            return None
        block = self.house.blocks[0]
        _, y0, x1, y1 = block.rect
        xy = self.to_world([[x1 + 0.02, y0 + 0.1 * (y1 - y0)]])
        ground = terrain.height_m(self.position[None])[0]
        return np.array([*xy[0], ground + block.plate_m - 0.25])


def plan_lot(rng: np.random.Generator, lot: Lot, plan: StreetPlan, town: Character) -> LotPlan:
    """Lay out one lot."""
    if lot.kind == "house":
        laid_out = _with_house(rng, lot, plan, town)
        if laid_out is not None:
            return laid_out
    return _open_land(rng, lot, town)


def _open_land(rng: np.random.Generator, lot: Lot, town: Character) -> LotPlan:
    """A park or an empty lot: trees, bushes, long grass, benches."""
    area = shapely.buffer(shapely.Polygon(lot.polygon), -2.0)
    yaw = float(np.arctan2(-lot.inward[1], -lot.inward[0]))
    trees = points_within(rng, area, int(area.area / rng.uniform(90, 220)), 5.0)
    clumps = points_within(rng, area, int(area.area / 180))
    items = []
    if lot.kind == "park":
        free = shapely.difference(area, shapely.MultiPoint(trees).buffer(3.5))
        for xy in points_within(rng, free, int(area.area / 260), 6.0):
            items.append((_pick(rng, _PARK_ITEMS), *map(float, xy), float(rng.uniform(0, 6.28))))
    return LotPlan(
        lot=lot,
        house=None,
        position=lot.front,
        yaw_rad=yaw,
        trees=trees,
        bushes=np.column_stack([clumps, rng.uniform(0.6, 2.0, len(clumps))]),
        tufts=points_within(rng, area, min(int(area.area / 2.5), 600)),
        items=items,
    )


def _with_house(
    rng: np.random.Generator, lot: Lot, plan: StreetPlan, town: Character
) -> LotPlan | None:
    """A lot with a house; None where no house was found that fits."""
    parcel = shapely.Polygon(lot.polygon)
    yaw = float(np.arctan2(-lot.inward[1], -lot.inward[0]) + np.radians(rng.normal(0, 1.2)))
    side = np.array([-lot.inward[1], lot.inward[0]])
    for shrink in (1.0, 0.9, 0.8):
        style = town.styles[rng.integers(len(town.styles))]
        built = draw_house(rng, style, shrink * lot.width_m, shrink * lot.depth_m)
        x0, y0, x1, y1 = built.bounds
        setback = rng.uniform(5.5, 9.0)
        spare = max(lot.width_m - (y1 - y0) - 2.4, 0) / 2
        # The street is ahead: the house's +y is on the left, which is -side.
        aside = (y0 + y1) / 2 + rng.uniform(-spare, spare)
        position = lot.front + lot.inward * (setback + x1) + side * aside
        draft = LotPlan(lot=lot, house=built, position=position, yaw_rad=yaw)
        body = shapely.Polygon(draft.to_world([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))
        if parcel.buffer(0.3).contains(body):
            return _garden(rng, draft, parcel, plan, town, setback + x1)
    return None


def _pick(rng: np.random.Generator, weights: dict[str, float]) -> str:
    share = np.array(list(weights.values()), float)
    return str(rng.choice(list(weights), p=share / share.sum()))


def _garden(
    rng: np.random.Generator,
    draft: LotPlan,
    parcel: shapely.Polygon,
    plan: StreetPlan,
    town: Character,
    front_x: float,
) -> LotPlan:
    """Everything around a house; `front_x` is the lot's front in the house's frame."""
    built = draft.house
    x0, y0, x1, y1 = built.bounds
    rects = np.array(built.footprint)
    walls = shapely.union_all(shapely.box(*rects.T))
    garage, entrance = built.driveway, built.entrance

    # Paving. A drive reaches the carriageway, a path only the pavement.
    street = front_x + FRONT_GAP_M + PAVEMENT_WIDTH_M + plan.verge_m + KERB_WIDTH_M
    strips, openings = [], []
    if garage is not None:
        half = garage.width_m / 2 + 0.3
        strips.append(
            shapely.box(garage.x_m - 0.3, garage.y_m - half, street + 0.4, garage.y_m + half)
        )
        openings.append((garage.y_m - half - 0.4, garage.y_m + half + 0.4))
    path = rng.uniform(0.45, 0.7)
    strips.append(
        shapely.box(
            entrance[0] - 0.1, entrance[1] - path, front_x + FRONT_GAP_M + 0.2, entrance[1] + path
        )
    )
    openings.append((entrance[1] - path - 0.3, entrance[1] + path + 0.3))
    paving = shapely.union_all(strips)

    # Everything below is planned in the house's frame.
    local = affinity.rotate(
        affinity.translate(parcel, *(-draft.position)), -draft.yaw_rad, (0, 0), use_radians=True
    )
    taken = shapely.union_all([walls.buffer(0.5), paving.buffer(0.3)])
    free = shapely.difference(local.buffer(-0.5), taken)
    shapely.prepare(free)
    rear = shapely.intersection(free, shapely.box(-200, -200, x0 - 0.6, 200))
    front = shapely.intersection(free, shapely.box(x1 - 1, -200, 200, 200))

    items = _items(rng, rear, town.garden_items_per_lot)
    if garage is not None and rng.random() < 0.8:
        items.append(("letter_box", front_x - 0.3, garage.y_m + garage.width_m / 2 + 0.9, 0.0))
    if rng.random() < 0.6:
        bins = points_within(
            rng, shapely.intersection(free, shapely.box(x0, y0 - 1.6, x1, y1 + 1.6)), 1
        )
        items += [("bins", *map(float, xy), 0.0) for xy in bins]
    occupied = [shapely.Point(x, y).buffer(GARDEN_ITEMS[name].radius_m) for name, x, y, _ in items]
    room = shapely.difference(free, shapely.union_all([*occupied, walls.buffer(3.0)]))
    trees = points_within(rng, room, int(rng.poisson(town.trees_per_lot)), 4.0)

    fences, hedges = [], []
    if rng.random() < town.fenced_share:
        kind = town.fence_kinds[rng.integers(len(town.fence_kinds))]
        # This side and half of the rear; the neighbours do the others.
        ahead = x0 + rng.uniform(0.3, 0.8) * (x1 - x0)
        middle = (y0 + y1) / 2
        mine = shapely.union_all(
            [shapely.box(-200, middle, ahead, 200), shapely.box(-200, -200, x0 - 3, middle)]
        )
        line = shapely.intersection(local.buffer(-0.14).boundary, mine)
        fences += [(shapely.get_coordinates(part), kind) for part in _lines(line)]
    chance = rng.random()
    if chance < town.front_fence_share + town.hedge_share:
        for a, b in _gaps(local, front_x - 0.7, openings):
            edge = np.array([[front_x - 0.7, a], [front_x - 0.7, b]])
            if chance < town.front_fence_share:
                fences.append((edge, "picket" if rng.random() < 0.6 else "wall"))
            else:
                hedges.append((edge, rng.uniform(0.7, 1.5), rng.uniform(0.5, 0.8)))

    along_walls = points_along(walls.buffer(0.75).boundary, rng.uniform(2.5, 7.0), rng)
    borders = np.concatenate([along_walls, points_within(rng, front, int(rng.integers(0, 5)))])
    bushes = borders[shapely.contains_xy(free, borders[:, 0], borders[:, 1])]
    edges = points_along(local.buffer(-0.25).boundary, 0.7, rng)
    edges = np.concatenate([edges, points_along(walls.buffer(0.12).boundary, 0.6, rng)])
    clear = ~shapely.contains_xy(paving, edges[:, 0], edges[:, 1])

    cars = []
    if garage is not None and front_x - garage.x_m > 5.6 and rng.random() < 0.55:
        lane = garage.y_m + rng.uniform(-0.1, 0.1)
        if garage.width_m > 4:
            lane += rng.choice([-1, 1]) * garage.width_m / 4
        cars.append((garage.x_m + rng.uniform(3.0, 3.4), lane, np.pi * rng.integers(2)))

    def world(points):
        points = np.asarray(points, np.float64)
        return draft.to_world(points) if len(points) else points.reshape(0, 2)

    yaw = draft.yaw_rad
    return dataclasses.replace(
        draft,
        paved=[world(shapely.get_coordinates(strip.exterior)[:-1]) for strip in strips],
        trees=world(trees),
        bushes=np.column_stack([world(bushes), rng.uniform(0.45, 1.3, len(bushes))]),
        tufts=world(edges[clear]),
        items=[(name, *map(float, world([(x, y)])[0]), yaw + a) for name, x, y, a in items],
        fences=[(world(line), kind) for line, kind in fences],
        hedges=[(world(line), float(h), float(w)) for line, h, w in hedges],
        cars=np.array([(*world([(x, y)])[0], yaw + a) for x, y, a in cars]).reshape(-1, 3),
    )


def _items(
    rng: np.random.Generator, rear: shapely.Geometry, mean: float
) -> list[tuple[str, float, float, float]]:
    """Garden items behind the house that do not overlap, in the house's frame."""
    items = []
    for _ in range(int(rng.poisson(mean))):
        name = _pick(rng, _REAR_ITEMS)
        radius = GARDEN_ITEMS[name].radius_m
        for x, y in points_within(rng, rear.buffer(-radius), 1):
            heading = float(rng.choice([0.0, np.pi / 2, np.pi, -np.pi / 2]))
            items.append((name, float(x), float(y), heading))
            rear = shapely.difference(rear, shapely.Point(x, y).buffer(radius + 0.4))
    return items


def _lines(geometry: shapely.Geometry) -> list[shapely.LineString]:
    """The pieces of a cut line, those long enough to be worth a fence."""
    if geometry.is_empty:
        return []
    merged = shapely.line_merge(geometry) if geometry.geom_type != "LineString" else geometry
    return [part for part in shapely.get_parts(merged) if part.length > 2.5]


def _gaps(
    parcel: shapely.Polygon, x: float, openings: list[tuple[float, float]]
) -> list[tuple[float, float]]:
    """The stretches of the line at `x` within a parcel, less the openings, 1.5 m or longer."""
    line = shapely.intersection(shapely.LineString([(x, -100), (x, 100)]), parcel.buffer(-0.3))
    cuts = shapely.union_all([shapely.box(x - 1, a, x + 1, b) for a, b in openings])
    rest = shapely.difference(line, cuts)
    stretches = []
    for part in shapely.get_parts(rest):
        if part.length >= 1.5:
            y = shapely.get_coordinates(part)[:, 1]
            stretches.append((float(y.min()), float(y.max())))
    return stretches


def build_lot(
    rng: np.random.Generator,
    planned: LotPlan,
    terrain: Terrain,
    bounds: np.ndarray,
) -> list[Model]:
    """House, fences and hedges of a lot; what stands on many lots is built for all of them."""
    away = float(distance_to(bounds, planned.position[None])[0])
    models: list[Model] = []
    if planned.house is not None:
        at = on_ground(terrain, planned.position[None])[0]
        built = house(planned.house, detail=1 if away <= _NEAR_M else 0)
        models.append(place(built, at, planned.yaw_rad))
    if away > _NEAR_M:
        return models
    detail = 1 if away <= _FENCE_DETAIL_M else 0
    models += [
        fence(rng, draped_line(terrain, line), kind, detail=detail) for line, kind in planned.fences
    ]
    models += [
        hedge(rng, draped_line(terrain, line), height, width, away)
        for line, height, width in planned.hedges
    ]
    return models


def build_items(
    rng: np.random.Generator, lots: list[LotPlan], terrain: Terrain, bounds: np.ndarray
) -> list[Model]:
    """The garden items of all lots near the flights, a few variants of each kind."""
    items = [item for lot in lots for item in lot.items]
    models = []
    for name, lane in zip(GARDEN_ITEMS, rng.spawn(len(GARDEN_ITEMS)), strict=True):
        at = np.array([item[1:] for item in items if item[0] == name]).reshape(-1, 3)
        at = at[distance_to(bounds, at) <= _NEAR_M]
        if len(at):
            models.append(scatter(lane, name, on_ground(terrain, at[:, :2]), at[:, 2], variants=6))
    return models
