"""Shapes with known curvature, for tests and examples."""

from __future__ import annotations

from . import _core
from ._geometry.mesh import Mesh
from ._options import checked

__all__ = ["cube", "icosahedron", "octahedron", "sphere", "tetrahedron", "torus"]


@checked
def sphere(level: int = 4, *, radius: float = 1.0) -> Mesh:
    """A sphere around the origin: an icosahedron whose faces are cut into four `level` times.

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.shapes.sphere(2)
    Mesh(162 vertices, 320 faces)
    """
    return Mesh._of(_core.sphere(level, radius))


@checked
def torus(
    rings: int = 36, sides: int = 24, *, major: float = 5.0, minor: float = 2.0, shifted: bool = True
) -> Mesh:
    """A torus around the origin, with `rings` times `sides` vertices.

    Parameters
    ----------
    rings, sides : int
        Vertices along the large circle and along the small one.
    major, minor : float
        The radii of these circles.
    shifted : bool
        Triangulated as in Dyn, Hormann, Kim, Levin 2001, who use ``torus(12, 6)``.
    """
    return Mesh._of(_core.torus(rings, sides, major, minor, shifted))


def tetrahedron() -> Mesh:
    """A regular tetrahedron."""
    return Mesh._of(_core.polyhedron(4))


def cube() -> Mesh:
    """A cube of six quadrilaterals or twelve triangles."""
    return Mesh._of(_core.polyhedron(6))


def octahedron() -> Mesh:
    """A regular octahedron."""
    return Mesh._of(_core.polyhedron(8))


def icosahedron() -> Mesh:
    """A regular icosahedron."""
    return Mesh._of(_core.polyhedron(20))
