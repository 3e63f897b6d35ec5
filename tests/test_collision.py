"""Swept spheres against triangles: contact times, distances, and that nothing is flown through."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.maps.geometry import box, join, quads, tube
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane
from synthdepth.simulate.collision import Mesh
from synthdepth.simulate.triangles import first_touch, segment_distance
from tests.conftest import flat_world, ground, wall

RADIUS = 0.35
SEEDS = st.integers(0, 2**32)


def mesh_of(geometry, label="building"):
    return Mesh(geometry.triangles, np.full(len(geometry.faces), LABELS[label]))


def contact(mesh, start, end, radius=RADIUS):
    share, triangle = mesh.first_contact(np.array([start]), np.array([end]), radius)
    return float(share[0]), int(triangle[0])


def point_distances(points, triangle):
    """Distances (n,) of points to a triangle, apart from the code under test: by the barycentric
    coordinates of the foot, found by least squares, else the nearest place of each edge."""
    a, b, c = triangle
    sides = np.stack([b - a, c - a], axis=1)
    weights = np.linalg.lstsq(sides, (points - a).T, rcond=None)[0]
    inside = (weights >= 0).all(axis=0) & (weights.sum(axis=0) <= 1)
    foot = a + (sides @ weights).T
    away = [np.where(inside, np.linalg.norm(points - foot, axis=1), np.inf)]
    for p, q in ((a, b), (b, c), (c, a)):
        t = np.clip((points - p) @ (q - p) / max((q - p) @ (q - p), 1e-300), 0, 1)
        away.append(np.linalg.norm(points - p - t[:, None] * (q - p), axis=1))
    return np.minimum.reduce(away)


def random_pair(seed):
    """A segment and a triangle near it, now and then parallel to it, thin or without area."""
    rng = lane(seed, "pair")
    triangle = rng.normal(size=(3, 3)) * rng.choice([0.1, 1, 4])
    start, end = rng.normal(size=(2, 3)) * rng.choice([0.5, 2, 5])
    kind = rng.integers(6)
    if kind == 1:
        end = start + (triangle[1] - triangle[0]) * rng.uniform(0.2, 2)
    elif kind == 2:
        triangle[2] = triangle[0] + 0.3 * (triangle[1] - triangle[0])
    elif kind == 3:
        end[2] = start[2] = triangle[:, 2] = 0.0
    elif kind == 4:
        triangle[1] = triangle[2] = triangle[0]
    return start, end, triangle


@settings(deadline=None, max_examples=300)
@given(SEEDS)
def test_distance_and_contact_agree_with_fine_sampling(seed):
    start, end, triangle = random_pair(seed)
    length = np.linalg.norm(end - start)
    shares = np.linspace(0, 1, 2001)
    away = point_distances(start + shares[:, None] * (end - start), triangle)
    one = start[None], end[None], triangle[None]
    exact = float(segment_distance(*one)[0])
    # Halfway between two samples it can be nearer by at most half their spacing.
    assert exact <= away.min() + 1e-9
    assert exact >= away.min() - length / 4000 - 1e-9
    touch = float(first_touch(start[None], end[None], RADIUS, triangle[None])[0])
    assert np.isfinite(touch) == (exact <= RADIUS) or abs(exact - RADIUS) < 1e-9
    if np.isfinite(touch):
        at = start + touch * (end - start)
        reached = float(point_distances(at[None], triangle)[0])
        assert reached <= RADIUS + 1e-7
        assert touch == 0 or reached == pytest.approx(RADIUS, abs=1e-7)
        assert (away[shares < touch - 1e-9] > RADIUS - 1e-7).all()


def test_a_wall_is_met_when_its_distance_is_flown():
    mesh = Mesh.of_world(flat_world([ground(), wall(50.0)]))
    share, triangle = contact(mesh, [0, 0, 10], [100, 0, 10])
    assert share == pytest.approx((50 - RADIUS) / 100, abs=1e-12)
    assert mesh.label_name(triangle) == "building"
    # Aslant at 60 degrees the sphere comes nearer by radius / cos.
    end = np.array([100, 100 * math.tan(math.radians(60)), 10.0])
    share, _ = contact(Mesh.of_world(flat_world([wall(50.0, half_m=200.0)])), [0, 0, 10], end)
    assert share == pytest.approx((50 - RADIUS) / 100, abs=1e-12)
    share, triangle = contact(mesh, [0, 0, 10], [0, 0, -30])
    assert share == pytest.approx((10 - RADIUS) / 40) and mesh.label_name(triangle) == "ground"


@pytest.mark.parametrize(("wider_m", "passes"), [(0.02, True), (1e-6, True), (-1e-6, False)])
def test_a_gap_is_passed_only_if_it_is_wider_than_the_drone(wider_m, passes):
    half = RADIUS + wider_m / 2
    # At the origin, where float32 corners are fine enough.
    sides = [
        quads([[[0, y, -9], [0, y + s * 9, -9], [0, y + s * 9, 9], [0, y, 9]]])
        for s, y in ((1, half), (-1, -half))
    ]
    share, _ = contact(mesh_of(join(sides)), [-5, 0, 0], [5, 0, 0])
    assert np.isinf(share) == passes
    edges = Mesh.distance(mesh_of(join(sides)), [[-5, 0, 0]], [[5, 0, 0]], 1.0)[0]
    assert edges[0] == pytest.approx(half, abs=1e-6)


@pytest.mark.parametrize("step_s", [0.005, 0.02, 0.1, 1.0])
def test_a_wire_of_five_centimetres_is_not_missed(step_s):
    wire = tube([[30, -20, 8], [30, 20, 8]], 0.025, sides=64)
    mesh = mesh_of(wire, "wire")
    x = np.arange(0, 60, 22.2 * step_s)
    way = np.column_stack([x, 0 * x, 0 * x + 8.0])
    share, triangle = mesh.first_contact(way[:-1], way[1:], RADIUS)
    step = int(np.flatnonzero(np.isfinite(share))[0])
    assert (step + share[step]) * step_s * 22.2 == pytest.approx(30 - 0.025 - RADIUS, abs=1e-4)
    assert mesh.label_name(triangle[step]) == "wire"
    over = way + [0, 0, 0.025 + RADIUS + 1e-3]
    assert np.isinf(mesh.first_contact(over[:-1], over[1:], RADIUS)[0]).all()


@settings(deadline=None, max_examples=100)
@given(SEEDS, st.floats(0.001, 3.0))
def test_nothing_is_tunnelled_through_at_any_step(seed, step_s):
    """The first contact of a way at 22.2 m/s is in the same place however it is cut into steps, and
    a way that crosses a triangle always has one."""
    rng = lane(seed, "tunnel")
    corners = rng.normal(size=(3, 3)) * 10 ** rng.uniform(-2, 1, (3, 1))
    weights = rng.dirichlet(np.ones(3))
    start = rng.normal(size=3) * 8
    end = start + 2 * (weights @ corners - start)  # through a place of the triangle
    mesh = Mesh(corners[None], [1])
    length = np.linalg.norm(end - start)
    cuts = np.append(np.arange(0, length, 22.2 * step_s), length) / length
    way = start + cuts[:, None] * (end - start)
    share = mesh.first_contact(way[:-1], way[1:], 0.05)[0]
    hit = np.flatnonzero(np.isfinite(share))
    assert len(hit)
    first = cuts[hit[0]] + share[hit[0]] * (cuts[hit[0] + 1] - cuts[hit[0]])
    whole, _ = contact(mesh, start, end, 0.05)
    assert first == pytest.approx(whole, abs=1e-6)
    assert whole <= 0.5


def soup(seed, count=700):
    """Triangles of all sizes, two of them larger than everything else together."""
    rng = lane(seed, "soup")
    middle = rng.uniform(-10, 10, (count, 1, 3))
    corners = middle + rng.normal(size=(count, 3, 3)) * 10 ** rng.uniform(-2, 0.5, (count, 1, 1))
    huge = [
        [[-900, -900, -3], [900, -900, -3], [0, 900, -3]],
        [[40, -900, 0], [40, 900, 0], [40, 0, 900]],
    ]
    return np.concatenate([corners, huge]).astype(np.float32)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_the_tree_finds_what_comparing_all_pairs_finds(seed):
    triangles = soup(seed)
    mesh = Mesh(triangles, np.zeros(len(triangles)))
    rng = lane(seed, "ways")
    start = rng.uniform(-12, 12, (60, 3))
    end = start + rng.normal(size=(60, 3)) * 10 ** rng.uniform(-1, 1.5, (60, 1))
    pairs = [np.repeat(x, len(triangles), axis=0) for x in (start, end)]
    every = np.tile(mesh.triangles.astype(np.float64), (60, 1, 1))
    touch = first_touch(*pairs, RADIUS, every).reshape(60, -1)
    share, which = mesh.first_contact(start, end, RADIUS)
    np.testing.assert_array_equal(share, touch.min(axis=1))
    hit = np.isfinite(share)
    assert 10 < hit.sum() < 60
    np.testing.assert_array_equal(which[hit], touch.argmin(axis=1)[hit])
    assert (which[~hit] == -1).all()
    away = segment_distance(*pairs, every).reshape(60, -1)
    near, which = mesh.distance(start, end, 1.5)
    np.testing.assert_array_equal(near, np.where(away.min(axis=1) <= 1.5, away.min(axis=1), np.inf))
    within = rng.uniform(0.01, 3, 60)
    near = mesh.distance(start, end, within)[0]
    np.testing.assert_array_equal(
        near, np.where(away.min(axis=1) <= within, away.min(axis=1), np.inf)
    )


def test_touching_from_the_start_is_at_once():
    mesh = mesh_of(box((1, 1, 1)))
    assert contact(mesh, [0.6, 0, 0.5], [5, 0, 0.5])[0] == 0
    # Inside a box larger than the sphere nothing touches until its wall.
    large = mesh_of(box((10, 10, 10)))
    assert contact(large, [0, 0, 5], [10, 0, 5])[0] == pytest.approx((5 - RADIUS) / 10)
    assert contact(large, [0, 0, 5], [0, 0, 5])[0] == np.inf
    assert contact(large, [4.8, 0, 5], [4.8, 0, 5])[0] == 0


def test_a_mesh_keeps_what_is_near_the_flight_area_with_its_labels():
    far = {("card", "hill"): box((5, 5, 5), base=(500, 0, 0))}
    mesh = Mesh.of_world(flat_world([ground(), wall(20.0), far]))
    assert len(mesh.triangles) == 4
    assert set(mesh.labels) == {LABELS["ground"], LABELS["building"]}
    none = Mesh(np.zeros((0, 3, 3)), np.zeros(0))
    assert contact(none, [0, 0, 0], [1, 0, 0]) == (np.inf, -1)
