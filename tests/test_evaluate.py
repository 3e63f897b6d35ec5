"""Evaluating as a job: reports against independent sums, all sources, what a browser shows."""

import dataclasses
import json
import os
import re

import numpy as np
import pytest

from synthdepth.dataset import PairDataset
from synthdepth.dataset.exr import encode_depth
from synthdepth.errors import SynthdepthError
from synthdepth.evaluate import run
from synthdepth.evaluate.breakdown import THIN_CLASSES, scene_of
from synthdepth.evaluate.data import pair_data
from synthdepth.evaluate.evaluation import Evaluation
from synthdepth.evaluate.markdown import summary
from synthdepth.evaluate.protocols import PROTOCOLS
from synthdepth.evaluate.record import make_report
from synthdepth.evaluate.run import REPORTS, evaluate
from synthdepth.evaluate.sources import FlipAveraged, Source, open_source
from synthdepth.evaluate.tables import group_tables
from synthdepth.evaluate.tally import DepthHistogram, Tally
from synthdepth.export import export
from synthdepth.kitti.dataset import KittiDataset
from synthdepth.kitti.png import encode_depth as encode_kitti
from synthdepth.seeding import lane
from tests.made import CAMERA, make_dataset
from tests.test_page import MEASURE, Page, browse  # noqa: F401

SHARDS, PAIRS = 6, 3
TEST = SHARDS // 2 * PAIRS


@dataclasses.dataclass
class Noisy(Source):
    """The truth with noise that depends on the picture alone."""

    name: str
    spread: float = 0.2
    says: str = "truth with noise"

    def depth_m(self, samples):
        return [self.one(sample) for sample in samples]

    def one(self, sample):
        noise = lane(0, self.name, sample.key).normal(0, self.spread, sample.depth_m.shape)
        return (sample.depth_m * np.exp(noise)).astype(np.float32)


@dataclasses.dataclass
class Deadly(Noisy):
    """Kills its process, as a lack of memory does."""

    def depth_m(self, samples):
        os._exit(9)


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    folder = tmp_path_factory.mktemp("made") / "set"
    return make_dataset(folder, shards=SHARDS, pairs=PAIRS, modalities=("flow", "seg"))


@pytest.fixture(scope="module")
def samples(made):
    return list(PairDataset(made, split="test"))


@pytest.fixture(scope="module")
def out(made, tmp_path_factory):
    out = tmp_path_factory.mktemp("reports") / "new" / "out"
    evaluate([Noisy("ours"), Noisy("theirs", 0.4)], [made], out=out, workers=1, panels=2)
    return out


@pytest.fixture(scope="module")
def table(out):
    return json.loads((out / "report.json").read_text())


@pytest.fixture(scope="module")
def page(out):
    return Page((out / "report.html").read_text())


def paper_metrics(prediction, truth):
    """Equations 19 to 21 of one picture."""
    p, g = np.minimum(prediction, 200).astype(float), truth.astype(float)
    worse = np.maximum(p / g, g / p)
    return {
        "rmse": np.sqrt(np.mean((p - g) ** 2)),
        "abs_rel": np.mean(np.abs(p - g) / g),
        **{f"delta_{n}": np.mean(worse < 1.25**n) for n in (1, 2, 3)},
    }


