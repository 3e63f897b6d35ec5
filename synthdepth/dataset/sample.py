"""What loaders hand to trainers and evaluators, the same for our pairs, KITTI and AirSim."""

import dataclasses
from collections.abc import Mapping

import numpy as np

from synthdepth.dataset.pair import Pair


@dataclasses.dataclass(frozen=True, kw_only=True)
class Sample:
    """A frame with its depth, and whatever else its source knows; what it does not know is None.

    Attributes:
        key: name within the dataset.
        rgb: frame t, (H, W, 3) uint8 sRGB.
        depth_m: planar depth of frame t, (H, W) float32 [m]; 0 where it is unknown.
        valid: (H, W) bool, where the depth is known; what is saturated is.
        max_depth_m: where the depth saturates; what holds exactly this is there or farther. inf for
            a sensor whose depth is left out instead.
        intrinsics: K, (3, 3) float64, the first pixel's centre at (0, 0).
        prev: frame t-1, as `rgb`.
        world_from_cam: pose of frame t, (4, 4) float64, OpenCV axes.
        world_from_cam_prev: pose of frame t-1.
        flow: (H, W, 2) float32 [px], where each pixel of t was at t-1, minus where it is now.
        visible: (H, W) bool, whether that place was seen at t-1.
        seg: (H, W) uint8, values of `LABELS`.
        normal: (H, W, 3) float32, camera axes.
        input: what a network is given, set by a transform.
        meta: whatever else the source says of the frame.
    """

    key: str
    rgb: np.ndarray
    depth_m: np.ndarray
    valid: np.ndarray
    max_depth_m: float
    intrinsics: np.ndarray
    prev: np.ndarray | None = None
    world_from_cam: np.ndarray | None = None
    world_from_cam_prev: np.ndarray | None = None
    flow: np.ndarray | None = None
    visible: np.ndarray | None = None
    seg: np.ndarray | None = None
    normal: np.ndarray | None = None
    input: np.ndarray | None = None
    meta: Mapping = dataclasses.field(default_factory=dict)


def sample_of(pair: Pair) -> Sample:
    """The sample of a pair of the contract, in which every pixel's depth is known."""
    return Sample(
        key=pair.key,
        rgb=pair.rgb,
        prev=pair.prev,
        depth_m=pair.depth_m,
        valid=np.ones(pair.depth_m.shape, bool),
        max_depth_m=pair.meta["max_depth_m"],
        intrinsics=pair.camera.matrix,
        world_from_cam=pair.world_from_cam,
        world_from_cam_prev=pair.world_from_cam_prev,
        flow=pair.flow,
        visible=pair.visible,
        seg=pair.seg,
        normal=pair.normal,
        meta=pair.meta,
    )
