"""Plants of a sports ground and of the streets and fields around it."""

import itertools

import numpy as np
import shapely

from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.gardens.lots import LotPlan
from synthdepth.maps.geometry import Model, copies, tube, yaw_matrix
from synthdepth.maps.placement import distance_to, draped_line, on_ground, points_within
from synthdepth.maps.stadium.piece import Piece
from synthdepth.maps.streets.streetscape import Streetscape
from synthdepth.maps.terrain import Terrain, tree_line
from synthdepth.maps.vegetation.shrubs import bushes, grass_tufts, hedge
from synthdepth.maps.vegetation.trees import plant

# Beyond this distance from the flights a bush is a few pixels.
_BUSHES_M = 40.0


def site_greenery(
    rng: np.random.Generator,
    tree_mix: dict[str, float],
    land: shapely.Geometry,
    site: Piece,
    terrain: Terrain,
    bounds: np.ndarray,
) -> list[Model]:
    """Trees, bushes, hedges or fences, and tufts of a ground.

    Args:
        rng: of all of them.
        tree_mix: weight of each species.
        land: of the site.
        site: where they stand.
        terrain: heights.
        bounds: (2, 2) of the flights.
    """
    lanes = rng.spawn(4)
    rng = lanes[0]
    inside = shapely.contains_xy(land.buffer(-0.8), site.trees[:, 0], site.trees[:, 1])
    feet = on_ground(terrain, site.trees[inside])
    names = list(tree_mix)
    weights = np.array([tree_mix[n] for n in names], float)
    # One kind to a stretch: rows and groves were planted at once.
    wave = (
        np.sin(feet[:, 0] / 37 + 2) + np.sin(feet[:, 1] / 29) + 0.4 * rng.standard_normal(len(feet))
    )
    rank = wave.argsort().argsort() / max(len(feet), 1)
    kinds = np.array(names)[np.searchsorted(np.cumsum(weights / weights.sum())[:-1], rank)]
    models = [plant(rng, feet, kinds, distance_to(bounds, feet))]
    rng = lanes[1]
    spots = on_ground(terrain, site.bushes)
    models.append(bushes(rng, spots, rng.uniform(0.8, 2.4, len(spots)), distance_to(bounds, spots)))
    rng = lanes[2]
    green = rng.random() < 0.6
    for line, height, width in site.hedges:
        path = draped_line(terrain, line)
        if green:
            # In stretches, each as fine as its distance asks for.
            cuts = np.append(np.arange(0, len(path) - 4, 10), len(path) - 1)
            for a, b in itertools.pairwise(cuts):
                part = path[a : b + 1]
                near = float(distance_to(bounds, part).min())
                models.append(hedge(rng, part, height, width, near))
        else:
            models.append(fence(rng, path, "chain_link", 2.0))
    rng = lanes[3]
    near = site.tufts[distance_to(bounds, site.tufts) <= 0.0]
    models.append(grass_tufts(rng, on_ground(terrain, near), rng.uniform(0.05, 0.2, len(near))))
    return models


def town_greenery(
    rng: np.random.Generator,
    tree_mix: dict[str, float],
    street_tree: str,
    country: shapely.Geometry,
    terrain: Terrain,
    lots: list[LotPlan],
    scape: Streetscape,
    bounds: np.ndarray,
) -> list[Model]:
    """Trees of gardens, streets, fields and the horizon; bushes and tufts near the flights.

    Args:
        rng: of all of them.
        tree_mix: weight of each species.
        street_tree: species along the streets.
        country: the fields.
        terrain: heights.
        lots, scape: where they stand.
        bounds: (2, 2) of the flights.
    """
    garden = np.concatenate([lot.trees for lot in lots] + [np.zeros((0, 2))])
    fields = _field_trees(rng, country)
    far = tree_line(rng, terrain)
    names = list(tree_mix)
    weights = np.array([tree_mix[n] for n in names], float)
    tall = [name for name in names if name not in ("young", "bare", "palm")]
    positions = np.concatenate(
        [
            on_ground(terrain, garden),
            on_ground(terrain, scape.trees),
            on_ground(terrain, fields),
            far,
        ]
    )
    kinds = np.concatenate(
        [
            rng.choice(names, len(garden), p=weights / weights.sum()),
            np.full(len(scape.trees), street_tree),
            rng.choice(tall, len(fields) + len(far)),
        ]
    )
    models = [plant(rng, positions, kinds, distance_to(bounds, positions))]
    models.append(_bales(rng, country, terrain))
    places = np.concatenate([lot.bushes for lot in lots] + [np.zeros((0, 3))])
    places = places[distance_to(bounds, places) <= _BUSHES_M]
    feet = on_ground(terrain, places[:, :2])
    models.append(bushes(rng, feet, places[:, 2], distance_to(bounds, feet)))
    edges = np.concatenate([lot.tufts for lot in lots] + [scape.tufts])
    near = edges[distance_to(bounds, edges) <= 0.0]
    models.append(grass_tufts(rng, on_ground(terrain, near), rng.uniform(0.08, 0.3, len(near))))
    return models


def _bales(rng: np.random.Generator, country: shapely.Geometry, terrain: Terrain) -> Model:
    """Round bales of straw, left on some fields."""
    fields = points_within(rng, country, 5, 90.0)
    spots = [shapely.Point(xy).buffer(rng.uniform(35, 70)) for xy in fields]
    land = shapely.intersection(shapely.union_all(spots), country)
    at = on_ground(terrain, points_within(rng, land, 90, 9.0))
    bale = tube([[0, y, 0.68] for y in (-0.6, -0.58, 0.58, 0.6)], [0.64, 0.7, 0.7, 0.64], 14)
    rotation = yaw_matrix(rng.uniform(0, 2 * np.pi, len(at)))
    tint = np.array([0.3, 0.23, 0.115]) * rng.uniform(0.75, 1.1, (len(at), 1))
    return {("leaf", "obstacle"): copies(bale, at, rotation=rotation, tint=tint)}


def _field_trees(rng: np.random.Generator, country: shapely.Geometry) -> np.ndarray:
    """Trees (k, 2) of hedgerows and copses in the open country."""
    if country.area < 1e4:
        return np.zeros((0, 2))
    rows = []
    for x, y in points_within(rng, country, max(int(country.area / 8000), 2), 40.0):
        turn, long = rng.choice([0.3, 1.87]) + rng.normal(0, 0.1), rng.uniform(30, 110)
        t = rng.uniform(-0.5, 0.5, int(long / rng.uniform(4, 7))) * long
        row = np.array([x, y]) + t[:, None] * [np.cos(turn), np.sin(turn)]
        rows.append(row + rng.normal(0, rng.choice([0.8, 5.0]), row.shape))
    points = np.concatenate(rows)
    return points[shapely.contains_xy(country, points[:, 0], points[:, 1])]
