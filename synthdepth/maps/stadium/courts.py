"""Courts beside the pitches: tennis, basketball, and a cage for five-a-side.

Each returns a `Piece` for a rectangle about the origin; its size comes in along x and y [m].
"""

import itertools

import numpy as np
import shapely

from synthdepth.maps.bars import beams, round_bars
from synthdepth.maps.furniture.fences import fence
from synthdepth.maps.geometry import Model, box, join, place, quads, tube
from synthdepth.maps.placement import points_along
from synthdepth.maps.stadium.markings import basketball_lines, paint, soccer_lines, tennis_lines
from synthdepth.maps.stadium.masts import training_mast
from synthdepth.maps.stadium.nets import ball_stop, balls, court_net, goal, netting
from synthdepth.maps.stadium.piece import Patch, Piece, moved_area

_WHITE = (0.66, 0.66, 0.63)
_COURT_TINTS = (
    (0.05, 0.13, 0.08), (0.04, 0.09, 0.2), (0.1, 0.17, 0.13), (0.22, 0.07, 0.045),
    (0.09, 0.12, 0.2),
)  # fmt: skip


def rectangle(size, inset: float = 0.0) -> shapely.Polygon:
    """A rectangle of `size` (2,) about the origin, drawn in by `inset`."""
    x, y = np.asarray(size, float) / 2 - inset
    return shapely.box(-x, -y, x, y)


def enclosure(
    rng: np.random.Generator, size, kind: str, height_m: float, gates: int = 1
) -> list[Model]:
    """A fence around a rectangle with gaps of 1.4 m for gates."""
    ring = shapely.LineString(rectangle(size).exterior.coords)
    length = ring.length
    cuts = np.sort(rng.uniform(0.05, 0.95, gates)) * length
    spans = np.concatenate([[0.0], cuts, [length]])
    models = []
    for a, b in itertools.pairwise(spans):
        a, b = a + (0.7 if a > 0 else 0), b - (0.7 if b < length else 0)
        part = shapely.get_coordinates(_substring(ring, a, b))
        if len(part) >= 2:
            path = np.column_stack([part, np.zeros(len(part))])
            models.append(fence(rng, path, kind, height_m))
    return models


def _substring(line: shapely.LineString, start: float, end: float) -> shapely.LineString:
    xy = shapely.get_coordinates(line)
    s = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))])
    inner = xy[(s > start + 1e-6) & (s < end - 1e-6)]
    ends = [shapely.get_coordinates(line.interpolate(at)) for at in (start, end)]
    return shapely.LineString(np.concatenate([ends[0], inner, ends[1]]))


def edge_tufts(rng: np.random.Generator, size, spacing: float = 0.45) -> np.ndarray:
    """Grass (k, 2) along the edge of a rectangle, where no mower reaches."""
    edge = points_along(rectangle(size).exterior, spacing, rng)
    return edge + rng.normal(0, 0.09, edge.shape)


