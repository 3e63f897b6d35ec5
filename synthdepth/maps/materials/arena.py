"""Paints, panels and floors of the obstacle arena, and façades seen from afar."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.materials.textures import (
    blend,
    courses,
    encode,
    encode_neutral,
    fractal_noise,
    smoothstep,
    texel_grid,
    tones,
    worley,
)
from synthdepth.maps.world import Material

Rng = np.random.Generator

FAR_BAY_M = 3.2  # width of a bay and height of a floor of the far façades
_FAR_BAYS = 8


def _facade_far(rng: Rng) -> Material:
    """Punched windows, one a bay and floor, some with blinds: a wall a kilometre away."""
    return _far_wall(rng, sill=0.3, head=0.75, side=0.22)


def _facade_far_bands(rng: Rng) -> Material:
    """Ribbon windows between spandrels, with slim mullions."""
    return _far_wall(rng, sill=0.34, head=0.9, side=0.03)


def _far_wall(rng: Rng, sill: float, head: float, side: float) -> Material:
    """Windows from `sill` to `head` of a floor and `side` bays from a bay's ends."""
    shape, n = (512, 512), _FAR_BAYS
    u, v = (np.broadcast_to(x * n, shape) for x in texel_grid(shape))
    bay, floor = u.astype(np.int32), v.astype(np.int32)
    x, y = u - bay, v - floor
    inside = np.minimum(np.minimum(x - side, 1 - side - x), np.minimum(y - sill, head - y))
    pane = smoothstep(inside, -0.006, 0.02)
    number = floor * n + bay
    # Sky, curtains and dark rooms: a pane is anything from a fifth to two thirds of its wall.
    room = 0.16 + 0.5 * rng.random(n * n, np.float32) ** 3
    blind = 1 - 0.6 * rng.random(n * n, np.float32) ** 2
    drawn = (y - sill) / (head - sill) > blind[number]
    light = room[number] * np.where(drawn, np.float32(1.7), np.float32(1))
    stain = fractal_noise(rng, shape, (1, 40), 0.5)
    streak = fractal_noise(rng, shape, (2, 50), 0.4, stretch=(1, 6))
    wall = 0.8 * (1 + 0.035 * stain + 0.03 * streak)
    # The slab's edge shows as a line at every floor.
    wall *= 1 - 0.12 * smoothstep(np.minimum(y, 1 - y), 0.05, 0.02)
    glass = 0.9 * light[..., None] * tones(rng, n * n, 0.05, 0.03)[number]
    glass = glass * np.float32([0.9, 1.0, 1.1])
    relative = wall[..., None] * (1 - pane[..., None]) + glass * pane[..., None]
    size = n * FAR_BAY_M
    return Material(texture=encode(np.clip(relative, 0, 1)), size_m=(size, size))


# Light and dark of patterned floors, linear reflectances.
_FLOOR_PAIRS = (
    ((0.34, 0.335, 0.32), (0.16, 0.16, 0.165)),
    ((0.4, 0.38, 0.34), (0.1, 0.105, 0.11)),
    ((0.36, 0.31, 0.24), (0.21, 0.105, 0.07)),
    ((0.33, 0.34, 0.33), (0.1, 0.14, 0.17)),
    ((0.33, 0.33, 0.3), (0.12, 0.17, 0.12)),
    ((0.37, 0.33, 0.25), (0.24, 0.19, 0.13)),
)


def _wear(rng: Rng, shape: tuple[int, int]) -> np.ndarray:
    """Stains, tyre marks, cracks and grit of an outdoor floor, as a multiplier (h, w)."""
    stain = fractal_noise(rng, shape, (2, 70), 0.35)
    grit = fractal_noise(rng, shape, (100, 256), 0.0)
    light = 1 + 0.07 * stain + 0.045 * grit
    spill = fractal_noise(rng, shape, (3, 60), 0.6)
    light *= 1 - rng.uniform(0.2, 0.45) * smoothstep(spill + 0.15 * grit, 1.1, 2.3)
    skid = fractal_noise(rng, shape, (3, 90), 0.3, (12, 1), rng.uniform(0, np.pi))
    light *= 1 - 0.3 * smoothstep(skid + 0.4 * stain, 1.6, 2.9)
    crack = worley(rng, shape, (4, 4), warp=0.12, warp_cycles=(3, 60)).border
    light *= 1 - 0.4 * smoothstep(crack, 0.012, 0.003) * smoothstep(stain, -0.6, 0.8)
    return light


