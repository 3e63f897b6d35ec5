"""What a recording holds, in Rerun's terms. The only module that needs Rerun to be imported.

Every scene is a world of its own, under `/world` while its pairs are shown: `flights` (paths of the
whole scene), `camera` and `camera_prev` (poses with their pictures), `points` (what the depth says,
in the colours of frame t, without what is saturated). `/plots` has curves, `/pair` the metadata.
The timeline `pair` counts all pairs; each flight has one of its own besides, in seconds.

Facts of Rerun that this relies on: an image spans [0, width], so a pixel's centre is at .5 and our
principal point gets half a pixel; `Transform3D` is parent-from-child, and a log replaces all of it;
times that were set go on until `reset_time`.
"""

from collections.abc import Collection, Mapping, Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from synthdepth.camera import Intrinsics, unproject
from synthdepth.dataset.pair import camera_of, encode_png
from synthdepth.dataset.pairs import PairDataset
from synthdepth.dataset.preview import colour_flow, colour_labels
from synthdepth.dataset.sample import Sample
from synthdepth.view.flights import Flight
from synthdepth.view.pictures import colour_normal

_CURRENT, _OTHER = (255, 140, 0), (110, 130, 160)
_PLOTS = ("altitude_m", "speed_mps", "nearest_depth_m")
_HALF_PIXEL = np.array([[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])


def log_pairs(
    path: Path,
    manifest: Mapping,
    pairs: PairDataset,
    flights: Sequence[Flight],
    chosen: Sequence[tuple[Flight, int]],
) -> None:
    """Write a recording.

    Args:
        path: the file.
        manifest: the dataset's.
        pairs: the dataset's, in the order of its index.
        flights: all of the dataset.
        chosen: the flight and the row of every pair that is recorded; a flight's pairs together.
    """
    stream = rr.RecordingStream("synthdepth")
    # What counts is the frame's time, not when this was written.
    stream.set_log_time_enabled(False)
    stream.set_log_tick_enabled(False)
    # Before anything is logged: what comes earlier is not in the file.
    stream.save(path, default_blueprint=_blueprint(pairs.fields))
    try:
        stream.send_recording_name(f"{manifest.get('map')}, seed {manifest.get('seed')}")
        stream.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
        if manifest.get("labels"):
            stream.log("world", _annotations(manifest["labels"]), static=True)
        before = None
        for number, (flight, row) in enumerate(chosen):
            sample = pairs[row]
            if flight is not before:
                stream.reset_time()
            stream.set_time("pair", sequence=number)
            stream.set_time(f"time_s {flight.name}", duration=sample.meta["time_s"])
            if flight is not before:
                _log_paths(stream, flight, [f for f in flights if f.scene == flight.scene])
            for entity, what in _entities(sample):
                stream.log(entity, what, strict=True)
            before = flight
    finally:
        stream.disconnect()


def _annotations(labels: Mapping[str, int]) -> rr.AnnotationContext:
    names = {number: name for name, number in labels.items()}
    colours = colour_labels(np.array([list(names)], np.uint8))[0]
    return rr.AnnotationContext(
        [
            (number, names[number], tuple(c.tolist()))
            for number, c in zip(names, colours, strict=True)
        ]
    )


def _log_paths(stream, current: Flight, of_scene: Sequence[Flight]) -> None:
    """Paths of all flights of the scene: runs of frames, and thinly what lies between them."""
    for name, radius in (("runs", 2.0), ("gaps", 0.5)):
        strips, colours = [], []
        for flight in of_scene:
            found = list(getattr(flight, name)())
            strips += found
            colours += [_CURRENT if flight is current else _OTHER] * len(found)
        lines = rr.LineStrips3D(strips, colors=colours, radii=rr.Radius.ui_points(radius))
        stream.log(f"world/flights/{name}", lines, strict=True)


def _entities(sample: Sample):
    """Entity and content of everything that belongs to one pair."""
    camera = camera_of(sample.meta)
    for entity, pose, picture in (
        ("world/camera", sample.world_from_cam, sample.rgb),
        ("world/camera_prev", sample.world_from_cam_prev, sample.prev),
    ):
        yield entity, transform(pose)
        yield entity, pinhole(camera)
        png = encode_png(picture)
        yield f"{entity}/picture", rr.EncodedImage(contents=png, media_type="image/png")
    yield "world/chase", transform(_heading(sample.world_from_cam))

    span = (0.0, sample.max_depth_m)
    depth = rr.DepthImage(sample.depth_m, meter=1.0, colormap="viridis", depth_range=span)
    yield "world/camera/depth", depth
    yield "world/points", _points(sample, camera)
    if sample.flow is not None:
        yield "world/camera/flow", rr.Image(colour_flow(sample.flow))
    if sample.seg is not None:
        yield "world/camera/labels", rr.SegmentationImage(sample.seg)
    if sample.normal is not None:
        yield "world/camera/normals", rr.Image(colour_normal(sample.normal))
    for name in _PLOTS:
        yield f"plots/{name}", rr.Scalars(sample.meta[name])
    yield "pair", rr.TextDocument(_about(sample), media_type="text/markdown")


def transform(world_from: np.ndarray) -> rr.Transform3D:
    """A pose, (4, 4), for Rerun."""
    return rr.Transform3D(mat3x3=world_from[:3, :3], translation=world_from[:3, 3])


def pinhole(camera: Intrinsics) -> rr.Pinhole:
    """A camera for Rerun, whose pixels begin where ours have their centres."""
    return rr.Pinhole(
        image_from_camera=camera.matrix + _HALF_PIXEL,
        width=camera.width,
        height=camera.height,
        camera_xyz=rr.ViewCoordinates.RDF,
        image_plane_distance=2.0,
    )


def _heading(world_from_cam: np.ndarray) -> np.ndarray:
    """A level pose at the camera whose x axis is where the camera looks: the 3D view's frame."""
    _, down, forward = world_from_cam[:2, :3].T
    ahead = forward - 1e-6 * down  # a camera that looks straight down heads where its top is
    x, y = ahead / np.linalg.norm(ahead)
    level = np.eye(4)
    level[:3, :3] = [[x, -y, 0], [y, x, 0], [0, 0, 1]]
    level[:3, 3] = world_from_cam[:3, 3]
    return level


def _points(sample: Sample, camera: Intrinsics) -> rr.Points3D:
    seen = sample.depth_m < sample.max_depth_m
    return rr.Points3D(
        unproject(sample.depth_m, camera, sample.world_from_cam)[seen].astype(np.float32),
        colors=sample.rgb[seen],
        # To a pixel's corner out there: from the camera, the points close up into surfaces.
        radii=0.7 * sample.depth_m[seen] / camera.fx,
        point_shading="flat",
    )


def _about(sample: Sample) -> str:
    meta = sample.meta
    facts = {
        "split": meta["split"],
        "condition": meta["condition"],
        "time in flight": f"{meta['time_s']:.1f} s",
        "altitude": f"{meta['altitude_m']:.1f} m",
        "speed": f"{meta['speed_mps']:.1f} m/s",
        "nearest depth": f"{meta['nearest_depth_m']:.1f} m",
        "in range": f"{100 * meta['in_range_share']:.0f} %",
        "visibility": f"{meta['visibility_m']:.0f} m",
        "scene seed": meta["scene_seed"],
    }
    rows = "\n".join(f"| {name} | {value} |" for name, value in facts.items())
    return f"`{sample.key}`\n\n| | |\n|---|---|\n{rows}\n"


def _blueprint(fields: Collection[str]) -> rrb.Blueprint:
    """3D view from behind the drone, pictures beside it, curves and facts below."""
    pictures = {
        "camera/picture": "frame t",
        "camera_prev/picture": "frame t-1",
        "camera/depth": "depth",
    }
    also = {"flow": "flow", "seg": "labels", "normal": "normals"}
    pictures |= {f"camera/{name}": name for field, name in also.items() if field in fields}
    # In 3D only frame t: the pictures of one camera would lie over each other, and Rerun's own
    # points of the depth over ours.
    hidden = [f"- /world/{entity}" for entity in pictures if entity != "camera/picture"]
    eye = rrb.EyeControls3D(
        position=(-14.0, 0.0, 7.0), look_target=(20.0, 0.0, 0.0), eye_up=(0.0, 0.0, 1.0)
    )
    world = rrb.Spatial3DView(
        origin="/world/chase", contents=["+ /world/**", *hidden], name="world", eye_controls=eye
    )
    images = [rrb.Spatial2DView(origin=f"/world/{e}", name=name) for e, name in pictures.items()]
    curves = rrb.TimeSeriesView(origin="/plots", name="flight")
    facts = rrb.TextDocumentView(origin="/pair", name="pair")
    return rrb.Blueprint(
        rrb.Vertical(
            rrb.Horizontal(world, rrb.Grid(*images, grid_columns=2), column_shares=[3, 2]),
            rrb.Horizontal(curves, facts, column_shares=[3, 2]),
            row_shares=[3, 1],
        ),
        rrb.TimePanel(timeline="pair", fps=4.0, state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.BlueprintPanel(state="collapsed"),
    )
