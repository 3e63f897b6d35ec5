"""People: scale, feet on the ground, dress, variety, determinism."""

import numpy as np
import pytest

from synthdepth.maps.materials.catalogue import CATALOGUE
from synthdepth.maps.people import POSES, people
from synthdepth.maps.people.body import person
from synthdepth.maps.people.crowd import draw_person
from synthdepth.maps.people.skeleton import SEAT_M, posed, varied

COUNT = 32
KIT = (0.4, 0.03, 0.03)


def rng(seed: int = 5) -> np.random.Generator:
    return np.random.default_rng(seed)


def spread() -> np.ndarray:
    """Places so far apart that nobody's vertices are another's."""
    return np.column_stack([np.arange(COUNT) * 5.0, np.zeros(COUNT), np.zeros(COUNT)])


@pytest.fixture(scope="module")
def crowds() -> dict:
    models = {name: people(rng(), spread(), 0.3, pose=name) for name in POSES}
    return models | {"mixed": people(rng(), spread(), 0.3)}


def heights(model) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest point of everybody, (COUNT,) each."""
    points = np.concatenate([g.vertices for g in model.values()])
    who = np.round(points[:, 0] / 5).astype(int)
    low, high = np.full(COUNT, np.inf), np.full(COUNT, -np.inf)
    np.minimum.at(low, who, points[:, 2])
    np.maximum.at(high, who, points[:, 2])
    return low, high


def test_soles_are_on_the_ground(crowds):
    for name, model in crowds.items():
        low, _ = heights(model)
        assert low.min() > -0.06, name
        if name != "sitting":
            assert low.max() < 0.02, name


def test_statures_are_those_of_children_and_adults(crowds):
    _, high = heights(crowds["standing"])
    assert 1.1 < high.min() < 1.6
    assert 1.7 < high.max() < 2.05
    _, seated = heights(crowds["sitting"])
    assert seated.min() > 0.95 and seated.max() < 1.6
    _, raised = heights(crowds["arms_up"])
    assert raised.max() > 2.0


def test_those_who_sit_rest_on_the_seat():
    generator = rng()
    for body_m in (1.3, 1.7, 1.95):
        hips = posed(varied(generator, "sitting"), body_m).legs[:, 0, 2]
        assert np.all(hips > SEAT_M) and np.all(hips < SEAT_M + 0.12)


def test_joints_keep_their_lengths():
    generator = rng()
    for name in POSES:
        skeleton = posed(varied(generator, name), 1.8)
        shank = np.linalg.norm(skeleton.legs[:, 2] - skeleton.legs[:, 1], axis=1)
        forearm = np.linalg.norm(skeleton.arms[:, 2] - skeleton.arms[:, 1], axis=1)
        np.testing.assert_allclose(shank, 0.246 * 1.8, rtol=0.02)
        np.testing.assert_allclose(forearm, 0.146 * 1.8, rtol=1e-6)


def test_geometry_is_sound_and_small(crowds):
    for name, model in crowds.items():
        assert sum(len(g.faces) for g in model.values()) < 1000 * COUNT
        for (material, label), g in model.items():
            assert material in CATALOGUE and label == "person"
            assert g.vertices.dtype == g.uv.dtype == g.tint.dtype == np.float32
            assert g.faces.dtype == np.int32 and g.faces.max() < len(g.vertices)
            assert g.tint.min() > 0 and g.tint.max() <= 0.9, name
            tri = g.triangles.astype(np.float64)
            area = np.linalg.norm(np.cross(tri[:, 1] - tri[:, 0], tri[:, 2] - tri[:, 0]), axis=1)
            assert area.min() > 2e-9, name


def test_people_face_their_yaw():
    """Toes point forwards of the heels."""
    model = people(rng(), [[0, 0, 0]], np.pi / 2, pose="standing")
    points = np.concatenate([g.vertices for g in model.values()])
    feet = points[points[:, 2] < 0.03]
    assert feet[:, 1].max() > 0.1
    assert -feet[:, 1].min() < 0.15


def test_most_dress_dark_and_no_two_alike(crowds):
    clothes = crowds["mixed"]["fabric", "person"]
    light = clothes.tint @ np.float32([0.21, 0.72, 0.07])
    assert np.median(light) < 0.2
    assert len(np.unique(np.round(clothes.tint, 4), axis=0)) > 2 * COUNT


def test_players_wear_their_kit():
    model = people(rng(), spread(), 0.0, pose="player_kick", kit=KIT)
    tint = model["fabric", "person"].tint
    share = np.isclose(tint, KIT, rtol=0.1).all(axis=1).mean()
    assert share > 0.3
    both = people(rng(), spread(), 0.0, kit=np.tile([KIT, (0.02, 0.05, 0.3)], (COUNT // 2, 1)))
    blue = np.isclose(both["fabric", "person"].tint, (0.02, 0.05, 0.3), rtol=0.1).all(axis=1)
    assert blue.mean() > 0.15


def test_builds_and_clothes_vary():
    drawn = [draw_person(rng(i), "standing") for i in range(60)]
    assert len({p.top for p in drawn}) >= 4
    assert len({p.hair for p in drawn}) >= 5
    assert np.ptp([p.girth for p in drawn]) > 0.2
    assert any(p.stature_m < 1.5 for p in drawn) and any(p.bag == "backpack" for p in drawn)


def test_every_garment_can_be_built():
    for seed in range(25):
        parts = person(draw_person(rng(seed), "walking"))
        assert len(parts["skin"].faces) and len(parts["top"].faces) and len(parts["shoes"].faces)


def test_the_same_draw_builds_the_same_bytes(crowds):
    again = people(rng(), spread(), 0.3)
    other = people(rng(6), spread(), 0.3)
    for key, g in crowds["mixed"].items():
        assert g.vertices.tobytes() == again[key].vertices.tobytes()
        assert g.tint.tobytes() == again[key].tint.tobytes()
    assert any(g.vertices.tobytes() != other[k].vertices.tobytes()
               for k, g in crowds["mixed"].items())  # fmt: skip


def test_nobody_and_unknown_poses():
    assert people(rng(), np.zeros((0, 3)), 0.0) == {}
    with pytest.raises(KeyError, match=r"pose 'flying' is not one of .*walking"):
        people(rng(), [[0, 0, 0]], 0.0, pose="flying")
