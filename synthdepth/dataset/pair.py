"""One pair of the contract: two pictures, depth and metadata, to and from the files of a shard."""

import dataclasses
import json
import math
import re
from collections.abc import Iterable, Mapping

import cv2
import numpy as np

from synthdepth.camera import Intrinsics
from synthdepth.config import parse_json, shown
from synthdepth.dataset.exr import (
    decode_depth,
    decode_flow,
    decode_normal,
    encode_depth,
    encode_flow,
    encode_normal,
)
from synthdepth.dataset.picture import check_size, decode_picture

SCHEMA_VERSION = 1

# Every field of meta.json and its type. Flat and fixed: readers that guess a schema from the first
# rows (Hugging Face datasets, Arrow) would otherwise truncate or drop what comes later.
META_FIELDS = {
    "schema_version": int,
    "map": str,
    "split": str,
    "condition": str,
    "scene_index": int,
    "scene_seed": int,
    "flight_index": int,
    "frame_index": int,
    "time_s": float,
    "dt_s": float,
    "width": int,
    "height": int,
    "intrinsics": list,
    "world_from_cam": list,
    "world_from_cam_prev": list,
    "velocity_mps": list,
    "speed_mps": float,
    "altitude_m": float,
    "clearance_m": float,
    "pitch_deg": float,
    "roll_deg": float,
    "max_depth_m": float,
    "nearest_depth_m": float,
    "median_depth_m": float,
    "in_range_share": float,
    "sun_azimuth_deg": float,
    "sun_elevation_deg": float,
    "turbidity": float,
    "visibility_m": float,
    "cloud_cover": float,
    "wetness": float,
    "spp": int,
    "exposure": float,
    "shutter_s": float,
    "white_electrons": float,
    "contrast": float,
    "saturation": float,
    "jpeg_quality": int,
}

SPLITS = ("train", "test")
# Names of files and folders are made of it.
MAP_NAME = "[A-Za-z0-9_-]{1,64}"
_SHAPES = {
    "intrinsics": (3, 3), "world_from_cam": (4, 4), "world_from_cam_prev": (4, 4),
    "velocity_mps": (3,),
}  # fmt: skip
# Whole numbers are counted from 0, and exact in every reader of JSON.
_MOST_WHOLE = 2**53

# Files of a pair: those that are always there, and those of each modality.
ALWAYS = ("rgb.png", "prev.png", "depth.exr", "meta.json")
BY_MODALITY = {"flow": "flow.exr", "seg": "seg.png", "normal": "normal.exr"}
# What can be decoded of a pair, and the file it is in.
FIELDS = {"rgb": "rgb.png", "prev": "prev.png", "depth_m": "depth.exr"} | BY_MODALITY


def pair_key(map_name: str, scene_index: int, flight_index: int, frame_index: int) -> str:
    """The key of a pair, e.g. `neighborhood-s00012-f003-0045`: no dots, sorts in drawing order."""
    return f"{map_name}-s{scene_index:05d}-f{flight_index:03d}-{frame_index:04d}"


def is_map_name(value) -> bool:
    """Whether this may be the name of a map."""
    return isinstance(value, str) and re.fullmatch(MAP_NAME, value) is not None


def scene_of_key(key: str) -> int:
    """The scene index in a pair's key; ValueError where it is no such key."""
    found = re.fullmatch(r".+-s(\d{5,})-f\d{3,}-\d{4,}", key)
    if not found:
        raise ValueError(f"{key!r} is not the key of a pair")
    return int(found[1])


def saturate(depth_m: np.ndarray, max_depth_m: float) -> np.ndarray:
    """Depth as the contract has it: float32, exactly `max_depth_m` at or beyond the range.

    Args:
        depth_m: (H, W) planar depth [m], inf where nothing was hit.
    """
    return np.minimum(depth_m, np.float32(max_depth_m)).astype(np.float32)


