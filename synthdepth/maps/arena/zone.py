"""What the themes of the arena's zones share: the zone's measures and paints, and its spots."""

import dataclasses

import numpy as np

from synthdepth.maps.arena.palette import Palette

OBSTACLE = "obstacle"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Zone:
    """A rectangle of the arena, in its own frame: centred on the origin, z = 0 the ground.

    Attributes:
        size_m: (2,) along x and y.
        palette: the scene's paints.
        density: how closely things stand, 1 as usual.
        height_m: of the tallest solid things.
        object_m: typical size of things.
        thin: share of thin things, 0 to 1.
        near: within reach of flights; otherwise small and thin things are left out.
    """

    size_m: np.ndarray
    palette: Palette
    density: float
    height_m: float
    object_m: float
    thin: float
    near: bool

    def spots(
        self, rng: np.random.Generator, spacing_m: float, *, shake: float = 0.5, share: float = 1.0
    ) -> np.ndarray:
        """Places (n, 2) on a shaken grid, `spacing_m` apart at density 1, half that off the edge.

        `shake` is the share of the spacing by which they move, `share` that of places kept.
        """
        spacing = spacing_m / np.sqrt(self.density)
        inner = np.maximum(self.size_m - 0.6 * spacing, 1.0)
        count = np.maximum(np.floor(inner / spacing), 1).astype(int)
        grid = [(np.arange(n) + 0.5) / n - 0.5 for n in count]
        xy = np.stack(np.meshgrid(*grid, indexing="ij"), -1).reshape(-1, 2) * inner
        xy = xy + shake * spacing * rng.uniform(-0.5, 0.5, xy.shape)
        return xy[rng.random(len(xy)) < share]


def at_ground(xy: np.ndarray, z=0.0) -> np.ndarray:
    """Points (n, 2) at heights z: (n, 3)."""
    return np.column_stack([xy, np.broadcast_to(np.asarray(z, float), len(xy))])


def square_yaws(rng: np.random.Generator, count: int, loose_share: float = 0.3) -> np.ndarray:
    """Quarter turns (count,) [rad], a share of them loosely turned."""
    yaw = np.pi / 2 * rng.integers(0, 4, count) + rng.normal(0, 0.03, count)
    return np.where(rng.random(count) < loose_share, rng.uniform(0, 2 * np.pi, count), yaw)
