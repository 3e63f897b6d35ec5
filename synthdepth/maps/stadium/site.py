"""The whole sports ground: its character, and everything on it but the plants."""

import dataclasses

import numpy as np
import shapely
from scipy.spatial import cKDTree

from synthdepth.maps.furniture.signs import street_lamps
from synthdepth.maps.furniture.street_furniture import FURNITURE, scatter_furniture
from synthdepth.maps.gardens.items import scatter
from synthdepth.maps.geometry import Model
from synthdepth.maps.people import people
from synthdepth.maps.placement import distance_to, points_along, points_within
from synthdepth.maps.stadium.arena import Arena, arena_piece
from synthdepth.maps.stadium.courts import basketball, cage, tennis
from synthdepth.maps.stadium.greens import club_garden, grove, yard
from synthdepth.maps.stadium.layout import GAP_M, Layout, Plot
from synthdepth.maps.stadium.parking import car_park
from synthdepth.maps.stadium.piece import Patch, Piece, moved, together, turned
from synthdepth.maps.stadium.playgrounds import playground, skate_park
from synthdepth.maps.stadium.practice import training_pitch
from synthdepth.maps.stadium.surfaces import Drift, ground
from synthdepth.maps.stadium.town import Surroundings
from synthdepth.maps.vehicles.vehicle import park

_KITS = {
    "keeper": (0.3, 0.42, 0.05),
    "referee": (0.02, 0.02, 0.022),
    "bib": (0.5, 0.17, 0.02),
    "coach": (0.03, 0.04, 0.09),
}
# `park` shows cars in full up to 80 m: that much only of those that a drone can come near.
_CAR_DETAIL_M = 68.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class SportsGround:
    """The character of one ground, drawn from `SoccerFieldRanges`.

    Attributes:
        arena: the main ground.
        layout: who gets which part of the site.
        at: (2,) middle of the site on the map [m].
        yaw_rad: its turn.
        tree_mix: weight of each species.
        rows: of streets around.
        skyline: whether a city stands on the horizon.
        surroundings: the streets' character.
        wear, parked_share, trees_per_hectare, training_players, training_masts: see the ranges.
        flight_area_m: see the ranges.
    """

    arena: Arena
    layout: Layout
    at: np.ndarray
    yaw_rad: float
    tree_mix: dict[str, float]
    rows: int
    skyline: bool
    surroundings: Surroundings
    wear: float
    parked_share: float
    trees_per_hectare: float
    training_players: int
    training_masts: int
    flight_area_m: float


def _plot_piece(rng: np.random.Generator, plot: Plot, club: SportsGround) -> Piece:
    """What stands on a plot, in its own frame."""
    size = plot.size
    if plot.kind in ("pitch", "small_pitch", "mini_pitch"):
        return training_pitch(
            rng,
            size,
            synthetic=bool(rng.random() < 0.25),
            wear=float(np.clip(club.wear + rng.uniform(-0.2, 0.2), 0, 1)),
            players=club.training_players,
            masts=club.training_masts,
        )
    if plot.kind == "parking":
        return car_park(
            rng, size, club.parked_share, int(rng.integers(0, 4)) if size[1] > 20 else 0
        )
    if plot.kind == "clubhouse":
        return club_garden(rng, size, club.arena.colours)
    if plot.kind == "grove":
        return grove(rng, size, club.trees_per_hectare)
    if plot.kind == "cage":
        return cage(rng, size, bool(rng.random() < 0.7))
    return {
        "tennis": tennis, "basketball": basketball, "playground": playground, "skate": skate_park,
        "yard": yard,
    }[plot.kind](rng, size)  # fmt: skip


