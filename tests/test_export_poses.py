"""TartanAir and nerfstudio: read back by their own descriptions, every point lies where it was."""

import json

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from synthdepth.camera import Intrinsics, look_rotation, pose, project, unproject
from synthdepth.dataset.pair import Pair
from synthdepth.errors import DatasetError
from synthdepth.export import tartanair
from synthdepth.export.folder import read_pairs
from synthdepth.export.nerfstudio import export_nerfstudio
from synthdepth.export.tartanair import export_tartanair, forward_flow
from tests.made import make_dataset

SHARDS, PAIRS = 2, 4


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("data") / "set"
    return make_dataset(out, shards=SHARDS, pairs=PAIRS, modalities=("seg",))


@pytest.fixture(scope="module")
def tartan(folder):
    out = folder.with_name("tartan")
    report = export_tartanair(folder, out)
    assert report.pairs == SHARDS * PAIRS and report.folder == out
    return out


@pytest.fixture(scope="module")
def nerf(folder):
    out = folder.with_name("nerf")
    assert export_nerfstudio(folder, out).pairs == SHARDS * PAIRS
    return out


def by_scene(folder):
    """The pairs of each scene, by its folder's name."""
    scenes = {}
    for pair in read_pairs(folder):
        scenes.setdefault(f"{pair.meta['split']}/{pair.key.split('-f')[0]}", []).append(pair)
    return scenes


def read_tartanair(trajectory):
    """Pictures, depth [m] and poses of a trajectory, by data_type.md alone."""
    poses = []
    for tx, ty, tz, *quaternion in np.loadtxt(trajectory / "pose_left.txt", ndmin=2):
        made = np.eye(4)
        made[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
        made[:3, 3] = tx, ty, tz
        poses.append(made)
    pictures = [cv2.imread(str(p)) for p in sorted((trajectory / "image_left").iterdir())]
    depths = [np.load(p) for p in sorted((trajectory / "depth_left").iterdir())]
    return pictures, depths, poses


def ned_camera_points(depth_m, camera):
    """Points of a depth image in TartanAir's camera: x forward, y right, z down."""
    v, u = np.mgrid[: camera.height, : camera.width]
    right, down = (u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy
    return np.stack([depth_m, depth_m * right, depth_m * down], axis=-1)


def test_tartanair_has_the_layout_of_its_readme(folder, tartan):
    for name, pairs in by_scene(folder).items():
        trajectory = tartan / name / "Easy" / "P000"
        names = {
            sub.name: sorted(p.name for p in sub.iterdir())
            for sub in trajectory.iterdir()
            if sub.is_dir()
        }
        assert names["image_left"] == [f"{k:06d}_left.png" for k in range(PAIRS)]
        assert names["depth_left"] == [f"{k:06d}_left_depth.npy" for k in range(PAIRS)]
        assert names["seg_left"] == [f"{k:06d}_left_seg.npy" for k in range(PAIRS)]
        kinds = ("flow", "mask")
        flows = [f"{k:06d}_{k + 1:06d}_{kind}.npy" for k in range(PAIRS - 1) for kind in kinds]
        assert names["flow"] == flows
        pictures, depths, poses = read_tartanair(trajectory)
        assert len(pictures) == len(depths) == len(poses) == PAIRS
        for k, pair in enumerate(pairs):
            np.testing.assert_array_equal(pictures[k][..., ::-1], pair.rgb)
            np.testing.assert_array_equal(depths[k], pair.depth_m)
            assert depths[k].dtype == np.float32
            labels = np.load(trajectory / "seg_left" / names["seg_left"][k])
            np.testing.assert_array_equal(labels, pair.seg)
    assert "fx = 32" in (tartan / "README.txt").read_text()


def test_tartanair_poses_carry_points_between_frames_as_ours_do(folder, tartan):
    for name, pairs in by_scene(folder).items():
        _, depths, poses = read_tartanair(tartan / name / "Easy" / "P000")
        camera, first, last = pairs[0].camera, pairs[0], pairs[-1]
        points = ned_camera_points(depths[0].astype(np.float64), camera)
        world = points @ poses[0][:3, :3].T + poses[0][:3, 3]
        # North-east-down: the drone is above the ground, and flies east.
        assert poses[0][2, 3] == -first.world_from_cam[2, 3] < -2
        assert poses[-1][1, 3] > poses[0][1, 3] + 1 and poses[-1][0, 3] == poses[0][0, 3] == 0
        x, y, z = np.moveaxis((world - poses[-1][:3, 3]) @ poses[-1][:3, :3], -1, 0)
        seen = np.stack([camera.fx * y / x + camera.cx, camera.fy * z / x + camera.cy], axis=-1)
        ours = unproject(first.depth_m, camera, first.world_from_cam)
        expected, depth_m = project(ours, camera, last.world_from_cam)
        np.testing.assert_allclose(seen, expected, atol=1e-6)
        np.testing.assert_allclose(x, depth_m, atol=1e-6)
        # And what is seen there is as far: on the ground and the wall, but for their edges.
        u, v = np.round(seen).astype(int).clip(0, [camera.width - 1, camera.height - 1]).T
        inside = (depths[0] < 200) & (seen >= 0).all(-1)
        inside &= (seen <= [camera.width - 1, camera.height - 1]).all(-1)
        error = np.abs(x / depths[-1][v.T, u.T] - 1)[inside]
        assert inside.mean() > 0.3 and np.quantile(error, 0.9) < 0.1


def test_tartanair_flow_leads_to_the_next_frame(folder, tartan):
    for name, pairs in by_scene(folder).items():
        trajectory = tartan / name / "Easy" / "P000"
        pictures, depths, _ = read_tartanair(trajectory)
        for k in range(PAIRS - 1):
            stem = trajectory / "flow" / f"{k:06d}_{k + 1:06d}"
            flow, mask = np.load(f"{stem}_flow.npy"), np.load(f"{stem}_mask.npy")
            assert flow.dtype == np.float32 and flow.shape == (*mask.shape, 2)
            assert mask.dtype == np.uint8
            camera = pairs[k].camera
            grid = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), -1)
            to = (grid + flow).astype(np.float32)
            after = cv2.remap(pictures[k + 1], to, None, cv2.INTER_LINEAR).astype(float)
            # Near the camera, where the pattern is coarser than a pixel.
            good = (mask == 0) & (depths[k] < 30)
            assert good.mean() > 0.1 and (mask == tartanair.OUT_OF_VIEW).any()
            still = np.abs(pictures[k + 1].astype(float) - pictures[k])[good].mean()
            assert np.abs(after - pictures[k])[good].mean() < 0.4 * still
            assert (mask[depths[k] == 200] > 0).all() and (mask == tartanair.BEYOND).any()


