"""Laying out the coast road and what stands along it: homes, car park, rails, poles, fences."""

import dataclasses
import functools

import numpy as np
import shapely

from synthdepth.maps.coast.shore import REACH_M, Shore
from synthdepth.maps.coast.terrain import HALF_M, ROAD_WIDTH_M, VERGE_M, Pad
from synthdepth.maps.gardens.lots import LotPlan, plan_lot
from synthdepth.maps.streets.lots import FRONT_GAP_M, Lot
from synthdepth.maps.streets.plan import KERB_WIDTH_M, PAVEMENT_WIDTH_M

LOT_DEPTH_M = 31.0
_SETBACK_M = ROAD_WIDTH_M / 2 + VERGE_M + FRONT_GAP_M + PAVEMENT_WIDTH_M + KERB_WIDTH_M


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Street:
    """What `plan_lot` needs to know of a street."""

    verge_m: float = VERGE_M


@dataclasses.dataclass(frozen=True, kw_only=True)
class Roadside:
    """Where things stand, in world x, y [m] and headings [rad].

    Attributes:
        lots: homes with their gardens.
        pads: levelled ground, for the terrain; of lots, car park and lighthouse.
        car_park: its pad, or None.
        parked, driving: (k, 3) x, y and heading of vehicles.
        lamps: (k, 3).
        poles: polylines (k, 2) of utility lines.
        signs: (name, x, y, heading).
        rails: lines (k, 2) of guard rail.
        fences: (line (k, 2), kind).
        boardwalk: (2, 2) from the road's side to the beach, or None.
        walkers: (k, 2) people by the road and the car park.
        road: (n, 2) the road's middle.
    """

    lots: list[LotPlan]
    pads: tuple[Pad, ...]
    car_park: Pad | None
    parked: np.ndarray
    driving: np.ndarray
    lamps: np.ndarray
    poles: list[np.ndarray]
    signs: list[tuple[str, float, float, float]]
    rails: list[np.ndarray]
    fences: list[tuple[np.ndarray, str]]
    boardwalk: np.ndarray | None
    walkers: np.ndarray
    road: np.ndarray

    @functools.cached_property
    def taken(self) -> shapely.Geometry:
        """Ground that plants keep off, as one prepared polygon."""
        parts = [shapely.Polygon(lot.lot.polygon) for lot in self.lots if lot.house is not None]
        parts += [shapely.LineString(self.road).buffer(ROAD_WIDTH_M / 2 + 0.5)]
        parts += [shapely.LineString(line).buffer(2.5) for line in self.poles]
        if len(self.parked):
            parts += [shapely.MultiPoint(self.parked[:, :2]).buffer(4.5)]
        if self.boardwalk is not None:
            parts += [shapely.LineString(self.boardwalk).buffer(1.6)]
        whole = shapely.union_all(parts)
        shapely.prepare(whole)
        return whole


class _Frame:
    """The road as a curve: places beside it by s and offset (positive inland)."""

    def __init__(self, shore: Shore, road_t_m: np.ndarray, road_z_m: np.ndarray):
        self.shore, self._t, self._z = shore, road_t_m, road_z_m

    def heading(self, s):
        """Of the road against s."""
        index = np.asarray(np.round(s), np.int64) + int(REACH_M)
        return np.arctan2(self._t[index + 2] - self._t[index - 2], 4.0)

    def local(self, s, offset) -> tuple[np.ndarray, np.ndarray]:
        """Local s, t."""
        turn = self.heading(s)
        t = np.interp(s, np.arange(-REACH_M, REACH_M + 0.5), self._t)
        return s - np.sin(turn) * offset, t + np.cos(turn) * offset

    def world(self, s, offset) -> np.ndarray:
        """(..., 2) x, y."""
        return self.shore.to_world(*self.local(np.asarray(s, float), np.asarray(offset, float)))

    def world_heading(self, s):
        """Of the road in the world."""
        return self.heading(s) + self.shore.yaw_rad

    def z(self, s) -> float:
        """Of the road's surface."""
        return float(np.interp(s, np.arange(-REACH_M, REACH_M + 0.5), self._z))

    def gap(self, s) -> np.ndarray:
        """Room between the cliff's brow and the road's seaward verge [m]."""
        look_up = self.shore.look_up
        brow = look_up("beach_m", s) + look_up("run_m", s)
        t = np.interp(s, np.arange(-REACH_M, REACH_M + 0.5), self._t)
        return self.shore.away_m(s, t) - brow - ROAD_WIDTH_M / 2 - VERGE_M


