"""Meshes of VTK itself. PyVista is not needed."""

from __future__ import annotations

from typing import Any

from ..._errors import ArrayError
from ..mesh import Mesh
from .parts import EXTRAS, merged, noted, separate
from .pyvista import TAKEN, of_pyvista

#: Cells that are polygons: triangles, strips, polygons, pixels and quadrilaterals; and vertices and lines.
_FLAT = (0, 1, 2, 3, 4, 5, 6, 7, 8, 9)


class _Surface:
    """A ``vtkPolyData`` with the names of PyVista for its parts."""

    def __init__(self, source: Any) -> None:
        self._source = source
        self.n_cells = source.GetNumberOfCells()
        self.n_verts = source.GetNumberOfVerts()
        self.n_lines = source.GetNumberOfLines()
        self.n_strips = source.GetNumberOfStrips()
        self.point_data = _arrays(source.GetPointData())
        self.cell_data = _arrays(source.GetCellData())
        self.field_data = _arrays(source.GetFieldData())

    @property
    def points(self) -> Any:
        import numpy as np

        points = self._source.GetPoints()
        return np.empty((0, 3)) if points is None else _numbers(points.GetData())

    @property
    def faces(self) -> Any:
        return _padded(self._source.GetPolys())

    @property
    def strips(self) -> Any:
        return _padded(self._source.GetStrips())

    @property
    def active_texture_coordinates(self) -> Any:
        found = self._source.GetPointData().GetTCoords()
        return None if found is None else _numbers(found)

    def GetPointData(self) -> Any:
        return self._source.GetPointData()


def _numbers(array: Any) -> Any:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(array)


def _padded(cells: Any) -> Any:
    """The corners of cells, with their number before each."""
    from vtkmodules.vtkCommonCore import vtkIdTypeArray

    found = vtkIdTypeArray()
    cells.ExportLegacyFormat(found)
    return _numbers(found)


def _arrays(data: Any) -> dict[str, Any]:
    """Arrays by name; texts as lists."""
    found: dict[str, Any] = {}
    for number in range(data.GetNumberOfArrays()):
        array = data.GetAbstractArray(number)
        name = str(array.GetName() or f"array {number}")
        if array.IsA("vtkStringArray"):
            found[name] = [array.GetValue(k) for k in range(array.GetNumberOfValues())]
        elif array.IsA("vtkDataArray"):
            found[name] = _numbers(array)
    return found


def of_vtk(source: Any, check: bool) -> Mesh:
    """A ``vtkPolyData``, the surface of another data set, or the blocks of a composite one, each a group."""
    if source.IsA("vtkCompositeDataSet"):
        return _of_blocks(source, check)
    if not source.IsA("vtkDataSet"):
        raise ArrayError(f"a {source.GetClassName()} is no data set")
    if source.IsA("vtkPolyData"):
        return of_pyvista(_Surface(source), check)
    from vtkmodules.vtkCommonDataModel import vtkCellTypes
    from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter

    kinds = vtkCellTypes()
    source.GetCellTypes(kinds)
    known = [kinds.GetCellType(k) for k in range(kinds.GetNumberOfTypes())]
    surface = vtkGeometryFilter()
    surface.SetInputData(source)
    surface.Update()
    mesh = of_pyvista(_Surface(surface.GetOutput()), check)
    if all(kind in _FLAT for kind in known):
        return mesh
    # The surface of a grid can have separate corners for each cell.
    notes = ["cells that are no polygons were replaced by their surface"]
    return noted(mesh if source.IsA("vtkUnstructuredGrid") else mesh.joined(), [*mesh.notes, *notes])


def _of_blocks(source: Any, check: bool) -> Mesh:
    from vtkmodules.vtkCommonDataModel import vtkCompositeDataSet

    meshes: list[Mesh] = []
    names: list[str] = []
    each = source.NewIterator()
    each.InitTraversal()
    while not each.IsDoneWithTraversal():
        block = each.GetCurrentDataObject()
        if block is not None and block.IsA("vtkDataSet") and block.GetNumberOfCells():
            about = each.GetCurrentMetaData() if each.HasCurrentMetaData() else None
            name = about.Get(vtkCompositeDataSet.NAME()) if about is not None else None
            meshes.append(of_vtk(block, check))
            names.append(str(name or f"block {len(names)}"))
        each.GoToNextItem()
    if not meshes:
        raise ArrayError(f"the {source.GetClassName()} has no cells")
    return merged(meshes, names)


def to_vtk(mesh: Mesh) -> Any:
    """A ``vtkPolyData`` with all data: vertices are split where texture coordinates or normals of their corners
    differ. Groups, materials and images are a text in the field data, ``"curvmesh"``."""
    import numpy as np
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints, vtkStringArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    def numbers(values: Any, name: str) -> Any:
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        return array

    def ids(values: Any) -> Any:
        return numpy_to_vtkIdTypeArray(np.ascontiguousarray(values, np.int64), deep=True)

    parts = separate(mesh, "VTK", TAKEN)
    points, cells, made = vtkPoints(), vtkCellArray(), vtkPolyData()
    points.SetData(numbers(parts.positions, "Points"))
    cells.SetData(ids(np.concatenate([[0], parts.ends])), ids(parts.corners))
    made.SetPoints(points)
    made.SetPolys(cells)
    for name, values in parts.of_points.items():
        made.GetPointData().AddArray(numbers(values, name))
    for name, values in parts.of_faces.items():
        made.GetCellData().AddArray(numbers(values, name))
    if parts.normals is not None:
        made.GetPointData().SetNormals(numbers(parts.normals, "Normals"))
    if parts.uvs is not None:
        made.GetPointData().SetTCoords(numbers(parts.uvs, "Texture Coordinates"))
    if parts.extras:
        text = vtkStringArray()
        text.SetName(EXTRAS)
        text.InsertNextValue(parts.extras)
        made.GetFieldData().AddArray(text)
    return made
