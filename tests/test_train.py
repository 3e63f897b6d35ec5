"""Training: it learns, goes on after a kill as if nothing had been, splits over processes."""

import dataclasses
import errno
import json
import math
import multiprocessing
import os
import signal
import time

import numpy as np
import pytest
import safetensors.torch
import torch

from synthdepth.camera import Intrinsics
from synthdepth.dataset import PairDataset
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.pix2pix.augment import AugmentationConfig, JitterColours
from synthdepth.pix2pix.checkpoint import (
    load_generator,
    read_facts,
    restore_state,
    save_model,
    save_state,
)
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.data import TrainingData
from synthdepth.pix2pix.discriminator import DiscriminatorConfig
from synthdepth.pix2pix.distributed import Place, find_device
from synthdepth.pix2pix.generator import GeneratorConfig, UNetGenerator
from synthdepth.pix2pix.inputs import InputConfig
from synthdepth.pix2pix.objective import ObjectiveConfig
from synthdepth.pix2pix.panels import panel
from synthdepth.pix2pix.state import State, follow
from synthdepth.pix2pix.target import DepthCoding
from synthdepth.pix2pix.train import train
from synthdepth.pix2pix.validation import picture_errors
from tests.made import make_dataset

HERE = Place(rank=0, ranks=1, device=torch.device("cpu"))
CAMERA = Intrinsics.from_fov(48, 32, 90.0)


def small(**values):
    """A training of seconds: a U-Net of five halvings on 48x32 pixels, deterministic but noisy."""
    defaults = {
        "input": InputConfig(kind="rgb"),
        "generator": GeneratorConfig(ngf=8, depth=4, norm="instance"),
        "discriminator": DiscriminatorConfig(ndf=8, layers=1, norm="instance"),
        "batch_size": 2,
        "epochs": 2,
        "log_every": 2,
        "workers": 0,
        "validation_pairs": 2,
    }
    return TrainConfig(**(defaults | values))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Four scenes of eight pairs: one to train with, one kept back, two of the split test."""
    return make_dataset(tmp_path_factory.mktemp("train") / "set", shards=4, pairs=8, camera=CAMERA)


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    """Sums in one order here and in subprocesses; and threads of tiny work only wait."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def lines(out, kind="train"):
    """The log without its times."""
    rows = [json.loads(line) for line in (out / "log.jsonl").read_text().splitlines()]
    left_out = ("kind", "elapsed_s", "pairs_per_s")
    return [{k: v for k, v in r.items() if k not in left_out} for r in rows if r["kind"] == kind]


# Pairs and batches.


def keys(config, folder, place=HERE, epoch=0, first=0):
    batches = TrainingData(config, [folder], place).batches(epoch, first)
    return [batch.keys for batch in batches]


def test_order_depends_on_seed_and_epoch_alone(folder):
    order = keys(small(), folder)
    assert len({key for batch in order for key in batch}) == 8
    assert keys(small(workers=2), folder) == order
    assert keys(small(), folder, first=1) == order[1:]
    assert keys(small(), folder, epoch=1) != order
    assert keys(small(seed=1), folder) != order


def test_processes_share_the_batches_of_one(folder):
    whole = keys(small(batch_size=4), folder)
    ranks = [keys(small(), folder, dataclasses.replace(HERE, rank=r, ranks=2)) for r in (0, 1)]
    assert [a + b for a, b in zip(*ranks, strict=True)] == whole


def test_batches_do_not_depend_on_workers(folder):
    config = small(
        input=InputConfig(kind="embed"),
        augmentation=AugmentationConfig(exposure_stops=1.0, noise=4.0),
        size=(64, 40),
    )
    first, second = (
        [batch.input for epoch in (0, 1) for batch in data.batches(epoch)]
        for data in (
            TrainingData(dataclasses.replace(config, workers=n), [folder], HERE) for n in (0, 2)
        )
    )
    assert first[0].shape == (2, 3, 40, 64)
    assert all(map(torch.equal, first, second))


def scenes(batches):
    return {key.split("-f")[0] for batch in batches for key in batch.keys}


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_validation_keeps_back_scenes_of_the_split_train(folder, seed):
    data = TrainingData(small(validation_pairs=0, seed=seed), [folder], HERE)
    seen, unseen = scenes(data.batches(0)), scenes(data.validation)
    assert len(unseen) == 1 and not seen & unseen
    train_split = PairDataset(folder, split="train")
    assert seen | unseen == {train_split.key(k).split("-f")[0] for k in range(len(train_split))}


