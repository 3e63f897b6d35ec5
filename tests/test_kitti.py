"""KITTI's layouts, calibration, scans and poses, against folders made here and real frames."""

import math
import pickle
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from synthdepth.camera import pose
from synthdepth.errors import DatasetError
from synthdepth.kitti.calibration import (
    CAM_FROM_BODY,
    Calibration,
    object_calibration,
    raw_calibration,
    read_table,
)
from synthdepth.kitti.dataset import KittiDataset
from synthdepth.kitti.lidar import VARIANTS, project_lidar, read_points
from synthdepth.kitti.oxts import oxts_of, world_from_imu
from synthdepth.kitti.png import encode_depth
from synthdepth.kitti.splits import read_split
from synthdepth.seeding import lane
from tests.real import REAL, needs_real

WIDTH, HEIGHT = 62, 20
DATE, DRIVE = "2011_09_26", "2011_09_26_drive_0002_sync"
# As KITTI's: not zero in the fourth column, a rectification that turns a little.
P2 = np.array([[36.0, 0, 30.4, 2.3], [0, 36.0, 9.1, -0.02], [0, 0, 1, 0.005]])
P3 = P2 - [[0, 0, 0, 19.4], [0, 0, 0, 0], [0, 0, 0, 0]]
RECT = Rotation.from_euler("xyz", [0.4, -0.5, 0.6], degrees=True).as_matrix()
VELO_T, IMU_T = np.array([-0.004, -0.076, -0.27]), np.array([-0.81, 0.32, -0.80])
VELO_R = Rotation.from_euler("z", 0.4, degrees=True).as_matrix() @ CAM_FROM_BODY
real = needs_real("kitti_object")


def row(name, values):
    return f"{name}: {' '.join(f'{value:e}' for value in np.ravel(values))}\n"


def write(path, data):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data.encode() if isinstance(data, str) else data)


def picture(number, height=HEIGHT, width=WIDTH):
    return lane(0, "picture", number).integers(0, 256, (height, width, 3), np.uint8)


def png(image):
    return cv2.imencode(".png", image[..., ::-1] if image.ndim == 3 else image)[1].tobytes()


def scan(number, count=3000):
    rng = lane(0, "scan", number)
    low, high = [-5, -20, -3, 0], [80, 20, 5, 1]
    return rng.uniform(low, high, (count, 4)).astype("<f4")


def depth_of(number):
    rng = lane(0, "depth", number)
    depth = rng.uniform(1, 90, (HEIGHT, WIDTH)) * (rng.uniform(size=(HEIGHT, WIDTH)) < 0.2)
    return (np.round(depth * 256) / 256).astype(np.float32)


def oxts(number):
    values = np.zeros(30)
    values[:6] = 49.015 + 1e-5 * number, 8.434, 112.8, 0.01, -0.02, 0.3
    return " ".join(map(str, values))


@pytest.fixture
def raw(tmp_path):
    """Two frames of a raw recording, 4 and 5, with scans and poses."""
    date = tmp_path / "raw" / DATE
    head = "calib_time: 09-Jan-2012 13:57:47\n"
    cameras = "".join(
        row(f"S_rect_{k:02d}", [WIDTH, HEIGHT])
        + row(f"R_rect_{k:02d}", RECT if k == 0 else np.eye(3))
        + row(f"P_rect_{k:02d}", P2 if k < 3 else P3)
        for k in range(4)
    )
    write(date / "calib_cam_to_cam.txt", head + "corner_dist: 9.95e-02\n" + cameras)
    write(date / "calib_velo_to_cam.txt", head + row("R", VELO_R) + row("T", VELO_T))
    write(date / "calib_imu_to_velo.txt", head + row("R", np.eye(3)) + row("T", IMU_T))
    for number in (4, 5):
        for camera in (2, 3):
            path = date / DRIVE / f"image_{camera:02d}" / "data" / f"{number:010d}.png"
            write(path, png(picture(10 * camera + number)))
        path = date / DRIVE / "velodyne_points" / "data" / f"{number:010d}.bin"
        write(path, scan(number).tobytes())
        write(date / DRIVE / "oxts" / "data" / f"{number:010d}.txt", oxts(number))
    return tmp_path / "raw"


