"""The loaders: every pair exactly once, exactly as stored, in orders that can be repeated."""

import functools
import gc
import itertools
import json
import os
import pickle
import random
import re
import subprocess
import sys
import tarfile
import threading
from collections import Counter

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
import torch
import webdataset
from hypothesis import given, settings
from hypothesis import strategies as st
from torch.utils.data import DataLoader, IterableDataset

from synthdepth.dataset import PairDataset, PairStream, Sample, collate, pairs, sample_of
from synthdepth.dataset.manifest import INDEX, read_index
from synthdepth.dataset.pair import decode_pair
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.errors import DatasetError
from tests.made import make_dataset

SHARDS, PAIRS = 6, 3


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("loaders") / "set"
    return make_dataset(path, shards=SHARDS, pairs=PAIRS, modalities=("flow", "seg", "normal"))


@pytest.fixture(scope="module")
def stored(folder):
    """Every pair as the shards have it, read without an index: {key: Sample}."""
    found = {}
    for path in sorted(folder.rglob("*.tar")):
        for key, members in shard_members(path).items():
            found[key] = sample_of(decode_pair(key, read_members(path, members)))
    assert len(found) == SHARDS * PAIRS
    return found


def same(one: Sample, other: Sample) -> bool:
    for name, value in vars(one).items():
        theirs = getattr(other, name)
        if isinstance(value, np.ndarray):
            if value.dtype != theirs.dtype or not np.array_equal(value, theirs):
                return False
        elif value != theirs:
            return False
    return True


def keys_of(samples) -> list[str]:
    return [sample.key for sample in samples]


# Random access


def test_every_pair_is_as_it_was_stored(folder, stored):
    dataset = PairDataset(folder)
    assert keys_of(dataset) == read_index(folder)["key"].to_pylist()
    assert all(same(sample, stored[sample.key]) for sample in dataset)
    assert dataset[-1].key == dataset[len(dataset) - 1].key == dataset.key(len(dataset) - 1)
    for beyond in (len(dataset), -len(dataset) - 1):
        with pytest.raises(IndexError):
            dataset[beyond]


def test_only_the_fields_asked_for_are_read(folder, stored, monkeypatch):
    spans, pread = [], os.pread
    monkeypatch.setattr(os, "pread", lambda *span: spans.append(span[1:]) or pread(*span))
    sample = PairDataset(folder, fields=("rgb", "depth_m"))[4]
    row = read_index(folder).slice(4, 1).to_pylist()[0]
    read = {(row[f"{name}_size"], row[f"{name}_offset"]) for name in ("rgb", "depth", "meta")}
    assert set(spans) == read and len(spans) == 3
    whole = stored[sample.key]
    assert np.array_equal(sample.rgb, whole.rgb) and np.array_equal(sample.depth_m, whole.depth_m)
    assert sample.prev is sample.flow is sample.visible is sample.seg is sample.normal is None
    assert sample.meta == whole.meta and sample.valid.all()
    assert PairDataset(folder, fields="prev")[0].valid is None


def test_folders_follow_one_another_with_the_fields_that_all_have(folder, tmp_path):
    plain = make_dataset(tmp_path / "plain", shards=2, pairs=1, seed=7)
    both = PairDataset([folder, plain])
    assert len(both) == SHARDS * PAIRS + 2
    assert both.fields == ("rgb", "prev", "depth_m")
    assert same(both[len(both) - 1], PairDataset(plain)[1])
    chosen = {"altitude_m": (0, 1e3)}
    assert PairStream([folder, plain], where=chosen, shuffle=0).pairs == len(both)


