"""What tells a drone the depth ahead: ideal depth cameras, nothing at all, or a trained model."""

import dataclasses
import hashlib
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Protocol

import numpy as np

from synthdepth.dataset.sample import Sample
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.baselines import GroundPlane, Triangulation

BLIND = "blind"
_BASELINES = {"ground": GroundPlane, "triangulation": Triangulation}
ALLOWED = (
    "a range in metres such as 10m or 200m (an ideal depth camera), "
    f"{BLIND}, {', '.join(_BASELINES)}, or a model's path, also as name=path"
)
_UNKNOWN_RANGE_M = 200.0


class DepthSource(Protocol):
    """Anything that gives depth.

    Attributes:
        max_depth_m: its range [m]: what is there or farther counts as equally far.
        sees: "depth", the samples hold the true depth; "rgb", they hold frames t and t-1 instead;
            "nothing".
    """

    max_depth_m: float
    sees: str

    def depth_m(self, samples: Sequence[Sample]) -> np.ndarray:
        """Planar depth (n, H, W) [m] of samples; H and W may be the source's own."""
        ...


@dataclasses.dataclass(frozen=True, kw_only=True)
class DepthCamera:
    """An ideal depth camera with a range: ground truth, saturated.

    Attributes:
        max_depth_m: the range.
    """

    max_depth_m: float
    sees = "depth"

    def depth_m(self, samples: Sequence[Sample]) -> np.ndarray:
        """The true depth."""
        return np.minimum([sample.depth_m for sample in samples], np.float32(self.max_depth_m))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Blind:
    """Sees nothing, and so flies straight at the goal: how hard the scenarios are."""

    max_depth_m: float = _UNKNOWN_RANGE_M
    sees = "nothing"

    def depth_m(self, samples: Sequence[Sample]) -> np.ndarray:
        """Everything is far."""
        shape = (len(samples), *samples[0].depth_m.shape)
        return np.full(shape, self.max_depth_m, np.float32)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Predicted:
    """A predictor that looks at pictures.

    Attributes:
        predict: samples -> (n, H, W) [m].
        max_depth_m: its range.
        batch: how many samples it is always given: a network's sums may depend on that number, and
            a flight must not depend on how many others are in the air.
    """

    predict: Callable[[Sequence[Sample]], np.ndarray]
    max_depth_m: float
    batch: int = 1
    sees = "rgb"

    def depth_m(self, samples: Sequence[Sample]) -> np.ndarray:
        """What the predictor says."""
        depths = []
        for i in range(0, len(samples), self.batch):
            some = list(samples[i : i + self.batch])
            padded = some + some[-1:] * (self.batch - len(some))
            depths.append(self.predict(padded)[: len(some)])
        return np.concatenate(depths)


@dataclasses.dataclass(frozen=True, kw_only=True)
class SourceName:
    """A source by name, not made yet.

    Attributes:
        name: in results.
        what: a range such as "10m", "blind", a baseline, or a model's path.
        sha256: of the model's file; empty without one.
    """

    name: str
    what: str
    sha256: str = ""


def parse_source(text: str) -> SourceName:
    """The source that a user names: see `ALLOWED`.

    Raises:
        SynthdepthError: there is no such source.
    """
    name, _, what = text.rpartition("=")
    if not what or (not name and "=" in text):
        raise SynthdepthError(f"--source {text!r}: allowed is {ALLOWED}")
    if _range_m(what) is not None or what == BLIND or what in _BASELINES:
        return SourceName(name=name or what, what=what)
    path = Path(what)
    if not path.exists():
        raise SynthdepthError(f"--source {text}: there is no such file; allowed is {ALLOWED}")
    from synthdepth.pix2pix.checkpoint import model_file

    with open(model_file(path), "rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return SourceName(name=name or what, what=what, sha256=digest)


def make_source(named: SourceName, *, batch: int) -> DepthSource:
    """The source of a name.

    Args:
        named: from `parse_source`.
        batch: how many samples a model is given at once.

    Raises:
        SynthdepthError: the model cannot be read, or torch is not there.
    """
    range_m = _range_m(named.what)
    if range_m is not None:
        return DepthCamera(max_depth_m=range_m)
    if named.what == BLIND:
        return Blind()
    if named.what in _BASELINES:
        one = _BASELINES[named.what]()
        return Predicted(
            predict=lambda samples: np.stack([one(sample) for sample in samples]),
            max_depth_m=_UNKNOWN_RANGE_M,
        )
    try:
        import torch

        from synthdepth.pix2pix.predict import Predictor
    except ImportError:
        raise SynthdepthError(
            f"the source {named.name} needs torch: pip install 'synthdepth[train]'"
        ) from None
    # A network's sums depend on the number of threads, and a flight must not.
    torch.set_num_threads(1)
    model = Predictor(named.what)
    range_m = model.config.coding.max_depth_m
    return Predicted(predict=model.depth_m, max_depth_m=range_m, batch=batch)


def _range_m(what: str) -> float | None:
    found = re.fullmatch(r"(\d+(?:\.\d+)?)m", what)
    if found is None:
        return None
    range_m = float(found[1])
    if not 0.1 <= range_m <= 5000:
        raise SynthdepthError(f"--source {what}: allowed are ranges from 0.1m to 5000m")
    return range_m
