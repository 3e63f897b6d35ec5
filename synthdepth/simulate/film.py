"""A flight as a video: the camera's picture, the depth that was seen, and the flight from above."""

import os
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from PIL import Image, ImageDraw, ImageFont

from synthdepth.dataset.preview import colour_depth
from synthdepth.dataset.shard import PARTIAL, write_error
from synthdepth.errors import SynthdepthError
from synthdepth.simulate.relief import map_picture
from synthdepth.simulate.replay import Frame, Replay
from synthdepth.simulate.sections import SECTIONS
from synthdepth.simulate.survey import PIXEL_M, TopView
from synthdepth.simulate.tables import ended

_STRIP_PX, _GAP_PX = 64, 8
_HOLD_S = 1.5  # that the last picture stays
_BACK, _TEXT, _SOFT = (16, 20, 24), (236, 239, 242), (150, 160, 170)
_FLOWN, _AHEAD, _CRASH, _GOAL = (214, 69, 20), (150, 140, 130), (200, 20, 30), (20, 120, 60)
_CHOSEN = (255, 255, 255)
_SHIFT = 4  # binary places of drawn coordinates


def write_film(
    replay: Replay,
    out: Path,
    on_progress: Callable[[int, int], None] = lambda done, total: None,
    *,
    panel_px: int = 432,
) -> int:
    """Fly a flight again and write its video; returns the number of its frames.

    Args:
        replay: the flight.
        out: the file, which ends in .mp4: VP9, at the speed of life.
        on_progress: called with (frames done, frames recorded).
        panel_px: width of each of its three pictures, an even number.

    Raises:
        SynthdepthError: OpenCV cannot write such a video here.
        DatasetError: the flight was not as recorded, or the file cannot be written.
    """
    out = Path(out)
    # OpenCV knows the kind by the end of the name.
    partial = out.with_name(f"{out.stem}.{os.getpid()}{PARTIAL}.mp4")
    rate = 1 / replay.rules.drone.frame_interval_s
    total, pictures = len(replay.recorded.track_m), _Pictures(replay, panel_px)
    writer = cv2.VideoWriter()
    try:
        partial.touch()

        def add(frame: Frame) -> None:
            picture = pictures.draw(frame)
            _write(writer, partial, picture, rate)
            on_progress(frame.number + 1, total)

        replay.fly(add)
        last = pictures.last()
        for _ in range(max(1, round(_HOLD_S * rate))):
            _write(writer, partial, last, rate)
        writer.release()
        if not partial.stat().st_size:
            raise SynthdepthError(f"cannot write {out}: OpenCV wrote nothing; is the disk full?")
        os.replace(partial, out)
    except OSError as error:
        raise write_error(out, error) from error
    finally:
        writer.release()
        partial.unlink(missing_ok=True)
    return total


def _write(writer: cv2.VideoWriter, path: Path, picture: np.ndarray, rate: float) -> None:
    if not writer.isOpened():
        height, width = picture.shape[:2]
        writer.open(
            str(path), cv2.CAP_FFMPEG, cv2.VideoWriter.fourcc(*"vp09"), rate, (width, height)
        )
        if not writer.isOpened():
            raise SynthdepthError("OpenCV writes no VP9 video here: write a .rrd file instead")
    writer.write(cv2.cvtColor(picture, cv2.COLOR_RGB2BGR))


