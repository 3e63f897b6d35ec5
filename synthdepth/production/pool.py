"""Worker processes: one fresh process a job, so that nothing leaks from scene to scene.

A job takes a minute or more; a fresh interpreter costs about a second of it, and buys flat memory
and a death that concerns one job only. Jobs are idempotent: one whose process was lost is simply
started again.
"""

import contextlib
import ctypes
import dataclasses
import multiprocessing
import multiprocessing.connection
import multiprocessing.resource_tracker
import os
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from synthdepth.errors import SynthdepthError

# A job whose process is lost is started again this often.
_RETRIES = 2
# A job may be silent for PATIENCE_S, or for so many times its longest silence so far.
PATIENCE_S = 900.0
_PATIENCE_FACTOR = 20
# Seconds between two looks at who is silent.
_TICK_S = 1.0
# Seconds that a process may take to exit when its job is done.
_EXIT_S = 10.0
_PR_SET_PDEATHSIG = 1  # linux/prctl.h


@dataclasses.dataclass(frozen=True)
class Progress:
    """A job has come on.

    Attributes:
        job: its number.
        done: units done so far.
    """

    job: int
    done: int


@dataclasses.dataclass(frozen=True)
class Restarted(Progress):
    """A job's process was lost, and the job begins again: `done` is 0.

    Attributes:
        why: what happened to the process, for people.
        workers: processes at once from now on.
    """

    why: str
    workers: int


@dataclasses.dataclass(frozen=True)
class Finished:
    """A job has ended.

    Attributes:
        job: its number.
        result: what it returned.
    """

    job: int
    result: Any


class WorkerError(Exception):
    """A job failed in a way that is no fault of the user's; holds the worker's traceback."""


class LostJobError(SynthdepthError):
    """A job's process was lost each time that it was started.

    Attributes:
        job: its number.
    """

    def __init__(self, job: int, message: str):
        super().__init__(message)
        self.job = job


@dataclasses.dataclass
class Silence:
    """How long a job has given no sign, against what it may.

    Attributes:
        allowed_s: seconds that any job may be silent.
        now_s: of the silence that lasts.
        longest_s: of any earlier one.
    """

    allowed_s: float
    now_s: float = 0.0
    longest_s: float = 0.0

    def broken(self) -> None:
        """The job has given a sign."""
        self.longest_s, self.now_s = max(self.longest_s, self.now_s), 0.0

    @property
    def too_long(self) -> bool:
        """Whether the job hangs, judged by its own pace."""
        return self.now_s > max(self.allowed_s, _PATIENCE_FACTOR * self.longest_s)


@dataclasses.dataclass(eq=False)
class _Worker:
    job: int
    process: multiprocessing.process.BaseProcess
    silence: Silence
    hung: bool = False


