"""The blocks of a house: main block, wing, garage and dormers, as one family would build them."""

import dataclasses
import math

import numpy as np

from synthdepth.maps.houses.plan import STOREY_M, Block
from synthdepth.maps.houses.roofs import Roof
from synthdepth.maps.houses.styles import Style

# Height of the garage's walls [m]; its floor is a step above the drive.
_GARAGE_PLATE_M = 2.65


def mirrored(sign: int, near: float, far: float) -> tuple[float, float]:
    """A range on one side of the house, low end first."""
    return (near, far) if sign > 0 else (-far, -near)


@dataclasses.dataclass(frozen=True)
class Massing:
    """What the blocks of one house share while they are drawn; lengths in metres.

    Attributes:
        form: roof form.
        pitch_deg: of all its roofs.
        eaves_m: overhang.
        style: the family.
        plinth_m: height of the ground floor.
        storeys: of the main block.
        width_m: of the main block along the street.
        depth_m: of the main block away from it.
        spare_m: room left beside the house, on either side.
    """

    form: str
    pitch_deg: float
    eaves_m: float
    style: Style
    plinth_m: float
    storeys: int
    width_m: float
    depth_m: float
    spare_m: float

    @property
    def flat(self) -> bool:
        """Whether wings cannot pass into the main roof."""
        return self.form in ("slab", "parapet", "shed")

    @property
    def plate_m(self) -> float:
        """Top of the main walls."""
        return self.plinth_m + STOREY_M * self.storeys

    def roof(self, ridge: str, ends: tuple[str, str], *, low: bool = False) -> Roof:
        """The roof of a block; `low` ones of flat-roofed houses have no slope."""
        form = self.form
        if low and form == "shed":
            form = "slab"
        ends = tuple("hip" if form == "hip" and e == "gable" else e for e in ends)
        return Roof(
            form=form,
            ridge=ridge,
            pitch_deg=0.0 if form in ("slab", "parapet") else self.pitch_deg,
            eaves_m=self.eaves_m,
            rake_m=0.75 * self.eaves_m,
            ends=ends,
            ribbed=self.style.roof[0] == "paint",
            capped=form != "shed",
        )


def _front_block(rng, m: Massing, *, sign: int, width: float, reach: float, role: str) -> Block:
    """A wing or garage that comes forward from the main block, its gable to the street."""
    past = min(rng.uniform(0.4, 1.0), m.spare_m)
    outer = m.width_m / 2 + (past if rng.random() < 0.3 and past >= 0.4 else -0.4)
    y0, y1 = mirrored(sign, outer - width, outer)
    storeys = 1 if role == "garage" else int(rng.integers(1, m.storeys + 1))
    # Slightly lower than the main block, so that no plane meets another in itself.
    plate = m.plinth_m + STOREY_M * storeys - 0.04
    if role == "garage":
        plate = min(plate, _GARAGE_PLATE_M + 0.1) if m.storeys > 1 or m.flat else plate
    if m.flat:
        plate = min(plate, m.plate_m - 0.5)
    rect = (0.0, y0, m.depth_m / 2 + reach, y1)
    return Block(
        role=role,
        rect=rect,
        # Off the plane of the rear wall, which shows where a wing stands out sideways.
        roof_rect=(-0.02, *rect[1:]),
        plate_m=plate,
        storeys=storeys,
        roof=m.roof("x", ("inner", "gable"), low=True),
        door_m=(4.9 if width > 5 else 2.6) if role == "garage" else 0.0,
    )


def _side_garage(rng, m: Massing, *, sign: int, width: float) -> Block:
    """A garage beside the main block, its ridge along the street."""
    # Of a bungalow its roof runs into the main one, and must stay under it.
    under = m.storeys == 1 and not m.flat
    set_back = m.eaves_m + rng.uniform(0.2, 1.4) if under else rng.uniform(-1.2, 1.5)
    if abs(set_back) < 0.3:
        set_back = 0.3
    x1 = m.depth_m / 2 - set_back
    depth = min(rng.uniform(6.0, 6.8), m.depth_m - set_back - m.eaves_m - 0.2 if under else 9.0)
    y0, y1 = mirrored(sign, m.width_m / 2 - 0.2, m.width_m / 2 + width)
    r0, r1 = mirrored(sign, 0.0 if under else m.width_m / 2 - 0.235, m.width_m / 2 + width)
    return Block(
        role="garage",
        rect=(x1 - depth, y0, x1, y1),
        roof_rect=(x1 - depth, r0, x1, r1),
        plate_m=m.plate_m - 0.04 if under else _GARAGE_PLATE_M,
        storeys=1,
        roof=m.roof("y", ("inner", "gable") if sign > 0 else ("gable", "inner"), low=True),
        door_m=4.9 if width > 5 else 2.6,
    )


