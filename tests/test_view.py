"""Recordings for Rerun: read back with Rerun's own reader, and compared with the dataset."""

import itertools
import subprocess
import sys

import cv2
import numpy as np
import pytest

from synthdepth.camera import Intrinsics
from synthdepth.dataset.manifest import read_index, read_manifest, write_manifest
from synthdepth.dataset.pairs import PairDataset
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.view.flights import flights_of
from synthdepth.view.recording import has_display, open_viewer, write_recording
from tests.made import make_dataset

pytest.importorskip("rerun", reason="Rerun is not installed: pip install 'synthdepth[view]'")

SCENES, PAIRS = 2, 3


class Recorded:
    """A recording, {entity: {component: {pair number: value}}}; what is static is at None."""

    def __init__(self, path):
        from rerun.chunk import RrdReader

        reader = RrdReader(path)
        self.blueprints = len(reader.blueprints())
        self.values, self.times = {}, {}  # times: {timeline: {pair number: time}}
        for chunk in reader.store().stream():
            batch = chunk.to_record_batch()
            numbers = [None] if chunk.is_static else batch["pair"].to_pylist()
            for name in chunk.timeline_names:
                times = batch[name].cast("int64").to_pylist()
                self.times.setdefault(name, {}).update(zip(numbers, times, strict=True))
            known = self.values.setdefault(chunk.entity_path, {})
            for field in batch.schema:
                if ":" in field.name:
                    rows = zip(numbers, batch[field.name].to_pylist(), strict=True)
                    # An entity's rows hold what was logged together; the rest of a row is empty.
                    known.setdefault(field.name.partition(":")[2], {}).update(
                        (number, value) for number, value in rows if value is not None
                    )

    def __call__(self, entity, component, number=None):
        return self.values[f"/{entity}"][component][number]

    def pose(self, entity, number):
        """World-from-entity of a pair; Rerun keeps matrices column by column."""
        pose = np.eye(4)
        pose[:3, :3] = np.reshape(self(entity, "mat3x3", number), (3, 3)).T
        pose[:3, 3] = np.ravel(self(entity, "translation", number))
        return pose


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    camera = Intrinsics(width=40, height=30, fx=22.0, fy=23.0, cx=18.5, cy=15.25)
    return make_dataset(
        folder / "set", shards=SCENES, pairs=PAIRS, modalities=("flow", "seg", "normal"),
        camera=camera,
    )  # fmt: skip


@pytest.fixture(scope="module")
def recorded(made):
    path = made.parent / "all.rrd"
    assert write_recording(made, path) == SCENES * PAIRS
    return Recorded(path)


def test_every_pair_is_there_with_all_it_has(recorded):
    everything = {
        "world/camera/picture": "blob", "world/camera_prev/picture": "blob",
        "world/camera/depth": "buffer", "world/camera/flow": "buffer",
        "world/camera/labels": "buffer", "world/camera/normals": "buffer",
        "world/points": "positions", "plots/altitude_m": "scalars", "pair": "text",
    }  # fmt: skip
    for entity, component in everything.items():
        assert sorted(recorded.values[f"/{entity}"][component]) == list(range(SCENES * PAIRS))
    assert recorded.blueprints == 1


def test_poses_are_the_datasets(made, recorded):
    for number, sample in enumerate(PairDataset(made)):
        for entity, pose in (
            ("world/camera", sample.world_from_cam),
            ("world/camera_prev", sample.world_from_cam_prev),
        ):
            np.testing.assert_allclose(recorded.pose(entity, number), pose, atol=1e-5)
            # Right, down, forward: Rerun's codes for the axes of OpenCV.
            assert recorded(entity, "camera_xyz", number) == [[3, 2, 5]]


