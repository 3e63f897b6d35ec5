"""Ground truth of a pair: depth, and by choice optical flow, labels and normals."""

import dataclasses

import numpy as np

from synthdepth.camera import project
from synthdepth.render.renderer import Renderer

# How far short of a point a ray from the other camera may end and still count as reaching it: what
# a grazing surface does to a float32 hit, and no more.
_REACHED = 1 - 2e-4
_BEYOND_EVERYTHING_M = 1e5


@dataclasses.dataclass(frozen=True)
class Truth:
    """What is true of frame t.

    Attributes:
        depth_m: (H, W) float32, unsaturated planar depth [m]; the sky is inf.
        flow: (H, W, 2) float32 [px]: where each pixel of t was at t-1, minus where it is now; or
            None.
        visible: (H, W) bool, whether that place was inside the picture and unhidden; or None.
        seg: (H, W) uint8 labels, or None.
        normal: (H, W, 3) float32 in camera axes, turned to the camera, 0 in the sky; or None.
    """

    depth_m: np.ndarray
    flow: np.ndarray | None = None
    visible: np.ndarray | None = None
    seg: np.ndarray | None = None
    normal: np.ndarray | None = None


def ground_truth(
    renderer: Renderer,
    world_from_cam: np.ndarray,
    world_from_cam_prev: np.ndarray,
    modalities: tuple[str, ...],
) -> Truth:
    """The truth of a pair.

    Args:
        renderer: of its world.
        world_from_cam: (4, 4) pose of frame t.
        world_from_cam_prev: (4, 4) pose of frame t-1.
        modalities: of `MODALITIES`.
    """
    seg = normal = flow = visible = None
    if "seg" in modalities or "normal" in modalities:
        surfels = renderer.surfels(world_from_cam)
        depth_m = surfels.depth_m
        seg = surfels.label if "seg" in modalities else None
        normal = surfels.normal if "normal" in modalities else None
    else:
        depth_m = renderer.planar_depth(world_from_cam)
    if "flow" in modalities:
        flow, visible = _flow(renderer, depth_m, world_from_cam, world_from_cam_prev)
    return Truth(depth_m=depth_m, flow=flow, visible=visible, seg=seg, normal=normal)


def _flow(
    renderer: Renderer, depth_m: np.ndarray, pose: np.ndarray, prev: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Flow and visibility of a static world; the sky is so far that only turning moves it."""
    camera = renderer.camera
    sky = ~np.isfinite(depth_m)[..., None]
    rays = camera.rays() @ pose[:3, :3].T
    # The sky at t-1 is in the same direction, wherever the camera was.
    place = np.where(
        sky, prev[:3, 3] + rays, pose[:3, 3] + rays * np.where(sky, 1, depth_m[..., None])
    )
    was, _ = project(place, camera, prev)
    v, u = np.mgrid[: camera.height, : camera.width]
    flow = np.nan_to_num(was - np.stack([u, v], axis=-1)).astype(np.float32)
    inside = (was > -0.5) & (was < [camera.width - 0.5, camera.height - 0.5])
    toward = (place - prev[:3, 3]) * np.where(sky, _BEYOND_EVERYTHING_M, 1)
    reached = renderer.reach(prev, toward.reshape(-1, 3)).reshape(depth_m.shape) >= _REACHED
    return flow, inside.all(axis=-1) & reached
