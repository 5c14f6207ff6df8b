"""Meshes of Open3D, legacy and tensor."""

from __future__ import annotations

from typing import Any

from ..mesh import Data, Mesh
from .parts import given, has_twins, image_of, note, noted, owned, picture_of, put, taken, tell, triangles


def of_open3d(source: Any, check: bool) -> Mesh:
    """An ``open3d.geometry.TriangleMesh``."""
    import numpy as np

    mesh = Mesh(np.asarray(source.vertices), np.asarray(source.triangles), check=check)
    notes: list[str] = []
    found: dict[str, Any] = {}
    if source.has_vertex_colors():
        found["colors"] = np.asarray(source.vertex_colors)
    if source.has_vertex_normals():
        found["normals"] = np.asarray(source.vertex_normals)
    put(mesh.vertex_data, found, notes)
    ids = np.asarray(source.triangle_material_ids)
    images: list[dict[str, Any]] = []
    materials: list[dict[str, Any]] = []
    for number, picture in enumerate(source.textures):
        # An empty texture is that of a material without one, and keeps its number.
        image = None if picture.is_empty() else image_of(np.asarray(picture), "", notes)
        materials.append({"name": f"texture {number}", "image": None if image is None else len(images)})
        images += [] if image is None else [image]
    mesh.images, mesh.materials = images, materials
    if len(ids) == mesh.face_count and materials:
        mesh.face_data["materials"] = np.where(ids < len(materials), ids, -1)
    elif len(ids) == mesh.face_count and ids.any():
        found = {"material_ids": ids}
        notes.append("ids of materials are the numbers 'material_ids': the mesh has no textures")
        put(mesh.face_data, found, notes)
    if source.has_triangle_uvs():
        mesh.corner_data["uvs"] = np.asarray(source.triangle_uvs)
        mesh = mesh.joined()
    return noted(mesh, notes)


def of_tensors(source: Any, check: bool) -> Mesh:
    """An ``open3d.t.geometry.TriangleMesh``."""
    import numpy as np

    def arrays(tensors: Any, *others: str) -> dict[str, Any]:
        return {name: tensors[name].cpu().numpy() for name in list(tensors) if name not in others}

    points = source.vertex.positions.cpu().numpy()
    mesh = Mesh(points, source.triangle.indices.cpu().numpy(), check=check)
    notes: list[str] = []
    put(mesh.vertex_data, taken(arrays(source.vertex, "positions", "texture_uvs"), mesh.vertex_count, notes), notes)
    of_faces = taken(arrays(source.triangle, "indices", "texture_uvs"), mesh.face_count, notes)
    if of_faces.pop("normals", None) is not None:
        notes.append("normals of faces were left out: they follow from the positions")
    owned(mesh, of_faces, None, notes)
    is_valid = source.has_valid_material()
    maps = source.material.texture_maps if is_valid else {}
    if is_valid:
        picture = image_of(maps["albedo"].as_tensor().cpu().numpy(), "", notes) if "albedo" in maps else None
        mesh.images = [picture] if picture is not None else []
        mesh.materials = [_material(source.material, has_image=picture is not None)]
        of_faces["materials"] = np.zeros(mesh.face_count, int)
    notes += [f"the texture map {name!r} was left out" for name in maps if name != "albedo"]
    put(mesh.face_data, of_faces, notes)
    if "texture_uvs" in source.triangle:
        mesh.corner_data["uvs"] = source.triangle.texture_uvs.cpu().numpy().reshape(-1, 2)
        mesh = mesh.joined()
    elif "texture_uvs" in source.vertex:
        mesh.corner_data["uvs"] = source.vertex.texture_uvs.cpu().numpy()[mesh.corners]
        mesh = mesh.joined()
    return noted(mesh, notes)


def _material(source: Any, has_image: bool) -> dict[str, Any]:
    """A material of the tensors."""
    vectors, numbers = source.vector_properties, source.scalar_properties
    found: dict[str, Any] = {"name": source.material_name, "image": 0 if has_image else None}
    if "base_color" in vectors:
        found["base_color"] = [float(x) for x in vectors["base_color"]]
    if "emissive_color" in vectors:
        found["emissive"] = [float(x) for x in vectors["emissive_color"]][:3]
    for name in ("metallic", "roughness"):
        if name in numbers:
            found[name] = float(numbers[name])
    return found


