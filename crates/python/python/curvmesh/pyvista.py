"""The plugin for PyVista: ``mesh.curvmesh`` of every ``pyvista.PolyData``, and a reader of OFF files.

PyVista loads it automatically, from version 0.48 on::

    small = pyvista.read("scan.ply").curvmesh.simplify(ratio=0.1)
"""

from __future__ import annotations

from typing import Any

import pyvista

from ._geometry.files import read as _read
from ._geometry.mesh import Mesh
from ._geometry.packages.pyvista import of_pyvista, to_pyvista

__all__ = ["Accessor", "read"]


@pyvista.register_dataset_accessor("curvmesh", pyvista.PolyData)
class Accessor:
    """``mesh.curvmesh`` of every ``pyvista.PolyData``: the functions of this package, with results of PyVista."""

    def __init__(self, source: Any) -> None:
        self._source = source

    @property
    def mesh(self) -> Mesh:
        """The mesh as one of this package."""
        return of_pyvista(self._source, True)

    def simplify(self, **options: Any) -> Any:
        """A simplified ``pyvista.PolyData``; see :func:`curvmesh.simplify`."""
        return to_pyvista(self.mesh.simplify(**options).mesh)

    def flip(self, **options: Any) -> Any:
        """A ``pyvista.PolyData`` after edge flips; see :func:`curvmesh.flip`."""
        return to_pyvista(self.mesh.flip(**options).mesh)

    def repair(self, **options: Any) -> Any:
        """A repaired ``pyvista.PolyData``; see :func:`curvmesh.repair`."""
        return to_pyvista(self.mesh.repair(**options).mesh)

    def curvature(self, **options: Any) -> Any:
        """The mesh with its curvatures as data of points or cells; see :func:`curvmesh.curvature`."""
        found = self.mesh.curvature(**options)
        made = to_pyvista(found.mesh) if found.on == "face" else self._source.copy()
        data = made.cell_data if found.on == "face" else made.point_data
        for name in ("mean", "gaussian", "k1", "k2", "shape_index", "curvedness"):
            data[name] = found[name]
        return made

    def distance(self, other: Any, **options: Any) -> Any:
        """The mesh with the distance of every point from another mesh as ``point_data["distance"]``."""
        made = self._source.copy()
        made.point_data["distance"] = self.mesh.distance(other, **options).of_vertices
        return made


def read(path: str, **options: Any) -> Any:
    """A file as a ``pyvista.PolyData``, with all data; see :func:`curvmesh.read`."""
    return to_pyvista(_read(path, **options))
