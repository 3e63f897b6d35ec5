"""Readers in forked processes, with limits on time, memory and what they may touch."""

import dataclasses
import errno
import faulthandler
import json
import os
import re
import resource
import select
import shutil
import signal
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import pyarrow as pa
import torch

from fuzzing.command_line import Worked, Wrong
from fuzzing.kinds import COMMAND_LINE, Feed
from synthdepth.errors import SynthdepthError

CPU_S, MEMORY_BYTES = 5.0, 2**30
# How often a process that says nothing is looked at.
_LOOK_S = 30.0
# What libraries say where the limit on memory stopped them.
_MEMORY = re.compile(r"memory|bad_alloc|allocat", re.IGNORECASE)
_LONGEST_MESSAGE = 1000
# What lies beside an input that is fed.
_OURS = {"in", "out", "tmp"}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Finding:
    """A failure, or several of one cause.

    Attributes:
        signature: what happened and where; the same for the same cause.
        reader: who was reading.
        told: traceback or log.
        kept: folder with the input.
        times: how many inputs failed so.
    """

    signature: str
    reader: str
    told: str
    kept: str = ""
    times: int = 1


@dataclasses.dataclass(kw_only=True)
class Result:
    """What came of an input: the worst outcome over its readers, and the most they took."""

    number: int
    outcome: str = "accepted"
    cpu_s: float = 0.0
    grown_mb: int = 0
    failures: list[Finding] = dataclasses.field(default_factory=list)


def in_child(work: Callable[[], None]) -> None:
    """Run something in a fork: threads that it starts here would not survive the next one."""
    child = os.fork()
    if child == 0:
        try:
            _few_threads()
            work()
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            os._exit(1)
    if os.waitpid(child, 0)[1]:
        sys.exit("the inputs could not be made")


def run_inputs(
    count: int, group: int, make: Callable[[int, Path], None], feeds: dict[str, Feed], work: Path
) -> Iterator[Result]:
    """Give inputs to their readers, some in one forked process; yields what came of each.

    Args:
        count: how many inputs.
        group: of one process.
        make: writes an input, by its number, into a folder to be made.
        feeds: the readers.
        work: where the folders are made and removed.
    """
    number = 0
    while number < count:
        for result in _group(range(number, min(number + group, count)), make, feeds, work):
            yield result
            number = result.number + 1


def _group(numbers: range, make, feeds: dict[str, Feed], work: Path) -> Iterator[Result]:
    """The inputs of one process, as far as it lives: the last that is yielded killed it."""
    reading, writing = os.pipe()
    log = work / "log"
    log.write_bytes(b"")
    child = os.fork()
    if child == 0:
        os.close(reading)
        try:
            _feed_all(numbers, make, feeds, work, os.fdopen(writing, "w"), log)
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            os._exit(1)
    os.close(writing)
    result, at = None, ""
    # Without a buffer: select does not see what waits in one.
    with os.fdopen(reading, "rb", buffering=0) as lines:
        while True:
            if not select.select([lines], [], [], _LOOK_S)[0]:
                # One that only waits for its turn on the processor is left to its timer.
                if not _wants_processor(child):
                    os.kill(child, signal.SIGKILL)
                    at += ", which waits for something"
                    break
                continue
            line = lines.readline()
            if not line:
                break
            event = json.loads(line)
            if "start" in event:
                result = Result(number=event["start"])
            elif "reader" in event:
                at = event["reader"]
            else:
                failures = [Finding(**failure) for failure in event.pop("failures")]
                yield dataclasses.replace(result, **event, failures=failures)
                result = None
    status = os.waitpid(child, 0)[1]
    if result is not None:
        yield _killed(result, status, at, log.read_text(errors="replace"))
    for left in work.glob("input-*"):
        shutil.rmtree(left, ignore_errors=True)


def _wants_processor(child: int) -> bool:
    """Whether a thread of a process runs, would run, or is at the disk, in about a second."""
    for _ in range(20):
        for task in Path(f"/proc/{child}/task").iterdir():
            if (task / "stat").read_text().rpartition(")")[2].split()[0] in "RD":
                return True
        time.sleep(0.05)
    return False


def _killed(result: Result, status: int, reader: str, log: str) -> Result:
    """The input during which a process died."""
    how = f"exit {os.waitstatus_to_exitcode(status)}"
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        how = f"more than {CPU_S:g} s" if number == signal.SIGPROF else signal.Signals(number).name
    places = re.findall(r'File "[^"]*/synthdepth/([^"]+)", line (\d+)', log)
    where = ":".join(places[0]) if places else "?"
    result.outcome = "failed"
    result.failures = [Finding(signature=f"{how} at {where}", reader=reader, told=log[-8000:])]
    return result


def _feed_all(numbers: range, make, feeds: dict[str, Feed], work: Path, pipe, log: Path) -> None:
    """In the child: every input to every reader; a line to the parent before and after."""

    def tell(**event) -> None:
        pipe.write(json.dumps(event) + "\n")
        pipe.flush()

    _few_threads()
    # Arrow takes a GB of addresses, which is no memory, when it allocates first.
    pa.allocate_buffer(1)
    file = open(log, "ab", buffering=0)  # noqa: SIM115
    for stream in (1, 2):
        os.dup2(file.fileno(), stream)
    faulthandler.enable(file)
    # The default action follows: the process ends, whatever library it hangs in.
    faulthandler.register(signal.SIGPROF, file, chain=True)
    guard = _Guard()
    sys.addaudithook(guard)
    for number in numbers:
        place = work / f"input-{number}"
        place.mkdir()
        (place / "out").mkdir()
        (place / "tmp").mkdir()
        tell(start=number)
        tell(reader="making it")
        make(number, place / "in")
        os.chdir(place / "out")
        tempfile.tempdir = str(place / "tmp")
        outcomes, failures = set(), []
        cpu, memory = time.process_time(), _peak_mb()
        for name, feed in feeds.items():
            tell(reader=name)
            outcome, failure = _fed(name, feed, place, guard)
            outcomes.add(outcome)
            failures += [failure] if failure else []
        worst = next(o for o in ("failed", "refused", "accepted") if o in outcomes)
        tell(
            outcome=worst,
            cpu_s=round(time.process_time() - cpu, 2),
            grown_mb=_peak_mb() - memory,
            failures=[dataclasses.asdict(failure) for failure in failures],
        )
        os.chdir(work)
        shutil.rmtree(place)