def _lot(frame: _Frame, s: float, width: float, side: int, depth: float) -> tuple[Lot, Pad]:
    """A parcel beside the road at s, on side +1 (inland) or -1, and its levelled ground."""
    turn = float(frame.heading(s))
    ahead = np.array([np.cos(turn), np.sin(turn)])
    inward = side * np.array([-np.sin(turn), np.cos(turn)])
    front = np.array(frame.local(s, side * _SETBACK_M))
    half = width / 2 - 0.3
    ring = front + np.stack(
        [-half * ahead, half * ahead, half * ahead + depth * inward, -half * ahead + depth * inward]
    )
    ring = ring if side > 0 else ring[::-1]
    to_world = frame.shore.to_world
    lot = Lot(
        polygon=to_world(ring[:, 0], ring[:, 1]),
        front=to_world(*front),
        inward=to_world(*inward),
        width_m=width - 0.6,
        depth_m=depth,
        kind="house",
        lawn_tint=np.ones(3),
    )
    middle = front + inward * (depth / 2 - 2.0)
    pad = Pad(
        s_m=float(middle[0]),
        t_m=float(middle[1]),
        heading_rad=turn,
        half_m=(width / 2, depth / 2 + 1.0),
        z_m=frame.z(s) + 0.12,
        blend_m=5.0,
    )
    return lot, pad


def _lots(rng, frame: _Frame, town, bounds, kept_free: list[tuple[float, float]]):
    """Homes along the road; seaward ones where there is room, and a few up the slope."""
    lots, pads = [], []
    for side in (1, -1):
        s = -HALF_M + rng.uniform(20, 50)
        while s < HALF_M - 30:
            width = float(rng.uniform(19, 27))
            here = np.linspace(s - width / 2, s + width / 2, 9)
            free = not any(a - width / 2 < s < b + width / 2 for a, b in kept_free)
            room = side > 0 or frame.gap(here).min() > LOT_DEPTH_M + 12
            if free and room and rng.random() < town.house_share * (1.0 if side > 0 else 0.7):
                lot, pad = _lot(frame, s, width, side, LOT_DEPTH_M)
                planned = plan_lot(rng, lot, _Street(), town, bounds)
                if planned.house is not None:
                    lots.append(planned)
                    pads.append(pad)
            s += width + (rng.uniform(0, 3) if rng.random() < 0.6 else rng.uniform(12, 60))
    return lots, pads


def plan_roadside(
    rng: np.random.Generator,
    shore: Shore,
    road: tuple[np.ndarray, np.ndarray],
    town,
    bounds: np.ndarray,
) -> Roadside:
    """Lay out everything along the road; `town` is the map's drawn character."""
    frame = _Frame(shore, *road)
    along = np.arange(-1000.0, 1001.0, 4.0)
    free: list[tuple[float, float]] = []
    car_park, parked = _car_park(rng, frame)
    if car_park is not None:
        middle = car_park.s_m
        free.append((middle - car_park.half_m[0] - 4, middle + car_park.half_m[0] + 4))
    lots, pads = _lots(rng, frame, town, bounds, free)
    if car_park is not None:
        pads.append(car_park)
    return Roadside(
        lots=lots,
        pads=tuple(pads),
        car_park=car_park,
        parked=parked,
        driving=_traffic(rng, frame),
        lamps=_lamps(rng, frame, town.lamp_spacing_m),
        poles=_poles(rng, frame),
        signs=_signs(rng, frame),
        rails=_rails(rng, frame),
        fences=_fences(rng, frame, lots, town.fence_kinds),
        boardwalk=_boardwalk(rng, frame, car_park),
        walkers=_walkers(rng, frame, parked),
        road=frame.world(along, 0 * along),
    )


