"""KITTI's calibration files: raw (a file a date), object (a file a frame) and depth benchmark (K).

KITTI states a rectified camera as a 3x4 matrix P that takes points in the rectified frame of
camera 0 to pixels. Its left 3x3 is K. Its fourth column is not zero: K^-1 times it moves points
from camera 0 to the camera meant, about 6 cm for the left colour camera. That shift is part of
`cam_from_velo` and `cam_from_imu` here, so that K, depth and pose are those of one camera.

KITTI's development kit leaves open where pixels are counted from. As almost all who use it, K is
taken for pixels whose centres are integers, the first one's (0, 0), which is the contract's own
convention; the variants of `lidar` name who shifts by one.

Source: Geiger et al., Vision meets Robotics: The KITTI Dataset, IJRR 2013, eqs. (3)-(8).
"""

import dataclasses
from pathlib import Path

import numpy as np

from synthdepth.errors import DatasetError

# x forward, y left, z up (velodyne, IMU) to the camera's axes.
CAM_FROM_BODY = np.array([[0.0, -1, 0], [0, 0, -1], [1, 0, 0]])


@dataclasses.dataclass(frozen=True, kw_only=True)
class Calibration:
    """One camera of a KITTI recording.

    Attributes:
        intrinsics: K, (3, 3) float64, the first pixel's centre at (0, 0).
        size: (width, height) of its pictures [px], None where the file does not say.
        cam_from_velo: (4, 4), from the laser scanner's axes to this camera's; None if unknown.
        cam_from_imu: (4, 4), likewise from the inertial unit's.
    """

    intrinsics: np.ndarray
    size: tuple[int, int] | None = None
    cam_from_velo: np.ndarray | None = None
    cam_from_imu: np.ndarray | None = None


def read_table(path: Path) -> dict[str, np.ndarray]:
    """The numbers of a calibration file by name; lines that hold text (`calib_time`) are left out.

    Raises:
        DatasetError: there is no such file, or it is no text.
    """
    try:
        lines = path.read_text().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise DatasetError(f"{path} cannot be read: {_reason(error)}") from None
    table = {}
    for line in lines:
        # The first colon only: the time of day in `calib_time` has more of them.
        name, colon, values = line.partition(":")
        if not colon:
            continue
        try:
            table[name.strip()] = np.array([float(value) for value in values.split()])
        except ValueError:
            continue
    return table


def raw_calibration(folder: Path, camera: int) -> Calibration:
    """A camera of a raw recording.

    Args:
        folder: of the date, with `calib_cam_to_cam.txt` and, where scanner or pose are wanted,
            `calib_velo_to_cam.txt` and `calib_imu_to_velo.txt`.
        camera: 0 to 3; 2 is the left colour camera.
    """
    path = folder / "calib_cam_to_cam.txt"
    table = read_table(path)
    width, height = map(round, _values(table, f"S_rect_{camera:02d}", 2, path).tolist())
    return _calibration(
        _values(table, f"P_rect_{camera:02d}", 12, path),
        path,
        rectification=_rotation(table, "R_rect_00", path),
        cam0_from_velo=_rigid_file(folder / "calib_velo_to_cam.txt"),
        velo_from_imu=_rigid_file(folder / "calib_imu_to_velo.txt"),
        size=(width, height),
    )


def object_calibration(path: Path, camera: int = 2) -> Calibration:
    """A camera of a frame of the object benchmark, from `calib/%06d.txt`."""
    table = read_table(path)
    velo_from_imu = None
    if "Tr_imu_to_velo" in table:
        velo_from_imu = _rigid(table, "Tr_imu_to_velo", path)
    return _calibration(
        _values(table, f"P{camera}", 12, path),
        path,
        rectification=_rotation(table, "R0_rect", path),
        cam0_from_velo=_rigid(table, "Tr_velo_to_cam", path),
        velo_from_imu=velo_from_imu,
        size=None,
    )


def selection_calibration(path: Path) -> Calibration:
    """The camera of a frame of `val_selection_cropped`, whose file holds K, nine numbers."""
    try:
        values = np.array([float(value) for value in path.read_text().split()])
        intrinsics = values.reshape(3, 3)
        if not np.isfinite(values).all():
            raise ValueError("they are not finite")
        return Calibration(intrinsics=intrinsics)
    except (OSError, ValueError) as error:
        raise DatasetError(f"{path} does not hold the 9 numbers of K: {_reason(error)}") from None


def _calibration(
    projection: np.ndarray,
    path: Path,
    *,
    rectification: np.ndarray,
    cam0_from_velo: np.ndarray | None,
    velo_from_imu: np.ndarray | None,
    size: tuple[int, int] | None,
) -> Calibration:
    projection = projection.reshape(3, 4)
    intrinsics = projection[:, :3]
    cam_from_cam0 = np.eye(4)
    cam_from_cam0[:3, :3] = rectification
    try:
        cam_from_cam0[:3, 3] = np.linalg.solve(intrinsics, projection[:, 3])
    except np.linalg.LinAlgError:
        raise DatasetError(f"{path}: the projection {projection.tolist()} is no camera's") from None
    cam_from_velo = cam_from_imu = None
    if cam0_from_velo is not None:
        cam_from_velo = cam_from_cam0 @ cam0_from_velo
        if velo_from_imu is not None:
            cam_from_imu = cam_from_velo @ velo_from_imu
    return Calibration(
        intrinsics=intrinsics, size=size, cam_from_velo=cam_from_velo, cam_from_imu=cam_from_imu
    )


def _rigid_file(path: Path) -> np.ndarray | None:
    if not path.exists():
        return None
    table = read_table(path)
    moved = np.eye(4)
    moved[:3, :3], moved[:3, 3] = _rotation(table, "R", path), _values(table, "T", 3, path)
    return moved


def _rigid(table: dict, name: str, path: Path) -> np.ndarray:
    moved = np.eye(4)
    moved[:3] = _values(table, name, 12, path).reshape(3, 4)
    _check_rotation(moved[:3, :3], name, path)
    return moved


def _rotation(table: dict, name: str, path: Path) -> np.ndarray:
    rotation = _values(table, name, 9, path).reshape(3, 3)
    _check_rotation(rotation, name, path)
    return rotation


def _check_rotation(matrix: np.ndarray, name: str, path: Path) -> None:
    # Its files have six digits; what is no rotation has perhaps no inverse.
    if not np.allclose(matrix @ matrix.T, np.eye(3), atol=0.01):
        raise DatasetError(f"{path}: {name} is no rotation: {matrix.tolist()}")


def _values(table: dict, name: str, count: int, path: Path) -> np.ndarray:
    if name not in table or len(table[name]) != count:
        found = f"{len(table[name])} numbers" if name in table else "nothing"
        raise DatasetError(f"{path}: {name} needs {count} numbers, the file has {found}")
    if not np.isfinite(table[name]).all():
        raise DatasetError(f"{path}: {name} needs {count} finite numbers")
    return table[name]


def _reason(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error)
