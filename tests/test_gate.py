"""The gate: wrong pairs of every kind are found, right ones never; no evidence, no verdict."""

import dataclasses

import cv2
import numpy as np
import pytest

from synthdepth.camera import Intrinsics, pitch_roll_deg, project, unproject
from synthdepth.dataset.gate import gate_pair, gate_shard
from synthdepth.dataset.gate_check import Check, mean_and_sigmas
from synthdepth.dataset.gate_edges import edge_checks
from synthdepth.dataset.gate_warp import Warp, moved_px, warp_checks
from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.pair import decode_pair
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.production.recast import recast_faults
from tests.made import make_dataset

CAMERA = Intrinsics.from_fov(208, 160, 90.0)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """(manifest, [(record, pair)]) of a wall over a ground, seen from two flights."""
    folder = make_dataset(
        tmp_path_factory.mktemp("gate") / "set", shards=2, pairs=9, camera=CAMERA,
        modalities=("flow",),
    )  # fmt: skip
    manifest = read_manifest(folder)
    found = []
    for record in manifest["shards"]:
        path = folder / record["path"]
        for key, members in shard_members(path).items():
            found.append((record, decode_pair(key, read_members(path, members))))
    return manifest, found


def replaced(pair, **changes):
    """The pair with other images or metadata, its derived fields made to fit the depth again."""
    images = {name: changes.pop(name) for name in ("rgb", "prev", "depth_m") if name in changes}
    depth_m = np.ascontiguousarray(images.get("depth_m", pair.depth_m), np.float32)
    images["depth_m"] = depth_m
    pose = np.array(changes.get("world_from_cam", pair.meta["world_from_cam"]))
    moved = pose - np.array(changes.get("world_from_cam_prev", pair.meta["world_from_cam_prev"]))
    velocity = moved[:3, 3] / pair.meta["dt_s"]
    pitch, roll = pitch_roll_deg(pose)
    fitting = {
        "nearest_depth_m": float(depth_m.min()),
        "median_depth_m": float(np.median(depth_m)),
        "in_range_share": float(np.mean(depth_m < 200)),
        "clearance_m": 0.0,
        "velocity_mps": velocity.tolist(),
        "speed_mps": float(np.linalg.norm(velocity)),
        "pitch_deg": pitch,
        "roll_deg": roll,
    }
    meta = {**pair.meta, **fitting, **changes}
    return dataclasses.replace(pair, flow=None, visible=None, meta=meta, **images)


def scaled(pair, factor):
    far = pair.depth_m >= 200
    return np.where(far, pair.depth_m, np.minimum(pair.depth_m * factor, 200))


def flipped(image, *axes):
    return np.ascontiguousarray(np.flip(image, axes))


