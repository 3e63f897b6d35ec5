"""A suburb's street network as centrelines: collectors, rows of local streets, links, cul-de-sacs.

Collectors bend through the map and cut it into districts. Each district has its own family of
parallel curves ("rows", a house, a back yard, a back yard and a house apart), turned against the
next district's. Cross streets tie neighbouring rows together at jittered places; where two rows
stand twice as far apart, cul-de-sacs reach into the gap. Rows end on a collector, in a loop with
their neighbour, or in a bulb.
"""

import numpy as np
import shapely
from scipy import spatial

from synthdepth.maps.streets.graph import (
    JUNCTION_GAP_M,
    STEP_M,
    Network,
    Street,
    StreetGraph,
    bend,
    join_street,
    resampled,
)
from synthdepth.maps.streets.rows import fill_district


def _collectors(rng, net: StreetGraph) -> None:
    h = net.half_m
    square = shapely.box(-h, -h, h, h)
    heading = rng.uniform(0, np.pi)
    first = bend(rng, rng.uniform(-110, 110, 2), heading, 900, rng.uniform(0.25, 0.5))
    turn = np.radians(rng.uniform(62, 118))
    centre = rng.uniform(-150, 150, 2)
    second = bend(rng, centre, heading + turn, 900, rng.uniform(0.2, 0.45))
    lines = [shapely.LineString(first), shapely.LineString(second)]
    crossing = shapely.intersection(*lines)
    point = shapely.get_coordinates(crossing)[0] if not crossing.is_empty else None
    if point is not None and rng.random() < 0.45:  # a T: the second ends on the first
        at = np.linalg.norm(second - point, axis=1).argmin()
        keep = second[: at + 1] if at > len(second) / 2 else second[at:][::-1]
        lines[1] = shapely.LineString(np.concatenate([keep[:-1], point[None]]))
    for line in lines:
        inside = shapely.intersection(line, square)
        parts = [p for p in shapely.get_parts(inside) if p.length > 150]
        for part in sorted(parts, key=lambda p: -p.length)[:1]:
            net.add(shapely.get_coordinates(part), collector=True)
    if point is not None and len(net.lines) == 2:
        net.junctions.append(point)
        net.links.append((1, 0))


def connected(net: StreetGraph) -> np.ndarray:
    """Which streets can be reached from the first collector."""
    reached = np.zeros(len(net.lines), bool)
    reached[0] = True
    links = np.array(net.links, np.int64).reshape(-1, 2)
    for _ in range(len(net.lines)):
        touched = reached[links].any(axis=1)
        if reached[links[touched]].all():
            break
        reached[links[touched].ravel()] = True
    return reached


def _reconnect(rng, net: StreetGraph) -> None:
    """Ties what no street reaches to the nearest street that one can drive to."""
    for _ in range(12):
        reached = connected(net)
        lost = [i for i in np.flatnonzero(~reached) if len(net.lines[i]) > 18]
        made = False
        for i in lost:
            for target in np.flatnonzero(reached):
                d, at = spatial.cKDTree(net.lines[target]).query(net.lines[i][8:-8])
                order = np.argsort(d)
                for k in order[d[order] < 200][::4]:
                    end = at[k]
                    if min(end, len(net.lines[target]) - 1 - end) < 8:
                        continue
                    line = resampled(np.stack([net.lines[i][8 + k], net.lines[target][end]]))
                    if join_street(net, int(i), line, int(target)):
                        made = True
                        break
                if made:
                    break
            if made:
                break
        if not made:
            return


