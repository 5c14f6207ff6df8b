"""Running a recipe on many inputs, and the report."""

from __future__ import annotations

import os
import tempfile
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import closing
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any

from .. import _core
from .._call import Progress, _Bar
from .._errors import OptionError
from .._options import Engine, checked
from .._table import table, text
from .._engines import Lost, check, check_shared, opened
from ._inputs import InputError, Inputs, shard_of, sources
from ._recipe import Recipe, Steps
from ._record import RECORD, Row, hash_of, is_settled, is_unchanged, is_whole, known, line, parsed
from ._store import Store, is_url, look
from ._summary import page
from ._task import Task, failed, finish


@dataclass(frozen=True, repr=False)
class Report:
    """The outcomes of all inputs.

    Attributes
    ----------
    rows : list of dict
        One row for each input, ordered by name, as in the manifest.
    skipped : int
        Number of inputs that were finished before.
    manifest : str
        The path or URL of the manifest: one row per line, as JSON.
    summary : str
        The path or URL of the summary, a page that opens offline.
    hash : str
        SHA-256 of everything that depends on inputs and recipe alone: the hashes of inputs and outputs, counts,
        errors, kinds of failures. It is the same for every engine, number of workers and order.
    """

    rows: list[Row]
    skipped: int
    manifest: str
    summary: str
    hash: str

    @property
    def done(self) -> list[Row]:
        """The rows of inputs that completed all steps."""
        return [row for row in self.rows if row["failure"] is None]

    @property
    def failed(self) -> list[Row]:
        """The rows of failed inputs; ``row["failure"]`` has kind, message, step and cure."""
        return [row for row in self.rows if row["failure"] is not None]

    def _rows(self) -> list[tuple[str, object]]:
        kinds = Counter(row["failure"]["kind"] for row in self.failed)
        return [
            ("inputs", len(self.rows)),
            ("done", len(self.done)),
            ("failed", len(self.failed)),
            *((f"failed: {kind}", count) for kind, count in kinds.most_common()),
            ("finished before", self.skipped),
            ("manifest", self.manifest),
            ("summary", self.summary),
        ]

    def __repr__(self) -> str:
        return text("Report", self._rows())

    def _repr_html_(self) -> str:
        return table("Report", self._rows())


