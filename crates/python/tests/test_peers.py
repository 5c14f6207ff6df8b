"""Comparison with other packages, if they are installed, and round trips through their meshes."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm


def rich(mesh: cm.Mesh) -> cm.Mesh:
    """A mesh with data of every kind."""
    mesh = mesh.copy()
    shade = (mesh.vertices - mesh.bounds[0]) / (mesh.bounds[1] - mesh.bounds[0])
    mesh.vertex_data.update({"colors": np.round(255 * shade).astype(np.uint8), "x": mesh.vertices[:, 0]})
    mesh.face_data["part"] = np.arange(mesh.face_count) % 3
    return mesh


def interior(values: Any, share: float) -> Any:
    """The largest value except for a share of outliers."""
    return np.quantile(values, share)


def test_gaussian_and_principal_curvature_of_libigl(bumpy: cm.Mesh) -> None:
    igl = pytest.importorskip("igl")
    v, f = np.array(bumpy.vertices), np.array(bumpy.faces, np.int64)
    k = cm.curvature(bumpy, estimator="vertex")
    defects = np.asarray(igl.gaussian_curvature(v, f)).ravel()
    np.testing.assert_allclose(k.integral_gaussian, defects, atol=1e-12)
    np.testing.assert_allclose(k.area.sum(), 0.5 * np.asarray(igl.doublearea(v, f)).sum(), rtol=1e-12)
    # igl fits quadrics to five rings: the surface is smooth, so the curvatures are similar.
    found = igl.principal_curvature(v, f)
    k1, k2 = (np.asarray(found[i]).ravel() for i in (2, 3))
    fit = cm.curvature(bumpy, estimator="fit", rings=5)
    theirs = np.sort(np.column_stack([k1, k2]), axis=1)[:, ::-1]
    sign = np.sign((theirs.sum(axis=1) * fit.mean).sum())
    theirs = theirs if sign > 0 else -theirs[:, ::-1]
    size = np.abs(theirs).max(axis=1).mean()
    assert np.median(np.abs(theirs - fit.principal)) < 0.06 * size
    d1 = np.asarray(found[0])
    clear = np.abs(theirs[:, 0] - theirs[:, 1]) > 0.5 * size
    first = fit.directions[:, 0] if sign > 0 else fit.directions[:, 1]
    assert np.median(np.abs((d1 * first).sum(axis=1))[clear]) > 0.98


def test_mean_curvature_of_libigl(bumpy: cm.Mesh) -> None:
    igl = pytest.importorskip("igl")
    pytest.importorskip("scipy")
    v, f = np.array(bumpy.vertices), np.array(bumpy.faces, np.int64)
    laplacian = igl.cotmatrix(v, f)
    mass = igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    normal = -(laplacian @ v) / mass[:, None]
    size = 0.5 * np.linalg.norm(normal, axis=1)
    theirs = np.where((normal * v).sum(axis=1) > 0, size, -size)
    ours = cm.curvature(bumpy, estimator="vertex").mean
    # Different discretisations of the same quantity.
    assert np.median(np.abs(ours - theirs)) < 0.03 * np.abs(theirs).mean()


def wavy() -> cm.Mesh:
    """A sheet with a boundary."""
    x, y = np.mgrid[0:9, 0:9].reshape(2, -1) / 8
    corners = [9 * i + j for i in range(8) for j in range(8)]
    faces = [[k, k + 9, k + 10] for k in corners] + [[k, k + 10, k + 1] for k in corners]
    return cm.Mesh(np.column_stack([x, y, 0.2 * np.sin(3 * x) * np.cos(2 * y)]), faces)


def test_the_page_is_right_on_integrals_and_boundaries(bumpy: cm.Mesh) -> None:
    """Claims of docs/coming-from.md."""
    for mesh in (bumpy, wavy()):
        auto, vertex = cm.curvature(mesh), cm.curvature(mesh, estimator="vertex")
        inner = ~vertex["boundary"].astype(bool)
        np.testing.assert_allclose(vertex.integral_mean, vertex.mean * vertex.area, atol=1e-12)
        np.testing.assert_allclose(
            vertex.integral_gaussian[inner], (vertex.gaussian * vertex.area)[inner], atol=1e-12
        )
        for name in ("integral_mean", "integral_gaussian", "area"):
            np.testing.assert_allclose(auto[name], vertex[name], atol=1e-12)
        assert not np.allclose(auto.integral_mean, auto.mean * auto.area, rtol=1e-3)
        assert (vertex.gaussian[~inner] == 0).all()
    assert (auto.gaussian[~inner] != 0).any()
    angles = 2 * np.pi * cm.info(mesh).euler_characteristic
    assert vertex.integral_gaussian.sum() == pytest.approx(angles)


def test_curvature_of_pyvista(bumpy: cm.Mesh) -> None:
    """Claims of docs/coming-from.md."""
    pytest.importorskip("pyvista")
    for mesh in (bumpy, wavy()):
        k = cm.curvature(mesh, estimator="vertex", area="barycentric")
        inner = ~k["boundary"].astype(bool)
        theirs = mesh.to_pyvista().curvature("gaussian")
        np.testing.assert_allclose(k.gaussian[inner], theirs[inner], rtol=1e-4, atol=1e-3)
        assert (k.gaussian[~inner] == 0).all() and (theirs[~inner] != 0).all()
    k = cm.curvature(bumpy, estimator="vertex", area="barycentric")
    means = bumpy.to_pyvista().curvature("mean")
    assert np.median(np.abs(k.mean - means)) < 0.03 * np.abs(means).mean()


def test_integral_mean_curvature_of_libigl(bumpy: cm.Mesh) -> None:
    """Claims of docs/coming-from.md."""
    igl = pytest.importorskip("igl")
    v, f = np.array(bumpy.vertices), np.array(bumpy.faces, np.int64)
    integral = 0.5 * np.linalg.norm(igl.cotmatrix(v, f) @ v, axis=1)
    area = igl.massmatrix(v, f, igl.MASSMATRIX_TYPE_VORONOI).diagonal()
    k = cm.curvature((v, f), estimator="vertex")
    np.testing.assert_allclose(k.area, area, rtol=1e-9)
    assert np.median(np.abs(np.abs(k.integral_mean) - integral)) < 0.03 * integral.mean()
    assert np.median(np.abs(np.abs(k.mean) - integral / area)) < 0.03 * (integral / area).mean()


def test_curvature_of_pymeshlab(bumpy: cm.Mesh) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(bumpy.vertices), np.array(bumpy.faces)))
    meshes.compute_scalar_by_discrete_curvature_per_vertex(curvaturetype="Gaussian Curvature")
    theirs = meshes.current_mesh().vertex_scalar_array()
    ours = cm.curvature(bumpy, estimator="vertex", area="barycentric")
    scale = np.abs(theirs).mean()
    assert np.median(np.abs(ours.gaussian - theirs)) < 0.15 * scale
    assert np.corrcoef(ours.gaussian, theirs)[0, 1] > 0.98


def test_distances_of_pymeshlab(bumpy: cm.Mesh) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    small = cm.simplify(bumpy, faces=400).mesh
    meshes = pymeshlab.MeshSet()
    for mesh in (bumpy, small):
        meshes.add_mesh(pymeshlab.Mesh(np.array(mesh.vertices), np.array(mesh.faces)))
    found = meshes.get_hausdorff_distance(
        sampledmesh=0, targetmesh=1, samplevert=True, samplenum=bumpy.vertex_count
    )
    ours = cm.distance(bumpy, small, samples=1000).of_vertices
    assert found["max"] == pytest.approx(ours.max(), rel=1e-5)
    assert found["mean"] == pytest.approx(ours.mean(), rel=1e-4)
    assert found["RMS"] == pytest.approx(np.sqrt((ours**2).mean()), rel=1e-4)


def test_distances_of_open3d(bumpy: cm.Mesh) -> None:
    o3d = pytest.importorskip("open3d")
    small = cm.simplify(bumpy, faces=400).mesh
    scene = o3d.t.geometry.RaycastingScene()
    scene.add_triangles(small.vertices.astype(np.float32), small.faces.astype(np.uint32))
    theirs = scene.compute_distance(bumpy.vertices.astype(np.float32)).numpy()
    ours = cm.distance(bumpy, small, samples=1000).of_vertices
    np.testing.assert_allclose(ours, theirs, atol=2e-6)


def test_distances_of_trimesh(bumpy: cm.Mesh) -> None:
    pytest.importorskip("scipy")
    pytest.importorskip("rtree")
    trimesh = pytest.importorskip("trimesh")
    small = cm.simplify(bumpy, faces=200).mesh
    _, theirs, _ = trimesh.proximity.closest_point(small.to_trimesh(), bumpy.vertices[:500])
    ours = cm.distance(bumpy, small, samples=1000).of_vertices[:500]
    np.testing.assert_allclose(ours, theirs, atol=1e-12)


def test_simplification_is_as_good_as_theirs(bumpy: cm.Mesh) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(bumpy.vertices), np.array(bumpy.faces)))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=500)
    found = meshes.current_mesh()
    theirs = cm.distance(bumpy, (found.vertex_matrix(), found.face_matrix()), samples=50_000)
    ours = cm.distance(bumpy, cm.simplify(bumpy, faces=500).mesh, samples=50_000)
    assert ours.mean < theirs.mean and ours.max < theirs.max


def everything() -> cm.Mesh:
    """A mesh with a seam, a texture, groups, colours, normals, a vector and numbers."""
    mesh = cm.examples.globe(3)
    mesh.groups = [("globe", "north"), ("globe", "south")]
    mesh.face_data["groups"] = np.where(mesh.vertices[mesh.faces].mean(axis=1)[:, 2] > 0, 0, 1)
    mesh.face_data["part"] = np.arange(mesh.face_count) % 3
    velocity = {f"velocity_{axis}": mesh.vertices[:, k] * (k + 1) for k, axis in enumerate("xyz")}
    mesh.vertex_data.update({"x": mesh.vertices[:, 0], "normals": mesh.vertices, **velocity})
    tensor = {f"stress_{k}": mesh.face_data["part"] * k for k in range(6)}
    mesh.face_data.update(tensor)
    return mesh


def to_open3d_tensors(mesh: cm.Mesh) -> Any:
    return mesh.to_open3d(tensor=True)


#: Each package: the conversion to it, and the data that it cannot store.
PACKAGES: dict[str, tuple[Any, set[str]]] = {
    "trimesh": (cm.Mesh.to_trimesh, {"colors"}),
    "pyvista": (cm.Mesh.to_pyvista, set()),
    "vtk": (cm.Mesh.to_vtk, set()),
    "meshio": (cm.Mesh.to_meshio, set()),
    "open3d": (cm.Mesh.to_open3d, {"x", "velocity", "part", "stress", "groups", "face colors"}),
    "open3d tensors": (to_open3d_tensors, {"groups"}),
}


def by_face(mesh: cm.Mesh) -> dict[str, Any]:
    """All data by face or corner, which is independent of splits of vertices; small faces first, as in meshio."""
    sizes = np.diff(mesh.face_ends, prepend=0)
    faces = np.argsort(sizes, kind="stable")
    place = np.empty_like(faces)
    place[faces] = np.arange(len(faces))
    order = np.argsort(np.repeat(place, sizes), kind="stable")
    corners = mesh.corners[order]
    found = {"positions": mesh.vertices[corners]}
    found |= {f"vertex {name}": values[corners] for name, values in mesh.vertex_data.items()}
    found |= {f"corner {name}": values[order] for name, values in mesh.corner_data.items()}
    return found | {f"face {name}": values[faces] for name, values in mesh.face_data.items()}


def assert_kept(mesh: cm.Mesh, back: cm.Mesh, without: set[str]) -> None:
    ours, theirs = by_face(mesh), by_face(back)
    if "face groups" not in theirs and "groups" not in without:
        assert "face groups" not in ours
    # Normals of corners become those of split vertices.
    if "corner normals" in ours and "vertex normals" in theirs:
        theirs["corner normals"] = theirs.pop("vertex normals")
        ours.pop("vertex normals", None)
    for name, values in ours.items():
        kind, _, last = name.partition(" ")
        if name in without or last in without or last.rpartition("_")[0] in without:
            continue
        if last == "normals" and "normals" in without:
            continue
        np.testing.assert_allclose(theirs[name], values, atol=0.003 if last == "colors" else 1e-6, err_msg=name)


def converted(package: str) -> tuple[Any, set[str]]:
    pytest.importorskip(package.partition(" ")[0])
    return PACKAGES[package]


@pytest.mark.parametrize("package", PACKAGES)
@pytest.mark.filterwarnings("ignore:a mesh of:UserWarning")
def test_round_trips_lose_nothing(package: str) -> None:
    pytest.importorskip("PIL")
    to, without = converted(package)
    mesh = everything()
    back = cm.as_mesh(to(mesh))
    assert_kept(mesh, back, without)
    assert back.joins and back.triangulated().vertex_count == mesh.vertex_count
    if "groups" not in without:
        assert back.groups == mesh.groups
    assert len(back.materials) == 1 and len(back.images) == 1
    assert pixels(back) == pixels(mesh)
    plain = cm.shapes.torus()
    again = cm.as_mesh(to(plain))
    np.testing.assert_array_equal(again.faces, plain.faces)
    np.testing.assert_array_equal(again.vertices, plain.vertices)
    assert again.notes == []


def pixels(mesh: cm.Mesh) -> bytes:
    import io

    from PIL import Image

    picture = Image.open(io.BytesIO(mesh.images[0]["data"])).convert("RGB")
    return bytes(picture.tobytes())


@pytest.mark.parametrize("package", PACKAGES)
@pytest.mark.filterwarnings("ignore:a mesh of:UserWarning")
def test_colours_go_through(package: str, bumpy: cm.Mesh) -> None:
    to, without = converted(package)
    mesh = rich(bumpy)
    back = cm.as_mesh(to(mesh))
    for name in ("colors", "x"):
        if name in without and name != "colors":
            continue
        np.testing.assert_allclose(back.vertex_data[name], mesh.vertex_data[name], atol=1e-6)
    if package != "open3d":
        np.testing.assert_array_equal(back.face_data["part"], mesh.face_data["part"])
    faces = bumpy.copy()
    faces.face_data["colors"] = np.tile(np.array([[255, 0, 51]], np.uint8), (bumpy.face_count, 1))
    if package != "open3d":
        found = cm.as_mesh(to(faces)).face_data["colors"]
        np.testing.assert_allclose(found, faces.face_data["colors"], atol=1e-6)


def test_what_has_no_place_is_said() -> None:
    pytest.importorskip("open3d")
    mesh = everything()
    with pytest.warns(UserWarning, match="no place for.*velocity.*groups"):
        mesh.to_open3d()
    assert len(mesh.notes) == 1 and "velocity" in mesh.notes[0] and mesh == everything()


def test_materials_of_tensors_of_open3d() -> None:
    pytest.importorskip("open3d")
    mesh = cm.shapes.cube()
    mesh.materials = [{"name": "paint", "base_color": (1, 0.5, 0.25, 1), "roughness": 0.25, "emissive": (0, 0.5, 0)}]
    mesh.face_data["materials"] = np.zeros(mesh.face_count, int)
    with pytest.warns(UserWarning, match="no place for material 'paint' beside its colours and texture"):
        (found,) = cm.as_mesh(mesh.to_open3d(tensor=True)).materials
    for name in ("base_color", "metallic", "roughness", "emissive"):
        assert found[name] == mesh.materials[0][name], name


def test_data_sets_of_vtk_need_no_pyvista(tmp_path: Path) -> None:
    pytest.importorskip("vtk")
    code = """
