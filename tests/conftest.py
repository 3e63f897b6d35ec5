"""Shared by the tests: a renderer, worlds small enough to reason about, and a small dataset."""

import dataclasses

import numpy as np
import pytest

from synthdepth.camera import Intrinsics
from synthdepth.maps.geometry import quads
from synthdepth.maps.world import Light, Material, World, assemble
from synthdepth.production.overrides import with_overrides
from synthdepth.production.recipe import load_recipe
from synthdepth.production.run import render_dataset
from synthdepth.render.settings import MODALITIES

PAIRS, SIZE = 6, "112x96"


@pytest.fixture(scope="session")
def backend():
    """The best variant that works here, active in this process."""
    from synthdepth.render.backend import activate, choose

    chosen = choose()
    activate(chosen)
    return chosen


@pytest.fixture(scope="session")
def camera():
    """64 x 48 pixels, 90 degrees."""
    return Intrinsics.from_fov(64, 48, 90.0)


def flat_world(models, *, materials=None, visibility_m=1e6, sun_elevation_deg=40.0) -> World:
    """A world of plain materials: `card` is neutral, the tint is the reflectance."""
    plain = {"card": Material(texture=np.full((2, 2, 3), 255, np.uint8))}
    light = Light(
        condition="clear",
        sun_azimuth_deg=200.0,
        sun_elevation_deg=sun_elevation_deg,
        turbidity=3.0,
        visibility_m=visibility_m,
    )
    materials = plain | (materials or {})
    return World(
        map="test",
        scene_seed=0,
        surfaces=assemble(models),
        materials=materials,
        light=light,
        flight_bounds=np.array([[-100.0, -100.0], [100.0, 100.0]]),
        ground_m=lambda xy: np.zeros(len(xy)),
    )


def ground(reflectance=0.18, half_m=5000.0):
    """A flat ground at z = 0."""
    c = half_m
    corners = [[[-c, -c, 0], [c, -c, 0], [c, c, 0], [-c, c, 0]]]
    return {("card", "ground"): quads(corners, (reflectance,) * 3)}


def wall(x_m, reflectance=0.5, half_m=60.0):
    """A wall across the x axis at `x_m`, facing the origin, reaching below and above it."""
    c = half_m
    corners = [[[x_m, c, -c], [x_m, -c, -c], [x_m, -c, c], [x_m, c, c]]]
    return {("card", "building"): quads(corners, (reflectance,) * 3)}


def recipe(size=SIZE):
    """Two scenes of four pairs, on a small flight area."""
    small = load_recipe("blocks")
    scene = dataclasses.replace(small.scene, flight_area_m=200.0)
    return with_overrides(
        dataclasses.replace(small, scene=scene),
        size=size,
        pairs_per_scene=4,
        pairs_per_flight=2,
        burst_pairs=2,
        modalities=MODALITIES,
        conditions=("clear", "overcast"),
    )


@pytest.fixture(scope="session")
def dataset(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data") / "set"
    report = render_dataset(recipe(), folder, pairs=PAIRS, workers=2)
    assert (report.pairs, report.rendered) == (PAIRS, PAIRS)
    return folder
