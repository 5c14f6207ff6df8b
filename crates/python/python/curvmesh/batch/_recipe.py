"""Recipes: the steps applied to every input, as data that is checked before anything runs."""

from __future__ import annotations

import difflib
import hashlib
import json
import os
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Union

from .._errors import CurvmeshError, OptionError
from .._geometry.files import write
from .._table import grid
from ..shapes import sphere
from ._steps import STEPS, Told, Work

#: A recipe, its steps, or the path of a JSON file with them.
Steps = Union["Recipe", str, "os.PathLike[str]", Mapping[str, Any], Sequence[Any]]


class RecipeError(OptionError):
    """A recipe is invalid.

    Attributes
    ----------
    step : int or None
        The step, counted from 0 in the recipe as given.
    option : str
        The option at fault, or an empty string.
    """

    def __init__(self, message: str, *, step: int | None = None, option: str = "", cure: str = "") -> None:
        super().__init__(message, cure=cure)
        self.step = step
        self.option = option


class Recipe(Sequence[Told]):
    """Steps that have been checked.

    Every step is a mapping: ``"do"`` is its name, the other entries are options of the function of that name. A
    text is a step without options. Reading at the beginning and writing at the end are added if they are
    missing; writing only if the mesh was changed and not yet written.

    Parameters
    ----------
    steps : path, mapping or sequence
        A JSON file; the steps; or a mapping with the steps as ``"steps"``.

    Attributes
    ----------
    hash : str
        SHA-256 of the steps, which identifies finished work.

    Raises
    ------
    RecipeError
        A step or an option is unknown, or has an invalid value.

    Examples
    --------
    >>> from curvmesh.batch import Recipe, RecipeError
    >>> recipe = Recipe(["repair", {"do": "simplify", "ratio": 0.1}, {"do": "distance"}])
    >>> [step["do"] for step in recipe]
    ['read', 'repair', 'simplify', 'distance', 'write']
    >>> try:
    ...     Recipe([{"do": "simplify", "ration": 0.1}])
    ... except RecipeError as error:
    ...     print(error)
    step 1 (simplify): there is no option "ration"; did you mean "ratio"?
    """

    def __init__(self, steps: Steps) -> None:
        self._steps = [_checked(number, step) for number, step in enumerate(_given(steps))]
        #: Number of steps before the first one that was given.
        self._before = 0 if self._steps[0]["do"] == "read" else 1
        if self._before:
            self._steps.insert(0, {"do": "read"})
        names = [step["do"] for step in self._steps]
        if "read" in names[1:]:
            raise self._wrong(names.index("read", 1), "reading comes first")
        if not any(name in ("lod", "write") for name in names) and any(STEPS[n].changes for n in names):
            self._steps.append({"do": "write"})
        self._check_files()
        text = json.dumps(self._steps, sort_keys=True, separators=(",", ":"))
        self.hash = hashlib.sha256(text.encode()).hexdigest()
        self._try()

    def _wrong(self, number: int, message: str, option: str = "", cure: str = "") -> RecipeError:
        place = number - self._before
        told = f"step {place + 1} ({self._steps[number]['do']}): {message}"
        return RecipeError(told, step=place, option=option, cure=cure)

    def _check_files(self) -> None:
        """Checks that no two steps write the same file."""
        usual = {"lod": "lod", "render": "picture", "write": "mesh"}
        seen = set()
        for number, step in enumerate(self._steps):
            if step["do"] in usual:
                name = step.get("name", usual[step["do"]])
                kind = "png" if step["do"] == "render" else step.get("extension", "")
                if (name, kind) in seen:
                    message = f'an earlier step writes "{name}", too; give it another "name"'
                    raise self._wrong(number, message, "name")
                seen.add((name, kind))

    def _try(self) -> None:
        """Runs all steps on a small mesh, to find errors that do not depend on the input."""
        with tempfile.TemporaryDirectory(prefix="curvmesh-") as folder:
            path = os.path.join(folder, "trial.ply")
            try:
                write(path, sphere(1), format=self._steps[0].get("format"))
            except OptionError as error:
                raise self._wrong(0, str(error), "format", error.cure) from None
            work = Work(path, folder, threads=1)
            for number, step in enumerate(self._steps):
                few = {"samples": 100} if step["do"] == "distance" else {}
                try:
                    STEPS[step["do"]].work(work, {**_options(step), **few})
                except CurvmeshError as error:
                    # Other meshes may be large enough, or have the data.
                    if isinstance(error, OptionError) and "values" not in step:
                        raise self._wrong(number, str(error), cure=error.cure) from None

    def do(self, number: int, work: Work) -> Told:
        """Runs one step, and returns its report."""
        step = self._steps[number]
        return STEPS[step["do"]].work(work, _options(step))

    def __getitem__(self, place: Any) -> Any:
        return self._steps[place]

    def __len__(self) -> int:
        return len(self._steps)

    def __iter__(self) -> Iterator[Told]:
        return iter(self._steps)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Recipe) and self.hash == other.hash

    def __hash__(self) -> int:
        return hash(self.hash)

    def __repr__(self) -> str:
        return f"Recipe({self._steps!r})"

    def _repr_html_(self) -> str:
        rows = [(number, step["do"], json.dumps(_options(step))) for number, step in enumerate(self, 1)]
        return grid("Recipe", ["", "step", "options"], rows)

    def __reduce__(self) -> tuple[Any, ...]:
        # A checked recipe is valid on all machines.
        return _restored, (self._steps, self.hash)