@pytest.fixture
def annotated(tmp_path):
    """Depth of frame 5, in the benchmark's folder of validation drives."""
    for camera in (2, 3):
        place = tmp_path / "depth" / "val" / DRIVE / "proj_depth"
        write(place / f"groundtruth/image_{camera:02d}/0000000005.png", encode_depth(depth_of(5)))
        write(place / f"velodyne_raw/image_{camera:02d}/0000000005.png", encode_depth(depth_of(6)))
    return tmp_path / "depth"


def object_text():
    return (
        "".join(row(f"P{k}", P2 if k < 3 else P3) for k in range(4))
        + row("R0_rect", RECT)
        + row("Tr_velo_to_cam", np.column_stack([VELO_R, VELO_T]))
        + row("Tr_imu_to_velo", np.column_stack([np.eye(3), IMU_T]))
        + "\n"
    )


@pytest.fixture
def objects(tmp_path):
    place = tmp_path / "object"
    write(place / "training/image_2/000007.png", png(picture(7)))
    write(place / "training/prev_2/000007_01.png", png(picture(6)))
    write(place / "training/velodyne/000007.bin", scan(7).tobytes())
    write(place / "training/calib/000007.txt", object_text())
    return place


def looped(points, shape, *, one_up=False, forward_only=False, velodyne_x=False):
    """The depth image as KITTI's own formula gives it, a point at a time: P R Tr x."""
    image = np.zeros(shape)
    for x, y, z in points:
        if forward_only and x < 0:
            continue
        u, v, w = P2 @ np.append(RECT @ (VELO_R @ [x, y, z] + VELO_T), 1)
        if w <= 0:
            continue
        column, line = round(u / w) - one_up, round(v / w) - one_up
        if 0 <= column < shape[1] and 0 <= line < shape[0]:
            depth = x if velodyne_x else w
            if image[line, column] == 0 or depth < image[line, column]:
                image[line, column] = depth
    return image


def assert_same_depth(image, expected):
    np.testing.assert_array_equal(image > 0, expected > 0)
    np.testing.assert_allclose(image, expected, rtol=1e-5)


LOOPED = {
    "camera_z": {},
    "monodepth2": {"one_up": True, "forward_only": True},
    "velodyne_x": {"one_up": True, "forward_only": True, "velodyne_x": True},
}


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_scan_is_projected_as_the_formula_says(tmp_path, variant):
    write(tmp_path / "c.txt", object_text())
    points = scan(1)[:, :3].astype(np.float64)
    # Two in one pixel, the farther one first and last; and one beside the scanner, behind its x.
    points = np.vstack([[30, 0, 0], [10, 0, 0.05], [30, 0, 0], points, [-0.1, 0, 0]])
    image = project_lidar(points, object_calibration(tmp_path / "c.txt"), (HEIGHT, WIDTH), variant)
    assert image.dtype == np.float32
    expected = looped(points, (HEIGHT, WIDTH), **LOOPED[variant])
    assert 300 < np.count_nonzero(expected) < expected.size
    assert_same_depth(image, expected)


def test_the_variants_differ_as_their_makers_do(tmp_path):
    write(tmp_path / "c.txt", object_text())
    calibration = object_calibration(tmp_path / "c.txt")
    points = scan(2)[:, :3].astype(np.float64)
    points = points[points[:, 0] > 0.5]
    ours, theirs, along_x = (
        project_lidar(points, calibration, (HEIGHT, WIDTH), name) for name in VARIANTS
    )
    np.testing.assert_array_equal(theirs[:-1, :-1], ours[1:, 1:])
    both = (theirs > 0) & (along_x > 0)
    # The scanner is 0.27 m behind the camera, so its x is larger by about that.
    assert np.median((along_x - theirs)[both]) == pytest.approx(0.27, abs=0.1)
    with pytest.raises(DatasetError, match="'camera_x': allowed are camera_z, monodepth2, velo"):
        project_lidar(points, calibration, (HEIGHT, WIDTH), "camera_x")


def test_a_point_straight_ahead_is_seen_at_its_depth():
    k = np.array([[36.0, 0, 30], [0, 36, 9], [0, 0, 1]])
    calibration = Calibration(intrinsics=k, cam_from_velo=pose(CAM_FROM_BODY, np.zeros(3)))
    image = project_lidar(np.array([[50.0, 0, 0]]), calibration, (HEIGHT, WIDTH))
    assert image[9, 30] == 50 and np.count_nonzero(image) == 1


