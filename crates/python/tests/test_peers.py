"""Against other people's code, where it is installed, and round trips through its meshes."""

from __future__ import annotations

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
    """The largest value but for so many percent of outliers."""
    return np.quantile(values, share)


def test_gaussian_and_principal_curvature_of_libigl(bumpy: cm.Mesh) -> None:
    igl = pytest.importorskip("igl")
    v, f = np.array(bumpy.vertices), np.array(bumpy.faces, np.int64)
    k = cm.curvature(bumpy)
    defects = np.asarray(igl.gaussian_curvature(v, f)).ravel()
    np.testing.assert_allclose(k.integral_gaussian, defects, atol=1e-12)
    np.testing.assert_allclose(k.area.sum(), 0.5 * np.asarray(igl.doublearea(v, f)).sum(), rtol=1e-12)
    # Quadrics fitted to five rings there, to two here: smooth, so much the same.
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
    ours = cm.curvature(bumpy).mean
    # Different discretisations of the same quantity.
    assert np.median(np.abs(ours - theirs)) < 0.03 * np.abs(theirs).mean()


def test_curvature_of_pymeshlab(bumpy: cm.Mesh) -> None:
    pymeshlab = pytest.importorskip("pymeshlab")
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.array(bumpy.vertices), np.array(bumpy.faces)))
    meshes.compute_scalar_by_discrete_curvature_per_vertex(curvaturetype="Gaussian Curvature")
    theirs = meshes.current_mesh().vertex_scalar_array()
    ours = cm.curvature(bumpy, area="barycentric")
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


def test_round_trip_through_trimesh(bumpy: cm.Mesh) -> None:
    pytest.importorskip("trimesh")
    mesh = rich(bumpy)
    theirs = mesh.to_trimesh()
    assert theirs.is_watertight and len(theirs.faces) == mesh.face_count
    back = cm.as_mesh(theirs)
    assert back == mesh
    for name in ("colors", "x"):
        np.testing.assert_allclose(back.vertex_data[name], mesh.vertex_data[name], atol=1e-7)
    np.testing.assert_array_equal(back.face_data["part"], mesh.face_data["part"])
    assert cm.simplify(theirs, faces=100).mesh.face_count == 100


def test_textures_go_through_trimesh() -> None:
    pytest.importorskip("trimesh")
    ball = cm.shapes.sphere(3)
    angle = np.arctan2(ball.vertices[:, 1], ball.vertices[:, 0]) / (2 * np.pi)
    uvs = np.column_stack([angle, 0.5 + 0.5 * ball.vertices[:, 2]])[ball.corners]
    # A seam where the angle jumps.
    tall = uvs.reshape(-1, 3, 2)
    across = np.ptp(tall[:, :, 0], axis=1) > 0.5
    tall[across, :, 0] = tall[across, :, 0] % 1.0
    ball.corner_data["uvs"] = uvs
    theirs = ball.to_trimesh()
    assert len(theirs.vertices) > ball.vertex_count
    back = cm.as_mesh(theirs)
    assert back.joins and back.triangulated().vertex_count == ball.vertex_count
    np.testing.assert_allclose(back.corner_data["uvs"], ball.corner_data["uvs"], atol=1e-6)
    small = cm.simplify(back, faces=200)
    assert small.mesh.face_count == 200 and "uvs" in small.mesh.corner_data


def test_round_trip_through_pyvista(bumpy: cm.Mesh) -> None:
    pytest.importorskip("pyvista")
    mesh = rich(bumpy)
    theirs = mesh.to_pyvista()
    assert theirs.n_cells == mesh.face_count and theirs.is_all_triangles
    back = cm.as_mesh(theirs)
    np.testing.assert_allclose(back.vertices, mesh.vertices)
    np.testing.assert_array_equal(back.faces, mesh.faces)
    np.testing.assert_allclose(back.vertex_data["x"], mesh.vertex_data["x"])
    np.testing.assert_allclose(back.vertex_data["colors"], mesh.vertex_data["colors"], atol=1e-7)
    np.testing.assert_array_equal(back.face_data["part"], mesh.face_data["part"])


def test_round_trip_through_open3d(bumpy: cm.Mesh) -> None:
    o3d = pytest.importorskip("open3d")
    mesh = rich(bumpy)
    theirs = mesh.to_open3d()
    assert theirs.is_watertight()
    back = cm.as_mesh(theirs)
    assert back == mesh
    np.testing.assert_allclose(back.vertex_data["colors"], mesh.vertex_data["colors"], atol=1e-6)
    tensors = o3d.t.geometry.TriangleMesh.from_legacy(theirs)
    np.testing.assert_array_equal(cm.as_mesh(tensors).faces, mesh.faces)


def test_round_trip_through_meshio(bumpy: cm.Mesh) -> None:
    meshio = pytest.importorskip("meshio")
    mesh = rich(bumpy)
    back = cm.as_mesh(mesh.to_meshio())
    assert back == mesh
    for name in ("colors", "x"):
        np.testing.assert_allclose(back.vertex_data[name], mesh.vertex_data[name])
    np.testing.assert_array_equal(back.face_data["part"], mesh.face_data["part"])
    mixed = meshio.Mesh(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]],
        [("triangle", [[1, 4, 2]]), ("quad", [[0, 1, 2, 3]]), ("line", [[0, 1]])],
        cell_data={"a": [[1.0], [2.0], [3.0]]},
    )
    found = cm.as_mesh(mixed)
    assert found.face_count == 2 and found.face_data["a"].tolist() == [1, 2]
    with pytest.raises(cm.ArrayError):
        cm.as_mesh(meshio.Mesh([[0, 0, 0], [1, 0, 0]], [("line", [[0, 1]])]))


def test_what_only_looks_like_a_mesh() -> None:
    """Nothing is imported to tell a mesh by what it has."""

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