# What is done to a pair, and what the gate has to say. The other pair is of another flight.
CORRUPTIONS = {
    "too far": (lambda p, o: {"depth_m": scaled(p, 1.4)}, "depth is too large"),
    "too near": (lambda p, o: {"depth_m": scaled(p, 1 / 1.4)}, "depth is too small"),
    "kilometres": (lambda p, o: {"depth_m": scaled(p, 1e-3)}, "is not frame t"),
    "ray length": (
        lambda p, o: {"depth_m": scaled(p, np.linalg.norm(p.camera.rays(), axis=-1))},
        "the pictures say",
    ),
    "upside down": (lambda p, o: {"depth_m": flipped(p.depth_m, 0)}, "mirrored"),
    "turned": (lambda p, o: {"depth_m": flipped(p.depth_m, 0, 1)}, "mirrored"),
    "mirrored picture": (lambda p, o: {"rgb": flipped(p.rgb, 1)}, "is not frame t"),
    "frames exchanged": (lambda p, o: {"rgb": p.prev, "prev": p.rgb}, "exchanged"),
    "poses exchanged": (
        lambda p, o: {
            "world_from_cam": p.meta["world_from_cam_prev"],
            "world_from_cam_prev": p.meta["world_from_cam"],
        },
        "exchanged",
    ),
    "another rgb": (lambda p, o: {"rgb": o.rgb}, "is not frame t"),
    "another prev": (lambda p, o: {"prev": o.prev}, "is not frame t"),
    "frozen": (lambda p, o: {"prev": p.rgb}, "though the camera moved"),
    "black": (lambda p, o: {"rgb": np.zeros_like(p.rgb)}, "black"),
    "burnt out": (lambda p, o: {"prev": np.full_like(p.prev, 255)}, "burnt out"),
    "one colour": (lambda p, o: {"prev": np.full_like(p.prev, 90)}, "of one colour"),
    "a hole": (lambda p, o: {"depth_m": p.depth_m * (p.depth_m > p.depth_m.min())}, "0.0 m"),
    "beyond": (lambda p, o: {"depth_m": np.where(p.depth_m >= 200, 250, p.depth_m)}, "beyond"),
    "nan": (lambda p, o: {"depth_m": np.where(p.depth_m >= 200, np.nan, p.depth_m)}, "finite"),
    "another course": (lambda p, o: {"velocity_mps": [0.0, 8.0, 0.0]}, "from what velocity_mps"),
    "another pitch": (lambda p, o: {"pitch_deg": 12.0}, "pitch or roll"),
    "too near for its clearance": (lambda p, o: {"clearance_m": 90.0}, "clearance_m says"),
    "another key": (lambda p, o: {"frame_index": 77}, "is of the pair"),
    "another map": (lambda p, o: {"map": "city"}, "its shard's is 'blocks'"),
}  # fmt: skip


def test_right_pairs_pass(made):
    manifest, pairs = made
    for record, pair in pairs:
        checks = gate_pair(pair, record, manifest)
        assert [check.fault for check in checks if check.fault] == []
        # Not because nobody asked: there is texture and motion.
        assert all(check.effect is not None for check in checks if check.subject == "warp")


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_wrong_pairs_do_not(made, name):
    manifest, pairs = made
    manifest = manifest | {"recipe": manifest["recipe"] | {"render": {"modalities": []}}}
    change, told = CORRUPTIONS[name]
    (record, pair), (_, other) = pairs[2], pairs[-1]
    checks = gate_pair(replaced(pair, **change(pair, other)), record, manifest)
    faults = [check.fault for check in checks if check.fault]
    assert any(part in fault for fault in faults for part in told.split("|")), faults


def test_a_pair_alone_is_as_good_as_its_replacement(made):
    """The corruptions above are found by what they change, not by how they are made."""
    manifest, pairs = made
    manifest = manifest | {"recipe": manifest["recipe"] | {"render": {"modalities": []}}}
    record, pair = pairs[2]
    assert not [c.fault for c in gate_pair(replaced(pair), record, manifest) if c.fault]


def test_flow_that_depth_and_poses_do_not_give_is_found(made):
    manifest, pairs = made
    record, pair = pairs[0]
    wrong = dataclasses.replace(pair, flow=pair.flow + np.float32(0.02))
    faults = [check.fault for check in gate_pair(wrong, record, manifest) if check.fault]
    assert len(faults) == 1 and "px from what depth and poses say" in faults[0]


@pytest.mark.parametrize("what", ["dark", "fog", "no motion", "no texture"])
def test_without_evidence_there_is_no_verdict(made, what):
    """Wrong depth that no picture can contradict."""
    manifest, pairs = made
    manifest = manifest | {"recipe": manifest["recipe"] | {"render": {"modalities": []}}}
    record, pair = pairs[2]
    rng = np.random.default_rng(0)
    grain = [rng.normal(0, 2, pair.rgb.shape) for _ in range(2)]
    changes = {"depth_m": scaled(pair, 1.4)}
    if what in ("dark", "fog", "no texture"):
        ramp = np.linspace(0, 30, CAMERA.width)[:, None]
        level = {"dark": 30, "fog": 180 + ramp, "no texture": 120 + ramp}[what]
        images = (np.clip(level + g, 0, 255).astype(np.uint8) for g in grain)
        changes |= dict(zip(("rgb", "prev"), images, strict=True))
    else:
        still = np.clip(pair.rgb + grain[0], 0, 255).astype(np.uint8)
        changes |= {"prev": still, "world_from_cam_prev": pair.meta["world_from_cam"]}
    checks = gate_pair(replaced(pair, **changes), record, manifest)
    assert [check.fault for check in checks if check.fault] == []


