"""What runs along walls: cornices, string courses, parapets, quoins, downpipes, murals."""

from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.materials.city import POSTER_COLUMNS, POSTER_M, POSTER_ROWS
from synthdepth.maps.towers.facades import Cells
from synthdepth.maps.towers.massing import Edges, Tier
from synthdepth.maps.towers.panels import Panels, block, faces, quads_of, sweep

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

# Steps (out, up) [m] of profiles, from the wall below to the wall above.
_CORNICES = {
    "stone": [(0, -0.9), (0.1, -0.85), (0.1, -0.6), (0.2, -0.5), (0.55, -0.35), (0.6, -0.3),
              (0.6, -0.12), (0.68, -0.02), (0.68, 0.05), (0, 0.12)],
    "brick": [(0, -0.6), (0.06, -0.6), (0.06, -0.4), (0.12, -0.4), (0.12, -0.2), (0.18, -0.2),
              (0.18, 0.0), (0, 0.03)],
    "thin": [(0, -0.28), (0.12, -0.28), (0.12, 0.0), (0, 0.02)],
}  # fmt: skip
_COURSE = [(0, -0.22), (0.09, -0.2), (0.12, -0.06), (0.12, 0.0), (0, 0.04)]
_FASCIA = [(0, -0.55), (0.05, -0.52), (0.05, -0.3), (0.22, -0.14), (0.28, -0.1), (0.28, 0.0),
           (0, 0.06)]  # fmt: skip


def _raised(profile, z: float, least_out: float = 0.0) -> list[tuple[float, float]]:
    return [(out + least_out * (out > 0), z + up) for out, up in profile]


def add_mouldings(panels: Panels, params: "Tower", detail: int) -> None:
    """Cornices under the parapets, a moulding over the ground floor, courses between storeys."""
    trim = (params.trim[0], "building")
    deep = params.pilaster_m if params.pilaster_m > 0.08 and params.skin == "punched" else 0.0
    for tier in params.tiers:
        if params.cornice == "none":
            continue
        # Over the parapet's foot; it stands over the pilasters too.
        profile = _raised(_CORNICES[params.cornice], params.levels_m[tier.last] + 0.1, deep)
        if detail < 2:
            out = max(p[0] for p in profile)
            z0, z1 = profile[0][1], profile[-1][1]
            profile = [(0, z0), (out, (z0 + z1) / 2), (out, z1), (0, z1 + 0.02)]
        key = (params.wall[0], "building") if params.cornice == "brick" else trim
        tint = params.wall[1] if params.cornice == "brick" else params.trim[1]
        shade = np.clip(0.8 + 0.5 * np.array([p[0] for p in profile]), None, 1.0)
        sweep(panels, key, tint, tier.polygon, profile, tier.street, shade)
        if params.cornice == "stone" and detail == 2:
            _dentils(panels, tier, trim, params.trim[1], profile, deep)
    if params.skin == "curtain" or detail < 2:
        return
    base = params.tiers[0]
    if params.cornice in ("stone", "brick") or params.rusticated:
        profile = _raised(_FASCIA, params.levels_m[1], deep)
        sweep(panels, trim, params.trim[1], base.polygon, profile, base.street)
    if params.courses:
        for tier in params.tiers:
            storeys = range(max(tier.first, 1) + params.courses, tier.last, params.courses)
            for storey in storeys:
                profile = _raised(_COURSE, params.levels_m[storey], deep)
                sweep(panels, trim, params.trim[1], tier.polygon, profile, tier.street)


def _dentils(panels: Panels, tier: Tier, key, tint, profile, deep: float) -> None:
    """Brackets under a cornice's overhang, every 0.7 m, in the frames of the tier's walls."""
    z = profile[3][1]
    starts, walls = [], []
    for i in np.flatnonzero(tier.street):
        length = np.linalg.norm(tier.polygon[(i + 1) % len(tier.polygon)] - tier.polygon[i])
        count = max(2, round(length / 0.7))
        starts.append((np.arange(count) + 0.5) * length / count)
        walls.append(np.full(count, i))
    if not starts:
        return
    at, wall = np.concatenate(starts), np.concatenate(walls)
    first = panels.frames_of(tier.polygon)
    made = block(at - 0.11, at + 0.11, z - 0.28, z + 0.12, 0.0, deep + 0.42, "flrb")
    panels.add(key, tint, made, wall + first)


