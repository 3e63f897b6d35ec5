"""Waves: a wind sea from its spectrum, and breakers that run up the beach."""

import dataclasses

import numpy as np
from scipy import ndimage

from synthdepth.maps.coast.shore import Shore, smooth

CELLS = 320
CELL_M = 0.5
# JONSWAP's peak enhancement (Hasselmann et al. 1973).
_GAMMA = 3.3
_CHOP = 0.8


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sea:
    """Waves of a scene.

    Attributes:
        height_m: significant height offshore.
        wavelength_m: of the peak.
        tile: (320, 320, 4) periodic every 160 m: rise, shift along s and t [m], and how much the
            surface is squeezed (whitecaps are where it is most).
        swell: (320, 320, 4), the same without waves below 14 m, for coarse cells.
        caps: squeeze from which the crests are white.
        body: (3,) linear reflectance of deep water.
        shallows: (3,) of a metre or two of water over the bed.
        breaker_m: distance between breakers.
        phase: of the breakers.
    """

    height_m: float
    wavelength_m: float
    tile: np.ndarray
    swell: np.ndarray
    caps: float
    body: tuple[float, float, float]
    shallows: tuple[float, float, float]
    breaker_m: float
    phase: float


def _tile(noise: np.ndarray, wavelength_m: float, heading_rad: float, shortest_m: float):
    """(n, n, 4) rise, shifts and squeeze of unit significant height."""
    k1 = 2 * np.pi * np.fft.fftfreq(CELLS, CELL_M)
    ks, kt = k1[:, None], k1[None, :]
    k = np.hypot(ks, kt)
    k[0, 0] = 1.0
    peak = 2 * np.pi / wavelength_m
    # In wavenumber: k**-4 exp(-5/4 (kp/k)**2) gamma**r spread over directions (cos**4).
    ratio = np.sqrt(k / peak)
    sigma = np.where(ratio <= 1, 0.07, 0.09)
    enhanced = _GAMMA ** np.exp(-((ratio - 1) ** 2) / (2 * sigma**2))
    turn = np.arctan2(kt, ks) - heading_rad
    spread = np.maximum(np.cos(turn), 0.0) ** 4 + 0.03
    power = k**-4.0 * np.exp(-1.25 * (peak / k) ** 2) * enhanced * spread
    power[0, 0] = 0.0
    scale = 4 * np.abs(np.fft.ifft2(np.sqrt(power) * noise).real).std() / 0.6
    power = np.where(2 * np.pi / k < shortest_m, 0.0, power)
    spectrum = np.sqrt(power) * noise / scale
    rise = np.fft.ifft2(spectrum).real
    shift_s = np.fft.ifft2(-1j * ks / k * spectrum).real
    shift_t = np.fft.ifft2(-1j * kt / k * spectrum).real
    squeeze = np.fft.ifft2(-k * spectrum).real
    return np.stack([rise, shift_s, shift_t, squeeze], -1).astype(np.float32)


# Body and shallows of seas from green and turbid to clear and blue; linear reflectances.
_WATERS = (
    ((0.018, 0.040, 0.040), (0.10, 0.145, 0.115)),
    ((0.012, 0.034, 0.050), (0.075, 0.17, 0.165)),
    ((0.010, 0.030, 0.055), (0.08, 0.22, 0.22)),
    ((0.022, 0.038, 0.034), (0.115, 0.125, 0.09)),
    ((0.016, 0.030, 0.036), (0.07, 0.105, 0.09)),
)


def draw_sea(rng: np.random.Generator, height_m: float) -> Sea:
    """A wind sea of significant height `height_m`, running towards the shore."""
    # Fetch-limited seas: 13, 30, 61 m for 0.36, 0.8, 1.6 m.
    wavelength = 37.0 * height_m + 2.0
    noise = np.fft.fft2(rng.standard_normal((CELLS, CELLS)))
    heading = np.pi / 2 + rng.uniform(-0.7, 0.7)
    tile = height_m * _tile(noise, wavelength, heading, 1.7)
    body, shallows = _WATERS[rng.integers(len(_WATERS))]
    light = rng.uniform(0.85, 1.2)
    # Cover grows steeply with the wind; a height of 0.8 m goes with about 7 m/s.
    cover = np.clip(0.004 * (height_m / 0.8) ** 2.2, 2e-4, 0.009)
    return Sea(
        height_m=height_m,
        wavelength_m=wavelength,
        tile=tile,
        swell=height_m * _tile(noise, wavelength, heading, 14.0),
        caps=float(np.quantile(tile[..., 3], cover)),
        body=tuple(light * np.array(body)),
        shallows=tuple(light * np.array(shallows)),
        breaker_m=float(rng.uniform(9, 15) * (0.7 + 0.5 * height_m)),
        phase=float(rng.uniform(0, 6.28)),
    )


