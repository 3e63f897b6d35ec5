"""Lucas and Kanade's method at every pixel, as its equations say, over a pyramid.

B. Lucas, T. Kanade, An iterative image registration technique with an application to stereo vision,
IJCAI 1981. Within a window B around each pixel x, find the v that minimises

    sum over d in B of (f1(x + v + d) - f0(x + d))^2                                (1)

With f1 linear the sum is least at

    v = -G^-1 b,   G = sum of grad f0 grad f0^T,   b = sum of (f1 - f0) grad f0     (3) (4) (5)

As f1 is not linear, v is updated by -G^-1 b until it changes no more, f1 taken where v points (6).
One v for a whole window would have f1 resampled for every pixel of every window. Instead each pixel
is sampled where its own v points, and f1 is linear from there: what a pixel at d then lacks for the
window's v(x), grad f0 . (v(x) - v(x + d)), is part of its difference in (5).
"""

import dataclasses

import cv2
import numpy as np
from scipy import ndimage

from synthdepth.config import Config, number


@dataclasses.dataclass(frozen=True, kw_only=True)
class DenseLucasKanade(Config):
    """Parameters of the dense method.

    Attributes:
        radius_px: of the window B, whose side is twice that and one.
        levels: of the pyramid, the full picture included; each halves the one below. 1 is the
            method without a pyramid, which finds motion of a few pixels. None is made in which two
            windows would not stand side by side: too little is left to compare, and v drifts.
        iterations: at each level, at most.
        tolerance_px: when no pixel moves more than this, a level is done.
        damping: added to the diagonal of grad f grad f^T, for f in [0, 1]: holds windows without
            texture to the mean of what was found there before.
    """

    radius_px: int = number(7, 1, 127)
    levels: int = number(5, 1, 12)
    iterations: int = number(10, 1, 200)
    tolerance_px: float = number(0.02, 1e-6, 1.0)
    damping: float = number(1e-5, 1e-9, 1.0)

    def flow(self, now: np.ndarray, before: np.ndarray) -> np.ndarray:
        """(H, W, 2) float32 [px] from `now` to `before`, each (H, W) uint8."""
        least_px = 2 * (2 * self.radius_px + 1)
        pyramid = [tuple(image.astype(np.float32) / 255 for image in (now, before))]
        while len(pyramid) < self.levels and min(pyramid[-1][0].shape) >= 2 * least_px:
            pyramid.append(tuple(cv2.pyrDown(image) for image in pyramid[-1]))
        flow = np.zeros((2, *pyramid[-1][0].shape), np.float32)
        for f0, f1 in reversed(pyramid):
            flow = self._refine(f0, f1, *_enlarged(flow, f0.shape))
        return np.ascontiguousarray(np.moveaxis(flow, 0, -1))

    def _refine(self, f0: np.ndarray, f1: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """The flow (2, H, W) at one level, from what the coarser one says."""
        fy, fx = np.gradient(f0)
        fxx, fxy, fyy = fx * fx + self.damping, fx * fy, fy * fy + self.damping
        gxx, gxy, gyy = (self._mean(term) for term in (fxx, fxy, fyy))  # (4)
        determinant = gxx * gyy - gxy * gxy
        y, x = np.indices(f0.shape, np.float32)
        bottom, right = f0.shape[0] - 1, f0.shape[1] - 1
        for _ in range(self.iterations):
            xt, yt = x + u, y + v
            df = ndimage.map_coordinates(f1, (yt, xt), order=1, mode="nearest") - f0
            # What has left the picture says nothing of where it went.
            df[(xt < 0) | (xt > right) | (yt < 0) | (yt > bottom)] = 0
            bx = self._mean(df * fx - fxx * u - fxy * v)  # (5), linear from each pixel's own v
            by = self._mean(df * fy - fxy * u - fyy * v)
            last = u, v
            u = (gxy * by - gyy * bx) / determinant  # (3)
            v = (gxy * bx - gxx * by) / determinant
            if max(np.abs(u - last[0]).max(), np.abs(v - last[1]).max()) <= self.tolerance_px:
                break
        return np.stack([u, v])

    def _mean(self, image: np.ndarray) -> np.ndarray:
        """The mean over the window; what is outside the picture counts as 0."""
        return ndimage.uniform_filter(image, 2 * self.radius_px + 1, mode="constant")


def _enlarged(flow: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """The flow (2, H, W) of a level at the size of the one below; itself where it has that size."""
    if flow.shape[1:] == shape:
        return flow
    # Pixel x of a level lies on pixel 2 x of the one below.
    place = np.indices(shape, np.float32) / 2
    return np.stack([2 * ndimage.map_coordinates(c, place, order=1, mode="nearest") for c in flow])
