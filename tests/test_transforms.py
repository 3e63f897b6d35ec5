"""Batches and transforms: pictures, ground truth, cameras and poses go on agreeing."""

import dataclasses
import pickle

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.camera import Intrinsics
from synthdepth.dataset import EmbedFlow, PairDataset, RandomFlip, Resize, collate
from synthdepth.dataset.pair import camera_of
from synthdepth.dataset.transforms import flipped
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.flow import embed, estimate_flow, flow_from_depth
from tests.made import make_dataset

# Nothing about it is symmetric.
CAMERA = Intrinsics(width=64, height=48, fx=40.0, fy=44.0, cx=25.0, cy=27.5)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("transforms") / "set"
    modalities = ("flow", "seg", "normal")
    return make_dataset(path, shards=3, pairs=2, modalities=modalities, camera=CAMERA)


@pytest.fixture(scope="module")
def sample(folder):
    return PairDataset(folder)[3]


# Batches


def test_a_batch_holds_what_its_samples_hold(folder):
    samples = list(PairDataset(folder))[:4]
    batch = collate(samples)
    shapes = {"rgb": 3, "prev": 3, "depth_m": 1, "valid": 1, "visible": 1, "seg": 1, "flow": 2}
    for name, channels in (shapes | {"normal": 3}).items():
        tensor = getattr(batch, name)
        assert tensor.shape == (4, channels, 48, 64) and tensor.is_contiguous()
        for k, sample in enumerate(samples):
            theirs = getattr(sample, name).reshape(48, 64, channels)
            assert tensor.numpy().dtype == theirs.dtype
            assert np.array_equal(tensor[k].permute(1, 2, 0).numpy(), theirs)
    for name in ("intrinsics", "world_from_cam", "world_from_cam_prev"):
        assert np.array_equal(getattr(batch, name)[2].numpy(), getattr(samples[2], name))
    assert batch.input is None and batch.keys == [s.key for s in samples] and len(batch) == 4
    assert batch.meta[1] == samples[1].meta and batch.max_depth_m.tolist() == [200.0] * 4
    picture = batch.as_float()
    assert picture.dtype == torch.float32 and picture.max() <= 1
    assert torch.equal((picture * 255).round().to(torch.uint8), batch.rgb)


def test_a_batch_moves_and_pins(folder, monkeypatch):
    batch = collate([PairDataset(folder, fields="rgb")[0]])
    moved = batch.to("meta")
    assert moved.rgb.device.type == moved.intrinsics.device.type == "meta"
    assert moved.flow is None and moved.keys == batch.keys
    # Pinning needs a GPU; that every tensor is asked for it does not.
    monkeypatch.setattr(torch.Tensor, "pin_memory", lambda tensor: tensor + 1)
    pinned = torch.utils.data._utils.pin_memory.pin_memory(batch)
    assert torch.equal(pinned.rgb, batch.rgb + 1) and pinned.meta == batch.meta


def test_what_does_not_fit_into_a_batch_is_named(folder, tmp_path):
    whole, plain = PairDataset(folder)[0], PairDataset(folder, fields=("rgb", "depth_m"))[1]
    with pytest.raises(DatasetError, match=f"prev is missing in {plain.key}"):
        collate([whole, plain])
    small = make_dataset(
        tmp_path / "s", shards=1, pairs=1, camera=Intrinsics.from_fov(32, 24, 90.0)
    )
    with pytest.raises(DatasetError, match=r"rgb has the shapes \(24, 32, 3\), \(48, 64, 3\)"):
        collate([plain, PairDataset(small, fields=("rgb", "depth_m"))[0]])
    with pytest.raises(DatasetError, match="no samples"):
        collate([])


# Transforms


def camera(sample) -> Intrinsics:
    height, width = sample.depth_m.shape
    (fx, _, cx), (_, fy, cy), _ = sample.intrinsics
    return Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy)


def geometric_flow(sample):
    """Flow as depth, camera and poses have it; NaN in the sky and where that place is behind."""
    return flow_from_depth(
        sample.depth_m,
        camera(sample),
        sample.world_from_cam,
        sample.world_from_cam_prev,
        max_depth_m=sample.max_depth_m,
        beyond="unknown",
    )


def test_a_mirrored_sample_agrees_with_itself(sample):
    mirrored = flipped(sample)
    for one in (sample, mirrored):
        expected = geometric_flow(one)
        near = np.isfinite(expected).all(axis=-1)
        assert near.mean() > 0.5
        assert np.abs(one.flow - expected)[near].max() < 1e-3
        for pose in (one.world_from_cam, one.world_from_cam_prev):
            assert np.isclose(np.linalg.det(pose[:3, :3]), 1)
        # The ground's normal is up in the world, and the wall's faces the camera along x.
        up = one.normal @ one.world_from_cam[:3, :3].T
        assert np.allclose(up[one.seg == 1], [0, 0, 1], atol=1e-6)
    facing = mirrored.normal @ mirrored.world_from_cam[:3, :3].T
    assert (mirrored.seg == 4).any()
    assert np.allclose(facing[mirrored.seg == 4], [1, 0, 0], atol=1e-6)
    assert np.array_equal(mirrored.rgb, sample.rgb[:, ::-1])
    assert np.array_equal(mirrored.visible, sample.visible[:, ::-1])
    # Everything that the flow says of the pictures holds: prev at (x + u, y + v) shows rgb.
    twice = flipped(mirrored)
    for name, value in vars(sample).items():
        if isinstance(value, np.ndarray):
            assert np.allclose(getattr(twice, name), value)
            assert getattr(mirrored, name).flags.c_contiguous


