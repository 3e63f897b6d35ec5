"""What stands on the sea's horizon: islands and ships, so that it never looks empty."""

import numpy as np

from synthdepth.maps.coast.boats import boat
from synthdepth.maps.coast.land import Stone, rock_tint
from synthdepth.maps.coast.shore import Shore, smooth
from synthdepth.maps.coast.terrain import grid_faces
from synthdepth.maps.geometry import Model, cross, geometry, merge, place


def _island(rng: np.random.Generator, shore: Shore, stone: Stone, at: np.ndarray) -> Model:
    """A hilly island with cliffs round it, its middle at world x, y `at`."""
    around, out = 72, 22
    length, width = rng.uniform(250, 1300), rng.uniform(120, 420)
    height = rng.uniform(25, 150)
    angle = np.linspace(0, 2 * np.pi, around + 1)
    share = np.linspace(1.0, 0.0, out) ** 0.9
    lobes = (
        1
        + 0.22 * np.sin(2 * angle + rng.uniform(0, 6))
        + 0.15 * np.sin(5 * angle + rng.uniform(0, 6))
    )
    lobes[-1] = lobes[0]
    radius = share[:, None] * lobes
    turn = shore.yaw_rad + rng.normal(0, 0.4)
    x, y = length * radius * np.cos(angle), width * radius * np.sin(angle)
    s, t = at[0] + np.cos(turn) * x - np.sin(turn) * y, at[1] + np.sin(turn) * x + np.cos(turn) * y
    crest = 1 - np.minimum(np.abs(shore.far.at(1.6 * s, 1.6 * t)), 1.5) / 1.5
    rough = shore.ridges.at(0.12 * s, 0.12 * t)
    inner = 1 - share[:, None]
    z = height * smooth(inner, 0.0, 0.75) * (0.35 + 0.65 * crest)
    z += 0.12 * height * smooth(inner, 0.02, 0.1) + 0.05 * height * rough * smooth(inner, 0, 0.3)
    z[0] = -3.0
    # A ring runs out and back at its seam: the last column is the first.
    z[:, -1] = z[:, 0]
    z[-1] = z[-1].mean()
    vertices = np.stack([s, t, z], -1).reshape(-1, 3)
    faces = grid_faces(out, around + 1).reshape(-1, 3)
    corner = vertices[faces]
    normal = cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    area = np.linalg.norm(normal, axis=1)
    faces, normal, corner = faces[area > 1e-3], normal[area > 1e-3], corner[area > 1e-3]
    steep = np.hypot(normal[:, 0], normal[:, 1]) > 0.9 * np.abs(normal[:, 2])
    bare = steep | (corner[..., 2].mean(axis=1) < 0.1 * height)
    # Slopes towards the map share no vertices with those behind the crest.
    away = np.einsum("ni,ni->n", corner.mean(axis=1) - [0, 0, 40.0], normal) > 0
    tint = rock_tint(stone, shore.fine, 0.1 * vertices[:, 0], vertices[:, 2])
    uv = np.column_stack([vertices[:, 0] + vertices[:, 1], vertices[:, 2]])
    models: list[Model] = [{("rock", "hill"): geometry(vertices, faces[bare], uv, tint)}]
    for side in (away, ~away):
        models.append({("hill", "hill"): geometry(vertices, faces[~bare & side])})
    return merge(models)


def horizon(rng: np.random.Generator, shore: Shore, stone: Stone) -> Model:
    """Three to seven islands and two to four ships, seaward."""
    models: list[Model] = []
    count = int(rng.integers(3, 8))
    bearing = np.linspace(-1.15, 1.15, count) + rng.normal(0, 0.16, count)
    for turn in bearing:
        reach = rng.uniform(1900, 7500)
        xy = shore.to_world(reach * np.sin(turn), -reach * np.cos(turn))
        models.append(_island(rng, shore, stone, xy))
    for _ in range(int(rng.integers(2, 5))):
        reach, turn = rng.uniform(900, 3800), rng.uniform(-0.95, 0.95)
        xy = shore.to_world(reach * np.sin(turn), -reach * np.cos(turn))
        kind = "cargo_ship" if reach > 1500 or rng.random() < 0.3 else "trawler"
        models.append(place(boat(rng, kind), [*xy, 0.0], rng.uniform(0, 2 * np.pi)))
    return merge(models)
