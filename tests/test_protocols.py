"""Protocols: each against the same thing done pixel by pixel, and what they say of real frames."""

import dataclasses
import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.evaluation import Evaluation, evaluate_protocol, metric_table
from synthdepth.evaluate.prepare import crop_slices, fill_background, kb_slices, resize_linear
from synthdepth.evaluate.protocols import (
    PROTOCOLS,
    Protocol,
    compare,
    find_protocol,
    find_protocols,
    resized,
    with_scaling,
)
from synthdepth.evaluate.published import EIGEN_SPLIT, TABLES
from synthdepth.kitti.calibration import object_calibration
from synthdepth.kitti.lidar import project_lidar, read_points
from synthdepth.seeding import lane
from tests.real import REAL, needs_real

KITTI = tuple(name for name, protocol in PROTOCOLS.items() if protocol.truth != "dense")
real = needs_real("kitti_depth")


# ----- each protocol, pixel by pixel

# (rows, columns) of a 375x1242 picture, as published; (lowest, highest, ends count, least pixels);
# what predictions are clamped to; whether medians are made equal.
BY_HAND = {
    "eigen-garg-full-80": ((153, 371), (44, 1197), (1e-3, 80, False, 1), (1e-3, 80), False),
    "eigen-garg-kb-80": ((166, 372), (56, 1185), (1e-3, 80, False, 1), (1e-3, 80), False),
    "eigen-crop-80": ((124, 342), (44, 1197), (1e-3, 80, False, 1), (1e-3, 80), False),
    "benchmark": ((0, 375), (0, 1242), (0, math.inf, False, 1), None, False),
    "monodepth2-eigen": ((153, 371), (44, 1197), (1e-3, 80, False, 1), (1e-3, 80), True),
    "monodepth2-benchmark": ((0, 375), (0, 1242), (0, math.inf, False, 1), (1e-3, 80), True),
    "depth-anything-80": ((0, 375), (0, 1242), (1e-3, 80, True, 10), None, False),
    "unidepth": ((166, 372), (56, 1185), (0, 80, False, 1), None, False),
}


def by_hand(name, prediction, truth):
    """Metrics of a picture of 375x1242, going through its pixels; None if it is left out."""
    rows, columns, (low, high, ends, least), clamp, scale = BY_HAND[name]
    p, g = [], []
    for r, c in np.argwhere(truth > 0).tolist():
        inside = rows[0] <= r < rows[1] and columns[0] <= c < columns[1]
        t = float(truth[r, c])
        counts = low <= t <= high if ends else low < t < high
        if inside and counts:
            p.append(float(prediction[r, c]))
            g.append(t)
    if len(g) < least:
        return None
    if scale:
        ratio = sorted_median(g) / sorted_median(p)
        p = [ratio * x for x in p]
    if clamp:
        p = [min(max(x, clamp[0]), clamp[1]) for x in p]
    n, pairs = len(g), list(zip(p, g, strict=True))
    e = [math.log(a / b) for a, b in pairs]
    e1, e2 = sum(e) / n, sum(x * x for x in e) / n
    return {
        "pixels": n,
        "mean_truth": sum(g) / n,
        "abs_rel": sum(abs(a - b) / b for a, b in pairs) / n,
        "sq_rel": sum((a - b) ** 2 / b for a, b in pairs) / n,
        "sq_rel_devkit": sum((a - b) ** 2 / b**2 for a, b in pairs) / n,
        "rmse": math.sqrt(sum((a - b) ** 2 for a, b in pairs) / n),
        "rmse_log": math.sqrt(e2),
        "log10": sum(abs(x) for x in e) / n / math.log(10),
        "silog_eigen": 100 * math.sqrt(e2 - e1**2),
        "silog_devkit": math.sqrt(e2 - e1**2),
        "silog_half": math.sqrt(e2 - 0.5 * e1**2),
        "silog_unidepth": 100 * math.sqrt((e2 - e1**2) * n / (n - 1)),
        "irmse": 1000 * math.sqrt(sum((1 / a - 1 / b) ** 2 for a, b in pairs) / n),
        "delta_1": sum(max(a / b, b / a) < 1.25 for a, b in pairs) / n,
        "delta_2": sum(max(a / b, b / a) < 1.25**2 for a, b in pairs) / n,
        "delta_3": sum(max(a / b, b / a) < 1.25**3 for a, b in pairs) / n,
    }