import sys
sys.modules["pyvista"] = None
import numpy as np, curvmesh as cm
from vtkmodules.vtkCommonDataModel import vtkMultiBlockDataSet, vtkImageData, vtkCompositeDataSet
from vtkmodules.vtkFiltersCore import vtkStripper, vtkAppendFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource

source = vtkSphereSource()
source.Update()
sphere = source.GetOutput()
mesh = cm.as_mesh(sphere)
assert cm.info(mesh).closed and mesh.face_count == sphere.GetNumberOfCells() and "normals" in mesh.vertex_data
strips = vtkStripper()
strips.SetInputData(sphere)
strips.Update()
assert strips.GetOutput().GetNumberOfStrips() > 0
assert cm.info(cm.as_mesh(strips.GetOutput())).closed
grid = vtkAppendFilter()
grid.AddInputData(sphere)
grid.Update()
found = cm.as_mesh(grid.GetOutput())
assert found.face_count == mesh.face_count and found.notes == []
box = vtkImageData()
box.SetDimensions(3, 3, 3)
found = cm.as_mesh(box)
assert cm.info(found).closed and "surface" in found.notes[0]
blocks = vtkMultiBlockDataSet()
blocks.SetBlock(0, sphere)
blocks.SetBlock(1, box)
blocks.GetMetaData(0).Set(vtkCompositeDataSet.NAME(), "ball")
found = cm.as_mesh(blocks)
assert found.groups == [("ball", ""), ("block 1", "")]
for empty in (vtkMultiBlockDataSet(), sphere.GetPoints().GetData()):
    try:
        cm.as_mesh(empty)
    except cm.ArrayError as error:
        print(error)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "no cells" in done.stdout and "no data set" in done.stdout


