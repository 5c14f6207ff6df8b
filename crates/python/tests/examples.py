"""Runs every example in the docstrings, in the README and on the page about batch processing."""

from __future__ import annotations

import doctest
import importlib
import os
import pkgutil
import re
import sys
import tempfile
from pathlib import Path

import curvmesh

OPTIONS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


def main() -> None:
    failed = attempted = 0
    for found in pkgutil.walk_packages(curvmesh.__path__, "curvmesh."):
        if found.name.endswith("__main__"):
            continue
        try:
            module = importlib.import_module(found.name)
        except ModuleNotFoundError as error:
            if (error.name or "").split(".")[0] == "curvmesh":
                raise
            print(f"skipped: {found.name} needs {error.name}")
            continue
        results = doctest.testmod(module, optionflags=OPTIONS)
        failed, attempted = failed + results.failed, attempted + results.attempted
    root = Path(__file__).parent.parent
    for page in (root / "README.md", root / "docs" / "batch.md"):
        told = run(page)
        failed, attempted = failed + told[0], attempted + told[1]
    print(f"{attempted - failed} passed, {failed} failed")
    sys.exit(bool(failed))


def run(page: Path) -> tuple[int, int]:
    """Runs the consecutive blocks of a page; returns the numbers of failures and of examples."""
    failed = attempted = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        curvmesh.write("scan.ply", curvmesh.shapes.sphere(5))
        names: dict[str, object] = {}
        for code in re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL):
            attempted += 1
            try:
                exec(compile(code, page.name, "exec"), names)
            except ModuleNotFoundError as error:
                print(f"skipped a part of {page.name}: {error}")
            except Exception as error:
                failed += 1
                print(f"in {page.name}: {type(error).__name__}: {error}\n{code}")
        os.chdir(page.parent)
    return failed, attempted


if __name__ == "__main__":
    main()
