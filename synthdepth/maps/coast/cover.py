"""What grows on the coast: woods, lone trees, scrub, dune grass, flowers; and the drift line."""

import numpy as np
import shapely

from synthdepth.maps.coast.land import wooded
from synthdepth.maps.coast.shore import smooth
from synthdepth.maps.coast.terrain import HALF_M, Ground
from synthdepth.maps.geometry import Geometry, Model, geometry, join
from synthdepth.maps.placement import distance_to
from synthdepth.maps.vegetation.foliage import clumps, dark_cores, directions, unit
from synthdepth.maps.vegetation.shrubs import bushes, flowers, grass_tufts
from synthdepth.maps.vegetation.trees import plant

TUFT = ("leaf", "ground")
_STRAW = np.array([0.27, 0.22, 0.125])
# Leaves of heath, gorse, bracken and bramble; linear reflectances.
_HEATH = np.array(
    [[0.075, 0.085, 0.035], [0.055, 0.07, 0.032], [0.15, 0.105, 0.05], [0.085, 0.06, 0.062]]
)
# Trees of a coast: (in woods, along the road and alone, by the beach), each name: weight.
FLORAS = {
    "mediterranean": (
        {"pine": 5, "oak": 2, "cypress": 1},
        {"pine": 3, "cypress": 2, "fruit": 2, "palm": 1},
        {"pine": 2, "palm": 1},
    ),
    "tropical": ({"oak": 4, "palm": 2, "willow": 2}, {"palm": 2, "fruit": 3}, {"palm": 1}),
    "temperate": (
        {"oak": 3, "birch": 2, "pine": 2, "maple": 2},
        {"oak": 1, "birch": 1, "bare": 1, "pine": 2, "fruit": 1},
        {"pine": 2, "bare": 1},
    ),
    "northern": (
        {"spruce": 4, "pine": 3, "birch": 3},
        {"birch": 2, "pine": 2, "bare": 1},
        {"pine": 1, "birch": 1},
    ),
}


def _scattered(
    rng: np.random.Generator, count: int, half_m: float, taken: shapely.Geometry
) -> np.ndarray:
    """Places (n, 2) [m] anywhere on the map but where something stands."""
    xy = rng.uniform(-half_m, half_m, (count, 2))
    return xy[~shapely.contains_xy(taken, xy[:, 0], xy[:, 1])]


def _apart(xy: np.ndarray, gap_m: float) -> np.ndarray:
    """One place of each square cell of a grid."""
    cell = np.floor(xy / gap_m).astype(np.int64)
    _, first = np.unique(cell[:, 0] * 100_003 + cell[:, 1], return_index=True)
    return xy[np.sort(first)]


def _species(rng: np.random.Generator, mix: dict[str, float], count: int) -> np.ndarray:
    weight = np.array(list(mix.values()), float)
    return rng.choice(list(mix), count, p=weight / weight.sum())


def trees(
    rng: np.random.Generator,
    ground: Ground,
    flora: str,
    bounds: np.ndarray,
    taken: shapely.Geometry,
    density: float,
    gardens: np.ndarray,
) -> Model:
    """Woods, lone trees and those of the gardens (n, 2); `density` is 1 for an ordinary coast."""
    shore = ground.shore
    in_woods, alone, by_beach = FLORAS[flora]
    near = _apart(_scattered(rng, 16_000, HALF_M, taken), 4.2)
    far = _scattered(rng, 15_000, 1300.0, taken)
    far = far[distance_to(bounds, far) > 90]
    picked, species = [gardens], [_species(rng, alone, len(gardens))]
    for xy, woods_share, lone_share in ((near, 0.42, 0.022), (far, 0.5, 0.02)):
        s, t = shore.to_local(xy)
        behind = ground.behind_m(xy)
        clear = (behind > 5) & (np.abs(ground.from_road_m(xy)) > 8)
        forest = wooded(shore, s, t, behind)
        beach = (behind > -7) & (behind < 20) & (shore.look_up("rockiness", s) < 0.4)
        lot = rng.random(len(xy))
        chance = np.where(forest > 0.4, woods_share * forest, lone_share) * density
        rows = {
            0: clear & (forest > 0.4) & (lot < chance),
            1: clear & (forest <= 0.4) & (lot < chance),
            2: beach & (lot < 0.05 * density),
        }
        for k, mix in enumerate((in_woods, alone, by_beach)):
            chosen = xy[rows[k]]
            picked.append(chosen)
            species.append(_species(rng, mix, len(chosen)))
    xy, species = np.concatenate(picked), np.concatenate(species)
    away = distance_to(bounds, xy)
    # No more than the triangles allow: the nearest keep their places.
    inside = np.flatnonzero(away <= 0.5)
    drop = inside[rng.permutation(len(inside))[int(310 * np.clip(density, 0.3, 1.25)) :]]
    keep = np.ones(len(xy), bool)
    keep[drop] = False
    xy, species, away = xy[keep], species[keep], away[keep]
    at = np.column_stack([xy, ground.height_m(xy) - 0.05])
    return plant(rng, at, species, away, templates=5)


