"""Predictors that have learnt nothing of pictures: what a network must beat.

Each is called with a sample and gives its depth (H, W) float32 [m], saturated at the sample's
range; those that are fitted read a train split once, a sample at a time.
"""

import dataclasses
import math
from collections.abc import Callable, Iterable

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.dataset.sample import Sample
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.metrics import HIGHEST_M, LOWEST_M, known_truth
from synthdepth.evaluate.prepare import resize_linear
from synthdepth.flow import estimate_flow
from synthdepth.flow.triangulate import relative_motion, triangulate

Predictor = Callable[[Sample], np.ndarray]


@dataclasses.dataclass(frozen=True, kw_only=True)
class ConstantDepth:
    """The same depth everywhere.

    Attributes:
        depth_m: which.
    """

    depth_m: float

    @classmethod
    def fit(cls, samples: Iterable[Sample]) -> "ConstantDepth":
        """The mean depth of a train split, which makes the RMSE of a constant smallest."""
        total, count = 0.0, 0
        for sample in samples:
            depth = sample.depth_m[known_truth(sample.depth_m, sample.valid)]
            total, count = total + float(depth.sum(dtype=np.float64)), count + len(depth)
        if not count:
            raise SynthdepthError("a constant depth is fitted to samples: there was none")
        return cls(depth_m=total / count)

    def __call__(self, sample: Sample) -> np.ndarray:
        """The constant, for a sample."""
        return _saturated(np.full(sample.depth_m.shape, self.depth_m), sample)


@dataclasses.dataclass(frozen=True, kw_only=True)
class MeanDepth:
    """Each pixel's mean over a train split: what position in the picture alone tells.

    Attributes:
        depth_m: (H, W) float64; resized to samples of another size.
    """

    depth_m: np.ndarray

    @classmethod
    def fit(cls, samples: Iterable[Sample]) -> "MeanDepth":
        """The mean over samples of one size; a pixel that none knows has the mean of the others."""
        total = count = None
        for sample in samples:
            known = known_truth(sample.depth_m, sample.valid)
            if total is None:
                total, count = np.zeros(known.shape), np.zeros(known.shape)
            if known.shape != total.shape:
                raise SynthdepthError(
                    f"{sample.key} has {known.shape[1]}x{known.shape[0]} pixels, samples before it "
                    f"{total.shape[1]}x{total.shape[0]}: the mean depth needs one size"
                )
            total += np.where(known, sample.depth_m, 0)
            count += known
        if count is None or not count.any():
            raise SynthdepthError("the mean depth is fitted to samples: there was none")
        overall = total.sum() / count.sum()
        return cls(depth_m=np.where(count > 0, total / np.maximum(count, 1), overall))

    def __call__(self, sample: Sample) -> np.ndarray:
        """The mean depth, for a sample."""
        return _saturated(resize_linear(self.depth_m, sample.depth_m.shape, False), sample)


@dataclasses.dataclass(frozen=True, kw_only=True)
class GroundPlane:
    """Flat ground at the drone's altitude, seen at the camera's pitch and roll; nothing else."""

    def __call__(self, sample: Sample) -> np.ndarray:
        """The ground's depth below the horizon, the range above it.

        Raises:
            SynthdepthError: the sample knows no altitude, or neither pose nor pitch.
        """
        meta = sample.meta
        if "altitude_m" not in meta:
            raise SynthdepthError(f"{sample.key} has no altitude_m: the ground plane needs it")
        upward = _camera(sample).rays() @ _up_in_camera(sample)
        with np.errstate(divide="ignore"):
            depth = np.where(upward < 0, meta["altitude_m"] / -upward, np.inf)
        return _saturated(depth, sample)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Triangulation:
    """Depth from optical flow and the camera's known motion, each pixel by itself.

    Attributes:
        method: how the flow is estimated, a name in `flow.METHODS`; "exact" takes the sample's own.
        flow_px: standard deviation of that flow [px].
        least_confidence: of `triangulate`; below it there is too little parallax, and the depth is
            the range. 0.1 is a third of a standard deviation.
        least_depth_m: what seems nearer is a flow that fits no place ahead: likewise.
    """

    method: str = "dis"
    flow_px: float = 0.5
    least_confidence: float = 0.1
    least_depth_m: float = 0.5

    def __call__(self, sample: Sample) -> np.ndarray:
        """The triangulated depth; the range where there is no parallax.

        Raises:
            SynthdepthError: the sample lacks a pose, frame t-1 or, for "exact", its flow.
        """
        if sample.world_from_cam is None or sample.world_from_cam_prev is None:
            raise SynthdepthError(f"{sample.key} has no two poses: triangulation needs them")
        depth, confidence = triangulate(
            self._flow(sample),
            _camera(sample),
            relative_motion(sample.world_from_cam, sample.world_from_cam_prev),
            max_depth_m=min(sample.max_depth_m, HIGHEST_M),
            flow_px=self.flow_px,
        )
        known = (confidence >= self.least_confidence) & (depth >= self.least_depth_m)
        return _saturated(np.where(known, depth, np.inf), sample)

    def _flow(self, sample: Sample) -> np.ndarray:
        if self.method == "exact":
            if sample.flow is None:
                raise SynthdepthError(f"{sample.key} has no flow: triangulation 'exact' needs it")
            return sample.flow
        if sample.prev is None:
            raise SynthdepthError(f"{sample.key} has no frame before it: triangulation needs it")
        return estimate_flow(sample.prev, sample.rgb, self.method)


# By name: how each is made, from an iterable of train samples.
BASELINES: dict[str, Callable[[Iterable[Sample]], Predictor]] = {
    "constant": ConstantDepth.fit,
    "mean": MeanDepth.fit,
    "ground": lambda _: GroundPlane(),
    "triangulation": lambda _: Triangulation(),
    "triangulation-exact-flow": lambda _: Triangulation(method="exact", flow_px=0.01),
}
# Which of them read the train split.
FITTED = ("constant", "mean")


def make_baseline(name: str, train: Iterable[Sample] = ()) -> Predictor:
    """A baseline of `BASELINES`, fitted to the train split where it must be.

    Raises:
        SynthdepthError: there is none of that name, or it has nothing to be fitted to.
    """
    if name not in BASELINES:
        raise SynthdepthError(f"baseline {name!r}: allowed are {', '.join(BASELINES)}")
    return BASELINES[name](train)


def _saturated(depth: np.ndarray, sample: Sample) -> np.ndarray:
    return np.clip(depth, LOWEST_M, sample.max_depth_m).astype(np.float32)


def _camera(sample: Sample) -> Intrinsics:
    (fx, _, cx), (_, fy, cy), _ = sample.intrinsics.tolist()
    height, width = sample.depth_m.shape
    return Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy)


def _up_in_camera(sample: Sample) -> np.ndarray:
    """The world's up in the camera's axes, (3,)."""
    if sample.world_from_cam is not None:
        return sample.world_from_cam[2, :3]
    if "pitch_deg" not in sample.meta:
        raise SynthdepthError(f"{sample.key} has no pose and no pitch: the ground plane needs one")
    pitch = math.radians(sample.meta["pitch_deg"])
    roll = math.radians(sample.meta.get("roll_deg", 0.0))
    level = math.cos(pitch)
    return np.array([-level * math.sin(roll), -level * math.cos(roll), math.sin(pitch)])
