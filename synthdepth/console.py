"""What commands show while they work: a progress bar, or plain lines where nobody watches."""

import contextlib
import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from synthdepth.errors import SynthdepthError

# Seconds between plain lines when the output is not a terminal.
_LINE_EVERY_S = 10.0


def say(text: str) -> None:
    """One line for the user, on standard output."""
    # Names of files may hold bytes that are no text, and a terminal may not know every letter.
    encoding = sys.stdout.encoding or "utf-8"
    sys.stdout.write(text.encode(encoding, "backslashreplace").decode(encoding) + "\n")
    sys.stdout.flush()


@contextlib.contextmanager
def progress_bar(what: str, unit: str) -> Iterator[Callable[[int, int], None]]:
    """Shows how far a long job is; yields a function to call with (done, total).

    The rate counts what is done while it is shown, not what an earlier run had done.
    """
    started, first = time.monotonic(), None

    def rate(done: int) -> float:
        nonlocal first
        first = done if first is None else first
        return (done - first) / max(time.monotonic() - started, 1e-6)

    console = Console(stderr=True)
    if not console.is_terminal:
        last = -_LINE_EVERY_S

        def line(done: int, total: int) -> None:
            nonlocal last
            speed, now = rate(done), time.monotonic()
            if now - last < _LINE_EVERY_S and done < total:
                return
            last = now
            left = f", {(total - done) / speed / 60:.1f} min left" if speed else ""
            console.print(
                f"{what}: {done}/{total} {unit}, {speed:.2f} {unit}/s{left}",
                highlight=False,
                soft_wrap=True,
            )

        yield line
        return
    columns = (
        TextColumn(what),
        BarColumn(),
        MofNCompleteColumn(),
        TextColumn("{task.fields[rate]}"),
        TimeRemainingColumn(elapsed_when_finished=True),
    )
    with Progress(*columns, console=console, speed_estimate_period=120) as bar:
        task = bar.add_task(what, total=None, rate="")

        def move(done: int, total: int) -> None:
            bar.update(task, completed=done, total=total, rate=f"{rate(done):.2f} {unit}/s")

        yield move


def write_json(path: Path | None, figures: Any) -> None:
    """Write what a command found to the file that `--json` names, if it does."""
    if path is None:
        return
    try:
        path.write_text(json.dumps(figures, indent=1, default=str) + "\n")
    except OSError as error:
        raise SynthdepthError(f"--json {path} cannot be written: {error.strerror}") from error
