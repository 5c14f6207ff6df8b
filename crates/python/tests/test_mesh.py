"""Arrays in and out, data by name, errors with ids."""

from __future__ import annotations

import pickle
import tracemalloc
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import curvmesh as cm

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
TWO = np.array([[0, 1, 2], [0, 2, 3]])

FLOATS = ["f4", "f8", "f2", ">f8", ">f4", "i4", "u1"]
INTEGERS = ["i4", "i8", "u4", "u8", "i2", "u2", "i1", ">i4", ">i8", ">u4"]


def laid_out(array: np.ndarray[Any, Any], layout: str) -> np.ndarray[Any, Any]:
    """The same numbers in another memory layout."""
    rows, columns = array.shape
    if layout == "fortran":
        return np.asfortranarray(array)
    if layout == "strided":
        wide = np.zeros((2 * rows, 3 * columns), array.dtype)
        wide[::2, ::3] = array
        return wide[::2, ::3]
    if layout == "reversed":
        return np.ascontiguousarray(array[::-1, ::-1])[::-1, ::-1]
    if layout == "unaligned":
        raw = np.zeros(array.nbytes + 1, np.uint8)
        shifted: np.ndarray[Any, Any] = raw[1:].view(array.dtype).reshape(array.shape)
        shifted[:] = array
        return shifted
    if layout == "read-only":
        array = array.copy()
        array.flags.writeable = False
    return array


LAYOUTS = ["plain", "fortran", "strided", "reversed", "unaligned", "read-only"]


@settings(deadline=None, max_examples=120)
@given(
    st.sampled_from(FLOATS),
    st.sampled_from(INTEGERS),
    st.sampled_from(LAYOUTS),
    st.sampled_from(LAYOUTS),
    st.integers(0, 40),
    st.data(),
)
def test_arrays_of_any_layout(
    number: str, index: str, of_points: str, of_faces: str, count: int, data: st.DataObject
) -> None:
    seed = data.draw(st.integers(0, 2**32 - 1))
    random = np.random.default_rng(seed)
    points = random.integers(0, 100, (count + 3, 3)).astype(number)
    faces = random.integers(0, count + 3, (count, 3)).astype(index)
    mesh = cm.Mesh(laid_out(points, of_points), laid_out(faces, of_faces))
    assert mesh.vertices.dtype == np.float64 and mesh.faces.dtype == np.int32
    np.testing.assert_array_equal(mesh.vertices, points.astype(float))
    np.testing.assert_array_equal(mesh.faces, faces.astype(np.int64))


@settings(deadline=None, max_examples=60)
@given(st.integers(-5, 60), st.integers(0, 11), st.sampled_from(["i4", "i8", "u8"]))
def test_indices_out_of_range_are_told(value: int, place: int, kind: str) -> None:
    faces = cm.shapes.octahedron().faces.astype(kind)
    if value < 0 and kind[0] == "u":
        return
    faces = faces.copy()
    faces[place % 8, place % 3] = value
    if 0 <= value < 6:
        cm.Mesh(cm.shapes.octahedron().vertices, faces)
        return
    with pytest.raises(cm.OutOfRangeError) as caught:
        cm.Mesh(cm.shapes.octahedron().vertices, faces)
    assert caught.value.faces == [place % 8] and caught.value.count == 1


def test_views_share_memory_and_stay_alive() -> None:
    mesh = cm.shapes.sphere(3)
    first, second = mesh.vertices, mesh.vertices
    assert first.__array_interface__["data"] == second.__array_interface__["data"]
    assert not first.flags.writeable and not mesh.faces.flags.writeable
    with pytest.raises(ValueError):
        first[0, 0] = 1
    kept = cm.shapes.sphere(3).vertices
    np.testing.assert_array_equal(kept, first)


def test_views_allocate_nothing() -> None:
    mesh = cm.shapes.sphere(6)
    tracemalloc.start()
    for _ in range(100):
        assert mesh.vertices.shape[1] == 3 and mesh.faces.shape[1] == 3
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert peak < 50_000


