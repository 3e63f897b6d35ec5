"""The map soccer_field: laws of the game, parts that stand where they should, the whole."""

import hashlib

import numpy as np
import pytest
import shapely
import shapely.affinity

from synthdepth.maps.placement import distance_to
from synthdepth.maps.soccer_field import SoccerFieldRanges, draw_sports_ground, soccer_field
from synthdepth.maps.stadium.arena import draw_arena
from synthdepth.maps.stadium.layout import draw_layout
from synthdepth.maps.stadium.markings import soccer_lines
from synthdepth.maps.stadium.masts import stadium_mast, training_mast
from synthdepth.maps.stadium.nets import GOAL_M, NET, ball_stop, goal
from synthdepth.maps.stadium.stands import club_colours, draw_stand, seats, stand_model
from synthdepth.maps.stadium.surfaces import tessellate
from synthdepth.seeding import lane
from tests.lights import CLEAR

RANGES = SoccerFieldRanges(
    flight_area_m=160.0, ground_m=(230, 240), stand_rows=(4, 6), stand_sides=(1, 1),
    spectators=20, training_players=(0, 6), trees_per_hectare=(10, 20), house_rows=(1, 1),
    grandeur=(0.2, 0.3), track_share=0.0,
)  # fmt: skip


def digest(world):
    total = hashlib.sha256()
    for key, part in world.surfaces.items():
        total.update(repr(key).encode())
        for array in (part.vertices, part.faces, part.uv, part.tint):
            total.update(array.tobytes())
    return total.hexdigest()


def areas_m2(part):
    corners = part.triangles.astype(np.float64)
    return (
        np.linalg.norm(
            np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
        )
        / 2
    )


@pytest.fixture(scope="module")
def world():
    return soccer_field(3, RANGES, CLEAR)


def test_a_seed_always_builds_the_same_place_and_others_build_others(world):
    assert digest(soccer_field(3, RANGES, CLEAR)) == digest(world)
    club, other = (draw_sports_ground(lane(s, "character"), RANGES) for s in (3, 4))
    assert not np.array_equal(club.at, other.at)


def test_everything_that_a_sports_ground_has_is_there(world):
    labels = {label for _, label in world.surfaces}
    assert {
        "ground", "road", "pavement", "building", "roof", "vegetation", "tree_trunk", "vehicle",
        "person", "pole", "wire", "barrier", "street_furniture", "obstacle", "hill",
    } <= labels  # fmt: skip
    materials = {name for name, _ in world.surfaces}
    assert {"turf", "chalk", "adverts", "floodlight", "lamp"} <= materials
    assert 3e5 < world.triangle_count < 5e6


def test_numbers_are_finite_and_triangles_have_an_area(world):
    for key, part in world.surfaces.items():
        assert np.isfinite(part.vertices).all()
        assert np.isfinite(part.uv).all()
        assert part.tint.min() >= 0
        assert part.faces.max() < len(part.vertices)
        assert areas_m2(part).min() > 1e-9, key


def test_things_stand_on_the_ground(world):
    for wanted in ("vehicle", "building", "pole", "person", "obstacle"):
        parts = [part.vertices for (_, label), part in world.surfaces.items() if label == wanted]
        vertices = np.concatenate(parts)
        vertices = vertices[np.abs(vertices[:, :2]).max(axis=1) < 480]
        above = vertices[:, 2] - world.ground_m(vertices[:, :2])
        assert -2.0 < above.min() < 0.05, wanted
        assert above.max() < 45, wanted


def test_the_ground_has_no_holes_where_one_flies(world):
    """A ray straight down meets ground, road or pavement within 15 cm of the land's height."""
    rng = lane(0, "rays")
    points = rng.uniform(-75, 75, (300, 2))
    flat = [
        p for (_, label), p in world.surfaces.items() if label in ("ground", "road", "pavement")
    ]
    tops = np.full(len(points), -9.0)
    for part in flat:
        corners = part.triangles.astype(np.float64)
        near = (np.abs(corners[:, :, :2]).max(axis=(1, 2)) < 110) & (areas_m2(part) > 1e-4)
        polygons = shapely.polygons(corners[near][:, :, :2])
        tree = shapely.STRtree(polygons)
        i, j = tree.query(shapely.points(points), predicate="intersects")
        np.maximum.at(tops, i, corners[near][j, :, 2].mean(axis=1))
    gap = tops - world.ground_m(points)
    assert (gap > -0.2).all()


def test_lines_have_the_measures_of_the_law():
    lines = soccer_lines(105.0, 68.0)
    assert lines.bounds == pytest.approx((-52.5, -34, 52.5, 34), abs=1e-6)
    across = shapely.LineString([(-60, 10.0), (60, 10.0)])
    parts = shapely.get_parts(shapely.intersection(lines, across))
    edges = np.sort(np.abs([p.bounds[0] if p.bounds[0] > 0 else p.bounds[2] for p in parts]))
    assert edges.min() == pytest.approx(0.06, abs=1e-6)  # half of the halfway line
    # Outer edges: penalty area 16.5 m from the goal line, goal line 0.12 m wide.
    assert np.abs(edges - (52.5 - 16.5)).min() < 1e-6
    assert shapely.LineString([(0, 9.03 + 0.005), (0, 9.15 - 0.005)]).within(lines)
    assert shapely.Point(52.5 - 11, 0).within(lines)
    assert not shapely.Point(0, 8.9).within(lines.difference(shapely.box(-0.07, -40, 0.07, 40)))


