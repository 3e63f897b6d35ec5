"""Pictures against depth and poses: frame t-1, warped, must look like frame t.

The test compares hypotheses. Frame t-1 is warped onto frame t by what the pair says, and by what it
would say if it had one of the usual faults (depth too small or too large, ray length for planar
depth, a mirrored image, poses exchanged, frames that do not move). For each block of the picture
the two residuals are compared; where a fault explains the pictures better than the pair itself, and
the blocks agree on it far beyond chance, the pair has that fault. Where there is no texture, no
light, no motion or only fog, all hypotheses explain the pictures equally, and there is no verdict.

One more rule needs no rival: where a block has texture, the warped block must correlate with it.

Pictures are compared in a band of spatial frequencies, so that vignetting, glare and noise, which
do not move with the world, count little.
"""

from collections.abc import Iterator

import cv2
import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.dataset.gate_check import Check, mean_and_sigmas
from synthdepth.dataset.pair import Pair

# At most this many pixels are looked at, on an even grid: more tell nothing new.
_GRID_PIXELS = 65_536
# The band: standard deviations of the Gaussians [px] between which it lies.
_FINE_PX, _COARSE_PX = 1.0, 6.0
# Side of a block [grid pixels], and how many blocks a verdict needs.
_BLOCK, _LEAST_BLOCKS = 8, 24
# Grey levels that are added to both residuals of a block, as what is smaller counts as noise; and
# that a block's picture must have in the mean.
_FLOOR, _LEAST_TEXTURE = 1.0, 1.5

# A rival explains the pictures better if its advantage, a share of the residual, is larger than the
# first and that many standard errors, over the blocks of a pair.
RIVAL_EFFECT, RIVAL_SIGMAS = 0.005, 8.0
# Of many pairs together, the effect alone, in the mean.
RIVAL_EFFECT_OF_MANY = 0.002
# Where windows of a side of so many pixels have a variance in the band above the first, in grey
# levels squared, they are textured. If that is a share of the picture, and their median correlation
# is below the second, the frames do not show the same place.
TEXTURE, LEAST_CORRELATION = 16.0, 0.2
_WINDOW, _LEAST_TEXTURED = 15, 0.05

# What a depth with a wrong scale is multiplied by to be right.
_SCALES = {"1.5": 1.5, "1.1": 1.1, "1/1.1": 1 / 1.1, "1/1.5": 1 / 1.5}


MIRRORED = {"left-right": (1,), "upside down": (0,), "turned": (0, 1)}


