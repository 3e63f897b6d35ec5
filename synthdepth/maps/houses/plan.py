"""Where the walls of a house stand and where their openings go."""

import dataclasses
import itertools
import math
from typing import TYPE_CHECKING

import numpy as np

from synthdepth.maps.houses.openings import Opening, Wall
from synthdepth.maps.houses.roofs import Rect, Roof

if TYPE_CHECKING:
    from synthdepth.maps.houses.house import House

# Floor to floor; how far walls go below the ground, which may slope; heads of windows and doors
# above their floor [m].
STOREY_M, BASE_M = 2.8, -0.5
_HEAD_M, _DOOR_M, _GARAGE_DOOR_M = 2.14, 2.08, 2.2


@dataclasses.dataclass(frozen=True, kw_only=True)
class Block:
    """A rectangle with walls and a roof.

    Attributes:
        role: "main", "wing", "garage" or "dormer".
        rect: outer faces of its walls (x0, y0, x1, y1) [m].
        roof_rect: what its roof spans; reaches into a neighbour where roofs meet.
        plate_m: top of the walls.
        storeys: number of floors; 0 for a dormer.
        roof: its roof.
        base_m: foot of the walls.
        door_m: width of the garage door.
    """

    role: str
    rect: Rect
    roof_rect: Rect
    plate_m: float
    storeys: int
    roof: Roof
    base_m: float = BASE_M
    door_m: float = 0.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Garage:
    """A garage door: its centre at ground level and its width [m]."""

    x_m: float
    y_m: float
    width_m: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Porch:
    """Entrance: "stoop", "portico", "full" or "canopy" over `rect`, its floor at `floor_m`."""

    kind: str
    rect: Rect
    floor_m: float
    railing: bool


@dataclasses.dataclass(frozen=True, kw_only=True)
class Chimney:
    """A stack of masonry from `foot_m` to `top_m`."""

    rect: Rect
    foot_m: float
    top_m: float


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bay:
    """A bay window on the ground floor, centred on (x, y) of a front wall [m]."""

    x_m: float
    y_m: float
    width_m: float
    depth_m: float = 0.65

    @property
    def outline(self) -> list[tuple[float, float]]:
        """Its four corners in plan, counter-clockwise."""
        x, y, w, d = self.x_m, self.y_m, self.width_m / 2, self.depth_m
        return [(x, y - w), (x + d, y - w + d), (x + d, y + w - d), (x, y + w)]


def side_wall(rect: Rect, side: int) -> tuple[tuple, tuple, float]:
    """Origin, direction and length of a side: 0 at low y, 1 front, 2 at high y, 3 back."""
    x0, y0, x1, y1 = rect
    return [
        ((x0, y0), (1.0, 0.0), x1 - x0),
        ((x1, y0), (0.0, 1.0), y1 - y0),
        ((x1, y1), (-1.0, 0.0), x1 - x0),
        ((x0, y1), (0.0, -1.0), y1 - y0),
    ][side]


def free_spans(blocks, number: int, side: int, storey: int, more=()) -> list[tuple[float, float]]:
    """Stretches of one side of a block that no other block covers on that storey.

    `more` holds further rectangles to keep clear of. Positions are along the wall [m].
    """
    (ox, oy), (dx, dy), length = side_wall(blocks[number].rect, side)
    covered = []
    others = [
        (b.rect, 0.35, b.storeys + (b.roof.form in ("gable", "hip")))
        for k, b in enumerate(blocks)
        if k != number and b.role != "dormer"
    ]
    for (x0, y0, x1, y1), margin, storeys in [*others, *((r, 0.2, 9) for r in more)]:
        line, low, high = (oy, y0, y1) if dx else (ox, x0, x1)
        if storey < storeys and low - 0.3 < line < high + 0.3:
            a, b = ((x0 - ox) * dx, (x1 - ox) * dx) if dx else ((y0 - oy) * dy, (y1 - oy) * dy)
            covered.append((min(a, b) - margin, max(a, b) + margin))
    spans, at = [], 0.0
    for a, b in sorted(covered):
        if a > at:
            spans.append((at, min(a, length)))
        at = max(at, b)
    if at < length:
        spans.append((at, length))
    return [(a, b) for a, b in spans if b - a > 0.9 and a < length]


