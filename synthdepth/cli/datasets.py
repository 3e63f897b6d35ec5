"""Commands that check, show, import and export datasets."""

import dataclasses
from pathlib import Path
from typing import Literal

import tyro

from synthdepth.console import progress_bar, say, write_json


@dataclasses.dataclass(frozen=True, kw_only=True)
class Verify:
    """Check a dataset: files, counts, decoding, contract, and ground truth that agrees with itself.

    Exit 1 if anything is wrong, or was and could not be repaired.
    """

    folder: tyro.conf.Positional[Path]
    """The dataset."""
    repair: bool = False
    """Render bad shards again, to the same bytes, and make the other files again."""
    workers: int | None = None
    """Processes at once; by default one a core."""
    json: Path | None = None
    """Write what was found to this file."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.dataset.verify import verify
        from synthdepth.production.run import usable_cores

        with progress_bar("verifying", "pairs") as progress:
            workers = usable_cores() if self.workers is None else self.workers
            report = verify(self.folder, workers=workers, on_progress=progress)
        for fault in report.faults:
            say(f"{fault.where}: {fault.what}")
        say(f"{'':12}{'judged':>10}{'no evidence':>14}{'faults':>10}")
        for subject, tally in report.checks.items():
            say(f"{subject:12}{tally.judged:10}{tally.silent:14}{tally.faults:10}")
        for note in report.notes:
            say(note)
        verdict = f"{len(report.faults)} faults" if report.faults else "no fault"
        say(
            f"{self.folder}: {report.shards} shards, {report.pairs} pairs, "
            f"{report.bytes / 1e6:.1f} MB, {verdict}"
        )
        repairs = self._repaired(report) if self.repair else []
        write_json(
            self.json,
            dataclasses.asdict(report) | {"repairs": [dataclasses.asdict(r) for r in repairs]},
        )
        if self.repair:
            return int(not all(one.done for one in repairs))
        return int(bool(report.faults))

    def _repaired(self, report) -> list:
        from synthdepth.production.repair import repair

        if not report.faults and not report.notes:
            return []
        with progress_bar("repairing", "pairs") as progress:
            repairs = repair(self.folder, report.faults, workers=self.workers, on_progress=progress)
        for one in repairs:
            say(f"{one.where}: {one.what}")
        done = sum(one.done for one in repairs)
        say(f"{self.folder}: {done} files repaired, {len(repairs) - done} not")
        return repairs


@dataclasses.dataclass(frozen=True, kw_only=True)
class OnePair:
    """Render one pair of a dataset again, alone, and say what the gate finds; exit 1 if it does."""

    folder: tyro.conf.Positional[Path]
    """The dataset; it need not be finished."""
    key: tyro.conf.Positional[str]
    """The pair's, e.g. neighborhood-s00012-f003-0045."""
    out: Path | None = None
    """The folder for its files: a new or an empty one; the key by default."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.production.single import render_pair

        pair = render_pair(self.folder, self.key, self.out or Path(self.key))
        for fault in pair.faults:
            say(f"{self.key}: {fault}")
        verdict = f"{len(pair.faults)} faults" if pair.faults else "no fault"
        say(f"{pair.folder}: {self.key}, scene seed {pair.scene_seed}, {verdict}")
        return int(bool(pair.faults))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Preview:
    """Show a dataset on one page: random pairs, histograms, conditions, maps of the flights.

    A name that ends in .html gives a web page that is whole in itself; .png a contact sheet.
    """

    folder: tyro.conf.Positional[Path]
    """The dataset."""
    out: Path | None = None
    """The .html or .png to write; preview.png beside the dataset folder by default."""
    count: int = 24
    """How many pairs."""
    seed: int = 0
    """Which pairs."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        # Beside, not inside: a dataset folder holds nothing but the dataset.
        out = self.out or Path(f"{self.folder.resolve()}-preview.png")
        if out.suffix.lower() in (".html", ".htm"):
            from synthdepth.view.page import write_page as write
        else:
            from synthdepth.dataset.preview import preview as write
        count = write(self.folder, out, count=self.count, seed=self.seed)
        say(f"{out}: {count} pairs")
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class View:
    """Fly through a dataset in the Rerun viewer: flights, points, every picture.

    Without a display, or with --out, it writes a recording instead.
    """

    folder: tyro.conf.Positional[Path]
    """The dataset."""
    out: Path | None = None
    """A .rrd file to write; without a display <folder>.rrd beside the dataset folder."""
    count: int = 64
    """At most how many pairs, in the dataset's order."""
    flight: tuple[str, ...] = ()
    """Only these flights (s00012-f003) or scenes (s00012)."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.view.recording import has_display, open_viewer, write_recording

        if self.out is None and has_display():
            say(f"{open_viewer(self.folder, count=self.count, flights=self.flight)} pairs shown")
            return 0
        out = self.out or Path(f"{self.folder.resolve()}.rrd")
        count = write_recording(self.folder, out, count=self.count, flights=self.flight)
        say(f"{out}: {count} pairs; open it with rerun --bind 127.0.0.1 {out}")
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Export:
    """Write a dataset in another layout; the new folder is there whole or not at all.

    kitti: raw recordings and depth benchmark, calibration, poses, split lists.
    tartanair: TartanAir (first version), a trajectory a burst, NED poses, forward flow.
    hf: typed Parquet with a card, for `datasets` and the Hugging Face Hub.
    nerfstudio: transforms.json, pictures and depth for each flight.
    """

    folder: tyro.conf.Positional[Path]
    """The dataset."""
    to: Literal["kitti", "tartanair", "hf", "nerfstudio"]
    """Which layout."""
    out: Path
    """The folder to write: a new or an empty one."""
    split: Literal["train", "test"] | None = None
    """Only this split."""
    sky: Literal["invalid", "saturated"] | None = None
    """With --to kitti: what pixels at or beyond the range hold, 0 (invalid, the default) or the
    range."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.export import export

        options = {} if self.sky is None else {"sky": self.sky}
        with progress_bar("exporting", "pairs") as progress:
            report = export(
                self.to, self.folder, self.out, split=self.split, on_progress=progress, **options
            )
        say(f"{report.folder}: {report.pairs} pairs")
        for note in report.notes:
            say(note)
        return 0


