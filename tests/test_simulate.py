"""Closed-loop flights: the physics of their ends, sources side by side, and runs that go on."""

import dataclasses
import functools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from scipy import stats

from synthdepth.camera import Intrinsics
from synthdepth.errors import DatasetError, FlightError, SynthdepthError
from synthdepth.maps.geometry import box, join, quads, tube
from synthdepth.production.pool import Finished, Progress, Restarted, run_jobs
from synthdepth.render.sensor import SensorRanges
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import lane
from synthdepth.simulate.collision import Mesh
from synthdepth.simulate.drone import DroneConfig
from synthdepth.simulate.eyes import Eyes
from synthdepth.simulate.flight import Place, Rules, fly
from synthdepth.simulate.outcome import (
    TABLE_6,
    Outcome,
    compare_sources,
    mcnemar,
    summarise,
    wilson_interval,
)
from synthdepth.simulate.planner import PlannerConfig
from synthdepth.simulate.run import HTML, MARKDOWN, Stage, simulate
from synthdepth.simulate.scenario import Scenario, ScenarioRanges, draw_scenario
from synthdepth.simulate.sources import Blind, DepthCamera, Predicted, make_source, parse_source
from synthdepth.simulate.store import FLIGHTS, MAPS, RESULTS, TABLE, read_flights
from tests.conftest import flat_world, ground, wall

CAMERA = Intrinsics.from_fov(36, 36, 90.0)


class Raycaster:
    """A renderer for a handful of triangles: every ray against every triangle."""

    camera, exposure = CAMERA, 1.0

    def __init__(self, world):
        self.triangles = np.concatenate([g.triangles for g in world.surfaces.values()])

    def planar_depth(self, world_from_cam):
        """By Möller and Trumbore."""
        rays = CAMERA.rays().reshape(-1, 1, 3) @ world_from_cam[:3, :3].T
        a, b, c = self.triangles.astype(np.float64).transpose(1, 0, 2)
        p, s = np.cross(rays, c - a), world_from_cam[:3, 3] - a
        q, scale = np.cross(s, b - a), (p * (b - a)).sum(axis=-1)
        with np.errstate(divide="ignore", invalid="ignore"):
            u, v = (p * s).sum(axis=-1) / scale, (rays * q).sum(axis=-1) / scale
            t = (q * (c - a)).sum(axis=-1) / scale
            hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
        depth = np.where(hit, t, np.inf).min(axis=1)
        return depth.reshape(CAMERA.height, CAMERA.width).astype(np.float32)

    def radiance(self, world_from_cam, seed, motion):
        """Grey that falls with distance, and noise by the seed."""
        near = 1 / (1 + np.nan_to_num(self.planar_depth(world_from_cam), posinf=1e6) / 10)
        grey = near + 0.01 * lane(seed, "grain").uniform(size=near.shape)
        return np.repeat(grey[..., None], 3, axis=2).astype(np.float32)


def place_of(models):
    world = flat_world([ground(), *models])
    eyes = Eyes(
        functools.partial(Raycaster, world),
        camera=CAMERA,
        scene_seed=5,
        sensor=SensorRanges(),
        at_night=False,
        max_depth_m=200.0,
        frame_interval_s=0.1,
    )
    return Place(
        map="test",
        scene_index=0,
        scene_seed=5,
        bounds=world.flight_bounds,
        ground_m=world.ground_m,
        mesh=Mesh.of_world(world),
        eyes=eyes,
    )


def ask(number=0, *, start=(0.0, 0.0, 8.0), goal=(80.0, 0.0, 8.0), speed=20.0, limit=60.0, yaw=0.0):
    return Scenario(
        number=number,
        start_m=np.array(start),
        goal_m=np.array(goal),
        yaw_rad=yaw,
        speed_mps=speed,
        time_limit_s=limit,
        blocked_by=None,
        shortest_m=math.dist(start[:2], goal[:2]) - 5,
    )


