"""AirSim's recordings as a dataset of the contract."""

import dataclasses
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from synthdepth.airsim.capture import check_same_size, planar, read_depth, read_picture
from synthdepth.airsim.frames import Shot, Source, camera_and_depth, shots_of, source_of
from synthdepth.airsim.manifest import MAP, NEUTRAL, manifest_of, shard_record, totals
from synthdepth.airsim.recording import find_recordings, read_recording
from synthdepth.camera import pitch_roll_deg
from synthdepth.dataset.card import write_card
from synthdepth.dataset.checksums import with_files, write_checksums
from synthdepth.dataset.croissant import write_croissant
from synthdepth.dataset.folder import new_folder
from synthdepth.dataset.manifest import write_index, write_manifest
from synthdepth.dataset.pair import (
    META_FIELDS,
    SCHEMA_VERSION,
    Pair,
    encode_pair,
    encode_png,
    pair_key,
    saturate,
)
from synthdepth.dataset.shard import ShardWriter
from synthdepth.dataset.verify import pair_problems
from synthdepth.errors import DatasetError


@dataclasses.dataclass(frozen=True, kw_only=True)
class ImportReport:
    """What an import did.

    Attributes:
        folder: the dataset.
        recordings: how many gave pairs.
        pairs: how many there are, by split.
        skipped: frames that gave no pair, by reason.
        notes: what the recordings do not say, or what was taken for granted; a line each.
    """

    folder: Path
    recordings: int
    pairs: dict[str, int]
    skipped: dict[str, int]
    notes: tuple[str, ...]


