"""Variety for training that leaves geometry true: light, colour and noise, the same on both frames.

Depth, flow and cameras stay as they are. What a camera changes between frames, its noise, is drawn
for each; exposure, white balance and contrast are one camera's, and the same for both.
"""

import dataclasses

import cv2
import numpy as np

from synthdepth.config import Config, number
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.transforms import SharedEpoch
from synthdepth.seeding import lane


@dataclasses.dataclass(frozen=True, kw_only=True)
class AugmentationConfig(Config):
    """What is varied, by up to how much; 0 leaves it alone.

    Attributes:
        flip: share of the pairs that are mirrored, world and all.
        exposure_stops: light is up to so many powers of 2 more or less.
        white_balance: red and blue are up to so many powers of 2 more or less.
        contrast: about middle grey, in powers of 2.
        noise: standard deviation of Gaussian noise in steps of 8 bits, drawn up to this.
    """

    flip: float = number(0.5, 0.0, 1.0)
    exposure_stops: float = number(0.0, 0.0, 4.0)
    white_balance: float = number(0.0, 0.0, 2.0)
    contrast: float = number(0.0, 0.0, 2.0)
    noise: float = number(0.0, 0.0, 64.0)

    @property
    def changes_pictures(self) -> bool:
        """Whether anything but the flip is varied."""
        return any((self.exposure_stops, self.white_balance, self.contrast, self.noise))


class JitterColours:
    """Changes light, colour and noise of a sample; comes before what makes the input.

    What a pair gets depends on the seed, its key and the epoch alone.

    Args:
        config: by how much.
        seed: of the draw.
    """

    def __init__(self, config: AugmentationConfig, *, seed: int):
        self.config, self._seed, self._epoch = config, seed, SharedEpoch()

    def set_epoch(self, epoch: int) -> None:
        """Say which pass comes next; the datasets' own `set_epoch` calls this."""
        self._epoch.set(epoch)

    def __call__(self, sample: Sample) -> Sample:
        """The sample with other frames."""
        rng = lane(self._seed, "colours", sample.key, self._epoch.get())
        table, noise = self._drawn(rng)
        frames = {"rgb": sample.rgb, "prev": sample.prev}
        return dataclasses.replace(
            sample,
            **{
                name: _noisy(rng, cv2.LUT(frame, table), noise)
                for name, frame in frames.items()
                if frame is not None
            },
        )

    def _drawn(self, rng: np.random.Generator) -> tuple[np.ndarray, float]:
        """Where each of 256 values goes in each channel, (1, 256, 3) uint8, and the noise."""
        stops, red, blue, contrast, noise = rng.uniform([-1, -1, -1, -1, 0], 1) * [
            self.config.exposure_stops,
            self.config.white_balance,
            self.config.white_balance,
            self.config.contrast,
            self.config.noise,
        ]
        gain = 2.0 ** (stops + np.array([red, 0, blue]))
        # sRGB is near enough a power of 2.2 of light.
        value = (np.arange(256)[:, None] / 255) * gain ** (1 / 2.2)
        value = 0.5 + (value - 0.5) * 2.0**contrast
        return np.rint(255 * np.clip(value, 0, 1)).astype(np.uint8)[None], noise


def _noisy(rng: np.random.Generator, frame: np.ndarray, std: float) -> np.ndarray:
    if std == 0:
        return frame
    noise = rng.standard_normal(frame.shape, np.float32) * np.float32(std)
    return np.rint(np.clip(frame + noise, 0, 255)).astype(np.uint8)
