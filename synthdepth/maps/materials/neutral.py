"""Neutral materials: near white, so that the geometry's tint is the reflectance.

Along u run courses of brick, laps of siding and rows of roofing; along v run grain, bark, streaks.
"""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.materials.textures import (
    blend,
    courses,
    doubled,
    encode_neutral,
    fractal_noise,
    smoothstep,
    tones,
    worley,
)
from synthdepth.maps.world import Material

Rng = np.random.Generator


def _leaf(rng: Rng) -> Material:
    """Leaves of 5-7 cm overlapping in a clump, so that one large quad reads as many leaves."""
    shape, n = (256, 256), int(rng.integers(15, 20))
    leaf = worley(rng, shape, (n, n), warp=0.25, warp_cycles=(0.3 * n, 0.9 * n))
    shades = tones(rng, n * n, 0.0, 0.05) * rng.uniform(0.6, 1.0, (n * n, 1)).astype(np.float32)
    # Darker towards the gap, where the next leaf lies above, with a pale vein here and there.
    gap = 0.5 + 0.5 * smoothstep(leaf.border, 0.0, 0.2)
    blade = 1 + 0.05 * fractal_noise(rng, shape, (15, 90), 0.2)
    relative = shades.take(leaf.index, axis=0) * (gap * blade)[..., None]
    return Material(texture=encode_neutral(relative), size_m=(1.0, 1.0))


def _bark(rng: Rng) -> Material:
    """Plates between fissures, stretched along the trunk."""
    shape = (512, 256)
    rows, columns = int(rng.integers(5, 9)), int(rng.integers(18, 28))
    plate = worley(rng, shape, (rows, columns), warp=0.13, warp_cycles=(4, 30))
    fibre = fractal_noise(rng, shape, (20, 120), 0.2, stretch=(1, 7))
    chip = fractal_noise(rng, shape, (16, 90), 0.2)
    cleft = plate.border + 0.05 * fibre + 0.04 * chip
    fissure = 0.34 + 0.66 * smoothstep(cleft, -0.02, rng.uniform(0.18, 0.34))
    moss = fractal_noise(rng, shape, (1, 8), 0.6)
    shades = tones(rng, rows * columns, 0.08, 0.02).take(plate.index, axis=0)
    relative = shades * (fissure * (1 + 0.08 * fibre + 0.05 * chip + 0.06 * moss))[..., None]
    return Material(texture=encode_neutral(relative), size_m=(1.2, 2.4), smooth=True)


def _siding(rng: Rng) -> Material:
    """Lap boards with the shadow line that each casts on the one below."""
    shape, rows = (512, 512), 16
    exposure_m = float(rng.choice([0.15, 0.165, 0.18, 0.2]))
    lap = courses(rng, shape, rows, 1, shift=rng.random(rows), irregular=0.3)
    board = 1 + 0.022 * rng.standard_normal(rows, np.float32)[lap.row]
    below_m = (1 - lap.up) * exposure_m
    shadow = 1 - 0.55 * smoothstep(below_m, 0.016, 0.009) - 0.13 * smoothstep(below_m, 0.05, 0.01)
    # The lower edge is turned to the sky and catches light, and a little dirt under it.
    edge = 1 + 0.06 * smoothstep(lap.up * exposure_m, 0.02, 0.004)
    butt = 1 - 0.3 * smoothstep(lap.side * 4.8, 0.008, 0.003)
    grain = fractal_noise(rng, shape, (12, 160), 0.2, stretch=(14, 1))
    weather = fractal_noise(rng, shape, (1, 14), 0.4)
    streak = fractal_noise(rng, shape, (3, 60), 0.3, stretch=(1, 8))
    wear = 1 + 0.012 * grain + rng.uniform(0.012, 0.035) * weather + 0.012 * streak
    relative = board * (shadow * edge) * butt * wear
    return Material(texture=encode_neutral(relative), size_m=(4.8, rows * exposure_m))


def _plaster(rng: Rng) -> Material:
    """Render with rain streaks, stains and a trowelled grain."""
    shape = (512, 512)
    stain = fractal_noise(rng, shape, (1, 50), 0.7)
    streak = fractal_noise(rng, shape, (2, 60), 0.5, stretch=(1, 7))
    trowel = fractal_noise(rng, shape, (25, 90), 0.2, stretch=(1.6, 1))
    grain = fractal_noise(rng, shape, (90, 256), 0.0)
    dirt = smoothstep(stain + 0.5 * streak, 0.6, 2.6) * rng.uniform(0.08, 0.22)
    light = 1 + 0.025 * stain + 0.025 * streak + 0.02 * trowel + 0.03 * grain
    crack = worley(rng, (256, 256), (3, 3), warp=0.12, warp_cycles=(3, 40)).border
    crack = smoothstep(doubled(crack), 0.008, 0.002) * smoothstep(stain, 0.3, 1.0)
    relative = (light * (1 - 0.2 * crack))[..., None] * blend([1, 1, 1], [0.6, 0.54, 0.46], dirt)
    return Material(texture=encode_neutral(relative), size_m=(6.0, 6.0))


