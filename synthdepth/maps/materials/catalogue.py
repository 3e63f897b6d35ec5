"""The catalogue of materials: every surface's texture, baked anew for each scene.

Neutral materials are near white and take their reflectance from the geometry's tint; the others
hold it, and their tint stays near 1.
"""

from collections.abc import Callable, Iterable

import numpy as np

from synthdepth.maps.materials.arena import ARENA
from synthdepth.maps.materials.city import CITY
from synthdepth.maps.materials.coast import COAST
from synthdepth.maps.materials.coloured import COLOURED
from synthdepth.maps.materials.luminous import LUMINOUS
from synthdepth.maps.materials.neutral import NEUTRAL
from synthdepth.maps.materials.sports import SPORTS
from synthdepth.maps.world import Material
from synthdepth.seeding import lane

CATALOGUE: dict[str, Callable[[np.random.Generator], Material]] = {
    **NEUTRAL,
    **COLOURED,
    **ARENA,
    **CITY,
    **COAST,
    **SPORTS,
    **LUMINOUS,
}


def bake_materials(rng: np.random.Generator, names: Iterable[str]) -> dict[str, Material]:
    """Some materials of the catalogue, drawn and baked.

    Each has a lane of its own, keyed by its name: using, adding or changing one leaves the others'
    bytes alone.

    Args:
        rng: one number is drawn from it.
        names: which.

    Raises:
        KeyError: the catalogue has no such material.
    """
    seed = int(rng.integers(2**53))
    return {name: CATALOGUE[name](lane(seed, name)) for name in sorted(set(names))}
