"""One shard of a dataset, looked at: its checksum, its pairs, the gate."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

import cv2

from synthdepth.config import parse_json
from synthdepth.dataset.checksums import file_record
from synthdepth.dataset.exr import depth_header
from synthdepth.dataset.gate import gate_pair, gate_shard
from synthdepth.dataset.gate_check import Check
from synthdepth.dataset.pair import Pair, decode_pair
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.dataset.verify_damage import Fault, State, stale_shard


@dataclasses.dataclass(frozen=True, kw_only=True)
class Tally:
    """How often the checks of a subject were asked, a pair each.

    Attributes:
        judged: pairs with a verdict.
        silent: pairs without evidence.
        faults: pairs at fault.
    """

    judged: int = 0
    silent: int = 0
    faults: int = 0

    def __add__(self, other: "Tally") -> "Tally":
        return Tally(
            judged=self.judged + other.judged,
            silent=self.silent + other.silent,
            faults=self.faults + other.faults,
        )


@dataclasses.dataclass(frozen=True, kw_only=True)
class Looked:
    """What was seen of a shard.

    Attributes:
        state: the file; if its bytes are not those that were written, no pair is looked at.
        faults: of its pairs.
        keys: of its pairs.
        tallies: {subject: Tally}.
    """

    state: State
    faults: list[Fault]
    keys: list[str]
    tallies: dict[str, Tally]


def look_at_shard(folder: Path, manifest: Mapping, record: Mapping) -> Looked:
    """Check one shard that is there.

    Args:
        folder: the dataset.
        manifest: the dataset's.
        record: the shard's.
    """
    name = record["path"]
    path = Path(folder) / name
    found = file_record(path)
    if found["sha256"] != record["sha256"]:
        # Nothing in a damaged shard can be trusted, not even far enough to decode it.
        state = State(**found, stale=stale_shard(path, record, manifest))
        return Looked(state=state, faults=[], keys=[], tallies={})
    # Shards are looked at side by side, so a picture needs no threads of its own.
    threads = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        return _look_into(path, State(**found), manifest, record)
    finally:
        cv2.setNumThreads(threads)


def _look_into(path: Path, state: State, manifest: Mapping, record: Mapping) -> Looked:
    name = record["path"]
    try:
        members = shard_members(path)
    except ValueError as error:
        faults = [Fault(where=name, kind="gate", what=str(error))]
        return Looked(state=state, faults=faults, keys=[], tallies={})
    faults, judged, tallies = [], [], {}
    if len(members) != record["pairs"]:
        what = f"holds {len(members)} pairs, not {record['pairs']}"
        faults.append(Fault(where=name, kind="gate", what=what))
    for key, files in members.items():
        checks = pair_checks(key, read_members(path, files), record, manifest)
        judged.append(checks)
        for check in checks:
            if check.fault:
                faults.append(Fault(where=f"{name} {key}", kind="gate", what=check.fault))
        for subject in {check.subject for check in checks}:
            tally = _tally([check for check in checks if check.subject == subject])
            tallies[subject] = tallies.get(subject, Tally()) + tally
    for check in gate_shard(judged):
        faults.append(Fault(where=name, kind="gate", what=check.fault))
    return Looked(state=state, faults=faults, keys=list(members), tallies=tallies)


def pair_checks(
    key: str, files: Mapping[str, bytes], record: Mapping, manifest: Mapping
) -> list[Check]:
    """Every check of a pair, from its files' bytes.

    Args:
        key: the pair's.
        files: {suffix: bytes}.
        record: its shard's, of the manifest.
        manifest: the dataset's.
    """
    try:
        pair = decode_pair(key, files)
        header = _header_fault(pair, files["depth.exr"])
    except ValueError as error:
        return [Check(subject="contract", fault=str(error))]
    checks = gate_pair(pair, record, manifest)
    return [Check(subject="contract", fault=header), *checks] if header else checks


def _tally(checks: list[Check]) -> Tally:
    fault = any(check.fault for check in checks)
    judged = fault or any(check.effect is not None for check in checks)
    return Tally(judged=int(judged), silent=int(not judged), faults=int(fault))


def _header_fault(pair: Pair, data: bytes) -> str | None:
    """Where the header of depth.exr contradicts meta.json."""
    header = depth_header(data)
    try:
        same = (
            parse_json(header["intrinsics"]) == pair.meta["intrinsics"]
            and parse_json(header["worldFromCam"]) == pair.meta["world_from_cam"]
            and float(header["maxDepth"]) == pair.meta["max_depth_m"]
        )
    except (KeyError, ValueError, TypeError) as error:
        return f"the header of depth.exr lacks what the contract asks for ({error})"
    return None if same else "the header of depth.exr contradicts meta.json"
