"""The figures of the page: histograms, flights from above and colour scales, as inline SVG.

Colours and fonts are the page's: shapes carry classes, so that light and dark are decided in CSS.
Every figure has a label in words for whoever cannot see it, and a title on each of its parts.
"""

import dataclasses
import html
import math
from collections.abc import Callable, Sequence

import numpy as np

from synthdepth.dataset.preview import colour_depth
from synthdepth.view.flights import Flight

# Altitudes from which the steps of the map's colours begin [m].
ALTITUDE_STEPS_M = (0, 5, 10, 20, 40)

_WIDTH, _HEIGHT = 360, 180
_LEFT, _RIGHT, _TOP, _BOTTOM = 40, 12, 20, 24
_MAP_PX = 320


@dataclasses.dataclass(frozen=True, kw_only=True)
class Axis:
    """A linear or logarithmic axis with bins that begin and end on round numbers.

    Attributes:
        edges: of the bins, ascending.
        ticks: round values within the edges.
        log: whether equal factors are equally wide.
    """

    edges: np.ndarray
    ticks: tuple[float, ...]
    log: bool

    def place(self, value: float) -> float:
        """Where a value lies, 0 at the first edge and 1 at the last."""
        low, high = self.edges[0], self.edges[-1]
        if self.log:
            low, high, value = math.log(low), math.log(high), math.log(value)
        return (value - low) / (high - low)


def linear_axis(values: np.ndarray, bins: int = 24) -> Axis:
    """An axis from a round number below all values to one above, with about `bins` bins."""
    low, high = float(np.min(values)), float(np.max(values))
    step = _round_step((high - low) / bins or 1.0)
    first, last = math.floor(low / step), max(math.ceil(high / step), math.floor(low / step) + 1)
    edges = step * np.arange(first, last + 1)
    wide = _round_step((edges[-1] - edges[0]) / 5)
    ticks = wide * np.arange(math.ceil(edges[0] / wide - 1e-9), edges[-1] / wide + 1e-9)
    return Axis(edges=edges, ticks=tuple(float(t) for t in ticks), log=False)


def log_axis(low: float, high: float, bins: int = 36) -> Axis:
    """An axis of equal factors from `low` to `high`, both above 0."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    round_ones = [m * 10.0**d for d in decades for m in (1, 2, 5)]
    ticks = tuple(t for t in round_ones if low * 0.999 <= t <= high * 1.001)
    return Axis(edges=np.geomspace(low, high, bins + 1), ticks=ticks, log=True)


def _round_step(least: float) -> float:
    """The next of ... 0.1 0.2 0.5 1 2 5 10 ... that is not below `least`."""
    power = 10.0 ** math.floor(math.log10(least))
    return next(m * power for m in (1, 2, 5, 10) if m * power >= least * (1 - 1e-9))


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
    step = _round_step(max(float(shares.max()), 1e-6) / 3)
    top = step * math.ceil(float(shares.max()) / step - 1e-9)

    def x(value: float) -> float:
        return _LEFT + axis.place(value) * (_WIDTH - _LEFT - _RIGHT)

    def y(share: float) -> float:
        return _HEIGHT - _BOTTOM - share / top * (_HEIGHT - _BOTTOM - _TOP)

    parts = []
    for number in range(1, round(top / step) + 1):
        at = y(number * step)
        parts.append(_line(_LEFT, at, _WIDTH - _RIGHT, at, "grid"))
        parts.append(_label(_LEFT - 5, at + 4, f"{100 * number * step:g} %", "end"))
    for low, high, share in zip(axis.edges[:-1], axis.edges[1:], shares, strict=True):
        if share:
            told = f"{number_text(low)} to {number_text(high)} {unit}: {100 * share:.1f} %"
            parts.append(_bar(x(low) + 0.5, x(high) - 0.5, y(share), y(0), told))
    parts.append(_line(_LEFT, y(0), _WIDTH - _RIGHT, y(0), "axis"))
    for tick in axis.ticks:
        parts.append(_label(x(tick), _HEIGHT - 7, f"{tick:g}", "middle"))
    middle = float(np.median(values))
    parts.append(_line(x(middle), _TOP - 8, x(middle), y(0), "median"))
    side, shift = ("end", -5) if axis.place(middle) > 0.6 else ("start", 5)
    text = f"median {number_text(middle)} {unit}"
    parts.append(_label(x(middle) + shift, _TOP + 1, text, side, "strong"))
    said = (
        f"Histogram of {name}: median {number_text(middle)} {unit}, "
        f"from {number_text(float(values.min()))} to {number_text(float(values.max()))} {unit}"
    )
    return _svg(_WIDTH, _HEIGHT, said, "".join(parts))


def flight_map(
    flights: Sequence[Flight], altitude_m: Callable[[Flight], np.ndarray], span_m: float
) -> str:
    """The flights of one scene from above, north (+Y) up: runs of frames, joined by dashes.

    Args:
        flights: of one scene, at least one.
        altitude_m: (n,) above the ground [m], of a flight's frames.
        span_m: the side of the square shown [m], at least what the flights need.
    """
    everywhere = np.concatenate([run for flight in flights for run in flight.runs()])[:, :2]
    middle = (everywhere.min(axis=0) + everywhere.max(axis=0)) / 2

    def on_map(points: np.ndarray) -> np.ndarray:
        return _MAP_PX / 2 + (points[:, :2] - middle) * [1, -1] * (_MAP_PX / span_m)

    bar_m = _round_step(span_m / 6)
    bar_px = bar_m * _MAP_PX / span_m
    parts = [_grid(middle, span_m, bar_m)]
    for flight in flights:
        parts += [_polyline(on_map(gap), "gap") for gap in flight.gaps()]
    for flight in flights:
        heights, done = altitude_m(flight), 0
        for run in flight.runs():
            frames = slice(done, done + len(run) - 1)
            done = frames.stop
            height = float(np.mean(heights[frames]))
            step = sum(height >= least for least in ALTITUDE_STEPS_M) - 1
            told = (
                f"{flight.name}, frames {flight.frames[frames][0]} to "
                f"{flight.frames[frames][-1]}, {height:.0f} m up"
            )
            parts.append(_polyline(on_map(run), f"run a{max(step, 0)}", told))
    for flight in flights:
        x, y = on_map(next(flight.runs())[:1])[0]
        number = html.escape(flight.name.rpartition("-f")[2].lstrip("0") or "0")
        title = f"<title>{html.escape(flight.name)} starts here</title>"
        parts.append(f'<circle class="start" cx="{x:.1f}" cy="{y:.1f}" r="4.5">{title}</circle>')
        parts.append(_label(x, y - 7, number, "middle", "number"))
    left, foot = 12, _MAP_PX - 12
    parts.append(
        f'<path class="scale" d="M{left} {foot - 5}v5h{bar_px:.1f}v-5"/>'
        + _label(left + bar_px / 2, foot - 6, f"{bar_m:g} m", "middle")
        + f'<path class="north" d="M{_MAP_PX - 18} 26l6 -16l6 16l-6 -4z"/>'
        + _label(_MAP_PX - 12, 40, "N", "middle")
    )
    count = f"{len(flights)} flights" if len(flights) > 1 else "one flight"
    said = (
        f"Map of scene {flights[0].scene} from above: {count} in {span_m:.0f} m by {span_m:.0f} m"
    )
    return _svg(_MAP_PX, _MAP_PX, said, "".join(parts))


def map_span_m(scenes: Sequence[Sequence[Flight]]) -> float:
    """The side of a square that holds the flights of any of these scenes, with a margin [m]."""
    spans = []
    for flights in scenes:
        points = np.concatenate([run for flight in flights for run in flight.runs()])[:, :2]
        spans.append(float(np.ptp(points, axis=0).max()))
    return max(max(spans) * 1.2, 10.0)


def depth_scale(max_depth_m: float) -> str:
    """The colours of `colour_depth` over their depths, logarithmic; black is the range's end."""
    axis = log_axis(1.0, max_depth_m)
    colours = colour_depth(axis.edges[None], max_depth_m * 1.001)[0]
    stops = "".join(
        f'<stop offset="{axis.place(edge):.3f}" stop-color="rgb({r},{g},{b})"/>'
        for edge, (r, g, b) in zip(axis.edges, colours, strict=True)
    )
    wide, left = 270, 12
    parts = [
        f'<defs><linearGradient id="depth-colours">{stops}</linearGradient></defs>',
        f'<rect x="{left}" y="2" width="{wide}" height="14" rx="2" fill="url(#depth-colours)"/>',
        f'<rect class="saturated" x="{left + wide + 8}" y="2" width="46" height="14" rx="2"/>',
        _label(left + wide + 31, 32, f"≥ {max_depth_m:g} m", "middle"),
    ]
    for tick in axis.ticks[:-1]:
        parts.append(_label(left + axis.place(tick) * wide, 32, f"{tick:g}", "middle"))
    said = f"Depth colours: from red at 1 m to violet at {max_depth_m:g} m, black from there"
    return _svg(_WIDTH, 38, said, "".join(parts))


