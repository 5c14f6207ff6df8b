# %% [markdown]
# # Curvature of a scan
#
# A scan has noise and triangles of all shapes. Four estimators of curvature give different results.

# %%
import os

import numpy as np

import curvmesh as cm

folder = os.environ.get("CURVMESH_MODELS", "")
path = os.path.join(folder, "igea.ply")
if os.path.exists(path):
    mesh = cm.simplify(cm.repair(path).mesh, faces=60_000, preset="fast").mesh
else:
    # Without a scan, a surface with bumps and a little noise.
    ball = cm.shapes.sphere(6)
    p = ball.vertices
    noise = np.random.default_rng(1).normal(size=len(p))
    r = 1 + 0.15 * np.sin(5 * p[:, 0] + 1) * np.cos(4 * p[:, 1]) + 2e-4 * noise
    mesh = ball.with_vertices(p * r[:, None])
mesh

# %%
cm.info(mesh)

# %% [markdown]
# Discrete curvature is defined at vertices and edges: its integrals are exact, and noise is not smoothed.

# %%
k = cm.curvature(mesh, estimator="vertex")
print("the theorem of Gauss and Bonnet:", k.totals["gaussian"] / (2 * np.pi))
k

# %%
cm.render(mesh, k.mean, label="H, discrete", size=(640, 560), smooth=True)

# %% [markdown]
# Averages over balls, and normal sections through each face, reduce noise and keep the shape.

# %%
ball_curvature = cm.curvature(mesh, estimator="ball", radius="1.5%")
cm.render(mesh, ball_curvature.mean, label="H, balls", size=(640, 560), smooth=True)

# %%
sections = cm.curvature(mesh, estimator="face")
cm.render(mesh, sections.mean, label="H, sections", size=(640, 560))

# %% [markdown]
# Quadratic surfaces fitted to rings of neighbours give principal directions.

# %%
fit = cm.curvature(mesh, estimator="fit", rings=3)
inner = np.abs(fit.mean) < np.nanquantile(np.abs(fit.mean), 0.98)
for name, other in (("discrete", k), ("balls", ball_curvature)):
    print(name, "correlates with the fit by", round(np.corrcoef(fit.mean[inner], other.mean[inner])[0, 1], 3))
cm.render(mesh, fit.shape_index, label="shape index", size=(640, 560), smooth=True, range=(-1.0, 1.0))

# %% [markdown]
# All results on an interactive page, with the values under the pointer and the directions as lines.

# %%
page = cm.view(fit, names=["scan"], title="Curvature of a scan")
page