#: Real meshes: small ones, or all if `CURVMESH_ALL_MODELS` is set.
REAL = sorted(
    path
    for path in Path(os.environ.get("CURVMESH_MODELS", "/none")).rglob("*")
    if path.suffix.lower() in (".obj", ".glb", ".gltf", ".ply", ".stl", ".off")
    and (path.stat().st_size < 250_000 or os.environ.get("CURVMESH_ALL_MODELS"))
)


#: What a note calls data that a package has no place for, and the columns that it is about.
NAMED = {
    "normals of corners": "normals",
    "colours of faces": "face colors",
    "vertex colors beside": "vertex colors",
    "face colors beside": "face colors",
    "groups": "groups",
    "material": "materials",
    "faces without a material": "materials",
}


def told(mesh: cm.Mesh) -> set[str]:
    """The columns that a mesh could not take along, as its notes say."""
    lost: set[str] = set()
    for note in mesh.notes:
        _, is_about, names = note.partition("has no place for ")
        for name in names.split(", ") if is_about else []:
            lost |= {column for words, column in NAMED.items() if name.startswith(words)} or {name}
    return lost


@pytest.mark.parametrize("package", PACKAGES)
@pytest.mark.parametrize("path", REAL, ids=[path.name for path in REAL])
@pytest.mark.filterwarnings("ignore:a mesh of:UserWarning")
def test_real_models_go_through_every_package(path: Path, package: str) -> None:
    """What does not come back is in the notes of the mesh that was converted."""
    to, _ = converted(package)
    try:
        mesh = cm.read(path)
    except cm.ReadError:
        assert path.stem in ("malformed", "empty")
        return
    if not mesh.is_triangular and package not in ("pyvista", "vtk", "meshio"):
        try:
            mesh = mesh.triangulated()
        except (cm.NonManifoldError, cm.OrientationError, cm.DegenerateFaceError, cm.DuplicateFaceError) as error:
            # Polygons are cut on oriented manifolds; the error names the repair.
            assert error.repair
            with pytest.raises(type(error)):
                to(mesh)
            return
    made = to(mesh)
    lost = told(mesh)
    back = cm.as_mesh(made, check=False)
    assert_kept(mesh, back, lost)
    if "groups" not in lost:
        assert back.groups == mesh.groups
    if "materials" not in lost:
        assert (back.materials, back.images) == (mesh.materials, mesh.images)
    # Only Open3D loses data of real models, and a mesh is not told twice.
    assert package.startswith("open3d") or lost <= {"vertex colors", "face colors"}
    notes = mesh.notes
    to(mesh)
    assert mesh.notes == notes


