"""Training: the loop, in plain PyTorch. One process, or several that `torchrun` starts."""

import dataclasses
import threading
import time
import warnings
from collections.abc import Callable, Sequence
from pathlib import Path

import torch
from torch import nn
from torch.nn.parallel import DistributedDataParallel

from synthdepth.dataset import Batch
from synthdepth.dataset.shard import write_error
from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.data import TrainingData
from synthdepth.pix2pix.distributed import Place, processes, stop_requests
from synthdepth.pix2pix.keeping import Keeper, begin
from synthdepth.pix2pix.objective import discriminator_loss, generator_losses
from synthdepth.pix2pix.state import State, follow
from synthdepth.pix2pix.validation import validate
from synthdepth.seeding import derive_seed


@dataclasses.dataclass(frozen=True, kw_only=True)
class TrainReport:
    """What a training came to.

    Attributes:
        rank: of this process; 0 reports.
        pairs: how many it trains with.
        epochs, steps: done in all.
        steps_now: done by this run.
        wall_s: of this run.
        elapsed_s: of all runs.
        best: errors of the best validation, with its epoch and step; None without validation.
    """

    rank: int
    pairs: int
    epochs: int
    steps: int
    steps_now: int
    wall_s: float
    elapsed_s: float
    best: dict | None


def train(
    config: TrainConfig,
    folders: Sequence[str | Path],
    out: Path,
    *,
    resume: bool = True,
    device: str | None = None,
    on_progress: Callable[[int, int], None] | None = None,
    on_validation: Callable[[dict], None] | None = None,
) -> TrainReport:
    """Train on the split "train" of some datasets, and validate on scenes of it that are kept back.

    `out` gets `config.json`, `log.jsonl`, `tensorboard/`, `last.safetensors` (the training whole)
    and `best.safetensors` (the generator with the lowest Rel). Stopped in any way, the same call
    goes on from the last checkpoint; on a CPU every loss is then the same to the bit as without the
    stop. Without decay, more `epochs` extend a finished training.

    Args:
        config: all that decides it.
        folders: dataset folders or addresses.
        out: folder of the training: new, or this training's.
        resume: whether to go on; if not, an `out` with a training in it is refused.
        device: "cpu", "cuda" or "cuda:1"; by default a GPU if there is one.
        on_progress: called with (pairs done, pairs in all).
        on_validation: called with the errors of each validation.

    Raises:
        DatasetError: see `TrainingData`; or the disk is full.
        SynthdepthError: `out` holds something else, or a loss is no number any more.
        KeyboardInterrupt: after Ctrl-C or SIGTERM, when a checkpoint was written.
    """
    out, started = Path(out), time.monotonic()
    with processes(device) as place, stop_requests() as stop:
        data = TrainingData(config, folders, place)
        state = State(config, place.device)
        facts = {
            "config": config.as_table(),
            "data": {"pairs": data.pairs, "shards": data.identity},
            "processes": place.ranks,
            "folders": [str(folder) for folder in folders],
        }
        begin(out, state, facts, resume=resume)
        first = state.progress.step
        place.wait()
        try:
            with Keeper(out, config, state, facts, place) as keeper:
                _learn(config, data, state, place, keeper, stop, on_progress, on_validation)
        except OSError as error:
            raise write_error(out / "log.jsonl", error) from error
        except torch.OutOfMemoryError:
            raise SynthdepthError(
                f"the memory of {place.device} is full: batch_size = {config.batch_size} or the "
                "size of the pictures has to be less"
            ) from None
        progress = state.progress
        return TrainReport(
            rank=place.rank,
            pairs=data.pairs,
            epochs=progress.epoch,
            steps=progress.step,
            steps_now=progress.step - first,
            wall_s=time.monotonic() - started,
            elapsed_s=progress.elapsed_s,
            best=progress.best,
        )


