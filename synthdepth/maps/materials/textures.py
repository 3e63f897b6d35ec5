"""Tiling texture fields: spectral noise, Worley cells, courses of units, and their encoding.

Every field lives on a torus: its left edge continues at its right one and its top at its bottom.
Arrays are (h, w) float32 with row 0 at the top (largest v), as `Material.texture` wants them. The
renderer has no mipmaps, so makers of materials keep the finest octave's contrast low.
"""

import functools
import typing

import numpy as np
import scipy.fft

# Reflectance that a neutral texture averages to: near white, with room above for bright grains.
NEUTRAL_MEAN = 0.8

# Linear values are looked up in steps of 1/32768, an eighth of the finest 8-bit sRGB step.
_STEPS = 32768


def texel_grid(shape: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Texel centres as fractions of the tile: u (1, w) to the right, v (h, 1) **up**, float32."""
    h, w = shape
    u = (np.arange(w, dtype=np.float32) + 0.5) / w
    v = 1 - (np.arange(h, dtype=np.float32) + 0.5) / h
    return u[None, :], v[:, None]


def fractal_noise(
    rng: np.random.Generator,
    shape: tuple[int, int],
    cycles: tuple[float, float],
    falloff: float = 0.5,
    stretch: tuple[float, float] = (1.0, 1.0),
    angle_rad: float = 0.0,
) -> np.ndarray:
    """Gaussian noise with a power-law spectrum of random phases; it tiles exactly.

    Args:
        rng: source of the phases and amplitudes.
        shape: (h, w) texels.
        cycles: lowest and highest frequency [cycles per tile]; the upper end rolls off smoothly.
        falloff: H of fBm: an octave's contrast goes as wavelength ** falloff; 0 gives each octave
            the same, large values keep the lowest alone.
        stretch: how many times longer features are along u and along v.
        angle_rad: turns the stretched axes counter-clockwise.

    Returns:
        (h, w) float32 of mean 0 and standard deviation 1, clipped at 3.5.
    """
    h, w = shape
    low, high = cycles
    # Only the band that the roll-off leaves is drawn; the rest of the spectrum is zero padding.
    reach = 2.2 * high / min(*stretch, 1.0)
    rows, columns = int(min(h // 2 - 1, reach)), int(min(w // 2, reach))
    fy = np.arange(-rows, rows + 1, dtype=np.float32)[:, None]
    fx = np.arange(columns + 1, dtype=np.float32)[None, :]
    # Image rows run against v, so a counter-clockwise turn has the sign of -fy.
    c, s = np.float32(np.cos(angle_rad)), np.float32(np.sin(angle_rad))
    squared = ((fx * c - fy * s) * stretch[0]) ** 2 + ((fx * s + fy * c) * stretch[1]) ** 2
    squared[rows, 0] = 1
    amplitude = np.exp(-squared / high**2 - 0.5 * (1 + falloff) * np.log(squared))
    amplitude[squared < 0.7 * low**2] = 0
    amplitude[rows, 0] = 0
    noise = rng.standard_normal((*amplitude.shape, 2), np.float32).view(np.complex64)[..., 0]
    noise *= amplitude
    spectrum = np.zeros((h, w // 2 + 1), np.complex64)
    spectrum[: rows + 1, : columns + 1] = noise[rows:]
    spectrum[h - rows :, : columns + 1] = noise[:rows]
    field = scipy.fft.irfft2(spectrum, s=shape, overwrite_x=True)
    field /= field.std()
    return np.clip(field, -3.5, 3.5, out=field)


class Cells(typing.NamedTuple):
    """Worley cells: all (h, w).

    Attributes:
        centre: float32 distance to the nearest feature point [cells].
        border: float32 distance to the border with the next cell [cells].
        index: int32 number of the cell, row-major.
    """

    centre: np.ndarray
    border: np.ndarray
    index: np.ndarray


def worley(
    rng: np.random.Generator,
    shape: tuple[int, int],
    cells: tuple[int, int],
    warp: float = 0.0,
    warp_cycles: tuple[float, float] | None = None,
) -> Cells:
    """Voronoi cells of one jittered point per square of a grid (Worley 1996).

    Args:
        rng: source of the points and the warp.
        shape: (h, w) texels.
        cells: (rows, columns) of the grid; unequal numbers stretch the cells.
        warp: standard deviation [cells] of noise that bends the borders.
        warp_cycles: band of that noise [cycles per tile]; by default from the cell down to a
            fifth of it.
    """
    rows, columns = (int(n) for n in cells)
    u, v = texel_grid(shape)
    x, y = np.broadcast_to(u * columns, shape), np.broadcast_to(v * rows, shape)
    if warp:
        band = warp_cycles or (max(rows, columns) * 0.7, max(rows, columns) * 5)
        x = x + np.float32(warp) * fractal_noise(rng, shape, band)
        y = y + np.float32(warp) * fractal_noise(rng, shape, band)
    jitter = 0.08 + 0.84 * rng.random((2, rows, columns), np.float32)
    cells_of_texels = Cells(
        np.empty(shape, np.float32), np.empty(shape, np.float32), np.empty(shape, np.int32)
    )
    # In bands of texel rows, whose arrays stay in the cache.
    for top in range(0, shape[0], 32):
        band = slice(top, top + 32)
        for whole, part in zip(cells_of_texels, _nearest(x[band], y[band], jitter), strict=True):
            whole[band] = part
    return cells_of_texels


# Steps to the nine neighbouring squares.
_STEP_X = np.tile(np.float32([-1, 0, 1]), 3)
_STEP_Y = np.repeat(np.float32([-1, 0, 1]), 3)


def _nearest(x: np.ndarray, y: np.ndarray, jitter: np.ndarray) -> Cells:
    """Cells of positions x, y (n, m) [squares] among points `jitter` (2, rows, columns)."""
    _, rows, columns = jitter.shape
    column, row = np.floor(x), np.floor(y)
    x, y = x - column, y - row
    # One ring of repeated squares round the grid spares the wrapping of every neighbour.
    points_x, points_y = np.pad(jitter, [(0, 0), (1, 1), (1, 1)], "wrap").reshape(2, -1)
    numbers = np.pad(np.arange(rows * columns, dtype=np.int32).reshape(rows, columns), 1, "wrap")
    stride = columns + 2
    corner = row.astype(np.intp) % rows * stride + column.astype(np.intp) % columns
    # The bits of positive floats sort as the floats do, so the four lowest of a squared distance
    # can carry, through the minima, which of the nine squares it belongs to.
    first = np.full(x.shape, np.iinfo(np.int32).max, np.int32)
    second = first.copy()
    for k in range(9):
        at = k // 3 * stride + k % 3
        px = points_x[at:].take(corner) - (x - _STEP_X[k])
        py = points_y[at:].take(corner) - (y - _STEP_Y[k])
        squared = (px * px + py * py).view(np.int32) & ~15 | k
        np.minimum(second, np.maximum(first, squared), out=second)
        np.minimum(first, squared, out=first)
    a, b = first & 15, second & 15
    at_a, at_b = (corner + k // 3 * stride + k % 3 for k in (a, b))
    ax = points_x.take(at_a) + (_STEP_X.take(a) - x)
    ay = points_y.take(at_a) + (_STEP_Y.take(a) - y)
    bx = points_x.take(at_b) + (_STEP_X.take(b) - x)
    by = points_y.take(at_b) + (_STEP_Y.take(b) - y)
    squared = ax * ax + ay * ay
    gap = np.hypot(bx - ax, by - ay)
    border = (bx * bx + by * by - squared) / np.maximum(2 * gap, np.float32(1e-6))
    return Cells(np.sqrt(squared), border, numbers.ravel().take(at_a))


class Courses(typing.NamedTuple):
    """Rows of units (bricks, boards, tabs, slabs).

    Attributes:
        row: (h, 1) int32 number of the row, from the bottom.
        index: (h, w) int32 number of the unit, row-major.
        side: (h, w) float32 distance to the unit's nearer end [columns].
        up: (h, 1) float32 height above the row's lower edge, 0 to 1 [rows].
    """

    row: np.ndarray
    index: np.ndarray
    side: np.ndarray
    up: np.ndarray


def courses(
    rng: np.random.Generator,
    shape: tuple[int, int],
    rows: int,
    columns: int,
    shift: np.ndarray | float = 0.0,
    irregular: float = 0.0,
) -> Courses:
    """A layout in rows: `rows` x `columns` units a tile.

    Args:
        rng: source of the irregular widths.
        shape: (h, w) texels.
        rows: rows a tile.
        columns: units a row.
        shift: scalar or (rows,), how far each row is shifted along u [columns].
        irregular: each joint moves to the right by up to this many columns, below 1.
    """
    u, v = texel_grid(shape)
    shift = np.broadcast_to(np.asarray(shift, np.float32), rows)[:, None]
    joint = np.float32(irregular) * rng.random((rows, columns), np.float32)
    each = np.arange(rows, dtype=np.int32)[:, None]
    # Within a row nothing depends on v: the layout is made one line a row, then spread.
    x = (u * columns - shift) % np.float32(columns)
    column = np.minimum(x.astype(np.int32), columns - 1)
    column = (column - (x - column < joint[each, column])) % np.int32(columns)
    following = (column + 1) % columns
    left = (x - column - joint[each, column]) % np.float32(columns)
    right = (following + joint[each, following] - x) % np.float32(columns)
    side = np.minimum(left, right)
    y = v * rows
    row = np.minimum(y.astype(np.int32), rows - 1)
    spread = row[:, 0]
    return Courses(row, (each * np.int32(columns) + column)[spread], side[spread], y - row)


def smoothstep(x: np.ndarray, start: float, end: float) -> np.ndarray:
    """0 up to `start`, 1 from `end`, a smooth cubic between; start > end falls instead."""
    t = (x - np.float32(start)) * np.float32(1 / (end - start))
    t = np.clip(t, 0, 1)
    return t * t * (3 - 2 * t)


def blend(base, over, weight: np.ndarray) -> np.ndarray:
    """Colours (h, w, 3): `base` where the weight (h, w) is 0, `over` where it is 1."""
    base, over = np.asarray(base, np.float32), np.asarray(over, np.float32)
    return base + (over - base) * weight[..., None]


def _srgb(linear: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1 encoding of linear values in 0 to 1."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _shoulder(x: np.ndarray) -> np.ndarray:
    """Identity up to 0.8, then bent smoothly towards 1."""
    return np.where(x < 0.8, x, 0.8 + 0.2 * np.tanh((x - 0.8) / 0.2))


@functools.cache
def _table(curve) -> np.ndarray:
    """uint8 sRGB of `curve`, a reflectance in 0 to 1, at linear values from 0 to 2."""
    return np.round(255 * _srgb(curve(np.arange(2 * _STEPS) / _STEPS))).astype(np.uint8)


def _lookup(linear: np.ndarray, scale: np.ndarray, curve) -> np.ndarray:
    """uint8 sRGB of `curve` at linear values (h, w, 3) times `scale` (3,)."""
    step = linear * (scale * _STEPS).astype(np.float32)
    step += 0.5
    np.clip(step, 0, 2 * _STEPS - 1, out=step)
    return _table(curve).take(step.astype(np.uint16))


def _limit(x: np.ndarray) -> np.ndarray:
    return np.minimum(x, 1)


def encode(linear: np.ndarray) -> np.ndarray:
    """uint8 sRGB texture (h, w, 3) of linear reflectances (h, w, 3) in 0 to 1."""
    return _lookup(linear, np.ones(3), _limit)


def encode_with_mean(relative: np.ndarray, mean) -> np.ndarray:
    """uint8 sRGB texture of relative reflectances (h, w) or (h, w, 3), each channel scaled to a
    linear mean (3,)."""
    relative = np.atleast_3d(relative)
    return _lookup(relative, np.asarray(mean) / relative.mean(axis=(0, 1)), _limit)


def encode_neutral(relative: np.ndarray) -> np.ndarray:
    """uint8 sRGB texture of relative reflectances (h, w) or (h, w, 3), near white.

    Each channel is scaled so that its linear mean is `NEUTRAL_MEAN`, with highlights bent below 1.
    """
    relative = np.atleast_3d(relative)
    # A sample decides the scale. Its stride is odd, so that it does not run in step with courses.
    sample = relative.reshape(-1, relative.shape[2])[::29]
    scale = NEUTRAL_MEAN / sample.mean(axis=0)
    for _ in range(12):
        scale *= NEUTRAL_MEAN / _shoulder(sample * scale).mean(axis=0)
    texture = _lookup(relative, scale, _shoulder)
    return np.repeat(texture, 3, axis=2) if texture.shape[2] == 1 else texture


def doubled(field: np.ndarray) -> np.ndarray:
    """(h, w) as (2 h, 2 w), bilinear round the torus: smooth fields are made at half density."""
    for axis in (0, 1):
        before, after = np.roll(field, 1, axis), np.roll(field, -1, axis)
        pair = np.stack([0.75 * field + 0.25 * before, 0.75 * field + 0.25 * after], axis + 1)
        shape = list(field.shape)
        shape[axis] *= 2
        field = pair.reshape(shape)
    return field


def tones(rng: np.random.Generator, count: int, contrast: float, hue: float) -> np.ndarray:
    """(count, 3) float32 multipliers of units: lightness and a warm-cool shift, log-normal."""
    light = contrast * rng.standard_normal(count, np.float32)
    warm = hue * rng.standard_normal(count, np.float32)
    return np.exp(np.stack([light + warm, light, light - 1.4 * warm], axis=-1))
