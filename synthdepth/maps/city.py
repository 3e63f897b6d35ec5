"""The map `city`: avenues between towers and low blocks, traffic, people, wires, parks, cranes."""

import dataclasses

import numpy as np

from synthdepth.config import Config, number, span
from synthdepth.maps.downtown.blocks import CityBlocks, build_blocks, plan_blocks
from synthdepth.maps.downtown.fittings import Fittings
from synthdepth.maps.downtown.furnishing import furnish_junctions, furnish_kerbs
from synthdepth.maps.downtown.grid import LAYOUTS, Grid, draw_grid
from synthdepth.maps.downtown.horizon import surroundings
from synthdepth.maps.downtown.kerbside import draw_kerbsides
from synthdepth.maps.downtown.markings import street_markings
from synthdepth.maps.downtown.overhead import bridged_edges, footbridges, hang_cables
from synthdepth.maps.downtown.surface import DISC_M, street_surface
from synthdepth.maps.downtown.traffic import draw_traffic, traffic_models
from synthdepth.maps.furniture.signs import LAMPS
from synthdepth.maps.geometry import Model
from synthdepth.maps.materials.catalogue import bake_materials
from synthdepth.maps.skyline import skyline
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
        street_tree_share: share of the streets that have trees.
        street_tree_spacing_m, lamp_spacing_m: along one side of a street.
        furniture_per_100m: benches, bins, meters and the like along 100 m of one side.
        people_per_100m: on 100 m of one pavement.
        cafe_tables_per_100m: on 100 m of a pavement that is wide enough.
        parked_share: of the bays along the kerb.
        cars_per_km: that drive on a kilometre of each lane.
        cable_share: of the streets with rows of wires, lights or banners across.
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
    street_tree_share: tuple[float, float] = span((0.4, 0.9), 0, 1)
    street_tree_spacing_m: tuple[float, float] = span((7.6, 12), 5, 100)
    lamp_spacing_m: tuple[float, float] = span((24, 34), 10, 200)
    furniture_per_100m: tuple[float, float] = span((5, 13), 0, 40)
    people_per_100m: tuple[float, float] = span((1.5, 7), 0, 80)
    cafe_tables_per_100m: tuple[float, float] = span((0.3, 2.5), 0, 20)
    parked_share: tuple[float, float] = span((0.25, 0.6), 0, 1)
    cars_per_km: tuple[float, float] = span((8, 28), 0, 140)
    cable_share: tuple[float, float] = span((0.3, 0.8), 0, 1)
    footbridges: int = number(2, 0, 10)
    flight_area_m: float = number(280.0, 150, 700)


@dataclasses.dataclass(frozen=True, kw_only=True)
class City:
    """The character of one city, drawn from `CityRanges`; see there.

    Attributes:
        layout: of the street grid, one of `LAYOUTS`.
        lamp: kind of the street lamps.
        drawn: what the ranges gave, by name.
        storeys: still a range, drawn for each building.
    """

    layout: str
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
    bridged = bridged_edges(grid, ranges.footbridges)
    models: list[Model] = [
        *_streets(scene_seed, town, grid, blocks, bridged, bounds),
        *build_blocks(lane(scene_seed, "buildings"), blocks, bounds),
        *footbridges(lane(scene_seed, "footbridges"), grid, bridged),
        surroundings(lane(scene_seed, "horizon")),
        skyline(
            lane(scene_seed, "skyline"),
            DISC_M + 5.0,
            2300.0,
            tallest_m=float(np.clip(2.8 * drawn["core_storeys"], 60, 170)),
            count=900,
        ),
    ]
    surfaces = assemble(models)
    return World(
        map="city",
        scene_seed=scene_seed,
        surfaces=surfaces,
        materials=bake_materials(lane(scene_seed, "materials"), {name for name, _ in surfaces}),
        light=light,
        flight_bounds=bounds,
        ground_m=_level_ground,
    )


def _streets(
    scene_seed: int,
    town: City,
    grid: Grid,
    blocks: CityBlocks,
    bridged: list[int],
    bounds: np.ndarray,
) -> list[Model]:
    """Ground, paint, furniture, people, vehicles and wires of the streets."""
    drawn, half = town.drawn, float(bounds[1, 0])
    kerbs = draw_kerbsides(
        lane(scene_seed, "kerbs"),
        grid,
        tree_spacing_m=drawn["street_tree_spacing_m"],
        tree_share=drawn["street_tree_share"],
        lamp_spacing_m=drawn["lamp_spacing_m"],
        parked_share=drawn["parked_share"],
        furniture_per_100m=drawn["furniture_per_100m"],
        bridged=bridged,
        half_m=half,
    )
    out = Fittings()
    furnish_kerbs(
        lane(scene_seed, "furnishing"),
        grid,
        kerbs,
        out,
        people_per_100m=drawn["people_per_100m"],
        lamp=town.lamp,
        cafes=drawn["cafe_tables_per_100m"],
        half_m=half,
    )
    crossing = 0.15 * drawn["people_per_100m"]
    furnish_junctions(lane(scene_seed, "junctions"), grid, out, people=crossing, half_m=half)
    hang_cables(
        lane(scene_seed, "cables"),
        grid,
        kerbs,
        list(blocks.lots),
        out,
        share=drawn["cable_share"],
        bridged=bridged,
        half_m=half,
    )
    traffic = draw_traffic(
        lane(scene_seed, "traffic"),
        grid,
        kerbs,
        cars_per_km=drawn["cars_per_km"],
        reach_m=half + 160,
    )
    return [
        street_surface(lane(scene_seed, "ground"), grid),
        street_markings(lane(scene_seed, "markings"), grid, kerbs, half),
        *traffic_models(lane(scene_seed, "vehicles"), traffic, bounds),
        *out.build(lane(scene_seed, "fittings"), bounds),
    ]


def _level_ground(xy: np.ndarray) -> np.ndarray:
    """The city is flat: 0 m at points (n, 2) [m], the level of the carriageways."""
    return np.zeros(len(xy))