@pytest.mark.parametrize(
    "vertices, faces, error",
    [
        (SQUARE[:, :2], TWO, cm.ArrayError),
        (SQUARE.ravel(), TWO, cm.ArrayError),
        (SQUARE, TWO.ravel(), cm.ArrayError),
        (SQUARE, TWO[:, :2], cm.ArrayError),
        (SQUARE, TWO.astype(float), cm.ArrayError),
        (SQUARE.astype(complex), TWO, cm.ArrayError),
        (SQUARE.astype(str), TWO, cm.ArrayError),
        (SQUARE, [[0, 1, 9]], cm.OutOfRangeError),
        (SQUARE, [[0, 1, -1]], cm.OutOfRangeError),
        (SQUARE, np.array([[0, 1, 2**40]]), cm.OutOfRangeError),
        (np.where(SQUARE == 1, np.nan, SQUARE), TWO, cm.NotFiniteError),
        (np.where(SQUARE == 1, np.inf, SQUARE), TWO, cm.NotFiniteError),
    ],
)
def test_bad_arrays_are_refused(vertices: Any, faces: Any, error: type[Exception]) -> None:
    with pytest.raises(error) as caught:
        cm.Mesh(vertices, faces)
    assert isinstance(caught.value, cm.CurvmeshError)


def test_vertices_at_no_place_are_dropped_with_their_faces(tmp_path: Path) -> None:
    nowhere = np.where(np.arange(4)[:, None] == 3, np.nan, SQUARE)
    with pytest.raises(cm.NotFiniteError, match="drop_not_finite") as caught:
        cm.Mesh(nowhere, TWO)
    assert caught.value.repair == "drop_not_finite"
    fixed = cm.repair((nowhere, TWO), drop_not_finite=True)
    assert (fixed.mesh.vertex_count, fixed.mesh.face_count) == (3, 1)
    assert fixed.counts["not_finite_vertices"] == 1 and fixed.counts["dropped_not_finite"] == 1
    (tmp_path / "scan.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 nan\nf 1 2 3\nf 2 4 3\n")
    scan = cm.read(tmp_path / "scan.obj")
    with pytest.warns(cm.RepairWarning, match="undefined positions: 1"):
        assert cm.distance(scan, scan).max < 1e-12
    with pytest.warns(cm.RepairWarning, match="undefined positions: 1"):
        assert cm.curvature(scan).mean.shape == (4,)


def test_the_error_has_ids_and_repair() -> None:
    def refused(faces: Any) -> cm.CurvmeshError:
        with pytest.raises(cm.CurvmeshError) as caught:
            cm.Mesh(np.vstack([SQUARE, SQUARE + [0, 0, 1]]), faces).validate()
        return caught.value

    error = refused([[0, 1, 2], [1, 0, 3], [0, 1, 4]])
    assert isinstance(error, cm.NonManifoldError)
    assert error.edges == [(0, 1)] and error.faces == [0, 1, 2] and error.repair == "cut_non_manifold"
    error = refused([[0, 1, 2], [0, 1, 3]])
    assert isinstance(error, cm.OrientationError) and error.repair == "reorient"
    error = refused([[0, 1, 1]])
    assert isinstance(error, cm.DegenerateFaceError) and error.faces == [0]
    error = refused([[0, 1, 2], [1, 2, 0]])
    assert isinstance(error, cm.DuplicateFaceError) and error.repair == "drop_duplicates"
    error = refused([[0, 1, 2], [0, 5, 6]])
    assert isinstance(error, cm.NonManifoldError) and error.vertices == [0]
    assert f"curvmesh.repair(mesh, {error.repair}=True)" in str(error)


@pytest.mark.parametrize(
    "work",
    [
        lambda mesh: cm.simplify(mesh, ratio=0.5),
        lambda mesh: cm.curvature(mesh),
        lambda mesh: cm.flip(mesh),
        lambda mesh: cm.patch(mesh, tolerance="1%"),
        lambda mesh: cm.lod(mesh, ratios=[0.5]),
        lambda mesh: cm.subdivide(mesh),
        lambda mesh: cm.render(mesh),
    ],
)
def test_what_is_no_manifold_is_repaired_with_a_warning(work: Any) -> None:
    ball = cm.shapes.sphere(3)
    faces = np.vstack([ball.faces, ball.faces[:1], [[0, 5, 9]]])
    broken = cm.Mesh(ball.vertices, faces)
    with pytest.raises(cm.CurvmeshError) as caught:
        broken.validate()
    assert caught.value.repair
    with pytest.warns(cm.RepairWarning, match="duplicate.*: 1.*repair"):
        work(broken)
    with pytest.raises(type(caught.value)):
        broken.validate()
    with warnings.catch_warnings():
        warnings.simplefilter("error", cm.RepairWarning)
        work(broken)  # One warning for each mesh.
        work(cm.repair(broken).mesh)
        with pytest.raises(cm.RepairWarning):
            work(cm.Mesh(ball.vertices, faces))


