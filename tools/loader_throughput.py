"""Speed and shuffling of the loaders, beside webdataset alone and a folder of plain files.

All decode with the same functions, in a torch DataLoader each, in turn for several rounds: pairs a
second with workers, and processor time a pair without, which other programs disturb less.

python tools/loader_throughput.py --json loaders.json
python tools/loader_throughput.py --folder data/suburb
"""

import dataclasses
import itertools
import json
import statistics
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
import tyro
import webdataset
from torch.utils.data import DataLoader

from synthdepth.camera import Intrinsics
from synthdepth.dataset import PairDataset, PairStream, collate
from synthdepth.dataset.exr import decode_depth
from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.pair import decode_png, scene_of_key
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.production.overrides import with_overrides
from synthdepth.production.recipe import load_recipe
from synthdepth.production.run import render_dataset

DECODERS = {
    "rgb.png": decode_png,
    "prev.png": decode_png,
    "depth.exr": decode_depth,
    "meta.json": json.loads,
}
WHOLE, PART = "whole pairs", "rgb and depth"
FIELDS = {WHOLE: ("rgb", "prev", "depth_m"), PART: ("rgb", "depth_m")}
FILES = {WHOLE: tuple(DECODERS), PART: ("rgb.png", "depth.exr", "meta.json")}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to measure.

    Attributes:
        folder: a dataset; by default one of the map blocks is rendered.
        pairs: pairs of the rendered dataset.
        workers: of each DataLoader.
        rounds: how often each is measured.
        batch: pairs a batch.
        order_scenes: scenes of 256 pairs whose order is looked at; 0 leaves that out.
        json: where the figures go.
    """

    folder: Path | None = None
    pairs: int = 256
    workers: int = 2
    rounds: int = 5
    batch: int = 8
    order_scenes: int = 24
    json: Path | None = None


class PlainFiles:
    """A map-style dataset of a folder with a file each, as most are written."""

    def __init__(self, folder: Path, names: tuple[str, ...]):
        self.folder, self.names = folder, names
        self.keys = sorted(path.name.split(".")[0] for path in folder.glob("*.rgb.png"))

    def __len__(self) -> int:
        return len(self.keys)

    def __getitem__(self, number: int) -> dict:
        key = self.keys[number]
        files = {name: (self.folder / f"{key}.{name}").read_bytes() for name in self.names}
        return decode(files) | {"__key__": key}


def decode(sample: dict) -> dict:
    return {name: DECODERS[name](data) for name, data in sample.items() if name in DECODERS}


def stacked(samples: list[dict]) -> dict:
    """A batch of all that `collate` makes of the same files."""
    batch = {name: [sample[name] for sample in samples] for name in ("__key__", "meta.json")}
    batch["valid"] = torch.from_numpy(
        np.stack([np.ones_like(s["depth.exr"], bool) for s in samples])
    )
    for name in samples[0].keys() & set(DECODERS) - {"meta.json"}:
        images = np.stack([sample[name] for sample in samples])
        images = images.transpose(0, 3, 1, 2) if images.ndim == 4 else images[:, None]
        batch[name] = torch.from_numpy(np.ascontiguousarray(images))
    for name in ("intrinsics", "world_from_cam", "world_from_cam_prev"):
        batch[name] = torch.tensor([sample["meta.json"][name] for sample in samples])
    return batch


def webdataset_alone(shards: list[str], names: tuple[str, ...] | None = None):
    """webdataset as its documentation shows it; told the files' names, it decodes only those."""
    wanted = names and tuple(f".{name}" for name in names)
    return (
        webdataset.WebDataset(
            shards,
            shardshuffle=len(shards),
            empty_check=False,
            select_files=wanted and (lambda name: name.endswith(wanted)),
        )
        .shuffle(1000)
        .map(decode)
    )


def unpack(shards: list[str], out: Path) -> None:
    """Every file of every shard as a plain file."""
    for shard in shards:
        for key, members in shard_members(Path(shard)).items():
            for name, data in read_members(Path(shard), members).items():
                (out / f"{key}.{name}").write_bytes(data)


def speeds(folder: Path, options: Options) -> dict:
    """Medians of every loader over whole pairs and over pictures and depth, and ratios."""
    shards = [str(folder / record["path"]) for record in read_manifest(folder)["shards"]]
    figures = {}
    with tempfile.TemporaryDirectory() as plain:
        unpack(shards, Path(plain))
        for what, fields in FIELDS.items():
            ours, others = {"collate_fn": collate}, {"collate_fn": stacked}
            drawn = {"shuffle": True}
            sources = {
                "PairDataset": (PairDataset(folder, fields=fields), ours | drawn),
                "PairStream": (PairStream(folder, fields=fields), ours),
                "webdataset": (webdataset_alone(shards), others),
                "webdataset, select_files": (webdataset_alone(shards, FILES[what]), others),
                "plain files": (PlainFiles(Path(plain), FILES[what]), others | drawn),
            }
            running = {"batch_size": options.batch, "num_workers": options.workers}
            running["persistent_workers"] = options.workers > 0
            for title, more, clock in (
                ("pairs_per_s", running, time.perf_counter),
                ("cpu_ms_a_pair", {"batch_size": options.batch}, time.process_time),
            ):
                loaders = {k: DataLoader(data, **own, **more) for k, (data, own) in sources.items()}
                figures[f"{title}, {what}"] = alternate(loaders, options.rounds, clock)
    for title, medians in figures.items():
        for one, other in itertools.product(("PairDataset", "PairStream"), list(medians)[2:5]):
            a, b = medians[one], medians[other]
            faster = a / b if title.startswith("pairs") else b / a
            medians[f"{one} over {other}"] = round(faster, 3)
    return figures


