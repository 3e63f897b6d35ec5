"""How frames are rendered. Knows no renderer, so that a plan can be made without one."""

import dataclasses

from synthdepth.config import Config, choice, choices, number
from synthdepth.errors import RecipeError

# What a pair can hold beside its pictures and depth.
MODALITIES = ("flow", "seg", "normal")


@dataclasses.dataclass(frozen=True, kw_only=True)
class RenderSettings(Config):
    """Samples, denoising and range.

    Attributes:
        spp: samples a pixel, a power of two (any other compiles a kernel of its own).
        denoise: OIDN's quality mode, or "off".
        max_depth_m: where the depth saturates [m].
        modalities: ground truth beside the depth: optical flow, labels, normals.
    """

    spp: int = number(4, 1, 4096)
    denoise: str = choice("fast", ("off", "fast", "balanced", "high"))
    max_depth_m: float = number(200.0, 1, 5000)
    modalities: tuple[str, ...] = choices((), MODALITIES)

    def __post_init__(self):
        super().__post_init__()
        if self.spp & (self.spp - 1):
            raise RecipeError(f"spp = {self.spp}: allowed are the powers of two from 1 to 4096")
