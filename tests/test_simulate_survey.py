"""Maps from above, free air and shortest ways: against worlds whose answers are known."""

import math

import numpy as np
import pytest
import shapely
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.maps.geometry import box, quads, tube
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane
from synthdepth.simulate.collision import Mesh
from synthdepth.simulate.relief import map_picture
from synthdepth.simulate.shortest import free_ways, shortest_way, way_length
from synthdepth.simulate.surface import surface_points
from synthdepth.simulate.survey import CELL_M, RIM, survey
from tests.conftest import flat_world, ground

RADIUS, ALTITUDE, GOAL = 0.35, (2.0, 20.0), 5.0
BOUNDS = np.array([[-50.0, -40.0], [50.0, 40.0]])
SEEDS = st.integers(0, 2**32)


def flat(xy):
    return np.zeros(len(xy))


def surveyed(models, bounds=BOUNDS):
    mesh = Mesh.of_world(flat_world([ground(half_m=300.0), *models]))
    return mesh, *survey(mesh, bounds, flat, altitude_m=ALTITUDE, radius_m=RADIUS)


def shortest(models, start, goal):
    mesh, _, air = surveyed(models)
    is_free = free_ways(mesh, flat, ALTITUDE, RADIUS)
    way = shortest_way(np.array(start), np.array(goal), GOAL, air, is_free)
    if way is not None:
        assert is_free(way[:-1], way[1:]).all()
        np.testing.assert_array_equal(way[0], start)
        assert np.hypot(*(way[-1] - goal)[:2]) <= GOAL + 1e-9
    return way


def block(size, base=(0.0, 0.0, 0.0)):
    return {("card", "building"): box(size, base=base)}


def around(obstacle, start, goal):
    """The shortest way in a plane around a convex obstacle that is in the way: the hull of it and
    both ends, less the straight way between them, on the shorter side."""
    hull = shapely.union_all([obstacle, shapely.Point(start), shapely.Point(goal)]).convex_hull
    corners = np.array(hull.exterior.coords)[:-1]
    at = [np.hypot(*(corners - end).T).argmin() for end in (start, goal)]
    ring = np.roll(corners, -at[0], axis=0)
    split = (at[1] - at[0]) % len(ring)
    sides = ring[: split + 1], np.concatenate([ring[split:], ring[:1]])
    return min(way_length(side) for side in sides)


@settings(deadline=None, max_examples=40)
@given(SEEDS)
def test_points_lie_on_their_triangles_and_leave_no_place_out(seed):
    rng = lane(seed, "triangles")
    middle = rng.uniform(-9, 9, (6, 1, 3))
    triangles = middle + rng.normal(size=(6, 3, 3)) * 10 ** rng.uniform(-2, 1, (6, 1, 3))
    spacing = 0.5
    low, high = np.full(3, -60.0), np.full(3, 60.0)
    found = list(surface_points(triangles, low, high, spacing))
    points, which = (np.concatenate(x) for x in zip(*found, strict=True))
    for k, triangle in enumerate(triangles):
        mine = points[which == k].astype(np.float64)
        assert len(mine)
        off = Mesh(triangle[None], [1]).distance(mine, mine, 1.0)[0]
        assert off.max() < 1e-4
        places = rng.dirichlet(np.ones(3), 200) @ triangle
        places = np.concatenate([places, triangle])
        places = places[(np.abs(places) < 58).all(axis=1)]
        away = np.linalg.norm(places[:, None] - mine, axis=-1).min(axis=1, initial=np.inf)
        assert (away <= 1.13 * spacing).all()


def test_points_of_a_vast_ground_stay_within_the_box():
    triangles = quads([[[-9e3, -9e3, 0], [9e3, -9e3, 0], [9e3, 9e3, 0], [-9e3, 9e3, 0]]]).triangles
    low, high = np.array([-5.0, 10, -1]), np.array([5.0, 30, 1])
    points = np.concatenate([p for p, _ in surface_points(triangles, low, high, 0.5)])
    assert ((points >= low) & (points < high)).all()
    cells = np.unique((points[:, :2] / 0.7).astype(int), axis=0)
    assert len(cells) == pytest.approx(10 * 20 / 0.49, rel=0.1)
    assert len(points) < 3 * 10 * 20 / 0.25


