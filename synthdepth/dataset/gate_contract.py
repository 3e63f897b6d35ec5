"""The contract's rules on one decoded pair: those that need no statistics."""

from collections.abc import Iterator, Mapping

import numpy as np

from synthdepth.camera import pitch_roll_deg
from synthdepth.dataset.gate_check import Check
from synthdepth.dataset.gate_warp import moved_px
from synthdepth.dataset.pair import BY_MODALITY, Pair, pair_key
from synthdepth.flow.truth import flow_from_depth

# What float64 and JSON may cost poses, angles [deg] and speeds [m/s], and float32 distances [m].
_ROUNDING, _ROUNDING_M = 1e-6, 1e-3
FLOW_TOLERANCE_PX = 0.01
# A picture is black if all but a thousandth of it is darker than the first [grey levels], and burnt
# out if more than a share of it is brighter than the second in every colour.
_BLACK, _WHITE, _WHITE_SHARE = 20, 250, 0.98
# Two frames with the same bytes are one frame twice if the camera saw this much motion [px].
_FROZEN_PX = 0.5


def contract_checks(pair: Pair, record: Mapping, manifest: Mapping) -> list[Check]:
    """Every rule of the contract on a pair, by subject: a check a fault, or one without.

    Args:
        pair: decoded.
        record: its shard's entry in the manifest: split, scene_index, scene_seed.
        manifest: the dataset's.
    """
    checks = _told("contract", _contract_faults(pair, record, manifest))
    checks += _told("poses", _pose_faults(pair, manifest))
    if _is_regular(pair):
        checks += _told("depth", _depth_faults(pair))
        checks += _told("pictures", _picture_faults(pair))
        checks += _told("truth", _truth_faults(pair, manifest))
    return checks


def pair_problems(pair: Pair, record: Mapping, manifest: Mapping) -> list[str]:
    """Where a decoded pair breaks the contract, a line each."""
    return [check.fault for check in contract_checks(pair, record, manifest) if check.fault]


def _told(subject: str, faults: Iterator[str]) -> list[Check]:
    told = [Check(subject=subject, fault=fault) for fault in faults]
    return told or [Check(subject=subject, effect=0.0)]


def _contract_faults(pair: Pair, record: Mapping, manifest: Mapping) -> Iterator[str]:
    """Whether the pair is of its shard and dataset, and has the files and sizes that it says."""
    meta, shape = pair.meta, (pair.camera.height, pair.camera.width)
    for name in ("map", "split", "scene_index", "scene_seed"):
        expected = manifest["map"] if name == "map" else record[name]
        if meta[name] != expected:
            yield f"{name} is {meta[name]!r}, its shard's is {expected!r}"
    key = pair_key(meta["map"], meta["scene_index"], meta["flight_index"], meta["frame_index"])
    if pair.key != key:
        yield f"meta.json is of the pair {key}"
    top = manifest["depth"]["max_depth_m"]
    if meta["max_depth_m"] != top:
        yield f"max_depth_m is {meta['max_depth_m']}, the dataset's is {top}"
    for name, image in _images(pair).items():
        if image.shape[:2] != shape:
            yield f"{name} is {image.shape[:2]}, meta.json says {shape}"
    asked = manifest["recipe"]["render"]["modalities"]
    for name in BY_MODALITY:
        if (name in _images(pair)) != (name in asked):
            yield f"{name} is {'missing' if name in asked else 'more than was asked'}"


def _images(pair: Pair) -> dict[str, np.ndarray]:
    images = {name: getattr(pair, name) for name in ("rgb", "prev", "depth_m", *BY_MODALITY)}
    return {name: image for name, image in images.items() if image is not None}


def _is_regular(pair: Pair) -> bool:
    """Whether sizes and poses are such that more can be asked."""
    shape = pair.camera.height, pair.camera.width
    right = all(image.shape[:2] == shape for image in _images(pair).values())
    return right and _is_rigid(pair.world_from_cam) and _is_rigid(pair.world_from_cam_prev)


