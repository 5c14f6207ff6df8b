"""Pictures, pages with interactive 3D views, and the display of meshes in notebooks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape
from typing import TYPE_CHECKING, Any, Union

from .. import _core
from .._call import Progress, calling
from .._errors import ArrayError, CurvmeshError, OptionError
from .._options import checked
from .._table import table
from .arrays import real_numbers
from .curvature import Curvature
from .files import as_mesh, deliver
from .info import info
from .mesh import Data, Mesh

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import ArrayLike, NDArray

    from .._options import File, Layout, On, Up

__all__ = ["Figure", "Page", "Picture", "figure", "render", "view"]

#: The name of data of vertices or faces, or an array with a value for each of them.
Values = Union[str, "ArrayLike", None]


class Picture:
    """A picture, displayed in notebooks.

    Attributes
    ----------
    png : bytes
        The file.
    pixels : ndarray of uint8, shape (height, width, 4)
        Red, green, blue, opacity.
    range : tuple of float or None
        The values at the ends of the colours; None for labels.
    """

    def __init__(
        self, png: bytes, pixels: NDArray[np.uint8], range: tuple[float, float] | None
    ) -> None:
        self.png = png
        self.pixels = pixels
        self.range = range

    def save(self, path: File) -> None:
        """Write the PNG file: to a path, or to an open binary file."""
        deliver(path, self.png, ".png")

    def __repr__(self) -> str:
        height, width, _ = self.pixels.shape
        return f"Picture({width} x {height})"

    def _repr_png_(self) -> bytes:
        return self.png


class Figure:
    """A picture as vectors, displayed in notebooks.

    Attributes
    ----------
    svg : str
        The file.
    size : (int, int)
        Width and height in pixels, with the legend.
    faces : int
        The number of faces in the file: those that are seen.
    range : tuple of float or None
        The values at the ends of the colours; None for labels.
    """

    def __init__(
        self, svg: str, size: tuple[int, int], faces: int, range: tuple[float, float] | None
    ) -> None:
        self.svg = svg
        self.size = size
        self.faces = faces
        self.range = range

    def save(self, path: File) -> None:
        """Write the SVG file: to a path, or to an open binary file."""
        deliver(path, self.svg.encode(), ".svg")

    def __repr__(self) -> str:
        width, height = self.size
        return f"Figure({width} x {height}, {self.faces} faces)"

    def _repr_svg_(self) -> str:
        return self.svg


class Page:
    """A page with interactive 3D views of meshes, displayed in notebooks.

    Attributes
    ----------
    html : str
        The whole page, which opens offline.
    height : int
        Its height in a notebook, in pixels.
    """

    def __init__(self, html: str, height: int) -> None:
        self.html = html
        self.height = height

    def save(self, path: File) -> None:
        """Write the page as one HTML file: to a path, or to an open binary file."""
        deliver(path, self.html.encode(), ".html", ".htm")

    def open(self) -> None:
        """Show the page in the browser."""
        import tempfile
        import webbrowser
        from pathlib import Path

        path = Path(tempfile.mkdtemp(prefix="curvmesh-")) / "view.html"
        self.save(path)
        webbrowser.open(path.as_uri())

    def __repr__(self) -> str:
        return f"Page({len(self.html) / 1e6:.1f} MB)"

    def _repr_html_(self) -> str:
        # The page is in its own frame, isolated from the notebook. It is encoded in ASCII, so that its hashes
        # stay valid for any encoding of the notebook.
        page = escape(self.html).encode("ascii", "xmlcharrefreplace").decode()
        return (
            f'<iframe srcdoc="{page}" width="100%" height="{self.height}" '
            'sandbox="allow-scripts allow-downloads" style="border:0"></iframe>'
        )


def _shown(
    mesh: Mesh, values: Values, on: On | None
) -> tuple[On, NDArray[np.float64], bool]:
    """Values, whether they belong to vertices or faces, inferred only if unambiguous, and whether they are labels."""
    import numpy as np

    if isinstance(values, str):
        named = {kind: data for kind, data in _data_of(mesh) if data.get(values) is not None}
        found = [kind for kind, data in named.items() if data[values].ndim == 1 and on in (None, kind)]
        if not found:
            names = sorted({name for _, data in _data_of(mesh) for name in data if data[name].ndim == 1})
            raise OptionError(f"there is no data {values!r}; there are {names or 'none'}")
        if len(found) > 1:
            raise OptionError(f'vertices and faces have {values!r}; say on="vertex" or on="face"')
        array = named[found[0]][values]
        return found[0], np.require(array, np.float64, "A"), _are_labels(array)
    labels = _are_labels(values)
    if np.ma.isMaskedArray(values):
        values = np.ma.filled(np.ma.asarray(values, np.float64), np.nan)
    array = np.require(real_numbers("values", values), np.float64, "A")
    if array.ndim != 1:
        raise ArrayError(f"values have the shape {array.shape}; give one for each vertex or face")
    counts: dict[On, int] = {"vertex": mesh.vertex_count, "face": mesh.face_count}
    fitting = [kind for kind, count in counts.items() if count == len(array)]
    if on is None and len(fitting) > 1:
        message = f'there are {len(array)} vertices and as many faces; say on="vertex" or on="face"'
        raise OptionError(message)
    if not fitting or on not in (None, *fitting):
        expected = f"one for each {on}" if on else "one for each vertex or for each face"
        raise ArrayError(
            f"there are {len(array)} values, but {mesh.vertex_count} vertices and {mesh.face_count} faces; "
            f"give {expected}"
        )
    return on or fitting[0], array, labels


def _asked(
    mesh: Any, values: Values, on: On | None, **style: Any
) -> tuple[Mesh, tuple[On, NDArray[np.float64], bool] | None, dict[str, Any]]:
    """The mesh, the values shown as colours, and the style as the library takes it."""
    given, shown = as_mesh(mesh), None
    if values is not None:
        kind, array, labels = _shown(given, values, on)
        # Who names a scale of colours wants amounts.
        is_scaled = style["colormap"] is not None or style["range"] != "auto" or style["log"]
        shown = (kind, array, labels and not is_scaled)
    direction = style["direction"]
    if direction is not None:
        style["direction"] = [direction] if isinstance(direction, str) else list(direction)
    up = style["up"]
    style["up"], style["size"] = up if isinstance(up, str) else list(up), list(style["size"])
    style["name"] = values if isinstance(values, str) else ""
    style["range"] = _range(style["range"])
    return given, shown, style


def _are_labels(values: Any) -> bool:
    """Whether values are integers that can be told apart as 64-bit numbers."""
    import numpy as np

    # The data of a masked array, whose mask marks missing values.
    array = np.asarray(np.ma.getdata(values))
    if array.dtype.kind not in "iub":
        return False
    return array.size == 0 or (int(array.max()) <= 2**53 and int(array.min()) >= -(2**53))


def _data_of(mesh: Mesh) -> list[tuple[On, Data]]:
    return [("vertex", mesh.vertex_data), ("face", mesh.face_data)]


def _range(range: str | tuple[float, float]) -> str:
    return range if isinstance(range, str) else f"{range[0]!r},{range[1]!r}"


@checked
def render(
    mesh: Any,
    values: Values = None,
    *,
    on: On | None = None,
    direction: str | Sequence[str] | Sequence[float] | None = None,
    up: Up | Sequence[float] = "auto",
    size: tuple[int, int] = (900, 900),
    edges: float = 0.0,
    outlines: float = 0.0,
    crease: float | None = None,
    smooth: bool = False,
    plain: bool = False,
    colormap: str | None = None,
    range: str | tuple[float, float] = "auto",
    log: bool = False,
    bar: bool = True,
    label: str = "",
    occlusion: float = 0.0,
    transparent: bool = False,
    supersampling: int = 2,
    threads: int | None = None,
) -> Picture:
    """Draw a mesh, without a display.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`; an oriented manifold.
    values : str or array_like, optional
        The values shown as colours: the name of data of the mesh, or a number for each vertex or each face. By
        default the mesh has its own colours or materials. Integers are labels: each different value has a colour
        of its own, unless `colormap`, `range` or `log` is given.
    on : str, optional
        Whether `values` belong to each ``"vertex"`` or each ``"face"``; required if both counts are equal, or
        both have data of that name.
    direction : sequence of float, str or sequence of str, optional
        From the model to the camera; or a side (``"front"``, ``"back"``, ``"left"``, ``"right"``,
        ``"top"``, ``"bottom"``, ``"corner"``), several of which make a sheet. By default from the front, a little
        from the right and above: (0.4, 0.3, 1) if y is up.
    up : str or sequence of float
        The direction of the model that is up in the picture: ``"x"``, ``"y"``, ``"z"``, ``"-x"``, ``"-y"``,
        ``"-z"``, three numbers, or ``"auto"``, which finds it from the shape as :func:`view` does. Sides and the
        default of `direction` turn with an axis; sides do not take three numbers.
    size : (int, int)
        Width and height in pixels.
    edges, outlines : float
        The width of edges and outlines in pixels; 0 draws none.
    crease : float, optional
        If outlines are drawn, also draw edges whose faces meet at a larger angle than this, in degrees.
    smooth : bool
        Shade with one normal per vertex.
    plain : bool
        Leave out colours and materials.
    colormap : str, optional
        ``"viridis"``, ``"red-blue"``, ...; the default depends on the values.
    range : str or (float, float)
        The values at the ends of the colours: ``"auto"`` leaves out the outer 2 %, ``"full"`` nothing,
        ``"5%,95%"`` are percentiles.
    log : bool
        Whether equal steps of colour are equal ratios.
    bar : bool
        Whether to draw a legend beside the picture, if there are values.
    label : str
        The title of the legend; by default the name of the data, with the unit of curvatures.
    occlusion : float
        How much darker cavities and creases are (ambient occlusion), from 0 to 1.
    transparent : bool
        Make the background transparent.
    supersampling : int
        Samples per pixel and direction, from 1 to 8.

    Returns
    -------
    Picture

    Examples
    --------
    >>> import curvmesh as cm
    >>> torus = cm.shapes.torus()
    >>> cm.render(torus, cm.curvature(torus).mean, label="H", size=(300, 200))  # doctest: +ELLIPSIS
    Picture(... x 200)
    """
    given, shown, style = _asked(
        mesh,
        values,
        on,
        direction=direction,
        up=up,
        size=size,
        edges=edges,
        outlines=outlines,
        crease=crease,
        smooth=smooth,
        occlusion=occlusion,
        transparent=transparent,
        supersampling=supersampling,
        plain=plain,
        label=label,
        colormap=colormap,
        range=range,
        log=log,
        bar=bar,
    )
    with calling("drawing", None, threads) as call:
        png, pixels, ends = _core.render(call, given._data, shown, style)
    return Picture(png, pixels, None if ends is None else (ends[0], ends[1]))


@checked
def figure(
    mesh: Any,
    values: Values = None,
    *,
    on: On | None = None,
    direction: str | Sequence[float] | None = None,
    up: Up | Sequence[float] = "auto",
    size: tuple[int, int] = (900, 900),
    edges: float = 0.0,
    outlines: float = 0.0,
    crease: float | None = None,
    smooth: bool = False,
    plain: bool = False,
    colormap: str | None = None,
    range: str | tuple[float, float] = "auto",
    log: bool = False,
    bar: bool = True,
    label: str = "",
    supersampling: int = 2,
    threads: int | None = None,
) -> Figure:
    """Draw a mesh as vectors, for figures of papers: an SVG file with a transparent background.

    It has the faces that are seen, each in the colour of its middle, edges, outlines and the legend. Faces are
    drawn from the farthest to the nearest; if faces pass through each other, the order can be wrong.

    Parameters
    ----------
    mesh, values, on, up, size, edges, outlines, crease, smooth, plain, colormap, range, log, bar, label
        As for :func:`render`.
    direction : sequence of float or str, optional
        From the model to the camera, or one side; by default as in :func:`render`.
    supersampling : int
        Samples per pixel and direction, from 1 to 8, that decide which faces are seen.

    Returns
    -------
    Figure

    Examples
    --------
    >>> import curvmesh as cm
    >>> cm.figure(cm.shapes.cube(), direction="corner", edges=1, size=(300, 200))
    Figure(300 x 200, 6 faces)
    """
    given, shown, style = _asked(
        mesh,
        values,
        on,
        direction=direction,
        up=up,
        size=size,
        edges=edges,
        outlines=outlines,
        crease=crease,
        smooth=smooth,
        occlusion=0.0,
        transparent=True,
        supersampling=supersampling,
        plain=plain,
        label=label,
        colormap=colormap,
        range=range,
        log=log,
        bar=bar,
    )
    with calling("drawing", None, threads) as call:
        svg, extent, faces, ends = _core.figure(call, given._data, shown, style)
    return Figure(svg, (extent[0], extent[1]), faces, None if ends is None else (ends[0], ends[1]))


@checked
def view(
    *meshes: Any,
    names: Sequence[str] | None = None,
    values: Mapping[str, Any] | Sequence[Mapping[str, Any]] | None = None,
    on: On | None = None,
    directions: bool = False,
    color: str | None = None,
    colormap: str | None = None,
    range: tuple[float, float] | None = None,
    layout: Layout = "side",
    up: Up = "auto",
    smooth: bool | None = None,
    edges: bool | None = None,
    title: str | None = None,
    report: Mapping[str, object] | None = None,
    exact_positions: bool = False,
    most_faces: int = 1_500_000,
    height: int = 640,
    progress: Progress = None,
    threads: int | None = None,
) -> Page:
    """Make a page with interactive 3D views: in a notebook cell, or as one file that opens offline.

    It has flat and smooth shading, edges, materials, any data as colours with an adjustable range, the value
    under the pointer, and boundaries and defects as lines. Several meshes share one camera, side by side, one
    over the other or alternating.

    Parameters
    ----------
    *meshes : mesh-like
        The meshes to show, including polygons and defects; or a :class:`curvmesh.Curvature`, with all its
        quantities and directions.
    names : sequence of str, optional
        The names of the meshes.
    values : mapping or sequence of mappings, optional
        Further numbers by name for each vertex or face: of all meshes, or one mapping for each. Integers are
        labels: each different value has a colour of its own, unless `colormap` or `range` is given.
    on : str, optional
        Whether `values` belong to each ``"vertex"`` or each ``"face"``; required if both counts are equal.
    directions : bool
        Whether principal directions of the vertices are computed and shown on demand.
    color : str, optional
        The data initially shown as colours: a name, ``"component"`` if a mesh has several, or ``"plain"``.
    colormap, range
        As for :func:`render`; both can be changed on the page.
    layout : str
        ``"side"`` by side, ``"wipe"``, ``"blink"``, or ``"one"`` at a time.
    up : str
        The axis that points up at first: ``"x"``, ``"y"``, ``"z"``, ``"-x"``, ``"-y"``, ``"-z"``. With
        ``"auto"``, it is the seen side of sheets such as terrain, z for surveys, and y otherwise.
    smooth, edges : bool, optional
        The initial appearance of meshes; the default depends on their size.
    title : str, optional
        The title of the page.
    report : mapping, optional
        Names and values for the side panel.
    exact_positions : bool
        Keep positions as 32-bit numbers, not in 65,536 steps along each side.
    most_faces : int
        Meshes with more faces are shown simplified, with a note.
    height : int
        The height in a notebook, in pixels.

    Returns
    -------
    Page
        Displayed in notebooks; ``.save("page.html")`` writes it, ``.open()`` opens a browser.

    Examples
    --------
    >>> import curvmesh as cm
    >>> torus = cm.shapes.torus()
    >>> page = cm.view(torus, cm.flip(torus).mesh, names=["before", "after"], edges=True)
    >>> page.html.startswith("<!DOCTYPE html>") or page.html[:15]
    True
    """
    if not meshes:
        raise OptionError("give a mesh to show")
    if names is not None and len(names) != len(meshes):
        raise OptionError(f"there are {len(names)} names for {len(meshes)} meshes")
    if values is None or isinstance(values, Mapping):
        of_each: list[Mapping[str, Any]] = [values or {}] * len(meshes)
    else:
        of_each = [] if isinstance(values, str) else list(values)
        if isinstance(values, str) or not all(isinstance(each, Mapping) for each in of_each):
            raise OptionError(
                f"values is {values!r}; it must be a mapping of names to numbers, like {{'H': k.mean}}; "
                'color="name" selects data of the mesh'
            )
    if len(of_each) != len(meshes):
        raise OptionError(f"there are {len(of_each)} mappings of values for {len(meshes)} meshes")
    exhibits = []
    for number, (thing, more) in enumerate(zip(meshes, of_each)):
        arrows: Any = None
        fields: dict[str, tuple[On, NDArray[np.float64], bool]] = {}
        if isinstance(thing, Curvature):
            mesh = thing.mesh
            shown = ("mean", "gaussian", "k1", "k2", "shape_index", "curvedness")
            fields = {name: (thing.on, thing[name], False) for name in shown}
            if thing.on == "vertex":
                arrows = thing.directions
            if color is None:
                color = "mean"
        else:
            mesh = as_mesh(thing, check=False)
        if directions and arrows is None:
            arrows = _core.principal_directions(_core.Call(None, None, threads, False), mesh._data)
        fields |= {name: _shown(mesh, array, on) for name, array in more.items()}
        exhibits.append(
            {
                "name": names[number] if names is not None else _name(thing, number, len(meshes)),
                "mesh": mesh._data,
                "values": list(fields.items()),
                "directions": arrows,
            }
        )
    rows = [(name, str(value)) for name, value in (report or {}).items()]
    page = {
        "title": title or ", ".join(str(exhibit["name"]) for exhibit in exhibits),
        "layout": layout,
        "up": up,
        "color": color,
        "colormap": colormap,
        "range": None if range is None else list(range),
        "smooth": smooth,
        "edges": edges,
        "exact_positions": exact_positions,
        "most_faces": most_faces,
        "report": [("Report", rows)] if rows else [],
    }
    with calling("page", progress, threads) as call:
        return Page(_core.page(call, exhibits, page), height)


def _name(thing: Any, number: int, count: int) -> str:
    import os

    if isinstance(thing, (str, os.PathLike)):
        return os.path.basename(os.fspath(thing))
    return "mesh" if count == 1 else f"mesh {number + 1}"


def card(mesh: Mesh) -> str:
    """The display of a mesh in a notebook: a picture, counts, defects."""
    import base64

    found = info(mesh)
    rows: list[tuple[str, object]] = [
        (name.replace("_", " "), found[name])
        for name in ("vertices", "faces", "edges", "components", "boundary_loops", "euler_characteristic")
    ]
    rows.append(("closed", found.closed))
    rows += [(f"defect: {name.replace('_', ' ')}", count) for name, count in found.defects.items()]
    if found.repairs:
        rows.append(("repair", ", ".join(f"{name}=True" for name in found.repairs)))
    data = [*mesh.vertex_data, *mesh.corner_data, *mesh.face_data]
    if data:
        rows.append(("data", ", ".join(dict.fromkeys(data))))
    try:
        picture = render(mesh, size=(360, 300), smooth=mesh.face_count > 20_000)
        image = base64.b64encode(picture.png).decode()
        shown = f'<img width="360" height="300" src="data:image/png;base64,{image}"/>'
    except CurvmeshError:
        # A mesh that no repair can draw has counts, but no picture.
        shown = ""
    return f'<div style="display:flex;gap:1em;align-items:center">{shown}{table("Mesh", rows)}</div>'
