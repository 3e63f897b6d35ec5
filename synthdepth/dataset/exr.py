"""Depth as OpenEXR: one float32 channel `Z` in metres, with the conventions in the header."""

import io
import json

import numpy as np
import OpenEXR

from synthdepth.camera import Intrinsics

CONVENTION = "planar (camera z), one ray through each pixel centre"


def encode_depth(
    depth_m: np.ndarray, camera: Intrinsics, world_from_cam: np.ndarray, max_depth_m: float
) -> bytes:
    """The EXR file of a saturated planar depth image.

    Args:
        depth_m: (H, W) float32 [m], within (0, max_depth_m].
        camera: intrinsics of the frame.
        world_from_cam: (4, 4) pose, OpenCV axes.
        max_depth_m: where the depth saturates.
    """
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "depthUnit": "metre",
        "depthConvention": CONVENTION,
        "maxDepth": float(max_depth_m),
        # EXR attributes hold float32 only: exact values go in as JSON.
        "intrinsics": json.dumps(camera.matrix.tolist()),
        "worldFromCam": json.dumps(np.asarray(world_from_cam, np.float64).tolist()),
    }
    # OpenEXR writes garbage from arrays that are not contiguous.
    channels = {"Z": np.ascontiguousarray(depth_m, np.float32)}
    buffer = io.BytesIO()
    with OpenEXR.File(header, channels) as file:
        file.write(buffer)
    return buffer.getvalue()


def decode_depth(data: bytes) -> np.ndarray:
    """The depth image (H, W) float32 [m] of an EXR file that `encode_depth` made.

    Raises:
        ValueError: not an EXR file with a float32 channel `Z`.
    """
    return np.array(_channel(data, "Z"))


def depth_header(data: bytes) -> dict:
    """The header's attributes by name."""
    with OpenEXR.File(io.BytesIO(data)) as file:
        return dict(file.header())


def _channel(data: bytes, name: str) -> np.ndarray:
    try:
        with OpenEXR.File(io.BytesIO(data), separate_channels=True) as file:
            channels = {key: np.array(channel.pixels) for key, channel in file.channels().items()}
    except (RuntimeError, OSError, ValueError) as error:
        raise ValueError(f"not a readable EXR file ({error})") from error
    if name not in channels:
        raise ValueError(f"no EXR channel {name!r}, only {sorted(channels)}")
    if channels[name].dtype != np.float32:
        raise ValueError(f"EXR channel {name!r} is {channels[name].dtype}, not float32")
    return channels[name]
