"""Which pairs: the indexes of dataset folders, here or remote, filtered by their columns."""

import dataclasses
import math
from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from synthdepth.config import parse_json
from synthdepth.dataset.contract import INDEX_COLUMNS, check_index, check_manifest, file_columns
from synthdepth.dataset.manifest import INDEX, MANIFEST, read_manifest
from synthdepth.dataset.pair import FIELDS
from synthdepth.errors import DatasetError

Where = Mapping[str, str | Collection[str] | tuple[float, float]]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Rows:
    """Chosen pairs in the order of their indexes, as columns: about 100 bytes a pair.

    Attributes:
        keys: (N,) names.
        shards: paths or addresses of the shards.
        shard_of: (N,) int32, places in `shards`.
        scenes: (N, 2) int64, the place among the folders and the scene's number in it.
        members: (N, 2) int64 by file of a pair ("rgb.png"): first byte and number of bytes.
    """

    keys: pa.StringArray
    shards: list[str]
    shard_of: np.ndarray
    scenes: np.ndarray
    members: Mapping[str, np.ndarray]


def is_remote(place: str) -> bool:
    """Whether a path is an address (`https://...`, `s3://...`, whatever fsspec knows)."""
    return "://" in place


def open_file(place: str) -> BinaryIO:
    """A file to read from its start, here or remote; no shell ever sees the name."""
    if not is_remote(place):
        return open(place, "rb")
    import fsspec

    return fsspec.open(place, "rb").open()


def within(folder: str, name: str) -> str:
    """Path or address of a dataset's file."""
    return f"{folder.rstrip('/')}/{name}"


def places(given: str | Path | Iterable[str | Path]) -> list[str]:
    """One folder or several, as a list of paths and addresses."""
    several = [given] if isinstance(given, str | Path) else list(given)
    if not several:
        raise DatasetError("no dataset was given: allowed is a folder or a list of folders")
    return [str(place) for place in several]


def manifest_of(folder: str) -> dict:
    """The manifest of a folder, here or remote."""
    if not is_remote(folder):
        return read_manifest(Path(folder))

    def read(file: BinaryIO) -> dict:
        manifest = parse_json(file.read())
        check_manifest(manifest)
        return manifest

    return _fetched(within(folder, MANIFEST), read)


def read_rows(
    folders: list[str],
    *,
    split: str | None,
    where: Where | None,
    fields: Collection[str] | None,
) -> tuple[Rows, tuple[str, ...]]:
    """The pairs of some folders that a filter lets through, and the fields to decode of them.

    Args:
        folders: paths or addresses.
        split: "train" or "test"; None is both.
        where: {column of the index: what is let through}. Of words, one or a collection of them; of
            numbers, a closed range (low, high).
        fields: names in `FIELDS`; None is all that every folder has.

    Raises:
        DatasetError: a folder without an index, an unknown column or field, a word that occurs
            nowhere, no range, or nothing is left.
    """
    where = dict(where or {}) | ({} if split is None else {"split": split})
    indexes = [_open_index(folder) for folder in folders]
    for folder, index in zip(folders, indexes, strict=True):
        lacking = [name for name in INDEX_COLUMNS if name not in index.schema_arrow.names]
        if lacking:
            raise DatasetError(f"{within(folder, INDEX)} cannot be used: no column {lacking[0]}")
    schemas = [index.schema_arrow for index in indexes]
    columns = [c for c in schemas[0] if all(c.name in schema.names for schema in schemas)]
    _check_columns(where, columns)
    names = {column.name for column in columns}
    here = [name for name, file in FIELDS.items() if names.issuperset(file_columns([file]))]
    fields = checked_fields(fields, here)
    files = ["meta.json", *(FIELDS[name] for name in fields)]
    wanted = ["key", "shard", "scene_index", *where, *file_columns(files)]
    tables, shards = [], []
    for place, (folder, index) in enumerate(zip(folders, indexes, strict=True)):
        table = _columns_of(within(folder, INDEX), index, list(dict.fromkeys(wanted)))
        names = pc.unique(table["shard"])
        number = pc.add(pc.index_in(table["shard"], names), len(shards)).cast(pa.int32())
        shards += [within(folder, name) for name in names.to_pylist()]
        table = table.append_column("shard_of", number)
        folder_of = pa.array(np.full(len(table), place))
        tables.append(table.append_column("folder_of", folder_of))
    table = pa.concat_tables(tables)
    if not len(table):
        raise DatasetError(f"{', '.join(folders)}: no pair has been written")
    table = table.take(np.flatnonzero(_mask(table, where))).combine_chunks()
    offsets_sizes = {
        file: np.stack([table[name].to_numpy() for name in file_columns([file])], -1)
        for file in files
    }
    rows = Rows(
        keys=table["key"].chunk(0),
        shards=shards,
        shard_of=table["shard_of"].to_numpy(),
        scenes=np.stack([table[name].to_numpy() for name in ("folder_of", "scene_index")], -1),
        members=offsets_sizes,
    )
    return rows, fields


