"""Sand, rock, water and what lies on a beach.

Sand, pebbles, rock and sea are middle grey and take their colour from the geometry's tint, so that
dry sand, wet sand and stones of one shore match: the tint is the reflectance over `COAST_MEAN`.
"""

import math
from collections.abc import Callable

import numpy as np

from synthdepth.maps.materials.textures import (
    blend,
    doubled,
    encode,
    encode_with_mean,
    fractal_noise,
    smoothstep,
    tones,
    worley,
)
from synthdepth.maps.world import Material

Rng = np.random.Generator

# Linear reflectance that the grey textures average to, with room above for pale stones and beds.
COAST_MEAN = 0.5
_GREY = (COAST_MEAN,) * 3


def _neutral(relative: np.ndarray) -> np.ndarray:
    """uint8 sRGB texture that averages to `COAST_MEAN`."""
    relative = np.atleast_3d(relative)
    if relative.shape[2] == 1:
        relative = np.broadcast_to(relative, (*relative.shape[:2], 3))
    return encode_with_mean(relative, _GREY)


def _sand(rng: Rng) -> Material:
    """Dry sand: wind ripples in patches, footprints, shell grit."""
    shape, half = (768, 768), (384, 384)
    turn = rng.uniform(-0.5, 0.5) + math.pi / 2
    ripple = fractal_noise(rng, shape, (60, 100), 0.0, (1, 5), turn)
    rippled = smoothstep(doubled(fractal_noise(rng, half, (2, 14), 0.3)), -0.4, 1.1)
    hollow = doubled(fractal_noise(rng, half, (24, 44), 0.2))
    trodden = smoothstep(doubled(fractal_noise(rng, half, (2, 20), 0.3)), -0.3, 1.0)
    # A print is dark, and the sand thrown up at its rim pale.
    print_dark = smoothstep(hollow, -1.1, -1.9) - 0.35 * smoothstep(np.abs(hollow + 0.9), 0.4, 0.1)
    grain = fractal_noise(rng, shape, (120, 380), 0.0)
    drift = doubled(fractal_noise(rng, half, (2, 60), 0.25))
    grit = smoothstep(fractal_noise(rng, shape, (60, 160), 0.3), 2.1, 2.9)
    light = 1 + 0.055 * grain + 0.06 * drift + 0.085 * ripple * rippled
    light *= 1 - 0.2 * print_dark * trodden
    light *= 1 + rng.uniform(-0.35, 0.25) * grit
    return Material(texture=_neutral(light), size_m=(15.0, 15.0), smooth=True)


def _wet_sand(rng: Rng) -> Material:
    """Sand under a film of water: smooth, with backwash rhombs and stray shells."""
    shape = (512, 512)
    drift = fractal_noise(rng, shape, (2, 50), 0.3)
    rhomb = fractal_noise(rng, shape, (14, 40), 0.1, (1, 3), 0.5) + fractal_noise(
        rng, shape, (14, 40), 0.1, (1, 3), -0.5
    )
    grain = fractal_noise(rng, shape, (60, 250), 0.0)
    shell = smoothstep(fractal_noise(rng, shape, (40, 110), 0.4), 2.5, 3.1)
    light = 1 + 0.06 * drift + 0.035 * rhomb + 0.035 * grain
    relative = blend([1, 1, 1], [1.9, 1.8, 1.7], shell) * light[..., None]
    texture = _neutral(relative)
    return Material(
        texture=texture, size_m=(12.0, 12.0), kind="plastic", roughness=0.06, smooth=True
    )


def _pebbles(rng: Rng) -> Material:
    """Shingle of 4-15 cm: rounded stones of many tones."""
    shape, n = (768, 768), int(rng.integers(50, 66))
    stone = worley(rng, shape, (n, n), warp=0.12, warp_cycles=(0.3 * n, 0.9 * n))
    shades = tones(rng, n * n, 0.24, 0.03).take(stone.index, axis=0)
    crown = 0.5 + 0.5 * smoothstep(stone.border, -0.03, 0.26) - 0.12 * stone.centre
    patch = fractal_noise(rng, shape, (2, 30), 0.2)
    grain = fractal_noise(rng, shape, (100, 300), 0.1)
    relative = shades * (crown * (1 + 0.1 * patch + 0.03 * grain))[..., None]
    return Material(texture=_neutral(relative), size_m=(6.0, 6.0))


def _rock(rng: Rng) -> Material:
    """Weathered rock: beds along u, joints across them, blocks, lichen."""
    shape, half = (768, 768), (384, 384)
    bed = fractal_noise(
        rng, shape, (4, 110), 0.35, stretch=(7, 1), angle_rad=rng.uniform(-0.2, 0.2)
    )
    block = worley(rng, half, tuple(int(x) for x in rng.integers((9, 5), (15, 9))), warp=0.16)
    chip = fractal_noise(rng, shape, (14, 220), 0.25)
    grain = fractal_noise(rng, shape, (110, 380), 0.0)
    crack = doubled(smoothstep(block.border, 0.05, 0.012))
    crack *= smoothstep(doubled(fractal_noise(rng, half, (2, 16), 0.3)), -0.9, 0.6)
    edge = doubled(smoothstep(np.abs(block.border - 0.09), 0.05, 0.01))
    face = tones(rng, int(block.index.max()) + 1, 0.1, 0.02)
    shades = np.stack([doubled(face[:, k].take(block.index)) for k in range(3)], axis=-1)
    light = 1 + 0.13 * bed + 0.11 * chip + 0.05 * grain + 0.1 * edge
    light *= 1 - 0.55 * crack
    light *= 1 - 0.28 * smoothstep(bed + 0.5 * chip, -1.0, -2.4)
    lichen = smoothstep(fractal_noise(rng, shape, (8, 120), 0.2) + 0.3 * chip, 1.4, 2.2)
    relative = shades * light[..., None]
    spots = [1.35, 1.15, 0.75] if rng.random() < 0.5 else [1.3, 1.32, 1.22]
    relative = blend(relative, np.asarray(spots, np.float32), 0.5 * lichen)
    return Material(texture=_neutral(relative), size_m=(9.6, 9.6))