def sorted_median(values):
    ordered, half = sorted(values), len(values) // 2
    return ordered[half] if len(ordered) % 2 else (ordered[half - 1] + ordered[half]) / 2


def scan(seed=0, shape=(375, 1242), points=4000):
    """Sparse depths all over a picture, a few beyond 80 m or exactly there; and a prediction."""
    rng = lane(seed, "scan")
    truth = np.zeros(shape, np.float32)
    at = rng.integers(0, shape[0], points), rng.integers(0, shape[1], points)
    truth[at] = rng.uniform(2, 95, points)
    truth[at[0][::40], at[1][::40]] = 80.0
    noise = rng.normal(0.1, 0.3, shape)
    return (np.where(truth > 0, truth, 20) * np.exp(noise)).astype(np.float32), truth


@pytest.mark.parametrize("name", KITTI)
def test_against_going_through_the_pixels(name):
    prediction, truth = scan()
    found = evaluate_protocol(PROTOCOLS[name], prediction, truth)
    for metric, value in by_hand(name, prediction, truth).items():
        assert getattr(found, metric) == pytest.approx(value, rel=1e-6), metric


def test_every_protocol_of_kitti_is_checked_so():
    assert set(BY_HAND) == set(KITTI)


def test_protocols_for_dense_truth():
    """A picture of 4 pixels at 10 m, 2 at 100 m and 2 saturated at 200 m, one seen beyond it."""
    truth = np.array([[10.0, 10, 10, 10, 100, 100, 200, 200]])
    guess = np.array([[11.0, 11, 11, 11, 90, 90, 100, 5000]])
    every = evaluate_protocol(PROTOCOLS["synthdepth"], guess, truth, max_depth_m=200.0)
    inside = evaluate_protocol(PROTOCOLS["synthdepth-in-range"], guess, truth, max_depth_m=200.0)
    paper = evaluate_protocol(PROTOCOLS["paper"], guess, truth, max_depth_m=200.0)
    assert every.rmse == pytest.approx(math.sqrt((4 * 1 + 2 * 100 + 100**2) / 8))
    assert inside.rmse == pytest.approx(math.sqrt((4 * 1 + 2 * 100) / 6))
    assert (every.pixels, inside.pixels) == (8, 6)
    assert (paper.rmse, paper.abs_rel) == (every.rmse, pytest.approx((0.4 + 0.2 + 0.5) / 8))
    assert paper.boundary_f1 is None and every.boundary_f1 > 0


# ----- the parts


@pytest.mark.parametrize("shape", [(375, 1242), (370, 1224), (376, 1241), (352, 1216)])
def test_crops_are_cut_as_published(shape):
    """Garg's and the benchmark's, with int(), on every size KITTI has."""
    height, width = shape
    rows, columns = crop_slices((height, width), "garg")
    assert (rows.start, rows.stop) == (int(0.40810811 * height), int(0.99189189 * height))
    assert (columns.start, columns.stop) == (int(0.03594771 * width), int(0.96405229 * width))
    rows, columns = kb_slices((height, width))
    assert (rows.start, rows.stop) == (height - 352, height)
    assert (columns.start, columns.stop) == (
        int((width - 1216) / 2),
        int((width - 1216) / 2) + 1216,
    )


def test_a_picture_smaller_than_the_benchmarks_is_refused_in_one_line():
    with pytest.raises(SynthdepthError, match="256x256.*1216x352"):
        evaluate_protocol(PROTOCOLS["unidepth"], np.ones((256, 256)), np.ones((256, 256)))


@pytest.mark.parametrize("corners", [True, False])
@pytest.mark.parametrize("shape", [(37, 61), (9, 8), (20, 120), (1, 1)])
def test_resizing_is_that_of_pytorch(corners, shape):
    torch = pytest.importorskip("torch")
    image = lane(0, "image").uniform(1, 80, (20, 30))
    expected = torch.nn.functional.interpolate(
        torch.from_numpy(image)[None, None], shape, mode="bilinear", align_corners=corners
    )[0, 0]
    np.testing.assert_allclose(resize_linear(image, shape, corners), expected.numpy(), rtol=1e-9)


