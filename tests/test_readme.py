"""The README and DATASET.md say what is so."""

import dataclasses
import re
from pathlib import Path

import pytest

from synthdepth.cli import _COMMANDS, Render
from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.pair import META_FIELDS
from synthdepth.production.recipe import load_recipe

ROOT = Path(__file__).parents[1]
README, FORMAT = (ROOT / "README.md").read_text(), (ROOT / "DATASET.md").read_text()


def test_every_command_of_the_readme_exists_and_the_other_way_round():
    named = set(re.findall(r"`synthdepth ([a-z]+)", README))
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
    assert capsys.readouterr().out.startswith("neighborhood-s00000-f000-")


def test_the_format_s_document_lists_the_fields_of_the_metadata():
    table = FORMAT[FORMAT.index("## meta.json") : FORMAT.index("## dataset.json")]
    rows = [line.split("|")[1] for line in table.splitlines() if line.startswith("| `")]
    named = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    assert sorted(named) == sorted(META_FIELDS)
