"""What a drone's camera shows a depth source: the renderer's depth, or the sensor's pictures."""

import dataclasses
import time
from collections.abc import Callable

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.dataset.pair import saturate
from synthdepth.dataset.sample import Sample
from synthdepth.render.sensor import Motion, Sensor, SensorRanges, draw_sensor, expose
from synthdepth.seeding import derive_seed, lane

_MOST_FRAMES = 100_000  # of a flight


@dataclasses.dataclass(frozen=True, kw_only=True)
class Look:
    """A moment of a flight.

    Attributes:
        scenario: its number within the scene.
        frame: its number within the flight.
        world_from_cam: (4, 4) float64.
        velocity_mps: (3,) float64.
        yaw_rate: [rad/s].
        altitude_m: above ground.
    """

    scenario: int
    frame: int
    world_from_cam: np.ndarray
    velocity_mps: np.ndarray
    yaw_rate: float
    altitude_m: float


class Eyes:
    """The camera of a scene's flights.

    A picture is a function of the scene, the scenario, the frame and the pose alone, so that all
    sources see the same noise.

    Args:
        load: gives the scene's `synthdepth.render.renderer.Renderer`; called when a source first
            sees something.
        camera: intrinsics of every picture.
        scene_seed: of the scene.
        sensor: what each scenario's sensor is drawn from.
        at_night: whether the scene's lamps are on.
        max_depth_m: where the true depth saturates.
        frame_interval_s: time between frames.

    Attributes:
        camera: likewise.
        loading_s: time spent on loading the scene.
        spent_s: time spent so far on rendering.
    """

    def __init__(
        self,
        load: Callable,
        *,
        camera: Intrinsics,
        scene_seed: int,
        sensor: SensorRanges,
        at_night: bool,
        max_depth_m: float,
        frame_interval_s: float,
    ):
        self._load, self._renderer, self.camera = load, None, camera
        self._scene_seed, self._at_night = scene_seed, at_night
        self.loading_s = self.spent_s = 0.0
        self._ranges, self._sensors = sensor, {}
        self._max_depth_m, self._frame_interval_s = max_depth_m, frame_interval_s

    def sample(self, sees: str, look: Look, before: Sample | None) -> Sample:
        """What a source is shown.

        Args:
            sees: "depth", "rgb" or "nothing".
            look: the moment.
            before: what this gave for the flight's last frame; None for the first, before which
                the drone hovered: it counts as its own frame t-1.
        """
        shape = (self.camera.height, self.camera.width)
        depth = np.zeros(shape, np.float32)
        rgb = np.zeros((*shape, 3), np.uint8)
        start = time.perf_counter()
        if sees != "nothing" and self._renderer is None:
            self._renderer, self._load = self._load(), None
            self.loading_s = time.perf_counter() - start
            start = time.perf_counter()
        if sees == "depth":
            depth = saturate(self._renderer.planar_depth(look.world_from_cam), self._max_depth_m)
        elif sees == "rgb":
            rgb = self._picture(look)
        self.spent_s += time.perf_counter() - start
        return Sample(
            key=f"f{look.scenario:03d}-{look.frame:04d}",
            rgb=rgb,
            prev=rgb if before is None else before.rgb,
            depth_m=depth,
            valid=np.full(shape, sees == "depth"),
            max_depth_m=self._max_depth_m,
            intrinsics=self.camera.matrix,
            world_from_cam=look.world_from_cam,
            world_from_cam_prev=(look.world_from_cam if before is None else before.world_from_cam),
            meta={"dt_s": self._frame_interval_s, "altitude_m": look.altitude_m},
        )

    def _picture(self, look: Look) -> np.ndarray:
        sensor = self._sensor(look.scenario)
        number = look.scenario * _MOST_FRAMES + look.frame
        motion = None
        if sensor.shutter_s:
            turned = np.array([0.0, 0.0, look.yaw_rate])
            motion = Motion(
                moved_m=sensor.shutter_s * look.velocity_mps, turned_rad=sensor.shutter_s * turned
            )
        seed = derive_seed(self._scene_seed, "simulate-samples", number) % 2**32
        radiance = self._renderer.radiance(look.world_from_cam, seed, motion)
        noise = lane(self._scene_seed, "simulate-noise", number)
        return expose(noise, radiance, self._renderer.exposure, sensor)

    def _sensor(self, scenario: int) -> Sensor:
        if scenario not in self._sensors:
            rng = lane(self._scene_seed, "simulate-sensor", scenario)
            self._sensors[scenario] = draw_sensor(rng, self._ranges, at_night=self._at_night)
        return self._sensors[scenario]
