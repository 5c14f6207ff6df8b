"""Arrays at the interface: converted exactly, or refused with a remedy; nothing is lost in copies and pickles."""

from __future__ import annotations

import copy
import errno
import io
import pickle
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm
from curvmesh import _core

SQUARE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
TWO = np.array([[0, 1, 2], [0, 2, 3]])


def rich() -> cm.Mesh:
    """A mesh with content of every kind."""
    mesh = cm.examples.globe(2)
    mesh.groups = [("globe", "north"), ("globe", "south")]
    high = mesh.vertices[mesh.faces].mean(axis=1)[:, 2] > 0
    mesh.face_data["groups"] = np.where(high, 0, 1)
    mesh.vertex_data["height"] = np.where(mesh.vertices[:, 2] > 0.5, np.nan, mesh.vertices[:, 2])
    mesh.vertex_data["colors"] = np.round(127 * (mesh.vertices + 1)).astype(np.uint8)
    return mesh


WAYS: list[Callable[[Any], Any]] = [
    lambda thing: pickle.loads(pickle.dumps(thing)),
    copy.copy,
    copy.deepcopy,
]


@pytest.mark.parametrize("way", WAYS, ids=["pickle", "copy", "deepcopy"])
def test_copies_keep_everything(way: Callable[[Any], Any]) -> None:
    mesh = rich()
    again = way(mesh)
    assert again == mesh
    assert again.materials == mesh.materials and again.images == mesh.images and again.groups == mesh.groups
    for name in ("groups", "materials"):
        np.testing.assert_array_equal(again.face_data[name], mesh.face_data[name])
    again.vertex_data["height"] = np.zeros(mesh.vertex_count)
    assert np.isnan(mesh.vertex_data["height"]).any() and again != mesh


def test_equality_sees_all_content() -> None:
    mesh = rich()
    for change in (
        lambda m: setattr(m, "materials", [{**m.materials[0], "roughness": 0.25}]),
        lambda m: setattr(m, "images", [{**m.images[0], "name": "other"}]),
        lambda m: setattr(m, "groups", [("a", "b"), ("c", "d")]),
        lambda m: m.face_data.__delitem__("groups"),
        lambda m: m.vertex_data.update(height=np.zeros(m.vertex_count)),
    ):
        other = mesh.copy()
        change(other)
        assert other != mesh and mesh == mesh.copy()
    assert mesh != mesh.joined()


def test_moved_vertices_keep_everything() -> None:
    mesh = rich()
    moved = mesh.with_vertices(2 * mesh.vertices)
    assert moved.with_vertices(mesh.vertices) == mesh
    assert moved.materials == mesh.materials and moved.groups == mesh.groups


@pytest.mark.parametrize("way", WAYS, ids=["pickle", "copy", "deepcopy"])
def test_results_are_pickled(way: Callable[[Any], Any]) -> None:
    mesh = rich()
    small = cm.simplify(mesh, faces=100, verify=True)
    again = way(small)
    assert again.mesh == small.mesh and again.error == small.error
    np.testing.assert_array_equal(again.log.columns["removed"], small.log.columns["removed"])
    assert len(again.log) == len(small.log)
    levels = cm.lod(mesh, ratios=[0.5, 0.2])
    others = way(levels)
    assert [level.mesh for level in others] == [level.mesh for level in levels]
    np.testing.assert_array_equal(others.record.vertex_map(9), levels.record.vertex_map(9))
    cover = cm.patch(mesh, tolerance="5%")
    other = way(cover)
    assert (other.patches == cover.patches).all() and other.mesh == cover.mesh
    np.testing.assert_array_equal(other.tessellate().vertices, cover.tessellate().vertices)
    k = cm.curvature(mesh, estimator="fit")
    np.testing.assert_array_equal(way(k).directions, k.directions)
    assert way(cm.info(mesh)) == cm.info(mesh)
    assert way(cm.flip(mesh)).mesh == cm.flip(mesh).mesh
    assert way(cm.distance(mesh, small, samples=100)).of_vertices.shape == (mesh.vertex_count,)


