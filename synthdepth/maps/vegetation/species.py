"""Kinds of trees: how each grows, and one tree drawn from its kind."""

import dataclasses

import numpy as np


@dataclasses.dataclass(frozen=True, kw_only=True)
class Species:
    """How a kind of tree grows; pairs are the bounds of a uniform draw.

    Attributes:
        habit: "puffs" (foliage in puffs), "whorls" (tiers of branches) or "fronds" (palms).
        height_m: to the top.
        spread: crown width over height.
        clear: height of the lowest foliage over height.
        girth: trunk diameter over height.
        profile: crown radius at heights 0, 1/4, 1/2, 3/4 and 1 of the crown, over the largest.
        stem: length of the trunk over height, before it is lost in the crown.
        limbs: main limbs; none where the trunk carries all branches.
        rise: how much higher than its root a branch ends, over its horizontal reach.
        arch: above 0 branches rise first and droop after, below 0 the reverse.
        puffs: of foliage; branches of whorls and fronds.
        flat: height of a puff over its width.
        hang_m: length of hanging shoots.
        clumps: of leaves, or twigs.
        clump_m: their length and width.
        bristle: how far clumps point out of their puff, 0 to 1.
        leaf_tints: linear reflectances, one of which is drawn.
        bark_tint: linear reflectance.
        peeling: white bark with dark scars.
        leafless: the clumps are twigs.
    """

    habit: str = "puffs"
    height_m: tuple[float, float]
    spread: tuple[float, float]
    clear: tuple[float, float]
    girth: float
    profile: tuple[float, float, float, float, float]
    stem: float
    limbs: int = 0
    rise: float
    arch: float = 0.0
    puffs: int
    flat: float = 0.75
    hang_m: float = 0.0
    clumps: int
    clump_m: tuple[float, float]
    bristle: float = 0.0
    leaf_tints: tuple[tuple[float, float, float], ...]
    bark_tint: tuple[float, float, float]
    peeling: bool = False
    leafless: bool = False


