"""The map neighborhood as a whole: deterministic, true to scale, nothing in the way of anything."""

import dataclasses
import hashlib

import numpy as np
import pytest
import shapely

from synthdepth.maps.gardens.lots import plan_lot
from synthdepth.maps.neighborhood import NeighborhoodRanges, draw_neighborhood, neighborhood
from synthdepth.maps.placement import points_along, points_within
from synthdepth.maps.streets.plan import draw_street_plan
from synthdepth.maps.streets.streetscape import furnish_streets
from synthdepth.maps.terrain import draw_terrain
from synthdepth.maps.world import Light
from synthdepth.seeding import lane

RANGES = NeighborhoodRanges(flight_area_m=200.0)
BOUNDS = np.array([[-100.0, -100.0], [100.0, 100.0]])
LIGHT = Light(
    condition="clear",
    sun_azimuth_deg=0.0,
    sun_elevation_deg=40.0,
    turbidity=3.0,
    visibility_m=2e4,
)


def digest(world):
    total = hashlib.sha256()
    for key, part in world.surfaces.items():
        total.update(str(key).encode())
        for array in (part.vertices, part.faces, part.uv, part.tint):
            total.update(array.tobytes())
    for material in world.materials.values():
        total.update(material.texture.tobytes())
    return total.hexdigest()


@pytest.fixture(scope="module")
def world():
    return neighborhood(5, RANGES, LIGHT)


def test_another_seed_builds_another_place(world):
    assert digest(neighborhood(6, RANGES, LIGHT)) != digest(world)


def test_everything_that_a_suburb_has_is_there(world):
    labels = {label for _, label in world.surfaces}
    assert {
        "ground", "road", "pavement", "building", "roof", "vegetation", "tree_trunk", "vehicle",
        "pole", "wire", "barrier", "street_furniture", "hill",
    } <= labels  # fmt: skip
    assert 5e5 < world.triangle_count < 5e6


def test_numbers_are_finite_and_surfaces_are_whole(world):
    for part in world.surfaces.values():
        assert np.isfinite(part.vertices).all()
        assert np.isfinite(part.uv).all()
        assert part.faces.min() >= 0
        assert part.faces.max() < len(part.vertices)
        assert part.tint.min() >= 0
        assert part.vertices.dtype == part.uv.dtype == part.tint.dtype == np.float32


def test_the_ground_reaches_the_horizon_all_around(world):
    """The sky is black below the horizon: hills must stand higher than a drone flies."""
    hill = world.surfaces["hill", "hill"].vertices
    azimuth = np.degrees(np.arctan2(hill[:, 1], hill[:, 0])) % 360
    top = [hill[np.abs(azimuth - a) <= 2.5, 2].max() for a in np.arange(2.5, 360, 5)]
    assert min(top) > 80


def test_nothing_hangs_in_the_air_or_lies_under_the_ground(world):
    for wanted in ("vehicle", "building", "pole", "tree_trunk"):
        parts = [part.vertices for (_, label), part in world.surfaces.items() if label == wanted]
        vertices = np.concatenate(parts)
        vertices = vertices[np.abs(vertices[:, :2]).max(axis=1) < 480]
        above = vertices[:, 2] - world.ground_m(vertices[:, :2])
        assert -2.0 < above.min() < 0.05, wanted
        assert above.max() < 40, wanted


@pytest.fixture(scope="module")
def layout():
    town = draw_neighborhood(lane(5, "character"), NeighborhoodRanges())
    terrain = draw_terrain(lane(5, "terrain"))
    plan = draw_street_plan(lane(5, "streets"))
    lots = [
        plan_lot(lane(5, "lot", index), lot, plan, town, BOUNDS)
        for index, lot in enumerate(plan.lots)
    ]
    return plan, lots, furnish_streets(lane(5, "streetscape"), plan, terrain, lots, town)


def footprints(lots):
    for lot in lots:
        if lot.house is not None:
            for x0, y0, x1, y1 in lot.house.footprint:
                yield shapely.Polygon(lot.to_world([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]))


def test_houses_stand_on_their_lots_and_off_the_streets(layout):
    plan, lots, _ = layout
    houses = [lot for lot in lots if lot.house is not None]
    assert len(houses) > 0.85 * len([lot for lot in plan.lots if lot.kind == "house"])
    for lot in houses:
        parcel = shapely.Polygon(lot.lot.polygon).buffer(0.35)
        assert all(parcel.contains(part) for part in footprints([lot]))
    assert not any(plan.street_land.buffer(-0.5).intersects(part) for part in footprints(houses))


def test_trees_and_cars_keep_out_of_houses_and_poles_off_the_road(layout):
    plan, lots, streets = layout
    built = shapely.union_all(list(footprints(lots)))
    for points in (np.concatenate([lot.trees for lot in lots]), streets.trees, streets.cars):
        assert not shapely.contains_xy(built, points[:, 0], points[:, 1]).any()
    poles = np.concatenate(streets.lines)
    for points in (poles, streets.lamps, streets.trees, *streets.signs.values()):
        assert not shapely.contains_xy(plan.carriageway, points[:, 0], points[:, 1]).any()
    spans = np.concatenate([np.hypot(*np.diff(line[:, :2], axis=0).T) for line in streets.lines])
    assert spans.min() >= 15
    assert spans.max() <= 62.0
    assert sum(len(drops) for drops in streets.drops) > 50


def test_recipes_reach_the_place():
    dense = dataclasses.replace(RANGES, house_styles=(1, 1), trees_per_lot=(0, 0))
    town = draw_neighborhood(lane(1, "character"), dense)
    assert len(town.styles) == 1
    assert town.trees_per_lot == 0


def test_points_are_placed_as_asked():
    rng = lane(0, "test")
    square = shapely.box(0, 0, 30, 30)
    points = points_within(rng, square, 40, apart_m=2.0)
    gaps = np.hypot(*(points[:, None] - points[None]).transpose(2, 0, 1)) + 99 * np.eye(len(points))
    assert len(points) == 40
    assert gaps.min() >= 2.0
    assert len(points_within(rng, shapely.Polygon(), 5)) == 0
    along = points_along(square.boundary, 1.0, rng)
    assert len(along) == 120
    assert shapely.distance(square.boundary, shapely.points(along)).max() < 1e-9
