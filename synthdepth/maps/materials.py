"""The catalogue of materials: every surface's texture, baked anew for each scene.

Neutral materials are near white and take their reflectance from the geometry's tint; coloured ones
hold it (visible linear reflectances after Oke 1987 and Taha 1992). Along u run courses of brick,
laps of siding and rows of roofing; along v run grain, bark and streaks.
"""

import math
from collections.abc import Callable

import numpy as np

from synthdepth.maps.textures import (
    blend,
    courses,
    encode,
    encode_neutral,
    encode_with_mean,
    fractal_noise,
    smoothstep,
    worley,
)
from synthdepth.maps.world import Material
from synthdepth.seeding import lane

Rng = np.random.Generator


def _doubled(field: np.ndarray) -> np.ndarray:
    """(h, w) as (2 h, 2 w), bilinear round the torus: smooth fields are made at half density."""
    for axis in (0, 1):
        before, after = np.roll(field, 1, axis), np.roll(field, -1, axis)
        pair = np.stack([0.75 * field + 0.25 * before, 0.75 * field + 0.25 * after], axis + 1)
        shape = list(field.shape)
        shape[axis] *= 2
        field = pair.reshape(shape)
    return field


def _tones(rng: Rng, count: int, contrast: float, hue: float) -> np.ndarray:
    """(count, 3) float32 multipliers of units: lightness and a warm-cool shift, log-normal."""
    light = contrast * rng.standard_normal(count, np.float32)
    warm = hue * rng.standard_normal(count, np.float32)
    return np.exp(np.stack([light + warm, light, light - 1.4 * warm], axis=-1))


# ---- neutral -------------------------------------------------------------------------------------


def _leaf(rng: Rng) -> Material:
    """Leaves of 5-7 cm overlapping in a clump, so that one large quad reads as many leaves."""
    shape, n = (256, 256), int(rng.integers(15, 20))
    leaf = worley(rng, shape, (n, n), warp=0.25, warp_cycles=(0.3 * n, 0.9 * n))
    tones = _tones(rng, n * n, 0.0, 0.05) * rng.uniform(0.6, 1.0, (n * n, 1)).astype(np.float32)
    # Darker towards the gap, where the next leaf lies above, with a pale vein here and there.
    gap = 0.5 + 0.5 * smoothstep(leaf.border, 0.0, 0.2)
    blade = 1 + 0.05 * fractal_noise(rng, shape, (15, 90), 0.2)
    relative = tones.take(leaf.index, axis=0) * (gap * blade)[..., None]
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
    tones = _tones(rng, rows * columns, 0.08, 0.02).take(plate.index, axis=0)
    relative = tones * (fissure * (1 + 0.08 * fibre + 0.05 * chip + 0.06 * moss))[..., None]
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
    crack = smoothstep(_doubled(crack), 0.008, 0.002) * smoothstep(stain, 0.3, 1.0)
    relative = (light * (1 - 0.2 * crack))[..., None] * blend([1, 1, 1], [0.6, 0.54, 0.46], dirt)
    return Material(texture=encode_neutral(relative), size_m=(6.0, 6.0))