def flown(models, *scenarios, source=None, rules=None):
    return list(fly(scenarios, source or Blind(), place_of(models), rules or Rules()))


def seconds_to(distance_m, speed, drone):
    """Time to fly a way from rest: latency, even acceleration, then cruise."""
    a = drone.max_acceleration_mps2
    if distance_m < speed**2 / (2 * a):
        return drone.latency_s + math.sqrt(2 * distance_m / a)
    return drone.latency_s + speed / a + (distance_m - speed**2 / (2 * a)) / speed


@pytest.mark.parametrize("speed", [3.0, 12.0, 20.0, 22.2])
@pytest.mark.parametrize("step_s", [0.02, 0.1])
@pytest.mark.parametrize("latency_s", [0.0, 0.1, 0.3])
def test_straight_at_a_wall_it_collides_at_the_computed_time(speed, step_s, latency_s):
    drone = DroneConfig(step_s=step_s, latency_s=latency_s)
    (end,) = flown([wall(40.0)], ask(speed=speed), rules=Rules(drone=drone))
    assert (end["end"], end["hit"]) == ("collision", "building")
    expected = seconds_to(40 - drone.radius_m, speed, drone)
    # The step in which it reaches its speed is not all acceleration.
    assert end["time_s"] == pytest.approx(expected, abs=step_s**2)
    np.testing.assert_allclose(end["end_m"], [40 - drone.radius_m, 0, 8], atol=0.01)
    assert end["hit_speed_mps"] == pytest.approx(speed)
    assert end["way_m"] == pytest.approx(40 - drone.radius_m, abs=1e-3)
    assert (end["clearance_m"], end["excess"]) == (0.0, None)
    assert end["effort_m_s3"] * end["way_m"] == pytest.approx(speed * 8, abs=8**2 * step_s)


def test_a_goal_is_reached_when_its_circle_is_entered():
    rules = Rules()
    (end,) = flown([], ask())
    assert end["end"] == "goal"
    way = 80 - rules.scenario.goal_radius_m
    assert end["time_s"] == pytest.approx(seconds_to(way, 20.0, rules.drone), abs=1e-3)
    assert end["excess"] == pytest.approx(0, abs=1e-4)
    assert end["goal_speed_mps"] == pytest.approx(way / end["time_s"], rel=1e-3)
    assert end["clearance_m"] == 5.0
    assert len(end["track_m"]) == math.ceil(round(end["time_s"] / 0.1, 6))


def test_clearance_is_the_least_distance_on_the_way():
    post = {("card", "pole"): box((1, 1, 30), base=(33.3, 3.5, 0))}
    (end,) = flown([post], ask())
    assert end["end"] == "goal"
    assert end["clearance_m"] == pytest.approx(3.0 - 0.35, abs=1e-4)
    # What lies behind the goal's circle is not flown past.
    post = {("card", "pole"): box((1, 1, 30), base=(76.6, 3.5, 0))}
    (end,) = flown([post], ask())
    assert end["clearance_m"] == pytest.approx(math.hypot(1.1, 3.0) - 0.35, abs=1e-3)


def test_time_and_bounds_end_a_flight():
    (end,) = flown([], ask(goal=(900.0, 0.0, 8.0), limit=1.23))
    assert (end["end"], end["time_s"]) == ("time", pytest.approx(1.24))
    (end,) = flown([], ask(goal=(900.0, 0.0, 8.0)))
    assert end["end"] == "bounds"
    assert 130 <= end["end_m"][0] <= 130 + 20 * 0.02 + 0.01


@pytest.mark.parametrize("step_s", [0.02, 0.1])
def test_a_wire_kills(step_s):
    wire = {("card", "wire"): tube([[30, -20, 8.2], [30, 20, 8.2]], 0.025, sides=8)}
    rules = Rules(drone=DroneConfig(step_s=step_s))
    (end,) = flown([wire], ask(speed=22.2), rules=rules)
    assert (end["end"], end["hit"]) == ("collision", "wire")
    higher = {("card", "wire"): tube([[30, -20, 8.5], [30, 20, 8.5]], 0.025, sides=8)}
    assert flown([higher], ask(speed=22.2), rules=rules)[0]["end"] == "goal"


