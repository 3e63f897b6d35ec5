"""What is fed to what: the kinds of input, and the readers of each."""

import contextlib
import dataclasses
import hashlib
import json
import os
import random
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import torch

from fuzzing.command_line import Wrong, leave_out_long_work, run_command
from synthdepth.airsim.importer import import_airsim
from synthdepth.airsim.settings import camera_from_settings
from synthdepth.dataset.exr import decode_depth, decode_flow, decode_normal, depth_header
from synthdepth.dataset.manifest import CHECKSUMS, INDEX, MANIFEST, read_manifest
from synthdepth.dataset.pair import decode_labels, decode_pair, decode_png
from synthdepth.dataset.pairs import PairDataset
from synthdepth.dataset.preview import preview
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.shard import ShardWriter, read_members, shard_members
from synthdepth.dataset.stream import PairStream
from synthdepth.dataset.verify import verify
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.sources import open_source
from synthdepth.export import export
from synthdepth.kitti.dataset import KittiDataset
from synthdepth.kitti.splits import read_split
from synthdepth.pix2pix.checkpoint import LAST, load_generator, read_facts
from synthdepth.pix2pix.config import TrainConfig, train_config
from synthdepth.pix2pix.data import TrainingData
from synthdepth.pix2pix.distributed import Place
from synthdepth.pix2pix.keeping import begin
from synthdepth.pix2pix.original import load_original_generator
from synthdepth.pix2pix.predict import predict
from synthdepth.pix2pix.state import State
from synthdepth.production.overrides import with_overrides
from synthdepth.production.recipe import load_recipe, recipe_from_table
from synthdepth.simulate.replay import rules_of
from synthdepth.simulate.spent import read_spent
from synthdepth.simulate.store import (
    SCENES,
    TIMES,
    claim,
    flown,
    read_flights,
    read_map,
    read_settings,
)
from synthdepth.view.page import write_page

_HERE = Place(rank=0, ranks=1, device=torch.device("cpu"))

Feed = Callable[[Path], object]
COMMAND_LINE = "command line"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Kind:
    """A kind of input.

    Attributes:
        seed: the folder of `seeds` that is copied and broken.
        targets: patterns of the files of it that are broken.
        feeds: readers by name; each is given the broken copy. A name that ends in "decoder" may
            raise ValueError, which its callers turn into DatasetError.
        settle: what to do to the copy after it was broken, so that the reader gets to the place.
    """

    seed: str
    targets: tuple[str, ...]
    feeds: dict[str, Feed]
    settle: Callable[[Path, random.Random], None] = lambda folder, rng: None


# Datasets.


def _read_all(folder: Path, **how) -> None:
    for sample in PairDataset(folder, **how):
        _check_sample(sample)


def _stream_all(source, **how) -> None:
    for sample in PairStream(source, shuffle=0, **how):
        _check_sample(sample)


def _check_sample(sample: Sample) -> None:
    """What was accepted has to be numbers, of the shapes that were promised."""
    matrices = (sample.intrinsics, sample.world_from_cam, sample.world_from_cam_prev)
    for matrix, shape in zip(matrices, ((3, 3), (4, 4), (4, 4)), strict=True):
        if matrix.shape != shape or matrix.dtype.kind not in "fi":
            raise Wrong(f"a sample with a matrix of {matrix.shape} {matrix.dtype}")
    if sample.depth_m.ndim != 2 or sample.rgb.ndim != 3:
        raise Wrong(f"a sample with depth {sample.depth_m.shape}, rgb {sample.rgb.shape}")


def _train_data(folder: Path) -> None:
    config = TrainConfig(workers=0, validate_every=0)
    for _ in TrainingData(config, [folder], _HERE).batches(0):
        pass


def _shards(folder: Path) -> list[str]:
    return [str(path) for path in sorted(folder.glob("*/*.tar"))]


