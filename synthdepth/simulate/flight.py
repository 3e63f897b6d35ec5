"""The closed loop: depth, command, motion, contact; several flights in the air at once."""

import collections
import dataclasses
import math
from collections.abc import Callable, Iterable, Iterator

import numpy as np

from synthdepth.config import Config, number
from synthdepth.dataset.sample import Sample
from synthdepth.simulate.collision import Mesh
from synthdepth.simulate.drone import Command, DroneConfig, Motion, advance, camera_pose
from synthdepth.simulate.eyes import Eyes, Look
from synthdepth.simulate.planner import Planner, PlannerConfig, Situation
from synthdepth.simulate.scenario import Scenario, ScenarioRanges
from synthdepth.simulate.sources import DepthSource

# How far clearance is looked for.
REACH_M = 5.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Rules(Config):
    """How all flights of a run are flown.

    Attributes:
        drone, planner, scenario: what their classes say.
        lockstep: flights in the air at once, whose depth is found together.
        batch: pictures that a model is given at once, always as many; see `sources.Predicted`.
    """

    drone: DroneConfig = dataclasses.field(default_factory=DroneConfig)
    planner: PlannerConfig = dataclasses.field(default_factory=PlannerConfig)
    scenario: ScenarioRanges = dataclasses.field(default_factory=ScenarioRanges)
    lockstep: int = number(8, 1, 1024)
    batch: int = number(4, 1, 1024)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Place:
    """A scene to fly in.

    Attributes:
        map: name of the map.
        scene_index: number of the scene.
        scene_seed: its seed.
        bounds: (2, 2) float64 flight bounds [m].
        ground_m: height of the ground (n,) [m] at points (n, 2) [m].
        mesh: all that can be hit.
        eyes: the drones' camera.
    """

    map: str
    scene_index: int
    scene_seed: int
    bounds: np.ndarray
    ground_m: Callable[[np.ndarray], np.ndarray]
    mesh: Mesh
    eyes: Eyes


@dataclasses.dataclass(frozen=True, kw_only=True)
class Decision:
    """What a flight decided by a picture.

    Attributes:
        look: the moment.
        sample: what the source was shown.
        depth_m: (H, W) [m], what it said.
        section: row and column of the section that is flown to.
        goal_m: (3,) float64.
    """

    look: Look
    sample: Sample
    depth_m: np.ndarray
    section: tuple[int, int]
    goal_m: np.ndarray


@dataclasses.dataclass(kw_only=True)
class _Airborne:
    """A flight in the air.

    Attributes:
        scenario: what it is asked to do.
        position_m, velocity_mps: (3,) float64.
        yaw_rad, yaw_rate: of drone and camera.
        told: velocity and yaw (4,) of the latest commands, the newest first.
        frame: number of the next frame.
        seen: the last frame.
        track: positions at the frames.
        way_m: flown so far.
        effort: integral of the squared acceleration [m^2/s^3].
        near_m: least distance of the centre to anything so far; never more than the reach.
        free_m: nothing is nearer than this to where it is now.
    """

    scenario: Scenario
    position_m: np.ndarray
    velocity_mps: np.ndarray
    yaw_rad: float
    told: collections.deque
    near_m: float
    yaw_rate: float = 0.0
    frame: int = 0
    seen: Sample | None = None
    track: list = dataclasses.field(default_factory=list)
    way_m: float = 0.0
    effort: float = 0.0
    free_m: float = 0.0


@dataclasses.dataclass(frozen=True)
class _Ending:
    end: str
    step: int
    share: float
    triangle: int = -1


