"""Meshes and scenes of trimesh."""

from __future__ import annotations

from typing import Any

from ..._errors import ArrayError
from ..mesh import Mesh
from .parts import (
    EXTRAS,
    image_of,
    in_bytes,
    merged,
    noted,
    owned,
    picture_of,
    put,
    read_extras,
    rejoined,
    separate,
    taken,
    tell,
    triangles,
    with_extras,
)


def of_scene(source: Any, check: bool) -> Mesh:
    """A ``trimesh.Scene``: the meshes of all nodes, each a group."""
    meshes, names = [], []
    notes: list[str] = []
    for node in source.graph.nodes_geometry:
        transform, geometry = source.graph[node]
        part = source.geometry[geometry]
        if hasattr(part, "faces"):
            part = part.copy()
            part.apply_transform(transform)
            meshes.append(of_trimesh(part, check))
            names.append(str(node))
        else:
            notes.append(f"{node!r} was left out: a {type(part).__name__} has no faces")
    if not meshes:
        raise ArrayError(f"the {type(source).__name__} has no meshes")
    return noted(merged(meshes, names), notes)


def of_trimesh(source: Any, check: bool) -> Mesh:
    """A ``trimesh.Trimesh``."""
    import numpy as np

    mesh, notes = Mesh(source.vertices, source.faces, check=check), list[str]()
    of_points = taken(getattr(source, "vertex_attributes", None), mesh.vertex_count, notes)
    of_faces = taken(getattr(source, "face_attributes", None), mesh.face_count, notes)
    # Normals that were given, or computed already; an access forgets them if the vertices have changed.
    cache: Any = getattr(source, "_cache", None)
    normals = cache["vertex_normals"] if hasattr(cache, "verify") else None
    if normals is not None and np.shape(normals) == (mesh.vertex_count, 3):
        of_points["normals"] = np.asarray(normals)
    look: Any = getattr(source, "visual", None)
    kind = getattr(look, "kind", None)
    if kind == "vertex":
        of_points["colors"] = np.asarray(look.vertex_colors)
    elif kind == "face":
        of_faces["colors"] = np.asarray(look.face_colors)
    kept = read_extras((getattr(source, "metadata", None) or {}).get(EXTRAS))
    is_replaced = False
    if kept:
        with_extras(mesh, kept)
        ids = of_faces.get("materials")
        is_replaced = kind == "texture" and _seen(look) != _seen(_texture(mesh, None, ids))
        if is_replaced:
            of_faces.pop("materials", None)
    owned(mesh, of_faces, kept, notes)
    if kind == "texture" and (is_replaced or not kept):
        _take_materials(mesh, look, of_faces, notes)
    put(mesh.vertex_data, of_points, notes)
    put(mesh.face_data, of_faces, notes)
    uv = getattr(look, "uv", None) if kind == "texture" else None
    if uv is not None and len(uv) == mesh.vertex_count:
        mesh.corner_data["uvs"] = np.asarray(uv)[mesh.corners]
        mesh = rejoined(mesh, kept)
    return noted(mesh, notes)


def _take_materials(mesh: Mesh, look: Any, of_faces: dict[str, Any], notes: list[str]) -> None:
    import numpy as np

    several = getattr(look.material, "materials", None)
    materials: list[dict[str, Any]] = []
    images: list[dict[str, Any]] = []
    for material in several or [look.material]:
        found, picture, lost = _material(material)
        if picture is not None:
            image = image_of(picture, found["name"], notes)
            if image is not None:
                found["image"] = len(images)
                images.append(image)
        notes += [f"{what} of material {found['name']!r} was left out" for what in lost]
        materials.append(found)
    # Materials of before may refer to more images.
    mesh.materials = []
    mesh.images = images
    mesh.materials = materials
    which = getattr(look, "face_materials", None) if several else None
    of_faces["materials"] = np.zeros(mesh.face_count, int) if which is None else np.asarray(which)


def _seen(look: Any) -> list[Any]:
    """What shows whether textures are the same: materials, and the pixels of their pictures."""
    found = [_material(material) for material in getattr(look.material, "materials", None) or [look.material]]
    return [(about, p and (p.mode, p.size, p.tobytes()), lost) for about, p, lost in found]


