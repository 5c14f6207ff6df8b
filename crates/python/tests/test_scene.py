"""Scenes: reading, simplification, levels of detail, and the same bytes as from the program."""

from __future__ import annotations

import copy
import dataclasses
import errno
import io
import json
import math
import pickle
import struct
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import curvmesh as cm
from conftest import Run


class Glb:
    """A GLB file that is put together here, without curvmesh."""

    def __init__(self) -> None:
        self.document: dict[str, Any] = {"asset": {"version": "2.0"}, "accessors": [], "bufferViews": []}
        self.binary = b""

    def add(self, values: NDArray[Any], kind: str, **more: Any) -> int:
        """An accessor of these values."""
        components = {"float32": 5126, "uint32": 5125, "uint16": 5123, "uint8": 5121}
        content = values.tobytes()
        view = {"buffer": 0, "byteOffset": len(self.binary), "byteLength": len(content)}
        self.binary += content + bytes(-len(content) % 4)
        self.document["bufferViews"].append(view)
        component = components[str(values.dtype)]
        place = len(self.document["accessors"])
        self.document["accessors"].append(
            {"bufferView": place, "componentType": component, "count": len(values), "type": kind, **more}
        )
        return place

    def surface(self, mesh: cm.Mesh, **attributes: int) -> dict[str, Any]:
        """A primitive with these triangles."""
        points = mesh.vertices.astype(np.float32)
        bounds = {"min": points.min(axis=0).tolist(), "max": points.max(axis=0).tolist()}
        indices = self.add(mesh.faces.astype(np.uint32).ravel(), "SCALAR")
        return {"indices": indices, "attributes": {"POSITION": self.add(points, "VEC3", **bounds), **attributes}}

    def file(self) -> bytes:
        self.document["buffers"] = [{"byteLength": len(self.binary)}]
        text = json.dumps(self.document).encode()
        text += b" " * (-len(text) % 4)
        size = 12 + 8 + len(text) + 8 + len(self.binary)
        head = struct.pack("<4sII", b"glTF", 2, size) + struct.pack("<I4s", len(text), b"JSON") + text
        return head + struct.pack("<I4s", len(self.binary), b"BIN\0") + self.binary


def bumps(level: int, phase: float) -> cm.Mesh:
    ball = cm.shapes.sphere(level)
    p = ball.vertices
    return ball.with_vertices(p * (1 + 0.15 * np.sin(5 * p[:, :1] + phase) * np.cos(4 * p[:, 1:2])))


def tree() -> Glb:
    """A node tree with two instances of a ball, a skinned blob that is animated, a camera and extras."""
    glb = Glb()
    ball, blob = bumps(4, 1.0), bumps(3, 2.0)
    count = blob.vertex_count
    joints = np.zeros((count, 4), dtype=np.uint8)
    joints[:, 1] = 1
    high = (blob.vertices[:, 2] + 1.5).clip(0, 3)[:, None] / 3
    weights = np.hstack([1 - high, high, 0 * high, 0 * high]).astype(np.float32)
    skinned = glb.surface(blob, JOINTS_0=glb.add(joints, "VEC4"), WEIGHTS_0=glb.add(weights, "VEC4"))
    skinned["material"] = 1
    inverse = np.stack([np.eye(4, dtype=np.float32).ravel()] * 2)
    times = np.array([0, 1], dtype=np.float32)
    turns = np.array([[0, 0, 0, 1], [0, 0, math.sqrt(0.5), math.sqrt(0.5)]], dtype=np.float32)
    glb.document |= {
        "scene": 0,
        "scenes": [{"nodes": [0, 4], "name": "all"}],
        "nodes": [
            {"name": "root", "children": [1, 2, 3], "scale": [2, 2, 2]},
            {"name": "left", "mesh": 0, "translation": [-3, 0, 0]},
            {"name": "right", "mesh": 0, "translation": [3, 0, 0], "extras": {"owner": "test", "grades": [1, 2]}},
            {"camera": 0, "translation": [0, 0, 9]},
            {"name": "skinned", "mesh": 1, "skin": 0},
            {"name": "bone", "children": [6]},
            {"name": "tip", "translation": [0, 0, 1]},
        ],
        "meshes": [
            {"name": "ball", "primitives": [glb.surface(ball) | {"material": 0}]},
            {"name": "blob", "primitives": [skinned]},
        ],
        "materials": [
            {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}},
            {"name": "plain", "extensions": {"KHR_materials_unlit": {}}},
        ],
        "extensionsUsed": ["KHR_materials_unlit"],
        "cameras": [{"name": "eye", "type": "perspective", "perspective": {"yfov": 0.7, "znear": 0.1}}],
        "skins": [{"name": "rig", "joints": [5, 6], "inverseBindMatrices": glb.add(inverse, "MAT4")}],
        "animations": [
            {
                "name": "nod",
                "samplers": [{"input": glb.add(times, "SCALAR", min=[0], max=[1]), "output": glb.add(turns, "VEC4")}],
                "channels": [{"sampler": 0, "target": {"node": 6, "path": "rotation"}}],
            }
        ],
        "extras": {"made": "by hand"},
    }
    glb.document["scenes"][0]["nodes"].append(5)
    return glb


