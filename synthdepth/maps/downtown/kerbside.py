"""What lines the kerbs: where lamps, trees, parked cars, bus stops and furniture have their places.

Each side of each edge is laid out along its free stretch, so that nothing stands in anything else.
"""

import dataclasses

import numpy as np

from synthdepth.maps.downtown.grid import PARKING_M, Grid

CROSSING_M = 6.5  # kept free before junctions: zebra and stop line
BAY_M = 6.2  # length of a parking bay
BUS_BOX_M = 21.0
STAIRS_M = 16.0  # a footbridge's stairs reach so far along the pavement

# Small things between the trees, with the pavement width that they need [m].
_SMALL = {
    "bench": (2.0, 3.4),
    "litter_bin": (2.2, 2.4),
    "bicycle_rack": (1.5, 3.2),
    "parking_meter": (1.6, 2.4),
    "hydrant": (1.2, 2.4),
    "newspaper_box": (1.0, 2.6),
    "mailbox": (0.7, 2.6),
    "planter": (1.3, 3.0),
    "electric_box": (0.9, 2.6),
    "phone_box": (0.4, 3.4),
    "advertising_column": (0.35, 4.2),
    "kiosk": (0.4, 4.6),
    "traffic_cone": (0.25, 2.4),
    "barrier_crowd": (0.3, 3.0),
}
# Distance of the middle from the kerb [m]; others stand 0.75 m from it.
_SET_BACK_M = {"kiosk": 1.9, "advertising_column": 1.3, "bench": 0.95, "phone_box": 1.0}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Kerbside:
    """One side of an edge.

    Attributes:
        edge, side: of the grid; side is 1 on the left of the edge, -1 on its right.
        span_m: (from, to) along the edge, free of junctions and crossings.
        half_m: half the carriageway.
        pavement_m: width of the pavement.
        flow: 1 where cars at this kerb head along the edge, -1 against it.
        parked_m: (p,) bays that a car takes.
        stop_m: middle of a bus stop, or none.
        lamps_m, trees_m: (k,) places along the edge.
        small: furniture: (name, place along the edge, distance from the kerb).
    """

    edge: int
    side: int
    span_m: tuple[float, float]
    half_m: float
    pavement_m: float
    flow: int
    parking: bool
    parked_m: np.ndarray
    stop_m: float | None
    lamps_m: np.ndarray
    trees_m: np.ndarray
    small: tuple[tuple[str, float, float], ...]

    def at(self, grid: Grid, s_m, inward_m) -> np.ndarray:
        """Points (n, 2) at `s_m` along the edge and `inward_m` from the kerb into the pavement."""
        s = np.asarray(s_m, float)
        left = self.side * (self.half_m + np.broadcast_to(inward_m, s.shape))
        return grid.at(self.edge, s, left)

    def yaw_inward(self, grid: Grid) -> float:
        """Direction from the kerb towards the buildings [rad]."""
        u = grid.along[self.edge]
        return float(np.arctan2(u[1], u[0]) + self.side * np.pi / 2)

    def yaw_flow(self, grid: Grid) -> float:
        """Heading of the traffic at this kerb [rad]."""
        u = self.flow * grid.along[self.edge]
        return float(np.arctan2(u[1], u[0]))


def bridge_m(grid: Grid, edge: int) -> float:
    """Where a footbridge crosses an edge: the middle of what lies between its junctions."""
    low, high = grid.setback_m[edge, 0], grid.length_m[edge] - grid.setback_m[edge, 1]
    return float((low + high) / 2)


def _flow(profile, side: int) -> int:
    """Direction of the lane nearest to a kerb."""
    return max(profile.lanes, key=lambda lane: side * lane[0])[1]


