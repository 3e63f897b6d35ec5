"""The map city: streets and junctions that hold together, and the whole, true to scale."""

import dataclasses
import hashlib

import numpy as np
import pytest
import shapely

from synthdepth.maps.city import CityRanges, city, draw_city
from synthdepth.maps.downtown.blocks import plan_blocks
from synthdepth.maps.downtown.fittings import Fittings
from synthdepth.maps.downtown.furnishing import furnish_junctions, furnish_kerbs
from synthdepth.maps.downtown.grid import LAYOUTS, draw_grid
from synthdepth.maps.downtown.kerbside import draw_kerbsides
from synthdepth.maps.downtown.markings import street_markings
from synthdepth.maps.downtown.overhead import bridged_edges, hang_cables
from synthdepth.maps.downtown.surface import DISC_M, KERB_HEIGHT_M, street_surface
from synthdepth.maps.downtown.traffic import draw_traffic
from synthdepth.maps.geometry import merge
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane
from tests.lights import CLEAR

# Everything is there, in a place small enough to build in a moment.
RANGES = CityRanges(
    flight_area_m=150.0,
    lamp_spacing_m=(30, 30),
    people_per_100m=(3, 3),
    cars_per_km=(15, 15),
    cable_share=(1, 1),
    park_share=(0.2, 0.2),
)


def grid_of(seed, layout):
    return draw_grid(
        lane(seed, "streets"),
        block_length_m=130,
        block_depth_m=72,
        avenue_share=0.3,
        drop_share=0.1,
        layout=layout,
    )


def kerbs_of(grid, **changes):
    wanted = {
        "tree_spacing_m": 9.0,
        "tree_share": 0.7,
        "lamp_spacing_m": 28.0,
        "parked_share": 0.5,
        "furniture_per_100m": 9.0,
        "bridged": [],
        "half_m": 200.0,
    }
    return draw_kerbsides(lane(1, "kerbs"), grid, **(wanted | changes))


@pytest.fixture(scope="module", params=LAYOUTS)
def grid(request):
    return grid_of(3, request.param)


def digest(model):
    total = hashlib.sha256()
    for key in sorted(model):
        total.update(str(key).encode())
        for array in (model[key].vertices, model[key].faces, model[key].uv, model[key].tint):
            total.update(array.tobytes())
    return total.hexdigest()


def test_streets_have_real_widths_and_lanes_keep_right(grid):
    for profile in grid.profiles:
        low, high = {"avenue": (18, 29), "street": (9, 18), "alley": (5, 8)}[profile.kind]
        assert low <= profile.width_m <= high
        if profile.two_way:
            assert all(offset * direction < 0 for offset, direction in profile.lanes)
        edge = profile.carriageway_m / 2 - 1.4
        assert all(abs(offset) <= edge for offset, _ in profile.lanes)


def test_junctions_have_three_arms_and_edges_meet_at_nodes(grid):
    ends = np.concatenate([grid.start, grid.end])
    node = grid.node.T.ravel()
    for number in np.unique(node):
        assert np.ptp(ends[node == number], axis=0).max() < 1e-6
    inner = np.hypot(*ends.T) < 380
    dead_ends = np.isin(node[inner], np.flatnonzero(grid.degree == 1)).mean()
    assert dead_ends < 0.02


def test_setbacks_clear_the_other_carriageways(grid):
    for edge in range(0, len(grid.start), 5):
        low, high = grid.setback_m[edge, 0], grid.length_m[edge] - grid.setback_m[edge, 1]
        if high - low < 10:
            continue
        half = grid.profile(edge).carriageway_m / 2
        s = np.linspace(low + 0.5, high - 0.5, 40)
        for side in (-1, 1):
            beside = grid.at(edge, s, np.full(40, side * (half + 0.3)))
            assert not shapely.contains_xy(grid.carriageway, *beside.T).any()


