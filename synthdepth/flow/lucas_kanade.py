"""Lucas and Kanade's method at the points of a grid, checked forth and back, and interpolated.

B. Lucas, T. Kanade, An iterative image registration technique with an application to stereo vision,
IJCAI 1981; with the pyramid of J.-Y. Bouguet (2000), as OpenCV has it.
"""

import dataclasses

import cv2
import numpy as np
from scipy import ndimage

from synthdepth.config import Config, number


@dataclasses.dataclass(frozen=True, kw_only=True)
class LucasKanade(Config):
    """Parameters of the sparse method.

    Attributes:
        grid_px: distance of the points, at most.
        window_px: side of the window that is compared.
        levels: of the pyramid, the full picture included; each halves the one below.
        iterations: at each level, at most.
        tolerance_px: an update smaller than this is the last.
        least_eigenvalue: of the window's gradients; points with less texture are left out.
        round_trip_px: a point tracked forth and back must end this close to where it began.
    """

    grid_px: float = number(8.0, 1.0, 64.0)
    window_px: int = number(15, 3, 255)
    levels: int = number(4, 1, 12)
    iterations: int = number(30, 1, 100)
    tolerance_px: float = number(0.01, 1e-6, 1.0)
    least_eigenvalue: float = number(1e-4, 0.0, 1.0)
    round_trip_px: float = number(1.0, 1e-3, 100.0)

    def flow(self, now: np.ndarray, before: np.ndarray) -> np.ndarray:
        """(H, W, 2) float32 [px] from `now` to `before`, each (H, W) uint8.

        A point that fails has the flow of the nearest that does not; between the points the flow is
        bilinear. It is 0 where all points fail.
        """
        rows, columns = (_nodes(side, self.grid_px) for side in now.shape)
        points = np.stack(np.meshgrid(columns, rows), axis=-1).astype(np.float32)
        there, found = self._track(now, before, points)
        back, returned = self._track(before, now, there)
        trip_px = np.linalg.norm(back - points, axis=-1)
        good = found & returned & (trip_px <= self.round_trip_px)
        if not good.any():
            return np.zeros((*now.shape, 2), np.float32)
        nearest = ndimage.distance_transform_edt(~good, return_distances=False, return_indices=True)
        at_nodes = (there - points)[tuple(nearest)]
        along_y = _interpolate(at_nodes, now.shape[0])
        return np.ascontiguousarray(
            _interpolate(along_y.swapaxes(0, 1), now.shape[1]).swapaxes(0, 1)
        )

    def _track(
        self, first: np.ndarray, second: np.ndarray, points: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Where points (..., 2) float32 [px] of `first` are in `second`, and whether each is."""
        found_px, status, _ = cv2.calcOpticalFlowPyrLK(
            first,
            second,
            points.reshape(-1, 1, 2),
            None,
            winSize=(self.window_px, self.window_px),
            maxLevel=self.levels - 1,
            criteria=(
                cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT,
                self.iterations,
                self.tolerance_px,
            ),
            minEigThreshold=self.least_eigenvalue,
        )
        return found_px.reshape(points.shape), status.reshape(points.shape[:-1]) > 0


def _nodes(side_px: int, step_px: float) -> np.ndarray:
    """Evenly spaced coordinates from the first pixel's centre to the last's."""
    return np.linspace(0, side_px - 1, int(np.ceil((side_px - 1) / step_px)) + 1)


def _interpolate(values: np.ndarray, side_px: int) -> np.ndarray:
    """Values (N, ...) at `_nodes`, linearly at every pixel: (side_px, ...) float32."""
    place = np.arange(side_px) * ((len(values) - 1) / (side_px - 1))
    low = np.minimum(place.astype(int), len(values) - 2)
    share = (place - low).astype(np.float32).reshape(-1, *(1,) * (values.ndim - 1))
    return (1 - share) * values[low] + share * values[low + 1]
