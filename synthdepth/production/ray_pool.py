"""The jobs of a run on a Ray cluster: the events of `pool.run_jobs`, the processes of many nodes.

A node may be lost at any time; its jobs begin again on another one. Ray may believe a node lost
that still works: then two processes write the same shard, each whole and with the same bytes.
"""

import contextlib
import dataclasses
import os
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from synthdepth.errors import SynthdepthError
from synthdepth.production.pool import (
    PATIENCE_S,
    Finished,
    LostJobError,
    Progress,
    Restarted,
    Silence,
    attempt,
    finished,
)

# A job that is lost more often than this is lost by its own fault; nodes go for other reasons too.
_RETRIES = 10
# Seconds between two looks at the jobs, and between two reports of one.
_TICK_S = 1.0


@dataclasses.dataclass(eq=False)
class _Task:
    job: int
    name: str
    silence: Silence
    begun: bool = False
    hung: bool = False


def run_jobs(
    function: Callable,
    jobs: Sequence,
    workers: int | None = None,
    *,
    patience_s: float = PATIENCE_S,
    address: str | None = None,
    memory_bytes: int = 0,
    gpus: int = 0,
) -> Iterator[Progress | Finished]:
    """Run `function(job, report)` for every job on a Ray cluster, in a fresh process each.

    Args:
        function: importable by name on all nodes; `report(done)` sends a `Progress`.
        jobs: picklable.
        workers: jobs at once; by default as many as the cluster takes.
        patience_s: how long a job that has begun may be silent [s]; see `pool.run_jobs`.
        address: of the cluster; by default the one that this machine belongs to, or else a new one
            of this machine alone.
        memory_bytes: that a node must have free to be given a job.
        gpus: likewise.

    Raises:
        SynthdepthError: one that a job raised; Ray is not installed, or there is no such cluster.
        LostJobError: a job was lost more than `_RETRIES` times.
        WorkerError: any other error of a job.
    """
    ray = installed_ray()
    most = workers or len(jobs)
    waiting, losses = list(range(len(jobs)))[::-1], [0] * len(jobs)
    running: dict[Any, _Task] = {}
    with _connected(ray, address):
        board = _board(ray)
        remote = ray.remote(max_calls=1, max_retries=0)(_attempt).options(
            num_cpus=1, num_gpus=gpus, memory=memory_bytes
        )
        clock = time.monotonic()
        try:
            while waiting or running:
                while waiting and len(running) < most:
                    job = waiting.pop()
                    task = _Task(job, f"{job}.{losses[job]}", Silence(patience_s))
                    running[remote.remote(function, jobs[job], task.name, board)] = task
                ready, _ = ray.wait(list(running), timeout=_TICK_S)
                signs = ray.get(board.take.remote())
                clock, before = time.monotonic(), clock
                for ref, task in running.items():
                    if task.name in signs:
                        task.begun = True
                        task.silence.broken()
                        if signs[task.name] is not None:
                            yield Progress(task.job, signs[task.name])
                    elif task.begun:
                        task.silence.now_s += min(clock - before, 2 * _TICK_S)
                    if task.silence.too_long and not task.hung:
                        task.hung = True
                        ray.cancel(ref, force=True)
                for ref in ready:
                    task = running.pop(ref)
                    try:
                        kind, value = ray.get(ref)
                    except ray.exceptions.RayError as error:
                        why = f"died ({type(error).__name__})"
                        if task.hung:
                            why = "gave no sign of life and was killed"
                        losses[task.job] += 1
                        if losses[task.job] > _RETRIES:
                            raise LostJobError(
                                task.job,
                                f"its worker was lost {losses[task.job]} times; the last one {why}",
                            ) from None
                        waiting.append(task.job)
                        yield Restarted(task.job, 0, why, most)
                        continue
                    yield finished(task.job, kind, value)
        finally:
            for ref in running:
                ray.cancel(ref, force=True)


def installed_ray() -> Any:
    """The package `ray`.

    Raises:
        SynthdepthError: it is not installed.
    """
    try:
        import ray
    except ImportError:
        raise SynthdepthError(
            "--executor ray needs Ray, here and on all nodes: pip install 'synthdepth[ray]'"
        ) from None
    return ray


@contextlib.contextmanager
def _connected(ray: Any, address: str | None) -> Iterator[None]:
    """Join the cluster, unless this process has; leave it afterwards."""
    if ray.is_initialized():
        yield
        return
    # Of jobs that were cancelled nobody asks what became of them.
    os.environ.setdefault("RAY_IGNORE_UNHANDLED_ERRORS", "1")
    try:
        ray.init(address, log_to_driver=False, logging_level="error")
    except (ConnectionError, ValueError, RuntimeError) as error:
        told = str(error).strip().splitlines()[0] if str(error).strip() else type(error).__name__
        raise SynthdepthError(f"--ray-address {address}: no Ray cluster answers: {told}") from error
    try:
        yield
    finally:
        ray.shutdown()


class _Board:
    """Where the jobs leave how far they are, for the one who looks now and then."""

    def __init__(self):
        self._signs: dict[str, int | None] = {}

    def post(self, name: str, done: int | None) -> None:
        self._signs[name] = done

    def take(self) -> dict[str, int | None]:
        signs, self._signs = self._signs, {}
        return signs


def _board(ray: Any) -> Any:
    """A board on this node: it ends with this process at the latest."""
    from ray.util.scheduling_strategies import NodeAffinitySchedulingStrategy

    here = NodeAffinitySchedulingStrategy(ray.get_runtime_context().get_node_id(), soft=False)
    # What a board lost is told again at the next tick; it must not end the run.
    lasting = {"max_restarts": -1, "max_task_retries": -1}
    return ray.remote(num_cpus=0, scheduling_strategy=here, **lasting)(_Board).remote()


def _attempt(function: Callable, job: Any, name: str, board: Any) -> tuple[str, Any]:
    """A job on a node; reports at most once a tick, so that one board serves thousands."""
    last = -_TICK_S
    board.post.remote(name, None)

    def report(done: int) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _TICK_S:
            last = now
            board.post.remote(name, done)

    return attempt(function, job, report)
