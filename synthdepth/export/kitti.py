"""Our datasets as KITTI has its own: the raw recordings and the depth benchmark in one folder.

    <date>/calib_cam_to_cam.txt, calib_velo_to_cam.txt, calib_imu_to_velo.txt
    <date>/<drive>/image_02/data/%010d.png, image_02/timestamps.txt
    <date>/<drive>/oxts/data/%010d.txt, oxts/timestamps.txt
    train|val/<drive>/proj_depth/groundtruth/image_02/%010d.png
    splits/bts/{train,val}_files_with_gt.txt
    splits/monodepth2/{train,val,test}_files.txt

A scene becomes a date (2000_01_01 and that many days), a flight a drive, a frame keeps its number:
scene 12, flight 3, frame 45 is 2000_01_13_drive_0003_sync, 0000000045. Frame t-1 of every pair is
written as the picture and pose before, without depth where it is no pair itself. The split test
becomes `val`, as the benchmark's test has no public depth.
"""

import dataclasses
import datetime
import itertools
import json
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.dataset.folder import new_folder
from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.pair import Pair, encode_png
from synthdepth.errors import DatasetError
from synthdepth.export.folder import ExportReport, read_pairs, write_file
from synthdepth.kitti.calibration import CAM_FROM_BODY
from synthdepth.kitti.dataset import EXPORT_NOTE
from synthdepth.kitti.oxts import oxts_of
from synthdepth.kitti.png import MAX_DEPTH_M, PER_METRE, encode_depth

SKIES = ("invalid", "saturated")
_SPLIT = {"train": "train", "test": "val"}
_FIRST_DATE = datetime.date(2000, 1, 1)
# Dates have four digits.
_LONGEST_DRIVE_S = 365 * 86400
# Every number up to the last has a line of times, whether there is such a frame or not.
_LAST_FRAME = 1_000_000


def drive_name(scene_index: int, flight_index: int) -> str:
    """The drive of a flight, e.g. 2000_01_13_drive_0003_sync; its first 10 letters are the date."""
    date = _FIRST_DATE + datetime.timedelta(days=scene_index)
    return f"{date:%Y_%m_%d}_drive_{flight_index:04d}_sync"


