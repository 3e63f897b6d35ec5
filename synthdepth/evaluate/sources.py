"""What predicts depth: a trained model, an ONNX file, a folder of predictions, a baseline."""

import abc
import dataclasses
import operator
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from synthdepth.config import parse_json
from synthdepth.dataset.exr import decode_depth
from synthdepth.dataset.picture import check_size
from synthdepth.dataset.sample import Sample
from synthdepth.dataset.transforms import Resize, flipped
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate.baselines import BASELINES, FITTED, make_baseline
from synthdepth.kitti.png import read_depth
from synthdepth.pix2pix.inputs import InputConfig, MakeInput

BASELINE = "baseline:"
# Files of a prediction, in the order they are looked for, and how each is read.
PREDICTIONS = (".depth.exr", ".npy", ".png")
# What baselines say of the sky where the data do not say how far they reach: the paper's range.
_BASELINES_END_M = 200.0
# What a baseline needs of a sample beside its size.
_BASELINE_FIELDS = {"triangulation": ("prev",), "triangulation-exact-flow": ("flow",)}


class Source(abc.ABC):
    """Something that predicts depth. Subclass it to evaluate what is none of the kinds here.

    It is pickled into worker processes; there, and here, `start` comes before the first prediction.

    Attributes:
        name: at the head of its column.
        says: what it is, in words.
        fields: of a sample that it needs beside frame t: prev, flow, ...
    """

    name: str
    says: str = ""
    fields: tuple[str, ...] = ()

    def start(self, threads: int) -> None:  # noqa: B027
        """Make ready, with so many threads."""

    @abc.abstractmethod
    def depth_m(self, samples: Sequence[Sample]) -> Sequence[np.ndarray]:
        """Predicted depth of samples of one size, (h, w) float [m] each, in any size of its own."""

    def picture(self, sample: Sample) -> np.ndarray | None:
        """What it is given, (h, w, 3) uint8, where that is not frame t alone."""
        return None


class ModelSource(Source):
    """A model that `train` made.

    Args:
        path: a model, a checkpoint or the folder of a training.
        name: of the column.
        how: `device`, `precision` and `compiled` as `Predictor` has them.
    """

    def __init__(self, path: str, name: str, **how: Any) -> None:
        self.name, self._path, self._how = name, path, how
        self._predictor = self._loaded()
        config = self._predictor.config
        self.fields = config.input.fields
        self._plain = config.input.kind == "rgb"
        self.says = f"model {path}, input {_input_text(config.input)}"

    def start(self, threads: int) -> None:
        """Load it, if that was not in this process."""
        import torch

        torch.set_num_threads(threads)
        self._predictor = self._predictor or self._loaded()

    def depth_m(self, samples: Sequence[Sample]) -> np.ndarray:
        """See `Predictor.depth_m`."""
        return self._predictor.depth_m(samples)

    def picture(self, sample: Sample) -> np.ndarray | None:
        """The first three channels of the input."""
        return None if self._plain else _picture(self._predictor.network_input(sample))

    def _loaded(self):
        try:
            from synthdepth.pix2pix.predict import Predictor
        except ModuleNotFoundError as error:
            raise SynthdepthError(
                f"{self._path} needs {error.name}: install it with pip install 'synthdepth[train]'"
            ) from None
        return Predictor(self._path, **self._how)

    def __getstate__(self) -> dict:
        return self.__dict__ | {"_predictor": None}


