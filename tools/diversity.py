"""Are the scenes of a map different places, and cheap enough to build? Figures without a camera.

    python tools/diversity.py --map neighborhood --scenes 100 --workers 2 --json diversity.json

Builds the first `--scenes` worlds of a dataset's seed, in batches, each in a fresh process; the
first few batches hold one scene only, so that their peak memory is that scene's. Of every scene,
within the flight area:

* of each label the area of its surfaces, and how that area is spread over height above ground;
* the layout: a raster of 32 x 32 cells by label, with the share of the cell that the label's
  surface would cover (0..1, capped). It sums areas at triangle centroids; triangles longer than
  half a cell are split first. The ground is left out: it is what remains, and lies under everything
  on some maps;
* the light; build time, triangles and peak memory, held against `LIMITS`.

The distance between two layouts is sum |a - b| / sum (a + b) over labels and cells: 0 for the same
and 1 for nothing in common; the least of it over one's 8 rotations and mirror images.

No two scenes are alike when the smallest distance between two scenes is above the threshold: the
largest distance between a scene and itself moved by half a cell along both axes (6.25 m each of a
flight area of 400 m, about the width of a street). Such a copy shows the same place to anyone, so
what lies closer together may be one place. A copy moved by more than a cell is not found.
"""

import argparse
import collections
import itertools
import json
import multiprocessing
import resource
import sys
import time
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from synthdepth.console import progress_bar
from synthdepth.dataset.shard import write_whole
from synthdepth.errors import SynthdepthError
from synthdepth.maps.registry import build_world
from synthdepth.maps.world import LABELS, World
from synthdepth.production.recipe import Recipe, load_recipe
from synthdepth.seeding import derive_seed

CELLS = 32
JITTER_CELLS = 0.5
LAYOUT_LABELS = [name for name in LABELS if name not in ("sky", "ground")]
HEIGHTS_M = (-np.inf, 0.5, 2.0, 5.0, 10.0, 20.0, 40.0, 80.0, np.inf)
LIGHT_NUMBERS = ("sun_azimuth_deg", "sun_elevation_deg", "visibility_m")
# Processor time as well: a busy machine does not stretch it.
LIMITS = {"build_s": 10.0, "build_cpu_s": 10.0, "triangles": 5e6, "peak_memory_gb": 2.0}
MEMORY_SCENES = 4
BATCH_SCENES = 8


def triangle_areas(triangles: np.ndarray) -> np.ndarray:
    """Areas (n,) [m2] of triangles (n, 3, 3) [m]."""
    sides = triangles[:, 1:] - triangles[:, :1]
    return np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1) / 2


def split(triangles: np.ndarray, longest_m: float, area_m: np.ndarray) -> np.ndarray:
    """The triangles (n, 3, 3) [m] that touch an area, cut in four until none is too long.

    Args:
        triangles: (m, 3, 3) [m].
        longest_m: what a triangle may span along x and along y.
        area_m: (2, 2) lower and upper corner of the area in x and y [m].
    """
    done = [triangles[:0]]
    while len(triangles):
        xy = triangles[..., :2]
        low, high = xy.min(axis=1), xy.max(axis=1)
        touches = ((high >= area_m[0]) & (low <= area_m[1])).all(axis=1)
        small = (high - low).max(axis=1) <= longest_m
        done.append(triangles[touches & small])
        a, b, c = triangles[touches & ~small].transpose(1, 0, 2)
        ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
        quarters = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        triangles = np.concatenate([np.stack(corners, axis=1) for corners in quarters])
    return np.concatenate(done)


def surface_points(world: World) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Small pieces of surface by label: centroids (n, 3) [m] and areas (n,) [m2]."""
    # A cell beyond the flight area as well, for the copy that is moved.
    cell_m = np.ptp(world.flight_bounds, axis=0) / CELLS
    area_m = world.flight_bounds + [-cell_m, cell_m]
    found: dict[str, list] = {}
    for (_, label), part in world.surfaces.items():
        pieces = split(part.triangles, cell_m.min() / 2, area_m)
        found.setdefault(label, []).append((pieces.mean(axis=1), triangle_areas(pieces)))
    return {
        label: tuple(np.concatenate(arrays) for arrays in zip(*parts, strict=True))
        for label, parts in sorted(found.items())
    }


def layout(points: Mapping, bounds_m: np.ndarray, offset_cells: float = 0.0) -> np.ndarray:
    """The raster of a scene: (labels, 32, 32) float32, share of each cell that a label covers.

    Args:
        points: from `surface_points`.
        bounds_m: (2, 2) lower and upper corner of the flight area [m].
        offset_cells: how far the scene is moved along x and y.
    """
    cell_m = np.ptp(bounds_m, axis=0) / CELLS
    raster = np.zeros((len(LAYOUT_LABELS), CELLS, CELLS))
    edges = [np.arange(CELLS + 1)] * 2
    for label, (where, area) in points.items():
        if label in LAYOUT_LABELS:
            place = (where[:, :2] - bounds_m[0]) / cell_m + offset_cells
            cells = np.histogram2d(*place.T, bins=edges, weights=area)[0]
            raster[LAYOUT_LABELS.index(label)] = cells
    return np.minimum(raster / cell_m.prod(), 1).astype(np.float32)


def symmetries(raster: np.ndarray) -> Iterator[np.ndarray]:
    """The 8 rotations and mirror images of a raster (labels, n, n)."""
    for image in (raster, raster[:, ::-1]):
        for turns in range(4):
            yield np.rot90(image, turns, axes=(1, 2))


def plain_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Bray-Curtis distance of two rasters, 0 (the same) to 1 (nothing in common)."""
    return float(np.abs(a - b).sum() / max(a.sum() + b.sum(), 1e-9))