def test_the_figures_are_those_of_an_independent_computation(samples, table):
    assert (table["pictures"], table["scenes"], table["split"]) == (TEST, SHARDS // 2, "test")
    for source, predictor in zip(
        table["sources"], (Noisy("ours"), Noisy("theirs", 0.4)), strict=False
    ):
        pictures = [paper_metrics(predictor.one(s), s.depth_m) for s in samples]
        images = source["protocols"][0]["images"]
        low_high = source["protocols"][0]["intervals"]
        for name in pictures[0]:
            mean = np.mean([picture[name] for picture in pictures])
            assert images[name] == pytest.approx(mean), name
            assert low_high[name][0] <= mean <= low_high[name][1]
        worst = np.argsort([picture["abs_rel"] for picture in pictures])[:-3:-1]
        assert [w["key"] for w in source["worst"]] == [samples[k].key for k in worst]
        for found, k in zip(source["worst"], worst, strict=True):
            assert found["abs_rel"] == pytest.approx(pictures[k]["abs_rel"])
            assert found["rmse"] == pytest.approx(pictures[k]["rmse"])


def test_groups_and_histograms_count_every_pixel_once(samples, table):
    source = table["sources"][0]
    pixels = sum(sample.depth_m.size for sample in samples)
    ranges = [g["pixels"]["pixels"] for g in source["groups"] if g["axis"] == "range"]
    assert sum(ranges) == np.sum(source["errors"]["counts"]) == pixels
    assert np.sum(source["depths"]["counts"]) == pixels
    p = np.concatenate([np.minimum(Noisy("ours").one(s), 200).ravel() for s in samples])
    g = np.concatenate([sample.depth_m.ravel() for sample in samples])
    counts = np.histogram(p.astype(float) - g, source["errors"]["edges_m"])[0]
    np.testing.assert_array_equal(source["errors"]["counts"], counts)
    groups = {(g["axis"], g["name"], g["saturated"]): g for g in source["groups"]}
    fog = groups["condition", "fog", True]
    there = [s for s in samples if s.meta["condition"] == "fog"]
    expected = np.mean([paper_metrics(Noisy("ours").one(s), s.depth_m)["rmse"] for s in there])
    assert fog["images"]["rmse"] == pytest.approx(expected)


def test_true_and_predicted_depths_are_counted_where_they_are():
    depths = DepthHistogram(200.0)
    rng = lane(0, "depths")
    truth, prediction = (np.exp(rng.uniform(0, np.log(200), 5000)) for _ in range(2))
    depths.add(prediction, truth)
    expected = np.histogram2d(truth, prediction, depths.edges_m)[0]
    np.testing.assert_array_equal(depths.counts, expected)
    depths.add(np.array([1e-3, 1e6]), np.array([50.0, 50.0]))
    row = depths.counts[np.searchsorted(depths.edges_m, 50) - 1]
    assert row[0] == expected[np.searchsorted(depths.edges_m, 50) - 1][0] + 1


def test_differences_are_paired(samples, made, tmp_path, table):
    """The same predictor under another name differs by nothing, whatever scenes are drawn."""
    copy = Noisy("ours")
    copy.name, copy.one = "copy", Noisy("ours").one
    evaluate([Noisy("ours"), copy], [made], out=tmp_path, workers=1, baselines=(), panels=0)
    ours, again = json.loads((tmp_path / "report.json").read_text())["sources"]
    assert "difference" not in ours["protocols"][0]
    difference = again["protocols"][0]["difference"]["rmse"]
    assert difference == {"value": 0, "low": 0, "high": 0}
    found = table["sources"][1]["protocols"][0]["difference"]["rmse"]
    one, other = (s["protocols"][0]["images"]["rmse"] for s in table["sources"][:2])
    assert found["value"] == pytest.approx(other - one)
    assert 0 < found["low"] <= found["value"] <= found["high"]


def test_neither_processes_nor_batches_change_a_digit(made, out, tmp_path, monkeypatch):
    monkeypatch.setattr(run, "_PART", 2)
    sources = [Noisy("ours"), Noisy("theirs", 0.4)]
    done = []
    for name, workers, batch_size in (("one", 1, 1), ("two", 2, 3)):
        evaluate(
            sources, [made], out=tmp_path / name, workers=workers, batch_size=batch_size, panels=2,
            on_progress=lambda *now: done.append(now),
        )  # fmt: skip
    for report in REPORTS:
        first, second = ((tmp_path / name / report).read_bytes() for name in ("one", "two"))
        assert first == second
    assert done[-1] == (TEST, TEST) and len(done) == 2 * -(-TEST // 2)


def test_parts_merge_into_the_whole(samples):
    whole, merged = (Tally([PROTOCOLS["synthdepth"]], 200.0, 3) for _ in range(2))
    for number, sample in enumerate(samples):
        whole.add(Noisy("ours").one(sample), sample, number, "dense")
        part = Tally([PROTOCOLS["synthdepth"]], 200.0, 3)
        part.add(Noisy("ours").one(sample), sample, number, "dense")
        merged.merge(part)
    assert whole.worst == merged.worst and len(whole.worst) == 3
    np.testing.assert_array_equal(whole.errors.counts, merged.errors.counts)
    np.testing.assert_array_equal(whole.depths.counts, merged.depths.counts)
    one, other = (tally.evaluation.results()[0].images for tally in (whole, merged))
    assert dataclasses.asdict(one) == pytest.approx(dataclasses.asdict(other))


def test_a_few_pairs_are_drawn_and_stay_the_same(made):
    few = pair_data([made], split="test", max_pairs=4)
    assert len(few.numbers) == 4 == len(set(few.numbers)) and sorted(few.numbers) == [*few.numbers]
    assert few.numbers == pair_data([made], split="test", max_pairs=4).numbers
    assert pair_data([made], split="test", max_pairs=99).numbers == tuple(range(TEST))


def test_predictions_in_files_are_what_was_predicted(samples, made, tmp_path, table):
    """A file of each kind; PNG has steps of 1/256 m."""
    folder = tmp_path / "predictions"
    folder.mkdir()
    for number, sample in enumerate(samples):
        depth = Noisy("ours").one(sample)
        name = folder / sample.key
        if number % 3 == 0:
            exr = encode_depth(depth, CAMERA, sample.world_from_cam, 200.0)
            name.with_name(f"{name.name}.depth.exr").write_bytes(exr)
        elif number % 3 == 1:
            np.save(f"{name}.npy", depth)
        else:
            name.with_name(f"{name.name}.png").write_bytes(encode_kitti(np.minimum(depth, 200)))
    evaluate([f"files={folder}"], [made], out=tmp_path / "out", workers=1, baselines=(), panels=0)
    (source,) = json.loads((tmp_path / "out/report.json").read_text())["sources"]
    assert source["name"] == "files"
    for name, value in table["sources"][0]["protocols"][0]["images"].items():
        if name in ("rmse", "abs_rel", "delta_1", "mae"):
            assert source["protocols"][0]["images"][name] == pytest.approx(value, rel=1e-4)
    (folder / f"{samples[1].key}.npy").unlink()
    with pytest.raises(SynthdepthError, match=rf"has no prediction of {samples[1].key}: allowed"):
        evaluate([str(folder)], [made], out=tmp_path / "no", workers=1)
    np.save(folder / f"{samples[1].key}.npy", np.ones((2, 3, 4)))
    with pytest.raises(SynthdepthError, match=r"shape \(2, 3, 4\) .* allowed is"):
        evaluate([str(folder)], [made], out=tmp_path / "no", workers=1)
    assert not (tmp_path / "no").exists()


def test_models_and_onnx_files_predict_as_they_do_alone(samples, made, tmp_path):
    torch = pytest.importorskip("torch")
    pytest.importorskip("onnxruntime")
    from synthdepth.pix2pix.checkpoint import save_model
    from synthdepth.pix2pix.config import TrainConfig
    from synthdepth.pix2pix.generator import UNetGenerator
    from synthdepth.pix2pix.onnx import export_onnx
    from synthdepth.pix2pix.predict import Predictor

    torch.manual_seed(0)
    config = TrainConfig.from_table(
        {"generator": {"ngf": 4, "depth": 4}, "size": [48, 32], "epochs": 1}, "test"
    )
    (tmp_path / "run").mkdir()
    path = tmp_path / "run" / "best.safetensors"
    save_model(path, UNetGenerator(config.generator), {"config": config.as_table()})
    export_onnx(path, tmp_path / "net.onnx")
    sources = [f"net={tmp_path / 'run'}", f"onnx={tmp_path / 'net.onnx'}"]
    evaluate(sources, [made], out=tmp_path / "out", workers=1, baselines=(), panels=1)
    net, onnx = json.loads((tmp_path / "out/report.json").read_text())["sources"]
    assert net["says"].endswith("input embed (flow farneback, interval 5)")
    alone = Evaluation([PROTOCOLS["synthdepth"]])
    predictor = Predictor(path)
    for sample in samples:
        depth = predictor.depth_m([sample])[0]
        assert depth.shape == (32, 48)
        alone.add(depth, sample.depth_m, max_depth_m=200.0, scene=scene_of(sample))
    expected = dataclasses.asdict(alone.results()[0].images)
    assert net["protocols"][0]["images"] == pytest.approx(expected, rel=1e-4)
    assert onnx["protocols"][0]["images"]["rmse"] == pytest.approx(expected["rmse"], rel=1e-3)
    # The input is another picture than the frame, and is shown.
    page = Page((tmp_path / "out/report.html").read_text())
    assert [text for _, text in page.all("span") if text.startswith("input, ")] == [
        "input, net", "input, onnx",
    ] * 2  # fmt: skip
    with pytest.raises(SynthdepthError, match="no readable ONNX file"):
        (tmp_path / "bad.onnx").write_bytes(b"nothing")
        open_source(str(tmp_path / "bad.onnx"))
    with pytest.raises(SynthdepthError, match="safetensors file that `synthdepth train` wrote"):
        (tmp_path / "bad.safetensors").write_bytes(b"nothing")
        open_source(str(tmp_path / "bad.safetensors"))


def test_baselines_stand_beside_and_are_fitted_to_the_train_split(made, samples, table):
    names = [source["name"] for source in table["sources"]]
    assert names == ["ours", "theirs", "baseline:mean", "baseline:ground", "baseline:triangulation"]
    mean = np.mean([s.depth_m for s in PairDataset(made, split="train")], axis=0)
    expected = np.mean([paper_metrics(mean, sample.depth_m)["rmse"] for sample in samples])
    images = table["sources"][2]["protocols"][0]["images"]
    assert images["rmse"] == pytest.approx(expected, rel=1e-5)


def test_without_a_train_split_what_is_fitted_is_left_out_and_told(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=1)
    only = pair_data([folder], split="test")
    only = dataclasses.replace(only, train=None)
    with pytest.raises(SynthdepthError, match="baseline:mean is fitted to the split train"):
        open_source("baseline:mean", train=only.train)
    opened, notes = run._opened(["baseline:ground"], None, only, None, "fp32", False)
    assert [source.name for source in opened] == ["baseline:ground", "baseline:triangulation"]
    assert len(notes) == 1 and notes[0].startswith("Without baseline:mean: ")


def test_mirrored_pictures_are_mirrored_back(samples):
    class Columns(Source):
        name = "columns"

        def depth_m(self, samples):
            return [sample.rgb[..., 0].astype(float) + 1 for sample in samples]

    averaged = FlipAveraged(Columns()).depth_m(samples)
    np.testing.assert_array_equal(averaged, Columns().depth_m(samples))


def test_kitti_under_several_protocols(made, tmp_path):
    export("kitti", made, tmp_path / "kitti")
    names = ["eigen-garg-full-80", "benchmark", "eigen-garg-full-80/median"]
    evaluate(
        [Noisy("ours")], out=tmp_path / "out", kitti=tmp_path / "kitti", split="val",
        protocols=names, workers=1, panels=1,
    )  # fmt: skip
    found = json.loads((tmp_path / "out/report.json").read_text())
    assert [source["name"] for source in found["sources"]] == ["ours"]
    alone = Evaluation([PROTOCOLS["benchmark"]])
    frames = KittiDataset(tmp_path / "kitti", split="val")
    for sample in frames:
        alone.add(
            Noisy("ours").one(sample), sample.depth_m, valid=sample.valid,
            max_depth_m=sample.max_depth_m, scene=scene_of(sample),
        )  # fmt: skip
    garg, benchmark, median = found["sources"][0]["protocols"]
    assert benchmark["images"] == pytest.approx(dataclasses.asdict(alone.results()[0].images))
    assert found["pictures"] == len(frames) == benchmark["images"]["images"]
    assert "Garg crop" in garg["terms"] and median["ratio_median"] != 1
    assert {row["method"] for row in found["published"]} >= {"the paper", "BTS"}
    with pytest.raises(SynthdepthError, match="benchmark's frame needs at least 1216x352"):
        evaluate([Noisy("ours")], out=tmp_path / "no", kitti=tmp_path / "kitti", workers=1)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"sources": []}, "no source given"),
        ({"sources": ["no/such"]}, "source 'no/such': there is no such file or folder; allowed"),
        ({"sources": ["baseline:best"]}, "'baseline:best': allowed are baseline:constant"),
        ({"sources": [Noisy("a"), Noisy("a")]}, "two sources are a: allowed is LABEL=a"),
        ({"protocols": ["eigen"]}, "protocol 'eigen': allowed are synthdepth"),
        ({"folders": []}, "either datasets or a folder of KITTI"),
        ({"kitti": "somewhere"}, "either datasets or a folder of KITTI"),
        ({"folders": ["no/set"]}, "no/set"),
        ({"split": "val"}, "split = 'val': allowed are test, train"),
        ({"baselines": ["best"]}, "'baseline:best': allowed are"),
        ({"batch_size": 0}, "batch_size 0: allowed is a whole number from 1"),
        ({"workers": 0}, "workers 0: allowed is a whole number from 1"),
        ({"max_pairs": -1}, "max_pairs -1: allowed is a whole number from 0"),
    ],
)
def test_mistakes_are_told_in_one_line(made, tmp_path, given, told):
    arguments = {"sources": [Noisy("ours")], "folders": [made], "workers": 1} | given
    with pytest.raises(SynthdepthError, match=re.escape(told)) as raised:
        evaluate(out=tmp_path / "o", **arguments)
    assert "\n" not in str(raised.value)
    assert not list(tmp_path.iterdir())


