"""Shards: deterministic bytes, whole or not at all, readable by others."""

import gc
import hashlib
import subprocess
import tarfile

import pytest
import webdataset

from synthdepth.dataset.shard import ShardWriter, partial_of, read_members, sha256_of, shard_members
from synthdepth.errors import DatasetError

PAIRS = {
    f"neighborhood-s00000-f000-{n:04d}": {
        "rgb.png": b"r" * n,
        "meta.json": b"{}",
        "depth.exr": b"d",
    }
    for n in range(1, 6)
}


def write(path, pairs=PAIRS):
    with ShardWriter(path) as shard:
        for key, members in pairs.items():
            shard.add(key, members)
    return shard


def test_the_same_pairs_give_the_same_bytes(tmp_path):
    first, second = write(tmp_path / "a.tar"), write(tmp_path / "b.tar")
    data = (tmp_path / "a.tar").read_bytes()
    assert data == (tmp_path / "b.tar").read_bytes()
    assert first.sha256 == second.sha256 == hashlib.sha256(data).hexdigest()
    assert first.sha256 == sha256_of(tmp_path / "a.tar")
    assert first.size == len(data)


def test_members_are_found_by_offset(tmp_path):
    write(tmp_path / "a.tar")
    found = shard_members(tmp_path / "a.tar")
    assert list(found) == list(PAIRS)
    for key, members in found.items():
        assert read_members(tmp_path / "a.tar", members) == PAIRS[key]


# webdataset leaves its tar streams to the garbage collector.
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_webdataset_and_tar_read_it(tmp_path):
    write(tmp_path / "a.tar")
    samples = list(webdataset.WebDataset(str(tmp_path / "a.tar"), shardshuffle=False))
    gc.collect()
    assert {s["__key__"]: s["rgb.png"] for s in samples} == {
        key: members["rgb.png"] for key, members in PAIRS.items()
    }
    listed = subprocess.run(
        ["tar", "-tf", tmp_path / "a.tar"], check=True, capture_output=True, text=True
    )
    names = listed.stdout.split()
    assert names == sorted(names)
    assert len(names) == 3 * len(PAIRS)


def test_entries_carry_no_trace_of_time_or_user(tmp_path):
    write(tmp_path / "a.tar")
    with tarfile.open(tmp_path / "a.tar") as tar:
        assert {(i.mtime, i.uid, i.gid, i.uname, i.mode) for i in tar} == {
            (0, 0, 0, "synthdepth", 0o444)
        }


def test_a_failure_leaves_nothing(tmp_path):
    with pytest.raises(RuntimeError, match="half way"), ShardWriter(tmp_path / "a.tar") as shard:
        shard.add(*next(iter(PAIRS.items())))
        raise RuntimeError("half way")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("size", [10, 3_000_000])
def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path, size):
    """/dev/full refuses every byte: at once for a large file, on closing for a small one."""
    partial_of(tmp_path / "a.tar").symlink_to("/dev/full")
    with pytest.raises(DatasetError, match="disk of .* is full"):
        write(tmp_path / "a.tar", {"key": {"rgb.png": b"x" * size}})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["../x.rgb.png", "/etc/x.png", "folder/x.png", "nodot"])
def test_strange_members_are_refused(tmp_path, name):
    with tarfile.open(tmp_path / "a.tar", "w") as tar:
        tar.addfile(tarfile.TarInfo(name))
    with pytest.raises(ValueError, match="no file of a pair"):
        shard_members(tmp_path / "a.tar")


def test_archives_of_every_length_end(tmp_path):
    """They are padded to records of 20 blocks, of which the end takes two."""
    for blocks in range(1, 24):
        write(tmp_path / "a.tar", {"key": {"rgb.png": bytes(512 * blocks - 1)}})
        assert shard_members(tmp_path / "a.tar")["key"]["rgb.png"].size == 512 * blocks - 1


def test_no_flipped_bit_of_a_header_loses_a_pair_unnoticed(tmp_path):
    """tarfile takes a damaged header for the archive's end, without an error."""
    write(tmp_path / "a.tar")
    data = (tmp_path / "a.tar").read_bytes()
    whole = shard_members(tmp_path / "a.tar")
    for at in range(0, data.rindex(b"ustar"), 37):
        flipped = bytearray(data)
        flipped[at] ^= 1 << at % 8
        (tmp_path / "b.tar").write_bytes(flipped)
        try:
            found = shard_members(tmp_path / "b.tar")
        except ValueError:
            continue
        assert found == whole, at


@pytest.mark.parametrize("kept", [512 * 2, 512 * 6, 512 * 30, 512 * 31])
def test_an_archive_without_its_end_is_refused(tmp_path, kept):
    write(tmp_path / "a.tar")
    data = (tmp_path / "a.tar").read_bytes()
    assert len(data) > 512 * 32
    (tmp_path / "a.tar").write_bytes(data[:kept])
    with pytest.raises(ValueError, match="broken at byte|no readable tar"):
        shard_members(tmp_path / "a.tar")


def test_links_and_doubles_are_refused(tmp_path):
    with tarfile.open(tmp_path / "link.tar", "w") as tar:
        link = tarfile.TarInfo("a.rgb.png")
        link.type, link.linkname = tarfile.SYMTYPE, "/etc/passwd"
        tar.addfile(link)
    with pytest.raises(ValueError, match="no file of a pair"):
        shard_members(tmp_path / "link.tar")
    with tarfile.open(tmp_path / "twice.tar", "w") as tar:
        tar.addfile(tarfile.TarInfo("a.rgb.png"))
        tar.addfile(tarfile.TarInfo("a.rgb.png"))
    with pytest.raises(ValueError, match="twice"):
        shard_members(tmp_path / "twice.tar")


def test_a_file_that_is_no_tar_is_refused(tmp_path):
    (tmp_path / "a.tar").write_bytes(b"nothing of the kind" * 100)
    with pytest.raises(ValueError, match="no readable tar"):
        shard_members(tmp_path / "a.tar")
