"""The plan of a suburb in two dimensions: streets, pavements and the lots along them."""

import dataclasses
from collections.abc import Sequence

import numpy as np
import shapely
from scipy import spatial

from synthdepth.maps.streets.graph import Network, Street, resampled
from synthdepth.maps.streets.lots import Lot, draw_lots
from synthdepth.maps.streets.network import draw_network

KERB_WIDTH_M = 0.15
PAVEMENT_WIDTH_M = 1.5
CHORD_M = 0.02  # how far edges may deviate from the curves they draw


@dataclasses.dataclass(frozen=True, kw_only=True)
class StreetPlan:
    """Streets and lots of one suburb, in a square centred on the origin.

    The carriageway, the kerb around it, the verge (planting strip) around that and the pavement
    around that touch and do not overlap; everything else in the square is ground.

    Attributes:
        half_size_m: half the side of the square.
        streets: centrelines with class and width.
        junctions: (k, 2) [m].
        approaches: (a, 4), where a street ends on another: the junction's x, y [m], the street's
            index, and 0 or 1 for its first or last point.
        crossings: (c, 2) [m], where collectors cross.
        bulbs: (b, 3), x, y and radius [m] of the turning circles of cul-de-sacs.
        verge_m: width of the planting strip.
        carriageway: between the kerbs, corners rounded.
        kerb: `KERB_WIDTH_M` wide.
        verge: the planting strips.
        pavement: `PAVEMENT_WIDTH_M` wide.
        street_land: all of the above.
        lots: disjoint, none on street land.
    """

    half_size_m: float
    streets: tuple[Street, ...]
    junctions: np.ndarray
    approaches: np.ndarray
    crossings: np.ndarray
    bulbs: np.ndarray
    verge_m: float
    carriageway: shapely.Geometry
    kerb: shapely.Geometry
    verge: shapely.Geometry
    pavement: shapely.Geometry
    street_land: shapely.Geometry
    lots: tuple[Lot, ...]


def _carriageway(network: Network, fillet_m: float) -> shapely.Geometry:
    lines = shapely.linestrings(
        np.concatenate([s.centreline for s in network.streets]),
        indices=np.repeat(
            np.arange(len(network.streets)), [len(s.centreline) for s in network.streets]
        ),
    )
    width = np.array([s.width_m for s in network.streets])
    strips = shapely.buffer(shapely.simplify(lines, CHORD_M), width / 2, quad_segs=4)
    parts = [strips]
    if len(network.bulbs):
        x, y, r = network.bulbs.T
        circles = shapely.buffer(shapely.points(x, y), r, quad_segs=7)
        near = shapely.buffer(shapely.points(x, y), r + 22, quad_segs=4)
        tree = shapely.STRtree(strips)
        bulb, strip = tree.query(circles, predicate="intersects")
        necks = shapely.intersection(strips[strip], near[bulb])
        # Closing by a large radius flares the neck of a bulb.
        flared = shapely.union(necks, circles[bulb])
        flared = shapely.buffer(shapely.buffer(flared, 14, quad_segs=8), -14, quad_segs=8)
        parts.append(shapely.intersection(flared, near[bulb]))
    union = shapely.union_all(np.concatenate(parts))
    closed = shapely.buffer(shapely.buffer(union, fillet_m, quad_segs=5), -fillet_m, quad_segs=5)
    parts = shapely.get_parts(shapely.simplify(closed, CHORD_M))
    return shapely.multipolygons(parts[shapely.area(parts) > 50])  # closing leaves specks


