"""Where KITTI's files lie, in each of the layouts it is found in: a folder in, frames out.

| layout      | what is there                                                                   |
|-------------|---------------------------------------------------------------------------------|
| `depth`     | `train or val/<drive>/proj_depth/<kind>/image_0X/%010d.png`, pictures as in `raw`  |
| `raw`       | `<date>/<drive>/image_0X/data/%010d.png`, `velodyne_points`, `oxts`, `calib_*.txt` |
| `selection` | `image/` and `groundtruth_depth/` with the same names, as `val_selection_cropped` |
| `object`    | `training/image_2/%06d.png`, `velodyne`, `calib`, `prev_2`                       |

`<date>` is 2011_09_26, say, and `<drive>` 2011_09_26_drive_0001_sync. What `export_kitti` writes is
both of the first two.
"""

import dataclasses
import itertools
import os
import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from synthdepth.errors import DatasetError
from synthdepth.kitti.calibration import (
    Calibration,
    object_calibration,
    raw_calibration,
    selection_calibration,
)

CAMERAS = (2, 3)
SPLITS = ("train", "val")
# BTS has the drives of both above them.
ALL_SPLITS = (*SPLITS, "")
# Depth that lies ready as pictures, of several scans or of one, and that from the scan itself.
KINDS = ("groundtruth", "velodyne_raw")
LIDAR = "lidar"
# KITTI has PNG; monodepth2 turns it into JPEG to save disk.
_SUFFIXES = (".png", ".jpg")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Frame:
    """Where the files of one frame lie; what there is not is None.

    Attributes:
        key: name within the dataset.
        image: the picture.
        depth: its depth image.
        velodyne: its scan.
        prev: the picture of the frame before.
        oxts, oxts_prev: poses of the two.
        calibrate: reads its calibration; None where the layout has no such file.
        meta: drive, camera, number and the like.
    """

    key: str
    image: Path
    depth: Path | None = None
    velodyne: Path | None = None
    prev: Path | None = None
    oxts: Path | None = None
    oxts_prev: Path | None = None
    calibrate: Callable[[], Calibration] | None = None
    meta: dict = dataclasses.field(default_factory=dict)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Place:
    """Where to look.

    Attributes:
        folder: as the user gave it.
        raw_folder: where the raw recordings lie, `folder` itself if not told otherwise.
        depth: one of `KINDS`, or `LIDAR`.
        splits: folders of the depth benchmark.
    """

    folder: Path
    raw_folder: Path
    depth: str
    splits: tuple[str, ...] = ALL_SPLITS

    def depth_image(self, name: str) -> Path | None:
        """The depth image `<drive>/proj_depth/...` of whichever split has it."""
        return existing(*(self.folder / split / name for split in self.splits))


def existing(*paths: Path) -> Path | None:
    """The first that exists."""
    # Not Path.exists, which raises where a name is no name of a file.
    return next((path for path in paths if os.path.exists(path)), None)


def drive_frame(
    place: Place, drive: str, camera: int, number: int, depth: Path | None = None
) -> Frame:
    """A frame of a raw recording.

    Args:
        place: where to look for it.
        drive: e.g. 2011_09_26_drive_0001_sync.
        camera: 2 or 3.
        number: of the frame.
        depth: its depth image.

    Raises:
        DatasetError: the recording lacks the picture.
    """
    date = place.raw_folder / drive[:10]
    folder = existing(date / drive, place.raw_folder / drive) or date / drive
    image = _picture(folder, camera, number)
    if image is None:
        raise DatasetError(
            f"there is no picture {folder}/image_{camera:02d}/data/{number:010d}.png; "
            "raw_folder says where the raw recordings lie"
        )
    oxts = folder / "oxts" / "data"
    return Frame(
        key=f"{drive}/image_{camera:02d}/{number:010d}",
        image=image,
        depth=depth,
        velodyne=existing(folder / "velodyne_points" / "data" / f"{number:010d}.bin"),
        prev=_picture(folder, camera, number - 1),
        oxts=existing(oxts / f"{number:010d}.txt"),
        oxts_prev=existing(oxts / f"{number - 1:010d}.txt"),
        calibrate=partial(raw_calibration, folder.parent, camera),
        meta={"drive": drive, "camera": camera, "frame_index": number},
    )


