"""A small dataset, rendered for real: determinism, resume, ground truth, others' readers."""

import gc
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import cv2
import numpy as np
import OpenEXR
import OpenImageIO
import pytest
import webdataset

from synthdepth.camera import project, unproject
from synthdepth.dataset.checksums import write_checksums
from synthdepth.dataset.manifest import read_index, read_manifest, write_manifest
from synthdepth.dataset.pair import decode_pair
from synthdepth.dataset.preview import preview
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.dataset.verify import verify
from synthdepth.errors import DatasetError
from synthdepth.flow.truth import flow_from_depth
from synthdepth.maps.registry import build_world
from synthdepth.maps.world import LABELS
from synthdepth.production.repair import repair
from synthdepth.production.run import render_dataset
from tests.conftest import PAIRS, SIZE, recipe
from tests.raycast import Recaster


def shard_hashes(folder):
    return {s["path"]: (s["sha256"], s["pairs"]) for s in read_manifest(folder)["shards"]}


@pytest.fixture(scope="session")
def pairs(dataset):
    found = []
    for shard in read_manifest(dataset)["shards"]:
        path = dataset / shard["path"]
        for key, members in shard_members(path).items():
            found.append(decode_pair(key, read_members(path, members)))
    return found


def test_it_verifies_and_is_complete(dataset, pairs):
    assert verify(dataset).faults == []
    manifest = read_manifest(dataset)
    assert manifest["complete"]
    assert manifest["splits"] == {"train": 4, "test": 2}
    assert len({pair.key for pair in pairs}) == PAIRS
    assert {p.meta["scene_seed"] for p in pairs if p.meta["split"] == "train"}.isdisjoint(
        p.meta["scene_seed"] for p in pairs if p.meta["split"] == "test"
    )
    for shard in manifest["shards"]:
        assert len(shard["cost"]["render_s"]) == shard["pairs"]


def test_one_worker_gives_the_same_bytes_as_two(dataset, tmp_path):
    render_dataset(recipe(), tmp_path / "one", pairs=PAIRS, workers=1)
    assert shard_hashes(tmp_path / "one") == shard_hashes(dataset)
    for name in ("index.parquet", "README.md", "card.jpg", "croissant.json"):
        assert (tmp_path / "one" / name).read_bytes() == (dataset / name).read_bytes()


def test_extending_equals_rendering_at_once(dataset, tmp_path):
    folder = tmp_path / "grown"
    first = render_dataset(recipe(), folder, pairs=3, workers=2)
    second = render_dataset(recipe(), folder, pairs=PAIRS, workers=2)
    assert (first.rendered, second.rendered) == (3, PAIRS - 3)
    assert shard_hashes(folder) == shard_hashes(dataset)


def test_asking_for_less_or_again_changes_nothing(dataset):
    before = {p: p.stat().st_mtime_ns for p in dataset.rglob("*.tar")}
    for pairs in (2, PAIRS):
        report = render_dataset(recipe(), dataset, pairs=pairs)
        assert (report.rendered, report.pairs) == (0, PAIRS)
    assert {p: p.stat().st_mtime_ns for p in dataset.rglob("*.tar")} == before
    assert verify(dataset).faults == []


def test_kill_and_start_again_gives_the_same_bytes(dataset, tmp_path):
    folder = tmp_path / "killed"
    code = (
        "import sys; from pathlib import Path; from tests.conftest import recipe, PAIRS\n"
        "from synthdepth.production.run import render_dataset\n"
        "if __name__ == '__main__':\n"
        "    render_dataset(recipe(), Path(sys.argv[1]), pairs=PAIRS, workers=1)\n"
    )
    script = tmp_path / "run.py"
    script.write_text(code)
    env = dict(os.environ, PYTHONPATH=os.getcwd())
    running = subprocess.Popen([sys.executable, script, folder], env=env, start_new_session=True)
    deadline = time.monotonic() + 240
    # One shard whole, the other one under way.
    while not (list(folder.glob("*/*.tar")) and list(folder.glob("*/*.partial"))):
        assert running.poll() is None
        assert time.monotonic() < deadline
        time.sleep(0.02)
    os.killpg(running.pid, signal.SIGKILL)
    running.wait()
    report = render_dataset(recipe(), folder, pairs=PAIRS, workers=2)
    assert 0 < report.rendered < PAIRS
    assert shard_hashes(folder) == shard_hashes(dataset)
    assert verify(folder).faults == []


@pytest.mark.parametrize(
    ("change", "named"),
    [({"seed": 1}, "seed is 0 there and 1"), ({"size": "64x64"}, "recipe.camera.")],
)
def test_another_dataset_is_not_touched(dataset, change, named):
    before = (dataset / "dataset.json").read_bytes()
    other = recipe(change.get("size", SIZE))
    with pytest.raises(DatasetError, match="holds a different dataset") as caught:
        render_dataset(other, dataset, pairs=PAIRS, seed=change.get("seed", 0))
    assert named in str(caught.value)
    assert (dataset / "dataset.json").read_bytes() == before


