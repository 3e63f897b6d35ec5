"""AirSim's settings.json: the cameras in it.

Source: docs/settings.md and AirLib/include/common/AirSimSettings.hpp of AirSim 1.8.
"""

import dataclasses
import json
import math
import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from synthdepth.airsim.ned import mounted
from synthdepth.camera import Intrinsics
from synthdepth.errors import DatasetError

# AirSim's defaults, which hold for what a capture leaves out.
WIDTH_PX, HEIGHT_PX, FOV_DEG = 256, 144, 90.0
SCENE, DEPTH_PLANAR, DEPTH_PERSPECTIVE = 0, 1, 2

# The cameras that every vehicle has, by the names and the older numbers that AirSim knows them by.
_BUILT_IN = {
    "front_center": "0", "front_right": "1", "front_left": "2", "bottom_center": "3", "fpv": "3",
    "back_center": "4",
}  # fmt: skip
# A string or comment without an end goes to the end of the file: no place of it is looked at twice.
_STRING = r'"(?:\\.|[^"\\])*+\\?(?:"|\Z)'
_STRING_OR_COMMENT = re.compile(_STRING + r"|//[^\n]*|/\*.*?(?:\*/|\Z)", re.DOTALL)
_STRING_OR_COMMA = re.compile(_STRING + r"|,(?=\s*[}\]])", re.DOTALL)


@dataclasses.dataclass(frozen=True, kw_only=True)
class AirSimCamera:
    """One camera of settings.json, as it captures one type of image.

    Attributes:
        width: [px].
        height: [px].
        fov_deg: horizontal field of view.
        position_m: (x, y, z) on the vehicle, forward, right, down; None where the file leaves any
            of it to the vehicle.
        angles_deg: (pitch, roll, yaw) on the vehicle; None likewise.
        stabilised: a gimbal turns it, so that its attitude is not the vehicle's.
    """

    width: int = WIDTH_PX
    height: int = HEIGHT_PX
    fov_deg: float = FOV_DEG
    position_m: tuple[float, float, float] | None = None
    angles_deg: tuple[float, float, float] | None = None
    stabilised: bool = False

    @property
    def intrinsics(self) -> Intrinsics:
        """The pinhole that it is."""
        return Intrinsics.from_fov(self.width, self.height, self.fov_deg)

    @property
    def vehicle_from_camera(self) -> np.ndarray:
        """Its pose on the vehicle, (4, 4) float64 in body axes; 0 for what is not known."""
        pitch, roll, yaw = self.angles_deg or (0.0, 0.0, 0.0)
        position = np.array(self.position_m or (0.0, 0.0, 0.0))
        return mounted(position, pitch_deg=pitch, roll_deg=roll, yaw_deg=yaw)


def camera_from_settings(
    path: Path,
    camera_name: str | None = None,
    *,
    vehicle: str | None = None,
    image_type: int = SCENE,
) -> AirSimCamera:
    """A camera of a settings.json.

    Comments, commas at the end of a list, NaN and missing values are understood as AirSim's
    documentation means them.

    Args:
        path: the file.
        camera_name: as AirSim knows it, e.g. "front_center" or "0"; without it the file's cameras
            must agree in size and field of view.
        vehicle: whose camera; of any without it.
        image_type: AirSim's number: 0 is the picture, 1 planar depth, 2 depth along the ray.

    Raises:
        DatasetError: the file cannot be read, a value is not allowed, or there is no such camera.
    """
    root = _read(Path(path))
    defaults = _table(path, root, "CameraDefaults")
    tables = {
        (owner, name): table
        for owner, settings in _tables(path, root, "Vehicles").items()
        for name, table in _tables(path, settings, "Cameras").items()
        if vehicle in (None, owner)
    }
    cameras = {key: _camera(path, (defaults, table), image_type) for key, table in tables.items()}
    plain = _camera(path, (defaults,), image_type)
    if camera_name is None:
        # Every camera takes pictures, but one that says nothing of depth is not one that takes it.
        saying = [key for key in tables if _captures(path, tables[key], image_type)]
        asked = tables if image_type == SCENE else saying or tables
        found = [cameras[key] for key in asked] or [plain]
        if len({(camera.width, camera.height, camera.fov_deg) for camera in found}) > 1:
            names = ", ".join(sorted({name for _, name in cameras}))
            raise DatasetError(f"{path} has cameras that differ: name one of {names}")
        return found[0]
    wanted = _names(camera_name)
    for (_, name), camera in cameras.items():
        if _names(name) & wanted:
            return camera
    known = {name for _, name in cameras} | _BUILT_IN.keys() | set(_BUILT_IN.values()) | {""}
    if camera_name not in known:
        raise DatasetError(f"{path} has no camera {camera_name!r}: there are {_listed(known)}")
    return plain


