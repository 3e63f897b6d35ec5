"""The renderer's physics, on worlds whose answer is known."""

import numpy as np
import pytest

from synthdepth.camera import Intrinsics, look_rotation, pose
from synthdepth.dataset.pair import saturate
from synthdepth.maps.geometry import box
from synthdepth.maps.world import Material
from synthdepth.render.colour import linear_to_srgb, tone_map
from synthdepth.render.settings import RenderSettings
from tests.conftest import flat_world, ground, wall

pytestmark = pytest.mark.usefixtures("backend")

AHEAD = pose(look_rotation(np.array([1.0, 0, 0]), np.array([0, 0, 1.0])), np.array([0, 0, 5.0]))


def renderer(models, camera, spp=16, denoise="off", **light):
    from synthdepth.render.renderer import Renderer

    return Renderer(flat_world(models, **light), camera, RenderSettings(spp=spp, denoise=denoise))


def test_a_wall_at_50_m_reads_50_m_everywhere(camera):
    depth = renderer([wall(50.0)], camera).planar_depth(AHEAD)
    # Planar depth: the corners of the picture too, though their rays are longer.
    np.testing.assert_allclose(depth, 50.0, rtol=1e-6)


def test_depth_saturates_beyond_the_range_and_in_the_sky(camera):
    view = renderer([ground(), wall(230.0, half_m=20)], camera)
    depth = saturate(view.planar_depth(AHEAD), 200.0)
    assert depth.dtype == np.float32
    assert depth[0].tolist() == [200.0] * 64  # sky
    assert depth[24, 32] == 200.0  # the wall
    assert depth.max() == 200.0
    # Ground 5 m below, seen through row v: z = 5 f / (v - cy).
    v = np.arange(30, 48)
    np.testing.assert_allclose(depth[30:, 10], 5 * camera.fx / (v - camera.cy), rtol=1e-4)


def test_colour_edges_lie_where_depth_edges_lie():
    # An off-centre camera: a mistake in the principal point shifts the one against the other.
    camera = Intrinsics(width=80, height=60, fx=50.0, fy=50.0, cx=31.0, cy=37.0)
    white = {("card", "building"): box((4, 4, 6), base=(20, 2, 0), tint=(0.9,) * 3)}
    view = renderer([ground(0.02), white], camera, spp=64)
    depth = view.planar_depth(AHEAD)
    # The box's side as well as its front: all that is nearer than the ground behind it.
    rays = camera.rays()
    height_m = 5 - rays[..., 1] * np.where(np.isfinite(depth), depth, 1e6)
    on_box = np.isfinite(depth) & (height_m > 0.01)
    seen = view.rgb(AHEAD, 1).mean(-1)
    bright = seen > (seen[on_box].mean() + seen[~on_box & np.isfinite(depth)].mean()) / 2
    below_sky = np.isfinite(depth) & (rays[..., 1] > 0)
    wrong = (bright != on_box) & below_sky
    assert wrong.sum() <= 0.01 * below_sky.sum()


def test_a_white_card_in_the_sun_has_the_level_that_exposure_aims_at(camera):
    down = pose(
        look_rotation(np.array([0.01, 0, -1]), np.array([0, 0, 1.0])), np.array([0, 0, 5.0])
    )
    view = renderer([ground(1.0)], camera, spp=64)
    linear = view.radiance(down, 3) * view.exposure
    assert np.median(linear.mean(-1)) == pytest.approx(1.7, rel=0.05)


def test_a_grey_card_reflects_its_reflectance(camera):
    down = pose(
        look_rotation(np.array([0.01, 0, -1]), np.array([0, 0, 1.0])), np.array([0, 0, 5.0])
    )
    white = renderer([ground(0.8)], camera, spp=64).radiance(down, 3)
    grey = renderer([ground(0.2)], camera, spp=64).radiance(down, 4)
    assert np.mean(grey) / np.mean(white) == pytest.approx(0.25, rel=0.03)


def test_tint_multiplies_the_texture(camera):
    half = Material(texture=np.full((4, 4, 3), 188, np.uint8))  # sRGB 188 is 0.503 linear
    model = {("half", "ground"): ground(0.4)[("card", "ground")]}
    down = pose(
        look_rotation(np.array([0.01, 0, -1]), np.array([0, 0, 1.0])), np.array([0, 0, 5.0])
    )
    both = renderer([model], camera, spp=64, materials={"half": half}).radiance(down, 3)
    plain = renderer([ground(0.4)], camera, spp=64).radiance(down, 4)
    assert np.mean(both) / np.mean(plain) == pytest.approx(0.503, rel=0.03)


def test_haze_takes_contrast_as_koschmieder_says(camera):
    """Contrast against the horizon falls as exp(-3.912 d / V)."""

    def black_minus_air(distance_m):
        view = renderer([wall(distance_m, 0.0)], camera, spp=16, visibility_m=1000.0)
        return np.mean(view.radiance(AHEAD, 1)[20:28, 30:34])

    near, middle, far = (black_minus_air(d) for d in (1.0, 250.0, 5000.0))
    assert near < 0.03 * far
    assert 1 - middle / far == pytest.approx(np.exp(-3.912 * 0.25), rel=0.05)


def test_ground_truth_ignores_haze(camera):
    clear = renderer([wall(50.0)], camera).planar_depth(AHEAD)
    fog = renderer([wall(50.0)], camera, visibility_m=60.0).planar_depth(AHEAD)
    np.testing.assert_array_equal(clear, fog)


def test_a_frame_is_a_function_of_pose_and_seed(camera):
    view = renderer([ground(), wall(50.0, half_m=10)], camera, spp=4, denoise="fast")
    other = renderer([ground(), wall(50.0, half_m=10)], camera, spp=4, denoise="fast")
    first = view.rgb(AHEAD, 7)
    moved = AHEAD.copy()
    moved[2, 3] += 1
    assert not np.array_equal(view.rgb(moved, 7), first)
    assert not np.array_equal(view.rgb(AHEAD, 8), first)
    np.testing.assert_array_equal(view.rgb(AHEAD, 7), first)
    np.testing.assert_array_equal(other.rgb(AHEAD, 7), first)


def test_denoising_brings_a_frame_nearer_to_the_converged_one(camera):
    models = [ground(), {("card", "building"): box((6, 6, 6), base=(20, 0, 0), tint=(0.5,) * 3)}]
    truth = renderer(models, camera, spp=1024).radiance(AHEAD, 1)
    noisy = renderer(models, camera, spp=4).radiance(AHEAD, 2)
    clean = renderer(models, camera, spp=4, denoise="fast").radiance(AHEAD, 2)

    def error(image):
        return np.mean((tone_map(image, 3.0) - tone_map(truth, 3.0)) ** 2)

    assert error(clean) < 0.7 * error(noisy)


def test_tone_curve_is_linear_then_rolls_off_to_one():
    x = np.linspace(0, 0.6, 50)
    np.testing.assert_allclose(tone_map(x, 1.0), x, atol=1e-7)
    y = tone_map(np.linspace(0, 20, 4000), 1.0)
    assert (np.diff(y) >= 0).all()
    assert y[-1] <= 1
    assert tone_map(np.array([-0.1]), 1.0)[0] == 0
    assert linear_to_srgb(np.array([0.18]))[0] == pytest.approx(0.4613, abs=1e-3)
