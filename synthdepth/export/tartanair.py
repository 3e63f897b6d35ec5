"""Our datasets as TartanAir's first version lays them out: a folder for each trajectory.

Source: README.md and data_type.md of github.com/castacks/tartanair_tools.
"""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np

from synthdepth.airsim.ned import ned_line
from synthdepth.camera import Intrinsics, project, unproject
from synthdepth.dataset.folder import new_folder
from synthdepth.dataset.pair import Pair, encode_png
from synthdepth.export.folder import ExportReport, read_pairs, write_file

# Values of a flow mask: TartanAir's own, and one for what lies beyond the depth's range.
VALID, OCCLUDED, OUT_OF_VIEW, BEYOND = 0, 1, 100, 255
# A surface that is farther than the one seen by this share is hidden behind it.
_HIDDEN_SHARE = 0.01
_INFINITE_M = 1e9


def export_tartanair(
    folder: Path,
    out: Path,
    *,
    split: str | None = None,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
) -> ExportReport:
    """Write a dataset as TartanAir's first version has it.

    Each trajectory `<out>/<split>/<map>-s00012/Easy/P000/` is a burst: pairs of which each one's
    frame t-1 is frame t of the one before. It holds `image_left`, `depth_left` (float32 metres,
    planar), `seg_left` where there are labels, `flow` from each frame to the next with its mask,
    and `pose_left.txt`, a line `tx ty tz qx qy qz qw` a frame: the world is north-east-down, and
    the camera's x points forward, y right, z down. Frame t-1 of a burst's first pair has no depth
    and is left out.

    Args:
        folder: the dataset.
        out: a new or an empty folder.
        split: `train` or `test`; both without.
        on_progress: called with (pairs done, pairs in all).

    Raises:
        DatasetError: as `read_pairs` and `new_folder`.
    """
    numbers: dict[str, int] = {}
    pairs, before = 0, None
    with new_folder(out) as partial:
        for pair in read_pairs(folder, split=split, on_progress=on_progress):
            if before is None or not _follows(pair, before):
                environment = _environment(pair)
                number = numbers[environment] = numbers.get(environment, -1) + 1
                trajectory, frame = partial / environment / f"P{number:03d}", 0
            else:
                frame += 1
                name = f"{frame - 1:06d}_{frame:06d}"
                flow, mask = forward_flow(before, pair)
                _write_array(trajectory / "flow" / f"{name}_flow.npy", flow)
                _write_array(trajectory / "flow" / f"{name}_mask.npy", mask)
            _write_frame(trajectory, frame, pair)
            pairs, before = pairs + 1, pair
        notes = _notes(before.camera, before.meta["max_depth_m"])
        write_file(partial / "README.txt", "".join(f"{note}\n" for note in notes).encode())
    return ExportReport(folder=Path(out), pairs=pairs, notes=notes)


def _follows(pair: Pair, before: Pair) -> bool:
    same = all(pair.meta[name] == before.meta[name] for name in ("scene_index", "flight_index"))
    return same and pair.meta["world_from_cam_prev"] == before.meta["world_from_cam"]


def _environment(pair: Pair) -> str:
    """Folder of a scene's trajectories; ours are neither easy nor hard, but readers expect one."""
    return f"{pair.meta['split']}/{pair.meta['map']}-s{pair.meta['scene_index']:05d}/Easy"


def _write_frame(trajectory: Path, frame: int, pair: Pair) -> None:
    name = f"{frame:06d}_left"
    write_file(trajectory / "image_left" / f"{name}.png", encode_png(pair.rgb))
    _write_array(trajectory / "depth_left" / f"{name}_depth.npy", pair.depth_m)
    if pair.seg is not None:
        _write_array(trajectory / "seg_left" / f"{name}_seg.npy", pair.seg)
    line = " ".join(f"{value:.17g}" for value in ned_line(pair.world_from_cam))
    with open(trajectory / "pose_left.txt", "a") as file:
        file.write(line + "\n")


def _write_array(path: Path, image: np.ndarray) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    np.save(path, image)


def forward_flow(pair: Pair, after: Pair) -> tuple[np.ndarray, np.ndarray]:
    """Where each pixel of a frame is in the next, minus where it is now, as TartanAir made its own.

    That is: from depth and poses alone, as nothing moves but the camera. What lies beyond the
    depth's range moves as what is infinitely far does.

    Args:
        pair: the frame.
        after: the next.

    Returns:
        flow (H, W, 2) float32 [px], u right and v down; mask (H, W) uint8: `VALID`, or why not.
    """
    camera, beyond = pair.camera, pair.depth_m >= np.float32(pair.meta["max_depth_m"])
    far_m = np.where(beyond, _INFINITE_M, pair.depth_m)
    to, depth_m = project(
        unproject(far_m, camera, pair.world_from_cam), camera, after.world_from_cam
    )
    behind = ~(depth_m > 0)
    to = np.where(behind[..., None], 0, to)
    v, u = np.mgrid[: camera.height, : camera.width]
    # A picture ends half a pixel beyond its outermost centres.
    inside = (to >= -0.5) & (to < [camera.width - 0.5, camera.height - 0.5])
    # The farthest of the four pixels around, as a slanted surface lies between them.
    farthest = cv2.dilate(after.depth_m, np.ones((2, 2), np.uint8), anchor=(0, 0))
    x, y = (
        np.clip(to[..., k], 0, n - 1).astype(int)
        for k, n in enumerate((camera.width, camera.height))
    )
    mask = np.full(beyond.shape, VALID, np.uint8)
    mask[depth_m > (1 + _HIDDEN_SHARE) * farthest[y, x]] = OCCLUDED
    mask[beyond] = BEYOND
    mask[~inside.all(axis=-1) | behind] = OUT_OF_VIEW
    flow = np.where(behind[..., None], 0, to - np.stack([u, v], axis=-1))
    return flow.astype(np.float32), mask


def _notes(camera: Intrinsics, max_depth_m: float) -> tuple[str, ...]:
    return (
        "each folder of a split is a root as TartanAir's readers expect it; a scene is an "
        "environment, a burst of consecutive frames a trajectory, and all are called Easy",
        f"the camera is {camera.width}x{camera.height}, fx = {camera.fx:.6g}, "
        f"fy = {camera.fy:.6g}, cx = {camera.cx:.6g}, cy = {camera.cy:.6g} with the first pixel's "
        "centre at (0, 0): readers with TartanAir's own numbers (640x480, 320, 320, 320, 240) must "
        "be told",
        "pose_left.txt: tx ty tz qx qy qz qw, world north-east-down, camera x forward, y right, z "
        "down",
        f"depth saturates at {max_depth_m:g} m, the sky too, where TartanAir has larger numbers",
        f"flow masks: {VALID} valid, {OCCLUDED} occluded, {OUT_OF_VIEW} out of view, {BEYOND} "
        "beyond the depth's range, where the flow is that of what is infinitely far",
        "only left images: there is no second camera",
    )
