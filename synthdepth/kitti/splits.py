"""Split files: which frames of the raw recordings belong to a split.

| who               | a line                                                                   |
|-------------------|--------------------------------------------------------------------------|
| BTS, AdaBins, ... | `<date>/<drive>/image_02/data/%010d.png <depth image or None> <focal px>` |
| monodepth2        | `<date>/<drive> <number> <l or r>`                                       |
"""

import dataclasses
import re
from pathlib import Path

from synthdepth.errors import DatasetError
from synthdepth.kitti.layouts import KINDS, Frame, Place, drive_frame

_CAMERA_OF_SIDE = {"l": 2, "r": 3}
_BTS = re.compile(
    r"(?:\S*/)?(\S+_sync)/image_(\d\d)/data/(\d{1,10})\.\w+(?:\s+(None|\S+\.png))?(?:\s+[\d.]+)?"
)
_MONODEPTH2 = re.compile(r"(?:\S*/)?(\S+_sync)\s+(\d{1,10})\s+([lr])")


@dataclasses.dataclass(frozen=True, kw_only=True)
class SplitLine:
    """A frame that a split file names.

    Attributes:
        drive, camera, number: which frame, as `layouts.drive_frame` has them.
        depth: path of its depth image below the folder of the drives; None where the line says
            that there is none, "" where it says nothing of depth.
    """

    drive: str
    camera: int
    number: int
    depth: str | None


def read_split(path: Path) -> list[SplitLine]:
    """The lines of a split file of either form; DatasetError names a line that is of none."""
    try:
        lines = Path(path).read_text().splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise DatasetError(f"{path} cannot be read: {reason}") from None
    found = [_line(line.strip(), path, k) for k, line in enumerate(lines, start=1) if line.strip()]
    if not found:
        raise DatasetError(f"{path} names no frames")
    return found


def _line(line: str, path: Path, number: int) -> SplitLine:
    if match := _MONODEPTH2.fullmatch(line):
        drive, frame, side = match.groups()
        return SplitLine(drive=drive, camera=_CAMERA_OF_SIDE[side], number=int(frame), depth="")
    if match := _BTS.fullmatch(line):
        drive, camera, frame, depth = match.groups()
        depth = None if depth == "None" else depth or ""
        return SplitLine(drive=drive, camera=int(camera), number=int(frame), depth=depth)
    raise DatasetError(
        f"{path} line {number} is {line!r}: allowed are "
        "'<date>/<drive>/image_02/data/<number>.png <depth or None> <focal>' and "
        "'<date>/<drive> <number> <l or r>'"
    )


def frames_of_split(path: Path, place: Place) -> list[Frame]:
    """The frames that a split file names, in its order.

    Where a line says nothing of depth, the frame has what depth image there is.

    Raises:
        DatasetError: a line cannot be read, or a file that it names is not there.
    """
    return [_frame(line, place) for line in read_split(path)]


def _frame(line: SplitLine, place: Place) -> Frame:
    depth = None
    if place.depth in KINDS and line.depth is not None:
        name = (
            f"{line.drive}/proj_depth/{place.depth}/image_{line.camera:02d}/{line.number:010d}.png"
        )
        depth = place.depth_image(line.depth or name)
        if line.depth and depth is None:
            raise DatasetError(
                f"there is no {line.depth} in {place.folder}, nor in its train or val"
            )
    return drive_frame(place, line.drive, line.camera, line.number, depth)
