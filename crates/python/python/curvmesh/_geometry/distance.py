"""Distances between meshes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

from .. import _core
from .._call import Progress, calling, plain
from .._errors import OptionError
from .._options import checked
from .._table import table, text
from .files import as_mesh
from .mesh import Mesh

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .._options import Length

__all__ = ["Bounds", "Distance", "OneSided", "Signed", "distance"]

#: More samples would only take memory and days; the program has the same bound.
_MOST_SAMPLES = 10_000_000_000


class Signed(NamedTuple):
    """Distances that are negative inside, in model units.

    Attributes
    ----------
    by : str
        How the sign was decided: ``"winding_number"`` of a closed surface, or ``"pseudonormal"`` at the closest
        point of an open one, where inside means behind the surface.
    mean, min, max : float
        The mean over the area, the smallest and the largest distance.
    inside : float
        The share of the area, or of the points, that is inside.
    """

    by: str
    mean: float
    min: float
    max: float
    inside: float


class OneSided(NamedTuple):
    """Distances of the points of one surface from another one, in model units.

    Attributes
    ----------
    mean, rms : float
        Mean and root mean square over the area.
    max : float
        The largest sampled distance.
    max_at, max_to : tuple of float
        The point with this distance, and the closest point of the other surface.
    signed : Signed or None
        The same distances with signs, if requested.
    """

    mean: float
    rms: float
    max: float
    max_at: tuple[float, float, float]
    max_to: tuple[float, float, float]
    signed: Signed | None = None


class Bounds(NamedTuple):
    """Certified bounds of the Hausdorff distance, in model units.

    `converged` is ``False`` if the limit of work was reached before the bounds were close enough.
    """

    lower: float
    upper: float
    converged: bool


@dataclass(repr=False)
class Distance:
    """The distances between two surfaces.

    Attributes
    ----------
    first, second : Mesh
        The surfaces.
    forward, backward : OneSided or None
        From the first to the second, and vice versa. A surface is not measured to points.
    mean, rms, max : float
        Over both directions, or the one that was measured; `max` is a lower bound of the Hausdorff distance.
    diagonal : float
        Of the bounding box of the first surface.
    bounds : Bounds or None
        Certified bounds, if requested.
    """

    first: Mesh
    second: Mesh
    forward: OneSided | None
    backward: OneSided | None
    mean: float
    rms: float
    max: float
    diagonal: float
    bounds: Bounds | None

    @cached_property
    def of_vertices(self) -> NDArray[np.float64]:
        """The distance of every vertex of the first mesh from the second; exact, computed on first use."""
        return _core.vertex_distances(plain(), self.first._data, self.second._data)

    @cached_property
    def of_other_vertices(self) -> NDArray[np.float64]:
        """The distance of every vertex of the second mesh from the first."""
        return _core.vertex_distances(plain(), self.second._data, self.first._data)

    def _rows(self) -> list[tuple[str, object]]:
        rows: list[tuple[str, object]] = []
        sides = (("A to B", self.forward), ("B to A", self.backward), ("both", self))
        for name, side in sides:
            if side is not None:
                rows += [(f"{name}: {what}", getattr(side, what)) for what in ("mean", "rms", "max")]
        if self.bounds is not None:
            rows.append(("Hausdorff distance, proved", (self.bounds.lower, self.bounds.upper)))
        rows.append(("diagonal of A", self.diagonal))
        return rows

    def __repr__(self) -> str:
        return text("Distance", self._rows())

    def _repr_html_(self) -> str:
        return table("Distance", self._rows())


@checked
def distance(
    first: Any,
    second: Any,
    *,
    samples: int = 1_000_000,
    exact: Length | None = None,
    relative: bool = False,
    signed: bool = False,
    seed: int = 1,
    progress: Progress = None,
    threads: int | None = None,
) -> Distance:
    """Measure the distance between two surfaces, from each to the other, or of points from a surface.

    Parameters
    ----------
    first, second : mesh-like
        See :func:`curvmesh.as_mesh`. Neither need be a manifold. A mesh without faces is a point cloud: points
        are measured to the other surface, in this direction only; two clouds in both directions.
    samples : int
        Number in each direction, uniform by area, for mean and root mean square. The largest distance also uses
        vertices and points of the edges.
    exact : float or str, optional
        Also certify bounds of the Hausdorff distance with at most this gap: in model units, or ``"0.01%"`` of
        the diagonal of the first surface.
    relative : bool
        Whether a number for `exact` is a share of that diagonal.
    signed : bool
        Also give distances a sign, negative inside; see :class:`Signed`.
    seed : int
        Seed of the random numbers.

    Returns
    -------
    Distance

    Notes
    -----
    As in Metro (Cignoni, Rocchini, Scopigno 1998); distances of samples are exact. The bounds account for all
    rounding errors.

    Examples
    --------
    >>> import curvmesh as cm
    >>> ball, larger = cm.shapes.sphere(4), cm.shapes.sphere(4, radius=1.1)
    >>> d = cm.distance(ball, larger, samples=10_000, exact=1e-3)
    >>> round(d.mean, 2), d.bounds.lower <= d.max <= d.bounds.upper
    (0.1, True)
    """
    if not 1 <= samples <= _MOST_SAMPLES:
        raise OptionError(f"samples is {samples}; it must be from 1 to {_MOST_SAMPLES}")
    a, b = as_mesh(first, check=False), as_mesh(second, check=False)
    with calling("measuring", progress, threads) as call:
        found = _core.distance(call, a._data, b._data, samples, exact, relative, signed, seed)
    bounds = found.pop("bounds")
    for side in ("forward", "backward"):
        numbers = found[side]
        if numbers is None:
            continue
        sign = numbers.pop("signed")
        numbers["signed"] = None if sign is None else Signed(*sign)
        places = {name: tuple(numbers[name]) for name in ("max_at", "max_to")}
        found[side] = OneSided(**{**numbers, **places})
    return Distance(a, b, bounds=None if bounds is None else Bounds(*bounds), **found)
