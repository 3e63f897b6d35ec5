"""The job: scenes, scenarios and sources, flown by worker processes; can be stopped and goes on."""

import dataclasses
import functools
import json
import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from synthdepth.camera import Intrinsics
from synthdepth.dataset.shard import write_whole
from synthdepth.errors import SynthdepthError
from synthdepth.maps.world import World
from synthdepth.render.backend import Backend, activate, choose
from synthdepth.render.sensor import SensorRanges
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import derive_seed
from synthdepth.simulate.flight import Rules
from synthdepth.simulate.markdown import markdown, text_table
from synthdepth.simulate.outcome import (
    TABLE_6,
    TABLE_6_SOURCES,
    Comparison,
    Outcome,
    Summary,
    compare_sources,
    summarise,
)
from synthdepth.simulate.report import MAPS_SHOWN, html_page
from synthdepth.simulate.scene import SceneFlights, TimedSource
from synthdepth.simulate.sources import SourceName, make_source
from synthdepth.simulate.spent import Spent, read_spent, spent_line
from synthdepth.simulate.store import (
    FLIGHTS,
    RESULTS,
    SCENES,
    TABLE,
    TIMES,
    append,
    claim,
    flown,
    locked,
    plain,
    read_map,
    scene_file,
    write_map,
)
from synthdepth.simulate.tables import Results

MARKDOWN, HTML = "report.md", "report.html"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Stage:
    """What flights are flown in, and through what camera.

    Attributes:
        map: name of the map.
        build: (scene_seed) -> World; importable by name, for the workers.
        camera: intrinsics of the pictures.
        sensor: what each scenario's sensor is drawn from.
        render: samples and range.
        recipe: all that as plain tables, to tell one stage from another.
    """

    map: str
    build: Callable[[int], World]
    camera: Intrinsics
    sensor: SensorRanges
    render: RenderSettings
    recipe: Mapping


@dataclasses.dataclass(frozen=True, kw_only=True)
class SimulationReport:
    """What a run did, and the results of all flights that were asked for.

    Attributes:
        folder: where they lie.
        flown: flights flown by this run.
        wall_s: of this run.
        spent: by its workers.
        summaries: per source.
        comparisons: per two sources.
        text: both as a table.
    """

    folder: Path
    flown: int
    wall_s: float
    spent: Spent
    summaries: list[Summary]
    comparisons: list[Comparison]
    text: str


@dataclasses.dataclass(frozen=True, kw_only=True)
class SceneJob:
    """A scene whose scenarios are to be flown.

    Attributes:
        scene_index, scene_seed: which scene.
        scenarios: the first so many of it.
        sources: each flies all of them.
    """

    scene_index: int
    scene_seed: int
    scenarios: int
    sources: tuple[SourceName, ...]

    @property
    def flights(self) -> set[tuple[str, int]]:
        """Source and scenario of each of its flights."""
        return {(source.name, k) for source in self.sources for k in range(self.scenarios)}


