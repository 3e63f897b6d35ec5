"""The pairs of a training: which, in which order, in which batches."""

import dataclasses
import hashlib
import json
import signal
from collections.abc import Iterator, Sequence
from pathlib import Path

import cv2
import numpy as np
import torch
from torch.utils.data import DataLoader, Subset

from synthdepth.dataset import Batch, PairDataset, RandomFlip, Resize, collate
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.select import manifest_of, places
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.pix2pix.augment import JitterColours
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.distributed import Place
from synthdepth.pix2pix.inputs import MakeInput
from synthdepth.seeding import derive_seed, lane

# What validates does not depend on the training's seed: so trainings differ by their models alone.
_ANY_SEED = 0


class TrainingData:
    """The split "train" of some datasets, mixed anew in every epoch, but for some scenes of it.

    These, drawn in each dataset and the same whatever the seed, validate: the split "test" is never
    read, so that a model chosen by its validation has not been chosen on what it is judged by.
    Which pairs make up a batch, and what is drawn for each, depends on the seed and the epoch
    alone: not on workers, nor on where a training began again.

    Args:
        config: of the training.
        folders: dataset folders, or addresses.
        place: which of the processes this is.

    Attributes:
        identity: of the datasets: a hash of what their shards hold.
        steps: of an epoch.
        validation: iterable of this process's batches of the scenes kept back, always the same;
            None where there is no validation.
        shown: a batch of a few of them, for pictures.

    Raises:
        DatasetError: a folder that is no dataset, has not the split or not what the input needs,
            saturates nearer than `coding.max_depth_m`, has too few pairs for a step, or no scene
            to keep back.
    """

    def __init__(self, config: TrainConfig, folders: Sequence[str | Path], place: Place):
        manifests = {folder: manifest_of(folder) for folder in places(folders)}
        for folder, manifest in manifests.items():
            _check_range(folder, manifest, config)
        shards = [record["sha256"] for m in manifests.values() for record in m["shards"]]
        self.identity = hashlib.sha256(json.dumps(shards).encode()).hexdigest()
        self._config, self._place = config, place

        known = {"split": "train", "fields": _fields(config)}
        self._source = PairDataset(list(manifests), **known, transform=_train_steps(config))
        kept_back = _kept_back(self._source.scenes, config)
        self._pairs = _chosen(self._source, ~kept_back, config.max_pairs, config.seed, "pairs")
        self.steps = len(self._pairs) // (config.batch_size * place.ranks)
        if self.steps == 0:
            raise DatasetError(
                f"{len(self._pairs)} pairs in split train: allowed is at least batch_size = "
                f"{config.batch_size} times {place.ranks} process(es)"
            )
        self._batches = _Batches()
        self._loader = _loader(self._pairs, config, place, batch_sampler=self._batches)
        self.validation = self.shown = None
        if config.validate_every:
            source = PairDataset(list(manifests), **known, transform=_steps(config, config.seed))
            self._set_validation(source, kept_back)

    @property
    def pairs(self) -> int:
        """How many there are to train with."""
        return len(self._pairs)

    @property
    def pairs_a_step(self) -> int:
        """How many a step takes, over all processes."""
        return self._config.batch_size * self._place.ranks

    def batches(self, epoch: int, first: int = 0) -> Iterator[Batch]:
        """This process's batches of an epoch, from number `first` on."""
        self._source.set_epoch(epoch)
        order = lane(self._config.seed, "order", epoch).permutation(len(self._pairs))
        size, ranks, rank = self._config.batch_size, self._place.ranks, self._place.rank
        # (steps, ranks, size): a step's pairs follow one another, whatever the number of processes.
        order = order[: self.steps * ranks * size].reshape(self.steps, ranks, size)
        self._batches.numbers = order[first:, rank].tolist()
        return _raising(self._loader)

    def _set_validation(self, source: PairDataset, kept_back: np.ndarray) -> None:
        config, place = self._config, self._place
        chosen = _chosen(source, kept_back, config.validation_pairs, _ANY_SEED, "validation")
        count = len(chosen)
        self.shown = collate([chosen[k] for k in sorted({k * count // 4 for k in range(4)})])
        mine = Subset(chosen, range(place.rank, count, place.ranks))
        self.validation = _Validation(_loader(mine, config, place, batch_size=config.batch_size))


class _Validation:
    """Batches of this process's validation pairs, the same at every pass."""

    def __init__(self, loader: DataLoader):
        self._loader = loader

    def __iter__(self) -> Iterator[Batch]:
        return _raising(self._loader)


class _Batches:
    """A batch sampler whose batches are set from outside, so that workers stay for the next."""

    def __init__(self):
        self.numbers: list[list[int]] = []

    def __iter__(self) -> Iterator[list[int]]:
        return iter(self.numbers)

    def __len__(self) -> int:
        return len(self.numbers)


def _fields(config: TrainConfig) -> tuple[str, ...]:
    return (*config.input.fields, "depth_m")


def _steps(config: TrainConfig, seed: int) -> list:
    resize = [] if config.size is None else [Resize(height=config.size[1], width=config.size[0])]
    return [*resize, MakeInput(config.input, seed=seed), _bare]


def _train_steps(config: TrainConfig) -> list:
    seed = derive_seed(config.seed, "augmentation")
    *resize, make_input, bare = _steps(config, seed)
    varied = [RandomFlip(config.augmentation.flip, seed=seed)]
    if config.augmentation.changes_pictures:
        varied.append(JitterColours(config.augmentation, seed=seed))
    return [*resize, *varied, make_input, bare]


def _bare(sample: Sample) -> Sample:
    """Input and depth alone: nothing else has to travel from the workers."""
    return dataclasses.replace(
        sample, rgb=None, prev=None, flow=None, visible=None, meta={},
        world_from_cam=None, world_from_cam_prev=None,
    )  # fmt: skip


def _kept_back(scenes: np.ndarray, config: TrainConfig) -> np.ndarray:
    """(N,) bool, the pairs of the scenes that validate: a share of each dataset's, at least one.

    A dataset of one scene trains with it; one dataset must have more.
    """
    kept_back = np.zeros(len(scenes), bool)
    if not config.validate_every:
        return kept_back
    for folder in np.unique(scenes[:, 0]):
        here = scenes[:, 0] == folder
        names = np.unique(scenes[here, 1])
        count = min(max(1, round(config.validation_share * len(names))), len(names) - 1)
        drawn = lane(_ANY_SEED, "kept back", int(folder)).permutation(names)[:count]
        kept_back |= here & np.isin(scenes[:, 1], drawn)
    if not kept_back.any():
        raise DatasetError(
            "the split train has one scene: allowed are two or more, as validation keeps scenes "
            "back, or validate_every = 0"
        )
    return kept_back


def _chosen(source: PairDataset, allowed: np.ndarray, most: int, seed: int, what: str) -> Subset:
    """All pairs that are allowed, or `most` of them, drawn once and in their order."""
    numbers = np.flatnonzero(allowed)
    if 0 < most < len(numbers):
        numbers = np.sort(lane(seed, "chosen", what).permutation(numbers)[:most])
    return Subset(source, numbers.tolist())


def _check_range(folder: str, manifest: dict, config: TrainConfig) -> None:
    there_m, wanted_m = manifest["depth"]["max_depth_m"], config.coding.max_depth_m
    if there_m < wanted_m:
        raise DatasetError(
            f"{folder} saturates at {there_m:g} m: allowed is coding.max_depth_m up to that, and "
            f"it is {wanted_m:g}"
        )


class _Safe:
    """A dataset that returns users' errors: torch would bury their one line in a traceback."""

    def __init__(self, pairs: Subset):
        self._pairs = pairs

    def __len__(self) -> int:
        return len(self._pairs)

    def __getitem__(self, number: int) -> Sample | SynthdepthError:
        try:
            return self._pairs[number]
        except SynthdepthError as error:
            return error


def _collated(samples: list[Sample | SynthdepthError]) -> Batch | SynthdepthError:
    try:
        for sample in samples:
            if isinstance(sample, SynthdepthError):
                return sample
        return collate(samples)
    except SynthdepthError as error:
        return error


def _raising(loader: DataLoader) -> Iterator[Batch]:
    for batch in loader:
        if isinstance(batch, SynthdepthError):
            # A new one: what is raised here must not be held here, or the workers outlive it.
            raise type(batch)(*batch.args)
        yield batch


def _start_worker(_: int) -> None:
    # A process a core needs no threads, and a fork does not carry OpenCV's along.
    cv2.setNumThreads(0)
    # Ctrl-C reaches all processes of a terminal; the training decides when to stop.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)


def _loader(pairs: Subset, config: TrainConfig, place: Place, **how) -> DataLoader:
    workers = min(config.workers, len(pairs))
    return DataLoader(
        _Safe(pairs),
        num_workers=workers,
        collate_fn=_collated,
        worker_init_fn=_start_worker,
        persistent_workers=workers > 0 and "batch_sampler" in how,
        pin_memory=place.device.type == "cuda",
        # Of its own, so that nothing is drawn from torch's generator.
        generator=torch.Generator().manual_seed(0),
        **how,
    )
