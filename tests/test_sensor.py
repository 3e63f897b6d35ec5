"""The sensor model against its equations, and motion blur against geometry."""

import dataclasses

import numpy as np
import pytest

from synthdepth.camera import look_rotation, pose
from synthdepth.maps.geometry import box
from synthdepth.render.colour import to_uint8
from synthdepth.render.sensor import IDEAL, Motion, SensorRanges, draw_sensor, expose
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import lane
from tests.conftest import flat_world

AHEAD = pose(look_rotation(np.array([1.0, 0, 0]), np.array([0, 0, 1.0])), np.array([0, 0, 5.0]))


def linear(image):
    x = image / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def grey(level=0.3, shape=(96, 128)):
    return np.full((*shape, 3), level, np.float32)


def test_an_ideal_sensor_only_encodes():
    image = np.random.default_rng(0).random((20, 30, 3), np.float32) * 2
    np.testing.assert_array_equal(expose(lane(0), image, 0.7, IDEAL), to_uint8(image, 0.7))


def test_noise_follows_the_photon_transfer_curve():
    """Variance = signal / electrons + (read noise / electrons)^2."""
    sensor = dataclasses.replace(IDEAL, electrons=400.0, read_noise=6.0)
    for level in (0.1, 0.3, 0.5):
        seen = linear(expose(lane(1), grey(level), 1.0, sensor))
        assert seen.mean() == pytest.approx(level, rel=0.02)
        assert seen.var() == pytest.approx(level / 400 + (6 / 400) ** 2, rel=0.06)


def test_corners_lose_the_light_that_vignetting_says():
    sensor = dataclasses.replace(IDEAL, vignetting=0.4)
    seen = linear(expose(lane(1), grey(), 1.0, sensor))
    assert seen[0, 0, 0] / seen[48, 64, 0] == pytest.approx(0.6, abs=0.02)


def test_the_noise_is_the_frames_own_and_repeats():
    sensor = draw_sensor(lane(3), SensorRanges(), at_night=False)
    one, again, other = (expose(lane(k), grey(), 1.0, sensor) for k in (5, 5, 6))
    np.testing.assert_array_equal(one, again)
    assert (one != other).any()


def test_jpeg_costs_little_at_high_quality_and_more_at_low():
    smooth = np.linspace(0, 0.8, 64, dtype=np.float32)[:, None, None] * np.ones((64, 64, 3), "f4")
    smooth[20:40, 20:40] *= 0.3

    def loss(quality):
        got = expose(lane(0), smooth, 1.0, dataclasses.replace(IDEAL, jpeg_quality=quality))
        return np.abs(got.astype(float) - to_uint8(smooth, 1.0)).mean()

    assert 0 < loss(98) < 1.0
    assert loss(20) > 2 * loss(98)


def test_a_picture_style_deepens_contrast_and_colour_and_keeps_greys_grey():
    ramp = np.linspace(0, 0.6, 256, dtype=np.float32)[None, :, None] * np.ones((8, 256, 3), "f4")
    flat = expose(lane(0), ramp, 1.0, IDEAL).astype(int)
    styled = expose(lane(0), ramp, 1.0, dataclasses.replace(IDEAL, contrast=0.4)).astype(int)
    assert (styled == styled[..., :1]).all()
    assert (np.diff(styled[0, :, 0]) >= 0).all()
    middle = np.abs(flat[0, :, 0] - 127.5) < 12
    slope = np.polyfit(flat[0, middle, 0], styled[0, middle, 0], 1)[0]
    assert slope == pytest.approx(1.4, abs=0.05)

    colour = np.full((4, 4, 3), [0.3, 0.2, 0.1], np.float32)
    vivid = linear(expose(lane(0), colour, 1.0, dataclasses.replace(IDEAL, saturation=1.5)))
    luminance = [0.2126, 0.7152, 0.0722]
    assert vivid[0, 0] @ luminance == pytest.approx(colour[0, 0] @ luminance, rel=0.02)
    assert np.ptp(vivid[0, 0]) == pytest.approx(1.5 * 0.2, rel=0.02)


def test_nights_are_noisier_and_longer():
    ranges = SensorRanges()
    for seed in range(20):
        day, night = (draw_sensor(lane(seed), ranges, at_night=dark) for dark in (False, True))
        assert night.electrons < day.electrons
        assert night.shutter_s >= day.shutter_s
        assert ranges.shutter_s[0] <= day.shutter_s <= ranges.shutter_s[1]
    ideal = SensorRanges(model="ideal")
    assert draw_sensor(lane(0), ideal, at_night=True) == IDEAL


@pytest.mark.usefixtures("backend")
class TestBlur:
    def frame(self, camera, motion, seed=1):
        from synthdepth.render.renderer import Renderer

        bar = {("card", "pole"): box((0.02, 1.0, 20), base=(20, 0, -5), tint=(0.9,) * 3)}
        wall = {("card", "building"): box((1, 90, 90), base=(40, 0, -40), tint=(0.02,) * 3)}
        world = flat_world([bar, wall], sun_elevation_deg=20.0)
        view = Renderer(world, camera, RenderSettings(spp=256, denoise="off"))
        return view.radiance(AHEAD, seed, motion).mean(axis=(0, 2))

    def test_a_shift_widens_what_is_near_by_the_path_over_the_depth(self, camera):
        still = self.frame(camera, None)
        moved = self.frame(camera, Motion(np.array([0, 2.0, 0]), np.zeros(3)))
        u = np.arange(camera.width)

        def spread(row):
            weight = np.clip(row - np.median(row), 0, None)
            middle = (u * weight).sum() / weight.sum()
            return middle, ((u - middle) ** 2 * weight).sum() / weight.sum()

        (before, narrow), (after, wide) = spread(still), spread(moved)
        # Uniform over f * 2 m / 20 m pixels: variance width^2 / 12 on top; the middle stays.
        width = camera.fx * 2.0 / 20
        assert wide - narrow == pytest.approx(width**2 / 12, rel=0.15)
        assert after == pytest.approx(before, abs=0.15)

    def test_turning_blurs_too(self, camera):
        still = self.frame(camera, None)
        turned = self.frame(camera, Motion(np.zeros(3), np.array([0, 0, 0.1])))
        assert turned.max() < 0.7 * still.max()
