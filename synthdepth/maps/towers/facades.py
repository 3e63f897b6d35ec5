"""Walls as cells (storey x bay), and the façade that each level of detail makes of them."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from synthdepth.maps.towers.massing import Edges
from synthdepth.maps.towers.panels import Panels, faces

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

# Height below which walls are dirtier [m].
_SOILED_M = 14.0


class Cells(NamedTuple):
    """Cells of walls: all (k,).

    Attributes:
        wall: number of the wall.
        storey: from the ground floor, 0.
        bay: number along the wall.
        bays: bays of that wall.
        c0, c1: extent along the wall [m]; the outer bays reach its ends.
        mid: middle of the bay [m].
        width: width of the bay [m].
        z0, z1: floor and the floor above [m].
        open: has a window.
        street: lies on a street side.
        balcony: has a balcony.
    """

    wall: np.ndarray
    storey: np.ndarray
    bay: np.ndarray
    bays: np.ndarray
    c0: np.ndarray
    c1: np.ndarray
    mid: np.ndarray
    width: np.ndarray
    z0: np.ndarray
    z1: np.ndarray
    open: np.ndarray
    street: np.ndarray
    balcony: np.ndarray

    def take(self, rows) -> "Cells":
        """Some of the cells."""
        return Cells(*(a[rows] for a in self))


def cells_of(params: "Tower", edges: Edges, rng: np.random.Generator) -> Cells:
    """The cells of all walls above the ground floor."""
    lots = []
    levels, curtain = params.levels_m, params.skin == "curtain"
    for w, length in enumerate(edges.length_m):
        tier = params.tiers[edges.tier[w]]
        margin = 0.0 if curtain else min(params.margin_m, 0.12 * length)
        bays = max(1, round((length - 2 * margin) / params.bay_m))
        width = (length - 2 * margin) / bays
        street = bool(edges.street[w])
        # A party wall is blank, or has a few columns of stairs and bathrooms.
        share = 1.0 if street else rng.choice([0.0, 0.12, 0.3, 1.0], p=[0.35, 0.3, 0.25, 0.1])
        has_window = rng.random(bays) < share
        has_balcony = (rng.random(bays) < params.balconies * street) & has_window
        storeys = np.arange(max(tier.first, 1), tier.last)
        storey, bay = (a.ravel() for a in np.meshgrid(storeys, np.arange(bays), indexing="ij"))
        left, one = margin + width * bay, np.ones(len(bay))
        # No balcony on the first storey of a tier, over a terrace or a shop's sign.
        reached = storey > max(tier.first, 1)
        lots.append(
            (
                *(w * one.astype(int), storey, bay, bays * one.astype(int)),
                *(np.where(bay == 0, 0.0, left), np.where(bay == bays - 1, length, left + width)),
                *(left + width / 2, width * one, levels[storey], levels[storey + 1]),
                *(has_window[bay], street * one.astype(bool), has_balcony[bay] & reached),
            )
        )
    return Cells(*(np.concatenate(a) for a in zip(*lots, strict=True)))


def soiling(z) -> np.ndarray:
    """Multiplier of a wall's reflectance at height z [m]: soot and splash near the street."""
    return 0.86 + 0.14 * np.clip(np.asarray(z) / _SOILED_M, 0, 1)


def wall_tints(params: "Tower", cells: Cells, rng: np.random.Generator) -> np.ndarray:
    """(k, 3) tint of each cell's wall: storeys and panels of slightly different batches."""
    spread = {"cladding": 0.03, "concrete": 0.03}.get(params.wall[0], 0.012)
    by_storey = rng.normal(0, spread * 0.6, params.storeys + 1)[cells.storey]
    # Rain runs down the same columns of bays.
    by_bay = rng.normal(0, 0.02, 997)[(cells.wall * 131 + cells.bay) % 997]
    each = rng.normal(0, spread, len(cells.wall))
    light = np.exp(by_storey + by_bay + each) * soiling(cells.z0)
    return light[:, None] * np.asarray(params.wall[1])


def openings(params: "Tower", cells: Cells) -> tuple[np.ndarray, ...]:
    """s0, s1, y0, y1 of each cell's window [m]."""
    half = params.window_width / 2 * cells.width
    s0, s1 = cells.mid - half, cells.mid + half
    y0 = np.where(cells.balcony, cells.z0 + 0.16, cells.z0 + params.sill_m)
    y1 = cells.z1 - params.head_m
    if params.skin == "ribbon":
        # A pier every few bays, where the columns stand.
        pier = (cells.bay % params.pier_bays == 0) & (cells.bay > 0)
        s0 = np.where(pier, s0 + 0.45, s0)
    return s0, s1, y0, y1


