"""Types of options, and the check of the options of every function."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, Literal, TypeVar, Union, cast

from ._errors import OptionError

if TYPE_CHECKING:
    import os
    from typing import BinaryIO

    #: A file by its path, or an open binary file.
    File = Union[str, os.PathLike[str], BinaryIO]

#: A number in model units, or a text such as ``"0.2%"`` of the diagonal of the bounding box.
Length = Union[float, str]

Preset = Literal[
    "draft",
    "fast",
    "default",
    "quality",
    "extreme",
    "thin-features",
    "quadrics",
    "paper-l1",
    "paper-l2",
    "paper-l1-guarded",
    "paper-l2-guarded",
]
Placement = Literal[
    "optimal-volume", "optimal", "endpoint", "midpoint", "butterfly", "curvature-optimal"
]
Norm = Literal["l1", "l2", "max"]
Estimator = Literal["auto", "vertex", "face", "fit", "ball", "corrected"]
Area = Literal["voronoi", "barycentric"]
Sections = Literal["robust", "paper"]
FlipCost = Literal[
    "f1", "f2", "f3", "gauss", "gauss-extrinsic", "area", "delaunay", "willmore", "willmore-potential"
]
Outline = Literal["best", "circle", "ellipse", "sagitta"]
CoverMethod = Literal["best", "greedy", "sequential"]
Format = Literal["obj", "ply", "stl", "off", "gltf", "glb"]
SceneFormat = Literal["gltf", "glb"]
Compress = Literal["none", "meshopt"]
Per = Literal["scene", "node", "mesh"]
External = Literal["none", "folder", "any"]
Encoding = Literal["usual", "text", "little-endian", "big-endian"]
Precision = Literal["exact", "single", "double"]
Layout = Literal["side", "wipe", "blink", "one"]
Up = Literal["auto", "x", "y", "z", "-x", "-y", "-z"]
On = Literal["vertex", "face"]
Engine = Literal["local", "dask", "ray"]

F = TypeVar("F", bound=Callable[..., Any])


def checked(function: F) -> F:
    """Refuses values that do not fit the annotations of the parameters.

    Integers may have any type if the value has no fraction (``3.0``, ``numpy.int64(3)``).
    """
    kinds = {
        name: kind
        for name, annotation in function.__annotations__.items()
        if (kind := _KINDS.get(annotation.removesuffix(" | None"))) is not None
    }
    positional = function.__code__.co_varnames[: function.__code__.co_argcount]

    @wraps(function)
    def check(*given: Any, **options: Any) -> Any:
        values = [_converted(kinds, name, value) for name, value in zip(positional, given)]
        named = {name: _converted(kinds, name, value) for name, value in options.items()}
        return function(*values, *given[len(values) :], **named)

    return cast(F, check)


def _converted(kinds: dict[str, Callable[[str, Any], Any]], name: str, value: Any) -> Any:
    return kinds[name](name, value) if value is not None and name in kinds else value


def whole(name: str, value: Any) -> int:
    """An integer that is not negative."""
    is_flag = isinstance(value, bool) or type(value).__name__ == "bool_"
    try:
        number = int(value) if not is_flag and not isinstance(value, str) and value == int(value) else -1
    except (TypeError, ValueError, OverflowError):
        number = -1
    if not 0 <= number < 2**64:
        raise OptionError(f"{name} is {value!r}; it must be a whole number that is not negative")
    return number


def _number(name: str, value: Any) -> float:
    try:
        if not isinstance(value, (bool, str)):
            return float(value)
    except (TypeError, ValueError, OverflowError):
        pass
    raise OptionError(f"{name} is {value!r}; it must be a number")


def _length(name: str, value: Any) -> Length:
    try:
        return value if isinstance(value, str) else _number(name, value)
    except OptionError:
        message = f'{name} is {value!r}; it must be a number, or a share of the diagonal like "0.2%"'
        raise OptionError(message) from None


def _flag(name: str, value: Any) -> bool:
    if isinstance(value, bool) or type(value).__name__ in ("bool_", "bool"):
        return bool(value)
    raise OptionError(f"{name} is {value!r}; it must be True or False")


def _side(name: str, value: Any) -> str:
    if isinstance(value, str) and value in ("vertex", "face"):
        return value
    raise OptionError(f'{name} is {value!r}; it must be "vertex" or "face"')


def _function(name: str, value: Any) -> Any:
    if callable(value):
        return value
    raise OptionError(f"{name} is {value!r}; it must be a function")


def _progress(name: str, value: Any) -> Any:
    if isinstance(value, bool) or callable(value):
        return value
    raise OptionError(f"{name} is {value!r}; it must be True, False or a function")


def _several(kind: Callable[[str, Any], Any]) -> Callable[[str, Any], list[Any]]:
    def check(name: str, values: Any) -> list[Any]:
        if isinstance(values, str) or not hasattr(values, "__iter__"):
            raise OptionError(f"{name} is {values!r}; it must be a list, like [{values!r}]")
        return [kind(name, value) for value in values]

    return check


def _pair(name: str, values: Any) -> tuple[int, ...]:
    if not hasattr(values, "__iter__") or isinstance(values, str) or len(list(values)) != 2:
        raise OptionError(f"{name} is {values!r}; it must be two whole numbers")
    return tuple(whole(name, value) for value in values)


def _text(name: str, value: Any) -> str:
    if isinstance(value, str):
        return value
    raise OptionError(f"{name} is {value!r}; it must be a text")


#: The check of each annotation.
_KINDS: dict[str, Callable[[str, Any], Any]] = {
    "int": whole,
    "float": _number,
    "bool": _flag,
    "Length": _length,
    "Sequence[float]": _several(_number),
    "Sequence[int]": _several(whole),
    "Sequence[Length]": _several(_length),
    "tuple[int, int]": _pair,
    "On": _side,
    "Callback": _function,
    "EdgeFunction": _function,
    "Progress": _progress,
    **dict.fromkeys(
        ("str", "Preset", "Placement", "Norm", "Estimator", "Area", "Sections", "Outline", "CoverMethod")
        + ("Format", "External", "Encoding", "Precision", "Layout", "Up", "Engine", "SceneFormat", "Compress", "Per"),
        _text,
    ),
}
