"""Breakdowns: each group against its own pixels; and predictors that learnt nothing."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.camera import Intrinsics, look_rotation, pitch_roll_deg, pose, unproject
from synthdepth.dataset.pair import decode_pair
from synthdepth.dataset.sample import Sample, sample_of
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.baselines import (
    BASELINES,
    FITTED,
    ConstantDepth,
    GroundPlane,
    MeanDepth,
    Triangulation,
    make_baseline,
)
from synthdepth.evaluate.breakdown import AXES, THIN_CLASSES, Breakdown, picture_groups, scene_of
from synthdepth.evaluate.evaluation import evaluate_protocol
from synthdepth.evaluate.metrics import compute_metrics
from synthdepth.evaluate.protocols import PROTOCOLS
from synthdepth.flow import flow_from_depth
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane
from tests.made import make_dataset

SHAPE = (24, 32)
BANDS = {
    "0-10 m": (0, 10),
    "10-25 m": (10, 25),
    "25-50 m": (25, 50),
    "50-100 m": (50, 100),
    "100-200 m": (100, 200),
}


def made_sample(number=0, **changes) -> Sample:
    rng = lane(number, "sample")
    depth = np.minimum(np.exp(rng.uniform(0.5, 6, SHAPE)), 200).astype(np.float32)
    depth[:2, :6] = [10, 25, 50, 100, 199.99, 200]
    meta = {
        "map": ("blocks", "city")[number % 2],
        "condition": ("clear", "fog", "night")[number % 3],
        "scene_seed": 100 + number // 2,
        "altitude_m": (3.0, 5.0, 40.0, 500.0)[number % 4],
        "speed_mps": 4.0 * number,
    }
    sample = Sample(
        key=f"k{number}",
        rgb=np.zeros((*SHAPE, 3), np.uint8),
        depth_m=depth,
        valid=rng.random(SHAPE) < 0.9,
        max_depth_m=200.0,
        intrinsics=Intrinsics.from_fov(32, 24, 90).matrix,
        seg=rng.integers(0, len(LABELS), SHAPE).astype(np.uint8),
        meta=meta,
    )
    return dataclasses.replace(sample, **changes)


def guess(sample, number=0):
    noise = lane(number, "guess").normal(0, 0.2, sample.depth_m.shape)
    return (sample.depth_m * np.exp(noise)).astype(np.float32)


def by_name(breakdown):
    """{(axis, name, saturated): result}."""
    results = breakdown.results()
    named = {(r.group.axis, r.group.name, r.group.saturated): r for r in results}
    assert len(named) == len(results)
    return named


def one(sample, prediction=None):
    breakdown = Breakdown()
    breakdown.add(guess(sample) if prediction is None else prediction, sample)
    return by_name(breakdown)


def alike(found, expected, *, boundaries=False):
    for name, value in dataclasses.asdict(expected).items():
        if boundaries or not name.startswith("boundary"):
            assert getattr(found, name) == (None if value is None else pytest.approx(value)), name


def test_each_range_and_class_has_the_metrics_of_its_pixels():
    sample = made_sample()
    found, prediction = one(sample), np.minimum(guess(sample), 200)
    saturated = sample.depth_m == 200

    def expected(mask):
        return compute_metrics(prediction, sample.depth_m, mask=mask & sample.valid)

    for name, (low, high) in BANDS.items():
        inside = (sample.depth_m >= low) & (sample.depth_m < high)
        alike(found["range", name, False].pixels, expected(inside))
    alike(found["range", "saturated", True].pixels, expected(saturated))
    for name, label in LABELS.items():
        for with_saturated in (True, False):
            mask = (sample.seg == label) & (with_saturated | ~saturated)
            alike(found["class", name, with_saturated].images, expected(mask))
    assert all(("class", name, True) in found for name in THIN_CLASSES)


def test_everything_with_and_without_saturated_pixels_is_the_protocols():
    sample = made_sample()
    found = one(sample)
    for name, saturated in (("synthdepth", True), ("synthdepth-in-range", False)):
        expected = evaluate_protocol(
            PROTOCOLS[name],
            guess(sample),
            sample.depth_m,
            valid=sample.valid,
            max_depth_m=200.0,
        )
        alike(found["all", "all", saturated].images, expected, boundaries=True)
        alike(found["map", "blocks", saturated].pixels, expected, boundaries=True)


@settings(deadline=None, max_examples=20)
@given(st.integers(0, 10**6))
def test_ranges_and_classes_share_out_all_pixels(seed):
    sample = made_sample(seed)
    found = one(sample)
    for saturated in (True, False):
        all_pixels = found["all", "all", saturated].pixels.pixels
        classes = [
            r.pixels.pixels for k, r in found.items() if k[0] == "class" and k[2] == saturated
        ]
        ranges = [
            r.pixels.pixels for k, r in found.items() if k[0] == "range" and (saturated or not k[2])
        ]
        assert sum(classes) == sum(ranges) == all_pixels
    assert found["all", "all", True].pixels.pixels == sample.valid.sum()


def test_flights_fall_into_their_bands():
    names = dict(picture_groups({"altitude_m": 5.0, "speed_mps": 2.999, "map": "city"}))
    assert names == {"map": "city", "altitude": "5-15 m", "speed": "0-3 m/s"}
    names = dict(picture_groups({"altitude_m": 130.0, "speed_mps": 0.0}))
    assert names == {"altitude": "120 m and more", "speed": "0-3 m/s"}
    assert picture_groups({}) == []


def test_pictures_are_counted_where_they_belong_and_parts_merge():
    samples = [made_sample(number) for number in range(8)]
    whole, parts = Breakdown(), [Breakdown(), Breakdown()]
    for number, sample in enumerate(samples):
        whole.add(guess(sample, number), sample)
        parts[number // 3 % 2].add(guess(sample, number), sample)
    parts[1].merge(parts[0])
    found, merged = by_name(whole), by_name(parts[1])
    assert found.keys() == merged.keys()
    for key, result in found.items():
        for average in ("images", "pixels"):
            alike(getattr(merged[key], average), getattr(result, average), boundaries=True)
    assert found["map", "city", True].images.images == 4
    assert found["condition", "fog", True].images.images == 3
    assert found["altitude", "120 m and more", False].images.images == 2
    # Scenes 100 to 103 of each map are places of their own.
    assert len(found["all", "all", True].by_scene) == 8
    singles = [compute_metrics(np.minimum(guess(s, k), 200), s.depth_m, mask=s.valid)
               for k, s in enumerate(samples) if s.meta["condition"] == "night"]  # fmt: skip
    mean = np.mean([single.rmse for single in singles])
    assert found["condition", "night", True].images.rmse == pytest.approx(mean)


def test_axes_come_in_order_and_can_be_chosen():
    breakdown = Breakdown()
    breakdown.add(guess(made_sample()), made_sample())
    axes = [result.group.axis for result in breakdown.results()]
    assert sorted(axes, key=AXES.index) == axes and set(axes) == set(AXES)
    ranges = [r.group.name for r in breakdown.results(["range"])]
    assert ranges == [*BANDS, "saturated"]
    classes = [r.group.name for r in breakdown.results(["class"]) if r.group.saturated]
    assert classes == [name for name in LABELS if name in classes]


def test_a_sample_without_labels_and_metadata_has_ranges_only():
    found = one(made_sample(seg=None, meta={}))
    assert {key[0] for key in found} == {"all", "range"}


def test_labels_of_others_and_sensors_without_saturation():
    sample = made_sample(seg=np.full(SHAPE, 200, np.uint8), max_depth_m=math.inf)
    found = one(sample)
    assert not any(key[0] == "class" for key in found)
    assert ("range", "saturated", True) not in found
    assert found["range", "200 m and more", False].pixels.pixels > 0
    assert found["all", "all", True].pixels == found["all", "all", False].pixels


def test_what_is_no_depth_is_counted_and_no_nan():
    sample = made_sample()
    odd = guess(sample)
    odd[::2, ::2] = math.nan
    odd[1::2, ::2] = math.inf
    odd[::2, 1::2] = 0
    found = one(sample, odd)
    counted = found["all", "all", True].pixels
    assert counted.unusable == sample.valid[::2].sum()
    for result in found.values():
        values = dataclasses.asdict(result.images).values()
        assert all(value is None or math.isfinite(value) for value in values)


def test_a_prediction_of_another_size_is_refused():
    with pytest.raises(SynthdepthError, match="k0 has 32x24 pixels, its prediction 7x5"):
        Breakdown().add(np.ones((5, 7)), made_sample())


def test_scenes_are_told_apart_by_what_the_source_knows():
    assert scene_of(made_sample(0)) == scene_of(made_sample(0)) != scene_of(made_sample(2))
    assert scene_of(made_sample(meta={"drive": "2011_09_26_drive_0001_sync"})).endswith("0001_sync")
    assert scene_of(made_sample(meta={})) == "k0"


# ----- baselines


def read_samples(folder):
    return [
        sample_of(decode_pair(key, read_members(path, members)))
        for path in sorted(folder.glob("*/*.tar"))
        for key, members in shard_members(path).items()
    ]


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    folder = make_dataset(tmp_path_factory.mktemp("made"), modalities=("flow", "seg"))
    pairs = read_samples(folder)
    assert len(pairs) == 12
    return pairs


def test_the_constant_and_the_mean_are_means(samples):
    stack = np.stack([sample.depth_m for sample in samples]).astype(np.float64)
    constant, mean = ConstantDepth.fit(iter(samples)), MeanDepth.fit(iter(samples))
    assert constant.depth_m == pytest.approx(stack.mean())
    np.testing.assert_allclose(mean.depth_m, stack.mean(axis=0))
    assert constant(samples[0]).dtype == mean(samples[0]).dtype == np.float32
    every = [compute_metrics(p(s), s.depth_m).rmse for p in (constant, mean) for s in samples]
    assert np.mean(every[12:]) < np.mean(every[:12])
    larger = dataclasses.replace(samples[0], depth_m=np.ones((96, 128), np.float32))
    assert mean(larger).shape == (96, 128)


def test_pixels_without_truth_do_not_count_in_a_mean():
    one, other = made_sample(0), made_sample(1)
    mean = MeanDepth.fit([one, other]).depth_m
    only = one.valid & ~other.valid
    np.testing.assert_allclose(mean[only], one.depth_m[only])
    neither = ~one.valid & ~other.valid
    known = np.concatenate([s.depth_m[s.valid] for s in (one, other)]).astype(np.float64)
    np.testing.assert_allclose(mean[neither], known.mean())


def test_the_ground_plane_is_exact_on_flat_ground(samples):
    for sample in samples:
        ground = (sample.seg == LABELS["ground"]) & (sample.depth_m < 199)
        depth = GroundPlane()(sample)
        np.testing.assert_allclose(depth[ground], sample.depth_m[ground], rtol=1e-4)
        assert (depth[sample.seg == LABELS["sky"]] == 200).all()
        # Without a pose, from pitch and roll.
        bare = dataclasses.replace(sample, world_from_cam=None)
        np.testing.assert_allclose(GroundPlane()(bare), depth, rtol=1e-4)


@given(st.floats(-60, 60), st.floats(-170, 170), st.floats(-40, 40))
def test_the_ground_plane_of_any_attitude(pitch, yaw, roll):
    """Every point that it predicts below the horizon lies at height 0."""
    pitch, yaw, roll = np.radians([pitch, yaw, roll])
    forward = [math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), math.sin(pitch)]
    level = look_rotation(np.array(forward), np.array([0, 0, 1.0]))
    turn = [[math.cos(roll), -math.sin(roll), 0], [math.sin(roll), math.cos(roll), 0], [0, 0, 1]]
    world_from_cam = pose(level @ np.array(turn), np.array([1.0, 2, 30]))
    camera = Intrinsics.from_fov(32, 24, 90)
    angles = dict(zip(("pitch_deg", "roll_deg"), pitch_roll_deg(world_from_cam), strict=True))
    for known in (world_from_cam, None):
        meta = {"altitude_m": 30.0} | angles
        depth = GroundPlane()(made_sample(world_from_cam=known, meta=meta, max_depth_m=1e5))
        below = depth < 1e4
        heights = unproject(depth, camera, world_from_cam)[below][:, 2]
        np.testing.assert_allclose(heights, 0, atol=0.05)


def test_exact_flow_triangulates_the_depth_exactly(samples):
    for sample in samples:
        depth = make_baseline("triangulation-exact-flow")(sample)
        in_range = sample.depth_m < 200
        right = np.abs(depth / sample.depth_m - 1) < 0.01
        # All but what lies where the drone flies to, which does not move.
        assert right[in_range].mean() > 0.97
        assert (depth[~in_range] == 200).all()


def test_a_drone_that_hovers_or_only_turns_triangulates_nothing(samples):
    hovering = dataclasses.replace(samples[0], world_from_cam_prev=samples[0].world_from_cam)
    assert (Triangulation()(hovering) == 200).all()
    turned = hovering.world_from_cam @ pose(
        look_rotation(np.array([0.05, 0.02, 1.0]), np.array([0, -1.0, 0])), np.zeros(3)
    )
    camera = Intrinsics.from_fov(64, 48, 90)
    flow = flow_from_depth(hovering.depth_m, camera, hovering.world_from_cam, turned)
    turning = dataclasses.replace(hovering, world_from_cam_prev=turned, flow=np.nan_to_num(flow))
    assert np.abs(turning.flow).max() > 1
    assert (make_baseline("triangulation-exact-flow")(turning) == 200).all()


@pytest.mark.parametrize("method", ["dis", "farneback"])
def test_estimated_flow_triangulates_what_is_near(method, tmp_path):
    """The ground below 25 m away, from 0.8 m of motion: to a fifth, most of it."""
    camera = Intrinsics.from_fov(160, 120, 90)
    for sample in read_samples(make_dataset(tmp_path / "made", shards=2, pairs=1, camera=camera)):
        near = sample.depth_m < 25
        wrong = np.abs(Triangulation(method=method)(sample) / sample.depth_m - 1)[near]
        assert near.sum() > 1000 and np.median(wrong) < 0.2


def test_a_flow_that_fits_no_place_ahead_has_the_range(samples):
    """Everything moves to the picture's middle, 30 px: on the way there, past the camera."""
    grid = np.stack(np.meshgrid(np.arange(64), np.arange(48)), axis=-1) - [31.5, 23.5]
    away = grid / np.linalg.norm(grid, axis=-1, keepdims=True)
    for sign in (-30, 30):
        wild = dataclasses.replace(samples[0], flow=(sign * away).astype(np.float32))
        depth = Triangulation(method="exact")(wild)
        assert ((depth >= 0.5) & (depth <= 200)).all()


