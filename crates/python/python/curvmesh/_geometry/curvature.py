"""Curvature of vertices and faces."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from .. import _core
from .._call import Progress, calling, plain
from .._options import checked
from .._table import table, text
from .files import as_mesh
from .mesh import Mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._options import Area, Estimator, Length, On, Sections

__all__ = ["Curvature", "curvature"]


class Curvature:
    """Curvature of every vertex, or with ``estimator="face"`` of every face.

    Curvatures are positive where the surface is convex seen from outside. Values are pointwise, except those
    whose names begin with ``integral_``. Where curvature is unknown, as at vertices without a face, values
    are NaN.

    Attributes
    ----------
    mesh : Mesh
        The mesh that the values belong to: with ``"face"``, the triangles that polygons are cut into.
    estimator : str
        ``"auto"``, ``"vertex"``, ``"face"``, ``"fit"``, ``"ball"`` or ``"corrected"``.
    on : str
        ``"vertex"`` or ``"face"``.
    totals : dict
        Integrals over the mesh: ``gaussian``, ``abs_gaussian``, ``mean``, ``abs_mean``, the costs
        ``f1``, ``f2`` and ``f3`` of Dyn, Hormann, Kim, Levin 2001, and ``willmore``; with ``"auto"`` and
        ``"vertex"`` they are the exact sums of the formulas of the papers, and there are also ``extrinsic`` (the total absolute extrinsic curvature of Alboul and van Damme), the norms
        ``norm_l1`` and ``norm_l2_squared`` of Kim, Kim, Levin 2002, and counts.
    radius : float or None
        The radius of discs or balls, in model units.
    noise : float or None
        The standard deviation of noise that the scale follows, in model units (auto, and fit with `noise`).
    """

    def __init__(self, mesh: Mesh, estimator: Estimator, found: dict[str, Any]) -> None:
        self.mesh = mesh
        self.estimator: Estimator = estimator
        self.on: On = "face" if estimator == "face" else "vertex"
        self.totals: dict[str, float] = found.pop("totals")
        self.radius: float | None = found.pop("radius")
        self.noise: float | None = found.pop("noise")
        kinds = found.pop("kinds")
        self._kinds: NDArray[np.str_] | None = None if kinds is None else np.array(kinds, dtype="<U8")
        self._directions: NDArray[np.float64] | None = found.pop("directions")
        self._normals: NDArray[np.float64] | None = found.pop("normals")
        self._found: dict[str, NDArray[Any]] = found

    @property
    def names(self) -> list[str]:
        """The names of all arrays."""
        return list(self._found)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self._found[name]

    @property
    def gaussian(self) -> NDArray[np.float64]:
        """K, per square of the model unit; 0 at boundary vertices with ``"vertex"``."""
        return self._found["gaussian"]

    @property
    def mean(self) -> NDArray[np.float64]:
        """H, per model unit."""
        return self._found["mean"]

    @property
    def abs_mean(self) -> NDArray[np.float64]:
        """\\|H\\|, per model unit."""
        return self._found["abs_mean"]

    @property
    def abs_dihedral(self) -> NDArray[np.float64]:
        """``1/4 sum of |e| |beta|`` per area, per model unit: the \\|H\\| of Dyn, Hormann, Kim, Levin 2001. At
        least `abs_mean`, and larger where convex and concave edges meet (vertex)."""
        return self._get("abs_dihedral")

    @property
    def principal(self) -> NDArray[np.float64]:
        """The principal curvatures, shape (n, 2), the larger one first, per model unit."""
        return self._found["principal"]

    @property
    def k1(self) -> NDArray[np.float64]:
        """The larger principal curvature, per model unit."""
        return self._found["k1"]

    @property
    def k2(self) -> NDArray[np.float64]:
        """The smaller principal curvature, per model unit."""
        return self._found["k2"]

    @property
    def shape_index(self) -> NDArray[np.float64]:
        """The shape index of Koenderink and van Doorn 1992, from -1 (cup) to 1 (cap)."""
        return self._found["shape_index"]

    @property
    def curvedness(self) -> NDArray[np.float64]:
        """``sqrt((k1**2 + k2**2) / 2)``, per model unit."""
        return self._found["curvedness"]

    @property
    def area(self) -> NDArray[np.float64]:
        """The area that belongs to each element, by which integrals are divided (vertex, face)."""
        return self._get("area")

    @property
    def integral_gaussian(self) -> NDArray[np.float64]:
        """The angle defect of each vertex, in radians; the sum obeys the Gauss-Bonnet theorem. At the boundary
        it is geodesic curvature (vertex)."""
        return self._get("integral_gaussian")

    @property
    def integral_mean(self) -> NDArray[np.float64]:
        """The integral of H over the area of each vertex, in model units (vertex)."""
        return self._get("integral_mean")

    @property
    def integral_abs_mean(self) -> NDArray[np.float64]:
        """The integral of \\|H\\| over the area of each vertex, in model units (vertex)."""
        return self._get("integral_abs_mean")

    @property
    def integral_abs_dihedral(self) -> NDArray[np.float64]:
        """``1/4 sum of |e| |beta|`` of each vertex, in model units; the sum is F2 (vertex)."""
        return self._get("integral_abs_dihedral")

    @property
    def willmore(self) -> NDArray[np.float64]:
        """Bobenko's Willmore energy of each vertex, without unit (vertex)."""
        return self._get("willmore")

    @property
    def k_plus(self) -> NDArray[np.float64]:
        """Positive extrinsic curvature of Alboul and van Damme, in radians: the angle defect of the convex
        hull of the star (vertex)."""
        return self._get("k_plus")

    @property
    def k_minus(self) -> NDArray[np.float64]:
        """Negative extrinsic curvature: `k_plus` minus the angle defect, in radians (vertex)."""
        return self._get("k_minus")

    def _get(self, name: str) -> NDArray[Any]:
        if name not in self._found:
            raise AttributeError(f"the estimator {self.estimator!r} has no {name}")
        return self._found[name]

    @property
    def error(self) -> NDArray[np.float64]:
        """The predicted error of `k1` and `k2`, per model unit: on surfaces with known curvature, it bounds the error
        at nine of ten vertices (auto, fit). NaN where it is unknown."""
        return self._get("error")

    @property
    def kind(self) -> NDArray[np.str_]:
        """What is at each vertex: ``"regular"``, ``"umbilic"`` (`k1` and `k2` differ by less than a quarter of their error; no
        directions), ``"crease"`` (a dihedral angle above 75°; with auto and fit no curvature), ``"boundary"`` or
        ``"unknown"`` (auto, fit, ball, corrected)."""
        if self._kinds is None:
            raise AttributeError(f"the estimator {self.estimator!r} has no kind")
        return self._kinds

    @property
    def directions(self) -> NDArray[np.float64]:
        """Unit tangents along which the normal curvature is `k1` and `k2`, shape (n, 2, 3), each up to sign;
        signs of neighbours agree where possible. NaN at umbilics. With ``"vertex"`` they come from quadratic surfaces fitted to the neighbours (Cazals and Pouget 2005),
        computed on first use."""
        if self._directions is None:
            self._directions = _core.principal_directions(plain(), self.mesh._data)
        return self._directions

    @property
    def normals(self) -> NDArray[np.float64]:
        """Unit normals of the fitted surfaces, shape (n, 3) (auto, face, fit, ball, corrected)."""
        if self._normals is None:
            raise AttributeError(f"the estimator {self.estimator!r} has no normals")
        return self._normals

    def _rows(self) -> list[tuple[str, object]]:
        rows: list[tuple[str, object]] = [("estimator", self.estimator)]
        if self.radius is not None:
            rows.append(("radius", self.radius))
        if self.noise is not None:
            rows.append(("noise", self.noise))
        names = {
            "gaussian": "integral of K",
            "abs_gaussian": "integral of |K|",
            "mean": "integral of H",
            "abs_mean": "integral of |H|",
            "f1": "F1, integral of H²",
            "f2": "F2",
            "f3": "F3, integral of |k1| + |k2|",
            "willmore": "Willmore energy",
        }
        return rows + [(names.get(name, name), value) for name, value in self.totals.items()]

    def __repr__(self) -> str:
        return text(f"Curvature of {len(self.mean)} {self.on} values", self._rows())

    def _repr_html_(self) -> str:
        return table("Curvature", self._rows())


