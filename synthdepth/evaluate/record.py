"""What an evaluation found, as a record: the figures of the reports, and its JSON."""

import dataclasses
import json
from collections.abc import Sequence

import synthdepth
from synthdepth.evaluate.accumulate import ErrorHistogram
from synthdepth.evaluate.bootstrap import Interval, difference_intervals, scene_intervals
from synthdepth.evaluate.breakdown import Group, GroupResult
from synthdepth.evaluate.data import Data
from synthdepth.evaluate.evaluation import ProtocolResult
from synthdepth.evaluate.metrics import METRICS
from synthdepth.evaluate.published import EIGEN_SPLIT, TABLE_2, TABLE_3, TABLE_4, Published
from synthdepth.evaluate.sources import Source
from synthdepth.evaluate.tally import DepthHistogram, Picture, Tally
from synthdepth.seeding import lane

LEVEL = 0.95
# Groups are many: fewer draws do for them.
_DRAWS, _GROUP_DRAWS = 2000, 500


@dataclasses.dataclass(frozen=True, kw_only=True)
class ProtocolScore:
    """What a source has under a protocol.

    Attributes:
        result: the metrics.
        intervals: of the means over pictures, by metric.
        difference: to the first source, likewise; None for itself.
    """

    result: ProtocolResult
    intervals: dict[str, Interval]
    difference: dict[str, Interval] | None


@dataclasses.dataclass(frozen=True, kw_only=True)
class GroupScore:
    """What a source has on a group of pixels; `intervals` as `ProtocolScore` has them."""

    result: GroupResult
    intervals: dict[str, Interval]


@dataclasses.dataclass(frozen=True, kw_only=True)
class SourceScore:
    """All that was found of a source.

    Attributes:
        name, says: of the source.
        protocols: in the order they were asked for.
        groups: of `Breakdown`.
        errors, depths: of all pixels with a truth.
        worst: pictures, worst first.
    """

    name: str
    says: str
    protocols: tuple[ProtocolScore, ...]
    groups: dict[Group, GroupScore]
    errors: ErrorHistogram
    depths: DepthHistogram
    worst: tuple[Picture, ...]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Report:
    """An evaluation.

    Attributes:
        data, split: what was evaluated on, in words.
        dense: whether every pixel had a truth.
        far_m: where charts end [m].
        pictures, scenes: how many.
        sources: the first is the one that the others are compared with.
        published: what others have printed, on other data.
        seed: of the intervals.
        notes: what else there is to say.
    """

    data: str
    split: str
    dense: bool
    far_m: float
    pictures: int
    scenes: int
    sources: tuple[SourceScore, ...]
    published: tuple[Published, ...]
    seed: int
    notes: tuple[str, ...]

    @property
    def places(self) -> str:
        """What the pictures are grouped by: scenes, or KITTI's drives."""
        return "scenes" if self.dense else "drives"

    def as_json(self) -> str:
        """All of it but the pictures."""
        table = {
            "synthdepth": synthdepth.__version__,
            "data": self.data,
            "split": self.split,
            "pictures": self.pictures,
            "scenes": self.scenes,
            "seed": self.seed,
            "level": LEVEL,
            "notes": list(self.notes),
            "sources": [_source_table(source) for source in self.sources],
            "published": [dataclasses.asdict(row) for row in self.published],
        }
        return json.dumps(table) + "\n"


def make_report(
    data: Data,
    sources: Sequence[Source],
    tallies: Sequence[Tally],
    *,
    seed: int,
    notes: Sequence[str] = (),
) -> Report:
    """The report of what was counted.

    Args:
        data: what was evaluated on.
        sources: at least one.
        tallies: of each.
        seed: of the scenes that the intervals draw.
        notes: what else there is to say.
    """
    first = tallies[0].evaluation.results()
    scored = tuple(
        _scored(source, tally, None if tally is tallies[0] else first, seed)
        for source, tally in zip(sources, tallies, strict=True)
    )
    return Report(
        data=data.says,
        split=data.split,
        dense=data.dense,
        far_m=data.far_m,
        pictures=len(data.numbers),
        scenes=max(len(result.by_scene) for result in first),
        sources=scored,
        published=(*TABLE_2, *TABLE_3) if data.dense else (*TABLE_4, *EIGEN_SPLIT),
        seed=seed,
        notes=tuple(notes),
    )


