"""The lie of a coast: where the shoreline runs, and how the land rises from it.

Local frame: s along the shore and t inland [m], the sea at negative t; `Shore.yaw_rad` turns it
into the world's x, y about the origin. Everything that depends on s alone is a table every metre.
"""

import dataclasses

import numpy as np
from scipy import ndimage

from synthdepth.maps.materials.textures import fractal_noise

REACH_M = 9000.0  # the tables end here on both sides
HEADLAND_FROM_M = 800.0  # the great headlands lie beyond, out of the flights' way
BED_M = 9.0  # the sea's bed levels out at this depth
MAX_SHORE_SLOPE = 0.75  # of the shoreline against s
# Cliff profile: height over run, a talus foot, a steep face and a rounded brow.
_PROFILE_RUN = np.array([0.0, 0.16, 0.34, 0.62, 0.8, 0.9, 1.0])
_PROFILE_RISE = np.array([0.0, 0.05, 0.22, 0.72, 0.93, 0.985, 1.0])


def smooth(x, low: float, high: float):
    """0 up to `low`, 1 from `high`, a smooth cubic between."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)


def cliff_rise(run) -> np.ndarray:
    """Height over a cliff's height at a place `run` (0 foot, 1 brow) of its profile."""
    return np.interp(run, _PROFILE_RUN, _PROFILE_RISE)


def cliff_run(rise) -> np.ndarray:
    """The inverse of `cliff_rise`."""
    return np.interp(rise, _PROFILE_RISE, _PROFILE_RUN)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Field:
    """Periodic noise on a square tile of unit variance.

    Attributes:
        tile: (n, n) float32.
        cell_m: distance between its samples.
    """

    tile: np.ndarray
    cell_m: float

    def at(self, s, t, order: int = 3) -> np.ndarray:
        """The noise at places s, t [m], arrays of one shape."""
        where = np.stack([np.ravel(s), np.ravel(t)]) / self.cell_m
        # B-spline weights without the prefilter smooth the tile, which ground wants.
        value = ndimage.map_coordinates(
            self.tile, where, order=order, mode="grid-wrap", prefilter=False
        )
        return value.reshape(np.shape(s))


