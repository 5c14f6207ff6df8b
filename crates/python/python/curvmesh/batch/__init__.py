"""Batch processing of many meshes: recipes as data, on this machine, Dask or Ray.

:func:`run` applies the steps of a :class:`Recipe` to every input and returns a :class:`Report`. Engines run a
:class:`Task` for each input, which writes files and a record. The same is available on the command line:
``python -m curvmesh.batch recipe.json scans/ -o out/ --shard 3/64``.
"""

from __future__ import annotations

from ._inputs import InputError, Source
from ._recipe import Recipe, RecipeError
from ._run import Report, gather, run
from ._task import Task

__all__ = ["InputError", "Recipe", "RecipeError", "Report", "Source", "Task", "gather", "run"]
