"""A scene that is ready to be flown in: built, loaded into the renderer, its scenarios drawn."""

import functools
import time
from collections.abc import Iterator, Sequence

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.dataset.sample import Sample
from synthdepth.maps.world import World
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import lane
from synthdepth.simulate.collision import Mesh
from synthdepth.simulate.eyes import Eyes
from synthdepth.simulate.flight import Place, Rules, fly
from synthdepth.simulate.scenario import draw_scenario
from synthdepth.simulate.sources import DepthSource


class SceneFlights:
    """A scene's flights.

    Args:
        stage: as `run.Stage`.
        scene_index, scene_seed: which scene.
        count: number of scenarios.
        rules: how they are flown.

    Attributes:
        place: the scene.
        scenarios: the first `count` of it; each has a lane of its own.
    """

    def __init__(self, stage, scene_index: int, scene_seed: int, count: int, rules: Rules):
        world = stage.build(scene_seed)
        mesh = Mesh.of_world(world)
        bounds = np.asarray(world.flight_bounds, np.float64)
        self.scenarios = [
            draw_scenario(
                lane(scene_seed, "simulate-scenario", number),
                number,
                mesh,
                bounds,
                world.ground_m,
                rules.scenario,
                rules.drone.radius_m,
            )
            for number in range(count)
        ]
        self._rules = rules
        self.place = Place(
            map=stage.map,
            scene_index=scene_index,
            scene_seed=scene_seed,
            bounds=bounds,
            ground_m=world.ground_m,
            mesh=mesh,
            eyes=Eyes(
                functools.partial(_load, world, stage.camera, stage.render),
                camera=stage.camera,
                scene_seed=scene_seed,
                sensor=stage.sensor,
                at_night=world.light.lamps_on,
                max_depth_m=stage.render.max_depth_m,
                frame_interval_s=rules.drone.frame_interval_s,
            ),
        )

    @property
    def sight_s(self) -> float:
        """Time spent so far on loading the scene and rendering what sources see."""
        return self.place.eyes.spent_s

    def fly(self, source: DepthSource, scenarios: Sequence[int]) -> Iterator[dict]:
        """Fly some scenarios by their numbers; yields as `flight.fly` does."""
        return fly([self.scenarios[k] for k in scenarios], source, self.place, self._rules)


def _load(world: World, camera: Intrinsics, settings: RenderSettings):
    # Only now: a scene in which nobody sees anything needs no renderer.
    from synthdepth.render.renderer import load_world

    return load_world(world, camera, settings)


class TimedSource:
    """A source that counts the time it takes.

    Attributes:
        max_depth_m, sees: the source's.
        spent_s: time so far.
    """

    def __init__(self, source: DepthSource):
        self._source, self.spent_s = source, 0.0
        self.max_depth_m, self.sees = source.max_depth_m, source.sees

    def depth_m(self, samples: Sequence[Sample]) -> np.ndarray:
        """What the source says."""
        start = time.perf_counter()
        depth = self._source.depth_m(samples)
        self.spent_s += time.perf_counter() - start
        return depth
