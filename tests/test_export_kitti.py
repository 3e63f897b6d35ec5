"""Our datasets in KITTI's format: read back by ourselves, and as KITTI's own description says."""

import json
import math
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from synthdepth.camera import Intrinsics
from synthdepth.dataset.folder import new_folder
from synthdepth.dataset.manifest import read_manifest, write_index
from synthdepth.dataset.shard import ShardWriter, read_members, shard_members
from synthdepth.errors import DatasetError
from synthdepth.export.folder import read_pairs, write_file
from synthdepth.export.kitti import drive_name, export_kitti, timestamps
from synthdepth.kitti.dataset import KittiDataset
from synthdepth.kitti.png import encode_depth, read_depth
from synthdepth.kitti.splits import read_split
from tests.made import make_dataset

CAMERA = Intrinsics(width=64, height=40, fx=40.5, fy=41.25, cx=30.0, cy=20.5)


@pytest.fixture(scope="module")
def source(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("ours") / "set", camera=CAMERA)


@pytest.fixture(scope="module", params=["invalid", "saturated"])
def exported(request, source, tmp_path_factory):
    out = tmp_path_factory.mktemp("theirs") / "kitti"
    return request.param, out, export_kitti(source, out, sky=request.param)


def place_of(pair):
    meta = pair.meta
    drive = drive_name(meta["scene_index"], meta["flight_index"])
    return drive, meta["frame_index"]


def test_it_comes_back_the_same(source, exported):
    sky, out, report = exported
    pairs = {place_of(pair): pair for pair in read_pairs(source)}
    data = KittiDataset(out)
    assert data.layout == "depth" and len(data) == len(pairs) == report.pairs == 12
    for sample in data:
        pair = pairs.pop((sample.meta["drive"], sample.meta["frame_index"]))
        np.testing.assert_array_equal(sample.rgb, pair.rgb)
        np.testing.assert_array_equal(sample.prev, pair.prev)
        far = pair.depth_m >= 200
        assert far.any() and not far.all()
        np.testing.assert_allclose(sample.depth_m[~far], pair.depth_m[~far], rtol=0, atol=1 / 512)
        assert sample.valid[~far].all()
        assert (sample.valid[far] == (sky == "saturated")).all()
        assert (sample.depth_m[far] == (200 if sky == "saturated" else 0)).all()
        assert sample.max_depth_m == (200 if sky == "saturated" else math.inf)
        np.testing.assert_allclose(sample.intrinsics, CAMERA.matrix, rtol=1e-12)
        np.testing.assert_allclose(sample.world_from_cam, pair.world_from_cam, atol=1e-6)
        np.testing.assert_allclose(sample.world_from_cam_prev, pair.world_from_cam_prev, atol=1e-6)
    assert not pairs


def test_the_depth_is_what_the_development_kit_describes(source, exported):
    """uint16, 0 is invalid, metres are the value over 256; read without our code."""
    sky, out, _ = exported
    for pair in read_pairs(source, split="test"):
        drive, number = place_of(pair)
        path = out / "val" / drive / "proj_depth/groundtruth/image_02" / f"{number:010d}.png"
        with Image.open(path) as image:
            assert image.mode == "I;16" and image.size == (64, 40)
            value = np.array(image)
        far = pair.depth_m >= 200
        assert set(value[far]) == {51200 if sky == "saturated" else 0}
        expected = pair.depth_m[~far].astype(np.float64)
        np.testing.assert_allclose(value[~far] / 256, expected, rtol=0, atol=1 / 512)


def test_poses_read_as_the_development_kit_does(source, exported):
    """convertOxtsToPose.m and the chain of calibrations, written out."""
    _, out, _ = exported
    radius = 6378137
    for pair in read_pairs(source):
        drive, number = place_of(pair)
        path = out / drive[:10] / drive / "oxts/data" / f"{number:010d}.txt"
        words = path.read_text().split()
        assert len(words) == 30 and all(word == "0" for word in words[25:])
        lat, lon, alt, rx, ry, rz, vn, ve = map(float, words[:8])
        scale = math.cos(lat * math.pi / 180)
        x = scale * lon * math.pi * radius / 180
        y = scale * radius * math.log(math.tan((90 + lat) * math.pi / 360))
        c, s = np.cos, np.sin
        turn_x = [[1, 0, 0], [0, c(rx), -s(rx)], [0, s(rx), c(rx)]]
        turn_y = [[c(ry), 0, s(ry)], [0, 1, 0], [-s(ry), 0, c(ry)]]
        turn_z = [[c(rz), -s(rz), 0], [s(rz), c(rz), 0], [0, 0, 1]]
        turn = np.array(turn_z) @ turn_y @ turn_x
        forward, left, up = turn.T
        pose = pair.world_from_cam
        np.testing.assert_allclose([x, y, alt], pose[:3, 3], atol=1e-6)
        np.testing.assert_allclose(np.stack([-left, -up, forward], 1), pose[:3, :3], atol=1e-9)
        np.testing.assert_allclose([ve, vn], pair.meta["velocity_mps"][:2])


