"""Which faults the consistency gate finds, and how many right pairs it accuses.

python tools/gate_detection.py data/city data/suburb --json gate_detection.json

Every pair of some shards is judged as it is; then some of one shard of each dataset with every
fault: in a file, of which meta.json tells what it held; rendered, where meta.json fits what is
wrong, so that only the pictures can tell; and all of the latter together, as a shard's are.
"""

import collections
import dataclasses
import json
import sys
from pathlib import Path

import numpy as np
import tyro

from synthdepth.camera import pitch_roll_deg
from synthdepth.dataset.gate import gate_pair, gate_shard
from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.pair import Pair, decode_pair, saturate
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.flow.truth import flow_from_depth

COLUMNS = ("pairs", "in a file", "rendered", "shards", "together")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to judge.

    Attributes:
        folders: finished datasets of at least two shards.
        shards: so many of each are judged at most, 2 at least.
        pairs: so many of one of them get faults; 8 or more are judged together.
        json: where the figures go.
    """

    folders: tyro.conf.Positional[tuple[Path, ...]]
    shards: int = 6
    pairs: int = 12
    json: Path | None = None


def faulty(pair: Pair, near: Pair, far: Pair) -> dict[str, dict]:
    """What of a pair each fault changes; `near` is of its flight, `far` of another scene."""
    depth, column = pair.depth_m, np.arange(pair.camera.width)
    finite = np.where(depth < np.float32(pair.meta["max_depth_m"]), depth, np.inf)
    length = np.linalg.norm(pair.camera.rays(), axis=-1)
    aside, turned, (sine, cosine) = np.eye(4), np.eye(4), np.sin(np.radians([2, 92]))
    aside[0, 3] = 1.0
    turned[::2, ::2][:2, :2] = [[cosine, sine], [-sine, cosine]]
    moved = {"1 m aside": aside, "turned by 2 degrees": turned}
    flow = flow_from_depth(far.depth_m, far.camera, far.world_from_cam, far.world_from_cam_prev)
    images = {
        "of another scene": far.depth_m,
        "of the same flight": near.depth_m,
        **{f"{px} px aside": depth[:, np.maximum(column - px, 0)] for px in (1, 2, 4, 8)},
        "left-right": depth[:, ::-1],
        "upside down": depth[::-1],
        "times 1.1": finite * 1.1,
        "times 1.5": finite * 1.5,
        "along the ray": finite * length,
    }
    return {
        "none": {},
        "rgb black": {"rgb": np.zeros_like(pair.rgb)},
        "rgb burnt out": {"rgb": np.full_like(pair.rgb, 255)},
        "rgb of another scene": {"rgb": far.rgb},
        "prev frozen": {"prev": pair.rgb},
        "rgb and prev exchanged": {"rgb": pair.prev, "prev": pair.rgb},
        **{f"depth {name}": {"depth_m": image} for name, image in images.items()},
        **{f"pose {n}": {"world_from_cam": pair.world_from_cam @ m} for n, m in moved.items()},
        "flow of another scene": {"flow": np.nan_to_num(flow), "visible": np.isfinite(depth)},
    }


def changed(pair: Pair, changes: dict) -> tuple[Pair, Pair]:
    """The pair with other images or another pose; and with a meta.json that fits them."""
    pose = changes.get("world_from_cam", pair.world_from_cam)
    images = {"flow": None, "seg": None, "normal": None, "depth_m": pair.depth_m} | changes
    images.pop("world_from_cam", None)
    depth_m = np.ascontiguousarray(saturate(images["depth_m"], pair.meta["max_depth_m"]))
    meta = {**pair.meta, "world_from_cam": pose.tolist()}
    filed = dataclasses.replace(pair, meta=meta, **images | {"depth_m": depth_m})
    velocity = (pose - pair.world_from_cam_prev)[:3, 3] / meta["dt_s"]
    fitting = {
        "nearest_depth_m": float(depth_m.min()),
        "median_depth_m": float(np.median(depth_m)),
        "in_range_share": float(np.mean(depth_m < np.float32(meta["max_depth_m"]))),
        "clearance_m": 0.0,
        "velocity_mps": velocity.tolist(),
        "speed_mps": float(np.linalg.norm(velocity)),
    } | dict(zip(("pitch_deg", "roll_deg"), pitch_roll_deg(pose), strict=True))
    return filed, dataclasses.replace(filed, meta=meta | fitting)


def damage(pairs: list[Pair], others: list[Pair], record, manifest, found, count: int) -> None:
    """Give some pairs of a shard every fault, and count in `found` what is found."""
    together = collections.defaultdict(list)
    for number in np.unique(np.linspace(0, len(pairs) - 1, count).astype(int)):
        pair, far = pairs[number], others[number % len(others)]
        flight = [p for p in pairs if p.meta["flight_index"] == pair.meta["flight_index"]]
        near = max(flight, key=lambda p: abs(p.meta["frame_index"] - pair.meta["frame_index"]))
        for name, changes in faulty(pair, near, far).items():
            render = {"render": {"modalities": ["flow"] if "flow" in changes else []}}
            asked = manifest | {"recipe": manifest["recipe"] | render}
            filed, rendered = (gate_pair(p, record, asked) for p in changed(pair, changes))
            together[name].append(rendered)
            found[name]["pairs"] += 1
            found[name]["in a file"] += any(check.fault for check in filed)
            found[name]["rendered"] += any(check.fault for check in rendered)
    for name, checks in together.items():
        found[name]["shards"] += 1
        alone = any(check.fault for of in checks for check in of)
        found[name]["together"] += alone or bool(gate_shard(checks))


def measure(options: Options) -> dict:
    """How many right pairs were judged, what was said against them, and what faults were found."""
    accused, judged, found = [], 0, collections.defaultdict(collections.Counter)
    for folder in options.folders:
        manifest, pairs = read_manifest(folder), []
        records = manifest["shards"]
        if len(records) < 2:
            raise DatasetError(f"{folder} has fewer than two shards")
        for record in records[:: -(-len(records) // options.shards)]:
            path, others = folder / record["path"], pairs
            members = shard_members(path)
            pairs = [decode_pair(key, read_members(path, files)) for key, files in members.items()]
            checks = [gate_pair(pair, record, manifest) for pair in pairs]
            judged += len(pairs)
            faults = [check.fault for of in (*checks, gate_shard(checks)) for check in of]
            accused += [f"{path}: {fault}" for fault in faults if fault]
        damage(pairs, others, record, manifest, found, options.pairs)
    return {"judged": judged, "accused": accused, "found": found}


def main(options: Options) -> int:
    try:
        figures = measure(options)
    except SynthdepthError as error:
        print(error, file=sys.stderr)
        return 2
    accused = figures["accused"]
    print(f"{figures['judged']} right pairs, {len(accused)} accused", *accused, sep="\n")
    print(f"{'fault':28}" + "".join(f"{column:>11}" for column in COLUMNS))
    for name, count in figures["found"].items():
        print(f"{name:28}" + "".join(f"{count[column]:11}" for column in COLUMNS))
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(tyro.cli(Options, description=__doc__)))
