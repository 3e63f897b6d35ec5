"""What is painted on the carriageways, and their repairs, covers and drains."""

import dataclasses
import itertools

import numpy as np

from synthdepth.maps.downtown.grid import PARKING_M, Grid
from synthdepth.maps.downtown.kerbside import BAY_M, BUS_BOX_M, CROSSING_M, Kerbside
from synthdepth.maps.furniture.posters import lettering
from synthdepth.maps.geometry import Model, cross, geometry, join, quads
from synthdepth.maps.streets.markings import ZEBRA_M

PATCH_LIFT_M, SEAL_LIFT_M, PAINT_LIFT_M = 0.006, 0.011, 0.016
LINE_M, STOP_LINE_M, ZEBRA_DEPTH_M = 0.12, 0.4, 3.0
DASH_M, DASH_GAP_M = 3.0, 6.0
WHITE, YELLOW = np.array([0.56, 0.56, 0.54]), np.array([0.5, 0.33, 0.06])


@dataclasses.dataclass(frozen=True, kw_only=True)
class Style:
    """How a city paints its streets.

    Attributes:
        zebra: bars of zebra crossings; otherwise two lines across.
        centre: linear reflectance of the lines between opposite directions.
        double: those are double lines.
        guides: dashes lead through the junctions.
        bays: parking bays are marked by "tees", "line" or "none".
    """

    zebra: bool
    centre: tuple[float, float, float]
    double: bool
    guides: bool
    bays: str


def draw_style(rng: np.random.Generator) -> Style:
    """A city's habits."""
    centre = WHITE if rng.random() < 0.45 else YELLOW
    return Style(
        zebra=bool(rng.random() < 0.8),
        centre=tuple(centre.tolist()),
        double=bool(rng.random() < 0.5),
        guides=bool(rng.random() < 0.6),
        bays=str(rng.choice(["tees", "line", "none"], p=[0.45, 0.4, 0.15])),
    )


class _Paint:
    """Rectangles in the frame of an edge, collected with their tints."""

    def __init__(self, rng: np.random.Generator, grid: Grid):
        self.rng, self.grid = rng, grid
        self.corners: list[np.ndarray] = []
        self.tints: list[np.ndarray] = []

    def add(self, edge: int, s, left, long, wide, tint) -> None:
        """Rectangles with middles (s, left) [m], `long` along the edge and `wide` across it."""
        s, left = np.atleast_1d(np.asarray(s, float)), np.atleast_1d(np.asarray(left, float))
        s, left, long, wide = np.broadcast_arrays(s, left, long, wide)
        x = np.array([-0.5, 0.5, 0.5, -0.5])
        y = np.array([-0.5, -0.5, 0.5, 0.5])
        a = s[:, None] + long[:, None] * x
        b = left[:, None] + wide[:, None] * y
        self.corners.append(self.grid.at(edge, a.ravel(), b.ravel()).reshape(-1, 4, 2))
        self.tints.append(np.asarray(tint) * self.rng.uniform(0.68, 1.05, (len(s), 1)))

    def line(self, edge: int, s0: float, s1: float, left: float, tint, wide=LINE_M) -> None:
        """A line along the edge, in pieces that are worn differently."""
        n = max(1, int((s1 - s0) / 9))
        cuts = np.linspace(s0, s1, n + 1)
        self.add(edge, (cuts[:-1] + cuts[1:]) / 2, left, np.diff(cuts), wide, tint)

    def dashes(self, edge: int, s0: float, s1: float, left: float, tint) -> None:
        """A dashed line along the edge."""
        middles = np.arange(s0 + DASH_M, s1 - DASH_M / 2, DASH_M + DASH_GAP_M)
        if len(middles):
            self.add(edge, middles, left, DASH_M, LINE_M, tint)

    def polygons(self, edge: int, corners, s: float, left: float, ahead: int, tint) -> None:
        """Quadrilaterals (k, 4, 2) given ahead and to the left of a driver at (s, left)."""
        corners = np.asarray(corners, float)
        a, b = s + ahead * corners[..., 0], left + ahead * corners[..., 1]
        at = self.grid.at(edge, a.ravel(), b.ravel()).reshape(-1, 4, 2)
        self.corners.append(at)
        self.tints.append(np.tile(np.asarray(tint) * self.rng.uniform(0.7, 1.0), (len(at), 1)))


