"""A pair against the world that it shows: rays cast anew, from what its files say alone."""

from collections.abc import Callable, Iterator

import numpy as np

from synthdepth.dataset.pair import Pair

# Rays through pixels: most where the depth is within the range, some anywhere.
_IN_RANGE, _ANYWHERE = 48, 16
# Rays all around, to see how near the nearest surface is and whether the sky is anywhere.
_AROUND = 128
# A ray agrees with the depth within this share, or so many metres. Of those cast some may not: the
# rays are not the same to the last bit, and may pass on the other side of an edge.
_SHARE, _LEAST_M, _STRAY = 1e-3, 0.01, 3
_ROUNDING_M = 1e-3


def recast_faults(
    rng: np.random.Generator,
    pair: Pair,
    reach: Callable[[np.ndarray, np.ndarray], np.ndarray],
) -> Iterator[str]:
    """Where a pair's depth, intrinsics and pose contradict the world.

    Args:
        rng: which pixels are looked at.
        pair: as its files have it.
        reach: `Renderer.reach`: from a pose (4, 4) and directions (n, 3), how many lengths of its
            direction each ray gets, (n,).
    """
    (fx, _, cx), (_, fy, cy), _ = pair.meta["intrinsics"]
    v, u = _pixels(rng, pair)
    through = np.stack([(u - cx) / fx, (v - cy) / fy, np.ones(len(u))], axis=1)
    through /= np.linalg.norm(through, axis=1, keepdims=True)
    directions = np.concatenate([through @ pair.world_from_cam[:3, :3].T, _around()])
    length_m = np.asarray(reach(pair.world_from_cam, directions), np.float64)
    pixels_m, around_m = length_m[: len(u)], length_m[len(u) :]

    depth_m = np.minimum(pixels_m * through[:, 2], pair.meta["max_depth_m"])
    off_m = np.abs(depth_m - pair.depth_m[v, u])
    wrong = off_m > np.maximum(_SHARE * depth_m, _LEAST_M)
    if wrong.sum() > _STRAY:
        yield (
            f"depth.exr is not what rays find: {wrong.sum()} of {len(u)} differ, by "
            f"{np.median(off_m[wrong]):.2g} m"
        )
    nearest_m = float(around_m.min())
    if nearest_m < pair.meta["clearance_m"] - _ROUNDING_M:
        told = pair.meta["clearance_m"]
        yield f"a surface is {nearest_m:.2f} m away, clearance_m says {told:.2f} m"
    if np.isfinite(around_m[_around()[:, 2] > 0]).all():
        yield "the camera is inside something: no ray gets to the sky"


def _pixels(rng: np.random.Generator, pair: Pair) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of the pixels to look at, (n,) each."""
    within = np.flatnonzero(pair.depth_m < np.float32(pair.meta["max_depth_m"]))
    chosen = [rng.integers(0, pair.depth_m.size, _ANYWHERE)]
    if len(within):
        chosen.append(within[rng.integers(0, len(within), _IN_RANGE)])
    return np.unravel_index(np.concatenate(chosen), pair.depth_m.shape)


def _around() -> np.ndarray:
    """Directions evenly spread over the sphere, (n, 3): a Fibonacci lattice."""
    k = np.arange(_AROUND) + 0.5
    z, turn = 1 - 2 * k / _AROUND, np.pi * (1 + np.sqrt(5)) * k
    flat = np.sqrt(1 - z * z)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=1)
