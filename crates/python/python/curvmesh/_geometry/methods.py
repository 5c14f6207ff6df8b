"""Functions of the modules above as methods of :class:`Mesh`."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from types import MethodType
from typing import Any

__all__ = ["Methods"]


class _Method:
    """Makes a method from a function: the mesh is its first argument.

    The module of the function is imported at the first call, so that no module imports a module above it.
    """

    def __init__(self, module: str, name: str) -> None:
        self._module = module
        self._name = name

    def __get__(self, mesh: Any, owner: type) -> Callable[..., Any]:
        module = import_module(f".{self._module}", __package__)
        function: Callable[..., Any] = getattr(module, self._name)
        return function if mesh is None else MethodType(function, mesh)


class Methods:
    """The methods. ``methods.pyi`` shows type checkers the functions themselves."""

    __slots__ = ()

    curvature = _Method("curvature", "curvature")
    distance = _Method("distance", "distance")
    flip = _Method("flip", "flip")
    info = _Method("info", "info")
    plot = _Method("show", "view")
    repair = _Method("info", "repair")
    save = _Method("files", "save")
    simplify = _Method("simplify", "simplify")
    to_meshio = _Method("packages.meshio", "to_meshio")
    to_open3d = _Method("packages.open3d", "to_open3d")
    to_pyvista = _Method("packages.pyvista", "to_pyvista")
    to_trimesh = _Method("packages.trimesh", "to_trimesh")
    to_vtk = _Method("packages.vtk", "to_vtk")
    _repr_html_ = _Method("show", "card")
