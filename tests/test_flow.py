"""Optical flow: what the methods find, what geometry says, and how it is put into a picture."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.camera import Intrinsics, look_rotation, pose
from synthdepth.dataset.preview import random_pairs
from synthdepth.errors import SynthdepthError
from synthdepth.flow import (
    INTERVALS,
    METHODS,
    PX_AT_WHITE,
    DenseLucasKanade,
    Farneback,
    LucasKanade,
    embed,
    end_point_error,
    estimate_flow,
    flow_channels,
    flow_from_depth,
    flow_image,
    flow_luminance,
    heat_map,
)
from synthdepth.maps.world import LABELS
from tests.made import make_dataset

CAMERA = Intrinsics.from_fov(160, 120, 90.0)
DEEP_BLUE = (0, 0, 128)


def texture(height=160, width=200, seed=0):
    """A smooth random picture with detail of 1 to 8 px, (H, W) uint8."""
    rng = np.random.default_rng(seed)
    field = sum(
        k * cv2.GaussianBlur(rng.standard_normal((height, width)), (0, 0), k) for k in (1, 2, 4, 8)
    )
    return cv2.normalize(field, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)


def moved(prev, matrix):
    """Frame t, whose pixel p shows what `prev` does at `matrix` p; that flow; what stays inside."""
    matrix = np.asarray(matrix, np.float64)
    height, width = prev.shape
    y, x = np.mgrid[:height, :width]
    was = np.stack([x, y, np.ones_like(x)], axis=-1) @ matrix.T
    flags = cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP
    rgb = cv2.warpAffine(prev, matrix, (width, height), flags=flags, borderMode=cv2.BORDER_REFLECT)
    inside = ((was >= 8) & (was <= [width - 9, height - 9])).all(axis=-1)
    return rgb, was - np.stack([x, y], axis=-1), inside


SHIFT = [[1, 0, 6.5], [0, 1, -3.25]]
ZOOM = [[0.95, 0, 4], [0, 0.95, 6]]
TURN = [[0.995, -0.06, 7], [0.06, 0.995, -8]]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Four pairs of four scenes, with flow and labels."""
    folder = tmp_path_factory.mktemp("made") / "set"
    make_dataset(folder, shards=4, pairs=1, modalities=("flow", "seg"), camera=CAMERA)
    return random_pairs(folder, 4, 0)


# Methods ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("matrix", [SHIFT, ZOOM, TURN], ids=["shift", "zoom", "turn"])
def test_methods_find_known_motion_on_the_grid_of_t(method, matrix):
    prev = texture()
    rgb, truth, inside = moved(prev, matrix)
    error = end_point_error(estimate_flow(prev, rgb, method), truth, inside)
    assert np.median(error) < 0.25
    assert np.quantile(error, 0.9) < 0.6


@pytest.mark.parametrize("method", METHODS)
def test_flow_points_to_where_a_pixel_was(method):
    """What stands at x = 60 in frame t stood at x = 64 before: u is +4 where the thing is now."""
    ground, thing = texture(seed=1) // 3, texture(40, 40, seed=2) // 2 + 120
    prev, rgb = ground.copy(), ground.copy()
    prev[60:100, 84:124] = rgb[60:100, 80:120] = thing
    flow = estimate_flow(prev, rgb, method)
    assert np.median(flow[66:94, 86:114], axis=(0, 1)) == pytest.approx([4, 0], abs=0.3)
    assert np.abs(np.median(flow[:40], axis=(0, 1))).max() < 0.1


@pytest.mark.parametrize("method", METHODS)
def test_methods_agree_with_the_truth_of_pairs(method, made):
    for pair in made:
        flow = estimate_flow(pair.prev, pair.rgb, method)
        assert flow.shape == (120, 160, 2) and flow.dtype == np.float32
        # Beyond, the pattern is finer than the pixels.
        seen = pair.visible & (pair.seg != LABELS["sky"]) & (pair.depth_m < 60)
        error = end_point_error(flow, pair.flow, seen)
        at_rest = end_point_error(np.zeros_like(flow), pair.flow, seen)
        assert np.median(error) < 0.5
        assert np.median(error) < 0.25 * np.median(at_rest)
        assert np.median(end_point_error(-flow, pair.flow, seen)) > np.median(at_rest)


