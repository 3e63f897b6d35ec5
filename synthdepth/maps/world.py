"""A generated world: what a map hands to flights, rendering and labels. No renderer here."""

import dataclasses
from collections.abc import Callable, Iterable, Mapping

import numpy as np

from synthdepth.maps.geometry import Geometry, Model, merge

# Class ids of `seg.png`; 0 is what no surface covers.
LABELS = {
    name: number
    for number, name in enumerate(
        [
            "sky",
            "ground",
            "road",
            "pavement",
            "building",
            "roof",
            "vegetation",
            "tree_trunk",
            "water",
            "vehicle",
            "person",
            "pole",
            "wire",
            "barrier",
            "street_furniture",
            "obstacle",
            "hill",
        ]
    )
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Material:
    """How a surface reflects light.

    Attributes:
        texture: (h, w, 3) uint8 sRGB, tiles seamlessly, first row is the top (largest v); the
            surface's linear reflectance is this times the geometry's tint.
        size_m: metres that the texture spans along u and along v.
        kind: "diffuse", "plastic" (diffuse under a clear coat), "metal", or "glass" (a dark
            reflecting pane: the inside of the building is not modelled).
        roughness: Beckmann alpha of the coat, the metal or the pane.
        smooth: interpolate vertex normals over shared vertices (car bodies, trunks, terrain).
    """

    texture: np.ndarray
    size_m: tuple[float, float] = (1.0, 1.0)
    kind: str = "diffuse"
    roughness: float = 0.1
    smooth: bool = False


@dataclasses.dataclass(frozen=True, kw_only=True)
class Light:
    """Sun, sky and air of a scene.

    Attributes:
        condition: name of the condition, e.g. "clear".
        sun_azimuth_deg: from +X, counter-clockwise seen from above.
        sun_elevation_deg: above the horizon.
        turbidity: of the clear-sky model, 1 to 10.
        visibility_m: meteorological visibility V; contrast falls to 2 % there (Koschmieder).
        exposure_ev: drawn error of the camera's exposure, in stops; 0 is a correct exposure.
    """

    condition: str
    sun_azimuth_deg: float
    sun_elevation_deg: float
    turbidity: float
    visibility_m: float
    exposure_ev: float

    @property
    def sun_direction(self) -> np.ndarray:
        """Unit vector towards the sun, (3,) float64."""
        a, e = np.radians(self.sun_azimuth_deg), np.radians(self.sun_elevation_deg)
        return np.array([np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)])


@dataclasses.dataclass(frozen=True, kw_only=True)
class World:
    """One generated place.

    Attributes:
        map: name of the map.
        scene_seed: the seed that it was drawn from.
        surfaces: geometry by (material, label).
        materials: by name.
        light: sun, sky and air.
        flight_bounds: (2, 2) float64, lower and upper corner [m] of the square that flights keep
            to in x and y; the world goes on well beyond it.
        ground_m: height of the ground [m] at points (n, 2) [m] -> (n,).
    """

    map: str
    scene_seed: int
    surfaces: Mapping[tuple[str, str], Geometry]
    materials: Mapping[str, Material]
    light: Light
    flight_bounds: np.ndarray
    ground_m: Callable[[np.ndarray], np.ndarray]

    @property
    def triangle_count(self) -> int:
        """Number of triangles."""
        return sum(len(g.faces) for g in self.surfaces.values())


def assemble(models: Iterable[Model], materials: Mapping[str, Material]) -> dict:
    """The surfaces of a world from its models, with unknown names refused early."""
    surfaces = merge(models)
    for material, label in surfaces:
        if material not in materials:
            raise KeyError(f"material {material!r} is not one of {sorted(materials)}")
        if label not in LABELS:
            raise KeyError(f"label {label!r} is not one of {sorted(LABELS)}")
    return {key: surfaces[key] for key in sorted(surfaces) if len(surfaces[key].faces)}