def test_a_mirrored_sample_keeps_a_skew_where_it_belongs(sample):
    skewed = dataclasses.replace(
        sample, intrinsics=sample.intrinsics + [[0, 3, 0], [0] * 3, [0] * 3]
    )
    point = np.array([1.0, 2.0, 10.0])
    u, v, _ = skewed.intrinsics @ point / 10
    mirrored_u, mirrored_v, _ = flipped(skewed).intrinsics @ (point * [-1, 1, 1]) / 10
    assert (mirrored_u, mirrored_v) == pytest.approx((CAMERA.width - 1 - u, v))


def test_what_is_mirrored_depends_on_seed_key_and_epoch_alone(sample):
    samples = [dataclasses.replace(sample, key=f"k{number}") for number in range(200)]

    def drawn(flip, order):
        return {s.key: not np.array_equal(flip(s).rgb, s.rgb) for s in order}

    flip = RandomFlip(0.3, seed=4)
    first = drawn(flip, samples)
    assert 0.2 < np.mean(list(first.values())) < 0.4
    assert drawn(flip, samples[::-1]) == first == drawn(pickle.loads(pickle.dumps(flip)), samples)
    flip.set_epoch(1)
    assert drawn(flip, samples) != first
    assert drawn(RandomFlip(0.3, seed=5), samples) != first
    assert not any(drawn(RandomFlip(0), samples).values())
    assert all(drawn(RandomFlip(1), samples).values())
    with pytest.raises(DatasetError, match="share = 2"):
        RandomFlip(2)


def test_the_datasets_tell_their_transforms_the_epoch(folder):
    dataset = PairDataset(folder, transform=[RandomFlip(), Resize(24, 32)])
    passes = set()
    for epoch in range(8):
        dataset.set_epoch(epoch)
        passes.add(b"".join(sample.rgb.tobytes() for sample in dataset))
    assert len(passes) > 4


@settings(max_examples=30, deadline=None)
@given(height=st.integers(1, 100), width=st.integers(1, 100))
def test_ground_truth_is_picked_and_never_blended(sample, height, width):
    small = Resize(height, width)(sample)
    v = [(2 * k + 1) * 48 // (2 * height) for k in range(height)]
    u = [(2 * k + 1) * 64 // (2 * width) for k in range(width)]
    for name in ("depth_m", "valid", "visible", "seg", "normal"):
        assert np.array_equal(getattr(small, name), getattr(sample, name)[np.ix_(v, u)])
    share = np.float32([width / 64, height / 48])
    assert np.allclose(small.flow, sample.flow[np.ix_(v, u)] * share)
    assert small.flow.dtype == np.float32
    assert small.rgb.shape == small.prev.shape == (height, width, 3)
    # The edges of the picture see along the same rays as before.
    for one, size in ((sample, (64, 48)), (small, (width, height))):
        k = one.intrinsics
        first = (-0.5 - k[:2, 2]) / np.diag(k)[:2]
        last = (np.array(size) - 0.5 - k[:2, 2]) / np.diag(k)[:2]
        if one is sample:
            edges = first, last
        assert np.allclose([first, last], edges)


def test_an_enlarged_sample_agrees_with_itself(sample):
    """Three times as large, every centre of before is a centre again."""
    large = Resize(144, 192)(sample)
    expected = geometric_flow(large)[1::3, 1::3]
    near = np.isfinite(expected).all(axis=-1)
    assert near.mean() > 0.5
    assert np.abs(large.flow[1::3, 1::3] - expected)[near].max() < 3e-3
    assert Resize(48, 64)(sample) is sample
    assert large.meta == sample.meta and camera_of(large.meta).width == 64
    with pytest.raises(DatasetError, match="Resize height = 0"):
        Resize(0, 5)


def test_a_flat_picture_stays_flat_and_centred(sample):
    """A picture that is linear in u stays linear in the new u, by the same intrinsics."""
    ramp = np.repeat(np.arange(64, dtype=np.uint8)[None, :, None] * 4, 48, 0).repeat(3, -1)
    small = Resize(24, 32)(dataclasses.replace(sample, rgb=ramp))
    u = (np.arange(32) + 0.5) * 2 - 0.5
    assert np.abs(small.rgb[5, :, 0] - 4 * u).max() <= 0.5


def test_the_input_is_the_picture_with_its_flow_embedded(sample):
    given_flow = estimate_flow(sample.prev, sample.rgb, "dis")
    done = EmbedFlow(interval=3, method="dis", px_at_white=8.0)(sample)
    assert np.array_equal(done.input, embed(sample.rgb, given_flow, 3, px_at_white=8.0))
    assert (done.input != sample.rgb).any(axis=-1)[::3, ::3].mean() > 0.5
    assert np.array_equal(done.input[1::3], sample.rgb[1::3])
    true = EmbedFlow(method="truth")(sample)
    assert np.array_equal(true.input, embed(sample.rgb, sample.flow, 5))
    assert collate([done]).input.shape == (1, 3, 48, 64)
    for late in (Resize(24, 32), RandomFlip()):
        with pytest.raises(DatasetError, match="comes before the transform that makes the input"):
            late(done)


def test_what_an_embedding_lacks_is_named(sample):
    for lacking, method in (("prev", "farneback"), ("flow", "truth"), ("rgb", "dis")):
        with pytest.raises(DatasetError, match=f"needs the field {lacking}, and {sample.key}"):
            EmbedFlow(method=method)(dataclasses.replace(sample, **{lacking: None}))
    with pytest.raises(SynthdepthError, match="flow method 'magic'"):
        EmbedFlow(method="magic")(sample)