def _hidden(blocks, number: int, side: int) -> bool:
    """Whether the main block swallows this side of another block."""
    if number == 0:
        return False
    (ox, oy), (dx, dy), length = side_wall(blocks[number].rect, side)
    x0, y0, x1, y1 = blocks[0].rect
    ends = ((ox, oy), (ox + dx * length, oy + dy * length))
    return all(x0 < x < x1 and y0 < y < y1 for x, y in ends)


def swallowed(house: "House", block, x: float, y: float) -> bool:
    """Whether the point (x, y) of a block's wall lies within another, no lower block."""
    return any(
        b is not block
        and b.role != "dormer"
        and b.rect[0] - 0.05 < x < b.rect[2] + 0.05
        and b.rect[1] - 0.05 < y < b.rect[3] + 0.05
        and b.plate_m > block.plate_m - 0.3
        for b in house.blocks
    )


def _without(spans, s: float, half: float):
    """Spans with the stretch around `s` taken out."""
    out = []
    for a, b in spans:
        if a < s < b:
            out += [(a, s - half), (s + half, b)]
        else:
            out.append((a, b))
    return [(a, b) for a, b in out if b - a > 0.9]


def _windows(house: "House", rng, spans, wall, floor, side, storey, openings, shy) -> None:
    """Windows along free spans: evenly set, of three sizes, some left out (`shy`)."""
    width, height = house.window_size_m
    edge = 0.3 + house.finish.casing_m
    for a, b in spans:
        w, h, kind = width, height, house.window
        if b - a < w + 2 * edge:
            w, h, kind = 0.6, 0.9, "double_hung" if house.finish.casing_m else "fixed"
            if b - a < w + 2 * edge:
                continue
        gap = 1.3 if side in (1, 3) else 2.2
        count = max(1, int((b - a - 0.3) / (w + gap)))
        for k in range(count):
            roll = rng.random(3)
            if roll[0] < shy:
                continue
            s = a + (b - a) * (k + 0.5) / count
            kw, kh, kkind = w, h, kind
            if side != 1 and roll[1] < 0.22:
                kw, kh = 0.65, 0.75
                kkind = "double_hung" if house.finish.casing_m else "fixed"
            elif storey == 0 and roll[1] > 0.7 and (b - a) / count > 1.75 * w + 2 * edge:
                kw = 1.7 * w
                if house.window in ("double_hung", "four_over_one", "casement"):
                    kkind = "picture"
            elif house.window in ("fixed", "ribbon") and roll[2] < 0.3:
                kw, kh, kkind = (0.8, 2.0, "shaft") if roll[2] < 0.15 else (2.0, 0.6, "ribbon")
                kw = min(kw, (b - a) / count - 2 * edge)
            top = floor + _HEAD_M
            shutters = house.shutters and side == 1 and (b - a) / count > 1.95 * kw + 2 * edge
            shutters = shutters and kw < 1.5
            openings.append(Opening(wall, s - kw / 2, s + kw / 2, top - kh, top, kkind, shutters))


def _front_door(house: "House", rng, spans, wall, openings):
    """Entrance with, sometimes, sidelights; returns the spans that it leaves."""
    main = house.blocks[0].rect
    s, floor = house.door_y_m - main[1], house.plinth_m
    openings.append(Opening(wall, s - 0.5, s + 0.5, floor, floor + _DOOR_M, house.entrance_kind))
    half = 0.5
    gap = 2 * house.finish.casing_m + 0.08
    lights = rng.random() < 0.35
    if lights and any(a < s - 1.05 - gap and s + 1.05 + gap < b for a, b in spans):
        for c in (s - 0.5 - gap - 0.17, s + 0.5 + gap + 0.17):
            z = floor + 0.3
            openings.append(Opening(wall, c - 0.17, c + 0.17, z, floor + _DOOR_M, "sidelight"))
        half = 0.5 + gap + 0.34
    return _without(spans, s, half + house.finish.casing_m + 0.15)