@pytest.mark.parametrize("method", METHODS)
def test_nothing_moves_between_equal_frames(method):
    frame = texture()
    assert np.abs(estimate_flow(frame, frame, method)).max() < 0.2
    grey = np.full((40, 50), 90, np.uint8)
    assert not flow_luminance(estimate_flow(grey, grey, method)).any()


@pytest.mark.parametrize("method", METHODS)
def test_flow_has_the_same_bytes_with_any_number_of_threads(method):
    prev = texture()
    rgb, _, _ = moved(prev, TURN)
    before, found = cv2.getNumThreads(), set()
    try:
        for threads in (1, 2, 3, 4, 8):
            cv2.setNumThreads(threads)
            found |= {estimate_flow(prev, rgb, method).tobytes() for _ in range(2)}
    finally:
        cv2.setNumThreads(before)
    assert len(found) == 1


@pytest.mark.parametrize("matrix", [SHIFT, ZOOM, TURN], ids=["shift", "zoom", "turn"])
def test_dense_lucas_kanade_agrees_with_opencv_at_its_points(matrix):
    prev = texture(seed=3)
    rgb, _, inside = moved(prev, matrix)
    y, x = np.mgrid[20:140:8, 20:180:8]
    points = np.stack([x, y], axis=-1).reshape(-1, 1, 2).astype(np.float32)
    there, status, _ = cv2.calcOpticalFlowPyrLK(
        rgb, prev, points, None, winSize=(15, 15), maxLevel=3
    )
    good = (status.ravel() > 0) & inside[y, x].ravel()
    ours = estimate_flow(prev, rgb, DenseLucasKanade(radius_px=7, levels=4))[y, x].reshape(-1, 2)
    difference = np.linalg.norm(ours - (there - points)[:, 0], axis=-1)[good]
    assert good.sum() > 150
    assert np.median(difference) < 0.1 and np.quantile(difference, 0.95) < 0.3


def test_dense_lucas_kanade_solves_its_normal_equations():
    """At one level after one step from rest, v is -G^-1 b, summed here window by window."""
    prev, rgb = texture(40, 48, seed=4), np.roll(texture(40, 48, seed=4), 1, axis=1)
    one = DenseLucasKanade(radius_px=3, levels=1, iterations=1, damping=1e-9)
    found = estimate_flow(prev, rgb, one)
    f0, f1 = rgb / 255, prev / 255
    fy, fx = np.gradient(f0)
    for y, x in [(10, 12), (20, 30), (33, 41)]:
        window = np.s_[y - 3 : y + 4, x - 3 : x + 4]
        gradient = np.stack([fx[window].ravel(), fy[window].ravel()])
        b = gradient @ (f1 - f0)[window].ravel()
        expected = -np.linalg.solve(gradient @ gradient.T, b)
        assert found[y, x] == pytest.approx(expected, abs=2e-3)


def test_lucas_kanade_bridges_what_it_cannot_follow():
    """A window without texture takes the flow of what is around it."""
    prev = texture()
    prev[60:100, 80:130] = 128
    rgb, truth, _ = moved(prev, [[1, 0, 3], [0, 1, 2]])
    flow = LucasKanade(window_px=9, levels=2).flow(rgb, prev)
    assert np.median(np.linalg.norm(flow - truth, axis=-1)[70:86, 92:112]) < 0.5


def test_parameters_reach_the_method():
    prev = texture()
    rgb, truth, inside = moved(prev, [[1, 0, 16], [0, 1, 0]])
    near, far = (estimate_flow(prev, rgb, "farneback", levels=n) for n in (0, 3))
    assert np.median(end_point_error(near, truth, inside)) > 5
    assert np.median(end_point_error(far, truth, inside)) < 0.3
    assert np.array_equal(far, estimate_flow(prev, rgb, Farneback(levels=3)))


