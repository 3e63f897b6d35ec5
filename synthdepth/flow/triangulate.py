"""Metric depth from flow and the camera's own motion: what a drone knows and a picture does not.

A drone measures how it turned and moved between two frames. Rotation moves every pixel by an amount
that does not depend on depth; what remains of the flow lies along the pixel's epipolar line, and
how far is inverse depth (Hartley and Zisserman, Multiple View Geometry, chapter 9).
"""

import dataclasses

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.config import Config, number
from synthdepth.errors import SynthdepthError


@dataclasses.dataclass(frozen=True, kw_only=True)
class MotionNoise(Config):
    """How well a drone knows its motion between two frames.

    The defaults are those of a small drone: a consumer IMU behind a visual-inertial filter, with
    camera and IMU out of step by a millisecond.

    Attributes:
        rotation_deg: standard deviation of the relative rotation about each axis.
        velocity_mps: standard deviation of the velocity along each axis.
        velocity_share: standard deviation of the velocity's scale, as a share.
    """

    rotation_deg: float = number(0.05, 0, 10)
    velocity_mps: float = number(0.1, 0, 10)
    velocity_share: float = number(0.02, 0, 1)


NO_NOISE = MotionNoise(rotation_deg=0.0, velocity_mps=0.0, velocity_share=0.0)


def relative_motion(world_from_cam: np.ndarray, world_from_cam_prev: np.ndarray) -> np.ndarray:
    """`prev_from_cam` (4, 4) float64 of two poses (4, 4)."""
    return np.linalg.inv(world_from_cam_prev) @ world_from_cam


def measured_motion(
    rng: np.random.Generator, prev_from_cam: np.ndarray, dt_s: float, noise: MotionNoise
) -> np.ndarray:
    """The motion (4, 4) as a drone would measure it over `dt_s` [s]."""
    x, y, z = np.deg2rad(noise.rotation_deg) * rng.standard_normal(3)
    # Hundredths of a degree: the first order of the rotation, made orthogonal again.
    u, _, v = np.linalg.svd(np.array([[1, -z, y], [z, 1, -x], [-y, x, 1]]))
    measured = prev_from_cam.copy()
    measured[:3, :3] = u @ v @ prev_from_cam[:3, :3]
    measured[:3, 3] *= 1 + noise.velocity_share * rng.standard_normal()
    measured[:3, 3] += dt_s * noise.velocity_mps * rng.standard_normal(3)
    return measured


def triangulate(
    flow: np.ndarray,
    camera: Intrinsics,
    prev_from_cam: np.ndarray,
    *,
    max_depth_m: float = 200.0,
    flow_px: float = 0.5,
) -> tuple[np.ndarray, np.ndarray]:
    """Planar depth of frame t from its flow to t-1 and the motion between them.

    Args:
        flow: (H, W, 2) float32 [px], position at t-1 minus position at t.
        camera: of both frames.
        prev_from_cam: (4, 4) motion of the camera, see `relative_motion`.
        max_depth_m: the depth given where there is no parallax, or where it is farther.
        flow_px: standard deviation of the flow [px] along and across the epipolar line.

    Returns:
        depth_m: (H, W) float32 [m], within (0, max_depth_m].
        confidence: (H, W) float32 in [0, 1]: how many standard deviations the parallax is above
            the flow's noise, as n^2 / (1 + n^2), times how well the flow keeps to the epipolar
            line. 0 where the flow says nothing of depth.

    Raises:
        SynthdepthError: the flow has another size than the camera.
    """
    if flow.shape != (camera.height, camera.width, 2):
        raise SynthdepthError(
            f"flow is {flow.shape}: allowed is ({camera.height}, {camera.width}, 2), the camera's"
        )
    focal = np.array([camera.fx, camera.fy], np.float32)
    move = prev_from_cam[:3, 3].astype(np.float32)
    ray = camera.rays().astype(np.float32)
    seen = ray[..., :2] + flow / focal
    turned = ray @ prev_from_cam[:3, :3].T.astype(np.float32)
    ahead = np.maximum(turned[..., 2], np.float32(1e-3))
    # Where the pixel would be seen if it were infinitely far, and which way nearness moves it:
    # n(w) = n_inf + w e / (ahead + w move_z) at inverse depth w.
    infinite = turned[..., :2] / ahead[..., None]
    along = move[:2] - infinite * move[2]
    shift = seen - infinite
    square = np.maximum((along * along).sum(axis=-1), np.float32(1e-12))
    s = (shift * along).sum(axis=-1) / square
    inverse = s * ahead / np.maximum(1 - s * move[2], np.float32(1e-3))
    nearest = np.float32(1 / max_depth_m)
    depth_m = 1 / np.clip(inverse, nearest, np.float32(1e3))
    # Parallax and what lies beside the epipolar line, in standard deviations of the flow.
    reach = np.sqrt(square) * focal.mean() / np.float32(flow_px)
    parallax = np.maximum(s, 0) * reach
    beside = (shift[..., 0] * along[..., 1] - shift[..., 1] * along[..., 0]) / square * reach
    confidence = parallax**2 / (1 + parallax**2) * np.exp(-(beside**2) / 18)
    return depth_m, np.where(turned[..., 2] > 0, confidence, 0).astype(np.float32)