def _shingle(rng: Rng) -> Material:
    """Asphalt shingles: three-tab with slots, or laminated with tabs of random width."""
    shape, rows, columns = (512, 512), 26, 12
    exposure_m, tab_m = 0.143, 0.305
    laminated = bool(rng.random() < 0.6)
    shift = rng.random(rows) if laminated else 0.5 * (np.arange(rows) % 2)
    tab = courses(rng, shape, rows, columns, shift, 0.7 if laminated else 0.02)
    tones = _tones(rng, rows * columns, rng.uniform(0.09, 0.15), rng.uniform(0.01, 0.03))
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
    relative = tones.take(tab.index, axis=0) * light[..., None]
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
    tones = _tones(rng, rows * columns, rng.uniform(0.07, 0.13), rng.uniform(0.02, 0.04))
    grain = fractal_noise(rng, shape, (90, 256), 0.0)
    lichen = smoothstep(wear + 0.6 * fractal_noise(rng, shape, (20, 90)), 1.2, 2.2)
    light = shadow * relief * groove * (1 + 0.05 * wear + 0.05 * grain)
    relative = tones.take(number, axis=0) * light[..., None]
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
    tones = _tones(rng, rows * columns, contrast, rng.uniform(0.02, 0.05))
    # A kiln leaves some bricks darker and bluer.
    burnt = rng.random((rows * columns, 1), np.float32) ** rng.uniform(3, 8)
    tones *= 1 - burnt * np.float32([0.42, 0.36, 0.3])
    weather = fractal_noise(rng, shape, (1, 30), 0.5)
    body = tones.take(brick.index, axis=0) * (1 + 0.05 * rough)[..., None]
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
    around = _doubled(np.exp(-((knot.centre / np.float32(0.25)) ** 2)) * kept)
    rings = np.sin(2 * np.pi * (plank.up * 5 + 1.1 * figure + 2.5 * around))
    tones = _tones(rng, planks, rng.uniform(0.06, 0.14), 0.025).take(plank.index, axis=0)
    weather = fractal_noise(rng, shape, (1, 20), 0.6, stretch=(3, 1))
    gap_m = np.minimum(plank.up, 1 - plank.up) * 0.14
    gap = 1 - 0.62 * smoothstep(gap_m, 0.0085, 0.001) - 0.08 * smoothstep(gap_m, 0.02, 0.004)
    light = gap * (1 + 0.055 * grain + 0.035 * rings + 0.05 * weather) * (1 - 0.35 * around**3)
    relative = tones * light[..., None]
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
    crack = _doubled(worley(rng, (256, 256), (9, 9), warp=0.2).border)
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


# ---- coloured ------------------------------------------------------------------------------------


def _asphalt(rng: Rng) -> Material:
    """Worn asphalt: aggregate, wheel tracks along u, repairs, cracks, and tar over some of them."""
    shape, half, size_m = (768, 768), (384, 384), 9.6
    mean = rng.uniform(0.06, 0.11) * np.array([1.02, 1.0, 0.95 + rng.uniform(-0.03, 0.04)])
    aggregate = fractal_noise(rng, shape, (130, 380), 0.0)
    mottle = _doubled(fractal_noise(rng, half, (3, 120), 0.15))
    track = fractal_noise(rng, half, (1, 5), 0.0, stretch=(6, 1))
    age = fractal_noise(rng, half, (2, 12), 0.3)
    slab = worley(rng, half, tuple(rng.integers(2, 6, 2)), warp=0.1, warp_cycles=(3, 45)).border
    open_crack = smoothstep(_doubled(slab), 0.0085, 0.002)
    open_crack *= _doubled(smoothstep(age, rng.uniform(-1.2, 0.8), 1.0))
    # Crews pour tar over the worst: whole stretches of the same network, 5-10 cm wide.
    tar = smoothstep(_doubled(slab + 0.0015 * fractal_noise(rng, half, (20, 90))), 0.017, 0.011)
    tar *= _doubled(smoothstep(age, 0.3, -0.1)) * rng.uniform(0.0, 0.9)
    alligator = _doubled(worley(rng, half, (46, 46), warp=0.2).border)
    tired = smoothstep(fractal_noise(rng, half, (2, 12), 0.4), rng.uniform(0.8, 1.6), 2.2)
    alligator = smoothstep(alligator, 0.12, 0.03) * _doubled(tired)
    oil = smoothstep(fractal_noise(rng, half, (4, 24), 0.4), 1.9, 3.3)
    light = 1 + 0.085 * aggregate + 0.045 * mottle + _doubled(0.025 * track + 0.025 * age)
    # Single pale stones, bare of their bitumen.
    light += 0.25 * smoothstep(aggregate, 1.6, 2.8)
    light *= _doubled(_repairs(rng, half, size_m) * (1 - 0.3 * oil))
    light *= (1 - 0.5 * open_crack) * (1 - 0.4 * alligator) * (1 - 0.55 * tar)
    return Material(texture=encode_with_mean(light, mean), size_m=(size_m, size_m))


