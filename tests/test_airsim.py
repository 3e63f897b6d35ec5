"""AirSim: recordings written its own way come out as the contract has it, in metres and upright."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synthdepth.airsim.importer import import_airsim
from synthdepth.airsim.manifest import NEUTRAL
from synthdepth.airsim.ned import body_pose, mounted, ned_line, world_from_cam
from synthdepth.airsim.recording import read_recording
from synthdepth.dataset.manifest import read_index, read_manifest
from synthdepth.dataset.pair import META_FIELDS
from synthdepth.dataset.preview import random_pairs
from synthdepth.dataset.verify import verify
from synthdepth.errors import DatasetError
from tests.airsim_made import (
    CAMERA,
    HEADER,
    SETTINGS,
    one_line,
    record_flight,
    turned,
)
from tests.made import view


def axis_turn(axis, angle_deg):
    """Right-handed rotation matrix about a coordinate axis."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    i, j = (axis + 1) % 3, (axis + 2) % 3
    made = np.eye(3)
    made[i, i], made[i, j], made[j, i], made[j, j] = c, -s, s, c
    return made


def all_pairs(folder):
    rows = read_index(folder).to_pylist()
    assert rows == sorted(rows, key=lambda row: row["key"])
    return random_pairs(folder, len(rows), 0)


@pytest.mark.parametrize("perspective", [False, True], ids=["planar", "perspective"])
def test_a_recording_comes_out_in_metres_upright_and_posed(tmp_path, perspective):
    truth = record_flight(tmp_path / "rec", perspective=perspective)
    report = import_airsim(tmp_path / "rec", tmp_path / "out")
    assert (report.recordings, report.pairs) == (1, {"train": 3})
    assert verify(tmp_path / "out").faults == []
    pairs = all_pairs(tmp_path / "out")
    for k, pair in enumerate(pairs, start=1):
        cam, rgb, depth = truth[k]
        np.testing.assert_array_equal(pair.rgb, rgb)
        np.testing.assert_array_equal(pair.prev, truth[k - 1][1])
        # Half floats have 11 bits; beyond 200 m and in the sky the depth saturates.
        near = depth < 200
        np.testing.assert_allclose(pair.depth_m[near], depth[near], rtol=2**-11)
        assert (pair.depth_m[depth > 201] == 200).all() and (depth > 201).any()
        assert pair.depth_m[:4].min() == 200, "the sky is not at the top"
        np.testing.assert_allclose(pair.world_from_cam, cam, atol=1e-5)
        np.testing.assert_allclose(pair.world_from_cam_prev, truth[k - 1][0], atol=1e-5)
        assert pair.camera == CAMERA
        assert (pair.meta["dt_s"], pair.meta["time_s"]) == (0.1, pytest.approx(0.1 * k))
        moved = (truth[k][0] - truth[k - 1][0])[:3, 3]
        np.testing.assert_allclose(pair.meta["velocity_mps"], moved / 0.1, atol=1e-9)


def test_what_a_recording_does_not_say_is_said(tmp_path):
    record_flight(tmp_path / "rec")
    report = import_airsim(tmp_path / "rec", tmp_path / "out")
    source = read_manifest(tmp_path / "out")["source"]
    assert source["kind"] == "airsim" and source["recordings"] == ["rec"]
    assert set(source["unknown"]) == set(NEUTRAL) < set(META_FIELDS)
    assert source["notes"] == list(report.notes)
    told = " ".join(report.notes)
    for word in ("clearance_m", "condition", "exposure", "clip", "after the picture", "90 degrees"):
        assert word in told
    (pair, *_) = all_pairs(tmp_path / "out")
    assert pair.meta["condition"] == "unknown"
    assert {name: pair.meta[name] for name in NEUTRAL} == NEUTRAL
    assert report.skipped == {"no frame lies before it": 1}


def test_the_settings_mount_the_camera(tmp_path):
    (tmp_path / "settings.json").write_text(SETTINGS)
    mount = np.eye(4)
    mount[:3, :3] = axis_turn(2, 20) @ axis_turn(1, -15) @ axis_turn(0, 5)
    mount[:3, 3] = 0.5, -0.1, -0.2
    truth = record_flight(tmp_path / "rec", mount=mount)
    report = import_airsim(tmp_path / "rec", tmp_path / "out", settings=tmp_path / "settings.json")
    for pair, (cam, _, depth) in zip(all_pairs(tmp_path / "out"), truth[1:], strict=True):
        np.testing.assert_allclose(pair.world_from_cam, cam, atol=2e-5)
        # What the pose says is what the depth shows.
        _, _, seen, *_ = view(CAMERA, pair.world_from_cam, 200.0)
        np.testing.assert_allclose(seen, depth, rtol=1e-3)
    assert not any("90 degrees" in note for note in report.notes)


