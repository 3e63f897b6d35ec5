"""Lots: the land between the streets, parcelled along their frontages."""

import dataclasses

import numpy as np
import shapely
from scipy import ndimage, spatial

from synthdepth.maps.streets.graph import length_m

FRONT_GAP_M = 0.3  # between the pavement and the lots
RING_STEP_M = 2.0
HOUSE_WIDTH_M = 13.5  # narrower or shallower lots, or smaller ones, take no house
HOUSE_DEPTH_M = 23.0
HOUSE_AREA_M2 = 380.0
PARK_AREA_M2 = 1100.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Lot:
    """A parcel of land.

    Attributes:
        polygon: (n, 2) float64 [m], counter-clockwise, not closed, nearly convex.
        front: (2,) [m], the middle of the usable frontage, on the street side.
        inward: (2,) unit vector from the street into the lot.
        width_m: clear width about the axis from `front` along `inward`, over the first 24 m.
        depth_m: length of that axis inside the lot.
        kind: "house", "vacant" or "park".
        lawn_tint: (3,) colour multiplier of its grass.
    """

    polygon: np.ndarray
    front: np.ndarray
    inward: np.ndarray
    width_m: float
    depth_m: float
    kind: str
    lawn_tint: np.ndarray


def _ring(coordinates: np.ndarray) -> np.ndarray:
    """A closed ring resampled every `RING_STEP_M`, last point left out."""
    s = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(coordinates, axis=0), axis=1))])
    t = np.linspace(0, s[-1], max(int(s[-1] / RING_STEP_M), 8), endpoint=False)
    return np.stack([np.interp(t, s, coordinates[:, k]) for k in (0, 1)], 1)


def _frontages(blocks: np.ndarray, half_m: float) -> list[dict]:
    """Stretches of block edge between corners: points, inward normals, block, corner flags."""
    runs = []
    for block in range(len(blocks)):
        rings = shapely.get_rings(shapely.orient_polygons(blocks[block]))
        for ring in rings:
            p = _ring(shapely.get_coordinates(ring))
            n = len(p)
            if n < 20:
                continue
            tangent = np.roll(p, -3, 0) - np.roll(p, 3, 0)
            tangent /= np.linalg.norm(tangent, axis=1, keepdims=True) + 1e-9
            before, after = p - np.roll(p, 2, 0), np.roll(p, -2, 0) - p
            cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
            turn = np.arctan2(cross, np.einsum("ni,ni->n", before, after))
            peak = turn == ndimage.maximum_filter1d(turn, 7, mode="wrap")
            corner = peak & (turn > np.radians(46))
            outer = np.abs(p).max(axis=1) > half_m - 4.0
            cuts = np.flatnonzero(
                corner | (outer & ~np.roll(outer, 1)) | (~outer & np.roll(outer, 1))
            )
            if not len(cuts):
                cuts = np.array([0])
            for a, b in zip(cuts, [*cuts[1:], cuts[0] + n], strict=True):
                index = np.arange(a, b + 1) % n
                if len(index) < 8 or outer[index[1:-1]].any():
                    continue
                t = tangent[index].copy()
                # At its ends a stretch keeps its own direction, not the corner's mean.
                t[:3], t[-3:] = t[min(3, len(t) - 1)], t[max(-4, -len(t))]
                runs.append(
                    {
                        "block": block,
                        "points": p[index],
                        "normal": np.stack([-t[:, 1], t[:, 0]], 1),
                        "corner": (bool(corner[index[0]]), bool(corner[index[-1]])),
                    }
                )
    return runs


