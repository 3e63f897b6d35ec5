"""Boats of all kinds, afloat and ashore: the table of kinds, and many of them at once."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.coast.cruisers import CRUISERS
from synthdepth.maps.coast.fishing import FISHING_BOATS
from synthdepth.maps.coast.ships import SHIPS
from synthdepth.maps.coast.small_craft import SMALL_CRAFT
from synthdepth.maps.coast.yachts import YACHTS
from synthdepth.maps.geometry import Geometry, Model, copies, merge, yaw_matrix

BOATS: dict[str, Callable[[np.random.Generator], Model]] = {
    **SMALL_CRAFT,
    **YACHTS,
    **CRUISERS,
    **FISHING_BOATS,
    **SHIPS,
}
_SHIPS = ("cargo_ship",)
_ASHORE = ("dinghy", "rowing_boat", "kayak", "rowing_boat", "dinghy", "kayak", "rib")
_AFLOAT = (
    "sailing_yacht",
    "sailing_yacht",
    "sailing_yacht",
    "motorboat",
    "motorboat",
    "cabin_cruiser",
    "fishing_boat",
    "rowing_boat",
    "dinghy",
    "rib",
    "catamaran",
    "trawler",
)


def boat(rng: np.random.Generator, kind: str | None = None) -> Model:
    """One drawn boat: its waterline at z = 0, x forward, origin amidships.

    Args:
        rng: the lane of the boats.
        kind: a key of `BOATS`; drawn (no ship) when none.
    """
    if kind is None:
        kind = str(rng.choice([name for name in BOATS if name not in _SHIPS]))
    if kind not in BOATS:
        raise KeyError(f"boat {kind!r} is not one of {sorted(BOATS)}")
    return BOATS[kind](rng)


def scatter_boats(
    rng: np.random.Generator, position, yaw_rad, *, ashore: bool, variants: int = 8
) -> dict[tuple[str, str], Geometry]:
    """Boats at many places, from a few drawn ones.

    Args:
        rng: the lane of the boats.
        position: (k, 3) [m], on the sand (ashore) or on the water.
        yaw_rad: (k,) of the bows, from +X.
        ashore: small kinds only, keel sunk in the sand and heeled onto the bilge.
        variants: how many different boats at most.

    Returns:
        Geometry by (material, label).
    """
    at = np.asarray(position, np.float64).reshape(-1, 3)
    k = len(at)
    kinds = [name for name in (_ASHORE if ashore else _AFLOAT) if name in BOATS]
    count = min(variants, k)
    order = rng.permutation(len(kinds))
    names = [kinds[order[i % len(kinds)]] for i in range(count)]
    models = [boat(rng, name) for name in names]
    pick = rng.integers(max(count, 1), size=k)
    heel = rng.normal(0, 0.012, k)
    if ashore:
        heel = np.where(rng.random(k) < 0.5, 1, -1) * rng.uniform(0.06, 0.2, k)
    c, s, o, i = np.cos(heel), np.sin(heel), np.zeros(k), np.ones(k)
    about_x = np.stack(
        [np.stack([i, o, o], -1), np.stack([o, c, -s], -1), np.stack([o, s, c], -1)], -2
    )
    rotation = yaw_matrix(np.asarray(yaw_rad, np.float64).reshape(k)) @ about_x
    placed = []
    for index, model in enumerate(models):
        chosen = pick == index
        if not chosen.any():
            continue
        where = at[chosen].copy()
        if ashore:
            where[:, 2] += _rest_height(model, rotation[chosen]) - 0.05
        placed.append(
            {key: copies(p, where, rotation=rotation[chosen]) for key, p in model.items()}
        )
    return merge(placed)


def _rest_height(model: Model, rotation: np.ndarray) -> np.ndarray:
    """How far (k,) [m] each turned boat is to be lifted to stand on its lowest hull point."""
    hull = np.concatenate(
        [
            g.vertices
            for (material, _), g in model.items()
            if material in ("car_paint", "paint", "wood")
        ]
    )
    hull = hull[np.abs(hull[:, 0]) < 0.42 * np.ptp(hull[:, 0])]
    return -np.einsum("nj,kj->kn", hull, rotation[:, 2]).min(axis=1)
