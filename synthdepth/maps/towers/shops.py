"""Shop fronts: glazing and doors, shutters, signs, awnings, bills."""

from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.materials.city import SIGN_ROW_M, SIGN_ROWS
from synthdepth.maps.towers.facades import pane_tints
from synthdepth.maps.towers.fronts import (
    FRONTS,
    KINDS,
    SUNK_M,
    WARM,
    Fronts,
    base_wall,
    pierced_wall,
    repeat,
)
from synthdepth.maps.towers.panels import Panels, block, faces, quads_of, slopes, tunnel

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

_PAINT = ("paint", "building")
_AWNINGS = np.array(
    [
        [0.03, 0.09, 0.055], [0.17, 0.03, 0.035], [0.04, 0.055, 0.13], [0.45, 0.42, 0.34],
        [0.06, 0.06, 0.06], [0.3, 0.12, 0.04], [0.22, 0.2, 0.18],
    ]
)  # fmt: skip


def add_shops(panels: Panels, params: "Tower", f: Fronts, rng, top: float, head: float) -> None:
    """Glazed fronts with doors, stall risers, signs, awnings; some behind a shutter."""
    k = len(f.a)
    if not k:
        return
    key, tint = base_wall(params)
    margin = rng.uniform(0.32, 0.55)
    s0, s1 = pierced_wall(panels, params, f, top, margin, head)
    n = np.full(k, -0.22)
    panels.add(key, tint, tunnel(s0, s1, -SUNK_M, head, 0.0, n, "lrt"), f.wall)
    colour = FRONTS[rng.integers(len(FRONTS), size=k)] * rng.uniform(0.8, 1.2, (k, 1))
    closed = f.kind == KINDS.index("shutter")
    # Slats of a shutter are lines that stand out, on a sheet.
    c = np.flatnonzero(closed)
    sheet = rng.uniform(0.16, 0.45, (len(c), 1)) * [1.0, 1.0, 1.02]
    panels.add(_PAINT, sheet, faces(s0[c], s1[c], -0.02, head, n[c]), f.wall[c])
    slats = int(head / 0.22)
    o, i = repeat(np.full(len(c), slats))
    z = 0.1 + 0.22 * i
    slat = block(s0[c][o], s1[c][o], z, z + 0.07, n[c][o], n[c][o] + 0.02, "ftb")
    panels.add(_PAINT, 0.92 * sheet[o], slat, f.wall[c][o])
    # Panes of about 1.6 m; one of them is the door.
    g = np.flatnonzero(~closed)
    count = np.maximum(2, np.round((s1 - s0)[g] / 1.6)).astype(int)
    o, i = repeat(count)
    which = g[o]
    door = i == (rng.random(len(g)) * count).astype(int)[o]
    wide = ((s1 - s0)[g] / count)[o]
    p0 = s0[which] + wide * i
    p1 = p0 + wide
    stall, transom = 0.5, min(2.35, head - 0.35)
    riser = block(p0, p1, -SUNK_M, stall, n[which], -0.1, "ft")
    panels.add(_PAINT, colour[which], riser, f.wall[which], where=~door)
    kick = block(p0 + 0.05, p1 - 0.05, 0.0, 0.28, n[which], n[which] + 0.02, "flrt")
    panels.add(_PAINT, colour[which], kick, f.wall[which], where=door)
    low = np.where(door, 0.02, stall)
    dim = np.full(len(which), -0.22)
    for z0, z1 in ((low, np.full(len(low), transom)), (np.full(len(low), transom), head)):
        lean = np.tan(np.radians(rng.uniform(-0.5, 0.5, len(low)))) * (wide / 2)
        lean = np.clip(lean, -0.02, 0.02)
        pane = quads_of(
            (*(p0, dim - lean, z0, p1, dim + lean, z0), *(p1, dim + lean, z1, p0, dim - lean, z1)),
            [0],
        )
        panels.add(
            ("glass", "building"), 1.2 * pane_tints(params, rng, len(low)), pane, f.wall[which]
        )
    for at, stands in ((p0, np.ones(len(o), bool)), (p1, i == count[o] - 1)):
        post = block(at - 0.035, at + 0.035, low, head, n[which] - 0.03, n[which] + 0.04, "flr")
        panels.add(_PAINT, colour[which], post, f.wall[which], where=stands)
    for z in (transom, head - 0.035):
        bar = block(s0[g], s1[g], z - 0.035, z + 0.035, n[g] - 0.03, n[g] + 0.035, "ftb")
        panels.add(_PAINT, colour[g], bar, f.wall[g])
    _displays(panels, rng, f.wall[which][~door], p0[~door], p1[~door], stall, transom)
    _signs(panels, params, f, s0, s1, rng, head, colour)


def _displays(panels: Panels, rng, wall, p0, p1, low: float, high: float) -> None:
    """Posters inside some shop windows."""
    chosen = np.flatnonzero(rng.random(len(p0)) < 0.3)
    wide = rng.uniform(0.4, 0.9, len(chosen))
    at = p0[chosen] + 0.1 + rng.random(len(chosen)) * ((p1 - p0)[chosen] - 0.2 - wide).clip(0)
    z = rng.uniform(low + 0.15, high - 0.9, len(chosen))
    poster = faces(at, at + wide, z, z + rng.uniform(0.5, 0.8, len(chosen)), -0.195)
    shift = rng.uniform(0, 12, (len(chosen), 2))
    panels.add(("poster", "building"), (0.9, 0.9, 0.9), poster, wall[chosen], uv_shift=shift)