def test_without_validation_all_scenes_train(folder):
    data = TrainingData(small(validate_every=0), [folder], HERE)
    assert data.pairs == 16 and data.validation is None


def test_each_dataset_keeps_scenes_back(folder, tmp_path):
    # Six scenes of the split train, of which a third is two; a dataset of one scene trains with it.
    six = make_dataset(tmp_path / "six", shards=12, pairs=1, camera=CAMERA, seed=3)
    one = make_dataset(tmp_path / "one", shards=2, pairs=1, camera=CAMERA, seed=4)
    data = TrainingData(small(validation_share=0.34, validation_pairs=0), [folder, six, one], HERE)
    assert data.pairs == 8 + 4 + 1
    assert sum(len(batch.keys) for batch in data.validation) == 8 + 2


def test_colours_change_both_frames_alike_and_no_geometry(folder):
    sample = PairDataset(folder)[0]
    still = dataclasses.replace(sample, prev=sample.rgb)
    jitter = JitterColours(AugmentationConfig(exposure_stops=1.0, white_balance=0.5), seed=0)
    changed = jitter(still)
    np.testing.assert_array_equal(changed.rgb, changed.prev)
    assert (changed.rgb != sample.rgb).any()
    np.testing.assert_array_equal(changed.depth_m, sample.depth_m)
    noisy = JitterColours(AugmentationConfig(noise=8.0), seed=0)(still)
    assert (noisy.rgb != noisy.prev).mean() > 0.5  # noise is each frame's own


def test_too_few_pairs_or_too_near_are_refused(folder, tmp_path):
    with pytest.raises(DatasetError, match=r"8 pairs in split train: allowed is at least"):
        TrainingData(small(batch_size=9), [folder], HERE)
    near = make_dataset(tmp_path / "near", shards=2, pairs=2, max_depth_m=80.0)
    with pytest.raises(DatasetError, match=r"near saturates at 80 m: allowed is coding"):
        TrainingData(small(), [near], HERE)
    with pytest.raises(DatasetError, match="holds no dataset"):
        TrainingData(small(), [tmp_path], HERE)
    one = make_dataset(tmp_path / "one", shards=2, pairs=2, camera=CAMERA)
    with pytest.raises(DatasetError, match=r"one scene: allowed are two or more"):
        TrainingData(small(), [one], HERE)


@pytest.mark.parametrize("workers", [0, 1])
def test_a_broken_pair_is_one_line(tmp_path, workers):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=2, camera=CAMERA)
    shard = next((folder / "train").glob("*.tar"))
    shard.write_bytes(shard.read_bytes()[:6000])
    data = TrainingData(small(workers=workers, validate_every=0), [folder], HERE)
    complaint = ""
    try:  # pytest.raises would keep the workers alive by the traceback
        list(data.batches(0))
    except DatasetError as error:
        complaint = str(error)
    assert str(shard) in complaint and "\n" not in complaint


# Numbers.


def test_errors_are_equations_19_to_21():
    rng = np.random.default_rng(0)
    truth = rng.uniform(1, 200, (2, 1, 5, 7)).astype(np.float32)
    guess = (truth * rng.uniform(0.5, 2, truth.shape)).astype(np.float32)
    valid = rng.random(truth.shape) < 0.7
    truth[~valid] = 0
    found = picture_errors(*map(torch.from_numpy, (guess, truth, valid)))
    for k in range(2):
        p, g = guess[k][valid[k]].astype(float), truth[k][valid[k]].astype(float)
        worse = np.maximum(p / g, g / p)
        expected = [np.sqrt(np.mean((g - p) ** 2)), np.mean(abs(g - p) / g)]
        expected += [np.mean(worse < 1.25**n) for n in (1, 2, 3)]
        np.testing.assert_allclose(found[k], expected, rtol=1e-6)


def test_an_average_follows():
    networks = [UNetGenerator(GeneratorConfig(ngf=2, depth=3)) for _ in range(2)]
    average, network = networks
    before = average.encoders[0].conv.weight.detach().clone()
    network(torch.rand(2, 3, 16, 16))  # moves the running statistics
    follow(average, network, 0.9, step=10**6)
    weight = network.encoders[0].conv.weight
    expected = (0.9 * before + 0.1 * weight).detach()
    np.testing.assert_allclose(average.encoders[0].conv.weight.detach(), expected, atol=1e-6)
    mean = network.encoders[1].norm.running_mean
    np.testing.assert_allclose(average.encoders[1].norm.running_mean, 0.1 * mean, rtol=1e-5)
    assert average.encoders[1].norm.num_batches_tracked == 1