@pytest.mark.parametrize("loader", [PairDataset, functools.partial(PairStream, shuffle=0)])
@settings(max_examples=12, deadline=None)
@given(
    conditions=st.none() | st.sets(st.sampled_from(["clear", "fog", "night"]), min_size=1),
    split=st.sampled_from([None, "train", "test"]),
    altitudes_m=st.none() | st.tuples(st.floats(0, 25), st.floats(0, 25)).map(sorted),
    frames=st.none() | st.tuples(st.integers(0, 4), st.integers(0, 4)).map(sorted),
)
def test_filters_agree_with_a_loop_over_the_metadata(
    folder, stored, loader, conditions, split, altitudes_m, frames
):
    where = {"condition": conditions, "altitude_m": altitudes_m, "frame_index": frames}
    where = {name: allowed for name, allowed in where.items() if allowed is not None}

    def wanted(meta):
        return (
            (conditions is None or meta["condition"] in conditions)
            and (split is None or meta["split"] == split)
            and (altitudes_m is None or altitudes_m[0] <= meta["altitude_m"] <= altitudes_m[1])
            and (frames is None or frames[0] <= meta["frame_index"] <= frames[1])
        )

    expected = sorted(key for key, sample in stored.items() if wanted(sample.meta))
    if not expected:
        with pytest.raises(DatasetError, match="no pair has"):
            loader(folder, split=split, where=where)
        return
    assert sorted(keys_of(loader(folder, split=split, where=where, fields="rgb"))) == expected


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"where": {"hight": (0, 1)}}, "where hight is unknown: allowed are .*altitude_m.*"),
        ({"where": {"world_from_cam": (0, 1)}}, "where world_from_cam is unknown: allowed .*"),
        ({"where": {"condition": "snow"}}, "condition = 'snow': allowed are clear, fog, night"),
        ({"where": {"condition": []}}, r"condition = \[\]: allowed are clear, fog, night"),
        ({"where": {"altitude_m": 5}}, r"altitude_m = 5: allowed is a range .*; there is .* to .*"),
        ({"where": {"altitude_m": (9, 5)}}, r"altitude_m = \(9, 5\): allowed is a range .*"),
        ({"where": {"altitude_m": (0, np.nan)}}, "altitude_m = .*nan.*: allowed is a range .*"),
        ({"where": {"altitude_m": ("a", "b")}}, "altitude_m = .*: allowed is a range .*"),
        ({"where": {"speed_mps": (90, np.inf)}}, "no pair has .*: there is speed_mps 8 to 8"),
        ({"split": "val"}, "split = 'val': allowed are test, train"),
        ({"fields": ("rgb", "depth")}, "fields = 'rgb', 'depth': allowed are rgb, prev, depth_m.*"),
        ({"fields": ()}, "fields = none: allowed are .*"),
    ],
)
@pytest.mark.parametrize("loader", [PairDataset, PairStream])
def test_an_impossible_choice_is_one_line_that_says_what_is_allowed(
    folder, loader, arguments, message
):
    with pytest.raises(DatasetError) as caught:
        loader(folder, **arguments)
    assert re.fullmatch(message, str(caught.value))


def test_what_is_no_dataset_is_named(folder, tmp_path):
    for loader in (PairDataset, PairStream):
        with pytest.raises(DatasetError, match="holds no dataset"):
            loader(tmp_path)
        with pytest.raises(DatasetError, match="no dataset was given"):
            loader([])
    unfinished = make_dataset(tmp_path / "unfinished", shards=2, pairs=1)
    (unfinished / INDEX).unlink()
    with pytest.raises(DatasetError, match=r"no index\.parquet: the run has not finished"):
        PairDataset(unfinished)
    (unfinished / INDEX).write_bytes(b"PAR1 but no more")
    with pytest.raises(DatasetError, match=r"index\.parquet cannot be read"):
        PairDataset(unfinished)
    assert len(list(PairStream(unfinished))) == 2
    with pytest.raises(DatasetError, match="there is no such shard"):
        PairStream(str(tmp_path / "x-{000000..000001}.tar"))
    with pytest.raises(DatasetError, match="split and where need a dataset folder"):
        PairStream(next(folder.rglob("*.tar")), split="train")
    with pytest.raises(DatasetError, match="shuffle = -1"):
        PairStream(folder, shuffle=-1)


