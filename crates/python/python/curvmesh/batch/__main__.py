"""``python -m curvmesh.batch``: batch processing from the command line."""

from __future__ import annotations

import argparse
import sys

from .. import _core
from .._errors import CurvmeshError
from ._run import Report, gather, run

#: Exit codes, as in the program `curvmesh`.
_SOME_FAILED, _USAGE, _INTERRUPTED = 4, 2, 130


def main(arguments: list[str] | None = None) -> int:
    """Runs the command line, and returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m curvmesh.batch",
        description="Do the steps of a recipe to many meshes, on this machine, Dask or Ray.",
    )
    parser.add_argument("recipe", nargs="?", help="the steps, as a JSON file")
    parser.add_argument("inputs", nargs="*", help="files, patterns, folders or URLs")
    parser.add_argument("-o", "--output", required=True, help="the folder or URL for results")
    parser.add_argument("--engine", default="local", choices=["local", "dask", "ray"], help="what runs the tasks")
    parser.add_argument("--address", help="of the scheduler of Dask or the cluster of Ray")
    parser.add_argument("--workers", type=int, help="how many tasks at a time on this machine")
    parser.add_argument("--cores", type=int, default=1, help="by how many threads each task is done")
    parser.add_argument("--retries", type=int, default=2, help="how often a task is tried again when its worker dies")
    parser.add_argument("--retry-failed", action="store_true", help="try again what has failed before")
    parser.add_argument("--shard", metavar="K/N", help="do only the K-th of N parts of the inputs, as in 3/64")
    parser.add_argument("--thumbnail", type=int, default=160, metavar="PIXELS", help="size of small pictures, 0 for none")
    parser.add_argument("--parquet", action="store_true", help="write the manifest as Parquet, too")
    parser.add_argument("--gather", action="store_true", help="only make one report of all records below the output")
    parser.add_argument("--quiet", action="store_true", help="print nothing but errors")
    parser.add_argument("--version", action="version", version=f"curvmesh {_core.VERSION}")
    given = parser.parse_args(arguments)
    try:
        if given.gather:
            if given.recipe is not None:
                parser.error("--gather takes no recipe and no inputs")
            report = gather(given.output, parquet=given.parquet)
        else:
            if not given.inputs:
                parser.error("a recipe and inputs are needed")
            report = run(
                given.inputs,
                given.recipe,
                given.output,
                engine=given.engine,
                client=given.address,
                workers=given.workers,
                cores=given.cores,
                retries=given.retries,
                retry_failed=given.retry_failed,
                shard=given.shard,
                thumbnail=given.thumbnail,
                parquet=given.parquet,
                progress=True if not given.quiet and sys.stderr.isatty() else None,
            )
    except CurvmeshError as error:
        cure = f" ({error.cure})" if error.cure else ""
        print(f"error: {error}{cure}", file=sys.stderr)
        return _USAGE
    except KeyboardInterrupt:
        print("interrupted; what is finished is not done again", file=sys.stderr)
        return _INTERRUPTED
    if not given.quiet:
        _tell(report)
    return _SOME_FAILED if report.failed else 0


def _tell(report: Report) -> None:
    for row in report.failed:
        failure = row["failure"]
        print(f"{row['name']}: {failure['kind']}: {failure['message']}".encode("ascii", "replace").decode())
    print(report)


if __name__ == "__main__":
    sys.exit(main())
