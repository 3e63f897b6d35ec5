"""Which frames of a recording make pairs, and what all of them share."""

import dataclasses
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from synthdepth.airsim.capture import capture_fov_deg, clip_of, range_of, read_depth
from synthdepth.airsim.ned import world_from_cam
from synthdepth.airsim.recording import Record
from synthdepth.airsim.settings import (
    DEPTH_PERSPECTIVE,
    DEPTH_PLANAR,
    SCENE,
    AirSimCamera,
    camera_from_settings,
)
from synthdepth.camera import Intrinsics
from synthdepth.errors import DatasetError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Shot:
    """A frame and the one before it.

    Attributes:
        flight_index: number of the vehicle within the recording.
        frame_index: number of the frame among the vehicle's.
        started_ms: time of the vehicle's first frame.
        now, before: the two lines of the recording.
    """

    flight_index: int
    frame_index: int
    started_ms: int
    now: Record
    before: Record


@dataclasses.dataclass(frozen=True, kw_only=True)
class Source:
    """What all frames share.

    Attributes:
        camera: name of the camera.
        depth_type: DEPTH_PLANAR or DEPTH_PERSPECTIVE.
        mounts: the camera as settings.json has it, by vehicle; empty without settings.
        intrinsics: of pictures and depth.
        clip_m: where the stored depth was clipped; None where nothing tells that it was.
        max_depth_m: where the dataset's depth saturates.
    """

    camera: str
    depth_type: int
    mounts: dict[str, AirSimCamera]
    intrinsics: Intrinsics
    clip_m: float | None
    max_depth_m: float

    @property
    def size(self) -> tuple[int, int]:
        """Width and height [px]."""
        return self.intrinsics.width, self.intrinsics.height

    def picture(self, record: Record) -> Path:
        """The file of a frame's picture."""
        return record.images[self.camera, SCENE]

    def depth(self, record: Record) -> Path:
        """The file of a frame's depth."""
        return record.images[self.camera, self.depth_type]

    def pose(self, record: Record) -> np.ndarray:
        """`world_from_cam` (4, 4) of a frame."""
        mount = self.mounts.get(record.vehicle, AirSimCamera())
        return world_from_cam(record.ned_from_body @ mount.vehicle_from_camera)


def camera_and_depth(folder: Path, records: list[Record], camera: str | None) -> tuple[str, int]:
    """The camera that has pictures and depth, and the type of its depth: planar if it has both.

    Raises:
        DatasetError: there is none, or several to choose from.
    """
    there = {key for record in records for key in record.images}
    types = {
        name: [kind for kind in (DEPTH_PLANAR, DEPTH_PERSPECTIVE) if (name, kind) in there]
        for name in sorted(name for name, kind in there if kind == SCENE)
    }
    usable = [name for name, kinds in types.items() if kinds]
    if not usable:
        raise DatasetError(
            f"{folder} has no camera with both pictures (ImageType 0) and depth in metres "
            '(ImageType 1 or 2 with "PixelsAsFloat": true)'
        )
    if camera is None and len(usable) > 1:
        raise DatasetError(f"{folder} has several cameras: choose --camera of {', '.join(usable)}")
    if camera is not None and camera not in usable:
        raise DatasetError(f"--camera {camera}: allowed are {', '.join(usable)}")
    name = usable[0] if camera is None else camera
    return name, types[name][0]


def shots_of(
    records: list[Record], camera: str, depth_type: int, max_gap_s: float, skipped: Counter
) -> list[Shot]:
    """The frames of a recording that have a depth and a frame before, by vehicle and time.

    Args:
        records: the recording's lines.
        camera, depth_type: from `camera_and_depth`.
        max_gap_s: frames farther apart are no pair.
        skipped: counts, by reason, the frames that are none.
    """
    shots = []
    for flight, vehicle in enumerate(dict.fromkeys(record.vehicle for record in records)):
        mine = [record for record in records if record.vehicle == vehicle]
        seen = sorted((r for r in mine if (camera, SCENE) in r.images), key=lambda r: r.time_ms)
        _count(skipped, "its picture is missing", len(mine) - len(seen))
        for index, now in enumerate(seen):
            # Lines of the same millisecond show the same moment.
            before = next((r for r in seen[index::-1] if r.time_ms < now.time_ms), None)
            if before is None:
                _count(skipped, "no frame lies before it")
            elif now.time_ms - before.time_ms > 1000 * max_gap_s:
                _count(skipped, f"the frame before is more than {max_gap_s:g} s older")
            elif (camera, depth_type) not in now.images:
                _count(skipped, "its depth is missing")
            else:
                shots.append(
                    Shot(
                        flight_index=flight,
                        frame_index=index,
                        started_ms=seen[0].time_ms,
                        now=now,
                        before=before,
                    )
                )
    return shots


def _count(skipped: Counter, reason: str, times: int = 1) -> None:
    if times:
        skipped[reason] += times


def source_of(
    frames: list[Record],
    camera: str,
    depth_type: int,
    *,
    settings: Path | None,
    max_depth_m: float | None,
) -> Source:
    """Field of view and mounting from the settings, size and range from all depth images.

    Args:
        frames: those that pairs will be made of, at least one.
        camera, depth_type: from `camera_and_depth`.
        settings: settings.json, if there is one.
        max_depth_m: where the depth shall saturate, if the user says so.

    Raises:
        DatasetError: a depth image cannot be read, or not all have the same size and field of view.
    """
    mounts, fovs_deg = {}, set()
    for vehicle in sorted({frame.vehicle for frame in frames}):
        fovs_deg.add(capture_fov_deg(settings, camera, depth_type, vehicle=vehicle))
        if settings is not None:
            mounts[vehicle] = camera_from_settings(settings, camera, vehicle=vehicle)
    if len(fovs_deg) > 1:
        raise DatasetError(f"{settings}: FOV_Degrees of {camera} differs between the vehicles")
    files = [frame.images[camera, depth_type] for frame in frames]
    height, width = read_depth(files[0]).shape
    intrinsics = Intrinsics.from_fov(width, height, fovs_deg.pop())
    clip_m = clip_of(_same_size(files, (height, width)))
    return Source(
        camera=camera,
        depth_type=depth_type,
        mounts=mounts,
        intrinsics=intrinsics,
        clip_m=clip_m,
        max_depth_m=range_of(clip_m, max_depth_m, intrinsics, depth_type),
    )


def _same_size(files: list[Path], shape: tuple[int, int]) -> Iterator[np.ndarray]:
    for file in files:
        depth_m = read_depth(file)
        if depth_m.shape != shape:
            (height, width), (h, w) = depth_m.shape, shape
            raise DatasetError(f"{file} is {width}x{height}, the first depth image {w}x{h}")
        yield depth_m