# -- unknown values


def test_unused_vertices_have_no_curvature() -> None:
    ball = cm.shapes.sphere(2)
    mesh = cm.Mesh(np.vstack([[[5, 5, 5]], ball.vertices]), ball.faces + 1)
    for estimator in ("auto", "vertex", "fit", "ball", "corrected"):
        k = cm.curvature(mesh, estimator=estimator)
        for name in k.names:
            if k[name].dtype.kind == "f":
                assert np.isnan(k[name][0]).all(), (estimator, name)
                assert not np.isnan(k[name][1:]).all(), (estimator, name)
        assert np.isnan(k.directions[0]).all()


def test_info_sees_the_joins_of_the_algorithms(tmp_path: Path) -> None:
    torus = cm.shapes.torus(12, 6)
    torus.corner_data["uvs"] = np.random.default_rng(1).random((len(torus.corners), 2))
    cm.write(tmp_path / "torus.glb", torus)
    back = cm.read(tmp_path / "torus.glb")
    found = cm.info(back)
    assert back.vertex_count > torus.vertex_count
    assert (found.closed, found.components, found.vertices) == (True, 1, torus.vertex_count)
    assert found.joined_vertices == back.vertex_count - torus.vertex_count
    assert cm.info(back.joined(False)).components == torus.face_count


def test_face_curvature_belongs_to_the_triangles_that_it_comes_with() -> None:
    cube = cm.subdivide(cm.shapes.cube(), steps=2)
    faces = cube.faces.reshape(-1, 3)
    quads = cm.Mesh([[x, y, 0.1 * x * y] for x in range(6) for y in range(6)],
                    [[6 * i + j, 6 * i + 6 + j, 6 * i + 7 + j, 6 * i + 1 + j] for i in range(5) for j in range(5)])
    for mesh, count in ((cube, len(faces)), (quads, 50)):
        k = cm.curvature(mesh, estimator="face")
        assert k.mesh.face_count == len(k.mean) == count
        assert cm.view(k).html and cm.render(k.mesh, k.mean, on="face").pixels.any()
    cover = cm.patch(quads, tolerance="5%")
    assert len(cover.patch_of_face) == cover.mesh.face_count == 50


def test_values_are_not_guessed_where_the_counts_are_equal() -> None:
    fan = cm.shapes.tetrahedron()
    assert fan.vertex_count == fan.face_count
    with pytest.raises(cm.OptionError, match='on="vertex"'):
        cm.render(fan, [0, 1, 2, 3.0])
    with pytest.raises(cm.OptionError, match='on="vertex"'):
        cm.view(fan, values={"x": [0, 1, 2, 3.0]})
    one = cm.render(fan, [0, 1, 2, 3.0], on="vertex").pixels
    other = cm.render(fan, [0, 1, 2, 3.0], on="face").pixels
    assert (one != other).any()
    assert cm.view(fan, values={"x": [0, 1, 2, 3.0]}, on="face").html
    fan.vertex_data["x"] = fan.face_data["x"] = [0, 1, 2, 3.0]
    with pytest.raises(cm.OptionError, match="vertices and faces"):
        cm.render(fan, "x")
    assert cm.render(fan, "x", on="face").pixels.any()
    with pytest.raises(cm.ArrayError, match="one for each face"):
        cm.render(cm.shapes.cube(), np.zeros(8), on="face")


# -- arrays


def test_masked_arrays() -> None:
    points = np.ma.masked_array(SQUARE, mask=False)
    assert cm.Mesh(points, np.ma.masked_array(TWO, mask=False)).face_count == 2
    points[1, 1] = np.ma.masked
    with pytest.raises(cm.ArrayError, match="1 masked.*fill"):
        cm.Mesh(points, TWO)
    mesh = cm.Mesh(SQUARE, TWO)
    with pytest.raises(cm.ArrayError, match="masked") as caught:
        mesh.vertex_data["x"] = np.ma.masked_array([1, 2, 3, 4.0], mask=[False, False, True, False])
    assert caught.value.cure
    # The unused corners of smaller polygons.
    faces = np.ma.masked_array([[0, 1, 2, 3], [0, 2, 3, 99]], mask=[[False] * 4, [False, False, False, True]])
    assert cm.Mesh(SQUARE, faces).face_ends.tolist() == [4, 7]
    for row, corner in ((0, 0), (0, 2), (1, 0)):
        unknown = np.ma.masked_array([[0, 1, 2], [0, 2, 3]])
        unknown[row, corner] = np.ma.masked
        with pytest.raises(cm.ArrayError, match="masked corners") as caught:
            cm.Mesh(SQUARE, unknown)
        assert "drop" in caught.value.cure


