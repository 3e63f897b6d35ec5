"""Boats, piers, lighthouses, beach things, barriers: scale, support, closeness, determinism."""

import itertools

import numpy as np
import pytest

from synthdepth.maps.coast.beach import BEACH_ITEMS, BEACH_RADIUS_M, beach_item, beach_items
from synthdepth.maps.coast.boats import BOATS, boat, scatter_boats
from synthdepth.maps.coast.guard_rail import GUARD_RAILS, guard_rail
from synthdepth.maps.coast.harbour import HARBOUR_ITEMS, harbour_clutter, sea_buoys
from synthdepth.maps.coast.lighthouse import draw_lighthouse, lighthouse
from synthdepth.maps.coast.lofts import net
from synthdepth.maps.coast.pier import breakwater, groyne, jetty, pier
from synthdepth.maps.geometry import merge
from synthdepth.maps.materials.catalogue import CATALOGUE
from synthdepth.maps.world import LABELS

LINE = np.array([[0.0, 0.0], [30.0, 6.0], [62.0, 6.0]])
ROAD = np.array([[0, 0, 0], [9, 1, 0.3], [16, 6, 0.9], [17, 14, 1.2]])
DECK_M = 3.1

# Overall length and height above the water [m].
BOAT_SIZE_M = {
    "dinghy": ((3.2, 6.2), (4.5, 8.5)),
    "rowing_boat": ((3.1, 5.6), (0.4, 1.6)),
    "kayak": ((3.5, 5.4), (0.2, 0.6)),
    "rib": ((4.2, 8.5), (2.5, 3.8)),
    "motorboat": ((4.8, 8.2), (0.8, 3.0)),
    "cabin_cruiser": ((7.5, 14.0), (3.0, 8.0)),
    "sailing_yacht": ((8.0, 14.5), (10.0, 21.0)),
    "catamaran": ((9.5, 15.5), (12.0, 21.0)),
    "fishing_boat": ((6.5, 12.0), (4.0, 9.0)),
    "trawler": ((12.0, 19.5), (7.0, 14.0)),
    "cargo_ship": ((105.0, 205.0), (25.0, 70.0)),
}


def rng(seed: int = 3) -> np.random.Generator:
    return np.random.default_rng(seed)


def bed_m(xy):
    return 1.4 - 0.07 * np.asarray(xy)[:, 0]


def points(model) -> np.ndarray:
    return np.concatenate([g.vertices for g in model.values()])


def places(count: int) -> tuple[np.ndarray, np.ndarray]:
    x = np.arange(count) % 5 * 30.0
    y = np.arange(count) // 5 * 30.0
    return np.column_stack([x, y, 0.1 * x]), np.linspace(0, 5, count)


def everything(seed: int) -> dict:
    """One of each, by name, from one seed."""
    out = {f"boat {k}": boat(rng(seed), k) for k in BOATS}
    out |= {f"beach {k}": beach_item(rng(seed), k) for k in BEACH_ITEMS}
    out |= {f"harbour {k}": build(rng(seed)) for k, build in HARBOUR_ITEMS.items()}
    out |= {f"guard rail {k}": guard_rail(rng(seed), ROAD, k) for k in GUARD_RAILS}
    out["pier"] = pier(rng(seed), LINE, deck_m=DECK_M, bed_m=bed_m)
    out["jetty"] = jetty(rng(seed), LINE[:2], deck_m=1.2, bed_m=bed_m)
    out["groyne"] = groyne(rng(seed), LINE, bed_m)
    out["breakwater"] = breakwater(rng(seed), LINE[:2], bed_m)
    out["lighthouse"] = lighthouse(rng(seed))
    out["ashore"] = scatter_boats(rng(seed), *places(3), ashore=True)
    out["afloat"] = scatter_boats(rng(seed), *places(4), ashore=False)
    out["mix"] = beach_items(rng(seed), *places(12))
    out["clutter"] = harbour_clutter(rng(seed), *places(8))
    out["buoys"] = sea_buoys(rng(seed), places(12)[0])
    return out


@pytest.fixture(scope="module")
def built() -> dict:
    return {seed: everything(seed) for seed in (3, 4)}