def _shingle(rng: Rng) -> Material:
    """Asphalt shingles: three-tab with slots, or laminated with tabs of random width."""
    shape, rows, columns = (512, 512), 26, 12
    exposure_m, tab_m = 0.143, 0.305
    laminated = bool(rng.random() < 0.6)
    shift = rng.random(rows) if laminated else 0.5 * (np.arange(rows) % 2)
    tab = courses(rng, shape, rows, columns, shift, 0.7 if laminated else 0.02)
    shades = tones(rng, rows * columns, rng.uniform(0.09, 0.15), rng.uniform(0.01, 0.03))
    blended = fractal_noise(rng, shape, (2, 20), 0.3)
    granules = fractal_noise(rng, shape, (100, 256), 0.0)
    # Butt edges are ragged by a few millimetres.
    below_m = (1 - tab.up) * exposure_m + 0.002 * granules
    side_m = tab.side * tab_m
    if laminated:
        # Every second layer lies back in the shadow of the thicker tabs beside it.
        back = (rng.random(rows * columns) < 0.45)[tab.index]
        depth = np.where(back, 0.018, 0.009).astype(np.float32)
        slot = 1 - 0.3 * smoothstep(side_m, 0.014, 0.004) * back
        slot = slot * np.where(back, np.float32(0.86), np.float32(1))
    else:
        depth = np.float32(0.01)
        slot = 1 - 0.55 * smoothstep(side_m, 0.009, 0.004)
    shadow = 1 - 0.5 * smoothstep(below_m - depth, 0.006, 0.0)
    streak = fractal_noise(rng, shape, (2, 30), 0.5, stretch=(1, 6))
    light = slot * shadow * (1 + 0.085 * granules + 0.04 * blended + 0.035 * streak)
    relative = shades.take(tab.index, axis=0) * light[..., None]
    size_m = (columns * tab_m, rows * exposure_m)
    return Material(texture=encode_neutral(relative), size_m=size_m)


def _roof_tile(rng: Rng) -> Material:
    """Curved clay or concrete tiles: crest, trough and the scalloped shadow of the row above."""
    shape, rows, columns = (512, 512), 12, 16
    width_m, exposure_m = rng.uniform(0.22, 0.28), rng.uniform(0.3, 0.36)
    tile = courses(rng, shape, rows, columns)
    u = (np.arange(shape[1], dtype=np.float32) + 0.5) / shape[1] * columns % 1
    # A broad crest and a narrower channel: the S-profile of a pantile.
    profile = (0.5 - 0.5 * np.cos(2 * np.pi * u**0.8))[None, :]
    flank = -np.sin(2 * np.pi * u**0.8)[None, :]
    wear = fractal_noise(rng, shape, (2, 60), 0.4)
    # The edge above hangs lower at its crest, thick enough to cast a shadow of 2-4 cm.
    below_m = (1 - tile.up) * exposure_m - 0.035 * profile + 0.002 * wear
    above = below_m < 0
    shadow = 1 - 0.6 * smoothstep(below_m, 0.045, 0.015) * ~above
    relief = (0.68 + 0.32 * np.sqrt(profile)) * (1 + 0.05 * flank)
    groove = 1 - 0.35 * smoothstep(tile.side * width_m, 0.014, 0.004)
    number = (tile.index + columns * above) % (rows * columns)
    shades = tones(rng, rows * columns, rng.uniform(0.07, 0.13), rng.uniform(0.02, 0.04))
    grain = fractal_noise(rng, shape, (90, 256), 0.0)
    lichen = smoothstep(wear + 0.6 * fractal_noise(rng, shape, (20, 90)), 1.2, 2.2)
    light = shadow * relief * groove * (1 + 0.05 * wear + 0.05 * grain)
    relative = shades.take(number, axis=0) * light[..., None]
    relative = relative * blend([1, 1, 1], [0.62, 0.7, 0.68], lichen * rng.uniform(0.3, 1))
    size_m = (columns * width_m, rows * exposure_m)
    return Material(texture=encode_neutral(relative), size_m=size_m)


def _brick(rng: Rng) -> Material:
    """Stretcher bond: bricks of 225 x 75 mm with their 10 mm joints."""
    shape, rows, columns = (768, 768), 48, 16
    brick = courses(rng, shape, rows, columns, 0.5 * (np.arange(rows) % 2), 0.03)
    rough = fractal_noise(rng, shape, (60, 250), 0.2)
    up_m = np.minimum(brick.up, 1 - brick.up) * 0.075
    joint_m = np.minimum(brick.side * 0.225, up_m) + 0.0008 * rough
    mortar = smoothstep(joint_m, 0.0068, 0.0035)
    # Mortar has less of the brick's red: dark and raked in most walls, pale lime in some.
    pale = rng.random() < 0.3
    light = rng.uniform(1.6, 2.0) if pale else rng.uniform(0.5, 0.72)
    contrast = 0.04 if pale else rng.uniform(0.06, 0.12)
    shades = tones(rng, rows * columns, contrast, rng.uniform(0.02, 0.05))
    # A kiln leaves some bricks darker and bluer.
    burnt = rng.random((rows * columns, 1), np.float32) ** rng.uniform(3, 8)
    shades *= 1 - burnt * np.float32([0.42, 0.36, 0.3])
    weather = fractal_noise(rng, shape, (1, 30), 0.5)
    body = shades.take(brick.index, axis=0) * (1 + 0.05 * rough)[..., None]
    relative = blend(body, np.float32([0.84, 1.0, 1.08]) * np.float32(light), mortar)
    # The joint is raked back: its upper half lies in the shadow of the brick above.
    raked = mortar * smoothstep(brick.up, 0.07, 0.03)
    relative *= ((1 - 0.22 * raked) * (1 + 0.045 * weather))[..., None]
    return Material(texture=encode_neutral(relative), size_m=(columns * 0.225, rows * 0.075))


