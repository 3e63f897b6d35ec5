"""The map `neighborhood`: a suburb with winding streets, houses, gardens, trees and wires."""

import dataclasses

import numpy as np

from synthdepth.config import Config, number, span
from synthdepth.maps.gardens.lots import LotPlan, build_items, build_lot, plan_lot
from synthdepth.maps.geometry import Model
from synthdepth.maps.houses.styles import STYLES
from synthdepth.maps.materials.catalogue import bake_materials
from synthdepth.maps.placement import distance_to, on_ground
from synthdepth.maps.streets.markings import draw_street_markings, street_markings
from synthdepth.maps.streets.plan import StreetPlan, draw_street_plan
from synthdepth.maps.streets.streetscape import Streetscape, furnish_streets
from synthdepth.maps.streets.surface import street_surface
from synthdepth.maps.terrain import Terrain, draw_terrain, outskirts, tree_line
from synthdepth.maps.vegetation.shrubs import bushes, grass_tufts
from synthdepth.maps.vegetation.trees import plant
from synthdepth.maps.world import Light, World, assemble
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class NeighborhoodRanges(Config):
    """What a suburb is drawn from; ranges are drawn once a scene.

    Attributes:
        lot_frontage_m: width of the lots along the street, drawn per lot.
        lot_depth_m: depth of the lots.
        house_styles: how many families of houses stand side by side.
        trees_per_lot: mean number of garden trees.
        street_tree_spacing_m: between trees in the planting strip.
        fenced_share: share of the lots with fences at the sides and behind.
        front_fence_share: share of the lots with a fence at the street.
        hedge_share: share of the lots with a hedge at the street.
        garden_items_per_lot: mean number of sheds, trampolines, tables and the like.
        parked_share: share of the places along the kerb that a car takes.
        utility_line_share: share of the streets with poles and wires.
        lamp_spacing_m: between street lamps.
        flight_area_m: side of the square in the middle that flights keep to.
    """

    lot_frontage_m: tuple[float, float] = span((17, 27), 14, 60)
    lot_depth_m: tuple[float, float] = span((30, 37), 24, 60)
    house_styles: tuple[float, float] = span((4, 7), 1, len(STYLES))
    trees_per_lot: tuple[float, float] = span((1, 3.5), 0, 8)
    street_tree_spacing_m: tuple[float, float] = span((9, 22), 5, 500)
    fenced_share: tuple[float, float] = span((0.35, 0.8), 0, 1)
    front_fence_share: tuple[float, float] = span((0.05, 0.4), 0, 1)
    hedge_share: tuple[float, float] = span((0.1, 0.4), 0, 1)
    garden_items_per_lot: tuple[float, float] = span((0.8, 2.5), 0, 8)
    parked_share: tuple[float, float] = span((0.03, 0.15), 0, 1)
    utility_line_share: tuple[float, float] = span((0.5, 1), 0, 1)
    lamp_spacing_m: tuple[float, float] = span((28, 42), 10, 500)
    flight_area_m: float = number(400.0, 150, 900)


# Which trees a scene grows: one mix is drawn, so that suburbs differ in what grows there.
_TREE_MIXES = (
    {"oak": 4, "maple": 4, "birch": 2, "fruit": 3, "young": 2, "spruce": 1},
    {"maple": 3, "poplar": 1, "willow": 1, "fruit": 3, "birch": 3, "bare": 1, "oak": 2},
    {"pine": 4, "spruce": 3, "birch": 3, "maple": 2, "young": 2},
    {"palm": 4, "cypress": 3, "oak": 2, "fruit": 3, "pine": 2},
    {"oak": 3, "willow": 1, "cypress": 1, "maple": 2, "pine": 2, "fruit": 2, "bare": 1},
)
_FENCES = ("board", "picket", "chain_link", "post_and_rail")
_STREET_TREES = ("maple", "oak", "birch", "young", "palm", "poplar")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Neighborhood:
    """The character of one suburb, drawn from `NeighborhoodRanges`.

    Attributes:
        styles: families of houses that stand here.
        tree_mix: weight of each species in the gardens.
        street_tree: species along the streets.
        fence_kinds: what people fence their gardens with.
        trees_per_lot, street_tree_spacing_m, fenced_share, front_fence_share, hedge_share,
        garden_items_per_lot, parked_share, utility_line_share, lamp_spacing_m: see the ranges.
        lot_frontage_m, lot_depth_m: ranges still, drawn per lot and block.
        flight_area_m: see the ranges.
    """

    styles: tuple[str, ...]
    tree_mix: dict[str, float]
    street_tree: str
    fence_kinds: tuple[str, ...]
    trees_per_lot: float
    street_tree_spacing_m: float
    fenced_share: float
    front_fence_share: float
    hedge_share: float
    garden_items_per_lot: float
    parked_share: float
    utility_line_share: float
    lamp_spacing_m: float
    lot_frontage_m: tuple[float, float]
    lot_depth_m: tuple[float, float]
    flight_area_m: float


