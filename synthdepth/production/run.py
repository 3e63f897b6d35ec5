"""The main job: plan, render in workers, keep the manifest, resume."""

import contextlib
import dataclasses
import functools
import os
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Literal

import pyarrow as pa

from synthdepth.dataset.manifest import index_table
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.production.ledger import Ledger, blank_manifest, software
from synthdepth.production.plan import ShardJob, plan_shards
from synthdepth.production.pool import (
    PATIENCE_S,
    Finished,
    LostJobError,
    Progress,
    Restarted,
    run_jobs,
)
from synthdepth.production.recipe import Recipe
from synthdepth.production.shard_job import GateError, run_shard_job
from synthdepth.production.storage import GoneError, Storage, storage_of
from synthdepth.render.backend import Backend, activate, choose

# What a worker needs at most; more workers than fit are not started by default.
WORKER_MEMORY_BYTES = 2 * 2**30
# A worker may be silent for this long a sample of a pair: a thousand times what the slowest needs.
_PATIENCE_S_PER_SAMPLE = 1e-3


@dataclasses.dataclass(frozen=True, kw_only=True)
class RunReport:
    """What a run did.

    Attributes:
        folder: the dataset: a folder, or an address.
        pairs: pairs in the dataset now.
        rendered: pairs rendered by this run.
        wall_s: of this run.
        render_share: share of the workers' time inside rendering, denoising and ground truth.
    """

    folder: Path | str
    pairs: int
    rendered: int
    wall_s: float
    render_share: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class ShardResult:
    """What a worker gives back.

    Attributes:
        record: the shard's, for the manifest.
        rows: its rows of the index, where reading the shard again would cost a transfer.
        seconds: that the job took.
    """

    record: dict
    rows: pa.Table | None
    seconds: float


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
    folder: Path | str,
    *,
    pairs: int,
    seed: int = 0,
    train_share: float = 0.5,
    workers: int | None = None,
    variant: str | None = None,
    executor: Literal["local", "ray"] = "local",
    ray_address: str | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    on_backend: Callable[[Backend], None] = lambda backend: None,
    on_restart: Callable[[Restarted], None] = lambda event: None,
) -> RunReport:
    """Render a dataset, or whatever is still missing of it.

    The bytes of every shard depend on the recipe, the seed and the shard's number alone. A run
    that was stopped in any way goes on with the same call; a larger `pairs` extends it.

    Args:
        recipe: what it is drawn from.
        folder: where it goes: a folder, made if it is not there, or an address that fsspec knows
            (`s3://bucket/folder`).
        pairs: how many pairs the dataset shall hold.
        seed: 0 is a seed like any other.
        train_share: share of the scenes in the split "train"; the others are "test".
        workers: processes at once; by default one a core, of a Ray cluster all of it.
        variant: "cuda", "llvm" or "scalar" instead of the best that works.
        executor: "local" for processes of this machine, "ray" for a Ray cluster, whose nodes must
            all reach `folder`.
        ray_address: of the cluster; by default the one that this machine belongs to.
        on_progress: called with (pairs done, pairs wanted).
        on_backend: called once with the backend that renders.
        on_restart: called when a worker was lost and its shard begins again.

    Raises:
        SynthdepthError: the arguments cannot be, the folder holds another dataset or cannot be
            written, no flight was found in a scene, or a shard's worker was lost again and again.
    """
    started = time.perf_counter()
    if workers is not None and not 1 <= workers <= 1024:
        raise SynthdepthError(f"--workers {workers}: allowed is a whole number from 1 to 1024")
    jobs = plan_shards(
        map_name=recipe.map,
        seed=seed,
        pairs=pairs,
        pairs_per_scene=recipe.sampling.pairs_per_scene,
        train_share=train_share,
    )
    if executor == "ray":
        from synthdepth.production.ray_pool import installed_ray

        installed_ray()
    storage = storage_of(folder)
    backend = choose(variant)
    on_backend(backend)
    asked = blank_manifest(recipe, seed, train_share, backend)
    with storage.locked(), storage.workspace() as work:
        ledger = Ledger(storage, work, asked, pairs)
        with storage.swept():
            todo = [
                dataclasses.replace(job, extends=ledger.records.get(job.path))
                for job in jobs
                if ledger.pairs_of(job.path) < job.pairs
            ]
            already = done = sum(min(ledger.pairs_of(job.path), job.pairs) for job in jobs)
            on_progress(done, pairs)
            if todo:
                ledger.start()
            counted = [ledger.pairs_of(job.path) for job in todo]
            spent, rendering = 0.0, 0.0
            render = functools.partial(
                _render_shard, recipe=recipe, storage=storage, expected=asked["software"]
            )
            events = _events(render, todo, workers, recipe, backend, executor, ray_address)
            try:
                # Closed before the folder is swept: then no worker is left to write into it.
                with contextlib.closing(events):
                    for event in events:
                        if isinstance(event, Finished):
                            result = event.result
                            ledger.add(result.record, result.rows)
                            progress = result.record["pairs"]
                            spent += result.seconds
                            rendering += sum(result.record["cost"]["render_s"])
                        else:
                            progress = event.done
                        if isinstance(event, Restarted):
                            on_restart(event)
                        ledger.save()
                        done += progress - counted[event.job]
                        counted[event.job] = progress
                        on_progress(done, pairs)
                ledger.finish()
            except LostJobError as error:
                raise SynthdepthError(
                    f"{todo[error.job].path} could not be rendered: {error}; {_safe(ledger)}"
                ) from error
            except GateError as error:
                raise SynthdepthError(
                    f"{error}; synthdepth pair {storage.place} {error.key} renders it alone"
                ) from error
            except GoneError:
                raise
            except DatasetError as error:
                raise DatasetError(f"{error}; {_safe(ledger)}") from error
    return RunReport(
        folder=storage.place,
        pairs=ledger.pairs,
        rendered=done - already,
        wall_s=time.perf_counter() - started,
        render_share=rendering / spent if spent else 0.0,
    )


