"""The maps by name: adding a map is one generator file, one recipe and one line here."""

import dataclasses
from collections.abc import Callable

from synthdepth.config import Config
from synthdepth.maps.light import LightRanges, draw_light
from synthdepth.maps.neighborhood import NeighborhoodRanges, neighborhood
from synthdepth.maps.weather import weathered
from synthdepth.maps.world import Light, World
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class MapKind:
    """A map generator.

    Attributes:
        ranges: the class of its ranges, the recipe's `[scene]`.
        build: (scene_seed, ranges, light) -> World.
        summary: one line for people.
    """

    ranges: type[Config]
    build: Callable[[int, Config, Light], World]
    summary: str


MAPS = {
    "neighborhood": MapKind(
        ranges=NeighborhoodRanges,
        build=neighborhood,
        summary="a suburb: winding streets, houses, gardens, trees, poles with wires, parked cars",
    ),
}


def build_world(map_name: str, ranges: Config, light: LightRanges, scene_seed: int) -> World:
    """One scene of a map: a function of its seed and ranges alone."""
    drawn = draw_light(lane(scene_seed, "light"), light)
    return weathered(MAPS[map_name].build(scene_seed, ranges, drawn))
