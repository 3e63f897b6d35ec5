"""The face of the land: sand, rock, heath, grass, gravel and road, by what the ground is like."""

import dataclasses

import numpy as np

from synthdepth.maps.coast.shore import Field, Shore, smooth
from synthdepth.maps.coast.terrain import (
    REACH_M,
    Ground,
    Pad,
    cut_quads,
    levelled,
    perimeter,
    rings,
)
from synthdepth.maps.geometry import Geometry, Model, cross, geometry, join, merge
from synthdepth.maps.materials.coast import COAST_MEAN

DROWNED_M = -2.4  # below this the water hides the bed
_KEYS = {
    "sand": ("sand", "ground"),
    "wet_sand": ("wet_sand", "ground"),
    "pebbles": ("pebbles", "ground"),
    "rock": ("rock", "ground"),
    "heath": ("heath", "ground"),
    "grass": ("grass", "ground"),
    "gravel": ("gravel", "ground"),
    "asphalt": ("asphalt", "road"),
    "hill": ("hill", "hill"),
}
_CODE = {name: np.int8(number) for number, name in enumerate(_KEYS)}
_DROWNED = np.int8(-1)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Stone:
    """What a coast is made of; linear reflectances.

    Attributes:
        sand, rock: (3,).
        shingle: share of the beach under pebbles.
        bands: contrast of the rock's beds.
    """

    sand: tuple[float, float, float]
    rock: tuple[float, float, float]
    shingle: float
    bands: float


# Sand and rock of one shore belong together: (sand, rock, contrast of beds).
STONES = {
    "chalk": ((0.40, 0.36, 0.29), (0.50, 0.48, 0.43), 0.10),
    "limestone": ((0.41, 0.37, 0.30), (0.33, 0.30, 0.25), 0.18),
    "sandstone": ((0.37, 0.29, 0.19), (0.29, 0.20, 0.13), 0.30),
    "granite": ((0.38, 0.34, 0.27), (0.20, 0.185, 0.17), 0.10),
    "slate": ((0.28, 0.25, 0.20), (0.12, 0.12, 0.12), 0.16),
    "basalt": ((0.13, 0.12, 0.11), (0.085, 0.08, 0.078), 0.12),
    "clay": ((0.33, 0.27, 0.19), (0.24, 0.17, 0.11), 0.24),
}


def draw_stone(rng: np.random.Generator) -> Stone:
    """The stone of a coast; black sand is rare."""
    names = list(STONES)
    weight = np.array([0.2 if name == "basalt" else 1.0 for name in names])
    sand, rock, bands = STONES[names[rng.choice(len(names), p=weight / weight.sum())]]
    light = rng.uniform(0.88, 1.1, 2)
    return Stone(
        sand=tuple(light[0] * np.array(sand)),
        rock=tuple(light[1] * np.array(rock)),
        shingle=float(rng.choice([0.0, 0.0, 0.0, 0.25, 0.5, 1.0])),
        bands=bands,
    )


def wooded(shore: Shore, s, t, behind) -> np.ndarray:
    """0 open land to 1 woods, at local places `behind` the brow [m]."""
    lean = shore.woods.at(s, t) + 0.0035 * np.minimum(behind, 400.0)
    return smooth(lean, 0.55, 1.1) * smooth(behind, 18.0, 45.0)


def rock_tint(stone: Stone, field: Field, s, z) -> np.ndarray:
    """(..., 3) tint of rock at heights z [m]: beds, stains, and dark weed at the water."""
    warp = 2.2 * field.at(s, 3.1 * z)
    bed = np.sin(1.3 * z + 0.6 * warp) + 0.7 * np.sin(3.7 * z + 1.7 + warp)
    light = 1 + stone.bands * 0.5 * bed + 0.1 * warp / 2.2
    light = light * (0.42 + 0.58 * smooth(z, 0.3, 1.5))
    hue = 1 + 0.3 * stone.bands * np.stack([bed, 0 * bed, -bed], -1)
    return np.asarray(stone.rock) / COAST_MEAN * hue * np.maximum(light, 0.25)[..., None]


