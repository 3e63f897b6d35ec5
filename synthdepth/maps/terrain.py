"""The lie of the land: a gently rolling town site, fields around it and hills on the horizon."""

import dataclasses

import numpy as np
from scipy import ndimage

from synthdepth.maps.geometry import Geometry, Model, cross, geometry, join

HILL_CELL_M = 100.0
HILL_FOOT_M = (850.0, 2300.0)  # distances between which the hills take over from the plain
RIM_M = (2600.0, 4600.0)  # distances between which the last range rises
EDGE_M = 6000.0  # where the modelled land ends
MAX_CURVATURE_PER_M = 1.8e-4  # a 15.6 m chord then stays within 6 mm of the surface


def _smoothstep(x: np.ndarray, low: float, high: float) -> np.ndarray:
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3 - 2 * t)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Terrain:
    """Heights of the ground: a sum of waves on the map, and hills beyond it.

    Attributes:
        half_size_m: half the side of the map's square, which is centred on the origin.
        wave_vector_rad_per_m: (k, 2).
        amplitude_m: (k,).
        phase_rad: (k,).
        offset_m: added to the waves, so that the map's mean height is 0.
        hill_grid_m: (n, n) float64, heights of the hills every `HILL_CELL_M`, centred on the map.
        rim_m: height that the last range reaches everywhere, so that no view ends in a void.
    """

    half_size_m: float
    wave_vector_rad_per_m: np.ndarray
    amplitude_m: np.ndarray
    phase_rad: np.ndarray
    offset_m: float
    hill_grid_m: np.ndarray
    rim_m: float

    def height_m(self, xy: np.ndarray) -> np.ndarray:
        """Height of lawns and pavements [m] at points (n, 2) [m]: (n,) float64."""
        xy = np.asarray(xy, np.float64).reshape(-1, 2)
        angle = xy @ self.wave_vector_rad_per_m.T + self.phase_rad
        height = np.sin(angle) @ self.amplitude_m + self.offset_m
        far = np.hypot(xy[:, 0], xy[:, 1])
        beyond = far > min(HILL_FOOT_M)
        if beyond.any():
            r = far[beyond]
            cell = xy[beyond] / HILL_CELL_M + (len(self.hill_grid_m) - 1) / 2
            # B-spline weights without the prefilter smooth the grid, which hills want.
            hill = ndimage.map_coordinates(
                self.hill_grid_m, cell.T, order=3, mode="grid-wrap", prefilter=False
            )
            rise = hill * _smoothstep(r, *HILL_FOOT_M) + self.rim_m * _smoothstep(r, *RIM_M)
            height[beyond] += rise
        return height


def _noise(rng: np.random.Generator, n: int, slope: float, lowest: float) -> np.ndarray:
    """Periodic noise (n, n) of amplitude f**-slope above `lowest` cycles, unit variance."""
    f = np.hypot(np.fft.fftfreq(n)[:, None], np.fft.fftfreq(n)[None, :]) * n
    amplitude = np.where(f >= lowest, np.maximum(f, 1.0) ** -slope, 0.0)
    field = np.fft.ifft2(np.fft.fft2(rng.standard_normal((n, n))) * amplitude).real
    return field / field.std()


def draw_terrain(
    rng: np.random.Generator,
    *,
    size_m: float = 1000.0,
    slope_range: tuple[float, float] = (0.012, 0.042),
    hill_height_range_m: tuple[float, float] = (120.0, 230.0),
) -> Terrain:
    """A terrain whose steepest slope on the map lies within `slope_range`, hills around it."""
    k = 6
    direction = rng.uniform(0, 2 * np.pi, k)
    wavelength = rng.uniform(700, 1900, k)
    wave_vector = (2 * np.pi / wavelength)[:, None] * np.stack(
        [np.cos(direction), np.sin(direction)], 1
    )
    amplitude = rng.uniform(0.4, 1.0, k) * (wavelength / 1000) ** 2
    phase = rng.uniform(0, 2 * np.pi, k)
    axis = np.linspace(-size_m / 2, size_m / 2, 41)
    grid = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    angle = grid @ wave_vector.T + phase
    slope = np.linalg.norm((np.cos(angle) * amplitude) @ wave_vector, axis=1).max()
    outer = wave_vector[:, :, None] * wave_vector[:, None, :]
    hessian = np.einsum("nk,kij->nij", np.sin(angle) * amplitude, outer)
    curvature = np.abs(np.linalg.eigvalsh(hessian)).max()
    amplitude *= min(rng.uniform(*slope_range) / slope, MAX_CURVATURE_PER_M / curvature)
    n = int(2 * EDGE_M / HILL_CELL_M) + 8
    # Ridged noise: crests where a smooth field changes sign.
    ridge = 1 - np.minimum(np.hypot(_noise(rng, n, 2.1, 4), 0.3), 1.6) / 1.6
    relief = 0.8 * ridge**1.6 + 0.25 * (_noise(rng, n, 1.9, 6) / 3 + 0.5)
    return Terrain(
        half_size_m=size_m / 2,
        wave_vector_rad_per_m=wave_vector,
        amplitude_m=amplitude,
        phase_rad=phase,
        offset_m=-float((np.sin(angle) @ amplitude).mean()),
        hill_grid_m=np.maximum(relief, 0.0) * rng.uniform(*hill_height_range_m),
        rim_m=float(rng.uniform(100, 135)),
    )