def test_the_warp_is_the_projection(made):
    _, pairs = made
    for _, pair in pairs[::4]:
        motion = np.linalg.inv(pair.world_from_cam_prev) @ pair.world_from_cam
        x, y, inside = Warp(CAMERA, motion)(1 / pair.depth_m)
        place = unproject(pair.depth_m, CAMERA, pair.world_from_cam)
        uv, z = project(place, CAMERA, pair.world_from_cam_prev)
        np.testing.assert_allclose(np.stack([x, y], -1)[z > 0.1], uv[z > 0.1], atol=0.01)
        safely = (uv > 0.01).all(-1) & (uv < [CAMERA.width - 1.01, CAMERA.height - 1.01]).all(-1)
        assert inside[safely].all()
        seen = pair.flow[pair.visible & (pair.depth_m < 200)]
        assert moved_px(pair) < np.linalg.norm(seen, axis=-1).max()


# Edges: cards of many sizes and depths before a far wall, each with a grey of its own.


def cards(seed, shift=(0, 0)):
    """A pair of pictures and depths of cards; the depth is shifted by (x, y) [px]."""
    rng = np.random.default_rng(seed)
    grey = np.full((256, 256), 120.0)
    depth = np.full((256, 256), 150.0, np.float32)
    for z in np.sort(rng.uniform(5, 60, 90))[::-1]:
        (x, y), (w, h) = rng.integers(0, 250, 2), rng.integers(10, 40, 2)
        grey[y : y + h, x : x + w] = rng.uniform(30, 220)
        depth[y : y + h, x : x + w] = z
    grey = cv2.GaussianBlur(grey, (0, 0), 0.6) + rng.normal(0, 3, grey.shape)
    picture = np.clip(grey, 0, 255).astype(np.uint8)[..., None].repeat(3, axis=-1)
    return picture, np.roll(depth, shift, axis=(1, 0))


def of_cards(pair, seed, depth_seed=None, **options):
    picture, _ = cards(seed)
    _, depth_m = cards(seed if depth_seed is None else depth_seed, **options)
    meta = {**pair.meta, "width": 256, "height": 256, "visibility_m": 1e4}
    return dataclasses.replace(pair, rgb=picture, depth_m=depth_m, meta=meta)


@pytest.mark.parametrize(
    ("shift", "told"),
    [((0, 0), []), ((1, 0), ["to the right"]), ((-1, 0), ["to the left"]), ((0, 1), ["down"]),
     ((0, -1), ["up"]), ((1, 1), ["to the right", "down"])],
)  # fmt: skip
def test_depth_beside_the_picture_is_found(made, shift, told):
    _, ((_, pair), *_) = made
    for seed in range(3):
        checks = edge_checks(of_cards(pair, seed, shift=shift))
        faults = [check.fault for check in checks if check.fault]
        assert len(faults) == len(told), faults
        assert all(fault.endswith(way) for fault, way in zip(faults, told, strict=True))


def test_depth_of_another_place_has_its_edges_elsewhere(made):
    """What speaks against the pair is far more; by one picture alone it need not be a fault."""
    _, ((_, pair), *_) = made

    def against(**options):
        checks = edge_checks(of_cards(pair, 0, **options))
        return next(check.effect for check in checks if check.name == "height")

    assert all(against(depth_seed=other) > against() + 0.3 for other in (9, 10, 11))