def draw_street_plan(
    rng: np.random.Generator,
    *,
    size_m: float = 1000.0,
    carriageway_range: tuple[float, float] = (6.6, 7.5),
    collector_range: tuple[float, float] = (9.0, 10.0),
    verge_range: tuple[float, float] = (1.2, 2.0),
    fillet_range: tuple[float, float] = (5.5, 8.0),
    bulb_radius_range: tuple[float, float] = (12.0, 15.0),
    frontage_range: tuple[float, float] = (17.0, 27.0),
    depth_range: tuple[float, float] = (31.0, 38.0),
    park_share: float = 0.5,
    vacant_share: float = 0.02,
) -> StreetPlan:
    """A suburb's streets and lots in a square of side `size_m`; all ranges in metres."""
    half = size_m / 2
    depth, verge_m = rng.uniform(*depth_range), rng.uniform(*verge_range)
    network = draw_network(
        rng,
        half_m=half,
        lot_depth_m=depth,
        verge_m=verge_m,
        carriageway_range=carriageway_range,
        collector_range=collector_range,
        bulb_radius_range=bulb_radius_range,
    )
    square = shapely.box(-half, -half, half, half)
    # Buffered before it is cut at the map's edge, so that kerbs do not turn in there.
    road = _carriageway(network, rng.uniform(*fillet_range))
    rings = [KERB_WIDTH_M, KERB_WIDTH_M + verge_m, KERB_WIDTH_M + verge_m + PAVEMENT_WIDTH_M]
    outer = shapely.simplify(shapely.buffer(road, rings, quad_segs=4), CHORD_M)
    road, kerb, verge, land = shapely.intersection([road, *outer], square)
    lots = draw_lots(
        rng,
        land,
        half_m=half,
        frontage_range=frontage_range,
        depth_m=depth,
        park_share=park_share,
        vacant_share=vacant_share,
    )
    return StreetPlan(
        half_size_m=half,
        streets=network.streets,
        junctions=network.junctions,
        approaches=network.approaches,
        crossings=network.crossings,
        bulbs=network.bulbs,
        verge_m=verge_m,
        carriageway=road,
        kerb=shapely.difference(kerb, road),
        verge=shapely.difference(verge, kerb),
        pavement=shapely.difference(land, verge),
        street_land=land,
        lots=lots,
    )


def along(
    rng: np.random.Generator,
    plan: StreetPlan,
    *,
    spacing_m: float,
    kerb_offset_m: float,
    jitter_m: float = 0.0,
    junction_clear_m: float = 12.0,
    sides: str = "both",
    kinds: Sequence[str] = ("collector", "local"),
    keep_clear: Sequence[np.ndarray] = (),
    clear_m: float = 0.6,
) -> tuple[np.ndarray, np.ndarray]:
    """Places along the streets for poles, lamps, trees or parked cars.

    Args:
        rng: random lane.
        plan: the streets.
        spacing_m: between places on one side of a street.
        kerb_offset_m: from the carriageway's edge; positive in the planting strip and on the
            pavement, negative on the carriageway.
        jitter_m: places shift along the street by up to this.
        junction_clear_m: nothing nearer to a junction, beyond the other street's half width.
        sides: "both", or "one" (of each street, drawn).
        kinds: of streets.
        keep_clear: polygons (k, 2) [m], e.g. driveways, that no place comes nearer to than
            `clear_m`.
        clear_m: see there.

    Returns:
        Positions (n, 2) [m], and headings (n,) [rad]: the direction of (right-hand) traffic on that
        side of the street; the carriageway lies to the heading's left.
    """
    positions, headings = [], []
    for street in plan.streets:
        line = resampled(street.centreline, 1.0)
        tangent = np.gradient(line, axis=0)
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        chosen = (1, -1) if sides == "both" else (int(rng.choice([-1, 1])),)
        for side in chosen if street.kind in kinds else ():
            s = np.arange(rng.uniform(0, spacing_m), len(line) - 1, spacing_m)
            i = np.clip(s + rng.uniform(-jitter_m, jitter_m, len(s)), 0, len(line) - 1)
            i = np.round(i).astype(np.int64)
            ahead = side * tangent[i]
            right = np.stack([ahead[:, 1], -ahead[:, 0]], 1)
            positions.append(line[i] + (street.width_m / 2 + kerb_offset_m) * right)
            headings.append(np.arctan2(ahead[:, 1], ahead[:, 0]))
    position, heading = np.concatenate(positions), np.concatenate(headings)
    widest = max(s.width_m for s in plan.streets) / 2
    keep = np.abs(position).max(axis=1) < plan.half_size_m - 1
    keep &= spatial.cKDTree(plan.junctions).query(position)[0] > junction_clear_m + widest
    if len(plan.bulbs):
        x, y, r = plan.bulbs.T
        away = np.linalg.norm(position[:, None] - np.stack([x, y], 1), axis=2)
        keep &= (away > r + 8).all(axis=1)
    # Loops bend without a junction: what then stands on the wrong side of a kerb goes.
    points = shapely.points(position)
    shapely.prepare(plan.carriageway)
    on_road = shapely.intersects(plan.carriageway, points)
    keep &= on_road == (kerb_offset_m < 0)
    if len(keep_clear):
        tree = shapely.STRtree([shapely.Polygon(p) for p in keep_clear])
        near, _ = tree.query(points, predicate="dwithin", distance=clear_m)
        keep[near] = False
    return position[keep], heading[keep]