def layout_distance(a: np.ndarray, b: np.ndarray) -> float:
    """Distance of two rasters (labels, n, n), however one is turned or mirrored."""
    return min(plain_distance(a, image) for image in symmetries(b))


def label_figures(world: World, points: Mapping) -> dict[str, dict]:
    """Area [m2] of each label in the flight area, and its spread over `HEIGHTS_M` above ground."""
    figures = {}
    for label, (where, area) in points.items():
        xy = where[:, :2]
        inside = ((xy >= world.flight_bounds[0]) & (xy < world.flight_bounds[1])).all(axis=1)
        height = where[inside, 2] - world.ground_m(xy[inside])
        spread = np.histogram(height, bins=HEIGHTS_M, weights=area[inside])[0]
        shares = (spread / max(spread.sum(), 1e-9)).round(4).tolist()
        figures[label] = {"area_m2": round(float(spread.sum()), 1), "height_shares": shares}
    return figures


def measure_scene(recipe: Recipe, scene_seed: int) -> tuple[dict, np.ndarray]:
    """Builds one scene: its figures and its layout raster."""
    wall, cpu = time.perf_counter(), time.process_time()
    world = build_world(recipe.map, recipe.scene, recipe.light, scene_seed)
    figures = {
        "scene_seed": scene_seed,
        "build_s": round(time.perf_counter() - wall, 2),
        "build_cpu_s": round(time.process_time() - cpu, 2),
        "triangles": world.triangle_count,
        # Linux gives kilobytes: the most that this process has taken so far.
        "peak_memory_gb": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1.024e-6, 3),
    }
    points = surface_points(world)
    raster = layout(points, world.flight_bounds)
    moved = layout(points, world.flight_bounds, JITTER_CELLS)
    figures["jitter_distance"] = plain_distance(raster, moved)
    figures |= {name: getattr(world.light, name) for name in ("condition", *LIGHT_NUMBERS)}
    figures["labels"] = label_figures(world, points)
    return figures, raster


def measure_batch(map_name: str, scene_seeds: list[int]) -> list[tuple[dict, np.ndarray]]:
    """The scenes of a batch; runs in a process of its own."""
    recipe = load_recipe(map_name)
    found = [measure_scene(recipe, scene_seed) for scene_seed in scene_seeds]
    for figures, _ in found if len(found) > 1 else ():
        del figures["peak_memory_gb"]  # That of the largest scene so far.
    return found


def measure(map_name: str, scene_seeds: list[int], workers: int) -> tuple[list[dict], np.ndarray]:
    """Figures of all scenes, and their rasters (scenes, labels, 32, 32)."""
    rest = scene_seeds[MEMORY_SCENES:]
    batches = [[seed] for seed in scene_seeds[:MEMORY_SCENES]]
    batches += [rest[n : n + BATCH_SCENES] for n in range(0, len(rest), BATCH_SCENES)]
    # This process stays small: a child's peak memory would begin with its parent's.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, max_tasks_per_child=1)
    found = []
    with pool, progress_bar("building", "scenes") as progress:
        for future in [pool.submit(measure_batch, map_name, b) for b in batches]:
            found += future.result()
            progress(len(found), len(scene_seeds))
    return [figures for figures, _ in found], np.stack([raster for _, raster in found])


def layout_report(rasters: np.ndarray, threshold: float) -> dict:
    """The distances of every two scenes, from rasters (scenes, labels, n, n), and the verdict."""
    pairs = list(itertools.combinations(range(len(rasters)), 2))
    distances = np.array([layout_distance(rasters[i], rasters[j]) for i, j in pairs])
    return {
        "same_scene": layout_distance(rasters[0], rasters[0]),
        "threshold": threshold,
        "smallest": float(distances.min()),
        "median": float(np.median(distances)),
        "largest": float(distances.max()),
        "nearest_scenes": pairs[int(distances.argmin())],
        "no_two_alike": bool(distances.min() > threshold),
    }


