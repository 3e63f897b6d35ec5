"""Which Mitsuba variant this machine can run, and switching to it.

Some builds of libLLVM load and then abort the whole process at the first kernel (LLVM 14 and 15 on
CPUs with AVX512-FP16), so a candidate is tried in a subprocess before it is trusted, and the
verdict is remembered.
"""

import contextlib
import ctypes
import dataclasses
import importlib.metadata
import json
import os
import re
import subprocess
import sys
from pathlib import Path

from synthdepth.config import parse_json
from synthdepth.errors import BackendError

VARIANTS = {"cuda": "cuda_ad_rgb", "llvm": "llvm_ad_rgb", "scalar": "scalar_rgb"}

# Renders a lit sphere: compiles rays, minima, a loop and virtual calls, as the real kernels do.
_PROBE = """
import sys, mitsuba as mi
mi.set_variant(sys.argv[1])
scene = mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "light": {"type": "constant"},
    "camera": {"type": "perspective", "to_world": mi.ScalarTransform4f().translate([0, 0, -4]),
               "film": {"type": "hdrfilm", "width": 8, "height": 8}}})
path = mi.load_dict({"type": "path", "max_depth": 3})
mi.TensorXf(mi.render(scene, integrator=path, spp=2)).numpy()
"""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Backend:
    """A variant that was seen to work, and why it was chosen.

    Attributes:
        name: "cuda", "llvm" or "scalar".
        library: path of the libLLVM that works, for "llvm".
        reason: one line for people.
    """

    name: str
    library: str | None
    reason: str

    @property
    def variant(self) -> str:
        """Mitsuba's name of the variant."""
        return VARIANTS[self.name]


def llvm_candidates() -> list[str]:
    """Paths of libLLVM to try, best first: the user's choice, pip's package, the system's."""
    found = [os.environ["DRJIT_LIBLLVM_PATH"]] if os.environ.get("DRJIT_LIBLLVM_PATH") else []
    suffix = "dylib" if sys.platform == "darwin" else "so"
    with contextlib.suppress(importlib.metadata.PackageNotFoundError):
        files = importlib.metadata.files("karellen-llvm-core") or []
        found += [os.path.realpath(f.locate()) for f in files if f.name == f"libLLVM.{suffix}"]
    system = [
        *Path("/usr/lib").glob(f"*/libLLVM*.{suffix}*"),
        *Path("/usr/lib").glob(f"llvm-*/lib/libLLVM*.{suffix}*"),
        *Path("/opt/homebrew/opt/llvm/lib").glob(f"libLLVM.{suffix}"),
    ]
    real = {os.path.realpath(p) for p in system}
    found += sorted(real, key=_llvm_version, reverse=True)
    return list(dict.fromkeys(p for p in found if os.path.exists(p)))


def _llvm_version(path: str) -> tuple[int, ...]:
    return tuple(int(n) for n in re.findall(r"\d+", os.path.basename(path))) or (0,)


def probe(name: str, library: str | None = None) -> str | None:
    """Render eight pixels with a variant in a subprocess; None if it works, else what happened."""
    if name == "cuda":
        try:
            ctypes.CDLL("libcuda.so.1")
        except OSError:
            return "no NVIDIA driver (libcuda.so.1)"
    env = dict(os.environ)
    if library:
        env["DRJIT_LIBLLVM_PATH"] = library
    try:
        done = subprocess.run(
            [sys.executable, "-c", _PROBE, VARIANTS[name]],
            env=env,
            capture_output=True,
            text=True,
            timeout=120,
        )
    except subprocess.TimeoutExpired:
        return "gave no picture within 120 s"
    if done.returncode < 0:
        return f"aborts the process (signal {-done.returncode})"
    if done.returncode:
        lines = done.stderr.strip().splitlines() or ["failed without a message"]
        return lines[-1][:160]
    return None


def _memory_path() -> Path:
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "synthdepth" / "backend.json"


