"""Poses in AirSim's axes, north-east-down with the camera's x forward, and in ours.

TartanAir, which was recorded with AirSim, has the same axes.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from synthdepth.camera import pose

# Our world has X east, Y north, Z up; the matrix is its own inverse.
WORLD_FROM_NED = np.array([[0.0, 1, 0], [1, 0, 0], [0, 0, -1]])
# A body has x forward, y right, z down; a camera in OpenCV's axes x right, y down, z forward.
BODY_FROM_OPTICAL = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])


def body_pose(position_m: np.ndarray, quaternion_wxyz: np.ndarray) -> np.ndarray:
    """`ned_from_body` (4, 4) float64 of a position (3,) [m] and a quaternion of any length but 0.

    Raises:
        ValueError: the quaternion has no direction.
    """
    return pose(Rotation.from_quat(quaternion_wxyz, scalar_first=True).as_matrix(), position_m)


def mounted(position_m: np.ndarray, *, pitch_deg: float, roll_deg: float, yaw_deg: float):
    """`vehicle_from_camera` (4, 4) float64 in body axes of a camera mounted as settings.json says.

    Yaw is applied last and turns right, pitch turns up, roll turns clockwise, as in Unreal.
    """
    turn = Rotation.from_euler("ZYX", [yaw_deg, pitch_deg, roll_deg], degrees=True)
    return pose(turn.as_matrix(), position_m)


def world_from_cam(ned_from_body: np.ndarray) -> np.ndarray:
    """Our pose (4, 4) of a camera whose body axes have the pose `ned_from_body` (4, 4)."""
    rotation = WORLD_FROM_NED @ ned_from_body[:3, :3] @ BODY_FROM_OPTICAL
    return pose(rotation, WORLD_FROM_NED @ ned_from_body[:3, 3])


def ned_line(world_from_cam: np.ndarray) -> np.ndarray:
    """Our pose (4, 4) as TartanAir writes it, (7,) float64: x, y, z [m], qx, qy, qz, qw."""
    rotation = WORLD_FROM_NED @ world_from_cam[:3, :3] @ BODY_FROM_OPTICAL.T
    turn = Rotation.from_matrix(rotation).as_quat(canonical=True)
    return np.concatenate([WORLD_FROM_NED @ world_from_cam[:3, 3], turn])
