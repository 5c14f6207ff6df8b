"""Runs every example in the docstrings, in the README, in the tutorial and on the page about batch processing.

With ``CURVMESH_BOOK=rewrite`` the pictures that a page makes replace the pictures that it shows.
"""

from __future__ import annotations

import doctest
import importlib
import os
import pkgutil
import re
import shutil
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
    # `cargo xtask python` copies the tutorial beside the other pages.
    copied = root / "docs" / "tutorial.md"
    tutorial = copied if copied.exists() else root.parent.parent / "docs" / "tutorials" / "python.md"
    for page in (root / "README.md", root / "docs" / "batch.md", tutorial):
        told = run(page)
        failed, attempted = failed + told[0], attempted + told[1]
    print(f"{attempted - failed} passed, {failed} failed")
    sys.exit(bool(failed))


def run(page: Path) -> tuple[int, int]:
    """Runs the consecutive blocks of a page; returns the numbers of failures and of examples."""
    failed = attempted = 0
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        if page.name != "README.md":
            curvmesh.write("scan.ply", curvmesh.examples.scan(5))
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
        if os.environ.get("CURVMESH_BOOK") == "rewrite":
            for link in re.findall(r"!\[.*?\]\((.*?)\)", page.read_text(encoding="utf-8")):
                made = Path(folder) / Path(link).name
                if made.exists():
                    shutil.copy(made, page.parent / link)
        os.chdir(page.parent)
    return failed, attempted


if __name__ == "__main__":
    main()