def test_goals_have_their_size_and_a_net_that_lets_light_through():
    model = goal(lane(0, "goal"))
    frame = np.concatenate([p.vertices for key, p in model.items() if key != NET])
    post = frame[np.abs(frame[:, 0]) < 0.125]
    assert np.abs(post[:, 1]).max() == pytest.approx(GOAL_M[0] / 2 + 0.12, abs=0.01)
    assert post[:, 2].max() == pytest.approx(GOAL_M[1] + 0.12, abs=0.01)
    net = model[NET]
    assert net.vertices[:, 0].max() < 0.02  # behind the line
    cords = areas_m2(net).sum()
    width, height = GOAL_M
    assert 0.02 * width * height < cords < 0.4 * width * height


def test_ball_stops_stand_on_their_poles():
    model = ball_stop(lane(1, "stop"), np.array([[0, 0], [30.0, 0]]), 7.0)
    poles = model["paint", "pole"].vertices
    assert poles[:, 2].max() == pytest.approx(7.0, abs=0.2)
    assert model[NET].vertices[:, 2].max() < 7.2
    assert areas_m2(model[NET]).sum() < 0.12 * 30 * 7


def test_masts_are_as_high_as_asked_and_shine_on_the_pitch():
    for model, high in (
        (stadium_mast(lane(0, "mast"), 30.0, "lattice", 3, 4, 0.5), 30.0),
        (stadium_mast(lane(0, "mast"), 24.0, "tube", 2, 3, 0.5), 24.0),
        (training_mast(lane(0, "mast"), 10.0, 2), 10.0),
    ):
        steel = model["paint", "pole"].vertices
        assert high <= steel[:, 2].max() < high + 4
        lamps = model["floodlight", "pole"]
        corners = lamps.triangles
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        assert (normal[:, 0] > 0).all()  # forwards
        assert (normal[:, 2] < 0).all()  # and down
        assert areas_m2(lamps).max() < 0.15


def test_stands_seat_people_on_their_steps():
    rng = lane(2, "stand")
    stand = draw_stand(rng, 60.0, 14, True, club_colours(rng))
    at, row = seats(stand)
    assert len(at) > 14 * 60
    np.testing.assert_allclose(at[:, 2], stand.front_m + row * stand.riser_m)
    model = stand_model(rng, stand)
    concrete = model["concrete", "building"].vertices
    assert concrete[:, 2].min() < 0
    assert concrete[:, 2].max() == pytest.approx(stand.top_m, abs=0.01)
    roof = model["sheeting", "roof"].vertices
    assert roof[:, 2].min() > stand.top_m + 2


def test_plots_keep_apart_and_inside_the_site():
    for seed in range(6):
        rng = lane(seed, "layout")
        wanted = ["clubhouse", "pitch", "small_pitch", "tennis", "cage", "playground"]
        layout = draw_layout(rng, (200, 190), (70, 60), wanted, 34.0, 2.5, 0.2)
        areas = [plot.area for plot in layout.plots]
        site = shapely.box(-200, -190, 200, 190)
        assert all(site.contains(area) for area in areas)
        arena = shapely.box(-70, -60, 70, 60)
        arena = shapely.affinity.translate(arena, *layout.arena_at)
        areas.append(arena)
        overlap = sum(a.area for a in areas) - shapely.union_all(areas).area
        assert overlap < 1e-6
        assert {plot.kind for plot in layout.plots} >= {"parking", "pitch", "clubhouse", "grove"}


def test_grandeur_makes_the_difference_between_a_village_and_a_stadium():
    shared = {
        "covered_share": 1.0,
        "track": False,
        "wear": 0.3,
        "occupied": 0.1,
        "spectators": 100,
        "players": 22,
    }
    village = draw_arena(
        lane(0, "a"), grandeur=0.0, sides=1, rows=(4, 5), mast_count=2, mast_m=14.0, **shared
    )
    stadium = draw_arena(
        lane(0, "a"), grandeur=1.0, sides=4, rows=(20, 24), mast_count=4, mast_m=34.0, **shared
    )
    assert len(village.stands) == 1
    assert len(stadium.stands) == 4
    places = [sum(len(seats(s)[0]) for s, _ in a.stands.values()) for a in (village, stadium)]
    assert places[1] > 10 * places[0]


def test_triangles_cover_an_area_once():
    ring = shapely.Point(3, 2).buffer(20).difference(shapely.box(-2, -2, 4, 5))
    corners, _ = tessellate(ring, (4.0, 3.0), (0.5, 0.0))
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]) / 2
    assert (area > 0).all()
    assert area.sum() == pytest.approx(ring.area, rel=1e-6)


def test_the_flights_are_over_the_ground(world):
    turf = world.surfaces["turf", "ground"].vertices
    assert (distance_to(world.flight_bounds, turf) <= 0).mean() > 0.2
