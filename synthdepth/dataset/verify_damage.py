"""What a file is that is not the one that should be there: names for every kind of damage."""

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from synthdepth.dataset.manifest import DESCRIPTIONS, pair_files
from synthdepth.dataset.pair import SPLITS, decode_meta
from synthdepth.dataset.shard import PARTIAL, read_members, shard_members

# Where `repair` makes files before they get their place.
REPAIR = f"repair{PARTIAL}"


@dataclasses.dataclass(frozen=True, kw_only=True)
class Fault:
    """Something that is wrong.

    Attributes:
        where: the file, and the pair if it is one pair's.
        kind: "missing", "truncated", "damaged" (the same size, other bytes), "grown", "swapped",
            "duplicate", "misplaced", "foreign" (of another dataset), "stale" (of another recipe,
            seed or length), "leftover" (of a kill), "stranger" (no file of a dataset),
            "unfinished", "manifest" (it contradicts itself), or "gate" (its content is wrong).
        what: in one line.
    """

    where: str
    kind: str
    what: str


@dataclasses.dataclass(frozen=True, kw_only=True)
class State:
    """A file as it is.

    Attributes:
        bytes: its size.
        sha256: its checksum.
        stale: what its content says that it is instead, as (kind, words); None where it says
            nothing.
    """

    bytes: int
    sha256: str
    stale: tuple[str, str] | None = None


def file_faults(expected: Mapping[str, Mapping], there: Mapping[str, State]) -> list[Fault]:
    """Every file that is not what it should be, named.

    Args:
        expected: {path: {"bytes": ..., "sha256": ...}} of all files that belong here.
        there: the files that are here. Of a file that belongs to nobody, `sha256` may be "".
    """
    home = {record["sha256"]: name for name, record in expected.items()}
    faults = []
    for name, record in expected.items():
        state = there.get(name)
        if state is None:
            faults.append(Fault(where=name, kind="missing", what="is missing"))
        elif state.sha256 != record["sha256"]:
            kind, what = _instead(name, record, state, home.get(state.sha256), expected, there)
            faults.append(Fault(where=name, kind=kind, what=what))
    for name in sorted(there.keys() - expected.keys()):
        if is_leftover(name):
            kind, what = "leftover", "is left over from a run that was killed"
        elif there[name].sha256 in home:
            kind, what = "misplaced", f"is {home[there[name].sha256]} under another name"
        else:
            kind, what = "stranger", "does not belong here"
        faults.append(Fault(where=name, kind=kind, what=what))
    return faults


def is_leftover(name: str) -> bool:
    """Whether a path in a dataset's folder is one that only a killed run or repair leaves."""
    if name.startswith(f"{REPAIR}/"):
        return True
    ours = any(name.startswith(f"{known}.") for known in DESCRIPTIONS)
    in_a_split = name.startswith(tuple(f"{split}/" for split in SPLITS)) and ".tar." in name
    return name.endswith(PARTIAL) and (ours or in_a_split)


def _instead(name, record, state, other, expected, there) -> tuple[str, str]:
    """What a file with the wrong bytes is."""
    if other is not None:
        at_home = there.get(other)
        if at_home is not None and at_home.sha256 == expected[other]["sha256"]:
            return "duplicate", f"is a copy of {other}"
        return "swapped", f"is {other}"
    if state.stale is not None:
        return state.stale
    short = record["bytes"] - state.bytes
    if short > 0:
        return "truncated", f"is truncated: {state.bytes} of {record['bytes']} bytes"
    if short < 0:
        return "grown", f"has {-short} bytes more than were written"
    return "damaged", "is damaged: not the bytes that were written (sha256 differs)"


def stale_shard(path: Path, record: Mapping, manifest: Mapping) -> tuple[str, str] | None:
    """What a shard with other bytes than its record's says of itself: (kind, words), or None.

    It is believed only where its first and its last pair say the same: a flipped bit is in one.
    """
    try:
        pairs = list(shard_members(path).values())
        ends = [read_members(path, files) for files in (pairs[0], pairs[-1])]
        told = [_strangeness(files, record, manifest) for files in ends]
    except (OSError, ValueError, KeyError, IndexError, TypeError):
        return None
    if told[0] is not None and told[0] == told[1]:
        return told[0]
    if len(pairs) != record["pairs"] and told == [None, None]:
        return "stale", f"holds {len(pairs)} pairs, not {record['pairs']}: another state of it"
    return None


def _strangeness(
    files: Mapping[str, bytes], record: Mapping, manifest: Mapping
) -> tuple[str, str] | None:
    """What the files of a pair say that is not of the shard."""
    recipe, meta = manifest["recipe"], decode_meta(files["meta.json"])
    if meta["map"] != manifest["map"]:
        return "foreign", f"is of the map {meta['map']}, not of this dataset"
    if meta["scene_seed"] != record["scene_seed"]:
        for other in manifest["shards"]:
            if other["scene_seed"] == meta["scene_seed"]:
                return "swapped", f"holds the scene of {other['path']}, in other bytes"
        return "stale", f"is of another seed: its scene is {meta['scene_seed']}"
    expected = {
        "width": (meta["width"], recipe["camera"]["width"]),
        "height": (meta["height"], recipe["camera"]["height"]),
        "max_depth_m": (meta["max_depth_m"], recipe["render"]["max_depth_m"]),
        "spp": (meta["spp"], recipe["render"].get("spp", meta["spp"])),
        "files": (sorted(files), sorted(pair_files(manifest))),
    }
    for name, (have, want) in expected.items():
        if have != want:
            return "stale", f"is of another recipe: {name} is {have}, the dataset's is {want}"
    return None
