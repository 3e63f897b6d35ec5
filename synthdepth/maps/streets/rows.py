"""A district of a suburb: rows of local streets, tied by cross streets, loops and closes."""

import numpy as np
import shapely
from scipy import ndimage, spatial

from synthdepth.maps.streets.graph import STEP_M, StreetGraph, bend, join_street, resampled


def _offset_rows(base: np.ndarray, offsets: np.ndarray) -> list[np.ndarray]:
    """Curves parallel to a polyline, kinks rounded off."""
    tangent = np.gradient(ndimage.gaussian_filter1d(base, 3, axis=0, mode="nearest"), axis=0)
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], 1)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    rows = []
    for t in offsets:
        line = base + t * normal
        # Beyond the centre of curvature an offset curve runs backwards: those points go.
        forward = np.einsum("ni,ni->n", np.gradient(line, axis=0), tangent) > 0.15
        line = line[forward]
        line = ndimage.gaussian_filter1d(resampled(line), 5, axis=0, mode="nearest")
        rows.append(resampled(line))
    return rows


def _runs(mask: np.ndarray, shortest: int) -> list[tuple[int, int]]:
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    return [(a, b) for a, b in zip(edges[::2], edges[1::2], strict=True) if b - a >= shortest]


def _row_gaps(rng, lot_depth_m: float, street_m: float, double_share: float):
    """Row offsets over a kilometre either side, and which gaps hold cul-de-sacs."""
    count = 30
    double = rng.random(count) < double_share
    double[1:] &= ~double[:-1]
    single = 2 * lot_depth_m + street_m + rng.uniform(-3, 9, count)
    gap = np.where(double, 2 * single + rng.uniform(-8, 8, count), single)
    return np.concatenate([[0.0], np.cumsum(gap)]), double


def fill_district(rng, net: StreetGraph, district, lot_depth_m, street_m) -> None:
    """Lays rows through a district (a polygon between collectors) and ties them together.

    The rows follow one of the bordering collectors, or a curve turned against it. `street_m` is
    the width of a local street with its pavements.
    """
    collectors = [i for i, c in enumerate(net.collector) if c]
    points = np.concatenate([net.lines[i] for i in collectors])
    owner = np.concatenate([np.full(len(net.lines[i]), i) for i in collectors])
    tangents = np.concatenate([np.gradient(net.lines[i], axis=0) for i in collectors])
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    tree = spatial.cKDTree(points)
    centroid = shapely.get_coordinates(district.centroid)[0]
    shapely.prepare(district)

    border = [i for i in collectors if shapely.LineString(net.lines[i]).distance(district) < 5]
    guide = border[int(rng.integers(len(border)))]
    gaps, double = _row_gaps(rng, lot_depth_m, street_m, rng.uniform(0.15, 0.5))
    _, near = spatial.cKDTree(net.lines[guide]).query(centroid)
    along = np.gradient(net.lines[guide], axis=0)[near]
    parallel = rng.random() < 0.5
    if parallel:
        line = net.lines[guide]
        ends = [line[0] - line[4], line[-1] - line[-5]]
        ends = [e / np.linalg.norm(e) * 500 for e in ends]
        base = resampled(np.concatenate([[line[0] + ends[0]], line, [line[-1] + ends[1]]]))
        side = np.sign(
            along[0] * (centroid - line[near])[1] - along[1] * (centroid - line[near])[0]
        )
        offsets, kinds = side * gaps[:14], double[:14]
    else:
        turn = rng.choice([-1, 1]) * np.radians(rng.uniform(18, 75))
        heading = np.arctan2(along[1], along[0]) + turn
        base = bend(rng, centroid, heading, 800, rng.uniform(0.15, 0.5))
        middle = len(gaps) // 2
        offsets, kinds = gaps - gaps[middle] + rng.uniform(-30, 30), double
        keep = np.abs(offsets) < 720
        offsets, kinds = offsets[keep], kinds[keep[: len(kinds)]]

    inner = net.half_m - 12 - lot_depth_m
    rows: list[list[int]] = []
    free: dict[tuple[int, int], np.ndarray] = {}
    for t, line in zip(offsets, _offset_rows(base, offsets), strict=True):
        rows.append([])
        if parallel and abs(t) < 1:
            rows[-1] = [guide]
            continue
        d, i = tree.query(line)
        slope = np.gradient(line, axis=0)
        slope /= np.linalg.norm(slope, axis=1, keepdims=True)
        cosine = np.abs(np.einsum("ni,ni->n", slope, tangents[i]))
        mask = shapely.contains_xy(district, line) & (np.abs(line).max(axis=1) < inner)
        mask &= ~((d < 70) & (cosine > 0.68)) & (d > 2)
        mask &= ~((d < 40) & (cosine > 0.5))
        # Kinks are left where an offset curve folded over.
        turn = np.linalg.norm(np.gradient(slope, axis=0), axis=1) / STEP_M
        mask &= ndimage.maximum_filter1d(turn, 9) < 1 / 18
        for a, b in _runs(mask, 20):
            part = line[a:b]
            hits = []
            for end in (0, -1):
                dist, at = tree.query(part[end])
                hit = None
                if dist < 2.5 * STEP_M and np.abs(points[at]).max() < inner:
                    old = net.junction_near(points[at])
                    if old is None:
                        hit = (points[at], owner[at])
                    elif np.linalg.norm(old - points[at]) < 14:  # line up: a crossroads
                        hit = (old, owner[at])
                hits.append(hit)
            # A free end stays clear of the collectors, so that houses fit around its bulb.
            distance = tree.query(part)[0]
            first, last = 0, len(part)
            if hits[0] is None:
                first = int(np.argmax(distance > 62))
            if hits[1] is None:
                last = len(part) - int(np.argmax(distance[::-1] > 62))
            if last - first < 20:
                continue
            part = part[first:last]
            # At a crossroads another district's row begins where this one ends.
            met = [0 if hit is None else 17 for hit in hits]
            if not net.clear(part[met[0] : len(part) - met[1]], 58, ignore=collectors):
                continue
            if hits[0] is not None:
                part = np.concatenate([hits[0][0][None], part])
            if hits[1] is not None:
                part = np.concatenate([part, hits[1][0][None]])
            street = net.add(part)
            rows[-1].append(street)
            for end, hit in enumerate(hits):
                if hit is None:
                    free[street, end] = net.lines[street][-end]
                else:
                    net.meet(hit[0], street, end, hit[1])

    spans = np.abs(np.diff(offsets))
    for j in range(len(rows) - 1):
        if kinds[j]:
            _cul_de_sacs(rng, net, rows[j], rows[j + 1], spans[j], lot_depth_m, street_m)
        else:
            _loops(rng, net, rows[j], rows[j + 1], spans[j], free)
            _cross_streets(rng, net, rows[j], rows[j + 1], spans[j], (140, 270))
    for (street, _end), point in free.items():
        net.bulbs.append((point, street))


