"""Dense inverse search: patches are matched coarse to fine, then smoothed by a variational step.

T. Kroeger, R. Timofte, D. Dai, L. Van Gool, Fast optical flow using dense inverse search, ECCV
2016; as OpenCV has it.
"""

import dataclasses

import cv2
import numpy as np

from synthdepth.config import Config, choice

_PRESETS = {
    "ultrafast": cv2.DISOPTICAL_FLOW_PRESET_ULTRAFAST,
    "fast": cv2.DISOPTICAL_FLOW_PRESET_FAST,
    "medium": cv2.DISOPTICAL_FLOW_PRESET_MEDIUM,
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Dis(Config):
    """Parameters of dense inverse search.

    Attributes:
        preset: OpenCV's trade of exactness against speed.
    """

    preset: str = choice("medium", tuple(_PRESETS))

    def flow(self, now: np.ndarray, before: np.ndarray) -> np.ndarray:
        """(H, W, 2) float32 [px] from `now` to `before`, each (H, W) uint8."""
        return cv2.DISOpticalFlow_create(_PRESETS[self.preset]).calc(now, before, None)