def test_the_ground_is_closed_and_has_kerbs(grid):
    model = street_surface(lane(1, "ground"), grid)
    disc = shapely.Point(0, 0).buffer(DISC_M - 15)
    road = model["asphalt", "road"].triangles.astype(float)
    a, b = road[:, 1] - road[:, 0], road[:, 2] - road[:, 0]
    area = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    assert area.min() > 0
    assert np.abs(road[..., 2]).max() == 0
    inside = disc.contains(shapely.points(road[..., :2].mean(axis=1)))
    wanted = shapely.intersection(grid.carriageway, disc).area
    assert area[inside].sum() == pytest.approx(wanted, rel=0.01)
    pavement = np.concatenate(
        [part.vertices for (_, label), part in model.items() if label == "pavement"]
    )
    assert pavement[:, 2].max() == pytest.approx(KERB_HEIGHT_M)
    longest = np.linalg.norm(road - np.roll(road, 1, axis=1), axis=2).max()
    assert longest < 40


def test_paint_lies_on_the_carriageway(grid):
    model = street_markings(lane(1, "markings"), grid, kerbs_of(grid), 200.0)
    paint = model["road_paint", "road"]
    middle = paint.triangles.mean(axis=1)
    on = shapely.contains_xy(grid.carriageway, middle[:, 0], middle[:, 1])
    assert on.mean() > 0.995
    assert 0.005 < paint.vertices[:, 2].min() <= paint.vertices[:, 2].max() < 0.03
    normal = np.cross(*np.diff(paint.triangles, axis=1).transpose(1, 0, 2))
    assert normal[:, 2].min() > 0


def test_kerbside_things_stand_on_the_pavement_and_apart(grid):
    for kerb in kerbs_of(grid):
        rows = np.concatenate([kerb.lamps_m, kerb.trees_m])
        at = kerb.at(grid, rows, 0.9)
        assert not shapely.contains_xy(grid.carriageway, *at.T).any()
        assert shapely.contains_xy(grid.street_land, *at.T).all()
        gaps = np.diff(np.sort(rows))
        assert not len(gaps) or gaps.min() > 5.0
        if kerb.stop_m is not None and len(kerb.parked_m):
            assert np.abs(kerb.parked_m - kerb.stop_m).min() > 12


def test_vehicles_stand_on_the_carriageway_and_in_nobodys_way(grid):
    kerbs = kerbs_of(grid)
    drawn = draw_traffic(lane(2, "traffic"), grid, kerbs, cars_per_km=30, reach_m=300)
    rows = np.concatenate([drawn.cars, drawn.taxis, drawn.vans, drawn.buses])
    assert len(drawn.cars) > 300
    assert shapely.contains_xy(grid.carriageway, rows[:, 0], rows[:, 1]).all()
    u = np.stack([np.cos(drawn.cars[:, 2]), np.sin(drawn.cars[:, 2])], 1)
    boxes = shapely.linestrings(
        np.stack([drawn.cars[:, :2] - 2.0 * u, drawn.cars[:, :2] + 2.0 * u], 1)
    ).tolist()
    boxes = shapely.buffer(boxes, 0.8, cap_style="flat")
    a, b = shapely.STRtree(boxes).query(boxes, predicate="overlaps")
    assert not (a != b).any()


def test_a_bridge_keeps_its_stairs_free():
    grid = grid_of(3, "grid")
    bridged = bridged_edges(grid, 1)
    kerbs = [k for k in kerbs_of(grid, bridged=bridged) if k.edge in bridged]
    for kerb in kerbs:
        middle = sum(kerb.span_m) / 2
        rows = np.concatenate([kerb.lamps_m, kerb.trees_m, [s for _, s, _ in kerb.small]])
        assert not len(rows) or np.abs(rows - middle).min() > 14


def test_recipes_reach_the_place():
    one, other = (draw_city(lane(seed, "character"), RANGES) for seed in (0, 1))
    assert one.drawn != other.drawn
    assert one.drawn["cable_share"] == 1
    empty = dataclasses.replace(RANGES, cars_per_km=(0, 0), parked_share=(0, 0))
    assert draw_city(lane(0, "character"), empty).drawn["cars_per_km"] == 0
    grid = grid_of(1, "grid")
    kerbs = kerbs_of(grid, parked_share=0.0, tree_share=0.0)
    assert sum(len(kerb.parked_m) + len(kerb.trees_m) for kerb in kerbs) == 0


