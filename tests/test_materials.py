import numpy as np
import pytest

from synthdepth.maps.materials import catalogue as materials
from synthdepth.maps.materials import textures
from synthdepth.maps.materials.neutral import NEUTRAL
from synthdepth.maps.world import KINDS, Material

NAMES = set(materials.CATALOGUE)
# Far away, or glass, or as small as a lamp.
COARSE = {"hill", "glass", "lit_window"}


def linear(texture: np.ndarray) -> np.ndarray:
    """Linear values of a uint8 sRGB texture, by the standard's formula."""
    x = texture / 255
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


@pytest.fixture(scope="module")
def baked() -> dict[str, Material]:
    return materials.bake_materials(np.random.default_rng(0), NAMES)


@pytest.fixture(scope="module")
def other() -> dict[str, Material]:
    return materials.bake_materials(np.random.default_rng(1), NAMES)


@pytest.fixture(scope="module")
def reflectance(baked) -> dict[str, np.ndarray]:
    return {name: linear(material.texture) for name, material in baked.items()}


def test_the_catalogue_is_whole_and_fits_in_memory(baked):
    assert set(baked) == NAMES
    for material in baked.values():
        texture = material.texture
        assert texture.dtype == np.uint8
        assert texture.ndim == 3
        assert texture.shape[2] == 3
        assert texture.flags.c_contiguous
        assert min(material.size_m) > 0
        assert material.kind in KINDS
    assert sum(m.texture.nbytes for m in baked.values()) < 80e6


def test_texels_are_five_centimetres_or_finer_near_the_camera(baked):
    for name in NAMES - COARSE:
        height, width, _ = baked[name].texture.shape
        assert baked[name].size_m[0] / width <= 0.05, name
        assert baked[name].size_m[1] / height <= 0.05, name


@pytest.mark.parametrize("name", sorted(NAMES))
def test_tiles_seamlessly(reflectance, name):
    field = reflectance[name].mean(axis=2)
    for axis in (0, 1):
        steps = np.abs(np.roll(field, -1, axis) - field).mean(axis=1 - axis)
        border, inside = steps[-1], steps[:-1]
        # A border may be a mortar joint, but no sharper than the joints inside.
        assert border <= 1.2 * np.quantile(inside, 0.999)
        # Neither do gradients break there: the border's texel is no outlier between its neighbours.
        bend = np.abs(2 * field - np.roll(field, 1, axis) - np.roll(field, -1, axis))
        bend = bend.mean(axis=1 - axis)
        assert max(bend[0], bend[-1]) <= 1.2 * np.quantile(bend[1:-1], 0.999)


@pytest.mark.parametrize("name", sorted(NEUTRAL))
def test_neutral_textures_leave_the_reflectance_to_the_tint(reflectance, name):
    mean = reflectance[name].mean(axis=(0, 1))
    np.testing.assert_allclose(mean, textures.NEUTRAL_MEAN, atol=0.015)


@pytest.mark.parametrize(
    ("name", "low", "high"),
    [
        ("asphalt", 0.05, 0.12),
        ("paving", 0.18, 0.36),
        ("concrete", 0.18, 0.36),
        ("soil", 0.05, 0.18),
        ("gravel", 0.12, 0.30),
        ("rubber", 0.02, 0.06),
        ("metal", 0.4, 0.62),
        ("glass", 0.015, 0.05),
    ],
)
def test_coloured_textures_hold_their_reflectance(baked, other, name, low, high):
    for scene in (baked, other):
        mean = linear(scene[name].texture).mean(axis=(0, 1))
        assert np.all((mean > low) & (mean < high)), mean


@pytest.mark.parametrize("name", ["grass", "hill"])
def test_vegetation_is_green_but_not_saturated(baked, other, name):
    for scene in (baked, other):
        red, green, blue = linear(scene[name].texture).mean(axis=(0, 1))
        assert 0.03 < green < 0.12
        assert blue < red < green
        assert red > 0.5 * green