def test_calibration_files_have_kittis_lines(exported):
    _, out, _ = exported
    text = (out / "2000_01_01" / "calib_cam_to_cam.txt").read_text()
    table = dict(line.split(":", 1) for line in text.splitlines())
    for k in range(4):
        assert [float(x) for x in table[f"S_rect_0{k}"].split()] == [64, 40]
        p = np.array(table[f"P_rect_0{k}"].split(), float).reshape(3, 4)
        np.testing.assert_allclose(p, [[40.5, 0, 30, 0], [0, 41.25, 20.5, 0], [0, 0, 1, 0]])
    names = {line.split(":")[0] for line in text.splitlines()} - {"calib_time", "corner_dist"}
    kinds = ("S", "K", "D", "R", "T", "S_rect", "R_rect", "P_rect")
    assert names == {f"{kind}_0{k}" for kind in kinds for k in range(4)}


def test_timestamps_have_a_line_for_every_frame_number(source, exported):
    _, out, _ = exported
    for pair in read_pairs(source):
        drive, number = place_of(pair)
        for sensor in ("image_02", "oxts"):
            lines = (out / drive[:10] / drive / sensor / "timestamps.txt").read_text().splitlines()
            assert re.fullmatch(r"\d{4}-\d\d-\d\d 00:00:00\.\d{9}", lines[number])
            assert float(lines[number][-12:]) == pytest.approx(pair.meta["time_s"], abs=1e-6)


@pytest.mark.parametrize("second", [1e9, 1e300])
def test_a_drive_lasts_a_year_at_most(second):
    with pytest.raises(DatasetError, match="allowed is up to a year"):
        timestamps("2000_01_01_drive_0000_sync", np.array([0.0, second]))


@pytest.mark.parametrize("number", [1_000_001, 2**52])
def test_numbers_of_frames_cost_no_memory(tmp_path, number):
    make_dataset(tmp_path / "set", shards=1, pairs=1)
    path = next((tmp_path / "set").rglob("*.tar"))
    pairs = {key: read_members(path, files) for key, files in shard_members(path).items()}
    with ShardWriter(path) as shard:
        for key, files in pairs.items():
            meta = json.loads(files["meta.json"]) | {"frame_index": number}
            shard.add(key, files | {"meta.json": json.dumps(meta).encode()})
    write_index(tmp_path / "set", read_manifest(tmp_path / "set"))
    with pytest.raises(DatasetError, match=f"has a frame {number}: allowed is up to 1000000"):
        export_kitti(tmp_path / "set", tmp_path / "k")
    assert not (tmp_path / "k").exists()


def test_the_previous_frame_lies_one_number_before(source, exported):
    _, out, _ = exported
    for pair in read_pairs(source):
        drive, number = place_of(pair)
        folder = out / drive[:10] / drive / "image_02" / "data"
        for name, picture in ((number, pair.rgb), (number - 1, pair.prev)):
            with Image.open(folder / f"{name:010d}.png") as image:
                np.testing.assert_array_equal(np.array(image), picture)


def test_split_lists(exported):
    _, out, _ = exported
    for split, days in (("train", (1, 3)), ("val", (2, 4))):
        path = out / "splits" / "bts" / f"{split}_files_with_gt.txt"
        for line in path.read_text().splitlines():
            rgb, depth, focal = line.split()
            assert (out / rgb).is_file() and (out / split / depth).is_file()
            assert float(focal) == 40.5
        assert len(KittiDataset(out, split_file=path)) == 6
        assert {int(line.drive[8:10]) for line in read_split(path)} == set(days)
        assert all(sample.valid.any() for sample in KittiDataset(out, split_file=path))
        # monodepth2 reads t-1, t and t+1 of what it trains on.
        lines = (out / "splits" / "monodepth2" / f"{split}_files.txt").read_text().splitlines()
        assert len(lines) == 4
        for line in lines:
            drive, number, side = line.split()
            assert side == "l"
            for k in (-1, 0, 1):
                assert (out / drive / f"image_02/data/{int(number) + k:010d}.png").is_file()
    tested = out / "splits" / "monodepth2" / "test_files.txt"
    assert len(KittiDataset(out, split_file=tested)) == 6


