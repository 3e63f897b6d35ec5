import numpy as np
import pytest
import shapely

from synthdepth.maps.geometry import Model
from synthdepth.maps.streets.graph import length_m
from synthdepth.maps.streets.markings import draw_street_markings, street_markings
from synthdepth.maps.streets.plan import along, draw_street_plan
from synthdepth.maps.streets.surface import (
    BEDDING_M,
    DROPPED_KERB_M,
    KERB_HEIGHT_M,
    street_surface,
)
from synthdepth.maps.terrain import draw_terrain, outskirts, tree_line
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane

SIZE_M = 520.0  # a quarter of a map keeps the tests fast


def small_plan(seed):
    return draw_street_plan(lane(seed, "streets"), size_m=SIZE_M)


def driveways_of(plan):
    made = []
    for lot in plan.lots:
        if lot.kind == "house":
            aside = np.array([-lot.inward[1], lot.inward[0]])
            c = lot.front + (lot.width_m / 2 - 3) * aside
            steps = [(-2, -5.5), (2, -5.5), (2, 8), (-2, 8)]
            made.append(np.array([c + a * aside + b * lot.inward for a, b in steps]))
    return made


@pytest.fixture(scope="module")
def terrain():
    return draw_terrain(lane(4, "terrain"), size_m=SIZE_M)


@pytest.fixture(scope="module")
def plan():
    return small_plan(4)


@pytest.fixture(scope="module")
def surface(plan, terrain) -> Model:
    return street_surface(plan, terrain, driveways_of(plan))


@pytest.fixture(scope="module")
def full_plan():
    return draw_street_plan(lane(7, "streets"))


def flat_area(part) -> np.ndarray:
    """Signed area seen from above of each triangle [m2]."""
    t = part.triangles.astype(np.float64)
    ab, ac = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    return (ab[:, 0] * ac[:, 1] - ab[:, 1] * ac[:, 0]) / 2


def bytes_of(model) -> bytes:
    return b"".join(
        a.tobytes()
        for key in sorted(model)
        for a in (model[key].vertices, model[key].faces, model[key].uv, model[key].tint)
    )


def test_the_site_is_gentle_and_hills_close_every_view():
    for seed in range(4):
        terrain = draw_terrain(lane(seed, "terrain"))
        axis = np.arange(-500, 501, 10.0)
        grid = np.stack(np.meshgrid(axis, axis, indexing="ij"), -1)
        height = terrain.height_m(grid.reshape(-1, 2)).reshape(len(axis), -1)
        assert max(np.abs(np.diff(height, axis=k)).max() for k in (0, 1)) / 10 < 0.05
        # The highest ground in each direction stands above a drone 60 m over the map's top.
        angle = np.radians(np.arange(0, 360, 2))
        r = np.arange(1000, 5900, 50.0)
        far = np.stack([np.cos(angle)[:, None] * r, np.sin(angle)[:, None] * r], -1)
        skyline = terrain.height_m(far.reshape(-1, 2)).reshape(len(angle), -1).max(axis=1)
        assert skyline.min() > height.max() + 60
        assert skyline.max() < 450


def test_outskirts_begin_at_the_map_edge_and_follow_the_terrain(terrain):
    land = outskirts(terrain)
    vertices = np.concatenate([g.vertices for g in land.values()]).astype(np.float64)
    edge = np.abs(vertices[:, :2]).max(axis=1)
    assert edge.min() == pytest.approx(SIZE_M / 2, abs=1e-3)
    assert np.hypot(*vertices[:, :2].T).max() == pytest.approx(6000, rel=1e-3)
    np.testing.assert_allclose(vertices[:, 2], terrain.height_m(vertices[:, :2]), atol=0.01)
    total = sum(flat_area(g).sum() for g in land.values())
    assert total == pytest.approx(np.pi * 6000**2 - SIZE_M**2, rel=2e-3)
    assert min(flat_area(g).min() for g in land.values()) > 0
    assert 5_000 < sum(len(g.faces) for g in land.values()) < 30_000


