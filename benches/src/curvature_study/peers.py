"""Principal curvatures by other packages.

``python peers.py FOLDER`` reads lines from the standard input: the name of a program, a tab, a radius. For each line, it
reads the raw arrays ``vertices.raw`` (float64) and ``faces.raw`` (uint32) from the folder, writes both principal
curvatures of every vertex to ``out.raw`` (float64, two per vertex), and prints the seconds of processor time of the
computation and the bytes that it used beyond the input (a dash if the system does not report them), or ``failed``.

Without arguments, it prints the programs, one a line: the name, a tab, the package and its version; or the name and two
tabs if the package cannot be imported.
"""

import importlib.metadata
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

    # Each call computes both curvatures, and shows one.
    run.calls = 2
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


def trueform(rings):
    def run(vertices, faces, _):
        import trueform

        return np.stack(trueform.principal_curvatures((faces.astype(np.int32), vertices), k=rings), axis=1)

    return run


def gpytoolbox(vertices, faces, _):
    import gpytoolbox

    areas = gpytoolbox.massmatrix(vertices, faces, type="voronoi").diagonal()
    vectors = 0.5 * (gpytoolbox.cotangent_laplacian(vertices, faces) @ vertices) / areas[:, None]
    mean = np.sum(vectors * gpytoolbox.per_vertex_normals(vertices, faces), axis=1)
    return split(mean, gpytoolbox.angle_defect(vertices, faces) / areas)


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
    "trueform, 1 ring": ("trueform", trueform(1)),
    "trueform, 2 rings": ("trueform", trueform(2)),
    "trueform, 3 rings": ("trueform", trueform(3)),
    "gpytoolbox": ("gpytoolbox", gpytoolbox),
}


# The package that has a module, if it has another name.
PACKAGES = {"igl": "libigl"}


def describe(name):
    module = PROGRAMS[name][0]
    if importlib.util.find_spec(module) is None:
        return f"{name}\t\t"
    package = PACKAGES.get(module, module)
    return f"{name}\t{package} {importlib.metadata.version(package)}"


def memory(field):
    with open("/proc/self/status") as status:
        line = next(line for line in status if line.startswith(field))
    return 1024 * int(line.split()[1])


def used_before():
    """The memory in use, after the peak is reset. None if the system does not report it."""
    try:
        with open("/proc/self/clear_refs", "w") as file:
            file.write("5")
        return memory("VmRSS:")
    except OSError:
        return None


def main():
    if len(sys.argv) == 1:
        print("\n".join(map(describe, PROGRAMS)))
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
            before = used_before()
            start = time.process_time()
            found = run(vertices, faces, float(radius))
            seconds = (time.process_time() - start) / getattr(run, "calls", 1)
            peak = "-" if before is None else max(memory("VmHWM:") - before, 0)
            np.ascontiguousarray(found, dtype=np.float64).tofile(folder / "out.raw")
            print(seconds, peak, file=answers)
        except Exception as error:
            print(f"{name}: {error}", file=sys.stderr)
            print("failed", file=answers)


if __name__ == "__main__":
    main()
