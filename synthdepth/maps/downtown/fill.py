"""What fills a block, collected: surfaces of the ground, and what stands where on it.

All trees, people, cars and pieces of furniture of a city are built together at the end, from a few
templates each.
"""

import dataclasses

import numpy as np
import shapely

from synthdepth.maps.downtown.parcels import oriented, polygons
from synthdepth.maps.furniture.signs import street_lamps
from synthdepth.maps.furniture.street_furniture import scatter_furniture
from synthdepth.maps.gardens.items import scatter
from synthdepth.maps.geometry import Geometry, Model, geometry, join
from synthdepth.maps.people import people
from synthdepth.maps.placement import distance_to
from synthdepth.maps.tessellation import draped, sliced
from synthdepth.maps.vegetation.shrubs import bushes, flowers, grass_tufts
from synthdepth.maps.vegetation.trees import plant
from synthdepth.maps.vehicles.vehicle import park

GROUND_M = 0.12  # the blocks lie level with the pavements
DECAL_M = 0.006
_SIGHT_M = 60.0  # small things farther than this from the flights are left out
Key = tuple[str, str]


@dataclasses.dataclass(frozen=True)
class Frame:
    """A place's own axes: x along its longer side.

    Attributes:
        origin: (2,) its middle [m].
        yaw_rad: of its x axis.
        length_m, width_m: of its tightest box.
    """

    origin: np.ndarray
    yaw_rad: float
    length_m: float
    width_m: float

    def out(self, xy) -> np.ndarray:
        """Points (n, 2) of the frame in the world."""
        c, s = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return np.asarray(xy, float).reshape(-1, 2) @ np.array([[c, s], [-s, c]]) + self.origin

    def area(self, xy) -> shapely.Polygon:
        """A polygon (n, 2) of the frame in the world."""
        return shapely.Polygon(self.out(xy))

    def rectangle(self, middle, size) -> shapely.Polygon:
        """A rectangle of the frame in the world; all (2,) [m]."""
        square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2
        return self.area(np.asarray(middle) + square * np.asarray(size))


def frame_of(area: shapely.Polygon) -> Frame:
    """The axes of an area's tightest box."""
    middle, long, length, width = oriented(area)
    return Frame(middle, float(np.arctan2(long[1], long[0])), length, width)


class Fill:
    """A growing collection of surfaces and things.

    Attributes:
        bounds: (2, 2) of the square that flights keep to [m].
        models: solid things in world coordinates.
    """

    def __init__(self, bounds: np.ndarray):
        self.bounds = np.asarray(bounds, float)
        self.models: list[Model] = []
        self._patches: dict[Key, list] = {}
        self._places: dict[str, dict[str, list[np.ndarray]]] = {}

    def distance_m(self, xy) -> np.ndarray:
        """Distance (n,) of points (n, 2) from the flights' square [m]."""
        return distance_to(self.bounds, np.asarray(xy, float).reshape(-1, 2))

    def near(self, area: shapely.Geometry, reach_m: float = _SIGHT_M) -> bool:
        """Whether any of an area lies within `reach_m` of the flights' square."""
        return shapely.box(*self.bounds.ravel()).distance(area) < reach_m

    def ground(self, layers: list) -> None:
        """Surfaces (area, (material, label), tint) of one block; later ones cover earlier ones."""
        covered = shapely.Polygon()
        for area, key, tint in reversed(layers):
            left = area.difference(covered) if not covered.is_empty else area
            shade = np.broadcast_to(np.asarray(tint, float), 3)
            pieces = polygons(left, 0.02)
            self._patches.setdefault(key, []).extend((piece, shade) for piece in pieces)
            covered = shapely.union(covered, area)

    def add(self, group: str, name: str, xy, yaw_rad=0.0) -> None:
        """Things of a group ("tree", "furniture", ...) and a kind at points (n, 2).

        Furniture, people and garden items that no flight comes near are left out.
        """
        xy = np.asarray(xy, float).reshape(-1, 2)
        place = np.column_stack([xy, np.broadcast_to(np.asarray(yaw_rad, float), len(xy))])
        if group in ("furniture", "person", "item", "flower", "tuft"):
            reach = 25.0 if group in ("flower", "tuft") else _SIGHT_M
            place = place[self.distance_m(xy) < reach]
        if len(place):
            self._places.setdefault(group, {}).setdefault(name, []).append(place)

    def _all(self, group: str):
        """(name, positions (n, 3), yaw (n,), distance (n,)) of each kind of a group."""
        for name, parts in sorted(self._places.get(group, {}).items()):
            place = np.concatenate(parts)
            at = np.column_stack([place[:, :2], np.full(len(place), GROUND_M)])
            yield name, at, place[:, 2], self.distance_m(place[:, :2])

    def built(self, rng: np.random.Generator) -> list[Model]:
        """Everything that was collected."""
        out = [self._surfaces(), *self.models]
        trees = list(self._all("tree"))
        if trees:
            species = np.concatenate([np.repeat(name, len(at)) for name, at, _, _ in trees])
            at = np.concatenate([at for _, at, _, _ in trees])
            out.append(plant(rng, at, species, np.concatenate([d for *_, d in trees])))
        for name, at, yaw, _ in self._all("furniture"):
            out.append(scatter_furniture(rng, name, at, yaw))
        for name, at, yaw, _ in self._all("item"):
            out.append(scatter(rng, name, at, yaw))
        for name, at, yaw, away in self._all("person"):
            seen = away < 40
            if seen.any():
                pose = None if name == "any" else name
                out.append(people(rng, at[seen], yaw[seen], pose=pose))
        for name, at, yaw, away in self._all("lamp"):
            seen = away < 2 * _SIGHT_M
            if seen.any():
                out.append(street_lamps(rng, at[seen], yaw[seen], name))
        for _, at, yaw, away in self._all("car"):
            # Parked between buildings they are seen from near only where flights go.
            out.append(park(rng, at, yaw, np.where(away > 3.0, 100.0, 0.0)))
        for _, at, _, away in self._all("bush"):
            out.append(bushes(rng, at, rng.uniform(0.6, 1.7, len(at)), away))
        for _, at, _, _ in self._all("flower"):
            out.append(flowers(rng, at, rng.uniform(0.2, 0.4, len(at))))
        for _, at, _, _ in self._all("tuft"):
            out.append(grass_tufts(rng, at, rng.uniform(0.08, 0.25, len(at))))
        return out

    def _surfaces(self) -> Model:
        model = {}
        for key, patches in self._patches.items():
            triangles, owner = _triangles([p for p, _ in patches])
            triangles, owner = sliced(triangles, owner)
            tints = np.stack([shade for _, shade in patches])[owner]
            model[key] = draped(triangles, lambda xy: np.full(len(xy), GROUND_M), tints, 0.1)
        return model


