"""The flights of a dataset as its index has them: which pairs are theirs, and where they go."""

import dataclasses
import itertools
from collections.abc import Iterator

import numpy as np
import pyarrow as pa

from synthdepth.errors import DatasetError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Flight:
    """What a dataset holds of one flight: runs of consecutive frames, with gaps between them.

    Attributes:
        name: as in the keys of its pairs, e.g. `city-s00012-f003`.
        rows: (n,) int, its rows in the index, in the order of time.
        frames: (n,) int, frame numbers within the flight.
        positions_m: (n, 3) float64, of the camera in each frame, world [m].
        starts_m: (n, 3) float64, of the camera in the frame before each.
    """

    name: str
    rows: np.ndarray
    frames: np.ndarray
    positions_m: np.ndarray
    starts_m: np.ndarray

    @property
    def scene(self) -> str:
        """The scene's name, e.g. `city-s00012`; worlds of two scenes have nothing in common."""
        return self.name.rpartition("-")[0]

    def runs(self) -> Iterator[np.ndarray]:
        """Positions (m, 3) [m] of each run of consecutive frames, from the first one's frame t-1.

        What lies between two runs is not in the dataset; a straight line there would be a guess.
        """
        breaks = np.flatnonzero(np.diff(self.frames) != 1) + 1
        for run in np.split(np.arange(len(self.rows)), breaks):
            yield np.concatenate([self.starts_m[run[:1]], self.positions_m[run]])

    def gaps(self) -> Iterator[np.ndarray]:
        """The (2, 3) ends [m] of what lies between two runs."""
        for before, after in itertools.pairwise(self.runs()):
            yield np.stack([before[-1], after[0]])


def flights_of(index: pa.Table) -> list[Flight]:
    """The flights of an index, in its order.

    Raises:
        DatasetError: the index lacks a column.
    """
    for name in ("key", "frame_index", "world_from_cam", "world_from_cam_prev"):
        if name not in index.schema.names:
            raise DatasetError(f"the index has no column {name}; synthdepth verify says more")
    rows_of: dict[str, list[int]] = {}
    for row, key in enumerate(index["key"].to_pylist()):
        rows_of.setdefault(key.rpartition("-")[0], []).append(row)
    frames = index["frame_index"].to_numpy()
    here, before = (_positions(index, name) for name in ("world_from_cam", "world_from_cam_prev"))
    flights = []
    for name, found in rows_of.items():
        rows = np.array(found)[np.argsort(frames[found], kind="stable")]
        flights.append(
            Flight(
                name=name,
                rows=rows,
                frames=frames[rows],
                positions_m=here[rows],
                starts_m=before[rows],
            )
        )
    return flights


def _positions(index: pa.Table, name: str) -> np.ndarray:
    poses = index[name].combine_chunks().flatten().to_numpy().reshape(-1, 4, 4)
    return poses[:, :3, 3]
