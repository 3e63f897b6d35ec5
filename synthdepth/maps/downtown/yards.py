"""What lies behind and between buildings: yards, gaps, alleys; and car parks."""

import itertools

import numpy as np
import shapely

from synthdepth.maps.bars import beams
from synthdepth.maps.downtown.fill import DECAL_M, GROUND_M, Fill, frame_of
from synthdepth.maps.downtown.parcels import Lot, polygons
from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.geometry import Geometry, box, copies, join, merge, place, quads
from synthdepth.maps.placement import distance_to, points_along, points_within
from synthdepth.maps.vegetation.shrubs import hedge

BAY_M, AISLE_M = (2.5, 5.0), 6.2
_GROUNDS = (
    ("asphalt", 0.34), ("concrete", 0.3), ("paving", 0.2), ("gravel", 0.1), ("grass", 0.06),
)  # fmt: skip
_TREES = ("maple", "birch", "young", "fruit", "bare", "poplar")


def _surface(rng) -> tuple[str, str]:
    names, share = zip(*_GROUNDS, strict=True)
    name = str(rng.choice(names, p=share))
    return name, "ground" if name in ("grass", "gravel") else "pavement"


def fill_yards(
    rng: np.random.Generator, fill: Fill, area: shapely.Polygon, lots: tuple[Lot, ...]
) -> None:
    """The open land of a block of buildings.

    Args:
        rng: lane of the blocks.
        fill: where to.
        area: land of the block.
        lots: what it is cut into.
    """
    layers = [(area, ("paving", "pavement"), rng.uniform(0.85, 1.1))]
    walls = [shapely.Polygon(lot.footprint) for lot in lots if lot.built]
    built = shapely.union_all(walls).buffer(0.05, join_style="mitre")
    seen = fill.near(area)
    for lot in lots:
        tint = rng.uniform(0.75, 1.15) * np.array([1.02, 1.0, 0.97])
        open_land = lot.parcel.difference(built)
        if open_land.area > 12:
            layers.append((open_land, _surface(rng), tint))
    if seen:
        layers += _repairs(rng, area.difference(built))
    fill.ground(layers)
    for yard in (lot.parcel for lot in lots if not lot.built):
        if yard.area > 260 and rng.random() < 0.3:
            _bays(rng, fill, yard.buffer(-0.8).difference(built.buffer(0.6)), 0.55)
        elif yard.area > 90:
            free = yard.buffer(-2.0).difference(built.buffer(2.4))
            at = points_within(rng, free, int(yard.area / 60), 4.5)
            fill.add("tree", str(rng.choice(_TREES)), at)
    if seen:
        _clutter(rng, fill, area, built)
        _partitions(rng, fill, area, lots, built)


def _repairs(rng, area: shapely.Geometry) -> list:
    """Patches of newer and older surfacing."""
    layers = []
    for at in points_within(rng, area, int(area.area / 90), 5.0):
        frame = frame_of(shapely.Point(at).buffer(1.0, quad_segs=1))
        patch = frame.rectangle((0, 0), rng.uniform([0.8, 0.7], [5.0, 2.4])).intersection(area)
        name = ("asphalt", "concrete")[int(rng.integers(2))]
        layers.append((patch, (name, "pavement"), rng.uniform(0.65, 1.25)))
    return layers


def _clutter(rng, fill: Fill, area: shapely.Polygon, built: shapely.Geometry) -> None:
    """Skips, bins, sheds, machines, pallets, people's things and weeds on open land."""
    land = polygons(area.buffer(-1.6).difference(built.buffer(1.3)), 4.0)
    if not land:
        return
    free = shapely.union_all(land)
    at = points_within(rng, free, int(free.area / 28), 3.4)
    yaw = (
        frame_of(area).yaw_rad
        + np.pi / 2 * rng.integers(0, 4, len(at))
        + rng.normal(0, 0.06, len(at))
    )
    kinds = ("skip", "bins", "shed", "machine", "pallets", "planter", "tree", "bicycle_rack",
             "bush", "barrier_jersey", "electric_box", "picnic_table", "person",
             "traffic_cone")  # fmt: skip
    weight = np.array([7, 12, 5, 10, 10, 6, 11, 4, 12, 4, 4, 3, 6, 6.0])
    which = rng.choice(len(kinds), len(at), p=weight / weight.sum())
    for k, name in enumerate(kinds):
        mine, turn = at[which == k], yaw[which == k]
        if name in ("bins", "shed"):
            fill.add("item", name, mine, turn)
        elif name == "tree":
            fill.add("tree", str(rng.choice(_TREES)), mine)
        elif name == "bush":
            fill.add("bush", "any", mine)
        elif name == "person":
            fill.add("person", "any", mine, turn)
        elif name in ("machine", "pallets"):
            build = _machine if name == "machine" else _pallets
            fill.models += [
                place(build(rng), (*p, GROUND_M), t) for p, t in zip(mine, turn, strict=True)
            ]
        else:
            fill.add("furniture", name, mine, turn)
    weeds = points_along(built.buffer(0.12).boundary, 1.6, rng)
    weeds = weeds[shapely.contains_xy(area.buffer(-2), *weeds.T)]
    fill.add("tuft", "any", weeds)
    drains = points_within(rng, free, int(area.area / 260), 8.0)
    if len(drains):
        grate = box((0.45, 0.45, DECAL_M + 0.004), (0, 0, 0), (0.25, 0.25, 0.26))
        at = np.column_stack([drains, np.full(len(drains), GROUND_M)])
        fill.models.append({("metal", "pavement"): copies(grate, at)})


