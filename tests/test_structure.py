"""How the package hangs together: one-way imports, nothing done on import, no hidden randomness."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

PACKAGE = Path(__file__).parents[1] / "synthdepth"

# Each may import from itself and from those above it.
LAYERS = (
    "errors",
    "config",
    "seeding",
    "camera",
    "flow",
    "maps",
    "flight",
    "render",
    "dataset",
    "charts",
    "kitti",
    "airsim",
    "pix2pix",
    "evaluate",
    "simulate",
    "production",
    "export",
    "view",
    "console",
    "cli",
)
# Who may import what is heavy or particular.
ONLY_IN = {
    "mitsuba": "render",
    "drjit": "render",
    "mitsuba_oidn": "render",
    "tyro": "cli",
    "rerun": "view",
    "ray": "production",
}

MODULES = sorted(path for path in PACKAGE.rglob("*.py") if path.name != "__main__.py")


def imports(path):
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_imports_go_one_way(path):
    layer = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
    if layer == "__init__":
        return
    for name in imports(path):
        top, *rest = name.split(".")
        if top == "synthdepth" and rest:
            assert LAYERS.index(rest[0]) <= LAYERS.index(layer), f"{path.name} imports {name}"
        assert ONLY_IN.get(top, layer) == layer, f"{path.name} imports {name}"


def test_importing_the_command_line_loads_nothing_heavy():
    code = "import sys, synthdepth.cli; print(*sorted(m for m in sys.modules if '.' not in m))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    heavy = {"mitsuba", "drjit", "torch", "trimesh", "pyarrow", "cv2", "OpenEXR", "scipy"}
    assert heavy.isdisjoint(done.stdout.split())


@pytest.mark.parametrize("path", MODULES, ids=lambda p: str(p.relative_to(PACKAGE)))
def test_no_randomness_but_the_lanes_and_no_clock(path):
    """Global generators, hash() and the time of day would break determinism without a trace."""
    for node in ast.walk(ast.parse(path.read_text())):
        if not isinstance(node, ast.Attribute):
            continue
        dotted = ast.unparse(node)
        if path.name != "seeding.py":
            assert not dotted.startswith("np.random.") or dotted == "np.random.Generator", dotted
        assert dotted not in ("time.time", "datetime.now", "uuid.uuid4", "random.random"), dotted


def test_files_stay_small():
    long = {
        str(path.relative_to(PACKAGE)): lines
        for path in MODULES
        if (lines := len(path.read_text().splitlines())) > 500
    }
    assert not long