def scrub(
    rng: np.random.Generator,
    ground: Ground,
    bounds: np.ndarray,
    taken: shapely.Geometry,
    gardens: np.ndarray,
) -> Model:
    """Bushes on the dunes' backs, along cliffs and the woods' edges, and in gardens (n, 3)."""
    shore = ground.shore
    xy = _scattered(rng, 16_000, HALF_M, taken)
    s, t = shore.to_local(xy)
    behind = ground.behind_m(xy)
    forest = wooded(shore, s, t, behind)
    thicket = shore.ridges.at(1.3 * s, 1.3 * t) + 0.5 * shore.fine.at(s, t)
    chance = 0.5 * smooth(thicket, 0.5, 1.4) * smooth(behind, 2, 9) + 0.25 * (forest > 0.2) * (
        forest < 0.8
    )
    chance *= 1 - 0.65 * smooth(behind, 60, 140)
    clear = (np.abs(ground.from_road_m(xy)) > 6.5) & (behind > 1.5)
    xy = xy[clear & (rng.random(len(xy)) < chance)]
    xy = xy[np.argsort(distance_to(bounds, xy), kind="stable")][:1500]
    inside = np.flatnonzero(distance_to(bounds, xy) <= 8)
    xy = np.delete(xy, inside[rng.permutation(len(inside))[620:]], axis=0)
    size = rng.gamma(4.0, 0.35, len(xy)) + 0.4
    xy = np.concatenate([xy, gardens[:, :2]])
    size = np.concatenate([size, gardens[:, 2]])
    at = np.column_stack([xy, ground.height_m(xy) - 0.04])
    return bushes(rng, at, size, distance_to(bounds, xy))


def _cushions(rng: np.random.Generator, position: np.ndarray, size_m: np.ndarray) -> Model:
    """Low heath and bracken: a dark core under sixteen leaf clumps each.

    Args:
        rng: of the plants.
        position: (k, 3) on the ground [m].
        size_m: (k,) width.
    """
    k, count = len(position), 16
    colour = _HEATH[rng.choice(len(_HEATH), k, p=[0.4, 0.25, 0.2, 0.15])]
    colour = colour * rng.normal(1.0, 0.12, (k, 1)).clip(0.6, 1.5)
    core = dark_cores(
        position,
        size_m[:, None] * [0.42, 0.42, 0.3] * rng.uniform(0.8, 1.2, (k, 3)),
        0.45 * colour,
        rng,
    )
    owner = np.repeat(np.arange(k), count)
    out = directions(rng, k * count)
    out[:, 2] = np.abs(out[:, 2])
    centre = position[owner] + size_m[owner, None] * out * [0.46, 0.46, 0.36]
    along = unit(0.6 * out + directions(rng, k * count) + [0, 0, 0.5])
    length = 0.34 * size_m[owner] * rng.uniform(0.7, 1.3, k * count)
    shade = (0.65 + 0.5 * out[:, 2:]) * rng.uniform(0.75, 1.25, (k * count, 1))
    leaves = clumps(centre, along, out, length, 0.75 * length, colour[owner] * shade)
    return {("leaf", "vegetation"): join([core, leaves])}


