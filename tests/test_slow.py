"""Checks of minutes, at the size that users render: run with `make test-slow`."""

import pytest
import torch

from synthdepth.camera import Intrinsics
from synthdepth.dataset.manifest import read_manifest
from synthdepth.dataset.pair import decode_pair
from synthdepth.dataset.shard import read_members, shard_members
from synthdepth.maps.registry import build_world
from synthdepth.production.overrides import with_overrides
from synthdepth.production.recipe import load_recipe
from synthdepth.production.run import render_dataset
from tests.made import make_dataset
from tests.raycast import Recaster
from tests.test_tools import load

pytestmark = pytest.mark.slow


def test_depth_of_ten_full_frames_agrees_with_an_independent_ray_caster(tmp_path, capsys):
    recipe = with_overrides(
        load_recipe("neighborhood"), pairs_per_scene=5, pairs_per_flight=1, burst_pairs=1
    )
    render_dataset(recipe, tmp_path / "set", pairs=10)
    wrong, unexplained, pixels = 0, 0, 0
    for shard in read_manifest(tmp_path / "set")["shards"]:
        caster = Recaster(build_world(recipe.map, recipe.scene, recipe.light, shard["scene_seed"]))
        path = tmp_path / "set" / shard["path"]
        for key, members in shard_members(path).items():
            pair = decode_pair(key, read_members(path, members))
            differ, off_edge = caster.differing(pair)
            wrong, unexplained = wrong + differ, unexplained + off_edge
            pixels += pair.depth_m.size
    with capsys.disabled():
        print(f"\n{pixels} pixels: {1 - wrong / pixels:.6%} agree, {unexplained} on no edge")
    assert wrong / pixels <= 1e-3
    assert unexplained == 0


def test_training_learns_eight_pairs_by_heart(tmp_path):
    camera = Intrinsics.from_fov(64, 64, 90.0)
    data = make_dataset(tmp_path / "set", shards=2, pairs=8, camera=camera)
    program = load("overfit")
    options = program.Options(data=data, epochs=250, ngf=16, depth=5)
    torch.set_num_threads(1)
    errors = program.overfit(options, tmp_path / "run")
    assert errors["rel"] < 0.05
    assert errors["delta_1"] > 0.96
