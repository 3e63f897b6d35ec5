"""The streets around a sports ground: a ring along its edge, rows of houses, then fields."""

import dataclasses

import numpy as np
import shapely

from synthdepth.maps.houses.styles import STYLES
from synthdepth.maps.stadium.piece import turned
from synthdepth.maps.streets.graph import Street, resampled
from synthdepth.maps.streets.lots import draw_lots
from synthdepth.maps.streets.plan import CHORD_M, KERB_WIDTH_M, PAVEMENT_WIDTH_M, StreetPlan


@dataclasses.dataclass(frozen=True, kw_only=True)
class Surroundings:
    """The character of the streets around a ground; see `NeighborhoodRanges`."""

    styles: tuple[str, ...]
    fence_kinds: tuple[str, ...]
    trees_per_lot: float
    street_tree: str
    street_tree_spacing_m: float
    fenced_share: float
    front_fence_share: float
    hedge_share: float
    garden_items_per_lot: float
    parked_share: float
    utility_line_share: float
    lamp_spacing_m: float


def draw_surroundings(
    rng: np.random.Generator, street_tree: str, parked_share: float
) -> Surroundings:
    """The character of the streets around a ground."""
    fences = ("board", "picket", "chain_link", "post_and_rail")
    return Surroundings(
        styles=tuple(str(s) for s in rng.permutation(sorted(STYLES))[: int(rng.integers(4, 7))]),
        fence_kinds=tuple(str(f) for f in rng.permutation(fences)[:2]),
        trees_per_lot=float(rng.uniform(1.0, 2.6)),
        street_tree=street_tree,
        street_tree_spacing_m=float(rng.uniform(10, 20)),
        fenced_share=float(rng.uniform(0.4, 0.8)),
        front_fence_share=float(rng.uniform(0.1, 0.4)),
        hedge_share=float(rng.uniform(0.1, 0.4)),
        garden_items_per_lot=float(rng.uniform(0.8, 2.0)),
        parked_share=parked_share,
        utility_line_share=float(rng.uniform(0.4, 1.0)),
        lamp_spacing_m=float(rng.uniform(28, 40)),
    )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Town:
    """Streets, lots and the land of the ground among them.

    Attributes:
        plan: streets and lots; its `street_land` holds the site too, which is meshed apart.
        site: the land of the ground.
        country: open land beyond the houses.
    """

    plan: StreetPlan
    site: shapely.Geometry
    country: shapely.Geometry


class _Net:
    """Collects streets in the ground's frame, and where they end on others."""

    def __init__(self) -> None:
        self.lines: list[np.ndarray] = []
        self.main: list[bool] = []
        self.ends: list[tuple[int, int]] = []

    def add(self, points, main: bool = False, ends=()) -> None:
        self.ends += [(len(self.lines), end) for end in ends]
        self.lines.append(resampled(np.asarray(points, np.float64)))
        self.main.append(main)


def _spread(rng, low: float, high: float, spacing, taken, gap: float) -> list[float]:
    """Places between two bounds, a `spacing` apart, no nearer to the `taken` than `gap`."""
    places, at = [], low + rng.uniform(0.3, 1.0) * spacing[0]
    while at < high:
        if all(abs(at - t) > gap for t in taken):
            places.append(float(at))
            at += rng.uniform(*spacing)
        else:
            at += 9.0
    return places


def _network(
    rng: np.random.Generator, ring: np.ndarray, row_m: float, rows: int, reach: float
) -> _Net:
    """The ring of half sizes (2,), rows of streets beyond it, and cross streets."""
    x, y = ring
    net = _Net()
    column_x = [s * (x + k * row_m) for k in range(rows) for s in (-1, 1)]
    for s in (-1, 1):
        for k in range(rows):
            net.add(
                [[-reach, s * (y + k * row_m)], [reach, s * (y + k * row_m)]], main=k == 0 and s < 0
            )
    for cx in column_x:
        net.add([[cx, -y], [cx, y]], ends=(0, 1))
    for s in (-1, 1):
        taken = list(column_x)
        for k in range(rows - 1):
            here = _spread(rng, -reach + 90, reach - 90, (130, 240), taken, 46.0)
            for at in here:
                a, b = (
                    [at, s * (y + k * row_m)],
                    [at + rng.uniform(-8, 8), s * (y + (k + 1) * row_m)],
                )
                net.add([a, b], ends=(0, 1))
            taken = here
    for s in (-1, 1):
        taken = [-y, y]
        for k in range(rows - 1):
            here = _spread(rng, -y, y - 50, (110, 200), taken, 50.0)
            for at in here:
                net.add([[s * (x + k * row_m), at], [s * (x + (k + 1) * row_m), at]], ends=(0, 1))
            taken = [-y, y, *here]
    return net


