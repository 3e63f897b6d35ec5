"""A level roof as a place to set things down on."""

import numpy as np

from synthdepth.maps.towers.panels import Panels, block, outward


class Roof:
    """A level roof with what has been set down on it so far.

    Attributes:
        z: its height [m].
        frame: number of its frame in `panels`: origin in the middle, s along the longest edge.
    """

    def __init__(self, panels: Panels, polygon: np.ndarray, z: float, taken=()) -> None:
        along = np.roll(polygon, -1, axis=0) - polygon
        k = int(np.argmax(np.linalg.norm(along, axis=1)))
        self.z, self.panels = z, panels
        self.middle = polygon.mean(axis=0)
        self.axis = along[k] / np.linalg.norm(along[k])
        self.frame = panels.add_frame(self.middle, self.axis)
        self.normal, self.foot = outward(polygon), polygon
        self.taken: list[tuple[float, float, float, float]] = []
        self.hole = None if not len(taken) else (outward(taken), taken)
        extent = np.abs(self.local(polygon)).max(axis=0)
        self.reach = extent
        self.area_m2 = 0.5 * abs(
            np.sum(polygon[:, 0] * np.roll(polygon[:, 1], -1)
                   - polygon[:, 1] * np.roll(polygon[:, 0], -1))
        )  # fmt: skip

    def local(self, xy: np.ndarray) -> np.ndarray:
        """World points (k, 2) as (s, n)."""
        d = xy - self.middle
        dx, dy = self.axis
        return np.stack([d @ self.axis, d @ np.array([dy, -dx])], axis=-1)

    def world(self, s, n, z) -> np.ndarray:
        """Points of the frame as (..., 3) world coordinates, z above the roof."""
        dx, dy = self.axis
        x, y = self.middle[0] + s * dx + n * dy, self.middle[1] + s * dy - n * dx
        out = np.empty((*np.broadcast_shapes(np.shape(x), np.shape(z)), 3))
        out[..., 0], out[..., 1], out[..., 2] = x, y, self.z + np.asarray(z)
        return out

    def spot(self, rng: np.random.Generator, size, apart_m: float = 0.5, edge_m: float = 1.1):
        """Middle (s, n) of free room for a rectangle of `size` (2,) [m], or none."""
        half = np.asarray(size) / 2
        tries = rng.uniform(-1, 1, (24, 2)) * self.reach
        corners = tries[:, None] + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        at = self.world(corners[..., 0], corners[..., 1], 0.0)[..., :2]
        inside = (_beyond(at, self.normal, self.foot) < -edge_m).all(axis=(1, 2))
        if self.hole is not None:
            # Clear of the storeys above: beyond at least one of their walls.
            inside &= (_beyond(at, *self.hole) > 0.3).all(axis=1).any(axis=1)
        if self.taken:
            low, high = np.split(np.array(self.taken), 2, axis=1)
            away = np.abs(tries[:, None] - (low + high) / 2) - half - (high - low) / 2
            inside &= (away > apart_m).any(axis=2).all(axis=1)
        if not inside.any():
            return None
        s, n = tries[np.argmax(inside)]
        self.taken.append((s - half[0], n - half[1], s + half[0], n + half[1]))
        return float(s), float(n)

    def box(self, key, tint, s, n, size, low=0.0, parts="flrtk") -> None:
        """Boxes centred on (s, n), each scalar or (k,), `size` (3,) [m], from `low` above."""
        s, n, low = np.broadcast_arrays(*(np.atleast_1d(np.asarray(a, float)) for a in (s, n, low)))
        x, y, h = size
        z = self.z + low
        made = block(s - x / 2, s + x / 2, z, z + h, n - y / 2, n + y / 2, parts)
        self.panels.add(key, tint, made, self.frame)

    def rods(self, key, tint, start, stop, radius_m: float, sides: int = 5) -> None:
        """Round rods between points (k, 3) of (s, n, z above the roof)."""
        a, b = (self.world(*np.atleast_2d(p).T) for p in (start, stop))
        self.panels.rods(key, tint, a, b, radius_m, sides)


def _beyond(at: np.ndarray, normal: np.ndarray, foot: np.ndarray) -> np.ndarray:
    """How far points (k, c, 2) lie beyond walls through `foot` (n, 2): (k, c, n) [m]."""
    return at @ normal.T - (foot * normal).sum(axis=1)
