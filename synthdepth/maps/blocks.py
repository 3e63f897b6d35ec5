"""The map `blocks`: an arena of obstacles in zones of many themes, fenced, with a town beyond."""

import dataclasses

import numpy as np

from synthdepth.config import Config, number, span
from synthdepth.maps.arena.filling import FreeSpace, filling
from synthdepth.maps.arena.ground import arena_ground
from synthdepth.maps.arena.palette import Palette, draw_palette
from synthdepth.maps.arena.plan import THEMES, Plot, draw_plots
from synthdepth.maps.arena.site import landmarks, lane_lamps, lane_things, perimeter, planting
from synthdepth.maps.arena.zone import Zone
from synthdepth.maps.geometry import Model, merge, place
from synthdepth.maps.materials.catalogue import bake_materials
from synthdepth.maps.skyline import skyline
from synthdepth.maps.terrain import Terrain, draw_terrain, outskirts, tree_line
from synthdepth.maps.world import Light, World, assemble
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class BlocksRanges(Config):
    """What an arena is drawn from; ranges are drawn once a scene.

    Attributes:
        zone_m: side of the zones, drawn for each row and column.
        density: how closely obstacles stand, 1 as usual.
        object_m: typical size of the solid obstacles.
        height_m: of the tallest solid obstacles.
        colourfulness: 0 for greys alone, 1 for strong paints.
        thin_share: share of the zones of thin things (frames, nets, cables), and of thin things
            elsewhere.
        skyline_m: height of the town's tallest tower.
        flight_area_m: side of the square in the middle that flights keep to.
    """

    zone_m: tuple[float, float] = span((60, 105), 40, 200)
    density: tuple[float, float] = span((0.7, 1.4), 0.2, 3)
    object_m: tuple[float, float] = span((3, 7), 0.5, 15)
    height_m: tuple[float, float] = span((8, 28), 2, 40)
    colourfulness: tuple[float, float] = span((0.45, 1), 0, 1)
    thin_share: tuple[float, float] = span((0.3, 0.6), 0, 1)
    skyline_m: tuple[float, float] = span((30, 140), 10, 250)
    flight_area_m: float = number(400.0, 150, 600)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Blocks:
    """The character of one arena, drawn from `BlocksRanges`.

    Attributes:
        palette: its paints.
        density, object_m, height_m, thin_share, skyline_m, flight_area_m: see the ranges.
        zone_m: a range still, drawn for each row and column.
    """

    palette: Palette
    density: float
    object_m: float
    height_m: float
    thin_share: float
    skyline_m: float
    zone_m: tuple[float, float]
    flight_area_m: float


def draw_blocks(rng: np.random.Generator, ranges: BlocksRanges) -> Blocks:
    """The character of one arena."""
    return Blocks(
        palette=draw_palette(rng, float(rng.uniform(*ranges.colourfulness))),
        zone_m=ranges.zone_m,
        flight_area_m=ranges.flight_area_m,
        **{
            name: float(rng.uniform(*getattr(ranges, name)))
            for name in ("density", "object_m", "height_m", "thin_share", "skyline_m")
        },
    )


def blocks(scene_seed: int, ranges: BlocksRanges, light: Light) -> World:
    """Build the arena of a scene seed."""
    arena = draw_blocks(lane(scene_seed, "character"), ranges)
    terrain = _flat_terrain(lane(scene_seed, "terrain"))
    half = arena.flight_area_m / 2
    bounds = np.array([[-half, -half], [half, half]])
    plots = draw_plots(lane(scene_seed, "zones"), arena.zone_m, arena.thin_share, bounds)
    everywhere = _zone(lane(scene_seed, "site"), arena, plots[0])
    far_trees = tree_line(lane(scene_seed, "woods"), terrain, count=900)

    models: list[Model] = []
    trees, shrubs = [np.zeros((0, 2))], [np.zeros((0, 2))]
    for index, plot in enumerate(plots):
        rng = lane(scene_seed, "zone", index)
        zone = _zone(rng, arena, plot)
        things = merge(THEMES[plot.theme](rng, zone))
        if plot.theme == "grove":
            space = FreeSpace(things, plot.size_m)
            trees.append(plot.centre_m + space.take(rng, 2.2, 0.7 if plot.near else 0.3))
            shrubs.append(plot.centre_m + space.take(rng, 1.0, 0.5))
        elif plot.near:
            things = merge([things, filling(rng, zone, FreeSpace(things, plot.size_m))])
        models.append(place(things, [*plot.centre_m, 0.0]))
    models += [
        arena_ground(lane(scene_seed, "ground"), plots, terrain.half_size_m),
        *lane_lamps(lane(scene_seed, "lamps"), plots, everywhere),
        *lane_things(lane(scene_seed, "lanes"), plots, bounds),
        *landmarks(lane(scene_seed, "landmarks"), plots, arena.thin_share),
        *planting(
            lane(scene_seed, "planting"),
            plots,
            np.concatenate(trees),
            np.concatenate(shrubs),
            bounds,
            far_trees,
        ),
        *perimeter(lane(scene_seed, "perimeter"), bounds),
        outskirts(terrain),
        skyline(
            lane(scene_seed, "skyline"),
            620.0,
            1700.0,
            tallest_m=arena.skyline_m,
            count=450,
            ground_m=terrain.height_m,
        ),
    ]
    surfaces = assemble(models)
    return World(
        map="blocks",
        scene_seed=scene_seed,
        surfaces=surfaces,
        materials=bake_materials(lane(scene_seed, "materials"), [name for name, _ in surfaces]),
        light=light,
        flight_bounds=bounds,
        ground_m=terrain.height_m,
    )


def _flat_terrain(rng: np.random.Generator) -> Terrain:
    """Level ground with hills round it."""
    land = draw_terrain(rng)
    return dataclasses.replace(land, amplitude_m=np.zeros_like(land.amplitude_m), offset_m=0.0)


def _zone(rng: np.random.Generator, arena: Blocks, plot: Plot) -> Zone:
    """A plot's zone: the arena's character, varied a little from zone to zone."""
    return Zone(
        size_m=plot.size_m,
        palette=arena.palette,
        density=float(arena.density * rng.uniform(0.8, 1.25)),
        height_m=float(arena.height_m * rng.uniform(0.55, 1.0)),
        object_m=float(arena.object_m * rng.uniform(0.6, 1.4)),
        thin=arena.thin_share,
        near=plot.near,
    )
