"""Parts of a house beside walls and roofs: porch, deck, chimney, bay, boards."""

import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.houses.facets import Facets, add_column
from synthdepth.maps.houses.plan import swallowed
from synthdepth.maps.houses.roofs import Roof, add_roof

if TYPE_CHECKING:
    from synthdepth.maps.houses.house import House

_PAINT, _PAVED = ("paint", "building"), ("concrete", "pavement")
_RAIL = ("paint", "barrier")


def _post(facets: Facets, house: "House", x, y, low, high) -> None:
    trim = house.finish.trim

    def block(key, tint, half, z0, z1):
        facets.box(key, tint, (x - half, y - half, z0), (x + half, y + half, z1))

    if house.columns == "round":
        block(_PAINT, trim, 0.15, low - 0.02, low + 0.1)
        add_column(facets, _PAINT, trim, x, y, 0.11, low + 0.1, high - 0.08)
        block(_PAINT, trim, 0.14, high - 0.08, high + 0.02)
    elif house.columns == "tapered":
        pier = house.plinth if house.plinth[0] == "brick" else house.lower
        block((pier[0], "building"), pier[1], 0.26, low - 0.05, low + 0.85)
        block(_PAVED, (1, 1, 1), 0.3, low + 0.85, low + 0.92)
        a, b, z0, z1 = 0.19, 0.12, low + 0.92, high + 0.01
        for ux, uy in ((1, 0), (0, 1), (-1, 0), (0, -1)):
            left, right = (-uy, ux), (uy, -ux)
            corners = [
                (x + r * (ux + d[0]), y + r * (uy + d[1]), z)
                for d, r, z in ((right, a, z0), (left, a, z0), (left, b, z1), (right, b, z1))
            ]
            facets.quad(_PAINT, trim, *corners)
    else:
        half = 0.045 if house.columns == "steel" else 0.075
        block(_PAINT, trim, half, low - 0.02, high + 0.01)


def _railing(facets: Facets, tint, start, stop, floor, height=0.95) -> None:
    """Rails and balusters between two points in plan, along x or y."""
    (ax, ay), (bx, by) = start, stop
    length = math.hypot(bx - ax, by - ay)
    if length < 0.4:
        return
    along_x = abs(bx - ax) > abs(by - ay)
    ex, ey = (0.0, 0.03) if along_x else (0.03, 0.0)
    low, high = (min(ax, bx), min(ay, by)), (max(ax, bx), max(ay, by))
    for z, h in ((0.08, 0.05), (height - 0.05, 0.06)):
        facets.box(
            _RAIL,
            tint,
            (low[0] - ex, low[1] - ey, floor + z),
            (high[0] + ex, high[1] + ey, floor + z + h),
        )
    count = max(1, round(length / 0.2))
    for k in range(1, count):
        x, y = ax + (bx - ax) * k / count, ay + (by - ay) * k / count
        facets.box(
            _RAIL,
            tint,
            (x - 0.015, y - 0.015, floor + 0.12),
            (x + 0.015, y + 0.015, floor + height - 0.03),
        )


def _steps(facets: Facets, x, y, half, floor, key, tint) -> None:
    """Steps from (x, y) down towards +x, risers of 0.18 m at most."""
    count = math.ceil(floor / 0.18)
    for k in range(1, count):
        top = floor * (1 - k / count)
        low = (x + 0.29 * (k - 1), y - half, -0.4)
        facets.box(key, tint, low, (x + 0.29 * k, y + half, top))


