"""Detached houses: parameters, their draw, and assembly.

A house is one to four blocks (main block, wing towards the street, garage, dormers), each a
rectangle with its own roof; storeys of 2.8 m on a plinth, openings 0.1-0.2 m deep, porch, deck,
chimney and the small things on walls and roofs.

Frame: origin at the centre of the main block on the ground, +x towards the street.
"""

import dataclasses
import math

import numpy as np

from synthdepth.maps.geometry import Geometry
from synthdepth.maps.houses import fittings as house_fittings
from synthdepth.maps.houses import parts as house_parts
from synthdepth.maps.houses.facets import Facets
from synthdepth.maps.houses.massing import Massing, draw_blocks, mirrored
from synthdepth.maps.houses.openings import OpeningFinish, add_walls
from synthdepth.maps.houses.plan import (
    BASE_M,
    Bay,
    Block,
    Chimney,
    Garage,
    Porch,
    Rect,
    free_spans,
    lay_out,
)
from synthdepth.maps.houses.roofs import add_roof, ridge_height
from synthdepth.maps.houses.styles import STYLES, Style, Tint
from synthdepth.seeding import lane

Finish = tuple[str, Tint]


@dataclasses.dataclass(frozen=True, kw_only=True)
class House:
    """One house; lengths in metres, colours linear RGB.

    Attributes:
        style: one of STYLES.
        seed: of what is too small to choose: pane tilt, blinds, which windows are left out.
        blocks: the main block first, then wing, garage and dormers.
        plinth_m: height of the ground floor.
        lower, upper, gable, plinth, cover: (material, tint) of walls, base and roof.
        finish: of all openings.
        window: kind of window.
        window_size_m: (width, height).
        entrance_kind, garage_kind: kinds of door.
        gutter: tint of gutters and downpipes.
        door_y_m: centre of the front door.
        porch, chimney, bay, deck: parts, or None.
        deck_is_wood: a raised deck rather than a patio.
        shutters, corner_boards, timbering, brackets, solar: whether it has them.
        columns: kind of porch post.
    """

    style: str
    seed: int
    blocks: tuple[Block, ...]
    plinth_m: float
    lower: Finish
    upper: Finish
    gable: Finish
    plinth: Finish
    cover: Finish
    finish: OpeningFinish
    window: str
    window_size_m: tuple[float, float]
    entrance_kind: str
    garage_kind: str
    gutter: Tint
    door_y_m: float
    porch: Porch
    chimney: Chimney | None
    bay: Bay | None
    deck: Rect | None
    deck_is_wood: bool
    shutters: bool
    corner_boards: bool
    timbering: bool
    brackets: bool
    solar: bool
    columns: str

    @property
    def footprint(self) -> list[Rect]:
        """Rectangles (x0, y0, x1, y1) [m] that it covers: blocks, porch with steps, deck."""
        rects = [b.rect for b in self.blocks if b.role != "dormer"]
        x0, y0, x1, y1 = self.porch.rect
        rects.append((x0, y0, max(x1, self.entrance[0]), y1))
        if self.deck is not None:
            rects.append(self.deck)
        return rects

    @property
    def bounds(self) -> Rect:
        """The smallest rectangle [m] around the footprint."""
        r = np.array(self.footprint)
        return (*map(float, r[:, :2].min(0)), *map(float, r[:, 2:].max(0)))

    @property
    def driveway(self) -> Garage | None:
        """Where the garage door is, at ground level; it faces +x. None without a garage."""
        for block in self.blocks:
            if block.role == "garage":
                _, y0, x1, y1 = block.rect
                return Garage(x_m=x1, y_m=(y0 + y1) / 2, width_m=block.door_m)
        return None

    @property
    def entrance(self) -> tuple[float, float]:
        """Foot of the front steps (x, y) [m], where the path arrives."""
        steps = math.ceil(self.porch.floor_m / 0.18)
        return (self.porch.rect[2] + 0.29 * steps, self.door_y_m)


def _pick(rng: np.random.Generator, choices):
    return choices[int(rng.random() * len(choices))]


def _weighted(rng: np.random.Generator, names, weights) -> str:
    at = rng.random() * sum(weights)
    for name, weight in zip(names, weights, strict=True):
        at -= weight
        if at < 0:
            return name
    return names[0]


def _tint(rng: np.random.Generator, tint: Tint) -> Tint:
    """The same paint from another bucket, some years older."""
    level = math.exp(0.09 * rng.standard_normal())
    r, g, b = 1 + 0.025 * rng.standard_normal(3)
    return (
        min(0.78, tint[0] * level * r),
        min(0.78, tint[1] * level * g),
        min(0.78, tint[2] * level * b),
    )


