"""The commands that fly: collision rates of depth sources, and single flights again."""

import dataclasses
import functools
from pathlib import Path
from typing import Any, Literal

import tyro

from synthdepth.console import progress_bar, say, write_json


@dataclasses.dataclass(frozen=True, kw_only=True)
class Simulate:
    """Fly drones by what depth sources tell them, and count their collisions (the paper's table 6).

    Every source flies the same scenarios, in scenes that no dataset holds. Stopped in any way, the
    same command goes on; with more --flights or other --source it extends the results.
    """

    map: str
    """Which map (see `synthdepth maps`), or a recipe file of your own (.toml)."""
    flights: int = 400
    """Scenarios that each source flies."""
    source: tuple[str, ...] = ("10m", "200m")
    """Ideal depth cameras by their range (10m, 200m), models by their path (or name=path), blind,
    ground, triangulation."""
    out: Path | None = None
    """Folder of the results; simulations/<map>-seed<seed> by default."""
    seed: int = 0
    """Everything is drawn from it."""
    size: str | None = None
    """Image size, e.g. 256x256; the recipe's by default."""
    conditions: tuple[str, ...] | None = None
    """Light and weather that scenes draw from; the recipe's by default."""
    rule: Literal["total", "nearest", "goal"] = "total"
    """Which section is flown to: largest total depth (the paper's), farthest nearest obstacle, or
    nearest the goal of those that are free."""
    goal_pull: float = 0.0
    """What the goal adds to a section's score; 0 is the paper's rule, 0.1 mostly arrives."""
    speed: Literal["cruise", "sight"] = "cruise"
    """Cruise speed throughout, or no faster than lets the drone halt within what it sees."""
    speed_mps: tuple[float, float] = (10.0, 22.2)
    """Range of the cruise speeds."""
    latency_s: float = 0.1
    """From a frame to its command's effect; the paper's table 5 has 0.297 on a Jetson."""
    flights_per_scene: int = 10
    """Scenarios of one scene."""
    workers: int | None = None
    """Processes at once; by default one a core."""
    executor: Literal["local", "ray"] = "local"
    """Processes of this machine, or of a Ray cluster, whose nodes must all reach --out and the
    models."""
    ray_address: str | None = None
    """The cluster's address; by default the cluster that this machine belongs to."""
    variant: Literal["cuda", "llvm", "scalar"] | None = None
    """How Mitsuba computes; by default the best that works here."""
    json: Path | None = None
    """Write the results to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.production.overrides import with_overrides
        from synthdepth.production.recipe import load_recipe
        from synthdepth.render.backend import choose
        from synthdepth.simulate.drone import DroneConfig
        from synthdepth.simulate.flight import Rules
        from synthdepth.simulate.planner import PlannerConfig
        from synthdepth.simulate.run import simulate
        from synthdepth.simulate.scenario import ScenarioRanges
        from synthdepth.simulate.sources import parse_source

        recipe = with_overrides(load_recipe(self.map), size=self.size, conditions=self.conditions)
        rules = Rules(
            drone=DroneConfig(latency_s=self.latency_s),
            planner=PlannerConfig(rule=self.rule, goal_pull=self.goal_pull, speed=self.speed),
            scenario=ScenarioRanges(speed_mps=self.speed_mps),
        )
        sources = [parse_source(text) for text in self.source]
        out = self.out or Path("simulations") / f"{Path(self.map).stem}-seed{self.seed}"
        try:
            with progress_bar("flying", "flights") as progress:
                report = simulate(
                    stage_of(recipe),
                    out,
                    flights=self.flights,
                    sources=sources,
                    **self._executor(choose(self.variant)),
                    rules=rules,
                    flights_per_scene=self.flights_per_scene,
                    seed=self.seed,
                    on_progress=progress,
                )
        except KeyboardInterrupt:
            say(f"\nstopped: finished flights in {out} are safe; the same command goes on")
            return 130
        say(report.text)
        say(f"{out}/report.html: {report.flown} flights flown now in {report.wall_s:.0f} s")
        write_json(self.json, dataclasses.asdict(report))
        return 0

    def _executor(self, backend) -> dict[str, Any]:
        """Who flies: arguments of `simulate`."""
        from synthdepth.production.run import WORKER_MEMORY_BYTES, default_workers, usable_cores

        if self.executor == "ray":
            from synthdepth.production import ray_pool

            run_jobs = functools.partial(
                ray_pool.run_jobs,
                address=self.ray_address,
                memory_bytes=WORKER_MEMORY_BYTES,
                gpus=int(backend.name == "cuda"),
            )
            # Every node has a libLLVM of its own.
            return {"run_jobs": run_jobs, "backend": backend.name, "workers": self.workers}
        from synthdepth.production.pool import run_jobs

        workers = default_workers() if self.workers is None else self.workers
        threads = max(1, usable_cores() // max(workers, 1))
        return {"run_jobs": run_jobs, "backend": backend, "workers": workers, "threads": threads}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Replay:
    """Fly a flight of a simulation again, exactly, and show it as a video or in 3D.

    A video has the camera's picture, the depth that was seen with the section that was flown to,
    and the flight from above.
    """

    folder: tyro.conf.Positional[Path]
    """Folder of the simulation."""
    source: str
    """Which source flew it."""
    scene: int = 0
    """In which scene; its number, as report.html and flights.jsonl have it."""
    scenario: int = 0
    """Which scenario of the scene."""
    out: Path = Path("flight.mp4")
    """A video (.mp4), or a recording for the Rerun viewer (.rrd)."""
    variant: Literal["cuda", "llvm", "scalar"] | None = None
    """How Mitsuba computes; by default the best that works here."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.errors import SynthdepthError
        from synthdepth.production.recipe import recipe_from_table
        from synthdepth.render.backend import activate, choose
        from synthdepth.simulate.replay import Replay
        from synthdepth.simulate.store import read_settings
        from synthdepth.simulate.tables import ended

        write = _writer_of(self.out)
        if not self.out.parent.is_dir():
            raise SynthdepthError(f"--out {self.out}: the folder {self.out.parent} does not exist")
        recipe = recipe_from_table(read_settings(self.folder)["recipe"], str(self.folder))
        activate(choose(self.variant))
        flight = Replay(
            stage_of(recipe),
            self.folder,
            source=self.source,
            scene_index=self.scene,
            scenario=self.scenario,
        )
        with progress_bar("flying", "frames") as progress:
            frames = write(flight, self.out, progress)
        say(f"{self.out}: {frames} frames; as recorded: {ended(flight.recorded)}")
        return 0


def _writer_of(out: Path):
    """What writes such a file: (replay, out, on_progress) -> number of frames."""
    from synthdepth.errors import SynthdepthError

    if out.suffix == ".mp4":
        from synthdepth.simulate.film import write_film

        return write_film
    if out.suffix != ".rrd":
        raise SynthdepthError(f"--out {out}: allowed is a file name that ends in .mp4 or .rrd")
    try:
        from synthdepth.view.flight_recording import write_flight_recording
    except ModuleNotFoundError as error:
        if error.name.partition(".")[0] != "rerun":
            raise
        raise SynthdepthError("Rerun is not installed: pip install 'synthdepth[view]'") from None
    return write_flight_recording


def stage_of(recipe):
    """The `synthdepth.simulate.run.Stage` of a `synthdepth.production.recipe.Recipe`."""
    from synthdepth.maps.registry import build_world
    from synthdepth.simulate.run import Stage

    return Stage(
        map=recipe.map,
        build=functools.partial(build_world, recipe.map, recipe.scene, recipe.light),
        camera=recipe.camera.intrinsics(),
        sensor=recipe.sensor,
        render=recipe.render,
        recipe=recipe.as_dict(),
    )
