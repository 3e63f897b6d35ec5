"""The sky as a picture: clear, clouded, overcast, foggy or at night, and what sun or moon adds.

Mitsuba's clear-sky model (Hosek & Wilkie 2012) is the ground; clouds are painted over it, an
overcast sky has the CIE's luminance distribution (CIE S 011). All in the model's unit of radiance.
"""

# Annotations stay text: Mitsuba has no types before a variant is set.
from __future__ import annotations

import dataclasses

import drjit as dr
import mitsuba as mi
import numpy as np
from scipy import ndimage

from synthdepth.maps.materials.textures import fractal_noise, smoothstep
from synthdepth.maps.world import Light
from synthdepth.render.colour import LUMINANCE
from synthdepth.seeding import lane

# One lux in the model's unit: the sun, high in a clear sky, gives 1.29 units and 100 klx.
LUX = 1.29e-5
# Half the sun's angle, as a slope.
SUN_SLOPE = 0.004675
_SHAPE = (256, 512)  # whole sphere, 0.7 degrees a texel
_GROUND_REFLECTANCE = 0.12
# What comes through a closed cloud cover, of all light that falls on it.
_OVERCAST_SHARE = 0.22
_OVERCAST_TINT = np.array([0.97, 1.0, 1.06])
# Covers between which the sun disappears.
_SUN_HIDDEN = (0.65, 0.95)
# Below this sine of the elevation clouds merge into the air's own colour.
_CLOUD_FOOT = (0.04, 0.16)
# At night: a bright moon, and the sky's glow at the zenith and above the horizon [lx a unit solid
# angle]; town lights make the horizon warm.
_MOON_LUX = np.array([0.62, 0.68, 0.8])
_NIGHT_ZENITH = np.array([0.018, 0.026, 0.048])
_NIGHT_HORIZON = np.array([0.1, 0.085, 0.08])


@dataclasses.dataclass(frozen=True)
class Sky:
    """What lights a scene from above.

    Attributes:
        image: (h, w, 3) float32 radiance over the whole sphere, as `direction_grid` has it.
        beam: (3,) irradiance by sun or moon of a surface that faces it.
        irradiance: (3,) of open level ground by the sky alone.
    """

    image: np.ndarray
    beam: np.ndarray
    irradiance: np.ndarray


def direction_grid() -> np.ndarray:
    """Unit vectors of the sky's texels, (h, w, 3): first row up, azimuth from +Y towards +X.

    That is how Mitsuba's `envmap` reads a picture once it is turned to have Z up: the first and
    last row are the poles, columns have their middles within.
    """
    h, w = _SHAPE
    theta = np.linspace(0, np.pi, h)[:, None]
    turn = 2 * np.pi * (np.arange(w) + 0.5)[None, :] / w
    return np.stack(
        np.broadcast_arrays(
            np.sin(theta) * np.sin(turn), np.sin(theta) * np.cos(turn), np.cos(theta)
        ),
        axis=-1,
    )


def make_sky(light: Light) -> Sky:
    """The sky of a light."""
    toward = direction_grid()
    h, w = _SHAPE
    solid_angle = np.hypot(toward[..., 0], toward[..., 1]) * np.pi / (h - 1) * 2 * np.pi / w
    upper = toward[..., 2] > 0
    weight = np.where(upper, solid_angle * toward[..., 2], 0.0)

    def irradiance(image):
        return np.einsum("hw,hwc->c", weight, image)

    hidden = smoothstep(np.float32(light.cloud_cover), *_SUN_HIDDEN)
    if light.lamps_on:
        clear, beam = _night(toward[..., 2]), _MOON_LUX * LUX
    else:
        clear, beam = _clear(light, toward), _sun(light)
    everything = irradiance(clear) + beam * light.sun_direction[2]
    image = clear
    if light.cloud_cover > 0:
        image = _clouded(light, toward, clear, everything)
    closed = smoothstep(np.float32(light.cloud_cover), 0.8, 1.0)
    if closed > 0:
        image = image + closed * (_overcast(light, toward, everything) - image)
    beam = beam * (1 - hidden)
    sky = irradiance(image)
    ground = _GROUND_REFLECTANCE * (sky + beam * light.sun_direction[2]) / np.pi
    image = np.where(upper[..., None], image, ground)
    return Sky(image=image.astype(np.float32), beam=beam, irradiance=sky)


def sunsky(light: Light, *, sun_scale: float) -> dict:
    """Mitsuba's clear-sky model of a light, with or without the sun's disc."""
    return {
        "type": "sunsky",
        "sun_direction": [float(x) for x in light.sun_direction],
        "turbidity": light.turbidity,
        "albedo": 0.15,
        "sun_scale": sun_scale,
    }