def test_arrays_materials_and_labels_are_sound(built):
    """No triangle without area, no unknown name, no reflectance above what paint can have."""
    for name, model in itertools.chain(*(b.items() for b in built.values())):
        for (material, label), g in model.items():
            where = (name, material, label)
            assert material in CATALOGUE, where
            assert label in LABELS, where
            n = len(g.vertices)
            assert g.vertices.dtype == g.uv.dtype == g.tint.dtype == np.float32, where
            assert g.faces.dtype == np.int32, where
            assert g.uv.shape == (n, 2) and g.tint.shape == (n, 3), where
            assert np.isfinite(g.vertices).all() and np.isfinite(g.uv).all(), where
            assert len(g.faces) and g.faces.min() >= 0 and g.faces.max() < n, where
            tri = g.triangles.astype(np.float64)
            cross = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
            assert np.linalg.norm(cross, axis=1).min() > 2e-9, where
            assert g.tint.min() > 0 and g.tint.max() <= 1.3, where
            if material in ("paint", "car_paint", "plaster", "fabric"):
                assert g.tint.max() <= 0.9, where


def test_same_seed_same_bytes_and_others_differ(built):
    again = everything(3)
    assert again.keys() == built[3].keys()
    for name, model in built[3].items():
        assert list(model) == list(again[name]), name
        for key, g in model.items():
            for field in ("vertices", "faces", "uv", "tint"):
                assert np.array_equal(getattr(g, field), getattr(again[name][key], field)), name
        other = built[4][name]
        same = list(model) == list(other) and all(
            np.array_equal(g.vertices, other[key].vertices)
            and np.array_equal(g.tint, other[key].tint)
            for key, g in model.items()
        )
        assert not same, name


def test_boats_have_their_size_and_float(built):
    assert set(BOAT_SIZE_M) == set(BOATS)
    for seed, (kind, (lengths, heights)) in itertools.product((3, 4), BOAT_SIZE_M.items()):
        p = points(built[seed][f"boat {kind}"])
        assert lengths[0] <= np.ptp(p[:, 0]) <= lengths[1], (kind, np.ptp(p[:, 0]))
        assert heights[0] <= p[:, 2].max() <= heights[1], (kind, p[:, 2].max())
        # A keel under water, and as much boat on one side as on the other.
        assert p[:, 2].min() < -0.04, kind
        assert abs(p[:, 1].max() + p[:, 1].min()) < 0.25 * np.ptp(p[:, 1]) + 0.3, kind
        labels = {label for _, label in built[seed][f"boat {kind}"]}
        assert labels == {"vehicle"}, kind


def test_a_yachts_wires_are_thin(built):
    """Shrouds and stays run from the deck to the mast as wires of about 8 mm."""
    metal = built[3]["boat sailing_yacht"]["metal", "vehicle"].triangles.astype(np.float64)
    edges = np.linalg.norm(metal - np.roll(metal, 1, axis=1), axis=2)
    long = edges.max(axis=1) > 4.0
    assert long.sum() >= 20
    assert (edges[long].min(axis=1) < 0.009).sum() >= 20


def test_boats_ashore_stand_in_the_sand():
    at, yaw = places(8)
    for k in range(8):
        p = points(scatter_boats(rng(k), at[k : k + 1], yaw[k : k + 1], ashore=True))
        assert -0.45 < p[:, 2].min() - at[k, 2] < 0.0


def test_piers_reach_from_the_deck_into_the_bed(built):
    for seed in (3, 4):
        model = built[seed]["pier"]
        deck = np.concatenate(
            [g.vertices for (_, label), g in model.items() if label == "pavement"]
        )
        assert deck[:, 2].max() == pytest.approx(DECK_M, abs=0.25)
        assert np.median(deck[:, 2]) == pytest.approx(DECK_M, abs=0.35)
        assert np.ptp(deck[:, 0]) == pytest.approx(np.ptp(LINE[:, 0]), abs=5)
        p = points(model)
        low = p[p[:, 2] < bed_m(p) - 0.3]
        assert len(low) > 40 and (low[:, 2] > bed_m(low) - 0.75).all()
        assert {"barrier", "street_furniture", "pole"} <= {label for _, label in model}
        for name, height in (("jetty", 5.5), ("groyne", 7.0), ("breakwater", 9.0)):
            q = points(built[seed][name])
            assert (q[:, 2] < bed_m(q)).any(), name
            assert 1.2 < q[:, 2].max() < height, name


def test_lamps_shine_down(built):
    for seed, name in itertools.product((3, 4), ("pier", "boat trawler", "boat fishing_boat")):
        for (material, _), g in built[seed][name].items():
            if material == "lamp":
                tri = g.triangles.astype(np.float64)
                cross = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
                assert (np.linalg.norm(cross, axis=1) / 2 < 0.3).all()
                if name == "pier":
                    assert (cross[:, 2] < 0).all()


