"""Construction sites: a concrete frame, a crane, a hoarding, and what lies about."""

import itertools

import numpy as np
import shapely

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.downtown.fill import GROUND_M, Fill, frame_of
from synthdepth.maps.downtown.parcels import corners, pulled_in, thickness_m
from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.furniture.structures import tower_crane
from synthdepth.maps.geometry import Geometry, Model, box, geometry, join, place
from synthdepth.maps.placement import points_within
from synthdepth.maps.towers.construction import construction_tower

_CABINS = np.array([[0.5, 0.5, 0.48], [0.06, 0.13, 0.28], [0.3, 0.07, 0.04], [0.32, 0.3, 0.22]])
_HOARDINGS = np.array([[0.5, 0.5, 0.48], [0.08, 0.15, 0.3], [0.12, 0.22, 0.12], [0.33, 0.27, 0.18]])


def fill_site(
    rng: np.random.Generator, fill: Fill, area: shapely.Polygon, storeys: int
) -> np.ndarray:
    """A construction site on an area; returns the outline (n, 2) of the frame, if there is one.

    Args:
        rng: lane of the blocks.
        fill: where to.
        area: its land.
        storeys: of the frame.
    """
    frame = frame_of(area)
    layers = [(area, ("soil", "ground"), rng.uniform(0.9, 1.2))]
    for at in points_within(rng, area.buffer(-2), int(area.area / 70), 6.0):
        patch = shapely.Point(at).buffer(rng.uniform(2, 5.5), quad_segs=3).intersection(area)
        name = ("gravel", "concrete", "soil", "sand")[int(rng.integers(4))]
        layers.append((patch, (name, "ground"), rng.uniform(0.8, 1.15)))
    fill.ground(layers)
    outline = _frame_outline(rng, area)
    taken = shapely.Polygon()
    if len(outline):
        model = construction_tower(rng, outline, storeys)
        fill.models.append(place(model, (0, 0, GROUND_M)))
        taken = shapely.Polygon(outline).buffer(2.2)
    free = area.buffer(-2.4).difference(taken)
    spots = points_within(rng, free.buffer(-1.2), 12)
    if len(spots):
        best = spots[np.argmin([shapely.Point(p).distance(taken) for p in spots])]
        high = max(3.6 * storeys + rng.uniform(12, 22), 30.0)
        crane = tower_crane(rng, height_m=high, jib_m=rng.uniform(35, 55))
        fill.models.append(place(crane, (*best, GROUND_M), rng.uniform(0, 2 * np.pi)))
        free = free.difference(shapely.Point(best).buffer(3.6))
    _hoarding(rng, fill, area)
    if fill.near(area, 100.0):
        _things(rng, fill, free, frame.yaw_rad)
    return outline


def _frame_outline(rng, area: shapely.Polygon) -> np.ndarray:
    """(n, 2) of the frame: what is left of the area inside its hoarding; empty for none."""
    points = corners(area)
    if area.area < 0.85 * area.convex_hull.area:
        return np.zeros((0, 2))
    by = rng.uniform(3.2, 5.0, len(points))
    longest = np.hypot(*(np.roll(points, -1, axis=0) - points).T).argmax()
    by[(longest + 1) % len(points)] += rng.uniform(0.15, 0.3) * np.sqrt(area.area)
    outline = pulled_in(points, by)
    return outline if len(outline) >= 3 and thickness_m(outline) > 11 else np.zeros((0, 2))


def _hoarding(rng, fill: Fill, area: shapely.Polygon) -> None:
    """Sheets on posts all round, in places mesh panels, with a gate."""
    ring = shapely.get_coordinates(
        shapely.orient_polygons(area.buffer(-0.7, join_style="mitre")).exterior
    )
    tint = _HOARDINGS[int(rng.integers(len(_HOARDINGS)))]
    sheets, posts = [], []
    for k, (a, b) in enumerate(itertools.pairwise(ring)):
        length = float(np.hypot(*(b - a)))
        if length < 2.5:
            continue
        at = np.arange(0, length - 0.5, 2.44)
        if k == 0:
            at = at[np.abs(at - length / 2) > 4.0]
        u = (b - a) / length
        mesh = rng.random() < 0.3
        if mesh:
            cut = a + (length / 2 - 4.0 if k == 0 else length) * u
            path = np.array([[*a, GROUND_M], [*cut, GROUND_M]])
            near = fill.distance_m(a).min() < 60
            fill.models.append(fence(rng, path, "chain_link", 2.0, detail=int(near)))
            continue
        span = np.minimum(2.4, length - at)
        foot = a + at[:, None] * u
        end = foot + span[:, None] * u
        z = np.full((len(at), 1), GROUND_M + 1.12)
        shade = tint * rng.uniform(0.85, 1.1, (len(at), 1))
        sheets.append(beams(np.hstack([foot, z]), np.hstack([end, z]), 0.03, 2.2, shade))
        low = np.hstack([foot, z * 0 + GROUND_M - 0.1]) + [*(0.08 * np.array([-u[1], u[0]])), 0]
        posts.append(round_bars(low, low + [0, 0, 2.5], 0.04, (0.3, 0.3, 0.3), 5))
    if sheets:
        fill.models.append({("paint", "barrier"): join([*sheets, *posts])})


