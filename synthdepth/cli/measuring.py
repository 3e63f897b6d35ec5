"""Commands that measure depth and its run time."""

import dataclasses
from pathlib import Path
from typing import Literal

import tyro

from synthdepth.console import progress_bar, say, write_json


@dataclasses.dataclass(frozen=True, kw_only=True)
class Evaluate:
    """Measure predicted depth: one report with tables, intervals, charts and pictures.

    Sources are models that `train` made, ONNX files, folders of predictions (<key>.depth.exr, .npy
    or 16-bit .png), and baseline:constant, mean, ground, triangulation, triangulation-exact-flow.
    LABEL= before one names its column; the others are compared with the first.
    """

    sources: tyro.conf.Positional[tuple[str, ...]]
    """What predicts."""
    out: Path
    """Folder for report.html, report.md and report.json."""
    data: tuple[str, ...] = ()
    """Datasets."""
    kitti: Path | None = None
    """KITTI instead: raw recordings, depth benchmark, val_selection_cropped, object, our export."""
    kitti_raw: Path | None = None
    """Where KITTI's raw recordings lie, if elsewhere."""
    split_file: Path | None = None
    """A list of KITTI's frames, as BTS or monodepth2 have it."""
    truth: Literal["groundtruth", "velodyne_raw", "lidar"] | None = None
    """Of KITTI; by default the first of these that is there."""
    split: Literal["train", "test", "val"] | None = None
    """Test by default; of KITTI all, or train or val."""
    protocol: tuple[str, ...] = ()
    """By default synthdepth and synthdepth-in-range; of KITTI several. NAME/median and NAME/metric
    scale otherwise than NAME."""
    baselines: tuple[str, ...] | None = None
    """Set beside; by default mean, ground and triangulation, of KITTI none."""
    max_pairs: int = 0
    """So many pictures, drawn once; 0 is all."""
    flip: bool = False
    """Average each prediction with the mirrored picture's, as AdaBins and ZoeDepth do."""
    panels: int = 6
    """How many pictures to show, and how many of the worst."""
    batch_size: int = 8
    """Pictures predicted at once."""
    workers: int | None = None
    """Processes; one a core by default."""
    device: str | None = None
    """cpu or cuda; a GPU by default where there is one."""
    precision: Literal["fp32", "bf16"] = "fp32"
    """Of models."""
    seed: int = 0
    """Of what is drawn: pictures, and the scenes of the intervals."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.evaluate.markdown import summary
        from synthdepth.evaluate.run import evaluate

        with progress_bar("evaluating", "pictures") as progress:
            report = evaluate(
                self.sources,
                self.data,
                out=self.out,
                kitti=self.kitti,
                raw_folder=self.kitti_raw,
                split_file=self.split_file,
                depth=self.truth,
                split=self.split,
                protocols=self.protocol,
                baselines=self.baselines,
                max_pairs=self.max_pairs,
                flip=self.flip,
                panels=self.panels,
                seed=self.seed,
                batch_size=self.batch_size,
                workers=self.workers,
                device=self.device,
                precision=self.precision,
                on_progress=progress,
            )
        say(summary(report))
        say(f"{self.out / 'report.html'}: {report.pictures} pictures of {report.scenes} "
            f"{report.places}")  # fmt: skip
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bench:
    """Time a network: seconds a picture with and without flow, PyTorch and ONNX Runtime, 8 bits."""

    model: tyro.conf.Positional[Path | None] = None
    """A model or the folder of a training; by default the paper's network, untrained."""
    size: str | None = None
    """WIDTHxHEIGHT of the pictures; by default the model's own, or 256x256."""
    runs: int = 20
    """That are timed; the median is told."""
    threads: int | None = None
    """One a core by default."""
    device: str | None = None
    """Of PyTorch: cpu or cuda; a GPU by default where there is one."""
    flow: str = "farneback"
    """How flow is estimated, where the model does not say: dis takes a third of the time."""
    compiled: bool = False
    """Measure PyTorch with the network compiled, too; takes a minute longer."""
    json: Path | None = None
    """Write the figures to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.evaluate.bench import bench

        with progress_bar("timing", "ways") as progress:
            report = bench(
                self.model,
                size=self.size,
                runs=self.runs,
                threads=self.threads,
                device=self.device,
                flow=self.flow,
                compiled=self.compiled,
                on_progress=progress,
            )
        say(str(report))
        write_json(self.json, dataclasses.asdict(report))
        return 0