def build_site(
    rng: np.random.Generator, club: SportsGround
) -> tuple[Piece, list[tuple[str, np.ndarray]]]:
    """The whole ground on a plane, in the map's frame.

    Returns:
        The ground as one piece, and the spectators on its stands as (pose, (k, 4) x, y, height
        above the ground and heading).
    """
    layout = club.layout
    lanes = rng.spawn(2 + len(layout.plots))
    main, crowd = arena_piece(lanes[0], club.arena)
    pieces = [moved(main, layout.arena_at, 0.0)]
    for lane, plot in zip(lanes[2:], layout.plots, strict=True):
        pieces.append(moved(_plot_piece(lane, plot, club), plot.centre, plot.yaw_rad))
    surface = ("asphalt", "paving", "gravel")[lanes[1].integers(3)]
    patches = [Patch(area=layout.paths, surface=(surface, "pavement"), rank=1)]
    patches += [
        Patch(area=shapely.Polygon(drive), surface=("asphalt", "road"), rank=2)
        for drive in layout.drives
    ]
    pieces.append(Piece(patches=patches, **_between(lanes[1], layout)))
    site = _cleared(together(pieces), layout)
    placed = []
    for pose, p in crowd:
        xy = np.column_stack([p[:, :2] + layout.arena_at, p[:, 3]])
        xy = turned(xy, club.at, club.yaw_rad)
        placed.append((pose, np.column_stack([xy[:, :2], p[:, 2], xy[:, 2]])))
    return moved(site, club.at, club.yaw_rad), placed


def _between(rng: np.random.Generator, layout: Layout) -> dict:
    """Lamps, benches and walkers of the paths; tree rows between the plots and along the edge."""
    edges = layout.paths.boundary
    lamps = _apart(points_along(edges, 30.0, rng), 20.0)
    benches = _apart(points_along(layout.paths.buffer(0.7).boundary, 40.0, rng), 12.0)
    bins = _apart(points_along(layout.paths.buffer(0.5).boundary, 90.0, rng), 30.0)
    walkers = points_within(rng, layout.paths, 40, 3.0)
    cyclists = points_along(layout.paths.buffer(0.9).boundary, 500.0, rng)
    x, y = layout.half_m
    belt = shapely.box(-x + 2.4, -y + 2.4, x - 2.4, y - 2.4).exterior
    drives = shapely.union_all([shapely.Polygon(d).buffer(2.5) for d in layout.drives])
    rows = shapely.difference(belt, drives)
    border = shapely.difference(shapely.box(-x + 0.9, -y + 0.9, x - 0.9, y - 0.9).exterior, drives)
    # Rows of trees between neighbours, where no path runs.
    outlines = [
        plot.area.buffer(0.5 * GAP_M, join_style="mitre").exterior
        for plot in layout.plots
        if plot.kind != "grove" and rng.random() < 0.8
    ]
    planted = [points_along(line, float(rng.uniform(8, 15)), rng) for line in outlines]
    planted.append(points_along(rows, float(rng.uniform(6.5, 11.0)), rng))
    hedges = [
        (shapely.get_coordinates(part), float(rng.uniform(1.0, 2.2)), 0.9)
        for part in shapely.get_parts(shapely.line_merge(border))
        if part.length > 3
    ]

    def facing(points):
        return np.column_stack([points, rng.uniform(0, 6.28, len(points))])

    return {
        "lamps": facing(lamps),
        "furniture": [
            ("bench", facing(benches)),
            ("litter_bin", facing(bins)),
            ("bicycle_rack", facing(cyclists)),
        ],
        "people": [("walking", "", facing(walkers))],
        "trees": _apart(np.concatenate(planted), 4.5),
        "bushes": np.concatenate([points_along(line, 14.0, rng) for line in [rows, *outlines]]),
        "tufts": np.concatenate([points_along(edges, 0.7, rng), points_along(border, 0.5, rng)]),
        "hedges": hedges,
    }


