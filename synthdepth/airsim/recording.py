"""What AirSim's recorder writes: `airsim_rec.txt` and the names of the images.

Source: RecordingFile.cpp and PawnSimApi.cpp of AirSim 1.8.
"""

import dataclasses
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from synthdepth.airsim.ned import body_pose
from synthdepth.errors import DatasetError

RECORD = "airsim_rec.txt"
IMAGES = "images"

_POSITION = ("POS_X", "POS_Y", "POS_Z")
_QUATERNION = ("Q_W", "Q_X", "Q_Y", "Q_Z")
_NEEDED = ("TimeStamp", *_POSITION, *_QUATERNION, "ImageFile")
# From the right: names of vehicles and cameras may hold underscores.
_IMAGE = re.compile(r"img_(?P<who>.*)_(?P<type>\d+)_(?P<stamp>\d+)\.(png|pfm|ppm)")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Record:
    """One line of a recording.

    Attributes:
        vehicle: its name; "" where the recording names none.
        time_ms: of the simulation's clock.
        ned_from_body: pose of the vehicle (4, 4) float64, north-east-down from where it started.
        images: file by (camera, image type), those that exist.
    """

    vehicle: str
    time_ms: int
    ned_from_body: np.ndarray
    images: Mapping[tuple[str, int], Path]


def find_recordings(folder: Path) -> list[Path]:
    """The recordings that a folder is or holds, by name.

    Raises:
        DatasetError: there is none.
    """
    folder = Path(folder)
    if not folder.is_dir():
        raise DatasetError(f"{folder} is no folder")
    if (folder / RECORD).is_file():
        return [folder]
    found = sorted(path.parent for path in folder.glob(f"*/{RECORD}"))
    if not found:
        raise DatasetError(
            f"{folder} has no {RECORD}, without which poses and order of frames are unknown: give "
            "a folder that AirSim's recorder wrote (single captures: read_airsim_capture, Python)"
        )
    return found


def read_recording(folder: Path) -> list[Record]:
    """The lines of a recording in the file's order.

    A last line that was cut off is left out, and so are images that do not exist.

    Raises:
        DatasetError: the file cannot be read or a line is not AirSim's.
    """
    path = Path(folder) / RECORD
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines(keepends=True)
        there = {image.name: image for image in (Path(folder) / IMAGES).iterdir()}
    except (OSError, UnicodeDecodeError) as error:
        raise DatasetError(f"{path} or its {IMAGES}/ cannot be read: {error}") from error
    columns = lines[0].strip().split("\t") if lines else []
    missing = [name for name in _NEEDED if name not in columns]
    if missing:
        raise DatasetError(f"{path} is not AirSim's: its first line lacks {', '.join(missing)}")
    records = []
    for number, line in enumerate(lines[1:], start=2):
        values = line.rstrip("\r\n").split("\t")
        if not line.endswith("\n") and len(values) < len(columns):
            break
        try:
            if len(values) != len(columns):
                raise ValueError(f"{len(values)} columns, not {len(columns)}")
            records.append(_record(dict(zip(columns, values, strict=True)), there))
        except ValueError as error:
            raise DatasetError(f"{path}, line {number}: {error}") from None
    return records


def _record(row: Mapping[str, str], there: Mapping[str, Path]) -> Record:
    vehicle = row.get("VehicleName", "")
    position = np.array([float(row[name]) for name in _POSITION])
    quaternion = np.array([float(row[name]) for name in _QUATERNION])
    if not (np.isfinite(position).all() and np.isfinite(quaternion).all()):
        raise ValueError("a pose that is not finite")
    names = {_parts(name, vehicle): name for name in row["ImageFile"].split(";") if name}
    return Record(
        vehicle=vehicle,
        time_ms=int(row["TimeStamp"]),
        ned_from_body=body_pose(position, quaternion),
        images={key: there[name] for key, name in names.items() if name in there},
    )


def _parts(name: str, vehicle: str) -> tuple[str, int]:
    """Camera and image type that a file's name tells."""
    found = _IMAGE.fullmatch(name)
    if not found:
        raise ValueError(f"{name!r} is no image of AirSim's recorder")
    # Before version 1.3 the vehicle was not part of it.
    return found["who"].removeprefix(f"{vehicle}_"), int(found["type"])
