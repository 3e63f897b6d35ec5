"""A dataset as one HTML page: figures, maps and pairs; no file beside it, no network, no script.

Everything that comes from files is escaped, and the page forbids itself to load anything.
"""

from collections.abc import Mapping, Sequence
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

import numpy as np
import pyarrow as pa

from synthdepth.charts.elements import page_style, table
from synthdepth.dataset.manifest import read_index, read_manifest
from synthdepth.dataset.pair import Pair
from synthdepth.dataset.preview import random_pairs
from synthdepth.dataset.shard import write_whole
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.view import sections
from synthdepth.view.flights import Flight, flights_of
from synthdepth.view.pictures import strip


def write_page(folder: Path, out_html: Path, *, count: int = 24, seed: int = 0) -> int:
    """Write the page of a dataset; returns how many pairs are on it.

    Args:
        folder: the dataset.
        out_html: the file, which ends in .html; about 0.15 MB a pair.
        count: how many pairs to show; the histograms of the flights are over all of them.
        seed: which pairs.

    Raises:
        SynthdepthError: an argument is not usable, or the file cannot be written.
        DatasetError: no finished dataset there, or a pair cannot be read.
    """
    if not 1 <= count <= 400:
        raise SynthdepthError(f"--count {count}: allowed is a whole number from 1 to 400")
    if Path(out_html).suffix.lower() not in (".html", ".htm"):
        raise SynthdepthError(f"--out {out_html}: allowed is a file name that ends in .html")
    manifest, index = read_manifest(folder), read_index(folder)
    if not len(index):
        raise DatasetError(f"{folder} holds no pairs")
    try:
        pairs = random_pairs(Path(folder), count, seed)
        page = _page(manifest, index, pairs)
    except (KeyError, TypeError, ValueError, OSError) as error:
        raise DatasetError(
            f"{folder} is not as the contract has it ({error}); synthdepth verify says where"
        ) from error
    write_whole(Path(out_html), page.encode())
    return len(pairs)


def _page(manifest: Mapping, index: pa.Table, pairs: Sequence[Pair]) -> str:
    far = pairs[0].meta["max_depth_m"]
    flights = flights_of(index)
    depth = np.concatenate([pair.depth_m.ravel() for pair in pairs])
    beyond = f"{100 * np.mean(depth >= far):.1f} %"
    name = f"{manifest['map']}, seed {manifest['seed']}"
    shown = "all of them" if len(pairs) == len(index) else f"{len(pairs)} of them, drawn at random"
    altitude = index["altitude_m"].to_numpy()
    parts = {
        "title": f"{escape(name)} (synthdepth)",
        "style": page_style(),
        "name": escape(name),
        "lead": f"{len(index):,} pairs of drone frames with depth to {far:g} m, path-traced in "
        f"{_many(index, 'scene_index')} procedural scenes.",
        "warning": _warning(manifest, len(index)),
        "strip": _strip(pairs),
        "tiles": _headline(manifest, index, flights, pairs[0]),
        "pairs_said": f"{shown.capitalize()}, by light and weather. Frame t is the one that the "
        "depth, the flow, the labels and the normals belong to.",
        "legends": sections.legends(manifest, pairs, far),
        "pairs": sections.pairs_by_condition(index, pairs),
        "depth_said": f"Of every pixel of the pairs shown below; {beyond} are sky or at {far:g} m "
        "and beyond, where the depth saturates.",
        "depth_histogram": sections.depth_histogram(depth, far),
        "depth_bands": sections.depth_bands(depth, far),
        "flights_said": f"Of all {len(index):,} pairs.",
        "flight_histograms": sections.flight_histograms(index, altitude),
        "conditions": sections.conditions(index),
        "map_legend": sections.map_legend(),
        "facts": _facts(manifest, pairs[0]),
    }
    parts["map_said"], parts["maps"] = sections.maps(flights, altitude)
    return Template(_resource("page.html")).substitute(parts)


def _resource(name: str) -> str:
    return (files("synthdepth.view") / name).read_text()


def _many(index: pa.Table, column: str) -> int:
    return len(index[column].unique())


def _warning(manifest: Mapping, pairs: int) -> str:
    if manifest["complete"]:
        return ""
    return (
        f'<p class="warning">The run has not finished: {pairs:,} of {manifest["pairs_planned"]:,} '
        "pairs are here. The same <code>synthdepth render</code> command goes on.</p>"
    )


def _strip(pairs: Sequence[Pair]) -> str:
    first_of = {pair.key.rpartition("-")[0]: pair for pair in reversed(pairs)}
    most = 8 if len(first_of) >= 8 else 4  # whole rows, also of four on a phone
    shown = strip(list(reversed(first_of.values())), most)
    return f'<div class="strip" style="--n:{len(shown)}">{"".join(t.img() for t in shown)}</div>'


def _headline(manifest: Mapping, index: pa.Table, flights: Sequence[Flight], first: Pair) -> str:
    splits = {str(split): int(n) for split, n in manifest["splits"].items()}
    size = sum(shard["bytes"] for shard in manifest["shards"])
    figures = {
        "Pairs": f"{len(index):,}",
        "Scenes": f"{_many(index, 'scene_index'):,}",
        "Flights": f"{len(flights):,}",
        **{f"In {split}": f"{n:,}" for split, n in sorted(splits.items(), reverse=True)},
        "Pixels": f"{first.camera.width}×{first.camera.height}",
        "Field of view": f"{first.camera.fov_deg:.3g}°",
        "Depth to": f"{first.meta['max_depth_m']:g} <small>m</small>",
        "On disk": _size(size),
    }
    return "".join(
        f"<div><dt>{escape(name)}</dt><dd>{figure}</dd></div>" for name, figure in figures.items()
    )


def _size(size: int) -> str:
    unit, scale = next(
        u for u in (("GB", 1e9), ("MB", 1e6), ("kB", 1e3)) if size >= u[1] or u[0] == "kB"
    )
    return f"{size / scale:.3g} <small>{unit}</small>"


def _facts(manifest: Mapping, first: Pair) -> str:
    recipe, software, meta = manifest["recipe"], manifest["software"], first.meta
    camera = first.camera
    sampling = recipe["sampling"]
    facts = {
        "Map": manifest["map"],
        "Seed": manifest["seed"],
        "Format": f"version {manifest['schema_version']}",
        "Ground truth": ", ".join(["depth", *recipe["render"]["modalities"]]),
        "Camera": f"{camera.width}×{camera.height} px, fx {camera.fx:.2f} px, fy {camera.fy:.2f} "
        f"px, principal point ({camera.cx:g}, {camera.cy:g}), no distortion",
        "Sensor": recipe["sensor"]["model"],
        "Time between frames": f"{meta['dt_s']:g} s",
        "A scene has": f"{sampling['pairs_per_scene']} pairs, {sampling['pairs_per_flight']} a "
        f"flight, {sampling['burst_pairs']} in a row",
        "Samples a pixel": meta["spp"],
        "Share of scenes in train": f"{100 * manifest['train_share']:g} %",
        "Software": ", ".join(f"{name} {version}" for name, version in software.items()),
    }
    rows = [
        [f"<th scope=row>{escape(name)}</th>", f"<td>{escape(str(value))}</td>"]
        for name, value in facts.items()
    ]
    return f'<div class="card">{table("", rows, "facts")}</div>'
