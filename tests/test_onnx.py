"""ONNX: another runtime gives the same depth, at any batch, and the file says how to feed it."""

import json

import numpy as np
import onnx
import onnxruntime
import pytest
import torch

from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.checkpoint import load_generator, save_model
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.generator import GeneratorConfig
from synthdepth.pix2pix.inputs import InputConfig
from synthdepth.pix2pix.onnx import export_onnx
from synthdepth.pix2pix.state import State
from synthdepth.pix2pix.target import DepthCoding


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    """Threads of tiny work only wait."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def write_model(path, **values):
    config = TrainConfig(**values)
    state = State(config, torch.device("cpu"))
    # Running statistics other than the first, as a trained network has them.
    state.generator(torch.rand(2, config.input.channels, 48, 80))
    save_model(path, state.generator, {"config": config.as_table()})
    return config


@pytest.mark.parametrize("coding", ["linear", "log"])
@pytest.mark.parametrize("norm", ["batch", "instance", "group"])
def test_another_runtime_gives_the_same_depth(tmp_path, norm, coding):
    upsample = "resize" if norm == "group" else "transposed"
    config = write_model(
        tmp_path / "model.safetensors",
        input=InputConfig(kind="channels"),
        generator=GeneratorConfig(ngf=8, depth=4, norm=norm, upsample=upsample),
        coding=DepthCoding(kind=coding),
        size=(72, 40),  # neither side fits the network: both are padded
    )
    out = tmp_path / "model.onnx"
    assert export_onnx(tmp_path / "model.safetensors", out) == out.stat().st_size
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    session = onnxruntime.InferenceSession(out, options, providers=["CPUExecutionProvider"])
    generator, _ = load_generator(tmp_path / "model.safetensors")
    for batch in (1, 3):
        image = 2 * torch.rand(batch, 5, 40, 72) - 1
        (found,) = session.run(["depth_m"], {"input": image.numpy()})
        expected = config.coding.decode(generator(image)).numpy()
        assert found.shape == (batch, 1, 40, 72) and found.dtype == np.float32
        np.testing.assert_allclose(found / 200, expected / 200, rtol=0, atol=1e-4)
        assert expected.std() > 0


def test_the_file_says_how_to_feed_it(tmp_path):
    config = write_model(
        tmp_path / "model.safetensors",
        input=InputConfig(kind="embed", interval=3),
        generator=GeneratorConfig(ngf=4, depth=4),
    )
    export_onnx(tmp_path / "model.safetensors", tmp_path / "model.onnx", size=(64, 48))
    model = onnx.load(tmp_path / "model.onnx")
    facts = {prop.key: json.loads(prop.value) for prop in model.metadata_props}
    assert InputConfig(**facts["input"]) == config.input
    assert DepthCoding(**facts["coding"]) == config.coding
    assert facts["size"] == [64, 48]
    (given,) = model.graph.input
    sides = [side.dim_param or side.dim_value for side in given.type.tensor_type.shape.dim]
    assert sides == ["batch", 3, 48, 64]
    assert "Dropout" not in {node.op_type for node in model.graph.node}


def test_bad_names_are_refused(tmp_path):
    with pytest.raises(SynthdepthError, match=r"allowed is a file name that ends in .onnx"):
        export_onnx(tmp_path / "model.safetensors", tmp_path / "model.pb")
    with pytest.raises(SynthdepthError, match="there is no such file"):
        export_onnx(tmp_path / "model.safetensors", tmp_path / "model.onnx")
    write_model(tmp_path / "model.safetensors", generator=GeneratorConfig(ngf=4, depth=4))
    with pytest.raises(SynthdepthError, match=r"cannot write .*nowhere"):
        export_onnx(tmp_path / "model.safetensors", tmp_path / "nowhere" / "model.onnx")
