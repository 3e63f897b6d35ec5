"""What fills the blocks between the streets: planning them, and building what was planned."""

import dataclasses

import numpy as np
import shapely

from synthdepth.maps.downtown.fill import GROUND_M, Fill
from synthdepth.maps.downtown.greens import fill_park
from synthdepth.maps.downtown.grid import Grid
from synthdepth.maps.downtown.parcels import (
    Lot,
    cut_across,
    cut_lots,
    draw_skyline,
)
from synthdepth.maps.downtown.plaza import fill_plaza
from synthdepth.maps.downtown.site import fill_site
from synthdepth.maps.downtown.yards import fill_car_park, fill_yards
from synthdepth.maps.geometry import Model, place
from synthdepth.maps.towers.tower import draw_tower, tower
from synthdepth.seeding import lane

REACH_M = 560.0
USES = ("buildings", "park", "plaza", "car_park", "site", "island")
FULL_DETAIL_M, SOME_DETAIL_M = 5.0, 70.0
_SLIVER_M2 = 120.0
_NEAR_M = 235.0  # blocks whose middle is this near to the map's lie in the flights' square
# Smallest and largest area of what is not built over [m2]; more than that is cut off and built.
_AREA_M2 = {
    "park": (900, 14000),
    "plaza": (500, 5200),
    "car_park": (500, 4200),
    "site": (700, 3600),
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Block:
    """Land between streets, or a part of it.

    Attributes:
        use: one of `USES`.
        area: its land.
        lots: of a block of buildings; empty for others.
    """

    use: str
    area: shapely.Polygon
    lots: tuple[Lot, ...] = ()


@dataclasses.dataclass(frozen=True, kw_only=True)
class CityBlocks:
    """All blocks within 560 m of the middle.

    Attributes:
        blocks: the blocks, from the middle outwards.
        street: land of the streets.
    """

    blocks: tuple[Block, ...]
    street: shapely.Geometry

    def of(self, use: str) -> tuple[Block, ...]:
        """The blocks of one use."""
        if use not in USES:
            raise KeyError(f"use {use!r} is not one of {sorted(USES)}")
        return tuple(b for b in self.blocks if b.use == use)

    @property
    def lots(self) -> tuple[Lot, ...]:
        """All lots."""
        return tuple(lot for block in self.blocks for lot in block.lots)


def plan_blocks(
    rng: np.random.Generator,
    grid: Grid,
    *,
    storeys_range: tuple[float, float],
    core_storeys: float,
    core_m: float,
    park_share: float,
    plaza_share: float,
    parking_share: float,
    construction: int,
) -> CityBlocks:
    """Decide what each block is used for, and cut those of buildings into lots.

    Args:
        rng: lane of the blocks.
        grid: the streets.
        storeys_range: lowest and highest building outside the lowest class (1 to 5 storeys).
        core_storeys: mean height at the cores [storeys].
        core_m: distance over which it falls to 1 / e.
        park_share, plaza_share, parking_share: shares of the blocks.
        construction: number of construction sites, in the flights' square where there is room.
    """
    skyline = draw_skyline(
        rng, storeys_range=storeys_range, core_storeys=core_storeys, core_m=core_m
    )
    street = grid.street_land
    disc = shapely.Point(0, 0).buffer(REACH_M, quad_segs=24)
    land = [p for p in shapely.get_parts(disc.difference(street)) if p.area > 4.0]
    away = np.array([np.hypot(p.centroid.x, p.centroid.y) for p in land])
    land = [shapely.simplify(land[k], 0.05) for k in np.argsort(away, kind="stable")]
    away = np.sort(away)
    use = ["island" if _sliver(p) else "buildings" for p in land]
    shares = {"park": park_share, "plaza": plaza_share, "car_park": parking_share}
    _assign(rng, "site", land, use, np.flatnonzero(away < 0.8 * _NEAR_M), construction)
    for name, share in shares.items():
        for zone in (away < _NEAR_M, away >= _NEAR_M):
            wanted = int(share * zone.sum() + rng.random())
            _assign(rng, name, land, use, np.flatnonzero(zone), wanted)
    blocks = []
    for area, name, distance in zip(land, use, away, strict=True):
        rest = []
        if name in _AREA_M2:
            area, rest = _part_of(rng, area, _AREA_M2[name][1])
            blocks.append(Block(use=name, area=area))
        elif name == "island":
            blocks.append(Block(use=name, area=area))
        else:
            rest = [area]
        for part in rest:
            lots = cut_lots(rng, part, street, skyline, coarse=bool(distance > _NEAR_M + 60))
            blocks.append(Block(use="buildings", area=part, lots=lots))
    return CityBlocks(blocks=tuple(blocks), street=street)


def _sliver(area: shapely.Polygon) -> bool:
    """Whether there is no room for more than paving."""
    return area.area < _SLIVER_M2 or area.buffer(-4.5).is_empty


def _assign(rng, name: str, land: list, use: list[str], zone: np.ndarray, count: int) -> None:
    """Give up to `count` of the blocks in a zone, no two of them neighbours if possible, a use."""
    free = [
        int(k)
        for k in rng.permutation(zone)
        if use[k] == "buildings" and land[k].area > _AREA_M2[name][0]
    ]
    # Not beside another open block: a stable sort by the number of open neighbours.
    taken = [land[k] for k in range(len(land)) if use[k] not in ("buildings", "island")]
    near = [sum(land[k].distance(t) < 30 for t in taken) for k in free]
    for k in np.argsort(near, kind="stable")[:count]:
        use[free[k]] = name


def _part_of(rng, area: shapely.Polygon, largest_m2: float):
    """An end of an area of at most about `largest_m2`, and the rest."""
    rest = []
    while area.area > largest_m2:
        share = float(rng.uniform(0.4, 0.6))
        parts = sorted(cut_across(area, share), key=lambda p: p.centroid.x + p.centroid.y)
        if len(parts) < 2:
            break
        rest += parts[1:]
        area = parts[0]
    return area, rest


def build_blocks(rng: np.random.Generator, plan: CityBlocks, bounds: np.ndarray) -> list[Model]:
    """Ground, buildings and all else between the streets.

    Args:
        rng: lane of what fills the blocks.
        plan: the blocks.
        bounds: (2, 2) of the square that flights keep to [m]; near it there is more detail.
    """
    fill = Fill(bounds)
    seeds = rng.integers(2**53, size=len(plan.blocks))
    for block, seed in zip(plan.blocks, seeds, strict=True):
        own = lane(int(seed), block.use)
        if block.use == "park":
            fill_park(own, fill, block.area)
        elif block.use == "plaza":
            fill_plaza(own, fill, block.area)
        elif block.use == "car_park":
            fill_car_park(own, fill, block.area)
        elif block.use == "site":
            fill_site(own, fill, block.area, int(own.integers(5, 17)))
        elif block.use == "island":
            fill.ground([(block.area, ("paving", "pavement"), own.uniform(0.8, 1.1))])
        else:
            fill_yards(own, fill, block.area, block.lots)
            fill.models += [_building(own, fill, lot) for lot in block.lots if lot.built]
    return fill.built(rng)


def _building(rng: np.random.Generator, fill: Fill, lot: Lot) -> Model:
    """The building of a lot, in detail that follows from its distance to the flights' square."""
    away = fill.distance_m(lot.footprint).min()
    detail = 2 if away < FULL_DETAIL_M else 1 if away < SOME_DETAIL_M else 0
    # Pavilions of one or two storeys are the lower part of a house of three.
    params = draw_tower(
        rng, lot.footprint, storeys=max(lot.storeys, 3), street_sides=lot.street_sides
    )
    if lot.storeys < 3:
        base = dataclasses.replace(
            params.tiers[0],
            polygon=lot.footprint,
            first=0,
            last=lot.storeys,
            street=lot.street_sides,
        )
        levels = params.levels_m[: lot.storeys + 1]
        params = dataclasses.replace(params, tiers=(base,), levels_m=levels)
    return place(tower(params, detail), (0.0, 0.0, GROUND_M))
