"""City parks: lawn, curved paths, groups of trees, a pond, a playground."""

import numpy as np
import shapely

from synthdepth.maps.downtown.fill import GROUND_M, Fill, block, flat, frame_of
from synthdepth.maps.downtown.parcels import polygons
from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.placement import points_along, points_within
from synthdepth.maps.vegetation.shrubs import hedge

_LEAFY = ("oak", "maple", "birch", "willow", "poplar", "spruce", "pine", "fruit", "young", "bare")
_PATHS = (
    ("gravel", (1.1, 1.02, 0.9)), ("asphalt", (1.25, 1.2, 1.15)), ("paving", (1.0, 0.97, 0.9)),
)  # fmt: skip


def fill_park(rng: np.random.Generator, fill: Fill, area: shapely.Polygon) -> None:
    """A park on an area: its ground and all that stands on it."""
    frame = frame_of(area)
    middle = frame.out(rng.uniform(-0.12, 0.12, 2) * [frame.length_m, frame.width_m])[0]
    if not area.contains(shapely.Point(middle)):
        middle = shapely.get_coordinates(area.representative_point())[0]
    lines = _path_lines(rng, area, middle)
    half = rng.uniform(1.0, 1.7)
    circle = shapely.Point(middle).buffer(rng.uniform(4.5, 0.1 * frame.width_m + 5), quad_segs=8)
    paths = shapely.union_all([*shapely.buffer(lines, half, quad_segs=3), circle])
    paths = paths.intersection(area)
    surface, shade = _PATHS[int(rng.integers(len(_PATHS)))]
    green = rng.uniform(0.85, 1.15) * np.array([rng.uniform(0.92, 1.15), 1.0, 0.95])
    layers = [(area, ("grass", "ground"), green)]
    for at in points_within(rng, area.buffer(-5), int(area.area / 500), 12.0):
        worn = shapely.Point(at).buffer(rng.uniform(1.5, 5), quad_segs=4)
        layers.append((worn, ("grass", "ground"), green * rng.uniform(0.8, 1.25)))
    layers.append((paths, (surface, "pavement"), shade))
    taken = paths.buffer(0.9, quad_segs=2)
    pond = _pond(rng, area, paths)
    if pond is not None:
        taken = taken.union(pond.buffer(1.6))
        _add_pond(rng, fill, pond)
        layers = [(a.difference(pond), key, tint) for a, key, tint in layers]
    taken = _playground(rng, fill, area, taken, layers)
    fill.ground(layers)
    _planting(rng, fill, area, taken)
    _along_paths(rng, fill, lines, half, area)
    fill.add("furniture", "fountain" if rng.random() < 0.4 else "statue", middle, rng.uniform(0, 6))
    tufts = points_along(paths.buffer(0.06, quad_segs=2).boundary, 0.55, rng)
    fill.add("tuft", "any", tufts[shapely.contains_xy(area, *tufts.T)])
    _rim(rng, fill, area, paths)


def _path_lines(rng, area: shapely.Polygon, middle: np.ndarray) -> np.ndarray:
    """Curves from the corners and from some of the sides to the middle, and one all round."""
    ring = shapely.get_coordinates(shapely.simplify(area.exterior, 2.0))[:-1]
    sides = (ring + np.roll(ring, -1, axis=0)) / 2
    ends = np.concatenate([ring, sides[rng.random(len(sides)) < 0.5]])
    t = np.linspace(0, 1, 14)[:, None]
    lines = []
    for end in ends:
        bend = (end + middle) / 2 + rng.normal(0, 0.13, 2) * np.hypot(*(end - middle))
        lines.append(
            shapely.LineString((1 - t) ** 2 * end + 2 * t * (1 - t) * bend + t**2 * middle)
        )
    inner = polygons(area.buffer(-15).buffer(6, quad_segs=3))
    if area.area > 4500 and inner:
        lines.append(shapely.LineString(max(inner, key=shapely.area).exterior))
    return np.array(lines, object)


def _pond(rng, area: shapely.Polygon, paths: shapely.Geometry) -> shapely.Polygon | None:
    """A pond of rounded outline off the paths, in parks with room for one."""
    wanted = rng.random() < 0.7
    free = area.difference(paths.buffer(1.4, quad_segs=2)).buffer(-3.5)
    sites = points_within(rng, free, 12)
    turn = np.arange(40) * 2 * np.pi / 40
    phase = rng.uniform(0, 6, 2)
    wave = 1 + 0.14 * np.sin(2 * turn + phase[0]) + 0.08 * np.sin(3 * turn + phase[1])
    if not len(sites) or not wanted:
        return None
    room = shapely.distance(shapely.points(sites), free.boundary)
    best = int(np.argmax(room))
    if room[best] < 3.0:
        return None
    reach = min(room[best], 14.0) * 0.95 * wave
    pond = shapely.Polygon(
        sites[best] + np.column_stack([reach * np.cos(turn), reach * np.sin(turn)])
    )
    pond = pond.intersection(free.buffer(2.0))
    return pond if pond.geom_type == "Polygon" and pond.area > 15 else None


def _add_pond(rng, fill: Fill, pond: shapely.Polygon) -> None:
    """Water, its stone kerb, and bushes at the edge."""
    kerb = pond.difference(pond.buffer(-0.35))
    stone = np.full(3, rng.uniform(0.28, 0.42))
    fill.models.append(
        {
            ("glass", "water"): flat(pond, GROUND_M - 0.05, (0.8, 1.0, 0.9)),
            ("stone", "ground"): block(kerb, GROUND_M - 0.3, GROUND_M + 0.16, stone),
        }
    )
    rim = points_along(pond.buffer(0.9).exterior, 1.1, rng)
    fill.add("bush", "any", rim[rng.random(len(rim)) < 0.2])


