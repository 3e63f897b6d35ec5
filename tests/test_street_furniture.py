"""Vehicles, poles and wires, fences and garden items: scale, support, closeness, determinism."""

import itertools

import numpy as np
import pytest

from synthdepth.maps.furniture.fences import FENCES, fence, gate
from synthdepth.maps.furniture.poles import (
    build_utility_line,
    catenary,
    draw_utility_line,
    service_drop,
    utility_line,
)
from synthdepth.maps.furniture.signs import LAMPS, SIGNS, signs, street_lamps
from synthdepth.maps.gardens.items import GARDEN_ITEMS, garden_item, scatter
from synthdepth.maps.materials.catalogue import CATALOGUE
from synthdepth.maps.vehicles.vehicle import BODIES, draw_vehicle, park, vehicle
from synthdepth.maps.world import LABELS

POLES = np.array([[0, 0, 0], [38, 1, 0.5], [75, -1, 1.0], [110, 4, 0.4]])
PATH = np.array([[0, 0, 0], [11, 2, 0.6], [14, 9, 0.2]])


def rng(seed: int = 3) -> np.random.Generator:
    return np.random.default_rng(seed)


def points(model) -> np.ndarray:
    return np.concatenate([g.vertices for g in model.values()])


def check(model) -> None:
    """Known names, sound arrays, no triangle without area, no reflectance above 0.9."""
    for (material, label), g in model.items():
        assert material in CATALOGUE
        assert label in LABELS
        n = len(g.vertices)
        assert g.vertices.dtype == g.uv.dtype == g.tint.dtype == np.float32
        assert g.uv.shape == (n, 2) and g.tint.shape == (n, 3)
        assert np.isfinite(g.vertices).all() and np.isfinite(g.uv).all()
        assert len(g.faces) and g.faces.min() >= 0 and g.faces.max() < n
        tri = g.triangles.astype(np.float64)
        area = np.linalg.norm(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1) / 2
        assert area.min() > 1e-7
        assert g.tint.min() > 0 and g.tint.max() <= (1.2 if material != "paint" else 0.9)


def everything(seed: int) -> dict:
    """One of each kind, by name, from one seed."""
    at, yaw = np.array([[0.0, 0, 0], [9, 1, 0.2]]), np.array([0.3, 2.0])
    out = {f"body {b}": vehicle(draw_vehicle(rng(seed), b)) for b in BODIES}
    out |= {f"fence {k}": fence(rng(seed), PATH, k) for k in FENCES}
    out |= {f"far fence {k}": fence(rng(seed), PATH, k, detail=0) for k in FENCES}
    out |= {f"gate {k}": gate(rng(seed), PATH[0], [1.1, 0, 0], k, 1.0) for k in FENCES}
    out |= {f"item {k}": garden_item(rng(seed), k) for k in GARDEN_ITEMS}
    out |= {f"lamp {k}": street_lamps(rng(seed), at, yaw, k) for k in LAMPS}
    out |= {f"sign {k}": signs(rng(seed), at, yaw, k) for k in SIGNS}
    out["line"] = utility_line(rng(seed), POLES, [[20, 14, 5]])
    out["drop"] = service_drop(rng(seed), [0, 0, 8], [12, 3, 5])
    out["park"] = park(rng(seed), at, yaw, np.array([20.0, 200.0]))
    return out


def test_everything_is_sound_and_reproducible():
    first, again, other = everything(3), everything(3), everything(4)
    for name, model in first.items():
        check(model)
        assert model.keys() == again[name].keys(), name
        for key, g in model.items():
            for field in ("vertices", "faces", "uv", "tint"):
                assert getattr(g, field).tobytes() == getattr(again[name][key], field).tobytes()
        same = model.keys() == other[name].keys() and all(
            g.vertices.tobytes() == other[name][k].vertices.tobytes()
            and g.tint.tobytes() == other[name][k].tint.tobytes()
            for k, g in model.items()
        )
        assert not same, name


@pytest.mark.parametrize("body", sorted(BODIES))
def test_vehicles_have_their_size_and_stand_on_the_ground(body):
    spec = BODIES[body]
    for detail, most in ((1, 3000), (0, 620)):
        params = draw_vehicle(rng(), body, detail=detail)
        model = vehicle(params)
        p = points(model)
        low, high = p.min(axis=0), p.max(axis=0)
        assert abs(low[2]) < 0.02  # tyres touch the ground
        assert high[0] - low[0] == pytest.approx(spec.length_m * params.scale[0], rel=0.02)
        assert high[2] == pytest.approx(spec.height_m * params.scale[2], rel=0.1)
        assert spec.width_m * 0.93 < high[1] - low[1] < spec.width_m + 0.35  # mirrors
        assert sum(len(g.faces) for g in model.values()) < most


def test_vehicle_bodies_face_outwards():
    """Normals of paint and panes point away from the middle, except inside a load bed."""
    for body in sorted(set(BODIES) - {"pickup"}):
        for detail in (0, 1):
            model = vehicle(draw_vehicle(rng(), body, detail=detail))
            for material in ("car_paint", "glass"):
                tri = model[material, "vehicle"].triangles.astype(np.float64)
                normal = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
                half = np.array([BODIES[body].length_m, BODIES[body].width_m, 0]) / 2 - 0.6
                middle = tri.mean(axis=1)
                axis = np.clip(middle, -half.clip(0), half.clip(0)) * [1, 1, 0] + [0, 0, 0.7]
                outward = np.einsum("ij,ij->i", normal, middle - axis) > 0
                area = np.linalg.norm(normal, axis=1)
                assert area[outward].sum() > 0.93 * area.sum(), (body, detail, material)


