"""AirSim's files: float maps the right way up, settings with their defaults, real captures."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from synthdepth.airsim.capture import clip_of, read_airsim_capture, read_depth
from synthdepth.airsim.importer import import_airsim
from synthdepth.airsim.pfm import read_pfm, write_pfm
from synthdepth.airsim.settings import camera_from_settings
from synthdepth.errors import DatasetError
from synthdepth.production.recipe import CAMERAS
from tests.airsim_made import (
    SETTINGS,
    airsim_pfm,
    one_line,
    record_flight,
)
from tests.real import REAL, needs_real

real = needs_real("airsim")


# PFM


@settings(max_examples=25)
@given(
    st.integers(1, 7), st.integers(1, 5), st.sampled_from(["top_first", "bottom_first"]), st.data()
)
def test_pfm_round_trip(tmp_path_factory, width, height, rows, data):
    path = tmp_path_factory.mktemp("pfm") / "x.pfm"
    values = data.draw(st.lists(st.floats(width=32), min_size=35, max_size=35))
    image = np.array(values[: width * height], np.float32).reshape(height, width)
    write_pfm(path, image, rows=rows)
    np.testing.assert_array_equal(read_pfm(path, rows=rows), image)


def test_pfm_rows_are_the_trap(tmp_path):
    """AirSim stores the top row first; OpenCV believes the format's description and flips it."""
    image = np.arange(12, dtype=np.float32).reshape(3, 4)
    airsim_pfm(tmp_path / "airsim.pfm", image)
    np.testing.assert_array_equal(read_pfm(tmp_path / "airsim.pfm", rows="top_first"), image)
    flipped = cv2.imread(str(tmp_path / "airsim.pfm"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(flipped, image[::-1])
    write_pfm(tmp_path / "standard.pfm", image, rows="bottom_first")
    standard = cv2.imread(str(tmp_path / "standard.pfm"), cv2.IMREAD_UNCHANGED)
    np.testing.assert_array_equal(standard, image)


def test_pfm_of_either_byte_order_and_of_values_like_white_space(tmp_path):
    image = np.frombuffer(b"\n \n " * 6, "<f4").reshape(2, 3)
    for name, head, dtype in (("a", b"Pf\n3 2\n-1.0\n", "<f4"), ("b", b"Pf 3 2 1\n", ">f4")):
        (tmp_path / name).write_bytes(head + image.astype(dtype).tobytes())
        np.testing.assert_array_equal(read_pfm(tmp_path / name, rows="top_first"), image)


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "no PFM file"),
        (b"P5\n2 2\n255\n1234", "no PFM file"),
        (b"PF\n1 1\n-1\n" + bytes(12), "three channels"),
        (b"Pf\n2 2\n-1\n" + bytes(15), "25 bytes, not the 26"),
        (b"Pf\n2 2\n-1\n" + bytes(17), "27 bytes, not the 26"),
        (b"Pf\n999999999 999999999\n-1\n", "allowed is up to 16384"),
        (b"Pf\n0 4\n-1\n", "allowed is up to 16384"),
        (b"Pf\n1 1\n0\n" + bytes(4), "allowed are 1 and -1"),
        (b"Pf\n1 1\n.\n" + bytes(4), "allowed are 1 and -1"),
        (b"Pf\n-2 2\n-1\n" + bytes(16), "no PFM file"),
    ],
)
def test_bad_pfm_is_refused_in_one_line(tmp_path, data, said):
    (tmp_path / "x.pfm").write_bytes(data)
    with pytest.raises(DatasetError) as error:
        read_pfm(tmp_path / "x.pfm", rows="top_first")
    assert said in one_line(error)


def test_float_png_is_metres_and_a_picture_of_depth_is_not(tmp_path):
    depth = np.array([[1.5, 200.0, 65_504.0], [0.25, 31.0625, 7.0]], np.float32)
    cv2.imwrite(str(tmp_path / "f.png"), depth.view(np.uint8).reshape(2, 3, 4))
    np.testing.assert_array_equal(read_depth(tmp_path / "f.png"), depth)
    eye = np.dstack([np.full((2, 3, 3), 90, np.uint8), np.full((2, 3), 255, np.uint8)])
    for image in (eye, eye[..., :3], eye[..., 0]):
        cv2.imwrite(str(tmp_path / "v.png"), image)
        with pytest.raises(DatasetError, match="PixelsAsFloat"):
            read_depth(tmp_path / "v.png")


# settings.json


