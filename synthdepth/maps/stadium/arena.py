"""The main ground: pitch, stands, masts and everything between them, as one piece."""

import dataclasses

import numpy as np
import shapely

from synthdepth.maps.geometry import Model, place
from synthdepth.maps.placement import points_along
from synthdepth.maps.stadium.markings import oval, paint, track_lines
from synthdepth.maps.stadium.masts import stadium_mast
from synthdepth.maps.stadium.piece import Patch, Piece, moved
from synthdepth.maps.stadium.pitches import Pitch, draw_pitch, main_pitch
from synthdepth.maps.stadium.stands import Stand, club_colours, draw_stand, seats, stand_model
from synthdepth.maps.stadium.touchline import (
    boards,
    dugout,
    flags,
    gantry,
    perimeter_rail,
    scoreboard,
    tunnel,
)

TRACK_RADIUS_M, TRACK_STRAIGHT_M, LANE_M = 36.5, 84.39, 1.22
_SIDES = {"north": 0.0, "east": -np.pi / 2, "south": np.pi, "west": np.pi / 2}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Arena:
    """The main ground; x along the pitch.

    Attributes:
        pitch: the pitch.
        colours: (2, 3) of the club.
        lanes: of the running track around the pitch; 0 without one.
        stands: by side ("north" is +y): the stand and the distance of its front from the centre.
        rail_m: half sizes of the rail around the pitch.
        half_m: half sizes of all of it, with the ways around the stands.
        masts: (k, 2).
        mast_kind: "lattice" or "tube".
        mast_m: height.
        mast_lamps: rows and columns.
        occupied: share of the seats that are taken.
        spectators: at most.
        players: on the pitch.
        boards_share: of the rail that has advertising boards.
    """

    pitch: Pitch
    colours: np.ndarray
    lanes: int
    stands: dict[str, tuple[Stand, float]]
    rail_m: tuple[float, float]
    half_m: tuple[float, float]
    masts: np.ndarray
    mast_kind: str
    mast_m: float
    mast_lamps: tuple[int, int]
    occupied: float
    spectators: int
    players: int
    boards_share: float