def _finish(rng: np.random.Generator, choice: tuple[str, tuple[Tint, ...]]) -> Finish:
    material, tints = choice
    tint = _pick(rng, tints)
    # Materials that hold their colour keep a tint near 1.
    return material, tint if material in ("concrete", "gravel") else _tint(rng, tint)


def _draw_porch(rng, s: Style, m: Massing, blocks) -> tuple[Porch, float]:
    """The porch and the y of the front door."""
    spans = free_spans(blocks, 0, 1, 0)
    low, high = max(spans, key=lambda span: span[1] - span[0])
    low, high = low - m.width_m / 2, high - m.width_m / 2
    at = rng.choice([0.5, 0.5, 0.3, 0.7])
    door_y = float(np.clip(low + at * (high - low), low + 0.95, high - 0.95))
    kind = _weighted(rng, ("stoop", "portico", "full", "canopy"), s.porch)
    front = m.depth_m / 2
    if kind == "full" and high - low < 3.0:
        kind = "portico"
    if kind == "portico" and (high - low < 2.6 or m.flat):
        kind = "stoop"
    floor = m.plinth_m - 0.03
    if kind == "full":
        rect = (front, low + 0.1, front + rng.uniform(1.7, 2.4), high - 0.1)
    else:
        half = {"stoop": 0.75, "portico": 1.3, "canopy": 1.1}[kind]
        half = min(half, (high - low) / 2 - 0.05)
        centre = float(np.clip(door_y, low + half, high - half))
        depth = {"stoop": 1.1, "portico": 1.5, "canopy": 1.3}[kind]
        rect = (front, centre - half, front + depth, centre + half)
    return Porch(kind=kind, rect=rect, floor_m=floor, railing=bool(rng.random() < 0.6)), door_y


def _draw_chimney(rng, m: Massing, blocks) -> Chimney:
    main = blocks[0]
    top = ridge_height(main.roof_rect, main.plate_m, main.roof) + rng.uniform(0.45, 0.9)
    x, half = rng.uniform(-0.25, 0.15) * m.depth_m, rng.uniform(0.3, 0.42)
    sides = [k for k in (0, 2) if free_spans(blocks, 0, k, 0) == [(0.0, m.depth_m)]]
    if sides and main.roof.ridge == "y" and main.roof.form == "gable" and rng.random() < 0.65:
        sign = 1 if _pick(rng, sides) == 2 else -1
        near, far = mirrored(sign, m.width_m / 2, m.width_m / 2 + 0.5)
        rect = (x - half - 0.05, near - 0.05, x + half + 0.05, far)
        if near < 0:
            rect = (rect[0], near, rect[2], far + 0.05)
        return Chimney(rect=rect, foot_m=BASE_M, top_m=top)
    y = rng.uniform(-0.3, 0.3) * m.width_m
    rect = (x - half, y - half, x + half, y + half)
    return Chimney(rect=rect, foot_m=main.plate_m - 0.3, top_m=top)


