"""Colours and shapes that garden things share."""

import numpy as np

LABEL = "street_furniture"
STEEL = (0.3, 0.31, 0.31)
DARK = (0.03, 0.032, 0.034)
WHITE = (0.66, 0.66, 0.63)
TIMBER = np.array([[0.33, 0.22, 0.12], [0.24, 0.14, 0.08], [0.28, 0.255, 0.225]])


def draw_timber(rng: np.random.Generator) -> np.ndarray:
    """Colour of garden timber: raw, stained or silvered."""
    return TIMBER[rng.integers(len(TIMBER))] * rng.uniform(0.8, 1.15)


def draw_colour(rng: np.random.Generator, colours) -> np.ndarray:
    """One of the colours (n, 3), a little lighter or darker."""
    table = np.asarray(colours, np.float64)
    return table[rng.integers(len(table))] * rng.uniform(0.85, 1.12)


def circle(radius: float, z: float, sides: int) -> np.ndarray:
    """Closed polyline (sides + 1, 3) [m]."""
    turn = 2 * np.pi * np.arange(sides + 1) / sides
    return np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(sides + 1, z)])
