"""Malformed files: refused in one line before they cost memory or time, or lead elsewhere."""

import ast
import io
import json
import shutil
import struct
import subprocess
import sys
import tarfile
import zlib
from pathlib import Path

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from synthdepth.airsim.settings import camera_from_settings
from synthdepth.config import parse_json, parse_toml
from synthdepth.dataset import PairDataset, PairStream
from synthdepth.dataset.archive import entries, mapped
from synthdepth.dataset.contract import check_index, check_manifest
from synthdepth.dataset.exr import decode_depth, depth_header, encode_channels
from synthdepth.dataset.manifest import INDEX, MANIFEST, read_index, read_manifest
from synthdepth.dataset.pair import check_meta, decode_fields, decode_labels, decode_png, encode_png
from synthdepth.dataset.picture import decode_picture
from synthdepth.dataset.preview import preview
from synthdepth.errors import DatasetError, RecipeError, SynthdepthError
from synthdepth.pix2pix.config import train_config
from synthdepth.pix2pix.frames import open_frames
from synthdepth.pix2pix.inputs import InputConfig
from synthdepth.production.recipe import load_recipe
from tests.made import make_dataset

ROOT = Path(__file__).parents[1]
DEEP = 100_000


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return make_dataset(tmp_path_factory.mktemp("whole") / "set", shards=2, pairs=2)


@pytest.fixture
def copy(folder, tmp_path):
    return shutil.copytree(folder, tmp_path / "set")


# JSON, TOML, messages.


@pytest.mark.parametrize(
    "text", ["[" * DEEP + "]" * DEEP, '{"a":' * DEEP + "1" + "}" * DEEP, "{", "\xff"]
)
def test_json_is_a_value_or_a_value_error(text):
    with pytest.raises(ValueError):  # noqa: PT011
        parse_json(text)


@pytest.mark.parametrize(
    "text",
    [
        "a = " + "[" * 2000 + "]" * 2000,
        "a." * 30_000 + "b = 1",
        "a = 1\n" * 20_000,
        "a = " + "9" * 4050,
    ],
)
def test_toml_is_a_table_or_a_value_error_soon(text):
    with pytest.raises(ValueError, match="deep|long|TOML|Expected|closing|Invalid"):
        parse_toml(text + "\nb = ]" if text.startswith("a = 9") else text)


@pytest.mark.parametrize(
    "text",
    [
        "map = []",
        "map = {}",
        "light = 1",
        'map = "blocks"\n[camera]\nwidth = 1' + "0" * 400,
        'map = "blocks"\nsensor = {model = []}',
        'map = "blocks"\nlight = {conditions = [[]]}',
        'map = "blocks"\nlight = {sun_elevation_deg = [nan, inf]}',
        'map = "blocks"\n"a\\nb" = 1',
        'map = "blocks"\n[camera]\nfov_deg = "' + "x" * 4000 + '"',
    ],
)
def test_recipes_refuse_any_type_in_one_line(tmp_path, text):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    with pytest.raises(RecipeError) as error:
        load_recipe(str(path))
    assert len(str(error.value)) <= 1000
    assert str(error.value).isprintable()


@pytest.mark.parametrize(
    "text", ['{"input": 5}', "[]", '{"size": [[1], 2]}', '{"epochs": 1e999}', '{"compile": null}']
)
def test_training_configurations_refuse_any_type(tmp_path, text):
    path = tmp_path / "config.json"
    path.write_text(text)
    with pytest.raises(RecipeError):
        train_config(path, {"input.kind": "rgb"})


def test_an_error_is_one_short_printable_line():
    assert str(DatasetError("a\nb\x1b[31m\udcff")) == r"a b\x1b[31m\udcff"
    long = str(SynthdepthError("start " + "x" * 10_000 + " end"))
    assert len(long) < 1000 and long.startswith("start") and long.endswith("end")


def test_comments_without_an_end_cost_no_time(tmp_path):
    path = tmp_path / "settings.json"
    for text in ("{/*" * 50_000, '{"' + '\\"' * 50_000 + "\\"):
        path.write_text(text)
        with pytest.raises(DatasetError, match="is not JSON"):
            camera_from_settings(path)