def test_a_panel_shows_four_pictures():
    truth = np.full((4, 6), 10.0)
    shown = panel(np.zeros((4, 6, 3)), truth, truth, 200.0)
    assert shown.shape == (4, 24, 3) and shown.dtype == np.uint8
    np.testing.assert_array_equal(shown[:, 6:12], shown[:, 12:18])
    assert (shown[:, 18:] == 0).all()
    worse = panel(np.zeros((4, 6, 3)), truth, 2 * truth, 200.0)
    assert (worse[:, 18:] == 255).all()


# Whole trainings.


def test_it_learns_eight_pairs(folder, tmp_path):
    """Rel on what it has seen falls to a fraction; the depth map is right, not only its mean."""
    config = small(
        epochs=40,
        lr=2e-3,
        decay="linear",
        generator=GeneratorConfig(ngf=16, depth=4, norm="instance", dropout=0.0),
        coding=DepthCoding(kind="log"),
        augmentation=AugmentationConfig(flip=0.0),
        validate_every=0,
    )
    errors = []
    for out, epochs in ((tmp_path / "short", 1), (tmp_path / "long", 40)):
        train(dataclasses.replace(config, epochs=epochs), [folder], out, device="cpu")
        generator, trained = load_generator(out)
        data = TrainingData(dataclasses.replace(config, batch_size=8), [folder], HERE)
        batch = next(data.batches(0))
        with torch.no_grad():
            depth_m = trained.coding.decode(generator(batch.input))
        errors.append(picture_errors(depth_m, batch.depth_m, batch.valid)[:, 1].mean().item())
    assert errors[1] < 0.15 and errors[1] < errors[0] / 3, errors


def test_what_a_training_leaves(folder, tmp_path):
    seen, validations = [], []
    report = train(
        small(ema=0.9, precision="bf16"),
        [folder],
        tmp_path / "run",
        device="cpu",
        on_progress=lambda *at: seen.append(at),
        on_validation=validations.append,
    )
    out = tmp_path / "run"
    assert (report.steps, report.epochs, report.pairs) == (8, 2, 8)
    assert seen[-1] == (16, 16) and len(validations) == 2
    assert report.best["rel"] == min(errors["rel"] for errors in validations)
    names = {"config.json", "log.jsonl", "tensorboard", "last.safetensors", "best.safetensors"}
    assert {path.name for path in out.iterdir()} == names
    assert [line["step"] for line in lines(out)] == [2, 4, 6, 8]
    assert {"discriminator", "total", "gan", "l1", "lr", "epoch"} <= lines(out)[0].keys()
    assert lines(out, "validation")[0]["rel"] == validations[0]["rel"]
    assert TrainConfig.from_table(json.loads((out / "config.json").read_text()), "") == small(
        ema=0.9, precision="bf16"
    )
    # The average is the model, in both files.
    best, last = (load_generator(out / f"{name}.safetensors")[0] for name in ("best", "last"))
    held = safetensors.torch.load_file(out / "last.safetensors")
    weight = "encoders.0.conv.weight"
    assert torch.equal(last.state_dict()[weight], held[f"average.{weight}"])
    assert not torch.equal(held[f"average.{weight}"], held[f"generator.{weight}"])
    if report.best["epoch"] == 2:
        assert torch.equal(best.state_dict()[weight], last.state_dict()[weight])


def test_tensorboard_holds_curves_and_pictures(folder, tmp_path):
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    train(small(epochs=1), [folder], tmp_path / "run", device="cpu")
    board = EventAccumulator(str(tmp_path / "run" / "tensorboard")).Reload()
    curves = set(board.Tags()["scalars"])
    assert {"train/total", "train/lr", "train/pairs_per_s", "validation/rel"} <= curves
    (name, _) = board.Tags()["images"]
    assert (board.Images(name)[0].width, board.Images(name)[0].height) == (4 * 48, 32)


def test_no_discriminator_without_its_term(folder, tmp_path):
    config = small(epochs=1, objective=ObjectiveConfig(lambda_gan=0.0))
    train(config, [folder], tmp_path / "run", device="cpu")
    (line, *_) = lines(tmp_path / "run")
    assert line["total"] == pytest.approx(100 * line["l1"])
    assert "gan" not in line and "discriminator" not in line