def _repairs(rng: Rng, shape: tuple[int, int], size_m: float) -> np.ndarray:
    """Up to two trench patches with sealed rims, as a multiplier."""
    field = np.ones(shape, np.float32)
    y, x = (np.arange(n, dtype=np.float32) / np.float32(n) for n in shape)
    wobble = 0.025 * fractal_noise(rng, shape, (6, 60), 0.2)
    for _ in range(rng.integers(0, 3)):
        middle, extent_m = rng.random(2), rng.uniform([0.8, 0.5], [3.0, 1.4])
        across = np.abs((x - middle[0] + 0.5) % 1 - 0.5)[None, :] * size_m - extent_m[0] / 2
        along = np.abs((y - middle[1] + 0.5) % 1 - 0.5)[:, None] * size_m - extent_m[1] / 2
        outside_m = (np.maximum(across, along) + wobble).astype(np.float32)
        field *= 1 - rng.uniform(0.02, 0.16) * smoothstep(outside_m, 0.02, -0.02)
        field *= 1 - 0.2 * smoothstep(np.abs(outside_m), 0.05, 0.01)
    return field


def _paving(rng: Rng) -> Material:
    """Concrete slabs with open joints, stains and dropped gum."""
    shape = (768, 768)
    slab_m = float(rng.choice([0.6, 0.75, 0.9, 1.2]))
    n = 2 * round(2.7 / slab_m)
    bonded = slab_m < 0.9 and rng.random() < 0.5
    slab = courses(rng, shape, n, n, 0.5 * (np.arange(n) % 2) * bonded)
    stain = fractal_noise(rng, shape, (1, 60), 0.5)
    grain = fractal_noise(rng, shape, (120, 384), 0.1)
    joint_m = np.minimum(slab.side, np.minimum(slab.up, 1 - slab.up)) * slab_m
    joint = smoothstep(joint_m + 0.0015 * grain, 0.009, 0.004)
    rim = smoothstep(joint_m, 0.06, 0.005)
    tones = _tones(rng, n * n, rng.uniform(0.03, 0.08), 0.008).take(slab.index, axis=0)
    spot = smoothstep(fractal_noise(rng, shape, (30, 60), 1.0), 2.7, 3.2)
    light = 1 + 0.045 * stain + 0.055 * grain
    light = light * (1 - 0.55 * joint) * (1 - 0.06 * rim) * (1 - 0.3 * spot)
    mean = rng.uniform(0.2, 0.32) * np.array([1.05, 1.0, 0.92 + rng.uniform(-0.05, 0.05)])
    texture = encode_with_mean(tones * light[..., None], mean)
    return Material(texture=texture, size_m=(n * slab_m, n * slab_m))


def _concrete(rng: Rng) -> Material:
    """Cast concrete: clouds, dark stains, streaks down v, pores."""
    shape = (512, 512)
    cloud = fractal_noise(rng, shape, (1, 60), 0.4)
    streak = fractal_noise(rng, shape, (3, 50), 0.4, stretch=(1, 9))
    grain = fractal_noise(rng, shape, (80, 256), 0.1)
    stain = smoothstep(fractal_noise(rng, shape, (2, 80), 0.4) + 0.25 * grain, 0.3, 3.0)
    pore = smoothstep(fractal_noise(rng, shape, (60, 130), 0.5), 2.4, 3.0)
    crack = worley(rng, (256, 256), (2, 2), warp=0.12, warp_cycles=(3, 50)).border
    crack = smoothstep(_doubled(crack), 0.006, 0.0015) * smoothstep(cloud, 0.0, 0.9)
    light = 1 + 0.06 * cloud + 0.03 * streak + 0.05 * grain
    light *= (1 - 0.25 * pore) * (1 - 0.4 * crack)
    relative = light[..., None] * blend([1, 1, 1], [0.66, 0.64, 0.6], stain * rng.uniform(0.3, 0.9))
    mean = rng.uniform(0.22, 0.33) * np.array([1.05, 1.0, 0.91 + rng.uniform(-0.04, 0.04)])
    return Material(texture=encode_with_mean(relative, mean), size_m=(5.0, 5.0))


