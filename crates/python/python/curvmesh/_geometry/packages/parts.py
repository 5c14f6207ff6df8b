"""Data of a mesh in the shapes used by other packages."""

from __future__ import annotations

import json
import warnings
from base64 import b64decode, b64encode
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from ..._errors import ArrayError
from ..arrays import EXACT, polygons
from ..mesh import Data, Mesh

if TYPE_CHECKING:
    from numpy.typing import NDArray

#: Suffixes of the components of vectors.
_AXES = ("x", "y", "z")

#: Names of colours and normals in other packages.
_COLORS, _NORMALS = ("colors", "Colors", "RGB", "RGBA", "rgb", "rgba"), ("normals", "Normals")

#: The name under which groups, materials and images are stored in a mesh of a package that does not support
#: them.
EXTRAS = "curvmesh"


def noted(mesh: Mesh, notes: Iterable[str]) -> Mesh:
    """The mesh with more notes."""
    return Mesh._of(mesh._data.with_notes([*mesh.notes, *notes]))


def tell(mesh: Mesh, package: str, lost: Iterable[str]) -> None:
    """Warns of data that a mesh of another package cannot store, and notes it on the mesh that is converted."""
    names = list(lost)
    if not names:
        return
    text = f"a mesh of {package} has no place for {', '.join(names)}"
    if text not in mesh.notes:
        mesh._data = mesh._data.with_notes([*mesh.notes, text])
    warnings.warn(text, stacklevel=3)


def taken(data: Any, count: int, notes: list[str]) -> dict[str, NDArray[Any]]:
    """Foreign data with one row per element, as columns: vectors are split, ``v`` to ``v_x, v_y, v_z``."""
    import numpy as np

    found: dict[str, NDArray[Any]] = {}
    for name in list(data.keys()) if hasattr(data, "keys") else []:
        array = np.asarray(data[name])
        name = str(name)
        if len(array) != count or array.dtype.kind not in "fiub":
            notes.append(f"{name!r} was left out: {array.dtype} of shape {array.shape}")
        elif name in _COLORS and array.ndim == 2 and array.shape[1] in (3, 4):
            found["colors"] = array
        elif name in _NORMALS and array.ndim == 2 and array.shape[1] == 3:
            found["normals"] = array
        elif array.ndim == 1:
            found[name] = array
        else:
            rows = array.reshape(count, -1) if count else array.reshape(0, 1)
            width = rows.shape[1]
            ends = _AXES[:width] if 2 <= width <= 3 else [str(k) for k in range(width)]
            found |= {name if width == 1 else f"{name}_{end}": rows[:, k] for k, end in enumerate(ends)}
    return found


def put(data: Data, columns: Mapping[str, Any], notes: list[str]) -> None:
    """Sets columns; data that a mesh cannot store is noted."""
    try:
        data.update(columns)
    except ArrayError:
        for name, column in columns.items():
            try:
                data[name] = column
            except ArrayError as error:
                notes.append(f"{name!r} was left out: {error}")


def given(data: Data) -> dict[str, NDArray[Any]]:
    """Columns of a mesh for other packages: ``v_x, v_y, v_z`` become the vector ``v`` again."""
    import numpy as np

    columns = {name: data[name] for name in data if data[name].ndim == 1}
    found: dict[str, NDArray[Any]] = {}
    for name in columns:
        stem, _, end = name.rpartition("_")
        names = _components(stem, end, columns) if stem else []
        if not names:
            found[name] = columns[name].copy()
        elif name == names[0]:
            found[stem] = np.column_stack([columns[part] for part in names])
    return found


def _components(stem: str, end: str, columns: Mapping[str, Any]) -> list[str]:
    """The names of all components of the vector that contains a column."""
    axes = [f"{stem}_{axis}" for axis in _AXES]
    numbers = [f"{stem}_{k}" for k in range(next((k for k in range(99) if f"{stem}_{k}" not in columns), 99))]
    if end in _AXES:
        here = [name for name in axes if name in columns]
        return here if len(here) >= 2 and here == axes[: len(here)] and f"{stem}_{end}" in here else []
    return numbers if len(numbers) >= 4 and f"{stem}_{end}" in numbers else []


def in_bytes(colors: NDArray[Any]) -> NDArray[Any]:
    """Colours from 0 to 255."""
    import numpy as np

    # Unknown colours are white, as in files.
    found: NDArray[Any] = np.round(255 * np.clip(np.nan_to_num(colors, nan=1), 0, 1)).astype(np.uint8)
    return found


