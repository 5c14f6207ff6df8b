"""Meshes larger than memory, region by region, on this machine, Dask or Ray.

The steps are the subcommands of ``curvmesh region``: each reads and writes files in a folder that all workers
share, and skips finished work. No process holds the whole mesh.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager, suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ._engines import Engine, Lost, check, opened, signal_name
from ._errors import CurvmeshError, OptionError
from ._options import checked, whole
from ._table import table, text

if TYPE_CHECKING:
    from ._options import Engine as EngineName
    from ._options import Length, Preset

__all__ = ["Level", "Levels", "Reduced", "RegionError", "lod", "simplify"]


class RegionError(CurvmeshError, RuntimeError):
    """A step has failed. Finished work is kept: the same call continues from there.

    Attributes
    ----------
    step : str
        The step, like ``"reduce 0 17"``.
    """

    def __init__(self, message: str, *, step: str = "") -> None:
        super().__init__(message, cure="call again with the same work_dir, once the cause is mended")
        self.step = step


@dataclass(frozen=True)
class Step:
    """A step of a run; it can be pickled and called on any machine that has the program.

    Attributes
    ----------
    program : tuple of str
        The command that starts the program.
    arguments : tuple of str
        The arguments after ``curvmesh region``.
    name : str
        The name of the step.
    cores : int
        Number of threads.
    progress : str
        The file for the progress of the step, or an empty string.
    """

    program: tuple[str, ...]
    arguments: tuple[str, ...]
    name: str
    cores: int
    progress: str = ""

    def __call__(self) -> dict[str, Any]:
        """Runs the program; returns its report, ``{"error": ...}``, or ``{"died": ...}`` after a signal."""
        command = [*self.program, "region", *self.arguments, "--json", "--quiet", "--threads", str(self.cores)]
        if self.progress:
            command.append("--tell-progress")
        pipe = subprocess.PIPE
        try:
            with subprocess.Popen(
                command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, text=True
            ) as process:
                said = self._listened(process)
                output = process.stdout.read() if process.stdout else ""
        except OSError as error:
            return {"error": f"{self.program[0]} cannot be run: {error}"}
        if process.returncode < 0:
            return {"died": f"the program was ended by {signal_name(-process.returncode)}"}
        try:
            report = json.loads(output.splitlines()[-1])
        except (IndexError, ValueError):
            return {"error": said or f"the program ended with code {process.returncode}"}
        if process.returncode:
            return {"error": report["error"]["message"]}
        return dict(report)

    def _listened(self, process: subprocess.Popen[str]) -> str:
        """Forwards progress, and returns the other lines of stderr."""
        said = []
        for line in process.stderr or ():
            if not line.startswith("progress: "):
                said.append(line)
            elif self.progress:
                part = f"{self.progress}.part"
                with open(part, "w", encoding="utf-8") as file:
                    file.write(line.removeprefix("progress: ").strip())
                os.replace(part, self.progress)
        return "".join(said).strip()


@dataclass(frozen=True, repr=False)
class Reduced:
    """The result of a run.

    Attributes
    ----------
    output : str
        The file that was written.
    faces : int
        Its number of faces.
    cells : list of int
        The number of regions on each level.
    error : float or None
        A proved upper bound of the Hausdorff distance from the input, in model units, if requested.
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


@dataclass(frozen=True)
class Level:
    """A level of detail on disk.

    Attributes
    ----------
    output : str
        The file, or the folder of its tiles.
    faces : int
        Its number of faces.
    tiles : int or None
        The number of files, if it is a folder.
    error : float or None
        A proved upper bound of the Hausdorff distance from the input, in model units, if requested.
    """

    output: str
    faces: int
    tiles: int | None
    error: float | None


@dataclass(frozen=True, repr=False)
class Levels:
    """The result of a run with several levels of detail.

    Attributes
    ----------
    levels : list of Level
        From fine to coarse.
    cells : list of int
        The number of regions in each pass.
    """

    levels: list[Level]
    cells: list[int]

    def _rows(self) -> list[tuple[str, object]]:
        return [
            *((level.output, f"{level.faces} faces") for level in self.levels),
            ("regions by pass", self.cells),
        ]

    def __repr__(self) -> str:
        return text("Levels", self._rows())

    def _repr_html_(self) -> str:
        return table("Levels", self._rows())


def _memory(memory: str | int) -> str:
    """A memory limit as the program takes it."""
    given = str(memory).replace(" ", "").upper() if isinstance(memory, str) else str(whole("memory", memory))
    if re.fullmatch(r"[0-9]+([KMG](I?B)?)?", given) is None:
        raise OptionError(f'memory is {memory!r}; it must be a number of bytes, or a text like "8G" or "500 MB"')
    return given