def streets_of(seed):
    """A digest of all that a seed puts on the streets."""
    grid = grid_of(seed, "diagonal")
    kerbs = kerbs_of(grid)
    drawn = draw_traffic(lane(seed, "traffic"), grid, kerbs, cars_per_km=20, reach_m=120)
    out = Fittings()
    wanted = {"people_per_100m": 4, "lamp": "cobra", "cafes": 1, "half_m": 60}
    furnish_kerbs(lane(seed, "furnishing"), grid, kerbs, out, **wanted)
    furnish_junctions(lane(seed, "junctions"), grid, out, people=0.5, half_m=60)
    models = [
        street_surface(lane(seed, "ground"), grid),
        street_markings(lane(seed, "markings"), grid, kerbs, 60.0),
        *out.models,
    ]
    tables = [out.rows(kind) for kind in ("furniture", "lamps", "signs", "trees", "people")]
    rows = [table[name] for table in tables for name in table]
    rows += [drawn.cars, drawn.taxis, drawn.vans, drawn.buses]
    places = hashlib.sha256(b"".join(row.tobytes() for row in rows)).hexdigest()
    return digest(merge(models)), places


def test_a_seed_always_builds_the_same_streets_and_others_build_others():
    first, again, other = streets_of(4), streets_of(4), streets_of(5)
    assert first == again
    assert first[0] != other[0]
    assert first[1] != other[1]


def test_wires_hang_clear_of_the_traffic():
    grid = grid_of(2, "grid")
    blocks = plan_blocks(
        lane(2, "blocks"),
        grid,
        storeys_range=(4, 8),
        core_storeys=12,
        core_m=100,
        park_share=0,
        plaza_share=0,
        parking_share=0,
        construction=0,
    )
    out = Fittings()
    rng = lane(2, "cables")
    lots = list(blocks.lots)
    hang_cables(rng, grid, kerbs_of(grid), lots, out, share=1.0, bridged=[], half_m=150)
    wires = [part for model in out.models for (_, label), part in model.items() if label == "wire"]
    points = np.concatenate([part.vertices for part in wires])
    assert len(wires) > 40
    assert points[:, 2].min() > 4.5
    assert points[:, 2].max() < 12


@pytest.fixture(scope="module")
def world():
    return city(5, RANGES, CLEAR)


def test_everything_that_a_city_has_is_there(world):
    labels = {label for _, label in world.surfaces}
    assert labels <= set(LABELS)
    assert {
        "ground", "road", "pavement", "building", "roof", "vegetation", "tree_trunk", "vehicle",
        "person", "pole", "wire", "street_furniture", "hill",
    } <= labels  # fmt: skip
    assert 5e5 < world.triangle_count < 4e6
    assert {name for name, _ in world.surfaces} == set(world.materials)


def test_numbers_are_finite_and_faces_are_whole(world):
    for part in world.surfaces.values():
        assert np.isfinite(part.vertices).all()
        assert np.isfinite(part.uv).all()
        assert part.faces.min() >= 0
        assert part.faces.max() < len(part.vertices)
        assert part.tint.min() >= 0
        assert part.vertices.dtype == part.uv.dtype == part.tint.dtype == np.float32


def test_the_ground_is_level_and_things_stand_on_it(world):
    assert (world.ground_m(np.zeros((3, 2))) == 0).all()
    for wanted in ("vehicle", "person", "tree_trunk", "pole"):
        parts = [part.vertices for (_, label), part in world.surfaces.items() if label == wanted]
        vertices = np.concatenate(parts)
        near = np.abs(vertices[:, :2]).max(axis=1) < 300
        assert -1.0 < vertices[near, 2].min() < 0.2, wanted


def test_hills_and_towers_close_the_horizon_all_around(world):
    hill = world.surfaces["hill", "hill"].vertices
    azimuth = np.degrees(np.arctan2(hill[:, 1], hill[:, 0])) % 360
    top = [hill[np.abs(azimuth - a) <= 2.5, 2].max() for a in np.arange(2.5, 360, 5)]
    assert min(top) > 80