def _infill(rng, net: StreetGraph, lot_depth_m: float) -> None:
    """Closes and links into what is still open land, longest first."""
    inner = net.half_m - 12 - lot_depth_m
    r = np.arange(12.0, 165.0, 7.0)
    start, ahead, parent = [], [], []
    for i in np.flatnonzero(connected(net)):
        line = net.lines[i]
        at = np.arange(9, len(line) - 9, 4)
        if not len(at):
            continue
        slope = np.gradient(line, axis=0)[at] / STEP_M
        for side in (-1, 1):
            start.append(line[at])
            ahead.append(side * np.stack([-slope[:, 1], slope[:, 0]], 1))
            parent.append(np.full(len(at), i))
    start, ahead, parent = (np.concatenate(x) for x in (start, ahead, parent))
    turn = rng.normal(0, 0.12, len(start))
    c, s = np.cos(turn), np.sin(turn)
    ahead = np.stack([c * ahead[:, 0] - s * ahead[:, 1], s * ahead[:, 0] + c * ahead[:, 1]], 1)
    taste = rng.uniform(0.75, 1.0, len(start))
    # Along a stem the nearest street is the one it leaves, until it comes near another one.
    need = np.minimum(0.8 * r, 60.0)
    points = start[:, None] + r[:, None] * ahead[:, None]
    built = np.concatenate([net.lines[i] for i in np.flatnonzero(connected(net))])
    distance = spatial.cKDTree(built).query(points)[0]
    distance[np.abs(points).max(axis=2) > inner] = 0
    apart = spatial.cKDTree(np.asarray(net.junctions)).query(start)[0]
    while True:
        reach = np.argmin(np.pad(distance > need, [(0, 0), (0, 1)]), axis=1)
        longest = np.where((reach > 0) & (apart > JUNCTION_GAP_M), r[reach - 1], 0)
        keep = longest > 62
        if not keep.any():
            return
        start, ahead, parent, points, distance, taste, apart, longest = (
            x[keep] for x in (start, ahead, parent, points, distance, taste, apart, longest)
        )
        best = int(np.argmax(longest * taste))
        length = min(longest[best], rng.uniform(100, 160))
        t = np.linspace(0, 1, 24)[:, None]
        line = resampled(start[best] + t * length * ahead[best])
        street = net.add(line)
        net.meet(line[0], street, 0, int(parent[best]))
        net.bulbs.append((line[-1], street))
        distance = np.minimum(distance, spatial.cKDTree(line).query(points)[0])
        apart = np.minimum(apart, np.linalg.norm(start - line[0], axis=1))


def draw_network(
    rng: np.random.Generator,
    *,
    half_m: float,
    lot_depth_m: float,
    verge_m: float,
    carriageway_range: tuple[float, float],
    collector_range: tuple[float, float],
    bulb_radius_range: tuple[float, float],
) -> Network:
    """A street network for the square of half side `half_m` [m]."""
    net = StreetGraph(half_m)
    local_m, collector_m = rng.uniform(*carriageway_range), rng.uniform(*collector_range)
    street_m = local_m + 2 * (verge_m + 1.95)
    _collectors(rng, net)
    square = shapely.box(-half_m, -half_m, half_m, half_m)
    lines = [square.exterior, *(shapely.LineString(p) for p in net.lines)]
    districts = shapely.get_parts(shapely.polygonize([shapely.union_all(lines)]))
    for district in districts[shapely.area(districts) > 2e4]:
        fill_district(rng, net, district, lot_depth_m, street_m)
    _reconnect(rng, net)
    for _ in range(3):  # later rounds start from the streets of earlier ones
        _infill(rng, net, lot_depth_m)

    reached = connected(net)
    new = np.cumsum(reached) - 1
    width = np.where(net.collector, collector_m, np.round(local_m, 2))
    streets = tuple(
        Street(
            centreline=net.lines[i],
            kind="collector" if net.collector[i] else "local",
            width_m=float(width[i]),
        )
        for i in np.flatnonzero(reached)
    )
    approaches = np.array([a for a in net.approaches if reached[a[2]]]).reshape(-1, 4)
    approaches[:, 2] = new[approaches[:, 2].astype(np.int64)]
    crossings = np.array(net.junctions[: int((1, 0) in net.links[:1])]).reshape(-1, 2)
    junctions = np.concatenate([crossings, approaches[:, :2]])
    _, first = np.unique(np.round(junctions / 2), axis=0, return_index=True)
    radius = rng.uniform(*bulb_radius_range, len(net.bulbs))
    bulbs = np.array(
        [[*p, r] for (p, i), r in zip(net.bulbs, radius, strict=True) if reached[i]]
    ).reshape(-1, 3)
    return Network(
        streets=streets,
        junctions=junctions[np.sort(first)],
        approaches=approaches,
        crossings=crossings,
        bulbs=bulbs,
    )