def _blades(
    rng: np.random.Generator, position: np.ndarray, height: np.ndarray, count: int, tint: np.ndarray
) -> Geometry:
    """Clumps of `count` long blades, bent over by the wind: two triangles each."""
    k = len(position)
    owner = np.repeat(np.arange(k), count)
    b = len(owner)
    high = height[owner] * rng.uniform(0.55, 1.1, b)
    turn = rng.uniform(0, 2 * np.pi, b)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(b)])
    side = np.column_stack([-out[:, 1], out[:, 0], np.zeros(b)])
    foot = position[owner] + (0.22 * high * rng.random(b))[:, None] * out - [0, 0, 0.03]
    wind = np.array([0.25, 0.1, 0.0])
    reach = (high * rng.uniform(0.2, 0.65, b))[:, None] * out + high[:, None] * wind
    middle = foot + 0.45 * reach + (0.62 * high)[:, None] * [0, 0, 1.0]
    tip = foot + 1.1 * reach + (high * rng.uniform(0.75, 1.0, b))[:, None] * [0, 0, 1.0]
    wide = (0.006 + 0.022 * high)[:, None] * side
    corners = np.stack([foot - wide, foot + wide, middle + 0.8 * wide, middle - 0.8 * wide, tip], 1)
    faces = np.array([[0, 1, 2], [0, 2, 3], [3, 2, 4]]) + 5 * np.arange(b)[:, None, None]
    shade = np.array([0.6, 0.6, 1.0, 1.0, 1.2])[None, :, None]
    colour = tint[owner] * rng.uniform(0.75, 1.2, (b, 1))
    uv = np.stack(
        [np.tile([0, 0.04, 0.04, 0, 0.02], (b, 1)), high[:, None] * [0, 0, 0.6, 0.6, 1]], -1
    )
    return geometry(corners, faces, uv, (shade * colour[:, None]).reshape(-1, 3))


def marram(rng: np.random.Generator, position: np.ndarray, height_m: np.ndarray) -> Model:
    """Clumps of dune grass at `position` (k, 3) [m], `height_m` (k,)."""
    k = len(position)
    green = np.array([0.105, 0.125, 0.062]) * rng.normal(1, 0.12, (k, 1)).clip(0.6, 1.4)
    dry = rng.beta(1.3, 2.2, (k, 1))
    return {TUFT: _blades(rng, position, height_m, 11, (1 - dry) * green + dry * _STRAW)}


def tussocks(rng: np.random.Generator, position: np.ndarray, height_m: np.ndarray) -> Model:
    """Clumps of meadow grass gone to seed: eight blades, a triangle each."""
    k, count = len(position), 8
    owner = np.repeat(np.arange(k), count)
    b = len(owner)
    high = height_m[owner] * rng.uniform(0.45, 1.15, b)
    turn = rng.uniform(0, 2 * np.pi, b)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(b)])
    side = np.column_stack([-out[:, 1], out[:, 0], np.zeros(b)])
    foot = position[owner] + (0.4 * high * rng.random(b))[:, None] * out - [0, 0, 0.03]
    reach = (high * rng.uniform(0.15, 0.8, b))[:, None] * out + high[:, None] * [0.15, 0.08, 0]
    tip = foot + reach + high[:, None] * [0, 0, 1.0]
    wide = (0.012 + 0.034 * high)[:, None] * side
    green = np.array([0.085, 0.098, 0.045]) * rng.normal(1, 0.14, (k, 1)).clip(0.6, 1.5)
    dry = rng.beta(1.2, 2.0, (k, 1))
    tint = ((1 - dry) * green + dry * _STRAW)[owner] * rng.uniform(0.7, 1.2, (b, 1))
    shade = np.array([0.6, 0.6, 1.15])[None, :, None] * tint[:, None]
    uv = np.stack([np.tile([0, 0.05, 0.025], (b, 1)), high[:, None] * [0, 0, 1.0]], -1)
    corners = np.stack([foot - wide, foot + wide, tip], 1)
    return {TUFT: geometry(corners, np.arange(3 * b), uv, shade.reshape(-1, 3))}