@pytest.mark.parametrize(("gap_m", "end"), [(0.72, "goal"), (0.68, "collision")])
def test_a_gap_is_passed_only_if_it_is_wider_than_the_drone(gap_m, end):
    y = gap_m / 2
    corners = [
        [[40, s * y, 0], [40, s * (y + 30), 0], [40, s * (y + 30), 40], [40, s * y, 40]]
        for s in (1, -1)
    ]
    slot = {("card", "building"): quads(corners)}
    assert flown([slot], ask())[0]["end"] == end


def screen():
    """A wall in the way, with free air beside it."""
    return {("card", "building"): box((1, 30, 60), base=(20, 0, 0))}


@pytest.mark.parametrize("rule", ["total", "nearest", "goal"])
def test_who_sees_far_flies_around_what_kills_who_does_not(rule):
    rules = Rules(planner=PlannerConfig(rule=rule, goal_pull=0.05))
    # Off the middle: the rules have no memory, and right before it they waver between the sides.
    far = ask(start=(-60.0, 4.0, 8.0), goal=(95.0, 0.0, 8.0), speed=22.2)
    ends = {
        range_m: flown([screen()], far, source=DepthCamera(max_depth_m=range_m), rules=rules)[0]
        for range_m in (10.0, 200.0)
    }
    assert (ends[10.0]["end"], ends[200.0]["end"]) == ("collision", "goal")
    assert 0.01 < ends[200.0]["excess"] < 0.5
    assert max(abs(y) for _, y, _ in ends[200.0]["track_m"]) > 15


def test_a_drone_that_halts_within_its_sight_lives_by_ten_metres():
    rules = Rules(planner=PlannerConfig(rule="goal", speed="sight"))
    ends = [
        flown([wall(20.0)], ask(speed=speed, limit=30.0), source=DepthCamera(max_depth_m=10.0),
              rules=rules)[0]
        for speed in (3.0, 22.2)
    ]  # fmt: skip
    assert [end["end"] for end in ends] == ["time", "time"]
    assert all(0.3 < end["clearance_m"] < 0.6 for end in ends)


def test_a_flight_is_the_same_whoever_flies_beside_it():
    asks = [
        ask(k, goal=(80.0, y, 8.0), speed=v, yaw=0.3 * y / 10, limit=2.5 + 0.3 * k)
        for k, (y, v) in enumerate([(0, 20), (15, 9), (-20, 22.2), (30, 14)])
    ]
    seen = []

    def predict(samples):
        seen.append(len(samples))
        return np.stack([200.0 * (1 - sample.rgb[..., 0] / 255.0) for sample in samples])

    for source in (
        DepthCamera(max_depth_m=60.0),
        Predicted(predict=predict, max_depth_m=200.0, batch=3),
    ):
        flights = []
        for lockstep in (1, 3):
            ends = flown([screen()], *asks, source=source, rules=Rules(lockstep=lockstep))
            flights.append(sorted(ends, key=lambda e: e["scenario"]))
        assert flights[0] == flights[1]
    assert set(seen) == {3}


def test_a_model_sees_its_own_last_frame():
    shown = []

    def predict(samples):
        shown.extend(samples)
        return np.full((len(samples), 10, 12), 200.0)

    flown([wall(90.0)], ask(limit=0.5), source=Predicted(predict=predict, max_depth_m=200.0))
    first, *later = shown
    np.testing.assert_array_equal(first.prev, first.rgb)
    for before, now in zip(shown, later, strict=False):
        np.testing.assert_array_equal(now.prev, before.rgb)
        np.testing.assert_array_equal(now.world_from_cam_prev, before.world_from_cam)
        assert not now.valid.any() and not now.depth_m.any()
    assert later[-1].world_from_cam[0, 3] > 0.1
    assert later[0].meta == {"dt_s": 0.1, "altitude_m": 8.0}


