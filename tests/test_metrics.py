"""Metrics: laws they obey, values worked out by hand, and averages that merge."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from synthdepth.evaluate.accumulate import Accumulator, ErrorHistogram, image_rows
from synthdepth.evaluate.bootstrap import difference_intervals, scene_intervals
from synthdepth.evaluate.boundaries import THRESHOLDS, boundary_counts, boundary_scores
from synthdepth.evaluate.metrics import METRICS, Metrics, compute_metrics, sum_terms
from synthdepth.seeding import lane

SHAPE = (6, 7)
depths = arrays(np.float64, SHAPE, elements=st.floats(0.5, 200, allow_subnormal=False))
masks = arrays(bool, SHAPE)
ZERO_AT_BEST = [name for name, metric in METRICS.items() if metric.better == "lower"]
ONE_AT_BEST = [name for name, metric in METRICS.items() if metric.better == "higher"]


def by_hand(p, g):
    """The metrics of lists of depths, as their formulas are written."""
    n = len(g)
    d = [a - b for a, b in zip(p, g, strict=True)]
    e = [math.log(a) - math.log(b) for a, b in zip(p, g, strict=True)]
    mean_e, mean_e2 = sum(e) / n, sum(x * x for x in e) / n
    spread = sum((x - mean_e) ** 2 for x in e)
    worse = [max(a / b, b / a) for a, b in zip(p, g, strict=True)]
    return {
        "mean_truth": sum(g) / n,
        "bias": sum(d) / n,
        "mae": sum(map(abs, d)) / n,
        "rmse": math.sqrt(sum(x * x for x in d) / n),
        "abs_rel": sum(abs(x) / b for x, b in zip(d, g, strict=True)) / n,
        "sq_rel": sum(x * x / b for x, b in zip(d, g, strict=True)) / n,
        "sq_rel_devkit": sum(x * x / b**2 for x, b in zip(d, g, strict=True)) / n,
        "rmse_log": math.sqrt(mean_e2),
        "silog_eigen": 100 * math.sqrt(spread / n),
        "silog_devkit": math.sqrt(spread / n),
        "silog_half": math.sqrt(spread / n + 0.5 * mean_e**2),
        "silog_unidepth": 100 * math.sqrt(spread / (n - 1)) if n > 1 else None,
        "log10": sum(abs(math.log10(a) - math.log10(b)) for a, b in zip(p, g, strict=True)) / n,
        "irmse": math.sqrt(sum((1000 / a - 1000 / b) ** 2 for a, b in zip(p, g, strict=True)) / n),
        **{f"delta_{k}": sum(w < 1.25**k for w in worse) / n for k in (1, 2, 3)},
    }


def close(found: Metrics, expected: dict):
    for name, value in expected.items():
        expected_value = None if value is None else pytest.approx(value, rel=1e-6, abs=1e-4)
        assert getattr(found, name) == expected_value, name


@settings(deadline=None, max_examples=60)
@given(depths, depths, masks)
def test_each_metric_is_its_formula_over_the_pixels_of_the_mask(p, g, mask):
    found = compute_metrics(p, g, mask=mask)
    assert found.pixels == mask.sum()
    if mask.any():
        close(found, by_hand(p[mask].tolist(), g[mask].tolist()))


def test_equations_of_the_paper():
    """Two pixels: 10 m seen as 13 m, 100 m seen as 96 m."""
    found = compute_metrics(np.array([[13.0, 96.0]]), np.array([[10.0, 100.0]]))
    assert found.rmse == pytest.approx(math.sqrt((9 + 16) / 2))
    assert found.abs_rel == pytest.approx((0.3 + 0.04) / 2)
    assert (found.delta_1, found.delta_2, found.delta_3) == (0.5, 1.0, 1.0)


def test_the_delta_metrics_leave_out_their_threshold():
    truth = np.array([[16.0, 16.0, 16.0]])
    found = compute_metrics(truth * [[1.25, 1.25**2, 1.25**3]], truth)
    assert (found.delta_1, found.delta_2, found.delta_3) == (0, 1 / 3, 2 / 3)


@settings(deadline=None, max_examples=60)
@given(depths, masks)
def test_a_perfect_prediction(g, mask):
    found = compute_metrics(g, g, mask=mask)
    edges = boundary_counts(g, g, mask)[2, 0] > 0
    for name in ZERO_AT_BEST:
        few = name == "silog_unidepth" and mask.sum() == 1
        assert getattr(found, name) == (0 if mask.any() and not few else None), name
    for name in ONE_AT_BEST:
        there = edges if name.startswith("boundary") else mask.any()
        assert getattr(found, name) == (pytest.approx(1) if there else None), name


@settings(deadline=None, max_examples=60)
@given(depths, depths, st.floats(0.1, 10))
def test_scaling_both_scales_lengths_and_nothing_else(p, g, s):
    one, other = compute_metrics(p, g), compute_metrics(s * p, s * g)
    for name, metric in METRICS.items():
        if name.startswith(("delta", "boundary")):
            continue
        factor = {"m": s, "1/km": 1 / s, "": 1}[metric.unit]
        expected = factor * getattr(one, name)
        assert getattr(other, name) == pytest.approx(expected, rel=1e-6, abs=1e-4), name


@settings(deadline=None, max_examples=60)
@given(depths, depths, st.sampled_from([0.5, 2.0, 4.0]))
def test_deltas_and_depth_edges_know_no_scale(p, g, s):
    one, other = compute_metrics(p, g), compute_metrics(s * p, s * g)
    for name in ("delta_1", "delta_2", "delta_3"):
        assert getattr(one, name) == getattr(other, name)
    if one.boundary_f1 is not None:
        assert other.boundary_f1 == pytest.approx(one.boundary_f1, abs=0.02)


@settings(deadline=None, max_examples=60)
@given(depths, depths, st.floats(0.2, 5))
def test_silog_ignores_the_scale_of_the_prediction_but_not_its_half_variant(p, g, s):
    one, other = compute_metrics(p, g), compute_metrics(s * p, g)
    assert other.silog_eigen == pytest.approx(one.silog_eigen, rel=1e-6, abs=1e-4)
    assert one.silog_eigen == pytest.approx(100 * one.silog_devkit)
    assert one.silog_devkit <= one.silog_half + 1e-9 <= one.rmse_log + 2e-9


@settings(deadline=None, max_examples=60)
@given(depths, depths, st.randoms(use_true_random=False))
def test_the_order_of_pixels_is_nothing(p, g, random):
    order = list(range(p.size))
    random.shuffle(order)
    shuffled = [x.ravel()[order].reshape(SHAPE) for x in (p, g)]
    expected = dataclasses.asdict(compute_metrics(p, g))
    for name, value in dataclasses.asdict(compute_metrics(*shuffled)).items():
        if not name.startswith("boundary"):
            assert value == pytest.approx(expected[name], rel=1e-9, abs=1e-6), name


odd = st.sampled_from([0.0, -1.0, math.nan, math.inf, -math.inf, 1e-30, 1e30, 5.0, 200.0])


@settings(deadline=None, max_examples=60)
@given(arrays(np.float32, SHAPE, elements=odd), arrays(np.float32, SHAPE, elements=odd))
def test_zeros_and_infinities_give_no_nan(p, g):
    found = compute_metrics(p, g)
    known = (g > 0) & np.isfinite(g)
    assert found.pixels == known.sum()
    assert found.unusable == (~(p > 0) & known).sum()
    for name in METRICS:
        value = getattr(found, name)
        assert value is None or math.isfinite(value), name
    if known.any():
        assert found.rmse is not None


def test_no_pixels_give_a_count_of_nothing():
    assert compute_metrics(np.ones((2, 2)), np.zeros((2, 2))) == Metrics()


def test_caps_and_crops_are_respected():
    truth = np.arange(1.0, 25.0).reshape(4, 6)
    wrong = truth + np.where((truth > 10) & (truth < 20), 1.0, 50.0)
    within = compute_metrics(wrong, truth, truth_within_m=(10.5, 19.5))
    assert (within.pixels, within.mae) == (9, 1.0)
    crop = compute_metrics(wrong, truth, crop=np.s_[1:3, 4:6])
    assert (crop.pixels, crop.mean_truth) == (4, (11 + 12 + 17 + 18) / 4)
    assert compute_metrics(truth * 100, truth, clamp_m=(1, 24)).mae == np.mean(24 - truth)


@settings(deadline=None, max_examples=60)
@given(depths, depths, arrays(np.int64, SHAPE, elements=st.integers(0, 4)))
def test_sums_of_groups_are_those_of_their_pixels(p, g, group):
    sums = sum_terms(p.ravel(), g.ravel(), group.ravel(), 5)
    for k in range(5):
        expected = sum_terms(p[group == k], g[group == k])[0]
        np.testing.assert_allclose(sums[k], expected, rtol=1e-12)


# ----- depth edges


def test_an_edge_one_pixel_off_is_missed():
    truth = np.where(np.arange(20) < 10, 10.0, 50.0) * np.ones((20, 1))
    beside = np.where(np.arange(20) < 11, 10.0, 50.0) * np.ones((20, 1))
    assert compute_metrics(truth, truth).boundary_f1 == pytest.approx(1)
    assert compute_metrics(beside, truth).boundary_f1 == 0
    assert compute_metrics(truth[:, ::-1], truth).boundary_f1 == 0  # the other side is nearer


def test_a_blurred_edge_loses_precision_and_a_flat_prediction_recall():
    truth = np.where(np.arange(20) < 10, 10.0, 50.0) * np.ones((20, 1))
    # From 10 m to 50 m in seven steps of 5^(1/7) = 1.258 each: all seven seem edges.
    ramp = 10 * 5 ** (np.clip(np.arange(20) - 6, 0, 7) / 7) * np.ones((20, 1))
    blurred = compute_metrics(ramp, truth)
    assert blurred.boundary_recall == pytest.approx(1)
    assert blurred.boundary_precision == pytest.approx(1 / 7)
    flat = compute_metrics(np.full((20, 20), 30.0), truth)
    assert (flat.boundary_precision, flat.boundary_recall, flat.boundary_f1) == (None, 0, 0)


@settings(deadline=None, max_examples=60)
@given(depths, depths)
def test_depth_edges_by_going_through_all_neighbours(p, g):
    """The counts at each threshold against a loop over pairs of pixels and both directions."""
    counts = np.zeros((3, len(THRESHOLDS)))
    pairs = [((i, j), (i, j + 1)) for i in range(6) for j in range(6)]
    pairs += [((i, j), (i + 1, j)) for i in range(5) for j in range(7)]
    near_a_threshold = False
    for a, b in pairs:
        for one, other in ((a, b), (b, a)):
            for k, t in enumerate(THRESHOLDS):
                ratios = p[one] / p[other] / t, g[one] / g[other] / t
                near_a_threshold |= any(abs(ratio - 1) < 1e-5 for ratio in ratios)
                predicted, true = (ratio > 1 for ratio in ratios)
                counts[:, k] += predicted and true, predicted, true
    if not near_a_threshold:
        np.testing.assert_array_equal(boundary_counts(p, g), counts)


def test_thresholds_are_weighted_by_themselves():
    counts = np.zeros((3, 10))
    counts[:, :3] = [[1, 1, 0], [2, 1, 1], [1, 1, 1]]
    t = THRESHOLDS[:3]
    scores = boundary_scores(counts)
    assert scores["boundary_precision"] == pytest.approx((t[0] / 2 + t[1]) / t.sum())
    assert scores["boundary_recall"] == pytest.approx((t[0] + t[1]) / t.sum())
    assert scores["boundary_f1"] == pytest.approx((t[0] * 2 / 3 + t[1]) / t.sum())


# ----- averages


def pictures(count, seed=0):
    rng = lane(seed, "pictures")
    for _ in range(count):
        g = rng.uniform(2, 200, (8, 8))
        yield g * rng.uniform(0.7, 1.4, (8, 8)), g, rng.random((8, 8)) < rng.uniform(0.1, 1)


def row_of(p, g, mask):
    sums = sum_terms(p[mask], g[mask])[0]
    return image_rows(sums, boundary_counts(p, g, mask))


def test_the_two_averages_against_one_pass_each():
    """The mean of the pictures' metrics, and the metrics of all pixels in one long picture."""
    accumulator, all_p, all_g, singles = Accumulator(), [], [], []
    for number, (p, g, mask) in enumerate(pictures(9)):
        accumulator.add(row_of(p, g, mask), scene=number % 4)
        all_p += p[mask].tolist()
        all_g += g[mask].tolist()
        singles.append(by_hand(p[mask].tolist(), g[mask].tolist()))
    close(accumulator.metrics("pixels"), by_hand(all_p, all_g))
    names = singles[0]
    means = {name: float(np.mean([single[name] for single in singles])) for name in names}
    close(accumulator.metrics("images"), means)
    assert accumulator.metrics("images").rmse != accumulator.metrics("pixels").rmse
    assert accumulator.metrics().images == 9 and accumulator.metrics().pixels == len(all_g)