def test_baselines_by_name(samples):
    for name in BASELINES:
        train = samples if name in FITTED else ()
        depth = make_baseline(name, train)(samples[0])
        assert depth.shape == samples[0].depth_m.shape and depth.dtype == np.float32
        assert (depth > 0).all() and depth.max() <= 200


def test_what_a_baseline_lacks_is_said_in_one_line(samples):
    bare = dataclasses.replace(samples[0], prev=None, flow=None, world_from_cam_prev=None, meta={})
    posed = dataclasses.replace(samples[0], prev=None, flow=None)
    lost = dataclasses.replace(samples[0], world_from_cam=None, meta={"altitude_m": 3.0})
    other_size = [made_sample(), samples[0]]
    for call, message in (
        (lambda: make_baseline("median"), "allowed are constant, mean, ground"),
        (lambda: make_baseline("constant"), "there was none"),
        (lambda: make_baseline("mean", []), "there was none"),
        (lambda: make_baseline("mean", other_size), "64x48 pixels, samples before it 32x24"),
        (lambda: GroundPlane()(bare), "altitude_m"),
        (lambda: GroundPlane()(lost), "no pose and no pitch"),
        (lambda: Triangulation()(bare), "two poses"),
        (lambda: Triangulation()(posed), "no frame before it"),
        (lambda: Triangulation(method="exact")(posed), "no flow"),
    ):
        with pytest.raises(SynthdepthError, match=message):
            call()
