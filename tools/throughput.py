"""Speed of a production run over everything: pairs/s, share inside the renderer, peak memory.

python tools/throughput.py --pairs 512 --workers 2 --json throughput.json
"""

import dataclasses
import json
import resource
import tempfile
from pathlib import Path

import numpy as np
import tyro

from synthdepth.dataset.manifest import read_manifest
from synthdepth.production.recipe import load_recipe
from synthdepth.production.run import render_dataset


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        map: the map.
        pairs: how many.
        seed: of the dataset.
        workers: processes.
        json: where the figures go.
    """

    map: str = "neighborhood"
    pairs: int = 512
    seed: int = 0
    workers: int = 2
    json: Path | None = None


def main(options: Options) -> None:
    with tempfile.TemporaryDirectory() as folder:
        report = render_dataset(
            load_recipe(options.map),
            Path(folder) / "set",
            pairs=options.pairs,
            seed=options.seed,
            workers=options.workers,
        )
        shards = read_manifest(report.folder)["shards"]
    costs = [shard["cost"] for shard in shards]
    figures = {
        "pairs_per_s": round(report.rendered / report.wall_s, 2),
        "wall_s": round(report.wall_s, 1),
        "render_share": round(report.render_share, 3),
        # Linux gives kilobytes, of the largest of all workers.
        "peak_worker_gb": round(
            resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / 1e9, 2
        ),
        "build_s_a_scene": round(float(np.median([cost["build_s"] for cost in costs])), 1),
        "flight_s_a_scene": round(float(np.median([cost["flight_s"] for cost in costs])), 1),
        "render_s_a_pair": round(
            float(np.median(np.concatenate([cost["render_s"] for cost in costs]))), 3
        ),
        "megabytes_a_pair": round(sum(s["bytes"] for s in shards) / report.pairs / 1e6, 3),
    }
    print("\n".join(f"{name} {value}" for name, value in figures.items()))
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
