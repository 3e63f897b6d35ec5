"""Resident memory of a run's workers, and of the run itself, over many scenes.

python tools/worker_memory.py --map neighborhood --scenes 40 --json memory.json

Every scene has a process of its own, so that nothing can pile up in one; the slope of the peaks
over the scenes shows whether anything does. The run itself lives through all of them.
"""

import dataclasses
import json
import tempfile
import threading
import time
from pathlib import Path

import numpy as np
import tyro

from synthdepth.production.overrides import with_overrides
from synthdepth.production.recipe import load_recipe
from synthdepth.production.run import default_workers, render_dataset

_EVERY_S = 0.25


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        map: the map.
        scenes: how many.
        pairs_per_scene: of each.
        workers: processes at once.
        seed: of the dataset.
        json: where the figures go.
    """

    map: str = "neighborhood"
    scenes: int = 40
    pairs_per_scene: int = 32
    workers: int = default_workers()
    seed: int = 0
    json: Path | None = None


class Watch(threading.Thread):
    """Looks at the memory of this process and its workers, four times a second.

    Attributes:
        peaks: {process: most bytes resident}, of the workers in the order of their start.
        own: [(seconds, bytes resident)] of this process.
    """

    def __init__(self):
        super().__init__(daemon=True)
        self.peaks: dict[int, int] = {}
        self.own: list[tuple[float, int]] = []
        self.stop = threading.Event()

    def run(self) -> None:
        """Look until told to stop."""
        started = time.monotonic()
        while not self.stop.wait(_EVERY_S):
            self.own.append((time.monotonic() - started, status_bytes("self", "VmRSS")))
            for pid in children():
                # VmHWM is the peak since the start, so that none is missed between two looks.
                peak = status_bytes(str(pid), "VmHWM")
                if peak:
                    self.peaks[pid] = max(self.peaks.get(pid, 0), peak)


def children() -> list[int]:
    """The workers: child processes of any thread, but for Python's resource tracker."""
    found = []
    for path in Path("/proc/self/task").glob("*/children"):
        try:
            for child in path.read_text().split():
                if b"spawn_main" in Path(f"/proc/{child}/cmdline").read_bytes():
                    found.append(int(child))
        except (FileNotFoundError, ProcessLookupError):
            continue
    return found


def status_bytes(process: str, name: str) -> int:
    """A figure of /proc/<process>/status; 0 where the process is no more."""
    try:
        lines = Path(f"/proc/{process}/status").read_text().splitlines()
    except (FileNotFoundError, ProcessLookupError):
        return 0
    return next((int(line.split()[1]) * 1024 for line in lines if line.startswith(name)), 0)


def slope(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Slope of the line through points, and its standard error."""
    (value, _), covariance = np.polyfit(x, y, 1, cov=True)
    return float(value), float(np.sqrt(covariance[0, 0]))


def main(options: Options) -> None:
    recipe = with_overrides(load_recipe(options.map), pairs_per_scene=options.pairs_per_scene)
    watch = Watch()
    watch.start()
    with tempfile.TemporaryDirectory() as folder:
        report = render_dataset(
            recipe,
            Path(folder) / "set",
            pairs=options.scenes * options.pairs_per_scene,
            seed=options.seed,
            workers=options.workers,
        )
    watch.stop.set()
    watch.join()
    peaks = np.array(list(watch.peaks.values())) / 1e6
    time_s, own = np.array(watch.own).T
    half = len(own) // 2  # Of its second half: what it loads as it starts is no leak.
    worker_slope, worker_error = slope(np.arange(len(peaks)), peaks)
    own_slope, own_error = slope(time_s[half:] / 3600, own[half:] / 1e6)
    figures = {
        "map": options.map,
        "scenes": len(peaks),
        "workers": options.workers,
        "wall_s": round(report.wall_s),
        "worker_peak_mb": {
            "most": round(float(peaks.max())),
            "median": round(float(np.median(peaks))),
            "least": round(float(peaks.min())),
        },
        "worker_slope_mb_per_scene": [round(worker_slope, 3), round(worker_error, 3)],
        "run_itself_mb": {"first": round(own[0] / 1e6), "most": round(own.max() / 1e6)},
        "run_itself_slope_mb_per_hour": [round(own_slope, 3), round(own_error, 3)],
        "peaks_mb": [round(float(peak)) for peak in peaks],
    }
    print(json.dumps(figures, indent=1))
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
