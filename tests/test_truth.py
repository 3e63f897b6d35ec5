"""Labels, normals and optical flow on scenes whose answer is known."""

import numpy as np
import pytest

from synthdepth.camera import look_rotation, pose, project, unproject
from synthdepth.maps.geometry import box
from synthdepth.maps.world import LABELS
from synthdepth.render.settings import MODALITIES, RenderSettings
from tests.conftest import flat_world, ground

pytestmark = pytest.mark.usefixtures("backend")

PREV = pose(
    look_rotation(np.array([1.0, 0.04, 0.02]), np.array([0, 0, 1.0])), np.array([-1.0, 3.0, 5.0])
)
NOW = pose(look_rotation(np.array([1.0, 0.0, 0.0]), np.array([0, 0, 1.0])), np.array([0, 0, 5.0]))


@pytest.fixture(scope="module")
def view(camera):
    from synthdepth.render.renderer import Renderer

    tower = {("card", "building"): box((4, 4, 30), base=(10, 0, 0), tint=(0.5,) * 3)}
    return Renderer(flat_world([ground(), tower]), camera, RenderSettings(spp=1))


@pytest.fixture(scope="module")
def camera():
    from synthdepth.camera import Intrinsics

    return Intrinsics.from_fov(64, 48, 90.0)


@pytest.fixture(scope="module")
def truth(view):
    from synthdepth.render.truth import ground_truth

    return ground_truth(view, NOW, PREV, MODALITIES)


def test_labels_are_those_of_the_surfaces(truth, camera):
    assert truth.seg.dtype == np.uint8
    assert set(np.unique(truth.seg)) == {0, LABELS["ground"], LABELS["building"]}
    np.testing.assert_array_equal(truth.seg == 0, ~np.isfinite(truth.depth_m))
    height_m = 5 - camera.rays()[..., 1] * truth.depth_m
    assert np.abs(height_m[truth.seg == LABELS["ground"]]).max() < 1e-2


def test_depth_does_not_depend_on_what_else_is_asked_for(view, truth):
    np.testing.assert_array_equal(view.planar_depth(NOW), truth.depth_m)


def test_normals_are_in_camera_axes_and_face_the_camera(truth, camera):
    np.testing.assert_allclose(
        truth.normal[truth.seg == LABELS["ground"]],
        [[0, -1, 0]] * (truth.seg == 1).sum(),
        atol=1e-5,
    )
    front = (truth.seg == LABELS["building"]) & (truth.depth_m < 8.01)
    np.testing.assert_allclose(truth.normal[front], [[0, 0, -1]] * front.sum(), atol=1e-5)
    assert (np.einsum("hwc,hwc->hw", truth.normal, camera.rays()) <= 0).all()
    assert (truth.normal[truth.seg == 0] == 0).all()


def test_flow_is_what_depth_and_poses_say(truth, camera):
    hit = np.isfinite(truth.depth_m)
    place = unproject(np.where(hit, truth.depth_m, 1.0), camera, NOW)
    was, _ = project(place, camera, PREV)
    v, u = np.mgrid[:48, :64]
    error = truth.flow - (was - np.stack([u, v], axis=-1))
    assert np.abs(error[hit]).max() < 0.01


def test_only_turning_moves_the_sky(truth, camera):
    sky = ~np.isfinite(truth.depth_m)
    turned = PREV.copy()
    turned[:3, 3] = NOW[:3, 3]
    far = unproject(np.full(sky.shape, 1e9), camera, NOW)
    was, _ = project(far, camera, turned)
    v, u = np.mgrid[:48, :64]
    np.testing.assert_allclose(truth.flow[sky], (was - np.stack([u, v], axis=-1))[sky], atol=1e-3)


def test_what_the_tower_hid_and_what_was_out_of_the_picture_is_not_visible(view, truth, camera):
    v, u = np.mgrid[:48, :64]
    was = truth.flow + np.stack([u, v], axis=-1)
    outside = (was < -0.5).any(-1) | (was[..., 0] > 63.5) | (was[..., 1] > 47.5)
    assert outside.any()
    assert not truth.visible[outside].any()
    # Where the place is inside the earlier picture, its depth there decides.
    earlier = view.planar_depth(PREV)
    hit = np.isfinite(truth.depth_m) & ~outside
    place = unproject(np.where(hit, truth.depth_m, 1.0), camera, NOW)
    _, z = project(place, camera, PREV)
    column, row = (np.clip(np.round(was[..., k]).astype(int), 0, [63, 47][k]) for k in (0, 1))
    behind = z > 1.5 * earlier[row, column]
    hidden = hit & behind & (truth.seg == LABELS["ground"])
    hidden &= (truth.seg == LABELS["ground"]) & (z < 150)
    assert hidden.sum() >= 8
    assert truth.visible[hidden].mean() < 0.3  # rounding to a pixel may look past the edge
    seen = hit & (np.abs(z - earlier[row, column]) < 0.02 * z)
    assert truth.visible[seen].mean() > 0.97
