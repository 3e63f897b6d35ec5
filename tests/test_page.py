"""The page of a dataset: its figures are right, its text is harmless, and a browser shows it."""

import json
import math
import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from synthdepth.camera import Intrinsics
from synthdepth.charts.axes import linear_axis, log_axis
from synthdepth.charts.svg import histogram
from synthdepth.dataset import manifest as manifest_module
from synthdepth.dataset.manifest import read_manifest, write_manifest
from synthdepth.dataset.pairs import PairDataset
from synthdepth.errors import DatasetError, SynthdepthError
from synthdepth.view.figures import flight_map
from synthdepth.view.flights import Flight
from synthdepth.view.page import write_page
from tests import made as made_module
from tests.made import make_dataset

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")
VOID = {"meta", "link", "img", "br"}
SHARDS, PAIRS = 3, 4


class Page(HTMLParser):
    """Elements of a page with their attributes and text; fails where tags do not match."""

    def __init__(self, text):
        super().__init__()
        self.found, self._open = [], []
        self.feed(text)
        assert not self._open

    def handle_starttag(self, tag, attrs):
        self.found.append((tag, dict(attrs), []))
        if tag not in VOID:
            self._open.append((tag, self.found[-1][2]))

    def handle_startendtag(self, tag, attrs):
        self.found.append((tag, dict(attrs), []))

    def handle_endtag(self, tag):
        assert self._open.pop()[0] == tag

    def handle_data(self, data):
        for _, texts in self._open:
            texts.append(data)

    def all(self, tag, kind=None):
        """Attributes and text of every element, in order; of one class."""
        return [
            (attrs, "".join(texts).strip())
            for name, attrs, texts in self.found
            if name == tag and (kind is None or kind in (attrs.get("class") or "").split())
        ]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "set"
    return make_dataset(folder, shards=SHARDS, pairs=PAIRS, modalities=("flow", "seg", "normal"))


@pytest.fixture(scope="module")
def file(made):
    out = made.parent / "page.html"
    assert write_page(made, out, count=100) == SHARDS * PAIRS
    return out


@pytest.fixture(scope="module")
def page(file):
    return Page(file.read_text())


def test_it_shows_every_picture_of_every_pair(page):
    pairs = page.all("figure", "pair")
    assert len(pairs) == SHARDS * PAIRS
    tiles = [text for _, text in page.all("span") if text.startswith("frame t")]
    assert tiles == ["frame t", "frame t-1"] * len(pairs)
    # Six tiles a pair, the strip of one frame a flight, the wheel of the flow's colours.
    assert len(page.all("img")) == 6 * len(pairs) + SHARDS + 1
    assert len(page.all("polyline", "run")) == SHARDS
    assert len(page.all("circle", "start")) == SHARDS


def test_captions_say_what_the_metadata_say(made, page):
    samples = {sample.key: sample.meta for sample in PairDataset(made)}
    for _, text in page.all("figcaption"):
        key = next((key for key in samples if text.startswith(key)), None)
        if key:
            meta = samples.pop(key)
            assert meta["condition"].capitalize() in text and meta["split"] in text
            assert f"{meta['altitude_m']:.1f} m up" in text
            assert f"{meta['speed_mps']:.1f} m/s" in text
            assert f"nearest {meta['nearest_depth_m']:.1f} m" in text
    assert not samples


def test_the_depth_table_counts_pixels(made, page):
    depth = np.stack([sample.depth_m for sample in PairDataset(made)])
    cells = [text for _, text in page.all("td", "number")][:7]
    edges = [0, 5, 10, 25, 50, 100, 200, np.inf]
    for cell, low, high in zip(cells, edges[:-1], edges[1:], strict=True):
        assert cell == f"{100 * np.mean((low <= depth) & (depth < high)):.1f} %"


def test_label_shares_are_those_of_the_pictures(made, page):
    seg = np.stack([sample.seg for sample in PairDataset(made)])
    shares = {text.partition(" ")[0]: text for _, text in page.all("li")}
    for name in ("sky", "ground", "building"):
        share = np.mean(seg == read_manifest(made)["labels"][name])
        assert shares[name] == f"{name} {100 * share:.1f} %"
    assert shares["wire"] == "wire none"


def test_it_is_whole_in_itself_and_can_be_read_aloud(file, page):
    text = file.read_text()
    assert "<script" not in text and "url(http" not in text
    addresses = [a[name] for _, a, _ in page.found for name in ("src", "href") if name in a]
    assert all(address.startswith(("data:", "#")) for address in addresses)
    sections = {attrs["id"] for attrs, _ in page.all("section")}
    assert {address[1:] for address in addresses if address.startswith("#")} == sections
    assert all(attrs["alt"] for attrs, _ in page.all("img"))
    assert all(attrs["aria-label"] for attrs, _ in page.all("svg"))
    levels = [int(tag[1]) for tag, _, _ in page.found if re.fullmatch("h[1-6]", tag)]
    assert levels[0] == 1 and max(np.diff(levels)) == 1 and levels.count(1) == 1
    assert page.all("html")[0][0] == {"lang": "en"}


