"""Flow as geometry has it, and how far an estimate is off."""

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.errors import SynthdepthError

_BEYOND = ("infinity", "range", "unknown")


def flow_from_depth(
    depth_m: np.ndarray,
    camera: Intrinsics,
    world_from_cam: np.ndarray,
    world_from_cam_prev: np.ndarray,
    *,
    max_depth_m: float = np.inf,
    beyond: str = "infinity",
) -> np.ndarray:
    """Where each pixel of frame t was at t-1 in a world that stands still, minus where it is now.

    Args:
        depth_m: planar depth of frame t, (H, W) [m]; 0 or NaN where it is unknown.
        camera: of both frames.
        world_from_cam: (4, 4) pose of frame t.
        world_from_cam_prev: (4, 4) pose of frame t-1.
        max_depth_m: where the depth saturates.
        beyond: how pixels at or beyond `max_depth_m` move. "infinity": as the sky does, by turning
            alone; true of the sky, and for a surface short by f times the way flown over its
            distance, under 1 px at 200 m for a way of 1 m. "range": as if they were there.
            "unknown": NaN.

    Returns:
        (H, W, 2) float32 [px], u right and v down. NaN where the depth is unknown, or the place was
        at or behind the plane of the earlier camera (`flow.exr` has 0 there).

    Raises:
        SynthdepthError: the depth has another size than the camera, or `beyond` is another word.
    """
    depth_m = np.asarray(depth_m, np.float64)
    if depth_m.shape != (camera.height, camera.width):
        raise SynthdepthError(
            f"depth_m is {depth_m.shape}: allowed is ({camera.height}, {camera.width}), "
            "the camera's size"
        )
    if beyond not in _BEYOND:
        raise SynthdepthError(f"beyond = {beyond!r}: allowed are {', '.join(_BEYOND)}")
    if beyond == "range" and not np.isfinite(max_depth_m):
        raise SynthdepthError(f"max_depth_m = {max_depth_m}: beyond = 'range' needs a finite one")
    with np.errstate(divide="ignore"):
        inverse = np.where(depth_m > 0, 1 / depth_m, np.nan)
    saturated = depth_m >= max_depth_m
    inverse[saturated] = {"infinity": 0, "range": 1 / max_depth_m, "unknown": np.nan}[beyond]
    # A point and its multiples are seen at the same pixel, so all is divided by the depth.
    prev_from_cam = np.linalg.inv(world_from_cam_prev) @ world_from_cam
    p = camera.rays() @ prev_from_cam[:3, :3].T + inverse[..., None] * prev_from_cam[:3, 3]
    z = np.where(p[..., 2] > 0, p[..., 2], np.nan)
    v, u = np.mgrid[: camera.height, : camera.width]
    flow = [camera.fx * p[..., 0] / z + camera.cx - u, camera.fy * p[..., 1] / z + camera.cy - v]
    return np.stack(flow, axis=-1).astype(np.float32)


def end_point_error(
    flow: np.ndarray, truth: np.ndarray, mask: np.ndarray | None = None
) -> np.ndarray:
    """Distance between where two flows end, a number a pixel.

    Args:
        flow: (H, W, 2) [px].
        truth: (H, W, 2) [px]; pixels where it is NaN are left out.
        mask: (H, W) bool, which pixels count; all by default.

    Returns:
        (N,) float64 [px], the pixels that count, in order.
    """
    if flow.shape != truth.shape or (mask is not None and mask.shape != truth.shape[:2]):
        raise SynthdepthError(
            f"flow {flow.shape}, truth {truth.shape}, mask {None if mask is None else mask.shape}: "
            "allowed are equal sizes"
        )
    counts = np.isfinite(truth).all(axis=-1)
    if mask is not None:
        counts &= mask
    return np.linalg.norm(np.subtract(flow[counts], truth[counts], dtype=np.float64), axis=-1)
