"""Sections of a depth picture, and which of them a drone flies to."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.camera import Intrinsics
from synthdepth.errors import RecipeError
from synthdepth.seeding import lane
from synthdepth.simulate.drone import Command, DroneConfig, advance, camera_rotations
from synthdepth.simulate.planner import Planner, PlannerConfig, Sight, Situation
from synthdepth.simulate.sections import section_means, section_minima, section_rays

CAMERA = Intrinsics.from_fov(90, 72, 90.0)
SIZES = [(18, 18), (36, 54), (17, 23), (37, 50), (5, 7)]


def share(low, high, pixel):
    """Length of a pixel that lies between two borders."""
    return max(0.0, min(high, pixel + 1) - max(low, pixel))


def looped_sections(depth_m, whole):
    """`whole` of the (depth, area) of the pixels of each section, by plain loops."""
    height, width = depth_m.shape
    out = np.empty((17, 17))
    for i in range(17):
        for j in range(17):
            y, x = (i * height / 18, (i + 2) * height / 18), (j * width / 18, (j + 2) * width / 18)
            inside = []
            for v in range(math.floor(y[0]), min(math.ceil(y[1]) + 1, height)):
                for u in range(math.floor(x[0]), min(math.ceil(x[1]) + 1, width)):
                    area = share(*y, v) * share(*x, u)
                    if area > 1e-9:
                        inside.append((depth_m[v, u], area))
            out[i, j] = whole(inside)
    return out


@pytest.mark.parametrize("size", SIZES)
def test_sections_agree_with_plain_loops(size):
    depth = lane(1, "sections").uniform(0, 200, size)
    area = size[0] * size[1] / 81
    total = looped_sections(depth, lambda inside: sum(d * a for d, a in inside))
    np.testing.assert_allclose(section_means(depth), total / area, rtol=1e-11)
    least = looped_sections(depth, lambda inside: min(d for d, _ in inside))
    np.testing.assert_array_equal(section_minima(depth), least)


@pytest.mark.parametrize("size", SIZES)
def test_what_saturates_everywhere_is_equal_everywhere(size):
    depth = np.full((3, *size), np.float32(200))
    np.testing.assert_allclose(section_means(depth), 200, rtol=1e-12)
    assert section_means(depth).shape == section_minima(depth).shape == (3, 17, 17)


def test_sections_overlap_by_halves_and_fill_the_picture():
    rays = section_rays(CAMERA)
    np.testing.assert_allclose(np.linalg.norm(rays, axis=-1), 1)
    np.testing.assert_allclose(rays[8, 8], [0, 0, 1], atol=1e-15)
    # 90 degrees wide: the borders lie at x / z = -1 and 1, half a section beyond the outer centres.
    x = rays[8, :, 0] / rays[8, :, 2]
    np.testing.assert_allclose(x, np.linspace(-8 / 9, 8 / 9, 17), atol=1e-15)
    np.testing.assert_allclose(rays[::-1, ::-1, :2], -rays[..., :2], atol=1e-15)


def situation(count=1, *, goal=(1000.0, 0.0, 10.0), altitude=10.0, speed=20.0, yaw=0.0):
    return Situation(
        position_m=np.tile([0.0, 0.0, 10.0], (count, 1)),
        yaw_rad=np.full(count, yaw),
        altitude_m=np.full(count, altitude),
        goal_m=np.tile(np.array(goal, np.float64), (count, 1)),
        cruise_mps=np.full(count, speed),
    )


def planner(drone=None, altitude_m=(2.0, 60.0), **config):
    # Climbs as steeply as it flies, so that up and down are as free as left and right.
    drone = drone or DroneConfig(max_climb_mps=40.0)
    return Planner(PlannerConfig(**config), drone, CAMERA, altitude_m)


def scene(near_m=20.0, far_m=200.0, **open_part):
    """A wall right ahead that leaves a part of the picture open."""
    depth = np.full((72, 90), near_m, np.float32)
    depth[open_part.get("rows", slice(None)), open_part.get("columns", slice(None))] = far_m
    return depth[None]


@pytest.mark.parametrize("rule", ["total", "nearest", "goal"])
@pytest.mark.parametrize(
    ("opening", "axis", "sign"),
    [
        ({"columns": slice(0, 30)}, 1, 1),  # left is +y when looking along +x
        ({"columns": slice(60, 90)}, 1, -1),
        ({"rows": slice(0, 24)}, 2, 1),
        ({"rows": slice(48, 72)}, 2, -1),
    ],
)
def test_the_open_side_is_chosen(rule, opening, axis, sign):
    now = situation(altitude=30.0)
    command = planner(rule=rule).command(scene(**opening), 200.0, now)
    velocity = command.velocity_mps[0]
    assert sign * velocity[axis] > 4
    assert abs(velocity[3 - axis]) < 1e-9
    # The section that it tells is the one that it flies to: x forward, y left, z up.
    right, down, forward = section_rays(CAMERA)[tuple(command.section[0])]
    np.testing.assert_allclose(velocity / 20.0, [forward, -right, -down], atol=1e-9)


def test_a_camera_of_ten_metres_does_not_see_the_wall():
    now, depth = situation(), scene(columns=slice(0, 30))
    ahead = planner().command(depth, 10.0, now)
    np.testing.assert_allclose(ahead.velocity_mps, [[20, 0, 0]], atol=1e-9)
    assert ahead.yaw_rad[0] == pytest.approx(0, abs=1e-12)
    assert planner().command(depth, 200.0, now).velocity_mps[0, 1] > 4


@pytest.mark.parametrize("yaw_deg", [0.0, 130.0])
@pytest.mark.parametrize(
    ("goal_deg", "expected_deg"), [(0, 0), (20, 18.4), (-20, -18.4), (80, 41.6), (-170, -41.6)]
)
def test_where_all_is_equal_the_goal_decides(yaw_deg, goal_deg, expected_deg):
    turn = math.radians(yaw_deg + goal_deg)
    goal = (1000 * math.cos(turn), 1000 * math.sin(turn), 10.0)
    now = situation(goal=goal, yaw=math.radians(yaw_deg))
    command = planner().command(np.full((1, 72, 90), 200.0), 200.0, now)
    # The nearest section's centre: x / z is a multiple of 1/9.
    off = math.degrees(command.yaw_rad[0]) - yaw_deg
    assert (off + 180) % 360 - 180 == pytest.approx(expected_deg, abs=0.1)


def test_the_largest_total_wins_and_the_largest_minimum_sees_the_wire():
    depth = scene(near_m=100.0, columns=slice(55, 65))
    depth[0, :, 60] = 5.0  # a wire down the middle of the open part
    now = situation()
    total = planner().command(depth, 200.0, now).velocity_mps[0]
    nearest = planner(rule="nearest").command(depth, 200.0, now).velocity_mps[0]
    assert 44.5 - 45 * total[1] / total[0] == pytest.approx(59.5)
    column = round(44.5 - 45 * nearest[1] / nearest[0])
    assert depth[0, 36, column - 5 : column + 6].min() == 100


def test_the_goal_rule_goes_where_it_can_still_turn_aside():
    rule = planner(rule="goal", speed="sight")
    turn = float(rule.turn_m(np.array([20.0]))[0])
    assert turn == pytest.approx(0.35 + 0.5 + 20 * 0.2 + 20**2 / 8)
    assert rule.command(scene(near_m=turn + 1), 200.0, situation()).yaw_rad[0] == pytest.approx(0)
    aside = rule.command(scene(near_m=turn - 1, columns=slice(0, 30)), 200.0, situation())
    assert aside.yaw_rad[0] > 0.2
    # Nowhere to go: slowly, where it is least near.
    closed = rule.command(scene(near_m=5.0, far_m=8.0, columns=slice(0, 30)), 200.0, situation())
    speed = np.linalg.norm(closed.velocity_mps)
    assert closed.yaw_rad[0] > 0.2 and float(rule.halt_m(speed)) == pytest.approx(8.0)


def test_the_goals_pull_outweighs_depth_by_its_amount():
    # Ahead 120 m, left 200 m: 0.4 of the range more. The goal at 40 degrees to the right.
    depth = scene(near_m=120.0, columns=slice(0, 20))
    now = situation(goal=(766.0, -643.0, 10.0))
    assert planner().command(depth, 200.0, now).yaw_rad[0] > 0.3
    assert planner(goal_pull=1.0).command(depth, 200.0, now).yaw_rad[0] < -0.3


def test_altitudes_are_kept_to():
    free = np.full((1, 72, 90), 200.0)
    high = planner(altitude_m=(2.0, 30.0))
    up = (1000.0, 0.0, 1000.0)
    assert high.command(free, 200.0, situation(goal=up, altitude=15.0)).velocity_mps[0, 2] > 10
    at_top = high.command(free, 200.0, situation(goal=up, altitude=30.0)).velocity_mps[0]
    assert at_top[2] == pytest.approx(0) and at_top[0] > 19
    assert high.command(free, 200.0, situation(altitude=0.5)).velocity_mps[0, 2] >= 1.5
    weak = planner(DroneConfig(max_climb_mps=3.0))
    assert weak.command(free, 200.0, situation(goal=up)).velocity_mps[0, 2] <= 3


def test_a_section_that_cannot_be_flown_to_is_not_chosen():
    # Open sky and walls, on the right less near: at its ceiling the drone cannot climb out.
    depth = scene(near_m=30.0, rows=slice(0, 20))
    depth[0, 20:, 70:] = 60.0
    command = planner(altitude_m=(2.0, 10.0)).command(depth, 200.0, situation())
    assert command.yaw_rad[0] < -0.4


@settings(deadline=None, max_examples=30)
@given(st.integers(0, 10**6), st.sampled_from(["total", "nearest", "goal"]))
def test_many_drones_are_told_what_each_is_told_alone(seed, rule):
    rng = lane(seed, "drones")
    depth = rng.uniform(1, 260, (4, 40, 50))
    now = Situation(
        position_m=rng.uniform(-50, 50, (4, 3)),
        yaw_rad=rng.uniform(-4, 4, 4),
        altitude_m=rng.uniform(1, 40, 4),
        goal_m=rng.uniform(-50, 50, (4, 3)),
        cruise_mps=rng.uniform(2, 22.2, 4),
    )
    plan = planner(rule=rule, goal_pull=0.2, speed="sight", altitude_m=(2.0, 30.0))
    together = plan.command(depth, 200.0, now)
    for k in range(4):
        parts = {f.name: getattr(now, f.name)[k : k + 1] for f in dataclasses.fields(now)}
        alone = plan.command(depth[k : k + 1], 200.0, Situation(**parts))
        np.testing.assert_allclose(together.velocity_mps[k], alone.velocity_mps[0], atol=1e-12)
        np.testing.assert_allclose(together.yaw_rad[k], alone.yaw_rad[0], atol=1e-12)


def test_choice_agrees_with_a_plain_search():
    rng = lane(2, "choice")
    plan = planner(rule="total", goal_pull=0.3)
    mean, least, cosine = rng.uniform(0, 1, (3, 20, 17, 17))
    flyable = rng.uniform(size=(20, 17, 17)) < 0.2
    sight = Sight(
        mean_share=mean, least_share=least, toward_goal=cosine, needed_share=np.full(20, 0.5)
    )
    rows, columns = plan.choose(sight, flyable)
    for k in range(20):
        best = max(
            ((i, j) for i in range(17) for j in range(17) if flyable[k, i, j]),
            key=lambda at: mean[k][at] + 0.3 * cosine[k][at],
        )
        assert best == (rows[k], columns[k])


@given(st.floats(0.5, 22.2))
def test_a_drone_halts_within_the_way_that_it_is_said_to_need(speed):
    drone = DroneConfig()
    plan = planner(drone, margin_m=0.0)
    way = float(plan.halt_m(np.array([speed]))[0])
    assert float(plan.halting_mps(np.array([way]))[0]) == pytest.approx(speed)
    late = round(drone.reaction_s / drone.step_s)
    on, stop = (
        Command(velocity_mps=np.array([[v, 0.0, 0.0]]), yaw_rad=np.zeros(1)) for v in (speed, 0.0)
    )
    commands = [on] * late + [stop] * 200
    motion = advance(np.zeros((1, 3)), np.array([[speed, 0.0, 0.0]]), np.zeros(1), commands, drone)
    x = motion.position_m[:, 0, 0]
    assert motion.velocity_mps[-1, 0, 0] == pytest.approx(0)
    # The last step of braking may be a part of one.
    assert x.max() + drone.radius_m == pytest.approx(way, abs=drone.step_s**2 * 8)


@given(st.integers(0, 10**6))
def test_motion_keeps_to_its_limits(seed):
    rng, drone = lane(seed, "motion"), DroneConfig()
    commands = [
        Command(velocity_mps=rng.uniform(-22, 22, (3, 3)), yaw_rad=rng.uniform(-9, 9, 3))
        for _ in range(30)
    ]
    motion = advance(np.zeros((3, 3)), np.zeros((3, 3)), np.zeros(3), commands, drone)
    acceleration = np.linalg.norm(np.diff(motion.velocity_mps, axis=0), axis=-1) / drone.step_s
    assert acceleration.max() <= drone.max_acceleration_mps2 * (1 + 1e-9)
    turn = np.abs(np.diff(motion.yaw_rad, axis=0)).max() / drone.step_s
    assert math.degrees(turn) <= drone.max_yaw_rate_dps * (1 + 1e-9)
    mean = (motion.velocity_mps[1:] + motion.velocity_mps[:-1]) / 2
    np.testing.assert_allclose(np.diff(motion.position_m, axis=0), mean * drone.step_s, atol=1e-12)


@pytest.mark.parametrize("pitch_deg", [0.0, -20.0, -90.0])
def test_the_camera_looks_ahead_level(pitch_deg):
    rotation = camera_rotations(np.array([0.0, 1.0, -2.5]), pitch_deg)
    np.testing.assert_allclose(np.linalg.det(rotation), 1)
    np.testing.assert_allclose(rotation[:, 2, 2], math.sin(math.radians(pitch_deg)), atol=1e-12)
    np.testing.assert_allclose(rotation[:, 2, 0], 0, atol=1e-12)  # the horizon is level
    np.testing.assert_allclose(np.arctan2(rotation[1, 1, 0], rotation[1, 0, 0]), 1 - math.pi / 2)


def test_bad_settings_are_refused():
    with pytest.raises(RecipeError, match="rule = 'best': allowed are total, nearest, goal"):
        PlannerConfig(rule="best")
    with pytest.raises(RecipeError, match="latency_s = 0.05: allowed are whole numbers of step_s"):
        DroneConfig(latency_s=0.05)
