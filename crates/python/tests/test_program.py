"""The results equal the results of the program, to the last bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm

from conftest import Run


def same(mesh: cm.Mesh, path: Path) -> None:
    """Compares a mesh with a file."""
    other = cm.read(path)
    np.testing.assert_array_equal(mesh.vertices, other.vertices)
    np.testing.assert_array_equal(mesh.faces, other.faces)
    for name in other.vertex_data:
        np.testing.assert_array_equal(mesh.vertex_data[name], other.vertex_data[name])


@pytest.fixture
def scan(bumpy: cm.Mesh, tmp_path: Path) -> Path:
    bumpy = bumpy.copy()
    bumpy.vertex_data["height"] = bumpy.vertices[:, 2]
    path = tmp_path / "bumpy.ply"
    cm.write(path, bumpy, precision="double")
    return path


@pytest.mark.parametrize(
    "options, arguments",
    [
        ({"faces": 700}, ["--faces", 700]),
        ({"ratio": 0.2, "preset": "fast"}, ["--ratio", 0.2, "--preset", "fast"]),
        ({"faces": 900, "preset": "quality", "seed": 5}, ["--faces", 900, "--preset", "quality", "--seed", 5]),
        ({"max_error": "1%", "verify": True}, ["--max-error", "1%", "--verify"]),
        ({"faces": 500, "preset": "paper-l1"}, ["--faces", 500, "--preset", "paper-l1"]),
        (
            {"faces": 800, "feature_angle": 30.0, "placement": "endpoint", "no_intersections": True},
            ["--faces", 800, "--feature-angle", 30, "--placement", "endpoint", "--no-intersections"],
        ),
    ],
)
def test_simplify(scan: Path, tmp_path: Path, program: Run, options: dict[str, object], arguments: list[object]) -> None:
    out = tmp_path / "out.ply"
    told = json.loads(
        program("simplify", scan, "-o", out, "--precision", "double", *arguments, "--json").stdout
    )
    small = cm.simplify(cm.read(scan), **options)  # type: ignore[arg-type]
    same(small.mesh, out)
    assert (small.stop, small.max_cost, small.refused) == (told["stop"], told["max_cost"], told["rejected"])
    assert small.preset_kept == told.get("preset_kept")
    if small.error is not None:
        assert [small.error.lower, small.error.upper] == list(told["error"].values())
    again = cm.simplify(cm.read(scan), threads=1, **options)  # type: ignore[arg-type]
    assert again.mesh == small.mesh


def test_a_cheaper_preset_that_is_closer_is_kept_and_named() -> None:
    mesh = cm.examples.bracket()
    found = {faces: cm.simplify(mesh, faces=faces, preset="quality") for faces in (40, 60, 100, 120)}
    assert any(small.preset_kept is not None for small in found.values())
    for faces, small in found.items():
        if small.preset_kept is not None:
            assert small.mesh == cm.simplify(mesh, faces=faces, preset=small.preset_kept).mesh


@pytest.mark.parametrize("cost", ["f1", "f2", "f3", "delaunay"])
def test_flip(scan: Path, tmp_path: Path, program: Run, cost: Any) -> None:
    out = tmp_path / "out.ply"
    arguments = ["flip", scan, "-o", out, "--precision", "double", "--cost", cost, "--random-ties", "--seed", 3]
    told = json.loads(program(*arguments, "--json").stdout)
    flipped = cm.flip(cm.read(scan), cost=cost, seed=3)
    same(flipped.mesh, out)
    assert (flipped.cost_before, flipped.cost_after) == (told["cost_before"], told["cost_after"])
    assert (flipped.flips, flipped.stop) == (told["flips"], told["stop"])


def test_rebuilding(scan: Path, tmp_path: Path, program: Run) -> None:
    small = tmp_path / "small.ply"
    cm.write(small, cm.simplify(cm.read(scan), faces=120, fit_rounds=0).mesh, precision="double")
    out = tmp_path / "out.ply"
    options = ["--rebuild-effort", 2, "--rebuild-largest", 12, "--seed", 5]
    told = json.loads(program("flip", small, "-o", out, "--precision", "double", "--cost", "f2", *options, "--json").stdout)
    flipped = cm.flip(cm.read(small), cost="f2", rebuild_effort=2, rebuild_largest=12, seed=5)
    same(flipped.mesh, out)
    assert (flipped.rebuilt, flipped.cost_after) == (told["rebuilt"], told["cost_after"])
    assert flipped.cost_after <= cm.flip(cm.read(small), cost="f2").cost_after
    with pytest.raises(cm.OptionError, match="at least 3"):
        cm.flip(cm.read(small), rebuild_effort=2, rebuild_largest=2)


@pytest.mark.parametrize("estimator", ["auto", "vertex", "face", "fit", "ball", "corrected"])
def test_curvature(scan: Path, tmp_path: Path, program: Run, estimator: Any) -> None:
    out = tmp_path / "out.ply"
    arguments = ["curvature", scan, "-o", out, "--precision", "double", "--estimator", estimator]
    told = json.loads(program(*arguments, "--json").stdout)
    k = cm.curvature(cm.read(scan), estimator=estimator)
    written = cm.read(out)
    data = written.face_data if estimator == "face" else written.vertex_data
    names = {"gaussian": "gaussian_curvature", "mean": "mean_curvature", "abs_mean": "abs_mean_curvature"}
    for name in ("gaussian", "mean", "abs_mean", "k1", "k2", "shape_index", "curvedness"):
        np.testing.assert_array_equal(k[name], data[names.get(name, name)], err_msg=name)
    for ours, theirs in (("gaussian", "integral_gaussian"), ("f1", "f1"), ("f3", "f3")):
        assert k.totals[ours] == told[theirs]
    if estimator in ("auto", "fit"):
        np.testing.assert_array_equal(k.error, data["curvature_error"])
        kinds = ["regular", "umbilic", "crease", "boundary", "unknown"]
        assert [kinds.index(kind) for kind in k.kind] == data["curvature_kind"].tolist()
        np.testing.assert_array_equal(k.directions[:, 0, 1], data["k1_y"])


def test_distance(scan: Path, tmp_path: Path, program: Run) -> None:
    out = tmp_path / "small.ply"
    program("simplify", scan, "-o", out, "--faces", 500)
    told = json.loads(
        program("distance", scan, out, "--samples", 20000, "--exact", "0.1%", "--json").stdout
    )
    d = cm.distance(scan, out, samples=20_000, exact="0.1%")
    assert [d.mean, d.rms, d.max] == [told[name] for name in ("mean", "rms", "max")]
    assert d.bounds is not None and d.bounds.upper == told["hausdorff"]["upper"]
    assert d.forward is not None and list(d.forward.max_at) == told["forward"]["max_at"]


def test_patch(scan: Path, tmp_path: Path, program: Run) -> None:
    out = tmp_path / "cover.json"
    program("patch", scan, "-o", out, "--tolerance", "1%")
    cover = cm.patch(cm.read(scan), tolerance="1%")
    assert cover.record() == json.loads(out.read_text())
    mesh = tmp_path / "cover.ply"
    program("patch", scan, "-o", mesh, "--tolerance", "1%", "--precision", "double")
    same(cover.tessellate(), mesh)


def test_levels(scan: Path, tmp_path: Path, program: Run) -> None:
    record = tmp_path / "scan.lod"
    folder = tmp_path / "levels"
    program("lod", scan, "-o", folder, "--levels", "0.5,0.1", "--record", record, "--precision", "double")
    mesh = cm.read(scan)
    levels = cm.lod(mesh, ratios=[0.5, 0.1])
    for level, path in zip(levels, sorted(folder.iterdir())):
        same(level.mesh, path)
    levels.record.save(tmp_path / "ours.lod")
    assert (tmp_path / "ours.lod").read_bytes() == record.read_bytes()
    loaded = cm.Record.load(record, mesh)
    assert cm.lod(mesh, ratios=[0.1], record=loaded)[0].mesh == levels[1].mesh
    with pytest.raises(cm.RecordError):
        cm.Record.load(record, cm.shapes.octahedron())


def test_figures(scan: Path, tmp_path: Path, program: Run) -> None:
    mesh = cm.read(scan)
    mesh.face_data["part"] = np.arange(mesh.face_count) // 100
    source, out, ours = tmp_path / "in.ply", tmp_path / "out.svg", tmp_path / "ours.svg"
    cm.write(source, mesh, precision="double")
    options = ["--property", "part", "--edges", 0.5, "--direction", "front", "--size", "300,200"]
    told = json.loads(program("render", source, "-o", out, *options, "--json").stdout)
    figure = cm.figure(cm.read(source), "part", edges=0.5, direction="front", size=(300, 200))
    figure.save(ours)
    assert ours.read_bytes() == out.read_bytes()
    assert (figure.size, figure.faces) == ((told["width"], told["height"]), told["drawn_faces"])
    assert figure.range is None and figure._repr_svg_() == figure.svg
    assert 0 < figure.faces < mesh.face_count
    with pytest.raises(cm.OptionError, match="one view"):
        cm.figure(mesh, direction=["front", "top"])  # type: ignore[list-item]


def test_info_repair_subdivide(scan: Path, tmp_path: Path, program: Run) -> None:
    told = json.loads(program("info", scan, "--json").stdout)
    found = cm.info(scan)
    for name in found.keys() - {"joined_vertices"}:
        assert told[name] == found[name], name
    out = tmp_path / "fine.ply"
    program("subdivide", scan, "-o", out, "--steps", 1, "--precision", "double")
    same(cm.subdivide(scan), out)
    broken = tmp_path / "broken.off"
    faces = [[0, 1, 2], [2, 1, 0], [1, 0, 3], [0, 1, 4], [3, 3, 4]]
    rows = ["3 " + " ".join(map(str, face)) for face in faces]
    points = ["0 0 0", "0 0 1", "1 0 0", "0 1 0", "-1 0 0"]
    broken.write_text("OFF\n5 5 0\n" + "\n".join(points + rows) + "\n")
    program("repair", broken, "-o", out, "--precision", "double")
    same(cm.repair(broken).mesh, out)


def test_textured_models_keep_everything(models: Path, tmp_path: Path, program: Run) -> None:
    source = next(iter(sorted(models.glob("*ruck*.glb"))), None)
    if source is None:
        pytest.skip("no textured truck among the models")
    out = tmp_path / "out.glb"
    repaired = cm.repair(source).mesh
    assert repaired.face_count
    program("simplify", source, "-o", out, "--ratio", 0.3, "--lenient")
    ours = tmp_path / "ours.glb"
    cm.write(ours, cm.simplify(repaired, ratio=0.3).mesh)
    theirs, mine = cm.read(out), cm.read(ours)
    assert mine.face_count == theirs.face_count
    assert [m["name"] for m in mine.materials] == [m["name"] for m in theirs.materials]


@pytest.mark.parametrize("name", ["cow", "igea"])
def test_real_meshes(name: str, models: Path, tmp_path: Path, program: Run) -> None:
    source = next((p for p in sorted(models.iterdir()) if p.stem == name), None)
    if source is None:
        pytest.skip(f"no {name} among the models")
    out = tmp_path / "out.ply"
    arguments = ["--faces", 2000, "--preset", "fast", "--lenient", "--precision", "double"]
    program("simplify", source, "-o", out, *arguments)
    same(cm.simplify(cm.repair(source).mesh, faces=2000, preset="fast").mesh, out)
