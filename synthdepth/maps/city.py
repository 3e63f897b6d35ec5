"""The map `city`: avenues between towers and low blocks, traffic, people, wires, parks, cranes."""

import dataclasses

import numpy as np

from synthdepth.config import Config, number, span
from synthdepth.maps.downtown.blocks import build_blocks, plan_blocks
from synthdepth.maps.downtown.grid import LAYOUTS, draw_grid
from synthdepth.maps.downtown.ground import EDGE_M, street_ground
from synthdepth.maps.downtown.kerbside import build_kerbside, draw_kerbside
from synthdepth.maps.downtown.overhead import overhead
from synthdepth.maps.downtown.paint import street_markings
from synthdepth.maps.downtown.traffic import build_traffic, draw_traffic
from synthdepth.maps.furniture.signs import LAMPS
from synthdepth.maps.geometry import Model
from synthdepth.maps.materials.catalogue import bake_materials
from synthdepth.maps.skyline import skyline
from synthdepth.maps.terrain import Terrain, draw_terrain, outskirts
from synthdepth.maps.world import Light, World, assemble
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class CityRanges(Config):
    """What a city is drawn from; ranges are drawn once a scene.

    Attributes:
        block_length_m, block_depth_m: mean sides of the blocks between the streets.
        avenue_share: share of the streets that are avenues.
        dropped_share: share of the streets' segments that are left out, which joins blocks.
        storeys: of the buildings outside the core; each is drawn anew.
        core_storeys: of the tallest towers.
        core_radius_m: how far the core of towers reaches.
        park_share, plaza_share, parking_share: of the blocks.
        construction_sites: blocks with a tower crane.
        street_tree_spacing_m, lamp_spacing_m: along one side of a street.
        furniture_per_100m: benches, bins, meters and the like along 100 m of one side.
        people_per_100m: on 100 m of one pavement.
        parked_share: of the bays along the kerb.
        cars_per_km: that drive on a kilometre of each lane.
        cable_share: of the streets with wires across.
        footbridges: over avenues.
        flight_area_m: side of the square in the middle that flights keep to.
    """

    block_length_m: tuple[float, float] = span((95, 190), 60, 300)
    block_depth_m: tuple[float, float] = span((60, 85), 45, 150)
    avenue_share: tuple[float, float] = span((0.2, 0.4), 0, 1)
    dropped_share: tuple[float, float] = span((0.05, 0.15), 0, 0.4)
    storeys: tuple[float, float] = span((3, 9), 1, 30)
    core_storeys: tuple[float, float] = span((14, 60), 1, 80)
    core_radius_m: tuple[float, float] = span((90, 260), 30, 600)
    park_share: tuple[float, float] = span((0.04, 0.12), 0, 1)
    plaza_share: tuple[float, float] = span((0.03, 0.1), 0, 1)
    parking_share: tuple[float, float] = span((0.02, 0.08), 0, 1)
    construction_sites: int = number(1, 0, 6)
    street_tree_spacing_m: tuple[float, float] = span((8, 13), 5, 100)
    lamp_spacing_m: tuple[float, float] = span((24, 34), 10, 200)
    furniture_per_100m: tuple[float, float] = span((5, 13), 0, 40)
    people_per_100m: tuple[float, float] = span((2, 10), 0, 80)
    parked_share: tuple[float, float] = span((0.45, 0.9), 0, 1)
    cars_per_km: tuple[float, float] = span((12, 40), 0, 140)
    cable_share: tuple[float, float] = span((0.3, 0.8), 0, 1)
    footbridges: int = number(2, 0, 10)
    flight_area_m: float = number(400.0, 150, 700)


_STREET_TREES = ("maple", "oak", "birch", "young", "poplar", "palm")


@dataclasses.dataclass(frozen=True, kw_only=True)
class City:
    """The character of one city, drawn from `CityRanges`; see there.

    Attributes:
        layout: of the street grid, one of `LAYOUTS`.
        street_tree: species along the streets.
        lamp: kind of the street lamps.
        drawn: what the ranges gave, by name.
        storeys: still a range, drawn for each building.
    """

    layout: str
    street_tree: str
    lamp: str
    drawn: dict[str, float]
    storeys: tuple[float, float]