def plain_pair(depth_m, camera, world_from_cam):
    picture = np.zeros((camera.height, camera.width, 3), np.uint8)
    meta = {
        "width": camera.width,
        "height": camera.height,
        "intrinsics": camera.matrix.tolist(),
        "world_from_cam": world_from_cam.tolist(),
        "max_depth_m": 200.0,
    }
    return Pair(key="", rgb=picture, prev=picture, depth_m=depth_m, meta=meta)


def test_a_post_hides_what_it_comes_to_stand_before():
    """A post at 10 m, a wall at 100 m: after 1 m to the right they move 3.2 and 0.32 px left."""
    camera = Intrinsics.from_fov(64, 48, 90.0)
    poses = [pose(look_rotation(np.array([1.0, 0, 0]), np.array([0, 0, 1.0])), np.array([0, y, 0]))
             for y in (0.0, -1.0)]  # fmt: skip

    def seen(left_px):
        depth = np.full((48, 64), 100, np.float32)
        depth[:, left_px : left_px + 8] = 10
        return depth

    pairs = [plain_pair(seen(at), camera, p) for at, p in zip((30, 27), poses, strict=True)]
    flow, mask = forward_flow(*pairs)
    post = pairs[0].depth_m == 10
    np.testing.assert_allclose(flow[post], [[-3.2, 0]] * post.sum(), atol=1e-5)
    np.testing.assert_allclose(flow[~post], [[-0.32, 0]] * (~post).sum(), atol=1e-5)
    assert (mask[post] == tartanair.VALID).all()
    # The post covers columns 27 to 34 then; the wall at x goes to x - 0.32, between two pixels.
    hidden = np.flatnonzero(mask[5] == tartanair.OCCLUDED)
    assert set(hidden) == {28, 29}


