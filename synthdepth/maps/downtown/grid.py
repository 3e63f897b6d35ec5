"""The street grid: avenues, streets and alleys as straight lines, cut into edges at junctions.

An irregular grid (spacing jitter, dropped segments), in some scenes with a diagonal avenue, in
others with a second district that meets the first at an angle.
"""

import dataclasses
import functools
import itertools

import numpy as np
import shapely

REACH_M = 680.0  # the grid is drawn within this distance of the middle
LANE_M, PARKING_M = 3.2, 2.2
LAYOUTS = ("grid", "diagonal", "districts")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Profile:
    """Cross section of a street, seen along its line; offsets count to the left.

    Attributes:
        kind: "avenue", "street" or "alley".
        carriageway_m: between the kerbs.
        pavement_m: on either side.
        lanes: offset of the middle [m] and direction of travel (1 along the line, -1 against it).
        parking: cars park at the left and at the right kerb.
    """

    kind: str
    carriageway_m: float
    pavement_m: float
    lanes: tuple[tuple[float, int], ...]
    parking: tuple[bool, bool]

    @property
    def width_m(self) -> float:
        """From building line to building line."""
        return self.carriageway_m + 2 * self.pavement_m

    @property
    def two_way(self) -> bool:
        """Whether cars drive in both directions."""
        return len({direction for _, direction in self.lanes}) == 2


@dataclasses.dataclass(frozen=True, kw_only=True)
class Grid:
    """Streets as lines, and as edges between junctions.

    Attributes:
        lines: (k, 2, 2) float64 ends [m].
        profiles: (k,) one a line.
        start, end: (e, 2) float64 ends of the edges [m].
        line: (e,) int, of each edge.
        node: (e, 2) int, junction at either end.
        degree: (number of nodes,) int, edges that meet there.
        setback_m: (e, 2) float64, from either end to where no other carriageway is near.
        angle_rad: direction of the main district's streets.
        corner_m: radius of the kerbs at junctions.
        carriageway: what lies between the kerbs.
        street_land: carriageways and pavements.
    """

    lines: np.ndarray
    profiles: tuple[Profile, ...]
    start: np.ndarray
    end: np.ndarray
    line: np.ndarray
    node: np.ndarray
    degree: np.ndarray
    setback_m: np.ndarray
    angle_rad: float
    corner_m: float
    carriageway: shapely.Geometry
    street_land: shapely.Geometry

    @functools.cached_property
    def along(self) -> np.ndarray:
        """(e, 2) unit vectors of the edges."""
        return (self.end - self.start) / self.length_m[:, None]

    @functools.cached_property
    def length_m(self) -> np.ndarray:
        """(e,) lengths of the edges."""
        return np.linalg.norm(self.end - self.start, axis=1)

    def profile(self, edge: int) -> Profile:
        """The cross section of an edge."""
        return self.profiles[self.line[edge]]

    def at(self, edge, s_m, left_m) -> np.ndarray:
        """Points (n, 2) `s_m` along an edge (or edges) from its start and `left_m` beside it."""
        u = self.along[edge]
        n = np.stack([-u[..., 1], u[..., 0]], -1)
        s, left = np.asarray(s_m, float)[..., None], np.asarray(left_m, float)[..., None]
        return self.start[edge] + s * u + left * n


