"""Pairs that fail the gate give their places to others, the same ones every time."""

import dataclasses
import functools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synthdepth.dataset.pair import decode_pair, encode_png, pair_key
from synthdepth.dataset.shard import read_members, sha256_of, shard_members
from synthdepth.production import shard_job
from synthdepth.production.plan import ShardJob
from synthdepth.production.pool import Finished, run_jobs
from synthdepth.production.recipe import SamplingRecipe
from synthdepth.production.shard_job import GateError, run_shard_job
from synthdepth.production.shots import REDRAWS, Shot, shots_of_flight, spares
from synthdepth.seeding import lane
from tests.made import CAMERA, _members, _pose
from tests.shards_made import recipe
from tests.test_gate import reach

JOB = ShardJob(
    scene_index=1, scene_seed=7, split="test", path="test/blocks-test-000000.tar", pairs=3
)
FRAMES = 40


# Which frames


@given(
    seed=st.integers(0, 100),
    frames=st.integers(40, 200),
    pairs=st.integers(1, 9),
    burst=st.integers(1, 4),
)
def test_spares_are_other_frames_and_no_two_shots_share_one(seed, frames, pairs, burst):
    sampling = SamplingRecipe(pairs_per_scene=99, pairs_per_flight=pairs, burst_pairs=burst)
    shots = shots_of_flight(lane(seed, "bursts", 3), 3, frames, sampling)
    drawn = [spares(seed, shot, frames, sampling) for shot in shots]
    every = [shot.frame_index for shot in shots] + [s.frame_index for some in drawn for s in some]
    assert len(set(every)) == len(every)
    assert all(1 <= frame < frames for frame in every)
    assert all(len(some) == REDRAWS for some in drawn)
    for shot, some in zip(shots, drawn, strict=True):
        assert {(s.flight_index, s.number, s.prev_number) for s in some} == {
            (3, shot.number, shot.prev_number)
        }
    assert drawn[0] == spares(seed, shots[0], frames, sampling)


def test_a_flight_without_other_frames_has_no_spares():
    sampling = SamplingRecipe(pairs_per_scene=8, pairs_per_flight=8, burst_pairs=8)
    (first, *_), frames = shots_of_flight(lane(0, "bursts", 0), 0, 9, sampling), 9
    assert spares(0, first, frames, sampling) == []


# A scene by formula, with faults planted in some of its frames.


class Studio:
    """As `studio.Studio`, of the wall and the ground of `tests.made`: one flight past them."""

    def __init__(self, job, recipe, cost, faults):
        self._job, self._recipe, self._faults, self.cost = job, recipe, faults, cost
        rng = lane(job.scene_seed, "bursts", 0)
        self.shots = shots_of_flight(rng, 0, FRAMES, recipe.sampling)[: job.pairs]
        self.renderer = type("World", (), {"reach": staticmethod(reach)})

    def key(self, shot: Shot) -> str:
        return pair_key("blocks", self._job.scene_index, 0, shot.frame_index)

    def spares(self, shot: Shot) -> list[Shot]:
        return spares(self._job.scene_seed, shot, FRAMES, self._recipe.sampling)

    def files(self, shot: Shot) -> dict[str, bytes]:
        self.cost.render_s.append(0.0)
        frame = shot.frame_index
        known = {name: getattr(self._job, name) for name in ("scene_index", "scene_seed", "split")}
        known |= {"frame_index": frame, "condition": "clear"}
        poses = [_pose(step, 6.0, 0.1) for step in (frame - 1, frame)]
        files = _members(CAMERA, poses, known, (), 200.0)
        return self._faults.get(self.key(shot), lambda files: files)(files)


def black(files):
    return files | {"rgb.png": encode_png(np.zeros((48, 64, 3), np.uint8))}


def no_file(files):
    return {name: data for name, data in files.items() if name != "prev.png"}


def planted(monkeypatch, **faults):
    keys = {key.replace("_", "-"): fault for key, fault in faults.items()}
    monkeypatch.setattr(shard_job, "Studio", functools.partial(Studio, faults=keys))


def made(folder, job=JOB):
    return run_shard_job(job, recipe(), folder, lambda done: None)


def keys_of(folder):
    return list(shard_members(folder / JOB.path))


@pytest.fixture
def right(monkeypatch, tmp_path):
    """Keys and record of the shard without a fault."""
    planted(monkeypatch)
    record = made(tmp_path / "right")
    return keys_of(tmp_path / "right"), record


def test_a_right_shard_is_as_planned(right):
    keys, record = right
    assert len(keys) == 3 and record["redrawn"] == []
    assert record["cost"]["gate_s"] > 0


@pytest.mark.parametrize(("fault", "why"), [(black, "rgb.png is black"), (no_file, "lacks prev")])
def test_a_wrong_pair_gives_its_place_to_another_frame(monkeypatch, tmp_path, right, fault, why):
    keys, _ = right
    planted(monkeypatch, **{keys[1]: fault})
    again = made(tmp_path / "again")
    there = keys_of(tmp_path / "again")
    assert (there[0], there[2]) == (keys[0], keys[2]) and there[1] not in keys
    (entry,) = again["redrawn"]
    assert entry["key"] == there[1] and entry["instead_of"] == keys[1] and why in entry["why"]
    for key, members in shard_members(tmp_path / "again" / JOB.path).items():
        decode_pair(key, read_members(tmp_path / "again" / JOB.path, members))


