"""A scene that is ready to be flown in: built, loaded into the renderer, its scenarios drawn."""

import dataclasses
import functools
import time
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.dataset.sample import Sample
from synthdepth.maps.world import World
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import lane
from synthdepth.simulate.collision import Mesh
from synthdepth.simulate.eyes import Eyes
from synthdepth.simulate.flight import Decision, Place, Rules, fly
from synthdepth.simulate.scenario import Scenario, draw_scenario
from synthdepth.simulate.shortest import free_ways, shortest_way, until_circle, way_length
from synthdepth.simulate.sources import DepthSource
from synthdepth.simulate.survey import survey


class SceneFlights:
    """A scene's flights.

    Args:
        stage: as `run.Stage`.
        scene_index, scene_seed: which scene.
        numbers: of its scenarios; each has a lane of its own.
        rules: how they are flown.

    Attributes:
        place: the scene.
        condition: its light and weather.
        scenarios: by their numbers.
        view: the scene from above, a `survey.TopView`.
        build_s: time that the world, its tree of triangles and the scenarios took.
        survey_s: time that the view and the shortest ways took.
    """

    def __init__(
        self, stage, scene_index: int, scene_seed: int, numbers: Sequence[int], rules: Rules
    ):
        started = time.perf_counter()
        world = stage.build(scene_seed)
        mesh = Mesh.of_world(world)
        bounds = np.asarray(world.flight_bounds, np.float64)
        self.condition = world.light.condition
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
        drawn = [
            draw_scenario(
                lane(scene_seed, "simulate-scenario", number),
                number,
                mesh,
                bounds,
                world.ground_m,
                rules.scenario,
                rules.drone.radius_m,
            )
            for number in numbers
        ]
        built = time.perf_counter()
        self.view, self.scenarios = self._surveyed(drawn)
        self.build_s, self.survey_s = built - started, time.perf_counter() - built

    def _surveyed(self, scenarios: Sequence[Scenario]):
        """The view from above, and the scenarios by their numbers with their shortest ways."""
        place, ranges, radius = self.place, self._rules.scenario, self._rules.drone.radius_m
        view, air = survey(
            place.mesh,
            place.bounds + [[-ranges.beyond_m], [ranges.beyond_m]],
            place.ground_m,
            altitude_m=ranges.altitude_m,
            radius_m=radius,
        )
        is_free = free_ways(place.mesh, place.ground_m, ranges.altitude_m, radius)
        known = {}
        for one in scenarios:
            if one.blocked_by is None:
                straight = np.stack([one.start_m, one.goal_m])
                way = until_circle(straight, one.goal_m, ranges.goal_radius_m)
            else:
                way = shortest_way(one.start_m, one.goal_m, ranges.goal_radius_m, air, is_free)
            shortest = None if way is None else round(way_length(way), 3)
            known[one.number] = dataclasses.replace(one, shortest_m=shortest)
        return view, known

    def fly(
        self,
        source: DepthSource,
        numbers: Sequence[int],
        watch: Callable[[Decision], None] = lambda decision: None,
    ) -> Iterator[dict]:
        """Fly some scenarios by their numbers; yields and tells as `flight.fly` does."""
        chosen = [self.scenarios[number] for number in numbers]
        return fly(chosen, source, self.place, self._rules, watch)


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
