import dataclasses
import itertools

import numpy as np
import pytest
import shapely

from synthdepth.maps.houses.facets import Facets
from synthdepth.maps.houses.house import House, draw_house, house
from synthdepth.maps.houses.openings import KINDS, Opening, OpeningFinish, Wall, add_walls
from synthdepth.maps.houses.roofs import Roof, add_roof, ridge_height, roof_height
from synthdepth.maps.houses.styles import STYLES
from synthdepth.maps.world import LABELS
from synthdepth.seeding import lane

LOT = (24.0, 38.0)
MATERIALS = {"siding", "plaster", "shingle", "roof_tile", "brick", "wood", "paint", "fabric"} | {
    "paving",
    "concrete",
    "gravel",
    "metal",
    "glass",
}
FINISH = OpeningFinish(
    reveal_m=0.15,
    casing_m=0.1,
    reveal=("paint", (0.6, 0.6, 0.6)),
    trim=(0.6, 0.6, 0.6),
    frame=(0.6, 0.6, 0.6),
    door=(0.1, 0.1, 0.1),
    garage=(0.6, 0.6, 0.6),
    shutter=(0.1, 0.1, 0.1),
    sill=("paint", (0.6, 0.6, 0.6)),
)


def sample(style: str, index: int = 0) -> House:
    return draw_house(lane(7, style, index), style, *LOT)


def triangles(model) -> np.ndarray:
    return np.concatenate([g.triangles for g in model.values()]).astype(np.float64)


def areas(tri: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1) / 2


def normals(tri: np.ndarray) -> np.ndarray:
    n = np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0])
    return n / np.linalg.norm(n, axis=1, keepdims=True)


@pytest.mark.parametrize("style", STYLES)
def test_a_house_is_sound_and_within_budget(style):
    for index in range(4):
        params = sample(style, index)
        for detail, limit in ((1, 4800), (0, 500)):
            model = house(params, detail)
            tri = triangles(model)
            assert 80 < len(tri) <= limit
            assert np.isfinite(tri).all()
            assert areas(tri).min() > 1e-7
            for (material, label), part in model.items():
                assert material in MATERIALS
                assert label in LABELS
                assert part.vertices.dtype == part.uv.dtype == part.tint.dtype == np.float32
                assert part.faces.dtype == np.int32
                assert (part.tint > 0).all()
                assert (part.tint <= 1.3).all()


@pytest.mark.parametrize("style", STYLES)
def test_a_house_keeps_its_scale_and_its_lot(style):
    for index in range(6):
        params = sample(style, index)
        tri = triangles(house(params))
        x0, y0, x1, y1 = params.bounds
        assert y1 - y0 <= LOT[0] - 3.0
        assert x1 - x0 <= LOT[1] - 8.0
        # Eaves, steps and air conditioner come out of the footprint, by this much at most.
        assert (tri.min((0, 1))[:2] > [x0 - 1.3, y0 - 1.3]).all()
        assert (tri.max((0, 1))[:2] < [x1 + 1.3, y1 + 1.3]).all()
        storeys = params.blocks[0].storeys
        assert 2.8 * storeys < tri[..., 2].max() < 2.8 * storeys + 7.5
        # Walls reach half a metre into the ground.
        assert tri[..., 2].min() == pytest.approx(-0.5)


@pytest.mark.parametrize("style", STYLES)
def test_no_two_faces_lie_in_one_another(style):
    tri = triangles(house(sample(style, 1)))
    n = normals(tri)
    plane = np.round(np.column_stack([200 * n, 1000 * (n * tri[:, 0]).sum(1)])).astype(int)
    _, group = np.unique(plane, axis=0, return_inverse=True)
    order = np.argsort(group.ravel(), kind="stable")
    for same in np.split(order, np.flatnonzero(np.diff(group.ravel()[order])) + 1):
        axes = np.argsort(np.abs(n[same[0]]))[:2]
        flat = shapely.polygons(tri[same][:, :, axes])
        first, second = shapely.STRtree(flat).query(flat, "intersects")
        pairs = first < second
        shared = shapely.intersection(flat[first[pairs]], flat[second[pairs]])
        # Corners of hidden boards may touch; a visible patch may not.
        assert shapely.area(shared).max(initial=0) < 0.012


def test_a_seed_gives_the_same_bytes_and_others_differ():
    def blob(index):
        model = house(sample("tudor", index))
        return b"".join(
            repr(k).encode()
            + g.vertices.tobytes()
            + g.faces.tobytes()
            + g.uv.tobytes()
            + g.tint.tobytes()
            for k, g in model.items()
        )

    blobs = [blob(k) for k in (0, 1, 2)]
    assert blob(0) == blobs[0]
    assert len(set(blobs)) == 3


def test_an_unknown_style_lists_the_known():
    with pytest.raises(KeyError, match="brick_ranch"):
        draw_house(lane(0, "x"), "castle", *LOT)


def test_door_path_and_driveway_meet_the_house():
    for style, index in itertools.product(STYLES, range(4)):
        params = sample(style, index)
        main = params.blocks[0].rect
        x, y = params.entrance
        assert main[1] < y < main[3]
        assert main[2] < x < main[2] + 4.5
        tri = triangles(house(params))
        near = tri[(np.abs(tri[..., 1] - y) < 0.9).any(1) & (tri[..., 0] < x + 0.01).all(1)]
        # The last step ends at the entrance and is low enough to take.
        assert x - 0.32 < near[near[..., 2].max(1) < 0.2][..., 0].max() <= x + 0.01
        if params.driveway is not None:
            garage = next(b for b in params.blocks if b.role == "garage")
            assert params.driveway.x_m == garage.rect[2]
            assert garage.rect[1] < params.driveway.y_m < garage.rect[3]
            assert params.driveway.width_m < garage.rect[3] - garage.rect[1]