def test_farneback_without_gain_is_opencv_and_gain_finds_faint_texture():
    prev = (118 + texture() / 32).astype(np.uint8)
    rgb, truth, inside = moved(prev, [[1, 0, 3], [0, 1, -2]])
    plain = estimate_flow(prev, rgb, Farneback(gain=1.0))
    opencv = cv2.calcOpticalFlowFarneback(rgb, prev, None, 0.5, 3, 15, 3, 5, 1.2, 0)
    assert np.array_equal(plain, opencv)
    assert np.median(end_point_error(plain, truth, inside)) > 1
    assert np.median(end_point_error(estimate_flow(prev, rgb), truth, inside)) < 0.5


def test_colour_is_read_as_rgb_and_memory_layout_does_not_matter():
    rng = np.random.default_rng(5)
    prev = np.dstack([texture(seed=s) for s in (6, 7, 8)])
    rgb = np.roll(prev, (1, 2), axis=(0, 1))
    expected = estimate_flow(prev, rgb)
    weights = [0.299, 0.587, 0.114]
    grey = [np.rint(image @ weights).astype(np.uint8) for image in (prev, rgb)]
    assert np.abs(estimate_flow(*grey) - expected).max() < 0.2
    wide = rng.integers(0, 255, (160, 400, 3), np.uint8)
    wide[:, ::2] = prev
    backward = np.ascontiguousarray(rgb[::-1])[::-1]
    backward.setflags(write=False)
    assert np.array_equal(estimate_flow(wide[:, ::2], backward), expected)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("shape", [(16, 16), (17, 61), (16, 200)])
def test_small_and_odd_sizes_work(method, shape):
    flow = estimate_flow(texture(*shape), texture(*shape), method)
    assert flow.shape == (*shape, 2) and np.isfinite(flow).all()


FRAME = np.zeros((32, 40, 3), np.uint8)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((FRAME, FRAME, "raft"), "allowed are farneback, lucas_kanade, lucas_kanade_dense, dis"),
        ((FRAME, FRAME, None), "allowed are farneback"),
        ((FRAME.astype(np.float32), FRAME), r"prev is \(32, 40, 3\) float32: allowed is"),
        ((FRAME, np.zeros((32, 40, 4), np.uint8)), r"rgb is \(32, 40, 4\) uint8"),
        ((FRAME, FRAME[0, 0]), r"rgb is \(3,\) uint8"),
        ((FRAME, FRAME[:0]), r"rgb is \(0, 40, 3\)"),
        ((FRAME, FRAME.tolist()), "rgb is a list: allowed is a numpy array"),
        ((FRAME, FRAME[:20]), "rgb has 40 x 20 pixels and prev 40 x 32"),
        ((FRAME[:9], FRAME[:9]), "frames of 40 x 9 pixels: allowed are 16 or more"),
    ],
)
def test_what_is_no_pair_of_frames_is_refused(arguments, message):
    with pytest.raises(SynthdepthError, match=message):
        estimate_flow(*arguments)


def test_wrong_parameters_are_refused():
    with pytest.raises(SynthdepthError, match="flow method dis: levels is unknown: allowed are pr"):
        estimate_flow(FRAME, FRAME, "dis", levels=3)
    with pytest.raises(SynthdepthError, match="levels = -1: allowed is a whole number from 0 to"):
        estimate_flow(FRAME, FRAME, levels=-1)
    with pytest.raises(SynthdepthError, match="with levels as well"):
        estimate_flow(FRAME, FRAME, Farneback(), levels=2)


# Truth --------------------------------------------------------------------------------------------


