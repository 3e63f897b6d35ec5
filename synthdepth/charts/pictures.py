"""Pictures of pages, inline as data URIs."""

import base64
import dataclasses
import html

import cv2
import numpy as np

# Widest a tile is stored; twice what it measures on a page, for screens with fine pixels.
TILE_PX = 320
_JPEG_QUALITY = 85


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tile:
    """One picture of a pair.

    Attributes:
        name: what stands below it.
        says: what it shows, for whoever cannot see it.
        uri: the picture itself.
        width: of the stored picture [px].
        height: of the stored picture [px].
    """

    name: str
    says: str
    uri: str
    width: int
    height: int

    def img(self) -> str:
        """The HTML element."""
        return (
            f'<img src="{self.uri}" alt="{html.escape(self.says)}" width="{self.width}" '
            f'height="{self.height}" loading="lazy" decoding="async">'
        )


def tile(
    name: str, says: str, image: np.ndarray, *, flat: bool = False, most_px: int = TILE_PX
) -> Tile:
    """A picture as a tile.

    Args:
        name, says: as `Tile` has them.
        image: (H, W, 3) uint8 RGB.
        flat: it has areas of one colour, which PNG keeps sharp and small.
        most_px: widest it is stored.
    """
    height, width = image.shape[:2]
    if width > most_px:
        height, width = round(height * most_px / width), most_px
        how = cv2.INTER_NEAREST if flat else cv2.INTER_AREA
        image = cv2.resize(image, (width, height), interpolation=how)
    suffix, kind, options = (
        (".png", "png", [cv2.IMWRITE_PNG_COMPRESSION, 9])
        if flat
        else (".jpg", "jpeg", [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])
    )
    data = cv2.imencode(suffix, cv2.cvtColor(image, cv2.COLOR_RGB2BGR), options)[1].tobytes()
    uri = f"data:image/{kind};base64,{base64.b64encode(data).decode()}"
    return Tile(name=name, says=says, uri=uri, width=width, height=height)