def _scored(
    source: Source, tally: Tally, first: list[ProtocolResult] | None, seed: int
) -> SourceScore:
    protocols = []
    for number, result in enumerate(tally.evaluation.results()):
        # The same lane for all sources: the same scenes are drawn.
        rng, difference = lane(seed, "bootstrap"), None
        intervals = scene_intervals(rng, result.by_scene, level=LEVEL, draws=_DRAWS)
        if first is not None:
            difference = difference_intervals(
                lane(seed, "bootstrap"),
                result.by_scene,
                first[number].by_scene,
                level=LEVEL,
                draws=_DRAWS,
            )
        protocols.append(ProtocolScore(result=result, intervals=intervals, difference=difference))
    groups = {}
    for result in tally.breakdown.results():
        rng = lane(seed, "bootstrap", "groups")
        intervals = scene_intervals(rng, result.by_scene, level=LEVEL, draws=_GROUP_DRAWS)
        groups[result.group] = GroupScore(result=result, intervals=intervals)
    return SourceScore(
        name=source.name,
        says=source.says,
        protocols=tuple(protocols),
        groups=groups,
        errors=tally.errors,
        depths=tally.depths,
        worst=tuple(tally.worst),
    )


def _source_table(source: SourceScore) -> dict:
    return {
        "name": source.name,
        "says": source.says,
        "protocols": [_protocol_table(score) for score in source.protocols],
        "groups": [
            dataclasses.asdict(group) | _metrics_table(score.result, score.intervals)
            for group, score in source.groups.items()
        ],
        "errors": _histogram_table(source.errors),
        "depths": _histogram_table(source.depths),
        "worst": [dataclasses.asdict(picture) for picture in source.worst],
    }


def _protocol_table(score: ProtocolScore) -> dict:
    result = score.result
    table = {
        "protocol": result.protocol.name,
        "terms": result.terms,
        "left_out": result.left_out,
        "ratio_median": result.ratio_median,
        "prints": list(result.protocol.metrics),
    } | _metrics_table(result, score.intervals)
    if score.difference is not None:
        table["difference"] = {
            name: dataclasses.asdict(interval) for name, interval in score.difference.items()
        }
    return table


def _metrics_table(result: ProtocolResult | GroupResult, intervals: dict[str, Interval]) -> dict:
    return {
        "images": dataclasses.asdict(result.images),
        "pixels": dataclasses.asdict(result.pixels),
        "intervals": {
            name: [interval.low, interval.high]
            for name, interval in intervals.items()
            if interval.low is not None
        },
    }


def _histogram_table(histogram: ErrorHistogram | DepthHistogram) -> dict:
    return {"edges_m": histogram.edges_m.tolist(), "counts": histogram.counts.tolist()}


def metric_text(name: str, value: float | None) -> str:
    """A metric as tables have it."""
    if value is None:
        return "–"
    text = f"{value:.3f}" if METRICS[name].unit or abs(value) >= 10 else f"{value:.4f}"
    return text.replace("-", "−")


def metric_name(name: str) -> str:
    """A metric's name as tables have it, with its unit."""
    names = {"rmse": "RMSE", "abs_rel": "AbsRel", "mae": "MAE", "bias": "bias", "irmse": "iRMSE"}
    names |= {f"delta_{n}": f"δ{sign}" for n, sign in zip((1, 2, 3), "₁₂₃", strict=True)}
    unit = METRICS[name].unit
    return names.get(name, name.replace("_", " ")) + (f" [{unit}]" if unit else "")