def draw_field(
    rng: np.random.Generator, cell_m: float, wavelength_m: tuple[float, float], falloff: float
) -> Field:
    """Noise of wavelengths between two bounds [m] on a tile of 256 cells."""
    span = 256 * cell_m
    cycles = (span / wavelength_m[1], span / wavelength_m[0])
    return Field(tile=fractal_noise(rng, (256, 256), cycles, falloff), cell_m=cell_m)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Shore:
    """A coast; tables are (n,) float64 over s from -`REACH_M` to `REACH_M`.

    Attributes:
        yaw_rad: of the direction along the shore in the world.
        line_m: t of the mean waterline.
        stretch: metres of t per metre away from the shoreline, sqrt(1 + slope**2).
        beach_m: width of the beach, to the foot of cliff or dune.
        cliff_m: height of the cliff, or of the bank.
        run_m: how far the cliff's brow lies behind its foot.
        rockiness: 0 dunes, 1 cliffs.
        swash_m: how far up the beach the waves' last film of water reaches.
        face_slope: of the beach at the waterline.
        berm_m: height that the face rises to.
        dune_m: height of the dunes.
        rise: slope of the land behind.
        hill_m: height of the far hills.
        wave_m: significant height of the waves that made it.
        broad, fine, ridges, far, woods: noise of the land at several scales.
    """

    yaw_rad: float
    line_m: np.ndarray
    stretch: np.ndarray
    beach_m: np.ndarray
    cliff_m: np.ndarray
    run_m: np.ndarray
    rockiness: np.ndarray
    swash_m: np.ndarray
    face_slope: float
    berm_m: float
    dune_m: float
    rise: float
    hill_m: float
    wave_m: float
    broad: Field
    fine: Field
    ridges: Field
    far: Field
    woods: Field

    def look_up(self, table: str, s) -> np.ndarray:
        """A table's values at s [m]."""
        x = np.clip(np.asarray(s, np.float64) + REACH_M, 0, 2 * REACH_M - 1e-6)
        low = x.astype(np.int64)
        values = getattr(self, table)
        return values[low] + (x - low) * (values[low + 1] - values[low])

    def away_m(self, s, t) -> np.ndarray:
        """Distance inland from the shoreline [m], negative at sea."""
        return (t - self.look_up("line_m", s)) / self.look_up("stretch", s)

    def to_world(self, s, t) -> np.ndarray:
        """(..., 2) world x, y of local places."""
        c, z = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return np.stack([c * s - z * t, z * s + c * t], -1)

    def to_local(self, xy) -> tuple[np.ndarray, np.ndarray]:
        """Local s and t of world places (..., 2)."""
        xy = np.asarray(xy, np.float64)
        c, z = np.cos(self.yaw_rad), np.sin(self.yaw_rad)
        return c * xy[..., 0] + z * xy[..., 1], c * xy[..., 1] - z * xy[..., 0]

    def natural_m(self, s, t) -> np.ndarray:
        """Height of the untouched ground or sea bed [m] at local places of one shape."""
        d = self.away_m(s, t)
        beach, run = self.look_up("beach_m", s), self.look_up("run_m", s)
        cliff, rocky = self.look_up("cliff_m", s), self.look_up("rockiness", s)
        m, berm = self.face_slope, self.berm_m
        behind = np.maximum(d - beach - run, 0.0)  # distance behind the brow

        bed = -BED_M * np.tanh(m * np.maximum(-d, 0.0) / BED_M)
        face = berm * (1 - np.exp(-m * np.maximum(d, 0.0) / berm))
        z = bed + face + 0.01 * np.maximum(np.minimum(d, beach + run) - 12.0, 0.0)
        z += cliff * cliff_rise(np.clip((d - beach) / run, 0.0, 1.0))

        fine, broad = self.fine.at(s, t), self.broad.at(s, t)
        ridge = 1 - np.minimum(np.abs(self.ridges.at(s, t)), 2.0)
        dunes = smooth(d - beach, -5.0, 9.0) * (1 - smooth(d - beach, 40.0, 85.0)) * (1 - rocky)
        z += self.dune_m * dunes * np.maximum(0.45 + 0.55 * ridge + 0.1 * fine, 0.05)
        z += self.rise * behind**2 / (behind + 60.0)
        z += smooth(d, -8.0, 25.0) * (0.05 + 0.13 * smooth(behind, 0.0, 60.0)) * fine
        z += 0.045 * smooth(behind, -4.0, 12.0) * self.fine.at(2.7 * s, 2.7 * t)
        z += (0.4 + 4.5 * smooth(behind, 30.0, 420.0)) * smooth(behind, 0.0, 50.0) * (broad + 0.6)

        reach = np.hypot(s, t)
        distant = reach > 450.0
        if distant.any():
            s, t, reach, inland = s[distant], t[distant], reach[distant], behind[distant]
            crest = 1 - np.minimum(np.hypot(self.far.at(s, t), 0.3), 1.6) / 1.6
            hills = self.hill_m * (0.25 + 0.75 * crest**1.5) * smooth(inland, 120.0, 900.0)
            rim = 110.0 * smooth(reach, 3500.0, 7000.0) * smooth(inland, 200.0, 1200.0)
            z[distant] += hills * smooth(reach, 450.0, 2400.0) + rim
        return z


def _along(
    rng: np.random.Generator, wavelength_m: tuple[float, float], falloff: float
) -> np.ndarray:
    """Noise along the shore of unit variance, a value every metre."""
    n = int(2 * REACH_M) + 1
    wavelength = 1 / np.maximum(np.fft.rfftfreq(n), 1e-9)
    band = (wavelength > wavelength_m[0]) & (wavelength < wavelength_m[1])
    amplitude = np.where(band, np.minimum(wavelength, 1e6) ** (falloff + 0.5), 0.0)
    noise = np.fft.irfft(np.fft.rfft(rng.standard_normal(n)) * amplitude, n)
    return noise / noise.std()


def _headlands(rng: np.random.Generator, s: np.ndarray) -> np.ndarray:
    """How far the great headlands reach out to sea on both sides [m]."""
    reach = np.zeros_like(s)
    for side in (-1, 1):
        for first in np.cumsum(rng.uniform(1100, 2100, 3)):
            middle = side * (first + rng.uniform(0, 200))
            width, length = rng.uniform(190, 420), rng.uniform(250, 900) * np.sqrt(first / 1500)
            reach = np.maximum(reach, length * np.exp(-(((s - middle) / width) ** 2)))
    return reach * smooth(np.abs(s), 0.6 * HEADLAND_FROM_M, 1.3 * HEADLAND_FROM_M)


