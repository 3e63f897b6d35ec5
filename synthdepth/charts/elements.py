"""Parts of pages: tables, cards, legends, as escaped HTML."""

from collections.abc import Sequence
from html import escape
from importlib.resources import files


def chip(colour: str, name: str, note: str = "") -> str:
    """An entry of a legend: a colour with a name and a note; `note` is finished HTML."""
    swatch = f'<span class="swatch" style="background:{colour}"></span>'
    return f"<li>{swatch}{escape(name)} <small>{note}</small></li>"


def card(title: str, note: str, figure: str) -> str:
    """A figure with a title and a note."""
    return (
        f'<figure class="card"><figcaption>{escape(title)}<small>{escape(note)}</small>'
        f"</figcaption>{figure}</figure>"
    )


def numeric(text: str) -> str:
    """A cell with a number."""
    return f'<td class="number">{escape(text)}</td>'


def bar_cell(share: float) -> str:
    """A cell with a bar as long as a share, 0 to 1."""
    return f'<td class="share"><span class="bar-cell" style="width:{100 * share:.1f}%"></span></td>'


def table(head: str, rows: Sequence[Sequence[str]], kind: str = "") -> str:
    """A table of finished cells; `kind` is its class."""
    body = "".join(f"<tr>{''.join(row)}</tr>" for row in rows)
    top = f"<thead><tr>{head}</tr></thead>" if head else ""
    return f'<table class="{kind}">{top}<tbody>{body}</tbody></table>'


def page_style() -> str:
    """The style sheet of all pages; light and dark as the reader's browser has it."""
    return (files("synthdepth.charts") / "page.css").read_text()