def test_a_folder_with_other_things_is_not_touched(tmp_path):
    mine = {"film.mkv.1.partial", "thesis.tex"}
    for name in mine:
        (tmp_path / name).write_text("precious")
    with pytest.raises(DatasetError, match=r"and no dataset"):
        render_dataset(recipe(), tmp_path, pairs=1)
    assert {p.name for p in tmp_path.iterdir()} == mine


def test_bursts_share_their_pictures(dataset):
    path = dataset / read_manifest(dataset)["shards"][0]["path"]
    content = {k: read_members(path, m) for k, m in shard_members(path).items()}
    first, second, third, _ = content.values()
    assert second["prev.png"] == first["rgb.png"]
    assert third["prev.png"] != second["rgb.png"]  # another flight


def test_depth_agrees_with_an_independent_ray_caster(pairs):
    """trimesh and Embree on the exported scene, the camera from meta.json."""
    small = recipe()
    seed = pairs[0].meta["scene_seed"]
    caster = Recaster(build_world(small.map, small.scene, small.light, seed))
    for pair in pairs[:4]:
        assert pair.meta["scene_seed"] == seed
        differ, on_no_edge = caster.differing(pair)
        assert differ <= 1e-3 * pair.depth_m.size
        assert on_no_edge == 0


def test_prev_is_the_frame_before(pairs):
    """Warped by depth and poses it falls onto frame t, and far better than left as it is."""
    gains = []
    for pair in pairs:
        points = unproject(pair.depth_m, pair.camera, pair.world_from_cam)
        uv, z = project(points, pair.camera, pair.world_from_cam_prev)
        inside = (z > 0) & (uv >= 0).all(-1)
        inside &= (uv <= [pair.camera.width - 1, pair.camera.height - 1]).all(-1)
        inside &= pair.depth_m < 200
        u, v = (np.nan_to_num(uv[..., k]).astype(np.float32) for k in (0, 1))
        warped = cv2.remap(pair.prev, u, v, cv2.INTER_LINEAR)
        now = pair.rgb[inside].astype(float)
        gains.append(
            np.abs(warped[inside] - now).mean()
            / np.abs(pair.prev[inside].astype(float) - now).mean()
        )
    assert max(gains) < 0.95
    assert np.median(gains) < 0.7


def test_flow_labels_and_normals_agree_with_the_depth(pairs):
    for pair in pairs:
        near = (pair.depth_m < 200) & pair.visible
        poses = pair.world_from_cam, pair.world_from_cam_prev
        by_depth = flow_from_depth(pair.depth_m, pair.camera, *poses)
        assert np.abs(pair.flow - by_depth)[near].max() < 0.01
        assert not np.isin(pair.seg[pair.depth_m < 200], [0]).any()
        # Ground by its label is ground by its normal: z up, in camera axes.
        up = pair.world_from_cam[:3, :3].T @ [0, 0, 1]
        level = pair.normal[np.isin(pair.seg, [LABELS["ground"], LABELS["road"]])] @ up
        assert np.median(level) > 0.98


def test_farneback_agrees_with_the_true_flow_where_there_is_texture(pairs):
    errors = []
    for pair in pairs:
        now, prev = (cv2.cvtColor(x, cv2.COLOR_RGB2GRAY) for x in (pair.rgb, pair.prev))
        found = cv2.calcOpticalFlowFarneback(now, prev, None, 0.5, 4, 15, 5, 7, 1.5, 0)
        textured = cv2.GaussianBlur(np.abs(cv2.Laplacian(now, cv2.CV_32F)), (0, 0), 3) > 6
        use = textured & pair.visible & (pair.depth_m < 200)
        length = np.linalg.norm(pair.flow, axis=-1)
        use &= length < 20
        if use.sum() > 200:
            errors.append(np.median(np.linalg.norm(found - pair.flow, axis=-1)[use]))
    assert len(errors) >= 2
    assert np.median(errors) < 1.5


def test_poses_and_times_are_those_of_a_flight(pairs):
    for pair in pairs:
        move = pair.world_from_cam[:3, 3] - pair.world_from_cam_prev[:3, 3]
        assert pair.meta["dt_s"] == pytest.approx(0.1)
        np.testing.assert_allclose(move / 0.1, pair.meta["velocity_mps"], atol=1.0)
        assert pair.meta["nearest_depth_m"] > 0.2
        assert 2.0 - 1e-6 <= pair.meta["altitude_m"] <= 60.0 + 1e-6


# webdataset leaves its tar streams to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_other_readers_read_the_same(dataset, pairs, tmp_path):
    urls = [str(dataset / s["path"]) for s in read_manifest(dataset)["shards"]]
    samples = list(webdataset.WebDataset(urls, shardshuffle=False))
    gc.collect()
    assert [s["__key__"] for s in samples] == [pair.key for pair in pairs]
    for sample, pair in zip(samples, pairs, strict=True):
        assert json.loads(sample["meta.json"]) == pair.meta
        (tmp_path / "depth.exr").write_bytes(sample["depth.exr"])
        with OpenEXR.File(str(tmp_path / "depth.exr"), separate_channels=True) as file:
            np.testing.assert_array_equal(file.channels()["Z"].pixels, pair.depth_m)
        image = OpenImageIO.ImageInput.open(str(tmp_path / "depth.exr"))
        assert image.spec().channelnames == ("Z",)
        np.testing.assert_array_equal(image.read_image("float").squeeze(), pair.depth_m)
        image.close()


