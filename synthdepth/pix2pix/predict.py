"""Depth in metres from a trained model: of samples, arrays, folders and videos."""

import dataclasses
import os
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
import torch

from synthdepth.camera import Intrinsics
from synthdepth.dataset import Resize
from synthdepth.dataset.exr import CONVENTION, encode_channels, encode_depth
from synthdepth.dataset.pair import encode_png
from synthdepth.dataset.preview import colour_depth
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.shard import PARTIAL, write_error
from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.checkpoint import load_generator
from synthdepth.pix2pix.distributed import find_device
from synthdepth.pix2pix.frames import frame_sample, open_frames
from synthdepth.pix2pix.inference import for_inference
from synthdepth.pix2pix.inputs import MakeInput


class Predictor:
    """A trained model that gives depth.

    Without the noise and with running statistics, so the same frame always has the same depth.

    Args:
        path: a model, a checkpoint, or the folder of a training.
        device: "cpu", "cuda" or "cuda:1"; by default a GPU if there is one.
        precision: "fp32", or "bf16", which is faster where the machine has it.
        compiled: compile the network first (`torch.compile`), half a minute for every number of
            frames that it is given at once; needs a C++ compiler.

    Attributes:
        config: how it was trained.
        device: where it computes.

    Raises:
        SynthdepthError: no such model, device or precision.
    """

    def __init__(
        self,
        path: Path | str,
        *,
        device: str | None = None,
        precision: str = "fp32",
        compiled: bool = False,
    ) -> None:
        if precision not in ("fp32", "bf16"):
            raise SynthdepthError(f"precision {precision!r}: allowed are fp32, bf16")
        self.device = find_device(device)
        generator, self.config = load_generator(path)
        dtype = torch.bfloat16 if precision == "bf16" else torch.float32
        self._generator = for_inference(generator, dtype=dtype).to(self.device)
        if compiled:
            if shutil.which(compiler := os.environ.get("CXX", "g++")) is None:
                raise SynthdepthError(f"compiled needs a C++ compiler: there is no {compiler}")
            # Frozen weights are laid out once as the kernels want them, not at every picture.
            self._generator = torch.compile(self._generator, options={"freezing": True})
        size = self.config.size
        self._resize = None if size is None else Resize(height=size[1], width=size[0])
        self._make_input = MakeInput(self.config.input)

    def depth_m(
        self, frames: Sequence[Sample] | np.ndarray, prev: np.ndarray | None = None
    ) -> np.ndarray:
        """Planar depth of some frames.

        Args:
            frames: samples with what the model's input is made of, or frames t, (B, H, W, 3) uint8
                RGB; all of one size.
            prev: with an array, frames t-1, likewise; not needed by a model of the input "rgb".

        Returns:
            (B, H, W) float32 [m], within (0, max_depth_m] of the model's coding: in the frames'
            size, or in the model's own where it was trained with a `size`.

        Raises:
            DatasetError: a frame lacks what the input is made of.
        """
        if isinstance(frames, np.ndarray):
            before = [None] * len(frames) if prev is None else prev
            frames = [frame_sample(*both) for both in zip(frames, before, strict=True)]
        inputs = np.stack([self.network_input(sample) for sample in frames])
        image = torch.from_numpy(inputs).to(self.device).permute(0, 3, 1, 2)
        with torch.inference_mode():
            code = self._generator(image)
        return self.config.coding.decode(code)[:, 0].cpu().numpy()

    def network_input(self, sample: Sample) -> np.ndarray:
        """What the network reads of a sample, (H, W, C) float32 in [-1, 1]."""
        return self._make_input(sample if self._resize is None else self._resize(sample)).input


@dataclasses.dataclass(frozen=True, kw_only=True)
class PredictReport:
    """What was predicted.

    Attributes:
        frames: how many have depth now.
        skipped: frames at the start that have none, as the input needs the frame before.
        wall_s: time it took, reading and writing included.
        network_s: of that in the network and what makes its input.
    """

    frames: int
    skipped: int
    wall_s: float
    network_s: float


