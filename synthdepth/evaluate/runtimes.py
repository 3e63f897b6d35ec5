"""Ways to run a network here, each measured alone.

Each is measured in a process of its own: nothing is warm from another, and its peak memory is its
own.
"""

import dataclasses
import logging
import multiprocessing
import resource
import statistics
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

import cv2
import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.dataset.sample import Sample
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.sources import ModelSource, OnnxSource, Source
from synthdepth.seeding import lane

TORCH, ONNX = "PyTorch", "ONNX Runtime"
# Runtime and precision of each way.
WAYS = (
    (TORCH, "fp32"),
    (TORCH, "bf16"),
    (ONNX, "fp32"),
    (ONNX, "int8 dynamic"),
    (ONNX, "int8 static"),
)
# As fast as PyTorch gets, but it takes a minute to make ready.
COMPILED = (TORCH, "bf16 compiled")
_WARM_UP = 3
_CALIBRATION_PICTURES = 4
# How far the second frame is moved [px].
_MOVED_PX = 3


@dataclasses.dataclass(frozen=True, kw_only=True)
class Timing:
    """One way to run a network.

    Attributes:
        runtime, precision: the way, of `WAYS`, or `COMPILED`.
        without_flow_s: median seconds a picture from frame to metres, of the network given RGB.
        with_flow_s: the same from two frames, flow and what is made of it included.
        flow_s: of that before the network: flow and what is made of it.
        peak_bytes: of the process with both networks, or of the GPU.
        note: why it does not work here.
    """

    runtime: str
    precision: str
    without_flow_s: float | None = None
    with_flow_s: float | None = None
    flow_s: float | None = None
    peak_bytes: int | None = None
    note: str = ""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Networks:
    """The two networks that are measured.

    Attributes:
        rgb, flow: models as files: given the frame alone, and flow.
        width, height: of the pictures [px].
        parameters: of the one with flow.
    """

    rgb: Path
    flow: Path
    width: int
    height: int
    parameters: int


@dataclasses.dataclass(frozen=True, kw_only=True)
class Job:
    """What to measure.

    Attributes:
        way: of `WAYS`, or `COMPILED`.
        networks: both.
        folder: for more files.
        runs: that are timed.
        threads: to use.
        device: of PyTorch.
    """

    way: tuple[str, str]
    networks: Networks
    folder: Path
    runs: int
    threads: int
    device: str | None


def make_networks(
    model: Path | str | None, size: str | None, folder: Path, flow: str = "farneback"
) -> Networks:
    """Files of the network with flow and of its twin without; as given, or drawn.

    A network that is drawn, or twin of one that sees no flow, gets its flow by the method `flow`.
    """
    try:
        from synthdepth.pix2pix.checkpoint import load_generator, save_model
        from synthdepth.pix2pix.config import TrainConfig, parse_size
        from synthdepth.pix2pix.generator import UNetGenerator
    except ModuleNotFoundError as error:
        raise SynthdepthError(
            f"bench needs {error.name}: install it with pip install 'synthdepth[train]'"
        ) from None
    config = TrainConfig() if model is None else load_generator(model)[1]
    width, height = parse_size(size) if size else config.size or (256, 256)
    table = config.as_table() | {"size": None}
    default = TrainConfig().as_table()["input"] | {"flow": flow}
    paths, parameters = {}, 0
    for kind in ("rgb", "flow"):
        same = model is not None and (kind == "rgb") == (config.input.kind == "rgb")
        given = table["input"] if same else default if kind == "flow" else {"kind": "rgb"}
        # Channels follow from the input.
        shape = {k: v for k, v in table["generator"].items() if not k.endswith("_channels")}
        whole = TrainConfig.from_table(
            {"input": given, "generator": shape, "coding": table["coding"]}, "bench"
        )
        network = UNetGenerator(whole.generator).eval()
        if same:
            network = load_generator(model)[0]
        paths[kind] = folder / f"{kind}.safetensors"
        save_model(paths[kind], network, {"config": whole.as_table()})
        parameters = sum(weights.numel() for weights in network.parameters())
    return Networks(**paths, width=width, height=height, parameters=parameters)


def timed(job: Job) -> Timing:
    """A way's figures; it is made ready in one fresh process and measured in another."""
    runtime, precision = job.way
    # Whatever a runtime cannot do here is worth a line, not an end to the others.
    try:
        files = (job.networks.rgb, job.networks.flow)
        if runtime == ONNX:
            files = _alone(_onnx_files, job)
        figures = _alone(_measured, job, files)
    except BrokenProcessPool:
        note = "its process died, perhaps for want of memory"
        return Timing(runtime=runtime, precision=precision, note=note)
    except Exception as error:
        text = str(error).strip().splitlines()
        note = f"does not work here: {text[0] if text else type(error).__name__}"
        return Timing(runtime=runtime, precision=precision, note=note)
    return Timing(runtime=runtime, precision=precision, **figures)