def _material(material: Any) -> tuple[dict[str, Any], Any, list[str]]:
    """A material, its picture, and the names of what is lost."""
    import numpy as np

    if hasattr(material, "to_pbr"):
        material = material.to_pbr()

    def number(name: str, usual: float) -> float:
        value = getattr(material, name, None)
        return usual if value is None else float(value)

    color = getattr(material, "baseColorFactor", None)
    color = np.ones(4) if color is None else np.asarray(color)
    color = color / 255 if color.dtype.kind in "ui" else color
    emissive = getattr(material, "emissiveFactor", None)
    alpha: Any = {"MASK": number("alphaCutoff", 0.5), "BLEND": "blend"}.get(
        getattr(material, "alphaMode", None) or "OPAQUE", "opaque"
    )
    found = {
        "name": str(getattr(material, "name", None) or ""),
        "base_color": [float(x) for x in color] + [1.0] * (4 - len(color)),
        "image": None,
        "metallic": number("metallicFactor", 0.0),
        "roughness": number("roughnessFactor", 1.0),
        "emissive": [0.0] * 3 if emissive is None else [float(x) for x in np.asarray(emissive)[:3]],
        "double_sided": bool(getattr(material, "doubleSided", False)),
        "alpha": alpha,
    }
    others = ("normalTexture", "emissiveTexture", "metallicRoughnessTexture", "occlusionTexture")
    lost = [name for name in others if getattr(material, name, None) is not None]
    return found, getattr(material, "baseColorTexture", None), lost


def to_trimesh(mesh: Mesh) -> Any:
    """A ``trimesh.Trimesh`` with all data: vertices are split where texture coordinates or normals of
    their corners differ. Groups are in ``metadata``."""
    import numpy as np
    import trimesh

    source = mesh
    mesh = triangles(mesh, "trimesh")
    parts = separate(source, "trimesh", of=mesh)
    # A mesh of trimesh has one look only.
    colors = {"vertex_colors": parts.of_points.pop("colors", None), "face_colors": parts.of_faces.pop("colors", None)}
    made = trimesh.Trimesh(
        parts.positions, parts.corners.reshape(-1, 3), vertex_normals=parts.normals, process=False
    )
    kinds = []
    if parts.uvs is not None:
        made.visual = _texture(mesh, parts.uvs, mesh.face_data.get("materials"))
        kinds.append("texture")
    for name, rows in colors.items():
        if rows is not None and kinds:
            tell(source, "trimesh", [f"{name.replace('_', ' ')} beside {kinds[0].replace('_', ' ')}"])
        elif rows is not None:
            setattr(made.visual, name, rows)
            kinds.append(name)
    for name, values in parts.of_points.items():
        made.vertex_attributes[name] = values
    for name, values in parts.of_faces.items():
        made.face_attributes[name] = values
    if parts.extras:
        made.metadata[EXTRAS] = parts.extras
        made.metadata["groups"] = np.array(["/".join(filter(None, group)) for group in mesh.groups])
    return made


def _texture(mesh: Mesh, uvs: Any, ids: Any) -> Any:
    import numpy as np
    import trimesh
    from trimesh.visual.material import MultiMaterial, PBRMaterial

    def made(material: dict[str, Any]) -> Any:
        alpha = material["alpha"]
        return PBRMaterial(
            name=material["name"],
            baseColorFactor=in_bytes(np.array(material["base_color"])),
            baseColorTexture=picture_of(mesh, material),
            metallicFactor=material["metallic"],
            roughnessFactor=material["roughness"],
            emissiveFactor=material["emissive"],
            doubleSided=material["double_sided"],
            alphaMode={"opaque": "OPAQUE", "blend": "BLEND"}.get(alpha, "MASK"),
            alphaCutoff=alpha if not isinstance(alpha, str) else None,
        )

    materials = [made(material) for material in mesh.materials]
    if len(materials) > 1 and ids is not None:
        return trimesh.visual.TextureVisuals(uv=uvs, material=MultiMaterial(materials=materials), face_materials=ids)
    return trimesh.visual.TextureVisuals(uv=uvs, material=materials[0] if materials else None)
