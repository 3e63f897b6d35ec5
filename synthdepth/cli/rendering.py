"""Commands that make datasets and worlds, and what they need."""

import contextlib
import dataclasses
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from synthdepth.console import progress_bar, say, write_json
from synthdepth.errors import SynthdepthError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Render:
    """Render a dataset: pairs of frames with 200 m depth, in shards.

    Stopped in any way, the same command goes on where it was; with more --pairs it extends the
    dataset without rendering anything again.
    """

    map: str
    """Which map (see `synthdepth maps`), or a recipe file of your own (.toml)."""
    pairs: int
    """How many pairs the dataset shall hold."""
    out: str | None = None
    """Folder of the dataset, or an address such as s3://bucket/folder; data/<map>-seed<seed> by
    default."""
    seed: int = 0
    """Everything is drawn from it."""
    size: str | None = None
    """Image size, e.g. 256x256; the recipe's by default."""
    camera: str | None = None
    """airsim, kitti, a .toml file with the keys of a recipe's [camera], or AirSim's
    settings.json."""
    max_depth_m: float | None = None
    """Where the depth saturates; the recipe's by default."""
    spp: int | None = None
    """Samples a pixel, a power of two; the recipe's by default."""
    pairs_per_scene: int | None = None
    """Pairs of one scene, which is one shard; the recipe's by default."""
    pairs_per_flight: int | None = None
    """Pairs of one flight; the recipe's by default."""
    burst_pairs: int | None = None
    """Pairs of consecutive frames in a row; 1 sets all pairs apart, at twice the cost."""
    modalities: tuple[str, ...] | None = None
    """Ground truth beside the depth: any of flow seg normal; the recipe's by default."""
    conditions: tuple[str, ...] | None = None
    """Light and weather that scenes draw from: any of clear golden_hour overcast haze fog wet
    night; the recipe's by default."""
    sensor: Literal["drawn", "ideal"] | None = None
    """Whether frames show a real camera's faults; ground truth never does."""
    train_share: float = 0.5
    """Share of the scenes that goes to the split train; the others go to test."""
    workers: int | None = None
    """Processes at once; by default one a core."""
    executor: Literal["local", "ray"] = "local"
    """Processes of this machine, or of a Ray cluster, whose nodes must all reach --out."""
    ray_address: str | None = None
    """The cluster's address; by default the cluster that this machine belongs to."""
    variant: Literal["cuda", "llvm", "scalar"] | None = None
    """How Mitsuba computes; by default the best that works here."""
    json: Path | None = None
    """Write the run's figures to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.production.overrides import with_overrides
        from synthdepth.production.recipe import load_recipe
        from synthdepth.production.run import render_dataset

        recipe = with_overrides(
            load_recipe(self.map),
            size=self.size,
            camera=self.camera,
            max_depth_m=self.max_depth_m,
            spp=self.spp,
            pairs_per_scene=self.pairs_per_scene,
            pairs_per_flight=self.pairs_per_flight,
            burst_pairs=self.burst_pairs,
            modalities=self.modalities,
            conditions=self.conditions,
            sensor=self.sensor,
        )
        out = self.out or f"data/{Path(self.map).stem}-seed{self.seed}"
        try:
            with _terminable(), progress_bar("rendering", "pairs") as progress:
                report = render_dataset(
                    recipe,
                    out,
                    pairs=self.pairs,
                    seed=self.seed,
                    train_share=self.train_share,
                    workers=self.workers,
                    variant=self.variant,
                    executor=self.executor,
                    ray_address=self.ray_address,
                    on_progress=progress,
                    on_restart=lambda event: say(
                        f"a worker {event.why}: its shard begins again, {event.workers} at once"
                    ),
                    on_backend=lambda backend: say(
                        f"renders with {backend.name}: {backend.reason}"
                    ),
                )
        except KeyboardInterrupt as stop:
            say(f"\nstopped: finished shards in {out} are safe; the same command goes on")
            return 128 + (stop.args[0] if stop.args else signal.SIGINT)
        speed = report.rendered / report.wall_s
        say(
            f"{out}: {report.pairs} pairs, {report.rendered} of them rendered now in "
            f"{report.wall_s:.0f} s ({speed:.2f} pairs/s, {100 * report.render_share:.0f} % of "
            "the workers' time in rendering)"
        )
        write_json(self.json, dataclasses.asdict(report) | {"pairs_per_s": speed})
        return 0


@contextlib.contextmanager
def _terminable() -> Iterator[None]:
    """SIGTERM, by which systems end programs, stops what is under way as Ctrl-C does."""

    def stop(number, _) -> None:
        raise KeyboardInterrupt(number)

    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Maps:
    """List the maps."""

    json: Path | None = None
    """Write the list to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.maps.registry import MAPS
        from synthdepth.production.recipe import load_recipe, shipped_recipes

        rows = {
            name: {"map": load_recipe(name).map, "recipe": str(path)}
            for name, path in shipped_recipes().items()
        }
        for name, row in rows.items():
            row["summary"] = MAPS[row["map"]].summary
            say(f"{name:16s} {row['summary']}\n{'':16s} {row['recipe']}")
        write_json(self.json, rows)
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Scene:
    """Write one generated world as glTF, for any 3D viewer."""

    map: str
    """Which map, or a recipe file."""
    seed: int
    """The scene's seed: `scene_seed` of a pair's meta.json rebuilds that pair's scene."""
    out: Path = Path("scene.glb")
    """The file to write."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.maps.gltf import check_glb_path, write_glb
        from synthdepth.maps.registry import build_world
        from synthdepth.production.recipe import load_recipe

        if not 0 <= self.seed < 2**63:
            raise SynthdepthError(f"--seed {self.seed}: allowed is a whole number from 0 to 2^63-1")
        check_glb_path(self.out)
        recipe = load_recipe(self.map)
        world = build_world(recipe.map, recipe.scene, recipe.light, self.seed)
        size = write_glb(world, self.out)
        say(f"{self.out}: {world.triangle_count} triangles, {size / 1e6:.0f} MB")
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Doctor:
    """Say what this machine has for rendering, and what to do about what is missing."""

    json: Path | None = None
    """Write the findings to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.render.doctor import examine

        findings = examine()
        for finding in findings:
            say(f"{'ok ' if finding.ok else 'NO '} {finding.name:10s} {finding.text}")
        write_json(self.json, [dataclasses.asdict(finding) for finding in findings])
        return 0
