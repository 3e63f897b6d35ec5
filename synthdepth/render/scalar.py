"""Rendering without a JIT compiler: for machines on which no libLLVM works.

Slow, and plainer: one colour a vertex instead of textures, no guides for the denoiser, haze added a
pixel at a time, no motion blur, no lamps at night. Ground truth is the same to float rounding.
"""

import mitsuba as mi
import numpy as np

from synthdepth.maps.world import World
from synthdepth.render.integrate import AIRLIGHT_SINE, HAZE_LAYER_M, KOSCHMIEDER
from synthdepth.render.renderer import Renderer
from synthdepth.render.scene import sky_emitter, to_world
from synthdepth.render.sensor import Motion
from synthdepth.render.settings import RenderSettings
from synthdepth.render.sky import Sky

_AZIMUTHS = 72


class ScalarRenderer(Renderer):
    """A `Renderer` for the variant scalar_rgb."""

    def _emitters(self, sky: Sky) -> dict:
        sun = {
            "type": "directional",
            "direction": (-self._light.sun_direction).tolist(),
            "irradiance": {"type": "rgb", "value": sky.beam.tolist()},
        }
        return {"sky": sky_emitter(sky), "sun": sun}

    def _prepare(self, world: World, atlas, lamps) -> None:
        """Nothing is recorded."""

    def set_settings(self, settings: RenderSettings) -> None:
        """Render with other samples or denoising from now on."""
        self.settings = settings
        self._path = mi.load_dict({"type": "path", "max_depth": 3})

    def noisy(
        self, world_from_cam: np.ndarray, seed: int, motion: Motion | None = None
    ) -> np.ndarray:
        """Radiance before denoising, (H, W, 3) float32; there are no guides and no blur."""
        self._params["camera.to_world"] = to_world(world_from_cam)
        self._params.update()
        image = mi.render(self.scene, integrator=self._path, spp=self.settings.spp, seed=seed)
        radiance = np.array(image, np.float32)
        rays = self._rays @ world_from_cam[:3, :3].T
        length = np.linalg.norm(rays, axis=1)
        distance_m = self.planar_depth(world_from_cam).ravel() * length
        sky_m = HAZE_LAYER_M / np.maximum(rays[:, 2] / length, 0.01)
        distance_m = np.where(np.isfinite(distance_m), distance_m, sky_m)
        clear = np.exp(-KOSCHMIEDER / self._light.visibility_m * distance_m)
        clear = clear.reshape(*radiance.shape[:2], 1)
        azimuth = np.arctan2(rays[:, 1], rays[:, 0])
        air = self._airlight(azimuth).reshape(radiance.shape)
        return (air + clear * (radiance - air)).astype(np.float32)

    def _airlight(self, azimuth_rad: np.ndarray) -> np.ndarray:
        """Light of the sky just above the horizon, (n, 3)."""
        around = np.linspace(-np.pi, np.pi, _AZIMUTHS + 1)
        colours = []
        for a in around.tolist():
            si = mi.SurfaceInteraction3f()
            toward = np.array([np.cos(a), np.sin(a), AIRLIGHT_SINE])
            si.wi = mi.Vector3f(*(-toward / np.linalg.norm(toward)).tolist())
            colours.append(list(self.scene.environment().eval(si)))
        table = np.array(colours)
        return np.stack([np.interp(azimuth_rad, around, table[:, k]) for k in range(3)], axis=1)

    def reach(self, world_from_cam: np.ndarray, direction: np.ndarray) -> np.ndarray:
        """How far rays from the camera's position get, (n,) float32; see `Renderer`."""
        origin = mi.Point3f(*world_from_cam[:3, 3].tolist())
        rays = (mi.Ray3f(origin, mi.Vector3f(*d)) for d in direction.tolist())
        return np.array([self.scene.ray_intersect_preliminary(ray).t for ray in rays], np.float32)

    def _hits(self, world_from_cam: np.ndarray, direction: np.ndarray):
        origin = mi.Point3f(*world_from_cam[:3, 3].tolist())
        t, label, normal = np.full(len(direction), np.inf), np.zeros(len(direction)), []
        for number, d in enumerate(direction.tolist()):
            si = self.scene.ray_intersect(mi.Ray3f(origin, mi.Vector3f(*d)))
            found = si.is_valid()
            if found:
                t[number] = si.t
                label[number] = si.shape.eval_attribute_1("face_label", si)
            normal.append(np.array(si.n) if found else np.zeros(3))
        return t.astype(np.float32), label, np.array(normal)
