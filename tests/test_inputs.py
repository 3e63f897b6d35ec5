"""The inputs of the networks: each kind's channels, their range, and what they carry."""

import dataclasses

import numpy as np
import pytest

from synthdepth.camera import Intrinsics
from synthdepth.dataset import PairDataset
from synthdepth.dataset.transforms import flipped
from synthdepth.errors import DatasetError
from synthdepth.flow import embed, estimate_flow
from synthdepth.pix2pix.inputs import CHANNELS, InputConfig, MakeInput
from tests.made import make_dataset

CAMERA = Intrinsics.from_fov(96, 64, 90.0)


@pytest.fixture(scope="module")
def samples(tmp_path_factory):
    folder = tmp_path_factory.mktemp("inputs") / "set"
    make_dataset(folder, shards=2, pairs=3, modalities=("flow",), camera=CAMERA)
    return list(PairDataset(folder))


@pytest.mark.parametrize("kind", CHANNELS)
def test_every_kind_has_its_channels_in_range(samples, kind):
    config = InputConfig(kind=kind)
    made = MakeInput(config, seed=0)(samples[0]).input
    assert made.shape == (CAMERA.height, CAMERA.width, config.channels)
    assert made.dtype == np.float32
    assert made.min() >= -1
    assert made.max() <= 1
    assert made.std() > 0.01


def test_the_embedded_input_is_the_papers(samples):
    sample = samples[0]
    flow = estimate_flow(sample.prev, sample.rgb)
    made = MakeInput(InputConfig(kind="embed", interval=3))(sample).input
    np.testing.assert_allclose((made + 1) * 127.5, embed(sample.rgb, flow, 3), atol=1e-3)


def test_triangulated_depth_from_true_flow_is_the_depth_where_it_is_sure(samples):
    config = InputConfig(kind="triangulated", flow="truth")
    for sample in samples:
        log_depth, confidence = np.moveaxis(MakeInput(config)(sample).input[..., 3:], -1, 0)
        sure = confidence > 0.5
        assert sure.mean() > 0.02
        share = log_depth[sure] / (confidence[sure] + 1) + 0.5
        np.testing.assert_allclose(200.0**share, sample.depth_m[sure], rtol=0.02)


def test_training_noise_is_the_pairs_and_the_epochs_own(samples):
    make = MakeInput(InputConfig(kind="triangulated", flow="truth"), seed=3)
    first = make(samples[0]).input
    np.testing.assert_array_equal(make(samples[0]).input, first)
    make.set_epoch(1)
    assert (make(samples[0]).input != first).any()
    exact = MakeInput(make.config)(samples[0]).input
    assert (exact != first).any()


def test_a_mirrored_sample_gives_the_mirrored_input(samples):
    make = MakeInput(InputConfig(kind="triangulated", flow="truth"))
    here, there = make(samples[0]).input, make(flipped(samples[0])).input
    np.testing.assert_allclose(there[:, ::-1], here, atol=2e-3)


def test_what_is_missing_is_named(samples):
    bare = dataclasses.replace(samples[0], prev=None)
    with pytest.raises(DatasetError, match=r"needs prev, and blocks-s00000"):
        MakeInput(InputConfig(kind="embed"))(bare)
    lost = dataclasses.replace(samples[0], world_from_cam=None)
    with pytest.raises(DatasetError, match="needs poses"):
        MakeInput(InputConfig(kind="triangulated"))(lost)
