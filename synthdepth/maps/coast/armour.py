"""Armour of breakwaters: quarried rocks and concrete tetrapods."""

import numpy as np
from scipy.spatial import ConvexHull

from synthdepth.maps.geometry import Geometry, Model, copies, cross, geometry, join, tube
from synthdepth.maps.materials.coast import COAST_MEAN

_WET = np.array([0.34, 0.37, 0.3])  # times the dry reflectance
_TIDE_M = 0.7
_STONES = ((0.17, 0.165, 0.155), (0.22, 0.2, 0.17), (0.13, 0.13, 0.135), (0.2, 0.17, 0.15))


def _quarried(rng: np.random.Generator, points: int = 26) -> Geometry:
    """A block about 1 m across: the hull of points squeezed to a box, its faces mapped flat."""
    p = rng.normal(size=(points, 3))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    # Stone splits along planes: rounder than a box, boxier than an ellipsoid.
    p = np.sign(p) * np.abs(p) ** rng.uniform(0.55, 0.8)
    p *= rng.uniform([0.5, 0.42, 0.34], [0.66, 0.56, 0.48]) / np.abs(p).max(axis=0)
    hull = ConvexHull(p)
    tri = p[hull.simplices]
    normal = cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    inward = np.einsum("ij,ij->i", normal, hull.equations[:, :3]) < 0
    tri[inward] = tri[inward][:, ::-1]
    keep = np.linalg.norm(normal, axis=1) > 1e-3
    tri, axis = tri[keep], np.abs(normal[keep]).argmax(axis=1)
    u = np.where(axis[:, None] == 0, tri[..., 1], tri[..., 0])
    v = np.where(axis[:, None] == 2, tri[..., 1], tri[..., 2])
    uv = np.stack([u, v], -1) + rng.uniform(0, 9, 2)
    return geometry(tri.reshape(-1, 3), np.arange(3 * len(tri)), uv)


def _turned(rng: np.random.Generator, k: int) -> np.ndarray:
    """Random rotations (k, 3, 3), from unit quaternions."""
    q = rng.normal(size=(k, 4))
    w, x, y, z = (q / np.linalg.norm(q, axis=1, keepdims=True)).T
    rows = (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
    return np.stack([np.stack(row, -1) for row in rows], -2)


def _weathered(part: Geometry) -> Geometry:
    """Dark with weed below the tide's height."""
    t = np.clip((part.vertices[:, 2:] - _TIDE_M + 0.3) / 0.6, 0, 1)
    return part.tinted(_WET * (1 - t) + t)


def draw_stone(rng: np.random.Generator) -> np.ndarray:
    """Tint (3,) of a quarry's rock, for the material "rock"."""
    return np.array(_STONES[rng.integers(len(_STONES))]) * rng.uniform(0.85, 1.15) / COAST_MEAN


def rock_armour(rng: np.random.Generator, position, size_m: float, stone) -> Model:
    """Rocks of about `size_m` at `position` (k, 3) [m], turned every way, of tint `stone` (3,)."""
    at = np.asarray(position, np.float64).reshape(-1, 3)
    k, variants = len(at), 9
    pick = rng.integers(variants, size=k)
    scale = np.clip(rng.lognormal(0.08, 0.22, (k, 1)), 0.65, 1.6) * rng.uniform(0.85, 1.15, (k, 3))
    tint = stone * np.clip(rng.normal(1, 0.16, (k, 1)), 0.6, 1.4) * rng.normal(1, 0.02, (k, 3))
    turn = _turned(rng, k)
    parts = []
    for i in range(variants):
        chosen = pick == i
        parts.append(
            copies(
                _quarried(rng),
                at[chosen],
                rotation=turn[chosen],
                scale=size_m * scale[chosen],
                tint=tint[chosen],
            )
        )
    return {("rock", "obstacle"): _weathered(join(parts))}


def tetrapod_armour(rng: np.random.Generator, position, size_m: float, _stone) -> Model:
    """Cast tetrapods at about half of `position` (k, 3) [m], each leg about `size_m` long."""
    at = np.asarray(position, np.float64).reshape(-1, 3)
    at = at[rng.random(len(at)) < 0.6]
    k = len(at)
    legs = np.array([[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]]) / np.sqrt(3)
    one = join([tube([0 * d, 0.92 * d, 1.0 * d], [0.34, 0.23, 0.17], 8) for d in legs])
    tint = np.clip(rng.normal(0.95, 0.07, (k, 1)), 0.7, 1.2) * np.ones(3)
    placed = copies(one, at, rotation=_turned(rng, k), scale=np.full(k, 1.05 * size_m), tint=tint)
    return {("concrete", "obstacle"): _weathered(placed)}