def _ring_points(terrain: Terrain, edge_step_m: float, rings: int) -> np.ndarray:
    """(rings, n, 2) points: the map's square, and rings that grow from it into a circle."""
    h = terrain.half_size_m
    n = round(2 * h / edge_step_m)
    s = -h + edge_step_m * np.arange(n)
    side = np.full(n, h)
    square = np.concatenate(
        [
            np.stack([s, -side], 1),
            np.stack([side, s], 1),
            np.stack([-s, side], 1),
            np.stack([-side, -s], 1),
        ]
    )
    reach = np.geomspace(h, EDGE_M, rings)
    angle = np.arctan2(square[:, 1], square[:, 0])
    circle = h * np.stack([np.cos(angle), np.sin(angle)], 1)
    blend = _smoothstep(reach, h, 3 * h)[:, None, None]
    return ((1 - blend) * square + blend * circle) * (reach / h)[:, None, None]


def outskirts(terrain: Terrain, *, edge_step_m: float = 15.625, rings: int = 56) -> Model:
    """The land from the map's edge to the horizon: fields, then wooded hills.

    The innermost vertices lie on the map's edge every `edge_step_m`, where the map's own ground
    has vertices too.
    """
    xy = _ring_points(terrain, edge_step_m, rings)
    n = xy.shape[1]
    flat = xy.reshape(-1, 2)
    far = np.hypot(flat[:, 0], flat[:, 1])
    vertices = np.column_stack([flat, terrain.height_m(flat)])
    ring, step = np.meshgrid(np.arange(rings - 1), np.arange(n), indexing="ij")
    i, j = (ring * n + step).ravel(), (ring * n + (step + 1) % n).ravel()
    faces = np.concatenate([np.stack([i, i + n, j + n], 1), np.stack([i, j + n, j], 1)])

    # Fields: a tilted, wavy checkerboard of crops, dry and lush.
    cell = np.floor(flat @ np.array([[0.86, -0.5], [0.5, 0.86]]) / [190.0, 130.0]).astype(np.int64)
    crop = ((cell[:, 0] * 73856093) ^ (cell[:, 1] * 19349663)) % 7
    dry = crop / 6.0
    near_tint = np.stack([0.9 + 0.28 * dry, 0.96 + 0.14 * dry, 0.9 + 0.1 * dry], 1)
    relief = vertices[:, 2] / (np.abs(vertices[:, 2]).max() + 1e-9)
    far_tint = np.stack([1.0 - 0.12 * relief, 1.0 - 0.06 * relief, 1.0 + 0.06 * relief], 1)
    tint = np.where(far[:, None] < 1150, near_tint, far_tint)

    centre = flat[faces].mean(axis=1)
    x, y = centre.T / 130
    # The woods' edge wanders in and out.
    woods = 1000 + 130 * (np.sin(x + 2 * np.sin(y / 3)) + np.sin(1.3 * y + 2 * np.sin(x / 2)))
    wooded = np.hypot(*centre.T) > woods
    # Slopes turned away from the map share no vertices with those that face it: a normal averaged
    # across a crest would point away from the viewer of its near side, who would see it black.
    corner = vertices[faces]
    normal = cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])
    hidden = np.einsum("ni,ni->n", corner.mean(axis=1) - [0, 0, 40.0], normal) > 0
    return {
        ("grass", "ground"): _part(vertices, faces[~wooded], tint),
        ("hill", "hill"): join(
            [_part(vertices, faces[wooded & side], tint) for side in (hidden, ~hidden)]
        ),
    }


def _part(vertices: np.ndarray, faces: np.ndarray, tint: np.ndarray) -> Geometry:
    used, corner = np.unique(faces, return_inverse=True)
    return geometry(vertices[used], corner.reshape(-1, 3), tint=tint[used])


def tree_line(rng: np.random.Generator, terrain: Terrain, *, count: int = 1500) -> np.ndarray:
    """Places (k, 3) [m] for far trees, k <= count: along the map's edge, in hedgerows and woods.

    They lie outside the map's square, in clumps, out to the lower slopes of the hills.
    """
    h = terrain.half_size_m
    edge = count * 45 // 100
    side = rng.integers(0, 4, edge)
    # Clumped: a periodic density along the edge, thinned by rejection of the gaps.
    along = rng.uniform(-h - 40, h + 40, edge)
    gap = np.sin(along / 37 + 2 * side) + np.sin(along / 91 + side) < -1.0
    out = h + 8 + rng.gamma(1.6, 16, edge)
    c, s = np.array([0, 1, 0, -1])[side], np.array([-1, 0, 1, 0])[side]
    belt = np.stack([c * out - s * along, s * out + c * along], 1)[~gap]

    clumps = max(count // 24, 1)
    r = rng.uniform(h * 1.55, 1700, clumps)
    a = rng.uniform(0, 2 * np.pi, clumps)
    heading, length = rng.uniform(0, np.pi, clumps), rng.uniform(15, 110, clumps)
    member = rng.integers(0, clumps, count - edge)
    t = rng.uniform(-1, 1, len(member)) * length[member]
    wood = np.stack([r * np.cos(a), r * np.sin(a)], 1)[member]
    wood += t[:, None] * np.stack([np.cos(heading), np.sin(heading)], 1)[member]
    wood += rng.normal(0, 5, wood.shape)
    wood = wood[np.abs(wood).max(axis=1) > h + 5]
    xy = np.concatenate([belt, wood])
    return np.column_stack([xy, terrain.height_m(xy)])
