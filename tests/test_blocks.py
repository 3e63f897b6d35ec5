"""The map blocks: solids that are closed and to scale, zones that fill the ground, the whole."""

import hashlib

import numpy as np
import pytest
import shapely

from synthdepth.errors import RecipeError
from synthdepth.maps.arena.filling import FreeSpace
from synthdepth.maps.arena.palette import draw_palette
from synthdepth.maps.arena.plan import EDGE_M, THEMES, draw_plots
from synthdepth.maps.arena.site import landmarks
from synthdepth.maps.arena.solids import cone, cuboids, cylinder, pipe, sphere, wedge
from synthdepth.maps.arena.walls import arch, pierced_wall
from synthdepth.maps.arena.zone import Zone
from synthdepth.maps.blocks import BlocksRanges, blocks, draw_blocks
from synthdepth.maps.geometry import merge
from synthdepth.seeding import lane
from tests.lights import CLEAR

RANGES = BlocksRanges(flight_area_m=150.0, zone_m=(100, 130), density=(0.5, 0.6))
BOUNDS = np.array([[-200.0, -200.0], [200.0, 200.0]])


def digest(surfaces):
    total = hashlib.sha256()
    for key, part in surfaces.items():
        total.update(repr(key).encode())
        for array in (part.vertices, part.faces, part.uv, part.tint):
            total.update(array.tobytes())
    return total.hexdigest()


def areas_m2(part):
    c = part.triangles.astype(np.float64)
    return np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1) / 2


def volume_m3(part):
    c = part.triangles.astype(np.float64)
    return np.einsum("ni,ni->n", c[:, 0], np.cross(c[:, 1], c[:, 2])).sum() / 6


def zone(size=(70.0, 60.0), near=True):
    return Zone(
        size_m=np.array(size),
        palette=draw_palette(lane(0, "palette"), 0.8),
        density=1.0,
        height_m=16.0,
        object_m=4.0,
        thin=0.5,
        near=near,
    )


@pytest.fixture(scope="module")
def world():
    return blocks(3, RANGES, CLEAR)


def test_solids_face_outwards_and_have_their_volume():
    tint = (0.5, 0.5, 0.5)
    assert volume_m3(cuboids([[3, 1, 2]], (2, 3, 4), 0.4, sunk_m=0)) == pytest.approx(24, rel=1e-4)
    assert volume_m3(wedge(6, 2, 3, tint)) == pytest.approx(18, rel=0.05)
    round_area = 0.5 * 64 * np.sin(2 * np.pi / 64)
    assert volume_m3(cylinder(2, 5, tint, 64, 0.001)) == pytest.approx(
        4 * round_area * 5.05, rel=0.01
    )
    assert volume_m3(cone(2, 6, tint, 64)) > 0.9 * np.pi * 4 * 6 / 3
    assert volume_m3(sphere(1, tint, 64)) == pytest.approx(4 / 3 * np.pi, rel=0.01)
    shell = np.pi * (1 - 0.81) * 4
    assert volume_m3(pipe(4, 1, 0.1, tint, 64)) == pytest.approx(shell, rel=0.02)
    assert volume_m3(arch(4, 2, 1, 0.5, tint)) > 0


def test_walls_leave_their_holes_open():
    holes = [(-2.0, -1.0, 0.0, 2.0), (1.0, 2.0, 1.0, 2.0)]
    wall = pierced_wall(8.0, 3.0, 0.2, holes, (1, 1, 1))
    front = wall.triangles[np.abs(wall.triangles[:, :, 1] + 0.1).max(axis=1) < 1e-6]
    seen = shapely.union_all(shapely.polygons(front[:, :, [0, 2]]))
    assert not seen.intersects(shapely.Point(-1.5, 1.0))
    assert not seen.intersects(shapely.Point(1.5, 1.5))
    assert seen.contains(shapely.Point(1.5, 0.5))
    assert seen.area == pytest.approx(8 * 3.05 - 2 - 0.05 - 1, abs=1e-3)


@pytest.mark.parametrize("name", sorted(THEMES))
def test_themes_stay_in_their_zone_and_stand_on_the_ground(name):
    for near in (True, False):
        place = zone(near=near)
        model = merge(THEMES[name](lane(5, name), place))
        assert sum(len(part.faces) for part in model.values()) > 20
        v = np.concatenate([part.vertices for part in model.values()])
        assert (np.abs(v[:, :2]) <= place.size_m / 2 + 4.5).all()
        assert -0.35 < v[:, 2].min() < 0.01
        assert v[:, 2].max() < 2 * place.height_m
        for key, part in model.items():
            assert (areas_m2(part) > 1e-9).all(), key
            assert part.tint.min() > 0


def test_zones_of_a_plan_do_not_overlap_and_all_themes_come_up():
    themes = set()
    for seed in range(4):
        plots = draw_plots(lane(seed, "zones"), (60, 105), 0.5, BOUNDS)
        boxes = [shapely.box(*(p.centre_m - p.size_m / 2), *(p.centre_m + p.size_m / 2))
                 for p in plots]  # fmt: skip
        assert shapely.union_all(boxes).area == pytest.approx(sum(b.area for b in boxes))
        assert max(np.abs(shapely.total_bounds(boxes))) < EDGE_M
        themes |= {p.theme for p in plots if p.near}
    assert themes == set(THEMES)


def test_free_places_keep_clear_of_things():
    things = {("paint", "obstacle"): cuboids([[5, 0, 0], [-12, 4, 0]], (8, 6, 3))}
    space = FreeSpace(things, np.array([60.0, 40.0]))
    taken = shapely.union_all([shapely.box(1, -3, 9, 3), shapely.box(-16, 1, -8, 7)])
    xy = np.concatenate([space.take(lane(0, "free"), r, 1.0) for r in (3.0, 1.5)])
    assert len(xy) > 10
    assert shapely.distance(shapely.points(xy), taken).min() > 1.0
    assert (np.abs(xy) < [28.6, 18.6]).all()


def test_a_seed_always_builds_the_same_place_and_others_build_others(world):
    assert digest(blocks(3, RANGES, CLEAR).surfaces) == digest(world.surfaces)
    first, other = (draw_blocks(lane(s, "character"), RANGES) for s in (3, 4))
    assert not np.array_equal(first.palette.weights, other.palette.weights)


def test_everything_that_an_arena_has_is_there(world):
    labels = {label for _, label in world.surfaces}
    assert {"ground", "road", "building", "vegetation", "vehicle", "person", "pole", "wire",
            "barrier", "obstacle", "hill"} <= labels  # fmt: skip
    assert {"lamp", "floodlight"} <= {name for name, _ in world.surfaces}
    assert world.triangle_count < 4e6
    for key, part in world.surfaces.items():
        assert np.isfinite(part.vertices).all()
        assert (areas_m2(part) < 1e-9).mean() < 2e-3, key
    assert np.abs(world.ground_m(np.array([[0.0, 0], [300, -300]]))).max() == 0


def test_wrong_ranges_are_refused():
    with pytest.raises(RecipeError, match="density"):
        BlocksRanges(density=(2.0, 9.0))


def test_few_large_zones_have_fewer_landmarks():
    """They stand at corners of lanes, of which there may be only one."""
    for zones in (1, 2, 6):
        plots = [plot for plot in draw_plots(lane(1, "zones"), (60, 105), 0.5, BOUNDS) if plot.near]
        models = landmarks(lane(2, "landmarks"), plots[:zones], 1.0)
        # The water tower stands outside.
        assert 2 <= len(models) <= zones + 1
