"""Portable float maps (PFM) of one channel.

The format's description stores the bottom row first (http://www.pauldebevec.com/Research/HDR/PFM/);
AirSim stores the top row first and says so nowhere, so every reader must be told.
"""

import os
import re
from pathlib import Path
from typing import Literal

import numpy as np

from synthdepth.dataset.shard import write_whole
from synthdepth.errors import DatasetError

Rows = Literal["top_first", "bottom_first"]

# One white space ends the header: what follows may be data that looks like white space.
_HEADER = re.compile(
    rb"(P[Ff])\s+(\d{1,9})\s+(\d{1,9})\s+([+-]?[\d.]+(?:[eE][+-]?\d+)?)(?:\r\n|\s)"
)
_HEADER_BYTES = 128
_LARGEST_PX = 16_384


def read_pfm(path: Path, *, rows: Rows) -> np.ndarray:
    """The image of a PFM file, (H, W) float32, top row first.

    Args:
        path: the file.
        rows: which row the file stores first: "top_first" for AirSim's.

    Raises:
        DatasetError: it cannot be read, is no PFM file of one channel, or its size is not what its
            header says.
    """
    try:
        with open(path, "rb") as file:
            head = file.read(_HEADER_BYTES)
            width, height, dtype, start = _parse(path, head, os.fstat(file.fileno()).st_size)
            file.seek(start)
            values = np.frombuffer(file.read(), dtype)
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror or error}") from error
    image = values.reshape(height, width).astype(np.float32)
    return image if rows == "top_first" else np.ascontiguousarray(image[::-1])


def _parse(path: Path, head: bytes, size: int) -> tuple[int, int, str, int]:
    """Width, height, dtype and first byte of the values, checked against the file's size."""
    found = _HEADER.match(head)
    if not found:
        raise DatasetError(f"{path} is no PFM file: its header is {head[:20]!r}")
    if found[1] != b"Pf":
        raise DatasetError(f"{path} has three channels: depth has one (header Pf, not PF)")
    width, height = int(found[2]), int(found[3])
    if not (1 <= width <= _LARGEST_PX and 1 <= height <= _LARGEST_PX):
        raise DatasetError(f"{path} is {width}x{height}: allowed is up to {_LARGEST_PX} px a side")
    try:
        scale = float(found[4])
    except ValueError:
        scale = 0.0
    if abs(scale) != 1:
        raise DatasetError(f"{path} has the scale {found[4].decode()}: allowed are 1 and -1")
    expected = found.end() + 4 * width * height
    if size != expected:
        raise DatasetError(
            f"{path} has {size} bytes, not the {expected} of {width}x{height} values"
        )
    # The sign is the byte order.
    return width, height, "<f4" if scale < 0 else ">f4", found.end()


def write_pfm(path: Path, image: np.ndarray, *, rows: Rows) -> None:
    """Write an image (H, W) float32 as a little-endian PFM file.

    Args:
        path: the file.
        image: top row first.
        rows: which row the file shall store first: "top_first" for AirSim's readers.

    Raises:
        DatasetError: the disk is full or the folder cannot be written.
    """
    height, width = image.shape
    values = np.ascontiguousarray(image if rows == "top_first" else image[::-1], "<f4")
    write_whole(Path(path), f"Pf\n{width} {height}\n-1\n".encode() + values.tobytes())
