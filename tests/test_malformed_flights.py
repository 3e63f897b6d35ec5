"""Malformed folders of simulations: refused in one line, field by field."""

import dataclasses
import json

import pytest

from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.simulate.flight import Rules
from synthdepth.simulate.outcome import Outcome
from synthdepth.simulate.replay import rules_of
from synthdepth.simulate.spent import Spent, read_spent, spent_line
from synthdepth.simulate.store import FORMAT, SETTINGS, flown, read_flights, read_settings

FLIGHT = Outcome(
    map="blocks", scene_index=0, scene_seed=7, scenario=0, source="blind", end="goal", hit="",
    hit_speed_mps=0.0, time_s=3.5, way_m=35.0, straight_m=30.0, shortest_m=31.0, left_m=0.0,
    goal_speed_mps=9.0, excess=None, clearance_m=0.5, effort_m_s3=12.5, latency_s=0.1,
    speed_mps=10.0, blocked_by="", start_m=[0.0, 0.0, 5.0], goal_m=[30.0, 0.0, 5.0],
    end_m=[30.0, 0.0, 5.0], track_m=[[0.0, 0.0, 5.0]],
)  # fmt: skip


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("scenario", True),
        ("scenario", 0.5),
        ("source", None),
        ("end", "nowhere"),
        ("way_m", "35"),
        ("way_m", float("nan")),
        pytest.param("way_m", 10**400, id="digits"),
        ("start_m", [0.0, 0.0]),
        ("track_m", [1.0]),
        ("another", 1),
    ],
)
def test_a_flight_has_fields_of_the_right_types(tmp_path, name, value):
    path = tmp_path / "flights.jsonl"
    flight = dataclasses.asdict(FLIGHT)
    path.write_text(json.dumps(flight) + "\n")
    assert read_flights(path) == [FLIGHT]
    assert flown(path) == {("blind", 0): FLIGHT}
    path.write_text(json.dumps(flight | {name: value}) + "\n")
    for read in (read_flights, flown):
        with pytest.raises(DatasetError, match=r"flights\.jsonl holds"):
            read(path)


@pytest.mark.parametrize(
    "change",
    [
        {"sources": "x"},
        {"sources": {"blind": "x"}},
        {"sources": {"blind": {"name": "blind"}}},
        {"rules": []},
        {"rules": {"drone": {}, "planner": {}}},
        {"rules": {"drone": {}, "planner": {}, "scenario": {}, "lockstep": 0}},
        {"rules": {"drone": {}, "planner": {}, "scenario": {}, "other": 1}},
        {"format": []},
    ],
)
def test_settings_of_simulations_refuse_any_type(tmp_path, change):
    def read():
        rules_of(read_settings(tmp_path)["rules"])

    source = {"name": "blind", "what": "blind", "sha256": ""}
    settings = {"format": FORMAT, "rules": dataclasses.asdict(Rules()), "recipe": {}}
    settings["sources"] = {"blind": source}
    (tmp_path / SETTINGS).write_text(json.dumps(settings))
    read()
    (tmp_path / SETTINGS).write_text(json.dumps(settings | change))
    with pytest.raises(SynthdepthError):
        read()


@pytest.mark.parametrize(
    "line", ["[]", "{}", '{"source": []}', '{"source": "a", "build_s": NaN}', '{"source": 1}']
)
def test_times_of_a_simulation_are_numbers_by_source(tmp_path, line):
    path = tmp_path / "times.jsonl"
    path.write_bytes(spent_line("a", Spent(build_s=1.5)) + b'{"cut')
    assert read_spent([path]) == {"a": Spent(build_s=1.5)}
    path.write_text(line + "\n")
    with pytest.raises(DatasetError, match=r"times\.jsonl cannot be read"):
        read_spent([path])
