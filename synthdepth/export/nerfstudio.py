"""Our flights for nerfstudio: a `transforms.json` each, with pictures and depth.

Source: docs/quickstart/data_conventions.md, nerfstudio_dataparser.py and data_utils.py of
github.com/nerfstudio-project/nerfstudio at 1.1.5.
"""

import itertools
import json
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np

from synthdepth.dataset.folder import new_folder
from synthdepth.dataset.pair import Pair, encode_png
from synthdepth.export.folder import ExportReport, read_pairs, write_file

# OpenGL's camera looks along -z with y up, OpenCV's along z with y down.
OPENCV_FROM_OPENGL = np.diag([1.0, -1, -1, 1])
_MM_PER_M = 1000.0

NOTES = (
    "to keep metres, train with `nerfstudio-data --center-method none --auto-scale-poses False`: "
    "by default nerfstudio centres the poses and scales them and the depth together",
    "depth is in .npy files, float32 millimetres, planar, as nerfstudio's depth_unit_scale_factor "
    "of 0.001 expects: 16-bit PNG would end at 65.535 m; 0 is unknown, which here is what lies at "
    "or beyond the dataset's range",
    "a flight is one folder, as pictures of one flight share a camera's faults; its bursts lie "
    "apart: a dataset for reconstruction is better rendered with long bursts",
    "cx and cy are ours plus 0.5: nerfstudio's first pixel has its centre at (0.5, 0.5)",
)


def export_nerfstudio(
    folder: Path,
    out: Path,
    *,
    split: str | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> ExportReport:
    """Write each flight of a dataset as nerfstudio reads it.

    `<out>/<split>/<map>-s00012-f003/` holds `transforms.json`, `images/0045.png` and
    `depths/0045.npy` (H, W) float32 [mm], planar, 0 where the depth saturates. Poses are
    camera-to-world in OpenGL's axes; the world is ours, in metres with Z up.

    Args:
        folder: the dataset.
        out: a new or an empty folder.
        split: `train` or `test`; both without.
        on_progress: called with (pairs done, pairs in all).

    Raises:
        DatasetError: as `read_pairs` and `new_folder`.
    """
    pairs = 0
    with new_folder(out) as partial:
        of_split = read_pairs(folder, split=split, on_progress=on_progress)
        for name, flight in itertools.groupby(of_split, key=_flight_name):
            pairs += _write_flight(partial / name, flight)
        write_file(partial / "README.txt", "".join(f"{note}\n" for note in NOTES).encode())
    return ExportReport(folder=Path(out), pairs=pairs, notes=NOTES)


def _flight_name(pair: Pair) -> str:
    return f"{pair.meta['split']}/{pair.key.rpartition('-')[0]}"


def _write_flight(folder: Path, flight: Iterable[Pair]) -> int:
    """Write a flight; returns how many pairs it has."""
    frames = []
    for pair in flight:
        name = f"{pair.meta['frame_index']:04d}"
        image, depth = f"images/{name}.png", f"depths/{name}.npy"
        write_file(folder / image, encode_png(pair.rgb))
        (folder / depth).parent.mkdir(exist_ok=True)
        np.save(folder / depth, _millimetres(pair))
        pose = pair.world_from_cam @ OPENCV_FROM_OPENGL
        frames.append(
            {"file_path": image, "depth_file_path": depth, "transform_matrix": pose.tolist()}
        )
    camera = pair.camera
    transforms = {
        "camera_model": "OPENCV",
        "w": camera.width,
        "h": camera.height,
        "fl_x": camera.fx,
        "fl_y": camera.fy,
        "cx": camera.cx + 0.5,
        "cy": camera.cy + 0.5,
        "k1": 0.0,
        "k2": 0.0,
        "p1": 0.0,
        "p2": 0.0,
        # The world stays upright, and no transform lies between these poses and the dataset's.
        "orientation_override": "none",
        "applied_transform": np.eye(4)[:3].tolist(),
        "frames": frames,
    }
    write_file(folder / "transforms.json", json.dumps(transforms, indent=1).encode() + b"\n")
    return len(frames)


def _millimetres(pair: Pair) -> np.ndarray:
    beyond = pair.depth_m >= np.float32(pair.meta["max_depth_m"])
    return np.where(beyond, np.float32(0), pair.depth_m * np.float32(_MM_PER_M))
