"""Runs the notebooks, and writes them with results as .ipynb files and as one page."""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import json
import re
import sys
import time
from html import escape
from pathlib import Path
from typing import Any

NOTEBOOKS = ["curvature_of_a_scan", "table_1_of_dhkl01", "error_against_faces"]

STYLE = """
body { font: 16px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; }
pre { background: #8881; padding: 0.6rem; overflow-x: auto; } img { max-width: 100%; }
table { border-collapse: collapse; } td, th { padding: 0.1rem 0.7rem; border-bottom: 1px solid #8884; }
details { margin: 0.6rem 0; }
"""


def cells(source: str) -> list[tuple[str, str]]:
    """The cells of a script, as kind and text."""
    found = []
    for part in re.split(r"^# %%", source, flags=re.MULTILINE)[1:]:
        head, _, body = part.partition("\n")
        if "[markdown]" in head:
            lines = [re.sub(r"^# ?", "", line) for line in body.strip().splitlines()]
            found.append(("markdown", "\n".join(lines)))
        else:
            found.append(("code", body.strip()))
    return found


def run(code: str, names: dict[str, Any]) -> tuple[str, Any]:
    """Runs a cell; returns its output, and the value of its last line."""
    tree = ast.parse(code)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    value = None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "cell", "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), "cell", "eval"), names)
    return printed.getvalue(), value


def shown(value: Any) -> dict[str, str]:
    """The representations of a value, by media type."""
    found = {"text/plain": repr(value)}
    if hasattr(value, "_repr_png_"):
        found["image/png"] = base64.b64encode(value._repr_png_()).decode()
    elif hasattr(value, "_repr_html_"):
        found["text/html"] = value._repr_html_()
    return found


def as_html(data: dict[str, str]) -> str:
    if "image/png" in data:
        return f'<img src="data:image/png;base64,{data["image/png"]}"/>'
    if "text/html" in data:
        return data["text/html"]
    return f"<pre>{escape(data['text/plain'])}</pre>"


def prose(text: str) -> str:
    """Renders the subset of Markdown that the notebooks use."""
    parts = []
    for block in text.split("\n\n"):
        block = escape(block.replace("\n", " "))
        block = re.sub(r"\*(.+?)\*", r"<em>\1</em>", block)
        block = re.sub(r"`(.+?)`", r"<code>\1</code>", block)
        heading = re.match(r"(#+) (.*)", block)
        parts.append(f"<h2>{heading[2]}</h2>" if heading else f"<p>{block}</p>")
    return "".join(parts)


def main(folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    page = []
    for name in NOTEBOOKS:
        start = time.perf_counter()
        source = (Path(__file__).parent / f"{name}.py").read_text(encoding="utf-8")
        names: dict[str, Any] = {"__name__": "__main__"}
        made: list[dict[str, Any]] = []
        for number, (kind, text) in enumerate(cells(source)):
            cell: dict[str, Any] = {"cell_type": kind, "id": f"cell{number}", "metadata": {}, "source": text}
            if kind == "markdown":
                page.append(prose(text))
            else:
                printed, value = run(text, names)
                outputs: list[dict[str, Any]] = []
                page.append(f"<details><summary>code</summary><pre>{escape(text)}</pre></details>")
                if printed:
                    outputs.append({"output_type": "stream", "name": "stdout", "text": printed})
                    page.append(f"<pre>{escape(printed)}</pre>")
                if value is not None:
                    data = shown(value)
                    outputs.append({"output_type": "display_data", "data": data, "metadata": {}})
                    page.append(as_html(data))
                cell.update(outputs=outputs, execution_count=None)
            made.append(cell)
        kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
        notebook = {"cells": made, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}
        (folder / f"{name}.ipynb").write_text(json.dumps(notebook), encoding="utf-8")
        print(f"{name}: {time.perf_counter() - start:.1f} s")
    body = "\n".join(page)
    html = f'<!DOCTYPE html><meta charset="utf-8"><title>curvmesh in Python</title><style>{STYLE}</style>{body}'
    (folder / "index.html").write_text(html, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
