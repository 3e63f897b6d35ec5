"""Training pitches: nets and fences around them, masts, spare goals, squads at practice."""

import numpy as np

from synthdepth.maps.geometry import Model, merge, place
from synthdepth.maps.placement import points_along
from synthdepth.maps.stadium.courts import enclosure, rectangle
from synthdepth.maps.stadium.gear import gear
from synthdepth.maps.stadium.markings import flat_mesh, paint, soccer_lines
from synthdepth.maps.stadium.masts import training_mast
from synthdepth.maps.stadium.nets import ball_stop, balls, goal
from synthdepth.maps.stadium.piece import Piece
from synthdepth.maps.stadium.pitches import Pitch, corner_flags, draw_pitch, surfaces
from synthdepth.maps.stadium.touchline import perimeter_rail

_MARGIN_M = 3.0
_SPARE_GOALS_M = ((5.0, 2.0), (3.0, 2.0), (1.8, 1.2))


def _row(rng: np.random.Generator, centre, turn: float, count: int, step: float) -> np.ndarray:
    """Places (k, 3) in a row about a centre, each turned to the row's direction."""
    along = (np.arange(count) - (count - 1) / 2)[:, None] * step
    xy = centre + along * [np.cos(turn), np.sin(turn)]
    return np.column_stack([xy + rng.normal(0, 0.1, xy.shape), np.full(count, turn)])


def _drill(rng: np.random.Generator, centre: np.ndarray) -> Model:
    """The gear of one exercise around a centre (2,)."""
    turn, kind = rng.uniform(0, np.pi), rng.integers(4)
    aside = 1.5 * np.array([-np.sin(turn), np.cos(turn)])
    if kind == 0:  # a square of discs with tall cones at its corners
        half = rng.uniform(4, 8)
        corners = centre + half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        sides = np.concatenate(
            [_row(rng, (a + b) / 2, np.arctan2(*(b - a)[::-1]), 5, half / 3)
             for a, b in zip(corners, np.roll(corners, 1, 0), strict=True)]
        )  # fmt: skip
        return gear(rng, "cone" if rng.random() < 0.4 else "disc", sides)
    if kind == 1:  # slalom poles
        return gear(rng, "pole", _row(rng, centre, turn, int(rng.integers(5, 11)), 1.5))
    if kind == 2:  # a wall of dummies before a goal's worth of cones
        wall = _row(rng, centre, turn, int(rng.integers(3, 6)), 0.65)
        return gear(rng, "dummy", wall + [0, 0, np.pi / 2])
    hurdles = _row(rng, centre + aside, turn, int(rng.integers(4, 9)), 1.1)
    ladder = np.array([[*(centre - aside), turn]])
    return merge([gear(rng, "hurdle", hurdles), gear(rng, "ladder", ladder)])