def _alone(work: Callable, *given):
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        return pool.submit(work, *given).result()


def _measured(job: Job, files: tuple[Path, Path]) -> dict:
    """Fields of `Timing`."""
    runtime, precision = job.way
    cv2.setNumThreads(job.threads)
    pair = _pair(job.networks.width, job.networks.height)
    sources: list[Source] = [
        ModelSource(
            str(path),
            path.stem,
            device=job.device,
            precision=precision.split()[0],
            compiled=job.way == COMPILED,
        )
        if runtime == TORCH
        else OnnxSource(str(path), path.stem)
        for path in files
    ]
    for source in sources:
        source.start(job.threads)
    without, with_flow = sources
    return {
        "without_flow_s": _median_s(job.runs, lambda: without.depth_m([pair])),
        "with_flow_s": _median_s(job.runs, lambda: with_flow.depth_m([pair])),
        "flow_s": _median_s(job.runs, lambda: with_flow.picture(pair)),
        "peak_bytes": _peak_bytes(runtime),
    }


def _onnx_files(job: Job) -> tuple[Path, ...]:
    """Both networks as ONNX, in the precision of the way."""
    from synthdepth.pix2pix.onnx import export_onnx

    made = []
    for path in (job.networks.rgb, job.networks.flow):
        plain = path.with_suffix(".onnx")
        if not plain.exists():
            export_onnx(path, plain, size=(job.networks.width, job.networks.height))
        if job.way[1] != "fp32":
            whole, plain = plain, path.with_name(f"{path.stem}-{job.way[1].replace(' ', '-')}.onnx")
            _quantise(whole, plain, job)
        made.append(plain)
    return tuple(made)


def _quantise(plain: Path, made: Path, job: Job) -> None:
    """Weights, and with "static" activations too, in 8 bits."""
    from onnxruntime import quantization

    # It advises, at every call, what changes nothing here.
    logging.getLogger().setLevel(logging.ERROR)
    if job.way[1] == "int8 dynamic":
        quantization.quantize_dynamic(plain, made)
        return
    source = OnnxSource(str(plain), "")
    pictures = [
        {"input": source.network_input([_pair(job.networks.width, job.networks.height, number)])}
        for number in range(_CALIBRATION_PICTURES)
    ]

    class Pictures(quantization.CalibrationDataReader):
        def __init__(self):
            self._left = iter(pictures)

        def get_next(self):
            return next(self._left, None)

    quantization.quantize_static(plain, made, Pictures(), per_channel=True)


def _median_s(runs: int, work: Callable[[], object]) -> float:
    for _ in range(_WARM_UP):
        work()
    seconds = []
    for _ in range(runs):
        started = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - started)
    return statistics.median(seconds)


def _peak_bytes(runtime: str) -> int:
    if runtime == TORCH:
        import torch

        if torch.cuda.is_available() and torch.cuda.max_memory_allocated():
            return torch.cuda.max_memory_allocated()
    # Linux gives kilobytes.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _pair(width: int, height: int, number: int = 0) -> Sample:
    """Two frames of a texture that moves, with all that any input is made of."""
    rng = lane(number, "bench")
    noise = rng.uniform(0, 255, (height, width + _MOVED_PX, 3)).astype(np.float32)
    texture = cv2.normalize(cv2.GaussianBlur(noise, (0, 0), 2), None, 0, 255, cv2.NORM_MINMAX)
    texture = texture.astype(np.uint8)
    rgb, prev = texture[:, _MOVED_PX:], texture[:, :-_MOVED_PX]
    before, now = np.eye(4), np.eye(4)
    now[:3, 3] = [0, 0, 0.8]
    return Sample(
        key=f"bench-{number}",
        rgb=np.ascontiguousarray(rgb),
        prev=np.ascontiguousarray(prev),
        depth_m=np.full((height, width), 20, np.float32),
        valid=np.ones((height, width), bool),
        max_depth_m=200.0,
        intrinsics=Intrinsics.from_fov(width, height, 90.0).matrix,
        world_from_cam=now,
        world_from_cam_prev=before,
        flow=np.full((height, width, 2), [_MOVED_PX, 0], np.float32),
    )
