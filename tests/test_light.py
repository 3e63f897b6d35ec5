"""Conditions of light and weather: what is drawn, and what they do to a world and its sky."""

import dataclasses

import numpy as np
import pytest

from synthdepth.camera import look_rotation, pose
from synthdepth.maps.geometry import box, quads
from synthdepth.maps.light import LightRanges, draw_light
from synthdepth.maps.materials.catalogue import bake_materials
from synthdepth.maps.weather import weathered
from synthdepth.maps.world import CONDITIONS, Material
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import lane
from tests.conftest import flat_world, ground
from tests.lights import CLEAR

DOWN = pose(look_rotation(np.array([0.01, 0, -1]), np.array([0, 0, 1.0])), np.array([0, 0, 5.0]))
AHEAD = pose(look_rotation(np.array([1.0, 0, 0]), np.array([0, 0, 1.0])), np.array([0, 0, 5.0]))


def drawn(condition, seed=0):
    return draw_light(lane(seed, "light"), LightRanges(conditions=(condition,)))


def lit(world, light):
    return dataclasses.replace(world, light=light)


@pytest.mark.parametrize("condition", CONDITIONS)
def test_a_light_lies_within_its_ranges(condition):
    ranges = LightRanges()
    for seed in range(40):
        light = drawn(condition, seed)
        assert light.condition == condition
        assert light.lamps_on == (condition == "night")
        assert (light.wetness > 0) == (condition == "wet")
        low, high = {"haze": ranges.haze_visibility_m, "fog": ranges.fog_visibility_m}.get(
            condition, ranges.visibility_m
        )
        assert low <= light.visibility_m <= high
        if condition == "golden_hour":
            assert light.sun_elevation_deg <= ranges.golden_elevation_deg[1]


def test_a_condition_that_stands_twice_is_drawn_twice_as_often():
    ranges = LightRanges(conditions=("clear", "night", "clear"))
    nights = sum(draw_light(lane(s, "light"), ranges).lamps_on for s in range(900))
    assert 900 / 3 - 60 < nights < 900 / 3 + 60


@pytest.mark.usefixtures("backend")
class TestSky:
    def test_the_picture_holds_the_irradiance_that_is_stated(self):
        from synthdepth.render.sky import direction_grid, make_sky

        toward = direction_grid()
        solid = np.pi / 255 * 2 * np.pi / 512 * np.hypot(toward[..., 0], toward[..., 1])
        for condition in CONDITIONS:
            sky = make_sky(drawn(condition))
            falls = np.where(toward[..., 2] > 0, solid * toward[..., 2], 0)
            np.testing.assert_allclose(
                np.einsum("hw,hwc->c", falls, sky.image), sky.irradiance, rtol=1e-3
            )
            assert np.isfinite(sky.image).all()
            assert sky.image.min() >= 0

    def test_the_environment_shows_the_picture_the_right_way_up(self):
        import drjit as dr
        import mitsuba as mi

        from synthdepth.render.scene import sky_emitter
        from synthdepth.render.sky import direction_grid, make_sky

        sky = make_sky(drawn("golden_hour"))
        emitter = mi.load_dict(sky_emitter(sky))
        rows, columns = np.array([20, 60, 100, 120, 126]), np.array([5, 130, 250, 400, 509])
        toward = direction_grid()[rows, columns]
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wi = mi.Vector3f(*np.ascontiguousarray(-toward.T, np.float32))
        np.testing.assert_allclose(
            emitter.eval(si).numpy().T, sky.image[rows, columns], rtol=2e-2, atol=1e-6
        )

    def test_clouds_hide_the_sun_and_an_overcast_sky_is_three_times_brighter_above(self):
        from synthdepth.render.sky import make_sky

        sky = make_sky(drawn("overcast"))
        assert sky.beam.max() == 0
        brightness = sky.image.mean(axis=(1, 2))
        # CIE S 011: the zenith has three times the luminance of the horizon.
        assert brightness[:6].mean() / brightness[124:127].mean() == pytest.approx(3, rel=0.15)
        assert make_sky(drawn("clear")).beam.min() > 0

    def test_a_low_sun_is_red(self):
        from synthdepth.render.sky import make_sky

        high = make_sky(dataclasses.replace(CLEAR, sun_elevation_deg=60.0)).beam
        low = make_sky(dataclasses.replace(CLEAR, sun_elevation_deg=4.0)).beam
        assert low[0] / low[2] > 3 * high[0] / high[2]
        assert low.sum() < 0.5 * high.sum()


