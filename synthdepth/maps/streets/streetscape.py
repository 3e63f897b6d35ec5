"""What stands along the streets: poles and wires, lamps, trees, signs, parked cars."""

import dataclasses
from typing import Protocol

import numpy as np
import shapely

from synthdepth.maps.furniture.poles import utility_line
from synthdepth.maps.furniture.signs import signs, street_lamps
from synthdepth.maps.gardens.items import scatter
from synthdepth.maps.gardens.lots import LotPlan
from synthdepth.maps.geometry import Model
from synthdepth.maps.placement import distance_to, on_ground, points_along
from synthdepth.maps.streets.network import Street, resampled
from synthdepth.maps.streets.plan import KERB_WIDTH_M, StreetPlan, along
from synthdepth.maps.streets.surface import KERB_HEIGHT_M
from synthdepth.maps.terrain import Terrain
from synthdepth.maps.vehicles.vehicle import park

_POLE_SPACING_M = 38.0
# Longer spans are not built; where poles cannot stand, the line ends.
_LONGEST_SPAN_M = 62.0
_DROP_REACH_M = 32.0
_CAR_LENGTH_M = 6.5
_CAR_DETAIL_M = 55.0


class Character(Protocol):
    """What the streets need to know of their suburb."""

    street_tree_spacing_m: float
    parked_share: float
    utility_line_share: float
    lamp_spacing_m: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Streetscape:
    """Where everything along the streets stands; [m] and [rad].

    Attributes:
        lines: (k, 3) pole bases of each run of poles.
        drops: (m, 3) points on houses that each line feeds.
        lamps, signs, hydrants: (k, 4) x, y, z and heading; signs by kind.
        cars: (k, 4), on the carriageway and on drives.
        trees: (k, 2).
        tufts: (k, 2), at the edges of pavements.
    """

    lines: list[np.ndarray]
    drops: list[np.ndarray]
    lamps: np.ndarray
    signs: dict[str, np.ndarray]
    hydrants: np.ndarray
    cars: np.ndarray
    trees: np.ndarray
    tufts: np.ndarray

    def models(self, rng: np.random.Generator, bounds: np.ndarray) -> list[Model]:
        """All but the trees and tufts."""
        lanes = rng.spawn(5)
        models = [
            utility_line(lanes[0], line, drops)
            for line, drops in zip(self.lines, self.drops, strict=True)
        ]
        models.append(street_lamps(lanes[1], self.lamps[:, :3], self.lamps[:, 3]))
        models += [
            signs(lanes[2], at[:, :3], at[:, 3], kind) for kind, at in self.signs.items() if len(at)
        ]
        models.append(scatter(lanes[3], "hydrant", self.hydrants[:, :3], self.hydrants[:, 3]))
        # `park` shows cars in full up to 80 m: that much only of those that a drone can reach.
        near = distance_to(bounds, self.cars) + _CAR_DETAIL_M
        models.append(park(lanes[4], self.cars[:, :3], self.cars[:, 3], near))
        return models


def furnish_streets(
    rng: np.random.Generator,
    plan: StreetPlan,
    terrain: Terrain,
    lots: list[LotPlan],
    town: Character,
) -> Streetscape:
    """Choose where everything along the streets stands; nothing stands on a drive."""
    lanes = rng.spawn(8)
    drives = [polygon for lot in lots for polygon in lot.paved]
    middle = KERB_WIDTH_M + plan.verge_m / 2
    lines = _pole_lines(lanes[0], plan, terrain, drives, town.utility_line_share)
    drops = _drops(lines, lots, terrain)

    taken = [*drives, *_squares(np.concatenate([*lines, np.zeros((0, 3))]), 1.5)]
    lamps = _placed(
        lanes[1],
        plan,
        terrain,
        taken,
        spacing_m=town.lamp_spacing_m,
        kerb_offset_m=0.6,
        sides="one",
    )
    lamps[:, 3] += np.pi / 2  # arms reach over the carriageway
    taken += _squares(lamps, 2.0)
    hydrants = _placed(
        lanes[2], plan, terrain, taken, spacing_m=110.0, kerb_offset_m=0.7, sides="one"
    )
    taken += _squares(hydrants, 1.5)
    posted = _placed(lanes[3], plan, terrain, taken, spacing_m=70.0, kerb_offset_m=0.75)
    posted[:, 3] += np.pi  # faces the traffic
    kind = lanes[3].choice(["speed_limit", "parking", "warning"], len(posted), p=[0.4, 0.35, 0.25])
    posts = {name: posted[kind == name] for name in ("parking", "speed_limit", "warning")}
    posts |= _junction_signs(plan, terrain)
    taken += _squares(posted, 2.0)
    trees, _ = along(
        lanes[4],
        plan,
        spacing_m=town.street_tree_spacing_m,
        kerb_offset_m=middle,
        jitter_m=1.5,
        keep_clear=taken,
        clear_m=1.5,
    )
    gone = lanes[4].random(len(trees)) < 0.12
    return Streetscape(
        lines=lines,
        drops=drops,
        lamps=lamps,
        signs=posts,
        hydrants=hydrants,
        cars=_cars(lanes[5], plan, terrain, lots, drives, town.parked_share),
        trees=trees[~gone],
        tufts=_edge_tufts(lanes[6], plan),
    )


def _placed(rng, plan, terrain, taken, *, sides="both", **where) -> np.ndarray:
    """Places along the streets as (k, 4): x, y, z and the heading of the traffic."""
    xy, heading = along(rng, plan, jitter_m=1.0, keep_clear=taken, sides=sides, **where)
    return np.column_stack([on_ground(terrain, xy), heading])


