"""Poses from KITTI's GPS and inertial unit ("oxts"), and back.

Its files hold 30 numbers: latitude, longitude [deg], altitude [m], roll, pitch, yaw [rad], then
velocities, accelerations, rates and the state of the receiver. Yaw 0 is east and grows
counter-clockwise; the unit's axes are x forward, y left, z up. Positions become metres by a
Mercator map, as in KITTI's development kit (`convertOxtsToPose.m`).
"""

import math
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from synthdepth.camera import pose
from synthdepth.errors import DatasetError

_EARTH_RADIUS_M = 6378137.0
_COUNT = 30


def read_oxts(path: Path) -> np.ndarray:
    """The (30,) float64 numbers of a file; DatasetError where it has others."""
    try:
        values = np.array([float(value) for value in path.read_text().split()])
    except (OSError, ValueError) as error:
        raise DatasetError(f"{path} cannot be read: {error}") from None
    if len(values) != _COUNT:
        raise DatasetError(f"{path} has {len(values)} numbers: allowed are {_COUNT}")
    # The others are not used, and may be NaN.
    if not np.isfinite(values[:6]).all() or abs(values[0]) >= 90:
        raise DatasetError(f"{path} has {values[:6].tolist()} for a pose, which is nowhere")
    return values


def world_from_imu(oxts: np.ndarray, first: np.ndarray) -> np.ndarray:
    """The unit's pose (4, 4) float64 in a world with x east, y north and z up [m].

    The world's origin is where the whole degrees of latitude and longitude nearest to the drive's
    first frame cross, so that numbers stay small and drives of a place share it.

    Args:
        oxts: (30,) of the frame.
        first: (30,) of the drive's first frame, whose latitude sets the map's scale.
    """
    origin, scale = np.round(first[:2]), math.cos(math.radians(first[0]))
    here, there = _mercator_m(*oxts[:2], scale), _mercator_m(*origin, scale)
    roll, pitch, yaw = oxts[3:6]
    rotation = Rotation.from_euler("ZYX", [yaw, pitch, roll]).as_matrix()
    return pose(rotation, np.array([here[0] - there[0], here[1] - there[1], oxts[2]]))


def oxts_of(world_from_imu: np.ndarray, velocity_mps: np.ndarray) -> np.ndarray:
    """The (30,) numbers of a pose in a world whose origin lies at latitude 0, longitude 0.

    There the Mercator map's scale is 1 to one part in 10^8 over a kilometre, so `world_from_imu`
    gives the pose back. What is not known (accelerations, rates, accuracies) is NaN.

    Args:
        world_from_imu: (4, 4); x east, y north, z up; not looking straight up or down.
        velocity_mps: (3,) in the same world.
    """
    east, north, up = world_from_imu[:3, 3]
    latitude = math.degrees(2 * math.atan(math.exp(north / _EARTH_RADIUS_M)) - math.pi / 2)
    yaw, pitch, roll = Rotation.from_matrix(world_from_imu[:3, :3]).as_euler("ZYX")
    oxts = np.full(_COUNT, np.nan)
    oxts[:6] = latitude, math.degrees(east / _EARTH_RADIUS_M), up, roll, pitch, yaw
    # North, east, then forward, left and up along the earth's surface.
    ahead = math.cos(yaw) * velocity_mps[0] + math.sin(yaw) * velocity_mps[1]
    left = math.cos(yaw) * velocity_mps[1] - math.sin(yaw) * velocity_mps[0]
    oxts[6:11] = velocity_mps[1], velocity_mps[0], ahead, left, velocity_mps[2]
    # State, satellites and modes are whole numbers, which readers convert: 0 is "none".
    oxts[25:] = 0
    return oxts


def _mercator_m(latitude_deg: float, longitude_deg: float, scale: float) -> tuple[float, float]:
    east = scale * _EARTH_RADIUS_M * math.radians(longitude_deg)
    angle = math.radians(90 + latitude_deg) / 2
    return east, scale * _EARTH_RADIUS_M * math.log(math.tan(angle))