@checked
def simplify(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    work_dir: str | os.PathLike[str],
    memory: str | int,
    faces: int | None = None,
    vertices: int | None = None,
    ratio: float | None = None,
    max_error: Length | None = None,
    max_cost: float | None = None,
    relative: bool = False,
    preset: Preset = "default",
    verify: bool = False,
    repair: bool = False,
    engine: EngineName = "local",
    client: Any = None,
    workers: int | None = None,
    cores: int = 1,
    retries: int = 2,
    program: str | os.PathLike[str] | None = None,
    callback: Callable[[str], object] | None = None,
) -> Reduced:
    """Simplify a mesh larger than memory; regions are processed in parallel.

    The file is split. Level by level, all regions are reduced and neighbours are joined. The rest is finished
    in one piece or region by region. A level is planned when the previous one is complete.

    Parameters
    ----------
    source, output : path
        The file to read, PLY, STL or OBJ, and the file to write.
    work_dir : path
        The folder for the regions, on a disk that all workers see. It is kept, and an interrupted run continues
        with it.
    memory : str or int
        The memory limit of a step, like ``"8G"`` or ``"500 MB"``, or in bytes.
    faces, vertices, ratio, max_error, max_cost, relative, preset, verify
        As for :func:`curvmesh.simplify`.
    repair : bool
        Make the repairs that are possible region by region.
    engine : str
        ``"local"``, ``"dask"`` or ``"ray"``.
    client, workers, cores, retries
        As for :func:`curvmesh.batch.run`.
    program : path, optional
        Another program ``curvmesh`` instead of the one of this package; all workers need it at the same path.
    callback : callable, optional
        Called with the name of each finished step, and during the last one with its progress, like ``"finish:
        fit 3 of 12"``.

    Returns
    -------
    Reduced
        The same file as of ``curvmesh simplify --memory``, for any engine.

    Raises
    ------
    OptionError
        The program does not exist, or an option is invalid.
    RegionError
        A step has failed.
    """
    options = {
        "--faces": faces,
        "--vertices": vertices,
        "--ratio": ratio,
        "--max-error": max_error,
        "--max-cost": max_cost,
        "--preset": preset,
    }
    flags = {"--relative": relative, "--verify": verify, "--lenient": repair}
    split = [os.path.abspath(source), "--memory", _memory(memory), *_given(options, flags)]
    check(engine, client, workers)
    run = _Run(os.path.abspath(work_dir), program, cores, retries, callback)
    with opened(engine, client, workers, cores, retries) as do:
        told, cells = run(do, split, ["-o", os.path.abspath(output)])
    return Reduced(told["output"], told["faces"], cells, told.get("error"))


@checked
def lod(
    source: str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    work_dir: str | os.PathLike[str],
    memory: str | int,
    ratios: Sequence[float] = (),
    faces: Sequence[int] = (),
    tiles: bool = False,
    preset: Preset = "default",
    verify: bool = False,
    repair: bool = False,
    engine: EngineName = "local",
    client: Any = None,
    workers: int | None = None,
    cores: int = 1,
    retries: int = 2,
    program: str | os.PathLike[str] | None = None,
    callback: Callable[[str], object] | None = None,
) -> Levels:
    """Make levels of detail of a mesh larger than memory; regions are processed in parallel.

    A coarser level continues from the regions of the finer one. Levels are not fitted to the input, as in
    :func:`curvmesh.lod`. Levels that do not fit into memory either are finished region by region.

    Parameters
    ----------
    source : path
        The file to read, PLY, STL or OBJ.
    output : path
        The folder for the levels, which are named after the source: ``scan-1.ply`` is the finest.
    ratios : sequence of float
        Levels with these shares of the faces.
    faces : sequence of int
        Levels with these numbers of faces.
    tiles : bool
        Write each level as a folder of tiles: a file for each region, and the list ``tiles.json``.
    work_dir, memory, preset, verify, repair, engine, client, workers, cores, retries, program, callback
        As for :func:`simplify`.

    Returns
    -------
    Levels
        The same files as of ``curvmesh lod --memory``, for any engine.

    Raises
    ------
    OptionError
        The program does not exist, or an option is invalid.
    RegionError
        A step has failed.
    """
    if not ratios and not faces:
        raise OptionError("no levels are named", cure="ratios= or faces=")
    options = {
        "--levels": ",".join(map(str, ratios)) or None,
        "--level-faces": ",".join(map(str, faces)) or None,
        "--preset": preset,
    }
    flags = {"--verify": verify, "--lenient": repair}
    split = [os.path.abspath(source), "--memory", _memory(memory), *_given(options, flags)]
    check(engine, client, workers)
    run = _Run(os.path.abspath(work_dir), program, cores, retries, callback)
    with opened(engine, client, workers, cores, retries) as do:
        told, cells = run(do, split, ["--tiles" if tiles else "-o", os.path.abspath(output)])
    if "levels" not in told:
        # Tiles of a single level.
        folder, count = told["tiles"]
        return Levels([Level(folder, told["faces"], count, told.get("error"))], cells)
    made = [Level(row["output"], row["faces"], row.get("tiles"), row.get("error")) for row in told["levels"]]
    return Levels(made, cells)


