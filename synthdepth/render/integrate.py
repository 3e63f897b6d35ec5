"""Camera samples: radiance through haze, with the denoiser's guides, in one kernel.

Outdoors by day there are two lights, and each has one good way to be sampled: the sun is a point,
found by a shadow ray at every hit; the sky is everywhere, found by the scattered ray that misses.
A path has two hits. What would reach the second one by way of a third is estimated: at 4 samples a
pixel that is as near to the truth as tracing it (tools/render_quality.py), for half the rays.

No film: samples of a pixel lie side by side and are summed in order, which takes no atomic
additions (they cost a quarter of the frame) and gives the same bits for any number of threads.
"""

# Annotations stay text: Mitsuba has no types before a variant is set.
from __future__ import annotations

import dataclasses

import drjit as dr
import mitsuba as mi

# Contrast at the meteorological visibility is 2 %: exp(-KOSCHMIEDER) (Koschmieder 1924).
KOSCHMIEDER = 3.912
# Thickness of the hazy layer seen from below: limits the haze in front of the sky.
HAZE_LAYER_M = 1000.0
# Where the air's own light is taken from the sky: sine of the elevation.
AIRLIGHT_SINE = 0.05
# Half the sun's angle, as a slope.
SUN_SLOPE = 0.004675
# What a second hit gets from beyond: share of the sky that it sees, and reflectance of the rest.
_SKY_SEEN, _REST_REFLECTS = 0.6, 0.1


@dataclasses.dataclass
class Lights:
    """The lights of a scene as JIT values, so that another scene compiles nothing.

    Attributes:
        sun: frame whose n points to the sun.
        sun_irradiance: on a surface that faces the sun.
        sky_irradiance: on open level ground.
        visibility_m: meteorological visibility.
        limit: samples of more radiance are fireflies and are cut.
    """

    sun: mi.Frame3f
    sun_irradiance: mi.Color3f
    sky_irradiance: mi.Color3f
    visibility_m: mi.Float
    limit: mi.Float


def camera_samples(scene, sampler, seed, size, settings, lights: Lights) -> list:
    """Mean radiance, guide albedo and guide normal of every pixel: 9 arrays of width * height.

    The guides are those of the first hit, faded by the haze as the radiance is, so that the
    denoiser does not look for texture where the air hides it.

    Args:
        scene: with one sensor, and the sky without its sun as environment.
        sampler: an independent sampler.
        seed: UInt32, opaque.
        size: (width, height) [px].
        settings: samples a pixel.
        lights: sun, sky and air.
    """
    (width, height), spp = size, settings.spp
    count = width * height * spp
    sampler = sampler.fork()
    sampler.set_samples_per_wavefront(spp)
    sampler.seed(seed, count)
    pixel = dr.arange(mi.UInt32, count) // spp
    shake = sampler.next_2d()
    x = (mi.Float(pixel % width) + shake.x) / width
    y = (mi.Float(pixel // width) + shake.y) / height
    ray, _ = scene.sensors()[0].sample_ray(0.0, 0.5, mi.Point2f(x, y), mi.Point2f(0.5))

    hit = scene.ray_intersect_preliminary(ray, coherent=True)
    si = hit.compute_surface_interaction(ray, mi.RayFlags.All)
    found = si.is_valid()
    bsdf = si.bsdf()
    albedo = bsdf.eval_diffuse_reflectance(si, found)
    radiance = _sun_at(scene, sampler, si, bsdf, lights, found)
    radiance += _scattered(scene, sampler, si, bsdf, lights, found)
    radiance = dr.select(found, radiance, scene.environment().eval(si) + _sun_disc(ray.d, lights))
    # A grazing glossy bounce can divide by zero: one such sample would blacken a denoised patch.
    usable = dr.all(dr.isfinite(radiance))
    radiance = dr.select(usable, dr.minimum(radiance, lights.limit), 0.0)

    sky_m = HAZE_LAYER_M / dr.maximum(ray.d.z, 0.01)
    clear = dr.exp(-KOSCHMIEDER / lights.visibility_m * dr.select(found, si.t, sky_m))
    # Airlight: the sky just above the horizon in the same direction.
    horizon = dr.zeros(mi.SurfaceInteraction3f)
    horizon.wi = -dr.normalize(mi.Vector3f(ray.d.x, ray.d.y + 1e-6, AIRLIGHT_SINE))
    air = scene.environment().eval(horizon)

    radiance = dr.lerp(air, radiance, clear)
    guide = dr.select(found, dr.lerp(1.0, albedo, clear), 1.0)
    normal = dr.select(found, si.sh_frame.n * clear, 0.0)
    channels = [*radiance, *guide, *normal]
    # One evaluation for all nine; each sum alone would trace the paths again.
    dr.eval(channels)
    return [dr.block_sum(channel, spp) / spp for channel in channels]


def _sun_at(scene, sampler, si, bsdf, lights, active):
    """Sunlight that a hit reflects: one shadow ray to a point of the sun's disc."""
    disc = mi.warp.square_to_uniform_disk_concentric(sampler.next_2d()) * SUN_SLOPE
    toward = dr.normalize(lights.sun.to_world(mi.Vector3f(disc.x, disc.y, 1.0)))
    value = bsdf.eval(mi.BSDFContext(), si, si.to_local(toward), active)
    lit = active & dr.any(value > 0)
    shadow = scene.ray_test(si.spawn_ray(toward), lit)
    return dr.select(lit & ~shadow, value * lights.sun_irradiance, 0.0)


def _scattered(scene, sampler, si, bsdf, lights, active):
    """Light by way of one scattered ray: the sky where it misses, a lit surface where it hits."""
    sample, weight = bsdf.sample(
        mi.BSDFContext(), si, sampler.next_1d(active), sampler.next_2d(active), active
    )
    active = active & dr.any(weight > 0)
    second = scene.ray_intersect(si.spawn_ray(si.to_world(sample.wo)), active)
    found = second.is_valid() & active
    there = second.bsdf()
    light = _sun_at(scene, sampler, second, there, lights, found)
    up = 0.5 + 0.5 * second.sh_frame.n.z * dr.sign(second.wi.z)
    sky = lights.sky_irradiance * (_SKY_SEEN * up)
    sun = lights.sun_irradiance * dr.maximum(lights.sun.n.z, 0)
    rest = (lights.sky_irradiance + sun) * (_REST_REFLECTS * (1 - up))
    light += there.eval_diffuse_reflectance(second, found) * (sky + rest) * dr.inv_pi
    miss = active & ~found
    return weight * dr.select(found, light, scene.environment().eval(second, miss))


def _sun_disc(direction, lights):
    """The sun itself, for those who look into it."""
    inside = dr.dot(direction, lights.sun.n) > dr.rsqrt(1 + SUN_SLOPE**2)
    return dr.select(inside, lights.sun_irradiance / (dr.pi * SUN_SLOPE**2), 0.0)
