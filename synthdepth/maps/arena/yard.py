"""Piles and rows: coloured blocks, crates, shipping containers, stacks of them."""

import numpy as np

from synthdepth.maps.arena.rails import railing
from synthdepth.maps.arena.solids import cuboids
from synthdepth.maps.arena.zone import OBSTACLE, Zone, at_ground, square_yaws
from synthdepth.maps.bars import beams
from synthdepth.maps.geometry import Geometry, Model, copies, join, merge, place, yaw_matrix

# Coats of blocks and how often each is met.
_COATS = {"painted_block": 5, "brick": 1, "plywood": 1.5, "cladding": 1.5, "plaster": 1}
CONTAINER_M = (2.44, 2.59)  # width and height of ISO 668 boxes
_WOOD = np.array([0.32, 0.23, 0.135])


def coated(rng: np.random.Generator, part_of, count: int) -> dict[tuple[str, str], Geometry]:
    """`part_of(chosen)` for each coat, `chosen` (count,) bool being the things that wear it."""
    weights = np.array(list(_COATS.values()), float)
    worn = rng.choice(len(_COATS), count, p=weights / weights.sum())
    return {
        (name, OBSTACLE): part_of(worn == i) for i, name in enumerate(_COATS) if (worn == i).any()
    }


def block_rows(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Rows of painted blocks, low ones by tall ones; some carry a smaller block or a rail."""
    xy = zone.spots(rng, 1.9 * zone.object_m + 3.0, shake=0.35, share=0.85)
    n = len(xy)
    side = zone.object_m * rng.uniform(0.35, 1.15, (n, 2))
    tall = rng.random(n) < 0.25
    high = np.where(
        tall, zone.height_m * rng.uniform(0.4, 1.0, n), zone.object_m * rng.uniform(0.25, 1.0, n)
    )
    yaw = square_yaws(rng, n, 0.12)
    size = np.column_stack([side, high])
    tint = zone.palette.tints(rng, n)
    low = coated(rng, lambda c: cuboids(at_ground(xy[c]), size[c], yaw[c], tint[c]), n)
    on_top = rng.random(n) < 0.45
    k = int(on_top.sum())
    upper = np.column_stack([side[on_top] * rng.uniform(0.3, 0.8, (k, 2)), rng.uniform(0.5, 4, k)])
    top_tint = zone.palette.tints(rng, k)
    base = at_ground(xy[on_top], high[on_top])
    models = [
        low,
        coated(rng, lambda c: cuboids(base[c], upper[c], yaw[on_top][c], top_tint[c]), k),
    ]
    if zone.near:
        models.append(_skirts(rng, xy, size, yaw))
        rails = np.flatnonzero(~on_top & (high < 9) & (rng.random(n) < 0.2 + 0.6 * zone.thin))
        models += [_roof_rail(xy[i], size[i], yaw[i], zone.palette.tint(rng)) for i in rails]
    return models


def _skirts(rng: np.random.Generator, xy, size, yaw) -> Model:
    """Striped bands round the feet of some blocks, a centimetre proud."""
    chosen = rng.random(len(xy)) < 0.22
    k = int(chosen.sum())
    band = np.column_stack([size[chosen, :2] + 0.02, np.full(k, 0.55)])
    return {("hazard", OBSTACLE): cuboids(at_ground(xy[chosen]), band, yaw[chosen])}


def _roof_rail(xy, size, yaw: float, tint) -> Model:
    x, y = np.maximum(np.asarray(size)[:2] / 2 - 0.12, 0.1)
    path = np.array([[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0], [-x, -y, 0]]) + [
        0, 0, size[2] - 0.01,
    ]  # fmt: skip
    return place({("paint", "barrier"): railing(path, tint)}, [*xy, 0.0], yaw)


def crate_piles(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Pyramids and towers of battened crates, a metre and more on a side, and stacked pallets."""
    xy = zone.spots(rng, 9.0, shake=0.5, share=0.8)
    bases, sides, yaws = [], [], []
    for spot in xy:
        side = rng.uniform(0.9, 1.7)
        across, levels = rng.integers(1, 5, 2), int(rng.integers(1, 6))
        turn = rng.uniform(0, np.pi)
        for level in range(levels):
            across = np.maximum(across - rng.integers(0, 2, 2), 1)
            steps = [(np.arange(m) - (m - 1) / 2) * (side + 0.06) for m in across]
            local = np.stack(np.meshgrid(*steps), -1).reshape(-1, 2)
            c, s = np.cos(turn), np.sin(turn)
            bases.append(at_ground(local @ np.array([[c, s], [-s, c]]) + spot, level * side))
            sides.append(np.full(len(local), side))
            yaws.append(turn + rng.normal(0, 0.05, len(local)))
    base, side, yaw = np.concatenate(bases), np.concatenate(sides), np.concatenate(yaws)
    shade = _WOOD * rng.uniform(0.6, 1.35, (len(base), 1))
    painted = rng.random(len(base)) < 0.3
    shade = np.where(painted[:, None], zone.palette.tints(rng, len(base)), shade)
    if not zone.near:
        return [{("plywood", OBSTACLE): cuboids(base, side[:, None] * [1, 1, 1], yaw, shade, 0.0)}]
    body = cuboids(base + [0, 0, 0.02], side[:, None] * [0.94, 0.94, 0.96], yaw, shade, 0.0)
    frame = copies(_crate_frame(), base, rotation=yaw_matrix(yaw), scale=side, tint=0.85 * shade)
    return [{("plywood", OBSTACLE): body, ("wood", OBSTACLE): frame}]


def _crate_frame() -> Geometry:
    """Battens round the edges of a unit crate, and a diagonal on its sides."""
    h, t = 0.46, 0.08
    low, high, e = t / 2, 1 - t / 2, 0.5 - t / 2
    start, stop = [], []
    for a, b in (((-e, -e), (e, -e)), ((e, -e), (e, e)), ((e, e), (-e, e)), ((-e, e), (-e, -e))):
        for z in (low, high):
            start.append([*a, z])
            stop.append([*b, z])
        start.append([*a, 0.0])
        stop.append([*a, 1.0])
        out = np.array([a[0] + b[0], a[1] + b[1]]) / (2 * e) * (h + 0.015)
        along = np.array([b[0] - a[0], b[1] - a[1]]) * 0.45
        start.append([*(out - along), t])
        stop.append([*(out + along), 1 - t])
    return beams(start, stop, t, t)


def container_yard(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Shipping containers of 20 and 40 feet in stacks of up to five, with aisles between."""
    levels = int(np.clip(zone.height_m / CONTAINER_M[1], 2, 5))
    aisle = rng.uniform(5, 9) / np.sqrt(zone.density)
    bays = max(int((zone.size_m[0] - 4) / (12.2 + aisle)), 1)
    rows = max(int((zone.size_m[1] - 4) / (CONTAINER_M[0] + 0.4)), 1)
    bases, lengths, yaws = [], [], []
    for bay in range(bays):
        x = (bay - (bays - 1) / 2) * (12.2 + aisle)
        height = rng.integers(0, levels + 1, rows)
        # Neighbouring stacks are of like height; every few there is a gap.
        height = np.where(rng.random(rows) < 0.6, np.roll(height, 1), height)
        height[rng.random(rows) < 0.22] = 0
        for row in np.flatnonzero(height):
            y = (row - (rows - 1) / 2) * (CONTAINER_M[0] + 0.4)
            for level in range(height[row]):
                halves = rng.random() < 0.35
                for shift in (-3.05, 3.05) if halves else (0.0,):
                    lengths.append(5.9 if halves else 12.0)
                    bases.append([x + shift + rng.normal(0, 0.05), y + rng.normal(0, 0.04),
                                  level * (CONTAINER_M[1] + 0.02)])  # fmt: skip
                    yaws.append(rng.normal(0, 0.004))
    loose = zone.spots(rng, 30.0, share=0.15)
    bases += [[*p, 0.0] for p in loose if abs((p[0] / (12.2 + aisle)) % 1 - 0.5) < 0.1]
    extra = len(bases) - len(lengths)
    lengths += [5.9] * extra
    yaws += list(rng.uniform(0, np.pi, extra))
    return [
        containers(rng, zone, np.array(bases).reshape(-1, 3), np.array(lengths), np.array(yaws))
    ]


def containers(rng: np.random.Generator, zone: Zone, base, length, yaw) -> Model:
    """Containers at bases (k, 3) of lengths (k,): sheet walls within posts and rails."""
    k = len(base)
    if not k:
        return {}
    wide, high = CONTAINER_M
    tint = zone.palette.tints(rng, k)
    ones = np.ones(k)
    inset = 0.05 if zone.near else 0.0
    size = np.column_stack([length - inset, (wide - inset) * ones, (high - inset) * ones])
    body = cuboids(base + [0, 0, inset / 2], size, yaw, tint, 0.0)
    if not zone.near:
        return {("container", OBSTACLE): body}
    unit = _container_frame(high)
    turn = yaw_matrix(yaw)
    frames = []
    for long in sorted(set(length.tolist())):
        who = length == long
        frames.append(copies(unit(long), base[who], rotation=turn[who], tint=0.8 * tint[who]))
    return {("container", OBSTACLE): body, ("paint", OBSTACLE): join(frames)}


def _container_frame(high: float):
    """Corner posts, rails, and the doors' lock rods of a container of a length."""

    def frame(long: float) -> Geometry:
        x, y, t = long / 2 - 0.06, CONTAINER_M[0] / 2 - 0.06, 0.12
        start, stop = [], []
        for sx in (-x, x):
            for z in (0.06, high - 0.06):
                start.append([sx, -y, z])
                stop.append([sx, y, z])
            for sy in (-y, y):
                start.append([sx, sy, 0])
                stop.append([sx, sy, high])
        for sy in (-y, y):
            for z in (0.06, high - 0.06):
                start.append([-x, sy, z])
                stop.append([x, sy, z])
        rods = np.array([-0.75, -0.3, 0.3, 0.75])
        low = np.column_stack([np.full(4, x + 0.07), rods, np.full(4, 0.1)])
        return join(
            [
                beams(start, stop, t, t),
                beams(low, low + [0, 0, high - 0.2], 0.035, 0.035, (0.7, 0.7, 0.7)),
                beams(
                    [[x + 0.045, 0, 0.14]], [[x + 0.045, 0, high - 0.14]], 0.03, 0.03, (0.2,) * 3
                ),
            ]
        )

    return frame


def high_blocks(rng: np.random.Generator, zone: Zone) -> list[Model]:
    """Towers of two to four tiers, each set back on the one below."""
    xy = zone.spots(rng, 15.0 + zone.object_m, shake=0.4, share=0.75)
    models = []
    for spot in xy:
        side = rng.uniform(3.0, 9.0, 2)
        high = zone.height_m * rng.uniform(0.35, 1.0)
        yaw = float(square_yaws(rng, 1, 0.2)[0])
        tiers = int(rng.integers(1, 4))
        cuts = np.concatenate([[0.0], np.sort(rng.uniform(0.3, 0.85, tiers - 1)), [1.0]]) * high
        shrink = np.cumprod(np.concatenate([[1.0], rng.uniform(0.55, 0.9, tiers - 1)]))
        size = np.column_stack([shrink[:, None] * side, np.diff(cuts)])
        base = np.column_stack([np.tile(spot, (tiers, 1)), cuts[:-1]])
        tint = zone.palette.tints(rng, tiers)
        models.append(
            coated(
                rng,
                lambda c, base=base, size=size, yaw=yaw, tint=tint: cuboids(
                    base[c], size[c], yaw, tint[c]
                ),
                tiers,
            )
        )
        if zone.near and rng.random() < 0.3 + 0.5 * zone.thin:
            models.append(_roof_rail(spot, [*size[-1, :2], high], yaw, zone.palette.tint(rng)))
    return [merge(models)]
