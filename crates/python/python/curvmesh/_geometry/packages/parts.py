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

#: Names with a meaning in a mesh or in another package: numbers that have one of them never become a vector.
_MEANT = (*_COLORS, *_NORMALS, "uvs", "Texture Coordinates", "TCoords", "positions", "indices", "texture_uvs")

#: Names with a meaning in a mesh; numbers of other packages that have one of them get another name.
_OWN = ("colors", "normals", "uvs")

#: The end of the names of numbers whose own name has a meaning.
_VALUES = "_values"

#: The name under which groups, materials and images are stored in a mesh of a package that does not support
#: them.
EXTRAS = "curvmesh"


def noted(mesh: Mesh, notes: Iterable[str]) -> Mesh:
    """The mesh with more notes."""
    return Mesh._of(mesh._data.with_notes([*mesh.notes, *notes]))


def note(mesh: Mesh, text: str) -> None:
    """Notes something on a mesh that is converted, once."""
    if text not in mesh.notes:
        mesh._data = mesh._data.with_notes([*mesh.notes, text])


def tell(mesh: Mesh, package: str, lost: Iterable[str]) -> None:
    """Warns of data that a mesh of another package cannot store, and notes it on the mesh that is converted."""
    names = list(lost)
    if names:
        text = f"a mesh of {package} has no place for {', '.join(names)}"
        note(mesh, text)
        warnings.warn(text, stacklevel=3)


def triangles(mesh: Mesh, package: str) -> Mesh:
    """The triangles of a mesh; repairs that were made on the way are noted on it."""
    if mesh.is_triangular:
        return mesh
    made = mesh.triangulated()
    if mesh.repairs:
        repairs = ", ".join(f"{what}: {count}" for what, count in mesh.repairs.items())
        note(mesh, f"a mesh of {package} is of triangles, so polygons were cut and the mesh repaired: {repairs}")
    return made


def taken(data: Any, count: int, notes: list[str]) -> dict[str, NDArray[Any]]:
    """Foreign data with one row per element, as columns: vectors are split, ``v`` to ``v_x, v_y, v_z``."""
    import numpy as np

    found: dict[str, NDArray[Any]] = {}
    for name in list(data.keys()) if hasattr(data, "keys") else []:
        # Masked entries are kept, so that they are refused as everywhere.
        array = data[name] if np.ma.isMaskedArray(data[name]) else np.asarray(data[name])
        name = str(name)
        if len(array) != count or array.dtype.kind not in "fiub":
            notes.append(f"{name!r} was left out: {array.dtype} of shape {array.shape}")
            continue
        if array.ndim == 2 and array.shape[1] == 1:
            array = array[:, 0]
        if name in _COLORS and array.ndim == 2 and array.shape[1] in (3, 4):
            found["colors"] = array
        elif name in _NORMALS and array.ndim == 2 and array.shape[1] == 3:
            found["normals"] = array
        elif array.ndim == 1:
            other = _free(name, data) if name in _OWN else name
            found[other] = array
            if other != name:
                notes.append(f"the numbers {name!r} are called {other!r}: they are no {name}")
        else:
            rows = array.reshape(count, -1) if count else array.reshape(0, 1)
            width = rows.shape[1]
            ends = _AXES[:width] if 2 <= width <= 3 else [str(k) for k in range(width)]
            found |= {f"{name}_{end}": rows[:, k] for k, end in enumerate(ends)}
    return found


def _free(name: str, others: Iterable[str]) -> str:
    """A name for numbers that is not in use."""
    made = name + _VALUES
    while made in others:
        made += _VALUES
    return made


