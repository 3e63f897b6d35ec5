"""Balconies with their railings and what people put on them; fire escapes."""

from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.towers.facades import Cells
from synthdepth.maps.towers.massing import Edges
from synthdepth.maps.towers.panels import Panels, block, faces, quads_of

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

RAILINGS = ("bars", "glass", "solid", "mesh")
_BARRIER = ("paint", "barrier")
_RAIL_M = 1.05
_IRONS = ((0.04, 0.04, 0.042), (0.05, 0.06, 0.05), (0.14, 0.06, 0.045), (0.3, 0.3, 0.29))


def add_balconies(
    panels: Panels, params: "Tower", cells: Cells, rng: np.random.Generator, detail: int
) -> None:
    """A slab and a railing before every cell that has a balcony."""
    c = cells.take(cells.balcony)
    k = len(c.wall)
    if not k:
        return
    depth = params.balcony_m
    a, b = c.mid - 0.46 * c.width, c.mid + 0.46 * c.width
    z = c.z0 + 0.1
    slab = block(a, b, z - 0.2, z, 0.0, depth, "flrtb" if detail > 1 else "ftb")
    panels.add(("concrete", "building"), (1.0, 0.99, 0.97), slab, c.wall)
    kind = params.railing
    if detail < 2 or kind in ("glass", "solid"):
        material = "glass" if kind == "glass" else "paint"
        tint = (1.4, 1.5, 1.5) if kind == "glass" else params.accent
        low = z - 0.15 if kind == "solid" else z + 0.05
        n = np.full(k, depth - 0.03)
        for quad in (
            faces(a, b, low, z + _RAIL_M, n),
            quads_of((a, 0.0, low, a, n, low, a, n, z + _RAIL_M, a, 0.0, z + _RAIL_M), [1]),
            quads_of((b, n, low, b, 0.0, low, b, 0.0, z + _RAIL_M, b, n, z + _RAIL_M), [1]),
        ):
            panels.add((material, "barrier"), tint, quad, c.wall)
    if detail < 2:
        return
    colour = params.accent if kind != "glass" else (0.3, 0.3, 0.3)
    _hand_rails(panels, colour, c.wall, a, b, z, depth, kind)
    _belongings(panels, params, c, a, b, z, depth, rng)


def _hand_rails(panels: Panels, colour, wall, a, b, z, depth: float, kind: str) -> None:
    """Rails on three sides, with balusters where it is a railing of bars or mesh."""
    top = z + _RAIL_M
    rails = [top] if kind in ("glass", "solid") else [top, z + 0.12]
    for level in rails:
        panels.add(_BARRIER, colour, block(a, b, level - 0.02, level + 0.025, depth - 0.05, depth,
                                           "ftbk"), wall)  # fmt: skip
        for x in (a, b - 0.04):
            panels.add(
                _BARRIER, colour,
                block(x, x + 0.04, level - 0.02, level + 0.025, 0.0, depth - 0.05, "lrtb"), wall,
            )  # fmt: skip
    if kind in ("glass", "solid"):
        return
    gap = 0.12 if kind == "bars" else 0.3
    along = np.maximum(3, np.round((b - a).max() / gap)).astype(int)
    t = (np.arange(along) + 0.5) / along
    x = (a[:, None] + (b - a)[:, None] * t).ravel()
    o = np.repeat(np.arange(len(a)), along)
    half, n = 0.009, depth - 0.025
    # Flat bars, each turned a little, so that no view loses them.
    turn = 0.006 * np.where(np.arange(len(x)) % 2, 1.0, -1.0)
    low, high = z[o], top[o]
    bar = quads_of(
        (
            *(x - half, n - turn, low, x + half, n + turn, low),
            *(x + half, n + turn, high, x - half, n - turn, high),
        ),
        [0],
    )
    panels.add(_BARRIER, colour, bar, wall[o])
    across = max(3, round(depth / gap))
    t = (np.arange(across) + 0.5) / across * (depth - 0.05)
    for end in (a + 0.02, b - 0.02):
        x, o = np.repeat(end, across), np.repeat(np.arange(len(a)), across)
        n = np.tile(t, len(a))
        bar = quads_of(
            (x, n - half, z[o], x, n + half, z[o], x, n + half, top[o], x, n - half, top[o]),
            [1],
        )
        panels.add(_BARRIER, colour, bar, wall[o])
    if kind == "mesh":
        for f in (0.3, 0.5, 0.7, 0.85):
            level = z + f * _RAIL_M
            line = faces(a, b, level - 0.008, level + 0.008, depth - 0.03)
            panels.add(_BARRIER, colour, line, wall)


