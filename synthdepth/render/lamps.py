"""The lamps of a world at night: every luminous surface, gathered into a few numbers a lamp.

A lamp is what shines within half a metre. How bright it is in a direction d is told by six lobes,
one per axis and sign: sum of lobe * max(0, +-d_axis). That is exact for boxes and near enough for
lanterns; what shines upwards into the lamp's own hood is left out.
"""

import dataclasses

import numpy as np

from synthdepth.maps.world import World
from synthdepth.render.atlas import Atlas
from synthdepth.render.sky import LUX

_LAMP_M = 0.5
# Below this luminance a surface glows but lights nothing: windows, signals.
LIGHTING_CDM2 = 10_000.0
# Lamps that a place may draw from: the strongest at its cell's middle.
PER_CELL = 8
_CELL_M = 12.0
_NEAR_M = 5.0


@dataclasses.dataclass(frozen=True)
class Lamps:
    """Lamps, and which of them matter where.

    Attributes:
        table: (n, 12) float32: position [m], red, green, blue, and the lobes
            +x, -x, +y, -y, +z, -z of the luminous intensity, in the sky's unit of radiance.
        corner: (2,) lower corner of the grid [m].
        cells: (nx, ny).
        candidates: (nx * ny, PER_CELL) int64 numbers of lamps.
        cumulative: (nx * ny, PER_CELL) float32, ascending to 1: how likely each is drawn.
    """

    table: np.ndarray
    corner: np.ndarray
    cells: tuple[int, int]
    candidates: np.ndarray
    cumulative: np.ndarray

    cell_m = _CELL_M

    def irradiance(self, points: np.ndarray) -> np.ndarray:
        """Unshadowed irradiance (n, 3) of level ground at points (n, 3) [m]."""
        total = np.zeros((len(points), 3))
        for lamp in self.table.astype(np.float64):
            toward = points - lamp[:3]
            square = np.maximum((toward**2).sum(axis=1), 0.25)
            d = toward / np.sqrt(square)[:, None]
            level = np.maximum(d, 0) @ lamp[6::2] + np.maximum(-d, 0) @ lamp[7::2]
            total += (level * np.maximum(-d[:, 2], 0) / square)[:, None] * lamp[3:6]
        return total


def find_lamps(world: World, atlas: Atlas) -> Lamps | None:
    """The lamps of a world; None if nothing in it gives enough light to see by."""
    shining = [
        (part, world.materials[name].luminance_cdm2 * atlas.mean(name))
        for (name, _), part in world.surfaces.items()
        if world.materials[name].luminance_cdm2 >= LIGHTING_CDM2
    ]
    if not shining:
        return None
    corners = np.concatenate([part.triangles for part, _ in shining]).astype(np.float64)
    colour = np.concatenate(
        [part.tint[part.faces[:, 0]] * luminance for part, luminance in shining]
    ).astype(np.float64)
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) / 2
    area = np.linalg.norm(cross, axis=1)
    use = (area > 0) & (cross[:, 2] < 0.7 * area)
    corners, colour, cross, area = corners[use], colour[use], cross[use], area[use]
    if not len(area):
        return None
    middle = corners.mean(axis=1)
    _, lamp = np.unique(np.floor(middle / _LAMP_M).astype(np.int64), axis=0, return_inverse=True)
    lamp = lamp.ravel()

    def summed(values):
        return np.stack([np.bincount(lamp, column) for column in values.T], axis=1)

    total = summed(area[:, None])
    position = summed(middle * area[:, None]) / total
    flux = summed(colour * area[:, None])
    hue = flux / flux.mean(axis=1, keepdims=True)
    lobes = np.stack([np.maximum(cross, 0), np.maximum(-cross, 0)], axis=-1).reshape(-1, 6)
    lobes = summed(lobes * colour.mean(axis=1, keepdims=True)) * LUX
    return _gridded(np.concatenate([position, hue, lobes], axis=1).astype(np.float32))


def _gridded(table: np.ndarray) -> Lamps:
    """The table with its grid, which reaches 60 m beyond the lamps."""
    corner = table[:, :2].min(axis=0) - 60.0
    cells = np.ceil((table[:, :2].max(axis=0) + 60.0 - corner) / _CELL_M).astype(int)
    x, y = (corner[k] + (np.arange(cells[k]) + 0.5) * _CELL_M for k in range(2))
    middle = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    reach = table[:, 6:].max(axis=1)
    count = min(PER_CELL, len(table))
    chosen = np.zeros((len(middle), PER_CELL), np.int64)
    weight = np.zeros((len(middle), PER_CELL))
    for start in range(0, len(middle), 4096):
        part = slice(start, start + 4096)
        square = ((middle[part, None] - table[None, :, :2]) ** 2).sum(axis=2)
        level = reach / (square + _NEAR_M**2)
        best = np.argpartition(-level, count - 1, axis=1)[:, :count]
        best.sort(axis=1)
        chosen[part, :count] = best
        weight[part, :count] = np.take_along_axis(level, best, axis=1)
    cumulative = np.cumsum(weight, axis=1)
    cumulative /= cumulative[:, -1:]
    cumulative[:, count - 1 :] = 1.0
    return Lamps(table, corner, (int(cells[0]), int(cells[1])), chosen, cumulative.astype("f4"))
