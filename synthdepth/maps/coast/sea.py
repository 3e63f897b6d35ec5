"""The sea as a mesh: fine along the shore, coarser out to the horizon; foam by the waves."""

import numpy as np

from synthdepth.maps.coast.land import Stone
from synthdepth.maps.coast.shore import BED_M, smooth
from synthdepth.maps.coast.terrain import (
    HALF_M,
    KEEP,
    Ground,
    cut_quads,
    on_chords,
    perimeter,
    rings,
)
from synthdepth.maps.coast.waves import Sea, surface
from synthdepth.maps.geometry import Geometry, Model, geometry, merge
from synthdepth.maps.materials.coast import COAST_MEAN

HORIZON_M = 40_000.0
STEP_M = 0.7  # between columns, and between rows off the shore
SURF_STEP_M = 0.45  # between rows in the surf
SURF_M = 45.0
FILM_M = 0.012  # thickness of the last film of water on the sand
_LACE, _FOAM = 0.28, 0.62  # whiteness from which a face is lace, or foam


def sea_surface(sea: Sea, ground: Ground, stone: Stone) -> Model:
    """All water of the map."""
    return merge([_near(sea, ground, stone), _outer(sea, ground, stone)])


def _rows(ground: Ground, s: np.ndarray) -> tuple[np.ndarray, int]:
    """t (rows, columns) of the near mesh, and the row at the film's edge; rows run inland."""
    shore = ground.shore
    line, q = shore.look_up("line_m", s), shore.look_up("stretch", s)
    seaward, landward = ground.t[0, 0], ground.t[-1, 0]
    surf, film = line - SURF_M * q, line + shore.look_up("swash_m", s) * q
    counts = [
        int((surf - seaward).mean() / STEP_M),
        int((film - surf).mean() / SURF_STEP_M),
        KEEP,
    ]
    counts[2] += -sum(counts) % KEEP
    lines = [np.full_like(s, seaward), surf, film, np.full_like(s, landward)]
    t = [lines[0][None]]
    for k, count in enumerate(counts):
        share = (np.arange(count) + 1)[:, None] / count
        t.append(lines[k] + share * (lines[k + 1] - lines[k]))
    return np.concatenate(t), counts[0] + counts[1]


def _water_tint(sea: Sea, ground: Ground, stone: Stone, s, t, white) -> np.ndarray:
    """(..., 3) tint of water: the bed shows through in the shallows, bubbles lighten it."""
    shore = ground.shore
    d = shore.away_m(s, t)
    depth = BED_M * np.tanh(shore.face_slope * np.maximum(-d, 0.0) / BED_M)
    broad = shore.broad.at(s, t, 1)
    clear = np.exp(-depth / 0.7)[..., None]
    shelf = np.exp(-np.maximum(depth - 0.4, 0) / 2.4 * (1 + 0.25 * broad))[..., None]
    body = np.asarray(sea.body) * (1 + 0.12 * broad)[..., None]
    body = body + (np.asarray(sea.shallows) - body) * 0.8 * shelf
    body = body + (0.42 * np.asarray(stone.sand) - body) * clear
    body = body + 0.16 * (white * (white < _LACE + 0.2))[..., None]
    return body / COAST_MEAN


def _split(vertices, faces, uv, tint, white) -> Model:
    """Faces as water, lace or foam by their mean whiteness."""
    mean = white[faces].mean(axis=1)
    kinds = {
        "sea": mean < _LACE,
        "lace": (mean >= _LACE) & (mean < _FOAM),
        "foam": mean >= _FOAM,
    }
    plain = np.ones_like(tint)
    return {
        (name, "water"): _part(vertices, faces[chosen], uv, tint if name == "sea" else plain)
        for name, chosen in kinds.items()
        if chosen.any()
    }


def _part(vertices, faces, uv, tint) -> Geometry:
    used, corner = np.unique(faces, return_inverse=True)
    return geometry(vertices[used], corner.reshape(-1, 3), uv[used], tint[used])