def test_what_a_source_needs_and_the_data_lack_is_told(tmp_path):
    folder = make_dataset(tmp_path / "set", shards=2, pairs=1)
    with pytest.raises(SynthdepthError, match="has no flow, which a source needs: there is rgb"):
        evaluate(["baseline:triangulation-exact-flow"], [folder], out=tmp_path / "o", workers=1)
    (tmp_path / "file").write_text("")
    with pytest.raises(SynthdepthError, match="file: allowed is a folder"):
        evaluate([Noisy("ours")], [folder], out=tmp_path / "file", workers=1)


def test_a_worker_that_dies_is_told_in_one_line(made, tmp_path, monkeypatch):
    monkeypatch.setattr(run, "_PART", 5)
    with pytest.raises(SynthdepthError, match="a worker process died"):
        evaluate([Deadly("deadly")], [made], out=tmp_path / "o", workers=2, baselines=())
    assert not (tmp_path / "o").exists()


def test_the_page_shows_what_the_json_says(page, table):
    cells = {text for _, text in page.all("td", "number")}
    images = table["sources"][0]["protocols"][0]["images"]
    low, high = table["sources"][0]["protocols"][0]["intervals"]["rmse"]
    assert f"{images['rmse']:.3f}{low:.3f} to {high:.3f}" in cells
    assert f"{images['delta_1']:.4f}" in {text for _, text in page.all("dd")}
    heads = {text for _, text in page.all("th", "source")}
    assert heads == {source["name"] for source in table["sources"]}
    # Frame, truth, and prediction and error of each of the two; two panels, two of the worst.
    assert len(page.all("figure", "pair")) == 4 and len(page.all("img")) == 4 * 6
    rows = [text for attrs, text in page.all("th") if attrs.get("scope") == "row"]
    assert any(text.startswith("fog") for text in rows)
    assert "the paper: embedded flow, interval 5" in rows