def test_parked_cars_stand_where_they_are_put():
    at = np.array([[10.0, 20, 1.5], [60, -5, 0], [90, 0, 2]])
    model = park(rng(), at, np.array([0.0, np.pi / 2, 1.0]), np.array([10.0, 90.0, 300.0]))
    p = points(model)
    for place in at:
        near = p[np.linalg.norm(p[:, :2] - place[:2], axis=1) < 4]
        assert abs(near[:, 2].min() - place[2]) < 0.02
        assert np.abs((near.min(axis=0) + near.max(axis=0)) / 2 - place)[:2].max() < 0.15
    assert np.linalg.norm(p[:, None, :2] - at[None, :, :2], axis=2).min(axis=1).max() < 4


def test_most_parked_cars_are_grey():
    k = 400
    at = np.column_stack([np.arange(k) * 10.0, np.zeros(k), np.zeros(k)])
    paint = park(rng(), at, np.zeros(k), np.full(k, 200.0))["car_paint", "vehicle"]
    car = np.round(paint.vertices[:, 0] / 10).astype(int)
    top = np.zeros((k, 3))
    top[car[np.argsort(paint.vertices[:, 2])]] = paint.tint[np.argsort(paint.vertices[:, 2])]
    grey = np.ptp(top, axis=1) < 0.15 * top.max(axis=1)
    assert 0.65 < grey.mean() < 0.9


def test_catenary_sags_and_holds_its_ends():
    a, b = np.array([[0.0, 0, 10], [0, 0, 9]]), np.array([[40.0, 0, 10], [30, 30, 12]])
    wire = catenary(a, b, 0.02, segments=20)
    np.testing.assert_allclose(wire[:, 0], a)
    np.testing.assert_allclose(wire[:, -1], b)
    assert 10 - wire[0, :, 2].min() == pytest.approx(0.02 * 40, rel=0.01)
    # Constant horizontal tension: y'' / sqrt(1 + y'^2) is the same everywhere.
    slope = np.diff(wire[0, :, 2]) / 2.0
    bend = np.diff(slope) / 2.0 / np.sqrt(1 + ((slope[1:] + slope[:-1]) / 2) ** 2)
    np.testing.assert_allclose(bend, bend.mean(), rtol=1e-3)


def test_wires_join_consecutive_poles():
    line = draw_utility_line(rng(), POLES)
    model = build_utility_line(line)
    wire = model["paint", "wire"].vertices
    assert wire[:, 2].min() < 9 and wire[:, 2].max() < line.heights_m.max() + 1.5
    for a, b in itertools.pairwise(POLES):
        middle = (a + b) / 2
        gap = np.linalg.norm(wire[:, :2] - middle[:2], axis=1)
        assert (gap < 1.5).sum() >= 3 * (line.conductors + 1)
    wood = model["wood", "pole"].vertices
    for base, height in zip(POLES, line.heights_m, strict=True):
        near = wood[np.linalg.norm(wood[:, :2] - base[:2], axis=1) < 1.4]
        assert near[:, 2].min() < base[2] - 0.05
        assert near[:, 2].max() == pytest.approx(base[2] + height, abs=0.1)
    assert (line.heights_m >= 9).all() and (line.heights_m <= 11).all()


def test_house_drops_end_at_the_house():
    house = np.array([[20.0, 14, 5], [70, -12, 6]])
    wire = utility_line(rng(), POLES, house)["paint", "wire"].vertices
    assert np.linalg.norm(wire[None] - house[:, None], axis=2).min(axis=1).max() < 0.03


@pytest.mark.parametrize("kind", sorted(FENCES))
def test_fences_follow_the_ground_at_their_height(kind):
    height = 1.2
    p = points(fence(rng(), PATH, kind, height))
    leg = PATH[1] - PATH[0]
    t = (p[:, :2] - PATH[0, :2]) @ leg[:2] / (leg[:2] @ leg[:2])
    on = (t > 0.05) & (t < 0.9) & (p[:, 1] < 3)
    off = np.abs(leg[0] * (p[on, 1] - PATH[0, 1]) - leg[1] * (p[on, 0] - PATH[0, 0]))
    assert (off / np.linalg.norm(leg[:2])).max() < 0.25
    above = p[on, 2] - (PATH[0, 2] + t[on] * leg[2])
    assert -0.35 < above.min() < 0.0
    assert height - 0.05 < above.max() < height + 0.2


@pytest.mark.parametrize("name", sorted(GARDEN_ITEMS))
def test_garden_items_stay_within_their_radius_and_on_the_ground(name):
    for seed in range(6):
        p = points(garden_item(rng(seed), name))
        assert np.linalg.norm(p[:, :2], axis=1).max() <= GARDEN_ITEMS[name].radius_m
        assert -0.15 < p[:, 2].min() <= 0.0
        assert p[:, 2].max() < 3.2


def test_scatter_sets_items_down():
    at = np.array([[5.0, 5, 1], [50, 0, 3]])
    p = points(scatter(rng(), "shed", at, 0.0))
    for place in at:
        near = p[np.linalg.norm(p[:, :2] - place[:2], axis=1) < 3]
        assert -0.15 < near[:, 2].min() - place[2] <= 0


@pytest.mark.parametrize(
    "call",
    [
        lambda: draw_vehicle(rng(), "tractor"),
        lambda: fence(rng(), PATH, "moat"),
        lambda: signs(rng(), [[0, 0, 0]], 0.0, "exit"),
        lambda: street_lamps(rng(), [[0, 0, 0]], 0.0, "torch"),
        lambda: garden_item(rng(), "gnome"),
    ],
)
def test_unknown_kinds_are_refused_with_the_known_ones(call):
    with pytest.raises(KeyError, match="is not one of"):
        call()
