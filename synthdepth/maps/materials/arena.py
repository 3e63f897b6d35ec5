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
    x = texel_grid(shape)[0] * n % 1
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


ARENA: dict[str, Callable[[Rng], Material]] = {
    "facade_far": _facade_far,
    "facade_far_bands": _facade_far_bands,
    "checker_floor": _checker_floor,
    "tile_floor": _tile_floor,
    "striped_floor": _striped_floor,
    "slab_floor": _slab_floor,
    "painted_block": _painted_block,
    "container": _container,
    "plywood": _plywood,
    "hazard": _hazard,
    "enamel": _enamel,
}
