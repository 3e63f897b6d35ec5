"""The map `coastline`: beaches, dunes and cliffs by the sea, a road with homes, boats, woods."""

import dataclasses

import numpy as np

from synthdepth.config import Config, number, span
from synthdepth.maps.coast.boulders import rocks
from synthdepth.maps.coast.cover import FLORAS, drift_line, grasses, scrub, trees
from synthdepth.maps.coast.horizon import horizon
from synthdepth.maps.coast.land import Stone, draw_stone, land
from synthdepth.maps.coast.road import build_roadside
from synthdepth.maps.coast.roadside import plan_roadside
from synthdepth.maps.coast.sea import sea_surface
from synthdepth.maps.coast.shore import draw_shore
from synthdepth.maps.coast.terrain import build_ground, draw_road
from synthdepth.maps.coast.waterfront import build_waterfront, plan_waterfront
from synthdepth.maps.coast.waves import draw_sea
from synthdepth.maps.gardens.lots import build_items, build_lot
from synthdepth.maps.geometry import Model
from synthdepth.maps.houses.styles import STYLES
from synthdepth.maps.materials.catalogue import bake_materials
from synthdepth.maps.world import Light, World, assemble
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class CoastlineRanges(Config):
    """What a coast is drawn from; ranges are drawn once a scene.

    Attributes:
        sea_share: share of the flights' square that is sea.
        bay_m: amplitude of bays and headlands.
        beach_width_m: from the waterline to the foot of cliff or dune.
        beach_slope: of the beach at the waterline: 1:50 fine sand to 1:10 shingle.
        cliff_height_m: of the highest cliffs near the flights.
        cliff_share: share of the shore that has cliffs; dunes lie behind the rest.
        dune_height_m: of the dunes.
        wave_height_m: significant height offshore; it grows with the wind.
        rock_density: of boulders, skerries and stacks, 1 for an ordinary coast.
        tree_density: of woods and lone trees, 1 for an ordinary coast.
        road_behind_m: mean distance of the road behind cliffs and dunes.
        house_share: share of the places along the road that a home takes.
        lamp_spacing_m: between street lamps.
        boats: on the water; half as many lie ashore.
        people: on the beach.
        beach_items: parasols, loungers, huts, nets, driftwood.
        pier_share: share of the scenes with a pier.
        house_styles: how many families of houses.
        flight_area_m: side of the square in the middle that flights keep to.
    """

    sea_share: tuple[float, float] = span((0.14, 0.29), 0.05, 0.6)
    bay_m: tuple[float, float] = span((8, 42), 0, 80)
    beach_width_m: tuple[float, float] = span((18, 48), 8, 90)
    beach_slope: tuple[float, float] = span((0.025, 0.09), 0.02, 0.1)
    cliff_height_m: tuple[float, float] = span((6, 38), 0, 60)
    cliff_share: tuple[float, float] = span((0.0, 0.8), 0, 1)
    dune_height_m: tuple[float, float] = span((1.5, 6), 0, 12)
    wave_height_m: tuple[float, float] = span((0.25, 1.3), 0.1, 2.5)
    rock_density: tuple[float, float] = span((0.5, 1.4), 0, 3)
    tree_density: tuple[float, float] = span((0.6, 1.4), 0, 3)
    road_behind_m: tuple[float, float] = span((24, 95), 13, 150)
    house_share: tuple[float, float] = span((0.35, 0.85), 0, 1)
    lamp_spacing_m: tuple[float, float] = span((26, 40), 10, 500)
    boats: tuple[float, float] = span((9, 24), 0, 60)
    people: tuple[float, float] = span((15, 70), 0, 300)
    beach_items: tuple[float, float] = span((20, 90), 0, 300)
    pier_share: tuple[float, float] = span((0.6, 0.6), 0, 1)
    house_styles: tuple[float, float] = span((3, 6), 1, len(STYLES))
    flight_area_m: float = number(400.0, 150, 500)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Coastline:
    """The character of one coast, drawn from `CoastlineRanges`; see there.

    Attributes:
        stone: what sand and rock are made of.
        flora: a key of `FLORAS`.
        styles: families of houses.
        fence_kinds: what people fence their gardens with.
        fenced_share, front_fence_share, hedge_share, trees_per_lot, garden_items_per_lot: of the
            gardens.
        has_pier: whether there is a pier.
    """

    stone: Stone
    flora: str
    styles: tuple[str, ...]
    fence_kinds: tuple[str, ...]
    fenced_share: float
    front_fence_share: float
    hedge_share: float
    trees_per_lot: float
    garden_items_per_lot: float
    has_pier: bool
    sea_share: float
    bay_m: float
    beach_width_m: float
    beach_slope: float
    cliff_height_m: float
    cliff_share: float
    dune_height_m: float
    wave_height_m: float
    rock_density: float
    tree_density: float
    road_behind_m: float
    house_share: float
    lamp_spacing_m: float
    boats: float
    people: float
    beach_items: float
    flight_area_m: float