def checked_fields(fields: Collection[str] | None, here: list[str]) -> tuple[str, ...]:
    """The fields to decode: those asked for, or all that there are."""
    if fields is None:
        return tuple(here)
    fields = (fields,) if isinstance(fields, str) else tuple(fields)
    unknown = [name for name in fields if name not in here]
    if unknown or not fields:
        raise DatasetError(
            f"fields = {', '.join(map(repr, fields)) or 'none'}: allowed are {', '.join(here)}"
        )
    return fields


def _open_index(folder: str) -> pq.ParquetFile:
    place = within(folder, INDEX)
    if is_remote(place):
        return _fetched(place, lambda file: pq.ParquetFile(pa.BufferReader(file.read())))
    try:
        return pq.ParquetFile(place)
    except FileNotFoundError:
        read_manifest(Path(folder))
        raise DatasetError(f"{folder} has no {INDEX}: the run has not finished") from None
    except (OSError, pa.ArrowException) as error:
        raise DatasetError(f"{place} cannot be read: {error}") from error


def _columns_of(place: str, index: pq.ParquetFile, names: list[str]) -> pa.Table:
    try:
        table = index.read(columns=names)
        check_index(table, names)
    except (OSError, ValueError, pa.ArrowException) as error:
        raise DatasetError(f"{place} cannot be used: {error}") from error
    return table


def _fetched(place: str, read):
    """What `read` makes of a remote file."""
    # Every kind of storage has errors of its own.
    try:
        with open_file(place) as file:
            return read(file)
    except Exception as error:
        raise DatasetError(f"{place} cannot be read: {error or type(error).__name__}") from error


def _check_columns(where: Mapping, columns: list[pa.Field]) -> None:
    allowed = [
        column.name
        for column in columns
        if column.name not in ("key", "shard")
        and not column.name.endswith(("_offset", "_size"))
        and not pa.types.is_list(column.type)
    ]
    for name in where:
        if name not in allowed:
            raise DatasetError(f"where {name} is unknown: allowed are {', '.join(allowed)}")


def _mask(table: pa.Table, where: Mapping) -> np.ndarray:
    """(N,) bool, the rows that pass all filters; some must."""
    mask = np.ones(len(table), bool)
    there = []
    for name, allowed in where.items():
        text, passes = _filter(name, table[name], allowed)
        there.append(text)
        mask &= passes
    if not mask.any():
        asked = ", ".join(f"{name} = {allowed!r}" for name, allowed in where.items())
        raise DatasetError(f"no pair has {asked}: there is {', '.join(there)}")
    return mask


def _filter(name: str, column: pa.ChunkedArray, allowed) -> tuple[str, np.ndarray]:
    """What a column holds, in words, and which of its rows pass."""
    if pa.types.is_string(column.type):
        there = sorted(pc.unique(column).to_pylist())
        words = [allowed] if isinstance(allowed, str) else allowed
        text = f"{name} {', '.join(there)}"
        known = isinstance(words, Collection) and all(word in there for word in words)
        if not known or not words:
            raise DatasetError(f"{name} = {allowed!r}: allowed are {', '.join(there)}")
        return text, pc.is_in(column, pa.array(list(words))).to_numpy()
    values = column.to_numpy()
    text = f"{name} {values.min():g} to {values.max():g}"
    if not _is_range(allowed):
        raise DatasetError(f"{name} = {allowed!r}: allowed is a range (low, high); there is {text}")
    low, high = allowed
    return text, (values >= low) & (values <= high)


def _is_range(value) -> bool:
    """Two numbers, the first not above the second; either may be infinite."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        return False
    numbers = all(isinstance(n, int | float | np.number) and not math.isnan(n) for n in value)
    return numbers and value[0] <= value[1]
