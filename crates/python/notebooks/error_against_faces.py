# %% [markdown]
# # Error against face count
#
# The same surface simplified to decreasing numbers of faces, by curvmesh and all other installed packages. All
# results are measured by the same code: samples in both directions, and exact closest points.

# %%
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import curvmesh as cm

ball = cm.shapes.sphere(5)
p = ball.vertices
r = 1 + 0.15 * np.sin(5 * p[:, 0] + 1) * np.cos(4 * p[:, 1]) + 0.02 * np.sin(23 * p[:, 2])
mesh = ball.with_vertices(p * r[:, None])
mesh

# %%
Simplifier = Callable[[int], Any]


def peers() -> dict[str, Simplifier]:
    """Functions that simplify the mesh, including installed other packages."""
    v, f = np.array(mesh.vertices), np.array(mesh.faces)
    found: dict[str, Simplifier] = {
        "curvmesh, fast": lambda n: cm.simplify(mesh, faces=n, preset="fast").mesh,
        "curvmesh, default": lambda n: cm.simplify(mesh, faces=n).mesh,
    }
    try:
        import pymeshlab

        def meshlab(n: int) -> Any:
            meshes = pymeshlab.MeshSet()
            meshes.add_mesh(pymeshlab.Mesh(v, f))
            meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=n)
            made = meshes.current_mesh()
            return made.vertex_matrix(), made.face_matrix()

        found["PyMeshLab"] = meshlab
    except ImportError:
        print("PyMeshLab is not installed")
    try:
        import open3d

        legacy = mesh.to_open3d()
        found["Open3D"] = lambda n: legacy.simplify_quadric_decimation(n)
        del open3d
    except ImportError:
        print("Open3D is not installed")
    try:
        import fast_simplification

        found["fast-simplification"] = lambda n: fast_simplification.simplify(v, f, target_count=n)
    except ImportError:
        print("fast-simplification is not installed")
    return found


# %%
counts = [4000, 1000, 250]
rows = []
for name, simplify in peers().items():
    for count in counts:
        start = time.perf_counter()
        result = simplify(count)
        seconds = time.perf_counter() - start
        d = cm.distance(mesh, result, samples=100_000)
        rows.append((name, count, d.mean, d.max, seconds))
        print(f"{name:22} {count:6} faces  mean {d.mean:.3e}  largest {d.max:.3e}  {seconds:6.2f} s")

# %%
ours = {count: mean for name, count, mean, _, _ in rows if name == "curvmesh, default"}
for name, count, mean, _, _ in rows:
    assert mean >= 0.999 * ours[count], f"{name} is nearer at {count} faces"

# %% [markdown]
# The errors on the surface, at 250 faces.

# %%
small = cm.simplify(mesh, faces=250)
d = cm.distance(mesh, small.mesh, samples=100_000)
cm.render(mesh, d.of_vertices, label="distance", size=(640, 560), smooth=True)

# %%
cm.view(
    mesh, small.mesh, names=["original", "250 faces"],
    values=[{"distance": d.of_vertices}, {"distance": d.of_other_vertices}], color="distance",
)
