"""Datasets of the contract made in milliseconds: walls and ground by formula, not by a renderer."""

from pathlib import Path

import numpy as np

import synthdepth
from synthdepth.camera import Intrinsics, look_rotation, pitch_roll_deg, pose, project, unproject
from synthdepth.dataset.card import write_card
from synthdepth.dataset.checksums import with_files, write_checksums
from synthdepth.dataset.croissant import write_croissant
from synthdepth.dataset.manifest import write_index, write_manifest
from synthdepth.dataset.pair import (
    META_FIELDS,
    SCHEMA_VERSION,
    encode_pair,
    encode_png,
    pair_key,
    saturate,
)
from synthdepth.dataset.shard import ShardWriter
from synthdepth.maps.world import LABELS
from synthdepth.production.recipe import load_recipe
from synthdepth.seeding import derive_seed, lane

CAMERA = Intrinsics.from_fov(64, 48, 90.0)
CONDITIONS = ("clear", "fog", "night")
_WALL_X_M, _DT_S = 60.0, 0.1


def view(camera: Intrinsics, world_from_cam: np.ndarray, max_depth_m: float):
    """Picture, saturated depth [m], labels and normals of a wall behind a ground, under sky."""
    rays = camera.rays() @ world_from_cam[:3, :3].T
    at = world_from_cam[:3, 3]
    with np.errstate(divide="ignore"):
        ground, wall = -at[2] / rays[..., 2], (_WALL_X_M - at[0]) / rays[..., 0]
    ground, wall = np.where(ground > 0, ground, np.inf), np.where(wall > 0, wall, np.inf)
    wall = np.where(at[2] + np.where(np.isinf(wall), 0, wall) * rays[..., 2] < 25, wall, np.inf)
    depth = np.minimum(ground, wall)
    sky = np.isinf(depth)
    points = unproject(np.where(sky, 0, depth), camera, world_from_cam)
    pattern = sum(np.sin(2 * np.pi * points[..., k] / period) for k, period in enumerate((7, 5, 6)))
    picture = np.clip(120 + 30 * pattern, 0, 255)[..., None] * [1.0, 0.9, 0.7]
    picture[sky] = [150, 180, 220]
    on_wall = wall < ground
    seg = np.where(sky, LABELS["sky"], np.where(on_wall, LABELS["building"], LABELS["ground"]))
    normal = np.where(on_wall[..., None], [-1.0, 0, 0], [0, 0, 1.0]) @ world_from_cam[:3, :3]
    return (
        picture.astype(np.uint8),
        saturate(depth, max_depth_m),
        depth,
        seg.astype(np.uint8),
        np.where(sky[..., None], 0, normal).astype(np.float32),
    )


def _pose(step: float, height_m: float, yaw_rad: float) -> np.ndarray:
    forward = np.array([np.cos(yaw_rad), np.sin(yaw_rad), -0.1])
    return pose(look_rotation(forward, np.array([0, 0, 1.0])), np.array([0.8 * step, 0, height_m]))