def grasses(
    rng: np.random.Generator,
    ground: Ground,
    bounds: np.ndarray,
    taken: shapely.Geometry,
    gardens: np.ndarray,
) -> list[Model]:
    """Dune grass, tufts on turf and meadow, flowers, and the tufts of gardens (n, 2)."""
    shore = ground.shore
    xy = _scattered(rng, 210_000, 0.5 * np.ptp(bounds[:, 0]) + 12, taken)
    xy = xy[np.abs(ground.from_road_m(xy)) > 4.6]
    s, t = shore.to_local(xy)
    behind = ground.behind_m(xy)
    back = ground.away_m(xy) - shore.look_up("beach_m", s)
    rocky = shore.look_up("rockiness", s)
    fine, broad = shore.fine.at(s, t), shore.broad.at(s, t)
    lot = rng.random(len(xy))
    dune = (back > -2.0) & (behind < 80) & (rocky < 0.6)
    # Denser where the ground is not bare; a few pioneers on the beach.
    leafy = smooth(0.03 * np.minimum(back, 60) - fine - 0.4 * broad, -1.4, 0.6)
    on_dune = dune & (lot < 0.62 * leafy + 0.015)
    # Where no foot treads, along the brow of cliffs, grass stands tall.
    on_dune |= (np.abs(behind - 1.2) < 2.2) & (rocky >= 0.3) & (lot < 0.75)
    steep = (back > -1) & (behind < 1.5) & (rocky >= 0.3)
    meadow = (behind > 1.5) & ~on_dune & ~steep
    patchy = smooth(fine + 0.6 * shore.ridges.at(2 * s, 2 * t), -0.7, 1.3)
    on_turf = meadow & (lot < 0.2 + 0.75 * patchy)
    bloom = meadow & (behind < 120) & (lot > 0.93) & (fine > 0.1)

    def feet(places):
        return np.column_stack([places, ground.height_m(places)])

    high = feet(xy[on_dune][:11_000])
    low = feet(xy[on_turf][:60_000])
    tall = (rng.gamma(5.0, 0.042, len(low)) + 0.08) * (
        0.75 + 0.8 * smooth(broad, -0.2, 1.6)[on_turf][:60_000]
    )
    spots = feet(xy[bloom][:1400])
    heath = meadow & (lot > 0.9) & (shore.woods.at(1.7 * s, 1.7 * t) + 0.4 * fine > 0.25)
    low_plants = feet(xy[heath][:4200])
    return [
        _cushions(rng, low_plants, rng.gamma(5.0, 0.13, len(low_plants)) + 0.15),
        marram(rng, high, rng.uniform(0.35, 0.95, len(high))),
        tussocks(rng, low, tall),
        grass_tufts(rng, feet(gardens), rng.uniform(0.1, 0.3, len(gardens))),
        flowers(rng, spots, rng.uniform(0.15, 0.45, len(spots))),
    ]


def drift_line(rng: np.random.Generator, ground: Ground, bounds: np.ndarray) -> Model:
    """Seaweed left by the last tides, in ragged lines above the reach of the waves."""
    shore = ground.shore
    n = 9000
    s = rng.uniform(-HALF_M, HALF_M, n)
    swash = shore.look_up("swash_m", s)
    tide = rng.choice([1.6, 1.6, 5.0], n)
    d = 0.8 * swash + tide + 0.7 * shore.fine.at(0.7 * s, 9.0 * tide) + rng.normal(0, 0.3, n)
    patch = shore.fine.at(1.5 * s, 40.0 * tide) + 0.5 * rng.normal(size=n)
    keep = (patch > 0.1) & (d < shore.look_up("beach_m", s) - 1)
    xy = shore.to_world(s, shore.look_up("line_m", s) + d * shore.look_up("stretch", s))
    xy = xy[keep & (distance_to(bounds, xy) < 20)]
    k = len(xy)
    at = np.column_stack([xy, ground.height_m(xy) + rng.uniform(0.01, 0.05, k)])
    flat = directions(rng, k) * [1, 1, 0.12]
    brown = np.array([[0.045, 0.034, 0.02], [0.06, 0.05, 0.022], [0.03, 0.035, 0.015]])
    size = rng.gamma(2.5, 0.08, k) + 0.06
    up = unit(0.35 * directions(rng, k) + [0, 0, 1])
    weed = clumps(at, flat, up, size, 0.5 * size, brown[rng.integers(3, size=k)], fold=0.1)
    return {TUFT: weed}
