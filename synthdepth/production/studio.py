"""A scene ready to be photographed: world, renderer, flights, light and sensors."""

import contextlib
import dataclasses
import time
from collections.abc import Iterator

import numpy as np
from scipy.spatial.transform import Rotation

from synthdepth.camera import pitch_roll_deg
from synthdepth.dataset.pair import (
    SCHEMA_VERSION,
    encode_pair,
    encode_png,
    pair_key,
    saturate,
)
from synthdepth.flight.clearance import Clearance
from synthdepth.flight.flight import Flight
from synthdepth.maps.registry import build_world
from synthdepth.production.plan import ShardJob
from synthdepth.production.recipe import Recipe
from synthdepth.production.shots import Shot, draw_flights, spares
from synthdepth.render.sensor import Motion, Sensor, draw_sensor, expose
from synthdepth.seeding import lane


@dataclasses.dataclass(kw_only=True)
class Cost:
    """Where a shard job's time went [s].

    Attributes:
        build_s: scene, clearance queries, loading into the renderer.
        flight_s: drawing flights.
        render_s: rendering, denoising and depth, one number a pair.
        encode_s: PNG, EXR and tar.
        gate_s: the consistency gate.
    """

    build_s: float = 0.0
    flight_s: float = 0.0
    render_s: list[float] = dataclasses.field(default_factory=list)
    encode_s: float = 0.0
    gate_s: float = 0.0


@contextlib.contextmanager
def adding_time(cost: Cost, name: str) -> Iterator[None]:
    """Adds the seconds of the block to a number of `cost`."""
    start = time.perf_counter()
    yield
    setattr(cost, name, getattr(cost, name) + time.perf_counter() - start)


