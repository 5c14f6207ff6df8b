"""Reports as text and as tables in notebooks."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


def shown(value: object) -> str:
    """A value in a table."""
    if isinstance(value, bool) or value is None:
        return {True: "yes", False: "no", None: "–"}[value]
    if isinstance(value, int):
        return f"{value:,}"
    if isinstance(value, float):
        return f"{value:.6g}"
    if isinstance(value, (tuple, list)):
        return ", ".join(shown(part) for part in value)
    return str(value)


def table(title: str, rows: Iterable[tuple[str, object]]) -> str:
    """Names and values as HTML."""
    cells = "".join(
        f'<tr><td style="text-align:left">{escape(name)}</td>'
        f'<td style="text-align:right">{escape(shown(value))}</td></tr>'
        for name, value in rows
    )
    return f"<table><caption>{escape(title)}</caption>{cells}</table>"


def grid(title: str, header: Iterable[str], lines: Iterable[Iterable[object]]) -> str:
    """A table with a header as HTML."""
    heads = "".join(f"<th>{escape(head)}</th>" for head in header)
    body = "".join(
        "<tr>" + "".join(f"<td>{escape(shown(cell))}</td>" for cell in line) + "</tr>"
        for line in lines
    )
    return f"<table><caption>{escape(title)}</caption><tr>{heads}</tr>{body}</table>"


def text(title: str, rows: Iterable[tuple[str, object]]) -> str:
    """Names and values as text."""
    pairs = list(rows)
    width = max((len(name) for name, _ in pairs), default=0)
    lines = [f"  {name:<{width}}  {shown(value)}" for name, value in pairs]
    return "\n".join([title, *lines])
