"""Noise and cost of the sample counts and denoisers, against frames of 2,048 samples a pixel.

    python tools/render_quality.py --views 3 --json quality.json

References have paths of up to 8 segments, so that what a shorter path loses counts as error. PSNR
is taken on the 8-bit sRGB frames, after tone mapping.
"""

import dataclasses
import json
import time
from pathlib import Path

import numpy as np
import tyro

from synthdepth.flight.clearance import Clearance
from synthdepth.maps.registry import build_world
from synthdepth.production.recipe import load_recipe
from synthdepth.production.shard_job import draw_flights
from synthdepth.render.backend import activate, choose
from synthdepth.render.colour import to_uint8
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import derive_seed

REFERENCE_SPP, BATCH = 2048, 16


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        map: the map.
        seed: of the dataset whose first scene is looked at.
        views: frames, spread over the scene's first flights.
        threads: of the renderer.
        json: where the figures go.
    """

    map: str = "neighborhood"
    seed: int = 0
    views: int = 3
    threads: int = 2
    json: Path | None = None


def psnr(image: np.ndarray, reference: np.ndarray) -> float:
    error = np.mean((image.astype(np.float64) - reference) ** 2)
    return float(10 * np.log10(255**2 / error))


def main(options: Options) -> None:
    activate(choose(), options.threads)
    from synthdepth.render.renderer import Renderer

    recipe = load_recipe(options.map)
    scene_seed = derive_seed(options.seed, recipe.map, 0)
    world = build_world(recipe.map, recipe.scene, recipe.light, scene_seed)
    clearance = Clearance(world, max_altitude_m=recipe.flight.altitude_m[1])
    flights, _ = draw_flights(scene_seed, 256, clearance, recipe)
    flights = (flights * options.views)[: options.views]
    poses = [flight.state.world_from_cam[len(flight.time_s) // 2] for flight in flights]
    camera = recipe.camera.intrinsics()
    best = RenderSettings(spp=BATCH, path_depth=8, denoise="off")
    renderer = Renderer(world, camera, best)
    references = []
    for pose in poses:
        frames = [renderer.radiance(pose, 10_000 + i) for i in range(REFERENCE_SPP // BATCH)]
        references.append(to_uint8(np.mean(frames, axis=0), renderer.exposure))
        print(f"reference {len(references)} of {len(poses)} is done", flush=True)

    rows = []
    for depth in (3, 4):
        for spp in (2, 4, 8):
            for mode in ("fast", "balanced", "high"):
                settings = RenderSettings(spp=spp, path_depth=depth, denoise=mode)
                renderer.set_settings(settings)
                renderer.rgb(poses[0], 0)  # compiles
                quality, spent = [], []
                for number, (pose, reference) in enumerate(zip(poses, references, strict=True)):
                    for repeat in range(3):
                        start = time.perf_counter()
                        image = renderer.rgb(pose, 100 * number + repeat)
                        spent.append(time.perf_counter() - start)
                        quality.append(psnr(image, reference))
                row = {
                    "path_depth": depth,
                    "spp": spp,
                    "denoise": mode,
                    "psnr_db": round(float(np.mean(quality)), 2),
                    "psnr_worst_db": round(min(quality), 2),
                    "ms": round(1e3 * float(np.median(spent)), 1),
                }
                rows.append(row)
                print("  ".join(f"{key} {value}" for key, value in row.items()), flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
