"""Exceptions: one class for each kind, with element ids and the remedy."""

from __future__ import annotations

import errno as codes
import os
from collections.abc import Sequence
from typing import Any


class RepairWarning(UserWarning):
    """A mesh is no oriented manifold, and was repaired for a function that needs one.

    Degenerate and duplicate faces are dropped, the surface is cut where it is not a manifold, and faces are reversed
    where neighbours disagree. :func:`curvmesh.repair` returns the repaired mesh; :meth:`curvmesh.Mesh.validate`
    raises an exception instead.
    """


class CurvmeshError(Exception):
    """Base class of all exceptions of this package.

    Attributes
    ----------
    vertices, faces : list of int
        The first eight vertices or faces at fault, as indices of the arrays.
    edges : list of (int, int)
        The first eight edges at fault, each by its two vertices.
    count : int
        Number of elements at fault.
    repair : str
        The argument of :func:`curvmesh.repair` that repairs the defect, or an empty string.
    cure : str
        Another remedy, or an empty string.
    path : str
        The file, or an empty string.
    line, byte : int or None
        Place in the file.
    place : str
        Place in a glTF document.
    """

    def __init__(
        self,
        message: str = "",
        *,
        vertices: Sequence[int] = (),
        faces: Sequence[int] = (),
        edges: Sequence[tuple[int, int]] = (),
        count: int = 0,
        repair: str = "",
        cure: str = "",
        path: str = "",
        line: int | None = None,
        byte: int | None = None,
        place: str = "",
    ) -> None:
        super().__init__(message)
        self.vertices = list(vertices)
        self.faces = list(faces)
        self.edges = list(edges)
        self.count = count
        self.repair = repair
        self.cure = cure
        self.path = path
        self.line = line
        self.byte = byte
        self.place = place


class ArrayError(CurvmeshError, ValueError):
    """An array has the wrong shape or type, or does not fit the mesh."""


class OptionError(CurvmeshError, ValueError):
    """An option has an invalid value, or conflicts with another option."""


class OutOfRangeError(CurvmeshError, IndexError):
    """A face refers to a vertex that does not exist, or the requested face does not exist."""


class NotFiniteError(CurvmeshError, ValueError):
    """A coordinate is infinite or NaN."""


class DegenerateFaceError(CurvmeshError, ValueError):
    """A face uses a vertex twice, or has fewer than three corners."""


class DuplicateFaceError(CurvmeshError, ValueError):
    """Several faces have the same vertices."""


class NonManifoldError(CurvmeshError, ValueError):
    """More than two faces share an edge, or two surfaces touch only in a vertex."""


class OrientationError(CurvmeshError, ValueError):
    """Adjacent faces have opposite orientations."""


class TooLargeError(CurvmeshError, ValueError):
    """There are more elements than 32-bit indices can address."""


class _FileError(CurvmeshError, OSError):
    """A file error. If the system refused the operation, `errno`, `filename` and `strerror` give the reason.

    The class is then also a subclass of the one that Python itself raises, such as ``FileNotFoundError``.
    """

    def __new__(cls, message: str = "", *, errno: int | None = None, **_: Any) -> _FileError:
        found: _FileError = OSError.__new__(_OF_SYSTEM.get((cls, errno), cls), message)
        return found

    def __init__(self, message: str = "", *, errno: int | None = None, **attributes: Any) -> None:
        super().__init__(message, **attributes)
        if errno is not None:
            self.errno = errno
            self.strerror = os.strerror(errno)
            self.filename = self.path or None

    def __str__(self) -> str:
        return str(self.args[0])

    def __reduce__(self) -> tuple[Any, ...]:
        return _again, (type(self), str(self), {**vars(self), "errno": self.errno})


def _again(kind: type[_FileError], message: str, attributes: dict[str, Any]) -> _FileError:
    return kind(message, **attributes)


class ReadError(_FileError):
    """A file cannot be read."""


class WriteError(_FileError):
    """A file cannot be written; a file of that name is unchanged."""


class NoFileError(ReadError, FileNotFoundError):
    """The file does not exist."""


class UnreadableFileError(ReadError, PermissionError):
    """Reading the file is not permitted."""


class NotAFileError(ReadError, IsADirectoryError):
    """The path is a folder."""


class NoFolderError(WriteError, FileNotFoundError):
    """The folder of the file does not exist."""


class UnwritableFileError(WriteError, PermissionError):
    """Writing the file is not permitted."""


class TargetIsFolderError(WriteError, IsADirectoryError):
    """The path is a folder."""


#: The class for an error number of the system.
_OF_SYSTEM: dict[tuple[type[_FileError], int | None], type[_FileError]] = {
    (ReadError, codes.ENOENT): NoFileError,
    (ReadError, codes.EACCES): UnreadableFileError,
    (ReadError, codes.EPERM): UnreadableFileError,
    (ReadError, codes.EISDIR): NotAFileError,
    (WriteError, codes.ENOENT): NoFolderError,
    (WriteError, codes.EACCES): UnwritableFileError,
    (WriteError, codes.EPERM): UnwritableFileError,
    (WriteError, codes.EISDIR): TargetIsFolderError,
}


class RecordError(CurvmeshError, ValueError):
    """A record of collapses cannot be read, or belongs to another mesh."""


class CannotBeDoneError(CurvmeshError, ValueError):
    """The mesh cannot be processed as requested."""


class InternalError(CurvmeshError, RuntimeError):
    """A defect of curvmesh; please report it."""