def _car_park(rng, frame: _Frame) -> tuple[Pad | None, np.ndarray]:
    """Gravel beside the road where beach-goers leave their cars, on the seaward side."""
    s = rng.permutation(np.linspace(-150, 150, 31))
    for at in s:
        half = (float(rng.uniform(15, 24)), 6.5)
        reach = np.linspace(at - half[0] - 3, at + half[0] + 3, 13)
        if frame.gap(reach).min() < 18 or np.ptp(frame.heading(reach)) > 0.16:
            continue
        offset = -(ROAD_WIDTH_M / 2 + half[1] + 0.2)
        where = frame.local(at, offset)
        turn = float(frame.heading(at))
        pad = Pad(
            s_m=float(where[0]),
            t_m=float(where[1]),
            heading_rad=turn,
            half_m=half,
            z_m=frame.z(at) - 0.02,
        )
        slots = np.arange(-half[0] + 2, half[0] - 1.5, 2.75)
        slots = slots[rng.random(len(slots)) < rng.uniform(0.35, 0.85)]
        slots = slots + rng.normal(0, 0.12, len(slots))
        back = -2.6 + rng.normal(0, 0.25, len(slots))
        c, z = np.cos(turn), np.sin(turn)
        xy = frame.shore.to_world(where[0] + c * slots - z * back, where[1] + z * slots + c * back)
        heading = turn + frame.shore.yaw_rad + np.pi / 2 * rng.choice([-1, 1, -1], len(slots))
        heading = heading + rng.normal(0, 0.03, len(slots))
        return pad, np.column_stack([xy, heading])
    return None, np.zeros((0, 3))


def _traffic(rng, frame: _Frame) -> np.ndarray:
    s = np.cumsum(rng.uniform(35, 150, 16)) - 500
    s = s[np.abs(s) < 420]
    # They keep right: those that run along +s on the seaward side.
    way = rng.choice([-1, 1], len(s))
    xy = frame.world(s, -way * 1.7 + rng.normal(0, 0.12, len(s)))
    return np.column_stack([xy, frame.world_heading(s) + np.where(way > 0, 0, np.pi)])


def _walkers(rng, frame: _Frame, parked: np.ndarray) -> np.ndarray:
    """A few on the verge, some behind their cars."""
    s = rng.uniform(-200, 200, int(rng.integers(4, 12)))
    verge = frame.world(s, rng.choice([-1, 1], len(s)) * (ROAD_WIDTH_M / 2 + 0.55))
    ahead = np.stack([np.cos(parked[:, 2]), np.sin(parked[:, 2])], 1)
    behind = parked[:, :2] - 3.3 * ahead
    return np.concatenate([verge, behind[rng.random(len(behind)) < 0.35]])


def _lamps(rng, frame: _Frame, spacing_m: float) -> np.ndarray:
    first, last = np.sort(rng.uniform(-HALF_M, HALF_M, 2))
    first, last = min(first, -60.0), max(last, 90.0)
    s = np.arange(first, last, spacing_m)
    xy = frame.world(s, np.full(len(s), -(ROAD_WIDTH_M / 2 + 1.7)))
    return np.column_stack([xy, frame.world_heading(s) + np.pi / 2])


def _poles(rng, frame: _Frame) -> list[np.ndarray]:
    """Along the road's inland side, and a branch that climbs away from it."""
    side = ROAD_WIDTH_M / 2 + 2.4
    s = np.arange(-520.0, 521.0, rng.uniform(34, 44))
    lines = [frame.world(s, np.full(len(s), side))]
    for start in rng.uniform(-170, 170, int(rng.integers(1, 3))):
        turn = np.pi / 2 + rng.uniform(-0.7, 0.7)
        run = np.arange(9.0, 420.0, rng.uniform(38, 50))
        where = frame.local(start, side)
        branch = frame.shore.to_world(where[0] + run * np.cos(turn), where[1] + run * np.sin(turn))
        lines.append(branch)
    return lines


def _signs(rng, frame: _Frame) -> list[tuple[str, float, float, float]]:
    signs = []
    for name in rng.permutation(["speed_limit", "warning", "warning", "parking", "give_way"]):
        s, side = rng.uniform(-200, 200), int(rng.choice([-1, 1]))
        x, y = frame.world(s, side * (ROAD_WIDTH_M / 2 + 0.9))
        # It faces those who drive on its side.
        heading = float(frame.world_heading(s)) + (0.0 if side > 0 else np.pi)
        signs.append((str(name), float(x), float(y), heading))
    return signs


