"""Worker processes: results, progress, refusals and deaths."""

import os
import signal
from pathlib import Path

import pytest

from synthdepth.errors import FlightError
from synthdepth.production.pool import Finished, Progress, WorkerError, run_jobs


def square(job, report):
    report(1)
    return job * job


def refuse(job, report):
    raise FlightError(f"no flight for {job}")


def crash(job, report):
    return 1 / 0


def die_once(job, report):
    """Kills its own process the first time it is run."""
    mark = Path(job)
    if not mark.exists():
        mark.touch()
        report(5)
        os.kill(os.getpid(), signal.SIGKILL)
    return "second time"


def die(job, report):
    os.kill(os.getpid(), signal.SIGKILL)


def test_all_jobs_finish_once_whatever_the_number_of_workers():
    for workers in (1, 3):
        events = list(run_jobs(square, [2, 3, 4], workers))
        results = {e.job: e.result for e in events if isinstance(e, Finished)}
        assert results == {0: 4, 1: 9, 2: 16}
        assert sum(isinstance(e, Progress) for e in events) == 3


def test_a_refusal_arrives_as_it_was_raised():
    with pytest.raises(FlightError, match="no flight for 7"):
        list(run_jobs(refuse, [7], 1))


def test_a_crash_arrives_with_its_traceback():
    with pytest.raises(WorkerError, match="ZeroDivisionError"):
        list(run_jobs(crash, [7], 1))


def test_a_killed_worker_is_started_again(tmp_path):
    events = list(run_jobs(die_once, [str(tmp_path / "mark")], 1))
    assert events == [Progress(0, 5), Progress(0, 0), Finished(0, "second time")]


def test_a_worker_that_always_dies_ends_the_run():
    with pytest.raises(WorkerError, match="died 3 times, the last time with exit code -9"):
        list(run_jobs(die, [None], 1))