def _fed(name: str, feed: Feed, place: Path, guard: "_Guard") -> tuple[str, Finding | None]:
    """One reader with one input: the outcome, and the failure if it is one."""
    guard.begin(place)
    before = _peak_mb()
    hard = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (_address_space() + MEMORY_BYTES, hard))
    signal.setitimer(signal.ITIMER_PROF, CPU_S)
    outcome, failure = "accepted", None
    try:
        feed(place / "in")
    except Worked:
        pass
    except SynthdepthError as error:
        outcome, failure = "refused", _message_failure(name, str(error))
    except BaseException as error:
        outcome = "refused"
        if not (isinstance(error, ValueError) and name.endswith("decoder")):
            failure = _exception_failure(name, error)
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        resource.setrlimit(resource.RLIMIT_AS, (hard, hard))
    strange = guard.end()
    # A command line says itself where to write.
    if name == COMMAND_LINE:
        strange = [what for what in strange if what != "writes elsewhere"]
    else:
        strange += sorted({p.name for p in place.iterdir()} - _OURS)
    if strange:
        failure = Finding(signature=f"it {strange[0]}", reader=name, told="\n".join(strange))
    if _peak_mb() - before > MEMORY_BYTES / 2**20:
        failure = Finding(signature="memory grew by more than 1 GB", reader=name, told="")
    return ("failed" if failure else outcome), failure


def _message_failure(reader: str, text: str) -> Finding | None:
    """What is wrong with a refusal, if anything."""
    wrong = ""
    if "\n" in text or not text.strip():
        wrong = "a message of not one line"
    elif len(text) > _LONGEST_MESSAGE:
        wrong = f"a message of more than {_LONGEST_MESSAGE} characters"
    elif _MEMORY.search(text):
        wrong = "a message of memory"
    if not wrong:
        return None
    start = re.sub(r"[\d./\w-]*/[\w./-]*|\d+", "_", text)[:60]
    return Finding(signature=f"{wrong}: {start!r}", reader=reader, told=text[:3000])


def _exception_failure(reader: str, error: BaseException) -> Finding:
    frames = traceback.extract_tb(error.__traceback__)
    ours = [f for f in frames if "/synthdepth/" in f.filename] or frames[-1:]
    where = f"{ours[-1].filename.rpartition('/synthdepth/')[2]}:{ours[-1].lineno}"
    text = str(error).splitlines()[0][:100] if str(error) else ""
    if isinstance(error, Wrong):
        where, text = "", re.sub(r"\d+", "_", text)
    told = "".join(traceback.format_exception(error))
    text = re.sub(r"[\d./\w-]*/[\w./-]*|\d+", "_", text)[:60]
    return Finding(
        signature=f"{type(error).__name__} {where} {text}", reader=reader, told=told[-8000:]
    )


# What writes, with how many paths in the first places; and what no reader may do.
_WRITES = {
    "os.mkdir": 1,
    "os.rename": 2,
    "os.remove": 1,
    "os.rmdir": 1,
    "os.link": 2,
    "os.symlink": 2,
    "os.truncate": 1,
    "os.chmod": 1,
    "os.utime": 1,
}
_NEVER = {
    "subprocess.Popen": "runs a program",
    "os.system": "runs a program",
    "os.exec": "runs a program",
    "os.posix_spawn": "runs a program",
    "socket.connect": "opens a connection",
    "socket.bind": "opens a port",
    "pickle.find_class": "unpickles",
}


class _Guard:
    """An audit hook that notes what a reader touches beside its own folders."""

    def __init__(self):
        self._root: str | None = None
        self._seen: list[str] = []

    def begin(self, root: Path) -> None:
        """Watch, until `end`, for what is not below `root`."""
        self._seen, self._root = [], f"{root}/"

    def end(self) -> list[str]:
        """What was seen."""
        self._root = None
        return self._seen

    def __call__(self, event: str, args: tuple) -> None:
        if self._root is None:
            return
        if event in _NEVER:
            self._seen.append(_NEVER[event])
        elif event == "open" and isinstance(args[2], int):
            if args[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
                self._look(args[0])
        elif event in _WRITES:
            for path in args[: _WRITES[event]]:
                self._look(path)

    def _look(self, path) -> None:
        if not isinstance(path, str | bytes | os.PathLike):
            return
        path = os.fsdecode(path)
        if path == os.devnull or path.startswith("/dev/shm"):
            return
        if not f"{os.path.realpath(path)}/".startswith(self._root):
            self._seen.append("writes elsewhere")
            # And so that it does not happen.
            raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), path)


def _few_threads() -> None:
    cv2.setNumThreads(0)
    torch.set_num_threads(1)
    pa.set_cpu_count(1)


def _address_space() -> int:
    """Of this process [bytes]."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    return pages * os.sysconf("SC_PAGE_SIZE")


def _peak_mb() -> int:
    # Linux gives kilobytes.
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
