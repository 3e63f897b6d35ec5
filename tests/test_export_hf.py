"""The Hugging Face export, read with `datasets` and, as any Parquet file, with pyarrow."""

import json
import re
import shutil

import numpy as np
import pyarrow.parquet as pq
import pytest

from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.pair import META_FIELDS, decode_pair
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.errors import DatasetError
from synthdepth.export import huggingface
from synthdepth.export.huggingface import export_hf
from tests.made import make_dataset

MODALITIES = ("flow", "seg", "normal")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(
        tmp_path_factory.mktemp("hf") / "set", shards=3, pairs=2, modalities=MODALITIES
    )


@pytest.fixture(scope="module")
def contents(folder):
    """{key: (pair, its files)}."""
    found = {}
    for record in read_manifest(folder)["shards"]:
        path = folder / record["path"]
        for key, members in shard_members(path).items():
            files = read_members(path, members)
            found[key] = decode_pair(key, files), files
    return found


@pytest.fixture(scope="module")
def out(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp("hf") / "out"
    told = []
    report = export_hf(folder, out, on_progress=lambda done, total: told.append((done, total)))
    assert (report.folder, report.pairs) == (out, 6)
    assert told[-1] == (6, 6)
    assert all("\n" not in note for note in report.notes)
    return out


@pytest.fixture(autouse=True)
def offline(monkeypatch):
    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    monkeypatch.setattr("datasets.config.HF_HUB_OFFLINE", True)


@pytest.fixture(scope="module")
def loaded(out, tmp_path_factory):
    return load(out, tmp_path_factory.mktemp("cache"))


def load(folder, cache):
    import datasets

    return datasets.load_dataset(str(folder), cache_dir=str(cache))


def test_the_columns_have_their_types(loaded):
    from datasets import Array2D, Array3D, Image, List, Value

    assert {name: len(rows) for name, rows in loaded.items()} == {"train": 4, "test": 2}
    features = loaded["train"].features
    assert features["key"] == Value("string")
    assert [features[name] for name in ("rgb", "prev", "seg")] == [Image()] * 3
    assert features["depth_m"] == Array2D(shape=(48, 64), dtype="float32")
    assert features["flow"] == Array3D(shape=(48, 64, 2), dtype="float32")
    assert features["visible"] == Array2D(shape=(48, 64), dtype="bool")
    assert features["normal"] == Array3D(shape=(48, 64, 3), dtype="float32")
    kinds = {int: Value("int64"), float: Value("float64"), str: Value("string")}
    for name, kind in META_FIELDS.items():
        if kind is not list:
            assert features[name] == kinds[kind], name
    assert features["intrinsics"] == Array2D(shape=(3, 3), dtype="float64")
    assert features["world_from_cam_prev"] == Array2D(shape=(4, 4), dtype="float64")
    assert features["velocity_mps"] == List(Value("float64"))


def test_nothing_is_lost(loaded, contents):
    seen = set()
    for split, rows in loaded.items():
        for row, arrays in zip(rows, rows.with_format("numpy"), strict=True):
            pair, _ = contents[row["key"]]
            seen.add(row["key"])
            assert pair.meta["split"] == split
            for name in ("rgb", "prev", "seg"):
                np.testing.assert_array_equal(np.array(row[name]), getattr(pair, name))
            for name in ("depth_m", "flow", "visible", "normal"):
                assert arrays[name].dtype == getattr(pair, name).dtype
                np.testing.assert_array_equal(arrays[name], getattr(pair, name))
            assert {name: row[name] for name in META_FIELDS} == pair.meta
            assert arrays["world_from_cam"].shape == (4, 4)
            # What the card says of `with_format`: it rounds what is not float32.
            np.testing.assert_allclose(arrays["world_from_cam"], pair.world_from_cam, atol=1e-5)
    assert seen == set(contents)


def test_pictures_are_the_same_files(loaded, contents):
    from datasets import Image

    for rows in loaded.values():
        for name in ("rgb", "prev", "seg"):
            raw = rows.cast_column(name, Image(decode=False))
            for row in raw:
                assert row[name]["bytes"] == contents[row["key"]][1][f"{name}.png"]


def test_it_streams(out, contents):
    import datasets

    rows = datasets.load_dataset(str(out), split="test", streaming=True)
    keys = [row["key"] for row in rows]
    assert keys == [key for key, (pair, _) in contents.items() if pair.meta["split"] == "test"]


def test_files_are_scenes_and_stand_alone(out, contents):
    files = sorted(path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file())
    assert files == [
        "README.md",
        "card.jpg",
        "data/test-00000-of-00001.parquet",
        "data/train-00000-of-00002.parquet",
        "data/train-00001-of-00002.parquet",
    ]
    table = pq.read_table(out / "data/train-00001-of-00002.parquet")
    keys = table["key"].to_pylist()
    assert keys == sorted(key for key in contents if "-s00002-" in key)
    depth = np.array(table["depth_m"].to_pylist(), np.float32)
    np.testing.assert_array_equal(depth, [contents[key][0].depth_m for key in keys])
    info = json.loads(table.schema.metadata[b"huggingface"])["info"]
    assert info["features"]["rgb"] == {"_type": "Image"}


def test_row_groups_stay_small(folder, tmp_path, monkeypatch, contents):
    pair = next(iter(contents.values()))[0]
    monkeypatch.setattr(huggingface, "_ROW_GROUP_BYTES", pair.depth_m.nbytes)
    export_hf(folder, tmp_path / "out", split="test")
    file = pq.ParquetFile(tmp_path / "out/data/test-00000-of-00001.parquet")
    assert [file.metadata.row_group(k).num_rows for k in range(file.num_row_groups)] == [1, 1]


def test_the_same_bytes_every_time(folder, out, tmp_path):
    export_hf(folder, tmp_path / "again")
    for path in out.rglob("*.*"):
        assert (tmp_path / "again" / path.relative_to(out)).read_bytes() == path.read_bytes()


def test_the_card_is_that_of_the_export(out, monkeypatch, capsys):
    text = (out / "README.md").read_text()
    assert "6 pairs (4 train, 2 test)" in text
    assert "12 wire" in text
    (snippet,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(out)
    monkeypatch.setattr("datasets.config.HF_DATASETS_CACHE", out.parent / "cache")
    exec(compile(snippet, "card", "exec"), {})
    assert "(48, 64, 3) float32" in capsys.readouterr().out


def test_one_split_of_a_plain_dataset(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=1)
    export_hf(folder, tmp_path / "out", split="test")
    text = (tmp_path / "out/README.md").read_text()
    assert "1 pairs (1 test)" in text
    assert "normal" not in text
    loaded = load(tmp_path / "out", tmp_path / "cache")
    assert {name: len(rows) for name, rows in loaded.items()} == {"test": 1}
    assert "seg" not in loaded["test"].features


def test_mistakes_are_told_in_a_line_and_leave_nothing(folder, tmp_path):
    with pytest.raises(DatasetError, match=r"split 'val': .* has test, train"):
        export_hf(folder, tmp_path / "out", split="val")
    with pytest.raises(DatasetError, match=r"holds no dataset"):
        export_hf(tmp_path / "nothing", tmp_path / "out")
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("precious")
    with pytest.raises(DatasetError, match=r"allowed is a new or an empty folder"):
        export_hf(folder, tmp_path / "mine")
    copy = shutil.copytree(folder, tmp_path / "copy")
    shard = copy / read_manifest(copy)["shards"][-1]["path"]
    shard.chmod(0o644)
    shard.write_bytes(shard.read_bytes()[:5000])
    with pytest.raises(DatasetError, match=rf"{shard.name} cannot be read: .*") as caught:
        export_hf(copy, tmp_path / "out")
    assert "\n" not in str(caught.value)
    assert {path.name for path in tmp_path.iterdir()} == {"mine", "copy"}
    assert {path.name for path in (tmp_path / "mine").iterdir()} == {"thesis.tex"}
