"""glTF scenes that are kept whole, their simplification and their levels of detail."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, overload

from .. import _core
from .._call import Callback, Progress, calling, plain
from .._errors import CurvmeshError, OptionError
from .._options import checked, whole
from .._table import grid, table, text
from .files import _write_to, file_content
from .mesh import Mesh
from .simplify import Charts, ErrorBounds, Shortfall, _choices, _rules, _shortfall

if TYPE_CHECKING:
    from .._options import Compress, External, File, Length, Norm, Per, Placement, Preset, SceneFormat

__all__ = [
    "MeshOfLevel",
    "MeshOfScene",
    "PoseErrors",
    "Scene",
    "SceneLevel",
    "SceneLevels",
    "SimplifiedScene",
    "lod_scene",
    "read_scene",
    "simplify_scene",
    "write_scene",
]


def _title(name: str | None, mesh: int) -> str:
    return f"mesh {mesh}" if name is None else name


class Scene:
    """A glTF or GLB document, kept whole: nodes, materials, skins, animations, cameras, extensions, extras.

    Made by :func:`read_scene`. It never changes: :func:`simplify_scene` and :func:`lod_scene` return new scenes.
    Scenes are equal if they are written as the same bytes. Every function that takes a mesh takes a scene too, as
    its :meth:`mesh`.
    """

    __slots__ = ("__weakref__", "_data")
    _data: _core.SceneData

    def __init__(self) -> None:
        raise TypeError("a scene comes from a file: curvmesh.read_scene(path)")

    @classmethod
    def _of(cls, data: _core.SceneData) -> Scene:
        made = cls.__new__(cls)
        made._data = data
        return made

    @property
    def nodes(self) -> list[str | None]:
        """The name of each node, in the order of the document; ``None`` for a node without one."""
        return self._data.names("nodes")

    @property
    def meshes(self) -> list[str | None]:
        """The name of each mesh."""
        return self._data.names("meshes")

    @property
    def materials(self) -> list[str | None]:
        """The name of each material."""
        return self._data.names("materials")

    @property
    def animations(self) -> list[str | None]:
        """The name of each animation."""
        return self._data.names("animations")

    @property
    def skins(self) -> list[str | None]:
        """The name of each skin."""
        return self._data.names("skins")

    @property
    def cameras(self) -> list[str | None]:
        """The name of each camera."""
        return self._data.names("cameras")

    @property
    def extensions(self) -> list[str]:
        """The names of the extensions in use."""
        return [name for name in self._data.names("extensionsUsed") if name is not None]

    @property
    def vertex_count(self) -> int:
        """Number of vertices that the default scene draws, as they are stored."""
        return self._data.counts[0]

    @property
    def face_count(self) -> int:
        """Number of triangles that the default scene draws. A mesh that two nodes draw counts twice."""
        return self._data.counts[1]

    @property
    def document(self) -> dict[str, Any]:
        """A copy of the JSON of the document. The bytes of its buffers are not in it."""
        import json

        found: dict[str, Any] = json.loads(self._data.json())
        return found

    @property
    def notes(self) -> list[str]:
        """Messages of the reader: losses and assumptions."""
        return self._data.notes

    @property
    def lost(self) -> list[str]:
        """Content of the file that is not in the scene, with the reason."""
        return self._data.lost

    def mesh(self, *, join: bool | None = None) -> Mesh:
        """All meshes as the default scene draws them, in one mesh, as :func:`read` reads the file.

        Parameters
        ----------
        join : bool, optional
            As for :func:`read`.

        Returns
        -------
        Mesh
            Positions in units of the scene, shape (:attr:`vertex_count`, 3).
        """
        return Mesh._of(_core.scene_mesh(plain(), self._data, join))

    def to_bytes(self, format: SceneFormat = "glb") -> bytes:
        """The content of a file with this scene: ``"glb"`` or ``"gltf"``, in which the buffer is text."""
        return _core.scene_bytes(plain(), self._data, format)

    def write(self, path: File, **options: Any) -> dict[str, Any]:
        """Write the scene; :func:`write_scene` as a method."""
        return write_scene(path, self, **options)

    save = write

    def simplify(self, **options: Any) -> SimplifiedScene:
        """Simplify the meshes; :func:`simplify_scene` as a method."""
        return simplify_scene(self, **options)

    def lod(self, **options: Any) -> SceneLevels:
        """Make levels of detail; :func:`lod_scene` as a method."""
        return lod_scene(self, **options)

    def copy(self) -> Scene:
        """The same scene. The content never changes, so it is shared."""
        return Scene._of(self._data)

    def _rows(self) -> list[tuple[str, object]]:
        kinds = ("nodes", "meshes", "materials", "animations", "skins", "cameras")
        rows: list[tuple[str, object]] = [(kind, len(getattr(self, kind))) for kind in kinds]
        rows += [("drawn vertices", self.vertex_count), ("drawn faces", self.face_count)]
        return [*rows, ("extensions", self.extensions)] if self.extensions else rows

    def __repr__(self) -> str:
        def some(count: int, one: str, more: str) -> str:
            return f"{count} {one if count == 1 else more}"

        parts = [
            some(len(self.nodes), "node", "nodes"),
            some(len(self.meshes), "mesh", "meshes"),
            some(self.face_count, "drawn face", "drawn faces"),
        ]
        for kind in ("materials", "animations", "skins", "cameras"):
            if count := len(getattr(self, kind)):
                parts.append(some(count, kind[:-1], kind))
        return f"Scene({', '.join(parts)})"

    def _repr_html_(self) -> str:
        return table("Scene", self._rows())

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Scene):
            return NotImplemented
        return self._data is other._data or self._data.equals(other._data)

    __hash__ = object.__hash__

    def __copy__(self) -> Scene:
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        data = self._data
        limits = (data.max_memory, data.allow_empty)
        return _restored, (_core.VERSION, self.to_bytes(), data.notes, data.lost, *limits)


def _restored(
    version: str,
    content: bytes,
    notes: list[str],
    lost: list[str],
    max_memory: int | None,
    allow_empty: bool,
) -> Scene:
    """A scene from its pickle."""
    if version != _core.VERSION:
        message = f"the scene was pickled by curvmesh {version}; this is {_core.VERSION}"
        raise CurvmeshError(message, cure="exchange scenes between versions as files: scene.save(path)")
    return Scene._of(_core.SceneData.load(content, notes, lost, max_memory, allow_empty))


def _scene(given: Any) -> Scene:
    """A scene, the scene of a result, or one from a file."""
    if isinstance(given, Scene):
        return given
    inside = getattr(given, "scene", None)
    if isinstance(inside, Scene):
        return inside
    if isinstance(given, (str, os.PathLike)) or hasattr(given, "read"):
        return read_scene(given)
    raise OptionError(
        f"a {type(given).__name__} is no scene; give a curvmesh.Scene, or the path of a glTF or GLB file"
    )


@checked
def read_scene(
    source: File | bytes,
    *,
    format: SceneFormat | None = None,
    external: External = "folder",
    max_memory: int | None = None,
    allow_empty: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> Scene:
    """Read a scene, glTF or GLB, and keep it whole.

    Untrusted files are safe to read, as with :func:`read`.

    Parameters
    ----------
    source : path, bytes or binary file
        The file, its content, or an open file. Buffers in files of their own are found only with a path.
    format : str, optional
        ``"gltf"`` or ``"glb"``; detected from the content by default.
    external : str
        Which of the files that it refers to are read: ``"none"``, those in its ``"folder"`` and below, or
        ``"any"``. Images in files of their own are not read; their names stay.
    max_memory : int, optional
        The most bytes that reading may allocate; by default 64 MiB and 60 times the size of the file.
    allow_empty : bool
        Read a file that draws nothing; otherwise this is an error.

    Returns
    -------
    Scene

    Raises
    ------
    ReadError
        The file cannot be read, or is no glTF file; the error has the place and what was expected. A missing
        file is a ``FileNotFoundError`` too.

    Examples
    --------
    >>> import curvmesh as cm, io
    >>> file = io.BytesIO()
    >>> _ = cm.write(file, cm.shapes.sphere(3), format="glb")
    >>> scene = cm.read_scene(file.getvalue())
    >>> scene
    Scene(1 node, 1 mesh, 1280 drawn faces)
    """
    options: dict[str, Any] = {
        "format": format,
        "external": external,
        "max_memory": max_memory,
        "allow_empty": allow_empty,
    }
    with calling("reading", progress, threads) as call:
        if not isinstance(source, (str, os.PathLike)):
            return Scene._of(_core.read_scene(call, None, file_content(source), **options))
        return Scene._of(_core.read_scene(call, os.fspath(source), None, **options))


@checked
def write_scene(
    path: File,
    scene: Any,
    *,
    format: SceneFormat | None = None,
    compress: Compress = "none",
    quantize: bool | int = False,
    progress: Progress = None,
    threads: int | None = None,
) -> dict[str, Any]:
    """Write a scene: the file is replaced as a whole or not at all. All buffers become one, in the file itself.

    Parameters
    ----------
    path : path or binary file
        The file; its extension is the format unless `format` is given. An open file needs `format`.
    scene : Scene
        A scene, or a result with a ``scene``.
    format : str, optional
        ``"gltf"`` or ``"glb"``.
    compress : str
        ``"meshopt"`` compresses the data (``EXT_meshopt_compression``). All values stay the same.
    quantize : bool or int
        Round the data of vertices to integers (``KHR_mesh_quantization``): positions and texture coordinates of
        16 bits, or of the given number of bits, from 8 to 16; normals, tangents, colours and weights of 8 bits.

    Returns
    -------
    dict
        As of :func:`write`. With `quantize`, ``rounding`` is the largest distance by which a vertex moves, in units
        of the scene, and ``stayed`` lists what could not be rounded, with the reason, if anything.

    Raises
    ------
    WriteError
        The file cannot be written, or its format holds no scenes. A missing folder is a ``FileNotFoundError``
        too.
    """
    data = _scene(scene)._data
    options: dict[str, Any] = {"format": format, "compress": compress, "quantize": _bits(quantize)}
    with calling("writing", progress, threads) as call:
        if isinstance(path, (str, os.PathLike)):
            return _core.write_scene(call, os.fspath(path), data, **options)
        return _write_to(path, lambda inside: _core.write_scene(call, inside, data, **options), format)


def _bits(quantize: bool | int) -> int | None:
    """The number of bits to which data are rounded, if they are."""
    if isinstance(quantize, bool):
        return 16 if quantize else None
    bits = whole("quantize", quantize)
    if not 8 <= bits <= 16:
        raise OptionError(f"quantize={bits}: the number of bits is from 8 to 16")
    return bits


@dataclass(frozen=True)
class PoseErrors:
    """Errors of a mesh that deforms: the number of poses, and the root mean square and the largest distance."""

    count: int
    rms: float
    max: float


@dataclass(frozen=True)
class MeshOfScene:
    """A simplified mesh of a scene. Distances are in units of the scene, where the mesh is drawn largest.

    Attributes
    ----------
    mesh : int
        Its index in the document. Meshes without triangles are not listed.
    name : str or None
        Its name, or the name of the first node that draws it.
    times : int
        How many times the default scene draws it.
    scale : float
        The largest factor by which a length grows where it is drawn.
    faces_in, faces_out : int
        Numbers of faces before and after, of the mesh itself.
    vertices_out : int
        Number of vertices after, split vertices joined.
    rms, max : float
        The root mean square and the largest distance between samples of the input and the result.
    error : ErrorBounds or None
        The proved distance, if requested.
    stop : str
        Why it stopped, as in :class:`Simplified`.
    shortfall : Shortfall or None
        The target that was not reached, and the reasons.
    charts : Charts or None
        The charts before and after, if some were merged.
    poses : PoseErrors or None
        The errors in other poses, if the mesh deforms.
    """

    mesh: int
    name: str | None
    times: int
    scale: float
    faces_in: int
    faces_out: int
    vertices_out: int
    rms: float
    max: float
    error: ErrorBounds | None
    stop: str
    shortfall: Shortfall | None
    charts: Charts | None
    poses: PoseErrors | None

    @staticmethod
    def _of(told: dict[str, Any]) -> MeshOfScene:
        error, charts, poses = told["error"], told["charts"], told["poses"]
        made = {
            "error": None if error is None else ErrorBounds(*error),
            "charts": None if charts is None else Charts(*charts),
            "poses": None if poses is None else PoseErrors(*poses),
            "shortfall": _shortfall(told["shortfall"]),
        }
        return MeshOfScene(**{**told, **made})

    def _notes(self) -> list[str]:
        title, notes = _title(self.name, self.mesh), []
        if self.charts is not None:
            before, after = self.charts
            notes.append(f"{title}: {before} charts became {after}; keep_seams=True keeps them")
        if self.shortfall is not None:
            held = "; ".join(f"{reason}: {count}" for reason, count in self.shortfall.held_by.items())
            wanted = f"the target of {self.shortfall.wanted_faces} faces was not reached"
            notes.append(f"{title}: {wanted}: {self.faces_out} are left" + (f" ({held})" if held else ""))
        return notes


@dataclass(frozen=True, repr=False)
class SimplifiedScene:
    """A simplified scene and a report.

    Attributes
    ----------
    scene : Scene
        The result.
    meshes : list of MeshOfScene
        The meshes with triangles, in the order of the document, with their faces and errors.
    faces_in, faces_out : int
        Numbers of faces that are drawn, before and after. A mesh that two nodes draw counts twice.
    lost : list of str
        What the simplification left out, with the reason.
    notes : list of str
        Merged charts, and targets that were not reached.
    repairs : dict
        Number of repairs of each kind that meshes needed.
    """

    scene: Scene
    meshes: list[MeshOfScene]
    faces_in: int
    faces_out: int
    lost: list[str]
    notes: list[str]
    repairs: dict[str, int]

    def _lines(self) -> list[tuple[str, object]]:
        rows: list[tuple[str, object]] = [("faces", f"{self.faces_in} -> {self.faces_out}")]
        for mesh in self.meshes:
            faces = f"{mesh.faces_in} -> {mesh.faces_out} faces, largest distance {mesh.max:.3g}"
            rows.append((_title(mesh.name, mesh.mesh), faces))
        return [*rows, *(("lost", lost) for lost in self.lost), *(("note", note) for note in self.notes)]

    def __repr__(self) -> str:
        return text("SimplifiedScene", self._lines())

    def _repr_html_(self) -> str:
        return table("SimplifiedScene", self._lines())


@checked
def simplify_scene(
    scene: Any,
    *,
    faces: int | None = None,
    ratio: float | None = None,
    max_error: Length | None = None,
    relative: bool = False,
    per: Per = "scene",
    poses: int = 8,
    preset: Preset = "default",
    placement: Placement | None = None,
    curvature_weight: float | None = None,
    fit_rounds: int | None = None,
    norm: Norm | None = None,
    anneal_time: float | None = None,
    lock_boundary: bool = False,
    feature_angle: float | None = None,
    no_intersections: bool = False,
    components: str | int = "free",
    verify: bool = False,
    seed: int = 1,
    attribute_weight: float = 0.3,
    normal_weight: float = 0.0,
    crease_angle: float = 40.0,
    keep_creases: bool = False,
    keep_seams: bool = False,
    progress: Progress = None,
    callback: Callback | None = None,
    keep_partial: bool = False,
    threads: int | None = None,
) -> SimplifiedScene:
    """Simplify the meshes of a scene, and keep everything else as it is.

    Each mesh is simplified once, however many nodes draw it. All data of its vertices come along: texture
    coordinates, colours, normals, tangents, joints and weights, morph targets, custom attributes.

    Parameters
    ----------
    scene : Scene
        A scene, or the path of a glTF or GLB file.
    faces : int, optional
        Stop at this number of drawn faces of the whole scene.
    ratio : float, optional
        Stop at this share of the faces, from 0 to 1.
    max_error : float or str, optional
        Stay within this distance of the input: a length in units of the scene, or ``"0.2%"`` of the diagonal of
        its bounding box.
    relative : bool
        Whether a number for `max_error` is a share of the diagonal.
    per : str
        Whether targets are for the whole ``"scene"``, whose faces are divided so that the error is least, for
        each ``"mesh"``, or for each ``"node"`` that draws a mesh. Nodes share a mesh unless their results differ.
    poses : int
        The number of poses in which the errors of a mesh with a skin or morph targets count, besides the pose of
        the file. They are the shapes that differ most: morph targets, key frames of animations.
    callback : callable, optional
        As for :func:`simplify`. ``faces`` and ``steps`` are those of the mesh at work.
    keep_partial : bool
        Whether Ctrl-C ends the run with what is done so far instead of an exception.

    The other parameters are described in :func:`simplify`.

    Returns
    -------
    SimplifiedScene
        The same result as of ``curvmesh simplify in.glb -o out.glb``, to the last bit.

    Raises
    ------
    OptionError
        No target is given, or an option is invalid.
    ReadError
        The data of a mesh exist only in a compressed form.
    CannotBeDoneError
        The scene has no triangles.

    Examples
    --------
    >>> import curvmesh as cm, io
    >>> file = io.BytesIO()
    >>> _ = cm.write(file, cm.shapes.sphere(3), format="glb")
    >>> small = cm.simplify_scene(cm.read_scene(file.getvalue()), ratio=0.25)
    >>> small.faces_in, small.faces_out, small.scene.face_count
    (1280, 320, 320)
    """
    targets = {"faces": faces, "ratio": ratio, "max_error": max_error, "relative": relative}
    if faces is None and ratio is None and max_error is None:
        raise OptionError("say when to stop: faces=, ratio= or max_error=")
    choices = _choices(
        preset,
        placement,
        curvature_weight,
        fit_rounds,
        norm,
        anneal_time,
        lock_boundary,
        feature_angle,
        no_intersections,
        components,
        verify,
        seed,
    )
    rules = {
        "choices": choices,
        "attributes": _rules(attribute_weight, normal_weight, crease_angle, keep_creases, True),
        "keep_seams": keep_seams,
        "per": per,
        "poses": whole("poses", poses),
    }
    data = _scene(scene)._data
    with calling("simplifying", progress, threads, callback, keep_partial) as call:
        made, told = _core.simplify_scene(call, data, targets, rules)
    meshes = [MeshOfScene._of(mesh) for mesh in told["meshes"]]
    faces_out = sum(mesh.times * mesh.faces_out for mesh in meshes)
    notes = [note for mesh in meshes for note in mesh._notes()]
    if told["missed_faces"] is not None:
        notes.append(f"the target of {told['missed_faces']} faces was not reached: {faces_out} are left")
    return SimplifiedScene(
        scene=Scene._of(made),
        meshes=meshes,
        faces_in=sum(mesh.times * mesh.faces_in for mesh in meshes),
        faces_out=faces_out,
        lost=told["lost"],
        notes=notes,
        repairs=told["repairs"],
    )


@dataclass(frozen=True)
class MeshOfLevel:
    """A mesh in a level of detail. Distances are in units of the scene, where the mesh is drawn largest.

    Attributes
    ----------
    mesh : int
        Its index in the document.
    name : str or None
        Its name, or the name of the first node that draws it.
    times : int
        How many times the default scene draws it.
    faces, vertices : int
        Counts of the mesh itself, split vertices joined.
    collapses : int
        Number of collapses that lead to it.
    charts : Charts or None
        The charts before and after, if some were merged.
    mean, rms, max : float
        Distances between samples of the input and the level.
    """

    mesh: int
    name: str | None
    times: int
    faces: int
    vertices: int
    collapses: int
    charts: Charts | None
    mean: float
    rms: float
    max: float


@dataclass(frozen=True, repr=False)
class SceneLevel:
    """A level of detail of a scene.

    Attributes
    ----------
    scene : Scene
        The level.
    meshes : list of MeshOfLevel
        The meshes with triangles, in the order of the document.
    mean, rms, max : float
        Distances between the drawn surfaces of the input and the level, in units of the scene; NaN if nothing
        is drawn.
    shown_from : float
        The share of the height of the screen down to which the level is shown.
    """

    scene: Scene
    meshes: list[MeshOfLevel]
    mean: float
    rms: float
    max: float
    shown_from: float

    def __repr__(self) -> str:
        return f"SceneLevel({self.scene.face_count} faces, mean {self.mean:.3g}, max {self.max:.3g})"


class SceneLevels(Sequence[SceneLevel]):
    """Levels of detail of a scene, from fine to coarse.

    Attributes
    ----------
    together : Scene or None
        One scene with the input and all levels as alternatives of its nodes (``MSFT_lod``), if requested.
    shown_from : float
        The share of the height of the screen down to which the input is shown.
    missed_faces : list of int
        The wanted numbers of drawn faces that no level reaches.
    lost : list of str
        What the levels leave out, with the reason.
    repairs : dict
        Number of repairs of each kind that meshes needed.
    """

    def __init__(
        self,
        levels: Sequence[SceneLevel],
        together: Scene | None,
        shown_from: float,
        missed_faces: list[int],
        lost: list[str],
        repairs: dict[str, int],
    ) -> None:
        self._levels = list(levels)
        self.together = together
        self.shown_from = shown_from
        self.missed_faces = missed_faces
        self.lost = lost
        self.repairs = repairs

    @overload
    def __getitem__(self, place: int) -> SceneLevel: ...
    @overload
    def __getitem__(self, place: slice) -> list[SceneLevel]: ...
    def __getitem__(self, place: int | slice) -> SceneLevel | list[SceneLevel]:
        return self._levels[place]

    def __len__(self) -> int:
        return len(self._levels)

    def __repr__(self) -> str:
        return f"SceneLevels({self._levels!r})"

    def _repr_html_(self) -> str:
        lines = [(x.scene.face_count, len(x.meshes), x.mean, x.rms, x.max) for x in self._levels]
        return grid("Levels of detail of a scene", ["faces", "meshes", "mean", "rms", "largest"], lines)


@checked
def lod_scene(
    scene: Any,
    *,
    ratios: Sequence[float] = (),
    faces: Sequence[int] = (),
    errors: Sequence[Length] = (),
    relative: bool = False,
    per: Per = "scene",
    poses: int = 8,
    together: bool = False,
    preset: Preset = "default",
    placement: Placement | None = None,
    curvature_weight: float | None = None,
    lock_boundary: bool = False,
    feature_angle: float | None = None,
    no_intersections: bool = False,
    components: str | int = "free",
    verify: bool = False,
    attribute_weight: float = 0.3,
    normal_weight: float = 0.0,
    crease_angle: float = 40.0,
    keep_creases: bool = False,
    keep_seams: bool = False,
    progress: Progress = None,
    threads: int | None = None,
) -> SceneLevels:
    """Make levels of detail of a scene, from one sequence of collapses for each mesh.

    Parameters
    ----------
    scene : Scene
        A scene, or the path of a glTF or GLB file.
    ratios : sequence of float
        Levels with these shares of the drawn faces.
    faces : sequence of int
        Levels with these numbers of drawn faces.
    errors : sequence of float or str
        The coarsest levels within these distances of the input, in units of the scene.
    relative : bool
        Whether numbers for `errors` are shares of the diagonal of the scene.
    per : str
        As for :func:`simplify_scene`.
    poses : int
        As for :func:`simplify_scene`.
    together : bool
        Whether to make one scene with all levels as well.

    The other parameters are described in :func:`simplify`.

    Returns
    -------
    SceneLevels
        The levels from fine to coarse, the same as of ``curvmesh lod`` to the last bit.

    Raises
    ------
    WriteError
        With `together`, the scene has levels already, or animation pointers.

    Examples
    --------
    >>> import curvmesh as cm, io
    >>> file = io.BytesIO()
    >>> _ = cm.write(file, cm.shapes.sphere(3), format="glb")
    >>> levels = cm.lod_scene(cm.read_scene(file.getvalue()), ratios=[0.5, 0.25], together=True)
    >>> [level.scene.face_count for level in levels], levels.together.extensions
    ([640, 320], ['MSFT_lod'])
    """
    if not (len(ratios) or len(faces) or len(errors)):
        raise OptionError("say which levels: ratios=, faces= or errors=")
    steps = {
        "ratios": [float(ratio) for ratio in ratios],
        "faces": [whole("faces", count) for count in faces],
        "errors": list(errors),
        "relative": relative,
        "together": together,
    }
    choices = _choices(
        preset,
        placement,
        curvature_weight,
        None,
        None,
        None,
        lock_boundary,
        feature_angle,
        no_intersections,
        components,
        verify,
        1,
    )
    rules = {
        "choices": choices,
        "attributes": _rules(attribute_weight, normal_weight, crease_angle, keep_creases, True),
        "keep_seams": keep_seams,
        "per": per,
        "poses": whole("poses", poses),
    }
    data = _scene(scene)._data
    with calling("levels of detail", progress, threads) as call:
        found, all_levels, told = _core.lod_scene(call, data, steps, rules)
    levels = []
    for level in found:
        meshes = []
        for mesh in level["meshes"]:
            charts = None if mesh["charts"] is None else Charts(*mesh["charts"])
            meshes.append(MeshOfLevel(**{**mesh, "charts": charts}))
        levels.append(SceneLevel(**{**level, "scene": Scene._of(level["scene"]), "meshes": meshes}))
    one = None if all_levels is None else Scene._of(all_levels)
    return SceneLevels(levels, one, told["shown_from"], told["missed_faces"], told["lost"], told["repairs"])
