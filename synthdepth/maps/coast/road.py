"""Building the coast road: paint, far ribbon, rails, lamps, poles, signs, vehicles, boardwalk."""

import numpy as np

from synthdepth.maps.bars import beams
from synthdepth.maps.coast.guard_rail import guard_rail
from synthdepth.maps.coast.roadside import Roadside
from synthdepth.maps.coast.terrain import HALF_M, ROAD_WIDTH_M, Ground
from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.furniture.poles import catenary, utility_line, wires
from synthdepth.maps.furniture.signs import signs, street_lamps
from synthdepth.maps.geometry import Geometry, Model, cross, geometry, join, merge, quads
from synthdepth.maps.placement import distance_to, draped_line, on_ground
from synthdepth.maps.vehicles.vehicle import park

_PAINT_LIFT_M = 0.018
_DRIVE_LIFT_M = 0.05


def _heading(line: np.ndarray) -> np.ndarray:
    along = np.gradient(line, axis=0)
    return along / np.linalg.norm(along, axis=1, keepdims=True)


def _ribbon(ground: Ground, line: np.ndarray, low: float, high: float, lift_m: float) -> np.ndarray:
    """(n - 1, 4, 3) quads of a strip between two offsets from a line (n, 2) along the road."""
    ahead = _heading(line)
    left = np.stack([-ahead[:, 1], ahead[:, 0]], 1)
    sides = [on_ground(ground, line + offset * left) + [0, 0, lift_m] for offset in (low, high)]
    right, over = sides
    return np.stack([right[:-1], right[1:], over[1:], over[:-1]], 1)


def _along_road(ground: Ground, s: np.ndarray) -> np.ndarray:
    """(n, 2) world places of the road's middle."""
    t = np.interp(
        s, np.arange(len(ground.road_t_m)) - (len(ground.road_t_m) - 1) / 2, ground.road_t_m
    )
    return ground.shore.to_world(s, t)


def markings(rng: np.random.Generator, ground: Ground) -> Model:
    """Edge lines and a dashed or double centre line on the near road."""
    # The paint breaks where the road's mesh does, so that it lies on it everywhere.
    line = _along_road(ground, ground.s)
    edge = ROAD_WIDTH_M / 2 - 0.22
    strips = [
        _ribbon(ground, line, side * edge - 0.06, side * edge + 0.06, _PAINT_LIFT_M)
        for side in (-1, 1)
    ]
    white = np.array([0.58, 0.58, 0.55])
    centre = white if rng.random() < 0.5 else np.array([0.52, 0.36, 0.07])
    parts = [quads(np.concatenate(strips), white * 0.95)]
    middle = _ribbon(ground, line, -0.07, 0.07, _PAINT_LIFT_M)
    cells = np.arange(len(middle))
    solid = np.sin(ground.s[:-1] / 90 + rng.uniform(0, 6)) > 0.6
    parts.append(quads(middle[(cells % 9 < 3) | solid], centre))
    wear = rng.uniform(0.75, 1.05, sum(len(p.vertices) for p in parts) // 4)
    paint = join(parts)
    return {("road_paint", "road"): paint.tinted(np.repeat(wear, 4)[:, None])}


def far_road(ground: Ground) -> Model:
    """The road beyond the near mesh, on a low bank."""
    parts = []
    for side in (-1, 1):
        s = side * np.arange(HALF_M - 1.0, 980.0, 7.0)
        s = s if side > 0 else s[::-1]
        xy = _along_road(ground, s)
        dry = ground.behind_m(xy) > 4
        xy = xy[np.cumprod(dry if side > 0 else dry[::-1]).astype(bool)[::side]]
        if len(xy) < 3:
            continue
        half = ROAD_WIDTH_M / 2
        top = _ribbon(ground, xy, -half, half, 0.45)
        top[..., 2] = np.maximum(top[..., 2], top[:, [1, 0, 3, 2], 2] - 0.1)
        down = [0, 0, 1.6]
        right, left = top[:, [0, 1]], top[:, [3, 2]]
        walls = [
            np.stack([right[:, 0] - down, right[:, 1] - down, right[:, 1], right[:, 0]], 1),
            np.stack([left[:, 1] - down, left[:, 0] - down, left[:, 0], left[:, 1]], 1),
        ]
        parts.append((quads(top), quads(np.concatenate(walls))))
    return {
        ("asphalt", "road"): join([p[0] for p in parts]),
        ("gravel", "ground"): join([p[1] for p in parts]),
    }


def drives(roadside: Roadside, ground: Ground) -> Model:
    """Paved strips of the lots (rectangles), laid on the ground in pieces of about a metre."""
    parts: list[Geometry] = []
    for lot in roadside.lots:
        for ring in lot.paved:
            a, b, c, d = ring[:4]
            n = max(int(np.linalg.norm(b - a) / 1.1), 1) + 1
            m = max(int(np.linalg.norm(d - a) / 1.1), 1) + 1
            u, v = np.linspace(0, 1, n)[:, None, None], np.linspace(0, 1, m)[None, :, None]
            xy = (1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d
            p = on_ground(ground, xy.reshape(-1, 2)) + [0, 0, _DRIVE_LIFT_M]
            i = np.arange(n * m).reshape(n, m)
            quad = np.stack([i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]], -1).reshape(-1, 4)
            faces = np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])
            corner = p[faces]
            turned = cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])[:, 2] < 0
            faces[turned] = faces[turned][:, ::-1]
            parts.append(geometry(p, faces))
    return {("paving", "pavement"): join(parts)} if parts else {}


