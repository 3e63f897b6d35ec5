"""A flow map inside a picture: every i-th pixel shows how far it moved, in false colour.

Flow becomes an 8-bit luminance, the luminance a heat map, and the heat map replaces the picture at
the crossings of every i-th row and column. What moved fast is near, or the camera turned.
"""

import functools

import cv2
import numpy as np

from synthdepth.errors import SynthdepthError

# The intervals that are compared; 5 is the best of them, and any other whole number works.
INTERVALS = (1, 3, 5, 7, 9)

# The displacement that is white. Of 180 pairs of all maps (256 px, 90 degrees, 10 frames a second)
# 97 % of the pixels move less; a step of 1/8 px is below the error of every method. Flow in pixels
# grows with the focal length and the time between frames, and so should this.
PX_AT_WHITE = 32.0

_SCALES = ("fixed", "frame")


def flow_luminance(
    flow: np.ndarray, *, scale: str = "fixed", px_at_white: float = PX_AT_WHITE
) -> np.ndarray:
    """Length of the flow as 8-bit luminance, rounded to the nearest step.

    Args:
        flow: (H, W, 2) float [px]; NaN counts as 0.
        scale: "fixed" means the same in every frame. "frame" gives 255 to the longest flow of this
            one: full contrast, but the same motion looks different from frame to frame.
        px_at_white: with the fixed scale, the length [px] from which on the luminance is 255. A
            step is `px_at_white / 255`.

    Returns:
        (H, W) uint8. Flow shorter than half a step is 0, which is "no flow" to `embed`: estimates
        are never exactly 0.

    Raises:
        SynthdepthError: another shape or type, or a scale that is not allowed.
    """
    _check_flow(flow)
    _check_scale(scale, px_at_white)
    length = _length(flow)
    return _luminance(length, _white(length, scale, px_at_white))


def heat_map(luminance: np.ndarray) -> np.ndarray:
    """Luminance (H, W) uint8 in false colour, (H, W, 3) uint8 RGB.

    From deep blue (0, 0, 128) at 0 by cyan, green and yellow to deep red (128, 0, 0) at 255: the
    colour map "jet".
    """
    return np.take(_jet(), luminance, axis=0)


def flow_image(
    flow: np.ndarray, *, scale: str = "fixed", px_at_white: float = PX_AT_WHITE
) -> np.ndarray:
    """The heat map of a flow (H, W, 2) [px] at every pixel: (H, W, 3) uint8 RGB, blue at rest.

    Args and errors: as `flow_luminance`.
    """
    return heat_map(flow_luminance(flow, scale=scale, px_at_white=px_at_white))


def embed(
    rgb: np.ndarray,
    flow: np.ndarray,
    interval: int = 5,
    *,
    scale: str = "fixed",
    px_at_white: float = PX_AT_WHITE,
) -> np.ndarray:
    """The picture with the heat map of its flow at every `interval`-th pixel, equation (18).

    Pixel (n, m), counted from 0, shows the heat map where n mod interval = 0, m mod interval = 0
    and the flow is not 0, that is, its luminance is not (see `flow_luminance`); elsewhere it shows
    the picture.

    Args:
        rgb: frame t, (H, W, 3) uint8.
        flow: of frame t to t-1, (H, W, 2) float [px].
        interval: [px], 1 or more; 1 shows the flow wherever there is any.
        scale, px_at_white: as `flow_luminance`.

    Returns:
        (H, W, 3) uint8 RGB, a new array.

    Raises:
        SynthdepthError: images that do not fit together, or an option that is not allowed.
    """
    _check_flow(flow)
    _check_scale(scale, px_at_white)
    size = (*flow.shape[:2], 3)
    if not isinstance(rgb, np.ndarray) or rgb.dtype != np.uint8 or rgb.shape != size:
        raise SynthdepthError(
            f"rgb is {_kind(rgb)}: allowed is {size} uint8, as the flow is {flow.shape}"
        )
    if not isinstance(interval, int | np.integer) or isinstance(interval, bool) or interval < 1:
        raise SynthdepthError(f"interval = {interval!r}: allowed is a whole number from 1")
    # Only every interval-th pixel is shown, so no other is coloured.
    shown = np.s_[::interval, ::interval]
    length = _length(flow if scale == "frame" else flow[shown])
    white = _white(length, scale, px_at_white)
    luminance = _luminance(length[shown] if scale == "frame" else length, white)
    embedded = rgb.copy()
    np.copyto(embedded[shown], heat_map(luminance), where=(luminance > 0)[..., None])
    return embedded


def flow_channels(flow: np.ndarray, *, px_at_one: float = PX_AT_WHITE) -> np.ndarray:
    """What the heat map throws away: both components with their sign, neither rounded nor clipped.

    Args:
        flow: (H, W, 2) float [px]; NaN becomes 0.
        px_at_one: the displacement [px] that becomes 1.

    Returns:
        (H, W, 2) float32.
    """
    _check_flow(flow)
    _check_scale("fixed", px_at_one)
    return np.nan_to_num(flow.astype(np.float32) / np.float32(px_at_one))


def _length(flow: np.ndarray) -> np.ndarray:
    u, v = flow[..., 0].astype(np.float32), flow[..., 1].astype(np.float32)
    return np.nan_to_num(np.sqrt(u * u + v * v))


def _white(length: np.ndarray, scale: str, px_at_white: float) -> np.float32:
    """The length that is white; where nothing moves any will do."""
    return np.float32(px_at_white if scale == "fixed" else length.max() or 1)


def _luminance(length: np.ndarray, white_px: np.float32) -> np.ndarray:
    return np.rint(np.minimum(length * (255 / white_px), 255)).astype(np.uint8)


@functools.cache
def _jet() -> np.ndarray:
    """(256, 3) uint8 RGB."""
    grey = np.arange(256, dtype=np.uint8)[:, None]
    table = cv2.cvtColor(cv2.applyColorMap(grey, cv2.COLORMAP_JET), cv2.COLOR_BGR2RGB)[:, 0]
    table.setflags(write=False)
    return table


def _check_flow(flow: np.ndarray) -> None:
    if (
        not isinstance(flow, np.ndarray)
        or flow.ndim != 3
        or flow.shape[2] != 2
        or 0 in flow.shape
        or not np.issubdtype(flow.dtype, np.floating)
    ):
        raise SynthdepthError(f"flow is {_kind(flow)}: allowed is (H, W, 2) float")


def _check_scale(scale: str, px_at_white: float) -> None:
    if scale not in _SCALES:
        raise SynthdepthError(f"scale = {scale!r}: allowed are {', '.join(_SCALES)}")
    if not 0 < px_at_white < np.inf:
        raise SynthdepthError(f"px_at_white = {px_at_white}: allowed is a number above 0")


def _kind(array) -> str:
    if not isinstance(array, np.ndarray):
        return f"a {type(array).__name__}"
    return f"{array.shape} {array.dtype}"