def started(config, folder, out, **environment):
    """A process of its own that trains; forked, as to load torch again takes seconds."""

    def run():
        os.environ |= environment
        train(config, [folder], out, device="cpu")

    process = multiprocessing.get_context("fork").Process(target=run)
    process.start()
    return process


def test_a_killed_training_goes_on_to_the_same_losses(folder, tmp_path):
    """Killed with checkpoints at every step, so in the middle of an epoch and of a line."""
    config = small(epochs=40, log_every=3, checkpoint_minutes=0.0, ema=0.9, workers=1)
    process = started(config, folder, tmp_path / "killed")
    log, wait_until = tmp_path / "killed" / "log.jsonl", time.monotonic() + 60
    while not log.exists() or log.read_text().count("\n") < 4:
        assert process.is_alive() and time.monotonic() < wait_until
        time.sleep(0.002)
    process.kill()
    process.join()
    assert process.exitcode == -signal.SIGKILL

    progress = read_facts(tmp_path / "killed" / "last.safetensors")["progress"]
    assert 3 < progress["step"] < 160
    config = dataclasses.replace(config, epochs=progress["epoch"] + 3)
    report = train(config, [folder], tmp_path / "killed", device="cpu")
    assert 0 < report.steps_now < report.steps
    undisturbed = dataclasses.replace(config, workers=0, checkpoint_minutes=10.0)
    train(undisturbed, [folder], tmp_path / "whole", device="cpu")
    assert lines(tmp_path / "killed") == lines(tmp_path / "whole")
    assert lines(tmp_path / "killed", "validation") == lines(tmp_path / "whole", "validation")
    killed, whole = (
        safetensors.torch.load_file(tmp_path / name / "last.safetensors")
        for name in ("killed", "whole")
    )
    assert killed.keys() == whole.keys()
    assert all(torch.equal(killed[name], whole[name]) for name in whole)


def test_interrupted_it_saves_first(folder, tmp_path):
    def interrupt(done, _):
        if done == 6:
            signal.raise_signal(signal.SIGINT)

    with pytest.raises(KeyboardInterrupt):
        train(small(), [folder], tmp_path / "run", device="cpu", on_progress=interrupt)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    report = train(small(), [folder], tmp_path / "run", device="cpu")
    assert (report.steps_now, report.steps) == (5, 8)
    train(small(), [folder], tmp_path / "whole", device="cpu")
    assert lines(tmp_path / "run") == lines(tmp_path / "whole")


def test_two_processes_are_one_with_twice_the_batch(folder, tmp_path):
    norm = {"norm": "instance"}
    config = small(generator=GeneratorConfig(ngf=8, depth=4, dropout=0.0, **norm), lr=1e-4)
    ranks = [
        started(
            config, folder, tmp_path / "two", RANK=str(rank), WORLD_SIZE="2",
            MASTER_ADDR="127.0.0.1", MASTER_PORT=str(20_000 + os.getpid() % 20_000),
        )
        for rank in (0, 1)
    ]  # fmt: skip
    train(dataclasses.replace(config, batch_size=4), [folder], tmp_path / "one", device="cpu")
    for process in ranks:
        process.join(timeout=120)
        assert process.exitcode == 0
    for kind in ("train", "validation"):
        two, one = lines(tmp_path / "two", kind), lines(tmp_path / "one", kind)
        assert len(two) == len(one) > 0
        for a, b in zip(two, one, strict=True):
            assert a == pytest.approx(b, rel=2e-4), kind


# Refusals.


def test_another_training_or_folder_is_refused(folder, tmp_path):
    config, out = small(epochs=1), tmp_path / "run"
    train(config, [folder], out, device="cpu")
    held = (out / "last.safetensors").read_bytes()

    def refused(complaint, config=config, folder=folder, out=out, **how):
        with pytest.raises(SynthdepthError, match=complaint) as raised:
            train(config, [folder], out, device="cpu", **how)
        assert "\n" not in str(raised.value)

    other = dataclasses.replace(config, lr=1e-3)
    refused(r"different training: config.lr is 0.0002 there and 0.001 was asked for", other)
    flow = small(epochs=1, input=InputConfig(kind="flow"))
    refused(r"config.input.kind is \"rgb\" there and \"flow\"", flow)
    refused("config.decay", dataclasses.replace(config, decay="linear"))
    another = make_dataset(tmp_path / "other", shards=4, pairs=8, camera=CAMERA, seed=5)
    refused("different training: data.shards", folder=another)
    refused("holds a training: allowed is another folder", resume=False)
    (tmp_path / "notes").mkdir()
    (tmp_path / "notes" / "todo.txt").touch()
    refused("holds todo.txt and no training", out=tmp_path / "notes")
    assert (out / "last.safetensors").read_bytes() == held
    # What no weight depends on may change, and more epochs extend it.
    again = dataclasses.replace(config, workers=1, epochs=2)
    assert train(again, [folder], out, device="cpu").steps_now == 4


