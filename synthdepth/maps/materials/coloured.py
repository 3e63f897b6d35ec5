"""Materials that hold their colour: visible linear reflectances after Oke 1987 and Taha 1992."""

import math
from collections.abc import Callable

import numpy as np

from synthdepth.maps.materials.textures import (
    blend,
    courses,
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


def _asphalt(rng: Rng) -> Material:
    """Worn asphalt: aggregate, wheel tracks along u, repairs, cracks, and tar over some of them."""
    shape, half, size_m = (768, 768), (384, 384), 9.6
    mean = rng.uniform(0.06, 0.11) * np.array([1.02, 1.0, 0.95 + rng.uniform(-0.03, 0.04)])
    aggregate = fractal_noise(rng, shape, (130, 380), 0.0)
    mottle = doubled(fractal_noise(rng, half, (3, 120), 0.15))
    track = fractal_noise(rng, half, (1, 5), 0.0, stretch=(6, 1))
    age = fractal_noise(rng, half, (2, 12), 0.3)
    slab = worley(rng, half, tuple(rng.integers(2, 6, 2)), warp=0.1, warp_cycles=(3, 45)).border
    open_crack = smoothstep(doubled(slab), 0.0085, 0.002)
    open_crack *= doubled(smoothstep(age, rng.uniform(-1.2, 0.8), 1.0))
    # Crews pour tar over the worst: whole stretches of the same network, 5-10 cm wide.
    tar = smoothstep(doubled(slab + 0.0015 * fractal_noise(rng, half, (20, 90))), 0.017, 0.011)
    tar *= doubled(smoothstep(age, 0.3, -0.1)) * rng.uniform(0.0, 0.9)
    alligator = doubled(worley(rng, half, (46, 46), warp=0.2).border)
    tired = smoothstep(fractal_noise(rng, half, (2, 12), 0.4), rng.uniform(0.8, 1.6), 2.2)
    alligator = smoothstep(alligator, 0.12, 0.03) * doubled(tired)
    oil = smoothstep(fractal_noise(rng, half, (4, 24), 0.4), 1.9, 3.3)
    light = 1 + 0.085 * aggregate + 0.045 * mottle + doubled(0.025 * track + 0.025 * age)
    # Single pale stones, bare of their bitumen.
    light += 0.25 * smoothstep(aggregate, 1.6, 2.8)
    light *= doubled(_repairs(rng, half, size_m) * (1 - 0.3 * oil))
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
    shades = tones(rng, n * n, rng.uniform(0.03, 0.08), 0.008).take(slab.index, axis=0)
    spot = smoothstep(fractal_noise(rng, shape, (30, 60), 1.0), 2.7, 3.2)
    light = 1 + 0.045 * stain + 0.055 * grain
    light = light * (1 - 0.55 * joint) * (1 - 0.06 * rim) * (1 - 0.3 * spot)
    mean = rng.uniform(0.2, 0.32) * np.array([1.05, 1.0, 0.92 + rng.uniform(-0.05, 0.05)])
    texture = encode_with_mean(shades * light[..., None], mean)
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
    crack = smoothstep(doubled(crack), 0.006, 0.0015) * smoothstep(cloud, 0.0, 0.9)
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
    tuft = doubled(fractal_noise(rng, half, (14, 100), 0.1))
    drift = doubled(fractal_noise(rng, half, (2, 60), 0.15))
    hue = doubled(fractal_noise(rng, half, (3, 90), 0.15))
    dry = doubled(fractal_noise(rng, half, (3, 60), 0.15))
    clover = doubled(fractal_noise(rng, half, (4, 40), 0.2))
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
    shades = tones(rng, n * n, 0.17, 0.04).take(stone.index, axis=0)
    # Round tops see more of the sky than the gaps do.
    crown = 0.62 + 0.38 * smoothstep(stone.border, -0.04, 0.24) - 0.1 * stone.centre
    patch = fractal_noise(rng, shape, (2, 40), 0.2)
    relative = shades * (crown * (1 + 0.06 * patch))[..., None]
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
    shades = tones(rng, n * n, 0.16, 0.025).take(crown.index, axis=0)
    clump = fractal_noise(rng, shape, (24, 150), 0.2)
    stand = fractal_noise(rng, shape, (2, 8), 0.1)
    dome = 0.42 + 0.58 * smoothstep(crown.border + 0.04 * clump, -0.04, 0.4)
    light = dome * (1 + 0.15 * clump + 0.05 * stand)
    mean = rng.uniform(0.85, 1.2) * np.array([0.040, 0.058, 0.026])
    texture = encode_with_mean(shades * light[..., None], mean)
    return Material(texture=texture, size_m=(60.0, 60.0), smooth=True)


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