def fly(
    scenarios: Iterable[Scenario],
    source: DepthSource,
    place: Place,
    rules: Rules,
    watch: Callable[[Decision], None] = lambda decision: None,
) -> Iterator[dict]:
    """Fly some scenarios of a scene with one depth source.

    A flight is the same whichever others are in the air.

    Args:
        scenarios: which; as flights end, the next ones start.
        source: of depth.
        place: the scene.
        rules: how they fly.
        watch: told of each decision.

    Yields:
        The fields of an `Outcome` but `source`, as each flight ends.
    """
    planner = Planner(rules.planner, rules.drone, place.eyes.camera, rules.scenario.altitude_m)
    waiting = collections.deque(scenarios)
    active: list[_Airborne] = []
    while waiting or active:
        while waiting and len(active) < rules.lockstep:
            active.append(_take_off(waiting.popleft(), rules.drone))
        _decide(active, source, planner, place, rules.drone, watch)
        motion = _move(active, rules.drone)
        contacts = _contacts(active, motion, place.mesh, rules.drone)
        endings = []
        for k, flight in enumerate(active):
            way = motion.position_m[:, k]
            endings.append(_ending(flight, way, contacts[k], place, rules))
            if endings[k] is not None:
                way[:] = _cut(way, endings[k])
            _log(flight, motion, k, endings[k], rules.drone)
        _measure_clearance(active, motion.position_m, place.mesh)
        for flight, ending in zip(active, endings, strict=True):
            if ending is not None:
                yield _outcome(flight, ending, place, rules.drone)
        active = [f for f, ending in zip(active, endings, strict=True) if ending is None]


