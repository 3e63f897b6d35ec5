"""What sports grounds are made of: turf, courts, running tracks, boards and sheeting."""

import itertools
from collections.abc import Callable

import numpy as np

from synthdepth.maps.materials.textures import (
    blend,
    encode,
    encode_neutral,
    encode_with_mean,
    fractal_noise,
    smoothstep,
    worley,
)
from synthdepth.maps.world import Material

Rng = np.random.Generator


def _turf_field(rng: Rng, shape: tuple[int, int], straw_from: float) -> np.ndarray:
    """Linear colours (h, w, 3) of close-mown turf, 8 m a tile."""
    turn = rng.uniform(0, np.pi)
    blades = [
        fractal_noise(rng, shape, (90, 320), 0.1, (1, 3), turn + k * np.pi / 3) for k in range(3)
    ]
    blade = np.maximum(np.maximum(blades[0], blades[1]), blades[2]) - np.float32(0.85)
    tuft = fractal_noise(rng, shape, (20, 110), 0.1)
    hue = fractal_noise(rng, shape, (4, 70), 0.2)
    dry = fractal_noise(rng, shape, (6, 80), 0.1)
    straw = smoothstep(dry + 0.4 * tuft + 0.5 * blade, straw_from, 3.4)
    green = blend([0.046, 0.085, 0.024], [0.066, 0.102, 0.03], smoothstep(hue, -2.2, 2.2))
    green = blend(green, [0.13, 0.12, 0.06], 0.55 * straw)
    light = 1 + 0.18 * blade + 0.07 * tuft
    light *= 1 - 0.2 * smoothstep(tuft + 0.7 * blade, -0.8, -2.4)
    return green * light[..., None]


def _turf(rng: Rng) -> Material:
    """A mown pitch: short dense blades, few dry patches."""
    field = _turf_field(rng, (768, 768), rng.uniform(1.4, 2.4))
    return Material(texture=encode(field * np.float32(rng.uniform(0.9, 1.1))), size_m=(8.0, 8.0))


def _worn_turf(rng: Rng) -> Material:
    """A goalmouth in winter: grass in islands, trodden soil between."""
    shape = (512, 512)
    grass = _turf_field(rng, shape, 1.0)
    clod = fractal_noise(rng, shape, (8, 160), 0.2)
    bare = smoothstep(fractal_noise(rng, shape, (5, 60), 0.3) + 0.45 * clod, -0.5, 0.9)
    soil = np.float32([0.108, 0.09, 0.062]) * (1 + 0.13 * clod)[..., None]
    return Material(texture=encode(blend(grass, soil, bare)), size_m=(5.4, 5.4))


def _synthetic_turf(rng: Rng) -> Material:
    """Plastic grass with black rubber crumbs; its tint is near 1."""
    shape = (512, 512)
    fibre = fractal_noise(rng, shape, (60, 230), 0.1, (1, 3), rng.uniform(0, np.pi))
    crumb = smoothstep(fractal_noise(rng, shape, (70, 200), 0.0), 1.0, 2.4)
    brushed = fractal_noise(rng, shape, (2, 40), 0.3, stretch=(5, 1))
    light = 1 + 0.13 * fibre + 0.07 * brushed
    field = blend([0.038, 0.088, 0.034], [0.02, 0.022, 0.02], 0.6 * crumb) * light[..., None]
    return Material(texture=encode(field), size_m=(5.4, 5.4))


def _rubber_floor(rng: Rng) -> Material:
    """Granules bound with polyurethane, of running tracks and playgrounds; the tint colours it."""
    shape, n = (512, 512), 150
    granule = fractal_noise(rng, shape, (80, 250), 0.0)
    stain = fractal_noise(rng, shape, (2, 50), 0.4)
    seam = fractal_noise(rng, shape, (3, 40), 0.3, stretch=(7, 1))
    dirt = smoothstep(stain + 0.3 * granule, 0.8, 2.8)
    light = (1 + 0.11 * granule + 0.045 * stain + 0.03 * seam) * (1 - 0.25 * dirt)
    return Material(texture=encode_neutral(light), size_m=(n / 30.0, n / 30.0))


def _court(rng: Rng) -> Material:
    """Acrylic paint on asphalt: sanded, scuffed, with puddles and cracks; the tint colours it."""
    shape = (512, 512)
    sand = fractal_noise(rng, shape, (90, 256), 0.0)
    scuff = smoothstep(fractal_noise(rng, shape, (20, 90), 0.2, (1, 6), rng.uniform(0, 3)), 1.4, 3)
    pool = fractal_noise(rng, shape, (2, 20), 0.6)
    crack = worley(rng, shape, (2, 2), warp=0.12, warp_cycles=(3, 50)).border
    crack = smoothstep(crack, 0.006, 0.001) * smoothstep(pool, 0.0, 0.9)
    light = (1 + 0.07 * sand + 0.05 * pool + 0.12 * scuff) * (1 - 0.4 * crack)
    return Material(texture=encode_neutral(light), size_m=(6.4, 6.4))


