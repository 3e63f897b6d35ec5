"""KITTI as a sequence of samples, whichever of its layouts it lies in."""

from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from pathlib import Path

import numpy as np

from synthdepth.config import parse_json, shown
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.transforms import set_epoch_of, several, transformed
from synthdepth.errors import DatasetError
from synthdepth.kitti.calibration import Calibration
from synthdepth.kitti.layouts import (
    ALL_SPLITS,
    KINDS,
    LAYOUTS,
    LIDAR,
    SPLITS,
    Frame,
    Place,
    detect_layout,
)
from synthdepth.kitti.lidar import VARIANTS, project_lidar, read_points
from synthdepth.kitti.oxts import read_oxts, world_from_imu
from synthdepth.kitti.png import read_depth, read_picture
from synthdepth.kitti.splits import frames_of_split

# What `export_kitti` leaves beside KITTI's own files: {"max_depth_m": where the depth saturates}.
EXPORT_NOTE = "synthdepth.json"

Transform = Callable[[Sample], Sample]


class KittiDataset(Sequence[Sample]):
    """Reads KITTI: the raw recordings, the depth and object benchmarks, and what we export.

    Frames come in the order of their names or of the split file. Frame t-1 is there where the
    layout has it, poses where a raw recording has `oxts` and `calib_imu_to_velo.txt`; the world is
    as in `oxts.world_from_imu`. The world of KITTI moves: t-1 may show things elsewhere.

    Args:
        folder: where it lies.
        layout: one of `LAYOUTS`; found out without.
        raw_folder: where the raw recordings lie, if not in `folder` too.
        split: `train` or `val`, of the depth benchmark; both without.
        split_file: a file that names the frames, as BTS or monodepth2 have it.
        depth: `groundtruth` or `velodyne_raw`, pictures of the depth benchmark, or `lidar`, the
            scan projected here; without, the first of these that the layout can have.
        variant: of `lidar.VARIANTS`, how scans are projected.
        intrinsics: K (3, 3) for layouts that state none, whose samples otherwise have NaN.
        transform: a callable from Sample to Sample, or several, applied in turn.

    Raises:
        DatasetError: nothing of KITTI there, or something was asked for that it has not.
    """

    def __init__(
        self,
        folder: Path,
        *,
        layout: str | None = None,
        raw_folder: Path | None = None,
        split: str | None = None,
        split_file: Path | None = None,
        depth: str | None = None,
        variant: str = VARIANTS[0],
        intrinsics: np.ndarray | None = None,
        transform: Transform | Iterable[Transform] | None = None,
    ):
        self.folder = Path(folder)
        self.layout = layout or detect_layout(self.folder)
        _check("layout", self.layout, tuple(LAYOUTS))
        known = LAYOUTS[self.layout]
        self.depth = depth or known.depths[0]
        _check(f"depth of layout {self.layout}", self.depth, known.depths)
        _check("variant", variant, VARIANTS)
        if split is not None:
            _check(
                f"split of layout {self.layout}", split, SPLITS if self.layout == "depth" else ()
            )
        place = Place(
            folder=self.folder,
            raw_folder=Path(raw_folder or folder),
            depth=self.depth,
            splits=ALL_SPLITS if split is None else (split,),
        )
        if split_file is None:
            self.frames = list(known.frames(place))
        else:
            _check("layout with a split file", self.layout, ("depth", "raw"))
            self.frames = frames_of_split(split_file, place)
        if not self.frames:
            raise DatasetError(
                f"{folder} has no frames of layout {self.layout}, depth {self.depth}"
            )
        if depth and not any(frame.depth or frame.velodyne for frame in self.frames):
            raise DatasetError(f"{folder} has no frame with depth {depth}")
        self.max_depth_m = _saturation_m(self.folder)
        self._variant, self._intrinsics = variant, intrinsics
        self._transforms = several(transform)

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, index: int) -> Sample:
        return transformed(self._transforms, self._read(self.frames[index]))

    def set_epoch(self, epoch: int) -> None:
        """Tell the transforms the number of the pass, for what they draw."""
        set_epoch_of(self._transforms, epoch)

    def _read(self, frame: Frame) -> Sample:
        rgb = read_picture(frame.image)
        shape = rgb.shape[:2]
        calibration = self._calibration(frame, shape)
        depth_m = self._depth(frame, calibration, shape)
        prev = None if frame.prev is None else read_picture(frame.prev)
        return Sample(
            key=frame.key,
            rgb=rgb,
            depth_m=depth_m,
            valid=depth_m > 0,
            max_depth_m=self.max_depth_m,
            intrinsics=calibration.intrinsics,
            prev=prev,
            world_from_cam=_pose(frame.oxts, calibration),
            world_from_cam_prev=None if prev is None else _pose(frame.oxts_prev, calibration),
            meta={"layout": self.layout, "depth": self._depth_name()} | frame.meta,
        )

    def _depth_name(self) -> str:
        return f"{LIDAR} {self._variant}" if self.depth == LIDAR else self.depth

    def _calibration(self, frame: Frame, shape: tuple[int, int]) -> Calibration:
        if frame.calibrate is None:
            unknown = np.full((3, 3), np.nan)
            return Calibration(intrinsics=unknown if self._intrinsics is None else self._intrinsics)
        calibration = frame.calibrate()
        if calibration.size is not None and calibration.size != shape[::-1]:
            raise DatasetError(
                f"{frame.image} is {shape[1]}x{shape[0]}, its calibration is for "
                f"{calibration.size[0]}x{calibration.size[1]}"
            )
        return calibration

    def _depth(self, frame: Frame, calibration: Calibration, shape: tuple[int, int]) -> np.ndarray:
        if self.depth in KINDS and frame.depth is not None:
            depth_m = read_depth(frame.depth)
            if depth_m.shape != shape:
                raise DatasetError(
                    f"{frame.depth} is {depth_m.shape[1]}x{depth_m.shape[0]}, its picture is "
                    f"{shape[1]}x{shape[0]}"
                )
            return depth_m
        if self.depth == LIDAR and frame.velodyne is not None:
            if calibration.cam_from_velo is None:
                raise DatasetError(f"{frame.velodyne} has no calib_velo_to_cam.txt with its date")
            return project_lidar(read_points(frame.velodyne), calibration, shape, self._variant)
        return np.zeros(shape, np.float32)


@lru_cache(maxsize=1024)
def _first_oxts(folder: Path) -> np.ndarray:
    return read_oxts(min(folder.glob("*.txt")))


def _pose(oxts: Path | None, calibration: Calibration) -> np.ndarray | None:
    if oxts is None or calibration.cam_from_imu is None:
        return None
    imu = world_from_imu(read_oxts(oxts), _first_oxts(oxts.parent))
    return imu @ np.linalg.inv(calibration.cam_from_imu)


def _saturation_m(folder: Path) -> float:
    path = folder / EXPORT_NOTE
    if not path.exists():
        return np.inf
    try:
        saturation_m = parse_json(path.read_text())["max_depth_m"]
        if saturation_m is None:
            return np.inf
        if not 0 < saturation_m < np.inf:
            raise ValueError(f"max_depth_m = {shown(saturation_m)}: allowed are positive numbers")
        return float(saturation_m)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DatasetError(f"{path} cannot be read: {error}") from None


def _check(what: str, given: str, allowed: tuple[str, ...]) -> None:
    if given not in allowed:
        raise DatasetError(f"{what} {given!r}: allowed are {', '.join(allowed) or 'none'}")
