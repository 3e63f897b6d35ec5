"""Pix2Pix: the losses against their equations, and depth to [-1, 1] and back."""

import math

import pytest
import torch
import torch.nn.functional as F
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.errors import SynthdepthError
from synthdepth.pix2pix import objective
from synthdepth.pix2pix.target import DepthCoding


@pytest.fixture
def rng():
    return torch.Generator().manual_seed(0)


def pictures(rng, *shape):
    return 2 * torch.rand(*shape, generator=rng) - 1


# Losses.


def test_equation_15_and_17(rng):
    """Against the equations, written with probabilities."""
    real, fake = 3 * torch.randn(2, 1, 30, 30, generator=rng), torch.randn(2, 1, 30, 30)
    d_real, d_fake = torch.sigmoid(real), torch.sigmoid(fake)
    equation_15 = torch.log(d_real).mean() + torch.log(1 - d_fake).mean()
    assert torch.isclose(objective.discriminator_loss(real, fake), -0.5 * equation_15)

    prediction, target = pictures(rng, 2, 1, 9, 7), pictures(rng, 2, 1, 9, 7)
    losses = objective.generator_losses(
        fake,
        prediction,
        target,
        config=objective.ObjectiveConfig(),
        coding=DepthCoding(kind="linear"),
    )
    l1 = (target - prediction).abs().sum() / target.numel()
    assert torch.isclose(losses["total"], -torch.log(d_fake).mean() + 100 * l1)
    assert losses.keys() == {"total", "gan", "l1"}


def test_adversarial_stays_finite():
    logits = torch.tensor([-1e4, 0.0, 1e4], requires_grad=True)
    for real in (True, False):
        expected = F.binary_cross_entropy_with_logits(logits, torch.full((3,), float(real)))
        loss = objective.adversarial(logits, real)
        assert torch.isclose(loss, expected)
        loss.backward()
    assert logits.grad.isfinite().all()


def test_losses_are_float32_from_bfloat16(rng):
    """The mean over a picture in bfloat16 would be off by per cents."""
    prediction = pictures(rng, 1, 1, 256, 256).bfloat16()
    target = pictures(rng, 1, 1, 256, 256)
    with torch.autocast("cpu", torch.bfloat16):
        loss = objective.l1(prediction, target)
        logits = objective.adversarial(prediction, True)
    assert loss.dtype == logits.dtype == torch.float32
    exact = (prediction.double() - target.double()).abs().mean()
    assert abs(loss.double() - exact) < 1e-6


TERMS = {
    "l1": objective.l1,
    "silog": objective.scale_invariant_log,
    "gradient": objective.multi_scale_gradient,
}


@pytest.mark.parametrize("term", TERMS.values(), ids=TERMS)
def test_invalid_pixels_do_not_count(rng, term):
    """Nonsense there changes neither the loss nor a gradient, NaN included."""
    prediction = (1 + 9 * torch.rand(2, 1, 24, 20, generator=rng)).requires_grad_()
    target = 1 + 9 * torch.rand(2, 1, 24, 20, generator=rng)
    valid = torch.rand(2, 1, 24, 20, generator=rng) < 0.4
    losses, gradients = [], []
    for nonsense in (5.0, -3.0, float("nan"), float("inf")):
        loss = term(prediction, torch.where(valid, target, nonsense), valid)
        losses.append(loss.detach())
        gradients.append(torch.autograd.grad(loss, prediction)[0])
    assert losses[0] > 0 and all(torch.equal(loss, losses[0]) for loss in losses)
    assert all(torch.equal(gradient, gradients[0]) for gradient in gradients)
    assert (gradients[0][~valid] == 0).all() and gradients[0].isfinite().all()
    assert torch.isclose(term(prediction, target), term(prediction, target, torch.ones_like(valid)))
    none = term(prediction, target, torch.zeros_like(valid))
    assert none == 0 and (torch.autograd.grad(none, prediction)[0] == 0).all()


@settings(max_examples=30, deadline=None)
@given(factor=st.floats(0.05, 20.0), focus=st.floats(0.0, 1.0))
def test_scale_invariance(factor, focus):
    """A factor s on all depth costs (1 - lambda) ln(s)^2, nothing at lambda 1."""
    target = 1 + torch.arange(60.0).reshape(1, 1, 6, 10)
    loss = objective.scale_invariant_log(factor * target, target, variance_focus=focus)
    assert math.isclose(loss, (1 - focus) * math.log(factor) ** 2, rel_tol=1e-3, abs_tol=1e-5)