def _clay(rng: Rng) -> Material:
    """Crushed brick, swept and scuffed."""
    shape = (512, 512)
    grain = fractal_noise(rng, shape, (80, 256), 0.0)
    sweep = fractal_noise(rng, shape, (10, 120), 0.2, stretch=(8, 1))
    slide = smoothstep(fractal_noise(rng, shape, (10, 60), 0.3, (1, 5), rng.uniform(0, 3)), 1.2, 3)
    damp = fractal_noise(rng, shape, (2, 16), 0.4)
    light = (1 + 0.08 * grain + 0.06 * sweep + 0.05 * damp) * (1 + 0.15 * slide)
    mean = rng.uniform(0.85, 1.1) * np.array([0.24, 0.105, 0.062])
    return Material(texture=encode_with_mean(light, mean), size_m=(5.4, 5.4))


def _chalk(rng: Rng) -> Material:
    """A white line sprayed on grass: blades stand through it."""
    shape = (256, 256)
    blade = fractal_noise(rng, shape, (30, 120), 0.1, (1, 2.5), rng.uniform(0, np.pi))
    worn = fractal_noise(rng, shape, (2, 24), 0.3)
    bare = smoothstep(blade + 0.8 * worn, 0.5, 2.6)
    field = blend([0.56, 0.57, 0.53], [0.09, 0.12, 0.05], 0.75 * bare)
    return Material(texture=encode(field * (1 + 0.06 * blade)[..., None]), size_m=(2.7, 2.7))


