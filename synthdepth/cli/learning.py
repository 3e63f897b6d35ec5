"""Commands that train networks and use them."""

import contextlib
import dataclasses
from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import tyro

from synthdepth.console import progress_bar, say, write_json
from synthdepth.errors import SynthdepthError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Train:
    """Train Pix2Pix on the split train of some datasets, but for some scenes of it, which validate.

    Stopped in any way, the same command goes on where it was. On several GPUs:
    torchrun --nproc-per-node 4 -m synthdepth train ...
    """

    folders: tyro.conf.Positional[tuple[str, ...]]
    """The datasets, folders or addresses."""
    out: Path
    """Folder of the training: checkpoints, the best model, log.jsonl, tensorboard."""
    input: Literal["rgb", "flow", "embed", "channels", "triangulated"] | None = None
    """What the network sees: the frame, its flow's heat map, the frame with the heat map embedded
    (default), the frame and both components of the flow, or the frame and the depth that flow and
    the drone's motion give."""
    interval: int | None = None
    """Every how many pixels embed shows the flow; 5 by default."""
    flow: Literal["farneback", "lucas_kanade", "lucas_kanade_dense", "dis", "truth"] | None = None
    """How flow is estimated; farneback by default."""
    size: str | None = None
    """Bring the pairs to this size, e.g. 256x256; by default they stay as they are."""
    epochs: int | None = None
    """Passes over the pairs; 100 by default."""
    batch_size: int | None = None
    """Pairs of a step in each process; 1 by default."""
    lr: float | None = None
    """Learning rate; 0.0002 by default."""
    decay: Literal["none", "linear"] | None = None
    """linear: the learning rate falls to 0 over the second half; none by default."""
    precision: Literal["fp32", "bf16"] | None = None
    """Inside the networks: bf16 is faster where the machine has it; fp32 by default."""
    seed: int | None = None
    """Everything is drawn from it; 0 by default."""
    max_pairs: int | None = None
    """Train with so many pairs only; 0, the default, is all."""
    workers: int | None = None
    """Processes that read ahead; 4 by default."""
    device: str | None = None
    """cpu, cuda or cuda:1; by default a GPU if there is one."""
    config: Path | None = None
    """A .toml or .json file with any value of the training, such as config.json of another one;
    the options above go before it."""
    json: Path | None = None
    """Write the training's figures to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        with _extra("train"):
            from synthdepth.pix2pix.config import parse_size, train_config
            from synthdepth.pix2pix.train import train

        size = None if self.size is None else parse_size(self.size)
        options = {"input.kind": self.input, "input.interval": self.interval, "size": size}
        options |= {"input.flow": self.flow}
        for name in ("epochs", "batch_size", "lr", "decay", "precision", "seed", "max_pairs"):
            options[name] = getattr(self, name)
        config = train_config(self.config, options | {"workers": self.workers})
        try:
            with progress_bar("training", "pairs") as progress:
                report = train(
                    config,
                    self.folders,
                    self.out,
                    device=self.device,
                    on_progress=progress,
                    on_validation=lambda errors: say(_errors(errors)),
                )
        except KeyboardInterrupt:
            say(f"\nstopped: {self.out} is safe; the same command goes on")
            return 130
        if report.rank == 0:
            best = f", best in {_errors(report.best)}" if report.best else ""
            say(
                f"{self.out}: {report.epochs} epochs of {report.pairs} pairs; {report.steps_now} "
                f"of {report.steps} steps now, in {report.wall_s:.0f} s{best}"
            )
            write_json(self.json, dataclasses.asdict(report))
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Predict:
    """Write depth for a dataset, a folder of pictures or a video: EXR in metres, PNG in colour.

    In a folder and a video frames follow one another by name and time; for a model that needs the
    frame before, the first gets no depth.
    """

    model: tyro.conf.Positional[Path]
    """A training's folder, or a .safetensors file of it."""
    source: tyro.conf.Positional[str]
    """A dataset, a folder of pictures, a picture, or a video."""
    out: Path
    """The folder to make."""
    split: Literal["train", "test"] | None = None
    """Of a dataset; both by default."""
    fov_deg: float | None = None
    """Horizontal field of view of pictures and videos, for the files' intrinsics."""
    batch_size: int = 8
    """Frames at once."""
    precision: Literal["fp32", "bf16"] = "fp32"
    """Inside the network: bf16 is faster where the machine has it."""
    compiled: bool = False
    """Compile the network first: takes half a minute, and each frame then less."""
    device: str | None = None
    """cpu, cuda or cuda:1; by default a GPU if there is one."""
    json: Path | None = None
    """Write figures to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        with _extra("train"):
            from synthdepth.pix2pix.predict import predict

        with progress_bar("predicting", "frames") as progress:
            report = predict(
                self.model,
                self.source,
                self.out,
                split=self.split,
                fov_deg=self.fov_deg,
                batch_size=self.batch_size,
                device=self.device,
                precision=self.precision,
                compiled=self.compiled,
                on_progress=progress,
            )
        left_out = ", the first left out as it has no frame before" if report.skipped else ""
        speed = report.frames / max(report.network_s, 1e-9)
        say(
            f"{self.out}: {report.frames} frames{left_out}, in {report.wall_s:.1f} s "
            f"({speed:.1f} frames/s in flow and network)"
        )
        write_json(self.json, dataclasses.asdict(report))
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Onnx:
    """Write a trained generator as ONNX, from its input to metres."""

    model: tyro.conf.Positional[Path]
    """A training's folder, or a .safetensors file of it."""
    out: Path
    """The .onnx file to write."""
    size: str | None = None
    """Size of the pictures, e.g. 256x256; by default the one it was trained at."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        with _extra("train"):
            from synthdepth.pix2pix.config import parse_size
            from synthdepth.pix2pix.onnx import export_onnx

        size = None if self.size is None else parse_size(self.size)
        data = export_onnx(self.model, self.out, size=size)
        say(f"{self.out}: {data / 1e6:.0f} MB")
        return 0


def _errors(errors: dict) -> str:
    return (
        f"epoch {errors['epoch']}: RMSE {errors['rmse_m']:.3f} m, Rel {errors['rel']:.4f}, "
        f"delta {errors['delta_1']:.4f} {errors['delta_2']:.4f} {errors['delta_3']:.4f}"
    )


@contextlib.contextmanager
def _extra(name: str) -> Iterator[None]:
    """Turns the lack of an optional package into one line that says how to get it."""
    try:
        yield
    except ModuleNotFoundError as error:
        if error.name.split(".")[0] == "synthdepth":
            raise
        raise SynthdepthError(
            f"this command needs {error.name}: install it with pip install 'synthdepth[{name}]'"
        ) from None
