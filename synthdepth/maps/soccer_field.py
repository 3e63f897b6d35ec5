"""The map `soccer_field`: a town's sports ground, from a village club to a stadium."""

import dataclasses

import numpy as np

from synthdepth.config import Config, number, span
from synthdepth.maps.geometry import merge
from synthdepth.maps.materials.catalogue import bake_materials
from synthdepth.maps.skyline import skyline
from synthdepth.maps.stadium.arena import draw_arena
from synthdepth.maps.stadium.greenery import site_greenery, town_greenery
from synthdepth.maps.stadium.layout import draw_layout
from synthdepth.maps.stadium.neighbours import neighbours
from synthdepth.maps.stadium.piece import drape, turned
from synthdepth.maps.stadium.site import SportsGround, build_site, site_models
from synthdepth.maps.stadium.town import draw_surroundings, draw_town
from synthdepth.maps.terrain import draw_terrain, outskirts
from synthdepth.maps.world import Light, World, assemble
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class SoccerFieldRanges(Config):
    """What a sports ground is drawn from; ranges are drawn once a scene.

    Attributes:
        grandeur: 0 for a village club, 1 for a stadium; sizes and equipment follow from it.
        ground_m: sides of the whole sports ground.
        stand_sides: sides of the main pitch that have a stand.
        stand_rows: rows of seats of a stand, drawn for each.
        covered_share: share of the stands with a roof; the main stand always has one.
        floodlight_masts: around the main pitch.
        mast_height_m: of those masts.
        track_share: share of the grounds with a running track around the main pitch.
        training_pitches: full and small ones that are laid out first, as many as fit.
        training_masts: at each training pitch.
        courts: tennis, basketball and five-a-side courts that follow, as many as fit.
        grove_share: of the land beside the main ground, what groves take; more pitches and courts
            take the rest.
        trees_per_hectare: in the groves between.
        wear: of the pitches: 0 fresh, 1 at the end of a wet winter.
        occupied_share: share of the seats that spectators take.
        spectators: on the stands, at most.
        players: on the main pitch.
        training_players: on each training pitch.
        parked_share: share of the bays of the car park that are taken.
        street_parked_share: share of the places along the kerbs that a car takes.
        house_rows: rows of streets with houses around the ground; fields beyond.
        skyline_share: share of the scenes with a city on the horizon.
        flight_area_m: side of the square in the middle that flights keep to.
    """

    grandeur: tuple[float, float] = span((0.0, 1.0), 0, 1)
    ground_m: tuple[float, float] = span((300, 430), 220, 520)
    stand_sides: tuple[float, float] = span((1, 4), 0, 4)
    stand_rows: tuple[float, float] = span((4, 24), 3, 40)
    covered_share: tuple[float, float] = span((0.4, 1.0), 0, 1)
    floodlight_masts: tuple[float, float] = span((2, 8), 0, 8)
    mast_height_m: tuple[float, float] = span((14, 36), 8, 60)
    track_share: float = number(0.3, 0.0, 1.0)
    training_pitches: tuple[float, float] = span((5, 9), 0, 16)
    training_masts: tuple[float, float] = span((2, 6), 0, 12)
    courts: tuple[float, float] = span((4, 8), 0, 16)
    grove_share: tuple[float, float] = span((0.1, 0.3), 0, 1)
    trees_per_hectare: tuple[float, float] = span((50, 110), 0, 400)
    wear: tuple[float, float] = span((0.1, 1.0), 0, 1)
    occupied_share: tuple[float, float] = span((0.02, 0.35), 0, 1)
    spectators: int = number(350, 0, 20000)
    players: tuple[float, float] = span((14, 22), 0, 22)
    training_players: tuple[float, float] = span((6, 18), 0, 40)
    parked_share: tuple[float, float] = span((0.25, 0.7), 0, 1)
    street_parked_share: tuple[float, float] = span((0.05, 0.3), 0, 1)
    house_rows: tuple[float, float] = span((1, 2.6), 1, 5)
    skyline_share: float = number(0.35, 0.0, 1.0)
    flight_area_m: float = number(400.0, 150, 900)


_TREE_MIXES = (
    {"oak": 4, "maple": 4, "birch": 3, "young": 2, "poplar": 2},
    {"maple": 4, "poplar": 3, "willow": 2, "birch": 2, "young": 2, "bare": 1},
    {"pine": 4, "spruce": 2, "birch": 3, "maple": 2, "young": 2},
    {"palm": 3, "cypress": 3, "pine": 4, "oak": 2, "young": 1},
    {"oak": 4, "willow": 1, "cypress": 1, "maple": 3, "pine": 2, "young": 2},
)
_STREET_TREES = ("maple", "oak", "birch", "palm", "poplar")


