"""Pix2Pix: shape of the networks against their description, and the original's weights."""

import copy
import math

import pytest
import torch
import torch.nn.functional as F
from hypothesis import given, settings
from hypothesis import strategies as st
from torch import nn

from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix.discriminator import DiscriminatorConfig, PatchDiscriminator
from synthdepth.pix2pix.generator import GeneratorConfig, UNetGenerator
from synthdepth.pix2pix.inference import for_inference
from synthdepth.pix2pix.layers import NORMS, draw_weights
from synthdepth.pix2pix.original import (
    load_original_discriminator,
    load_original_generator,
    original_weights,
)

SMALL = {"ngf": 4, "depth": 6}


@pytest.fixture
def rng():
    return torch.Generator().manual_seed(0)


def generator(rng, **config):
    return draw_weights(UNetGenerator(GeneratorConfig(**{**SMALL, **config})), rng)


def discriminator(rng, **config):
    return draw_weights(PatchDiscriminator(DiscriminatorConfig(**{"ndf": 8, **config})), rng)


def pictures(rng, *shape):
    return 2 * torch.rand(*shape, generator=rng) - 1


def count(network):
    return sum(parameter.numel() for parameter in network.parameters())


# The structure, against a second writing of its description: nested, as the authors name it.


class Level(nn.Module):
    """A level of the U-Net that holds all levels inside it; outside of all, it is the network."""

    def __init__(self, outside, inside, within, *, rgb=None, out=None, norm="batch", drop=0.0):
        super().__init__()
        self.outermost, biased = rgb is not None, norm == "instance"
        make = nn.BatchNorm2d if norm == "batch" else nn.InstanceNorm2d
        down = nn.Conv2d(rgb or outside, inside, 4, 2, 1, bias=biased)
        wide = inside * (1 if within is None else 2)
        up = nn.ConvTranspose2d(wide, out or outside, 4, 2, 1, bias=biased or self.outermost)
        if self.outermost:
            parts = [down, within, nn.ReLU(), up, nn.Tanh()]
        elif within is None:
            parts = [nn.LeakyReLU(0.2), down, nn.ReLU(), up, make(outside)]
        else:
            parts = [nn.LeakyReLU(0.2), down, make(inside), within, nn.ReLU(), up, make(outside)]
            parts += [nn.Dropout(drop)] if drop else []
        self.model = nn.Sequential(*parts)

    def forward(self, x):
        return self.model(x) if self.outermost else torch.cat([x, self.model(x)], 1)


def nested(config):
    """`config` as nested levels, under the attribute `model` that the files' names begin with."""
    widths, kind = config.widths, {"norm": config.norm}
    level = Level(widths[-2], widths[-1], None, **kind)
    for k in range(config.depth - 2, 0, -1):
        drop = config.dropout if widths[k - 1] == 8 * config.ngf else 0.0
        level = Level(widths[k - 1], widths[k], level, drop=drop, **kind)
    ends = {"rgb": config.in_channels, "out": config.out_channels}
    whole = nn.Module()
    whole.model = Level(None, widths[0], level, **ends, **kind)
    return whole


def patch_gan(config):
    biased, make = config.norm == "instance", NORMS[config.norm]
    parts, wide = [nn.Conv2d(config.in_channels, config.ndf, 4, 2, 1), nn.LeakyReLU(0.2)], 1
    for k in range(1, config.layers + 1):
        before, wide = wide, min(2**k, 8)
        stride = 2 if k < config.layers else 1
        shape = (before * config.ndf, wide * config.ndf, 4, stride, 1)
        parts += [nn.Conv2d(*shape, bias=biased), make(wide * config.ndf), nn.LeakyReLU(0.2)]
    whole = nn.Module()
    whole.model = nn.Sequential(*parts, nn.Conv2d(wide * config.ndf, 1, 4, 1, 1))
    return whole