def _floor(rng: Rng, dark: np.ndarray, joint: np.ndarray, shades: np.ndarray) -> np.ndarray:
    """uint8 texture of two worn paints: `dark` and `joint` (h, w) 0 to 1, `shades` (h, w, 3)."""
    light_paint, dark_paint = _FLOOR_PAIRS[rng.integers(len(_FLOOR_PAIRS))]
    chip = fractal_noise(rng, dark.shape, (12, 160), 0.2) + 0.6 * fractal_noise(
        rng, dark.shape, (1, 10), 0.4
    )
    bare = smoothstep(chip, rng.uniform(1.0, 1.8), 2.8) * 0.85
    colour = blend(blend(light_paint, dark_paint, dark), [0.22, 0.21, 0.195], bare) * shades
    light = _wear(rng, dark.shape) * (1 - 0.5 * joint)
    return encode(np.clip(colour * light[..., None], 0, 1))


def _checker_floor(rng: Rng) -> Material:
    """Squares of 1.6 m in two paints on concrete, seamed, chipped and stained."""
    shape, n = (512, 512), 8
    u, v = (np.broadcast_to(x * n, shape) for x in texel_grid(shape))
    column, row = u.astype(np.int32), v.astype(np.int32)
    edge = np.minimum(np.minimum(u % 1, 1 - u % 1), np.minimum(v % 1, 1 - v % 1))
    joint = smoothstep(edge * 1.6, 0.03, 0.01)
    shades = tones(rng, n * n, 0.08, 0.015)[row * n + column]
    dark = ((column + row) % 2).astype(np.float32)
    return Material(texture=_floor(rng, dark, joint, shades), size_m=(12.8, 12.8))


def _tile_floor(rng: Rng) -> Material:
    """Slabs of 0.8 m in a broken bond, a share of them dark."""
    shape, n = (512, 512), 12
    slab = courses(rng, shape, n, n, 0.5 * (np.arange(n) % 2), 0.0)
    joint = smoothstep(np.minimum(slab.side, np.minimum(slab.up, 1 - slab.up)) * 0.8, 0.03, 0.008)
    dark = (rng.random(n * n) < rng.uniform(0.15, 0.5)).astype(np.float32)[slab.index]
    shades = tones(rng, n * n, 0.1, 0.02)[slab.index]
    return Material(texture=_floor(rng, dark, joint, shades), size_m=(9.6, 9.6))


def _striped_floor(rng: Rng) -> Material:
    """Bands of 1.28 m along v, crossed by joints every 3.2 m."""
    shape, n = (512, 512), 10
    u, v = (np.broadcast_to(x, shape) for x in texel_grid(shape))
    band = u * n
    number = band.astype(np.int32)
    across = (v * 4) % 1
    joint = smoothstep(np.minimum(across, 1 - across) * 3.2, 0.03, 0.01)
    shades = tones(rng, n, 0.08, 0.015)[number]
    dark = (number % 2).astype(np.float32)
    return Material(texture=_floor(rng, dark, joint, shades), size_m=(12.8, 12.8))


def _slab_floor(rng: Rng) -> Material:
    """Concrete cast in bays of 3.2 m, each of its own grey, with sealed expansion joints."""
    shape, n = (512, 512), 4
    u, v = (np.broadcast_to(x * n, shape) for x in texel_grid(shape))
    number = v.astype(np.int32) * n + u.astype(np.int32)
    edge = np.minimum(np.minimum(u % 1, 1 - u % 1), np.minimum(v % 1, 1 - v % 1)) * 3.2
    joint = smoothstep(edge, 0.045, 0.02)
    dark = (0.5 * rng.random(n * n).astype(np.float32))[number]
    shades = (
        tones(rng, n * n, 0.1, 0.02)[number] * (1 - 0.12 * smoothstep(edge, 0.4, 0.0))[..., None]
    )
    return Material(texture=_floor(rng, dark, joint, shades), size_m=(12.8, 12.8))


