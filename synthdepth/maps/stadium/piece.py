"""What one part of a sports ground brings: surfaces, solid things, and who and what goes there.

Everything is planned on a flat plane, in the part's own frame. At the end the whole ground is laid
on the terrain at once (`drape`), which moves every vertex up by the height of the land below it.
"""

import dataclasses
from collections.abc import Callable

import numpy as np
import shapely
from shapely import affinity

from synthdepth.maps.geometry import Geometry, Model, copies, yaw_matrix
from synthdepth.maps.terrain import Terrain

Tint = Callable[[np.ndarray], np.ndarray]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Patch:
    """A surface of the ground.

    Attributes:
        area: polygons [m].
        surface: (material, label).
        tint: (3,) colour multiplier.
        cell_m: sides of the grid that it is cut along [m]; the first is a mowing stripe's share.
        origin_m: a corner of that grid, in the frame of the part [m].
        stripes: cells along x per mowing stripe; 0 without stripes.
        stripe_contrast: of neighbouring stripes, about the mean.
        worn: (k, 4) x, y, radius [m] and strength of wear.
        rank: of overlapping patches the one of higher rank is seen.
        turn_rad: of the grid; set when a part is put in its place.
    """

    area: shapely.Geometry
    surface: tuple[str, str]
    tint: tuple[float, float, float] = (1.0, 1.0, 1.0)
    cell_m: tuple[float, float] = (4.0, 4.0)
    origin_m: tuple[float, float] = (0.0, 0.0)
    stripes: int = 0
    stripe_contrast: float = 0.0
    worn: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 4)))
    rank: int = 1
    turn_rad: float = 0.0


@dataclasses.dataclass(kw_only=True)
class Piece:
    """One part of a sports ground; [m] and [rad] in its own frame.

    Attributes:
        models: solid things, on z = 0.
        patches: surfaces.
        trees, bushes: (k, 2).
        tufts: (k, 2).
        cars: (k, 3) x, y and heading.
        people: (pose, kit, (k, 3) x, y and heading).
        furniture: (name, (k, 3) x, y and heading).
        lamps: (k, 3) x, y and heading.
        hedges: (polyline (k, 2), height, width).
        keep_clear: where neither trees nor furniture of others may stand.
    """

    models: list[Model] = dataclasses.field(default_factory=list)
    patches: list[Patch] = dataclasses.field(default_factory=list)
    trees: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 2)))
    bushes: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 2)))
    tufts: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 2)))
    cars: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 3)))
    people: list[tuple[str, str, np.ndarray]] = dataclasses.field(default_factory=list)
    furniture: list[tuple[str, np.ndarray]] = dataclasses.field(default_factory=list)
    lamps: np.ndarray = dataclasses.field(default_factory=lambda: np.zeros((0, 3)))
    hedges: list[tuple[np.ndarray, float, float]] = dataclasses.field(default_factory=list)
    keep_clear: list[shapely.Geometry] = dataclasses.field(default_factory=list)


def turned(points: np.ndarray, at, yaw_rad: float) -> np.ndarray:
    """Points (k, 2), or places (k, 3) with a heading, of a frame at `at` turned by `yaw_rad`."""
    points = np.asarray(points, np.float64)
    xy = points[:, :2] @ yaw_matrix(yaw_rad)[:2, :2].T + np.asarray(at)[:2]
    return xy if points.shape[1] == 2 else np.column_stack([xy, points[:, 2] + yaw_rad])


def moved_area(area: shapely.Geometry, at, yaw_rad: float) -> shapely.Geometry:
    """An area of a frame at `at` turned by `yaw_rad`."""
    spun = affinity.rotate(area, yaw_rad, origin=(0, 0), use_radians=True)
    return affinity.translate(spun, float(at[0]), float(at[1]))


def moved(piece: Piece, at, yaw_rad: float) -> Piece:
    """A piece set down at `at` (2,) [m], turned by `yaw_rad`."""
    rotation, position = yaw_matrix(yaw_rad)[None], np.array([[*np.asarray(at)[:2], 0.0]])
    models = [
        {key: copies(part, position, rotation=rotation) for key, part in model.items()}
        for model in piece.models
    ]
    patches = []
    for patch in piece.patches:
        worn = patch.worn.copy()
        worn[:, :2] = turned(worn[:, :2], at, yaw_rad)
        patches.append(
            dataclasses.replace(
                patch,
                area=moved_area(patch.area, at, yaw_rad),
                origin_m=tuple(turned(np.array([patch.origin_m]), at, yaw_rad)[0]),
                worn=worn,
                turn_rad=patch.turn_rad + yaw_rad,
            )
        )
    return Piece(
        models=models,
        patches=patches,
        trees=turned(piece.trees, at, yaw_rad),
        bushes=turned(piece.bushes, at, yaw_rad),
        tufts=turned(piece.tufts, at, yaw_rad),
        cars=turned(piece.cars, at, yaw_rad),
        people=[(pose, kit, turned(p, at, yaw_rad)) for pose, kit, p in piece.people],
        furniture=[(name, turned(p, at, yaw_rad)) for name, p in piece.furniture],
        lamps=turned(piece.lamps, at, yaw_rad),
        hedges=[(turned(line, at, yaw_rad), h, w) for line, h, w in piece.hedges],
        keep_clear=[moved_area(area, at, yaw_rad) for area in piece.keep_clear],
    )


def together(pieces: list[Piece]) -> Piece:
    """All pieces, of one frame, as one."""
    whole = Piece()
    for field in dataclasses.fields(Piece):
        values = [getattr(piece, field.name) for piece in pieces]
        if isinstance(getattr(whole, field.name), np.ndarray):
            joined = np.concatenate([getattr(whole, field.name), *values])
        else:
            joined = [item for value in values for item in value]
        setattr(whole, field.name, joined)
    return whole


def drape(model: Model, terrain: Terrain) -> dict[tuple[str, str], Geometry]:
    """A model on z = 0 laid on the terrain: each vertex rises by the height of the land there."""
    out = {}
    for key, part in model.items():
        lifted = part.vertices.copy()
        lifted[:, 2] += terrain.height_m(part.vertices[:, :2]).astype(np.float32)
        out[key] = dataclasses.replace(part, vertices=lifted)
    return out
