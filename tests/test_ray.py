"""Jobs on a Ray cluster of several nodes on this machine: the events of the local pool."""

import os
import signal
import time
from pathlib import Path

import pytest

from synthdepth.dataset.shard import write_whole
from synthdepth.errors import FlightError, SynthdepthError
from synthdepth.production import ray_pool
from synthdepth.production.pool import (
    Finished,
    LostJobError,
    Progress,
    Restarted,
    WorkerError,
    run_jobs,
)
from synthdepth.production.run import render_dataset
from tests.conftest import PAIRS, recipe
from tests.shards_made import contents
from tests.test_simulate import files, run

ray = pytest.importorskip("ray", reason="needs Ray: pip install 'synthdepth[ray]'")

pytestmark = [
    pytest.mark.filterwarnings("ignore::DeprecationWarning"),
    pytest.mark.filterwarnings("ignore::FutureWarning"),
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
]


_STORE = 80 * 2**20  # bytes, the least that Ray allows


@pytest.fixture(scope="module")
def cluster():
    """Three nodes of one core each; this process is on the first."""
    from ray.cluster_utils import Cluster

    each = {"num_cpus": 1, "object_store_memory": _STORE}
    made = Cluster(initialize_head=True, head_node_args=each)
    for _ in range(2):
        made.add_node(**each)
    ray.init(made.address, log_to_driver=False, logging_level="error")
    yield made
    ray.shutdown()
    made.shutdown()


def lose_a_node(cluster):
    """Kill a node with all that runs there, and have a new one come."""
    cluster.remove_node(next(iter(cluster.worker_nodes)), allow_graceful=False)
    cluster.add_node(num_cpus=1, object_store_memory=_STORE)


def write_slowly(job, report):
    """Makes a file of a job's own, as a shard is made, and says where."""
    folder, number = job
    for done in range(3):
        report(done)
        time.sleep(1.2)
    write_whole(Path(folder) / f"{number}.tar", bytes([number]) * 1000)
    return ray.get_runtime_context().get_node_id()


def refuse(job, report):
    raise FlightError(f"no flight for {job}")


def crash(job, report):
    return 1 / 0


def die_once(job, report):
    mark = Path(job)
    if not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return "second time"


def hang_once(job, report):
    mark = Path(job)
    if not mark.exists():
        mark.touch()
        time.sleep(600)
    return "second time"


def die(job, report):
    os.kill(os.getpid(), signal.SIGKILL)


def process(job, report):
    return os.getpid()


@pytest.mark.usefixtures("cluster")
def test_every_job_has_a_process_of_its_own_and_ends_once():
    events = list(ray_pool.run_jobs(process, [1, 2, 3], 2))
    results = {event.job: event.result for event in events if isinstance(event, Finished)}
    assert sorted(results) == [0, 1, 2]
    assert len({*results.values()} - {os.getpid()}) == 3


@pytest.mark.usefixtures("cluster")
def test_refusals_and_crashes_arrive_as_from_the_local_pool():
    with pytest.raises(FlightError, match="no flight for 7"):
        list(ray_pool.run_jobs(refuse, [7]))
    with pytest.raises(WorkerError, match="ZeroDivisionError"):
        list(ray_pool.run_jobs(crash, [7]))


@pytest.mark.usefixtures("cluster")
def test_a_process_that_dies_is_started_again(tmp_path):
    again, end = ray_pool.run_jobs(die_once, [str(tmp_path / "mark")])
    assert isinstance(again, Restarted) and (again.job, again.done) == (0, 0)
    assert end == Finished(0, "second time")


@pytest.mark.usefixtures("cluster")
def test_a_job_that_hangs_is_killed_and_started_again(tmp_path):
    events = list(ray_pool.run_jobs(hang_once, [str(tmp_path / "mark")], patience_s=3.0))
    assert [type(event) for event in events] == [Restarted, Finished]
    assert "no sign of life" in events[0].why


@pytest.mark.usefixtures("cluster")
def test_a_job_that_is_always_lost_ends_the_run(monkeypatch):
    monkeypatch.setattr(ray_pool, "_RETRIES", 1)
    with pytest.raises(LostJobError, match="lost 2 times"):
        list(ray_pool.run_jobs(die, [None]))


def test_a_node_lost_in_the_middle_changes_nothing(cluster, tmp_path):
    jobs = {kind: [(str(tmp_path / kind), k) for k in range(7)] for kind in ("local", "ray")}
    for kind in jobs:
        (tmp_path / kind).mkdir()
    list(run_jobs(make, jobs["local"], 3))
    events, lost = [], False
    for event in ray_pool.run_jobs(write_slowly, jobs["ray"]):
        events.append(event)
        if isinstance(event, Progress) and event.done > 0 and not lost:
            lost = True
            lose_a_node(cluster)
    ended = [event for event in events if isinstance(event, Finished)]
    assert sorted(event.job for event in ended) == list(range(7))
    assert any(isinstance(event, Restarted) for event in events)
    made = [{path.name: path.read_bytes() for path in (tmp_path / kind).iterdir()} for kind in jobs]
    assert made[0] == made[1]
    assert len(made[0]) == 7


def make(job, report):
    """As `write_slowly`, at once."""
    folder, number = job
    write_whole(Path(folder) / f"{number}.tar", bytes([number]) * 1000)


def test_a_cluster_that_does_not_answer_is_one_line(monkeypatch):
    def init(*_, **__):
        raise ConnectionError("Failed to connect to GCS at 10.0.0.9:6379\nsecond line")

    monkeypatch.setattr(ray, "is_initialized", lambda: False)
    monkeypatch.setattr(ray, "init", init)
    told = r"--ray-address 10.0.0.9:6379: no Ray cluster answers: Failed to connect.*6379$"
    with pytest.raises(SynthdepthError, match=told):
        list(ray_pool.run_jobs(process, [1], address="10.0.0.9:6379"))


@pytest.mark.slow
def test_a_cluster_that_loses_a_node_renders_the_bytes_of_one_machine(cluster, dataset, tmp_path):
    folder, lost, restarts = tmp_path / "set", [], []

    def lose_one(done, _):
        if 0 < done < PAIRS and not lost:
            lost.append(done)
            lose_a_node(cluster)

    report = render_dataset(
        recipe(), folder, pairs=PAIRS, executor="ray", on_progress=lose_one,
        on_restart=restarts.append,
    )  # fmt: skip
    assert report.rendered == PAIRS
    assert lost
    assert contents(folder) == contents(dataset)


def test_flights_are_those_of_this_machine(cluster, tmp_path):
    run(tmp_path / "here")
    run(tmp_path / "cluster", run_jobs=ray_pool.run_jobs, workers=None)
    assert files(tmp_path / "cluster") == files(tmp_path / "here")