def _painted_block(rng: Rng) -> Material:
    """Painted concrete: formwork seams, tie holes, streaks, flakes and a dirty foot; neutral."""
    shape, n = (512, 512), 4
    u, v = (np.broadcast_to(x * n, shape) for x in texel_grid(shape))
    edge = np.minimum(np.minimum(u % 1, 1 - u % 1), np.minimum(v % 1, 1 - v % 1)) * 1.5
    seam = smoothstep(edge, 0.028, 0.01)
    hole = np.hypot((u * 2 % 1 - 0.5) * 0.75, (v * 2 % 1 - 0.5) * 0.75)
    hole = smoothstep(hole, 0.035, 0.02)
    stain = fractal_noise(rng, shape, (1, 50), 0.45)
    streak = fractal_noise(rng, shape, (4, 90), 0.3, stretch=(1, 10))
    grain = fractal_noise(rng, shape, (60, 256), 0.1)
    flake = fractal_noise(rng, shape, (8, 120), 0.25) + 0.5 * stain
    flake = smoothstep(flake, rng.uniform(1.5, 2.0), 2.6)
    run = smoothstep(streak + 0.5 * stain, 0.7, 2.6)
    light = 1 + 0.055 * stain + 0.04 * streak + 0.05 * grain
    light *= (1 - 0.4 * seam) * (1 - 0.5 * hole) * (1 - 0.3 * flake)
    panel = tones(rng, n * n, 0.05, 0.008)[v.astype(np.int32) * n + u.astype(np.int32)]
    relative = panel * light[..., None] * blend([1, 1, 1], [0.62, 0.56, 0.5], run)
    return Material(texture=encode_neutral(relative), size_m=(6.0, 6.0))


def _container(rng: Rng) -> Material:
    """Corrugated sheet of 0.28 m pitch: lit and shaded flanks, dents, rust, runs; neutral."""
    shape, n = (512, 512), 20
    u, v = texel_grid(shape)
    x = u * n % 1
    lit = smoothstep(np.abs(x - 0.2), 0.1, 0.05)
    shaded = smoothstep(np.abs(x - 0.7), 0.1, 0.05)
    crest = smoothstep(np.abs(x - 0.45), 0.24, 0.16)
    profile = 1 + 0.16 * lit - 0.34 * shaded + 0.05 * crest
    dent = fractal_noise(rng, shape, (1, 12), 0.6)
    streak = fractal_noise(rng, shape, (3, 80), 0.3, stretch=(1, 9))
    grain = fractal_noise(rng, shape, (50, 220), 0.1)
    rust = smoothstep(streak + 0.6 * fractal_noise(rng, shape, (6, 90), 0.3), 1.5, 2.7)
    light = profile * (1 + 0.05 * dent + 0.045 * streak + 0.03 * grain)
    relative = blend([1, 1, 1], [0.62, 0.36, 0.22], 0.85 * rust) * light[..., None]
    return Material(texture=encode_neutral(relative), size_m=(n * 0.28, n * 0.28))


def _plywood(rng: Rng) -> Material:
    """Sheets of 1.22 x 2.44 m with grain, patches, screws and grey weathering; neutral."""
    shape, rows, columns = (512, 512), 2, 4
    u, v = (np.broadcast_to(x, shape) for x in texel_grid(shape))
    x, y = u * columns, v * rows
    number = y.astype(np.int32) * columns + x.astype(np.int32)
    edge = np.minimum(np.minimum(x % 1, 1 - x % 1) * 1.22, np.minimum(y % 1, 1 - y % 1) * 2.44)
    gap = smoothstep(edge, 0.016, 0.005)
    grain = fractal_noise(rng, shape, (10, 200), 0.3, stretch=(1, 12))
    figure = fractal_noise(rng, shape, (4, 50), 0.5, stretch=(1, 4))
    ring = np.sin(9 * figure + 2 * np.pi * 6 * u)
    damp = smoothstep(fractal_noise(rng, shape, (2, 40), 0.4, stretch=(1, 2)), 0.3, 2.2)
    shades = tones(rng, rows * columns, 0.1, 0.03)[number]
    light = (1 + 0.06 * grain + 0.05 * ring) * (1 - 0.6 * gap)
    relative = shades * light[..., None] * blend([1, 1, 1], [0.62, 0.62, 0.64], 0.7 * damp)
    return Material(texture=encode_neutral(relative), size_m=(columns * 1.22, rows * 2.44))


