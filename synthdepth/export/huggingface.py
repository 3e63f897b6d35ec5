"""Our datasets as Parquet files that `datasets.load_dataset(folder)` reads with the right types.

    README.md                                 card: columns and their types, figures, licence
    card.jpg
    data/train-00000-of-00012.parquet ...     a scene each, with the split's name

Pictures are `Image` columns, the same PNG files; depth, flow, normals and matrices are `Array2D` or
`Array3D`: exact float32 metres, with no file format in between. The card declares the types, so
that `datasets` guesses nothing, and so does each file as far as `datasets` heeds it. Writing needs
pyarrow alone.
"""

import dataclasses
import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from synthdepth.dataset.card import (
    dataset_name,
    figures,
    hub_header,
    license_text,
    sheet_jpeg,
    summary,
)
from synthdepth.dataset.folder import new_folder
from synthdepth.dataset.manifest import CARD, SHEET, read_index, read_manifest
from synthdepth.dataset.pair import FIELDS, META_FIELDS, decode_fields, decode_meta
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.errors import DatasetError
from synthdepth.export.folder import ExportReport, write_file

# Uncompressed: small enough to stream, large enough to compress.
_ROW_GROUP_BYTES = 32 * 2**20
_MATRICES = {"intrinsics": (3, 3), "world_from_cam": (4, 4), "world_from_cam_prev": (4, 4)}
_DTYPES = {int: "int64", float: "float64", str: "string", list: "float64"}
_ARROW = {
    "int64": pa.int64(),
    "float64": pa.float64(),
    "string": pa.string(),
    "float32": pa.float32(),
    "bool": pa.bool_(),
}
_IMAGE = pa.struct([("bytes", pa.binary()), ("path", pa.string())])

_COLUMN_LINES = {
    "key": "name of the pair, unique in the dataset",
    "rgb": "frame *t*, 8-bit sRGB",
    "prev": "frame *t-1* of the same flight",
    "depth_m": "depth of frame *t*: **metres**, **planar** (z in the camera's frame), one ray "
    "through each pixel's centre; {max_depth_m:g} is that far or farther, the sky included",
    "flow": "where each pixel was at *t-1*, minus where it is now: (u, v) [px]",
    "visible": "whether that place was seen at *t-1*",
    "seg": "class ids: {labels}",
    "normal": "unit normals in camera axes, turned to the camera; 0 in the sky",
}


