"""On the beach and the water: people, their things, boats, piers, groynes; and the lighthouse."""

import dataclasses

import numpy as np
import shapely

from synthdepth.maps.coast.beach import BEACH_RADIUS_M, beach_items
from synthdepth.maps.coast.boats import scatter_boats
from synthdepth.maps.coast.harbour import harbour_clutter, sea_buoys
from synthdepth.maps.coast.lighthouse import lighthouse
from synthdepth.maps.coast.pier import jetty, pier
from synthdepth.maps.coast.sea_works import breakwater, groyne
from synthdepth.maps.coast.shore import Shore
from synthdepth.maps.coast.terrain import HALF_M, Ground, Pad
from synthdepth.maps.geometry import Model, place
from synthdepth.maps.people import people
from synthdepth.maps.placement import on_ground

_DECK_M, _JETTY_M = 3.1, 1.7
# Large things on a beach: how many of each at most.
_STRUCTURES = {
    "lifeguard_tower": 1,
    "volleyball_net": 2,
    "hut_row": 1,
    "net_poles": 2,
    "beach_hut": 5,
    "beach_flag": 3,
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Waterfront:
    """Where things stand, in world x, y [m].

    Attributes:
        light: (2,) the lighthouse.
        pads: levelled ground for it.
        works: (kind, line (2, 2) from the beach out to sea): pier, jetty, breakwater, groynes.
    """

    light: np.ndarray
    pads: tuple[Pad, ...]
    works: list[tuple[str, np.ndarray]]

    @property
    def lines(self) -> shapely.Geometry:
        """All works as lines."""
        return shapely.MultiLineString([line for _, line in self.works])


# Builders of what reaches out into the sea: (rng, line, bed height) -> Model.
_WORKS = {
    "pier": lambda rng, line, bed: pier(rng, line, deck_m=_DECK_M, bed_m=bed),
    "jetty": lambda rng, line, bed: jetty(rng, line, deck_m=_JETTY_M, bed_m=bed),
    "breakwater": breakwater,
    "groyne": groyne,
}


def _light(rng: np.random.Generator, shore: Shore) -> tuple[np.ndarray, Pad]:
    """A place for the lighthouse on the boldest headland about, and its levelled ground."""
    look_up = shore.look_up
    s = np.arange(-520.0, 521.0, 10.0)
    jut = -look_up("line_m", s) + 2.0 * look_up("cliff_m", s) - 0.06 * np.abs(s)
    at = float(s[np.argmax(jut + rng.normal(0, 6, len(s)))])
    behind = look_up("beach_m", at) + look_up("run_m", at) + 17.0
    t = float(look_up("line_m", at) + behind * look_up("stretch", at))
    pad = Pad(
        s_m=at,
        t_m=t,
        heading_rad=0.0,
        half_m=(8.0, 7.0),
        z_m=float(shore.natural_m(np.array([at]), np.array([t]))[0]),
    )
    return shore.to_world(at, t), pad


def plan_waterfront(rng: np.random.Generator, shore: Shore, *, with_pier: bool) -> Waterfront:
    """A lighthouse on a headland, a pier from an easy beach, groynes, a jetty, a breakwater."""
    look_up = shore.look_up
    light, pad = _light(rng, shore)
    s = np.sort(rng.permutation(np.arange(-235.0, 236.0, 22.0))[:14])
    easy = (look_up("cliff_m", s) < 5) & (look_up("beach_m", s) > 9)
    kinds = ["pier"] * with_pier + ["jetty"] * (rng.random() < 0.5)
    kinds += ["breakwater"] * (rng.random() < 0.4) + ["groyne"] * int(rng.choice([0, 2, 4, 6]))
    places = rng.permutation(s[easy])
    works = []
    for kind, at in zip(kinds, places, strict=False):
        line, q, beach = (float(look_up(n, at)) for n in ("line_m", "stretch", "beach_m"))
        inner = {
            "pier": min(0.75 * beach, 26.0),
            "jetty": min(0.4 * beach, 7.0),
            "breakwater": 0.5 * beach,
            "groyne": 0.55 * beach,
        }[kind]
        reach = {"pier": (45, 90), "jetty": (22, 36), "breakwater": (35, 75), "groyne": (16, 34)}
        out = rng.uniform(*reach[kind])
        t = np.array([line + inner * q, line - out])
        works.append((kind, shore.to_world(at + np.array([0.0, rng.normal(0, 0.05) * out]), t)))
    return Waterfront(light=light, pads=(pad,), works=works)


def _along_beach(rng, ground: Ground, count: int, inner: float, outer: float) -> np.ndarray:
    """Places (k, 2) on the sand in groups, between two shares of the beach's width."""
    shore = ground.shore
    groups = rng.uniform(-240, 240, max(count // 5, 1))
    s = groups[rng.integers(len(groups), size=count)] + rng.normal(0, 7, count)
    beach, swash = shore.look_up("beach_m", s), shore.look_up("swash_m", s)
    d = swash + 1.0 + rng.uniform(inner, outer, count) * np.maximum(beach - swash - 2.5, 0)
    sandy = (beach - swash > 6) & (shore.look_up("rockiness", s) < 0.75) & (np.abs(s) < HALF_M)
    t = shore.look_up("line_m", s) + d * shore.look_up("stretch", s)
    return shore.to_world(s, t)[sandy]


def _apart(
    places: np.ndarray, gap_m: float, off: shapely.Geometry, off_m: float | None = None
) -> np.ndarray:
    """Places (k, 2) of which each keeps its distance from those before, and from `off`."""
    off_m = gap_m + 2.0 if off_m is None else off_m
    kept: list[np.ndarray] = []
    clear = shapely.distance(shapely.points(places), off) > off_m
    for xy in places[clear | off.is_empty]:
        if all(np.hypot(*(xy - other)) > gap_m for other in kept):
            kept.append(xy)
    return np.array(kept).reshape(-1, 2)


def _structures(rng, ground: Ground, taken: shapely.Geometry) -> tuple[list, shapely.Geometry]:
    """Huts, towers, nets: (name, place) and what they and `taken` cover."""
    placed = []
    for name, most in _STRUCTURES.items():
        radius = BEACH_RADIUS_M[name]
        for xy in _along_beach(rng, ground, 6 * most, 0.5, 0.9)[: int(rng.integers(most + 1))]:
            s, _ = ground.shore.to_local(xy)
            room = ground.shore.look_up("beach_m", s) - ground.shore.look_up("swash_m", s)
            if 2 * radius < room and shapely.distance(shapely.Point(xy), taken) > radius + 1.5:
                placed.append((name, xy))
                taken = shapely.union(taken, shapely.Point(xy).buffer(radius))
    return placed, taken


def build_waterfront(
    rng: np.random.Generator,
    front: Waterfront,
    ground: Ground,
    *,
    walkers: np.ndarray,
    boat_count: int,
    people_count: int,
    item_count: int,
) -> list[Model]:
    """Everything of the waterfront; `walkers` (k, 2) are people elsewhere, as on the road."""
    lanes = rng.spawn(6)
    shore = ground.shore
    to_sea = shore.yaw_rad - np.pi / 2
    models: list[Model] = []

    structures, taken = _structures(lanes[4], ground, front.lines)
    for name, xy in structures:
        at = on_ground(ground, xy[None])
        yaw = [to_sea + lanes[4].normal(0, 0.08)]
        models.append(beach_items(lanes[4], at, yaw, weights={name: 1.0}, variants=1))
    items = _apart(_along_beach(lanes[0], ground, item_count, 0.1, 1.0), 3.4, taken)
    yaw = to_sea + lanes[0].normal(0, 0.5, len(items))
    models.append(beach_items(lanes[0], on_ground(ground, items), yaw))
    taken = shapely.union(taken, shapely.MultiPoint(items).buffer(1.3))

    ashore = _along_beach(lanes[2], ground, max(boat_count // 2, 3), 0.15, 0.8)
    ashore = _apart(ashore, 4.0, taken)
    yaw = to_sea + np.pi * lanes[2].integers(2, size=len(ashore))
    yaw = yaw + lanes[2].normal(0, 0.35, len(ashore))
    models.append(scatter_boats(lanes[2], on_ground(ground, ashore), yaw, ashore=True))
    beside = ashore[: len(ashore) // 2] + lanes[2].normal(0, 0.6, 2) + [3.4, 0.0]
    clutter = _apart(beside, 1.5, taken)
    turn = lanes[2].uniform(0, 6.28, len(clutter))
    models.append(harbour_clutter(lanes[2], on_ground(ground, clutter), turn))
    taken = shapely.union(taken, shapely.MultiPoint(np.concatenate([ashore, clutter])).buffer(2.5))

    bathers = _along_beach(lanes[1], ground, people_count, -0.1, 0.9)
    folk = np.concatenate([_apart(bathers, 0.9, taken, 0.4), walkers])
    models.append(people(lanes[1], on_ground(ground, folk), lanes[1].uniform(0, 6.28, len(folk))))

    s = lanes[3].uniform(-300, 300, 2 * boat_count)
    d = -14 - lanes[3].gamma(1.5, 32, 2 * boat_count)
    afloat = shore.to_world(s, shore.look_up("line_m", s) + d * shore.look_up("stretch", s))
    floating = _apart(afloat[ground.height_m(afloat) < -0.8], 14.0, front.lines)
    swing = shore.yaw_rad + lanes[3].uniform(0, 6.28) + lanes[3].normal(0, 0.3, len(floating))
    boats, buoys = floating[:boat_count], floating[boat_count:] + 4.0
    models.append(scatter_boats(lanes[3], _at_sea(boats), swing[:boat_count], ashore=False))
    models.append(sea_buoys(lanes[3], _at_sea(buoys)))

    for kind, line in front.works:
        models.append(_WORKS[kind](lanes[4], line, ground.height_m))
    at = on_ground(ground, front.light[None])[0]
    models.append(place(lighthouse(lanes[5]), at, to_sea))
    return models


def _at_sea(xy: np.ndarray) -> np.ndarray:
    return np.column_stack([xy, np.zeros(len(xy))])
