"""Choosing a variant: what works is trusted, what aborts is not, and the verdict is remembered."""

import subprocess
import sys

import pytest

from synthdepth.errors import BackendError
from synthdepth.render import backend


@pytest.fixture(autouse=True)
def private_memory(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def test_a_library_that_cannot_be_used_is_passed_over(tmp_path, monkeypatch):
    fake = tmp_path / "libLLVM.so"
    fake.write_bytes(b"not a library")
    real = backend.llvm_candidates()
    monkeypatch.setattr(backend, "llvm_candidates", lambda: [str(fake), *real])
    monkeypatch.setattr(backend, "VARIANTS", {"llvm": "llvm_ad_rgb", "scalar": "scalar_rgb"})
    assert backend.probe("llvm", str(fake)) is not None
    chosen = backend.choose("llvm")
    assert chosen.library in real


def test_without_any_library_scalar_renders_and_says_why(monkeypatch):
    monkeypatch.setattr(backend, "llvm_candidates", list)
    monkeypatch.setattr(backend, "remembered_probe", lambda name, library=None: "no driver")
    chosen = backend.choose()
    assert chosen.name == "scalar"
    assert "no libLLVM found" in chosen.reason
    with pytest.raises(BackendError, match="pip install karellen-llvm-core"):
        backend.choose("llvm")
    with pytest.raises(BackendError, match="--variant cuda cannot run"):
        backend.choose("cuda")
    with pytest.raises(BackendError, match="allowed are cuda, llvm, scalar"):
        backend.choose("metal")


def test_a_verdict_is_asked_for_once(monkeypatch):
    asked = []
    monkeypatch.setattr(backend, "probe", lambda name, library: asked.append(name))
    assert backend.remembered_probe("scalar") is None
    assert backend.remembered_probe("scalar") is None
    assert asked == ["scalar"]


def run(code):
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_scalar_renders_the_same_depth_and_light():
    """The variant for machines without a JIT compiler, in a process of its own."""
    told = run(
        "from synthdepth.render.backend import activate, choose\n"
        "activate(choose('scalar'))\n"
        "from tests.conftest import flat_world, ground, wall\n"
        "from tests.test_render import AHEAD\n"
        "from synthdepth.camera import Intrinsics\n"
        "from synthdepth.render.renderer import load_world\n"
        "from synthdepth.render.settings import RenderSettings\n"
        "view = load_world(flat_world([ground(), wall(50.0, half_m=10)]),\n"
        "                  Intrinsics.from_fov(32, 24, 90), RenderSettings(spp=16))\n"
        "print(view.planar_depth(AHEAD)[12, 16], view.rgb(AHEAD, 1)[:, :, 1].mean(), view.exposure)"
    )
    depth, green, exposure = map(float, told.split())
    assert depth == pytest.approx(50.0, rel=1e-6)
    assert 60 < green < 250
    assert 0.1 < exposure < 100


def test_activating_too_late_is_an_error_not_an_abort():
    told = run(
        "import drjit\n"
        "from synthdepth.errors import BackendError\n"
        "from synthdepth.render.backend import Backend, activate\n"
        "try:\n"
        "    activate(Backend(name='llvm', library='/some/libLLVM.so', reason=''))\n"
        "except BackendError as error:\n"
        "    print(error)"
    )
    assert "call synthdepth.render.backend.activate first" in told
