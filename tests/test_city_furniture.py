"""Street furniture, signals and large structures: scale, support, sound meshes, determinism."""

import numpy as np
import pytest

from synthdepth.maps.furniture.masts import conductors, draw_pylon, power_line
from synthdepth.maps.furniture.parts import lathe
from synthdepth.maps.furniture.posters import decals, lettering, poster
from synthdepth.maps.furniture.signals import overhead_gantry, street_name_sign, traffic_light
from synthdepth.maps.furniture.street_furniture import FURNITURE, furniture, scatter_furniture
from synthdepth.maps.furniture.structures import (
    billboard,
    footbridge,
    lattice_mast,
    pylon,
    scaffold,
    tower_crane,
    water_tower,
)
from synthdepth.maps.materials.catalogue import CATALOGUE
from synthdepth.maps.world import LABELS

SEEDS = (0, 1)
NEUTRAL = {"paint", "wood", "fabric", "leaf", "brick", "plaster", "lamp", "signal"}

OTHERS = {
    "traffic_light": lambda r: traffic_light(r, arm_m=7.5),
    "signal_pole": lambda r: traffic_light(r, arm_m=0.0),
    "street_name_sign": street_name_sign,
    "overhead_gantry": lambda r: overhead_gantry(r, span_m=16.0),
    "tower_crane": lambda r: tower_crane(r, height_m=40.0, jib_m=45.0),
    "footbridge": lambda r: footbridge(r, span_m=20.0, clearance_m=5.2),
    "water_tower": water_tower,
    "lattice_mast": lambda r: lattice_mast(r, height_m=36.0),
    "scaffold": lambda r: scaffold(r, width_m=12.0, height_m=8.0),
    "billboard": billboard,
    "pylon": pylon,
}
BUILDERS = {**FURNITURE, **OTHERS}

# Greatest height [m] over the drawn variants: from, to.
HEIGHTS = {
    "bench": (0.42, 1.0), "litter_bin": (0.9, 1.3), "hydrant": (0.65, 0.85),
    "bollard": (0.8, 1.1), "bus_shelter": (2.4, 3.2), "kiosk": (2.7, 3.8),
    "phone_box": (2.2, 2.7), "manhole": (0.005, 0.02), "traffic_cone": (0.45, 0.8),
    "barrier_crowd": (1.0, 1.25), "barrier_jersey": (0.75, 0.9), "picnic_table": (0.7, 0.85),
    "cafe_table": (0.75, 2.8), "mailbox": (1.1, 1.7), "advertising_column": (3.5, 4.7),
    "skip": (1.1, 1.9), "traffic_light": (5.5, 7.0), "signal_pole": (3.3, 3.8),
    "overhead_gantry": (6.5, 8.5), "tower_crane": (47.0, 49.0), "lattice_mast": (38.0, 42.0),
    "pylon": (26.0, 44.5), "water_tower": (20.0, 45.0),
}  # fmt: skip


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def points(model) -> np.ndarray:
    return np.concatenate([g.vertices for g in model.values()])


@pytest.fixture(scope="module")
def built() -> dict:
    return {name: [make(rng(s)) for s in SEEDS] for name, make in BUILDERS.items()}


@pytest.mark.parametrize("name", sorted(BUILDERS))
def test_meshes_are_sound(built, name):
    for model in built[name]:
        for (material, label), g in model.items():
            assert material in CATALOGUE and label in LABELS
            assert g.vertices.dtype == g.uv.dtype == g.tint.dtype == np.float32
            assert g.faces.dtype == np.int32
            assert np.isfinite(g.vertices).all() and np.isfinite(g.uv).all()
            assert g.faces.min() >= 0 and g.faces.max() < len(g.vertices)
            tri = g.triangles.astype(np.float64)
            area = np.linalg.norm(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1)
            assert area.min() > 2e-9
            limit = 0.9 if material in NEUTRAL else 1.3
            assert g.tint.min() > 0 and g.tint.max() <= limit, material


@pytest.mark.parametrize("name", sorted(BUILDERS))
def test_stands_on_the_ground_and_has_its_size(built, name):
    low, high = HEIGHTS.get(name, (0.3, 60.0))
    for model in built[name]:
        z = points(model)[:, 2]
        assert -0.5 < z.min() < 0.012
        assert low <= z.max() <= high


@pytest.mark.parametrize("name", sorted(BUILDERS))
def test_the_same_seed_builds_the_same_bytes(built, name):
    again = BUILDERS[name](rng(0))
    assert set(again) == set(built[name][0])
    for key, g in again.items():
        assert g.vertices.tobytes() == built[name][0][key].vertices.tobytes()
        assert g.tint.tobytes() == built[name][0][key].tint.tobytes()
    first, second = (np.sort(points(built[name][k]).ravel()) for k in (0, 1))
    tints = [sum(g.tint.sum() for g in built[name][k].values()) for k in (0, 1)]
    assert len(first) != len(second) or not np.array_equal(first, second) or tints[0] != tints[1]


def test_lamps_are_small_and_under_a_shelter_shine_down(built):
    for name in ("bus_shelter", "kiosk", "phone_box", "advertising_column"):
        for model in built[name]:
            tri = model["lamp", "street_furniture"].triangles.astype(np.float64)
            normal = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
            assert np.all(normal[:, 2] < 0)
            assert np.linalg.norm(normal, axis=1).max() / 2 < 0.15