def _field_tone(s, t) -> np.ndarray:
    """-1 to 1, one value a pasture."""
    cell = np.floor(np.stack([(s + 0.2 * t) / 95.0, (t - 0.1 * s) / 70.0])).astype(np.int64)
    return ((cell[0] * 73856093) ^ (cell[1] * 19349663)) % 9 / 4.0 - 1.0


def _displaced(ground: Ground) -> tuple[np.ndarray, np.ndarray]:
    """s and t of the mesh with the cliff's buttresses, gullies and ledges pushed out."""
    shore = ground.shore
    first, last = ground.starts[3], ground.starts[4]
    s = np.broadcast_to(ground.s, ground.t.shape).copy()
    t = ground.t.copy()
    rows = slice(first, last + 1)
    z = ground.z[rows]
    cliff = shore.look_up("cliff_m", ground.s)
    share = np.linspace(0, 1, last - first + 1)[:, None]
    envelope = np.minimum(1.0, 3.2 * np.minimum(share, 1 - share)) * smooth(cliff, 2.0, 9.0)
    along = s[rows]
    size = np.minimum(0.5 + 0.07 * cliff, 2.2)
    buttress = shore.ridges.at(1.6 * along, 0.25 * z)
    ledge = shore.fine.at(1.1 * along, 5.0 * z)
    block = shore.fine.at(2.9 * along + 70, 3.2 * z)
    out = (
        envelope
        * size
        * (0.75 * (np.abs(buttress) - 0.6) + 0.55 * np.clip(ledge, -1, 1.2) + 0.38 * block)
    )
    out[:, [0, -1]] = 0.0
    line = shore.look_up("line_m", ground.s + 1.0) - shore.look_up("line_m", ground.s - 1.0)
    q = shore.look_up("stretch", ground.s)
    s[rows] += out * line / 2 / q
    t[rows] -= out / q
    return s, t


def _part(vertices: np.ndarray, faces: np.ndarray, uv: np.ndarray, tint: np.ndarray) -> Geometry:
    used, corner = np.unique(faces, return_inverse=True)
    return geometry(vertices[used], corner.reshape(-1, 3), uv[used], tint[used])


def _tints(ground: Ground, stone: Stone, s, t, z) -> dict[str, np.ndarray]:
    """(n, 3) tints by material at vertices (n,)."""
    shore = ground.shore
    d = shore.away_m(s, t)
    behind = d - shore.look_up("beach_m", s) - shore.look_up("run_m", s)
    broad, fine = shore.broad.at(s, t, 1), shore.fine.at(s, t, 1)
    drift = (1 + 0.05 * fine + 0.04 * broad)[:, None]
    damp = 0.45 + 0.55 * smooth(d - shore.look_up("swash_m", s) + 0.5 * fine, -0.5, 5.5)
    sand = np.asarray(stone.sand) / COAST_MEAN * drift
    dry = smooth(broad + 0.4 * fine, -1.2, 1.6)[:, None]
    meadow = (1 - dry) * np.array([0.9, 1.0, 0.92]) + dry * np.array([1.35, 1.22, 1.15])
    sandy = (1 - smooth(behind, -6.0, 60.0))[:, None] * (1 - shore.look_up("rockiness", s))[:, None]
    turf = (1 - 0.55 * sandy) * meadow * 0.95 + 0.55 * sandy * np.array([1.6, 1.42, 1.45])
    # Under trees lie needles and last year's leaves.
    litter = smooth(fine + 0.4 * broad, -1.0, 0.6) * wooded(shore, s, t, behind)
    turf = turf + (np.array([1.05, 0.78, 0.72]) - turf) * 0.8 * litter[:, None]
    field = _field_tone(s, t)[:, None]
    turf = turf * (1 + 0.3 * field * smooth(behind, 60, 140)[:, None] * [1.0, 0.65, 0.5])
    white = np.ones((len(s), 3))
    return {
        "sand": sand * damp[:, None],
        "wet_sand": 0.42 * sand,
        "pebbles": np.array([0.24, 0.225, 0.205]) / COAST_MEAN * drift * damp[:, None],
        "rock": rock_tint(stone, shore.fine, s, z),
        "heath": turf * drift,
        "grass": meadow * drift * np.array([1.12, 0.98, 1.1]),
        "gravel": white * drift,
        "asphalt": white,
        "hill": white * drift,
    }


