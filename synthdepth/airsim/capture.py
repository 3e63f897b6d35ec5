"""Single captures of AirSim: a picture and its depth."""

from collections.abc import Iterable
from pathlib import Path

import cv2
import numpy as np

from synthdepth.airsim.pfm import read_pfm
from synthdepth.airsim.settings import DEPTH_PERSPECTIVE, DEPTH_PLANAR, SCENE, camera_from_settings
from synthdepth.camera import Intrinsics
from synthdepth.dataset.pair import saturate
from synthdepth.dataset.picture import decode_picture
from synthdepth.dataset.sample import Sample
from synthdepth.errors import DatasetError

# The contract's range.
RANGE_M = 200.0
# Where this share of all pixels holds exactly the greatest value, the depth was clipped there.
_CLIPPED_SHARE = 0.01


def read_picture(path: Path) -> np.ndarray:
    """The picture of a PNG or PPM file, (H, W, 3) uint8 RGB; AirSim's alpha says nothing.

    Raises:
        DatasetError: it cannot be read.
    """
    image = _decoded(path, cv2.IMREAD_COLOR)
    return cv2.cvtColor(image, cv2.COLOR_BGR2RGB)


def read_depth(path: Path) -> np.ndarray:
    """The depth of a capture as it was stored, (H, W) float32 [m], top row first.

    Args:
        path: a PFM file of AirSim's, or a PNG whose four bytes a pixel are a float32.

    Raises:
        DatasetError: it cannot be read, or it is a picture for the eye.
    """
    if path.suffix == ".pfm":
        return read_pfm(path, rows="top_first")
    image = _decoded(path, cv2.IMREAD_UNCHANGED)
    depth = None
    if image.dtype == np.uint8 and image.ndim == 3 and image.shape[2] == 4:
        # OpenCV's order of channels, blue first, is the order of the bytes.
        depth = np.ascontiguousarray(image).view("<f4")[..., 0]
    # Opaque alpha as a float's last byte makes it negative or NaN.
    if depth is None or np.isnan(depth).any() or depth.min() < 0:
        raise DatasetError(
            f"{path} is a picture of depth, not metres: record it with "
            '"PixelsAsFloat": true, which writes .pfm'
        )
    return depth.astype(np.float32)


def _decoded(path: Path, flags: int) -> np.ndarray:
    try:
        return decode_picture(Path(path).read_bytes(), flags)
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror or error}") from error
    except ValueError as error:
        raise DatasetError(f"{path} is no readable image: {error}") from None


def planar(stored_m: np.ndarray, camera: Intrinsics, depth_type: int) -> np.ndarray:
    """Planar depth (H, W) float32 [m] of what a capture of `depth_type` stored (H, W) [m]."""
    if depth_type == DEPTH_PLANAR:
        return stored_m
    return (stored_m / _ray_lengths(camera)).astype(np.float32)


def _ray_lengths(camera: Intrinsics) -> np.ndarray:
    return np.linalg.norm(camera.rays(), axis=-1)


def clip_of(depths: Iterable[np.ndarray]) -> float | None:
    """Where depth images (H, W) [m] were clipped; None where nothing tells that they were.

    Clipped are images whose greatest value so many pixels share that no place can be its cause.
    """
    greatest, at_greatest, pixels = -np.inf, 0, 0
    for depth in depths:
        top = float(depth.max())
        if top > greatest:
            greatest, at_greatest = top, 0
        at_greatest += int(np.sum(depth == greatest))
        pixels += depth.size
    clipped = np.isfinite(greatest) and at_greatest >= _CLIPPED_SHARE * pixels
    return greatest if clipped else None


def range_of(
    clip_m: float | None, asked_m: float | None, camera: Intrinsics, depth_type: int
) -> float:
    """Where planar depth shall saturate [m]: as asked for, or where it was clipped, at most 200.

    Lengths of rays that were clipped at L are planar depths from L / (longest ray) on.

    Args:
        clip_m: from `clip_of`.
        asked_m: what the user wants.
        camera: of the depth images.
        depth_type: DEPTH_PLANAR or DEPTH_PERSPECTIVE.

    Returns:
        a number that float32 holds exactly, as the depth images do.
    """
    if asked_m is not None and not 1 <= asked_m <= 65_504:
        raise DatasetError(f"--max-depth-m {asked_m}: allowed is a number from 1 to 65504")
    if asked_m is None:
        longest = 1.0 if depth_type == DEPTH_PLANAR else float(_ray_lengths(camera).max())
        asked_m = min(RANGE_M, (clip_m or np.inf) / longest)
    return float(np.float32(asked_m))


def read_airsim_capture(
    rgb: Path,
    depth: Path,
    settings: Path | None = None,
    *,
    camera: str | None = None,
    perspective: bool = False,
    max_depth_m: float | None = None,
) -> Sample:
    """A picture and its depth, without poses.

    Args:
        rgb: the picture.
        depth: its depth, see `read_depth`.
        settings: settings.json, for the field of view; 90 degrees without it.
        camera: which of the settings' cameras.
        perspective: the depth is DepthPerspective, the length of the ray, not DepthPlanar.
        max_depth_m: where the depth saturates; without it where the image was clipped, or 200 m.

    Raises:
        DatasetError: a file cannot be read or they do not belong together.
    """
    kind = DEPTH_PERSPECTIVE if perspective else DEPTH_PLANAR
    fov_deg = capture_fov_deg(settings, camera, kind)
    picture, stored_m = read_picture(rgb), read_depth(depth)
    check_same_size(depth, stored_m, rgb, picture)
    height, width = stored_m.shape
    intrinsics = Intrinsics.from_fov(width, height, fov_deg)
    range_m = range_of(clip_of([stored_m]), max_depth_m, intrinsics, kind)
    depth_m = planar(stored_m, intrinsics, kind)
    known = depth_m > 0
    return Sample(
        key=Path(rgb).stem,
        rgb=picture,
        depth_m=np.where(known, saturate(depth_m, range_m), np.float32(0)),
        valid=known,
        max_depth_m=range_m,
        intrinsics=intrinsics.matrix,
    )


def capture_fov_deg(
    settings: Path | None, camera: str | None, depth_type: int, *, vehicle: str | None = None
) -> float:
    """The horizontal field of view that picture and depth share; AirSim's 90 without settings.

    Raises:
        DatasetError: they differ, so that the depth is not the picture's.
    """
    if settings is None:
        return 90.0
    picture, depth = (
        camera_from_settings(settings, camera, vehicle=vehicle, image_type=kind).fov_deg
        for kind in (SCENE, depth_type)
    )
    if picture != depth:
        raise DatasetError(
            f"{settings}: the picture's FOV_Degrees is {picture:g}, the depth's {depth:g}: "
            "capture both with the same"
        )
    return picture


def check_same_size(depth: Path, depth_m: np.ndarray, rgb: Path, picture: np.ndarray) -> None:
    """Refuse a depth image of another size than its picture."""
    if depth_m.shape != picture.shape[:2]:
        (h, w), (height, width) = depth_m.shape, picture.shape[:2]
        raise DatasetError(
            f"{depth} is {w}x{h}, {rgb} {width}x{height}: set the same Width and Height in "
            "settings.json for both"
        )