def _squad(rng: np.random.Generator, pitch: Pitch, count: int) -> Piece:
    """Players at practice in groups of about six, each at its exercise, and a coach."""
    x, y = pitch.length_m / 2, pitch.width_m / 2
    models, people = [], []
    groups = max(round(x * y / 260), 1)
    centres = rng.uniform([-0.8 * x, -0.75 * y], [0.8 * x, 0.75 * y], (groups, 2))
    busy = rng.permutation(groups)[: max(count // 5, 1)]
    for number, centre in enumerate(centres):
        models.append(_drill(rng, centre))
        models.append(balls(centre + rng.normal(0, 3.5, (int(rng.integers(1, 6)), 2))))
        if number not in busy:
            continue
        around = centre + rng.normal(0, 4.0, (5, 2))
        heading = np.arctan2(*(centre - around).T[::-1]) + rng.normal(0, 0.6, 5)
        places = np.column_stack([around, heading])
        kits = [str(kit) for kit in rng.choice(["home", "bib"], 3)]
        people += [("running", kits[0], places[:2]), ("standing", kits[1], places[2:4])]
        people.append(("player_kick", kits[2], places[4:]))
    coach = [[*(centres[0] + 2.5), rng.uniform(0, 6.28)]]
    people.append(("standing", "coach", np.array(coach)))
    return Piece(models=models, people=people)


def _around(rng: np.random.Generator, pitch: Pitch, side: int) -> list[Model]:
    """Ball stops behind the goals; a rail, a net or a fence along the sides."""
    x, y = pitch.length_m / 2 + _MARGIN_M, pitch.width_m / 2 + _MARGIN_M
    models: list[Model] = []
    for s in (-1, 1):
        reach = min(max(rng.uniform(0.45, 1.0) * y, 9.0), y)
        end = np.array([[s * (x + 1.2), -reach], [s * (x + 1.2), reach]])
        models.append(ball_stop(rng, end, rng.uniform(5.0, 8.0)))
    if pitch.synthetic:
        models += enclosure(
            rng, (2 * x + 1.6, 2 * y + 0.8), "chain_link", float(rng.choice([1.2, 3.0, 4.0])), 3
        )
        return models
    chance = rng.random()
    if chance < 0.45:
        line = np.array([[-0.85 * x, side * (y + 0.4)], [0.85 * x, side * (y + 0.4)]])
        models.append(ball_stop(rng, line, rng.uniform(4, 6)))
    if chance > 0.25:
        sides = (
            [[-x, -side * y], [x, -side * y]] if chance < 0.45 else [[-x, side * y], [x, side * y]]
        )
        tint = (0.6, 0.6, 0.58) if rng.random() < 0.7 else (0.04, 0.08, 0.05)
        models.append(perimeter_rail(np.array(sides), tint))
    return models


def _goals(rng: np.random.Generator, pitch: Pitch, side: int) -> list[Model]:
    """Two goals on the lines, and a few spare ones."""
    x, y = pitch.length_m / 2, pitch.width_m / 2
    models = []
    for s, yaw in ((-1, 0.0), (1, np.pi)):
        own = goal(rng, *pitch.goal_m, portable=bool(rng.random() < 0.4))
        models.append(place(own, (s * x, 0, 0), yaw))
    for _ in range(int(rng.integers(1, 5))):
        spare = goal(rng, *_SPARE_GOALS_M[rng.integers(3)], portable=True)
        if rng.random() < 0.5:  # put aside
            models.append(
                place(spare, (rng.uniform(-0.8, 0.8) * x, -side * (y + 1.4), 0), side * np.pi / 2)
            )
        else:
            at = (rng.uniform(-0.7, 0.7) * x, rng.uniform(-0.6, 0.6) * y, 0)
            models.append(place(spare, at, rng.uniform(0, 6.28)))
    return models


def training_pitch(
    rng: np.random.Generator, size, *, synthetic: bool, wear: float, players: int, masts: int
) -> Piece:
    """A pitch with all around it on a rectangle of `size` (2,) [m].

    Args:
        rng: of all choices.
        size: of the land.
        synthetic: plastic grass, in a fence.
        wear: of the turf, 0 to 1.
        players: at practice.
        masts: floodlights, along both sides.
    """
    length, width = size[0] - 2 * (_MARGIN_M + 2.5), size[1] - 2 * (_MARGIN_M + 1.0)
    width = min(width, 0.72 * length)
    pitch = draw_pitch(rng, float(length), float(width), _MARGIN_M, synthetic=synthetic, wear=wear)
    side = int(rng.choice([-1, 1]))
    lines = soccer_lines(length, width)
    models = [
        paint(lines, "road_paint", (0.55, 0.55, 0.52))
        if synthetic
        else {("chalk", "ground"): flat_mesh(lines)},
        *_goals(rng, pitch, side),
        *_around(rng, pitch, side),
    ]
    height, lamps = rng.uniform(9, 14), int(rng.integers(1, 4))
    for k in range(masts):
        s = (-1, 1)[k % 2]
        x = ((k // 2 + 0.5) / ((masts + 1) // 2) - 0.5) * 0.85 * length
        at = (x, s * (width / 2 + _MARGIN_M + 0.9), 0)
        models.append(place(training_mast(rng, height, lamps), at, -s * np.pi / 2))
    if rng.random() < 0.6:
        models += corner_flags(rng, pitch, (0.5, 0.1, 0.02))
    squad = _squad(rng, pitch, players)
    edge = rectangle((length + 2 * _MARGIN_M + 2, width + 2 * _MARGIN_M))
    benches = np.array(
        [[rng.uniform(-0.4, 0.4) * length, -side * (width / 2 + 2.4)] for _ in range(2)]
    )
    tufts = points_along(edge.exterior, 0.3, rng)
    return Piece(
        models=[*models, *squad.models],
        patches=surfaces(rng, pitch),
        people=squad.people,
        furniture=[("bench", np.column_stack([benches, np.full(2, side * np.pi / 2)]))],
        tufts=tufts + rng.normal(0, 0.15, tufts.shape),
        keep_clear=[edge.buffer(0.8)],
    )