@dataclasses.dataclass(frozen=True, kw_only=True)
class Pair:
    """Frame t with its depth, and frame t-1.

    Attributes:
        key: name of the pair within its dataset.
        rgb: frame t, (H, W, 3) uint8 sRGB.
        prev: frame t-1, (H, W, 3) uint8 sRGB.
        depth_m: planar depth of frame t, (H, W) float32 [m], saturated.
        meta: the fields of `META_FIELDS`.
        flow: (H, W, 2) float32 [px], where each pixel of t was at t-1, minus where it is now; None
            if the dataset has none, as below.
        visible: (H, W) bool, whether that place was seen at t-1.
        seg: (H, W) uint8, values of `LABELS`.
        normal: (H, W, 3) float32 unit normals in camera axes, turned to the camera; 0 in the sky.
    """

    key: str
    rgb: np.ndarray
    prev: np.ndarray
    depth_m: np.ndarray
    meta: Mapping
    flow: np.ndarray | None = None
    visible: np.ndarray | None = None
    seg: np.ndarray | None = None
    normal: np.ndarray | None = None

    @property
    def camera(self) -> Intrinsics:
        """Intrinsics of both frames."""
        return camera_of(self.meta)

    @property
    def world_from_cam(self) -> np.ndarray:
        """Pose of frame t, (4, 4) float64."""
        return np.array(self.meta["world_from_cam"])

    @property
    def world_from_cam_prev(self) -> np.ndarray:
        """Pose of frame t-1, (4, 4) float64."""
        return np.array(self.meta["world_from_cam_prev"])


def camera_of(meta: Mapping) -> Intrinsics:
    """The intrinsics that a `meta.json` holds."""
    (fx, _, cx), (_, fy, cy), _ = meta["intrinsics"]
    return Intrinsics(width=meta["width"], height=meta["height"], fx=fx, fy=fy, cx=cx, cy=cy)


def encode_pair(
    *,
    rgb_png: bytes,
    prev_png: bytes,
    depth_m: np.ndarray,
    meta: Mapping,
    flow: np.ndarray | None = None,
    visible: np.ndarray | None = None,
    seg: np.ndarray | None = None,
    normal: np.ndarray | None = None,
) -> dict[str, bytes]:
    """The files of a pair, {suffix: bytes}; pictures come encoded, as two pairs share each.

    Args:
        rgb_png: frame t, from `encode_png`.
        prev_png: frame t-1.
        depth_m: (H, W) float32 [m], saturated.
        meta: the fields of `META_FIELDS`.
        flow, visible, seg, normal: as `Pair` has them; what is None gets no file.
    """
    check_meta(meta)
    pose = np.array(meta["world_from_cam"])
    members = {
        "rgb.png": rgb_png,
        "prev.png": prev_png,
        "depth.exr": encode_depth(depth_m, camera_of(meta), pose, meta["max_depth_m"]),
        "meta.json": json.dumps(dict(meta)).encode(),
    }
    if flow is not None:
        members["flow.exr"] = encode_flow(flow, visible)
    if seg is not None:
        members["seg.png"] = cv2.imencode(".png", seg)[1].tobytes()
    if normal is not None:
        members["normal.exr"] = encode_normal(normal)
    return members


def decode_pair(key: str, members: Mapping[str, bytes]) -> Pair:
    """The pair of its members.

    Raises:
        ValueError: a member is missing or cannot be decoded.
    """
    missing = set(ALWAYS) - set(members)
    if missing:
        raise ValueError(f"pair {key} lacks {', '.join(sorted(missing))}")
    meta = decode_meta(members["meta.json"])
    fields = decode_fields(members, [f for f, name in FIELDS.items() if name in members], meta)
    return Pair(key=key, meta=meta, **fields)


def decode_meta(data: bytes) -> dict:
    """The metadata of a pair; ValueError where they are not the contract's."""
    meta = parse_json(data)
    check_meta(meta)
    return meta


