"""Random drone flights through a world: safe, smooth, and as a drone moves."""

import collections
import dataclasses
import math

import numpy as np

from synthdepth.errors import FlightError
from synthdepth.flight.attitude import Attitude, fly_attitude
from synthdepth.flight.clearance import Clearance
from synthdepth.flight.guide import Guide
from synthdepth.flight.limits import FlightLimits
from synthdepth.flight.planner import Mission, Planner
from synthdepth.flight.primitives import Trajectory

_STARTS, _GOALS = 64, 64  # places tried at once


@dataclasses.dataclass(frozen=True, kw_only=True)
class FlightState:
    """A drone at n moments.

    Attributes:
        position_m: (n, 3) float64.
        velocity_mps: (n, 3) float64.
        acceleration_mps2: (n, 3) float64.
        world_from_body: (n, 3, 3) float64 rotations; body axes forward, left, up (the thrust).
        world_from_cam: (n, 4, 4) float64 poses of the camera, in OpenCV axes.
    """

    position_m: np.ndarray
    velocity_mps: np.ndarray
    acceleration_mps2: np.ndarray
    world_from_body: np.ndarray
    world_from_cam: np.ndarray


@dataclasses.dataclass(frozen=True, kw_only=True)
class Flight:
    """One flight, at frames and at any time.

    Attributes:
        time_s: (n,) float64, from 0 in steps of exactly the frame interval.
        state: the drone at the frames.
        clearance_m: (n,) float64, lower bound of the distance to everything.
        altitude_m: (n,) float64, above ground.
        mission: start, goal, cruise speed and altitude, preferred clearance.
        mount_pitch_deg: pitch of the camera against the body; negative looks down.
        trajectory: position over time.
        attitude: attitude over time.
    """

    time_s: np.ndarray
    state: FlightState
    clearance_m: np.ndarray
    altitude_m: np.ndarray
    mission: Mission
    mount_pitch_deg: float
    trajectory: Trajectory
    attitude: Attitude

    def state_at(self, t: np.ndarray) -> FlightState:
        """The drone at times t (n,) [s] of the flight."""
        return _state(self.trajectory, self.attitude, self.mount_pitch_deg, t)


def body_from_cam(mount_pitch_deg: float) -> np.ndarray:
    """Rotation (3, 3) of a camera (right, down, forward) that looks ahead on a body (forward, left,
    up), pitched up by `mount_pitch_deg`."""
    c, s = math.cos(math.radians(mount_pitch_deg)), math.sin(math.radians(mount_pitch_deg))
    right, forward = np.array([0.0, -1.0, 0.0]), np.array([c, 0.0, s])
    return np.stack([right, np.cross(forward, right), forward], axis=1)


def _state(trajectory, attitude, mount_pitch_deg, t) -> FlightState:
    t = np.asarray(t, np.float64)
    rotation = attitude.world_from_body(t)
    pose = np.tile(np.eye(4), (len(t), 1, 1))
    pose[:, :3, :3] = rotation @ body_from_cam(mount_pitch_deg)
    pose[:, :3, 3] = position = trajectory.evaluate(t, 0)
    return FlightState(
        position_m=position,
        velocity_mps=trajectory.evaluate(t, 1),
        acceleration_mps2=trajectory.evaluate(t, 2),
        world_from_body=rotation,
        world_from_cam=pose,
    )


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return math.exp(rng.uniform(math.log(low), math.log(high)))


