"""Our datasets as a stream: shards one after another, local or remote, shuffled on the way."""

import contextlib
import dataclasses
import tarfile
from collections import Counter
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from synthdepth.dataset.archive import entries, mapped
from synthdepth.dataset.manifest import INDEX, MANIFEST, pair_files
from synthdepth.dataset.pair import FIELDS
from synthdepth.dataset.pairs import Transform, decode_sample
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.select import (
    Where,
    checked_fields,
    is_remote,
    manifest_of,
    open_file,
    places,
    read_rows,
    within,
)
from synthdepth.dataset.transforms import SharedEpoch, set_epoch_of, several, transformed
from synthdepth.errors import DatasetError
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class _Shard:
    """A shard to read: `pairs` of it, or None if nobody has said; only `keys`, or None for all."""

    place: str
    pairs: int | None = None
    keys: frozenset[str] | None = None


class PairStream:
    """An iterable dataset of `Sample`; a `torch.utils.data.IterableDataset` where torch is there.

    Shards are dealt out to the ranks of a distributed run and to the workers of each, so that every
    pair comes exactly once in a pass; who gets no shard yields nothing. **Ranks may get different
    numbers of pairs**, and a `DistributedDataParallel` run hangs at the end of the pass if one rank
    has a batch more than another: there, use `PairDataset` with torch's `DistributedSampler`.

    The order depends on the seed, the epoch and the numbers of ranks and workers, and on nothing
    else. It is the same in every pass until `set_epoch` is called, which workers that are already
    running (`persistent_workers=True`) see too.

    Args:
        source: a dataset folder or a list of them; or a shard (`....tar`), a pattern of shards
            (`....-{000000..000009}.tar`), or a list of these. Paths, or addresses that fsspec knows
            (`https://...`, `s3://...`).
        split: "train" or "test"; None is both. Of folders only.
        where: as `PairDataset` has it. Of folders only.
        shuffle: pairs held back in each worker to be drawn from, about 0.4 MB each at 256 x 256
            pixels; the first pair comes when so many were read. 0 keeps the order of the shards.
        seed: of the order.
        fields: as `PairDataset` has it; of shards without a folder, which say nothing of what they
            hold, rgb, prev and depth_m by default.
        transform: a callable from Sample to Sample, or a list of them, applied in turn.

    Raises:
        DatasetError: no such dataset, or a filter or field it does not have; while iterating, a
            shard that cannot be read, with its name.
    """

    def __new__(cls, *_, **__):
        """Make it pass for an IterableDataset; a base class would load torch with this module."""
        with contextlib.suppress(ModuleNotFoundError):
            from torch.utils.data import IterableDataset

            IterableDataset.register(cls)
        return super().__new__(cls)

    def __init__(
        self,
        source: str | Path | Iterable[str | Path],
        *,
        split: str | None = None,
        where: Where | None = None,
        shuffle: int = 1000,
        seed: int = 0,
        fields: Collection[str] | None = None,
        transform: Transform | Iterable[Transform] | None = None,
    ):
        if not isinstance(shuffle, int) or shuffle < 0:
            raise DatasetError(f"shuffle = {shuffle!r}: allowed is a whole number from 0")
        given = places(source)
        if all(place.endswith(".tar") for place in given):
            self._shards = _lone_shards(given, split, where)
            fields = ("rgb", "prev", "depth_m") if fields is None else fields
            self.fields = checked_fields(fields, list(FIELDS))
        else:
            self._shards, self.fields = _shards_of_folders(given, split, where, fields)
        self._files = tuple(f".{name}" for name in ("meta.json", *map(FIELDS.get, self.fields)))
        self._transforms = several(transform)
        self._shuffle, self._seed, self._epoch = shuffle, seed, SharedEpoch()
        self._rank = (0, 1)

    @property
    def pairs(self) -> int | None:
        """How many pairs a pass has over all ranks and workers; None if the shards alone know."""
        counts = [shard.pairs if shard.keys is None else len(shard.keys) for shard in self._shards]
        return None if None in counts else sum(counts)

    def set_epoch(self, epoch: int) -> None:
        """Say which pass comes next: each has an order of its own. Reaches the transforms too."""
        self._epoch.set(epoch)
        set_epoch_of(self._transforms, epoch)

    def __iter__(self) -> Iterator[Sample]:
        rank, ranks, worker, workers = self._place()
        seed, epoch, shards = self._seed, self._epoch.get(), self._shards
        if self._shuffle:
            order = lane(seed, "shards", epoch).permutation(len(shards))
            shards = [shards[k] for k in order]
        raw = self._raw_pairs(shards[rank::ranks][worker::workers])
        if self._shuffle:
            raw = _shuffled(raw, self._shuffle, lane(seed, "pairs", epoch, rank, worker))
        for pair in raw:
            sample = decode_sample(pair["__key__"], pair, self.fields, pair["__url__"])
            yield transformed(self._transforms, sample)

    def _place(self) -> tuple[int, int, int, int]:
        """(rank, ranks, worker, workers) of this process."""
        from webdataset.utils import pytorch_worker_info

        rank, ranks, worker, workers = pytorch_worker_info()
        # A worker that was spawned, not forked, does not know that its parent is one of several.
        rank, ranks = (rank, ranks) if ranks > 1 else self._rank
        return rank, ranks, worker, workers

    def __getstate__(self) -> dict:
        return self.__dict__ | {"_rank": self._place()[:2]}

    def _raw_pairs(self, shards: list[_Shard]) -> Iterator[dict]:
        """The files of one pair after another: {"__key__", "__url__", "rgb.png": bytes, ...}."""
        for shard in shards:
            found = Counter()
            # Broken archives and every kind of storage have errors of their own.
            try:
                for pair in self._grouped(shard.place):
                    found[pair["__key__"]] += 1
                    if shard.keys is None or pair["__key__"] in shard.keys:
                        yield pair
            except Exception as error:
                raise DatasetError(f"{shard.place} cannot be read: {_reason(error)}") from error
            twice = [key for key, count in found.items() if count > 1]
            if twice:
                raise DatasetError(
                    f"{shard.place}: the files of {twice[0]} do not follow one another"
                )
            # tarfile takes a broken header in the middle for the end.
            if shard.pairs is not None and len(found) != shard.pairs:
                raise DatasetError(
                    f"{shard.place} holds {len(found)} readable pairs, and its manifest says "
                    f"{shard.pairs}: it is broken or from another run"
                )

    def _grouped(self, place: str) -> Iterator[dict]:
        from webdataset.tariterators import group_by_keys

        with open_file(place) as stream:
            yield from group_by_keys(self._members(place, stream))

    def _members(self, place: str, stream: BinaryIO) -> Iterator[dict]:
        """The files that the fields are in, as webdataset groups them."""
        # On the disk what is not wanted is stepped over; a remote shard comes in one piece.
        how = ("r|", stream) if is_remote(place) else ("r:", mapped(stream))
        with tarfile.open(None, *how) as tar:
            for info in entries(tar):
                if info.isreg() and info.name.endswith(self._files):
                    data = tar.extractfile(info).read()
                    yield {"fname": info.name, "data": data, "__url__": place}


