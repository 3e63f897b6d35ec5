"""Attitude of a drone along a trajectory: where its thrust must point, and a limited yaw.

A multirotor is differentially flat (D. Mellinger, V. Kumar, "Minimum Snap Trajectory Generation
and Control for Quadrotors", ICRA 2011, section III): position and yaw over time fix its attitude.
Body axes: x forward, y left, z up (along the thrust).
"""

import dataclasses
from collections.abc import Callable

import numpy as np
from scipy.ndimage import gaussian_filter1d

from synthdepth.flight.primitives import Trajectory

GRAVITY_MPS2 = 9.81
_STEP_S = 0.02
# Time that the airframe takes to turn its thrust: smooths the corners of the acceleration.
_TILT_SMOOTHING_S = 0.08
_YAW_BANDWIDTH = 3.0  # [rad/s] of the critically damped yaw loop


def thrust(
    velocity_mps: np.ndarray, acceleration_mps2: np.ndarray, drag_per_s: float
) -> np.ndarray:
    """Mass-normalised thrust (..., 3) [m/s^2]: acceleration, weight and linear rotor drag."""
    return acceleration_mps2 + drag_per_s * velocity_mps + [0.0, 0.0, GRAVITY_MPS2]


def track_yaw(
    reference_rad: np.ndarray, step_s: float, max_rate: float, max_acceleration: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Yaw, its rate and its acceleration (n,) that follow a reference (n,) within limits.

    The acceleration is constant over each step, so that the limits hold between samples too.
    """
    w = _YAW_BANDWIDTH
    rates = np.gradient(reference_rad, step_s).tolist()
    psi, omega = float(reference_rad[0]), float(np.clip(rates[0], -max_rate, max_rate))
    out = np.empty((3, len(rates)))
    for i, (target, rate) in enumerate(zip(reference_rad.tolist(), rates, strict=True)):
        alpha = w * w * (target - psi) + 2 * w * (rate - omega)
        alpha = min(max(alpha, -max_acceleration), max_acceleration)
        alpha = (min(max(omega + alpha * step_s, -max_rate), max_rate) - omega) / step_s
        out[:, i] = psi, omega, alpha
        psi += omega * step_s + alpha * step_s**2 / 2
        omega += alpha * step_s
    return out[0], out[1], out[2]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Attitude:
    """Thrust direction and yaw over time, evaluated at any time of a flight.

    Attributes:
        step_s: spacing of the knots [s]; the first is at 0.
        thrust_mps2: (n, 3) float64.
        yaw: (3, n) float64: yaw [rad], its rate [rad/s] and its acceleration [rad/s^2], constant
            from each knot to the next.
    """

    step_s: float
    thrust_mps2: np.ndarray
    yaw: np.ndarray

    def yaw_rad(self, t: np.ndarray) -> np.ndarray:
        """Yaw (n,) [rad] from +X, counter-clockwise, continuous (not wrapped)."""
        i = np.clip((t / self.step_s).astype(int), 0, self.yaw.shape[1] - 1)
        dt = t - i * self.step_s
        psi, omega, alpha = self.yaw[:, i]
        return psi + omega * dt + alpha * dt**2 / 2

    def world_from_body(self, t: np.ndarray) -> np.ndarray:
        """Rotations (n, 3, 3) float64 at times t (n,) [s]; columns forward, left, up."""
        t = np.asarray(t, np.float64)
        knots = np.arange(len(self.thrust_mps2)) * self.step_s
        z = np.stack([np.interp(t, knots, axis) for axis in self.thrust_mps2.T], axis=1)
        z /= np.linalg.norm(z, axis=1, keepdims=True)
        psi = self.yaw_rad(t)
        heading = np.stack([np.cos(psi), np.sin(psi), np.zeros_like(psi)], axis=1)
        y = np.cross(z, heading)
        y /= np.linalg.norm(y, axis=1, keepdims=True)
        return np.stack([np.cross(y, z), y, z], axis=-1)


def fly_attitude(
    trajectory: Trajectory,
    look_rad: Callable[[np.ndarray], np.ndarray],
    initial_yaw_rad: float,
    *,
    drag_per_s: float,
    max_yaw_rate: float,
    max_yaw_acceleration: float,
) -> Attitude:
    """The attitude along a `Trajectory`: thrust as flown, yaw towards the velocity plus a look.

    Args:
        trajectory: the motion.
        look_rad: of time (n,) [s] -> (n,) [rad], where the drone looks beside its course.
        initial_yaw_rad: course while the drone has not moved yet.
        drag_per_s: linear drag [1/s].
        max_yaw_rate: [rad/s].
        max_yaw_acceleration: [rad/s^2].
    """
    t = np.arange(int(np.ceil(trajectory.end_s / _STEP_S)) + 1) * _STEP_S
    held = np.minimum(t, trajectory.end_s)
    velocity, acceleration = trajectory.evaluate(held, 1), trajectory.evaluate(held, 2)
    force = thrust(velocity, acceleration, drag_per_s)
    force = gaussian_filter1d(force, _TILT_SMOOTHING_S / _STEP_S, axis=0, mode="nearest")
    # Near standstill the direction of the velocity means nothing: hold the course between.
    moving = np.hypot(velocity[:, 0], velocity[:, 1]) > 0.5
    course = np.full(len(t), initial_yaw_rad)
    if moving.any():
        angle = np.unwrap(np.arctan2(velocity[moving, 1], velocity[moving, 0]))
        course = np.interp(t, t[moving], angle)
    reference = course + look_rad(t)
    reference = gaussian_filter1d(reference, 0.2 / _STEP_S, mode="nearest")
    yaw = track_yaw(reference, _STEP_S, max_yaw_rate, max_yaw_acceleration)
    return Attitude(step_s=_STEP_S, thrust_mps2=force, yaw=np.stack(yaw))
