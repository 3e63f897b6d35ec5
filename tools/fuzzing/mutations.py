"""Ways to break a file: bytes, numbers in text, leaves of JSON and TOML, chunks with right sums.

All are functions (rng, data, others) -> data; `others` are files to splice pieces from.
"""

import json
import random
import re
import struct
import tomllib
import zlib
from collections.abc import Callable, Sequence
from pathlib import Path

Mutation = Callable[[random.Random, bytes, Sequence[bytes]], bytes]

WORDS = (0, 1, 0x7F, 0xFFFF, 0x10000, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF)
NUMBERS = (
    "0",
    "-0",
    "-1",
    "1e999",
    "-1e999",
    "nan",
    "inf",
    "NaN",
    "Infinity",
    "1e308",
    "1e-320",
    "0.5",
    "2147483648",
    "9223372036854775808",
    str(10**30),
    "9" * 5000,
    "1e5",
    "100000",
    "true",
    "",
)
LEAVES = (
    None,
    [],
    {},
    "",
    "x",
    0,
    -1,
    1,
    0.5,
    True,
    10**30,
    1e308,
    float("nan"),
    float("inf"),
    [[]],
    [None],
    {"a": {}},
    [1, [2, [3]]],
    "../../x",
    "/etc/x",
    "a\0b",
    "\ud800",
    "\n",
    "é" * 3000,
    [0] * 5000,
    1e-320,
    -(2**63) - 1,
    ["x", 1],
    "nan",
    {"": None},
)


# Bytes.