def test_depth_that_rays_do_not_find_is_no_pair(monkeypatch, tmp_path, right):
    """Everything else agrees: only the world knows that the depth is another's."""
    keys, _ = right
    planted(monkeypatch)
    moved = type("World", (), {"reach": staticmethod(lambda pose, d: 1.01 * reach(pose, d))})
    monkeypatch.setattr(Studio, "renderer", moved, raising=False)
    monkeypatch.setattr(Studio, "__setattr__", _all_but("renderer"))
    with pytest.raises(GateError, match="is not what rays find") as caught:
        made(tmp_path / "wrong")
    assert caught.value.key == keys[0]
    assert not list((tmp_path / "wrong").rglob("*.*"))


def _all_but(name):
    def put(self, key, value):
        if key != name:
            object.__setattr__(self, key, value)

    return put


def test_what_cannot_pass_stops_the_run_with_one_line(monkeypatch, tmp_path, right):
    keys, _ = right
    studio = Studio(JOB, recipe(), shard_job.Cost(), {})
    wrong = [keys[1], *(studio.key(spare) for spare in studio.spares(studio.shots[1]))]
    planted(monkeypatch, **dict.fromkeys(wrong, black))
    with pytest.raises(GateError) as caught:
        made(tmp_path / "none")
    assert caught.value.key == keys[1]
    assert "scene seed 7" in str(caught.value) and "rgb.png is black" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert not list((tmp_path / "none").rglob("*.*"))
    planted(monkeypatch, **dict.fromkeys(wrong[:-1], black))
    assert made(tmp_path / "last")["redrawn"][0]["key"] == wrong[-1]


def test_the_run_says_which_command_renders_the_pair_alone(monkeypatch, tmp_path, right):
    from synthdepth.errors import SynthdepthError
    from tests.shards_made import render, without_rendering

    monkeypatch.setattr(shard_job, "Studio", functools.partial(Studio, faults=_Always(black)))
    without_rendering(monkeypatch, run_shard_job)
    with pytest.raises(SynthdepthError, match=r"synthdepth pair \S+ blocks-s00000-f000-\d+ "):
        render(tmp_path / "set")


class _Always(dict):
    def __init__(self, fault):
        super().__init__()
        self._fault = fault

    def get(self, key, default=None):
        return self._fault


# Extending


def test_an_extended_shard_keeps_what_was_drawn_again(monkeypatch, tmp_path, right):
    keys, _ = right
    planted(monkeypatch, **{keys[0]: black, keys[2]: black})
    whole = made(tmp_path / "whole")
    first = made(tmp_path / "grown", dataclasses.replace(JOB, pairs=2))
    planted(monkeypatch, **{keys[2]: black})  # What is there is not asked again.
    second = made(tmp_path / "grown", dataclasses.replace(JOB, extends=first))
    assert second["sha256"] == whole["sha256"] and second["redrawn"] == whole["redrawn"]
    assert len(second["redrawn"]) == 2


def test_a_lost_record_is_known_by_the_keys(monkeypatch, tmp_path, right):
    keys, _ = right
    planted(monkeypatch, **{keys[0]: black})
    whole = made(tmp_path / "whole")
    first = made(tmp_path / "grown", dataclasses.replace(JOB, pairs=2))
    lost = first | {"redrawn": None, "cost": None}
    second = made(tmp_path / "grown", dataclasses.replace(JOB, extends=lost))
    assert second["sha256"] == whole["sha256"]
    assert second["redrawn"] == [whole["redrawn"][0] | {"why": None}]


def test_a_damaged_shard_is_not_extended_but_made_anew(monkeypatch, tmp_path, right):
    """Its damage would get a new checksum."""
    _, record = right
    planted(monkeypatch)
    first = made(tmp_path / "grown", dataclasses.replace(JOB, pairs=2))
    path = tmp_path / "grown" / JOB.path
    data = bytearray(path.read_bytes())
    data[1000] ^= 16
    path.write_bytes(data)
    second = made(tmp_path / "grown", dataclasses.replace(JOB, extends=first))
    assert second["sha256"] == record["sha256"] == sha256_of(path)


# Workers


def planted_job(job, report, *, folder):
    """What a worker does: a shard in which every second planned pair is black."""
    with pytest.MonkeyPatch.context() as patch:
        studio = Studio(job, recipe(), shard_job.Cost(), {})
        wrong = [studio.key(shot) for shot in studio.shots[::2]]
        planted(patch, **dict.fromkeys(wrong, black))
        return run_shard_job(job, recipe(), folder, report)


def test_redraws_are_the_same_whatever_the_workers(tmp_path):
    jobs = [
        dataclasses.replace(JOB, scene_seed=seed, scene_index=seed, path=f"test/{seed}.tar")
        for seed in range(2)
    ]
    found = []
    for workers in (1, 2):
        folder = tmp_path / str(workers)
        work = functools.partial(planted_job, folder=folder)
        done = [e.result for e in run_jobs(work, jobs, workers) if isinstance(e, Finished)]
        found.append({r["path"]: (r["sha256"], str(r["redrawn"])) for r in done})
    assert found[0] == found[1] and len(found[0]) == 2
    assert all(redrawn.count("black") == 2 for _, redrawn in found[0].values())
