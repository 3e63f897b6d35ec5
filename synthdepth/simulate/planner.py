"""Where to fly, from a depth picture: the rules that choose a section, for many drones at once."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.config import Config, choice, number
from synthdepth.simulate.drone import Command, DroneConfig, camera_rotations
from synthdepth.simulate.sections import section_means, section_minima, section_rays

# How fast a drone returns into its band of altitudes [1/s].
_ALTITUDE_RATE = 1.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sight:
    """What a rule may go by; depths are saturated at the source's range.

    Attributes:
        mean_share: (n, 17, 17) mean depth of the sections, as a share of the range.
        least_share: (n, 17, 17) least depth, likewise.
        toward_goal: (n, 17, 17) cosine of the angle between section and goal.
        needed_share: (n,) way in which a drone can turn aside, likewise.
    """

    mean_share: np.ndarray
    least_share: np.ndarray
    toward_goal: np.ndarray
    needed_share: np.ndarray


def _total(sight: Sight) -> np.ndarray:
    return sight.mean_share


def _nearest(sight: Sight) -> np.ndarray:
    return sight.least_share


def _goal(sight: Sight) -> np.ndarray:
    # Beyond the range nothing is known, so what is free up to there must do.
    needed = np.minimum(sight.needed_share, 1)[:, None, None]
    return np.where(sight.least_share >= needed, 2 + sight.toward_goal, sight.least_share)


# Score of each section, (n, 17, 17); the highest is flown to.
RULES: dict[str, Callable[[Sight], np.ndarray]] = {
    "total": _total,
    "nearest": _nearest,
    "goal": _goal,
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class PlannerConfig(Config):
    """How a section is chosen and how fast the drone flies there.

    Attributes:
        rule: "total", the section with the largest total depth (section 5.4 of the paper);
            "nearest", whose nearest obstacle is farthest; "goal", of those that are free as far as
            the drone needs to turn aside the one nearest the goal, or else as "nearest".
        goal_pull: what the goal adds to a section's score: this times the cosine of the angle
            between them. 1 weighs as much as the whole range of depth, 0 is the paper's rule.
        tie_share: scores that differ by less count as equal; of equal ones the section nearest the
            goal is taken.
        margin_m: of free space that turning aside and halting leave beside the drone's own radius.
        speed: "cruise", the flight's own throughout; "sight", no faster than lets it halt within
            the least depth of the chosen section.
    """

    rule: str = choice("total", tuple(RULES))
    goal_pull: float = number(0.0, 0, 10)
    tie_share: float = number(1e-6, 0, 1)
    margin_m: float = number(0.5, 0, 10)
    speed: str = choice("cruise", ("cruise", "sight"))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Situation:
    """Where n drones are and what they want.

    Attributes:
        position_m: (n, 3) float64.
        yaw_rad: (n,) float64, of the camera.
        altitude_m: (n,) float64 above ground.
        goal_m: (n, 3) float64.
        cruise_mps: (n,) float64.
    """

    position_m: np.ndarray
    yaw_rad: np.ndarray
    altitude_m: np.ndarray
    goal_m: np.ndarray
    cruise_mps: np.ndarray


class Planner:
    """Turns depth pictures into commands.

    Args:
        config: rule and speed.
        drone: limits of the drones.
        camera: intrinsics of a picture that shows what the depth pictures show; they may be of
            another size.
        altitude_m: (lowest, highest) above ground that the drones keep to.
    """

    def __init__(
        self,
        config: PlannerConfig,
        drone: DroneConfig,
        camera: Intrinsics,
        altitude_m: tuple[float, float],
    ):
        self.config, self.drone, self.altitude_m = config, drone, altitude_m
        self.rays = section_rays(camera)
        self._kept_m = drone.radius_m + config.margin_m
        self._slack_rad = math.atan(camera.height / 18 / camera.fy) / 2

    def command(self, depth_m: np.ndarray, max_depth_m: float, now: Situation) -> Command:
        """What n drones are told.

        Args:
            depth_m: (n, H, W) planar depth [m]; beyond the range and unknown alike counts as at it.
            max_depth_m: the range.
            now: of each drone at its picture.
        """
        depth_m = np.clip(np.nan_to_num(depth_m, nan=np.inf), 0, max_depth_m)
        least = section_minima(depth_m)
        cruise, climb = now.cruise_mps, self._climb_limits(now)
        rotation = camera_rotations(now.yaw_rad, self.drone.camera_pitch_deg)
        rays = np.einsum("nij,rcj->nrci", rotation, self.rays)
        goal = now.goal_m - now.position_m
        goal = goal / np.maximum(np.linalg.norm(goal, axis=1, keepdims=True), 1e-9)
        sight = Sight(
            mean_share=section_means(depth_m) / max_depth_m,
            least_share=least / max_depth_m,
            toward_goal=np.einsum("nrci,ni->nrc", rays, goal),
            needed_share=self.turn_m(cruise) / max_depth_m,
        )
        row, column = self.choose(sight, self._flyable(rays[..., 2], cruise, climb))
        each = np.arange(len(cruise))
        ray, least = rays[each, row, column], least[each, row, column]
        speed = cruise
        if self.config.speed == "sight":
            speed = np.minimum(self.halting_mps(least), cruise)
        velocity = speed[:, None] * ray
        velocity[:, 2] = np.clip(velocity[:, 2], *climb)
        return Command(
            velocity_mps=velocity,
            yaw_rad=np.arctan2(ray[:, 1], ray[:, 0]),
            section=np.stack([row, column], axis=-1),
        )

    def choose(self, sight: Sight, flyable: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Row and column (n,) int64 each of the chosen sections.

        Args:
            sight: what is seen.
            flyable: (n, 17, 17) bool, the sections to choose from; at least one each.
        """
        score = RULES[self.config.rule](sight) + self.config.goal_pull * sight.toward_goal
        score = np.where(flyable, score, -np.inf)
        best = score.max(axis=(1, 2), keepdims=True)
        # Of equal ones nearest the goal; where that is equal, too, nearest the picture's middle.
        wanted = sight.toward_goal + 1e-6 * self.rays[..., 2]
        wanted = np.where(score >= best - self.config.tie_share, wanted, -np.inf)
        return np.unravel_index(wanted.reshape(len(score), -1).argmax(axis=1), score.shape[1:])

    def turn_m(self, speed_mps: np.ndarray) -> np.ndarray:
        """Way (n,) [m] ahead in which a drone can turn aside, radius and margin included: late by
        its reaction, then along a circle of the largest acceleration."""
        circle = speed_mps**2 / self.drone.max_acceleration_mps2
        return self._kept_m + speed_mps * self.drone.reaction_s + circle

    def halt_m(self, speed_mps: np.ndarray) -> np.ndarray:
        """Way (n,) [m] that a drone needs to come to a halt, radius and margin included."""
        braking = speed_mps**2 / (2 * self.drone.max_acceleration_mps2)
        return self._kept_m + speed_mps * self.drone.reaction_s + braking

    def halting_mps(self, way_m: np.ndarray) -> np.ndarray:
        """The speed (n,) [m/s] that needs a way (n,) [m]: the inverse of `halt_m`, at least 0."""
        a, way = self.drone.max_acceleration_mps2, np.maximum(way_m - self._kept_m, 0)
        late = a * self.drone.reaction_s
        return np.sqrt(late**2 + 2 * a * way) - late

    def _climb_limits(self, now: Situation) -> tuple[np.ndarray, np.ndarray]:
        """Least and largest vertical speed (n,) [m/s] that keep a drone in its altitudes."""
        low, high = self.altitude_m
        most = self.drone.max_climb_mps
        down = np.clip(_ALTITUDE_RATE * (low - now.altitude_m), -most, most)
        return down, np.clip(_ALTITUDE_RATE * (high - now.altitude_m), -most, most)

    def _flyable(self, sine, cruise_mps, climb) -> np.ndarray:
        """Which sections (n, 17, 17) lie where a drone may climb or sink to, or nearest there.

        Args:
            sine: (n, 17, 17) of the sections' elevation.
            cruise_mps: (n,).
            climb: limits from `_climb_limits`.
        """
        elevation = np.arcsin(np.clip(sine, -1, 1))
        low, high = (
            np.arcsin(np.clip(limit / cruise_mps, -1, 1))[:, None, None] for limit in climb
        )
        off = np.maximum(np.maximum(low - elevation, elevation - high), 0)
        return off <= np.maximum(off.min(axis=(1, 2), keepdims=True), self._slack_rad)
