"""Where a process stands among those that train together, as `torchrun` tells them."""

import contextlib
import dataclasses
import os
import signal
import threading
from collections.abc import Iterator

import torch
import torch.distributed as dist

from synthdepth.errors import SynthdepthError


@dataclasses.dataclass(frozen=True, kw_only=True)
class Place:
    """A process and its device.

    Attributes:
        rank: number of the process; 0 writes.
        ranks: how many there are.
        device: what it computes on.
    """

    rank: int
    ranks: int
    device: torch.device

    @property
    def leads(self) -> bool:
        """Whether this process writes and reports."""
        return self.rank == 0

    def wait(self) -> None:
        """Until all processes are here."""
        if self.ranks > 1:
            dist.barrier()

    def total(self, values: torch.Tensor) -> torch.Tensor:
        """The sum of a tensor over all processes."""
        if self.ranks > 1:
            values = values.clone()
            dist.all_reduce(values)
        return values

    def any(self, yes: bool) -> bool:
        """Whether it is so in any process."""
        if self.ranks == 1:
            return yes
        return bool(self.total(torch.tensor(float(yes), device=self.device)))


@contextlib.contextmanager
def processes(device: str | None = None) -> Iterator[Place]:
    """Joins the processes that `torchrun` started; without it there is one.

    Args:
        device: "cpu", "cuda" or "cuda:1"; by default a GPU if there is one, each process its own.

    Raises:
        SynthdepthError: no such device.
    """
    ranks = int(os.environ.get("WORLD_SIZE", "1"))
    rank, local = int(os.environ.get("RANK", "0")), os.environ.get("LOCAL_RANK", "0")
    place = Place(rank=rank, ranks=ranks, device=find_device(device, f"cuda:{local}"))
    if ranks == 1:
        yield place
        return
    gpu = place.device.type == "cuda"
    if gpu:
        torch.cuda.set_device(place.device)
    dist.init_process_group("nccl" if gpu else "gloo")
    try:
        yield place
    finally:
        dist.destroy_process_group()


def find_device(name: str | None, gpu: str = "cuda") -> torch.device:
    """The device of a name: by default the GPU if torch has one, else the CPU.

    Raises:
        SynthdepthError: unknown, or not here.
    """
    if name is None or name == "cuda":
        name = gpu if name or torch.cuda.is_available() else "cpu"
    there = ["cpu", *(f"cuda:{k}" for k in range(torch.cuda.device_count()))]
    if name not in there and (name != "cuda" or len(there) == 1):
        raise SynthdepthError(f"device {name!r}: allowed are {', '.join(there)}")
    return torch.device(name)


@contextlib.contextmanager
def stop_requests() -> Iterator[threading.Event]:
    """An event that Ctrl-C and SIGTERM set, so that a step is never cut in two.

    The second Ctrl-C stops at once. Outside of the main thread signals are left alone.
    """
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = {kind: signal.getsignal(kind) for kind in (signal.SIGINT, signal.SIGTERM)}

    def note(kind, _) -> None:
        stop.set()
        signal.signal(kind, before[kind])

    for kind in before:
        signal.signal(kind, note)
    try:
        yield stop
    finally:
        for kind, handler in before.items():
            signal.signal(kind, handler)
