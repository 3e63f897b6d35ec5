"""Evaluating: predictors by data by protocols, into one report."""

import collections
import dataclasses
import itertools
import multiprocessing
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from synthdepth.dataset.sample import Sample
from synthdepth.dataset.shard import write_error, write_whole
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.baselines import FITTED
from synthdepth.evaluate.data import Data, kitti_data, pair_data
from synthdepth.evaluate.markdown import markdown
from synthdepth.evaluate.panels import Panel, make_panel
from synthdepth.evaluate.protocols import Protocol, find_protocols
from synthdepth.evaluate.record import Report, make_report
from synthdepth.evaluate.report import html_page
from synthdepth.evaluate.sources import BASELINE, FlipAveraged, Source, open_source
from synthdepth.evaluate.tally import Tally

PROTOCOLS = ("synthdepth", "synthdepth-in-range")
KITTI_PROTOCOLS = ("eigen-garg-full-80", "eigen-garg-kb-80", "eigen-crop-80", "benchmark")
BASELINES = ("mean", "ground", "triangulation")
REPORTS = ("report.json", "report.md", "report.html")
# Pictures of a part. Sums are added part by part in their order, so it must not depend on how many
# processes there are: then neither does the last digit.
_PART = 32


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Job:
    """What every process is told once."""

    data: Data
    sources: tuple[Source, ...]
    protocols: tuple[Protocol, ...]
    batch_size: int
    worst: int
    threads: int


