"""Pictures and ground truth of a world: what a worker calls once a frame."""

# Annotations stay text: Mitsuba has no types before a variant is set.
from __future__ import annotations

import dataclasses

import drjit as dr
import mitsuba as mi
import numpy as np
from mitsuba_oidn import Quality, denoise

from synthdepth.camera import Intrinsics
from synthdepth.maps.world import World
from synthdepth.render.atlas import pack
from synthdepth.render.colour import LUMINANCE, to_uint8
from synthdepth.render.integrate import LampGrid, Lights, View, camera_samples, lamp_grid
from synthdepth.render.lamps import LIGHTING_CDM2, Lamps, find_lamps
from synthdepth.render.scene import build_scene, sky_emitter
from synthdepth.render.sensor import Motion
from synthdepth.render.settings import RenderSettings
from synthdepth.render.sky import LUX, Sky, make_sky

# A sample brighter than this many sunlit white cards is a firefly, not picture content.
_FIREFLY_WHITES = 20.0
# Display-linear value of a sunlit white card at a correct exposure. Above 1, as cameras expose for
# a world that is much darker than a white card; the shoulder keeps its highlights.
_WHITE_LEVEL = 1.7
# A low sun lights walls rather than the ground: exposure counts it as if it stood this high.
_LEAST_SINE = 0.6
# At night what only the moon lights stays dark,
_NIGHT_STOPS = 1.3
# and a camera exposes for what the lamps light: this quantile of it, over the flight area.
_LAMP_QUANTILE, _LAMP_SHARE, _LAMP_POINTS = 0.8, 0.4, 24


