"""Meshes of other packages in and out, told by what they have; nothing is imported to look."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from . import _core
from ._errors import ArrayError, CurvmeshError
from ._mesh import Mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray


def as_mesh(source: Any, *, check: bool = True) -> Mesh:
    """The mesh that something is.

    Parameters
    ----------
    source : mesh-like
        A :class:`Mesh`; what has one as ``mesh``, such as the result of :func:`simplify`; a pair
        ``(vertices, faces)``; a path to read; anything with ``vertices`` and ``faces`` (trimesh),
        ``vertices`` and ``triangles`` (Open3D), ``points`` and ``cells`` (meshio) or ``points`` and
        ``faces`` (PyVista).
    check : bool
        As for :class:`Mesh`.

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.as_mesh(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    Mesh(3 vertices, 1 face)
    """
    import os

    if isinstance(source, Mesh):
        return source
    if isinstance(source, (str, os.PathLike)):
        from ._mesh import read

        return read(source)
    if isinstance(source, (tuple, list)) and len(source) == 2:
        return Mesh(source[0], source[1], check=check)
    result = getattr(source, "mesh", None)
    if isinstance(result, Mesh):
        return result
    if hasattr(source, "points") and hasattr(source, "cells"):
        return _of_meshio(source, check)
    if hasattr(source, "points") and hasattr(source, "faces"):
        return _of_pyvista(source, check)
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return _of_trimesh(source, check)
    if hasattr(source, "vertices") and hasattr(source, "triangles"):
        return _of_open3d(source, check)
    if hasattr(source, "vertex") and hasattr(source, "triangle"):
        return _of_open3d_tensors(source, check)
    raise ArrayError(
        f"a {type(source).__name__} is no mesh; give a curvmesh.Mesh, (vertices, faces), a path, or a "
        "mesh of trimesh, PyVista, Open3D or meshio"
    )


def coordinates(vertices: Any) -> NDArray[Any]:
    """Positions as rows of float32 or float64; copied only if they are of another type."""
    import numpy as np

    array = np.asarray(vertices)
    if array.size == 0:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ArrayError(f"vertices have the shape {array.shape}; it must be (n, 3)")
    if array.dtype.kind not in "fiub":
        raise ArrayError(f"vertices are of type {array.dtype}; they must be numbers")
    kind = np.float32 if array.dtype == np.float32 else np.float64
    return np.require(array, kind, "A")


def indices(faces: Any) -> NDArray[Any]:
    """Indices of 32 or 64 bits; copied only if they are of another type."""
    import numpy as np

    array = np.asarray(faces)
    if array.size == 0:
        array = np.empty((0, 3), np.int32)
    if array.dtype.kind not in "iu":
        raise ArrayError(f"faces are of type {array.dtype}; they must be integers")
    if array.ndim != 2 or array.shape[1] < 3:
        raise ArrayError(f"faces have the shape {array.shape}; it must be (m, 3)")
    name = "u" if array.dtype.kind == "u" else "i"
    size = 4 if array.dtype.itemsize <= 4 else 8
    if name == "u" and size == 4 and array.dtype.itemsize < 4:
        name = "i"
    return np.require(array, np.dtype(f"{name}{size}"), "A")


def content(vertices: Any, faces: Any, check: bool) -> _core.MeshData:
    """The content of arrays."""
    import numpy as np

    points, corners = coordinates(vertices), indices(faces)
    if corners.shape[1] == 3:
        return _core.MeshData.of_triangles(points, corners, check)
    rows, width = corners.shape
    ends = np.arange(1, rows + 1, dtype=np.int64) * width
    return polygons(points, corners.reshape(-1), ends, check)


def polygons(vertices: Any, corners: Any, ends: Any, check: bool) -> _core.MeshData:
    """The content of polygons: their corners, and where each ends."""
    import numpy as np

    flat = [np.require(array, np.int64, "A") for array in (corners, ends)]
    return _core.MeshData.of_polygons(coordinates(vertices), flat[0], flat[1], check)


def content_like(mesh: Mesh, vertices: Any) -> Mesh:
    """The faces and data of a mesh at other positions."""
    points = coordinates(vertices)
    if len(points) != mesh.vertex_count:
        raise ArrayError(f"there are {len(points)} positions for {mesh.vertex_count} vertices")
    moved = Mesh._of(polygons(points, mesh.corners, mesh.face_ends, True).with_joins(mesh.joins))
    for data, others in (
        (moved.vertex_data, mesh.vertex_data),
        (moved.corner_data, mesh.corner_data),
        (moved.face_data, mesh.face_data),
    ):
        kept = {n: a for n, a in others.items() if n not in ("normals", "groups", "materials")}
        if kept:
            data.update(kept)
    return moved


def _numbers(data: Any, count: int) -> dict[str, NDArray[Any]]:
    """What of a mapping is one number for each of so many elements."""
    import numpy as np

    found: dict[str, NDArray[Any]] = {}
    for name in list(data.keys()) if isinstance(data, Mapping) or hasattr(data, "keys") else []:
        array = np.asarray(data[name])
        is_number = array.dtype.kind in "fiub"
        if array.ndim == 2 and array.shape[1] == 1:
            array = array[:, 0]
        if is_number and array.ndim == 1 and len(array) == count:
            found[str(name)] = array
    return found


def _of_trimesh(source: Any, check: bool) -> Mesh:
    import numpy as np

    mesh = Mesh(source.vertices, source.faces, check=check)
    of_vertices = _numbers(getattr(source, "vertex_attributes", None), mesh.vertex_count)
    of_faces = _numbers(getattr(source, "face_attributes", None), mesh.face_count)
    look: Any = getattr(source, "visual", None)
    kind = getattr(look, "kind", None)
    if kind == "vertex":
        of_vertices["colors"] = np.asarray(look.vertex_colors)
    elif kind == "face":
        of_faces["colors"] = np.asarray(look.face_colors)
    uv = getattr(look, "uv", None) if kind == "texture" else None
    if uv is not None and len(uv) == mesh.vertex_count:
        mesh.corner_data["uvs"] = np.asarray(uv)[mesh.corners]
        mesh = mesh.joined()
    if of_vertices:
        mesh.vertex_data.update(of_vertices)
    if of_faces:
        mesh.face_data.update(of_faces)
    return mesh


def _of_pyvista(source: Any, check: bool) -> Mesh:
    import numpy as np

    padded = np.asarray(source.faces)
    if padded.ndim == 2:
        mesh = Mesh(source.points, padded, check=check)
    else:
        corners, ends = _unpadded(padded)
        mesh = Mesh._of(polygons(source.points, corners, ends, check))
    data = (getattr(source, "point_data", None), getattr(source, "cell_data", None))
    of_vertices, of_faces = _numbers(data[0], mesh.vertex_count), _numbers(data[1], mesh.face_count)
    _take_named(data[0], of_vertices, mesh.vertex_count)
    _take_named(data[1], of_faces, mesh.face_count)
    _set(mesh, of_vertices, of_faces)
    return mesh


def _unpadded(padded: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Corners and ends of faces that are each preceded by their number of corners."""
    import numpy as np

    padded = padded.astype(np.int64)
    if len(padded) and len(padded) % 4 == 0 and (padded[::4] == 3).all():
        corners = padded.reshape(-1, 4)[:, 1:].reshape(-1)
        return corners, np.arange(3, len(corners) + 1, 3)
    sizes: list[int] = []
    at = 0
    while at < len(padded):
        sizes.append(int(padded[at]))
        at += sizes[-1] + 1
    ends = np.cumsum(np.array(sizes, np.int64))
    starts = ends + np.arange(1, len(ends) + 1) - (ends - np.concatenate([[0], ends[:-1]])) - 1
    keep = np.ones(len(padded), bool)
    keep[starts] = False
    return padded[keep], ends


def _take_named(data: Any, found: dict[str, NDArray[Any]], count: int) -> None:
    """Colours and normals, under the names that they usually have."""
    import numpy as np

    if data is None or not hasattr(data, "keys"):
        return
    names = {"colors": "colors", "RGB": "colors", "RGBA": "colors", "normals": "normals", "Normals": "normals"}
    for theirs, ours in names.items():
        if theirs in list(data.keys()) and ours not in found:
            array = np.asarray(data[theirs])
            widths = (3,) if ours == "normals" else (3, 4)
            if array.ndim == 2 and len(array) == count and array.shape[1] in widths:
                found[ours] = array


def _set(mesh: Mesh, of_vertices: dict[str, Any], of_faces: dict[str, Any]) -> None:
    of_faces.pop("normals", None)
    if of_vertices:
        mesh.vertex_data.update(of_vertices)
    if of_faces:
        mesh.face_data.update(of_faces)


def _of_open3d(source: Any, check: bool) -> Mesh:
    import numpy as np

    mesh = Mesh(np.asarray(source.vertices), np.asarray(source.triangles), check=check)
    found: dict[str, Any] = {}
    if source.has_vertex_colors():
        found["colors"] = np.asarray(source.vertex_colors)
    if source.has_vertex_normals():
        found["normals"] = np.asarray(source.vertex_normals)
    if found:
        mesh.vertex_data.update(found)
    if source.has_triangle_uvs():
        mesh.corner_data["uvs"] = np.asarray(source.triangle_uvs)
        mesh = mesh.joined()
    return mesh


def _of_open3d_tensors(source: Any, check: bool) -> Mesh:
    def array(tensor: Any) -> Any:
        return tensor.cpu().numpy()

    mesh = Mesh(array(source.vertex.positions), array(source.triangle.indices), check=check)
    found = {n: array(source.vertex[n]) for n in ("colors", "normals") if n in source.vertex}
    if found:
        mesh.vertex_data.update(found)
    return mesh


def _of_meshio(source: Any, check: bool) -> Mesh:
    import numpy as np

    points = np.asarray(source.points)
    if points.ndim == 2 and points.shape[1] == 2:
        points = np.hstack([points, np.zeros((len(points), 1))])
    flat: list[NDArray[Any]] = []
    sizes: list[int] = []
    blocks: list[int] = []
    for number, block in enumerate(source.cells):
        if block.type in ("triangle", "quad", "polygon"):
            cells = [np.asarray(cell) for cell in block.data]
            flat.extend(cells)
            sizes.extend(len(cell) for cell in cells)
            blocks.append(number)
    if not flat:
        kinds = sorted({block.type for block in source.cells})
        raise ArrayError(f"the mesh has no faces, only {', '.join(kinds) or 'points'}")
    mesh = Mesh._of(polygons(points, np.concatenate(flat), np.cumsum(sizes), check))
    of_vertices = _numbers(source.point_data, mesh.vertex_count)
    _take_named(source.point_data, of_vertices, mesh.vertex_count)
    joined = {
        name: np.concatenate([np.asarray(parts[i]) for i in blocks])
        for name, parts in source.cell_data.items()
    }
    of_faces = _numbers(joined, mesh.face_count)
    _take_named(joined, of_faces, mesh.face_count)
    _set(mesh, of_vertices, of_faces)
    return mesh


def _bytes(colors: NDArray[Any]) -> NDArray[Any]:
    import numpy as np

    found: NDArray[Any] = np.round(255 * np.clip(colors, 0, 1)).astype(np.uint8)
    return found


def _vertex_uvs(mesh: Mesh) -> NDArray[Any] | None:
    """Texture coordinates by vertex, where the corners of every vertex agree."""
    import numpy as np

    if "uvs" not in mesh.corner_data:
        return None
    corners, uvs = mesh.corners, mesh.corner_data["uvs"]
    found = np.zeros((mesh.vertex_count, 2), uvs.dtype)
    found[corners] = uvs
    return found if np.array_equal(found[corners], uvs, equal_nan=True) else None


def _split_uvs(mesh: Mesh) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Vertices split so that each has one texture coordinate: positions, faces, uvs, sources."""
    import numpy as np

    uvs = mesh.corner_data["uvs"]
    pairs = np.column_stack([mesh.corners.astype(np.float64), uvs.astype(np.float64)])
    _, first, inverse = np.unique(pairs, axis=0, return_index=True, return_inverse=True)
    sources = mesh.corners[first]
    faces = np.asarray(inverse).reshape(-1, 3)
    return mesh.vertices[sources], faces, uvs[first], sources


def to_trimesh(mesh: Mesh) -> Any:
    """A ``trimesh.Trimesh``."""
    import numpy as np
    import trimesh

    if not mesh.is_triangular:
        mesh = mesh.triangulated()
    if "uvs" in mesh.corner_data:
        vertices, faces, uvs, sources = _split_uvs(mesh)
        made = trimesh.Trimesh(vertices, faces, process=False)
        made.visual = trimesh.visual.TextureVisuals(uv=uvs)
    else:
        sources = np.arange(mesh.vertex_count)
        made = trimesh.Trimesh(mesh.vertices.copy(), mesh.faces.copy(), process=False)
        if "colors" in mesh.vertex_data:
            made.visual.vertex_colors = _bytes(mesh.vertex_data["colors"])
        elif "colors" in mesh.face_data:
            made.visual.face_colors = _bytes(mesh.face_data["colors"])
    for name, values in mesh.vertex_data.items():
        if values.ndim == 1:
            made.vertex_attributes[name] = values[sources]
    for name, values in mesh.face_data.items():
        if values.ndim == 1 and name not in ("groups", "materials"):
            made.face_attributes[name] = values.copy()
    return made


def to_pyvista(mesh: Mesh) -> Any:
    """A ``pyvista.PolyData``."""
    import numpy as np
    import pyvista

    ends = mesh.face_ends.astype(np.int64)
    starts = np.concatenate([[0], ends[:-1]]).astype(np.int64)
    padded = np.insert(mesh.corners.astype(np.int64), starts, ends - starts)
    made = pyvista.PolyData(mesh.vertices.copy(), faces=padded)
    for name, values in mesh.vertex_data.items():
        made.point_data[name] = _bytes(values) if name == "colors" else values.copy()
    for name, values in mesh.face_data.items():
        made.cell_data[name] = _bytes(values) if name == "colors" else values.copy()
    uvs = _vertex_uvs(mesh)
    if uvs is not None:
        made.active_texture_coordinates = uvs
    return made


def to_open3d(mesh: Mesh) -> Any:
    """An ``open3d.geometry.TriangleMesh``."""
    import numpy as np
    import open3d

    if not mesh.is_triangular:
        mesh = mesh.triangulated()
    vector = open3d.utility.Vector3dVector
    # What is read-only is not taken.
    made = open3d.geometry.TriangleMesh(
        vector(mesh.vertices.copy()), open3d.utility.Vector3iVector(mesh.faces.copy())
    )
    if "colors" in mesh.vertex_data:
        made.vertex_colors = vector(mesh.vertex_data["colors"][:, :3].astype(np.float64))
    if "normals" in mesh.vertex_data:
        made.vertex_normals = vector(mesh.vertex_data["normals"].astype(np.float64))
    if "uvs" in mesh.corner_data:
        uvs = mesh.corner_data["uvs"].astype(np.float64)
        made.triangle_uvs = open3d.utility.Vector2dVector(uvs)
    return made


def to_meshio(mesh: Mesh) -> Any:
    """A ``meshio.Mesh``."""
    import meshio
    import numpy as np

    ends = mesh.face_ends.astype(np.int64)
    sizes = np.diff(ends, prepend=0)
    names = {3: "triangle", 4: "quad"}
    cells, orders = [], []
    for size in np.unique(sizes):
        of_size = np.flatnonzero(sizes == size)
        rows = mesh.corners[(ends[of_size] - size)[:, None] + np.arange(size)]
        cells.append((names.get(int(size), "polygon"), rows))
        orders.append(of_size)
    points = {
        name: values.copy() for name, values in mesh.vertex_data.items()
    }
    of_cells = {
        name: [values[order] for order in orders] for name, values in mesh.face_data.items()
    }
    return meshio.Mesh(mesh.vertices.copy(), cells, point_data=points, cell_data=of_cells)


__all__ = ["CurvmeshError", "as_mesh"]