def export_kitti(
    folder: Path,
    out: Path,
    *,
    split: str | None = None,
    sky: str = "invalid",
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> ExportReport:
    """Write a dataset in KITTI's format.

    Depth is 16-bit PNG, metres = value / 256, rounded to the nearest. In KITTI a number is a
    measured distance and 0 is none, and the official evaluation neither caps nor crops: so what our
    depth says of saturated pixels, "at least this far", is left out (`sky="invalid"`), as a laser
    gets no echo from there. With `sky="saturated"` they hold the range, 200 m = 51200, for training
    on far depth; `synthdepth.json` then tells `KittiDataset` where the depth saturates.

    Args:
        folder: the dataset.
        out: the folder to write, new or empty.
        split: `train` or `test`; both without.
        sky: `invalid` or `saturated`.
        on_progress: called with (pairs done, pairs in all).

    Raises:
        DatasetError: the dataset cannot be read, `out` is taken or cannot be written.
    """
    if sky not in SKIES:
        raise DatasetError(f"sky {sky!r}: allowed are {', '.join(SKIES)}")
    range_m = min(read_manifest(folder)["recipe"]["render"]["max_depth_m"], MAX_DEPTH_M)
    pairs = read_pairs(folder, split=split, on_progress=on_progress)
    drives = []
    with new_folder(out) as root:
        for name, flight in itertools.groupby(pairs, key=_drive_of):
            drives.append(_write_drive(root, name, flight, range_m, sky))
        for name, lines in _split_files(drives).items():
            write_file(root / "splits" / name, "".join(f"{line}\n" for line in lines).encode())
        # The range as the file can say it, so that what is saturated holds exactly this.
        saturates = round(range_m * PER_METRE) / PER_METRE if sky == "saturated" else None
        write_file(root / EXPORT_NOTE, json.dumps({"max_depth_m": saturates}).encode() + b"\n")
    count = sum(len(drive.pairs) for drive in drives)
    return ExportReport(
        folder=Path(out), pairs=count, notes=_notes(Path(out), drives[0].camera, range_m, sky)
    )


def _drive_of(pair: Pair) -> str:
    return drive_name(pair.meta["scene_index"], pair.meta["flight_index"])


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Drive:
    """What was written of a flight: its pairs' frame numbers, and those of all its pictures."""

    name: str
    split: str
    camera: Intrinsics
    pairs: list[int]
    pictures: set[int]

    @property
    def path(self) -> str:
        """`<date>/<drive>`."""
        return f"{self.name[:10]}/{self.name}"


def _write_drive(root: Path, name: str, flight: Iterable[Pair], range_m: float, sky: str) -> _Drive:
    numbers, pictures = [], set()
    for pair in flight:
        split, number, camera = _SPLIT[pair.meta["split"]], pair.meta["frame_index"], pair.camera
        drive = _Drive(name=name, split=split, camera=camera, pairs=numbers, pictures=pictures)
        if not numbers:
            _write_calibration(root / name[:10], camera)
            first = pair
        elif camera != first.camera:
            raise DatasetError(f"{pair.key} has another camera than {first.key}: KITTI allows one")
        if number - 1 not in pictures:
            moved = (pair.world_from_cam - pair.world_from_cam_prev)[:3, 3] / pair.meta["dt_s"]
            _write_frame(root / drive.path, number - 1, pair.prev, pair.world_from_cam_prev, moved)
        velocity = np.array(pair.meta["velocity_mps"])
        _write_frame(root / drive.path, number, pair.rgb, pair.world_from_cam, velocity)
        numbers.append(number)
        pictures |= {number - 1, number}
        far = np.float32(range_m) if sky == "saturated" else np.float32(0)
        depth = np.where(pair.depth_m >= np.float32(range_m), far, pair.depth_m)
        write_file(root / split / _depth_path(name, number), encode_depth(depth))
    if max(pictures) > _LAST_FRAME:
        raise DatasetError(f"{name} has a frame {max(pictures)}: allowed is up to {_LAST_FRAME}")
    seconds = (
        first.meta["time_s"]
        + (np.arange(max(pictures) + 1) - first.meta["frame_index"]) * first.meta["dt_s"]
    )
    for sensor in ("image_02", "oxts"):
        write_file(root / drive.path / sensor / "timestamps.txt", timestamps(name, seconds))
    return drive


def _depth_path(drive: str, number: int) -> str:
    return f"{drive}/proj_depth/groundtruth/image_02/{number:010d}.png"


def _write_frame(
    drive: Path, number: int, picture: np.ndarray, world_from_cam: np.ndarray, velocity: np.ndarray
) -> None:
    write_file(drive / "image_02" / "data" / f"{number:010d}.png", encode_png(picture))
    # The unit sits in the camera, with its own axes.
    world_from_imu = world_from_cam.copy()
    world_from_imu[:3, :3] = world_from_cam[:3, :3] @ CAM_FROM_BODY
    values = " ".join(f"{value:.17g}" for value in oxts_of(world_from_imu, velocity)[:25])
    # The last five are whole numbers.
    write_file(drive / "oxts" / "data" / f"{number:010d}.txt", f"{values} 0 0 0 0 0\n".encode())


def _write_calibration(date: Path, camera: Intrinsics) -> None:
    """The date's files: scanner and inertial unit are in the camera, and all four cameras are one.

    KITTI's readers want four cameras; pictures are written of camera 2 only.
    """
    turn, still = np.eye(3), np.zeros(3)
    size = [camera.width, camera.height]
    lines = {"corner_dist": [0]}
    for k in range(4):
        lines |= {f"S_{k:02d}": size, f"K_{k:02d}": camera.matrix, f"D_{k:02d}": np.zeros(5)}
        lines |= {f"R_{k:02d}": turn, f"T_{k:02d}": still, f"S_rect_{k:02d}": size}
        projection = np.column_stack([camera.matrix, still])
        lines |= {f"R_rect_{k:02d}": turn, f"P_rect_{k:02d}": projection}
    _write_table(date / "calib_cam_to_cam.txt", lines)
    optics = {"delta_f": [0, 0], "delta_c": [0, 0]}
    _write_table(date / "calib_velo_to_cam.txt", {"R": CAM_FROM_BODY, "T": still} | optics)
    _write_table(date / "calib_imu_to_velo.txt", {"R": turn, "T": still})


def _write_table(path: Path, lines: dict) -> None:
    text = "calib_time: 01-Jan-2000 00:00:00\n"
    for name, values in lines.items():
        text += f"{name}: {' '.join(f'{value:.15e}' for value in np.ravel(values))}\n"
    write_file(path, text.encode())


def timestamps(drive: str, seconds: np.ndarray) -> bytes:
    """A line for every frame number from 0, written or not: line k is frame k's, as in KITTI."""
    if seconds.max() > _LONGEST_DRIVE_S:
        raise DatasetError(f"{drive} has a frame at {seconds.max():g} s: allowed is up to a year")
    midnight = datetime.datetime.strptime(drive[:10], "%Y_%m_%d")
    times = (midnight + datetime.timedelta(seconds=max(float(s), 0.0)) for s in seconds)
    return "".join(f"{time:%Y-%m-%d %H:%M:%S.%f}000\n" for time in times).encode()


def _split_files(drives: list[_Drive]) -> dict[str, list[str]]:
    """The lists of BTS and of monodepth2, {name: lines}.

    monodepth2 trains on a frame with both neighbours: its `train_files` and `val_files` name those
    that have them, `test_files` all of the split val.
    """
    files = {}
    for drive, number in ((each, number) for each in drives for number in each.pairs):
        picture = f"{drive.path}/image_02/data/{number:010d}.png"
        line = f"{picture} {_depth_path(drive.name, number)} {drive.camera.fx:.4f}"
        files.setdefault(f"bts/{drive.split}_files_with_gt.txt", []).append(line)
        line = f"{drive.path} {number} l"
        if drive.split == "val":
            files.setdefault("monodepth2/test_files.txt", []).append(line)
        if number + 1 in drive.pictures:
            files.setdefault(f"monodepth2/{drive.split}_files.txt", []).append(line)
    return files


def _notes(out: Path, camera: Intrinsics, range_m: float, sky: str) -> tuple[str, ...]:
    far = "0 (not measured)" if sky == "invalid" else f"{round(range_m * PER_METRE)}"
    notes = [
        f"pixels at {range_m:g} m or farther, with the sky, hold {far}; others rounded to 1/256 m",
        "a scene is a date, a flight a drive, the split test is val; frames keep their numbers",
        f"BTS lists: pictures below {out}, depth below {out}/train or {out}/val",
        "monodepth2 has its intrinsics in the code: they are "
        f"{camera.fx / camera.width:.4f} and {camera.fy / camera.height:.4f} of the size here",
    ]
    size = f"{camera.width}x{camera.height}"
    if size != "1242x375":
        notes.append(
            f"pictures are {size}; KITTI's crops are for 1242x375 (render with --camera kitti)"
        )
    return tuple(notes)
