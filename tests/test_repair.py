"""Damage of every kind is found, named, and repaired to the original bytes, or refused politely."""

import json
import shutil
import subprocess

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from synthdepth.cli import main
from synthdepth.dataset import verify_shard
from synthdepth.dataset.checksums import settle
from synthdepth.dataset.gate_contract import contract_checks
from synthdepth.dataset.manifest import CHECKSUMS, DERIVED, DESCRIPTIONS, MANIFEST, read_manifest
from synthdepth.dataset.shard import ShardWriter, read_members, sha256_of, shard_members
from synthdepth.dataset.verify import verify
from synthdepth.errors import DatasetError
from synthdepth.production import repair as repairing
from synthdepth.production.repair import repair
from tests.made import make_dataset
from tests.shards_made import in_this_process, made_shard, render, without_rendering

TRAIN, TEST = "train/blocks-train-000000.tar", "test/blocks-test-000000.tar"


def contents(folder):
    return {
        p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()
    }


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A dataset of a run, all but the rendering."""
    folder = tmp_path_factory.mktemp("whole") / "set"
    with pytest.MonkeyPatch.context() as patch:
        without_rendering(patch)
        render(folder)
    assert verify(folder).faults == []
    return folder


@pytest.fixture(autouse=True)
def without_statistics(monkeypatch):
    """What pictures say is asked elsewhere, and takes most of the time."""
    monkeypatch.setattr(verify_shard, "gate_pair", contract_checks)


@pytest.fixture
def copy(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "copy")


@pytest.fixture
def quick(monkeypatch):
    """Shards are made again by formula."""
    monkeypatch.setattr(repairing, "run_shard_job", made_shard)
    monkeypatch.setattr(repairing, "run_jobs", in_this_process)
    monkeypatch.setattr(repairing, "activate", lambda backend, threads: None)
    return monkeypatch


def told(folder):
    return {fault.where: fault.kind for fault in verify(folder).faults}


# Finding


@settings(
    max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(data=st.data())
def test_any_flipped_bit_is_found_and_named(whole, data):
    name = data.draw(st.sampled_from([*DESCRIPTIONS, TRAIN, TEST]))
    path = whole / name
    before = path.read_bytes()
    bit = data.draw(st.integers(0, 8 * len(before) - 1))
    flipped = bytearray(before)
    flipped[bit // 8] ^= 1 << bit % 8
    path.write_bytes(flipped)
    try:
        assert told(whole) == {name: "damaged"}
    finally:
        path.write_bytes(before)


@pytest.mark.parametrize("name", [*DESCRIPTIONS, TRAIN])
def test_truncated_missing_and_grown_files_are_named(copy, name):
    path = copy / name
    data = path.read_bytes()
    for kept in (0, len(data) // 3, len(data) - 1):
        path.write_bytes(data[:kept])
        assert told(copy) == {name: "truncated"}
    path.write_bytes(data + b"\0")
    assert told(copy) == {name: "grown"}
    path.unlink()
    assert told(copy) == {name: "missing"}


@pytest.mark.parametrize(
    ("first", "second"),
    [(TRAIN, TEST), ("README.md", "card.jpg"), (MANIFEST, "index.parquet"), (CHECKSUMS, TRAIN)],
)
def test_swapped_files_are_told_from_copies(copy, first, second):
    one, other = ((copy / name).read_bytes() for name in (first, second))
    (copy / first).write_bytes(other)
    faults = {fault.where: fault for fault in verify(copy).faults}
    assert faults.keys() == {first} and faults[first].what == f"is a copy of {second}"
    (copy / second).write_bytes(one)
    faults = {fault.where: fault.what for fault in verify(copy).faults}
    assert faults == {first: f"is {second}", second: f"is {first}"}


def test_what_belongs_to_nobody_is_told_from_what_a_kill_leaves(copy):
    left = [f"{TRAIN}.node-77.partial", "dataset.json.node-1.partial", "repair.partial/x.tar"]
    for name in [*left, "notes.txt", "train/look.jpg", "film.mkv.partial"]:
        (copy / name).parent.mkdir(exist_ok=True)
        (copy / name).write_bytes(b"?")
    (copy / TEST).rename(copy / "test" / "mine.tar")
    expected = dict.fromkeys(left, "leftover") | {TEST: "missing", "test/mine.tar": "misplaced"}
    strangers = dict.fromkeys(["notes.txt", "train/look.jpg", "film.mkv.partial"], "stranger")
    assert told(copy) == expected | strangers


def rewritten(path, **changes):
    """The shard with other metadata in every pair."""
    pairs = {key: read_members(path, files) for key, files in shard_members(path).items()}
    with ShardWriter(path) as shard:
        for key, files in pairs.items():
            meta = json.loads(files["meta.json"]) | changes
            shard.add(key, files | {"meta.json": json.dumps(meta).encode()})


@pytest.mark.parametrize(
    ("changes", "kind", "words"),
    [
        ({"scene_seed": 5}, "stale", "is of another seed: its scene is 5"),
        ({"spp": 64}, "stale", "is of another recipe: spp is 64, the dataset's is 4"),
        ({"map": "city"}, "foreign", "is of the map city, not of this dataset"),
    ],
)
def test_shards_of_other_runs_are_named(copy, changes, kind, words):
    rewritten(copy / TRAIN, **changes)
    (fault,) = verify(copy).faults
    assert (fault.where, fault.kind, fault.what) == (TRAIN, kind, words)


def test_a_shorter_state_of_a_shard_is_named(copy):
    (key, files), *_ = shard_members(copy / TRAIN).items()
    content = read_members(copy / TRAIN, files)
    with ShardWriter(copy / TRAIN) as shard:
        shard.add(key, content)
    (fault,) = verify(copy).faults
    assert (fault.kind, fault.what) == ("stale", "holds 1 pairs, not 3: another state of it")


def test_a_pair_in_two_shards_and_a_scene_in_two_splits_are_found(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=1)
    manifest = read_manifest(folder)
    train, test = manifest["shards"]
    shutil.copyfile(folder / train["path"], folder / test["path"])
    twice = {name: train[name] for name in ("scene_index", "scene_seed", "sha256", "bytes")}
    manifest["shards"][1] = test | twice
    (folder / CHECKSUMS).unlink()
    del manifest["files"]
    (folder / MANIFEST).write_text(json.dumps(manifest))
    faults = [fault.what for fault in verify(folder).faults]
    assert any("its scene is in both splits" in what for what in faults)
    assert any("is also in" in what for what in faults)


def test_sha256sum_reads_the_checksums(whole):
    check = ["sha256sum", "--check", "--strict", "--quiet", CHECKSUMS]
    assert subprocess.run(check, cwd=whole, capture_output=True, check=True).stdout == b""
    listed = subprocess.run(
        ["sha256sum", "--check", CHECKSUMS], cwd=whole, capture_output=True, text=True, check=True
    ).stdout
    assert len(listed.splitlines()) == len(contents(whole)) - 1


def test_side_by_side_finds_the_same(copy, monkeypatch):
    # Other processes do not know what this one leaves out.
    monkeypatch.undo()
    data = bytearray((copy / TRAIN).read_bytes())
    data[5000] ^= 1
    (copy / TRAIN).write_bytes(data)
    alone = verify(copy)
    assert verify(copy, workers=2) == alone
    assert alone.checks["warp"].judged > 0


def test_an_older_dataset_is_still_checked(copy):
    """As before there were checksums: no file of them, nothing of them in the manifest."""
    manifest = read_manifest(copy)
    del manifest["files"]
    for record in manifest["shards"]:
        del record["redrawn"]
    (copy / CHECKSUMS).unlink()
    (copy / MANIFEST).write_text(json.dumps(manifest, indent=1))
    report = verify(copy)
    assert report.faults == [] and "older than checksums.sha256" in report.notes[0]
    (copy / TEST).write_bytes((copy / TEST).read_bytes()[:-1])
    (copy / "card.jpg").unlink()
    assert told(copy) == {TEST: "truncated", "card.jpg": "missing"}


# Repairing


DAMAGES = {
    "truncated shard": lambda f: (f / TRAIN).write_bytes((f / TRAIN).read_bytes()[:999]),
    "missing shards": lambda f: shutil.rmtree(f / "train"),
    "swapped": lambda f: swap(f, TRAIN, TEST),
    "swapped across kinds": lambda f: swap(f, TRAIN, "card.jpg"),
    "copied over": lambda f: shutil.copyfile(f / TEST, f / TRAIN),
    "renamed": lambda f: (f / TRAIN).rename(f / "train" / "old.tar"),
    "of another seed": lambda f: rewritten(f / TEST, scene_seed=1),
    "no descriptions": lambda f: [(f / name).unlink() for name in DERIVED],
    "no manifest": lambda f: (f / MANIFEST).unlink(),
    "empty manifest": lambda f: (f / MANIFEST).write_bytes(b""),
    "another seed in the manifest": lambda f: (f / MANIFEST).write_text(
        (f / MANIFEST).read_text().replace('"seed": 0', '"seed": 1')
    ),
    "manifest renamed": lambda f: (f / MANIFEST).rename(f / "old.json"),
    "checksums renamed": lambda f: (f / CHECKSUMS).rename(f / "train" / "old.txt"),
    "manifest and checksums exchanged": lambda f: swap(f, MANIFEST, CHECKSUMS),
    "no checksums": lambda f: (f / CHECKSUMS).unlink(),
    "half of the checksums": lambda f: (f / CHECKSUMS).write_bytes(
        (f / CHECKSUMS).read_bytes()[:600]
    ),
    "leftovers": lambda f: (f / f"{TEST}.node-5.partial").write_bytes(b"half"),
    "several": lambda f: [
        (f / TRAIN).unlink(), (f / "README.md").unlink(), (f / MANIFEST).write_bytes(b"{"),
        swap(f, TEST, "index.parquet"),
    ],
}  # fmt: skip


def swap(folder, first, second):
    one, other = ((folder / name).read_bytes() for name in (first, second))
    (folder / first).write_bytes(other)
    (folder / second).write_bytes(one)


@pytest.mark.parametrize("damage", DAMAGES)
@pytest.mark.usefixtures("quick")
def test_damage_is_repaired_to_the_same_bytes(whole, copy, damage):
    DAMAGES[damage](copy)
    repairs = repair(copy, verify(copy).faults)
    assert repairs and all(one.done for one in repairs)
    assert contents(copy) == contents(whole)


def test_a_copy_of_what_is_in_its_place_is_left_alone(copy):
    shutil.copyfile(copy / TEST, copy / "test" / "mine.tar")
    (one,) = repair(copy, verify(copy).faults)
    assert one.where == "test/mine.tar" and not one.done and "remove it yourself" in one.what
    assert (copy / "test" / "mine.tar").exists()


@pytest.mark.usefixtures("quick")
def test_the_command_repairs_and_says_what_it_did(whole, copy, capsys, tmp_path):
    (copy / TRAIN).write_bytes(b"no tar at all")
    (copy / "card.jpg").unlink()
    assert main(["verify", str(copy)]) == 1
    out = capsys.readouterr().out
    assert f"{TRAIN}: is truncated: 13 of " in out and "card.jpg: is missing" in out
    assert main(["verify", str(copy), "--repair", "--json", str(tmp_path / "found.json")]) == 0
    out = capsys.readouterr().out
    assert f"{TRAIN}: rendered again to the same bytes" in out and "2 files repaired, 0 not" in out
    found = json.loads((tmp_path / "found.json").read_text())
    assert {fault["kind"] for fault in found["faults"]} == {"truncated", "missing"}
    assert [one["done"] for one in found["repairs"]] == [True, True]
    assert contents(copy) == contents(whole)
    assert main(["verify", str(copy), "--repair"]) == 0


def test_other_versions_give_other_bytes_and_nothing_is_replaced(quick, copy):
    manifest = settle(copy).manifest
    for name in (TRAIN, TEST):
        (copy / name).write_bytes(b"damaged")

    def other(job, recipe, folder, progress):
        return made_shard(job, recipe, folder, progress) | {"sha256": "other"}

    quick.setattr(repairing, "run_shard_job", other)
    here = manifest["software"] | {"mitsuba": "9.9"}
    quick.setattr(repairing, "software", lambda variant: here)
    repairs = repair(copy, verify(copy).faults)
    assert [one.done for one in repairs] == [False, False]
    assert f"mitsuba 9.9, not {manifest['software']['mitsuba']}" in repairs[0].what
    assert (copy / TRAIN).read_bytes() == (copy / TEST).read_bytes() == b"damaged"
    assert not (copy / "repair.partial").exists()


@pytest.mark.usefixtures("quick")
def test_what_hangs_on_a_lost_shard_waits_for_it(copy, monkeypatch):
    def failing(job, recipe, folder, progress):
        raise DatasetError("no")

    monkeypatch.setattr(repairing, "run_shard_job", failing)
    (copy / TRAIN).unlink()
    (copy / "index.parquet").unlink()
    repairs = {one.where: one for one in repair(copy, verify(copy).faults)}
    assert repairs[TRAIN].what == "cannot be rendered: no"
    assert f"as long as {TRAIN} is not whole" in repairs["index.parquet"].what


def test_what_was_not_rendered_here_cannot_be_rendered_again(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=1)
    before = contents(folder)
    (folder / TRAIN).unlink()
    (one,) = repair(folder, verify(folder).faults)
    assert not one.done and "variant none" in one.what
    (folder / TRAIN).write_bytes(before[TRAIN])
    swap(folder, TRAIN, TEST)
    (folder / "README.md").unlink()
    assert all(one.done for one in repair(folder, verify(folder).faults))
    assert contents(folder) == before


@pytest.mark.usefixtures("quick")
def test_content_that_was_written_wrong_is_not_written_again(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=1, pairs=1)
    path = folder / TRAIN
    rewritten(path, pitch_deg=1.5)
    manifest = read_manifest(folder)
    manifest["shards"][0] |= {"sha256": sha256_of(path), "bytes": path.stat().st_size}
    del manifest["files"]
    (folder / CHECKSUMS).unlink()
    (folder / MANIFEST).write_text(json.dumps(manifest))
    (fault,) = verify(folder).faults
    assert fault.kind == "gate" and "pitch or roll" in fault.what
    before = path.read_bytes()
    assert not any(one.done for one in repair(folder, [fault]) if one.where.startswith(TRAIN))
    assert path.read_bytes() == before


def test_both_copies_of_the_manifest_gone_is_one_line(copy, capsys):
    for name in (MANIFEST, CHECKSUMS):
        data = bytearray((copy / name).read_bytes())
        data[200:210] = b"0123456789"
        (copy / name).write_bytes(data)
    assert main(["verify", str(copy), "--repair"]) == 2
    error = capsys.readouterr().err
    assert "both dataset.json and checksums.sha256 are damaged" in error
    assert error.count("\n") == 1


@pytest.mark.usefixtures("quick")
def test_an_unfinished_run_is_not_repaired(copy, capsys):
    manifest = read_manifest(copy)
    del manifest["files"]
    (copy / CHECKSUMS).unlink()
    (copy / MANIFEST).write_text(json.dumps(manifest | {"complete": False, "pairs_planned": 90}))
    assert told(copy)[MANIFEST] == "unfinished"
    assert main(["verify", str(copy), "--repair"]) == 2
    assert "the same render command goes on" in capsys.readouterr().err


def test_the_manifest_is_read_from_either_file(whole, tmp_path):
    expected = read_manifest(whole)
    rng = np.random.default_rng(0)
    for name in (MANIFEST, CHECKSUMS):
        for _ in range(40):
            folder = tmp_path / "two"
            folder.mkdir(exist_ok=True)
            for one in (MANIFEST, CHECKSUMS):
                shutil.copyfile(whole / one, folder / one)
            data = bytearray((folder / name).read_bytes())
            at = int(rng.integers(8 * len(data)))
            data[at // 8] ^= 1 << at % 8
            (folder / name).write_bytes(data)
            settled = settle(folder)
            assert settled.manifest == expected and settled.sealed
            assert settled.right[MANIFEST] == (whole / MANIFEST).read_bytes()
            assert settled.right[CHECKSUMS] == (whole / CHECKSUMS).read_bytes()