def test_names_in_calibration_files_end_at_the_first_colon(tmp_path):
    write(tmp_path / "c.txt", "calib_time: 09-Jan-2012 13:57:47\nR: 1 2 3\nurl: a:b\n\n")
    table = read_table(tmp_path / "c.txt")
    assert list(table) == ["R"]
    assert table["R"].tolist() == [1, 2, 3]


def test_the_fourth_column_moves_the_camera_and_not_its_k(raw):
    left, right = (raw_calibration(raw / DATE, camera) for camera in (2, 3))
    np.testing.assert_allclose(left.intrinsics, P2[:, :3])
    assert left.size == (WIDTH, HEIGHT)
    point = np.array([20.0, 3, 1])
    for calibration, projection in ((left, P2), (right, P3)):
        seen = calibration.cam_from_velo @ np.append(point, 1)
        expected = projection @ np.append(RECT @ (VELO_R @ point + VELO_T), 1)
        np.testing.assert_allclose(calibration.intrinsics @ seen[:3], expected, atol=1e-4)
        assert seen[2] == pytest.approx(expected[2])
    baseline = (left.cam_from_velo - right.cam_from_velo)[:3, 3]
    np.testing.assert_allclose(baseline, [19.4 / 36, 0, 0], atol=1e-6)


def test_raw_recordings(raw):
    data = KittiDataset(raw)
    assert data.layout == "raw" and data.depth == "lidar" and len(data) == 4
    assert [sample.key for sample in data] == [
        f"{DRIVE}/image_{camera:02d}/{number:010d}" for camera in (2, 3) for number in (4, 5)
    ]
    first, second = data[0], data[1]
    np.testing.assert_array_equal(first.rgb, picture(24))
    assert first.prev is None and first.world_from_cam_prev is None
    np.testing.assert_array_equal(second.prev, picture(24))
    np.testing.assert_array_equal(second.world_from_cam_prev, first.world_from_cam)
    np.testing.assert_array_equal(data[3].prev, picture(34))
    assert_same_depth(second.depth_m, looped(scan(5)[:, :3].astype(float), (HEIGHT, WIDTH)))
    np.testing.assert_array_equal(second.valid, second.depth_m > 0)
    assert second.max_depth_m == np.inf
    assert second.meta["depth"] == "lidar camera_z"
    assert KittiDataset(raw, variant="velodyne_x")[1].meta["depth"] == "lidar velodyne_x"


def test_poses_of_raw_recordings(raw):
    left, right = (KittiDataset(raw)[k] for k in (1, 3))
    # 1e-5 degrees of latitude north, in metres; a Mercator map is true to scale where it starts.
    moved = (left.world_from_cam - left.world_from_cam_prev)[:3, 3]
    np.testing.assert_allclose(moved, [0, math.radians(1e-5) * 6378137, 0], atol=1e-3)
    # The right camera is 19.4 / 36 m to the right of the left one, in its own axes.
    apart = np.linalg.inv(left.world_from_cam) @ right.world_from_cam
    np.testing.assert_allclose(apart, pose(np.eye(3), np.array([19.4 / 36, 0, 0])), atol=1e-5)
    # It looks where the car goes: yaw 0.3 from east, counter-clockwise.
    x, y, _ = left.world_from_cam[:3, 2]
    assert math.atan2(y, x) == pytest.approx(0.3, abs=0.03)
    # A point of the scan lies in the world where its scanner and the unit say.
    point, earth_m, degree = np.array([12.0, -3, 1]), 6378137, math.radians(1)
    seen = left.world_from_cam @ raw_calibration(raw / DATE, 2).cam_from_velo @ np.append(point, 1)
    scale, north = (
        math.cos(49.01504 * degree),
        [math.log(math.tan((90 + latitude) * degree / 2)) for latitude in (49, 49.01505)],
    )
    unit = scale * earth_m * np.array([0.434 * degree, north[1] - north[0], 0]) + [0, 0, 112.8]
    turn = Rotation.from_euler("xyz", [0.01, -0.02, 0.3]).as_matrix()
    np.testing.assert_allclose(seen[:3], unit + turn @ (point - IMU_T), atol=1e-5)


angles = st.floats(-1.4, 1.4)
metres = st.floats(-2000, 2000)


