"""What the tables of a report hold, for HTML and Markdown alike."""

import dataclasses
from collections.abc import Iterator, Sequence

from synthdepth.evaluate.bootstrap import Interval
from synthdepth.evaluate.breakdown import AXES, THIN_CLASSES, Group
from synthdepth.evaluate.metrics import METRICS
from synthdepth.evaluate.protocols import Protocol
from synthdepth.evaluate.record import Report, metric_name, metric_text

# The paper's five.
HEADLINE = ("rmse", "abs_rel", "delta_1", "delta_2", "delta_3")
# Of a group: the metric, and whether saturated pixels count.
_COLUMNS = (("abs_rel", False), ("rmse", False), ("rmse", True))
# Axes of whole pictures: a single group on one of them is everything once more.
_WHOLE = ("altitude", "speed", "map", "condition")
_TITLES = {
    "all": "Pixels",
    "range": "True depth",
    "class": "Class",
    "altitude": "Altitude",
    "speed": "Speed",
    "map": "Map",
    "condition": "Condition",
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Row:
    """A group of the breakdown.

    Attributes:
        name: of the group.
        note: how much there is of it.
        columns: names of a source's columns.
        cells: (sources, columns) texts.
    """

    name: str
    note: str
    columns: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]


def group_tables(report: Report) -> Iterator[tuple[str, list[Row]]]:
    """The tables of the breakdown: title and rows; axes that tell nothing are left out."""
    groups = list(report.sources[0].groups)
    for axis in AXES:
        names = list(dict.fromkeys(group.name for group in groups if group.axis == axis))
        if axis == "all" or names == ["unlabelled"] or (len(names) == 1 and axis in _WHOLE):
            continue
        if axis == "class":
            names.sort(key=lambda name: name not in THIN_CLASSES)
        if names:
            yield _TITLES[axis], [_row(report, axis, name) for name in names]


def range_bands(report: Report) -> list[str]:
    """The bands of true depth that were met."""
    return [group.name for group in report.sources[0].groups if group.axis == "range"]


def _row(report: Report, axis: str, name: str) -> Row:
    columns = _COLUMNS
    if axis == "range":
        columns = [(metric, name == "saturated") for metric in ("abs_rel", "rmse", "delta_1")]
    elif not report.dense:
        columns = [(metric, True) for metric in ("abs_rel", "rmse", "delta_1")]
    mixed = axis != "range" and report.dense
    titles = [
        metric_name(metric).partition(" [")[0]
        + ((", all" if saturated else ", in range") if mixed else "")
        for metric, saturated in columns
    ]
    cells = tuple(
        tuple(_value(source, Group(axis=axis, name=name, saturated=s), m) for m, s in columns)
        for source in report.sources
    )
    return Row(name=name, note=_amount(report, axis, name), columns=tuple(titles), cells=cells)


def _value(source, group: Group, metric: str) -> str:
    score = source.groups.get(group)
    return metric_text(metric, getattr(score.result.images, metric) if score else None)


def _amount(report: Report, axis: str, name: str) -> str:
    """Share of the pixels, and the pictures where whole ones are meant."""
    groups = report.sources[0].groups

    def found(axis: str, name: str):
        both = (Group(axis=axis, name=name, saturated=saturated) for saturated in (True, False))
        return next((groups[group].result for group in both if group in groups), None)

    group, everything = found(axis, name), found("all", "all")
    share = f"{100 * group.pixels.pixels / everything.pixels.pixels:.2g} % of pixels"
    if axis in ("range", "class"):
        return share
    scenes = len(group.by_scene)
    return f"{group.images.images:,} pictures, {scenes:,} scene{'s' * (scenes > 1)}"


def ordered_metrics(protocol: Protocol) -> list[str]:
    """What a protocol prints, what most ask for first, and the mean truth, which tells crops."""
    first = (*HEADLINE, "mae", "bias", "boundary_f1")
    names = [name for name in (*first, *METRICS) if name in protocol.metrics]
    names.insert(min(len(names), len(first)), "mean_truth")
    return list(dict.fromkeys(names))


def best_of(metric: str, values: Sequence[float | None]) -> float | None:
    """The best of some values of a metric; None where there is none."""
    known = [value for value in values if value is not None]
    better = METRICS[metric].better
    if not known or not better:
        return None
    return min(known) if better == "lower" else max(known)


def interval_text(metric: str, interval: Interval) -> str:
    """Both ends, or nothing where there are none."""
    if interval.low is None:
        return ""
    return f"{metric_text(metric, interval.low)} to {metric_text(metric, interval.high)}"


def published_rows(report: Report) -> Iterator[tuple[str, list[str], str, str]]:
    """Method, the `HEADLINE` metrics, protocol, and where it is printed."""
    for row in report.published:
        values = ["–" if (v := getattr(row, name)) is None else f"{v:g}" for name in HEADLINE]
        source = f"{row.source}: {row.note}" if row.note else row.source
        yield row.method, values, row.protocol or "not stated", source
