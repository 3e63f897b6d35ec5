"""Walls with cut openings: windows, doors and garage doors as real relief, a house at a time.

An opening is casing, reveal, frame, bars and panes (or panels); the wall is split into rectangles
around it, so that nothing lies on anything. In a wall's own frame s runs along it, n points out
of it and z is up.
"""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from synthdepth.maps.houses.facets import Facets, Key

# [m] how far a casing stands out of the wall, and how deep frames, bars and panes lie behind the
# front of the frame.
_CASING_OUT, _FRAME_DEEP, _BAR_BACK, _PANE_BACK, _PANEL_BACK = 0.025, 0.062, 0.012, 0.036, 0.03


class Wall(NamedTuple):
    """A vertical rectangle; walking along `direction`, the outside is on the right.

    Attributes:
        origin: (2,) foot of its start [m].
        direction: (2,) unit vector along it.
        length_m: along `direction`.
        low_m: bottom.
        high_m: top.
        key: (material, label).
        tint: (3,).
    """

    origin: tuple[float, float]
    direction: tuple[float, float]
    length_m: float
    low_m: float
    high_m: float
    key: Key
    tint: tuple[float, float, float]


class Opening(NamedTuple):
    """A hole in one wall, from `s0` to `s1` along it and from `z0` to `z1` [m]."""

    wall: int
    s0: float
    s1: float
    z0: float
    z1: float
    kind: str
    shutters: bool = False


class Kind(NamedTuple):
    """How an opening of one kind is filled.

    Attributes:
        frame_m: width of the frame.
        bar_columns, bar_rows: cells that the bars part the opening into.
        bar_m: width of a bar.
        pane_columns, pane_rows: panes; each boundary lies behind a bar.
        glazed_rows: rows of panes of glass, from the top; the rest are panels.
        door: reaches the floor: no sill, no casing below, panels and bars in the door's colour.
        blinds: share of such windows that have a blind.
    """

    frame_m: float
    bar_columns: int
    bar_rows: int
    bar_m: float
    pane_columns: int
    pane_rows: int
    glazed_rows: int
    door: bool = False
    blinds: float = 0.45


KINDS = {
    "double_hung": Kind(0.055, 1, 2, 0.055, 1, 2, 2),
    "six_over_six": Kind(0.055, 3, 4, 0.03, 1, 2, 2),
    "four_over_one": Kind(0.06, 2, 2, 0.04, 2, 2, 2),
    "casement": Kind(0.05, 2, 1, 0.07, 2, 1, 1),
    "casement_cottage": Kind(0.05, 2, 3, 0.045, 2, 1, 1),
    "leaded": Kind(0.06, 3, 4, 0.028, 3, 1, 1, blinds=0.3),
    "picture": Kind(0.06, 3, 1, 0.07, 3, 1, 1),
    "fixed": Kind(0.045, 1, 1, 0.05, 1, 1, 1, blinds=0.25),
    "ribbon": Kind(0.045, 2, 1, 0.05, 2, 1, 1, blinds=0.3),
    "shaft": Kind(0.05, 1, 3, 0.05, 1, 3, 3, blinds=0.1),
    "sidelight": Kind(0.05, 1, 3, 0.05, 1, 3, 3, True, 0),
    "garden_door": Kind(0.07, 2, 1, 0.09, 2, 1, 1, True),
    "door_panel": Kind(0.11, 2, 3, 0.11, 2, 3, 0, True, 0),
    "door_fan": Kind(0.11, 2, 4, 0.1, 2, 4, 1, True, 0),
    "door_lite": Kind(0.12, 1, 2, 0.16, 1, 2, 1, True, 0),
    "door_flush": Kind(0.09, 1, 4, 0.025, 1, 4, 0, True, 0),
    "garage_4": Kind(0.06, 4, 4, 0.07, 4, 4, 0, True, 0),
    "garage_4_lites": Kind(0.06, 4, 4, 0.07, 4, 4, 1, True, 0),
    "garage_8": Kind(0.06, 8, 4, 0.07, 8, 4, 0, True, 0),
    "garage_8_lites": Kind(0.06, 8, 4, 0.07, 8, 4, 1, True, 0),
    "garage_flush": Kind(0.05, 1, 5, 0.02, 1, 5, 0, True, 0),
    "garage_plank": Kind(0.06, 9, 1, 0.025, 9, 1, 0, True, 0),
}
_KIND_NUMBER = {name: number for number, name in enumerate(KINDS)}
_KIND_TABLE = np.array([tuple(kind) for kind in KINDS.values()], float)


