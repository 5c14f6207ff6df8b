//! Reading glTF.

use super::accessor::{Document, at, no_such};
use super::scene::{Instance, instances};
use super::{container, material};
use crate::error::{Location, ReadErrorKind};
use crate::input::Input;
use crate::{Group, Model, Scalars};
use glam::{DMat3, DVec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root, accessor::Accessor};
use std::path::Path;

/// A scene may grow to this many values, and some more per byte of the file, by instancing.
const MOST_VALUES: u64 = 1 << 20;
const MOST_VALUES_PER_BYTE: u64 = 64;

pub(crate) fn read(input: &mut Input<'_>, folder: Option<&Path>) -> Result<Model, ReadErrorKind> {
    let (json, binary) = container::read(input)?;
    let root: Root = gltf::json::deserialize::from_slice(&json).map_err(|error| {
        let at = Location::Line(error.line() as u64);
        ReadErrorKind::malformed(at, "a glTF document", error.to_string())
    })?;
    drop(json);
    check_extensions(&root)?;
    let buffers = container::buffers(&root, binary, folder)?;
    let mut reader = Reader {
        budget: MOST_VALUES + MOST_VALUES_PER_BYTE * input.offset(),
        document: Document { root, buffers },
        model: Model::default(),
    };
    material::read(&reader.document, &mut reader.model);
    for instance in instances(&reader.document.root)? {
        reader.instance(&instance)?;
    }
    Ok(reader.finish())
}

/// Extensions that change nothing but the looks, or that are read here.
fn check_extensions(root: &Root) -> Result<(), ReadErrorKind> {
    let harmless = |name: &str| {
        name.starts_with("KHR_materials_")
            || ["KHR_mesh_quantization", "KHR_texture_transform", "KHR_lights_punctual"]
                .contains(&name)
    };
    match root.extensions_required.iter().position(|name| !harmless(name)) {
        None => Ok(()),
        Some(index) => Err(ReadErrorKind::Unsupported {
            at: at(&format!("extensionsRequired[{index}]")),
            what: format!("the extension {}", root.extensions_required[index]),
            cure: "export the file without it",
        }),
    }
}

struct Reader {
    document: Document,
    model: Model,
    /// How many more vertices and corners may be read.
    budget: u64,
}

/// The accessors of the vertices of a primitive, and where they are in the model.
struct Vertices {
    attributes: Vec<(Checked<Semantic>, usize)>,
    base: u32,
    count: usize,
    normals: Option<Vec<[f32; 3]>>,
    uvs: Option<Vec<[f32; 2]>>,
}

impl Reader {
    fn instance(&mut self, instance: &Instance) -> Result<(), ReadErrorKind> {
        let meshes = &self.document.root.meshes;
        let mesh = meshes.get(instance.mesh).ok_or_else(|| {
            no_such(
                &format!("nodes[{}].mesh", instance.node),
                "meshes",
                instance.mesh,
                meshes.len(),
            )
        })?;
        let primitives = mesh.primitives.clone();
        let node = &self.document.root.nodes[instance.node];
        let name = node.name.as_ref().or(mesh.name.as_ref()).cloned().unwrap_or_default();
        let group = self.model.groups.len() as u32;
        self.model.groups.push(Group { object: name, name: String::new() });
        if node.skin.is_some() || primitives.iter().any(|p| p.targets.is_some()) {
            self.model.notes.push(format!("meshes[{}]: read in its rest pose", instance.mesh));
        }
        // Primitives of one mesh that share their vertices share them in the model too.
        let mut shared: Vec<Vertices> = Vec::new();
        for (index, primitive) in primitives.iter().enumerate() {
            let path = format!("meshes[{}].primitives[{index}]", instance.mesh);
            let triangles = matches!(
                primitive.mode,
                Checked::Valid(Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)
            );
            if !triangles {
                self.model.notes.push(format!("{path}: skipped points or lines"));
                continue;
            }
            let key: Vec<_> =
                primitive.attributes.iter().map(|(k, v)| (k.clone(), v.value())).collect();
            let place = match shared.iter().position(|vertices| vertices.attributes == key) {
                Some(place) => place,
                None => {
                    shared.push(self.vertices(primitive, key, instance, &path)?);
                    shared.len() - 1
                }
            };
            self.faces(primitive, &shared[place], instance, group, &path)?;
        }
        Ok(())
    }

