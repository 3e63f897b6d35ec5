"""What fills a city's blocks: lots that fit, heights that vary, sound meshes on the ground."""

import numpy as np
import pytest
import shapely

from synthdepth.maps.downtown.blocks import USES, CityBlocks, build_blocks, plan_blocks
from synthdepth.maps.downtown.fill import GROUND_M
from synthdepth.maps.downtown.grid import draw_grid
from synthdepth.maps.geometry import merge
from synthdepth.maps.materials.catalogue import CATALOGUE
from synthdepth.maps.world import LABELS


def planned(seed: int) -> CityBlocks:
    rng = np.random.default_rng(seed)
    grid = draw_grid(
        rng,
        block_length_m=110,
        block_depth_m=70,
        avenue_share=0.35,
        drop_share=0.1,
        layout="diagonal",
    )
    return plan_blocks(
        rng,
        grid,
        storeys_range=(3, 40),
        core_storeys=22,
        core_m=220,
        park_share=0.06,
        plaza_share=0.06,
        parking_share=0.05,
        construction=2,
    )


@pytest.fixture(scope="module")
def plan() -> CityBlocks:
    return planned(4)


@pytest.fixture(scope="module")
def sample(plan) -> CityBlocks:
    """One block of each use."""
    blocks = tuple(plan.of(use)[0] for use in USES if plan.of(use))
    return CityBlocks(blocks=blocks, street=plan.street)


@pytest.fixture(scope="module")
def model(sample):
    return built(sample, 1)


def built(plan: CityBlocks, seed: int):
    bounds = np.array([[-40.0, -40.0], [40.0, 40.0]])
    return merge(build_blocks(np.random.default_rng(seed), plan, bounds))


def test_blocks_cover_what_streets_leave(plan):
    areas = [b.area for b in plan.blocks]
    land = shapely.union_all(areas)
    assert np.isclose(land.area, sum(a.area for a in areas), rtol=1e-3)
    assert land.intersection(plan.street).area < 60
    assert len(plan.of("site")) == 2
    assert all(plan.of(use) for use in ("park", "plaza", "car_park"))


def test_buildings_stand_apart_on_their_lots(plan):
    lots = [lot for lot in plan.lots if lot.built]
    walls = shapely.polygons([shapely.LinearRing(lot.footprint) for lot in lots])
    assert all(shapely.LinearRing(lot.footprint).is_ccw for lot in lots)
    assert np.allclose(shapely.area(walls), shapely.area(shapely.convex_hull(walls)))
    assert shapely.area(shapely.union_all(walls)) > sum(shapely.area(walls)) - 1.0
    assert shapely.intersection(shapely.union_all(walls), plan.street).area < 1.0


def test_low_roofs_stand_beside_towers(plan):
    storeys = np.array([lot.storeys for lot in plan.lots if lot.built])
    assert 0.2 < (storeys <= 5).mean() < 0.5
    assert storeys.max() >= 20
    assert storeys.min() < 3


def test_meshes_are_sound_and_stand_on_the_ground(model):
    for (material, label), part in model.items():
        assert material in CATALOGUE
        assert label in LABELS
        tri = part.triangles.astype(np.float64)
        area = np.linalg.norm(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1) / 2
        assert area.min() > 1e-9, (material, label)
        # Crowns may reach into the ground; nothing else may by more than its footing.
        deepest = -4.0 if label == "vegetation" else -1.0
        assert part.vertices[:, 2].min() > deepest, (material, label)
    assert np.allclose(model["paving", "pavement"].vertices[:, 2].min(), GROUND_M)


def test_same_seed_same_bytes(sample, model):
    again, other = built(sample, 1), built(sample, 2)
    assert model.keys() == again.keys()
    assert all(model[k].vertices.tobytes() == again[k].vertices.tobytes() for k in model)
    assert any(
        k not in other or model[k].vertices.tobytes() != other[k].vertices.tobytes() for k in model
    )