def test_resizing_without_corners_is_that_of_opencv():
    image = lane(0, "image").uniform(1, 80, (20, 30))
    expected = cv2.resize(image, (97, 41), interpolation=cv2.INTER_LINEAR)
    np.testing.assert_allclose(resize_linear(image, (41, 97), False), expected, rtol=1e-6)


def test_disparity_is_resized_as_disparity():
    """Half way between 10 m and 90 m: the mean of the depths is 50 m, of the disparities 18 m."""
    edge = np.array([[10.0, 90.0]])
    assert resized(edge, (1, 3), "corners")[0, 1] == pytest.approx(50)
    assert resized(edge, (1, 3), "disparity")[0, 1] == pytest.approx(18)


def test_a_small_prediction_is_brought_to_the_truths_size():
    prediction, truth = scan()
    small = cv2.resize(prediction, (620, 188), interpolation=cv2.INTER_AREA)
    for name in KITTI:
        wanted = cv2.resize(small, (1242, 375), interpolation=cv2.INTER_LINEAR)
        if PROTOCOLS[name].resize == "disparity":
            wanted = 1 / cv2.resize(1 / small, (1242, 375), interpolation=cv2.INTER_LINEAR)
        found = evaluate_protocol(PROTOCOLS[name], small, truth)
        expected = evaluate_protocol(PROTOCOLS[name], wanted, truth)
        exact = PROTOCOLS[name].resize != "corners"
        assert found.rmse == pytest.approx(expected.rmse, rel=1e-5 if exact else 0.1), name
        assert exact or found.rmse != expected.rmse, name


def test_a_network_that_sees_the_benchmarks_part_is_pasted_into_the_picture():
    prediction, truth = scan()
    part = prediction[23:, 13:1229]
    for name in ("eigen-garg-full-80", "eigen-crop-80", "eigen-garg-kb-80", "unidepth"):
        whole = evaluate_protocol(PROTOCOLS[name], prediction, truth)
        assert evaluate_protocol(PROTOCOLS[name], part, truth, shows="kb") == whole, name
    # Where the protocol has no crop, what is around the part counts as not predicted.
    counts = (truth > 0) & (truth <= 80)
    counts[23:, 13:1229] = False
    found = evaluate_protocol(PROTOCOLS["depth-anything-80"], part, truth, shows="kb")
    assert found.unusable == np.count_nonzero(counts) > 0


def test_gaps_are_filled_as_the_devkit_fills_them():
    nan = math.nan
    gappy = [[nan, nan, nan, nan], [nan, 5, 0, 9], [7, nan, -1, nan], [math.inf, nan, nan, nan]]
    filled = fill_background(np.array(gappy))
    assert filled.tolist() == [[5, 5, 5, 9], [5, 5, 5, 9], [7, 7, 7, 7], [7, 7, 7, 7]]
    prediction, truth = scan()
    holes = np.where(lane(0, "holes").random(truth.shape) < 0.3, 0, prediction)
    found = evaluate_protocol(PROTOCOLS["benchmark"], holes, truth)
    assert found.unusable == 0
    assert evaluate_protocol(PROTOCOLS["depth-anything-80"], holes, truth).unusable > 0


def test_the_ends_of_the_range_count_only_where_they_should():
    truth = np.full((375, 1242), 80.0)
    truth[:, ::2] = 40
    strict = evaluate_protocol(PROTOCOLS["eigen-garg-full-80"], truth, truth)
    closed = dataclasses.replace(PROTOCOLS["eigen-garg-full-80"], inclusive=True)
    assert strict.mean_truth == 40
    assert evaluate_protocol(closed, truth, truth).mean_truth == pytest.approx(60, abs=0.1)


@pytest.mark.parametrize("points", [9, 10])
def test_depth_anything_leaves_out_pictures_under_ten_pixels(points):
    truth = np.zeros((375, 1242))
    truth[200, :points] = 20
    evaluation = Evaluation([PROTOCOLS["depth-anything-80"]])
    evaluation.add(np.full_like(truth, 19), truth)
    (result,) = evaluation.results()
    assert (result.images.images, result.left_out) == ((1, 0) if points == 10 else (0, 1))
    assert str(result)


