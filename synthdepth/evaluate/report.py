"""An evaluation as one HTML page: no file beside it, no network, no script.

Everything that comes from files is escaped, and the page forbids itself to load anything.
"""

from collections.abc import Sequence
from html import escape
from importlib.resources import files
from string import Template

import numpy as np

from synthdepth.charts.axes import linear_axis
from synthdepth.charts.elements import card, numeric, page_style, table
from synthdepth.charts.svg import colour_scale, depth_scale
from synthdepth.evaluate import figures
from synthdepth.evaluate.breakdown import Group
from synthdepth.evaluate.metrics import METRICS
from synthdepth.evaluate.panels import Panel
from synthdepth.evaluate.record import LEVEL, Report, SourceScore, metric_name, metric_text
from synthdepth.evaluate.tables import (
    HEADLINE,
    Row,
    best_of,
    group_tables,
    interval_text,
    ordered_metrics,
    published_rows,
    range_bands,
)
from synthdepth.pix2pix.panels import colour_error

# Rows of a protocol that are seen at once.
_AT_FIRST = 10


def html_page(report: Report, typical: Sequence[Panel], worst: Sequence[Panel]) -> str:
    """The page.

    Args:
        report: what was found.
        typical: pictures evenly out of the data.
        worst: the first source's worst pictures.
    """
    first = report.sources[0]
    against = len(report.sources) - 1
    lead = (
        f"{report.pictures:,} pictures of {report.scenes:,} {report.places}: {report.data}, split "
        f"{report.split}"
    )
    parts = {
        "title": f"{escape(first.name)} (synthdepth evaluation)",
        "style": page_style() + (files("synthdepth.evaluate") / "report.css").read_text(),
        "name": escape(first.name),
        "lead": escape(lead) + (f", beside {against} other{'s' * (against > 1)}." * bool(against)),
        "notes": "".join(f'<p class="warning">{escape(note)}</p>' for note in report.notes),
        "tiles": _headline(report),
        "intervals_said": _intervals_said(report),
        "legend": _legend(report.sources) if against else "",
        "results": "".join(_results(report, number) for number in range(len(first.protocols))),
        "where_said": "Every pixel with a truth, in metres and uncropped whatever the protocols; "
        "bars with their intervals, RMSE in metres."
        + " “In range” leaves out pixels whose truth is only known to be beyond the range."
        * report.dense,
        "range_charts": _range_charts(report),
        "groups": "".join(_group_table(report, name, rows) for name, rows in group_tables(report)),
        "errors_said": "Prediction minus truth over all pixels with a truth: right of 0 the "
        "prediction is too far, which is the dangerous side.",
        "error_chart": _error_chart(report),
        "depth_charts": "".join(
            card(
                source.name,
                "predicted depth upwards, true depth to the right, metres; stronger is more often",
                figures.depth_chart(source.depths, source.name, number),
            )
            for number, source in enumerate(report.sources)
        ),
        "scales": _scales(report.far_m),
        "panels": _panels("Evenly out of the data", typical)
        + _panels(f"The worst of {first.name}, by AbsRel", worst),
        "published_said": "As printed, each on the data and by the protocol of its authors: not to "
        "be compared digit by digit with the figures above, nor with one another.",
        "published": _published(report),
        "sources": _sources(report),
    }
    return Template((files("synthdepth.evaluate") / "report.html").read_text()).substitute(parts)


def _intervals_said(report: Report) -> str:
    if report.scenes < 2:
        return "; intervals need two scenes or more"
    return (
        f"; in small their {100 * LEVEL:.0f} % intervals over the {report.scenes} {report.places} "
        "(bootstrap)"
    )


def _headline(report: Report) -> str:
    score = report.sources[0].protocols[0]
    tiles = {"Pictures": f"{score.result.images.images:,}"}
    for name in HEADLINE:
        text = metric_text(name, getattr(score.result.images, name))
        unit = METRICS[name].unit
        plain = metric_name(name).partition(" [")[0]
        tiles[plain] = f"{text} <small>{unit}</small>" if unit else text
    return "".join(f"<div><dt>{name}</dt><dd>{text}</dd></div>" for name, text in tiles.items())


def _legend(sources: Sequence[SourceScore]) -> str:
    chips = "".join(
        f'<li><span class="swatch k{number % figures.COLOURS}"></span>{escape(source.name)}</li>'
        for number, source in enumerate(sources)
    )
    return f'<ul class="chips legend">{chips}</ul>'


