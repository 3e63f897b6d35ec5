"""Depth edges against colour edges: where the depth jumps, the picture mostly changes too.

A depth edge is a jump between neighbours that stands alone in its row or column and is not lost in
the air. Around them the gradient of the picture, as a share of its surroundings', is averaged into
a profile across the edge, a block of the picture at a time, so that the blocks say how certain the
profile is. In a true pair it peaks at the edge; beside it if depth and picture are shifted; and it
is flat if they have nothing to do with each other.
"""

import cv2
import numpy as np

from synthdepth.dataset.gate_check import Check, mean_and_sigmas
from synthdepth.dataset.gate_warp import MIRRORED
from synthdepth.dataset.pair import Pair

# A jump of the depth by this factor is an edge (exp(0.2) = 1.22), unless the air hides all but
# exp(-2.5) of its contrast (Koschmieder: contrast falls with exp(-3.912 z / V)).
_JUMP_LOG, _HAZE_LOG, _KOSCHMIEDER = 0.2, 2.5, 3.912
# Trees at the end of the range are smaller than a pixel: an edge is nearer than half of it.
_RANGE_SHARE = 0.5
# How far the profile reaches to each side [px], and the blocks that it is averaged over.
_REACH, _BLOCK, _LEAST_EDGES = 4, 16, 2
# In foliage everything is an edge: at most this many of the 81 pixels around may be at a jump.
_CROWD = 24
# Grey levels added to the surroundings' gradient: what is smaller is noise.
_FLOOR = 1.0
# What is blurred away first: noise, and half of a pixel that the edge may lie off.
_NOISE_PX = 0.7
_LEAST_BLOCKS = 20

# Shifted: the profile has its peak at another pixel, its sides differ by this share of its height,
# and by that many standard errors.
SHIFT_SHARE, SHIFT_SIGMAS = 0.5, 6.5
# Of many pairs together: the share alone, in the mean. Objects have the ground below and the sky
# above, so that right pairs lean upwards by 0.05, and by 0.26 in the worst of 30 shards.
SHIFT_SHARE_OF_MANY = {"to the left": 0.3, "to the right": 0.3, "up": 0.45, "down": 0.45}
# Unrelated: the profile's height is not that many standard errors above 0, and even 4 of them up
# it is below this.
HEIGHT_SIGMAS, LEAST_HEIGHT = 3.0, 0.14
# Mirrored: the mirrored depth's profile is higher by that many standard errors.
MIRROR_SIGMAS = 5.0


def edge_checks(pair: Pair) -> list[Check]:
    """What the depth's edges say of the depth's place on the picture."""
    grey = cv2.cvtColor(pair.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32)
    least = _FLOOR + _noise(grey)
    grey = cv2.GaussianBlur(grey, (0, 0), _NOISE_PX)
    gradients = [np.abs(np.diff(side, axis=1)) for side in (grey, grey.T)]
    around = [cv2.blur(gradient, (9, 9)) for gradient in gradients]
    contrast = [g / (a + _FLOOR) for g, a in zip(gradients, around, strict=True)]
    depth = np.log(pair.depth_m)
    seen_m = _HAZE_LOG * pair.meta["visibility_m"] / _KOSCHMIEDER
    right, down = _edges(depth, np.log(min(seen_m, _RANGE_SHARE * pair.meta["max_depth_m"])))

    def profiles(flipped: tuple[int, ...] = ()) -> list[np.ndarray]:
        edges = np.flip(right, flipped), np.flip(down, flipped).T
        return [_profiles(c, e) for c, e in zip(contrast, edges, strict=True)]

    ours = profiles()
    height = _height(ours)
    # Where the picture is no more than its noise, nothing can change in it.
    lit = [right & (around[0] > least), down.T & (around[1] > least)]
    checks = [
        *_shifts(("to the left", "to the right"), ours[0]),
        *_shifts(("up", "down"), ours[1]),
        _related(_height([_profiles(c, e) for c, e in zip(contrast, lit, strict=True)])),
    ]
    for name, axes in MIRRORED.items():
        checks.append(_mirror(name, height, _height(profiles(axes))))
    return checks


def _noise(grey: np.ndarray) -> float:
    """Standard deviation of the noise of a picture (H, W), from differences along diagonals.

    After Donoho and Johnstone, "Ideal spatial adaptation by wavelet shrinkage" (1994): the finest
    diagonal details of a picture are noise in the median.
    """
    detail = (grey[:-1, :-1] - grey[1:, :-1] - grey[:-1, 1:] + grey[1:, 1:]) / 2
    return float(np.median(np.abs(detail))) / 0.6745


