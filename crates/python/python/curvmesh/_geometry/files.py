"""Reading and writing, and conversion of mesh-like objects."""

from __future__ import annotations

import os
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from .. import _core
from .._call import calling, plain
from .._errors import ArrayError, OptionError, ReadError
from .._options import checked
from .mesh import Mesh
from .packages import meshio, open3d, pyvista, trimesh, vtk

if TYPE_CHECKING:
    from .._call import Progress
    from .._options import Encoding, External, File, Format, Precision

__all__ = ["as_mesh", "read", "save", "write"]

#: Attributes that identify the meshes of other packages, and the conversion of each.
_KINDS: list[tuple[tuple[str, ...], Callable[[Any, bool], Mesh]]] = [
    (("geometry", "graph"), trimesh.of_scene),
    (("n_blocks", "keys"), pyvista.of_blocks),
    (("points", "extract_surface"), pyvista.of_pyvista),
    (("IsA", "GetClassName", "GetMTime"), vtk.of_vtk),
    (("points", "cells"), meshio.of_meshio),
    (("points", "faces"), pyvista.of_pyvista),
    (("vertices", "faces"), trimesh.of_trimesh),
    (("vertices", "triangles"), open3d.of_open3d),
    (("vertex", "triangle"), open3d.of_tensors),
]


@checked
def as_mesh(source: Any, *, check: bool = True) -> Mesh:
    """The mesh of any mesh-like object.

    Parameters
    ----------
    source : mesh-like
        A :class:`Mesh`; a :class:`Scene`; a result with a ``mesh``, such as the result of :func:`simplify`; a
        pair ``(vertices, faces)``; a path or an open file; a mesh or scene of trimesh; a ``PolyData``,
        ``MultiBlock`` or other data set of PyVista or VTK; a mesh of Open3D (legacy or tensor) or meshio.
    check : bool
        As for :class:`Mesh`.

    Returns
    -------
    Mesh
        With colours, normals, texture coordinates, materials, textures, groups and named numbers. A vector
        ``v`` becomes the columns ``v_x``, ``v_y`` and ``v_z``. :attr:`Mesh.notes` lists what was left out.

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.as_mesh(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]))
    Mesh(3 vertices, 1 face)
    """
    if isinstance(source, Mesh):
        return source
    if isinstance(source, (str, os.PathLike)):
        return read(source)
    if isinstance(source, (tuple, list)) and len(source) == 2:
        return Mesh(source[0], source[1], check=check)
    result = getattr(source, "mesh", None)
    if isinstance(result, Mesh):
        return result
    scene = getattr(source, "_data", None)
    if isinstance(scene, _core.SceneData):
        return Mesh._of(_core.scene_mesh(plain(), scene, None))
    for attributes, convert in _KINDS:
        if all(hasattr(source, name) for name in attributes):
            return convert(source, check)
    if hasattr(source, "read"):
        return read(source)
    raise ArrayError(
        f"a {type(source).__name__} is no mesh; give a curvmesh.Mesh, (vertices, faces), a path, or a "
        "mesh of trimesh, PyVista, VTK, Open3D or meshio"
    )


@checked
def read(
    source: File | bytes,
    *,
    format: Format | None = None,
    external: External = "folder",
    max_memory: int | None = None,
    allow_empty: bool = False,
    join: bool | None = None,
    progress: Progress = None,
    threads: int | None = None,
) -> Mesh:
    """Read a mesh: OBJ, PLY, STL, OFF, glTF or GLB.

    Untrusted files are safe to read: other files are read only from the folder of the file and below, and
    memory is limited in proportion to the size of the file.

    Parameters
    ----------
    source : path, bytes or binary file
        The file, its content, or an open file.
    format : str, optional
        ``"obj"``, ``"ply"``, ``"stl"``, ``"off"``, ``"gltf"`` or ``"glb"``; detected from the content by
        default.
    external : str
        Which of the files that it refers to are read: ``"none"``, those in its ``"folder"`` and below, or
        ``"any"``.
    max_memory : int, optional
        The most bytes that reading may allocate; by default 64 MiB and 60 times the size of the file.
    allow_empty : bool
        Read a file without any vertex as an empty mesh; otherwise this is an error.
    join : bool, optional
        Whether vertices at equal positions are one vertex of the surface. By default this holds for formats
        that split vertices: glTF, and files with texture coordinates or normals per corner. In other files only
        open edges that lie on each other are one edge.

    Returns
    -------
    Mesh
        Nothing is repaired; :func:`curvmesh.info` counts defects, :func:`curvmesh.repair` repairs them.

    Raises
    ------
    ReadError
        The file cannot be read; the error has the place and what was expected. A missing file is a
        ``FileNotFoundError`` too.

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.read(b"OFF\\n3 1 0\\n0 0 0\\n1 0 0\\n0 1 0\\n3 0 1 2\\n")
    Mesh(3 vertices, 1 face)
    """
    options: dict[str, Any] = {
        "format": format,
        "external": external,
        "max_memory": max_memory,
        "allow_empty": allow_empty,
        "join": join,
    }
    with calling("reading", progress, threads) as call:
        if not isinstance(source, (str, os.PathLike)):
            return Mesh._of(_core.read(call, None, file_content(source), **options))
        return Mesh._of(_core.read(call, os.fspath(source), None, **options))