def draw_sports_ground(rng: np.random.Generator, ranges: SoccerFieldRanges) -> SportsGround:
    """The character and the plan of one ground."""
    lanes = rng.spawn(3)
    grandeur = float(rng.uniform(*ranges.grandeur))

    def graded(name: str, spread: float = 0.25) -> float:
        """Within a range by grandeur, give or take."""
        low, high = getattr(ranges, name)
        return float(low + (high - low) * np.clip(grandeur + rng.uniform(-spread, spread), 0, 1))

    def drawn(name: str) -> float:
        return float(rng.uniform(*getattr(ranges, name)))

    rows_low, rows_high = ranges.stand_rows
    rows = graded("stand_rows")
    arena = draw_arena(
        lanes[0],
        grandeur=grandeur,
        sides=round(graded("stand_sides")),
        rows=(max(rows_low, 0.75 * rows), min(rows_high, 1.2 * rows)),
        covered_share=drawn("covered_share"),
        mast_count=round(graded("floodlight_masts")),
        mast_m=graded("mast_height_m", 0.15),
        track=bool(rng.random() < ranges.track_share and grandeur > 0.25),
        wear=drawn("wear") * (1 - 0.6 * grandeur),
        occupied=drawn("occupied_share"),
        spectators=ranges.spectators,
        players=round(drawn("players")),
    )
    half = np.array([graded("ground_m"), graded("ground_m")]) / 2
    half = np.maximum(half, np.array(arena.half_m) + [14.0, 40.0])
    half = np.minimum(half, 0.5 * ranges.flight_area_m + 60)
    half = np.maximum(half, np.array(arena.half_m) + [12.0, 34.0])
    layout = draw_layout(
        lanes[1],
        half,
        arena.half_m,
        _wanted(rng, ranges),
        float(rng.choice([18.0, 34.0])),
        rng.uniform(2.0, 3.4),
        drawn("grove_share"),
    )
    yaw = float(rng.uniform(-np.pi, np.pi))
    mix = _TREE_MIXES[rng.integers(len(_TREE_MIXES))]
    street = [name for name in _STREET_TREES if name in mix]
    return SportsGround(
        arena=arena,
        layout=layout,
        at=-turned(0.5 * layout.arena_at[None], (0, 0), yaw)[0],
        yaw_rad=yaw,
        tree_mix=mix,
        rows=round(drawn("house_rows")),
        skyline=bool(rng.random() < ranges.skyline_share),
        surroundings=draw_surroundings(
            lanes[2], street[rng.integers(len(street))], drawn("street_parked_share")
        ),
        wear=drawn("wear"),
        parked_share=drawn("parked_share"),
        trees_per_hectare=drawn("trees_per_hectare"),
        training_players=round(drawn("training_players")),
        training_masts=round(drawn("training_masts")),
        flight_area_m=ranges.flight_area_m,
    )


def _wanted(rng: np.random.Generator, ranges: SoccerFieldRanges) -> list[str]:
    """Kinds of plots, most wanted first."""
    pitches = round(rng.uniform(*ranges.training_pitches))
    courts = round(rng.uniform(*ranges.courts))
    kinds = ["pitch", "small_pitch", "mini_pitch", "pitch", "small_pitch", "mini_pitch"]
    first = ["clubhouse"] + [kinds[k % len(kinds)] for k in range(pitches)]
    games = ["tennis", "cage", "basketball", "tennis", "cage"]
    shift = int(rng.integers(len(games)))
    rest = [games[(k + shift) % len(games)] for k in range(courts)]
    rest += ["playground", "yard", "skate", "playground", "mini_pitch"]
    wanted = first[:3] + [str(kind) for kind in rng.permutation(first[3:7] + rest[:5])]
    return wanted + first[7:] + rest[5:]


def soccer_field(scene_seed: int, ranges: SoccerFieldRanges, light: Light) -> World:
    """Build the sports ground of a scene seed."""
    club = draw_sports_ground(lane(scene_seed, "character"), ranges)
    # Grounds are levelled: their falls drain the rain, no more.
    terrain = draw_terrain(lane(scene_seed, "terrain"), slope_range=(0.003, 0.008))
    half_m = club.layout.half_m
    town = draw_town(lane(scene_seed, "streets"), half_m, club.at, club.yaw_rad, rows=club.rows)
    half = club.flight_area_m / 2
    bounds = np.array([[-half, -half], [half, half]])

    site, spectators = build_site(lane(scene_seed, "site"), club)
    drives = [turned(drive, club.at, club.yaw_rad) for drive in club.layout.drives]
    models, lots, streets = neighbours(
        lane(scene_seed, "town"), town.plan, club.surroundings, drives, terrain, bounds
    )
    things = lane(scene_seed, "things")
    flat = merge(site_models(things, club, town.site, site, spectators, bounds))
    models.append(drape(flat, terrain))
    plants = lane(scene_seed, "plants")
    models += site_greenery(plants, club.tree_mix, town.site, site, terrain, bounds)
    plants = lane(scene_seed, "town plants")
    tree = club.surroundings.street_tree
    models += town_greenery(
        plants, club.tree_mix, tree, town.country, terrain, lots, streets, bounds
    )
    models.append(outskirts(terrain))
    if club.skyline:
        rng = lane(scene_seed, "skyline")
        near, tallest = rng.uniform(1300, 2200), rng.uniform(60, 200)
        models.append(
            skyline(rng, near, near + 1500, tallest_m=tallest, count=140, ground_m=terrain.height_m)
        )
    surfaces = assemble(models)
    return World(
        map="soccer_field",
        scene_seed=scene_seed,
        surfaces=surfaces,
        materials=bake_materials(lane(scene_seed, "materials"), [name for name, _ in surfaces]),
        light=light,
        flight_bounds=bounds,
        ground_m=terrain.height_m,
    )
