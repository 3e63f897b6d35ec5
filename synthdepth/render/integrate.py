"""Camera samples: radiance through haze, with the denoiser's guides, in one kernel.

No film: samples of a pixel lie side by side and are summed in order, which takes no atomic
additions (they cost a quarter of the frame) and gives the same bits for any number of threads.
"""

import drjit as dr
import mitsuba as mi

# Contrast at the meteorological visibility is 2 %: exp(-KOSCHMIEDER) (Koschmieder 1924).
KOSCHMIEDER = 3.912
# Thickness of the hazy layer seen from below: limits the haze in front of the sky.
_HAZE_LAYER_M = 1000.0
# Where the air's own light is taken from the sky: sine of the elevation.
_AIRLIGHT_SINE = 0.05


def camera_samples(scene, sampler, seed, size, settings, visibility_m, radiance_limit) -> list:
    """Mean radiance, guide albedo and guide normal of every pixel: 9 arrays of width * height.

    The guides are those of the first hit, faded by the haze as the radiance is, so that the
    denoiser does not look for texture where the air hides it.

    Args:
        scene: with one sensor and an environment.
        sampler: an independent sampler.
        seed: UInt32, opaque.
        size: (width, height) [px].
        settings: samples a pixel and longest path.
        visibility_m: Float, opaque.
        radiance_limit: Float, opaque; samples above it are fireflies and are cut.
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

    path = mi.load_dict({"type": "path", "max_depth": settings.path_depth})
    radiance, _, _ = path.sample(scene, sampler, ray)
    radiance = dr.minimum(radiance, radiance_limit)

    hit = scene.ray_intersect_preliminary(ray, coherent=True)
    si = hit.compute_surface_interaction(ray, mi.RayFlags.All)
    found = si.is_valid()
    albedo = si.bsdf().eval_diffuse_reflectance(si, found)
    sky_m = _HAZE_LAYER_M / dr.maximum(ray.d.z, 0.01)
    clear = dr.exp(-KOSCHMIEDER / visibility_m * dr.select(found, si.t, sky_m))
    # Airlight: the sky just above the horizon in the same direction.
    horizon = dr.zeros(mi.SurfaceInteraction3f)
    horizon.wi = -dr.normalize(mi.Vector3f(ray.d.x, ray.d.y + 1e-6, _AIRLIGHT_SINE))
    air = scene.environment().eval(horizon)

    radiance = dr.lerp(air, radiance, clear)
    guide = dr.select(found, dr.lerp(1.0, albedo, clear), 1.0)
    normal = dr.select(found, si.sh_frame.n * clear, 0.0)
    channels = [*radiance, *guide, *normal]
    # One evaluation for all nine; each sum alone would trace the paths again.
    dr.eval(channels)
    return [dr.block_sum(channel, spp) / spp for channel in channels]