def _depths(rng, runs: list[dict], blocks: np.ndarray, half_m: float, depth_m: float) -> None:
    """Sets each stretch's lot depth: to the medial line of its block, or `depth_m`."""
    edges = shapely.get_rings(shapely.orient_polygons(blocks))
    coordinates, ring = shapely.get_coordinates(edges, return_index=True)
    same = ring[1:] == ring[:-1]
    a, b = coordinates[:-1][same], coordinates[1:][same]
    tree = shapely.STRtree(shapely.linestrings(np.stack([a, b], 1)))
    start = np.concatenate([r["points"][1:-1:3] for r in runs])
    normal = np.concatenate([r["normal"][1:-1:3] for r in runs])
    origin = start + 1.0 * normal
    rays = shapely.linestrings(np.stack([origin, origin + 110 * normal], 1))
    i, j = tree.query(rays, predicate="intersects")
    edge, to = b[j] - a[j], a[j] - origin[i]
    cross = normal[i, 0] * edge[:, 1] - normal[i, 1] * edge[:, 0]
    distance = (to[:, 0] * edge[:, 1] - to[:, 1] * edge[:, 0]) / np.where(cross == 0, 1e-9, cross)
    # Inward normal of what is hit: a street that faces this one shares the land with it.
    facing = -(-edge[:, 1] * normal[i, 0] + edge[:, 0] * normal[i, 1])
    facing /= np.linalg.norm(edge, axis=1) + 1e-9
    outer = np.abs((a[j] + b[j]) / 2).max(axis=1) > half_m - 4.0
    share = np.where(outer, 1.0, np.where(facing > 0.5, 0.5, 1.0))
    room = np.full(len(start), 110.0)
    np.minimum.at(room, i, (distance + 1.0) * share)
    first = 0
    for run in runs:
        count = len(run["points"][1:-1:3])
        own = room[first : first + count]
        first += count
        target = depth_m + rng.uniform(-1.5, 1.5)
        depth = np.where(own < depth_m + 7, own, target)
        depth = ndimage.median_filter(depth, 5, mode="nearest")
        at = np.arange(1, len(run["points"]) - 1, 3)
        run["depth"] = np.interp(np.arange(len(run["points"])), at, depth)


def _polygons(rings: list[list[np.ndarray]]) -> np.ndarray:
    count = [len(r) for r in rings]
    indices = np.repeat(np.arange(len(rings)), count)
    return shapely.polygons(shapely.linearrings(np.concatenate(rings), indices=indices))


