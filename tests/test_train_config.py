"""The configuration of a training: the paper's as it stands, checked, and the same after JSON."""

import json

import pytest

from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.augment import AugmentationConfig
from synthdepth.pix2pix.config import TrainConfig, parse_size, train_config
from synthdepth.pix2pix.inputs import CHANNELS, InputConfig
from synthdepth.pix2pix.target import DepthCoding


def test_as_it_stands_it_is_the_papers():
    config = TrainConfig()
    assert (config.epochs, config.batch_size, config.objective.lambda_l1) == (100, 1, 100)
    assert (config.lr, config.beta1, config.beta2) == (2e-4, 0.5, 0.999)
    assert (config.input.kind, config.input.interval) == ("embed", 5)


@pytest.mark.parametrize("kind", CHANNELS)
def test_channels_follow_from_the_input(kind):
    config = TrainConfig(input=InputConfig(kind=kind))
    assert config.generator.in_channels == CHANNELS[kind]
    assert config.discriminator.in_channels == CHANNELS[kind] + 1


def test_configuration_survives_json():
    config = TrainConfig(
        input=InputConfig(kind="flow", px_at_white=1 / 3),
        size=(64, 48),
        lr=0.1 + 0.2,
        ema=0.999,
        coding=DepthCoding(kind="log"),
        augmentation=AugmentationConfig(noise=3.0),
        compile=True,
    )
    table = json.loads(json.dumps(config.as_table()))
    assert TrainConfig.from_table(table, "there") == config


def test_a_file_and_options_make_a_configuration(tmp_path):
    path = tmp_path / "run.toml"
    path.write_text('epochs = 7\n[input]\nkind = "flow"\n[objective]\nlambda_l1 = 10.0\n')
    config = train_config(path, {"input.interval": 3, "epochs": None, "lr": 1e-3})
    assert (config.epochs, config.lr, config.input) == (
        7,
        1e-3,
        InputConfig(kind="flow", interval=3),
    )
    (tmp_path / "again.json").write_text(json.dumps(config.as_table()))
    assert train_config(tmp_path / "again.json") == config


@pytest.mark.parametrize(
    ("table", "complaint"),
    [
        ({"epochs": 0}, r"train epochs = 0: allowed is a whole number from 1"),
        ({"steps": 5}, r"train steps is unknown: allowed are input, coding"),
        ({"input": {"kind": "lidar"}}, r"train input kind = 'lidar': allowed are rgb"),
        ({"input": 3}, r"train input is 3: allowed is a table"),
        ({"size": [256, 0]}, r"size = \[256, 0\]: allowed are \[width, height\]"),
        ({"compile": 1}, r"compile = 1: allowed are true and false"),
        ({"generator": {"in_channels": 4}}, r"generator in_channels = 4: allowed is 3"),
        ({"precision": "fp16"}, r"precision = 'fp16': allowed are fp32, bf16"),
    ],
)
def test_what_is_not_allowed_is_named(table, complaint):
    with pytest.raises(SynthdepthError, match=complaint):
        TrainConfig.from_table(table, "train")


def test_bad_files_and_sizes_are_refused(tmp_path):
    (tmp_path / "bad.toml").write_text("epochs = ")
    for path, complaint in (
        (tmp_path / "no.toml", "no such file"),
        (tmp_path / "bad.toml", "read"),
    ):
        with pytest.raises(SynthdepthError, match=complaint):
            train_config(path)
    assert parse_size("640x480") == (640, 480)
    with pytest.raises(SynthdepthError, match="WIDTHxHEIGHT"):
        parse_size("640")


def test_the_learning_rate_falls_in_the_second_half():
    config = TrainConfig(decay="linear", lr=1.0)
    assert [config.lr_at(x) for x in (0, 0.5, 0.75, 1)] == [1, 1, 0.5, 0]
    assert TrainConfig(lr=1.0).lr_at(0.9) == 1
