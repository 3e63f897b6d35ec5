"""A concrete frame under construction: slabs, columns, core, rails, props, netting, hoist."""

import numpy as np

from synthdepth.maps.geometry import Model
from synthdepth.maps.towers.massing import grown
from synthdepth.maps.towers.panels import Panels, block, cover, faces, sweep
from synthdepth.maps.towers.roof import Roof

_CONCRETE = ("concrete", "building")
_STEEL = ("paint", "barrier")
_STOREY_M, _SLAB_M, _SUNK_M = 3.4, 0.26, 0.3
_NETS = ((0.05, 0.12, 0.07), (0.06, 0.11, 0.2), (0.4, 0.4, 0.38), (0.08, 0.08, 0.085))


def construction_tower(rng: np.random.Generator, footprint: np.ndarray, storeys: int) -> Model:
    """A concrete frame under construction.

    Args:
        rng: source of all choices.
        footprint: (n, 2) convex CCW polygon [m].
        storeys: slabs above the ground.

    Returns:
        The model in world coordinates, the ground at z = 0.
    """
    polygon = np.asarray(footprint, np.float64)
    panels = Panels(np.zeros((0, 4)))
    first = panels.frames_of(polygon)
    length = np.linalg.norm(np.roll(polygon, -1, axis=0) - polygon, axis=1)
    plan = Roof(panels, polygon, 0.0)
    levels = _STOREY_M * np.arange(1, storeys + 1)
    for z in levels:
        tint = np.ones(3) * rng.uniform(0.88, 1.08)
        cover(panels, _CONCRETE, tint, polygon, z)
        cover(panels, _CONCRETE, 0.95 * tint, polygon[::-1], z - _SLAB_M)
        sweep(panels, _CONCRETE, tint, polygon, [(0, z - _SLAB_M), (0, z)], shade=(0.85, 1.0))
    cover(panels, _CONCRETE, (0.8, 0.78, 0.74), grown(polygon, 0.4), 0.04)
    columns = _column_grid(plan)
    top = float(levels[-1])
    _columns(plan, columns, levels)
    _core(plan, rng, top)
    _fresh_storey(plan, columns, rng, top)
    _edges(panels, first, length, levels, rng)
    _nets(panels, first, length, levels, rng)
    for z in levels:
        _stores(Roof(panels, polygon, z), columns, rng)
    _props(plan, columns, levels, rng)
    _hoist(panels, first, length, top, rng)
    return panels.model()


def _column_grid(plan: Roof) -> np.ndarray:
    """(k, 2) columns about every 6.5 m, 0.9 m inside the edges."""
    s, n = (
        np.linspace(-r + 0.9, r - 0.9, max(2, round((2 * r - 1.8) / 6.5) + 1)) for r in plan.reach
    )
    grid = np.stack(np.meshgrid(s, n, indexing="ij"), -1).reshape(-1, 2)
    at = plan.world(grid[:, 0], grid[:, 1], 0.0)[:, :2]
    beyond = at @ plan.normal.T - (plan.foot * plan.normal).sum(axis=1)
    return grid[(beyond < -0.6).all(axis=1)]


def _columns(plan: Roof, columns: np.ndarray, levels: np.ndarray) -> None:
    """Square columns from slab to slab."""
    o = np.tile(np.arange(len(columns)), len(levels))
    low = np.repeat(np.concatenate([[-_SUNK_M], levels[:-1]]), len(columns))
    high = np.repeat(levels - _SLAB_M, len(columns))
    s, n = columns[o].T
    made = block(s - 0.23, s + 0.23, low, high, n - 0.23, n + 0.23, "flrk")
    plan.panels.add(_CONCRETE, (1.0, 0.99, 0.97), made, plan.frame)


def _core(plan: Roof, rng: np.random.Generator, top: float) -> None:
    """The lift and stair core, two storeys ahead of the slabs, with climbing formwork."""
    size = np.clip(0.45 * plan.reach, 2.5, 4.5)
    high = top + 1.6 * _STOREY_M
    plan.box(_CONCRETE, (1.04, 1.03, 1.0), 0.0, 0.0, (*(2 * size), high + _SUNK_M), -_SUNK_M)
    lift = top + 0.5 * _STOREY_M
    x, y = size
    ply = ("wood", "building")
    for s, n, w, d in ((0, y + 0.1, 2 * x, 0.1), (0, -y - 0.1, 2 * x, 0.1),
                       (x + 0.1, 0, 0.1, 2 * y), (-x - 0.1, 0, 0.1, 2 * y)):  # fmt: skip
        plan.box(ply, (0.32, 0.22, 0.11), s, n, (w, d, 3.2), lift, "flrtkb")
        # A platform of boards round the forms, with its rail.
        wide = (w, 1.0, 0.06) if d < w else (1.0, d, 0.06)
        out = 0.6 * np.sign([s, n])
        plan.box(ply, (0.22, 0.18, 0.13), s + out[0], n + out[1], wide, lift - 0.3, "flrtkb")
    ring = np.array([[-x, -y], [x, -y], [x, y], [-x, y]]) + 1.1 * np.array(
        [[-1, -1], [1, -1], [1, 1], [-1, 1]]
    )
    stop = np.roll(ring, -1, axis=0)
    for z in (0.25, 0.75):
        a, b = (np.column_stack([p, np.full(4, lift + z)]) for p in (ring, stop))
        plan.rods(_STEEL, (0.45, 0.3, 0.04), a, b, 0.022, 4)
    low, up = (np.column_stack([ring, np.full(4, lift + z)]) for z in (-0.3, 0.8))
    plan.rods(_STEEL, (0.45, 0.3, 0.04), low, up, 0.025, 4)
    # Starter bars stand out of the core's walls.
    t = np.linspace(-1, 1, 24)
    for side in (-1, 1):
        foot = np.column_stack([t * (x - 0.1), np.full(24, side * (y - 0.12)), np.full(24, high)])
        plan.rods(("paint", "obstacle"), (0.12, 0.06, 0.04), foot - [0, 0, 0.1],
                  foot + [0, 0, rng.uniform(0.9, 1.4)], 0.012, 3)  # fmt: skip