_DATASET: dict[str, Feed] = {
    "PairDataset": _read_all,
    "where": lambda f: _read_all(f, split="train", where={"altitude_m": (0, 1e9)}),
    "PairStream": _stream_all,
    "PairStream of shards": lambda f: _stream_all(_shards(f)),
    "PairStream where": lambda f: _stream_all(f, where={"split": ["train", "test"]}),
    "training": _train_data,
    "verify": lambda f: _one_line_faults(verify(f)),
    "preview": lambda f: preview(f, f / "out.png", count=2),
    "page": lambda f: write_page(f, f / "out.html", count=2),
    "kitti": lambda f: export("kitti", f, f.parent / "out/kitti"),
    "tartanair": lambda f: export("tartanair", f, f.parent / "out/tartanair"),
    "hf": lambda f: export("hf", f, f.parent / "out/hf"),
    "nerfstudio": lambda f: export("nerfstudio", f, f.parent / "out/nerfstudio"),
}


def _one_line_faults(report) -> None:
    for fault in report.faults:
        if "\n" in fault.what:
            raise Wrong(f"a fault of several lines: {fault.what[:200]!r}")
    if report.faults:
        raise SynthdepthError(f"{len(report.faults)} faults")


def _settle_sums(folder: Path, rng: random.Random) -> None:
    """Often the manifest says what the broken shard now is, so that readers look into it."""
    if rng.random() < 0.3:
        return
    try:
        manifest = json.loads((folder / MANIFEST).read_text())
        for record in manifest["shards"]:
            data = (folder / record["path"]).read_bytes()
            record |= {"bytes": len(data), "sha256": hashlib.sha256(data).hexdigest()}
        (folder / MANIFEST).write_text(json.dumps(manifest))
    except (OSError, ValueError, KeyError, TypeError):
        return


def unpack_shards(folder: Path) -> None:
    """Every member as a file of its own in `members/`, to be broken alone."""
    for path in folder.glob("*/*.tar"):
        for key, files in shard_members(path).items():
            for suffix, data in read_members(path, files).items():
                place = folder / "members" / path.relative_to(folder) / f"{key}.{suffix}"
                place.parent.mkdir(parents=True, exist_ok=True)
                place.write_bytes(data)


def _settle_members(folder: Path, rng: random.Random) -> None:
    """The shards of the members as they are now, with the index that they had."""
    index = pq.read_table(folder / INDEX)
    rows = {row["key"]: row for row in index.to_pylist()}
    for path in folder.glob("*/*.tar"):
        files = sorted((folder / "members" / path.relative_to(folder)).iterdir())
        pairs: dict[str, dict[str, bytes]] = {}
        for file in files:
            key, _, suffix = file.name.partition(".")
            pairs.setdefault(key, {})[suffix] = file.read_bytes()
        with ShardWriter(path) as writer:
            for key, members in pairs.items():
                writer.add(key, members)
        for key, members in shard_members(path).items():
            for suffix, member in members.items():
                name = suffix.split(".")[0]
                rows[key] |= {f"{name}_offset": member.offset, f"{name}_size": member.size}
    pq.write_table(type(index).from_pylist(list(rows.values()), index.schema), folder / INDEX)
    _settle_sums(folder, rng)


def _decode_members(folder: Path) -> None:
    """Each decoder with each member; ValueError is their word for what they cannot read."""
    decoders = {
        "depth.exr": [decode_depth, depth_header, decode_flow],
        "flow.exr": [decode_flow, decode_depth],
        "normal.exr": [decode_normal],
        "seg.png": [decode_labels],
        "rgb.png": [decode_png, decode_labels],
        "prev.png": [decode_png],
    }
    refused = 0
    for file in sorted(folder.glob("members/*/*/*")):
        key, _, suffix = file.name.partition(".")
        for decode in decoders.get(suffix, []):
            with contextlib.suppress(ValueError):
                decode(file.read_bytes())
                continue
            refused += 1
        if suffix == "meta.json":
            names = {p.name.partition(".")[2]: p.read_bytes() for p in file.parent.glob(f"{key}.*")}
            decode_pair(key, names)


# Trainings and networks.


