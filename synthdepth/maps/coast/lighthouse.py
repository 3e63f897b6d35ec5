"""A lighthouse: tapered tower, gallery, lantern, and the keeper's house behind its wall."""

import dataclasses

import numpy as np

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.coast.lighthouse_tower import (
    WHITEWASH,
    Lighthouse,
    gallery,
    lantern_room,
    openings,
    radius_m,
    tower,
)
from synthdepth.maps.coast.lofts import lathe
from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.gardens.parts import circle, draw_colour
from synthdepth.maps.geometry import (
    Geometry,
    Model,
    box,
    join,
    merge,
    place,
    quads,
    tube,
)
from synthdepth.maps.houses.house import draw_house, house
from synthdepth.seeding import lane

_BANDS = ((0.34, 0.03, 0.025), (0.03, 0.03, 0.034), (0.34, 0.03, 0.025), (0.03, 0.06, 0.14))
_WALL, _RAIL = "building", "barrier"


def draw_lighthouse(rng: np.random.Generator) -> Lighthouse:
    """Choose a tower of 15 to 30 m to its gallery."""
    height = rng.uniform(13.0, 29.0)
    brick = rng.random() < 0.15
    sides = 8 if rng.random() < 0.35 else 32
    round_only = "spiral" if sides == 32 else "bands"
    trim = draw_colour(
        rng, [(0.03, 0.035, 0.035), (0.3, 0.03, 0.025), (0.03, 0.1, 0.07), (0.6, 0.6, 0.58)]
    )
    return Lighthouse(
        height_m=height,
        foot_radius_m=0.1 * height + rng.uniform(1.1, 1.7),
        top_radius_m=0.045 * height + rng.uniform(1.1, 1.4),
        sides=sides,
        pattern="plain" if brick else str(rng.choice(["plain", "bands", "bands", round_only])),
        material="brick" if brick else "plaster",
        colour=(0.24, 0.12, 0.085) if brick else WHITEWASH,
        second=_BANDS[rng.integers(len(_BANDS))],
        bands=int(rng.integers(3, 7)),
        trim=tuple(trim.tolist()),
        house_style=str(
            rng.choice(["weatherboard_cottage", "stucco_bungalow", "weatherboard_cottage"])
        ),
        seed=int(rng.integers(2**53)),
    )


def _keepers_house(p: Lighthouse, rng: np.random.Generator) -> Model:
    """A whitewashed cottage beside the tower."""
    drawn = draw_house(rng, p.house_style, 12.5, 27.0)
    for _ in range(8):
        if not any(block.role == "garage" for block in drawn.blocks):
            break
        drawn = draw_house(rng, p.house_style, 10.2, 27.0)
    white = tuple((np.array(WHITEWASH) * rng.uniform(0.93, 1.03)).tolist())
    wall = ("plaster", white)
    finish = dataclasses.replace(drawn.finish, reveal=wall, trim=white, casing_m=0.0, reveal_m=0.12)
    drawn = dataclasses.replace(
        drawn,
        lower=wall,
        upper=wall,
        gable=wall,
        plinth=wall,
        finish=finish,
        corner_boards=False,
        timbering=False,
        solar=False,
        cover=("shingle", (0.1, 0.105, 0.11)) if rng.random() < 0.6 else drawn.cover,
    )
    return house(drawn)


def build_lighthouse(p: Lighthouse) -> Model:
    """The tower on the origin, its door towards +x; the house lies towards -y, within a wall.

    All within about x from -9 to 12 m and y from -21 to 9 m; walls go 1.5 m into the ground.
    """
    rng = lane(p.seed, "lighthouse")
    out: dict[tuple[str, str], list[Geometry]] = {(p.material, _WALL): [tower(p)]}
    for key, parts in openings(p, rng).items():
        out.setdefault(key, []).extend(parts)
    top = float(radius_m(p, p.height_m))
    gallery(p, p.height_m, top + rng.uniform(0.75, 1.05), out)
    lantern = min(top - 0.35, rng.uniform(1.25, 1.6))
    z = p.height_m
    if rng.random() < 0.5 or p.height_m > 22:  # a watch room below the lantern
        room = lathe(
            [lantern + 0.3, lantern + 0.3, lantern + 0.75, lantern + 0.75],
            [z - 0.05, z + 2.1, z + 2.25, z + 2.37],
            24,
            WHITEWASH,
        )
        out.setdefault(("plaster", _WALL), []).append(room)
        door = quads(_curved(lantern + 0.3, 0.45, 1.9, z + 0.05), np.array(p.trim) * 1.2 + 0.01)
        out.setdefault(("paint", _WALL), []).append(door)
        z += 2.37
        ring = circle(lantern + 0.68, z, 24)
        trim = np.array(p.trim)
        rails = [tube(ring + [0, 0, h], 0.014, 4, trim, capped=False) for h in (0.5, 1.0)]
        posts = round_bars(ring[:-1:2], ring[:-1:2] + [0, 0, 1.0], 0.016, trim, 5)
        out.setdefault(("paint", _RAIL), []).append(join([*rails, posts]))
    lantern_room(p, rng, z, lantern, out)
    r = p.foot_radius_m
    home = _keepers_house(p, rng)
    pts = np.concatenate(
        [g.vertices for (m, label), g in home.items() if label in ("building", "roof")]
    )
    low, high = pts[:, :2].min(axis=0), pts[:, :2].max(axis=0)
    away = -(r + 3.0 + high[1])
    home = place(home, [0.0, away, 0.0])
    # A wall round both, with a gap before the doors.
    x0, x1 = min(low[0], -r) - 2.5, max(high[0], r) + 4.0
    y0, y1 = away + low[1] - 2.5, r + 4.0
    yard = np.array(
        [[x1, -1.6, 0], [x1, y0, 0], [x0, y0, 0], [x0, y1, 0], [x1, y1, 0], [x1, 1.6, 0]]
    )
    wall = fence(rng, yard, "wall", 1.15)
    whitewash = {}
    for (material, label), part in wall.items():
        name = "plaster" if material == "brick" else material
        tint = (
            np.broadcast_to(np.float32(WHITEWASH), part.tint.shape)
            if material == "brick"
            else part.tint
        )
        whitewash[name, label] = dataclasses.replace(
            part, tint=np.ascontiguousarray(tint * np.float32(0.95))
        )
    # Footings, where the ground falls away.
    low_end, high_end = yard[:-1] - [0, 0, 0.75], yard[1:] - [0, 0, 0.75]
    size = np.append(high - low - 1.0, 1.0)
    footing = [
        beams(low_end, high_end, 0.24, 1.5),
        box(size, (*((low + high) / 2 + [0.0, away]), -1.45)),
        lathe([1.1 * r, 1.04 * r], [-1.6, -0.5], 16),
    ]
    below = {("plaster", _WALL): join(footing).tinted(np.array(WHITEWASH) * 0.8)}
    standing = {key: join(parts) for key, parts in out.items()}
    return merge([standing, home, whitewash, below])


def _curved(radius: float, half: float, high: float, z: float) -> np.ndarray:
    """A door's quadrilateral before a round wall, towards +x: (1, 4, 3)."""
    x = radius + 0.02
    return np.array([[[x, -half, z], [x, half, z], [x, half, z + high], [x, -half, z + high]]])


def lighthouse(rng: np.random.Generator) -> Model:
    """One drawn lighthouse with its house and wall, as `build_lighthouse` lays them out."""
    return build_lighthouse(draw_lighthouse(rng))
