"""How flights ended, and what that says of their depth sources."""

import dataclasses
import itertools
import math
import sys
import types
import typing
from collections.abc import Iterable
from statistics import NormalDist

from synthdepth.config import parse_json, shown

ENDS = ("goal", "collision", "time", "bounds")

# Table 6 of the paper: collision rate [%] of 400 flights a map in AirSim.
TABLE_6_FLIGHTS = 400
TABLE_6_SOURCES = ("10 m", "200 m", "Shimada et al.: RGB only", "the paper: embedded flow")
TABLE_6 = {
    "blocks": (58.75, 7.0, 17.5, 14.5),
    "city": (73.5, 26.0, 34.75, 34.0),
    "coastline": (70.5, 0.25, 1.5, 1.25),
    "neighborhood": (82.0, 7.0, 2.5, 1.0),
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Outcome:
    """One flight, as results hold it; positions in the world, to the centimetre.

    Attributes:
        map: name of the map.
        scene_index, scene_seed: which scene.
        scenario: number within the scene.
        source: what told the depth.
        end: one of `ENDS`.
        hit: label of what it hit; None without a collision, as below.
        hit_speed_mps: at the collision.
        time_s: how long it flew.
        way_m: how far it flew.
        straight_m: horizontal distance from start to goal.
        shortest_m: length of the shortest free way from start to the goal's circle, see
            `shortest.shortest_way`; None where none was found.
        left_m: likewise from its end to the goal.
        goal_speed_mps: distance won towards the goal, by the time.
        excess: way over the shortest free one, less 1; None where it did not arrive.
        clearance_m: least distance from the drone's surface to anything, told up to 5 m.
        effort_m_s3: integral of the squared acceleration, by the way: smooth flights have little.
        latency_s: from a frame to its command's effect.
        speed_mps: cruise speed.
        blocked_by: label of what a straight flight hits.
        start_m, goal_m, end_m: (3,).
        track_m: positions at the frames.
    """

    map: str
    scene_index: int
    scene_seed: int
    scenario: int
    source: str
    end: str
    hit: str | None
    hit_speed_mps: float | None
    time_s: float
    way_m: float
    straight_m: float
    shortest_m: float | None
    left_m: float
    goal_speed_mps: float
    excess: float | None
    clearance_m: float
    effort_m_s3: float
    latency_s: float
    speed_mps: float
    blocked_by: str | None
    start_m: list[float]
    goal_m: list[float]
    end_m: list[float]
    track_m: list[list[float]]

    @property
    def scenario_key(self) -> tuple:
        """What all sources' flights of one scenario have in common."""
        return self.map, self.scene_index, self.scenario


def outcome_of(line: bytes) -> Outcome:
    """The flight of a line of JSON; ValueError where it is none."""
    record = parse_json(line)
    kinds = typing.get_type_hints(Outcome)
    if not isinstance(record, dict) or record.keys() != kinds.keys():
        raise ValueError("a flight has other fields")
    for name, kind in kinds.items():
        if not _is_a(record[name], kind):
            raise ValueError(f"{name} is {shown(record[name])}")
    places = (record["start_m"], record["goal_m"], record["end_m"], *record["track_m"])
    if record["end"] not in ENDS or any(len(place) != 3 for place in places):
        raise ValueError("it ends nowhere")
    return Outcome(**record)


def _is_a(value, kind) -> bool:
    """Whether a value of JSON has the type of a field."""
    if isinstance(kind, types.UnionType):
        return any(_is_a(value, one) for one in typing.get_args(kind))
    if typing.get_origin(kind) is list:
        (one,) = typing.get_args(kind)
        return isinstance(value, list) and all(_is_a(each, one) for each in value)
    if kind is float:
        # JSON's whole numbers may have any number of digits.
        return type(value) in (int, float) and abs(value) <= sys.float_info.max
    return type(value) is kind


@dataclasses.dataclass(frozen=True, kw_only=True)
class Rate:
    """A share of flights with its Wilson interval at 95 %.

    Attributes:
        count: flights that it was so with.
        flights: all flights.
        value, low, high: share, 0 to 1.
    """

    count: int
    flights: int
    value: float
    low: float
    high: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Summary:
    """A source's flights on a map. Means are None where no flight has the value.

    Attributes:
        map: name of the map.
        source: name of the source.
        flights: how many.
        collision: collision rate, equation 22.
        blocked: likewise of the flights alone whose straight way to the goal is blocked; the others
            arrive by flying straight, seeing or not.
        goal, time, bounds: shares of the other ends.
        hits: how often each label was hit, most often first.
        excess: mean of flights that arrived.
        clearance_m: mean of flights that did not collide.
        goal_speed_mps, effort_m_s3: means of all flights.
        time_to_collision_s, hit_speed_mps: means of flights that collided.
    """

    map: str
    source: str
    flights: int
    collision: Rate
    blocked: Rate
    goal: Rate
    time: Rate
    bounds: Rate
    hits: dict[str, int]
    excess: float | None
    clearance_m: float | None
    goal_speed_mps: float | None
    effort_m_s3: float | None
    time_to_collision_s: float | None
    hit_speed_mps: float | None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Comparison:
    """McNemar's exact test of two sources over the same scenarios of a map.

    Attributes:
        map: name of the map.
        one, other: the sources.
        scenarios: flown by both.
        only_one, only_other: in how many only that source collided.
        p: of a difference at least this large if both collided equally often.
    """

    map: str
    one: str
    other: str
    scenarios: int
    only_one: int
    only_other: int
    p: float


def wilson_interval(count: int, total: int, level: float = 0.95) -> tuple[float, float]:
    """The score interval of a share (E. B. Wilson, JASA 22, 1927): ends within [0, 1].

    It takes flights as independent; those of one scene are alike, so it is somewhat too narrow.
    """
    if not total:
        return 0.0, 1.0
    z = NormalDist().inv_cdf((1 + level) / 2)
    p, spread = count / total, z * z / total
    middle = (p + spread / 2) / (1 + spread)
    half = z * math.sqrt(p * (1 - p) / total + spread / (4 * total)) / (1 + spread)
    # With none or all the interval ends there; rounding must not move it.
    low = 0.0 if count == 0 else middle - half
    return low, 1.0 if count == total else middle + half


def mcnemar(only_one: int, only_other: int) -> float:
    """Two-sided exact p-value of McNemar's test (Q. McNemar, Psychometrika 12, 1947): under equal
    rates, each pair that differs does so either way with probability 1/2."""
    n, fewer = only_one + only_other, min(only_one, only_other)
    tail = sum(math.comb(n, k) for k in range(fewer + 1))
    return min(1.0, 2 * tail / 2**n)


def rate(count: int, flights: int) -> Rate:
    """A share with its interval."""
    low, high = wilson_interval(count, flights)
    value = count / flights if flights else 0.0
    return Rate(count=count, flights=flights, value=value, low=low, high=high)


def summarise(outcomes: Iterable[Outcome]) -> list[Summary]:
    """The flights of each map and source, in the order in which they first come."""
    groups: dict[tuple[str, str], list[Outcome]] = {}
    for outcome in outcomes:
        groups.setdefault((outcome.map, outcome.source), []).append(outcome)
    return [_summary(*key, flights) for key, flights in groups.items()]


def compare_sources(outcomes: Iterable[Outcome]) -> list[Comparison]:
    """Every two sources of each map, over the scenarios that both have flown."""
    crashed: dict[str, dict[str, dict[tuple, bool]]] = {}
    for outcome in outcomes:
        sources = crashed.setdefault(outcome.map, {}).setdefault(outcome.source, {})
        sources[outcome.scenario_key] = outcome.end == "collision"
    comparisons = []
    for map_name, sources in crashed.items():
        for one, other in itertools.combinations(sources, 2):
            both = sources[one].keys() & sources[other].keys()
            b = sum(sources[one][key] and not sources[other][key] for key in both)
            c = sum(sources[other][key] and not sources[one][key] for key in both)
            comparisons.append(
                Comparison(
                    map=map_name,
                    one=one,
                    other=other,
                    scenarios=len(both),
                    only_one=b,
                    only_other=c,
                    p=mcnemar(b, c),
                )
            )
    return comparisons


def _summary(map_name: str, source: str, flights: list[Outcome]) -> Summary:
    ends = {end: rate(sum(f.end == end for f in flights), len(flights)) for end in ENDS}
    labels = [f.hit for f in flights if f.hit is not None]
    blocked = [f.end == "collision" for f in flights if f.blocked_by is not None]
    hits = {label: labels.count(label) for label in sorted(set(labels))}
    return Summary(
        map=map_name,
        source=source,
        flights=len(flights),
        blocked=rate(sum(blocked), len(blocked)),
        **ends,
        hits=dict(sorted(hits.items(), key=lambda item: -item[1])),
        excess=_mean(f.excess for f in flights),
        clearance_m=_mean(f.clearance_m for f in flights if f.end != "collision"),
        goal_speed_mps=_mean(f.goal_speed_mps for f in flights),
        effort_m_s3=_mean(f.effort_m_s3 for f in flights),
        time_to_collision_s=_mean(f.time_s for f in flights if f.end == "collision"),
        hit_speed_mps=_mean(f.hit_speed_mps for f in flights),
    )


def _mean(values: Iterable[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return math.fsum(known) / len(known) if known else None