def test_flow_from_depth_is_what_pairs_hold(made):
    for pair in made:
        flow = flow_from_depth(
            pair.depth_m,
            pair.camera,
            pair.world_from_cam,
            pair.world_from_cam_prev,
            max_depth_m=pair.meta["max_depth_m"],
        )
        # A place in range, or the sky; what is farther has a depth that the pair does not say.
        known = (pair.depth_m < pair.meta["max_depth_m"]) | (pair.seg == LABELS["sky"])
        assert known.mean() > 0.9
        assert end_point_error(flow, pair.flow, known).max() < 1e-3


def flown(yaw_rad=0.0, way_m=1.0):
    """Poses t and t-1 of a flight along x that turns left, up, or right only by `yaw_rad`."""
    up = np.array([0, 0, 1.0])
    looks = [np.array([np.cos(a), np.sin(a), 0]) for a in (yaw_rad, 0.0)]
    now, before = (look_rotation(look, up) for look in looks)
    return pose(now, np.array([way_m, 0, 0])), pose(before, np.zeros(3))


def test_a_wall_ahead_was_nearer_the_middle_before():
    """Flying 1 m to a wall that is 19 m ahead: it was 20 m ahead, and 19/20 as large."""
    depth = np.full((CAMERA.height, CAMERA.width), 19.0)
    flow = flow_from_depth(depth, CAMERA, *flown())
    v, u = np.mgrid[: CAMERA.height, : CAMERA.width]
    from_middle = np.stack([u - CAMERA.cx, v - CAMERA.cy], axis=-1)
    assert np.allclose(flow, -from_middle / 20, atol=1e-5)
    assert flow.dtype == np.float32


def test_the_sky_moves_by_turning_alone_and_saturated_pixels_as_asked():
    depth = np.full((CAMERA.height, CAMERA.width), 200.0)
    turned = flown(yaw_rad=0.05)
    sky = flow_from_depth(np.full_like(depth, np.inf), CAMERA, *turned)
    # At the middle row, a ray at angle a to the axis was at a - 0.05 before the turn to the left.
    angle = np.arctan2(np.arange(CAMERA.width) - CAMERA.cx, CAMERA.fx)
    row = CAMERA.fx * np.tan(angle - 0.05) + CAMERA.cx - np.arange(CAMERA.width)
    assert sky[60, :, 0] == pytest.approx(row, abs=0.02)
    assert np.array_equal(flow_from_depth(depth, CAMERA, *turned, max_depth_m=200.0), sky)
    still = flow_from_depth(depth, CAMERA, *flown(), max_depth_m=200.0)
    assert np.abs(still).max() < 1e-6
    at_range = flow_from_depth(depth, CAMERA, *turned, max_depth_m=200.0, beyond="range")
    assert np.array_equal(at_range, flow_from_depth(depth, CAMERA, *turned))
    assert not np.array_equal(at_range, sky)
    unknown = flow_from_depth(depth, CAMERA, *turned, max_depth_m=200.0, beyond="unknown")
    assert np.isnan(unknown).all()


def test_unknown_depth_and_places_behind_the_earlier_camera_are_nan():
    depth = np.full((CAMERA.height, CAMERA.width), 5.0)
    depth[0, 0], depth[0, 1] = 0, np.nan
    flow = flow_from_depth(depth, CAMERA, *flown(way_m=-3.0))
    assert np.isnan(flow[0, :2]).all() and np.isfinite(flow[0, 2:]).all()
    assert np.isnan(flow_from_depth(depth, CAMERA, *flown(way_m=-6.0))).all()


def test_flow_from_depth_refuses_what_it_cannot_use():
    depth = np.ones((CAMERA.height, CAMERA.width))
    with pytest.raises(SynthdepthError, match=r"depth_m is \(5, 5\): allowed is \(120, 160\)"):
        flow_from_depth(depth[:5, :5], CAMERA, *flown())
    with pytest.raises(SynthdepthError, match="beyond = 'sky': allowed are infinity, range, unkno"):
        flow_from_depth(depth, CAMERA, *flown(), beyond="sky")
    with pytest.raises(SynthdepthError, match="needs a finite one"):
        flow_from_depth(depth, CAMERA, *flown(), beyond="range")


