"""Pictures of what a network does: input, truth, prediction and error side by side."""

import cv2
import numpy as np

from synthdepth.dataset.preview import colour_depth

# A relative error of this much and more is the end of the colour scale.
WORST = 0.5


def panel(
    picture: np.ndarray, truth_m: np.ndarray, prediction_m: np.ndarray, max_depth_m: float
) -> np.ndarray:
    """One pair's panel.

    Args:
        picture: (H, W, 3) float in [-1, 1], the first channels of the input.
        truth_m: (H, W) float [m].
        prediction_m: (H, W) float [m].
        max_depth_m: where depth saturates; black.

    Returns:
        (H, 4 W, 3) uint8 RGB. Near is red. The error is |prediction - truth| / truth, from black
        at 0 by red and yellow to white at 0.5 and more.
    """
    seen = np.rint(127.5 * (np.clip(picture, -1, 1) + 1)).astype(np.uint8)
    depths = [colour_depth(depth_m, max_depth_m) for depth_m in (truth_m, prediction_m)]
    return np.concatenate([seen, *depths, colour_error(truth_m, prediction_m)], axis=1)


def colour_error(truth_m: np.ndarray, prediction_m: np.ndarray) -> np.ndarray:
    """The relative error in false colour, see `panel`; black where there is no truth."""
    known = truth_m > 0
    error = np.abs(prediction_m - truth_m) / np.where(known, truth_m, 1)
    grey = np.rint(255 * np.clip(np.where(known, error, 0) / WORST, 0, 1)).astype(np.uint8)
    return cv2.cvtColor(cv2.applyColorMap(grey, cv2.COLORMAP_HOT), cv2.COLOR_BGR2RGB)