def test_points_are_where_the_depth_says(made, recorded):
    for number, sample in enumerate(PairDataset(made)):
        fx, fy, cx, cy = sample.intrinsics[[0, 1, 0, 1], [0, 1, 2, 2]]
        expected, colours = [], []
        for v, u in itertools.product(range(30), range(40)):
            z = float(sample.depth_m[v, u])
            if z < 200:
                seen = np.array([(u - cx) / fx * z, (v - cy) / fy * z, z, 1.0])
                expected.append((sample.world_from_cam @ seen)[:3])
                colours.append(sample.rgb[v, u])
        points = np.array(recorded("world/points", "positions", number))
        np.testing.assert_allclose(points, expected, atol=1e-3)
        packed = np.array(recorded("world/points", "colors", number), np.uint32)
        unpacked = np.stack([packed >> shift & 255 for shift in (24, 16, 8)], axis=-1)
        np.testing.assert_array_equal(unpacked, colours)


def test_the_sky_gets_no_points(made, recorded):
    """What is saturated is at least that far; points there would be a wall that does not exist."""
    sample = PairDataset(made)[0]
    assert (sample.depth_m == 200).any()
    assert len(recorded("world/points", "positions", 0)) == (sample.depth_m < 200).sum()


def test_points_project_onto_the_middles_of_their_pixels(made, recorded):
    """In Rerun an image spans [0, width], so the middle of the first pixel is at 0.5."""
    sample = PairDataset(made)[0]
    points = np.array(recorded("world/points", "positions", 0))
    k = np.reshape(recorded("world/camera", "image_from_camera", 0), (3, 3)).T
    pose = recorded.pose("world/camera", 0)
    seen = (points - pose[:3, 3]) @ pose[:3, :3] @ k.T
    v, u = np.nonzero(sample.depth_m < 200)
    np.testing.assert_allclose(
        seen[:, :2] / seen[:, 2:], np.stack([u, v], axis=-1) + 0.5, atol=1e-3
    )


def test_pictures_are_the_datasets(made, recorded):
    for number, sample in enumerate(PairDataset(made)):
        for entity, picture in (("camera", sample.rgb), ("camera_prev", sample.prev)):
            png = np.array(recorded(f"world/{entity}/picture", "blob", number)[0], np.uint8)
            stored = cv2.cvtColor(cv2.imdecode(png, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)
            np.testing.assert_array_equal(stored, picture)
        depth = bytes(recorded("world/camera/depth", "buffer", number)[0])
        stored = np.frombuffer(depth, np.float32).reshape(30, 40)
        np.testing.assert_array_equal(stored, sample.depth_m)
        assert recorded("world/camera/depth", "meter", number) == [1.0]
        labels = bytes(recorded("world/camera/labels", "buffer", number)[0])
        np.testing.assert_array_equal(np.frombuffer(labels, np.uint8), sample.seg.ravel())


def test_labels_have_their_names(made, recorded):
    (classes,) = recorded("world", "context")
    named = {c["class_description"]["info"]["label"]: c["class_id"] for c in classes}
    assert named == read_manifest(made)["labels"]


def test_flights_share_no_timeline_but_the_order(recorded):
    own = {name: times for name, times in recorded.times.items() if name != "pair"}
    assert own == {
        f"time_s blocks-s0000{scene}-f000": {
            scene * PAIRS + frame: 100_000_000 * (frame + 1)  # ns
            for frame in range(PAIRS)
        }
        for scene in range(SCENES)
    }


def test_paths_are_those_of_the_scene_that_is_shown(made, recorded):
    strips = recorded.values["/world/flights/runs"]["strips"]
    assert sorted(strips) == [scene * PAIRS for scene in range(SCENES)]
    for scene, flight in enumerate(flights_of(read_index(made))):
        (strip,) = strips[scene * PAIRS]
        # From the first frame t-1 on; the drone moves 0.8 m east a frame.
        assert len(strip) == PAIRS + 1
        np.testing.assert_allclose(strip[1:], flight.positions_m, atol=1e-5)
        np.testing.assert_allclose(np.diff(strip, axis=0), [[0.8, 0, 0]] * PAIRS, atol=1e-5)


def test_runs_end_where_frames_are_missing(made):
    index = read_index(made)
    flight = flights_of(index.filter([True, False, True] + [True] * 3))[0]
    runs, (gap,) = list(flight.runs()), flight.gaps()
    assert [len(run) for run in runs] == [2, 2]
    np.testing.assert_array_equal(gap, [runs[0][-1], runs[1][0]])


def test_a_flight_or_a_scene_can_be_chosen(made, tmp_path):
    for name in ("s00001", "s00001-f000", "blocks-s00001", "blocks-s00001-f000"):
        out = tmp_path / f"{name}.rrd"
        assert write_recording(made, out, flights=[name], count=2) == 2
        recorded = Recorded(out)
        assert "blocks-s00001-f000-0002" in recorded("pair", "text", 1)[0]
        np.testing.assert_allclose(
            recorded.pose("world/camera", 0), PairDataset(made)[PAIRS].world_from_cam, atol=1e-5
        )


def test_a_dataset_of_depth_alone(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=1, pairs=1)
    assert write_recording(folder, tmp_path / "x.rrd") == 1
    values = Recorded(tmp_path / "x.rrd").values
    assert "/world/camera/depth" in values
    assert not {"/world/camera/flow", "/world/camera/labels", "/world/camera/normals"} & set(values)


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"out": "x.txt"}, "allowed is a file name that ends in .rrd"),
        ({"count": 0}, "--count 0: allowed is a whole number from 1"),
        ({"flights": ["s00009"]}, "--flight s00009: .* holds no such flight or scene"),
        ({"flights": ["00001"]}, "--flight 00001"),
        ({"out": "no/such/folder/x.rrd"}, "cannot write .*x.rrd: No such file"),
    ],
)
def test_mistakes_are_told_in_one_line(made, tmp_path, arguments, told):
    out = tmp_path / arguments.pop("out", "x.rrd")
    with pytest.raises(SynthdepthError, match=told):
        write_recording(made, out, **arguments)
    assert not list(tmp_path.iterdir())


