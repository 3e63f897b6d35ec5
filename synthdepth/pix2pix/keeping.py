"""What is kept of a training while it runs: log, pictures, checkpoints, the best model."""

import json
import math
import time
from collections.abc import Mapping
from pathlib import Path

import torch

from synthdepth.dataset import Batch
from synthdepth.dataset.shard import PARTIAL, write_whole
from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.checkpoint import (
    BEST,
    LAST,
    read_facts,
    restore_state,
    save_model,
    save_state,
)
from synthdepth.pix2pix.config import FREE, TrainConfig, first_difference
from synthdepth.pix2pix.distributed import Place
from synthdepth.pix2pix.journal import Journal
from synthdepth.pix2pix.panels import panel
from synthdepth.pix2pix.state import State
from synthdepth.pix2pix.validation import predict_batch

CONFIG = "config.json"


def begin(out: Path, state: State, facts: Mapping, *, resume: bool) -> None:
    """Goes on in a folder where this training stands, and accepts an empty one.

    Args:
        out: the folder.
        state: at its first values; afterwards as the checkpoint has it.
        facts: what decides the training.
        resume: whether to go on.

    Raises:
        SynthdepthError: the folder holds something else; nothing was touched.
    """
    last = out / LAST
    if not last.exists():
        if out.exists() and not out.is_dir():
            raise SynthdepthError(f"{out} is a file: allowed is a folder")
        strange = [p.name for p in out.iterdir() if p.suffix != PARTIAL] if out.exists() else []
        if strange:
            raise SynthdepthError(
                f"{out} holds {strange[0]} and no training: allowed is a new or empty folder"
            )
        return
    if not resume:
        raise SynthdepthError(f"{out} holds a training: allowed is another folder, or to resume it")
    there = read_facts(last)
    if "progress" not in there:
        raise SynthdepthError(f"{last} is a model: allowed is a folder that `train` made")
    there["config"] = TrainConfig.from_table(there.get("config"), f"{last}: config").as_table()
    found = first_difference(_identity(there, facts), _identity(facts, there))
    if found:
        name, old, new = found
        raise SynthdepthError(
            f"{out} holds a different training: {name} is {json.dumps(old)} there and "
            f"{json.dumps(new)} was asked for; choose another --out (nothing was touched)"
        )
    restore_state(last, state)


def _identity(facts: Mapping, other: Mapping) -> dict:
    """What must be the same for a training to go on."""
    config = {name: value for name, value in facts["config"].items() if name not in FREE}
    # A pass more changes none before it, as long as the learning rate does not depend on it.
    if config.get("decay") == "none":
        config["epochs"] = max(config["epochs"], other["config"]["epochs"])
    return {"config": config, "data": facts.get("data"), "processes": facts.get("processes")}


class Keeper:
    """Counts losses in every process; rank 0 writes. A context manager.

    Args:
        out: folder of the training.
        config: of the training.
        state: of the training.
        facts: for the headers of the files.
        place: which process this is.
    """

    def __init__(self, out: Path, config: TrainConfig, state: State, facts: Mapping, place: Place):
        self._out, self._config, self._state = out, config, state
        self._facts, self._place = facts, place

    def __enter__(self) -> "Keeper":
        self._ticked = self._saved = self._lined = time.monotonic()
        self._line_step = self._state.progress.step
        self._journal = None
        if self._place.leads:
            progress = self._state.progress
            self._out.mkdir(parents=True, exist_ok=True)
            # At once, so that a disk without room is found now.
            save_state(self._out / LAST, self._state, self._facts)
            config = json.dumps(self._config.as_table(), indent=1) + "\n"
            write_whole(self._out / CONFIG, config.encode())
            self._journal = Journal(self._out, log_bytes=progress.log_bytes, step=progress.step)
        return self

    def __exit__(self, *_) -> None:
        if self._journal:
            self._journal.close()

    def count(self, losses: Mapping[str, torch.Tensor]) -> bool:
        """Add up the losses of a step; True where that made a line of the log."""
        state = self._state
        # Stays on the device: a step must not wait for a number.
        state.window += torch.stack([losses[name].detach().double() for name in state.terms])
        state.progress.counted += 1
        if state.progress.counted < self._config.log_every:
            return False
        self.line()
        return True

    def line(self) -> None:
        """Log the mean losses since the last line, if there was a step."""
        state, progress, place = self._state, self._state.progress, self._place
        if not progress.counted:
            return
        means = (place.total(state.window) / (progress.counted * place.ranks)).tolist()
        losses = dict(zip(state.terms, means, strict=True))
        bad = [name for name, value in losses.items() if not math.isfinite(value)]
        if bad:
            raise SynthdepthError(
                f"the loss {bad[0]} is {losses[bad[0]]} by step {progress.step}: a smaller lr or "
                f"precision fp32 may help (lr is {self._config.lr:g}, precision "
                f"{self._config.precision})"
            )
        now = time.monotonic()
        pairs = (progress.step - self._line_step) * self._config.batch_size * place.ranks
        speed = pairs / max(now - self._lined, 1e-9)
        self._lined, self._line_step = now, progress.step
        state.window.zero_()
        progress.counted = 0
        self._write("train", losses | {"lr": state.lr, "pairs_per_s": speed})

    def validated(self, errors: Mapping[str, float], shown: Batch) -> None:
        """Log a validation, with pictures; keep the model if it is the best so far."""
        state, progress = self._state, self._state.progress
        self._write("validation", errors)
        if progress.best is None or errors["rel"] < progress.best["rel"]:
            progress.best = {"epoch": progress.epoch, "step": progress.step, **errors}
            if self._place.leads:
                facts = {**self._facts, "best": progress.best}
                save_model(self._out / BEST, state.model, facts)
        if self._journal:
            self._show(shown)

    def due(self) -> bool:
        """Whether it is time for a checkpoint."""
        wait_s = 60 * self._config.checkpoint_minutes
        return self._place.leads and time.monotonic() - self._saved >= wait_s

    def checkpoint(self) -> None:
        """Write the training as it stands."""
        if self._place.leads:
            self._tick()
            self._state.progress.log_bytes = self._journal.log_bytes
            save_state(self._out / LAST, self._state, self._facts)
            self._saved = time.monotonic()

    def _tick(self) -> None:
        now = time.monotonic()
        self._state.progress.elapsed_s += now - self._ticked
        self._ticked = now

    def _write(self, kind: str, values: Mapping[str, float]) -> None:
        self._tick()
        if self._journal:
            progress = self._state.progress
            when = {"epoch": progress.epoch, "elapsed_s": progress.elapsed_s}
            self._journal.write(kind, progress.step, {**values, **when})

    @torch.no_grad()
    def _show(self, shown: Batch) -> None:
        model, config = self._state.model, self._config
        training = model.training
        model.eval()
        depths_m = predict_batch(model, shown, config, self._place.device).cpu().numpy()
        model.train(training)
        for k, key in enumerate(shown.keys):
            picture = panel(
                shown.input[k, :3].permute(1, 2, 0).numpy(),
                shown.depth_m[k, 0].numpy(),
                depths_m[k, 0],
                config.coding.max_depth_m,
            )
            self._journal.show(f"pairs/{key}", self._state.progress.step, picture)
