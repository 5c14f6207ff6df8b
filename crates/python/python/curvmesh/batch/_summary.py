"""The summary: a page with the outcomes of all inputs that opens offline."""

from __future__ import annotations

import base64
import math
from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape
from typing import Any

from .._table import shown
from ._record import Row
from ._store import Store

#: Limits on the numbers of rows and pictures, so that browsers can open the page.
_MOST_ROWS, _MOST_PICTURES = 200, 240

_STYLE = """
:root { color-scheme: light dark; --ink: #222; --soft: #777; --line: #ddd; --bar: #3b6ea5; --paper: #fff; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #ddd; --soft: #999; --line: #444; --bar: #7aa7d8; --paper: #1b1b1b; }
}
body { font: 15px/1.45 system-ui, sans-serif; color: var(--ink); background: var(--paper);
  max-width: 70rem; margin: 2rem auto; padding: 0 1rem; }
h1, h2 { font-weight: 600; } h2 { margin-top: 2.5rem; font-size: 1.15rem; }
.counts { display: flex; flex-wrap: wrap; gap: 2rem; } .counts b { display: block; font-size: 1.8rem; }
.scroll { overflow-x: auto; }
table { border-collapse: collapse; font-size: .9rem; }
th, td { padding: .25rem .8rem .25rem 0; border-bottom: 1px solid var(--line); text-align: left;
  vertical-align: top; overflow-wrap: break-word; max-width: 40rem; }
th { color: var(--soft); font-weight: 500; } td.number { text-align: right; white-space: nowrap; }
svg { width: 100%; max-width: 46rem; height: auto; } svg rect { fill: var(--bar); }
svg text { font-size: 11px; fill: var(--soft); } svg line { stroke: var(--line); }
.pictures { display: grid; grid-template-columns: repeat(auto-fill, minmax(8.5rem, 1fr)); gap: 1rem; }
figure { margin: 0; } figure img { width: 100%; height: auto; background: #fff; border-radius: 3px; }
figcaption { font-size: .8rem; overflow-wrap: anywhere; } .soft { color: var(--soft); }
"""


def page(rows: Sequence[Row], store: Store) -> str:
    """The page of all rows."""
    failed = [row for row in rows if row["failure"]]
    seconds = [row["seconds"].get("total") for row in rows]
    counts = [
        ("inputs", len(rows)),
        ("done", len(rows) - len(failed)),
        ("failed", len(failed)),
        ("work of one processor", _span(sum(s for s in seconds if s))),
    ]
    parts = [
        "<h1>Summary</h1>",
        '<div class="counts">'
        + "".join(f"<div><b>{shown(value)}</b>{name}</div>" for name, value in counts)
        + "</div>",
        *_errors(rows),
        *_failures(failed),
        *_slowest(rows),
        *_pictures(rows, store),
    ]
    policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
    return (
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>Summary of {len(rows)} inputs</title><style>{_STYLE}</style></head><body>"
        + "\n".join(parts)
        + "</body></html>\n"
    )


def _span(seconds: float) -> str:
    """A time in words."""
    if seconds < 120:
        return f"{seconds:.3g} s"
    return f"{seconds / 60:.3g} min" if seconds < 7200 else f"{seconds / 3600:.3g} h"


def error_of(row: Row) -> tuple[float, float | None] | None:
    """The mean and the largest distance of a result from its input, as shares of the diagonal."""
    for step in reversed(row["steps"]):
        if step["do"] == "distance" and step["diagonal"]:
            return step["mean"] / step["diagonal"], step["max"] / step["diagonal"]
    return None


def _errors(rows: Iterable[Row]) -> list[str]:
    found = [error for error in map(error_of, rows) if error is not None]
    if not found:
        return []
    parts = ["<h2>Errors</h2>"]
    largest = [error[1] for error in found if error[1] is not None]
    for title, values in (("mean distance", [error[0] for error in found]), ("largest distance", largest)):
        parts.append(f"<p>{title}, in % of the diagonal, of {len(values):,} results; {_quantiles(values)}</p>")
        parts.append(_histogram([100 * value for value in values]))
    return parts


def _quantiles(values: Sequence[float]) -> str:
    order = sorted(values)
    named = (("median", 0.5), ("95th percentile", 0.95), ("largest", 1.0))
    return ", ".join(f"{name} {100 * order[math.ceil(q * len(order)) - 1]:.3g} %" for name, q in named)