def test_end_point_error_is_a_distance_over_the_pixels_that_count():
    flow, truth = np.zeros((2, 3, 2), np.float32), np.zeros((2, 3, 2), np.float32)
    truth[0, 0], truth[0, 1], truth[1, 2] = (3, -4), np.nan, (0, 2)
    assert end_point_error(flow, truth).tolist() == [5, 0, 0, 0, 2]
    assert end_point_error(flow, truth, truth[..., 0] == 3).tolist() == [5]
    with pytest.raises(SynthdepthError, match="allowed are equal sizes"):
        end_point_error(flow, truth[:1])


# Embedding ----------------------------------------------------------------------------------------


def heat(grey):
    """The heat map's colour of a luminance, by its definition: three trapezia a quarter wide."""
    place = grey / 255
    return [np.clip(1.5 - abs(4 * place - at), 0, 1) * 255 for at in (3, 2, 1)]


def test_the_heat_map_runs_from_deep_blue_to_deep_red():
    colours = heat_map(np.arange(256, dtype=np.uint8)[None])[0]
    assert tuple(colours[0]) == DEEP_BLUE
    assert tuple(colours[255]) == (128, 0, 0)
    expected = np.array([heat(grey) for grey in range(256)])
    assert np.abs(colours - expected).max() <= 4
    assert len({tuple(colour) for colour in colours.tolist()}) == 256


def literal(rgb, flow, interval, scale, px_at_white):
    """Equation (18), a pixel at a time."""
    height, width = flow.shape[:2]
    length = [[float(np.hypot(*flow[n, m])) for m in range(width)] for n in range(height)]
    white = px_at_white if scale == "fixed" else max(map(max, length)) or 1.0
    embedded = np.zeros_like(rgb)
    for n in range(height):
        for m in range(width):
            grey = round(min(255.0, 255 * length[n][m] / white))
            if n % interval != 0 or m % interval != 0 or grey == 0:
                embedded[n, m] = rgb[n, m]
            else:
                bgr = cv2.applyColorMap(np.uint8([[grey]]), cv2.COLORMAP_JET)
                embedded[n, m] = bgr[0, 0, ::-1]
    return embedded


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    height=st.integers(1, 24),
    width=st.integers(1, 24),
    interval=st.sampled_from(INTERVALS),
    scale=st.sampled_from(["fixed", "frame"]),
    white_steps=st.integers(1, 300),
    still=st.floats(0, 1),
)
def test_embedding_is_equation_18(seed, height, width, interval, scale, white_steps, still):
    rng = np.random.default_rng(seed)
    rgb = rng.integers(0, 256, (height, width, 3), np.uint8)
    flow = rng.normal(0, 10, (height, width, 2)).astype(np.float32)
    # Some pixels rest, some all but rest.
    flow[rng.random((height, width)) < still] *= rng.choice([0, 0.001])
    px_at_white = white_steps / 8 + 0.0137
    # A length on the very boundary of two steps may round either way.
    longest = float(np.hypot(flow[..., 0], flow[..., 1]).max()) or 1.0
    steps = 255 * np.hypot(flow[..., 0], flow[..., 1], dtype=np.float64)
    steps /= px_at_white if scale == "fixed" else longest
    flow[np.abs(steps % 1 - 0.5) < 1e-3] = 0
    found = embed(rgb, flow, interval, scale=scale, px_at_white=px_at_white)
    assert np.array_equal(found, literal(rgb, flow, interval, scale, px_at_white))