def test_what_is_behind_the_next_camera_has_no_flow():
    camera = Intrinsics.from_fov(16, 12, 90.0)
    here = pose(look_rotation(np.array([1.0, 0, 0]), np.array([0, 0, 1.0])), np.zeros(3))
    there = here.copy()
    there[0, 3] = 5
    pairs = [plain_pair(np.full((12, 16), 3, np.float32), camera, p) for p in (here, there)]
    flow, mask = forward_flow(*pairs)
    assert (flow == 0).all() and (mask == tartanair.OUT_OF_VIEW).all()


def test_a_gap_begins_a_new_trajectory(folder, tmp_path, monkeypatch):
    def with_a_gap(*given, **options):
        pairs = list(read_pairs(*given, **options))
        return iter(pairs[:2] + pairs[3:])

    monkeypatch.setattr(tartanair, "read_pairs", with_a_gap)
    export_tartanair(folder, tmp_path / "out")
    lengths = {
        "/".join(path.parts[-4:-1]): len(path.read_text().splitlines())
        for path in sorted((tmp_path / "out").rglob("pose_left.txt"))
    }
    assert lengths == {
        "blocks-s00001/Easy/P000": 4,
        "blocks-s00000/Easy/P000": 2,
        "blocks-s00000/Easy/P001": 1,
    }


def read_nerfstudio(folder):
    """Pictures, z-depth [m], camera-to-world and intrinsics, as its data parser takes them."""
    meta = json.loads((folder / "transforms.json").read_text())
    assert meta["camera_model"] == "OPENCV" and meta["orientation_override"] == "none"
    frames = sorted(meta["frames"], key=lambda frame: frame["file_path"])
    pictures = [cv2.imread(str(folder / frame["file_path"])) for frame in frames]
    # depth_unit_scale_factor is 1e-3 unless told otherwise.
    depths = [np.load(folder / f["depth_file_path"]).astype(np.float32) * 1e-3 for f in frames]
    return meta, pictures, depths, [np.array(f["transform_matrix"]) for f in frames]


def test_nerfstudio_rays_end_where_ours_do(folder, nerf):
    for name, pairs in by_scene(folder).items():
        meta, pictures, depths, poses = read_nerfstudio(nerf / f"{name}-f000")
        assert (meta["w"], meta["h"]) == (64, 48)
        # Its first pixel's centre is (0.5, 0.5), its camera looks along -z, y is up.
        y, x = np.mgrid[:48, :64] + 0.5
        rays = np.stack(
            [(x - meta["cx"]) / meta["fl_x"], -(y - meta["cy"]) / meta["fl_y"], -np.ones_like(x)],
            axis=-1,
        )
        assert (meta["cx"], meta["cy"]) == (32, 24)
        for pair, picture, depth, matrix in zip(pairs, pictures, depths, poses, strict=True):
            np.testing.assert_array_equal(picture[..., ::-1], pair.rgb)
            ends = (rays * depth[..., None]) @ matrix[:3, :3].T + matrix[:3, 3]
            near = pair.depth_m < 200
            expected = unproject(pair.depth_m, pair.camera, pair.world_from_cam)
            np.testing.assert_allclose(ends[near], expected[near], rtol=1e-5, atol=1e-4)
            assert (depth[~near] == 0).all() and (~near).any()
            assert depth.max() > 65.535, "what 16 bits of millimetres cannot hold is lost"
            np.testing.assert_allclose(np.linalg.det(matrix[:3, :3]), 1)


@pytest.mark.parametrize("export", [export_tartanair, export_nerfstudio])
def test_exports_take_a_split_and_never_a_folder_in_use(folder, tmp_path, export):
    out, calls = tmp_path / "out", []
    report = export(folder, out, split="test", on_progress=lambda *done: calls.append(done))
    assert report.pairs == PAIRS and calls[-1] == (PAIRS, PAIRS)
    assert sorted(path.name for path in out.iterdir()) == ["README.txt", "test"]
    for options, said in (({"split": "val"}, "val"), ({}, "exists")):
        with pytest.raises(DatasetError, match=said) as error:
            export(folder, out if not options else tmp_path / "new", **options)
        assert "\n" not in str(error.value)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out"]