def _fingerprint(name: str, library: str | None) -> str:
    """Changes whenever a remembered verdict may no longer hold."""
    stamp = [name, importlib.metadata.version("mitsuba"), importlib.metadata.version("drjit")]
    if library:
        stat = os.stat(library)
        stamp += [os.path.realpath(library), str(stat.st_size), str(stat.st_mtime_ns)]
    return " ".join(stamp)


def remembered_probe(name: str, library: str | None = None) -> str | None:
    """`probe`, asked once per machine, variant, library and version."""
    path, key = _memory_path(), _fingerprint(name, library)
    try:
        verdicts = parse_json(path.read_text())
    except (OSError, ValueError):
        verdicts = {}
    verdicts = verdicts if isinstance(verdicts, dict) else {}
    if isinstance(verdicts.get(key, 0), str | None):
        return verdicts[key]
    verdict = probe(name, library)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        temporary = path.with_suffix(f".{os.getpid()}.tmp")
        temporary.write_text(json.dumps(verdicts | {key: verdict}, indent=1))
        temporary.replace(path)
    except OSError:
        pass  # A read-only home only means that the next start asks again.
    return verdict


def choose(name: str | None = None) -> Backend:
    """The best variant that works here: CUDA, else LLVM, else scalar.

    Args:
        name: "cuda", "llvm" or "scalar" to have that one and no other.

    Raises:
        BackendError: the variant asked for does not work, with the reason and the remedy.
    """
    if name is not None and name not in VARIANTS:
        raise BackendError(f"--variant {name} is unknown: allowed are {', '.join(VARIANTS)}")
    refused = []
    if name in (None, "cuda"):
        verdict = remembered_probe("cuda")
        if verdict is None:
            return Backend(name="cuda", library=None, reason="an NVIDIA GPU renders")
        refused.append(f"cuda: {verdict}")
    if name in (None, "llvm"):
        for library in llvm_candidates():
            verdict = remembered_probe("llvm", library)
            if verdict is None:
                return Backend(name="llvm", library=library, reason=f"{library} works")
            refused.append(f"llvm: {library} {verdict}")
        if not llvm_candidates():
            refused.append("llvm: no libLLVM found")
    if name == "llvm":
        raise BackendError(
            f"--variant llvm cannot run ({'; '.join(refused)}): `pip install karellen-llvm-core` "
            "brings one, or point DRJIT_LIBLLVM_PATH at libLLVM 19 or newer"
        )
    if name == "cuda":
        raise BackendError(f"--variant cuda cannot run ({refused[0]}): use llvm or scalar")
    why = "asked for" if name else "; ".join(refused)
    return Backend(name="scalar", library=None, reason=f"slow, for small checks only ({why})")


def activate(backend: Backend, threads: int | None = None) -> None:
    """Make Mitsuba use a backend in this process.

    Call it before anything imports Dr.Jit (`synthdepth.render.renderer` does): Dr.Jit loads libLLVM
    as it is imported, and a wrong one aborts the process at the first kernel.

    Raises:
        BackendError: too late for that, or another variant is active.
    """
    chosen = os.environ.get("DRJIT_LIBLLVM_PATH")
    if backend.library and "drjit" in sys.modules and chosen != backend.library:
        raise BackendError(
            "drjit was imported before its libLLVM was chosen: call "
            "synthdepth.render.backend.activate first, or set "
            f"DRJIT_LIBLLVM_PATH={backend.library}"
        )
    if backend.library:
        os.environ["DRJIT_LIBLLVM_PATH"] = backend.library
    import drjit as dr
    import mitsuba as mi

    if mi.variant() not in (None, backend.variant):
        raise BackendError(
            f"this process already renders with {mi.variant()}: it cannot change to "
            f"{backend.variant}"
        )
    mi.set_variant(backend.variant)
    mi.set_log_level(mi.LogLevel.Warn)
    if threads and backend.name != "cuda":
        dr.set_thread_count(threads)
