"""Meshes of PyVista."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ..._errors import ArrayError
from ..arrays import polygons
from ..mesh import Mesh
from .parts import EXTRAS, merged, noted, owned, put, read_extras, rejoined, separate, taken, with_extras

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Data that belongs to filters of VTK.
_OF_FILTERS = ("vtkOriginalPointIds", "vtkOriginalCellIds", "vtkGhostType")

#: Names that have a meaning in VTK.
TAKEN = ("Normals", "Texture Coordinates", *_OF_FILTERS)


def of_blocks(source: Any, check: bool) -> Mesh:
    """A ``pyvista.MultiBlock``: each block a group."""
    notes: list[str] = []
    leaves = list(_leaves(source, "", check, notes))
    if not leaves:
        raise ArrayError(f"the {type(source).__name__} has no cells")
    return noted(merged([mesh for _, mesh in leaves], [name for name, _ in leaves]), notes)


def _leaves(source: Any, path: str, check: bool, notes: list[str]) -> Iterator[tuple[str, Mesh]]:
    """The names and meshes of all blocks, also of blocks inside blocks."""
    for number, (name, block) in enumerate(zip(source.keys(), source)):
        name = f"{path}{name or f'block {number}'}"
        if hasattr(block, "n_blocks"):
            yield from _leaves(block, f"{name}/", check, notes)
        elif block is not None and block.n_cells:
            yield name, of_pyvista(block, check)
        elif block is not None:
            notes.append(f"block {name!r} was left out: it has no cells")


def of_pyvista(source: Any, check: bool) -> Mesh:
    """A ``pyvista.PolyData``, or the surface of another data set."""
    import numpy as np

    notes: list[str] = []
    # The surface of a grid has separate corners for each cell.
    is_grid = not hasattr(source, "faces") and not hasattr(source, "celltypes")
    for kind in ("point", "cell"):
        data = getattr(source, f"{kind}_data", None) or {}
        of_filters = [name for name in _OF_FILTERS if name in data]
        notes += [f"{name!r} of {kind}s was left out: it belongs to filters of VTK" for name in of_filters]
    if not hasattr(source, "faces"):
        if source.n_cells and any(kind not in (3, 5, 6, 7, 8, 9) for kind in np.unique(_cell_types(source))):
            notes.append("cells that are no polygons were replaced by their surface")
        with warnings.catch_warnings():
            # Newer versions require the name of the algorithm, which older ones do not know.
            warnings.simplefilter("ignore")
            source = source.extract_surface(pass_pointid=False, pass_cellid=False)
    corners, ends, cells, lost = _faces(source)
    if lost:
        notes.append(f"{lost} points and lines were left out")
    mesh = Mesh._of(polygons(source.points, corners, ends, check))
    uvs = getattr(source, "active_texture_coordinates", None)
    numbers = dict(getattr(source, "point_data", None) or {})
    if uvs is not None:
        numbers.pop(source.GetPointData().GetTCoords().GetName(), None)
    of_points = taken(numbers, mesh.vertex_count, notes)
    of_cells = taken(getattr(source, "cell_data", None), getattr(source, "n_cells", len(cells)), notes)
    fields = getattr(source, "field_data", None) or {}
    names = list(fields.keys())
    kept = read_extras(str(np.asarray(fields[EXTRAS]).ravel()[0])) if EXTRAS in names else None
    if uvs is not None:
        mesh.corner_data["uvs"] = np.asarray(uvs)[:, :2][mesh.corners]
        mesh = rejoined(mesh, kept)
    if kept:
        with_extras(mesh, kept)
    others = ", ".join(repr(name) for name in names if name != EXTRAS or not kept)
    notes += [f"field data was left out: {others}"] * bool(others)
    for name in _OF_FILTERS:
        of_points.pop(name, None)
        of_cells.pop(name, None)
    if of_cells.pop("normals", None) is not None:
        notes.append("normals of cells were left out: they follow from the positions")
    owned(mesh, of_cells, kept, notes)
    put(mesh.vertex_data, of_points, notes)
    put(mesh.face_data, {name: values[cells] for name, values in of_cells.items()}, notes)
    return noted(mesh.joined() if is_grid else mesh, notes)


def _cell_types(source: Any) -> Any:
    return source.celltypes if hasattr(source, "celltypes") else [source.GetCellType(0)]


def _faces(source: Any) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], int]:
    """Corners and ends of all faces, the cell of each, and the number of other cells."""
    import numpy as np

    padded = np.asarray(source.faces)
    if padded.ndim == 2:
        padded = np.column_stack([np.full(len(padded), padded.shape[1]), padded]).ravel()
    corners, ends = _unpadded(padded)
    faces = len(ends)
    others = getattr(source, "n_verts", 0) + getattr(source, "n_lines", 0)
    cells = [others + np.arange(faces)]
    if getattr(source, "n_strips", 0):
        strips, strip_ends = _unpadded(np.asarray(source.strips))
        starts = np.concatenate([[0], strip_ends[:-1]])
        made, of = [], []
        for number, (start, end) in enumerate(zip(starts, strip_ends)):
            k = np.arange(start, end - 2)
            odd = (k - start) % 2
            made.append(np.column_stack([strips[k], strips[k + 1 + odd], strips[k + 2 - odd]]))
            of.append(np.full(len(k), others + faces + number))
        rows = np.concatenate(made)
        last = ends[-1] if faces else 0
        ends = np.concatenate([ends, last + 3 * np.arange(1, len(rows) + 1)])
        corners = np.concatenate([corners, rows.ravel()])
        cells += of
    return corners, ends, np.concatenate(cells), others


def _unpadded(padded: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Corners and ends of faces, from a list in which the number of corners precedes each face."""
    import numpy as np

    padded = padded.astype(np.int64)
    if len(padded) and len(padded) % 4 == 0 and (padded[::4] == 3).all():
        corners = padded.reshape(-1, 4)[:, 1:].reshape(-1)
        return corners, np.arange(3, len(corners) + 1, 3)
    places: list[int] = []
    at = 0
    while at < len(padded):
        places.append(at)
        at += int(padded[at]) + 1
    keep = np.ones(len(padded), bool)
    keep[places] = False
    return padded[keep], np.cumsum(padded[places]).astype(np.int64)


def to_pyvista(mesh: Mesh) -> Any:
    """A ``pyvista.PolyData`` with all data: vertices are split where texture coordinates or normals of
    their corners differ. Groups, materials and images are in ``field_data["curvmesh"]``."""
    import numpy as np
    import pyvista

    parts = separate(mesh, "PyVista", TAKEN)
    starts = np.concatenate([[0], parts.ends[:-1]]).astype(np.int64)
    padded = np.insert(parts.corners.astype(np.int64), starts, parts.ends - starts)
    made = pyvista.PolyData(parts.positions, faces=padded)
    for name, values in parts.of_points.items():
        made.point_data[name] = values
    for name, values in parts.of_faces.items():
        made.cell_data[name] = values
    if parts.normals is not None:
        made.point_data["Normals"] = parts.normals
    if parts.uvs is not None:
        made.active_texture_coordinates = parts.uvs
    if parts.extras:
        made.field_data[EXTRAS] = [parts.extras]
    return made
