"""What hangs over the streets: span wires, string lights, contact wires, banners, footbridges."""

import numpy as np
import shapely

from synthdepth.maps.downtown.fittings import Fittings
from synthdepth.maps.downtown.grid import Grid
from synthdepth.maps.downtown.kerbside import STAIRS_M, Kerbside, bridge_m
from synthdepth.maps.downtown.parcels import Lot
from synthdepth.maps.downtown.surface import KERB_HEIGHT_M
from synthdepth.maps.furniture.footbridge import footbridge
from synthdepth.maps.furniture.poles import catenary, wires
from synthdepth.maps.geometry import Model, copies, geometry, join, place, quads, tube

_CABLE = (0.025, 0.025, 0.026)
_STEEL = (0.24, 0.25, 0.26)
_BANNERS = ((0.3, 0.03, 0.03), (0.05, 0.09, 0.25), (0.5, 0.34, 0.05), (0.06, 0.2, 0.1),
            (0.55, 0.54, 0.5), (0.25, 0.05, 0.2))  # fmt: skip


def _walls(lots: list[Lot]) -> tuple[shapely.STRtree, np.ndarray]:
    """Footprints of the buildings and their heights [m]."""
    built = [lot for lot in lots if lot.built]
    shapes = np.array([shapely.Polygon(lot.footprint) for lot in built], dtype=object)
    return shapely.STRtree(shapes), np.array([3.1 * lot.storeys for lot in built])


def _anchors(grid: Grid, edge: int, s: np.ndarray, walls, least_m: float):
    """Where lines across a street at `s` (k,) meet a building on either side.

    Returns:
        left and right points (k, 2), which of the lines meet two high enough buildings (k,).
    """
    tree, height = walls
    reach = grid.profile(edge).width_m / 2 + 5.2
    ends, found = [], np.ones(len(s), bool)
    for side in (1, -1):
        axis, far = grid.at(edge, s, 0 * s), grid.at(edge, s, 0 * s + side * reach)
        rays = shapely.linestrings(np.stack([axis, far], 1))
        ray, shape = tree.query(rays, predicate="intersects")
        hit = np.full(len(s), np.inf)
        for r, k in zip(ray, shape, strict=True):
            if height[k] > least_m:
                hit[r] = min(hit[r], shapely.distance(shapely.Point(axis[r]), tree.geometries[k]))
        found &= np.isfinite(hit)
        hit = np.where(np.isfinite(hit), hit, 1.0)
        ends.append(grid.at(edge, s, side * (hit + 0.03)))
    return ends[0], ends[1], found


def hang_cables(
    rng: np.random.Generator,
    grid: Grid,
    kerbs: list[Kerbside],
    lots: list[Lot],
    out: Fittings,
    *,
    share: float,
    bridged: list[int],
    half_m: float,
) -> None:
    """Wires over a share of the streets: lamps on span wires, lights in zigzag, trolley wires.

    Args:
        rng: the lane of the cables.
        grid: the streets.
        kerbs: their layout.
        lots: whose buildings wires are fixed to.
        out: what it is added to.
        share: of the streets.
        bridged: edges with a footbridge, which wires would run into.
        half_m: half the side of the square that flights keep to.
    """
    walls = _walls(lots)
    pairs: dict[int, dict[int, Kerbside]] = {}
    for kerb in kerbs:
        pairs.setdefault(kerb.edge, {})[kerb.side] = kerb
    kinds = ("span", "string", "trolley", "banner")
    chosen = rng.random(len(grid.lines)) < share
    kind_of = rng.choice(kinds, len(grid.lines), p=[0.28, 0.22, 0.3, 0.2])
    for edge, both in pairs.items():
        middle = np.abs(grid.start[edge] + grid.end[edge]).max() / 2
        if middle > half_m + 70 or edge in bridged:
            continue
        low = max(kerb.span_m[0] for kerb in both.values()) - 3
        high = min(kerb.span_m[1] for kerb in both.values()) + 3
        # Single cables cross everywhere but over trolley wires.
        kind = kind_of[grid.line[edge]] if chosen[grid.line[edge]] else "loose"
        if kind != "trolley":
            _loose_cables(rng, grid, edge, low, high, walls, out)
        if kind == "span":
            s = np.arange(low + 6, high, rng.uniform(16, 26))
            _span_lamps(rng, grid, edge, s, walls, out)
        elif kind == "string":
            _string_lights(rng, grid, edge, low, high, walls, out)
        elif kind == "trolley":
            _trolley(rng, grid, edge, low, high, out)
        elif kind == "banner":
            _banners(rng, grid, edge, low, high, walls, out)