def file_content(source: Any) -> bytes:
    """The content of a file that is open or given as bytes."""
    try:
        content = source.read() if hasattr(source, "read") else source
    except UnicodeDecodeError:
        content = ""
    if isinstance(content, str):
        raise ReadError("the file is open as text", cure='open(path, "rb")')
    if not isinstance(content, (bytes, bytearray, memoryview)):
        raise OptionError(f"a {type(source).__name__} cannot be read; give a path, bytes or an open file")
    return bytes(content)


@checked
def write(
    path: File,
    mesh: Any,
    *,
    format: Format | None = None,
    encoding: Encoding = "usual",
    precision: Precision = "exact",
    overwrite_companions: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> dict[str, Any]:
    """Write a mesh with all its data: the file is replaced as a whole or not at all.

    Parameters
    ----------
    path : path or binary file
        The file; its extension is the format unless `format` is given. An open file needs `format`.
    mesh : Mesh or mesh-like
        See :func:`curvmesh.as_mesh`.
    encoding : str
        ``"usual"``, ``"text"``, ``"little-endian"`` or ``"big-endian"``.
    precision : str
        Width of the numbers in PLY: ``"single"``, ``"double"``, or ``"exact"`` for 32 bits where they
        suffice.
    overwrite_companions : bool
        Whether the material library and textures beside an OBJ file may replace files that curvmesh did
        not write.

    Returns
    -------
    dict
        ``rounding``, the largest change of a coordinate; ``dropped``, content that the format cannot store;
        ``kept``, files beside it that were left unchanged.

    Raises
    ------
    WriteError
        The file cannot be written. A missing folder is a ``FileNotFoundError`` too.
    """
    data = as_mesh(mesh)._data
    options: dict[str, Any] = {
        "format": format,
        "encoding": encoding,
        "precision": precision,
        "overwrite_companions": overwrite_companions,
    }
    with calling("writing", progress, threads) as call:
        if isinstance(path, (str, os.PathLike)):
            return _core.write(call, os.fspath(path), data, **options)
        return _write_to(path, lambda inside: _core.write(call, inside, data, **options), format)


def _write_to(file: Any, write_file: Callable[[str], dict[str, Any]], format: str | None) -> dict[str, Any]:
    """Writes to an open file via a temporary file."""
    import tempfile
    from pathlib import Path

    if not hasattr(file, "write"):
        raise OptionError(f"a {type(file).__name__} cannot be written to; give a path or an open file")
    if format is None:
        raise OptionError("an open file has no extension; say format=")
    with tempfile.TemporaryDirectory(prefix="curvmesh-") as folder:
        path = Path(folder) / f"mesh.{format}"
        told = write_file(str(path))
        deliver(file, path.read_bytes())
        beside = sorted(other.name for other in Path(folder).iterdir() if other != path)
    told["dropped"] += [f"{name}: an open file has no place beside it" for name in beside]
    return told


#: Suffixes of files that show something.
_SHOWN = (".png", ".jpg", ".jpeg", ".gif", ".webp", ".bmp", ".tif", ".tiff", ".svg", ".pdf", ".eps", ".html", ".htm")


def deliver(path: File, content: bytes, *suffixes: str) -> None:
    """Writes content of a format with one of some suffixes to a path or to an open binary file.

    Raises
    ------
    OptionError
        The path has the suffix of another format, or the file is open as text.
    """
    if not isinstance(path, (str, os.PathLike)):
        if not hasattr(path, "write"):
            raise OptionError(f"a {type(path).__name__} cannot be written to; give a path or an open file")
        try:
            path.write(content)
        except TypeError:
            raise OptionError('the file is open as text; open(path, "wb")') from None
        return
    suffix = os.path.splitext(os.fspath(path))[1].lower()
    if suffixes and suffix in _SHOWN and suffix not in suffixes:
        raise OptionError(f"{os.fspath(path)} ends in {suffix}, but the file is written as {suffixes[0]}")
    with open(path, "wb") as file:
        file.write(content)


def save(mesh: Any, path: File, **options: Any) -> dict[str, Any]:
    """Write a mesh; :func:`write` with the mesh first, for the method of a mesh."""
    return write(path, mesh, **options)
