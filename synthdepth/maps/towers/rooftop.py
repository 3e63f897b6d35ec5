"""Roofs: their surfaces, plant rooms, and how much of what stands on them."""

from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.towers import roof_items
from synthdepth.maps.towers.massing import grown
from synthdepth.maps.towers.panels import Panels, cover, faces, slopes
from synthdepth.maps.towers.roof import Roof

if TYPE_CHECKING:
    from synthdepth.maps.towers.tower import Tower

_METAL, _PAINT = ("metal", "roof"), ("paint", "roof")


def add_roofs(panels: Panels, params: "Tower", rng: np.random.Generator, detail: int) -> None:
    """Roof surfaces of all tiers, and what stands on them."""
    for i, tier in enumerate(params.tiers):
        z = float(params.levels_m[tier.last])
        inner = grown(tier.polygon, -0.2)
        cover(panels, (params.roof, "roof"), (1, 1, 1), inner, z)
        top = i == len(params.tiers) - 1
        above = () if top else params.tiers[i + 1].polygon
        roof = Roof(panels, tier.polygon, z, above)
        if top:
            _plant(roof, params, rng, detail)
        if detail == 2:
            _furnish(roof, params, rng, top)
        elif detail == 1 and top:
            _outline(roof, params, rng)


def _plant(roof: Roof, params: "Tower", rng: np.random.Generator, detail: int) -> None:
    """Lift overruns and plant rooms; a screened plant storey and a mast on the tallest."""
    key, tint = (params.wall[0], "roof"), np.asarray(params.wall[1]) * 0.95
    tall = params.storeys >= 18
    sizes = [np.minimum([rng.uniform(0.35, 0.6), rng.uniform(0.4, 0.6)] * roof.reach * 2, 24.0)]
    sizes = sizes if tall else [rng.uniform([3.5, 3.0], [7.0, 4.6])]
    if rng.random() < 0.6:
        sizes.append(rng.uniform([2.4, 2.4], [4.2, 3.6]))
    for size in sizes:
        at = roof.spot(rng, size, edge_m=1.6 if tall else 1.2)
        if at is None:
            continue
        s, n = at
        high = rng.uniform(4.0, 6.5) if tall and size is sizes[0] else rng.uniform(2.5, 3.6)
        roof.box(key, tint, s, n, (*size, high + 0.05), -0.05)
        if detail == 0:
            continue
        lid = (size[0] + 0.3, size[1] + 0.3, 0.14)
        roof.box(("roof_felt", "roof"), (1.1, 1.1, 1.1), s, n, lid, high, "flrtkb")
        if detail < 2:
            continue
        _louvres(roof, s, n, size, high, rng)
        if rng.random() < 0.6:
            x, y = s + 0.3 * size[0], n - 0.2 * size[1]
            roof.rods(_METAL, (0.8, 0.8, 0.8), (x, y, high), (x, y, high + 1.6), 0.12, 8)
        if tall and size is sizes[0]:
            roof_items.mast(
                roof, s, n, high + 0.14, rng.uniform(7, 14 + 0.25 * params.storeys), rng
            )


def _louvres(roof: Roof, s, n, size, high: float, rng) -> None:
    """A door and louvres on the front of a plant room, flush ladders on its side."""
    front = n + size[1] / 2
    x = s - size[0] / 2 + 0.5
    z = roof.z
    leaf = faces(np.array([x]), x + 0.95, z, z + 2.05, front + 0.02)
    roof.panels.add(_PAINT, rng.uniform(0.05, 0.35) * np.ones(3), leaf, roof.frame)
    wide = size[0] - 2.4
    if wide > 0.6:
        k = np.arange(int((high - 0.8) / 0.16))
        low = z + 0.4 + 0.16 * k
        left = np.full(len(k), x + 1.3)
        slat = slopes(left, left + wide, front + 0.07, low, front + 0.006, low + 0.14)
        roof.panels.add(_PAINT, (0.26, 0.27, 0.27), slat, roof.frame)
    side = s + size[0] / 2 + 0.12
    key, grey = ("paint", "barrier"), (0.3, 0.3, 0.3)
    for y in (n - 0.2, n + 0.2):
        roof.rods(key, grey, (side, y, 0), (side, y, high + 1.0), 0.02, 4)
    z = np.arange(0.3, high + 0.8, 0.3)
    rung = np.stack([np.full_like(z, side), np.full_like(z, n - 0.2), z], 1)
    roof.rods(key, grey, rung, rung + [0, 0.4, 0], 0.012, 3)


def _is_old(params: "Tower") -> bool:
    return params.wall[0] in ("brick", "stone", "plaster")


def _outline(roof: Roof, params: "Tower", rng: np.random.Generator) -> None:
    """Of what stands on a roof, that which shows against the sky from afar."""
    if _is_old(params) and params.storeys >= 5 and rng.random() < 0.7:
        roof_items.water_tank(roof, rng)
    at = roof.spot(rng, (2.6, 2.6), 0.3)
    if at and rng.random() < 0.6:
        roof_items.mast(roof, *at, 0.0, rng.uniform(4.0, 8.0), rng)
    for _ in range(int(min(2, roof.area_m2 / 150))):
        roof_items.air_handlers(roof, rng)


def _furnish(roof: Roof, params: "Tower", rng: np.random.Generator, top: bool) -> None:
    """Machines, pipes, tanks, aerials, skylights: about one a 40 m² of free roof."""
    count = int(min(16, roof.area_m2 / 38 * (1.0 if top else 0.35)) * rng.uniform(0.7, 1.3))
    old = _is_old(params)
    if top and old and params.storeys >= 5 and rng.random() < 0.7:
        roof_items.water_tank(roof, rng)
    if top and params.storeys <= 9 and rng.random() < 0.3:
        roof_items.billboard(roof, rng)
    makers = {
        roof_items.air_handlers: 5.0,
        roof_items.duct: 2.5,
        roof_items.vents: 3.0,
        roof_items.skylight: 1.5 if params.storeys < 12 else 0.3,
        roof_items.whips: 2.0,
        roof_items.dish: 1.2,
        roof_items.panels_antenna: 1.5,
        roof_items.pipes: 2.0,
        roof_items.solar: 0.8,
        roof_items.stack: 1.0 if old else 0.1,
        roof_items.hatch: 1.0,
    }
    share = np.array(list(makers.values()))
    kinds = list(makers)
    for k in rng.choice(len(kinds), count, p=share / share.sum()):
        kinds[k](roof, rng)
    if top and rng.random() < 0.6:
        at = roof.spot(rng, (2.6, 2.6), 0.3)
        if at:
            roof_items.mast(roof, *at, 0.0, rng.uniform(4.0, 8.0), rng)
    if not old or rng.random() < 0.4:
        _railing(roof)


def _railing(roof: Roof) -> None:
    """A steel railing on feet, inside the parapet."""
    ring = roof.local(grown(roof.foot, -0.75))
    key, tint = ("metal", "barrier"), (0.9, 0.9, 0.9)
    stop = np.roll(ring, -1, axis=0)
    for z in (0.6, 1.12):
        a, b = (np.column_stack([p, np.full(len(p), z)]) for p in (ring, stop))
        roof.rods(key, tint, a, b, 0.02, 4)
    posts = []
    for a, b in zip(ring, stop, strict=True):
        count = max(2, int(np.linalg.norm(b - a) / 1.8))
        posts.append(a + (b - a) * (np.arange(count) / count)[:, None])
    at = np.concatenate(posts)
    low, high = (np.column_stack([at, np.full(len(at), z)]) for z in (-0.02, 1.12))
    roof.rods(key, tint, low, high, 0.02, 4)
