"""Depth images from the laser scanner: which points are seen, where, and what their depth is.

Those who made ground truth for KITTI's raw recordings did not agree; each way has a name here.
"""

from pathlib import Path

import numpy as np

from synthdepth.errors import DatasetError
from synthdepth.kitti.calibration import Calibration

# `camera_z`: depth along the camera's axis, in the pixel whose centre is nearest. What we mean.
# `monodepth2`: as its `generate_depth_map`, one pixel up and left ("as KITTI's Matlab code").
# `velodyne_x`: as its `export_gt_depth.py` made the ground truth of the Eigen split: likewise, but
#     the scanner's x for depth, which starts 0.3 m behind the camera.
VARIANTS = ("camera_z", "monodepth2", "velodyne_x")


def read_points(path: Path) -> np.ndarray:
    """A scan's points (N, 3) float64 [m] in the scanner's axes: x forward, y left, z up.

    Raises:
        DatasetError: no such file, or not made of four float32 a point.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror}") from None
    if len(data) % 16:
        raise DatasetError(f"{path} has {len(data)} bytes: allowed are 16 a point (x, y, z, r)")
    return np.frombuffer(data, "<f4").reshape(-1, 4)[:, :3].astype(np.float64)


def project_lidar(
    points: np.ndarray,
    calibration: Calibration,
    shape: tuple[int, int],
    variant: str = "camera_z",
) -> np.ndarray:
    """The depth image of a scan; where several points meet a pixel, the nearest counts.

    Points at or behind the camera are not seen, nor, in the variants of monodepth2, those with
    x < 0. (monodepth2 itself also takes the last pixel of a row and the first of the next for the
    same one; that slip, outside every crop, is not repeated.)

    Args:
        points: (N, 3) [m], the scanner's axes.
        calibration: of the camera, with `cam_from_velo`.
        shape: (height, width) of the picture.
        variant: one of `VARIANTS`.

    Returns:
        (H, W) float32 [m], 0 where there is no point.
    """
    if variant not in VARIANTS:
        raise DatasetError(f"variant {variant!r}: allowed are {', '.join(VARIANTS)}")
    height, width = shape
    if variant != "camera_z":
        points = points[points[:, 0] >= 0]
    seen = points @ calibration.cam_from_velo[:3, :3].T + calibration.cam_from_velo[:3, 3]
    points, seen = points[seen[:, 2] > 0], seen[seen[:, 2] > 0]
    u, v, w = (seen @ calibration.intrinsics.T).T
    shift = 0 if variant == "camera_z" else 1
    column, row = np.round(u / w) - shift, np.round(v / w) - shift
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    depth = points[:, 0] if variant == "velodyne_x" else seen[:, 2]
    place = (row[inside] * width + column[inside]).astype(np.int64)
    image = np.full(height * width, np.inf, np.float32)
    np.minimum.at(image, place, depth[inside].astype(np.float32))
    image[np.isinf(image)] = 0
    return image.reshape(height, width)