def _loose_cables(rng, grid: Grid, edge: int, low, high, walls, out: Fittings) -> None:
    """Telephone and power cables: bundles that fan out from house to house across the street."""
    count = rng.poisson((high - low) / 26)
    start = np.repeat(rng.uniform(low, high, count), rng.integers(1, 5, count))
    end = np.clip(start + rng.normal(0, 7, len(start)), low, high)
    if not len(start):
        return
    side = rng.random(len(start)) < 0.5
    a, _, found_a = _anchors(grid, edge, np.where(side, start, end), walls, 8.5)
    _, b, found_b = _anchors(grid, edge, np.where(side, end, start), walls, 8.5)
    found = found_a & found_b
    if found.any():
        a, b = a[found], b[found]
        level = rng.uniform(6.3, 8.3, (2, len(a)))
        curve = catenary(
            np.column_stack([a, level[0]]),
            np.column_stack([b, level[1]]),
            rng.uniform(0.015, 0.045, len(a)),
            10,
        )
        out.models.append({("paint", "wire"): wires(curve, 0.015, _CABLE)})


def _span_lamps(rng, grid: Grid, edge: int, s, walls, out: Fittings) -> None:
    """Cables from house to house with a lamp hanging in the middle of each."""
    a, b, found = _anchors(grid, edge, s, walls, 8.5)
    if not found.any():
        return
    a, b = a[found], b[found]
    level = rng.uniform(6.9, 8.3, len(a))
    curve = catenary(
        np.column_stack([a, level]),
        np.column_stack([b, level]),
        rng.uniform(0.015, 0.04, len(a)),
        8,
    )
    head = join(
        [
            tube([[0, 0, 0.0], [0, 0, -0.35]], 0.012, 4, _STEEL),
            tube([[0, 0, -0.32], [0, 0, -0.42], [0, 0, -0.6]], [0.05, 0.16, 0.2], 8, _STEEL),
        ]
    )
    square = np.array([[-1, -1], [-1, 1], [1, 1], [1, -1]]) * 0.13  # seen from below
    glow = quads([[[*corner, -0.605] for corner in square]], (0.65, 0.6, 0.5))
    low = curve[:, 4]
    out.models.append(
        {
            ("paint", "wire"): wires(curve, 0.012, _CABLE),
            ("paint", "pole"): copies(head, low),
            ("lamp", "pole"): copies(glow, low),
        }
    )


def _string_lights(rng, grid: Grid, edge: int, low, high, walls, out: Fittings) -> None:
    """Strings of bulbs in zigzag from house to house."""
    s = np.arange(low + 2, high, rng.uniform(6, 9))
    a, b, found = _anchors(grid, edge, s, walls, 8.5)
    k = np.arange(len(s) - 1)
    ok = found[:-1] & found[1:]
    start, end = (
        np.where((k % 2 == 0)[:, None], a[:-1], b[:-1]),
        np.where((k % 2 == 0)[:, None], b[1:], a[1:]),
    )
    if not ok.any():
        return
    level = np.full((ok.sum(), 1), rng.uniform(5.8, 7.2))
    curve = catenary(np.hstack([start[ok], level]), np.hstack([end[ok], level]), 0.035, 24)
    bulbs = curve[:, 1:-1].reshape(-1, 3)
    bulb = tube([[0, 0, 0.0], [0, 0, -0.05], [0, 0, -0.11]], [0.016, 0.045, 0.02], 5)
    out.models.append(
        {
            ("paint", "wire"): wires(curve, 0.012, _CABLE),
            ("paint", "street_furniture"): copies(bulb, bulbs).tinted((0.62, 0.55, 0.4)),
        }
    )


def _trolley(rng, grid: Grid, edge: int, low, high, out: Fittings) -> None:
    """Poles on both pavements, span wires between them, and contact wires along the lanes."""
    profile = grid.profile(edge)
    count = max(2, int((high - low) / 27) + 1)
    s = np.linspace(low + 1.0, high - 1.0, count)
    off = profile.carriageway_m / 2 + 0.32
    feet = [grid.at(edge, s, np.full(count, side * off)) for side in (1, -1)]
    pole = tube([[0, 0, -0.2], [0, 0, 7.4]], [0.13, 0.085], 8, _STEEL)
    at = np.concatenate([np.column_stack([f, np.full(count, KERB_HEIGHT_M)]) for f in feet])
    level = np.full((count, 1), 7.0)
    span = catenary(np.hstack([feet[0], level]), np.hstack([feet[1], level]), 0.022, 8)
    lanes = np.array([offset for offset, _ in profile.lanes])
    tracks = np.unique(np.round([lanes.min(), lanes.max()], 2))
    lines = []
    for track in np.concatenate([tracks - 0.3, tracks + 0.3]):
        xy = grid.at(edge, s, np.full(count, track))
        share = 0.5 - track / (2 * off)
        z = np.interp(share, np.linspace(0, 1, 9), span[0, :, 2]) - 0.32
        points = np.column_stack([xy, np.full(count, z)])
        lines.append(catenary(points[:-1], points[1:], 0.003, 4))
        hung = np.column_stack([xy, np.full(count, z + 0.32)])
        lines.append(catenary(hung, points + [1e-3, 0, 0], 1e-4, 4))
    out.models.append(
        {
            ("paint", "pole"): copies(pole, at),
            ("paint", "wire"): join(
                [wires(span, 0.012, _CABLE), *(wires(line, 0.011, (0.11, 0.07, 0.05))
                                               for line in lines)]
            ),
        }
    )  # fmt: skip


