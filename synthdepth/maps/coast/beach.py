"""Things on a beach: the table of kinds, and a mix of them at many places."""

from collections.abc import Callable, Mapping

import numpy as np

from synthdepth.maps.coast.beach_buildings import BEACH_BUILDINGS
from synthdepth.maps.coast.beach_finds import FINDS
from synthdepth.maps.coast.beach_leisure import LEISURE
from synthdepth.maps.geometry import Geometry, Model, copies, merge, yaw_matrix

# Each draws and builds one: its front, or the sea, towards +x.
BEACH_ITEMS: dict[str, Callable[[np.random.Generator], Model]] = {
    **LEISURE,
    **BEACH_BUILDINGS,
    **FINDS,
}
# Radius of the ground that each needs [m].
BEACH_RADIUS_M = {
    "parasol": 2.5,
    "towel": 1.4,
    "lounger": 1.2,
    "windbreak": 3.0,
    "cooler": 1.0,
    "surfboards": 2.0,
    "volleyball_net": 9.2,
    "beach_hut": 2.8,
    "hut_row": 11.5,
    "lifeguard_tower": 7.5,
    "beach_flag": 1.8,
    "sandcastle": 1.7,
    "driftwood": 3.4,
    "lobster_pots": 1.6,
    "net_poles": 5.5,
    "floats": 1.8,
    "wrack": 2.7,
}
# How often each of the small kinds is met.
BATHERS = {
    "parasol": 5.0,
    "towel": 2.5,
    "lounger": 2.0,
    "windbreak": 2.0,
    "cooler": 1.0,
    "surfboards": 0.8,
    "sandcastle": 0.7,
    "beach_flag": 0.5,
}
LEFT_BY_THE_SEA = {
    "driftwood": 2.0,
    "wrack": 4.0,
    "lobster_pots": 0.6,
    "floats": 0.7,
    "net_poles": 0.3,
}


def beach_item(rng: np.random.Generator, name: str) -> Model:
    """One drawn item, a key of `BEACH_ITEMS`, in its own frame."""
    if name not in BEACH_ITEMS:
        raise KeyError(f"beach item {name!r} is not one of {sorted(BEACH_ITEMS)}")
    return BEACH_ITEMS[name](rng)


def beach_items(
    rng: np.random.Generator,
    position,
    yaw_rad,
    *,
    weights: Mapping[str, float] | None = None,
    variants: int = 4,
) -> dict[tuple[str, str], Geometry]:
    """A mix of things at many places, each kind from a few variants.

    Args:
        rng: the lane of the beach.
        position: (k, 3) on the sand [m].
        yaw_rad: (k,) of their fronts.
        weights: how often each kind is met; bathers' and the sea's small things when none.
        variants: different ones of a kind, at most.

    Returns:
        Geometry by (material, label).
    """
    at = np.asarray(position, np.float64).reshape(-1, 3)
    rotation = yaw_matrix(np.asarray(yaw_rad, np.float64).reshape(len(at)))
    table = dict({**BATHERS, **LEFT_BY_THE_SEA} if weights is None else weights)
    names = list(table)
    share = np.array([table[name] for name in names], np.float64)
    kind = rng.choice(len(names), size=len(at), p=share / share.sum())
    variant = rng.integers(variants, size=len(at))
    placed = []
    for i, name in enumerate(names):
        for j in range(variants):
            chosen = (kind == i) & (variant == j)
            if not chosen.any():
                continue
            model = beach_item(rng, name)
            placed.append(
                {key: copies(p, at[chosen], rotation=rotation[chosen]) for key, p in model.items()}
            )
    return merge(placed)
