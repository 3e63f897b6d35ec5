"""Commands as users run them, up to where the long work would begin."""

import contextlib
import importlib
import io
import re
import sys

from synthdepth.cli import main as command_line
from synthdepth.errors import SynthdepthError


class Wrong(Exception):
    """A reader did something that it must not do."""


class Worked(BaseException):
    """The input was accepted, and what would take long has been left out."""


# A job's own progress on standard error is no part of the complaint.
_PROGRESS = re.compile(r"\w+: \d+/\d+ ")


def run_command(arguments: list[str]) -> None:
    """A command as a user runs it: 0, 1, or 2 with one line."""
    # As Python sets them up: what cannot be encoded is an error on one, and not on the other.
    streams = [
        io.TextIOWrapper(io.BytesIO(), "utf-8", errors=e, write_through=True)
        for e in ("strict", "backslashreplace")
    ]
    with contextlib.redirect_stdout(streams[0]), contextlib.redirect_stderr(streams[1]):
        try:
            code = command_line(arguments)
        except SystemExit as stop:
            code = stop.code or 0
    told = streams[1].buffer.getvalue().decode(errors="replace")
    lines = [line for line in told.splitlines() if not _PROGRESS.match(line)]
    if code not in (0, 1, 2) or "Traceback" in told:
        raise Wrong(f"exit code {code}: {told[-300:]!r}")
    if code == 2:
        if len(lines) != 1 or not lines[0].startswith("synthdepth: "):
            raise Wrong(f"exit code 2 with {len(lines)} lines: {told[:300]!r}")
        raise SynthdepthError(lines[0])


# Where a command begins to render, train, fly, or to start processes.
_LONG_WORK = (
    ("synthdepth.render.backend", "choose"),
    ("synthdepth.production.pool", "run_jobs"),
    ("synthdepth.maps.registry", "build_world"),
    ("synthdepth.pix2pix.train", "_learn"),
    ("synthdepth.evaluate.run", "_tallied"),
    ("synthdepth.evaluate.runtimes", "timed"),
    ("synthdepth.render.doctor", "examine"),
    ("concurrent.futures", "ProcessPoolExecutor"),
)


def leave_out_long_work() -> None:
    """From now on a command that has come that far has accepted what it was given."""

    def worked(*_, **__):
        raise Worked

    for place, name in _LONG_WORK:
        there = getattr(importlib.import_module(place), name)
        # Others have imported it by its name.
        for module in list(sys.modules.values()):
            if getattr(module, "__dict__", {}).get(name) is there:
                setattr(module, name, worked)