def test_a_map_shows_what_lies_topmost_north_up():
    roof = {("card", "roof"): box((10, 6, 2), base=(20, 30, 4))}
    car = {("card", "vehicle"): box((3, 3, 1), base=(20, 30, 0))}  # under the roof
    wire = {("card", "wire"): tube([[-40, -30, 9], [10, -20, 9]], 0.01, sides=4)}
    _, view, _ = surveyed([roof, car, wire])
    assert view.height_m.shape == view.labels.shape == (160, 200)
    # Rows from y = 40 down, columns from x = -50 on, half a metre each.
    inside = view.labels[(40 - 32) * 2 : (40 - 28) * 2, (50 + 17) * 2 : (50 + 23) * 2]
    assert set(inside.ravel()) == {LABELS["roof"]}
    np.testing.assert_allclose(view.height_m[2 * 10, 2 * 70], 6.0)
    roofs = view.labels == LABELS["roof"]
    assert roofs.sum() / 4 == pytest.approx(60, rel=0.15)
    assert not (view.labels == LABELS["vehicle"]).any()
    assert set(view.labels.ravel()) == {LABELS[n] for n in ("ground", "roof", "wire")}
    ground_height = view.height_m[view.labels == LABELS["ground"]]
    np.testing.assert_array_equal(ground_height, 0.0)
    # The wire crosses every column from -40 to 10 once, give or take its ends.
    columns = (view.labels == LABELS["wire"]).any(axis=0)
    assert columns[21:119].all() and not columns[:19].any() and not columns[121:].any()