# Arrows, a driver at the origin looking along +x: quadrilaterals of (ahead, left) [m].
_SHAFT = [[0, -0.08], [1.7, -0.08], [1.7, 0.08], [0, 0.08]]
_HEAD = [[1.7, -0.32], [2.9, 0], [2.9, 0], [1.7, 0.32]]
_BEND = [[1.0, 0.08], [1.25, 0.08], [1.75, 0.55], [1.5, 0.55]]
_BARB = [[1.25, 0.5], [1.75, 1.0], [1.75, 1.0], [2.05, 0.5]]
_ARROWS = {
    "ahead": [_SHAFT, _HEAD],
    "left": [[[0, -0.08], [1.25, -0.08], [1.25, 0.08], [0, 0.08]], _BEND, _BARB],
    "both": [_SHAFT, _HEAD, _BEND, _BARB],
}


def _arrow(kind: str) -> np.ndarray:
    mirror = kind in ("right", "both_right")
    shape = np.array(_ARROWS[{"right": "left", "both_right": "both"}.get(kind, kind)], float)
    return shape[:, ::-1] * [1, -1] if mirror else shape


def _lettered(text: str, height_m: float) -> np.ndarray:
    """Lettering on the road, three times as long as wide, as (ahead, left) quadrilaterals."""
    r = lettering(text, 1.0)
    x0, y0, x1, y1 = r.T
    # A driver reads it: u runs to the right, v ahead.
    corner = np.stack(
        [np.stack([y0, -x0], 1), np.stack([y0, -x1], 1), np.stack([y1, -x1], 1),
         np.stack([y1, -x0], 1)], axis=1,
    )  # fmt: skip
    return corner * [height_m, 0.42 * height_m]


def _junction_ends(rng, paint: _Paint, edge: int, style: Style, degree) -> None:
    """Crossings, stop lines and arrows at both ends of an edge."""
    grid = paint.grid
    profile, length = grid.profile(edge), grid.length_m[edge]
    half = profile.carriageway_m / 2
    for end, ahead in ((0, -1), (1, 1)):
        setback = grid.setback_m[edge, end]
        if degree[end] < 3 or setback == 0:
            continue

        def at(x, setback=setback, end=end):
            return setback + x if end == 0 else length - setback - x

        if style.zebra:
            bars = np.arange(-half + 0.55, half - 0.3, 2 * ZEBRA_M)
            middle = np.full(len(bars), at(0.3 + ZEBRA_DEPTH_M / 2))
            paint.add(edge, middle, bars, ZEBRA_DEPTH_M, ZEBRA_M, WHITE)
        else:
            for x in (0.4, 0.4 + ZEBRA_DEPTH_M):
                paint.add(edge, at(x), 0.0, 0.3, 2 * half - 0.5, WHITE)
        lanes = [offset for offset, direction in profile.lanes if direction == ahead]
        if not lanes:
            continue
        wide = abs(profile.lanes[1][0] - profile.lanes[0][0]) if len(profile.lanes) > 1 else 3.6
        low, high = min(lanes) - wide / 2, max(lanes) + wide / 2
        stop = 0.3 + ZEBRA_DEPTH_M + 1.4
        paint.add(edge, at(stop), (low + high) / 2, STOP_LINE_M, high - low - 0.3, WHITE)
        if profile.kind == "avenue" or rng.random() < 0.35:
            kinds = ["ahead"] * len(lanes)
            rightmost = int(np.argmin(np.array(lanes) * ahead))
            kinds[rightmost] = str(rng.choice(["both_right", "right", "ahead"]))
            if len(lanes) > 1:
                leftmost = int(np.argmax(np.array(lanes) * ahead))
                kinds[leftmost] = str(rng.choice(["left", "both", "ahead"]))
            for back in (stop + 5.5, stop + 24):
                if back + 8 < length - grid.setback_m[edge].sum() - CROSSING_M:
                    for lane, kind in zip(lanes, kinds, strict=True):
                        shape = _arrow(kind)
                        paint.polygons(edge, shape, at(back), lane, ahead, WHITE)