def test_no_dataset(tmp_path):
    with pytest.raises(DatasetError, match="holds no dataset"):
        write_recording(tmp_path, tmp_path / "x.rrd")


def test_a_broken_pair_leaves_no_file(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=1)
    shard = next(folder.rglob("*.tar"))
    shard.write_bytes(shard.read_bytes()[:9000])
    with pytest.raises(DatasetError, match=shard.name):
        write_recording(folder, tmp_path / "x.rrd")
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


def test_a_recording_that_broke_off_is_no_success(made, tmp_path, monkeypatch):
    """Rerun's writer logs what the disk refuses and goes on, and so it does switched off."""
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(DatasetError, match="the recording broke off"):
        write_recording(made, tmp_path / "x.rrd")
    assert not list(tmp_path.iterdir())


def test_a_manifest_without_labels(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=1, pairs=1, modalities=("seg",))
    write_manifest(folder, {k: v for k, v in read_manifest(folder).items() if k != "labels"})
    assert write_recording(folder, tmp_path / "x.rrd") == 1


def test_without_rerun_it_says_what_to_install(made, tmp_path, monkeypatch):
    monkeypatch.delitem(sys.modules, "synthdepth.view.rerun_log", raising=False)
    monkeypatch.setitem(sys.modules, "rerun", None)
    with pytest.raises(SynthdepthError, match=r"pip install 'synthdepth\[view\]'"):
        write_recording(made, tmp_path / "x.rrd")


def test_the_viewer_listens_to_this_machine_only(made, monkeypatch):
    seen = {}

    def run(command, check):
        seen["command"], seen["pairs"] = command, Recorded(command[-1]).times["pair"]
        return subprocess.CompletedProcess(command, 0)

    monkeypatch.setattr(subprocess, "run", run)
    assert open_viewer(made, count=2) == 2
    command = seen["command"]
    assert command[command.index("--bind") + 1] == "127.0.0.1"
    assert list(seen["pairs"]) == [0, 1]


def test_a_viewer_that_fails_is_told(made, monkeypatch):
    monkeypatch.setattr(
        subprocess, "run", lambda command, check: subprocess.CompletedProcess(command, 1)
    )
    with pytest.raises(SynthdepthError, match="exit code 1"):
        open_viewer(made, count=1)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere there is always a display")
def test_display(monkeypatch):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    assert not has_display()
    monkeypatch.setenv("DISPLAY", ":0")
    assert has_display()
