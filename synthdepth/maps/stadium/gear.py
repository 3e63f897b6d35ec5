"""Training gear: cones, slalom poles, dummies, hurdles and ladders."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.bars import round_bars
from synthdepth.maps.geometry import Geometry, Model, box, copies, geometry, join, tube, yaw_matrix

_COLOURS = np.array([[0.5, 0.14, 0.01], [0.55, 0.42, 0.02], [0.05, 0.25, 0.4], [0.5, 0.5, 0.48]])


def _cone() -> Geometry:
    levels = [[0, 0, 0.0], [0, 0, 0.02], [0, 0, 0.02001], [0, 0, 0.3]]
    return tube(levels, [0.14, 0.14, 0.1, 0.02], 8)


def _disc() -> Geometry:
    return tube([[0, 0, 0.0], [0, 0, 0.05]], [0.1, 0.03], 8)


def _pole() -> Geometry:
    foot = tube([[0, 0, 0.0], [0, 0, 0.06]], [0.12, 0.08], 8, (0.15, 0.15, 0.15))
    return join([foot, tube([[0, 0, 0.0], [0, 0, 1.7]], 0.015, 6)])


def _dummy() -> Geometry:
    """A flat figure of a defender in a wall, across x."""
    outline = [[-0.2, 0.25], [0.2, 0.25], [0.27, 1.0], [0.24, 1.42], [0.1, 1.5], [0.11, 1.68],
               [0.0, 1.8], [-0.11, 1.68], [-0.1, 1.5], [-0.24, 1.42], [-0.27, 1.0]]  # fmt: skip
    ring = np.insert(np.array(outline), 0, 0.0, axis=1)
    fan = np.stack([np.zeros(9), np.arange(1, 10), np.arange(2, 11)], 1)
    stakes = round_bars(
        [[0, s * 0.15, -0.05] for s in (-1, 1)], [[0, s * 0.15, 0.3] for s in (-1, 1)], 0.012
    )
    return join([geometry(ring, fan, ring[:, 1:]), stakes])


def _hurdle() -> Geometry:
    start = [[0, -0.3, 0], [0, 0.3, 0], [0, -0.3, 0.32], [-0.15, -0.3, 0.01], [-0.15, 0.3, 0.01]]
    end = [[0, -0.3, 0.32], [0, 0.3, 0.32], [0, 0.3, 0.32], [0.15, -0.3, 0.01], [0.15, 0.3, 0.01]]
    return round_bars(start, end, 0.013, sides=5)


def _ladder() -> Geometry:
    """An agility ladder on the grass."""
    rungs = [box((0.04, 0.5, 0.01), (0.45 * k, 0, 0.012)) for k in range(9)]
    straps = [box((3.7, 0.03, 0.006), (1.8, s * 0.24, 0.014), (0.1, 0.1, 0.1)) for s in (-1, 1)]
    return join([*rungs, *straps])


GEAR: dict[str, Callable[[], Geometry]] = {
    "cone": _cone,
    "disc": _disc,
    "dummy": _dummy,
    "hurdle": _hurdle,
    "ladder": _ladder,
    "pole": _pole,
}


def gear(rng: np.random.Generator, name: str, places: np.ndarray) -> Model:
    """Training gear of one kind (a key of `GEAR`) and colour at places (k, 3), x, y and heading."""
    if name not in GEAR:
        raise KeyError(f"gear {name!r} is not one of {sorted(GEAR)}")
    places = np.asarray(places, np.float64).reshape(-1, 3)
    at = np.column_stack([places[:, :2], np.zeros(len(places))])
    tint = _COLOURS[rng.integers(len(_COLOURS))] * rng.uniform(0.85, 1.1, (len(at), 1))
    part = copies(GEAR[name](), at, rotation=yaw_matrix(places[:, 2]), tint=tint)
    return {("paint", "obstacle"): part}
