import itertools

import numpy as np
import pytest
import shapely

from synthdepth.maps.materials.catalogue import CATALOGUE
from synthdepth.maps.towers.construction import construction_tower
from synthdepth.maps.towers.panels import Panels, block, faces, sweep, tunnel
from synthdepth.maps.towers.styles import STYLES
from synthdepth.maps.towers.tower import FACADES, draw_tower, tower
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane

# 25 x 20 m, turned by 30 degrees and far from the origin, with a corner cut off.
TURN = np.array([[np.cos(0.52), np.sin(0.52)], [-np.sin(0.52), np.cos(0.52)]])
PLAIN = np.array([[0.0, 0.0], [25.0, 0.0], [25.0, 20.0], [0.0, 20.0]]) @ TURN + [310.0, -140.0]
CUT = np.array([[6.0, 0.0], [25.0, 0.0], [25.0, 20.0], [0.0, 20.0], [0.0, 6.0]]) @ TURN
STREET = np.array([True, True, False, True])


def draw(facade, storeys, index=0, footprint=PLAIN, street=STREET):
    rng = lane(5, facade, index)
    return draw_tower(rng, footprint, storeys=storeys, street_sides=street, facade=facade)


def triangles(model) -> np.ndarray:
    return np.concatenate([g.triangles for g in model.values()]).astype(np.float64)


def count(model) -> int:
    return sum(len(g.faces) for g in model.values())


def fit(facade: str, storeys: int) -> bool:
    low, high = STYLES[facade].storeys
    return low <= storeys <= high


@pytest.fixture(scope="module")
def built() -> dict:
    """(facade, detail) -> (params, model): ten storeys, or as many as the family has."""
    out = {}
    for facade in FACADES:
        params = draw(facade, min(10, STYLES[facade].storeys[1]))
        for detail in (0, 1, 2):
            out[facade, detail] = params, tower(params, detail)
    return out


def check(model) -> np.ndarray:
    """Contracts of any model; its triangles."""
    for (material, label), part in model.items():
        assert material in CATALOGUE
        assert label in LABELS
        assert part.vertices.dtype == part.uv.dtype == part.tint.dtype == np.float32
        assert part.faces.dtype == np.int32
        assert np.isfinite(part.uv).all()
        assert (part.tint > 0).all()
        assert (part.tint <= 2).all()
    tri = triangles(model)
    assert np.isfinite(tri).all()
    area = np.linalg.norm(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1) / 2
    assert area.min() > 1e-9
    return tri


def test_there_are_families_for_every_height():
    assert len(FACADES) >= 9
    for storeys in range(3, 61):
        assert any(fit(f, storeys) for f in FACADES)
    drawn = {draw_tower(lane(1, "any", k), PLAIN, storeys=6, street_sides=STREET).facade
             for k in range(60)}  # fmt: skip
    assert len(drawn) >= 7
    assert all(fit(f, 6) for f in drawn)


def test_models_are_sound(built):
    for _, model in built.values():
        check(model)


def test_triangle_budgets(built):
    mean = {d: np.mean([count(m) for (_, e), (_, m) in built.items() if e == d]) for d in range(3)}
    assert mean[2] <= 25_000
    assert mean[1] <= mean[2] / 6
    assert max(count(m) for (_, d), (_, m) in built.items() if d == 0) <= 200
    tall = [count(tower(draw(f, 50))) for f in FACADES if fit(f, 50)]
    assert tall
    assert np.mean(tall) <= 80_000


def test_buildings_stand_in_the_ground_and_reach_their_height(built):
    for params, model in built.values():
        z = triangles(model)[..., 2]
        assert -0.5 < z.min() < -0.1
        assert params.height_m < z.max() < params.height_m + 30
        assert 2.8 < np.diff(params.levels_m)[1:].mean() < 4.3


def test_nothing_leaves_the_lot_but_over_the_street(built):
    home = shapely.Polygon(PLAIN)
    along = PLAIN[3] - PLAIN[2]
    normal = np.array([along[1], -along[0]]) / np.linalg.norm(along)
    for _, model in built.values():
        xy = triangles(model)[..., :2].reshape(-1, 2)
        assert shapely.distance(home, shapely.points(xy)).max() < 2.6
        # The party wall's neighbour may stand right against it.
        assert ((xy - PLAIN[2]) @ normal).max() < 0.5


def test_walls_close_every_storey(built):
    """Seen from the street at any height, what is there lies within 0.6 m of the wall's plane."""
    a, b = PLAIN[0], PLAIN[1]
    d = (b - a) / np.linalg.norm(b - a)
    n = np.array([d[1], -d[0]])
    wide = np.linalg.norm(b - a)
    for facade, detail in itertools.product(FACADES[::4], (0, 1, 2)):
        params, model = built[facade, detail]
        tri = triangles(model)
        s, out = (tri[..., :2] - a) @ d, (tri[..., :2] - a) @ n
        shapes = shapely.polygons(np.stack([s, tri[..., 2]], -1)[(np.abs(out) < 0.6).all(axis=1)])
        seen = shapely.union_all(shapes[np.abs(shapely.area(shapes)) > 1e-4])
        wall = shapely.box(0, 0, wide, params.levels_m[params.tiers[0].last])
        assert seen.intersection(wall).area > 0.995 * wall.area