@checked
def run(
    inputs: Inputs,
    steps: Steps,
    output: str | os.PathLike[str],
    *,
    engine: Engine = "local",
    client: Any = None,
    workers: int | None = None,
    cores: int = 1,
    retries: int = 2,
    retry_failed: bool = False,
    shard: str | tuple[int, int] | None = None,
    thumbnail: int = 160,
    parquet: bool = False,
    progress: Progress = None,
    callback: Callable[[Row], object] | None = None,
) -> Report:
    """Apply the same steps to many meshes, on the processors of this machine, Dask or Ray.

    Each input gets a folder below `output` with its name. It contains the files written by the steps (by
    default ``mesh.ply``, ``picture.png``, ``lod-1.ply``, ...), a small picture, and ``record.json``, which is
    written last. Files appear whole or not at all. A second run skips finished inputs if the input, the recipe
    and the version of this package are unchanged. An input that cannot be processed, or that kills its worker,
    has a row with the reason, and the run continues.

    Parameters
    ----------
    inputs : path, pattern, folder or URL, or several
        Files; patterns such as ``"scans/**/*.ply"``; folders, for all mesh files in them and below; or the same
        at URLs such as ``"s3://bucket/scans"``, which require fsspec.
    steps : path, mapping or sequence
        The recipe, see :class:`Recipe`: ``"read"``, ``"repair"``, ``"flip"``, ``"simplify"``, ``"lod"``,
        ``"curvature"``, ``"distance"``, ``"render"`` and ``"write"``, with the options of the functions of the
        same name.
    output : path or URL
        The folder for results, accessible to all workers.
    engine : str
        ``"local"``, ``"dask"`` or ``"ray"``.
    client : optional
        For Dask a ``distributed.Client`` or the address of a scheduler, for Ray the address of a cluster; an
        open connection is used. By default both run on this machine.
    workers : int, optional
        Number of parallel tasks on this machine; by default as many as the processors allow. Not with a client,
        which has its own workers.
    cores : int
        Number of threads of each task. Dask does not know it: its workers should then have one thread for this
        number of processors.
    retries : int
        How often a task is retried after its worker died. For an existing Dask cluster, its own
        ``allowed-failures`` applies.
    retry_failed : bool
        Whether failed inputs are retried. Failures that may be caused by the machine are always retried.
    shard : str or (int, int), optional
        Process only the K-th of N parts of the inputs, as in ``"3/64"``, for job arrays; :func:`gather` makes
        one report from all.
    thumbnail : int
        Width and height of the small pictures in pixels; 0 for none.
    parquet : bool
        Whether the manifest is also written as Parquet, which requires pyarrow.
    progress : bool or callable, optional
        ``True`` for a bar, or a function of the completed share.
    callback : callable, optional
        Called with each row when it is available.

    Returns
    -------
    Report

    Raises
    ------
    RecipeError, InputError, OptionError
        Before anything runs: steps, inputs or options are invalid.
    WriteError
        Manifest or summary cannot be written.

    Notes
    -----
    Results are the same to the last bit for any engine, number of workers and cores, unless a step has a
    ``time_limit``.

    Examples
    --------
    >>> import curvmesh as cm
    >>> import tempfile, os
    >>> folder = tempfile.mkdtemp()
    >>> for level in (2, 3):
    ...     told = cm.write(os.path.join(folder, f"ball{level}.ply"), cm.shapes.sphere(level))
    >>> steps = ["repair", {"do": "simplify", "ratio": 0.5}, {"do": "distance", "samples": 1000}]
    >>> report = cm.batch.run(folder, steps, os.path.join(folder, "out"), workers=1)
    >>> [(row["name"], row["status"], row["steps"][2]["faces"]) for row in report.rows]
    [('ball2.ply', 'done', 160), ('ball3.ply', 'done', 640)]
    >>> cm.batch.run(folder, steps, os.path.join(folder, "out")).skipped
    2
    """
    recipe = steps if isinstance(steps, Recipe) else Recipe(steps)
    output = os.fspath(output)
    if not is_url(output):
        # Workers may have another working folder.
        output = os.path.abspath(output)
    check(engine, client, workers)
    _check_counts(workers, cores, retries, thumbnail)
    if parquet:
        _check_pyarrow()
    found = sources(inputs, output)
    check_shared([output, *(source.path for source in found)])
    chosen, ending = shard_of(found, shard)
    store = Store(output)
    before, sizes = known(store, (source.name for source in chosen))
    rows: dict[str, Row] = {}
    tasks = []
    for source in chosen:
        row = before.get(source.name)
        if (
            row is not None
            and is_settled(row, recipe.hash, _core.VERSION, retry_failed)
            and is_whole(row, sizes.get)
            and is_unchanged(row, look(source.path))
        ):
            rows[source.name] = row
        else:
            tasks.append(Task(source, recipe, output, cores, thumbnail, retry_failed))
    skipped = len(rows)
    with tempfile.TemporaryDirectory(prefix="curvmesh-") as folder, _telling(progress) as tell:
        if tasks:
            # The workers end after any exception.
            with opened(engine, client, workers, cores, retries) as do, closing(do(tasks)) as outcomes:
                for number, (task, outcome) in enumerate(outcomes, 1):
                    row = _lost(task, outcome, store, folder) if isinstance(outcome, Lost) else outcome
                    rows[task.name] = row
                    tell(number / len(tasks))
                    if callback is not None:
                        callback(row)
        return _report(rows.values(), skipped, store, ending, parquet, folder)


def gather(output: str | os.PathLike[str], *, parquet: bool = False) -> Report:
    """Make one manifest and one summary of all records below an output.

    For the parts of a job array, or during a run.

    Parameters
    ----------
    output : path or URL
        The `output` of :func:`run`.
    parquet : bool
        Whether the manifest is also written as Parquet.

    Returns
    -------
    Report

    Raises
    ------
    InputError
        There are no records.
    """
    if parquet:
        _check_pyarrow()
    store = Store(os.fspath(output))
    names = [file.removesuffix(f"/{RECORD}") for file, _ in store.files() if file.endswith(f"/{RECORD}")]
    read = (parsed(store.text(f"{name}/{RECORD}")) for name in names)
    rows = [row for row in read if row is not None]
    if not rows:
        raise InputError(f"{store.root}: there are no records of a run", path=store.root)
    with tempfile.TemporaryDirectory(prefix="curvmesh-") as folder:
        return _report(rows, len(rows), store, "", parquet, folder)


