"""Plants: true to scale, rooted, distinct in outline, repeatable, and affordable at distance."""

import numpy as np
import pytest

from synthdepth.maps.geometry import join
from synthdepth.maps.vegetation.shrubs import bushes, flowers, grass_tufts, hedge
from synthdepth.maps.vegetation.trees import DETAILS, SPECIES, draw_tree, plant, tree
from synthdepth.maps.world import LABELS


def areas(part) -> np.ndarray:
    a, b, c = np.moveaxis(part.triangles.astype(np.float64), 1, 0)
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def digest(surfaces) -> list[bytes]:
    return [getattr(g, f).tobytes() for _, g in sorted(surfaces.items()) for f in g.__annotations__]


def triangle_count(surfaces) -> int:
    return sum(len(g.faces) for g in surfaces.values())


def check_sound(surfaces):
    for (material, label), part in surfaces.items():
        assert material in {"leaf", "bark"}
        assert label in LABELS
        assert part.vertices.dtype == part.uv.dtype == part.tint.dtype == np.float32
        assert part.faces.dtype == np.int32
        assert len(part.vertices) == len(part.uv) == len(part.tint)
        assert part.faces.min() >= 0
        assert part.faces.max() < len(part.vertices)
        assert np.isfinite(part.vertices).all()
        assert np.isfinite(part.uv).all()
        assert areas(part).min() > 1e-7
        assert part.tint.min() > 0
        assert part.tint.max() < 1


@pytest.mark.parametrize("species", SPECIES)
def test_tree_has_its_size_and_stands_in_the_ground(species):
    params = draw_tree(np.random.default_rng(3), species)
    model = tree(params)
    check_sound(model)
    v = join(model.values()).vertices
    assert -0.5 < v[:, 2].min() < -0.1
    # Clumps jut out of the crown, and a palm's fronds arch over its crown shaft.
    assert v[:, 2].max() == pytest.approx(params.height_m, rel=0.15, abs=0.8)
    reach = np.percentile(np.hypot(v[:, 0], v[:, 1]), 99)
    assert 0.65 * params.crown_radius_m < reach < 1.5 * params.crown_radius_m + 0.3
    foot = model["bark", "tree_trunk"].vertices
    foot = foot[foot[:, 2] < 0.05]
    assert np.hypot(foot[:, 0], foot[:, 1]).max() < 2 * params.trunk_radius_m


@pytest.mark.parametrize("species", [s for s in SPECIES if not SPECIES[s].leafless])
def test_trunk_is_bare_below_the_crown(species):
    params = draw_tree(np.random.default_rng(4), species)
    z = tree(params)["leaf", "vegetation"].vertices[:, 2]
    hanging = SPECIES[species].hang_m + SPECIES[species].clump_m[0]
    if SPECIES[species].habit == "puffs":
        assert z.min() > params.clear_m - hanging - 0.3
    assert z.min() > -0.3


def test_crowns_are_dense_but_porous():
    leaf = tree(draw_tree(np.random.default_rng(5), "oak"))["leaf", "vegetation"]
    rng = np.random.default_rng(0)
    corner = rng.dirichlet([1, 1, 1], (len(leaf.faces), 200))
    seen = np.einsum("ijk,ikl->ijl", corner, leaf.triangles).reshape(-1, 3)[:, [0, 2]]
    low, high = np.percentile(seen, [15, 85], axis=0)
    inside = seen[((seen > low) & (seen < high)).all(axis=1)]
    filled = 0.05**2 * len(np.unique(np.floor(inside / 0.05), axis=0)) / np.prod(high - low)
    assert 0.6 < filled < 0.97


def test_trees_repeat_and_differ():
    params = draw_tree(np.random.default_rng(7), "maple")
    assert params == draw_tree(np.random.default_rng(7), "maple")
    assert params != draw_tree(np.random.default_rng(8), "maple")
    assert digest(tree(params)) == digest(tree(params))


def test_unknown_species_names_the_known():
    with pytest.raises(KeyError, match=r"baobab.*birch"):
        draw_tree(np.random.default_rng(0), "baobab")
    with pytest.raises(KeyError, match=r"baobab.*birch"):
        plant(np.random.default_rng(0), np.zeros((1, 3)), np.array(["baobab"]), np.zeros(1))


@pytest.mark.parametrize("species", SPECIES)
def test_detail_falls_with_distance_but_the_crown_stays(species):
    near = [0.0, 30.0, 100.0, 200.0, 1000.0]
    planted = [
        plant(np.random.default_rng(2), [[5.0, 6.0, 7.0]], np.array([species]), np.array([d]), 1)
        for d in near
    ]
    for surfaces in planted:
        check_sound(surfaces)
    counts = [triangle_count(s) for s in planted]
    assert counts == sorted(counts, reverse=True)
    assert counts[3] <= 120
    assert 20 <= counts[4] <= 40
    key = ("bark", "tree_trunk") if SPECIES[species].leafless else ("leaf", "vegetation")
    full, *rest = [s[key] for s in planted]
    for part in rest:
        if key[0] == "leaf":
            assert areas(part).sum() == pytest.approx(areas(full).sum(), rel=0.35)
    tops = [join(s.values()).vertices[:, 2].max() - 7 for s in planted]
    assert tops == pytest.approx(np.full(5, tops[0]), rel=0.25)