def boardwalk(rng: np.random.Generator, line: np.ndarray, ground: Ground) -> Model:
    """Planks on stringers with posts and ropes along a line (2, 2) to the beach."""
    start, end = line
    length = np.linalg.norm(end - start)
    along = (end - start) / length
    left = np.array([-along[1], along[0]])
    run = np.arange(0.3, length - 0.3, 0.17)
    foot = ground.height_m(start + run[:, None] * along)
    # Never steeper than people like: the deck follows the highest ground about.
    wide = 41
    padded = np.pad(foot, wide // 2, mode="edge")
    window = np.lib.stride_tricks.sliding_window_view(padded, wide)
    deck = window.max(axis=1)
    deck = np.convolve(np.pad(deck, wide // 2, mode="edge"), np.ones(wide) / wide, mode="valid")
    deck = np.maximum(deck, foot) + 0.22
    deck[-40:] = np.linspace(deck[-40], foot[-1] + 0.06, 40) if len(deck) > 60 else deck[-40:]
    middle = np.column_stack([start + run[:, None] * along, deck])
    across = np.append(left, 0.0)
    grey = np.array([0.27, 0.235, 0.19])
    tint = grey * rng.uniform(0.75, 1.2, (len(run), 1))
    planks = beams(middle - 0.75 * across, middle + 0.75 * across, 0.14, 0.04, tint)
    step = slice(None, None, 12)
    posts, ropes = [], []
    for side in (-1, 1):
        base = middle[step] + side * 0.8 * across
        low = base.copy()
        low[:, 2] = ground.height_m(base[:, :2]) - 0.3
        top = base + [0, 0, 1.0]
        posts.append(beams(low, top, 0.1, 0.1, grey * rng.uniform(0.7, 1.0, (len(base), 1))))
        for below in (0.08, 0.5):
            spans = catenary(top[:-1] - [0, 0, below], top[1:] - [0, 0, below], 0.03, segments=4)
            ropes.append(wires(spans, 0.014, (0.33, 0.28, 0.19)))
        edge = middle[step] + side * 0.6 * across - [0, 0, 0.1]
        posts.append(beams(edge[:-1], edge[1:], 0.06, 0.14, grey * 0.7))
    return {
        ("wood", "pavement"): planks,
        ("wood", "barrier"): join(posts),
        ("fabric", "barrier"): join(ropes),
    }


def build_roadside(
    rng: np.random.Generator, roadside: Roadside, ground: Ground, bounds: np.ndarray
) -> list[Model]:
    """Everything of the roadside but its homes."""
    lanes = rng.spawn(8)
    models: list[Model] = [
        markings(lanes[0], ground),
        far_road(ground),
        drives(roadside, ground),
    ]
    cars = np.concatenate([roadside.parked, roadside.driving, *[lot.cars for lot in roadside.lots]])
    models.append(
        park(lanes[1], on_ground(ground, cars[:, :2]), cars[:, 2], distance_to(bounds, cars))
    )
    models.append(
        street_lamps(lanes[2], on_ground(ground, roadside.lamps[:, :2]), roadside.lamps[:, 2])
    )
    eaves = [lot.eaves(ground) for lot in roadside.lots]
    eaves = np.array([point for point in eaves if point is not None]).reshape(-1, 3)
    for index, line in enumerate(roadside.poles):
        # Only the line along the road serves the houses.
        gap = np.linalg.norm(eaves[:, None, :2] - line[None], axis=2).min(axis=1, initial=1e9)
        served = eaves[gap < 38] if index == 0 else None
        models.append(utility_line(lanes[3], on_ground(ground, line), served))
    for name, x, y, heading in roadside.signs:
        at = on_ground(ground, np.array([[x, y]]))
        models.append(signs(lanes[4], at, [heading], name))
    for line in roadside.rails:
        models.append(guard_rail(lanes[5], on_ground(ground, line)))
    for line, kind in roadside.fences:
        detail = 1 if distance_to(bounds, line).min() < 2 else 0
        draped = draped_line(ground, line, 3.0)
        high = 0.9 if kind == "wall" else 1.15
        models.append(fence(lanes[6], draped, kind, high, detail=detail))
    if roadside.boardwalk is not None:
        models.append(boardwalk(lanes[7], roadside.boardwalk, ground))
    return [merge(models)]