def test_a_pickled_dataset_is_small_and_reads_the_same(folder, stored, tmp_path):
    dataset = PairDataset(folder)
    dataset[0]
    copy = pickle.loads(pickle.dumps(dataset))
    assert same(copy[5], dataset[5])
    index, many = read_index(folder), 20_000
    table = index.take(pa.array(np.arange(many) % len(index)))
    (tmp_path / "large").mkdir()
    pq.write_table(table, tmp_path / "large" / INDEX)
    large = PairDataset(tmp_path / "large", fields=("rgb", "depth_m"))
    assert len(large) == many
    assert len(pickle.dumps(large)) < 100 * many
    assert len(pickle.dumps(PairDataset(tmp_path / "large", where={"altitude_m": (0, 6)}))) < (
        150 * many
    )


def test_few_files_stay_open_and_none_after_use(folder, monkeypatch):
    monkeypatch.setattr(pairs, "_OPEN_FILES", 2)

    def open_shards():
        links = (f"/proc/self/fd/{number}" for number in os.listdir("/proc/self/fd"))
        targets = (os.readlink(link) for link in links if os.path.lexists(link))
        return sum(str(folder) in target for target in targets)

    gc.collect()
    before = open_shards()
    dataset = PairDataset(folder)
    order = list(range(len(dataset))) * 2
    random.Random(0).shuffle(order)
    assert [dataset[i].key for i in order] == [dataset.key(i) for i in order]
    assert open_shards() == before + 2
    del dataset
    assert open_shards() == before


