"""Maps from above as pictures: pale colours by what lies there, shaded by its relief."""

import cv2
import numpy as np

from synthdepth.maps.world import LABELS
from synthdepth.simulate.survey import PIXEL_M, TopView

# Pale, so that paths stand out.
_COLOURS = {
    "ground": (226, 224, 205), "road": (198, 199, 204), "pavement": (222, 219, 214),
    "building": (214, 190, 176), "roof": (205, 168, 152), "vegetation": (176, 204, 160),
    "tree_trunk": (170, 150, 120), "water": (168, 200, 222), "vehicle": (158, 160, 178),
    "person": (222, 150, 190), "pole": (120, 116, 112), "wire": (120, 116, 112),
    "barrier": (190, 178, 160), "street_furniture": (170, 165, 185), "obstacle": (200, 182, 200),
    "hill": (206, 210, 186),
}  # fmt: skip
_LIGHT = np.array([-1.0, 1.0, 1.6]) / np.linalg.norm([-1.0, 1.0, 1.6])  # from the north-west
_RISE_M = 40.0  # above the lowest ground at which a map is lightest


def map_picture(view: TopView) -> np.ndarray:
    """A view from above as a picture (H, W, 3) uint8 RGB."""
    palette = np.full((256, 3), 226, np.float32)
    for name, colour in _COLOURS.items():
        palette[LABELS[name]] = colour
    height = cv2.GaussianBlur(view.height_m, (0, 0), 0.8)
    # A sheer wall would be black or white for its pixel whatever its height.
    south, east = (np.clip(slope, -2, 2) for slope in np.gradient(height, PIXEL_M))
    normal = np.stack([-east, south, np.ones_like(east)], axis=-1)
    light = (normal @ _LIGHT) / np.linalg.norm(normal, axis=-1)
    shade = 0.55 + 0.45 * np.clip(light / _LIGHT[2], 0, 1.25)
    rise = np.clip((view.height_m - view.height_m.min()) / _RISE_M, 0, 1)
    picture = palette[view.labels] * (shade * (0.94 + 0.1 * rise))[..., None]
    return np.clip(picture, 0, 255).astype(np.uint8)
