"""Trees: single ones in full, and whole plantings at several levels of detail.

Detail depends on the distance to the region that flights may use, never on a flight.
"""

import dataclasses

import numpy as np
from scipy.spatial.transform import Rotation

from synthdepth.maps.geometry import Geometry, Model, copies, join, yaw_matrix
from synthdepth.maps.vegetation.foliage import clumps, tapers
from synthdepth.maps.vegetation.growth import Crown, Wood, grow
from synthdepth.maps.vegetation.species import SPECIES, Tree, draw_tree, species_named

__all__ = ["DETAILS", "SPECIES", "Detail", "Tree", "draw_tree", "plant", "tree"]

LEAF = ("leaf", "vegetation")
BARK = ("bark", "tree_trunk")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Detail:
    """How much of a tree is kept.

    Attributes:
        beyond_m: distance from the flights' region from which this holds.
        share: of the clumps, whose area is enlarged by the inverse.
        most: clumps at most.
        sides: of trunk and branches.
        orders: of branching kept, the trunk being the first.
        stations: of the trunk kept.
    """

    beyond_m: float
    share: float
    most: int
    sides: tuple[int, int, int]
    orders: int
    stations: int


DETAILS = (
    Detail(beyond_m=-1.0, share=1.0, most=10_000, sides=(7, 4, 3), orders=3, stations=99),
    Detail(beyond_m=0.5, share=0.33, most=240, sides=(6, 3, 3), orders=2, stations=6),
    Detail(beyond_m=60.0, share=0.12, most=90, sides=(4, 3, 3), orders=2, stations=4),
    Detail(beyond_m=150.0, share=0.06, most=36, sides=(3, 3, 3), orders=1, stations=3),
    Detail(beyond_m=400.0, share=0.03, most=12, sides=(3, 3, 3), orders=1, stations=2),
)


def _thinned(crown: Crown, detail: Detail) -> Crown:
    """A stochastic simplification: fewer clumps of the same area in all (Cook et al. 2007)."""
    n = len(crown.centre)
    kept = int(np.clip(np.ceil(detail.share * n), 1, detail.most))
    pick = (np.arange(kept) * n) // kept
    thin = {f.name: getattr(crown, f.name)[pick] for f in dataclasses.fields(crown)}
    swell = np.sqrt(n / kept)
    # Larger clumps would swell the crown: draw them in by what they have gained.
    gain = 0.5 * (swell - 1) * crown.length_m.mean()
    middle = crown.centre.mean(axis=0)
    extent = np.abs(crown.centre - middle).max(axis=0)
    thin["centre"] = middle + (thin["centre"] - middle) * np.clip(1 - gain / extent, 0.45, 1)
    thin["length_m"] = thin["length_m"] * swell
    thin["width_m"] = thin["width_m"] * swell
    return Crown(**thin)


def _build(grown: tuple[list[Wood], Crown], leafless: bool, detail: Detail) -> dict:
    """The model of a grown tree at some detail."""
    woods, crown = grown
    parts: dict[tuple[str, str], list[Geometry]] = {LEAF: [], BARK: []}
    for order, wood in enumerate(woods[: detail.orders]):
        path, radius, tint = wood.path, wood.radius_m, wood.tint
        if order == 0 and path.shape[1] > detail.stations:
            rows = np.linspace(0, path.shape[1] - 1, detail.stations).astype(int)
            path, radius, tint = path[:, rows], radius[:, rows[:-1]], tint[:, rows]
        if len(path):
            parts[BARK].append(tapers(path, radius, detail.sides[order], tint))
    thin = crown if detail.share == 1 else _thinned(crown, detail)
    fields = {f.name: getattr(thin, f.name) for f in dataclasses.fields(thin)}
    parts[BARK if leafless else LEAF].append(clumps(**fields))
    return {key: join(part) for key, part in parts.items() if part}


def tree(params: Tree) -> Model:
    """A tree in full detail; its foot is sunk 0.35 m for slopes."""
    return _build(grow(params), species_named(params.species).leafless, DETAILS[0])


def plant(
    rng: np.random.Generator,
    positions: np.ndarray,
    species: np.ndarray,
    near_m: np.ndarray,
    templates: int = 6,
) -> dict[tuple[str, str], Geometry]:
    """Many trees: copies of a few templates a species, each with its own size, turn and colour.

    Args:
        rng: of the templates and of the copies.
        positions: (k, 3) feet on the ground [m].
        species: (k,) keys of `SPECIES`.
        near_m: (k,) distance [m] from the region that flights may use; chooses the detail.
        templates: different trees a species.
    """
    positions = np.asarray(positions, np.float64).reshape(-1, 3)
    species = np.asarray(species)
    k = len(positions)
    for name in np.unique(species):
        species_named(str(name))
    starts = np.array([d.beyond_m for d in DETAILS])
    level = np.searchsorted(starts, np.asarray(near_m, np.float64), side="right") - 1
    which = rng.integers(templates, size=k)
    girth = rng.uniform(0.85, 1.18, k)
    scale = np.column_stack([girth, girth, girth * rng.uniform(0.9, 1.12, k)])
    lean = Rotation.from_rotvec(np.column_stack([rng.normal(0, 0.025, (k, 2)), np.zeros(k)]))
    rotation = lean.as_matrix() @ yaw_matrix(rng.uniform(0, 2 * np.pi, k))
    tint = rng.normal(1.0, 0.07, (k, 1)) * rng.normal(1.0, [0.06, 0.03, 0.07], (k, 3))
    tint = np.clip(tint, 0.7, 1.35)
    # One lane a species: the first oak is the same whatever else grows here.
    lanes = dict(zip(SPECIES, rng.spawn(len(SPECIES)), strict=True))

    parts: dict[tuple[str, str], list[Geometry]] = {LEAF: [], BARK: []}
    for name, kind in SPECIES.items():
        here = species == name
        if not here.any():
            continue
        for number in range(templates):
            grown = grow(draw_tree(lanes[name], name))
            for tier, detail in enumerate(DETAILS):
                at = np.flatnonzero(here & (which == number) & (level == tier))
                if not len(at):
                    continue
                for key, part in _build(grown, kind.leafless, detail).items():
                    parts[key].append(
                        copies(
                            part,
                            positions[at],
                            rotation=rotation[at],
                            scale=scale[at],
                            tint=tint[at],
                        )
                    )
    return {key: join(part) for key, part in parts.items() if part}