def _resume(folder: Path) -> None:
    """Go on with a training that is known from the whole file beside."""
    facts = read_facts(folder / "whole.safetensors")
    config = TrainConfig.from_table(facts["config"], "config")
    asked = {name: facts[name] for name in ("config", "data", "processes", "folders")}
    (folder / "run").mkdir()
    os.replace(folder / LAST, folder / "run" / LAST)
    try:
        begin(folder / "run", State(config, torch.device("cpu")), asked, resume=True)
    finally:
        os.replace(folder / "run" / LAST, folder / LAST)
        (folder / "run").rmdir()


def _frame() -> Sample:
    return Sample(
        key="frame",
        rgb=np.zeros((48, 64, 3), np.uint8),
        prev=np.zeros((48, 64, 3), np.uint8),
        depth_m=np.ones((48, 64), np.float32),
        valid=np.ones((48, 64), bool),
        max_depth_m=200.0,
        intrinsics=np.eye(3),
    )


def _source(path: Path, keys: Sequence[str] = ("frame",)) -> None:
    source = open_source(str(path))
    for key in keys:
        for depth in source.depth_m([dataclasses.replace(_frame(), key=key)]):
            if np.ndim(depth) != 2 or np.asarray(depth).dtype.kind not in "fiu":
                raise Wrong(f"a prediction of {np.shape(depth)}")


def _predictions(kind: str) -> Feed:
    def feed(folder: Path) -> None:
        names = sorted(path.name.partition(".")[0] for path in (folder / kind).iterdir())
        _source(folder / kind, names)

    return feed


# Other people's files.


def _kitti(place: str, **how) -> Feed:
    def feed(folder: Path) -> None:
        for sample in KittiDataset(folder / place, **how):
            if sample.depth_m.shape != sample.rgb.shape[:2]:
                raise Wrong(f"depth {sample.depth_m.shape} of a picture {sample.rgb.shape}")

    return feed


def _kitti_splits(folder: Path) -> None:
    for path in sorted(folder.glob("depth/splits/*/*.txt")):
        read_split(path)
        for _ in KittiDataset(folder / "depth", split_file=path):
            pass


def _simulation(folder: Path) -> None:
    """As `simulate` goes on in its folder."""
    settings = read_settings(folder)
    known = {k: v for k, v in settings.items() if k not in ("sources", "format")}
    claim(folder, known, [])


def _replay(folder: Path) -> None:
    """As `replay` reads what was asked for."""
    settings = read_settings(folder)
    recipe_from_table(settings["recipe"], "recipe")
    rules_of(settings["rules"])


def _command_of(*words: str) -> Feed:
    """A command with the broken copy {f}; what it writes goes to {out}."""

    def feed(folder: Path) -> None:
        leave_out_long_work()
        run_command([word.format(f=folder, out=folder.parent / "out/cli") for word in words])

    return feed