def _cut_lots(rng, runs: list[dict], frontage_range):
    """Quadrilaterals side by side along each stretch; the longer stretch takes the corner."""
    length = np.array([length_m(r["points"]) for r in runs])
    ends = {}
    for k, run in enumerate(runs):
        for end in (0, 1):
            if run["corner"][end]:
                point = run["points"][-end]
                ends.setdefault((run["block"], *np.round(point, 3)), []).append((k, end))
    trim = np.zeros((len(runs), 2))
    for members in ends.values():
        if len(members) == 2:
            (k0, e0), (k1, e1) = members
            if length[k0] < length[k1]:
                (k0, e0), (k1, e1) = (k1, e1), (k0, e0)
            trim[k1, e1] = runs[k0]["depth"][-e0] + 0.2
    low, high = frontage_range
    mean = rng.uniform(low + 4.5, high - 0.5)
    polygons, probes, block, priority, fronts, inwards = [], [], [], [], [], []
    for k, run in enumerate(runs):
        p, n, depth = run["points"], run["normal"], run["depth"]
        # Widths are measured along the building line, 8 m in: wedges on bulbs come out fair.
        step = np.linalg.norm(np.diff(p, axis=0), axis=1)
        back = np.linalg.norm(np.diff(p + 8 * n, axis=0), axis=1)
        s = np.concatenate([[0], np.cumsum(step)])
        w = np.concatenate([[0], np.cumsum(np.maximum(0.75 * back + 0.25 * step, 0.1))])
        w0, w1 = np.interp([trim[k, 0], s[-1] - trim[k, 1]], s, w)
        count = round((w1 - w0) / (mean + rng.normal(0, 0.8)))
        if count < 1 and w1 - w0 > low - 2:
            count = 1
        if count < 1:
            continue
        share = rng.uniform(0.88, 1.12, count)
        marks = w0 + (w1 - w0) * np.concatenate([[0], np.cumsum(share) / share.sum()])
        position = np.interp(marks, w, np.arange(len(p)))
        low_i = np.minimum(position.astype(np.int64), len(p) - 2)
        f = (position - low_i)[:, None]
        front = (1 - f) * p[low_i] + f * p[low_i + 1]
        inward = (1 - f) * n[low_i] + f * n[low_i + 1]
        inward /= np.linalg.norm(inward, axis=1, keepdims=True)
        deep = np.interp(position, np.arange(len(p)), depth)
        rear = front + deep[:, None] * inward
        for i in range(count):
            inner = np.arange(low_i[i] + 1, low_i[i + 1] + 1)[1:-1:2]
            bow = [p[m] + depth[m] * n[m] for m in inner[len(inner) // 2 :][:1]]
            ring = [front[i], *p[inner], front[i + 1], rear[i + 1], *bow, rear[i]]
            polygons.append(ring)
            # The same lot drawn back from its own street: what leaves the block, crosses another.
            ring = [
                front[i] + 0.5 * inward[i],
                front[i + 1] + 0.5 * inward[i + 1],
                *ring[len(inner) + 2 :],
            ]
            probes.append(ring)
            block.append(run["block"])
            priority.append(length[k])
            middle = round((position[i] + position[i + 1]) / 2)
            fronts.append(p[middle])
            inwards.append(n[middle])
    rings = [_polygons(polygons), _polygons(probes)]
    return (*rings, *map(np.array, (block, priority, fronts, inwards)))


def _largest_part(polygons: np.ndarray) -> np.ndarray:
    parts, owner = shapely.get_parts(polygons, return_index=True)
    area = np.where(shapely.get_type_id(parts) == 3, shapely.area(parts), 0)
    order = np.lexsort([-area, owner])
    first = np.concatenate([[True], owner[order][1:] != owner[order][:-1]])
    chosen = np.full(len(polygons), shapely.Polygon(), dtype=object)
    chosen[owner[order[first]]] = parts[order[first]]
    return np.where(shapely.get_type_id(chosen) == 3, chosen, shapely.Polygon())


# Of the coordinates that overlays are rounded to: without, lots that share an edge to rounding
# make them fail.
_GRID_M = 1e-4


def _without_overlaps(polygons: np.ndarray, priority: np.ndarray) -> np.ndarray:
    """Each polygon less the overlapping ones of higher priority."""
    order = np.lexsort([np.arange(len(polygons)), -priority])
    rank = np.empty(len(order), np.int64)
    rank[order] = np.arange(len(order))
    polygons = polygons.copy()
    i, j = shapely.STRtree(polygons).query(polygons, predicate="intersects")
    pairs = np.stack([i, j], 1)[rank[i] > rank[j]]
    overlap = shapely.area(
        shapely.intersection(polygons[pairs[:, 0]], polygons[pairs[:, 1]], grid_size=_GRID_M)
    )
    for cut, by in pairs[overlap > 1e-6]:
        rest = shapely.difference(polygons[cut], polygons[by], grid_size=_GRID_M)
        # Slivers may be left as lines, and of areas mixed with lines nothing can be taken away.
        polygons[cut] = _largest_part(np.array([rest]))[0]
    return polygons


def _longest_parts(lines: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Ends (k, 2, 2) of the longest part of each line, and which line it is of."""
    parts, owner = shapely.get_parts(lines, return_index=True)
    straight = (shapely.get_type_id(parts) == 1) & (shapely.length(parts) > 0)
    parts, owner = parts[straight], owner[straight]
    order = np.lexsort([-shapely.length(parts), owner])
    first = order[np.unique(owner[order], return_index=True)[1]]
    ends = [shapely.get_coordinates(shapely.get_point(parts[first], i)) for i in (0, -1)]
    return np.stack(ends, 1), owner[first]


def _usable(polygons, front, inward):
    """Clear width, depth and recentred front of each lot about its axis."""
    aside = np.stack([-inward[:, 1], inward[:, 0]], 1)
    low, high = np.full(len(polygons), -60.0), np.full(len(polygons), 60.0)
    for y in (3.0, 10.0, 17.0, 24.0):
        middle = front + y * inward
        chord = shapely.linestrings(np.stack([middle - 60 * aside, middle + 60 * aside], 1))
        ends, owner = _longest_parts(shapely.intersection(chord, polygons))
        offset = np.einsum("nij,nj->ni", ends - middle[owner, None], aside[owner])
        left, right = np.full(len(polygons), -60.0), np.full(len(polygons), 60.0)
        left[owner], right[owner] = offset.max(axis=1), offset.min(axis=1)
        high, low = np.minimum(high, left), np.maximum(low, right)
    centre = front + ((low + high) / 2)[:, None] * aside
    axis = shapely.linestrings(np.stack([centre - 6 * inward, centre + 80 * inward], 1))
    ends, owner = _longest_parts(shapely.intersection(axis, polygons))
    reach = np.einsum("nij,nj->ni", ends - centre[owner, None], inward[owner])
    near, depth = np.zeros(len(polygons)), np.zeros(len(polygons))
    near[owner], depth[owner] = reach.min(axis=1), np.ptp(reach, axis=1)
    return centre + near[:, None] * inward, np.maximum(high - low, 0.0), depth


def _whole(park: shapely.Geometry) -> list:
    """A piece of land as polygons without holes, cut through the holes where it has some."""
    todo, done = [park], []
    while todo:
        piece = todo.pop()
        hole = shapely.get_interior_ring(piece, 0)
        if hole is None:
            done.append(piece)
            continue
        x0, y0, x1, y1 = piece.bounds
        x = hole.centroid.x
        for side in (shapely.box(x0, y0, x, y1), shapely.box(x, y0, x1, y1)):
            todo += [p for p in shapely.get_parts(piece & side) if p.area > PARK_AREA_M2]
    return done


def _parks(rng, blocks, lots, block_of_lot, runs) -> list[Lot]:
    """Greens on the larger pieces of land that no lot covers."""
    edge = np.concatenate([r["points"] for r in runs])
    normal = np.concatenate([r["normal"] for r in runs])
    tree = spatial.cKDTree(edge)
    used = np.bincount(block_of_lot, shapely.area(lots), minlength=len(blocks))
    tint = _lawn_tints(rng, 1)[0]
    parks = []
    for b in np.flatnonzero(shapely.area(blocks) - used > PARK_AREA_M2):
        taken = shapely.union_all(lots[block_of_lot == b], grid_size=0.01)
        rest = shapely.difference(shapely.simplify(blocks[b], 0.2), taken)
        # Opening leaves out the slivers between lots, and stays off their fences.
        rest = shapely.buffer(rest, -6, join_style="mitre")
        rest = shapely.buffer(rest, 5.4, quad_segs=2)
        for piece in shapely.get_parts(shapely.simplify(rest, 0.4)):
            parks += _whole(piece) if piece.area > PARK_AREA_M2 else []
    made = []
    for park in parks:
        ring = shapely.get_coordinates(shapely.orient_polygons(park).exterior)[:-1]
        nearest = tree.query(ring)
        front = int(nearest[1][nearest[0].argmin()])
        made.append(
            Lot(
                polygon=ring,
                front=edge[front],
                inward=normal[front],
                width_m=float(np.sqrt(park.area)),
                depth_m=float(np.sqrt(park.area)),
                kind="park",
                lawn_tint=tint,
            )
        )
    return made


def _lawn_tints(rng: np.random.Generator, count: int) -> np.ndarray:
    """Greener, paler or drier grass: (n, 3)."""
    dry = rng.beta(1.3, 2.6, count)[:, None]
    return (1 + dry * [0.26, 0.08, 0.02]) * rng.uniform(0.84, 1.1, count)[:, None]


def draw_lots(
    rng: np.random.Generator,
    street_land: shapely.Geometry,
    *,
    half_m: float,
    frontage_range: tuple[float, float],
    depth_m: float,
    park_share: float,
    vacant_share: float,
) -> tuple[Lot, ...]:
    """Parcels the land outside `street_land` in the square of half side `half_m` [m].

    Lots stand side by side along every frontage, back to back on the medial line of their block.
    A few whole stretches become parks, a few lots stay vacant, and so does land that fits no house
    but a green.
    """
    square = shapely.box(-half_m + 2, -half_m + 2, half_m - 2, half_m - 2)
    roads = shapely.simplify(shapely.buffer(street_land, FRONT_GAP_M, quad_segs=3), 0.02)
    blocks = shapely.get_parts(shapely.difference(square, roads))
    blocks = blocks[shapely.area(blocks) > 400]
    runs = _frontages(blocks, half_m)
    _depths(rng, runs, blocks, half_m, depth_m)
    raw, probe, block, priority, front, inward = _cut_lots(rng, runs, frontage_range)
    raw = shapely.make_valid(raw)
    shapely.prepare(blocks)
    out = ~shapely.contains_properly(blocks[block], probe)
    raw[out] = shapely.intersection(raw[out], blocks[block[out]])
    raw = _largest_part(raw)
    polygons = _without_overlaps(raw, priority)
    front, width, depth = _usable(polygons, front, inward)
    area = shapely.area(polygons)
    hull = shapely.area(shapely.convex_hull(polygons))
    good = (width > HOUSE_WIDTH_M) & (depth > HOUSE_DEPTH_M) & (area > HOUSE_AREA_M2)
    good &= (area > 0.86 * hull) & shapely.is_valid(polygons)
    good &= shapely.get_num_interior_rings(polygons) == 0
    # Parks take the place of the lots around a few points.
    for _ in range(rng.binomial(3, park_share)):
        middle = front[rng.integers(len(front))]
        good &= np.linalg.norm(front - middle, axis=1) > rng.uniform(35, 60)
    polygons, block, front, inward, width, depth = (
        x[good] for x in (polygons, block, front, inward, width, depth)
    )
    vacant = rng.random(len(polygons)) < vacant_share
    tints = _lawn_tints(rng, len(polygons))
    lots = [
        Lot(
            polygon=shapely.get_coordinates(ring)[:-1],
            front=front[i],
            inward=inward[i],
            width_m=float(width[i]),
            depth_m=float(depth[i]),
            kind="vacant" if vacant[i] else "house",
            lawn_tint=tints[i],
        )
        for i, ring in enumerate(shapely.orient_polygons(polygons))
    ]
    return tuple(lots + _parks(rng, blocks, polygons, block, runs))