def _swash(rng: np.random.Generator, wave_height_m: float, face_slope: float) -> np.ndarray:
    """Lobes of spent waves on the beach, sharper where two of them meet."""
    lobes = np.abs(_along(rng, (14, 60), 0.6)) + 0.3 * np.abs(_along(rng, (5, 16), 0.5))
    reach = np.clip(0.28 * wave_height_m / face_slope, 1.6, 6.0)
    return reach * (0.75 + 0.35 * (1.2 - np.minimum(lobes, 2.4)))


def draw_shore(
    rng: np.random.Generator,
    *,
    flight_area_m: float,
    sea_share: float,
    bay_m: float,
    beach_width_m: float,
    cliff_height_m: float,
    cliff_share: float,
    dune_height_m: float,
    face_slope: float,
    wave_height_m: float,
) -> Shore:
    """A coast of some character; the sea takes `sea_share` of the flights' square.

    Args:
        rng: of all shapes.
        flight_area_m: side of that square.
        sea_share: 0 to 1.
        bay_m: amplitude of bays and headlands.
        beach_width_m: mean width.
        cliff_height_m: of the highest cliffs near the flights.
        cliff_share: share of the shore that has them.
        dune_height_m: of the dunes elsewhere.
        face_slope: of the beach at the waterline.
        wave_height_m: significant height of the waves offshore.
    """
    s = np.arange(-REACH_M, REACH_M + 0.5)
    near = np.abs(s) < 400.0
    line = bay_m * _along(rng, (220, 1400), 1.2) + 1.6 * _along(rng, (30, 160), 1.0)
    line *= min(1.0, MAX_SHORE_SLOPE / np.abs(np.gradient(line))[near].max())
    great = _headlands(rng, s)

    # Rock stands where the coast juts out.
    jut = -(line - line[near].mean()) / (line[near].std() + 1e-6)
    firm = _along(rng, (160, 900), 0.8) + 0.7 * jut
    threshold = np.quantile(firm[near], 1 - np.clip(cliff_share, 0.0, 1.0))
    rocky = smooth(firm, threshold - 0.3, threshold + 0.35) if cliff_share > 0 else 0 * firm
    rocky = np.maximum(rocky, smooth(great, 60.0, 250.0))
    cliff = (1 + 0.22 * _along(rng, (50, 250), 0.8)) * np.maximum(cliff_height_m, 0.0)
    cliff = np.maximum(cliff, 55.0 * smooth(great, 60.0, 300.0)) * rocky**1.3
    cliff = np.maximum(cliff, 0.0) + rng.uniform(0.3, 1.2)
    beach = beach_width_m * np.exp(0.28 * _along(rng, (70, 400), 0.8)) * (1 - 0.72 * rocky)
    beach = np.maximum(beach, 7.0) + 2.6 * rocky * np.abs(_along(rng, (9, 70), 0.7))

    yaw = rng.choice([0.0, 0.5, 1.0, 1.5]) * np.pi + rng.uniform(-0.3, 0.3)
    # The shoreline's place decides how much of the square is sea.
    grid = np.linspace(-0.5, 0.5, 81) * flight_area_m
    x, y = np.meshgrid(grid, grid)
    c, z = np.cos(yaw), np.sin(yaw)
    along_m, inland_m = c * x + z * y, c * y - z * x
    offset = np.quantile(inland_m - np.interp(along_m, s, line), sea_share)
    line = line + offset - great
    # Beyond the near mesh cells are coarse: cliffs lean back there, or they would show as spikes.
    lean = 1 + 0.0022 * np.maximum(np.abs(s) - 300.0, 0.0)
    return Shore(
        yaw_rad=float(yaw),
        line_m=line,
        stretch=np.sqrt(1 + ndimage.gaussian_filter1d(np.gradient(line), 6.0) ** 2),
        beach_m=beach,
        cliff_m=cliff,
        run_m=(3.0 + np.minimum(0.42 * cliff, 3.0 + 0.26 * cliff) + 9.0 * (1 - rocky)) * lean,
        rockiness=rocky,
        swash_m=_swash(rng, wave_height_m, face_slope),
        face_slope=face_slope,
        berm_m=float(rng.uniform(1.3, 2.1)),
        dune_m=dune_height_m,
        rise=float(rng.uniform(0.015, 0.06)),
        hill_m=float(rng.uniform(130, 240)),
        wave_m=wave_height_m,
        broad=draw_field(rng, 6.0, (60, 500), 1.0),
        fine=draw_field(rng, 1.6, (7, 60), 0.6),
        ridges=draw_field(rng, 2.0, (22, 120), 0.6),
        far=draw_field(rng, 60.0, (700, 3500), 1.2),
        woods=draw_field(rng, 3.0, (36, 260), 0.6),
    )