def flip_bits(rng: random.Random, data: bytes, _) -> bytes:
    """One to four bits."""
    data = bytearray(data or b"\0")
    for _ in range(rng.randint(1, 4)):
        data[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
    return bytes(data)


def set_bytes(rng: random.Random, data: bytes, _) -> bytes:
    """A run of bytes of one value, or of random ones."""
    start, count = rng.randrange(len(data) + 1), rng.choice([1, 1, 2, 4, 16, 200])
    value = rng.choice([b"\0", b"\xff", b" ", b"\n", rng.randbytes(1)]) * count
    return (
        data[:start]
        + (value if rng.random() < 0.7 else rng.randbytes(count))
        + data[start + rng.choice([0, count]) :]
    )


def set_word(rng: random.Random, data: bytes, _) -> bytes:
    """An aligned number of two, four or eight bytes becomes an extreme one."""
    size = rng.choice([2, 4, 4, 4, 8])
    # Headers come first: half of all hits go there.
    end = min(len(data), 512) if rng.random() < 0.5 else len(data)
    start = rng.randrange(max(end // size, 1)) * size
    value = (rng.choice(WORDS) if rng.random() < 0.8 else rng.getrandbits(8 * size)) % 256**size
    return data[:start] + value.to_bytes(size, rng.choice(["little", "big"])) + data[start + size :]


def cut_off(rng: random.Random, data: bytes, _) -> bytes:
    """The file ends early, or at once."""
    return data[: rng.choice([0, 1, rng.randrange(len(data) + 1), max(len(data) - 1, 0)])]


def move_chunk(rng: random.Random, data: bytes, others: Sequence[bytes]) -> bytes:
    """A piece is removed, doubled, swapped with another, or comes from another file."""
    size = rng.choice([1, 4, 64, 512, 4096])
    a, b = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    piece = data[a : a + size]
    other = rng.choice(others) if others else data
    c = rng.randrange(len(other) + 1)
    return rng.choice(
        [
            lambda: data[:a] + data[a + size :],
            lambda: data[:a] + piece + data[a:],
            lambda: data[:a] + data[b : b + size] + data[a + size : b] + piece + data[b + size :],
            lambda: data[:a] + other[c : c + size] + data[a + size :],
            lambda: data[:a] + other[c:],
            lambda: data + other,
        ]
    )()


def set_number(rng: random.Random, data: bytes, _) -> bytes:
    """A number written out becomes another."""
    found = list(re.finditer(rb"[-+]?\d+(\.\d+)?([eE][-+]?\d+)?", data))
    if not found:
        return set_bytes(rng, data, ())
    at = rng.choice(found)
    return data[: at.start()] + rng.choice(NUMBERS).encode() + data[at.end() :]


def move_line(rng: random.Random, data: bytes, others: Sequence[bytes]) -> bytes:
    """A line is removed, doubled, moved, or comes from another file."""
    lines = data.splitlines(keepends=True) or [b""]
    foreign = (rng.choice(others) if others else data).splitlines(keepends=True) or [b""]
    at = rng.randrange(len(lines))
    line = rng.choice(
        [lines.pop(at), lines[at % len(lines)] if lines else b"", rng.choice(foreign)]
    )
    for _ in range(rng.choice([0, 1, 2])):
        lines.insert(rng.randrange(len(lines) + 1), line)
    return b"".join(lines)


BYTES: tuple[Mutation, ...] = (flip_bits, set_bytes, set_word, set_word, cut_off, move_chunk)
TEXT: tuple[Mutation, ...] = (set_number, set_number, move_line, flip_bits, set_bytes, cut_off)


# Trees.


def change_tree(rng: random.Random, root):
    """JSON's or TOML's values with a leaf, a branch or a key replaced, added or removed."""
    places = list(_places(root))
    if not places:
        return rng.choice(LEAVES)
    parent, key = rng.choice(places)
    change = rng.random()
    if change < 0.12:
        del parent[key]
    elif change < 0.2:
        if isinstance(parent, dict):
            parent[rng.choice(["x", "", "../x", "é" * 300, str(key) + "_"])] = rng.choice(LEAVES)
        else:
            parent.insert(key, rng.choice(LEAVES))
    elif change < 0.3:
        parent[key] = _deeper(parent[key], rng.choice([1, 3, 60]))
    elif change < 0.4:
        other, name = rng.choice(places)
        parent[key] = json.loads(json.dumps(other[name])) if name in _names(other) else None
    else:
        parent[key] = rng.choice(LEAVES)
    return root


def _places(value):
    """(parent, key) of all that is in a tree."""
    for key in _names(value):
        yield value, key
        yield from _places(value[key])


def _names(value) -> list:
    if isinstance(value, dict):
        return list(value)
    return list(range(len(value))) if isinstance(value, list) else []


def _deeper(value, times: int):
    for _ in range(times):
        value = [value]
    return value


def change_json(rng: random.Random, data: bytes, others: Sequence[bytes]) -> bytes:
    """The tree of a JSON file changed."""
    try:
        root = json.loads(data)
    except ValueError:
        return set_number(rng, data, others)
    return json.dumps(change_tree(rng, root)).encode()


def change_toml(rng: random.Random, data: bytes, others: Sequence[bytes]) -> bytes:
    """The tree of a TOML file changed."""
    try:
        root = change_tree(rng, tomllib.loads(data.decode()))
    except ValueError:
        return set_number(rng, data, others)
    if not isinstance(root, dict):
        return json.dumps(root).encode()
    return toml_file(root)


def toml_file(root: dict) -> bytes:
    """A table as a TOML file, each of its keys on one line."""
    text = "".join(f"{json.dumps(k)} = {_toml(v)}\n" for k, v in root.items())
    return text.encode(errors="surrogatepass")


def _toml(value) -> str:
    """A value on one line."""
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)} = {_toml(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_toml, value)) + "]"
    if isinstance(value, float):
        return repr(value).replace("1e", "1.0e")
    return "null" if value is None else json.dumps(value, ensure_ascii=False)


# Formats that would refuse anything whose sums are wrong.


def change_tar_header(rng: random.Random, data: bytes, _) -> bytes:
    """A field of a member's header, with the right checksum."""
    headers = [at for at in range(0, len(data), 512) if data[at + 257 : at + 262] == b"ustar"]
    if not headers:
        return data
    at = rng.choice(headers)
    header = bytearray(data[at : at + 512])
    start, size, values = rng.choice(
        [
            (
                0,
                100,
                [
                    b"../../x.rgb.png",
                    b"/etc/x.rgb.png",
                    b"a/b.rgb.png",
                    b"",
                    b"\xff" * 100,
                    b"x",
                    b".",
                    b"..",
                    b"a\nb.rgb.png",
                    header[:99].strip(b"\0")[:-3],
                ],
            ),
            (
                124,
                12,
                [
                    b"00000000000\0",
                    b"77777777777\0",
                    b"-1\0",
                    b"zzz\0",
                    b"\x80" + b"\xff" * 11,
                    b"\xff" * 12,
                    b"\x80" + b"\0" * 6 + b"\xff" * 5,
                    b"00000000400\0",
                ],
            ),
            (
                156,
                1,
                [
                    b"0",
                    b"1",
                    b"2",
                    b"3",
                    b"4",
                    b"5",
                    b"6",
                    b"7",
                    b"L",
                    b"K",
                    b"x",
                    b"g",
                    b"S",
                    b"\xff",
                ],
            ),
            (157, 100, [b"/etc/passwd", b"../../x", b""]),
            (345, 155, [b"../..", b"/", b"a" * 155]),
        ]
    )
    value = bytes(rng.choice(values))[:size]
    header[start : start + size] = value.ljust(size, b"\0")
    header[148:156] = b" " * 8
    header[148:156] = b"%06o\0 " % sum(header)
    return data[:at] + bytes(header) + data[at + 512 :]


def change_png_chunk(rng: random.Random, data: bytes, others: Sequence[bytes]) -> bytes:
    """A chunk's content, with the right checksum; often the header's."""
    chunks = _png_chunks(data)
    if not chunks:
        return set_word(rng, data, others)
    k = 0 if rng.random() < 0.5 else rng.randrange(len(chunks))
    kind, content = chunks[k]
    if kind == b"IHDR" and rng.random() < 0.8:
        width, height, *rest = struct.unpack(">IIBBBBB", content[:13].ljust(13, b"\0"))
        sides = (width, 0, 1, 7, 16385, 100_000, 2**20, 2**31 - 1, 2**32 - 1)
        rest = [rng.choice([v, v, v, rng.randrange(256), 16, 3, 6, 0]) for v in rest]
        content = struct.pack(">IIBBBBB", rng.choice(sides), rng.choice([height, *sides]), *rest)
    else:
        content = rng.choice(BYTES)(rng, content, others)
    chunks[k] = (rng.choice([kind, kind, kind, b"IDAT", b"PLTE", b"tRNS", b"zTXt"]), content)
    return png_file(chunks)


def _png_chunks(data: bytes) -> list[tuple[bytes, bytes]]:
    chunks, at = [], 8
    while at + 12 <= len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        chunks.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 12 + size
    return chunks


def png_file(chunks: Sequence[tuple[bytes, bytes]]) -> bytes:
    """A PNG file of some chunks (name, content)."""
    parts = [
        struct.pack(">I", len(content))
        + kind
        + content
        + struct.pack(">I", zlib.crc32(kind + content))
        for kind, content in chunks
    ]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def change_safetensors(rng: random.Random, data: bytes, others: Sequence[bytes]) -> bytes:
    """The header's JSON, or the JSON within its metadata, with the right length."""
    size = int.from_bytes(data[:8], "little")
    try:
        header = json.loads(data[8 : 8 + size])
        facts = header["__metadata__"]["synthdepth"]
        if rng.random() < 0.6:
            changed = change_json(rng, facts.encode(), others)
            header["__metadata__"]["synthdepth"] = changed.decode(errors="replace")
        else:
            header = change_tree(rng, header)
    except (ValueError, KeyError, TypeError):
        return set_word(rng, data, others)
    text = json.dumps(header).encode()
    return len(text).to_bytes(8, "little") + text + data[8 + size :]


_BY_SUFFIX: dict[str, tuple[Mutation, ...]] = {
    ".json": (change_json, change_json, change_json, *TEXT),
    ".jsonl": (move_line, *TEXT),
    ".toml": (change_toml, change_toml, change_toml, *TEXT),
    ".txt": TEXT,
    ".tar": (change_tar_header, change_tar_header, *BYTES),
    ".png": (change_png_chunk, change_png_chunk, *BYTES),
    ".safetensors": (change_safetensors, change_safetensors, *BYTES),
    ".npy": (set_number, *BYTES),
    ".pfm": (set_number, *BYTES),
}


def mutated(rng: random.Random, path: Path, data: bytes, others: Sequence[bytes]) -> bytes:
    """A file with one to three things wrong, as its suffix suggests."""
    for _ in range(rng.choice([1, 1, 1, 2, 3])):
        data = rng.choice(_BY_SUFFIX.get(path.suffix, BYTES))(rng, data, others)
    return data
