"""Ground floors: lobbies, entrances, flats, docks and service doors beside the shops."""

from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.materials.city import SIGN_ROW_M, SIGN_ROWS
from synthdepth.maps.towers.facades import pane_tints
from synthdepth.maps.towers.fronts import (
    FRONTS,
    SUNK_M,
    WARM,
    Fronts,
    base_wall,
    fronts_of,
    pierced_wall,
    plain_wall,
    repeat,
)
from synthdepth.maps.towers.massing import Edges
from synthdepth.maps.towers.panels import Panels, block, faces, ring, slopes, tunnel
from synthdepth.maps.towers.punched import glaze
from synthdepth.maps.towers.shops import add_bills, add_shops

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

_PAINT = ("paint", "building")


def add_ground(
    panels: Panels, params: "Tower", edges: Edges, rng: np.random.Generator, detail: int
) -> None:
    """The ground floor of all walls; `detail` as in `tower`."""
    top = float(params.levels_m[1])
    fronts = fronts_of(params, edges, rng)
    if detail < 2:
        _plain(panels, params, edges, fronts, rng, top, detail)
        return
    head = min(top - 1.5, 3.3)
    plain_wall(panels, params, fronts.of("blank", "service"), top)
    add_bills(panels, params, fronts.of("blank"), rng)
    add_shops(panels, params, fronts.of("shop", "shutter"), rng, top, head)
    _lobby(panels, params, fronts.of("lobby"), rng, top)
    _entrances(panels, params, fronts.of("entrance"), rng, top)
    _flats(panels, params, fronts.of("flat"), rng, top)
    _docks(panels, params, fronts.of("dock"), rng, top)
    _service(panels, params, fronts.of("service"), rng)


def _lobby(panels: Panels, params: "Tower", f: Fronts, rng, top: float) -> None:
    """Glass from floor to ceiling between slim posts."""
    if not len(f.a):
        return
    s0, s1 = pierced_wall(panels, params, f, top, 0.3, top - 0.7)
    n = np.full(len(s0), -0.4)
    key, tint = base_wall(params)
    panels.add(key, tint, tunnel(s0, s1, -SUNK_M, top - 0.7, 0.0, n, "lrt"), f.wall)
    plinth = block(s0, s1, -SUNK_M, 0.12, n, n + 0.06, "ft")
    panels.add(("stone", "building"), (0.14, 0.14, 0.14), plinth, f.wall)
    columns = max(2, round(float((s1 - s0).mean()) / 1.8))
    z0, z1 = np.full(len(s0), 0.12), np.full(len(s0), top - 0.7)
    glaze(panels, params, rng, f.wall, s0, s1, z0, z1, n, columns, 2, 0.06, 0.0)


def _entrances(panels: Panels, params: "Tower", f: Fronts, rng, top: float) -> None:
    """Doors in a deep reveal with a fanlight, a canopy and a lamp on each side."""
    k = len(f.a)
    if not k:
        return
    office = params.ground in ("lobby", "dock")
    half = np.minimum(1.9 if office else 1.1, 0.4 * (f.b - f.a))
    middle = (f.a + f.b) / 2
    head = min(top - 0.95, 3.2)
    s0, s1 = pierced_wall(panels, params, f, top, (f.b - f.a) / 2 - half, head)
    n = np.full(k, -0.45)
    key, tint = base_wall(params)
    panels.add(key, 0.9 * tint, tunnel(s0, s1, -SUNK_M, head, 0.0, n, "lrt"), f.wall)
    step = block(s0 - 0.2, s1 + 0.2, -SUNK_M, 0.12, n, 0.35, "flrt")
    panels.add(("stone", "building"), (0.3, 0.29, 0.27), step, f.wall)
    door = np.asarray(params.accent) * np.ones((k, 1))
    edge = 0.09
    z0, z1 = np.full(k, 0.12), np.full(k, 2.35)
    made = ring(s0, s1, z0, head, s0 + edge, s1 - edge, z0 + 0.25, z1, n)
    panels.add(_PAINT, door, made, f.wall)
    glaze(panels, params, rng, f.wall, s0 + edge, s1 - edge, z0 + 0.25, z1, n, 2, 1, 0.12, 0, door)
    fan = np.full(k, head - edge)
    panels.add(
        ("glass", "building"), pane_tints(params, rng, k),
        faces(s0 + edge, s1 - edge, z1 + 0.12, fan, n + 0.004), f.wall,
    )  # fmt: skip
    reach = 2.0 if office else 1.0
    slab = block(s0 - 0.5, s1 + 0.5, head + 0.1, head + 0.32, 0.0, reach, "flrtb")
    panels.add(_PAINT, params.frame, slab, f.wall)
    light = block(middle - 0.2, middle + 0.2, head + 0.094, head + 0.12, reach * 0.45, reach * 0.7,
                  "b")  # fmt: skip
    panels.add(("lamp", "building"), WARM, light, f.wall)
    for x in (s0 - 0.35, s1 + 0.35):
        _wall_lamp(panels, f.wall, x, 2.1)