def _banners(rng, grid: Grid, edge: int, low, high, walls, out: Fittings) -> None:
    """Cloths on cables across the street, some with rows of pennants."""
    s = np.arange(low + 8, high, rng.uniform(26, 40))
    a, b, found = _anchors(grid, edge, s, walls, 9.5)
    u = grid.along[edge]
    for p, q in zip(a[found], b[found], strict=True):
        top = rng.uniform(7.2, 8.4)
        curve = catenary([[*p, top]], [[*q, top]], 0.02, 16)
        parts = {("paint", "wire"): wires(curve, 0.009, _CABLE)}
        colour = np.array(_BANNERS[int(rng.integers(len(_BANNERS)))])
        run = curve[0]
        if rng.random() < 0.5:
            upper = run[5:12] - [0, 0, 0.05]
            lower = upper - [0, 0, rng.uniform(0.8, 1.2)]
            wave = 0.1 * np.sin(np.arange(7) * 1.3)[:, None] * np.array([*u, 0])
            cloth = np.stack(
                [lower[:-1] + wave[:-1], lower[1:] + wave[1:], upper[1:], upper[:-1]], 1
            )
            parts["fabric", "street_furniture"] = quads(cloth, colour)
            rise = upper - lower
            high, low_edge = lower + 0.62 * rise + wave * 0.4, lower + 0.3 * rise + wave * 0.7
            stripe = np.stack([low_edge[:-1], low_edge[1:], high[1:], high[:-1]], 1)
            stripe = stripe + 0.02 * np.array([*u, 0])
            parts["fabric", "street_furniture"] = join(
                [parts["fabric", "street_furniture"], quads(stripe[1:-1], (0.6, 0.6, 0.57))]
            )
        else:
            t = np.linspace(0.04, 0.96, 26)
            at = np.stack(
                [np.interp(t, np.linspace(0, 1, len(run)), run[:, k]) for k in range(3)], 1
            )
            across = (q - p) / np.linalg.norm(q - p) * 0.14
            side = np.array([*across, 0])
            tip = at + rng.normal(0, 0.05, (len(at), 1)) * np.array([*u, 0]) - [0, 0, 0.34]
            corners = np.stack([at - side, tip, at + side], 1)
            tint = np.array(_BANNERS)[rng.integers(len(_BANNERS), size=len(at))]
            parts["fabric", "street_furniture"] = geometry(
                corners, np.arange(3 * len(at)), tint=np.repeat(tint, 3, axis=0)
            )
        out.models.append(parts)


def bridged_edges(grid: Grid, count: int) -> list[int]:
    """The `count` avenues' edges nearest to the middle that have room for a footbridge."""
    middle = np.linalg.norm((grid.start + grid.end) / 2, axis=1)
    free = grid.length_m - grid.setback_m.sum(axis=1)
    fit = [
        int(edge)
        for edge in np.flatnonzero((middle < 200) & (free > 2 * STAIRS_M + 20))
        if grid.profile(edge).kind == "avenue" and grid.profile(edge).pavement_m > 3.9
    ]
    return sorted(fit, key=lambda edge: middle[edge])[:count]


def footbridges(rng: np.random.Generator, grid: Grid, edges: list[int]) -> list[Model]:
    """Footbridges over the middle of edges; their stairs run along the pavements."""
    models = []
    for edge in edges:
        u = grid.along[edge]
        span = grid.profile(edge).carriageway_m + 1.6
        model = footbridge(rng, span_m=span, clearance_m=float(rng.uniform(4.7, 5.4)))
        middle = grid.at(edge, np.array(bridge_m(grid, edge)), np.array(0.0))
        yaw = float(np.arctan2(u[1], u[0]) - np.pi / 2)
        models.append(place(model, [*middle, KERB_HEIGHT_M - 0.02], yaw))
    return models
