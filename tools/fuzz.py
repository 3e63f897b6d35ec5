"""Feeds malformed input of every kind to the package, and tells what broke.

Each input is a whole one, broken by a few changes of bytes, numbers, leaves or chunks, or made by
hand (`fuzzing/crafted.py`), and is given to every reader of its kind in a forked process. A reader
must accept it, or refuse it with a SynthdepthError of one line: without another exception, without
5 s of processor time, without a GB more memory, without writing outside its folders, running a
program, opening a connection or unpickling anything. What fails is kept with its input.

python tools/fuzz.py --data DATASET --inputs 2000 --json fuzz.json

DATASET is any dataset of ours with two splits; small pictures make small inputs.
"""

import dataclasses
import json
import os
import random
import shutil
import sys
import tempfile
import time
import traceback
from collections import Counter
from pathlib import Path

import tyro
from fuzzing.child import Finding, in_child, run_inputs
from fuzzing.commands import COMMANDS
from fuzzing.crafted import CRAFTED
from fuzzing.kinds import KINDS, unpack_shards
from fuzzing.mutations import mutated
from fuzzing.seeds import make_seeds

# Inputs of one process: what one of them leaves behind may trip the next, but only a few.
_GROUP = 20


@dataclasses.dataclass(frozen=True, kw_only=True)
class Options:
    """What to feed.

    Attributes:
        data: a dataset, of which inputs are made.
        model: the folder of a training, of which inputs are made; a tiny one by default.
        inputs: how many, over all kinds; those made by hand come first, and are all fed.
        seed: of the changes.
        kinds: which kinds; all by default.
        out: folder for the inputs that failed, a new or an empty one; made only if there are any.
        json: where the figures go.
    """

    data: Path
    model: Path | None = None
    inputs: int = 2000
    seed: int = 0
    kinds: tuple[str, ...] = ()
    out: Path = Path("fuzz-failures")
    json: Path | None = None


ALL = KINDS | COMMANDS


def main(options: Options) -> int:
    unknown = [name for name in options.kinds if name not in ALL]
    if unknown:
        sys.exit(f"--kinds {unknown[0]}: allowed are {', '.join(ALL)}")
    started, names = time.monotonic(), options.kinds or tuple(ALL)
    work = Path(tempfile.mkdtemp(prefix="fuzz-"))
    try:
        in_child(lambda: _prepare(work / "inputs", options))
        each = max(1, options.inputs // len(names))
        figures, failures = {}, []
        for name in names:
            told, found = _one_kind(name, each, work, options)
            figures[name], failures = told, failures + found
            print(f"{name:16s}" + "".join(f" {value} {what}," for what, value in told.items())[:-1])
            for finding in found:
                print(f"    {finding.times} x {finding.signature}: {finding.kept}")
            sys.stdout.flush()
    finally:
        shutil.rmtree(work, ignore_errors=True)
    total = Counter()
    for told in figures.values():
        total.update({what: told[what] for what in ("inputs", "accepted", "refused", "failed")})
    print(f"{dict(total)} in {time.monotonic() - started:.0f} s")
    if options.json:
        report = {
            "seed": options.seed,
            "total": total,
            "kinds": figures,
            "failures": [dataclasses.asdict(finding) for finding in failures],
        }
        options.json.write_text(json.dumps(report, indent=1) + "\n")
    return 1 if failures else 0


def _prepare(inputs: Path, options: Options) -> None:
    """All seeds, in `inputs` itself: the readers of some kinds need a whole one of another."""
    make_seeds(inputs, options.data, options.model)
    shutil.copytree(inputs / "dataset", inputs / "members")
    unpack_shards(inputs / "members")
    (inputs / "checkpoint").mkdir()
    for name in ("last.safetensors", "whole.safetensors"):
        shutil.copy(inputs / "training/last.safetensors", inputs / "checkpoint" / name)


def _one_kind(name: str, each: int, work: Path, options: Options) -> tuple[dict, list[Finding]]:
    """Feed a kind; returns its figures, and one finding for all failures of one cause."""
    kind, inputs, crafted = ALL[name], work / "inputs", CRAFTED.get(name, [])

    def make(number: int, folder: Path) -> None:
        """Input `number`, which depends on the seed, the kind and the number alone."""
        rng = random.Random(f"{options.seed} {name} {number}")
        shutil.copytree(inputs / kind.seed, folder)
        if number < len(crafted):
            crafted[number](folder)
        elif kind.targets:
            pattern = rng.choice(kind.targets)
            alike = sorted(path for path in folder.glob(pattern) if path.is_file())
            path = rng.choice(alike)
            others = [other.read_bytes() for other in alike[:8]]
            path.write_bytes(mutated(rng, path, path.read_bytes(), others))
        kind.settle(folder, rng)

    told = Counter(inputs=0, accepted=0, refused=0, failed=0)
    found: dict[str, Finding] = {}
    most = {"most_cpu_s": 0.0, "most_mb": 0}
    for result in run_inputs(max(each, len(crafted)), _GROUP, make, kind.feeds, inputs):
        told["inputs"] += 1
        told[result.outcome] += 1
        most["most_cpu_s"] = max(most["most_cpu_s"], result.cpu_s)
        most["most_mb"] = max(most["most_mb"], result.grown_mb)
        for failure in result.failures:
            known = found.get(failure.signature)
            if known is None:
                kept = options.out / f"{name}-{result.number}-{len(found)}"
                _keep(kept, make, result.number, failure)
                found[failure.signature] = dataclasses.replace(failure, kept=str(kept))
            else:
                found[failure.signature] = dataclasses.replace(known, times=known.times + 1)
    return {**told, **most}, list(found.values())


def _keep(kept: Path, make, number: int, failure: Finding) -> None:
    """The input of a failure, and what happened."""
    kept.mkdir(parents=True, exist_ok=True)
    try:
        make(number, kept / "in")
    except Exception:
        failure = dataclasses.replace(failure, told=failure.told + traceback.format_exc())
    (kept / "failure.txt").write_text(
        f"reader {failure.reader}\n{failure.signature}\n\n{failure.told}\n", errors="replace"
    )


if __name__ == "__main__":
    os.environ.pop("DISPLAY", None)
    # A parent that trained leaves it; without it torch keeps to the temporary folder of an input.
    os.environ.pop("TORCHINDUCTOR_CACHE_DIR", None)
    raise SystemExit(main(tyro.cli(Options, description=__doc__)))
