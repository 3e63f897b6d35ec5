"""What weather and hour do to a finished world: rain on the ground, light in the windows."""

import dataclasses

import numpy as np

from synthdepth.maps.geometry import Geometry, cross, geometry, join
from synthdepth.maps.materials.catalogue import bake_materials
from synthdepth.maps.materials.textures import encode
from synthdepth.maps.world import Material, World
from synthdepth.seeding import lane

# What rain wets: surfaces that lie open to it.
_WET_LABELS = ("ground", "road", "pavement", "roof")
# Blades stand up: rain does not make a mirror of them.
_BLADES = ("grass", "turf", "worn_turf", "synthetic_turf", "heath")
# A film of water fills the pores: less light comes back, and more of it as a mirror's
# (Lekner & Dorf 1988 find 0.4 to 0.6 of the dry reflectance for porous ground).
_WET_REFLECTANCE = 0.55
_WET_ROUGHNESS = 0.08

# A puddle: how many a square metre of open ground, how large, how far above it.
_PUDDLES_PER_M2 = 0.004
_PUDDLE_RADIUS_M = (0.25, 1.6)
_PUDDLE_CORNERS = 14
_PUDDLE_UP_M = 0.007

# Rooms behind a facade, seen from outside: lights go on and off room by room.
_ROOM_M = np.array([4.5, 4.5, 3.1])
_LIT_SHARE = (0.15, 0.6)
# Linear tints of room light: tungsten, warm and neutral white, a screen's blue.
_ROOM_COLOURS = np.array(
    [[1.0, 0.62, 0.28], [1.0, 0.78, 0.5], [0.95, 0.92, 0.82], [0.4, 0.55, 1.0]]
)
_ROOM_WEIGHTS = (0.35, 0.4, 0.2, 0.05)
_ROOM_TABLE = 65_521

Surfaces = dict[tuple[str, str], Geometry]


def weathered(world: World) -> World:
    """The world under its light: wet where it has rained, rooms lit where it is night."""
    light = world.light
    surfaces, materials = dict(world.surfaces), dict(world.materials)
    if light.lamps_on:
        surfaces = _lit_rooms(lane(world.scene_seed, "rooms"), surfaces)
    if light.wetness > 0:
        surfaces |= _puddles(lane(world.scene_seed, "puddles"), world, light.wetness)
        surfaces, materials = _wetted(surfaces, materials, light.wetness)
    used = {name for name, _ in surfaces}
    materials |= bake_materials(lane(world.scene_seed, "materials"), used - materials.keys())
    return dataclasses.replace(
        world,
        surfaces={key: surfaces[key] for key in sorted(surfaces)},
        materials={name: materials[name] for name in sorted(used)},
    )


def _wetted(
    surfaces: Surfaces, materials: dict[str, Material], wetness: float
) -> tuple[Surfaces, dict[str, Material]]:
    """Open ground under a film of water; what is no dull solid (glass, metal) stays as it is."""
    out, made = {}, dict(materials)
    for (name, label), part in surfaces.items():
        if label in _WET_LABELS and materials[name].kind == "diffuse" and name not in _BLADES:
            wet = f"wet {name}"
            made[wet] = _wet(materials[name], wetness)
            name = wet
        out[name, label] = part
    return out, made


def _wet(dry: Material, wetness: float) -> Material:
    darker = 1 - wetness * (1 - _WET_REFLECTANCE)
    linear = (dry.texture / np.float32(255)) ** np.float32(2.2)
    return dataclasses.replace(
        dry,
        texture=encode(linear * np.float32(darker)),
        kind="plastic",
        roughness=_WET_ROUGHNESS,
    )


