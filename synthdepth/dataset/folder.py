"""A folder that is there whole or not at all."""

import contextlib
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

from synthdepth.dataset.shard import PARTIAL, sync_folder, write_error
from synthdepth.errors import DatasetError


@contextlib.contextmanager
def new_folder(out: Path) -> Iterator[Path]:
    """Yields a folder to write into, which becomes `out` when the block ends without an error.

    Until then it is `<out>.partial`; if the block fails it is removed. What a killed run left
    there is removed first.

    Raises:
        DatasetError: `out` exists and is not an empty folder, or it cannot be written.
    """
    out = Path(os.path.abspath(out))
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise DatasetError(f"--out {out} exists: allowed is a new or an empty folder")
    partial = out.with_name(out.name + PARTIAL)
    try:
        if partial.is_dir():
            shutil.rmtree(partial)
        partial.mkdir(parents=True)
        yield partial
        os.replace(partial, out)
        sync_folder(out.parent)
    except OSError as error:
        raise write_error(out, error) from error
    finally:
        shutil.rmtree(partial, ignore_errors=True)