class OnnxSource(Source):
    """An ONNX file that `export` of a model made, run by ONNX Runtime; needs no PyTorch.

    Args:
        path: the file.
        name: of the column.
    """

    def __init__(self, path: str, name: str) -> None:
        self.name, self._path, self._session = name, path, None
        self.start(1)
        try:
            facts = self._session.get_modelmeta().custom_metadata_map
            table = parse_json(facts["input"])
            width, height = map(operator.index, parse_json(facts["size"]))
            check_size(width, height)
        except (KeyError, ValueError, TypeError) as error:
            raise SynthdepthError(
                f"{path}: allowed is an ONNX file of a model of synthdepth, whose metadata say "
                f"`input` and `size` ({error} is missing or unreadable)"
            ) from None
        config = InputConfig.from_table(table, f"{path}: input")
        self.fields = config.fields
        self._resize, self._make_input = Resize(height=height, width=width), MakeInput(config)
        self._plain = config.kind == "rgb"
        self.says = f"ONNX model {path}, input {_input_text(config)}, {width}x{height}"

    def start(self, threads: int) -> None:
        """Load it."""
        try:
            import onnxruntime
        except ModuleNotFoundError:
            raise SynthdepthError(
                "ONNX files need onnxruntime: install it with pip install 'synthdepth[train]'"
            ) from None
        options = onnxruntime.SessionOptions()
        options.intra_op_num_threads, options.log_severity_level = threads, 3
        # Its errors share no class but Exception.
        try:
            self._session = onnxruntime.InferenceSession(
                self._path, options, providers=onnxruntime.get_available_providers()
            )
        except Exception as error:
            reason = str(error).splitlines()[0]
            raise SynthdepthError(f"{self._path} is no readable ONNX file: {reason}") from None

    def depth_m(self, samples: Sequence[Sample]) -> np.ndarray:
        """Depth in the size that the file has."""
        image = self.network_input(samples)
        # As above; a graph may also be of anything.
        try:
            name = self._session.get_inputs()[0].name
            return self._session.run(None, {name: image})[0][:, 0]
        except Exception as error:
            raise SynthdepthError(f"{self._path} gives no depth: {error}") from None

    def network_input(self, samples: Sequence[Sample]) -> np.ndarray:
        """What the network reads, (B, C, height, width) float32 in [-1, 1]."""
        image = np.stack([self._input(sample) for sample in samples])
        return np.ascontiguousarray(image.transpose(0, 3, 1, 2))

    def picture(self, sample: Sample) -> np.ndarray | None:
        """The first three channels of the input."""
        return None if self._plain else _picture(self._input(sample))

    def _input(self, sample: Sample) -> np.ndarray:
        return self._make_input(self._resize(sample)).input

    def __getstate__(self) -> dict:
        return self.__dict__ | {"_session": None}


class FolderSource(Source):
    """Predictions in files: `<key>.depth.exr` (channel Z, metres), `<key>.npy` ((h, w), metres), or
    `<key>.png` (16 bits, 1/256 m, as KITTI has them; 0 is no prediction).

    Args:
        path: the folder.
        name: of the column.
    """

    def __init__(self, path: str, name: str) -> None:
        self.name, self.says = name, f"predictions in {path}"
        self._folder = Path(path)

    def depth_m(self, samples: Sequence[Sample]) -> list[np.ndarray]:
        """What the files hold; SynthdepthError where one is missing or broken."""
        return [self._read(sample.key) for sample in samples]

    def _read(self, key: str) -> np.ndarray:
        path = next(
            (p for p in (self._folder / f"{key}{suffix}" for suffix in PREDICTIONS) if p.is_file()),
            None,
        )
        if path is None:
            raise SynthdepthError(
                f"{self._folder} has no prediction of {key}: allowed is that name with "
                f"{', '.join(PREDICTIONS)}"
            )
        if path.suffix == ".png":
            return read_depth(path)
        try:
            depth = _npy(path) if path.suffix == ".npy" else decode_depth(path.read_bytes())
        except (OSError, ValueError) as error:
            raise SynthdepthError(f"{path} cannot be read: {error}") from None
        if depth.ndim != 2 or depth.dtype.kind not in "fiu":
            raise SynthdepthError(
                f"{path} has shape {depth.shape} and type {depth.dtype}: allowed is "
                "(height, width) of numbers in metres"
            )
        return np.asarray(depth)


