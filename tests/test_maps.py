"""What holds for every map: a place, true to scale, the same for its seed, its depth true."""

import dataclasses
import hashlib

import numpy as np
import pytest

from synthdepth.camera import Intrinsics
from synthdepth.dataset.pair import saturate
from synthdepth.flight.clearance import Clearance
from synthdepth.flight.flight import draw_flight
from synthdepth.maps.registry import MAPS, build_world
from synthdepth.production.recipe import load_recipe, shipped_recipes
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import lane
from tests.raycast import Recaster

# Each map under another condition; ground truth is the same in all of them (test_light.py).
CASES = {
    "blocks": "fog",
    "city": "night",
    "coastline": "wet",
    "neighborhood": "golden_hour",
    "soccer_field": "overcast",
}
SEED = 7
CAMERA = Intrinsics.from_fov(96, 72, 90.0)


def built(map_name, seed=SEED):
    recipe = load_recipe(map_name)
    light = dataclasses.replace(recipe.light, conditions=(CASES[map_name],))
    scene = dataclasses.replace(recipe.scene, flight_area_m=200.0)
    return build_world(map_name, scene, light, seed)


def digest(world):
    total = hashlib.sha256()
    for key, part in world.surfaces.items():
        total.update(str(key).encode())
        for array in (part.vertices, part.faces, part.uv, part.tint):
            total.update(array.tobytes())
    for name, material in world.materials.items():
        total.update(name.encode() + material.texture.tobytes())
    return total.hexdigest()


def test_every_map_has_a_recipe_of_its_name():
    assert set(MAPS) == set(CASES) == set(shipped_recipes())
    for name in MAPS:
        recipe = load_recipe(name)
        assert recipe.map == name
        # The recipe shows every range that there is, at its default.
        assert recipe.scene == MAPS[name].ranges()


@pytest.fixture(scope="module", params=sorted(CASES))
def world(request):
    return built(request.param)


@pytest.fixture(scope="module")
def caster(world):
    return Recaster(world)


def test_a_seed_builds_the_same_place_again(world):
    assert digest(built(world.map)) == digest(world)


def test_the_place_is_whole(world):
    assert 2e5 < world.triangle_count < 5e6
    low, high = (
        np.min([part.vertices.min(axis=0) for part in world.surfaces.values()], axis=0),
        np.max([part.vertices.max(axis=0) for part in world.surfaces.values()], axis=0),
    )
    # Land or sea to the horizon on all sides, and no mountain.
    assert (low[:2] < -2500).all()
    assert (high[:2] > 2500).all()
    assert high[2] < 900
    assert world.light.condition == CASES[world.map]
    for (material, _), part in world.surfaces.items():
        assert material in world.materials
        assert np.isfinite(part.vertices).all()
        assert np.isfinite(part.uv).all()
        assert part.tint.min() >= 0
        assert part.tint.max() <= 4
        assert part.faces.max() < len(part.vertices)


def test_no_ground_is_missing_and_things_stand_on_it(world, caster):
    """`ground_m` is where the triangles are, within what kerbs, waves and floors make of it."""
    rng = np.random.default_rng(0)
    low, high = world.flight_bounds
    places = rng.uniform(low, high, (400, 2))
    origins = np.column_stack([places, world.ground_m(places) + 300.0])
    down = np.broadcast_to([0.0, 0.0, -1.0], origins.shape)
    assert (caster.caster.intersects_first(origins, down) >= 0).all()
    up = origins * [1, 1, 0] + np.column_stack([0 * places, world.ground_m(places) - 2.5])
    found = caster.caster.intersects_first(up, -down)
    floor = caster.mesh.triangles[found][:, :, 2].min(axis=1)
    assert (found >= 0).mean() > 0.97
    gap = floor - world.ground_m(places)
    assert np.mean(np.abs(gap[found >= 0]) < 1.2) > 0.9


@pytest.mark.usefixtures("backend")
def test_flights_see_the_depth_that_an_independent_ray_caster_sees(world, caster):
    from synthdepth.render.renderer import load_world

    recipe = load_recipe(world.map)
    clearance = Clearance(world, max_altitude_m=recipe.flight.altitude_m[1])
    limits = dataclasses.replace(recipe.flight, distance_m=(40, 120))
    flights = [draw_flight(lane(SEED, "flight", k), clearance, limits) for k in range(3)]
    view = load_world(world, CAMERA, RenderSettings(spp=1))
    for flight in flights:
        pose = flight.state.world_from_cam[len(flight.time_s) // 2]
        depth_m = saturate(view.planar_depth(pose), 200.0)
        meta = {"width": 96, "height": 72, "intrinsics": CAMERA.matrix, "max_depth_m": 200.0}
        meta["world_from_cam"] = pose
        seen = Pixels(depth_m, meta)
        differ, on_no_edge = caster.differing(seen)
        # Rounding decides on which side of a blade of grass a ray passes, and nothing else.
        assert differ <= 1e-3 * depth_m.size
        assert on_no_edge == 0
        assert (depth_m < 200).mean() > 0.15
        assert view.rgb(pose, 1).std() > 4


@dataclasses.dataclass
class Pixels:
    """As much of a pair as `Recaster` looks at."""

    depth_m: np.ndarray
    meta: dict
