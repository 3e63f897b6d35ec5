"""The job: scenes, scenarios and sources, flown by worker processes; can be stopped and goes on."""

import contextlib
import dataclasses
import fcntl
import functools
import json
import math
import os
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from synthdepth.camera import Intrinsics
from synthdepth.dataset.shard import write_error, write_whole
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.maps.world import World
from synthdepth.render.backend import Backend, activate
from synthdepth.render.sensor import SensorRanges
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import derive_seed
from synthdepth.simulate.flight import Rules
from synthdepth.simulate.outcome import (
    TABLE_6,
    TABLE_6_SOURCES,
    Comparison,
    Outcome,
    Summary,
    compare_sources,
    summarise,
    table,
)
from synthdepth.simulate.scene import SceneFlights, TimedSource
from synthdepth.simulate.sources import SourceName, make_source

SETTINGS, FLIGHTS, RESULTS, TABLE = "simulation.json", "flights.jsonl", "results.json", "table.txt"
_SCENES = "scenes"


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
class Spent:
    """Where workers' time went [s].

    Attributes:
        build_s: scenes, their scenarios and the trees of triangles.
        sight_s: loading scenes into the renderer, and rendering what the sources see.
        depth_s: the sources' own work.
        rest_s: planning, motion, contacts, results.
    """

    build_s: float = 0.0
    sight_s: float = 0.0
    depth_s: float = 0.0
    rest_s: float = 0.0

    def __add__(self, other: "Spent") -> "Spent":
        sums = (
            a + b
            for a, b in zip(dataclasses.astuple(self), dataclasses.astuple(other), strict=True)
        )
        return Spent(**dict(zip(dataclasses.asdict(self), sums, strict=True)))


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
    backend: Backend | None,
    rules: Rules | None = None,
    flights_per_scene: int = 10,
    seed: int = 0,
    workers: int = 1,
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
        backend: to activate in the workers; None where each process has one already.
        rules: how they fly.
        flights_per_scene: scenarios of one scene.
        seed: everything is drawn from it.
        workers: processes at once.
        threads: of each.
        on_progress: called with (flights done, flights wanted).

    Raises:
        SynthdepthError: the arguments cannot be, the folder holds something else or cannot be
            written, or no scenario was found in a scene.
    """
    started, folder, rules = time.perf_counter(), Path(folder), rules or Rules()
    jobs = plan_scenes(stage.map, seed, flights, flights_per_scene, sources)
    settings = {
        "format": 1,
        "seed": seed,
        "flights_per_scene": flights_per_scene,
        "rules": _plain(dataclasses.asdict(rules)),
        "camera": dataclasses.asdict(stage.camera),
        "recipe": _plain(stage.recipe),
    }
    with _locked(folder):
        _claim(folder, settings, sources)
        wanted = {job.scene_index: job.flights for job in jobs}
        total = sum(map(len, wanted.values()))

        def count() -> int:
            return sum(
                len(wanted[job.scene_index] & _flown(_scene_file(folder, stage, job)).keys())
                for job in jobs
            )

        before = done = count()
        on_progress(done, total)
        todo = [job for job in jobs if job.flights - _flown(_scene_file(folder, stage, job)).keys()]
        work = functools.partial(
            fly_scene, stage=stage, folder=folder, rules=rules, backend=backend, threads=threads
        )
        spent, progress = Spent(), [0] * len(todo)
        for event in run_jobs(work, todo, max(1, min(workers, len(todo)))):
            result = getattr(event, "result", None)
            if result is not None:
                spent += result
            else:
                done += event.done - progress[event.job]
                progress[event.job] = event.done
            on_progress(done, total)
        outcomes = _gather(folder, stage, jobs, sources)
        summaries, comparisons = summarise(outcomes), compare_sources(outcomes)
        text = table(summaries, comparisons)
        _write_results(folder, outcomes, summaries, comparisons, text)
    return SimulationReport(
        folder=folder,
        flown=len(outcomes) - before,
        wall_s=time.perf_counter() - started,
        spent=spent,
        summaries=summaries,
        comparisons=comparisons,
        text=text,
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
    backend: Backend | None,
    threads: int,
) -> Spent:
    """What a worker does: the flights of a scene that its file lacks, a line each as it ends."""
    if backend is not None:
        activate(backend, threads)
    start = time.perf_counter()
    path = _scene_file(folder, stage, job)
    there = _flown(path, mend=True)
    scene = SceneFlights(stage, job.scene_index, job.scene_seed, job.scenarios, rules)
    build_s, done = time.perf_counter() - start, 0
    depth_s = 0.0
    for named in job.sources:
        missing = [k for k in range(job.scenarios) if (named.name, k) not in there]
        if not missing:
            continue
        source = TimedSource(make_source(named, batch=rules.batch, threads=threads))
        for fields in scene.fly(source, missing):
            outcome = Outcome(source=named.name, **fields)
            _append(path, json.dumps(dataclasses.asdict(outcome)).encode() + b"\n")
            done += 1
            report(done)
        depth_s += source.spent_s
    rest_s = time.perf_counter() - start - build_s - scene.sight_s - depth_s
    return Spent(build_s=build_s, sight_s=scene.sight_s, depth_s=depth_s, rest_s=rest_s)


def read_flights(path: Path) -> list[Outcome]:
    """The flights of a `flights.jsonl`.

    Raises:
        DatasetError: it cannot be read, or holds something else.
    """
    try:
        return [Outcome(**json.loads(line)) for line in path.read_bytes().splitlines()]
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror}") from None
    except (ValueError, TypeError):
        raise DatasetError(f"{path} holds no flights: allowed is what simulate wrote") from None


def _scene_file(folder: Path, stage: Stage, job: SceneJob) -> Path:
    return folder / _SCENES / f"{stage.map}-s{job.scene_index:05d}.jsonl"


def _flown(path: Path, mend: bool = False) -> dict[tuple[str, int], dict]:
    """The flights of a scene's file by source and scenario; a line that a kill cut short is none.

    With `mend` such a line is removed.
    """
    if not path.exists():
        return {}
    data = path.read_bytes()
    whole = data[: data.rfind(b"\n") + 1]
    if mend and whole != data:
        write_whole(path, whole)
    records = [json.loads(line) for line in whole.splitlines()]
    return {(record["source"], record["scenario"]): record for record in records}


def _append(path: Path, line: bytes) -> None:
    with _naming(path), open(path, "ab") as file:
        file.write(line)
        file.flush()
        os.fsync(file.fileno())


def _gather(folder, stage, jobs, sources) -> list[Outcome]:
    """All flights that were asked for, in the order of sources, scenes and scenarios."""
    records: dict[tuple[int, str, int], dict] = {}
    for job in jobs:
        for (source, k), record in _flown(_scene_file(folder, stage, job)).items():
            records[job.scene_index, source, k] = record
    return [
        Outcome(**records[job.scene_index, source.name, k])
        for source in sources
        for job in jobs
        for k in range(job.scenarios)
    ]


def _write_results(folder, outcomes, summaries, comparisons, text) -> None:
    lines = "".join(json.dumps(dataclasses.asdict(outcome)) + "\n" for outcome in outcomes)
    results = {
        "summaries": [dataclasses.asdict(summary) for summary in summaries],
        "comparisons": [dataclasses.asdict(comparison) for comparison in comparisons],
        "paper_table_6": {
            name: dict(zip(TABLE_6_SOURCES, rates, strict=True)) for name, rates in TABLE_6.items()
        },
    }
    write_whole(folder / FLIGHTS, lines.encode())
    write_whole(folder / RESULTS, (json.dumps(results, indent=1) + "\n").encode())
    write_whole(folder / TABLE, (text + "\n").encode())


def _claim(folder: Path, settings: dict, sources: Sequence[SourceName]) -> None:
    """Write what the folder is for, or see that it is for the same."""
    path = folder / SETTINGS
    models = {source.name: dataclasses.asdict(source) for source in sources}
    if path.exists():
        try:
            there = json.loads(path.read_bytes())
            known = there.pop("sources")
        except (OSError, ValueError, KeyError):
            raise DatasetError(f"{path} cannot be read: choose another --out") from None
        for name, value in settings.items():
            if there.get(name) != value:
                raise DatasetError(
                    f"{folder} holds flights with another {name.replace('_', ' ')}: "
                    "choose another --out"
                )
        for name in models.keys() & known.keys():
            if models[name] != known[name]:
                raise DatasetError(
                    f"{folder} holds flights of another source {name!r}: name this one "
                    "otherwise (name=path) or choose another --out"
                )
        models = known | models
    elif strangers := sorted(entry.name for entry in folder.iterdir()):
        raise DatasetError(
            f"{folder} holds {strangers[0]!r} and no simulation: choose an empty or new --out"
        )
    with _naming(path):
        (folder / _SCENES).mkdir(exist_ok=True)
    write_whole(path, (json.dumps(settings | {"sources": models}, indent=1) + "\n").encode())


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Make the folder and keep other runs out of it."""
    with _naming(folder):
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError:
        raise DatasetError(f"another run is writing to {folder}: wait for it or stop it") from None
    finally:
        os.close(handle)


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise write_error(path, error) from error


def _plain(value: Any) -> Any:
    """Tables and lists as JSON gives them back."""
    return json.loads(json.dumps(value))
