"""Depth from flow and motion: exact where the flow is, honest where there is no parallax."""

import dataclasses

import numpy as np
import pytest

from synthdepth.camera import Intrinsics, look_rotation, pose
from synthdepth.errors import SynthdepthError
from synthdepth.flow import flow_from_depth
from synthdepth.flow.triangulate import (
    NO_NOISE,
    MotionNoise,
    measured_motion,
    relative_motion,
    triangulate,
)
from synthdepth.seeding import lane
from tests.made import CAMERA, view

UP = np.array([0, 0, 1.0])


def poses(move, turn_rad=0.02, height_m=6.0):
    before = pose(look_rotation(np.array([1.0, 0.1, -0.1]), UP), np.array([0, 0, height_m]))
    heading = np.array([np.cos(0.1 + turn_rad), np.sin(0.1 + turn_rad), -0.13])
    return before, pose(look_rotation(heading, UP), np.array([0, 0, height_m]) + move)


@pytest.mark.parametrize("move", [(0.9, 0, 0), (0.4, 0.5, 0.1), (0, 1.0, 0), (-0.5, 0, 0.4)])
def test_true_flow_gives_true_depth_wherever_there_is_parallax(move):
    before, now = poses(np.array(move))
    _, depth_m, far_m, *_ = view(CAMERA, now, 200.0)
    flow = flow_from_depth(np.where(np.isinf(far_m), 1e9, far_m), CAMERA, now, before)
    got, confidence = triangulate(flow, CAMERA, relative_motion(now, before))
    sure = confidence > 0.2
    assert sure.mean() > 0.2
    np.testing.assert_allclose(got[sure], depth_m[sure], rtol=2e-3)
    # The sky has no parallax: it is at the range, and nothing is claimed of it.
    sky = np.isinf(far_m)
    assert confidence[sky].max() < 1e-3
    np.testing.assert_allclose(got[sky], 200.0, rtol=0.2)


def test_confidence_says_how_far_off_noisy_flow_leaves_the_depth():
    before, now = poses(np.array([0.8, 0.2, 0.0]))
    camera = Intrinsics.from_fov(256, 192, 90.0)
    _, _, far_m, *_ = view(camera, now, 200.0)
    flow = flow_from_depth(np.where(np.isinf(far_m), 1e9, far_m), camera, now, before)
    noisy = flow + lane(0).normal(0, 0.5, flow.shape).astype(np.float32)
    got, confidence = triangulate(noisy, camera, relative_motion(now, before))
    near = far_m < 200
    error = np.where(near, np.abs(got / np.where(near, far_m, 1) - 1), 0)
    bands = [(0.3, 0.7), (0.7, 0.95), (0.95, 1.01)]
    typical = [
        np.median(error[near & (low <= confidence) & (confidence < high)]) for low, high in bands
    ]
    assert typical[0] > typical[1] > typical[2]
    assert typical[2] < 0.12


def test_flow_beside_the_epipolar_line_is_not_believed():
    before, now = poses(np.array([0.9, 0, 0]))
    _, _, far_m, *_ = view(CAMERA, now, 200.0)
    flow = flow_from_depth(np.where(np.isinf(far_m), 1e9, far_m), CAMERA, now, before)
    motion = relative_motion(now, before)
    _, right = triangulate(flow, CAMERA, motion)
    _, wrong = triangulate(flow[..., ::-1].copy() * [-4, 4] + 3, CAMERA, motion)
    sure = right > 0.9
    assert np.median(wrong[sure]) < 0.1


def test_standing_still_nothing_is_claimed():
    before, now = poses(np.zeros(3))
    depth_m, confidence = triangulate(
        np.zeros((CAMERA.height, CAMERA.width, 2), np.float32), CAMERA, relative_motion(now, before)
    )
    assert np.isfinite(depth_m).all()
    assert confidence.max() < 1e-3


def test_the_measured_motion_is_a_motion_as_wrong_as_its_noise_says():
    motion = relative_motion(*poses(np.array([0.9, 0.3, 0])))
    np.testing.assert_array_equal(measured_motion(lane(0), motion, 0.1, NO_NOISE), motion)
    noise = MotionNoise(rotation_deg=0.2, velocity_mps=0.3, velocity_share=0.0)
    drawn = [measured_motion(lane(k), motion, 0.1, noise) for k in range(400)]
    turned = np.array([(m @ np.linalg.inv(motion))[:3, :3] for m in drawn])
    np.testing.assert_allclose(
        turned @ turned.transpose(0, 2, 1), np.broadcast_to(np.eye(3), turned.shape), atol=1e-12
    )
    assert np.rad2deg(turned[:, 1, 0].std()) == pytest.approx(0.2, rel=0.15)
    moved = np.array([m[:3, 3] - motion[:3, 3] for m in drawn])
    np.testing.assert_allclose(moved.std(axis=0), 0.03, rtol=0.15)
    scaled = dataclasses.replace(NO_NOISE, velocity_share=0.1)
    lengths = [
        np.linalg.norm(measured_motion(lane(k), motion, 0.1, scaled)[:3, 3]) for k in range(400)
    ]
    assert np.std(lengths) == pytest.approx(0.1 * np.linalg.norm(motion[:3, 3]), rel=0.15)


def test_a_flow_of_another_size_is_refused():
    with pytest.raises(SynthdepthError, match="allowed is"):
        triangulate(np.zeros((4, 4, 2), np.float32), CAMERA, np.eye(4))
