"""A simulation as text: Markdown to paste where tables are read, and lines for a terminal."""

from collections.abc import Callable

from synthdepth.simulate import tables
from synthdepth.simulate.outcome import TABLE_6, TABLE_6_SOURCES
from synthdepth.simulate.report import SAID, facts, lead
from synthdepth.simulate.tables import Results, Table


def markdown(results: Results) -> str:
    """The tables of a report."""
    parts = [f"# Flights on {_plain(results.map)}", _plain(lead(results))]
    for title, table in _sections(results).items():
        parts += [f"## {title}", SAID[title], _table(table)]
    parts += [f"{tables.scene_time(results)}.", "## Settings", _table(_facts_table(results))]
    return "\n\n".join(part for part in parts if part) + "\n"


def text_table(results: Results) -> str:
    """The results as lines for a terminal, with the paper's table 6 beside."""
    lines = [
        f"{'map':14s} {'source':24s} {'flights':>7s} {'collision rate [95 %]':>25s} "
        f"{'blocked':>7s} {'goal':>7s} {'time':>7s} {'bounds':>7s} {'excess':>7s} {'m/s':>6s} "
        f"{'effort':>7s}  hit"
    ]
    for s in results.summaries:
        c = s.collision
        ends = " ".join(f"{100 * r.value:6.1f}%" for r in (s.blocked, s.goal, s.time, s.bounds))
        hits = ", ".join(f"{label} {count}" for label, count in s.hits.items())
        lines.append(
            f"{s.map:14s} {s.source[-24:]:24s} {s.flights:7d} "
            f"{100 * c.value:8.2f} % [{100 * c.low:5.1f}, {100 * c.high:5.1f}] {ends} "
            f"{_shown(s.excess, 7)} {_shown(s.goal_speed_mps, 6)} {_shown(s.effort_m_s3, 7)}  "
            f"{hits}".rstrip()
        )
    if results.map in TABLE_6:
        values = zip(TABLE_6_SOURCES, TABLE_6[results.map], strict=True)
        lines.append(
            f"paper, {results.map} (400 flights in AirSim): "
            + ", ".join(f"{source} {value:g} %" for source, value in values)
        )
    for c in results.comparisons:
        lines.append(
            f"{c.map}: of {c.scenarios} scenarios {c.one} alone crashed in {c.only_one}, {c.other} "
            f"alone in {c.only_other} (McNemar p = {c.p:.3g})"
        )
    return "\n".join(lines)


def _sections(results: Results) -> dict[str, Table]:
    makers: dict[str, Callable[[Results], Table]] = {
        "Collisions": tables.collision_table,
        "Differences": tables.comparison_table,
        "How flights ended": tables.ends_table,
        "What was hit": tables.hits_table,
        "How they flew": tables.flying_table,
        "Time": tables.time_table,
    }
    made = {title: make(results) for title, make in makers.items()}
    return {title: table for title, table in made.items() if table.rows}


def _facts_table(results: Results) -> Table:
    return Table(head=("", ""), rows=list(facts(results).items()))


def _table(table: Table) -> str:
    lines = [table.head, ["---"] + ["---:"] * (len(table.head) - 1), *table.rows]
    return "\n".join(f"| {' | '.join(map(_plain, line))} |" for line in lines)


def _plain(text: str) -> str:
    """Text that ends no cell and begins no markup."""
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;").replace("\n", " ")


def _shown(value: float | None, width: int) -> str:
    return "-".rjust(width) if value is None else f"{value:{width}.2f}"