@settings(max_examples=50, deadline=None)
@given(st.floats(-3.1, 3.1), angles, angles, metres, metres, metres)
def test_poses_survive_latitude_and_longitude(yaw, pitch, roll, east, north, up):
    rotation = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    there = pose(rotation, np.array([east, north, up]))
    values = oxts_of(there, np.array([3.0, 4.0, 1.0]))
    first = oxts_of(pose(np.eye(3), np.array([100.0, -1500.0, 0])), np.zeros(3))
    np.testing.assert_allclose(world_from_imu(values, first), there, atol=3e-4)
    np.testing.assert_allclose(world_from_imu(values, values), there, atol=3e-4)
    assert values[6] == 4 and values[7] == 3
    assert math.hypot(*values[8:10]) == pytest.approx(5)


def test_the_depth_benchmark(raw, annotated):
    data = KittiDataset(annotated, raw_folder=raw)
    assert data.layout == "depth" and len(data) == 2
    np.testing.assert_array_equal(data[0].depth_m, depth_of(5))
    np.testing.assert_array_equal(data[0].rgb, picture(25))
    np.testing.assert_array_equal(data[1].rgb, picture(35))
    np.testing.assert_array_equal(data[0].prev, picture(24))
    np.testing.assert_allclose(data[0].intrinsics, P2[:, :3])
    one = KittiDataset(annotated, raw_folder=raw, depth="velodyne_raw")[0]
    np.testing.assert_array_equal(one.depth_m, depth_of(6))
    with pytest.raises(DatasetError, match="no frames of layout depth"):
        KittiDataset(annotated, raw_folder=raw, split="train")
    assert len(KittiDataset(annotated, raw_folder=raw, split="val")) == 2


def test_the_object_benchmark(objects):
    data = KittiDataset(objects, transform=lambda sample: replace(sample, input=sample.rgb[:2]))
    assert data.layout == "object"
    sample = data[0]
    assert sample.key == "000007" and sample.world_from_cam is None
    np.testing.assert_array_equal(sample.input, picture(7)[:2])
    np.testing.assert_array_equal(sample.prev, picture(6))
    assert_same_depth(sample.depth_m, looped(scan(7)[:, :3].astype(float), (HEIGHT, WIDTH)))


def test_folders_of_pictures_and_depth(tmp_path):
    k = np.array([[700.0, 0, 600], [0, 700, 170], [0, 0, 1]])
    names = [f"{DRIVE}_{{}}_000000000{n}_image_03.png" for n in (5, 8)]
    for name, number in zip(names, (5, 8), strict=True):
        write(tmp_path / "image" / name.format("image"), png(picture(number)))
        path = tmp_path / "groundtruth_depth" / name.format("groundtruth_depth")
        write(path, encode_depth(depth_of(number)))
        path = tmp_path / "velodyne_raw" / name.format("velodyne_raw")
        write(path, encode_depth(depth_of(number + 1)))
    path = (tmp_path / "intrinsics" / names[0].format("image")).with_suffix(".txt")
    write(path, " ".join(map(str, k.ravel())))
    data = KittiDataset(tmp_path)
    assert data.layout == "selection"
    np.testing.assert_array_equal(data[1].depth_m, depth_of(8))
    np.testing.assert_array_equal(data[0].intrinsics, k)
    raw_depth = KittiDataset(tmp_path, depth="velodyne_raw")[0].depth_m
    np.testing.assert_array_equal(raw_depth, depth_of(6))
    # No file of K: unknown, unless the caller knows it.
    assert np.isnan(data[1].intrinsics).all()
    np.testing.assert_array_equal(KittiDataset(tmp_path, intrinsics=k)[1].intrinsics, k)