def test_narrow_lots_still_get_a_house():
    for style in STYLES:
        for index in range(3):
            params = draw_house(lane(3, style, index), style, 12.0, 30.0)
            _, y0, _, y1 = params.bounds
            assert y1 - y0 < 10.0
            assert len(triangles(house(params))) > 500


def test_a_cut_wall_and_its_filling_leave_no_hole_and_no_overlap():
    walls = [Wall((0.0, 0.0), (1.0, 0.0), 6.0, 0.0, 2.8, ("brick", "building"), (0.2, 0.1, 0.1))]
    holes = [
        Opening(0, 4.0, 5.0, 0.0, 2.1, "door_panel"),
        Opening(0, 1.0, 2.2, 0.9, 2.1, "double_hung"),
    ]
    facets = Facets()
    add_walls(facets, lane(0, "wall"), walls, holes, FINISH)
    model = facets.model()
    wall = triangles({"w": model["brick", "building"]})
    assert areas(wall).sum() == pytest.approx(6 * 2.8 - 1.0 * 2.1 - 1.2 * 1.2, rel=1e-5)
    # Looking along +y, whatever is not brick is covered once or more behind or before it.
    rest = triangles({k: g for k, g in model.items() if k[0] != "brick"})
    facing = rest[normals(rest)[:, 1] < -0.9]
    glass = model["glass", "building"].vertices
    assert glass[:, 1].min() > FINISH.reveal_m
    assert glass[:, 1].max() < FINISH.reveal_m + 0.07
    rng = lane(0, "points")
    for opening in holes:
        s = rng.uniform(opening.s0, opening.s1, 300)
        z = rng.uniform(opening.z0, opening.z1, 300)
        a, b, c = (facing[:, k][:, [0, 2]] for k in range(3))

        def side(p, q, x, y):
            return (q[:, 0] - p[:, 0])[:, None] * (y - p[:, 1][:, None]) - (q[:, 1] - p[:, 1])[
                :, None
            ] * (x - p[:, 0][:, None])

        inside = (side(a, b, s, z) >= -1e-9) & (side(b, c, s, z) >= -1e-9)
        inside &= side(c, a, s, z) >= -1e-9
        assert inside.any(0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_panes_end_behind_bars(kind):
    k = KINDS[kind]
    assert k.bar_columns % k.pane_columns == 0
    assert k.bar_rows % k.pane_rows == 0


@pytest.mark.parametrize("ridge", ["x", "y"])
@pytest.mark.parametrize("form", ["gable", "hip", "shed"])
def test_roofs_slope_outwards_at_their_pitch(form, ridge):
    roof = Roof(form=form, ridge=ridge, pitch_deg=30.0, eaves_m=0.5, capped=False)
    rect, plate = ((-6.0, -4.0, 6.0, 4.0) if ridge == "x" else (-4.0, -6.0, 4.0, 6.0)), 3.0
    facets = Facets()
    cover, wall = ("shingle", (0.1, 0.1, 0.1)), ("siding", (0.5, 0.5, 0.5))
    add_roof(facets, rect, plate, roof, cover, (0.6,) * 3, (0.6,) * 3, wall)
    model = facets.model()
    tri = triangles({"r": model["shingle", "roof"]})
    up = normals(tri)[:, 2]
    assert up == pytest.approx(np.cos(np.radians(30)), rel=1e-5)
    # The covering is where roof_height says, at its own corners and in between.
    for weights in ([1, 0, 0], [0.2, 0.3, 0.5]):
        for p in np.einsum("tcx,c->tx", tri, weights):
            assert roof_height(rect, plate, roof, p[0], p[1]) == pytest.approx(p[2], abs=1e-3)
    assert tri[..., 2].max() <= ridge_height(rect, plate, roof) + (4.0 if form == "shed" else 1e-4)
    # Gable walls stay under the covering and face away from the middle.
    if ("siding", "building") in model:
        gable = triangles({"g": model["siding", "building"]})
        out = (normals(gable) * gable.mean(1))[:, :2].sum(1)
        assert (out > 0).all()
        tops = [roof_height(rect, plate, roof, *p[:2]) - p[2] for p in gable.reshape(-1, 3)]
        assert min(tops) > 0.1


def test_boxes_face_outwards_and_buried_bottoms_are_left_out():
    facets = Facets()
    facets.box(("paint", "building"), (1, 1, 1), (1, 1, 1), (2, 3, 4))
    tri = triangles(facets.model())
    assert len(tri) == 12
    assert (np.einsum("tx,tx->t", normals(tri), tri.mean(1) - [1.5, 2, 2.5]) > 0).all()
    facets.box(("paint", "building"), (1, 1, 1), (5, 5, -1), (6, 6, 1), without=2)
    assert len(facets.model()["paint", "building"].faces) == 12 + 8
    assert areas(triangles(facets.model())).min() > 0


def test_every_field_of_a_house_is_plain_data():
    params = sample("mediterranean")
    assert dataclasses.asdict(params)["style"] == "mediterranean"
    assert dataclasses.replace(params) == params
