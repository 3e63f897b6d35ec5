"""`dataset.json` and `index.parquet`: what a dataset folder says of itself, for programs."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from synthdepth.config import parse_json
from synthdepth.dataset.contract import INDEX_COLUMNS, check_index, check_manifest, file_columns
from synthdepth.dataset.pair import ALWAYS, BY_MODALITY, META_FIELDS, decode_meta
from synthdepth.dataset.shard import read_members, shard_members, write_whole
from synthdepth.errors import DatasetError

MANIFEST = "dataset.json"
INDEX = "index.parquet"
CARD = "README.md"
SHEET = "card.jpg"
CROISSANT = "croissant.json"
CHECKSUMS = "checksums.sha256"
# What is made of the manifest and the shards.
DERIVED = (INDEX, CARD, SHEET, CROISSANT)
# What a finished dataset folder holds beside its shards.
DESCRIPTIONS = (MANIFEST, *DERIVED, CHECKSUMS)

# What decides the bytes of a dataset: a run may only go on in a folder that agrees in all of it.
IDENTITY = ("schema_version", "map", "seed", "train_share", "recipe", "software")

_ARROW = {int: pa.int64(), float: pa.float64(), str: pa.string()}
_MATRICES = ("intrinsics", "world_from_cam", "world_from_cam_prev")


def read_manifest(folder: Path) -> dict:
    """The manifest of a dataset folder.

    Raises:
        DatasetError: there is none, or it cannot be read.
    """
    path = Path(folder) / MANIFEST
    try:
        manifest = parse_json(path.read_bytes())
        check_manifest(manifest)
        return manifest
    except FileNotFoundError:
        raise DatasetError(f"{folder} holds no dataset: there is no {MANIFEST}") from None
    except (OSError, ValueError) as error:
        raise DatasetError(f"{path} is not a manifest: {error}") from error


def write_manifest(folder: Path, manifest: Mapping) -> None:
    """Replace the manifest whole."""
    write_whole(Path(folder) / MANIFEST, manifest_bytes(manifest))


def manifest_bytes(manifest: Mapping) -> bytes:
    """The bytes of `dataset.json`, which are a function of what it says."""
    return json.dumps(manifest, indent=1).encode() + b"\n"


def check_identity(folder: Path, there: Mapping, asked: Mapping) -> None:
    """Refuse to go on in a folder that holds another dataset; names the first difference."""
    for name in IDENTITY:
        for key, old, new in _differences(name, there.get(name), asked.get(name)):
            raise DatasetError(
                f"{folder} holds a different dataset: {key} is {json.dumps(old)} there and "
                f"{json.dumps(new)} was asked for; choose another --out (nothing was touched)"
            )


def _differences(key: str, old, new):
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for name in sorted(old.keys() | new.keys()):
            yield from _differences(f"{key}.{name}", old.get(name), new.get(name))
    elif old != new:
        yield key, old, new


def pair_files(manifest: Mapping) -> list[str]:
    """The files of every pair of a dataset: "rgb.png", "prev.png", ..."""
    return [*ALWAYS, *(BY_MODALITY[name] for name in manifest["recipe"]["render"]["modalities"])]


def write_index(
    folder: Path,
    manifest: Mapping,
    table_of: Callable[[Mapping], pa.Table] | None = None,
) -> None:
    """Write `index.parquet`, a row a pair: where its files lie, and all of its metadata.

    Args:
        folder: the dataset folder.
        manifest: the dataset's, with its shards.
        table_of: gives the rows of a shard by its record; reads the folder's shards by default.
    """
    if table_of is None:

        def table_of(record: Mapping) -> pa.Table:
            return index_table(Path(folder) / record["path"], record["path"], manifest)

    sink = pa.BufferOutputStream()
    with pq.ParquetWriter(sink, _index_schema(manifest), compression="zstd") as writer:
        for record in manifest["shards"]:
            writer.write_table(table_of(record))
    write_whole(Path(folder) / INDEX, sink.getvalue().to_pybytes())


def index_table(path: Path, shard: str, manifest: Mapping) -> pa.Table:
    """A shard's rows of the index.

    Args:
        path: of the shard.
        shard: its path within the dataset.
        manifest: the dataset's, of which `recipe` is used.

    Raises:
        DatasetError: the shard cannot be read, or holds something else.
    """
    try:
        rows = [_index_row(path, shard, key, files) for key, files in shard_members(path).items()]
        return pa.Table.from_pylist(rows, _index_schema(manifest))
    except (OSError, ValueError, KeyError) as error:
        raise DatasetError(f"{path} is broken: {error}; synthdepth verify says more") from error


def _index_schema(manifest: Mapping) -> pa.Schema:
    return pa.schema(
        [("key", pa.string()), ("shard", pa.string())]
        + [(name, pa.int64()) for name in file_columns(pair_files(manifest))]
        + [
            (name, pa.list_(pa.float64()) if kind is list else _ARROW[kind])
            for name, kind in META_FIELDS.items()
        ]
    )


def _index_row(path: Path, shard: str, key: str, members: Mapping) -> dict:
    meta = decode_meta(read_members(path, {"meta.json": members["meta.json"]})["meta.json"])
    for name in _MATRICES:
        meta[name] = [value for row in meta[name] for value in row]
    row = {"key": key, "shard": shard} | meta
    for suffix, member in members.items():
        name = suffix.split(".")[0]
        row |= {f"{name}_offset": member.offset, f"{name}_size": member.size}
    return row


def read_index(folder: Path, columns: list[str] | None = None) -> pa.Table:
    """The index of a dataset folder, a row a pair, matrices flattened row by row.

    Raises:
        DatasetError: there is none, it cannot be read, or it holds something else.
    """
    path = Path(folder) / INDEX
    try:
        table = pq.read_table(path, columns=columns)
        check_index(table, columns or INDEX_COLUMNS)
        if not len(table):
            raise ValueError("it lists no pair")
        return table
    except FileNotFoundError:
        raise DatasetError(f"{folder} has no {INDEX}: the run has not finished") from None
    except (OSError, ValueError, pa.ArrowException) as error:
        raise DatasetError(f"{path} cannot be read: {error}") from error
