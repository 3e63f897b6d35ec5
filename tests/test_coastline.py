"""The map coastline as a whole: deterministic, true to scale, sea and land where they belong."""

import hashlib

import numpy as np
import pytest

from synthdepth.maps.coast.land import wooded
from synthdepth.maps.coast.sea import sea_surface
from synthdepth.maps.coast.shore import cliff_rise, cliff_run, draw_shore
from synthdepth.maps.coast.terrain import Pad, build_ground, draw_road
from synthdepth.maps.coast.waves import draw_sea
from synthdepth.maps.coastline import CoastlineRanges, coastline, draw_coastline
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane
from tests.lights import CLEAR

# Few plants and people: the tests look at the place, not at its triangles.
RANGES = CoastlineRanges(
    flight_area_m=150.0,
    boats=(4, 4),
    people=(5, 5),
    beach_items=(6, 6),
    tree_density=(0.2, 0.2),
    house_share=(0.3, 0.3),
)


def digest(surfaces):
    total = hashlib.sha256()
    for key, part in surfaces.items():
        total.update(str(key).encode())
        for array in (part.vertices, part.faces, part.uv, part.tint):
            total.update(array.tobytes())
    return total.hexdigest()


def shore_of(seed, **changes):
    params = {
        "flight_area_m": 400.0,
        "sea_share": 0.3,
        "bay_m": 25.0,
        "beach_width_m": 30.0,
        "cliff_height_m": 30.0,
        "cliff_share": 0.5,
        "dune_height_m": 4.0,
        "face_slope": 0.05,
        "wave_height_m": 0.8,
    }
    return draw_shore(lane(seed, "shore"), **(params | changes))


@pytest.fixture(scope="module")
def world():
    return coastline(5, RANGES, CLEAR)


@pytest.fixture(scope="module")
def ground():
    shore = shore_of(3)
    road = draw_road(lane(3, "road"), shore, 50.0)
    pad = Pad(s_m=0.0, t_m=150.0, heading_rad=0.2, half_m=(12.0, 15.0), z_m=14.0)
    return build_ground(shore, road, (pad,))


def grid(half_m, n):
    x, y = np.meshgrid(np.linspace(-half_m, half_m, n), np.linspace(-half_m, half_m, n))
    return np.stack([x, y], -1).reshape(-1, 2)


def test_everything_that_a_coast_has_is_there(world):
    labels = {label for _, label in world.surfaces}
    assert labels <= set(LABELS)
    assert {
        "ground", "road", "water", "building", "roof", "vegetation", "tree_trunk", "vehicle",
        "person", "pole", "wire", "barrier", "hill",
    } <= labels  # fmt: skip
    materials = {material for material, _ in world.surfaces}
    assert {"sand", "wet_sand", "heath", "rock", "sea", "lace", "foam"} <= materials
    assert materials == set(world.materials)
    assert 8e5 < world.triangle_count < 4.5e6


def test_numbers_are_finite_and_surfaces_are_whole(world):
    for (material, label), part in world.surfaces.items():
        assert np.isfinite(part.vertices).all()
        assert np.isfinite(part.uv).all()
        assert part.faces.min() >= 0
        assert part.faces.max() < len(part.vertices)
        assert part.tint.min() >= 0, (material, label)
        assert part.vertices.dtype == part.uv.dtype == part.tint.dtype == np.float32


@pytest.mark.parametrize("key", ["sand", "rock", "heath", "sea", "foam", "asphalt"])
def test_no_triangle_of_land_or_sea_is_degenerate_or_upside_down(world, key):
    for (material, _), part in world.surfaces.items():
        if material != key:
            continue
        corner = part.triangles.astype(np.float64)
        normal = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
        assert np.linalg.norm(normal, axis=1).min() > 2e-9
        if key in ("sea", "sand", "asphalt"):
            assert (normal[:, 2] > 0).mean() > 0.999


def test_the_whole_map_is_a_function_of_its_seed(world):
    again = coastline(5, RANGES, CLEAR)
    assert digest(again.surfaces) == digest(world.surfaces)
    assert draw_coastline(lane(6, "character"), RANGES) != draw_coastline(
        lane(5, "character"), RANGES
    )
    assert (shore_of(6).line_m != shore_of(5).line_m).mean() > 0.9
    for name, material in world.materials.items():
        assert material.texture.tobytes() == again.materials[name].texture.tobytes()


def test_the_sea_takes_its_share_of_the_square():
    for seed in range(6):
        for share in (0.2, 0.33):
            shore = shore_of(seed, sea_share=share)
            s, t = shore.to_local(grid(200.0, 101))
            assert np.mean(shore.away_m(s, t) < 0) == pytest.approx(share, abs=0.02)


def test_cliffs_and_beaches_have_the_asked_sizes():
    shore = shore_of(2, cliff_share=1.0, cliff_height_m=40.0)
    near = np.arange(-250.0, 250.0, 5.0)
    assert 25 < shore.look_up("cliff_m", near).mean() < 55
    flat = shore_of(2, cliff_share=0.0, beach_width_m=40.0)
    assert flat.look_up("cliff_m", near).max() < 2
    assert 25 < flat.look_up("beach_m", near).mean() < 60
    # The beach's face has its slope at the waterline.
    line = flat.look_up("line_m", near)
    q = flat.look_up("stretch", near)
    rise = flat.natural_m(near, line + 2 * q) - flat.natural_m(near, line)
    assert np.median(rise) / 2 == pytest.approx(0.05, rel=0.25)
    x = np.linspace(0, 1, 50)
    np.testing.assert_allclose(cliff_run(cliff_rise(x)), x, atol=1e-9)


