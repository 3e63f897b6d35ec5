"""How the depth of datasets is spread over the range: is any distance too rare to learn?

    python tools/depth_coverage.py data/city data/coastline --json coverage.json

Counts every pixel of every depth.exr, a pair at a time, so memory does not grow with the dataset.
Datasets of the same map are counted together. Per map, all shares are of its pixels:

* the share in 0-10, 10-25, 25-50, 50-100 and 100-200 m, and what is saturated (at or beyond the
  range, and the sky);
* the same for each condition, of the pixels of that condition;
* where pairs have a `seg.png`, the same for each class, of the pixels of that class, and the share
  of the class itself;
* the nearest depth of a frame: quantiles over the frames, and the share of frames nearer than
  some distances.

The rule, marked with a star where a map breaks it: no band within the range holds under 5 % of the
map's pixels, and under 60 % are saturated.
"""

import argparse
import dataclasses
import itertools
import json
import sys
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from synthdepth.dataset.exr import decode_depth
from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.shard import read_members, shard_members, write_whole
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.maps.world import LABELS

BANDS_M = (0.0, 10.0, 25.0, 50.0, 100.0, 200.0)
LEAST_BAND_SHARE = 0.05
MOST_SATURATED_SHARE = 0.60
NEAR_M = (1.0, 2.0, 5.0, 10.0)
QUANTILES = (0.0, 0.01, 0.1, 0.5, 0.9)


def band_edges(max_depth_m: float) -> list[float]:
    """Edges of the bands [m]: those of `BANDS_M` within the range, and the range."""
    return [edge for edge in BANDS_M if edge < max_depth_m] + [float(max_depth_m)]


def band_of(depth_m: np.ndarray, edges_m: list[float]) -> np.ndarray:
    """The band of every depth, int of any shape; the last number is what is saturated.

    Args:
        depth_m: planar depth [m], saturated at the last edge.
        edges_m: from `band_edges`; a band holds its lower edge and not its upper one.
    """
    return np.searchsorted(edges_m[1:], depth_m, side="right")


def shares(counts: np.ndarray) -> list[float]:
    """Counts as shares that sum to one; of nothing, all zero."""
    return (counts / max(counts.sum(), 1)).tolist()


@dataclasses.dataclass(kw_only=True)
class Coverage:
    """Counts over the pairs of one map.

    Attributes:
        edges_m: edges of the bands [m].
        by_condition: pixels a band and what is saturated, by condition.
        by_class: (256, bands + 1) pixels, by class id of `seg.png`.
        nearest_m: nearest depth of every frame [m].
    """

    edges_m: list[float]
    by_condition: dict[str, np.ndarray] = dataclasses.field(default_factory=dict)
    by_class: np.ndarray = dataclasses.field(init=False)
    nearest_m: list[float] = dataclasses.field(default_factory=list)

    def __post_init__(self):
        self.by_class = np.zeros((256, len(self.edges_m)), np.int64)

    def add(self, depth_m: np.ndarray, condition: str, seg: np.ndarray | None = None) -> None:
        """Count one frame: (H, W) depth [m], and (H, W) uint8 class ids where there are any."""
        bands = len(self.edges_m)
        band = band_of(depth_m, self.edges_m).ravel()
        before = self.by_condition.get(condition, np.zeros(bands, np.int64))
        self.by_condition[condition] = before + np.bincount(band, minlength=bands)
        self.nearest_m.append(float(depth_m.min()))
        if seg is not None:
            both = seg.ravel().astype(np.int64) * bands + band
            self.by_class += np.bincount(both, minlength=256 * bands).reshape(256, bands)

    def report(self) -> dict:
        """Shares of the pixels, quantiles of the nearest depth [m], and what breaks the rule."""
        names = [f"{a:g}-{b:g} m" for a, b in itertools.pairwise(self.edges_m)] + ["saturated"]
        total = np.sum(list(self.by_condition.values()), axis=0)
        overall = dict(zip(names, shares(total), strict=True))
        broken = [name for name in names[:-1] if overall[name] < LEAST_BAND_SHARE]
        broken += ["saturated"] if overall["saturated"] >= MOST_SATURATED_SHARE else []
        class_names = {number: name for name, number in LABELS.items()}
        classes = {}
        for number in np.flatnonzero(self.by_class.sum(axis=1)):
            counts = self.by_class[number]
            name = class_names.get(int(number), f"class {number}")
            share = {"share_of_pixels": float(counts.sum() / self.by_class.sum())}
            classes[name] = share | dict(zip(names, shares(counts), strict=True))
        nearest = np.array(self.nearest_m)
        return {
            "frames": len(nearest),
            "shares": overall,
            "breaks_rule": broken,
            "by_condition": {
                name: dict(zip(names, shares(counts), strict=True))
                for name, counts in sorted(self.by_condition.items())
            },
            "by_class": classes,
            "nearest_m": {f"p{100 * q:g}": float(np.quantile(nearest, q)) for q in QUANTILES},
            "frames_nearer_than": {f"{m:g} m": float(np.mean(nearest < m)) for m in NEAR_M},
        }