def test_a_map_is_lit_from_the_north_west():
    corners = np.array([[-20, -20, 0], [20, -20, 0], [20, 20, 0], [-20, 20, 0], [0, 0, 20.0]])
    faces = np.array([[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
    mesh = Mesh(corners[faces], np.full(4, LABELS["hill"]))
    view, _ = survey(mesh, BOUNDS, flat, altitude_m=ALTITUDE, radius_m=RADIUS)
    grey = map_picture(view).astype(float).mean(axis=-1)
    north, south = grey[80 - 20, 100], grey[80 + 20, 100]
    west, east = grey[80, 100 - 20], grey[80, 100 + 20]
    assert min(north, west) > max(south, east) + 20
    # Water and lawn are told apart, and ground that nothing shows is drawn, too.
    assert map_picture(view)[2, 2].min() > 100


@settings(deadline=None, max_examples=25)
@given(SEEDS)
def test_free_cells_are_clear_and_clear_cells_are_free(seed):
    rng = lane(seed, "air")
    at = rng.uniform(-6, 6, (4, 1, 3)) + [0, 0, 9]
    triangles = at + rng.normal(size=(4, 3, 3)) * 10 ** rng.uniform(-1, 0.6, (4, 1, 1))
    mesh = Mesh(triangles, np.ones(4))
    bounds = np.array([[-10.0, -8.0], [10.0, 8.0]])
    _, air = survey(mesh, bounds, flat, altitude_m=ALTITUDE, radius_m=RADIUS)
    assert air.free.shape == (20 + 2 * RIM, 16 + 2 * RIM, 18 + 2 * RIM)
    inside = np.zeros(air.free.shape, bool)
    inside[RIM:-RIM, RIM:-RIM, RIM:-RIM] = True
    assert not air.free[~inside].any()
    cells = np.argwhere(inside)
    centres = air.centres(cells)
    assert (np.abs(centres[:, 2] - 11) < 9).all() and (np.abs(centres[:, :2]) < [10, 8]).all()
    away = mesh.distance(centres, centres, 1.5)[0]
    free = air.free[tuple(cells.T)]
    limit = RADIUS + CELL_M / 2
    assert free[away >= limit + 1e-4].all()
    # Beside surfaces outside of the surveyed box points are not looked for.
    middle = (np.abs(centres[:, :2]) < [9, 7]).all(axis=1)
    assert not free[middle & (away < limit - 0.56)].any()


def test_altitudes_are_above_the_ground_not_above_zero():
    def slope(xy):
        return 0.5 * xy[:, 0]

    mesh = Mesh(np.zeros((0, 3, 3)), np.zeros(0))
    _, air = survey(mesh, BOUNDS, slope, altitude_m=ALTITUDE, radius_m=RADIUS)
    centres = air.centres(np.argwhere(air.free))
    above = centres[:, 2] - slope(centres)
    assert above.min() >= 2 and above.max() <= 20
    assert len(centres) == pytest.approx(100 * 80 * 18, rel=0.01)


def test_where_nothing_stands_the_straight_way_is_the_shortest():
    way = shortest([], [-40.0, 3.0, 8.0], [40.0, -20.0, 12.0])
    straight = np.linalg.norm([80.0, 23.0, 4.0])
    assert way_length(way) == pytest.approx(straight * (1 - 5 / math.hypot(80, 23)), abs=1e-9)
    assert len(way) == 2


@settings(deadline=None, max_examples=8)
@given(SEEDS)
def test_around_a_tower_it_is_as_long_as_a_string_pulled_taut(seed):
    rng = lane(seed, "tower")
    size, at = rng.uniform(4, 30, 2), rng.uniform(-6, 6, 2)
    start = np.array([-45.0, rng.uniform(-20, 20)])
    goal = np.array([45.0, rng.uniform(-20, 20)])
    low, high = at - size / 2, at + size / 2
    tower = shapely.box(*low, *high).buffer(RADIUS, quad_segs=64)
    if not tower.intersects(shapely.LineString([start, goal])):
        return
    expected = around(tower, start, goal) - GOAL
    way = shortest([block((*size, 60.0), (*at, 0.0))], [*start, 9.0], [*goal, 9.0])
    # Where both sides are about as long, the grid may take the longer one: see `shortest_way`.
    assert expected - 0.01 <= way_length(way) <= expected * 1.08 + 0.1


def test_over_a_wall_it_climbs_no_higher_than_it_must():
    """In the plane of x and z: a tangent to the wall's rounded top edge, then level."""
    way = shortest([block((2, 200, 12))], [-40.0, 0.0, 4.0], [40.0, 0.0, 4.0])
    wall = shapely.box(-1, -9, 1, 12).buffer(RADIUS, quad_segs=64)
    level = np.array([40 - GOAL, 12 + RADIUS])
    assert way_length(way) == pytest.approx(around(wall, [-40.0, 4.0], level), rel=2e-3)
    assert way[:, 2].max() < 12 + RADIUS + CELL_M + 0.02
    # No way over it is left within the altitudes, none around it within the bounds.
    assert shortest([block((2, 200, 19.9))], [-40.0, 0.0, 4.0], [40.0, 0.0, 4.0]) is None


@pytest.mark.parametrize(("door_m", "through"), [(6.0, True), (4.0, True), (0.6, False)])
def test_through_a_door_if_it_is_wide_enough(door_m, through):
    sides = [block((1, 60, 60), (0, s * (30 + door_m / 2) + 3.3, 0)) for s in (1, -1)]
    way = shortest(sides, [-30.0, 0.0, 5.0], [30.0, 0.0, 5.0])
    if through:
        at = 3.3 - door_m / 2 + RADIUS
        expected = 60 if at <= 0 else math.hypot(29.5, at) * 2 + 1
        assert way_length(way) == pytest.approx(expected - GOAL, abs=0.15)
    else:
        assert way is None


def test_a_goal_that_is_walled_in_has_no_way():
    walls = [block((1, 20, 60), (20 + s * 10, 0, 0)) for s in (1, -1)]
    walls += [block((20, 1, 60), (20, s * 10, 0)) for s in (1, -1)]
    assert shortest(walls, [-30.0, 0.0, 5.0], [20.0, 0.0, 5.0]) is None


def test_wires_are_gone_around():
    """Five wires of 1 cm, a metre apart: a fence that points of surfaces alone might not close."""
    wires = [
        {("card", "wire"): tube([[0, -200, z], [0, 12, z]], 0.005, sides=3)}
        for z in np.arange(1.0, 21.0, 0.6)
    ]
    way = shortest(wires, [-30.0, 0.0, 5.0], [30.0, 0.0, 5.0])
    around_its_end = 2 * math.hypot(30, 12 + RADIUS)
    assert way_length(way) == pytest.approx(around_its_end - GOAL, abs=0.3)
