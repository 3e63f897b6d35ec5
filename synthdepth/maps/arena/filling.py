"""What fills the gaps: free places in a zone, and towers, blocks, drums and poles set there."""

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from synthdepth.maps.arena.solids import cuboids, cylinder
from synthdepth.maps.arena.yard import coated
from synthdepth.maps.arena.zone import OBSTACLE, Zone, at_ground, square_yaws
from synthdepth.maps.bars import round_bars
from synthdepth.maps.geometry import Model, copies, merge

_CELL_M = 0.75


class FreeSpace:
    """A raster of a zone's free ground: how far it is to the nearest thing or to the edge."""

    def __init__(self, model: Model, size_m: np.ndarray):
        self._half = size_m / 2
        self._shape = np.maximum((size_m / _CELL_M).astype(int), 1)
        wide = int(self._shape[1]) + 1
        taken = np.zeros(int(np.prod(self._shape + 1)), np.int64)
        for part in model.values():
            xy = part.triangles[:, :, :2]
            low = np.clip(self._cell(xy.min(axis=1)), 0, self._shape - 1)
            high = np.clip(self._cell(xy.max(axis=1)), 0, self._shape - 1) + 1
            # Rectangles as differences, which two cumulative sums fill.
            for i, j, sign in ((low, low, 1), (high, high, 1), (low, high, -1), (high, low, -1)):
                taken += sign * np.bincount(wide * i[:, 0] + j[:, 1], minlength=len(taken))
        taken = taken.reshape(self._shape + 1)
        self._free = taken.cumsum(0).cumsum(1)[:-1, :-1] == 0

    def _cell(self, xy: np.ndarray) -> np.ndarray:
        return np.floor((xy + self._half) / _CELL_M).astype(int)

    def take(self, rng: np.random.Generator, radius_m: float, share: float) -> np.ndarray:
        """Free places (n, 2) [m] for things of a radius, `share` of those found; then taken."""
        room = distance_transform_edt(np.pad(self._free, 1))[1:-1, 1:-1] * _CELL_M
        tries = int(np.prod(2 * self._half) / (3.2 * radius_m**2)) + 1
        xy = rng.uniform(-self._half, self._half, (tries, 2))
        cell = np.minimum(self._cell(xy), self._shape - 1)
        xy = xy[room[cell[:, 0], cell[:, 1]] > radius_m + _CELL_M]
        pairs = cKDTree(xy).query_pairs(2 * radius_m, output_type="ndarray")
        keep = np.ones(len(xy), bool)
        keep[pairs.max(axis=1)] = False
        xy = xy[keep & (rng.random(len(xy)) < share)]
        reach = int(radius_m / _CELL_M)
        for x, y in self._cell(xy):
            self._free[max(x - reach, 0) : x + reach + 1, max(y - reach, 0) : y + reach + 1] = False
        return xy


def filling(rng: np.random.Generator, zone: Zone, space: FreeSpace) -> Model:
    """Towers where there is much room, blocks and drums where there is less, poles between."""
    models: list[Model] = []
    more = min(zone.density, 1.5)
    for radius, share, low, high in (
        (5.0, 0.25 * more, 0.3 * zone.height_m, zone.height_m),
        (2.6, 0.22 * more, 1.0, 0.35 * zone.height_m + 1.0),
        (1.1, 0.12 * more, 0.5, 2.2),
    ):
        xy = space.take(rng, radius, share)
        n = len(xy)
        side = radius * rng.uniform(0.45, 1.3, (n, 2))
        size = np.column_stack([side, rng.uniform(low, high, n)])
        yaw, tint = square_yaws(rng, n, 0.3), zone.palette.tints(rng, n)
        models.append(
            coated(
                rng,
                lambda c, xy=xy, size=size, yaw=yaw, tint=tint: cuboids(
                    at_ground(xy[c]), size[c], yaw[c], tint[c]
                ),
                n,
            )
        )
    xy = space.take(rng, 0.7, 0.06 * more)
    n = len(xy)
    drum = cylinder(0.29, 0.88, (1.0, 1.0, 1.0), 14, 0.015)
    models.append(
        {("enamel", OBSTACLE): copies(drum, at_ground(xy), tint=zone.palette.tints(rng, n))}
    )
    xy = space.take(rng, 0.6, 0.05 * zone.thin)
    top = at_ground(xy, rng.uniform(2.0, 9.0, len(xy)))
    models.append(
        {("hazard", "pole"): round_bars(at_ground(xy, -0.05), top, 0.04, sides=6)}
        if len(xy)
        else {}
    )
    return merge(models)
