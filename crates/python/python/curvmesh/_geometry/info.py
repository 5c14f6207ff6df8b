"""Counts and defects, repair, subdivision."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .. import _core
from .._call import Progress, calling
from .._options import checked, whole
from .._table import table, text
from .files import as_mesh
from .mesh import Mesh

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .._options import Length

__all__ = ["Info", "Repaired", "info", "repair", "subdivide"]

#: Counts of repairable defects, and the repair for each.
_REPAIRS = {
    "non_manifold_edges": "cut_non_manifold",
    "non_manifold_vertices": "cut_non_manifold",
    "inconsistent_edges": "reorient",
    "inside_out": "reorient",
    "duplicate_faces": "drop_duplicates",
    "repeated_vertex_faces": "drop_degenerate",
    "unreferenced_vertices": "drop_unreferenced",
    "zero_area_faces": "",
    "sliver_faces": "",
    "non_finite_vertices": "drop_not_finite",
}


@dataclass(frozen=True, repr=False)
class Info(Mapping[str, Any]):
    """Counts, topology, defects and sizes of a mesh, as attributes and by name.

    Attributes
    ----------
    vertices, faces, triangles, quadrilaterals, larger_polygons, edges : int
        Counts; edges are counted after polygons are cut into triangles.
    boundary_edges, boundary_loops : int
        Edges with one face, and the closed curves that they form.
    components, edge_components : int
        Parts connected by common vertices, and by common edges.
    non_manifold_edges, non_manifold_vertices, inconsistent_edges, duplicate_faces, degenerate_faces : int
        Defects; degenerate faces repeat a vertex or have no area.
    repeated_vertex_faces, zero_area_faces, sliver_faces, unreferenced_vertices, non_finite_vertices : int
        More defects.
    inside_out : int or None
        Components that are inside out, after joining vertices at equal positions; ``None`` if unknown.
    euler_characteristic : int
        Vertices minus edges plus faces.
    closed, manifold, oriented : bool
        Every edge has two faces; every vertex has a disc or half-disc around it; adjacent faces agree.
    bbox_min, bbox_max : list of float or None
        Corners of the bounding box, in model units; ``None`` without a finite vertex in use.
    area, volume : float or None
        In model units; the volume is ``None`` unless the mesh is closed and oriented.
    joined_vertices : int
        Vertices at equal positions that count as another one, see :attr:`Mesh.joins`.
    """

    vertices: int
    faces: int
    triangles: int
    quadrilaterals: int
    larger_polygons: int
    edges: int
    boundary_edges: int
    boundary_loops: int
    components: int
    edge_components: int
    non_manifold_edges: int
    non_manifold_vertices: int
    inconsistent_edges: int
    duplicate_faces: int
    degenerate_faces: int
    repeated_vertex_faces: int
    zero_area_faces: int
    sliver_faces: int
    unreferenced_vertices: int
    non_finite_vertices: int
    inside_out: int | None
    euler_characteristic: int
    closed: bool
    manifold: bool
    oriented: bool
    bbox_min: list[float] | None
    bbox_max: list[float] | None
    area: float | None
    volume: float | None
    joined_vertices: int

    def __getitem__(self, name: str) -> Any:
        return vars(self)[name]

    def __iter__(self) -> Iterator[str]:
        return iter(vars(self))

    def __len__(self) -> int:
        return len(vars(self))

    @property
    def defects(self) -> dict[str, int]:
        """The number of each kind of defect; empty for a valid mesh."""
        return {name: count for name in _REPAIRS if (count := self[name])}

    @property
    def repairs(self) -> list[str]:
        """The arguments of :func:`repair` for these defects."""
        return list(dict.fromkeys(_REPAIRS[name] for name in self.defects if _REPAIRS[name]))

    def __repr__(self) -> str:
        return text("Info", self.items())

    def _repr_html_(self) -> str:
        return table("Info", self.items())


@checked
def info(mesh: Any, *, threads: int | None = None) -> Info:
    """Count the elements and defects of a mesh, and measure it. Broken meshes are allowed.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`.

    Returns
    -------
    Info
        The same values as ``curvmesh info``. Vertices joined by :attr:`Mesh.joins` are counted once.

    Examples
    --------
    >>> import curvmesh as cm
    >>> found = cm.info(cm.shapes.torus())
    >>> found.euler_characteristic, found.closed, found.defects
    (0, True, {})
    """
    given = as_mesh(mesh, check=False)
    with calling("info", None, threads) as call:
        return Info(**_core.info(call, given._data))


@dataclass(frozen=True, repr=False)
class Repaired:
    """An oriented manifold of triangles, and a report of the repairs.

    Attributes
    ----------
    mesh : Mesh
        The result, with the data of the original.
    counts : dict
        Number of repairs of each kind.
    unchanged : bool
        Whether no repair was needed.
    vertex_source, face_source : ndarray of int32
        For each vertex and face of the result, a vertex or face of the original from which it comes.
    """

    mesh: Mesh
    counts: dict[str, int]
    unchanged: bool
    vertex_source: NDArray[np.int32]
    face_source: NDArray[np.int32]

    def _rows(self) -> list[tuple[str, object]]:
        rows: list[tuple[str, object]] = [
            ("vertices", self.mesh.vertex_count),
            ("faces", self.mesh.face_count),
            ("unchanged", self.unchanged),
        ]
        done = [(name.replace("_", " "), count) for name, count in self.counts.items() if count]
        return rows + done

    def __repr__(self) -> str:
        return text("Repaired", self._rows())

    def _repr_html_(self) -> str:
        return table("Repaired", self._rows())


@checked
def repair(
    mesh: Any,
    *,
    weld: Length | None = None,
    relative: bool = False,
    drop_out_of_range: bool = False,
    drop_not_finite: bool = False,
    drop_degenerate: bool = False,
    drop_duplicates: bool = False,
    reorient: bool = False,
    cut_non_manifold: bool = False,
    drop_unreferenced: bool = False,
    fill_holes: int | str | None = None,
    threads: int | None = None,
) -> Repaired:
    """Make an oriented manifold of triangles from any mesh.

    All repairs are made unless some are named; then only these are made. `weld` determines how vertices are
    merged.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`; indices may be out of range, and coordinates infinite or NaN.
    weld : str or float, optional
        Merge vertices at equal positions (``"exact"``), only where open edges lie on each other (``"seams"``),
        within a distance (a number, or ``"0.01%"``), or not (``"none"``).
    relative : bool
        Whether a number for `weld` is a share of the diagonal of the bounding box.
    drop_out_of_range, drop_degenerate, drop_duplicates : bool
        Drop faces that refer to vertices that do not exist, that use a vertex twice, or that have the vertices
        of an earlier face.
    drop_not_finite : bool
        Drop vertices at infinite or undefined positions, and the faces at them.
    reorient : bool
        Reverse faces until neighbours agree and components face outward.
    cut_non_manifold : bool
        Cut the surface apart along edges of more than two faces and at pinched vertices.
    drop_unreferenced : bool
        Drop vertices that no face uses.
    fill_holes : int or "all", optional
        Then fill holes of at most this number of edges.

    Returns
    -------
    Repaired

    Examples
    --------
    >>> import curvmesh as cm
    >>> fixed = cm.repair(([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2], [2, 1, 0], [0, 1, 9]]))
    >>> fixed.mesh.face_count, fixed.counts["dropped_out_of_range"]
    (1, 1)
    """
    named = {
        "drop_out_of_range": drop_out_of_range,
        "drop_not_finite": drop_not_finite,
        "drop_degenerate": drop_degenerate,
        "drop_duplicates": drop_duplicates,
        "reorient": reorient,
        "cut_non_manifold": cut_non_manifold,
        "drop_unreferenced": drop_unreferenced,
    }
    if not any(named.values()):
        named = dict.fromkeys(named, True)
        weld = "exact" if weld is None else weld
    if fill_holes is not None and not isinstance(fill_holes, str):
        fill_holes = whole("fill_holes", fill_holes)
    given = as_mesh(mesh, check=False)
    repairs = {"weld": weld, "relative": relative, **named}
    with calling("repairing", None, threads) as call:
        made, told = _core.repair(call, given._data, repairs, fill_holes)
    unchanged = told.pop("unchanged")
    sources = {name: told.pop(name) for name in ("vertex_source", "face_source")}
    return Repaired(mesh=Mesh._of(made), counts=told, unchanged=unchanged, **sources)


@checked
def subdivide(
    mesh: Any,
    *,
    steps: int = 1,
    tension: float = 1 / 16,
    eight_point: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> Mesh:
    """Subdivide a mesh smoothly by the butterfly scheme. Its vertices do not move.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`; an oriented manifold.
    steps : int
        Number of steps; each cuts every face into four.
    tension : float
        The tension of Dyn, Levin, Gregory 1990, from 0 (flat) to 0.25.
    eight_point : bool
        Use the eight-point rule also at irregular vertices, instead of the rule of Zorin, Schröder, Sweldens
        1996.

    Returns
    -------
    Mesh
        The vertices of the input come first. Texture coordinates and other data are interpolated; normals are
        left out, with a note. Where the scheme would make slivers or turn faces over, new vertices are at the middle of their
        edges, and a warning says how many.

    Examples
    --------
    >>> import curvmesh as cm
    >>> fine = cm.subdivide(cm.shapes.octahedron(), steps=2)
    >>> fine.face_count
    128
    """
    given = as_mesh(mesh)
    with calling("subdividing", progress, threads) as call:
        fine, straight_edges = _core.subdivide(call, given._data, steps, tension, eight_point)
    if straight_edges:
        warnings.warn(
            f"{straight_edges} new vertices are at the middle of their edges, where the curve of the scheme would make "
            "slivers or turn faces over; a lower tension curves less",
            stacklevel=3,
        )
    data = {"vertices": given.vertex_data, "corners": given.corner_data}
    normals = [on for on, columns in data.items() if "normals" in columns]
    notes = [f"normals of {on} were left out: subdivision does not carry them over" for on in normals]
    return Mesh._of(fine.with_notes([*fine.notes, *notes]))