def _stretches(mask: np.ndarray, shortest: int) -> list[np.ndarray]:
    """Runs of True in a mask, as index arrays of at least `shortest` members."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [np.arange(a, b) for a, b in edges.reshape(-1, 2) if b - a >= shortest]


def _rails(rng, frame: _Frame) -> list[np.ndarray]:
    """Guard rail on the seaward side where the road runs near a drop, or bends."""
    s = np.arange(-HALF_M, HALF_M + 1, 4.0)
    drop = frame.shore.look_up("cliff_m", s) > 4
    bend = np.abs(np.gradient(frame.heading(s), 4.0)) > rng.uniform(0.0012, 0.004)
    mask = ((frame.gap(s) < 35) & drop) | bend
    return [
        frame.world(s[run], np.full(len(run), -(ROAD_WIDTH_M / 2 + 0.75)))
        for run in _stretches(mask, 5)
    ]


def _fences(rng, frame: _Frame, lots, kinds) -> list[tuple[np.ndarray, str]]:
    """Along cliff tops, and round the pastures behind the road."""
    shore = frame.shore
    s = np.arange(-HALF_M + 10, HALF_M - 9, 6.0)
    look_up = shore.look_up
    brow = (look_up("beach_m", s) + look_up("run_m", s) + 4.0) * look_up("stretch", s)
    edge = shore.to_world(s, look_up("line_m", s) + brow)
    lines = [
        (edge[run], "post_and_rail")
        for run in _stretches((look_up("cliff_m", s) > 5) & (frame.gap(s) > 9), 5)
    ]
    # Low fences keep people off the dunes, beside the road.
    mask = (look_up("cliff_m", s) <= 5) & (frame.gap(s) > 8)
    for run in _stretches(mask, 6):
        part = run[: int(rng.integers(5, 30))]
        lines.append((frame.world(s[part], np.full(len(part), -8.0)), "post_and_rail"))
    built = shapely.union_all([shapely.Polygon(lot.lot.polygon).buffer(3) for lot in lots])
    pasture = rng.choice(["post_and_rail", "chain_link", "wall"])
    cross = np.cumsum(rng.uniform(55, 120, 9)) - 310
    for at in cross[np.abs(cross) < HALF_M - 15]:
        offset = np.arange(7.0 + rng.uniform(0, 30), rng.uniform(110, 230), 6.0)
        lean = rng.uniform(-0.25, 0.25)
        lines.append((frame.world(at + lean * offset, offset), str(pasture)))
    for offset in np.cumsum(rng.uniform(42, 85, 3)) + 8:
        run = np.arange(*np.sort(rng.uniform(-HALF_M + 15, HALF_M - 15, 2)), 6.0)
        if len(run) > 8:
            lines.append((frame.world(run, np.full(len(run), offset)), str(pasture)))
    clear = []
    for line, kind in lines:
        whole = shapely.difference(shapely.LineString(line), built)
        clear += [
            (shapely.get_coordinates(part), kind)
            for part in shapely.get_parts(whole)
            if part.length > 8
        ]
    return clear


def _boardwalk(rng, frame: _Frame, car_park: Pad | None) -> np.ndarray | None:
    """Over the dunes to the beach; none where a cliff is in the way."""
    shore = frame.shore
    start = car_park.s_m + rng.uniform(-8, 8) if car_park is not None else rng.uniform(-120, 120)
    for s in (start, *rng.uniform(-150, 150, 12)):
        here = np.linspace(s - 6, s + 6, 5)
        if shore.look_up("cliff_m", here).max() < 3.0 and frame.gap(here).min() > 4:
            out = ROAD_WIDTH_M / 2 + (14.5 if car_park is not None and s == start else 1.5)
            beach = shore.look_up("beach_m", s) * 0.55
            end = (s, shore.look_up("line_m", s) + beach * shore.look_up("stretch", s))
            return np.stack([frame.world(s, -out), shore.to_world(*end)])
    return None
