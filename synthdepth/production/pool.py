"""Worker processes: one fresh process a job, so that nothing leaks from scene to scene.

A job takes a minute or more; a fresh interpreter costs about a second of it, and buys flat memory
and a death that concerns one job only.
"""

import dataclasses
import multiprocessing
import multiprocessing.connection
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from typing import Any

from synthdepth.errors import SynthdepthError

# A job whose process dies (killed for memory, say) is started again this often.
_RETRIES = 2


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


def run_jobs(function: Callable, jobs: Sequence, workers: int) -> Iterator[Progress | Finished]:
    """Run `function(job, report)` for every job in processes of their own, `workers` at a time.

    Args:
        function: importable by name; `report(done)` sends a `Progress`.
        jobs: picklable.
        workers: number of processes at once.

    Raises:
        SynthdepthError: one that a job raised.
        WorkerError: any other error of a job, or a process that died more than `_RETRIES` times.
    """
    context = multiprocessing.get_context("spawn")
    waiting = list(range(len(jobs)))[::-1]
    deaths = [0] * len(jobs)
    running: dict[multiprocessing.connection.Connection, tuple[int, Any]] = {}
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                number = waiting.pop()
                ours, theirs = context.Pipe(duplex=False)
                process = context.Process(target=_work, args=(function, jobs[number], theirs))
                process.start()
                theirs.close()
                running[ours] = number, process
            for pipe in multiprocessing.connection.wait(list(running)):
                number, process = running[pipe]
                try:
                    kind, value = pipe.recv()
                except (EOFError, OSError):
                    # The pipe closed without a result: the process died.
                    process.join()
                    del running[pipe]
                    deaths[number] += 1
                    if deaths[number] > _RETRIES:
                        raise WorkerError(
                            f"worker {number} died {deaths[number]} times, "
                            f"the last time with exit code {process.exitcode}"
                        ) from None
                    waiting.append(number)
                    yield Progress(number, 0)
                    continue
                if kind == "progress":
                    yield Progress(number, value)
                    continue
                process.join()
                del running[pipe]
                if kind == "refused":
                    raise value
                if kind == "failed":
                    raise WorkerError(value)
                yield Finished(number, value)
    finally:
        for _, process in running.values():
            process.kill()
        for _, process in running.values():
            process.join()


def _work(function: Callable, job: Any, pipe: multiprocessing.connection.Connection) -> None:
    """The whole life of a worker process."""
    # Ctrl-C reaches the whole process group; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def send(kind: str, value: Any) -> None:
        try:
            pipe.send((kind, value))
        except BrokenPipeError:
            os._exit(1)  # The parent is gone: nobody wants the rest.

    try:
        result = function(job, lambda done: send("progress", done))
    except SynthdepthError as error:
        send("refused", error)
    except Exception:
        import traceback

        send("failed", traceback.format_exc())
    else:
        send("finished", result)
