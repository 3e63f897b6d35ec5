"""Where the time of flights went."""

import dataclasses
import json
import sys
from collections.abc import Iterable
from pathlib import Path

from synthdepth.config import parse_json
from synthdepth.errors import DatasetError

_MOST = sys.float_info.max


@dataclasses.dataclass(frozen=True, kw_only=True)
class Spent:
    """Time [s] of one process.

    Attributes:
        flights, frames: how many were flown in it.
        build_s: scenes, their trees of triangles, and drawing scenarios.
        survey_s: views from above and shortest ways.
        load_s: loading scenes into the renderer.
        sight_s: rendering what the sources see.
        depth_s: the sources' own work.
        physics_s: planning, motion, contacts, results.
    """

    flights: int = 0
    frames: int = 0
    build_s: float = 0.0
    survey_s: float = 0.0
    load_s: float = 0.0
    sight_s: float = 0.0
    depth_s: float = 0.0
    physics_s: float = 0.0

    def __add__(self, other: "Spent") -> "Spent":
        ours, theirs = dataclasses.asdict(self), dataclasses.asdict(other)
        return Spent(**{name: ours[name] + theirs[name] for name in ours})

    @property
    def is_time(self) -> bool:
        """Whether all of them are numbers from 0."""
        values = dataclasses.astuple(self)
        return all(type(value) in (int, float) and 0 <= value <= _MOST for value in values)

    @property
    def scenes_s(self) -> float:
        """What scenes took, whoever flies in them."""
        return self.build_s + self.survey_s + self.load_s

    @property
    def flying_s(self) -> float:
        """What flights took."""
        return self.sight_s + self.depth_s + self.physics_s


def spent_line(source: str, spent: Spent) -> bytes:
    """A line of a file that `read_spent` reads; what no single source took has the source ""."""
    return json.dumps({"source": source} | dataclasses.asdict(spent)).encode() + b"\n"


def read_spent(files: Iterable[Path]) -> dict[str, Spent]:
    """What such files say by source, in the order in which sources first come.

    A line that a kill cut short counts as none.

    Raises:
        DatasetError: a file cannot be read, or holds something else.
    """
    spent: dict[str, Spent] = {}
    for file in files:
        try:
            for line in file.read_bytes().splitlines(keepends=True):
                if line.endswith(b"\n"):
                    fields = parse_json(line)
                    source, one = fields.pop("source"), Spent(**fields)
                    if not isinstance(source, str) or not one.is_time:
                        raise ValueError("no source, or no time")
                    spent[source] = spent.get(source, Spent()) + one
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            raise DatasetError(f"{file} cannot be read: remove it, it only holds times") from None
    return spent