def test_medians_are_made_equal_before_the_clamp():
    """A prediction in other units is as good as one in metres; a clamped one would not be."""
    prediction, truth = scan()
    for name in ("monodepth2-eigen", "synthdepth/median", "eigen-garg-full-80/median"):
        protocol = find_protocol(name)
        found = evaluate_protocol(protocol, prediction, truth)
        assert evaluate_protocol(protocol, prediction * 1000, truth).rmse == pytest.approx(
            found.rmse
        )
        compared = compare(protocol, prediction / 7, truth)
        medians = [np.median(x[compared.mask]) for x in (compared.prediction, compared.truth)]
        assert medians[0] == pytest.approx(medians[1], rel=1e-6)
    metric = find_protocol("monodepth2-eigen/metric")
    assert evaluate_protocol(metric, prediction * 1000, truth).delta_1 < 0.3 < found.delta_1


odd = st.sampled_from([0.0, -3.0, math.nan, math.inf, -math.inf, 40.0])


@settings(max_examples=12, deadline=None)
@given(st.lists(odd, min_size=4, max_size=4))
def test_no_protocol_makes_nan_of_what_is_no_depth(values):
    truth = np.zeros((375, 1242))
    truth[200:204, 600] = truth[250:260, 600] = 30
    prediction = np.full(truth.shape, 25.0)
    prediction[200:204, 600] = values
    for protocol in PROTOCOLS.values():
        found = evaluate_protocol(protocol, prediction, truth, max_depth_m=200.0)
        for name in protocol.metrics:
            value = getattr(found, name)
            undefined = value is None and name.startswith("boundary")
            assert undefined or math.isfinite(value), (protocol.name, name)


# ----- names, results


def test_an_unknown_protocol_lists_the_known_ones():
    for name in ("eigen", "paper/scaled", ""):
        with pytest.raises(SynthdepthError) as caught:
            find_protocol(name)
        assert all(known in str(caught.value) for known in PROTOCOLS)
        assert "\n" not in str(caught.value)


def test_a_protocol_checks_its_choices():
    with pytest.raises(SynthdepthError, match="crop 'middle': allowed are none, garg, eigen"):
        Protocol(name="x", follows="nobody", crop="middle")
    with pytest.raises(SynthdepthError, match="metric 'a1'"):
        Protocol(name="x", follows="nobody", metrics=("a1",))


def test_scaling_is_part_of_the_name():
    protocol = PROTOCOLS["paper"]
    assert with_scaling(protocol, "median").name == "paper/median"
    assert with_scaling(with_scaling(protocol, "median"), "metric") == dataclasses.replace(
        protocol, name="paper/metric"
    )
    assert find_protocols(["paper", "paper/median", "paper"]) == [
        protocol,
        with_scaling(protocol, "median"),
    ]


def test_what_is_no_image_is_refused():
    for wrong in (np.ones(5), np.ones((3, 4, 1)), np.ones((0, 4))):
        with pytest.raises(SynthdepthError, match="allowed is"):
            compare(PROTOCOLS["paper"], wrong, np.ones((3, 4)))


def test_several_protocols_at_once_are_each_alone_and_say_which_they_are():
    protocols = find_protocols([*KITTI, "eigen-garg-full-80/median"])
    evaluation, parts = Evaluation(protocols), [Evaluation(protocols), Evaluation(protocols)]
    pictures = [scan(seed, points=500) for seed in range(3)]
    for number, (prediction, truth) in enumerate(pictures):
        evaluation.add(prediction, truth, scene=number, truth_is="groundtruth")
        parts[number % 2].add(prediction, truth, scene=number, truth_is="groundtruth")
    parts[0].merge(parts[1])
    table = metric_table(evaluation.results())
    for result, merged in zip(evaluation.results(), parts[0].results(), strict=True):
        singles = [evaluate_protocol(result.protocol, *picture) for picture in pictures]
        mean = np.mean([single.abs_rel for single in singles])
        assert result.images.abs_rel == pytest.approx(mean)
        assert merged.images.rmse == pytest.approx(result.images.rmse)
        assert result.by_scene.shape[0] == 3
        text = str(result)
        assert text.startswith(f"{result.protocol.name}: ") and "3 pictures" in text
        assert all(name in text for name in result.protocol.metrics)
        assert ("ground truth here" in text) == (result.protocol.truth != "groundtruth")
        assert result.terms in table
    with pytest.raises(ValueError, match="different protocols"):
        evaluation.merge(Evaluation(protocols[:1]))
    with pytest.raises(SynthdepthError, match="at least one"):
        Evaluation([])


