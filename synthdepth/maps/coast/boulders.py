"""Rocks: boulders under the cliffs, skerries, stacks in the sea, cobbles."""

import numpy as np
from scipy.spatial import ConvexHull

from synthdepth.maps.coast.land import Stone, rock_tint
from synthdepth.maps.coast.shore import Field, smooth
from synthdepth.maps.coast.terrain import HALF_M, Ground, grid_faces
from synthdepth.maps.geometry import (
    Geometry,
    Model,
    copies,
    cross,
    geometry,
    join,
    merge,
    yaw_matrix,
)
from synthdepth.maps.placement import distance_to

ROCK = ("rock", "ground")


def _boxed(triangles: np.ndarray) -> Geometry:
    """Facets (m, 3, 3) with texture coordinates along the two axes that each faces least."""
    normal = np.abs(cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]))
    axis = normal.argmax(axis=1)
    across = np.where(axis == 0, 1, 0)
    up = np.where(axis == 2, 1, 2)
    each = np.arange(len(triangles))[:, None]
    corner = np.arange(3)[None]
    uv = np.stack(
        [triangles[each, corner, across[:, None]], triangles[each, corner, up[:, None]]], -1
    )
    return geometry(triangles, np.arange(3 * len(triangles)), uv)


def _hull(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and outward faces of the convex hull of points (n, 3)."""
    hull = ConvexHull(points)
    faces = hull.simplices.copy()
    corner = points[faces]
    normal = cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    inward = np.einsum("ij,ij->i", normal, hull.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    return points, faces


def _subdivided(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Every face cut into four at the middles of its edges."""
    edges = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], -1).reshape(-1, 2), axis=1)
    unique, number = np.unique(edges, axis=0, return_inverse=True)
    middle = vertices[unique].mean(axis=1)
    ab, bc, ca = (number.reshape(-1, 3) + len(vertices)).T
    a, b, c = faces.T
    new = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    return np.concatenate([vertices, middle]), np.concatenate([np.stack(f, 1) for f in new])


def _rock(rng: np.random.Generator, points: int, cuts: int) -> Geometry:
    """A rock about one metre wide, its middle at the origin."""
    p = rng.normal(size=(points, 3))
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    p *= rng.uniform(0.4, 0.56, (points, 1)) * [1.0, rng.uniform(0.65, 1.0), rng.uniform(0.5, 0.85)]
    vertices, faces = _hull(p)
    for cut in range(cuts):
        vertices, faces = _subdivided(vertices, faces)
        vertices = vertices + rng.normal(0, 0.022 / 2**cut, vertices.shape)
    return _boxed(vertices[faces])


def boulders(
    rng: np.random.Generator,
    stone: Stone,
    field: Field,
    position: np.ndarray,
    size_m: np.ndarray,
    near_m: np.ndarray,
) -> Model:
    """Rocks lying about, sunk by a quarter.

    Args:
        rng: of the templates and the copies.
        stone: what they are made of.
        field: noise of their stains.
        position: (k, 3) ground below them [m].
        size_m: (k,) width.
        near_m: (k,) distance from the square of flights; near and large ones have more facets.
    """
    k = len(position)
    templates = 7
    which = rng.integers(templates, size=k)
    fine = (near_m < 25) & (size_m > 0.9)
    scale = size_m[:, None] * np.column_stack([np.ones((k, 2)), rng.uniform(0.75, 1.1, k)])
    rotation = yaw_matrix(rng.uniform(0, 2 * np.pi, k))
    tilt = rng.normal(0, 0.12, (k, 2))
    rotation = rotation @ np.stack(
        [
            np.stack([np.ones(k), np.zeros(k), tilt[:, 0]], -1),
            np.stack([np.zeros(k), np.ones(k), tilt[:, 1]], -1),
            np.stack([-tilt[:, 0], -tilt[:, 1], np.ones(k)], -1),
        ],
        -2,
    )
    at = position + np.column_stack([np.zeros((k, 2)), 0.12 * scale[:, 2]])
    light = rng.normal(1.0, 0.11, (k, 1)) * rng.normal(1.0, 0.025, (k, 3))
    parts = []
    for number in range(templates):
        coarse = _rock(rng, 16, 0)
        detailed = _rock(rng, 20, 1)
        for part, chosen in (
            (coarse, (which == number) & ~fine),
            (detailed, (which == number) & fine),
        ):
            if not chosen.any():
                continue
            placed = copies(part, at[chosen], rotation=rotation[chosen], scale=scale[chosen])
            n = len(part.vertices)
            uv = placed.uv * np.repeat(size_m[chosen], n)[:, None].astype(np.float32)
            uv += np.repeat(at[chosen, :2].astype(np.float32) % 9.0, n, axis=0)
            tint = rock_tint(stone, field, placed.vertices[:, 0], placed.vertices[:, 2])
            tint = tint * np.repeat(light[chosen], n, axis=0)
            parts.append(geometry(placed.vertices, placed.faces, uv, tint))
    return {ROCK: join(parts)} if parts else {}


