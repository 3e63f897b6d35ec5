"""Checking a dataset folder from its files alone."""

import dataclasses
import json
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np

from synthdepth.camera import project, unproject
from synthdepth.dataset.exr import depth_header
from synthdepth.dataset.manifest import DESCRIPTIONS, INDEX, MANIFEST, read_index, read_manifest
from synthdepth.dataset.pair import Pair, decode_pair
from synthdepth.dataset.shard import read_members, sha256_of, shard_members
from synthdepth.errors import DatasetError

# Depth stored in the header and in meta.json are float32 and float64 of the same number.
_POSE_TOLERANCE = 1e-6
FLOW_TOLERANCE_PX = 0.01


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fault:
    """Something that is wrong.

    Attributes:
        where: the file, and the pair if it is one pair's.
        what: in one line.
    """

    where: str
    what: str


@dataclasses.dataclass(frozen=True, kw_only=True)
class VerifyReport:
    """What `verify` found.

    Attributes:
        shards: shards looked at.
        pairs: pairs decoded.
        faults: empty where all is well.
    """

    shards: int
    pairs: int
    faults: list[Fault]


def verify(
    folder: Path, *, threads: int = 2, on_progress: Callable[[int, int], None] = lambda a, b: None
) -> VerifyReport:
    """Check checksums, counts, decoding and the contract's rules of a dataset folder.

    Args:
        folder: the dataset.
        threads: shards looked at side by side.
        on_progress: called with (pairs done, pairs in all).

    Raises:
        DatasetError: there is no manifest to check against.
    """
    folder = Path(folder)
    manifest = read_manifest(folder)
    records = manifest["shards"]
    total = sum(record["pairs"] for record in records)
    done, pairs = 0, 0
    faults = _folder_faults(folder, manifest)
    keys: dict[str, str] = {}
    on_progress(0, total)
    with ThreadPoolExecutor(threads) as pool:
        for record, (found, shard_keys) in zip(
            records, pool.map(lambda r: _shard_faults(folder, r, manifest), records), strict=True
        ):
            faults += found
            pairs += len(shard_keys)
            for key in shard_keys:
                if key in keys:
                    faults.append(Fault(where=record["path"], what=f"{key} is also in {keys[key]}"))
                keys[key] = record["path"]
            done += record["pairs"]
            on_progress(done, total)
    faults += _index_faults(folder, keys)
    return VerifyReport(shards=len(records), pairs=pairs, faults=faults)


def _folder_faults(folder: Path, manifest: Mapping) -> list[Fault]:
    """Files that should be there and are not, and the other way round."""
    faults = []
    if not manifest.get("complete"):
        faults.append(Fault(where=MANIFEST, what="the run has not finished: render it again"))
    listed = {record["path"] for record in manifest["shards"]}
    expected = {*DESCRIPTIONS} | listed
    there = {p.relative_to(folder).as_posix() for p in folder.rglob("*") if p.is_file()}
    faults += [Fault(where=name, what="is missing") for name in sorted(expected - there)]
    faults += [Fault(where=name, what="does not belong here") for name in sorted(there - expected)]
    scenes: dict[int, str] = {}
    for record in manifest["shards"]:
        other = scenes.setdefault(record["scene_seed"], record["split"])
        if other != record["split"]:
            faults.append(Fault(where=record["path"], what="its scene is in both splits"))
    return faults


def _shard_faults(
    folder: Path, record: Mapping, manifest: Mapping
) -> tuple[list[Fault], list[str]]:
    """What is wrong with one shard, and the keys of the pairs that it holds."""
    name = record["path"]
    path = folder / name
    if not path.is_file():
        return [], []  # Already reported as missing.
    if path.stat().st_size != record["bytes"] or sha256_of(path) != record["sha256"]:
        # Nothing in a damaged shard can be trusted, not even far enough to decode it.
        return [Fault(where=name, what="is not the file that was written (sha256 differs)")], []
    try:
        members = shard_members(path)
    except ValueError as error:
        return [Fault(where=name, what=str(error))], []
    faults = []
    if len(members) != record["pairs"]:
        faults.append(Fault(where=name, what=f"holds {len(members)} pairs, not {record['pairs']}"))
    for key, files in members.items():
        try:
            content = read_members(path, files)
            pair = decode_pair(key, content)
            problems = pair_problems(pair, record, manifest)
            problems += _header_problems(pair, content["depth.exr"])
        except ValueError as error:
            problems = [str(error)]
        faults += [Fault(where=f"{name} {key}", what=problem) for problem in problems]
    return faults, list(members)


