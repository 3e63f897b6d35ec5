"""Blocks cut into lots, each with the footprint and the height of its building.

Lots come from cutting a block across its longest side again and again; heights from a field that
falls off from one or two cores, so heavily shaken that low roofs stand beside towers.
"""

import dataclasses

import numpy as np
import shapely

STREET_REACH_M = 6.0  # a wall this near to a street has windows and shops
_NARROWEST_LOT_M = 14.0
_SHORTEST_WALL_M = 6.2
_THINNEST_M = 9.5
_PARTY_GAP_M = 0.03  # party walls never lie in one plane


@dataclasses.dataclass(frozen=True, kw_only=True)
class Lot:
    """A piece of a block.

    Attributes:
        parcel: its land.
        footprint: (n, 2) float64 convex CCW [m], what is built over; empty for a yard.
        storeys: of the building; 0 for a yard.
        street_sides: (n,) bool, edges i -> i+1 that lie within 6 m of a street's land.
    """

    parcel: shapely.Polygon
    footprint: np.ndarray
    storeys: int
    street_sides: np.ndarray

    @property
    def built(self) -> bool:
        """Whether a building stands here."""
        return self.storeys > 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Skyline:
    """How high the buildings are where.

    Attributes:
        low, high: lowest and highest outside the lowest class [storeys].
        core_storeys: mean at the cores.
        core_m: distance over which the height falls to 1 / e.
        cores: (k, 2) [m].
    """

    low: float
    high: float
    core_storeys: float
    core_m: float
    cores: np.ndarray

    def storeys(self, rng: np.random.Generator, at: np.ndarray, width_m: float) -> int:
        """Storeys of a building in the middle `at` (2,) on a lot `width_m` wide."""
        if rng.random() < 0.22:
            return int(rng.choice(5, p=[0.1, 0.2, 0.26, 0.22, 0.22])) + 1
        away = np.hypot(*(self.cores - at).T).min() / self.core_m
        outer = self.low + 0.13 * (self.high - self.low)
        mean = outer + max(self.core_storeys - outer, 0) * np.exp(-(away**1.5))
        slender = 2.1 * width_m
        drawn = min(mean * np.exp(rng.normal(-0.05, 0.42)), slender)
        return int(np.clip(drawn, max(self.low, 3), min(self.high, 60)))


def draw_skyline(
    rng: np.random.Generator,
    *,
    storeys_range: tuple[float, float],
    core_storeys: float,
    core_m: float,
) -> Skyline:
    """One or two cores near the middle of the map."""
    count = 1 + int(rng.random() < 0.45)
    turn = rng.uniform(0, 2 * np.pi) + np.pi * np.arange(count)
    reach = rng.uniform(30, 120) if count == 1 else rng.uniform(130, 230)
    cores = reach * np.column_stack([np.cos(turn), np.sin(turn)])
    low, high = storeys_range
    return Skyline(low=low, high=high, core_storeys=core_storeys, core_m=core_m, cores=cores)


def oriented(area: shapely.Polygon) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Middle (2,), unit vector (2,) along the longer side, both sides [m] of the tightest box."""
    box = shapely.get_coordinates(shapely.oriented_envelope(area))[:4]
    a, b = box[1] - box[0], box[2] - box[1]
    la, lb = np.hypot(*a), np.hypot(*b)
    long, length, width = (a / la, la, lb) if la >= lb else (b / lb, lb, la)
    return box.mean(axis=0), long, float(length), float(width)


def half_plane(at: np.ndarray, along: np.ndarray) -> shapely.Polygon:
    """What lies to the left of a line through `at` (2,) along a unit vector (2,)."""
    far = 2000.0
    left = np.array([-along[1], along[0]])
    a, b = at - far * along, at + far * along
    return shapely.Polygon([a, b, b + far * left, a + far * left])


def polygons(area: shapely.Geometry, least_m2: float = 1.0) -> list[shapely.Polygon]:
    """The polygons in a geometry that are larger than `least_m2`."""
    parts = shapely.get_parts(area)
    return [p for p in parts if p.geom_type == "Polygon" and p.area > least_m2]


def cut_across(area: shapely.Polygon, share: float) -> list[shapely.Polygon]:
    """Polygons of an area cut across its longer side, at a share of its length."""
    middle, long, length, _ = oriented(area)
    half = half_plane(middle + (share - 0.5) * length * long, np.array([-long[1], long[0]]))
    return polygons(area.intersection(half)) + polygons(area.difference(half))


def split(rng: np.random.Generator, area: shapely.Polygon, largest_m: float) -> list:
    """Pieces of an area, cut at 0.4 to 0.6 of the longest side until that is `largest_m`."""
    length = oriented(area)[2]
    limit = largest_m * rng.uniform(0.8, 1.25)
    compact = area.area > 0.9 * area.convex_hull.area
    if length < 2 * _NARROWEST_LOT_M or (length < limit and compact):
        return [area]
    pieces = cut_across(area, float(rng.uniform(0.4, 0.6)))
    if len(pieces) < 2:
        return [area]
    return [lot for piece in pieces for lot in split(rng, piece, largest_m)]


def _area_m2(p: np.ndarray) -> float:
    q = np.roll(p, -1, axis=0)
    return float((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum() / 2)


def corners(area: shapely.Polygon) -> np.ndarray:
    """Corners (n, 2) of a nearly convex area, CCW, without walls too short to build."""
    hull = shapely.simplify(area.convex_hull, 0.25)
    points = shapely.get_coordinates(shapely.orient_polygons(hull))[:-1]
    while len(points) > 3:
        length = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
        shortest = int(length.argmin())
        if length[shortest] >= _SHORTEST_WALL_M:
            break
        # Without one of its corners a convex shape stays convex, and within itself.
        pair = [shortest, (shortest + 1) % len(points)]
        points = max((np.delete(points, k, axis=0) for k in pair), key=_area_m2)
    return points


def thickness_m(points: np.ndarray) -> float:
    """Smallest width of a convex polygon (n, 2)."""
    u = np.roll(points, -1, axis=0) - points
    u = u / np.hypot(*u.T)[:, None]
    across = (points[None] - points[:, None]) @ np.stack([-u[:, 1], u[:, 0]], 1)[:, :, None]
    return float(across[..., 0].max(axis=1).min())


def pulled_in(points: np.ndarray, by_m: np.ndarray) -> np.ndarray:
    """A convex CCW polygon (n, 2) with each edge moved in by `by_m` (n,); empty if none is left."""
    shape = shapely.Polygon(points)
    for a, b, by in zip(points, np.roll(points, -1, axis=0), by_m, strict=True):
        u = (b - a) / np.hypot(*(b - a))
        shape = shape.intersection(half_plane(a + by * np.array([-u[1], u[0]]), u))
    if shape.is_empty or shape.geom_type != "Polygon":
        return np.zeros((0, 2))
    return corners(shape)


def near_street(points: np.ndarray, street: shapely.Geometry) -> np.ndarray:
    """Which edges (n,) of a polygon (n, 2) have their middle near a street's land."""
    middles = (points + np.roll(points, -1, axis=0)) / 2
    return shapely.distance(shapely.points(middles), street) < STREET_REACH_M