def alternate(loaders: dict[str, DataLoader], rounds: int, clock: Callable) -> dict[str, float]:
    """The median of every loader, which take turns: pairs a second, or milliseconds a pair."""
    measured = {name: [] for name in loaders}
    # The first round starts the workers and fills the caches.
    for number in range(rounds + 1):
        for name, loader in loaders.items():
            started = clock()
            pairs = sum(
                len(batch["__key__"] if isinstance(batch, dict) else batch) for batch in loader
            )
            if number:
                measured[name].append((clock() - started) / pairs)
    milliseconds = clock is time.process_time
    return {
        name: round(
            1e3 * statistics.median(seconds) if milliseconds else 1 / statistics.median(seconds), 3
        )
        for name, seconds in measured.items()
    }


def orders(scenes: int, options: Options) -> dict:
    """How well each loader mixes a dataset of `scenes` shards with 256 tiny pairs each."""
    sys.path.insert(0, str(Path(__file__).parents[1]))
    from tests.made import make_dataset

    with tempfile.TemporaryDirectory() as folder:
        camera = Intrinsics.from_fov(16, 16, 90.0)
        folder = make_dataset(Path(folder), shards=scenes, pairs=256, camera=camera)
        shards = [str(folder / record["path"]) for record in read_manifest(folder)["shards"]]
        dataset = PairDataset(folder, fields="rgb")
        stored = {dataset.key(number): number for number in range(len(dataset))}
        loaders = {
            "PairDataset": (dataset, {"shuffle": True}),
            "PairStream shuffle=1000": (PairStream(folder, fields="rgb"), {}),
            "PairStream shuffle=100": (PairStream(folder, fields="rgb", shuffle=100), {}),
            "webdataset shuffle=1000": (webdataset_alone(shards, ("rgb.png",)), {}),
            "unshuffled": (dataset, {}),
        }
        figures = {}
        for name, (source, own) in loaders.items():
            loader = DataLoader(
                source, batch_size=8, num_workers=options.workers, collate_fn=keys_of, **own
            )
            keys = [key for keys in loader for key in keys]
            figures[f"order, {name}"] = mixing(np.array([stored[key] for key in keys]), keys)
        return figures


def keys_of(samples: list) -> list[str]:
    return [s["__key__"] if isinstance(s, dict) else s.key for s in samples]


def mixing(order: np.ndarray, keys: list[str]) -> dict:
    """Figures of an order (N,) of stored places; a full permutation has 1, 0 and 1 / scenes.

    Returns:
        `displacement`, the mean distance between stored and shown place over a permutation's N / 3;
        `rank_correlation` of the two; `same_scene`, the share of neighbours within 8 places, as in
        a batch, that are of one scene.
    """
    scenes = np.array([scene_of_key(key) for key in keys])
    places = np.arange(len(order))
    same = [np.mean(scenes[step:] == scenes[:-step]) for step in range(1, 8)]
    return {
        "displacement": round(float(np.abs(order - places).mean() / (len(order) / 3)), 3),
        "rank_correlation": round(float(np.corrcoef(order, places)[0, 1]), 3),
        "same_scene": round(float(np.mean(same)), 3),
    }


def with_folder(options: Options, measure: Callable[[Path, Options], dict]) -> dict:
    """What is measured of the dataset asked for, or of one that is rendered for it."""
    if options.folder:
        return measure(options.folder, options)
    with tempfile.TemporaryDirectory() as folder:
        recipe = with_overrides(load_recipe("blocks"), pairs_per_scene=32)
        out = Path(folder) / "set"
        render_dataset(recipe, out, pairs=options.pairs, workers=options.workers)
        return measure(out, options)


def main(options: Options) -> None:
    # As in a worker: more threads only wait for one another.
    torch.set_num_threads(1)
    figures = with_folder(options, speeds)
    if options.order_scenes:
        figures |= orders(options.order_scenes, options)
    for title, values in figures.items():
        print(f"{title}:")
        print("\n".join(f"  {name:42s} {value}" for name, value in values.items()))
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")


if __name__ == "__main__":
    main(tyro.cli(Options, description=__doc__))