def _puddles(rng: np.random.Generator, world: World, wetness: float) -> Surfaces:
    """Standing water on roads and pavements of the flight area."""
    low, high = world.flight_bounds - [[20.0], [-20.0]]
    corners = [
        part.triangles
        for (_, label), part in world.surfaces.items()
        if label in ("road", "pavement")
    ]
    tri = np.concatenate([*corners, np.zeros((0, 3, 3), np.float32)]).astype(np.float64)
    normal = cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    area = np.linalg.norm(normal, axis=1) / 2
    middle = tri.mean(axis=1)[:, :2]
    # Water stays where it is level, and nobody looks under bridges.
    open_ground = (normal[:, 2] > 2 * 0.995 * area) & (area > 0.05)
    open_ground &= ((middle > low) & (middle < high)).all(axis=1)
    tri, area = tri[open_ground], area[open_ground]
    count = int(area.sum() * _PUDDLES_PER_M2 * wetness)
    if not count:
        return {}
    chosen = np.searchsorted(np.cumsum(area), rng.random(count) * area.sum(), side="right")
    chosen = np.minimum(chosen, len(tri) - 1)
    a, b = np.sqrt(rng.random(count)), rng.random(count)
    weights = np.stack([1 - a, a * (1 - b), a * b], axis=1)
    centre = np.einsum("kc,kcx->kx", weights, tri[chosen])
    # Each lies in the plane of the face under it; a blob of a few harmonics.
    edge = tri[chosen, 1] - tri[chosen, 0]
    plane = cross(edge, tri[chosen, 2] - tri[chosen, 0])
    slope = -plane[:, :2] / plane[:, 2:]
    turn = 2 * np.pi * np.arange(_PUDDLE_CORNERS) / _PUDDLE_CORNERS
    radius = np.exp(rng.uniform(*np.log(_PUDDLE_RADIUS_M), count))
    wave = sum(
        rng.uniform(0, 0.3 / k, (count, 1)) * np.sin(k * turn + rng.uniform(0, 7, (count, 1)))
        for k in (1, 2, 3, 4)
    )
    stretch, yaw = rng.uniform(1, 2.2, (count, 1)), rng.uniform(0, np.pi, (count, 1))
    reach = radius[:, None] * (1 + wave)
    x, y = reach * np.cos(turn) * np.sqrt(stretch), reach * np.sin(turn) / np.sqrt(stretch)
    dx, dy = x * np.cos(yaw) - y * np.sin(yaw), x * np.sin(yaw) + y * np.cos(yaw)
    rim = np.stack([dx, dy, dx * slope[:, :1] + dy * slope[:, 1:]], axis=-1) + centre[:, None]
    vertices = np.concatenate([centre[:, None], rim], axis=1) + [0, 0, _PUDDLE_UP_M]
    step = np.arange(_PUDDLE_CORNERS)
    fan = np.stack([np.zeros_like(step), 1 + step, 1 + (step + 1) % _PUDDLE_CORNERS], axis=1)
    faces = fan[None] + (np.arange(count) * (_PUDDLE_CORNERS + 1))[:, None, None]
    return {("glass", "water"): geometry(vertices, faces)}


def _lit_rooms(rng: np.random.Generator, surfaces: Surfaces) -> Surfaces:
    """Panes of some rooms become lit windows."""
    share = rng.uniform(*_LIT_SHARE)
    salt = rng.integers(1, 2**31, 3)
    rooms = rng.random((_ROOM_TABLE, 3))
    out, shining = {}, []
    for key, part in surfaces.items():
        if key not in (("glass", "building"), ("coated_glass", "building")):
            out[key] = part
            continue
        # Two faces make a pane; a pane has one room behind it.
        middle = part.triangles.mean(axis=1)
        even = len(middle) // 2 * 2
        middle[:even] = np.repeat(middle[:even].reshape(-1, 2, 3).mean(axis=1), 2, axis=0)
        room = rooms[np.floor(middle / _ROOM_M).astype(np.int64) @ salt % _ROOM_TABLE]
        lit = room[:, 0] < share
        out[key] = _faces(part, ~lit)
        kind = np.searchsorted(np.cumsum(_ROOM_WEIGHTS), room[lit, 1], side="right")
        tint = _ROOM_COLOURS[np.minimum(kind, len(_ROOM_COLOURS) - 1)]
        tint = tint * (0.2 + 0.8 * room[lit, 2:] ** 2)
        panes = _faces(part, lit)
        shining.append(dataclasses.replace(panes, tint=np.repeat(tint, 3, axis=0)))
    if shining:
        out["lit_window", "building"] = join(shining)
    return {key: part for key, part in out.items() if len(part.faces)}


def _faces(part: Geometry, chosen: np.ndarray) -> Geometry:
    """Some faces of a geometry, with vertices of their own."""
    corner = part.faces[chosen].ravel()
    return geometry(
        part.vertices[corner], np.arange(len(corner)), part.uv[corner], part.tint[corner]
    )
