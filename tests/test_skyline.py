"""The distant town: in its ring, true to scale, all around, and never twice the same."""

import numpy as np
import pytest

from synthdepth.maps.materials.catalogue import CATALOGUE
from synthdepth.maps.skyline import skyline
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane

INNER_M, OUTER_M, TALLEST_M, COUNT = 900.0, 2200.0, 120.0, 300


def town(seed=4, **options):
    return skyline(
        lane(seed, "skyline"), INNER_M, OUTER_M, tallest_m=TALLEST_M, count=COUNT, **options
    )


@pytest.fixture(scope="module")
def model():
    return town()


def vertices(model, *labels):
    return np.concatenate([part.vertices for (_, label), part in model.items() if label in labels])


def test_materials_and_labels_are_known_and_triangles_are_few_and_whole(model):
    assert all(name in CATALOGUE and label in LABELS for name, label in model)
    assert 3_000 < sum(len(part.faces) for part in model.values()) < 16_000
    for part in model.values():
        a, b, c = part.triangles.astype(np.float64).transpose(1, 0, 2)
        assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() > 1e-3


def test_it_keeps_to_its_ring_and_stands_in_the_ground(model):
    everything = np.concatenate([part.vertices for part in model.values()])
    reach = np.hypot(everything[:, 0], everything[:, 1])
    assert INNER_M <= reach.min() < INNER_M + 100
    assert OUTER_M - 300 < reach.max() <= OUTER_M
    assert vertices(model, "building")[:, 2].min() < -2.0


def test_the_tallest_roof_is_as_tall_as_asked_and_most_are_low(model):
    roofs = model["concrete", "roof"].triangles[::2, :, 2].max(axis=1)
    plant_m = 5.0
    assert TALLEST_M <= roofs.max() <= TALLEST_M + plant_m
    assert np.median(roofs) < 0.5 * TALLEST_M


def test_no_direction_is_a_void(model):
    """Some roof in every sector of 30 degrees, seen from the middle."""
    built = vertices(model, "building")
    sector = (np.degrees(np.arctan2(built[:, 1], built[:, 0])) // 30).astype(int)
    top = np.array([built[sector == k, 2].max() for k in range(-6, 6)])
    assert top.min() > 5.0
    assert top.max() > 2 * top.min()


def test_panes_shine_towards_the_map(model):
    a, b, c = model["glass", "building"].triangles.astype(np.float64).transpose(1, 0, 2)
    normal = np.cross(b - a, c - a)
    outward = np.einsum("ni,ni->n", normal, a)
    outward /= np.linalg.norm(normal, axis=1) * np.linalg.norm(a, axis=1)
    # A wall seen edge-on from the middle may turn its far end away by a hair.
    assert outward.max() < 0.06
    assert (outward < 0).mean() > 0.98


def test_it_follows_the_ground(model):
    raised = town(ground_m=lambda xy: np.full(len(xy), 40.0))
    for key, part in model.items():
        np.testing.assert_allclose(raised[key].vertices, part.vertices + [0, 0, 40.0], atol=1e-3)


def test_a_seed_always_builds_the_same_town_and_others_build_others(model):
    def digest(parts):
        return [(key, part.vertices.tobytes(), part.tint.tobytes()) for key, part in parts.items()]

    assert digest(town()) == digest(model)
    assert digest(town(5)) != digest(model)