def test_the_interval_sets_how_many_pixels_show_flow():
    rgb = np.full((45, 90, 3), 200, np.uint8)
    flow = np.full((45, 90, 2), 3.0, np.float32)
    for interval in INTERVALS:
        changed = (embed(rgb, flow, interval) != rgb).any(axis=-1)
        assert changed.sum() == -(-45 // interval) * -(-90 // interval)
        assert changed[0, 0]
    assert np.array_equal(embed(rgb, flow, 1), flow_image(flow))


def test_still_pixels_and_unknown_ones_keep_the_picture():
    rgb = np.random.default_rng(0).integers(0, 256, (20, 20, 3), np.uint8)
    flow = np.zeros((20, 20, 2), np.float32)
    flow[5, :, 0] = 0.49 * PX_AT_WHITE / 255
    flow[10] = np.nan
    assert np.array_equal(embed(rgb, flow, 1), rgb)
    assert np.array_equal(embed(rgb, flow, 1, scale="frame")[10], rgb[10])
    assert (flow_image(flow) == DEEP_BLUE).all()
    flow[15, :, 1] = -0.51 * PX_AT_WHITE / 255
    embedded = embed(rgb, flow, 5)
    assert (embedded[15, ::5] == heat_map(np.uint8([1]))).all()
    embedded[15, ::5] = rgb[15, ::5]
    assert np.array_equal(embedded, rgb)


def test_the_fixed_scale_means_the_same_in_every_frame_and_the_other_does_not():
    slow = np.full((8, 8, 2), 0, np.float32)
    slow[..., 0] = PX_AT_WHITE / 4
    fast = slow.copy()
    fast[0, 0] = (0, -2 * PX_AT_WHITE)
    assert (flow_luminance(slow) == 64).all()
    assert (flow_luminance(fast)[1:] == 64).all() and flow_luminance(fast)[0, 0] == 255
    assert (flow_luminance(slow, scale="frame") == 255).all()
    assert (flow_luminance(fast, scale="frame")[1:] == 32).all()
    assert (flow_luminance(slow, px_at_white=PX_AT_WHITE / 2) == 128).all()


def test_flow_channels_keep_direction_and_length():
    flow = np.array([[[3.0, -4.0], [1e3, 0.001], [np.nan, 1]]])
    channels = flow_channels(flow, px_at_one=2.0)
    assert channels.dtype == np.float32 and channels.shape == flow.shape
    assert np.allclose(channels, [[[1.5, -2], [500, 0.0005], [0, 0.5]]])


def test_embedding_leaves_its_inputs_alone_and_takes_any_layout():
    rgb = np.random.default_rng(0).integers(0, 256, (20, 20, 3), np.uint8)[::-1, ::2]
    flow = np.asfortranarray(np.random.default_rng(1).normal(0, 9, (20, 10, 2)))
    rgb.setflags(write=False)
    flow.setflags(write=False)
    embedded = embed(rgb, flow, 3)
    expected = embed(rgb.copy(), np.ascontiguousarray(flow, np.float32), 3)
    assert np.array_equal(embedded, expected)
    assert embedded.flags.writeable and not np.shares_memory(embedded, rgb)


STILL = np.zeros((6, 8, 2), np.float32)
PICTURE = np.zeros((6, 8, 3), np.uint8)


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((PICTURE, STILL, 0), {}, "interval = 0: allowed is a whole number from 1"),
        ((PICTURE, STILL, 2.5), {}, r"interval = 2.5"),
        ((PICTURE, STILL), {"scale": "max"}, "scale = 'max': allowed are fixed, frame"),
        ((PICTURE, STILL), {"px_at_white": 0}, "px_at_white = 0: allowed is a number above 0"),
        ((PICTURE, STILL), {"px_at_white": np.nan}, "px_at_white = nan"),
        ((PICTURE[:5], STILL), {}, r"rgb is \(5, 8, 3\) uint8: allowed is \(6, 8, 3\) uint8"),
        ((PICTURE / 255, STILL), {}, r"rgb is \(6, 8, 3\) float64"),
        ((PICTURE, PICTURE), {}, r"flow is \(6, 8, 3\) uint8: allowed is \(H, W, 2\) float"),
        ((PICTURE, STILL.astype(int)), {}, r"flow is \(6, 8, 2\) int64"),
        ((PICTURE, None), {}, "flow is a NoneType"),
    ],
)
def test_what_cannot_be_embedded_is_refused(arguments, options, message):
    with pytest.raises(SynthdepthError, match=message):
        embed(*arguments, **options)
