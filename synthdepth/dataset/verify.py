"""Checking a dataset folder from its files alone."""

import dataclasses
import functools
import hashlib
import multiprocessing
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from synthdepth.dataset.checksums import Settled, file_record, settle
from synthdepth.dataset.gate_check import SUBJECTS
from synthdepth.dataset.gate_contract import pair_problems
from synthdepth.dataset.manifest import (
    CHECKSUMS,
    DESCRIPTIONS,
    INDEX,
    MANIFEST,
    read_index,
)
from synthdepth.dataset.verify_damage import Fault, State, file_faults, is_leftover
from synthdepth.dataset.verify_shard import Looked, Tally, look_at_shard
from synthdepth.errors import DatasetError, SynthdepthError

__all__ = ["Fault", "VerifyReport", "pair_problems", "verify"]


@dataclasses.dataclass(frozen=True, kw_only=True)
class VerifyReport:
    """What `verify` found.

    Attributes:
        shards: shards looked at.
        pairs: pairs decoded.
        bytes: of all files.
        faults: empty where all is well.
        notes: what a reader should know that is no fault.
        checks: for each subject of the gate how many pairs it judged, had no evidence for, and
            found at fault.
    """

    shards: int
    pairs: int
    bytes: int
    faults: list[Fault]
    notes: list[str]
    checks: dict[str, Tally]


def verify(
    folder: Path,
    *,
    workers: int = 1,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> VerifyReport:
    """Check checksums, counts, decoding, the contract, and ground truth that agrees with itself.

    Args:
        folder: the dataset.
        workers: processes; with 1 it all happens in this one.
        on_progress: called with (pairs done, pairs in all).

    Raises:
        SynthdepthError: there is no manifest to check against, nor a copy of it; or `workers` is
            out of bounds.
    """
    if not 1 <= workers <= 1024:
        raise SynthdepthError(f"--workers {workers}: allowed is a whole number from 1 to 1024")
    folder = Path(folder)
    settled = settle(folder)
    manifest, records = settled.manifest, settled.manifest["shards"]
    here = {p.relative_to(folder).as_posix(): p for p in folder.rglob("*") if p.is_file()}
    present = [record for record in records if record["path"] in here]
    done, total = 0, sum(record["pairs"] for record in present)
    looked: dict[str, Looked] = {}
    on_progress(done, total)
    look = functools.partial(look_at_shard, folder, manifest)
    for record, one in zip(present, _side_by_side(look, present, workers), strict=True):
        looked[record["path"]] = one
        done += record["pairs"]
        on_progress(done, total)

    expected = _expected(folder, settled)
    states = {name: one.state for name, one in looked.items()}
    for name in sorted(here.keys() - states.keys()):
        states[name] = _state(here[name], name, expected)
    faults = [*_manifest_faults(manifest), *file_faults(expected, states)]
    faults += [fault for one in looked.values() for fault in one.faults]
    homes, doubled = _homes(looked)
    faults += doubled
    if INDEX in here and not faults:
        faults += _index_faults(folder, homes)
    return VerifyReport(
        shards=len(present),
        pairs=len(homes),
        bytes=sum(state.bytes for state in states.values()),
        faults=faults,
        notes=_notes(settled),
        checks=_summed(one.tallies for one in looked.values()),
    )


def _side_by_side(look: Callable, records: Sequence, workers: int) -> Iterator[Looked]:
    """What is seen of the shards, in their order, from as many processes."""
    workers = min(workers, len(records))
    if workers <= 1:
        yield from map(look, records)
        return
    # Not threads: decoding EXR and half of the gate hold the interpreter's lock.
    context = multiprocessing.get_context("spawn")
    try:
        with ProcessPoolExecutor(workers, mp_context=context) as pool:
            yield from pool.map(look, records)
    except BrokenProcessPool as error:
        raise DatasetError("a worker process died, perhaps for lack of memory") from error


def _expected(folder: Path, settled: Settled) -> dict[str, Mapping]:
    """Size and checksum of every file that belongs into the folder."""
    manifest, expected = settled.manifest, {}
    if settled.sealed:
        for name, right in settled.right.items():
            expected[name] = {"bytes": len(right), "sha256": hashlib.sha256(right).hexdigest()}
        expected |= manifest["files"]
    else:
        # Nothing tells what these should hold: what is there counts as right.
        known = [name for name in DESCRIPTIONS if name != CHECKSUMS]
        names = known if manifest["complete"] else [MANIFEST]
        for name in names:
            path = folder / name
            expected[name] = file_record(path) if path.is_file() else {"bytes": 0, "sha256": "?"}
    return expected | {record["path"]: record for record in manifest["shards"]}


def _state(path: Path, name: str, expected: Mapping[str, Mapping]) -> State:
    """A file that is no shard of the manifest's; its checksum where it may be one under a name."""
    size = path.stat().st_size
    sizes = {record["bytes"] for record in expected.values()}
    if name not in expected and (size not in sizes or is_leftover(name)):
        return State(bytes=size, sha256="")
    return State(**file_record(path))


def _manifest_faults(manifest: Mapping) -> list[Fault]:
    """Where the manifest says that the run has not finished, or contradicts itself."""
    records, faults = manifest["shards"], []

    def fault(kind: str, what: str, where: str = MANIFEST) -> None:
        faults.append(Fault(where=where, kind=kind, what=what))

    if not manifest["complete"]:
        fault("unfinished", "the run has not finished: the same command goes on")
    splits = Counter()
    for record in records:
        splits[record["split"]] += record["pairs"]
    if manifest["complete"] and dict(splits) != {k: n for k, n in manifest["splits"].items() if n}:
        fault("manifest", f"counts {manifest['splits']} pairs, its shards {dict(splits)}")
    scenes: dict[int, str] = {}
    for record in records:
        if scenes.setdefault(record["scene_seed"], record["split"]) != record["split"]:
            fault("manifest", "its scene is in both splits", record["path"])
    return faults


def _homes(looked: Mapping[str, Looked]) -> tuple[dict[str, str], list[Fault]]:
    """The shard of every pair, and the pairs that have two."""
    homes: dict[str, str] = {}
    doubled = []
    for name, one in looked.items():
        for key in one.keys:
            if key in homes:
                what = f"{key} is also in {homes[key]}"
                doubled.append(Fault(where=name, kind="manifest", what=what))
            homes[key] = name
    return homes, doubled


def _index_faults(folder: Path, homes: Mapping[str, str]) -> list[Fault]:
    """Where the index and the shards disagree."""
    try:
        table = read_index(folder, ["key", "shard"]).to_pydict()
    except DatasetError as error:
        return [Fault(where=INDEX, kind="damaged", what=str(error))]
    indexed = dict(zip(table["key"], table["shard"], strict=True))
    lost = [key for key in homes if indexed.get(key) != homes[key]]
    extra = [key for key in indexed if key not in homes]
    words = {"lacks {} pairs, {} first": lost, "lists {} pairs that do not exist, {} first": extra}
    return [
        Fault(where=INDEX, kind="stale", what=text.format(len(keys), keys[0]))
        for text, keys in words.items()
        if keys
    ]


def _notes(settled: Settled) -> list[str]:
    if settled.sealed or not settled.manifest["complete"]:
        return []
    return [
        f"this dataset is older than {CHECKSUMS}: its shards are checked, of its other files only "
        "that they are there (verify --repair writes the checksums)"
    ]


def _summed(many: Iterator[Mapping[str, Tally]]) -> dict[str, Tally]:
    total = dict.fromkeys(SUBJECTS, Tally())
    for tallies in many:
        for name, tally in tallies.items():
            total[name] += tally
    return total