def add_porch(facets: Facets, house: "House", detail: int) -> None:
    """Floor, steps, posts, railing and roof of the entrance."""
    porch, trim = house.porch, house.finish.trim
    x0, y0, x1, y1 = porch.rect
    floor, door = porch.floor_m, house.door_y_m
    wood = porch.kind == "full" and house.lower[0] in ("siding", "wood")
    deck = (("wood", "pavement"), (0.24, 0.22, 0.20)) if wood else (_PAVED, (0.95, 0.95, 0.95))
    facets.box(*deck, (x0 - 0.05, y0, -0.4), (x1, y1, floor))
    width = min(0.75, door - y0, y1 - door)
    _steps(facets, x1, door, width, floor, *deck)
    head = floor + 2.42
    if porch.kind == "canopy":
        facets.box(_PAINT, trim, (x0 - 0.05, y0 - 0.15, head - 0.06), (x1, y1 + 0.15, head + 0.12))
        if detail and x1 - x0 > 1.2:
            _post(facets, house, x1 - 0.12, y0 + 0.05, floor, head - 0.06)
        return
    if porch.kind == "stoop":
        if detail:
            if porch.railing and floor > 0.25:
                for y in (y0 + 0.05, y1 - 0.05):
                    _railing(facets, house.finish.frame, (x0, y), (x1 - 0.05, y), floor)
            low = (x0 - 0.02, door - 0.8, head - 0.06)
            facets.box(_PAINT, trim, low, (x0 + 0.7, door + 0.8, head + 0.02))
        return
    beam = (head - 0.02, head + 0.2)
    for low, high in (
        ((x1 - 0.26, y0 + 0.06), (x1 - 0.06, y1 - 0.06)),
        ((x0 - 0.05, y0 + 0.06), (x1 - 0.26, y0 + 0.2)),
        ((x0 - 0.05, y1 - 0.2), (x1 - 0.26, y1 - 0.06)),
    ):
        facets.box(_PAINT, trim, (*low, beam[0]), (*high, beam[1]))
    ys = [y0 + 0.3, y1 - 0.3]
    if porch.kind == "full":
        # Posts flank the steps and stand at most 3.2 m apart.
        flank = [y for y in (door - width - 0.2, door + width + 0.2) if y0 + 1 < y < y1 - 1]
        ys = sorted([*ys, *flank])
        for a, b in itertools.pairwise(tuple(ys)):
            ys += np.linspace(a, b, math.ceil((b - a) / 3.2) + 1)[1:-1].tolist()
        ys.sort()
    if detail:
        for y in ys:
            _post(facets, house, x1 - 0.3, y, floor, head)
    else:
        for y in (ys[0], ys[-1]):
            low = (x1 - 0.4, y - 0.09, floor - 0.02)
            facets.box(_PAINT, trim, low, (x1 - 0.22, y + 0.09, head))
    cover = house.cover
    if porch.kind == "portico":
        roof = Roof(
            form="gable",
            ridge="x",
            pitch_deg=max(20.0, house.blocks[0].roof.pitch_deg),
            eaves_m=0.22,
            rake_m=0.22,
            ends=("inner", "gable"),
            capped=False,
        )
        rect = (x0 - 0.9, y0, x1, y1)
        add_roof(facets, rect, beam[1], roof, cover, trim, None, house.gable, detail)
    else:
        top, low = beam[1] + 0.38, beam[1] - 0.02
        _lean_to(facets, house, (x0 - 0.02, y0 - 0.15, x1 + 0.2, y1 + 0.15), low, top)
    if detail and porch.railing and porch.kind == "full" and house.columns != "steel":
        gap = width + 0.05
        edge = x1 - 0.3
        stops = sorted([*ys, door - gap, door + gap])
        for a, b in itertools.pairwise(stops):
            if not door - gap <= (a + b) / 2 <= door + gap:
                _railing(facets, trim, (edge, a + 0.09), (edge, b - 0.09), floor)
        for y in (y0 + 0.3, y1 - 0.3):
            _railing(facets, trim, (x0, y), (edge - 0.1, y), floor)