def cost_report(scenes: list[dict]) -> dict:
    """Median and largest cost of the scenes, beside the limits; a cost over its limit fails."""
    report = {}
    for name, limit in LIMITS.items():
        values = [scene[name] for scene in scenes if name in scene]
        found = {"median": float(np.median(values)), "max": float(max(values)), "limit": limit}
        report[name] = found | {"scenes": len(values), "within_limit": found["max"] <= limit}
    return report


def label_report(scenes: list[dict]) -> dict[str, dict]:
    """Area [m2] of each label: median, least and most of the scenes; and its mean heights."""
    report = {}
    for label in sorted({label for scene in scenes for label in scene["labels"]}):
        there = [scene["labels"][label] for scene in scenes if label in scene["labels"]]
        areas = [figures["area_m2"] for figures in there] + [0.0] * (len(scenes) - len(there))
        report[label] = {
            "area_m2": [float(np.median(areas)), min(areas), max(areas)],
            "height_shares": np.mean([f["height_shares"] for f in there], axis=0).tolist(),
        }
    return report


def light_report(scenes: list[dict]) -> dict:
    """Scenes of each condition, and the lowest and highest of the light's numbers."""
    values = {name: [scene[name] for scene in scenes] for name in ("condition", *LIGHT_NUMBERS)}
    values = {name: [scene[name] for scene in scenes] for name in ("condition", *LIGHT_NUMBERS)}
    ranges = {name: [round(m(values[name]), 1) for m in (min, max)] for name in LIGHT_NUMBERS}
    return {"conditions": dict(collections.Counter(values["condition"]))} | ranges


def text(report: dict) -> str:
    """The report for people."""
    lines = [f"{report['map']}: {len(report['scenes'])} scenes"]
    for name, cost in report["cost"].items():
        mark = "" if cost["within_limit"] else "  OVER THE LIMIT"
        figures = f"median {cost['median']:.10g}, max {cost['max']:.10g}, limit {cost['limit']:g}"
        lines.append(f"  {name}: {figures} ({cost['scenes']} scenes){mark}")
    found = report["layout"]
    figures = ", ".join(f"{n} {d:.3f}" for n, d in found.items() if isinstance(d, float))
    verdict = "no two alike" if found["no_two_alike"] else "SOME ARE ALIKE"
    lines.append(f"  layout distance: {figures}: {verdict} (nearest {found['nearest_scenes']})")
    lines += [f"  {name}: {value}" for name, value in report["light"].items()]
    edges = "".join(f"{edge:6g}" for edge in HEIGHTS_M[1:-1])
    lines.append(f"  {'':18}{'median area [m2] (range)':36}{edges}  more: % by height, up to [m]")
    for label, row in report["labels"].items():
        area = "{:8.0f} ({:.0f} to {:.0f})".format(*row["area_m2"])
        spread = "".join(f"{100 * share:6.1f}" for share in row["height_shares"])
        lines.append(f"  {label:18}{area:36}{spread}")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--map", required=True, help="a map, or a recipe file (.toml)")
    parser.add_argument("--scenes", type=int, default=100, help="how many, from 2")
    parser.add_argument("--seed", type=int, default=0, help="of the dataset")
    parser.add_argument("--workers", type=int, default=2, help="processes at once")
    parser.add_argument("--json", type=Path, metavar="FILE", help="where the figures go")
    options = parser.parse_args(arguments)
    try:
        for name, least in (("scenes", 2), ("seed", 0), ("workers", 1)):
            if (given := getattr(options, name)) < least:
                raise SynthdepthError(f"--{name} {given}: allowed is a number from {least}")
        if options.json and not options.json.parent.is_dir():
            raise SynthdepthError(f"--json {options.json}: its folder does not exist")
        map_name = load_recipe(options.map).map
        seeds = [derive_seed(options.seed, map_name, index) for index in range(options.scenes)]
        scenes, rasters = measure(options.map, seeds, options.workers)
        report = {
            "map": map_name,
            "cost": cost_report(scenes),
            "layout": layout_report(rasters, max(scene["jitter_distance"] for scene in scenes)),
            "light": light_report(scenes),
            "labels": label_report(scenes),
            "scenes": scenes,
        }
        print(text(report))
        if options.json:
            write_whole(options.json, json.dumps(report, indent=1).encode() + b"\n")
    except SynthdepthError as error:
        print(f"diversity: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