@settings(deadline=None, max_examples=25)
@given(st.lists(st.integers(0, 2), min_size=6, max_size=6), st.permutations(range(3)))
def test_parts_merge_in_any_order(parts_of, order):
    whole, parts = Accumulator(), [Accumulator() for _ in range(3)]
    for number, (picture, part) in enumerate(zip(pictures(6), parts_of, strict=True)):
        whole.add(row_of(*picture), scene=number % 2)
        parts[part].add(row_of(*picture), scene=number % 2)
    merged = Accumulator()
    for k in order:
        merged.merge(parts[k])
    for average in ("images", "pixels"):
        expected = dataclasses.asdict(whole.metrics(average))
        assert dataclasses.asdict(merged.metrics(average)) == pytest.approx(expected, rel=1e-9)


def test_a_picture_without_pixels_moves_no_average():
    accumulator = Accumulator()
    p, g, mask = next(pictures(1))
    accumulator.add(row_of(p, g, mask))
    before = accumulator.metrics()
    accumulator.add(row_of(p, g, np.zeros_like(mask)))
    assert accumulator.metrics() == before
    assert Accumulator().metrics("pixels") == Metrics()


def test_an_unknown_average_is_refused():
    with pytest.raises(ValueError, match="images, pixels"):
        Accumulator().metrics("both")


