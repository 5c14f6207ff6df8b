"""The Blender add-on: simplify, flip and measure the active mesh with curvmesh.

Install the Python package into the Python of Blender (``python -m pip install curvmesh``), then this file under
Edit > Preferences > Add-ons > Install from Disk. The tools are in the sidebar of the 3D view (key N), tab "curvmesh".
"""

import warnings

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty

try:
    import curvmesh as cm
except ImportError:  # The panel says what to do.
    cm = None

bl_info = {
    "name": "curvmesh",
    "author": "The curvmesh developers",
    "version": (0, 1, 0),
    "blender": (4, 2, 0),
    "location": "View3D > Sidebar > curvmesh",
    "description": "Simplify, flip and measure meshes by their curvature",
    "category": "Mesh",
}

GROUP = "group:"
"""The beginning of the names of columns with the weights of vertex groups."""

MATERIAL = "material_index"
"""The column with the material slot of each face. It is a whole number, so it is never blended."""


def of_blender(source):
    """A mesh of Blender as a ``curvmesh.Mesh`` of triangles, and a list of what does not come along.

    The active UV map, material slots and the weights of vertex groups come along.
    """
    source.calc_loop_triangles()
    count, triangles = len(source.vertices), len(source.loop_triangles)
    positions = np.empty(3 * count, np.float32)
    source.vertices.foreach_get("co", positions)
    faces = np.empty(3 * triangles, np.int32)
    source.loop_triangles.foreach_get("vertices", faces)
    mesh = cm.Mesh(positions.reshape(-1, 3), faces.reshape(-1, 3))

    materials = np.empty(triangles, np.int32)
    source.loop_triangles.foreach_get("material_index", materials)
    if materials.any():
        mesh.face_data[MATERIAL] = materials

    layer = source.uv_layers.active
    if layer is not None:
        loops = np.empty(3 * triangles, np.int32)
        source.loop_triangles.foreach_get("loops", loops)
        uvs = np.empty(2 * len(source.loops), np.float32)
        layer.uv.foreach_get("vector", uvs)
        mesh.corner_data["uvs"] = uvs.reshape(-1, 2)[loops]

    weights = {}
    for vertex in source.vertices:
        for entry in vertex.groups:
            column = weights.setdefault(entry.group, np.zeros(count))
            column[vertex.index] = entry.weight
    mesh.vertex_data.update({f"{GROUP}{group}": column for group, column in weights.items()})
    return mesh, _lost(source)


def _lost(source):
    others = [layer.name for layer in source.uv_layers if not layer.active]
    lost = [f"UV map {name}" for name in others]
    if source.shape_keys is not None:
        lost.append(f"{len(source.shape_keys.key_blocks)} shape keys")
    lost += [f"colors {attribute.name}" for attribute in source.color_attributes]
    edges = len(source.edges) - len({key for face in source.polygons for key in face.edge_keys})
    if edges > 0:
        lost.append(f"{edges} edges without a face")
    return lost


def to_blender(mesh, name, like=None):
    """A ``curvmesh.Mesh`` as a new mesh of Blender, and the weights of vertex groups: for each index of a group, one
    weight for each vertex.

    The new mesh has the materials of `like`.
    """
    made = bpy.data.meshes.new(name)
    made.from_pydata(mesh.vertices, [], mesh.faces)
    for material in [] if like is None else like.materials:
        made.materials.append(material)
    if MATERIAL in mesh.face_data:
        made.polygons.foreach_set("material_index", np.asarray(mesh.face_data[MATERIAL], np.int32))
    if "uvs" in mesh.corner_data:
        active = None if like is None else like.uv_layers.active
        layer = made.uv_layers.new(name="UVMap" if active is None else active.name)
        layer.uv.foreach_set("vector", np.asarray(mesh.corner_data["uvs"], np.float32).ravel())
    if like is not None and any(face.use_smooth for face in like.polygons):
        made.polygons.foreach_set("use_smooth", np.ones(len(made.polygons), bool))
    made.update()
    groups = [name for name in mesh.vertex_data if name.startswith(GROUP)]
    return made, {int(name.removeprefix(GROUP)): mesh.vertex_data[name] for name in groups}


def replace(holder, mesh):
    """Gives an object a new mesh. Its materials and vertex groups stay."""
    old = holder.data
    made, weights = to_blender(mesh, old.name, old)
    groups, active = [group.name for group in holder.vertex_groups], holder.vertex_groups.active_index
    holder.data = made
    # A new mesh takes the groups away.
    holder.vertex_groups.clear()
    for group in groups:
        holder.vertex_groups.new(name=group)
    holder.vertex_groups.active_index = active
    for group, column in weights.items():
        # Weights of groups that the object does not have mean nothing.
        for vertex in np.flatnonzero(column) if group < len(groups) else []:
            holder.vertex_groups[group].add([int(vertex)], float(column[vertex]), "REPLACE")
    if old.users == 0:
        bpy.data.meshes.remove(old)
    return made


