"""What the networks minimise: equations 15-17 of the paper, and further terms for depth.

Pure functions of tensors. All compute in float32, under autocast too. `valid` marks the pixels with
ground truth; a term without a single one is 0.
"""

import dataclasses

import torch
import torch.nn.functional as F

from synthdepth.config import Config, number
from synthdepth.pix2pix.layers import at_least_float32
from synthdepth.pix2pix.target import DepthCoding


@dataclasses.dataclass(frozen=True, kw_only=True)
class ObjectiveConfig(Config):
    """Weights of the generator's terms. As they stand, they are the paper's and the original's.

    Attributes:
        lambda_gan: of the adversarial term.
        lambda_l1: w of equation 17.
        lambda_silog: of `scale_invariant_log`; 0 leaves it out.
        lambda_gradient: of `multi_scale_gradient`; 0 leaves it out.
    """

    lambda_gan: float = number(1.0, 0.0, 1e6)
    lambda_l1: float = number(100.0, 0.0, 1e6)
    lambda_silog: float = number(0.0, 0.0, 1e6)
    lambda_gradient: float = number(0.0, 0.0, 1e6)


def adversarial(logits: torch.Tensor, real: bool) -> torch.Tensor:
    """-log D where the patches are to be taken for real, else -log(1 - D): binary cross-entropy.

    Args:
        logits: of the discriminator, any shape.
        real: what D is to say.

    Returns:
        Scalar: the mean over patches.
    """
    # -log sigmoid(x) = softplus(-x) and -log(1 - sigmoid(x)) = softplus(x), without overflow.
    logits = at_least_float32(logits)
    return F.softplus(-logits if real else logits).mean()


def discriminator_loss(real_logits: torch.Tensor, fake_logits: torch.Tensor) -> torch.Tensor:
    """Minus equation 15, halved, which slows the discriminator (Isola et al. 2017, section 3.3).

    Args:
        real_logits: D(i, gt).
        fake_logits: D(i, G(i, n)), with G(i, n) detached.
    """
    return 0.5 * (adversarial(real_logits, True) + adversarial(fake_logits, False))


def generator_losses(
    fake_logits: torch.Tensor,
    prediction: torch.Tensor,
    target: torch.Tensor,
    *,
    config: ObjectiveConfig,
    coding: DepthCoding,
    valid: torch.Tensor | None = None,
) -> dict[str, torch.Tensor]:
    """Equation 17 for the generator, which says -log D instead of log(1 - D) (Goodfellow 2014).

    Args:
        fake_logits: D(i, G(i, n)).
        prediction: (B, 1, H, W), G(i, n), coded.
        target: (B, 1, H, W), coded.
        config: weights of the terms.
        coding: how both are coded.
        valid: (B, 1, H, W), bool; none means all.

    Returns:
        Scalars: `total`, the weighted sum, and each of its terms without the weight: `gan`, `l1`
        and, with a weight above 0, `silog` and `gradient`.
    """
    terms = {"gan": adversarial(fake_logits, True), "l1": l1(prediction, target, valid)}
    total = config.lambda_gan * terms["gan"] + config.lambda_l1 * terms["l1"]
    if config.lambda_silog > 0:
        terms["silog"] = scale_invariant_log(
            coding.decode(prediction), coding.decode(target), valid
        )
        total = total + config.lambda_silog * terms["silog"]
    if config.lambda_gradient > 0:
        terms["gradient"] = multi_scale_gradient(prediction, target, valid)
        total = total + config.lambda_gradient * terms["gradient"]
    return {"total": total, **terms}


def l1(
    prediction: torch.Tensor, target: torch.Tensor, valid: torch.Tensor | None = None
) -> torch.Tensor:
    """Equation 16: mean |y - G(i, n)| over valid pixels; any shape."""
    return _mean(at_least_float32(prediction) - at_least_float32(target), valid, torch.abs)


def scale_invariant_log(
    prediction_m: torch.Tensor,
    target_m: torch.Tensor,
    valid: torch.Tensor | None = None,
    *,
    variance_focus: float = 0.5,
) -> torch.Tensor:
    """Scale-invariant error of Eigen et al. 2014 (NIPS), equation 4, per image, then the mean.

    E[e^2] - lambda E[e]^2 with e = ln p - ln g over the valid pixels of an image. Lambda 1 forgives
    any one factor on the whole depth, 0 forgives none. The SILog of BTS (Lee et al. 2019) is ten
    times the root of this with lambda 0.85; its gradient has no bound near 0.

    Args:
        prediction_m: (B, 1, H, W), metres, above 0 where valid.
        target_m: (B, 1, H, W), likewise.
        valid: (B, 1, H, W), bool.
        variance_focus: lambda, in [0, 1].
    """
    if valid is None:
        valid = torch.ones_like(target_m, dtype=torch.bool)
    # 1 m against 1 m is no error, and its logarithm is finite: so are gradients of invalid pixels.
    error = torch.log(torch.where(valid, at_least_float32(prediction_m), 1.0)) - torch.log(
        torch.where(valid, at_least_float32(target_m), 1.0)
    )
    count = valid.sum(dim=(1, 2, 3)).clamp_min(1)
    mean_square = error.square().sum(dim=(1, 2, 3)) / count
    square_mean = (error.sum(dim=(1, 2, 3)) / count).square()
    return (mean_square - variance_focus * square_mean).mean()


def multi_scale_gradient(
    prediction: torch.Tensor,
    target: torch.Tensor,
    valid: torch.Tensor | None = None,
    *,
    scales: int = 4,
) -> torch.Tensor:
    """Gradient matching of Li and Snavely 2018 (MegaDepth), equation 3: keeps edges sharp.

    Mean |dR/dx| + mean |dR/dy| of the difference R = prediction - target, summed over scales of 1,
    1/2, 1/4, ..., by taking every 2nd, 4th, ... pixel: averages would blend across edges. With the
    log coding R is the paper's, up to a factor.

    Args:
        prediction: (B, 1, H, W).
        target: (B, 1, H, W).
        valid: (B, 1, H, W), bool: a difference counts where both of its pixels are valid.
        scales: how many.
    """
    difference = at_least_float32(prediction) - at_least_float32(target)
    if valid is None:
        valid = torch.ones_like(difference, dtype=torch.bool)
    difference = torch.where(valid, difference, 0.0)
    total = difference.new_zeros(())
    for scale in range(scales):
        step = 2**scale
        r, v = difference[..., ::step, ::step], valid[..., ::step, ::step]
        for axis, size in ((-1, r.shape[-1]), (-2, r.shape[-2])):
            if size > 1:
                both = v.narrow(axis, 1, size - 1) & v.narrow(axis, 0, size - 1)
                total = total + _mean(r.diff(dim=axis), both, torch.abs)
    return total


def _mean(values: torch.Tensor, valid: torch.Tensor | None, of) -> torch.Tensor:
    """Mean of `of(values)` where valid; what is not valid may be NaN and gets no gradient."""
    if valid is None:
        return of(values).mean()
    return of(torch.where(valid, values, 0.0)).sum() / valid.sum().clamp_min(1)
