"""What a real camera adds to a picture: wrong exposure and colour, vignetting, noise, blur, JPEG.

After the photon transfer model (EMVA 1288): a pixel collects electrons in proportion to the light,
with Poisson noise, and reading them adds Gaussian noise. A camera's picture style then deepens
contrast and colour. Ground truth is never touched.
"""

import dataclasses
import io

import numpy as np
from PIL import Image

from synthdepth.config import Config, choice, span
from synthdepth.render.colour import LUMINANCE, linear_to_srgb, tone_map


@dataclasses.dataclass(frozen=True, kw_only=True)
class SensorRanges(Config):
    """What the sensor of a flight is drawn from.

    Attributes:
        model: "drawn", or "ideal" for a camera without any fault.
        exposure_ev: error of the exposure [stops].
        white_balance: error of the red and the blue gain, as a share.
        vignetting: share of the light that the picture's corners lose.
        full_well_electrons: electrons of a white pixel at base gain, drawn log-uniformly. A
            stored pixel sums what several pixels of a larger sensor collect.
        night_gain: how many times fewer there are at night, drawn log-uniformly.
        read_noise_electrons: standard deviation.
        shutter_s: exposure time by day, drawn log-uniformly.
        night_shutter_s: likewise at night.
        contrast: how much steeper than sRGB the picture style's curve is at middle grey.
        saturation: the picture style's factor on the distance of colours from their grey.
        jpeg_quality: of the compression before storing, 100 being the best.
    """

    model: str = choice("drawn", ("drawn", "ideal"))
    exposure_ev: tuple[float, float] = span((-0.5, 0.5), -4, 4)
    white_balance: tuple[float, float] = span((-0.06, 0.06), -0.5, 0.5)
    vignetting: tuple[float, float] = span((0.0, 0.35), 0, 0.9)
    full_well_electrons: tuple[float, float] = span((10000, 80000), 50, 1e6)
    night_gain: tuple[float, float] = span((4, 24), 1, 1000)
    read_noise_electrons: tuple[float, float] = span((1.5, 5), 0, 100)
    shutter_s: tuple[float, float] = span((0.0005, 0.008), 0, 0.1)
    night_shutter_s: tuple[float, float] = span((0.008, 0.02), 0, 0.1)
    contrast: tuple[float, float] = span((0.0, 0.4), 0, 0.5)
    saturation: tuple[float, float] = span((0.95, 1.3), 0, 2)
    jpeg_quality: tuple[float, float] = span((75, 98), 10, 100)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sensor:
    """The camera of one flight.

    Attributes:
        gain: (3,) multiplier of linear red, green and blue.
        vignetting: share of the light that the corners lose.
        electrons: of a pixel at linear value 1.
        read_noise: [electrons].
        shutter_s: exposure time.
        contrast: of the picture style, 0 for none.
        saturation: of the picture style, 1 for none.
        jpeg_quality: of the compression; None stores the picture as it is.
    """

    gain: np.ndarray
    vignetting: float
    electrons: float
    read_noise: float
    shutter_s: float
    contrast: float
    saturation: float
    jpeg_quality: int | None


IDEAL = Sensor(
    gain=np.ones(3), vignetting=0.0, electrons=np.inf, read_noise=0.0, shutter_s=0.0,
    contrast=0.0, saturation=1.0, jpeg_quality=None,
)  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Motion:
    """How the camera moves while the shutter is open.

    Attributes:
        moved_m: (3,) how far it goes [m], world axes.
        turned_rad: (3,) and turns, as a rotation vector [rad], world axes.
    """

    moved_m: np.ndarray
    turned_rad: np.ndarray


def _log_uniform(rng: np.random.Generator, span_: tuple[float, float]) -> float:
    low, high = span_
    return low if low in (0.0, high) else float(np.exp(rng.uniform(np.log(low), np.log(high))))


def draw_sensor(rng: np.random.Generator, ranges: SensorRanges, *, at_night: bool) -> Sensor:
    """The sensor of one flight."""
    if ranges.model == "ideal":
        return IDEAL
    red, blue = 1 + rng.uniform(*ranges.white_balance, 2)
    exposure = 2.0 ** rng.uniform(*ranges.exposure_ev)
    electrons = _log_uniform(rng, ranges.full_well_electrons)
    night_gain = _log_uniform(rng, ranges.night_gain)
    return Sensor(
        gain=exposure * np.array([red, 1.0, blue]),
        vignetting=float(rng.uniform(*ranges.vignetting)),
        electrons=electrons / night_gain if at_night else electrons,
        read_noise=float(rng.uniform(*ranges.read_noise_electrons)),
        shutter_s=_log_uniform(rng, ranges.night_shutter_s if at_night else ranges.shutter_s),
        jpeg_quality=round(float(rng.uniform(*ranges.jpeg_quality))),
        contrast=float(rng.uniform(*ranges.contrast)),
        saturation=float(rng.uniform(*ranges.saturation)),
    )


def _styled(linear: np.ndarray, sensor: Sensor) -> np.ndarray:
    """Display-linear values as sRGB-encoded ones in [0, 1], in the camera's picture style."""
    if sensor.saturation != 1:
        grey = (linear @ LUMINANCE.astype(np.float32))[..., None]
        linear = np.clip(grey + np.float32(sensor.saturation) * (linear - grey), 0, 1)
    x = linear_to_srgb(linear)
    # Keeps black, middle grey and white; steeper by `contrast` in the middle, never falling.
    return x + np.float32(4 * sensor.contrast) * x * (1 - x) * (x - np.float32(0.5))


def expose(
    rng: np.random.Generator, radiance: np.ndarray, exposure: float, sensor: Sensor
) -> np.ndarray:
    """The picture that a sensor takes.

    Args:
        rng: the frame's noise.
        radiance: (H, W, 3) float32.
        exposure: factor from radiance to linear values, of which 1 is white.
        sensor: the camera.

    Returns:
        (H, W, 3) uint8 sRGB.
    """
    height, width = radiance.shape[:2]
    y, x = np.ogrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    # Falls with the square of the distance from the middle, as cos^4 does to first order.
    falloff = 1 - sensor.vignetting * (x * x + y * y) / 2
    factor = (falloff[..., None] * (exposure * sensor.gain)).astype(np.float32)
    linear = np.maximum(radiance, 0) * factor
    if np.isfinite(sensor.electrons):
        # Thousands of photons: their Poisson noise is Gaussian.
        variance = linear / sensor.electrons + (sensor.read_noise / sensor.electrons) ** 2
        linear += np.sqrt(variance) * rng.standard_normal(linear.shape, np.float32)
    image = _styled(tone_map(linear, 1.0), sensor)
    image = (image * 255 + 0.5).astype(np.uint8)
    if sensor.jpeg_quality is None:
        return image
    file = io.BytesIO()
    Image.fromarray(image).save(file, "JPEG", quality=sensor.jpeg_quality)
    return np.array(Image.open(file))