def test_same_bytes_again_and_other_seeds_differ(built):
    for facade in FACADES[::4]:
        params, model = built[facade, 2]
        again = tower(draw(facade, params.storeys), 2)
        assert list(again) == list(model)
        for key, part in model.items():
            assert part.vertices.tobytes() == again[key].vertices.tobytes()
            assert part.tint.tobytes() == again[key].tint.tobytes()
        other = tower(draw(facade, params.storeys, 1), 2)
        assert count(other) != count(model)


def test_families_differ(built):
    looks = [(p.wall, count(m)) for (_, d), (p, m) in built.items() if d == 2]
    for one, two in itertools.combinations(looks, 2):
        assert one != two
    assert ("coated_glass", "building") in built["curtain_wall", 2][1]
    assert any(label == "barrier" for _, label in built["fire_escape", 2][1])
    assert any(label == "pole" for f in FACADES for _, label in built[f, 2][1])


def test_every_pane_is_two_triangles_in_a_row(built):
    for _, model in built.values():
        glass = model[("glass", "building")]
        pairs = glass.faces.reshape(-1, 2, 3)
        shared = (pairs[:, 0, [0, 2]] == pairs[:, 1, [0, 1]]).all(axis=1)
        assert shared.all()


def test_lamps_are_small_and_shine_downwards(built):
    seen = 0
    for (_, detail), (_, model) in built.items():
        if detail == 2 and ("lamp", "building") in model:
            tri = model[("lamp", "building")].triangles.astype(np.float64)
            cross = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
            assert (cross[:, 2] < 0).all()
            assert np.linalg.norm(cross, axis=1).max() < 0.3
            seen += len(tri)
    assert seen


def test_cut_corners_setbacks_and_low_buildings():
    street = np.ones(5, bool)
    for facade, storeys in (("curtain_wall", 60), ("stone_classical", 20), ("punched_brick", 3)):
        for index in range(3):
            params = draw(facade, storeys, index, CUT, street)
            assert params.tiers[0].first == 0
            assert params.tiers[-1].last == storeys
            for low, high in itertools.pairwise(params.tiers):
                assert low.last == high.first
                ground = shapely.Polygon(low.polygon).buffer(1e-6)
                assert ground.contains(shapely.Polygon(high.polygon))
            for detail in (0, 1, 2):
                check(tower(params, detail))


def test_an_unknown_facade_is_refused():
    with pytest.raises(KeyError, match="papier"):
        draw_tower(lane(1, "x"), PLAIN, storeys=5, street_sides=STREET, facade="papier-mache")


def test_a_frame_under_construction_is_open():
    model = construction_tower(lane(2, "crane"), PLAIN, 7)
    tri = check(model)
    assert -0.5 < tri[..., 2].min() < -0.1
    assert 7 * 3.4 < tri[..., 2].max() < 7 * 3.4 + 10
    assert 3_000 < len(tri) < 40_000
    slabs = np.isclose(tri[..., 2], 3.4 * 3, atol=1e-3).all(axis=1)
    area = np.linalg.norm(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1) / 2
    assert area[slabs].sum() == pytest.approx(shapely.Polygon(PLAIN).area, rel=0.02)
    again = construction_tower(lane(2, "crane"), PLAIN, 7)
    assert all(again[k].vertices.tobytes() == part.vertices.tobytes() for k, part in model.items())


def normals(model) -> np.ndarray:
    tri = triangles(model)
    cross = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    return cross / np.linalg.norm(cross, axis=1, keepdims=True)


def test_frames_face_outwards():
    """A wall along +x of the south side: out of it is -y."""
    key = ("paint", "building")
    for quads, away in (
        (faces(np.zeros(1), 2.0, 0.0, 3.0), [[0, -1, 0]]),
        (block(np.zeros(1), 1.0, 0.0, 1.0, 0.0, 1.0, "lrtb"),
         [[-1, 0, 0], [1, 0, 0], [0, 0, 1], [0, 0, -1]]),
        (tunnel(np.zeros(1), 1.0, 0.0, 1.0, 0.0, -0.2, "lrtb"),
         [[1, 0, 0], [-1, 0, 0], [0, 0, -1], [0, 0, 1]]),
    ):  # fmt: skip
        panels = Panels(np.array([[0.0, 0.0, 1.0, 0.0]]))
        panels.add(key, (1, 1, 1), quads, 0)
        np.testing.assert_allclose(normals(panels.model()), np.repeat(away, 2, axis=0), atol=1e-6)


def test_sweeps_are_mitred_and_closed():
    square = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    profile = [(0, 0), (0.5, 0), (0.5, 1), (0, 1)]
    whole, part = Panels(np.zeros((0, 4))), Panels(np.zeros((0, 4)))
    sweep(whole, ("stone", "building"), (1, 1, 1), square, profile)
    tri = triangles(whole.model())
    np.testing.assert_allclose(tri[..., :2].min(axis=(0, 1)), [-0.5, -0.5])
    # The volume by the divergence theorem, with the share of the open side, x = 10 and y = 10.
    volume = np.einsum("ni,ni->n", tri[:, 0], np.cross(tri[:, 1], tri[:, 2])).sum() / 6
    assert volume - 2 * 10 * 10 / 3 == pytest.approx(11 * 11 - 10 * 10)
    sweep(part, ("stone", "building"), (1, 1, 1), square, profile, np.array([1, 0, 0, 0], bool))
    tri = triangles(part.model())
    assert tri[..., 0].min() == 0
    assert tri[..., 0].max() == 10
    assert (np.isclose(tri[..., 0], 0).all(axis=1)).any()
