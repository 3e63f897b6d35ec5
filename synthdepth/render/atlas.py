"""All textures of a world in one picture, so that all its materials can be one.

Every material that is a BSDF of its own makes the renderer's kernel larger: a suburb's two dozen
took 20 s to compile, and one that looks its texture up in an atlas takes 2 s.
"""

import dataclasses
from collections.abc import Mapping

import numpy as np

from synthdepth.maps.world import Material

_WIDTH = 2048


@dataclasses.dataclass(frozen=True)
class Atlas:
    """Textures side by side.

    Attributes:
        image: (h, w, 3) float32 linear RGB.
        tiles: (materials, 4) float32: left, top, width and height of each texture, over the size of
            the image. Each has a rim of one texel around it that continues it, so that bilinear
            look-ups tile without a seam.
        index: number of each material.
    """

    image: np.ndarray
    tiles: np.ndarray
    index: Mapping[str, int]

    def mean(self, material: str) -> np.ndarray:
        """Mean colour of a material's texture, (3,) float32 linear RGB."""
        size = np.tile(self.image.shape[1::-1], 2)
        left, top, w, h = np.round(self.tiles[self.index[material]] * size).astype(int)
        return self.image[top : top + h, left : left + w].mean(axis=(0, 1))


def srgb_to_linear(srgb: np.ndarray) -> np.ndarray:
    """Linear values (float32) of sRGB ones in 0 to 255 (IEC 61966-2-1)."""
    table = np.arange(256) / 255
    table = np.where(table <= 0.04045, table / 12.92, ((table + 0.055) / 1.055) ** 2.4)
    return table.astype(np.float32)[srgb]


def pack(materials: Mapping[str, Material]) -> Atlas:
    """The atlas of some materials: shelves of textures, the tallest first."""
    names = list(materials)
    shapes = np.array([materials[name].texture.shape[:2] for name in names]) + 2
    width = max(_WIDTH, int(shapes[:, 1].max()))
    corners = np.zeros((len(names), 2), int)
    x = y = shelf = 0
    for number in np.argsort(-shapes[:, 0], kind="stable"):
        h, w = shapes[number]
        if x + w > width:
            x, y, shelf = 0, y + shelf, 0
        corners[number] = y, x
        x, shelf = x + w, max(shelf, h)
    image = np.zeros((y + shelf, width, 3), np.float32)
    for name, (top, left) in zip(names, corners, strict=True):
        texture = srgb_to_linear(materials[name].texture)
        h, w = texture.shape[:2]
        rim = np.pad(texture, ((1, 1), (1, 1), (0, 0)), mode="wrap")
        image[top : top + h + 2, left : left + w + 2] = rim
    size = np.array(image.shape[1::-1])
    start = (corners[:, ::-1] + 1) / size
    extent = (shapes[:, ::-1] - 2) / size
    return Atlas(
        image=image,
        tiles=np.concatenate([start, extent], axis=1).astype(np.float32),
        index={name: number for number, name in enumerate(names)},
    )