def _picture(drive: Path, camera: int, number: int) -> Path | None:
    stem = drive / f"image_{camera:02d}" / "data" / f"{number:010d}"
    return existing(*(stem.with_suffix(suffix) for suffix in _SUFFIXES))


def _depth_frames(place: Place) -> Iterator[Frame]:
    for split, camera in itertools.product(place.splits, CAMERAS):
        pattern = f"*_sync/proj_depth/{place.depth}/image_{camera:02d}/*.png"
        for path in sorted((place.folder / split).glob(pattern)):
            yield drive_frame(place, path.parents[3].name, camera, _number(path), path)


def _raw_frames(place: Place) -> Iterator[Frame]:
    for pattern, camera in itertools.product(("*_sync", "*/*_sync"), CAMERAS):
        pictures = place.raw_folder.glob(f"{pattern}/image_{camera:02d}/data/*")
        for path in sorted(path for path in pictures if path.suffix in _SUFFIXES):
            yield drive_frame(place, path.parents[2].name, camera, _number(path))


def _number(path: Path) -> int:
    """The frame's, which a file has as its name."""
    if not re.fullmatch("[0-9]{1,10}", path.stem):
        raise DatasetError(f"{path}: allowed is a frame's number as name, e.g. 0000000005")
    return int(path.stem)


def _selection_frames(place: Place) -> Iterator[Frame]:
    # Names are equal, or differ in one word: ..._sync_image_0000000215_image_03.png.
    kind = {"groundtruth": "groundtruth_depth"}.get(place.depth, place.depth)
    for path in sorted((place.folder / "image").glob("*.png")):
        numbers = (place.folder / "intrinsics" / path.name).with_suffix(".txt")
        yield Frame(
            key=path.stem,
            image=path,
            depth=existing(
                place.folder / kind / path.name.replace("_sync_image_", f"_sync_{kind}_")
            ),
            calibrate=partial(selection_calibration, numbers) if numbers.exists() else None,
        )


def _object_frames(place: Place) -> Iterator[Frame]:
    for path in sorted((place.folder / "training" / "image_2").glob("*.png")):
        folder, stem = path.parents[1], path.stem
        yield Frame(
            key=stem,
            image=path,
            velodyne=existing(folder / "velodyne" / f"{stem}.bin"),
            prev=existing(folder / "prev_2" / f"{stem}_01.png"),
            calibrate=partial(object_calibration, folder / "calib" / f"{stem}.txt"),
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Layout:
    """A way in which KITTI's files are laid out.

    Attributes:
        frames: finds its frames.
        marks: patterns of which one is met where the layout is.
        depths: what depth it can have, first what is taken if none is asked for.
    """

    frames: Callable[[Place], Iterator[Frame]]
    marks: tuple[str, ...]
    depths: tuple[str, ...]


# In the order in which they are looked for: `depth` comes with `raw` in one folder.
LAYOUTS = {
    "depth": Layout(
        frames=_depth_frames,
        marks=("*_sync/proj_depth", *(f"{split}/*_sync/proj_depth" for split in SPLITS)),
        depths=KINDS,
    ),
    "selection": Layout(frames=_selection_frames, marks=("image/*.png",), depths=KINDS),
    "object": Layout(frames=_object_frames, marks=("training/image_2",), depths=(LIDAR,)),
    "raw": Layout(
        frames=_raw_frames, marks=("*_sync/image_0*", "*/*_sync/image_0*"), depths=(LIDAR,)
    ),
}


def detect_layout(folder: Path) -> str:
    """The name of the layout that a folder has; DatasetError where it has none."""
    if not folder.is_dir():
        raise DatasetError(f"{folder} is no folder")
    for name, layout in LAYOUTS.items():
        if any(True for mark in layout.marks for _ in folder.glob(mark)):
            return name
    raise DatasetError(f"{folder} has none of KITTI's layouts: known are {', '.join(LAYOUTS)}")
