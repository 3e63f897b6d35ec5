"""Flights from above, as inline SVG."""

import html
import math
from collections.abc import Callable, Sequence

import numpy as np

from synthdepth.charts.axes import round_step
from synthdepth.charts.svg import label, line, polyline, svg
from synthdepth.view.flights import Flight

# Altitudes from which the steps of the map's colours begin [m].
ALTITUDE_STEPS_M = (0, 5, 10, 20, 40)

_MAP_PX = 320


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

    bar_m = round_step(span_m / 6)
    bar_px = bar_m * _MAP_PX / span_m
    parts = [_grid(middle, span_m, bar_m)]
    for flight in flights:
        parts += [polyline(on_map(gap), "gap") for gap in flight.gaps()]
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
            parts.append(polyline(on_map(run), f"run a{max(step, 0)}", told))
    for flight in flights:
        x, y = on_map(next(flight.runs())[:1])[0]
        number = html.escape(flight.name.rpartition("-f")[2].lstrip("0") or "0")
        title = f"<title>{html.escape(flight.name)} starts here</title>"
        parts.append(f'<circle class="start" cx="{x:.1f}" cy="{y:.1f}" r="4.5">{title}</circle>')
        parts.append(label(x, y - 7, number, "middle", "number"))
    left, foot = 12, _MAP_PX - 12
    parts.append(
        f'<path class="scale" d="M{left} {foot - 5}v5h{bar_px:.1f}v-5"/>'
        + label(left + bar_px / 2, foot - 6, f"{bar_m:g} m", "middle")
        + f'<path class="north" d="M{_MAP_PX - 18} 26l6 -16l6 16l-6 -4z"/>'
        + label(_MAP_PX - 12, 40, "N", "middle")
    )
    count = f"{len(flights)} flights" if len(flights) > 1 else "one flight"
    said = (
        f"Map of scene {flights[0].scene} from above: {count} in {span_m:.0f} m by {span_m:.0f} m"
    )
    return svg(_MAP_PX, _MAP_PX, said, "".join(parts))


def map_span_m(scenes: Sequence[Sequence[Flight]]) -> float:
    """The side of a square that holds the flights of any of these scenes, with a margin [m]."""
    spans = []
    for flights in scenes:
        points = np.concatenate([run for flight in flights for run in flight.runs()])[:, :2]
        spans.append(float(np.ptp(points, axis=0).max()))
    return max(max(spans) * 1.2, 10.0)


def _grid(middle: np.ndarray, span_m: float, step_m: float) -> str:
    scale, lines = _MAP_PX / span_m, []
    for axis in (0, 1):
        first = math.ceil((middle[axis] - span_m / 2) / step_m)
        last = math.floor((middle[axis] + span_m / 2) / step_m)
        for number in range(first, last + 1):
            at = _MAP_PX / 2 + (number * step_m - middle[axis]) * scale * (1, -1)[axis]
            ends = (at, 0, at, _MAP_PX) if axis == 0 else (0, at, _MAP_PX, at)
            lines.append(line(*ends, "grid"))
    return "".join(lines)