def to_open3d(mesh: Mesh, *, tensor: bool = False) -> Any:
    """An ``open3d.geometry.TriangleMesh``; with ``tensor=True`` an ``open3d.t.geometry.TriangleMesh``, which
    also has named numbers.

    A warning lists what it cannot store.
    """
    import numpy as np
    import open3d

    source = mesh
    mesh = triangles(mesh, "Open3D")
    # Texture coordinates make a mesh join when it is read back.
    is_lost = source.joins not in (None, "uvs" in mesh.corner_data or None) and has_twins(source)
    unsaid = [f"joins={source.joins}"] * is_lost
    if tensor:
        made, lost = _tensors(source, mesh)
        tell(source, "Open3D", lost + unsaid)
        return made
    vector = open3d.utility.Vector3dVector
    # Read-only arrays are not accepted.
    made = open3d.geometry.TriangleMesh(
        vector(mesh.vertices.copy()), open3d.utility.Vector3iVector(mesh.faces.copy())
    )
    if "colors" in mesh.vertex_data:
        made.vertex_colors = vector(mesh.vertex_data["colors"][:, :3].astype(np.float64))
    if "normals" in mesh.vertex_data:
        made.vertex_normals = vector(mesh.vertex_data["normals"].astype(np.float64))
    if "uvs" in mesh.corner_data:
        uvs = mesh.corner_data["uvs"].astype(np.float64)
        made.triangle_uvs = open3d.utility.Vector2dVector(uvs)
    lost = ["opacity of colours"] * any((d["colors"][:, 3] < 1).any() for d in _colored(mesh))
    lost += [*given(mesh.vertex_data), *(n for n in given(mesh.face_data) if n not in ("materials", "groups"))]
    lost += ["colours of faces"] * ("colors" in mesh.face_data) + ["groups"] * bool(mesh.groups)
    lost += ["normals of corners"] * ("normals" in mesh.corner_data)
    lost += ["materials without faces"] * bool(mesh.materials and "materials" not in mesh.face_data)
    if mesh.materials and "materials" in mesh.face_data:
        pictures = [picture_of(mesh, material) for material in mesh.materials]
        lost += [
            f"material {m['name']!r}" + (" beside its texture" if p is not None else "")
            for m, p in zip(mesh.materials, pictures)
        ]
        lost += ["faces without a material"] * bool((mesh.face_data["materials"] < 0).any())
        rows: list[Any] = [None if picture is None else np.array(picture.convert("RGB")) for picture in pictures]
        image = open3d.geometry.Image
        made.textures = [image() if array is None else image(array) for array in rows]
        ids = np.maximum(mesh.face_data["materials"], 0).astype(np.int32)
        made.triangle_material_ids = open3d.utility.IntVector(ids)
    tell(source, "Open3D", lost + unsaid)
    return made


def _tensors(source: Mesh, mesh: Mesh) -> tuple[Any, list[str]]:
    """The mesh, and the names of what it cannot store."""
    import numpy as np
    import open3d

    def tensor(array: Any) -> Any:
        return open3d.core.Tensor.from_numpy(np.ascontiguousarray(array))

    made = open3d.t.geometry.TriangleMesh(tensor(mesh.vertices), tensor(mesh.faces))
    of_points = {**given(mesh.vertex_data)}
    of_faces = {n: v for n, v in given(mesh.face_data).items() if n not in ("materials", "groups")}
    for name in ("colors", "normals"):
        if name in mesh.vertex_data:
            of_points[name] = mesh.vertex_data[name][:, :3]
    if "colors" in mesh.face_data:
        of_faces["colors"] = mesh.face_data["colors"][:, :3]
    if "uvs" in mesh.corner_data:
        of_faces["texture_uvs"] = mesh.corner_data["uvs"].reshape(-1, 3, 2)
    for columns in (of_points, of_faces):
        for name in ("positions", "indices"):
            if name in columns:
                columns[f"{name}_values"] = columns.pop(name)
                note(source, f"a mesh of Open3D has {name} of its own: the numbers {name!r} are '{name}_values' there")
    for name, values in of_points.items():
        made.vertex[name] = tensor(values.reshape(len(values), -1) if values.ndim == 1 else values)
    for name, values in of_faces.items():
        made.triangle[name] = tensor(values.reshape(len(values), -1) if values.ndim == 1 else values)
    lost = ["groups"] * bool(mesh.groups) + ["normals of corners"] * ("normals" in mesh.corner_data)
    lost += ["opacity of colours"] * any((d["colors"][:, 3] < 1).any() for d in _colored(mesh))
    for number, material in enumerate(mesh.materials):
        if number > 0:
            lost.append(f"material {material['name']!r}")
            continue
        picture = picture_of(mesh, material)
        made.material.material_name = "defaultLit"
        made.material.vector_properties["base_color"] = np.array(material["base_color"], np.float32)
        glow = np.array([*material["emissive"], 1], np.float32)
        made.material.vector_properties["emissive_color"] = glow
        made.material.scalar_properties["metallic"] = material["metallic"]
        made.material.scalar_properties["roughness"] = material["roughness"]
        if picture is not None:
            image = open3d.t.geometry.Image(tensor(np.array(picture.convert("RGB"))))
            made.material.texture_maps["albedo"] = image
        lost.append(f"material {material['name']!r} beside its colours and texture")
    return made, lost


def _colored(mesh: Mesh) -> list[Data]:
    return [data for data in (mesh.vertex_data, mesh.face_data) if "colors" in data]