def _learn(
    config: TrainConfig,
    data: TrainingData,
    state: State,
    place: Place,
    keeper: Keeper,
    stop: threading.Event,
    on_progress: Callable[[int, int], None] | None,
    on_validation: Callable[[dict], None] | None,
) -> None:
    """All steps that are left."""
    progress, total = state.progress, config.epochs * data.steps
    generator, discriminator = _wrapped(config, state, place)
    state.generator.train()

    while progress.epoch < config.epochs:
        for batch in data.batches(progress.epoch, progress.position):
            state.set_lr(config.lr_at(progress.step / total))
            # A step's noise depends on its number alone: a run that begins here draws the same.
            torch.manual_seed(derive_seed(config.seed, "noise", progress.step, place.rank))
            losses = _step(
                config, state, generator, discriminator, _on_device(config, batch, place)
            )
            progress.step, progress.position = progress.step + 1, progress.position + 1
            if state.average is not None:
                follow(state.average, state.generator, config.ema, progress.step)

            line = keeper.count(losses)
            if on_progress and place.leads:
                on_progress(progress.step * data.pairs_a_step, total * data.pairs_a_step)
            # Several processes must agree to stop; they do so where the log has a line.
            if line or place.ranks == 1:
                stops = place.any(stop.is_set())
                if stops or keeper.due():
                    keeper.checkpoint()
                if stops:
                    raise KeyboardInterrupt

        keeper.line()
        progress.epoch, progress.position = progress.epoch + 1, 0
        last = progress.epoch == config.epochs
        every = config.validate_every
        if data.validation is not None and (last or progress.epoch % every == 0):
            errors = validate(state.model, data.validation, config, place)
            keeper.validated(errors, data.shown)
            if on_validation and place.leads:
                on_validation({"epoch": progress.epoch, **errors})
        keeper.checkpoint()


def _step(
    config: TrainConfig,
    state: State,
    generator: nn.Module,
    discriminator: nn.Module | None,
    batch: tuple[torch.Tensor, torch.Tensor, torch.Tensor],
) -> dict[str, torch.Tensor]:
    """One step of both networks; returns the losses before it, scalars by name."""
    image, target, valid = batch
    losses = {}
    half = torch.autocast(image.device.type, torch.bfloat16, enabled=config.precision == "bf16")
    with half:
        fake = generator(image)  # G(i, n), for both networks

    if discriminator is not None:
        # The discriminator, equation 15: the generator's share of the graph is left alone.
        state.discriminator.requires_grad_(True)
        with half:
            # The original's order, in which the running statistics see them.
            fake_logits = discriminator(image, fake.detach())
            real_logits = discriminator(image, target)
        losses["discriminator"] = discriminator_loss(real_logits, fake_logits)
        state.discriminator_adam.zero_grad()
        losses["discriminator"].backward()
        state.discriminator_adam.step()

        # The generator against the discriminator as it is now, whose weights need no gradients.
        state.discriminator.requires_grad_(False)
        with half:
            fake_logits = state.discriminator(image, fake)
    else:
        fake_logits = fake.new_zeros(())

    # Equation 17.
    losses |= generator_losses(
        fake_logits, fake, target, config=config.objective, coding=config.coding, valid=valid
    )
    state.generator_adam.zero_grad()
    losses["total"].backward()
    state.generator_adam.step()
    return losses


def _on_device(
    config: TrainConfig, batch: Batch, place: Place
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Input (B, C, H, W), coded depth (B, 1, H, W) and where it is known, bool."""
    tensors = (batch.input, batch.depth_m, batch.valid)
    image, depth_m, valid = (tensor.to(place.device, non_blocking=True) for tensor in tensors)
    return image, config.coding.encode(depth_m), valid


def _wrapped(config: TrainConfig, state: State, place: Place) -> tuple[nn.Module, nn.Module | None]:
    """Both networks as the loop calls them: perhaps compiled, gradients averaged over ranks."""

    def wrapped(network: nn.Module | None) -> nn.Module | None:
        if network is None:
            return None
        if config.compile:
            network.compile()
        if place.ranks == 1:
            return network
        with warnings.catch_warnings():
            # The option's successor is not in every torch that is allowed.
            warnings.filterwarnings("ignore", "`broadcast_buffers`", FutureWarning)
            # Running statistics are each rank's own; those of rank 0 are saved. A broadcast between
            # the discriminator's two calls would change what its backward pass needs.
            return DistributedDataParallel(network, broadcast_buffers=False)

    return wrapped(state.generator), wrapped(state.discriminator)
