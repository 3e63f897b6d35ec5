"""A simulated flight, flown again, as a Rerun recording.

Under `/world`: `surfaces` (points of the true geometry around the flight, a colour a class), `way`
(as flown), `start` and `goal`, `camera` (pose and picture), `seen` (the same pose with the depth
that the source said, and the `section` that was flown to). `/plots` has curves. Timelines: `frame`
and `time_s`. Needs Rerun to be imported.
"""

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from synthdepth.camera import Intrinsics
from synthdepth.dataset.pair import encode_png
from synthdepth.dataset.preview import colour_labels
from synthdepth.dataset.shard import PARTIAL, write_error
from synthdepth.simulate.outcome import Outcome
from synthdepth.simulate.replay import Frame, Replay
from synthdepth.simulate.sections import SECTIONS
from synthdepth.simulate.surface import surface_points
from synthdepth.simulate.tables import ended
from synthdepth.view.recording import check_whole
from synthdepth.view.rerun_log import pinhole, transform

_AROUND_M = 30.0  # of the flight whose surfaces are recorded
_SPACING_M = 0.5
_WAY, _GOAL, _CHOSEN = (255, 140, 0), (40, 160, 80), (255, 255, 255)


def write_flight_recording(
    replay: Replay, out: Path, on_progress: Callable[[int, int], None] = lambda done, total: None
) -> int:
    """Fly a flight again and write its recording; returns the number of its frames.

    Args:
        replay: the flight.
        out: the file, which ends in .rrd: about 8 MB of surfaces, and 0.2 MB a frame of 256x256.
        on_progress: called with (frames done, frames recorded).

    Raises:
        DatasetError: the flight was not as recorded, or the file cannot be written.
    """
    out = Path(out)
    partial = out.with_name(f"{out.name}.{os.getpid()}{PARTIAL}")
    total = len(replay.recorded.track_m)
    try:
        partial.touch()
        stream = rr.RecordingStream("synthdepth")
        # What counts is the flight's time, not when this was written.
        stream.set_log_time_enabled(False)
        stream.set_log_tick_enabled(False)
        # Before anything is logged: what comes earlier is not in the file.
        stream.save(partial, default_blueprint=_blueprint())
        try:
            _log_place(stream, replay)

            def add(frame: Frame) -> None:
                _log_frame(stream, replay, frame)
                on_progress(frame.number + 1, total)

            replay.fly(add)
        finally:
            stream.disconnect()
        check_whole(partial, out)
        os.replace(partial, out)
    except OSError as error:
        raise write_error(out, error) from error
    finally:
        partial.unlink(missing_ok=True)
    return total


def _log_place(stream: rr.RecordingStream, replay: Replay) -> None:
    """All that does not move."""
    flight = replay.recorded
    stream.send_recording_name(f"{flight.map}, scene {flight.scene_index}: {flight.source}")
    way = np.array([*flight.track_m, flight.end_m])
    points, colours = _surfaces(replay, way)
    size = rr.Radius.ui_points(2.0)
    for entity, what in {
        "world": rr.ViewCoordinates.RIGHT_HAND_Z_UP,
        "world/surfaces": rr.Points3D(points, colors=colours, radii=_SPACING_M / 2),
        "world/way": rr.LineStrips3D([way], colors=_WAY, radii=size),
        "world/start": rr.Points3D([flight.start_m], colors=_WAY, radii=0.5, labels=["start"]),
        "world/goal": rr.Points3D([flight.goal_m], colors=_GOAL, radii=0.5, labels=["goal"]),
        "flight": rr.TextDocument(_about(flight), media_type="text/markdown"),
    }.items():
        stream.log(entity, what, static=True, strict=True)


