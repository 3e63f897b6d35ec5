"""Speed of simulated flights: flights/s by source, where the time goes, what table 6 would cost.

python tools/simulation_throughput.py --maps blocks city --source 10m 200m ours=runs/embed \
    --flights 10 --json simulation.json
"""

import dataclasses
import json
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path

import tyro

from synthdepth.cli.simulating import stage_of
from synthdepth.errors import SynthdepthError
from synthdepth.production.overrides import with_overrides
from synthdepth.production.pool import run_jobs
from synthdepth.production.recipe import load_recipe
from synthdepth.production.run import default_workers, usable_cores
from synthdepth.render.backend import choose
from synthdepth.simulate.flight import Rules
from synthdepth.simulate.planner import PlannerConfig
from synthdepth.simulate.run import simulate
from synthdepth.simulate.sources import parse_source
from synthdepth.simulate.spent import Spent, read_spent
from synthdepth.simulate.store import TIMES

# Table 6 of the paper.
_FLIGHTS, _MAPS, _SOURCES = 400, 4, 4


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        maps: the maps.
        source: as `synthdepth simulate` has them.
        flights: of each source and map.
        flights_per_scene: scenarios of one scene; what a scene costs is shared by its flights.
        size: of the pictures; the recipe's by default.
        goal_pull: of the planner; at 0 flights last until their time is over.
        seed: everything is drawn from it.
        workers: processes.
        json: where the figures go.
    """

    maps: tuple[str, ...] = ("neighborhood",)
    source: tuple[str, ...] = ("10m", "200m", "triangulation")
    flights: int = 10
    flights_per_scene: int = 10
    size: str | None = None
    goal_pull: float = 0.1
    seed: int = 0
    workers: int = dataclasses.field(default_factory=default_workers)
    json: Path | None = None


def figures_of(spent: Mapping[str, Spent], scenes: int, flights_per_scene: int) -> dict:
    """The figures of a map.

    Args:
        spent: by source, of one map; what no single source took is at "".
        scenes: how many were flown in.
        flights_per_scene: of the table whose cost is projected.
    """
    scene_s = spent[""].scenes_s / scenes
    sources = {}
    for name, one in spent.items():
        if name:
            sources[name] = {
                "flights": one.flights,
                "frames_a_flight": round(one.frames / one.flights, 1),
                "flights_per_s": round(one.flights / one.flying_s, 4),
                "picture_ms_a_frame": round(1e3 * one.sight_s / one.frames, 2),
                "depth_ms_a_frame": round(1e3 * one.depth_s / one.frames, 2),
                "physics_ms_a_frame": round(1e3 * one.physics_s / one.frames, 2),
            }
    # Four sources, as dear as those that were measured are on average.
    flight_s = sum(1 / figures["flights_per_s"] for figures in sources.values()) / len(sources)
    table_s = _FLIGHTS / flights_per_scene * scene_s + _SOURCES * _FLIGHTS * flight_s
    return {
        "scene_s": {
            "build": round(spent[""].build_s / scenes, 2),
            "survey": round(spent[""].survey_s / scenes, 2),
            "load": round(spent[""].load_s / scenes, 2),
        },
        "sources": sources,
        "row_of_table_6_process_hours": round(table_s / 3600, 3),
    }


def measure(options: Options) -> dict:
    """Fly, and sum up."""
    figures = {}
    for name in options.maps:
        with tempfile.TemporaryDirectory() as folder:
            simulate(
                stage_of(with_overrides(load_recipe(name), size=options.size)),
                Path(folder) / "flights",
                flights=options.flights,
                sources=[parse_source(text) for text in options.source],
                run_jobs=run_jobs,
                backend=choose(),
                rules=Rules(planner=PlannerConfig(goal_pull=options.goal_pull)),
                flights_per_scene=options.flights_per_scene,
                seed=options.seed,
                workers=options.workers,
                threads=max(1, usable_cores() // max(options.workers, 1)),
            )
            times = sorted((Path(folder) / "flights" / TIMES).glob("*.jsonl"))
            figures[name] = figures_of(read_spent(times), len(times), options.flights_per_scene)
    rows = [one["row_of_table_6_process_hours"] for one in figures.values()]
    hours = _MAPS * sum(rows) / len(rows)
    return {
        "workers": options.workers,
        "maps": figures,
        "table_6_process_hours": round(hours, 2),
        "table_6_hours": round(hours / options.workers, 2),
    }


def text(figures: Mapping) -> str:
    """The figures as lines."""
    lines = []
    for name, one in figures["maps"].items():
        scene = ", ".join(f"{part} {s:g} s" for part, s in one["scene_s"].items())
        lines.append(f"{name}: a scene {scene}")
        for source, s in one["sources"].items():
            lines.append(
                f"  {source:24s} {s['flights_per_s']:.3f} flights/s, {s['frames_a_flight']:g} "
                f"frames each; a frame {s['picture_ms_a_frame']:g} ms picture, "
                f"{s['depth_ms_a_frame']:g} ms depth, {s['physics_ms_a_frame']:g} ms physics"
            )
    lines.append(
        f"table 6 ({_FLIGHTS} flights x {_MAPS} maps x {_SOURCES} sources): about "
        f"{figures['table_6_hours']:g} h with {figures['workers']} workers"
    )
    return "\n".join(lines)


def main(options: Options) -> int:
    try:
        figures = measure(options)
        if options.json:
            options.json.write_text(json.dumps(figures, indent=1) + "\n")
    except (SynthdepthError, OSError) as error:
        print(error, file=sys.stderr)
        return 2
    print(text(figures))
    return 0


if __name__ == "__main__":
    sys.exit(main(tyro.cli(Options, description=__doc__)))
