"""What the generator is given: the picture, and what flow and the drone's motion add to it."""

import dataclasses
import math

import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.config import Config, choice, number
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.transforms import SharedEpoch
from synthdepth.errors import DatasetError
from synthdepth.flow import METHODS, PX_AT_WHITE, embed, estimate_flow, flow_channels, flow_image
from synthdepth.flow.triangulate import (
    NO_NOISE,
    MotionNoise,
    measured_motion,
    relative_motion,
    triangulate,
)
from synthdepth.seeding import lane

# Channels of each kind of input.
CHANNELS = {"rgb": 3, "flow": 3, "embed": 3, "channels": 5, "triangulated": 5}
TRUTH = "truth"
# Triangulated depth of this [m] and less is -1 in its channel, which is logarithmic.
_NEAREST_M = 1.0


@dataclasses.dataclass(frozen=True, kw_only=True)
class InputConfig(Config):
    """The input of a network.

    Attributes:
        kind: "rgb", the frame alone; "flow", the heat map of its flow alone; "embed", the paper's:
            the frame with the heat map at every `interval`-th pixel (equation 18); "channels", the
            frame and both components of the flow; "triangulated", the frame, the depth that flow
            and the drone's own motion give, and how sure that is.
        interval: every how many pixels "embed" shows the flow.
        flow: how it is estimated, a name in `flow.METHODS`, or "truth" for the dataset's own.
        flow_scale: "fixed" or "frame", see `flow.flow_luminance`.
        px_at_white: the displacement that is white, or 1 among the channels.
        rotation_deg, velocity_mps, velocity_share: how well the motion between frames is known in
            training, see `flow.triangulate.MotionNoise`.
    """

    kind: str = choice("embed", tuple(CHANNELS))
    interval: int = number(5, 1, 256)
    flow: str = choice("farneback", (*METHODS, TRUTH))
    flow_scale: str = choice("fixed", ("fixed", "frame"))
    px_at_white: float = number(PX_AT_WHITE, 1e-3, 1e4)
    rotation_deg: float = number(MotionNoise.rotation_deg, 0, 10)
    velocity_mps: float = number(MotionNoise.velocity_mps, 0, 10)
    velocity_share: float = number(MotionNoise.velocity_share, 0, 1)

    @property
    def channels(self) -> int:
        """How many the generator reads."""
        return CHANNELS[self.kind]

    @property
    def fields(self) -> tuple[str, ...]:
        """Fields of a sample that the input is made of."""
        if self.kind == "rgb":
            return ("rgb",)
        return ("rgb", "flow" if self.flow == TRUTH else "prev")

    @property
    def noise(self) -> MotionNoise:
        """How well the motion is known."""
        names = (field.name for field in dataclasses.fields(MotionNoise))
        return MotionNoise(**{name: getattr(self, name) for name in names})


class MakeInput:
    """Sets `input`, (H, W, C) float32 in [-1, 1]; comes last, after what changes size or side.

    Args:
        config: what the input is.
        seed: of the motion's noise, which depends on it, the pair's key and the epoch alone. None
            leaves the motion as the sample has it.
    """

    def __init__(self, config: InputConfig, *, seed: int | None = None):
        self.config, self._seed, self._epoch = config, seed, SharedEpoch()

    def set_epoch(self, epoch: int) -> None:
        """Say which pass comes next; the datasets' own `set_epoch` calls this."""
        self._epoch.set(epoch)

    def __call__(self, sample: Sample) -> Sample:
        """The sample with its input; DatasetError where it lacks what the input is made of."""
        for name in self.config.fields:
            if getattr(sample, name) is None:
                raise DatasetError(
                    f"the input {self.config.kind!r} needs {name}, and {sample.key} has none"
                )
        return dataclasses.replace(sample, input=self._made(sample))

    def _made(self, sample: Sample) -> np.ndarray:
        config = self.config
        if config.kind == "rgb":
            return _signed(sample.rgb)
        flow = sample.flow
        if config.flow != TRUTH:
            flow = estimate_flow(sample.prev, sample.rgb, config.flow)
        scale = {"scale": config.flow_scale, "px_at_white": config.px_at_white}
        if config.kind == "flow":
            return _signed(flow_image(flow, **scale))
        if config.kind == "embed":
            return _signed(embed(sample.rgb, flow, config.interval, **scale))
        if config.kind == "channels":
            more = np.clip(flow_channels(flow, px_at_one=config.px_at_white), -1, 1)
        else:
            more = self._triangulated(sample, flow)
        return np.concatenate([_signed(sample.rgb), more], axis=-1)

    def _triangulated(self, sample: Sample, flow: np.ndarray) -> np.ndarray:
        """Log depth and confidence, (H, W, 2) float32 in [-1, 1]."""
        if sample.world_from_cam is None or sample.world_from_cam_prev is None:
            raise DatasetError(f"the input 'triangulated' needs poses, and {sample.key} has none")
        motion = relative_motion(sample.world_from_cam, sample.world_from_cam_prev)
        if self._seed is not None and self.config.noise != NO_NOISE:
            rng = lane(self._seed, "motion", sample.key, self._epoch.get())
            motion = measured_motion(rng, motion, sample.meta["dt_s"], self.config.noise)
        (fx, _, cx), (_, fy, cy), _ = sample.intrinsics
        height, width = flow.shape[:2]
        camera = Intrinsics(width=width, height=height, fx=fx, fy=fy, cx=cx, cy=cy)
        far_m = sample.max_depth_m if math.isfinite(sample.max_depth_m) else 200.0
        depth_m, confidence = triangulate(flow, camera, motion, max_depth_m=far_m)
        span = math.log(far_m / _NEAREST_M)
        share = np.log(np.maximum(depth_m, _NEAREST_M) / _NEAREST_M) / span
        # What is not known is not shown: where nothing is sure the channel is in its middle.
        return np.stack([(2 * share - 1) * confidence, 2 * confidence - 1], axis=-1)


def _signed(image: np.ndarray) -> np.ndarray:
    """8 bits as float32 in [-1, 1]."""
    return image.astype(np.float32) / np.float32(127.5) - 1