def _pose_faults(pair: Pair, manifest: Mapping) -> Iterator[str]:
    """Whether the poses are poses, and what meta.json says of the motion is theirs."""
    meta = pair.meta
    for name in ("world_from_cam", "world_from_cam_prev"):
        if not _is_rigid(np.array(meta[name])):
            yield f"{name} is not a rigid pose"
            return
    angles = pitch_roll_deg(pair.world_from_cam)
    if not np.allclose(angles, (meta["pitch_deg"], meta["roll_deg"]), atol=1e-3):
        yield "world_from_cam has another pitch or roll than meta.json says"
    velocity = np.array(meta["velocity_mps"])
    if abs(np.linalg.norm(velocity) - meta["speed_mps"]) > _ROUNDING_M:
        yield "speed_mps is not the length of velocity_mps"
    moved_m = (pair.world_from_cam - pair.world_from_cam_prev)[:3, 3]
    # What an acceleration a can make of it within the interval is a dt^2 / 2.
    limit = manifest["recipe"].get("flight", {}).get("max_acceleration_mps2", 0.0)
    off_m = np.linalg.norm(moved_m - velocity * meta["dt_s"])
    if off_m > limit * meta["dt_s"] ** 2 / 2 + _ROUNDING_M:
        yield f"the poses are {off_m:.2f} m from what velocity_mps says: one is of another frame"


def _depth_faults(pair: Pair) -> Iterator[str]:
    """Whether the depth is in its range, saturated as it should be, and as meta.json has it."""
    meta, depth = pair.meta, pair.depth_m
    top = np.float32(meta["max_depth_m"])
    if not np.isfinite(depth).all():
        yield "depth has values that are not finite"
        return
    if depth.min() <= 0:
        yield f"depth has a value of {depth.min()} m"
    if depth.max() > top:
        yield f"depth has a value of {depth.max()} m, beyond the range of {top} m"
    if abs(float(depth.min()) - meta["nearest_depth_m"]) > 1e-4:
        yield "nearest_depth_m is not the least depth"
    if abs(float(np.median(depth)) - meta["median_depth_m"]) > 1e-4:
        yield "median_depth_m is not the median depth"
    if abs(float(np.mean(depth < top)) - meta["in_range_share"]) > _ROUNDING:
        yield "in_range_share is not the share of pixels within the range"
    length_m = (depth * np.linalg.norm(pair.camera.rays(), axis=-1)).min()
    if length_m < meta["clearance_m"] - _ROUNDING_M:
        yield f"a surface is {length_m:.2f} m away, clearance_m says {meta['clearance_m']:.2f} m"


def _picture_faults(pair: Pair) -> Iterator[str]:
    """Whether the pictures show something, and not the same thing twice."""
    for name, image in (("rgb.png", pair.rgb), ("prev.png", pair.prev)):
        if np.quantile(image.max(axis=-1), 0.999) < _BLACK:
            yield f"{name} is black"
        elif np.mean(image.min(axis=-1) > _WHITE) > _WHITE_SHARE:
            yield f"{name} is burnt out"
        elif (image == image[0, 0]).all():
            yield f"{name} is of one colour"
    if np.array_equal(pair.rgb, pair.prev) and moved_px(pair) > _FROZEN_PX:
        yield "prev.png is rgb.png, though the camera moved"


def _truth_faults(pair: Pair, manifest: Mapping) -> Iterator[str]:
    """Where flow, labels and normals break the contract or contradict the depth."""
    in_range = pair.depth_m < np.float32(pair.meta["max_depth_m"])
    if pair.seg is not None:
        if not np.isin(pair.seg, list(manifest["labels"].values())).all():
            yield "seg.png has a value that is no label"
        if (pair.seg[in_range] == 0).any():
            yield "seg.png has sky where the depth is within the range"
    if pair.normal is not None:
        length = np.linalg.norm(pair.normal, axis=-1)
        if not (np.abs(length - 1) < 1e-3)[in_range].all():
            yield "normal.exr has vectors that are not of unit length"
        if (np.einsum("hwc,hwc->hw", pair.normal, pair.camera.rays()) > 1e-3).any():
            yield "normal.exr has normals that are turned away from the camera"
    if pair.flow is not None and not np.isfinite(pair.flow).all():
        yield "flow.exr has values that are not finite"
    elif pair.flow is not None:
        poses = pair.world_from_cam, pair.world_from_cam_prev
        off = np.abs(pair.flow - flow_from_depth(pair.depth_m, pair.camera, *poses))
        worst = off[in_range & pair.visible].max(initial=0)
        if worst > FLOW_TOLERANCE_PX:
            yield f"flow.exr is {worst:.3f} px from what depth and poses say"


def _is_rigid(pose: np.ndarray) -> bool:
    if pose.shape != (4, 4) or not np.isfinite(pose).all():
        return False
    rotation = pose[:3, :3]
    return (
        np.allclose(rotation @ rotation.T, np.eye(3), atol=_ROUNDING)
        and np.linalg.det(rotation) > 0
        and np.array_equal(pose[3], [0, 0, 0, 1])
    )
