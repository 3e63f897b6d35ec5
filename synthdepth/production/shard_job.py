"""One shard job: build the scene, fly it, render its pairs, write the shard."""

import contextlib
import dataclasses
import time
from collections.abc import Callable, Iterator
from pathlib import Path

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
from synthdepth.dataset.shard import ShardWriter, read_members, shard_members
from synthdepth.flight.clearance import Clearance
from synthdepth.flight.flight import Flight, draw_flight
from synthdepth.maps.registry import build_world
from synthdepth.maps.world import Light
from synthdepth.production.plan import ShardJob
from synthdepth.production.recipe import Recipe, SamplingRecipe
from synthdepth.render.sensor import Motion, Sensor, draw_sensor, expose
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class Shot:
    """One pair to render: which frames of which flight.

    Attributes:
        flight_index: within the scene.
        frame_index: frame t within its flight; frame t-1 is the one before.
        prev_number: running number of frame t-1's picture within the scene, its noise seed.
        number: likewise of frame t; the frame t-1 of the next pair of a burst.
    """

    flight_index: int
    frame_index: int
    prev_number: int
    number: int


def burst_starts(rng: np.random.Generator, frames: int, sampling: SamplingRecipe) -> np.ndarray:
    """First frames of a flight's bursts, (bursts,) int64 ascending; bursts never overlap.

    Args:
        rng: the flight's lane.
        frames: number of frames of the flight, at least `sampling.frames_per_flight`.
        sampling: burst length and pairs per flight.
    """
    bursts = sampling.bursts_per_flight
    slack = frames - sampling.frames_per_flight
    gaps = np.sort(rng.integers(0, slack + 1, bursts))
    return gaps + (sampling.burst_pairs + 1) * np.arange(bursts)


def shots_of_flight(
    rng: np.random.Generator, flight_index: int, frames: int, sampling: SamplingRecipe
) -> list[Shot]:
    """The pairs of one flight, in order."""
    length = sampling.burst_pairs + 1
    first = flight_index * sampling.frames_per_flight
    shots = [
        Shot(
            flight_index=flight_index,
            frame_index=int(start) + k,
            prev_number=first + burst * length + k - 1,
            number=first + burst * length + k,
        )
        for burst, start in enumerate(burst_starts(rng, frames, sampling))
        for k in range(1, length)
    ]
    return shots[: sampling.pairs_per_flight]


@dataclasses.dataclass(kw_only=True)
class Cost:
    """Where a shard job's time went [s].

    Attributes:
        build_s: scene, clearance queries, loading into the renderer.
        flight_s: drawing flights.
        render_s: rendering, denoising and depth, one number a pair.
        encode_s: PNG, EXR and tar.
    """

    build_s: float = 0.0
    flight_s: float = 0.0
    render_s: list[float] = dataclasses.field(default_factory=list)
    encode_s: float = 0.0


def run_shard_job(
    job: ShardJob, recipe: Recipe, folder: Path, progress: Callable[[int], None]
) -> dict:
    """Render one shard and return its record for the manifest.

    Pairs that an earlier, shorter shard of the same scene holds are copied, not rendered again.

    Args:
        job: which scene, how many pairs.
        recipe: what it is drawn from.
        folder: the dataset folder.
        progress: called with the number of pairs done so far.
    """
    cost = Cost()
    path = Path(folder) / job.path
    ready = shard_members(path) if path.exists() else {}
    with ShardWriter(path) as shard:
        for key, members in ready.items():
            shard.add(key, read_members(path, members))
        progress(len(ready))
        for done, (key, members) in enumerate(
            _render_pairs(job, recipe, len(ready), cost), start=len(ready) + 1
        ):
            with _adding_time(cost, "encode_s"):
                shard.add(key, members)
            progress(done)
    return shard_record(job, shard.sha256, shard.size, cost)


def shard_record(job: ShardJob, sha256: str, size: int, cost: Cost | None) -> dict:
    """A shard's entry in the manifest; `cost` is None where a kill lost it."""
    spent = None
    if cost is not None:
        spent = dataclasses.asdict(cost)
        spent = {
            name: [round(s, 4) for s in value] if isinstance(value, list) else round(value, 3)
            for name, value in spent.items()
        }
    return {
        "path": job.path,
        "split": job.split,
        "scene_index": job.scene_index,
        "scene_seed": job.scene_seed,
        "pairs": job.pairs,
        "bytes": size,
        "sha256": sha256,
        "cost": spent,
    }