def test_values_that_are_no_real_numbers() -> None:
    ball = cm.shapes.sphere(2)
    waves = np.exp(1j * ball.vertices[:, 0])
    for work in (
        lambda: cm.render(ball, waves),
        lambda: cm.render(ball, ["a"] * ball.vertex_count),
        lambda: ball.vertex_data.update(x=waves),
        lambda: cm.simplify(ball, faces=100, cost=lambda edges: edges.lengths * 1j),
        lambda: cm.simplify(ball, faces=100, constraint=lambda edges: None),
        lambda: cm.flip(ball, cost=cm.EdgeCost(lambda edges: np.full(len(edges), 1j), 1)),
    ):
        with pytest.raises(cm.ArrayError, match="real numbers"):
            work()
    with pytest.raises(cm.ArrayError, match="it must be below 3.4"):
        ball.vertex_data["normals"] = np.full((ball.vertex_count, 3), 1e300)


def test_masked_values_are_drawn_as_unknown() -> None:
    ball = cm.shapes.sphere(2)
    counts: Any = np.ma.masked_array(np.arange(ball.vertex_count), mask=np.arange(ball.vertex_count) < 9)
    floats = counts.astype(float).filled(np.nan)
    as_amounts = cm.render(ball, counts, colormap="viridis")
    assert (as_amounts.pixels == cm.render(ball, floats).pixels).all()
    # As labels, too, unknown values are grey: the light that is on them takes all channels alike.
    colors = cm.render(ball, counts, size=(200, 200), bar=False).pixels.reshape(-1, 4)[:, :3].astype(int)
    grey = (np.ptp(colors, axis=1) == 0) & (colors[:, 0] < 200)
    assert 100 < grey.sum() < len(colors) // 2


def test_padded_faces() -> None:
    ball = cm.shapes.sphere(2)
    padded = np.column_stack([np.full(ball.face_count, 3), ball.faces])
    assert cm.Mesh(ball.vertices, padded) == ball
    cube = cm.shapes.cube()
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    grid = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], float)
    assert cm.Mesh(grid, np.column_stack([np.full(6, 4), quads])) == cm.Mesh(grid, quads)
    assert cm.info(cube).closed
    # Two triangles with their counts, or two quadrilaterals around vertex 3?
    with pytest.raises(cm.ArrayError, match="around vertex 3") as caught:
        cm.Mesh(np.vstack([SQUARE, SQUARE + 1]), [[3, 0, 1, 2], [3, 4, 5, 6]])
    assert "np.roll" in caught.value.cure
    short = cm.Mesh(SQUARE, [[0, 1, 2, 3], [0, 1, 2, -1]])
    assert short.face_ends.tolist() == [4, 7]
    ragged = cm.Mesh(SQUARE, [[0, 1, 2, 3], [0, 1, 2]])
    assert ragged == short
    with pytest.raises(cm.ArrayError, match="reshape"):
        cm.Mesh(SQUARE, [3, 0, 1, 2])
    with pytest.raises(cm.ArrayError, match="astype"):
        cm.Mesh(SQUARE, TWO.astype(float))