def _reason(error: Exception) -> str:
    """Why a shard cannot be read, in few words."""
    if isinstance(error, OSError) and error.strerror:
        return error.strerror
    return str(error.args[0] if error.args else type(error).__name__)


def _lone_shards(given: list[str], split: str | None, where: Where | None) -> list[_Shard]:
    if split is not None or where:
        raise DatasetError(
            f"split and where need a dataset folder, which has an index; {given[0]} is a shard"
        )
    from braceexpand import braceexpand

    shards = [_Shard(place=place) for pattern in given for place in braceexpand(pattern)]
    for shard in shards:
        if not is_remote(shard.place) and not Path(shard.place).is_file():
            raise DatasetError(f"{shard.place}: there is no such shard")
    return shards


def _shards_of_folders(
    folders: list[str], split: str | None, where: Where | None, fields: Collection[str] | None
) -> tuple[list[_Shard], tuple[str, ...]]:
    """The shards of folders by their manifests; where pairs are filtered, also by their indexes."""
    manifests = [manifest_of(folder) for folder in folders]
    records = {
        within(folder, record["path"]): record
        for folder, manifest in zip(folders, manifests, strict=True)
        for record in manifest["shards"]
    }
    if where:
        rows, fields = read_rows(folders, split=split, where=where, fields=fields)
        unknown = [place for place in rows.shards if place not in records]
        if unknown:
            raise DatasetError(
                f"{unknown[0]} stands in {INDEX} but not in {MANIFEST}; synthdepth verify says more"
            )
        keys = [[] for _ in rows.shards]
        for number, key in zip(rows.shard_of.tolist(), rows.keys.to_pylist(), strict=True):
            keys[number].append(key)
        shards = [
            _Shard(place=place, pairs=records[place]["pairs"], keys=frozenset(chosen))
            for place, chosen in zip(rows.shards, keys, strict=True)
            if chosen
        ]
        return shards, fields
    here = [name for name, file in FIELDS.items() if all(file in pair_files(m) for m in manifests)]
    splits = sorted({record["split"] for record in records.values()})
    if split is not None and split not in splits:
        raise DatasetError(f"split = {split!r}: allowed are {', '.join(splits)}")
    shards = [
        _Shard(place=place, pairs=record["pairs"])
        for place, record in records.items()
        if split in (None, record["split"])
    ]
    return shards, checked_fields(fields, here)


def _shuffled(pairs: Iterator, held: int, rng: np.random.Generator) -> Iterator:
    """The same pairs, each drawn from the `held` that are there at a time."""
    buffer = []
    for pair in pairs:
        if len(buffer) < held:
            buffer.append(pair)
            continue
        k = int(rng.integers(held))
        buffer[k], pair = pair, buffer[k]
        yield pair
    for k in rng.permutation(len(buffer)):
        yield buffer[k]
