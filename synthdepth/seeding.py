"""Named random lanes: every draw of the project comes from a generator made here.

A lane is a `numpy.random.Generator` keyed by a seed and a path of names and numbers, so that a
change to one concern (trees) never moves another (the camera), and item `i` never depends on how
many items were drawn before it. No default generators, no clock.
"""

import zlib

import numpy as np


def _sequence(seed: int, path: tuple[str | int, ...]) -> np.random.SeedSequence:
    # crc32, not hash(): Python salts hash() per process.
    words = [zlib.crc32(p.encode()) if isinstance(p, str) else int(p) for p in path]
    return np.random.SeedSequence([int(seed), *words])


def lane(seed: int, *path: str | int) -> np.random.Generator:
    """The random generator of one concern, e.g. `lane(scene_seed, "trees", 12)`."""
    return np.random.default_rng(_sequence(seed, path))


def derive_seed(seed: int, *path: str | int) -> int:
    """A child seed below 2**53, so that it survives JSON readers that use doubles."""
    return int(_sequence(seed, path).generate_state(1, np.uint64)[0] >> np.uint64(11))
