"""Many people: a few built, each copied with a size and colours of its own."""

import numpy as np

from synthdepth.maps.geometry import Geometry, copies, join, yaw_matrix
from synthdepth.maps.people.body import SLOTS, Person, person
from synthdepth.maps.people.skeleton import varied
from synthdepth.maps.placement import pick

LABEL = "person"
_MIX = {"standing": 0.34, "walking": 0.40, "talking": 0.14, "phone": 0.10, "running": 0.02}

# Colours as (share, linear reflectance, spread over it).
_SKIN = np.array(
    [[0.58, 0.40, 0.31], [0.50, 0.33, 0.24], [0.42, 0.26, 0.17], [0.30, 0.17, 0.105],
     [0.17, 0.09, 0.055], [0.075, 0.042, 0.030]]
)  # fmt: skip
_HAIR = np.array(
    [[0.012, 0.011, 0.010], [0.030, 0.018, 0.011], [0.075, 0.042, 0.022], [0.26, 0.17, 0.08],
     [0.13, 0.045, 0.018], [0.24, 0.235, 0.23]]
)  # fmt: skip
_BRIGHT = np.array(
    [[0.42, 0.035, 0.03], [0.50, 0.30, 0.03], [0.05, 0.12, 0.30], [0.04, 0.24, 0.10],
     [0.45, 0.16, 0.03], [0.42, 0.10, 0.20], [0.06, 0.27, 0.30], [0.22, 0.07, 0.26],
     [0.55, 0.42, 0.12]]
)  # fmt: skip
_TOP = np.array(
    [[0.018, 0.018, 0.020], [0.022, 0.022, 0.024], [0.045, 0.046, 0.050], [0.020, 0.028, 0.060],
     [0.14, 0.14, 0.145], [0.25, 0.25, 0.25], [0.60, 0.60, 0.58], [0.52, 0.47, 0.38],
     [0.055, 0.085, 0.15], [0.065, 0.07, 0.035], [0.10, 0.018, 0.025], [0.16, 0.10, 0.055]]
)  # fmt: skip
_TOP_SHARE = np.array([14, 8, 14, 10, 9, 6, 13, 6, 8, 5, 3, 4.0])
_BOTTOM = np.array(
    [[0.030, 0.045, 0.085], [0.075, 0.105, 0.165], [0.15, 0.19, 0.25], [0.018, 0.018, 0.020],
     [0.05, 0.05, 0.055], [0.28, 0.22, 0.15], [0.20, 0.20, 0.20], [0.5, 0.48, 0.44]]
)  # fmt: skip
_BOTTOM_SHARE = np.array([22, 17, 6, 24, 12, 10, 5, 4.0])
_SHOES = np.array(
    [[0.02, 0.02, 0.02], [0.05, 0.035, 0.025], [0.55, 0.55, 0.54], [0.14, 0.08, 0.04]]
)


def _draw(rng, count: int, table: np.ndarray, share=None, spread: float = 0.12) -> np.ndarray:
    """Colours (count, 3) of a table's rows, each a little lighter or darker."""
    p = None if share is None else share / share.sum()
    light = np.exp(rng.normal(0, spread, (count, 1)))
    return np.clip(table[rng.choice(len(table), count, p=p)] * light, 0.008, 0.75)


def _colours(rng: np.random.Generator, count: int, kit: np.ndarray | None) -> dict[str, np.ndarray]:
    """Colours (count, 3) by slot: mostly black, grey, navy, denim and white; 15 % bright."""
    bright = rng.random((count, 2)) < (0.15, 0.04)
    tone = rng.choice(len(_SKIN), count, p=[0.2, 0.24, 0.2, 0.14, 0.12, 0.1])
    hair = _draw(rng, count, _HAIR, np.array([28, 26, 20, 10, 4, 12.0]))
    top = _draw(rng, count, _TOP, _TOP_SHARE)
    bottom = _draw(rng, count, _BOTTOM, _BOTTOM_SHARE)
    top = np.where(bright[:, :1], _draw(rng, count, _BRIGHT), top)
    bottom = np.where(bright[:, 1:], _draw(rng, count, _BRIGHT), bottom)
    extra = _draw(rng, count, _TOP, _TOP_SHARE)
    shoes = _draw(rng, count, _SHOES, np.array([45, 15, 28, 12.0]))
    inner = _draw(rng, count, _TOP, _TOP_SHARE[::-1])
    if kit is not None:
        top = np.broadcast_to(np.asarray(kit, float).reshape(-1, 3), (count, 3))
        # Shorts follow from the shirt, so that a team's are all alike.
        pale = (top @ [0.21, 0.72, 0.07])[:, None] > 0.2
        bottom = np.where(pale, [0.022, 0.024, 0.032], [0.58, 0.58, 0.57])
    return {
        "skin": _SKIN[tone] * rng.uniform(0.88, 1.08, (count, 1)),
        "hair": np.where(tone[:, None] >= 3, _HAIR[0], hair),
        "top": top,
        "bottom": bottom,
        "extra": extra,
        "shoes": shoes,
        "inner": inner,
    }