def decode_fields(
    members: Mapping[str, bytes], fields: Iterable[str], meta: Mapping
) -> dict[str, np.ndarray]:
    """Images of a pair by the names that `Pair` gives them.

    Args:
        members: {suffix: bytes}.
        fields: which, names in `FIELDS`; `visible` comes with the flow.
        meta: the pair's, which says how large they are.

    Raises:
        ValueError: one cannot be decoded, or is of another size.
        KeyError: there is no such file.
    """
    shape, images = (meta["height"], meta["width"]), {}
    for name in fields:
        file = FIELDS[name]
        try:
            image = _DECODERS[name](members[file])
        except ValueError as error:
            raise ValueError(f"{file} cannot be read: {error}") from None
        found = (image[0] if name == "flow" else image).shape[:2]
        if found != shape:
            raise ValueError(f"{file} is {found}, meta.json says {shape}")
        images[name] = image
    if "flow" in images:
        images["flow"], images["visible"] = images["flow"]
    return images


def check_meta(meta: Mapping) -> None:
    """Refuse metadata whose fields, types or shapes are not the contract's, with a ValueError."""
    if not isinstance(meta, Mapping):
        raise ValueError("meta.json is no table")
    if list(meta) != list(META_FIELDS):
        odd = sorted(set(meta) ^ set(META_FIELDS)) or "their order"
        raise ValueError(f"meta.json has other fields than the contract: {shown(odd)}")
    for name, kind in META_FIELDS.items():
        # bool is an int to Python and float("1") an int to JSON readers: compare exactly.
        if type(meta[name]) is not kind:
            raise ValueError(f"meta.json: {name} is {shown(meta[name])}, not a {kind.__name__}")
        if not _is_allowed(name, meta[name]):
            raise ValueError(
                f"meta.json: {name} is {shown(meta[name])}, which the contract forbids"
            )
    check_size(meta["width"], meta["height"])


def _is_allowed(name: str, value) -> bool:
    """Whether a value of the right type is one that a field may have."""
    if name == "split":
        return value in SPLITS
    if name == "map":
        return is_map_name(value)
    if isinstance(value, list):
        return _is_matrix(value, _SHAPES[name]) and (name != "intrinsics" or _is_camera(value))
    if isinstance(value, int):
        return 0 <= value < _MOST_WHOLE
    return isinstance(value, str) or math.isfinite(value)


def _is_matrix(value: list, shape: tuple[int, ...]) -> bool:
    """Whether these are so many finite numbers."""
    try:
        array = np.array(value)
    except ValueError:  # Rows of different lengths.
        return False
    return array.shape == shape and array.dtype.kind in "if" and bool(np.isfinite(array).all())


def _is_camera(intrinsics: list) -> bool:
    (fx, _, _), (_, fy, _), _ = intrinsics
    return fx > 0 and fy > 0


def encode_png(image: np.ndarray) -> bytes:
    """PNG bytes of an (H, W, 3) uint8 RGB image."""
    # Level 1 is 4 times faster than the default and 8 % larger on path-traced frames.
    bgr = cv2.cvtColor(image, cv2.COLOR_RGB2BGR)
    return cv2.imencode(".png", bgr, [cv2.IMWRITE_PNG_COMPRESSION, 1])[1].tobytes()


def decode_png(data: bytes) -> np.ndarray:
    """The (H, W, 3) uint8 RGB image of PNG bytes; ValueError where they are not one."""
    return cv2.cvtColor(decode_picture(data, cv2.IMREAD_COLOR), cv2.COLOR_BGR2RGB)


def decode_labels(data: bytes) -> np.ndarray:
    """The (H, W) uint8 labels of PNG bytes; ValueError where they are not 8-bit grey ones."""
    image = decode_picture(data, cv2.IMREAD_UNCHANGED)
    if image.ndim != 2 or image.dtype != np.uint8:
        raise ValueError("it is no 8-bit grey picture")
    return image


_DECODERS = {
    "rgb": decode_png,
    "prev": decode_png,
    "depth_m": decode_depth,
    "flow": decode_flow,
    "seg": decode_labels,
    "normal": decode_normal,
}