def _triangles(pieces: list[shapely.Polygon]) -> tuple[np.ndarray, np.ndarray]:
    """Corners (t, 3, 2) of the polygons' triangles, counter-clockwise, and each one's polygon."""
    parts, owner = shapely.get_parts(
        shapely.constrained_delaunay_triangles(np.array(pieces, object)), return_index=True
    )
    corners = shapely.get_coordinates(parts).reshape(-1, 4, 2)[:, :3]
    ab, ac = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    double = ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]
    corners = np.where((double < 0)[:, None, None], corners[:, ::-1], corners)
    solid = np.abs(double) > 1e-5
    return corners[solid], owner[solid]


def flat(area: shapely.Geometry, z: float, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """A level surface over an area at height z [m]."""
    triangles, _ = _triangles(polygons(area, 1e-3))
    xy = triangles.reshape(-1, 2)
    points = np.column_stack([xy, np.full(len(xy), z)])
    return geometry(points, np.arange(len(xy)).reshape(-1, 3), tint=tint)


def block(area: shapely.Geometry, z0: float, z1: float, tint=(1.0, 1.0, 1.0)) -> Geometry:
    """An upright prism over an area from z0 to z1, open below [m]."""
    parts = [flat(area, z1, tint)]
    for ring in shapely.get_rings(shapely.orient_polygons(np.array(polygons(area), object))):
        p = shapely.get_coordinates(ring)
        a, b = p[:-1], p[1:]
        keep = np.hypot(*(b - a).T) > 1e-3
        a, b = a[keep], b[keep]
        quad = np.stack(
            [
                np.column_stack([q, np.full(len(q), z)])
                for q, z in ((a, z0), (b, z0), (b, z1), (a, z1))
            ],
            axis=1,
        )  # fmt: skip
        along = np.cumsum(np.hypot(*(b - a).T))
        back = along - np.hypot(*(b - a).T)
        low, high = np.full(len(a), z0), np.full(len(a), z1)
        uv = np.stack(
            [np.stack([back, along, along, back], 1), np.stack([low, low, high, high], 1)], -1
        )
        first = 4 * np.arange(len(a))[:, None]
        faces = np.concatenate([first + [0, 1, 2], first + [0, 2, 3]])
        parts.append(geometry(quad, faces, uv.reshape(-1, 2), tint))
    return join(parts)