def _render_pairs(
    job: ShardJob, recipe: Recipe, skip: int, cost: Cost
) -> Iterator[tuple[str, dict[str, bytes]]]:
    """The scene's pairs from number `skip` on, each as its key and files."""
    from synthdepth.render.renderer import load_world
    from synthdepth.render.truth import ground_truth

    with _adding_time(cost, "build_s"):
        world = build_world(recipe.map, recipe.scene, recipe.light, job.scene_seed)
        clearance = Clearance(world, max_altitude_m=recipe.flight.altitude_m[1])
    with _adding_time(cost, "flight_s"):
        flights, shots = draw_flights(job.scene_seed, job.pairs, clearance, recipe)
    # What is let go as soon as it has served keeps a worker under 2 GB.
    del clearance
    with _adding_time(cost, "build_s"):
        renderer = load_world(world, recipe.camera.intrinsics(), recipe.render)
    light = world.light
    del world

    sensors = [
        draw_sensor(lane(job.scene_seed, "sensor", k), recipe.sensor, at_night=light.lamps_on)
        for k in range(len(flights))
    ]
    # Running numbers, not hashes: the scalar variant repeats its noise modulo 65,536.
    first = job.scene_index * recipe.sampling.frames_per_scene
    last_number, last_png = None, b""
    for shot in shots[skip:]:
        flight = flights[shot.flight_index]
        pose, prev_pose = (flight.state.world_from_cam[shot.frame_index - k] for k in (0, 1))
        fresh = last_number != shot.prev_number
        sensor = sensors[shot.flight_index]

        def picture(t: int, number: int, flight=flight, sensor=sensor) -> np.ndarray:
            radiance = renderer.radiance(
                flight.state.world_from_cam[t], first + number, _motion(flight, t, sensor)
            )
            noise = lane(job.scene_seed, "noise", number)
            return expose(noise, radiance, renderer.exposure, sensor)

        start = time.perf_counter()
        t = shot.frame_index
        prev = picture(t - 1, shot.prev_number) if fresh else None
        rgb = picture(t, shot.number)
        truth = ground_truth(renderer, pose, prev_pose, recipe.render.modalities)
        depth_m = saturate(truth.depth_m, recipe.render.max_depth_m)
        cost.render_s.append(time.perf_counter() - start)
        with _adding_time(cost, "encode_s"):
            rgb_png = encode_png(rgb)
            members = encode_pair(
                rgb_png=rgb_png,
                prev_png=encode_png(prev) if fresh else last_png,
                depth_m=depth_m,
                meta=_meta(job, recipe, light, flight, shot, depth_m)
                | _sensor_meta(sensor, renderer.exposure),
                flow=truth.flow,
                visible=truth.visible,
                seg=truth.seg,
                normal=truth.normal,
            )
        last_number, last_png = shot.number, rgb_png
        yield pair_key(recipe.map, job.scene_index, shot.flight_index, shot.frame_index), members


@contextlib.contextmanager
def _adding_time(cost: Cost, name: str) -> Iterator[None]:
    start = time.perf_counter()
    yield
    setattr(cost, name, getattr(cost, name) + time.perf_counter() - start)


def draw_flights(
    scene_seed: int, pairs: int, clearance: Clearance, recipe: Recipe
) -> tuple[list[Flight], list[Shot]]:
    """As many of a scene's flights as `pairs` need, and the shots on them, in order.

    Every flight has lanes of its own, so flight 3 is the same whether 4 or 40 are drawn.
    """
    sampling = recipe.sampling
    flights: list[Flight] = []
    shots: list[Shot] = []
    while len(shots) < pairs:
        index = len(flights)
        flight = draw_flight(lane(scene_seed, "flight", index), clearance, recipe.flight)
        flights.append(flight)
        bursts = lane(scene_seed, "bursts", index)
        shots += shots_of_flight(bursts, index, len(flight.time_s), sampling)
    return flights, shots[:pairs]


def _meta(
    job: ShardJob,
    recipe: Recipe,
    light: Light,
    flight: Flight,
    shot: Shot,
    depth_m: np.ndarray,
) -> dict:
    t, camera = shot.frame_index, recipe.camera.intrinsics()
    pitch_deg, roll_deg = pitch_roll_deg(flight.state.world_from_cam[t])
    return {
        "schema_version": SCHEMA_VERSION,
        "map": recipe.map,
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
        "max_depth_m": recipe.render.max_depth_m,
        "nearest_depth_m": float(depth_m.min()),
        "median_depth_m": float(np.median(depth_m)),
        "in_range_share": float(np.mean(depth_m < recipe.render.max_depth_m)),
        "sun_azimuth_deg": light.sun_azimuth_deg,
        "sun_elevation_deg": light.sun_elevation_deg,
        "turbidity": light.turbidity,
        "visibility_m": light.visibility_m,
        "cloud_cover": light.cloud_cover,
        "wetness": light.wetness,
        "spp": recipe.render.spp,
    }


def _sensor_meta(sensor: Sensor, exposure: float) -> dict:
    ideal = not np.isfinite(sensor.electrons)
    return {
        "exposure": exposure * float(sensor.gain[1]),
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