def draw_house(
    rng: np.random.Generator, style: str, lot_width_m: float, lot_depth_m: float
) -> House:
    """Choose a house of one style for a lot.

    Args:
        rng: source of all choices.
        style: one of STYLES.
        lot_width_m: along the street; 1.7 m stays free on both sides.
        lot_depth_m: away from it; 15 m stay free in front and behind together.
    """
    if style not in STYLES:
        raise KeyError(f"house style {style!r} is not one of {sorted(STYLES)}")
    s = STYLES[style]
    room_w, room_d = max(7.0, lot_width_m - 3.4), max(10.0, lot_depth_m - 15.0)
    width = min(rng.uniform(*s.width_m), room_w)
    depth = min(rng.uniform(*s.depth_m), room_d - 2.5)
    garage = _weighted(rng, ("none", "side", "front", "detached"), s.garage)
    garage_w = 6.0 if rng.random() < 0.7 else 3.6
    if garage == "side":
        if room_w - garage_w < 8.0:
            garage_w = 3.6
        width = min(width, room_w - garage_w)
    elif garage == "front":
        width = min(width, room_w - 1.0)
        if width < 10.5:
            garage_w = 3.6
    elif garage == "detached":
        width = min(width, room_w - 4.2)
    if garage != "none" and (width < 7.0 or (garage == "detached" and room_d < depth + 4.5)):
        garage, width = "none", max(width, 7.0)
    beside = {"side": garage_w, "detached": 4.2}.get(garage, 0.0)
    storeys = 2 if rng.random() < s.two_storeys else 1
    m = Massing(
        form=_pick(rng, s.forms),
        pitch_deg=rng.uniform(*s.pitch_deg),
        eaves_m=rng.uniform(*s.eaves_m),
        style=s,
        plinth_m=rng.uniform(0.22, 0.42),
        storeys=storeys,
        width_m=width,
        depth_m=depth,
        spare_m=(room_w - width - beside) / 2,
    )
    blocks = draw_blocks(rng, m, garage, garage_w, room_d)
    porch, door_y = _draw_porch(rng, s, m, blocks)
    lower = _finish(rng, s.lower)
    upper = _finish(rng, s.upper) if s.upper else lower
    trim = _tint(rng, _pick(rng, s.trims))
    gable = _finish(rng, s.gable) if s.gable and rng.random() < 0.75 else upper
    plinth, cover = _finish(rng, s.plinth), _finish(rng, s.roof)
    frame, door = _tint(rng, _pick(rng, s.frames)), _tint(rng, _pick(rng, s.doors))
    garage_tint = _tint(rng, _pick(rng, s.garage_doors))
    # Brick and plaster turn into their openings; boards end at a lining.
    bare = s.casing_m == 0
    sill = {"paint": ("paint", trim), "concrete": ("concrete", (1.0, 1.0, 1.0))}
    wing = next((b for b in blocks if b.role == "wing"), None)
    bay = None
    if rng.random() < s.bay and wing is not None:
        bay = Bay(x_m=wing.rect[2], y_m=(wing.rect[1] + wing.rect[3]) / 2, width_m=2.4)
    deck, behind = None, free_spans(blocks, 0, 3, 0)
    if behind and rng.random() < 0.8:
        low, high = max(behind, key=lambda span: span[1] - span[0])
        wide = min(rng.uniform(3.2, 5.0), high - low)
        centre = width / 2 - rng.uniform(low + wide / 2, high - wide / 2)
        deck = (
            -depth / 2 - rng.uniform(2.4, 3.4),
            centre - wide / 2,
            -depth / 2,
            centre + wide / 2,
        )
    return House(
        style=style,
        seed=int(rng.integers(2**53)),
        blocks=blocks,
        plinth_m=m.plinth_m,
        lower=lower,
        upper=upper,
        gable=gable,
        plinth=plinth,
        cover=cover,
        finish=OpeningFinish(
            reveal_m=s.reveal_m,
            casing_m=s.casing_m,
            reveal=lower if bare and lower[0] != "wood" else ("paint", trim),
            trim=trim,
            frame=frame,
            door=door,
            garage=garage_tint,
            shutter=_tint(rng, _pick(rng, s.doors)),
            sill=sill.get(s.sills, lower),
        ),
        window=_pick(rng, s.windows),
        window_size_m=(
            s.window_size_m[0] * rng.uniform(0.9, 1.12),
            s.window_size_m[1] * rng.uniform(0.92, 1.05),
        ),
        entrance_kind=_pick(rng, s.entrances),
        garage_kind=_pick(rng, s.garages),
        gutter=trim if rng.random() < 0.7 else (0.6, 0.6, 0.58),
        door_y_m=door_y,
        porch=porch,
        chimney=_draw_chimney(rng, m, blocks) if rng.random() < s.chimney else None,
        bay=bay,
        deck=deck,
        deck_is_wood=bool(rng.random() < 0.55),
        shutters=bool(rng.random() < s.shutters),
        corner_boards=bool(rng.random() < s.corner_boards),
        timbering=bool(rng.random() < s.timbering),
        brackets=bool(rng.random() < s.brackets),
        solar=bool(rng.random() < s.solar),
        columns=s.columns,
    )


def house(params: House, detail: int = 1) -> dict[tuple[str, str], Geometry]:
    """Build one house.

    Args:
        params: the house.
        detail: 1 in full, 0 for houses far from any flight (walls, panes, roofs).
    """
    facets, rng = Facets(), lane(params.seed, "house")
    walls, openings = lay_out(params, rng, detail)
    add_walls(facets, rng, walls, openings, params.finish, detail)
    for block in params.blocks:
        add_roof(
            facets,
            block.roof_rect,
            block.plate_m,
            block.roof,
            params.cover,
            params.finish.trim,
            params.gutter,
            params.gable if block.roof.form in ("gable", "hip") else params.upper,
            detail,
        )
    house_parts.add_porch(facets, params, detail)
    house_parts.add_chimney(facets, params, detail)
    if detail:
        house_parts.add_bay_roof(facets, params)
        house_parts.add_boards(facets, params, walls, openings)
        house_parts.add_deck(facets, params)
        house_fittings.add_fittings(facets, params, rng, openings)
    return facets.model()