def _names(name: str) -> set[str]:
    """The name of a camera and the number that stands for the same one."""
    return {name, _BUILT_IN.get(name, name)} | ({"0"} if name == "" else set())


def _listed(names: set[str]) -> str:
    return ", ".join(sorted(names - {""}))


def _read(path: Path) -> Mapping:
    try:
        text = path.read_text(encoding="utf-8-sig")
        for pattern in (_STRING_OR_COMMENT, _STRING_OR_COMMA):
            text = pattern.sub(lambda found: found[0] if found[0][0] == '"' else " ", text)
        root = json.loads(text)
    except OSError as error:
        raise DatasetError(f"{path} cannot be read: {error.strerror or error}") from error
    except (ValueError, RecursionError) as error:
        raise DatasetError(f"{path} is not JSON: {error}") from error
    if not isinstance(root, Mapping):
        raise DatasetError(f"{path} is not AirSim's settings: it holds no table")
    return root


def _table(path: Path, parent: Mapping, name: str) -> Mapping:
    table = parent.get(name) or {}
    if not isinstance(table, Mapping):
        raise DatasetError(f"{path}: {name} is {table!r}: allowed is a table")
    return table


def _tables(path: Path, parent: Mapping, name: str) -> dict[str, Mapping]:
    return {
        key: _table(path, _table(path, parent, name), key) for key in _table(path, parent, name)
    }


def _camera(path: Path, layers: tuple[Mapping, ...], image_type: int) -> AirSimCamera:
    """The camera of CameraDefaults and of what a vehicle sets over them."""
    capture: Mapping = {}
    values: dict = {}
    gimbal: Mapping = {}
    for layer in layers:
        # An entry replaces the default's whole: what it leaves out is AirSim's own default.
        capture = (_captures(path, layer, image_type) or [capture])[-1]
        gimbal = _table(path, layer, "Gimbal") or gimbal
        for name in ("X", "Y", "Z", "Pitch", "Roll", "Yaw"):
            if name in layer and not _is_nan(layer[name]):
                values[name] = _number(path, layer, name, 0.0, -1e6, 1e6)
    width = _number(path, capture, "Width", WIDTH_PX, 1, 16_384)
    height = _number(path, capture, "Height", HEIGHT_PX, 1, 16_384)
    place, angles = ("X", "Y", "Z"), ("Pitch", "Roll", "Yaw")
    return AirSimCamera(
        width=int(width),
        height=int(height),
        fov_deg=_number(path, capture, "FOV_Degrees", FOV_DEG, 1, 179),
        position_m=tuple(values[n] for n in place) if values.keys() >= set(place) else None,
        angles_deg=tuple(values[n] for n in angles) if values.keys() >= set(angles) else None,
        stabilised=_number(path, gimbal, "Stabilization", 0.0, 0, 1) > 0,
    )


def _captures(path: Path, layer: Mapping, image_type: int) -> list[Mapping]:
    captures = layer.get("CaptureSettings") or []
    if not isinstance(captures, list) or not all(isinstance(c, Mapping) for c in captures):
        raise DatasetError(f"{path}: CaptureSettings is {captures!r}: allowed is a list of tables")
    return [capture for capture in captures if capture.get("ImageType", SCENE) == image_type]


def _is_nan(value) -> bool:
    return isinstance(value, float) and math.isnan(value)


def _number(
    path: Path, table: Mapping, name: str, default: float, low: float, high: float
) -> float:
    value = table.get(name, default)
    if _is_nan(value):
        return float(default)
    right = isinstance(value, int | float) and not isinstance(value, bool)
    whole = isinstance(default, int)
    if not right or not low <= value <= high or (whole and value != int(value)):
        kind = "a whole number" if whole else "a number"
        raise DatasetError(
            f"{path}: {name} = {value!r}: allowed is {kind} from {low:g} to {high:g}"
        )
    return float(value)