def pane_tints(params: "Tower", rng: np.random.Generator, count: int) -> np.ndarray:
    """(count, 3) tints of panes, each room a little different."""
    return rng.uniform(0.7, 1.3, (count, 1)) * np.asarray(params.glass)


def cloth_tints(rng: np.random.Generator, count: int) -> np.ndarray:
    """(count, 3) reflectances of blinds and curtains behind glass."""
    hue = np.array([[1.0, 0.97, 0.9], [1.0, 0.9, 0.74], [0.92, 0.97, 1.0], [0.9, 0.75, 0.65]])
    return rng.uniform(0.14, 0.5, (count, 1)) * hue[rng.choice(4, count, p=[0.6, 0.2, 0.15, 0.05])]


def far_walls(panels: Panels, params: "Tower", edges: Edges, cells: Cells, rng) -> None:
    """Detail 0: one textured rectangle a wall, and a few panes that can be lit at night."""
    cell_m = 3.15  # of the far façades' textures, FAR_CELL_M
    curtain = params.skin == "curtain"
    material, tint = ("facade_glass", params.glass) if curtain else (
        "facade_windows", _as_paint(params)
    )  # fmt: skip
    for w, length in enumerate(edges.length_m):
        own = cells.take(cells.wall == w)
        tier = params.tiers[edges.tier[w]]
        first = max(tier.first, 1)
        z0, z1 = params.levels_m[first], params.levels_m[tier.last]
        quad = faces(np.array([0.0]), length, z0, z1)
        if not own.open.any():
            panels.add((params.wall[0], "building"), params.wall[1], quad, w)
            continue
        # The texture's cells are stretched to this wall's.
        bays = own.bays[0] / (2 if curtain else 1)
        shift = cell_m * rng.integers(0, 6, 2)
        uv = np.array([[0, 0], [bays, 0], [bays, tier.last - first], [0, tier.last - first]])
        x, y, dx, dy = panels.frames[w]
        corners = quad.corners[0, 0]
        world = np.column_stack([x + corners[:, 0] * dx, y + corners[:, 0] * dy, corners[:, 2]])
        panels.add_world((material, "building"), world[None], (cell_m * uv + shift)[None], tint)
    few = cells.take(rng.permutation(np.flatnonzero(cells.open))[:30])
    s0, s1, y0, y1 = openings(params, few)
    pane = faces(s0 + 0.05, s1 - 0.05, y0, y1, 0.03)
    panels.add(("glass", "building"), pane_tints(params, rng, len(s0)), pane, few.wall)


def _as_paint(params: "Tower") -> np.ndarray:
    """The wall's reflectance: concrete holds its own, the rest have it in the tint."""
    scale = 0.28 if params.wall[0] == "concrete" else 1.0
    return scale * np.asarray(params.wall[1])


def plain_walls(panels: Panels, params: "Tower", edges: Edges, cells: Cells, rng) -> None:
    """Detail 1: a band of wall each storey, windows as panes 1 cm in front of it."""
    first = cells.take(cells.bay == 0)
    tints = wall_tints(params, first, rng)
    band = faces(np.zeros(len(first.wall)), edges.length_m[first.wall], first.z0, first.z1)
    if params.skin == "curtain" and params.spandrel_glass:
        spandrel = 0.8 * np.asarray(params.glass)
        panels.add(("coated_glass", "building"), spandrel, band, first.wall)
    else:
        panels.add((params.wall[0], "building"), tints, band, first.wall)
    seen = cells.take(cells.open)
    if params.skin == "curtain":
        s0, s1 = seen.c0 + 0.04, seen.c1 - 0.04
        y0, y1 = seen.z0 + params.sill_m + params.head_m, seen.z1 - 0.04
    else:
        s0, s1, y0, y1 = openings(params, seen)
    pane = faces(s0, s1, y0, y1, 0.01)
    clad = rng.random(len(s0)) < 0.2
    material = "coated_glass" if params.skin == "curtain" else "glass"
    panels.add(
        (material, "building"), pane_tints(params, rng, (~clad).sum()), pane.take(~clad),
        seen.wall[~clad],
    )  # fmt: skip
    panels.add(
        ("curtained_glass", "building"), cloth_tints(rng, clad.sum()), pane.take(clad),
        seen.wall[clad],
    )  # fmt: skip