def test_the_error_histogram_counts_every_pixel_once():
    histogram, other = ErrorHistogram(), ErrorHistogram()
    truth = np.array([[50.0, 50.0, 50.0, 0.0]])
    histogram.add(np.array([[50.4, 47.2, 900.0, 5.0]]), truth, truth > 0)
    other.merge(histogram)
    at = {float(other.edges_m[k]): int(n) for k, n in enumerate(other.counts) if n}
    assert at == {0.0: 1, -3.0: 1, 199.0: 1}


# ----- confidence intervals


def scenes(effects, pictures_each=5, noise=0.01, name="a"):
    rng = lane(3, "scenes", name)
    accumulator = Accumulator()
    for scene, effect in enumerate(effects):
        for _ in range(pictures_each):
            g = rng.uniform(5, 100, 200)
            p = g * (1 + effect + rng.normal(0, noise, 200))
            accumulator.add(image_rows(sum_terms(p, g)[0]), scene)
    return accumulator.by_scene


def test_intervals_are_as_wide_as_scenes_differ_however_many_pictures_each_has():
    """Scene means drawn with a spread of 0.05: their mean is known to 1.96 x 0.05 / sqrt(40)."""
    effects = lane(1, "effects").normal(0.3, 0.05, 40)
    few, many = (
        scene_intervals(lane(0, "bootstrap"), scenes(effects, count))["abs_rel"]
        for count in (2, 20)
    )
    expected = 2 * 1.96 * np.std(effects) / math.sqrt(40)
    for found in (few, many):
        assert found.low < found.value < found.high
        assert found.high - found.low == pytest.approx(expected, rel=0.15)


def test_intervals_repeat_with_the_lane_and_need_two_scenes():
    rows = scenes([0.1, 0.2, 0.3])
    one, again = (scene_intervals(lane(5, "bootstrap"), rows, average="pixels") for _ in range(2))
    assert one == again
    alone = scene_intervals(lane(5, "bootstrap"), rows[:1])["rmse"]
    assert alone.value > 0 and alone.low is None and alone.high is None


def test_a_small_difference_shows_where_scenes_differ_much():
    """Both predictors are worse in some scenes; one is always 1 % worse, which pairs can tell."""
    effects = lane(2, "effects").normal(0.3, 0.08, 30)
    ours, theirs = scenes(effects, name="a"), scenes(effects + 0.01, name="b")
    apart = [scene_intervals(lane(0, "bootstrap"), rows)["abs_rel"] for rows in (ours, theirs)]
    assert apart[0].high > apart[1].low
    paired = difference_intervals(lane(0, "bootstrap"), ours, theirs)["abs_rel"]
    assert paired.high < 0 and paired.value == pytest.approx(-0.01, abs=0.003)
    with pytest.raises(ValueError, match="30 scenes against 29"):
        difference_intervals(lane(0, "bootstrap"), ours, theirs[1:])
