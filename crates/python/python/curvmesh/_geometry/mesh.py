"""The class :class:`Mesh`, and its data by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, MutableMapping, Sequence
from typing import TYPE_CHECKING, Any

from .. import _core
from .._call import plain
from .._errors import ArrayError, CurvmeshError
from .arrays import column, content, coordinates
from .methods import Methods

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

__all__ = ["Data", "Mesh"]


class Data(MutableMapping[str, "NDArray[Any]"]):
    """Arrays by name, one row for each vertex, corner or face.

    Reading returns a read-only view without a copy. Setting or deleting a name changes only the data of this
    mesh, and copies all its data once; :meth:`update` sets several arrays with one copy.
    """

    def __init__(self, mesh: Mesh, on: str) -> None:
        self._mesh = mesh
        self._on = on

    def __getitem__(self, name: str) -> NDArray[Any]:
        found: NDArray[Any] | None = _core.data(self._mesh._data, self._on, name)
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
        made = [(name, column(self._on, name, values)) for name, values in items]
        if made:
            self._mesh._data = _core.with_data(self._mesh._data, self._on, made)

    def __repr__(self) -> str:
        return f"{{{', '.join(f'{name!r}: {self[name].shape}' for name in self)}}}"


class Mesh(Methods):
    """A polygon mesh with data of its vertices, corners and faces.

    Positions and faces never change; all functions of this package return new meshes.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        Positions, in model units; of any type of numbers and any strides. They are copied once.
    faces : array_like, shape (m, 3) or (m, k)
        Vertex indices, counter-clockwise seen from outside, counted from 0; of any integer type.
    vertex_data, corner_data, face_data : mapping, optional
        Arrays by name. Vertices have ``"normals"`` (n, 3), ``"colors"`` (n, 3) or (n, 4) and numbers of any type
        under any other name; corners, which are the vertices of the faces one after the other, have
        ``"uvs"`` and ``"normals"``; faces have ``"colors"`` and numbers.
    check : bool, optional
        Whether indices out of range and coordinates that are not finite are refused. If not, such a mesh can be
        examined with :func:`curvmesh.info` and repaired with :func:`curvmesh.repair`.
    join : bool, optional
        Whether vertices at equal positions count as one. This is needed if vertices were split so that each has
        one texture coordinate. By default only open edges that lie on each other count as one edge, as between
        patches that have vertices of their own.

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
    array([1, 2, 3])
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
        join: bool | None = None,
    ) -> None:
        
        self._data = content(vertices, faces, check)
        if join is not None:
            self._data = self._data.with_joins(join)
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
            Some faces are not triangles; use :attr:`corners` and :attr:`face_ends` for these, or
            :meth:`triangulated` to cut them.
        """
        if not self._data.is_triangular:
            raise ArrayError(
                "some faces are no triangles; take mesh.triangulated(), or mesh.corners and "
                "mesh.face_ends"
            )
        return self._data.corners.reshape(-1, 3)

    @property
    def corners(self) -> NDArray[np.int32]:
        """The vertices of all faces, face after face: a read-only view."""
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
        """The materials, to which ``face_data["materials"]`` refers by index.

        Each has ``name``, ``base_color`` (red, green, blue, opacity), ``image`` (an index into
        :attr:`images`, or ``None``), ``metallic``, ``roughness``, ``emissive``, ``double_sided`` and
        ``alpha`` (``"opaque"``, ``"blend"``, or the opacity below which nothing is drawn).
        """
        return _core.materials(self._data)

    @materials.setter
    def materials(self, materials: Sequence[Mapping[str, Any]]) -> None:
        self._data = _core.with_materials(self._data, [dict(material) for material in materials])

    @property
    def images(self) -> list[dict[str, Any]]:
        """The textures: ``name``, ``media_type``, and either ``data``, the bytes of the image file, or ``uri``,
        its path."""
        return _core.images(self._data)

    @images.setter
    def images(self, images: Sequence[Mapping[str, Any]]) -> None:
        self._data = _core.with_images(self._data, [{"name": "", **image} for image in images])

    @property
    def groups(self) -> list[tuple[str, str]]:
        """The groups, to which ``face_data["groups"]`` refers by index: object and name of each."""
        return _core.groups(self._data)

    @groups.setter
    def groups(self, groups: Sequence[tuple[str, str]]) -> None:
        self._data = _core.with_groups(self._data, [(str(one), str(other)) for one, other in groups])

    @property
    def notes(self) -> list[str]:
        """Messages about data that was lost, repaired or skipped when this mesh was made, or that meshes of other
        packages, to which it was converted, have no place for."""
        return self._data.notes

    @property
    def repairs(self) -> dict[str, int]:
        """The repairs that were made for functions that need an oriented manifold, and how many of each.

        Empty for an oriented manifold, and until such a function is called. The mesh itself does not change.

        Examples
        --------
        >>> import warnings
        >>> import curvmesh as cm
        >>> twice = cm.Mesh([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [1, 2, 0]])
        >>> with warnings.catch_warnings():
        ...     warnings.simplefilter("ignore", cm.RepairWarning)
        ...     found = cm.curvature(twice)
        >>> twice.repairs
        {'dropped duplicate triangles': 1}
        """
        return dict(self._data.repairs)

    @property
    def bounds(self) -> NDArray[np.float64]:
        """The corners of the bounding box, shape (2, 3), in model units."""
        import numpy as np

        points = self.vertices
        return np.array([points.min(axis=0), points.max(axis=0)])

    @property
    def joins(self) -> bool | None:
        """Whether vertices at equal positions count as one; ``None`` if only open edges that lie on each other do."""
        return self._data.joins

    def joined(self, join: bool | None = True) -> Mesh:
        """The same mesh, with vertices at equal positions counting as one or not; see :attr:`joins`."""
        return Mesh._of(self._data.with_joins(join))

    def copy(self) -> Mesh:
        """A mesh whose data can be set without changing this one; nothing is copied until then."""
        return Mesh._of(self._data)

    def with_vertices(self, vertices: ArrayLike) -> Mesh:
        """The same faces and data at other positions, shape (n, 3).

        Normals are left out, since they belong to the old positions.
        """
        return Mesh._of(self._data.with_positions(coordinates(vertices)))

    def validate(self, *, threads: int | None = None) -> Mesh:
        """This mesh, if it is an oriented manifold.

        Raises
        ------
        NonManifoldError, OrientationError, DegenerateFaceError, DuplicateFaceError
            It is not; the error has the ids and the name of the repair.

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
        """The triangles used by all computations, with all data: polygons are cut, and if the mesh
        :attr:`joins`, vertices at equal positions are merged."""
        return Mesh._of(self._data.triangulated(plain(threads)))

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

    def __eq__(self, other: object) -> bool:
        """Whether all content is the same to the last bit, except :attr:`notes`."""
        if not isinstance(other, Mesh):
            return NotImplemented
        return self._data is other._data or self._data.equals(other._data)

    __hash__ = object.__hash__

    def __copy__(self) -> Mesh:
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> Mesh:
        # The content never changes, so it can be shared.
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (_core.VERSION, self._data.dump())


def _restored(version: str, content: bytes) -> Mesh:
    """A mesh from its pickle."""
    if version != _core.VERSION:
        message = f"the mesh was pickled by curvmesh {version}; this is {_core.VERSION}"
        raise CurvmeshError(message, cure="exchange meshes between versions as files: mesh.save(path)")
    return Mesh._of(_core.MeshData.load(content))