def _wall_lamp(panels: Panels, wall, x, z: float) -> None:
    """A small lamp that shines down the wall."""
    body = block(x - 0.07, x + 0.07, z + 0.006, z + 0.26, 0.0, 0.14, "flrt")
    panels.add(_PAINT, (0.05, 0.05, 0.05), body, wall)
    lamp_face = block(x - 0.06, x + 0.06, z, z + 0.1, 0.02, 0.13, "b")
    panels.add(("lamp", "building"), WARM, lamp_face, wall)


def _flats(panels: Panels, params: "Tower", f: Fronts, rng, top: float) -> None:
    """Raised ground-floor flats: windows with bars over a stone plinth."""
    k = len(f.a)
    if not k:
        return
    key, tint = base_wall(params)
    half = 0.5 * min(params.window_width, 0.6) * (f.b - f.a)
    middle, y0, y1 = (f.a + f.b) / 2, 1.35, min(top - 0.7, 3.5)
    s0, s1 = middle - half, middle + half
    shade = np.ones((k, 4, 4))
    shade[:, :3, :2] = 0.66
    panels.add(key, tint, ring(f.a, f.b, 0.8, top, s0, s1, y0, y1), f.wall)
    panels.add(key, tint, faces(f.a, f.b, -SUNK_M, 0.8), f.wall)
    plinth = block(f.a, f.b, -SUNK_M, 0.8, 0.0, 0.05, "ft")
    panels.add(("stone", "building"), 0.75 * np.asarray(params.trim[1]) if params.trim[0] == "stone"
               else (0.25, 0.24, 0.22), plinth, f.wall, shade[:, :2])  # fmt: skip
    n = np.full(k, -max(params.reveal_m, 0.1))
    panels.add(key, tint, tunnel(s0, s1, y0, y1, 0.0, n), f.wall)
    e = 0.06
    panels.add(_PAINT, params.frame, ring(s0, s1, y0, y1, s0 + e, s1 - e, y0 + e, y1 - e, n),
               f.wall)  # fmt: skip
    z0, z1 = np.full(k, y0 + e), np.full(k, y1 - e)
    glaze(panels, params, rng, f.wall, s0 + e, s1 - e, z0, z1, n, 2, 1, 0.05, 0.6)
    sill = block(s0 - 0.06, s1 + 0.06, y0 - 0.08, y0 + 0.004, n, 0.07)
    panels.add((params.trim[0], "building"), params.trim[1], sill, f.wall)
    barred = np.flatnonzero(rng.random(k) < 0.4)
    count = np.maximum(4, ((s1 - s0)[barred] / 0.13)).astype(int)
    o, i = repeat(count)
    at = s0[barred][o] + (s1 - s0)[barred][o] * (i + 0.5) / count[o]
    bar = faces(at - 0.009, at + 0.009, y0, y1, -0.03)
    panels.add(("paint", "barrier"), (0.04, 0.04, 0.04), bar, f.wall[barred][o])