def _grass(rng: Rng) -> Material:
    """Lawn: blades, tufts, clover and dry patches, with hue drifting at every scale."""
    shape, half = (768, 768), (384, 384)
    # Blades lie every way: the brightest of three crossed grains shows.
    turn = rng.uniform(0, math.pi)
    blades = [
        fractal_noise(rng, shape, (80, 300), 0.2, (1, 4), turn + k * math.pi / 3) for k in range(3)
    ]
    blade = np.maximum(np.maximum(blades[0], blades[1]), blades[2])
    blade = (blade - np.float32(0.85)) / np.float32(0.75)
    tuft = _doubled(fractal_noise(rng, half, (14, 100), 0.1))
    drift = _doubled(fractal_noise(rng, half, (2, 60), 0.15))
    hue = _doubled(fractal_noise(rng, half, (3, 90), 0.15))
    dry = _doubled(fractal_noise(rng, half, (3, 60), 0.15))
    clover = _doubled(fractal_noise(rng, half, (4, 40), 0.2))
    straw = smoothstep(dry + 0.4 * tuft + 0.4 * blade, rng.uniform(0.6, 2.0), 3.4)
    green = blend([0.050, 0.084, 0.026], [0.078, 0.104, 0.035], smoothstep(hue, -2.2, 2.2))
    green = blend(green, [0.046, 0.078, 0.027], 0.7 * smoothstep(clover + 0.4 * tuft, 0.5, 2.0))
    green = blend(green, [0.135, 0.118, 0.062], 0.6 * straw)
    light = 1 + 0.15 * blade + 0.085 * tuft + 0.045 * drift
    # Soil and shade show dark between tufts.
    light *= 1 - 0.2 * smoothstep(tuft + 0.7 * blade, -0.9, -2.6)
    green *= (light * np.float32(rng.uniform(0.8, 1.05)))[..., None]
    return Material(texture=encode(green), size_m=(8.0, 8.0))


def _soil(rng: Rng) -> Material:
    """Bare earth: clods, damp patches and scattered stones."""
    shape = (512, 512)
    clod = fractal_noise(rng, shape, (6, 150), 0.2)
    damp = fractal_noise(rng, shape, (2, 30), 0.4)
    grain = fractal_noise(rng, shape, (90, 256), 0.0)
    pebble = fractal_noise(rng, shape, (40, 110), 0.4) + 0.2 * grain
    stone = smoothstep(pebble, 1.9, 2.3) * rng.uniform(0.3, 1.0)
    light = 1 + 0.10 * clod + 0.06 * damp + 0.08 * grain
    # Hollows between the clods, and each stone's shaded foot.
    light *= 1 - 0.22 * smoothstep(clod, -0.6, -2.2)
    light *= 1 - 0.15 * smoothstep(np.abs(pebble - 1.75), 0.2, 0.05)
    earth = blend([1.24, 0.95, 0.7], [1.12, 0.97, 0.78], smoothstep(damp, -2, 2))
    relative = blend(earth, [1.6, 1.45, 1.25], stone) * light[..., None]
    mean = rng.uniform(0.075, 0.13) * np.array([1.25, 0.95, rng.uniform(0.6, 0.75)])
    return Material(texture=encode_with_mean(relative, mean), size_m=(4.0, 4.0))


def _gravel(rng: Rng) -> Material:
    """Loose stones of 3-5 cm, one tone each, dark between."""
    shape, n = (512, 512), int(rng.integers(46, 62))
    stone = worley(rng, shape, (n, n), warp=0.15, warp_cycles=(0.3 * n, 0.9 * n))
    tones = _tones(rng, n * n, 0.17, 0.04).take(stone.index, axis=0)
    # Round tops see more of the sky than the gaps do.
    crown = 0.62 + 0.38 * smoothstep(stone.border, -0.04, 0.24) - 0.1 * stone.centre
    patch = fractal_noise(rng, shape, (2, 40), 0.2)
    relative = tones * (crown * (1 + 0.06 * patch))[..., None]
    mean = rng.uniform(0.16, 0.26) * np.array([1.06, 1.0, 0.9])
    return Material(texture=encode_with_mean(relative, mean), size_m=(2.7, 2.7))


