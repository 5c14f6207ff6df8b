"""Simplification, and levels of detail."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple, overload

from .. import _core
from .._call import Callback, Progress, calling, plain
from .._errors import OptionError
from .._options import checked, whole
from .._table import grid, table, text
from .arrays import real_numbers
from .files import as_mesh, deliver, file_content
from .mesh import Mesh

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from .._options import File, Length, Norm, Placement, Preset

__all__ = ["Charts", "Edges", "ErrorBounds", "Fit", "Level", "Levels", "Record", "Shortfall", "Simplified", "TurnedOver", "lod", "simplify"]

class Edges(NamedTuple):
    """Candidate edges, as passed to a custom cost, cost modifier or constraint.

    Attributes
    ----------
    vertices : ndarray, shape (k, 2)
        The two vertices of each edge, numbered as in the mesh before any collapse.
    ends : ndarray, shape (k, 2, 3)
        Their current positions.
    apexes : ndarray, shape (k, 2, 3)
        The third corners of the faces to the left and to the right; NaN beyond the boundary.
    """

    vertices: NDArray[np.int32]
    ends: NDArray[np.float64]
    apexes: NDArray[np.float64]

    @property
    def lengths(self) -> NDArray[np.float64]:
        """The length of each edge."""
        import numpy as np

        found: NDArray[np.float64] = np.linalg.norm(self.ends[:, 1] - self.ends[:, 0], axis=1)
        return found

    @property
    def midpoints(self) -> NDArray[np.float64]:
        """The middle of each edge, shape (k, 3)."""
        found: NDArray[np.float64] = self.ends.mean(axis=1)
        return found


EdgeFunction = Callable[[Edges], Any]


class ErrorBounds(NamedTuple):
    """A distance from the original: at least `lower`, and at most `upper` if that was certified."""

    lower: float
    upper: float | None


class Shortfall(NamedTuple):
    """A target that was not reached because every remaining collapse was refused.

    Attributes
    ----------
    wanted_faces, wanted_vertices : int or None
        The numbers at which the run should have ended.
    held_by : dict
        Number of refused edges, by reason, the most frequent first. The options `keep`, `lock_boundary`,
        `max_edge`, `min_angle`, `max_valence`, `components` and `no_intersections` cause ``"locked"``,
        ``"max_edge"``, ``"min_angle"``, ``"max_valence"``, ``"component"`` and ``"intersection"``.
    """

    wanted_faces: int | None
    wanted_vertices: int | None
    held_by: dict[str, int]


class Charts(NamedTuple):
    """Numbers of charts, which are the parts between seams, before and after some were merged."""

    before: int
    after: int


class Fit(NamedTuple):
    """Report of the fit: rounds, flips, the root mean square distance before and after, and the norm."""

    rounds: int
    flips: int
    rms_before: float
    rms_last: float
    norm: str


class TurnedOver(NamedTuple):
    """Numbers of faces that refinement turned over against the original: `found`, and `left` after they were
    turned back."""

    found: int
    left: int


@dataclass(frozen=True, repr=False)
class Record:
    """The collapses of a run, from which every level of detail can be reproduced.

    Made by :func:`simplify` and :func:`lod`, or read with :meth:`load`. It belongs to the mesh of the run.
    """

    _log: _core.LogData = field(repr=False)

    def __len__(self) -> int:
        return len(self._log)

    def __repr__(self) -> str:
        return f"Record({len(self)} collapses)"

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, (Mesh._of(self._log.mesh()), _core.record_bytes(plain(), self._log))

    def save(self, path: File) -> None:
        """Write the record, 48 bytes for each collapse: to a path, or to an open binary file."""
        import os

        if isinstance(path, (str, os.PathLike)):
            _core.save_record(plain(), self._log, os.fspath(path))
        else:
            deliver(path, _core.record_bytes(plain(), self._log))

    @staticmethod
    def load(path: File, mesh: Any) -> Record:
        """Read the record of a run on this mesh: from a path, or from an open binary file.

        Raises
        ------
        RecordError
            The file is not a record, or a record of another mesh.
        """
        import os

        file = os.fspath(path) if isinstance(path, (str, os.PathLike)) else file_content(path)
        return Record(_core.load_record(plain(), file, as_mesh(mesh)._data))

    @property
    def columns(self) -> dict[str, NDArray[Any]]:
        """The collapses as arrays: ``removed``, ``kept``, ``position``, ``cost``, ``faces_before``."""
        return self._log.columns()

    def vertex_map(self, collapses: int) -> NDArray[np.int32]:
        """For each vertex of the mesh, the vertex into which it has been merged after this number of collapses,
        in the numbering of the mesh."""
        return _core.representatives(self._log, collapses)


def _restored(mesh: Mesh, content: bytes) -> Record:
    return Record(_core.load_record(plain(), content, mesh._data))


@dataclass(frozen=True, repr=False)
class Simplified:
    """A simplified mesh and a report.

    Attributes
    ----------
    mesh : Mesh
        The result, with the attributes of the original.
    vertex_map : ndarray of int32, shape (n,)
        For each vertex of the original, its vertex of the result.
    stop : str
        Why it stopped: ``"faces"``, ``"vertices"``, ``"cost"``, ``"error"``, ``"time"``,
        ``"cancelled"`` or ``"nothing_left"``.
    shortfall : Shortfall or None
        The target that was not reached because every remaining collapse was refused, and the reasons.
    charts : Charts or None
        The charts of textures, materials and labels, if some were merged to make room for the shape.
    error : ErrorBounds or None
        The distance from the original, if requested.
    refused : dict
        Number of refused edges, by reason.
    max_cost : float
        The largest cost of a collapse, in the unit of the metric.
    boundary_shift : float or None
        The largest distance of a boundary vertex of the original from the new boundary.
    fit : Fit or None
        Report of the fit.
    turned_over : TurnedOver or None
        Faces that refinement turned over, if the result was refined.
    preset_kept : str or None
        The cheaper preset whose result is this one, because it is closer to the original.
    log : Record
        Every collapse, before fitting.
    """

    mesh: Mesh
    vertex_map: NDArray[np.int32]
    stop: str
    shortfall: Shortfall | None
    charts: Charts | None
    error: ErrorBounds | None
    refused: dict[str, int]
    max_cost: float
    boundary_shift: float | None
    fit: Fit | None
    turned_over: TurnedOver | None
    preset_kept: Preset | None
    log: Record

    def _rows(self) -> list[tuple[str, object]]:
        rows: list[tuple[str, object]] = [
            ("vertices", self.mesh.vertex_count),
            ("faces", self.mesh.face_count),
            ("stopped at", self.stop),
            ("collapses", len(self.log)),
            ("largest cost", self.max_cost),
        ]
        if self.shortfall is not None:
            rows.append(("target not reached", self.shortfall.wanted_faces or self.shortfall.wanted_vertices))
        if self.charts is not None:
            rows.append(("charts merged", f"{self.charts.before} -> {self.charts.after}"))
        if self.turned_over is not None and self.turned_over.left:
            rows.append(("faces upside down", self.turned_over.left))
        if self.preset_kept is not None:
            rows.append(("kept the result of", self.preset_kept))
        if self.error is not None:
            rows.append(("error, at least", self.error.lower))
            if self.error.upper is not None:
                rows.append(("error, proved at most", self.error.upper))
        if self.boundary_shift is not None:
            rows.append(("boundary shift", self.boundary_shift))
        rows += [(f"refused: {reason}", count) for reason, count in self.refused.items()]
        return rows

    def __repr__(self) -> str:
        return text("Simplified", self._rows())

    def _repr_html_(self) -> str:
        return table("Simplified", self._rows())


def _choices(
    preset: str,
    placement: str | None,
    curvature_weight: float | None,
    fit_rounds: int | None,
    norm: str | None,
    anneal_time: float | None,
    lock_boundary: bool,
    feature_angle: float | None,
    no_intersections: bool,
    components: str | int,
    verify: bool,
    seed: int,
) -> dict[str, Any]:
    kept = {"free": None, "keep": 4}
    if isinstance(components, str) and components not in kept:
        raise OptionError(f'components is {components!r}; it must be "free", "keep" or a number')
    return {
        "preset": preset,
        "placement": placement,
        "curvature_weight": curvature_weight,
        "fit_rounds": fit_rounds,
        "norm": norm,
        "anneal_time": anneal_time,
        "lock_boundary": lock_boundary,
        "feature_angle": feature_angle,
        "no_intersections": no_intersections,
        "min_component_vertices": kept[components]
        if isinstance(components, str)
        else whole("components", components),
        "verify": verify,
        "seed": seed,
    }


def _constraints(
    keep: str | None,
    weight: str | None,
    max_edge: Length | None,
    min_angle: float | None,
    max_valence: int | None,
    keep_seams: bool,
) -> dict[str, Any]:
    return {
        "keep": keep,
        "weight": weight,
        "max_edge": max_edge,
        "min_angle": min_angle,
        "max_valence": None if max_valence is None else whole("max_valence", max_valence),
        "keep_seams": keep_seams,
    }


def _rules(
    attribute_weight: float, normal_weight: float, crease_angle: float, keep_creases: bool, attributes: bool
) -> dict[str, Any]:
    return {
        "attribute_weight": attribute_weight,
        "normal_weight": normal_weight,
        "crease_angle": crease_angle,
        "keep_creases": keep_creases,
        "attributes": attributes,
    }


def _asked(function: EdgeFunction | None) -> Callable[[Any, Any, Any], Any] | None:
    """Wraps a function of edges for the compiled part."""
    if function is None:
        return None
    given = function

    def ask(vertices: Any, ends: Any, apexes: Any) -> Any:
        import numpy as np

        found = real_numbers("result of the function", given(Edges(vertices, ends, apexes)))
        return np.ascontiguousarray(found, dtype=np.float64)

    return ask


def _shortfall(told: tuple[int | None, int | None, list[tuple[str, int]]] | None) -> Shortfall | None:
    if told is None:
        return None
    wanted_faces, wanted_vertices, held_by = told
    return Shortfall(wanted_faces, wanted_vertices, dict(held_by))


@checked
def simplify(
    mesh: Any,
    *,
    faces: int | None = None,
    vertices: int | None = None,
    ratio: float | None = None,
    max_error: Length | None = None,
    max_cost: float | None = None,
    time_limit: float | None = None,
    relative: bool = False,
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
    keep: str | None = None,
    weight: str | None = None,
    max_edge: Length | None = None,
    min_angle: float | None = None,
    max_valence: int | None = None,
    verify: bool = False,
    seed: int = 1,
    attribute_weight: float = 0.3,
    normal_weight: float = 0.0,
    crease_angle: float = 40.0,
    keep_creases: bool = False,
    keep_seams: bool = False,
    attributes: bool = True,
    cost: EdgeFunction | None = None,
    cost_modifier: EdgeFunction | None = None,
    constraint: EdgeFunction | None = None,
    progress: Progress = None,
    callback: Callback | None = None,
    keep_partial: bool = False,
    threads: int | None = None,
) -> Simplified:
    """Simplify a mesh by collapsing edges.

    Texture coordinates, normals, colours, materials and named numbers are transferred. Several targets may be
    given; the first one that is reached ends the run.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`. An oriented manifold, with or without boundaries;
        :func:`curvmesh.repair` makes one.
    faces, vertices : int, optional
        Stop at this number.
    ratio : float, optional
        Stop at this share of the faces, from 0 to 1.
    max_error : float or str, optional
        Stay within this distance of the input, and the input within it of the result: a length in model
        units, or ``"0.2%"`` of the diagonal of the bounding box.
    max_cost : float, optional
        Stop before a collapse that costs more than this, in the unit of the metric.
    time_limit : float, optional
        Stop collapsing after this number of seconds.
    relative : bool
        Whether numbers for `max_error` and `max_edge` are shares of the diagonal.
    preset : str
        ``"draft"``, ``"fast"``, ``"default"``, ``"quality"``, ``"extreme"``, ``"thin-features"``,
        ``"quadrics"``, ``"paper-l1"``, ``"paper-l2"``, ``"paper-l1-guarded"`` or ``"paper-l2-guarded"``. The default collapses by
        quadrics with a curvature factor and fits the result. The guarded presets reject collapses that fold a
        face or leave a sliver; ``"paper-l1"`` and ``"paper-l2"`` reject none, as published.
    placement : str, optional
        Where the remaining vertex goes: ``"optimal-volume"``, ``"optimal"``, ``"endpoint"``,
        ``"midpoint"``, ``"butterfly"`` or ``"curvature-optimal"``, which needs one of the ``"paper-..."``
        presets and is slow.
    curvature_weight : float, optional
        How much a change of curvature raises the cost.
    fit_rounds : int, optional
        Rounds of fitting the result to the input; 0 for none. With four or more, one is skipped if at least a
        fifth of the faces remain.
    norm : str, optional
        The norm of the distances from the input that the fit minimises: ``"l1"``, the mean; ``"l2"``, the root
        mean square, which is the default; or ``"max"``, the largest, at the expense of the mean.
    anneal_time : float, optional
        Anneal for at most this number of seconds, with the presets ``"quality"`` and ``"extreme"``. A result
        that is limited by time differs between machines.
    lock_boundary : bool
        Fix all boundary vertices.
    feature_angle : float, optional
        Keep edges as feature lines if the angle between the normals of their faces is larger than this, in
        degrees.
    no_intersections : bool
        Reject operations that cause new intersections of faces.
    components : str or int
        How to treat small components: ``"free"`` may remove them, ``"keep"`` leaves at least a tetrahedron of
        each, a number leaves at least this number of vertices.
    keep : str, optional
        A named number of vertices or faces. Vertices with another value than 0 stay where they are; faces with
        another value than 0 stay as they are, with their corners.
    weight : str, optional
        A named number of vertices, at least 0: their importance. Costs and errors near a vertex count so many
        times.
    max_edge : float or str, optional
        Make no edge longer than this length, in model units, or ``"5%"`` of the diagonal. Edges of the input
        may stay.
    min_angle : float, optional
        Make no face with a smaller angle than this, in degrees, below 60. Faces of the input may stay.
    max_valence : int, optional
        Give no vertex more edges than this, at least 3, or than a vertex of the input in its place.
    verify : bool
        Certify the distance from the input, and that it is within `max_error`.
    seed : int
        Seed of the random numbers of the fit.
    attribute_weight, normal_weight : float
        Weights of changes of texture and colours, and of normals.
    crease_angle : float
        An edge is a crease if normals differ by more than this across it, in degrees.
    keep_creases : bool
        Keep creases as feature lines, as borders of texture charts and materials are.
    keep_seams : bool
        Keep all borders of texture charts, materials, groups and labels, even if the shape suffers. By default,
        small charts are merged where the borders need more than a fifth of the wanted faces.
    attributes : bool
        Whether attributes are transferred; if not, the result has positions and faces only.
    cost : callable, optional
        A custom cost instead of the cost of the preset. Called with :class:`Edges`; returns one number for
        each, NaN for edges that must not collapse. It is called with all edges first, and after each collapse
        with the edges around it.
    cost_modifier : callable, optional
        At least 0; the cost becomes ``cost * (1 + cost_modifier)``; called in the same way.
    constraint : callable, optional
        Returns ``True`` for each edge that may collapse; called in the same way. With any of the three
        functions the result is not fitted, and the metric is used from the first collapse; without them
        quadrics come first if the target has far fewer faces.
    progress : bool or callable, optional
        ``True`` for a bar, or a function of the completed share.
    callback : callable, optional
        Called with a :class:`State` at intervals; ends the run with the best result so far by returning
        ``False``.
    keep_partial : bool
        Whether Ctrl-C ends the run with the best result so far instead of an exception.
    threads : int, optional
        Number of threads; the result does not depend on it.

    Returns
    -------
    Simplified
        The same result as of ``curvmesh simplify``, to the last bit.

    Raises
    ------
    OptionError
        No target is given, or an option is invalid.
    NonManifoldError, OrientationError, DegenerateFaceError, DuplicateFaceError, NotFiniteError
        The mesh is not an oriented manifold; the error has the ids and the name of the repair.

    Notes
    -----
    Quadrics follow Garland and Heckbert 1997 and Lindstrom and Turk 1998, the norms of ``"paper-l1"`` and
    ``"paper-l2"`` eq. 1 and 2 of Kim, Kim, Levin: Surface simplification using a discrete curvature norm, 2002.

    Examples
    --------
    >>> import curvmesh as cm
    >>> sphere = cm.shapes.sphere(4)
    >>> small = cm.simplify(sphere, faces=500, verify=True)
    >>> small.mesh.face_count, small.stop
    (500, 'faces')
    >>> small.error.upper < 0.02
    True

    Edges near one side stay:

    >>> left = cm.simplify(sphere, faces=1500, constraint=lambda edges: edges.midpoints[:, 0] > 0).mesh
    >>> int((left.vertices[:, 0] < -0.5).sum()) == int((sphere.vertices[:, 0] < -0.5).sum())
    True
    """
    targets = {
        "faces": faces,
        "vertices": vertices,
        "ratio": ratio,
        "max_error": max_error,
        "max_cost": max_cost,
        "time_limit": time_limit,
        "relative": relative,
    }
    if all(target is None for name, target in targets.items() if name != "relative"):
        raise OptionError(
            "say when to stop: faces=, vertices=, ratio=, max_error=, max_cost= or time_limit="
        )
    if (cost or cost_modifier or constraint) and (fit_rounds or norm):
        raise OptionError("with functions of one's own the result is not fitted: leave out fit_rounds and norm")
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
    rules = _rules(attribute_weight, normal_weight, crease_angle, keep_creases, attributes)
    constraints = _constraints(keep, weight, max_edge, min_angle, max_valence, keep_seams)
    data = as_mesh(mesh)._data
    with calling("simplifying", progress, threads, callback, keep_partial) as call:
        made, told = _core.simplify(
            call, data, targets, choices, rules, constraints, _asked(cost), _asked(cost_modifier), _asked(constraint)
        )
    return Simplified(
        mesh=Mesh._of(made),
        vertex_map=told["vertex_map"],
        stop=told["stop"],
        shortfall=_shortfall(told["shortfall"]),
        charts=None if told["charts"] is None else Charts(*told["charts"]),
        error=None if told["error"] is None else ErrorBounds(*told["error"]),
        refused=told["refused"],
        max_cost=told["max_cost"],
        boundary_shift=told["boundary_shift"],
        fit=None if told["fit"] is None else Fit(*told["fit"]),
        turned_over=None if told["turned_over"] is None else TurnedOver(*told["turned_over"]),
        preset_kept=told["preset_kept"],
        log=Record(told["log"]),
    )


@dataclass(frozen=True, repr=False)
class Level:
    """A level of detail.

    Attributes
    ----------
    mesh : Mesh
        The level, with the attributes of the original.
    collapses : int
        Number of collapses of the record.
    mean, rms, max : float
        Distances from the original over both directions, from 200,000 samples each, in model units.
    """

    mesh: Mesh
    collapses: int
    mean: float
    rms: float
    max: float

    def __repr__(self) -> str:
        return f"Level({self.mesh.face_count} faces, mean {self.mean:.3g}, max {self.max:.3g})"


class Levels(Sequence[Level]):
    """Levels of detail, from fine to coarse, and their record of collapses."""

    def __init__(self, levels: Sequence[Level], record: Record) -> None:
        self._levels = list(levels)
        self.record = record

    @overload
    def __getitem__(self, place: int) -> Level: ...
    @overload
    def __getitem__(self, place: slice) -> list[Level]: ...
    def __getitem__(self, place: int | slice) -> Level | list[Level]:
        return self._levels[place]

    def __len__(self) -> int:
        return len(self._levels)

    def __repr__(self) -> str:
        return f"Levels({self._levels!r})"

    def _repr_html_(self) -> str:
        lines = [(x.mesh.face_count, x.mesh.vertex_count, x.mean, x.rms, x.max) for x in self._levels]
        return grid("Levels of detail", ["faces", "vertices", "mean", "rms", "largest"], lines)


@checked
def lod(
    mesh: Any,
    *,
    ratios: Sequence[float] = (),
    faces: Sequence[int] = (),
    errors: Sequence[Length] = (),
    relative: bool = False,
    record: Record | None = None,
    preset: Preset = "default",
    placement: Placement | None = None,
    curvature_weight: float | None = None,
    lock_boundary: bool = False,
    feature_angle: float | None = None,
    no_intersections: bool = False,
    components: str | int = "free",
    keep: str | None = None,
    weight: str | None = None,
    max_edge: Length | None = None,
    min_angle: float | None = None,
    max_valence: int | None = None,
    verify: bool = False,
    attribute_weight: float = 0.3,
    normal_weight: float = 0.0,
    crease_angle: float = 40.0,
    keep_creases: bool = False,
    keep_seams: bool = False,
    attributes: bool = True,
    progress: Progress = None,
    threads: int | None = None,
) -> Levels:
    """Make levels of detail from one run of collapses.

    Each vertex of a level comes from vertices of the finer levels. So levels are not fitted to the input,
    unlike the results of :func:`simplify`.

    Parameters
    ----------
    mesh : mesh-like
        See :func:`curvmesh.as_mesh`.
    ratios : sequence of float
        Levels with these shares of the faces.
    faces : sequence of int
        Levels with these numbers of faces, or one fewer.
    errors : sequence of float or str
        The coarsest levels within these distances of the input.
    record : Record, optional
        Use the collapses of this record of a run on the same mesh.
    verify : bool
        Certify the distances of `errors`.
    keep_seams : bool
        Keep all seams. By default small charts are merged, in all levels, where the coarsest level has no room for
        their borders.

    The other parameters are described in :func:`simplify`.

    Returns
    -------
    Levels
        The levels from fine to coarse; ``.record`` has the collapses.

    Examples
    --------
    >>> import curvmesh as cm
    >>> levels = cm.lod(cm.shapes.sphere(4), ratios=[0.5, 0.25, 0.1])
    >>> [level.mesh.face_count for level in levels]
    [2560, 1280, 512]
    >>> again = cm.lod(cm.shapes.sphere(4), faces=[512], record=levels.record)
    >>> again[0].mesh == levels[2].mesh
    True
    """
    if not (len(ratios) or len(faces) or len(errors)):
        raise OptionError("say which levels: ratios=, faces= or errors=")
    steps = {
        "ratios": [float(ratio) for ratio in ratios],
        "faces": [whole("faces", count) for count in faces],
        "errors": list(errors),
        "relative": relative,
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
    rules = _rules(attribute_weight, normal_weight, crease_angle, keep_creases, attributes)
    constraints = _constraints(keep, weight, max_edge, min_angle, max_valence, keep_seams)
    data = as_mesh(mesh)._data
    known = None if record is None else record._log
    with calling("levels of detail", progress, threads) as call:
        found, log = _core.lod(call, data, steps, choices, rules, constraints, known)
    levels = [Level(**{**level, "mesh": Mesh._of(level["mesh"])}) for level in found]
    return Levels(levels, Record(log))