@pytest.mark.parametrize("norm", ["batch", "instance"])
@pytest.mark.parametrize("channels", [(3, 1), (5, 3)])
def test_the_unet_is_the_nested_one(rng, monkeypatch, norm, channels):
    """Same weights and noise: the same output, and the same gradient of every weight."""

    def dropout(x, p, training, inplace):
        # PyTorch's own draws in the order of memory, which differs between the two.
        return x * (torch.rand(x.shape) >= p) / (1 - p) if training else x

    monkeypatch.setattr(F, "dropout", dropout)
    config = {"in_channels": channels[0], "out_channels": channels[1], "norm": norm}
    ours = generator(rng, dropout=0.5, **config).double()
    theirs = nested(ours.config).double()
    theirs.load_state_dict(original_weights(ours), strict=True)
    image = pictures(rng, 2, channels[0], 64, 128).double()
    results = []
    for network in (ours, theirs.model):
        torch.manual_seed(3)
        results.append(network(image).float())
    torch.testing.assert_close(*results, rtol=0, atol=1e-6)

    cotangent = torch.rand(results[0].shape, generator=rng)
    for result in results:
        (result * cotangent).sum().backward()
    gradients = copy.deepcopy(ours)
    for gradient, parameter in zip(gradients.parameters(), ours.parameters(), strict=True):
        gradient.data = parameter.grad
    renamed = original_weights(gradients)
    for name, parameter in theirs.named_parameters():
        assert parameter.grad.abs().max() > 0, name
        torch.testing.assert_close(renamed[name], parameter.grad, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("norm", ["batch", "instance"])
@pytest.mark.parametrize("layers", [1, 3, 4])
def test_the_discriminator_is_the_described_one(rng, norm, layers):
    ours = discriminator(rng, norm=norm, layers=layers)
    theirs = patch_gan(ours.config)
    theirs.load_state_dict(original_weights(ours), strict=True)
    image, depth = pictures(rng, 2, 3, 96, 80), pictures(rng, 2, 1, 96, 80)
    expected = theirs.model(torch.cat([image, depth], 1))
    torch.testing.assert_close(ours(image, depth), expected, rtol=0, atol=1e-5)


def test_sizes_are_the_published_ones():
    with torch.device("meta"):
        unet = UNetGenerator(GeneratorConfig(out_channels=3))
        patches = PatchDiscriminator(DiscriminatorConfig(in_channels=6))
        logits = patches(torch.empty(2, 3, 256, 256), torch.empty(2, 3, 256, 256))
    assert round(count(unet) / 1e6, 2) == 54.41
    assert round(count(patches) / 1e6, 2) == 2.77
    assert logits.shape == (2, 1, 30, 30)
    assert unet.config.widths == [64, 128, 256, 512, 512, 512, 512, 512]


def test_three_dropouts_and_where():
    """In the blocks of 512 channels, all but the innermost; a smaller U-Net has fewer."""
    places = {}
    for depth in (9, 8, 7, 5):
        with torch.device("meta"):
            unet = UNetGenerator(GeneratorConfig(depth=depth))
        places[depth] = [n for n, m in unet.named_modules() if isinstance(m, nn.Dropout)]
        assert all(m.p == 0.5 for m in unet.modules() if isinstance(m, nn.Dropout))
    assert places[8] == ["decoders.1.dropout", "decoders.2.dropout", "decoders.3.dropout"]
    assert [len(places[depth]) for depth in (9, 7, 5)] == [4, 2, 0]
    with torch.device("meta"):
        silent = UNetGenerator(GeneratorConfig(dropout=0.0))
    assert not [m for m in silent.modules() if isinstance(m, nn.Dropout)]


def test_dropout_is_the_noise(rng):
    unet, image = generator(rng), pictures(rng, 1, 3, 64, 64)
    assert not torch.equal(unet(image), unet(image))
    unet.eval()
    assert torch.equal(unet(image), unet(image))


def test_first_weights(rng):
    unet = generator(rng, ngf=32)
    convolutions = [m for m in unet.modules() if isinstance(m, nn.Conv2d | nn.ConvTranspose2d)]
    drawn = torch.cat([m.weight.flatten() for m in convolutions])
    scales = torch.cat([m.weight for m in unet.modules() if isinstance(m, nn.BatchNorm2d)])
    # A mean of n draws is off by std / sqrt(n), a standard deviation by std / sqrt(2 n).
    for values, mean in ((drawn, 0.0), (scales, 1.0)):
        assert abs(values.mean() - mean) < 5 * 0.02 / math.sqrt(len(values))
        assert abs(values.std() - 0.02) < 5 * 0.02 / math.sqrt(2 * len(values))
    assert all((b == 0).all() for n, b in unet.named_parameters() if n.endswith("bias"))
    again = generator(torch.Generator().manual_seed(0), ngf=32)
    assert all(map(torch.equal, again.parameters(), unet.parameters()))


# Any size, any batch.


@settings(max_examples=25, deadline=None)
@given(height=st.integers(1, 150), width=st.integers(1, 150))
def test_any_size(height, width):
    unet = generator(torch.Generator().manual_seed(0), ngf=2).eval()
    with torch.no_grad():
        depth = unet(torch.zeros(1, 3, height, width))
    assert depth.shape == (1, 1, height, width)
    assert depth.dtype == torch.float32 and depth.abs().max() <= 1


def test_other_sizes_see_their_own_pixels(rng):
    """A size that needs padding gives what the picture, padded by hand, gives there."""
    unet, image = generator(rng).eval(), pictures(rng, 1, 3, 100, 75)
    by_hand = F.pad(image, (26, 27, 14, 14), mode="reflect")
    with torch.no_grad():
        assert torch.equal(unet(image), unet(by_hand)[..., 14:114, 26:101])


def test_resizing_has_the_same_sizes(rng):
    resized = generator(rng, upsample="resize", norm="group")
    with torch.no_grad():
        assert resized(pictures(rng, 1, 3, 64, 96)).shape == (1, 1, 64, 96)


@pytest.mark.parametrize("norm", ["batch", "instance", "group"])
def test_a_batch_is_its_pictures(rng, norm):
    """Evaluated, each picture has its own result, whatever its neighbours and their order."""
    unet, patches = generator(rng, norm=norm).eval(), discriminator(rng, norm=norm).eval()
    image = pictures(rng, 3, 3, 64, 64)
    with torch.no_grad():
        depth = unet(image)
        logits = patches(image, depth)
        for i in (2, 0, 1):
            alone = unet(image[i : i + 1])
            torch.testing.assert_close(alone[0], depth[i], rtol=0, atol=1e-6)
            judged = patches(image[i : i + 1], alone)
            torch.testing.assert_close(judged[0], logits[i], rtol=0, atol=1e-5)


@pytest.mark.parametrize(("layers", "pixels"), [(1, 16), (2, 34), (3, 70), (4, 142)])
def test_a_patch_has_70_pixels(rng, layers, pixels):
    """What a logit sees, by its gradient, in float64 so that none underflows."""
    patches = discriminator(rng, ndf=4, layers=layers).eval().double()
    image = torch.rand(1, 4, 256, 256, generator=rng, dtype=torch.float64, requires_grad=True)
    logits = patches(image[:, :3], image[:, 3:])
    logits[0, 0, logits.shape[2] // 2, logits.shape[3] // 2].backward()
    seen = image.grad.abs().sum(dim=(0, 1)) > 0
    assert (int(seen.any(1).sum()), int(seen.any(0).sum())) == (pixels, pixels)


def test_bfloat16_gives_float32_depth(rng):
    unet, image = generator(rng, ngf=16).eval(), pictures(rng, 2, 3, 64, 64)
    with torch.no_grad():
        exact = unet(image)
        with torch.autocast("cpu", torch.bfloat16):
            near = unet(image)
    assert near.dtype == torch.float32
    torch.testing.assert_close(near, exact, rtol=0, atol=0.02)


@pytest.mark.parametrize("norm", ["batch", "group"])
def test_inference_predicts_the_same(rng, norm):
    unet, image = generator(rng, norm=norm, ngf=16), pictures(rng, 4, 3, 64, 64)
    unet(image)  # running statistics worth folding
    weights = copy.deepcopy(unet.state_dict())
    fast, half = for_inference(unet), for_inference(unet, dtype=torch.bfloat16)
    folded = [module for module in fast.modules() if isinstance(module, nn.BatchNorm2d)]
    assert unet.training and not folded
    assert all(map(torch.equal, unet.state_dict().values(), weights.values()))
    expected = unet.eval()(image)
    torch.testing.assert_close(fast(image), expected, rtol=0, atol=1e-6)
    assert half(image).dtype == torch.float32
    torch.testing.assert_close(half(image), expected, rtol=0, atol=0.02)


# The original's weights.


def test_documented_names(rng):
    """Names as the files of the original have them, typed by hand for the real depth."""
    with torch.device("meta"):
        names = set(original_weights(UNetGenerator(GeneratorConfig())))
        patches = set(original_weights(PatchDiscriminator(DiscriminatorConfig())))
    deep = "model.model.1.model." + 6 * "3.model."
    assert {
        "model.model.0.weight",
        "model.model.3.weight",
        "model.model.3.bias",
        "model.model.1.model.1.weight",
        "model.model.1.model.2.running_mean",
        "model.model.1.model.3.model.5.weight",
        "model.model.1.model.3.model.6.num_batches_tracked",
        deep + "1.weight",
        deep + "3.weight",
        deep + "4.running_var",
    } <= names
    # 16 convolutions, 13 norms of five entries, one bias.
    assert len(names) == 16 + 13 * 5 + 1
    assert {"model.0.bias", "model.2.weight", "model.3.bias", "model.9.weight"} <= patches
    assert {"model.11.weight", "model.11.bias"} <= patches
    assert len(patches) == 5 + 2 + 3 * 5


@pytest.mark.parametrize("norm", ["batch", "instance"])
@pytest.mark.parametrize("channels", [(3, 3), (4, 1)])
@pytest.mark.parametrize("suffix", [".pth", ".safetensors"])
def test_weights_there_and_back(rng, tmp_path, norm, channels, suffix):
    from safetensors.torch import save_file

    save = save_file if suffix == ".safetensors" else torch.save
    shape = {"in_channels": channels[0], "out_channels": channels[1]}
    unet = generator(rng, norm=norm, **shape)
    patches = discriminator(rng, norm=norm, in_channels=sum(channels), layers=2)
    image = pictures(rng, 2, channels[0], 64, 64)
    depth = unet(image)  # in training mode, so that batch norms have something to remember
    patches(image, depth)
    save(original_weights(unet), tmp_path / f"latest_net_G{suffix}")
    save(original_weights(patches), tmp_path / f"latest_net_D{suffix}")

    again = load_original_generator(tmp_path / f"latest_net_G{suffix}")
    judge = load_original_discriminator(tmp_path / f"latest_net_D{suffix}")
    assert (again.config, judge.config) == (unet.config, patches.config)
    for network, loaded in ((unet, again), (patches, judge)):
        assert network.state_dict().keys() == loaded.state_dict().keys()
        assert all(map(torch.equal, network.state_dict().values(), loaded.state_dict().values()))
    assert torch.equal(again.eval()(image), unet.eval()(image))


def test_loading_copies(rng):
    weights = original_weights(generator(rng))
    before = {name: value.clone() for name, value in weights.items()}
    loaded = load_original_generator(weights)
    with torch.no_grad():
        loaded(pictures(rng, 2, 3, 64, 64))
        for parameter in loaded.parameters():
            parameter.add_(1)
    assert all(map(torch.equal, weights.values(), before.values()))


def test_old_files_count_no_batches(rng):
    weights = original_weights(generator(rng))
    old = {n: v for n, v in weights.items() if not n.endswith("num_batches_tracked")}
    loaded = load_original_generator(old).state_dict()
    assert all(v == 0 for n, v in loaded.items() if n.endswith("num_batches_tracked"))


class Code:
    def __reduce__(self):
        return (print, ("code ran",))


def test_wrong_weights_are_one_line(rng, tmp_path, capsys):
    unet, patches = generator(rng), discriminator(rng)
    good = original_weights(unet)
    lacking = {n: v for n, v in good.items() if n != "model.model.1.model.2.weight"}
    bent = good | {"model.model.1.model.1.weight": torch.zeros(1, 2, 4, 4)}
    torch.save({"model": Code()}, tmp_path / "code.pth")
    torch.save({"epoch": 3}, tmp_path / "other.pth")
    (tmp_path / "text.pth").write_text("no weights")
    (tmp_path / "text.safetensors").write_text("no weights")
    wrong = {
        "lacks model.model.1.model.2.weight": lacking,
        "too much": good | {"model.model.9.weight": torch.zeros(1)},
        "allowed is": bent,
        "no model.model.0.weight": original_weights(patches),
        "no such file": tmp_path / "none.pth",
        "not readable": tmp_path / "code.pth",
        "more than tensors": tmp_path / "other.pth",
        "not readable as weights": tmp_path / "text.pth",
        "not readable as weights;": tmp_path / "text.safetensors",
    }
    for part, source in wrong.items():
        with pytest.raises(SynthdepthError, match=part) as error:
            load_original_generator(source)
        assert "\n" not in str(error.value)
    with pytest.raises(SynthdepthError, match=r"no model\.0\.weight"):
        load_original_discriminator(good)
    with pytest.raises(SynthdepthError, match="norm batch or instance"):
        original_weights(generator(rng, norm="group"))
    assert "code ran" not in capsys.readouterr().out


@pytest.mark.parametrize(
    ("make", "part"),
    [
        (lambda: GeneratorConfig(norm="layer"), "allowed are batch, instance, group"),
        (lambda: GeneratorConfig(depth=1), "from 2 to 10"),
        (lambda: DiscriminatorConfig(layers=0), "from 1 to 6"),
    ],
)
def test_wrong_settings_are_one_line(make, part):
    with pytest.raises(SynthdepthError, match=part):
        make()