def _fresh_storey(plan: Roof, columns: np.ndarray, rng: np.random.Generator, top: float) -> None:
    """On the top slab: columns just cast, forms, starter bars."""
    s, n = columns.T
    state = rng.random(len(columns))
    cast = state < 0.45
    plan.box(_CONCRETE, (1.1, 1.08, 1.05), s[cast], n[cast], (0.46, 0.46, 2.9), top - 0.02)
    formed = (state >= 0.45) & (state < 0.65)
    form = ("wood", "building")
    plan.box(form, (0.3, 0.2, 0.1), s[formed], n[formed], (0.6, 0.6, 2.9), top - 0.02)
    for dx, dy in ((-0.15, -0.15), (0.15, -0.15), (0.15, 0.15), (-0.15, 0.15), (0, 0.15)):
        low = top + np.where(cast | formed, 2.8, -0.05)
        foot = np.column_stack([s + dx, n + dy, low])
        stop = foot + np.column_stack([np.zeros((len(s), 2)), rng.uniform(0.8, 1.5, len(s))])
        plan.rods(("paint", "obstacle"), (0.13, 0.065, 0.04), foot, stop, 0.013, 3)


def _edges(panels: Panels, first: int, length: np.ndarray, levels: np.ndarray, rng) -> None:
    """Guard rails of posts, two rails and a toe board at the edges of all slabs."""
    yellow = np.array([0.42, 0.28, 0.04]) * rng.uniform(0.7, 1.1)
    walls = np.arange(len(length))
    w, z = (a.ravel() for a in np.meshgrid(walls, levels))
    zero, end = np.zeros(len(w)), length[w]
    for low, high in ((0.98, 1.03), (0.5, 0.54)):
        rail = block(zero, end, z + low, z + high, -0.16, -0.12, "ftbk")
        panels.add(_STEEL, yellow, rail, first + w)
    toe = block(zero, end, z - 0.01, z + 0.15, -0.16, -0.13, "ftk")
    panels.add(("wood", "barrier"), (0.25, 0.19, 0.12), toe, first + w)
    count = np.maximum(2, np.round(length / 2.2)).astype(int)
    at = np.concatenate([np.linspace(0.1, m - 0.1, c) for m, c in zip(length, count, strict=True)])
    of = np.repeat(walls, count)
    o, z = (a.ravel() for a in np.meshgrid(np.arange(len(at)), levels))
    post = block(at[o] - 0.02, at[o] + 0.02, z - 0.02, z + 1.1, -0.2, -0.16, "flrtk")
    panels.add(_STEEL, yellow, post, first + of[o])


def _nets(panels: Panels, first: int, length: np.ndarray, levels: np.ndarray, rng) -> None:
    """Debris netting before some stretches of some storeys, each a sheet that bellies out."""
    colour = np.array(_NETS[int(rng.integers(len(_NETS)))])
    for w, m in enumerate(length):
        if rng.random() < 0.35:
            continue
        count = max(1, round(m / 3.0))
        s, z = (a.ravel() for a in np.meshgrid(np.arange(count) * m / count, levels))
        # Whole storeys hang full of it, others have scraps.
        share = rng.choice([0.04, 0.5, 0.96], len(levels), p=[0.45, 0.15, 0.4])
        keep = rng.random(len(s)) < share[np.searchsorted(levels, z - 0.1)]
        s, z = s[keep], z[keep]
        wide, middle = m / count, z - 0.5 * _STOREY_M
        out = rng.uniform(0.02, 0.25, len(s))
        tint = colour * rng.uniform(0.8, 1.2, (len(s), 1))
        for low, high, a, b in (
            (z - _STOREY_M + 0.05, middle, np.full(len(s), 0.03), out),
            (middle, z - 0.02, out, np.full(len(s), 0.03)),
        ):
            sheet = faces(s, s + wide - 0.02, low, high)
            sheet.corners[:, 0, :2, 1] = a[:, None]
            sheet.corners[:, 0, 2:, 1] = b[:, None]
            panels.add(("netting", "barrier"), tint, sheet, first + w)


