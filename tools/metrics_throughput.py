"""Speed of the evaluator without reading or predicting: pairs/s of all metrics and breakdowns.

python tools/metrics_throughput.py --pairs 8000 --workers 2 --json metrics_throughput.json
"""

import dataclasses
import json
import multiprocessing
import resource
import time
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np
import tyro

from synthdepth.camera import Intrinsics
from synthdepth.dataset.sample import Sample
from synthdepth.evaluate.accumulate import ErrorHistogram
from synthdepth.evaluate.breakdown import Breakdown
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane

_DIFFERENT = 8
_PAIRS_PER_SCENE = 50


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        size_px: side of the square pictures.
        pairs: how many, over a few that repeat.
        workers: processes.
        json: where the figures go.
    """

    size_px: int = 256
    pairs: int = 8000
    workers: int = 2
    json: Path | None = None


def made_up(number: int, size: int) -> tuple[np.ndarray, Sample]:
    """A prediction and its sample: ground, blocks of every class before it, sky above."""
    rng = lane(number, "picture")
    row = np.arange(size)[:, None] * np.ones((1, size), int)
    depth = np.where(row > size // 2, 8.0 * size / (row - size // 2 + 0.5), 200.0)
    seg = np.where(row > size // 2, LABELS["ground"], LABELS["sky"])
    for label in range(2, len(LABELS)):
        y, x = rng.integers(0, size - 20, 2)
        block = np.s_[y : y + rng.integers(3, 60), x : x + rng.integers(3, 60)]
        depth[block] = np.minimum(depth[block], rng.uniform(5, 180))
        seg[block] = label
    depth = np.minimum(depth, 200).astype(np.float32)
    wrong = 0.1 * np.sin(row / 9 + number) + rng.normal(0, 0.02, depth.shape)
    sample = Sample(
        key=str(number),
        rgb=np.zeros((size, size, 3), np.uint8),
        depth_m=depth,
        valid=np.ones(depth.shape, bool),
        max_depth_m=200.0,
        intrinsics=Intrinsics.from_fov(size, size, 90).matrix,
        seg=seg.astype(np.uint8),
        meta={"map": "blocks", "condition": "clear", "altitude_m": 8.0, "speed_mps": 9.0},
    )
    return (depth * np.exp(wrong)).astype(np.float32), sample


def evaluate(pairs: int, size: int) -> dict[str, float]:
    """One process's share: seconds that passed and that it computed, memory early and late [MB]."""
    pictures = [made_up(number, size) for number in range(_DIFFERENT)]
    breakdown, histogram, early = Breakdown(), ErrorHistogram(), 0.0
    started, began = time.perf_counter(), time.process_time()
    for number in range(pairs):
        prediction, sample = pictures[number % _DIFFERENT]
        scene = {"scene_seed": number // _PAIRS_PER_SCENE}
        breakdown.add(prediction, dataclasses.replace(sample, meta=sample.meta | scene))
        histogram.add(prediction, sample.depth_m, sample.valid)
        if number == pairs // 10:
            early = _peak_mb()
    seconds, computed = time.perf_counter() - started, time.process_time() - began
    assert breakdown.results()[0].images.images == pairs
    return {"wall_s": seconds, "cpu_s": computed, "early_mb": early, "end_mb": _peak_mb()}


def _peak_mb() -> float:
    # Linux gives kilobytes.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6


def main(options: Options) -> None:
    share = options.pairs // options.workers
    # Fresh processes: a fork would count this one's memory.
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(options.workers, mp_context=context) as pool:
        parts = list(
            pool.map(evaluate, [share] * options.workers, [options.size_px] * options.workers)
        )
    figures = {
        "pairs_per_s": round(share * options.workers / max(part["wall_s"] for part in parts), 1),
        # On a machine with other work the wall clock says little.
        "cpu_milliseconds_a_pair": round(
            1000 * float(np.mean([part["cpu_s"] for part in parts])) / share, 2
        ),
        "pairs": share * options.workers,
        "peak_mb_a_process": round(max(part["end_mb"] for part in parts), 1),
        "growth_mb_after_a_tenth": round(max(p["end_mb"] - p["early_mb"] for p in parts), 1),
    }
    print("\n".join(f"{name} {value}" for name, value in figures.items()))
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