@pytest.mark.parametrize(
    "kind", ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8", ">i8", ">f4", "f2", "bool"]
)
def test_named_numbers_keep_their_type(kind: str) -> None:
    dtype = np.dtype(kind)
    ends = np.iinfo(dtype) if dtype.kind in "iu" else None
    values = np.array([ends.min, ends.max, 2, 3] if ends else [0.5, 1, 2, 3], object).astype(dtype)
    mesh = cm.Mesh(SQUARE, TWO, vertex_data={"id": values}, face_data={"id": values[:2]})
    for back in (mesh.vertex_data["id"], pickle.loads(pickle.dumps(mesh)).vertex_data["id"]):
        np.testing.assert_array_equal(back, values)
        kept = {"bool": np.uint8, "f2": np.float32}.get(kind, dtype.newbyteorder("="))
        assert back.dtype == kept
    np.testing.assert_array_equal(mesh.face_data["id"], values[:2])


def test_coordinates_stay_exact() -> None:
    with pytest.raises(cm.ArrayError, match="2\\*\\*53") as caught:
        cm.Mesh(SQUARE.astype(np.int64) + 2**53, TWO)
    assert caught.value.cure


@pytest.mark.parametrize(
    "colors",
    [
        np.array([[255, 0, 51]] * 4, np.uint8),
        np.array([[65535, 0, 13107]] * 4, np.uint16),
        [[255, 0, 51]] * 4,
        np.array([[1, 0, 0.2]] * 4),
        np.array([[1, 0, 0.2, 1]] * 4, np.float32),
    ],
)
def test_colours_of_every_type_are_the_same(colors: Any) -> None:
    mesh = cm.Mesh(SQUARE, TWO, vertex_data={"colors": colors})
    np.testing.assert_allclose(mesh.vertex_data["colors"], [[1, 0, 0.2, 1]] * 4, atol=1e-7)


@pytest.mark.parametrize(
    "colors",
    [
        [[255.0, 0, 51]] * 4,
        [[-0.1, 0, 0]] * 4,
        [[1, 0, 0]] * 4,
        [[300, 0, 0]] * 4,
        np.array([[-1, 0, 0]] * 4),
        [[0.5, 0.5]] * 4,
    ],
)
def test_colours_of_unknown_scale_are_refused(colors: Any) -> None:
    with pytest.raises(cm.ArrayError) as caught:
        cm.Mesh(SQUARE, TWO, vertex_data={"colors": colors})
    assert caught.value.cure or "shape" in str(caught.value)


def test_ids_of_groups_are_whole_numbers() -> None:
    mesh = cm.Mesh(SQUARE, TWO)
    mesh.groups = [("", "a"), ("", "b")]
    mesh.face_data["groups"] = [0.0, 1.0]
    assert mesh.face_data["groups"].tolist() == [0, 1]
    with pytest.raises(cm.ArrayError, match="fraction"):
        mesh.face_data["groups"] = [0.7, 1.0]
    with pytest.raises(cm.OutOfRangeError):
        mesh.groups = [("", "only")]
    with pytest.raises(cm.OutOfRangeError):
        mesh.materials = [{"name": "a", "image": 3}]
    with pytest.raises(cm.OptionError, match="a material has no"):
        mesh.materials = [{"gloss": 3}]


# -- options and files


#: The package without its types.
loose: Any = cm


