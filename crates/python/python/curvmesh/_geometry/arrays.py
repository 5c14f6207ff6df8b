"""Conversion of arrays of the caller to arrays of a mesh, with checks of types, shapes and value ranges."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .. import _core
from .._errors import ArrayError

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Up to this number, every integer is exact in float64.
EXACT = 2**53


def _refused(what: str, cure: str) -> ArrayError:
    return ArrayError(f"{what}; {cure}", cure=cure)


def real_numbers(name: str, values: Any) -> NDArray[Any]:
    """An array of real numbers without masked entries."""
    import numpy as np

    if np.ma.isMaskedArray(values):
        masked = int(np.ma.getmaskarray(values).sum())
        if masked:
            cure = "drop those rows, or fill them: array.filled(value)"
            raise _refused(f"{name!r} has {masked} masked entries", cure)
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise _refused(f"{name!r} is of type {array.dtype}", "it must be of real numbers")
    return array


def coordinates(vertices: Any) -> NDArray[Any]:
    """Positions as rows of float32 or float64; copied only if the type differs."""
    import numpy as np

    array = real_numbers("vertices", vertices)
    if array.size == 0:
        array = array.reshape(0, 3)
    if array.ndim == 2 and array.shape[1] == 2:
        cure = "add a third column: np.column_stack([vertices, np.zeros(len(vertices))])"
        raise _refused(f"vertices have the shape {array.shape}", cure)
    if array.ndim != 2 or array.shape[1] != 3:
        raise ArrayError(f"vertices have the shape {array.shape}; it must be (n, 3)")
    kind = np.float32 if array.dtype == np.float32 else np.float64
    if array.dtype.kind in "iu" and array.dtype.itemsize == 8 and array.size:
        largest = max(abs(int(array.min())), abs(int(array.max())))
        if largest > EXACT:
            raise _refused(
                f"vertices have {largest}: whole numbers above 2**53 are no exact coordinates",
                "move them closer to the origin: vertices - vertices[0]",
            )
    return np.require(array, kind, "A")


def faces_of(faces: Any) -> tuple[NDArray[Any], NDArray[Any] | None]:
    """Rows of vertex indices; or, for polygons, all corners and the end of each face."""
    import numpy as np

    if np.ma.isMaskedArray(faces):
        # Unused corners of a smaller polygon, as in the UGRID convention.
        mask = np.ma.getmaskarray(faces)
        if mask.ndim == 2 and ((mask[:, :-1] & ~mask[:, 1:]).any() or mask[:, :3].any()):
            raise _refused(
                "faces have masked corners before others, or fewer than three others",
                "drop those rows; only the unused corners at the end of smaller polygons can be masked",
            )
        faces = np.where(mask, -1, np.ma.getdata(faces).astype(np.int64)) if mask.any() else np.asarray(faces)
    try:
        array = np.asarray(faces)
    except ValueError:
        return _ragged(faces)
    if array.dtype == object:
        return _ragged(faces)
    if array.size == 0:
        return np.empty((0, 3), np.int32), None
    if array.dtype.kind == "f":
        raise _refused(f"faces are of type {array.dtype}; they must be integers", "faces.astype(int)")
    if array.dtype.kind not in "iu":
        raise ArrayError(f"faces are of type {array.dtype}; they must be integers")
    if array.ndim == 1:
        cure = "reshape(-1, 3) for triangles, reshape(-1, 4)[:, 1:] where a 3 precedes each triangle"
        raise _refused(f"faces have the shape {array.shape}; it must be (m, 3)", cure)
    if array.ndim != 2 or array.shape[1] < 3:
        raise ArrayError(f"faces have the shape {array.shape}; it must be (m, 3)")
    array = _without_counts(array)
    if array.shape[1] == 3:
        return _integers(array), None
    return _polygons(array)


def _ragged(faces: Any) -> tuple[NDArray[Any], NDArray[Any]]:
    """Polygons as a list of lists of different lengths."""
    import numpy as np

    try:
        rows = [np.asarray(face) for face in faces]
        corners = np.concatenate(rows)
    except (TypeError, ValueError):
        raise ArrayError("faces must be rows of vertex indices") from None
    if corners.dtype.kind not in "iu" or any(row.ndim != 1 for row in rows):
        raise ArrayError("faces must be rows of vertex indices")
    return corners, np.cumsum([len(row) for row in rows])


def _without_counts(array: NDArray[Any]) -> NDArray[Any]:
    """The rows without a first column of counts, as used by VTK: ``[3, a, b, c]``."""
    width = array.shape[1] - 1
    if width < 3 or not (array[:, 0] == width).all():
        return array
    if (array[:, 1:] == width).any():
        # As polygons, these rows would use a vertex twice.
        return array[:, 1:]
    raise _refused(
        f"every row of faces begins with {width}: these are either {width}-gons, each with its number of "
        f"corners before it, or {width + 1}-gons around vertex {width}",
        "faces[:, 1:] for the former, np.roll(faces, 1, axis=1) for the latter",
    )


def _integers(array: NDArray[Any]) -> NDArray[Any]:
    """Indices of 32 or 64 bits; copied only if the type differs."""
    import numpy as np

    unsigned = array.dtype.kind == "u" and array.dtype.itemsize >= 4
    size = 4 if array.dtype.itemsize <= 4 else 8
    return np.require(array, np.dtype(f"{'u' if unsigned else 'i'}{size}"), "A")


def _polygons(array: NDArray[Any]) -> tuple[NDArray[Any], NDArray[Any]]:
    """Rows of polygons; smaller polygons are padded with -1."""
    import numpy as np

    rows, width = array.shape
    used = array != -1 if array.dtype.kind == "i" else np.ones(array.shape, bool)
    sizes = used.sum(axis=1)
    trailing = (used == (np.arange(width) < sizes[:, None])).all() and (sizes >= 3).all()
    if not trailing:
        used, sizes = np.ones(array.shape, bool), np.full(rows, width)
    return array[used], np.cumsum(sizes)


def content(vertices: Any, faces: Any, check: bool) -> _core.MeshData:
    """The mesh of arrays."""
    points = coordinates(vertices)
    corners, ends = faces_of(faces)
    if ends is None:
        return _core.MeshData.of_triangles(points, corners, check)
    return polygons(points, corners, ends, check)


def polygons(vertices: Any, corners: Any, ends: Any, check: bool) -> _core.MeshData:
    """The mesh of polygons: all corners, and the end of each face."""
    import numpy as np

    flat = [np.require(array, np.int64, "A") for array in (corners, ends)]
    return _core.MeshData.of_polygons(coordinates(vertices), flat[0], flat[1], check)


def column(on: str, name: str, values: Any) -> NDArray[Any]:
    """Data of a mesh in the type of storage."""
    import numpy as np

    array = real_numbers(name, values)
    if name == "colors" and on in ("vertex", "face"):
        return _colors(array)
    if name in ("normals", "uvs"):
        if array.ndim != 2:
            raise ArrayError(f"{name!r} has the shape {array.shape}; it must have rows and columns")
        with np.errstate(over="ignore"):
            single = np.require(array, np.float32, "A")
        if (np.isfinite(array) & np.isinf(single)).any():
            raise _refused(f"{name!r} has {np.abs(array).max():g}", f"it must be below {np.finfo(np.float32).max:g}")
        return single
    if array.ndim != 1:
        raise _refused(
            f"{name!r} has the shape {array.shape}; named numbers are one for each {on}",
            "give each column its own name",
        )
    if on == "face" and name in ("groups", "materials"):
        if array.dtype.kind == "f" and not (array == np.floor(array)).all():
            raise _refused(f"{name!r} has numbers with a fraction", "give whole numbers, -1 for none")
        return np.require(array, np.int64, "A")
    kind = array.dtype
    if kind.kind == "b":
        kind = np.dtype(np.uint8)
    elif kind.kind == "f":
        kind = np.dtype(np.float32 if kind.itemsize <= 4 else np.float64)
    return np.require(array, kind.newbyteorder("="), "A")


def _colors(array: NDArray[Any]) -> NDArray[Any]:
    """Colours as rows of red, green, blue and opacity, from 0 to 1."""
    import numpy as np

    if array.ndim != 2 or array.shape[1] not in (3, 4):
        raise ArrayError(f"'colors' has the shape {array.shape}; it must be (n, 3) or (n, 4)")
    found = np.minimum(array.astype(np.float32) / np.float32(_full_scale(array)), np.float32(1))
    if found.shape[1] == 3:
        found = np.hstack([found, np.ones((len(found), 1), np.float32)])
    return np.require(found, np.float32, "A")


def _full_scale(array: NDArray[Any]) -> float:
    """The value of full intensity."""
    import numpy as np

    kind = array.dtype
    if kind in (np.uint8, np.uint16):
        return float(np.iinfo(kind).max)
    known = array[np.isfinite(array)] if kind.kind == "f" else array
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    if kind.kind in "fb":
        if low < 0 or high > 1 + 1e-6:
            cure = "divide them by their full scale, such as 255, or give uint8"
            raise _refused(f"'colors' are from {low:g} to {high:g}; they must be from 0 to 1", cure)
        return 1.0
    if low < 0 or high > 255 or high == 1:
        cure = "give uint8 or uint16, or floats from 0 to 1"
        raise _refused(f"'colors' are of type {kind}, from {low:g} to {high:g}: their full scale is unknown", cure)
    return 255.0
