"""An evaluation as text: Markdown to paste where tables are read, and lines for a terminal."""

from collections.abc import Sequence

from synthdepth.evaluate.record import LEVEL, Report, metric_name, metric_text
from synthdepth.evaluate.tables import (
    HEADLINE,
    group_tables,
    interval_text,
    ordered_metrics,
    published_rows,
)


def markdown(report: Report) -> str:
    """The tables of a report."""
    names = [source.name for source in report.sources]
    parts = [
        f"# {_plain(names[0])}",
        f"{report.pictures:,} pictures of {report.scenes:,} {report.places}: "
        f"{_plain(report.data)}, split {_plain(report.split)}. Means over pictures, with "
        f"{100 * LEVEL:.0f} % intervals over {report.places}.",
        *(_plain(note) for note in report.notes),
    ]
    for number, score in enumerate(report.sources[0].protocols):
        protocol = score.result.protocol
        rows = []
        for metric in ordered_metrics(protocol):
            scores = [source.protocols[number] for source in report.sources]
            rows.append([metric_name(metric), *(_scored(metric, one) for one in scores)])
        parts += [
            f"## {protocol.name}",
            _table(["", *names], rows),
            f"{_plain(score.result.terms)}.",
        ]
    for title, rows in group_tables(report):
        columns = rows[0].columns
        head = [title, *(f"{name}: {column}" for name in names for column in columns)]
        body = [[row.name, *(text for texts in row.cells for text in texts)] for row in rows]
        parts += [f"## {title}", _table(head, body)]
    parts += [
        "## Published",
        "As printed, each on the data and by the protocol of its authors.",
        _table(
            ["", *(metric_name(name) for name in HEADLINE), "protocol", "printed in"],
            [[method, *values, *rest] for method, values, *rest in published_rows(report)],
        ),
        "## Sources",
        _table(["", ""], [[source.name, source.says] for source in report.sources]),
    ]
    return "\n\n".join(parts) + "\n"


def summary(report: Report) -> str:
    """The paper's five of every source under every protocol, for a terminal."""
    lines = [("", *(metric_name(name) for name in HEADLINE))]
    for number, first in enumerate(report.sources[0].protocols):
        lines.append((first.result.protocol.name, *("" for _ in HEADLINE)))
        for source in report.sources:
            images = source.protocols[number].result.images
            values = (metric_text(name, getattr(images, name)) for name in HEADLINE)
            lines.append((f"  {source.name}", *values))
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return "\n".join(
        "  ".join(
            cell.ljust(width) if k == 0 else cell.rjust(width)
            for k, (cell, width) in enumerate(zip(line, widths, strict=True))
        ).rstrip()
        for line in lines
    )


def _scored(metric: str, score) -> str:
    text = metric_text(metric, getattr(score.result.images, metric))
    interval = interval_text(metric, score.intervals[metric])
    return f"{text} ({interval})" if interval else text


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    lines = [head, ["---"] + ["---:"] * (len(head) - 1), *rows]
    return "\n".join(f"| {' | '.join(map(_plain, line))} |" for line in lines)


def _plain(text: str) -> str:
    """Text that ends no cell and begins no markup."""
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")