def predict(
    model: Path | str | Predictor,
    source: Path | str,
    out: Path,
    *,
    split: str | None = None,
    fov_deg: float | None = None,
    batch_size: int = 8,
    device: str | None = None,
    precision: str = "fp32",
    compiled: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
) -> PredictReport:
    """Write depth for every frame of a source.

    Each frame gets `<name>.depth.exr`, float32 metres, and `<name>.depth.png`, the same in colour
    (near is red), both of the frame's size: a model with a size of its own gives each pixel the
    nearest of its values. Names are the pairs' keys, the pictures' names, or the video's name and
    the number of the frame from 0. The folder is there whole or not at all.

    Args:
        model: as `Predictor` has it, or one.
        source: a dataset folder, a folder of pictures, a picture or a video, see `open_frames`.
        out: the folder to make; may be there if it is empty.
        split: of a dataset: "train" or "test"; both without.
        fov_deg: horizontal field of view of pictures and videos, for the headers' intrinsics;
            without it they say none.
        batch_size: frames at once.
        device, precision, compiled: as `Predictor` has them.
        on_progress: called with (frames done, frames in all), where it is known how many.

    Raises:
        SynthdepthError: no such model or source, a source that lacks what the model needs, or an
            `out` that is not empty or cannot be written.
    """
    started, out = time.monotonic(), Path(out)
    if batch_size < 1:
        raise SynthdepthError(f"batch_size {batch_size}: allowed is a whole number from 1")
    if fov_deg is not None and not 0 < fov_deg < 180:
        raise SynthdepthError(f"fov_deg {fov_deg}: allowed is a number between 0 and 180")
    if not isinstance(model, Predictor):
        model = Predictor(model, device=device, precision=precision, compiled=compiled)
    frames = open_frames(source, model.config.input, split=split, fov_deg=fov_deg)
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise SynthdepthError(f"{out} is there already: allowed is a new or empty folder")
    partial = out.resolve().with_name(out.resolve().name + PARTIAL)
    done, network_s, max_depth_m = 0, 0.0, model.config.coding.max_depth_m
    try:
        shutil.rmtree(partial, ignore_errors=True)
        partial.mkdir(parents=True)
        for batch in _batches(frames.samples, batch_size):
            before = time.monotonic()
            depths_m = model.depth_m(batch)
            network_s += time.monotonic() - before
            for sample, depth_m in zip(batch, depths_m, strict=True):
                _write(partial, sample, depth_m, max_depth_m)
            done += len(batch)
            if on_progress and frames.count:
                on_progress(done, max(done, frames.count))
        if done == 0:
            raise SynthdepthError(f"{source} has no frame that depth could be predicted for")
        if out.exists():
            out.rmdir()
        partial.rename(out)
    except OSError as error:
        raise write_error(out, error) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return PredictReport(
        frames=done,
        skipped=frames.skipped,
        wall_s=time.monotonic() - started,
        network_s=network_s,
    )


def _batches(samples: Iterable[Sample], most: int) -> Iterator[list[Sample]]:
    """Lists of samples of one size that follow one another."""
    batch: list[Sample] = []
    for sample in samples:
        if batch and (len(batch) == most or batch[0].rgb.shape != sample.rgb.shape):
            yield batch
            batch = []
        batch.append(sample)
    if batch:
        yield batch


def _write(folder: Path, sample: Sample, depth_m: np.ndarray, max_depth_m: float) -> None:
    height, width = sample.rgb.shape[:2]
    if depth_m.shape != (height, width):
        depth_m = cv2.resize(depth_m, (width, height), interpolation=cv2.INTER_NEAREST_EXACT)
    exr = _exr(sample, depth_m, max_depth_m)
    (folder / f"{sample.key}.depth.exr").write_bytes(exr)
    png = encode_png(colour_depth(depth_m, max_depth_m))
    (folder / f"{sample.key}.depth.png").write_bytes(png)


def _exr(sample: Sample, depth_m: np.ndarray, max_depth_m: float) -> bytes:
    if np.isnan(sample.intrinsics).any():
        header = {"depthUnit": "metre", "depthConvention": CONVENTION, "maxDepth": max_depth_m}
        return encode_channels(header, {"Z": depth_m})
    (fx, _, cx), (_, fy, cy), _ = sample.intrinsics
    height, width = depth_m.shape
    camera = Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy)
    pose = np.eye(4) if sample.world_from_cam is None else sample.world_from_cam
    return encode_depth(depth_m, camera, pose, max_depth_m)
