"""The main job: plan, render in workers, keep the manifest, resume."""

import contextlib
import dataclasses
import fcntl
import functools
import importlib.metadata
import os
import platform
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import synthdepth
from synthdepth.dataset.card import write_card
from synthdepth.dataset.croissant import write_croissant
from synthdepth.dataset.manifest import (
    DESCRIPTIONS,
    MANIFEST,
    check_identity,
    read_manifest,
    write_index,
    write_manifest,
)
from synthdepth.dataset.pair import META_FIELDS, SCHEMA_VERSION, scene_of_key
from synthdepth.dataset.shard import PARTIAL, sha256_of, shard_members, write_error
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.maps.world import LABELS
from synthdepth.production.plan import ShardJob, plan_shards
from synthdepth.production.pool import Finished, run_jobs
from synthdepth.production.recipe import Recipe
from synthdepth.production.shard_job import run_shard_job, shard_record
from synthdepth.render.backend import Backend, activate, choose

# What a worker needs at most; more workers than fit are not started by default.
WORKER_MEMORY_BYTES = 2 * 2**30


@dataclasses.dataclass(frozen=True, kw_only=True)
class RunReport:
    """What a run did.

    Attributes:
        folder: the dataset.
        pairs: pairs in the dataset now.
        rendered: pairs rendered by this run.
        wall_s: of this run.
        render_share: share of the workers' time inside rendering, denoising and ground truth.
    """

    folder: Path
    pairs: int
    rendered: int
    wall_s: float
    render_share: float