def test_scenes_and_materials_of_trimesh() -> None:
    trimesh = pytest.importorskip("trimesh")
    image = pytest.importorskip("PIL.Image")
    box = trimesh.creation.box()
    picture = image.new("RGB", (4, 4), (10, 200, 30))
    material = trimesh.visual.material.PBRMaterial(
        name="paint", baseColorFactor=[255, 128, 0, 255], roughnessFactor=0.25, baseColorTexture=picture
    )
    box.visual = trimesh.visual.TextureVisuals(uv=box.vertices[:, :2], material=material)
    mesh = cm.as_mesh(box)
    found = mesh.materials[0]
    assert found["name"] == "paint" and found["roughness"] == 0.25 and found["image"] == 0
    assert pixels(mesh) == picture.tobytes()
    ball = trimesh.creation.icosphere(subdivisions=1)
    scene = trimesh.Scene()
    scene.add_geometry(box, node_name="box")
    scene.add_geometry(ball, node_name="ball", transform=trimesh.transformations.translation_matrix([9, 0, 0]))
    whole = cm.as_mesh(scene)
    assert whole.groups == [("box", ""), ("ball", "")] and whole.face_count == len(box.faces) + len(ball.faces)
    assert whole.bounds[1, 0] > 9.9 and len(whole.images) == 1


