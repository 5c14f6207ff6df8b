"""Fixtures shared by the tests."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm

Run = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="session")
def models() -> Path:
    """The folder of real meshes."""
    folder = os.environ.get("CURVMESH_MODELS")
    if not folder:
        pytest.skip("CURVMESH_MODELS names no folder of real meshes")
    return Path(folder)


@pytest.fixture(scope="session")
def program() -> Run:
    """Runs the program `curvmesh`."""
    path = os.environ.get("CURVMESH_PROGRAM")
    if not path:
        pytest.skip("CURVMESH_PROGRAM names no program to compare with")

    def run(*arguments: Any) -> subprocess.CompletedProcess[str]:
        command = [path, *map(str, arguments), "--quiet"]
        return subprocess.run(command, check=True, capture_output=True, text=True)

    return run


@pytest.fixture(scope="session")
def bumpy() -> cm.Mesh:
    """A closed surface without symmetry, of some thousand faces."""
    sphere = cm.shapes.sphere(4)
    p = sphere.vertices
    r = 1 + 0.15 * np.sin(5 * p[:, 0] + 1) * np.cos(4 * p[:, 1]) + 0.05 * np.sin(9 * p[:, 2])
    return sphere.with_vertices(p * r[:, None])


@pytest.fixture(scope="session")
def large() -> cm.Mesh:
    """A surface that takes seconds to process."""
    sphere = cm.shapes.sphere(7)
    p = sphere.vertices
    r = 1 + 0.15 * np.sin(5 * p[:, 0] + 1) * np.cos(4 * p[:, 1]) + 0.01 * np.sin(97 * p[:, 2])
    return sphere.with_vertices(p * r[:, None])
