"""Pictures and ground truth of a world: what a worker calls once a frame."""

import drjit as dr
import mitsuba as mi
import numpy as np
from mitsuba_oidn import Quality, denoise

from synthdepth.camera import Intrinsics
from synthdepth.maps.world import World
from synthdepth.render.colour import to_uint8
from synthdepth.render.integrate import camera_samples
from synthdepth.render.scene import build_scene, to_world
from synthdepth.render.settings import RenderSettings

# A sample brighter than this many sunlit white cards is a firefly, not picture content.
_FIREFLY_WHITES = 20.0
# Display-linear value of a sunlit white card at a correct exposure. Above 1, as cameras expose for
# a world that is much darker than a white card; the shoulder keeps its highlights.
_WHITE_LEVEL = 1.7


def _frozen(function):
    """The function with its kernels recorded once, where the variant compiles any."""
    return dr.freeze(function) if dr.is_jit_v(mi.Float) else function


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

    def __init__(self, world: World, camera: Intrinsics, settings: RenderSettings):
        self.camera = camera
        self.scene = build_scene(world, camera)
        self._params = mi.traverse(self.scene)
        self._rays = camera.rays().reshape(-1, 3)
        white = self._white_radiance()
        self._visibility_m = dr.opaque(mi.Float, world.light.visibility_m)
        self._radiance_limit = dr.opaque(mi.Float, _FIREFLY_WHITES * white)
        self.exposure = float(_WHITE_LEVEL / white * 2.0**world.light.exposure_ev)
        self._trace = _frozen(self._trace_once)
        self.set_settings(settings)

    def set_settings(self, settings: RenderSettings) -> None:
        """Render with other samples or denoising from now on; compiles a new kernel."""
        self.settings = settings
        self._sampler = mi.load_dict({"type": "independent", "sample_count": settings.spp})
        self._samples = _frozen(self._samples_once)

    def _white_radiance(self) -> float:
        """Radiance of a white card lying in the open: irradiance of sun and sky over pi."""
        n = 64
        grid = (np.stack(np.meshgrid(np.arange(n), np.arange(n)), -1).reshape(-1, 2) + 0.5) / n
        total = 0.0
        emitter = self.scene.environment()
        point = dr.zeros(mi.Interaction3f)
        if dr.is_jit_v(mi.Float):
            samples = mi.Point2f(*np.ascontiguousarray(grid.T, np.float32))
            found, weight = emitter.sample_direction(point, samples)
            value = mi.luminance(mi.Color3f(weight)) * dr.maximum(found.d.z, 0)
            return float(np.mean(value.numpy())) / np.pi
        for x, y in grid:
            found, weight = emitter.sample_direction(point, mi.Point2f(x, y))
            total += mi.luminance(mi.Color3f(weight)) * max(found.d.z, 0)
        return total / len(grid) / np.pi

    def _samples_once(self, scene, seed, visibility_m, radiance_limit):
        size = (self.camera.width, self.camera.height)
        return camera_samples(
            scene, self._sampler, seed, size, self.settings, visibility_m, radiance_limit
        )

    def noisy(self, world_from_cam: np.ndarray, seed: int) -> np.ndarray:
        """Radiance, guide albedo and guide normal before denoising, (H, W, 9) float32.

        Args:
            world_from_cam: (4, 4) pose.
            seed: the frame's number; every number is another noise pattern.
        """
        self._params["camera.to_world"] = to_world(world_from_cam)
        self._params.update()
        channels = self._samples(
            self.scene, dr.opaque(mi.UInt32, seed), self._visibility_m, self._radiance_limit
        )
        stacked = np.stack([channel.numpy() for channel in channels], axis=-1)
        return stacked.reshape(self.camera.height, self.camera.width, 9)

    def radiance(self, world_from_cam: np.ndarray, seed: int) -> np.ndarray:
        """Radiance before exposure, (H, W, 3) float32, denoised as the settings say."""
        noisy = self.noisy(world_from_cam, seed)
        colour = np.ascontiguousarray(noisy[..., :3])
        if self.settings.denoise == "off":
            return colour
        return denoise(
            colour,
            np.ascontiguousarray(np.clip(noisy[..., 3:6], 0, 1)),
            np.ascontiguousarray(noisy[..., 6:9]),
            hdr=True,
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
        if dr.is_jit_v(mi.Float):
            o, d = (mi.Vector3f(np.ascontiguousarray(a.T)) for a in (origin, direction))
            t = self._trace(self.scene, mi.Point3f(o), d).numpy()
        else:
            rays = zip(origin.tolist(), direction.tolist(), strict=True)
            t = np.array([self._trace(self.scene, o, d) for o, d in rays], np.float32)
        return t.reshape(self.camera.height, self.camera.width)
