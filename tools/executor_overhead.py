"""What a Ray cluster costs against local processes: the same jobs on the same cores, in turn.

python tools/executor_overhead.py --map blocks --pairs 512 --json overhead.json

Two figures. Jobs that do nothing tell what starting and ending one takes. Datasets rendered by
either tell what that is of a real run. Ray is started before and not counted, as a cluster is there
already.
"""

import dataclasses
import functools
import json
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import tyro

from synthdepth.production import ray_pool
from synthdepth.production.pool import run_jobs
from synthdepth.production.recipe import load_recipe
from synthdepth.production.run import default_workers, render_dataset


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        map: the map.
        pairs: of a dataset.
        seed: of a dataset.
        workers: processes at once, of either.
        rounds: each renders a dataset locally and one with Ray; the median over them is told.
        empty_jobs: how many jobs that do nothing.
        json: where the figures go.
    """

    map: str = "blocks"
    pairs: int = 1024
    seed: int = 0
    workers: int = default_workers()
    rounds: int = 3
    empty_jobs: int = 40
    json: Path | None = None


def nothing(job: int, report: Callable[[int], None]) -> int:
    """A job that costs what any job costs; loads what a rendering one does."""
    import synthdepth.production.run  # noqa: F401

    return job


def main(options: Options) -> None:
    import ray

    ray.init(num_cpus=options.workers, log_to_driver=False, logging_level="error")
    executors = {"local": run_jobs, "ray": ray_pool.run_jobs}
    empty_s = {}
    for name, run in executors.items():
        started = time.perf_counter()
        list(run(nothing, list(range(options.empty_jobs)), options.workers))
        empty_s[name] = (time.perf_counter() - started) / options.empty_jobs
    wall_s: dict[str, list[float]] = {name: [] for name in executors}
    for number in range(options.rounds):
        # Whoever comes second finds what the first one left in caches.
        for name in list(executors)[:: 1 if number % 2 else -1]:
            wall_s[name].append(rendered(options, name))
            print(f"round {number}: {name} {wall_s[name][-1]:.1f} s", flush=True)
    ray.shutdown()
    local, cluster = (float(np.median(wall_s[name])) for name in executors)
    figures = {
        "local_s": round(local, 1),
        "ray_s": round(cluster, 1),
        "overhead": round(cluster / local - 1, 4),
        "pairs": options.pairs,
        "workers": options.workers,
        "wall_s": wall_s,
        "seconds_an_empty_job": {name: round(value, 3) for name, value in empty_s.items()},
    }
    print(json.dumps(figures, indent=1))
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")


def rendered(options: Options, executor: str) -> float:
    """Seconds that a dataset takes."""
    with tempfile.TemporaryDirectory() as folder:
        render = functools.partial(render_dataset, load_recipe(options.map), Path(folder) / "set")
        return render(
            pairs=options.pairs,
            seed=options.seed,
            workers=options.workers,
            executor=executor,
        ).wall_s


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