def test_scenarios_start_and_end_in_the_open():
    hall = box((60, 60, 30), base=(0, 0, -1))
    world = flat_world([ground(), {("card", "building"): hall}])
    mesh, ranges = Mesh.of_world(world), ScenarioRanges(distance_m=(40.0, 150.0))
    drawn = [
        draw_scenario(
            lane(3, "scenario", k), k, mesh, world.flight_bounds, world.ground_m, ranges, 0.35
        )
        for k in range(40)
    ]
    for s in drawn:
        for point in (s.start_m, s.goal_m):
            away = np.maximum(np.abs(point[:2]) - 30, 0)
            assert np.hypot(*away) >= 3.0 and (np.abs(point[:2]) <= 100).all()
            assert 2 <= point[2] <= 20
        assert 40 <= s.straight_m <= 150 and 10 <= s.speed_mps <= 22.2
        toward = math.atan2(*(s.goal_m - s.start_m)[1::-1])
        assert abs((s.yaw_rad - toward + math.pi) % (2 * math.pi) - math.pi) <= math.radians(30.1)
        # Does the straight way pass the hall's square?
        way = s.start_m[:2] + np.linspace(0, 1, 400)[:, None] * (s.goal_m - s.start_m)[:2]
        assert (s.blocked_by == "building") == (np.abs(way).max(axis=1) < 30.2).any()
    assert 5 < sum(s.blocked_by is not None for s in drawn) < 35
    closed = dataclasses.replace(ranges, room_m=50.0, altitude_m=(2.0, 3.0))
    with pytest.raises(FlightError, match="50 m of room"):
        draw_scenario(lane(3, "s"), 0, mesh, world.flight_bounds, world.ground_m, closed, 0.35)


@pytest.mark.parametrize(("count", "total"), [(0, 8), (3, 10), (29, 400), (400, 400), (1, 1)])
def test_wilson_intervals_and_mcnemar_are_those_of_scipy(count, total):
    expected = stats.binomtest(count, total).proportion_ci(0.95, "wilson")
    np.testing.assert_allclose(wilson_interval(count, total), expected, atol=1e-12)
    expected = stats.binomtest(count, total).pvalue
    assert mcnemar(count, total - count) == pytest.approx(expected)
    assert mcnemar(0, 0) == 1


def outcome(source, scenario, end):
    fields = {f.name: None for f in dataclasses.fields(Outcome)}
    given = {"map": "blocks", "scene_index": 0, "source": source, "scenario": scenario, "end": end}
    collided = end == "collision"
    figures = {"time_s": 2.0, "goal_speed_mps": 5.0, "effort_m_s3": 3.0}
    figures |= {"clearance_m": 0.0 if collided else 1.0, "hit_speed_mps": 9.0 if collided else None}
    return Outcome(**fields | given | figures | {"hit": "wire" if end == "collision" else None})


def test_summaries_count_and_compare_the_same_scenarios():
    ends = {"10m": ["collision"] * 6 + ["goal"] * 4, "200m": ["goal"] * 8 + ["collision", "time"]}
    flights = [outcome(s, k, end) for s, all_ in ends.items() for k, end in enumerate(all_)]
    # What flies straight into something is counted once more.
    flights[:8] = [dataclasses.replace(f, blocked_by="wall") for f in flights[:8]]
    ten, far = summarise(flights)
    assert (ten.blocked.count, ten.blocked.flights, far.blocked.flights) == (6, 8, 0)
    assert (ten.collision.value, far.collision.value, far.time.count) == (0.6, 0.1, 1)
    assert (ten.hits, far.goal.flights) == ({"wire": 6}, 10)
    assert (ten.time_to_collision_s, ten.hit_speed_mps, ten.clearance_m) == (2.0, 9.0, 1.0)
    (both,) = compare_sources(flights)
    assert (both.only_one, both.only_other, both.scenarios) == (6, 1, 10)
    assert both.p == pytest.approx(stats.binomtest(1, 7).pvalue)
    assert TABLE_6["blocks"] == (58.75, 7.0, 17.5, 14.5)


