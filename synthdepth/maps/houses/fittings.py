"""Fittings on walls and roofs: downpipes, lamp, meter, air conditioner, vents, dish, solar."""

import math
from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.geometry import cross
from synthdepth.maps.houses.facets import Facets, add_column
from synthdepth.maps.houses.plan import swallowed
from synthdepth.maps.houses.roofs import roof_height

if TYPE_CHECKING:
    from synthdepth.maps.houses.house import House

_PAINT, _PAVED = ("paint", "building"), ("concrete", "pavement")


def add_fittings(facets: Facets, house: "House", rng: np.random.Generator, openings) -> None:
    """Downpipes, lamps, meter, air conditioner, vents, dish and solar panels."""
    main = house.blocks[0]
    x0, y0, x1, y1 = main.rect
    _downpipes(facets, house)
    grey = (0.9, 0.9, 0.9)
    # Lamp beside the door, or beyond its sidelights.
    lights = any(o.kind == "sidelight" for o in openings)
    beside = 0.76 + (2 * house.finish.casing_m + 0.42 if lights else 0.0)
    y, z = house.door_y_m + beside, house.plinth_m + 1.75
    facets.box(
        _PAINT, (0.05, 0.05, 0.05), (x1 - 0.02, y - 0.06, z), (x1 + 0.14, y + 0.06, z + 0.28)
    )
    side = y0 if rng.random() < 0.5 else y1
    sign = 1 if side == y1 else -1
    clear = all(b is main or b.rect[3] < side - 0.3 or b.rect[1] > side + 0.3 for b in house.blocks)
    if clear:
        near = sorted((side - 0.02 * sign, side + 0.14 * sign))
        x = x0 + 0.38
        box = (x, near[0], 1.2), (x + 0.28, near[1], 1.75)
        facets.box(_PAINT, (0.32, 0.33, 0.33), *box)
        if rng.random() < 0.7:
            a = sorted((side + 0.3 * sign, side + 1.1 * sign))
            x = x0 + rng.uniform(1.6, 3.0)
            facets.box(_PAVED, (1, 1, 1), (x - 0.1, a[0] - 0.1, -0.2), (x + 0.9, a[1] + 0.1, 0.07))
            tint = (0.42, 0.41, 0.38)
            facets.box(_PAINT, tint, (x, a[0], 0.06), (x + 0.8, a[1], 0.85))
            mid = (a[0] + a[1]) / 2
            add_column(facets, _PAINT, (0.06, 0.06, 0.06), x + 0.4, mid, 0.3, 0.84, 0.9, 10)
    roof = main.roof

    def height(x, y):
        return roof_height(main.roof_rect, main.plate_m, roof, x, y)

    # Vents and pipes keep to the rear slope, panels have it to themselves.
    for _ in range(0 if house.solar else int(rng.integers(1, 4))):
        x = x0 + (x1 - x0) * rng.uniform(0.12, 0.38)
        y = y0 + (y1 - y0) * rng.uniform(0.2, 0.8)
        z = height(x, y)
        if rng.random() < 0.6:
            add_column(facets, ("metal", "roof"), grey, x, y, 0.05, z - 0.1, z + 0.4, 6)
        else:
            low = (x - 0.18, y - 0.18, z - 0.15)
            facets.box(("metal", "roof"), (0.8, 0.8, 0.8), low, (x + 0.18, y + 0.18, z + 0.2))
    if roof.form in ("slab", "parapet"):
        x, y, z = x1 * 0.4, y0 * 0.45, main.plate_m
        facets.box(("metal", "roof"), grey, (x, y, z), (x + 1.1, y + 0.8, z + 0.75))
    if rng.random() < 0.3:
        x, y = x0 * 0.75, (y1 if rng.random() < 0.5 else y0) * 0.7
        _dish(facets, x, y, height(x, y))
    if house.solar:
        _solar(facets, house, rng)