def _streaks(panels: Panels, params: "Tower", tier: Tier, top: float, rng) -> None:
    """Tongues of dirt that run down from the coping, in the wall's own texture."""
    length = np.linalg.norm(np.roll(tier.polygon, -1, axis=0) - tier.polygon, axis=1)
    count = (length * rng.uniform(0.3, 0.9)).astype(int)
    wall = np.repeat(np.arange(len(length)), count)
    at = rng.uniform(0.1, 0.9, len(wall)) * length[wall]
    half = rng.uniform(0.05, 0.22, len(wall))
    deep = rng.uniform(0.5, 0.95, len(wall)) * (tier.parapet_m + params.head_m - 0.15)
    m = 0.006
    tongue = quads_of(
        (
            *(at - 0.3 * half, m, top - deep, at + 0.2 * half, m, top - deep),
            *(at + half, m, top - 0.07, at - half, m, top - 0.07),
        ),
        [0],
    )
    shade = np.ones((len(wall), 1, 4))
    shade[:, 0, 2:] = rng.uniform(0.5, 0.8, (len(wall), 1))
    shade[:, 0, :2] = 0.93
    first = panels.frames_of(tier.polygon)
    key = (params.wall[0], "building")
    panels.add(key, params.wall[1], tongue, wall + first, shade)


def add_parapets(panels: Panels, params: "Tower", rng: np.random.Generator, detail: int) -> None:
    """The walls round the roofs, with their copings."""
    key = (params.wall[0], "building")
    clad = params.skin == "curtain" or params.wall[0] == "cladding"
    coping = (("metal", "roof"), (0.8, 0.8, 0.8)) if clad else (
        (params.trim[0], "roof"), params.trim[1]
    )  # fmt: skip
    for tier in params.tiers:
        z = float(params.levels_m[tier.last])
        top = z + tier.parapet_m
        outer = [(0, z), (0, top)]
        sweep(panels, key, params.wall[1], tier.polygon, outer, shade=(1.0, 0.86))
        inner = [(-0.26, top), (-0.26, z - 0.02)]
        sweep(panels, key, np.asarray(params.wall[1]) * 0.92, tier.polygon, inner)
        profile = [(-0.002, top - 0.06), (0.035, top - 0.06), (0.035, top + 0.03)]
        profile += [(-0.295, top + 0.05), (-0.295, top - 0.05), (-0.258, top - 0.05)]
        if detail < 2:
            profile = [(0, top), (-0.26, top)]
        sweep(panels, *coping, tier.polygon, profile)
        if detail == 2 and params.cornice in ("none", "thin") and params.skin != "curtain":
            _streaks(panels, params, tier, top, rng)


def add_downpipes(panels: Panels, params: "Tower", edges: Edges, cells: Cells, rng) -> None:
    """A pipe with brackets near an end of the walls, from the parapet to the pavement."""
    if params.skin == "curtain":
        return
    pierced = edges.street.copy()
    pierced[cells.wall[cells.open]] = True
    walls = np.flatnonzero((edges.tier == 0) & pierced & (rng.random(len(pierced)) < 0.75))
    if not len(walls):
        return
    at = np.where(rng.random(len(walls)) < 0.5, 0.14, edges.length_m[walls] - 0.14)
    top = params.levels_m[params.tiers[0].last] - 0.75
    n = 0.14 + (params.pilaster_m if params.pilaster_m > 0.08 else 0.0) * edges.street[walls]
    pipe = block(at - 0.05, at + 0.05, -0.05, top, n, n + 0.1, "flr")
    colour = (0.1, 0.1, 0.1) if rng.random() < 0.5 else (0.4, 0.4, 0.39)
    panels.add(("paint", "building"), colour, pipe, walls)
    head = block(at - 0.13, at + 0.13, top, top + 0.28, 0.0, n + 0.16, "flrtb")
    panels.add(("paint", "building"), colour, head, walls)
    heights = np.arange(2.0, top, 3.0)
    o, z = np.repeat(np.arange(len(walls)), len(heights)), np.tile(heights, len(walls))
    clip = block(at[o] - 0.08, at[o] + 0.08, z, z + 0.05, 0.0, n[o] + 0.12, "flrtb")
    panels.add(("paint", "building"), colour, clip, walls[o])


def add_mural(panels: Panels, params: "Tower", edges: Edges, cells: Cells, rng) -> None:
    """On some blank party walls, an advertisement painted or pasted high up."""
    blank = np.ones(len(edges.tier), bool)
    blank[cells.wall[cells.open]] = False
    blank &= (edges.tier == 0) & (edges.length_m > 9)
    top = float(params.levels_m[params.tiers[0].last])
    for w in np.flatnonzero(blank & (rng.random(len(blank)) < 0.35)):
        high = min(rng.uniform(5, 9), top - 6)
        wide = min(rng.uniform(0.8, 1.3) * high, edges.length_m[w] - 3)
        if high < 4:
            continue
        a, z = rng.uniform(1.5, edges.length_m[w] - wide - 1.4), top - 1.2 - high
        quad = faces(np.array([a]), a + wide, z, z + high, 0.02)
        place = panels.in_world(quad, w)
        cell = np.array([rng.integers(POSTER_COLUMNS), rng.integers(POSTER_ROWS)])
        uv = POSTER_M * (np.array([[0, 0], [1, 0], [1, 1], [0, 1]]) + cell)
        panels.add_world(("poster", "building"), place[0], uv[None], (0.85, 0.85, 0.85))
