"""A simulation as one HTML page: no file beside it, no network, no script.

Everything that comes from files is escaped, and the page forbids itself to load anything.
"""

from collections.abc import Sequence
from html import escape
from importlib.resources import files
from string import Template

from synthdepth.charts.elements import card, page_style
from synthdepth.charts.elements import table as html_table
from synthdepth.simulate import figures, tables
from synthdepth.simulate.outcome import ENDS
from synthdepth.simulate.tables import END_NAMES, Results, Table

MAPS_SHOWN = 12
SAID = {
    "Collisions": "Of all flights, with Wilson's 95 % intervals. They take flights as independent; "
    "those of one scene are alike, so they are somewhat too narrow. “Printed” is table 6 of the "
    "paper for this map: 400 flights in AirSim, in other scenes. The last column leaves out the "
    "flights that arrive by flying straight.",
    "Differences": "All sources flew the same scenarios: where only one of two collided, they can "
    "be told apart.",
    "How flights ended": "Shares of flights with their 95 % intervals.",
    "What was hit": "Collisions by the class of what the drone touched first.",
    "How they flew": "Path excess: how much longer than the shortest free way, over flights that "
    "arrived. That way is A* through the scene's true geometry, pulled taut, within the altitudes; "
    "it can be a few per cent too long, or a drone fly outside the altitudes for a moment, and so "
    "an excess be below 0. Clearance: from the drone's surface to whatever was nearest, 5 m at "
    "most, over flights that did not collide. Effort: squared acceleration over time, a metre "
    "flown: smooth flights have little.",
    "Time": "On the machine that flew: what a frame took for pictures, for depth, and for "
    "planning, motion and contacts.",
}


def html_page(results: Results) -> str:
    """The page."""
    sources = [summary.source for summary in results.summaries]
    rates = {s.source: s.collision for s in results.summaries}
    rates |= tables.printed_rates(results.map)
    settings = results.settings
    parts = {
        "title": f"Flights on {escape(results.map)} (synthdepth simulation)",
        "style": page_style()
        + (files("synthdepth.simulate") / "report.css").read_text()
        + "".join(_source_style(number, len(sources)) for number in range(len(sources))),
        "name": escape(f"{results.map}, seed {settings['seed']}"),
        "lead": escape(lead(results)),
        "tiles": _headline(results),
        "collisions_said": SAID["Collisions"],
        "collisions": card(
            "Collision rate",
            "dots, with their 95 % intervals",
            figures.rate_chart(rates, len(sources)),
        )
        + _card(tables.collision_table(results), "collision rates"),
        "differences": _titled("Differences", tables.comparison_table(results)),
        "ends_said": SAID["How flights ended"],
        "ends_chart": f'<figure class="card">{_end_legend()}'
        f"{figures.ends_chart(results.summaries)}</figure>",
        "hits": _card(tables.hits_table(results), "what was hit"),
        "ends": _card(tables.ends_table(results), "ends"),
        "flying_said": SAID["How they flew"],
        "flying": _card(tables.flying_table(results), "how they flew"),
        "maps_said": escape(_maps_said(results)),
        "legend": _legend(sources),
        "maps": _maps(results, sources),
        "time_said": f"{SAID['Time']} In all {escape(tables.scene_time(results))}.",
        "time": _card(tables.time_table(results), "time"),
        "facts": _facts(results),
    }
    return Template((files("synthdepth.simulate") / "report.html").read_text()).substitute(parts)


def lead(results: Results) -> str:
    """What was flown, in a sentence."""
    flights = results.outcomes
    sources = [summary.source for summary in results.summaries]
    first = [flight for flight in flights if flight.source == sources[0]]
    scenes = len({flight.scene_index for flight in first})
    blocked = sum(flight.blocked_by is not None for flight in first)
    who = f"each of {len(sources)} sources" if len(sources) > 1 else sources[0]
    return (
        f"{len(first):,} flights of {who}, through the same scenarios in {scenes:,} "
        f"scene{'s' * (scenes > 1)}; in {100 * blocked / max(len(first), 1):.0f} % of them "
        "something stands in the straight way."
    )


def facts(results: Results) -> dict[str, str]:
    """How it was flown, {name: text}."""
    settings = results.settings
    drone, planner, asked = (settings["rules"][name] for name in ("drone", "planner", "scenario"))
    camera = settings["camera"]

    def span(name: str) -> str:
        low, high = asked[name]
        return f"{low:g} to {high:g}"

    rule = {
        "total": "the section with the largest total depth",
        "nearest": "the section whose nearest obstacle is farthest",
        "goal": "of the free sections the one nearest the goal",
    }
    return {
        "Map": results.map,
        "Seed": str(settings["seed"]),
        "Scenarios": f"{settings['flights_per_scene']} a scene; {span('distance_m')} m from start "
        f"to goal, {span('altitude_m')} m above ground",
        "Cruise speed": f"{span('speed_mps')} m/s"
        + (", slower where a halt within sight asks for it" * (planner["speed"] == "sight")),
        "Rule": f"{rule[planner['rule']]}; pull of the goal {planner['goal_pull']:g}",
        "Drone": f"radius {drone['radius_m']:g} m, at most {drone['max_acceleration_mps2']:g} m/s² "
        f"and {drone['max_yaw_rate_dps']:g}°/s",
        "Frames": f"every {drone['frame_interval_s']:g} s",
        "Latency": f"{drone['latency_s']:g} s from a frame to its command's effect",
        "Camera": f"{camera['width']}×{camera['height']} px",
        "A flight ends": f"within {asked['goal_radius_m']:g} m of the goal seen from above, at the "
        f"first contact, after {asked['time_factor']:g} times the straight way's time and "
        f"{asked['spare_time_s']:g} s, or {asked['beyond_m']:g} m outside the bounds",
        **{f"Source {name}": what for name, what in settings["sources"].items()},
    }