def make_dataset(
    folder: Path,
    *,
    shards: int = 4,
    pairs: int = 3,
    modalities: tuple[str, ...] = (),
    camera: Intrinsics = CAMERA,
    seed: int = 0,
    max_depth_m: float = 200.0,
) -> Path:
    """A dataset of `shards` scenes with `pairs` pairs each, every other scene in the split test.

    Scene k has condition k of `CONDITIONS` in turn; the depth, the flow and the poses agree.
    """
    recipe = load_recipe("blocks").as_dict()
    recipe["camera"] |= {"width": camera.width, "height": camera.height}
    recipe["render"] |= {"modalities": list(modalities), "max_depth_m": max_depth_m}
    folder, records = Path(folder), []
    for scene in range(shards):
        split = ("train", "test")[scene % 2]
        name = f"{split}/blocks-{split}-{scene // 2:06d}.tar"
        rng = lane(seed, "made", scene)
        height, yaw = float(rng.uniform(3, 20)), float(rng.uniform(-0.5, 0.5))
        scene_seed = derive_seed(seed, "scene", scene)
        with ShardWriter(folder / name) as writer:
            for frame in range(1, pairs + 1):
                known = {"scene_index": scene, "scene_seed": scene_seed, "split": split}
                known |= {"frame_index": frame, "condition": CONDITIONS[scene % 3]}
                poses = [_pose(step, height, yaw) for step in (frame - 1, frame)]
                key = pair_key("blocks", scene, 0, frame)
                writer.add(key, _members(camera, poses, known, modalities, max_depth_m))
        record = {"path": name, "split": split, "scene_index": scene, "scene_seed": scene_seed}
        records.append(
            record | {"pairs": pairs, "bytes": writer.size, "sha256": writer.sha256, "cost": None}
        )
    manifest = {
        "schema_version": SCHEMA_VERSION, "map": "blocks", "seed": seed, "train_share": 0.5,
        "pairs_planned": shards * pairs, "complete": True,
        "splits": {s: pairs * sum(r["split"] == s for r in records) for s in ("train", "test")},
        "software": {
            "synthdepth": synthdepth.__version__, "mitsuba": "none", "numpy": np.__version__,
            "variant": "none", "machine": "none",
        },
        "depth": {
            "unit": "metre", "convention": "planar", "channel": "Z", "dtype": "float32",
            "max_depth_m": max_depth_m,
        },
        "meta_fields": list(META_FIELDS), "labels": LABELS if "seg" in modalities else {},
        "recipe": recipe, "shards": records,
    }  # fmt: skip
    write_index(folder, manifest)
    write_card(folder, manifest)
    write_croissant(folder, manifest)
    manifest = with_files(folder, manifest)
    write_checksums(folder, manifest)
    write_manifest(folder, manifest)
    return folder


def _members(camera, poses, known, modalities, max_depth_m) -> dict[str, bytes]:
    (prev, *_), (rgb, depth_m, far_m, seg, normal) = (view(camera, p, max_depth_m) for p in poses)
    flow = visible = None
    if "flow" in modalities:
        grid = np.stack(np.meshgrid(np.arange(camera.width), np.arange(camera.height)), axis=-1)
        # The sky moves as what is infinitely far does.
        far_m = np.where(np.isinf(far_m), 1e9, far_m)
        before, _ = project(unproject(far_m, camera, poses[1]), camera, poses[0])
        flow = (before - grid).astype(np.float32)
        inside = (before >= 0) & (before <= [camera.width - 1, camera.height - 1])
        visible = inside.all(axis=-1)
    pitch, roll = pitch_roll_deg(poses[1])
    values = known | {
        "schema_version": SCHEMA_VERSION, "map": "blocks", "flight_index": 0,
        "time_s": known["frame_index"] * _DT_S, "dt_s": _DT_S,
        "width": camera.width, "height": camera.height, "intrinsics": camera.matrix.tolist(),
        "world_from_cam": poses[1].tolist(), "world_from_cam_prev": poses[0].tolist(),
        "velocity_mps": ((poses[1] - poses[0])[:3, 3] / _DT_S).tolist(), "speed_mps": 8.0,
        "altitude_m": float(poses[1][2, 3]), "clearance_m": 1.0, "pitch_deg": pitch,
        "roll_deg": roll, "max_depth_m": max_depth_m, "nearest_depth_m": float(depth_m.min()),
        "median_depth_m": float(np.median(depth_m)),
        "in_range_share": float(np.mean(depth_m < max_depth_m)),
        "sun_azimuth_deg": 120.0, "sun_elevation_deg": 40.0, "turbidity": 3.0,
        "visibility_m": 1e4, "cloud_cover": 0.0, "wetness": 0.0, "spp": 4, "exposure": 1.0,
        "shutter_s": 0.0, "white_electrons": 0.0, "contrast": 0.0, "saturation": 1.0,
        "jpeg_quality": 0,
    }  # fmt: skip
    return encode_pair(
        rgb_png=encode_png(rgb),
        prev_png=encode_png(prev),
        depth_m=depth_m,
        meta={name: values[name] for name in META_FIELDS},
        flow=flow,
        visible=visible,
        seg=seg if "seg" in modalities else None,
        normal=normal if "normal" in modalities else None,
    )