def test_other_data_sets_of_pyvista() -> None:
    pv = pytest.importorskip("pyvista")
    sphere = pv.Sphere()
    grid = sphere.cast_to_unstructured_grid()
    assert cm.info(cm.as_mesh(grid)).closed and cm.as_mesh(grid).notes == []
    grid.point_data["h"] = np.arange(grid.n_points)
    assert sorted(cm.as_mesh(grid).vertex_data["h"]) == list(range(grid.n_points))
    box = cm.as_mesh(pv.ImageData(dimensions=(3, 3, 3)))
    assert cm.info(box).closed and "surface" in box.notes[0]
    strips = sphere.strip()
    strips.cell_data["strip"] = np.arange(strips.n_cells)
    found = cm.as_mesh(strips)
    assert cm.info(found).closed and found.face_count == sphere.n_cells
    assert cm.info(found).volume == pytest.approx(sphere.volume, rel=1e-5)
    assert set(found.face_data["strip"]) == set(range(strips.n_cells))
    blocks = pv.MultiBlock({"a": sphere, "b": pv.Cube().triangulate(), "c": None})
    whole = cm.as_mesh(blocks)
    assert whole.groups == [("a", ""), ("b", "")]
    assert whole.face_count == sphere.n_cells + 12
    both = pv.PolyData(sphere.points, faces=sphere.faces, lines=[2, 0, 1])
    both.cell_data["n"] = np.arange(both.n_cells)
    mesh = cm.as_mesh(both)
    assert mesh.face_data["n"].tolist() == list(range(1, both.n_cells)) and "lines" in mesh.notes[0]


def test_the_accessor_and_the_reader_of_pyvista(tmp_path: Path) -> None:
    pv = pytest.importorskip("pyvista")
    if not hasattr(pv, "register_dataset_accessor"):
        pytest.skip("this PyVista has no accessors")
    sphere = pv.Sphere()
    small = sphere.curvmesh.simplify(faces=200)
    assert isinstance(small, pv.PolyData) and small.n_cells == 200
    assert np.median(sphere.curvmesh.curvature().point_data["mean"]) == pytest.approx(2, rel=0.01)
    assert sphere.curvmesh.distance(small, samples=100).point_data["distance"].max() < 0.05
    assert small.curvmesh.flip().n_cells == 200
    assert sphere.curvmesh.info().closed and sphere.curvmesh.render(size=(40, 30)).pixels.shape == (30, 40, 4)
    grid = pv.ImageData(dimensions=(4, 4, 4)).cast_to_unstructured_grid()
    with pytest.warns(UserWarning, match="replaced by their surface"):
        assert grid.curvmesh.curvature().n_points == 56
    assert grid.curvmesh.info().closed
    mixed = pv.PolyData(sphere.points, faces=sphere.faces, lines=[2, 0, 1])
    mixed.point_data["text"] = ["a"] * mixed.n_points
    with pytest.warns(UserWarning) as told:
        assert mixed.curvmesh.simplify(faces=200).n_cells == 200
    assert ["lines" in str(told[0].message), "'text'" in str(told[1].message)] == [True, True]
    cm.write(tmp_path / "a.off", cm.shapes.sphere(2))
    assert pv.read(tmp_path / "a.off").n_cells == 320


def test_cells_of_meshio() -> None:
    meshio = pytest.importorskip("meshio")
    mixed = meshio.Mesh(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]],
        [("triangle", [[1, 4, 2]]), ("quad", [[0, 1, 2, 3]]), ("line", [[0, 1]])],
        cell_data={"a": [[1.0], [2.0], [3.0]]},
        cell_sets={"corner": [[0], [], []], "square": [[], [0], []]},
    )
    found = cm.as_mesh(mixed)
    assert found.face_count == 2 and found.face_data["a"].tolist() == [1, 2]
    assert found.groups == [("", "corner"), ("", "square")] and found.face_data["groups"].tolist() == [0, 1]
    assert found.notes == ["1 cells of type 'line' were left out"]
    with pytest.raises(cm.ArrayError):
        cm.as_mesh(meshio.Mesh([[0, 0, 0], [1, 0, 0]], [("line", [[0, 1]])]))


def test_what_only_looks_like_a_mesh() -> None:
    """Nothing is imported to recognise a mesh by its attributes."""

    class Theirs:
        def __init__(self, **parts: Any) -> None:
            self.__dict__.update(parts)

    points = [[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 2, 1]]
    assert cm.as_mesh(Theirs(vertices=points, faces=[[0, 1, 2]])).face_count == 1
    padded = np.array([3, 0, 1, 2, 4, 0, 1, 2, 3, 3, 1, 4, 2])
    found = cm.as_mesh(Theirs(points=points, faces=padded))
    assert found.face_ends.tolist() == [3, 7, 10]
    assert found.corners.tolist() == [0, 1, 2, 0, 1, 2, 3, 1, 4, 2]
    with pytest.raises(cm.ArrayError, match="no mesh"):
        cm.as_mesh(7)