    fn spend(&mut self, values: u64, path: &str) -> Result<(), ReadErrorKind> {
        self.budget = self.budget.checked_sub(values).ok_or_else(|| {
            let expected = "a scene that does not grow out of proportion by instancing";
            ReadErrorKind::malformed(at(path), expected, format!("{values} more values"))
        })?;
        Ok(())
    }

    fn vertices(
        &mut self,
        primitive: &Primitive,
        attributes: Vec<(Checked<Semantic>, usize)>,
        instance: &Instance,
        path: &str,
    ) -> Result<Vertices, ReadErrorKind> {
        let document = &self.document;
        let get = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let position_path = format!("{path}.attributes.POSITION");
        let position = get(Semantic::Positions).ok_or_else(|| {
            ReadErrorKind::malformed(at(&position_path), "an accessor", "nothing")
        })?;
        let count = document.accessor(position, &position_path)?.count.0;
        self.spend(count, path)?;
        let document = &self.document;
        let positions = document.floats::<3>(position, &position_path, 3..=3, 0.0)?;
        let same_count = |index: Index<Accessor>, name: &str| {
            let path = format!("{path}.attributes.{name}");
            let found = document.accessor(index, &path)?.count.0;
            if found == count {
                return Ok(path);
            }
            Err(ReadErrorKind::malformed(at(&path), format!("{count} values"), found.to_string()))
        };
        let mut normals = None;
        if let Some(index) = get(Semantic::Normals) {
            let path = same_count(index, "NORMAL")?;
            let mut values = document.floats::<3>(index, &path, 3..=3, 0.0)?;
            rotate_normals(&mut values, instance);
            normals = Some(values);
        }
        let mut uvs = None;
        if let Some(index) = get(Semantic::TexCoords(0)) {
            let path = same_count(index, "TEXCOORD_0")?;
            let mut values = document.floats::<2>(index, &path, 2..=2, 0.0)?;
            // The origin is at the upper left.
            values.iter_mut().for_each(|uv| uv[1] = 1.0 - uv[1]);
            uvs = Some(values);
        }
        let mut colors = None;
        if let Some(index) = get(Semantic::Colors(0)) {
            let path = same_count(index, "COLOR_0")?;
            colors = Some(document.floats::<4>(index, &path, 3..=4, 1.0)?);
        }
        let mut scalars = Vec::new();
        for (semantic, &index) in &primitive.attributes {
            if let Checked::Valid(Semantic::Extras(name)) = semantic {
                let path = same_count(index, name)?;
                if let Ok(values) = document.floats::<1>(index, &path, 1..=1, 0.0) {
                    let values = values.iter().map(|&[value]| f64::from(value)).collect();
                    scalars.push(Scalars { name: name.to_lowercase(), values });
                }
            }
        }
        let base = self.model.soup.vertex_count();
        self.append_vertices(&positions, instance, colors, scalars);
        let base = u32::try_from(base).map_err(|_| mesh_core::soup::TooManyCorners)?;
        Ok(Vertices { attributes, base, count: positions.len(), normals, uvs })
    }

    fn append_vertices(
        &mut self,
        positions: &[[f32; 3]],
        instance: &Instance,
        colors: Option<Vec<[f32; 4]>>,
        scalars: Vec<Scalars>,
    ) {
        let before = self.model.soup.vertex_count();
        self.model.soup.positions_mut().extend(
            positions
                .iter()
                .map(|p| instance.transform.transform_point3(DVec3::from(p.map(f64::from)))),
        );
        let after = self.model.soup.vertex_count();
        extend_padded(&mut self.model.vertex_colors, colors, before, after, [1.0; 4]);
        for Scalars { name, values } in scalars {
            if !self.model.vertex_scalars.iter().any(|s| s.name == name) {
                self.model.vertex_scalars.push(Scalars { name: name.clone(), values: vec![] });
            }
            if let Some(s) = self.model.vertex_scalars.iter_mut().find(|s| s.name == name) {
                s.values.resize(before, f64::NAN);
                s.values.extend(values);
            }
        }
        for s in &mut self.model.vertex_scalars {
            s.values.resize(after, f64::NAN);
        }
    }

