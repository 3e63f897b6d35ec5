"""The map `plain`: built, flown and rendered in a second, for tools that render again and again.

Importing this file makes it a map like the others. Workers import the main program's file anew, and
so know it too.
"""

import dataclasses

import numpy as np

from synthdepth.config import Config, number
from synthdepth.maps.geometry import box, copies, quads
from synthdepth.maps.registry import MAPS, MapKind
from synthdepth.maps.world import Light, Material, World, assemble
from synthdepth.production.recipe import Recipe, recipe_from_table
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class PlainRanges(Config):
    """Of the plain map: how many towers."""

    towers: int = number(12, 0, 100)


def plain(scene_seed: int, ranges: PlainRanges, light: Light) -> World:
    """A field with towers."""
    rng, far = lane(scene_seed, "towers"), 400.0
    at = rng.uniform(-100, 100, (ranges.towers, 3)) * [1, 1, 0]
    ground = quads([[[-far, -far, 0], [far, -far, 0], [far, far, 0], [-far, far, 0]]], (0.3,) * 3)
    towers = copies(box((6.0, 6.0, 12.0), tint=(0.6, 0.5, 0.4)), at)
    return World(
        map="plain",
        scene_seed=scene_seed,
        surfaces=assemble([{("card", "ground"): ground}, {("card", "building"): towers}]),
        materials={"card": Material(texture=np.full((2, 2, 3), 255, np.uint8))},
        light=light,
        flight_bounds=np.array([[-100.0, -100.0], [100.0, 100.0]]),
        ground_m=lambda xy: np.zeros(len(xy)),
    )


MAPS["plain"] = MapKind(ranges=PlainRanges, build=plain, summary="a field with towers")


def plain_recipe(pairs_per_shard: int, modalities: tuple[str, ...] = ()) -> Recipe:
    """The cheapest pairs that there are, 64x64, one flight a scene."""
    table = {
        "map": "plain",
        "light": {"conditions": ["clear"]},
        "flight": {"distance_m": [40.0, 80.0], "duration_s": [3.0, 25.0]},
        "camera": {"width": 64, "height": 64},
        "sensor": {"model": "ideal"},
        "sampling": {
            "pairs_per_scene": pairs_per_shard,
            "pairs_per_flight": pairs_per_shard,
            "burst_pairs": 2,
        },
        "render": {"spp": 1, "modalities": list(modalities)},
    }
    return recipe_from_table(table, "plain")