def _cover(ground: Ground, stone: Stone, s, t, z, steep) -> np.ndarray:
    """Numbers of the materials (n,) at places (n,) where the ground's slope is `steep`."""
    shore = ground.shore
    d = shore.away_m(s, t)
    back = d - shore.look_up("beach_m", s)
    run = shore.look_up("run_m", s)
    behind = back - run
    fine, broad = shore.fine.at(s, t), shore.broad.at(s, t)
    rocky = shore.look_up("rockiness", s)
    # Tussocks fray edges a little.
    fine = fine + 0.22 * shore.fine.at(7.0 * s + 11, 7.0 * t + 5, 1)
    cover = np.full(s.shape, _CODE["heath"])
    mown = (behind > 90.0) & (_field_tone(s, t) < -0.6) & (wooded(shore, s, t, behind) < 0.1)
    cover[mown] = _CODE["grass"]
    # Dunes: bare where the wind gets at them.
    dune = (back > -4) & (behind < 50) & (rocky < 0.6)
    bare = (fine + 0.5 * broad - 0.045 * np.maximum(back, 0) + 1.5 * (back < 5 + 3 * fine)) > 0.55
    cover[dune & bare] = _CODE["sand"]
    cover[back < 1.0 + 1.6 * fine] = _CODE["sand"]
    stony = fine + 1.3 * broad > 2.6 - 3.6 * stone.shingle
    stony |= (rocky > 0.5) & (back > -2.5 + 1.5 * fine)
    cover[(cover == _CODE["sand"]) & stony & (d > -40)] = _CODE["pebbles"]
    cover[(d < shore.look_up("swash_m", s) + 0.9 + 0.5 * fine) & (cover == _CODE["sand"])] = _CODE[
        "wet_sand"
    ]
    cliff = shore.look_up("cliff_m", s) > 2.5
    face = (back > -0.5) & (behind < 2.0)
    cover[cliff & face & (back < 0.45 * run)] = _CODE["pebbles"]  # scree
    cover[cliff & face & (steep > 0.62 + 0.1 * broad)] = _CODE["rock"]
    cover[(steep > 0.9) & (back > 0) & (behind < 4) & (rocky > 0.5)] = _CODE["rock"]
    cover[(d < 4) & (rocky > 0.75) & (fine > 0.2)] = _CODE["rock"]
    return cover


def land(ground: Ground, stone: Stone, gravel: tuple[Pad, ...] = ()) -> Model:
    """All ground from the sea bed to the hills; `gravel` are pads that cars use."""
    return merge([_near(ground, stone, gravel), _outer(ground, stone)])


def _near(ground: Ground, stone: Stone, gravel: tuple[Pad, ...]) -> Model:
    shore = ground.shore
    columns = len(ground.s)
    s, t = _displaced(ground)
    vertices = np.column_stack([shore.to_world(s, t).reshape(-1, 2), ground.z.ravel()])
    cover = _cover(ground, stone, s, t, ground.z, _steepness(ground))
    for pad in gravel:
        cover[pad.outside_m(s, t) < 0.3] = _CODE["gravel"]
    cover[ground.z < DROWNED_M] = _DROWNED
    faces = cut_quads(s, t)
    # A face is what two of its corners are.
    first, second, third = np.moveaxis(cover.ravel()[faces], -1, 0)
    cover = np.where(second == third, second, first)
    edge = ground.starts[5:7]
    cover[edge[0] - 1] = cover[edge[1]] = _CODE["gravel"]
    cover[edge[0] : edge[1]] = _CODE["asphalt"]

    tints = _tints(ground, stone, s.ravel(), t.ravel(), ground.z.ravel())
    flat = np.stack([s, t], -1)
    # On rock v runs up the face, from the cliff's foot.
    step = np.sqrt(
        np.diff(s, axis=0) ** 2 + np.diff(t, axis=0) ** 2 + np.diff(ground.z, axis=0) ** 2
    )
    climb = np.concatenate([np.zeros((1, columns)), np.cumsum(step, axis=0)])
    climb -= climb[ground.starts[3]]
    girth = np.cumsum(shore.look_up("stretch", ground.s)) * (ground.s[1] - ground.s[0])
    up = np.stack([np.broadcast_to(girth, s.shape), climb], -1)
    along = np.stack([s, t - np.interp(ground.s, ground.s, _middle_of_road(ground))], -1)
    uv = {"rock": up, "asphalt": along}
    model = {}
    for name, key in _KEYS.items():
        chosen = faces[cover == _CODE[name]]
        if len(chosen):
            model[key] = _part(vertices, chosen, uv.get(name, flat).reshape(-1, 2), tints[name])
    return model


