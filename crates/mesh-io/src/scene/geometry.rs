//! The triangles of a mesh, with all data of their vertices.

use mesh_core::as_u32;

use super::document::Scene;
use super::extensions::is_known;
use super::vertex_data::VertexData;
use crate::color_range::to_unit_range;
use crate::error::{ReadError, ReadErrorKind};
use crate::gltf::accessor::{Document, at, item};
use crate::gltf::material::base_texture;
use crate::gltf::plan::{Plan, not_draco, path_of};
use crate::gltf::read::{check_extensions, read_mesh};
use crate::gltf::schema::{Attributes, Primitive};
use crate::model::{Group, Material, Model};
use crate::notes::Notes;
use std::collections::HashMap;
use std::ops::Range;

/// The triangles of a mesh.
#[derive(Clone, Debug)]
pub struct SceneMesh {
    /// The triangles in the coordinates of the mesh, exactly as [`read`](crate::read()) reads the mesh from a scene
    /// without transforms. Each primitive is a group if there are several. Materials are numbered in the order of the
    /// faces, and have no content.
    pub model: Model,
    /// The primitives with triangles, in the order of the faces of the model.
    pub primitives: Vec<ScenePrimitive>,
}

/// The vertices of a primitive, and its place in the model of its mesh.
#[derive(Clone, Debug)]
pub struct ScenePrimitive {
    /// The index in the mesh.
    pub index: usize,
    /// The faces of the model.
    pub faces: Range<usize>,
    /// The vertex of the model that is the first vertex of the primitive. Primitives can share vertices.
    pub first_vertex: u32,
    /// The number of vertices.
    pub vertex_count: usize,
    /// The attributes of the vertices.
    pub attributes: Vec<VertexData>,
    /// For each morph target, its changes of the attributes.
    pub targets: Vec<Vec<VertexData>>,
}

impl Scene {
    /// The triangles of a mesh; `None` if it has none.
    ///
    /// # Errors
    /// There is no such mesh, its data exist only in a compressed form, or it needs more memory than a file of this
    /// size may use.
    pub fn mesh(&self, mesh: usize) -> Result<Option<SceneMesh>, ReadError> {
        Ok(self.read_meshes(&[mesh])?.pop().flatten())
    }

    /// The triangles of several meshes.
    ///
    /// # Errors
    /// As [`Scene::mesh`]; all meshes together need more memory than a file of this size may use.
    pub fn meshes(&self, meshes: &[usize]) -> Result<Vec<Option<SceneMesh>>, ReadError> {
        Ok(self.read_meshes(meshes)?)
    }

    fn read_meshes(&self, meshes: &[usize]) -> Result<Vec<Option<SceneMesh>>, ReadErrorKind> {
        let document = &*self.document;
        check_extensions(&document.root, is_known)?;
        let textures: Vec<_> = document.root.materials.iter().map(base_texture).collect();
        let plans: Vec<(u32, Plan)> = meshes
            .iter()
            .map(|&mesh| {
                // A number beyond the range is none of the meshes.
                let mesh = u32::try_from(mesh).unwrap_or(u32::MAX);
                let notes = &mut Notes::default();
                Ok((mesh, Plan::of_mesh(document, &textures, mesh, notes)?))
            })
            .collect::<Result<_, ReadErrorKind>>()?;
        // The error has the amount for all of them, so that a run with this limit succeeds.
        let (mut needed, mut first_beyond) = (0_u64, None);
        for (mesh, plan) in &plans {
            needed = needed.saturating_add(plan.bytes());
            needed = needed.saturating_add(data_bytes(document, *mesh)?);
            if needed > self.memory {
                first_beyond.get_or_insert(*mesh);
            }
        }
        if let Some(mesh) = first_beyond {
            let at = at(&format!("meshes[{mesh}]"));
            return Err(ReadErrorKind::Memory { at, needed, limit: self.memory });
        }
        plans.iter().map(|(mesh, plan)| self.read_planned(*mesh, plan)).collect()
    }

