"""What every export shares: a folder that is there whole or not at all, and the pairs for it."""

import dataclasses
from collections.abc import Callable, Iterator
from pathlib import Path

from synthdepth.camera import is_rigid
from synthdepth.dataset.contract import file_columns
from synthdepth.dataset.manifest import pair_files, read_index, read_manifest
from synthdepth.dataset.pair import Pair, decode_pair
from synthdepth.dataset.shard import Member, read_members
from synthdepth.errors import DatasetError


@dataclasses.dataclass(frozen=True, kw_only=True)
class ExportReport:
    """What an export did.

    Attributes:
        folder: where it is.
        pairs: how many pairs went in.
        notes: what the other format cannot say, or says otherwise; a line each.
    """

    folder: Path
    pairs: int
    notes: tuple[str, ...] = ()


def write_file(path: Path, data: bytes) -> None:
    """Write a file of an export, and the folders that lead to it."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


def read_pairs(
    folder: Path,
    *,
    split: str | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> Iterator[Pair]:
    """The pairs of a finished dataset in the order of their keys: by scene, flight and frame.

    Args:
        folder: the dataset.
        split: `train` or `test`; both without.
        on_progress: called with (pairs done, pairs in all) after each.

    Raises:
        DatasetError: no finished dataset, no pair of that split, or a file cannot be read. All but
            the last are raised at once, not when the first pair is asked for.
    """
    folder = Path(folder)
    suffixes = {suffix: suffix.split(".")[0] for suffix in pair_files(read_manifest(folder))}
    rows = read_index(folder, ["key", "shard", "split", *file_columns(suffixes)]).to_pylist()
    splits = sorted({row["split"] for row in rows})
    if split is not None and split not in splits:
        raise DatasetError(f"split {split!r}: {folder} has {', '.join(splits) or 'no pairs'}")
    if not rows:
        raise DatasetError(f"{folder} has no pairs")
    rows = sorted(
        (row for row in rows if split in (None, row["split"])), key=lambda row: row["key"]
    )
    return _decoded(folder, rows, suffixes, on_progress)


def _decoded(folder: Path, rows: list[dict], suffixes: dict, on_progress) -> Iterator[Pair]:
    for done, row in enumerate(rows, start=1):
        members = {
            suffix: Member(offset=row[f"{name}_offset"], size=row[f"{name}_size"])
            for suffix, name in suffixes.items()
        }
        try:
            pair = decode_pair(row["key"], read_members(folder / row["shard"], members))
            if not (is_rigid(pair.world_from_cam) and is_rigid(pair.world_from_cam_prev)):
                raise ValueError(f"pair {row['key']} has a pose that is no rotation")
        except (OSError, ValueError) as error:
            raise DatasetError(f"{folder / row['shard']}: {error}") from error
        yield pair
        on_progress(done, len(rows))
