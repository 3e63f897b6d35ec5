"""The dataset card: README.md with its picture, for people and for the Hugging Face Hub.

Everything in it is a function of the dataset's bytes, so that it has the same bytes every time.
"""

import itertools
import textwrap
from collections.abc import Mapping
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa

from synthdepth.dataset.manifest import CARD, SHEET, pair_files, read_index
from synthdepth.dataset.pair import META_FIELDS
from synthdepth.dataset.preview import contact_sheet, random_pairs, random_rows
from synthdepth.dataset.shard import write_whole
from synthdepth.maps.registry import MAPS

# What is rendered belongs to whoever renders it; the card and croissant.json propose this licence.
LICENSE, LICENSE_URL = "cc-by-4.0", "https://creativecommons.org/licenses/by/4.0/"
_LICENSE_TEXTS = {
    LICENSE: f"""## Licence

Pictures and ground truth belong to whoever rendered them. Unless they say otherwise:
[{LICENSE.upper()}]({LICENSE_URL}).
""",
    "unknown": """## Licence

That of the recordings and of what they show, which they do not say.
""",
}

_MODALITY_LINES = {
    "flow": "`flow.exr`: optical flow, channels `u`, `v` [px]: where each pixel was at *t-1*, "
    "minus where it is now; `visible` is 1 where that place was seen then.",
    "seg": "`seg.png`: class ids; `dataset.json` names them under `labels`.",
    "normal": "`normal.exr`: unit normals `X`, `Y`, `Z` in camera axes, turned to the camera; 0 in "
    "the sky.",
}
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
_SPREAD = {
    "altitude_m": "altitude above ground [m]",
    "speed_mps": "speed [m/s]",
    "nearest_depth_m": "nearest surface in the picture [m]",
    "median_depth_m": "median depth of the picture [m]",
    "in_range_share": "share of pixels within the range",
}
_BANDS_M = (0, 2, 5, 10, 25, 50, 100)
_SHEET_PAIRS, _JPEG_QUALITY = 8, 85


def dataset_name(manifest: Mapping) -> str:
    """A short name without spaces, e.g. `synthdepth-city-seed0`."""
    return f"synthdepth-{manifest['map']}-seed{manifest['seed']}"


def license_text(manifest: Mapping) -> str:
    """The card's section on the licence."""
    return _LICENSE_TEXTS["unknown" if "source" in manifest else LICENSE]


def summary(manifest: Mapping) -> str:
    """What the dataset is, in a few sentences."""
    size = manifest["recipe"]["camera"]
    if "source" in manifest:
        made = (
            f"imported by synthdepth {manifest['software']['synthdepth']} from recordings of AirSim"
            ". A recording is a scene"
        )
    else:
        made = (
            f"path-traced by synthdepth {manifest['software']['synthdepth']} along simulated "
            f"flights. The map is `{manifest['map']}`, {MAPS[manifest['map']].summary}. Every "
            "scene is generated anew"
        )
    splits = ", ".join(f"{count} {name}" for name, count in _counts(manifest))
    return (
        f"{sum(count for _, count in _counts(manifest))} pairs ({splits}) of consecutive drone "
        f"frames, {size['width']}x{size['height']}, with metric depth to "
        f"{manifest['depth']['max_depth_m']:g} m, {made}, and no scene is in two splits."
    )


def write_card(folder: Path, manifest: Mapping) -> None:
    """Write the card and its picture, of a dataset whose shards and index are there.

    Args:
        folder: the dataset folder.
        manifest: the dataset's, with its shards.
    """
    folder = Path(folder)
    write_whole(folder / SHEET, sheet_jpeg(folder))
    splits = [name for name, _ in _counts(manifest)]
    data_files = [(name, f"{name}/*.tar") for name in splits]
    text = hub_header(manifest, len(read_index(folder, ["key"])), data_files, _features(manifest))
    text += f"\n# {dataset_name(manifest)}\n\n{_wrap(summary(manifest))}\n"
    text += f"![Frames, the frames before, depth]({SHEET})\n\n"
    text += figures(read_index(folder))
    text += f"\n{_contract(manifest)}\n{_loading(manifest, splits[0])}\n{_origin(manifest)}"
    write_whole(folder / CARD, text.encode())


def sheet_shards(folder: Path) -> set[str]:
    """The shards that the card's picture shows; the folder needs no more than its index."""
    return {row["shard"] for row in random_rows(folder, _SHEET_PAIRS, seed=0)}


