"""A dataset in the Rerun viewer: flights in 3D, the points each frame sees, every picture."""

import os
import subprocess
import sys
import tempfile
import warnings
from collections.abc import Sequence
from pathlib import Path

from synthdepth.dataset.manifest import read_index, read_manifest
from synthdepth.dataset.pairs import PairDataset
from synthdepth.dataset.shard import PARTIAL, write_error
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.view.flights import Flight, flights_of


def write_recording(
    folder: Path, out: Path, *, count: int = 64, flights: Sequence[str] = ()
) -> int:
    """Write pairs of a dataset as a Rerun recording; returns how many.

    `rerun_log` says what is in it. A `.rrd` file is read by the version of Rerun that wrote it and
    the next: write it again, and archive the dataset.

    Args:
        folder: the dataset.
        out: the file, which ends in .rrd; about 1.3 MB a pair of 256x256.
        count: at most how many pairs, in the order of the index.
        flights: names such as `city-s00012-f003`, `s00012-f003` or `s00012` (a whole scene); all
            by default.

    Raises:
        SynthdepthError: Rerun is not installed, or an argument is not usable.
        DatasetError: no finished dataset there, no such flight, or the file cannot be written.
    """
    out = Path(out)
    if out.suffix.lower() != ".rrd":
        raise SynthdepthError(f"--out {out}: allowed is a file name that ends in .rrd")
    try:
        from synthdepth.view.rerun_log import log_pairs
    except ModuleNotFoundError as error:
        if error.name.partition(".")[0] != "rerun":
            raise
        raise SynthdepthError("Rerun is not installed: pip install 'synthdepth[view]'") from None
    manifest, everything = read_manifest(folder), flights_of(read_index(folder))
    chosen = _chosen(folder, everything, count, flights)
    partial = out.with_name(f"{out.name}.{os.getpid()}{PARTIAL}")
    try:
        # Opened by us first: Rerun reports a folder that cannot be written as a bare RuntimeError.
        partial.touch()
        log_pairs(partial, manifest, PairDataset(folder), everything, chosen)
        check_whole(partial, out)
        os.replace(partial, out)
    except OSError as error:
        raise write_error(out, error) from error
    finally:
        partial.unlink(missing_ok=True)
    return len(chosen)


def open_viewer(folder: Path, *, count: int = 64, flights: Sequence[str] = ()) -> int:
    """Show pairs of a dataset in the Rerun viewer, and wait until it is closed; returns how many.

    Args and errors are those of `write_recording`.
    """
    with tempfile.TemporaryDirectory(prefix="synthdepth-view-") as place:
        file = Path(place) / f"{Path(folder).resolve().name}.rrd"
        shown = write_recording(folder, file, count=count, flights=flights)
        # Left alone, the viewer listens on every interface, and joins a viewer that is open.
        command = [sys.executable, "-m", "rerun", "--bind", "127.0.0.1", "--new", str(file)]
        done = subprocess.run(command, check=False)
    if done.returncode:
        raise SynthdepthError(
            f"the Rerun viewer ended with exit code {done.returncode}: write a file with "
            "--out FILE.rrd, and open it where there is a display"
        )
    return shown


def has_display() -> bool:
    """Whether a window can be opened here."""
    if sys.platform in ("darwin", "win32"):
        return True
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))


def _chosen(
    folder: Path, everything: Sequence[Flight], count: int, names: Sequence[str]
) -> list[tuple[Flight, int]]:
    """The flight and the row of every pair to show."""
    if count < 1:
        raise SynthdepthError(f"--count {count}: allowed is a whole number from 1")
    for name in names:
        if not any(_is_named(flight, name) for flight in everything):
            some = ", ".join(flight.name for flight in everything[:3])
            raise DatasetError(
                f"--flight {name}: {folder} holds no such flight or scene; it has "
                f"{len(everything)} flights ({some}, ...)"
            )
    wanted = [f for f in everything if not names or any(_is_named(f, name) for name in names)]
    return [(flight, int(row)) for flight in wanted for row in flight.rows][:count]


def _is_named(flight: Flight, name: str) -> bool:
    whole = (flight.name, flight.scene)
    return name in whole or any(known.endswith(f"-{name}") for known in whole)


def check_whole(partial: Path, out: Path) -> None:
    """Refuse what Rerun's writer left: on a full disk it logs an error and goes on."""
    from rerun.chunk import RrdReader

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            RrdReader(partial).store()
    except (RuntimeError, ValueError, Warning) as error:
        raise DatasetError(
            f"cannot write {out}: the recording broke off; is the disk full, or Rerun switched off "
            "by the environment variable RERUN?"
        ) from error
