"""Farneback's method: each neighbourhood is a quadratic polynomial, and its shift is the flow.

G. Farneback, Two-frame motion estimation based on polynomial expansion, SCIA 2003; as OpenCV has
it.
"""

import dataclasses

import cv2
import numpy as np

from synthdepth.config import Config, choice, number


@dataclasses.dataclass(frozen=True, kw_only=True)
class Farneback(Config):
    """Parameters of Farneback's method; all but the gain default to those of OpenCV's examples.

    OpenCV adds a constant to the determinant it divides by, so that where the picture is smooth or
    faint (sky, asphalt, fog) the flow is drawn to 0. Against luminance from 0 to 255 it is large:
    over flights on all maps a gain of 16 takes 40 % off the mean end-point error.

    Attributes:
        gain: luminance is multiplied by this first; 1 is plain OpenCV.
        pyramid_scale: size of a level of the pyramid against the one below.
        levels: of the pyramid above the full picture; none gets smaller than 32 px.
        window_px: side of the window over which a displacement is sought.
        iterations: at each level.
        polynomial_px: reach of the neighbourhood that a polynomial describes, OpenCV's `poly_n`.
        polynomial_sigma_px: of the Gaussian that weights it.
        window: its weights; "gaussian" is slower.
    """

    gain: float = number(16.0, 0.01, 1000.0)
    pyramid_scale: float = number(0.5, 0.1, 0.95)
    levels: int = number(3, 0, 12)
    window_px: int = number(15, 3, 255)
    iterations: int = number(3, 1, 50)
    polynomial_px: int = number(5, 3, 15)
    polynomial_sigma_px: float = number(1.2, 0.3, 5.0)
    window: str = choice("box", ("box", "gaussian"))

    def flow(self, now: np.ndarray, before: np.ndarray) -> np.ndarray:
        """(H, W, 2) float32 [px] from `now` to `before`, each (H, W) uint8."""
        return cv2.calcOpticalFlowFarneback(
            now.astype(np.float32) * np.float32(self.gain),
            before.astype(np.float32) * np.float32(self.gain),
            None,
            self.pyramid_scale,
            self.levels,
            self.window_px,
            self.iterations,
            self.polynomial_px,
            self.polynomial_sigma_px,
            cv2.OPTFLOW_FARNEBACK_GAUSSIAN if self.window == "gaussian" else 0,
        )
