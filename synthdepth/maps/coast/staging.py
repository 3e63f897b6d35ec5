"""What piers, jetties and groynes share: a line to build along, piles, cast decks."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.coast.lofts import fan, resampled, sheet
from synthdepth.maps.gardens.parts import draw_colour
from synthdepth.maps.geometry import Geometry, copies, join

BedHeight = Callable[[np.ndarray], np.ndarray]
_WET = np.array([0.33, 0.36, 0.27])  # times the dry reflectance
_TIDE_M = 0.9


class Walk:
    """Positions along a polyline: s [m] along it, w [m] to its left, z."""

    def __init__(self, line: np.ndarray):
        p = np.asarray(line, np.float64)[:, :2]
        self.length = float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum())
        # Bends are rounded a little: planks fan out round them.
        count = max(int(self.length / 2.0), 1) + 1
        self.path = resampled(p, count)
        self.s = np.linspace(0, self.length, count)
        along = np.gradient(self.path, self.s, axis=0)
        self.along = along / np.linalg.norm(along, axis=1, keepdims=True)

    def heading(self, s) -> np.ndarray:
        """Yaw [rad] of the line at s (k,)."""
        a = np.stack([np.interp(s, self.s, self.along[:, i]) for i in (0, 1)], -1)
        return np.arctan2(a[..., 1], a[..., 0])

    def at(self, s, w, z) -> np.ndarray:
        """Points (..., 3)."""
        s, w, z = np.broadcast_arrays(*(np.asarray(x, np.float64) for x in (s, w, z)))
        x, y = (np.interp(s, self.s, self.path[:, i]) for i in (0, 1))
        yaw = self.heading(s)
        return np.stack([x - w * np.sin(yaw), y + w * np.cos(yaw), z], -1)


def piles(foot: np.ndarray, head: np.ndarray, radius_m, tint, sides: int = 8) -> Geometry:
    """Round piles from `foot` to `head` (k, 3), dark and weedy up to the tide's height."""
    k = len(foot)
    level = np.array([0.0, 0.35, 0.36, 1.0])
    span = head[:, 2] - foot[:, 2]
    tide = np.clip((_TIDE_M - foot[:, 2]) / span, 0.05, 0.9)
    share = np.stack([0 * tide, tide, np.minimum(tide + 0.35 / span, 0.95), 1 + 0 * tide], 1)
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    radius = np.broadcast_to(np.asarray(radius_m, np.float64), k)
    axis = foot[:, None] + share[..., None] * (head - foot)[:, None]  # (k, 4, 3)
    ring = np.stack([np.cos(turn), np.sin(turn), 0 * turn], -1)
    v = axis[:, :, None] + radius[:, None, None, None] * ring
    shade = np.array([_WET, _WET * 1.1, [1, 1, 1], [1, 1, 1]])
    colour = (
        shade[None, :, None] * np.broadcast_to(np.asarray(tint, np.float64), (k, 3))[:, None, None]
    )
    colour = np.broadcast_to(colour, v.shape)
    n = len(level) * (sides + 1)
    unit = sheet(
        np.stack(
            [np.column_stack([np.cos(turn), np.sin(turn), np.full(sides + 1, z)]) for z in level]
        )
    )
    uv = np.zeros((*v.shape[:3], 2))
    uv[..., 0] = turn * radius[:, None, None]
    uv[..., 1] = (share * span[:, None])[:, :, None]
    faces = unit.faces[None] + n * np.arange(k, dtype=np.int32)[:, None, None]
    body = Geometry(
        v.reshape(-1, 3).astype(np.float32),
        faces.reshape(-1, 3).astype(np.int32),
        uv.reshape(-1, 2).astype(np.float32),
        colour.reshape(-1, 3).astype(np.float32),
    )
    cap = fan(ring[:-1])
    caps = copies(
        cap, head, scale=radius, tint=np.broadcast_to(np.asarray(tint, np.float64), (k, 3)) * 0.9
    )
    return join([body, caps])


def weathered_timber(rng: np.random.Generator) -> np.ndarray:
    """Sea-worn timber: silver grey to brown."""
    return draw_colour(
        rng, [(0.22, 0.195, 0.165), (0.17, 0.13, 0.095), (0.26, 0.235, 0.2), (0.13, 0.1, 0.075)]
    )


def slab(walk: Walk, s: np.ndarray, half: float, deck_m: float) -> Geometry:
    """A cast deck with kerbs and edge beams as one profile swept along s (k,)."""
    w = np.array([-1, -1, -0.94, -0.94, 0.94, 0.94, 1, 1, 0.8, 0.8, -0.8, -0.8, -1]) * half
    z = deck_m + np.array(
        [-0.3, 0.14, 0.14, 0, 0, 0.14, 0.14, -0.3, -0.3, -0.28, -0.28, -0.3, -0.3]
    )
    grid = walk.at(s[:, None], w[None], z[None])
    ends = [
        fan(walk.at(s[i], w[[0, 1, 6, 7]], z[[0, 1, 6, 7]] - [0, 0.15, 0.15, 0])) for i in (0, -1)
    ]
    return join([sheet(grid[:, ::-1]), *ends])
