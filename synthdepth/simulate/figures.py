"""The charts of a simulation's page, as inline SVG: rates, ends, flights on their scene's map."""

import html
import math
from collections.abc import Mapping, Sequence

import cv2
import numpy as np

from synthdepth.charts.axes import round_step
from synthdepth.charts.pictures import tile
from synthdepth.charts.svg import bar, label, line, polyline, svg
from synthdepth.simulate.outcome import ENDS, Outcome, Rate, Summary
from synthdepth.simulate.store import SceneMap
from synthdepth.simulate.tables import END_NAMES, ended, interval, percent

# As many sources as the style sheet has colours.
COLOURS = 6
_WIDTH, _ROW, _SIDE = 420, 34, 6
_MAP_PX, _PICTURE_PX = 440, 640
_CROSS_PX = 4.0


def rate_chart(rates: Mapping[str, Rate], own: int) -> str:
    """Collision rates with their intervals, a row each.

    Args:
        rates: by name.
        own: so many of them are coloured as sources; the others were printed elsewhere.
    """
    most = max(max(found.high for found in rates.values()), 0.02)
    step = round_step(most / 4)
    top = step * math.ceil(most / step - 1e-9)
    foot = _ROW * len(rates)

    def x(share: float) -> float:
        return _SIDE + share / top * (_WIDTH - 2 * _SIDE)

    parts = []
    for tick in range(round(top / step) + 1):
        at = x(tick * step)
        parts.append(line(at, 0, at, foot, "grid"))
        anchor = "start" if tick == 0 else "end" if at > _WIDTH - 20 else "middle"
        parts.append(label(at, foot + 14, f"{100 * tick * step:g} %", anchor))
    for number, (name, found) in enumerate(rates.items()):
        kind = f"k{number % COLOURS}" if number < own else "printed"
        y = number * _ROW
        told = f"{name}: {percent(found)} ({interval(found)})"
        parts.append(label(_SIDE, y + 14, name, "start", "name" if number < own else "tick"))
        parts.append(label(_WIDTH - _SIDE, y + 14, percent(found), "end", "name"))
        parts.append(bar(x(found.low), x(found.high), y + 20, y + 27, told, f"span {kind}"))
        title = f"<title>{html.escape(told)}</title>"
        parts.append(
            f'<circle class="dot {kind}" cx="{x(found.value):.1f}" cy="{y + 23.5}" r="5">'
            f"{title}</circle>"
        )
    said = "Collision rates: " + ", ".join(f"{n} {percent(found)}" for n, found in rates.items())
    return svg(_WIDTH, foot + 20, said, "".join(parts))


def ends_chart(summaries: Sequence[Summary]) -> str:
    """How the flights of each source ended: a bar a source, cut by ends."""
    parts = []
    for number, summary in enumerate(summaries):
        y, at = number * _ROW, float(_SIDE)
        parts.append(label(_SIDE, y + 14, summary.source, "start", "name"))
        for end in ENDS:
            found = getattr(summary, end)
            wide = found.value * (_WIDTH - 2 * _SIDE)
            if found.count:
                told = f"{summary.source}: {percent(found)} {END_NAMES[end]}"
                parts.append(bar(at, at + wide, y + 19, y + 30, told, f"end-{end}"))
            at += wide
    said = "How flights ended: " + "; ".join(
        f"{s.source} " + ", ".join(f"{percent(getattr(s, e))} {END_NAMES[e]}" for e in ENDS)
        for s in summaries
    )
    return svg(_WIDTH, _ROW * len(summaries) + 4, said, "".join(parts))


def flight_map(scene: SceneMap, flights: Sequence[Outcome], sources: Sequence[str]) -> str:
    """A scene from above with its flights, north (+Y) up.

    Args:
        scene: its map.
        flights: of the scene.
        sources: all of the page, in the order of their colours.
    """
    size = scene.high_m - scene.low_m
    scale = _MAP_PX / size[0]
    height = round(size[1] * scale)

    def on_map(points) -> np.ndarray:
        points = np.atleast_2d(np.asarray(points, float))[:, :2]
        return (points - [scene.low_m[0], scene.high_m[1]]) * [scale, -scale]

    said = f"scene {scene.scene_index} from above"
    uri = tile("", said, scene.picture, most_px=_PICTURE_PX).uri
    parts = [
        f'<image class="land" href="{uri}" width="{_MAP_PX}" height="{height}" '
        'preserveAspectRatio="none"/>'
    ]
    ends = []
    for number, source in enumerate(sources):
        kind = f"k{number % COLOURS} f{number}"
        for flight in flights:
            if flight.source != source:
                continue
            told = f"{source}, scenario {flight.scenario}: {ended(flight)}"
            way = on_map([*flight.track_m, flight.end_m])
            parts.append(polyline(_thinned(way), f"under f{number}"))
            parts.append(polyline(_thinned(way), f"way {kind}", told))
            # Larger under those that are drawn over it: sources often crash in the same place.
            arm = _CROSS_PX + 1.5 * min(len(sources) - 1 - number, 4)
            ends.append(_end_mark(flight, way[-1], arm, number, told))
    parts += _starts_and_goals(flights, on_map, scale)
    bar_m = round_step(size[0] / 8)
    parts += [
        *ends,
        f'<path class="scale" d="M12 {height - 17}v5h{bar_m * scale:.1f}v-5"/>',
        label(12 + bar_m * scale / 2, height - 18, f"{bar_m:g} m", "middle", "number"),
    ]
    crashes = sum(flight.end == "collision" for flight in flights)
    said = (
        f"Scene {scene.scene_index} from above, {size[0]:.0f} m by {size[1]:.0f} m: "
        f"{len(flights)} flights, {crashes} collisions"
    )
    return svg(_MAP_PX, height, said, "".join(parts))


def _thinned(way: np.ndarray) -> np.ndarray:
    """A polyline (n, 2) without the points that cannot be seen."""
    return cv2.approxPolyDP(way.astype(np.float32).reshape(-1, 1, 2), 0.2, False).reshape(-1, 2)


def _end_mark(flight: Outcome, at: np.ndarray, arm: float, number: int, told: str) -> str:
    """A cross where a flight collided, a dot where time or bounds ended it."""
    (x, y), kind = at, f"k{number % COLOURS} f{number}"
    title = f"<title>{html.escape(told)}</title>"
    if flight.end == "collision":
        arms = f"M{x - arm:.1f} {y - arm:.1f}l{2 * arm} {2 * arm}m0 {-2 * arm}l{-2 * arm} {2 * arm}"
        return (
            f'<path class="crash-under f{number}" d="{arms}"/>'
            f'<path class="crash {kind}" d="{arms}">{title}</path>'
        )
    if flight.end == "goal":
        return ""
    return f'<circle class="dot {kind}" cx="{x:.1f}" cy="{y:.1f}" r="3.5">{title}</circle>'


def _starts_and_goals(flights: Sequence[Outcome], on_map, scale: float) -> list[str]:
    parts = []
    for flight in {flight.scenario: flight for flight in flights}.values():
        (x, y), (u, v) = on_map(flight.start_m)[0], on_map(flight.goal_m)[0]
        parts.append(f'<circle class="goal" cx="{u:.1f}" cy="{v:.1f}" r="{5 * scale:.1f}"/>')
        title = f"<title>scenario {flight.scenario} starts here</title>"
        parts.append(f'<circle class="begin" cx="{x:.1f}" cy="{y:.1f}" r="4">{title}</circle>')
        parts.append(label(x, y - 7, str(flight.scenario), "middle", "number"))
    return parts
