"""What a flight is asked to do: start, goal and speed, drawn at random in a scene."""

import dataclasses
import math
from collections.abc import Callable

import numpy as np

from synthdepth.config import Config, number, span
from synthdepth.errors import FlightError
from synthdepth.maps.world import LABELS
from synthdepth.simulate.collision import Mesh

_PLACES = 64  # tried at once
_OVERHEAD_M = 300.0
_PIECE_M = 4.0
# A drone may start under these; anything else overhead is a roof or a ceiling.
_AIRY = [LABELS[name] for name in ("sky", "vegetation", "tree_trunk", "wire", "pole")]


@dataclasses.dataclass(frozen=True, kw_only=True)
class ScenarioRanges(Config):
    """What scenarios are drawn from, and when a flight ends; ranges are (lowest, highest).

    Attributes:
        speed_mps: cruise speed (22.2: the paper's drones at their fastest).
        distance_m: horizontal, from start to goal.
        altitude_m: above ground, of start and goal; flights keep to it.
        heading_deg: largest angle between the first look and the direction to the goal.
        room_m: free space around start and goal.
        goal_radius_m: a drone this near the goal, seen from above, has arrived.
        time_factor: a flight may take this many times as long as the straight way at cruise speed,
        spare_time_s: and this much more.
        beyond_m: how far outside the flight bounds a drone may go.
        max_draws: tries of 64 places before a scene is given up.
    """

    speed_mps: tuple[float, float] = span((10.0, 22.2), 0.1, 100)
    distance_m: tuple[float, float] = span((60.0, 350.0), 1, 5000)
    altitude_m: tuple[float, float] = span((2.0, 20.0), 0.5, 300)
    heading_deg: float = number(30.0, 0, 180)
    room_m: float = number(3.0, 0.1, 50)
    goal_radius_m: float = number(5.0, 0.1, 100)
    time_factor: float = number(3.0, 1, 100)
    spare_time_s: float = number(5.0, 0, 1000)
    beyond_m: float = number(30.0, 0, 90)
    max_draws: int = number(20, 1, 10_000)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Scenario:
    """One flight to fly, the same for every depth source.

    Attributes:
        number: within the scene.
        start_m, goal_m: (3,) float64.
        yaw_rad: where the drone looks at first; it hovers.
        speed_mps: cruise speed.
        time_limit_s: when it is over.
        blocked_by: label of what a straight flight to the goal would hit; None if nothing.
        shortest_m: length of the shortest free way to the goal's circle; None without one.
    """

    number: int
    start_m: np.ndarray
    goal_m: np.ndarray
    yaw_rad: float
    speed_mps: float
    time_limit_s: float
    blocked_by: str | None
    shortest_m: float | None = None

    @property
    def straight_m(self) -> float:
        """Horizontal distance from start to goal."""
        return float(np.hypot(*(self.goal_m - self.start_m)[:2]))


def draw_scenario(
    rng: np.random.Generator,
    number: int,
    mesh: Mesh,
    bounds: np.ndarray,
    ground_m: Callable[[np.ndarray], np.ndarray],
    ranges: ScenarioRanges,
    radius_m: float,
) -> Scenario:
    """A random scenario: start, direction, distance, altitude and speed.

    Args:
        rng: the scenario's lane.
        number: within the scene.
        mesh: all that can be hit.
        bounds: (2, 2) lower and upper corner [m] that start and goal keep to.
        ground_m: height of the ground (n,) [m] at points (n, 2) [m].
        ranges: what it is drawn from.
        radius_m: of the drone.

    Raises:
        FlightError: no free start with a free goal was found.
    """
    speed = rng.uniform(*ranges.speed_mps)
    heading = math.radians(ranges.heading_deg) * rng.uniform(-1, 1)
    low, high = bounds
    for _ in range(ranges.max_draws):
        start, goal = np.empty((2, _PLACES, 3))
        start[:, :2] = rng.uniform(low, high, (_PLACES, 2))
        course = rng.uniform(0, 2 * math.pi, _PLACES)
        distance = rng.uniform(*ranges.distance_m, _PLACES)
        goal[:, :2] = start[:, :2] + distance[:, None] * np.column_stack(
            [np.cos(course), np.sin(course)]
        )
        altitude = rng.uniform(*ranges.altitude_m, _PLACES)
        for place in (start, goal):
            place[:, 2] = ground_m(place[:, :2]) + altitude
        fits = ((goal[:, :2] >= low) & (goal[:, :2] <= high)).all(axis=1)
        for place in (start, goal):
            fits[fits] = _is_free(mesh, place[fits], ranges.room_m)
        if not fits.any():
            continue
        first = int(fits.argmax())
        start, goal = start[first], goal[first]
        toward = goal - start
        limit = ranges.time_factor * np.hypot(*toward[:2]) / speed + ranges.spare_time_s
        return Scenario(
            number=number,
            start_m=start,
            goal_m=goal,
            yaw_rad=math.atan2(toward[1], toward[0]) + heading,
            speed_mps=speed,
            time_limit_s=float(limit),
            blocked_by=_blocked_by(mesh, start, goal, radius_m),
        )
    raise FlightError(
        f"no start and goal in {ranges.max_draws * _PLACES} places: flights need "
        f"{ranges.room_m:g} m of room at {ranges.altitude_m[0]:g} to {ranges.altitude_m[1]:g} m "
        f"above ground, {ranges.distance_m[0]:g} to {ranges.distance_m[1]:g} m apart"
    )


def _is_free(mesh: Mesh, points: np.ndarray, room_m: float) -> np.ndarray:
    """Which points (n, 3) have room and nothing above them that a drone cannot have come through:
    (n,) bool."""
    free = np.isinf(mesh.distance(points, points, room_m)[0])
    _, above = mesh.first_contact(points, points + [0, 0, _OVERHEAD_M], 0.0)
    return free & ((above < 0) | np.isin(mesh.labels[above], _AIRY))


def _blocked_by(mesh: Mesh, start: np.ndarray, goal: np.ndarray, radius_m: float) -> str | None:
    count = max(int(np.linalg.norm(goal - start) / _PIECE_M), 1)
    way = start + np.linspace(0, 1, count + 1)[:, None] * (goal - start)
    share, triangle = mesh.first_contact(way[:-1], way[1:], radius_m)
    hit = np.flatnonzero(np.isfinite(share))
    return mesh.label_name(triangle[hit[0]]) if len(hit) else None