#: Lists that neither the simplification nor the writer touches.
KEPT = ("asset", "scene", "scenes", "nodes", "materials", "cameras", "extras", "extensionsUsed")


@pytest.fixture(scope="module")
def given() -> bytes:
    return tree().file()


@pytest.fixture(scope="module")
def scene(given: bytes) -> cm.Scene:
    return cm.read_scene(given)


@pytest.fixture()
def path(given: bytes, tmp_path: Path) -> Path:
    path = tmp_path / "in.glb"
    path.write_bytes(given)
    return path


def test_a_scene_says_what_is_in_it(scene: cm.Scene) -> None:
    assert scene.nodes == ["root", "left", "right", None, "skinned", "bone", "tip"]
    assert scene.meshes == ["ball", "blob"] and scene.materials == ["red", "plain"]
    assert (scene.animations, scene.skins, scene.cameras) == (["nod"], ["rig"], ["eye"])
    assert scene.extensions == ["KHR_materials_unlit"]
    assert scene.face_count == 2 * 5120 + 1280
    assert repr(scene) == (
        "Scene(7 nodes, 2 meshes, 11520 drawn faces, 2 materials, 1 animation, 1 skin, 1 camera)"
    )
    assert "KHR_materials_unlit" in scene._repr_html_()
    assert scene.document["nodes"][2]["extras"] == {"owner": "test", "grades": [1, 2]}
    assert scene.notes == [] and scene.lost == []
    with pytest.raises(TypeError, match="read_scene"):
        cm.Scene()


def test_paths_bytes_and_open_files_are_read(path: Path, given: bytes, scene: cm.Scene) -> None:
    assert cm.read_scene(path) == cm.read_scene(str(path)) == cm.read_scene(io.BytesIO(given)) == scene
    assert cm.read_scene(path, format="glb") == scene


def test_the_mesh_is_that_of_read(path: Path, scene: cm.Scene) -> None:
    mesh = scene.mesh()
    assert mesh == cm.read(path) and mesh.face_count == scene.face_count and mesh.joins
    assert scene.mesh(join=False) == cm.read(path, join=False)
    # An independent count of the placed points: scale 2, and 3 to both sides.
    ball = bumps(4, 1.0).vertices.astype(np.float32)
    assert np.allclose(mesh.vertices[:, 0].max(), 2 * (ball[:, 0].max() + 3), atol=1e-5)
    assert np.allclose(mesh.vertices[:, 0].min(), 2 * (ball[:, 0].min() - 3), atol=1e-5)
    # Every function takes a scene where it takes a mesh.
    assert cm.info(scene) == cm.info(mesh)


def test_a_scene_is_written_as_it_was(scene: cm.Scene, tmp_path: Path) -> None:
    for name in ("a.glb", "b.gltf"):
        told = scene.save(tmp_path / name)
        assert told["dropped"] == [] and cm.read_scene(tmp_path / name) == scene
        assert (tmp_path / name).read_bytes() == scene.to_bytes("glb" if name == "a.glb" else "gltf")
    before, after = tree().document, cm.read_scene(tmp_path / "a.glb").document
    for part in KEPT:
        assert after[part] == before[part], part
    file = io.BytesIO()
    cm.write_scene(file, scene, format="glb")
    assert file.getvalue() == scene.to_bytes()