@dataclasses.dataclass(frozen=True, kw_only=True)
class ImportAirsim:
    """Turn recordings of AirSim into a dataset: same shards, same loaders."""

    folder: tyro.conf.Positional[Path]
    """A recording (the folder with airsim_rec.txt), or a folder of recordings."""
    out: Path
    """The dataset: a new or an empty folder."""
    camera: str | None = None
    """Which camera, if the recordings hold several."""
    settings: Path | None = None
    """AirSim's settings.json: the camera's field of view and place on the vehicle."""
    max_depth_m: float | None = None
    """Where the depth saturates; where the simulator clipped it by default, at most 200."""
    split: Literal["train", "test"] | None = None
    """By default the recordings alternate between train and test, by name."""
    max_gap_s: float = 0.5
    """Frames farther apart are no pair."""

    def run(self) -> int:
        """Do it; returns the exit code."""
        from synthdepth.airsim.importer import import_airsim

        with progress_bar("importing", "frames") as progress:
            report = import_airsim(
                self.folder,
                self.out,
                camera=self.camera,
                settings=self.settings,
                max_depth_m=self.max_depth_m,
                split=self.split,
                max_gap_s=self.max_gap_s,
                on_progress=progress,
            )
        total = sum(report.pairs.values())
        say(f"{report.folder}: {total} pairs of {report.recordings} recordings")
        for reason, count in report.skipped.items():
            say(f"left out: {count} frames, {reason}")
        for note in report.notes:
            say(note)
        return 0