def _rubber(rng: Rng) -> Material:
    """Tyres: black, dusty."""
    shape = (128, 128)
    dust = fractal_noise(rng, shape, (1, 40), 0.4)
    mean = rng.uniform(0.03, 0.045) * np.array([1.03, 1.0, 0.97])
    texture = encode_with_mean(1 + 0.12 * dust, mean)
    return Material(texture=texture, size_m=(0.8, 0.8), smooth=True)


def _metal(rng: Rng) -> Material:
    """Galvanised steel: spangle, streaks and a dull bloom."""
    shape = (256, 256)
    spangle = worley(rng, shape, (24, 24), warp=0.15)
    tone = 1 + 0.05 * rng.standard_normal(24 * 24, np.float32)[spangle.index]
    bloom = fractal_noise(rng, shape, (1, 40), 0.5)
    streak = fractal_noise(rng, shape, (2, 40), 0.4, stretch=(1, 8))
    light = tone * (1 + 0.05 * bloom + 0.04 * streak)
    mean = rng.uniform(0.42, 0.58) * np.array([0.98, 1.0, 1.01])
    texture = encode_with_mean(light, mean)
    roughness = float(rng.uniform(0.25, 0.4))
    return Material(texture=texture, size_m=(1.0, 1.0), kind="metal", roughness=roughness)


def _glass(rng: Rng) -> Material:
    """A pane before a dim room: the texture is what little light comes back from inside."""
    shape = (128, 128)
    room = fractal_noise(rng, shape, (1, 6), 0.5)
    mean = rng.uniform(0.022, 0.035) * np.array([0.88, 1.0, 1.08])
    texture = encode_with_mean(np.exp(0.3 * room), mean)
    return Material(texture=texture, size_m=(5.3, 4.7), kind="glass", roughness=0.02)


def _hill(rng: Rng) -> Material:
    """Woods seen from afar: crowns of 4-7 m in several greens, with shaded gaps."""
    shape, n = (512, 512), int(rng.integers(9, 14))
    crown = worley(rng, shape, (n, n), warp=0.13, warp_cycles=(0.3 * n, 1.5 * n))
    tones = _tones(rng, n * n, 0.16, 0.025).take(crown.index, axis=0)
    clump = fractal_noise(rng, shape, (24, 150), 0.2)
    stand = fractal_noise(rng, shape, (2, 8), 0.1)
    dome = 0.42 + 0.58 * smoothstep(crown.border + 0.04 * clump, -0.04, 0.4)
    light = dome * (1 + 0.15 * clump + 0.05 * stand)
    mean = rng.uniform(0.85, 1.2) * np.array([0.040, 0.058, 0.026])
    texture = encode_with_mean(tones * light[..., None], mean)
    return Material(texture=texture, size_m=(60.0, 60.0), smooth=True)


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

# The texture holds the reflectance: the geometry's tint stays near 1.
COLOURED: dict[str, Callable[[Rng], Material]] = {
    "asphalt": _asphalt,
    "paving": _paving,
    "concrete": _concrete,
    "grass": _grass,
    "soil": _soil,
    "gravel": _gravel,
    "rubber": _rubber,
    "metal": _metal,
    "glass": _glass,
    "hill": _hill,
}


def bake_materials(rng: np.random.Generator) -> dict[str, Material]:
    """Every material of the catalogue, drawn and baked.

    Each has a lane of its own, keyed by its name: adding or changing one leaves the others' bytes
    alone.

    Args:
        rng: one number is drawn from it.
    """
    seed = int(rng.integers(2**53))
    return {name: bake(lane(seed, name)) for name, bake in {**NEUTRAL, **COLOURED}.items()}
