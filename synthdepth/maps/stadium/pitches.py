"""Pitches: turf with stripes and wear, lines, goals, flags, players and training gear."""

import dataclasses

import numpy as np
import shapely

from synthdepth.maps.geometry import Model, place
from synthdepth.maps.stadium.courts import rectangle
from synthdepth.maps.stadium.markings import flat_mesh, soccer_lines
from synthdepth.maps.stadium.nets import GOAL_M, balls, corner_flag, goal
from synthdepth.maps.stadium.piece import Patch, Piece


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pitch:
    """A pitch; x along its length.

    Attributes:
        length_m, width_m: of the field of play.
        margin_m: of turf around it.
        synthetic: plastic grass.
        stripe_m: width of a mowing stripe.
        stripe_contrast: of neighbouring stripes, about the mean.
        wear: of goalmouths and centre, 0 to 1.
        goal_m: inner width and height of the goals.
    """

    length_m: float
    width_m: float
    margin_m: float
    synthetic: bool
    stripe_m: float
    stripe_contrast: float
    wear: float
    goal_m: tuple[float, float]


def draw_pitch(
    rng: np.random.Generator,
    length_m: float,
    width_m: float,
    margin_m: float,
    *,
    synthetic: bool,
    wear: float,
) -> Pitch:
    """A pitch of a size, with goals to match."""
    k = min(1.0, length_m / 90.0)
    goals = GOAL_M if k > 0.85 else ((5.0, 2.0) if k > 0.45 else (3.0, 2.0))
    count = 2 * round(length_m / rng.uniform(5.0, 6.0) / 2)
    return Pitch(
        length_m=length_m,
        width_m=width_m,
        margin_m=margin_m,
        synthetic=synthetic,
        stripe_m=length_m / max(count, 2),
        stripe_contrast=0.0 if synthetic or rng.random() < 0.12 else float(rng.uniform(0.07, 0.13)),
        wear=wear,
        goal_m=goals,
    )


def _blob(rng: np.random.Generator, x: float, y: float, rx: float, ry: float) -> shapely.Geometry:
    """An irregular patch of trodden ground."""
    n = 40
    turn = 2 * np.pi * np.arange(n) / n
    r = 1 + sum(
        rng.uniform(0.05, 0.22) / k * np.sin(k * turn + rng.uniform(0, 6.3))
        for k in (2, 3, 5, 8, 11)
    )
    return shapely.Polygon(
        np.column_stack([x + rx * r * np.cos(turn), y + ry * r * np.sin(turn)])
    ).buffer(0)


def surfaces(rng: np.random.Generator, pitch: Pitch) -> list[Patch]:
    """Turf with its stripes, worn where games wear it."""
    x, y, m = pitch.length_m / 2, pitch.width_m / 2, pitch.margin_m
    field = shapely.box(-x, -y, x, y)
    land = shapely.box(-x - m, -y - m, x + m, y + m)
    kind = "synthetic_turf" if pitch.synthetic else "turf"
    spots = [(-x + 3.0, 0, 5.5, 1.0), (x - 3.0, 0, 5.5, 1.0), (0, 0, 6.0, 0.5)]
    spots += [(s * (x - 11), 0, 2.0, 0.6) for s in (-1, 1)]
    # Linesmen and substitutes wear tracks along the touchlines.
    spots += [
        (e, s * (y + 0.8), 2.2, 0.35) for s in (-1, 1) for e in np.arange(-0.4 * x, 0.5 * x, 3.0)
    ]
    worn = np.array(spots)
    worn[:, 3] *= 0.0 if pitch.synthetic else pitch.wear
    shared = {"surface": (kind, "ground"), "worn": worn}
    patches = [
        Patch(
            area=field,
            cell_m=(pitch.stripe_m / 3, 2.0),
            origin_m=(-x, -y),
            stripes=3,
            stripe_contrast=pitch.stripe_contrast,
            rank=6,
            **shared,
        ),
        Patch(
            area=land,
            cell_m=(3.0, 3.0),
            origin_m=(-x, -y),
            rank=5,
            tint=(1.05, 0.98, 1.0),
            **shared,
        ),
    ]
    if pitch.wear > 0.25 and not pitch.synthetic:
        scale = 0.6 + 0.6 * pitch.wear
        mouths = [_blob(rng, s * (x - 2.2), 0, 2.6 * scale, 4.2 * scale) for s in (-1, 1)]
        mouths += [_blob(rng, s * (x - 11), 0, 0.9 * scale, 0.9 * scale) for s in (-1, 1)]
        mouths.append(_blob(rng, 0, 0, 2.0 * scale, 2.3 * scale))
        for _ in range(int(rng.integers(3, 9))):
            mouths.append(
                _blob(rng, rng.uniform(-x, x), rng.uniform(-y, y), *rng.uniform(0.4, 1.8, 2))
            )
        patches.append(
            Patch(
                area=shapely.union_all(mouths),
                surface=("worn_turf", "ground"),
                cell_m=(2.0, 2.0),
                rank=8,
            )
        )
        if pitch.wear > 0.6:
            bare = [_blob(rng, s * (x - 1.6), 0, 1.0, 2.2) for s in (-1, 1)]
            patches.append(Patch(area=shapely.union_all(bare), surface=("soil", "ground"), rank=9))
    return patches