def _lean_to(facets: Facets, house: "House", rect, low, top) -> None:
    """A roof that falls from the wall at x0 to x1: covering, underside, boards."""
    x0, y0, x1, y1 = rect
    t, trim, key = 0.14, house.finish.trim, ("paint", "roof")
    cover = house.cover if house.cover[0] != "gravel" else ("paint", trim)
    a, b, c, d = (x1, y0, low + t), (x1, y1, low + t), (x0, y1, top + t), (x0, y0, top + t)
    facets.quad((cover[0], "roof"), cover[1], a, b, c, d)

    def under(p):
        return (p[0], p[1], p[2] - t)

    facets.quad(key, [0.8 * v for v in trim], under(b), under(a), under(d), under(c))
    for p, q in ((a, b), (b, c), (d, a)):
        facets.quad(key, trim, under(p), under(q), q, p)
    # Cheeks between roof and beam.
    for y, sign in ((y0 + 0.22, 1), (y1 - 0.22, -1)):
        foot = [(x0, y, low - 0.05), (x1 - 0.3, y, low - 0.05), (x0, y, top + 0.02)]
        if sign < 0:
            foot = [foot[1], foot[0], foot[2]]
        facets.quad(_PAINT, trim, *foot, foot[2])


def add_chimney(facets: Facets, house: "House", detail: int) -> None:
    """A stack with shoulders where it stands outside, a cap and pots."""
    chimney = house.chimney
    if chimney is None:
        return
    x0, y0, x1, y1 = chimney.rect
    material, tint = house.lower
    if material not in ("brick", "plaster"):
        tint = house.plinth[1] if house.plinth[0] == "brick" else (0.2, 0.1, 0.07)
        material = "brick"
    key, top = (material, "roof"), chimney.top_m
    if chimney.foot_m < 0:
        shoulder = min(2.6, 0.5 * top)
        facets.box(
            (material, "building"), tint, (x0 - 0.25, y0, chimney.foot_m), (x1 + 0.25, y1, shoulder)
        )
        # Weathered shoulders.
        for a, b in ((x0 - 0.25, x0), (x1 + 0.25, x1)):
            slope = [(a, y0, shoulder), (a, y1, shoulder), (b, y1, shoulder + 0.35)]
            slope.append((b, y0, shoulder + 0.35))
            facets.quad(key, tint, *(slope if a > b else slope[1::-1] + slope[:1:-1]))
            for y, flip in ((y0, a < b), (y1, a > b)):
                side = [(a, y, shoulder), (b, y, shoulder), (b, y, shoulder + 0.35)]
                if not flip:
                    side = [side[1], side[0], side[2]]
                facets.quad(key, tint, *side, side[2])
        facets.box(key, tint, (x0, y0, shoulder), (x1, y1, top))
    else:
        facets.box(key, tint, (x0, y0, chimney.foot_m), (x1, y1, top))
    grey, cap = (0.85, 0.85, 0.83), ("concrete", "roof")
    if detail:
        facets.box(key, tint, (x0 - 0.04, y0 - 0.04, top - 0.28), (x1 + 0.04, y1 + 0.04, top - 0.1))
    facets.box(cap, grey, (x0 - 0.07, y0 - 0.07, top - 0.01), (x1 + 0.07, y1 + 0.07, top + 0.07))
    if detail:
        y = (y0 + y1) / 2
        for x in (x0 + 0.18, x1 - 0.18):
            add_column(facets, ("brick", "roof"), (0.26, 0.13, 0.09), x, y, 0.1, top, top + 0.36)


def add_bay_roof(facets: Facets, house: "House") -> None:
    """The low hipped roof of a bay window."""
    bay = house.bay
    if bay is None:
        return
    p, low, top = np.array(bay.outline), house.plinth_m + 2.3, house.plinth_m + 2.68
    centre = np.array([bay.x_m, bay.y_m])
    out = centre + (p - centre) * 1.12 + [0.02, 0.0]
    out[[0, 3], 0] = bay.x_m - 0.02
    inner = p[[0, 0, 3, 3]] * 0.45 + centre * 0.55
    inner[:, 0] = bay.x_m - 0.01
    for k in range(3):
        a, b = out[k], out[k + 1]
        c, d = inner[min(k + 1, 2) if k else 0], inner[1 if k < 2 else 2]
        corners = [(*a, low + 0.1), (*b, low + 0.1), (*c, top), (*d, top)]
        facets.quad((house.cover[0], "roof"), house.cover[1], *corners)
        board = [(*a, low), (*b, low), (*b, low + 0.1), (*a, low + 0.1)]
        facets.quad(("paint", "roof"), house.finish.trim, *board)
    soffit = [(*q, low) for q in out[::-1]]
    facets.quad(("paint", "roof"), house.finish.trim, *soffit)