    fn read_planned(&self, mesh: u32, plan: &Plan) -> Result<Option<SceneMesh>, ReadErrorKind> {
        let document = &*self.document;
        let Some(mesh_plan) = plan.meshes.get(&mesh) else { return Ok(None) };
        if plan.faces == 0 {
            return Ok(None);
        }
        let mut model = read_mesh(document, plan, mesh)?;
        number_materials(&mut model);
        to_unit_range(&mut model);
        crate::whole_numbers::mark_labels(&mut model);
        let mut first = Vec::with_capacity(mesh_plan.sets.len());
        let mut vertices = 0;
        for set in &mesh_plan.sets {
            first.push(vertices);
            vertices += set.count;
        }
        let content = item(&document.root.meshes, mesh, "meshes", "meshes")?;
        let mut primitives = Vec::with_capacity(mesh_plan.parts.len());
        let mut end = 0;
        for part in &mesh_plan.parts {
            let path = path_of(mesh, part.primitive);
            let primitive = item(&content.primitives, as_u32(part.primitive), "primitives", &path)?;
            let count = mesh_plan.sets.get(part.set).map_or(0, |set| set.count);
            let faces = end..end + part.faces;
            end = faces.end;
            let attributes = |attributes: &Attributes| -> Result<Vec<VertexData>, ReadErrorKind> {
                let all = attributes.iter();
                all.map(|(name, accessor)| data(document, primitive, name, accessor, count, &path))
                    .collect()
            };
            primitives.push(ScenePrimitive {
                index: part.primitive,
                faces,
                first_vertex: as_u32(first.get(part.set).copied().unwrap_or(0)),
                vertex_count: count,
                attributes: attributes(&primitive.attributes)?,
                targets: primitive.targets.iter().map(attributes).collect::<Result<_, _>>()?,
            });
        }
        if primitives.len() > 1 {
            let groups = (0..as_u32(primitives.len())).zip(&primitives);
            let of_faces = groups.flat_map(|(group, p)| std::iter::repeat_n(group, p.faces.len()));
            model.face_groups = Some(of_faces.collect());
            let group =
                |p: &ScenePrimitive| Group { name: p.index.to_string(), ..Group::default() };
            model.groups = primitives.iter().map(group).collect();
        } else {
            (model.face_groups, model.groups) = (None, Vec::new());
        }
        Ok(Some(SceneMesh { model, primitives }))
    }
}

/// Numbers the materials in the order of the faces, and adds them without content.
fn number_materials(model: &mut Model) {
    let mut numbers = HashMap::new();
    for material in model.face_materials.iter_mut().flatten().filter(|m| **m != Model::NONE) {
        let next = as_u32(numbers.len());
        *material = *numbers.entry(*material).or_insert(next);
    }
    model.materials = vec![Material::default(); numbers.len()];
}

/// The values of an attribute, as many as there are vertices.
fn data(
    document: &Document,
    primitive: &Primitive,
    name: &str,
    accessor: u32,
    count: usize,
    path: &str,
) -> Result<VertexData, ReadErrorKind> {
    let path = format!("{path}.{name}");
    if document.accessor(accessor, &path)?.shape.is_matrix() {
        return Err(ReadErrorKind::Unsupported {
            at: at(&path),
            what: "an attribute of matrices".to_owned(),
            cure: "export the file without it, or its columns as attributes",
        });
    }
    let values = document.values(accessor, &path, 1..=16)?;
    not_draco(primitive, name, &values, &path)?;
    if values.count() != count {
        let found = values.count().to_string();
        return Err(ReadErrorKind::malformed(at(&path), format!("{count} values"), found));
    }
    Ok(VertexData {
        name: name.to_owned(),
        component: values.component(),
        width: document.width(accessor, &path)?,
        normalized: values.is_normalized(),
        bytes: values.packed()?,
    })
}

/// The memory of the attributes and targets of a mesh.
fn data_bytes(document: &Document, mesh: u32) -> Result<u64, ReadErrorKind> {
    let content = item(&document.root.meshes, mesh, "meshes", "meshes")?;
    let mut bytes = 0_u64;
    for (index, primitive) in content.primitives.iter().enumerate() {
        let path = path_of(mesh, index);
        let targets = primitive.targets.iter().flat_map(Attributes::iter);
        for (name, accessor) in primitive.attributes.iter().chain(targets) {
            // No component is longer than four bytes.
            let value = 4 * document.width(accessor, &path)? as u64;
            let count = document.count(accessor, &path)?;
            bytes = bytes.saturating_add(count.saturating_mul(value));
            bytes = bytes.saturating_add((size_of::<VertexData>() + name.len() + 16) as u64);
        }
    }
    Ok(bytes)
}