def stack(
    rng: np.random.Generator,
    stone: Stone,
    field: Field,
    at: np.ndarray,
    height_m: float,
    radius_m: float,
) -> Model:
    """A sea stack: a pillar of bedded rock, undercut by the waves, with turf on its top.

    Args:
        rng: of its shape.
        stone: what it is made of.
        field: noise that carves it.
        at: (2,) its middle [m]; the sea is at z = 0.
        height_m: above the sea.
        radius_m: at mid-height.
    """
    around = int(np.clip(2 * np.pi * radius_m / 0.9, 18, 90))
    up = int(np.clip((height_m + 4) / 0.9, 8, 60))
    angle = np.linspace(0, 2 * np.pi, around + 1)[:-1]
    z = np.concatenate([np.linspace(-4, height_m, up), np.full(5, height_m)])
    share = np.clip(z / height_m, -0.3, 1)
    profile = (
        1.15
        - 0.35 * share
        + 0.25 * np.exp(-(((z + 2) / 2.5) ** 2))
        - 0.14 * np.exp(-(((z - 0.9) / 0.8) ** 2))
    )
    profile[up:] = profile[up - 1] * np.array([0.93, 0.8, 0.6, 0.35, 0.0])
    z[up:] += np.array([0.3, 0.55, 0.75, 0.85, 0.9]) * min(1.0, 0.06 * height_m)
    lobes = (
        1
        + 0.16 * np.sin(2 * angle + rng.uniform(0, 6))
        + 0.1 * np.sin(3 * angle + rng.uniform(0, 6))
    )
    turn = np.broadcast_to(angle, (len(z), around))
    high = np.broadcast_to(z[:, None], turn.shape)
    # Sampled on a circle, so that the noise closes round the pillar.
    cs, cc = radius_m * np.cos(turn) + at[0], radius_m * np.sin(turn) + at[1]
    carve = 0.5 * np.clip(field.at(1.2 * cs, 1.2 * cc + 4.5 * high), -1, 1.3)
    carve += 0.35 * field.at(2.6 * cs + 1.3 * high, 2.6 * cc)
    body = np.minimum(1.0, profile[:, None] / 0.4)
    radius = radius_m * profile[:, None] * lobes + carve * min(1.0, 0.16 * radius_m + 0.3) * body
    radius = np.maximum(radius, 0.0)
    lean = rng.normal(0, 0.05, 2) * np.maximum(high, 0)[..., None]
    vertices = np.stack([radius * np.cos(turn), radius * np.sin(turn), high], -1)
    vertices[..., :2] += lean + at
    closed = np.concatenate([vertices, vertices[:, :1]], axis=1)
    faces = grid_faces(len(z), around + 1)
    faces = faces.reshape(len(z) - 1, -1, 3)
    girth = np.append(angle, 2 * np.pi) * radius_m
    uv = np.stack(np.broadcast_arrays(girth, closed[..., 2]), -1).reshape(-1, 2)
    tint = rock_tint(stone, field, closed[..., 0] * 0.3, closed[..., 2]).reshape(-1, 3)
    rock = faces[: up + 1].reshape(-1, 3)
    top = faces[up + 1 :].reshape(-1, 3)
    flat = closed.reshape(-1, 3)
    turf = height_m > 5
    model = {ROCK: _whole(flat, rock if turf else np.concatenate([rock, top]), uv, tint)}
    if turf:
        model["heath", "ground"] = _whole(flat, top, flat[:, :2], np.ones_like(tint))
    return model


def _whole(vertices, faces, uv, tint) -> Geometry:
    corner = vertices[faces]
    area = np.linalg.norm(cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]), axis=1)
    used, index = np.unique(faces[area > 1e-6], return_inverse=True)
    return geometry(vertices[used], index.reshape(-1, 3), uv[used], tint[used])


