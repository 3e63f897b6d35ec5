"""KITTI's pictures: depth as 16-bit PNG, metres = value / 256, 0 where nothing was measured."""

from pathlib import Path

import cv2
import numpy as np

from synthdepth.dataset.picture import decode_picture
from synthdepth.errors import DatasetError

PER_METRE = 256
MAX_DEPTH_M = 65535 / PER_METRE


def encode_depth(depth_m: np.ndarray) -> bytes:
    """The PNG file of a depth image (H, W) [m], rounded to the nearest 1/256 m.

    What is not finite and positive, or below 1/256 m, is written as not measured; what exceeds the
    16 bits as their largest number, 255.996 m, never wrapped.
    """
    measured = np.isfinite(depth_m) & (depth_m >= 1 / PER_METRE)
    value = np.round(np.where(measured, depth_m, 0).astype(np.float64) * PER_METRE)
    return cv2.imencode(".png", np.minimum(value, 65535).astype(np.uint16))[1].tobytes()


def read_depth(path: Path) -> np.ndarray:
    """A depth image (H, W) float32 [m], 0 where nothing was measured.

    Raises:
        DatasetError: not a readable picture, or not one of 16-bit grey.
    """
    image = _read(path, cv2.IMREAD_UNCHANGED)
    if image.dtype != np.uint16 or image.ndim != 2:
        channels = 1 if image.ndim == 2 else image.shape[2]
        raise DatasetError(
            f"{path} has {channels} channel(s) of {8 * image.itemsize} bits: "
            "KITTI's depth is one channel of 16 bits"
        )
    return image.astype(np.float32) / PER_METRE


def read_picture(path: Path) -> np.ndarray:
    """A picture (H, W, 3) uint8 sRGB; DatasetError where it cannot be read."""
    return cv2.cvtColor(_read(path, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def _read(path: Path, flags: int) -> np.ndarray:
    try:
        return decode_picture(path.read_bytes(), flags)
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise DatasetError(f"{path} is no readable picture: {error}") from None