def sheet_jpeg(folder: Path) -> bytes:
    """The card's picture: a few pairs of the dataset, as JPEG."""
    sheet = contact_sheet(random_pairs(folder, _SHEET_PAIRS, seed=0), columns=2)
    bgr = cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR)
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY])[1].tobytes()


def hub_header(
    manifest: Mapping, pairs: int, data_files: list[tuple[str, str]], features: list[str]
) -> str:
    """The YAML block that the Hugging Face Hub and `datasets` read.

    Args:
        manifest: the dataset's.
        pairs: how many there are.
        data_files: (split, pattern of its files).
        features: the columns, an entry of YAML each, as `datasets.Features` are written.
    """
    bounds = {"n<1K": 1e3, "1K<n<10K": 1e4, "10K<n<100K": 1e5, "100K<n<1M": 1e6}
    size = next((name for name, most in bounds.items() if pairs < most), "1M<n<10M")
    lines = [
        "---",
        f"license: {'unknown' if 'source' in manifest else LICENSE}",
        f"pretty_name: synthdepth {manifest['map']}, seed {manifest['seed']}",
        "task_categories: [depth-estimation]",
        f'size_categories: ["{size}"]',
        "tags: [synthetic, drone, uav, monocular-depth, metric-depth]",
        "configs:",
        "- config_name: default",
        "  data_files:",
        *(f'  - {{split: {split}, path: "{pattern}"}}' for split, pattern in data_files),
    ]
    lines += ["dataset_info:", "  features:", *(f"  - {entry}" for entry in features)]
    return "\n".join([*lines, "---", ""])


def figures(index: pa.Table) -> str:
    """What is in a dataset, as tables in Markdown.

    Args:
        index: rows of `index.parquet`, all columns.
    """
    split, scene, condition = (
        index[name].to_numpy() for name in ("split", "scene_index", "condition")
    )
    sizes = (index[name].to_numpy() for name in index.column_names if name.endswith("_size"))
    size = sum(sizes)
    splits = []
    for name in sorted(set(split), reverse=True):
        of = split == name
        splits.append([name, of.sum(), len(set(scene[of])), f"{size[of].sum() / 1e6:.1f}"])
    conditions = sorted(set(condition))
    counts = [(condition == name).sum() for name in conditions]
    spread = []
    for name, words in _SPREAD.items():
        digits = 2 if name == "in_range_share" else 1
        at = np.quantile(index[name].to_numpy(), _QUANTILES)
        spread.append([words, *(f"{value:.{digits}f}" for value in at)])
    shares = np.histogram(index["nearest_depth_m"].to_numpy(), [*_BANDS_M, np.inf])[0] / len(split)
    bands = [*(f"{a}-{b} m" for a, b in itertools.pairwise(_BANDS_M)), f"{_BANDS_M[-1]} m or more"]
    tables = (
        _table(["split", "pairs", "scenes", "MB"], *splits),
        _table(["condition", *conditions], ["pairs", *counts]),
        _table(["share of the pairs below", *(f"{100 * q:g} %" for q in _QUANTILES)], *spread),
        _table(
            ["nearest surface", *bands], ["pairs", *(f"{100 * share:.0f} %" for share in shares)]
        ),
    )
    return "## What is in it\n\n" + "\n".join(tables)


def _table(head: list, *rows: list) -> str:
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(map(str, line)) + " |\n" for line in lines)


def _counts(manifest: Mapping) -> list[tuple[str, int]]:
    """Pairs of the splits that have any, train first."""
    return [(name, n) for name, n in sorted(manifest["splits"].items(), reverse=True) if n]


def _wrap(text: str, **options) -> str:
    return textwrap.fill(text, 100, break_on_hyphens=False, **options) + "\n"


def _features(manifest: Mapping) -> list[str]:
    """The columns of the shards as `datasets` reads them, which would otherwise guess.

    From the first five pairs, that is: a number that is whole in all of them would be an integer.
    """
    kinds = {int: "dtype: int64", float: "dtype: float64", str: "dtype: string"}
    struct = ""
    for name, kind in META_FIELDS.items():
        depth = "list: float64" if name == "velocity_mps" else "list: {list: float64}"
        struct += f"\n    - {{name: {name}, {kinds.get(kind, depth)}}}"
    lines = ["{name: __key__, dtype: string}", "{name: __url__, dtype: string}"]
    for file in pair_files(manifest):
        if file == "meta.json":
            lines.append(f"name: {file}\n    struct:{struct}")
        else:
            kind = "image" if file.endswith(".png") else "binary"
            lines.append(f"{{name: {file}, dtype: {kind}}}")
    return lines