def _sheeting(rng: Rng) -> Material:
    """Profiled steel sheets: ribs every 0.2 m along u, streaks of rain; the tint colours it."""
    shape, ribs = (512, 512), 24
    u = (np.arange(shape[1], dtype=np.float32) + 0.5) / shape[1] * ribs % 1
    # A trapezoid's crest, its two flanks (one lit, one shaded) and the pan between.
    rib = 1 + 0.06 * smoothstep(np.abs(u - 0.5), 0.22, 0.12)
    flank = 0.22 * smoothstep(np.abs(u - 0.3), 0.09, 0.03) - 0.3 * smoothstep(
        np.abs(u - 0.7), 0.09, 0.03
    )
    sheet = np.repeat(1 + 0.03 * rng.standard_normal(ribs // 4, np.float32), 4)
    number = (np.arange(shape[1]) * ribs // shape[1]).astype(int)
    streak = fractal_noise(rng, shape, (2, 60), 0.4, stretch=(1, 9))
    dirt = smoothstep(streak + fractal_noise(rng, shape, (1, 30), 0.6), 0.8, 3.2)
    light = (rib + flank)[None] * sheet[number][None] * (1 + 0.035 * streak) * (1 - 0.3 * dirt)
    return Material(texture=encode_neutral(light), size_m=(4.8, 4.8))


# Strokes of capital letters in a unit square (x0, y0, x1, y1), y up.
_GLYPHS = (
    ((0, 0, 0.5, 1), (0.5, 1, 1, 0), (0.2, 0.4, 0.8, 0.4)),
    ((0, 0, 0, 1), (0, 1, 0.9, 1), (0, 0.5, 0.7, 0.5), (0, 0, 0.9, 0)),
    ((0, 0, 0, 1), (0, 1, 0.9, 1), (0, 0.5, 0.7, 0.5)),
    ((0, 0, 0, 1), (1, 0, 1, 1), (0, 0.5, 1, 0.5)),
    ((0.5, 0, 0.5, 1),),
    ((0, 0, 0, 1), (0, 0.45, 0.9, 1), (0.2, 0.5, 0.95, 0)),
    ((0, 0, 0, 1), (0, 0, 0.85, 0)),
    ((0, 0, 0, 1), (0, 1, 0.5, 0.35), (0.5, 0.35, 1, 1), (1, 1, 1, 0)),
    ((0, 0, 0, 1), (0, 1, 1, 0), (1, 0, 1, 1)),
    ((0, 0, 0, 1), (0, 1, 1, 1), (1, 1, 1, 0), (1, 0, 0, 0)),
    ((0, 0, 0, 1), (0, 1, 0.85, 1), (0.85, 1, 0.85, 0.5), (0.85, 0.5, 0, 0.5)),
    ((0, 0, 0, 1), (0, 1, 0.85, 1), (0.85, 1, 0.85, 0.5), (0.85, 0.5, 0, 0.5), (0.4, 0.5, 1, 0)),
    ((1, 1, 0, 1), (0, 1, 0, 0.5), (0, 0.5, 1, 0.5), (1, 0.5, 1, 0), (1, 0, 0, 0)),
    ((0, 1, 1, 1), (0.5, 1, 0.5, 0)),
    ((0, 1, 0, 0), (0, 0, 1, 0), (1, 0, 1, 1)),
    ((0, 1, 0.5, 0), (0.5, 0, 1, 1)),
    ((0, 1, 1, 1), (1, 1, 0, 0), (0, 0, 1, 0)),
    ((1, 1, 0, 1), (0, 1, 0, 0), (0, 0, 1, 0)),
)
# Grounds and letters of advertisements, linear reflectances.
_AD_PAIRS = (
    ((0.6, 0.6, 0.58), (0.02, 0.03, 0.12)),
    ((0.02, 0.05, 0.2), (0.62, 0.62, 0.6)),
    ((0.3, 0.02, 0.025), (0.62, 0.6, 0.56)),
    ((0.55, 0.38, 0.03), (0.03, 0.03, 0.03)),
    ((0.025, 0.025, 0.027), (0.55, 0.4, 0.06)),
    ((0.02, 0.14, 0.06), (0.6, 0.6, 0.55)),
    ((0.6, 0.6, 0.58), (0.3, 0.02, 0.03)),
    ((0.1, 0.24, 0.4), (0.62, 0.62, 0.62)),
    ((0.45, 0.14, 0.02), (0.6, 0.58, 0.55)),
    ((0.3, 0.3, 0.29), (0.02, 0.02, 0.02)),
)
AD_ROWS, AD_HEIGHT_M, AD_LENGTH_M = 8, 0.9, 12.0


def _letters(rng: Rng, h: int, w: int) -> np.ndarray:
    """A word in block letters across (h, w) texels: 0 to 1, antialiased."""
    y, x = np.meshgrid(np.arange(h)[::-1] + 0.5, np.arange(w) + 0.5, indexing="ij")
    ink = np.zeros((h, w), np.float32)
    size = h * rng.uniform(0.4, 0.62)
    pitch = size * rng.uniform(0.85, 1.1)
    count = int(np.clip((w - 0.6 * h) // pitch, 1, rng.integers(4, 11)))
    left, low = (w - count * pitch + 0.3 * size) / 2, (h - size) / 2
    thick, slant = size * rng.uniform(0.07, 0.13), rng.choice([0.0, 0.0, 0.2])
    for k, glyph in enumerate(rng.integers(len(_GLYPHS), size=count)):
        for x0, y0, x1, y1 in _GLYPHS[glyph]:
            a = np.array([left + k * pitch + (0.62 * x0 + slant * y0) * size, low + y0 * size])
            d = np.array([(0.62 * (x1 - x0) + slant * (y1 - y0)) * size, (y1 - y0) * size])
            first, last = int(max(min(a[0], a[0] + d[0]) - size, 0)), int(a[0] + size * 1.2) + 2
            px, py = x[:, first:last] - a[0], y[:, first:last] - a[1]
            t = np.clip((px * d[0] + py * d[1]) / (d @ d), 0, 1)
            away = np.hypot(px - t * d[0], py - t * d[1])
            np.maximum(
                ink[:, first:last],
                smoothstep(away.astype(np.float32), thick + 1.2, thick - 1.2),
                out=ink[:, first:last],
            )
    return ink


def _adverts(rng: Rng) -> Material:
    """Advertising boards, `AD_ROWS` strips of `AD_HEIGHT_M`, each several boards long."""
    w, h = 768, 96
    field = np.zeros((AD_ROWS * h, w, 3), np.float32)
    for row in range(AD_ROWS):
        cuts = np.concatenate([[0], np.sort(rng.choice(np.arange(2, 7), 2, False)) * w // 8, [w]])
        for first, last in itertools.pairwise(cuts):
            ground, ink = _AD_PAIRS[rng.integers(len(_AD_PAIRS))]
            field[row * h : (row + 1) * h, first:last] = blend(
                ground, ink, _letters(rng, h, int(last - first))
            )
    weather = fractal_noise(rng, (AD_ROWS * h, w), (2, 90), 0.4)
    return Material(
        texture=encode(field * (1 + 0.045 * weather)[..., None]),
        size_m=(AD_LENGTH_M, AD_ROWS * AD_HEIGHT_M),
    )


SPORTS: dict[str, Callable[[Rng], Material]] = {
    "turf": _turf,
    "worn_turf": _worn_turf,
    "synthetic_turf": _synthetic_turf,
    "rubber_floor": _rubber_floor,
    "court": _court,
    "clay": _clay,
    "chalk": _chalk,
    "sheeting": _sheeting,
    "adverts": _adverts,
}