def _sampled(tile: np.ndarray, s: np.ndarray, t: np.ndarray) -> np.ndarray:
    """(..., 4) values of a tile, bilinear."""
    where = np.stack([s.ravel(), t.ravel()]) / CELL_M
    values = [
        ndimage.map_coordinates(tile[..., k], where, order=1, mode="grid-wrap", prefilter=False)
        for k in range(tile.shape[2])
    ]
    return np.stack(values, -1).reshape(*s.shape, -1)


def surface(
    sea: Sea, shore: Shore, s: np.ndarray, t: np.ndarray, *, coarse: bool
) -> tuple[np.ndarray, np.ndarray]:
    """The water at local places of one shape.

    Args:
        sea: the waves.
        shore: where they break.
        s, t: places [m].
        coarse: leave out short waves and breakers.

    Returns:
        (..., 3) shifts along s and t and rise [m], and (...) whiteness, 0 to 1.
    """
    d = shore.away_m(s, t)
    depth = shore.face_slope * np.maximum(-d, 0.0)
    open_sea = np.tanh(depth / (1.1 * sea.height_m + 0.4)) ** 0.8
    wind = _sampled(sea.swell if coarse else sea.tile, s, t)
    shift = np.stack([_CHOP * wind[..., 1], _CHOP * wind[..., 2], wind[..., 0]], -1)
    shift *= open_sea[..., None]
    gusts = shore.broad.at(s, 1.7 * t, 1)
    white = smooth(wind[..., 3], 0.6 * sea.caps, 1.25 * sea.caps) * open_sea * (gusts > -0.6)
    if coarse:
        return shift, white
    rise, foam = _breakers(sea, shore, s, t, d)
    shift[..., 2] += rise
    return shift, np.maximum(white, foam)


def _breakers(sea, shore, s, t, d) -> tuple[np.ndarray, np.ndarray]:
    """Rise [m] and whiteness of the surf at places `d` from the shoreline [m]."""
    # Waves break where H / h is about 0.7, for slopes of 1:10 to 1:40.
    first = sea.height_m / 0.7 / shore.face_slope
    warp = 1.1 * shore.ridges.at(0.45 * s, 0.3 * t) + 0.6 * shore.fine.at(0.5 * s, 0.4 * t)
    turns = d / sea.breaker_m + 0.24 * warp + sea.phase / (2 * np.pi)
    crest = np.round(turns)
    ahead = (turns - crest) * sea.breaker_m  # metres in front of the nearest crest
    # Each crest has its own segments along the shore.
    segment = shore.fine.at(0.42 * s + 37.0 * crest, 23.0 * crest, 1)
    strength = smooth(segment, -0.9, 0.5)
    zone = smooth(d, -2.6 * first - 8, -first) * smooth(-d, -0.5, 3.0)
    high = 0.62 * np.minimum(sea.height_m, 0.12 + 0.7 * shore.face_slope * np.maximum(-d, 0))
    # Steep in front, drawn out behind.
    shape = np.where(ahead > 0, np.exp(-((ahead / 0.9) ** 2)), np.exp(-((ahead / 2.6) ** 2)))
    rise = high * (0.35 + 0.65 * strength) * zone * shape
    broken = smooth(d, -1.25 * first - 3, -0.8 * first)
    front = smooth(ahead, -1.6, -0.3) * (1 - smooth(ahead, 0.7, 1.6))
    lace = shore.fine.at(2.2 * s, 1.6 * t)
    trail = (1 - smooth(-ahead, 0.5, 0.55 * sea.breaker_m)) * (ahead < 0.5)
    foam = broken * strength * (front + 0.6 * trail * (0.6 + 0.5 * lace))
    # Old foam drifts about inside the surf, and lies where the last film of water stops.
    drifting = smooth(lace + 0.6 * warp, 0.5, 1.5) * smooth(d, -1.5 * first, -0.3 * first)
    edge = shore.look_up("swash_m", s) - d
    rim = smooth(edge, -0.4, 0.1) * (1 - smooth(edge, 0.9, 1.9 + 0.7 * np.clip(lace, -1, 1)))
    foam = np.maximum(foam, 0.5 * drifting)
    # On the sand itself foam lies in one rim, not in nets over dark water.
    foam = np.where(d > -1.8, smooth(np.maximum(foam, rim), 0.45, 0.62), foam)
    return rise, np.clip(foam, 0.0, 1.0)