def export_hf(
    folder: Path,
    out: Path,
    *,
    split: str | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> ExportReport:
    """Write a dataset as Parquet with a card, for `datasets` and the Hugging Face Hub.

    Args:
        folder: the dataset.
        out: the folder to write, new or empty.
        split: `train` or `test`; both without.
        on_progress: called with (pairs done, pairs in all).

    Raises:
        DatasetError: the dataset cannot be read, `out` is taken or cannot be written.
    """
    folder, out = Path(folder), Path(out)
    manifest, index = read_manifest(folder), read_index(folder)
    splits = sorted(set(index["split"].to_pylist()))
    if split is not None:
        if split not in splits:
            raise DatasetError(f"split {split!r}: {folder} has {', '.join(splits) or 'no pairs'}")
        splits, index = [split], index.filter(pc.equal(index["split"], split))
    columns, done = _columns(manifest), 0
    with new_folder(out) as root:
        (root / "data").mkdir()
        for name in splits:
            shards = [s["path"] for s in manifest["shards"] if s["split"] == name and s["pairs"]]
            for number, shard in enumerate(shards):
                path = root / f"data/{name}-{number:05d}-of-{len(shards):05d}.parquet"
                for written in _write_parquet(path, columns, _rows(folder / shard, columns)):
                    done += written
                    on_progress(done, len(index))
        write_file(root / SHEET, sheet_jpeg(folder))
        write_file(root / CARD, _card(manifest, index, columns).encode())
    note = "with_format('numpy') or 'torch' gives depth and matrices as arrays, not lists of lists"
    return ExportReport(folder=out, pairs=len(index), notes=(note,))


def _rows(shard: Path, columns: Mapping[str, "_Column"]) -> Iterator[dict]:
    """What each column holds of the pairs of a shard: files of pictures, arrays, values."""
    # Pictures stay the files that they are.
    arrays = [name for name in FIELDS if name in columns and columns[name].dtype]
    pictures = [name for name in FIELDS if name in columns and not columns[name].dtype]
    try:
        for key, members in shard_members(shard).items():
            files = read_members(shard, members)
            meta = decode_meta(files["meta.json"])
            row = {"key": key} | {name: files[FIELDS[name]] for name in pictures}
            row |= decode_fields(files, arrays, meta)
            if row["depth_m"].shape != columns["depth_m"].shape:
                raise ValueError(f"pair {key} has another size than its dataset")
            yield row | meta | {name: np.array(meta[name]) for name in _MATRICES}
    except (OSError, ValueError, KeyError) as error:
        raise DatasetError(f"{shard} cannot be read: {error}") from error


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Column:
    """A column: a value, an `Image` (no dtype), an array of a shape, or a list of any length."""

    dtype: str | None = None
    shape: tuple[int, ...] = ()
    is_list: bool = False

    @property
    def feature(self) -> dict:
        """As `datasets.Features.to_dict()` writes it."""
        if self.dtype is None:
            return {"_type": "Image"}
        if self.shape:
            name = f"Array{len(self.shape)}D"
            return {"shape": list(self.shape), "dtype": self.dtype, "_type": name}
        value = {"dtype": self.dtype, "_type": "Value"}
        # What releases of `datasets` before and after its 4.0 understand; now it is `List`.
        return {"feature": value, "_type": "Sequence"} if self.is_list else value

    @property
    def yaml(self) -> str:
        """As the card's header declares it."""
        if self.shape:
            array = f"array{len(self.shape)}_d"
            return f"dtype: {{{array}: {{shape: {list(self.shape)}, dtype: {self.dtype}}}}}"
        return f"list: {self.dtype}" if self.is_list else f"dtype: {self.dtype or 'image'}"

    @property
    def arrow(self) -> pa.DataType:
        """How it is stored."""
        kind = _ARROW[self.dtype] if self.dtype else _IMAGE
        for _ in range(len(self.shape) + self.is_list):
            kind = pa.list_(kind)
        return kind

    def __str__(self) -> str:
        return f"{self.dtype} {self.shape}" if self.shape else self.dtype or "Image"


def _columns(manifest: dict) -> dict[str, _Column]:
    size = tuple(manifest["recipe"]["camera"][name] for name in ("height", "width"))
    of_modality = {
        "flow": {
            "flow": _Column(dtype="float32", shape=(*size, 2)),
            "visible": _Column(dtype="bool", shape=size),
        },
        "seg": {"seg": _Column()},
        "normal": {"normal": _Column(dtype="float32", shape=(*size, 3))},
    }
    columns = {"key": _Column(dtype="string"), "rgb": _Column(), "prev": _Column()}
    columns["depth_m"] = _Column(dtype="float32", shape=size)
    for name in manifest["recipe"]["render"]["modalities"]:
        columns |= of_modality[name]
    for name, kind in META_FIELDS.items():
        shape = _MATRICES.get(name, ())
        is_list = kind is list and not shape
        columns[name] = _Column(dtype=_DTYPES[kind], shape=shape, is_list=is_list)
    return columns


def _write_parquet(path: Path, columns: dict[str, _Column], rows: Iterator[dict]) -> Iterator[int]:
    """Write a file, a row group at a time; yields how many rows each has."""
    features = {name: column.feature for name, column in columns.items()}
    schema = pa.schema([(name, column.arrow) for name, column in columns.items()])
    schema = schema.with_metadata({"huggingface": json.dumps({"info": {"features": features}})})
    # Bytes of equal weight side by side: lossless, and depth shrinks by a third more.
    split_bytes = [
        name + ".list.element" * len(column.shape)
        for name, column in columns.items()
        if column.dtype == "float32"
    ]
    words = [name for name, column in columns.items() if column.dtype == "string"]
    options = {"use_dictionary": words, "use_byte_stream_split": split_bytes}
    with pq.ParquetWriter(path, schema, compression="zstd", **options) as writer:
        for group in _row_groups(rows):
            arrays = [_array(name, column, group) for name, column in columns.items()]
            writer.write_table(pa.Table.from_arrays(arrays, schema=schema))
            yield len(group)


def _row_groups(rows: Iterator[dict]) -> Iterator[list[dict]]:
    group, size = [], 0
    for row in rows:
        group.append(row)
        size += sum(value.nbytes for value in row.values() if isinstance(value, np.ndarray))
        size += sum(len(value) for value in row.values() if isinstance(value, bytes))
        if size >= _ROW_GROUP_BYTES:
            yield group
            group, size = [], 0
    if group:
        yield group


def _array(name: str, column: _Column, rows: list[dict]) -> pa.Array:
    """A column of some rows."""
    values = [row[name] for row in rows]
    if column.shape:
        return _nested(np.stack(values))
    if column.dtype:
        return pa.array(values, column.arrow)
    paths = [f"{row['key']}.{name}.png" for row in rows]
    return pa.StructArray.from_arrays([pa.array(values), pa.array(paths)], fields=list(_IMAGE))


def _nested(stack: np.ndarray) -> pa.Array:
    """An array (n, ...) as n lists of lists."""
    column = pa.array(stack.reshape(-1))
    for size in stack.shape[:0:-1]:
        offsets = np.arange(0, len(column) + 1, size, dtype=np.int32)
        column = pa.ListArray.from_arrays(offsets, column)
    return column


def _card(manifest: dict, index: pa.Table, columns: dict[str, _Column]) -> str:
    counts = Counter(index["split"].to_pylist())
    manifest = manifest | {"splits": dict(counts)}
    splits = sorted(counts, reverse=True)
    patterns = [(name, f"data/{name}-*.parquet") for name in splits]
    entries = [f"{{name: {name}, {column.yaml}}}" for name, column in columns.items()]
    known = {
        "max_depth_m": manifest["depth"]["max_depth_m"],
        "labels": ", ".join(f"{n} {name}" for name, n in manifest["labels"].items()),
    }
    told = "".join(
        f"| `{name}` | {columns[name]} | {line.format(**known)} |\n"
        for name, line in _COLUMN_LINES.items()
        if name in columns
    )
    return f"""{hub_header(manifest, len(index), patterns, entries)}
# {dataset_name(manifest)}

{summary(manifest)}

![Frames, the frames before, depth]({SHEET})

{figures(index)}
## Columns

| column | type | |
|---|---|---|
{told}
and all metadata: intrinsics (integer pixel coordinates are pixel centres), poses `world_from_cam`
(4x4, OpenCV axes: x right, y down, z forward; the world in metres, Z up), flight, light, sensor;
units are in the names. `with_format` makes arrays of what else are lists of lists; poses it rounds
to float32.

```python
import os

from datasets import load_dataset

rows = load_dataset(os.getcwd(), split="{splits[0]}").with_format("numpy")
row = rows[0]
print(row["key"], row["rgb"].shape, row["depth_m"].dtype, row["depth_m"].min())
```

Written by `synthdepth export`{_origin(manifest)}.

{license_text(manifest)}"""


def _origin(manifest: Mapping) -> str:
    if "source" in manifest:
        return ""
    return (
        f" from a dataset of seed {manifest['seed']}, which the same version of\nsynthdepth "
        "renders again, byte for byte"
    )
