"""The methods that estimate flow, in one table, and the one function that runs them."""

import cv2
import numpy as np

from synthdepth.errors import SynthdepthError
from synthdepth.flow.dense_lucas_kanade import DenseLucasKanade
from synthdepth.flow.dis import Dis
from synthdepth.flow.farneback import Farneback
from synthdepth.flow.lucas_kanade import LucasKanade

Method = Farneback | LucasKanade | DenseLucasKanade | Dis

METHODS: dict[str, type[Method]] = {
    "farneback": Farneback,
    "lucas_kanade": LucasKanade,
    "lucas_kanade_dense": DenseLucasKanade,
    "dis": Dis,
}

# The windows and pyramids of the methods need this much.
_LEAST_SIDE_PX = 16


def estimate_flow(
    prev: np.ndarray, rgb: np.ndarray, method: str | Method = "farneback", **parameters
) -> np.ndarray:
    """Where each pixel of frame t was at t-1, minus where it is now.

    The flow is on the grid of frame t, where the depth is, as `flow.exr` has it: `prev` sampled at
    `(x + u, y + v)` shows what `rgb` shows at `(x, y)`. The number of threads changes no byte.

    Args:
        prev: frame t-1, (H, W, 3) uint8 RGB or (H, W) uint8.
        rgb: frame t, of the same size.
        method: a name in `METHODS`, or a configured method such as `Farneback(levels=5)`.
        parameters: fields of the named method; what is left out has its default.

    Returns:
        (H, W, 2) float32 [px], u right and v down. A method never says "unknown": where it finds
        nothing it gives its best guess, which without any texture is 0.

    Raises:
        SynthdepthError: an unknown method or parameter, or images that are no pair of frames.
    """
    return _configured(method, parameters).flow(*_pair(rgb, prev))


def _configured(method: str | Method, parameters: dict) -> Method:
    if isinstance(method, Method):
        if parameters:
            raise SynthdepthError(
                f"flow method {method} with {', '.join(parameters)} as well: "
                "allowed is a configured method or a name with parameters"
            )
        return method
    if not isinstance(method, str) or method not in METHODS:
        raise SynthdepthError(f"flow method {method!r}: allowed are {', '.join(METHODS)}")
    return METHODS[method].from_table(parameters, f"flow method {method}:")


def _pair(now: np.ndarray, before: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    now, before = _grey(now, "rgb"), _grey(before, "prev")
    if now.shape != before.shape:
        raise SynthdepthError(
            f"rgb has {_size(now)} pixels and prev {_size(before)}: allowed are equal sizes"
        )
    if min(now.shape) < _LEAST_SIDE_PX:
        raise SynthdepthError(
            f"frames of {_size(now)} pixels: allowed are {_LEAST_SIDE_PX} or more a side"
        )
    return now, before


def _grey(image: np.ndarray, name: str) -> np.ndarray:
    if not isinstance(image, np.ndarray):
        raise SynthdepthError(f"{name} is a {type(image).__name__}: allowed is a numpy array")
    if image.dtype != np.uint8 or image.shape[2:] not in ((), (3,)) or image.ndim < 2:
        raise SynthdepthError(
            f"{name} is {image.shape} {image.dtype}: allowed is (H, W, 3) or (H, W) uint8"
        )
    if 0 in image.shape:
        raise SynthdepthError(f"{name} is {image.shape}: allowed is an image with pixels")
    image = np.ascontiguousarray(image)
    return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)


def _size(image: np.ndarray) -> str:
    return f"{image.shape[1]} x {image.shape[0]}"