def test_a_scene_is_rounded_and_compressed(scene: cm.Scene, tmp_path: Path) -> None:
    plain, rounded, small = (tmp_path / name for name in ("plain.glb", "rounded.glb", "small.glb"))
    scene.save(plain)
    told = scene.save(rounded, quantize=True)
    assert 0 < told["rounding"] < 1e-3 and "KHR_mesh_quantization" in cm.read_scene(rounded).extensions
    assert np.allclose(cm.read_scene(rounded).mesh().vertices, scene.mesh().vertices, atol=2 * told["rounding"])
    more = cm.write_scene(small, scene, quantize=12, compress="meshopt")
    assert more["rounding"] > told["rounding"]
    assert {"EXT_meshopt_compression", "KHR_mesh_quantization"} <= set(cm.read_scene(small).extensions)
    assert small.stat().st_size < rounded.stat().st_size < plain.stat().st_size
    assert cm.read_scene(small).face_count == scene.face_count


def test_scenes_are_pickled_copied_and_compared_by_content(scene: cm.Scene, given: bytes) -> None:
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene and again is not scene and again.to_bytes() == scene.to_bytes()
    assert again.mesh() == scene.mesh()
    assert copy.copy(scene) == scene == copy.deepcopy(scene)
    glb = tree()
    glb.document["nodes"][2]["extras"]["owner"] = "other"
    other = cm.read_scene(glb.file())
    assert other != scene and other.mesh() == scene.mesh() and scene != "scene"
    # One bit of a coordinate.
    changed = bytearray(given)
    changed[-4 * 100] ^= 1
    assert cm.read_scene(bytes(changed)) != scene


def test_what_the_reader_lost_is_pickled() -> None:
    glb = tree()
    glb.document["extensionsUsed"] = []
    scene = cm.read_scene(glb.file() + b"more")
    again = pickle.loads(pickle.dumps(scene))
    assert scene.notes and again.notes == scene.notes and again.lost == scene.lost


def test_a_simplified_scene_keeps_all_but_its_triangles(scene: cm.Scene) -> None:
    made = cm.simplify_scene(scene, ratio=0.25)
    assert made.faces_in == 11520 and made.faces_out == made.scene.face_count
    assert 0.99 * 2880 <= made.faces_out <= 2880
    ball, blob = made.meshes
    assert (ball.name, ball.times, ball.faces_in) == ("ball", 2, 5120)
    assert (blob.name, blob.times, blob.faces_in) == ("blob", 1, 1280)
    assert ball.scale == pytest.approx(2) and blob.scale == pytest.approx(1)
    assert 2 * ball.faces_out + blob.faces_out == made.faces_out
    assert (made.lost, made.notes, made.repairs) == ([], [], {})
    assert f"11520 -> {made.faces_out}" in repr(made) and "ball" in made._repr_html_()
    before, after = scene.document, made.scene.document
    for part in KEPT:
        assert after[part] == before[part], part
    assert [a["name"] for a in after["animations"]] == ["nod"] and after["skins"][0]["joints"] == [5, 6]
    assert set(after["meshes"][1]["primitives"][0]["attributes"]) == {"POSITION", "JOINTS_0", "WEIGHTS_0"}
    assert scene.face_count == 11520
    # The errors are those of the joined meshes, measured apart.
    distance = cm.distance(scene, made.scene, samples=50_000)
    largest = max(mesh.max for mesh in made.meshes)
    assert distance.max == pytest.approx(largest, rel=0.5)
    assert pickle.loads(pickle.dumps(made)).scene == made.scene
    assert scene.simplify(ratio=0.25).scene == made.scene


#: Options of Python, and those of the program.
OPTIONS: list[tuple[dict[str, Any], list[str]]] = [
    ({"ratio": 0.3}, ["--ratio", "0.3"]),
    ({"faces": 2000, "per": "mesh"}, ["--faces", "2000", "--per", "mesh"]),
    ({"ratio": 0.3, "poses": 0}, ["--ratio", "0.3", "--poses", "0"]),
    ({"max_error": "0.5%", "per": "node"}, ["--max-error", "0.5%", "--per", "node"]),
    ({"max_error": "0.2%", "preset": "fast", "verify": True}, ["--max-error", "0.2%", "--preset", "fast", "--verify"]),
    ({"ratio": 0.2, "lock_boundary": True, "keep_seams": True}, ["--ratio", "0.2", "--lock-boundary", "--keep-seams"]),
]


