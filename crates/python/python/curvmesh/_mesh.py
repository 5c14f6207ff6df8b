"""The mesh, and its data by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping
from typing import TYPE_CHECKING, Any

from . import _core
from ._call import calling, plain
from ._errors import ArrayError

if TYPE_CHECKING:
    import os

    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from ._call import Progress

__all__ = ["Data", "Mesh", "read", "write"]


class Data(MutableMapping[str, "NDArray[Any]"]):
    """Arrays by name, one row for each vertex, corner or face.

    Reading gives a read-only view without a copy. Setting or deleting a name changes the mesh that this
    belongs to, and no other one; each time the data of the mesh is copied once, so give several arrays
    to :meth:`update`.
    """

    def __init__(self, mesh: Mesh, on: str) -> None:
        self._mesh = mesh
        self._on = on

    def __getitem__(self, name: str) -> NDArray[Any]:
        found = _core.data(self._mesh._data, self._on, name)
        if found is None:
            raise KeyError(name)
        return found

    def __setitem__(self, name: str, values: ArrayLike) -> None:
        self._put([(name, values)])

    def __delitem__(self, name: str) -> None:
        if name not in self:
            raise KeyError(name)
        self._mesh._data = _core.with_data(self._mesh._data, self._on, [(name, None)])

    def __iter__(self) -> Iterator[str]:
        return iter(_core.data_names(self._mesh._data, self._on))

    def __len__(self) -> int:
        return len(_core.data_names(self._mesh._data, self._on))

    def update(self, *others: Any, **named: Any) -> None:
        """Sets several arrays at once."""
        self._put(dict(*others, **named).items())

    def _put(self, items: Any) -> None:
        made = [(name, _column(self._on, name, values)) for name, values in items]
        self._mesh._data = _core.with_data(self._mesh._data, self._on, made)

    def __repr__(self) -> str:
        return f"{{{', '.join(f'{name!r}: {self[name].shape}' for name in self)}}}"


def _column(on: str, name: str, values: ArrayLike) -> NDArray[Any]:
    """The array in the type that the mesh keeps it in."""
    import numpy as np

    array = np.asarray(values)
    if name == "colors" and on in ("vertex", "face"):
        if array.dtype.kind in "ui":
            array = array.astype(np.float32) / np.float32(255)
        if array.ndim == 2 and array.shape[1] == 3:
            opaque = np.ones((len(array), 1), np.float32)
            array = np.hstack([array.astype(np.float32), opaque])
    if name in ("colors", "normals", "uvs"):
        kind: Any = np.float32
    elif on == "face" and name in ("groups", "materials"):
        kind = np.int64
    else:
        kind = np.float64
    if array.dtype.kind not in "fiub":
        raise ArrayError(f"{name!r} is of type {array.dtype}; it must be of numbers")
    if kind is np.float64 and array.ndim != 1:
        raise ArrayError(
            f"{name!r} has the shape {array.shape}; named numbers are one for each {on}: "
            "give each column a name of its own"
        )
    if kind is np.float32 and array.ndim != 2:
        raise ArrayError(f"{name!r} has the shape {array.shape}; it must have rows and columns")
    return np.require(array, kind, "A")


class Mesh:
    """A polygon mesh with whatever belongs to its vertices, corners and faces.

    Positions and faces never change; all functions of this package give new meshes.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        Positions, in model units; of any type of numbers and any strides. They are copied once.
    faces : array_like, shape (m, 3) or (m, k)
        Vertex indices, counter-clockwise seen from outside, counted from 0; of any integer type.
    vertex_data, corner_data, face_data : mapping, optional
        Arrays by name. Vertices have ``"normals"`` (n, 3), ``"colors"`` (n, 3) or (n, 4) and numbers
        under any other name; corners, which are the vertices of the faces one after the other, have
        ``"uvs"`` and ``"normals"``; faces have ``"colors"`` and numbers.
    check : bool, optional
        Whether indices out of range and coordinates that are not finite are refused. Without, such a
        mesh can be examined with :func:`curvmesh.info` and mended with :func:`curvmesh.repair`.
    join : bool, optional
        Whether vertices at equal positions count as one, as is needed where an array of vertices was
        split so that each has one texture coordinate.

    Raises
    ------
    ArrayError
        Arrays have the wrong shape or type.
    OutOfRangeError, NotFiniteError
        Indices are out of range, or coordinates are not finite; the error has the ids.

    Examples
    --------
    >>> import curvmesh as cm
    >>> mesh = cm.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]])
    >>> mesh
    Mesh(3 vertices, 1 face)
    >>> mesh.faces
    array([[0, 1, 2]], dtype=int32)
    >>> mesh.vertex_data["quality"] = [1, 2, 3]
    >>> mesh.vertex_data["quality"]
    array([1., 2., 3.])
    """

    __slots__ = ("_data", "__weakref__")
    _data: _core.MeshData

    def __init__(
        self,
        vertices: ArrayLike,
        faces: ArrayLike,
        *,
        vertex_data: Mapping[str, ArrayLike] | None = None,
        corner_data: Mapping[str, ArrayLike] | None = None,
        face_data: Mapping[str, ArrayLike] | None = None,
        check: bool = True,
        join: bool = False,
    ) -> None:
        from ._convert import content

        self._data = content(vertices, faces, check)
        if join:
            self._data = self._data.with_joins(True)
        given = ((self.vertex_data, vertex_data), (self.corner_data, corner_data))
        for data, values in (*given, (self.face_data, face_data)):
            if values:
                data.update(values)

    @classmethod
    def _of(cls, data: _core.MeshData) -> Mesh:
        mesh = cls.__new__(cls)
        mesh._data = data
        return mesh

    @property
    def vertices(self) -> NDArray[np.float64]:
        """Positions, shape (n, 3), in model units: a read-only view, never a copy."""
        return self._data.vertices

    @property
    def faces(self) -> NDArray[np.int32]:
        """Vertex indices, shape (m, 3): a read-only view, never a copy.

        Raises
        ------
        ArrayError
            Some faces are no triangles; :attr:`corners` and :attr:`face_ends` have those, and
            :meth:`triangulated` cuts them.
        """
        if not self._data.is_triangular:
            raise ArrayError(
                "some faces are no triangles; take mesh.triangulated(), or mesh.corners and "
                "mesh.face_ends"
            )
        return self._data.corners.reshape(-1, 3)

    @property
    def corners(self) -> NDArray[np.int32]:
        """The vertices of all faces, one face after the other: a read-only view."""
        return self._data.corners

    @property
    def face_ends(self) -> NDArray[np.int32]:
        """For each face one past its last corner: a read-only view."""
        return self._data.face_ends

    @property
    def vertex_count(self) -> int:
        """The number of vertices."""
        return self._data.vertex_count

    @property
    def face_count(self) -> int:
        """The number of faces."""
        return self._data.face_count

    @property
    def is_triangular(self) -> bool:
        """Whether every face is a triangle."""
        return self._data.is_triangular

    @property
    def vertex_data(self) -> Data:
        """Data of vertices by name: ``"normals"``, ``"colors"``, and numbers under other names."""
        return Data(self, "vertex")

    @property
    def corner_data(self) -> Data:
        """Data of corners by name: ``"uvs"`` with the origin at the lower left, ``"normals"``."""
        return Data(self, "corner")

    @property
    def face_data(self) -> Data:
        """Data of faces by name: ``"colors"``, ``"groups"``, ``"materials"``, and numbers."""
        return Data(self, "face")

    @property
    def materials(self) -> list[dict[str, Any]]:
        """The materials, which ``face_data["materials"]`` counts from 0."""
        return self._data.materials()

    @property
    def images(self) -> list[dict[str, Any]]:
        """The pictures of the materials: ``data`` are the bytes of an encoded image, ``uri`` its file."""
        return self._data.images()

    @property
    def groups(self) -> list[tuple[str, str]]:
        """The groups, which ``face_data["groups"]`` counts from 0, as object and name."""
        return self._data.groups()

    @property
    def notes(self) -> list[str]:
        """What the reader of the file passed over, for people."""
        return self._data.notes

    @property
    def bounds(self) -> NDArray[np.float64]:
        """The corners of the bounding box, shape (2, 3), in model units."""
        import numpy as np

        points = self.vertices
        return np.array([points.min(axis=0), points.max(axis=0)])

    @property
    def joins(self) -> bool:
        """Whether vertices at equal positions count as one."""
        return self._data.joins

    def joined(self, join: bool = True) -> Mesh:
        """The same mesh, with vertices at equal positions counting as one or not."""
        return Mesh._of(self._data.with_joins(join))

    def copy(self) -> Mesh:
        """A mesh whose data can be set without changing this one; nothing is copied until then."""
        return Mesh._of(self._data)

    def with_vertices(self, vertices: ArrayLike) -> Mesh:
        """The same faces and data at other positions, shape (n, 3).

        Normals are left out, since they were those of the old positions.
        """
        from ._convert import content_like

        return content_like(self, vertices)

    def validate(self, *, threads: int | None = None) -> Mesh:
        """This mesh, if it is an oriented manifold.

        Raises
        ------
        NonManifoldError, OrientationError, DegenerateFaceError, DuplicateFaceError
            It is not; the error has the ids and the repair that would help.

        Examples
        --------
        >>> import curvmesh as cm
        >>> fins = cm.Mesh([[0, 0, 0], [0, 0, 1], [1, 0, 0], [0, 1, 0], [-1, 0, 0]],
        ...                [[0, 1, 2], [1, 0, 3], [0, 1, 4]])
        >>> try:
        ...     fins.validate()
        ... except cm.NonManifoldError as error:
        ...     print(error.edges, error.repair)
        [(0, 1)] cut_non_manifold
        """
        self._data.validate(plain(threads))
        return self

    def triangulated(self, *, threads: int | None = None) -> Mesh:
        """The triangles that everything is computed on, with all data: polygons are cut, and where
        the mesh :attr:`joins`, vertices at equal positions are one."""
        return Mesh._of(self._data.triangulated(plain(threads)))

    def to_trimesh(self) -> Any:
        """A ``trimesh.Trimesh``, with colours, texture coordinates and named numbers."""
        from ._convert import to_trimesh

        return to_trimesh(self)

    def to_pyvista(self) -> Any:
        """A ``pyvista.PolyData``, with all data."""
        from ._convert import to_pyvista

        return to_pyvista(self)

    def to_open3d(self) -> Any:
        """An ``open3d.geometry.TriangleMesh``, with normals, colours and texture coordinates."""
        from ._convert import to_open3d

        return to_open3d(self)

    def to_meshio(self) -> Any:
        """A ``meshio.Mesh``, with all data of vertices and faces."""
        from ._convert import to_meshio

        return to_meshio(self)

    def __repr__(self) -> str:
        def some(count: int, one: str, more: str) -> str:
            return f"{count} {one if count == 1 else more}"

        parts = [
            some(self.vertex_count, "vertex", "vertices"),
            some(self.face_count, "face", "faces"),
        ]
        names = [*self.vertex_data, *self.corner_data, *self.face_data]
        if names:
            parts.append("with " + ", ".join(dict.fromkeys(names)))
        return f"Mesh({', '.join(parts)})"

    def _repr_html_(self) -> str:
        from ._show import card

        return card(self)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Mesh):
            return NotImplemented
        import numpy as np

        return (
            np.array_equal(self.vertices, other.vertices)
            and np.array_equal(self.corners, other.corners)
            and np.array_equal(self.face_ends, other.face_ends)
        )

    __hash__ = object.__hash__

    def __reduce__(self) -> tuple[Any, ...]:
        data = [dict(d) for d in (self.vertex_data, self.corner_data, self.face_data)]
        for unkept in ("groups", "materials"):
            data[2].pop(unkept, None)
        arrays = (self.vertices, self.corners, self.face_ends)
        return _restored, (*arrays, *data, self.joins)


def _restored(
    vertices: Any, corners: Any, ends: Any, of_vertices: Any, of_corners: Any, of_faces: Any, join: bool
) -> Mesh:
    from ._convert import polygons

    mesh = Mesh._of(polygons(vertices, corners, ends, False).with_joins(join))
    for data, values in (
        (mesh.vertex_data, of_vertices),
        (mesh.corner_data, of_corners),
        (mesh.face_data, of_faces),
    ):
        if values:
            data.update(values)
    return mesh


def read(
    source: str | os.PathLike[str] | bytes,
    *,
    format: str | None = None,
    external: str = "folder",
    max_memory: int | None = None,
    allow_empty: bool = False,
    join: bool | None = None,
    progress: Progress = None,
    threads: int | None = None,
) -> Mesh:
    """Read a mesh: OBJ, PLY, STL, OFF, glTF or GLB.

    Files of strangers are safe to read: no other files are read than those below the folder of the
    file, and no more memory is taken than in proportion to its size.

    Parameters
    ----------
    source : path or bytes
        The file, or its content.
    format : str, optional
        ``"obj"``, ``"ply"``, ``"stl"``, ``"off"``, ``"gltf"`` or ``"glb"``; found out from the content
        otherwise.
    external : str
        Which files that it names are read with it: ``"none"``, those in its ``"folder"`` and below, or
        ``"any"``.
    max_memory : int, optional
        The most bytes that reading may take; 64 MiB and 60 times the size of the file otherwise.
    allow_empty : bool
        Take a file without any vertex for an empty mesh, not for an error.
    join : bool, optional
        Whether vertices at equal positions count as one. By default that is so where the format splits
        them, as glTF and files with texture coordinates or normals of corners do.

    Returns
    -------
    Mesh
        Nothing is repaired; :func:`curvmesh.info` counts defects, :func:`curvmesh.repair` mends them.

    Raises
    ------
    ReadError
        The file cannot be read; the error has the place and what was expected.

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.read(b"OFF\\n3 1 0\\n0 0 0\\n1 0 0\\n0 1 0\\n3 0 1 2\\n")
    Mesh(3 vertices, 1 face)
    """
    import os

    options: dict[str, Any] = {
        "format": format,
        "external": external,
        "max_memory": max_memory,
        "allow_empty": allow_empty,
        "join": join,
    }
    with calling("reading", progress, threads) as call:
        if isinstance(source, (bytes, bytearray, memoryview)):
            return Mesh._of(_core.read(call, None, bytes(source), **options))
        return Mesh._of(_core.read(call, os.fspath(source), None, **options))


def write(
    path: str | os.PathLike[str],
    mesh: Any,
    *,
    format: str | None = None,
    encoding: str = "usual",
    precision: str = "exact",
    overwrite_companions: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> dict[str, Any]:
    """Write a mesh with all its data: the file is replaced whole or not at all.

    Parameters
    ----------
    path : path
        The file; its extension is the format, unless `format` says otherwise.
    mesh : Mesh or mesh-like
        See :func:`curvmesh.as_mesh`.
    encoding : str
        ``"usual"``, ``"text"``, ``"little-endian"`` or ``"big-endian"``.
    precision : str
        Width of the numbers in PLY: ``"single"``, ``"double"``, or ``"exact"`` for 32 bits where they
        suffice.
    overwrite_companions : bool
        Whether the material library and pictures beside an OBJ file may replace files of others.

    Returns
    -------
    dict
        ``rounding``, by how much coordinates were rounded; ``dropped``, what the format has no place
        for; ``kept``, files beside it that stay.

    Raises
    ------
    WriteError
        The file cannot be written.
    """
    import os

    from ._convert import as_mesh

    with calling("writing", progress, threads) as call:
        return _core.write(
            call,
            os.fspath(path),
            as_mesh(mesh)._data,
            format=format,
            encoding=encoding,
            precision=precision,
            overwrite_companions=overwrite_companions,
        )
