"""Malformed models, predictions, KITTI files, names: refused in one line, never unpickled."""

import io
import json
import pickle
import struct
import sys

import numpy as np
import pytest
import safetensors.torch
import torch

from synthdepth.cli import main
from synthdepth.console import say
from synthdepth.dataset import PairDataset
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.evaluate.sources import open_source
from synthdepth.kitti.calibration import object_calibration, raw_calibration
from synthdepth.kitti.dataset import EXPORT_NOTE, KittiDataset
from synthdepth.kitti.layouts import existing
from synthdepth.kitti.oxts import read_oxts
from synthdepth.kitti.splits import read_split
from synthdepth.pix2pix.checkpoint import load_generator, restore_state, save_state
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.discriminator import DiscriminatorConfig
from synthdepth.pix2pix.generator import GeneratorConfig
from synthdepth.pix2pix.inputs import InputConfig
from synthdepth.pix2pix.state import State
from tests.made import make_dataset

DEEP = 100_000


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("whole") / "set", shards=2, pairs=2)


# Models and predictions.


@pytest.fixture(scope="module")
def tiny():
    return TrainConfig(
        input=InputConfig(kind="rgb"),
        generator=GeneratorConfig(ngf=1, depth=2),
        discriminator=DiscriminatorConfig(ndf=1, layers=1),
    )


def checkpoint(path, config, change=lambda facts: facts, dtype=None):
    """A training at its first step whose header or weights were changed."""
    state = State(config, torch.device("cpu"))
    save_state(path, state, {"config": config.as_table()})
    with safetensors.safe_open(path, "pt") as file:
        facts = json.loads(file.metadata()["synthdepth"])
        tensors = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    if dtype is not None:
        tensors = {name: tensor.to(dtype) for name, tensor in tensors.items()}
    text = change(facts)
    text = text if isinstance(text, str) else json.dumps(text)
    path.write_bytes(safetensors.torch.save(tensors, {"synthdepth": text}))
    return state


@pytest.mark.parametrize(
    "text",
    [
        "null",
        "[]",
        "1",
        "{",
        "[" * DEEP,
        '{"format": []}',
        '{"format": 1}',
        '{"format": 1, "config": {"generator": []}}',
    ],
)
def test_a_model_says_what_it_is(tmp_path, tiny, text):
    checkpoint(tmp_path / "x.safetensors", tiny, lambda facts: text)
    with pytest.raises(SynthdepthError, match="x.safetensors"):
        load_generator(tmp_path / "x.safetensors")


def test_weights_are_of_their_type(tmp_path, tiny):
    checkpoint(tmp_path / "x.safetensors", tiny, dtype=torch.int64)
    with pytest.raises(SynthdepthError, match="of int64, allowed is shape"):
        load_generator(tmp_path / "x.safetensors")


@pytest.mark.parametrize("progress", [None, [], 0, {"step": "x"}, {"step": -1}, {"more": 1}])
def test_a_training_stands_somewhere(tmp_path, tiny, progress):
    path = tmp_path / "last.safetensors"

    def change(facts):
        return facts | {"progress": progress and facts["progress"] | progress}

    state = checkpoint(path, tiny, change)
    with pytest.raises(SynthdepthError, match="which no training has"):
        restore_state(path, state)