@pytest.mark.parametrize(
    "work, says",
    [
        (lambda m: loose.simplify(m, faces=3.7), "faces is 3.7; it must be a whole number"),
        (lambda m: loose.simplify(m, faces=-4), "faces is -4"),
        (lambda m: loose.simplify(m, faces="many"), "faces is 'many'"),
        (lambda m: loose.simplify(m, faces=True), "faces is True"),
        (lambda m: loose.simplify(m, faces=10, threads=-1), "threads is -1"),
        (lambda m: loose.simplify(m, faces=10, threads=1.5), "threads is 1.5"),
        (lambda m: loose.simplify(m, ratio="0.1"), "ratio is '0.1'; it must be a number"),
        (lambda m: loose.simplify(m, faces=10, verify="yes"), "verify is 'yes'; it must be True or False"),
        (lambda m: loose.simplify(m, faces=10, preset=3), "preset is 3; it must be a text"),
        (lambda m: loose.simplify(m, faces=10, max_error=[1]), "max_error is"),
        (lambda m: loose.simplify(m, faces=10, components=2.5), "components is 2.5"),
        (lambda m: loose.lod(m, faces=[2.5]), "faces is 2.5"),
        (lambda m: loose.flip(m, look_ahead=1.5), "look_ahead is 1.5"),
        (lambda m: loose.curvature(m, rings=2.5), "rings is 2.5"),
        (lambda m: loose.patch(m, tolerance=object()), "tolerance is"),
        (lambda m: loose.distance(m, m, samples=-1), "samples is -1"),
        (lambda m: loose.repair(m, fill_holes=1.5), "fill_holes is 1.5"),
        (lambda m: loose.subdivide(m, steps=1.5), "steps is 1.5"),
        (lambda m: loose.render(m, supersampling=1.5), "supersampling is 1.5"),
        (lambda m: loose.view(m, height="tall"), "height is 'tall'"),
        (lambda m: loose.shapes.sphere(-1), "level is -1"),
        (lambda m: loose.lod(m, faces=4), "faces is 4; it must be a list, like [4]"),
        (lambda m: loose.lod(m, ratios="0.5"), "ratios is '0.5'; it must be a list"),
        (lambda m: loose.simplify(m, faces=4, constraint=3), "constraint is 3; it must be a function"),
        (lambda m: loose.simplify(m, faces=4, callback=3), "callback is 3; it must be a function"),
        (lambda m: loose.simplify(m, faces=4, progress=3), "progress is 3; it must be True, False or a function"),
        (lambda m: loose.flip(m, cost=3), "cost is 3; it must be a name"),
        (lambda m: loose.distance(m, m, samples=0), "samples is 0; it must be from 1 to 10000000000"),
        (lambda m: loose.distance(m, m, samples=2**63), "it must be from 1 to 10000000000"),
        (lambda m: loose.render(m, [1] * 8, on="edge"), "on is 'edge'; it must be"),
        (lambda m: loose.render(m, size=10), "size is 10; it must be two whole numbers"),
        (lambda m: loose.render(m, size=(1.5, 10)), "size is 1.5; it must be a whole number"),
        (lambda m: loose.info(m, threads=-2), "threads is -2"),
        (lambda m: m.validate(threads=-1), "threads is -1"),
        (lambda m: m.triangulated(threads=-1), "threads is -1"),
        (lambda m: loose.view(m, values="x"), 'values is \'x\'; it must be a mapping'),
        (lambda m: loose.view(m, values=["x"]), "it must be a mapping"),
        (lambda m: loose.render(m, size=(9, 9)).save("a.jpg"), "a.jpg ends in .jpg, but the file is written as .png"),
        (lambda m: loose.figure(m).save("f.png"), "written as .svg"),
        (lambda m: loose.view(m).save("f.svg"), "written as .html"),
        (lambda m: loose.view(m).save(7), "a int cannot be written to"),
        (lambda m: loose.regions.simplify("a.ply", "b.ply", work_dir="w", memory="much"), "memory is 'much'"),
        (lambda m: loose.regions.lod("a.ply", "b", ratios=[0.5], work_dir="w", memory="-1"), "memory is '-1'"),
    ],
)
def test_wrong_values_are_answered_in_words(work: Any, says: str) -> None:
    with pytest.raises(cm.OptionError) as caught:
        work(cm.shapes.octahedron())
    assert says in str(caught.value)


def test_whole_numbers_of_any_type() -> None:
    ball = cm.shapes.sphere(3)
    expected = cm.simplify(ball, faces=100).mesh
    for faces in (100.0, np.int64(100), np.uint8(100), np.float32(100), np.array(100)):
        assert loose.simplify(ball, faces=faces).mesh == expected


def test_missing_files_are_those_of_python(tmp_path: Path) -> None:
    path = tmp_path / "nothing.ply"
    for work in (lambda: cm.read(path), lambda: cm.Record.load(path, cm.shapes.sphere(1))):
        with pytest.raises(FileNotFoundError) as caught:
            work()
        error = caught.value
        assert isinstance(error, cm.ReadError)
        assert (error.errno, error.filename) == (errno.ENOENT, str(path)) and "nothing.ply" in str(error)
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error) and again.errno == errno.ENOENT and str(again) == str(error)
    with pytest.raises(FileNotFoundError) as missing:
        cm.write(tmp_path / "none" / "a.ply", cm.shapes.sphere(1))
    assert isinstance(missing.value, cm.WriteError) and missing.value.errno == errno.ENOENT