def split(mesh: Mesh) -> tuple[NDArray[Any], NDArray[Any], NDArray[Any]]:
    """Vertices split so that each has one texture coordinate and one normal.

    Returns for each new vertex its original vertex and corner, and the new corners.
    """
    import numpy as np

    names = list(mesh.corner_data)
    corners = mesh.corners
    if not names:
        return np.arange(mesh.vertex_count), np.empty(0, np.int64), corners.copy()
    keys = np.column_stack([corners, *(mesh.corner_data[name].astype(np.float64) for name in names)])
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    # In the order of the vertices, so that a mesh without seams keeps its numbering.
    order = np.lexsort((first, corners[first]))
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    first = first[order]
    made = place[np.asarray(inverse).ravel()]
    if len(np.unique(corners)) < mesh.vertex_count:
        unused = np.setdiff1d(np.arange(mesh.vertex_count), corners)
        return np.concatenate([corners[first], unused]), first, made
    return corners[first], first, made


def of_vertices(values: NDArray[Any], first: NDArray[Any], count: int) -> NDArray[Any]:
    """Values of corners for the vertices that :func:`split` made; NaN for unused vertices."""
    import numpy as np

    found = np.full((count, values.shape[1]), np.nan, values.dtype)
    found[: len(first)] = values[first]
    return found


class Separate(NamedTuple):
    """The data of a mesh for packages that store one texture coordinate and one normal for each vertex."""

    positions: NDArray[Any]
    #: The vertices of all faces, and the end of each face.
    corners: NDArray[Any]
    ends: NDArray[Any]
    of_points: dict[str, NDArray[Any]]
    of_faces: dict[str, NDArray[Any]]
    normals: NDArray[Any] | None
    uvs: NDArray[Any] | None


def separate(mesh: Mesh) -> Separate:
    """The data with split vertices. Colours are bytes, ``"colors"`` of points and of faces."""
    import numpy as np

    sources, first, corners = split(mesh)
    of_points = {name: values[sources] for name, values in given(mesh.vertex_data).items()}
    of_faces = given(mesh.face_data)
    if "colors" in mesh.vertex_data:
        of_points["colors"] = in_bytes(mesh.vertex_data["colors"])[sources]
    if "colors" in mesh.face_data:
        of_faces["colors"] = in_bytes(mesh.face_data["colors"])
    normals = uvs = None
    if "normals" in mesh.corner_data:
        normals = of_vertices(mesh.corner_data["normals"], first, len(sources))
    elif "normals" in mesh.vertex_data:
        normals = mesh.vertex_data["normals"][sources]
    if "uvs" in mesh.corner_data:
        uvs = of_vertices(mesh.corner_data["uvs"], first, len(sources))
    ends = mesh.face_ends.astype(np.int64)
    return Separate(mesh.vertices[sources], corners, ends, of_points, of_faces, normals, uvs)


def extras(mesh: Mesh) -> str:
    """Groups, materials and images as a text."""
    images = [
        {**image, "data": b64encode(image["data"]).decode()} if "data" in image else image
        for image in mesh.images
    ]
    return json.dumps({"groups": mesh.groups, "materials": mesh.materials, "images": images})


def with_extras(mesh: Mesh, text: str) -> None:
    """Restores the groups, materials and images written by :func:`extras`."""
    found = json.loads(text)
    mesh.groups = [(one, other) for one, other in found["groups"]]
    mesh.images = [
        {**image, "data": b64decode(image["data"])} if "data" in image else image
        for image in found["images"]
    ]
    mesh.materials = found["materials"]


def image_of(pixels: Any, name: str = "") -> dict[str, Any] | None:
    """Pixels of an image, a picture of Pillow or an array; ``None`` without Pillow."""
    import io

    try:
        from PIL import Image
    except ImportError:
        return None
    picture = pixels if hasattr(pixels, "save") else Image.fromarray(pixels)
    written = io.BytesIO()
    picture.save(written, "PNG")
    return {"name": name, "media_type": "image/png", "data": written.getvalue()}


def picture_of(mesh: Mesh, material: Mapping[str, Any]) -> Any:
    """The texture of a material as a picture of Pillow; ``None`` if there is none."""
    import io

    place = material["image"]
    content = mesh.images[place].get("data") if place is not None else None
    if content is None:
        return None
    try:
        from PIL import Image

        return Image.open(io.BytesIO(content))
    except (ImportError, OSError):
        return None