def _take_off(scenario: Scenario, drone: DroneConfig) -> _Airborne:
    hover = np.array([0.0, 0.0, 0.0, scenario.yaw_rad])
    frames = -(-drone.latency_steps // drone.steps_per_frame) + 1
    return _Airborne(
        scenario=scenario,
        position_m=scenario.start_m,
        velocity_mps=np.zeros(3),
        yaw_rad=scenario.yaw_rad,
        told=collections.deque([hover] * frames, maxlen=frames),
        near_m=drone.radius_m + REACH_M,
    )


def _decide(active, source, planner: Planner, place: Place, drone: DroneConfig, watch) -> None:
    """Take a picture on each flight and add a command to what it is told."""
    looks = []
    position = np.stack([flight.position_m for flight in active])
    altitude = position[:, 2] - place.ground_m(position[:, :2])
    for flight, above in zip(active, altitude.tolist(), strict=True):
        pose = camera_pose(flight.position_m, flight.yaw_rad, drone.camera_pitch_deg)
        look = Look(
            scenario=flight.scenario.number,
            frame=flight.frame,
            world_from_cam=pose,
            velocity_mps=flight.velocity_mps,
            yaw_rate=flight.yaw_rate,
            altitude_m=above,
        )
        looks.append(look)
        flight.seen = place.eyes.sample(source.sees, look, flight.seen)
        flight.track.append([round(x, 2) for x in flight.position_m.tolist()])
    depth_m = source.depth_m([flight.seen for flight in active])
    command = planner.command(
        depth_m,
        source.max_depth_m,
        Situation(
            position_m=position,
            yaw_rad=np.array([flight.yaw_rad for flight in active]),
            altitude_m=altitude,
            goal_m=np.stack([flight.scenario.goal_m for flight in active]),
            cruise_mps=np.array([flight.scenario.speed_mps for flight in active]),
        ),
    )
    for k, flight in enumerate(active):
        flight.told.appendleft(np.array([*command.velocity_mps[k], command.yaw_rad[k]]))
        flight.frame += 1
        row, column = command.section[k].tolist()
        watch(
            Decision(
                look=looks[k],
                sample=flight.seen,
                depth_m=depth_m[k],
                section=(row, column),
                goal_m=flight.scenario.goal_m,
            )
        )


def _move(active: list[_Airborne], drone: DroneConfig) -> Motion:
    """The flights' motion from this frame to the next."""
    told = np.array([flight.told for flight in active])  # (n, frames back, 4)
    commands = []
    for step in range(drone.steps_per_frame):
        # How many frames ago the command was given that takes effect by now.
        back = max(-(-(drone.latency_steps - step) // drone.steps_per_frame), 0)
        commands.append(Command(velocity_mps=told[:, back, :3], yaw_rad=told[:, back, 3]))
    return advance(
        np.stack([flight.position_m for flight in active]),
        np.stack([flight.velocity_mps for flight in active]),
        np.array([flight.yaw_rad for flight in active]),
        commands,
        drone,
    )


def _contacts(active, motion: Motion, mesh: Mesh, drone: DroneConfig) -> list[tuple | None]:
    """Step, share of it and triangle of each flight's first contact; None without one."""
    ways = motion.position_m
    # The distance to anything changes by no more than the way flown.
    free = np.array([flight.free_m for flight in active]) - _lengths(ways)
    ask = np.flatnonzero(free <= drone.radius_m)
    start, end = (w[:, ask].reshape(-1, 3) for w in (ways[:-1], ways[1:]))
    share, triangle = (
        x.reshape(len(ways) - 1, -1) for x in mesh.first_contact(start, end, drone.radius_m)
    )
    contacts: list[tuple | None] = [None] * len(active)
    for column, k in enumerate(ask.tolist()):
        hit = np.flatnonzero(np.isfinite(share[:, column]))
        if len(hit):
            step = int(hit[0])
            contacts[k] = step, float(share[step, column]), int(triangle[step, column])
    return contacts


def _measure_clearance(active: list[_Airborne], ways: np.ndarray, mesh: Mesh) -> None:
    """Lower each flight's `near_m` along its way and renew its `free_m`.

    Args:
        active: n flights.
        ways: (k + 1, n, 3) that they have flown.
        mesh: all that can be hit.
    """
    length = _lengths(ways)
    before = np.array([flight.free_m for flight in active])
    near = np.array([flight.near_m for flight in active])
    free = before - length
    ask = np.flatnonzero(free < near)
    last, wide = ways[-1, ask], near[ask] + length[ask]
    free[ask] = np.minimum(mesh.distance(last, last, wide)[0], wide)
    # Between its ends a way comes no nearer than this.
    closer = ask[(before[ask] + free[ask] - length[ask]) / 2 < near[ask]]
    start, end = (w[:, closer].reshape(-1, 3) for w in (ways[:-1], ways[1:]))
    found = mesh.distance(start, end, np.tile(near[closer], len(ways) - 1))[0]
    near[closer] = np.minimum(near[closer], found.reshape(len(ways) - 1, -1).min(axis=0))
    for flight, f, n in zip(active, free.tolist(), near.tolist(), strict=True):
        flight.free_m, flight.near_m = f, n


def _lengths(ways: np.ndarray) -> np.ndarray:
    """Lengths (n,) of ways (k + 1, n, 3)."""
    return np.linalg.norm(np.diff(ways, axis=0), axis=-1).sum(axis=0)


def _ending(flight, way: np.ndarray, contact, place: Place, rules: Rules) -> _Ending | None:
    """The first thing on a way (k + 1, 3) that ends a flight, if any does."""
    scenario, ranges = flight.scenario, rules.scenario
    steps = len(way) - 1
    endings = []
    if contact is not None:
        endings.append(_Ending("collision", *contact))
    gap = way[:, :2] - scenario.goal_m[:2]
    for step in range(steps):
        share = _enters(gap[step], gap[step + 1], ranges.goal_radius_m)
        if share is not None:
            endings.append(_Ending("goal", step, share))
            break
    low, high = place.bounds + [[-ranges.beyond_m], [ranges.beyond_m]]
    outside = np.flatnonzero(((way[1:, :2] < low) | (way[1:, :2] > high)).any(axis=1))
    if len(outside):
        endings.append(_Ending("bounds", int(outside[0]), 1.0))
    # The frame's number was raised when its command was given.
    left = math.ceil(scenario.time_limit_s / rules.drone.step_s) - (flight.frame - 1) * steps
    if left <= steps:
        endings.append(_Ending("time", max(left, 1) - 1, 1.0))
    # min keeps the first of equal ones: who touches something at the goal has collided.
    return min(endings, key=lambda e: (e.step, e.share), default=None)


def _enters(start: np.ndarray, end: np.ndarray, radius: float) -> float | None:
    """Share of a segment (2,) at which it enters a circle around 0, or None."""
    d = end - start
    a, b, c = float(d @ d), float(start @ d), float(start @ start) - radius**2
    if c <= 0:
        return 0.0
    if b >= 0 or b * b < a * c:
        return None
    share = c / (-b + math.sqrt(b * b - a * c))
    return share if share <= 1 else None


def _cut(way: np.ndarray, ending: _Ending) -> np.ndarray:
    """A way (k + 1, 3) that stays where it ended."""
    end = way[ending.step] + ending.share * (way[ending.step + 1] - way[ending.step])
    return np.concatenate([way[: ending.step + 1], np.tile(end, (len(way) - ending.step - 1, 1))])


def _log(flight: _Airborne, motion: Motion, k: int, ending, drone: DroneConfig) -> None:
    """Add a frame interval, or its part up to the end, to a flight's figures."""
    position, velocity, yaw = (
        x[:, k] for x in (motion.position_m, motion.velocity_mps, motion.yaw_rad)
    )
    efforts = (np.diff(velocity, axis=0) ** 2).sum(axis=1) / drone.step_s
    if ending is not None:
        efforts[ending.step] *= ending.share
        efforts[ending.step + 1 :] = 0
    flight.way_m += float(np.linalg.norm(np.diff(position, axis=0), axis=1).sum())
    flight.effort += float(efforts.sum())
    flight.position_m = position[-1]
    flight.velocity_mps = velocity[-1 if ending is None else ending.step + 1]
    flight.yaw_rad = float(yaw[-1])
    flight.yaw_rate = float((yaw[-1] - yaw[-2]) / drone.step_s)


def _outcome(flight: _Airborne, ending: _Ending, place: Place, drone: DroneConfig) -> dict:
    scenario, end = flight.scenario, flight.position_m
    steps = (flight.frame - 1) * drone.steps_per_frame + ending.step + ending.share
    time = steps * drone.step_s
    left = float(np.hypot(*(scenario.goal_m - end)[:2]))
    collided = ending.end == "collision"

    def rounded(values: np.ndarray) -> list[float]:
        return [round(x, 2) for x in values.tolist()]

    return {
        "map": place.map,
        "scene_index": place.scene_index,
        "scene_seed": place.scene_seed,
        "scenario": scenario.number,
        "end": ending.end,
        "hit": place.mesh.label_name(ending.triangle) if collided else None,
        "hit_speed_mps": round(float(np.linalg.norm(flight.velocity_mps)), 3) if collided else None,
        "time_s": round(time, 4),
        "way_m": round(flight.way_m, 3),
        "straight_m": round(scenario.straight_m, 3),
        "shortest_m": scenario.shortest_m,
        "left_m": round(left, 3),
        "goal_speed_mps": round((scenario.straight_m - left) / max(time, drone.step_s), 4),
        "excess": round(flight.way_m / scenario.shortest_m - 1, 4)
        if ending.end == "goal" and scenario.shortest_m
        else None,
        "clearance_m": 0.0 if collided else round(flight.near_m - drone.radius_m, 4),
        "effort_m_s3": round(flight.effort / max(flight.way_m, 1e-9), 4),
        "latency_s": drone.latency_s,
        "speed_mps": round(scenario.speed_mps, 3),
        "blocked_by": scenario.blocked_by,
        "start_m": rounded(scenario.start_m),
        "goal_m": rounded(scenario.goal_m),
        "end_m": rounded(end),
        "track_m": flight.track,
    }