def _wood(rng: Rng) -> Material:
    """Vertical boards of 0.14 m with grain, knots and open gaps."""
    shape, planks = (512, 512), 16
    # Laid on its side, a wall of boards is a layout in rows; rows then run along u.
    plank = courses(rng, shape, planks, 1)
    grain = fractal_noise(rng, shape, (8, 120), 0.4, stretch=(22, 1))
    figure = fractal_noise(rng, shape, (3, 40), 0.6, stretch=(9, 1))
    knot = worley(rng, (256, 256), (planks, 5))
    kept = (rng.random(planks * 5, np.float32) < rng.uniform(0.05, 0.25))[knot.index]
    # Rings bend round a knot.
    around = doubled(np.exp(-((knot.centre / np.float32(0.25)) ** 2)) * kept)
    rings = np.sin(2 * np.pi * (plank.up * 5 + 1.1 * figure + 2.5 * around))
    shades = tones(rng, planks, rng.uniform(0.06, 0.14), 0.025).take(plank.index, axis=0)
    weather = fractal_noise(rng, shape, (1, 20), 0.6, stretch=(3, 1))
    gap_m = np.minimum(plank.up, 1 - plank.up) * 0.14
    gap = 1 - 0.62 * smoothstep(gap_m, 0.0085, 0.001) - 0.08 * smoothstep(gap_m, 0.02, 0.004)
    light = gap * (1 + 0.055 * grain + 0.035 * rings + 0.05 * weather) * (1 - 0.35 * around**3)
    relative = shades * light[..., None]
    texture = encode_neutral(np.swapaxes(relative, 0, 1)[::-1])
    return Material(texture=texture, size_m=(planks * 0.14, 3.0))


def _paint(rng: Rng) -> Material:
    """Matt paint: nearly even."""
    shape = (128, 128)
    relative = (
        1 + 0.02 * fractal_noise(rng, shape, (1, 20)) + 0.008 * fractal_noise(rng, shape, (20, 64))
    )
    return Material(texture=encode_neutral(relative), size_m=(2.0, 2.0))


def _road_paint(rng: Rng) -> Material:
    """Line paint worn through to the aggregate and crossed by hairline cracks."""
    shape = (512, 512)
    wear = fractal_noise(rng, shape, (2, 60), 0.35)
    aggregate = fractal_noise(rng, shape, (50, 220), 0.1)
    worn = smoothstep(wear + 0.55 * aggregate, rng.uniform(0.9, 1.7), 2.9)
    crack = doubled(worley(rng, (256, 256), (9, 9), warp=0.2).border)
    crack = smoothstep(crack, 0.035, 0.01) * smoothstep(wear, -0.2, 0.8)
    dirt = fractal_noise(rng, shape, (1, 8), 0.3, stretch=(1, 2))
    light = (1 + 0.035 * dirt + 0.035 * aggregate) * (1 - 0.6 * worn) * (1 - 0.35 * crack)
    return Material(texture=encode_neutral(light), size_m=(3.0, 3.0))


def _car_paint(rng: Rng) -> Material:
    """Enamel under clear coat, with a film of dust."""
    shape = (128, 128)
    relative = 1 + 0.012 * fractal_noise(rng, shape, (1, 30), 0.5)
    return Material(
        texture=encode_neutral(relative), size_m=(3.0, 3.0), kind="plastic", roughness=0.06,
        smooth=True,
    )  # fmt: skip


def _fabric(rng: Rng) -> Material:
    """Cloth: folds and a coarse weave."""
    shape = (256, 256)
    fold = fractal_noise(rng, shape, (2, 16), 0.6, stretch=(1, 2.5))
    weave = fractal_noise(rng, shape, (50, 128), 0.0)
    relative = 1 + 0.09 * fold + 0.04 * weave
    return Material(texture=encode_neutral(relative), size_m=(0.8, 0.8))


# Near white: the geometry's tint is the linear reflectance.
NEUTRAL: dict[str, Callable[[Rng], Material]] = {
    "leaf": _leaf,
    "bark": _bark,
    "siding": _siding,
    "plaster": _plaster,
    "shingle": _shingle,
    "roof_tile": _roof_tile,
    "brick": _brick,
    "wood": _wood,
    "paint": _paint,
    "road_paint": _road_paint,
    "car_paint": _car_paint,
    "fabric": _fabric,
}
