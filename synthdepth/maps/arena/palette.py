"""Paints of the arena: a few weathered colours a scene."""

import dataclasses

import numpy as np

# Linear reflectances of weathered paints.
_PAINTS = np.array(
    [
        (0.56, 0.56, 0.54), (0.33, 0.34, 0.34), (0.16, 0.165, 0.17), (0.44, 0.37, 0.27),
        (0.46, 0.29, 0.06), (0.26, 0.065, 0.04), (0.045, 0.075, 0.17), (0.07, 0.15, 0.085),
        (0.06, 0.19, 0.2), (0.43, 0.15, 0.04), (0.2, 0.33, 0.42), (0.2, 0.12, 0.085),
        (0.035, 0.037, 0.04), (0.36, 0.13, 0.13), (0.3, 0.35, 0.24), (0.14, 0.2, 0.31),
    ]
)  # fmt: skip
_GREYS = 4  # of the first of them, some are in every scene


@dataclasses.dataclass(frozen=True, kw_only=True)
class Palette:
    """The paints of one scene.

    Attributes:
        colours: (n, 3) linear reflectances.
        weights: (n,) how often each is used.
    """

    colours: np.ndarray
    weights: np.ndarray

    def tints(self, rng: np.random.Generator, count: int) -> np.ndarray:
        """(count, 3) linear reflectances, each a little lighter or darker."""
        picked = rng.choice(len(self.colours), count, p=self.weights)
        return self.colours[picked] * rng.uniform(0.75, 1.12, (count, 1))

    def tint(self, rng: np.random.Generator) -> np.ndarray:
        """One of them (3,)."""
        return self.tints(rng, 1)[0]


def draw_palette(rng: np.random.Generator, colourfulness: float) -> Palette:
    """Greys and some colours; `colourfulness` 0 leaves greys, 1 keeps the colours as they are."""
    greys = rng.permutation(_GREYS)[:2]
    others = _GREYS + rng.permutation(len(_PAINTS) - _GREYS)[: rng.integers(4, 8)]
    colours = _PAINTS[np.concatenate([greys, others])]
    grey = colours.mean(axis=1, keepdims=True)
    weights = rng.uniform(0.4, 1.5, len(colours)) * np.r_[1.6, 1.6, np.ones(len(others))]
    return Palette(colours=grey + colourfulness * (colours - grey), weights=weights / weights.sum())
