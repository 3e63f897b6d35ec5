"""`checksums.sha256`: the checksum of every file of a dataset, and the manifest once more.

`sha256sum -c checksums.sha256` reads it. Its comment holds the manifest, so that each of the two
files can be written anew from the other: the manifest knows every checksum but its own, which this
file knows.
"""

import dataclasses
import hashlib
import json
from collections.abc import Mapping
from pathlib import Path

from synthdepth.config import parse_json
from synthdepth.dataset.contract import check_manifest
from synthdepth.dataset.manifest import CHECKSUMS, DERIVED, MANIFEST, manifest_bytes
from synthdepth.dataset.shard import sha256_of, write_whole
from synthdepth.errors import DatasetError

_HEAD = "# Every file of this dataset; sha256sum -c checksums.sha256 checks them.\n"
_MANIFEST_COMMENT = "# dataset.json: "


def file_record(path: Path) -> dict:
    """Size and checksum of a file, as the manifest has them: {"bytes": ..., "sha256": ...}."""
    return {"bytes": path.stat().st_size, "sha256": sha256_of(path)}


def with_files(folder: Path, manifest: Mapping) -> dict:
    """A manifest that also knows the files that were made of it, and that there are checksums."""
    return {**manifest, "files": {name: file_record(Path(folder) / name) for name in DERIVED}}


def write_checksums(folder: Path, manifest: Mapping) -> None:
    """Write `checksums.sha256` for a manifest, which has to have `files`."""
    write_whole(Path(folder) / CHECKSUMS, checksums_bytes(manifest))


def checksums_bytes(manifest: Mapping) -> bytes:
    """The bytes of `checksums.sha256`, which are a function of the manifest."""
    sums = {MANIFEST: _sha256(manifest_bytes(manifest))}
    sums |= {name: record["sha256"] for name, record in manifest["files"].items()}
    sums |= {record["path"]: record["sha256"] for record in manifest["shards"]}
    text = json.dumps(manifest, separators=(",", ":"))
    lines = "".join(f"{digest}  {name}\n" for name, digest in sums.items())
    return f"{_HEAD}{_MANIFEST_COMMENT}{text}\n{lines}".encode()


@dataclasses.dataclass(frozen=True, kw_only=True)
class Settled:
    """The manifest that a folder's two copies of it agree on.

    Attributes:
        manifest: what the dataset is.
        right: {name: bytes} of what `dataset.json` and `checksums.sha256` should hold, if it is.
        sealed: whether the manifest is known to be whole; not in an older dataset, nor in one that
            is being written.
    """

    manifest: dict
    right: Mapping[str, bytes]
    sealed: bool


def settle(folder: Path) -> Settled:
    """Find out what a dataset is, though `dataset.json` or `checksums.sha256` may be damaged.

    Raises:
        DatasetError: there is no dataset, or nothing whole to know it by.
    """
    folder = Path(folder)
    data, sums = (_read(folder / name) for name in (MANIFEST, CHECKSUMS))
    if data is None and sums is None:
        raise DatasetError(f"{folder} holds no dataset: there is no {MANIFEST}")
    # Somebody may have exchanged the two.
    settled = _settled(data, sums) or _settled(sums, data)
    if settled is None:
        raise DatasetError(
            f"{folder}: both {MANIFEST} and {CHECKSUMS} are damaged or missing, so that nothing "
            "tells what the dataset is: one of them has to come from a copy"
        )
    return settled


def _settled(data: bytes | None, sums: bytes | None) -> Settled | None:
    """What `dataset.json` and `checksums.sha256` tell together; None where it is not enough."""
    manifest, (copy, digest) = _parsed(data), _copy_and_digest(sums)
    # Older than the checksums, or not finished: then checksums tell of another state.
    unsealed = manifest is not None and "files" not in manifest
    if unsealed and (sums is None or not manifest["complete"]):
        return Settled(manifest=manifest, right={}, sealed=False)
    by_manifest, by_copy = _both(manifest), _both(copy)
    if by_manifest and (
        digest == _sha256(data) or copy == manifest or (copy is None and digest is None)
    ):
        return Settled(manifest=manifest, right=by_manifest, sealed=True)
    if by_copy and digest == _sha256(by_copy[MANIFEST]):
        return Settled(manifest=copy, right=by_copy, sealed=True)
    return None


def _read(path: Path) -> bytes | None:
    try:
        return path.read_bytes()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror or error}") from error


def _sha256(data: bytes) -> str:
    return hashlib.sha256(data).hexdigest()


def _parsed(data: bytes | None) -> dict | None:
    """The manifest of these bytes, if they are one."""
    try:
        manifest = parse_json(data or b"")
        check_manifest(manifest)
        return manifest
    except ValueError:
        return None


def _both(manifest: dict | None) -> dict[str, bytes] | None:
    """What both files hold by a manifest; None where it lacks what belongs into them."""
    try:
        return {MANIFEST: manifest_bytes(manifest), CHECKSUMS: checksums_bytes(manifest)}
    except (KeyError, TypeError, AttributeError):
        return None


def _copy_and_digest(sums: bytes | None) -> tuple[dict | None, str | None]:
    """The manifest that stands in `checksums.sha256`, and the checksum of `dataset.json`."""
    copy = digest = None
    for line in (sums or b"").decode(errors="replace").splitlines():
        if line.startswith(_MANIFEST_COMMENT):
            copy = _parsed(line.removeprefix(_MANIFEST_COMMENT).encode())
        elif line.endswith(f"  {MANIFEST}"):
            digest = line.split()[0]
    return copy, digest
