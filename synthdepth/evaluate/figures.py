"""The charts of a report, as inline SVG: errors, errors by range, predicted against true depth."""

import base64
import dataclasses
import html
import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from synthdepth.charts.axes import linear_axis, log_axis, round_step
from synthdepth.charts.svg import BOTTOM, HEIGHT, LEFT, RIGHT, TOP, bar, label, line, svg
from synthdepth.evaluate.accumulate import ErrorHistogram
from synthdepth.evaluate.bootstrap import Interval
from synthdepth.evaluate.tally import DepthHistogram

# As many sources as the style sheet has colours.
COLOURS = 6
_WIDE, _HALF = 960, 560
_SQUARE = 320


def error_chart(errors: Mapping[str, ErrorHistogram], within_m: float) -> str:
    """How often errors occur (figure 14), a line a source; shares are logarithmic.

    Args:
        errors: by source, of the same bins.
        within_m: the chart ends here on both sides [m]; what is beyond is not drawn.
    """
    axis = linear_axis(np.array([-within_m, within_m]))
    low, high = axis.edges[0], axis.edges[-1]
    shares = {name: h.counts / max(h.counts.sum(), 1) for name, h in errors.items()}
    least = min((float(s[s > 0].min()) for s in shares.values() if s.any()), default=1e-4)
    decades = range(max(math.floor(math.log10(least)), -5), 1)

    def x(value: float) -> float:
        return LEFT + 16 + axis.place(value) * (_WIDE - LEFT - 16 - RIGHT)

    def y(share: float) -> float:
        part = (math.log10(max(share, 10.0 ** decades[0])) - decades[0]) / (0 - decades[0])
        return HEIGHT + 40 - BOTTOM - part * (HEIGHT + 40 - BOTTOM - TOP)

    foot = y(0)
    parts = []
    for decade in decades:
        parts.append(line(x(low), y(10.0**decade), x(high), y(10.0**decade), "grid"))
        share = f"{100 * 10.0**decade:g} %"
        parts.append(label(x(low) - 5, y(10.0**decade) + 4, share, "end"))
    parts += [label(x(tick), foot + 17, f"{tick:g}", "middle") for tick in axis.ticks]
    parts.append(line(x(low), foot, x(high), foot, "axis"))
    parts.append(line(x(0), TOP - 8, x(0), foot, "median"))
    for number, (name, histogram) in enumerate(errors.items()):
        edges, share = histogram.edges_m, shares[name]
        inside = (edges[:-1] >= low - 1e-9) & (edges[1:] <= high + 1e-9)
        points = []
        for k in np.flatnonzero(inside):
            start, end, part = edges[k], edges[k + 1], share[k]
            points += [f"{x(start):.1f},{y(part):.1f}", f"{x(end):.1f},{y(part):.1f}"]
        title = f"<title>{html.escape(name)}</title>"
        way = " ".join(points)
        parts.append(
            f'<polyline class="errors k{number % COLOURS}" points="{way}">{title}</polyline>'
        )
    said = f"Shares of errors from {low:g} to {high:g} m of {', '.join(errors)}"
    return svg(_WIDE, HEIGHT + 40, said, "".join(parts))


@dataclasses.dataclass(frozen=True, kw_only=True)
class Bars:
    """A source's bars: an `Interval` a group, or None where it has none."""

    name: str
    values: Sequence[Interval | None]


def bar_chart(groups: Sequence[str], bars: Sequence[Bars], *, name: str, unit: str) -> str:
    """Upright bars side by side with their intervals, groups left to right.

    Args:
        groups: their names.
        bars: of each source.
        name: what is shown.
        unit: of the values.
    """
    ends = [
        max(v.value, v.high or v.value)
        for source in bars
        for v in source.values
        if v is not None and v.value is not None
    ]
    most = max([*ends, 1e-6])
    step = round_step(most / 4)
    top = step * math.ceil(most / step - 1e-9)
    wide = (_HALF - LEFT - RIGHT) / len(groups)
    thick = min(0.8 * wide / len(bars), 34)

    def y(value: float) -> float:
        return HEIGHT - BOTTOM - value / top * (HEIGHT - BOTTOM - TOP)

    parts = []
    for number in range(1, round(top / step) + 1):
        at = y(number * step)
        parts.append(line(LEFT, at, _HALF - RIGHT, at, "grid"))
        parts.append(label(LEFT - 5, at + 4, f"{number * step:g}", "end"))
    for place, group in enumerate(groups):
        middle = LEFT + (place + 0.5) * wide
        for number, source in enumerate(bars):
            found = source.values[place]
            if found is None or found.value is None:
                continue
            left = middle + (number - len(bars) / 2) * thick
            told = f"{source.name}, {group}: {_interval_text(found)} {unit}".rstrip()
            kind = f"bar b{number % COLOURS}"
            parts.append(bar(left + 0.5, left + thick - 0.5, y(found.value), y(0), told, kind))
            if found.low is not None:
                at = left + thick / 2
                parts.append(line(at, y(found.low), at, y(found.high), "whisker"))
        parts.append(label(middle, HEIGHT - 7, group, "middle"))
    parts.append(line(LEFT, y(0), _HALF - RIGHT, y(0), "axis"))
    said = f"{name} by {', '.join(groups)}, of {', '.join(source.name for source in bars)}"
    return svg(_HALF, HEIGHT, said, "".join(parts))


def _interval_text(interval: Interval) -> str:
    ends = "" if interval.low is None else f" ({interval.low:.3g} to {interval.high:.3g})"
    return f"{interval.value:.3g}{ends}"


def depth_chart(depths: DepthHistogram, name: str, number: int) -> str:
    """Predicted depth upwards against true depth, both logarithmic; darker is more often.

    Args:
        depths: of one source.
        name: of the source.
        number: of the chart on its page.
    """
    low, high = float(depths.edges_m[0]), float(depths.edges_m[-1])
    axis = log_axis(low, high)
    side = _SQUARE - LEFT - RIGHT
    foot = _SQUARE - BOTTOM - 14

    def x(value: float) -> float:
        return LEFT + axis.place(value) * side

    def y(value: float) -> float:
        return foot - axis.place(value) * side

    # A mask, so that light and dark pages each have a colour of their own.
    common = np.log1p(depths.counts.T[::-1]) / max(np.log1p(depths.counts.max()), 1e-9)
    png = cv2.imencode(".png", np.rint(255 * common).astype(np.uint8))[1].tobytes()
    uri = f"data:image/png;base64,{base64.b64encode(png).decode()}"
    place = f'x="{LEFT}" y="{foot - side}" width="{side}" height="{side}"'
    parts = []
    for tick in axis.ticks:
        parts.append(line(x(tick), foot, x(tick), foot - side, "grid"))
        parts.append(line(LEFT, y(tick), LEFT + side, y(tick), "grid"))
        parts.append(label(x(tick), foot + 15, f"{tick:g}", "middle"))
        parts.append(label(LEFT - 5, y(tick) + 4, f"{tick:g}", "end"))
    parts += [
        f'<mask id="depths-{number}"><image href="{uri}" {place} preserveAspectRatio="none" '
        'style="image-rendering:pixelated"/></mask>',
        f'<rect class="depths k{number % COLOURS}" {place} mask="url(#depths-{number})"/>',
        line(LEFT, foot, LEFT + side, foot - side, "median"),
        label(LEFT + side / 2, _SQUARE - 5, "true depth [m]", "middle"),
    ]
    said = f"Predicted against true depth of {name}, from {low:g} to {high:g} m"
    return svg(_SQUARE, _SQUARE, said, "".join(parts))