class BaselineSource(Source):
    """A baseline of `BASELINES`.

    Args:
        baseline: its name there.
        name: of the column.
        train: samples that it is fitted to, if it is one of `FITTED`.
    """

    def __init__(self, baseline: str, name: str, train: Iterable[Sample] = ()) -> None:
        self.name, self.says = name, f"baseline {baseline}"
        self.fields = _BASELINE_FIELDS.get(baseline, ())
        self._predict = make_baseline(baseline, train)

    def depth_m(self, samples: Sequence[Sample]) -> list[np.ndarray]:
        """One after another; in data without an end of their range it is 200 m."""
        return [
            self._predict(
                dataclasses.replace(sample, max_depth_m=min(sample.max_depth_m, _BASELINES_END_M))
            )
            for sample in samples
        ]


@dataclasses.dataclass
class FlipAveraged(Source):
    """The mean of each prediction and the mirrored picture's, as AdaBins and ZoeDepth evaluate.

    Attributes:
        source: what predicts.
    """

    source: Source

    def __post_init__(self):
        self.name, self.fields = self.source.name, self.source.fields
        self.says = f"{self.source.says}, averaged with the mirrored picture's"

    def start(self, threads: int) -> None:
        """Of the source."""
        self.source.start(threads)

    def depth_m(self, samples: Sequence[Sample]) -> list[np.ndarray]:
        """The means."""
        plain = self.source.depth_m(samples)
        mirrored = self.source.depth_m([flipped(sample) for sample in samples])
        return [(a + np.asarray(b)[:, ::-1]) / 2 for a, b in zip(plain, mirrored, strict=True)]

    def picture(self, sample: Sample) -> np.ndarray | None:
        """Of the source."""
        return self.source.picture(sample)


def open_source(
    text: str,
    *,
    train: Callable[[], Iterable[Sample]] | None = None,
    device: str | None = None,
    precision: str = "fp32",
) -> Source:
    """The source that a text means.

    Args:
        text: a model or the folder of a training, an `.onnx` file, a folder of predictions, or
            `baseline:NAME`; `LABEL=` before it gives its column that name.
        train: gives samples to fit baselines to; None: there are none.
        device, precision: of a model.

    Raises:
        SynthdepthError: it is none of these, or cannot be read.
    """
    label, equals, rest = text.partition("=")
    if equals and label and "/" not in label and not Path(text).exists():
        text = rest
    name = label if text is rest else text
    path = Path(text)
    if text.startswith(BASELINE):
        baseline = text.removeprefix(BASELINE)
        if baseline not in BASELINES:
            allowed = ", ".join(f"{BASELINE}{known}" for known in BASELINES)
            raise SynthdepthError(f"source {text!r}: allowed are {allowed}")
        if baseline in FITTED and train is None:
            raise SynthdepthError(
                f"{text} is fitted to the split train of datasets, and there is none"
            )
        return BaselineSource(baseline, name, train() if baseline in FITTED else ())
    if path.is_file() and path.suffix == ".onnx":
        return OnnxSource(text, name)
    if path.is_file() or (path.is_dir() and any(path.glob("*.safetensors"))):
        return ModelSource(text, name, device=device, precision=precision)
    if path.is_dir():
        return FolderSource(text, name)
    raise SynthdepthError(
        f"source {text!r}: there is no such file or folder; allowed are a model, the folder of a "
        f"training, an .onnx file, a folder of predictions, and {BASELINE}NAME with NAME one of "
        f"{', '.join(BASELINES)}"
    )


def _npy(path: Path) -> np.ndarray:
    """The array of a .npy file; ValueError where it is none of plain numbers."""
    # Mapped, so that a header cannot ask for more memory than the file has bytes, and nothing is
    # unpickled. A header is parsed as Python, with all the errors that Python has.
    try:
        return np.lib.format.open_memmap(path, mode="r")
    except Exception:
        raise ValueError("it is no .npy file of numbers, or it is cut off") from None


def _input_text(config: InputConfig) -> str:
    if config.kind == "rgb":
        return "rgb"
    every = f", interval {config.interval}" if config.kind == "embed" else ""
    return f"{config.kind} (flow {config.flow}{every})"


def _picture(network_input: np.ndarray) -> np.ndarray:
    """The first channels of an input in [-1, 1], as a picture."""
    return np.rint(127.5 * (np.clip(network_input[..., :3], -1, 1) + 1)).astype(np.uint8)