def evaluate(
    sources: Sequence[str | Source],
    folders: Sequence[str | Path] = (),
    *,
    out: Path,
    kitti: Path | None = None,
    raw_folder: Path | None = None,
    split: str | None = None,
    split_file: Path | None = None,
    depth: str | None = None,
    variant: str | None = None,
    protocols: Sequence[str] = (),
    baselines: Sequence[str] | None = None,
    max_pairs: int = 0,
    flip: bool = False,
    panels: int = 6,
    seed: int = 0,
    batch_size: int = 8,
    workers: int | None = None,
    device: str | None = None,
    precision: str = "fp32",
    on_progress: Callable[[int, int], None] | None = None,
) -> Report:
    """Evaluate predictors, and write `report.html`, `report.md` and `report.json` into a folder.

    All see the same pictures, so that their differences can be told better than the values
    themselves. The result does not depend on `workers`, nor, but for a network's rounding, on
    `batch_size`; memory does not grow with the number of pictures.

    Args:
        sources: texts as `open_source` has them, or `Source`s of your own; the others are compared
            with the first.
        folders: datasets; either these or `kitti`.
        out: folder of the reports, made if it is not there; earlier reports in it are replaced.
        kitti: a folder of KITTI.
        raw_folder, split_file, depth, variant: of KITTI, as `KittiDataset` has them.
        split: of datasets, "test" by default; of KITTI, all by default.
        protocols: names as `find_protocol` has them; by default `PROTOCOLS`, or `KITTI_PROTOCOLS`.
        baselines: names of baselines to set beside; by default `BASELINES` on datasets.
        max_pairs: so many pictures, drawn once; 0 is all.
        flip: whether models' predictions are averaged with the mirrored picture's.
        panels: how many pictures to show, and how many of the worst.
        seed: of what is drawn: pictures and the scenes of the intervals.
        batch_size: pictures predicted at once.
        workers: processes; one a core by default, 1 stays in this one.
        device, precision: of models, as `Predictor` has them.
        on_progress: called with (pictures done, pictures in all).

    Raises:
        SynthdepthError: an argument is not usable, a source or the data cannot be read, or a report
            cannot be written.
    """
    _check(sources, folders, kitti, out, panels=panels, max_pairs=max_pairs, batch_size=batch_size)
    known = {"split": split, "max_pairs": max_pairs, "seed": seed}
    if kitti is None:
        data = pair_data(folders, **known | {"split": split or "test"})
    else:
        places = {"raw_folder": raw_folder, "split_file": split_file}
        data = kitti_data(kitti, depth=depth, variant=variant, **places, **known)
    chosen = find_protocols(protocols or (PROTOCOLS if kitti is None else KITTI_PROTOCOLS))
    opened, notes = _opened(sources, baselines, data, device, precision, flip)
    data = data.with_fields({name for source in opened for name in source.fields})

    parts = [data.numbers[k : k + _PART] for k in range(0, len(data.numbers), _PART)]
    workers = min(_workers(workers), len(parts))
    job = _Job(
        data=dataclasses.replace(data, train=None),
        sources=tuple(opened),
        protocols=tuple(chosen),
        batch_size=batch_size,
        worst=panels,
        threads=max(1, _cores() // workers),
    )
    tallies, done = None, 0
    for part, found in zip(parts, _tallied(job, parts, workers), strict=True):
        if tallies is None:
            tallies = found
        else:
            for tally, more in zip(tallies, found, strict=True):
                tally.merge(more)
        done += len(part)
        if on_progress:
            on_progress(done, len(data.numbers))
    report = make_report(data, opened, tallies, seed=seed, notes=notes)
    typical, worst = _panels(job, tallies[0], panels, alone=workers > 1)
    _write(out, report, typical, worst)
    return report


def _check(sources, folders, kitti, out, **numbers) -> None:
    if not sources:
        raise SynthdepthError("no source given: allowed is one or more")
    if bool(folders) == (kitti is not None):
        raise SynthdepthError("allowed are either datasets or a folder of KITTI, one of the two")
    for name, value in numbers.items():
        least = 1 if name == "batch_size" else 0
        if value < least:
            raise SynthdepthError(f"{name} {value}: allowed is a whole number from {least}")
    if Path(out).exists() and not Path(out).is_dir():
        raise SynthdepthError(f"out {out}: allowed is a folder")


def _opened(sources, baselines, data: Data, device, precision, flip) -> tuple[list[Source], list]:
    """The sources, then baselines; and what there is to say of those left out."""
    opened: list[Source] = []
    for source in sources:
        if isinstance(source, str):
            source = open_source(source, train=data.train, device=device, precision=precision)
        averaged = flip and not source.name.startswith(BASELINE)
        opened.append(FlipAveraged(source) if averaged else source)
    names = [source.name for source in opened]
    for name in names:
        if names.count(name) > 1:
            raise SynthdepthError(f"two sources are {name}: allowed is LABEL={name}, each its own")
    notes = []
    asked = baselines is not None
    for baseline in baselines if asked else BASELINES if data.dense else ():
        name = f"{BASELINE}{baseline}"
        if name in names:
            continue
        try:
            opened.append(open_source(name, train=data.train))
        except SynthdepthError as error:
            if asked or baseline not in FITTED:
                raise
            notes.append(f"Without {name}: {error}.")
    return opened, notes


def _workers(workers: int | None) -> int:
    if workers is None:
        return _cores()
    if workers < 1:
        raise SynthdepthError(f"workers {workers}: allowed is a whole number from 1")
    return workers


def _cores() -> int:
    return len(os.sched_getaffinity(0))


def _tallied(job: _Job, parts: list[tuple[int, ...]], workers: int) -> Iterator[list[Tally]]:
    """What each part gave, in their order."""
    if workers == 1:
        for source in job.sources:
            source.start(job.threads)
        for part in parts:
            yield _tally(job, part)
        return
    # Fresh processes: torch's threads and a GPU's context do not survive a fork.
    context = multiprocessing.get_context("spawn")
    pool = ProcessPoolExecutor(workers, mp_context=context, initializer=_begin, initargs=(job,))
    try:
        waiting = collections.deque()
        for part in parts:
            waiting.append(pool.submit(_work, part))
            if len(waiting) > 2 * workers:
                yield waiting.popleft().result()
        while waiting:
            yield waiting.popleft().result()
    except BrokenProcessPool:
        raise SynthdepthError(
            f"a worker process died, perhaps for want of memory: try fewer than {workers} workers"
        ) from None
    finally:
        pool.shutdown(cancel_futures=True)


_mine: _Job | None = None


def _begin(job: _Job) -> None:
    """The start of a worker process."""
    global _mine
    # Ctrl-C reaches the whole process group; the parent decides what it means.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    _mine = job


def _work(part: tuple[int, ...]) -> list[Tally]:
    global _ready
    if not _ready:
        # Not in `_begin`, whose errors nobody would see.
        for source in _mine.sources:
            source.start(_mine.threads)
        _ready = True
    return _tally(_mine, part)


_ready = False


def _tally(job: _Job, part: tuple[int, ...]) -> list[Tally]:
    """What each source gave on some pictures."""
    tallies = [Tally(job.protocols, job.data.far_m, job.worst) for _ in job.sources]
    for batch in _batches(job, part):
        numbers, samples = zip(*batch, strict=True)
        for source, tally in zip(job.sources, tallies, strict=True):
            predictions = source.depth_m(samples)
            for number, sample, prediction in zip(numbers, samples, predictions, strict=True):
                tally.add(prediction, sample, number, job.data.truth_of(sample))
    return tallies


def _batches(job: _Job, part: tuple[int, ...]) -> Iterator[list[tuple[int, Sample]]]:
    """Numbers and samples, as many at once as there may be, of one size."""
    numbered = ((number, job.data.samples[number]) for number in part)
    for _, alike in itertools.groupby(numbered, key=lambda pair: pair[1].depth_m.shape):
        while batch := list(itertools.islice(alike, job.batch_size)):
            yield batch


def _panels(job: _Job, first: Tally, count: int, *, alone: bool) -> tuple[list[Panel], list[Panel]]:
    """Pictures evenly out of the data, and the first source's worst ones."""
    numbers = job.data.numbers
    typical = sorted({numbers[(2 * k + 1) * len(numbers) // (2 * count)] for k in range(count)})
    if alone:
        for source in job.sources:
            source.start(_cores())
    return tuple(
        [make_panel(job.data.samples[number], job.sources, job.data.far_m) for number in chosen]
        for chosen in (typical, [picture.number for picture in first.worst])
    )


def _write(out: Path, report: Report, typical: list[Panel], worst: list[Panel]) -> None:
    out = Path(out)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise write_error(out, error) from error
    texts = (report.as_json(), markdown(report), html_page(report, typical, worst))
    for name, text in zip(REPORTS, texts, strict=True):
        write_whole(out / name, text.encode())
