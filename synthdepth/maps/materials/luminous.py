"""What shines at night: lamps, floodlights, signal lenses and windows of lit rooms."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.materials.textures import encode_neutral, fractal_noise
from synthdepth.maps.world import Material

Rng = np.random.Generator


def _lamp(rng: Rng) -> Material:
    """The face of a street lamp or a wall light: its tint is the lamp's colour."""
    return _diffuser(rng, 20_000.0)


def _floodlight(rng: Rng) -> Material:
    """The face of a floodlight."""
    return _diffuser(rng, 250_000.0)


def _signal(rng: Rng) -> Material:
    """Lenses of traffic lights, tail lamps and small signs."""
    return _diffuser(rng, 3_000.0)


def _diffuser(rng: Rng, luminance_cdm2: float) -> Material:
    relative = 1 + 0.03 * fractal_noise(rng, (64, 64), (1, 20))
    return Material(
        texture=encode_neutral(relative), size_m=(0.5, 0.5), luminance_cdm2=luminance_cdm2
    )


def _lit_window(rng: Rng) -> Material:
    """A pane before a lit room: curtains, shelves and lamps as soft shapes."""
    shape = (128, 128)
    room = fractal_noise(rng, shape, (1, 8), 0.4)
    fold = fractal_noise(rng, shape, (6, 30), 0.3, stretch=(1, 8))
    relative = np.exp(0.35 * room + 0.1 * fold)
    return Material(
        texture=encode_neutral(relative),
        size_m=(5.3, 4.7),
        kind="glass",
        roughness=0.02,
        luminance_cdm2=12.0,
    )


# Their luminance counts when the lamps are on; by day they are plain diffusers and panes.
LUMINOUS: dict[str, Callable[[Rng], Material]] = {
    "lamp": _lamp,
    "floodlight": _floodlight,
    "signal": _signal,
    "lit_window": _lit_window,
}