def _check_counts(workers: int | None, cores: int, retries: int, thumbnail: int) -> None:
    for name, value, least in (
        ("workers", 1 if workers is None else workers, 1),
        ("cores", cores, 1),
        ("retries", retries, 0),
        ("thumbnail", thumbnail, 0),
    ):
        if value < least:
            raise OptionError(f"{name} is {value}; it must be at least {least}")


def _check_pyarrow() -> None:
    if find_spec("pyarrow") is None:
        raise OptionError("a manifest as Parquet needs pyarrow", cure="pip install pyarrow")


class _telling:
    """A function of the completed share, and a bar that is closed at the end."""

    def __init__(self, progress: Progress) -> None:
        self._bar = _Bar("batch") if progress is True else None
        self._function = progress if callable(progress) else None

    def __enter__(self) -> Callable[[float], object]:
        if self._bar is not None:
            return self._bar.tell
        return self._function or (lambda fraction: None)

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.close()


def _lost(task: Task, lost: Lost, store: Store, folder: str) -> Row:
    """The record of an input whose worker died, written by this process instead."""
    earlier = parsed(store.text(f"{task.source.name}/{RECORD}"))
    if (
        earlier is not None
        and is_settled(earlier, task.recipe.hash, _core.VERSION, task.retry_failed)
        and is_whole(earlier, store.bytes)
        and is_unchanged(earlier, look(task.source.path))
    ):
        # The task was completed; only the answer was lost.
        return earlier
    row = failed(task.blank(), RuntimeError(lost.message))
    row["failure"]["kind"] = lost.kind
    row["worker"] = ""
    now = look(task.source.path)
    if now is not None:
        row["input_bytes"], row["input_changed"] = now.bytes, now.changed
    finish(store, row, earlier, folder)
    return row


def _report(
    found: Iterable[Row], skipped: int, store: Store, ending: str, parquet: bool, folder: str
) -> Report:
    """Writes manifest and summary."""
    rows = sorted(found, key=lambda row: str(row["name"]))
    manifest, summary = f"manifest{ending}.jsonl", f"summary{ending}.html"
    store.put_text("".join(map(line, rows)), manifest, folder)
    if parquet:
        path = os.path.join(folder, "manifest.parquet")
        _write_parquet(rows, path)
        store.put(path, f"manifest{ending}.parquet")
    store.put_text(page(rows, store), summary, folder)
    return Report(rows, skipped, store.path(manifest), store.path(summary), hash_of(rows))


def _write_parquet(rows: list[Row], path: str) -> None:
    """A column for each name, with the same type for any rows; nested parts are JSON."""
    import pyarrow
    import pyarrow.parquet

    flat = [_flat(row) for row in rows]
    kinds = {"input_bytes": pyarrow.int64(), "failure_step": pyarrow.int64(), "failure_lasting": pyarrow.bool_()}
    kinds["seconds_total"] = pyarrow.float64()
    schema = pyarrow.schema([(name, kinds.get(name, pyarrow.string())) for name in flat[0]] if flat else [])
    pyarrow.parquet.write_table(pyarrow.Table.from_pylist(flat, schema=schema), path)


#: The nested parts of a row that have separate columns.
_PARTS = {
    "failure": ("kind", "message", "step", "do", "lasting", "repair", "cure"),
    "versions": ("curvmesh", "numpy", "python", "machine"),
    "seconds": ("total",),
}


def _flat(row: Row) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in row.items():
        if name in _PARTS:
            parts: Mapping[str, Any] = value or {}
            found.update({f"{name}_{part}": parts.get(part) for part in _PARTS[name]})
        if isinstance(value, (dict, list)) or name in _PARTS:
            value = None if value is None else line(value).rstrip("\n")
        found[name] = value
    return found
