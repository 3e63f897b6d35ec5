"""A scene surveyed once: how it looks from above, and where in its air a drone fits."""

import dataclasses
from collections.abc import Callable

import numpy as np
from scipy import ndimage

from synthdepth.maps.world import LABELS
from synthdepth.simulate.collision import Mesh
from synthdepth.simulate.surface import surface_points

PIXEL_M = 0.5  # of views from above
CELL_M = 1.0  # of the air
RIM = 2  # cells around the air that are never free: who steps two cells needs no look at borders
_SPACING_M = 0.5
_SKY = 255  # label of a pixel that nothing lies under


@dataclasses.dataclass(frozen=True, kw_only=True)
class TopView:
    """What lies topmost, on a grid of square pixels; rows go south from the north (+Y), columns
    east (+X).

    Attributes:
        low_m, high_m: (2,) float64 corners of what is shown [m].
        height_m: (H, W) float32 [m], of the topmost surface.
        labels: (H, W) uint8 of `LABELS`, likewise.
    """

    low_m: np.ndarray
    high_m: np.ndarray
    height_m: np.ndarray
    labels: np.ndarray


@dataclasses.dataclass(frozen=True, kw_only=True)
class Air:
    """Where a drone's centre may be, in cubes of `CELL_M`.

    Attributes:
        low_m: (3,) float64, corner of the cell (0, 0, 0) [m].
        free: (X, Y, Z) bool, cells within the altitudes whose centres are far enough from all
            surfaces to fly from one to the next.
    """

    low_m: np.ndarray
    free: np.ndarray

    def centres(self, cells: np.ndarray) -> np.ndarray:
        """Centres (n, 3) float64 [m] of cells (n, 3)."""
        return self.low_m + (np.asarray(cells) + 0.5) * CELL_M


def survey(
    mesh: Mesh,
    bounds: np.ndarray,
    ground_m: Callable[[np.ndarray], np.ndarray],
    *,
    altitude_m: tuple[float, float],
    radius_m: float,
) -> tuple[TopView, Air]:
    """Survey a scene.

    A cell of the air is free if no point of a surface is nearer to its centre than the radius and
    half a cell: a sphere that goes straight on to the next free cell then stays clear, but for the
    half metre between the points that surfaces are made of and for diagonals.

    Args:
        mesh: all that can be hit.
        bounds: (2, 2) lower and upper corner of the square to survey [m].
        ground_m: height of the ground (n,) [m] at points (n, 2) [m].
        altitude_m: (lowest, highest) above ground that drones keep to.
        radius_m: of a drone.
    """
    air = _open_air(bounds, ground_m, altitude_m)
    shape = tuple(np.round((bounds[1] - bounds[0]) / PIXEL_M).astype(int)[::-1])
    height, labels = np.full(shape, -np.inf, np.float32), np.full(shape, _SKY, np.uint8)
    low, high = (np.array([*corner, z]) for corner, z in zip(bounds, (-1e4, 1e4), strict=True))
    for points, triangle in surface_points(mesh.triangles, low, high, _SPACING_M):
        _raise(height, labels, points, mesh.labels[triangle], bounds)
        _block(air, points, radius_m + CELL_M / 2)
    _fill(height, labels)
    view = TopView(low_m=bounds[0], high_m=bounds[1], height_m=height, labels=labels)
    return view, air


def _open_air(bounds, ground_m, altitude_m) -> Air:
    """The air between two altitudes, as if there was only ground."""
    size = np.round((bounds[1] - bounds[0]) / CELL_M).astype(int)
    columns = np.stack(np.meshgrid(*(np.arange(n) for n in size), indexing="ij"), axis=-1)
    ground = ground_m(bounds[0] + (columns.reshape(-1, 2) + 0.5) * CELL_M).reshape(size)
    floor = np.floor(ground.min() + altitude_m[0])
    layers = int(np.ceil((ground.max() + altitude_m[1] - floor) / CELL_M))
    above = floor + (np.arange(layers) + 0.5) * CELL_M - ground[..., None]
    free = (above >= altitude_m[0]) & (above <= altitude_m[1])
    return Air(
        low_m=np.array([*bounds[0], floor]) - RIM * CELL_M,
        free=np.pad(free, RIM),
    )


def _raise(height, labels, points, label, bounds) -> None:
    """Lay points over what lies lower."""
    column = ((points[:, 0] - bounds[0, 0]) / PIXEL_M).astype(np.int64)
    row = ((bounds[1, 1] - points[:, 1]) / PIXEL_M).astype(np.int64)
    pixel = np.clip(row, 0, height.shape[0] - 1) * height.shape[1]
    pixel += np.clip(column, 0, height.shape[1] - 1)
    higher = np.flatnonzero(points[:, 2] > height.reshape(-1)[pixel])
    # Of values for one place the last one stays.
    higher = higher[np.argsort(points[higher, 2], kind="stable")]
    height.reshape(-1)[pixel[higher]] = points[higher, 2]
    labels.reshape(-1)[pixel[higher]] = label[higher]


def _fill(height: np.ndarray, labels: np.ndarray) -> None:
    """Give pixels between the points what the nearest pixel has; ground where there is none."""
    empty = labels == _SKY
    if empty.all():
        height[:], labels[:] = 0, LABELS["ground"]
        return
    nearest = ndimage.distance_transform_edt(empty, return_distances=False, return_indices=True)
    height[:], labels[:] = height[tuple(nearest)], labels[tuple(nearest)]


def _block(air: Air, points: np.ndarray, away_m: float) -> None:
    """Take cells out of the free ones whose centres are nearer than `away_m`, at most a cell."""
    cell = (points - air.low_m) / CELL_M - 0.5
    # Between these centres and the next ones: no other can be near enough.
    below = np.floor(cell).astype(np.int64)
    inside = np.ones(len(below), bool)
    for axis, count in enumerate(air.free.shape):
        inside &= (below[:, axis] >= 0) & (below[:, axis] < count - 1)
    below, rest = below[inside], (cell - below)[inside]
    squares = [np.square(rest), np.square(1 - rest)]
    limit, flat = (away_m / CELL_M) ** 2, air.free.reshape(-1)
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (squares[side][:, axis] for axis, side in enumerate(corner))
        near = below[x + y + z < limit] + corner
        flat[np.ravel_multi_index(near.T, air.free.shape)] = False