def test_pitch_down_looks_down_and_roll_turns_clockwise():
    down = world_from_cam(mounted(np.zeros(3), pitch_deg=-90, roll_deg=0, yaw_deg=0))
    np.testing.assert_allclose(down[:3, 2], [0, 0, -1], atol=1e-12)
    east = world_from_cam(mounted(np.zeros(3), pitch_deg=0, roll_deg=0, yaw_deg=90))
    np.testing.assert_allclose(east[:3, 2], [1, 0, 0], atol=1e-12)
    # Rolled clockwise, what was right points down.
    rolled = world_from_cam(mounted(np.zeros(3), pitch_deg=0, roll_deg=90, yaw_deg=0))
    np.testing.assert_allclose(rolled[:3, 0], [0, 0, -1], atol=1e-12)


unit = st.floats(-1, 1, allow_nan=False)


@given(st.tuples(unit, unit, unit, unit), st.tuples(unit, unit, unit))
def test_quaternions_turn_as_their_product_does(quaternion, vector):
    length = np.linalg.norm(quaternion)
    if length < 0.1:
        return
    pose = body_pose(np.array([1.0, 2, 3]), np.array(quaternion))
    expected = turned(vector, np.array(quaternion) / length)
    np.testing.assert_allclose(pose[:3, :3] @ vector, expected, atol=1e-9)
    # And back: TartanAir's line holds the same pose, x y z w.
    *position, x, y, z, w = ned_line(world_from_cam(pose))
    np.testing.assert_allclose(position, [1, 2, 3], atol=1e-12)
    np.testing.assert_allclose(turned(vector, (w, x, y, z)), expected, atol=1e-9)


def test_frames_are_matched_by_time_within_the_gap(tmp_path):
    """The lines' order does not count; a gap, a repeated time and a lost file give no pair."""
    record_flight(tmp_path / "rec", frames=6, times_ms=[1300, 1000, 1100, 1100, 3000, 3100])
    lines = read_recording(tmp_path / "rec")
    lines[5].images["front_center", 1].unlink()
    report = import_airsim(tmp_path / "rec", tmp_path / "out")
    assert report.skipped == {
        "no frame lies before it": 1,
        "the frame before is more than 0.5 s older": 1,
        "its depth is missing": 1,
    }
    pairs = all_pairs(tmp_path / "out")
    assert [pair.meta["time_s"] for pair in pairs] == [0.1, 0.1, 0.3]
    assert [pair.meta["dt_s"] for pair in pairs] == [0.1, 0.1, 0.2]
    report = import_airsim(tmp_path / "rec", tmp_path / "wide", max_gap_s=2.0)
    assert report.pairs == {"train": 4}


def test_a_recording_is_a_scene_in_one_split_and_a_vehicle_a_flight(tmp_path):
    for name, vehicles in (("a", ["Drone_1", "Drone_2"]), ("b", [""]), ("c", ["d"])):
        for number, vehicle in enumerate(vehicles):
            record_flight(tmp_path / "all" / name, vehicle=vehicle, frames=3 + number)
    report = import_airsim(tmp_path / "all", tmp_path / "out")
    assert (report.recordings, report.pairs) == (3, {"train": 7, "test": 2})
    assert verify(tmp_path / "out").faults == []
    keys = read_index(tmp_path / "out")["key"].to_pylist()
    assert keys[2:5] == [f"airsim-s00000-f001-{k:04d}" for k in (1, 2, 3)]
    report = import_airsim(tmp_path / "all", tmp_path / "test", split="test")
    assert report.pairs == {"test": 9}
    card = (tmp_path / "test" / "README.md").read_text()
    assert "train" not in card.split("---")[1], "the card promises files that are not there"


def test_where_the_depth_was_clipped_it_saturates(tmp_path):
    record_flight(tmp_path / "rec", clip_m=40.0)
    report = import_airsim(tmp_path / "rec", tmp_path / "out")
    manifest = read_manifest(tmp_path / "out")
    assert manifest["depth"]["max_depth_m"] == 40 and verify(tmp_path / "out").faults == []
    assert any("clipped depth at 40 m" in note for note in report.notes)
    assert all(0.2 < pair.meta["in_range_share"] < 0.9 for pair in all_pairs(tmp_path / "out"))


