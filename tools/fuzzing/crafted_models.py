"""Trainings, predictions and pictures made by hand."""

import io
import json
import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch

from fuzzing.parts import (
    ABSURD,
    BOTH,
    WINDOWS,
    Craft,
    Payload,
    absurd_png,
    deep_json,
    deep_list,
    exr_window,
    json_files,
    pickled,
    png_bomb,
    replace,
    text_bomb,
    toml_files,
)
from synthdepth.pix2pix.checkpoint import LAST

# Trainings, predictions, pictures.


def _header(change: Callable[[dict], object]) -> Craft:
    """A checkpoint's header, changed."""

    def craft(folder: Path) -> None:
        data = (folder / LAST).read_bytes()
        size = int.from_bytes(data[:8], "little")
        header = json.loads(data[8 : 8 + size])
        change(header)
        text = json.dumps(header).encode()
        (folder / LAST).write_bytes(len(text).to_bytes(8, "little") + text + data[8 + size :])

    return craft


def _facts(change: Callable[[dict], object]) -> Craft:
    def craft(header: dict) -> None:
        facts = json.loads(header["__metadata__"]["synthdepth"])
        change(facts)
        header["__metadata__"]["synthdepth"] = json.dumps(facts)

    return _header(craft)


def _pickled(_: bytes) -> bytes:
    file = io.BytesIO()
    torch.save({"model.model.0.weight": Payload()}, file)
    return file.getvalue()


CHECKPOINTS: list[Craft] = [
    *(
        _header(lambda h, d=data: h["__metadata__"].update(synthdepth=d))
        for data in (
            "",
            "null",
            "[]",
            "{}",
            deep_json().decode(),
            '{"format": 1}',
            '{"format": []}',
        )
    ),
    *(
        _facts(lambda f, v=v: f.update(progress=v))
        for v in (None, [], {}, {"x": 1}, {"step": "x"}, {"step": -1})
    ),
    *(
        _facts(lambda f, v=v: f["config"]["generator"].update(v))
        for v in ({"ngf": 512, "depth": 10}, {"depth": 3})
    ),
    *(_facts(lambda f, v=v: f.update(config=v)) for v in (None, [], {}, {"size": [8192, 8192]})),
    *(
        replace(LAST, lambda d, s=size: s.to_bytes(8, "little") + d[8:])
        for size in (0, 2**63, 2**40, 10**8)
    ),
    replace(LAST, _pickled),
    replace(LAST, lambda _: pickled(Payload())),
]


def _npy(array: np.ndarray) -> bytes:
    file = io.BytesIO()
    np.save(file, array, allow_pickle=True)
    return file.getvalue()


def _npz(_: bytes) -> bytes:
    file = io.BytesIO()
    np.savez(file, a=np.ones((4, 4)))
    return file.getvalue()


def _npy_header(text: str) -> bytes:
    text = text.ljust(118) + "\n"
    return b"\x93NUMPY\x01\0" + struct.pack("<H", len(text)) + text.encode() + b"\0" * 64


_HEADERS = (
    "{'descr': '<f4', 'fortran_order': False, 'shape': (100000, 100000), }",
    "{'descr': '<f4', 'fortran_order': False, 'shape': (10000000000000000000000, 2), }",
    "{'descr': '<f4', 'fortran_order': False, 'shape': (-1, 4), }",
    "{'descr': '<f4', 'fortran_order': False, 'shape': (0, 0), }",
    "{'descr': '|O', 'fortran_order': False, 'shape': (4, 4), }",
    "{'descr': '<f4,<f4', 'fortran_order': False, 'shape': (4, 4), }",
    "{'descr': '<c8', 'fortran_order': False, 'shape': (2, 2), }",
    "{'descr': '<M8[s]', 'fortran_order': False, 'shape': (2, 2), }",
    "[" * 5000,
    "(" * 9000,
    "{'descr': []}",
    "None",
    "x" * 100,
)
PREDICTIONS: list[Craft] = [
    replace("npy/*", lambda _: _npy(np.array([[Payload()]], dtype=object))),
    replace("npy/*", lambda _: pickled(Payload())),
    replace("npy/*", _npz),
    *(replace("npy/*", lambda _, h=header: _npy_header(h)) for header in _HEADERS),
    *(
        replace("npy/*", lambda _, s=shape: _npy(np.full(s, np.nan)))
        for shape in ((), (3,), (2, 2, 2), (1, 1))
    ),
    *(replace("png/*", lambda _, s=size: absurd_png(*s)) for size in ABSURD),
    replace("png/*", lambda _: png_bomb(16_384, 8192, 16, 0)),
    *(replace("exr/*", exr_window(w, BOTH)) for w in WINDOWS),
]