def faceted() -> cm.Mesh:
    """A torus whose faces have normals of their own, so that files of glTF hold all vertices several times."""
    mesh = cm.shapes.torus(24, 12)
    p = mesh.vertices[mesh.faces]
    normals = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    mesh.corner_data["normals"] = np.repeat(normals / np.linalg.norm(normals, axis=1)[:, None], 3, axis=0)
    return mesh


def assert_like_the_file(scene: Any, path: Path) -> None:
    ours, theirs = cm.info(path), cm.info(scene)
    assert (theirs.closed, theirs.components, theirs.vertices) == (True, 1, ours.vertices)
    assert cm.simplify(scene, ratio=0.25).mesh.face_count == cm.simplify(path, ratio=0.25).mesh.face_count < 150
    assert cm.curvature(scene).totals["abs_mean"] == pytest.approx(cm.curvature(path).totals["abs_mean"])


def test_scenes_join_like_single_meshes(tmp_path: Path) -> None:
    path = tmp_path / "torus.glb"
    faceted().save(path)
    trimesh = pytest.importorskip("trimesh")
    assert_like_the_file(trimesh.load(path), path)


def test_blocks_join_like_single_meshes_also_inside_blocks(tmp_path: Path) -> None:
    path = tmp_path / "torus.glb"
    faceted().save(path)
    pv = pytest.importorskip("pyvista")
    assert_like_the_file(pv.MultiBlock({"a": pv.MultiBlock({"b": faceted().to_pyvista()})}), path)
    assert_like_the_file(pv.read(path), path)
    tree = pv.MultiBlock({"a": pv.MultiBlock({"b": pv.Sphere(), "none": pv.PolyData()}), "c": pv.Cube()})
    mesh = cm.as_mesh(tree)
    assert mesh.groups == [("a/b", ""), ("c", "")] and "'a/none' was left out" in mesh.notes[-1]
    own = pv.MultiBlock({"one": cm.examples.bracket().to_pyvista(), "two": cm.examples.bracket().to_pyvista()})
    assert cm.as_mesh(own).groups == [(part, name) for part in ("one", "two") for name in ("plate", "ring")]


def test_scenes_without_meshes_are_refused_in_words() -> None:
    pv, trimesh = pytest.importorskip("pyvista"), pytest.importorskip("trimesh")
    for empty in (pv.MultiBlock(), pv.MultiBlock({"a": pv.PolyData()}), trimesh.Scene()):
        with pytest.raises(cm.ArrayError, match="has no"):
            cm.as_mesh(empty)


def test_parts_without_a_column() -> None:
    pv, trimesh = pytest.importorskip("pyvista"), pytest.importorskip("trimesh")
    blocks = pv.MultiBlock({"a": pv.Sphere(), "b": pv.Sphere()})
    count = blocks["a"].n_points
    small, ids = np.arange(count), np.arange(count) + 2**60
    blocks["a"].point_data.update({"id": ids, "small": small, "both": ids.astype(np.uint64)})
    blocks["b"].point_data["both"] = ids
    mesh = cm.as_mesh(blocks)
    np.testing.assert_array_equal(mesh.vertex_data["id"], np.append(ids, np.full(count, -1)))
    np.testing.assert_array_equal(mesh.vertex_data["small"], np.append(small, np.full(count, np.nan)))
    np.testing.assert_array_equal(mesh.vertex_data["both"], np.append(ids, ids))
    assert len(mesh.notes) == 1 and "'id' is -1 in parts without it" in mesh.notes[0]
    scene, red = trimesh.Scene(), trimesh.creation.box()
    red.visual.face_colors = [255, 0, 0, 255]
    scene.add_geometry(red, node_name="red")
    scene.add_geometry(trimesh.creation.box(), node_name="plain")
    scene.add_geometry(trimesh.load_path([[0, 0, 0], [1, 1, 1]]), node_name="path")
    mesh = cm.as_mesh(scene)
    assert np.isnan(mesh.face_data["colors"][12:]).all()
    assert ["'plain' without colours" in mesh.notes[0], "'path' was left out" in mesh.notes[1]] == [True, True]
    assert (np.asarray(mesh.to_vtk().GetCellData().GetArray("colors"))[12:] == 255).all()


def test_empty_textures_of_open3d_keep_their_numbers() -> None:
    o3d = pytest.importorskip("open3d")
    mesh = cm.examples.globe(2)
    mesh.materials = [{"name": "plain"}, *mesh.materials]
    mesh.face_data["materials"] = np.arange(mesh.face_count) % 2
    with pytest.warns(UserWarning):
        back = cm.as_mesh(mesh.to_open3d())
    assert [material["image"] for material in back.materials] == [None, 0]
    np.testing.assert_array_equal(back.face_data["materials"], mesh.face_data["materials"])
    box = o3d.geometry.TriangleMesh.create_box()
    box.triangle_material_ids = o3d.utility.IntVector([0, 1] * 6)
    found = cm.as_mesh(box)
    assert found.face_data["material_ids"].tolist() == [0, 1] * 6 and "no textures" in found.notes[0]


@pytest.mark.parametrize("kind, scale", [("f4", 1), ("u2", 65535), ("u1", 255)])
@pytest.mark.parametrize("channels", [1, 3])
def test_textures_of_open3d_of_every_type(kind: str, scale: int, channels: int) -> None:
    o3d = pytest.importorskip("open3d")
    image = pytest.importorskip("PIL.Image")
    pixels = np.linspace(0, scale, 16 * channels).reshape(4, 4, channels).astype(kind)
    box = o3d.geometry.TriangleMesh.create_box(create_uv_map=True)
    box.textures = [o3d.geometry.Image(pixels)]
    mesh = cm.as_mesh(box)
    found = np.array(image.open(io.BytesIO(mesh.images[0]["data"])).convert("RGB"), int)
    assert np.abs(found - 255 * (pixels.astype(float) / scale)).max() <= 0.501
    assert ["8 bits" in note for note in mesh.notes] == [True] * (kind != "u1")