def _contract(manifest: Mapping) -> str:
    modalities = manifest["recipe"]["render"]["modalities"]
    sensor = {
        "drawn": "with a camera's noise, blur, compression",
        "ideal": "with no camera's faults",
        "unknown": "as the simulator gave them",
    }[manifest["recipe"]["sensor"]["model"]]
    lines = [
        f"`rgb.png`: frame *t*; `prev.png`: frame *t-1* of the same flight. 8-bit sRGB, {sensor}.",
        "`depth.exr`: one channel, `Z`, float32 **metres**, **planar** (z in the camera's frame, "
        "not the ray's length), from one ray through each pixel's centre. Whatever is at "
        f"{manifest['depth']['max_depth_m']:g} m or beyond, the sky included, holds exactly "
        f"{manifest['depth']['max_depth_m']:g}. There are no zeros and no NaN.",
        "`meta.json`: intrinsics, poses of both frames, flight, light, sensor; always the same "
        "fields, units in their names.",
        *(_MODALITY_LINES[name] for name in modalities),
    ]
    bullets = "".join(_wrap(line, initial_indent="* ", subsequent_indent="  ") for line in lines)
    return f"""## A pair

Each shard is a WebDataset tar file, one scene; a pair is the files that share a key.

{bullets}
Poses are `world_from_cam`, 4x4, with OpenCV axes (x right, y down, z forward) in a world in metres
with Z up. Integer pixel coordinates are pixel centres: a symmetric camera has
`cx = (width - 1) / 2`.

**Do not read the depth with OpenCV**: it returns zeros for a channel named `Z`, without an error,
or reads no EXR at all. OpenEXR and OpenImageIO read it.
"""


def _loading(manifest: Mapping, split: str) -> str:
    shard = next(record["path"] for record in manifest["shards"] if record["split"] == split)
    return f"""## Load it

In this folder. With synthdepth:

```python
from synthdepth.dataset import PairDataset

for sample in PairDataset(".", split="{split}"):
    print(sample.key, sample.rgb.shape, sample.depth_m.min(), sample.meta["speed_mps"])
```

With [webdataset](https://github.com/webdataset/webdataset):

```python
import io, json

import OpenEXR, webdataset

for sample in webdataset.WebDataset("{shard}", shardshuffle=False):
    meta = json.loads(sample["meta.json"])
    with OpenEXR.File(io.BytesIO(sample["depth.exr"]), separate_channels=True) as exr:
        depth_m = exr.channels()["Z"].pixels  # (H, W) float32
    print(sample["__key__"], depth_m.min(), meta["speed_mps"])
```

With [datasets](https://huggingface.co/docs/datasets), which takes its types from this card:

```python
import io, os

import OpenEXR
from datasets import load_dataset

for row in load_dataset(os.getcwd(), split="{split}", streaming=True):
    with OpenEXR.File(io.BytesIO(row["depth.exr"]), separate_channels=True) as exr:
        depth_m = exr.channels()["Z"].pixels
    print(row["__key__"], row["rgb.png"].size, depth_m.min(), row["meta.json"]["speed_mps"])
```

`index.parquet` has a row a pair: where its files lie in the shards, and all of its metadata.
`croissant.json` describes the folder to whatever reads [Croissant](https://mlcommons.org/croissant);
`mlcroissant` unpacks shards into a cache by their names: give each dataset a `CROISSANT_CACHE`.
"""


def _origin(manifest: Mapping) -> str:
    if "source" in manifest:
        notes = (f"{note[0].upper()}{note[1:]}." for note in manifest["source"]["notes"])
        bullets = (_wrap(n, initial_indent="* ", subsequent_indent="  ") for n in notes)
        return f"## Where it comes from\n\n{''.join(bullets)}\n{license_text(manifest)}"
    return f"""## Where it comes from

`dataset.json` holds the recipe, the seed, the versions and every shard's sha256: the same command
gives the same bytes. `synthdepth verify` checks the folder, `synthdepth preview` shows it. All of
it is rendered: nothing in it was photographed, nobody in it exists, and the world stands still
within a scene. Models trained on it have to be measured on real frames.

{license_text(manifest)}"""