# Heights, spreads and clear stems of open-grown trees; colours are visible linear reflectances,
# raised by about a half for the light that real leaves let through.
SPECIES = {
    "oak": Species(
        height_m=(9, 14), spread=(0.85, 1.1), clear=(0.18, 0.26), girth=0.05,
        profile=(0.5, 0.95, 1.0, 0.8, 0.3), stem=0.6, limbs=8, rise=0.45, arch=-0.12, puffs=50,
        clumps=920, clump_m=(0.66, 0.56), bark_tint=(0.11, 0.09, 0.07),
        leaf_tints=((0.063, 0.098, 0.03), (0.057, 0.103, 0.034), (0.076, 0.101, 0.03)),
    ),
    "maple": Species(
        height_m=(9, 15), spread=(0.6, 0.78), clear=(0.2, 0.28), girth=0.036,
        profile=(0.55, 1.0, 0.95, 0.68, 0.12), stem=0.7, limbs=7, rise=1.1, arch=-0.1, puffs=46,
        clumps=840, clump_m=(0.62, 0.54), bark_tint=(0.14, 0.12, 0.1),
        leaf_tints=(
            (0.075, 0.115, 0.034), (0.069, 0.121, 0.04), (0.063, 0.103, 0.034),
            (0.076, 0.048, 0.039),
        ),
    ),
    "birch": Species(
        height_m=(9, 16), spread=(0.36, 0.48), clear=(0.2, 0.32), girth=0.02,
        profile=(0.75, 1.0, 0.8, 0.5, 0.1), stem=0.93, rise=0.9, arch=0.3, puffs=40, flat=0.8,
        hang_m=1.1, clumps=760, clump_m=(0.5, 0.34), bark_tint=(0.52, 0.5, 0.46), peeling=True,
        leaf_tints=((0.098, 0.144, 0.044), (0.109, 0.149, 0.046), (0.149, 0.149, 0.046)),
    ),
    "poplar": Species(
        height_m=(14, 22), spread=(0.16, 0.22), clear=(0.07, 0.12), girth=0.024,
        profile=(0.6, 0.95, 1.0, 0.8, 0.15), stem=0.95, rise=3.0, arch=-0.2, puffs=44, flat=1.8,
        clumps=760, clump_m=(0.62, 0.46), bristle=0.3, bark_tint=(0.14, 0.13, 0.11),
        leaf_tints=((0.071, 0.115, 0.039), (0.081, 0.115, 0.034)),
    ),
    "cypress": Species(
        height_m=(7, 14), spread=(0.14, 0.2), clear=(0.02, 0.05), girth=0.022,
        profile=(0.7, 1.0, 0.95, 0.7, 0.08), stem=0.96, rise=3.0, puffs=30, flat=2.2,
        clumps=600, clump_m=(0.62, 0.34), bristle=0.2, bark_tint=(0.11, 0.09, 0.075),
        leaf_tints=((0.039, 0.063, 0.028), (0.034, 0.06, 0.031)),
    ),
    "pine": Species(
        height_m=(12, 20), spread=(0.38, 0.52), clear=(0.45, 0.58), girth=0.027,
        profile=(0.6, 1.0, 0.95, 0.75, 0.35), stem=0.94, rise=0.12, arch=-0.1, puffs=22, flat=0.4,
        clumps=720, clump_m=(0.66, 0.3), bristle=0.8, bark_tint=(0.18, 0.1, 0.065),
        leaf_tints=((0.046, 0.076, 0.037), (0.053, 0.076, 0.034)),
    ),
    "spruce": Species(
        habit="whorls", height_m=(10, 20), spread=(0.34, 0.44), clear=(0.03, 0.09), girth=0.025,
        profile=(1.0, 0.8, 0.56, 0.29, 0.03), stem=1.0, rise=0.05, puffs=90,
        clumps=860, clump_m=(0.85, 0.52), bark_tint=(0.1, 0.075, 0.06),
        leaf_tints=((0.039, 0.064, 0.039), (0.034, 0.06, 0.034), (0.057, 0.086, 0.071)),
    ),
    "palm": Species(
        habit="fronds", height_m=(7, 14), spread=(0.5, 0.6), clear=(0.8, 0.86), girth=0.032,
        profile=(1.0, 1.0, 1.0, 1.0, 1.0), stem=0.9, rise=0.0, puffs=24,
        clumps=504, clump_m=(1.0, 0.22), bark_tint=(0.2, 0.17, 0.14),
        leaf_tints=((0.075, 0.109, 0.034), (0.067, 0.103, 0.039)),
    ),
    "willow": Species(
        height_m=(8, 13), spread=(0.85, 1.05), clear=(0.32, 0.4), girth=0.05,
        profile=(0.75, 1.0, 1.0, 0.8, 0.3), stem=0.55, limbs=6, rise=0.7, arch=0.2, puffs=44,
        flat=0.6, hang_m=3.4, clumps=760, clump_m=(0.82, 0.27), bark_tint=(0.13, 0.11, 0.085),
        leaf_tints=((0.098, 0.132, 0.046), (0.103, 0.136, 0.057)),
    ),
    "fruit": Species(
        height_m=(3.5, 5.5), spread=(0.85, 1.1), clear=(0.26, 0.34), girth=0.035,
        profile=(0.55, 0.95, 1.0, 0.8, 0.3), stem=0.5, limbs=5, rise=0.7, arch=-0.1, puffs=20,
        clumps=460, clump_m=(0.38, 0.31), bark_tint=(0.12, 0.095, 0.08),
        leaf_tints=(
            (0.081, 0.115, 0.039), (0.086, 0.115, 0.046), (0.081, 0.115, 0.039),
            (0.506, 0.368, 0.38),
        ),
    ),
    "young": Species(
        height_m=(4, 6.5), spread=(0.4, 0.55), clear=(0.34, 0.42), girth=0.016,
        profile=(0.6, 1.0, 0.95, 0.65, 0.15), stem=0.9, rise=1.5, arch=-0.1, puffs=18,
        clumps=360, clump_m=(0.33, 0.28), bark_tint=(0.16, 0.14, 0.12),
        leaf_tints=((0.086, 0.132, 0.041), (0.075, 0.121, 0.046), (0.081, 0.052, 0.044)),
    ),
    "bare": Species(
        height_m=(7, 13), spread=(0.65, 0.9), clear=(0.2, 0.3), girth=0.032,
        profile=(0.5, 0.9, 1.0, 0.8, 0.3), stem=0.65, limbs=7, rise=0.8, arch=-0.12, puffs=52,
        clumps=600, clump_m=(0.85, 0.03), leafless=True,
        bark_tint=(0.13, 0.115, 0.1), leaf_tints=((0.115, 0.098, 0.081),),
    ),
}  # fmt: skip


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tree:
    """One tree.

    Attributes:
        species: a key of `SPECIES`.
        seed: of the branching.
        height_m: to the top.
        crown_radius_m: largest.
        clear_m: height of the lowest foliage.
        trunk_radius_m: above the root flare.
        leaf_tint: linear reflectance.
        bark_tint: linear reflectance.
    """

    species: str
    seed: int
    height_m: float
    crown_radius_m: float
    clear_m: float
    trunk_radius_m: float
    leaf_tint: tuple[float, float, float]
    bark_tint: tuple[float, float, float]


def species_named(name: str) -> Species:
    """The species of that name; an unknown one lists the known."""
    if name not in SPECIES:
        raise KeyError(f"species {name!r} is not one of {sorted(SPECIES)}")
    return SPECIES[name]


def draw_tree(rng: np.random.Generator, species: str) -> Tree:
    """A tree of a species, of ordinary size, shape and colour."""
    kind = species_named(species)
    height = rng.uniform(*kind.height_m)
    leaf = np.array(kind.leaf_tints[rng.integers(len(kind.leaf_tints))])
    leaf *= rng.normal(1.0, 0.1) * np.clip(rng.normal(1.0, [0.1, 0.04, 0.12]), 0.75, 1.25)
    bark = np.array(kind.bark_tint) * rng.uniform(0.8, 1.2)
    return Tree(
        species=species,
        seed=int(rng.integers(2**53)),
        height_m=float(height),
        crown_radius_m=float(height * rng.uniform(*kind.spread) / 2),
        clear_m=float(height * rng.uniform(*kind.clear)),
        trunk_radius_m=float(height * kind.girth / 2 * rng.uniform(0.85, 1.2)),
        leaf_tint=tuple(float(c) for c in leaf),
        bark_tint=tuple(float(c) for c in bark),
    )
