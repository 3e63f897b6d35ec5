"""The pages of simulations: their figures are right, their text is harmless, the maps to scale."""

import dataclasses
import re
import shutil
import subprocess

import numpy as np
import pytest
from scipy import stats

from synthdepth.simulate.figures import flight_map
from synthdepth.simulate.flight import Rules
from synthdepth.simulate.markdown import markdown, text_table
from synthdepth.simulate.outcome import Outcome, compare_sources, summarise
from synthdepth.simulate.report import html_page
from synthdepth.simulate.spent import Spent, read_spent, spent_line
from synthdepth.simulate.store import SceneMap, plain
from synthdepth.simulate.tables import NONE, Results, collision_table, flying_table, time_table
from tests.test_page import Page

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
EVIL = '"><script>alert(1)</script><img src=x onerror=alert(1)>'
SOURCES = ("10m", "200m")


def flight(source, scenario, end, **values):
    """A flight of 40 m to the east and 30 m to the north."""
    collided = end == "collision"
    fields = {
        "map": "blocks", "scene_index": scenario // 5, "scene_seed": 7, "scenario": scenario % 5,
        "source": source, "end": end, "hit": "street_furniture" if collided else None,
        "hit_speed_mps": 12.0 if collided else None, "time_s": 4.0, "way_m": 55.0,
        "straight_m": 50.0, "shortest_m": 50.0, "left_m": 5.0, "goal_speed_mps": 11.0,
        "excess": 0.1 if end == "goal" else None, "clearance_m": 0.0 if collided else 2.0,
        "effort_m_s3": 3.0, "latency_s": 0.1, "speed_mps": 15.0, "blocked_by": None,
        "start_m": [-20.0, -10.0, 5.0], "goal_m": [20.0, 20.0, 5.0], "end_m": [20.0, 20.0, 5.0],
        "track_m": [[-20.0, -10.0, 5.0], [20.0, -10.0, 5.0]],
    }  # fmt: skip
    return Outcome(**fields | values)


def results_of(outcomes, **values):
    rules = dataclasses.asdict(Rules())
    land = np.full((60, 80, 3), 200, np.uint8)
    corners = {"low_m": np.array([-40.0, -30.0]), "high_m": np.array([40.0, 30.0])}
    fields = {
        "map": "blocks",
        "settings": {
            "seed": 3, "flights_per_scene": 5, "rules": plain(rules),
            "camera": {"width": 64, "height": 48}, "sources": {name: name for name in SOURCES},
        },
        "outcomes": outcomes,
        "summaries": summarise(outcomes),
        "comparisons": compare_sources(outcomes),
        "spent": {
            "": Spent(build_s=20.0, survey_s=10.0, load_s=10.0),
            "10m": Spent(flights=10, frames=400, sight_s=40.0, depth_s=4.0, physics_s=16.0),
        },
        "maps": [SceneMap(scene_index=k, condition="fog", picture=land, **corners)
                 for k in range(2)],
    }  # fmt: skip
    return Results(**fields | values)


@pytest.fixture(scope="module")
def results():
    ends = {
        "10m": ["collision"] * 6 + ["goal"] * 4,
        "200m": ["goal"] * 7 + ["collision", "time", "bounds"],
    }
    flights = [flight(s, k, end) for s, all_ in ends.items() for k, end in enumerate(all_)]
    # What flies straight into something is counted once more.
    flights[:8] = [dataclasses.replace(f, blocked_by="building") for f in flights[:8]]
    return results_of(flights)


@pytest.fixture(scope="module")
def page_text(results):
    return html_page(results)


@pytest.fixture(scope="module")
def page(page_text):
    # It knows no void elements but those of other pages.
    return Page(re.sub(r"<input ([^>]*)>", r"<input \1/>", page_text))


def test_rates_stand_beside_those_that_the_paper_printed(results, page):
    rows = {row[0]: row[1:] for row in collision_table(results).rows}
    low, high = stats.binomtest(6, 10).proportion_ci(0.95, "wilson")
    assert rows["10m"][:4] == ("10", "6", "60.00 %", f"{100 * low:.1f} to {100 * high:.1f}")
    assert rows["10m"][4] == "75.00 %" and rows["200m"][4] == NONE
    # 58.75 % of 400 flights.
    low, high = stats.binomtest(235, 400).proportion_ci(0.95, "wilson")
    assert rows["printed: 10 m"][:4] == (
        "400",
        "235",
        "58.75 %",
        f"{100 * low:.1f} to {100 * high:.1f}",
    )
    assert len(rows) == 6
    cells = [text for _, text in page.all("td", "number")]
    assert "60.00 %" in cells and "14.50 %" in cells
    elsewhere = dataclasses.replace(results, map="soccer_field")
    assert len(collision_table(elsewhere).rows) == 2
    p = stats.binomtest(1, 7).pvalue  # 6 scenarios in which only 10m collided, 1 the other way
    assert f"{p:.2f}" in cells


def test_means_are_over_the_flights_that_they_belong_to(results):
    head = flying_table(results).head
    rows = {row[0]: dict(zip(head, row, strict=True)) for row in flying_table(results).rows}
    assert rows["10m"]["Path excess [%]"] == "10.0"
    assert rows["10m"]["Least clearance [m]"] == "2.00"  # of the four that did not collide
    assert rows["10m"]["Speed at collision [m/s]"] == "12.0"
    safe = results_of([flight("10m", 0, "goal", excess=None, shortest_m=None)])
    row = dict(zip(head, flying_table(safe).rows[0], strict=True))
    assert (row["Path excess [%]"], row["Time to collision [s]"]) == ("–", "–")


