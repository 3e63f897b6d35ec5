"""Camera conventions: OpenCV axes (x right, y down, z forward), integer pixel = pixel centre.

The world is right-handed, Z up, in metres. A pose is `world_from_cam`, a 4x4 matrix.
"""

import dataclasses
import math

import numpy as np


@dataclasses.dataclass(frozen=True, kw_only=True)
class Intrinsics:
    """A pinhole camera without distortion.

    Attributes:
        width: image width [px].
        height: image height [px].
        fx: focal length along x [px].
        fy: focal length along y [px].
        cx: principal point, x [px]; (width - 1) / 2 for a symmetric camera.
        cy: principal point, y [px].
    """

    width: int
    height: int
    fx: float
    fy: float
    cx: float
    cy: float

    @classmethod
    def from_fov(cls, width: int, height: int, fov_deg: float) -> "Intrinsics":
        """A symmetric camera with square pixels and a horizontal field of view."""
        f = width / 2 / math.tan(math.radians(fov_deg) / 2)
        return cls(width=width, height=height, fx=f, fy=f, cx=(width - 1) / 2, cy=(height - 1) / 2)

    @property
    def matrix(self) -> np.ndarray:
        """K, (3, 3) float64."""
        return np.array([[self.fx, 0, self.cx], [0, self.fy, self.cy], [0, 0, 1.0]])

    @property
    def fov_deg(self) -> float:
        """Horizontal field of view [deg]."""
        return math.degrees(2 * math.atan(self.width / 2 / self.fx))

    def rays(self) -> np.ndarray:
        """Camera-frame directions through the pixel centres with z = 1: (H, W, 3) float64."""
        x = (np.arange(self.width) - self.cx) / self.fx
        y = (np.arange(self.height) - self.cy) / self.fy
        d = np.ones((self.height, self.width, 3))
        d[..., 0], d[..., 1] = x[None, :], y[:, None]
        return d


def look_rotation(forward: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Rotations `world_from_cam` whose z axis is `forward` and whose -y axis is nearest `up`.

    Args:
        forward: (..., 3) directions, not parallel to `up`.
        up: (..., 3) directions.

    Returns:
        (..., 3, 3) float64, columns right, down, forward.
    """
    z = forward / np.linalg.norm(forward, axis=-1, keepdims=True)
    x = np.cross(z, up)
    x /= np.linalg.norm(x, axis=-1, keepdims=True)
    return np.stack([x, np.cross(z, x), z], axis=-1)


def pose(rotation: np.ndarray, position: np.ndarray) -> np.ndarray:
    """`world_from_cam` (4, 4) float64 from a rotation (3, 3) and the camera's position (3,) [m]."""
    m = np.eye(4)
    m[:3, :3], m[:3, 3] = rotation, position
    return m


def is_rigid(world_from_cam: np.ndarray) -> bool:
    """Whether a matrix (4, 4) is a pose: a rotation and a position, to a millionth."""
    rotation = world_from_cam[:3, :3]
    return bool(
        np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6)
        and np.linalg.det(rotation) > 0
        and np.array_equal(world_from_cam[3], [0, 0, 0, 1])
    )


def unproject(depth_m: np.ndarray, camera: Intrinsics, world_from_cam: np.ndarray) -> np.ndarray:
    """World points (H, W, 3) [m] of a planar depth image (H, W) [m]."""
    points = camera.rays() * np.asarray(depth_m, np.float64)[..., None]
    return points @ world_from_cam[:3, :3].T + world_from_cam[:3, 3]


def project(
    points: np.ndarray, camera: Intrinsics, world_from_cam: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Pixel coordinates (..., 2) and planar depth (...) [m] of world points (..., 3) [m].

    Points at or behind the camera plane get NaN pixels and their true (non-positive) depth.
    """
    p = (points - world_from_cam[:3, 3]) @ world_from_cam[:3, :3]
    z = p[..., 2]
    safe = np.where(z > 0, z, np.nan)
    uv = np.stack(
        [camera.fx * p[..., 0] / safe + camera.cx, camera.fy * p[..., 1] / safe + camera.cy], -1
    )
    return uv, z


def pitch_roll_deg(world_from_cam: np.ndarray) -> tuple[float, float]:
    """Elevation of the optical axis above the horizon, and roll clockwise about it [deg]."""
    right, down, forward = np.asarray(world_from_cam)[:3, :3].T
    pitch = math.degrees(math.asin(float(np.clip(forward[2], -1, 1))))
    return pitch, math.degrees(math.atan2(-right[2], -down[2]))
