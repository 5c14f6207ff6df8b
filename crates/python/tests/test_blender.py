"""The add-on for Blender, in the Blender that is a package of Python (``bpy``), if it is installed."""

from __future__ import annotations

import importlib.util
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm

bpy: Any = pytest.importorskip("bpy")

FILE = Path(__file__).parent.parent / "blender" / "curvmesh_blender.py"


@pytest.fixture(scope="module")
def addon() -> Iterator[Any]:
    spec = importlib.util.spec_from_file_location("curvmesh_blender", FILE)
    assert spec is not None and spec.loader is not None
    module: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.register()
    yield module
    module.unregister()


@pytest.fixture
def sphere() -> Any:
    """The active object: a sphere with UVs, two materials by height, and a vertex group on the upper half."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=48, ring_count=24)
    made = bpy.context.active_object
    for name in ("lower", "upper"):
        made.data.materials.append(bpy.data.materials.new(name))
    for face in made.data.polygons:
        face.material_index = int(face.center.z > 0)
    group = made.vertex_groups.new(name="top")
    group.add([v.index for v in made.data.vertices if v.co.z > 0], 1.0, "REPLACE")
    return made


def test_simplify_keeps_uvs_materials_and_weights(addon: Any, sphere: Any) -> None:
    before = len(sphere.data.loop_triangles) or sum(len(face.vertices) - 2 for face in sphere.data.polygons)
    assert bpy.ops.curvmesh.simplify(ratio=0.25) == {"FINISHED"}
    data = sphere.data
    assert 0 < len(data.polygons) <= round(0.25 * before)
    assert not data.validate()
    assert [material.name for material in data.materials] == ["lower", "upper"]
    for face in data.polygons:
        z = face.center.z
        assert face.material_index == int(z > 0) or abs(z) < 0.15
    assert len(data.uv_layers) == 1
    # UV spheres have u from the longitude and v from the latitude.
    uvs = data.uv_layers[0].uv
    for face in data.polygons:
        for loop, vertex in zip(face.loop_indices, face.vertices):
            latitude = np.arcsin(np.clip(data.vertices[vertex].co.normalized().z, -1, 1))
            assert abs(uvs[loop].vector.y - (0.5 + latitude / np.pi)) < 0.05
    for vertex in data.vertices:
        weight = sum(entry.weight for entry in vertex.groups)
        assert abs(vertex.co.z) < 0.3 or abs(weight - (vertex.co.z > 0)) < 0.01


def test_flip_keeps_the_vertices(addon: Any, sphere: Any) -> None:
    before = sorted(tuple(v.co) for v in sphere.data.vertices)
    assert bpy.ops.curvmesh.flip(cost="f2") == {"FINISHED"}
    assert sorted(tuple(v.co) for v in sphere.data.vertices) == before


def test_curvature_is_an_attribute(addon: Any, sphere: Any) -> None:
    assert bpy.ops.curvmesh.curvature(quantity="mean") == {"FINISHED"}
    found = np.empty(len(sphere.data.vertices), np.float32)
    sphere.data.attributes["curvature_mean"].data.foreach_get("value", found)
    assert abs(np.nanmedian(found) - 1) < 0.02


def test_what_is_lost_and_errors_are_said(addon: Any, sphere: Any) -> None:
    sphere.shape_key_add(name="Basis")
    _, lost = addon.of_blender(sphere.data)
    assert lost == ["1 shape keys"]
    sphere.shape_key_clear()
    sphere.data.vertices[0].co.x = float("nan")
    with pytest.raises(cm.NotFiniteError):
        addon.of_blender(sphere.data)
    with pytest.raises(RuntimeError, match="^Error: vertex 0 is at .* which is not finite"):
        bpy.ops.curvmesh.simplify(ratio=0.5)


def test_a_mesh_of_several_objects_is_not_replaced(addon: Any, sphere: Any) -> None:
    bpy.context.collection.objects.link(bpy.data.objects.new("twin", sphere.data))
    with pytest.raises(RuntimeError, match="Single User"):
        bpy.ops.curvmesh.simplify(ratio=0.5)