def _given(options: Mapping[str, object], flags: Mapping[str, bool]) -> list[str]:
    """The remaining arguments of the command line."""
    pairs = [(name, str(value)) for name, value in options.items() if value is not None]
    return [part for pair in pairs for part in pair] + [name for name, is_set in flags.items() if is_set]


class _Run:
    """The steps of a run, level by level."""

    def __init__(
        self,
        folder: str,
        program: str | os.PathLike[str] | None,
        cores: int,
        retries: int,
        callback: Callable[[str], object] | None,
    ) -> None:
        if program is None:
            # The program of this package.
            self.program: tuple[str, ...] = (sys.executable, "-m", "curvmesh")
        else:
            found = shutil.which(os.fspath(program))
            if found is None:
                raise OptionError(f"there is no program {os.fspath(program)}")
            self.program = (found,)
        self.folder, self.cores, self.retries, self.callback = folder, cores, retries, callback
        self._progress = os.path.join(folder, "progress.txt") if callback is not None else ""

    def __call__(self, do: Engine, split: list[str], target: list[str]) -> tuple[dict[str, Any], list[int]]:
        """Runs all steps; returns the report of the last one, and the number of cells on each level."""
        plan = self._one(do, "split", "split", *split, "-w", self.folder)
        cells = [plan["cells"]]
        self._finish(do, plan)
        while plan["next"] != "finish":
            level = plan["level"]
            if plan["next"] == "pass":
                self._each(do, "reduce", level, plan["cells"])
                self._each(do, "join", level + 1, plan["joined"])
            else:
                # One step collapses all borders, and makes all cells.
                self._each(do, "join", level + 1, 1)
            plan = self._one(do, "plan", "plan", self.folder)
            if plan["level"] == level:
                raise RegionError(f"level {level + 1} was joined, and is not there", step="plan")
            cells.append(plan["cells"])
            self._finish(do, plan)
        last = self._step("finish", "finish", self.folder, *target)
        with _followed(self._progress, self.callback):
            told = _all(do, [last], self.retries, None)[0]
        if self.callback is not None:
            self.callback("finish")
        return told, cells

    def _finish(self, do: Engine, plan: dict[str, Any]) -> None:
        """Finishes a resulting level that does not fit into memory, cell by cell."""
        self._each(do, "finish", plan["level"], plan.get("apart") or 0)

    def _each(self, do: Engine, act: str, level: int, count: int) -> None:
        def step(cell: int) -> Step:
            return self._step(
                f"{act} {level} {cell}", act, self.folder, "--level", str(level), "--cell", str(cell)
            )

        _all(do, [step(cell) for cell in range(count)], self.retries, self.callback)

    def _one(self, do: Engine, name: str, *arguments: str) -> dict[str, Any]:
        return _all(do, [self._step(name, *arguments)], self.retries, self.callback)[0]

    def _step(self, name: str, *arguments: str) -> Step:
        progress = self._progress if name == "finish" else ""
        return Step(self.program, arguments, name, self.cores, progress)


def _all(
    do: Engine, steps: list[Step], retries: int, callback: Callable[[str], object] | None
) -> list[dict[str, Any]]:
    """Runs independent steps, and returns their reports in any order; a step that died is retried."""
    reports = []
    for tries in range(retries + 1):
        died = []
        with closing(do(steps)) as outcomes:
            for step, outcome in outcomes:
                if isinstance(outcome, Lost):
                    raise RegionError(f"{step.name}: {outcome.message}", step=step.name)
                if "died" in outcome:
                    died.append(step)
                    if tries == retries:
                        message = f"{step.name}: {outcome['died']}, tried {tries + 1} times"
                        raise RegionError(message, step=step.name)
                    continue
                if "step" not in outcome:
                    raise RegionError(f"{step.name}: {outcome['error']}", step=step.name)
                reports.append(outcome)
                if callback is not None:
                    callback(step.name)
        if not died:
            break
        steps = died
    return reports


@contextmanager
def _followed(path: str, callback: Callable[[str], object] | None) -> Iterator[None]:
    """Reports the progress that a step writes to a file, like ``"finish: fit 3 of 12"``."""
    if callback is None:
        yield
        return
    tell, is_done = callback, threading.Event()

    def follow() -> None:
        last, is_last = "", False
        while not is_last:
            is_last = is_done.wait(0.2)
            with suppress(OSError), open(path, encoding="utf-8") as file:
                now = file.read()
                if now != last:
                    tell(f"finish: {now}")
                last = now

    thread = threading.Thread(target=follow, daemon=True)
    thread.start()
    try:
        yield
    finally:
        is_done.set()
        thread.join()
        with suppress(OSError):
            os.unlink(path)