def test_split_files(raw, annotated, tmp_path):
    stem = f"{DRIVE}/image_02/data/0000000005.png"
    depth = f"{DRIVE}/proj_depth/groundtruth/image_02/0000000005.png"
    other = stem.replace("05.png", "04.png").replace("image_02", "image_03")
    write(tmp_path / "bts.txt", f"{DATE}/{stem} {depth} 721.5377\n{DATE}/{other} None 721.5377\n")
    data = KittiDataset(annotated, raw_folder=raw, split_file=tmp_path / "bts.txt")
    known, unknown = data
    np.testing.assert_array_equal(known.depth_m, depth_of(5))
    np.testing.assert_array_equal(unknown.rgb, picture(34))
    assert not unknown.valid.any() and not unknown.depth_m.any()

    # Without a word on depth the frame has what there is.
    write(tmp_path / "bare.txt", f"{DATE}/{stem} 721.5\n{DATE}/{stem}\n")
    for sample in KittiDataset(annotated, raw_folder=raw, split_file=tmp_path / "bare.txt"):
        np.testing.assert_array_equal(sample.depth_m, depth_of(5))
    write(tmp_path / "gone.txt", f"{DATE}/{stem} {depth.replace('05.png', '09.png')} 721.5\n")
    with pytest.raises(DatasetError, match=r"there is no .*09.png"):
        KittiDataset(annotated, raw_folder=raw, split_file=tmp_path / "gone.txt")

    write(tmp_path / "mono.txt", f"{DATE}/{DRIVE} 5 r\n{DATE}/{DRIVE} 0000000004 l\n")
    right, left = KittiDataset(raw, split_file=tmp_path / "mono.txt")
    np.testing.assert_array_equal(right.rgb, picture(35))
    np.testing.assert_array_equal(left.rgb, picture(24))
    assert right.valid.any()
    right, left = KittiDataset(annotated, raw_folder=raw, split_file=tmp_path / "mono.txt")
    np.testing.assert_array_equal(right.depth_m, depth_of(5))
    assert not left.valid.any()


@pytest.mark.parametrize(
    "line", ["a/b.png c.png 7", f"{DATE}/{DRIVE} 5 x", f"{DATE}/{DRIVE} five l", "12", "a b c d"]
)
def test_a_line_that_is_of_no_split_file_is_named(tmp_path, line):
    write(tmp_path / "s.txt", f"{DATE}/{DRIVE} 5 l\n\n{line}\n")
    with pytest.raises(DatasetError, match="line 3 is"):
        read_split(tmp_path / "s.txt")


def broken(raw, annotated, what):
    if what == "eight bits":
        path = next(annotated.rglob("groundtruth/image_02/*.png"))
        path.write_bytes(png(np.zeros((HEIGHT, WIDTH), np.uint8)))
    elif what == "size":
        path = next(annotated.rglob("groundtruth/image_02/*.png"))
        path.write_bytes(encode_depth(np.ones((HEIGHT, WIDTH + 1))))
    elif what == "picture size":
        path = next(raw.rglob("image_02/data/*05.png"))
        path.write_bytes(png(picture(0, HEIGHT + 2)))
    elif what == "no picture":
        next(raw.rglob("image_02/data/*05.png")).unlink()
    elif what == "cut picture":
        next(raw.rglob("image_02/data/*05.png")).write_bytes(b"\x89PNG")
    elif what == "no calibration":
        (raw / DATE / "calib_cam_to_cam.txt").unlink()
    elif what == "no P":
        path = raw / DATE / "calib_cam_to_cam.txt"
        path.write_text(path.read_text().replace("P_rect_02", "P_rect_2"))
    elif what == "oxts":
        next(raw.rglob("oxts/data/*05.txt")).write_text("1 2 3")


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("eight bits", "1 channel.* of 8 bits: KITTI's depth is one channel of 16 bits"),
        ("size", "is 63x20, its picture is 62x20"),
        ("picture size", "is 62x22, its calibration is for 62x20"),
        ("no picture", "there is no picture .*raw_folder says"),
        ("cut picture", "is no readable picture"),
        ("no calibration", "calib_cam_to_cam.txt cannot be read: No such file"),
        ("no P", "P_rect_02 needs 12 numbers, the file has nothing"),
        ("oxts", "has 3 numbers: allowed are 30"),
    ],
)
def test_what_is_broken_is_told_in_one_line(raw, annotated, what, says):
    broken(raw, annotated, what)
    with pytest.raises(DatasetError, match=says) as told:
        KittiDataset(annotated, raw_folder=raw)[0]
    assert "\n" not in str(told.value)


def test_depth_that_is_asked_for_must_be_there(raw):
    for path in raw.rglob("*.bin"):
        path.unlink()
    assert not any(sample.valid.any() for sample in KittiDataset(raw))
    with pytest.raises(DatasetError, match="has no frame with depth lidar"):
        KittiDataset(raw, depth="lidar")


