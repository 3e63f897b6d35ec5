"""Transforms of samples that keep pictures, ground truth, cameras and poses in agreement."""

import contextlib
import dataclasses
from collections.abc import Callable, Iterable
from typing import Any

import cv2
import numpy as np

from synthdepth.dataset.sample import Sample
from synthdepth.errors import DatasetError
from synthdepth.flow import PX_AT_WHITE, embed, estimate_flow
from synthdepth.seeding import lane

_PICTURES = ("rgb", "prev")
_EXACT = ("depth_m", "valid", "visible", "seg", "normal", "flow")


class SharedEpoch:
    """The number of the pass, which DataLoader workers see even if they were started before.

    With torch it lies in shared memory, forked and spawned workers alike; without, there are none.
    """

    def __init__(self):
        self._value = np.zeros(1, np.int64)
        with contextlib.suppress(ModuleNotFoundError):
            import torch

            self._value = torch.zeros(1, dtype=torch.int64).share_memory_()

    def get(self) -> int:
        """The number."""
        return int(self._value[0])

    def set(self, epoch: int) -> None:
        """Change it for everybody."""
        self._value[0] = int(epoch)

    def __setstate__(self, state: dict) -> None:
        self.__dict__ |= state
        if not isinstance(self._value, np.ndarray):
            self._value.share_memory_()


def several(transform: Callable | Iterable[Callable] | None) -> tuple[Callable, ...]:
    """No transform, one, or several, as a tuple."""
    if transform is None:
        return ()
    return (transform,) if callable(transform) else tuple(transform)


def transformed(transforms: Iterable[Callable], sample: Sample) -> Sample:
    """A sample after one transform after another."""
    for transform in transforms:
        sample = transform(sample)
    return sample


def set_epoch_of(transforms: Iterable[Callable], epoch: int) -> None:
    """Tell those transforms that draw something which pass comes next."""
    for transform in transforms:
        if hasattr(transform, "set_epoch"):
            transform.set_epoch(epoch)


@dataclasses.dataclass(frozen=True, kw_only=True)
class EmbedFlow:
    """Sets `input` to frame t with its optical flow embedded, equation (18) of the paper.

    Comes after `Resize` and `RandomFlip`, which refuse a sample that has an input.

    Attributes:
        interval: every how many pixels flow is shown.
        method: a name in `flow.METHODS` or a configured method; "truth" is the sample's own flow.
        scale, px_at_white: see `flow.embed`.
    """

    interval: int = 5
    method: Any = "farneback"
    scale: str = "fixed"
    px_at_white: float = PX_AT_WHITE

    def __call__(self, sample: Sample) -> Sample:
        """The sample with its input, (H, W, 3) uint8; DatasetError where frame t-1 is missing."""
        needed = ("rgb", "flow") if self.method == "truth" else ("rgb", "prev")
        for name in needed:
            if getattr(sample, name) is None:
                raise DatasetError(f"EmbedFlow needs the field {name}, and {sample.key} has none")
        flow = sample.flow
        if self.method != "truth":
            flow = estimate_flow(sample.prev, sample.rgb, self.method)
        embedded = embed(
            sample.rgb, flow, self.interval, scale=self.scale, px_at_white=self.px_at_white
        )
        return dataclasses.replace(sample, input=embedded)


