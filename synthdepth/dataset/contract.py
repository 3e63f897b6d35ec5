"""What a manifest and an index must hold before anything in them is used.

Both may come from anywhere: the names in them become paths, the numbers sizes of what is read.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping

import pyarrow as pa
import pyarrow.compute as pc

from synthdepth.config import shown
from synthdepth.dataset.pair import (
    ALWAYS,
    BY_MODALITY,
    MAP_NAME,
    META_FIELDS,
    SPLITS,
    is_map_name,
)

# Below the folder, and nowhere else.
_SHARD = r"([A-Za-z0-9_-][A-Za-z0-9._-]*/)*[A-Za-z0-9_-][A-Za-z0-9._-]*\.tar"
_WORDS = {"key": "[A-Za-z0-9_-]+", "shard": _SHARD, "map": MAP_NAME, "split": "|".join(SPLITS)}
_LENGTHS = {"intrinsics": 9, "world_from_cam": 16, "world_from_cam_prev": 16, "velocity_mps": 3}
_ARROW = {int: pa.int64(), float: pa.float64(), str: pa.string(), list: pa.list_(pa.float64())}


def file_columns(files: Iterable[str]) -> list[str]:
    """The columns of the index that say where files of a pair ("rgb.png") lie in their shards."""
    return [f"{file.split('.')[0]}_{what}" for file in files for what in ("offset", "size")]


# Every index has these.
INDEX_COLUMNS = ("key", "shard", *file_columns(ALWAYS), *META_FIELDS)


def check_manifest(manifest) -> None:
    """Refuse, with a ValueError of one line, what is no manifest of the contract."""
    _check(manifest, _MANIFEST)
    for number, record in enumerate(manifest["shards"]):
        _check(record, _RECORD, f"shards[{number}]")
    paths = [record["path"] for record in manifest["shards"]]
    if len(set(paths)) < len(paths):
        raise ValueError("it lists a shard twice")


def _check(table, allowed: Mapping, at: str = "") -> None:
    if not isinstance(table, Mapping):
        raise ValueError(f"{at or 'it'} is {shown(table)}: allowed is a table")
    for name, right in allowed.items():
        name, optional = name.rstrip("?"), name.endswith("?")
        where = f"{at}.{name}" if at else name
        if name not in table:
            if optional:
                continue
            raise ValueError(f"{where} is missing")
        if isinstance(right, Mapping):
            _check(table[name], right, where)
        elif not right(table[name]):
            raise ValueError(f"{where} is {shown(table[name])}, which the contract forbids")


def _is_whole(value) -> bool:
    return type(value) is int and 0 <= value < 2**63


def _is_number(value) -> bool:
    return type(value) in (int, float) and 0 <= value < math.inf


def _is_side(value) -> bool:
    return type(value) is int and 1 <= value <= 2**14


def _is(kind: type) -> Callable[[object], bool]:
    return lambda value: isinstance(value, kind)


def _is_range(value) -> bool:
    return _is_number(value) and value > 0


def _are_labels(value) -> bool:
    return isinstance(value, dict) and all(type(v) is int and 0 <= v < 256 for v in value.values())


def _are_modalities(value) -> bool:
    return isinstance(value, list) and all(v in list(BY_MODALITY) for v in value)


def _are_files(value) -> bool:
    """Sizes and checksums of files that lie in the dataset's folder itself."""
    return isinstance(value, dict) and all(
        re.fullmatch(r"[A-Za-z0-9_-][A-Za-z0-9._-]*", name)
        and isinstance(record, dict)
        and _is_whole(record.get("bytes"))
        and isinstance(record.get("sha256"), str)
        for name, record in value.items()
    )


def _is_shard(value) -> bool:
    return isinstance(value, str) and len(value) < 1000 and re.fullmatch(_SHARD, value) is not None


# A question mark is at what may be left out.
_MANIFEST = {
    "map": is_map_name,
    "seed": _is_whole,
    "train_share": _is_number,
    "pairs_planned": _is_whole,
    "complete": _is(bool),
    "splits": _is(dict),
    "software": _is(dict),
    "depth": {"max_depth_m": _is_range},
    "recipe": {
        "camera": {"width": _is_side, "height": _is_side},
        "flight?": {"max_acceleration_mps2?": _is_number},
        "sensor": {"model": lambda value: value in ("drawn", "ideal", "unknown")},
        "render": {"modalities": _are_modalities, "max_depth_m": _is_range},
    },
    "labels?": _are_labels,
    "files?": _are_files,
    "shards": _is(list),
}
_RECORD = {
    "path": _is_shard,
    "split": lambda value: value in SPLITS,
    "scene_index": _is_whole,
    "scene_seed": _is_whole,
    "pairs": _is_whole,
    "bytes": _is_whole,
    "sha256": _is(str),
}


def check_index(table: pa.Table, needed: Iterable[str]) -> None:
    """Refuse, with a ValueError of one line, rows that no index of the contract has.

    Args:
        table: some columns of the index or all.
        needed: columns that have to be there; a file's size always has to be with its offset.
    """
    files = {name.rpartition("_")[0] for name in table.schema.names if _is_of_file(name)}
    needed = [*needed, *file_columns(files)]
    lacking = [name for name in needed if name not in table.schema.names]
    if lacking:
        raise ValueError(f"it has no column {lacking[0]}")
    for name in table.schema.names:
        wanted = _arrow_type(name)
        column = table[name]
        if wanted is None:
            continue
        if column.type != wanted:
            raise ValueError(f"column {name} holds {column.type}: allowed is {wanted}")
        column.validate(full=True)
        if column.null_count or not _are_allowed(name, column):
            raise ValueError(f"column {name} has a value that the contract forbids")


def _is_of_file(name: str) -> bool:
    return name.endswith(("_offset", "_size"))


def _arrow_type(name: str) -> pa.DataType | None:
    if name in ("key", "shard"):
        return pa.string()
    if _is_of_file(name):
        return pa.int64()
    return _ARROW.get(META_FIELDS.get(name))


def _are_allowed(name: str, column: pa.ChunkedArray) -> bool:
    """Whether all values of a column are."""
    if name in _WORDS:
        return _all(pc.match_substring_regex(pc.unique(column), f"^({_WORDS[name]})$"))
    if pa.types.is_list(column.type):
        values = pc.list_flatten(column)
        whole = _all(pc.equal(pc.list_value_length(column), _LENGTHS[name]))
        return whole and not values.null_count and _all(pc.is_finite(values))
    if pa.types.is_integer(column.type):
        return _all(pc.greater_equal(column, 0))
    return pa.types.is_string(column.type) or _all(pc.is_finite(column))


def _all(values) -> bool:
    return pc.all(values, min_count=0).as_py()