def _guides(paint: _Paint, edge: int, degree) -> None:
    """Short dashes that lead the lanes of an avenue through its junctions."""
    profile, length = paint.grid.profile(edge), paint.grid.length_m[edge]
    lanes = sorted(offset for offset, _ in profile.lanes)
    for end in (0, 1):
        setback = paint.grid.setback_m[edge, end]
        if degree[end] < 3 or setback < 3:
            continue
        s = np.arange(0.6, setback - 0.4, 1.8)
        for a, b in itertools.pairwise(lanes):
            at = s if end == 0 else length - s
            paint.add(edge, at, (a + b) / 2, 0.6, LINE_M, WHITE)


def _lanes(rng, paint: _Paint, edge: int, style: Style, span) -> None:
    """Lines between lanes and along the parking lanes."""
    profile = paint.grid.profile(edge)
    lanes = sorted(profile.lanes)
    low, high = span
    for (a, da), (b, db) in itertools.pairwise(lanes):
        between = (a + b) / 2
        if da == db:
            paint.dashes(edge, low, high, between, WHITE)
        elif style.double:
            for shift in (-0.11, 0.11):
                paint.line(edge, low, high, between + shift, style.centre)
        else:
            paint.dashes(edge, low, high, between, style.centre)
    half = profile.carriageway_m / 2
    for side, parking in zip((1, -1), profile.parking, strict=True):
        edge_line = side * (half - PARKING_M)
        if not parking or style.bays == "none":
            continue
        if style.bays == "line":
            paint.line(edge, low, high, edge_line, WHITE, 0.1)
        bays = np.arange(low, high + 0.1, BAY_M)
        middle = side * (half - PARKING_M / 2)
        deep = PARKING_M - 0.2 if style.bays == "line" else 0.9
        shift = 0.0 if style.bays == "line" else -side * (PARKING_M / 2 - 0.45)
        paint.add(edge, bays, middle + shift, 0.1, deep, WHITE)
        if style.bays == "tees":
            paint.add(edge, bays, edge_line, 0.9, 0.1, WHITE)


def _bus_box(paint: _Paint, kerb: Kerbside, tint) -> None:
    """The outline of a bus stop and its word."""
    deep = 2.9
    middle = kerb.side * (kerb.half_m - deep / 2 - 0.15)
    s = kerb.stop_m
    for shift in (-1, 1):
        left = middle + shift * deep / 2
        paint.line(kerb.edge, s - BUS_BOX_M / 2, s + BUS_BOX_M / 2, left, tint, 0.1)
        paint.add(kerb.edge, s + shift * BUS_BOX_M / 2, middle, 0.1, deep, tint)
    for place in (-6.0, 5.0):
        word = _lettered("BUS", 2.6)
        paint.polygons(kerb.edge, word, s + place, middle, kerb.flow, tint)