_DRAWN = (
    "sea_share",
    "bay_m",
    "beach_width_m",
    "beach_slope",
    "cliff_height_m",
    "cliff_share",
    "dune_height_m",
    "wave_height_m",
    "rock_density",
    "tree_density",
    "road_behind_m",
    "house_share",
    "lamp_spacing_m",
    "boats",
    "people",
    "beach_items",
)


def draw_coastline(rng: np.random.Generator, ranges: CoastlineRanges) -> Coastline:
    """The character of one coast."""
    drawn = {name: float(rng.uniform(*getattr(ranges, name))) for name in _DRAWN}
    low, high = ranges.house_styles
    count = int(rng.integers(int(np.ceil(low)), int(high) + 1))
    fences = rng.permutation(["board", "picket", "chain_link", "post_and_rail"])[:2]
    return Coastline(
        stone=draw_stone(rng),
        flora=str(rng.choice(list(FLORAS))),
        styles=tuple(str(name) for name in rng.permutation(sorted(STYLES))[:count]),
        fence_kinds=tuple(str(name) for name in fences),
        fenced_share=float(rng.uniform(0.5, 0.95)),
        front_fence_share=float(rng.uniform(0.2, 0.6)),
        hedge_share=float(rng.uniform(0.05, 0.3)),
        trees_per_lot=float(rng.uniform(0.8, 2.5)),
        garden_items_per_lot=float(rng.uniform(0.8, 2.5)),
        has_pier=bool(rng.random() < rng.uniform(*ranges.pier_share)),
        flight_area_m=ranges.flight_area_m,
        **drawn,
    )


def coastline(scene_seed: int, ranges: CoastlineRanges, light: Light) -> World:
    """Build the coast of a scene seed."""
    coast = draw_coastline(lane(scene_seed, "character"), ranges)
    half = coast.flight_area_m / 2
    bounds = np.array([[-half, -half], [half, half]])
    shore = draw_shore(
        lane(scene_seed, "shore"),
        flight_area_m=coast.flight_area_m,
        sea_share=coast.sea_share,
        bay_m=coast.bay_m,
        beach_width_m=coast.beach_width_m,
        cliff_height_m=coast.cliff_height_m,
        cliff_share=coast.cliff_share,
        dune_height_m=coast.dune_height_m,
        face_slope=coast.beach_slope,
        wave_height_m=coast.wave_height_m,
    )
    road = draw_road(lane(scene_seed, "road"), shore, coast.road_behind_m)
    roadside = plan_roadside(lane(scene_seed, "roadside"), shore, road, coast, bounds)
    front = plan_waterfront(lane(scene_seed, "waterfront"), shore, with_pier=coast.has_pier)
    ground = build_ground(shore, road, (*front.pads, *roadside.pads))
    sea = draw_sea(lane(scene_seed, "sea"), coast.wave_height_m)

    gravel = () if roadside.car_park is None else (roadside.car_park,)
    models: list[Model] = [
        land(ground, coast.stone, gravel),
        sea_surface(sea, ground, coast.stone),
        rocks(lane(scene_seed, "rocks"), ground, coast.stone, bounds, coast.rock_density),
        horizon(lane(scene_seed, "horizon"), shore, coast.stone),
        *build_roadside(lane(scene_seed, "furniture"), roadside, ground, bounds),
    ]
    for index, lot in enumerate(roadside.lots):
        models += build_lot(lane(scene_seed, "garden", index), lot, ground, bounds)
    models += build_items(lane(scene_seed, "items"), roadside.lots, ground, bounds)
    models += build_waterfront(
        lane(scene_seed, "beach"),
        front,
        ground,
        walkers=roadside.walkers,
        boat_count=round(coast.boats),
        people_count=round(coast.people),
        item_count=round(coast.beach_items),
    )
    garden = {
        name: np.concatenate([getattr(lot, name) for lot in roadside.lots] + [np.zeros((0, width))])
        for name, width in (("trees", 2), ("bushes", 3), ("tufts", 2))
    }
    taken = roadside.taken
    models += [
        trees(
            lane(scene_seed, "trees"),
            ground,
            coast.flora,
            bounds,
            taken,
            coast.tree_density,
            garden["trees"],
        ),
        scrub(lane(scene_seed, "scrub"), ground, bounds, taken, garden["bushes"]),
        *grasses(lane(scene_seed, "grass"), ground, bounds, taken, garden["tufts"]),
        drift_line(lane(scene_seed, "drift"), ground, bounds),
    ]
    surfaces = assemble(models)
    return World(
        map="coastline",
        scene_seed=scene_seed,
        surfaces=surfaces,
        materials=bake_materials(lane(scene_seed, "materials"), [name for name, _ in surfaces]),
        light=light,
        flight_bounds=bounds,
        ground_m=ground.surface_m,
    )