def _playground(rng, fill: Fill, area, taken, layers: list) -> shapely.Geometry:
    """A soft floor with swings and a table; returns what is taken afterwards."""
    at = points_within(rng, area.difference(taken).buffer(-6.0), 1)
    if not len(at) or rng.random() < 0.3:
        return taken
    floor = shapely.Point(at[0]).buffer(6.0, quad_segs=5)
    surface = ("rubber_floor", "sand")[int(rng.integers(2))]
    layers.append((floor, (surface, "ground"), 1.0))
    turn = rng.uniform(0, 6) + 2.1 * np.arange(3)
    around = at[0] + 3.2 * np.column_stack([np.cos(turn), np.sin(turn)])
    fill.add("item", "swing", around[0], turn[0])
    fill.add("item", "goal", around[1], turn[1] + np.pi)
    fill.add("furniture", "picnic_table", around[2], turn[2])
    fill.add("furniture", "bench", at[0] + [5.2, 0.0], np.pi)
    fill.add("person", "any", at[0] + rng.uniform(-1.4, 1.4, (2, 2)), rng.uniform(0, 6, 2))
    return taken.union(floor.buffer(1.0))


def _planting(rng, fill: Fill, area, taken) -> None:
    """Trees in groups with glades between, bushes and flowers in beds, uneven grass."""
    lawn = area.buffer(-1.6).difference(taken)
    places = points_within(rng, lawn, int(area.area / 42), rng.uniform(5.0, 6.5))
    phase, wave = rng.uniform(0, 6, 4), rng.uniform(11, 19)
    x, y = places.T
    group = np.sin(x / wave + phase[0]) * np.sin(y / wave + phase[1])
    places = places[group + 0.3 * np.sin(x / 5 + phase[2]) > -0.25]
    kinds = rng.permutation(_LEAFY)[:5]
    which = rng.choice(5, len(places), p=[0.4, 0.25, 0.16, 0.11, 0.08])
    for k, name in enumerate(kinds):
        fill.add("tree", str(name), places[which == k])
    under = points_within(rng, lawn, int(area.area / 60), 1.2)
    dense = np.sin(under[:, 0] / 7 + phase[3]) * np.sin(under[:, 1] / 6 + phase[2]) > 0.45
    fill.add("bush", "any", under[dense])
    beds = points_within(rng, lawn, int(area.area / 20), 0.4)
    dense = np.sin(beds[:, 0] / 5 + phase[2]) * np.sin(beds[:, 1] / 7 + phase[3]) > 0.8
    fill.add("flower", "any", beds[dense])
    fill.add("tuft", "any", points_within(rng, lawn, int(area.area / 6), 0.2))


def _along_paths(rng, fill: Fill, lines: np.ndarray, half: float, area: shapely.Polygon) -> None:
    """Benches, bins and lamps beside the paths, and people on them."""
    inner = area.buffer(-2.0)
    paths = shapely.union_all(lines)
    for group, name, spacing, off, share in (
        ("furniture", "bench", 13.0, half + 0.7, 0.8),
        ("furniture", "litter_bin", 37.0, half + 0.6, 0.9),
        ("lamp", "lantern", 21.0, half + 0.5, 1.0),
        ("person", "any", 8.0, 0.0, 0.7),
    ):
        at, along = [], []
        for line in lines:
            s = np.arange(rng.uniform(0, spacing), line.length - 1, spacing)
            here, ahead = (
                shapely.get_coordinates(shapely.line_interpolate_point(line, d))
                for d in (s, s + 0.5)
            )
            at.append(here)
            along.append(ahead - here)
        at, along = np.concatenate(at), np.concatenate(along)
        yaw = np.arctan2(along[:, 1], along[:, 0]) + np.pi * rng.integers(0, 2, len(at))
        beside = at + off * np.column_stack([np.sin(yaw), -np.cos(yaw)])
        clear = shapely.distance(paths, shapely.points(beside)) > off - 0.15
        keep = clear & shapely.contains_xy(inner, *beside.T) & (rng.random(len(at)) < share)
        fill.add(group, name, beside[keep], yaw[keep] + (np.pi / 2 if off else 0.0))


def _rim(rng, fill: Fill, area: shapely.Polygon, paths: shapely.Geometry) -> None:
    """A hedge, railing or wall along the streets, open where paths come in."""
    style = rng.choice(["hedge", "post_and_rail", "wall", "chain_link"], p=[0.5, 0.2, 0.2, 0.1])
    if not fill.near(area, 120.0):
        return
    line = area.buffer(-0.6).exterior.difference(paths.buffer(0.7, quad_segs=2))
    line = shapely.line_merge(line) if line.geom_type == "MultiLineString" else line
    for part in shapely.get_parts(line):
        if part.length < 4:
            continue
        xy = shapely.get_coordinates(shapely.simplify(part, 0.3))
        path = np.column_stack([xy, np.full(len(xy), GROUND_M)])
        away = float(fill.distance_m(xy).min())
        if style == "hedge":
            fill.models.append(hedge(rng, path, rng.uniform(0.7, 1.3), 0.6, max(away, 9.0)))
        else:
            fill.models.append(fence(rng, path, str(style), detail=int(away < 40)))
