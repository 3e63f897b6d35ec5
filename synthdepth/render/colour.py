"""From radiance to 8-bit sRGB: exposure, highlight shoulder, encoding."""

import numpy as np

# Where the highlights begin to roll off; below it the camera is linear.
SHOULDER = 0.6
# Weights of linear sRGB in luminance (ITU-R BT.709).
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def tone_map(radiance: np.ndarray, exposure: float) -> np.ndarray:
    """Display-linear image in [0, 1] from radiance (..., 3) and an exposure factor.

    Linear up to `SHOULDER`, then a tanh roll-off that reaches 1 smoothly, like the shoulder of a
    camera's response. Negative radiance (rounding of the sRGB primaries) is clamped.
    """
    x = np.maximum(radiance * np.float32(exposure), 0)
    room = np.float32(1 - SHOULDER)
    rolled = np.float32(SHOULDER) + room * np.tanh((x - np.float32(SHOULDER)) / room)
    return np.minimum(np.where(x < SHOULDER, x, rolled), 1)


def linear_to_srgb(linear: np.ndarray) -> np.ndarray:
    """sRGB-encoded values in [0, 1] of linear ones (IEC 61966-2-1)."""
    return np.where(
        linear <= 0.0031308, 12.92 * linear, 1.055 * np.maximum(linear, 1e-8) ** (1 / 2.4) - 0.055
    )


def to_uint8(radiance: np.ndarray, exposure: float) -> np.ndarray:
    """8-bit sRGB image (H, W, 3) uint8 of a radiance image (H, W, 3)."""
    return (linear_to_srgb(tone_map(radiance, exposure)) * 255 + 0.5).astype(np.uint8)
