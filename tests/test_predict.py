"""Prediction: the same depth from every kind of source, in files that say what they hold."""

import io

import cv2
import numpy as np
import OpenEXR
import pytest
import torch

from synthdepth.camera import Intrinsics
from synthdepth.dataset import PairDataset
from synthdepth.dataset.exr import decode_depth, depth_header
from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.checkpoint import load_generator, save_model
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.frames import open_frames
from synthdepth.pix2pix.generator import GeneratorConfig
from synthdepth.pix2pix.inputs import CHANNELS, InputConfig, MakeInput
from synthdepth.pix2pix.predict import Predictor, predict
from synthdepth.pix2pix.state import State
from synthdepth.pix2pix.target import DepthCoding
from tests.made import make_dataset

CAMERA = Intrinsics.from_fov(64, 48, 90.0)


@pytest.fixture(scope="module", autouse=True)
def one_thread():
    """Threads of tiny work only wait."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def write_model(path, kind="embed", **values):
    """A model with its first weights; metres by a logarithm, so that they vary."""
    config = TrainConfig(
        input=InputConfig(kind=kind),
        generator=GeneratorConfig(ngf=4, depth=4, norm="instance"),
        coding=DepthCoding(kind="log"),
        **values,
    )
    state = State(config, torch.device("cpu"))
    save_model(path, state.generator, {"config": config.as_table()})
    return path


@pytest.fixture(scope="module")
def models(tmp_path_factory):
    folder = tmp_path_factory.mktemp("models")
    return {kind: write_model(folder / f"{kind}.safetensors", kind) for kind in CHANNELS}


@pytest.fixture(scope="module")
def dataset(tmp_path_factory):
    """A scene of three consecutive pairs for each split."""
    folder = tmp_path_factory.mktemp("predict") / "set"
    return make_dataset(folder, shards=2, pairs=3, camera=CAMERA)


@pytest.fixture(scope="module")
def pairs(dataset):
    return list(PairDataset(dataset, split="train"))


@pytest.fixture(scope="module")
def flight(pairs):
    """Four consecutive frames (H, W, 3) uint8 RGB."""
    return [pairs[0].prev, *(pair.rgb for pair in pairs)]


@pytest.fixture
def pictures(flight, tmp_path):
    """The frames as pictures whose numbers have no zeros in front."""
    folder = tmp_path / "pictures"
    folder.mkdir()
    for number, frame in zip((8, 9, 10, 11), flight, strict=True):
        cv2.imwrite(str(folder / f"frame{number}.png"), frame[..., ::-1])
    return folder


def written(folder):
    """{name: (H, W) float32 [m]} of a folder of predictions."""
    return {
        path.name.removesuffix(".depth.exr"): decode_depth(path.read_bytes())
        for path in sorted(folder.glob("*.exr"))
    }


@pytest.mark.parametrize("kind", CHANNELS)
def test_it_is_the_generator_decoded(models, pairs, kind):
    predictor = Predictor(models[kind])
    depth_m = predictor.depth_m(pairs)
    inputs = np.stack([MakeInput(predictor.config.input)(pair).input for pair in pairs])
    with torch.no_grad():
        code = load_generator(models[kind])[0](torch.from_numpy(inputs.transpose(0, 3, 1, 2)))
    expected = predictor.config.coding.decode(code)[:, 0]
    assert depth_m.shape == (3, 48, 64) and depth_m.dtype == np.float32
    np.testing.assert_allclose(depth_m, expected, rtol=1e-4)
    assert depth_m.std() > 0 and depth_m.min() > 0 and depth_m.max() <= 200


def test_arrays_are_as_good_as_samples(models, pairs):
    predictor = Predictor(models["embed"])
    rgb, prev = np.stack([p.rgb for p in pairs]), np.stack([p.prev for p in pairs])
    np.testing.assert_array_equal(predictor.depth_m(rgb, prev), predictor.depth_m(pairs))
    alone = Predictor(models["rgb"])
    np.testing.assert_array_equal(alone.depth_m(rgb), alone.depth_m(pairs))
    with pytest.raises(SynthdepthError, match="the input 'embed' needs prev, and frame has none"):
        predictor.depth_m(rgb)


def test_a_batch_is_its_frames(models, pairs):
    predictor = Predictor(models["embed"])
    one_by_one = np.concatenate([predictor.depth_m([pair]) for pair in pairs])
    np.testing.assert_allclose(predictor.depth_m(pairs), one_by_one, rtol=1e-4)


def test_half_precision_is_nearly_as_good(models, pairs):
    full, half = (Predictor(models["rgb"], precision=p).depth_m(pairs) for p in ("fp32", "bf16"))
    assert 0 < np.abs(half / full - 1).max() < 0.1
    with pytest.raises(SynthdepthError, match="precision 'fp16': allowed are fp32, bf16"):
        Predictor(models["rgb"], precision="fp16")


@pytest.mark.parametrize("kind", CHANNELS)
def test_a_dataset(models, dataset, pairs, tmp_path, kind):
    report = predict(models[kind], dataset, tmp_path / "out", split="train", batch_size=2)
    assert (report.frames, report.skipped) == (3, 0)
    found = written(tmp_path / "out")
    assert list(found) == [pair.key for pair in pairs]
    expected = Predictor(models[kind]).depth_m(pairs)
    np.testing.assert_allclose(list(found.values()), expected, rtol=1e-4)


def test_files_say_what_they_hold(models, dataset, pairs, tmp_path):
    predict(models["rgb"], dataset, tmp_path / "out", split="train")
    data = (tmp_path / "out" / f"{pairs[0].key}.depth.exr").read_bytes()
    header = depth_header(data)
    assert header["depthUnit"] == "metre" and header["maxDepth"] == 200
    assert str(CAMERA.matrix.tolist()) == header["intrinsics"]
    assert str(pairs[0].world_from_cam.tolist()) == header["worldFromCam"]
    coloured = cv2.imread(str(tmp_path / "out" / f"{pairs[0].key}.depth.png"))
    assert coloured.shape == (48, 64, 3)
    with OpenEXR.File(io.BytesIO(data), separate_channels=True) as file:
        assert list(file.channels()) == ["Z"]


def test_pictures_and_a_video_are_the_flight(models, pairs, flight, pictures, tmp_path):
    """Each frame's flow is to the one before, 9 to 10 too; the first has none and is left out."""
    said = []
    report = predict(
        models["flow"], pictures, tmp_path / "a", on_progress=lambda *at: said.append(at)
    )
    assert (report.frames, report.skipped) == (3, 1) and said[-1] == (3, 3)
    found = written(tmp_path / "a")
    assert set(found) == {"frame9", "frame10", "frame11"}
    expected = Predictor(models["flow"]).depth_m(pairs)
    for name, depth_m in zip(("frame9", "frame10", "frame11"), expected, strict=True):
        np.testing.assert_array_equal(found[name], depth_m)

    path = tmp_path / "flight.avi"
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, (64, 48))
    for frame in flight:
        video.write(np.ascontiguousarray(frame[..., ::-1]))
    video.release()
    report = predict(models["embed"], path, tmp_path / "b", batch_size=2)
    assert (report.frames, report.skipped) == (3, 1)
    assert list(written(tmp_path / "b")) == [f"flight-00000{k}" for k in (1, 2, 3)]
    # JPEG changes colours a little; every frame is there, in order, for a model that needs no t-1.
    shown = [sample.rgb for sample in open_frames(path, InputConfig(kind="rgb")).samples]
    assert len(shown) == 4
    errors = [[np.abs(a - b.astype(float)).mean() for b in flight] for a in shown]
    np.testing.assert_array_equal(np.argmin(errors, axis=1), range(4))


