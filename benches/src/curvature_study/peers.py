"""Principal curvatures by other packages.

``python peers.py FOLDER`` reads lines from the standard input: the name of a program, a tab, a radius. For each line, it
reads the raw arrays ``vertices.raw`` (float64) and ``faces.raw`` (uint32) from the folder, writes both principal
curvatures of every vertex to ``out.raw`` (float64, two per vertex), and prints the seconds of the computation, or
``failed``. Without arguments, it prints the names of the programs that can be imported.
"""

import importlib.util
import os
import sys
import time
from pathlib import Path

import numpy as np


def split(mean, gaussian):
    root = np.sqrt(np.maximum(mean * mean - gaussian, 0.0))
    return np.stack([mean + root, mean - root], axis=1)


def igl(rings):
    def run(vertices, faces, _):
        import igl

        found = igl.principal_curvature(vertices, faces, rings)
        return np.stack([found[2], found[3]], axis=1)

    return run


def meshlab(method):
    def run(vertices, faces, _):
        import pymeshlab

        found = []
        for shown in ("Max Curvature", "Min Curvature"):
            meshes = pymeshlab.MeshSet()
            meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
            meshes.compute_curvature_principal_directions_per_vertex(
                method=method, curvcolormethod=shown, autoclean=False
            )
            found.append(meshes.current_mesh().vertex_scalar_array())
        return np.stack(found, axis=1)

    return run


def vtk(vertices, faces, _):
    import pyvista

    mesh = pyvista.PolyData.from_regular_faces(vertices, faces)
    return split(mesh.curvature("mean"), mesh.curvature("gaussian"))


def trimesh_measure(vertices, faces, radius):
    import trimesh
    from trimesh import curvature

    mesh = trimesh.Trimesh(vertices, faces, process=False)
    area = np.pi * radius * radius
    mean = curvature.discrete_mean_curvature_measure(mesh, vertices, radius) / area
    gaussian = curvature.discrete_gaussian_curvature_measure(mesh, vertices, radius) / area
    return split(mean, gaussian)


PROGRAMS = {
    "libigl, 2 rings": ("igl", igl(2)),
    "libigl, 3 rings": ("igl", igl(3)),
    "libigl, 5 rings": ("igl", igl(5)),
    "MeshLab, Taubin": ("pymeshlab", meshlab("Taubin approximation")),
    "MeshLab, PCA": ("pymeshlab", meshlab("Principal Component Analysis")),
    "MeshLab, normal cycles": ("pymeshlab", meshlab("Normal Cycles")),
    "MeshLab, quadric": ("pymeshlab", meshlab("Quadric Fitting")),
    "MeshLab, scale-dependent": ("pymeshlab", meshlab("Scale Dependent Quadric Fitting")),
    "VTK": ("pyvista", vtk),
    "trimesh": ("trimesh", trimesh_measure),
}


def main():
    if len(sys.argv) == 1:
        print("\n".join(n for n, (module, _) in PROGRAMS.items() if importlib.util.find_spec(module)))
        return
    folder = Path(sys.argv[1])
    # Some packages print to the standard output.
    answers = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)
    for line in sys.stdin:
        name, radius = line.rstrip("\n").split("\t")
        vertices = np.fromfile(folder / "vertices.raw", dtype=np.float64).reshape(-1, 3)
        faces = np.fromfile(folder / "faces.raw", dtype=np.uint32).reshape(-1, 3).astype(np.int64)
        module, run = PROGRAMS[name]
        # Imports are not timed.
        importlib.import_module(module)
        try:
            start = time.perf_counter()
            found = run(vertices, faces, float(radius))
            seconds = time.perf_counter() - start
            np.ascontiguousarray(found, dtype=np.float64).tofile(folder / "out.raw")
            print(seconds, file=answers)
        except Exception as error:
            print(f"{name}: {error}", file=sys.stderr)
            print("failed", file=answers)


if __name__ == "__main__":
    main()
