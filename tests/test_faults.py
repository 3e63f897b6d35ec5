"""A run that is hit where it hurts goes on to the same bytes, or ends with one line."""

import contextlib
import itertools
import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from synthdepth.cli import main
from synthdepth.dataset.manifest import DESCRIPTIONS, MANIFEST, read_manifest
from synthdepth.dataset.shard import partial_of
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.production.pool import Finished, LostJobError, Restarted
from synthdepth.production.storage import GoneError
from tests.shards_made import (
    PAIRS,
    contents,
    in_this_process,
    made_shard,
    render,
    without_rendering,
)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The contents of the dataset of a run that nothing happened to."""
    folder = tmp_path_factory.mktemp("whole") / "set"
    with pytest.MonkeyPatch.context() as patch:
        without_rendering(patch)
        render(folder)
    assert read_manifest(folder)["complete"]
    return contents(folder)


@pytest.fixture
def quick(monkeypatch):
    without_rendering(monkeypatch)
    return monkeypatch


class Killed(BaseException):
    pass


@contextlib.contextmanager
def death_at(number, when):
    """Die at the n-th file that is to get its name; as after `kill -9`, nothing is cleaned up."""
    writes, replace = itertools.count(1), os.replace
    with pytest.MonkeyPatch.context() as patch:

        def dying(source, target):
            if next(writes) == number:
                if when == "half written":
                    os.truncate(source, os.path.getsize(source) // 2)
                if when == "named":
                    replace(source, target)
                patch.setattr(Path, "unlink", lambda *_, **__: None)
                raise Killed(Path(target).name)
            replace(source, target)

        patch.setattr(os, "replace", dying)
        yield


@pytest.mark.parametrize("when", ["half written", "named"])
@pytest.mark.usefixtures("quick")
def test_killed_at_any_file_it_goes_on_to_the_same_bytes(whole, tmp_path, when):
    died_at = []
    for number in itertools.count(1):
        folder = tmp_path / str(number)
        try:
            with death_at(number, when):
                render(folder)
            break
        except Killed as death:
            died_at.append(str(death))
        if (folder / MANIFEST).exists() and read_manifest(folder)["complete"]:
            # Said last of all.
            assert (when, number) == ("named", len(died_at)) and died_at.count(MANIFEST) > 1
        render(folder)
        assert contents(folder) == whole
    assert {*DESCRIPTIONS} < {*died_at} and died_at[-1] == MANIFEST


def shard_then(what, at=1):
    """Makes shards, and does `what(folder)` before the one with the number `at`."""

    def make(job, recipe, folder, progress):
        if job.scene_index == at:
            what(folder)
        return made_shard(job, recipe, folder, progress)

    return make


def test_a_full_disk_ends_the_run_with_what_is_safe_and_what_to_do(quick, whole, tmp_path):
    def fill(folder):
        full = partial_of(folder / "test" / "blocks-test-000000.tar")
        full.parent.mkdir()
        full.symlink_to("/dev/full")

    folder = tmp_path / "set"
    without_rendering(quick, shard_then(fill))
    with pytest.raises(DatasetError, match="is full: free space.*the 3 pairs of finished shards"):
        render(folder)
    assert not [name for name in contents(folder) if name.endswith(".partial")]
    without_rendering(quick)
    assert render(folder).rendered == PAIRS - 3
    assert contents(folder) == whole


@pytest.mark.parametrize("how", ["deleted", "unmounted", "moved"])
def test_a_folder_that_goes_ends_the_run_and_nothing_is_written_where_it_was(quick, tmp_path, how):
    folder = tmp_path / "set"

    def go(_):
        folder.rename(tmp_path / "elsewhere")
        if how == "unmounted":
            folder.mkdir()

    def while_a_worker_starts(function, jobs, workers, patience_s):
        events = in_this_process(function, jobs, workers, patience_s=patience_s)
        yield next(events)
        go(folder)
        yield from events

    without_rendering(quick, run_jobs=while_a_worker_starts)
    with pytest.raises(GoneError, match="deleted, moved or unmounted while the run wrote to it"):
        render(folder)
    assert not folder.exists() or not any(folder.iterdir())


def test_a_shard_that_goes_during_the_run_is_told_and_rendered_again(quick, whole, tmp_path):
    folder = tmp_path / "set"
    first = folder / "train" / "blocks-train-000000.tar"
    without_rendering(quick, shard_then(lambda _: first.unlink(), at=2))
    with pytest.raises(DatasetError, match=r"blocks-train-000000.tar was deleted or changed"):
        render(folder)
    assert not read_manifest(folder)["complete"]
    without_rendering(quick)
    assert render(folder).rendered == 3
    assert contents(folder) == whole


def test_a_shard_cut_off_is_rendered_again(quick, whole, tmp_path):
    folder = tmp_path / "set"
    render(folder)
    first = folder / "train" / "blocks-train-000000.tar"
    for size in (20_000, first.stat().st_size - 10_240):
        os.truncate(first, size)
        assert render(folder).rendered == 3
        assert contents(folder) == whole


def test_a_shard_that_is_lost_again_and_again_is_named(quick, tmp_path):
    def lost(function, jobs, workers, patience_s):
        yield Finished(0, function(jobs[0], lambda done: None))
        raise LostJobError(1, "its worker was lost 3 times; the last one died (exit code -11)")

    without_rendering(quick, run_jobs=lost)
    told = (
        r"test/blocks-test-000000.tar could not be rendered: its .*-11\); the 3 pairs of finished"
    )
    with pytest.raises(SynthdepthError, match=told):
        render(tmp_path / "set")


ARGUMENTS = ["render", "--map", "blocks", "--pairs", "8", "--pairs-per-scene", "3"]
ARGUMENTS += ["--pairs-per-flight", "3", "--burst-pairs", "3", "--size", "64x48"]


@pytest.mark.parametrize("kind", [signal.SIGINT, signal.SIGTERM])
def test_stopped_by_a_signal_it_says_what_is_safe(quick, whole, tmp_path, capsys, kind):
    folder, before = tmp_path / "set", signal.getsignal(signal.SIGTERM)
    without_rendering(quick, shard_then(lambda _: os.kill(os.getpid(), kind)))
    arguments = [*ARGUMENTS, "--variant", "scalar", "--out", str(folder)]
    assert main(arguments) == 128 + kind
    assert f"stopped: finished shards in {folder} are safe" in capsys.readouterr().out
    assert signal.getsignal(signal.SIGTERM) == before
    without_rendering(quick)
    assert main(arguments) == 0
    assert contents(folder) == whole


def test_ray_that_is_not_installed_is_told_before_anything_is_written(quick, tmp_path, capsys):
    quick.setitem(sys.modules, "ray", None)
    assert main([*ARGUMENTS, "--executor", "ray", "--out", str(tmp_path / "set")]) == 2
    assert "pip install 'synthdepth[ray]'" in capsys.readouterr().err
    assert not (tmp_path / "set").exists()


def test_a_worker_killed_for_memory_is_told_in_one_line(quick, tmp_path, capsys):
    def short_of_memory(function, jobs, workers, patience_s):
        yield Restarted(0, 0, "was killed (exit code -9, ...)", 3)
        yield from in_this_process(function, jobs, workers, patience_s=patience_s)

    without_rendering(quick, run_jobs=short_of_memory)
    arguments = [*ARGUMENTS, "--variant", "scalar", "--out", str(tmp_path / "set")]
    assert main(arguments) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "a worker" in line]
    assert lines == ["a worker was killed (exit code -9, ...): its shard begins again, 3 at once"]


def test_a_worker_with_other_software_is_refused(quick, tmp_path):
    from synthdepth.production import ledger, run

    def upgraded(function, jobs, workers, patience_s):
        quick.setattr(ledger, "software", None)
        quick.setattr(run, "software", lambda variant: {"mitsuba": "9.9.9"})
        return in_this_process(function, jobs, workers, patience_s=patience_s)

    without_rendering(quick, run_jobs=upgraded)
    with pytest.raises(DatasetError, match=r"has mitsuba 9\.9\.9, the run was started with"):
        render(tmp_path / "set")


@pytest.mark.slow
def test_killed_again_and_again_it_ends_with_the_same_bytes(tmp_path):
    """Real processes, real rendering, real `kill -9`; `tools/fault_harness.py` does it for long."""
    harness = Path(__file__).parents[1] / "tools" / "fault_harness.py"
    command = [sys.executable, harness, "--kills", "12", "--json", tmp_path / "faults.json"]
    subprocess.run([*map(str, command), "--folder", str(tmp_path / "work")], check=True)
    figures = json.loads((tmp_path / "faults.json").read_text())
    assert figures["kills"] >= 12
    assert (figures["unequal"], figures["orphans"]) == ([], 0)