def _heads(report: Report, first: str, each: int = 1) -> str:
    span = f' colspan="{each}"' if each > 1 else ""
    names = "".join(
        f'<th class="number source{" first" * (each > 1)}"{span}>{escape(source.name)}</th>'
        for source in report.sources
    )
    return f"<th>{first}</th>{names}"


def _results(report: Report, number: int) -> str:
    """The table of a protocol, and of the differences to the first source."""
    scores = [source.protocols[number] for source in report.sources]
    result = scores[0].result
    names = ordered_metrics(result.protocol)
    rows, differences = [], []
    for name in names:
        values = [getattr(score.result.images, name) for score in scores]
        best = best_of(name, values)
        row = [f"<th scope=row>{escape(metric_name(name))}</th>"]
        for score, value in zip(scores, values, strict=True):
            small = interval_text(name, score.intervals[name])
            kind = "number best" if value == best and len(values) > 1 else "number"
            row.append(_cell(metric_text(name, value), small, kind))
        rows.append(row)
        if METRICS[name].better:
            differences.append(row[:1] + [_difference(name, score) for score in scores[1:]])
    left_out = f", {result.left_out} left out" if result.left_out else ""
    title = f"{result.protocol.name} <small>{result.images.images:,} pictures{left_out}</small>"
    head = _heads(report, "Metric")
    parts = [_scroll(table(head, rows[:_AT_FIRST]), result.protocol.name)]
    if len(rows) > _AT_FIRST:
        more = _scroll(table(head, rows[_AT_FIRST:]), f"more of {result.protocol.name}")
        parts.append(f"<details><summary>More metrics</summary>{more}</details>")
    if len(scores) > 1:
        others = "".join(
            f'<th class="number source">{escape(source.name)}</th>' for source in report.sources[1:]
        )
        said = f"Minus {escape(report.sources[0].name)}"
        parts.append(
            f"<details><summary>Differences to {escape(report.sources[0].name)}, with their "
            "intervals over the same places; bold is what these scenes can tell</summary>"
            + _scroll(table(f"<th>{said}</th>{others}", differences), "differences")
            + "</details>"
        )
    return f'<h3>{title}</h3>{"".join(parts)}<p class="terms">{escape(result.terms)}.</p>'


def _difference(name: str, score) -> str:
    found = score.difference[name]
    if found.value is None:
        return _cell("–", "", "number")
    told = found.low is not None and (found.low > 0 or found.high < 0)
    sign = "+" if found.value >= 0 else "−"
    text = sign + metric_text(name, abs(found.value))
    return _cell(text, interval_text(name, found), "number told" if told else "number")


def _cell(text: str, small: str, kind: str) -> str:
    below = f"<small>{escape(small)}</small>" if small else ""
    return f'<td class="{kind}">{escape(text)}{below}</td>'


def _scroll(content: str, said: str) -> str:
    return (
        f'<div class="card scroll" role="region" aria-label="{escape(said)}" tabindex="0">'
        f"{content}</div>"
    )


def _range_charts(report: Report) -> str:
    bands = range_bands(report)
    # The unit is in the title: so many names have little room.
    names = [band.replace(" m", "").replace(" and more", "+") for band in bands]
    charts = []
    for metric in ("abs_rel", "rmse"):
        bars = [
            figures.Bars(
                name=source.name,
                values=[
                    source.groups[group].intervals[metric] if group in source.groups else None
                    for group in (
                        Group(axis="range", name=band, saturated=band == "saturated")
                        for band in bands
                    )
                ],
            )
            for source in report.sources
        ]
        title = metric_name(metric)
        chart = figures.bar_chart(names, bars, name=title, unit=METRICS[metric].unit)
        charts.append(card(f"{title} by true depth", "bands in metres", chart))
    return "".join(charts)


def _group_table(report: Report, axis: str, rows: Sequence[Row]) -> str:
    """One axis of the breakdown: a row a group."""
    columns = rows[0].columns
    each = "".join(
        f'<th class="number{" first" * (k == 0)}">{escape(column)}</th>'
        for k, column in enumerate(columns)
    )
    head = _heads(report, "", len(columns)).replace("<th></th>", "<td></td>")
    head += f"</tr><tr><th>{escape(axis)}</th>{each * len(report.sources)}"
    body = []
    for row in rows:
        cells = [f"<th scope=row>{escape(row.name)}<small>{escape(row.note)}</small></th>"]
        cells += [
            _cell(text, "", "number first" if k == 0 else "number")
            for texts in row.cells
            for k, text in enumerate(texts)
        ]
        body.append(cells)
    return f"<h3>{escape(axis)}</h3>" + _scroll(table(head, body), axis)


