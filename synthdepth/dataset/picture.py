"""Decoding of pictures, but for those whose header announces more than fits into memory."""

import io
import struct
import warnings

import cv2
import numpy as np
from PIL import Image

# A recipe's largest picture has 8192 x 8192 pixels.
LARGEST_SIDE_PX, MOST_PIXELS = 16_384, 2**26
_PNG = b"\x89PNG\r\n\x1a\n"


def check_size(width: int, height: int) -> None:
    """Refuse a picture that is empty or too large [px], with a ValueError."""
    least, most = sorted((int(width), int(height)))
    if least < 1 or most > LARGEST_SIDE_PX or least * most > MOST_PIXELS:
        raise ValueError(
            f"it is {width}x{height}: allowed are {MOST_PIXELS} pixels, {LARGEST_SIDE_PX} a side"
        )


def decode_picture(data: bytes, flags: int) -> np.ndarray:
    """The picture of a file's bytes.

    Args:
        data: PNG, JPEG, or whatever else OpenCV reads.
        flags: of `cv2.imdecode`.

    Returns:
        (H, W) or (H, W, C), as the flags say; OpenCV's order of channels, blue first.

    Raises:
        ValueError: it cannot be read, or is too large; then nothing was allocated for it.
    """
    size = _size(data)
    if size is not None:
        check_size(*size)
    try:
        image = cv2.imdecode(np.frombuffer(data, np.uint8), flags) if data else None
    except cv2.error:
        image = None
    if image is None:
        raise ValueError("it is broken, or of no known format")
    return image


def _size(data: bytes) -> tuple[int, int] | None:
    """Width and height that a picture's header says; None where Pillow knows none."""
    if data.startswith(_PNG) and len(data) >= 24:
        return struct.unpack(">II", data[16:24])
    try:
        with warnings.catch_warnings(action="ignore"), Image.open(io.BytesIO(data)) as picture:
            return picture.size
    except Image.DecompressionBombError:
        raise ValueError(f"it is too large: allowed are {MOST_PIXELS} pixels") from None
    # Its plugins raise what they like; then OpenCV says whether it is a picture.
    except Exception:
        return None