def test_far_trees_stand_outside_the_map_on_the_ground(terrain):
    trees = tree_line(lane(1, "trees"), terrain, count=800)
    assert 500 < len(trees) <= 800
    assert np.abs(trees[:, :2]).max(axis=1).min() > SIZE_M / 2
    np.testing.assert_allclose(trees[:, 2], terrain.height_m(trees[:, :2]))


def test_a_square_kilometre_holds_a_suburb(full_plan):
    houses = [lot for lot in full_plan.lots if lot.kind == "house"]
    assert 300 < len(houses) < 850
    assert {lot.kind for lot in full_plan.lots} <= {"house", "vacant", "park"}
    assert 8_000 < sum(length_m(s.centreline) for s in full_plan.streets) < 16_000
    local = [s.width_m for s in full_plan.streets if s.kind == "local"]
    assert min(local) >= 6.6
    assert max(local) <= 7.5
    assert len(full_plan.bulbs) > 5
    assert len(full_plan.junctions) > 25


def test_every_street_can_be_reached(full_plan):
    assert shapely.get_num_geometries(full_plan.carriageway) == 1


def test_lots_are_disjoint_beside_the_street_and_of_house_size(full_plan):
    lots = np.array([shapely.Polygon(lot.polygon) for lot in full_plan.lots])
    assert shapely.is_valid(lots).all()
    i, j = shapely.STRtree(lots).query(lots, predicate="intersects")
    overlap = shapely.area(shapely.intersection(lots[i[i < j]], lots[j[i < j]]))
    assert overlap.max() < 0.01
    assert shapely.area(shapely.intersection(lots, full_plan.street_land)).max() < 0.01
    for lot, polygon in zip(full_plan.lots, lots, strict=True):
        assert polygon.exterior.is_ccw
        assert np.linalg.norm(lot.inward) == pytest.approx(1)
        if lot.kind == "park":
            continue
        assert 13 < lot.width_m < 40
        assert 22 < lot.depth_m < 60
        # The front touches the lot, and the pavement lies just before it.
        assert polygon.distance(shapely.Point(lot.front)) < 0.1
        assert full_plan.pavement.distance(shapely.Point(lot.front)) < 1.5
        # A house that keeps to the stated width fits.
        aside = np.array([-lot.inward[1], lot.inward[0]])
        half = lot.width_m / 2 - 0.5
        house = shapely.Polygon(
            [
                lot.front + a * half * aside + b * lot.inward
                for a, b in ((-1, 4), (1, 4), (1, 22), (-1, 22))
            ]
        )
        assert polygon.buffer(0.6).contains(house)


def test_street_areas_touch_without_overlap(full_plan):
    parts = [full_plan.carriageway, full_plan.kerb, full_plan.verge, full_plan.pavement]
    total = sum(p.area for p in parts)
    assert total == pytest.approx(full_plan.street_land.area, rel=1e-6)
    assert full_plan.carriageway.distance(full_plan.verge) == pytest.approx(0.15, abs=0.03)


def test_the_ground_covers_the_square_once(surface, plan):
    ground = {k: g for k, g in surface.items() if k[0] != "soil"}
    areas = {k: flat_area(g) for k, g in ground.items()}
    assert sum(a.sum() for a in areas.values()) == pytest.approx(SIZE_M**2, abs=1.0)
    assert min(a.min() for a in areas.values()) > -1e-4
    assert areas["asphalt", "road"].sum() == pytest.approx(plan.carriageway.area, rel=1e-4)
    for (_material, label), part in surface.items():
        assert label in LABELS
        triangles = part.triangles.astype(np.float64)
        cross = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        assert np.linalg.norm(cross, axis=1).min() > 1e-8