class Studio:
    """Renders pairs of one scene; one a process, as `Renderer` says.

    Args:
        job: which scene, and how many of its pairs have to be planned.
        recipe: what it is drawn from.
        cost: where the time goes.

    Attributes:
        shots: of the pairs, in order.
        renderer: of the world.
        cost: what the scene has taken so far.
    """

    def __init__(self, job: ShardJob, recipe: Recipe, cost: Cost):
        from synthdepth.render.renderer import load_world

        self._job, self._recipe, self.cost = job, recipe, cost
        with adding_time(cost, "build_s"):
            world = build_world(recipe.map, recipe.scene, recipe.light, job.scene_seed)
            clearance = Clearance(world, max_altitude_m=recipe.flight.altitude_m[1])
        with adding_time(cost, "flight_s"):
            self._flights, self.shots = draw_flights(job.scene_seed, job.pairs, clearance, recipe)
        # What is let go as soon as it has served keeps a worker under 2 GB.
        del clearance
        with adding_time(cost, "build_s"):
            self.renderer = load_world(world, recipe.camera.intrinsics(), recipe.render)
        self._light = world.light
        self._sensors = [
            draw_sensor(
                lane(job.scene_seed, "sensor", k), recipe.sensor, at_night=self._light.lamps_on
            )
            for k in range(len(self._flights))
        ]
        # The picture that the next pair of a burst has for its frame t-1: its number, as PNG.
        self._last: tuple[int | None, bytes] = None, b""

    def key(self, shot: Shot) -> str:
        """The key of a shot's pair."""
        return pair_key(
            self._recipe.map, self._job.scene_index, shot.flight_index, shot.frame_index
        )

    def spares(self, shot: Shot) -> list[Shot]:
        """What is drawn instead of a shot, in order."""
        frames = len(self._flights[shot.flight_index].time_s)
        return spares(self._job.scene_seed, shot, frames, self._recipe.sampling)

    def files(self, shot: Shot) -> dict[str, bytes]:
        """The files of a shot's pair, {suffix: bytes}."""
        from synthdepth.render.truth import ground_truth

        flight, t = self._flights[shot.flight_index], shot.frame_index
        pose, prev_pose = (flight.state.world_from_cam[t - k] for k in (0, 1))
        known, prev_png = self._last
        # Of a shot of the plan only: the frames of a spare share their numbers, not their pictures.
        fresh = known != shot.prev_number or shot not in self.shots
        start = time.perf_counter()
        prev = self._picture(shot, t - 1, shot.prev_number) if fresh else None
        rgb = self._picture(shot, t, shot.number)
        truth = ground_truth(self.renderer, pose, prev_pose, self._recipe.render.modalities)
        depth_m = saturate(truth.depth_m, self._recipe.render.max_depth_m)
        self.cost.render_s.append(time.perf_counter() - start)
        with adding_time(self.cost, "encode_s"):
            rgb_png = encode_png(rgb)
            members = encode_pair(
                rgb_png=rgb_png,
                prev_png=encode_png(prev) if fresh else prev_png,
                depth_m=depth_m,
                meta=self._meta(shot, depth_m) | self._sensor_meta(shot),
                flow=truth.flow,
                visible=truth.visible,
                seg=truth.seg,
                normal=truth.normal,
            )
        if shot in self.shots:
            self._last = shot.number, rgb_png
        return members

    def _picture(self, shot: Shot, t: int, number: int) -> np.ndarray:
        """Frame t of a shot's flight, with noise of its own by its number."""
        job, sensor = self._job, self._sensors[shot.flight_index]
        flight = self._flights[shot.flight_index]
        # Running numbers, not hashes: the scalar variant repeats its noise modulo 65,536.
        first = job.scene_index * self._recipe.sampling.frames_per_scene
        radiance = self.renderer.radiance(
            flight.state.world_from_cam[t], first + number, _motion(flight, t, sensor)
        )
        noise = lane(job.scene_seed, "noise", number)
        return expose(noise, radiance, self.renderer.exposure, sensor)

    def _meta(self, shot: Shot, depth_m: np.ndarray) -> dict:
        t, camera = shot.frame_index, self._recipe.camera.intrinsics()
        job, light, flight = self._job, self._light, self._flights[shot.flight_index]
        max_depth_m = self._recipe.render.max_depth_m
        pitch_deg, roll_deg = pitch_roll_deg(flight.state.world_from_cam[t])
        return {
            "schema_version": SCHEMA_VERSION,
            "map": self._recipe.map,
            "split": job.split,
            "condition": light.condition,
            "scene_index": job.scene_index,
            "scene_seed": job.scene_seed,
            "flight_index": shot.flight_index,
            "frame_index": t,
            "time_s": float(flight.time_s[t]),
            "dt_s": float(flight.time_s[t] - flight.time_s[t - 1]),
            "width": camera.width,
            "height": camera.height,
            "intrinsics": camera.matrix.tolist(),
            "world_from_cam": flight.state.world_from_cam[t].tolist(),
            "world_from_cam_prev": flight.state.world_from_cam[t - 1].tolist(),
            "velocity_mps": flight.state.velocity_mps[t].tolist(),
            "speed_mps": float(np.linalg.norm(flight.state.velocity_mps[t])),
            "altitude_m": float(flight.altitude_m[t]),
            "clearance_m": float(flight.clearance_m[t]),
            "pitch_deg": pitch_deg,
            "roll_deg": roll_deg,
            "max_depth_m": max_depth_m,
            "nearest_depth_m": float(depth_m.min()),
            "median_depth_m": float(np.median(depth_m)),
            "in_range_share": float(np.mean(depth_m < max_depth_m)),
            "sun_azimuth_deg": light.sun_azimuth_deg,
            "sun_elevation_deg": light.sun_elevation_deg,
            "turbidity": light.turbidity,
            "visibility_m": light.visibility_m,
            "cloud_cover": light.cloud_cover,
            "wetness": light.wetness,
            "spp": self._recipe.render.spp,
        }

    def _sensor_meta(self, shot: Shot) -> dict:
        sensor = self._sensors[shot.flight_index]
        ideal = not np.isfinite(sensor.electrons)
        return {
            "exposure": self.renderer.exposure * float(sensor.gain[1]),
            "shutter_s": sensor.shutter_s,
            "white_electrons": 0.0 if ideal else sensor.electrons,
            "contrast": sensor.contrast,
            "saturation": sensor.saturation,
            "jpeg_quality": sensor.jpeg_quality or 0,
        }


def _motion(flight: Flight, t: int, sensor: Sensor) -> Motion | None:
    """What the camera does while the shutter is open around frame t."""
    if not sensor.shutter_s:
        return None
    ends = flight.time_s[t] + sensor.shutter_s * np.array([-0.5, 0.5])
    ends = np.clip(ends, flight.time_s[0], flight.time_s[-1])
    first, last = flight.state_at(ends).world_from_cam
    share = sensor.shutter_s / (ends[1] - ends[0])
    turn = Rotation.from_matrix(last[:3, :3] @ first[:3, :3].T).as_rotvec()
    return Motion(moved_m=share * (last[:3, 3] - first[:3, 3]), turned_rad=share * turn)