def _signs(panels: Panels, params: "Tower", f: Fronts, s0, s1, rng, head: float, colour) -> None:
    """Fascia boards with lamps over them, awnings, and boards that stand out from the wall."""
    k = len(s0)
    low = head + 0.06
    a, b = s0 - 0.08, s1 + 0.08
    panels.add(_PAINT, colour, block(a, b, low, low + SIGN_ROW_M, 0.0, 0.1, "lrtb"), f.wall)
    row = rng.integers(SIGN_ROWS, size=k)
    shift = np.column_stack([rng.uniform(0, 12.8, k), SIGN_ROW_M * row - low])
    board = faces(a, b, low, low + SIGN_ROW_M, 0.1)
    panels.add(("signboard", "building"), (1, 1, 1), board, f.wall, uv_shift=shift)
    # Lamps on short arms, their faces turned down on the board.
    lit = np.flatnonzero(rng.random(k) < 0.55)
    for t in (0.25, 0.75):
        at, z = a[lit] + t * (b - a)[lit], low + SIGN_ROW_M + 0.12
        lamp_face = block(at - 0.14, at + 0.14, z, z + 0.05, 0.38, 0.48, "b")
        panels.add(("lamp", "building"), WARM, lamp_face, f.wall[lit])
        cap = block(at - 0.15, at + 0.15, z + 0.004, z + 0.07, 0.37, 0.49, "flrtk")
        panels.add(_PAINT, (0.05, 0.05, 0.05), cap, f.wall[lit])
        arm = block(at - 0.015, at + 0.015, z + 0.04, z + 0.065, 0.0, 0.38, "lrtb")
        panels.add(_PAINT, (0.05, 0.05, 0.05), arm, f.wall[lit])
    dressed = np.flatnonzero(rng.random(k) < 0.38)
    cloth = _AWNINGS[rng.integers(len(_AWNINGS), size=len(dressed))]
    cloth = cloth * rng.uniform(0.8, 1.2, (len(dressed), 1))
    reach = rng.uniform(0.9, 1.5, len(dressed))
    z1, z0 = low + 0.02, low - 0.55
    x0, x1, w = s0[dressed], s1[dressed], f.wall[dressed]
    panels.add(("fabric", "building"), cloth, slopes(x0, x1, reach, z0, 0.12, z1), w)
    valance = faces(x0, x1, z0 - 0.22, z0, reach)
    panels.add(("fabric", "building"), cloth, valance, w)
    for x in (x0, x1):
        cheek = quads_of((x, 0.1, z0, x, reach, z0, x, 0.12, z1, x, 0.1, z1), [1])
        panels.add(("fabric", "building"), cloth, cheek, w)
    out = np.flatnonzero(rng.random(k) < 0.3)
    at, z = a[out] + 0.2, low + rng.uniform(0.9, 1.3, len(out))
    wide = rng.uniform(0.6, 0.9, len(out))
    plate = block(at, at + 0.1, z, z + SIGN_ROW_M, 0.4, 0.4 + wide, "lr")
    shift = np.column_stack([rng.uniform(0, 12.8, len(out)), SIGN_ROW_M * row[out] - z])
    panels.add(("signboard", "street_furniture"), (1, 1, 1), plate, f.wall[out], uv_shift=shift)
    rim = block(at, at + 0.1, z, z + SIGN_ROW_M, 0.4, 0.4 + wide, "ftbk")
    panels.add(("paint", "street_furniture"), colour[out], rim, f.wall[out])
    arm = block(at + 0.03, at + 0.07, z + 0.7, z + 0.74, -0.02, 0.41, "lrtb")
    panels.add(("paint", "street_furniture"), (0.05, 0.05, 0.05), arm, f.wall[out])


def add_bills(panels: Panels, params: "Tower", f: Fronts, rng) -> None:
    """Bills pasted side by side on blank walls, and vents above them."""
    for k in np.flatnonzero(rng.random(len(f.a)) < 0.5):
        count = int((f.b[k] - f.a[k] - 1.0) / 0.75)
        if count < 2:
            continue
        count = int(rng.integers(2, min(count, 8) + 1))
        at = f.a[k] + 0.5 + 0.72 * np.arange(count) + rng.uniform(-0.02, 0.02, count)
        low = 0.9 + rng.uniform(-0.04, 0.04, count)
        bill = faces(at, at + 0.68, low, low + 1.0, 0.008)
        shift = np.repeat(rng.uniform(0, 12, (count // 3 + 1, 2)), 3, axis=0)[:count]
        shift[:, 0] -= at
        panels.add(("poster", "building"), (0.8, 0.8, 0.8), bill, f.wall[k], uv_shift=shift)
    x = f.a + 0.3 * (f.b - f.a)
    z = np.full(len(x), 3.0)
    vent = block(x, x + 0.5, z, z + 0.35, 0.0, 0.06)
    panels.add(_PAINT, (0.2, 0.2, 0.2), vent, f.wall)
