"""Pictures with ground truth to evaluate on: our datasets or KITTI."""

import dataclasses
import math
from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path

from synthdepth.dataset import PairDataset, Sample
from synthdepth.dataset.select import manifest_of, places
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.kitti.dataset import KittiDataset
from synthdepth.seeding import lane

# Where charts of KITTI end [m]; its laser reaches about as far.
_KITTI_FAR_M = 100.0
# What every evaluation reads, and what the breakdown reads where it is there.
_ALWAYS, _IF_THERE = ("rgb", "depth_m"), ("seg",)
# Pairs that baselines are fitted to: their means are known to a per cent with less.
_FIT_PAIRS = 1000


@dataclasses.dataclass(frozen=True, kw_only=True)
class Data:
    """What is evaluated on.

    Attributes:
        samples: by number; picklable.
        numbers: which of them.
        says: what it is, in words.
        split: of the data, in words.
        far_m: where charts end [m].
        dense: whether every pixel has a truth.
        folders: of our datasets.
        train: gives the pairs to fit baselines to; None where there are none.
    """

    samples: Sequence[Sample]
    numbers: tuple[int, ...]
    says: str
    split: str
    far_m: float
    dense: bool
    folders: tuple[str, ...] = ()
    train: Callable[[], Iterable[Sample]] | None = None

    def truth_of(self, sample: Sample) -> str:
        """The kind of a sample's ground truth, as `Protocol.truth` has it."""
        return "dense" if self.dense else sample.meta["depth"]

    def with_fields(self, fields: Collection[str]) -> "Data":
        """The same, reading no more than what is needed.

        Args:
            fields: what the sources need beside frame t.

        Raises:
            DatasetError: the data lack one of them.
        """
        if not self.folders:
            return self
        there = self.samples.fields
        for name in fields:
            if name not in there:
                raise DatasetError(
                    f"{self.says} has no {name}, which a source needs: there is {', '.join(there)}"
                )
        wanted = {*_ALWAYS, *fields, *(name for name in _IF_THERE if name in there)}
        fields = [name for name in there if name in wanted]
        samples = PairDataset(self.folders, split=self.split, fields=fields)
        return dataclasses.replace(self, samples=samples)


def pair_data(
    folders: Sequence[str | Path], *, split: str, max_pairs: int = 0, seed: int = 0
) -> Data:
    """Datasets of ours.

    Args:
        folders: one or several, or addresses.
        split: "train" or "test".
        max_pairs: so many, drawn once; 0 is all.
        seed: of the draw.

    Raises:
        DatasetError: no such dataset or split.
    """
    given = places(folders)
    samples = PairDataset(given, split=split)
    return Data(
        samples=samples,
        numbers=_drawn(len(samples), max_pairs, seed, "pairs"),
        says=", ".join(given),
        split=split,
        far_m=max(manifest_of(folder)["depth"]["max_depth_m"] for folder in given),
        dense=True,
        folders=tuple(given),
        train=_train_of(given, seed),
    )


def kitti_data(
    folder: Path,
    *,
    raw_folder: Path | None = None,
    split: str | None = None,
    split_file: Path | None = None,
    depth: str | None = None,
    variant: str | None = None,
    max_pairs: int = 0,
    seed: int = 0,
) -> Data:
    """KITTI; arguments as `KittiDataset` has them, `max_pairs` and `seed` as `pair_data`."""
    samples = KittiDataset(
        folder,
        raw_folder=raw_folder,
        split=split,
        split_file=split_file,
        depth=depth,
        **({} if variant is None else {"variant": variant}),
    )
    far_m = samples.max_depth_m
    return Data(
        samples=samples,
        numbers=_drawn(len(samples), max_pairs, seed, "frames"),
        says=str(folder),
        split=str(split_file or split or "all"),
        far_m=far_m if math.isfinite(far_m) else _KITTI_FAR_M,
        dense=False,
    )


def _drawn(count: int, most: int, seed: int, what: str) -> tuple[int, ...]:
    if not 0 < most < count:
        return tuple(range(count))
    return tuple(sorted(lane(seed, "evaluate", what).permutation(count)[:most].tolist()))


def _train_of(folders: list[str], seed: int) -> Callable[[], Iterable[Sample]] | None:
    try:
        pairs = PairDataset(folders, split="train", fields=("depth_m",))
    except SynthdepthError:
        return None
    numbers = _drawn(len(pairs), _FIT_PAIRS, seed, "fit")
    return lambda: (pairs[number] for number in numbers)
