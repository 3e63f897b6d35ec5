"""A dataset at an address that fsspec knows, made in workspaces on this machine."""

import contextlib
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from synthdepth.dataset.manifest import MANIFEST
from synthdepth.dataset.select import within
from synthdepth.dataset.shard import PARTIAL, write_error
from synthdepth.errors import DatasetError
from synthdepth.production.storage import Storage, took_lock

# Seconds between the tries of what a network refuses, a minute in all; fsspec's own come on top.
_PAUSES_S = (1.0, 2.0, 4.0, 8.0, 16.0, 32.0)


class RemoteFolder(Storage):
    """An address that fsspec knows, such as `s3://bucket/folder`: an object store, as a rule.

    Nothing keeps two runs from writing to one address. If both were given the same arguments they
    write the same bytes.
    """

    def __init__(self, place: str):
        self.place = place.rstrip("/")
        self._kept: tuple[Any, str] | None = None

    def __getstate__(self) -> dict:
        return {"place": self.place, "_kept": None}  # Connections are a process's own.

    @property
    def _system(self) -> tuple[Any, str]:
        """The file system, and the folder's path in it."""
        if self._kept is None:
            import fsspec

            try:
                self._kept = fsspec.core.url_to_fs(self.place)
            except (ImportError, ValueError) as error:
                raise DatasetError(f"{self.place} cannot be used: {error}") from error
        return self._kept

    @contextlib.contextmanager
    def locked(self) -> Iterator[None]:
        """An object store has neither folders nor locks, but it must answer."""
        system, root = self._system
        with contextlib.suppress(FileNotFoundError):
            self._patiently(MANIFEST, lambda: system.info(within(root, MANIFEST)), pauses_s=())
        yield

    @contextlib.contextmanager
    def swept(self) -> Iterator[None]:
        """Objects are whole; what may be left is in the workspaces of killed workers."""
        try:
            yield
        finally:
            with _workspaces() as root:
                _remove_abandoned(root)

    @contextlib.contextmanager
    def workspace(self) -> Iterator[Path]:
        """A temporary folder."""
        with _own_workspace() as work:
            yield work

    def files(self) -> dict[str, int]:
        """What lies at the address."""
        system, root = self._system

        def find() -> dict[str, int]:
            system.invalidate_cache()
            found = system.find(root, detail=True)
            start = len(root.rstrip("/")) + 1
            return {name[start:]: info["size"] for name, info in found.items()}

        try:
            return self._patiently(self.place, find)
        except FileNotFoundError:
            return {}

    def check(self) -> None:
        """Nothing to do: writing to what is gone fails."""

    def pull(self, work: Path, name: str) -> Path | None:
        """Fetch a file, unless the workspace has it."""
        system, root = self._system
        path = work / name
        if path.exists():
            return path
        path.parent.mkdir(parents=True, exist_ok=True)
        partial = path.with_name(path.name + PARTIAL)
        try:
            self._patiently(name, lambda: system.get_file(within(root, name), str(partial)))
        except FileNotFoundError:
            partial.unlink(missing_ok=True)
            return None
        return partial.rename(path)

    def push(self, work: Path, name: str, alive: Callable[[], None] = lambda: None) -> None:
        """Put a file as one object, and ask for its size."""
        from fsspec.callbacks import Callback

        class Sign(Callback):
            def relative_update(self, inc: int = 1) -> None:
                alive()

        system, root = self._system
        path, there = work / name, within(root, name)

        def put() -> None:
            alive()
            system.put_file(str(path), there, callback=Sign())
            system.invalidate_cache()
            size = system.info(there)["size"]
            if size != path.stat().st_size:
                raise OSError(f"{size} bytes of {path.stat().st_size} arrived")

        try:
            self._patiently(name, put)
        except FileNotFoundError as error:
            raise DatasetError(f"cannot write {self.place}/{name}: {error}") from error

    def remove(self, name: str) -> None:
        """Remove an object."""
        system, root = self._system
        with contextlib.suppress(FileNotFoundError):
            self._patiently(name, lambda: system.rm_file(within(root, name)))

    def drop(self, work: Path, name: str) -> None:
        """Remove the workspace's copy."""
        (work / name).unlink(missing_ok=True)

    def _patiently(
        self, name: str, operation: Callable[[], Any], pauses_s: Sequence[float] = _PAUSES_S
    ) -> Any:
        """What `operation` gives, tried again for a while: networks have faults of every kind.

        Raises:
            FileNotFoundError: as it is; it is an answer.
            DatasetError: no success.
        """
        for pause_s in (*pauses_s, None):
            try:
                return operation()
            except FileNotFoundError:
                raise
            except Exception as error:
                # Every kind of storage has errors of its own.
                if pause_s is None or isinstance(error, PermissionError | NotImplementedError):
                    raise DatasetError(
                        f"{self.place}: {name} cannot be read or written: "
                        f"{error or type(error).__name__}"
                    ) from error
                time.sleep(pause_s)


@contextlib.contextmanager
def _workspaces() -> Iterator[Path]:
    """The folder of this user's workspaces, held alone."""
    root = Path(tempfile.gettempdir()) / f"synthdepth-{os.getuid()}"
    try:
        root.mkdir(mode=0o700, exist_ok=True)
        handle = os.open(root, os.O_RDONLY)
    except OSError as error:
        raise write_error(root / "workspace", error) from error
    try:
        fcntl.flock(handle, fcntl.LOCK_EX)
        yield root
    finally:
        os.close(handle)


@contextlib.contextmanager
def _own_workspace() -> Iterator[Path]:
    """A temporary folder that a killed process does not leave for long.

    Whoever uses one holds its lock, which the kernel takes from the dead; the next one to come
    removes those that nobody holds.
    """
    with _workspaces() as root:
        _remove_abandoned(root)
        try:
            work = Path(tempfile.mkdtemp(dir=root))
        except OSError as error:
            raise write_error(root / "workspace", error) from error
        handle = os.open(work, os.O_RDONLY)
        fcntl.flock(handle, fcntl.LOCK_EX)
    try:
        yield work
    finally:
        shutil.rmtree(work, ignore_errors=True)
        os.close(handle)


def _remove_abandoned(root: Path) -> None:
    for work in root.iterdir():
        with contextlib.suppress(FileNotFoundError):  # Its owner is just removing it.
            handle = os.open(work, os.O_RDONLY)
            if took_lock(handle):
                shutil.rmtree(work, ignore_errors=True)
            os.close(handle)