def tennis(rng: np.random.Generator, size) -> Piece:
    """As many courts side by side as fit, behind one fence."""
    count = max(int((size[1] - 2) // 17.5), 1)
    wide = (35.5, 17.0 * count + 1.0)
    clay = rng.random() < 0.45
    outer, inner = (np.array(_COURT_TINTS[i]) for i in rng.permutation(5)[:2])
    area = rectangle(wide)
    patches, models, people, lines, benches = [], [], [], [], []
    base = ("clay", "ground") if clay else ("court", "ground")
    patches.append(Patch(area=area, surface=base, tint=(1, 1, 1) if clay else tuple(outer), rank=3))
    for k in range(count):
        y = (k - (count - 1) / 2) * 17.0
        lines.append(moved_area(tennis_lines(), (0, y), 0))
        if not clay:
            court = shapely.box(-11.885, y - 5.485, 11.885, y + 5.485)
            patches.append(Patch(area=court, surface=base, tint=tuple(inner), rank=4))
        models.append(place(court_net(12.8, 1.07), (0, y, 0)))
        if rng.random() < 0.6:
            for s in (-1, 1):
                at = [[s * rng.uniform(6, 12.5), y + rng.uniform(-4, 4), np.pi * (s > 0)]]
                people.append((str(rng.choice(["running", "standing"])), "bib", np.array(at)))
        benches.append([rng.uniform(-2, 2), y + 7.7, -np.pi / 2])
        people.append(("standing", "", np.array([[rng.uniform(-4, 4), y + 7.0, 1.0]])))
    models.append(paint(shapely.union_all(lines), "road_paint", (0.62, 0.62, 0.6)))
    models += enclosure(rng, wide, "chain_link", float(rng.choice([3.0, 3.6, 4.0])), gates=count)
    return Piece(
        models=models,
        patches=patches,
        people=people,
        furniture=[("bench", np.array(benches))],
        tufts=edge_tufts(rng, np.add(wide, 0.3)),
        keep_clear=[area.buffer(1.5)],
    )


def _hoop() -> Model:
    """A basketball post behind its board, which faces +x; the rim 3.05 m up, at x = 0."""
    post = tube([[-1.9, 0, -0.1], [-1.9, 0, 2.6], [-1.6, 0, 3.2], [-0.45, 0, 3.45]], 0.075, 8)
    board = box((0.04, 1.8, 1.05), (-0.37, 0, 2.9), (0.6, 0.6, 0.58))
    frame = quads(
        [[[-0.348, -0.3, 3.1], [-0.348, 0.3, 3.1], [-0.348, 0.3, 3.55], [-0.348, -0.3, 3.55]]]
    )
    turn = np.linspace(0, 2 * np.pi, 13)
    ring = np.column_stack([0.225 * np.cos(turn), 0.225 * np.sin(turn), np.full(13, 3.05)])
    rim = tube(ring, 0.012, 5, (0.4, 0.09, 0.02), capped=False)
    drop = ring * [0.6, 0.6, 1] - [0, 0, 0.42]
    top, low = ring[:-1], drop[:-1]
    strings = round_bars(
        np.concatenate([top, top]), np.concatenate([low, np.roll(low, 1, 0)]), 0.004, _WHITE, 3
    )
    return {
        ("paint", "obstacle"): join(
            [post.tinted((0.04, 0.07, 0.05)), board, frame.tinted((0.3, 0.03, 0.03)), rim]
        ),
        ("fabric", "obstacle"): strings,
    }


def basketball(rng: np.random.Generator, size) -> Piece:
    """A court of 28 x 15 m with two posts, a low fence behind them, some players."""
    outer, inner = (np.array(_COURT_TINTS[i]) for i in rng.permutation(5)[:2])
    wide = (min(31.0, size[0]), min(18.0, size[1]))
    models = [place(_hoop(), (12.42 * s, 0, 0), 0.0 if s < 0 else np.pi) for s in (-1, 1)]
    models.append(paint(basketball_lines(), "road_paint", (0.62, 0.62, 0.6)))
    players = np.column_stack(
        [rng.uniform(-12, 12, 6), rng.uniform(-6, 6, 6), rng.uniform(0, 6, 6)]
    )
    x, y = np.array(wide) / 2
    for s in (-1, 1):
        path = np.array([[s * x, -y, 0], [s * x, y, 0]])
        models.append(fence(rng, path, "chain_link", 3.0))
    keys = shapely.union_all(
        [shapely.box(8.2, -2.45, 14, 2.45), shapely.box(-14, -2.45, -8.2, 2.45)]
    )
    return Piece(
        models=models,
        patches=[
            Patch(area=rectangle(wide), surface=("court", "ground"), tint=tuple(outer), rank=3),
            Patch(
                area=rectangle((28, 15)).difference(keys),
                surface=("court", "ground"),
                tint=tuple(inner),
                rank=4,
            ),
        ],
        people=[("running", "home", players[:4]), ("standing", "", players[4:])],
        tufts=edge_tufts(rng, np.add(wide, 0.3)),
        keep_clear=[rectangle(wide).buffer(1.0)],
    )


def cage(rng: np.random.Generator, size, lit: bool) -> Piece:
    """A five-a-side court on plastic grass, in boards and high mesh."""
    length = float(min(size[0] - 2, 42.0))
    wide = float(min(size[1] - 2, 0.58 * length, 25.0))
    area = rectangle((length + 1.5, wide + 1.5))
    models: list[Model] = []
    for s in (-1, 1):
        small = goal(rng, 3.0, 2.0, portable=True)
        models.append(place(small, (s * (length / 2 - 0.3), 0, 0), np.pi if s > 0 else 0.0))
    models.append(paint(soccer_lines(length - 1, wide - 1), "road_paint", (0.6, 0.6, 0.58)))
    models += enclosure(rng, (length + 1.5, wide + 1.5), "chain_link", 3.0, gates=2)
    x, y = (length + 1.4) / 2, (wide + 1.4) / 2
    kick = [([-x, s * y], [x, s * y]) for s in (-1, 1)]
    for a, b in kick:
        models.append(
            {("wood", "barrier"): beams([[*a, 0.5]], [[*b, 0.5]], 0.04, 1.0, (0.25, 0.18, 0.1))}
        )
    for s in (-1, 1):
        models.append(ball_stop(rng, np.array([[s * x, -y], [s * x, y]]) * 1.02, 6.0))
    top = netting(
        [[-x, -y, 5.9], [x, -y, 5.9], [x, y, 5.9], [-x, y, 5.9]],
        0.25,
        0.004,
        (0, 0, -0.4),
        (0.05, 0.06, 0.05),
    )
    if rng.random() < 0.35:
        models.append({("fabric", "wire"): top})
    if lit:
        for sx in (-0.3, 0.3):
            for s in (-1, 1):
                mast = training_mast(rng, 8.0, 1)
                models.append(place(mast, (sx * length, s * (y + 0.6), 0), -s * np.pi / 2))
    team = np.column_stack(
        [
            rng.uniform(-0.45, 0.45, 8) * length,
            rng.uniform(-0.4, 0.4, 8) * wide,
            rng.uniform(0, 6, 8),
        ]
    )
    return Piece(
        models=[*models, balls(rng.uniform(-0.4, 0.4, (3, 2)) * [length, wide])],
        patches=[Patch(area=area, surface=("synthetic_turf", "ground"), rank=3)],
        people=[
            ("running", "home", team[:4]),
            ("player_kick", "away", team[4:5]),
            ("running", "away", team[5:]),
        ],
        tufts=edge_tufts(rng, (length + 2, wide + 2)),
        keep_clear=[area.buffer(1.5)],
    )
