"""Damages a small rendered dataset in every way, one at a time: found, named, repaired?

python tools/corruption_harness.py --flips 1000 --others 200 --json corruption.json

Random single-bit flips and random truncations, deletions, swaps, copies and the like are spread
evenly over the kinds of file: manifest, index, card, picture, Croissant, checksums, shards. After
each, `verify` has to find the damaged file and to name its kind, and `repair` has to give every
file its original bytes back; shards it renders again, of a plain map.
"""

import collections
import dataclasses
import json
import shutil
import tempfile
from pathlib import Path

import numpy as np
import tyro
from plain_map import plain_recipe

from synthdepth.dataset.manifest import DESCRIPTIONS, read_manifest
from synthdepth.dataset.shard import PARTIAL, ShardWriter, read_members, shard_members
from synthdepth.dataset.verify import verify
from synthdepth.errors import DatasetError
from synthdepth.production.repair import repair
from synthdepth.production.run import render_dataset
from synthdepth.seeding import lane

COLUMNS = {"times": 7, "found": 7, "named": 7, "rendered": 10, "repaired": 10}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to do to a dataset.

    Attributes:
        flips: single bits flipped.
        others: truncations, deletions, swaps, copies, additions.
        seed: what is damaged, and how.
        json: where the figures go.
    """

    flips: int = 30
    others: int = 20
    seed: int = 0
    json: Path | None = None


@dataclasses.dataclass(frozen=True, kw_only=True)
class Damage:
    """Something done to a folder.

    Attributes:
        what: e.g. "flip".
        files: that are not what they were; `verify` has to name them all.
        kinds: the names that it may give them.
    """

    what: str
    files: tuple[str, ...]
    kinds: tuple[str, ...]


def flip(rng: np.random.Generator, folder: Path, name: str, _) -> Damage:
    """Flip one bit."""
    data = bytearray((folder / name).read_bytes())
    at = int(rng.integers(8 * len(data)))
    data[at // 8] ^= 1 << at % 8
    (folder / name).write_bytes(data)
    return Damage(what="flip", files=(name,), kinds=("damaged",))


def truncate(rng: np.random.Generator, folder: Path, name: str, _) -> Damage:
    """Cut the end off, as much as may be."""
    data = (folder / name).read_bytes()
    (folder / name).write_bytes(data[: int(rng.integers(len(data)))])
    return Damage(what="truncate", files=(name,), kinds=("truncated",))


def delete(rng: np.random.Generator, folder: Path, name: str, _) -> Damage:
    """Remove a file."""
    (folder / name).unlink()
    return Damage(what="delete", files=(name,), kinds=("missing",))


def swap(rng: np.random.Generator, folder: Path, name: str, other: str) -> Damage:
    """Exchange two files."""
    first, second = (folder / name).read_bytes(), (folder / other).read_bytes()
    (folder / name).write_bytes(second)
    (folder / other).write_bytes(first)
    return Damage(what="swap", files=(name, other), kinds=("swapped",))


def duplicate(rng: np.random.Generator, folder: Path, name: str, other: str) -> Damage:
    """Write a file over another."""
    shutil.copyfile(folder / other, folder / name)
    return Damage(what="duplicate", files=(name,), kinds=("duplicate",))


def rename(rng: np.random.Generator, folder: Path, name: str, _) -> Damage:
    """Give a file a name of nobody's."""
    (folder / name).rename(folder / f"{name}.bak")
    return Damage(what="rename", files=(name, f"{name}.bak"), kinds=("missing", "misplaced"))


def append(rng: np.random.Generator, folder: Path, name: str, _) -> Damage:
    """Write more behind the end."""
    with open(folder / name, "ab") as file:
        file.write(rng.bytes(int(rng.integers(1, 2000))))
    return Damage(what="append", files=(name,), kinds=("grown",))


def leave_behind(rng: np.random.Generator, folder: Path, name: str, _) -> Damage:
    """Leave half of a file, as a kill does."""
    left = f"{name}.node-1{PARTIAL}"
    (folder / left).write_bytes((folder / name).read_bytes()[:1000])
    return Damage(what="leave behind", files=(left,), kinds=("leftover",))


