"""Detail 2 of walls with windows in them, single or in ribbons: relief, panes, stains."""

from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.towers.facades import (
    Cells,
    cloth_tints,
    openings,
    pane_tints,
    soiling,
    wall_tints,
)
from synthdepth.maps.towers.massing import Edges
from synthdepth.maps.towers.panels import Panels, Quads, block, faces, quads_of, ring, tunnel
from synthdepth.maps.towers.styles import STYLES

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

_PAINT = ("paint", "building")


def panes(s0, s1, z0, z1, n, lean, low=None, high=None) -> Quads:
    """Rectangles in the plane n that lean by slopes `lean` (2, k) along s and z.

    `low` and `high` cut the rectangle without changing its plane.
    """
    low, high = z0 if low is None else low, z1 if high is None else high
    middle = (z0 + z1) / 2
    ds = lean[0] * (s1 - s0) / 2
    a, b = lean[1] * (low - middle), lean[1] * (high - middle)
    return quads_of(
        (
            *(s0, n - ds + a, low, s1, n + ds + a, low),
            *(s1, n + ds + b, high, s0, n - ds + b, high),
        ),
        [0],
    )


def glaze(
    panels: Panels, params: "Tower", rng, wall, s0, s1, z0, z1, n, columns: int, rows: int,
    bar_m: float, blinds: float = 0.35, frame=None,
) -> None:  # fmt: skip
    """Panes, blinds and bars of the clear openings s, z at depth n, all (k,)."""
    k = len(s0)
    if not k:
        return
    blind = np.where(rng.random(k) < blinds, rng.choice([0.25, 0.4, 0.6, 1.0], k), 0.0)
    edge = z1 - blind * (z1 - z0)
    cloth = cloth_tints(rng, k)
    glass = pane_tints(params, rng, k)
    o = np.repeat(np.arange(k), columns * rows)
    i = np.tile(np.arange(columns * rows), k)
    wide, tall = ((s1 - s0) / columns)[o], ((z1 - z0) / rows)[o]
    p0, q0 = s0[o] + wide * (i % columns), z0[o] + tall * (i // columns)
    p1, q1 = p0 + wide, q0 + tall
    lean = np.tan(np.radians(rng.uniform(-0.8, 0.8, (2, len(o)))))
    # No pane leaves its frame.
    lean *= np.minimum(1, 0.016 / np.maximum(np.abs(lean[0]) * wide, np.abs(lean[1]) * tall))
    cut = np.clip(edge[o], q0, q1)
    clear, covered = cut > q0 + 0.02, cut < q1 - 0.02
    plane = n[o] - 0.012
    # Old panes differ within a window, too.
    tint = glass[o] * rng.uniform(0.92, 1.08, (len(o), 1))
    made = panes(p0, p1, q0, q1, plane, lean, high=np.where(covered, cut, q1))
    panels.add(("glass", "building"), tint[clear], made.take(clear), wall[o[clear]])
    made = panes(p0, p1, q0, q1, plane, lean, low=np.where(clear, cut, q0)).take(covered)
    panels.add(("curtained_glass", "building"), cloth[o[covered]], made, wall[o[covered]])
    colour = params.frame if frame is None else frame
    half = bar_m / 2
    for count, upright in ((columns, True), (rows, False)):
        if count < 2:
            continue
        o = np.repeat(np.arange(k), count - 1)
        t = np.tile(np.arange(1, count) / count, k)
        if upright:
            at = s0[o] + t * (s1 - s0)[o]
            bar = block(at - half, at + half, z0[o], z1[o], n[o] - 0.03, n[o] + 0.014, "flr")
        else:
            at = z0[o] + t * (z1 - z0)[o]
            bar = block(s0[o], s1[o], at - half, at + half, n[o] - 0.03, n[o] + 0.01, "ftb")
        panels.add(_PAINT, colour, bar, wall[o])


def add_punched(
    panels: Panels, params: "Tower", edges: Edges, cells: Cells, rng: np.random.Generator
) -> None:
    """Walls of cells with their windows."""
    tints = wall_tints(params, cells, rng)
    key = (params.wall[0], "building")
    blank = ~cells.open
    b = cells.take(blank)
    panels.add(key, tints[blank], faces(b.c0, b.c1, b.z0, b.z1), b.wall)
    cells, tints = cells.take(cells.open), tints[cells.open]
    s0, s1, y0, y1 = openings(params, cells)
    wall, k = cells.wall, len(s0)
    ribbon = params.skin == "ribbon"
    surround = params.lintel == "surround"
    below = np.ones((k, 4, 4))
    # Rain washes the dust of the sill down the wall below it, and the head is sheltered.
    below[:, 2, 2:] = rng.uniform(0.72, 0.95, (k, 1))
    below[:, 3, :2] = 0.93
    walls = ring(cells.c0, cells.c1, cells.z0, cells.z1, s0, s1, y0, y1)
    panels.add(key, tints, walls, wall, below)
    front = 0.035 if surround else 0.0
    n = np.full(k, -params.reveal_m)
    jamb = (params.trim[0], "building") if surround else key
    jamb_tint = np.asarray(params.trim[1]) * soiling(cells.z0)[:, None] if surround else tints
    sides = tunnel(s0, s1, y0, y1, front, n, "t")
    panels.add(jamb, 0.96 * jamb_tint, sides, wall)
    for side, stands in (("l", s0 > cells.c0 + 0.01), ("r", s1 < cells.c1 - 0.01)):
        made = tunnel(s0, s1, y0, y1, front, n, side)
        panels.add(jamb, jamb_tint[stands], made.take(stands), wall[stands])
    _sills(panels, params, cells, s0, s1, y0, n, tints, rng)
    frame = params.frame_m
    f0, f1, g0, g1 = s0 + frame, s1 - frame, y0 + frame, y1 - frame
    panels.add(_PAINT, params.frame, ring(s0, s1, y0, y1, f0, f1, g0, g1, n), wall)
    glaze(
        panels, params, rng, wall, f0, f1, g0, g1, n, params.columns, params.rows,
        0.035 if params.columns > 3 else 0.05, 0.12 if params.columns > 3 else 0.38,
    )  # fmt: skip
    if not ribbon:
        _lintels(panels, params, cells, s0, s1, y0, y1)
        _air_conditioners(panels, params, cells, s0, y0, rng)
    if params.pilaster_m > 0.08 and not ribbon:
        add_pilasters(panels, params, edges, cells)


def _sills(panels: Panels, params: "Tower", cells: Cells, s0, s1, y0, n, tints, rng) -> None:
    """Sills with their drips; below some, streaks that fade down the wall."""
    out = STYLES[params.facade].window.sill_out_m
    key = (params.wall[0], "building")
    if not out:
        panels.add(key, 0.9 * tints, tunnel(s0, s1, y0, y0 + 1, 0.0, n, "b"), cells.wall)
        return
    ribbon = params.skin == "ribbon"
    grow = 0.0 if ribbon else 0.06
    material = "metal" if params.wall[0] == "cladding" or ribbon else params.trim[0]
    tint = (0.85, 0.85, 0.85) if material == "metal" else params.trim[1]
    thick = 0.03 if material == "metal" else 0.08
    made = block(s0 - grow, s1 + grow, y0 - thick, y0 + 0.004, n, out, "ftb" + "lr" * (not ribbon))
    panels.add((material, "building"), tint, made, cells.wall)
    # Narrow tongues of the wall's own texture, dark at the top and even with it at the bottom.
    chosen = np.flatnonzero((rng.random(len(s0)) < 0.55) & (y0 - cells.z0 > 0.3))
    end = rng.random(len(chosen)) < 0.5
    at = np.where(end, s0[chosen] - 0.02, s1[chosen] + 0.02)
    half = rng.uniform(0.04, 0.16, len(chosen))
    low = np.maximum(y0[chosen] - rng.uniform(0.4, 1.6, len(chosen)), cells.z0[chosen] + 0.02)
    z, m = y0[chosen] - thick - 0.01, 0.007
    tongue = quads_of(
        (
            *(at - 0.35 * half, m, low, at + 0.3 * half, m, low),
            *(at + half, m, z, at - half, m, z),
        ),
        [0],
    )
    shade = np.ones((len(chosen), 1, 4))
    shade[:, 0, 2:] = rng.uniform(0.55, 0.85, (len(chosen), 1))
    panels.add(key, tints[chosen], tongue, cells.wall[chosen], shade)


def _lintels(panels: Panels, params: "Tower", cells: Cells, s0, s1, y0, y1) -> None:
    """Stone lintels, or surrounds with a keystone's weight of shadow."""
    key, tint = (params.trim[0], "building"), params.trim[1]
    tints = np.asarray(tint) * soiling(cells.z0)[:, None]
    if params.lintel == "stone":
        made = block(s0 - 0.12, s1 + 0.12, y1, y1 + 0.22, -0.02, 0.03)
        panels.add(key, tints, made, cells.wall)
    elif params.lintel == "surround":
        a, b, c, d = s0 - 0.14, s1 + 0.14, y0 - 0.12, y1 + 0.18
        around = ring(a, b, c, d, s0, s1, y0, y1, 0.035)
        panels.add(key, tints, around, cells.wall)
        panels.add(key, tints, tunnel(a, b, c, d, -0.02, 0.035), cells.wall)
        # A small hood over it.
        hood = block(a - 0.05, b + 0.05, d, d + 0.09, -0.02, 0.12)
        panels.add(key, tints, hood, cells.wall)


def _air_conditioners(panels: Panels, params: "Tower", cells: Cells, s0, y0, rng) -> None:
    """Units that hang below some windows, with their drip on the wall."""
    chosen = rng.random(len(s0)) < params.air_conditioners
    chosen &= (y0 - cells.z0 > 0.5) & ~cells.balcony
    c = np.flatnonzero(chosen)
    a, z = s0[c] + rng.uniform(0.0, 0.5, len(c)), y0[c] - rng.uniform(0.55, 0.62, len(c))
    light = rng.uniform(0.3, 0.58, (len(c), 1)) * [1.0, 0.99, 0.95]
    made = block(a, a + 0.72, z, z + 0.44, 0.04, 0.34, "flrtb")
    panels.add(_PAINT, light, made, cells.wall[c])
    grille = faces(a + 0.06, a + 0.48, z + 0.05, z + 0.39, 0.346)
    panels.add(_PAINT, 0.35 * light, grille, cells.wall[c])


def add_pilasters(panels: Panels, params: "Tower", edges: Edges, cells: Cells) -> None:
    """Flat piers between the bays of street walls, from the ground floor to the cornice."""
    first = cells.take(
        (cells.storey == np.maximum(np.array([t.first for t in params.tiers]), 1)[
            edges.tier[cells.wall]
        ]) & cells.street
    )  # fmt: skip
    at = np.concatenate([first.c0[first.bay > 0], first.c0[first.bay == 0] + 0.32])
    wall = np.concatenate([first.wall[first.bay > 0], first.wall[first.bay == 0]])
    last = np.concatenate([first.c1[first.bay == first.bays - 1] - 0.32])
    at = np.concatenate([at, last])
    wall = np.concatenate([wall, first.wall[first.bay == first.bays - 1]])
    tops = np.array([params.levels_m[t.last] for t in params.tiers])[edges.tier[wall]]
    lows = np.array([params.levels_m[max(t.first, 1)] for t in params.tiers])[edges.tier[wall]]
    half = min(0.3, 0.42 * (1 - params.window_width) * params.bay_m)
    p = params.pilaster_m
    key = (params.wall[0], "building")
    middle = np.clip(14.0, lows, tops)
    for low, high in ((lows, middle), (middle, tops)):
        made = block(at - half, at + half, low, high, -0.02, p, "flrt")
        shade = np.ones((len(at), 4, 4))
        shade[:, :3, :2] = soiling(low)[:, None, None]
        shade[:, :3, 2:] = soiling(high)[:, None, None]
        panels.add(key, params.wall[1], made, wall, shade)