def _wall_box(facets: Facets, wall, tint, s0, s1, z0, z1, out, key=_PAINT) -> None:
    """A board on an axis-aligned wall."""
    (ox, oy), (dx, dy) = wall.origin, wall.direction
    nx, ny = dy, -dx
    xs = (ox + s0 * dx - 0.01 * nx, ox + s1 * dx + out * nx)
    ys = (oy + s0 * dy - 0.01 * ny, oy + s1 * dy + out * ny)
    back = {(0, -1): 2, (1, 0): 3, (0, 1): 0, (-1, 0): 1}[round(nx), round(ny)]
    facets.box(key, tint, (min(xs), min(ys), z0), (max(xs), max(ys), z1), back)


def add_boards(facets: Facets, house: "House", walls, openings) -> None:
    """Corner boards, belt courses, half-timbering and gable brackets."""
    trim = house.finish.trim
    if house.corner_boards:
        for block in house.blocks:
            if block.role == "dormer":
                continue
            x0, y0, x1, y1 = block.rect
            low, high = house.plinth_m - 0.02, block.plate_m - 0.02
            for x, sx in ((x0, -1), (x1, 1)):
                for y, sy in ((y0, -1), (y1, 1)):
                    if swallowed(house, block, x, y):
                        continue
                    xs, ys = (x + 0.022 * sx, x - 0.1 * sx), (y + 0.022 * sy, y - 0.1 * sy)
                    facets.box(_PAINT, trim, (min(xs), min(ys), low), (max(xs), max(ys), high))
    holes: dict[int, list] = {}
    for o in openings:
        holes.setdefault(o.wall, []).append(o)
    belt = house.upper[0] != house.lower[0]
    for number, wall in enumerate(walls):
        if abs(wall.direction[0] * wall.direction[1]) > 1e-6 or wall.low_m < 1:
            continue
        if belt and wall.high_m - wall.low_m > 2:
            z = wall.low_m
            _wall_box(facets, wall, trim, 0.0, wall.length_m, z - 0.1, z + 0.1, 0.03)
        if house.timbering and wall.high_m - wall.low_m > 2:
            _timber(facets, wall, trim, holes.get(number, []), house.finish.casing_m)
    for block in house.blocks:
        _gable_boards(facets, house, block)


def _timber(facets: Facets, wall, tint, holes, casing: float) -> None:
    """Posts about every 0.9 m and a rail, clear of the openings."""
    low, high = wall.low_m + 0.1, wall.high_m - 0.02
    rail = wall.low_m + 0.85
    count = max(2, round(wall.length_m / 0.9))
    edges = [(o.s0 - casing - 0.06, o.s1 + casing + 0.06) for o in holes]
    for s in np.linspace(0.09, wall.length_m - 0.09, count + 1):
        if not any(a - 0.07 < s < b + 0.07 for a, b in edges):
            _wall_box(facets, wall, tint, s - 0.07, s + 0.07, low, high, 0.03)
    at = 0.16
    for a, b in [*sorted(edges), (wall.length_m - 0.16, 0)]:
        if a - at > 0.3:
            _wall_box(facets, wall, tint, at, a, rail, rail + 0.13, 0.022)
        at = b