def _belongings(panels: Panels, params: "Tower", c: Cells, a, b, z, depth: float, rng) -> None:
    """Planters with plants, air conditioners, chairs and washing."""
    k = len(a)
    planted = np.flatnonzero(rng.random(k) < 0.4)
    x = a[planted] + rng.uniform(0.15, 0.6, len(planted)) * (b - a)[planted]
    y, w = z[planted], c.wall[planted]
    pot = block(x, x + 0.7, y, y + 0.35, depth - 0.45, depth - 0.15, "flrtk")
    panels.add(("wood", "building"), (0.2, 0.14, 0.09), pot, w)
    leaves = 14
    o = np.repeat(np.arange(len(x)), leaves)
    at = x[o] + rng.uniform(0.0, 0.7, len(o))
    n = depth - 0.3 + rng.uniform(-0.14, 0.14, len(o))
    h = y[o] + 0.3 + rng.uniform(0.0, 0.55, len(o)) * rng.uniform(0.4, 1.0, len(x))[o]
    u, v, q = rng.uniform(0.05, 0.16, (3, len(o)))
    leaf = quads_of(
        (
            *(at - u, n - q, h, at + u * 0.3, n + v, h - 0.4 * u),
            *(at + u, n + q, h + v, at - u * 0.3, n - v, h + 1.2 * u),
        ),
        [0],
    )
    green = rng.uniform(0.6, 1.3, (len(o), 1)) * [0.045, 0.085, 0.028]
    panels.add(("leaf", "vegetation"), green, leaf, w[o])
    cooled = np.flatnonzero(rng.random(k) < 0.25)
    x, y = b[cooled] - 1.0, z[cooled]
    unit = block(x, x + 0.8, y + 0.06, y + 0.66, 0.08, 0.4, "flrtb")
    panels.add(("paint", "building"), (0.5, 0.5, 0.48), unit, c.wall[cooled])
    fan = faces(x + 0.08, x + 0.54, y + 0.13, y + 0.59, 0.406)
    panels.add(("paint", "building"), (0.12, 0.12, 0.12), fan, c.wall[cooled])
    airing = np.flatnonzero(rng.random(k) < 0.15)
    o = np.repeat(airing, 3)
    x = a[o] + 0.3 + rng.uniform(0, 1, len(o)) * np.maximum((b - a)[o] - 1.2, 0.1)
    wide, long = rng.uniform(0.3, 0.6, len(o)), rng.uniform(0.3, 0.7, len(o))
    # Washing hangs over the rail.
    n, top = depth + rng.uniform(0.01, 0.03, len(o)), z[o] + _RAIL_M + 0.03
    cloth = rng.uniform(0.06, 0.6, (len(o), 1)) * rng.uniform(0.75, 1.2, (len(o), 3))
    sheet = faces(x, x + wide, top - long, top, n)
    panels.add(("fabric", "building"), cloth, sheet, c.wall[o])
    seat = np.flatnonzero(rng.random(k) < 0.25)
    x, y = a[seat] + 0.3, z[seat]
    chair = block(x, x + 0.48, y + 0.38, y + 0.44, 0.4, 0.86)
    panels.add(("paint", "building"), (0.35, 0.33, 0.3), chair, c.wall[seat])
    back = block(x, x + 0.04, y, y + 0.85, 0.42, 0.84, "flrtk")
    panels.add(("paint", "building"), (0.35, 0.33, 0.3), back, c.wall[seat])