def _profile(rng: np.random.Generator, kind: str) -> Profile:
    """A cross section of a kind: avenues 21-28 m, streets 13-16 m from house to house."""
    if kind == "alley":
        return Profile(
            kind=kind, carriageway_m=4.2, pavement_m=1.3, lanes=((0.0, 1),), parking=(False, False)
        )
    one_way = rng.random() < (0.45 if kind == "avenue" else 0.55)
    if kind == "avenue":
        count = int(rng.integers(3, 5)) if one_way else 4
        parking = (bool(rng.random() < 0.7), bool(rng.random() < 0.85))
        pavement = rng.uniform(4.0, 5.4)
    else:
        count = 1 if one_way and rng.random() < 0.5 else 2
        parking = (bool(rng.random() < 0.75), bool(count == 1 or rng.random() < 0.6))
        pavement = rng.uniform(2.8, 3.6)
    lane = LANE_M + (0.6 if count == 1 else rng.uniform(-0.1, 0.15))
    carriageway = count * lane + PARKING_M * sum(parking)
    right = -carriageway / 2 + PARKING_M * parking[1]
    offsets = right + lane * (np.arange(count) + 0.5)
    flow = int(rng.choice([-1, 1]))
    directions = [flow] * count if one_way else [1] * (count // 2) + [-1] * (count // 2)
    return Profile(
        kind=kind,
        carriageway_m=float(carriageway),
        pavement_m=float(pavement),
        lanes=tuple((float(o), d) for o, d in zip(offsets, directions, strict=True)),
        parking=parking,
    )


def _stations(rng: np.random.Generator, spacing_m: float) -> np.ndarray:
    """Places of parallel lines across the city, unevenly spaced."""
    count = int(2 * REACH_M / spacing_m) + 2
    gaps = spacing_m * np.clip(rng.normal(1, 0.17, count), 0.7, 1.45)
    places = np.cumsum(gaps) - rng.uniform(0.45, 0.55) * gaps.sum()
    return places[np.abs(places) < REACH_M]


def _kinds(rng: np.random.Generator, places: np.ndarray, share: float) -> list[str]:
    """Which of the parallel lines are avenues: spread evenly, one of them near the middle."""
    every = max(1, round(1 / max(share, 0.02)))
    middle = int(np.argmin(np.abs(places + rng.uniform(-90, 90))))
    return ["avenue" if (i - middle) % every == 0 else "street" for i in range(len(places))]


def _district(rng, angle_rad: float, block_m, avenue_share: float, drop_share: float) -> list:
    """Lines (ends, profile) of a grid turned by `angle_rad`."""
    length, depth = block_m
    x, y = _stations(rng, length + 18), _stations(rng, depth + 16)
    x_kinds = _kinds(rng, x, min(1, 1.6 * avenue_share))
    y_kinds = _kinds(rng, y, 0.6 * avenue_share)
    lines = []
    for at, kind in zip(x, x_kinds, strict=True):
        lines.append((np.array([[at, -REACH_M], [at, REACH_M]]), _profile(rng, kind)))
    gaps = np.concatenate([[-REACH_M], x, [REACH_M]])
    dropped = np.zeros((len(y), len(gaps) - 1), bool)
    for i, (at, kind) in enumerate(zip(y, y_kinds, strict=True)):
        profile = _profile(rng, kind)
        drop = (rng.random(len(gaps) - 1) < drop_share) & (kind == "street")
        drop[[0, -1]] = False
        # Every junction keeps three arms: no two dropped segments meet.
        drop[1:] &= ~drop[:-1]
        if i:
            drop &= ~dropped[i - 1]
        dropped[i] = drop
        cuts = [-REACH_M, *(g for k in np.flatnonzero(drop) for g in gaps[k : k + 2]), REACH_M]
        for a, b in zip(cuts[::2], cuts[1::2], strict=True):
            lines.append((np.array([[a, at], [b, at]]), profile))
    lines += _alleys(rng, x, y, dropped)
    c, s = np.cos(angle_rad), np.sin(angle_rad)
    turn = np.array([[c, s], [-s, c]])
    return [(ends @ turn, profile) for ends, profile in lines]


def _alleys(rng, x: np.ndarray, y: np.ndarray, dropped: np.ndarray) -> list:
    """Alleys across some of the longer blocks."""
    alleys = []
    for (i, (x0, x1)), (j, (y0, y1)) in itertools.product(
        enumerate(itertools.pairwise(x)), enumerate(itertools.pairwise(y))
    ):
        chance = rng.random()
        at = x0 + rng.uniform(0.4, 0.6) * (x1 - x0)
        if x1 - x0 > 115 and chance < 0.3 and not dropped[j : j + 2, i + 1].any():
            alleys.append((np.array([[at, y0], [at, y1]]), _profile(rng, "alley")))
    return alleys


def _clipped(lines: list, point: np.ndarray, normal: np.ndarray) -> list:
    """Lines cut at the straight through `point`, on the side that `normal` points to."""
    kept = []
    for ends, profile in lines:
        side = (ends - point) @ normal
        if side.max() <= 0:
            continue
        if side.min() < 0:
            t = side[0] / (side[0] - side[1])
            cut = ends[0] + t * (ends[1] - ends[0])
            ends = np.stack([cut, ends[1]]) if side[0] < 0 else np.stack([ends[0], cut])
        if np.linalg.norm(ends[1] - ends[0]) > 40 or profile.kind == "alley":
            kept.append((ends, profile))
    return kept


def draw_grid(
    rng: np.random.Generator,
    *,
    block_length_m: float,
    block_depth_m: float,
    avenue_share: float,
    drop_share: float,
    layout: str,
) -> Grid:
    """A street grid.

    Args:
        rng: lane of the streets.
        block_length_m, block_depth_m: mean sides of the blocks.
        avenue_share: share of the lines that are avenues.
        drop_share: share of the segments that are left out.
        layout: one of `LAYOUTS`.
    """
    angle = rng.uniform(0, np.pi)
    block = (block_length_m, block_depth_m)
    lines = _district(rng, angle, block, avenue_share, drop_share)
    if layout != "grid":
        turn = np.radians(rng.uniform(22, 40) * rng.choice([-1, 1]))
        heading = angle + (turn if layout == "diagonal" else np.pi / 2)
        point = rng.uniform(-110, 110, 2)
        u = np.array([np.cos(heading), np.sin(heading)])
        n = np.array([-u[1], u[0]])
        if layout == "districts":
            other = _district(rng, angle + turn, block, avenue_share, drop_share)
            # No street runs close beside the boundary between the districts.
            lines = [
                (ends, profile)
                for ends, profile in _clipped(lines, point, n)
                if np.abs((ends - point) @ n).max() > 55
            ]
            lines += _clipped(other, point, -n)
        lines.append((point + np.outer([-REACH_M, REACH_M], u), _profile(rng, "avenue")))
    return _grid(lines, angle, float(rng.uniform(4.0, 6.2)))


def strip(a: np.ndarray, b: np.ndarray, width_m: float, extra_m: float = 0.0) -> np.ndarray:
    """Corners (4, 2) of a straight strip from a to b, counter-clockwise, longer by `extra_m`."""
    u = (b - a) / np.linalg.norm(b - a)
    n = np.array([-u[1], u[0]]) * width_m / 2
    a, b = a - extra_m * u, b + extra_m * u
    return np.stack([a - n, b - n, b + n, a + n])


def _grid(lines: list, angle: float, corner_m: float) -> Grid:
    ends = np.stack([line for line, _ in lines])
    profiles = tuple(profile for _, profile in lines)
    start, end, line, node, points = _edges(ends)
    middle = np.linalg.norm((start + end) / 2, axis=1)
    kept = middle < REACH_M - 20
    start, end, line, node = start[kept], end[kept], line[kept], node[kept]
    degree = np.bincount(node.ravel(), minlength=len(points))
    carriageway = shapely.union_all(
        shapely.polygons([strip(*e, p.carriageway_m) for e, p in lines])
    )
    # Closing rounds the kerbs at the corners and leaves straight ones alone.
    carriageway = carriageway.buffer(corner_m, quad_segs=4).buffer(-corner_m, quad_segs=4)
    land = shapely.union_all(shapely.polygons([strip(*e, p.width_m, 0.0) for e, p in lines]))
    # Kerbs swing into acute corners: a pavement runs round them, too.
    land = shapely.union(land, carriageway.buffer(1.2, join_style="mitre"))
    return Grid(
        lines=ends,
        profiles=profiles,
        start=start,
        end=end,
        line=line,
        node=node,
        degree=degree,
        setback_m=_setbacks(profiles, start, end, line, carriageway),
        angle_rad=float(angle),
        corner_m=corner_m,
        carriageway=shapely.simplify(carriageway, 0.02),
        street_land=land,
    )


def _edges(ends: np.ndarray):
    """Edges (start, end, line, nodes) between the crossings of lines (k, 2, 2), and the nodes."""
    a, d = ends[:, 0], ends[:, 1] - ends[:, 0]
    cross = d[:, None, 0] * d[None, :, 1] - d[:, None, 1] * d[None, :, 0]
    gap = a[None] - a[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (gap[..., 0] * d[None, :, 1] - gap[..., 1] * d[None, :, 0]) / cross
        t = (gap[..., 0] * d[:, None, 1] - gap[..., 1] * d[:, None, 0]) / cross
    slack = 1e-6
    meet = (np.abs(cross) > 1e-3) & (s > -slack) & (s < 1 + slack) & (t > -slack) & (t < 1 + slack)
    i, j = np.nonzero(np.triu(meet, 1))
    points = [a[i] + s[i, j, None] * d[i]]
    stops = [[(float(s[x, y]), n) for n, (x, y) in enumerate(zip(i, j, strict=True)) if x == k]
             + [(float(t[x, y]), n) for n, (x, y) in enumerate(zip(i, j, strict=True)) if y == k]
             for k in range(len(ends))]  # fmt: skip
    start, end, line, node = [], [], [], []
    count = len(i)
    for k, on_line in enumerate(stops):
        on_line = sorted(on_line)
        for at in (0.0, 1.0):  # ends that meet nothing are nodes of their own
            if all(abs(x - at) * np.linalg.norm(d[k]) > 1.0 for x, _ in on_line):
                on_line.append((at, count))
                points.append((a[k] + at * d[k])[None])
                count += 1
        for (s0, n0), (s1, n1) in itertools.pairwise(sorted(on_line)):
            if (s1 - s0) * np.linalg.norm(d[k]) > 0.5:
                start.append(a[k] + s0 * d[k])
                end.append(a[k] + s1 * d[k])
                line.append(k)
                node.append((n0, n1))
    return (
        np.array(start), np.array(end), np.array(line), np.array(node), np.concatenate(points)
    )  # fmt: skip


def _setbacks(profiles, start, end, line, carriageway) -> np.ndarray:
    """(e, 2): how far from either end of an edge its kerbs are open to another carriageway."""
    length = np.linalg.norm(end - start, axis=1)
    u = (end - start) / length[:, None]
    n = np.stack([-u[:, 1], u[:, 0]], 1)
    half = np.array([profile.carriageway_m / 2 for profile in profiles])[line]
    share = np.linspace(0, 1, 121)
    s = length[:, None] * share  # (e, q)
    hit = np.zeros(s.shape, bool)
    shapely.prepare(carriageway)
    for side in (-1, 1):
        beside = start + (side * (half + 0.25))[:, None] * n
        points = beside[:, None] + s[..., None] * u[:, None]
        hit |= shapely.contains_xy(carriageway, points[..., 0], points[..., 1])
    first = np.where(hit & (share <= 0.5), s, -1).max(axis=1)
    last = np.where(hit & (share >= 0.5), length[:, None] - s, -1).max(axis=1)
    # A sample may lie just inside; the kerb is straight a little later still.
    step = length / 120 + 0.3
    return np.stack([np.where(d >= 0, d + step, 0.0) for d in (first, last)], axis=1)
