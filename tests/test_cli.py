"""The command line: exit codes, and one line for whatever is wrong."""

import json

import pytest

from synthdepth.cli import _COMMANDS, main
from tests.made import make_dataset


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ([], "Expected one of"),
        (["rendr"], "Unrecognized options: rendr"),
        (["render", "--map", "neighborhood"], "--pairs"),
        (["render", "--map", "neighborhood", "--pairs", "many"], "--pairs"),
        (["render", "--map", "moon", "--pairs", "4"], "the maps are blocks, city, coastline"),
        (["render", "--map", "neighborhood", "--pairs", "0"], "--pairs 0: allowed is"),
        (["render", "--map", "neighborhood", "--pairs", "-2"], "--pairs -2: allowed is"),
        (["render", "--map", "neighborhood", "--pairs", "4", "--size", "big"], "--size big"),
        (["render", "--map", "neighborhood", "--pairs", "4", "--seed", "-1"], "--seed -1"),
        (["render", "--map", "neighborhood", "--pairs", "4", "--workers", "0"], "--workers 0"),
        (["render", "--map", "neighborhood", "--pairs", "4", "--variant", "gpu"], "variant"),
        (
            ["render", "--map", "neighborhood", "--pairs", "4", "--train-share", "2"],
            "--train-share",
        ),
        (["verify", "nowhere"], "nowhere holds no dataset"),
        (["preview", "nowhere"], "nowhere holds no dataset"),
        (["scene", "--map", "neighborhood", "--seed", "1", "--out", "x.obj"], "ends in .glb"),
        (["view", "nowhere", "--out", "x.rrd"], "nowhere holds no dataset"),
        (["preview", "nowhere", "--out", "x.html"], "nowhere holds no dataset"),
        (["export", "nowhere", "--to", "kitti", "--out", "there"], "nowhere holds no dataset"),
        (["export", "nowhere", "--to", "coco", "--out", "there"], "coco"),
        (["export", "nowhere", "--to", "hf", "--out", "x", "--sky", "invalid"], "--sky belongs"),
        (["import-airsim", "nowhere", "--out", "there"], "nowhere"),
        (["train", "nowhere", "--out", "there"], "nowhere"),
        (["predict", "nowhere", "nothing", "--out", "there"], "nowhere"),
        (["onnx", "nowhere", "--out", "x.onnx"], "nowhere"),
    ],
)
def test_a_mistake_is_one_line_and_exit_2(arguments, complaint, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert complaint in told
    assert told.startswith("synthdepth: ")
    assert told.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_one_line(capsys):
    """/proc refuses new folders to everybody, root included."""
    target = "/proc/synthdepth"
    assert main(["render", "--map", "neighborhood", "--pairs", "1", "--out", target]) == 2
    told = capsys.readouterr().err
    assert "cannot write /proc/synthdepth" in told
    assert told.count("\n") == 1


def test_an_out_that_is_a_file_is_one_line(capsys, tmp_path):
    target = tmp_path / "set"
    target.write_text("a file")
    assert main(["render", "--map", "neighborhood", "--pairs", "1", "--out", str(target)]) == 2
    assert "cannot write" in capsys.readouterr().err
    assert target.read_text() == "a file"


def test_maps_lists_the_maps(capsys, tmp_path):
    assert main(["maps", "--json", str(tmp_path / "maps.json")]) == 0
    assert "neighborhood" in capsys.readouterr().out
    assert "suburb" in json.loads((tmp_path / "maps.json").read_text())["neighborhood"]["summary"]


def test_doctor_says_what_renders(capsys):
    assert main(["doctor"]) == 0
    told = capsys.readouterr().out
    assert "renders with" in told
    assert "cores" in told


def test_help_names_every_command(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--help"])
    assert stopped.value.code == 0
    told = capsys.readouterr().out
    assert all(name in told for name in _COMMANDS)


@pytest.mark.parametrize("layout", ["kitti", "tartanair", "hf", "nerfstudio"])
def test_export_says_how_many_pairs_it_wrote(layout, capsys, tmp_path):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=2)
    assert main(["export", str(folder), "--to", layout, "--out", str(tmp_path / "out")]) == 0
    assert f"{tmp_path / 'out'}: 4 pairs" in capsys.readouterr().out
    assert any((tmp_path / "out").rglob("*.*"))


def test_preview_writes_a_page_and_view_a_recording(capsys, tmp_path):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=2)
    assert main(["preview", str(folder), "--out", str(tmp_path / "page.html")]) == 0
    assert main(["view", str(folder), "--out", str(tmp_path / "set.rrd")]) == 0
    assert (tmp_path / "page.html").read_text().startswith("<!doctype html>")
    assert (tmp_path / "set.rrd").stat().st_size > 1000
    assert capsys.readouterr().out.count("4 pairs") == 2


def test_a_broken_shard_is_one_line_for_preview(capsys, tmp_path):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=2)
    shard = sorted(folder.rglob("*.tar"))[0]
    shard.write_bytes(shard.read_bytes()[:2000])
    assert main(["preview", str(folder), "--out", str(tmp_path / "x.png")]) == 2
    told = capsys.readouterr().err
    assert shard.name in told
    assert told.count("\n") == 1