def frames(folder: Path, shards: list[dict]) -> Iterator[tuple[np.ndarray, str, np.ndarray | None]]:
    """Depth [m], condition and class ids (or none) of every pair of a dataset, one at a time."""
    for record in shards:
        path = folder / record["path"]
        try:
            for key, members in shard_members(path).items():
                wanted = {"depth.exr", "meta.json", "seg.png"} & members.keys()
                content = read_members(path, {suffix: members[suffix] for suffix in wanted})
                if len(content.keys() - {"seg.png"}) < 2:
                    raise ValueError(f"pair {key} lacks its depth or its metadata")
                depth_m = decode_depth(content["depth.exr"])
                seg = content.get("seg.png")
                if seg is not None:
                    seg = decode_seg(seg, depth_m.shape)
                yield depth_m, json.loads(content["meta.json"])["condition"], seg
        except (OSError, ValueError, KeyError) as error:
            raise DatasetError(f"{path} cannot be counted: {error}") from error


def decode_seg(data: bytes, shape: tuple[int, int]) -> np.ndarray:
    """The (H, W) uint8 class ids of a `seg.png`; ValueError where they are none of that shape."""
    seg = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_UNCHANGED) if data else None
    if seg is None or seg.dtype != np.uint8 or seg.shape != shape:
        raise ValueError(f"seg.png is no 8-bit grey PNG of {shape[1]}x{shape[0]} px")
    return seg


def count(folders: list[Path]) -> dict[str, Coverage]:
    """The counts of datasets by map.

    Raises:
        DatasetError: no dataset there, or two of one map have other ranges.
    """
    found: dict[str, Coverage] = {}
    for folder in folders:
        manifest = read_manifest(folder)
        if not manifest["shards"]:
            raise DatasetError(f"{folder} has no finished shard yet")
        edges = band_edges(manifest["depth"]["max_depth_m"])
        coverage = found.setdefault(manifest["map"], Coverage(edges_m=edges))
        if coverage.edges_m != edges:
            raise DatasetError(
                f"{folder} saturates at {edges[-1]:g} m, another dataset of its map at "
                f"{coverage.edges_m[-1]:g} m: count them apart"
            )
        for depth_m, condition, seg in frames(folder, manifest["shards"]):
            coverage.add(depth_m, condition, seg)
    return found


def text(name: str, report: dict) -> str:
    """The report of a map for people."""

    def line(label: str, row: dict, broken=()) -> str:
        cells = (f"{100 * row[b]:10.1f}{'*' if b in broken else ' '}" for b in report["shares"])
        return f"  {label:24}" + "".join(cells)

    lines = [f"{name}: {report['frames']} frames, % of the pixels (* breaks the rule)"]
    lines.append(" " * 26 + "".join(f"{band:>11}" for band in report["shares"]))
    lines.append(line("all", report["shares"], report["breaks_rule"]))
    lines += [line(f"condition {c}", row) for c, row in report["by_condition"].items()]
    for label, row in report["by_class"].items():
        lines.append(line(f"{label} ({100 * row['share_of_pixels']:.1f} %)", row))
    nearest = ", ".join(f"{q} {m:.2f} m" for q, m in report["nearest_m"].items())
    near = ", ".join(f"{100 * s:.0f} % < {m}" for m, s in report["frames_nearer_than"].items())
    return "\n".join([*lines, f"  nearest depth of a frame: {nearest}; frames: {near}"])


def main(arguments: list[str] | None = None) -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("datasets", nargs="+", type=Path, metavar="DATASET", help="folders")
    parser.add_argument("--json", type=Path, metavar="FILE", help="where the figures go")
    options = parser.parse_args(arguments)
    try:
        reports = {name: found.report() for name, found in count(options.datasets).items()}
        print("\n".join(text(name, report) for name, report in reports.items()))
        if options.json:
            write_whole(options.json, json.dumps(reports, indent=1).encode() + b"\n")
    except SynthdepthError as error:
        print(f"depth_coverage: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