def test_settings_default_to_airsims(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text('{"SettingsVersion": 1.2}')
    camera = camera_from_settings(path)
    assert (camera.width, camera.height, camera.fov_deg) == (256, 144, 90.0)
    assert camera.intrinsics == CAMERAS["airsim"].intrinsics()
    assert camera.position_m is None and camera.angles_deg is None
    assert (camera.vehicle_from_camera == np.eye(4)).all()


def test_settings_of_a_camera_go_before_the_defaults(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text(SETTINGS)
    for name in ("front_center", "0", "", None):
        camera = camera_from_settings(path, name)
        assert (camera.width, camera.height, camera.fov_deg) == (64, 48, 90)
        assert camera.position_m == (0.5, -0.1, -0.2) and camera.angles_deg == (-15, 5, 20)
    other = camera_from_settings(path, "bottom_center")
    assert other.width == 64 and other.position_m is None
    # An entry of a camera replaces that of the defaults whole.
    captures = '"CaptureSettings": [{"ImageType": 0, "Height": 99, "FOV_Degrees": 60}], "X": 0.5'
    path.write_text(SETTINGS.replace('"X": 0.5', captures))
    camera = camera_from_settings(path, "front_center")
    assert (camera.width, camera.height, camera.fov_deg) == (256, 99, 60)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is not JSON"),
        ("[]", "holds no table"),
        ('{"CameraDefaults": 3}', "CameraDefaults is 3"),
        ('{"CameraDefaults": {"CaptureSettings": {}, "Gimbal": 1}}', "Gimbal is 1"),
        ('{"CameraDefaults": {"CaptureSettings": [1]}}', "a list of tables"),
        ('{"CameraDefaults": {"CaptureSettings": [{"Width": "640"}]}}', "Width = '640'"),
        ('{"CameraDefaults": {"CaptureSettings": [{"Width": 0}]}}', "from 1 to 16384"),
        ('{"CameraDefaults": {"CaptureSettings": [{"FOV_Degrees": 180}]}}', "from 1 to 179"),
        ('{"Vehicles": {"d": {"Cameras": {"a": {}, "b": {"CaptureSettings": [{"Width": 8}]}}}}}',
         "name one of a, b"),
    ],
)  # fmt: skip
def test_bad_settings_are_refused_in_one_line(tmp_path, text, said):
    (tmp_path / "settings.json").write_text(text)
    with pytest.raises(DatasetError) as error:
        camera_from_settings(tmp_path / "settings.json")
    assert said in one_line(error)


def test_an_unknown_camera_and_two_fields_of_view_are_refused(tmp_path):
    path = tmp_path / "settings.json"
    path.write_text(SETTINGS)
    with pytest.raises(DatasetError, match="no camera 'left'"):
        camera_from_settings(path, "left")
    path.write_text(SETTINGS.replace('"Height": 48}', '"Height": 48, "FOV_Degrees": 60}'))
    record_flight(tmp_path / "rec")
    with pytest.raises(DatasetError, match="the picture's FOV_Degrees is 60, the depth's 90"):
        import_airsim(tmp_path / "rec", tmp_path / "out", settings=path)


# Real captures


@real
@pytest.mark.parametrize("number", [1, 2])
def test_real_captures_are_upright_and_saturate_where_they_were_clipped(number):
    folder = REAL / "airsim"
    sample = read_airsim_capture(
        folder / f"Img0_{number}.png",
        folder / f"DepthGT_{number}.pfm",
        folder / "airsim_settings.json",
    )
    assert sample.rgb.shape == (480, 680, 3) and sample.rgb.dtype == np.uint8
    assert sample.depth_m.shape == (480, 680) and sample.depth_m.dtype == np.float32
    assert sample.max_depth_m == 40 and sample.valid.all()
    assert (sample.depth_m[:20] == 40).all() and (sample.depth_m[-20:] < 40).all()
    np.testing.assert_allclose(sample.intrinsics, [[340, 0, 339.5], [0, 340, 239.5], [0, 0, 1]])
    assert sample.prev is None and sample.world_from_cam is None

    def edges(image):
        return np.hypot(cv2.Sobel(image, cv2.CV_32F, 1, 0), cv2.Sobel(image, cv2.CV_32F, 0, 1))

    seen = edges(cv2.cvtColor(sample.rgb, cv2.COLOR_RGB2GRAY).astype(np.float32))
    upright, flipped = (
        np.corrcoef(seen.ravel(), edges(np.log(depth)).ravel())[0, 1]
        for depth in (sample.depth_m, sample.depth_m[::-1])
    )
    assert upright > 0.3 > flipped + 0.1


@real
def test_real_captures_have_no_poses_to_import(tmp_path):
    with pytest.raises(DatasetError, match="no airsim_rec.txt"):
        import_airsim(REAL / "airsim", tmp_path / "out")


def test_a_flat_top_is_a_clip_and_a_peak_is_not():
    depth = np.linspace(1, 90, 1000).reshape(20, 50)
    assert clip_of([depth, depth + 1]) is None
    assert clip_of([depth, np.minimum(depth, 30), np.full((20, 50), 90.0)]) == 90
    assert clip_of([np.minimum(depth, 30)]) == 30
    assert clip_of([np.where(depth > 30, np.inf, depth)]) is None
