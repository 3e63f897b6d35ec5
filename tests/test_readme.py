"""The README and DATASET.md say what is so."""

import dataclasses
import re
import sys
import types
from pathlib import Path

import numpy as np
import pytest

from synthdepth.camera import Intrinsics
from synthdepth.cli import _COMMANDS, Render
from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.pair import META_FIELDS
from synthdepth.export import export
from synthdepth.flight.clearance import Clearance
from synthdepth.flight.flight import draw_flight
from synthdepth.flight.limits import FlightLimits
from synthdepth.maps.light import LightRanges
from synthdepth.maps.registry import MAPS, MapKind, build_world
from synthdepth.production.recipe import load_recipe
from synthdepth.render.settings import RenderSettings
from synthdepth.seeding import lane
from tests.made import make_dataset

ROOT = Path(__file__).parents[1]
README, FORMAT = (ROOT / "README.md").read_text(), (ROOT / "DATASET.md").read_text()


def test_every_command_of_the_readme_exists_and_the_other_way_round():
    named = set(re.findall(r"`synthdepth ([a-z-]+)", README))
    assert named == set(_COMMANDS)


def test_every_option_of_the_readme_exists():
    options = {f"--{field.name.replace('_', '-')}" for field in dataclasses.fields(Render)}
    table = README[README.index("the most used of `render`") : README.index("## Use the data")]
    named = set(re.findall(r"--[a-z][a-z-]+", table))
    assert len(named) > 8
    assert named <= options


def test_defaults_in_the_readme_are_the_recipe_s():
    recipe = load_recipe("neighborhood")
    assert f"`--pairs-per-scene` | {recipe.sampling.pairs_per_scene} |" in README
    sampling = f"{recipe.sampling.pairs_per_flight}, {recipe.sampling.burst_pairs}"
    assert f"`--pairs-per-flight`, `--burst-pairs` | {sampling} |" in README
    assert f"`--max-depth-m` | {recipe.render.max_depth_m:g} |" in README


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_the_reader_in_the_readme_reads(dataset, capsys):
    code = re.search(r"```python\n(import io, json.*?)```", README, re.DOTALL)[1]
    shard = dataset / read_manifest(dataset)["shards"][0]["path"]
    path = "data/suburb/train/neighborhood-train-000000.tar"
    assert path in code
    exec(compile(code.replace(path, str(shard)), "README.md", "exec"), {})
    assert capsys.readouterr().out.startswith("blocks-s00000-f000-")


def test_the_loader_in_the_readme_loads_and_the_flow_embeds(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=3, pairs=2)
    code = re.search(r"```python\n(from torch.utils.data.*?)```", README, re.DOTALL)[1]
    assert code.count('"data/suburb"') == 1
    seen = {}
    code = code.replace('"data/suburb"', repr(str(folder))).replace("range(10)", "range(1)")
    exec(compile(code.replace("num_workers=2", "num_workers=0"), "README.md", "exec"), seen)
    assert len(seen["pairs"]) == 2
    assert seen["batch"].input.shape == (2, 3, 48, 64)
    code = re.search(r"```python\n(from synthdepth.flow.*?)```", README, re.DOTALL)[1]
    sample = seen["pairs"][0]
    flown = {"prev": sample.prev, "rgb": sample.rgb}
    exec(compile(code, "README.md", "exec"), flown)
    assert flown["flow"].shape == (48, 64, 2)
    assert (flown["picture"] != sample.rgb).any()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
def test_the_other_loaders_in_the_readme_load(tmp_path, monkeypatch):
    folder = make_dataset(tmp_path / "set", shards=4, pairs=2)
    export("kitti", folder, tmp_path / "kitti")
    code = re.search(r"```python\n(from synthdepth.kitti.*?)```", README, re.DOTALL)[1]
    found = re.search(r"KittiDataset\(.*?\)", code)[0]
    assert '"kitti/raw"' in found
    mine = code.replace(found, f"KittiDataset({str(tmp_path / 'kitti')!r}, split='val')")
    read = {}
    exec(compile(mine, "README.md", "exec"), read)
    assert read["sample"].valid.any()

    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    monkeypatch.setenv("HF_DATASETS_CACHE", str(tmp_path / "cache"))
    code = re.search(r"```python\n(from datasets.*?)```", README, re.DOTALL)[1]
    code = code.replace('"data/suburb"', f"{str(folder)!r}, cache_dir={str(tmp_path / 'cache')!r}")
    exec(compile(code, "README.md", "exec"), read)
    assert len(read["rows"]) == 4


@pytest.mark.usefixtures("backend")
def test_the_map_of_the_readme_can_be_built_flown_and_rendered(monkeypatch):
    from synthdepth.render.renderer import load_world

    code = re.search(r'```python\n("""The map `orchard`.*?)```', README, re.DOTALL)[1]
    assert sum(bool(line.strip()) for line in code.splitlines()) <= 60
    module = types.ModuleType("orchard")
    monkeypatch.setitem(sys.modules, "orchard", module)
    exec(compile(code, "README.md", "exec"), module.__dict__)
    kind = MapKind(ranges=module.OrchardRanges, build=module.orchard, summary="fruit trees")
    monkeypatch.setitem(MAPS, "orchard", kind)
    small = module.OrchardRanges(flight_area_m=150.0, row_spacing_m=[8, 9])
    world = build_world("orchard", small, LightRanges(conditions=("clear",)), 3)
    labels = {label for _, label in world.surfaces}
    assert labels >= {"ground", "vegetation", "tree_trunk", "pole", "wire", "person", "hill"}
    flight = draw_flight(lane(3, "flight"), Clearance(world), FlightLimits(distance_m=(40, 100)))
    view = load_world(world, Intrinsics.from_fov(64, 64, 90), RenderSettings(spp=1))
    pose = flight.state.world_from_cam[len(flight.time_s) // 2]
    assert view.rgb(pose, 1).std() > 10
    assert len(np.unique(view.surfels(pose).label)) >= 3


def test_the_format_s_document_lists_the_fields_of_the_metadata():
    table = FORMAT[FORMAT.index("## meta.json") : FORMAT.index("## dataset.json")]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    named = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    assert sorted(named) == sorted(META_FIELDS)