def _gable_boards(facets: Facets, house: "House", block) -> None:
    """Timbering, a louvred vent or brackets in the gables that face the street or the sides."""
    roof = block.roof
    if roof.form != "gable" or block.role == "dormer":
        return
    x0, y0, x1, y1 = block.roof_rect
    along_x = roof.ridge == "x"
    half = (y1 - y0 if along_x else x1 - x0) / 2
    tan, trim = math.tan(math.radians(roof.pitch_deg)), house.finish.trim
    for end, kind in enumerate(roof.ends):
        if kind != "gable":
            continue
        if along_x:
            origin, way = ((x1, y0), (0.0, 1.0)) if end else ((x0, y1), (0.0, -1.0))
        else:
            origin, way = ((x1, y1), (-1.0, 0.0)) if end else ((x0, y0), (1.0, 0.0))
        wall = _Gable(origin, way)
        plate = block.plate_m
        if house.timbering:
            _wall_box(facets, wall, trim, 0.15, 2 * half - 0.15, plate - 0.06, plate + 0.12, 0.036)
            for s in np.linspace(0, 2 * half, max(3, round(2 * half / 0.8)) + 1)[1:-1]:
                top = plate + (half - abs(s - half)) * tan
                if top - plate > 0.35:
                    _wall_box(facets, wall, trim, s - 0.06, s + 0.06, plate + 0.12, top, 0.022)
        elif half * tan > 1.2:
            z = plate + 0.52 * half * tan
            _wall_box(facets, wall, trim, half - 0.3, half + 0.3, z, z + 0.62, 0.03)
            dark = [0.35 * t for t in trim]
            for k in range(5):
                a = z + 0.07 + 0.1 * k
                _wall_box(facets, wall, dark, half - 0.23, half + 0.23, a, a + 0.05, 0.036)
        if house.brackets:
            for s in (0.35, half, 2 * half - 0.35):
                z = plate + (half - abs(s - half)) * tan - 0.12
                reach = roof.rake_m - 0.05
                _wall_box(facets, wall, trim, s - 0.06, s + 0.06, z - 0.08, z + 0.08, reach)
                _wall_box(facets, wall, trim, s - 0.05, s + 0.05, z - 0.55, z - 0.08, 0.1)


class _Gable:
    """Just enough of a wall to nail boards to."""

    def __init__(self, origin, direction) -> None:
        self.origin, self.direction = origin, direction


def add_deck(facets: Facets, house: "House") -> None:
    """A raised wooden deck with railing and steps, or a paved patio, behind the house."""
    if house.deck is None:
        return
    x0, y0, x1, y1 = house.deck
    if not house.deck_is_wood:
        facets.box(("paving", "pavement"), (1, 1, 1), (x0, y0, -0.3), (x1 + 0.05, y1, 0.05))
        step = (x1 - 0.45, (y0 + y1) / 2 - 0.95, -0.3)
        high = (x1 + 0.04, (y0 + y1) / 2 + 0.95, house.plinth_m / 2 + 0.03)
        facets.box(_PAVED, (1, 1, 1), step, high)
        return
    floor, key, tint = house.plinth_m - 0.04, ("wood", "pavement"), (0.26, 0.19, 0.13)
    facets.box(key, tint, (x0, y0, floor - 0.04), (x1 + 0.05, y1, floor))
    dark = [0.7 * t for t in tint]
    facets.box(key, dark, (x0 + 0.06, y0 + 0.06, -0.3), (x1 + 0.05, y1 - 0.06, floor - 0.04))
    mid, half = (y0 + y1) / 2, 0.7
    count = math.ceil(floor / 0.18)
    for k in range(1, count):
        low = (x0 - 0.29 * k, mid - half, -0.3)
        facets.box(key, tint, low, (x0 - 0.29 * (k - 1), mid + half, floor * (1 - k / count)))
    rail = house.finish.trim if sum(house.finish.trim) > 1 else tint
    edge = x0 + 0.06
    for a, b in (((edge, y0 + 0.06), (edge, mid - half)), ((edge, mid + half), (edge, y1 - 0.06))):
        _railing(facets, rail, a, b, floor)
    for y in (y0 + 0.06, y1 - 0.06):
        _railing(facets, rail, (edge, y), (x1, y), floor)
    for x, y in ((edge, y0 + 0.06), (edge, mid - half), (edge, mid + half), (edge, y1 - 0.06)):
        facets.box(_RAIL, rail, (x - 0.05, y - 0.05, -0.3), (x + 0.05, y + 0.05, floor + 1.05))
