"""Other files made by hand: recipes, settings, KITTI, AirSim, simulations."""

import re

import numpy as np

from fuzzing.parts import (
    ABSURD,
    Craft,
    absurd_png,
    deep_list,
    first,
    json_files,
    png_bomb,
    replace,
    toml_files,
)

# Other people's files.


def _text(pattern: str, old: str, new: str) -> Craft:
    return replace(pattern, lambda data: data.replace(old.encode(), new.encode(), 1))


def _numbers_of(pattern: str) -> list[Craft]:
    """A file of numbers with what is none, too many or too few."""
    texts = (
        "",
        "nan " * 30,
        "inf " * 30,
        "0 " * 30,
        "1e999 " * 30,
        "1 " * 9,
        "x",
        "1 " * 10_000,
        "-1 " * 30,
        "91 181 0 0 0 0 " + "0 " * 24,
        "\xff",
    )
    return [replace(pattern, lambda _, t=text: t.encode("latin-1")) for text in texts]


_LINES = (
    "\n",
    "x",
    "a/b_sync " + "9" * 5000 + " l",
    "a/b_sync -1 l",
    "../../../etc/x_sync 1 l",
    "/etc/x_sync 1 l",
    f"a_sync/image_02/data/{'9' * 5000}.png",
    "a_sync/image_99/data/1.png ../../../../etc/passwd.png 1",
    "a" * 100_000,
    "\0_sync 1 l",
    "é" * 300 + "_sync 1 l",
)
KITTI: list[Craft] = [
    *_numbers_of("depth/*/*/oxts/data/*"),
    *_numbers_of("selection/intrinsics/*"),
    *(replace("depth/splits/bts/*", lambda _, t=line: t.encode()) for line in _LINES),
    *(
        _text(f"{where}", "P_rect_02: ", f"P_rect_02: {' '.join([value] * 12)}\nx: ")
        for where in ("depth/*/calib_cam_to_cam.txt",)
        for value in ("nan", "0", "inf", "1e308", "1e-320")
    ),
    *(
        _text("depth/*/calib_cam_to_cam.txt", "S_rect_02: ", f"S_rect_02: {value} {value}\nx: ")
        for value in ("nan", "inf", "-1", "1e999", "0")
    ),
    *(
        _text("object/training/calib/*", "P2: ", f"P2: {' '.join([value] * 12)}\nx: ")
        for value in ("nan", "0", "inf", "1e308", "1e-320")
    ),
    *(
        replace("depth/*/*/proj_depth/*/*/*.png", lambda _, s=size: absurd_png(*s))
        for size in ABSURD
    ),
    *(replace("selection/image/*.png", lambda _, s=size: absurd_png(*s)) for size in ABSURD),
    replace("selection/groundtruth_depth/*", lambda _: png_bomb(16_384, 8192, 16, 0)),
    *(
        replace("depth/*/*/velodyne_points/data/*", lambda _, d=data: d)
        for data in (
            b"",
            b"x",
            np.full(400, np.nan, "<f4").tobytes(),
            np.full(400, np.inf, "<f4").tobytes(),
            np.full(400, 1e38, "<f4").tobytes(),
            np.full(400, 1e-42, "<f4").tobytes(),
        )
    ),
    *(
        replace("depth/synthdepth.json", lambda _, d=data: d)
        for data in (
            b"",
            b"null",
            b"{}",
            deep_list(),
            b'{"max_depth_m": []}',
            b'{"max_depth_m": NaN}',
            b'{"max_depth_m": -1}',
            b'{"max_depth_m": "x"}',
            b'{"max_depth_m": true}',
            b'{"max_depth_m": 1e999}',
        )
    ),
    lambda folder: first(folder, "depth/*/*/image_02/data/*").rename(
        first(folder, "depth/*/*/image_02/data") / "x.png"
    ),
    lambda folder: (first(folder, "depth/*/*/image_02/data") / f"{'9' * 240}.png").write_bytes(b""),
]