def test_the_ground_answers_as_its_mesh_lies(ground):
    """Heights between the mesh's columns agree with its triangles; at sea the level is 0."""
    rng = np.random.default_rng(0)
    rows = np.r_[ground.starts[1] : ground.starts[3], ground.starts[4] : len(ground.t)]
    row, column = rng.choice(rows, 400), rng.integers(1, len(ground.s) - 1, 400)
    xy = ground.shore.to_world(ground.s[column], ground.t[row, column])
    np.testing.assert_allclose(ground.height_m(xy), ground.z[row, column], atol=0.02)
    everywhere = grid(220.0, 80)
    assert ground.surface_m(everywhere).min() == 0.0
    outside = ground.shore.to_world(np.array([301.0, -301.0]), np.array([120.0, 90.0]))
    inside = ground.shore.to_world(np.array([299.0, -299.0]), np.array([120.0, 90.0]))
    np.testing.assert_allclose(ground.height_m(outside), ground.height_m(inside), atol=0.8)


def test_the_road_keeps_off_the_beach_and_pads_are_level(ground):
    s = ground.s
    middle = (ground.lines[5] + ground.lines[6]) / 2
    assert (ground.lines[5] - ground.lines[4]).min() > 1.0
    xy = ground.shore.to_world(s, middle)
    assert ground.height_m(xy).min() > 2.0
    climb = np.abs(np.diff(ground.height_m(xy))) / np.diff(s)
    assert np.quantile(climb, 0.99) < 0.12
    pad = ground.shore.to_world(np.array([-5.0, 0.0, 6.0]), np.array([146.0, 150.0, 152.0]))
    np.testing.assert_allclose(ground.height_m(pad), 14.0, atol=0.05)


def test_waves_have_their_height_and_stay_above_the_bed(ground):
    sea = draw_sea(lane(1, "sea"), 0.8)
    assert 4 * sea.tile[..., 0].std() == pytest.approx(0.8, rel=0.05)
    stone = draw_coastline(lane(1, "character"), CoastlineRanges()).stone
    model = sea_surface(sea, ground, stone)
    vertices = np.concatenate([part.vertices for part in model.values()])
    near = np.abs(vertices[:, :2]).max(axis=1) < 200
    assert vertices[near, 2].max() < 2.2
    assert vertices[near, 2].min() > -1.5
    depth = vertices[near, 2] - ground.height_m(vertices[near, :2])
    assert np.quantile(depth, 0.001) > -0.35
    # Out to the horizon all around, and no sheet of water inland.
    assert np.hypot(*vertices[:, :2].T).max() > 3e4
    assert (ground.away_m(vertices[near, :2]) < 12).all()


def test_objects_stand_on_the_ground(world):
    for wanted in ("vehicle", "tree_trunk", "person"):
        parts = [part.vertices for (_, label), part in world.surfaces.items() if label == wanted]
        vertices = np.concatenate(parts)
        near = np.abs(vertices[:, :2]).max(axis=1) < 250
        away = world.ground_m.__self__.away_m(vertices[:, :2])
        vertices = vertices[near & (away > 8)]
        above = vertices[:, 2] - world.ground_m(vertices[:, :2])
        assert -3.0 < above.min() < 0.1, wanted
        assert above.max() < 40, wanted


def test_no_view_of_the_square_ends_in_a_void(world):
    """Land rises higher than a drone flies; the sea reaches the horizon where no land does."""
    parts = [
        part.vertices
        for (_, label), part in world.surfaces.items()
        if label in ("hill", "water", "ground")
    ]
    far = np.concatenate(parts)
    reach = np.hypot(far[:, 0], far[:, 1])
    far, reach = far[reach > 2500], reach[reach > 2500]
    azimuth = np.degrees(np.arctan2(far[:, 1], far[:, 0])) % 360
    for a in np.arange(2.5, 360, 5):
        sector = np.abs(azimuth - a) <= 2.5
        high = far[sector & (reach < 9500), 2].max(initial=0.0) > 75
        assert high or reach[sector].max() > 3e4, a


def test_scenes_differ_in_character():
    drawn = [draw_coastline(lane(seed, "character"), CoastlineRanges()) for seed in range(24)]
    assert len({coast.flora for coast in drawn}) == 4
    assert len({coast.stone.rock for coast in drawn}) > 20
    assert np.ptp([coast.cliff_height_m for coast in drawn]) > 20
    assert len({coast.has_pier for coast in drawn}) == 2


def test_woods_grow_inland_only():
    shore = shore_of(1)
    xy = grid(280.0, 90)
    s, t = shore.to_local(xy)
    beach = shore.look_up("beach_m", s) + shore.look_up("run_m", s)
    behind = shore.away_m(s, t) - beach
    woods = wooded(shore, s, t, behind)
    assert woods[behind < 15].max() == 0
    assert 0.02 < woods[behind > 60].mean() < 0.9