@pytest.mark.parametrize(("options", "arguments"), OPTIONS, ids=[" ".join(a) for _, a in OPTIONS])
def test_the_bytes_are_those_of_the_program(
    options: dict[str, Any], arguments: list[str], path: Path, program: Run, tmp_path: Path
) -> None:
    out = tmp_path / "out.glb"
    told = json.loads(program("simplify", path, "-o", out, "--json", *arguments).stdout)
    made = cm.simplify_scene(path, **options)
    assert made.scene.to_bytes() == out.read_bytes()
    assert (made.faces_in, made.faces_out) == (told["faces_in"], told["faces_out"])
    assert len(made.meshes) == len(told["meshes"]) == 2
    for mesh, expected in zip(made.meshes, told["meshes"]):
        error = expected.pop("error", None)
        assert (mesh.error is None) == (error is None)
        if mesh.error is not None:
            assert mesh.error._asdict() == error
        wanted = expected.pop("wanted_faces", None)
        assert (mesh.shortfall and mesh.shortfall.wanted_faces) == wanted
        charts = expected.pop("charts", None)
        assert (mesh.charts and list(mesh.charts)) == charts
        poses = expected.pop("poses", None)
        assert (mesh.poses and dataclasses.asdict(mesh.poses)) == poses
        assert {name: getattr(mesh, name) for name in expected} == expected


