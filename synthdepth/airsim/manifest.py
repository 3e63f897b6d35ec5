"""The manifest of an imported dataset, and what it says is unknown."""

import hashlib
from pathlib import Path

import numpy as np

import synthdepth
from synthdepth.airsim.capture import RANGE_M
from synthdepth.airsim.frames import Source
from synthdepth.airsim.recording import RECORD
from synthdepth.airsim.settings import DEPTH_PLANAR
from synthdepth.dataset.pair import META_FIELDS, SCHEMA_VERSION

MAP = "airsim"
# What meta.json must hold and a recording does not say: what changes no picture.
NEUTRAL = {
    "condition": "unknown", "clearance_m": 0.0, "sun_azimuth_deg": 0.0, "sun_elevation_deg": 0.0,
    "turbidity": 1.0, "visibility_m": 1e6, "cloud_cover": 0.0, "wetness": 0.0, "spp": 1,
    "exposure": 1.0, "shutter_s": 0.0, "white_electrons": 0.0, "contrast": 0.0, "saturation": 1.0,
    "jpeg_quality": 0,
}  # fmt: skip


def shard_record(path: Path, scene: int, split: str) -> dict:
    """The manifest's entry of a recording, still without its pairs."""
    # The same recording has the same seed anywhere, so that one in two splits is found out.
    digest = hashlib.sha256((path / RECORD).read_bytes()).digest()
    return {
        "path": f"{split}/{MAP}-{split}-{scene:06d}.tar",
        "split": split,
        "scene_index": scene,
        "scene_seed": int.from_bytes(digest[:8]) >> 11,
        "pairs": 0,
        "bytes": 0,
        "sha256": "",
        "cost": None,
    }


def manifest_of(source: Source, recordings: list[str]) -> dict:
    """The manifest, still without shards and totals."""
    camera, planar_stored = source.intrinsics, source.depth_type == DEPTH_PLANAR
    return {
        "schema_version": SCHEMA_VERSION,
        "map": MAP,
        "seed": 0,
        "software": {"synthdepth": synthdepth.__version__, "numpy": np.__version__},
        "depth": {
            "unit": "metre",
            "convention": "planar",
            "channel": "Z",
            "dtype": "float32",
            "max_depth_m": source.max_depth_m,
        },
        "meta_fields": list(META_FIELDS),
        "labels": {},
        "recipe": {
            "map": MAP,
            "camera": {
                "width": camera.width,
                "height": camera.height,
                "fov_deg": round(camera.fov_deg, 9),
            },
            "sensor": {"model": "unknown"},
            "render": {"max_depth_m": source.max_depth_m, "modalities": []},
        },
        "source": {
            "kind": "airsim",
            "recordings": recordings,
            "camera": source.camera,
            "depth_type": "DepthPlanar" if planar_stored else "DepthPerspective",
            "unknown": [*NEUTRAL],
            "notes": _notes(source),
        },
        "shards": [],
    }


def totals(shards: list[dict]) -> dict:
    """What the manifest says of all shards together."""
    splits: dict[str, int] = {}
    for shard in shards:
        splits[shard["split"]] = splits.get(shard["split"], 0) + shard["pairs"]
    return {
        "train_share": sum(shard["split"] == "train" for shard in shards) / len(shards),
        "pairs_planned": sum(splits.values()),
        "complete": True,
        "splits": splits,
    }


def _notes(source: Source) -> list[str]:
    """What a reader of the dataset must know, a line each."""
    notes = [
        f"these fields of meta.json are unknown and hold neutral values: {', '.join(NEUTRAL)}",
        "poses were read after the picture was taken, with 6 significant digits; velocity_mps is "
        "the mean since frame t-1, altitude_m the height above the vehicle's start",
        "each vehicle's world has its origin where the vehicle started",
        "depth comes from half-float pixels: steps of 31 mm from 32 to 64 m, 125 mm from 128 m",
    ]
    if not source.mounts:
        notes.append(
            "without settings.json the field of view is AirSim's 90 degrees, and the poses are the "
            "vehicle's: where the camera sits on it is unknown"
        )
    elif any(m.position_m is None or m.angles_deg is None for m in source.mounts.values()):
        notes.append(
            "settings.json does not say all of X, Y, Z or all of Pitch, Roll, Yaw of the camera: "
            "the poses leave that out"
        )
    if any(mount.stabilised for mount in source.mounts.values()):
        notes.append("a gimbal turns the camera: its attitude is not the vehicle's, as poses say")
    if any((m.width, m.height) != source.size for m in source.mounts.values()):
        notes.append("settings.json gives another size than the pictures have: theirs is used")
    if source.clip_m is None:
        notes.append(
            f"nothing tells where the simulator clips depth: {source.max_depth_m:g} m is taken"
        )
    elif source.clip_m <= max(RANGE_M, source.max_depth_m):
        notes.append(f"the simulator seems to have clipped depth at {source.clip_m:g} m")
    else:
        notes.append(f"the simulator's depth goes on beyond {source.max_depth_m:g} m; clipped here")
    return notes