def corner_flags(rng: np.random.Generator, pitch: Pitch, tint) -> list[Model]:
    """The four flags of a pitch."""
    x, y = pitch.length_m / 2, pitch.width_m / 2
    return [place(corner_flag(rng, tint), (s * x, t * y, 0)) for s in (-1, 1) for t in (-1, 1)]


def match(rng: np.random.Generator, pitch: Pitch, count: int) -> list[tuple[str, str, np.ndarray]]:
    """Two teams at play, their keepers and three officials."""
    x, y = pitch.length_m / 2, pitch.width_m / 2
    ball = np.array([rng.uniform(-0.6, 0.6) * x, rng.uniform(-0.6, 0.6) * y])
    people = []
    for team, side in (("home", -1), ("away", 1)):
        n = max(count // 2 - 1, 1)
        spread = np.column_stack([rng.uniform(-0.75, 0.75, n) * x, rng.uniform(-0.9, 0.9, n) * y])
        spread = 0.65 * spread + 0.35 * (ball + rng.normal(0, 6, (n, 2)))
        spread = np.clip(spread, [-x + 1, -y + 1], [x - 1, y - 1])
        to_ball = ball - spread
        heading = np.arctan2(to_ball[:, 1], to_ball[:, 0]) + rng.normal(0, 0.5, n)
        near = np.hypot(*to_ball.T).argsort()
        places = np.column_stack([spread, heading])[near]
        people.append(("player_kick", team, places[:1]))
        people.append(("running", team, places[1 : 1 + n // 2]))
        people.append(("standing", team, places[1 + n // 2 :]))
        keeper = [[side * (x - rng.uniform(1, 7)), rng.uniform(-2, 2), 0 if side < 0 else np.pi]]
        people.append(("standing", "keeper", np.array(keeper)))
    people.append(("running", "referee", np.array([[*(ball + [8, 6]), 3.9]])))
    for s in (-1, 1):
        at = [[rng.uniform(-0.4, 0.4) * x, s * (y + 0.7), -s * np.pi / 2]]
        people.append(("running", "referee", np.array(at)))
    return people


def main_pitch(rng: np.random.Generator, pitch: Pitch, flag_tint, players: int) -> Piece:
    """The main pitch, a match on it."""
    x = pitch.length_m / 2
    lines = soccer_lines(pitch.length_m, pitch.width_m)
    cord = (0.62, 0.62, 0.6)
    models = [{("chalk", "ground"): flat_mesh(lines)}]
    models += [
        place(goal(rng, *pitch.goal_m, cord_tint=cord), (s * x, 0, 0), 0.0 if s < 0 else np.pi)
        for s in (-1, 1)
    ]
    models += corner_flags(rng, pitch, flag_tint)
    models.append(balls(rng.uniform(-0.5, 0.5, (1, 2)) * [pitch.length_m, pitch.width_m]))
    return Piece(
        models=models,
        patches=surfaces(rng, pitch),
        people=match(rng, pitch, players),
        keep_clear=[rectangle((pitch.length_m, pitch.width_m)).buffer(pitch.margin_m)],
    )