def _surfaces(replay: Replay, way: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) float32 [m] of what is around a way, one a small cube, and their colours."""
    mesh = replay.scene.place.mesh
    low, high = way.min(axis=0) - _AROUND_M, way.max(axis=0) + _AROUND_M
    points, triangles = [np.zeros((0, 3), np.float32)], [np.zeros(0, np.int64)]
    for some, which in surface_points(mesh.triangles, low, high, _SPACING_M):
        points.append(some)
        triangles.append(which)
    points, triangles = np.concatenate(points), np.concatenate(triangles)
    x, y, z = ((points - low) / _SPACING_M).astype(np.int64).T
    chosen = np.unique((x << 40) | (y << 20) | z, return_index=True)[1]
    return points[chosen], colour_labels(mesh.labels[triangles[chosen]][None])[0]


def _log_frame(stream: rr.RecordingStream, replay: Replay, frame: Frame) -> None:
    camera = replay.scene.place.eyes.camera
    stream.set_time("frame", sequence=frame.number)
    stream.set_time("time_s", duration=frame.time_s)
    height, width = frame.depth_m.shape
    pose = transform(frame.world_from_cam)
    side = np.array([width, height]) / (SECTIONS + 1)
    box = rr.Boxes2D(array=[[*side * frame.section[::-1], *2 * side]],
                     array_format=rr.Box2DFormat.XYWH, colors=[_CHOSEN])  # fmt: skip
    span = (0.0, replay.max_depth_m)
    goal = np.array(replay.recorded.goal_m) - frame.world_from_cam[:3, 3]
    for entity, what in (
        ("world/camera", pose),
        ("world/camera", pinhole(camera)),
        ("world/camera/picture",
         rr.EncodedImage(contents=encode_png(frame.rgb), media_type="image/png")),
        ("world/seen", pose),
        ("world/seen", pinhole(_resized(camera, width, height))),
        ("world/seen/depth",
         rr.DepthImage(frame.depth_m, meter=1.0, colormap="viridis", depth_range=span)),
        ("world/seen/section", box),
        ("plots/speed_mps", rr.Scalars(float(np.linalg.norm(frame.velocity_mps)))),
        ("plots/altitude_m", rr.Scalars(frame.altitude_m)),
        ("plots/goal_m", rr.Scalars(float(np.hypot(*goal[:2])))),
    ):  # fmt: skip
        stream.log(entity, what, strict=True)


def _resized(camera: Intrinsics, width: int, height: int) -> Intrinsics:
    """The camera of the same picture with other pixels."""
    x, y = width / camera.width, height / camera.height
    return Intrinsics(
        width=width,
        height=height,
        fx=camera.fx * x,
        fy=camera.fy * y,
        cx=(camera.cx + 0.5) * x - 0.5,
        cy=(camera.cy + 0.5) * y - 0.5,
    )


def _about(flight: Outcome) -> str:
    facts = {
        "map": flight.map,
        "scene": f"{flight.scene_index} (seed {flight.scene_seed})",
        "scenario": flight.scenario,
        "ended": ended(flight),
        "way": f"{flight.way_m:.1f} m",
        "shortest way": "none found" if flight.shortest_m is None else f"{flight.shortest_m:.1f} m",
        "clearance": f"{flight.clearance_m:.2f} m",
    }
    rows = "\n".join(f"| {name} | {value} |" for name, value in facts.items())
    return f"`{flight.source}`\n\n| | |\n|---|---|\n{rows}\n"


def _blueprint() -> rrb.Blueprint:
    """The world, both pictures beside it, curves and facts below."""
    # In 3D neither the depth's own points nor its picture: they would lie over the surfaces.
    world = rrb.Spatial3DView(
        origin="/world", contents=["+ /world/**", "- /world/seen/**"], name="world"
    )
    pictures = [
        rrb.Spatial2DView(origin="/world/camera", name="picture"),
        rrb.Spatial2DView(origin="/world/seen", name="depth seen"),
    ]
    curves = rrb.TimeSeriesView(origin="/plots", name="flight")
    facts = rrb.TextDocumentView(origin="/flight", name="facts")
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(world, rrb.Vertical(*pictures), column_shares=[3, 2]),
            rrb.Horizontal(curves, facts, column_shares=[3, 2]),
            row_shares=[3, 1],
        ),
        rrb.TimePanel(timeline="time_s", state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )
