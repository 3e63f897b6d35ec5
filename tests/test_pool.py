"""Worker processes: results, progress, refusals, deaths and silence."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from synthdepth.errors import FlightError
from synthdepth.production import pool
from synthdepth.production.pool import (
    Finished,
    LostJobError,
    Progress,
    Restarted,
    Silence,
    WorkerError,
    run_jobs,
)


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


def hang_once(job, report):
    """Gives no sign any more the first time it is run; a stop is as deaf as a native deadlock."""
    mark = Path(job)
    if not mark.exists():
        mark.touch()
        report(5)
        os.kill(os.getpid(), signal.SIGSTOP)
    return "second time"


def die(job, report):
    os.kill(os.getpid(), signal.SIGKILL)


def leave(job, report):
    os._exit(7)


def die_by_number(job, report):
    """Dies while its folder holds fewer marks than the job says."""
    folder, deaths = job
    marks = len(list(folder.iterdir()))
    if marks < deaths:
        (folder / str(marks)).touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return marks


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
    first, again, end = run_jobs(die_once, [str(tmp_path / "mark")], 1)
    assert (first, end) == (Progress(0, 5), Finished(0, "second time"))
    assert isinstance(again, Restarted)
    assert (again.job, again.done, again.workers) == (0, 0, 1)
    assert "killed (exit code -9" in again.why


def test_a_hanging_worker_is_killed_and_its_job_started_again(tmp_path, monkeypatch):
    monkeypatch.setattr(pool, "_TICK_S", 0.1)
    # Not so little that a process takes longer to start.
    first, again, end = run_jobs(hang_once, [str(tmp_path / "mark")], 1, patience_s=20.0)
    assert (first, end) == (Progress(0, 5), Finished(0, "second time"))
    assert "no sign of life" in again.why


def test_patience_is_measured_by_the_job_s_own_pace():
    silence = Silence(allowed_s=10.0)
    for pause_s in (3.0, 1.0, 0.5):
        silence.now_s = pause_s
        assert not silence.too_long
        silence.broken()
    silence.now_s = 59.0
    assert not silence.too_long
    silence.now_s = 61.0
    assert silence.too_long
    assert Silence(allowed_s=10.0, now_s=11.0).too_long


@pytest.mark.parametrize(("function", "code"), [(die, -9), (leave, 7)])
def test_a_worker_that_always_dies_ends_the_run_with_one_line(function, code):
    with pytest.raises(LostJobError, match=rf"lost 3 times; the last one .*exit code {code}"):
        list(run_jobs(function, [None], 1))


def test_kills_among_many_mean_fewer_at_once_and_never_the_end(tmp_path):
    events = list(run_jobs(die_by_number, [(tmp_path, 4)], 3))
    restarts = [event.workers for event in events if isinstance(event, Restarted)]
    assert restarts == [3, 2, 1, 1]
    assert events[-1] == Finished(0, 4)


# A parent with a worker that would sleep for long, which tells its number.
_PARENT = """
import os, sys, time
from synthdepth.production.pool import run_jobs

def sleep(job, report):
    report(os.getpid())
    time.sleep(60)

if __name__ == "__main__":
    for event in run_jobs(sleep, [None], 1):
        print(event.done, flush=True)
"""


def is_running(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except FileNotFoundError:
        return False


@pytest.mark.skipif(sys.platform != "linux", reason="the kernel's word to a child is Linux's own")
@pytest.mark.parametrize("kind", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_no_worker_outlives_its_parent_and_ctrl_c_is_the_parent_s_alone(tmp_path, kind):
    script = tmp_path / "parent.py"
    script.write_text(_PARENT)
    with subprocess.Popen(
        [sys.executable, script],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=dict(os.environ, PYTHONPATH=os.getcwd()),
        start_new_session=True,
    ) as parent:
        worker = int(parent.stdout.readline())
        assert is_running(worker)
        status = Path(f"/proc/{worker}/status").read_text()
        blocked = int(status.partition("SigBlk:")[2].split()[0], 16)
        assert blocked & 1 << signal.SIGINT - 1
        # As a terminal does, to the whole group; the others reach the parent only.
        (os.killpg if kind == signal.SIGINT else os.kill)(parent.pid, kind)
        _, complaint = parent.communicate(timeout=30)
    deadline = time.monotonic() + 10
    while is_running(worker) and time.monotonic() < deadline:
        time.sleep(0.01)
    assert not is_running(worker)
    assert complaint.count("Traceback") == (kind == signal.SIGINT)