@pytest.mark.filterwarnings("ignore::curvmesh.RepairWarning")
def test_where_the_surface_is_cut_a_vertex_has_no_curvature() -> None:
    ball = cm.shapes.sphere(3)
    other = cm.Mesh(
        np.vstack([ball.vertices, ball.vertices[1:] + 2 * ball.vertices[0]]),
        np.vstack([ball.faces, np.where(ball.faces == 0, 0, ball.faces + ball.vertex_count - 1)]),
    )
    found = cm.curvature(other, estimator="vertex")
    assert np.isnan(found.mean[0]) and np.isfinite(found.mean[1:]).all()
    assert len(cm.simplify(other, ratio=0.5).mesh.faces) <= ball.face_count


def test_data_by_name(tmp_path: Path) -> None:
    mesh = cm.Mesh(
        SQUARE,
        TWO,
        vertex_data={"quality": [1, 2, 3, 4], "colors": np.array([[255, 0, 51]] * 4, np.uint8)},
        corner_data={"uvs": SQUARE[TWO.ravel(), :2]},
        face_data={"part": [7, 8]},
    )
    assert sorted(mesh.vertex_data) == ["colors", "quality"]
    np.testing.assert_allclose(mesh.vertex_data["colors"][0], [1, 0, 0.2, 1])
    other = mesh.copy()
    other.vertex_data["quality"] = [0, 0, 0, 1]
    assert mesh.vertex_data["quality"].tolist() == [1, 2, 3, 4]
    del other.vertex_data["quality"]
    assert "quality" not in other.vertex_data
    with pytest.raises(KeyError):
        del other.vertex_data["quality"]
    wrong: list[tuple[str, Any]] = [
        ("quality", [1, 2]),
        ("normals", np.zeros((4, 2))),
        ("deep", np.zeros((4, 3))),
    ]
    for name, values in wrong:
        with pytest.raises(cm.ArrayError):
            mesh.vertex_data[name] = values
    for format in ("ply", "obj", "glb"):
        path = tmp_path / f"square.{format}"
        cm.write(path, mesh)
        back = cm.read(path)
        assert back.face_count == 2
        if format == "ply":
            assert back.vertex_data["quality"].tolist() == [1, 2, 3, 4]
            np.testing.assert_array_equal(back.vertex_data["colors"], mesh.vertex_data["colors"])
        else:
            np.testing.assert_array_equal(back.corner_data["uvs"], mesh.corner_data["uvs"])


def test_polygons_are_kept_until_they_are_cut() -> None:
    cube = cm.Mesh(
        [[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)],
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]],
    )
    assert not cube.is_triangular and cube.face_count == 6
    with pytest.raises(cm.ArrayError, match="triangulated"):
        cube.faces  # noqa: B018
    assert cube.triangulated().face_count == 12
    assert cm.info(cube).quadrilaterals == 6 and cm.info(cube).volume == pytest.approx(1, abs=1e-15)


def test_split_vertices_are_joined(tmp_path: Path) -> None:
    ball = cm.shapes.sphere(3)
    torn = cm.Mesh(ball.vertices[ball.faces.ravel()], np.arange(3 * ball.face_count).reshape(-1, 3))
    assert cm.info(torn.joined(False)).components == ball.face_count
    assert cm.info(torn).components == 1
    whole = torn.joined()
    small = cm.simplify(whole, faces=300)
    assert small.mesh.face_count == 300 and small.vertex_map.shape == (torn.vertex_count,)
    k, split = (cm.curvature(mesh, estimator="vertex") for mesh in (ball, whole))
    # Sums around a vertex start elsewhere.
    np.testing.assert_allclose(split.mean, k.mean[ball.faces.ravel()], rtol=1e-12)


def test_results_stand_for_their_meshes() -> None:
    ball = cm.shapes.sphere(2)
    small = cm.simplify(ball, faces=100)
    assert cm.as_mesh(small) is small.mesh
    assert cm.distance(ball, small).mean == cm.distance(ball, small.mesh).mean
    assert cm.as_mesh(cm.repair(ball)).faces.shape == ball.faces.shape
    with pytest.raises(cm.ArrayError, match="a SimpleNamespace is no mesh"):
        cm.as_mesh(SimpleNamespace(mesh=None))


def test_meshes_are_pickled_and_compared() -> None:
    mesh = cm.shapes.torus()
    mesh.vertex_data["x"] = mesh.vertices[:, 0]
    again = pickle.loads(pickle.dumps(mesh))
    assert again == mesh and again != cm.shapes.octahedron()
    np.testing.assert_array_equal(again.vertex_data["x"], mesh.vertex_data["x"])


