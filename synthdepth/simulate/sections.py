"""The 289 sections of a depth picture (section 5.4 and figure 11 of the paper).

A section is a ninth of the picture wide and high; one begins every half section, so that 17 rows of
17 overlap by halves. All have the same area whatever the picture's size: a pixel on a border counts
with the share of it that lies inside.
"""

import numpy as np

from synthdepth.camera import Intrinsics

SECTIONS = 17  # along each side
_HALVES = SECTIONS + 1


def section_means(depth_m: np.ndarray) -> np.ndarray:
    """Mean depth of each section: its total, divided by the area that all have in common.

    Args:
        depth_m: (..., H, W) [m], finite.

    Returns:
        (..., 17, 17) float64 [m], rows from the top, columns from the left.
    """
    height, width = depth_m.shape[-2:]
    at = _summed(_summed(depth_m, -2), -1)
    total = at[..., 2:, 2:] - at[..., :-2, 2:] - at[..., 2:, :-2] + at[..., :-2, :-2]
    return total / (height * width / 9**2)


def section_minima(depth_m: np.ndarray) -> np.ndarray:
    """Least depth of each section, of all pixels that it touches.

    Args:
        depth_m: (..., H, W) [m].

    Returns:
        (..., 17, 17) of the same dtype [m].
    """
    for axis in (-2, -1):
        depth_m = np.moveaxis(depth_m, axis, -1)
        first, last = _touched(depth_m.shape[-1])
        halves = np.stack(
            [depth_m[..., a:b].min(axis=-1) for a, b in zip(first, last, strict=True)], axis=-1
        )
        depth_m = np.moveaxis(np.minimum(halves[..., :-1], halves[..., 1:]), -1, axis)
    return depth_m


def section_rays(camera: Intrinsics) -> np.ndarray:
    """Unit directions through the sections' centres, camera axes: (17, 17, 3) float64."""
    # In integer pixel coordinates the picture begins at -0.5.
    share = np.arange(1, _HALVES) / _HALVES
    x = (share * camera.width - 0.5 - camera.cx) / camera.fx
    y = (share * camera.height - 0.5 - camera.cy) / camera.fy
    rays = np.ones((SECTIONS, SECTIONS, 3))
    rays[..., 0], rays[..., 1] = x[None, :], y[:, None]
    return rays / np.linalg.norm(rays, axis=-1, keepdims=True)


def _summed(values: np.ndarray, axis: int) -> np.ndarray:
    """Sums along an axis from its start to each of the 19 borders of half sections, in float64."""
    summed = np.cumsum(values, axis=axis, dtype=np.float64)
    size = values.shape[axis]
    # Whole numbers: a border that falls between two pixels falls exactly there.
    below, rest = np.divmod(np.arange(_HALVES + 1) * size, _HALVES)
    share = (rest / _HALVES).reshape(-1, *[1] * (-1 - axis))
    low = summed.take(np.maximum(below - 1, 0), axis)
    low = np.where(below.reshape(share.shape) > 0, low, 0.0)
    # Within a pixel, which is constant, the sum is linear.
    return low + share * values.take(np.minimum(below, size - 1), axis)


def _touched(size: int) -> tuple[np.ndarray, np.ndarray]:
    """First and one past the last pixel that each half section touches: (18,) int64 each."""
    border = np.arange(_HALVES + 1) * size
    return border[:-1] // _HALVES, -(-border[1:] // _HALVES)