def _machine(rng) -> dict[tuple[str, str], Geometry]:
    """A chiller or a transformer on a plinth, with a duct."""
    x, y, z = rng.uniform([1.0, 0.8, 0.9], [2.4, 1.4, 1.9])
    shade = rng.uniform(0.25, 0.55) * np.array([1, 1, 0.97])
    slats = np.linspace(0.25, z - 0.15, 7)
    front = np.stack([[[x / 2 + 0.012, -0.4 * y, h], [x / 2 + 0.012, 0.4 * y, h],
                       [x / 2 + 0.012, 0.4 * y, h + 0.07], [x / 2 + 0.012, -0.4 * y, h + 0.07]]
                      for h in slats])  # fmt: skip
    case = box((x, y, z), (0, 0, 0.1), shade)
    fan = box((0.6, 0.6, 0.08), (0, 0, z + 0.1), (0.05, 0.05, 0.05))
    return {
        ("concrete", "obstacle"): box((x + 0.3, y + 0.3, 0.2), (0, 0, -0.08)),
        ("paint", "obstacle"): join([case, fan, quads(front, shade * 0.35)]),
    }


def _pallets(rng) -> dict[tuple[str, str], Geometry]:
    """A stack of pallets, or one with crates on it."""
    count, wood = int(rng.integers(2, 8)), rng.uniform(0.2, 0.34) * np.array([1, 0.8, 0.58])
    parts = []
    for k in range(count):
        shift = rng.normal(0, 0.02, 2)
        y = np.linspace(-0.52, 0.52, 3)
        foot = np.column_stack(
            [np.full(3, -0.4) + shift[0], y + shift[1], np.full(3, 0.145 * k + 0.04)]
        )
        parts.append(beams(foot, foot + [0.8, 0, 0], 0.1, 0.1, wood * 0.85))
        x = np.linspace(-0.36, 0.36, 6)
        a = np.column_stack(
            [x + shift[0], np.full(6, -0.6) + shift[1], np.full(6, 0.145 * k + 0.105)]
        )
        parts.append(beams(a, a + [0, 1.2, 0], 0.1, 0.028, wood * rng.uniform(0.85, 1.1)))
    model = {("wood", "obstacle"): join(parts)}
    if rng.random() < 0.5:
        load = box((0.75, 1.1, rng.uniform(0.4, 1.1)), (0, 0, 0.145 * count - 0.02))
        shade = rng.uniform(0.1, 0.5) * np.array([1, 0.9, 0.75])
        model[("fabric", "obstacle")] = load.tinted(shade)
    return model


def _partitions(rng, fill: Fill, area, lots, built) -> None:
    """Fences and walls between the yards of neighbours."""
    edges = shapely.union_all([lot.parcel.exterior for lot in lots])
    lines = edges.intersection(area.buffer(-1.5)).difference(built.buffer(0.5))
    lines = shapely.line_merge(lines) if lines.geom_type != "LineString" else lines
    for line in shapely.get_parts(lines):
        if line.geom_type != "LineString" or not 2.5 < line.length < 60 or rng.random() < 0.45:
            continue
        xy = shapely.get_coordinates(shapely.simplify(line, 0.1))
        path = np.column_stack([xy, np.full(len(xy), GROUND_M)])
        kind = str(rng.choice(["chain_link", "wall", "board"], p=[0.45, 0.4, 0.15]))
        height = rng.uniform(1.6, 2.6) if kind != "board" else None
        near = distance_to(fill.bounds, xy).min() < 2
        fill.models.append(fence(rng, path, kind, height, detail=int(near)))


