"""The command line: every command parses, calls one library function, and says what came of it."""

import contextlib
import io
import os
import sys
from typing import Annotated, Any

import tyro

import synthdepth
from synthdepth.cli.datasets import Export, ImportAirsim, OnePair, Preview, Verify, View
from synthdepth.cli.learning import Onnx, Predict, Train
from synthdepth.cli.measuring import Bench, Evaluate
from synthdepth.cli.rendering import Doctor, Maps, Render, Scene
from synthdepth.cli.simulating import Replay, Simulate
from synthdepth.console import say
from synthdepth.errors import SynthdepthError

_COMMANDS = {
    "render": Render,
    "maps": Maps,
    "scene": Scene,
    "preview": Preview,
    "view": View,
    "verify": Verify,
    "pair": OnePair,
    "export": Export,
    "import-airsim": ImportAirsim,
    "train": Train,
    "predict": Predict,
    "onnx": Onnx,
    "evaluate": Evaluate,
    "bench": Bench,
    "simulate": Simulate,
    "replay": Replay,
    "doctor": Doctor,
}


def _parse(arguments: list[str]) -> Any:
    """The command of the arguments; a parse error becomes a SynthdepthError of one line."""
    union = None
    for name, command in _COMMANDS.items():
        one = Annotated[command, tyro.conf.subcommand(name)]
        union = one if union is None else union | one
    complaint = io.StringIO()
    try:
        with contextlib.redirect_stderr(complaint):
            return tyro.cli(
                union,
                prog="synthdepth",
                description=synthdepth.__doc__,
                args=arguments,
                config=(tyro.conf.OmitSubcommandPrefixes,),
            )
    except SystemExit as stop:
        if not stop.code:
            raise
        raise SynthdepthError(_first_section(complaint.getvalue())) from None


def _first_section(box: str) -> str:
    """The message of a framed complaint, on one line."""
    words: list[str] = []
    for line in box.splitlines():
        text = line.strip("│ \t")
        if words and text.startswith(("──", "╰")):
            break
        if text and text[0] not in "╭╰─":
            words += text.split()
    return " ".join(words) or "the arguments cannot be read; see synthdepth --help"


def _one_line(error: SynthdepthError) -> str:
    """The message; a loader's worker wraps it into a traceback, of which it is the last line."""
    return str(error).strip().splitlines()[-1].split(f"{type(error).__qualname__}: ", 1)[-1]


def main(arguments: list[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if arguments == ["--version"]:
        say(synthdepth.__version__)
        return 0
    try:
        return _parse(arguments).run()
    except SynthdepthError as error:
        sys.stderr.write(f"synthdepth: {_one_line(error)}\n")
        return 2
    except BrokenPipeError:
        # The reader of our output has gone (`| head`): nothing to complain about.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except OSError as error:
        # What the system refuses: a name that is too long, a folder that is closed to us.
        where = "" if error.filename is None else f"{error.filename}: "
        sys.stderr.write(f"synthdepth: {SynthdepthError(where + (error.strerror or str(error)))}\n")
        return 2
    except KeyboardInterrupt:
        return 130
