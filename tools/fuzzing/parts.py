"""Pieces of inputs made by hand: lying headers, bombs, pickles, JSON that is nested too deep."""

import pickle
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

from fuzzing.mutations import png_file

Craft = Callable[[Path], None]

DEEP = 100_000
# Sides of pictures that nobody has.
ABSURD = (
    (100_000, 100_000),
    (16_385, 1),
    (1, 2**31 - 1),
    (2**20, 2**20),
    (0, 0),
    (40_000, 20_000),
)
WINDOWS = (
    (0, 0, 99_999, 99_999),
    (0, 0, 2**31 - 1, 0),
    (-(2**31), -(2**31), 2**31 - 1, 2**31 - 1),
    (5, 5, 0, 0),
    (2**30, 2**30, 2**30 + 63, 2**30 + 47),
    (0, 0, 16_383, 16_383),
    (0, 0, 0, 2**27),
)


class Payload:
    """Pickled, it creates a file where it is unpickled."""

    def __reduce__(self):
        return (open, ("../unpickled", "w"))


def pickled(thing) -> bytes:
    return pickle.dumps(thing)


def replace(pattern: str, data: Callable[[bytes], bytes]) -> Craft:
    """Another content for the first file of a pattern."""

    def craft(folder: Path) -> None:
        path = first(folder, pattern)
        path.write_bytes(data(path.read_bytes()))

    return craft


def first(folder: Path, pattern: str) -> Path:
    return min(folder.glob(pattern))


def absurd_png(width: int, height: int) -> bytes:
    """A PNG file of a few bytes that says to be of this size."""
    header = struct.pack(">IIBBBBB", width & 0xFFFFFFFF, height & 0xFFFFFFFF, 8, 2, 0, 0, 0)
    return png_file([(b"IHDR", header), (b"IDAT", zlib.compress(b"\0" * 1000)), (b"IEND", b"")])


def png_bomb(width: int, height: int, depth: int = 8, colour: int = 2) -> bytes:
    """A whole PNG file of zeros, a thousandth of what it unpacks to."""
    row = 1 + width * {0: 1, 2: 3, 6: 4}[colour] * depth // 8
    packer = zlib.compressobj(9)
    rows = b"".join(packer.compress(b"\0" * row) for _ in range(height)) + packer.flush()
    header = struct.pack(">IIBBBBB", width, height, depth, colour, 0, 0, 0)
    return png_file([(b"IHDR", header), (b"IDAT", rows), (b"IEND", b"")])


def text_bomb(data: bytes) -> bytes:
    """A PNG file with a compressed text that unpacks to 1 GB."""
    packer = zlib.compressobj(9)
    text = b"".join(packer.compress(b"\0" * 2**20) for _ in range(1024)) + packer.flush()
    size = int.from_bytes(data[8:12], "big")
    header, rest = data[16 : 16 + size], data[8 + 12 + size :]
    return png_file([(b"IHDR", header), (b"zTXt", b"x\0\0" + text)]) + rest


def exr_window(window: tuple[int, ...], names: tuple[bytes, ...]) -> Callable[[bytes], bytes]:
    """An EXR file that says to have other windows."""

    def change(data: bytes) -> bytes:
        data = bytearray(data)
        for name in names:
            at = data.find(name + b"\0box2i\0")
            start = at + len(name) + 7 + 4
            data[start : start + 16] = struct.pack("<4i", *window)
        return bytes(data)

    return change


BOTH = (b"dataWindow", b"displayWindow")


def deep_json(_: bytes = b"") -> bytes:
    return b'{"a": ' * DEEP + b"1" + b"}" * DEEP


def deep_list(_: bytes = b"") -> bytes:
    return b"[" * DEEP + b"]" * DEEP


def _deep_within(data: bytes) -> bytes:
    """The first value of a table is nested too deep."""
    head, _, rest = data.partition(b":")
    return head + b": " + deep_list() + b"," + b'"x":' + rest


_NO_TABLES = (b"", b"null", b"[]", b"1", b'"x"', b"{}", b"\xff\xfe{\0}\0", b"\0", b"\xef\xbb\xbf{}")


def json_files(pattern: str) -> list[Craft]:
    """JSON that is nested too deep, is no table, or holds what is no number."""
    return [
        *(replace(pattern, deep) for deep in (deep_json, deep_list, _deep_within)),
        *(replace(pattern, lambda _, d=data: d) for data in _NO_TABLES),
    ]


def toml_files(pattern: str) -> list[Craft]:
    """TOML that is nested too deep, or is none."""
    texts = (
        b"a = " + b"[" * DEEP + b"]" * DEEP,
        b"a = " + b"{b = " * DEEP + b"1" + b"}" * DEEP,
        b"a." * DEEP + b"b = 1",
        b"[" + b"a." * DEEP + b"b]",
        b"map = []",
        b"map = {}",
        b"[light]\nconditions = [[]]",
        b"[light]\nconditions = [{}]",
        b"light = 1",
        b"flight = []",
        b'map = "blocks"\nsensor = {model = []}',
        b'map = "blocks"\nsensor = {model = {}}',
        b"a = " + b"9" * 5000,
        b"\xff",
        b"\0",
    )
    return [replace(pattern, lambda _, t=text: t) for text in texts]