def test_a_lighthouse_shines_outwards_from_its_top(built):
    for seed in (3, 4):
        model, drawn = built[seed]["lighthouse"], draw_lighthouse(rng(seed))
        p = points(model)
        assert 15 < p[:, 2].max() < 42
        assert p[:, 2].min() > -2.0
        assert np.abs(p[:, :2]).max() < 24
        lamp = model["floodlight", "building"].triangles.astype(np.float64)
        middle = lamp.mean(axis=1)
        assert (middle[:, 2] > drawn.height_m).all()
        normal = np.cross(lamp[:, 1] - lamp[:, 0], lamp[:, 2] - lamp[:, 0])
        assert (np.einsum("ij,ij->i", normal[:, :2], middle[:, :2]) > 0).all()
        assert (np.linalg.norm(normal, axis=1) / 2 < 0.3).all()
        yaw = np.arctan2(middle[:, 1], middle[:, 0])
        assert np.diff(np.sort(yaw)).max() < 1.0
        assert ("paint", "barrier") in model


def test_beach_items_stand_on_the_sand_within_their_radius(built):
    assert set(BEACH_RADIUS_M) == set(BEACH_ITEMS)
    for seed, name in itertools.product((3, 4), BEACH_ITEMS):
        p = points(built[seed][f"beach {name}"])
        assert np.hypot(*p[:, :2].T).max() <= BEACH_RADIUS_M[name], name
        assert -1.0 < p[:, 2].min() < 0.012, name
        assert 0.01 < p[:, 2].max() < 9, name


def test_a_volleyball_net_hangs_at_its_height(built):
    fabric = built[3]["beach volleyball_net"]["fabric", "barrier"].vertices
    between_posts = fabric[np.abs(fabric[:, 1]) < 4]
    assert 2.2 < between_posts[:, 2].max() < 2.5
    assert 1.1 < between_posts[:, 2].min() < 1.5


def test_harbour_things_and_buoys_rest_where_they_are_put(built):
    for seed, name in itertools.product((3, 4), HARBOUR_ITEMS):
        low = points(built[seed][f"harbour {name}"])[:, 2].min()
        assert -0.35 < low < 0.012, name
    at = places(12)[0]
    p = points(built[3]["buoys"])
    assert p[:, 2].min() < at[0, 2] - 0.1
    assert p[:, 2].max() > at[:, 2].max() + 0.2


def test_guard_rails_follow_the_ground(built):
    for seed, kind in itertools.product((3, 4), GUARD_RAILS):
        model = built[seed][f"guard rail {kind}"]
        assert {label for _, label in model} == {"barrier"}
        p = points(model)
        gap = np.linalg.norm(p[:, None, :2] - ROAD[None, :, :2], axis=2).min(axis=1)
        near = p[gap < 0.6]
        # Near the line's corners, heights are measured from the corner's ground.
        ground = ROAD[np.linalg.norm(near[:, None, :2] - ROAD[None, :, :2], axis=2).argmin(1), 2]
        assert 0.55 < (near[:, 2] - ground).max() < 1.25, kind
        assert (near[:, 2] - ground).min() < -0.1, kind
    assert len(points(guard_rail(rng(), ROAD, "w_beam", spacing_m=4.0))) < len(
        points(built[3]["guard rail w_beam"])
    )


def test_nets_lie_in_their_own_plane():
    """A hanging net seen from the front shows both its cords, each as wide as it should be."""
    y, z = np.meshgrid(np.linspace(0, 1, 6), np.linspace(0, 1, 6))
    part = net(np.stack([0 * y, y, z], -1), 0.01, (0.5, 0.5, 0.5))
    tri = part.triangles.astype(np.float64)
    area = np.abs(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])[:, 0]).sum() / 2
    assert area == pytest.approx(12 * 0.01, rel=1e-3)


def test_kinds_and_colours_vary():
    colours = [
        boat(rng(k), "motorboat")["car_paint", "vehicle"].tint.mean(axis=0) for k in range(6)
    ]
    assert np.ptp(np.array(colours), axis=0).max() > 0.05
    patterns = {draw_lighthouse(rng(k)).pattern for k in range(12)}
    assert len(patterns) >= 2
    drawn = merge([guard_rail(rng(k), ROAD) for k in range(12)])
    assert {"metal", "wood", "rock"} <= {material for material, _ in drawn}


@pytest.mark.parametrize("make", [boat, beach_item])
def test_an_unknown_kind_lists_the_known_ones(make):
    with pytest.raises(KeyError, match="is not one of"):
        make(rng(), "galleon")