def primitives_of_every_kind() -> bytes:
    """Two primitives, of which one is small and one has flat normals."""
    glb = Glb()
    ball, small = bumps(4, 1.0), cm.shapes.sphere(1)
    apart = cm.Mesh(ball.vertices[ball.faces].reshape(-1, 3), np.arange(3 * ball.face_count).reshape(-1, 3))
    corners = ball.vertices[ball.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    flat = glb.surface(apart, NORMAL=glb.add(np.repeat(normals, 3, axis=0).astype(np.float32), "VEC3"))
    tiny = glb.surface(small.with_vertices(1e-3 * small.vertices + [5, 0, 0]))
    glb.document |= {"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "meshes": [{"primitives": [flat, tiny]}]}
    return glb.file()


def test_losses_are_those_of_the_program(program: Run, tmp_path: Path) -> None:
    path, out = tmp_path / "in.glb", tmp_path / "out.glb"
    path.write_bytes(primitives_of_every_kind())
    told = json.loads(program("simplify", path, "-o", out, "--json", "--ratio", "0.05").stdout)
    made = cm.simplify_scene(path, ratio=0.05)
    assert made.scene.to_bytes() == out.read_bytes()

    def text(lost: dict[str, Any]) -> str:
        count = f" ({lost['count']})" if "count" in lost else ""
        return f"{lost['what']}{count}: {lost['why']}"

    expected = [text(lost) for lost in told["lost"] if lost["by"] == "simplify"]
    assert made.lost == expected
    assert any("flat-shaded" in lost for lost in expected) and len(expected) == len(set(expected))


def test_a_primitive_without_faces_is_lost_as_in_the_program(program: Run, tmp_path: Path) -> None:
    path, out = tmp_path / "in.glb", tmp_path / "out.glb"
    ball, glb = bumps(3, 1.0), Glb()
    # The second primitive repeats a face of the first one, and is dropped as a needed repair.
    surfaces = [glb.surface(ball), glb.surface(cm.Mesh(ball.vertices, ball.faces[:1]))]
    meshes = [{"name": "twice", "primitives": surfaces}]
    glb.document |= {"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "meshes": meshes}
    path.write_bytes(glb.file())
    told = json.loads(program("simplify", path, "-o", out, "--json", "--ratio", "0.5").stdout)
    with pytest.warns(cm.RepairWarning):
        made = cm.simplify_scene(path, ratio=0.5)
    assert made.scene.to_bytes() == out.read_bytes()
    (lost,) = [lost for lost in told["lost"] if lost["by"] == "simplify"]
    assert made.lost == [f"{lost['what']}: {lost['why']}"] and lost["what"] == "twice: primitive 1"
    assert made.repairs == {repair["what"]: repair["count"] for repair in told["repairs"]}
    with pytest.warns(cm.RepairWarning):
        assert cm.lod_scene(path, ratios=[0.5, 0.25]).lost == made.lost


def test_levels_are_those_of_the_program(path: Path, program: Run, tmp_path: Path) -> None:
    folder, one = tmp_path / "levels", tmp_path / "one.glb"
    ratios = ["--levels", "0.5,0.2"]
    program("lod", path, "-o", folder, "--format", "glb", *ratios)
    told = json.loads(program("lod", path, "-o", one, "--json", *ratios).stdout)
    levels = cm.lod_scene(path, ratios=[0.5, 0.2], together=True)
    assert levels.together is not None and levels.together.to_bytes() == one.read_bytes()
    assert "MSFT_lod" in levels.together.extensions
    written = sorted(file.read_bytes() for file in folder.glob("*.glb"))
    assert sorted(level.scene.to_bytes() for level in levels) == written
    assert levels.shown_from == told["shown_from"]
    for level, expected in zip(levels, told["levels"]):
        assert (level.scene.face_count, level.scene.vertex_count) == (expected["faces"], expected["vertices"])
        for name in ("mean", "rms", "max", "shown_from"):
            assert getattr(level, name) == expected[name]
        assert [vars(mesh) for mesh in level.meshes] == expected["meshes"]
    assert len(levels) == 2 and levels[0].max < levels[1].max
    assert pickle.loads(pickle.dumps(levels))[1].scene == levels[1].scene
    assert cm.lod_scene(path, ratios=[0.5]).together is None
    with pytest.raises(cm.WriteError):
        cm.lod_scene(levels.together, ratios=[0.5], together=True)


def single(mesh: cm.Mesh) -> cm.Scene:
    """A scene with one mesh."""
    glb = Glb()
    meshes = [{"name": "one", "primitives": [glb.surface(mesh)]}]
    glb.document |= {"nodes": [{"mesh": 0}], "scenes": [{"nodes": [0]}], "meshes": meshes}
    return cm.read_scene(glb.file())


def test_targets_out_of_reach_are_noted() -> None:
    ball = bumps(3, 1.0)
    upper = ball.faces[ball.vertices[ball.faces].mean(axis=1)[:, 2] > 0]
    made = cm.simplify_scene(single(cm.Mesh(ball.vertices, upper)), faces=3, lock_boundary=True)
    (mesh,), (note,) = made.meshes, made.notes
    assert mesh.shortfall is not None and mesh.shortfall.wanted_faces == 3 < mesh.faces_out
    assert "one" in note and f"{mesh.faces_out} are left" in note and note in repr(made)


def test_needed_repairs_are_counted_and_warned_of() -> None:
    ball = bumps(2, 1.0)
    doubled = cm.Mesh(ball.vertices, np.vstack([ball.faces, ball.faces[:3]]), check=False)
    with pytest.warns(cm.RepairWarning, match="meshes of the scene"):
        made = cm.simplify_scene(single(doubled), faces=100)
    assert 3 in made.repairs.values()


def test_vertices_that_the_file_splits_are_merged_without_a_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        made = cm.simplify_scene(cm.read_scene(primitives_of_every_kind()), ratio=0.5)
    assert list(made.repairs) == ["merged vertices"]


def test_missing_files_are_those_of_python(scene: cm.Scene, tmp_path: Path) -> None:
    path = tmp_path / "nothing.glb"
    with pytest.raises(FileNotFoundError) as caught:
        cm.read_scene(path)
    assert isinstance(caught.value, cm.ReadError)
    assert (caught.value.errno, caught.value.filename) == (errno.ENOENT, str(path))
    with pytest.raises(FileNotFoundError) as missing:
        scene.save(tmp_path / "none" / "a.glb")
    assert isinstance(missing.value, cm.WriteError) and missing.value.errno == errno.ENOENT


WRONG: list[tuple[Callable[[Any, Any], object], type[Exception], str]] = [
    (lambda s, at: cm.simplify_scene(s), cm.OptionError, "ratio="),
    (lambda s, at: cm.simplify_scene(s, ratio=1.5), cm.OptionError, "from 0 to 1"),
    (lambda s, at: cm.simplify_scene(s, ratio=math.nan), cm.OptionError, "from 0 to 1"),
    (lambda s, at: s.simplify(ratio=0.5, per="part"), cm.OptionError, '"mesh"'),
    (lambda s, at: cm.simplify_scene(s, max_error=-1.0), cm.OptionError, "max_error"),
    (lambda s, at: cm.simplify_scene(3, ratio=0.5), cm.OptionError, "curvmesh.Scene"),
    (lambda s, at: cm.lod_scene(s), cm.OptionError, "ratios="),
    (lambda s, at: cm.lod_scene(s, ratios=[2.0]), cm.OptionError, "from 0 to 1"),
    (lambda s, at: cm.read_scene(b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"), cm.ReadError, "glTF or GLB"),
    (lambda s, at: cm.read_scene(b"glTF"), cm.ReadError, ""),
    (lambda s, at: cm.read_scene(s.face_count), cm.OptionError, "path"),
    (lambda s, at: s.save(at / "a.ply"), cm.WriteError, "holds no scenes"),
    (lambda s, at: s.save(at / "a.glb", quantize=20), cm.OptionError, "from 8 to 16"),
    (lambda s, at: s.save(at / "a.glb", compress="zip"), cm.OptionError, '"meshopt"'),
    (lambda s, at: s.write(io.BytesIO()), cm.OptionError, "format="),
    (lambda s, at: s.to_bytes("obj"), cm.OptionError, '"gltf"'),
    (lambda s, at: cm.read_scene(s.to_bytes(), max_memory=10), cm.ReadError, "max_memory="),
]


@pytest.mark.parametrize(("work", "kind", "text"), WRONG)
def test_errors_name_the_cure(
    work: Callable[[Any, Any], object], kind: type[Exception], text: str, scene: cm.Scene, tmp_path: Path
) -> None:
    with pytest.raises(kind) as caught:
        work(scene, tmp_path)
    assert text in str(caught.value)


def test_a_scene_without_triangles_is_refused_unless_allowed() -> None:
    glb = Glb()
    points = glb.add(np.zeros((2, 3), dtype=np.float32), "VEC3", min=[0, 0, 0], max=[0, 0, 0])
    glb.document |= {
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "meshes": [{"primitives": [{"mode": 0, "attributes": {"POSITION": points}}]}],
    }
    with pytest.raises(cm.CannotBeDoneError) as caught:
        cm.simplify_scene(cm.read_scene(glb.file()), ratio=0.5)
    assert caught.value.cure == "allow_empty=True"
    allowed = cm.read_scene(glb.file(), allow_empty=True)
    assert cm.simplify_scene(allowed, ratio=0.5).scene == allowed


def test_progress_goes_from_mesh_to_mesh_and_the_callback_ends_it(given: bytes) -> None:
    glb = Glb()
    meshes = [{"primitives": [glb.surface(bumps(6, phase))]} for phase in (1.0, 2.0)]
    nodes = [{"mesh": place, "translation": [3 * place, 0, 0]} for place in (0, 1)]
    glb.document |= {"nodes": nodes, "scenes": [{"nodes": [0, 1]}], "meshes": meshes}
    scene = cm.read_scene(glb.file())
    seen: list[float] = []
    cm.simplify_scene(scene, ratio=0.1, per="mesh", progress=seen.append)
    assert seen[-1] == 1 and all(0 <= part <= 1 for part in seen) and any(part > 0.5 for part in seen[:-1])
    ended = cm.simplify_scene(scene, ratio=0.1, per="mesh", callback=lambda state: False)
    assert ended.faces_out > 0.1 * ended.faces_in
    assert any(mesh.stop == "cancelled" for mesh in ended.meshes)


def test_the_number_of_threads_changes_nothing(scene: cm.Scene) -> None:
    one, two = (cm.simplify_scene(scene, ratio=0.3, threads=threads).scene for threads in (1, 2))
    assert one == two
