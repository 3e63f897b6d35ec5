"""Depth in metres to what the networks learn, a number in [-1, 1], and back.

Always float32: 8 bits, as in the paper, are steps of 0.8 m at 200 m.
"""

import dataclasses
import math

import torch

from synthdepth.config import Config, choice, number
from synthdepth.errors import RecipeError


@dataclasses.dataclass(frozen=True, kw_only=True)
class DepthCoding(Config):
    """The code t of a depth d.

    Attributes:
        kind: "log", t = 1 + 2 ln(d / max) / ln(max / min), the same share of error at each
            distance, or "linear", t = 2 d / max - 1 (the paper's depth image).
        max_depth_m: t = 1, exactly: depth saturates there.
        min_depth_m: "log": t = -1; nearer counts as this near. Nothing decodes to nearer, so that
            relative errors stay defined.
    """

    kind: str = choice("log", ("linear", "log"))
    max_depth_m: float = number(200.0, 1e-3, 1e6)
    min_depth_m: float = number(0.1, 1e-6, 1e6)

    def __post_init__(self):
        super().__post_init__()
        if self.min_depth_m >= self.max_depth_m:
            raise RecipeError(
                f"min_depth_m = {self.min_depth_m:g}: allowed is less than "
                f"max_depth_m = {self.max_depth_m:g}"
            )

    def encode(self, depth_m: torch.Tensor) -> torch.Tensor:
        """Code of a depth.

        Args:
            depth_m: any shape, metres; beyond the range it counts as at its end.

        Returns:
            The same shape, float32, in [-1, 1]; NaN stays NaN.
        """
        depth_m = depth_m.float()
        if self.kind == "linear":
            return (2 * depth_m.clamp(0, self.max_depth_m) / self.max_depth_m) - 1
        depth_m = depth_m.clamp(self.min_depth_m, self.max_depth_m)
        # Relative to the far end, where ln 1 = 0 makes the code exact.
        return (1 + 2 * torch.log(depth_m / self.max_depth_m) / self._log_span).clamp_min(-1)

    def decode(self, code: torch.Tensor) -> torch.Tensor:
        """Depth of a code.

        Args:
            code: any shape, as the generator gives it.

        Returns:
            The same shape, float32, metres, in [min_depth_m, max_depth_m].
        """
        code = code.float()
        if self.kind == "linear":
            depth_m = (code + 1) / 2 * self.max_depth_m
        else:
            depth_m = self.max_depth_m * torch.exp((code - 1) / 2 * self._log_span)
        return depth_m.clamp(self.min_depth_m, self.max_depth_m)

    @property
    def _log_span(self) -> float:
        return math.log(self.max_depth_m / self.min_depth_m)