class Unpickled:
    """Leaves a file behind where it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


@pytest.mark.parametrize("kind", ["array", "pickle", "npz", "huge", "deep"])
def test_predictions_are_numbers_and_are_not_unpickled(tmp_path, folder, kind):
    trap, out = Unpickled(tmp_path / "trap"), tmp_path / "predictions"
    out.mkdir()
    sample = PairDataset(folder)[0]
    path = out / f"{sample.key}.npy"
    if kind == "array":
        np.save(path, np.array([[trap]], object), allow_pickle=True)
    elif kind == "pickle":
        path.write_bytes(pickle.dumps(trap))
    elif kind == "npz":
        with open(path, "wb") as file:
            np.savez(file, a=np.ones((2, 2)))
    else:
        shape = "(1000000, 1000000)" if kind == "huge" else "(" * 9000
        text = f"{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}".encode() + b"\n"
        path.write_bytes(b"\x93NUMPY\x01\0" + struct.pack("<H", len(text)) + text)
    with pytest.raises(SynthdepthError, match="cannot be read: it is no .npy file"):
        open_source(str(out)).depth_m([sample])
    assert not trap.path.exists()


def test_an_onnx_file_says_what_it_is_in_text(tmp_path):
    onnx = pytest.importorskip("onnx")
    pytest.importorskip("onnxruntime")
    x = onnx.helper.make_tensor_value_info("x", onnx.TensorProto.FLOAT, [1])
    y = onnx.helper.make_tensor_value_info("y", onnx.TensorProto.FLOAT, [1])
    graph = onnx.helper.make_graph([onnx.helper.make_node("Identity", ["x"], ["y"])], "g", [x], [y])
    model = onnx.helper.make_model(
        graph, ir_version=10, opset_imports=[onnx.helper.make_opsetid("", 20)]
    )
    onnx.helper.set_model_props(model, {"input": "zzzz"})
    path = tmp_path / "model.onnx"
    for data in (model.SerializeToString(), model.SerializeToString().replace(b"zzzz", b"zz\xffz")):
        path.write_bytes(data)
        with pytest.raises(SynthdepthError, match="model.onnx: allowed is an ONNX file"):
            open_source(str(path))


# KITTI.


@pytest.mark.parametrize("text", ["nan " * 30, "91 " + "0 " * 29, "inf " * 30, "1e999 " * 30])
def test_a_pose_is_somewhere(tmp_path, text):
    (tmp_path / "x.txt").write_text(text)
    with pytest.raises(DatasetError, match="x.txt"):
        read_oxts(tmp_path / "x.txt")


@pytest.mark.parametrize(
    "line", ["a_sync " + "9" * 5000 + " l", "a_sync/image_02/data/" + "9" * 5000 + ".png"]
)
def test_numbers_of_frames_are_short(tmp_path, line):
    (tmp_path / "split.txt").write_text(line)
    with pytest.raises(DatasetError, match="line 1 is"):
        read_split(tmp_path / "split.txt")


@pytest.mark.parametrize("name", ["x", "-1", "1_0", "\u0661", "9" * 200])
def test_names_of_frames_are_numbers(tmp_path, name):
    data = tmp_path / "2011_09_26/2011_09_26_drive_0001_sync/image_02/data"
    data.mkdir(parents=True)
    (data / "0000000005.png").touch()
    assert len(KittiDataset(tmp_path, layout="raw")) == 1
    (data / f"{name}.png").touch()
    with pytest.raises(DatasetError, match="allowed is a frame's number as name"):
        KittiDataset(tmp_path, layout="raw")


@pytest.mark.parametrize("value", ["[" * DEEP, "0", "-200", "1e999", "NaN", '"200"', "[200]"])
def test_depth_saturates_at_a_positive_number(tmp_path, value):
    data = tmp_path / "2011_09_26/2011_09_26_drive_0001_sync/image_02/data"
    data.mkdir(parents=True)
    (data / "0000000005.png").touch()
    for number in ("200.0", value):
        (tmp_path / EXPORT_NOTE).write_text(f'{{"max_depth_m": {number}}}')
        if number == "200.0":
            assert KittiDataset(tmp_path, layout="raw").max_depth_m == 200
    with pytest.raises(DatasetError, match=EXPORT_NOTE):
        KittiDataset(tmp_path, layout="raw")


@pytest.mark.parametrize("name", ["x" * 5000, "a\0b"])
def test_what_can_be_no_name_does_not_exist(tmp_path, name):
    assert existing(tmp_path / name) is None


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("P2", [0] * 12),
        ("P2", ["nan"] * 12),
        ("P2", ["1e999"] * 12),
        ("R0_rect", [0] * 9),
        ("Tr_velo_to_cam", [1] * 12),
    ],
)
def test_a_calibration_has_an_inverse(tmp_path, name, values):
    unit = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]
    lines = {"P2": unit, "R0_rect": [1, 0, 0, 0, 1, 0, 0, 0, 1], "Tr_velo_to_cam": unit}
    path = tmp_path / "calib.txt"
    for numbers in (lines, lines | {name: values}):
        path.write_text("".join(f"{k}: {' '.join(map(str, v))}\n" for k, v in numbers.items()))
        if numbers is lines:
            object_calibration(path)
    with pytest.raises(DatasetError, match="calib.txt"):
        object_calibration(path)


def test_the_size_of_a_picture_is_a_number(tmp_path):
    (tmp_path / "calib_cam_to_cam.txt").write_text("S_rect_02: nan 1e999\n")
    with pytest.raises(DatasetError, match="S_rect_02 needs 2 finite numbers"):
        raw_calibration(tmp_path, 2)


# The command line.


@pytest.mark.parametrize(
    "arguments",
    [
        ["verify", "x" * 5000],
        ["evaluate", "y" * 300, "--data", "z", "--out", "o"],
        ["preview", "\udcff"],
        ["scene", "--map", "a/" * 3000 + "b.toml", "--seed", "1"],
        ["predict", "m" * 300, "x", "--out", "o"],
    ],
)
def test_names_that_the_system_refuses_are_one_line(tmp_path, monkeypatch, capsys, arguments):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert told.startswith("synthdepth: ") and told.count("\n") == 1


def test_what_no_terminal_can_show_is_said_all_the_same(monkeypatch):
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, "ascii"))
    say("a\udcff×")
    assert raw.getvalue() == b"a\\udcff\\xd7\n"
