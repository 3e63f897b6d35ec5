"""The table of street furniture, and many copies of one kind."""

from collections.abc import Callable

import numpy as np

from synthdepth.maps.furniture import (
    monuments,
    roadside,
    roadworks,
    seating,
    shelters,
    stalls,
)
from synthdepth.maps.furniture.parts import Surfaces
from synthdepth.maps.geometry import Geometry, Model, copies, join, yaw_matrix

# How many makes of a kind a place has; most of what comes in rows is all alike.
_MAKES = {
    "barrier_crowd": 1, "barrier_jersey": 1, "bench": 2, "bollard": 1, "hydrant": 1,
    "litter_bin": 2, "manhole": 2, "parking_meter": 1, "traffic_cone": 1,
}  # fmt: skip
_MOST_MAKES = 4

# Each stands on the ground at its origin; x is the side that people use.
FURNITURE: dict[str, Callable[[np.random.Generator], Model]] = {
    "advertising_column": shelters.advertising_column,
    "barrier_crowd": roadworks.barrier_crowd,
    "barrier_jersey": roadworks.barrier_jersey,
    "bench": seating.bench,
    "bicycle_rack": seating.bicycle_rack,
    "bollard": roadside.bollard,
    "bus_shelter": shelters.bus_shelter,
    "cafe_table": seating.cafe_table,
    "electric_box": roadside.electric_box,
    "fountain": monuments.fountain,
    "hydrant": roadside.hydrant,
    "kiosk": stalls.kiosk,
    "litter_bin": roadside.litter_bin,
    "mailbox": roadside.mailbox,
    "manhole": roadside.manhole,
    "market_stall": stalls.market_stall,
    "newspaper_box": roadside.newspaper_box,
    "parking_meter": roadside.parking_meter,
    "phone_box": shelters.phone_box,
    "picnic_table": seating.picnic_table,
    "planter": roadside.planter,
    "skip": roadworks.skip,
    "statue": monuments.statue,
    "traffic_cone": roadworks.traffic_cone,
}


def furniture(rng: np.random.Generator, name: str) -> Model:
    """One drawn piece, a key of `FURNITURE`, in its own frame (x forward, z up)."""
    if name not in FURNITURE:
        raise KeyError(f"furniture {name!r} is not one of {sorted(FURNITURE)}")
    return FURNITURE[name](rng)


def scatter_furniture(rng: np.random.Generator, name: str, position, yaw_rad) -> Surfaces:
    """Many pieces of one kind, copies of one to four makes.

    Args:
        rng: of the pieces and of their weathering.
        name: a key of `FURNITURE`.
        position: (k, 3) on the ground [m].
        yaw_rad: (k,) or scalar, where their fronts look.
    """
    at = np.asarray(position, np.float64).reshape(-1, 3)
    count = len(at)
    rotation = yaw_matrix(np.broadcast_to(np.asarray(yaw_rad, np.float64), count))
    tint = np.repeat(rng.uniform(0.9, 1.05, (count, 1)), 3, axis=1)
    built = min(count, _MAKES.get(name, _MOST_MAKES))
    which = rng.permutation(count) % max(built, 1)
    parts: dict[tuple[str, str], list[Geometry]] = {}
    for number in range(built):
        mine = np.flatnonzero(which == number)
        for key, part in furniture(rng, name).items():
            parts.setdefault(key, []).append(
                copies(part, at[mine], rotation=rotation[mine], tint=tint[mine])
            )
    return {key: join(group) for key, group in parts.items()}