def test_mirrored_depth_has_its_edges_elsewhere(made):
    _, ((_, pair), *_) = made
    right = of_cards(pair, 1)
    wrong = dataclasses.replace(right, depth_m=flipped(right.depth_m, 1))
    faults = [check.fault for check in edge_checks(wrong) if check.fault]
    assert any("mirrored (left-right)" in fault for fault in faults)


# Many pairs together


def test_what_no_single_pair_shows_all_together_do():
    rng = np.random.default_rng(0)

    def pairs(effect):
        values = rng.normal(effect, 0.004, 30)
        return [[Check(subject="warp", name="x", effect=v, limit=0.002, told="!")] for v in values]

    assert [check.fault for check in gate_shard(pairs(0.01))] == ["30 pairs together: !"]
    assert gate_shard(pairs(-0.01)) == gate_shard(pairs(0.0)) == []
    assert gate_shard(pairs(0.01)[:3]) == []


def test_a_wrong_scale_in_every_pair_is_found_together(made):
    _, pairs = made
    right = [warp_checks(pair) for _, pair in pairs]
    wrong = [warp_checks(replaced(pair, depth_m=scaled(pair, 1.2))) for _, pair in pairs]
    assert gate_shard(right) == []
    assert any("too large" in check.fault for check in gate_shard(wrong))


def test_sigmas_are_those_of_the_mean():
    values = np.random.default_rng(1).normal(0.3, 2.0, 400)
    mean, sigmas = mean_and_sigmas(values)
    assert mean == pytest.approx(values.mean())
    assert sigmas == pytest.approx(values.mean() / (values.std(ddof=1) / 20))


# Against the world: the same wall and ground, by formula.


def reach(world_from_cam, directions):
    """As `Renderer.reach`, of the wall and the ground of `tests.made`."""
    at = world_from_cam[:3, 3]
    with np.errstate(divide="ignore"):
        ground, wall = -at[2] / directions[:, 2], (60.0 - at[0]) / directions[:, 0]
    ground, wall = np.where(ground > 0, ground, np.inf), np.where(wall > 0, wall, np.inf)
    top = at[2] + np.where(np.isinf(wall), 0, wall) * directions[:, 2]
    return np.minimum(ground, np.where(top < 25, wall, np.inf)).astype(np.float32)


def recast(pair, reach=reach):
    return list(recast_faults(np.random.default_rng(0), pair, reach))


def test_rays_cast_again_agree_with_a_right_pair(made):
    for _, pair in made[1]:
        assert recast(pair) == []


@pytest.mark.parametrize(
    "change",
    [
        lambda p: {"depth_m": scaled(p, 1.002)},
        lambda p: {"depth_m": scaled(p, np.linalg.norm(p.camera.rays(), axis=-1))},
        lambda p: {"depth_m": np.roll(p.depth_m, 1, axis=0)},
        lambda p: {"depth_m": flipped(p.depth_m, 0)},
        lambda p: {"depth_m": np.minimum(p.depth_m, 100)},
        lambda p: {"world_from_cam": p.meta["world_from_cam_prev"]},
        lambda p: {"intrinsics": (p.camera.matrix + [[0, 0, 0], [0, 0, 0.5], [0, 0, 0]]).tolist()},
    ],
)
def test_rays_cast_again_find_the_slightest_fault(made, change):
    for _, pair in made[1][::5]:
        (fault,) = recast(replaced(pair, **change(pair)))
        assert "is not what rays find" in fault


def test_a_camera_inside_something_or_too_near_is_found(made):
    _, pair = made[1][0]
    boxed = recast(pair, lambda pose, d: np.minimum(reach(pose, d), 400).astype(np.float32))
    assert boxed == ["the camera is inside something: no ray gets to the sky"]
    (near,) = recast(replaced(pair, clearance_m=50.0))
    assert "clearance_m says 50.00 m" in near