def rocks(
    rng: np.random.Generator, ground: Ground, stone: Stone, bounds: np.ndarray, density: float
) -> Model:
    """All loose rock of the shore; `density` is 1 for an ordinary coast."""
    shore = ground.shore
    look_up = shore.look_up
    s = rng.uniform(-HALF_M, HALF_M, int(5200 * density))
    rocky = look_up("rockiness", s)
    keep = rng.random(len(s)) < 0.06 + 0.94 * rocky**1.5
    s = s[keep]
    n = len(s)
    # Most lie under the cliff, fewer down the beach, some awash.
    kind = rng.random(n)
    foot = look_up("beach_m", s)
    away = np.where(
        kind < 0.55,
        foot + 1.5 - rng.gamma(1.6, 2.4, n),
        np.where(
            kind < 0.8, rng.uniform(-3, 1, n) * 3 + rng.random(n) * foot, -rng.gamma(1.5, 6, n)
        ),
    )
    # Falls come in heaps.
    heap = shore.fine.at(0.8 * s, 0.8 * away) + 0.6 * shore.ridges.at(s, 0 * s)
    size = 0.25 + rng.gamma(1.1, 0.5, n) * (0.6 + 0.5 * smooth(look_up("cliff_m", s), 3, 25))
    size = np.minimum(np.where(away < -3, 1.6 * size + 0.3, size), 5.0)
    keep = heap > -0.2
    s, away, size = s[keep], away[keep], size[keep]
    xy = shore.to_world(s, look_up("line_m", s) + away * look_up("stretch", s))
    z = ground.height_m(xy)
    # What lies deep must be large enough to show.
    keep = (z > -0.55 * size) & (z > -4)
    position = np.column_stack([xy, z])[keep]
    models = [
        boulders(rng, stone, shore.fine, position, size[keep], distance_to(bounds, position)),
        _cobbles(rng, ground, stone, bounds),
    ]
    models += _stacks(rng, ground, stone, density)
    return merge(models)


def _cobbles(rng: np.random.Generator, ground: Ground, stone: Stone, bounds: np.ndarray) -> Model:
    """Stones of a hand's to a foot's width, where the ground is stony and along the drift line."""
    shore = ground.shore
    s = rng.uniform(-HALF_M, HALF_M, 16_000)
    foot = shore.look_up("beach_m", s)
    d = rng.uniform(0, 1, len(s)) * (foot + 3)
    t = shore.look_up("line_m", s) + d * shore.look_up("stretch", s)
    stony = shore.fine.at(s, t) + 1.3 * shore.broad.at(s, t) > 2.4 - 3.6 * stone.shingle
    stony |= rng.random(len(s)) < 0.05 + 0.5 * shore.look_up("rockiness", s)
    drift = np.abs(d - shore.look_up("swash_m", s) - 2.0) < 1.2
    xy = shore.to_world(s, t)
    keep = (stony | (drift & (rng.random(len(s)) < 0.4))) & (distance_to(bounds, xy) < 10)
    xy = xy[keep][:6000]
    size = 0.1 + rng.gamma(1.5, 0.07, len(xy))
    position = np.column_stack([xy, ground.height_m(xy)])
    return boulders(rng, stone, shore.fine, position, size, np.full(len(xy), 99.0))


def _stacks(rng: np.random.Generator, ground: Ground, stone: Stone, density: float) -> list[Model]:
    """Stacks and skerries off rocky shores, near and far."""
    shore = ground.shore
    models = []
    s = rng.uniform(-1500, 1500, 60)
    s[:30] *= 0.18
    chance = rng.random(60)
    for at_s, lot in zip(s, chance, strict=True):
        rocky, cliff = (
            float(shore.look_up("rockiness", at_s)),
            float(shore.look_up("cliff_m", at_s)),
        )
        if rocky < 0.55 or lot > 0.17 * density:
            continue
        away = -rng.uniform(8, 55) * (1 + 1.2 * (abs(at_s) > HALF_M))
        height = rng.uniform(0.1, 0.9) ** 1.2 * cliff
        if height < 4.0:
            continue
        radius = float(np.clip(rng.uniform(0.12, 0.45) * height + 1.2, 1.8, 16.0))
        t = float(shore.look_up("line_m", at_s) + away * shore.look_up("stretch", at_s))
        xy = shore.to_world(np.float64(at_s), np.float64(t))
        models.append(stack(rng, stone, shore.fine, xy, float(height), radius))
    return models
