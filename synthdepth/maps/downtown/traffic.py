"""Vehicles: parked at the kerbs, queued at junctions, under way in the lanes; buses at stops."""

import dataclasses

import numpy as np
from scipy.spatial import cKDTree

from synthdepth.maps.downtown.grid import Grid
from synthdepth.maps.downtown.kerbside import CROSSING_M, Kerbside, parked_offset_m
from synthdepth.maps.geometry import Model, box, copies, join, merge, yaw_matrix
from synthdepth.maps.placement import distance_to
from synthdepth.maps.vehicles.vehicle import BODIES, draw_vehicle, park, vehicle

_TAXI_COLOURS = ((0.55, 0.33, 0.02), (0.02, 0.02, 0.022), (0.7, 0.7, 0.68), (0.2, 0.33, 0.2))
_BUS_COLOURS = ((0.36, 0.03, 0.03), (0.55, 0.56, 0.56), (0.04, 0.1, 0.24), (0.05, 0.2, 0.12),
                (0.5, 0.34, 0.04))  # fmt: skip
# A car within this distance of the flights is modelled in full, farther ones coarsely.
_NEAR_M = 12.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Traffic:
    """Where vehicles stand: x, y [m] and heading [rad].

    Attributes:
        cars: (n, 3), of any body.
        taxis, vans, buses: (n, 3).
    """

    cars: np.ndarray
    taxis: np.ndarray
    vans: np.ndarray
    buses: np.ndarray


def draw_traffic(
    rng: np.random.Generator,
    grid: Grid,
    kerbs: list[Kerbside],
    *,
    cars_per_km: float,
    reach_m: float,
) -> Traffic:
    """Vehicles on all streets within `reach_m` of the middle (per axis).

    Args:
        rng: the lane of the traffic.
        grid: the streets.
        kerbs: with parked cars and bus stops.
        cars_per_km: on a kilometre of each lane.
        reach_m: streets beyond it stay empty.
    """
    headway_m = 1000 / max(cars_per_km, 1e-3)
    places: dict[str, list] = {"cars": [], "taxis": [], "vans": [], "buses": []}
    kinds = np.array(["cars", "taxis", "vans", "buses"])
    stops = {kerb.edge: kerb for kerb in kerbs if kerb.stop_m is not None}
    for edge in range(len(grid.start)):
        profile, length = grid.profile(edge), grid.length_m[edge]
        if np.abs(grid.start[edge] + grid.end[edge]).max() / 2 > reach_m:
            continue
        low, high = grid.setback_m[edge, 0], length - grid.setback_m[edge, 1]
        if profile.kind == "alley" or high - low < 24:
            continue
        heading = np.arctan2(*grid.along[edge][::-1])
        for offset, direction in profile.lanes:
            # From the stop line backwards.
            at, span = CROSSING_M - 0.9, high - low - CROSSING_M
            queue = rng.poisson(min(90 / headway_m, 8)) if rng.random() < 0.55 else 0
            at += 0 if queue else rng.exponential(0.7 * headway_m)
            while True:
                kind = str(rng.choice(kinds, p=[0.8, 0.09, 0.08, 0.03]))
                long = {"buses": 12.2, "vans": 5.7}.get(kind, 5.0)
                if at + long > span:
                    break
                back = at + long / 2
                s = high - back if direction > 0 else low + back
                beside = stops.get(edge)
                # Lanes by a stop stay free for the bus that stands there.
                if beside is None or abs(s - beside.stop_m) > 16 or beside.side * offset < 0:
                    shift = offset + rng.normal(0, 0.12)
                    yaw = heading + (0 if direction > 0 else np.pi) + rng.normal(0, 0.008)
                    places[kind].append((*grid.at(edge, s, shift), yaw))
                queue -= 1
                gap = rng.uniform(1.4, 3.2) if queue > 0 else 7 + rng.exponential(headway_m)
                at += long + gap
    for kerb in kerbs:
        inward, yaw = parked_offset_m(kerb), kerb.yaw_flow(grid)
        for s in kerb.parked_m:
            kind = "vans" if rng.random() < 0.07 else "cars"
            turn = np.pi if rng.random() < 0.06 else 0.0
            near = inward + rng.normal(0, 0.06)
            point = kerb.at(grid, s, min(near, -0.95 if kind == "cars" else -1.06))
            places[kind].append((*point, yaw + turn + rng.normal(0, 0.012)))
        if kerb.stop_m is not None and rng.random() < 0.5:
            s = kerb.stop_m + kerb.flow * rng.uniform(-1, 2.5)
            places["buses"].append((*kerb.at(grid, s, -1.55), yaw + rng.normal(0, 0.01)))
    arrays = {name: np.array(rows, float).reshape(-1, 3) for name, rows in places.items()}
    return Traffic(**_apart(arrays))


