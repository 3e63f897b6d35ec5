"""Recordings of AirSim made in milliseconds, written as it writes them, without the package."""

import math

import cv2
import numpy as np

from synthdepth.camera import Intrinsics
from tests.made import view

CAMERA = Intrinsics.from_fov(64, 48, 90.0)
HEADER = "VehicleName\tTimeStamp\tPOS_X\tPOS_Y\tPOS_Z\tQ_W\tQ_X\tQ_Y\tQ_Z\tImageFile\n"
SETTINGS = """{
  // as AirSim's documentation writes it
  "SettingsVersion": 1.2, /* two kinds */
  "SeeDocsAt": "https://github.com/Microsoft/AirSim",
  "CameraDefaults": {"CaptureSettings": [{"ImageType": 0, "Width": 64, "Height": 48}]},
  "Vehicles": {"Drone_1": {"VehicleType": "SimpleFlight", "X": NaN, "Cameras": {
    "front_center": {"X": 0.5, "Y": -0.1, "Z": -0.2, "Pitch": -15, "Roll": 5.0, "Yaw": 20,},
  }}}
}"""


# Written from what the terms mean, without the package and without scipy.
def ned_heading(yaw_deg, pitch_deg):
    """Where a camera looks, up and to the right, in our world, and the quaternion w, x, y, z."""
    yaw, pitch = math.radians(yaw_deg), math.radians(pitch_deg)
    north, east = math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw)
    forward = np.array([east, north, math.sin(pitch)])
    right = np.array([math.cos(yaw), -math.sin(yaw), 0.0])
    cy, sy, cp, sp = (f(a / 2) for a in (yaw, pitch) for f in (math.cos, math.sin))
    return forward, right, (cy * cp, -sy * sp, cy * sp, sy * cp)


def pose_of(position_ned, yaw_deg, pitch_deg):
    forward, right, _ = ned_heading(yaw_deg, pitch_deg)
    made = np.eye(4)
    made[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    x, y, z = position_ned
    made[:3, 3] = [y, x, -z]
    return made


def turned(vector, quaternion_wxyz):
    """q v q*, by the definition of the product."""

    def product(a, b):
        return np.array(
            [
                a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
                a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
                a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
                a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
            ]
        )

    q = np.asarray(quaternion_wxyz, float)
    return product(product(q, [0, *vector]), q * [1, -1, -1, -1])[1:]


def airsim_pfm(path, image):
    """As Utils.hpp writes it: Pf, scale -1, the top row first."""
    height, width = image.shape
    with open(path, "wb") as file:
        file.write(b"Pf\n%d %d\n-1\n" % (width, height))
        for row in image:
            file.write(row.astype("<f4").tobytes())


def record_flight(
    folder,
    *,
    frames=4,
    vehicle="Drone_1",
    camera="front_center",
    perspective=False,
    mount=None,
    times_ms=None,
    clip_m=65_504.0,
    heading=(84.0, -6.0),
    picture=None,
):
    """A recording of `tests.made`'s wall, flown east; returns poses, pictures, planar depth."""
    (folder / "images").mkdir(parents=True, exist_ok=True)
    lines, truth = [], []
    mount = np.eye(4) if mount is None else mount
    for k in range(frames):
        ned = np.array([0.3 * k - 2.5, 1.2345678 * k, -8.0 - 0.01 * k])
        ned = np.array([float(f"{value:g}") for value in ned])  # Streams write 6 digits.
        quaternion = [float(f"{value:g}") for value in ned_heading(*heading)[2]]
        cam = (
            pose_of(ned, *heading)
            if (mount == np.eye(4)).all()
            else mount_pose(ned, heading, mount)
        )
        rgb, _, depth, *_ = view(CAMERA, cam, 1e9)
        rgb = picture(k, rgb) if picture else rgb
        stored = depth
        if perspective:
            stored = depth * np.linalg.norm(CAMERA.rays(), axis=-1)
        with np.errstate(over="ignore"):
            stored = np.minimum(stored, clip_m).astype(np.float16).astype(np.float32)
        kind, stamp = 1 + perspective, 1_600_000_000_000_000_000 + 50_000_000 * k
        names = [
            f"img_{vehicle}_{camera}_0_{stamp}.png",
            f"img_{vehicle}_{camera}_{kind}_{stamp + 9}.pfm",
        ]
        rgba = np.dstack([rgb[..., ::-1], np.full(rgb.shape[:2], 255, np.uint8)])
        cv2.imwrite(str(folder / "images" / names[0]), rgba)
        airsim_pfm(folder / "images" / names[1], stored)
        time_ms = 1000 + 100 * k if times_ms is None else times_ms[k]
        values = [vehicle, str(time_ms), *(f"{v:g}" for v in (*ned, *quaternion)), ";".join(names)]
        lines.append("\t".join(values) + "\n")
        truth.append((cam, rgb, depth))
    path = folder / "airsim_rec.txt"
    text = path.read_text() if path.exists() else HEADER
    path.write_text(text + "".join(lines))
    return truth


def mount_pose(ned, heading, mount):
    """The camera's pose by axes: each is a vector of the vehicle's, turned by the quaternion."""
    quaternion = ned_heading(*heading)[2]
    quaternion = np.array(quaternion) / np.linalg.norm(quaternion)

    def ours(vector):
        north, east, down = turned(vector, quaternion)
        return np.array([east, north, -down])

    forward, right, down = mount[:3, :3].T
    made = np.eye(4)
    made[:3, :3] = np.stack([ours(right), ours(down), ours(forward)], axis=1)
    made[:3, 3] = ours(mount[:3, 3]) + [ned[1], ned[0], -ned[2]]
    return made


def one_line(error):
    assert "\n" not in str(error.value)
    return str(error.value)
