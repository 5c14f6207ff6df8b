"""Curvature, simplification, edge flips, patches and distances of triangle meshes.

Arrays in, arrays out. Every function takes any mesh-like object (see :func:`as_mesh`), releases the
interpreter lock while it works, stops at Ctrl-C, and gives the same bits as the program ``curvmesh``.
"""

from __future__ import annotations

# Type checkers treat this as true; `typing` itself is not imported, to keep the import fast.
TYPE_CHECKING = False
if TYPE_CHECKING:
    from . import batch, examples, regions, shapes
    from ._call import State
    from ._core import VERSION as __version__
    from ._geometry.curvature import Curvature, curvature
    from ._geometry.distance import Bounds, Distance, OneSided, Signed, distance
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
        RepairWarning,
        TooLargeError,
        WriteError,
    )
    from ._geometry.flip import EdgeCost, FaceCost, Flipped, flip
    from ._geometry.info import Info, Repaired, info, repair, subdivide
    from ._geometry.files import as_mesh, read, write
    from ._geometry.mesh import Data, Mesh
    from ._geometry.patch import Cover, patch
    from ._geometry.scene import (
        MeshOfLevel,
        MeshOfScene,
        PoseErrors,
        Scene,
        SceneLevel,
        SceneLevels,
        SimplifiedScene,
        lod_scene,
        read_scene,
        simplify_scene,
        write_scene,
    )
    from ._geometry.show import Figure, Page, Picture, figure, render, view
    from ._geometry.simplify import (
        Charts,
        Edges,
        ErrorBounds,
        Fit,
        Level,
        Levels,
        Record,
        Shortfall,
        Simplified,
        TurnedOver,
        lod,
        simplify,
    )

#: The module of each public name; it is imported at the first use of the name.
_PLACES = {
    "_call": "State",
    "_geometry.curvature": "Curvature curvature",
    "_geometry.distance": "Bounds Distance OneSided Signed distance",
    "_errors": "ArrayError CannotBeDoneError CurvmeshError DegenerateFaceError DuplicateFaceError InternalError NonManifoldError NotFiniteError OptionError OrientationError OutOfRangeError ReadError RecordError RepairWarning TooLargeError WriteError",
    "_geometry.flip": "EdgeCost FaceCost Flipped flip",
    "_geometry.info": "Info Repaired info repair subdivide",
    "_geometry.files": "as_mesh read write",
    "_geometry.mesh": "Data Mesh",
    "_geometry.patch": "Cover patch",
    "_geometry.scene": "MeshOfLevel MeshOfScene PoseErrors Scene SceneLevel SceneLevels SimplifiedScene lod_scene read_scene simplify_scene write_scene",
    "_geometry.show": "Figure Page Picture figure render view",
    "_geometry.simplify": "Charts Edges ErrorBounds Fit Level Levels Record Shortfall Simplified TurnedOver lod simplify",
}
_MODULE_OF = {name: module for module, names in _PLACES.items() for name in names.split()}

__all__ = [
    "ArrayError",
    "Bounds",
    "CannotBeDoneError",
    "Charts",
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
    "Figure",
    "Fit",
    "Flipped",
    "Info",
    "InternalError",
    "Level",
    "Levels",
    "Mesh",
    "MeshOfLevel",
    "MeshOfScene",
    "NonManifoldError",
    "NotFiniteError",
    "OneSided",
    "OptionError",
    "OrientationError",
    "OutOfRangeError",
    "Page",
    "Picture",
    "PoseErrors",
    "ReadError",
    "Record",
    "RecordError",
    "RepairWarning",
    "Repaired",
    "Scene",
    "SceneLevel",
    "SceneLevels",
    "Shortfall",
    "Signed",
    "Simplified",
    "SimplifiedScene",
    "State",
    "TooLargeError",
    "TurnedOver",
    "WriteError",
    "__version__",
    "as_mesh",
    "batch",
    "curvature",
    "distance",
    "examples",
    "figure",
    "flip",
    "info",
    "lod",
    "lod_scene",
    "patch",
    "read",
    "read_scene",
    "regions",
    "render",
    "repair",
    "shapes",
    "simplify",
    "simplify_scene",
    "subdivide",
    "view",
    "write",
    "write_scene",
]


def __getattr__(name: str) -> object:
    from importlib import import_module

    if name in ("batch", "examples", "regions", "shapes"):
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
