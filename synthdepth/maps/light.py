"""Drawing the light of a scene: sun, clarity of the sky, visibility, exposure."""

import dataclasses

import numpy as np

from synthdepth.config import Config, span
from synthdepth.maps.world import Light


@dataclasses.dataclass(frozen=True, kw_only=True)
class LightRanges(Config):
    """What the light is drawn from.

    Attributes:
        sun_elevation_deg: drawn uniformly in its sine, as the sun spends its time.
        turbidity: of the clear-sky model; 2 is mountain air, 6 a hazy summer day.
        visibility_m: meteorological visibility, drawn log-uniformly.
    """

    sun_elevation_deg: tuple[float, float] = span((12, 65), 2, 90)
    turbidity: tuple[float, float] = span((2, 6), 1, 10)
    visibility_m: tuple[float, float] = span((6e3, 5e4), 50, 2e5)


def draw_light(rng: np.random.Generator, ranges: LightRanges) -> Light:
    """The light of one scene."""
    low, high = np.sin(np.radians(ranges.sun_elevation_deg))
    return Light(
        condition="clear",
        sun_azimuth_deg=float(rng.uniform(0, 360)),
        sun_elevation_deg=float(np.degrees(np.arcsin(rng.uniform(low, high)))),
        turbidity=float(rng.uniform(*ranges.turbidity)),
        visibility_m=float(np.exp(rng.uniform(*np.log(ranges.visibility_m)))),
    )