def _cleared(site: Piece, layout: Layout) -> Piece:
    """The site without the trees, lamps and benches that would stand in something's way."""
    drives = [shapely.Polygon(d) for d in layout.drives]
    solid = shapely.union_all([*site.keep_clear, *drives])
    shapely.prepare(solid)
    ways = shapely.union_all([layout.paths, solid])
    grown, wide = ways.buffer(0.7), shapely.union_all([layout.paths.buffer(1.0), solid.buffer(1.0)])
    parking = shapely.union_all([p.area for p in layout.plots if p.kind == "parking"])
    for area in (grown, wide, parking):
        shapely.prepare(area)

    def off(area, points):
        return ~shapely.contains_xy(area, points[:, 0], points[:, 1])

    trees = site.trees
    in_islands = ~off(parking, trees)
    site.trees = trees[off(wide, trees) | in_islands]
    site.bushes = site.bushes[off(grown, site.bushes)]
    site.tufts = site.tufts[off(layout.paths, site.tufts)]
    lamps = site.lamps
    site.lamps = lamps[off(solid, lamps) | ~off(parking, lamps)]
    return site


def _apart(points: np.ndarray, gap_m: float) -> np.ndarray:
    """The points (k, 2) without those that come too near to an earlier one."""
    pairs = cKDTree(points).query_pairs(gap_m, output_type="ndarray")
    keep = np.ones(len(points), bool)
    keep[pairs.max(axis=1)] = False
    return points[keep]


def site_models(
    rng: np.random.Generator,
    club: SportsGround,
    land: shapely.Geometry,
    site: Piece,
    spectators: list[tuple[str, np.ndarray]],
    bounds: np.ndarray,
) -> list[Model]:
    """All of the site but its plants, on z = 0.

    Args:
        rng: of the surfaces' colours, of people, cars and furniture.
        club: the ground.
        land: of the site.
        site, spectators: from `build_site`.
        bounds: (2, 2) of the flights.
    """
    lanes = rng.spawn(3)
    drift = Drift(lanes[0], 0.13)
    lawn = Patch(area=shapely.Polygon(), surface=("grass", "ground"), turn_rad=club.yaw_rad)
    models = [*site.models, ground(site.patches, land, lawn, drift)]
    models += _everybody(lanes[1], club, site, spectators)
    names = sorted({name for name, _ in site.furniture})
    for name in names:
        p = np.concatenate([q for other, q in site.furniture if other == name])
        if not len(p):
            continue
        at = np.column_stack([p[:, :2], np.zeros(len(p))])
        if name in FURNITURE:
            models.append(scatter_furniture(lanes[2], name, at, p[:, 2]))
        else:
            models.append(scatter(lanes[2], name, at, p[:, 2]))
    cars = np.column_stack([site.cars[:, :2], np.zeros(len(site.cars)), site.cars[:, 2]])
    models.append(
        park(lanes[2], cars[:, :3], cars[:, 3], distance_to(bounds, cars) + _CAR_DETAIL_M)
    )
    lamps = np.column_stack([site.lamps[:, :2], np.zeros(len(site.lamps))])
    if len(lamps):
        models.append(street_lamps(lanes[2], lamps, site.lamps[:, 2], "straight"))
    return models


def _everybody(
    rng: np.random.Generator,
    club: SportsGround,
    site: Piece,
    spectators: list[tuple[str, np.ndarray]],
) -> list[Model]:
    """Players, officials, spectators and passers-by, each pose built once."""
    kits = {name: np.array(tint) for name, tint in _KITS.items()}
    kits["home"], kits["away"] = club.arena.colours
    groups: dict[tuple[str, bool], list[tuple[np.ndarray, np.ndarray]]] = {}
    for pose, kit, p in site.people:
        places = np.column_stack([p[:, :2], np.zeros(len(p)), p[:, 2]])
        shirts = np.tile(kits.get(kit, np.zeros(3)), (len(p), 1))
        groups.setdefault((pose, kit in kits), []).append((places, shirts))
    for pose, p in spectators:
        groups.setdefault((pose, False), []).append((p, np.zeros((len(p), 3))))
    models = []
    for (pose, players), members in groups.items():
        p, shirts = (np.concatenate(part) for part in zip(*members, strict=True))
        if len(p):
            kit = shirts if players else None
            models.append(people(rng, p[:, :3], p[:, 3], pose=pose, kit=kit))
    return models
