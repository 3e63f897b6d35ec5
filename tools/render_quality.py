"""Noise and cost of the sample counts and denoisers, against Mitsuba's path tracer at 2,048 spp.

    python tools/render_quality.py --views 3 --json quality.json

References have paths of up to 8 segments, so that what a shorter path loses counts as error. PSNR
is taken on the 8-bit sRGB frames, after tone mapping; the last rows have next to no noise and show
the bias alone.
"""

import dataclasses
import json
import multiprocessing
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import tyro

from synthdepth.flight.clearance import Clearance
from synthdepth.maps.registry import build_world
from synthdepth.production.recipe import load_recipe
from synthdepth.production.shots import draw_flights
from synthdepth.render.backend import activate, choose
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import derive_seed

BATCH = 16


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        map: the map.
        seed: of the dataset whose first scene is looked at.
        views: frames, spread over the scene's first flights.
        threads: of the renderer.
        reference_spp: samples a pixel of the references.
        json: where the figures go.
    """

    map: str = "neighborhood"
    seed: int = 0
    views: int = 3
    threads: int = 2
    reference_spp: int = 2048
    json: Path | None = None


def psnr(image: np.ndarray, reference: np.ndarray) -> float:
    error = np.mean((image.astype(np.float64) - reference) ** 2)
    return float(10 * np.log10(255**2 / error))


def scene_and_poses(options: Options):
    """The first scene of the dataset in clear air, and one pose of each of its first flights."""
    recipe = load_recipe(options.map)
    scene_seed = derive_seed(options.seed, recipe.map, 0)
    clear = dataclasses.replace(recipe.light, conditions=("clear",))
    world = build_world(recipe.map, recipe.scene, clear, scene_seed)
    # Mitsuba's sky has no clouds, and haze is the same analytic factor in both: without them the
    # reference is Mitsuba's alone.
    light = dataclasses.replace(world.light, visibility_m=1e12, cloud_cover=0.0)
    world = dataclasses.replace(world, light=light)
    clearance = Clearance(world, max_altitude_m=recipe.flight.altitude_m[1])
    flights, _ = draw_flights(scene_seed, 256, clearance, recipe)
    flights = (flights * options.views)[: options.views]
    poses = [flight.state.world_from_cam[len(flight.time_s) // 2] for flight in flights]
    return world, poses, recipe.camera.intrinsics()


def references(options: Options) -> list[np.ndarray]:
    """Radiance by Mitsuba's own path tracer with the sun in its sky, (H, W, 3) a view."""
    activate(choose(), options.threads)
    import mitsuba as mi

    from synthdepth.render.atlas import pack
    from synthdepth.render.scene import build_scene, to_world
    from synthdepth.render.sky import sunsky

    world, poses, camera = scene_and_poses(options)
    sky = {"sky": sunsky(world.light, sun_scale=1.0)}
    scene = build_scene(world, camera, pack(world.materials), sky)
    params = mi.traverse(scene)
    path = mi.load_dict({"type": "path", "max_depth": 8})
    found = []
    for pose in poses:
        params["camera.to_world"] = to_world(pose)
        params.update()
        total = 0.0
        for seed in range(options.reference_spp // BATCH):
            image = mi.render(scene, integrator=path, spp=BATCH, seed=seed)
            total = total + np.nan_to_num(image.numpy(), posinf=0.0)
        found.append(total * BATCH / options.reference_spp)
        print(f"reference {len(found)} of {len(poses)} is done", flush=True)
    return found


def main(options: Options) -> None:
    # In a process of its own: a second scene would slow the first one's kernels.
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        truths = pool.submit(references, options).result()
    activate(choose(), options.threads)
    from synthdepth.render.colour import to_uint8
    from synthdepth.render.renderer import Renderer

    world, poses, camera = scene_and_poses(options)
    renderer = Renderer(world, camera, RenderSettings())
    rows = []
    for spp in (2, 4, 8):
        for mode in ("fast", "balanced", "high"):
            renderer.set_settings(RenderSettings(spp=spp, denoise=mode))
            renderer.rgb(poses[0], 0)  # compiles
            quality, spent = [], []
            for number, (pose, truth) in enumerate(zip(poses, truths, strict=True)):
                for repeat in range(3):
                    start = time.perf_counter()
                    image = renderer.rgb(pose, 100 * number + repeat)
                    spent.append(time.perf_counter() - start)
                    quality.append(psnr(image, to_uint8(truth, renderer.exposure)))
            row = {
                "spp": spp,
                "denoise": mode,
                "psnr_db": round(float(np.mean(quality)), 2),
                "psnr_worst_db": round(min(quality), 2),
                "ms": round(1e3 * float(np.median(spent)), 1),
            }
            rows.append(row)
            print("  ".join(f"{key} {value}" for key, value in row.items()), flush=True)
    # Bias alone: what is left when our own noise is averaged away.
    renderer.set_settings(RenderSettings(spp=BATCH, denoise="off"))
    for pose, truth in zip(poses, truths, strict=True):
        mean = np.mean([renderer.radiance(pose, seed) for seed in range(32)], axis=0)
        bias = psnr(to_uint8(mean, renderer.exposure), to_uint8(truth, renderer.exposure))
        rows.append({"spp": 32 * BATCH, "denoise": "off", "psnr_db": round(bias, 2)})
        print(rows[-1], flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
