"""Camera conventions and random lanes."""

import numpy as np
import pytest

from synthdepth.camera import Intrinsics, look_rotation, pitch_roll_deg, pose, project, unproject
from synthdepth.seeding import derive_seed, lane


def test_principal_point_of_a_symmetric_camera_is_the_middle_of_the_pixel_centres():
    camera = Intrinsics.from_fov(256, 144, 90.0)
    assert (camera.cx, camera.cy) == (127.5, 71.5)
    assert camera.fx == pytest.approx(128.0)
    assert camera.fov_deg == pytest.approx(90.0)


def test_projection_inverts_unprojection():
    rng = lane(1, "test")
    camera = Intrinsics(width=17, height=11, fx=12.0, fy=12.0, cx=7.3, cy=5.9)
    view = pose(
        look_rotation(np.array([1.0, 2.0, -0.4]), np.array([0, 0, 1.0])), rng.normal(size=3)
    )
    depth = rng.uniform(1, 200, (11, 17))
    uv, z = project(unproject(depth, camera, view), camera, view)
    columns, rows = np.meshgrid(np.arange(17), np.arange(11))
    np.testing.assert_allclose(z, depth, rtol=1e-12)
    np.testing.assert_allclose(uv, np.stack([columns, rows], -1), atol=1e-9)


def test_points_behind_the_camera_have_no_pixel():
    camera = Intrinsics.from_fov(8, 8, 90.0)
    uv, z = project(np.array([[0.0, 0, -1], [0, 0, 1]]), camera, np.eye(4))
    assert np.isnan(uv[0]).all()
    assert z.tolist() == [-1, 1]


def test_looking_north_has_east_on_the_right_and_the_ground_below():
    rotation = look_rotation(np.array([0.0, 1, 0]), np.array([0, 0, 1.0]))
    np.testing.assert_allclose(rotation[:, 0], [1, 0, 0], atol=1e-15)
    np.testing.assert_allclose(rotation[:, 1], [0, 0, -1], atol=1e-15)
    assert np.linalg.det(rotation) == pytest.approx(1)


def test_pitch_looks_up_and_roll_leans_right():
    up = look_rotation(np.array([1.0, 0, 1]), np.array([0, 0, 1.0]))
    assert pitch_roll_deg(pose(up, np.zeros(3))) == pytest.approx((45.0, 0.0))
    c, s = np.cos(0.1), np.sin(0.1)
    level = look_rotation(np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))
    leaning = level @ np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    assert pitch_roll_deg(pose(leaning, np.zeros(3)))[1] == pytest.approx(np.degrees(0.1))


def test_lanes_repeat_and_do_not_touch_each_other():
    first = lane(0, "flight", 3).random(4)
    np.testing.assert_array_equal(first, lane(0, "flight", 3).random(4))
    for other in (lane(0, "flight", 4), lane(0, "trees", 3), lane(1, "flight", 3)):
        assert not np.array_equal(first, other.random(4))


def test_child_seeds_survive_doubles_and_differ():
    seeds = [derive_seed(0, "neighborhood", scene) for scene in range(2000)]
    assert all(int(float(seed)) == seed for seed in seeds)
    assert len(set(seeds)) == len(seeds)
