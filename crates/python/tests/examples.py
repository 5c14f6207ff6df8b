"""Runs every example in the docstrings and in the README."""

from __future__ import annotations

import doctest
import importlib
import pkgutil
import re
import sys
import tempfile
from pathlib import Path

import curvmesh

OPTIONS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS


def main() -> None:
    failed = attempted = 0
    for found in pkgutil.iter_modules(curvmesh.__path__):
        module = importlib.import_module(f"curvmesh.{found.name}")
        results = doctest.testmod(module, optionflags=OPTIONS)
        failed, attempted = failed + results.failed, attempted + results.attempted
    readme = Path(__file__).parent.parent / "README.md"
    with tempfile.TemporaryDirectory() as folder:
        import os

        os.chdir(folder)
        curvmesh.write("scan.ply", curvmesh.shapes.sphere(5))
        # Blocks of one section follow each other.
        names: dict[str, object] = {}
        for code in re.findall(r"```python\n(.*?)```", readme.read_text(encoding="utf-8"), re.DOTALL):
            attempted += 1
            try:
                exec(compile(code, "README.md", "exec"), names)
            except ModuleNotFoundError as error:
                print(f"skipped a part of the README: {error}")
            except Exception as error:
                failed += 1
                print(f"in the README: {type(error).__name__}: {error}\n{code}")
    print(f"{attempted - failed} passed, {failed} failed")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