KINDS: dict[str, Kind] = {
    "recipe": Kind(
        seed="recipe",
        targets=("*.toml",),
        feeds={
            "load_recipe": lambda f: [load_recipe(str(p)) for p in sorted(f.glob("*.toml"))],
            "command": _command_of(
                "scene", "--map", "{f}/blocks.toml", "--seed", "1", "--out", "{out}.glb"
            ),
        },
    ),
    "camera": Kind(
        seed="camera",
        targets=("camera.toml",),
        feeds={
            "camera": lambda f: with_overrides(load_recipe("blocks"), camera=str(f / "camera.toml"))
        },
    ),
    "airsim_settings": Kind(
        seed="airsim",
        targets=("settings.json",),
        feeds={
            "any": lambda f: camera_from_settings(f / "settings.json"),
            "named": lambda f: camera_from_settings(f / "settings.json", "front", image_type=1),
            "camera": lambda f: with_overrides(
                load_recipe("blocks"), camera=str(f / "settings.json")
            ),
        },
    ),
    "airsim": Kind(
        seed="airsim",
        targets=("rec/airsim_rec.txt", "rec/images/*", "rec/airsim_rec.txt"),
        feeds={
            "import": lambda f: import_airsim(f / "rec", f.parent / "out/a"),
            "with settings": lambda f: import_airsim(
                f / "rec", f.parent / "out/b", settings=f / "settings.json"
            ),
            "command": _command_of("import-airsim", "{f}", "--out", "{out}"),
        },
    ),
    "shard": Kind(seed="dataset", targets=("*/*.tar",), feeds=_DATASET, settle=_settle_sums),
    "member": Kind(
        seed="members",
        targets=("members/*/*/*.exr", "members/*/*/*.png", "members/*/*/*.exr"),
        feeds={"decoder": _decode_members} | _DATASET,
        settle=_settle_members,
    ),
    "meta": Kind(
        seed="members",
        targets=("members/*/*/*.json",),
        feeds={"decoder": _decode_members} | _DATASET,
        settle=_settle_members,
    ),
    "manifest": Kind(
        seed="dataset",
        targets=(MANIFEST, MANIFEST, CHECKSUMS),
        feeds=_DATASET
        | {
            "read_manifest": read_manifest,
            "command": _command_of("verify", "{f}"),
            "export": _command_of("export", "{f}", "--to", "kitti", "--out", "{out}"),
        },
    ),
    "index": Kind(
        seed="dataset",
        targets=(INDEX,),
        feeds=_DATASET
        | {
            "predict": lambda f: predict(f.parents[1] / "training", f, f.parent / "out/predicted"),
        },
    ),
    "checkpoint": Kind(
        seed="checkpoint",
        targets=(LAST,),
        feeds={
            "load_generator": lambda f: load_generator(f / LAST),
            "source": lambda f: _source(f / LAST),
            "resume": _resume,
            "original": lambda f: load_original_generator(f / LAST),
            "onnx": _command_of("onnx", "{f}/" + LAST, "--out", "{out}.onnx", "--size", "32x32"),
        },
    ),
    "train_config": Kind(
        seed="training",
        targets=("config.json", "config.toml"),
        feeds={
            "json": lambda f: train_config(f / "config.json", {"input.kind": "rgb", "epochs": 3}),
            "toml": lambda f: train_config(f / "config.toml"),
        },
    ),
    "simulation": Kind(
        seed="simulation",
        targets=("simulation.json", "flights.jsonl", "scenes/*.jsonl", "maps/*", "times/*"),
        feeds={
            "settings": _simulation,
            "flights": lambda f: read_flights(f / "flights.jsonl"),
            "scene": lambda f: flown(f / SCENES / "blocks-s00000.jsonl", mend=True),
            "map": lambda f: read_map(f, "blocks", 0),
            "times": lambda f: read_spent(sorted((f / TIMES).glob("*.jsonl"))),
            "replay": _replay,
            "command": _command_of("replay", "{f}", "--source", "blind", "--out", "{out}.mp4"),
        },
    ),
    "onnx": Kind(
        seed="onnx",
        targets=("model.onnx",),
        feeds={"source": lambda f: _source(f / "model.onnx")},
    ),
    "predictions": Kind(
        seed="predictions",
        targets=("exr/*", "npy/*", "npy/*", "png/*"),
        feeds={kind: _predictions(kind) for kind in ("exr", "npy", "png")},
    ),
    "kitti": Kind(
        seed="kitti",
        targets=(
            "depth/*/*/oxts/data/*",
            "depth/*/*/velodyne_points/data/*",
            "depth/*/calib_*.txt",
            "depth/splits/*/*.txt",
            "depth/*/*/proj_depth/*/*/*.png",
            "depth/*/*/image_02/data/*",
            "depth/synthdepth.json",
            "selection/*/*",
            "object/training/*/*",
        ),
        feeds={
            "depth": _kitti("depth"),
            "raw": _kitti("depth", layout="raw"),
            "monodepth2": _kitti("depth", layout="raw", variant="monodepth2"),
            "selection": _kitti("selection"),
            "object": _kitti("object"),
            "splits": _kitti_splits,
        },
    ),
    "pictures": Kind(
        seed="pictures",
        targets=("folder/*", "video.avi"),
        feeds={
            "folder": lambda f: predict(
                f.parents[1] / "training", f / "folder", f.parent / "out/a"
            ),
            "video": lambda f: predict(
                f.parents[1] / "training", f / "video.avi", f.parent / "out/b"
            ),
        },
    ),
}