def draw_neighborhood(rng: np.random.Generator, ranges: NeighborhoodRanges) -> Neighborhood:
    """The character of one suburb."""
    low, high = ranges.house_styles
    count = int(rng.integers(int(np.ceil(low)), int(high) + 1))
    mix = _TREE_MIXES[rng.integers(len(_TREE_MIXES))]
    street = [species for species in _STREET_TREES if species in mix]
    drawn = {
        name: float(rng.uniform(*getattr(ranges, name)))
        for name in (
            "trees_per_lot",
            "street_tree_spacing_m",
            "fenced_share",
            "front_fence_share",
            "hedge_share",
            "garden_items_per_lot",
            "parked_share",
            "utility_line_share",
            "lamp_spacing_m",
        )
    }
    return Neighborhood(
        styles=tuple(str(name) for name in rng.permutation(sorted(STYLES))[:count]),
        tree_mix=mix,
        street_tree=street[rng.integers(len(street))],
        fence_kinds=tuple(str(name) for name in rng.permutation(_FENCES)[:2]),
        lot_frontage_m=ranges.lot_frontage_m,
        lot_depth_m=ranges.lot_depth_m,
        flight_area_m=ranges.flight_area_m,
        **drawn,
    )


def neighborhood(scene_seed: int, ranges: NeighborhoodRanges, light: Light) -> World:
    """Build the suburb of a scene seed."""
    town = draw_neighborhood(lane(scene_seed, "character"), ranges)
    terrain = draw_terrain(lane(scene_seed, "terrain"))
    plan = draw_street_plan(
        lane(scene_seed, "streets"),
        frontage_range=town.lot_frontage_m,
        depth_range=town.lot_depth_m,
    )
    half = town.flight_area_m / 2
    bounds = np.array([[-half, -half], [half, half]])

    lots = [
        plan_lot(lane(scene_seed, "lot", index), lot, plan, town, bounds)
        for index, lot in enumerate(plan.lots)
    ]
    paved = [polygon for lot in lots for polygon in lot.paved]
    streetscape = furnish_streets(lane(scene_seed, "streetscape"), plan, terrain, lots, town)
    markings = draw_street_markings(lane(scene_seed, "markings"), plan)
    models: list[Model] = [
        street_surface(plan, terrain, [*paved, *markings.ramps]),
        street_markings(markings, terrain),
        outskirts(terrain),
        *streetscape.models(lane(scene_seed, "furniture"), bounds),
    ]
    for index, lot in enumerate(lots):
        models += build_lot(lane(scene_seed, "garden", index), lot, terrain, bounds)
    models += build_items(lane(scene_seed, "items"), lots, terrain, bounds)
    models += _greenery(scene_seed, town, plan, terrain, lots, streetscape, bounds)
    surfaces = assemble(models)
    return World(
        map="neighborhood",
        scene_seed=scene_seed,
        surfaces=surfaces,
        materials=bake_materials(lane(scene_seed, "materials"), [name for name, _ in surfaces]),
        light=light,
        flight_bounds=bounds,
        ground_m=terrain.height_m,
    )


def _greenery(
    scene_seed: int,
    town: Neighborhood,
    plan: StreetPlan,
    terrain: Terrain,
    lots: list[LotPlan],
    streetscape: Streetscape,
    bounds: np.ndarray,
) -> list[Model]:
    """All trees, bushes and tufts of the map, each kind built in one go."""
    rng = lane(scene_seed, "trees")
    garden = np.concatenate([lot.trees for lot in lots] + [np.zeros((0, 2))])
    names, weights = list(town.tree_mix), np.array(list(town.tree_mix.values()), float)
    species = rng.choice(names, len(garden), p=weights / weights.sum())
    far = tree_line(rng, terrain)
    far_names = [name for name in names if name not in ("fruit", "young", "bare", "palm")]
    positions = np.concatenate(
        [on_ground(terrain, garden), on_ground(terrain, streetscape.trees), far]
    )
    kinds = np.concatenate(
        [
            species,
            np.full(len(streetscape.trees), town.street_tree),
            rng.choice(far_names, len(far)),
        ]
    )
    models = [plant(rng, positions, kinds, distance_to(bounds, positions))]

    rng = lane(scene_seed, "shrubs")
    places = np.concatenate([lot.bushes for lot in lots] + [np.zeros((0, 3))])
    # Farther out a bush is a few pixels: trees and hedges make the picture there.
    places = places[distance_to(bounds, places) <= 40.0]
    feet = on_ground(terrain, places[:, :2])
    models.append(bushes(rng, feet, places[:, 2], distance_to(bounds, feet)))

    rng = lane(scene_seed, "tufts")
    edges = np.concatenate([lot.tufts for lot in lots] + [streetscape.tufts])
    near = edges[distance_to(bounds, edges) <= 0.0]
    models.append(grass_tufts(rng, on_ground(terrain, near), rng.uniform(0.08, 0.3, len(near))))
    return models