def test_gradient_loss_sees_slopes_not_offsets():
    """On a ramp of slope a and b, the scale of step s adds s (a + b)."""
    rows, columns = torch.arange(32.0)[:, None], torch.arange(64.0)[None]
    ramp = (0.5 * rows + 0.25 * columns)[None, None]
    flat = torch.full_like(ramp, 7.0)
    assert objective.multi_scale_gradient(flat + 3, flat) == 0
    assert objective.multi_scale_gradient(ramp, flat, scales=1) == 0.75
    assert objective.multi_scale_gradient(ramp, flat) == 0.75 * (1 + 2 + 4 + 8)
    tiny = objective.multi_scale_gradient(torch.ones(1, 1, 1, 1), torch.zeros(1, 1, 1, 1))
    assert tiny == 0


def test_further_terms_join_the_total(rng):
    coding = DepthCoding(kind="log")
    prediction, target = pictures(rng, 2, 1, 16, 16), pictures(rng, 2, 1, 16, 16)
    config = objective.ObjectiveConfig(lambda_gan=2, lambda_l1=3, lambda_silog=5, lambda_gradient=7)
    losses = objective.generator_losses(
        torch.zeros(2, 1, 2, 2), prediction, target, config=config, coding=coding
    )
    weights = {"gan": 2, "l1": 3, "silog": 5, "gradient": 7}
    assert torch.isclose(losses["total"], sum(w * losses[n] for n, w in weights.items()))
    expected = objective.scale_invariant_log(coding.decode(prediction), coding.decode(target))
    assert losses["silog"] == expected


# Depth to [-1, 1] and back.


@pytest.mark.parametrize("kind", ["linear", "log"])
@settings(deadline=None)
@given(depth=st.lists(st.floats(0.125, 200.0, width=32), min_size=1, max_size=20))
def test_depth_there_and_back(kind, depth):
    coding, depth_m = DepthCoding(kind=kind), torch.tensor(depth)
    code = coding.encode(depth_m)
    assert code.dtype == torch.float32 and code.abs().max() <= 1
    # A code has steps of 6e-8: 6 um of 200 m, or 2.3e-7 of the depth if logarithmic.
    error = (coding.decode(code) - depth_m).abs()
    assert (error <= (2e-5 if kind == "linear" else 2e-6 * depth_m + 1e-7)).all()
    order = torch.argsort(depth_m)
    assert (code[order].diff() >= 0).all()


@pytest.mark.parametrize("kind", ["linear", "log"])
@pytest.mark.parametrize("max_depth_m", [200.0, 80.0, 123.4])
def test_saturated_depth_is_exact(kind, max_depth_m):
    coding = DepthCoding(kind=kind, max_depth_m=max_depth_m)
    far = torch.tensor([max_depth_m, 1e9, float("inf")])
    assert (coding.encode(far) == 1).all()
    assert (coding.decode(torch.tensor([1.0, 1.5])) == torch.tensor(max_depth_m)).all()
    near = coding.decode(torch.tensor([-1.0, -9.0]))
    torch.testing.assert_close(near, torch.full((2,), 0.1))


def test_codes_of_known_depths():
    depth_m = torch.tensor([0.0, 50.0, 100.0, 200.0])
    linear = DepthCoding(kind="linear")
    assert linear.encode(depth_m).tolist() == [-1.0, -0.5, 0.0, 1.0]
    log = DepthCoding(kind="log", max_depth_m=100.0, min_depth_m=0.01)
    expected = torch.tensor([-1.0, -0.5, 0.0, 0.5, 1.0])
    found = log.encode(torch.tensor([0.0, 0.1, 1.0, 10.0, 100.0]))
    torch.testing.assert_close(found, expected, rtol=0, atol=1e-6)


def test_finer_than_eight_bits():
    depth_m = torch.linspace(1, 199, 100_000)
    for kind in ("linear", "log"):
        assert len(DepthCoding(kind=kind).encode(depth_m).unique()) > 99_000


@pytest.mark.parametrize(
    ("make", "part"),
    [
        (lambda: DepthCoding(kind="cubic"), "allowed are linear, log"),
        (lambda: DepthCoding(min_depth_m=300.0), "allowed is less than max_depth_m = 200"),
        (lambda: objective.ObjectiveConfig(lambda_l1=-1.0), "from 0"),
    ],
)
def test_wrong_settings_are_one_line(make, part):
    with pytest.raises(SynthdepthError, match=part):
        make()