_ROW = "Drone1\t1000\t"
AIRSIM: list[Craft] = [
    *(
        _text("rec/airsim_rec.txt", _ROW, f"Drone1\t{value}\t")
        for value in ("", "nan", "-1", "9" * 400, "9" * 5000, "1e3", "1000.5")
    ),
    *(
        _text("rec/airsim_rec.txt", "\t1\t0\t0\t0\t", f"\t{value}\t{value}\t{value}\t{value}\t")
        for value in ("0", "nan", "1e999", "1e-320", "1e308", "x")
    ),
    *(
        _text("rec/airsim_rec.txt", "\t0\t-8\t", f"\t{value}\t{value}\t")
        for value in ("1e308", "-1e308", "1e30", "nan")
    ),
    *(
        _text("rec/airsim_rec.txt", "Drone1\t", f"{name}\t")
        for name in ("../../x", "/etc/x", "", "é" * 2000, "\0")
    ),
    *(
        _text("rec/airsim_rec.txt", "img_Drone1", f"{name}")
        for name in ("../../x", "/etc/x", "img_../x", "\0")
    ),
    *(replace("rec/images/*.png", lambda _, s=size: absurd_png(*s)) for size in ABSURD),
    replace("rec/images/*.png", lambda _: png_bomb(16_384, 16_384, colour=0)),
    *(
        replace("rec/images/*.pfm", lambda _, d=data: d)
        for data in (
            b"",
            b"Pf\n100000 100000\n-1\n",
            b"Pf\n999999999 999999999\n-1\n",
            b"PF\n1 1\n-1\n" + b"\0" * 12,
            b"Pf\n1 1\n-1e999\n\0\0\0\0",
            b"Pf\n1 1\n-nan\n\0\0\0\0",
            b"Pf\n1 1\n-1\n" + b"\0" * 4,
        )
    ),
    *(
        replace(
            "rec/images/*.pfm",
            lambda d, v=v: (
                d[:16]
                + np.full((len(d) - 16) // 4, v, "<f4").tobytes()
                + b"\0" * ((len(d) - 16) % 4)
            ),
        )
        for v in (np.nan, np.inf, -1, 0, 1e38, 1e-42)
    ),
    replace("rec/airsim_rec.txt", lambda d: d.splitlines(keepends=True)[0]),
    lambda folder: (folder / "rec/images/x").symlink_to("/etc/passwd"),
]


def _settings(*texts: str) -> list[Craft]:
    return [replace("settings.json", lambda _, t=text: t.encode()) for text in texts]


SIMULATION: list[Craft] = [
    *json_files("simulation.json"),
    *json_files("maps/*.json"),
    *(
        replace("flights.jsonl", lambda d, x=x: x + b"\n" + d)
        for x in (b"null", b"[]", b"{}", b"1", deep_list())
    ),
    *(
        replace(pattern, lambda d, x=x: x + b"\n" + d)
        for pattern in ("scenes/*", "times/*")
        for x in (b"null", b"[]", b"{}", b"1", deep_list())
    ),
    *(
        replace(pattern, lambda d, n=number: re.sub(rb"\d+\.\d+", n, d, count=1))
        for pattern in ("flights.jsonl", "scenes/*", "times/*")
        for number in (b"NaN", b"1" + b"0" * 400)
    ),
    *(replace("maps/*.jpg", lambda _, s=size: absurd_png(*s)) for size in ABSURD),
]


OTHERS: dict[str, list[Craft]] = {
    "recipe": toml_files("blocks.toml"),
    "camera": toml_files("camera.toml"),
    "airsim_settings": [
        *json_files("settings.json"),
        *_settings(
            "{/*" * 20_000,
            '{"a": "' + "\\" * 100_001,
            "//" * 50_000,
            "," * 100_000 + "]",
            '{"Vehicles": {"a": {"Cameras": {"": {"CaptureSettings": [{"Width": 1e300}]}}}}}',
            '{"CameraDefaults": {"CaptureSettings": [{"FOV_Degrees": 1e-320}]}}',
            ", " * 50_000,
        ),
    ],
    "airsim": AIRSIM,
    "simulation": SIMULATION,
    "kitti": KITTI,
}