def simulate(
    stage: Stage,
    folder: Path,
    *,
    flights: int,
    sources: Sequence[SourceName],
    run_jobs: Callable[[Callable, Sequence, int], Iterator],
    backend: Backend | str | None,
    rules: Rules | None = None,
    flights_per_scene: int = 10,
    seed: int = 0,
    workers: int | None = 1,
    threads: int = 1,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> SimulationReport:
    """Fly scenarios with every source, or those that are still missing, and compare the sources.

    The results depend on the stage, the rules, the seed and the sources alone, not on the number of
    workers. The scenes are drawn for the simulation: no dataset holds them. All sources fly the
    same scenarios. A run that was stopped goes on with the same call and has lost at most the
    flights in the air; more flights and more sources can be asked for later.

    Args:
        stage: map and camera.
        folder: where results go; made if it is not there.
        flights: scenarios that each source flies.
        sources: from `parse_source`; at least one, with different names.
        run_jobs: as `synthdepth.production.pool.run_jobs`.
        backend: to activate in the workers, or its name, for workers on machines that each find
            their own; None where each process has one already.
        rules: how they fly.
        flights_per_scene: scenarios of one scene.
        seed: everything is drawn from it.
        workers: processes at once; None for as many as `run_jobs` finds room for.
        threads: of the renderer in each.
        on_progress: called with (flights done, flights wanted).

    Raises:
        SynthdepthError: the arguments cannot be, the folder holds something else or cannot be
            written, or no scenario was found in a scene.
    """
    started, folder, rules = time.perf_counter(), Path(folder), rules or Rules()
    jobs = plan_scenes(stage.map, seed, flights, flights_per_scene, sources)
    settings = {
        "seed": seed,
        "flights_per_scene": flights_per_scene,
        "rules": dataclasses.asdict(rules),
        "camera": dataclasses.asdict(stage.camera),
        "recipe": stage.recipe,
    }
    with locked(folder):
        claim(folder, settings, sources)
        wanted = {job.scene_index: job.flights for job in jobs}
        total = sum(map(len, wanted.values()))

        def count() -> int:
            return sum(
                len(wanted[job.scene_index] & flown(_scene_file(folder, stage, job)).keys())
                for job in jobs
            )

        before = done = count()
        on_progress(done, total)
        todo = [job for job in jobs if job.flights - flown(_scene_file(folder, stage, job)).keys()]
        work = functools.partial(
            fly_scene, stage=stage, folder=folder, rules=rules, backend=backend, threads=threads
        )
        spent, progress = Spent(), [0] * len(todo)
        for event in run_jobs(work, todo, max(1, min(workers or len(todo), len(todo)))):
            result = getattr(event, "result", None)
            if result is not None:
                spent += result
            elif new := event.done - progress[event.job]:
                # A worker that begins again does not fly again what was safe.
                done, progress[event.job] = count() if new < 0 else done + new, event.done
                on_progress(done, total)
        outcomes = _gather(folder, stage, jobs, sources)
        results = Results(
            map=stage.map,
            settings=plain(settings) | {"sources": {s.name: s.what for s in sources}},
            outcomes=outcomes,
            summaries=summarise(outcomes),
            comparisons=compare_sources(outcomes),
            spent=read_spent(sorted((folder / TIMES).glob("*.jsonl"))),
            maps=[read_map(folder, stage.map, job.scene_index) for job in jobs[:MAPS_SHOWN]],
        )
        _write_results(folder, results)
    return SimulationReport(
        folder=folder,
        flown=len(outcomes) - before,
        wall_s=time.perf_counter() - started,
        spent=spent,
        summaries=results.summaries,
        comparisons=results.comparisons,
        text=text_table(results),
    )


def plan_scenes(
    map_name: str, seed: int, flights: int, flights_per_scene: int, sources: Sequence[SourceName]
) -> list[SceneJob]:
    """The scenes of a run; a longer run begins with the shorter one's.

    Raises:
        SynthdepthError: the arguments cannot be.
    """
    counts = ("flights", flights, 10**6), ("flights-per-scene", flights_per_scene, 1000)
    for name, value, most in counts:
        if not 1 <= value <= most:
            raise SynthdepthError(f"--{name} {value}: allowed is a whole number from 1 to {most}")
    if not 0 <= seed < 2**63:
        raise SynthdepthError(f"--seed {seed}: allowed is a whole number from 0 to 2^63 - 1")
    names = [source.name for source in sources]
    if not names or len(set(names)) < len(names):
        raise SynthdepthError(
            f"--source {' '.join(names)}: allowed are one or more, each once (name=path names one)"
        )
    return [
        SceneJob(
            scene_index=scene,
            scene_seed=derive_seed(seed, "simulate", map_name, scene),
            scenarios=min(flights_per_scene, flights - scene * flights_per_scene),
            sources=tuple(sources),
        )
        for scene in range(math.ceil(flights / flights_per_scene))
    ]


def fly_scene(
    job: SceneJob,
    report: Callable[[int], None],
    *,
    stage: Stage,
    folder: Path,
    rules: Rules,
    backend: Backend | str | None,
    threads: int,
) -> Spent:
    """What a worker does: the flights of a scene that its file lacks, a line each as it ends."""
    if backend is not None:
        activate(choose(backend) if isinstance(backend, str) else backend, threads)
    path = _scene_file(folder, stage, job)
    times = scene_file(folder, TIMES, stage.map, job.scene_index, ".jsonl")
    there = flown(path, mend=True)
    numbers = range(job.scenarios)
    scene = SceneFlights(stage, job.scene_index, job.scene_seed, numbers, rules)
    write_map(folder, stage.map, job.scene_index, scene.view, scene.condition)
    total, done = Spent(build_s=scene.build_s, survey_s=scene.survey_s), 0
    append(times, spent_line("", total))
    for named in job.sources:
        missing = [k for k in numbers if (named.name, k) not in there]
        if not missing:
            continue
        start, eyes, frames = time.perf_counter(), scene.place.eyes, 0
        loading_s, sight_s = eyes.loading_s, eyes.spent_s
        source = TimedSource(make_source(named, batch=rules.batch))
        # Flights of one batch may take minutes until the first one ends.
        for fields in scene.fly(source, missing, lambda _: report(done)):  # noqa: B023
            outcome = Outcome(source=named.name, **fields)
            append(path, json.dumps(dataclasses.asdict(outcome)).encode() + b"\n")
            frames += len(outcome.track_m)
            done += 1
            report(done)
        load = Spent(load_s=eyes.loading_s - loading_s)
        spent = Spent(
            flights=len(missing), frames=frames, sight_s=eyes.spent_s - sight_s,
            depth_s=source.spent_s,
        )  # fmt: skip
        rest_s = time.perf_counter() - start - load.load_s - spent.sight_s - spent.depth_s
        spent += Spent(physics_s=rest_s)
        append(times, spent_line("", load) + spent_line(named.name, spent))
        total += load + spent
    return total


def _scene_file(folder: Path, stage: Stage, job: SceneJob) -> Path:
    return scene_file(folder, SCENES, stage.map, job.scene_index, ".jsonl")


def _gather(folder, stage, jobs, sources) -> list[Outcome]:
    """All flights that were asked for, in the order of sources, scenes and scenarios."""
    flights: dict[tuple[int, str, int], Outcome] = {}
    for job in jobs:
        for (source, k), flight in flown(_scene_file(folder, stage, job)).items():
            flights[job.scene_index, source, k] = flight
    return [
        flights[job.scene_index, source.name, k]
        for source in sources
        for job in jobs
        for k in range(job.scenarios)
    ]


def _write_results(folder: Path, results: Results) -> None:
    lines = "".join(json.dumps(dataclasses.asdict(outcome)) + "\n" for outcome in results.outcomes)
    figures = {
        "summaries": [dataclasses.asdict(summary) for summary in results.summaries],
        "comparisons": [dataclasses.asdict(comparison) for comparison in results.comparisons],
        "paper_table_6": {
            name: dict(zip(TABLE_6_SOURCES, rates, strict=True)) for name, rates in TABLE_6.items()
        },
    }
    write_whole(folder / FLIGHTS, lines.encode())
    write_whole(folder / RESULTS, (json.dumps(figures, indent=1) + "\n").encode())
    write_whole(folder / TABLE, (text_table(results) + "\n").encode())
    write_whole(folder / MARKDOWN, markdown(results).encode())
    write_whole(folder / HTML, html_page(results).encode())