def _detached_garage(rng, m: Massing, *, sign: int) -> Block:
    y0, y1 = mirrored(sign, m.width_m / 2 + 0.3, m.width_m / 2 + 4.0)
    x1 = -m.depth_m / 2 + rng.uniform(-2.0, 0.5)
    rect = (x1 - 6.2, y0, x1, y1)
    return Block(
        role="garage",
        rect=rect,
        roof_rect=rect,
        plate_m=2.5,
        storeys=1,
        roof=m.roof("x", ("gable", "gable"), low=True),
        door_m=2.6,
    )


def _dormers(rng, m: Massing, wing: Block | None) -> list[Block]:
    """Gabled dormers on the front slope, where the main roof is high enough to hold them."""
    tan = math.tan(math.radians(m.pitch_deg))
    width, inset, wall = rng.uniform(1.6, 2.0), 0.75, 1.2
    plate = m.plate_m + 0.16 + inset * tan + wall
    top = inset * tan + wall + 0.2 + width / 2 * tan
    if top > m.depth_m / 2 * tan - 0.1:
        return []
    front = m.depth_m / 2 - inset
    rear = max(0.0, m.depth_m / 2 - top / tan - 0.3)
    count = 1 + int(rng.random() * min(3, m.width_m // 3.6))
    out = []
    for k in range(count):
        y = m.width_m * ((k + 0.5) / count - 0.5) * 0.8
        if wing and wing.rect[1] - width - 0.4 < y < wing.rect[3] + width + 0.4:
            continue
        rect = (rear, y - width / 2, front, y + width / 2)
        roof = Roof(
            form="gable",
            pitch_deg=m.pitch_deg,
            eaves_m=0.18,
            rake_m=0.2,
            ends=("inner", "gable"),
            capped=False,
        )
        out.append(
            Block(
                role="dormer",
                rect=rect,
                roof_rect=rect,
                plate_m=plate,
                storeys=0,
                roof=roof,
                base_m=m.plate_m + 0.05,
            )
        )
    return out


def draw_blocks(
    rng: np.random.Generator, m: Massing, garage: str, garage_w: float, room_d: float
) -> tuple[Block, ...]:
    """Choose all blocks, the main block first.

    Args:
        rng: source of all choices.
        m: the main block's measures.
        garage: "none", "side", "front" or "detached".
        garage_w: its width [m].
        room_d: depth that blocks and porch may take [m].
    """
    s = m.style
    sign = 1 if rng.random() < 0.5 else -1
    w, d = m.width_m, m.depth_m
    across = m.form != "shed" and (w < 0.95 * d or (s.brackets and w < 1.2 * d))
    rect = (-d / 2, -w / 2, d / 2, w / 2)
    blocks = [
        Block(
            role="main",
            rect=rect,
            roof_rect=rect,
            plate_m=m.plate_m,
            storeys=m.storeys,
            roof=m.roof("x" if across else "y", ("gable", "gable")),
        )
    ]
    reach = max(0.8, min(room_d - d - 2.0, 5.0))
    taken = 0.0
    if garage == "front":
        far = rng.uniform(0.5, 1.0) * reach
        blocks.append(_front_block(rng, m, sign=sign, width=garage_w, reach=far, role="garage"))
        taken = garage_w
    elif garage == "side":
        blocks.append(_side_garage(rng, m, sign=sign, width=garage_w))
    elif garage == "detached":
        blocks.append(_detached_garage(rng, m, sign=sign))
    width = rng.uniform(3.5, min(5.4, max(3.6, 0.42 * w)))
    wing = None
    if rng.random() < s.front_wing and w - taken - width > 3.2 and m.form != "shed":
        far = min(rng.uniform(1.0, 2.6), reach)
        wing = _front_block(rng, m, sign=-sign, width=width, reach=far, role="wing")
        blocks.append(wing)
    if rng.random() < s.dormers and m.form == "gable" and not across:
        fronts = [b for b in blocks[1:] if b.rect[0] == 0.0]
        dormers = _dormers(rng, m, wing)
        blocks += [
            b
            for b in dormers
            if all(b.rect[3] < f.rect[1] - 0.5 or b.rect[1] > f.rect[3] + 0.5 for f in fronts)
        ]
    return tuple(blocks)
