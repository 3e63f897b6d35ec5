"""The command line's changes to a recipe."""

import dataclasses
import re
from pathlib import Path

from synthdepth.airsim.settings import camera_from_settings
from synthdepth.config import parse_toml
from synthdepth.errors import DatasetError, RecipeError
from synthdepth.production.recipe import CAMERAS, CameraRecipe, Recipe


def with_overrides(
    recipe: Recipe,
    *,
    size: str | None = None,
    camera: str | None = None,
    max_depth_m: float | None = None,
    spp: int | None = None,
    pairs_per_scene: int | None = None,
    pairs_per_flight: int | None = None,
    burst_pairs: int | None = None,
    modalities: tuple[str, ...] | None = None,
    conditions: tuple[str, ...] | None = None,
    sensor: str | None = None,
) -> Recipe:
    """A recipe with what the user gave instead; what is None stays as it is.

    Args:
        recipe: the recipe.
        size: "WIDTHxHEIGHT" in pixels; keeps the field of view.
        camera: a name of `CAMERAS`, a TOML file with the keys of `CameraRecipe`, or AirSim's
            settings.json.
        max_depth_m: where the depth saturates.
        spp: samples a pixel.
        pairs_per_scene: pairs of one shard.
        pairs_per_flight: pairs of one flight.
        burst_pairs: pairs of consecutive frames in a row.
        modalities: ground truth beside the depth.
        conditions: what the scenes' light is drawn from.
        sensor: "drawn" or "ideal".

    Raises:
        RecipeError: a value is not allowed; the message names the option.
    """
    if camera is not None:
        recipe = dataclasses.replace(recipe, camera=_camera(camera))
    if size is not None:
        recipe = dataclasses.replace(recipe, camera=_resized(recipe.camera, size))
    if sensor is not None:
        faults = _replaced(recipe.sensor, {"model": sensor}, {"model": "sensor"})
        recipe = dataclasses.replace(recipe, sensor=faults)
    light = _replaced(recipe.light, {"conditions": conditions})
    render = _replaced(
        recipe.render, {"max_depth_m": max_depth_m, "spp": spp, "modalities": modalities}
    )
    given = {
        "pairs_per_scene": pairs_per_scene,
        "pairs_per_flight": pairs_per_flight,
        "burst_pairs": burst_pairs,
    }
    sampling = _replaced(recipe.sampling, given)
    return dataclasses.replace(recipe, light=light, render=render, sampling=sampling)


def _replaced(config, given: dict, options: dict | None = None):
    for name, value in given.items():
        if value is not None:
            try:
                config = dataclasses.replace(config, **{name: value})
            except RecipeError as error:
                option = (options or {}).get(name, name).replace("_", "-")
                raise RecipeError(f"--{option}: {error}") from None
    return config


def _resized(camera: CameraRecipe, size: str) -> CameraRecipe:
    found = re.fullmatch(r"(\d{1,5})x(\d{1,5})", size)
    if not found:
        raise RecipeError(f"--size {size}: allowed is WIDTHxHEIGHT in pixels, e.g. 256x256")
    fov_deg = camera.intrinsics().fov_deg
    try:
        return CameraRecipe(width=int(found[1]), height=int(found[2]), fov_deg=fov_deg)
    except RecipeError as error:
        raise RecipeError(f"--size {size}: {error}") from None


def _camera(name_or_file: str) -> CameraRecipe:
    if name_or_file in CAMERAS:
        return CAMERAS[name_or_file]
    path = Path(name_or_file)
    if path.suffix == ".json":
        return _airsim_camera(path)
    if path.suffix != ".toml":
        raise RecipeError(
            f"--camera {name_or_file} is unknown: allowed are {', '.join(CAMERAS)}, a .toml file, "
            "or AirSim's settings.json"
        )
    try:
        table = parse_toml(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise RecipeError(f"--camera {path} cannot be read: {error}") from None
    return CameraRecipe.from_table(table, path.name)


def _airsim_camera(path: Path) -> CameraRecipe:
    try:
        camera = camera_from_settings(path)
        return CameraRecipe(width=camera.width, height=camera.height, fov_deg=camera.fov_deg)
    except (DatasetError, RecipeError) as error:
        raise RecipeError(f"--camera {path.name}: {error}") from None
