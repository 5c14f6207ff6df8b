"""Curvature, simplification, edge flips, patches and distances of triangle meshes.

Arrays in, arrays out. Every function takes whatever is a mesh (see :func:`as_mesh`), lets other threads
work while it works, stops at Ctrl-C, and has the results of the program ``curvmesh`` to the last bit.
"""

from . import shapes
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
    "curvature",
    "distance",
    "flip",
    "info",
    "lod",
    "patch",
    "read",
    "render",
    "repair",
    "shapes",
    "simplify",
    "subdivide",
    "view",
    "write",
]