# Metadata, manifest, index.


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("map", "../../x"),
        ("map", ""),
        ("map", "a\0b"),
        ("split", "../x"),
        ("width", 0),
        ("height", 10**9),
        ("width", -5),
        ("scene_index", -1),
        ("scene_seed", 2**53),
        ("frame_index", True),
        ("dt_s", float("nan")),
        ("max_depth_m", float("inf")),
        ("velocity_mps", [1.0, 2.0]),
        ("velocity_mps", [1.0, 2.0, "3"]),
        ("intrinsics", [[1, 0, 0], [0, 1, 0]]),
        ("intrinsics", [[0.0, 0, 1], [0, 1, 1], [0, 0, 1]]),
        ("world_from_cam", [[None] * 4] * 4),
        ("world_from_cam", [[1.0] * 4, [1.0] * 3]),
        ("world_from_cam_prev", [[10**400] * 4] * 4),
    ],
)
def test_metadata_are_numbers_of_the_right_shape(folder, name, value):
    meta = dict(PairDataset(folder)[0].meta)
    check_meta(meta)
    with pytest.raises(ValueError, match=f"meta.json: {name} is|it is"):
        check_meta(meta | {name: value})


@pytest.mark.parametrize("meta", [None, [], 1, "x"])
def test_metadata_are_a_table(meta):
    with pytest.raises(ValueError, match="table"):
        check_meta(meta)


def changed(tree, path, value):
    """A copy of a tree with a value at a path; None removes it."""
    tree = json.loads(json.dumps(tree))
    at = tree
    for key in path[:-1]:
        at = at[key]
    at[path[-1]] = value
    return tree


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("shards",), {}),
        (("shards", 0), None),
        (("shards", 0, "path"), "../../x.tar"),
        (("shards", 0, "path"), "/etc/x.tar"),
        (("shards", 0, "path"), "train/a\0.tar"),
        (("shards", 0, "path"), "train/x.tar\n"),
        (("shards", 0, "path"), "http://a/b.tar"),
        (("shards", 0, "pairs"), -1),
        (("shards", 0, "split"), []),
        (("shards", 0, "scene_seed"), {}),
        (("map",), "../x"),
        (("recipe",), []),
        (("recipe", "render", "modalities"), [[]]),
        (("recipe", "render", "modalities"), ["depth"]),
        (("recipe", "camera", "width"), 10**6),
        (("depth", "max_depth_m"), float("nan")),
        (("splits",), None),
        (("files",), {"../x": {"bytes": 1, "sha256": ""}}),
        (("files",), {"x": {"bytes": -1, "sha256": ""}}),
        (("labels",), {"sky": "x"}),
    ],
)
def test_manifests_hold_what_readers_rely_on(folder, path, value):
    manifest = read_manifest(folder)
    check_manifest(manifest)
    with pytest.raises(ValueError, match=r"[\w\[\]. ]+"):
        check_manifest(changed(manifest, path, value))


def test_a_shard_is_listed_once(folder):
    manifest = read_manifest(folder)
    with pytest.raises(ValueError, match="twice"):
        check_manifest(manifest | {"shards": manifest["shards"] * 2})


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("key", "../../x"),
        ("key", None),
        ("key", ""),
        ("shard", "../../x.tar"),
        ("shard", "/etc/passwd"),
        ("rgb_size", -1),
        ("rgb_size", 2**62),
        ("depth_offset", -1),
        ("depth_offset", 2**62),
        ("rgb_offset", None),
        ("meta_size", 2**62),
    ],
)
def test_an_index_leads_nowhere_else_and_costs_no_memory(copy, name, value):
    table = pq.read_table(copy / INDEX)
    rows = table.to_pylist()
    rows[0][name] = value
    pq.write_table(pa.Table.from_pylist(rows, table.schema), copy / INDEX)
    with pytest.raises(DatasetError):
        PairDataset(copy)[0]


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("key", [1, 2]),
        ("shard", [b"\xff"] * 2),
        ("altitude_m", ["x", "y"]),
        ("scene_index", [0.5, 1.0]),
        ("world_from_cam", [[1.0]] * 2),
        ("speed_mps", [float("nan")] * 2),
    ],
)
def test_columns_of_an_index_have_their_types(folder, name, values):
    table = pq.read_table(folder / INDEX).slice(0, 2)
    check_index(table, [name])
    place = table.schema.get_field_index(name)
    with pytest.raises(ValueError, match=f"column {name}"):
        check_index(table.set_column(place, name, pa.array(values)), [name])
    with pytest.raises(ValueError, match=f"no column {name}"):
        check_index(table.remove_column(place), [name])