def test_times_are_a_frame_and_a_flight(results, page):
    (row,) = time_table(results).rows
    assert row == ("10m", "10", "400", "100.0", "10.0", "40.0", "6.00")
    (said,) = [text for _, text in page.all("p") if text.startswith("On the machine")]
    assert "In all 100 s of processes: building scenes 20 %" in said and "pictures 40 %" in said


def test_times_are_read_but_for_a_line_cut_short(tmp_path):
    one, other = tmp_path / "a.jsonl", tmp_path / "b.jsonl"
    line = spent_line("10m", Spent(flights=2, sight_s=1.5))
    one.write_bytes(spent_line("", Spent(build_s=3.0)) + line)
    other.write_bytes(line + line[:20])
    assert read_spent([one, other]) == {
        "": Spent(build_s=3.0), "10m": Spent(flights=4, sight_s=3.0),
    }  # fmt: skip


def test_a_map_is_to_scale_with_crashes_marked(results):
    scene = results.maps[0]
    page = Page(flight_map(scene, [flight("10m", 0, "collision"), flight("200m", 0, "time")],
                           SOURCES))  # fmt: skip
    assert page.all("svg")[0][0]["viewbox"] == "0 0 440 330"
    first, second = page.all("polyline", "way")
    points = np.array([p.split(",") for p in first[0]["points"].split()], float)
    scale = 440 / 80
    np.testing.assert_allclose(points / scale, [[20, 40], [60, 40], [60, 10]], atol=0.02)
    assert first[1] == "10m, scenario 0: collided with street furniture after 4.0 s"
    assert second[1].endswith("out of time after 4.0 s")
    (crash,) = page.all("path", "crash")
    assert {"k0", "f0"} <= set(crash[0]["class"].split())
    middle = np.array(re.findall(r"M([\d.]+) ([\d.]+)l([\d.]+)", crash[0]["d"])[0], float)
    np.testing.assert_allclose(middle[:2] + middle[2] / 2, points[-1], atol=0.1)
    assert len(page.all("circle", "dot")) == 1  # where time ran out
    goal, begin = page.all("circle", "goal")[0][0], page.all("circle", "begin")[0][0]
    np.testing.assert_allclose([float(begin["cx"]), float(begin["cy"])], points[0], atol=0.05)
    assert float(goal["r"]) == pytest.approx(5 * scale, abs=0.05)
    assert "10 m" in [text for _, text in page.all("text")]


def test_every_flight_of_the_scenes_shown_is_on_the_page(page_text, page):
    assert len(page.all("polyline", "way")) == 20
    assert len(page.all("path", "crash")) == 7 + 1  # and the legend's
    assert [text for _, text in page.all("small") if "collisions" in text] == [
        "fog; 10 flights, 5 collisions", "fog; 10 flights, 2 collisions",
    ]  # fmt: skip
    assert page_text.count('type="checkbox"') == 2


def test_it_is_whole_in_itself_and_harmless(results):
    text = html_page(results)
    assert "<script" not in text and "url(" not in text
    evil = [dataclasses.replace(f, map=EVIL, source=EVIL + f.source, hit=f.hit and EVIL)
            for f in results.outcomes]  # fmt: skip
    settings = dict(results.settings) | {"sources": {EVIL: EVIL}}
    bad = results_of(evil, map=EVIL, settings=settings)
    bad.maps[0] = dataclasses.replace(bad.maps[0], condition=EVIL)
    page = Page(re.sub(r"<input ([^>]*)>", r"<input \1/>", html_page(bad)))
    assert not page.all("script")
    assert all(attrs["href"].startswith("data:image/") for attrs, _ in page.all("image"))
    assert not any(name.startswith("on") for _, attrs, _ in page.found for name in attrs)
    assert page.all("h1")[0][1] == f"{EVIL}, seed 3"
    assert "<script" not in markdown(bad).replace("\\", "")


def test_sections_and_levels(page):
    sections = {attrs["id"] for attrs, _ in page.all("section")}
    links = [a["href"] for _, a, _ in page.found if a.get("href", "").startswith("#")]
    assert {link[1:] for link in links} == sections
    levels = [int(tag[1]) for tag, _, _ in page.found if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1 and max(np.diff(levels)) == 1 and levels.count(1) == 1
    assert all(attrs["aria-label"] for attrs, _ in page.all("svg") if "key" not in str(attrs))


def test_markdown_and_text_have_the_same_figures(results):
    lines = markdown(results).splitlines()
    assert "| 10m | 10 | 6 | 60.00 % | 31.3 to 83.2 | 75.00 % |" in lines
    tables = [line for line in lines if line.startswith("|")]
    assert all(line.endswith("|") for line in tables)
    assert text_table(results).splitlines()[1].startswith("blocks         10m ")
    assert "street_furniture 6" in text_table(results)


@pytest.mark.skipif(CHROMIUM is None, reason="no chromium to show the page in")
def test_a_browser_shows_it_without_sideways_scrolling(results, tmp_path):
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", html_page(results))
    measure = (
        '<script>addEventListener("load", () => { document.title = '
        "document.documentElement.scrollWidth + ' ' + innerWidth + ' ' + "
        "getComputedStyle(document.querySelector('.way.f1')).display; });"
        "</script></body>"
    )
    file = tmp_path / "page.html"
    file.write_text(text.replace('id="source-1" checked', 'id="source-1"')
                    .replace("</body>", measure))  # fmt: skip
    done = subprocess.run(
        [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
         f"--user-data-dir={tmp_path / 'profile'}", "--window-size=500,900",
         "--virtual-time-budget=5000", "--dump-dom", file.as_uri()],
        capture_output=True, text=True, timeout=300, check=True,
    )  # fmt: skip
    needs, has, hidden = re.search(r"<title>(\d+) (\d+) (\w+)</title>", done.stdout).groups()
    assert int(needs) <= int(has)
    assert hidden == "none"  # its box is not checked
