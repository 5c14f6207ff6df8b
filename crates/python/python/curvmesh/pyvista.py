"""The plugin for PyVista: ``mesh.curvmesh`` of every ``PolyData`` and ``UnstructuredGrid``, and a reader of OFF files.

PyVista loads it automatically, from version 0.48 on::

    small = pyvista.read("scan.ply").curvmesh.simplify(ratio=0.1)
"""

from __future__ import annotations

import warnings
from typing import Any

import pyvista

from ._geometry.files import read as _read
from ._geometry.info import Info
from ._geometry.mesh import Mesh
from ._geometry.packages.pyvista import of_pyvista, to_pyvista
from ._geometry.show import Picture
from ._geometry.show import render as _render

__all__ = ["Accessor", "read"]


@pyvista.register_dataset_accessor("curvmesh", pyvista.UnstructuredGrid)
@pyvista.register_dataset_accessor("curvmesh", pyvista.PolyData)
class Accessor:
    """``mesh.curvmesh`` of every ``PolyData`` and ``UnstructuredGrid``: the functions of this package, with results
    of PyVista. A warning lists what a mesh of this package has no place for, such as lines and texts."""

    def __init__(self, source: Any) -> None:
        self._source = source

    @property
    def mesh(self) -> Mesh:
        """The mesh as one of this package; of a grid, its surface."""
        return of_pyvista(self._source, True)

    def _taken(self) -> Mesh:
        """The mesh, with a warning of what is not in it: results of PyVista have no place for notes."""
        mesh = self.mesh
        for note in mesh.notes:
            warnings.warn(f"curvmesh: {note}", stacklevel=3)
        return mesh

    def info(self, **options: Any) -> Info:
        """Counts, topology and defects; see :func:`curvmesh.info`."""
        return self.mesh.info(**options)

    def render(self, values: Any = None, **options: Any) -> Picture:
        """A picture without a display; see :func:`curvmesh.render`."""
        return _render(self.mesh, values, **options)

    def simplify(self, **options: Any) -> Any:
        """A simplified ``pyvista.PolyData``; see :func:`curvmesh.simplify`."""
        return to_pyvista(self._taken().simplify(**options).mesh)

    def flip(self, **options: Any) -> Any:
        """A ``pyvista.PolyData`` after edge flips; see :func:`curvmesh.flip`."""
        return to_pyvista(self._taken().flip(**options).mesh)

    def repair(self, **options: Any) -> Any:
        """A repaired ``pyvista.PolyData``; see :func:`curvmesh.repair`."""
        return to_pyvista(self._taken().repair(**options).mesh)

    def curvature(self, **options: Any) -> Any:
        """The mesh with its curvatures as data of points or cells; see :func:`curvmesh.curvature`."""
        mesh = self._taken()
        found = mesh.curvature(**options)
        made = to_pyvista(found.mesh) if found.on == "face" else self._copied(mesh)
        data = made.cell_data if found.on == "face" else made.point_data
        for name in ("mean", "gaussian", "k1", "k2", "shape_index", "curvedness"):
            data[name] = found[name]
        return made

    def distance(self, other: Any, **options: Any) -> Any:
        """The mesh with the distance of every point from another mesh as ``point_data["distance"]``."""
        mesh = self._taken()
        made = self._copied(mesh)
        made.point_data["distance"] = mesh.distance(other, **options).of_vertices
        return made

    def _copied(self, mesh: Mesh) -> Any:
        """A copy of the source; of a grid, its surface, which has the vertices of the mesh."""
        return self._source.copy() if isinstance(self._source, pyvista.PolyData) else to_pyvista(mesh)


def read(path: str, **options: Any) -> Any:
    """A file as a ``pyvista.PolyData``, with all data; see :func:`curvmesh.read`."""
    return to_pyvista(_read(path, **options))