@pytest.mark.parametrize("name", ["rgb_offset", "depth_size", "meta_offset", "altitude_m"])
def test_an_index_has_all_columns(copy, name):
    table = pq.read_table(copy / INDEX)
    pq.write_table(table.drop_columns([name]), copy / INDEX)
    for read in (PairDataset, read_index, lambda f: preview(f, f / "sheet.png", count=2)):
        with pytest.raises(DatasetError, match=f"no column {name}"):
            read(copy)


def test_a_stream_needs_a_manifest_that_knows_the_shards_of_the_index(copy):
    manifest = read_manifest(copy)
    manifest["shards"] = manifest["shards"][:1]
    (copy / MANIFEST).write_text(json.dumps(manifest))
    with pytest.raises(DatasetError, match=f"not in {MANIFEST}"):
        PairStream(copy, where={"altitude_m": (0, 1000)})


def test_an_index_without_rows_is_refused(copy):
    pq.write_table(pq.read_table(copy / INDEX).slice(0, 0), copy / INDEX)
    with pytest.raises(DatasetError, match="no pair"):
        read_index(copy)
    with pytest.raises(DatasetError, match="no pair"):
        preview(copy, copy / "sheet.png", count=2)
    with pytest.raises(DatasetError, match="no pair"):
        PairDataset(copy)


# Archives.


def tar_of(path, members, first_size=None):
    with tarfile.open(path, "w", format=tarfile.USTAR_FORMAT) as tar:
        for name, data in members.items():
            info = tarfile.TarInfo(name)
            info.size = len(data)
            tar.addfile(info, io.BytesIO(data))
    if first_size is not None:
        data = bytearray(path.read_bytes())
        data[124:136] = first_size.ljust(12, b"\0")
        data[148:156] = b" " * 8
        data[148:156] = b"%06o\0 " % sum(data[:512])
        path.write_bytes(data)
    return path


@pytest.mark.parametrize(
    "size", [b"77777777777", b"-1", b"-2000", b"\x80" + b"\0" * 3 + b"\xff" * 8, b"\xff" * 12]
)
def test_sizes_in_an_archive_are_not_believed(tmp_path, size):
    path = tar_of(tmp_path / "x.tar", {"a.rgb.png": b"x" * 600, "a.meta.json": b"{}"}, size)
    with pytest.raises(DatasetError, match=r"x\.tar"):
        list(PairStream(str(path), shuffle=0))
    with open(path, "rb") as file, tarfile.open(None, "r:", mapped(file)) as tar:
        try:
            assert all(len(tar.extractfile(info).read()) <= 2000 for info in entries(tar))
        except tarfile.ReadError as error:
            assert str(error)  # noqa: PT017


# Pictures.