def _docks(panels: Panels, params: "Tower", f: Fronts, rng, top: float) -> None:
    """Wide doors of sectional sheets, a lamp over each, bumpers at their feet."""
    k = len(f.a)
    if not k:
        return
    head = min(top - 1.0, 3.8)
    s0, s1 = pierced_wall(panels, params, f, top, 0.6, head)
    n = np.full(k, -0.3)
    key, tint = base_wall(params)
    panels.add(key, tint, tunnel(s0, s1, -SUNK_M, head, 0.0, n, "lrt"), f.wall)
    sheet = FRONTS[rng.integers(4, len(FRONTS), size=k)]
    panels.add(_PAINT, sheet, faces(s0, s1, -0.02, head, n), f.wall)
    o, i = repeat(np.full(k, int(head / 0.5)))
    z = 0.5 * (i + 1)
    panels.add(_PAINT, 0.5 * sheet[o], block(s0[o], s1[o], z, z + 0.03, n[o], n[o] + 0.012, "ftb"),
               f.wall[o])  # fmt: skip
    _wall_lamp(panels, f.wall, (s0 + s1) / 2, head + 0.12)


def _service(panels: Panels, params: "Tower", f: Fronts, rng) -> None:
    """Steel doors, louvres, meter boxes and a lamp on a back wall."""
    k = len(f.a)
    if not k:
        return
    x = f.a + rng.uniform(0.5, 1.0, k)
    leaf = block(x, x + 1.0, -0.02, 2.1, -0.02, 0.03, "flrt")
    panels.add(_PAINT, FRONTS[rng.integers(len(FRONTS), size=k)], leaf, f.wall)
    _wall_lamp(panels, f.wall, x + 0.5, 2.3)
    y = x + 1.5
    box = block(y, y + 0.6, 1.0, 1.7, -0.02, 0.22, "flrtb")
    panels.add(_PAINT, rng.uniform(0.2, 0.4, (k, 1)) * [1, 1, 1.02], box, f.wall)
    o, i = repeat(np.full(k, 8))
    z = 2.6 + 0.13 * i
    slat = slopes((x + 0.2)[o], (x + 1.7)[o], 0.07, z, 0.005, z + 0.11)
    panels.add(_PAINT, (0.22, 0.22, 0.22), slat, f.wall[o])


def _plain(
    panels: Panels, params: "Tower", edges: Edges, f: Fronts, rng, top: float, detail: int
) -> None:
    """Detail 1 and 0: walls, and panes and boards flush before them."""
    key, tint = base_wall(params)
    ground = np.flatnonzero(edges.tier == 0)
    wall = faces(np.zeros(len(ground)), edges.length_m[ground], -SUNK_M, top)
    panels.add(key, tint, wall, ground)
    glazed = f.of("shop", "lobby", "entrance")
    head = min(top - 1.5, 3.3)
    if detail == 0:
        street = ground[edges.street[ground]]
        pane = faces(np.full(len(street), 0.6), edges.length_m[street] - 0.6, 0.4, head, 0.03)
        panels.add(("glass", "building"), (1, 1, 1), pane, street)
        return
    pane = faces(glazed.a + 0.4, glazed.b - 0.4, 0.35, head, 0.01)
    panels.add(("glass", "building"), pane_tints(params, rng, len(glazed.a)), pane, glazed.wall)
    shops = f.of("shop", "shutter")
    low = head + 0.06
    row = rng.integers(SIGN_ROWS, size=len(shops.a))
    shift = np.column_stack([rng.uniform(0, 12.8, len(row)), SIGN_ROW_M * row - low])
    board = faces(shops.a + 0.3, shops.b - 0.3, low, low + SIGN_ROW_M, 0.03)
    panels.add(("signboard", "building"), (1, 1, 1), board, shops.wall, uv_shift=shift)
    sheet = f.of("dock", "service")
    door = faces(sheet.a + 0.8, sheet.b - 0.8, 0.0, 3.0, 0.01)
    panels.add(_PAINT, (0.25, 0.25, 0.25), door, sheet.wall)
