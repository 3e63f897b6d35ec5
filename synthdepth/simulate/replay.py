"""One recorded flight, flown again: what the drone saw and chose, frame by frame."""

import dataclasses
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

from synthdepth.config import shown
from synthdepth.errors import DatasetError, RecipeError
from synthdepth.simulate.drone import DroneConfig
from synthdepth.simulate.flight import Decision, Rules
from synthdepth.simulate.outcome import Outcome
from synthdepth.simulate.planner import PlannerConfig
from synthdepth.simulate.scenario import ScenarioRanges
from synthdepth.simulate.scene import SceneFlights
from synthdepth.simulate.sources import SourceName, make_source, parse_source
from synthdepth.simulate.store import SCENES, flown, read_settings, scene_file
from synthdepth.simulate.tables import ended

# What a flight is measured by, not what it did.
_YARDSTICK = ("shortest_m", "excess")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Frame:
    """A moment of a flight.

    Attributes:
        number: of the frame.
        time_s: since take-off.
        world_from_cam: (4, 4) float64.
        velocity_mps: (3,) float64.
        altitude_m: above ground.
        rgb: (H, W, 3) uint8, the camera's picture, whether or not the source looked at it.
        depth_m: (h, w) float32 [m], what the source said.
        section: row and column of the section that was flown to.
    """

    number: int
    time_s: float
    world_from_cam: np.ndarray
    velocity_mps: np.ndarray
    altitude_m: float
    rgb: np.ndarray
    depth_m: np.ndarray
    section: tuple[int, int]


class Replay:
    """A recorded flight, ready to be flown again.

    Args:
        stage: as `run.Stage`, of the recipe that the folder names.
        folder: of the simulation; it need not be finished.
        source: name of the source.
        scene_index, scenario: which flight.

    Attributes:
        recorded: its outcome.
        rules: how it was flown.
        max_depth_m: range of the source.
        scene: where.

    Raises:
        DatasetError: the folder holds no such flight, or the model that flew it has changed.
        SynthdepthError: the model cannot be read.
    """

    def __init__(
        self,
        stage,
        folder: Path,
        *,
        source: str,
        scene_index: int,
        scenario: int,
    ):
        settings = read_settings(folder)
        self.rules = rules_of(settings["rules"])
        named = _named_source(Path(folder), settings["sources"], source)
        self.recorded = _recorded(Path(folder), stage.map, source, scene_index, scenario)
        self._source = make_source(named, batch=self.rules.batch)
        self.max_depth_m = self._source.max_depth_m
        seed = self.recorded.scene_seed
        self.scene = SceneFlights(stage, scene_index, seed, [scenario], self.rules)

    def fly(self, on_frame: Callable[[Frame], None]) -> None:
        """Fly it.

        Args:
            on_frame: told of each frame.

        Raises:
            DatasetError: it was not as recorded.
        """
        eyes = self.scene.place.eyes

        def watch(decision: Decision) -> None:
            look, sample = decision.look, decision.sample
            if self._source.sees != "rgb":
                sample = eyes.sample("rgb", look, None)
            on_frame(
                Frame(
                    number=look.frame,
                    time_s=look.frame * self.rules.drone.frame_interval_s,
                    world_from_cam=look.world_from_cam,
                    velocity_mps=look.velocity_mps,
                    altitude_m=look.altitude_m,
                    rgb=sample.rgb,
                    depth_m=decision.depth_m,
                    section=decision.section,
                )
            )

        (fields,) = self.scene.fly(self._source, [self.recorded.scenario], watch)
        again = Outcome(source=self.recorded.source, **fields)
        now, then = (dataclasses.asdict(flight) for flight in (again, self.recorded))
        if differ := [name for name in then if now[name] != then[name] and name not in _YARDSTICK]:
            raise DatasetError(
                f"the flight was not as recorded ({', '.join(differ)}): now {ended(again)}, then "
                f"{ended(self.recorded)}; another version or machine?"
            )


def rules_of(table: Mapping) -> Rules:
    """The rules that a simulation's settings hold.

    Raises:
        RecipeError: a value is not allowed.
    """
    kinds = {"drone": DroneConfig, "planner": PlannerConfig, "scenario": ScenarioRanges}
    if not isinstance(table, Mapping):
        raise RecipeError(f"rules are {shown(table)}: allowed is a table of keys")
    parts = {name: kind.from_table(table.get(name), name) for name, kind in kinds.items()}
    return Rules.from_table({**table, **parts}, "rules")


def _named_source(folder: Path, known: Mapping[str, Mapping], name: str) -> SourceName:
    if name not in known:
        raise DatasetError(f"--source {name}: {folder} holds flights of {', '.join(known)}")
    recorded = SourceName(**known[name])
    now = parse_source(f"{name}={recorded.what}")
    if now != recorded:
        raise DatasetError(
            f"--source {name}: {recorded.what} is not the model that flew: its SHA-256 has changed"
        )
    return recorded


def _recorded(folder: Path, map_name: str, source: str, scene: int, scenario: int) -> Outcome:
    path = scene_file(folder, SCENES, map_name, scene, ".jsonl")
    flights = flown(path)
    if (source, scenario) not in flights:
        there = sorted(k for name, k in flights if name == source)
        has = f"scenarios {there[0]} to {there[-1]} of it" if there else "no flight of it"
        raise DatasetError(
            f"--source {source} --scene {scene} --scenario {scenario}: {folder} holds {has}"
        )
    return flights[source, scenario]
