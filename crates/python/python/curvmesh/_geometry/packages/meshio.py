"""Meshes of meshio."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..._errors import ArrayError
from ..arrays import polygons
from ..mesh import Mesh
from .parts import EXTRAS, note, noted, owned, put, read_extras, rejoined, separate, taken, with_extras

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Cells that are faces, and the number of their corners; cells of higher order have more nodes.
_FACES = {"triangle": 3, "quad": 4, "triangle6": 3, "triangle7": 3, "quad8": 4, "quad9": 4}


def of_meshio(source: Any, check: bool) -> Mesh:
    """A ``meshio.Mesh``: its faces; other cells are noted."""
    import numpy as np

    points = np.asarray(source.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.hstack([points, np.zeros((len(points), 1))])
    notes: list[str] = []
    flat: list[NDArray[Any]] = []
    sizes: list[int] = []
    blocks: list[int] = []
    for number, block in enumerate(source.cells):
        if block.type not in _FACES and block.type != "polygon":
            notes.append(f"{len(block.data)} cells of type {block.type!r} were left out")
            continue
        cells = [np.asarray(cell)[: _FACES.get(block.type)] for cell in block.data]
        if block.type[-1].isdigit():
            notes.append(f"{len(cells)} cells of type {block.type!r} were taken as flat")
        flat.extend(cells)
        sizes.extend(len(cell) for cell in cells)
        blocks.append(number)
    if not flat:
        kinds = sorted({block.type for block in source.cells})
        raise ArrayError(f"the mesh has no faces, only {', '.join(kinds) or 'points'}")
    mesh = Mesh._of(polygons(points, np.concatenate(flat), np.cumsum(sizes), check))
    numbers = dict(source.point_data)
    uvs = np.asarray(numbers.get("uvs", ()))
    # Files of VTK add a third column to texture coordinates.
    has_uvs = uvs.shape == (mesh.vertex_count, 2) or uvs.shape == (mesh.vertex_count, 3) and not uvs[:, 2].any()
    if has_uvs:
        del numbers["uvs"]
    of_points = taken(numbers, mesh.vertex_count, notes)
    _take_colors(of_points)
    joined = {
        name: np.concatenate([np.asarray(parts[i]) for i in blocks])
        for name, parts in source.cell_data.items()
    }
    of_faces = taken(joined, mesh.face_count, notes)
    if of_faces.pop("normals", None) is not None:
        notes.append("normals of cells were left out: they follow from the positions")
    kept = read_extras((getattr(source, "info", None) or {}).get(EXTRAS))
    owned(mesh, of_faces, kept, notes)
    if kept:
        with_extras(mesh, kept)
    else:
        _take_sets(mesh, source, blocks, of_faces, notes)
    for what, text in (("field_data", "field data was"), ("point_sets", "sets of points were")):
        names = ", ".join(repr(name) for name in getattr(source, what, None) or {})
        notes += [f"{text} left out: {names}"] * bool(names)
    put(mesh.vertex_data, of_points, notes)
    put(mesh.face_data, of_faces, notes)
    if has_uvs:
        mesh.corner_data["uvs"] = uvs[mesh.corners, :2]
        mesh = rejoined(mesh, kept)
    return noted(mesh, notes)


def _take_colors(of_points: dict[str, Any]) -> None:
    """The columns of colours of PLY files as colours."""
    import numpy as np

    names = [name for name in ("red", "green", "blue", "alpha") if name in of_points]
    kinds = {of_points[name].dtype for name in names}
    if names[:3] == ["red", "green", "blue"] and "colors" not in of_points and kinds <= {np.dtype("u1")}:
        of_points["colors"] = np.column_stack([of_points.pop(name) for name in names])


def _take_sets(
    mesh: Mesh, source: Any, blocks: list[int], of_faces: dict[str, Any], notes: list[str]
) -> None:
    """Sets of cells as groups; a face belongs to the last set that contains it."""
    import numpy as np

    sets = getattr(source, "cell_sets", None) or {}
    if not sets:
        return
    starts = np.cumsum([0, *(len(source.cells[i].data) for i in blocks)])
    groups = np.full(mesh.face_count, -1)
    overlaps = 0
    for number, parts in enumerate(sets.values()):
        for start, block in zip(starts, blocks):
            if parts[block] is not None:
                faces = start + np.asarray(parts[block], int)
                overlaps += int((groups[faces] >= 0).sum())
                groups[faces] = number
    if overlaps:
        notes.append(f"sets of cells overlap in {overlaps} faces, which belong to the last set that has them")
    mesh.groups = [("", str(name)) for name in sets]
    of_faces["groups"] = groups


def to_meshio(mesh: Mesh) -> Any:
    """A ``meshio.Mesh`` with all data: vertices are split where texture coordinates or normals of their
    corners differ. Groups are sets of cells; materials and images are in ``info["curvmesh"]``."""
    import meshio
    import numpy as np

    parts = separate(mesh, "meshio")
    ends, points = parts.ends, parts.of_points
    sizes = np.diff(ends, prepend=0)
    if (np.diff(sizes) < 0).any():
        note(mesh, "a mesh of meshio has its faces in another order: by their number of corners")
    names = {3: "triangle", 4: "quad"}
    cells, orders = [], []
    for size in np.unique(sizes):
        of_size = np.flatnonzero(sizes == size)
        rows = parts.corners[(ends[of_size] - size)[:, None] + np.arange(size)]
        cells.append((names.get(int(size), "polygon"), rows))
        orders.append(of_size)
    if parts.normals is not None:
        points["normals"] = parts.normals
    if parts.uvs is not None:
        points["uvs"] = parts.uvs
    sets = {}
    of_groups = mesh.face_data.get("groups")
    if of_groups is not None:
        for number, group in enumerate(mesh.groups):
            name = "/".join(filter(None, group)) or f"group {number}"
            sets[name] = [np.flatnonzero(of_groups[order] == number) for order in orders]
    return meshio.Mesh(
        parts.positions,
        cells,
        point_data=points,
        cell_data={name: [values[order] for order in orders] for name, values in parts.of_faces.items()},
        cell_sets=sets or None,
        info={EXTRAS: parts.extras} if parts.extras else None,
    )