def _wear(rng, grid: Grid, edge: int, span) -> tuple[np.ndarray, np.ndarray, list[np.ndarray]]:
    """Patches (k, 4, 2) with their tone (k,), and sealed cracks: polylines."""
    half = grid.profile(edge).carriageway_m / 2
    low, high = span
    count = rng.poisson((high - low) / 15)
    s, left = rng.uniform(low, high, count), rng.uniform(-half + 0.8, half - 0.8, count)
    long, wide = rng.uniform(0.8, 6.0, count), rng.uniform(0.7, 2.4, count)
    trench = rng.random(count) < 0.25
    long, wide = np.where(trench, rng.uniform(0.5, 1.0, count), long), np.where(trench, half, wide)
    wide = np.minimum(wide, 2 * (half - np.abs(left)) - 0.06)
    long = np.minimum(long, 2 * np.minimum(s - low, high - s) + 0.3)
    skew = rng.normal(0, 0.05, (count, 4, 2))
    x, y = np.array([-0.5, 0.5, 0.5, -0.5]), np.array([-0.5, -0.5, 0.5, 0.5])
    a = s[:, None] + long[:, None] * x + skew[..., 0]
    b = left[:, None] + wide[:, None] * y
    patches = grid.at(edge, a.ravel(), b.ravel()).reshape(-1, 4, 2)
    tone = np.where(rng.random(count) < 0.7, rng.uniform(0.5, 0.85, count),
                    rng.uniform(1.1, 1.35, count))  # fmt: skip
    cracks = []
    for _ in range(rng.poisson((high - low) / 9)):
        across = rng.random() < 0.5
        reach = rng.uniform(0.5, 1.0) * half if across else rng.uniform(3, 14)
        t = np.linspace(-0.5, 0.5, 9) * reach
        wander = np.cumsum(rng.normal(0, 0.13, 9))
        s0, l0 = rng.uniform(low, high), rng.uniform(-0.5, 0.5) * half
        line = (s0 + wander, l0 + t) if across else (s0 + t, l0 + wander)
        inside = (np.abs(line[1]) < half - 0.1) & (line[0] > low - 4) & (line[0] < high + 4)
        if inside.all():
            cracks.append(grid.at(edge, *line))
    return patches, tone, cracks


def _junction_wear(rng, grid: Grid, half_m: float):
    """Patches (k, 4, 2), their tone (k,) and sealed cracks in the middle of junctions."""
    ends = np.concatenate([grid.start, grid.end])
    node, first = np.unique(np.concatenate([grid.node[:, 0], grid.node[:, 1]]), return_index=True)
    middle = ends[first][grid.degree[node] >= 3]
    middle = middle[np.abs(middle).max(axis=1) < half_m + 60]
    count = rng.integers(4, 10, len(middle))
    centre = np.repeat(middle, count, axis=0) + rng.normal(0, 3.2, (count.sum(), 2))
    turn = grid.angle_rad + np.pi / 2 * rng.integers(0, 4, len(centre))
    turn += rng.normal(0, 0.06, len(centre))
    u = np.stack([np.cos(turn), np.sin(turn)], 1)[:, None]
    n = np.stack([-np.sin(turn), np.cos(turn)], 1)[:, None]
    size = rng.uniform([0.8, 0.4], [6.5, 2.2], (len(centre), 2)) / 2
    x, y = np.array([-1, 1, 1, -1]), np.array([-1, -1, 1, 1])
    patches = centre[:, None] + (size[:, :1] * x)[..., None] * u + (size[:, 1:] * y)[..., None] * n
    tone = np.where(rng.random(len(centre)) < 0.7, 0.7, 1.2) * rng.uniform(0.8, 1.15, len(centre))
    cracks = []
    for point in np.repeat(middle, rng.integers(2, 6, len(middle)), axis=0):
        angle = rng.uniform(0, np.pi)
        t = np.linspace(-0.5, 0.5, 9) * rng.uniform(3, 9)
        line = np.stack([t, np.cumsum(rng.normal(0, 0.16, 9))], 1)
        c, s = np.cos(angle), np.sin(angle)
        cracks.append(point + rng.normal(0, 4.0, 2) + line @ np.array([[c, s], [-s, c]]))
    return patches, tone, cracks


def _ribbons(lines: list[np.ndarray], width_m: np.ndarray) -> np.ndarray:
    """Quadrilaterals (k, 4, 2) along polylines of nine points each."""
    if not lines:
        return np.zeros((0, 4, 2))
    p = np.stack(lines)
    along = np.gradient(p, axis=1)
    along /= np.linalg.norm(along, axis=2, keepdims=True)
    side = np.stack([-along[..., 1], along[..., 0]], -1) * width_m[:, None, None] / 2
    low, high = p - side, p + side
    return np.stack([low[:, :-1], low[:, 1:], high[:, 1:], high[:, :-1]], 2).reshape(-1, 4, 2)