def _histogram(values: Sequence[float]) -> str:
    """A logarithmic histogram with four bins per factor of ten; zeros are separate."""
    zeros = sum(value <= 0 for value in values)
    steps = Counter(math.floor(4 * math.log10(value)) for value in values if value > 0)
    first, last = (min(steps), max(steps)) if steps else (0, 0)
    # Values below a billionth of the largest are counted in one bin with it.
    first = max(first, last - 36)
    bars = [("0", zeros)] if zeros else []
    for step in range(first, last + 1) if steps else ():
        count = steps[step] if step > first else sum(n for s, n in steps.items() if s <= first)
        bars.append((f"{10 ** (step / 4):.2g}", count))
    most = max(count for _, count in bars)
    width, height, foot = 736, 150, 24
    wide = width / len(bars)
    every = math.ceil(len(bars) / 12)
    drawn = []
    for place, (name, count) in enumerate(bars):
        tall = (height - 16) * count / most
        x = place * wide
        drawn.append(
            f'<rect x="{x + 1:.1f}" y="{height - tall:.1f}" width="{max(wide - 2, 1):.1f}" height="{tall:.1f}">'
            f"<title>from {name} %: {count:,}</title></rect>"
        )
        if place % every == 0:
            drawn.append(f'<text x="{x + 1:.1f}" y="{height + 15}">{name}</text>')
    drawn.append(f'<text x="0" y="11">{most:,}</text>')
    drawn.append(f'<line x1="0" y1="{height}" x2="{width}" y2="{height}"/>')
    return f'<svg viewBox="0 0 {width} {height + foot}" role="img">{"".join(drawn)}</svg>'


def _failures(failed: Sequence[Row]) -> list[str]:
    if not failed:
        return []
    kinds = Counter((row["failure"]["kind"], row["failure"]["do"]) for row in failed)
    lines = []
    for row in sorted(failed, key=lambda row: (row["failure"]["kind"], row["name"])):
        failure = row["failure"]
        cure = failure.get("repair") and f"repair {failure['repair']}" or failure.get("cure", "")
        lines.append((row["name"], failure["kind"], failure["do"], failure["message"], cure))
    return [
        "<h2>Failed</h2>",
        _table(["kind", "in", "inputs"], [(kind, do, count) for (kind, do), count in kinds.most_common()]),
        "<h2>Failed, by name</h2>",
        _table(["name", "kind", "in", "reason", "what may help"], lines),
    ]


def _slowest(rows: Sequence[Row]) -> list[str]:
    timed = [row for row in rows if row["seconds"].get("total")]
    if not timed:
        return []
    order = sorted(timed, key=lambda row: -row["seconds"]["total"])[:20]
    lines = []
    for row in order:
        parts = sorted(row["seconds"].items(), key=lambda part: -part[1])
        most = ", ".join(f"{name} {value:.3g}" for name, value in parts if name != "total" and value > 0.005)
        faces = row["steps"][0].get("faces") if row["steps"] else None
        lines.append((row["name"], faces, round(row["seconds"]["total"], 3), most))
    return ["<h2>Slowest</h2>", _table(["name", "faces", "seconds", "of which"], lines)]


def _pictures(rows: Sequence[Row], store: Store) -> list[str]:
    drawn = [row for row in rows if row["thumbnail"]]
    if not drawn:
        return []
    # If there are very many, an even selection.
    step = math.ceil(len(drawn) / _MOST_PICTURES)
    some = drawn[::step]
    parts = []
    for row in some:
        content = store.content(f"{row['name']}/{row['thumbnail']}")
        if content is None:
            continue
        data = base64.b64encode(content).decode()
        sizes = [step["faces"] for step in row["steps"] if "faces" in step]
        told = f"{sizes[0]:,} → {sizes[-1]:,} faces" if sizes else ""
        why = f"<br>{escape(row['failure']['kind'])}" if row["failure"] else ""
        parts.append(
            f'<figure><img alt="" src="data:image/png;base64,{data}">'
            f'<figcaption>{escape(row["name"])}<br><span class="soft">{told}{why}</span></figcaption></figure>'
        )
    more = f'<p class="soft">{len(some):,} of {len(drawn):,}</p>' if step > 1 else ""
    return ["<h2>Pictures</h2>", more, f'<div class="pictures">{"".join(parts)}</div>']


def _table(header: Sequence[str], lines: Sequence[Sequence[Any]]) -> str:
    heads = "".join(f"<th>{escape(head)}</th>" for head in header)
    body = []
    for line in lines[:_MOST_ROWS]:
        cells = (
            f'<td class="number">{shown(cell)}</td>'
            if isinstance(cell, (int, float))
            else f"<td>{escape(shown('' if cell is None else cell))}</td>"
            for cell in line
        )
        body.append(f"<tr>{''.join(cells)}</tr>")
    more = f'<p class="soft">and {len(lines) - _MOST_ROWS:,} more, in the manifest</p>' if len(lines) > _MOST_ROWS else ""
    return f'<div class="scroll"><table><tr>{heads}</tr>{"".join(body)}</table></div>{more}'