def _hazard(rng: Rng) -> Material:
    """Yellow and black stripes at 45 degrees, scuffed to the primer."""
    shape, n = (256, 256), 4
    u, v = texel_grid(shape)
    stripe = (u + v) * n % 1
    black = smoothstep(np.abs(stripe - 0.5), 0.26, 0.235)
    scuff = fractal_noise(rng, shape, (4, 90), 0.25) + 0.5 * fractal_noise(rng, shape, (1, 8), 0.4)
    dirt = fractal_noise(rng, shape, (2, 40), 0.4, stretch=(1, 4))
    colour = blend([0.46, 0.3, 0.03], [0.03, 0.03, 0.032], black)
    colour = blend(colour, [0.3, 0.29, 0.27], 0.8 * smoothstep(scuff, 1.0, 2.2))
    return Material(texture=encode(colour * (1 + 0.08 * dirt)[..., None]), size_m=(1.6, 1.6))


def _enamel(rng: Rng) -> Material:
    """Chalky enamel on round things: plates with weld lines, runs and rust spots; neutral."""
    shape, rows = (512, 512), 4
    plate = courses(rng, shape, rows, 3, rng.random(rows), 0.0)
    line_m = np.minimum(plate.side * 2.0, np.minimum(plate.up, 1 - plate.up) * 1.5)
    weld = smoothstep(line_m, 0.03, 0.012)
    streak = fractal_noise(rng, shape, (3, 80), 0.35, stretch=(1, 9))
    chalk = fractal_noise(rng, shape, (1, 40), 0.5)
    grain = fractal_noise(rng, shape, (60, 220), 0.1)
    rust = smoothstep(streak + 0.8 * fractal_noise(rng, shape, (8, 120), 0.3), 1.9, 3.0)
    light = (1 + 0.05 * streak + 0.05 * chalk + 0.03 * grain) * (1 - 0.28 * weld)
    shades = tones(rng, rows * 3, 0.03, 0.006)[plate.index]
    relative = shades * light[..., None] * blend([1, 1, 1], [0.5, 0.3, 0.2], 0.8 * rust)
    return Material(texture=encode_neutral(relative), size_m=(6.0, 6.0), smooth=True)


def _seams_m(unit: Courses, width_m: float, height_m: float) -> np.ndarray:
    """Distance (h, w) to the nearest joint of a layout [m]."""
    return np.minimum(unit.side * width_m, np.minimum(unit.up, 1 - unit.up) * height_m)