def make_stale(rng: np.random.Generator, folder: Path, name: str, _) -> Damage:
    """Put what an older seed gave into a shard's place."""
    records = read_manifest(folder)["shards"]
    record = records[int(rng.integers(len(records)))]
    path = folder / record["path"]
    pairs = {key: read_members(path, files) for key, files in shard_members(path).items()}
    with ShardWriter(path) as shard:
        for key, files in pairs.items():
            meta = json.loads(files["meta.json"]) | {"scene_seed": record["scene_seed"] + 1}
            shard.add(key, files | {"meta.json": json.dumps(meta).encode()})
    return Damage(what="stale", files=(record["path"],), kinds=("stale",))


OTHERS = (truncate, swap, delete, duplicate, rename, append, leave_behind, make_stale)


def main(options: Options) -> int:
    with tempfile.TemporaryDirectory() as scratch:
        figures = measure(options, Path(scratch))
    print(f"{'damage':14}" + "".join(f"{name:>{width}}" for name, width in COLUMNS.items()))
    for what, counts in figures["damages"].items():
        print(f"{what:14}" + "".join(f"{counts.get(k, 0):>{w}}" for k, w in COLUMNS.items()))
    for miss in figures["missed"]:
        print(miss)
    if options.json:
        options.json.write_text(json.dumps(figures, indent=1) + "\n")
    return 1 if figures["missed"] else 0


def measure(options: Options, scratch: Path) -> dict:
    """Do it all; the figures by damage, and what was missed."""
    whole = scratch / "whole"
    render_dataset(plain_recipe(2, modalities=("flow", "seg", "normal")), whole, pairs=6)
    assert not verify(whole).faults
    original = {p.relative_to(whole).as_posix(): p.read_bytes() for p in files_of(whole)}
    shards = [name for name in original if name.endswith(".tar")]
    kinds = [*([name] for name in DESCRIPTIONS), shards]
    counts = collections.defaultdict(collections.Counter)
    missed, every = [], options.flips + options.others
    for number in range(every):
        rng = lane(options.seed, "damage", number)
        way = flip if number < options.flips else OTHERS[(number - options.flips) % len(OTHERS)]
        kind = kinds[int(rng.integers(len(kinds)))]
        name = kind[int(rng.integers(len(kind)))]
        other = str(rng.permutation([one for one in original if one != name])[0])
        damage = way(rng, whole, name, other)
        count = counts[damage.what]
        count["times"] += 1
        faults, told = [], {}
        try:
            faults = verify(whole).faults
            told = {fault.where: fault.kind for fault in faults}
        except DatasetError as error:
            missed.append(f"{damage}: {error}")
        found = all(name in told for name in damage.files)
        named = found and all(told[name] in damage.kinds for name in damage.files)
        count["found"] += found
        count["named"] += named
        if not named:
            missed.append(f"{damage}: told {told}")
        repairs = repair(whole, faults)
        count["rendered"] += any("rendered again" in one.what for one in repairs)
        now = {p.relative_to(whole).as_posix(): p.read_bytes() for p in files_of(whole)}
        count["repaired"] += now == original
        if now != original:
            names = sorted(now.keys() | original.keys())
            wrong = [name for name in names if now.get(name) != original.get(name)]
            missed.append(f"{damage}: not repaired: {wrong}: {repairs}")
        for path in files_of(whole):
            if path.relative_to(whole).as_posix() not in original:
                path.unlink()
        for name, data in original.items():
            (whole / name).write_bytes(data)
        if (number + 1) % 50 == 0:
            print(f"{number + 1} of {every} damages, missed {len(missed)}", flush=True)
    return {"damages": {what: dict(count) for what, count in counts.items()}, "missed": missed}


def files_of(folder: Path) -> list[Path]:
    """Every file below a folder."""
    return [path for path in folder.rglob("*") if path.is_file()]


if __name__ == "__main__":
    raise SystemExit(main(tyro.cli(Options, description=__doc__)))