def draw_kerbsides(
    rng: np.random.Generator,
    grid: Grid,
    *,
    tree_spacing_m: float,
    tree_share: float,
    lamp_spacing_m: float,
    parked_share: float,
    furniture_per_100m: float,
    bridged: list[int],
    half_m: float,
) -> list[Kerbside]:
    """The layout of every kerb.

    Args:
        rng: the lane of the kerbs.
        grid: the streets.
        tree_spacing_m: between street trees.
        tree_share: share of the streets that have trees.
        lamp_spacing_m: between lamps on a side.
        parked_share: of the bays that a car takes.
        furniture_per_100m: small things between trees and lamps.
        bridged: edges with a footbridge, whose stairs take the room at its foot.
        half_m: half the side of the square that flights keep to; furniture stands near it only.
    """
    sides = []
    green = rng.random(len(grid.lines)) < tree_share
    # A gap between trees or lamps holds one and a half things, if any.
    furnished = float(np.clip(furniture_per_100m * tree_spacing_m / 150, 0, 1))
    length = grid.length_m
    for edge in range(len(grid.start)):
        profile = grid.profile(edge)
        middle = np.abs(grid.start[edge] + grid.end[edge]) / 2
        away = middle.max() - half_m - length[edge] / 2
        low, high = grid.setback_m[edge, 0], length[edge] - grid.setback_m[edge, 1]
        if profile.kind == "alley" or high - low < 2 * CROSSING_M + 8 or away > 230:
            continue
        for side, parking in zip((1, -1), profile.parking, strict=True):
            sides.append(
                _layout(
                    rng.spawn(1)[0],
                    edge=edge,
                    side=side,
                    profile=profile,
                    span=(low + CROSSING_M, high - CROSSING_M),
                    parking=parking,
                    pitch_m=tree_spacing_m,
                    green=bool(green[grid.line[edge]]),
                    lamp_every=max(2, round(lamp_spacing_m / tree_spacing_m)),
                    parked_share=parked_share,
                    furniture=furnished if away < 60 else 0.0,
                    stairs_m=bridge_m(grid, edge) if edge in bridged else None,
                )
            )
    return sides


def _layout(
    rng, *, edge, side, profile, span, parking, pitch_m, green, lamp_every, parked_share, furniture,
    stairs_m,
) -> Kerbside:  # fmt: skip
    """One kerbside: lamps and trees in a row, small things between, cars, perhaps a bus stop."""
    low, high = span
    stop = None
    wanted = 0.42 if profile.kind == "avenue" else 0.12
    if high - low > 50 and rng.random() < wanted and stairs_m is None:
        stop = float(rng.uniform(low + BUS_BOX_M / 2 + 2, high - BUS_BOX_M / 2 - 2))

    def off_stop(s, margin):
        return np.abs(s - stop) > margin if stop is not None else np.ones(len(s), bool)

    count = int((high - low) / pitch_m)
    row = low + (high - low - (count - 1) * pitch_m) / 2 + pitch_m * np.arange(count)
    lamp = (np.arange(count) + rng.integers(lamp_every)) % lamp_every == 0
    row = row + rng.normal(0, 0.15, count)
    tree = ~lamp & (rng.random(count) < 0.88) & green & off_stop(row, 4.5)
    lamp &= off_stop(row, 3.2)
    if stairs_m is not None:
        clear = np.abs(row - stairs_m) > STAIRS_M
        lamp, tree = lamp & clear, tree & clear

    names = [name for name, (_, wide) in _SMALL.items() if profile.pavement_m >= wide]
    weight = np.array([_SMALL[name][0] for name in names])
    small = []
    for s in (row[:-1] + row[1:]) / 2:
        # Things stand in clusters: a bin beside a bench, a bin beside the meters.
        cluster = rng.choice(len(names), int(rng.integers(1, 3)), p=weight / weight.sum())
        offset = rng.uniform(-1.4, -0.9) if len(cluster) > 1 else rng.uniform(-1.0, 1.0)
        blocked = (stop is not None and abs(s - stop) < 6) or (
            stairs_m is not None and abs(s - stairs_m) < STAIRS_M + 2
        )
        if rng.random() < furniture and not blocked:
            for k, index in enumerate(np.unique(cluster)):
                name = names[index]
                place = s + offset + (2.6 * k if k else 0.0)
                small.append((name, float(place), _SET_BACK_M.get(name, 0.75)))
    if stop is not None and furniture:
        small.append(("bus_shelter", stop, 1.75 if profile.pavement_m > 3.6 else 1.45))
        small.append(("litter_bin", stop + 4.2, 0.75))
    bays = np.arange(low + BAY_M / 2, high - BAY_M / 2, BAY_M) if parking else np.zeros(0)
    # Cars stand in runs, with a few free bays between.
    run = np.convolve(rng.random(len(bays) + 2), [0.25, 0.5, 0.25], "valid") if len(bays) else bays
    taken = run < np.quantile(run, parked_share) if len(run) else np.zeros(0, bool)
    bays = bays[taken & off_stop(bays, BUS_BOX_M / 2 + BAY_M / 2)]
    return Kerbside(
        edge=edge,
        side=side,
        span_m=(float(low), float(high)),
        half_m=profile.carriageway_m / 2,
        pavement_m=profile.pavement_m,
        flow=_flow(profile, side),
        parking=parking,
        parked_m=bays + rng.normal(0, 0.2, len(bays)),
        stop_m=stop,
        lamps_m=row[lamp],
        trees_m=row[tree],
        small=tuple(small),
    )


def parked_offset_m(kerb: Kerbside) -> float:
    """Middle of a parked car, from the kerb into the pavement (negative: on the carriageway)."""
    return -PARKING_M / 2 - 0.03