def test_the_same_dataset_gives_the_same_page(made, file, tmp_path):
    write_page(made, tmp_path / "again.html", count=100)
    assert (tmp_path / "again.html").read_bytes() == file.read_bytes()


def test_24_pairs_stay_below_5_mb(tmp_path):
    camera = Intrinsics.from_fov(256, 256, 90.0)
    folder = make_dataset(
        tmp_path / "set", shards=2, pairs=2, modalities=("flow", "seg", "normal"), camera=camera
    )
    assert write_page(folder, tmp_path / "page.html") == 4
    assert (tmp_path / "page.html").stat().st_size < 5e6 * 4 / 24


def test_what_files_say_is_never_markup(tmp_path, monkeypatch):
    evil = '"><script>alert(1)</script><img src=x onerror=alert(1)>'
    monkeypatch.setattr(made_module, "CONDITIONS", (evil,) * 3)
    # The contract refuses most of it; the page relies on nobody.
    monkeypatch.setattr(manifest_module, "check_manifest", lambda manifest: None)
    folder = make_dataset(tmp_path / "set", shards=2, pairs=1, modalities=("seg",))
    manifest = read_manifest(folder)
    manifest |= {"map": evil, "seed": evil, "software": {evil: evil}, "splits": {evil: 2}}
    manifest["recipe"]["sensor"]["model"] = evil
    manifest["labels"] = {evil: 1, "sky": 0}
    write_manifest(folder, manifest)
    write_page(folder, tmp_path / "page.html")
    page = Page((tmp_path / "page.html").read_text())
    assert not page.all("script")
    assert all(attrs["src"].startswith("data:image/") for attrs, _ in page.all("img"))
    assert not any(name.startswith("on") for _, attrs, _ in page.found for name in attrs)
    assert page.all("h1")[0][1] == f"{evil}, seed {evil}"


def test_an_unfinished_run_is_told(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=1)
    write_manifest(folder, read_manifest(folder) | {"complete": False, "pairs_planned": 12})
    write_page(folder, tmp_path / "page.html")
    ((_, told),) = Page((tmp_path / "page.html").read_text()).all("p", "warning")
    assert told.startswith("The run has not finished: 3 of 12 pairs")


def test_a_dataset_without_sky_or_modalities(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=1, pairs=1, max_depth_m=2.0)
    write_page(folder, tmp_path / "page.html")
    page = Page((tmp_path / "page.html").read_text())
    assert len(page.all("figure", "pair")) == 1
    assert "100.0 %" in [text for _, text in page.all("td", "number")]


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"count": 0}, "--count 0: allowed is a whole number from 1 to 400"),
        ({"out": "page.pdf"}, "allowed is a file name that ends in .html"),
        ({"out": "no/folder/page.html"}, "cannot write .*page.html: No such file"),
    ],
)
def test_mistakes_are_told_in_one_line(made, tmp_path, arguments, told):
    out = tmp_path / arguments.pop("out", "page.html")
    with pytest.raises(SynthdepthError, match=told):
        write_page(made, out, **arguments)
    assert not list(tmp_path.iterdir())


def test_a_broken_dataset_is_told_in_one_line(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=1)
    shard = next(folder.rglob("*.tar"))
    shard.write_bytes(shard.read_bytes()[:9000])
    with pytest.raises(DatasetError, match="synthdepth verify"):
        write_page(folder, tmp_path / "page.html")
    write_manifest(folder, {"shards": []})
    with pytest.raises(DatasetError, match=r"dataset.json is not a manifest: map is missing"):
        write_page(folder, tmp_path / "page.html")
    with pytest.raises(DatasetError, match="holds no dataset"):
        write_page(tmp_path, tmp_path / "page.html")
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


@given(st.lists(st.floats(-1e4, 1e4), min_size=1, max_size=50))
def test_a_linear_axis_holds_its_values(values):
    axis = linear_axis(np.array(values))
    assert axis.edges[0] <= min(values) + 1e-9 and max(values) <= axis.edges[-1] + 1e-9
    assert 1 <= len(axis.edges) - 1 <= 26
    assert all(-1e-6 <= axis.place(tick) <= 1 + 1e-6 for tick in axis.ticks)


def test_a_log_axis_gives_equal_factors_equal_room():
    axis = log_axis(1.0, 200.0)
    assert axis.ticks == (1, 2, 5, 10, 20, 50, 100, 200)
    assert axis.place(1) == 0 and axis.place(200) == 1
    assert math.isclose(axis.place(20) - axis.place(10), axis.place(2) - axis.place(1))


