"""The program ``curvmesh``: ``curvmesh`` on the path, or ``python -m curvmesh``."""

from __future__ import annotations

import sys

from . import _core


def main() -> None:
    """Runs the program with the arguments of this process."""
    sys.exit(_core.run_program(["curvmesh", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