@pytest.mark.parametrize("format", ["obj", "ply", "stl", "off", "gltf", "glb"])
def test_open_files_are_read_and_written(format: Any, tmp_path: Path) -> None:
    ball = cm.shapes.sphere(2)
    file = io.BytesIO()
    told = cm.write(file, ball, format=format)
    named = tmp_path / f"mesh.{format}"
    cm.write(named, ball)
    assert file.getvalue() == named.read_bytes()
    file.seek(0)
    if format != "gltf":
        assert told["dropped"] == [] and cm.read(file, format=format) == cm.read(named)
        with open(named, "rb") as opened:
            assert cm.as_mesh(opened) == cm.read(named)
    with pytest.raises(cm.OptionError, match="format"):
        cm.write(io.BytesIO(), ball)
    with pytest.raises(cm.OptionError, match="wb"):
        loose.write(io.StringIO(), ball, format=format)
    with pytest.raises(cm.ReadError) as caught:
        loose.read(io.StringIO("OFF"))
    assert "rb" in caught.value.cure


def test_a_file_of_binary_content_that_is_open_as_text(tmp_path: Path) -> None:
    path = tmp_path / "a.bin"
    path.write_bytes(b"\xff\xfe\x80")
    with open(path, encoding="utf-8") as file, pytest.raises(cm.ReadError, match="open as text") as caught:
        loose.read(file)
    assert "rb" in caught.value.cure


def test_results_are_saved_to_open_files(tmp_path: Path) -> None:
    ball = cm.shapes.sphere(2)
    log = cm.simplify(ball, faces=100).log
    shown: list[Any] = [cm.render(ball, size=(40, 40)), cm.figure(ball, size=(40, 40)), cm.view(ball), log]
    for result, name in zip(shown, ("a.png", "a.svg", "a.html", "a.record")):
        file = io.BytesIO()
        result.save(file)
        result.save(tmp_path / name)
        assert file.getvalue() == (tmp_path / name).read_bytes() != b""
        with pytest.raises(cm.OptionError, match="wb"):
            result.save(io.StringIO())
    with open(tmp_path / "a.record", "rb") as opened:
        assert len(cm.Record.load(opened, ball)) == len(log)


def test_what_stands_beside_an_open_file_is_told() -> None:
    told = cm.write(io.BytesIO(), cm.examples.globe(1), format="obj")
    assert any("no place beside it" in dropped for dropped in told["dropped"])


def test_a_mesh_is_made_without_the_interpreter_lock() -> None:
    """The interpreter lock is never taken away here, so other threads run only when it is released."""
    ball = cm.shapes.sphere(5)
    vertices, faces = np.array(ball.vertices), np.array(ball.faces)
    interval = sys.getswitchinterval()
    start, has_run = threading.Lock(), threading.Event()
    start.acquire()

    def other() -> None:
        with start:
            has_run.set()

    thread = threading.Thread(target=other)
    thread.start()
    sys.setswitchinterval(3600)
    try:
        start.release()
        for _ in range(10_000):
            _core.MeshData.of_triangles(vertices, faces, True)
            if has_run.is_set():
                break
        assert has_run.is_set()
    finally:
        sys.setswitchinterval(interval)
    thread.join()


def test_levels_are_typed() -> None:
    levels = cm.lod(cm.shapes.sphere(3), ratios=[0.5, 0.25])
    fine: cm.Level = levels[0]
    rest: list[cm.Level] = levels[1:]
    total: int = sum(level.mesh.face_count for level in levels)
    assert total == fine.mesh.face_count + rest[0].mesh.face_count
    found = cm.info(fine.mesh)
    volume: float | None = found.volume
    assert volume is not None and found["volume"] == volume and dict(found)["closed"] is True