def tiny_world(scene_seed):
    rng = lane(scene_seed, "boxes")
    at = np.column_stack([rng.uniform(-90, 90, (25, 2)), np.zeros(25)])
    boxes = join([box((4, 4, 15), base=p) for p in at])
    return flat_world([ground(), {("card", "obstacle"): boxes}])


STAGE = Stage(
    map="tiny",
    build=tiny_world,
    camera=CAMERA,
    sensor=SensorRanges(model="ideal"),
    render=RenderSettings(spp=1),
    recipe={"map": "tiny"},
)
SHORT = Rules(scenario=ScenarioRanges(distance_m=(30.0, 80.0)))
BLIND = [parse_source("blind"), parse_source("other=blind")]


def here(function, jobs, workers):
    """Runs jobs in this process."""
    for number, job in enumerate(jobs):
        told = []
        result = function(job, told.append)
        yield from (Progress(number, done) for done in told)
        yield Finished(number, result)


def run(folder, **options):
    options = {"flights": 7, "sources": BLIND, "run_jobs": here} | options
    common = {"backend": None, "rules": SHORT, "flights_per_scene": 4, "seed": 4}
    return simulate(STAGE, folder, **common | options)


def files(folder):
    """All that must have the same bytes every time: everything but what tells times."""
    maps = sorted((Path(folder) / MAPS).iterdir())
    assert len(maps) == 4
    paths = [Path(folder) / name for name in (FLIGHTS, RESULTS, TABLE)] + maps
    return {path.name: path.read_bytes() for path in paths}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    folder = tmp_path_factory.mktemp("simulate") / "run"
    progress = []
    report = run(folder, on_progress=lambda done, total: progress.append((done, total)))
    assert report.flown == 14
    assert progress[0] == (0, 14) and progress[-1] == (14, 14) and progress == sorted(progress)
    return folder


def test_the_number_of_workers_changes_nothing(finished, tmp_path):
    report = run(tmp_path / "two", run_jobs=run_jobs, workers=2)
    assert report.flown == 14
    assert files(tmp_path / "two") == files(finished)


def test_sources_fly_the_same_scenarios_and_blind_ones_crash_where_the_way_is_blocked(finished):
    flights = read_flights(finished / FLIGHTS)
    one, other = flights[:7], flights[7:]
    for f in one:
        shortest = f.straight_m - SHORT.scenario.goal_radius_m
        assert f.shortest_m == pytest.approx(shortest, abs=1e-3 if f.blocked_by is None else 30)
        assert f.shortest_m > shortest - 1e-3
        if f.end == "goal":
            assert f.excess == pytest.approx(f.way_m / f.shortest_m - 1, abs=1e-4)
    strip = [dataclasses.replace(f, source="") for f in one]
    assert strip == [dataclasses.replace(f, source="") for f in other]
    assert {f.source for f in other} == {"other"}
    assert len({tuple(f.start_m) for f in one}) == 7
    results = json.loads((finished / RESULTS).read_text())
    assert results["summaries"][0]["clearance_m"] > 0
    assert results["comparisons"][0]["p"] == 1.0
    assert results["paper_table_6"]["city"]["200 m"] == 26.0
    assert len((finished / TABLE).read_text().splitlines()) == 4
    assert "7 flights of each of 2 sources" in (finished / HTML).read_text()
    assert (finished / MARKDOWN).read_text().startswith("# Flights on tiny")


class Killed(Exception):
    pass