def run_jobs(
    function: Callable, jobs: Sequence, workers: int, *, patience_s: float = PATIENCE_S
) -> Iterator[Progress | Finished]:
    """Run `function(job, report)` for every job in processes of their own, `workers` at a time.

    A job is started again when its process dies, or when it gives no sign for `patience_s` seconds
    and for 20 times as long as it ever did before. Where processes are killed from outside (exit
    code -9, as a system does that is short of memory) more than once, one fewer runs at a time from
    then on. No process outlives this one, however this one ends.

    Args:
        function: importable by name; `report(done)` sends a `Progress`.
        jobs: picklable.
        workers: number of processes at once.
        patience_s: how long any job may be silent [s].

    Raises:
        SynthdepthError: one that a job raised.
        LostJobError: a job's process was lost more than `_RETRIES` times.
        WorkerError: any other error of a job.
    """
    context = multiprocessing.get_context("spawn")
    waiting = list(range(len(jobs)))[::-1]
    losses, kills = [0] * len(jobs), 0
    running: dict[multiprocessing.connection.Connection, _Worker] = {}
    clock = time.monotonic()
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                number = waiting.pop()
                ours, theirs = context.Pipe(duplex=False)
                process = context.Process(
                    target=_work, args=(function, jobs[number], theirs), daemon=True
                )
                # Known before it is started: a Ctrl-C in between leaves nobody behind.
                running[ours] = _Worker(number, process, Silence(patience_s))
                with _without_interrupts():
                    process.start()
                theirs.close()
            ready = multiprocessing.connection.wait(list(running), _TICK_S)
            # While this process was stopped or busy nobody was listening: that is no silence.
            clock, before = time.monotonic(), clock
            for worker in running.values():
                worker.silence.now_s += min(clock - before, 2 * _TICK_S)
            for pipe in ready:
                worker = running[pipe]
                try:
                    kind, value = pipe.recv()
                except (EOFError, OSError):
                    # The pipe closed without a result: the process is lost.
                    worker.process.join()
                    del running[pipe]
                    killed = worker.process.exitcode == -signal.SIGKILL and not worker.hung
                    kills += killed
                    # Killed among several: short of memory all together, so no fault of the job's.
                    losses[worker.job] += not (killed and workers > 1)
                    if killed and kills > 1:
                        workers = max(1, workers - 1)
                    why = _what_happened(worker)
                    if losses[worker.job] > _RETRIES:
                        raise LostJobError(
                            worker.job,
                            f"its worker was lost {losses[worker.job]} times; the last one {why}",
                        ) from None
                    waiting.append(worker.job)
                    yield Restarted(worker.job, 0, why, workers)
                    continue
                worker.silence.broken()
                if kind == "progress":
                    yield Progress(worker.job, value)
                    continue
                # Whatever it still does at its exit is of no use to anyone.
                worker.process.join(_EXIT_S)
                worker.process.kill()
                worker.process.join()
                del running[pipe]
                yield finished(worker.job, kind, value)
            for worker in running.values():
                if worker.silence.too_long and not worker.hung:
                    worker.hung = True
                    worker.process.kill()
    finally:
        started = [worker.process for worker in running.values() if worker.process.pid]
        for process in started:
            process.kill()
        for process in started:
            process.join()


def _what_happened(worker: _Worker) -> str:
    if worker.hung:
        return f"gave no sign of life for {worker.silence.now_s / 60:.0f} minutes and was killed"
    code = worker.process.exitcode
    if code == -signal.SIGKILL:
        return "was killed (exit code -9, as a system does that is short of memory)"
    return f"died (exit code {code})"


def attempt(function: Callable, job: Any, report: Callable[[int], None]) -> tuple[str, Any]:
    """Run a job in a worker: ("finished", result), ("refused", error) or ("failed", traceback)."""
    try:
        return "finished", function(job, report)
    except SynthdepthError as error:
        return "refused", error
    except Exception:
        return "failed", traceback.format_exc()


def finished(job: int, kind: str, value: Any) -> Finished:
    """What `attempt` gave, as an event or as the error that it is."""
    if kind == "refused":
        raise value
    if kind == "failed":
        raise WorkerError(value)
    return Finished(job, value)


@contextlib.contextmanager
def _without_interrupts() -> Iterator[None]:
    """A process started in here never sees Ctrl-C: its parent decides what that means."""
    # Python's tracker is started with the first process otherwise, and lets interrupts through.
    multiprocessing.resource_tracker.ensure_running()
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _die_with_parent() -> None:
    """Have the kernel kill this process when its parent ends, `kill -9` included (Linux)."""
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != multiprocessing.parent_process().pid:
        os._exit(1)  # It ended before it could be asked.


def _work(function: Callable, job: Any, pipe: multiprocessing.connection.Connection) -> None:
    """The whole life of a worker process."""
    _die_with_parent()

    def send(kind: str, value: Any) -> None:
        try:
            pipe.send((kind, value))
        except BrokenPipeError:
            os._exit(1)  # The parent is gone: nobody wants the rest.

    send(*attempt(function, job, lambda done: send("progress", done)))
