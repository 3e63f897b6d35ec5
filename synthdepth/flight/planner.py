"""Receding-horizon flight: choose a motion primitive, fly its first part, choose again.

Every choice is among some hundred primitives that end in different velocities. Those that break a
limit drop out; of the rest the cheapest (progress towards the goal, preferred clearance, smooth
motion, cruise speed and altitude) is flown. Each is safe up to its end, so what was planned last
is there to fall back on.
"""

import dataclasses
import math

import numpy as np

from synthdepth.flight.attitude import GRAVITY_MPS2, thrust
from synthdepth.flight.clearance import Clearance
from synthdepth.flight.guide import Guide, shortfall
from synthdepth.flight.limits import FlightLimits
from synthdepth.flight.primitives import Trajectory, evaluate, minimum_jerk

_REPLAN_S = 0.4
_FAN_RAD = np.radians([0, -6, 6, -14, 14, -25, 25, -40, 40, -60, 60, -90, 90])
_SAMPLES = 10  # along a primitive, to compare; the chosen one is then checked densely
_DENSE_M = 0.3
_BATCH = 32
_HEADROOM = 0.97  # limits are planned with this share, for what happens between samples
_STALL_S, _STALL_M = 3.0, 1.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Mission:
    """What one flight wants.

    Attributes:
        start_m: (3,) float64.
        goal_m: (3,) float64.
        speed_mps: cruise speed.
        altitude_m: cruise altitude above ground.
        clearance_m: preferred clearance.
        wave: relative amplitude of a slow change of the cruise altitude.
        wave_period_s: its period.
        wave_phase_rad: its phase at the start.
    """

    start_m: np.ndarray
    goal_m: np.ndarray
    speed_mps: float
    altitude_m: float
    clearance_m: float
    wave: float
    wave_period_s: float
    wave_phase_rad: float

    def altitude_at(self, t: float, limits: FlightLimits) -> float:
        """Wanted altitude above ground [m] at time t [s]."""
        phase = 2 * math.pi * t / self.wave_period_s + self.wave_phase_rad
        low, high = limits.altitude_m
        wanted = self.altitude_m * (1 + self.wave * math.sin(phase))
        return min(max(wanted, low + 0.2 * min(1, high - low)), high)