@dataclasses.dataclass(frozen=True)
class Resize:
    """Changes the size of all images of a sample.

    Pictures are averaged over the area when they shrink, else interpolated. Ground truth takes the
    nearest pixel, whose value was measured, never a blend across an edge; flow becomes as many of
    the new pixels. The intrinsics follow: a pixel's centre u goes to (u + 0.5) s - 0.5. `meta`
    stays what the source says.

    Attributes:
        height: of the result [px].
        width: of the result [px].
    """

    height: int
    width: int

    def __post_init__(self):
        for name in ("height", "width"):
            value = getattr(self, name)
            if not isinstance(value, int) or value < 1:
                raise DatasetError(f"Resize {name} = {value!r}: allowed is a whole number from 1")

    def __call__(self, sample: Sample) -> Sample:
        """The sample in its new size; DatasetError where it has an input already."""
        height, width = _size(sample, "Resize")
        if (height, width) == (self.height, self.width):
            return sample
        shrinks = self.height <= height and self.width <= width
        kind = cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR
        # The nearest centre; OpenCV's INTER_NEAREST would shift by half a pixel.
        v = ((np.arange(self.height) + 0.5) * height / self.height).astype(int)
        u = ((np.arange(self.width) + 0.5) * width / self.width).astype(int)
        changed = _each(
            sample,
            _PICTURES,
            lambda image: cv2.resize(image, (self.width, self.height), None, 0, 0, kind),
        )
        changed |= _each(sample, _EXACT, lambda image: image[v[:, None], u])
        scale = np.array([self.width / width, self.height / height])
        if "flow" in changed:
            changed["flow"] = changed["flow"] * scale.astype(np.float32)
        intrinsics = sample.intrinsics.copy()
        intrinsics[:2, 2] += 0.5
        intrinsics[:2] *= scale[:, None]
        intrinsics[:2, 2] -= 0.5
        return dataclasses.replace(sample, intrinsics=intrinsics, **changed)


class RandomFlip:
    """Mirrors a sample left to right, as if the world were mirrored in its x axis.

    A mirrored camera is none, so the world is mirrored with it: the poses become those of the same
    flight through the world whose x is negated. They are rotations still, and depth, flow, normals
    and poses agree as before. `meta` stays what the source says.

    Whether a pair is mirrored depends on the seed, its key and the epoch alone.

    Args:
        share: of the pairs, 0 to 1.
        seed: of the draw.

    Raises:
        DatasetError: the share is none.
    """

    def __init__(self, share: float = 0.5, *, seed: int = 0):
        if not 0 <= share <= 1:
            raise DatasetError(f"RandomFlip share = {share!r}: allowed is a number from 0 to 1")
        self.share, self.seed, self._epoch = share, seed, SharedEpoch()

    def set_epoch(self, epoch: int) -> None:
        """Say which pass comes next; the datasets' own `set_epoch` calls this."""
        self._epoch.set(epoch)

    def __call__(self, sample: Sample) -> Sample:
        """The sample or its mirror image; DatasetError where it has an input already."""
        _size(sample, "RandomFlip")
        rng = lane(self.seed, "flip", sample.key, self._epoch.get())
        return flipped(sample) if rng.random() < self.share else sample


def flipped(sample: Sample) -> Sample:
    """The mirror image of a sample, see `RandomFlip`."""
    _, width = _size(sample, "flipped")
    changed = _each(sample, (*_PICTURES, *_EXACT), lambda image: image[:, ::-1])
    for name in ("flow", "normal"):
        if name in changed:
            changed[name] = changed[name] * np.float32([-1] + [1] * (changed[name].shape[2] - 1))
    changed = {name: np.ascontiguousarray(image) for name, image in changed.items()}
    mirror = np.diag([-1.0, 1, 1, 1])
    for name in ("world_from_cam", "world_from_cam_prev"):
        if getattr(sample, name) is not None:
            changed[name] = mirror @ getattr(sample, name) @ mirror
    # u becomes (width - 1) - u; a skew would change its sign.
    intrinsics = sample.intrinsics.copy()
    intrinsics[0, 1] *= -1
    intrinsics[0, 2] = width - 1 - intrinsics[0, 2]
    return dataclasses.replace(sample, intrinsics=intrinsics, **changed)


def _each(sample: Sample, names: Iterable[str], change: Callable) -> dict[str, np.ndarray]:
    """Those of the named images that a sample has, changed."""
    images = {name: getattr(sample, name) for name in names}
    return {name: change(image) for name, image in images.items() if image is not None}


def _size(sample: Sample, who: str) -> tuple[int, int]:
    """(H, W) of a sample's images."""
    if sample.input is not None:
        raise DatasetError(f"{who} comes before the transform that makes the input, not after")
    for name in (*_PICTURES, *_EXACT):
        if getattr(sample, name) is not None:
            return getattr(sample, name).shape[:2]
    raise DatasetError(f"{who} needs an image, and {sample.key} has none")