def _upward(corners: np.ndarray, z_m: float, tint) -> Model:
    """Quadrilaterals (k, 4, 2) as faces that look up."""
    ac, bd = corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1]
    clockwise = ac[:, 0] * bd[:, 1] - ac[:, 1] * bd[:, 0] < 0
    corners = np.where(clockwise[:, None, None], corners[:, ::-1], corners)
    z = np.full((*corners.shape[:2], 1), z_m)
    part = quads(np.concatenate([corners, z], 2), tint)
    tri = part.triangles.astype(float)
    area = np.linalg.norm(cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1)
    return geometry(part.vertices, part.faces[area > 1e-5], part.vertices[:, :2], part.tint)


def street_markings(
    rng: np.random.Generator, grid: Grid, kerbs: list[Kerbside], half_m: float
) -> Model:
    """Paint, patches, sealed cracks, drains; millimetres above the carriageways.

    Args:
        rng: the lane of the markings.
        grid: the streets.
        kerbs: with their bus stops.
        half_m: half the side of the square that flights keep to; wear is modelled near it.
    """
    style = draw_style(rng)
    paint = _Paint(rng, grid)
    patches, tones, cracks, drains = [np.zeros((0, 4, 2))], [np.zeros(0)], [], [np.zeros((0, 4, 2))]
    for edge in range(len(grid.start)):
        profile, length = grid.profile(edge), grid.length_m[edge]
        low, high = grid.setback_m[edge, 0], length - grid.setback_m[edge, 1]
        away = np.abs(grid.start[edge] + grid.end[edge]).max() / 2 - half_m
        if high - low < 4 or away > 330:
            continue
        if away < 110:
            found = _wear(rng, grid, edge, (low, high))
            patches.append(found[0])
            tones.append(found[1])
            cracks += found[2]
        if profile.kind == "alley" or high - low < 2 * CROSSING_M + 6:
            continue
        _junction_ends(rng, paint, edge, style, grid.degree[grid.node[edge]])
        # Along one street only: those of two would cross.
        if profile.kind == "avenue" and style.guides and grid.line[edge] % 2:
            _guides(paint, edge, grid.degree[grid.node[edge]])
        _lanes(rng, paint, edge, style, (low + CROSSING_M, high - CROSSING_M))
        s = np.array([low + 1.5, high - 1.5])
        for side in (-1, 1):
            wear = _Paint(rng, grid)
            wear.add(edge, s, side * (profile.carriageway_m / 2 - 0.26), 0.6, 0.36, WHITE)
            drains.append(wear.corners[0])
    worn = _junction_wear(rng, grid, half_m)
    patches.append(worn[0])
    tones.append(worn[1])
    cracks += worn[2]
    for kerb in kerbs:
        if kerb.stop_m is not None:
            _bus_box(paint, kerb, YELLOW if style.double else WHITE)
    tone = np.concatenate(tones)[:, None]
    crack_width = rng.uniform(0.04, 0.09, len(cracks))
    dark = np.tile([0.022, 0.022, 0.023], (8 * len(cracks), 1))
    return {
        ("road_paint", "road"): _upward(
            np.concatenate(paint.corners), PAINT_LIFT_M, np.concatenate(paint.tints)
        ),
        ("asphalt", "road"): _upward(
            np.concatenate(patches), PATCH_LIFT_M, np.repeat(tone, 3, axis=1)
        ),
        ("paint", "road"): join([_upward(_ribbons(cracks, crack_width), SEAL_LIFT_M, dark)]),
        ("metal", "road"): _upward(np.concatenate(drains), PAINT_LIFT_M, (0.45, 0.45, 0.45)),
    }
