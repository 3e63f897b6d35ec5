"""Guard rails on roofs, decks and walls."""

import numpy as np

from synthdepth.maps.bars import beams
from synthdepth.maps.geometry import Geometry, join


def railing(path, tint, height_m: float = 1.1, bay_m: float = 1.5) -> Geometry:
    """Posts, a handrail and two knee rails along a polyline (k, 3) [m]."""
    p = np.asarray(path, np.float64)
    leg = np.linalg.norm(np.diff(p, axis=0), axis=1)
    bays = np.maximum(np.round(leg / bay_m), 1).astype(int)
    foot = np.concatenate(
        [a + np.arange(n)[:, None] / n * (b - a) for a, b, n in zip(p, p[1:], bays, strict=False)]
        + [p[-1:]]
    )
    posts = beams(foot, foot + [0, 0, height_m], 0.04, 0.04, tint)
    levels = np.array([0.35, 0.68, 1.0]) * height_m
    lift = np.repeat(levels, len(leg))[:, None] * [0, 0, 1.0]
    bars = beams(np.tile(p[:-1], (3, 1)) + lift, np.tile(p[1:], (3, 1)) + lift, 0.04, 0.04, tint)
    return join([posts, bars])
