"""Inputs, and the names of their results."""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple, Union

from .._errors import CurvmeshError, OptionError
from ._steps import FORMATS
from ._store import file_system, is_url

#: A path, a pattern, a folder or a URL, or several.
Inputs = Union[str, "os.PathLike[str]", Iterable[Union[str, "os.PathLike[str]"]]]


class InputError(CurvmeshError, ValueError):
    """There are no inputs, or several whose results would have the same path."""


class Source(NamedTuple):
    """An input: the name of its results, and its path or URL."""

    name: str
    path: str


def sources(inputs: Inputs, output: str) -> list[Source]:
    """All inputs by name.

    Raises
    ------
    InputError
        A folder or a pattern has no mesh files, or two inputs have the same name.
    """
    if isinstance(inputs, (str, os.PathLike)):
        inputs = [inputs]
    by_name: dict[str, str] = {}
    for given in inputs:
        path = os.fspath(given)
        if not is_url(path):
            # Workers may have another working folder.
            path = os.path.abspath(path)
        count = 0
        for source in _expanded(path, output):
            count += 1
            other = by_name.setdefault(source.name, source.path)
            if other != source.path:
                raise InputError(
                    f"the results of {other} and {source.path} would go to the same place",
                    cure="name the folder that both are in; their results then go to folders like theirs",
                )
        if not count:
            raise InputError(f"{path}: no mesh files ({', '.join(FORMATS)})", path=path)
    if not by_name:
        raise InputError("there are no inputs")
    return [Source(name, by_name[name]) for name in sorted(by_name)]


def shard_of(found: list[Source], shard: str | tuple[int, int] | None) -> tuple[list[Source], str]:
    """The K-th of N parts of the inputs, and the suffix of the names of its reports."""
    if shard is None:
        return found, ""
    match = re.fullmatch(r"(\d+)/(\d+)", shard) if isinstance(shard, str) else None
    number, of = map(int, match.groups()) if match else (0, 0) if isinstance(shard, str) else shard
    if not 1 <= number <= of:
        raise OptionError(f"shard is {shard!r}; it must be which part of how many, like 2/16")
    return found[number - 1 :: of], f"-{number}-of-{of}"


def _expanded(path: str, output: str) -> Iterator[Source]:
    """The inputs of a path, pattern, folder or URL."""
    if is_url(path):
        return _of_url(path, output)
    if os.path.isdir(path):
        return _of_folder(path, output)
    if glob.has_magic(path) and not os.path.lexists(path):
        return _of_pattern(path, output)
    # A missing file is a failure of this input alone.
    return iter([Source(_name(os.path.basename(path), path), path)])


def _of_folder(root: str, output: str) -> Iterator[Source]:
    """The mesh files of a folder and its subfolders, except those in the output."""
    away = None if is_url(output) else os.path.realpath(output)
    for folder, below, names in os.walk(root):
        below[:] = [
            name
            for name in below
            if not name.startswith(".") and os.path.realpath(os.path.join(folder, name)) != away
        ]
        for name in names:
            if _is_mesh(name):
                path = os.path.join(folder, name)
                yield Source(_name(os.path.relpath(path, root), path), path)


def _of_pattern(pattern: str, output: str) -> Iterator[Source]:
    """The files that match a pattern, named relative to the last folder without a wildcard."""
    root = _sure(pattern)
    away = None if is_url(output) else os.path.realpath(output) + os.sep
    for path in glob.iglob(pattern, recursive=True):
        if os.path.isfile(path) and not (away and os.path.realpath(path).startswith(away)):
            yield Source(_name(os.path.relpath(path, root or "."), path), path)


def _of_url(url: str, output: str) -> Iterator[Source]:
    fs, inside = file_system(url)
    scheme = url.split("://", 1)[0]
    away = file_system(output)[1].rstrip("/") + "/" if is_url(output) else None

    def named(path: str, root: str) -> Source:
        name = path[len(root) :].lstrip("/") if path.startswith(root) else os.path.basename(path)
        return Source(_name(name, path), fs.unstrip_protocol(path) if scheme != "file" else f"file://{path}")

    if glob.has_magic(inside):
        found = [path for path in fs.glob(inside) if not fs.isdir(path)]
        root = _sure(inside)
    elif fs.isdir(inside):
        found = [path for path in fs.find(inside) if _is_mesh(path) and "/." not in path]
        root = inside
    else:
        return iter([Source(_name(os.path.basename(inside), url), url)])
    return (named(path, root) for path in found if not (away and path.startswith(away)))


def _sure(pattern: str) -> str:
    """The folder before the first part with a wildcard."""
    parts = pattern.replace(os.sep, "/").split("/")
    place = next(place for place, part in enumerate(parts) if glob.has_magic(part))
    return "/".join(parts[:place]) or ("/" if pattern.startswith("/") else "")


def _is_mesh(name: str) -> bool:
    return os.path.splitext(name)[1].lower().lstrip(".") in FORMATS


def _name(name: str, path: str) -> str:
    """The normalised name of the results. Refuses names outside the output."""
    parts = [part for part in name.replace(os.sep, "/").split("/") if part not in ("", ".")]
    if not parts or ".." in parts:
        raise InputError(f"{path}: it has no name below the folder that it was found from", path=path)
    return "/".join(parts)