def test_forked_workers_and_threads_read_what_one_process_reads(folder, stored):
    dataset = PairDataset(folder, fields=("rgb", "depth_m", "flow"))
    expected = [dataset[i] for i in range(len(dataset))]
    loader = DataLoader(dataset, batch_size=None, num_workers=2)
    assert all(same(a, b) for a, b in zip(loader, expected, strict=True))
    wrong = []

    def read():
        wrong.extend(i for i in range(len(dataset)) if not same(dataset[i], expected[i]))

    threads = [threading.Thread(target=read) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert not wrong


# Streams


def parts(stream, monkeypatch, ranks, workers) -> list[list[str]]:
    """The keys that each worker of each rank yields."""
    found = []
    for rank in range(ranks):
        for worker in range(workers):
            names = {"RANK": rank, "WORLD_SIZE": ranks, "WORKER": worker, "NUM_WORKERS": workers}
            with monkeypatch.context() as patch:
                for name, value in names.items():
                    patch.setenv(name, str(value))
                found.append(keys_of(stream))
    return found


@pytest.mark.parametrize("ranks", [1, 2, 4])
@pytest.mark.parametrize("workers", [1, 2, 8])
@pytest.mark.parametrize("shuffle", [0, 4, 1000])
def test_every_pair_comes_once_over_ranks_and_workers(
    folder, stored, monkeypatch, ranks, workers, shuffle
):
    stream = PairStream(folder, shuffle=shuffle, fields="seg")
    for epoch in (0, 1):
        stream.set_epoch(epoch)
        found = parts(stream, monkeypatch, ranks, workers)
        assert sorted(itertools.chain(*found)) == sorted(stored)
    # As many shards as there are; who has none yields nothing.
    assert sum(map(bool, found)) == min(SHARDS, ranks * workers)


# More workers than cores are the point.
@pytest.mark.filterwarnings("ignore:This DataLoader will create 8 worker")
def test_a_worker_without_a_shard_is_fine_in_a_real_loader(folder, stored):
    stream = PairStream(folder)
    assert isinstance(stream, IterableDataset)
    loader = DataLoader(stream, batch_size=None, num_workers=8)
    found = list(loader)
    assert sorted(keys_of(found)) == sorted(stored)
    assert all(same(sample, stored[sample.key]) for sample in found)
    assert stream.pairs == len(stored)


def test_a_process_group_is_split_over_where_there_are_no_variables(folder, stored, monkeypatch):
    """webdataset's own default refuses here; spawned workers would not even know of the group."""
    monkeypatch.setattr(torch.distributed, "is_initialized", lambda: True)
    monkeypatch.setattr(torch.distributed, "get_world_size", lambda group=None: 2)
    monkeypatch.setattr(torch.distributed, "group", type("group", (), {"WORLD": None}))
    found = []
    for rank in (0, 1):
        with monkeypatch.context() as patch:
            patch.setattr(torch.distributed, "get_rank", lambda group=None, rank=rank: rank)
            stream = PairStream(folder, shuffle=0)
            found += keys_of(stream)
            sent = pickle.dumps(stream)
            url = str(next(folder.rglob("*.tar")))
            with pytest.raises(ValueError, match="nodesplitter"):
                next(iter(webdataset.WebDataset(url, shardshuffle=False)))
        with monkeypatch.context() as patch:
            patch.setattr(torch.distributed, "is_initialized", lambda: False)
            assert keys_of(pickle.loads(sent)) == found[-len(stored) // 2 :]
    assert sorted(found) == sorted(stored)


def test_the_order_is_of_seed_and_epoch_alone(folder):
    def order(seed, epoch, shuffle=5):
        stream = PairStream(folder, seed=seed, shuffle=shuffle, fields="seg")
        stream.set_epoch(epoch)
        # Two passes without set_epoch are the same pass.
        assert keys_of(stream) == keys_of(stream)
        return keys_of(stream)

    orders = [order(seed, epoch) for seed in (0, 1) for epoch in (0, 1, 2)]
    assert len(set(map(tuple, orders))) == len(orders)
    assert order(1, 2) == orders[-1]
    assert order(0, 0, shuffle=0) == order(3, 9, shuffle=0) == keys_of(PairDataset(folder))
    # The shards' order changes too, not only the order within the buffer.
    scenes = [
        [key.split("-")[1] for key in order(0, epoch, shuffle=1)][::PAIRS] for epoch in (0, 1)
    ]
    assert scenes[0] != scenes[1]


def test_running_workers_see_the_next_epoch(folder, stored):
    """Persistent workers hold a copy of the dataset: a plain attribute would repeat the order."""
    stream = PairStream(folder, fields="seg", shuffle=4)
    loader = DataLoader(
        stream, batch_size=2, num_workers=2, persistent_workers=True, collate_fn=keys_of
    )
    passes = []
    for epoch in range(3):
        stream.set_epoch(epoch)
        passes.append([key for keys in loader for key in keys])
        assert sorted(passes[-1]) == sorted(stored)
    assert len(set(map(tuple, passes))) == 3
    # webdataset's with_epoch(n) would show the same first n each time.
    assert len({tuple(sorted(keys[:4])) for keys in passes}) > 1


def test_lone_shards_stream_by_name_and_pattern(folder, stored):
    pattern = str(folder / "train" / "blocks-train-{000000..000002}.tar")
    samples = list(PairStream(pattern, fields=("rgb", "flow"), shuffle=0))
    assert keys_of(samples) == [key for key, s in stored.items() if s.meta["split"] == "train"]
    assert all(np.array_equal(sample.flow, stored[sample.key].flow) for sample in samples)
    assert PairStream(pattern).pairs is None
    only = sorted((folder / "test").glob("*.tar"))
    assert len(list(PairStream(only))) == SHARDS // 2 * PAIRS


def test_no_shell_is_given_a_name(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("pipe:touch struck; cat x.tar", "pipe://touch struck.tar"):
        with pytest.raises(DatasetError):
            list(PairStream(name))
    assert not (tmp_path / "struck").exists() and not list(tmp_path.iterdir())


# Broken shards


def rewritten(path, change):
    data = bytearray(path.read_bytes())
    path.write_bytes(change(data))


def cut(data):
    return data[: len(data) // 2]


def scratched(data):
    """The header of the third pair's first file is noise."""
    start = data.index(b"-0003.depth.exr")
    data[start // 512 * 512 + 100 : start // 512 * 512 + 300] = b"\xa5" * 200
    return data


def no_png(data):
    start = data.index(b"\x89PNG")
    data[start : start + 64] = bytes(64)
    return data


@pytest.mark.parametrize("damage", [cut, scratched, no_png, lambda data: b"", lambda data: None])
def test_a_broken_shard_is_one_line_that_names_it(tmp_path, damage):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=3)
    path = folder / "train" / "blocks-train-000000.tar"
    if damage(bytearray(path.read_bytes())) is None:
        path.unlink()
    else:
        rewritten(path, damage)
    # The index knows where the files are: the header of a member may be noise.
    for loader in (PairStream, PairDataset)[: 1 if damage is scratched else 2]:
        with pytest.raises(DatasetError) as caught:
            list(loader(folder))
        assert path.name in str(caught.value) and "\n" not in str(caught.value)


def test_interleaved_members_are_refused(folder, tmp_path):
    """webdataset yields partial pairs from them without a word."""
    source = next((folder / "train").glob("*.tar"))
    with tarfile.open(source) as tar, tarfile.open(tmp_path / "mixed.tar", "w") as mixed:
        members = sorted(tar.getmembers(), key=lambda info: info.name.split(".", 1)[1])
        for info in members:
            mixed.addfile(info, tar.extractfile(info))
    for shuffle in (0, 100):
        with pytest.raises(DatasetError, match=r"mixed\.tar.*(beside|follow one another)"):
            list(PairStream(str(tmp_path / "mixed.tar"), shuffle=shuffle))


def test_a_workers_error_keeps_its_type_and_line(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=1, pairs=2)
    rewritten(next(folder.rglob("*.tar")), cut)
    with pytest.raises(DatasetError, match="DatasetError: .*blocks-train-000000.tar gives"):
        list(DataLoader(PairDataset(folder), batch_size=1, num_workers=1, collate_fn=collate))


# Batches


@pytest.mark.parametrize("loader", [PairDataset, PairStream])
def test_batches_through_two_workers(folder, stored, loader):
    dataset = loader(folder, split="train", fields=("rgb", "depth_m"))
    seen = Counter()
    for batch in DataLoader(dataset, batch_size=4, num_workers=2, collate_fn=collate):
        seen.update(batch.keys)
        for key, depth_m in zip(batch.keys, batch.depth_m, strict=True):
            assert np.array_equal(depth_m[0].numpy(), stored[key].depth_m)
    assert seen == Counter(key for key, s in stored.items() if s.meta["split"] == "train")


# Imports


def test_importing_loads_no_torch_and_a_stream_works_without_it(folder):
    code = f"""
import sys
from synthdepth.dataset.collate import Batch
from synthdepth.dataset import Batch, EmbedFlow, PairDataset, PairStream, RandomFlip, Resize
from synthdepth.dataset import Sample, collate
assert "torch" not in sys.modules and callable(collate)
sys.modules["torch"] = None
samples = list(PairStream({str(folder)!r}, transform=RandomFlip()))
print(len(samples), len(PairDataset({str(folder)!r})))
try:
    collate(samples)
except Exception as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == [
        "18 18",
        "batches need torch: install it with pip install 'synthdepth[train]'",
    ]


def test_metadata_is_that_of_the_shard(folder):
    sample = PairDataset(folder, fields="rgb")[7]
    path = folder / read_index(folder)["shard"][7].as_py()
    raw = read_members(path, shard_members(path)[sample.key])
    assert sample.meta == json.loads(raw["meta.json"])
    assert sample.max_depth_m == 200.0