def _error_chart(report: Report) -> str:
    errors = {source.name: source.errors for source in report.sources}
    chart = figures.error_chart(errors, report.far_m / 2)
    near = ", ".join(f"{name} {100 * share:.1f} %" for name, share in _within(report, 1.0).items())
    legend = _legend(report.sources) if len(errors) > 1 else ""
    return (
        '<figure class="card"><figcaption>Share of pixels by error<small>metres, bins of '
        f"{report.far_m / 200:g} m, logarithmic shares; within 1 m: {escape(near)}</small>"
        f'</figcaption>{legend}<div class="scroll wide" role="region" tabindex="0" '
        f'aria-label="Share of pixels by error">{chart}</div></figure>'
    )


def _within(report: Report, limit_m: float) -> dict[str, float]:
    """Share of errors below a limit, to whole bins."""
    shares = {}
    for source in report.sources:
        edges, counts = source.errors.edges_m, source.errors.counts
        inside = (edges[:-1] >= -limit_m - 1e-9) & (edges[1:] <= limit_m + 1e-9)
        shares[source.name] = float(counts[inside].sum() / max(counts.sum(), 1))
    return shares


def _scales(far_m: float) -> str:
    axis = linear_axis(np.array([0.0, 0.5]), bins=32)
    ones = np.ones((1, len(axis.edges)))
    scale = colour_scale(
        axis,
        colour_error(ones, ones + axis.edges)[0],
        {tick: f"{100 * tick:g} %" for tick in axis.ticks[:-1]},
        kind="error",
        end="≥ 50 %",
        said="Error colours: from black at 0 by red and yellow to white at 50 % and more",
    )
    return (
        f'<div class="card scales"><div><h3>Depth, in metres</h3>{depth_scale(far_m)}</div>'
        f"<div><h3>Error</h3>{scale}</div></div>"
    )


def _panels(title: str, panels: Sequence[Panel]) -> str:
    if not panels:
        return ""
    many = len(panels[0].tiles)
    columns = many if many <= 6 else -(-many // 2)
    return (
        f'<h3>{escape(title)}</h3><div class="pairs" style="--pair:{220 * columns}px">'
        f"{''.join(_panel(panel, columns) for panel in panels)}</div>"
    )


def _panel(panel: Panel, columns: int) -> str:
    facts = "".join(f"<span>{escape(fact)}</span>" for fact in panel.facts)
    items = "".join(f"<li>{t.img()}<span>{escape(t.name)}</span></li>" for t in panel.tiles)
    return (
        f'<figure class="pair"><figcaption><code>{escape(panel.key)}</code>{facts}</figcaption>'
        f'<ul style="--n:{columns};--narrow:{min(columns, 3)}">{items}</ul></figure>'
    )


def _published(report: Report) -> str:
    heads = ("Method", *(metric_name(name) for name in HEADLINE), "Protocol", "Printed in")
    numbers = len(HEADLINE)
    head = "".join(
        f'<th class="number">{escape(text)}</th>' if 0 < k <= numbers else f"<th>{text}</th>"
        for k, text in enumerate(heads)
    )
    rows = [
        [f"<th scope=row>{escape(method)}</th>"]
        + [numeric(value) for value in values]
        + [f"<td>{escape(protocol)}</td>", f"<td>{escape(source)}</td>"]
        for method, values, protocol, source in published_rows(report)
    ]
    return _scroll(table(head, rows), "published")


def _sources(report: Report) -> str:
    rows = [
        [f"<th scope=row>{escape(source.name)}</th>", f"<td>{escape(source.says)}</td>"]
        for source in report.sources
    ]
    facts = {"Data": report.data, "Split": report.split, "Seed": str(report.seed)}
    rows += [
        [f"<th scope=row>{name}</th>", f"<td>{escape(value)}</td>"] for name, value in facts.items()
    ]
    return f'<div class="card">{table("", rows, "facts")}</div>'
