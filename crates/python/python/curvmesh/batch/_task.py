"""A task: processes one input to files and a record, on any machine."""

from __future__ import annotations

import os
import platform
import socket
import tempfile
import time
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from .. import _core
from .._errors import CurvmeshError, InternalError, ReadError, WriteError
from .._geometry.show import render
from ._inputs import Source
from ._recipe import Recipe
from ._record import RECORD, Row, is_settled, is_whole, line, parsed, plain
from ._steps import Work
from ._store import Store, digest, fetch, look

if TYPE_CHECKING:
    from collections.abc import Iterator

#: The name of the small picture among the results of an input.
THUMBNAIL = "thumbnail.png"


@dataclass(frozen=True)
class Task:
    """The processing of one input; it can be pickled and called anywhere.

    Attributes
    ----------
    source : Source
        The name and the path or URL of the input.
    recipe : Recipe
        The steps.
    output : str
        The folder or URL for the results of all inputs.
    cores : int
        Number of threads.
    thumbnail : int
        Width and height of the small picture in pixels; 0 for none.
    retry_failed : bool
        Whether failed inputs are retried.
    """

    source: Source
    recipe: Recipe
    output: str
    cores: int = 1
    thumbnail: int = 160
    retry_failed: bool = False

    @property
    def name(self) -> str:
        """The name of the input."""
        return self.source.name

    def __call__(self) -> Row:
        """Processes the input unless it is finished; returns the record, with the failure if there is one."""
        store = Store(self.output)
        row = self.blank()
        try:
            with tempfile.TemporaryDirectory(prefix="curvmesh-") as folder:
                return self._done(store, row, folder)
        except Exception as error:
            # The folder for unfinished files, or the store itself.
            return failed(row, error)

    def _done(self, store: Store, row: Row, folder: str) -> Row:
        files = os.path.join(folder, "files")
        os.mkdir(files)
        name, seconds = self.source.name, row["seconds"]
        before = parsed(store.text(f"{name}/{RECORD}"))
        began = time.perf_counter()
        work = Work("", files, self.cores)
        number = 0
        try:
            with _timed(seconds, "fetch"):
                work.path = self._fetched(row, folder)
            if before is not None and self._is_finished(before, row, store):
                if before["input_changed"] != row["input_changed"]:
                    # Touched but unchanged: the next run need not read it again.
                    before["input_changed"] = row["input_changed"]
                    finish(store, before, None, folder)
                return before
            for number, step in enumerate(self.recipe):
                with _timed(seconds, step["do"]):
                    mesh = work.mesh if number else None
                    told = {"do": step["do"], **plain(self.recipe.do(number, work))}
                    if mesh is not None and mesh.repairs:
                        told["repairs_needed"] = mesh.repairs
                    row["steps"].append(told)
        except Exception as error:
            failed(row, error, number, self.recipe[number]["do"])
        with _timed(seconds, "thumbnail"):
            has_picture = self._draw(work, folder)
        with _timed(seconds, "store"):
            try:
                for file in work.files if row["failure"] is None else []:
                    path = os.path.join(files, file)
                    told = {"file": file, "bytes": os.path.getsize(path), "sha256": digest(path)}
                    row["outputs"].append(told)
                    store.put(path, f"{name}/{file}")
                if has_picture:
                    store.put(os.path.join(folder, THUMBNAIL), f"{name}/{THUMBNAIL}")
                    row["thumbnail"] = THUMBNAIL
            except Exception as error:
                failed(row, error)
        seconds["total"] = time.perf_counter() - began
        # The record is written last: if it exists, all files that it names exist.
        finish(store, row, before, folder)
        return row

    def blank(self) -> Row:
        """An empty record."""
        return {
            "name": self.source.name,
            "input": self.source.path,
            "input_hash": None,
            "input_bytes": None,
            "input_changed": None,
            "recipe": self.recipe.hash,
            "versions": versions(),
            "status": "done",
            "failure": None,
            "outputs": [],
            "steps": [],
            "thumbnail": None,
            "seconds": {},
            "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime()),
            "worker": f"{socket.gethostname()}:{os.getpid()}",
        }

    def _fetched(self, row: Row, folder: str) -> str:
        now = look(self.source.path)
        if now is None:
            raise ReadError(f"{self.source.path}: there is no such file", path=self.source.path)
        row["input_bytes"], row["input_changed"] = now.bytes, now.changed
        path = fetch(self.source.path, folder)
        row["input_hash"] = digest(path)
        return path

    def _is_finished(self, before: Row, row: Row, store: Store) -> bool:
        """Whether another worker has finished it, or an earlier run before the file was touched."""
        return (
            before["input_hash"] == row["input_hash"]
            and is_settled(before, self.recipe.hash, _core.VERSION, self.retry_failed)
            and is_whole(before, store.bytes)
        )

    def _draw(self, work: Work, folder: str) -> bool:
        """Draws the small picture of the last mesh."""
        mesh = getattr(work, "mesh", None)
        if not self.thumbnail or mesh is None or not mesh.face_count:
            return False
        try:
            size = (self.thumbnail, self.thumbnail)
            picture = render(mesh, size=size, smooth=mesh.face_count > 20_000, threads=self.cores)
            picture.save(os.path.join(folder, THUMBNAIL))
        except (CurvmeshError, OSError):
            # A mesh that is not a manifold has no picture.
            return False
        return True


def finish(store: Store, row: Row, before: Row | None, folder: str) -> None:
    """Writes the record of an input, and removes further files of an earlier one."""
    name = row["name"]
    if before is not None:
        files = {output["file"] for output in before["outputs"]}
        files |= {before["thumbnail"]} if before.get("thumbnail") else set()
        kept = {output["file"] for output in row["outputs"]} | {row["thumbnail"]}
        for file in sorted(files - kept):
            store.remove(f"{name}/{file}")
    try:
        store.put_text(line(row), f"{name}/{RECORD}", folder)
    except Exception as error:
        # The record is missing then, so the next run repeats the task.
        failed(row, error)


def failed(row: Row, error: BaseException, step: int | None = None, do: str = "") -> Row:
    """Records a failure."""
    # If the machine may be the cause, a retry may help.
    is_typed = isinstance(error, CurvmeshError)
    lasting = is_typed and not isinstance(error, (WriteError, InternalError))
    failure: Row = {
        "kind": type(error).__name__,
        "message": str(error) or type(error).__name__,
        "step": step,
        "do": do,
        "lasting": lasting,
    }
    if isinstance(error, CurvmeshError):
        for name in ("vertices", "faces", "edges", "count", "repair", "cure", "line", "byte", "place"):
            value = getattr(error, name)
            if value:
                failure[name] = plain(value)
    row["status"], row["failure"], row["outputs"] = "failed", failure, []
    return row


def versions() -> dict[str, str]:
    """Versions of everything that results may depend on."""
    import numpy

    return {
        "curvmesh": _core.VERSION,
        "numpy": numpy.__version__,
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
    }


@contextmanager
def _timed(seconds: dict[str, float], name: str) -> Iterator[None]:
    start = time.perf_counter()
    try:
        yield
    finally:
        seconds[name] = seconds.get(name, 0.0) + time.perf_counter() - start