def test_foreign_numbers_are_no_groups_and_materials(tmp_path: Path) -> None:
    pv, trimesh, meshio = (pytest.importorskip(name) for name in ("pyvista", "trimesh", "meshio"))
    ball, box = pv.Sphere(), trimesh.creation.box()
    ids = np.arange(ball.n_cells) % 3 + 1
    ball.cell_data.update({"materials": ids, "groups": ids})
    box.face_attributes["materials"] = box.face_attributes["groups"] = ids[:12]
    box.visual = trimesh.visual.TextureVisuals(uv=box.vertices[:, :2])
    flat = meshio.Mesh(np.eye(3), [("triangle", [[0, 1, 2]])], cell_data={"groups": [[4]], "materials": [[4]]})
    for source in (ball, box, flat):
        mesh = cm.as_mesh(source)
        assert mesh.groups == [] and "groups" not in mesh.face_data and len(mesh.notes) == 2
        for name in ("groups_values", "materials_values"):
            np.testing.assert_array_equal(mesh.face_data[name], ids[: mesh.face_count] if mesh.face_count > 1 else [4])
    ball.point_data.update({"colors": np.arange(ball.n_points), "groups": np.arange(ball.n_points)})
    mesh = cm.as_mesh(ball)
    assert {"colors_values", "groups"} < {*mesh.vertex_data} and "they are no colors" in mesh.notes[0]
    for kind in ("vtu", "vtk"):
        everything().to_meshio().write(tmp_path / f"a.{kind}")
        mesh = cm.as_mesh(meshio.read(tmp_path / f"a.{kind}"))
        np.testing.assert_array_equal(mesh.face_data["groups_values"], everything().face_data["groups"])
        assert "uvs" in mesh.corner_data and "mesh.groups" in mesh.notes[0]


def test_what_trimesh_changed_is_seen() -> None:
    trimesh, image = pytest.importorskip("trimesh"), pytest.importorskip("PIL.Image")
    globe = cm.examples.globe(2)
    globe.materials = [*globe.materials, {"name": "red", "base_color": (1, 0, 0, 1)}]
    globe.face_data["materials"] = np.arange(globe.face_count) % 2
    made = globe.to_trimesh()
    assert cm.as_mesh(made.copy()).images == globe.images and cm.as_mesh(made).materials == globe.materials
    red = image.new("RGB", (8, 8), (255, 0, 0))
    made.visual = trimesh.visual.TextureVisuals(uv=made.visual.uv, image=red)
    back = cm.as_mesh(made)
    assert pixels(back) == red.tobytes() and len(back.materials) == 1 and not back.face_data["materials"].any()
    plain = trimesh.visual.material.PBRMaterial(name="plain", baseColorFactor=[0, 255, 0, 255])
    made.visual = trimesh.visual.TextureVisuals(uv=made.visual.uv, material=plain)
    assert [material["name"] for material in cm.as_mesh(made).materials] == ["plain"] and not cm.as_mesh(made).images
    ball = cm.shapes.sphere(2).to_trimesh()
    assert len(ball.vertex_normals)
    ball.vertices = ball.vertices * [1, 1, -3]
    assert "normals" not in cm.as_mesh(ball).vertex_data
    assert len(ball.vertex_normals)
    np.testing.assert_allclose(cm.as_mesh(ball).vertex_data["normals"], ball.vertex_normals, atol=1e-6)


def test_names_of_groups_are_those_of_the_whole_mesh() -> None:
    """A mesh that another package joined from several has the names of one of them."""
    trimesh, pv = pytest.importorskip("trimesh"), pytest.importorskip("pyvista")
    one = cm.examples.bracket()
    other = one.with_vertices(one.vertices + 20)
    other.groups = [("", "p2"), ("", "r2")]
    for both in (
        trimesh.util.concatenate([one.to_trimesh(), other.to_trimesh()]),
        pv.merge([one.to_pyvista(), other.to_pyvista()]),
    ):
        mesh = cm.as_mesh(both)
        assert mesh.groups == [] and "'plate', 'ring'" in mesh.notes[0] or "'p2', 'r2'" in mesh.notes[0]
        assert sorted(mesh.face_data["groups_values"]) == sorted(list(one.face_data["groups"]) * 2)
    part = one.to_trimesh().submesh([[0, 1, 2]], append=True)
    assert cm.as_mesh(part).groups == one.groups and cm.as_mesh(part).notes == []


