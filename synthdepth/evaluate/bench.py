"""Seconds a picture, with and without optical flow (table 5), of each way to run a network here."""

import dataclasses
import os
import platform
import tempfile
from collections.abc import Callable
from pathlib import Path

from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.published import TABLE_5_S
from synthdepth.evaluate.runtimes import COMPILED, WAYS, Job, Timing, make_networks, timed
from synthdepth.flow import METHODS


@dataclasses.dataclass(frozen=True, kw_only=True)
class BenchReport:
    """What was measured.

    Attributes:
        machine: processor and, where there is one, GPU.
        threads: that each way had.
        model: the path, or what stands for it.
        width, height: of the pictures [px].
        runs: that each median is of.
        parameters: of the network with flow.
        timings: in the order of `WAYS`.
        published_s: the paper's, {device: (without, with flow)}.
    """

    machine: str
    threads: int
    model: str
    width: int
    height: int
    runs: int
    parameters: int
    timings: tuple[Timing, ...]
    published_s: dict[str, tuple[float, float]] = dataclasses.field(
        default_factory=lambda: dict(TABLE_5_S)
    )

    def __str__(self) -> str:
        """A table, and the paper's."""
        lines = [("", "without flow", "with flow", "of it flow", "memory")]
        for timing in self.timings:
            seconds = (timing.without_flow_s, timing.with_flow_s, timing.flow_s)
            lines.append(
                (
                    f"{timing.runtime} {timing.precision}",
                    *(timing.note and "-" if s is None else f"{1000 * s:.1f} ms" for s in seconds),
                    "" if timing.peak_bytes is None else f"{timing.peak_bytes / 1e6:.0f} MB",
                )
            )
        for device, seconds in self.published_s.items():
            both = [f"{1000 * s:.0f} ms" for s in seconds]
            lines.append((f"the paper, {device}", *both, "", ""))
        widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
        rows = [
            "  ".join(
                cell.ljust(width) if k == 0 else cell.rjust(width)
                for k, (cell, width) in enumerate(zip(line, widths, strict=True))
            ).rstrip()
            for line in lines
        ]
        head = (
            f"{self.model}: {self.parameters / 1e6:.1f} million parameters, {self.width}x"
            f"{self.height}, a picture at a time, median of {self.runs} runs, {self.threads} "
            f"threads, {self.machine}"
        )
        notes = [f"{t.runtime} {t.precision}: {t.note}" for t in self.timings if t.note]
        return "\n".join([head, *rows, *notes])


def bench(
    model: Path | str | None = None,
    *,
    size: str | None = None,
    runs: int = 20,
    threads: int | None = None,
    device: str | None = None,
    flow: str = "farneback",
    compiled: bool = False,
    on_progress: Callable[[int, int], None] | None = None,
) -> BenchReport:
    """Measure a model, or the paper's network with weights as they are drawn: they cost the same.

    Args:
        model: a model, a checkpoint or the folder of a training. The network without flow is
            another of the same shape, given RGB; of a model of RGB, the one with flow is the
            paper's kind of input.
        size: of the pictures, WIDTHxHEIGHT [px]; by default the model's own, or 256x256.
        runs: that are timed, after a few that are not.
        threads: for each way; by default as many as there are cores.
        device: of PyTorch, by default a GPU if there is one; ONNX Runtime stays on the CPU.
        flow: the method by which a network without flow, or none, gets some: of `flow.METHODS`.
        compiled: measure PyTorch with the network compiled, too; takes a minute longer.
        on_progress: called with (ways done, ways in all).

    Raises:
        SynthdepthError: an argument is not usable, the model cannot be read, or torch is missing.
    """
    if flow not in METHODS:
        raise SynthdepthError(f"flow {flow!r}: allowed are {', '.join(METHODS)}")
    for name, value in (("runs", runs), ("threads", threads)):
        if value is not None and value < 1:
            raise SynthdepthError(f"{name} {value}: allowed is a whole number from 1")
    threads = threads or len(os.sched_getaffinity(0))
    with tempfile.TemporaryDirectory() as folder:
        networks = make_networks(model, size, Path(folder), flow)
        if device is not None:
            from synthdepth.pix2pix.distributed import find_device

            find_device(device)
        timings = []
        ways = (*WAYS, COMPILED) if compiled else WAYS
        for way in ways:
            job = Job(
                way=way,
                networks=networks,
                folder=Path(folder),
                runs=runs,
                threads=threads,
                device=device,
            )
            timings.append(timed(job))
            if on_progress:
                on_progress(len(timings), len(ways))
    return BenchReport(
        machine=_machine(),
        threads=threads,
        model="unet_256 as drawn" if model is None else str(model),
        width=networks.width,
        height=networks.height,
        runs=runs,
        parameters=networks.parameters,
        timings=tuple(timings),
    )


def _machine() -> str:
    """The processor's name, and the GPU's where torch has one."""
    import torch

    lines = Path("/proc/cpuinfo").read_text().splitlines() if Path("/proc/cpuinfo").exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    parts = [names[0] if names else platform.processor() or platform.machine()]
    if torch.cuda.is_available():
        parts.append(torch.cuda.get_device_name())
    return ", ".join(parts)