def _heap(rng, radius: float, height: float) -> Geometry:
    """A heap of loose material at its angle of repose, lumpy."""
    rings, sides = 5, 14
    turn = np.arange(sides) * 2 * np.pi / sides
    lump = 1 + 0.16 * np.sin(2 * turn + rng.uniform(0, 6)) + 0.08 * rng.normal(size=sides)
    share = np.linspace(1, 0.14, rings)
    r = radius * share[:, None] * lump
    z = height * (1 - share[:, None] ** 1.15) * rng.uniform(0.93, 1.05, (rings, sides)) - 0.06
    v = np.stack([r * np.cos(turn), r * np.sin(turn), z], -1).reshape(-1, 3)
    v = np.concatenate([v, [[0, 0, height * 0.95]]])
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(sides), indexing="ij")
    a, b = (i * sides + j).ravel(), (i * sides + (j + 1) % sides).ravel()
    top = (rings - 1) * sides
    k = np.arange(sides)
    cap = np.stack([top + k, top + (k + 1) % sides, np.full(sides, len(v) - 1)], 1)
    faces = [np.stack([a, b, b + sides], 1), np.stack([a, b + sides, a + sides], 1), cap]
    return geometry(v, np.concatenate(faces))


def _cabin(rng) -> Model:
    """A 20-foot container or site office, now and then two on top of each other."""
    parts, panes = [], []
    for level in range(int(rng.integers(1, 3))):
        tint = _CABINS[int(rng.integers(len(_CABINS)))] * rng.uniform(0.85, 1.1)
        z = 2.6 * level
        parts.append(box((6.06, 2.4, 2.55), (0, 0, z - 0.02 * (level == 0)), tint))
        x = np.linspace(-2.9, 2.9, 30)
        for y in (-1.215, 1.215):
            a = np.column_stack([x, np.full(30, y), np.full(30, z + 0.15)])
            parts.append(beams(a, a + [0, 0, 2.25], 0.06, 0.03, tint * 0.93))
        if rng.random() < 0.6:
            for x0 in (-1.9, 0.9):
                panes.append(box((1.1, 0.1, 0.9), (x0, 1.2, z + 1.1), (0.35, 0.35, 0.36)))
    return {("paint", "obstacle"): join(parts + panes)}


def _pipes(rng) -> Model:
    """Concrete pipes, or bundles of bars on timbers."""
    if rng.random() < 0.5:
        count, radius = int(rng.integers(3, 6)), rng.uniform(0.25, 0.45)
        y = 2.02 * radius * np.arange(count)
        a = np.column_stack([np.full(count, -1.2), y, np.full(count, radius)])
        low = round_bars(a, a + [2.4, 0, 0], radius, (1, 1, 1), 12)
        b = a[:-1] + [0, radius * 1.01, radius * 1.73]
        return {
            ("concrete", "obstacle"): join([low, round_bars(b, b + [2.4, 0, 0], radius, sides=12)])
        }
    n = 36
    y, z = rng.uniform(-0.5, 0.5, n), rng.uniform(0.16, 0.42, n)
    start = np.column_stack([rng.uniform(-3.2, -2.6, n), y, z])
    end = np.column_stack([rng.uniform(2.6, 3.2, n), y + rng.normal(0, 0.04, n), z])
    timber = np.array([[-2, -0.8, 0.06], [0, -0.8, 0.06], [2, -0.8, 0.06]])
    return {
        ("paint", "obstacle"): round_bars(start, end, 0.014, (0.14, 0.075, 0.045), 4),
        ("wood", "obstacle"): beams(timber, timber + [0, 1.6, 0], 0.14, 0.14, (0.25, 0.18, 0.11)),
    }


def _timber(rng) -> Model:
    """A stack of formwork sheets and props."""
    count = int(rng.integers(5, 14))
    z = 0.12 + 0.05 * np.arange(count)
    a = np.column_stack([np.full(count, -1.25), rng.normal(0, 0.03, count), z])
    shade = rng.uniform(0.7, 1.1, (count, 1)) * [0.4, 0.3, 0.13]
    sleepers = np.array([[-0.8, -0.7, 0.045], [0.8, -0.7, 0.045]])
    return {
        ("wood", "obstacle"): join(
            [beams(a, a + [2.5, 0, 0], 1.25, 0.027, shade),
             beams(sleepers, sleepers + [0, 1.4, 0], 0.1, 0.12, (0.25, 0.18, 0.11))]
        )
    }  # fmt: skip


def _things(rng, fill: Fill, free: shapely.Geometry, yaw: float) -> None:
    """Cabins, heaps, pipes, timber, skips, people on the open part of a site."""
    for build, reach, count in (
        (_cabin, 3.4, 4),
        (None, 2.6, 4),
        (_pipes, 3.0, 4),
        (_timber, 1.7, 6),
    ):
        for at in points_within(rng, free.buffer(-reach + 0.6), count, 2 * reach):
            if build is None:
                radius = rng.uniform(1.5, 2.6)
                name = ("sand", "gravel", "soil")[int(rng.integers(3))]
                model = {(name, "obstacle"): _heap(rng, radius, 0.6 * radius)}
            else:
                model = build(rng)
            turn = (
                yaw + np.pi / 2 * (build is not _cabin) * rng.integers(0, 2) + rng.normal(0, 0.04)
            )
            fill.models.append(place(model, (*at, GROUND_M), turn))
            free = free.difference(shapely.Point(at).buffer(reach))
    for group, name, count in (
        ("furniture", "skip", 3), ("furniture", "barrier_jersey", 5),
        ("furniture", "traffic_cone", 7),
        ("furniture", "barrier_crowd", 5), ("person", "any", 8),
    ):  # fmt: skip
        at = points_within(rng, free.buffer(-0.6), count, 2.2)
        fill.add(group, name, at, rng.uniform(0, 2 * np.pi, len(at)))
        if len(at):
            free = free.difference(shapely.MultiPoint(at).buffer(1.3))
