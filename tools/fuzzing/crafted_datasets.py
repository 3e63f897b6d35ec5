"""Datasets made by hand: archives that climb out of their folder, names and numbers that lie."""

import io
import json
import tarfile
from collections.abc import Callable
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq

from fuzzing.parts import (
    ABSURD,
    BOTH,
    WINDOWS,
    Craft,
    absurd_png,
    exr_window,
    first,
    json_files,
    png_bomb,
    replace,
    text_bomb,
)
from synthdepth.dataset.manifest import INDEX, MANIFEST

# Shards.


def _tar(change: Callable[[tarfile.TarFile], None], *, before: bool = False) -> Craft:
    """The first shard with some members more, behind its own or before them."""

    def craft(folder: Path) -> None:
        path = first(folder, "*/*.tar")
        members = []
        with tarfile.open(path) as tar:
            members = [(info, tar.extractfile(info).read()) for info in tar]
        with tarfile.open(path, "w", format=tarfile.PAX_FORMAT) as tar:
            if before:
                change(tar)
            for info, data in members:
                tar.addfile(info, io.BytesIO(data))
            if not before:
                change(tar)

    return craft


def _member(name: str, data: bytes = b"x", **fields) -> Callable[[tarfile.TarFile], None]:
    def change(tar: tarfile.TarFile) -> None:
        info = tarfile.TarInfo(name)
        info.size = len(data)
        for field, value in fields.items():
            setattr(info, field, value)
        tar.addfile(info, io.BytesIO(data))

    return change


def _lying_size(size: bytes) -> Craft:
    """The first member says that it has another size than it has."""

    def craft(folder: Path) -> None:
        path = first(folder, "*/*.tar")
        data = bytearray(path.read_bytes())
        data[124:136] = size.ljust(12, b"\0")
        data[148:156] = b" " * 8
        data[148:156] = b"%06o\0 " % sum(data[:512])
        path.write_bytes(data)

    return craft


def _long_names(count: int, size: int) -> Craft:
    """So many headers of long names before the first member, each of so many bytes."""

    def craft(folder: Path) -> None:
        path = first(folder, "*/*.tar")
        info = tarfile.TarInfo("././@LongLink")
        info.type, info.size = tarfile.GNUTYPE_LONGNAME, size
        header = info.tobuf(tarfile.GNU_FORMAT)
        path.write_bytes(header * count + path.read_bytes())

    return craft


_EVIL = ("../../x", "/etc/x", "a/b", "..", "a\nb", "é" * 80, "x" * 3000)
SHARD: list[Craft] = [
    *(_tar(_member(f"{name}.rgb.png")) for name in _EVIL),
    *(_tar(_member(f"{name}.meta.json", b"{}"), before=True) for name in _EVIL),
    *(
        _tar(_member("x.rgb.png", b"", type=kind, linkname=to))
        for kind in (
            tarfile.SYMTYPE,
            tarfile.LNKTYPE,
            tarfile.CHRTYPE,
            tarfile.FIFOTYPE,
            tarfile.DIRTYPE,
        )
        for to in ("/etc/passwd", "../../x")
    ),
    _tar(_member("x.rgb.png", pax_headers={"path": "../../x.rgb.png"})),
    _tar(_member("x.rgb.png", pax_headers={"size": "99999999999999"})),
    _tar(_member("x.rgb.png", pax_headers={"GNU.sparse.map": "0,1,9999999999,1"})),
    _long_names(3000, 0),
    _long_names(1, 2**33 - 1),
    *map(
        _lying_size, (b"77777777777", b"0", b"-1", b"\x80" + b"\0" * 3 + b"\xff" * 8, b"\xff" * 12)
    ),
]


MEMBER: list[Craft] = [
    *(replace("members/*/*/*.rgb.png", lambda _, s=size: absurd_png(*s)) for size in ABSURD),
    *(replace("members/*/*/*.prev.png", lambda _, s=size: absurd_png(*s)) for size in ABSURD),
    replace("members/*/*/*.rgb.png", lambda _: png_bomb(16_384, 16_384, colour=0)),
    replace("members/*/*/*.rgb.png", lambda _: png_bomb(8192, 8192)),
    replace("members/*/*/*.rgb.png", text_bomb),
    *(replace("members/*/*/*.depth.exr", exr_window(w, BOTH)) for w in WINDOWS),
    *(replace("members/*/*/*.depth.exr", exr_window(w, BOTH[:1])) for w in WINDOWS),
    replace("members/*/*/*.depth.exr", lambda d: d.replace(b'"[[', b'"' + b"[" * 1000)),
]


