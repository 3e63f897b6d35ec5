"""The tables of a simulation's reports, as text cells: for pages, Markdown and terminals alike."""

import dataclasses
from collections.abc import Mapping, Sequence

from synthdepth.simulate.outcome import (
    ENDS,
    TABLE_6,
    TABLE_6_FLIGHTS,
    TABLE_6_SOURCES,
    Comparison,
    Outcome,
    Rate,
    Summary,
    rate,
)
from synthdepth.simulate.spent import Spent
from synthdepth.simulate.store import SceneMap

NONE = "–"
END_NAMES = {
    "goal": "arrived",
    "collision": "collided",
    "time": "out of time",
    "bounds": "out of bounds",
}


@dataclasses.dataclass(frozen=True, kw_only=True)
class Results:
    """What a simulation found.

    Attributes:
        map: name of the map.
        settings: as `simulation.json` has them.
        outcomes: all flights, source by source.
        summaries: of each source.
        comparisons: of every two sources.
        spent: time by source; what no single source took is at "".
        maps: the first scenes from above.
    """

    map: str
    settings: Mapping
    outcomes: Sequence[Outcome]
    summaries: Sequence[Summary]
    comparisons: Sequence[Comparison]
    spent: Mapping[str, Spent]
    maps: Sequence[SceneMap]


@dataclasses.dataclass(frozen=True, kw_only=True)
class Table:
    """A table; the first cell of a row is its name.

    Attributes:
        head: of the columns.
        rows: cells, as many as the head has.
    """

    head: Sequence[str]
    rows: Sequence[Sequence[str]]


def ended(flight: Outcome) -> str:
    """How a flight ended, in words."""
    hit = f" with {flight.hit.replace('_', ' ')}" if flight.hit else ""
    return f"{END_NAMES[flight.end]}{hit} after {flight.time_s:.1f} s"


def percent(share: Rate) -> str:
    """A share."""
    return f"{100 * share.value:.2f} %"


def interval(share: Rate) -> str:
    """A share's interval."""
    return f"{100 * share.low:.1f} to {100 * share.high:.1f}"


def printed_rates(map_name: str) -> dict[str, Rate]:
    """Table 6 of the paper for a map, by its sources, with intervals; empty for other maps."""
    counts = [round(value / 100 * TABLE_6_FLIGHTS) for value in TABLE_6.get(map_name, ())]
    return {
        f"printed: {source}": rate(count, TABLE_6_FLIGHTS)
        for source, count in zip(TABLE_6_SOURCES, counts, strict=False)
    }


def collision_table(results: Results) -> Table:
    """Collision rates, and those that the paper printed for the map."""
    rates = {s.source: s.collision for s in results.summaries} | printed_rates(results.map)
    blocked = {s.source: percent(s.blocked) for s in results.summaries if s.blocked.flights}
    rows = [
        (
            name,
            f"{found.flights:,}",
            f"{found.count:,}",
            percent(found),
            interval(found),
            blocked.get(name, NONE),
        )
        for name, found in rates.items()
    ]
    head = ("Source", "Flights", "Collisions", "Collision rate", "95 %", "If the way is blocked")
    return Table(head=head, rows=rows)


def ends_table(results: Results) -> Table:
    """How flights ended."""
    rows = [
        (s.source, *(f"{percent(getattr(s, end))} ({interval(getattr(s, end))})" for end in ENDS))
        for s in results.summaries
    ]
    return Table(head=("Source", *(END_NAMES[end].capitalize() for end in ENDS)), rows=rows)


def comparison_table(results: Results) -> Table:
    """McNemar's test of every two sources."""
    rows = [
        (
            f"{c.one} / {c.other}",
            f"{c.scenarios:,}",
            str(c.only_one),
            str(c.only_other),
            p_text(c.p),
        )
        for c in results.comparisons
    ]
    head = ("One / other", "Scenarios", "Only one collided", "Only the other", "p (McNemar)")
    return Table(head=head, rows=rows)


def hits_table(results: Results) -> Table:
    """What was hit, most often first."""
    total: dict[str, int] = {}
    for summary in results.summaries:
        for label, count in summary.hits.items():
            total[label] = total.get(label, 0) + count
    rows = [
        (label.replace("_", " "), *(str(s.hits.get(label, 0)) for s in results.summaries))
        for label in sorted(total, key=lambda label: (-total[label], label))
    ]
    return Table(head=("Hit", *(s.source for s in results.summaries)), rows=rows)


def flying_table(results: Results) -> Table:
    """How well sources flew."""
    columns = {
        "Path excess [%]": lambda s: _text(s.excess, 1, 100),
        "Speed towards goal [m/s]": lambda s: _text(s.goal_speed_mps, 2),
        "Least clearance [m]": lambda s: _text(s.clearance_m, 2),
        "Time to collision [s]": lambda s: _text(s.time_to_collision_s, 1),
        "Speed at collision [m/s]": lambda s: _text(s.hit_speed_mps, 1),
        "Effort [m/s³]": lambda s: _text(s.effort_m_s3, 2),
    }
    rows = [(s.source, *(value(s) for value in columns.values())) for s in results.summaries]
    return Table(head=("Source", *columns), rows=rows)


def time_table(results: Results) -> Table:
    """Where the time of flying went, per frame, by source."""
    rows = []
    for source, spent in results.spent.items():
        if source and spent.frames:
            each = [1e3 * s / spent.frames for s in (spent.sight_s, spent.depth_s, spent.physics_s)]
            rows.append(
                (
                    source,
                    f"{spent.flights:,}",
                    f"{spent.frames:,}",
                    *(f"{ms:.1f}" for ms in each),
                    f"{spent.flying_s / spent.flights:.2f}",
                )
            )
    head = (
        "Source", "Flights", "Frames", "Pictures [ms/frame]", "Depth [ms/frame]",
        "Physics [ms/frame]", "A flight [s]",
    )  # fmt: skip
    return Table(head=head, rows=rows)


def scene_time(results: Results) -> str:
    """What scenes took, in words."""
    scenes, flying = results.spent.get("", Spent()), Spent()
    for source, spent in results.spent.items():
        flying += spent if source else Spent()
    total = scenes.scenes_s + flying.flying_s
    parts = {
        "building scenes": scenes.build_s,
        "maps from above and shortest ways": scenes.survey_s,
        "loading scenes": scenes.load_s,
        "pictures": flying.sight_s,
        "depth": flying.depth_s,
        "planning, motion and contacts": flying.physics_s,
    }
    shares = ", ".join(f"{name} {100 * s / max(total, 1e-9):.0f} %" for name, s in parts.items())
    return f"{total:,.0f} s of processes: {shares}"


def p_text(p: float) -> str:
    """A p-value."""
    return "< 0.0001" if p < 1e-4 else f"{p:.4f}" if p < 0.1 else f"{p:.2f}"


def _text(value: float | None, digits: int, scale: float = 1.0) -> str:
    return NONE if value is None else f"{scale * value:.{digits}f}"