def default_workers() -> int:
    """One worker a usable core, as far as memory reaches."""
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    return max(1, min(usable_cores(), memory // WORKER_MEMORY_BYTES))


def usable_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def render_dataset(
    recipe: Recipe,
    folder: Path,
    *,
    pairs: int,
    seed: int = 0,
    train_share: float = 0.5,
    workers: int | None = None,
    variant: str | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    on_backend: Callable[[Backend], None] = lambda backend: None,
) -> RunReport:
    """Render a dataset, or whatever is still missing of it.

    The bytes of every shard depend on the recipe, the seed and the shard's number alone. A run
    that was stopped in any way goes on with the same call; a larger `pairs` extends it.

    Args:
        recipe: what it is drawn from.
        folder: where it goes; made if it is not there.
        pairs: how many pairs the dataset shall hold.
        seed: 0 is a seed like any other.
        train_share: share of the scenes in the split "train"; the others are "test".
        workers: processes at once; by default one a core.
        variant: "cuda", "llvm" or "scalar" instead of the best that works.
        on_progress: called with (pairs done, pairs wanted).
        on_backend: called once with the backend that renders.

    Raises:
        SynthdepthError: the arguments cannot be, the folder holds another dataset or cannot be
            written, or no flight was found in a scene.
    """
    started = time.perf_counter()
    folder = Path(folder)
    if workers is not None and not 1 <= workers <= 1024:
        raise SynthdepthError(f"--workers {workers}: allowed is a whole number from 1 to 1024")
    jobs = plan_shards(
        map_name=recipe.map,
        seed=seed,
        pairs=pairs,
        pairs_per_scene=recipe.sampling.pairs_per_scene,
        train_share=train_share,
    )
    backend = choose(variant)
    on_backend(backend)
    asked = _blank_manifest(recipe, seed, train_share, backend)
    with _locked(folder):
        records = _records_there(folder, asked)
        with _swept(folder):
            keep = [r for r in records.values() if r["pairs"]]
            manifest = asked | {"pairs_planned": max(pairs, sum(r["pairs"] for r in keep))}
            todo = [job for job in jobs if records.get(job.path, {"pairs": 0})["pairs"] < job.pairs]
            done = sum(
                min(records[job.path]["pairs"], job.pairs) for job in jobs if job.path in records
            )
            already = done
            on_progress(done, pairs)
            _save(folder, manifest, records)

            workers = min(workers or default_workers(), max(len(todo), 1))
            threads = max(1, usable_cores() // workers)
            work = functools.partial(
                _render_shard, recipe=recipe, folder=folder, backend=backend, threads=threads
            )
            counted = [records.get(job.path, {"pairs": 0})["pairs"] for job in todo]
            spent, rendering = 0.0, 0.0
            for event in run_jobs(work, todo, workers):
                if isinstance(event, Finished):
                    record, seconds = event.result
                    records[record["path"]] = record
                    spent, rendering = spent + seconds, rendering + sum(record["cost"]["render_s"])
                    _save(folder, manifest, records)
                    progress = record["pairs"]
                else:
                    progress = event.done
                done += progress - counted[event.job]
                counted[event.job] = progress
                on_progress(done, pairs)
            _finish(folder, manifest, records)
    return RunReport(
        folder=folder,
        pairs=sum(record["pairs"] for record in records.values()),
        rendered=done - already,
        wall_s=time.perf_counter() - started,
        render_share=rendering / spent if spent else 0.0,
    )


def _render_shard(
    job: ShardJob,
    report: Callable[[int], None],
    *,
    recipe: Recipe,
    folder: Path,
    backend: Backend,
    threads: int,
) -> tuple[dict, float]:
    """What a worker process does: one shard, its record, and the seconds it took."""
    start = time.perf_counter()
    activate(backend, threads)
    record = run_shard_job(job, recipe, folder, report)
    return record, time.perf_counter() - start


def _blank_manifest(recipe: Recipe, seed: int, train_share: float, backend: Backend) -> dict:
    version = importlib.metadata.version
    return {
        "schema_version": SCHEMA_VERSION,
        "map": recipe.map,
        "seed": seed,
        "train_share": train_share,
        "pairs_planned": 0,
        "complete": False,
        "splits": {},
        "software": {
            "synthdepth": synthdepth.__version__,
            "mitsuba": version("mitsuba"),
            "numpy": version("numpy"),
            "variant": backend.variant,
            "machine": platform.machine(),
        },
        "depth": {
            "unit": "metre",
            "convention": "planar",
            "channel": "Z",
            "dtype": "float32",
            "max_depth_m": recipe.render.max_depth_m,
        },
        "meta_fields": list(META_FIELDS),
        "labels": LABELS if "seg" in recipe.render.modalities else {},
        "recipe": recipe.as_dict(),
        "shards": [],
    }


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Make the folder and keep other runs out of it."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY)
    except OSError as error:
        raise write_error(folder / MANIFEST, error) from error
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise DatasetError(f"another run is writing to {folder}: wait for it or stop it") from None
    try:
        yield
    finally:
        os.close(handle)


@contextlib.contextmanager
def _swept(folder: Path) -> Iterator[None]:
    """Remove what was left half written, before and after; only in a folder known to be ours."""
    try:
        _sweep(folder)
        yield
    finally:
        _sweep(folder)


def _sweep(folder: Path) -> None:
    ours = (*DESCRIPTIONS, "train/*.tar", "test/*.tar")
    for pattern in (f"{name}.*{PARTIAL}" for name in ours):
        for partial in folder.glob(pattern):
            partial.unlink(missing_ok=True)


def _records_there(folder: Path, asked: dict) -> dict[str, dict]:
    """The records of the shards that are whole, by path."""
    if not (folder / MANIFEST).exists():
        strangers = sorted(
            p.name for p in folder.iterdir() if not p.match(f"{MANIFEST}.*{PARTIAL}")
        )
        if strangers:
            raise DatasetError(
                f"{folder} holds {strangers[0]!r} and no dataset: choose an empty or new --out"
            )
        there = asked
    else:
        there = read_manifest(folder)
        check_identity(folder, there, asked)
    known = {record["path"]: record for record in there["shards"]}
    records = {}
    for path in sorted(folder.glob("*/*.tar")):
        name = path.relative_to(folder).as_posix()
        record = known.get(name)
        if record is None or record["bytes"] != path.stat().st_size:
            record = _record_of(path, name, asked)
        if record is not None:
            records[name] = record
    return records


def _record_of(path: Path, name: str, asked: dict) -> dict | None:
    """The record of a shard that got its name just before a kill; None where it is not ours."""
    per_scene = asked["recipe"]["sampling"]["pairs_per_scene"]
    try:
        keys = list(shard_members(path))
        scene_index = scene_of_key(keys[0])
    except (ValueError, IndexError):
        return None
    job = plan_shards(
        map_name=asked["map"],
        seed=asked["seed"],
        pairs=(scene_index + 1) * per_scene,
        pairs_per_scene=per_scene,
        train_share=asked["train_share"],
    )[-1]
    if job.path != name:
        return None
    job = dataclasses.replace(job, pairs=len(keys))
    return shard_record(job, sha256_of(path), path.stat().st_size, None)


def _save(folder: Path, manifest: dict, records: dict[str, dict]) -> None:
    shards = sorted(records.values(), key=lambda record: record["scene_index"])
    splits: dict[str, int] = {}
    for record in shards:
        splits[record["split"]] = splits.get(record["split"], 0) + record["pairs"]
    complete = sum(splits.values()) >= manifest["pairs_planned"]
    write_manifest(folder, manifest | {"complete": complete, "splits": splits, "shards": shards})


def _finish(folder: Path, manifest: dict, records: dict[str, dict]) -> None:
    """Write what is made of all shards: index, card and Croissant."""
    _save(folder, manifest, records)
    final = read_manifest(folder)
    write_index(folder, final)
    write_card(folder, final)
    write_croissant(folder, final)