def _safe(ledger: Ledger) -> str:
    return f"the {ledger.pairs} pairs of finished shards are safe, and the same command goes on"


def _events(
    render: Callable,
    todo: list[ShardJob],
    workers: int | None,
    recipe: Recipe,
    backend: Backend,
    executor: str,
    ray_address: str | None,
) -> Iterator[Progress | Finished]:
    """What happens to the jobs, here or on a cluster."""
    camera = recipe.camera
    patience_s = PATIENCE_S + _PATIENCE_S_PER_SAMPLE * camera.width * camera.height * (
        recipe.render.spp
    )
    if executor == "ray":
        from synthdepth.production import ray_pool

        # Every node has a libLLVM of its own.
        work = functools.partial(render, backend=backend.name, threads=1)
        return ray_pool.run_jobs(
            work,
            todo,
            workers,
            patience_s=patience_s,
            address=ray_address,
            memory_bytes=WORKER_MEMORY_BYTES,
            gpus=int(backend.name == "cuda"),
        )
    workers = min(workers or default_workers(), max(len(todo), 1))
    threads = max(1, usable_cores() // workers)
    work = functools.partial(render, backend=backend, threads=threads)
    return run_jobs(work, todo, workers, patience_s=patience_s)


def _render_shard(
    job: ShardJob,
    report: Callable[[int], None],
    *,
    recipe: Recipe,
    storage: Storage,
    expected: Mapping,
    backend: Backend | str,
    threads: int,
) -> ShardResult:
    """What a worker process does: one shard."""
    start = time.perf_counter()
    storage.check()
    activate(choose(backend) if isinstance(backend, str) else backend, threads)
    _check_software(expected)
    with storage.workspace() as work:
        if job.extends:
            storage.pull(work, job.path)
        record = run_shard_job(job, recipe, work, report)
        path = work / job.path
        rows = None
        if work != storage.place:
            rows = index_table(path, job.path, {"recipe": recipe.as_dict()})
        storage.push(work, job.path, alive=lambda: report(record["pairs"]))
    return ShardResult(record=record, rows=rows, seconds=time.perf_counter() - start)


def _check_software(expected: Mapping) -> None:
    """Refuse to mix what other versions would render into a dataset."""
    for name, here in software(expected["variant"]).items():
        if here != expected[name]:
            raise DatasetError(
                f"a worker on {os.uname().nodename} has {name} {here}, the run was started with "
                f"{expected[name]}"
            )