def test_intrinsics_of_pictures_are_those_given_or_none(models, pictures, tmp_path):
    report = predict(models["rgb"], pictures, tmp_path / "a", fov_deg=90.0)
    assert (report.frames, report.skipped) == (4, 0)
    header = depth_header((tmp_path / "a" / "frame8.depth.exr").read_bytes())
    assert header["intrinsics"] == str(CAMERA.matrix.tolist())
    predict(models["rgb"], pictures / "frame9.png", tmp_path / "b")
    header = depth_header((tmp_path / "b" / "frame9.depth.exr").read_bytes())
    assert "intrinsics" not in header and header["maxDepth"] == 200


def test_pictures_of_several_sizes(models, pictures, tmp_path):
    cv2.imwrite(str(pictures / "frame12.jpg"), np.zeros((33, 70, 3), np.uint8))
    predict(models["rgb"], pictures, tmp_path / "out")
    assert written(tmp_path / "out")["frame12"].shape == (33, 70)
    with pytest.raises(SynthdepthError, match="rgb has 70 x 33 pixels and prev 64 x 48"):
        predict(models["embed"], pictures, tmp_path / "more")
    assert not list(tmp_path.glob("more*"))


def test_a_model_with_a_size_of_its_own(pairs, dataset, tmp_path):
    model = write_model(tmp_path / "model.safetensors", size=(32, 24))
    small = Predictor(model).depth_m(pairs)
    assert small.shape == (3, 24, 32)
    predict(model, dataset, tmp_path / "out", split="train")
    large = np.stack(list(written(tmp_path / "out").values()))
    np.testing.assert_array_equal(large, small.repeat(2, axis=1).repeat(2, axis=2))


def test_what_cannot_be_predicted_is_one_line(models, pictures, dataset, tmp_path):
    def refused(complaint, source, model="embed", out="out", **how):
        with pytest.raises(SynthdepthError, match=complaint) as raised:
            predict(models[model], source, tmp_path / out, **how)
        assert "\n" not in str(raised.value)
        assert out == "full" or not list(tmp_path.glob(f"{out}*"))

    (tmp_path / "bare").mkdir()
    (tmp_path / "text.avi").write_text("no video")
    refused("no such folder or file", tmp_path / "nowhere")
    refused("no dataset.json and no pictures: allowed are", tmp_path / "bare")
    refused("text.avi is not a readable video", tmp_path / "text.avi")
    refused("has no poses, which the input 'triangulated'", pictures, "triangulated")
    refused("split 'test' is allowed for datasets only", pictures, split="test")
    refused("split = 'val': allowed are test, train", dataset, split="val")
    refused("frame9.png has 1 frame", pictures / "frame9.png")
    refused("batch_size 0", pictures, batch_size=0)
    refused("fov_deg 180: allowed is a number between", pictures, fov_deg=180)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "notes.txt").touch()
    refused("full is there already: allowed is a new or empty folder", pictures, out="full")
    cv2.imwrite(str(pictures / "frame9.jpg"), np.zeros((48, 64, 3), np.uint8))
    refused("allowed is one picture a name", pictures)
    (pictures / "frame9.jpg").unlink()
    (pictures / "frame12.png").write_bytes(b"nothing")
    refused("frame12.png is not a readable picture", pictures)
