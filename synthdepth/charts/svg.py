"""Charts as inline SVG.

Colours and fonts are the page's: shapes carry classes, so that light and dark are decided in CSS.
Every chart has a label in words for whoever cannot see it, and a title on each of its parts.
"""

import html
import math
from collections.abc import Mapping

import numpy as np

from synthdepth.charts.axes import Axis, log_axis, number_text, round_step
from synthdepth.dataset.preview import colour_depth

WIDTH, HEIGHT = 360, 180
LEFT, RIGHT, TOP, BOTTOM = 40, 12, 20, 24


def histogram(
    values: np.ndarray, axis: Axis, *, name: str, unit: str, total: int | None = None
) -> str:
    """Shares of values a bin, with their median.

    Args:
        values: any shape, not empty; those outside the axis count in its first or last bin.
        axis: the bins.
        name: what is counted, for the label.
        unit: of the values.
        total: how many values 100 % are; these by default.
    """
    values = np.clip(np.ravel(values), axis.edges[0], axis.edges[-1])
    shares = np.histogram(values, axis.edges)[0] / (total or len(values))
    step = round_step(max(float(shares.max()), 1e-6) / 3)
    top = step * math.ceil(float(shares.max()) / step - 1e-9)

    def x(value: float) -> float:
        return LEFT + axis.place(value) * (WIDTH - LEFT - RIGHT)

    def y(share: float) -> float:
        return HEIGHT - BOTTOM - share / top * (HEIGHT - BOTTOM - TOP)

    parts = []
    for number in range(1, round(top / step) + 1):
        at = y(number * step)
        parts.append(line(LEFT, at, WIDTH - RIGHT, at, "grid"))
        parts.append(label(LEFT - 5, at + 4, f"{100 * number * step:g} %", "end"))
    for low, high, share in zip(axis.edges[:-1], axis.edges[1:], shares, strict=True):
        if share:
            told = f"{number_text(low)} to {number_text(high)} {unit}: {100 * share:.1f} %"
            parts.append(bar(x(low) + 0.5, x(high) - 0.5, y(share), y(0), told))
    parts.append(line(LEFT, y(0), WIDTH - RIGHT, y(0), "axis"))
    for tick in axis.ticks:
        parts.append(label(x(tick), HEIGHT - 7, f"{tick:g}", "middle"))
    middle = float(np.median(values))
    parts.append(line(x(middle), TOP - 8, x(middle), y(0), "median"))
    side, shift = ("end", -5) if axis.place(middle) > 0.6 else ("start", 5)
    text = f"median {number_text(middle)} {unit}"
    parts.append(label(x(middle) + shift, TOP + 1, text, side, "strong"))
    said = (
        f"Histogram of {name}: median {number_text(middle)} {unit}, "
        f"from {number_text(float(values.min()))} to {number_text(float(values.max()))} {unit}"
    )
    return svg(WIDTH, HEIGHT, said, "".join(parts))


def depth_scale(max_depth_m: float) -> str:
    """The colours of `colour_depth` over their depths, logarithmic; black is the range's end."""
    axis = log_axis(1.0, max_depth_m)
    colours = colour_depth(axis.edges[None], max_depth_m * 1.001)[0]
    said = f"Depth colours: from red at 1 m to violet at {max_depth_m:g} m, black from there"
    ticks = {tick: f"{tick:g}" for tick in axis.ticks[:-1]}
    return colour_scale(axis, colours, ticks, kind="depth", end=f"≥ {max_depth_m:g} m", said=said)


def colour_scale(
    axis: Axis, colours: np.ndarray, ticks: Mapping[float, str], *, kind: str, end: str, said: str
) -> str:
    """A bar of colours over their values, and the colour of what is at the end or beyond.

    Args:
        axis: of the values.
        colours: (B + 1, 3) uint8 RGB, at the axis's edges.
        ticks: values to name.
        kind: a word for the gradient's id: one scale of a kind on a page.
        end: what the colour at the end is, which carries the class "saturated".
        said: the scale in words.
    """
    stops = "".join(
        f'<stop offset="{axis.place(edge):.3f}" stop-color="rgb({r},{g},{b})"/>'
        for edge, (r, g, b) in zip(axis.edges, colours, strict=True)
    )
    wide, left = 270, 12
    parts = [
        f'<defs><linearGradient id="{kind}-colours">{stops}</linearGradient></defs>',
        f'<rect x="{left}" y="2" width="{wide}" height="14" rx="2" fill="url(#{kind}-colours)"/>',
        f'<rect class="saturated {kind}" x="{left + wide + 8}" y="2" width="46" height="14" '
        'rx="2"/>',
        label(left + wide + 31, 32, end, "middle"),
    ]
    for tick, text in ticks.items():
        parts.append(label(left + axis.place(tick) * wide, 32, text, "middle"))
    return svg(WIDTH, 38, said, "".join(parts))


def svg(width: int, height: int, said: str, body: str) -> str:
    """An SVG element; `said` is what it shows, in words."""
    return (
        f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="{html.escape(said)}">'
        f"{body}</svg>"
    )


def line(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    """A straight line of a class."""
    return f'<path class="{kind}" d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}"/>'


def bar(x1: float, x2: float, top: float, foot: float, told: str, kind: str = "bar") -> str:
    """An upright bar with a title, at least half a pixel wide and high."""
    width, height = max(x2 - x1, 0.5), max(foot - top, 0.5)
    return (
        f'<rect class="{kind}" x="{x1:.1f}" y="{foot - height:.1f}" width="{width:.1f}" '
        f'height="{height:.1f}"><title>{html.escape(told)}</title></rect>'
    )


def label(x: float, y: float, text: str, anchor: str, kind: str = "tick") -> str:
    """Text; `anchor` is start, middle or end."""
    # Anchors are attributes, not classes: they are geometry.
    return (
        f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
        f"{html.escape(text)}</text>"
    )


def polyline(points: np.ndarray, kind: str, told: str = "") -> str:
    """A line through points (N, 2), with a title if there is something to tell."""
    way = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    title = f"<title>{html.escape(told)}</title>" if told else ""
    return f'<polyline class="{kind}" points="{way}">{title}</polyline>'