def pair_problems(pair: Pair, record: Mapping, manifest: Mapping) -> list[str]:
    """Where a decoded pair breaks the contract, a line each."""
    meta, depth, camera = pair.meta, pair.depth_m, pair.camera
    problems = []
    shape = (camera.height, camera.width)
    for name, image in (("rgb.png", pair.rgb), ("prev.png", pair.prev), ("depth.exr", depth)):
        if image.shape[:2] != shape:
            problems.append(f"{name} is {image.shape[:2]}, meta.json says {shape}")
    top = np.float32(manifest["depth"]["max_depth_m"])
    if meta["max_depth_m"] != float(top):
        problems.append(f"max_depth_m is {meta['max_depth_m']}, the dataset's is {top}")
    if not np.isfinite(depth).all():
        problems.append("depth has values that are not finite")
    elif depth.min() <= 0:
        problems.append(f"depth has a value of {depth.min()} m")
    elif depth.max() > top:
        problems.append(f"depth has a value of {depth.max()} m, beyond the range of {top} m")
    if abs(float(depth.min()) - meta["nearest_depth_m"]) > 1e-4:
        problems.append("nearest_depth_m is not the least depth")
    if abs(float(np.mean(depth < top)) - meta["in_range_share"]) > 1e-6:
        problems.append("in_range_share is not the share of pixels within the range")
    problems += _modality_problems(pair, manifest)
    for name in ("world_from_cam", "world_from_cam_prev"):
        pose = np.array(meta[name])
        if pose.shape != (4, 4) or not _is_rigid(pose):
            problems.append(f"{name} is not a rigid pose")
    for name in ("map", "split", "scene_index", "scene_seed"):
        expected = manifest["map"] if name == "map" else record[name]
        if meta[name] != expected:
            problems.append(f"{name} is {meta[name]!r}, its shard's is {expected!r}")
    for name, image in (("rgb.png", pair.rgb), ("prev.png", pair.prev)):
        if image.max() < 20:
            problems.append(f"{name} is black")
        elif image.min() > 235:
            problems.append(f"{name} is burnt out")
    return problems


def _modality_problems(pair: Pair, manifest: Mapping) -> list[str]:
    """Where flow, labels and normals break the contract or contradict the depth."""
    problems = []
    shape, top = pair.depth_m.shape, np.float32(manifest["depth"]["max_depth_m"])
    asked = manifest["recipe"]["render"]["modalities"]
    there = {"flow": pair.flow, "seg": pair.seg, "normal": pair.normal}
    for name, image in there.items():
        if (image is None) == (name in asked):
            problems.append(f"{name} is {'missing' if image is None else 'more than was asked'}")
        elif image is not None and image.shape[:2] != shape:
            problems.append(f"{name} is {image.shape[:2]}, the depth {shape}")
    if problems:
        return problems
    in_range = pair.depth_m < top
    if pair.seg is not None:
        if not np.isin(pair.seg, list(manifest["labels"].values())).all():
            problems.append("seg.png has a value that is no label")
        if (pair.seg[in_range] == 0).any():
            problems.append("seg.png has sky where the depth is within the range")
    if pair.normal is not None:
        length = np.linalg.norm(pair.normal, axis=-1)
        if not (np.abs(length - 1) < 1e-3)[in_range].all():
            problems.append("normal.exr has vectors that are not of unit length")
        if (np.einsum("hwc,hwc->hw", pair.normal, pair.camera.rays()) > 1e-3).any():
            problems.append("normal.exr has normals that are turned away from the camera")
    if pair.flow is not None and not np.isfinite(pair.flow).all():
        problems.append("flow.exr has values that are not finite")
    elif pair.flow is not None:
        worst = np.abs(pair.flow - flow_of(pair))[in_range & (pair.visible > 0)].max(initial=0)
        if worst > FLOW_TOLERANCE_PX:
            problems.append(f"flow.exr is {worst:.3f} px from what depth and poses say")
    return problems


def flow_of(pair: Pair) -> np.ndarray:
    """Flow (H, W, 2) [px] to frame t-1 by depth and poses alone; NaN behind that camera."""
    place = unproject(pair.depth_m, pair.camera, pair.world_from_cam)
    was, _ = project(place, pair.camera, pair.world_from_cam_prev)
    v, u = np.mgrid[: pair.camera.height, : pair.camera.width]
    return was - np.stack([u, v], axis=-1)


def _is_rigid(pose: np.ndarray) -> bool:
    rotation = pose[:3, :3]
    return (
        np.allclose(rotation @ rotation.T, np.eye(3), atol=_POSE_TOLERANCE)
        and np.linalg.det(rotation) > 0
        and np.array_equal(pose[3], [0, 0, 0, 1])
    )


def _header_problems(pair: Pair, data: bytes) -> list[str]:
    """Where the EXR's header contradicts meta.json."""
    header = depth_header(data)
    problems = []
    try:
        same = (
            json.loads(header["intrinsics"]) == pair.meta["intrinsics"]
            and json.loads(header["worldFromCam"]) == pair.meta["world_from_cam"]
            and float(header["maxDepth"]) == pair.meta["max_depth_m"]
        )
        if not same:
            problems.append("the header of depth.exr contradicts meta.json")
    except (KeyError, ValueError) as error:
        problems.append(f"the header of depth.exr lacks what the contract asks for ({error})")
    return problems


def _index_faults(folder: Path, keys: Mapping[str, str]) -> list[Fault]:
    """Where the index and the shards disagree."""
    try:
        table = read_index(folder, ["key", "shard"]).to_pydict()
    except DatasetError as error:
        return [] if not (folder / INDEX).exists() else [Fault(where=INDEX, what=str(error))]
    indexed = dict(zip(table["key"], table["shard"], strict=True))
    lost = [key for key in keys if indexed.get(key) != keys[key]]
    extra = [key for key in indexed if key not in keys]
    faults = []
    if lost:
        faults.append(Fault(where=INDEX, what=f"lacks {len(lost)} pairs, {lost[0]} first"))
    if extra:
        faults.append(
            Fault(
                where=INDEX, what=f"lists {len(extra)} pairs that cannot be read, {extra[0]} first"
            )
        )
    return faults