# Manifest and index.


def _manifest(change: Callable[[dict], object]) -> Craft:
    def craft(folder: Path) -> None:
        manifest = json.loads((folder / MANIFEST).read_text())
        change(manifest)
        (folder / MANIFEST).write_text(json.dumps(manifest))

    return craft


_PATHS = (
    "../../x.tar",
    "/etc/passwd",
    "train/../../x.tar",
    "a\0b",
    "",
    ".",
    "http://127.0.0.1:1/x",
    "~/x",
    7,
)
MANIFESTS: list[Craft] = [
    *json_files(MANIFEST),
    *(_manifest(lambda m, p=path: m["shards"][0].update(path=p)) for path in _PATHS),
    *(
        _manifest(lambda m, v=v: m["shards"][0].update(pairs=v))
        for v in (-1, 10**30, "2", None, 1.5)
    ),
    _manifest(lambda m: m["shards"].append(m["shards"][0])),
    _manifest(lambda m: m["shards"].clear()),
    *(_manifest(lambda m, v=v: m["shards"].append(v)) for v in (None, [], {}, 1)),
    *(_manifest(lambda m, v=v: m.update(recipe=v)) for v in (None, [], {}, {"render": None})),
    *(_manifest(lambda m, v=v: m.update(map=v)) for v in ("../../x", None, ["blocks"], "<script>")),
]


def _index(change: Callable[[list[dict]], object]) -> Craft:
    """The rows of the index, changed; the columns keep their types."""

    def craft(folder: Path) -> None:
        table = pq.read_table(folder / INDEX)
        rows = table.to_pylist()
        change(rows)
        pq.write_table(pa.Table.from_pylist(rows, table.schema), folder / INDEX)

    return craft


def _column(name: str, values) -> Craft:
    """A column of the index with other values, or without it."""

    def craft(folder: Path) -> None:
        table = pq.read_table(folder / INDEX)
        place = table.schema.get_field_index(name)
        if values is None:
            table = table.remove_column(place)
        else:
            table = table.set_column(place, name, pa.array(values(len(table))))
        pq.write_table(table, folder / INDEX)

    return craft


_OFFSETS = (-1, 2**62, -(2**63), 2**63 - 1, 0, None)
INDEXES: list[Craft] = [
    *(_index(lambda rows, v=v: rows[0].update(shard=v)) for v in (*_PATHS[:-1], None)),
    *(
        _index(lambda rows, v=v: rows[0].update(key=v))
        for v in ("../../../x", "/tmp/x", "a/b", "a\0b", "", None)
    ),
    *(_index(lambda rows, v=v: rows[0].update(rgb_size=v)) for v in _OFFSETS),
    *(_index(lambda rows, v=v: rows[0].update(depth_offset=v)) for v in _OFFSETS),
    *(_index(lambda rows, v=v: rows[0].update(scene_index=v)) for v in _OFFSETS),
    *(
        _index(lambda rows, v=v: rows[0].update(altitude_m=v))
        for v in (None, float("nan"), float("inf"))
    ),
    *(
        _index(lambda rows, v=v: rows[0].update(world_from_cam=v))
        for v in (None, [], [1.0], [None] * 16)
    ),
    _index(lambda rows: rows.clear()),
    _index(lambda rows: rows.append(rows[0])),
    *(
        _column(name, values)
        for name in (
            "key",
            "shard",
            "rgb_offset",
            "depth_size",
            "scene_index",
            "split",
            "condition",
            "world_from_cam",
            "altitude_m",
            "frame_index",
        )
        for values in (
            None,
            lambda n: ["x"] * n,
            lambda n: [1.5] * n,
            lambda n: [[1]] * n,
            lambda n: [True] * n,
            lambda n: [{"a": 1}] * n,
            lambda n: [None] * n,
            lambda n: [b"\xff"] * n,
        )
    ),
    replace(INDEX, lambda _: b"PAR1PAR1"),
]


DATASETS: dict[str, list[Craft]] = {
    "shard": SHARD,
    "member": MEMBER,
    "meta": json_files("members/*/*/*.json"),
    "manifest": MANIFESTS,
    "index": INDEXES,
}
