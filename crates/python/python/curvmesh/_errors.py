"""What can go wrong: one class per kind, with ids and what would cure it."""

from __future__ import annotations

from collections.abc import Sequence


class CurvmeshError(Exception):
    """Something is wrong with a mesh, a file or an option.

    Attributes
    ----------
    vertices, faces : list of int
        The first of the vertices or faces at fault, counted from 0 as in the arrays; at most eight.
    edges : list of (int, int)
        The first of the edges at fault, each by its two vertices.
    count : int
        How many there are in all.
    repair : str
        The argument of :func:`curvmesh.repair` that mends it, or an empty string.
    cure : str
        What else would help, or an empty string.
    path : str
        The file, if it is about one.
    line, byte : int or None
        Where in the file.
    place : str
        Where in a glTF document.
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
    """An option has a value that makes no sense, or does not go with another one."""


class OutOfRangeError(CurvmeshError, IndexError):
    """Faces refer to vertices that are not there, or a face that is asked for is not there."""


class NotFiniteError(CurvmeshError, ValueError):
    """Coordinates are infinite or not numbers."""


class DegenerateFaceError(CurvmeshError, ValueError):
    """Faces use a vertex twice, or have fewer than three corners."""


class DuplicateFaceError(CurvmeshError, ValueError):
    """Several faces have the same vertices."""


class NonManifoldError(CurvmeshError, ValueError):
    """More than two faces share an edge, or surfaces touch in a vertex only."""


class OrientationError(CurvmeshError, ValueError):
    """Neighbouring faces disagree on which side is outside."""


class TooLargeError(CurvmeshError, ValueError):
    """There are more elements than 32-bit indices can address."""


class ReadError(CurvmeshError, OSError):
    """A file cannot be read."""


class WriteError(CurvmeshError, OSError):
    """A file cannot be written; what was there is as it was."""


class RecordError(CurvmeshError, ValueError):
    """A record of collapses cannot be read, or is that of another mesh."""


class CannotBeDoneError(CurvmeshError, ValueError):
    """The mesh cannot be processed as asked."""


class InternalError(CurvmeshError, RuntimeError):
    """A defect of curvmesh; please report it."""
