from .curvature import curvature as _curvature
from .distance import distance as _distance
from .files import save as _save
from .flip import flip as _flip
from .info import info as _info
from .info import repair as _repair
from .packages.meshio import to_meshio as _to_meshio
from .packages.open3d import to_open3d as _to_open3d
from .packages.pyvista import to_pyvista as _to_pyvista
from .packages.trimesh import to_trimesh as _to_trimesh
from .packages.vtk import to_vtk as _to_vtk
from .show import card as _card
from .show import view as _view
from .simplify import simplify as _simplify

__all__ = ["Methods"]

class Methods:
    curvature = _curvature
    distance = _distance
    flip = _flip
    info = _info
    plot = _view
    repair = _repair
    save = _save
    simplify = _simplify
    to_meshio = _to_meshio
    to_open3d = _to_open3d
    to_pyvista = _to_pyvista
    to_trimesh = _to_trimesh
    to_vtk = _to_vtk
    _repr_html_ = _card
