"""What depth can be predicted for: a dataset, a folder of pictures or a video, as samples."""

import dataclasses
import itertools
import re
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.dataset import PairDataset
from synthdepth.dataset.manifest import MANIFEST
from synthdepth.dataset.picture import check_size, decode_picture
from synthdepth.dataset.sample import Sample
from synthdepth.errors import DatasetError
from synthdepth.pix2pix.inputs import TRUTH, InputConfig

PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp")


@dataclasses.dataclass(frozen=True, kw_only=True)
class Frames:
    """Frames one after another.

    Attributes:
        samples: iterator; keys are names for files.
        count: how many, about so many for a video, or None where nobody knows.
        skipped: how many at the start have no frame before, and the input needs it.
    """

    samples: Iterator[Sample]
    count: int | None
    skipped: int = 0


def open_frames(
    source: str | Path,
    config: InputConfig,
    *,
    split: str | None = None,
    fov_deg: float | None = None,
) -> Frames:
    """The frames of a source, with what an input is made of.

    In a folder and a video the frame before is the one before in the order of names (numbers in
    them count as numbers) or of time; if the input needs it, the first frame is left out.

    Args:
        source: a dataset folder, a folder of pictures, a picture or a video.
        config: the input.
        split: "train" or "test", of a dataset; both without.
        fov_deg: horizontal field of view of pictures and videos, for their intrinsics.

    Raises:
        DatasetError: there is nothing there, or not what the input is made of; while iterating, a
            picture that cannot be read.
    """
    path = Path(source)
    if (path / MANIFEST).is_file() or "://" in str(source):
        pairs = PairDataset(source, split=split, fields=config.fields)
        return Frames(samples=(pairs[k] for k in range(len(pairs))), count=len(pairs))
    if not path.exists():
        raise DatasetError(f"{path}: there is no such folder or file")
    if config.kind == "triangulated" or "flow" in config.fields:
        lacking = "poses" if config.flow != TRUTH else "true flow"
        raise DatasetError(
            f"{path} has no {lacking}, which the input {config.kind!r} of this model needs: "
            "allowed is a dataset folder"
        )
    if split is not None:
        raise DatasetError(f"{path} is no dataset: split {split!r} is allowed for datasets only")
    pictures = _pictures(path)
    frames, count = _video(path) if pictures is None else (_read_all(pictures), len(pictures))
    if "prev" not in config.fields:
        return Frames(samples=_samples(frames, fov_deg), count=count)
    if count is not None and count < 2:
        raise DatasetError(
            f"{path} has {count} frame, and the input {config.kind!r} of this model needs the one "
            "before as well: allowed are 2 or more"
        )
    following = _samples_with_prev(frames, fov_deg)
    return Frames(samples=following, count=count and count - 1, skipped=1)


def _pictures(path: Path) -> list[Path] | None:
    """The pictures of a folder, or a single one; None where it is another file."""
    if path.is_file():
        return [path] if path.suffix.lower() in PICTURES else None
    found = [file for file in path.iterdir() if file.suffix.lower() in PICTURES]
    if not found:
        raise DatasetError(
            f"{path} has no {MANIFEST} and no pictures: allowed are a dataset folder, a folder of "
            f"{', '.join(PICTURES)}, or a video"
        )
    names = {}
    for file in found:
        if names.setdefault(file.stem, file) != file:
            raise DatasetError(
                f"{path} has {names[file.stem].name} and {file.name}: allowed is one picture a name"
            )
    return sorted(found, key=lambda file: [_order(part) for part in re.split(r"(\d+)", file.stem)])


def _order(part: str) -> tuple:
    return (0, int(part), "") if part.isdigit() else (1, 0, part)


def _read_all(pictures: list[Path]) -> Iterator[tuple[str, np.ndarray]]:
    for file in pictures:
        try:
            image = decode_picture(file.read_bytes(), cv2.IMREAD_COLOR)
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise DatasetError(f"{file} is not a readable picture: {reason}") from None
        yield file.stem, cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


def _video(path: Path) -> tuple[Iterator[tuple[str, np.ndarray]], int | None]:
    video = cv2.VideoCapture(str(path))
    if not video.isOpened():
        raise DatasetError(
            f"{path} is not a readable video: allowed are a dataset folder, pictures "
            f"({', '.join(PICTURES)}), or a video that OpenCV reads"
        )
    sides = (video.get(side) for side in (cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT))
    try:
        check_size(*sides)
    except ValueError as error:
        raise DatasetError(f"{path} is not a readable video: {error}") from None

    def frames() -> Iterator[tuple[str, np.ndarray]]:
        for number in itertools.count():
            there, image = video.read()
            if not there:
                return
            yield f"{path.stem}-{number:06d}", cv2.cvtColor(image, cv2.COLOR_BGR2RGB)

    count = int(video.get(cv2.CAP_PROP_FRAME_COUNT))
    return frames(), count if count > 0 else None


def _samples(frames, fov_deg: float | None) -> Iterator[Sample]:
    for key, rgb in frames:
        yield frame_sample(rgb, None, key=key, fov_deg=fov_deg)


def _samples_with_prev(frames, fov_deg: float | None) -> Iterator[Sample]:
    for (_, prev), (key, rgb) in itertools.pairwise(frames):
        yield frame_sample(rgb, prev, key=key, fov_deg=fov_deg)


def frame_sample(
    rgb: np.ndarray, prev: np.ndarray | None, *, key: str = "frame", fov_deg: float | None = None
) -> Sample:
    """A sample of bare frames (H, W, 3) uint8 RGB; without a field of view K is NaN."""
    height, width = rgb.shape[:2]
    camera = np.full((3, 3), np.nan)
    if fov_deg is not None:
        camera = Intrinsics.from_fov(width, height, fov_deg).matrix
    return Sample(
        key=key,
        rgb=rgb,
        prev=prev,
        depth_m=None,
        valid=None,
        max_depth_m=np.inf,
        intrinsics=camera,
    )
