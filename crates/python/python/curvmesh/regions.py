"""Meshes larger than memory, region by region, on this machine, Dask or Ray.

The steps are those of ``curvmesh region``, each from files to files in a folder that all workers see; what is
scheduled here are these steps. Nobody holds the whole mesh, and nothing is done twice: a step finds what it
did before.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from typing import Any

from ._errors import CurvmeshError, OptionError
from ._table import table, text
from .batch._engines import Engine, Lost, check, opened

__all__ = ["Reduced", "RegionError", "simplify"]


class RegionError(CurvmeshError, RuntimeError):
    """A step has failed. What was done is kept: the same call goes on from there.

    Attributes
    ----------
    step : str
        Which one, like ``"reduce 0 17"``.
    """

    def __init__(self, message: str, *, step: str = "") -> None:
        super().__init__(message, cure="call again with the same work_dir, once the cause is mended")
        self.step = step


@dataclass(frozen=True)
class Step:
    """A step of a run; it can be pickled and called on any machine that has the program.

    Attributes
    ----------
    program : str
        The program.
    arguments : tuple of str
        What follows ``curvmesh region``.
    name : str
        What it is called.
    cores : int
        By how many threads.
    """

    program: str
    arguments: tuple[str, ...]
    name: str
    cores: int

    def __call__(self) -> dict[str, Any]:
        """Runs the program; gives its report, or ``{"error": ...}``."""
        command = [self.program, "region", *self.arguments, "--json", "--quiet", "--threads", str(self.cores)]
        try:
            done = subprocess.run(command, capture_output=True, text=True, stdin=subprocess.DEVNULL)
        except OSError as error:
            return {"error": f"{self.program} cannot be run: {error}"}
        if done.returncode < 0:
            # As where this process had been killed: the engine tries again.
            os.kill(os.getpid(), -done.returncode)
        try:
            report = json.loads(done.stdout.splitlines()[-1])
        except (IndexError, ValueError):
            return {"error": done.stderr.strip() or f"the program ended with code {done.returncode}"}
        if done.returncode:
            return {"error": report["error"]["message"]}
        return dict(report)


@dataclass(frozen=True, repr=False)
class Reduced:
    """What came of a run.

    Attributes
    ----------
    output : str
        The file that was written.
    faces : int
        How many faces it has.
    cells : list of int
        How many regions there were on each level.
    error : float or None
        No point of either surface is farther from the other one than this, if that was to be proved.
    """

    output: str
    faces: int
    cells: list[int]
    error: float | None

    def _rows(self) -> list[tuple[str, object]]:
        proved = [] if self.error is None else [("error, proved at most", self.error)]
        return [("output", self.output), ("faces", self.faces), ("regions by level", self.cells), *proved]

    def __repr__(self) -> str:
        return text("Reduced", self._rows())

    def _repr_html_(self) -> str:
        return table("Reduced", self._rows())


def simplify(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    work_dir: str | os.PathLike[str],
    memory: str | int,
    faces: int | None = None,
    vertices: int | None = None,
    ratio: float | None = None,
    max_error: float | str | None = None,
    max_cost: float | None = None,
    relative: bool = False,
    preset: str = "default",
    verify: bool = False,
    repair: bool = False,
    engine: str = "local",
    client: Any = None,
    workers: int | None = None,
    cores: int = 1,
    retries: int = 2,
    program: str | os.PathLike[str] | None = None,
    callback: Callable[[str], object] | None = None,
) -> Reduced:
    """Simplify a mesh larger than memory, its regions side by side.

    The file is split; level by level all regions are reduced, and neighbours joined; the rest is finished in
    one piece or region by region. A level is planned when the one below is there.

    Parameters
    ----------
    source, output : path
        The file to read, PLY, STL or OBJ, and the one to write.
    work_dir : path
        The folder for the regions, on a disk that all workers see. It is left there, and with it a run
        that was interrupted goes on.
    memory : str or int
        The most memory that a step may take, like ``"8G"``, or in bytes.
    faces, vertices, ratio, max_error, max_cost, relative, preset, verify
        As for :func:`curvmesh.simplify`.
    repair : bool
        Make all repairs that can be made region by region.
    engine : str
        ``"local"``, ``"dask"`` or ``"ray"``.
    client, workers, cores, retries
        As for :func:`curvmesh.batch.run`.
    program : path, optional
        The program ``curvmesh``, which all workers must have there; found on the path otherwise.
    callback : callable, optional
        Called with the name of each step when it is done.

    Returns
    -------
    Reduced
        The same file as of ``curvmesh simplify --memory``, whatever the engine.

    Raises
    ------
    OptionError
        The program is not there, or an option makes no sense.
    RegionError
        A step has failed.
    """
    check(engine, client, workers)
    found = shutil.which(os.fspath(program) if program is not None else "curvmesh")
    if found is None:
        name = "curvmesh" if program is None else os.fspath(program)
        raise OptionError(f"there is no program {name}", cure="cargo install --path crates/cli, or program=")
    folder = os.path.abspath(work_dir)
    options = {
        "faces": faces,
        "vertices": vertices,
        "ratio": ratio,
        "max-error": max_error,
        "max-cost": max_cost,
        "preset": preset,
    }
    given = [(f"--{name}", str(value)) for name, value in options.items() if value is not None]
    flags = {"--relative": relative, "--verify": verify, "--lenient": repair}
    split = ["split", os.path.abspath(source), "-w", folder, "--memory", str(memory)]
    split += [part for pair in given for part in pair] + [name for name, is_set in flags.items() if is_set]

    def step(name: str, *arguments: str) -> Step:
        return Step(found, arguments, name, cores)

    with opened(engine, client, workers, cores, retries) as do:
        plan = _all(do, [step("split", *split)], callback)[0]
        cells = [plan["cells"]]
        while plan["next"] == "pass":
            level, joined = plan["level"], plan["joined"]
            for act, above, count in (("reduce", level, plan["cells"]), ("join", level + 1, joined)):
                steps = [
                    step(f"{act} {above} {cell}", act, folder, "--level", str(above), "--cell", str(cell))
                    for cell in range(count)
                ]
                _all(do, steps, callback)
            plan = _all(do, [step("plan", "plan", folder)], callback)[0]
            if plan["level"] == level:
                raise RegionError(f"level {level + 1} was joined, and is not there", step="plan")
            cells.append(plan["cells"])
        # A result that does not fit is finished cell by cell.
        apart = range(plan.get("apart") or 0)
        steps = [step(f"finish {cell}", "finish", folder, "--cell", str(cell)) for cell in apart]
        _all(do, steps, callback)
        told = _all(do, [step("finish", "finish", folder, "-o", os.path.abspath(output))], callback)[0]
    return Reduced(told["output"], told["faces"], cells, told.get("error"))


def _all(do: Engine, steps: list[Step], callback: Callable[[str], object] | None) -> list[dict[str, Any]]:
    """Does steps that do not wait for each other, and gives their reports in any order."""
    reports = []
    with closing(do(steps)) as outcomes:
        for step, outcome in outcomes:
            if isinstance(outcome, Lost):
                raise RegionError(f"{step.name}: {outcome.message}", step=step.name)
            if "step" not in outcome:
                raise RegionError(f"{step.name}: {outcome['error']}", step=step.name)
            reports.append(outcome)
            if callback is not None:
                callback(step.name)
    return reports