def _edges(depth: np.ndarray, within: float) -> list[np.ndarray]:
    """Where a log depth (H, W) jumps to the right, (H, W-1), and downwards, (H-1, W); bool."""
    right, down = (np.abs(np.diff(depth, axis=axis)) > _JUMP_LOG for axis in (1, 0))
    either = np.zeros(depth.shape, np.float32)
    either[:, 1:] += right
    either[1:] += down
    side = 2 * _REACH + 1
    alone = cv2.blur(np.minimum(either, 1), (side, side)) * side**2 <= _CROWD
    right &= alone[:, 1:] & (np.minimum(depth[:, 1:], depth[:, :-1]) < within)
    down &= alone[1:] & (np.minimum(depth[1:], depth[:-1]) < within)
    return [_single(right), _single(down.T).T]


def _single(jump: np.ndarray) -> np.ndarray:
    """Those of the jumps (H, W) that have no other within reach in their row, nor the border."""
    side = 2 * _REACH + 1
    near = cv2.blur(jump.astype(np.float32), (side, 1), borderType=cv2.BORDER_CONSTANT) * side
    jump = jump & (near < 1.5)
    jump[:, :_REACH] = jump[:, -_REACH:] = False
    return jump


def _profiles(contrast: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Mean profiles (blocks, 2 reach + 1) of a contrast (H, W) across edges (H, W)."""
    y, x = np.nonzero(edges)
    block = y // _BLOCK * contrast.shape[1] + x // _BLOCK
    order = np.argsort(block, kind="stable")
    _, first, count = np.unique(block[order], return_index=True, return_counts=True)
    across = contrast[y[order, None], x[order, None] + np.arange(-_REACH, _REACH + 1)]
    total = np.add.reduceat(across, first, axis=0) if len(first) else across
    return (total / count[:, None])[count >= _LEAST_EDGES]


def _height(profiles: list[np.ndarray]) -> np.ndarray:
    """How far each profile's middle three pixels stand above its outer four."""
    every = np.concatenate(profiles)
    outer = every[:, [0, 1, -2, -1]].mean(axis=1)
    return every[:, _REACH - 1 : _REACH + 2].mean(axis=1) - outer


def _shifts(ways: tuple[str, str], profiles: np.ndarray) -> list[Check]:
    """Whether depth is shifted against the picture, to the first or to the second side."""
    if len(profiles) < _LEAST_BLOCKS:
        return [Check(subject="edges", name=f"shifted {way}") for way in ways]
    # Depth that is too far to the left has the picture's edges on the right of its own.
    sides, sigmas = mean_and_sigmas(profiles[:, _REACH + 1] - profiles[:, _REACH - 1])
    mean = profiles.mean(axis=0)
    share = float(np.clip(sides / max(np.ptp(mean), 1e-6), -1, 1))
    beside = int(np.argmax(mean[2:-2])) != _REACH - 2
    checks = []
    for way, sign in zip(ways, (1, -1), strict=True):
        bad = beside and sign * share > SHIFT_SHARE and sign * sigmas > SHIFT_SIGMAS
        told = f"the depth's edges lie beside the picture's: it is shifted {way}"
        checks.append(
            Check(
                subject="edges",
                name=f"shifted {way}",
                effect=sign * share,
                sigmas=sign * sigmas,
                fault=told if bad else None,
                limit=SHIFT_SHARE_OF_MANY[way],
                told=told,
            )
        )
    return checks


def _related(height: np.ndarray) -> Check:
    if len(height) < _LEAST_BLOCKS:
        return Check(subject="edges", name="height")
    mean, sigmas = mean_and_sigmas(height)
    effect = LEAST_HEIGHT - mean * (1 + 4 / sigmas if sigmas else 1)
    told = "where the depth jumps the picture does not change: they do not belong together"
    fault = told if effect > 0 and sigmas < HEIGHT_SIGMAS else None
    return Check(subject="edges", name="height", effect=effect, sigmas=-sigmas, fault=fault)


def _mirror(name: str, ours: np.ndarray, theirs: np.ndarray) -> Check:
    if min(len(ours), len(theirs)) < _LEAST_BLOCKS:
        return Check(subject="edges", name=name)
    error = np.hypot(*(np.std(side, ddof=1) / np.sqrt(len(side)) for side in (ours, theirs)))
    effect = float(theirs.mean() - ours.mean())
    sigmas = effect / max(float(error), 1e-6)
    told = f"the picture's edges say that the depth is mirrored ({name})"
    fault = told if sigmas > MIRROR_SIGMAS else None
    return Check(subject="edges", name=name, effect=effect, sigmas=sigmas, fault=fault)