def _steepness(ground: Ground) -> np.ndarray:
    """(rows, columns) slope of the ground as laid out; its rows run askew to its columns."""
    ds = ground.s[1] - ground.s[0]
    up = np.gradient(ground.z, axis=0) / np.maximum(np.gradient(ground.t, axis=0), 0.02)
    along = (np.gradient(ground.z, axis=1) - up * np.gradient(ground.t, axis=1)) / ds
    return np.hypot(up, along)


def _middle_of_road(ground: Ground) -> np.ndarray:
    return (ground.lines[5] + ground.lines[6]) / 2


def _outer(ground: Ground, stone: Stone) -> Model:
    """Rings from the near mesh's edge to the horizon."""
    shore = ground.shore
    s = np.broadcast_to(ground.s, ground.t.shape)
    edge = perimeter(s, ground.t)
    largest = np.abs(edge).max()
    reach = np.geomspace(1.0, (REACH_M - 50.0) / largest, 110)
    places, faces = rings(edge, reach)
    at_s, at_t = places[..., 0].ravel(), places[..., 1].ravel()
    z = levelled(shore, ground.road_t_m, ground.road_z_m, at_s, at_t)
    z[: len(edge)] = perimeter(ground.z, ground.z)[:, 0]
    vertices = np.column_stack([shore.to_world(at_s, at_t), z])
    faces = faces[z[faces].max(axis=1) > DROWNED_M]
    corner = vertices[faces].astype(np.float64)
    normal = cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    steep = np.hypot(normal[:, 0], normal[:, 1]) / np.maximum(normal[:, 2], 1e-9)
    middle_s, middle_t = at_s[faces].mean(axis=1), at_t[faces].mean(axis=1)
    cover = _cover(ground, stone, middle_s, middle_t, z[faces].mean(axis=1), steep)
    beach, run = shore.look_up("beach_m", middle_s), shore.look_up("run_m", middle_s)
    behind = shore.away_m(middle_s, middle_t) - beach - run
    far = np.hypot(middle_s, middle_t)
    woods = wooded(shore, middle_s, middle_t, behind) > 0.45
    green = np.isin(cover, [_CODE["heath"], _CODE["grass"]])
    cover[green & ((woods & (far > 420)) | ((far > 1400) & (behind > 160)))] = _CODE["hill"]
    tints = _tints(ground, stone, at_s, at_t, z)
    flat = np.stack([at_s, at_t], -1)
    # On steep rock v follows the height.
    up = np.stack([at_s, z * 1.2], -1)
    # A normal averaged across a crest would turn away from those who see its near side: slopes
    # that face the middle share no vertices with those that face away.
    away = np.einsum("ni,ni->n", corner.mean(axis=1) - [0, 0, 40.0], normal) > 0
    model = {}
    for name, key in _KEYS.items():
        parts = [
            _part(vertices, faces[(cover == _CODE[name]) & (away == side)], uv, tints[name])
            for side in (False, True)
            for uv in (up if name == "rock" else flat,)
        ]
        model[key] = join(parts)
    return {key: part for key, part in model.items() if len(part.faces)}