def test_the_index_finds_every_file(dataset, pairs):
    rows = read_index(dataset).to_pylist()
    assert [row["key"] for row in rows] == [pair.key for pair in pairs]
    for row, pair in zip(rows, pairs, strict=True):
        with open(dataset / row["shard"], "rb") as shard:
            shard.seek(row["meta_offset"])
            assert json.loads(shard.read(row["meta_size"])) == pair.meta
        assert np.reshape(row["world_from_cam"], (4, 4)).tolist() == pair.meta["world_from_cam"]


@pytest.fixture
def copy(dataset, tmp_path):
    return shutil.copytree(dataset, tmp_path / "copy")


def test_verify_names_every_kind_of_damage(copy):
    shards = [copy / s["path"] for s in read_manifest(copy)["shards"]]
    flipped = bytearray(shards[0].read_bytes())
    flipped[len(flipped) // 2] ^= 4
    shards[0].write_bytes(flipped)
    shards[1].unlink()
    (copy / "train" / "notes.txt").write_text("?")
    (copy / "index.parquet").write_bytes(b"PAR1")
    names = [shard.relative_to(copy).as_posix() for shard in shards]
    assert {fault.where: fault.kind for fault in verify(copy).faults} == {
        names[0]: "damaged",
        names[1]: "missing",
        "train/notes.txt": "stranger",
        "index.parquet": "truncated",
    }


def test_a_damaged_shard_is_rendered_again_to_the_same_bytes(dataset, copy):
    record = read_manifest(copy)["shards"][1]
    (copy / record["path"]).write_bytes(b"nothing of the kind")
    (copy / "card.jpg").unlink()
    repairs = repair(copy, verify(copy).faults, workers=1)
    assert {one.where: one.done for one in repairs} == {record["path"]: True, "card.jpg": True}
    for path in (p for p in dataset.rglob("*") if p.is_file()):
        assert (copy / path.relative_to(dataset)).read_bytes() == path.read_bytes()


def test_a_pair_is_rendered_alone_to_the_same_bytes(dataset, tmp_path):
    """In a process of its own, as the command does it: a process has one world."""
    path = dataset / read_manifest(dataset)["shards"][0]["path"]
    key, files = list(shard_members(path).items())[1]
    run = [sys.executable, "-m", "synthdepth", "pair", dataset, key, "--out", tmp_path / "one"]
    out = subprocess.run(run, capture_output=True, text=True, check=True).stdout
    assert out.endswith("no fault\n") and key in out
    for suffix, data in read_members(path, files).items():
        assert (tmp_path / "one" / f"{key}.{suffix}").read_bytes() == data


def test_verify_looks_into_the_pairs(copy):
    """A shard whose checksum is right and whose content breaks the contract."""
    from synthdepth.dataset.pair import encode_pair, encode_png
    from synthdepth.dataset.shard import ShardWriter, sha256_of

    manifest = read_manifest(copy)
    record = manifest["shards"][1]
    path = copy / record["path"]
    content = {k: read_members(path, m) for k, m in shard_members(path).items()}
    with ShardWriter(path) as shard:
        for number, (key, members) in enumerate(content.items()):
            pair = decode_pair(key, members)
            depth = pair.depth_m.copy()
            depth[0, 0] = (0.0, 300.0)[number]
            png = encode_png(np.zeros_like(pair.rgb))
            seg, flow = pair.seg.copy(), pair.flow.copy()
            seg[5, 5], flow[pair.visible] = 250, flow[pair.visible] + 0.02
            shard.add(
                key,
                encode_pair(
                    rgb_png=png,
                    prev_png=png,
                    depth_m=depth,
                    meta=pair.meta,
                    flow=flow,
                    visible=pair.visible,
                    seg=seg,
                    normal=None if number else pair.normal,
                ),
            )
    record |= {"sha256": sha256_of(path), "bytes": path.stat().st_size}
    write_checksums(copy, manifest)
    write_manifest(copy, manifest)
    told = [fault.what for fault in verify(copy).faults]
    assert "depth has a value of 0.0 m" in told
    assert "depth has a value of 300.0 m, beyond the range of 200.0 m" in told
    assert told.count("rgb.png is black") == 2
    assert "seg.png has a value that is no label" in told
    assert "normal is missing" in told
    assert any("px from what depth and poses say" in what for what in told)


def test_the_contact_sheet_shows_the_pairs(dataset, tmp_path):
    assert preview(dataset, tmp_path / "sheet.png", count=4) == 4
    sheet = cv2.imread(str(tmp_path / "sheet.png"))
    assert sheet.shape[1] >= 3 * 200
    assert sheet.std() > 20


def test_the_camera_keeps_its_field_of_view(pairs):
    assert pairs[0].camera.fov_deg == pytest.approx(90)
    assert pairs[0].camera.cx == (112 - 1) / 2
