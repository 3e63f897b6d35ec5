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


KINDS = ("diffuse", "plastic", "metal", "glass", "coated_glass", "water")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Material:
    """How a surface reflects light.

    Attributes:
        texture: (h, w, 3) uint8 sRGB, tiles seamlessly, first row is the top (largest v); the
            surface's linear reflectance is this times the geometry's tint.
        size_m: metres that the texture spans along u and along v.
        kind: one of `KINDS`: "plastic" is diffuse under a clear coat; "glass" a dark pane whose
            inside is not modelled, "coated_glass" one that mirrors more; "water" is deep water.
        roughness: Beckmann alpha of the coat, the metal, the pane or the water.
        smooth: interpolate vertex normals over shared vertices (car bodies, trunks, terrain).
        luminance_cdm2: light that it gives where lamps are on (`Light.lamps_on`), on the side that
            its normal points to; coloured by texture and tint.
    """

    texture: np.ndarray
    size_m: tuple[float, float] = (1.0, 1.0)
    kind: str = "diffuse"
    roughness: float = 0.1
    smooth: bool = False
    luminance_cdm2: float = 0.0


CONDITIONS = ("clear", "golden_hour", "overcast", "haze", "fog", "wet", "night")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Light:
    """Sun or moon, sky and air of a scene.

    Attributes:
        condition: one of `CONDITIONS`.
        sun_azimuth_deg: from +X, counter-clockwise seen from above; the moon's at night.
        sun_elevation_deg: above the horizon; the moon's at night.
        turbidity: of the clear-sky model, 1 to 10.
        visibility_m: meteorological visibility V; contrast falls to 2 % there (Koschmieder).
        cloud_cover: share of the sky under clouds; at 1 they hide the sun.
        cloud_seed: what the clouds' shapes are drawn from.
        wetness: of the ground, 0 (dry) to 1 (it has just rained).
        lamps_on: it is night: the moon stands in for the sun, and lamps and windows shine.
    """

    condition: str
    sun_azimuth_deg: float
    sun_elevation_deg: float
    turbidity: float
    visibility_m: float
    cloud_cover: float = 0.0
    cloud_seed: int = 0
    wetness: float = 0.0
    lamps_on: bool = False

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


def assemble(models: Iterable[Model]) -> dict[tuple[str, str], Geometry]:
    """The surfaces of a world from its models: joined, sorted, empty ones left out.

    Raises:
        KeyError: a label is not one of `LABELS`.
    """
    surfaces = merge(models)
    for _, label in surfaces:
        if label not in LABELS:
            raise KeyError(f"label {label!r} is not one of {sorted(LABELS)}")
    return {key: surfaces[key] for key in sorted(surfaces) if len(surfaces[key].faces)}
