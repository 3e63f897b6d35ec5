"""Drawing the light of a scene: its condition, sun or moon, clouds, air and wetness."""

import dataclasses

import numpy as np

from synthdepth.config import Config, choices, span
from synthdepth.maps.world import CONDITIONS, Light


@dataclasses.dataclass(frozen=True, kw_only=True)
class LightRanges(Config):
    """What the light is drawn from.

    Attributes:
        conditions: every scene has one of them; one that stands twice is drawn twice as often.
        sun_elevation_deg: drawn uniformly in its sine, as the sun spends its time.
        golden_elevation_deg: the sun's at the golden hour.
        moon_elevation_deg: the moon's at night.
        turbidity: of the clear-sky model; 2 is mountain air, 6 a hazy summer day.
        cloud_cover: share of the sky under clouds; overcast and fog have 1.
        visibility_m: meteorological visibility, drawn log-uniformly; haze and fog have their own.
        haze_visibility_m, fog_visibility_m: likewise.
        wetness: of the ground when it is wet; 0 is dry, 1 just after the rain.
    """

    conditions: tuple[str, ...] = choices(CONDITIONS, CONDITIONS, least=1)
    sun_elevation_deg: tuple[float, float] = span((8, 75), 1, 90)
    golden_elevation_deg: tuple[float, float] = span((1.5, 9), 0.5, 20)
    moon_elevation_deg: tuple[float, float] = span((12, 70), 1, 90)
    turbidity: tuple[float, float] = span((2, 6), 1, 10)
    cloud_cover: tuple[float, float] = span((0, 0.6), 0, 1)
    visibility_m: tuple[float, float] = span((6e3, 5e4), 50, 2e5)
    haze_visibility_m: tuple[float, float] = span((700, 4000), 50, 2e5)
    fog_visibility_m: tuple[float, float] = span((250, 1000), 10, 5000)
    wetness: tuple[float, float] = span((0.5, 1), 0, 1)


# Clouds after rain: from breaking up to closed.
_COVER_AFTER_RAIN = (0.35, 1.0)


def draw_light(rng: np.random.Generator, ranges: LightRanges) -> Light:
    """The light of one scene."""
    condition = ranges.conditions[rng.integers(len(ranges.conditions))]
    elevations = {"golden_hour": ranges.golden_elevation_deg, "night": ranges.moon_elevation_deg}
    low, high = np.sin(np.radians(elevations.get(condition, ranges.sun_elevation_deg)))
    air = {"haze": ranges.haze_visibility_m, "fog": ranges.fog_visibility_m}
    covers = {"overcast": (1, 1), "fog": (1, 1), "wet": _COVER_AFTER_RAIN}
    wetness = float(rng.uniform(*ranges.wetness))
    return Light(
        condition=condition,
        sun_azimuth_deg=float(rng.uniform(0, 360)),
        sun_elevation_deg=float(np.degrees(np.arcsin(rng.uniform(low, high)))),
        turbidity=float(rng.uniform(*ranges.turbidity)),
        visibility_m=float(np.exp(rng.uniform(*np.log(air.get(condition, ranges.visibility_m))))),
        cloud_cover=float(rng.uniform(*covers.get(condition, ranges.cloud_cover))),
        cloud_seed=int(rng.integers(2**32)),
        wetness=wetness if condition == "wet" else 0.0,
        lamps_on=condition == "night",
    )