def _loops(rng, net: StreetGraph, near, far, span, free) -> None:
    """Joins free ends of neighbouring rows by a bend, so that the two form a loop."""
    cut = 5  # points of each row that the bend takes
    for key in [k for k in free if k[0] in near]:
        gap = {k: np.linalg.norm(free[k] - free[key]) for k in free if k[0] in far}
        if not gap or rng.random() < 0.4:
            continue
        other = min(gap, key=gap.get)
        across = resampled(np.stack([free[key], free[other]]))
        ends = []
        for street, end in (key, other):
            line = net.lines[street] if end else net.lines[street][::-1]
            ends.append((line[-cut - 1], line[-1] - line[-cut - 1]))
        ahead = (across[-1] - across[0]) / max(gap[other], 1.0)
        sharp = [
            e[1] @ ahead * sign / np.linalg.norm(e[1])
            for e, sign in zip(ends, (1, -1), strict=True)
        ]
        if gap[other] > 1.4 * span or min(sharp) < -0.45 or len(across) < 14:
            continue
        if not net.clear(across[5:-5], 50, ignore=(key[0], other[0])):
            continue
        t = np.linspace(0, 1, 8)[:, None]
        bend = [
            (1 - t) ** 2 * start + 2 * t * (1 - t) * corner + t**2 * inside
            for start, corner, inside in (
                (ends[0][0], across[0], across[cut]),
                (ends[1][0], across[-1], across[-cut - 1]),
            )
        ]
        street = net.add(np.concatenate([bend[0], across[cut + 1 : -cut - 1], bend[1][::-1]]))
        for row, end in (key, other):
            net.lines[row] = net.lines[row][:-cut] if end else net.lines[row][cut:]
            net.links.append((street, row))
        del free[key], free[other]


def _cross_streets(rng, net: StreetGraph, near, far, span, spacing) -> None:
    """Ties two rows together every `spacing` (low, high) metres."""
    for a in near:
        for b in far:
            line, other = net.lines[a], net.lines[b]
            if not net.collector[b] and min(len(line), len(other)) < 20:
                continue
            d, target = spatial.cKDTree(other).query(line)
            s = rng.uniform(40, 130)
            while s < len(line) * STEP_M - 40:
                i = int(s / STEP_M)
                slip = target[i] + int(rng.integers(-4, 5))
                ends = min(slip, len(other) - 1 - slip)
                if d[i] < 1.25 * span and ends > 10:
                    street = resampled(np.stack([line[i], other[slip]]))
                    if join_street(net, a, street, b):
                        s += rng.uniform(*spacing)
                        continue
                s += 12


def _cul_de_sacs(rng, net: StreetGraph, near, far, span, lot_depth_m, street_m) -> None:
    """Fills a wide gap between two rows with closes from either side and few through streets."""
    reach = span - street_m / 2 - lot_depth_m - 14
    for a, b in [(a, b) for a in near for b in far]:
        line, other = net.lines[a], net.lines[b]
        to_far, at_far = spatial.cKDTree(other).query(line)
        through = rng.uniform(0, 250)
        s = rng.uniform(44, 80)
        while s < len(line) * STEP_M - 40:
            i = int(s / STEP_M)
            if to_far[i] > 1.15 * span:
                s += 10
                continue
            start, end, home = line[i], other[at_far[i]], a
            inner = 10 < at_far[i] < len(other) - 10
            if s > through and inner:
                made = join_street(net, a, resampled(np.stack([start, end])), b)
                through = s + rng.uniform(220, 420) if made else through
            else:
                if rng.random() < 0.4 and inner:
                    start, end, home = end, start, b
                # A close bends a little on its way in.
                ahead = (end - start) / np.linalg.norm(end - start)
                aside = np.array([-ahead[1], ahead[0]]) * rng.uniform(-16, 16)
                t = np.linspace(0, 1, 24)[:, None]
                made = join_street(
                    net, home, resampled(start + t * reach * ahead + t**2 * aside), None
                )
            s += rng.uniform(80, 92) if made else 10