def _grid(middle: np.ndarray, span_m: float, step_m: float) -> str:
    scale, lines = _MAP_PX / span_m, []
    for axis in (0, 1):
        first = math.ceil((middle[axis] - span_m / 2) / step_m)
        last = math.floor((middle[axis] + span_m / 2) / step_m)
        for number in range(first, last + 1):
            at = _MAP_PX / 2 + (number * step_m - middle[axis]) * scale * (1, -1)[axis]
            ends = (at, 0, at, _MAP_PX) if axis == 0 else (0, at, _MAP_PX, at)
            lines.append(_line(*ends, "grid"))
    return "".join(lines)


def number_text(value: float) -> str:
    """A quantity to three digits, or to whole units where they are more."""
    return f"{value:.3g}" if abs(value) < 1000 else f"{value:,.0f}"


def _svg(width: int, height: int, said: str, body: str) -> str:
    return (
        f'<svg viewBox="0 0 {width} {height}" role="img" aria-label="{html.escape(said)}">'
        f"{body}</svg>"
    )


def _line(x1: float, y1: float, x2: float, y2: float, kind: str) -> str:
    return f'<path class="{kind}" d="M{x1:.1f} {y1:.1f}L{x2:.1f} {y2:.1f}"/>'


def _bar(x1: float, x2: float, top: float, foot: float, told: str) -> str:
    width, height = max(x2 - x1, 0.5), max(foot - top, 0.5)
    return (
        f'<rect class="bar" x="{x1:.1f}" y="{foot - height:.1f}" width="{width:.1f}" '
        f'height="{height:.1f}"><title>{html.escape(told)}</title></rect>'
    )


def _label(x: float, y: float, text: str, anchor: str, kind: str = "tick") -> str:
    # Anchors are attributes, not classes: they are geometry.
    return (
        f'<text class="{kind}" x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">'
        f"{html.escape(text)}</text>"
    )


def _polyline(points: np.ndarray, kind: str, told: str = "") -> str:
    way = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
    title = f"<title>{html.escape(told)}</title>" if told else ""
    return f'<polyline class="{kind}" points="{way}">{title}</polyline>'