@dataclasses.dataclass(frozen=True)
class Surfels:
    """What the rays through the pixel centres hit.

    Attributes:
        depth_m: (H, W) float32 unsaturated planar depth [m]; the sky is inf.
        label: (H, W) uint8, a value of `LABELS`; the sky is 0.
        normal: (H, W, 3) float32 unit normals in camera axes, turned to the camera; the sky is 0.
    """

    depth_m: np.ndarray
    label: np.ndarray
    normal: np.ndarray


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

    def __init__(self, world: World, camera: Intrinsics, settings: RenderSettings):
        self.camera, self._light = camera, world.light
        self.sky = make_sky(world.light)
        atlas = pack(world.materials)
        self.scene = build_scene(world, camera, atlas, self._emitters(self.sky))
        self._params = mi.traverse(self.scene)
        self._rays = camera.rays().reshape(-1, 3)
        lamps = find_lamps(world, atlas) if world.light.lamps_on else None
        level = self.sky.irradiance @ LUMINANCE
        level += self.sky.beam @ LUMINANCE * max(world.light.sun_direction[2], _LEAST_SINE)
        if world.light.lamps_on:
            level *= 2.0**_NIGHT_STOPS
        if lamps is not None:
            level += _LAMP_SHARE * _typical(lamps, world)
        white = float(level) / np.pi
        self.exposure = float(_WHITE_LEVEL / white)
        self._limit = _FIREFLY_WHITES * white
        self._prepare(world, atlas, lamps)
        self.set_settings(settings)

    def _emitters(self, sky: Sky) -> dict:
        """What lights the scene from above, but for the sun: our integrator adds it itself."""
        return {"sky": sky_emitter(sky)}

    def _prepare(self, world: World, atlas, lamps: Lamps | None) -> None:
        luminance = [world.materials[name].luminance_cdm2 * LUX for name in atlas.index]
        grid = None
        if world.light.lamps_on and (lamps is not None or any(luminance)):
            lights_nothing = [0.0 if v >= LIGHTING_CDM2 * LUX else v for v in luminance]
            grid = lamp_grid(lamps or _no_lamps(), luminance, lights_nothing)
        self._lights = self._jit_lights(grid)
        self._trace = dr.freeze(self._trace_once)
        self._trace_surfels = dr.freeze(self._trace_surfels_once)

    def _jit_lights(self, grid: LampGrid | None) -> Lights:
        lights = Lights(
            sun=mi.Frame3f(mi.Normal3f(*self._light.sun_direction.tolist())),
            sun_irradiance=mi.Color3f(*self.sky.beam.tolist()),
            sky_irradiance=mi.Color3f(*self.sky.irradiance.tolist()),
            visibility_m=mi.Float(self._light.visibility_m),
            limit=mi.Float(self._limit),
            lamps=grid,
        )
        dr.make_opaque(lights)
        return lights

    def set_settings(self, settings: RenderSettings) -> None:
        """Render with other samples or denoising from now on; compiles a new kernel."""
        self.settings = settings
        self._sampler = mi.load_dict({"type": "independent", "sample_count": settings.spp})
        self._samples = dr.freeze(self._samples_once)

    def _samples_once(self, scene, seed, lights, view):
        return camera_samples(
            scene, self._sampler, seed, self.camera, self.settings.spp, lights, view
        )

    def noisy(
        self, world_from_cam: np.ndarray, seed: int, motion: Motion | None = None
    ) -> np.ndarray:
        """Radiance, guide albedo and guide normal before denoising, (H, W, 9) float32.

        Args:
            world_from_cam: (4, 4) pose at mid-exposure.
            seed: the frame's number; every number is another noise pattern.
            motion: of the camera during the exposure; none by default.
        """
        columns = [world_from_cam[:3, k].tolist() for k in range(4)]
        still = np.zeros(3)
        view = View(
            mi.Point3f(*columns[3]),
            mi.Vector3f(*columns[0]),
            mi.Vector3f(*columns[1]),
            mi.Vector3f(*columns[2]),
            mi.Vector3f(*(motion.moved_m if motion else still).tolist()),
            mi.Vector3f(*(motion.turned_rad if motion else still).tolist()),
        )
        dr.make_opaque(view)
        channels = self._samples(self.scene, dr.opaque(mi.UInt32, seed), self._lights, view)
        stacked = np.stack([channel.numpy() for channel in channels], axis=-1)
        return stacked.reshape(self.camera.height, self.camera.width, 9)

    def radiance(
        self, world_from_cam: np.ndarray, seed: int, motion: Motion | None = None
    ) -> np.ndarray:
        """Radiance before exposure, (H, W, 3) float32, denoised as the settings say."""
        noisy = self.noisy(world_from_cam, seed, motion)
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
        """The frame of an ideal camera as 8-bit sRGB, (H, W, 3) uint8."""
        return to_uint8(self.radiance(world_from_cam, seed), self.exposure)

    def _trace_once(self, scene, origin, direction):
        return scene.ray_intersect_preliminary(mi.Ray3f(origin, direction), coherent=True).t

    def _trace_surfels_once(self, scene, origin, direction):
        ray = mi.Ray3f(origin, direction)
        hit = scene.ray_intersect_preliminary(ray, coherent=True)
        si = hit.compute_surface_interaction(ray, mi.RayFlags.Minimal)
        found = hit.is_valid()
        label = dr.select(found, si.shape.eval_attribute_1("face_label", si, found), 0.0)
        normal = dr.select(found, si.n, 0.0)
        return hit.t, mi.UInt32(label), normal

    def _rays_from(self, world_from_cam: np.ndarray, direction: np.ndarray):
        direction = np.ascontiguousarray(direction.T, np.float32)
        origin = np.broadcast_to(world_from_cam[:3, 3].astype(np.float32)[:, None], direction.shape)
        return mi.Point3f(np.ascontiguousarray(origin)), mi.Vector3f(direction)

    def reach(self, world_from_cam: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """How far rays from the camera's position get, (n,) float32.

        Args:
            world_from_cam: (4, 4) pose.
            direction: (n, 3), world axes, of any length.

        Returns:
            The distance to the first surface in lengths of `direction`; inf where there is none.
        """
        return self._trace(self.scene, *self._rays_from(world_from_cam, direction)).numpy()

    def _hits(self, world_from_cam: np.ndarray, direction: np.ndarray):
        """`reach`, labels (n,) and normals (n, 3)."""
        rays = self._rays_from(world_from_cam, direction)
        t, label, normal = self._trace_surfels(self.scene, *rays)
        return t.numpy(), label.numpy(), normal.numpy().T

    def _through_pixels(self, world_from_cam: np.ndarray) -> np.ndarray:
        # Directions have z = 1 in the camera, so the ray parameter is the planar depth itself.
        return self._rays @ world_from_cam[:3, :3].T

    def planar_depth(self, world_from_cam: np.ndarray) -> np.ndarray:
        """Unsaturated planar depth at the pixel centres, (H, W) float32 [m]; the sky is inf."""
        t = self.reach(world_from_cam, self._through_pixels(world_from_cam))
        return t.reshape(self.camera.height, self.camera.width)

    def surfels(self, world_from_cam: np.ndarray) -> Surfels:
        """Depth as `planar_depth` has it, with labels and normals."""
        rays = self._through_pixels(world_from_cam)
        t, label, n = self._hits(world_from_cam, rays)
        shape = (self.camera.height, self.camera.width)
        away = np.einsum("nx,nx->n", n, rays) > 0
        n = np.where(away[:, None], -n, n) @ world_from_cam[:3, :3]
        return Surfels(
            depth_m=t.reshape(shape),
            label=label.astype(np.uint8).reshape(shape),
            normal=n.astype(np.float32).reshape(*shape, 3),
        )


def _typical(lamps: Lamps, world: World) -> float:
    """What the lamps give the brighter places of the flight area, without shadows."""
    low, high = world.flight_bounds
    x, y = (np.linspace(low[k], high[k], _LAMP_POINTS) for k in range(2))
    places = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    places = np.column_stack([places, world.ground_m(places)])
    return float(np.quantile(lamps.irradiance(places) @ LUMINANCE, _LAMP_QUANTILE))


def _no_lamps() -> Lamps:
    """A grid that covers nothing, for a night with lit windows and no lamps."""
    return Lamps(
        table=np.zeros((1, 12), np.float32),
        corner=np.zeros(2),
        cells=(0, 0),
        candidates=np.zeros((1, 1), np.int64),
        cumulative=np.ones((1, 1), np.float32),
    )
