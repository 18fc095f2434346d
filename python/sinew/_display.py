"""Tables for notebooks."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import Any


def number(value: Any, digits: int = 4) -> str:
    """A number as text, a dash for none."""
    return "–" if value is None or value != value else f"{value:.{digits}g}"


def percent(fraction: Any) -> str:
    """A fraction as text."""
    return "–" if fraction is None else f"{100 * fraction:.1f} %"


def html_table(title: str, head: Sequence[str], rows: Iterable[Sequence[Any]], notes: Iterable[str] = ()) -> str:
    """A table; every text is escaped."""

    def cells(tag: str, row: Sequence[Any]) -> str:
        return "<tr>" + "".join(f"<{tag}>{escape(str(cell))}</{tag}>" for cell in row) + "</tr>"

    body = "".join(cells("td", row) for row in rows)
    below = "".join(f"<p>{escape(note)}</p>" for note in notes if note)
    return (
        f"<div><p><b>{escape(title)}</b></p>"
        f"<table><thead>{cells('th', head)}</thead><tbody>{body}</tbody></table>{below}</div>"
    )