def _near(sea: Sea, ground: Ground, stone: Stone) -> Model:
    shore = ground.shore
    columns = int(2 * HALF_M / STEP_M / KEEP) * KEEP
    line = np.linspace(-HALF_M, HALF_M, columns + 1)
    t, film_row = _rows(ground, line)
    for edge in (t[:, 0], t[:, -1]):
        edge[:] = on_chords(edge)
    s = np.broadcast_to(line, t.shape)
    used = slice(0, film_row + 1)
    s, t = s[used], t[used]
    shift, white = surface(sea, shore, s, t, coarse=False)
    white = np.where(np.abs(s) < HALF_M - 1, white, 0.0)
    # Horizontal shifts would open the seams to the rings and tear the film from the sand.
    still = (s.shape[1] - 1) * [1.0] + [0.0]
    still = np.minimum(still, still[::-1]) * np.minimum(np.arange(len(t)), 1)[:, None]
    d = shore.away_m(s, t)
    still = still * smooth(-d, 4.0, 15.0)
    z = shift[..., 2]
    z = np.maximum(z, _bed(ground, s, t) + FILM_M)
    z[-1] = _bed(ground, s[-1], t[-1]) - 0.02
    for edge in (z[0], z[:, 0], z[:, -1]):
        edge[: len(edge) // KEEP * KEEP + 1] = on_chords(edge)[: len(edge) // KEEP * KEEP + 1]
    at_s, at_t = s + still * shift[..., 0], t + still * shift[..., 1]
    vertices = np.column_stack([shore.to_world(at_s, at_t).reshape(-1, 2), z.ravel()])
    faces = cut_quads(s, t).reshape(-1, 3)
    tint = _water_tint(sea, ground, stone, s, t, white)
    uv = np.stack([at_s, at_t], -1).reshape(-1, 2)
    return _split(vertices, faces, uv, tint.reshape(-1, 3), white.ravel())


def _bed(ground: Ground, s, t) -> np.ndarray:
    xy = ground.shore.to_world(s, t)
    return ground.height_m(xy.reshape(-1, 2)).reshape(np.shape(s))


def _outer(sea: Sea, ground: Ground, stone: Stone) -> Model:
    """Rings around the near mesh; the last one rises a little, or the black below the sky's rim
    would show as a line."""
    shore = ground.shore
    columns = int(2 * HALF_M / STEP_M / KEEP) * KEEP
    line = np.linspace(-HALF_M, HALF_M, columns + 1)
    t, film_row = _rows(ground, line)
    s = np.broadcast_to(line, t.shape)
    edge = perimeter(s, t)
    largest = np.abs(edge).max()
    reach = np.concatenate(
        [
            np.geomspace(1.0, 1100 / largest, 64),
            np.geomspace(1100 / largest, HORIZON_M / largest, 26)[1:],
        ]
    )
    places, faces = rings(edge, reach)
    at_s, at_t = places[..., 0].ravel(), places[..., 1].ravel()
    shift, white = surface(sea, shore, at_s, at_t, coarse=True)
    fade = np.repeat(1 - smooth(reach, 1.6, 1000 / largest), len(edge))
    z = shift[..., 2] * fade
    z[-len(edge) :] = 70.0
    z[: len(edge)] = _inner_edge(sea, ground, s, t, film_row)
    d = shore.away_m(at_s, at_t)
    dry = d > shore.look_up("swash_m", at_s) + 6.0
    faces = faces[~dry[faces].all(axis=1)]
    vertices = np.column_stack([shore.to_world(at_s, at_t), z])
    tint = _water_tint(sea, ground, stone, at_s, at_t, 0 * white)
    # Wind lanes and the shadows of clouds.
    far = shore.far.at(0.6 * at_s, 2.5 * at_t, 1)
    tint = tint * (1 + 0.13 * far * smooth(np.hypot(at_s, at_t), 400, 1500))[:, None]
    line_white = 0.8 * np.exp(-(((d + 6) / 9) ** 2)) * (shore.fine.at(at_s, at_t, 1) > -0.3)
    return _split(vertices, faces, np.stack([at_s, at_t], -1), tint, np.maximum(line_white, 0))


def _inner_edge(sea, ground, s, t, film_row) -> np.ndarray:
    """Heights of the near mesh round its perimeter; landward of the film, of the sea at rest."""
    shift, _ = surface(sea, ground.shore, s[:1], t[:1], coarse=False)
    z = np.zeros(t.shape)
    z[0] = shift[0, :, 2]
    for column in (0, -1):
        side = slice(0, film_row + 1)
        at = (s[side, column], t[side, column])
        shift, _ = surface(sea, ground.shore, *at, coarse=False)
        z[side, column] = np.maximum(shift[..., 2], _bed(ground, *at) + FILM_M)
    return perimeter(z, z)[:, 0]
