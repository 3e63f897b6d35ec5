"""Houses, gardens and street furniture around a ground."""

import dataclasses

import numpy as np
import shapely

from synthdepth.maps.gardens.lots import LotPlan, build_items, build_lot, plan_lot
from synthdepth.maps.geometry import Model
from synthdepth.maps.stadium.town import Surroundings
from synthdepth.maps.streets.markings import draw_street_markings, street_markings
from synthdepth.maps.streets.plan import StreetPlan
from synthdepth.maps.streets.streetscape import Streetscape, furnish_streets
from synthdepth.maps.streets.surface import street_surface
from synthdepth.maps.terrain import Terrain


def neighbours(
    rng: np.random.Generator,
    plan: StreetPlan,
    character: Surroundings,
    drives: list[np.ndarray],
    terrain: Terrain,
    bounds: np.ndarray,
) -> tuple[list[Model], list[LotPlan], Streetscape]:
    """Streets, houses and gardens.

    Args:
        rng: of all of them.
        plan: streets and lots.
        character: of the streets.
        drives: (4, 2) each, ways into the ground that cross the pavement [m].
        terrain: heights.
        bounds: (2, 2) of the flights.

    Returns:
        The models, and the plans of lots and streets, for what grows there.
    """
    lanes = rng.spawn(4 + 2 * len(plan.lots))
    planning, building = lanes[4::2], lanes[5::2]
    lots = [
        plan_lot(lane, lot, plan, character, bounds)
        for lane, lot in zip(planning, plan.lots, strict=True)
    ]
    paved = [*(polygon for lot in lots for polygon in lot.paved), *drives]
    scape = _off_drives(furnish_streets(lanes[0], plan, terrain, lots, character), drives)
    markings = draw_street_markings(lanes[1], plan)
    models: list[Model] = [
        street_surface(plan, terrain, [*paved, *markings.ramps]),
        street_markings(markings, terrain),
        *scape.models(lanes[2], bounds),
    ]
    for lane, lot in zip(building, lots, strict=True):
        models += build_lot(lane, lot, terrain, bounds)
    models += build_items(lanes[3], lots, terrain, bounds)
    return models, lots, scape


def _off_drives(scape: Streetscape, drives: list[np.ndarray]) -> Streetscape:
    """The streetscape without what would stand on the car park's drives."""
    area = shapely.union_all([shapely.Polygon(d).buffer(2.0) for d in drives])

    def off(points):
        return points[~shapely.contains_xy(area, points[:, 0], points[:, 1])]

    return dataclasses.replace(
        scape,
        lamps=off(scape.lamps),
        hydrants=off(scape.hydrants),
        cars=off(scape.cars),
        trees=off(scape.trees),
        tufts=off(scape.tufts),
        signs={kind: off(at) for kind, at in scape.signs.items()},
    )