class Planner:
    """Plans one flight of a mission."""

    def __init__(self, mission: Mission, clearance: Clearance, guide: Guide, limits: FlightLimits):
        self.mission, self.clearance, self.guide, self.limits = mission, clearance, guide, limits

    def fly(self, velocity_mps: np.ndarray) -> Trajectory | None:
        """The flight from a starting velocity (3,) [m/s], or none if there is no safe motion.

        It ends at the goal, after the longest duration, or where it cannot go on.
        """
        p, v, a = self.mission.start_m, np.asarray(velocity_mps, np.float64), np.zeros(3)
        starts, plans = [], []
        t, left = 0.0, 0.0  # left: what remains of the current plan [s]
        trail = [p[:2]]
        reach = max(3.0, 0.6 * self.mission.speed_mps)
        while t < self.limits.duration_s[1] - 1e-9:
            found = self._choose(t, p, v, a)
            if found is not None:
                plan, left = found
                starts.append(t)
                plans.append(plan)
            elif left < _REPLAN_S:
                break
            t += _REPLAN_S
            left -= _REPLAN_S
            at = np.array([t - starts[-1]])
            p, v, a = (evaluate(plans[-1], at, order)[0] for order in range(3))
            trail.append(p[:2])
            if np.linalg.norm(self.mission.goal_m[:2] - p[:2]) < reach:
                break
            stalled = int(_STALL_S / _REPLAN_S)
            if len(trail) > stalled and np.linalg.norm(p[:2] - trail[-stalled]) < _STALL_M:
                t -= _STALL_S
                break
        if not plans:
            return None
        end = min(t, self.limits.duration_s[1])
        return Trajectory(start_s=np.array(starts), end_s=end, coefficients=np.stack(plans))

    def _choose(self, t, p, v, a) -> tuple[np.ndarray, float] | None:
        """The best safe primitive (5, 3) from a state at time t, and its duration [s]."""
        coefficients, duration = self._candidates(t, p, v, a)
        coefficients, duration = self._within_dynamics(coefficients, duration)
        if not len(duration):
            return None
        cost = self._cost_of_motion(t, p, coefficients, duration)
        order = np.argsort(cost, kind="stable")
        coefficients, duration, cost = coefficients[order], duration[order], cost[order]
        # Clearance is dear to ask for and only ever adds to the cost: ask the cheapest first, and
        # stop when nothing that is left can be better.
        full = np.full(len(cost), np.inf)
        for i in range(0, len(cost), _BATCH):
            if full.min() <= cost[i]:
                break
            s = np.s_[i : i + _BATCH]
            full[s] = cost[s] + self._cost_of_clearance(coefficients[s], duration[s])
        for k in np.argsort(full, kind="stable")[:6]:
            if np.isfinite(full[k]) and self._safe(coefficients[k], duration[k]):
                return coefficients[k], float(duration[k])
        return None

    def _candidates(self, t, p, v, a):
        """Coefficients (m, 5, 3) and durations (m,) of the primitives to choose from."""
        mission, limits = self.mission, self.limits
        speed = float(np.hypot(v[0], v[1]))
        goal = self.guide.course_rad(p, max(6.0, 1.2 * mission.speed_mps))
        course = math.atan2(v[1], v[0]) if speed > 0.5 else goal
        heading = np.concatenate([course + _FAN_RAD, goal + np.radians([0, -8, 8])])
        longest = 2.0 + speed / 12
        wanted = mission.altitude_at(t + 1.5, limits)
        off = wanted - (p[2] - float(self.clearance.ground_m(p[None, :2])[0]))
        steepest = min(4.0, 1.0 + 0.3 * mission.speed_mps)
        climb = float(np.clip(off / 1.5, -steepest, steepest))
        climbs = np.array([climb, climb + 0.7 * steepest, climb - 0.5 * steepest])
        # What forward thrust is left at this speed; braking has drag on its side.
        ahead = (
            GRAVITY_MPS2 * math.tan(math.radians(limits.max_tilt_deg)) - limits.drag_per_s * speed
        )
        ahead = max(min(limits.max_acceleration_mps2, ahead), 0.5)
        ends, durations = [], []
        for T in (longest, 0.6 * longest):
            faster = min(mission.speed_mps, speed + 0.55 * ahead * T)
            slower = max(speed - 0.58 * limits.max_acceleration_mps2 * T, 0.0)
            cruise = max(faster, slower)
            speeds = np.array([cruise, max(0.6 * cruise, slower), max(0.2 * cruise, slower)])
            h, s, c = (g.ravel() for g in np.meshgrid(heading, speeds, climbs, indexing="ij"))
            ends.append(np.stack([s * np.cos(h), s * np.sin(h), c], axis=1))
            durations.append(np.full(len(h), T))
        ends, durations = np.concatenate(ends), np.concatenate(durations)
        return minimum_jerk(p, v, a, ends, durations), durations

    def _dynamic(self, coefficients, times):
        """Which primitives (m,) keep to speed, acceleration, jerk and tilt at times (m, k)."""
        limits = self.limits
        v, a = (evaluate(coefficients, times, order) for order in (1, 2))
        # The jerk is linear in time, so its norm is largest at an end.
        j = evaluate(coefficients, times[:, [0, -1]], 3)
        force = thrust(v, a, limits.drag_per_s)
        steep = np.hypot(force[..., 0], force[..., 1]) / np.maximum(force[..., 2], 1e-6)
        share = np.stack(
            [
                np.linalg.norm(v, axis=-1).max(axis=1) / limits.max_speed_mps,
                np.linalg.norm(a, axis=-1).max(axis=1) / limits.max_acceleration_mps2,
                np.linalg.norm(j, axis=-1).max(axis=1) / limits.max_jerk_mps3,
                steep.max(axis=1) / math.tan(math.radians(limits.max_tilt_deg)),
            ]
        )
        return (share <= [[1.0], [_HEADROOM], [1.0], [_HEADROOM]]).all(axis=0)

    def _within_dynamics(self, coefficients, duration):
        ok = self._dynamic(coefficients, duration[:, None] * np.linspace(0, 1, 9))
        end = evaluate(coefficients, duration[:, None], 0)[:, 0, :2]
        low, high = self.clearance.bounds
        ok &= ((end >= low) & (end <= high)).all(axis=1)
        return coefficients[ok], duration[ok]

    def _cost_of_motion(self, t, p, coefficients, duration):
        """Cost (m,) of progress, speed, altitude and smoothness: all but clearance."""
        mission = self.mission
        T = duration[:, None]
        end, v = (evaluate(coefficients, T, order)[:, 0] for order in (0, 1))
        to_go = self.guide.cost_to_go(np.concatenate([p[None], end]))
        metre = min(float(self.guide.cost(p[None])[0]), 5.0)
        progress = (to_go[0] - to_go[1:]) / (duration * mission.speed_mps * metre)
        speed = np.linalg.norm(v, axis=1) / mission.speed_mps - 1
        altitude = end[:, 2] - self.clearance.ground_m(end[:, :2])
        wanted = mission.altitude_at(t + float(duration.mean()), self.limits)
        off = (altitude - wanted) / (2 + 0.3 * wanted)
        j = evaluate(coefficients, T * np.array([0.0, 0.5, 1.0]), 3)
        rough = np.square(j).sum(axis=-1) @ np.array([1, 4, 1]) / 6 / 10**2  # Simpson: exact
        return -2 * progress + 0.5 * speed**2 + off**2 + 0.15 * rough

    def _cost_of_clearance(self, coefficients, duration):
        """Cost (m,) of missing clearance; infinite where a sample is too near."""
        times = duration[:, None] * (np.arange(1, _SAMPLES + 1) / _SAMPLES)
        points = evaluate(coefficients, times, 0)
        flat = points.reshape(-1, 3)
        obstacle = self.clearance.obstacle_m(flat).reshape(times.shape)
        altitude = (flat[:, 2] - self.clearance.ground_m(flat[:, :2])).reshape(times.shape)
        low, high = self.limits.altitude_m
        ok = (obstacle >= self.limits.needed_m) & (altitude >= low) & (altitude <= high)
        missing = np.square(shortfall(obstacle, self.mission.clearance_m)).mean(axis=1)
        return np.where(ok.all(axis=1), 3 * missing, np.inf)

    def _safe(self, coefficients, duration) -> bool:
        """Whether a primitive (5, 3) keeps every limit at every moment, not at samples only."""
        limits = self.limits
        count = max(int(duration / 0.02), int(limits.max_speed_mps * duration / _DENSE_M)) + 2
        times = np.linspace(0, duration, count)
        if not self._dynamic(coefficients[None], times[None])[0]:
            return False
        points = evaluate(coefficients, times, 0)
        low, high = self.clearance.bounds
        if not ((points[:, :2] >= low) & (points[:, :2] <= high)).all():
            return False
        altitude = points[:, 2] - self.clearance.ground_m(points[:, :2])
        if altitude.min() < limits.altitude_m[0] or altitude.max() > limits.altitude_m[1]:
            return False
        # The true distance changes by no more than the way flown, so between two samples it is at
        # least the samples' bound less half their spacing.
        step = np.linalg.norm(np.diff(points, axis=0), axis=1).max()
        return bool(self.clearance(points).min() >= limits.needed_m + step / 2)