def test_thin_things_come_first(made, samples):
    tally = Tally([PROTOCOLS["synthdepth"]], 200.0, 0)
    for number, sample in enumerate(samples):
        seg = sample.seg.copy()
        seg[:4], seg[4:8] = 12, 11
        sample = dataclasses.replace(sample, seg=seg)
        tally.add(Noisy("ours").one(sample), sample, number, "dense")
    data = pair_data([made], split="test")
    report = make_report(data, [Noisy("ours")], [tally], seed=0)
    rows = dict(group_tables(report))["Class"]
    assert {row.name for row in rows[:2]} == set(THIN_CLASSES)


def test_the_markdown_says_the_same(out, table):
    text = (out / "report.md").read_text()
    images = table["sources"][0]["protocols"][0]["images"]
    low, high = table["sources"][0]["protocols"][0]["intervals"]["abs_rel"]
    row = next(line for line in text.splitlines() if line.startswith("| AbsRel |"))
    assert row.split("|")[2].strip() == f"{images['abs_rel']:.4f} ({low:.4f} to {high:.4f})"
    for lines in re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE):
        assert len({line.count(" |") for line in lines.splitlines()}) == 1


def test_the_summary_has_a_line_a_source_and_protocol(made, tmp_path):
    sources = [Noisy("ours"), Noisy("theirs", 0.4)]
    report = evaluate(sources, [made], out=tmp_path, workers=1, baselines=(), panels=0)
    lines = summary(report).splitlines()
    assert [line.split()[0] for line in lines[1:]] == [
        "synthdepth", "ours", "theirs", "synthdepth-in-range", "ours", "theirs",
    ]  # fmt: skip
    rmse = report.sources[1].protocols[0].result.images.rmse
    assert lines[3].split()[1] == f"{rmse:.3f}"


