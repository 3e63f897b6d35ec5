"""Our two Mitsuba plugins: the tinted texture, and the camera integrator with guides and haze.

They are defined inside a function because their base classes exist only once a variant is set.
"""

import functools

import drjit as dr
import mitsuba as mi

# Contrast at the meteorological visibility is 2 %: exp(-KOSCHMIEDER) (Koschmieder 1924).
KOSCHMIEDER = 3.912
# Thickness of the hazy layer seen from below: limits the haze in front of the sky.
_HAZE_LAYER_M = 1000.0
_HORIZON_M = 1e5


@functools.cache
def register_plugins() -> None:
    """Make `tinted` and `camera_path` known to the active variant; done once a process."""

    class Tinted(mi.Texture):
        """A bitmap times a mesh attribute: thousands of colours from one material."""

        def __init__(self, props):
            mi.Texture.__init__(self, props)
            self.base, self.tint = props["base"], props["tint"]

        def eval(self, si, active=True):
            return self.base.eval(si, active) * self.tint.eval(si, active)

        def mean(self):
            return self.base.mean()

        def is_spatially_varying(self):
            return True

    class CameraPath(mi.SamplingIntegrator):
        """Radiance through haze, with first-hit albedo and normal as guides, in one kernel.

        Channels 3-5 hold the albedo, 6-8 the normal. The guides go through the same haze as the
        radiance, so that the denoiser does not look for texture where the air hides it.
        """

        def __init__(self, props):
            mi.SamplingIntegrator.__init__(self, props)
            self.path = mi.load_dict({"type": "path", "max_depth": props["max_depth"]})
            # Set inside the frozen call, so that a new scene's air compiles nothing.
            self.visibility_m = self.radiance_limit = None

        def sample(self, scene, sampler, ray, medium=None, active=True):
            radiance, valid, _ = self.path.sample(scene, sampler, ray, medium, active)
            hit = scene.ray_intersect_preliminary(ray, coherent=True, active=active)
            si = hit.compute_surface_interaction(ray, mi.RayFlags.All, active)
            found = si.is_valid()

            albedo = si.bsdf(ray).eval_diffuse_reflectance(si, found & active)
            sky_m = _HAZE_LAYER_M / dr.maximum(ray.d.z, 0.02)
            distance_m = dr.select(found, si.t, dr.minimum(sky_m, _HORIZON_M))
            clear = dr.exp(-KOSCHMIEDER / self.visibility_m * distance_m)
            # Airlight: the sky just above the horizon in the same direction.
            level = mi.Vector3f(ray.d.x, ray.d.y, 0.0)
            level = dr.normalize(level + mi.Vector3f(1e-6, 0, 0))
            sky = dr.zeros(mi.SurfaceInteraction3f)
            sky.wi = -dr.normalize(level + mi.Vector3f(0, 0, 0.05))
            air = scene.environment().eval(sky, active)
            radiance = dr.minimum(radiance, self.radiance_limit)
            radiance = dr.lerp(air, radiance, clear)

            guide = dr.select(found, dr.lerp(1.0, albedo, clear), 1.0)
            normal = dr.select(found, si.sh_frame.n * clear, 0.0)
            channels = [guide.x, guide.y, guide.z, normal.x, normal.y, normal.z]
            return radiance, valid, channels

        def aov_names(self):
            return ["albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z"]

    mi.register_texture("tinted", Tinted)
    mi.register_integrator("camera_path", CameraPath)
