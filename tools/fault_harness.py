"""Kills a render run again and again, parent and workers, and compares what comes out in the end.

Small datasets of a plain map are rendered while `kill -9` hits a process: after a time drawn at
random, or just as a file of the folder begins, grows or is there; or a process kills itself so, the
instant before or after it gives a file its name. The run is started again until the dataset is
complete; then every byte is compared with an undisturbed run's.

python tools/fault_harness.py --kills 200 --json faults.json
"""

import collections
import contextlib
import dataclasses
import hashlib
import json
import multiprocessing
import os
import random
import shutil
import signal
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import tyro
from plain_map import plain_recipe

from synthdepth.dataset.manifest import CHECKSUMS, DESCRIPTIONS, MANIFEST, read_index, read_manifest
from synthdepth.dataset.verify import verify
from synthdepth.errors import SynthdepthError
from synthdepth.production.run import render_dataset

_POLL_S = 0.002
ANYONE = -1
_LONGEST_WAIT_S = 8.0
_LET_START_SHARE = 0.95
# No look at the folder from outside is quick enough for the moment in which a file gets its name.
_TRAP_SHARE = 0.35
# A worker that outlives its parent for longer than this is an orphan; it may be just starting.
_ORPHAN_S = 60.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to do.

    Attributes:
        kills: at least so many `kill -9`, over as many datasets as that takes.
        kills_per_dataset: after so many the dataset is left to finish.
        shards: of a dataset.
        pairs_per_shard: of each; the last shard has one fewer.
        workers: processes of a run.
        seed: of the kills; every dataset has the seed 0.
        folder: to work in, which must not be there; a temporary one by default.
        json: where the figures go.
    """

    kills: int = 200
    kills_per_dataset: int = 25
    shards: int = 5
    pairs_per_shard: int = 4
    workers: int = 2
    seed: int = 0
    folder: Path | None = None
    json: Path | None = None

    @property
    def pairs(self) -> int:
        """Of a dataset."""
        return self.shards * self.pairs_per_shard - 1


os_replace = os.replace


def replace(source: Path, target: Path) -> None:
    """`os.replace`, with `kill -9` of the process itself before or after it where a trap is set."""
    when = sprung(Path(target))
    if when == "before":
        os.kill(os.getpid(), signal.SIGKILL)
    os_replace(source, target)
    if when == "after":
        os.kill(os.getpid(), signal.SIGKILL)


# In the run and its workers too, as they import this file.
os.replace = replace


def trap_of(folder: Path, when: str, suffix: str) -> Path:
    """The file that sets a trap for the next file of a dataset that gets a name with a suffix."""
    return folder.with_name(f"{folder.name}.{when}{suffix}")


def sprung(target: Path) -> str | None:
    """Whether a trap is set for a file: "before", "after" or None. It is set for one process."""
    for when in ("before", "after"):
        with contextlib.suppress(FileNotFoundError):
            trap_of(target.parents[target.suffix == ".tar"], when, target.suffix).unlink()
            return when
    return None


def render(folder: Path, options: Options) -> None:
    """A run, in a process of its own; the exit code is 3 where it gave up by itself."""
    log = os.open(folder.with_suffix(".log"), os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(log, 1), os.dup2(log, 2)
    folder.with_suffix(".begun").touch()
    try:
        render_dataset(
            plain_recipe(options.pairs_per_shard),
            folder,
            pairs=options.pairs,
            workers=options.workers,
        )
    except SynthdepthError as error:
        print(error)
        raise SystemExit(3) from None


def main(options: Options) -> int:
    started, cpu = time.monotonic(), os.times()
    work = options.folder or Path(tempfile.mkdtemp(prefix="faults-"))
    work.mkdir(parents=True, exist_ok=options.folder is None)
    try:
        with contextlib.redirect_stdout(None):
            render_dataset(
                plain_recipe(options.pairs_per_shard),
                work / "whole",
                pairs=options.pairs,
                workers=options.workers,
            )
        harness = Harness(options, work)
        while sum(harness.kills.values()) < options.kills:
            harness.one_dataset()
            print(harness.line(), flush=True)
    finally:
        if options.folder is None:
            shutil.rmtree(work)
    spent = sum(os.times()[:4]) - sum(cpu[:4])
    figures = {
        "kills": sum(harness.kills.values()),
        "kills_by_victim_and_phase": dict(sorted(harness.kills.items())),
        "runs": harness.runs,
        "runs_that_gave_up": harness.gave_up,
        "datasets": harness.datasets,
        "datasets_equal": harness.datasets - len(harness.unequal),
        "unequal": harness.unequal,
        "orphans": harness.orphans,
        "wall_s": round(time.monotonic() - started),
        "processor_s": round(spent),
    }
    print(json.dumps(figures, indent=1))
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")
    return 1 if harness.unequal or harness.orphans else 0


class Harness:
    """Kills runs and keeps the tally.

    Args:
        options: what to do.
        work: folder with `whole`, the dataset of an undisturbed run.

    Attributes:
        kills: by victim and phase.
        runs, gave_up, datasets: how many.
        unequal: what differs, of each dataset that is not as it should be.
        orphans: workers that outlived their parents.
    """

    def __init__(self, options: Options, work: Path):
        self.options, self.work = options, work
        self.kills: collections.Counter[str] = collections.Counter()
        self.runs = self.gave_up = self.datasets = self.orphans = 0
        self.unequal: list[str] = []
        # Of whom to kill and when; what is rendered has its own lanes.
        self._random = random.Random(options.seed)
        self._left: list[int] = []
        self._whole = work / "whole"
        self._sizes = {path.name: path.stat().st_size for path in self._whole.glob("*/*.tar")}
        self._known = contents(self._whole)

    def line(self) -> str:
        """The tally so far."""
        return (
            f"{sum(self.kills.values())} kills over {self.runs} runs of {self.datasets} datasets: "
            f"{len(self.unequal)} differ, {self.orphans} orphans"
        )

    def one_dataset(self) -> None:
        """Render one dataset under fire, and look at what came out."""
        folder = self.work / f"set{self.datasets}"
        killed = 0
        while True:
            run = multiprocessing.get_context("spawn").Process(
                target=render, args=(folder, self.options)
            )
            begun = folder.with_suffix(".begun")
            begun.unlink(missing_ok=True)
            run.start()
            self.runs += 1
            # Python's own start takes seconds, in which there is little to break.
            patient = self._random.random() < _LET_START_SHARE
            while run.is_alive() and patient and not begun.exists():
                time.sleep(_POLL_S)
            while run.is_alive() and killed < self.options.kills_per_dataset:
                trap = self._random.random() < _TRAP_SHARE
                killed += self._trap(run, folder) if trap else self._strike(run, folder)
            run.join()
            if run.exitcode == 0:
                break
            self.gave_up += run.exitcode == 3
        self.datasets += 1
        self.orphans += still_there(self._left)
        self._left.clear()
        wrong = self._differences(folder)
        if wrong:
            self.unequal.append(f"{folder.name}: {wrong}")
        else:
            shutil.rmtree(folder)
            begun.unlink()
            folder.with_suffix(".log").unlink()

    def _strike(self, run: multiprocessing.Process, folder: Path) -> bool:
        """Wait for a moment, and kill; False if the run ended before."""
        moment = self._random.choice(self._moments(run.pid, folder))
        while not (victim := moment()):
            if not run.is_alive():
                return False
            time.sleep(_POLL_S)
        time.sleep(self._random.choice([0.0, 0.0, self._random.uniform(0.0, 0.03)]))
        workers = children_of(run.pid)
        if victim == ANYONE:
            victim = self._random.choice([run.pid, *workers])
        phase = self._phase(folder, victim)
        with contextlib.suppress(ProcessLookupError):
            os.kill(victim, signal.SIGKILL)
            self.kills[f"{'parent' if victim == run.pid else 'worker'}, {phase}"] += 1
        if victim == run.pid:
            # The next run begins at once, beside what may still live of this one.
            run.join()
            self._left += workers
        return True

    def _trap(self, run: multiprocessing.Process, folder: Path) -> bool:
        """Let a process die as it gives a file its name; False if the run ended before."""
        whole = len(list(folder.glob("*/*.tar"))) == self.options.shards
        told = sorted({Path(name).suffix for name in DESCRIPTIONS})
        suffixes = told if whole else [".json", ".tar", ".tar"]
        when, suffix = self._random.choice(["before", "after"]), self._random.choice(suffixes)
        trap, workers = trap_of(folder, when, suffix), []
        trap.touch()
        while trap.exists():
            if not run.is_alive():
                with contextlib.suppress(FileNotFoundError):
                    trap.unlink()
                    return False
            workers = children_of(run.pid) or workers
            time.sleep(_POLL_S)
        if suffix == ".tar":
            self.kills[f"worker, {when} a shard has its name"] += 1
            return True
        self.kills[f"parent, {when} a file has its name ({suffix})"] += 1
        run.join()
        self._left += workers
        return True

    def _moments(self, parent: int, folder: Path) -> list[Callable[[], int | None]]:
        """What to wait for, each a function that gives the process that it is the moment to kill.

        A third of them wait for nothing that the folder shows: any process, at any time.
        """
        tars, manifest = len(list(folder.glob("*/*.tar"))), modified(folder / MANIFEST)
        finishing = time.monotonic() + self._random.uniform(0.0, 1.0)
        any_time = time.monotonic() + self._random.uniform(0.0, _LONGEST_WAIT_S)

        def writer(is_it: Callable[[int, int], bool]) -> Callable[[], int | None]:
            return lambda: next((p for p, *sizes in self._partials(folder) if is_it(*sizes)), None)

        def parent_when(event: Callable[[], object]) -> Callable[[], int | None]:
            return lambda: parent if event() else None

        return [
            writer(lambda size, whole: size == 0),
            writer(lambda size, whole: 0 < size < whole),
            parent_when(lambda: len(list(folder.glob("*/*.tar"))) > tars),
            parent_when(lambda: any(folder.glob("*.partial"))),
            parent_when(lambda: modified(folder / MANIFEST) != manifest),
            parent_when(lambda: tars == self.options.shards and time.monotonic() > finishing),
        ] + [lambda: ANYONE if time.monotonic() > any_time else None] * 3

    def _partials(self, folder: Path) -> Iterator[tuple[int, int, int]]:
        """Who writes each shard that is being written, its bytes so far, and those it will have."""
        for path in folder.glob("*/*.partial"):
            with contextlib.suppress(FileNotFoundError):
                tar, _, rest = path.name.partition(".tar.")
                pid = int(rest.removesuffix(".partial").rpartition("-")[2])
                yield pid, path.stat().st_size, self._sizes[f"{tar}.tar"]

    def _phase(self, folder: Path, victim: int) -> str:
        """What the folder says that a process is doing."""
        for pid, size, whole in self._partials(folder):
            if pid == victim:
                return "building" if not size else "rendering" if size < whole else "closing"
        for path in folder.glob(f"*-{victim}.partial"):
            return f"writing {'.'.join(path.name.split('.')[:2])}"
        if not (folder / MANIFEST).exists():
            return "before the manifest"
        if len(list(folder.glob("*/*.tar"))) == self.options.shards:
            return "finishing"
        return "between files"

    def _differences(self, folder: Path) -> str:
        """What is not as in the undisturbed dataset; empty where all is."""
        found = contents(folder)
        names = {n for n in found.keys() | self._known.keys() if found.get(n) != self._known.get(n)}
        keys = read_index(folder, ["key"])["key"].to_pylist()
        told = sorted(names)
        told += [f"{len(keys)} pairs of {self.options.pairs}"] * (len(keys) != self.options.pairs)
        told += ["pairs twice"] * (len(set(keys)) != len(keys))
        told += [f"{fault.where}: {fault.what}" for fault in verify(folder).faults]
        return "; ".join(told)


def contents(folder: Path) -> dict[str, str]:
    """A digest of every file, hidden or half written ones too, but for what a kill loses."""
    digests = {}
    for path in folder.rglob("*"):
        if path.is_file():
            data = path.read_bytes()
            if path.name == MANIFEST:
                manifest = read_manifest(folder)
                shards = [record | {"cost": None, "redrawn": None} for record in manifest["shards"]]
                data = json.dumps(manifest | {"shards": shards}).encode()
            if path.name == CHECKSUMS:
                data = b""  # Of the manifest, costs and all; `verify` checks them.
            digests[path.relative_to(folder).as_posix()] = hashlib.sha256(data).hexdigest()
    return digests


def children_of(pid: int) -> list[int]:
    """The workers of a run: its child processes, but for Python's resource tracker."""
    try:
        children = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
        return [
            int(c) for c in children if b"spawn_main" in Path(f"/proc/{c}/cmdline").read_bytes()
        ]
    except (FileNotFoundError, ProcessLookupError):
        return []


def still_there(workers: list[int]) -> int:
    """How many processes live on for longer than they may."""
    limit = time.monotonic() + _ORPHAN_S
    while time.monotonic() < limit:
        workers = [pid for pid in workers if alive(pid)]
        if not workers:
            break
        time.sleep(0.01)
    return len(workers)


def alive(pid: int) -> bool:
    """Whether a process is there and no zombie."""
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] not in "ZX"
    except (FileNotFoundError, ProcessLookupError):
        return False


def modified(path: Path) -> int:
    """When a file was written last [ns]; 0 if it is not there."""
    try:
        return path.stat().st_mtime_ns
    except FileNotFoundError:
        return 0


if __name__ == "__main__":
    raise SystemExit(main(tyro.cli(Options, description=__doc__)))