def test_the_page_is_whole_in_itself_and_can_be_read_aloud(out, page):
    text = (out / "report.html").read_text()
    assert "<script" not in text and "url(http" not in text
    addresses = [a[name] for _, a, _ in page.found for name in ("src", "href") if name in a]
    assert all(address.startswith(("data:", "#")) for address in addresses)
    sections = {attrs["id"] for attrs, _ in page.all("section")}
    assert {address[1:] for address in addresses if address.startswith("#")} == sections
    assert all(attrs["alt"] for attrs, _ in page.all("img"))
    assert all(attrs["aria-label"] for attrs, _ in page.all("svg"))


def test_what_names_and_files_say_is_never_markup(made, tmp_path):
    evil = '"><script>alert(1)</script><img src=x onerror=alert(1)> | x'
    sources = [Noisy(evil, says=evil), Noisy("b")]
    evaluate(sources, [made], out=tmp_path, workers=1, baselines=(), panels=1)
    page = Page((tmp_path / "report.html").read_text())
    assert not page.all("script")
    assert all(attrs["src"].startswith("data:image/") for attrs, _ in page.all("img"))
    assert not any(name.startswith("on") for _, attrs, _ in page.found for name in attrs)
    assert page.all("h1")[0][1] == evil
    text = (tmp_path / "report.md").read_text()
    assert "<script" not in text and " | x" not in text.replace("\\|", "")


@pytest.mark.parametrize("width", [1280, 500])
def test_a_browser_shows_it(out, browse, tmp_path, width):  # noqa: F811
    text = (out / "report.html").read_text()
    text = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", text)
    text = text.replace('loading="lazy" decoding="async"', "").replace("</body>", MEASURE)
    measuring = tmp_path / "measuring.html"
    measuring.write_text(text)
    measured, _ = browse(measuring, width)
    assert measured["images"] == 4 * 6
    assert measured["broken"] == measured["squeezed"] == measured["empty"] == 0
    assert measured["needs"] <= measured["width"]
    assert measured["resources"] == 0


def test_a_browser_has_nothing_to_complain_about(out, browse):  # noqa: F811
    _, log = browse(out / "report.html", 1280)
    assert "CONSOLE" not in log
