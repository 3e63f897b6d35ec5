"""Depth, flow and normals as OpenEXR: float32 channels, with the conventions in the header."""

import contextlib
import io
import json
from collections.abc import Iterator

import numpy as np
import OpenEXR

from synthdepth.camera import Intrinsics
from synthdepth.dataset.picture import MOST_PIXELS, check_size

CONVENTION = "planar (camera z), one ray through each pixel centre"
FLOW_CONVENTION = "position at t-1 minus position at t, on the grid of t; u right, v down"
NORMAL_CONVENTION = "unit, camera axes (x right, y down, z forward), turned to the camera; sky 0"


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
        "depthUnit": "metre",
        "depthConvention": CONVENTION,
        "maxDepth": float(max_depth_m),
        # EXR attributes hold float32 only: exact values go in as JSON.
        "intrinsics": json.dumps(camera.matrix.tolist()),
        "worldFromCam": json.dumps(np.asarray(world_from_cam, np.float64).tolist()),
    }
    return encode_channels(header, {"Z": depth_m})


def encode_flow(flow: np.ndarray, visible: np.ndarray) -> bytes:
    """The EXR file of optical flow (H, W, 2) float32 [px] and its visibility (H, W) bool."""
    header = {"flowUnit": "pixel", "flowConvention": FLOW_CONVENTION}
    return encode_channels(header, {"u": flow[..., 0], "v": flow[..., 1], "visible": visible})


def encode_normal(normal: np.ndarray) -> bytes:
    """The EXR file of normals (H, W, 3) float32 in camera axes."""
    header = {"normalConvention": NORMAL_CONVENTION}
    return encode_channels(header, {name: normal[..., k] for k, name in enumerate("XYZ")})


def encode_channels(header: dict, channels: dict[str, np.ndarray]) -> bytes:
    """The EXR file of some float32 channels (H, W), with attributes in its header."""
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage} | header
    # OpenEXR writes garbage from arrays that are not contiguous.
    channels = {name: np.ascontiguousarray(values, np.float32) for name, values in channels.items()}
    buffer = io.BytesIO()
    with OpenEXR.File(header, channels) as file:
        file.write(buffer)
    return buffer.getvalue()


def decode_depth(data: bytes) -> np.ndarray:
    """The depth image (H, W) float32 [m] of an EXR file that `encode_depth` made.

    Raises:
        ValueError: not an EXR file with a float32 channel `Z`.
    """
    return _channels(data, ("Z",))[0]


def decode_flow(data: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Flow (H, W, 2) float32 [px] and visibility (H, W) bool of `encode_flow`'s file.

    Raises:
        ValueError: not an EXR file with these channels.
    """
    u, v, visible = _channels(data, ("u", "v", "visible"))
    return np.stack([u, v], axis=-1), visible > 0.5


def decode_normal(data: bytes) -> np.ndarray:
    """Normals (H, W, 3) float32 of `encode_normal`'s file; ValueError where it is none."""
    return np.stack(_channels(data, ("X", "Y", "Z")), axis=-1)


def depth_header(data: bytes) -> dict:
    """The header's attributes by name; ValueError where it is no EXR file."""
    with _opened(data, header_only=True) as file:
        return dict(file.header())


def _channels(data: bytes, names: tuple[str, ...]) -> list[np.ndarray]:
    with _opened(data, header_only=True) as file:
        _check_size(file)
    with _opened(data, separate_channels=True) as file:
        channels = {key: np.array(channel.pixels) for key, channel in file.channels().items()}
    for name in names:
        if name not in channels:
            raise ValueError(f"no EXR channel {name!r}, only {sorted(channels)}")
        if channels[name].dtype != np.float32:
            raise ValueError(f"EXR channel {name!r} is {channels[name].dtype}, not float32")
    return [channels[name] for name in names]


@contextlib.contextmanager
def _opened(data: bytes, **how) -> Iterator[OpenEXR.File]:
    try:
        with OpenEXR.File(io.BytesIO(data), **how) as file:
            yield file
    except (RuntimeError, OSError, ValueError) as error:
        raise ValueError(f"no readable EXR file ({error})") from error


def _check_size(file: OpenEXR.File) -> None:
    """Refuse what would not fit into memory before it is decoded."""
    if len(file.parts) != 1:
        raise ValueError(f"it has {len(file.parts)} parts: allowed is one")
    (left, top), (right, bottom) = (corner.tolist() for corner in file.header()["dataWindow"])
    width, height = right - left + 1, bottom - top + 1
    check_size(width, height)
    channels = file.header()["channels"]
    if width * height * len(channels) > 4 * MOST_PIXELS:
        raise ValueError(f"it has {len(channels)} channels of {width}x{height}, which is too much")