def forest(count, near_count, seed=1):
    rng = np.random.default_rng(seed)
    positions = np.column_stack([rng.uniform(-500, 500, (count, 2)), rng.uniform(0, 9, count)])
    near = np.where(np.arange(count) < near_count, 0.0, rng.uniform(0, 700, count))
    return positions, rng.choice(list(SPECIES), count), near


def test_a_square_kilometre_is_affordable():
    planted = plant(np.random.default_rng(3), *forest(2500, 900))
    assert triangle_count(planted) <= 1.8e6


def test_planting_repeats_and_sets_every_tree_on_its_foot():
    positions, species, near = forest(40, 20)
    once = plant(np.random.default_rng(3), positions, species, near, templates=2)
    assert digest(once) == digest(
        plant(np.random.default_rng(3), positions, species, near, templates=2)
    )
    assert digest(once) != digest(
        plant(np.random.default_rng(4), positions, species, near, templates=2)
    )
    bark = once["bark", "tree_trunk"].vertices
    for x, y, z in positions:
        close = bark[np.hypot(bark[:, 0] - x, bark[:, 1] - y) < 1.0]
        assert -0.8 < close[:, 2].min() - z < -0.1


def test_every_tier_is_farther_and_sparser():
    assert [d.beyond_m for d in DETAILS] == sorted(d.beyond_m for d in DETAILS)
    assert [d.most for d in DETAILS] == sorted((d.most for d in DETAILS), reverse=True)


def test_bushes_have_their_width():
    surfaces = bushes(np.random.default_rng(1), [[10.0, 20.0, 3.0]] * 30, np.full(30, 1.4))
    check_sound(surfaces)
    v = surfaces["leaf", "vegetation"].vertices - [10, 20, 3]
    assert -0.3 < v[:, 2].min() < 0.05
    assert 0.5 < np.percentile(np.hypot(v[:, 0], v[:, 1]), 98) < 1.0
    assert v[:, 2].max() < 1.4 * 2.6
    far = bushes(np.random.default_rng(1), [[0.0, 0.0, 0.0]] * 30, np.full(30, 1.4), 300.0)
    assert triangle_count(far) < 0.3 * triangle_count(surfaces)
    assert digest(surfaces) == digest(
        bushes(np.random.default_rng(1), [[10.0, 20.0, 3.0]] * 30, np.full(30, 1.4))
    )


def test_hedge_follows_its_path():
    path = np.array([[0.0, 0, 0], [10, 0, 1], [10, 8, 1]])
    surfaces = hedge(np.random.default_rng(1), path, 1.2, 0.7)
    check_sound(surfaces)
    v = surfaces["leaf", "vegetation"].vertices
    low, high = v.min(axis=0), v.max(axis=0)
    assert low[0] > -0.7
    assert high[0] < 11
    assert low[1] > -0.9
    assert high[1] < 8.7
    assert 2.1 < high[2] < 2.6
    assert low[2] > -0.3
    inside = (v[:, 0] < 9) & (v[:, 1] > 1)
    assert not inside.any()
    assert triangle_count(hedge(np.random.default_rng(1), path, 1.2, 0.7, 300.0)) < 0.3 * len(
        surfaces["leaf", "vegetation"].faces
    )


def test_hedge_core_faces_outward():
    surfaces = hedge(np.random.default_rng(1), [[0.0, 0, 0], [6.0, 0, 0]], 1.0, 0.6)
    core = surfaces["leaf", "vegetation"].triangles[: 11 * 5 * 2 + 0].astype(np.float64)
    normal = np.cross(core[:, 1] - core[:, 0], core[:, 2] - core[:, 0])
    outward = core.mean(axis=1) - [0, 0, 0.45]
    outward[:, 0] = 0
    sides = np.abs(normal[:, 0]) < 0.5 * np.linalg.norm(normal, axis=1)
    assert ((normal * outward).sum(axis=1)[sides] > 0).mean() > 0.95


@pytest.mark.parametrize(("make", "least", "most"), [(grass_tufts, 3, 5), (flowers, 10, 10)])
def test_small_plants(make, least, most):
    rng = np.random.default_rng(2)
    positions = np.column_stack([rng.uniform(0, 50, (2000, 2)), np.full(2000, 4.0)])
    surfaces = make(np.random.default_rng(2), positions, 0.2)
    check_sound(surfaces)
    assert least * 2000 <= triangle_count(surfaces) <= most * 2000
    v = join(surfaces.values()).vertices
    assert 3.9 < v[:, 2].min() < 4.0
    assert 4.15 < v[:, 2].max() < 4.4
    assert digest(surfaces) == digest(make(np.random.default_rng(2), positions, 0.2))
    assert digest(surfaces) != digest(make(np.random.default_rng(3), positions, 0.2))


def test_grass_is_ground():
    assert list(grass_tufts(np.random.default_rng(0), np.zeros((5, 3)), 0.2)) == [
        ("leaf", "ground")
    ]


def test_nothing_planted_is_nothing():
    none = np.zeros((0, 3))
    rng = np.random.default_rng(0)
    assert triangle_count(plant(rng, none, np.array([], str), np.zeros(0))) == 0
    assert triangle_count(bushes(rng, none, np.zeros(0))) == 0
    assert triangle_count(grass_tufts(rng, none, np.zeros(0))) == 0