def draw_mission(
    rng: np.random.Generator, clearance: Clearance, limits: FlightLimits
) -> Mission | str:
    """Start, goal and manner of a flight; or why there is none."""
    preferred = _log_uniform(rng, *limits.clearance_m)
    low, high = limits.altitude_m
    # Low flights cannot keep far from things, so the wary ones are high.
    lowest = min(max(low * 1.1, 0.8 * preferred), 0.8 * high) if high > 1.5 * low else low
    altitude = _log_uniform(rng, lowest, high)
    speed = rng.uniform(*limits.speed_mps)
    wave, period = rng.uniform(0, 0.2), rng.uniform(8, 25)
    phase = rng.uniform(0, 2 * math.pi)

    corner, opposite = clearance.bounds
    inset = np.minimum(3.0, 0.1 * (opposite - corner))
    places = rng.uniform(corner + inset, opposite - inset, (_STARTS, 2))
    places = np.column_stack([places, clearance.ground_m(places) + altitude])
    room = clearance.obstacle_m(places)
    free = (clearance(places) >= limits.needed_m + 0.3) & ~clearance.covered(places)
    # A flight starts where the clearance suits it.
    weight = np.where(free, np.minimum(room / preferred, preferred / np.maximum(room, 1e-6)), 0)
    pick = rng.uniform()
    if not free.any():
        return "start blocked"
    cumulative = np.cumsum(weight**2)
    start = places[np.searchsorted(cumulative, pick * cumulative[-1], side="right")]

    distance = rng.uniform(*limits.distance_m, _GOALS)
    angle = rng.uniform(0, 2 * math.pi, _GOALS)
    goals = start[:2] + distance[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    goals = goals[((goals > corner + inset) & (goals < opposite - inset)).all(axis=1)]
    if len(goals):
        goals = np.column_stack([goals, clearance.ground_m(goals) + altitude])
        goals = goals[(clearance(goals) >= limits.needed_m) & ~clearance.covered(goals)]
    if not len(goals):
        return "no free goal"
    return Mission(
        start_m=start,
        goal_m=goals[0],
        speed_mps=speed,
        altitude_m=altitude,
        clearance_m=preferred,
        wave=wave,
        wave_period_s=period,
        wave_phase_rad=phase,
    )


def _fly(rng, mission: Mission, clearance: Clearance, limits: FlightLimits) -> Trajectory | str:
    """A trajectory of a mission; or why there is none."""
    share, jitter = rng.uniform(), rng.normal(0, 0.2)
    guide = Guide(
        clearance,
        mission.start_m,
        mission.goal_m,
        mission.altitude_m,
        mission.clearance_m,
        limits.needed_m,
    )
    planner = Planner(mission, clearance, guide, limits)
    course = guide.course_rad(mission.start_m, max(6.0, mission.speed_mps)) + jitter
    trajectory = None
    for speed in mission.speed_mps * np.array([share, share / 2, 0.0]):  # already under way
        trajectory = planner.fly(speed * np.array([math.cos(course), math.sin(course), 0]))
        if trajectory is not None and trajectory.end_s >= limits.duration_s[0]:
            return trajectory
    return "no safe motion" if trajectory is None else "too short"


def draw_flight(rng: np.random.Generator, clearance: Clearance, limits: FlightLimits) -> Flight:
    """A random flight: start, goal, speed, altitude, daring, look and camera mount.

    Raises:
        FlightError: none of `limits.max_draws` draws made a flight.
    """
    reasons = collections.Counter()
    for _ in range(limits.max_draws):
        mission = draw_mission(rng, clearance, limits)
        flown = mission if isinstance(mission, str) else _fly(rng, mission, clearance, limits)
        if isinstance(flown, str):
            reasons[flown] += 1
            continue
        break
    else:
        why = ", ".join(f"{name}: {count}" for name, count in sorted(reasons.items()))
        low, high = limits.altitude_m
        raise FlightError(
            f"no flight in {limits.max_draws} draws ({why}); flights need {limits.needed_m:g} m of"
            f" room at {low:g} to {high:g} m above ground and last {limits.duration_s[0]:g} s or"
            " more"
        )

    # Real drones crab: the look is an angle held beside the course and a slow swing.
    swing = math.radians(limits.look_deg) * rng.uniform(0, 1)
    aside = (math.radians(limits.look_deg) - swing) * rng.uniform(-1, 1)
    period, phase = rng.uniform(6, 20), rng.uniform(0, 2 * math.pi)
    toward = mission.goal_m - mission.start_m
    attitude = fly_attitude(
        flown,
        lambda t: aside + swing * np.sin(2 * np.pi * t / period + phase),
        math.atan2(toward[1], toward[0]),
        drag_per_s=limits.drag_per_s,
        max_yaw_rate=math.radians(limits.max_yaw_rate_dps),
        max_yaw_acceleration=math.radians(limits.max_yaw_acceleration_dps2),
    )
    pitch = rng.uniform(*limits.mount_pitch_deg)
    count = int(flown.end_s / limits.frame_interval_s + 1e-6) + 1
    time = np.arange(count) * limits.frame_interval_s
    state = _state(flown, attitude, pitch, time)
    ground = clearance.ground_m(state.position_m[:, :2])
    return Flight(
        time_s=time,
        state=state,
        clearance_m=clearance(state.position_m, near_m=clearance.reach_m),
        altitude_m=state.position_m[:, 2] - ground,
        mission=mission,
        mount_pitch_deg=pitch,
        trajectory=flown,
        attitude=attitude,
    )
