"""The maps by name: adding a map is one generator file, one recipe and one line here."""

import dataclasses
from collections.abc import Callable

from synthdepth.config import Config
from synthdepth.maps.blocks import BlocksRanges, blocks
from synthdepth.maps.city import CityRanges, city
from synthdepth.maps.coastline import CoastlineRanges, coastline
from synthdepth.maps.light import LightRanges, draw_light
from synthdepth.maps.neighborhood import NeighborhoodRanges, neighborhood
from synthdepth.maps.soccer_field import SoccerFieldRanges, soccer_field
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
    "blocks": MapKind(
        ranges=BlocksRanges,
        build=blocks,
        summary="an arena of obstacles: walls with gates, pillars, stacks, frames, nets, cables",
    ),
    "city": MapKind(
        ranges=CityRanges,
        build=city,
        summary="avenues between towers and low blocks: traffic, people, wires, parks, a crane",
    ),
    "coastline": MapKind(
        ranges=CoastlineRanges,
        build=coastline,
        summary="beach, dunes or cliffs by the sea: pines, a coast road, houses, boats, a pier",
    ),
    "neighborhood": MapKind(
        ranges=NeighborhoodRanges,
        build=neighborhood,
        summary="a suburb: winding streets, houses, gardens, trees, poles with wires, parked cars",
    ),
    "soccer_field": MapKind(
        ranges=SoccerFieldRanges,
        build=soccer_field,
        summary="a sports ground: pitches, goals with nets, stands, masts, courts, a town around",
    ),
}


def build_world(map_name: str, ranges: Config, light: LightRanges, scene_seed: int) -> World:
    """One scene of a map: a function of its seed and ranges alone."""
    drawn = draw_light(lane(scene_seed, "light"), light)
    return weathered(MAPS[map_name].build(scene_seed, ranges, drawn))