def draw_person(rng: np.random.Generator, pose: str, player: bool = False) -> Person:
    """Someone in a pose (a key of `POSES`): an adult, one in nine a child; or a player in kit."""
    child = not player and bool(rng.random() < 0.11)
    woman = not player and bool(rng.random() < 0.5)
    seated = pose == "sitting"
    if child:
        stature = rng.uniform(1.18, 1.5)
    else:
        stature = np.clip(rng.normal(1.655 if woman else 1.785, 0.065), 1.5, 1.97)
    girth = 1.0 if child else float(np.clip(rng.normal(1.05, 0.11), 0.86, 1.36))
    sporty = player or pose == "running"
    if sporty:
        girth = min(girth, 1.06)
    tops = {"tshirt": 0.34, "shirt": 0.26, "jacket": 0.28, "coat": 0.0 if seated else 0.12}
    bottoms = {"trousers": 0.80, "shorts": 0.12, "skirt": 0.16 * woman * (not seated)}
    hairs = {"long": 0.5, "tail": 0.24, "short": 0.18, "hat": 0.05, "beanie": 0.03}
    if not woman:
        hairs = {"short": 0.66, "bald": 0.12, "cap": 0.13, "beanie": 0.09}
    bags = {"none": 0.6, "backpack": 0.18, "shoulder": 0.14, "shopping": 0.08}
    top, bottom = pick(rng, tops), pick(rng, bottoms)
    hair, bag = pick(rng, hairs), pick(rng, bags)
    if sporty:
        top, bottom, bag = "tshirt", pick(rng, {"shorts": 0.7, "trousers": 0.3}), "none"
    if player:
        top, bottom, hair = "jersey", "shorts", "bald" if rng.random() < 0.1 else "short"
    if seated or pose in ("arms_up", "talking"):
        bag = "none" if seated else pick(rng, {"none": 0.7, "backpack": 0.3})
    if top == "coat":
        bottom = "trousers"
    return Person(
        stature_m=float(stature),
        girth=girth,
        shoulders=float(rng.normal(0.91 if woman else 1.02, 0.03)),
        hips=float(rng.normal(1.05 if woman else 0.98, 0.03)),
        pose=varied(rng, pose),
        top=top,
        bottom=bottom,
        hair=hair,
        bag=bag,
        open_front=bool(rng.random() < 0.5),
        hem=float(rng.uniform(0.27, 0.42)),
        phone=pose == "phone",
    )


def people(
    rng: np.random.Generator, position, yaw_rad, *, pose: str | None = None, kit=None
) -> dict[tuple[str, str], Geometry]:
    """People of every build and colour, dressed mostly dark.

    Args:
        rng: of who they are.
        position: (k, 3) on the ground below each [m]; those who sit need a seat of 0.45 m there.
        yaw_rad: (k,) or scalar, where they look.
        pose: a key of `POSES`; by default a mixture of pedestrians.
        kit: (3,) or (k, 3) linear reflectance of football shirts; makes players of them.
    """
    at = np.asarray(position, np.float64).reshape(-1, 3)
    count = len(at)
    yaw = np.broadcast_to(np.asarray(yaw_rad, np.float64), count)
    built = min(count, 16)
    colours = _colours(rng, count, kit)
    which = rng.permutation(count) % max(built, 1)
    size = 1 + np.clip(rng.normal(0, 0.02, (count, 1)), -0.04, 0.04)
    wide = size * rng.uniform(0.96, 1.05, (count, 1))
    # Those who sit keep to the height of their seats.
    size = np.concatenate([wide, wide, size if pose != "sitting" else np.ones((count, 1))], axis=1)
    rotation = yaw_matrix(yaw)
    parts: dict[tuple[str, str], list[Geometry]] = {}
    for number in range(built):
        name = pose or pick(rng, _MIX)
        mine = np.flatnonzero(which == number)
        for slot, part in person(draw_person(rng, name, kit is not None)).items():
            if len(part.faces):
                parts.setdefault((SLOTS[slot], LABEL), []).append(
                    copies(
                        part,
                        at[mine],
                        rotation=rotation[mine],
                        scale=size[mine],
                        tint=colours[slot][mine],
                    )
                )
    return {key: join(group) for key, group in parts.items()}