class Warp:
    """Where the pixels of frame t were at t-1, on a grid, by any depth.

    Args:
        camera: of both frames.
        prev_from_cam: (4, 4), from the axes of frame t to those of t-1.
        step: every how many pixels the grid has one.
    """

    def __init__(self, camera: Intrinsics, prev_from_cam: np.ndarray, step: int = 1):
        self._last = np.float32(camera.width - 1), np.float32(camera.height - 1)
        # A place is seen at K (R ray + t / depth), and a ray is linear in x and y.
        x = ((np.arange(camera.width) - camera.cx) / camera.fx)[::step]
        y = ((np.arange(camera.height) - camera.cy) / camera.fy)[::step, None]
        turn = camera.matrix @ prev_from_cam[:3, :3]
        self._ray = [(a * x + (b * y + c)).astype(np.float32) for a, b, c in turn]
        self._move = (camera.matrix @ prev_from_cam[:3, 3]).astype(np.float32)

    def __call__(self, inverse_depth: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pixel coordinates x, y (h, w) float32 in frame t-1, and whether they are in the picture.

        Args:
            inverse_depth: (h, w) float32 [1/m] on the grid; 0 is infinitely far.
        """
        x, y, z = (r + inverse_depth * m for r, m in zip(self._ray, self._move, strict=True))
        ahead = z > 1e-3
        np.copyto(z, 1, where=~ahead)
        x /= z
        y /= z
        inside = (x >= 0) & (y >= 0) & (x <= self._last[0]) & (y <= self._last[1])
        return x, y, ahead & inside


def warp_checks(pair: Pair) -> list[Check]:
    """What the pictures of a pair say of its depth and poses."""
    step = int(np.ceil(np.sqrt(pair.depth_m.size / _GRID_PIXELS)))
    now, before = np.ascontiguousarray(_band(pair.rgb)[::step, ::step]), _band(pair.prev)
    inverse = _inverse(pair.depth_m[::step, ::step], pair.meta["max_depth_m"])
    warp = _warp(pair, step)
    x, y, inside = warp(inverse)
    seen = cv2.remap(before, x, y, cv2.INTER_LINEAR)
    residual = np.abs(now - seen)
    checks = [_likeness(now, seen, inside)]
    # JPEG's blocks and vignetting stand still in an empty sky: what is as faint is no evidence.
    texture, _ = _block_means(np.abs(now), inside)
    for name, fault, rival_warp, rival_inverse in _rivals(pair, step, warp, inverse):
        x, y, rival_inside = rival_warp(rival_inverse)
        rival = np.abs(now - cv2.remap(before, x, y, cv2.INTER_LINEAR))
        use = inside & rival_inside
        checks.append(_rivalry(name, fault, residual, rival, use, texture > _LEAST_TEXTURE))
    return checks


def moved_px(pair: Pair) -> float:
    """What a tenth of the picture moved by at least, as depth and poses have it [px]."""
    x, y, _ = _warp(pair, 1)(_inverse(pair.depth_m, pair.meta["max_depth_m"]))
    v, u = np.mgrid[: pair.camera.height, : pair.camera.width]
    return float(np.quantile(np.hypot(x - u, y - v), 0.9))


def _warp(pair: Pair, step: int) -> Warp:
    motion = np.linalg.inv(pair.world_from_cam_prev) @ pair.world_from_cam
    return Warp(pair.camera, motion, step)


def _inverse(depth_m: np.ndarray, max_depth_m: float) -> np.ndarray:
    """Inverse depth float32 [1/m]; what saturates is at least that far, and counts as endless."""
    near = depth_m < np.float32(max_depth_m)
    # A depth of 0 is the contract's fault to find, not this division's.
    return np.where(near, 1 / np.maximum(depth_m, np.float32(1e-3)), 0).astype(np.float32)


def _band(image: np.ndarray) -> np.ndarray:
    grey = cv2.cvtColor(image, cv2.COLOR_RGB2GRAY).astype(np.float32)
    return cv2.GaussianBlur(grey, (0, 0), _FINE_PX) - cv2.GaussianBlur(grey, (0, 0), _COARSE_PX)


def _rivals(
    pair: Pair, step: int, warp: Warp, inverse: np.ndarray
) -> Iterator[tuple[str, str, Warp, np.ndarray]]:
    """Name, fault, warp and inverse depth of every rival; each is what undoes the fault."""
    for name, scale in _SCALES.items():
        told = f"the pictures say that the depth is too {'small' if scale > 1 else 'large'}"
        yield f"scale {name}", told, warp, inverse / scale
    length = np.linalg.norm(pair.camera.rays()[::step, ::step], axis=-1).astype(np.float32)
    told = "the pictures say that the depth is the length of the ray, not planar"
    yield "ray length", told, warp, inverse * length
    told = "the pictures say that the depth is planar divided by the ray's length"
    yield "twice planar", told, warp, inverse / length
    for name, axes in MIRRORED.items():
        told = f"the pictures say that the depth is mirrored ({name})"
        yield f"mirrored {name}", told, warp, np.ascontiguousarray(np.flip(inverse, axes))
    told = "the pictures say that the camera stood still, the poses that it moved"
    yield "still", told, Warp(pair.camera, np.eye(4), step), inverse
    told = "the pictures say that the frames or the poses are exchanged"
    back = np.linalg.inv(pair.world_from_cam) @ pair.world_from_cam_prev
    yield "exchanged", told, Warp(pair.camera, back, step), inverse


def _rivalry(
    name: str,
    fault: str,
    residual: np.ndarray,
    rival: np.ndarray,
    use: np.ndarray,
    textured: np.ndarray,
) -> Check:
    ours, share = _block_means(residual, use)
    theirs, _ = _block_means(rival, use)
    advantage = ((ours - theirs) / (ours + theirs + _FLOOR))[textured & (share > 0.5)]
    if len(advantage) < _LEAST_BLOCKS:
        return Check(subject="warp", name=name)
    effect, sigmas = mean_and_sigmas(advantage)
    bad = effect > RIVAL_EFFECT and sigmas > RIVAL_SIGMAS
    return Check(
        subject="warp",
        name=name,
        effect=effect,
        sigmas=sigmas,
        fault=fault if bad else None,
        limit=RIVAL_EFFECT_OF_MANY,
        told=fault,
    )


def _block_means(values: np.ndarray, use: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means over the pixels in use of every block, and their share."""
    height, width = (size - size % _BLOCK for size in values.shape)
    size = width // _BLOCK, height // _BLOCK
    share = use[:height, :width].astype(np.float32)
    total = cv2.resize(values[:height, :width] * share, size, interpolation=cv2.INTER_AREA)
    share = cv2.resize(share, size, interpolation=cv2.INTER_AREA)
    return total / np.maximum(share, 1e-6), share


def _likeness(now: np.ndarray, seen: np.ndarray, inside: np.ndarray) -> Check:
    """Local correlation of a frame and the warped one, where the frame has texture."""
    name, size = "likeness", (_WINDOW, _WINDOW)
    weight = inside.astype(np.float32)
    share = cv2.blur(weight, size)
    over = np.maximum(share, 1e-6)
    a, b = now * weight, seen * weight
    mean_a, mean_b = cv2.blur(a, size) / over, cv2.blur(b, size) / over
    var_a = cv2.blur(a * a, size) / over - mean_a**2
    var_b = cv2.blur(b * b, size) / over - mean_b**2
    both = cv2.blur(a * b, size) / over - mean_a * mean_b
    textured = (var_a > TEXTURE) & (share > 0.7)
    if textured.mean() < _LEAST_TEXTURED:
        return Check(subject="warp", name=name)
    correlation = both / np.sqrt(np.maximum(var_a, 1e-3) * np.maximum(var_b, 1e-3))
    median = float(np.median(correlation[textured]))
    told = f"frame t-1, warped by depth and poses, is not frame t (correlation {median:.2f})"
    bad = median < LEAST_CORRELATION
    effect = LEAST_CORRELATION - median
    return Check(subject="warp", name=name, effect=effect, fault=told if bad else None)
