"""Tar archives from anywhere, read without trusting the sizes that stand in them."""

import mmap
import sys
import tarfile
from collections.abc import Iterator
from typing import BinaryIO


def mapped(file: BinaryIO) -> mmap.mmap:
    """A file for `tarfile`, which asks for as many bytes as a header says: there are no more here.

    Raises:
        ValueError: it is empty.
    """
    return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)


def entries(tar: tarfile.TarFile) -> Iterator[tarfile.TarInfo]:
    """The entries of an archive one after another; none is kept.

    Raises:
        tarfile.ReadError: a size that no file has; one below 0 would lead back to the entries
            before.
    """
    for info in tar:
        if not 0 <= info.size <= sys.maxsize:
            raise tarfile.ReadError(f"{info.name!r} says to have {info.size} bytes")
        yield info
        # A long shard would leave a record of every file behind.
        tar.members.clear()