def _chamfered(rng: np.random.Generator, points: np.ndarray, street: np.ndarray) -> np.ndarray:
    """A corner between two street sides cut off, in some."""
    meets = np.flatnonzero(street & np.roll(street, 1))
    if not len(meets) or len(points) > 4 or rng.random() > 0.3:
        return points
    k = int(rng.choice(meets))
    a, p, b = points[k - 1], points[k], points[(k + 1) % len(points)]
    leg = rng.uniform(4.8, 6.5)
    if min(np.hypot(*(a - p)), np.hypot(*(b - p))) < leg + 8:
        return points
    cut = [p + leg * (q - p) / np.hypot(*(q - p)) for q in (a, b)]
    # A blunt or sharp corner would leave a wall too short to build.
    if np.hypot(*(cut[0] - cut[1])) < _SHORTEST_WALL_M:
        return points
    return np.concatenate([points[:k], cut, points[k + 1 :]])


def yard(parcel: shapely.Polygon) -> Lot:
    """A lot that is left open."""
    return Lot(parcel=parcel, footprint=np.zeros((0, 2)), storeys=0, street_sides=np.zeros(0, bool))


def _lot(rng, parcel: shapely.Polygon, street: shapely.Geometry, skyline: Skyline) -> Lot:
    """One parcel with its building, if there is room for one."""
    if parcel.area < 0.93 * parcel.convex_hull.area or parcel.area < 110:
        return yard(parcel)
    points = corners(parcel)
    n = len(points)
    fronts = near_street(points, street)
    setback = rng.uniform(0.3, 3.0) if rng.random() < 0.35 else 0.0
    gaps = np.where(rng.random(n) < 0.72, _PARTY_GAP_M, rng.uniform(0.5, 4.0, n))
    by = np.where(fronts, setback, gaps)
    back = ~fronts & np.roll(fronts, 2) if n == 4 else np.zeros(n, bool)
    if back.sum() == 1 and rng.random() < 0.55:
        by[back] = rng.uniform(0.15, 0.42) * thickness_m(points)
    points = pulled_in(points, by)
    if len(points) < 3 or thickness_m(points) < _THINNEST_M:
        return yard(parcel)
    points = _chamfered(rng, points, near_street(points, street))
    return Lot(
        parcel=parcel,
        footprint=np.ascontiguousarray(points, np.float64),
        storeys=skyline.storeys(rng, points.mean(axis=0), thickness_m(points)),
        street_sides=near_street(points, street),
    )


def cut_lots(
    rng: np.random.Generator,
    block: shapely.Polygon,
    street: shapely.Geometry,
    skyline: Skyline,
    *,
    coarse: bool,
) -> tuple[Lot, ...]:
    """The lots of a block.

    Args:
        rng: lane of the lots.
        block: its land.
        street: land of the streets.
        skyline: heights.
        coarse: cut it into few large lots, for blocks that are only seen from afar.
    """
    reach = STREET_REACH_M + 2
    x0, y0, x1, y1 = block.bounds
    street = shapely.clip_by_rect(street, x0 - reach, y0 - reach, x1 + reach, y1 + reach)
    _, _, length, width = oriented(block)
    slab = width < 48 and length < 80 and rng.random() < 0.25
    largest = 90.0 if slab else rng.uniform(56, 80) if coarse else rng.uniform(34, 52)
    parcels = split(rng, block, largest)
    open_share = rng.uniform(0.02, 0.12) if len(parcels) > 2 else 0.0
    lots = []
    for parcel in parcels:
        # Land in the middle of a block, away from any street, is a yard more often than not.
        inner = shapely.distance(parcel, street) > 4.0 and rng.random() < 0.75
        if inner or rng.random() < open_share:
            lots.append(yard(parcel))
        else:
            lots.append(_lot(rng, parcel, street, skyline))
    return tuple(lots)
