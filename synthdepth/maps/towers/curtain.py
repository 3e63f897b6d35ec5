"""Detail 2 of curtain walls: panes on mullions and transoms, spandrels, fins."""

from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.towers.facades import Cells, cloth_tints, pane_tints, wall_tints
from synthdepth.maps.towers.massing import Edges
from synthdepth.maps.towers.panels import Panels, block, faces
from synthdepth.maps.towers.punched import panes

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

_PAINT = ("paint", "building")
_BACK_M = -0.045


def _leans(rng: np.random.Generator, s0, s1, z0, z1) -> np.ndarray:
    """(2, k) slopes of panes, about a degree, less where a pane would leave its frame."""
    lean = np.tan(np.radians(np.clip(rng.normal(0, 0.45, (2, len(s0))), -1, 1)))
    reach = np.maximum(np.abs(lean[0]) * (s1 - s0), np.abs(lean[1]) * (z1 - z0))
    return lean * np.minimum(1, 0.03 / np.maximum(reach, 1e-9))


def add_curtain(
    panels: Panels, params: "Tower", edges: Edges, cells: Cells, rng: np.random.Generator
) -> None:
    """Curtain walls; cells without windows are clad in panels."""
    tints = wall_tints(params, cells, rng)
    key = (params.wall[0], "building")
    blank = ~cells.open
    b = cells.take(blank)
    panels.add(key, tints[blank], faces(b.c0, b.c1, b.z0, b.z1), b.wall)
    storeys = cells.take(cells.bay == 0)
    glazed = np.zeros(len(edges.length_m), bool)
    glazed[cells.wall[cells.open]] = True
    cells, tints = cells.take(cells.open), tints[cells.open]
    s0, s1, wall = cells.c0, cells.c1, cells.wall
    middle = cells.z0 + params.sill_m + params.head_m
    n = np.full(len(s0), _BACK_M)
    # Spandrels hide the slab: opaque glass, or sheet in the frame's colour.
    if params.spandrel_glass:
        dark = 0.8 * np.asarray(params.glass) * rng.uniform(0.93, 1.07, (len(s0), 1))
        lean = _leans(rng, s0, s1, cells.z0, middle)
        made = panes(s0, s1, cells.z0, middle, n, lean)
        panels.add(("coated_glass", "building"), dark, made, wall)
    else:
        panels.add(key, tints, faces(s0, s1, cells.z0, middle, n), wall)
    # Blinds hang as the rooms behind them go: whole runs of bays alike.
    room = (cells.wall * 97 + cells.storey) * 64 + cells.bay // 3
    _, room = np.unique(room, return_inverse=True)
    drop = np.where(rng.random(room.max() + 1) < 0.3, rng.uniform(0.15, 1.0, room.max() + 1), 0.0)
    drop = np.where(rng.random(len(s0)) < 0.85, drop[room], 0.0)
    tall = cells.z1 - middle
    cut = np.where(drop > 0.93, middle, cells.z1 - drop * tall)
    lean = _leans(rng, s0, s1, middle, cells.z1)
    covered, clear = drop > 0.05, cut > middle
    made = panes(s0, s1, middle, cells.z1, n, lean, high=np.where(covered, cut, cells.z1))
    tint = pane_tints(params, rng, len(s0))
    panels.add(("coated_glass", "building"), tint[clear], made.take(clear), wall[clear])
    made = panes(s0, s1, middle, cells.z1, n, lean, low=cut).take(covered)
    cloth = 0.6 * cloth_tints(rng, room.max() + 1)[room]
    panels.add(("curtained_glass", "building"), cloth[covered], made, wall[covered])
    _mullions(panels, params, edges, cells)
    _transoms(panels, params, edges, storeys.take(glazed[storeys.wall]))


def _mullions(panels: Panels, params: "Tower", edges: Edges, cells: Cells) -> None:
    """Uprights at every bay, over the whole height of their tier."""
    lowest = np.array([max(t.first, 1) for t in params.tiers])[edges.tier[cells.wall]]
    c = cells.take(cells.storey == lowest)
    tier = edges.tier[c.wall]
    low = params.levels_m[lowest[cells.storey == lowest]]
    high = params.levels_m[np.array([t.last for t in params.tiers])[tier]]
    inner = c.bay > 0
    out = np.where(c.bay % params.fin_bays == 0, params.fin_m, 0.05)
    made = block(c.c0 - 0.03, c.c0 + 0.03, low, high, -0.08, out, "flr").take(inner)
    panels.add(_PAINT, params.frame, made, c.wall[inner])
    # Ends are wider: they close the corner against the next wall.
    for end, at in ((c.bay == 0, c.c0), (c.bay == c.bays - 1, c.c1 - 0.1)):
        made = block(at, at + 0.1, low, high, -0.1, 0.05, "flr").take(end)
        panels.add(_PAINT, params.frame, made, c.wall[end])


def _transoms(panels: Panels, params: "Tower", edges: Edges, storeys: Cells) -> None:
    """Level bars above and below the spandrels, along whole walls."""
    length = edges.length_m[storeys.wall]
    for z in (storeys.z0, storeys.z0 + params.sill_m + params.head_m):
        bar = block(np.zeros(len(z)), length, z - 0.03, z + 0.03, -0.08, 0.03, "ftb")
        panels.add(_PAINT, params.frame, bar, storeys.wall)
    if params.rows > 1:
        z = storeys.z1 - 0.28 * (storeys.z1 - storeys.z0)
        bar = block(np.zeros(len(z)), length, z - 0.02, z + 0.02, -0.08, 0.03, "ftb")
        panels.add(_PAINT, params.frame, bar, storeys.wall)
