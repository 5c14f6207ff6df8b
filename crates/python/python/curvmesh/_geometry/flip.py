"""Edge flips."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from .. import _core
from .._call import Callback, Progress, calling
from .._errors import OptionError
from .._options import checked
from .._table import table, text
from .arrays import real_numbers
from .files import as_mesh
from .mesh import Mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from .._options import Area, FlipCost

__all__ = ["EdgeCost", "FaceCost", "Flipped", "flip"]


@dataclass(frozen=True)
class FaceCost:
    """A flip cost that is a sum over triangles.

    Parameters
    ----------
    of : callable
        Called with the corners of k triangles, shape (k, 3, 3); returns one number for each.
    length_exponent : int
        The unit of the cost as a power of length: 0 if it does not depend on scale, 2 for an area. It is used
        to distinguish gains from rounding errors.

    Examples
    --------
    The sum of the squared areas:

    >>> import curvmesh as cm
    >>> import numpy as np
    >>> def squared_area(triangles):
    ...     a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    ...     return 0.25 * (np.cross(b - a, c - a) ** 2).sum(axis=1)
    >>> better = cm.flip(cm.shapes.torus(), cost=cm.FaceCost(squared_area, length_exponent=4))
    >>> better.cost_after < better.cost_before
    True
    """

    of: Callable[[NDArray[Any]], Any]
    length_exponent: int
    terms = "faces"

    def function(self, points: Any) -> Any:
        """The terms of some triangles."""
        import numpy as np

        return np.ascontiguousarray(real_numbers("result of the function", self.of(points)), dtype=np.float64)


@dataclass(frozen=True)
class EdgeCost:
    """A flip cost that is a sum over the edges between two triangles.

    Parameters
    ----------
    of : callable
        Called with the two ends, the left and the right apex of k edges, shape (k, 4, 3); returns one number
        for each.
    length_exponent : int
        As for :class:`FaceCost`.
    """

    of: Callable[[NDArray[Any]], Any]
    length_exponent: int
    terms = "edges"

    def function(self, points: Any) -> Any:
        """The terms of some edges."""
        import numpy as np

        return np.ascontiguousarray(real_numbers("result of the function", self.of(points)), dtype=np.float64)


@dataclass(frozen=True, repr=False)
class Flipped:
    """A mesh after edge flips, and a report.

    Attributes
    ----------
    mesh : Mesh
        The same vertices with other faces, without normals, since flips change them.
    cost_before, cost_after : float
        The cost of the whole mesh.
    flips : int
        Number of flips.
    rebuilt : int
        Number of rebuilding rounds that lowered the cost.
    annealed_flips : int
        Number of flips from annealing.
    locked_edges : int
        Number of feature edges and borders, which are never flipped.
    stop : str
        ``"local-minimum"``, ``"cycle-guard"``, ``"flip-limit"``, ``"time-limit"`` or ``"cancelled"``.
    refused : dict
        Number of rejected flips, by reason.
    """

    mesh: Mesh
    cost_before: float
    cost_after: float
    flips: int
    rebuilt: int
    annealed_flips: int
    locked_edges: int
    stop: str
    refused: dict[str, int]

    def _rows(self) -> list[tuple[str, object]]:
        rows: list[tuple[str, object]] = [
            ("cost before", self.cost_before),
            ("cost after", self.cost_after),
            ("flips", self.flips),
            ("patches rebuilt", self.rebuilt),
            ("of annealing", self.annealed_flips),
            ("locked edges", self.locked_edges),
            ("stopped at", self.stop),
        ]
        return rows + [(f"refused: {reason}", count) for reason, count in self.refused.items()]

    def __repr__(self) -> str:
        return text("Flipped", self._rows())

    def _repr_html_(self) -> str:
        return table("Flipped", self._rows())


@checked
def flip(
    mesh: Any,
    *,
    cost: FlipCost | FaceCost | EdgeCost = "f2",
    area: Area = "voronoi",
    look_ahead: int = 1,
    rebuild_effort: int | None = None,
    rebuild_largest: int = 1000,
    anneal_steps: int | None = None,
    feature_angle: float | None = None,
    shape_constraint: str | None = None,
    max_fold: float | None = None,
    no_intersections: bool = False,
    random_ties: bool | None = None,
    seed: int | None = None,
    max_flips: int | None = None,
    time_limit: float | None = None,
    progress: Progress = None,
    callback: Callback | None = None,
    keep_partial: bool = False,
    threads: int | None = None,
) -> Flipped:
    """Lower a cost by edge flips; vertices do not move.

    Borders between texture charts, groups and materials are kept.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`; an oriented manifold.
    cost : str or FaceCost or EdgeCost
        ``"f1"``, ``"f2"`` and ``"f3"`` of Dyn, Hormann, Kim, Levin 2001 (integrals of H², of \\|H\\| and of
        \\|k1\\| + \\|k2\\|), ``"gauss"`` (\\|K\\|), ``"gauss-extrinsic"`` (Alboul and van Damme),
        ``"area"``, ``"delaunay"`` (cotangents), ``"willmore"`` (Brink, Alboul, Rodrigues 2006), ``"willmore-potential"``; or functions of one's own.
    area : str
        Area of a vertex, for ``"f1"`` and ``"f3"``: ``"voronoi"`` or
        ``"barycentric"``.
    look_ahead : int
        Where no single flip lowers the cost, try sequences of up to this many flips, from 1 to 6. Each
        further flip multiplies the time by about 6.
    rebuild_effort : int, optional
        Leave local minima by ruin and recreate: remove the vertices of a patch and insert each where it
        costs least. Ends when each vertex was removed this many times without improvement; 10 is typical.
    rebuild_largest : int
        Largest number of vertices that are removed at once, at least 3.
    anneal_steps : int, optional
        Leave local minima by simulated annealing with this many trial flips per edge and round; 50 is
        typical.
    feature_angle : float, optional
        Keep edges with a larger dihedral angle than this, in degrees.
    shape_constraint : str, optional
        Constraint on the shape of new faces: ``"unrestricted"`` (as in the papers), ``"keep-shape"`` (no
        face folds back, no new slivers) or ``"convex"`` (also, the two faces of the edge form a convex
        quadrilateral). The default is ``"convex"`` for ``"area"`` and ``"delaunay"``, else
        ``"keep-shape"``.
    max_fold : float, optional
        Reject flips that turn a face by more than this, in degrees.
    no_intersections : bool
        Reject flips that would make the surface cross itself.
    random_ties : bool, optional
        Break ties in a random order instead of by edge number. The default is true if a `seed` is given
        without `rebuild_effort` and `anneal_steps`.
    seed : int, optional
        Seed of the random numbers; the default is 1.
    max_flips : int, optional
        Stop after this many flips.
    time_limit : float, optional
        Stop after this many seconds.
    progress, callback, keep_partial, threads
        As for :func:`curvmesh.simplify`.

    Returns
    -------
    Flipped

    Examples
    --------
    >>> import curvmesh as cm
    >>> better = cm.flip(cm.shapes.torus(12, 6), cost="f2", look_ahead=2)
    >>> better.cost_after < better.cost_before, better.stop
    (True, 'local-minimum')
    """
    if not isinstance(cost, (str, FaceCost, EdgeCost)):
        raise OptionError(f"cost is {cost!r}; it must be a name, a FaceCost or an EdgeCost")
    if not 1 <= look_ahead <= 6:
        raise OptionError(f"look_ahead is {look_ahead}; it must be from 1 to 6")
    if random_ties is None:
        random_ties = seed is not None and anneal_steps is None and rebuild_effort is None
    options = {
        "area": area,
        "look_ahead": look_ahead,
        "rebuild_effort": rebuild_effort,
        "rebuild_largest": rebuild_largest,
        "anneal_steps": anneal_steps,
        "feature_angle": feature_angle,
        "shape_constraint": shape_constraint,
        "max_fold": max_fold,
        "no_intersections": no_intersections,
        "random_ties": random_ties,
        "seed": 1 if seed is None else seed,
        "max_flips": max_flips,
        "time_limit": time_limit,
    }
    data = as_mesh(mesh)._data
    with calling("flipping", progress, threads, callback, keep_partial) as call:
        made, told = _core.flip(call, data, cost, options)
    return Flipped(mesh=Mesh._of(made), **told)
