"""Smooth patches from face-based curvature."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from .. import _core
from .._call import Progress, calling, plain
from .._options import checked
from .._table import table, text
from .files import as_mesh
from .mesh import Mesh

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from .._options import CoverMethod, Length, Outline, Sections

__all__ = ["Cover", "patch"]


class Cover:
    """A mesh covered by smooth patches within a tolerance; made by :func:`patch`.

    Attributes
    ----------
    mesh : Mesh
        The triangles that are covered.
    """

    def __init__(self, mesh: Mesh, cover: _core.CoverData) -> None:
        self.mesh = mesh
        self._cover = cover
        self._patches: NDArray[Any] | None = None

    def __len__(self) -> int:
        return len(self._cover)

    @property
    def patches(self) -> NDArray[Any]:
        """The patches as a structured array, in the order of selection.

        Fields are ``face`` (the base face), ``faces`` (number of covered faces), ``radius``, ``origin``,
        ``center``, ``frame`` (the directions of k1 and k2 and the normal), ``curvatures`` (the one of larger
        absolute value first, positive where convex), ``arcs`` (lengths along both directions), ``translation``,
        ``error`` (the largest distance from the mesh), ``overhang`` (how far it sticks out beyond the boundary of
        the mesh, which is no error), ``shape`` and ``stop`` (what limits its size). Lengths are in model units.
        """
        import numpy as np

        if self._patches is None:
            columns = {n: np.asarray(c) for n, c in self._cover.columns().items()}
            kinds: Any = [
                (name, array.dtype if array.dtype.kind != "U" else "U16", array.shape[1:])
                for name, array in columns.items()
            ]
            found = np.empty(len(self), kinds)
            for name, array in columns.items():
                found[name] = array
            self._patches = found
        return self._patches

    @property
    def tolerance(self) -> float:
        """The largest allowed distance between patches and mesh, in model units."""
        return self._cover.tolerance

    @property
    def max_error(self) -> float:
        """The largest error of any patch, in model units."""
        return self._cover.max_error

    @property
    def covered_faces(self) -> int:
        """Number of faces covered by patches."""
        return self._cover.covered_faces

    @property
    def patch_of_face(self) -> NDArray[np.int32]:
        """For each triangle the first patch that covers it; -1 for none."""
        return self._cover.patch_of_face()

    def faces_of(self, patch: int) -> NDArray[np.int32]:
        """The faces covered by a patch."""
        return self._cover.faces_of(patch)

    def evaluate(self, u: ArrayLike, phi: ArrayLike, patch: int = 0) -> NDArray[np.float64]:
        """Points of a patch.

        Parameters
        ----------
        u : array_like
            From 0 at the centre to 1 at the rim.
        phi : array_like
            The angle from the direction of the first curvature, in radians. Both are broadcast.
        patch : int
            Index of the patch.

        Returns
        -------
        ndarray, shape (..., 3)
        """
        return self._at(u, phi, patch, False)

    def normals(self, u: ArrayLike, phi: ArrayLike, patch: int = 0) -> NDArray[np.float64]:
        """Unit normals of a patch, as :meth:`evaluate`."""
        return self._at(u, phi, patch, True)

    def _at(self, u: ArrayLike, phi: ArrayLike, patch: int, normals: bool) -> NDArray[np.float64]:
        import numpy as np

        a, b = np.broadcast_arrays(np.asarray(u, np.float64), np.asarray(phi, np.float64))
        found = self._cover.evaluate(patch, a.ravel(), b.ravel(), normals)
        return found.reshape(*a.shape, 3)

    def tessellate(self, tolerance: float | None = None, *, threads: int | None = None) -> Mesh:
        """The patches as triangles, coloured by patch, and the uncovered faces.

        Parameters
        ----------
        tolerance : float, optional
            The largest distance of triangles from a patch, in model units; by default half the tolerance of the
            cover.

        Returns
        -------
        Mesh
            With normals and colours, and the number of the patch in ``face_data["patch"]``.
        """
        return Mesh._of(self._cover.tessellate(plain(threads), tolerance))

    def splats(self) -> Mesh:
        """One point for each patch, with its normal, its colour, and the half axes ``u_x, u_y, u_z`` and
        ``v_x, v_y, v_z`` of an ellipse in ``vertex_data``."""
        return Mesh._of(self._cover.splats())

    def record(self) -> dict[str, Any]:
        """The complete definition of all patches, as plain data."""
        found: dict[str, Any] = json.loads(self._cover.record())
        return found

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (self.mesh, self._cover.dump())

    def _rows(self) -> list[tuple[str, object]]:
        return [
            ("patches", len(self)),
            ("covered faces", self.covered_faces),
            ("faces", len(self.patch_of_face)),
            ("tolerance", self.tolerance),
            ("largest error", self.max_error),
        ]

    def __repr__(self) -> str:
        return text("Cover", self._rows())

    def _repr_html_(self) -> str:
        return table("Cover", self._rows())


def _restored(mesh: Mesh, content: bytes) -> Cover:
    return Cover(mesh, _core.CoverData.load(content, mesh._data))


@checked
def patch(
    mesh: Any,
    *,
    tolerance: Length | None = None,
    relative: bool = False,
    face: int | None = None,
    radius: Length | None = None,
    shape: Outline = "best",
    preset: Sections = "robust",
    cover: CoverMethod = "best",
    overhang: bool = True,
    progress: Progress = None,
    threads: int | None = None,
) -> Cover:
    """Replace a mesh by smooth patches, each as large as the tolerance allows.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`; an oriented manifold.
    tolerance : float or str
        The largest distance between patches and mesh: in model units, or ``"1%"`` of the diagonal.
    relative : bool
        Whether numbers are shares of the diagonal of the bounding box.
    face : int, optional
        Make one patch, at this triangle: with the given radius, or the largest within the tolerance.
    radius : float or str, optional
        The radius of the one patch, instead of a tolerance.
    shape : str
        The outline: ``"circle"`` (equal arcs), ``"ellipse"`` (equal angles), ``"sagitta"`` (equal rise), or
        ``"best"``, for each patch the one of the first two that covers more.
    preset : str
        How curvature is estimated: ``"robust"``, or ``"paper"`` as in Szilvási-Nagy 2010.
    cover : str
        How patches are chosen: ``"greedy"``, ``"sequential"``, or the ``"best"`` of both.
    overhang : bool
        Whether patches may extend beyond the boundary of the mesh.

    Returns
    -------
    Cover

    Examples
    --------
    >>> import curvmesh as cm
    >>> cover = cm.patch(cm.shapes.torus(), tolerance="2%")
    >>> cover.covered_faces, len(cover.patches) < 200
    (1728, True)
    >>> cover.evaluate([0.0, 1.0], 0.0).shape
    (2, 3)
    """
    given = as_mesh(mesh).triangulated(threads=threads)
    with calling("patches", progress, threads) as call:
        made = _core.patch(
            call, given._data, tolerance, relative, face, radius, shape, preset, cover, overhang
        )
    return Cover(given, made)