def add_escapes(panels: Panels, params: "Tower", edges: Edges, cells: Cells, rng) -> None:
    """Fire escapes: a platform a storey, ladders between, down the fronts of street walls."""
    iron = ("paint", "barrier")
    colour = _IRONS[int(rng.integers(len(_IRONS)))]
    c = cells.take(cells.street & (edges.tier[cells.wall] == 0))
    for w in np.unique(c.wall):
        own = c.take(c.wall == w)
        bays = int(own.bays[0])
        if bays < 3:
            continue
        start = int(rng.integers(0, bays - 1))
        column = own.take(own.bay == start)
        k = len(column.z0)
        z = column.z0 + 0.12
        wide = float(own.width[0])
        a = column.mid - 0.45 * wide
        b = a + 1.9 * wide
        d = 1.1
        panels.add(iron, colour, block(a, b, z - 0.05, z, 0.0, d, "flr"), w)
        # Gratings: flat bars, so that light comes through.
        bars = 8
        t = np.tile((np.arange(bars) + 0.5) / bars * d, k)
        o = np.repeat(np.arange(k), bars)
        strip = quads_of(
            (
                *(a[o], t - 0.045, z[o] - 0.01, b[o], t - 0.045, z[o] - 0.01),
                *(b[o], t + 0.045, z[o] - 0.01, a[o], t + 0.045, z[o] - 0.01),
            ),
            [2],
        )
        panels.add(iron, colour, strip, w)
        wall = np.full(k, w)
        _hand_rails(panels, colour, wall, a, b, z, d, "bars")
        # Brackets below, then flights that climb in turn to the right and to the left.
        for x in (a + 0.05, (a + b) / 2, b - 0.08):
            brace = quads_of(
                (x, 0.0, z - 0.7, x + 0.03, 0.0, z - 0.7, x + 0.03, d * 0.8, z - 0.05, x, d * 0.8,
                 z - 0.05),
                [1],
            )  # fmt: skip
            panels.add(iron, colour, brace, w)
        steps = 11
        low, high = z[:-1], z[1:]
        o, i = np.repeat(np.arange(k - 1), steps), np.tile(np.arange(steps), k - 1)
        t = (i + 0.7) / (steps + 0.4)
        x0, x1 = a + 0.35, b - 0.35
        right = (o % 2).astype(bool)
        x = np.where(right, x1[o] + (x0 - x1)[o] * t, x0[o] + (x1 - x0)[o] * t)
        at = low[o] + (high - low)[o] * t
        n0 = np.where(right, 0.14, 0.6)
        tread = block(x - 0.11, x + 0.11, at - 0.02, at, n0, n0 + 0.42, "ftb")
        panels.add(iron, colour, tread, w)
        o = np.arange(k - 1)
        right = (o % 2).astype(bool)
        p, q = np.where(right, x1[o], x0[o]), np.where(right, x0[o], x1[o])
        for edge in (0.13, 0.58):
            n = np.where(right, edge, edge + 0.46)
            for lift, deep in ((0.0, 0.16), (0.8, 0.035)):
                stringer = quads_of(
                    (p, n, low + lift - deep, q, n, high + lift - deep, q, n, high + lift, p, n,
                     low + lift),
                    [0],
                )  # fmt: skip
                panels.add(iron, colour, stringer, w)
        # The drop ladder hangs from the lowest platform.
        for x in (a[0] + 0.3, a[0] + 0.72):
            rail = block(
                np.array([x]), x + 0.04, z[0] - 2.1, z[0] + 1.0, d + 0.02, d + 0.06, "flrk"
            )
            panels.add(iron, colour, rail, w)
        at = z[0] - 2.0 + 0.3 * np.arange(10)
        rung = block(np.full(10, a[0] + 0.3), a[0] + 0.74, at, at + 0.03, d + 0.03, d + 0.05, "ftb")
        panels.add(iron, colour, rung, w)