@pytest.mark.parametrize("after", [1, 4])
def test_a_killed_run_goes_on_and_ends_with_the_same_bytes(finished, tmp_path, after):
    folder, told = tmp_path / "killed", set()

    def killing(function, jobs, workers):
        def report(scene, done):
            told.add((scene, done))
            if sum(done > 0 for _, done in told) == after:
                raise Killed

        for job in jobs:
            function(job, functools.partial(report, job.scene_index))
            yield Progress(0, 0)

    with pytest.raises(Killed):
        run(folder, run_jobs=killing)
    (last,) = sorted((folder / "scenes").iterdir())[-1:]
    last.write_bytes(last.read_bytes() + b'{"map": "tiny", "sce')  # a line half written
    assert run(folder).flown == 14 - after
    assert files(folder) == files(finished)
    assert run(folder).flown == 0


def test_a_lost_worker_costs_no_flight_in_the_count(finished, tmp_path):
    told, lost = [], []

    def losing(function, jobs, workers):
        for number, job in enumerate(jobs):
            if not lost:
                function(dataclasses.replace(job, scenarios=2), lost.append)
                yield Progress(number, 2)
                yield Restarted(number, 0, "died", workers)
            yield Finished(number, function(job, lambda done: None))

    run(tmp_path, run_jobs=losing, on_progress=lambda done, total: told.append(done))
    assert files(tmp_path) == files(finished)
    assert told == sorted(told)


def test_more_flights_and_more_sources_extend_a_run(finished, tmp_path):
    folder = tmp_path / "grows"
    assert run(folder, flights=2, sources=BLIND[:1]).flown == 2
    assert run(folder, flights=2).flown == 2
    assert run(folder).flown == 10
    assert files(folder) == files(finished)


def test_another_run_is_refused(finished, tmp_path):
    with pytest.raises(DatasetError, match="holds flights with another seed"):
        run(finished, seed=5)
    with pytest.raises(DatasetError, match="holds flights with another rules"):
        run(finished, rules=dataclasses.replace(SHORT, drone=DroneConfig(radius_m=0.2)))
    with pytest.raises(DatasetError, match="flights of another source 'other'"):
        run(finished, sources=[parse_source("other=10m")])
    (tmp_path / "letter.txt").write_text("mine")
    with pytest.raises(DatasetError, match=r"holds 'letter.txt' and no simulation"):
        run(tmp_path)
    with pytest.raises(SynthdepthError, match="--flights 0: allowed is a whole number from 1"):
        run(tmp_path / "x", flights=0)
    with pytest.raises(SynthdepthError, match="each once"):
        run(tmp_path / "x", sources=BLIND[:1] * 2)
    assert not (tmp_path / "x").exists()


def test_sources_by_name(tmp_path):
    assert make_source(parse_source("12.5m"), batch=4).max_depth_m == 12.5
    assert make_source(parse_source("mine=ground"), batch=4).sees == "rgb"
    for wrong in ("0m", "10cm", "=10m", "x=", "no/such/model"):
        with pytest.raises(SynthdepthError, match="--source .*: .*allowed"):
            parse_source(wrong)
    (tmp_path / "notes.txt").write_text("no model")
    named = parse_source(f"ours={tmp_path / 'notes.txt'}")
    assert named.name == "ours" and len(named.sha256) == 64
    with pytest.raises(SynthdepthError, match=r"notes.txt: allowed is a .safetensors file"):
        make_source(named, batch=4)


def test_cameras_fly_by_what_the_renderer_shows(backend, tmp_path):
    sources = [parse_source("200m"), parse_source("triangulation")]
    report = run(tmp_path / "run", flights=1, sources=sources)
    flights = read_flights(tmp_path / "run" / FLIGHTS)
    assert [f.source for f in flights] == ["200m", "triangulation"]
    assert flights[0].end != "collision"
    assert report.spent.sight_s > 0 and report.spent.depth_s > 0
