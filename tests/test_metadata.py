"""What a dataset folder says of itself, read with the libraries that others will read it with."""

import json
import logging
import re
import shutil
import subprocess
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from synthdepth.dataset.card import LICENSE, LICENSE_URL
from synthdepth.dataset.exr import decode_depth, decode_flow, decode_normal
from synthdepth.dataset.manifest import DESCRIPTIONS, read_index, read_manifest
from synthdepth.dataset.pair import META_FIELDS, decode_pair
from synthdepth.dataset.shard import ShardWriter, read_members, sha256_of, shard_members
from synthdepth.dataset.verify import verify
from synthdepth.production.storage import LocalFolder
from tests.made import make_dataset

MODALITIES = ("flow", "seg", "normal")

# mlcroissant leaves files open, and pandas and rdflib complain of how it calls them; webdataset
# leaves its streams to the garbage collector.
pytestmark = [
    pytest.mark.filterwarnings("ignore::ResourceWarning"),
    pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning"),
    pytest.mark.filterwarnings("ignore::DeprecationWarning:rdflib"),
    pytest.mark.filterwarnings("ignore:The inplace keyword"),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(
        tmp_path_factory.mktemp("metadata") / "set", shards=3, pairs=2, modalities=MODALITIES
    )


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """One scene, one split, no modalities."""
    return make_dataset(tmp_path_factory.mktemp("metadata") / "plain", shards=1, pairs=2)


@pytest.fixture(scope="module")
def pairs(folder):
    return read_pairs(folder)


def read_pairs(folder):
    found = []
    for record in read_manifest(folder)["shards"]:
        path = folder / record["path"]
        for key, members in shard_members(path).items():
            found.append(decode_pair(key, read_members(path, members)))
    return found


@pytest.fixture(autouse=True)
def offline(monkeypatch, tmp_path):
    """No network, and caches of this test alone."""
    from mlcroissant._src.operation_graph.operations import extract

    monkeypatch.setattr("huggingface_hub.constants.HF_HUB_OFFLINE", True)
    monkeypatch.setattr("datasets.config.HF_HUB_OFFLINE", True)
    monkeypatch.setattr(extract, "EXTRACT_PATH", type(extract.EXTRACT_PATH)(tmp_path / "unpacked"))


def load(folder, cache):
    import datasets

    return datasets.load_dataset(str(folder), cache_dir=str(cache))


def header_of(folder):
    import yaml

    return yaml.safe_load((folder / "README.md").read_text().split("---\n")[1])


def tables_of(folder):
    """The tables of the card: {first cell of the head: [{head: cell}]}."""
    found, lines = {}, (folder / "README.md").read_text().splitlines()
    for number, line in enumerate(lines):
        if line.startswith("| ---"):
            head = cells(lines[number - 1])
            rows = found.setdefault(head[0], [])
            for row in lines[number + 1 :]:
                if not row.startswith("|"):
                    break
                rows.append(dict(zip(head, cells(row), strict=True)))
    return found


def cells(line):
    return [cell.strip() for cell in line.strip("|").split("|")]


# The folder


def test_the_descriptions_are_there_and_the_same_every_time(folder, tmp_path):
    assert verify(folder).faults == []
    again = make_dataset(tmp_path / "again", shards=3, pairs=2, modalities=MODALITIES)
    for name in DESCRIPTIONS:
        assert (again / name).read_bytes() == (folder / name).read_bytes(), name


@pytest.mark.parametrize("name", ["README.md", "card.jpg", "croissant.json"])
def test_verify_misses_them_and_a_run_sweeps_what_is_half_written(folder, tmp_path, name):
    copy = shutil.copytree(folder, tmp_path / "copy")
    (copy / name).rename(copy / f"{name}.123.partial")
    told = {(fault.where, fault.what) for fault in verify(copy).faults}
    left = f"{name}.123.partial", "is left over from a run that was killed"
    assert told == {(name, "is missing"), left}
    with LocalFolder(copy).swept():
        pass
    assert [fault.where for fault in verify(copy).faults] == [name]


# The card


def test_the_card_tells_the_figures(folder, pairs):
    tables = tables_of(folder)
    assert [(row["split"], row["pairs"], row["scenes"]) for row in tables["split"]] == [
        ("train", "4", "2"),
        ("test", "2", "1"),
    ]
    shards = [shard_members(path).values() for path in folder.glob("train/*.tar")]
    size = sum(file.size for shard in shards for files in shard for file in files.values())
    assert tables["split"][0]["MB"] == f"{size / 1e6:.1f}"
    assert tables["condition"] == [{"condition": "pairs", "clear": "2", "fog": "2", "night": "2"}]
    rows = {row["share of the pairs below"]: row for row in tables["share of the pairs below"]}
    middle = {
        "altitude above ground [m]": [p.world_from_cam[2, 3] for p in pairs],
        "nearest surface in the picture [m]": [p.depth_m.min() for p in pairs],
        "median depth of the picture [m]": [np.median(p.depth_m) for p in pairs],
    }
    for words, values in middle.items():
        assert float(rows[words]["50 %"]) == pytest.approx(np.median(values), abs=0.051)
    shares = [
        float(share.rstrip(" %")) for share in list(tables["nearest surface"][0].values())[1:]
    ]
    near = [p.depth_m.min() for p in pairs]
    assert sum(shares) == pytest.approx(100, abs=3)
    assert shares[3] == pytest.approx(100 * np.mean([10 <= m < 25 for m in near]), abs=0.5)


def test_the_card_shows_pictures_small(folder):
    assert "](card.jpg)" in (folder / "README.md").read_text()
    assert (folder / "card.jpg").stat().st_size < 1e6
    assert cv2.imread(str(folder / "card.jpg")).std() > 20


@pytest.mark.parametrize(("pairs", "size"), [(999, "n<1K"), (1000, "1K<n<10K"), (2e6, "1M<n<10M")])
def test_the_header_says_the_size_as_the_hub_has_it(plain, pairs, size):
    import yaml

    from synthdepth.dataset.card import hub_header

    text = hub_header(read_manifest(plain), pairs, [("train", "train/*.tar")], [])
    assert yaml.safe_load(text.split("---")[1])["size_categories"] == [size]


def test_the_header_is_what_the_hub_asks_for(folder, plain):
    from huggingface_hub import DatasetCard

    header = DatasetCard.load(folder / "README.md").data.to_dict()
    assert header["license"] == LICENSE
    assert header["task_categories"] == ["depth-estimation"]
    assert header["configs"][0]["data_files"] == [
        {"split": "train", "path": "train/*.tar"},
        {"split": "test", "path": "test/*.tar"},
    ]
    assert [entry["split"] for entry in header_of(plain)["configs"][0]["data_files"]] == ["train"]


def test_only_what_is_there_is_described(folder, plain):
    told = {path: (path / "README.md").read_text() for path in (folder, plain)}
    for word in ("flow.exr", "seg.png", "normal.exr"):
        assert word in told[folder]
        assert word not in told[plain]
    assert [row["split"] for row in tables_of(plain)["split"]] == ["train"]
    assert "2 pairs (2 train)" in " ".join(told[plain].split())


@pytest.mark.parametrize("name", ["folder", "plain"])
def test_the_cards_snippets_run(name, request, monkeypatch, capsys):
    folder = request.getfixturevalue(name)
    keys = [pair.key for pair in read_pairs(folder) if pair.meta["split"] == "train"]
    snippets = re.findall(r"```python\n(.*?)```", (folder / "README.md").read_text(), re.DOTALL)
    assert len(snippets) == 3
    monkeypatch.chdir(folder)
    for snippet in snippets:
        exec(compile(snippet, "card", "exec"), {})
        told = capsys.readouterr().out.splitlines()
        assert [line.split()[0] for line in told] in (keys, keys[:2])  # all, or the first shard


# Hugging Face datasets


def test_datasets_reads_the_folder_as_it_is(folder, pairs, tmp_path):
    import datasets

    loaded = load(folder, tmp_path)
    assert {name: len(rows) for name, rows in loaded.items()} == {"train": 4, "test": 2}
    features = loaded["train"].features
    assert all(isinstance(features[f"{n}.png"], datasets.Image) for n in ("rgb", "prev", "seg"))
    assert features["depth.exr"] == datasets.Value("binary")
    assert list(features["meta.json"]) == list(META_FIELDS)
    # What the card declares is what `datasets` itself would write.
    assert header_of(folder)["dataset_info"]["features"] == features._to_yaml_list()
    rows = {row["__key__"]: row for rows in loaded.values() for row in rows}
    assert set(rows) == {pair.key for pair in pairs}
    for pair in pairs:
        row = rows[pair.key]
        np.testing.assert_array_equal(np.array(row["rgb.png"]), pair.rgb)
        np.testing.assert_array_equal(np.array(row["prev.png"]), pair.prev)
        np.testing.assert_array_equal(np.array(row["seg.png"]), pair.seg)
        np.testing.assert_array_equal(decode_depth(row["depth.exr"]), pair.depth_m)
        np.testing.assert_array_equal(decode_flow(row["flow.exr"])[0], pair.flow)
        np.testing.assert_array_equal(decode_normal(row["normal.exr"]), pair.normal)
        assert row["meta.json"] == pair.meta
        assert [type(v) for v in row["meta.json"].values()] == list(META_FIELDS.values())


def test_types_do_not_hang_on_the_first_pairs(plain, tmp_path):
    """Whole numbers in the first five pairs, and a field that comes later, cost nothing."""
    copy = shutil.copytree(plain, tmp_path / "copy")
    path = copy / read_manifest(copy)["shards"][0]["path"]
    (key, members), *_ = shard_members(path).items()
    files = read_members(path, members)
    meta = json.loads(files["meta.json"])
    heights = [1, 2, 3, 4, 5, 6.25]
    with ShardWriter(path) as shard:
        for number, height in enumerate(heights):
            told = meta | {"altitude_m": height}
            if number < 5:
                del told["condition"]
            line = {"meta.json": json.dumps(told).encode()}
            shard.add(f"{key}{number}", files | line)
    rows = load(copy, tmp_path / "cache")["train"]["meta.json"]
    assert [row["altitude_m"] for row in rows] == heights
    assert rows[5]["condition"] == meta["condition"]


def test_files_beside_the_shards_do_not_outvote_them(plain, tmp_path):
    copy = shutil.copytree(plain, tmp_path / "copy")
    for number in range(5):
        (copy / "train" / f"look-{number}.jpg").write_bytes((copy / "card.jpg").read_bytes())
        (copy / f"notes-{number}.json").write_text('{"a": 1}')
    loaded = load(copy, tmp_path / "cache")
    assert {name: len(rows) for name, rows in loaded.items()} == {"train": 2}
    assert "depth.exr" in loaded["train"].features


# Croissant


@pytest.mark.parametrize("name", ["folder", "plain"])
def test_mlcroissant_has_nothing_to_say(name, request, caplog):
    import mlcroissant

    path = request.getfixturevalue(name) / "croissant.json"
    with caplog.at_level(logging.WARNING):
        metadata = mlcroissant.Dataset(path).metadata
    assert (metadata.ctx.issues.errors, metadata.ctx.issues.warnings) == (set(), set())
    assert not caplog.records


def test_its_command_line_has_nothing_to_say(folder):
    program = Path(sys.executable).with_name("mlcroissant")
    arguments = [program, "validate", "--jsonld", folder / "croissant.json"]
    done = subprocess.run(arguments, capture_output=True, text=True)
    assert done.returncode == 0
    # absl marks its lines: I for information, W and E for worse.
    assert re.fullmatch(r"I\d+ .*Done\.\n", done.stderr), done.stderr


def test_what_the_specification_requires_is_there(folder, plain):
    """`mlcroissant validate` misses most of these."""
    document = json.loads((folder / "croissant.json").read_text())
    for name in ("name", "description", "license", "url", "creator", "datePublished"):
        assert document[name], name
    assert document["license"] == LICENSE_URL
    assert document["@type"] == "sc:Dataset"
    assert document["conformsTo"] == "http://mlcommons.org/croissant/1.0"
    assert (folder / document["url"]).is_file()
    files = [f for f in document["distribution"] if f["@type"] == "cr:FileObject"]
    assert {f["contentUrl"] for f in files} == {
        "index.parquet",
        *(record["path"] for record in read_manifest(folder)["shards"]),
    }
    for file in files:
        assert file["sha256"] == sha256_of(folder / file["contentUrl"])
    shards = {f["@id"] for f in files if f["encodingFormat"] == "application/x-tar"}
    sets = [f for f in document["distribution"] if f["@type"] == "cr:FileSet"]
    assert len(sets) == 3 + len(MODALITIES)
    for one in sets:
        assert {entry["@id"] for entry in one["containedIn"]} == shards
    splits = {
        path: [row["splits/name"] for row in tables["splits"]["data"]]
        for path in (folder, plain)
        for tables in [record_sets(json.loads((path / "croissant.json").read_text()))]
    }
    assert splits == {folder: ["train", "test"], plain: ["train"]}


def record_sets(document):
    return {table["@id"]: table for table in document["recordSet"]}


def records(folder, table):
    import mlcroissant

    # A Dataset yields a table once; a second time it gives no rows.
    return list(mlcroissant.Dataset(folder / "croissant.json").records(table))


def test_mlcroissant_reads_pictures_and_depth(folder, pairs):
    for table, kind, decode in (
        ("rgb", "rgb", np.array),
        ("prev", "prev", np.array),
        ("seg", "seg", np.array),
        ("depth", "depth_m", decode_depth),
        ("normal", "normal", decode_normal),
        ("flow", "flow", lambda data: decode_flow(data)[0]),
    ):
        rows = {
            row[f"{table}/key"].decode(): row[f"{table}/{table}"] for row in records(folder, table)
        }
        assert set(rows) == {pair.key for pair in pairs}
        for pair in pairs:
            np.testing.assert_array_equal(decode(rows[pair.key]), getattr(pair, kind))


def test_mlcroissant_reads_the_metadata(folder):
    """From the index: `jsonPath` on files of an archive gives None, without an error."""
    document = json.loads((folder / "croissant.json").read_text())
    assert "jsonPath" not in json.dumps(document["recordSet"])
    rows, index = records(folder, "pairs"), read_index(folder).to_pylist()
    assert len(rows) == len(index)
    for row, known in zip(rows, index, strict=True):
        for name in ("key", "shard", *META_FIELDS):
            value = row[f"pairs/{name}"]
            assert (value.decode() if isinstance(value, bytes) else value) == known[name], name
    split_names = {row["splits/name"] for row in records(folder, "splits")}
    assert split_names == {row["pairs/split"].decode() for row in rows}


def test_exr_is_text_to_croissant_as_it_would_fail_as_a_picture(folder):
    tables = record_sets(json.loads((folder / "croissant.json").read_text()))
    kinds = {name: table["field"][-1]["dataType"] for name, table in tables.items()}
    assert {kinds[name] for name in ("depth", "flow", "normal")} == {"sc:Text"}
    assert {kinds[name] for name in ("rgb", "prev", "seg")} == {"sc:ImageObject"}


def test_another_dataset_with_the_same_names_needs_a_cache_of_its_own(plain, tmp_path, monkeypatch):
    """mlcroissant keeps unpacked shards by their names; the card says what to do about it."""
    from mlcroissant._src.operation_graph.operations import extract

    assert "CROISSANT_CACHE" in (plain / "README.md").read_text()
    other = make_dataset(tmp_path / "other", shards=1, pairs=2, seed=1)
    first = records(plain, "rgb")
    monkeypatch.setattr(extract, "EXTRACT_PATH", type(extract.EXTRACT_PATH)(tmp_path / "fresh"))
    for folder, rows in ((plain, first), (other, records(other, "rgb"))):
        for row, pair in zip(rows, read_pairs(folder), strict=True):
            np.testing.assert_array_equal(np.array(row["rgb/rgb"]), pair.rgb)


def test_mlcroissant_notices_a_shard_that_is_another(plain, tmp_path):
    import mlcroissant

    copy = shutil.copytree(plain, tmp_path / "copy")
    path = copy / read_manifest(copy)["shards"][0]["path"]
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.chmod(0o644)
    path.write_bytes(data)
    with pytest.raises(mlcroissant.GenerationError) as caught:
        records(copy, "rgb")
    assert "Hash of downloaded file" in str(caught.value.__cause__)