def test_bars_are_as_high_as_their_shares():
    values = np.array([0.5] * 10 + [1.5] * 30 + [2.5] * 60)
    axis = linear_axis(np.array([0.0, 3.0]), bins=3)
    page = Page(histogram(values, axis, name="heights", unit="m"))
    heights = [float(attrs["height"]) for attrs, _ in page.all("rect", "bar")]
    np.testing.assert_allclose(np.array(heights) / heights[2], [1 / 6, 1 / 2, 1], atol=0.01)
    titles = [text for _, text in page.all("title")]
    assert titles == ["0 to 1 m: 10.0 %", "1 to 2 m: 30.0 %", "2 to 3 m: 60.0 %"]
    assert "median 2.5 m" in page.all("svg")[0][0]["aria-label"]


def test_the_map_is_to_scale_with_north_up():
    """A flight of 30 m north, then 40 m east, on a square of 100 m."""
    places = np.array([[0, 0, 9], [0, 30, 9], [40, 30, 9]], float)
    flight = Flight(
        name="city-s00000-f002", rows=np.arange(2), frames=np.array([4, 5]),
        positions_m=places[1:], starts_m=places[:-1],
    )  # fmt: skip
    page = Page(flight_map([flight], lambda f: np.full(len(f.rows), 9.0), 100.0))
    ((attrs, told),) = page.all("polyline", "run")
    points = np.array([point.split(",") for point in attrs["points"].split()], float)
    np.testing.assert_allclose(np.diff(points, axis=0) / 3.2, [[0, -30], [40, 0]], atol=0.05)
    assert attrs["class"] == "run a1" and told == "city-s00000-f002, frames 4 to 5, 9 m up"
    start = page.all("circle", "start")[0][0]
    np.testing.assert_allclose([float(start["cx"]), float(start["cy"])], points[0])
    # The bar says 20 m, and is 20 m long on this map.
    assert "20 m" in [text for _, text in page.all("text")]
    assert "h64.0v" in page.all("path", "scale")[0][0]["d"]


@pytest.fixture(scope="module")
def browse(tmp_path_factory):
    if CHROMIUM is None:
        pytest.skip("no chromium to show the page in: apt-get install chromium")

    def dump(file: Path, width: int) -> tuple[dict, str]:
        """What the page measures of itself once shown, and the browser's log."""
        done = subprocess.run(
            [
                CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic",
                "--no-first-run", "--disable-background-networking", "--disable-component-update",
                "--disable-sync", "--enable-logging=stderr", "--v=0", "--hide-scrollbars",
                f"--user-data-dir={tmp_path_factory.mktemp('profile')}",
                f"--window-size={width},900", "--virtual-time-budget=20000", "--dump-dom",
                file.as_uri(),
            ],
            capture_output=True, text=True, timeout=100, check=True,
        )  # fmt: skip
        found = re.search(r'<pre id="measured">(.*?)</pre>', done.stdout)
        return json.loads(found[1]) if found else {}, done.stderr

    return dump


MEASURE = """<script>
addEventListener("load", () => {
  const images = [...document.images];
  const loaded = performance.getEntriesByType("resource").map(entry => entry.name);
  const box = document.createElement("pre");
  box.id = "measured";
  box.textContent = JSON.stringify({
    images: images.length,
    broken: images.filter(image => image.naturalWidth === 0).length,
    squeezed: images.filter(image => image.width < 40).length,
    empty: [...document.querySelectorAll("svg")].filter(s => s.getBBox().width < 100).length,
    width: innerWidth, needs: document.documentElement.scrollWidth,
    resources: loaded.filter(name => !name.startsWith("data:")).length,
  });
  document.body.append(box);
});
</script></body>"""


@pytest.mark.parametrize("width", [1280, 500])
def test_a_browser_shows_it(file, browse, tmp_path, width):
    """The page itself allows no script: the copy that measures has that taken out."""
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", file.read_text())
    measuring = tmp_path / "measuring.html"
    text = text.replace('loading="lazy" decoding="async"', "").replace("</body>", MEASURE)
    measuring.write_text(text)
    measured, _ = browse(measuring, width)
    assert measured["images"] == 6 * SHARDS * PAIRS + SHARDS + 1
    assert measured["broken"] == measured["squeezed"] == measured["empty"] == 0
    assert measured["needs"] <= measured["width"]
    assert measured["resources"] == 0


def test_a_browser_has_nothing_to_complain_about(file, browse):
    _, log = browse(file, 1280)
    assert "CONSOLE" not in log


def test_a_page_lets_no_script_run(file, browse, tmp_path):
    """Its own policy stops what an escape might have missed."""
    with_script = tmp_path / "script.html"
    with_script.write_text(file.read_text().replace("</body>", MEASURE))
    measured, log = browse(with_script, 1280)
    assert not measured and "Content Security Policy" in log
