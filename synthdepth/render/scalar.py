"""Rendering without a JIT compiler: for machines on which no libLLVM works.

Slow, and plainer: one colour a vertex instead of textures, no guides for the denoiser, haze added a
pixel at a time. Depth is the same to float rounding.
"""

import mitsuba as mi
import numpy as np

from synthdepth.render.integrate import AIRLIGHT_SINE, HAZE_LAYER_M, KOSCHMIEDER
from synthdepth.render.renderer import Renderer
from synthdepth.render.scene import to_world
from synthdepth.render.settings import RenderSettings

_AZIMUTHS, _LIGHT_SAMPLES = 72, 64


class ScalarRenderer(Renderer):
    """A `Renderer` for the variant scalar_rgb."""

    _sky_with_sun = True

    def set_settings(self, settings: RenderSettings) -> None:
        """Render with other samples or denoising from now on."""
        self.settings = settings
        self._path = mi.load_dict({"type": "path", "max_depth": 3})

    def _compiled(self, function):
        return function

    def _irradiance(self) -> tuple[np.ndarray, np.ndarray]:
        side = (np.arange(_LIGHT_SAMPLES) + 0.5) / _LIGHT_SAMPLES
        emitter, point, light = self.scene.environment(), mi.Interaction3f(), []
        for x in side.tolist():
            for y in side.tolist():
                found, weight = emitter.sample_direction(point, mi.Point2f(x, y))
                light.append(np.array(weight) * max(found.d.z, 0.0))
        return np.mean(light, axis=0), np.zeros(3)

    def _jit_lights(self, sun: np.ndarray, sky: np.ndarray) -> None:
        return None

    def noisy(self, world_from_cam: np.ndarray, seed: int) -> np.ndarray:
        """Radiance before denoising, (H, W, 3) float32; there are no guides."""
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

    def planar_depth(self, world_from_cam: np.ndarray) -> np.ndarray:
        """Unsaturated planar depth at the pixel centres, (H, W) float32 [m]; the sky is inf."""
        origin = mi.Point3f(*world_from_cam[:3, 3].tolist())
        directions = (self._rays @ world_from_cam[:3, :3].T).tolist()
        t = [self._trace(self.scene, origin, mi.Vector3f(*d)) for d in directions]
        return np.array(t, np.float32).reshape(self.camera.height, self.camera.width)
