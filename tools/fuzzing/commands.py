"""Command lines: any command, any options, values that are right, extreme or nonsense."""

import dataclasses
import json
import random
from pathlib import Path

from fuzzing.command_line import leave_out_long_work, run_command
from fuzzing.kinds import COMMAND_LINE, Kind
from synthdepth.cli import _COMMANDS

# What a value may be, whatever the option is; {f} is a dataset, {s} the folder of all seeds.
_VALUES = (
    "",
    "0",
    "-1",
    "1",
    "2",
    "1e999",
    "nan",
    "inf",
    "0.5",
    str(10**30),
    "9" * 5000,
    "x",
    "=",
    "a=b",
    "=x",
    "x=",
    "--",
    "-",
    "-h",
    "--json",
    "1x1",
    "16x16",
    "99999x99999",
    "0x0",
    "256x256",
    "-1x5",
    "10m",
    "0m",
    "blind",
    "baseline:mean",
    "baseline:",
    "baseline:x",
    "a=baseline:ground",
    "../../x",
    "/",
    "/dev/null",
    "/proc/self/mem",
    "/proc/nowhere/x",
    "x" * 300,
    "a/" * 3000,
    "é\u202e",
    "\udcff",
    "a\nb",
    "%s{0}",
    "s3://b/k",
    "file:///nowhere",
    "nowhere://x",
    "http://127.0.0.1:1/x",
    "{f}",
    "{f}/dataset.json",
    "{f}/index.parquet",
    "{f}/none",
    "{s}/training",
    "{s}/training/last.safetensors",
    "{s}/onnx/model.onnx",
    "{s}/predictions/exr",
    "{s}/kitti/depth",
    "{s}/kitti/object",
    "{s}/airsim/rec",
    "{s}/airsim/settings.json",
    "{s}/pictures/folder",
    "{s}/pictures/video.avi",
    "{s}/recipe/city.toml",
    "{s}/camera/camera.toml",
    "{s}/training/config.json",
    "blocks",
    "city",
    "airsim",
    "kitti",
    "clear",
    "fog",
    "flow",
    "seg",
    "cpu",
    "cuda",
    "cuda:99",
    "cuda:x",
    "train",
    "test",
    "val",
    "{out}",
    "{out}/a/b",
    "out.png",
    "out.html",
    "out.rrd",
    "out.glb",
    "out.onnx",
    "out.json",
)
# Commands that work are more likely to be reached with what they need.
_LIKELY = {
    "render": ["--map", "blocks", "--pairs", "2", "--out", "{out}"],
    "scene": ["--map", "blocks", "--seed", "1"],
    "preview": ["{f}"],
    "view": ["{f}"],
    "verify": ["{f}"],
    "export": ["{f}", "--to", "kitti", "--out", "{out}"],
    "import-airsim": ["{s}/airsim/rec", "--out", "{out}"],
    "train": ["{f}", "--out", "{out}", "--workers", "0"],
    "predict": ["{s}/training", "{s}/pictures/folder", "--out", "{out}"],
    "onnx": ["{s}/training", "--out", "out.onnx"],
    "evaluate": ["baseline:constant", "--data", "{f}", "--out", "{out}", "--workers", "1"],
    "bench": ["{s}/training"],
    "simulate": ["--map", "blocks", "--flights", "2", "--source", "blind", "--out", "{out}"],
}


def _arguments(folder: Path, rng: random.Random) -> None:
    """Draw a command line and leave it in the folder."""
    name = rng.choice(list(_COMMANDS))
    options = [f"--{f.name.replace('_', '-')}" for f in dataclasses.fields(_COMMANDS[name])]
    words = list(_LIKELY.get(name, [])) if rng.random() < 0.8 else []
    for _ in range(rng.choice([0, 1, 1, 2, 3])):
        value = rng.choice(_VALUES)
        change = rng.random()
        if words and change < 0.4:
            words[rng.randrange(len(words))] = value
        elif words and change < 0.5:
            del words[rng.randrange(len(words))]
        elif change < 0.9:
            words += [rng.choice(options), value]
        else:
            words.insert(rng.randrange(len(words) + 1), value)
    if rng.random() < 0.05:
        name = rng.choice(_VALUES)
    places = {
        "{f}": str(folder),
        "{s}": str(folder.parents[1]),
        "{out}": str(folder.parent / "out/x"),
    }
    for place, path in places.items():
        words = [word.replace(place, path) for word in words]
    (folder.parent / "arguments.json").write_text(json.dumps([name, *words]))


def _run(folder: Path) -> None:
    leave_out_long_work()
    arguments = json.loads((folder.parent / "arguments.json").read_text())
    # Elsewhere they are names like any other; a command line cannot hold them.
    run_command([word.replace("\0", "") for word in arguments])


COMMANDS = {
    "command_line": Kind(seed="dataset", targets=(), feeds={COMMAND_LINE: _run}, settle=_arguments)
}
