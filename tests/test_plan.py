"""Which scene gives which shard, and which frames of a flight become pairs."""

import dataclasses

import pytest

from synthdepth.errors import SynthdepthError
from synthdepth.production.plan import plan_shards
from synthdepth.production.recipe import SamplingRecipe
from synthdepth.production.shots import shots_of_flight
from synthdepth.seeding import lane


def plan(pairs, seed=0, train_share=0.5, pairs_per_scene=10):
    return plan_shards(
        map_name="neighborhood",
        seed=seed,
        pairs=pairs,
        pairs_per_scene=pairs_per_scene,
        train_share=train_share,
    )


def test_a_longer_plan_begins_with_the_shorter():
    short, long = plan(37), plan(95)
    assert [job.pairs for job in short] == [10, 10, 10, 7]
    assert short[:3] == long[:3]
    assert dataclasses.replace(short[3], pairs=10) == long[3]
    assert sum(job.pairs for job in long) == 95


def test_scenes_alternate_between_train_and_test():
    jobs = plan(40)
    assert [job.split for job in jobs] == ["train", "test", "train", "test"]
    assert [job.path for job in jobs][:3] == [
        "train/neighborhood-train-000000.tar",
        "test/neighborhood-test-000000.tar",
        "train/neighborhood-train-000001.tar",
    ]


@pytest.mark.parametrize(("share", "train"), [(0.0, 0), (1.0, 100), (0.8, 80), (0.25, 25)])
def test_the_train_share_is_kept(share, train):
    assert sum(job.split == "train" for job in plan(1000, train_share=share)) == train


def test_every_seed_gives_other_scenes():
    assert {job.scene_seed for job in plan(100)}.isdisjoint(
        job.scene_seed for job in plan(100, seed=1)
    )


@pytest.mark.parametrize("wrong", [{"pairs": 0}, {"pairs": -3}, {"pairs": 5, "train_share": 1.5}])
def test_impossible_counts_are_refused(wrong):
    with pytest.raises(SynthdepthError, match="allowed is"):
        plan(**wrong)


@pytest.mark.parametrize(("per_flight", "burst"), [(32, 4), (10, 4), (5, 1), (3, 8)])
def test_bursts_are_consecutive_and_do_not_overlap(per_flight, burst):
    sampling = SamplingRecipe(pairs_per_flight=per_flight, burst_pairs=burst)
    shots = shots_of_flight(lane(0, "bursts", 0), 2, sampling.frames_per_flight + 40, sampling)
    assert len(shots) == per_flight
    frames = [shot.frame_index for shot in shots]
    assert frames == sorted(set(frames))
    assert min(frames) >= 1
    assert max(frames) < sampling.frames_per_flight + 40
    # One picture, one number: frame t-1 of a pair inside a burst is frame t of the pair before.
    number_of = {shot.frame_index: shot.number for shot in shots}
    assert len(set(number_of.values())) == per_flight
    for shot in shots:
        earlier = number_of.get(shot.frame_index - 1)
        assert earlier is None or earlier == shot.prev_number


def test_a_flight_that_is_just_long_enough_is_used_whole():
    sampling = SamplingRecipe(pairs_per_flight=8, burst_pairs=4)
    shots = shots_of_flight(lane(0, "bursts", 0), 0, sampling.frames_per_flight, sampling)
    assert [shot.frame_index for shot in shots] == [1, 2, 3, 4, 6, 7, 8, 9]
