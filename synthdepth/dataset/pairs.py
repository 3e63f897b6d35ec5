"""Our datasets by number: any pair at once, straight out of its shard."""

import functools
import operator
import os
from collections.abc import Callable, Collection, Iterable, Mapping
from pathlib import Path

import numpy as np

from synthdepth.dataset.pair import camera_of, decode_fields, decode_meta
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.select import Where, is_remote, places, read_rows
from synthdepth.dataset.transforms import set_epoch_of, several, transformed
from synthdepth.errors import DatasetError

# Shards that a process holds open at once.
_OPEN_FILES = 64

Transform = Callable[[Sample], Sample]


class PairDataset:
    """A map-style dataset (`torch.utils.data.Dataset` without the need for torch) of `Sample`.

    The index says where each file of a pair lies, so a pair costs as many reads as it has fields.
    May be forked and pickled into workers; both are cheap.

    Args:
        folder: a dataset folder, or several that follow one another; paths, or addresses that
            fsspec knows (`https://...`, `s3://...`) if they answer range requests.
        split: "train" or "test"; None is both.
        where: only these pairs: {column of the index: value, collection of values, or closed range
            (low, high)}, e.g. `{"condition": ["clear", "fog"], "altitude_m": (5, 20)}`.
        fields: what is read and decoded, any of rgb, prev, depth_m, flow, seg, normal; the others
            are None. By default all that every folder has. `valid` comes with the depth, `visible`
            with the flow; metadata, intrinsics and poses always come.
        transform: a callable from Sample to Sample, or a list of them, applied in turn.

    Raises:
        DatasetError: see `select.read_rows`.
    """

    def __init__(
        self,
        folder: str | Path | Iterable[str | Path],
        *,
        split: str | None = None,
        where: Where | None = None,
        fields: Collection[str] | None = None,
        transform: Transform | Iterable[Transform] | None = None,
    ):
        self._rows, self.fields = read_rows(places(folder), split=split, where=where, fields=fields)
        self._transforms = several(transform)
        self._open = _opener()

    def __len__(self) -> int:
        return len(self._rows.keys)

    def __getitem__(self, number: int) -> Sample:
        """Pair `number`; IndexError beyond the last, DatasetError where it cannot be read."""
        number = operator.index(number)
        if not -len(self) <= number < len(self):
            raise IndexError(f"pair {number} of {len(self)}")
        number %= len(self)
        key, shard = self.key(number), self._rows.shards[self._rows.shard_of[number]]
        spans = {name: span[number].tolist() for name, span in self._rows.members.items()}
        read = _read_remote if is_remote(shard) else self._read
        sample = decode_sample(key, read(shard, key, spans), self.fields, shard)
        return transformed(self._transforms, sample)

    def key(self, number: int) -> str:
        """The name of pair `number`, without reading the pair."""
        return self._rows.keys[number].as_py()

    @property
    def scenes(self) -> np.ndarray:
        """(N, 2) int64, of each pair: which folder it is from, and which scene of it it shows."""
        return self._rows.scenes

    def set_epoch(self, epoch: int) -> None:
        """Tell the transforms the number of the pass, for what they draw."""
        set_epoch_of(self._transforms, epoch)

    def _read(self, shard: str, key: str, spans: Mapping[str, list[int]]) -> dict[str, bytes]:
        try:
            # pread has no position that forked processes would share.
            file = self._open(shard)
            # No more than there is: an index may say anything, and memory comes first.
            files = {
                name: os.pread(file.descriptor, min(size, file.size), offset)
                for name, (offset, size) in spans.items()
            }
        except OSError as error:
            raise DatasetError(f"{shard} cannot be read: {error.strerror}") from error
        return _whole(shard, key, files, spans)

    def __getstate__(self) -> dict:
        return {name: value for name, value in self.__dict__.items() if name != "_open"}

    def __setstate__(self, state: dict) -> None:
        self.__dict__ |= state
        self._open = _opener()


class _OpenFile:
    """A file descriptor that is closed when nobody uses it any more, and the file's size."""

    def __init__(self, path: str):
        self.descriptor = -1
        self.descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
        self.size = os.fstat(self.descriptor).st_size

    # Bound now: when Python exits, the module may be gone before the file.
    def __del__(self, close=os.close):
        if self.descriptor >= 0:
            close(self.descriptor)


def _opener() -> Callable[[str], _OpenFile]:
    """Opens files, and keeps the last used open."""
    return functools.lru_cache(_OPEN_FILES)(_OpenFile)


def _read_remote(shard: str, key: str, spans: Mapping[str, list[int]]) -> dict[str, bytes]:
    import fsspec

    # Every kind of storage has errors of its own. Connections are fsspec's, one set a process.
    try:
        system, path = fsspec.core.url_to_fs(shard)
        starts = [offset for offset, _ in spans.values()]
        ends = [offset + size for offset, size in spans.values()]
        found = system.cat_ranges([path] * len(spans), starts, ends, on_error="raise")
    except Exception as error:
        raise DatasetError(f"{shard} cannot be read: {error or type(error).__name__}") from error
    return _whole(shard, key, dict(zip(spans, found, strict=True)), spans)


def _whole(shard: str, key: str, files: dict[str, bytes], spans) -> dict[str, bytes]:
    for name, (_, size) in spans.items():
        if len(files[name]) != size:
            raise DatasetError(
                f"{shard} gives {len(files[name])} bytes of {key}.{name} instead of {size}: "
                "it is cut off, or its server answers no range requests"
            )
    return files


def decode_sample(
    key: str, files: Mapping[str, bytes], fields: Iterable[str], shard: str
) -> Sample:
    """The sample of a pair's files, of which only `fields` are decoded.

    Args:
        key: name of the pair.
        files: {"rgb.png": bytes}, with meta.json.
        fields: names in `pair.FIELDS`.
        shard: where they are from, for the error.

    Raises:
        DatasetError: a file is missing or broken; names the shard and the pair.
    """
    try:
        meta = decode_meta(files["meta.json"])
        known = decode_fields(files, fields, meta)
    except KeyError as error:
        raise DatasetError(
            f"{shard}: pair {key} has no {error.args[0]} beside its other files"
        ) from None
    except ValueError as error:
        raise DatasetError(f"{shard}: pair {key} is broken: {error}") from error
    depth_m = known.get("depth_m")
    return Sample(
        key=key,
        valid=None if depth_m is None else np.ones(depth_m.shape, bool),
        max_depth_m=meta["max_depth_m"],
        intrinsics=camera_of(meta).matrix,
        world_from_cam=np.array(meta["world_from_cam"]),
        world_from_cam_prev=np.array(meta["world_from_cam_prev"]),
        meta=meta,
        **{"rgb": None, "depth_m": None} | known,
    )