class _Pictures:
    """The video's pictures."""

    def __init__(self, replay: Replay, panel_px: int):
        self._panel_px = panel_px
        self._left_px = [_GAP_PX + k * (panel_px + _GAP_PX) for k in range(3)]
        self._flight, self._range_m = replay.recorded, replay.max_depth_m
        self._goal_radius_m = replay.rules.scenario.goal_radius_m
        way = np.array([*self._flight.track_m, self._flight.end_m])
        around = np.concatenate([way, [self._flight.start_m, self._flight.goal_m]])[:, :2]
        self._middle = (around.min(axis=0) + around.max(axis=0)) / 2
        span_m = max(1.2 * float(np.ptp(around, axis=0).max()), 60.0)
        self._scale = self._panel_px / span_m  # px/m
        self._land = self._cropped(replay.scene.view)
        self._way = way
        self._frame: Frame | None = None

    def draw(self, frame: Frame) -> np.ndarray:
        """The picture of a frame, (H, W, 3) uint8 RGB."""
        self._frame = frame
        left = np.array(self._flight.goal_m) - frame.world_from_cam[:3, 3]
        return self._composed(self._map(frame.number), f"{np.hypot(*left[:2]):.0f} m to the goal")

    def last(self) -> np.ndarray:
        """The picture of how it ended."""
        land = self._map(len(self._way) - 1)
        if self._flight.end == "collision":
            at = self._on_map(self._way[-1:])[0]
            for arm in ([9, 9], [9, -9]):
                _line(land, np.array([at - arm, at + arm]), _CRASH, 4)
        return self._composed(land, ended(self._flight))

    def _composed(self, land: np.ndarray, said: str) -> np.ndarray:
        frame, flight = self._frame, self._flight
        panels = (self._fitted(frame.rgb, cv2.INTER_CUBIC), self._depth(frame), land)
        height = max(map(len, panels))
        width = self._left_px[-1] + self._panel_px + _GAP_PX
        sheet = np.full((_STRIP_PX + height + _GAP_PX, width, 3), _BACK, np.uint8)
        for panel, x in zip(panels, self._left_px, strict=True):
            y = _STRIP_PX + (height - len(panel)) // 2
            sheet[y : y + len(panel), x : x + self._panel_px] = panel
        image = Image.fromarray(sheet[: len(sheet) // 2 * 2])  # VP9 wants even sides
        draw = ImageDraw.Draw(image)
        title = (
            f"{flight.map}, scene {flight.scene_index}, scenario {flight.scenario}, "
            f"flown by {flight.source}"
        )
        draw.text((_GAP_PX, 8), title, fill=_TEXT, font=ImageFont.load_default(20))
        notes = (
            f"{frame.time_s:.1f} s, {np.linalg.norm(frame.velocity_mps):.1f} m/s, "
            f"{frame.altitude_m:.1f} m above ground",
            f"depth to {self._range_m:g} m; the square is flown to",
            said,
        )
        for note, x in zip(notes, self._left_px, strict=True):
            draw.text((x, 37), note, fill=_SOFT, font=ImageFont.load_default(17))
        return np.asarray(image)

    def _depth(self, frame: Frame) -> np.ndarray:
        """The depth in colours with the section that is flown to."""
        depth = np.nan_to_num(frame.depth_m, nan=self._range_m)
        picture = self._fitted(colour_depth(depth, self._range_m), cv2.INTER_NEAREST)
        cell = np.array(picture.shape[1::-1]) / (SECTIONS + 1)
        low = np.array(frame.section[::-1]) * cell
        (x, y), (u, v) = np.rint([low, low + 2 * cell]).astype(int).tolist()
        cv2.rectangle(picture, (x, y), (u, v), (0, 0, 0), 5)
        cv2.rectangle(picture, (x, y), (u, v), _CHOSEN, 2)
        return picture

    def _map(self, number: int) -> np.ndarray:
        """The flight from above up to a frame."""
        land = self._land.copy()
        (x, y), goal = (self._on_map([p])[0] for p in (self._way[0], self._flight.goal_m))
        _line(land, self._on_map(self._way), _AHEAD, 1)
        _circle(land, goal, self._goal_radius_m * self._scale, _GOAL, 2)
        _circle(land, np.array([x, y]), 4.0, (30, 30, 30), 2)
        _line(land, self._on_map(self._way[: number + 1]), _FLOWN, 3)
        here = self._way[number]
        forward = self._frame.world_from_cam[:2, 2]
        ahead = forward / max(float(np.linalg.norm(forward)), 1e-9) * [1, -1]
        side, at = np.array([-ahead[1], ahead[0]]), self._on_map([here])[0]
        arrow = at + np.array([11 * ahead, -7 * ahead + 6 * side, -7 * ahead - 6 * side])
        points = np.rint(arrow * 2**_SHIFT).astype(np.int32)
        cv2.fillPoly(land, [points], _FLOWN, cv2.LINE_AA, _SHIFT)
        return land

    def _on_map(self, points) -> np.ndarray:
        points = np.asarray(points, float)[:, :2]
        return self._panel_px / 2 + (points - self._middle) * [self._scale, -self._scale]

    def _fitted(self, picture: np.ndarray, how: int) -> np.ndarray:
        height = round(self._panel_px * picture.shape[0] / picture.shape[1])
        return cv2.resize(picture, (self._panel_px, height), interpolation=how)

    def _cropped(self, view: TopView) -> np.ndarray:
        zoom = self._scale * PIXEL_M
        how = cv2.INTER_LINEAR if zoom > 1 else cv2.INTER_AREA
        picture = cv2.resize(map_picture(view), None, fx=zoom, fy=zoom, interpolation=how)
        x, y = self._on_map([[view.low_m[0], view.high_m[1]]])[0]
        size = (self._panel_px, self._panel_px)
        return cv2.warpAffine(picture, np.array([[1.0, 0, x], [0, 1, y]]), size, borderValue=_BACK)


def _line(picture: np.ndarray, way: np.ndarray, colour: tuple, width: int) -> None:
    points = np.rint(way * 2**_SHIFT).astype(np.int32)
    cv2.polylines(picture, [points], False, colour, width, cv2.LINE_AA, _SHIFT)


def _circle(picture: np.ndarray, at: np.ndarray, radius: float, colour: tuple, width: int) -> None:
    x, y = np.rint(at * 2**_SHIFT).astype(int).tolist()
    cv2.circle(picture, (x, y), round(radius * 2**_SHIFT), colour, width, cv2.LINE_AA, _SHIFT)