def _downpipes(facets: Facets, house: "House") -> None:
    """Square pipes from the gutters to the ground, near a front and a rear corner of each block."""
    tint = house.gutter
    for block in house.blocks:
        if block.role == "dormer" or block.roof.form in ("slab", "parapet"):
            continue
        x0, y0, x1, y1 = block.rect
        drop = block.roof.eaves_m * math.tan(math.radians(block.roof.pitch_deg))
        top, reach = block.plate_m - drop + 0.03, block.roof.eaves_m + 0.05
        feet = [((x1, y1 - 0.3), (1, 0)), ((x0, y0 + 0.3), (-1, 0))]
        if block.roof.ridge == "x":
            feet = [((x1 - 0.3, y0), (0, -1)), ((x0 + 0.3, y1), (0, 1))]
        for (x, y), (nx, ny) in feet:
            if swallowed(house, block, x + 0.2 * nx, y + 0.2 * ny):
                continue
            cx, cy = x + 0.05 * nx, y + 0.05 * ny
            low, high = (cx - 0.035, cy - 0.035, -0.05), (cx + 0.035, cy + 0.035, top - 0.25)
            facets.box(_PAINT, tint, low, high)
            # The swan neck from the wall out to the gutter, a sheared box.
            ex, ey, wx, wy = x + reach * nx, y + reach * ny, -0.035 * ny, 0.035 * nx
            a, b = (cx - wx, cy - wy, top - 0.27), (cx + wx, cy + wy, top - 0.27)
            c, d = (ex + wx, ey + wy, top), (ex - wx, ey - wy, top)
            upper = [(px, py, pz + 0.07) for px, py, pz in (a, b, c, d)]
            facets.quad(_PAINT, tint, *upper[::-1])
            facets.quad(_PAINT, tint, a, b, c, d)
            facets.quad(_PAINT, tint, c, b, upper[1], upper[2])
            facets.quad(_PAINT, tint, a, d, upper[3], upper[0])


def _dish(facets: Facets, x, y, z) -> None:
    """A satellite dish, 0.7 m wide, tilted up."""
    key, tint = ("metal", "roof"), (1, 1, 1)
    facets.box(key, tint, (x - 0.025, y - 0.025, z - 0.1), (x + 0.025, y + 0.025, z + 0.55))
    turn = 2 * np.pi * np.arange(9) / 8
    face = np.array([-0.6, 0.55, 0.58])
    face /= np.linalg.norm(face)
    u = cross([0, 0, 1.0], face)
    u /= np.linalg.norm(u)
    v = cross(face, u)
    centre = np.array([x, y, z + 0.6]) + 0.08 * face
    rim = centre + 0.35 * (np.cos(turn)[:, None] * u + np.sin(turn)[:, None] * v)
    back = np.broadcast_to(centre - 0.1 * face, (8, 3))
    facets.add(("paint", "roof"), (0.55, 0.55, 0.53), np.stack([rim[:-1], rim[1:], back, back], 1))


def _solar(facets: Facets, house: "House", rng: np.random.Generator) -> None:
    """Rows of panels of 1.0 x 1.65 m, 9 cm above the larger slope."""
    main = house.blocks[0]
    x0, y0, x1, y1 = main.roof_rect
    roof = main.roof
    if roof.form not in ("gable", "hip", "slab", "parapet"):
        return
    pitch = math.radians(roof.pitch_deg)
    along_y = roof.ridge == "y"
    run = ((x1 - x0) if along_y else (y1 - y0)) / 2
    length = (y1 - y0) if along_y else (x1 - x0)
    if roof.form == "hip":
        length = max(0.0, length - 1.4 * run)
    rows = min(2, int((run / math.cos(pitch) - 0.9) / 1.68))
    columns = min(6, int((length - 2.4) / 1.02))
    if rows < 1 or columns < 2:
        return
    flat = roof.form in ("slab", "parapet")
    tilt = math.radians(12) if flat else pitch
    k, r = np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij")
    k, r = k.ravel(), r.ravel()
    shift = rng.uniform(-0.5, 0.5) * (length - 2.2 - 1.02 * columns)
    s0 = (k - columns / 2) * 1.02 + shift
    t0 = 0.5 + r * (2.1 if flat else 1.68)
    # Rear slope: up the slope is +x where the ridge runs along y.
    lift = 0.3 if flat else 0.16 + 0.09 / math.cos(pitch)
    tt = np.stack([t0, t0, t0 + 1.65, t0 + 1.65], 1)
    ss = np.stack([s0, s0 + 1.0, s0 + 1.0, s0], 1)
    rise = tt * math.sin(tilt) if not flat else (tt - t0[:, None]) * math.sin(tilt)
    z = main.plate_m + lift + rise
    across = tt * math.cos(tilt)
    if along_y:
        corners = np.stack([x0 + across, (y0 + y1) / 2 - ss, z], -1)
    else:
        corners = np.stack([(x0 + x1) / 2 + ss, y0 + across, z], -1)
    facets.add(("glass", "roof"), (0.9, 0.95, 1.1), corners)
    low = corners - [0, 0, 0.05]
    if flat:
        # Ballasted trays, closed against the wind.
        low[..., 2] = main.plate_m - 0.02
    edge = np.concatenate(
        [
            np.stack([low[:, a], low[:, b], corners[:, b], corners[:, a]], 1)
            for a, b in ((0, 1), (1, 2), (2, 3), (3, 0))
        ]
    )
    facets.add(("metal", "roof"), (0.9, 0.9, 0.9), edge)