def test_files_are_told_where_they_are_wrong(tmp_path: Path) -> None:
    path = tmp_path / "bad.obj"
    path.write_text("v 0 0 0\nv 1 x 0\n")
    with pytest.raises(cm.ReadError) as caught:
        cm.read(path)
    assert caught.value.line == 2 and caught.value.path == str(path)
    with pytest.raises(OSError):
        cm.read(tmp_path / "nothing.ply")
    with pytest.raises(cm.WriteError):
        cm.write(tmp_path / "no.format", cm.shapes.octahedron())
    empty = tmp_path / "empty.off"
    empty.write_text("OFF\n0 0 0\n")
    with pytest.raises(cm.ReadError) as caught:
        cm.read(empty)
    assert caught.value.cure == "allow_empty=True"
    assert cm.read(empty, allow_empty=True).vertex_count == 0


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"ratio": 2.0},
        {"faces": 10, "preset": "slow"},
        {"faces": 10, "placement": "centre"},
        {"faces": 10, "feature_angle": 400.0},
        {"faces": 10, "threads": 0},
        {"max_error": "0.2 parts"},
        {"max_error": -1.0},
        {"faces": 10, "components": "some"},
        {"faces": 10, "fit_rounds": 2, "constraint": lambda edges: edges.lengths > 0},
    ],
)
def test_options_that_make_no_sense(options: Any) -> None:
    with pytest.raises(cm.OptionError):
        cm.simplify(cm.shapes.sphere(3), **options)


def test_empty_and_tiny_meshes() -> None:
    empty = cm.Mesh(np.empty((0, 3)), np.empty((0, 3), int))
    assert cm.info(empty).faces == 0 and len(cm.curvature(empty).mean) == 0
    assert cm.simplify(empty, faces=1).mesh.face_count == 0
    alone = cm.Mesh(SQUARE, [[0, 1, 2]])
    assert cm.simplify(alone, faces=1).mesh.face_count == 1
    assert cm.flip(alone).flips == 0
    with pytest.raises(cm.CurvmeshError):
        cm.distance(empty, alone)


def apart(mesh: cm.Mesh) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """The faces with vertices of their own."""
    return mesh.vertices[mesh.faces].reshape(-1, 3), np.arange(3 * mesh.face_count).reshape(-1, 3)


def test_boundary_edges_that_lie_on_each_other_are_joined(tmp_path: Path) -> None:
    torus = cm.shapes.torus(24, 12)
    soup = cm.Mesh(*apart(torus))
    assert soup.joins is None
    assert soup.vertex_count == 3 * torus.face_count
    assert cm.info(soup).closed
    small = cm.simplify(soup, faces=200).mesh
    assert small.face_count == 200
    assert cm.info(small).closed
    found = cm.curvature(soup, estimator="vertex")
    assert found.mean.shape == (soup.vertex_count,)
    assert np.isfinite(found.mean).all()
    kept = soup.joined(False)
    assert kept.joins is False
    assert not cm.info(kept).closed
    for name in ["soup.ply", "soup.obj", "soup.off"]:
        cm.write(tmp_path / name, soup)
        assert cm.read(tmp_path / name).joins is None
        assert cm.simplify(tmp_path / name, faces=200).mesh == small
        assert cm.read(tmp_path / name, join=False) == soup
    assert pickle.loads(pickle.dumps(soup)).joins is None
    assert pickle.loads(pickle.dumps(kept)).joins is False


def test_what_joined_vertices_lose_is_named() -> None:
    soup = cm.Mesh(*apart(cm.shapes.torus(24, 12)))
    soup.vertex_data["part"] = np.arange(soup.vertex_count) // 900
    with pytest.warns(cm.RepairWarning, match="colours or numbers of vertices.*join=False"):
        cm.simplify(soup, faces=200)


def test_narrow_gaps_are_named_with_their_cure() -> None:
    points: list[list[float]] = []
    faces: list[list[int]] = []
    for strip in range(2):
        for y in range(6):
            points += [[strip * (1 + 1e-6) + x, y, 0] for x in range(2)]
        for v in range(12 * strip, 12 * strip + 10, 2):
            faces += [[v, v + 1, v + 3, v + 2]]
    strips = cm.Mesh(points, faces)
    with pytest.warns(cm.RepairWarning, match=r"6 boundary vertices.*weld=2.0e-6") as told:
        cm.simplify(strips, faces=10)
    texts = [text for warning in told if "weld=" in (text := str(warning.message))]
    weld = float(texts[0].split("weld=")[1].split(")")[0])
    assert cm.info(cm.repair(strips, weld=weld).mesh).components == 1