def test_one_split_alone(source, tmp_path):
    steps = []
    report = export_kitti(
        source, tmp_path / "k", split="test", on_progress=lambda a, b: steps.append((a, b))
    )
    assert report.pairs == 6 and steps == [(k, 6) for k in range(1, 7)]
    assert not (tmp_path / "k" / "train").exists()
    assert len(KittiDataset(tmp_path / "k", split="val")) == 6
    # A scene's date and a flight's drive do not depend on what else was written.
    assert sorted(path.name for path in (tmp_path / "k").glob("2*")) == ["2000_01_02", "2000_01_04"]
    assert any("64x40" in note for note in report.notes)


@pytest.mark.parametrize("sky", ["invalid", "saturated"])
def test_what_is_beyond_sixteen_bits(tmp_path, sky):
    make_dataset(tmp_path / "far", shards=1, pairs=1, max_depth_m=1000.0)
    export_kitti(tmp_path / "far", tmp_path / "k", sky=sky)
    (pair,), (sample,) = read_pairs(tmp_path / "far"), KittiDataset(tmp_path / "k")
    beyond = pair.depth_m > 255.997
    assert beyond.any()
    top = 65535 / 256
    assert set(sample.depth_m[beyond]) == {0 if sky == "invalid" else np.float32(top)}
    assert sample.max_depth_m == (math.inf if sky == "invalid" else top)
    near = pair.depth_m < 255.99
    np.testing.assert_allclose(sample.depth_m[near], pair.depth_m[near], rtol=0, atol=1 / 512)


def test_depth_pictures_clip_and_never_wrap(tmp_path):
    depth = np.array([[0, 1 / 300, 1 / 256, 200, 255.9961, 256, 1e9, np.inf, np.nan, -3]])
    write_file(tmp_path / "d.png", encode_depth(depth))
    stored = cv2.imread(str(tmp_path / "d.png"), cv2.IMREAD_UNCHANGED)
    assert stored.dtype == np.uint16
    assert stored[0].tolist() == [0, 0, 1, 51200, 65535, 65535, 65535, 0, 0, 0]
    assert read_depth(tmp_path / "d.png")[0, 3] == 200


@settings(max_examples=30, deadline=None)
@given(st.floats(1 / 256, 255.99))
def test_depth_pictures_keep_metres(metres_):
    code = cv2.imdecode(np.frombuffer(encode_depth(np.full((1, 1), metres_)), np.uint8), -1)
    assert abs(int(code[0, 0]) / 256 - metres_) <= 1 / 512


def test_refusals_leave_nothing_behind(source, tmp_path):
    taken = tmp_path / "taken"
    write_file(taken / "mine.txt", b"mine")
    with pytest.raises(DatasetError, match="exists: allowed is a new or an empty folder"):
        export_kitti(source, taken)
    with pytest.raises(DatasetError, match="sky 'blue': allowed are invalid, saturated"):
        export_kitti(source, tmp_path / "k", sky="blue")
    with pytest.raises(DatasetError, match="split 'val': .* has test, train"):
        export_kitti(source, tmp_path / "k", split="val")
    with pytest.raises(DatasetError, match="holds no dataset"):
        export_kitti(tmp_path, tmp_path / "k")
    assert [path.name for path in tmp_path.rglob("*")] == ["taken", "mine.txt"]


def test_a_folder_is_there_whole_or_not_at_all(tmp_path):
    out = tmp_path / "deep" / "out"

    def fail(error):
        with new_folder(out) as folder:
            write_file(folder / "a" / "b", b"1")
            assert folder == Path(f"{out}.partial") and not out.exists()
            raise error

    for error, caught in ((ValueError("no"), ValueError), (OSError(28, "full"), DatasetError)):
        with pytest.raises(caught):
            fail(error)
        assert list(out.parent.iterdir()) == []
    # What a kill left is no part of the next export.
    write_file(Path(f"{out}.partial") / "old", b"")
    out.mkdir()
    with new_folder(out) as folder:
        write_file(folder / "new", b"1")
    assert [path.name for path in out.parent.rglob("*")] == ["out", "new"]


def test_a_broken_shard_is_told_in_one_line(tmp_path):
    make_dataset(tmp_path / "set", shards=1, pairs=1)
    shard = next((tmp_path / "set").rglob("*.tar"))
    shard.write_bytes(shard.read_bytes()[:600])
    with pytest.raises(DatasetError, match=r"blocks-train-000000.tar: ") as told:
        export_kitti(tmp_path / "set", tmp_path / "k")
    assert "\n" not in str(told.value) and not (tmp_path / "k").exists()