def test_published_rows_name_protocols_that_exist():
    for row in (row for table in TABLES.values() for row in table):
        assert row.source and (row.protocol is None or row.protocol in PROTOCOLS)
        assert 0 < row.delta_1 < (row.delta_2 or 1) < (row.delta_3 or 1.1)
    assert {row.method for row in EIGEN_SPLIT} >= {"BTS", "monodepth2"}


# ----- real frames


def real_frame():
    path = REAL / "kitti_depth/groundtruth_depth/0000000005.png"
    return cv2.imread(str(path), cv2.IMREAD_UNCHANGED).astype(np.float32) / 256


def made_up_prediction(truth):
    """Flat ground 1.65 m below a KITTI camera, 60 m above its horizon: wrong, and not absurd."""
    row = np.arange(truth.shape[0])[:, None] - 172.9
    depth = np.where(row > 0, 1.65 * 721.5 / np.maximum(row, 1e-3), 60.0)
    return np.minimum(depth, 60.0) * np.ones((1, truth.shape[1]))


@real
def test_the_protocols_differ_on_a_real_frame_as_documented():
    truth = real_frame()
    assert truth.shape[0] >= 370 and 0.1 < np.mean(truth > 0) < 0.3
    found = {
        name: evaluate_protocol(PROTOCOLS[name], made_up_prediction(truth), truth) for name in KITTI
    }
    full, kb = found["eigen-garg-full-80"], found["eigen-garg-kb-80"]
    # In the benchmark's frame Garg's crop is lower, so nearer.
    assert 16.35 < kb.mean_truth < 17.2 < 17.4 < full.mean_truth < 18.2
    assert kb.pixels < full.pixels
    assert found["unidepth"].mean_truth == kb.mean_truth
    assert found["unidepth"].silog_unidepth == pytest.approx(kb.silog_eigen, rel=1e-3)
    # Without a crop more counts, and without a cap also what lies beyond 80 m.
    assert full.pixels < found["depth-anything-80"].pixels < found["benchmark"].pixels
    beyond = np.count_nonzero(truth > 80)
    assert found["benchmark"].pixels - found["depth-anything-80"].pixels == beyond > 0
    assert full.silog_eigen != found["depth-anything-80"].silog_half * 100
    results = {(m.abs_rel, m.rmse) for name, m in found.items() if name != "unidepth"}
    assert len(results) == len(KITTI) - 1


@real
def test_a_perfect_prediction_is_perfect_under_all_of_them():
    truth = real_frame()
    for name in KITTI:
        dense = np.where(truth > 0, truth, 20)
        found = evaluate_protocol(PROTOCOLS[name], dense, truth)
        # The clamp moves what lies beyond 80 m where it counts all the same.
        if name != "monodepth2-benchmark":
            assert (found.rmse, found.delta_1) == (0, 1), name
        else:
            assert 0 < found.rmse < 1


@real
def test_the_scanners_x_is_no_depth():
    """A perfect prediction of camera depth against monodepth2's exported ground truth."""
    off, errors = [], []
    for frame in ("000000", "000001", "000002"):
        folder = REAL / "kitti_object/training"
        picture = cv2.imread(str(folder / f"image_2/{frame}.png"))
        calibration = object_calibration(folder / f"calib/{frame}.txt")
        points = read_points(folder / f"velodyne/{frame}.bin")
        depth, exported = (
            project_lidar(points, calibration, picture.shape[:2], variant)
            for variant in ("monodepth2", "velodyne_x")
        )
        metric = find_protocol("monodepth2-eigen/metric")
        found = evaluate_protocol(metric, np.where(depth > 0, depth, 20), exported)
        off.append(-found.bias)
        errors.append(found.abs_rel)
    assert all(0.25 < value < 0.35 for value in off), off
    assert all(0.018 < value < 0.033 for value in errors), errors