def test_clipped_rays_are_never_called_nearer_than_they_are(tmp_path):
    """A ray clipped at 40 m is 40 m long at least, and in the corner that is less planar depth."""
    truth = record_flight(tmp_path / "rec", clip_m=40.0, perspective=True)
    import_airsim(tmp_path / "rec", tmp_path / "out")
    longest = np.linalg.norm(CAMERA.rays(), axis=-1).max()
    for pair, (_, _, depth) in zip(all_pairs(tmp_path / "out"), truth[1:], strict=True):
        assert pair.meta["max_depth_m"] == pytest.approx(40 / longest, rel=1e-6)
        expected = np.minimum(depth, pair.meta["max_depth_m"])
        np.testing.assert_allclose(pair.depth_m, expected, rtol=2**-11)


def test_frames_that_the_contract_refuses_are_left_out(tmp_path):
    record_flight(tmp_path / "rec", frames=6, picture=lambda k, rgb: rgb * (k != 2))
    report = import_airsim(tmp_path / "rec", tmp_path / "out")
    assert report.skipped["rgb.png is black"] == 1 and report.skipped["prev.png is black"] == 1
    assert report.pairs == {"train": 3} and verify(tmp_path / "out").faults == []


def test_bad_recordings_are_refused_in_one_line_and_leave_nothing(tmp_path):
    rec, out = tmp_path / "rec", tmp_path / "out"
    record_flight(rec)
    good = (rec / "airsim_rec.txt").read_text()
    first = good.splitlines()[1]
    for text, said in (
        (good + first.replace("\t1000\t", "\tsoon\t") + "\n", "line 6"),
        (good + first + "\t1\n", "11 columns, not 10"),
        (good.replace("Q_W\t", ""), "lacks Q_W"),
        (good + first.replace(".png", ".tif") + "\n", "is no image"),
        (good + "\t".join(["v", "1", *"000", *"0000", ""]) + "\n", "line 6"),
        (HEADER, "no camera"),
        ("", "lacks TimeStamp"),
    ):
        (rec / "airsim_rec.txt").write_text(text)
        with pytest.raises(DatasetError) as error:
            import_airsim(rec, out)
        assert said in one_line(error)
    # A line that was being written when the simulator ended is no error.
    (rec / "airsim_rec.txt").write_text(good + first[:40])
    for options, said in (
        ({"camera": "0"}, "allowed are front_center"),
        ({"split": "val"}, "allowed are train, test"),
        ({"max_gap_s": 0.0}, "above 0"),
        ({"max_gap_s": 0.05}, "gives no pair"),
        ({"max_depth_m": 0.0}, "--max-depth-m"),
        ({"settings": rec / "none.json"}, "cannot be read"),
    ):
        with pytest.raises(DatasetError) as error:
            import_airsim(rec, out, **options)
        assert said in one_line(error)
    assert not out.exists() and not list(tmp_path.glob("*.partial"))
    assert import_airsim(rec, out).pairs == {"train": 3}
    with pytest.raises(DatasetError, match="exists"):
        import_airsim(rec, out)


def test_a_broken_image_in_the_middle_leaves_nothing(tmp_path):
    record_flight(tmp_path / "rec")
    read_recording(tmp_path / "rec")[3].images["front_center", 0].write_bytes(b"\x89PNG")
    with pytest.raises(DatasetError, match="is no readable image"):
        import_airsim(tmp_path / "rec", tmp_path / "out")
    assert [path.name for path in tmp_path.iterdir()] == ["rec"]


def test_the_same_recording_twice_and_captures_without_poses_are_refused(tmp_path):
    for name in "ab":
        record_flight(tmp_path / "all" / name)
    with pytest.raises(DatasetError, match="same recording as a"):
        import_airsim(tmp_path / "all", tmp_path / "out")
    (tmp_path / "all" / "a" / "airsim_rec.txt").unlink()
    with pytest.raises(DatasetError) as error:
        import_airsim(tmp_path / "all" / "a", tmp_path / "out")
    assert "no airsim_rec.txt" in one_line(error) and "read_airsim_capture" in str(error.value)


def test_several_cameras_must_be_chosen_from(tmp_path):
    record_flight(tmp_path / "rec", camera="0")
    record_flight(tmp_path / "rec", camera="bottom_center", times_ms=[5000, 5100, 5200, 5300])
    with pytest.raises(DatasetError, match="--camera of 0, bottom_center"):
        import_airsim(tmp_path / "rec", tmp_path / "out")
    assert import_airsim(tmp_path / "rec", tmp_path / "out", camera="0").pairs == {"train": 3}