class _Tool:
    """What all operators share: the active mesh in, messages out."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        holder = context.active_object
        return cm is not None and holder is not None and holder.type == "MESH" and holder.mode == "OBJECT"

    def execute(self, context):
        holder = context.active_object
        if holder.data.users > 1 and self.replaces:
            self.report({"ERROR"}, "other objects use this mesh: Object > Relations > Make Single User > Object & Data")
            return {"CANCELLED"}
        with warnings.catch_warnings(record=True) as repairs:
            warnings.simplefilter("always")
            try:
                mesh, lost = of_blender(holder.data)
                message = self.run(holder, mesh)
            except cm.CurvmeshError as error:
                self.report({"ERROR"}, str(error))
                return {"CANCELLED"}
        for repair in repairs:
            self.report({"WARNING"}, str(repair.message))
        if lost and self.replaces:
            self.report({"WARNING"}, "not kept: " + ", ".join(lost))
        self.report({"INFO"}, message)
        return {"FINISHED"}


class CURVMESH_OT_simplify(_Tool, bpy.types.Operator):
    """Fewer triangles, with the least change of the shape"""

    bl_idname = "curvmesh.simplify"
    bl_label = "Simplify"
    replaces = True

    ratio: FloatProperty(name="Ratio", description="Share of the triangles that stays", default=0.5, min=0.0, max=1.0)
    max_error: FloatProperty(
        name="Largest Error",
        description="Largest distance from the original, in % of the diagonal; 0 for no limit. With a limit, as few"
        " triangles as possible stay, but no fewer than the ratio",
        default=0.0,
        min=0.0,
        max=100.0,
    )
    preset: EnumProperty(
        name="Preset",
        items=[(name, name.title(), "") for name in ("draft", "fast", "default", "quality", "extreme")],
        default="default",
    )
    keep_seams: BoolProperty(name="Keep Seams", description="Keep all borders of UV charts and materials")
    lock_boundary: BoolProperty(name="Lock Boundary", description="Keep all vertices of the boundary")

    def run(self, holder, mesh):
        before = mesh.face_count
        limit = f"{self.max_error}%" if self.max_error > 0 else None
        found = cm.simplify(
            mesh,
            ratio=self.ratio,
            max_error=limit,
            preset=self.preset,
            keep_seams=self.keep_seams,
            lock_boundary=self.lock_boundary,
        )
        replace(holder, found.mesh)
        error = "" if found.error is None or found.error.upper is None else f", error at most {found.error.upper:.3g}"
        return f"{before} -> {found.mesh.face_count} triangles{error}"


class CURVMESH_OT_flip(_Tool, bpy.types.Operator):
    """A better triangulation of the same vertices, by edge flips"""

    bl_idname = "curvmesh.flip"
    bl_label = "Flip Edges"
    replaces = True

    cost: EnumProperty(
        name="Cost",
        items=[
            ("f1", "Gaussian Curvature", "Integral of the absolute Gaussian curvature, F1"),
            ("f2", "Mean Curvature", "Integral of the absolute mean curvature, F2"),
            ("f3", "Principal Curvatures", "Integral of the absolute principal curvatures, F3"),
            ("delaunay", "Delaunay", "Larger angles"),
        ],
        default="f2",
    )

    def run(self, holder, mesh):
        found = cm.flip(mesh, cost=self.cost)
        replace(holder, found.mesh)
        return f"{found.flips} edges flipped"


class CURVMESH_OT_curvature(_Tool, bpy.types.Operator):
    """Curvature of the vertices, as an attribute of the mesh"""

    bl_idname = "curvmesh.curvature"
    bl_label = "Measure Curvature"
    replaces = False

    quantity: EnumProperty(
        name="Quantity",
        items=[
            ("mean", "Mean", "Mean curvature, 1 per unit of length"),
            ("gaussian", "Gaussian", "Gaussian curvature, 1 per unit of area"),
            ("k1", "Largest", "The larger principal curvature"),
            ("k2", "Smallest", "The smaller principal curvature"),
        ],
        default="mean",
    )

    def run(self, holder, mesh):
        values = np.asarray(cm.curvature(mesh)[self.quantity], np.float32)
        attributes, name = holder.data.attributes, f"curvature_{self.quantity}"
        if name in attributes:
            attributes.remove(attributes[name])
        attributes.new(name=name, type="FLOAT", domain="POINT").data.foreach_set("value", values)
        known = np.isfinite(values)
        if not known.any():
            return f"{name}: unknown at all vertices"
        low, high = values[known].min(), values[known].max()
        return f"{name}: {low:.4g} to {high:.4g}, unknown (NaN) at {(~known).sum()} vertices"


class CURVMESH_PT_tools(bpy.types.Panel):
    """The tools in the sidebar."""

    bl_label = "curvmesh"
    bl_idname = "CURVMESH_PT_tools"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"
    bl_category = "curvmesh"

    def draw(self, context):
        if cm is None:
            self.layout.label(text="Install the package curvmesh", icon="ERROR")
            self.layout.label(text="into the Python of Blender:")
            self.layout.label(text="python -m pip install curvmesh")
            return
        for tool in TOOLS:
            self.layout.operator(tool.bl_idname)


TOOLS = (CURVMESH_OT_simplify, CURVMESH_OT_flip, CURVMESH_OT_curvature)


def register():
    for kind in (*TOOLS, CURVMESH_PT_tools):
        bpy.utils.register_class(kind)


def unregister():
    for kind in reversed((*TOOLS, CURVMESH_PT_tools)):
        bpy.utils.unregister_class(kind)


if __name__ == "__main__":
    register()