def _squares(points: np.ndarray, half_m: float) -> list[np.ndarray]:
    """Squares (4, 2) around points, as areas to keep clear."""
    ring = half_m * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    return list(points[:, None, :2] + ring)


def _pole_lines(
    rng: np.random.Generator,
    plan: StreetPlan,
    terrain: Terrain,
    drives: list[np.ndarray],
    share: float,
) -> list[np.ndarray]:
    """Runs of pole bases (k, 3) in the planting strip, on one side of a share of the streets."""
    strip = plan.verge.buffer(-0.35)
    if drives:
        strip = shapely.difference(strip, shapely.union_all([shapely.Polygon(d) for d in drives]))
    shapely.prepare(strip)
    lines = []
    for street in plan.streets:
        side, chance = rng.choice([-1.0, 1.0]), rng.random()
        if chance > share and street.kind != "collector":
            continue
        path = shapely.LineString(
            _beside(street, side * (street.width_m / 2 + 0.15 + plan.verge_m / 2))
        )
        run: list[np.ndarray] = []
        for at in np.arange(6.0, path.length, _POLE_SPACING_M) + rng.uniform(0, 10):
            # A pole that would stand on a drive or a crossing moves along the kerb.
            near = shapely.line_interpolate_point(path, at + np.array([0, 2.5, -2.5, 5, -5, 8, -8]))
            xy = shapely.get_coordinates(near)
            free = np.flatnonzero(shapely.contains_xy(strip, xy[:, 0], xy[:, 1]))
            if len(free) == 0:
                continue
            foot = on_ground(terrain, xy[free[:1]])[0]
            if run and np.hypot(*(foot - run[-1])[:2]) > _LONGEST_SPAN_M:
                lines.append(run)
                run = []
            if not run or np.hypot(*(foot - run[-1])[:2]) > 15:
                run.append(foot)
        lines.append(run)
    return [np.array(run) for run in lines if len(run) >= 2]


def _beside(street: Street, offset_m: float) -> np.ndarray:
    """A line (n, 2) [m] beside a street's centreline; positive offsets are to its left."""
    line = resampled(street.centreline)
    ahead = np.gradient(line, axis=0)
    ahead /= np.linalg.norm(ahead, axis=1, keepdims=True)
    return line + offset_m * np.column_stack([-ahead[:, 1], ahead[:, 0]])


def _drops(lines: list[np.ndarray], lots: list[LotPlan], terrain: Terrain) -> list[np.ndarray]:
    """For each line, the points on houses (m, 3) that are nearest to it and within reach."""
    drops: list[list[np.ndarray]] = [[] for _ in lines]
    if not lines:
        return []
    poles = np.concatenate(lines)
    owner = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
    for lot in lots:
        point = lot.eaves(terrain)
        if point is None:
            continue
        away = np.hypot(*(poles - point)[:, :2].T)
        nearest = int(np.argmin(away))
        if away[nearest] < _DROP_REACH_M:
            drops[owner[nearest]].append(point)
    return [np.array(points).reshape(-1, 3) for points in drops]


def _junction_signs(plan: StreetPlan, terrain: Terrain) -> dict[str, np.ndarray]:
    """A stop sign where a street ends on another, and the street's name opposite."""
    stops, names = [], []
    for x, y, index, end in plan.approaches:
        street = plan.streets[int(index)]
        line = street.centreline if end == 0 else street.centreline[::-1]
        away = line[min(3, len(line) - 1)] - line[0]
        away /= np.hypot(*away)
        right = np.array([-away[1], away[0]])  # of traffic towards the junction
        edge = street.width_m / 2 + 0.75
        for places, back, across in ((stops, 11.5, right), (names, 10.5, -right)):
            xy = np.array([x, y]) + away * back + across * edge
            if not plan.carriageway.contains(shapely.Point(xy)):
                places.append([*xy, np.arctan2(away[1], away[0])])
    found = {}
    for name, places in (("stop", stops), ("street_name", names)):
        at = np.array(places).reshape(-1, 3)
        found[name] = np.column_stack([on_ground(terrain, at[:, :2]), at[:, 2]])
    return found


def _cars(
    rng: np.random.Generator,
    plan: StreetPlan,
    terrain: Terrain,
    lots: list[LotPlan],
    drives: list[np.ndarray],
    share: float,
) -> np.ndarray:
    """Parked cars (k, 4): along the kerb, and on the drives."""
    xy, heading = along(
        rng,
        plan,
        spacing_m=_CAR_LENGTH_M,
        kerb_offset_m=-1.15,
        jitter_m=0.4,
        keep_clear=drives,
        clear_m=2.8,
    )
    stays = rng.random(len(xy)) < share
    xy, heading = xy[stays], heading[stays]
    flip = rng.random(len(xy)) < 0.06  # some park against the traffic
    kerb = np.column_stack(
        [on_ground(terrain, xy), heading + np.pi * flip + np.radians(rng.normal(0, 1, len(xy)))]
    )
    kerb[:, 2] -= KERB_HEIGHT_M
    own = np.concatenate([lot.cars for lot in lots] + [np.zeros((0, 3))])
    drive = np.column_stack([on_ground(terrain, own[:, :2]), own[:, 2]])
    return np.concatenate([kerb, drive])


def _edge_tufts(rng: np.random.Generator, plan: StreetPlan) -> np.ndarray:
    """Grass that the mower misses, along the edges of the planting strips, (k, 2) [m]."""
    edges = shapely.get_parts(shapely.boundary(plan.verge.buffer(-0.06)))
    points = [points_along(edge, 0.8, rng) for edge in edges if edge.length > 4]
    return np.concatenate([*points, np.zeros((0, 2))])