def _worn_paint(rng: Rng, shape: tuple[int, int], chipped: float) -> np.ndarray:
    """Old paint as relative reflectances (h, w, 3): runs, fading, grime, chips down to a primer."""
    fade = fractal_noise(rng, shape, (1, 12), 0.5)
    streak = fractal_noise(rng, shape, (3, 70), 0.35, stretch=(1, 10))
    grain = fractal_noise(rng, shape, (60, 220), 0.1)
    half = (shape[0] // 2, shape[1] // 2)
    grime = smoothstep(doubled(fractal_noise(rng, half, (2, 60), 0.5)) + 0.6 * streak, 0.4, 3.0)
    flake = doubled(fractal_noise(rng, half, (4, 90), 0.35)) + 0.3 * grain
    chip = smoothstep(flake, 3.1 - 1.5 * chipped, 3.3 - 1.5 * chipped)
    light = 1 + 0.045 * fade + 0.05 * streak + 0.035 * grain
    relative = light[..., None] * blend([1, 1, 1], [0.52, 0.48, 0.42], 0.75 * grime)
    primer = np.float32(rng.uniform(0.4, 0.95)) * np.float32([1.06, 1.0, 0.92])
    return blend(relative, primer * (1 + 0.06 * grain)[..., None], 0.85 * chip)


def _panel_paint(rng: Rng) -> Material:
    """Painted sheets of 2.4 x 1.2 m with open seams, screws along them and runs below."""
    shape, rows, columns = (768, 768), 6, 3
    sheet = courses(rng, shape, rows, columns, 0.5 * (np.arange(rows) % 2) * (rng.random() < 0.5))
    seam_m = _seams_m(sheet, 2.4, 1.2)
    relative = _worn_paint(rng, shape, rng.uniform(0.2, 0.8))
    relative *= tones(rng, rows * columns, 0.05, 0.012)[sheet.index]
    # Screws every 0.3 m, 5 cm inside the seams.
    u, v = (np.broadcast_to(x * 7.2, shape) for x in texel_grid(shape))
    across = np.minimum(np.abs((u + 0.15) % 0.3 - 0.15), np.abs((v + 0.15) % 0.3 - 0.15))
    screw = smoothstep(np.hypot(across, seam_m - 0.06), 0.02, 0.009)
    light = (1 - 0.62 * smoothstep(seam_m, 0.011, 0.004)) * (1 - 0.4 * screw)
    light *= 1 - 0.16 * smoothstep(seam_m, 0.09, 0.0)
    return Material(texture=encode_neutral(relative * light[..., None]), size_m=(7.2, 7.2))


def _block_paint(rng: Rng) -> Material:
    """Painted blockwork of 0.6 x 0.3 m units: joints show through, units differ a little."""
    shape, rows, columns = (768, 768), 16, 8
    unit = courses(rng, shape, rows, columns, 0.5 * (np.arange(rows) % 2), 0.01)
    rough = fractal_noise(rng, shape, (60, 250), 0.2)
    joint = smoothstep(_seams_m(unit, 0.6, 0.3) + 0.001 * rough, 0.013, 0.004)
    relative = _worn_paint(rng, shape, rng.uniform(0.4, 1.0))
    relative *= tones(rng, rows * columns, rng.uniform(0.03, 0.09), 0.012)[unit.index]
    pore = smoothstep(fractal_noise(rng, shape, (70, 160), 0.4), 2.0, 2.9)
    light = (1 - 0.42 * joint) * (1 - 0.22 * pore) * (1 + 0.04 * rough)
    return Material(texture=encode_neutral(relative * light[..., None]), size_m=(4.8, 4.8))


def _plywood(rng: Rng) -> Material:
    """Sheets of 1.2 x 2.4 m, oiled or bare: cathedral grain, screws, grey weathering."""
    shape, columns = (768, 768), 4
    sheet = courses(rng, shape, 2, columns)
    figure = fractal_noise(rng, shape, (2, 40), 0.7, stretch=(1, 5))
    fibre = fractal_noise(rng, shape, (14, 150), 0.2, stretch=(1, 14))
    number = sheet.index.astype(np.float32)
    rings = np.sin(2 * np.pi * (3.0 * figure + 0.37 * number))
    weather = smoothstep(fractal_noise(rng, shape, (2, 40), 0.5, stretch=(1, 2)), 0.2, 2.4)
    seam_m = _seams_m(sheet, 1.2, 2.4)
    light = (1 + 0.07 * rings + 0.05 * fibre) * (1 - 0.6 * smoothstep(seam_m, 0.012, 0.004))
    relative = light[..., None] * tones(rng, 2 * columns, 0.1, 0.04)[sheet.index]
    relative = relative * blend([1, 1, 1], [0.66, 0.68, 0.7], rng.uniform(0.3, 1) * weather)
    return Material(texture=encode_neutral(relative), size_m=(4.8, 4.8))


def _container_steel(rng: Rng) -> Material:
    """Old enamel on steel: scratches, dull patches, rust that bleeds downwards."""
    shape, half = (512, 512), (256, 256)
    dull = fractal_noise(rng, shape, (1, 20), 0.5)
    scratch = smoothstep(fractal_noise(rng, shape, (12, 140), 0.2, (9, 1), 0.15), 2.1, 3.0)
    grain = fractal_noise(rng, shape, (60, 200), 0.1)
    source = doubled(fractal_noise(rng, half, (4, 60), 0.3)) + 0.25 * grain
    rust = smoothstep(source, rng.uniform(1.3, 2.1), 2.7)
    bleed = fractal_noise(rng, shape, (4, 60), 0.3, stretch=(1, 12))
    run = smoothstep(bleed + 0.4 * source, rng.uniform(1.0, 1.8), 3.2)
    light = 1 + 0.05 * dull + 0.03 * grain + 0.22 * scratch
    relative = blend([1, 1, 1], [0.62, 0.4, 0.26], 0.7 * run) * light[..., None]
    relative = blend(relative, np.float32([0.42, 0.2, 0.11]), 0.9 * rust)
    return Material(texture=encode_neutral(relative), size_m=(5.0, 5.0))


def _arena_floor(rng: Rng) -> Material:
    """Painted slabs of 1.2 m: tyre scuffs, spills, cracks, paint worn off where feet go."""
    shape, half, n = (768, 768), (384, 384), 6
    slab = courses(rng, shape, n, n)
    joint_m = _seams_m(slab, 1.2, 1.2)
    grain = fractal_noise(rng, shape, (90, 300), 0.1)
    mottle = doubled(fractal_noise(rng, half, (2, 90), 0.2))
    scuff = np.zeros(shape, np.float32)
    for angle in rng.uniform(0, np.pi, 2):
        line = fractal_noise(rng, shape, (5, 90), 0.4, (14, 1), angle)
        scuff += smoothstep(line + 0.3 * mottle, 1.7, 3.1)
    spill = smoothstep(doubled(fractal_noise(rng, half, (3, 40), 0.5)) + 0.2 * grain, 1.3, 2.4)
    worn = smoothstep(doubled(fractal_noise(rng, half, (2, 110), 0.3)) + 0.4 * grain, 1.5, 2.6)
    crack = doubled(worley(rng, half, (3, 3), warp=0.12, warp_cycles=(3, 50)).border)
    crack = smoothstep(crack, 0.008, 0.002) * smoothstep(mottle, -0.6, 0.8)
    light = (1 + 0.06 * mottle + 0.06 * grain) * (1 - 0.35 * scuff) * (1 - 0.45 * crack)
    light *= 1 - 0.5 * smoothstep(joint_m + 0.002 * grain, 0.012, 0.005)
    light *= 1 - 0.12 * smoothstep(joint_m, 0.09, 0.01)
    relative = tones(rng, n * n, 0.05, 0.012)[slab.index] * light[..., None]
    relative = relative * blend([1, 1, 1], [0.55, 0.52, 0.48], 0.55 * spill)
    bare = np.float32([0.8, 0.78, 0.74]) * (1 + 0.08 * grain)[..., None]
    return Material(texture=encode_neutral(blend(relative, bare, 0.55 * worn)), size_m=(7.2, 7.2))


def _shell_paint(rng: Rng) -> Material:
    """Paint on rolled steel: tanks, pipes and domes, with a weld every 2 m and runs below it."""
    shape = (512, 512)
    relative = _worn_paint(rng, shape, rng.uniform(0.2, 0.7))
    weld = courses(rng, shape, 3, 2, 0.5 * (np.arange(3) % 2))
    weld_m = _seams_m(weld, 3.0, 2.0)
    light = (1 - 0.25 * smoothstep(weld_m, 0.03, 0.008)) * (1 - 0.1 * smoothstep(weld_m, 0.2, 0.0))
    texture = encode_neutral(relative * light[..., None])
    return Material(texture=texture, size_m=(6.0, 6.0), smooth=True)


def _hazard(rng: Rng) -> Material:
    """Diagonal warning stripes, black on yellow or red on white, scraped and dusty."""
    shape, size_m = (256, 256), 1.6
    u, v = texel_grid(shape)
    worn = fractal_noise(rng, shape, (4, 60), 0.4)
    grain = fractal_noise(rng, shape, (40, 120), 0.1)
    across = np.abs(((u + v) * 4 + 0.03 * worn) % 1 - 0.5)
    stripe = smoothstep(across, 0.235, 0.265)
    yellow = rng.random() < 0.65
    pale = [0.46, 0.3, 0.035] if yellow else [0.55, 0.53, 0.49]
    dark = [0.035, 0.034, 0.033] if yellow else [0.3, 0.05, 0.035]
    colour = blend(pale, dark, stripe) * (1 + 0.06 * worn + 0.05 * grain)[..., None]
    scraped = smoothstep(worn + 0.5 * grain, 1.2, 2.2)
    return Material(
        texture=encode(blend(colour, [0.2, 0.18, 0.155], 0.7 * scraped)), size_m=(size_m, size_m)
    )


# The far façades and everything but the warning stripes are near white: tint is the reflectance.
ARENA: dict[str, Callable[[Rng], Material]] = {
    "panel_paint": _panel_paint,
    "block_paint": _block_paint,
    "plywood": _plywood,
    "container_steel": _container_steel,
    "arena_floor": _arena_floor,
    "shell_paint": _shell_paint,
    "hazard": _hazard,
    "facade_far": _facade_far,
    "facade_far_bands": _facade_far_bands,
}