def png_header(width, height):
    def chunk(kind, data):
        return (
            struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
        )

    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    body = chunk(b"IDAT", zlib.compress(b"\0" * 100)) + chunk(b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + header + body


def bmp_header(width, height):
    info = struct.pack("<IiiHHIIiiII", 40, width, height, 1, 24, 0, 0, 1, 1, 0, 0)
    return b"BM" + struct.pack("<IHHI", 54, 0, 0, 54) + info


@pytest.mark.parametrize(
    "size", [(100_000, 100_000), (16_385, 1), (2**31 - 1, 1), (16_384, 16_384), (0, 0)]
)
@pytest.mark.parametrize("header", [png_header, bmp_header])
def test_a_picture_is_measured_before_it_is_decoded(size, header):
    with pytest.raises(ValueError, match="allowed are 67108864 pixels|too large|broken"):
        decode_picture(header(*size), cv2.IMREAD_COLOR)


@pytest.mark.parametrize("decode", [decode_png, decode_labels])
@pytest.mark.parametrize("data", [b"", b"\x89PNG\r\n\x1a\n", png_header(50, 40)[:40], b"x" * 100])
def test_what_is_no_picture_is_a_value_error(decode, data):
    with pytest.raises(ValueError, match="broken|it is"):
        decode(data)


@pytest.mark.parametrize("suffix", [".png", ".jpg", ".bmp", ".tif", ".webp"])
def test_measuring_changes_no_picture(suffix):
    image = np.arange(40 * 30 * 3, dtype=np.uint8).reshape(40, 30, 3)
    data = cv2.imencode(suffix, image)[1].tobytes()
    assert np.array_equal(
        decode_picture(data, cv2.IMREAD_COLOR), cv2.imdecode(np.frombuffer(data, np.uint8), 1)
    )


@pytest.mark.parametrize(
    "window",
    [
        (0, 0, 99_999, 99_999),
        (0, 0, 16_384, 0),
        (0, 0, 16_383, 16_383),
        (5, 5, 0, 0),
        (-(2**31),) * 2 + (2**31 - 1,) * 2,
    ],
)
def test_an_exr_is_measured_before_it_is_decoded(window):
    data = bytearray(encode_channels({}, {"Z": np.ones((8, 8), np.float32)}))
    for name in (b"dataWindow", b"displayWindow"):
        start = data.find(name + b"\0box2i\0") + len(name) + 11
        data[start : start + 16] = struct.pack("<4i", *window)
    with pytest.raises(ValueError, match="allowed are|no readable EXR"):
        decode_depth(bytes(data))


def test_a_header_alone_is_read_or_a_value_error():
    assert (
        depth_header(encode_channels({"depthUnit": "metre"}, {"Z": np.ones((2, 2))}))["depthUnit"]
        == "metre"
    )
    with pytest.raises(ValueError, match="EXR"):
        depth_header(b"v/1\x01 and no more")


def test_images_have_the_size_that_the_metadata_say(folder):
    meta = dict(PairDataset(folder)[0].meta)
    files = {"rgb.png": encode_png(np.zeros((48, 63, 3), np.uint8))}
    with pytest.raises(ValueError, match=r"rgb.png is \(48, 63\), meta.json says \(48, 64\)"):
        decode_fields(files, ["rgb"], meta)


def test_a_picture_of_a_prediction_is_measured_too(tmp_path):
    (tmp_path / "a.png").write_bytes(png_header(100_000, 100_000))
    with pytest.raises(DatasetError, match="a.png is not a readable picture: it is 100000x100000"):
        list(open_frames(tmp_path, InputConfig(kind="rgb")).samples)


# The source.


def calls():
    for path in sorted((ROOT / "synthdepth").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Call):
                yield (
                    path.name,
                    ast.unparse(node.func),
                    {k.arg: ast.unparse(k.value) for k in node.keywords},
                )


def test_nothing_is_unpickled_evaluated_or_given_to_a_shell():
    forbidden = (
        "pickle.load",
        "pickle.loads",
        "pickle.Unpickler",
        "np.load",
        "joblib.load",
        "marshal.loads",
        "eval",
        "exec",
        "os.system",
        "os.popen",
        "yaml.load",
        "shelve.open",
    )
    for name, function, keywords in calls():
        assert function not in forbidden, f"{name} calls {function}"
        assert keywords.get("shell", "False") == "False", f"{name} gives {function} to a shell"
        if function == "torch.load":
            assert keywords.get("weights_only") == "True", f"{name} may unpickle"


@pytest.mark.slow
def test_the_fuzzer_finds_nothing(folder, tmp_path):
    command = [
        sys.executable,
        "tools/fuzz.py",
        "--data",
        str(folder),
        "--inputs",
        "400",
        "--out",
        str(tmp_path / "kept"),
    ]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr[-2000:]
