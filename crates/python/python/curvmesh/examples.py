"""Small example meshes: a scan with noise and holes, a textured model, a part with sharp edges."""

from __future__ import annotations

from ._geometry.mesh import Mesh
from ._options import checked
from .shapes import cube, sphere, torus

__all__ = ["bracket", "globe", "scan"]


@checked
def scan(level: int = 5, *, noise: float = 0.002, seed: int = 1) -> Mesh:
    """A bumpy surface as from a scanner: with noise, and a hole at the bottom.

    Parameters
    ----------
    level : int
        Subdivisions of an icosahedron; each has four times as many faces.
    noise : float
        Standard deviation of the noise, as a share of the radius.
    seed : int
        Seed of the random numbers.

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.info(cm.examples.scan(3)).boundary_loops
    1
    """
    import numpy as np

    ball = sphere(level)
    p = ball.vertices
    radius = 1 + 0.15 * np.sin(5 * p[:, 0] + 1) * np.cos(4 * p[:, 1]) + 0.05 * np.sin(9 * p[:, 2])
    radius += np.random.default_rng(seed).normal(0, noise, len(p))
    faces = ball.faces[(p[ball.faces, 1] > -0.9).all(axis=1)]
    used, corners = np.unique(faces, return_inverse=True)
    return Mesh((p * radius[:, None])[used], corners.reshape(-1, 3))


@checked
def globe(level: int = 4) -> Mesh:
    """A sphere with texture coordinates, a chequered texture, and a seam.

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.examples.globe(2).materials[0]["name"]
    'chequer'
    """
    import numpy as np

    ball = sphere(level)
    p, corners = ball.vertices, ball.corners
    u = (np.arctan2(p[:, 1], p[:, 0]) / (2 * np.pi) % 1.0)[corners].reshape(-1, 3)
    # Faces across the seam continue beyond 1.
    across = np.ptp(u, axis=1) > 0.5
    u[across] = np.where(u[across] < 0.5, u[across] + 1, u[across])
    v = np.arcsin(np.clip(p[:, 2], -1, 1))[corners] / np.pi + 0.5
    ball.corner_data["uvs"] = np.column_stack([u.ravel(), v])
    ball.images = [{"name": "chequer", "media_type": "image/png", "data": _chequer()}]
    ball.materials = [{"name": "chequer", "image": 0}]
    ball.face_data["materials"] = np.zeros(ball.face_count, int)
    return ball


def _chequer(size: int = 64, squares: int = 8) -> bytes:
    """A chequered PNG image."""
    import struct
    import zlib

    def chunk(kind: bytes, content: bytes) -> bytes:
        total = struct.pack(">I", zlib.crc32(kind + content))
        return struct.pack(">I", len(content)) + kind + content + total

    side = size // squares
    rows = [
        b"\0" + b"".join(
            b"\xe8\xe4\xd8" if (x // side + y // side) % 2 else b"\x3b\x6e\xa5" for x in range(size)
        )
        for y in range(size)
    ]
    header = struct.pack(">IIBBBBB", size, size, 8, 2, 0, 0, 0)
    parts = [chunk(b"IHDR", header), chunk(b"IDAT", zlib.compress(b"".join(rows))), chunk(b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(parts)


def bracket() -> Mesh:
    """A part with sharp edges: a plate with a ring on it, two components that are two groups.

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.examples.bracket().groups
    [('', 'plate'), ('', 'ring')]
    """
    import numpy as np

    plate, ring = cube().triangulated(), torus(48, 16, major=2.0, minor=0.5)
    made = Mesh(
        np.vstack([plate.vertices * [3.5, 3.5, 0.4], ring.vertices + [0, 0, 1.2]]),
        np.vstack([plate.faces, ring.faces + plate.vertex_count]),
    )
    made.groups = [("", "plate"), ("", "ring")]
    made.face_data["groups"] = np.repeat([0, 1], [plate.face_count, ring.face_count])
    return made