def fill_car_park(rng: np.random.Generator, fill: Fill, area: shapely.Polygon) -> None:
    """A car park on asphalt, with a hedge or a fence round it."""
    tint = rng.uniform(0.85, 1.25)
    layers = [(area, ("asphalt", "road"), tint), *_repairs(rng, area)]
    fill.ground(layers)
    _bays(rng, fill, area.buffer(-1.6), rng.uniform(0.3, 0.65))
    inside = area.buffer(-0.8)
    corners = shapely.get_coordinates(shapely.simplify(inside.exterior, 1.0))
    style = str(rng.choice(["hedge", "chain_link", "wall"]))
    for k, (a, b) in enumerate(itertools.pairwise(corners)):
        length = np.hypot(*(b - a))
        if length < 8:
            continue
        # The way in is through the middle of the first side.
        stretches = [(0.0, 1.0)] if k else [(0.0, 0.5 - 3.5 / length), (0.5 + 3.5 / length, 1.0)]
        for s, t in stretches:
            xy = np.array([a + s * (b - a), a + t * (b - a)])
            if (t - s) * length < 2 or not fill.near(area, 120.0):
                continue
            path = np.column_stack([xy, np.full(2, GROUND_M)])
            away = float(fill.distance_m(xy).min())
            if style == "hedge":
                fill.models.append(hedge(rng, path, rng.uniform(0.8, 1.2), 0.6, max(away, 9.0)))
            else:
                fill.models.append(fence(rng, path, style, detail=int(away < 40)))
    fill.add("furniture", "parking_meter", (corners[0] + corners[1]) / 2 + 0.5, rng.uniform(0, 6))
    edge = area.buffer(-1.0).difference(area.buffer(-2.0))
    fill.add("lamp", "cobra", points_within(rng, edge, 5, 14.0), rng.uniform(0, 6))


def _bays(rng, fill: Fill, area: shapely.Geometry, share: float) -> None:
    """Rows of painted bays with aisles between them, and the cars that stand there."""
    for part in polygons(area, 60.0):
        frame = frame_of(part)
        depth, wide = BAY_M[1], BAY_M[0]
        rows, y, face = [], -frame.width_m / 2 + depth / 2 + 0.2, 1
        while y < frame.width_m / 2 - depth / 2:
            rows.append((y, face))
            y += depth + AISLE_M if face > 0 else depth + 0.3
            face = -face
        x = np.arange(-frame.length_m / 2 + wide, frame.length_m / 2 - wide / 2, wide)
        lines, people_at = [], []
        for y, face in rows:
            bays = np.array([frame.rectangle((at, y), (wide, depth)) for at in x], object)
            inside = shapely.contains(part, bays) if len(bays) else np.zeros(0, bool)
            marks = np.unique(np.concatenate([x[inside] - wide / 2, x[inside] + wide / 2]).round(3))
            lines += [(at, y) for at in marks]
            taken = inside & (rng.random(len(x)) < share)
            n = int(taken.sum())
            at = np.column_stack([x[taken] + rng.normal(0, 0.09, n), y + rng.normal(0, 0.15, n)])
            heading = np.where(rng.random(n) < 0.65, -face, face) * np.pi / 2
            fill.add("car", "any", frame.out(at), frame.yaw_rad + heading + rng.normal(0, 0.02, n))
            people_at += [
                (a + wide / 2, y + face * 3.6) for a in x[inside & (rng.random(len(x)) < 0.05)]
            ]
        if lines:
            fill.models.append(_paint(frame, np.array(lines), depth))
        if people_at:
            fill.add("person", "walking", frame.out(people_at), rng.uniform(0, 6, len(people_at)))


def _paint(frame, at: np.ndarray, depth: float) -> dict[tuple[str, str], Geometry]:
    """White lines between bays, each about (n, 2) of the frame."""
    corner = np.array([[-0.05, -0.5], [0.05, -0.5], [0.05, 0.5], [-0.05, 0.5]]) * [1, depth]
    xy = frame.out((at[:, None] + corner).reshape(-1, 2))
    xyz = np.column_stack([xy, np.full(len(xy), GROUND_M + DECAL_M)]).reshape(-1, 4, 3)
    return merge([{("road_paint", "road"): quads(xyz, (0.5, 0.5, 0.47))}])