def _headline(results: Results) -> str:
    rules = results.settings["rules"]
    low, high = rules["scenario"]["speed_mps"]
    tiles = {
        "Flights": f"{len(results.outcomes):,}",
        **{
            escape(s.source): f"{100 * s.collision.value:.2f} <small>% collided</small>"
            for s in results.summaries
        },
        "Cruise": f"{low:g}–{high:g} <small>m/s</small>",
        "Latency": f"{1e3 * rules['drone']['latency_s']:g} <small>ms</small>",
    }
    return "".join(f"<div><dt>{name}</dt><dd>{text}</dd></div>" for name, text in tiles.items())


def _source_style(number: int, count: int) -> str:
    """How a source's flights look: hidden while its box is not checked, and the wider the more
    sources are drawn over them."""
    width = 1.5 + 0.8 * min(count - 1 - number, 4)
    return (
        f"svg .f{number} {{ --w: {width:.1f}; }}\n"
        f":root:has(#source-{number}:not(:checked)) .f{number} {{ display: none; }}\n"
    )


def _legend(sources: Sequence[str]) -> str:
    boxes = "".join(
        f'<li><label><input type="checkbox" id="source-{number}" checked>'
        f'<span class="swatch k{number % figures.COLOURS}"></span>{escape(name)}</label></li>'
        for number, name in enumerate(sources)
    )
    marks = {
        '<circle class="begin" cx="8" cy="8" r="4"/>': "start",
        '<circle class="goal" cx="8" cy="8" r="6"/>': "goal",
        '<path class="crash" d="M3.5 3.5l9 9m0 -9l-9 9"/>': "collision",
        '<circle class="dot" cx="8" cy="8" r="3.5"/>': "out of time or bounds",
    }
    keys = "".join(
        f'<li><svg class="key" viewBox="0 0 16 16" aria-hidden="true">{mark}</svg>{name}</li>'
        for mark, name in marks.items()
    )
    return f'<ul class="chips legend">{boxes}{keys}</ul>'


def _end_legend() -> str:
    chips = "".join(
        f'<li><span class="swatch end-{end}"></span>{END_NAMES[end]}</li>' for end in ENDS
    )
    return f'<ul class="chips legend">{chips}</ul>'


def _maps_said(results: Results) -> str:
    scenes = len({flight.scene_index for flight in results.outcomes})
    which = f"The first {len(results.maps)} of {scenes} scenes" if scenes > len(results.maps) else (
        "All scenes" if scenes > 1 else "The scene"
    )  # fmt: skip
    return (
        f"{which}, drawn from the triangles that drones fly among; north is up. Numbers are "
        "scenarios; boxes hide sources."
    )


def _maps(results: Results, sources: Sequence[str]) -> str:
    cards = []
    for scene in results.maps:
        flights = [f for f in results.outcomes if f.scene_index == scene.scene_index]
        crashes = sum(flight.end == "collision" for flight in flights)
        note = f"{scene.condition.replace('_', ' ')}; {len(flights)} flights, {crashes} collisions"
        figure = figures.flight_map(scene, flights, sources)
        cards.append(card(f"Scene {scene.scene_index}", note, figure))
    return "".join(cards)


def _titled(title: str, table: Table) -> str:
    if not table.rows:
        return ""
    said = f"<p>{SAID[title]}</p>" if title in SAID else ""
    return f"<h3>{title}</h3>{said}{_card(table, title)}"


def _card(table: Table, said: str) -> str:
    """A table in a box that scrolls where it is too wide; nothing without rows."""
    if not table.rows:
        return ""
    head = "".join(
        f'<th class="{"number" if k else ""}">{escape(name)}</th>'
        for k, name in enumerate(table.head)
    )
    rows = [
        [f"<th scope=row>{escape(row[0])}</th>"]
        + [f'<td class="number">{escape(cell)}</td>' for cell in row[1:]]
        for row in table.rows
    ]
    return (
        f'<div class="card scroll" role="region" aria-label="{escape(said)}" tabindex="0">'
        f"{html_table(head, rows)}</div>"
    )


def _facts(results: Results) -> str:
    rows = [
        [f"<th scope=row>{escape(name)}</th>", f"<td>{escape(value)}</td>"]
        for name, value in facts(results).items()
    ]
    return f'<div class="card">{html_table("", rows, "facts")}</div>'