def import_airsim(
    folder: Path,
    out: Path,
    *,
    camera: str | None = None,
    settings: Path | None = None,
    max_depth_m: float | None = None,
    split: str | None = None,
    max_gap_s: float = 0.5,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> ImportReport:
    """Turn recordings of AirSim into a dataset that every reader of the contract takes.

    A recording is a scene and lies in one split; each of its vehicles is a flight. Frame t-1 is the
    vehicle's frame before, by the simulation's clock. The manifest's `source` says what the
    recordings do not: the fields listed there hold the values of `NEUTRAL`.

    Args:
        folder: a recording, or a folder of recordings.
        out: the dataset, a new or an empty folder.
        camera: which camera, if the recordings hold several.
        settings: AirSim's settings.json, for the camera's field of view and place on the vehicle.
        max_depth_m: where the depth saturates; without it where it was clipped, at most 200 m.
        split: "train" or "test"; without it the recordings alternate, by name.
        max_gap_s: frames farther apart are no pair.
        on_progress: called with (frames done, frames in all).

    Raises:
        DatasetError: no recording, or one that cannot be read; a recording gives no pair; the
            options do not fit; or `out` cannot be written. Nothing is left behind.
    """
    if split not in (None, "train", "test"):
        raise DatasetError(f"--split {split}: allowed are train, test")
    if not 0 < max_gap_s < np.inf:
        raise DatasetError(f"--max-gap-s {max_gap_s}: allowed is a number above 0")
    recordings = {path: read_recording(path) for path in find_recordings(folder)}
    lines = [line for recording in recordings.values() for line in recording]
    camera, depth_type = camera_and_depth(folder, lines, camera)
    skipped = {path: Counter() for path in recordings}
    shots = {
        path: shots_of(recording, camera, depth_type, max_gap_s, skipped[path])
        for path, recording in recordings.items()
    }
    for path in recordings:
        _check_any(path, len(shots[path]), skipped[path])
    frames = [shot.now for of_recording in shots.values() for shot in of_recording]
    source = source_of(frames, camera, depth_type, settings=settings, max_depth_m=max_depth_m)
    manifest = manifest_of(source, [path.resolve().name for path in recordings])
    done = 0
    on_progress(done, len(frames))
    with new_folder(out) as partial:
        for scene, path in enumerate(recordings):
            record = shard_record(path, scene, split or ("train", "test")[scene % 2])
            _check_new(path, record, manifest)
            manifest["shards"].append(record)
            pairs = _pairs(shots[path], source, record, manifest, skipped[path])
            with ShardWriter(partial / record["path"]) as shard:
                for key, members in pairs:
                    if members is not None:
                        shard.add(key, members)
                        record["pairs"] += 1
                    done += 1
                    on_progress(done, len(frames))
            _check_any(path, record["pairs"], skipped[path])
            record |= {"bytes": shard.size, "sha256": shard.sha256}
        manifest |= totals(manifest["shards"])
        write_index(partial, manifest)
        write_card(partial, manifest)
        write_croissant(partial, manifest)
        manifest = with_files(partial, manifest)
        write_checksums(partial, manifest)
        write_manifest(partial, manifest)
    return ImportReport(
        folder=Path(out),
        recordings=len(recordings),
        pairs=manifest["splits"],
        skipped=dict(sum(skipped.values(), Counter())),
        notes=tuple(manifest["source"]["notes"]),
    )


def _check_any(path: Path, pairs: int, skipped: Counter) -> None:
    if not pairs:
        why = ", ".join(f"{reason} ({count} frames)" for reason, count in skipped.items())
        raise DatasetError(f"{path} gives no pair: {why or 'it has no frames'}")


def _check_new(path: Path, record: dict, manifest: dict) -> None:
    for other, name in zip(manifest["shards"], manifest["source"]["recordings"], strict=False):
        if other["scene_seed"] == record["scene_seed"]:
            raise DatasetError(f"{path} is the same recording as {name}: remove one of them")


def _pairs(
    shots: list[Shot], source: Source, record: dict, manifest: dict, skipped: Counter
) -> Iterator[tuple[str, dict[str, bytes] | None]]:
    """Key and files of every shot; no files where the contract refuses it, and why in `skipped`."""
    known: dict[Path, tuple[np.ndarray, bytes]] = {}
    for shot in shots:
        rgb_path, prev_path = source.picture(shot.now), source.picture(shot.before)
        # The frame before is mostly frame t of the shot before.
        known = {
            path: known.get(path) or _picture(path) for path in dict.fromkeys((prev_path, rgb_path))
        }
        (rgb, rgb_png), (prev, prev_png) = known[rgb_path], known[prev_path]
        stored_m = read_depth(source.depth(shot.now))
        check_same_size(source.depth(shot.now), stored_m, rgb_path, rgb)
        depth_m = planar(stored_m, source.intrinsics, source.depth_type)
        depth_m = saturate(depth_m, source.max_depth_m)
        meta = _meta(shot, source, record, depth_m)
        key = pair_key(MAP, record["scene_index"], shot.flight_index, shot.frame_index)
        pair = Pair(key=key, rgb=rgb, prev=prev, depth_m=depth_m, meta=meta)
        problems = pair_problems(pair, record, manifest)
        if problems:
            skipped[problems[0]] += 1
            yield key, None
        else:
            files = {"rgb_png": rgb_png, "prev_png": prev_png}
            yield key, encode_pair(depth_m=depth_m, meta=meta, **files)


def _picture(path: Path) -> tuple[np.ndarray, bytes]:
    image = read_picture(path)
    return image, encode_png(image)


def _meta(shot: Shot, source: Source, record: dict, depth_m: np.ndarray) -> dict:
    pose, pose_prev = source.pose(shot.now), source.pose(shot.before)
    dt_s = (shot.now.time_ms - shot.before.time_ms) / 1000
    velocity_mps = (pose - pose_prev)[:3, 3] / dt_s
    pitch_deg, roll_deg = pitch_roll_deg(pose)
    values = NEUTRAL | {
        "schema_version": SCHEMA_VERSION,
        "map": MAP,
        "split": record["split"],
        "scene_index": record["scene_index"],
        "scene_seed": record["scene_seed"],
        "flight_index": shot.flight_index,
        "frame_index": shot.frame_index,
        "time_s": (shot.now.time_ms - shot.started_ms) / 1000,
        "dt_s": dt_s,
        "width": source.intrinsics.width,
        "height": source.intrinsics.height,
        "intrinsics": source.intrinsics.matrix.tolist(),
        "world_from_cam": pose.tolist(),
        "world_from_cam_prev": pose_prev.tolist(),
        "velocity_mps": velocity_mps.tolist(),
        "speed_mps": float(np.linalg.norm(velocity_mps)),
        "altitude_m": float(pose[2, 3]),
        "pitch_deg": pitch_deg,
        "roll_deg": roll_deg,
        "max_depth_m": source.max_depth_m,
        "nearest_depth_m": float(depth_m.min()),
        "median_depth_m": float(np.median(depth_m)),
        "in_range_share": float(np.mean(depth_m < source.max_depth_m)),
    }
    return {name: values[name] for name in META_FIELDS}
