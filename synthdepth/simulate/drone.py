"""The drone: a point mass with a radius, steered by velocity and yaw, that looks ahead level.

Its flight controller reaches a commanded velocity with bounded acceleration and a commanded yaw
with a bounded rate. Time goes in short steps; within one the drone flies straight, so that its way
is a polyline and what it touches can be found exactly. The camera is on a gimbal: it turns with the
yaw and does not lean with the drone.
"""

import dataclasses
import math

import numpy as np

from synthdepth.camera import look_rotation, pose
from synthdepth.config import Config, number
from synthdepth.errors import RecipeError


@dataclasses.dataclass(frozen=True, kw_only=True)
class DroneConfig(Config):
    """What the drone can do, and how often and how late it is told what to do.

    Attributes:
        radius_m: of the sphere that must touch nothing.
        max_acceleration_mps2: largest norm of the acceleration.
        max_yaw_rate_dps: fastest turn.
        max_climb_mps: fastest climb and descent.
        camera_pitch_deg: of the camera against the horizon; negative looks down.
        frame_interval_s: time between frames, each of which gives a command.
        latency_s: from a frame to when its command takes effect: exposure, depth, planning, link.
        step_s: of the motion; the two times before are whole numbers of it.
    """

    radius_m: float = number(0.35, 0.01, 5)
    max_acceleration_mps2: float = number(8.0, 0.1, 100)
    max_yaw_rate_dps: float = number(90.0, 1, 720)
    max_climb_mps: float = number(8.0, 0.1, 100)
    camera_pitch_deg: float = number(0.0, -90, 45)
    frame_interval_s: float = number(0.1, 0.001, 10)
    latency_s: float = number(0.1, 0, 10)
    step_s: float = number(0.02, 0.0001, 1)

    def __post_init__(self):
        super().__post_init__()
        for name in ("frame_interval_s", "latency_s"):
            steps = getattr(self, name) / self.step_s
            if abs(steps - round(steps)) > 1e-6:
                raise RecipeError(
                    f"{name} = {getattr(self, name):g}: allowed are whole numbers of "
                    f"step_s = {self.step_s:g}"
                )

    @property
    def steps_per_frame(self) -> int:
        """Steps of the motion from a frame to the next."""
        return round(self.frame_interval_s / self.step_s)

    @property
    def latency_steps(self) -> int:
        """Steps from a frame to its command's effect."""
        return round(self.latency_s / self.step_s)

    @property
    def reaction_s(self) -> float:
        """The longest time from something's coming into sight to a command that knows of it."""
        return self.frame_interval_s + self.latency_s


@dataclasses.dataclass(frozen=True, kw_only=True)
class Command:
    """What n drones are told.

    Attributes:
        velocity_mps: (n, 3) float64, world axes.
        yaw_rad: (n,) float64, from +X, counter-clockwise.
        section: (n, 2) int64 row and column of the sections flown to; None where nobody asked.
    """

    velocity_mps: np.ndarray
    yaw_rad: np.ndarray
    section: np.ndarray | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Motion:
    """How n drones move, at the ends of k steps.

    Attributes:
        position_m: (k + 1, n, 3) float64, corners of polylines.
        velocity_mps: (k + 1, n, 3) float64.
        yaw_rad: (k + 1, n) float64, continuous.
    """

    position_m: np.ndarray
    velocity_mps: np.ndarray
    yaw_rad: np.ndarray


def advance(
    position_m: np.ndarray,
    velocity_mps: np.ndarray,
    yaw_rad: np.ndarray,
    commands: list[Command],
    drone: DroneConfig,
) -> Motion:
    """Fly some drones, one command a step.

    Args:
        position_m, velocity_mps: (n, 3) float64 at the start.
        yaw_rad: (n,) float64.
        commands: k of them, each for n drones.
        drone: their limits.
    """
    most = drone.max_acceleration_mps2 * drone.step_s
    turn = math.radians(drone.max_yaw_rate_dps) * drone.step_s
    states = [(position_m, velocity_mps, yaw_rad)]
    for command in commands:
        p, v, psi = states[-1]
        change = command.velocity_mps - v
        size = np.linalg.norm(change, axis=1, keepdims=True)
        new = v + change * np.minimum(1, most / np.maximum(size, 1e-12))
        off = (command.yaw_rad - psi + math.pi) % (2 * math.pi) - math.pi
        # The velocity changes evenly, so the mean of both ends leads to the right place.
        moved = p + (v + new) * (drone.step_s / 2)
        states.append((moved, new, psi + np.clip(off, -turn, turn)))
    position, velocity, yaw = (np.stack(x) for x in zip(*states, strict=True))
    return Motion(position_m=position, velocity_mps=velocity, yaw_rad=yaw)


def camera_rotations(yaw_rad: np.ndarray, pitch_deg: float) -> np.ndarray:
    """Rotations `world_from_cam` (n, 3, 3) of level cameras at yaws (n,)."""
    pitch = math.radians(pitch_deg)
    level = math.cos(pitch)
    x, y = level * np.cos(yaw_rad), level * np.sin(yaw_rad)
    forward = np.stack([x, y, np.full_like(x, math.sin(pitch))], axis=-1)
    if level < 1e-9:  # straight down: the picture's top is ahead
        return look_rotation(forward, np.stack([np.cos(yaw_rad), np.sin(yaw_rad), 0 * x], axis=-1))
    return look_rotation(forward, np.array([0.0, 0.0, 1.0]))


def camera_pose(position_m: np.ndarray, yaw_rad: float, pitch_deg: float) -> np.ndarray:
    """`world_from_cam` (4, 4) of the camera in the middle of a drone at (3,)."""
    return pose(camera_rotations(np.array([yaw_rad]), pitch_deg)[0], position_m)
