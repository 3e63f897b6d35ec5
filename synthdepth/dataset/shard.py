"""Shards: WebDataset tar files that exist whole or not at all, with the same bytes every time."""

import contextlib
import dataclasses
import errno
import hashlib
import io
import os
import platform
import re
import tarfile
from collections.abc import Iterator, Mapping
from pathlib import Path

from synthdepth.dataset.archive import entries, mapped
from synthdepth.errors import DatasetError

# Suffix of a file that is being written; whatever carries it may be deleted.
PARTIAL = ".partial"
# A pair's key becomes a file's name.
_KEY = re.compile(r"[A-Za-z0-9_-]+")
# An archive ends in two blocks of zeros, and is padded with more to a whole record.
_TAR_END, _TAR_RECORD = 2 * 512, 10_240


def partial_of(path: Path) -> Path:
    """Where this process writes a file before it gets its name; no other process does, anywhere."""
    return path.with_name(f"{path.name}.{platform.node()}-{os.getpid()}{PARTIAL}")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Member:
    """Where a file of a pair lies in its shard.

    Attributes:
        offset: first byte of the file's content.
        size: number of bytes.
    """

    offset: int
    size: int


class _HashingFile:
    """A binary file that hashes what is written; tar archives are written front to back."""

    def __init__(self, file):
        self._file, self.sha256, self.size = file, hashlib.sha256(), 0

    def write(self, data) -> int:
        self.sha256.update(data)
        self.size += len(data)
        return self._file.write(data)

    def tell(self) -> int:
        return self.size


class ShardWriter:
    """Writes one shard; use as a context manager.

    The file gets its name when the block ends without an error: until then the bytes are in a
    partial file beside it, which is removed if the block fails. Then `sha256` and `size` hold.

    Args:
        path: where the shard will be.

    Raises:
        DatasetError: the disk is full or the folder cannot be written.
    """

    def __init__(self, path: Path):
        self.path = Path(path)
        self._partial = partial_of(self.path)
        self.sha256, self.size = "", 0

    def __enter__(self) -> "ShardWriter":
        with _naming(self.path):
            self.path.parent.mkdir(parents=True, exist_ok=True)
            self._file = open(self._partial, "wb")
            self._hashing = _HashingFile(self._file)
            self._tar = tarfile.open(fileobj=self._hashing, mode="w|", format=tarfile.USTAR_FORMAT)
        return self

    def add(self, key: str, members: Mapping[str, bytes]) -> None:
        """Append one pair; its members go in sorted."""
        with _naming(self.path):
            for suffix in sorted(members):
                info = tarfile.TarInfo(f"{key}.{suffix}")
                info.size, info.mode, info.mtime = len(members[suffix]), 0o444, 0
                info.uid = info.gid = 0
                info.uname = info.gname = "synthdepth"
                self._tar.addfile(info, io.BytesIO(members[suffix]))

    def __exit__(self, kind, error, trace) -> None:
        try:
            if kind is None:
                with _naming(self.path):
                    self._tar.close()
                    self._file.flush()
                    os.fsync(self._file.fileno())
                    self._file.close()
                    os.replace(self._partial, self.path)
                    sync_folder(self.path.parent)
                self.sha256, self.size = self._hashing.sha256.hexdigest(), self._hashing.size
        finally:
            # On a full disk closing fails again; what is told is the first failure.
            for file in (self._tar, self._file):
                with contextlib.suppress(OSError, ValueError):
                    file.close()
            self._partial.unlink(missing_ok=True)


@contextlib.contextmanager
def _naming(path: Path) -> Iterator[None]:
    """Turns the operating system's refusals into one line that names the file."""
    try:
        yield
    except OSError as error:
        raise write_error(path, error) from error


def write_error(path: Path, error: OSError) -> DatasetError:
    """What to tell a user whose disk or folder refused a write."""
    if error.errno == errno.ENOSPC:
        return DatasetError(f"the disk of {path.parent} is full: free space, then run again")
    return DatasetError(f"cannot write {path}: {error.strerror or error}")


def sync_folder(folder: Path) -> None:
    """Make a rename in `folder` survive a power cut."""
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_whole(path: Path, data: bytes) -> None:
    """Write a small file so that it is there whole or, after a kill, as it was before."""
    partial = partial_of(path)
    try:
        with open(partial, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
        sync_folder(path.parent)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise write_error(path, error) from error


def shard_members(path: Path) -> dict[str, dict[str, Member]]:
    """Where every file of a shard lies: {key: {suffix: Member}}, in the shard's order.

    Raises:
        ValueError: not a whole tar archive, or an entry that is no plain file of a pair.
    """
    pairs: dict[str, dict[str, Member]] = {}
    try:
        with open(path, "rb") as file, tarfile.open(None, "r:", mapped(file)) as tar:
            for info in entries(tar):
                key, dot, suffix = info.name.partition(".")
                if not info.isreg() or "/" in suffix or not dot or not _KEY.fullmatch(key):
                    raise ValueError(f"{path.name} holds {info.name!r}, which is no file of a pair")
                member = Member(offset=info.offset_data, size=info.size)
                if suffix in pairs.setdefault(key, {}):
                    raise ValueError(f"{path.name} holds {info.name} twice")
                pairs[key][suffix] = member
            _check_end(path, tar.offset)
    except (tarfile.TarError, EOFError, OSError, OverflowError, RecursionError) as error:
        raise ValueError(f"{path.name} is no readable tar archive ({error})") from error
    return pairs


def _check_end(path: Path, end: int) -> None:
    """Refuse an archive that does not end where its last entry does, with two blocks of zeros.

    `tarfile` takes a damaged header for the end, and what lies behind it would be lost unnoticed.
    """
    with open(path, "rb") as file:
        file.seek(end)
        rest = file.read(_TAR_END + _TAR_RECORD)
    if not _TAR_END <= len(rest) < _TAR_END + _TAR_RECORD or any(rest):
        raise ValueError(f"{path.name} is broken at byte {end}: no entry is there, and no end")


def read_members(path: Path, members: Mapping[str, Member]) -> dict[str, bytes]:
    """The bytes of one pair's files, {suffix: bytes}.

    Raises:
        ValueError: one ends behind the shard's end.
    """
    with open(path, "rb") as file:
        end, content = os.fstat(file.fileno()).st_size, {}
        for suffix, member in members.items():
            if member.offset + member.size > end:
                raise ValueError(f"{path.name} ends before its {suffix} does")
            file.seek(member.offset)
            content[suffix] = file.read(member.size)
    return content


def sha256_of(path: Path) -> str:
    """Hex digest of a file."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