@dataclasses.dataclass(frozen=True, kw_only=True)
class OpeningFinish:
    """Colours (linear RGB) and sizes shared by the openings of one house.

    Attributes:
        reveal_m: from the face of the wall to the face of the frame.
        casing_m: width of the boards around an opening; 0 for none.
        reveal: (material, tint) of the sides of the hole.
        trim, frame, door, garage, shutter: tints of paint.
        sill: (material, tint).
    """

    reveal_m: float
    casing_m: float
    reveal: tuple[str, tuple]
    trim: tuple
    frame: tuple
    door: tuple
    garage: tuple
    shutter: tuple
    sill: tuple[str, tuple]


def _quads(*columns) -> np.ndarray:
    """(k, m, 4, 3) from 12 m columns (s, n, z of the corners), (k,) or some scalar."""
    k = next(len(c) for c in columns if isinstance(c, np.ndarray))
    out = np.empty((len(columns), k))
    for row, column in zip(out, columns, strict=True):
        row[:] = column
    return out.T.reshape(k, len(columns) // 12, 4, 3)


def _faces(s0, s1, z0, z1, n) -> np.ndarray:
    """(k, 1, 4, 3) rectangles that face outwards."""
    return _quads(s0, n, z0, s1, n, z0, s1, n, z1, s0, n, z1)


def _ring(s0, s1, z0, z1, t0, t1, y0, y1, n) -> np.ndarray:
    """(k, 4, 4, 3): what a rectangle t, y leaves of a larger one s, z, facing outwards."""
    left = (s0, n, z0, t0, n, z0, t0, n, z1, s0, n, z1)
    right = (t1, n, z0, s1, n, z0, s1, n, z1, t1, n, z1)
    below = (t0, n, z0, t1, n, z0, t1, n, y0, t0, n, y0)
    above = (t0, n, y1, t1, n, y1, t1, n, z1, t0, n, z1)
    return _quads(*left, *right, *below, *above)


def _tunnel(s0, s1, z0, z1, a, b) -> np.ndarray:
    """(k, 4, 4, 3): sides of a hole from n = a in to n = b; swap a and b for those of a block."""
    left = (s0, a, z0, s0, b, z0, s0, b, z1, s0, a, z1)
    right = (s1, b, z0, s1, a, z0, s1, a, z1, s1, b, z1)
    top = (s0, b, z1, s1, b, z1, s1, a, z1, s0, a, z1)
    bottom = (s0, a, z0, s1, a, z0, s1, b, z0, s0, b, z0)
    return _quads(*left, *right, *top, *bottom)


def _spread(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Owner and number within the owner of `counts` (k,) things each."""
    owner = np.repeat(np.arange(len(counts)), counts)
    return owner, np.arange(len(owner)) - np.repeat(np.cumsum(counts) - counts, counts)


class _Frames:
    """Quads in wall coordinates, collected and turned into facets in one go."""

    def __init__(self, facets: Facets, walls: Sequence[Wall]) -> None:
        self.facets = facets
        self.table = np.array([(*w.origin, *w.direction, *w[2:5]) for w in walls])
        self._parts: list[tuple[np.ndarray, ...]] = []

    def add(self, key: Key | np.ndarray, tint, quads: np.ndarray, wall: np.ndarray) -> None:
        """`quads` (k, m, 4, 3) of walls (k,); `key` and `tint` for all, or (k,) and (k, 3)."""
        k, m = quads.shape[:2]
        ids, tints = np.empty((k, m), int), np.empty((k, m, 3))
        ids[:] = key[:, None] if isinstance(key, np.ndarray) else self.facets.id_of(key)
        tints[:] = tint[:, None] if isinstance(tint, np.ndarray) else tint
        of = np.repeat(wall, m)
        self._parts.append((ids.ravel(), tints.reshape(-1, 3), quads.reshape(-1, 4, 3), of))

    def flush(self) -> None:
        """Hand everything over."""
        ids, tints, quads, wall = (np.concatenate(p) for p in zip(*self._parts, strict=True))
        frame = self.table[wall][:, None, :]
        s, n = quads[..., 0], quads[..., 1]
        dx, dy = frame[..., 2], frame[..., 3]
        x, y = frame[..., 0] + s * dx + n * dy, frame[..., 1] + s * dy - n * dx
        quads[..., 0], quads[..., 1] = x, y
        self.facets.add(ids, tints, quads)


def _cut_walls(frames: _Frames, walls: Sequence[Wall], wall, s0, s1, z0, z1) -> None:
    """The walls around their openings: piers of full height, a piece below and one above each."""
    table, every = frames.table, np.arange(len(walls))
    owner = np.concatenate([every, wall])
    starts = np.concatenate([np.zeros(len(walls)), s1])
    stops = np.concatenate([table[:, 4], s0])
    starts = starts[np.lexsort((starts, owner))]
    order = np.lexsort((stops, owner))
    stops, owner = stops[order], owner[order]
    pieces = np.concatenate(
        [
            _faces(starts, stops, table[owner, 5], table[owner, 6], 0.0),
            _faces(s0, s1, table[wall, 5], z0, 0.0),
            _faces(s0, s1, z1, table[wall, 6], 0.0),
        ]
    )
    of = np.concatenate([owner, wall, wall])
    ids = np.array([frames.facets.id_of(w.key) for w in walls])
    tints = np.array([w.tint for w in walls])
    frames.add(ids[of], tints[of], pieces, of)


def _fill(frames: _Frames, rng, finish: OpeningFinish, kind, colour, wall, f0, f1, y0, y1, n):
    """Bars, panes, panels and blinds of the clear openings f, y behind frames at depth n."""
    cols, rows, bar = kind[:, 1].astype(int), kind[:, 2].astype(int), kind[:, 3] / 2
    paint = ("paint", "building")
    o, i = _spread(cols - 1)
    centre = f0[o] + (f1 - f0)[o] * (i + 1) / cols[o]
    a, b, front = centre - bar[o], centre + bar[o], n[o] - _BAR_BACK
    back, z0, z1 = front - 0.05, y0[o], y1[o]
    upright = _quads(
        *(a, front, z0, b, front, z0, b, front, z1, a, front, z1),
        *(a, back, z0, a, front, z0, a, front, z1, a, back, z1),
        *(b, front, z0, b, back, z0, b, back, z1, b, front, z1),
    )
    frames.add(paint, colour[o], upright, wall[o])
    o, i = _spread(rows - 1)
    centre = y0[o] + (y1 - y0)[o] * (i + 1) / rows[o]
    # Level bars lie a hair behind the uprights that they cross.
    a, b, front = centre - bar[o], centre + bar[o], n[o] - _BAR_BACK - 0.004
    back, s0, s1 = front - 0.046, f0[o], f1[o]
    level = _quads(
        *(s0, front, a, s1, front, a, s1, front, b, s0, front, b),
        *(s0, front, b, s1, front, b, s1, back, b, s0, back, b),
        *(s0, back, a, s1, back, a, s1, front, a, s0, front, a),
    )
    frames.add(paint, colour[o], level, wall[o])

    cols, rows = kind[:, 4].astype(int), kind[:, 5].astype(int)
    blind = np.where(
        rng.random(len(kind)) < kind[:, 8], rng.choice([0.3, 0.45, 0.6, 1.0], len(kind)), 0.0
    )
    cloth = rng.uniform(0.3, 0.55, (len(kind), 1)) * [1.0, 0.97, 0.9]
    o, i = _spread(cols * rows)
    row, width, height = i // cols[o], ((f1 - f0) / cols)[o], ((y1 - y0) / rows)[o]
    s0, z0 = f0[o] + width * (i % cols[o]), y0[o] + height * row
    s1, z1 = s0 + width, z0 + height
    glazed = row >= rows[o] - kind[o, 6]
    # A degree of tilt each way, less for panes that would leave their frame.
    lean = np.tan(np.radians(rng.uniform(-1, 1, (2, len(o))))) * glazed
    reach = np.abs(lean[0]) * width / 2 + np.abs(lean[1]) * height / 2
    lean *= np.minimum(1, 0.022 / np.maximum(reach, 0.022))
    depth = n[o] - np.where(glazed, _PANE_BACK, _PANEL_BACK)

    def leaning(low, high):
        def at(s, z):
            return depth + lean[0] * (s - (s0 + s1) / 2) + lean[1] * (z - (z0 + z1) / 2)

        return _quads(
            *(s0, at(s0, low), low, s1, at(s1, low), low),
            *(s1, at(s1, high), high, s0, at(s0, high), high),
        )

    bottom_of_blind = np.clip((y1 - blind * (y1 - y0))[o], z0, z1)
    glass = leaning(z0, bottom_of_blind)
    shade = rng.uniform(0.75, 1.25, (len(kind), 1)) * [1.0, 1.0, 1.0]
    frames.add(("glass", "building"), shade[o[glazed]], glass[glazed], wall[o[glazed]])
    lowered = glazed & (bottom_of_blind < z1 - 1e-6)
    cover = leaning(bottom_of_blind, z1)
    frames.add(("fabric", "building"), cloth[o[lowered]], cover[lowered], wall[o[lowered]])
    panel = ~glazed
    frames.add(paint, 0.94 * colour[o[panel]], _faces(s0, s1, z0, z1, depth)[panel], wall[o[panel]])


def add_walls(
    facets: Facets,
    rng: np.random.Generator,
    walls: Sequence[Wall],
    openings: Sequence[Opening],
    finish: OpeningFinish,
    detail: int = 1,
) -> None:
    """Add walls with their openings cut and filled.

    Args:
        facets: where to.
        rng: tilts panes and lowers blinds.
        walls: the walls.
        openings: their openings, apart from each other.
        finish: colours and sizes.
        detail: 1 for all relief, 0 for a plain pane in the plane of the wall.
    """
    frames = _Frames(facets, walls)
    number = np.array([(o.wall, _KIND_NUMBER[o.kind], o.shutters) for o in openings], int)
    number = number.reshape(-1, 3)
    s0, s1, z0, z1 = np.array([o[1:5] for o in openings], float).reshape(-1, 4).T
    _cut_walls(frames, walls, number[:, 0], s0, s1, z0, z1)
    if openings:
        _fill_holes(frames, rng, finish, openings, number, s0, s1, z0, z1, detail)
    frames.flush()


def _fill_holes(frames: _Frames, rng, finish, openings, number, s0, s1, z0, z1, detail) -> None:
    """Casings, reveals, frames, fillings, sills and shutters of the holes s, z."""
    wall, kind_of, shuttered = number.T
    kind = _KIND_TABLE[kind_of]
    door = kind[:, 7] > 0
    garage = np.array([o.kind.startswith("garage") for o in openings])
    solid = door & (kind[:, 6] < kind[:, 5])
    colour = np.where(solid[:, None], np.where(garage[:, None], finish.garage, finish.door), 0.0)
    colour = np.where(solid[:, None], colour, finish.frame)
    paint = ("paint", "building")
    casing = finish.casing_m
    reveal_key = (finish.reveal[0], "building")
    n = np.full(len(wall), -finish.reveal_m)
    if not detail:
        pane = _faces(s0, s1, z0, z1, 0.0)
        frames.add(("glass", "building"), (1, 1, 1), pane[~solid], wall[~solid])
        frames.add(paint, colour[solid], pane[solid], wall[solid])
        return
    out = _CASING_OUT if casing else 0.0
    frames.add(reveal_key, finish.reveal[1], _tunnel(s0, s1, z0, z1, out, n), wall)
    if casing:
        c0, c1, e1 = s0 - casing, s1 + casing, z1 + 1.2 * casing
        e0 = np.where(door, z0, z0 - casing)
        around = _ring(c0, c1, e0, e1, s0, s1, z0, z1, out)
        sides = _tunnel(c0, c1, e0, e1, -0.005, out)
        frames.add(paint, finish.trim, np.concatenate([around, sides], axis=1), wall)
    edge = kind[:, 0]
    f0, f1, y1 = s0 + edge, s1 - edge, z1 - edge
    y0 = np.where(door, z0 + 0.03, z0 + edge)
    frame = np.concatenate(
        [_ring(s0, s1, z0, z1, f0, f1, y0, y1, n), _tunnel(f0, f1, y0, y1, n, n - _FRAME_DEEP)],
        axis=1,
    )
    frames.add(paint, np.where(solid[:, None], finish.trim, finish.frame), frame, wall)
    _fill(frames, rng, finish, kind, colour, wall, f0, f1, y0, y1, n)
    w = ~door
    grow = casing + 0.04
    a, b, low, high = s0[w] - grow, s1[w] + grow, z0[w] - 0.055, z0[w] + 0.012
    sill = np.concatenate(
        [_faces(a, b, low, high, 0.08), _tunnel(a, b, low, high, -0.005, 0.08)], axis=1
    )
    frames.add((finish.sill[0], "building"), finish.sill[1], sill, wall[w])
    w = shuttered > 0
    if w.any():
        leaf = 0.42 * (s1 - s0)[w]
        a = np.concatenate([s0[w] - casing - 0.01 - leaf, s1[w] + casing + 0.01])
        b = a + np.tile(leaf, 2)
        low, high, of = np.tile(z0[w], 2) - 0.02, np.tile(z1[w], 2) + 0.02, np.tile(wall[w], 2)
        t0, t1, mid = a + 0.06, b - 0.06, (low + high) / 2
        board = np.concatenate(
            [
                _ring(a, b, low, mid, t0, t1, low + 0.07, mid - 0.035, 0.04),
                _ring(a, b, mid, high, t0, t1, mid + 0.035, high - 0.07, 0.04),
                _faces(t0, t1, low + 0.07, mid - 0.035, 0.022),
                _faces(t0, t1, mid + 0.035, high - 0.07, 0.022),
                _tunnel(a, b, low, high, -0.005, 0.04),
            ],
            axis=1,
        )
        frames.add(paint, finish.shutter, board, of)
