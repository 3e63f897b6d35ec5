"""What a training writes of itself: `log.jsonl` for programs, TensorBoard for people."""

import json
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from synthdepth.errors import SynthdepthError

LOG, BOARD = "log.jsonl", "tensorboard"


class Journal:
    """Appends to the log and to TensorBoard; what a killed run wrote after its last checkpoint,
    and will be written again, goes.

    Args:
        out: folder of the training.
        log_bytes: how much of the log stands.
        step: the last step that stands.
    """

    def __init__(self, out: Path, *, log_bytes: int, step: int):
        try:
            from torch.utils.tensorboard import SummaryWriter
        except ModuleNotFoundError:
            raise SynthdepthError(
                "training needs tensorboard: install it with pip install 'synthdepth[train]'"
            ) from None
        self._log = open(out / LOG, "ab")  # noqa: SIM115
        if self.log_bytes > log_bytes:
            self._log.truncate(log_bytes)
        # Without anything that stands there is nothing to purge, and no file to do it in.
        purge = {"purge_step": step + 1} if step else {}
        self._board = SummaryWriter(str(out / BOARD), **purge)

    @property
    def log_bytes(self) -> int:
        """Size of the log."""
        return os.fstat(self._log.fileno()).st_size

    def write(self, kind: str, step: int, values: Mapping[str, float]) -> None:
        """A line of the log, and a point of every number's curve `kind/name`."""
        self._log.write(json.dumps({"kind": kind, "step": step, **values}).encode() + b"\n")
        self._log.flush()
        for name, value in values.items():
            self._board.add_scalar(f"{kind}/{name}", value, step)

    def show(self, name: str, step: int, picture: np.ndarray) -> None:
        """A picture (H, W, 3) uint8 RGB for TensorBoard."""
        self._board.add_image(name, picture, step, dataformats="HWC")

    def close(self) -> None:
        """Write out what is held back."""
        self._board.close()
        self._log.close()