def _looked_up(emitter: mi.Emitter, toward: np.ndarray) -> np.ndarray:
    """Radiance (n, 3) of an environment from directions (n, 3)."""
    if dr.is_jit_v(mi.Float):
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.wi = mi.Vector3f(*np.ascontiguousarray(-toward.T, np.float32))
        return emitter.eval(si).numpy().T
    found, si = [], mi.SurfaceInteraction3f()
    for direction in (-toward).tolist():
        si.wi = mi.Vector3f(*direction)
        found.append(list(emitter.eval(si)))
    return np.array(found)


def _clear(light: Light, toward: np.ndarray) -> np.ndarray:
    model = mi.load_dict(sunsky(light, sun_scale=0.0))
    image = np.zeros((*toward.shape[:2], 3))
    half = toward.shape[0] // 2
    image[:half] = _looked_up(model, toward[:half].reshape(-1, 3)).reshape(half, -1, 3)
    return np.maximum(image, 0)


def _sun(light: Light) -> np.ndarray:
    """Irradiance by the sun: the radiance that the model has with it and not without."""
    turn = 2 * np.pi * np.arange(16) / 16
    sun = light.sun_direction
    side = np.cross(sun, [0.0, 0.0, 1.0] if abs(sun[2]) < 0.9 else [1.0, 0.0, 0.0])
    side /= np.linalg.norm(side)
    other = np.cross(sun, side)
    # The model's limb darkening: rings of equal area stand for the disc.
    radii = SUN_SLOPE * np.sqrt((np.arange(8) + 0.5) / 8)
    rings = radii[:, None, None] * (np.cos(turn)[:, None] * side + np.sin(turn)[:, None] * other)
    toward = (sun + rings).reshape(-1, 3)
    toward /= np.linalg.norm(toward, axis=1, keepdims=True)
    with_sun, without = (
        _looked_up(mi.load_dict(sunsky(light, sun_scale=scale)), toward) for scale in (1.0, 0.0)
    )
    return np.maximum(with_sun - without, 0).mean(axis=0) * np.pi * SUN_SLOPE**2


def _night(sine: np.ndarray) -> np.ndarray:
    foot = np.exp(-4 * np.maximum(sine, 0))[..., None]
    return LUX * (_NIGHT_ZENITH + foot * (_NIGHT_HORIZON - _NIGHT_ZENITH))


def _overcast(light: Light, toward: np.ndarray, everything: np.ndarray) -> np.ndarray:
    """The CIE's overcast sky, L = Lz (1 + 2 sin e) / 3, with faint billows."""
    falls = everything @ LUMINANCE * _OVERCAST_SHARE
    if light.lamps_on:
        falls = everything @ LUMINANCE  # Clouds throw the town's light back.
    zenith = falls * 9 / (7 * np.pi)
    # Near the horizon all is one grey, which is also the colour of the air.
    sharp = smoothstep(toward[..., 2].astype(np.float32), *_CLOUD_FOOT)
    billows = 1 + 0.07 * sharp * _cloud_field(light, toward, 0.7)
    level = zenith * (1 + 2 * np.maximum(toward[..., 2], 0)) / 3 * billows
    return level[..., None] * _OVERCAST_TINT


def _clouded(
    light: Light, toward: np.ndarray, clear: np.ndarray, everything: np.ndarray
) -> np.ndarray:
    """Cumulus over the clear sky: white where thin or turned to the sun, grey at their bases."""
    field = _cloud_field(light, toward, 0.45)
    # The field is standard normal: cover is a quantile of it.
    edge = float(np.quantile(field[: field.shape[0] // 2], 1 - min(light.cloud_cover, 0.97)))
    depth = smoothstep(field, edge - 0.1, edge + 1.4)
    alpha = smoothstep(field, edge - 0.12, edge + 0.22)
    alpha = alpha * smoothstep(toward[..., 2].astype(np.float32), *_CLOUD_FOOT)
    away = np.arccos(np.clip(toward @ light.sun_direction, -1, 1))
    rim = 1 + 1.2 * np.exp(-away / 0.35) * (1 - depth)
    white = 0.75 * everything / np.pi
    cloud = (white * np.array([1.0, 1.0, 1.02])) * ((1 - 0.62 * depth) * rim)[..., None]
    return clear + alpha[..., None] * (cloud - clear)


def _cloud_field(light: Light, toward: np.ndarray, falloff: float) -> np.ndarray:
    """Standard-normal noise on a flat cloud base, seen from below, (h, w) float32."""
    rng = lane(light.cloud_seed, "clouds")
    tile = fractal_noise(rng, (512, 512), (2, 160), falloff)
    scale = rng.uniform(0.05, 0.12)
    plane = toward[..., :2] / (np.maximum(toward[..., 2:], 0) + 0.09)
    at = np.moveaxis(plane, -1, 0) * scale * 512
    return ndimage.map_coordinates(tile, at, order=1, mode="grid-wrap").astype(np.float32)