def draw_city(rng: np.random.Generator, ranges: CityRanges) -> City:
    """The character of one city."""
    names = [
        field.name
        for field in dataclasses.fields(ranges)
        if "span" in field.metadata and field.name != "storeys"
    ]
    return City(
        layout=LAYOUTS[rng.integers(len(LAYOUTS))],
        street_tree=_STREET_TREES[rng.integers(len(_STREET_TREES))],
        lamp=sorted(LAMPS)[rng.integers(len(LAMPS))],
        drawn={name: float(rng.uniform(*getattr(ranges, name))) for name in names},
        storeys=ranges.storeys,
    )


def city(scene_seed: int, ranges: CityRanges, light: Light) -> World:
    """Build the city of a scene seed."""
    town = draw_city(lane(scene_seed, "character"), ranges)
    drawn = town.drawn
    half = ranges.flight_area_m / 2
    bounds = np.array([[-half, -half], [half, half]])
    grid = draw_grid(
        lane(scene_seed, "streets"),
        block_length_m=drawn["block_length_m"],
        block_depth_m=drawn["block_depth_m"],
        avenue_share=drawn["avenue_share"],
        drop_share=drawn["dropped_share"],
        layout=town.layout,
    )
    blocks = plan_blocks(
        lane(scene_seed, "blocks"),
        grid,
        storeys_range=town.storeys,
        core_storeys=drawn["core_storeys"],
        core_m=drawn["core_radius_m"],
        park_share=drawn["park_share"],
        plaza_share=drawn["plaza_share"],
        parking_share=drawn["parking_share"],
        construction=ranges.construction_sites,
    )
    kerbside = draw_kerbside(
        lane(scene_seed, "kerbside"),
        grid,
        lamp_spacing_m=drawn["lamp_spacing_m"],
        tree_spacing_m=drawn["street_tree_spacing_m"],
        furniture_per_100m=drawn["furniture_per_100m"],
        people_per_100m=drawn["people_per_100m"],
    )
    traffic = draw_traffic(
        lane(scene_seed, "traffic"),
        grid,
        parked_share=drawn["parked_share"],
        cars_per_km=drawn["cars_per_km"],
    )
    models: list[Model] = [
        street_ground(grid),
        street_markings(lane(scene_seed, "markings"), grid),
        *build_blocks(lane(scene_seed, "buildings"), blocks, bounds),
        *build_kerbside(
            lane(scene_seed, "furniture"), kerbside, town.street_tree, town.lamp, bounds
        ),
        *build_traffic(lane(scene_seed, "vehicles"), traffic, bounds),
        *overhead(
            lane(scene_seed, "overhead"),
            grid,
            cable_share=drawn["cable_share"],
            bridges=ranges.footbridges,
        ),
        *_surroundings(scene_seed, drawn["core_storeys"]),
    ]
    surfaces = assemble(models)
    return World(
        map="city",
        scene_seed=scene_seed,
        surfaces=surfaces,
        materials=bake_materials(lane(scene_seed, "materials"), {name for name, _ in surfaces}),
        light=light,
        flight_bounds=bounds,
        ground_m=lambda xy: np.zeros(len(xy)),
    )


def _surroundings(scene_seed: int, core_storeys: float) -> list[Model]:
    """The town goes on as a skyline, and the land beyond it as hills."""
    land: Terrain = draw_terrain(lane(scene_seed, "terrain"), size_m=2 * EDGE_M)
    flat = dataclasses.replace(land, amplitude_m=np.zeros_like(land.amplitude_m), offset_m=0.0)
    return [
        skyline(
            lane(scene_seed, "skyline"),
            EDGE_M + 20.0,
            1500.0,
            tallest_m=min(2.6 * core_storeys, 150.0),
            count=700,
        ),
        outskirts(flat, edge_step_m=20.0),
    ]