def test_lenses_face_the_traffic_and_one_is_lit():
    for seed in range(6):
        model = traffic_light(rng(seed), arm_m=0.0)
        lens = model["signal", "street_furniture"]
        tri = lens.triangles.astype(np.float64)
        normal = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
        to_traffic = normal[:, 0] > 0.9 * np.linalg.norm(normal, axis=1)
        # The other lit one is the pedestrians', across the road.
        assert len(np.unique(np.round(lens.tint[lens.faces[to_traffic, 0]], 3), axis=0)) == 1
        assert not to_traffic.all()
        centre = tri[to_traffic].mean(axis=(0, 1))
        assert 2.3 < centre[2] < 3.4 and centre[0] > 0


def test_the_arm_reaches_over_the_road():
    assert points(traffic_light(rng(), arm_m=8.0))[:, 1].max() == pytest.approx(8.0, abs=0.4)


@pytest.mark.parametrize("seed", range(6))
def test_a_footbridge_leaves_the_road_free(seed):
    model = footbridge(rng(seed), span_m=18.0, clearance_m=5.0)
    p = points(model)
    over_road = p[np.abs(p[:, 0]) < 8.0]
    assert over_road[:, 2].min() > 4.95
    rails = model["paint", "barrier"].vertices
    assert rails[:, 2].max() > 6.0


def test_a_gantry_leaves_the_road_free():
    p = points(overhead_gantry(rng(), span_m=14.0))
    assert p[np.abs(p[:, 1]) < 6.0][:, 2].min() > 5.1


def test_a_scaffold_stays_before_its_wall():
    p = points(scaffold(rng(), width_m=10.0, height_m=12.0))
    assert p[:, 0].min() > 0.05
    assert np.abs(p[:, 1]).max() < 5.6


def test_conductors_meet_both_pylons_and_sag():
    params = draw_pylon(rng())
    far = np.array([150.0, 0, 0])
    wire = conductors(params, np.zeros(3), 0.0, far, 0.0, 0.03)["paint", "wire"].vertices
    clamps = np.concatenate([params.clamps, params.peak])
    for foot in (np.zeros(3), far):
        gap = np.linalg.norm(wire[:, None] - (clamps + foot)[None], axis=2).min(axis=0)
        assert gap.max() < 0.05
    middle = wire[np.abs(wire[:, 0] - 75) < 8]
    assert middle[:, 2].min() == pytest.approx(clamps[:, 2].min() - 0.03 * 150, abs=0.6)
    assert middle[:, 2].min() > 5
    assert ("paint", "wire") in power_line(rng(), [[0, 0, 0], [150, 0, 0]])


def test_scattered_pieces_are_where_they_should_be():
    at = np.column_stack([np.arange(12) * 10.0, np.zeros(12), np.full(12, 3.0)])
    p = points(scatter_furniture(rng(), "bench", at, np.pi / 2))
    who = np.round(p[:, 0] / 10).astype(int)
    assert set(who) == set(range(12))
    assert np.abs(p[:, 0] - 10 * who).max() < 1.3
    assert p[:, 2].min() > 2.9
    assert scatter_furniture(rng(), "bench", np.zeros((0, 3)), 0.0) == {}


def test_unknown_furniture_lists_the_known():
    with pytest.raises(KeyError, match=r"furniture 'throne' is not one of .*bench"):
        furniture(rng(), "throne")


def test_a_bowl_turns_in_without_a_twist():
    bowl = lathe([(0.5, 0.0), (1.0, 1.0), (0.9, 1.0), (0.4, 0.2)], 12)
    radius = np.hypot(bowl.vertices[:, 0], bowl.vertices[:, 1])
    mid = bowl.triangles.mean(axis=1)
    # Every side's middle lies near the wall, none crosses the axis.
    assert np.sort(np.hypot(mid[:, 0], mid[:, 1]))[24:].min() > 0.3
    assert radius.max() == pytest.approx(1.0)


def test_posters_stay_on_their_sheets():
    for seed in range(8):
        flat = poster(rng(seed), 1.2, 1.8)
        assert np.abs(flat.vertices[:, 1]).max() < 0.601
        assert flat.vertices[:, 2].min() > -1e-6 and flat.vertices[:, 2].max() < 1.801
        bent = poster(rng(seed), 0.9, 2.0, 0.6, 24)
        radius = np.hypot(bent.vertices[:, 0], bent.vertices[:, 1])
        assert radius.min() > 0.58 and radius.max() < 0.63


def test_lettering_reads_from_left_to_right():
    wide = lettering("TOWN", 0.5)
    assert np.ptp(wide[:, [1, 3]]) == pytest.approx(0.5)
    bar = lettering("L", 1.0)
    # The stem of an L is its leftmost, highest bar; its foot lies to the right, at the base.
    stem, foot = bar[np.argmax(bar[:, 3])], bar[np.argmax(bar[:, 2])]
    assert stem[2] <= foot[0] + 1e-9 and foot[3] < 0 < stem[3]
    part = decals(bar, (0.5, 0.5, 0.5), 1)
    tri = part.triangles.astype(np.float64)
    assert np.all(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])[:, 0] > 0)