def _heath(rng: Rng) -> Material:
    """Coastal grassland: wiry grass in tussocks, straw, heath and bare sandy ground."""
    shape, half = (768, 768), (384, 384)
    turn = rng.uniform(0, math.pi)
    blades = [
        fractal_noise(rng, shape, (80, 300), 0.2, (1, 4), turn + k * math.pi / 3) for k in range(3)
    ]
    blade = np.maximum(np.maximum(blades[0], blades[1]), blades[2])
    blade = (blade - np.float32(0.85)) / np.float32(0.75)
    tuft = fractal_noise(rng, shape, (16, 120), 0.1)
    drift = doubled(fractal_noise(rng, half, (4, 70), 0.1))
    heath = doubled(fractal_noise(rng, half, (4, 50), 0.2))
    bare = doubled(fractal_noise(rng, half, (4, 80), 0.2)) + 0.5 * tuft
    dry = smoothstep(1.3 * drift + 0.4 * blade + 0.3 * tuft, -1.5, 2.1)
    green = blend([0.072, 0.09, 0.037], [0.15, 0.137, 0.07], dry)
    green = blend(green, [0.068, 0.062, 0.038], 0.75 * smoothstep(heath + 0.3 * tuft, 0.4, 1.5))
    green = blend(green, [0.2, 0.17, 0.11], 0.8 * smoothstep(bare, rng.uniform(0.9, 1.6), 2.5))
    light = 1 + 0.15 * blade + 0.15 * tuft + 0.09 * drift
    light *= 1 - 0.26 * smoothstep(tuft + 0.6 * blade, -0.8, -2.4)
    green *= (light * np.float32(rng.uniform(0.85, 1.1)))[..., None]
    return Material(texture=encode(np.clip(green, 0, 1)), size_m=(9.0, 9.0), smooth=True)


def _sea(rng: Rng) -> Material:
    """Water: ripples too small for the mesh, as a faint play of its body's colour."""
    shape = (768, 768)
    turn = rng.uniform(-0.3, 0.3)
    ripple = fractal_noise(rng, shape, (24, 330), 0.25, (3, 1), turn)
    cross = fractal_noise(rng, shape, (20, 200), 0.25, (3, 1), turn + rng.uniform(0.6, 1.1))
    slick = fractal_noise(rng, shape, (1, 9), 0.3, (2, 1), turn + 0.4)
    light = np.exp(0.24 * (ripple + 0.7 * cross) * smoothstep(slick, -2.2, 0.6) + 0.08 * slick)
    return Material(
        texture=_neutral(light), size_m=(24.0, 24.0), kind="water", roughness=0.08, smooth=True
    )


def _net(rng: Rng, cells: int, width: float) -> np.ndarray:
    """Strands of foam (512, 512) between bubbles of open water, 0 to 1."""
    half = (256, 256)
    coarse = worley(rng, half, (cells, cells), warp=0.3, warp_cycles=(3, 3 * cells)).border
    fine = worley(rng, half, (3 * cells, 3 * cells), warp=0.2).border
    thick = width * (1 + 0.6 * fractal_noise(rng, half, (3, 24), 0.3))
    strand = smoothstep(coarse - thick, 0.12, -0.08)
    web = 0.6 * smoothstep(fine - 0.5 * thick, 0.2, 0.0) * smoothstep(coarse, 0.4, 0.05)
    return doubled(np.maximum(strand, web))


def _lace(rng: Rng) -> Material:
    """Nets of old foam on dark water."""
    shape = (512, 512)
    net = _net(rng, 9, 0.05)
    patch = smoothstep(fractal_noise(rng, shape, (2, 20), 0.3), -1.6, 0.6)
    churn = 1 + 0.08 * fractal_noise(rng, shape, (8, 90), 0.3)
    water = np.array([0.05, 0.068, 0.066]) * rng.uniform(0.8, 1.2)
    foam = blend(water, [0.6, 0.62, 0.62], net * (0.15 + 0.85 * patch)) * churn[..., None]
    return Material(texture=encode(np.clip(foam, 0, 1)), size_m=(10.0, 10.0), smooth=True)


def _foam(rng: Rng) -> Material:
    """Broken water: white, with holes."""
    shape = (512, 512)
    hole = smoothstep(_net(rng, 14, 0.2), 0.5, 0.0)
    churn = 1 + 0.12 * fractal_noise(rng, shape, (3, 90), 0.3)
    foam = blend([0.7, 0.71, 0.71], [0.38, 0.42, 0.42], 0.8 * hole) * churn[..., None]
    return Material(texture=encode(np.clip(foam, 0, 1)), size_m=(10.0, 10.0), smooth=True)


COAST: dict[str, Callable[[Rng], Material]] = {
    "sand": _sand,
    "wet_sand": _wet_sand,
    "pebbles": _pebbles,
    "rock": _rock,
    "heath": _heath,
    "sea": _sea,
    "lace": _lace,
    "foam": _foam,
}
