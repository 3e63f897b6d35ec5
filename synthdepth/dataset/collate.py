"""Samples into a batch of torch tensors."""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from synthdepth.errors import DatasetError, SynthdepthError

if TYPE_CHECKING:
    import torch

    from synthdepth.dataset.sample import Sample

# (H, W, C) become (B, C, H, W), (H, W) become (B, 1, H, W), the others keep their shape.
_COLOURED = ("rgb", "prev", "flow", "normal", "input")
_FLAT = ("depth_m", "valid", "visible", "seg")
_MATRICES = ("intrinsics", "world_from_cam", "world_from_cam_prev")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Batch:
    """The samples of a batch, as `Sample` has them: same names, types and units, same None.

    Attributes:
        keys: B names.
        max_depth_m: (B,) float32 [m].
        intrinsics: (B, 3, 3) float64.
        rgb, prev: (B, 3, H, W) uint8.
        depth_m: (B, 1, H, W) float32 [m].
        valid, visible: (B, 1, H, W) bool.
        world_from_cam, world_from_cam_prev: (B, 4, 4) float64.
        flow: (B, 2, H, W) float32 [px].
        seg: (B, 1, H, W) uint8.
        normal: (B, 3, H, W) float32.
        input: (B, C, H, W).
        meta: B mappings.
    """

    keys: list[str]
    max_depth_m: "torch.Tensor"
    intrinsics: "torch.Tensor"
    rgb: "torch.Tensor | None" = None
    prev: "torch.Tensor | None" = None
    depth_m: "torch.Tensor | None" = None
    valid: "torch.Tensor | None" = None
    visible: "torch.Tensor | None" = None
    world_from_cam: "torch.Tensor | None" = None
    world_from_cam_prev: "torch.Tensor | None" = None
    flow: "torch.Tensor | None" = None
    seg: "torch.Tensor | None" = None
    normal: "torch.Tensor | None" = None
    input: "torch.Tensor | None" = None
    meta: list[Mapping] = dataclasses.field(default_factory=list)

    def __len__(self) -> int:
        return len(self.keys)

    def as_float(self, name: str = "rgb") -> "torch.Tensor":
        """The pictures `rgb`, `prev` or `input` as float32 from 0 to 1, where they lie."""
        return getattr(self, name).float() / 255

    def to(self, device: "torch.device | str", *, non_blocking: bool = False) -> "Batch":
        """The batch on another device."""
        return self._each(lambda tensor: tensor.to(device, non_blocking=non_blocking))

    def pin_memory(self) -> "Batch":
        """The batch in page-locked memory; `DataLoader(pin_memory=True)` calls this."""
        return self._each(lambda tensor: tensor.pin_memory())

    def _each(self, change: Callable) -> "Batch":
        values = {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}
        return Batch(
            **{
                name: value if value is None or isinstance(value, list) else change(value)
                for name, value in values.items()
            }
        )


def collate(samples: "Sequence[Sample]") -> Batch:
    """The batch of some samples; for `DataLoader(collate_fn=collate)`.

    Args:
        samples: at least one, of one size, all with the same fields.

    Raises:
        DatasetError: their sizes differ, or some have what others do not.
        SynthdepthError: torch is missing.
    """
    try:
        import torch
        from torch.utils.data import default_collate
    except ModuleNotFoundError:
        raise SynthdepthError(
            "batches need torch: install it with pip install 'synthdepth[train]'"
        ) from None
    if not samples:
        raise DatasetError("no samples to collate: allowed is one or more")
    known = {}
    for name in (*_COLOURED, *_FLAT, *_MATRICES):
        values = _values(name, samples)
        if values:
            # In a worker torch's own function stacks into the memory that the trainer reads.
            known[name] = default_collate([torch.from_numpy(_laid_out(name, v)) for v in values])
    return Batch(
        keys=[sample.key for sample in samples],
        max_depth_m=torch.tensor([sample.max_depth_m for sample in samples]),
        meta=[sample.meta for sample in samples],
        **known,
    )


def _values(name: str, samples: "Sequence[Sample]") -> list[np.ndarray]:
    """One field of all samples, of one shape; empty if none has it."""
    values = [getattr(sample, name) for sample in samples]
    lacking = [s.key for s, value in zip(samples, values, strict=True) if value is None]
    if len(lacking) == len(samples):
        return []
    if lacking:
        raise DatasetError(f"one batch: {name} is missing in {lacking[0]}, and others have it")
    shapes = {value.shape for value in values}
    if len(shapes) > 1:
        raise DatasetError(
            f"one batch: {name} has the shapes {', '.join(map(str, sorted(shapes)))}; "
            "allowed is one (Resize makes them equal)"
        )
    return values


def _laid_out(name: str, value: np.ndarray) -> np.ndarray:
    """One field of one sample as it is in a batch: channels first, one if there are none."""
    value = value[None] if name in _FLAT else value
    if name in _COLOURED and value.dtype == np.uint8:
        import cv2

        # Five times as fast as numpy's copy; it writes into `planes`.
        planes = np.empty((value.shape[2], *value.shape[:2]), np.uint8)
        cv2.split(value, list(planes))
        return planes
    value = value.transpose(2, 0, 1) if name in _COLOURED else value
    return np.require(value, requirements=["C", "W"])