@pytest.mark.parametrize("package", PACKAGES)
@pytest.mark.parametrize("join", [True, False, None])
def test_joins_go_through(package: str, join: bool | None) -> None:
    """Two tetrahedra with a common vertex; with normals of corners all vertices are split."""
    to, _ = converted(package)
    p = np.vstack([np.zeros(3), np.eye(3), -np.eye(3)])
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3], [0, 4, 5], [0, 6, 4], [0, 5, 6], [4, 6, 5]]
    apart = [*faces[:4], *([7, *face[1:]] for face in faces[4:7]), faces[7]]
    plain, twins = cm.Mesh(p, faces, join=join), cm.Mesh(np.vstack([p, p[:1]]), apart, join=join)
    for mesh in (plain, twins):
        back = cm.as_mesh(to(mesh))
        told = any(f"joins={join}" in note for note in mesh.notes)
        assert back.joins == join or told or package.startswith("open3d") and mesh is plain
        assert told or cm.info(back).components == cm.info(mesh).components
    if not package.startswith("open3d"):
        plain.corner_data["normals"] = np.random.default_rng(1).random((24, 3))
        back = cm.as_mesh(to(plain))
        assert (back.vertex_count, cm.info(back).components) == (24, cm.info(plain).components)


@pytest.mark.parametrize("package", PACKAGES)
@pytest.mark.filterwarnings("ignore:a mesh of:UserWarning")
def test_names_that_other_packages_use_are_not_lost(package: str) -> None:
    to, without = converted(package)
    mesh = cm.shapes.sphere(2)
    scalars = ["Normals", "Texture Coordinates", "TCoords", "positions", "indices", "vtkGhostType", "v"]
    vectors = [f"{stem}_{axis}" for stem in ("rgb", "Colors", "Normals", "uvs", "positions", "v") for axis in "xyz"]
    values = {name: np.arange(mesh.vertex_count) + k for k, name in enumerate([*scalars, *vectors])}
    mesh.vertex_data.update({"normals": mesh.vertices, **values})
    mesh.vertex_data.update({"mixed_x": values["v"] + 2**60, "mixed_y": values["v"] + 0.5})
    mesh.corner_data["uvs"] = np.zeros((len(mesh.corners), 2))
    back = cm.as_mesh(to(mesh))
    if package == "open3d":
        assert all(name in mesh.notes[-1] for name in scalars)
        return
    for name in mesh.vertex_data:
        found = name if name in back.vertex_data else f"{name}_values"
        assert found == name or any(repr(found) in note for note in mesh.notes)
        np.testing.assert_allclose(back.vertex_data[found], mesh.vertex_data[name], atol=1e-6)
        assert back.vertex_data[found].dtype == mesh.vertex_data[name].dtype or name == "normals"
    np.testing.assert_array_equal(back.vertices, mesh.vertices)


def test_masked_numbers_of_others_are_not_read_as_known() -> None:
    trimesh = pytest.importorskip("trimesh")
    ball = trimesh.creation.icosphere(subdivisions=1)
    ball.vertex_attributes["q"] = np.ma.masked_array(np.arange(42.0), mask=np.arange(42) < 3)
    mesh = cm.as_mesh(ball)
    assert "q" not in mesh.vertex_data and "3 masked" in mesh.notes[0] and "fill" in mesh.notes[0]


def test_what_is_left_out_of_other_meshes_is_in_the_notes() -> None:
    pv, meshio = pytest.importorskip("pyvista"), pytest.importorskip("meshio")
    ball = pv.Sphere().compute_normals(cell_normals=True, point_normals=False)
    ball.field_data["about"] = [1, 2]
    ball.cell_data["vtkGhostType"] = np.zeros(ball.n_cells, np.uint8)
    notes = "; ".join(cm.as_mesh(ball).notes)
    assert all(what in notes for what in ("'about'", "vtkGhostType", "normals of cells"))
    rgb = {name: np.array([255, 0, k, 9], np.uint8) for k, name in enumerate(("red", "green", "blue"))}
    flat = meshio.Mesh(
        np.eye(4)[:, :3], [("triangle", [[0, 1, 2], [1, 2, 3]])], point_data=rgb,
        cell_sets={"a": [[0, 1]], "b": [[1]]}, field_data={"f": np.array([1, 2])}, point_sets={"p": [0, 1]},
    )  # fmt: skip
    mesh = cm.as_mesh(flat)
    assert list(mesh.vertex_data) == ["colors"] and mesh.vertex_data["colors"][0].tolist() == [1, 1, 1, 1]
    notes = "; ".join(mesh.notes)
    assert all(what in notes for what in ("overlap in 1 faces", "field data was left out: 'f'", "sets of points"))


def test_the_order_of_faces_and_vertices() -> None:
    meshio = pytest.importorskip("meshio")
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]]
    mixed = cm.Mesh(square, [[0, 1, 2, 3], [1, 4, 2]])
    assert isinstance(mixed.to_meshio(), meshio.Mesh) and "another order" in mixed.notes[0]
    ball = cm.shapes.sphere(1)
    mesh = cm.Mesh(np.vstack([[[9, 9, 9]], ball.vertices]), ball.faces + 1)
    mesh.corner_data["uvs"] = np.zeros((len(mesh.corners), 2))
    back = cm.as_mesh(mesh.to_meshio())
    np.testing.assert_array_equal(back.vertices, mesh.vertices)
    np.testing.assert_array_equal(back.faces, mesh.faces)


def test_repairs_on_the_way_are_in_the_notes() -> None:
    pytest.importorskip("trimesh")
    square = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
    twice = cm.Mesh(square, [[0, 1, 2, 3], [0, 1, 2, 3]])
    with pytest.warns(cm.RepairWarning):
        twice.to_trimesh()
    assert "repaired" in twice.notes[0] and "duplicate" in twice.notes[0]