def owned(mesh: Mesh, of_faces: dict[str, NDArray[Any]], kept: Mapping[str, Any] | None, notes: list[str]) -> None:
    """Takes numbers as indices of groups and materials only if the mesh was written by this package.

    Numbers of others get another name. So do indices that belong to other groups: out of range, or in a mesh that has
    more vertices than the one that was written, since it was joined from several.
    """
    for name in ("groups", "materials"):
        values = of_faces.get(name)
        if values is None:
            continue
        known: list[Any] = kept[name] if kept else []
        is_whole = values.dtype.kind in "iu" or bool((values == values.round()).all())
        if kept and is_whole and mesh.vertex_count <= kept["vertices"] and len(values) and -1 <= values.min():
            if values.max() < len(known):
                continue
        other = _free(name, of_faces)
        of_faces[other] = of_faces.pop(name)
        text = f"the numbers {name!r} are called {other!r}, since no list of {name} belongs to them"
        if known:
            names = [each["name"] if name == "materials" else "/".join(filter(None, each)) for each in known]
            text += f", and the {name} {', '.join(map(repr, names))} were left out"
            setattr(mesh, name, [])
        notes.append(f"{text}; set mesh.{name} and mesh.face_data[{name!r}] if they are indices")


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
    """Columns of a mesh for other packages: ``v_x, v_y, v_z`` of one type become the vector ``v`` again."""
    import numpy as np

    columns = {name: data[name] for name in data if data[name].ndim == 1}
    found: dict[str, NDArray[Any]] = {}
    for name in columns:
        stem, _, end = name.rpartition("_")
        names = _components(stem, end, columns) if stem and stem not in _MEANT and stem not in columns else []
        if len({columns[part].dtype for part in names}) > 1:
            names = []
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

    Returns for each new vertex its original vertex and corner (-1 if no face uses it), and the new corners.
    """
    import numpy as np

    names = list(mesh.corner_data)
    corners = mesh.corners
    if not names:
        return np.arange(mesh.vertex_count), np.empty(0, np.int64), corners.copy()
    keys = np.column_stack([corners, *(mesh.corner_data[name].astype(np.float64) for name in names)])
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    # In the order of the vertices, so that a mesh without seams keeps its numbering.
    unused = np.setdiff1d(np.arange(mesh.vertex_count), corners)
    sources = np.concatenate([corners[first], unused])
    first = np.concatenate([first, np.full(len(unused), -1)])
    order = np.lexsort((first, sources))
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    return sources[order], first[order], place[np.asarray(inverse).ravel()]


def of_vertices(values: NDArray[Any], first: NDArray[Any]) -> NDArray[Any]:
    """Values of corners for the vertices that :func:`split` made; NaN for unused vertices."""
    import numpy as np

    found: NDArray[Any] = values[first]
    found[first < 0] = np.nan
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
    #: What only this package can read, as a text: see :func:`extras`.
    extras: str | None


def separate(source: Mesh, package: str, names: Sequence[str] = (), *, of: Mesh | None = None) -> Separate:
    """The data with split vertices. Colours are bytes, ``"colors"`` of points and of faces.

    `names` have a meaning in the package: numbers are renamed. `of` is the mesh itself if `source`, which gets the
    notes, had to be triangulated.
    """
    import numpy as np

    mesh = source if of is None else of

    sources, first, corners = split(mesh)
    of_points = {name: values[sources] for name, values in given(mesh.vertex_data).items()}
    of_faces = given(mesh.face_data)
    if "colors" in mesh.vertex_data:
        of_points["colors"] = in_bytes(mesh.vertex_data["colors"])[sources]
    if "colors" in mesh.face_data:
        of_faces["colors"] = in_bytes(mesh.face_data["colors"])
    normals = uvs = None
    if "normals" in mesh.corner_data:
        normals = of_vertices(mesh.corner_data["normals"], first)
    elif "normals" in mesh.vertex_data:
        normals = mesh.vertex_data["normals"][sources]
    if "uvs" in mesh.corner_data:
        uvs = of_vertices(mesh.corner_data["uvs"], first)
    for columns in (of_points, of_faces):
        for name in names:
            if name in columns:
                other = _free(name, columns)
                columns[other] = columns.pop(name)
                note(source, f"the numbers {name!r} are {other!r} in a mesh of {package}, where that name is taken")
    joins = mesh.joins
    is_split = len(sources) > mesh.vertex_count
    if is_split:
        if not joins and has_twins(mesh):
            note(source, f"in a mesh of {package} vertices at equal positions count as one, since some were split")
        joins = True
    ends = mesh.face_ends.astype(np.int64)
    is_needed = mesh.groups or mesh.materials or mesh.images or mesh.joins is not None or uvs is not None or is_split
    text = extras(mesh, len(sources), joins) if is_needed else None
    return Separate(mesh.vertices[sources], corners, ends, of_points, of_faces, normals, uvs, text)


def has_twins(mesh: Mesh) -> bool:
    """Whether several vertices are at one position."""
    import numpy as np

    return len(np.unique(mesh.vertices, axis=0)) < mesh.vertex_count


def extras(mesh: Mesh, vertices: int, joins: bool | None) -> str:
    """Groups, materials, images, joins and the number of vertices as a text."""
    images = [
        {**image, "data": b64encode(image["data"]).decode()} if "data" in image else image
        for image in mesh.images
    ]
    lists = {"groups": mesh.groups, "materials": mesh.materials, "images": images}
    return json.dumps({**lists, "joins": joins, "vertices": vertices})


def read_extras(text: Any) -> dict[str, Any] | None:
    """What :func:`extras` wrote; ``None`` for a text of another origin."""
    try:
        found = json.loads(text)
        return found if {"groups", "materials", "images", "joins", "vertices"} <= found.keys() else None
    except (AttributeError, TypeError, ValueError):
        return None


def with_extras(mesh: Mesh, kept: Mapping[str, Any]) -> None:
    """Restores the groups, materials, images and joins written by :func:`extras`."""
    mesh.groups = [(one, other) for one, other in kept["groups"]]
    mesh.images = [
        {**image, "data": b64decode(image["data"])} if "data" in image else image for image in kept["images"]
    ]
    mesh.materials = kept["materials"]
    if mesh.vertex_count <= kept["vertices"]:
        mesh._data = mesh._data.with_joins(kept["joins"])


def rejoined(mesh: Mesh, kept: Mapping[str, Any] | None) -> Mesh:
    """A mesh with texture coordinates for its vertices: they were split, unless this package wrote otherwise."""
    return mesh.joined(kept["joins"] if kept and mesh.vertex_count <= kept["vertices"] else True)


def image_of(pixels: Any, name: str, notes: list[str]) -> dict[str, Any] | None:
    """Pixels of an image, a picture of Pillow or an array; ``None`` if it cannot be stored, which is noted."""
    import io

    import numpy as np

    try:
        from PIL import Image
    except ImportError:
        notes.append("textures were left out: they need Pillow (pip install pillow)")
        return None
    if not hasattr(pixels, "save"):
        pixels = np.asarray(pixels)
        if pixels.dtype != np.uint8:
            scale = 1 / 257 if pixels.dtype == np.uint16 else 255
            notes.append(f"a texture of {pixels.dtype} was rounded to 8 bits")
            pixels = np.round(np.clip(np.nan_to_num(pixels * np.float64(scale)), 0, 255)).astype(np.uint8)
        pixels = Image.fromarray(pixels[..., 0] if pixels.ndim == 3 and pixels.shape[2] == 1 else pixels)
    written = io.BytesIO()
    if pixels.mode not in ("1", "L", "LA", "P", "RGB", "RGBA", "I", "I;16"):
        notes.append(f"a texture of mode {pixels.mode} was converted to RGB")
        pixels = pixels.convert("RGB")
    pixels.save(written, "PNG")
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
        if name == "colors" and any(row is None for row in rows):
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
