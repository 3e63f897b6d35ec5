"""Where a dataset is written: a folder of this machine, or an address that fsspec knows.

Both keep the same promise: a file is there whole or not at all, and what is read back is what was
written. A folder gives it by partial files that are renamed, an object store by whole objects.
"""

import abc
import contextlib
import fcntl
import os
import platform
import urllib.parse
import urllib.request
from collections.abc import Callable, Iterator
from pathlib import Path

from synthdepth.dataset.manifest import DESCRIPTIONS, MANIFEST
from synthdepth.dataset.select import is_remote
from synthdepth.dataset.shard import PARTIAL, write_error
from synthdepth.errors import DatasetError

_SHARDS = ("train/*.tar", "test/*.tar")


class GoneError(DatasetError):
    """What a run has written is no longer where it was."""


class Storage(abc.ABC):
    """Where a dataset is written. Files are named by their path within the dataset.

    Attributes:
        place: the folder or the address.
    """

    place: Path | str

    @abc.abstractmethod
    def locked(self) -> contextlib.AbstractContextManager[None]:
        """Make the place, and keep other runs out of it where that can be.

        Raises:
            DatasetError: it cannot be written, or another run is writing to it.
        """

    @abc.abstractmethod
    def swept(self) -> contextlib.AbstractContextManager[None]:
        """Remove what killed runs left half written, before and after the block."""

    @abc.abstractmethod
    def workspace(self) -> contextlib.AbstractContextManager[Path]:
        """A folder of this machine to make files in; for a folder it is the folder itself."""

    @abc.abstractmethod
    def files(self) -> dict[str, int]:
        """The size [bytes] of everything that lies there, but for half-written files of ours."""

    @abc.abstractmethod
    def check(self) -> None:
        """Make sure that the dataset is still there.

        Raises:
            GoneError: its manifest is not.
        """

    @abc.abstractmethod
    def pull(self, work: Path, name: str) -> Path | None:
        """Have a file in the workspace; None if there is no such file."""

    @abc.abstractmethod
    def push(self, work: Path, name: str, alive: Callable[[], None] = lambda: None) -> None:
        """Have the workspace's file in the dataset, whole; calls `alive` while that takes time."""

    @abc.abstractmethod
    def remove(self, name: str) -> None:
        """Remove a file of the dataset."""

    @abc.abstractmethod
    def drop(self, work: Path, name: str) -> None:
        """Forget the workspace's copy of a file, if it is a copy."""


def storage_of(place: Path | str) -> Storage:
    """The storage of a folder, a `file://` address, or any other address that fsspec knows."""
    if isinstance(place, str) and place.startswith("file://"):
        place = Path(urllib.request.url2pathname(urllib.parse.urlparse(place).path))
    if isinstance(place, str) and is_remote(place):
        from synthdepth.production.remote import RemoteFolder

        return RemoteFolder(place)
    return LocalFolder(Path(place))


class LocalFolder(Storage):
    """A folder of this machine, or of a file system that several share."""

    def __init__(self, place: Path):
        self.place = place

    def __getstate__(self) -> dict:
        return {"place": Path(os.path.abspath(self.place))}  # A worker may start elsewhere.

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """Make the folder and keep other runs of this machine out of it."""
        try:
            self.place.mkdir(parents=True, exist_ok=True)
            handle = os.open(self.place, os.O_RDONLY)
        except OSError as error:
            raise write_error(self.place / MANIFEST, error) from error
        try:
            if not took_lock(handle):
                raise DatasetError(
                    f"another run is writing to {self.place}: wait for it or stop it"
                )
            yield
        finally:
            os.close(handle)

    @contextlib.contextmanager
    def swept(self) -> Iterator[None]:
        """Remove half-written files, before and after; only in a folder known to be ours."""
        try:
            self._sweep()
            yield
        finally:
            self._sweep()

    def _sweep(self) -> None:
        for partial in self._partials():
            partial.unlink(missing_ok=True)

    def _partials(self) -> set[Path]:
        patterns = (f"{name}.*{PARTIAL}" for name in (*DESCRIPTIONS, *_SHARDS))
        return {path for pattern in patterns for path in self.place.glob(pattern)}

    @contextlib.contextmanager
    def workspace(self) -> Iterator[Path]:
        """The folder itself."""
        yield self.place

    def files(self) -> dict[str, int]:
        """What lies in the folder and in the folders of its splits."""
        there = {*self.place.glob("*"), *self.place.glob("*/*.tar")} - self._partials()
        there -= {self.place / pattern.split("/")[0] for pattern in _SHARDS}
        sizes = {}
        for path in there:
            with contextlib.suppress(FileNotFoundError):
                sizes[path.relative_to(self.place).as_posix()] = path.lstat().st_size
        return sizes

    def check(self) -> None:
        """An empty mount point has no manifest either."""
        if not (self.place / MANIFEST).exists():
            raise GoneError(
                f"{self.place} was deleted, moved or unmounted while the run wrote to it: "
                f"{platform.node()} finds no {MANIFEST} there, and nothing was written since"
            )

    def pull(self, work: Path, name: str) -> Path | None:
        """The file itself."""
        return work / name if (work / name).exists() else None

    def push(self, work: Path, name: str, alive: Callable[[], None] = lambda: None) -> None:
        """Nothing to do: who writes into the folder writes whole files."""

    def remove(self, name: str) -> None:
        """Remove a file."""
        (self.place / name).unlink(missing_ok=True)

    def drop(self, work: Path, name: str) -> None:
        """Nothing to do: there are no copies."""


def took_lock(handle: int) -> bool:
    """Whether the lock of an open folder was free; it is ours until the folder is closed."""
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return False
    return True