def draw_arena(
    rng: np.random.Generator,
    *,
    grandeur: float,
    sides: int,
    rows: tuple[float, float],
    covered_share: float,
    mast_count: int,
    mast_m: float,
    track: bool,
    wear: float,
    occupied: float,
    spectators: int,
    players: int,
) -> Arena:
    """The main ground of a club.

    Args:
        rng: of all choices.
        grandeur: 0 for a village club, 1 for a stadium.
        sides: how many have a stand.
        rows: range of the rows of the stands.
        covered_share: of the stands.
        mast_count: floodlight masts, 0 to 8.
        mast_m: their height.
        track: a running track lies around the pitch.
        wear: of the pitch, 0 to 1.
        occupied: share of the seats.
        spectators: at most.
        players: on the pitch.
    """
    colours = club_colours(rng)
    if track:
        length, width = 100.0 + rng.uniform(0, 5), 64.0 + rng.uniform(0, 4)
    else:
        length = 105.0 if grandeur > 0.5 and rng.random() < 0.7 else rng.uniform(95, 108)
        width = 68.0 if length == 105.0 else rng.uniform(60, 70)
    pitch = draw_pitch(
        rng, float(length), float(width), rng.uniform(3.0, 5.0), synthetic=False, wear=wear
    )
    lanes = int(rng.choice([6, 8])) if track else 0
    if track:
        outer = TRACK_RADIUS_M + lanes * LANE_M + 1.5
        rail = (TRACK_STRAIGHT_M / 2 + outer, outer)
    else:
        rail = (length / 2 + pitch.margin_m + 0.6, width / 2 + pitch.margin_m + 0.6)
    order = (
        ["north", "south", "east", "west"]
        if rng.random() < 0.7
        else ["north", "west", "south", "east"]
    )
    stands: dict[str, tuple[Stand, float]] = {}
    half = [rail[0] + 3.0, rail[1] + 3.0]
    for k, side in enumerate(order[:sides]):
        n = round(rng.uniform(*rows) * (1.0 if k == 0 else rng.uniform(0.5, 1.0)))
        along = 0 if side in ("north", "south") else 1
        room = 2 * (length, width)[along] / 2
        share = np.clip(0.25 + 0.05 * n + 0.3 * grandeur + rng.uniform(-0.15, 0.15), 0.22, 1.05)
        covered = rng.random() < covered_share or k == 0
        stand = draw_stand(rng, float(max(room * share, 12.0)), max(n, 3), covered, colours)
        front = rail[1 - along] + rng.uniform(2.2, 3.2)
        stands[side] = (stand, front)
        half[1 - along] = max(half[1 - along], front + stand.depth_m + 3.5)
    corner = np.array([rail[0] + 5.0, rail[1] + 6.0])
    if mast_count <= 0:
        masts = np.zeros((0, 2))
    elif mast_count < 5:
        masts = corner * np.array([[1, 1], [-1, 1], [-1, -1], [1, -1]])[:mast_count]
    else:
        x = (np.arange(mast_count // 2) / max(mast_count // 2 - 1, 1) - 0.5) * 1.6 * rail[0]
        depth = [half[1] - 1.0 if s in stands else rail[1] + 4.0 for s in ("north", "south")]
        masts = np.concatenate(
            [
                np.column_stack([x, np.full(len(x), s * d)])
                for s, d in zip((1, -1), depth, strict=True)
            ]
        )
    half = [max(half[0], corner[0] + 3.0), max(half[1], corner[1] + 3.0)]
    return Arena(
        pitch=pitch,
        colours=colours,
        lanes=lanes,
        stands=stands,
        rail_m=rail,
        half_m=(float(half[0]), float(half[1])),
        masts=masts,
        mast_kind=str(rng.choice(["lattice", "tube"])),
        mast_m=mast_m,
        mast_lamps=(int(rng.integers(2, 4)), int(rng.integers(3, 5))) if mast_m > 20 else (1, 3),
        occupied=occupied,
        spectators=spectators,
        players=players,
        boards_share=float(np.clip(0.2 + 0.8 * grandeur + rng.uniform(-0.1, 0.2), 0, 1)),
    )


def _track(arena: Arena, tint) -> Piece:
    """Lanes, the bends' inner fields and a long-jump pit."""
    r0, r1 = TRACK_RADIUS_M, TRACK_RADIUS_M + arena.lanes * LANE_M
    inner, outer = (shapely.Polygon(oval(TRACK_STRAIGHT_M, r)) for r in (r0, r1))
    runway = shapely.box(-30.0, r1 + 1.0, 12.0, r1 + 2.3)
    pit = shapely.box(12.0, r1 + 0.4, 20.0, r1 + 3.2)
    lines = track_lines(TRACK_STRAIGHT_M, r0, arena.lanes)
    return Piece(
        models=[paint(lines, "road_paint", (0.62, 0.62, 0.6))],
        patches=[
            Patch(
                area=outer.difference(inner),
                surface=("rubber_floor", "ground"),
                tint=tuple(tint),
                rank=4,
            ),
            Patch(area=runway, surface=("rubber_floor", "ground"), tint=tuple(tint), rank=7),
            Patch(area=pit, surface=("gravel", "ground"), tint=(1.35, 1.25, 1.0), rank=7),
            Patch(area=inner, surface=("turf", "ground"), rank=3),
        ],
    )


def _rail_path(arena: Arena) -> np.ndarray:
    if arena.lanes:
        radius = TRACK_RADIUS_M + arena.lanes * LANE_M + 1.4
        ring = oval(TRACK_STRAIGHT_M, radius)[::2]
        return np.concatenate([ring, ring[:1]])
    x, y = arena.rail_m
    return np.array([[x, y], [-x, y], [-x, -y], [x, -y], [x, y]], float)


def _crowd(rng: np.random.Generator, stand: Stand, share: float) -> tuple[list, list[np.ndarray]]:
    """Who sits and stands on a stand: (pose, kit, places), and their heights (k,)."""
    at, _ = seats(stand)
    # People come in groups: a slow wave decides where it is full.
    wave = np.sin(at[:, 0] / 5 + rng.uniform(0, 6)) * np.sin(at[:, 1] / 2.1 + rng.uniform(0, 6))
    taken = rng.random(len(at)) < share * np.clip(1 + 0.9 * wave, 0.1, 1.9)
    places = at[taken]
    mood = rng.random(len(places))
    sitting = mood < (0.9 if stand.seating != "standing" else 0.0)
    arms = mood > 0.96
    poses = {"sitting": sitting & ~arms, "arms_up": arms, "standing": ~sitting & ~arms}
    people, heights = [], []
    for pose, mask in poses.items():
        p = places[mask]
        shift = {"sitting": 0.0, "arms_up": -0.12, "standing": -0.1}[pose]
        turn = -np.pi / 2 + rng.normal(0, 0.15, len(p))
        people.append((pose, "", np.column_stack([p[:, 0], p[:, 1] + shift, turn])))
        heights.append(p[:, 2])
    return people, heights


def arena_piece(
    rng: np.random.Generator, arena: Arena
) -> tuple[Piece, list[tuple[str, np.ndarray]]]:
    """Build the main ground.

    Returns:
        The piece, and the spectators on its stands as (pose, (k, 4) x, y, height and heading).
    """
    lanes = rng.spawn(10)
    piece = main_pitch(lanes[0], arena.pitch, arena.colours[0], arena.players)
    models, patches = piece.models, piece.patches
    if arena.lanes:
        tint = np.array([(0.26, 0.07, 0.045), (0.2, 0.06, 0.04), (0.06, 0.12, 0.24)])[
            lanes[1].integers(3)
        ]
        ring = _track(arena, tint)
        models += ring.models
        patches += ring.patches
    rail = _rail_path(arena)
    models.append(perimeter_rail(rail, (0.6, 0.6, 0.58)))
    models.append(boards(lanes[2], 0.985 * rail, 1.0, arena.boards_share))
    x, y = arena.rail_m
    inside = shapely.Polygon(rail)
    ways = inside.buffer(2.6, join_style="mitre", mitre_limit=1.5)
    patches.append(
        Patch(area=ways.difference(inside.buffer(0.4)), surface=("asphalt", "pavement"), rank=2)
    )
    patches.append(
        Patch(area=inside.buffer(0.4), surface=("turf", "ground"), rank=2, tint=(1.04, 1.0, 1.0))
    )
    spectators: list[tuple[str, np.ndarray]] = []
    places = sum(len(seats(stand)[0]) for stand, _ in arena.stands.values())
    share = min(arena.occupied, arena.spectators / max(places, 1))
    people, clear = piece.people, piece.keep_clear
    for k, (side, (stand, front)) in enumerate(arena.stands.items()):
        lane = lanes[3].spawn(1)[0]
        yaw = _SIDES[side]
        out = np.array([-np.sin(yaw), np.cos(yaw)])
        at = front * out
        models.append(place(stand_model(lane, stand), (*at, 0), yaw))
        foot = shapely.box(
            -stand.length_m / 2 - 2.5, -1.5, stand.length_m / 2 + 2.5, stand.depth_m + 3.0
        )
        apron = Piece(
            patches=[Patch(area=foot, surface=("asphalt", "pavement"), rank=1)], keep_clear=[foot]
        )
        apron = moved(apron, at, yaw)
        patches += apron.patches
        clear += apron.keep_clear
        crowd, heights = _crowd(lane, stand, share)
        for (pose, _, places), height in zip(crowd, heights, strict=True):
            turned = moved(Piece(people=[(pose, "", places)]), at, yaw).people[0][2]
            spectators.append((pose, np.column_stack([turned[:, :2], height, turned[:, 2]])))
        if k == 0:
            models.append(
                place(
                    tunnel(max(front - y + 0.2, 2.5), arena.colours[0] * 0.8 + 0.03),
                    (*(y + 0.4) * out, 0),
                    yaw,
                )
            )
    models += _beside(lanes[4], arena, people)
    drop = np.arctan2(arena.mast_m, 0.75 * np.hypot(x, y))
    for mx, my in arena.masts:
        aim = np.arctan2(-my, 0.25 * mx - mx)
        rows, columns = arena.mast_lamps
        models.append(
            place(
                stadium_mast(lanes[5], arena.mast_m, arena.mast_kind, rows, columns, drop),
                (mx, my, 0),
                aim,
            )
        )
        clear.append(shapely.Point(mx, my).buffer(3.0))
    # Those who lean on the rail.
    along = points_along(shapely.LineString(1.03 * rail), 9.0, lanes[6])
    along = along[lanes[6].random(len(along)) < min(1.0, 1.6 * arena.occupied + 0.15)]
    free = shapely.union_all(clear[1:] or [shapely.Polygon()])
    along = along[~shapely.contains_xy(free, along[:, 0], along[:, 1])]
    people.append(
        ("standing", "", np.column_stack([along, np.arctan2(-along[:, 1], -along[:, 0])]))
    )
    edge = points_along(shapely.LineString(0.98 * rail), 0.3, lanes[7])
    clear.append(inside.buffer(2.6))
    return (
        Piece(
            models=models,
            patches=patches,
            people=people,
            tufts=edge + lanes[7].normal(0, 0.12, edge.shape),
            keep_clear=clear,
        ),
        spectators,
    )


def _beside(rng: np.random.Generator, arena: Arena, people: list) -> list[Model]:
    """Dugouts with substitutes, gantry, scoreboard, flags."""
    x, y = arena.rail_m
    models: list[Model] = []
    edge = arena.pitch.width_m / 2
    line = edge + max(arena.pitch.margin_m - 1.4, 1.6)
    if arena.lanes:
        line = min(line, TRACK_RADIUS_M - 1.2)
    long = float(rng.uniform(4.5, 8.0))
    for s, kit in ((-1, "home"), (1, "away")):
        at = s * rng.uniform(9, 13)
        models.append(place(dugout(rng, long, arena.colours[0]), (at, line, 0)))
        n = int(rng.integers(3, 7))
        spots = at + (np.arange(n) - n / 2) * 0.55
        people.append(
            (
                "standing",
                kit,
                np.column_stack(
                    [spots[:2] * 0 + at + [-1.5, 1.8], np.full(2, line - 2.0), np.full(2, -1.6)]
                ),
            )
        )
        people.append(("standing", "coach", np.array([[at + 0.5, line - 1.9, -np.pi / 2]])))
    if "south" in arena.stands:
        if "east" not in arena.stands:
            spot = (x + 2.5, rng.uniform(-0.6, 0.6) * y, 0)
            models.append(place(gantry(rng), spot, -np.pi / 2))
    else:
        models.append(place(gantry(rng), (rng.uniform(-0.3, 0.3) * x, -y - 1.8, 0), np.pi))
    end = -1 if "east" in arena.stands else 1
    free_end = "west" if end < 0 else "east"
    wide = float(rng.uniform(4.0, 7.0) + 3.0 * (arena.mast_m > 24))
    if free_end in arena.stands:
        stand, front = arena.stands[free_end]
        shift = stand.length_m / 2 + wide / 2 + 1.5
        place_x, place_y = end * (front + 2.0), min(shift, y)
    else:
        place_x, place_y = end * (x + 2.6), rng.uniform(-0.5, 0.5) * y
    models.append(
        place(
            scoreboard(rng, wide, rng.uniform(2.4, 4.0)),
            (place_x, place_y, 0),
            0.0 if end < 0 else np.pi,
        )
    )
    poles = np.array(
        [[-end * (x + 3.5), t] for t in np.linspace(-0.5, 0.5, int(rng.integers(3, 7))) * y]
    )
    side = "east" if end < 0 else "west"
    if side not in arena.stands:
        models.append(flags(rng, poles, 7.5, arena.colours))
    return models
