"""Curvature, simplification, edge flips, patches and distances of triangle meshes.

Arrays in, arrays out. Every function takes whatever is a mesh (see :func:`as_mesh`), lets other threads
work while it works, stops at Ctrl-C, and has the results of the program ``curvmesh`` to the last bit.
"""

from __future__ import annotations

# Type checkers take this for true; `typing` itself is not imported, so that importing this takes no time.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from . import batch, regions, shapes
    from ._call import State
    from ._convert import as_mesh
    from ._core import VERSION as __version__
    from ._curvature import Curvature, curvature
    from ._distance import Bounds, Distance, OneSided, distance
    from ._errors import (
        ArrayError,
        CannotBeDoneError,
        CurvmeshError,
        DegenerateFaceError,
        DuplicateFaceError,
        InternalError,
        NonManifoldError,
        NotFiniteError,
        OptionError,
        OrientationError,
        OutOfRangeError,
        ReadError,
        RecordError,
        TooLargeError,
        WriteError,
    )
    from ._flip import EdgeCost, FaceCost, Flipped, flip
    from ._info import Info, Repaired, info, repair, subdivide
    from ._mesh import Data, Mesh, read, write
    from ._patch import Cover, patch
    from ._show import Page, Picture, render, view
    from ._simplify import Edges, ErrorBounds, Fit, Level, Levels, Record, Simplified, lod, simplify

#: Where things are: a module is imported when something in it is needed first.
_PLACES = {
    "_call": "State",
    "_convert": "as_mesh",
    "_curvature": "Curvature curvature",
    "_distance": "Bounds Distance OneSided distance",
    "_errors": "ArrayError CannotBeDoneError CurvmeshError DegenerateFaceError DuplicateFaceError InternalError NonManifoldError NotFiniteError OptionError OrientationError OutOfRangeError ReadError RecordError TooLargeError WriteError",
    "_flip": "EdgeCost FaceCost Flipped flip",
    "_info": "Info Repaired info repair subdivide",
    "_mesh": "Data Mesh read write",
    "_patch": "Cover patch",
    "_show": "Page Picture render view",
    "_simplify": "Edges ErrorBounds Fit Level Levels Record Simplified lod simplify",
}
_MODULE_OF = {name: module for module, names in _PLACES.items() for name in names.split()}

__all__ = [
    "ArrayError",
    "Bounds",
    "CannotBeDoneError",
    "Cover",
    "Curvature",
    "CurvmeshError",
    "Data",
    "DegenerateFaceError",
    "Distance",
    "DuplicateFaceError",
    "EdgeCost",
    "Edges",
    "ErrorBounds",
    "FaceCost",
    "Fit",
    "Flipped",
    "Info",
    "InternalError",
    "Level",
    "Levels",
    "Mesh",
    "NonManifoldError",
    "NotFiniteError",
    "OneSided",
    "OptionError",
    "OrientationError",
    "OutOfRangeError",
    "Page",
    "Picture",
    "ReadError",
    "Record",
    "RecordError",
    "Repaired",
    "Simplified",
    "State",
    "TooLargeError",
    "WriteError",
    "__version__",
    "as_mesh",
    "batch",
    "curvature",
    "distance",
    "flip",
    "info",
    "lod",
    "patch",
    "read",
    "regions",
    "render",
    "repair",
    "shapes",
    "simplify",
    "subdivide",
    "view",
    "write",
]


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name in ("batch", "regions", "shapes"):
        return import_module(f".{name}", __name__)
    if name == "__version__":
        found: object = import_module("._core", __name__).VERSION
    elif name in _MODULE_OF:
        found = getattr(import_module(f".{_MODULE_OF[name]}", __name__), name)
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    globals()[name] = found
    return found


def __dir__() -> list[str]:
    return sorted(__all__)
