"""The steps of a recipe: their options and their functions."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from .._geometry.curvature import curvature
from .._geometry.distance import distance
from .._geometry.flip import flip
from .._geometry.info import repair
from .._geometry.files import read, write
from .._geometry.mesh import Mesh
from .._geometry.show import render
from .._geometry.simplify import lod, simplify

#: The report on a mesh or a step: names and JSON values.
Told = dict[str, Any]

#: Output formats, by the extension of the file.
FORMATS = ("obj", "ply", "stl", "off", "gltf", "glb")


@dataclass
class Work:
    """A mesh in a sequence of steps.

    Attributes
    ----------
    path : str
        The source file.
    folder : str
        The folder for files.
    threads : int
        Number of threads of each step.
    mesh, original, repaired : Mesh
        The current mesh, the input, and the mesh after the initial repairs.
    files : list of str
        The names of all files in the folder, in the order of writing.
    """

    path: str
    folder: str
    threads: int
    mesh: Mesh = field(init=False)
    original: Mesh = field(init=False)
    repaired: Mesh = field(init=False)
    files: list[str] = field(default_factory=list)

    def change(self, mesh: Mesh, **told: Any) -> Told:
        """Continues with another mesh."""
        self.mesh = mesh
        return {"vertices": mesh.vertex_count, "faces": mesh.face_count, **told}

    def extension(self) -> str:
        """The extension of the source file, if the format can be written."""
        found = os.path.splitext(self.path)[1].lower().lstrip(".")
        return found if found in FORMATS else "ply"

    def save(self, name: str, mesh: Mesh, options: Mapping[str, Any]) -> Told:
        """Writes a mesh with its companion files."""
        before = set(os.listdir(self.folder))
        path = os.path.join(self.folder, name)
        told = write(path, mesh, threads=self.threads, overwrite_companions=True, **options)
        beside = set(os.listdir(self.folder)) - before - {name}
        self.files += [file for file in [name, *sorted(beside)] if file not in self.files]
        return {"file": name, "rounding": told["rounding"], "dropped": told["dropped"]}


def _read(work: Work, options: Told) -> Told:
    mesh = read(work.path, threads=work.threads, **options)
    work.original = work.repaired = mesh
    return work.change(mesh)


def _repair(work: Work, options: Told) -> Told:
    done = repair(work.mesh, threads=work.threads, **options)
    work.repaired = done.mesh
    counts = {name: count for name, count in done.counts.items() if count}
    return work.change(done.mesh, unchanged=done.unchanged, counts=counts)


def _flip(work: Work, options: Told) -> Told:
    done = flip(work.mesh, threads=work.threads, **options)
    names = ("cost_before", "cost_after", "flips", "rebuilt", "annealed_flips", "stop", "refused")
    return work.change(done.mesh, **{name: getattr(done, name) for name in names})


def _simplify(work: Work, options: Told) -> Told:
    done = simplify(work.mesh, threads=work.threads, **options)
    told: Told = {"stop": done.stop, "collapses": len(done.log), "max_cost": done.max_cost}
    if done.shortfall is not None:
        told["shortfall"] = done.shortfall._asdict()
    if done.error is not None:
        told["error"] = done.error._asdict()
    if done.boundary_shift is not None:
        told["boundary_shift"] = done.boundary_shift
    return work.change(done.mesh, **told)


def _lod(work: Work, options: Told) -> Told:
    options = dict(options)
    name, extension = options.pop("name", "lod"), options.pop("extension", work.extension())
    told = []
    for number, level in enumerate(lod(work.mesh, threads=work.threads, **options), 1):
        saved = work.save(f"{name}-{number}.{extension}", level.mesh, {})
        errors = {"mean": level.mean, "rms": level.rms, "max": level.max}
        told.append({"faces": level.mesh.face_count, **errors, **saved})
    return {"levels": told}


#: Names of curvature quantities in files of the program.
_NAMES = {"gaussian": "gaussian_curvature", "mean": "mean_curvature", "abs_mean": "abs_mean_curvature"}


def _curvature(work: Work, options: Told) -> Told:
    options = dict(options)
    quantities = options.pop("quantities", ["gaussian", "mean"])
    found = curvature(work.mesh, threads=work.threads, **options)
    # Unknown values are NaN in the file as well.
    mesh = found.mesh.copy()
    data = mesh.face_data if found.on == "face" else mesh.vertex_data
    data.update({_NAMES.get(name, name): found[name] for name in quantities})
    told: Told = {"totals": found.totals}
    if found.radius is not None:
        told["radius"] = found.radius
    return work.change(mesh, **told)


def _distance(work: Work, options: Told) -> Told:
    options = dict(options)
    other = work.repaired if options.pop("to", "input") == "repaired" else work.original
    found = distance(other, work.mesh, threads=work.threads, **options)
    told: Told = {name: getattr(found, name) for name in ("mean", "rms", "max", "diagonal")}
    for name in ("forward", "backward"):
        side = getattr(found, name)
        if side is not None:
            told[name] = {"mean": side.mean, "rms": side.rms, "max": side.max}
            if side.signed is not None:
                told[name]["signed"] = side.signed._asdict()
    if found.bounds is not None:
        told["bounds"] = found.bounds._asdict()
    return told


def _render(work: Work, options: Told) -> Told:
    options = dict(options)
    name = f"{options.pop('name', 'picture')}.png"
    if isinstance(options.get("range"), list):
        options["range"] = tuple(options["range"])
    picture = render(work.mesh, threads=work.threads, **options)
    picture.save(os.path.join(work.folder, name))
    work.files.append(name)
    return {"file": name, "range": None if picture.range is None else list(picture.range)}


def _write(work: Work, options: Told) -> Told:
    options = dict(options)
    name, extension = options.pop("name", "mesh"), options.pop("extension", work.extension())
    return work.save(f"{name}.{extension}", work.mesh, options)


@dataclass(frozen=True)
class Kind:
    """The type of an option.

    Attributes
    ----------
    what : str
        A description.
    fits : callable
        Whether a value is valid.
    normal : callable
        Converts equivalent values to one form.
    """

    what: str
    fits: Callable[[Any], bool]
    normal: Callable[[Any], Any] = lambda value: value


def _is_count(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= 0


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def _is_length(value: Any) -> bool:
    return _is_number(value) or isinstance(value, str)


def _length(value: Any) -> Any:
    return value if isinstance(value, str) else float(value)


def _all(fits: Callable[[Any], bool], *lengths: int) -> Callable[[Any], bool]:
    def all_fit(value: Any) -> bool:
        is_list = isinstance(value, (list, tuple)) and (not lengths or len(value) in lengths)
        return is_list and all(map(fits, value))

    return all_fit


def _one_of(*names: str) -> Kind:
    return Kind(" or ".join(f'"{name}"' for name in names), lambda value: value in names)


_FLAG = Kind("true or false", lambda value: isinstance(value, bool))
_COUNT = Kind("a whole number that is not negative", _is_count)
_COUNTS = Kind("a list of whole numbers", _all(_is_count), list)
_NUMBER = Kind("a number", _is_number, float)
_NUMBERS = Kind("a list of numbers", _all(_is_number), lambda value: [float(x) for x in value])
_POINT = Kind("three numbers", _all(_is_number, 3), lambda value: [float(x) for x in value])
_TEXT = Kind("a text", lambda value: isinstance(value, str))
_LENGTH = Kind('a length, or a share like "0.2%"', _is_length, _length)
_LENGTHS = Kind("a list of lengths", _all(_is_length), lambda value: [_length(x) for x in value])
_SIZE = Kind("width and height in pixels", _all(_is_count, 2), list)
_EXTENSION = _one_of(*FORMATS)
_FILE = Kind(
    "a plain name without extension, other than record and thumbnail",
    lambda value: isinstance(value, str)
    and re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_-]{0,63}", value) is not None
    and value not in ("record", "thumbnail"),
)
_QUANTITIES = Kind(
    "a list of gaussian, mean, abs_mean, k1, k2, shape_index and curvedness",
    _all(lambda v: v in ("gaussian", "mean", "abs_mean", "k1", "k2", "shape_index", "curvedness")),
    list,
)
_RANGE = Kind(
    "a text, or two numbers",
    lambda value: isinstance(value, str) or _all(_is_number, 2)(value),
    lambda value: value if isinstance(value, str) else [float(x) for x in value],
)
_DIRECTION = Kind(
    "the name of a side, a list of them, or three numbers",
    lambda v: isinstance(v, str) or _all(_is_number, 3)(v) or _all(lambda s: isinstance(s, str))(v),
    lambda value: list(value) if isinstance(value, (list, tuple)) else value,
)

_COLLAPSES = {
    "preset": _TEXT,
    "placement": _TEXT,
    "curvature_weight": _NUMBER,
    "lock_boundary": _FLAG,
    "feature_angle": _NUMBER,
    "no_intersections": _FLAG,
    "components": Kind('"free", "keep" or a number', lambda v: isinstance(v, str) or _is_count(v)),
    "keep": _TEXT,
    "weight": _TEXT,
    "max_edge": _LENGTH,
    "min_angle": _NUMBER,
    "max_valence": _COUNT,
    "keep_seams": _FLAG,
    "verify": _FLAG,
    "attribute_weight": _NUMBER,
    "normal_weight": _NUMBER,
    "crease_angle": _NUMBER,
    "keep_creases": _FLAG,
    "attributes": _FLAG,
}


@dataclass(frozen=True)
class Step:
    """A kind of step.

    Attributes
    ----------
    options : dict
        The types of the options; the names are those of the function of the same name.
    work : callable
        Runs the step, and returns its report.
    changes : bool
        Whether it changes the mesh.
    """

    options: dict[str, Kind]
    work: Callable[[Work, Told], Told]
    changes: bool = False


#: All steps by name.
STEPS = {
    "read": Step(
        {
            "format": _TEXT,
            "external": _TEXT,
            "max_memory": _COUNT,
            "allow_empty": _FLAG,
            "join": _FLAG,
        },
        _read,
    ),
    "repair": Step(
        {
            "weld": _LENGTH,
            "relative": _FLAG,
            "drop_out_of_range": _FLAG,
            "drop_not_finite": _FLAG,
            "drop_degenerate": _FLAG,
            "drop_duplicates": _FLAG,
            "reorient": _FLAG,
            "cut_non_manifold": _FLAG,
            "drop_unreferenced": _FLAG,
            "fill_holes": Kind('a number of edges or "all"', lambda v: v == "all" or _is_count(v)),
        },
        _repair,
        changes=True,
    ),
    "flip": Step(
        {
            "cost": _TEXT,
            "area": _TEXT,
            "look_ahead": _COUNT,
            "rebuild_effort": _COUNT,
            "rebuild_largest": _COUNT,
            "anneal_steps": _COUNT,
            "feature_angle": _NUMBER,
            "shape_constraint": _TEXT,
            "max_fold": _NUMBER,
            "no_intersections": _FLAG,
            "random_ties": _FLAG,
            "seed": _COUNT,
            "max_flips": _COUNT,
            "time_limit": _NUMBER,
        },
        _flip,
        changes=True,
    ),
    "simplify": Step(
        {
            "faces": _COUNT,
            "vertices": _COUNT,
            "ratio": _NUMBER,
            "max_error": _LENGTH,
            "max_cost": _NUMBER,
            "norm": _TEXT,
            "anneal_time": _NUMBER,
            "time_limit": _NUMBER,
            "relative": _FLAG,
            "fit_rounds": _COUNT,
            "seed": _COUNT,
            **_COLLAPSES,
        },
        _simplify,
        changes=True,
    ),
    "lod": Step(
        {
            "ratios": _NUMBERS,
            "faces": _COUNTS,
            "errors": _LENGTHS,
            "relative": _FLAG,
            "name": _FILE,
            "extension": _EXTENSION,
            **_COLLAPSES,
        },
        _lod,
    ),
    "curvature": Step(
        {
            "estimator": _TEXT,
            "area": _TEXT,
            "radius": _LENGTH,
            "noise": _LENGTH,
            "relative": _FLAG,
            "rings": _COUNT,
            "preset": _TEXT,
            "quantities": _QUANTITIES,
        },
        _curvature,
        changes=True,
    ),
    "distance": Step(
        {
            "to": _one_of("input", "repaired"),
            "samples": _COUNT,
            "exact": _LENGTH,
            "relative": _FLAG,
            "signed": _FLAG,
            "seed": _COUNT,
        },
        _distance,
    ),
    "render": Step(
        {
            "values": _TEXT,
            "on": _TEXT,
            "direction": _DIRECTION,
            "up": _POINT,
            "size": _SIZE,
            "edges": _NUMBER,
            "outlines": _NUMBER,
            "crease": _NUMBER,
            "smooth": _FLAG,
            "plain": _FLAG,
            "colormap": _TEXT,
            "range": _RANGE,
            "log": _FLAG,
            "bar": _FLAG,
            "label": _TEXT,
            "transparent": _FLAG,
            "occlusion": _NUMBER,
            "supersampling": _COUNT,
            "name": _FILE,
        },
        _render,
    ),
    "write": Step(
        {"name": _FILE, "extension": _EXTENSION, "encoding": _TEXT, "precision": _TEXT},
        _write,
    ),
}