def _block_walls(house: "House", rng, number: int, detail: int, walls, openings) -> None:
    blocks, block = house.blocks, house.blocks[number]
    garage = block.role == "garage"
    more = []
    if house.chimney is not None and house.chimney.foot_m < 0:
        more.append(house.chimney.rect)
    for side in range(4):
        if _hidden(blocks, number, side):
            continue
        origin, along, length = side_wall(block.rect, side)
        if garage and side == 1:
            key = (house.lower[0], "building")
            walls.append(Wall(origin, along, length, BASE_M, block.plate_m, key, house.lower[1]))
            half, top = block.door_m / 2, 0.03 + _GARAGE_DOOR_M
            mid = length / 2
            kind = house.garage_kind
            if kind.startswith("garage_4") and block.door_m > 4:
                kind = kind.replace("4", "8", 1)
            openings.append(Opening(len(walls) - 1, mid - half, mid + half, 0.03, top, kind))
            continue
        key, tint = (house.plinth[0], "building"), house.plinth[1]
        walls.append(Wall(origin, along, length, BASE_M, house.plinth_m, key, tint))
        for storey in range(block.storeys):
            floor = house.plinth_m + STOREY_M * storey
            top = block.plate_m if storey == block.storeys - 1 else floor + STOREY_M
            skin = house.upper if storey else house.lower
            key = (skin[0], "building")
            walls.append(Wall(origin, along, length, floor, top, key, skin[1]))
            wall = len(walls) - 1
            spans = free_spans(blocks, number, side, storey, more)
            if garage:
                spans = [] if side == 3 else spans
                if spans and rng.random() < 0.5:
                    a, b = max(spans, key=lambda span: span[1] - span[0])
                    s, z = (a + b) / 2, floor + 1.0
                    if b - a > 1.6:
                        openings.append(
                            Opening(wall, s - 0.45, s + 0.45, z, z + 0.9, "double_hung")
                        )
                continue
            if number == 0 and side == 1 and storey == 0:
                spans = _front_door(house, rng, spans, wall, openings)
            if house.bay is not None and block.role == "wing" and side == 1 and storey == 0:
                spans = []
            if number == 0 and side == 3 and storey == 0 and house.deck is not None:
                s = block.rect[3] - (house.deck[1] + house.deck[3]) / 2
                half = 0.9
                if any(a < s - half - 0.2 and s + half + 0.2 < b for a, b in spans):
                    hole = Opening(wall, s - half, s + half, floor, floor + 2.08, "garden_door")
                    openings.append(hole)
                    spans = _without(spans, s, half + house.finish.casing_m + 0.15)
            shy = (0.4, 0.0, 0.4, 0.12)[side] if detail else (0.5, 0.0, 0.5, 0.3)[side]
            _windows(house, rng, spans, wall, floor, side, storey, openings, shy)


def _dormer_walls(house: "House", block: Block, walls, openings) -> None:
    key = (house.gable[0], "building")
    for side in range(3):
        origin, along, length = side_wall(block.rect, side)
        walls.append(Wall(origin, along, length, block.base_m, block.plate_m, key, house.gable[1]))
        if side == 1:
            mid, half, top = length / 2, length / 2 - 0.38, block.plate_m - 0.14
            kind = house.window if house.finish.casing_m else "casement"
            wall = len(walls) - 1
            openings.append(Opening(wall, mid - half, mid + half, top - 0.95, top, kind))


def _bay_walls(house: "House", bay: Bay, walls, openings) -> None:
    corners = bay.outline
    floor, top = house.plinth_m, house.plinth_m + 2.32
    for (ax, ay), (bx, by) in itertools.pairwise(corners):
        length = math.hypot(bx - ax, by - ay)
        along = ((bx - ax) / length, (by - ay) / length)
        key = (house.lower[0], "building")
        walls.append(Wall((ax, ay), along, length, BASE_M, top, key, house.lower[1]))
        edge = 0.12 + house.finish.casing_m
        kind = house.window if house.window not in ("picture", "ribbon") else "fixed"
        hole = Opening(len(walls) - 1, edge, length - edge, floor + 0.6, floor + _HEAD_M, kind)
        openings.append(hole)


def lay_out(
    house: "House", rng: np.random.Generator, detail: int
) -> tuple[list[Wall], list[Opening]]:
    """All walls of a house and their openings."""
    walls: list[Wall] = []
    openings: list[Opening] = []
    for number, block in enumerate(house.blocks):
        if block.role == "dormer":
            _dormer_walls(house, block, walls, openings)
        else:
            _block_walls(house, rng, number, detail, walls, openings)
    if house.bay is not None and detail:
        _bay_walls(house, house.bay, walls, openings)
    return walls, openings