def merged(meshes: Sequence[Mesh], names: Sequence[str]) -> Mesh:
    """One mesh from several, each a group; numbers missing in a part are NaN."""
    import numpy as np

    starts = np.cumsum([0, *(mesh.vertex_count for mesh in meshes)])
    ends = np.cumsum([0, *(len(mesh.corners) for mesh in meshes)])
    whole = Mesh._of(
        polygons(
            np.concatenate([mesh.vertices for mesh in meshes]),
            np.concatenate([mesh.corners + np.int64(start) for mesh, start in zip(meshes, starts)]),
            np.concatenate([mesh.face_ends + np.int64(end) for mesh, end in zip(meshes, ends)]),
            False,
        )
    )
    notes = [text for mesh in meshes for text in mesh.notes]
    _merge_lists(whole, meshes, names)
    for on in ("vertex_data", "corner_data", "face_data"):
        _merge_data(whole, meshes, names, on, notes)
    joins = [mesh.joins for mesh in meshes]
    if True in joins and False in joins:
        notes.append("vertices at equal positions count as one, also in parts where they did not")
    whole = whole.joined(True if True in joins else False if set(joins) == {False} else None)
    return noted(whole, dict.fromkeys(notes))


def _merge_lists(whole: Mesh, meshes: Sequence[Mesh], names: Sequence[str]) -> None:
    import numpy as np

    groups: list[tuple[str, str]] = []
    images: list[dict[str, Any]] = []
    materials: list[dict[str, Any]] = []
    of_groups, of_materials = [], []
    for mesh, name in zip(meshes, names):
        own = mesh.face_data.get("groups")
        if own is None or not mesh.groups:
            of_groups.append(np.full(mesh.face_count, len(groups)))
            groups.append((name, ""))
        else:
            of_groups.append(np.where(own < 0, -1, own + len(groups)))
            groups += [(one or name, other) for one, other in mesh.groups]
        used = mesh.face_data.get("materials")
        none = np.full(mesh.face_count, -1)
        of_materials.append(none if used is None else np.where(used < 0, -1, used + len(materials)))
        for material in mesh.materials:
            place = material["image"]
            materials.append({**material, "image": None if place is None else place + len(images)})
        images += mesh.images
    whole.groups, whole.images, whole.materials = groups, images, materials
    whole.face_data["groups"] = np.concatenate(of_groups)
    if materials:
        whole.face_data["materials"] = np.concatenate(of_materials)


def _merge_data(whole: Mesh, meshes: Sequence[Mesh], names: Sequence[str], on: str, notes: list[str]) -> None:
    counts = {"vertex_data": "vertex_count", "face_data": "face_count"}
    size = [getattr(mesh, counts[on]) if on in counts else len(mesh.corners) for mesh in meshes]
    parts = [getattr(mesh, on) for mesh in meshes]
    found = {}
    for name in dict.fromkeys(name for part in parts for name in part if name not in ("groups", "materials")):
        rows = [part[name] if name in part else None for part in parts]
        found[name] = _in_one(name, rows, size, notes)
        if name == "colors" and None in [None if row is None else 0 for row in rows]:
            without = ", ".join(repr(part) for part, row in zip(names, rows) if row is None)
            notes.append(f"{without} without colours: they are unknown there (NaN), and white in files")
    getattr(whole, on).update(found)


def _in_one(name: str, rows: Sequence[Any], size: Sequence[int], notes: list[str]) -> Any:
    """The rows of all parts. Parts without are NaN, or another number if NaN would change whole numbers."""
    import numpy as np

    there = [row for row in rows if row is not None]
    kind = np.result_type(*there)
    is_whole = all(row.dtype.kind in "iu" for row in there)
    low = min((int(row.min()) for row in there if is_whole and row.size), default=0)
    high = max((int(row.max()) for row in there if is_whole and row.size), default=0)
    if is_whole and kind.kind == "f":
        # Signed and unsigned numbers of 64 bits have no common type; their values often do.
        kind = np.dtype(np.uint64 if low >= 0 else np.int64 if high < 2**63 else np.float64)
    unknown: Any = np.nan
    if len(there) < len(rows):
        if not is_whole or max(-low, high) <= EXACT:
            kind = kind if kind.kind == "f" else np.dtype(np.float64)
        elif kind.kind != "f":
            ends = np.iinfo(kind)
            unknown = -1 if kind.kind == "i" and low >= 0 else ends.min if low > ends.min else ends.max
            notes.append(f"{name!r} is {unknown} in parts without it: NaN would change whole numbers above 2**53")
    if kind.kind == "f" and any(row.dtype.kind in "iu" and row.size and _exceeds(row) for row in there):
        notes.append(f"{name!r} has whole numbers above 2**53 beside other numbers, and lost digits")
    empty = [np.full((count, *there[0].shape[1:]), unknown, kind) for count in size]
    return np.concatenate([none if row is None else row.astype(kind) for row, none in zip(rows, empty)])


def _exceeds(values: NDArray[Any]) -> bool:
    return max(-int(values.min()), int(values.max())) > EXACT