@checked
def curvature(
    mesh: Any,
    *,
    estimator: Estimator = "auto",
    area: Area = "voronoi",
    radius: Length | None = None,
    noise: Length | None = None,
    relative: bool = False,
    rings: int | None = None,
    preset: Sections = "robust",
    progress: Progress = None,
    threads: int | None = None,
) -> Curvature:
    """Curvature of every vertex or face.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`; an oriented manifold, with or without boundaries.
    estimator : str
        ``"auto"``: of surfaces fitted at each vertex, at a scale that follows the noise of the mesh; sums, and
        quantities of whole vertices, as ``"vertex"``; ``"vertex"``: discrete curvature from angle defects and
        dihedral angles, as in the papers; ``"face"``: from normal sections through each face (Szilvási-Nagy 2010);
        ``"fit"``: of surfaces fitted to the nearest points (Cazals and Pouget 2005), for meshes without noise;
        ``"ball"``: averaged over balls (Cohen-Steiner and Morvan 2003); ``"corrected"``: averaged over balls, with
        interpolated normals (Lachaud, Romon, Thibert and Coeurjolly 2020).
    area : str
        With ``"auto"`` and ``"vertex"``, the area of a vertex: ``"voronoi"`` or ``"barycentric"``, a third of every triangle.
    radius : float or str, optional
        With ``"face"`` the length of sections to either side, by default four local edge lengths, or four mean
        edge lengths with ``preset="paper"``. With ``"ball"`` and ``"corrected"`` the radius of the balls, by default
        four mean edge lengths. With ``"fit"`` the radius within which points have similar weights. In model units,
        or ``"1%"`` of the diagonal.
    noise : float or str, optional
        With ``"auto"`` and ``"fit"``, the standard deviation of the noise of vertices. By default it is estimated with
        ``"auto"``, and 0 with ``"fit"``.
    relative : bool
        Whether a number for `radius` or `noise` is a share of the diagonal of the bounding box.
    rings : int, optional
        With ``"fit"``: quadratic surfaces are fitted to this number of rings of neighbours, with equal weights.
    preset : str
        With ``"face"``: ``"robust"``, or ``"paper"`` as in the paper.

    Returns
    -------
    Curvature

    Notes
    -----
    At a vertex, with angles :math:`\\alpha_i` and dihedral angles :math:`\\beta_e` of edges of length
    :math:`|e|`: the integral of K is :math:`2\\pi - \\sum \\alpha_i`, that of H is
    :math:`\\frac14 \\sum |e| \\beta_e`, and :math:`k_{1,2} = H \\pm \\sqrt{\\max(H^2 - K, 0)}` (Dyn, Hormann,
    Kim, Levin 2001).

    Examples
    --------
    >>> import curvmesh as cm
    >>> import numpy as np
    >>> k = cm.curvature(cm.shapes.sphere(5, radius=2.0))
    >>> bool(abs(k.mean - 0.5).max() < 1e-6), bool(k.error.max() < 1e-3)
    (True, True)
    >>> round(k.totals["gaussian"] / np.pi, 9)
    4.0
    >>> k = cm.curvature(cm.shapes.torus())
    >>> k.directions.shape
    (864, 2, 3)
    """
    given = as_mesh(mesh)
    if estimator == "face":
        given = given.triangulated(threads=threads)
    with calling("curvature", progress, threads) as call:
        found = _core.curvature(
            call,
            given._data,
            estimator=estimator,
            area=area,
            radius=radius,
            noise=noise,
            relative=relative,
            rings=rings,
            preset=preset,
        )
    return Curvature(given, estimator, found)