def test_a_loss_that_is_no_number_stops_it(folder, tmp_path, monkeypatch):
    def lost(*_, **__):
        return {n: torch.full((), math.nan, requires_grad=True) for n in ("total", "gan", "l1")}

    monkeypatch.setattr("synthdepth.pix2pix.train.generator_losses", lost)
    with pytest.raises(SynthdepthError, match=r"the loss total is nan by step 2: a smaller lr"):
        train(small(), [folder], tmp_path / "run", device="cpu")


def test_a_full_disk_is_one_line(folder, tmp_path, monkeypatch):
    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("synthdepth.dataset.shard.os.fsync", full)
    with pytest.raises(
        DatasetError, match=r"the disk of .*run is full: free space, then run again"
    ):
        train(small(), [folder], tmp_path / "run", device="cpu")
    assert list((tmp_path / "run").iterdir()) == []
    monkeypatch.undo()
    (tmp_path / "file").touch()
    with pytest.raises(SynthdepthError, match="file is a file: allowed is a folder"):
        train(small(), [folder], tmp_path / "file", device="cpu")


def test_unknown_devices_are_refused():
    with pytest.raises(SynthdepthError, match=r"device 'tpu': allowed are cpu"):
        find_device("tpu")


def test_files_that_are_no_models_are_refused(tmp_path):
    config = small()
    state = State(config, torch.device("cpu"))
    facts = {"config": config.as_table()}
    save_model(tmp_path / "model.safetensors", state.generator, facts)
    generator, loaded = load_generator(tmp_path / "model.safetensors")
    assert loaded == config and not generator.training
    image = torch.rand(1, 3, 32, 48)
    assert torch.equal(generator(image), state.generator.eval()(image))

    def refused(path, complaint, read=load_generator):
        with pytest.raises(SynthdepthError, match=complaint) as raised:
            read(path)
        assert "\n" not in str(raised.value)

    (tmp_path / "text.safetensors").write_text("no weights")
    (tmp_path / "empty").mkdir()
    safetensors.torch.save_file({"a": torch.zeros(1)}, tmp_path / "other.safetensors")
    wrong = {"config": small(generator=GeneratorConfig(ngf=4, depth=4)).as_table()}
    save_model(tmp_path / "wrong.safetensors", state.generator, wrong)
    refused(tmp_path / "no.safetensors", "there is no such file")
    refused(tmp_path / "text.safetensors", "allowed is a .safetensors file that `synthdepth train`")
    refused(tmp_path / "other.safetensors", r"no header")
    refused(tmp_path / "empty", "holds no model")
    refused(tmp_path / "wrong.safetensors", "does not agree with its own configuration")
    refused(tmp_path / "model.safetensors", "is a model", lambda p: restore_state(p, state))


def test_a_state_comes_back_whole(tmp_path):
    config = small(ema=0.9)
    ours, theirs = (State(dataclasses.replace(config, seed=s), torch.device("cpu")) for s in (0, 1))
    for state in (ours, theirs):  # as on a GPU
        state.generator.to(memory_format=torch.channels_last)
    ours.generator(torch.rand(2, 3, 32, 48)).sum().backward()
    ours.generator_adam.step()
    ours.progress.step, ours.progress.best = 7, {"rel": 0.1 + 0.2}
    save_state(tmp_path / "a.safetensors", ours, {"config": config.as_table()})
    restore_state(tmp_path / "a.safetensors", theirs)
    assert theirs.progress == ours.progress
    for (_, a, adam_a), (_, b, adam_b) in zip(ours.networks(), theirs.networks(), strict=True):
        assert all(map(torch.equal, a.state_dict().values(), b.state_dict().values()))
        for p, q in zip(a.parameters(), b.parameters(), strict=True):
            assert p.stride() == q.stride()
            for name, value in (adam_a.state.get(p, {}) if adam_a else {}).items():
                assert torch.equal(adam_b.state[q][name], value)
                assert adam_b.state[q][name].stride() == value.stride()