def _bent(rng: np.random.Generator, lines: list[np.ndarray], ring: np.ndarray) -> list[np.ndarray]:
    """The lines with a bend that grows with the distance from the ring."""
    phase, reach = rng.uniform(0, 6.3, 4), rng.uniform(6, 20, 2)
    out = []
    for line in lines:
        away = np.maximum(np.abs(line) - ring - 12.0, 0).max(axis=1)
        t = np.clip(away / 140, 0, 1)
        s = (t * t * (3 - 2 * t))[:, None]
        u, v = line.T
        sway = np.column_stack(
            [np.sin(v / 95 + phase[0]) + 0.5 * np.sin(u / 170 + phase[1]),
             np.sin(u / 120 + phase[2]) + 0.5 * np.sin(v / 150 + phase[3])]
        )  # fmt: skip
        out.append(line + s * reach * sway)
    return out


def draw_town(
    rng: np.random.Generator,
    half_m: np.ndarray,
    at: np.ndarray,
    yaw_rad: float,
    *,
    rows: int,
    size_m: float = 1000.0,
) -> Town:
    """Streets and lots around a ground.

    Args:
        rng: of all choices.
        half_m: (2,) half sizes of the ground.
        at: (2,) its middle [m].
        yaw_rad: its turn.
        rows: of streets on each side, the ring being the first.
        size_m: side of the map.
    """
    half = size_m / 2
    verge_m, local_m, main_m = rng.uniform(1.2, 2.0), rng.uniform(6.6, 7.4), rng.uniform(8.6, 9.6)
    depth_m = rng.uniform(29, 35)
    side_m = KERB_WIDTH_M + verge_m + PAVEMENT_WIDTH_M
    ring = np.asarray(half_m, float) + local_m / 2 + side_m
    ring[1] += (main_m - local_m) / 2
    row_m = 2 * depth_m + local_m + 2 * side_m + 0.6
    net = _network(rng, ring, row_m, rows, 760.0)
    lines = [turned(line, at, yaw_rad) for line in _bent(rng, net.lines, ring)]
    frame = shapely.box(-half - 40, -half - 40, half + 40, half + 40)
    streets, approaches, number = [], [], {}
    for i, line in enumerate(lines):
        parts = shapely.get_parts(shapely.intersection(shapely.LineString(line), frame))
        parts = [p for p in parts if p.geom_type == "LineString" and p.length > 30]
        for part in sorted(parts, key=lambda p: -p.length)[:1]:
            number[i] = len(streets)
            streets.append(
                Street(
                    centreline=resampled(shapely.get_coordinates(part)),
                    kind="collector" if net.main[i] else "local",
                    width_m=float(round(main_m if net.main[i] else local_m, 2)),
                )
            )
    for i, end in net.ends:
        point = lines[i][-end]
        if i in number and np.abs(point).max() < half - 15:
            own = streets[number[i]].centreline
            if np.hypot(*(own[-end] - point)) < 1.0:
                approaches.append([*point, number[i], end])
    approaches = np.array(approaches, float).reshape(-1, 4)
    strips = [shapely.LineString(s.centreline).buffer(s.width_m / 2, quad_segs=4) for s in streets]
    road = shapely.union_all(strips)
    fillet = rng.uniform(5.5, 8.0)
    road = shapely.buffer(shapely.buffer(road, fillet, quad_segs=5), -fillet, quad_segs=5)
    road = shapely.simplify(road, CHORD_M)
    widths = np.cumsum([KERB_WIDTH_M, verge_m, PAVEMENT_WIDTH_M])
    square = shapely.box(-half, -half, half, half)
    outer = shapely.simplify(shapely.buffer(road, widths, quad_segs=4), CHORD_M)
    road, kerb, verge, land = shapely.intersection([road, *outer], square)
    free = shapely.get_parts(shapely.difference(square, land))
    site = free[np.argmin(shapely.distance(free, shapely.Point(at)))]
    taken = shapely.union_all([land, site])
    # Twice a lot's depth off the streets: lots end on the middle line between two edges.
    country = shapely.difference(square, shapely.buffer(taken, 2 * depth_m + 3.0, quad_segs=3))
    country = country.buffer(-6).buffer(6)
    lots = draw_lots(
        rng,
        shapely.union_all([taken, country]),
        half_m=half,
        frontage_range=(17.0, 27.0),
        depth_m=depth_m,
        park_share=0.3,
        vacant_share=0.03,
    )
    # What lies along the fields only is no frontage.
    lots = tuple(lot for lot in lots if shapely.distance(land, shapely.Point(lot.front)) < 6.0)
    plan = StreetPlan(
        half_size_m=half,
        streets=tuple(streets),
        junctions=approaches[:, :2],
        approaches=approaches,
        crossings=np.zeros((0, 2)),
        bulbs=np.zeros((0, 3)),
        verge_m=verge_m,
        carriageway=road,
        kerb=shapely.difference(kerb, road),
        verge=shapely.difference(verge, kerb),
        pavement=shapely.difference(land, verge),
        street_land=taken,
        lots=lots,
    )
    return Town(plan=plan, site=site, country=country)