    fn faces(
        &mut self,
        primitive: &Primitive,
        vertices: &Vertices,
        instance: &Instance,
        group: u32,
        path: &str,
    ) -> Result<(), ReadErrorKind> {
        let path = format!("{path}.indices");
        let indices = match primitive.indices {
            Some(index) => {
                self.spend(self.document.accessor(index, &path)?.count.0, &path)?;
                self.document.indices(index, &path)?
            }
            None => (0..vertices.count as u32).collect(),
        };
        if let Some(&index) = indices.iter().find(|&&index| index as usize >= vertices.count) {
            return Err(no_such(&path, "vertices", index as usize, vertices.count));
        }
        if let Some(material) = primitive.material
            && material.value() >= self.model.materials.len()
        {
            let count = self.model.materials.len();
            return Err(no_such(
                &path.replace("indices", "material"),
                "materials",
                material.value(),
                count,
            ));
        }
        let mirrored = DMat3::from_mat4(instance.transform).determinant() < 0.0;
        let first_face = self.model.soup.face_count();
        let first_corner = self.model.soup.corners().len();
        let mut corners = Vec::with_capacity(indices.len());
        let mut push = |mut triangle: [u32; 3]| {
            if mirrored {
                triangle.swap(1, 2);
            }
            corners.extend_from_slice(&triangle);
            self.model.soup.push_face(&triangle.map(|index| vertices.base + index))
        };
        match primitive.mode {
            Checked::Valid(Mode::TriangleStrip) => {
                for (place, &[a, b, c]) in indices.array_windows::<3>().enumerate() {
                    push(if place % 2 == 0 { [a, b, c] } else { [b, a, c] })?;
                }
            }
            Checked::Valid(Mode::TriangleFan) => {
                for pair in indices.get(1..).unwrap_or_default().array_windows::<2>() {
                    push([indices[0], pair[0], pair[1]])?;
                }
            }
            _ => indices.as_chunks::<3>().0.iter().try_for_each(|&triangle| push(triangle))?,
        }
        let last_corner = self.model.soup.corners().len();
        let pick = |index: &u32| *index as usize;
        let uvs = vertices.uvs.as_ref().map(|uvs| corners.iter().map(|c| uvs[pick(c)]).collect());
        extend_padded(&mut self.model.corner_uvs, uvs, first_corner, last_corner, [f32::NAN; 2]);
        let normals =
            vertices.normals.as_ref().map(|all| corners.iter().map(|c| all[pick(c)]).collect());
        extend_padded(
            &mut self.model.corner_normals,
            normals,
            first_corner,
            last_corner,
            [f32::NAN; 3],
        );
        let last_face = self.model.soup.face_count();
        let material = primitive.material.map(|m| vec![m.value() as u32; last_face - first_face]);
        extend_padded(&mut self.model.face_materials, material, first_face, last_face, Model::NONE);
        self.model.face_groups.get_or_insert_default().resize(last_face, group);
        Ok(())
    }

    fn finish(mut self) -> Model {
        let named = |group: &Group| !group.object.is_empty();
        if self.model.groups.len() <= 1 && !self.model.groups.iter().any(named) {
            self.model.groups.clear();
            self.model.face_groups = None;
        }
        if !self.document.root.animations.is_empty() {
            self.model.notes.push("ignored the animations".to_owned());
        }
        self.model
    }
}

/// Normals follow the inverse transpose of the transform: the matrix of its cofactors does, and
/// exists for singular ones too.
fn rotate_normals(normals: &mut [[f32; 3]], instance: &Instance) {
    let m = DMat3::from_mat4(instance.transform);
    if m == DMat3::IDENTITY {
        return;
    }
    let cofactors = DMat3::from_cols(
        m.y_axis.cross(m.z_axis),
        m.z_axis.cross(m.x_axis),
        m.x_axis.cross(m.y_axis),
    ) * m.determinant().signum();
    for normal in normals {
        let turned = cofactors * DVec3::from(normal.map(f64::from));
        *normal = turned.normalize_or_zero().as_vec3().to_array();
    }
}

/// Appends values for the entries from `before` to `after`; where there are none, `fill` stands
/// for them once any part of the model has some.
fn extend_padded<T: Copy>(
    all: &mut Option<Vec<T>>,
    values: Option<Vec<T>>,
    before: usize,
    after: usize,
    fill: T,
) {
    if let Some(values) = values {
        let all = all.get_or_insert_default();
        all.resize(before, fill);
        all.extend(values);
    }
    if let Some(all) = all {
        all.resize(after, fill);
    }
}