def street():
    """A road, a house with windows on four sides, and a lamp over the road."""
    panes = [[[30, y, z], [30, y + 1, z], [30, y + 1, z + 1], [30, y, z + 1]]
             for y in range(-20, 20, 2) for z in range(1, 13, 2)]  # fmt: skip
    lamp = quads(
        [[[-0.2, 0.2, 6], [0.2, 0.2, 6], [0.2, -0.2, 6], [-0.2, -0.2, 6]]], (0.6, 0.5, 0.4)
    )
    models = [
        {("asphalt", "road"): ground(1.0, half_m=60)[("card", "ground")]},
        {("card", "building"): box((10, 44, 14), base=(36, 0, 0), tint=(0.4,) * 3)},
        {("glass", "building"): quads(panes)},
        {("lamp", "pole"): lamp},
    ]
    return flat_world(models, materials=bake_materials(lane(0, "m"), ["asphalt", "glass", "lamp"]))


def test_night_lights_some_rooms_and_loses_no_pane():
    world = lit(street(), drawn("night"))
    night = weathered(world)
    dark = len(night.surfaces["glass", "building"].faces)
    shining = len(night.surfaces["lit_window", "building"].faces)
    assert dark + shining == len(world.surfaces["glass", "building"].faces)
    assert 0 < shining < dark + shining
    # A pane is lit whole: faces come in twos.
    assert shining % 2 == 0
    again = weathered(world)
    for key, part in night.surfaces.items():
        assert part.vertices.tobytes() == again.surfaces[key].vertices.tobytes()


def test_rain_darkens_and_glosses_the_ground_and_leaves_puddles():
    wet = weathered(lit(street(), drawn("wet")))
    dry = bake_materials(lane(0, "m"), ["asphalt"])["asphalt"]
    road = wet.materials["wet asphalt"]
    assert road.kind == "plastic"
    assert road.texture.mean() < 0.95 * dry.texture.mean()
    assert ("asphalt", "road") not in wet.surfaces
    puddles = wet.surfaces["glass", "water"]
    assert 0.003 < puddles.vertices[:, 2].min() <= puddles.vertices[:, 2].max() < 0.02
    assert {label for _, label in wet.surfaces} >= {"road", "building", "water"}


def test_a_dry_day_changes_nothing():
    world = street()
    assert weathered(world).surfaces.keys() == world.surfaces.keys()


@pytest.mark.usefixtures("backend")
class TestNight:
    def view(self, world, camera, spp=256):
        from synthdepth.render.renderer import Renderer

        return Renderer(world, camera, RenderSettings(spp=spp, denoise="off"))

    def test_a_lamp_lights_the_ground_as_the_inverse_square_law_says(self, camera):
        from synthdepth.render.sky import LUX

        side_m, luminance = 0.2, 20_000.0
        lamp = quads([[[-0.1, 0.1, 6], [0.1, 0.1, 6], [0.1, -0.1, 6], [-0.1, -0.1, 6]]])
        white = np.full((4, 4, 3), 255, np.uint8)
        materials = {"lamp": Material(texture=white, luminance_cdm2=luminance)}
        dark = dataclasses.replace(drawn("night"), cloud_cover=0.0, visibility_m=1e9)
        world = lit(flat_world([ground(0.5), {("lamp", "pole"): lamp}], materials=materials), dark)
        with_lamp = self.view(world, camera).radiance(DOWN, 1)
        without = self.view(lit(flat_world([ground(0.5)]), dark), camera).radiance(DOWN, 1)
        middle = (with_lamp - without)[22:26, 30:34].mean()
        # Intensity L A at 6 m, straight down, on a Lambertian ground.
        expected = luminance * side_m**2 / 36 * 0.5 / np.pi * LUX
        assert middle == pytest.approx(expected, rel=0.05)

    def test_lit_windows_are_seen_and_lamps_are_not_needed_for_it(self, camera):
        world = street()
        surfaces = {key: part for key, part in world.surfaces.items() if key[0] != "lamp"}
        world = weathered(lit(dataclasses.replace(world, surfaces=surfaces), drawn("night")))
        view = self.view(world, camera, spp=16)
        level = (view.radiance(AHEAD, 1) * view.exposure).max(axis=-1)
        assert np.quantile(level, 0.999) > 5 * np.median(level)


@pytest.mark.usefixtures("backend")
def test_ground_truth_is_the_same_in_every_light(camera):
    from synthdepth.render.renderer import Renderer

    truths = []
    for condition in ("clear", "fog", "overcast", "night"):
        world = lit(street(), drawn(condition))
        hit = Renderer(world, camera, RenderSettings(spp=1)).surfels(AHEAD)
        truths.append((hit.depth_m.tobytes(), hit.label.tobytes(), hit.normal.tobytes()))
    assert len(set(truths)) == 1


@pytest.mark.usefixtures("backend")
@pytest.mark.parametrize("condition", ["overcast", "fog", "wet", "night"])
def test_a_frame_is_the_same_twice_in_every_light(camera, condition):
    from synthdepth.render.renderer import Renderer

    world = weathered(lit(street(), drawn(condition)))
    first, second = (Renderer(world, camera, RenderSettings(spp=4)).rgb(AHEAD, 7) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert first.std() > 3
