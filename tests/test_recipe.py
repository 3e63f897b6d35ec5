"""Recipes and the command line's changes to them: what is allowed, and one line where it is not."""

import dataclasses
import json

import pytest

from synthdepth.errors import RecipeError
from synthdepth.production.overrides import with_overrides
from synthdepth.production.recipe import load_recipe, recipe_from_table, shipped_recipes


def test_every_shipped_recipe_loads_and_survives_the_manifest():
    assert "neighborhood" in shipped_recipes()
    for name in shipped_recipes():
        recipe = load_recipe(name)
        stored = json.loads(json.dumps(recipe.as_dict()))
        assert recipe_from_table(stored, "dataset.json") == recipe


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("map = 'atlantis'", "map = 'atlantis': allowed are blocks, city, coastline"),
        ("map = 'neighborhood'\nfog = 1", "fog is unknown: allowed are map, scene, light"),
        (
            "map = 'neighborhood'\n[flight]\nspeed = 1",
            "[flight] speed is unknown: allowed are max_",
        ),
        (
            "map = 'neighborhood'\n[flight]\nspeed_mps = [9, 2]",
            "[flight] speed_mps = [9, 2]: allowed are two numbers [from, to] with 0.1 <= from",
        ),
        ("map = 'neighborhood'\n[flight]\nspeed_mps = [2, 40]", "allowed is up to max_speed_mps"),
        ("map = 'neighborhood'\n[flight]\nmax_draws = 2.5", "max_draws = 2.5: allowed is a whole"),
        (
            "map = 'neighborhood'\n[light]\nturbidity = 'high'",
            "[light] turbidity = 'high': allowed",
        ),
        ("map = 'neighborhood'\n[light]\nturbidity = [1, inf]", "turbidity = [1, inf]: allowed"),
        (
            "map = 'neighborhood'\n[scene]\nparked_share = [0, 1.1]",
            "[scene] parked_share = [0, 1.1]",
        ),
        ("map = 'neighborhood'\n[render]\nspp = 3", "[render] spp = 3: allowed are the powers of"),
        ("map = 'neighborhood'\n[render]\nspp = true", "spp = True: allowed is a whole number"),
        ("map = 'neighborhood'\n[render]\ndenoise = 'best'", "denoise = 'best': allowed are off"),
        ("map = 'neighborhood'\n[camera]\nwidth = 0", "[camera] width = 0: allowed is a whole"),
        ("map = 'neighborhood'\n[sampling]\npairs_per_flight = 900", "the shortest flight"),
        ("map = 'neighborhood'\nlight = 3", "[light] is 3: allowed is a table"),
        ("map = ", "is not valid TOML"),
    ],
)
def test_a_malformed_recipe_is_one_line(tmp_path, text, complaint):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(RecipeError) as caught:
        load_recipe(str(path))
    message = str(caught.value)
    assert complaint in message
    assert "mine.toml" in message
    assert "\n" not in message


def test_unknown_maps_are_answered_with_the_known_ones(tmp_path):
    with pytest.raises(RecipeError, match="--map moon is unknown: the maps are blocks, city"):
        load_recipe("moon")
    with pytest.raises(RecipeError, match="does not exist"):
        load_recipe(str(tmp_path / "none.toml"))


def test_overrides_replace_what_was_given_only():
    recipe = load_recipe("neighborhood")
    assert with_overrides(recipe) == recipe
    changed = with_overrides(recipe, size="320x200", max_depth_m=150.0, spp=8, pairs_per_scene=64)
    assert (changed.camera.width, changed.camera.height) == (320, 200)
    assert changed.camera.intrinsics().fov_deg == pytest.approx(90)
    assert (changed.render.max_depth_m, changed.render.spp) == (150, 8)
    assert changed.sampling == dataclasses.replace(recipe.sampling, pairs_per_scene=64)


def test_camera_presets_are_the_cameras_that_users_know(tmp_path):
    recipe = load_recipe("neighborhood")
    kitti = with_overrides(recipe, camera="kitti").camera.intrinsics()
    assert (kitti.width, kitti.height) == (1242, 375)
    assert kitti.matrix[0].tolist() == [721.5377, 0, 609.5593]
    airsim = with_overrides(recipe, camera="airsim").camera.intrinsics()
    assert (airsim.width, airsim.height, airsim.fx) == (256, 144, pytest.approx(128))
    mine = tmp_path / "mine.toml"
    mine.write_text("width = 64\nheight = 32\nfov_deg = 60\n")
    assert with_overrides(recipe, camera=str(mine)).camera.fov_deg == 60


@pytest.mark.parametrize(
    ("override", "complaint"),
    [
        ({"size": "256"}, "--size 256: allowed is WIDTHxHEIGHT"),
        ({"size": "0x0"}, "--size 0x0: width = 0: allowed"),
        ({"size": "99999x2"}, "--size 99999x2: width = 99999: allowed"),
        ({"camera": "gopro"}, "--camera gopro is unknown: allowed are airsim, kitti"),
        ({"camera": "none.toml"}, "--camera none.toml cannot be read"),
        ({"spp": 5}, "--spp: spp = 5: allowed are the powers of two"),
        ({"max_depth_m": -1.0}, "--max-depth-m: max_depth_m = -1.0: allowed"),
    ],
)
def test_a_wrong_override_names_the_option(override, complaint):
    with pytest.raises(RecipeError, match=complaint.replace("(", r"\(")):
        with_overrides(load_recipe("neighborhood"), **override)