def test_heights_follow_the_terrain(surface, terrain):
    for key, part in surface.items():
        xyz = part.vertices.astype(np.float64)
        over = xyz[:, 2] - terrain.height_m(xyz[:, :2])
        if key[0] == "asphalt":
            np.testing.assert_allclose(over, -KERB_HEIGHT_M, atol=1e-3)
        elif key[0] == "soil":
            np.testing.assert_allclose(over, -BEDDING_M, atol=1e-3)
        elif key[0] == "paving":
            np.testing.assert_allclose(over, 0, atol=1e-3)
        else:
            assert over.min() > -KERB_HEIGHT_M - 1e-3
            assert over.max() < 1e-3
    # Between its vertices too: the grid keeps chords within a centimetre.
    for key in (("grass", "ground"), ("asphalt", "road")):
        centre = surface[key].triangles.astype(np.float64).mean(axis=1)
        sunk = KERB_HEIGHT_M if key[0] == "asphalt" else 0.0
        gap = np.abs(centre[:, 2] + sunk - terrain.height_m(centre[:, :2]))
        assert np.quantile(gap, 0.9) < 0.01


def test_kerbs_drop_at_driveways(surface, plan, terrain):
    xyz = surface["concrete", "pavement"].vertices.astype(np.float64)
    over = xyz[:, 2] - terrain.height_m(xyz[:, :2])
    drives = shapely.union_all([shapely.Polygon(d) for d in driveways_of(plan)])
    on_kerb = shapely.dwithin(plan.carriageway, shapely.points(xyz[:, :2]), 0.1)
    top = over > -KERB_HEIGHT_M + 0.01
    inside = shapely.contains_xy(drives.buffer(-0.02), xyz[:, :2])
    away = ~shapely.contains_xy(drives.buffer(0.8), xyz[:, :2])
    assert (on_kerb & top & inside).any()
    np.testing.assert_allclose(
        over[on_kerb & top & inside], DROPPED_KERB_M - KERB_HEIGHT_M, atol=2e-3
    )
    np.testing.assert_allclose(over[on_kerb & top & away], 0, atol=2e-3)


def test_markings_lie_on_the_carriageway(plan, terrain):
    model = street_markings(draw_street_markings(lane(4, "markings"), plan), terrain)
    road = plan.carriageway.buffer(0.1)
    for (_material, label), part in model.items():
        assert label == "road"
        xyz = part.vertices.astype(np.float64)
        lift = xyz[:, 2] - terrain.height_m(xyz[:, :2]) + KERB_HEIGHT_M
        assert lift.min() > 0.005
        assert lift.max() < 0.03
        assert shapely.contains_xy(road, xyz[:, :2]).mean() > 0.99


def test_places_along_streets(full_plan):
    drive = driveways_of(full_plan)
    trees, heading = along(
        lane(0, "trees"), full_plan, spacing_m=12, kerb_offset_m=0.8, jitter_m=2, keep_clear=drive
    )
    points = shapely.points(trees)
    assert len(trees) > 400
    assert not shapely.intersects(full_plan.carriageway, points).any()
    assert shapely.dwithin(full_plan.verge, points, 0.3).mean() > 0.97
    assert not shapely.intersects(
        shapely.union_all([shapely.Polygon(d) for d in drive]), points
    ).any()
    left = trees + 2.5 * np.stack([-np.sin(heading), np.cos(heading)], 1)
    assert shapely.contains_xy(full_plan.carriageway, left).mean() > 0.99
    cars, _ = along(lane(0, "cars"), full_plan, spacing_m=20, kerb_offset_m=-1.1)
    assert shapely.contains_xy(full_plan.carriageway, cars).all()


def test_same_seed_same_bytes_other_seed_another_place(surface, plan, terrain):
    again = small_plan(4)
    assert bytes_of(street_surface(again, terrain, driveways_of(again))) == bytes_of(surface)
    other = small_plan(5)
    assert len(other.lots) != len(plan.lots) or not np.array_equal(
        other.lots[0].polygon, plan.lots[0].polygon
    )