def _restored(steps: list[Told], found: str) -> Recipe:
    recipe = Recipe.__new__(Recipe)
    recipe._steps = steps
    recipe._before = 0
    recipe.hash = found
    return recipe


def _options(step: Told) -> Told:
    return {name: value for name, value in step.items() if name != "do"}


def _given(steps: Steps) -> list[Any]:
    """The steps as given."""
    if isinstance(steps, (str, os.PathLike)):
        path = os.fspath(steps)
        try:
            with open(path, encoding="utf-8") as file:
                steps = json.load(file)
        except OSError as error:
            raise RecipeError(f"{path}: {error.strerror or error}") from None
        except ValueError as error:
            raise RecipeError(f"{path}: no JSON: {error}") from None
    if isinstance(steps, Mapping):
        unknown = sorted(set(steps) - {"steps"})
        if "steps" not in steps or unknown:
            what = f'"{unknown[0]}" is not known in it' if unknown else "it has none"
            raise RecipeError(f'a recipe has its steps under "steps"; {what}')
        steps = steps["steps"]
    if not isinstance(steps, Sequence) or isinstance(steps, (str, bytes)):
        raise RecipeError(f"steps are a {type(steps).__name__}; they must be a list")
    found = list(steps)
    if not found:
        raise RecipeError("there are no steps; name one, such as {'do': 'repair'}")
    return found


def _checked(number: int, step: Any) -> Told:
    """A step in its normal form: values of one type each, without ``None``."""
    if isinstance(step, str):
        step = {"do": step}
    if not isinstance(step, Mapping) or not isinstance(step.get("do"), str):
        raise RecipeError(
            f'step {number + 1} is {step!r}; it must be like {{"do": "simplify", "ratio": 0.1}}', step=number
        )
    name = step["do"]
    if name not in STEPS:
        raise RecipeError(f'step {number + 1}: there is no step "{name}"{_similar(name, STEPS)}', step=number)
    options = STEPS[name].options
    found: Told = {"do": name}
    for option, value in step.items():
        if option == "do" or value is None:
            continue
        place = f"step {number + 1} ({name}): "
        if option not in options:
            message = f'{place}there is no option "{option}"{_similar(str(option), options)}'
            raise RecipeError(message, step=number, option=str(option))
        kind = options[option]
        if not kind.fits(value):
            message = f"{place}{option} is {value!r}; it must be {kind.what}"
            raise RecipeError(message, step=number, option=option)
        found[option] = kind.normal(value)
    return found


def _similar(name: str, names: Mapping[str, Any]) -> str:
    close = difflib.get_close_matches(name, names, 1)
    return f'; did you mean "{close[0]}"?' if close else f"; there are {', '.join(names)}"
