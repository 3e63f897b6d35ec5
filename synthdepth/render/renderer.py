"""Pictures and ground truth of a world: what a worker calls once a frame."""

# Annotations stay text: Mitsuba has no types before a variant is set.
from __future__ import annotations

import drjit as dr
import mitsuba as mi
import numpy as np
from mitsuba_oidn import Quality, denoise

from synthdepth.camera import Intrinsics
from synthdepth.maps.world import World
from synthdepth.render.colour import LUMINANCE, to_uint8
from synthdepth.render.integrate import SUN_SLOPE, Lights, camera_samples
from synthdepth.render.scene import build_scene, sunsky, to_world
from synthdepth.render.settings import RenderSettings

# A sample brighter than this many sunlit white cards is a firefly, not picture content.
_FIREFLY_WHITES = 20.0
# Display-linear value of a sunlit white card at a correct exposure. Above 1, as cameras expose for
# a world that is much darker than a white card; the shoulder keeps its highlights.
_WHITE_LEVEL = 1.7
_LIGHT_SAMPLES = 96


def load_world(world: World, camera: Intrinsics, settings: RenderSettings) -> Renderer:
    """The renderer of a world, for the variant that is active."""
    if dr.is_jit_v(mi.Float):
        return Renderer(world, camera, settings)
    from synthdepth.render.scalar import ScalarRenderer

    return ScalarRenderer(world, camera, settings)


class Renderer:
    """A world loaded into Mitsuba, ready to be looked at from any pose.

    Args:
        world: the generated world.
        camera: intrinsics; fx and fy must be equal.
        settings: samples and denoising.

    `synthdepth.render.backend.activate` must have been called in this process. One world a process:
    Dr.Jit compiles virtual calls over every object that was ever loaded, so that a second world
    makes both slow.
    """

    _sky_with_sun = False

    def __init__(self, world: World, camera: Intrinsics, settings: RenderSettings):
        self.camera, self._light = camera, world.light
        self.scene = build_scene(world, camera, with_sun=self._sky_with_sun)
        self._params = mi.traverse(self.scene)
        self._rays = camera.rays().reshape(-1, 3)
        sun, sky = self._irradiance()
        white = float((sun + sky) @ LUMINANCE) / np.pi
        self.exposure = float(_WHITE_LEVEL / white)
        self._limit = _FIREFLY_WHITES * white
        self._lights = self._jit_lights(sun, sky)
        self._trace = self._compiled(self._trace_once)
        self.set_settings(settings)

    def _compiled(self, function):
        """The function with its kernels recorded once."""
        return dr.freeze(function)

    def set_settings(self, settings: RenderSettings) -> None:
        """Render with other samples or denoising from now on; compiles a new kernel."""
        self.settings = settings
        self._sampler = mi.load_dict({"type": "independent", "sample_count": settings.spp})
        self._samples = self._compiled(self._samples_once)

    def _irradiance(self) -> tuple[np.ndarray, np.ndarray]:
        """Irradiance of level ground by sun and by sky, (3,) each."""
        side = (np.arange(_LIGHT_SAMPLES) + 0.5) / _LIGHT_SAMPLES
        grid = np.stack(np.meshgrid(side, side)).reshape(2, -1).astype(np.float32)
        environment = self.scene.environment()
        found, weight = environment.sample_direction(dr.zeros(mi.Interaction3f), mi.Point2f(grid))
        sky = (mi.Color3f(weight) * dr.maximum(found.d.z, 0)).numpy().mean(axis=1)

        # The sun's radiance is what the sky with it has more than the one without it.
        with_sun = mi.load_dict(sunsky(self._light, with_sun=True))
        disc = mi.warp.square_to_uniform_disk_concentric(mi.Point2f(grid)) * (2 * SUN_SLOPE)
        si = dr.zeros(mi.SurfaceInteraction3f)
        toward = self._sun_frame().to_world(mi.Vector3f(disc.x, disc.y, 1.0))
        si.wi = -dr.normalize(toward)
        excess = (with_sun.eval(si) - environment.eval(si)).numpy().mean(axis=1)
        solid_angle = np.pi * (2 * SUN_SLOPE) ** 2
        return excess * solid_angle * self._light.sun_direction[2], sky

    def _sun_frame(self) -> mi.Frame3f:
        return mi.Frame3f(mi.Normal3f(*self._light.sun_direction.tolist()))

    def _jit_lights(self, sun: np.ndarray, sky: np.ndarray) -> Lights:
        facing = np.maximum(sun / self._light.sun_direction[2], 0)
        lights = Lights(
            sun=self._sun_frame(),
            sun_irradiance=mi.Color3f(*facing.tolist()),
            sky_irradiance=mi.Color3f(*sky.tolist()),
            visibility_m=mi.Float(self._light.visibility_m),
            limit=mi.Float(self._limit),
        )
        dr.make_opaque(lights)
        return lights

    def _samples_once(self, scene, seed, lights):
        size = (self.camera.width, self.camera.height)
        return camera_samples(scene, self._sampler, seed, size, self.settings, lights)

    def noisy(self, world_from_cam: np.ndarray, seed: int) -> np.ndarray:
        """Radiance, guide albedo and guide normal before denoising, (H, W, 9) float32.

        Args:
            world_from_cam: (4, 4) pose.
            seed: the frame's number; every number is another noise pattern.
        """
        self._params["camera.to_world"] = to_world(world_from_cam)
        self._params.update()
        channels = self._samples(self.scene, dr.opaque(mi.UInt32, seed), self._lights)
        stacked = np.stack([channel.numpy() for channel in channels], axis=-1)
        return stacked.reshape(self.camera.height, self.camera.width, 9)

    def radiance(self, world_from_cam: np.ndarray, seed: int) -> np.ndarray:
        """Radiance before exposure, (H, W, 3) float32, denoised as the settings say."""
        noisy = self.noisy(world_from_cam, seed)
        colour = np.ascontiguousarray(noisy[..., :3])
        if self.settings.denoise == "off":
            return colour
        guides = (
            np.ascontiguousarray(np.clip(noisy[..., 3:6], 0, 1)),
            np.ascontiguousarray(noisy[..., 6:9]),
        )
        return denoise(
            colour,
            *(guides if noisy.shape[-1] == 9 else ()),
            hdr=True,
            # OIDN's own estimate sums in an order that depends on the number of threads.
            input_scale=self.exposure,
            quality=getattr(Quality, self.settings.denoise.capitalize()),
        )

    def rgb(self, world_from_cam: np.ndarray, seed: int) -> np.ndarray:
        """The frame as 8-bit sRGB, (H, W, 3) uint8."""
        return to_uint8(self.radiance(world_from_cam, seed), self.exposure)

    def _trace_once(self, scene, origin, direction):
        # Directions have z = 1 in the camera, so the ray parameter is the planar depth itself.
        return scene.ray_intersect_preliminary(mi.Ray3f(origin, direction), coherent=True).t

    def planar_depth(self, world_from_cam: np.ndarray) -> np.ndarray:
        """Unsaturated planar depth at the pixel centres, (H, W) float32 [m]; the sky is inf."""
        direction = (self._rays @ world_from_cam[:3, :3].T).astype(np.float32)
        origin = np.broadcast_to(world_from_cam[:3, 3].astype(np.float32), direction.shape)
        o, d = (mi.Vector3f(np.ascontiguousarray(a.T)) for a in (origin, direction))
        t = self._trace(self.scene, mi.Point3f(o), d).numpy()
        return t.reshape(self.camera.height, self.camera.width)