def _stores(floor: Roof, columns: np.ndarray, rng: np.random.Generator) -> None:
    """What lies on a slab: pallets of blocks, boards, drums, bundles of bars."""
    floor.taken += [(s - 0.4, n - 0.4, s + 0.4, n + 0.4) for s, n in columns]
    half = np.clip(0.45 * floor.reach, 2.5, 4.5) + 0.3
    floor.taken.append((-half[0], -half[1], half[0], half[1]))
    for kind in rng.choice(4, int(rng.integers(3, 8))):
        size = [(1.2, 1.0, 1.1), (3.6, 1.0, 0.5), (0.6, 0.6, 0.9), (6.0, 0.5, 0.25)][kind]
        at = floor.spot(rng, size[:2], 0.2, 1.2)
        if at is None:
            continue
        key = [_CONCRETE, ("wood", "obstacle"), ("paint", "obstacle"), ("paint", "obstacle")][kind]
        tint = [
            (1.1, 1.08, 1.02),
            (0.35, 0.26, 0.15),
            rng.uniform(0.05, 0.3, 3),
            (0.14, 0.07, 0.05),
        ]
        floor.box(key, tint[kind], *at, (*size[:2], size[2] * rng.uniform(0.5, 1.0)), -0.01)


def _props(plan: Roof, columns: np.ndarray, levels: np.ndarray, rng) -> None:
    """Steel props that carry the two youngest slabs."""
    span = plan.reach - 1.4
    grid = np.stack(np.meshgrid(*(np.arange(-r, r, 1.9) for r in span), indexing="ij"), -1).reshape(
        -1, 2
    )
    at = plan.world(grid[:, 0], grid[:, 1], 0.0)[:, :2]
    inside = (at @ plan.normal.T - (plan.foot * plan.normal).sum(axis=1) < -0.8).all(axis=1)
    inside &= (np.abs(grid) > np.clip(0.45 * plan.reach, 2.5, 4.5) + 0.2).any(axis=1)
    grid = grid[inside]
    for k in range(1, min(3, len(levels))):
        high, low = levels[-k] - _SLAB_M, levels[-k - 1]
        keep = grid[rng.random(len(grid)) < 0.8]
        keep = keep + rng.uniform(-0.1, 0.1, keep.shape)
        foot = np.column_stack([keep, np.full(len(keep), low)])
        stop = foot + [0, 0, high - low]
        plan.rods(("paint", "obstacle"), (0.35, 0.1, 0.05), foot, stop, 0.035, 4)


def _hoist(panels: Panels, first: int, length: np.ndarray, top: float, rng) -> None:
    """A passenger hoist on its lattice mast before the longest wall."""
    w = int(np.argmax(length))
    s, n = length[w] * rng.uniform(0.2, 0.4), 1.3
    high = top + 2.5
    x, y, dx, dy = panels.frames[first + w]

    def world(points) -> np.ndarray:
        p = np.atleast_2d(np.asarray(points, float))
        return np.column_stack(
            [x + p[:, 0] * dx + p[:, 1] * dy, y + p[:, 0] * dy - p[:, 1] * dx, p[:, 2]]
        )

    key, red = ("paint", "obstacle"), (0.35, 0.09, 0.04)
    corner = np.array([[-0.33, -0.33], [0.33, -0.33], [0.33, 0.33], [-0.33, 0.33]]) + [s, n]
    low = np.column_stack([corner, np.full(4, -0.05)])
    panels.rods(key, red, world(low), world(low + [0, 0, high]), 0.04, 4)
    z = np.arange(0.75, high, 0.75)
    for k in range(4):
        a, b = corner[k], corner[(k + 1) % 4]
        start = np.column_stack([np.tile(a, (len(z), 1)), z - 0.75])
        stop = np.column_stack([np.tile(b, (len(z), 1)), z])
        panels.rods(key, red, world(start), world(stop), 0.016, 3)
        level = np.column_stack([np.tile(a, (len(z), 1)), z])
        panels.rods(key, red, world(level), world(stop), 0.016, 3)
    ties = np.arange(_STOREY_M, top, 2 * _STOREY_M) - 0.15
    start = np.column_stack([np.full(len(ties), s), np.full(len(ties), n - 0.3), ties])
    panels.rods(key, red, world(start), world(start * [1, 0, 1] + [0, -0.1, 0]), 0.04, 4)
    at = np.array([rng.uniform(2.0, max(2.5, 0.7 * top))])
    car = block(s + 0.42, s + 1.9, at, at + 2.3, n - 0.9, n + 0.9, "flrtbk")
    panels.add(("paint", "obstacle"), (0.4, 0.28, 0.05), car, first + w)
    bars = block(s + 0.42 + 0.2 * np.arange(8), s + 0.45 + 0.2 * np.arange(8), at + 0.1, at + 2.2,
                 n + 0.9, n + 0.93, "flr")  # fmt: skip
    panels.add(("paint", "obstacle"), (0.1, 0.1, 0.1), bars, first + w)
