"""The developers' programs under tools/: their pure functions on inputs whose figures are known."""

import importlib.util
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from tests.conftest import flat_world, ground, wall
from tests.made import make_dataset

TOOLS = Path(__file__).parents[1] / "tools"


def load(name):
    """A program by its path: tools/ is not a package."""
    spec = importlib.util.spec_from_file_location(name, TOOLS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


statistics = load("image_statistics")
coverage = load("depth_coverage")
diversity = load("diversity")
detection = load("gate_detection")


def noise(slope, height=256, width=256, seed=0):
    """Luminance whose power falls as frequency to the `slope`, with a mean of 0.5."""
    rng = np.random.default_rng(seed)
    f = np.hypot(np.fft.fftfreq(height)[:, None], np.fft.fftfreq(width)[None])
    f[0, 0] = np.inf
    wave = np.fft.fft2(rng.standard_normal((height, width)))
    # Phases alone are random, so that every wave has the power that it should have.
    field = np.fft.ifft2(wave / np.abs(wave) * f ** (slope / 2)).real
    return 0.5 + 0.1 * field / field.std()


def grey_frame(level, height=8, width=8):
    return np.full((height, width, 3), level, np.uint8)


@pytest.mark.parametrize("slope", [-1.0, -2.0, -2.9])
@pytest.mark.parametrize("height", [144, 256])
def test_spectrum_slope_is_recovered(slope, height):
    # One frame tells its slope to 0.1 only: it has few waves in its lowest ring.
    found = [statistics.spectrum_slope(noise(slope, height, seed=seed)) for seed in range(6)]
    assert np.mean(found) == pytest.approx(slope, abs=0.1)


def test_spectrum_slope_does_not_depend_on_contrast():
    field = noise(-2.5)
    faint = statistics.spectrum_slope(0.3 + 0.01 * field)
    assert faint == pytest.approx(statistics.spectrum_slope(field), abs=1e-6)


def test_kurtosis_of_gaussian_noise_is_three_and_of_rare_edges_large():
    rng = np.random.default_rng(0)
    gaussian = rng.standard_normal((300, 300))
    assert statistics.gradient_kurtosis(gaussian) == pytest.approx(3, abs=0.1)
    steps = np.zeros((10, 101))
    steps[:, 50:] = 1  # One step of 1 among 100 of 0: (p q^4 + q p^4) / (p q)^2 at p = 0.01.
    assert statistics.gradient_kurtosis(steps) == pytest.approx(0.9703 / 0.0099, rel=1e-3)


def test_flat_share():
    assert statistics.flat_share(np.full((20, 30), 0.7)) == 1
    assert statistics.flat_share(np.tile(np.linspace(0, 1, 30), (20, 1))) == 1
    # A step of one level is an edge to the two columns beside it.
    step = np.full((20, 12), 100 / 255)
    step[:, 6:] = 101 / 255
    assert statistics.flat_share(step) == pytest.approx(8 / 10)


def test_entropy_and_saturation():
    levels = np.arange(256).reshape(16, 16) / 255
    assert statistics.entropy_bits(levels) == pytest.approx(8)
    assert statistics.entropy_bits(np.full((16, 16), 0.2)) == 0
    half = grey_frame(80)
    assert statistics.mean_saturation(half) == 0
    half[:4] = (200, 100, 50)
    assert statistics.mean_saturation(half) == pytest.approx(0.75 / 2)
    assert statistics.mean_saturation(grey_frame(0)) == 0


def test_a_constant_frame_has_no_slope_and_is_left_out_of_its_median():
    empty = statistics.summarise([grey_frame(90, 64, 64)])
    assert empty["figures"]["slope"]["median"] is None
    assert not empty["figures"]["slope"]["in_real_range"]
    picture = np.repeat(
        (255 * np.clip(noise(-2.5, 64, 64), 0, 1)).astype(np.uint8)[..., None], 3, 2
    )
    both = statistics.summarise([grey_frame(90, 64, 64), picture])
    assert both["frames"] == 2
    assert both["figures"]["slope"] == statistics.summarise([picture])["figures"]["slope"]
    assert "none*" in statistics.table({"flat": empty})


def test_only_frames_larger_than_256_px_are_resized():
    small = grey_frame(3, 144, 256)
    assert statistics.comparable(small) is small
    assert statistics.comparable(grey_frame(3, 375, 1242)).shape == (256, 256, 3)
    assert statistics.comparable(grey_frame(3, 100, 680)).shape == (100, 256, 3)


def test_real_frames_are_grouped_and_ground_truth_left_out(tmp_path):
    for name, image in {
        "kitti_a/x.png": grey_frame(1),
        "kitti_b/y.jpg": grey_frame(2),
        "kitti_b/depth.png": np.ones((8, 8), np.uint16),
        "airsim/z.png": grey_frame(3),
        "airsim/mask.png": np.ones((8, 8), np.uint8),
    }.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        assert cv2.imwrite(str(tmp_path / name), image)
    groups = statistics.real_groups(tmp_path)
    assert {name: [p.name for p in paths] for name, paths in groups.items()} == {
        "airsim": ["z.png"],
        "kitti": ["x.png", "y.jpg"],
    }


def test_spread_takes_the_first_and_the_last():
    assert statistics.spread(3, 10) == [0, 1, 2]
    assert statistics.spread(101, 3) == [0, 50, 100]


def test_bands_hold_their_lower_edge_and_saturation_is_its_own():
    edges = coverage.band_edges(200.0)
    assert edges == [0, 10, 25, 50, 100, 200]
    depth = np.array([0.5, 10, 24.9, 25, 50, 99, 100, 199.9, 200], np.float32)
    assert coverage.band_of(depth, edges).tolist() == [0, 1, 1, 2, 3, 3, 4, 4, 5]
    assert coverage.band_edges(40.0) == [0, 10, 25, 40]


def test_coverage_sums_to_one_by_map_condition_and_class():
    rng = np.random.default_rng(1)
    found = coverage.Coverage(edges_m=coverage.band_edges(200.0))
    for condition in ("clear", "fog", "clear"):
        depth = np.minimum(rng.uniform(1, 300, (20, 30)), 200).astype(np.float32)
        found.add(depth, condition, rng.integers(0, 3, (20, 30)).astype(np.uint8))
    report = found.report()
    rows = [report["shares"], *report["by_condition"].values()]
    for row in report["by_class"].values():
        rows.append({band: row[band] for band in report["shares"]})
    assert len(rows) == 1 + 2 + 3
    assert all(sum(row.values()) == pytest.approx(1) for row in rows)
    assert sum(row["share_of_pixels"] for row in report["by_class"].values()) == pytest.approx(1)
    assert {"sky", "ground", "road"} == set(report["by_class"])
    assert report["frames"] == 3 and json.dumps(report)


def test_coverage_marks_what_breaks_the_rule():
    depth = np.repeat([5, 15, 30, 70, 150, 200], [10, 10, 4, 10, 6, 60]).astype(np.float32)
    found = coverage.Coverage(edges_m=coverage.band_edges(200.0))
    found.add(depth.reshape(10, 10), "clear")
    report = found.report()
    assert report["breaks_rule"] == ["25-50 m", "saturated"]
    assert report["nearest_m"]["p0"] == 5
    assert report["frames_nearer_than"] == {"1 m": 0, "2 m": 0, "5 m": 0, "10 m": 1}
    assert "4.0*" in coverage.text("map", report) and "60.0*" in coverage.text("map", report)


def test_layout_distance_of_a_turned_or_mirrored_copy_is_zero_and_of_another_is_not():
    rng = np.random.default_rng(2)
    raster, other = rng.uniform(0, 1, (2, 3, 8, 8)).astype(np.float32)
    for copy in (np.rot90(raster, 3, axes=(1, 2)), raster[:, :, ::-1], raster.transpose(0, 2, 1)):
        assert diversity.layout_distance(raster, copy) == 0
    assert diversity.layout_distance(raster, other) > 0.1
    assert len({image.tobytes() for image in diversity.symmetries(raster)}) == 8
    report = diversity.layout_report(np.stack([raster, other, raster[:, ::-1]]), 0.05)
    assert report["smallest"] == 0 and report["nearest_scenes"] == (0, 2)
    assert not report["no_two_alike"]


def test_splitting_keeps_the_area_and_drops_what_lies_elsewhere():
    rng = np.random.default_rng(4)
    area = np.array([[-10.0, -10.0], [10.0, 10.0]])
    inside = rng.uniform(-9, 9, (20, 3, 3))
    pieces = diversity.split(inside, 2.0, area)
    assert np.ptp(pieces[..., :2], axis=1).max() <= 2
    areas = diversity.triangle_areas(inside).sum()
    assert diversity.triangle_areas(pieces).sum() == pytest.approx(areas)
    assert len(diversity.split(inside + 100, 2.0, area)) == 0


def test_figures_of_a_scene_of_known_size():
    """A wall of 120 m x 120 m on a ground of 10 km: what lies within the 200 m x 200 m area."""
    world = flat_world([ground(), wall(20.0, half_m=60.0)])
    points = diversity.surface_points(world)
    labels = diversity.label_figures(world, points)
    assert labels["building"]["area_m2"] == pytest.approx(120 * 120, rel=1e-3)
    assert labels["ground"]["area_m2"] == pytest.approx(200 * 200, rel=0.03)
    # The wall reaches from 60 m below the ground to 60 m above it.
    assert labels["building"]["height_shares"][0] == pytest.approx(0.5, abs=0.03)
    assert labels["building"]["height_shares"][-2] == pytest.approx(1 / 6, abs=0.03)
    raster = diversity.layout(points, world.flight_bounds)
    building = raster[diversity.LAYOUT_LABELS.index("building")]
    assert raster.sum() == building.sum()
    assert set(np.flatnonzero(building.any(axis=1))) == {int((20 + 100) / 200 * 32)}
    assert (building.sum(axis=0) > 0).sum() == pytest.approx(120 / 200 * 32, abs=2)


def test_the_gate_finds_faults_and_accuses_nobody(tmp_path, capsys):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=4)
    options = detection.Options(folders=(folder,), pairs=2, json=tmp_path / "figures.json")
    assert detection.main(options) == 0
    figures = json.loads((tmp_path / "figures.json").read_text())
    assert figures["judged"] == 8 and figures["accused"] == []
    found = {name: (c["in a file"], c["rendered"]) for name, c in figures["found"].items()}
    assert found["none"] == (0, 0)
    assert found["rgb black"] == found["prev frozen"] == found["flow of another scene"] == (2, 2)
    # What meta.json tells of motion and depth, it does not tell if it is wrong itself.
    assert found["pose 1 m aside"][0] == found["depth times 1.1"][0] == 2
    assert "8 right pairs, 0 accused" in capsys.readouterr().out


def test_one_shard_alone_has_no_other_scene(tmp_path, capsys):
    folder = make_dataset(tmp_path / "set", shards=1, pairs=1)
    assert detection.main(detection.Options(folders=(folder,))) == 2
    assert "fewer than two shards" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("tool", "arguments", "said"),
    [
        (statistics, [], "nothing to look at"),
        (statistics, ["nowhere"], "nowhere holds no dataset"),
        (statistics, ["nowhere", "--frames", "0"], "--frames 0"),
        (statistics, ["--real", "nowhere"], "--real nowhere"),
        (coverage, ["nowhere"], "nowhere holds no dataset"),
        (diversity, ["--map", "nowhere"], "--map nowhere is unknown"),
        (diversity, ["--map", "neighborhood", "--scenes", "1"], "--scenes 1"),
        (diversity, ["--map", "neighborhood", "--json", "nowhere/x.json"], "--json nowhere"),
    ],
)
def test_bad_input_is_one_line_and_exit_2(tool, arguments, said, capsys):
    assert tool.main(arguments) == 2
    out, error = capsys.readouterr()
    assert out == "" and said in error and error.count("\n") == 1