@pytest.mark.parametrize("name", sorted(NAMES))
def test_the_finest_octave_is_faint(reflectance, name):
    # Without mipmaps, contrast between neighbouring texels turns into noise far away.
    field = reflectance[name].mean(axis=2)
    h, w = field.shape
    halved = field.reshape(h // 2, 2, w // 2, 2).mean(axis=(1, 3))
    finest = field - halved.repeat(2, axis=0).repeat(2, axis=1)
    assert finest.std() <= 0.15 * field.mean()


def test_same_seed_same_bytes_other_seed_other_bytes(baked, other):
    again = materials.bake_materials(np.random.default_rng(0), NAMES)
    for name, material in baked.items():
        assert material.texture.tobytes() == again[name].texture.tobytes()
        assert material.size_m == again[name].size_m
        assert material.texture.tobytes() != other[name].texture.tobytes()


def test_a_material_less_leaves_the_others_as_they_are(baked):
    fewer = materials.bake_materials(np.random.default_rng(0), ["rubber", "paint"])
    assert list(fewer) == ["paint", "rubber"]
    for name, material in fewer.items():
        np.testing.assert_array_equal(material.texture, baked[name].texture)


def test_an_unknown_material_is_refused():
    with pytest.raises(KeyError, match="unobtainium"):
        materials.bake_materials(np.random.default_rng(0), ["unobtainium"])


def test_encoding_follows_the_standard():
    values = np.linspace(0, 1, 3 * 4096, dtype=np.float32).reshape(1, -1, 3)
    back = linear(textures.encode(values))
    # Half an 8-bit step: at most 1/255 * slope / 2, the slope being 1.055 * 2.4 at white.
    assert np.abs(back - values).max() < 0.5 / 255 * 2.6
    assert textures.encode(np.full((1, 1, 3), 0.18, np.float32)).tolist() == [[[118, 118, 118]]]


def test_worley_agrees_with_brute_force():
    rng = np.random.default_rng(4)
    shape, rows, columns = (48, 64), 6, 8
    cells = textures.worley(rng, shape, (rows, columns))
    jitter = 0.08 + 0.84 * np.random.default_rng(4).random((2, rows, columns), np.float32)
    r, c = np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij")
    points = np.stack([c + jitter[0], r + jitter[1]], -1).reshape(-1, 2)
    u, v = textures.texel_grid(shape)
    at = np.stack(np.broadcast_arrays(u * columns, v * rows), -1)
    away = np.abs(at[:, :, None] - points)
    away = np.minimum(away, [columns, rows] - away)
    distance = np.hypot(*np.moveaxis(away, -1, 0))
    np.testing.assert_allclose(cells.centre, distance.min(axis=2), atol=1e-3)
    assert np.mean(cells.index == distance.argmin(axis=2)) > 0.999
    assert cells.border.min() >= -1e-3


def test_noise_is_standard_and_keeps_to_its_band():
    field = textures.fractal_noise(np.random.default_rng(2), (256, 256), (8, 20))
    assert abs(field.mean()) < 1e-3
    assert field.std() == pytest.approx(1, abs=0.02)
    spectrum = np.abs(np.fft.rfft2(field)) ** 2
    cycles = np.hypot(np.fft.fftfreq(256)[:, None] * 256, np.arange(129)[None])
    assert spectrum[cycles < 6].sum() < 0.01 * spectrum.sum()
    assert spectrum[cycles > 50].sum() < 0.01 * spectrum.sum()


def test_courses_count_and_measure_their_units():
    rows, columns = 8, 4
    layout = textures.courses(
        np.random.default_rng(0), (256, 256), rows, columns, shift=0.5 * (np.arange(rows) % 2)
    )
    assert set(np.unique(layout.index)) == set(range(rows * columns))
    assert np.all(np.bincount(layout.index.ravel()) == 256 * 256 // (rows * columns))
    # The bottom row of texels belongs to row 0; ends lie half a unit apart in alternate rows.
    assert layout.row[-1, 0] == 0
    assert layout.row[0, 0] == rows - 1
    assert layout.side[-1, 0] == pytest.approx(0, abs=0.02)
    assert layout.side[-1 - 256 // rows, 0] == pytest.approx(0.5, abs=0.02)