def test_a_scan_needs_its_calibration_and_whole_points(raw, tmp_path):
    (raw / DATE / "calib_velo_to_cam.txt").unlink()
    with pytest.raises(DatasetError, match="has no calib_velo_to_cam.txt"):
        KittiDataset(raw)[0]
    write(tmp_path / "cut.bin", b"\0" * 30)
    with pytest.raises(DatasetError, match="30 bytes: allowed are 16 a point"):
        read_points(tmp_path / "cut.bin")


def test_what_is_asked_for_must_be_there(raw, objects, tmp_path):
    for given_, says in [
        ({"layout": "odometry"}, "'odometry': allowed are depth, selection, object, raw"),
        ({"depth": "groundtruth"}, "depth of layout raw 'groundtruth': allowed are lidar"),
        ({"variant": "x"}, "variant 'x': allowed are camera_z"),
        ({"split": "val"}, "split of layout raw 'val': allowed are none"),
        ({"split_file": tmp_path / "no"}, "no cannot be read: No such file"),
    ]:
        with pytest.raises(DatasetError, match=says):
            KittiDataset(raw, **given_)
    with pytest.raises(DatasetError, match="is no folder"):
        KittiDataset(tmp_path / "no")
    (tmp_path / "empty").mkdir()
    with pytest.raises(DatasetError, match="none of KITTI's layouts: known are depth"):
        KittiDataset(tmp_path / "empty")
    write(tmp_path / "s.txt", f"{DATE}/{DRIVE} 5 l\n")
    with pytest.raises(DatasetError, match="split file 'object': allowed are depth, raw"):
        KittiDataset(objects, split_file=tmp_path / "s.txt")


def test_workers_can_have_a_copy(raw):
    copy = pickle.loads(pickle.dumps(KittiDataset(raw)))
    assert len(copy) == 4
    np.testing.assert_array_equal(copy[1].rgb, KittiDataset(raw)[1].rgb)


@real
def test_real_scans_lie_on_the_objects():
    """Where the scan's depth jumps, the picture changes: more than 8 px to either side."""
    here, beside = [], []
    for sample in KittiDataset(REAL / "kitti_object"):
        assert sample.rgb.shape[0] in (370, 375)
        known = sample.depth_m[sample.valid]
        assert 0.03 < sample.valid.mean() < 0.06
        assert known.min() > 2 and 60 < known.max() < 125
        grey = cv2.cvtColor(sample.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
        change = np.abs(cv2.Sobel(cv2.GaussianBlur(grey, (3, 3), 0), -1, 1, 0))
        change = cv2.dilate(change, np.ones((1, 3)))
        rows, columns = np.nonzero(sample.valid)
        near = (np.diff(rows) == 0) & (np.diff(columns) <= 5)
        edge = near & (np.abs(np.diff(np.log(sample.depth_m[rows, columns]))) > 0.25)
        line, column = rows[:-1][edge], (columns[:-1] + columns[1:])[edge] // 2
        for shift, into in ((-8, beside), (0, here), (8, beside)):
            at = column + shift
            inside = (at >= 0) & (at < grey.shape[1])
            into.append(change[line[inside], at[inside]])
    assert len(np.concatenate(here)) > 300
    assert np.concatenate(here).mean() > 1.15 * np.concatenate(beside).mean()


@real
def test_real_scans_show_what_the_scanners_x_costs():
    for right, wrong in zip(
        KittiDataset(REAL / "kitti_object", variant="monodepth2"),
        KittiDataset(REAL / "kitti_object", variant="velodyne_x"),
        strict=True,
    ):
        both = right.valid & wrong.valid
        error = (wrong.depth_m - right.depth_m)[both]
        assert 0.27 < np.median(error) < 0.33
        assert 0.02 < np.mean(np.abs(error) / right.depth_m[both]) < 0.032


@real
def test_a_real_frame_of_the_depth_benchmark():
    (sample,) = KittiDataset(REAL / "kitti_depth")
    known = sample.depth_m[sample.valid]
    assert sample.rgb.shape == (375, 1242, 3)
    assert 0.18 < sample.valid.mean() < 0.21
    assert 5 < known.min() < 6 and 80 < known.max() < 86
    assert 0 < np.count_nonzero(known > 80) < 200
    assert not sample.valid[:100].any()
