"""The city beyond the modelled streets: its ground, and the hills that end every view."""

import numpy as np

from synthdepth.maps.downtown.surface import DISC_M
from synthdepth.maps.geometry import Model, geometry

_TOWN_M, _EDGE_M = 2500.0, 6000.0


def surroundings(rng: np.random.Generator) -> Model:
    """Ground from the modelled disc to the horizon: roofs, yards and greens, then wooded hills."""
    n, rings = 180, 44
    reach = np.concatenate([[DISC_M - 12.0], np.geomspace(DISC_M + 40, _EDGE_M, rings - 1)])
    angle = 2 * np.pi * np.arange(n) / n
    r, a = np.meshgrid(reach, angle, indexing="ij")
    x, y = r * np.cos(a), r * np.sin(a)
    phase = rng.uniform(0, 2 * np.pi, 6)
    wave = (
        np.sin(3 * a + phase[0]) + 0.6 * np.sin(7 * a + phase[1] + r / 900)
        + 0.35 * np.sin(17 * a + phase[2]) + 0.5 * np.sin(r / 330 + 5 * np.sin(2 * a + phase[3]))
        + 0.2 * np.sin(41 * a + phase[4] + r / 140)
    )  # fmt: skip
    t = np.clip((r - 0.75 * _TOWN_M) / (4300 - 0.75 * _TOWN_M), 0, 1)
    rise = t * t * (3 - 2 * t)
    z = rise * (rng.uniform(120, 170) + 32 * wave) - 0.06
    vertices = np.stack([x, y, z], -1).reshape(-1, 3)
    ring, step = np.meshgrid(np.arange(rings - 1), np.arange(n), indexing="ij")
    i, j = (ring * n + step).ravel(), (ring * n + (step + 1) % n).ravel()
    faces = np.concatenate([np.stack([i, i + n, j + n], 1), np.stack([i, j + n, j], 1)])
    far = np.concatenate([ring.ravel(), ring.ravel()])
    town = reach[far] < _TOWN_M
    green = rng.random(len(faces)) < np.where(reach[far] < 1300, 0.15, 0.45)
    tone = rng.uniform(0.6, 1.3, len(vertices))[:, None] * np.ones(3)
    parts = {}
    for key, chosen, tint in (
        (("asphalt", "ground"), town & ~green, 1.3 * tone),
        (("grass", "ground"), town & green, np.clip(tone, 0.8, 1.2)),
        (("hill", "hill"), ~town, np.ones_like(tone)),
    ):
        used, corner = np.unique(faces[chosen], return_inverse=True)
        parts[key] = geometry(vertices[used], corner.reshape(-1, 3), tint=tint[used])
    return parts
