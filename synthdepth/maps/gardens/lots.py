"""What stands on a lot: house, drive, fences, hedges and garden, or a park."""

import dataclasses
from typing import Protocol

import numpy as np
import shapely
from shapely import affinity

from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.gardens.items import GARDEN_ITEMS, scatter
from synthdepth.maps.gardens.plan import (
    Site,
    drive_cars,
    front_lines,
    garden_bushes,
    garden_fence,
    garden_items,
    garden_trees,
    garden_tufts,
)
from synthdepth.maps.geometry import Model, place
from synthdepth.maps.houses.house import House, draw_house, house
from synthdepth.maps.placement import (
    distance_to,
    draped_line,
    on_ground,
    pick,
    points_within,
)
from synthdepth.maps.streets.lots import FRONT_GAP_M, Lot
from synthdepth.maps.streets.plan import KERB_WIDTH_M, PAVEMENT_WIDTH_M, StreetPlan
from synthdepth.maps.terrain import Terrain
from synthdepth.maps.vegetation.shrubs import hedge

# Beyond this distance from the square of flights, houses are coarse and gardens are bare.
_NEAR_M = 40.0
# Beyond this one, fences are single sheets.
_FENCE_DETAIL_M = 5.0
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

    def to_world_turned(self, local: np.ndarray) -> np.ndarray:
        """Places (k, 3), x, y and heading, of the house's frame in the world."""
        return np.column_stack([self.to_world(local[:, :2]), local[:, 2] + self.yaw_rad])

    def eaves(self, terrain: Terrain) -> np.ndarray | None:
        """Where a drop wire reaches the house: a front corner of its main block, (3,)."""
        if self.house is None:
            return None
        block = self.house.blocks[0]
        _, y0, x1, y1 = block.rect
        xy = self.to_world([[x1 + 0.02, y0 + 0.1 * (y1 - y0)]])
        ground = terrain.height_m(self.position[None])[0]
        return np.array([*xy[0], ground + block.plate_m - 0.25])


def plan_lot(
    rng: np.random.Generator, lot: Lot, plan: StreetPlan, town: Character, bounds: np.ndarray
) -> LotPlan:
    """Lay out one lot; far from the flights with house, drive and trees only."""
    if lot.kind == "house":
        near = distance_to(bounds, lot.front[None])[0] <= _NEAR_M
        laid_out = _with_house(rng, lot, plan, town, near)
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
            items.append((pick(rng, _PARK_ITEMS), *map(float, xy), float(rng.uniform(0, 6.28))))
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
    rng: np.random.Generator, lot: Lot, plan: StreetPlan, town: Character, near: bool
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
            local = affinity.translate(parcel, *(-position))
            front_x = setback + x1
            site = Site(
                house=built,
                parcel=affinity.rotate(local, -yaw, (0, 0), use_radians=True),
                front_x=front_x,
                kerb_x=front_x + FRONT_GAP_M + PAVEMENT_WIDTH_M + plan.verge_m + KERB_WIDTH_M,
                path_half_m=rng.uniform(0.45, 0.7),
            )
            return _garden(rng, draft, site, town, near)
    return None


def _garden(
    rng: np.random.Generator, draft: LotPlan, site: Site, town: Character, near: bool
) -> LotPlan:
    """The lot with everything around its house; far from the flights, paving and trees."""
    items = garden_items(rng, site, town.garden_items_per_lot) if near else []
    trees = garden_trees(rng, site, items, town.trees_per_lot)
    planned = dataclasses.replace(
        draft,
        paved=[draft.to_world(shapely.get_coordinates(s.exterior)[:-1]) for s in site.strips],
        trees=draft.to_world(trees),
        cars=draft.to_world_turned(drive_cars(rng, site)),
    )
    if not near:
        return planned
    fences, hedges = [], []
    if rng.random() < town.fenced_share:
        kind = town.fence_kinds[rng.integers(len(town.fence_kinds))]
        fences += [(draft.to_world(line), kind) for line in garden_fence(rng, site)]
    chance = rng.random()
    if chance < town.front_fence_share:
        kind = "picket" if rng.random() < 0.6 else "wall"
        fences += [(draft.to_world(line), kind) for line in front_lines(site)]
    elif chance < town.front_fence_share + town.hedge_share:
        height, width = rng.uniform(0.7, 1.5), rng.uniform(0.5, 0.8)
        hedges += [(draft.to_world(line), height, width) for line in front_lines(site)]
    bushes = garden_bushes(rng, site)
    turned = draft.to_world_turned(np.array([item[1:] for item in items]).reshape(-1, 3))
    return dataclasses.replace(
        planned,
        bushes=np.column_stack([draft.to_world(bushes[:, :2]), bushes[:, 2]]),
        tufts=draft.to_world(garden_tufts(rng, site)),
        items=[(item[0], *map(float, at)) for item, at in zip(items, turned, strict=True)],
        fences=fences,
        hedges=hedges,
    )


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
