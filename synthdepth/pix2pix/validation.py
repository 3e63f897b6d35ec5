"""How far predictions are off in scenes that training never saw: the five numbers of the paper."""

from collections.abc import Iterable

import torch

from synthdepth.dataset import Batch
from synthdepth.pix2pix.config import TrainConfig
from synthdepth.pix2pix.distributed import Place
from synthdepth.pix2pix.generator import UNetGenerator

ERRORS = ("rmse_m", "rel", "delta_1", "delta_2", "delta_3")


def picture_errors(
    prediction_m: torch.Tensor, truth_m: torch.Tensor, valid: torch.Tensor
) -> torch.Tensor:
    """Equations 19-21 for each picture by itself.

    Args:
        prediction_m: (B, 1, H, W) float, above 0 [m].
        truth_m: (B, 1, H, W) float, above 0 where valid [m].
        valid: (B, 1, H, W) bool, which pixels count.

    Returns:
        (B, 5) float64 in the order of `ERRORS`; NaN for a picture without a valid pixel.
    """
    p = torch.where(valid, prediction_m, 1.0).double()
    g = torch.where(valid, truth_m, 1.0).double()
    count = valid.sum(dim=(1, 2, 3)).double()

    def mean(values: torch.Tensor) -> torch.Tensor:
        return torch.where(valid, values, 0.0).double().sum(dim=(1, 2, 3)) / count

    worse = torch.maximum(p / g, g / p)
    return torch.stack(
        [
            mean((g - p).square()).sqrt(),
            mean((g - p).abs() / g),
            *(mean((worse < 1.25**n).double()) for n in (1, 2, 3)),
        ],
        dim=1,
    )


@torch.no_grad()
def validate(
    generator: UNetGenerator, batches: Iterable[Batch], config: TrainConfig, place: Place
) -> dict[str, float]:
    """Mean errors over pictures, without the noise and with running statistics.

    Args:
        generator: on the device of `place`; its mode is as before afterwards.
        batches: this process's.
        config: how it is trained.
        place: the errors are of all processes together.

    Returns:
        {name in `ERRORS`: mean over the pictures with a valid pixel}.
    """
    training = generator.training
    generator.eval()
    sums = torch.zeros(len(ERRORS) + 1, dtype=torch.float64, device=place.device)
    for batch in batches:
        prediction_m = predict_batch(generator, batch, config, place.device)
        truth_m = batch.depth_m.to(place.device).clamp_max(config.coding.max_depth_m)
        errors = picture_errors(prediction_m, truth_m, batch.valid.to(place.device))
        known = errors[~errors.isnan().any(dim=1)]
        sums[:-1] += known.sum(dim=0)
        sums[-1] += len(known)
    generator.train(training)
    *totals, count = place.total(sums).tolist()
    return {name: total / max(count, 1) for name, total in zip(ERRORS, totals, strict=True)}


def predict_batch(
    generator: UNetGenerator, batch: Batch, config: TrainConfig, device: torch.device
) -> torch.Tensor:
    """Depth (B, 1, H, W) float32 [m] of a batch with its input, on the device."""
    with torch.autocast(device.type, torch.bfloat16, enabled=config.precision == "bf16"):
        code = generator(batch.input.to(device))
    return config.coding.decode(code)
