"""The record of an input, which is also its row in the manifest."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Iterable
from typing import Any

from ._store import PART, Found, Store

#: A record: names and JSON values.
Row = dict[str, Any]

#: The name of the record among the results of an input.
RECORD = "record.json"

#: The parts of a row that depend on the recipe and the input alone, not on time, place or engine.
_RESULT = ("name", "input_hash", "recipe", "status", "outputs", "steps")


def result_of(row: Row) -> Row:
    """The part of a row that depends on the input and the recipe alone."""
    part = {name: row[name] for name in _RESULT}
    failure = row["failure"]
    part["failure"] = failure and {name: failure[name] for name in ("kind", "step")}
    return part


def hash_of(rows: Iterable[Row]) -> str:
    """SHA-256 of the results of all rows."""
    total = hashlib.sha256()
    for row in sorted(rows, key=lambda row: str(row["name"])):
        total.update(line(result_of(row)).encode())
    return total.hexdigest()


def line(row: Row) -> str:
    """A row as a line of JSON."""
    return json.dumps(plain(row), sort_keys=True, separators=(",", ":"), allow_nan=False) + "\n"


def plain(value: Any) -> Any:
    """A value as JSON; numbers that are not finite become null."""
    if isinstance(value, dict):
        return {str(name): plain(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(part) for part in value]
    if isinstance(value, (str, bool, int)) or value is None:
        return value
    number = float(value)
    return number if math.isfinite(number) else None


def parsed(text: str | None) -> Row | None:
    """A row from its text, if it is one."""
    try:
        row = json.loads(text or "")
    except ValueError:
        return None
    is_row = isinstance(row, dict) and {*_RESULT, "failure", "versions", "input_bytes"} <= set(row)
    return row if is_row else None


def is_whole(row: Row, sizes: Any) -> bool:
    """Whether all outputs of a row exist; `sizes` returns the size of a file."""
    files = [(f"{row['name']}/{output['file']}", output["bytes"]) for output in row["outputs"]]
    return all(sizes(name) == size for name, size in files)


def is_settled(row: Row, recipe: str, version: str, retry_failed: bool) -> bool:
    """Whether a row is up to date for this recipe and version if the input is unchanged."""
    if row["recipe"] != recipe or row["versions"].get("curvmesh") != version:
        return False
    failure = row["failure"]
    return not failure or bool(failure["lasting"] and not retry_failed)


def is_unchanged(row: Row, now: Found | None) -> bool:
    """Whether an input looks unchanged, without reading it."""
    if now is None:
        # Unchanged if the file was missing before.
        return row["input_bytes"] is None
    return bool(row["input_bytes"] == now.bytes and row["input_changed"] == now.changed)


def known(store: Store, names: Iterable[str]) -> tuple[dict[str, Row], dict[str, int]]:
    """The records of inputs, and the sizes of all files below the output.

    Removes unfinished copies of a killed run.
    """
    from concurrent.futures import ThreadPoolExecutor

    wanted = set(names)
    sizes: dict[str, int] = {}
    for file, size in store.files():
        owner, _, last = file.rpartition("/")
        if PART in last:
            if owner in wanted:
                store.remove(file)
        else:
            sizes[file] = size
    there = [name for name in sorted(wanted) if f"{name}/{RECORD}" in sizes]
    # Remote stores are slow because of latency.
    with ThreadPoolExecutor(16) as pool:
        rows = pool.map(lambda name: parsed(store.text(f"{name}/{RECORD}")), there)
        return {name: row for name, row in zip(there, rows) if row and row["name"] == name}, sizes
