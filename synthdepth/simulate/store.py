"""The folder of a simulation: what it is for, its flights scene by scene, and its results.

`simulation.json` says what was asked for; `scenes/` has a line a flight as it ended, `maps/` each
scene from above, `times/` where the time went. When all is flown come `flights.jsonl`,
`results.json` and `table.txt`, the same bytes every time, and the reports.
"""

import contextlib
import dataclasses
import fcntl
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from synthdepth.config import parse_json
from synthdepth.dataset.picture import decode_picture
from synthdepth.dataset.shard import write_error, write_whole
from synthdepth.errors import DatasetError
from synthdepth.simulate.outcome import Outcome, outcome_of
from synthdepth.simulate.relief import map_picture
from synthdepth.simulate.sources import SourceName
from synthdepth.simulate.survey import TopView

SETTINGS, FLIGHTS, RESULTS, TABLE = "simulation.json", "flights.jsonl", "results.json", "table.txt"
SCENES, MAPS, TIMES = "scenes", "maps", "times"
FORMAT = 2


@dataclasses.dataclass(frozen=True, kw_only=True)
class SceneMap:
    """A scene from above.

    Attributes:
        scene_index: number of the scene.
        condition: its light and weather.
        low_m, high_m: (2,) corners of what is shown [m]; north (+Y) is up.
        picture: (H, W, 3) uint8 RGB.
    """

    scene_index: int
    condition: str
    low_m: np.ndarray
    high_m: np.ndarray
    picture: np.ndarray


def scene_file(folder: Path, kind: str, map_name: str, scene_index: int, suffix: str) -> Path:
    """A scene's file of one of the kinds `SCENES`, `MAPS`, `TIMES`."""
    return folder / kind / f"{map_name}-s{scene_index:05d}{suffix}"


def read_settings(folder: Path) -> dict:
    """What a simulation's folder is for.

    Raises:
        DatasetError: there is none, or one of another version.
    """
    path = Path(folder) / SETTINGS
    try:
        there = parse_json(path.read_bytes())
        known = there["format"] == FORMAT and {"sources", "rules", "recipe"} <= there.keys()
        for source in there["sources"].values() if known else ():
            SourceName(**source)
    except FileNotFoundError:
        raise DatasetError(
            f"{folder} holds no simulation: allowed is what simulate wrote"
        ) from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise DatasetError(f"{path} cannot be read: choose another --out") from None
    if not known:
        raise DatasetError(
            f"{folder} holds flights with another format: allowed is {FORMAT}, fly them again"
        )
    return there


def read_flights(path: Path) -> list[Outcome]:
    """The flights of a `flights.jsonl`.

    Raises:
        DatasetError: it cannot be read, or holds something else.
    """
    try:
        return [outcome_of(line) for line in Path(path).read_bytes().splitlines()]
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror}") from None
    except ValueError:
        raise DatasetError(f"{path} holds no flights: allowed is what simulate wrote") from None


def flown(path: Path, mend: bool = False) -> dict[tuple[str, int], Outcome]:
    """The flights of a scene's file by source and scenario; a line that a kill cut short is none.

    With `mend` such a line is removed.

    Raises:
        DatasetError: it cannot be read, or holds something else.
    """
    try:
        data = path.read_bytes()
    except FileNotFoundError:
        return {}
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror}") from None
    whole = data[: data.rfind(b"\n") + 1]
    if mend and whole != data:
        write_whole(path, whole)
    try:
        flights = [outcome_of(line) for line in whole.splitlines()]
    except ValueError as error:
        raise DatasetError(
            f"{path} holds something else than flights ({error}): remove it and fly again"
        ) from None
    return {(flight.source, flight.scenario): flight for flight in flights}


def append(path: Path, line: bytes) -> None:
    """Add a line to a file, safe from then on."""
    with _naming(path), open(path, "ab") as file:
        file.write(line)
        file.flush()
        os.fsync(file.fileno())


def write_map(folder: Path, map_name: str, scene_index: int, view: TopView, condition: str) -> None:
    """Write a scene from above, unless it is there."""
    path, about = (
        scene_file(folder, MAPS, map_name, scene_index, suffix) for suffix in (".jpg", ".json")
    )
    if path.exists() and about.exists():
        return
    facts = {
        "scene_index": scene_index,
        "condition": condition,
        "low_m": view.low_m.tolist(),
        "high_m": view.high_m.tolist(),
    }
    picture = cv2.cvtColor(map_picture(view), cv2.COLOR_RGB2BGR)
    jpeg = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 90])[1]
    write_whole(path, jpeg.tobytes())
    write_whole(about, (json.dumps(facts) + "\n").encode())


def read_map(folder: Path, map_name: str, scene_index: int) -> SceneMap:
    """A scene from above.

    Raises:
        DatasetError: it cannot be read.
    """
    path = scene_file(folder, MAPS, map_name, scene_index, ".jpg")
    try:
        facts = parse_json(path.with_suffix(".json").read_bytes())
        picture = decode_picture(path.read_bytes(), cv2.IMREAD_COLOR)
        picture = cv2.cvtColor(picture, cv2.COLOR_BGR2RGB)
        corners = {name: np.array(facts.pop(name), float) for name in ("low_m", "high_m")}
        return SceneMap(**facts, **corners, picture=picture)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        raise DatasetError(
            f"{path} cannot be read: remove the folder {path.parent.parent} and fly again"
        ) from None


def claim(folder: Path, settings: Mapping, sources: Sequence[SourceName]) -> None:
    """Write what the folder is for, or see that it is for the same.

    Raises:
        DatasetError: it holds something else, or cannot be written.
    """
    path = folder / SETTINGS
    settings = {"format": FORMAT} | plain(settings)
    models = {source.name: dataclasses.asdict(source) for source in sources}
    if path.exists():
        there = read_settings(folder)
        known = there.pop("sources")
        for name, value in settings.items():
            if there.get(name) != value:
                raise DatasetError(
                    f"{folder} holds flights with another {name.replace('_', ' ')}: "
                    "choose another --out"
                )
        for name in models.keys() & known.keys():
            if models[name] != known[name]:
                raise DatasetError(
                    f"{folder} holds flights of another source {name!r}: name this one "
                    "otherwise (name=path) or choose another --out"
                )
        models = known | models
    elif strangers := sorted(entry.name for entry in folder.iterdir()):
        raise DatasetError(
            f"{folder} holds {strangers[0]!r} and no simulation: choose an empty or new --out"
        )
    with _naming(path):
        for kind in (SCENES, MAPS, TIMES):
            (folder / kind).mkdir(exist_ok=True)
    write_whole(path, (json.dumps(settings | {"sources": models}, indent=1) + "\n").encode())


@contextlib.contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Make the folder and keep other runs out of it."""
    with _naming(folder):
        folder.mkdir(parents=True, exist_ok=True)
        handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    except BlockingIOError:
        raise DatasetError(f"another run is writing to {folder}: wait for it or stop it") from None
    finally:
        os.close(handle)


def plain(value: Any) -> Any:
    """Tables and lists as JSON gives them back."""
    return json.loads(json.dumps(value))


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise write_error(path, error) from error
