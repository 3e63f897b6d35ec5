"""Run times: what is measured, beside what, and what is told where a way does not work."""

import json
import time
from dataclasses import asdict

import numpy as np
import pytest

from synthdepth.errors import SynthdepthError
from synthdepth.evaluate import bench as bench_module
from synthdepth.evaluate import runtimes
from synthdepth.evaluate.published import TABLE_5_S
from synthdepth.evaluate.runtimes import WAYS, _median_s

torch = pytest.importorskip("torch")
bench = bench_module.bench


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    """A small network that is given five channels."""
    from synthdepth.pix2pix.checkpoint import save_model
    from synthdepth.pix2pix.config import TrainConfig
    from synthdepth.pix2pix.generator import UNetGenerator

    table = {"input": {"kind": "channels"}, "generator": {"ngf": 4, "depth": 4}, "size": [48, 32]}
    config = TrainConfig.from_table(table, "test")
    path = tmp_path_factory.mktemp("model") / "best.safetensors"
    save_model(path, UNetGenerator(config.generator), {"config": config.as_table()})
    return path


@pytest.fixture
def here(monkeypatch):
    """No processes: what they do is done in this one."""
    threads = torch.get_num_threads()
    monkeypatch.setattr(runtimes, "_alone", lambda work, *given: work(*given))
    yield
    torch.set_num_threads(threads)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of onnxruntime's quantisation
def test_every_way_works_and_times_flow_as_well(model, here):
    pytest.importorskip("onnxruntime")
    pytest.importorskip("onnx")
    done = []
    report = bench(model, runs=2, threads=1, on_progress=lambda *now: done.append(now))
    assert [(t.runtime, t.precision) for t in report.timings] == list(WAYS)
    assert done[-1] == (len(WAYS), len(WAYS))
    assert (report.width, report.height, report.threads) == (48, 32, 1)
    for timing in report.timings:
        assert not timing.note
        assert min(timing.without_flow_s, timing.with_flow_s, timing.flow_s) > 0
        assert timing.peak_bytes > 1e7
    from synthdepth.pix2pix.checkpoint import load_generator

    generator, _ = load_generator(model)
    assert report.parameters == sum(weights.numel() for weights in generator.parameters())
    assert report.published_s == TABLE_5_S
    assert json.loads(json.dumps(asdict(report)))["timings"][0]["precision"] == "fp32"
    text = str(report)
    assert all(f"{runtime} {precision}" in text for runtime, precision in WAYS)
    assert "the paper, NVIDIA Jetson Xavier NX        193 ms" in text


def test_a_process_of_its_own(model, monkeypatch):
    monkeypatch.setattr(bench_module, "WAYS", WAYS[:1])
    (timing,) = bench(model, runs=1, threads=1).timings
    assert not timing.note and timing.without_flow_s > 0


def test_a_way_that_does_not_work_is_a_line(model, here, monkeypatch):
    def broken(*_):
        raise RuntimeError("no such instruction\nand a long trace")

    monkeypatch.setattr(runtimes, "_onnx_files", broken)
    report = bench(model, runs=1, threads=1)
    assert [bool(t.note) for t in report.timings] == [runtime != "PyTorch" for runtime, _ in WAYS]
    assert "ONNX Runtime fp32: does not work here: no such instruction" in str(report).splitlines()


def test_medians_leave_out_what_is_slow_once():
    waits = iter([0.05] * 3 + [0.0, 0.2, 0.0])
    assert _median_s(3, lambda: time.sleep(next(waits))) < 0.05


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"runs": 0}, "runs 0: allowed is a whole number from 1"),
        ({"threads": 0}, "threads 0: allowed is a whole number from 1"),
        ({"model": "no/such"}, "no/such: there is no such file"),
        ({"flow": "tea leaves"}, "flow 'tea leaves': allowed are farneback"),
        ({"size": "big"}, "size 'big': allowed is WIDTHxHEIGHT"),
        ({"device": "tpu"}, "device 'tpu': allowed are cpu"),
    ],
)
def test_mistakes_are_told_in_one_line(model, given, told):
    with pytest.raises(SynthdepthError, match=told) as raised:
        bench(**{"model": model} | given)
    assert "\n" not in str(raised.value)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of torch's own modules
def test_compiled_it_predicts_the_same(model):
    from synthdepth.pix2pix.predict import Predictor

    plain, compiled = (Predictor(model, device="cpu", compiled=how) for how in (False, True))
    pair = runtimes._pair(48, 32)
    np.testing.assert_allclose(compiled.depth_m([pair]), plain.depth_m([pair]), rtol=1e-4)


def test_compiling_needs_a_compiler(model, monkeypatch):
    from synthdepth.pix2pix.predict import Predictor

    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(SynthdepthError, match=r"a C\+\+ compiler: there is no no-such-compiler"):
        Predictor(model, device="cpu", compiled=True)