def _bmp(width: int, height: int) -> bytes:
    info = struct.pack("<IiiHHIIiiII", 40, width, height, 1, 24, 0, 0, 1, 1, 0, 0)
    return b"BM" + struct.pack("<IHHI", 54, 0, 0, 54) + info


def _tiff(width: int, height: int) -> bytes:
    """An uncompressed RGB TIFF file without its pixels."""
    tags = [
        (256, 4, width),
        (257, 4, height),
        (258, 3, 8),
        (259, 3, 1),
        (262, 3, 1),
        (273, 4, 8),
        (277, 3, 1),
        (278, 4, height),
        (279, 4, 100),
    ]
    body = b"".join(struct.pack("<HHII", tag, kind, 1, value) for tag, kind, value in tags)
    return b"II*\0" + struct.pack("<IH", 8, len(tags)) + body + b"\0" * 4


def _jpeg(data: bytes, width: int, height: int) -> bytes:
    at = data.find(b"\xff\xc0")
    return data[: at + 5] + struct.pack(">HH", height, width) + data[at + 9 :]


PICTURES: list[Craft] = [
    *(replace("folder/*.png", lambda _, s=size: absurd_png(*s)) for size in ABSURD),
    replace("folder/*.png", lambda _: png_bomb(16_384, 16_384, colour=0)),
    replace("folder/*.png", lambda _: png_bomb(16_384, 1)),
    replace("folder/*.png", text_bomb),
    *(
        replace("folder/*.bmp", lambda _, s=size: _bmp(*s))
        for size in (
            (100_000, 100_000),
            (-1, -1),
            (2**31 - 1, 1),
            (40_000, 10_000),
            (20_000, -20_000),
        )
    ),
    *(
        replace("folder/*.tif", lambda _, s=size: _tiff(*s))
        for size in ((100_000, 100_000), (0, 0), (2**31, 1), (30_000, 30_000))
    ),
    *(
        replace("folder/*.jpg", lambda d, s=size: _jpeg(d, *s))
        for size in ((65_535, 65_535), (0, 0))
    ),
    replace("folder/*.jpg", lambda _: b""),
    lambda folder: (folder / "folder/9.png").symlink_to("/etc/passwd"),
    lambda folder: (folder / "folder/9.png").mkdir(),
    lambda folder: (folder / f"folder/{'9' * 200}.png").write_bytes(
        (folder / "folder/0.png").read_bytes()
    ),
    replace("video.avi", lambda _: b""),
    replace("video.avi", lambda d: d[:64] + b"\xff" * 1000),
]


def _onnx(change: Callable) -> Craft:
    """A model's parts, changed."""

    def craft(folder: Path) -> None:
        import onnx

        model = onnx.load(folder / "model.onnx")
        change(model)
        (folder / "model.onnx").write_bytes(model.SerializeToString())

    return craft


def _fact(name: str, text: str) -> Craft:
    def change(model) -> None:
        for prop in model.metadata_props:
            if prop.key == name:
                prop.value = text

    return _onnx(change)


def _external(where: str) -> Craft:
    """A weight that says to lie in another file."""

    def change(model) -> None:
        weight = model.graph.initializer[0]
        weight.ClearField("raw_data")
        weight.data_location = 1
        weight.external_data.add(key="location", value=where)

    return _onnx(change)


ONNX: list[Craft] = [
    *(
        _fact("size", text)
        for text in (
            "",
            "null",
            "[]",
            "[1]",
            "[0, 0]",
            "[-1, 5]",
            '["a", "b"]',
            "[1e9, 1e9]",
            "[100000, 100000]",
            "[1.5, 2]",
            "{}",
            deep_list().decode(),
            "[64, 48, 1]",
            "[NaN, 1]",
            "[true, true]",
            "[16, 16]",
        )
    ),
    *(
        _fact("input", text)
        for text in (
            "",
            "null",
            "[]",
            "{}",
            '{"kind": []}',
            '{"kind": {}}',
            deep_list().decode(),
            '{"kind": "channels"}',
            '{"kind": "rgb", "interval": 1e999}',
        )
    ),
    *map(_external, ("/etc/passwd", "../../../../../../etc/passwd", "x", "")),
    _onnx(lambda m: m.graph.ClearField("input")),
    _onnx(lambda m: m.graph.ClearField("output")),
    _onnx(lambda m: m.graph.output.reverse() or m.graph.output.add().CopyFrom(m.graph.input[0])),
    _onnx(lambda m: m.ClearField("opset_import")),
    _onnx(lambda m: setattr(m.opset_import[0], "version", 10_000)),
]


LEARNING: dict[str, list[Craft]] = {
    "checkpoint": CHECKPOINTS,
    "train_config": [*json_files("config.json"), *toml_files("config.toml")],
    "onnx": ONNX,
    "predictions": PREDICTIONS,
    "pictures": PICTURES,
}
