"""Flights flown again: as recorded, or nothing is written; what videos and recordings show."""

import json

import cv2
import numpy as np
import pytest

from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.simulate.film import write_film
from synthdepth.simulate.flight import Rules
from synthdepth.simulate.replay import Replay, rules_of
from synthdepth.simulate.scenario import ScenarioRanges
from synthdepth.simulate.sources import parse_source
from synthdepth.simulate.store import FLIGHTS, SCENES, SETTINGS, read_flights
from tests.test_simulate import CAMERA, STAGE, run

PANEL = 192
QUICK = Rules(scenario=ScenarioRanges(distance_m=(18.0, 25.0), speed_mps=(12.0, 15.0)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two short flights by depth to 60 m, and by none."""
    place = tmp_path_factory.mktemp("replay") / "run"
    with pytest.MonkeyPatch.context() as patch:
        _without_renderer(patch)
        run(place, flights=2, sources=[parse_source("60m"), parse_source("blind")], rules=QUICK)
    return place


class Plain:
    """A renderer that sees nothing but the ground: depth, and grey that falls with it."""

    camera, exposure = CAMERA, 1.0

    def planar_depth(self, world_from_cam):
        down = np.minimum(CAMERA.rays() @ world_from_cam[2, :3], -1e-3)
        return (world_from_cam[2, 3] / -down).astype(np.float32)

    def radiance(self, world_from_cam, seed, motion):
        grey = 1 / (1 + self.planar_depth(world_from_cam) / 10)
        return np.repeat(grey[..., None], 3, axis=2).astype(np.float32)


def _without_renderer(patch):
    patch.setattr("synthdepth.simulate.scene._load", lambda *_: Plain())


@pytest.fixture(autouse=True)
def _raycast(monkeypatch):
    _without_renderer(monkeypatch)


@pytest.fixture(scope="module")
def shortest(folder):
    return min(read_flights(folder / FLIGHTS)[:2], key=lambda flight: len(flight.track_m))


def replay(folder, flight):
    return Replay(STAGE, folder, source=flight.source, scene_index=0, scenario=flight.scenario)


def test_rules_are_those_that_the_settings_hold(folder):
    assert rules_of(json.loads((folder / SETTINGS).read_text())["rules"]) == QUICK


def test_a_flight_flown_again_shows_what_was_recorded(folder, shortest):
    frames = []
    again = replay(folder, shortest)
    again.fly(frames.append)
    track = [np.round(frame.world_from_cam[:3, 3], 2).tolist() for frame in frames]
    assert track == shortest.track_m
    assert [frame.number for frame in frames] == list(range(len(track)))
    assert frames[7].time_s == pytest.approx(0.7)
    for frame in frames:
        assert frame.rgb.shape == (36, 36, 3) and frame.rgb.any()
        assert frame.depth_m.max() <= 60 == again.max_depth_m
        assert all(0 <= index < 17 for index in frame.section)


def test_a_video_has_every_frame_and_how_it_ended(folder, shortest, tmp_path):
    told = []
    out = tmp_path / "flight.mp4"
    total = len(shortest.track_m)
    count = write_film(replay(folder, shortest), out, lambda *x: told.append(x), panel_px=PANEL)
    assert count == total and told == [(k + 1, total) for k in range(total)]
    video = cv2.VideoCapture(str(out))
    assert video.get(cv2.CAP_PROP_FPS) == pytest.approx(10)
    pictures = []
    while (read := video.read())[0]:
        pictures.append(cv2.cvtColor(read[1], cv2.COLOR_BGR2RGB).astype(float))
    assert len(pictures) == total + 15
    assert [path.name for path in tmp_path.iterdir()] == ["flight.mp4"]
    # To the right the map: what has been flown is drawn over it.
    flown = [
        (np.abs(picture[64:, -8 - PANEL : -8] - (214, 69, 20)).sum(axis=-1) < 120).sum()
        for picture in (pictures[0], pictures[total - 1])
    ]
    assert flown[0] + 60 < flown[1]
    # To the left the camera's picture: grey, by how near things are.
    camera = pictures[0][68 : 60 + PANEL, 12 : 4 + PANEL]
    assert np.ptp(camera, axis=-1).mean() < 12 and camera.std() > 3


def test_a_flight_that_ends_otherwise_is_told_and_leaves_no_file(folder, shortest, tmp_path):
    path = next((folder / SCENES).iterdir())
    before = path.read_bytes()
    lines = [json.loads(line) for line in before.splitlines()]
    for line in lines:
        line["time_s"] += 0.5
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    try:
        again = replay(folder, shortest)
        with pytest.raises(DatasetError, match=r"was not as recorded \(time_s\)"):
            write_film(again, tmp_path / "flight.mp4", panel_px=PANEL)
    finally:
        path.write_bytes(before)
    assert not list(tmp_path.iterdir())
    with pytest.raises(DatasetError, match="cannot write .*no/x.mp4: No such"):
        write_film(again, tmp_path / "no" / "x.mp4", panel_px=PANEL)


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"source": "5m"}, "--source 5m: .* holds flights of 60m, blind"),
        ({"scene_index": 3}, "--scene 3 --scenario 0: .* holds no flight of it"),
        ({"scenario": 9}, "--scenario 9: .* holds scenarios 0 to 1 of it"),
    ],
)
def test_a_flight_that_is_not_there_is_told(folder, asked, told):
    asked = {"source": "60m", "scene_index": 0, "scenario": 0} | asked
    with pytest.raises(DatasetError, match=told):
        Replay(STAGE, folder, **asked)


def test_another_model_or_format_is_refused(folder, tmp_path):
    settings = json.loads((folder / SETTINGS).read_text())
    model = tmp_path / "model.safetensors"
    model.write_bytes(b"one")
    named = parse_source(f"ours={model}")
    sources = {"ours": {"name": "ours", "what": str(model), "sha256": named.sha256}}
    place = tmp_path / "run"
    place.mkdir()
    (place / SETTINGS).write_text(json.dumps(settings | {"sources": sources}))
    model.write_bytes(b"other")
    asked = {"source": "ours", "scene_index": 0, "scenario": 0}
    with pytest.raises(DatasetError, match="its SHA-256 has changed"):
        Replay(STAGE, place, **asked)
    model.unlink()
    with pytest.raises(SynthdepthError, match="there is no such file"):
        Replay(STAGE, place, **asked)
    (place / SETTINGS).write_text(json.dumps(settings | {"format": 1}))
    with pytest.raises(DatasetError, match="another format"):
        Replay(STAGE, place, **asked)
    with pytest.raises(DatasetError, match="holds no simulation"):
        Replay(STAGE, tmp_path / "nothing", **asked)


def test_a_recording_holds_every_frame(folder, shortest, tmp_path):
    pytest.importorskip("rerun", reason="Rerun is not installed: pip install 'synthdepth[view]'")
    from rerun.chunk import RrdReader

    from synthdepth.view.flight_recording import write_flight_recording

    out = tmp_path / "flight.rrd"
    total = len(shortest.track_m)
    assert write_flight_recording(replay(folder, shortest), out) == total
    assert [path.name for path in tmp_path.iterdir()] == ["flight.rrd"]
    rows = {}
    for chunk in RrdReader(out).store().stream():
        batch = chunk.to_record_batch()
        for field in batch.schema:
            if ":" in field.name:
                name = (chunk.entity_path, field.name.partition(":")[2])
                found = [value for value in batch[field.name].to_pylist() if value is not None]
                rows.setdefault(name, []).extend(found)
    places = np.array(rows["/world/camera", "translation"]).reshape(-1, 3)
    np.testing.assert_allclose(places, shortest.track_m, atol=0.006)
    assert len(rows["/world/camera/picture", "blob"]) == total
    assert len(rows["/world/seen/section", "half_sizes"]) == total
    half = np.ravel(rows["/world/seen/section", "half_sizes"][0])
    np.testing.assert_allclose(half, [CAMERA.width / 18, CAMERA.height / 18])
    way = np.array(rows["/world/way", "strips"][0][0])
    np.testing.assert_allclose(way[-1], shortest.end_m, atol=1e-3)
    # Every point of the surfaces is on the ground or on a box, 4 m wide and 15 m high.
    points = np.array(rows["/world/surfaces", "positions"][0], float)
    assert len(points) > 1000 and points[:, 2].min() >= -1e-3 and points[:, 2].max() <= 15.001