def _apart(arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The same places without vehicles that overlap larger or earlier ones."""
    names = ("buses", "vans", "taxis", "cars")
    rows = np.concatenate([arrays[name] for name in names])
    kind = np.repeat(np.arange(4), [len(arrays[name]) for name in names])
    half_long = np.array([6.1, 2.85, 2.5, 2.5])[kind] + 0.3
    # A vehicle is three circles along its length.
    reach = np.minimum(half_long - 1.0, 5.0)
    u = np.stack([np.cos(rows[:, 2]), np.sin(rows[:, 2])], 1)
    steps = np.array([-1, -0.5, 0, 0.5, 1])[:, None, None]
    points = rows[None, :, :2] + steps * reach[None, :, None] * u[None]
    keep = np.ones(len(rows), bool)
    flat = points.reshape(-1, 2)
    owner = np.tile(np.arange(len(rows)), 5)
    pairs = cKDTree(flat).query_pairs(1.75, output_type="ndarray")
    pairs = owner[pairs]
    pairs = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
    for a, b in pairs:
        if keep[a]:
            keep[b] = False
    return {name: rows[(kind == k) & keep] for k, name in enumerate(names)}


def _fleet(rng, body: str, colours, places: np.ndarray, near: np.ndarray, sign: bool) -> Model:
    """Vehicles of one body in a few liveries; taxis carry a sign on the roof."""
    models = []
    which = rng.integers(len(colours), size=len(places))
    for number, colour in enumerate(colours):
        drawn = draw_vehicle(rng, body)
        for detail in (0, 1):
            mine = (which == number) & (near == bool(detail))
            if not mine.any():
                continue
            livery = dataclasses.replace(
                drawn, detail=detail, colour=colour if colour else drawn.colour
            )
            model = dict(vehicle(livery))
            if sign:
                high = BODIES[body].height_m * drawn.scale[2]
                light = box((0.2, 0.5, 0.16), (-0.15, 0, high - 0.02), (0.6, 0.55, 0.4))
                model["paint", "vehicle"] = join([model["paint", "vehicle"], light])
            at = np.column_stack([places[mine, :2], np.zeros(mine.sum())])
            turn = yaw_matrix(places[mine, 2])
            models.append({k: copies(p, at, rotation=turn) for k, p in model.items()})
    return merge(models)


def traffic_models(rng: np.random.Generator, traffic: Traffic, bounds: np.ndarray) -> list[Model]:
    """All vehicles, in full near the square that flights keep to."""
    cars = traffic.cars
    feet = np.column_stack([cars[:, :2], np.zeros(len(cars))])
    # `park` goes over to coarse models at 80 m.
    away = 80.0 / _NEAR_M * distance_to(bounds, cars)
    models: list[Model] = [park(rng, feet, cars[:, 2], away)]
    taxi = _TAXI_COLOURS[int(rng.integers(len(_TAXI_COLOURS)))]
    buses = [_BUS_COLOURS[i] for i in rng.permutation(len(_BUS_COLOURS))[:2]]
    fleets = (
        ("sedan", (taxi, taxi), traffic.taxis, True),
        ("van", (None,) * 4, traffic.vans, False),
        ("bus", buses, traffic.buses, False),
    )
    for body, colours, places, sign in fleets:
        if len(places):
            near = distance_to(bounds, places) < 2 * _NEAR_M
            models.append(_fleet(rng, body, colours, places, near, sign))
    return models
