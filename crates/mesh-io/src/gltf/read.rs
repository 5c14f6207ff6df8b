//! Reading glTF.

use super::accessor::{Bytes, Document, at, no_such};
use super::compressed;
use super::container::{self, Container};
use super::plan::{FAN, MeshPlan, Part, Plan, STRIP, UNDRACO, VertexSet, path_of};
use super::scene::{Placed, each_placed, transforms};
use super::schema::{LARGEST, Mesh, Node, Primitive, Root, TextureTransform};
use super::{lost, material};
use crate::budget::GROWING;
use crate::error::{Location, ReadErrorKind};
use crate::external::Files;
use crate::input::Input;
use crate::notes::Notes;
use crate::text::quote;
use crate::{Group, Model};
use glam::{DMat3, DMat4, DVec3};
use mesh_core::soup::TooManyCorners;
use mesh_core::{PolygonSoup, as_u32};

pub(crate) fn read(input: &mut Input<'_>, files: &Files<'_>) -> Result<Model, ReadErrorKind> {
    let mut notes = Notes::default();
    let document = load(input, files, &mut notes)?;
    read_document(&document, notes, input)
}

/// The document and the bytes of its buffers.
pub(super) fn load(
    input: &mut Input<'_>,
    files: &Files<'_>,
    notes: &mut Notes,
) -> Result<Document, ReadErrorKind> {
    let container = container::read(input)?;
    container.note(notes);
    let Container { json, binary, .. } = container;
    input.spend(document_bytes(&json), || at("the document"))?;
    let root = parse(&json)?;
    drop(json);
    check_extensions(&root, is_harmless)?;
    let buffers = container::buffers(&root, binary, files, input)?;
    unpacked(root, buffers, input)
}

/// The document with its compressed accessors unpacked.
fn unpacked(
    root: Root,
    buffers: Vec<Bytes>,
    input: &mut Input<'_>,
) -> Result<Document, ReadErrorKind> {
    #[cfg_attr(not(feature = "draco"), expect(unused_mut, reason = "only that feature changes it"))]
    let mut document = Document { root, buffers };
    compressed::spend(&document.root, &document.buffers, input)?;
    #[cfg(feature = "draco")]
    super::draco::fill(&mut document, Some(input))?;
    Ok(document)
}

/// The memory of the document of a JSON text. Its lists grow, and its strings are copied from the text.
pub(crate) fn document_bytes(json: &[u8]) -> u64 {
    let braces = json.iter().filter(|&&byte| byte == b'{').count() as u64;
    json.len() as u64 + GROWING * LARGEST * braces
}

/// The document in a JSON text.
pub(crate) fn parse(json: &[u8]) -> Result<Root, ReadErrorKind> {
    serde_json::from_slice(json).map_err(|error| {
        let at = Location::Line(error.line() as u64);
        ReadErrorKind::malformed(at, "a glTF document", error.to_string())
    })
}

/// The model of a document with the bytes of its buffers.
#[cfg(feature = "gltf-crate")]
pub(super) fn read_root(
    root: Root,
    buffers: Vec<Bytes>,
    notes: Notes,
    input: &mut Input<'_>,
) -> Result<Model, ReadErrorKind> {
    check_extensions(&root, is_harmless)?;
    let document = unpacked(root, buffers, input)?;
    read_document(&document, notes, input)
}

fn read_document(
    document: &Document,
    mut notes: Notes,
    input: &mut Input<'_>,
) -> Result<Model, ReadErrorKind> {
    let mut model = Model::default();
    let textures = material::read(document, &mut model, &mut notes, input)?;
    let plan = Plan::of(document, &textures, &mut notes)?;
    input.spend(plan.bytes(), || at("the scene"))?;
    lost::note(&document.root, &mut notes);
    let mut reader = Reader::new(document, &plan, model)?;
    each_placed(&document.root, |placed| reader.place(placed))?;
    let mut model = reader.finish();
    notes.store(&mut model);
    Ok(model)
}

/// The triangles of one mesh, in its own coordinates, with indices of materials that the model does not have; the plan
/// is of this mesh.
pub(crate) fn read_mesh(
    document: &Document,
    plan: &Plan,
    mesh: u32,
) -> Result<Model, ReadErrorKind> {
    let mut reader = Reader::new(document, plan, Model::default())?;
    reader.place(&Placed { index: 0, node: &Node::default(), mesh, transform: DMat4::IDENTITY })?;
    Ok(reader.finish())
}

const DRACO: &str = "KHR_draco_mesh_compression";

/// Whether an extension affects only the appearance, or is read here.
fn is_harmless(name: &str) -> bool {
    const HARMLESS: [&str; 8] = [
        "KHR_mesh_quantization",
        "KHR_texture_transform",
        "KHR_lights_punctual",
        "EXT_mesh_gpu_instancing",
        "EXT_texture_webp",
        "KHR_texture_basisu",
        "EXT_meshopt_compression",
        "KHR_meshopt_compression",
    ];
    name.starts_with("KHR_materials_") || HARMLESS.contains(&name)
}

/// Rejects a document that requires an extension that is not allowed.
pub(crate) fn check_extensions(
    root: &Root,
    is_allowed: impl Fn(&str) -> bool,
) -> Result<(), ReadErrorKind> {
    let required = root.extensions_required.iter().enumerate();
    let is_read =
        |name: &str| if name == DRACO { cfg!(feature = "draco") } else { is_allowed(name) };
    match required.into_iter().find(|(_, name)| !is_read(name)) {
        None => Ok(()),
        Some((index, name)) => Err(ReadErrorKind::Unsupported {
            at: at(&format!("extensionsRequired[{index}]")),
            what: format!("the extension {}", quote(name.as_bytes())),
            cure: if name.as_ref() == DRACO { UNDRACO } else { "export the file without it" },
        }),
    }
}

/// Fills the model, whose size the plan has determined.
struct Reader<'d> {
    document: &'d Document,
    plan: &'d Plan,
    model: Model,
    /// Allocated in full size; filled up to `vertex`.
    positions: Vec<DVec3>,
    vertex: usize,
}

impl<'d> Reader<'d> {
    fn new(
        document: &'d Document,
        plan: &'d Plan,
        mut model: Model,
    ) -> Result<Self, ReadErrorKind> {
        let too_many = |_| TooManyCorners;
        let vertices = u32::try_from(plan.vertices).map_err(too_many)? as usize;
        let faces = u32::try_from(plan.faces.saturating_mul(3)).map_err(too_many)? as usize / 3;
        let corners = 3 * faces;
        model.soup = PolygonSoup::with_capacity(0, faces, corners);
        model.vertex_colors = plan.has_colors.then(|| vec![[1.0; 4]; vertices]);
        model.vertex_scalars = plan.columns(vertices);
        let (of_points, of_corners) =
            (plan.has_normals && plan.has_points, plan.has_normals && !plan.has_points);
        model.vertex_normals = of_points.then(|| Vec::with_capacity(vertices));
        model.corner_normals = of_corners.then(|| Vec::with_capacity(corners));
        model.corner_uvs = plan.has_uvs.then(|| Vec::with_capacity(corners));
        let set = || Vec::with_capacity(corners);
        model.more_corner_uvs = std::iter::repeat_with(set).take(plan.more_uvs).collect();
        model.face_materials = plan.has_materials.then(|| Vec::with_capacity(faces));
        model.face_groups = (vertices > 0).then(|| Vec::with_capacity(faces));
        Ok(Self { document, plan, model, positions: vec![DVec3::ZERO; vertices], vertex: 0 })
    }

    fn place(&mut self, placed: &Placed<'_>) -> Result<(), ReadErrorKind> {
        let mesh = self.document.root.meshes.get(placed.mesh as usize);
        let (Some(mesh), Some(mesh_plan)) = (mesh, self.plan.meshes.get(&placed.mesh)) else {
            return Ok(());
        };
        if mesh_plan.sets.is_empty() {
            return Ok(());
        }
        let transforms = transforms(self.document, placed)?;
        if transforms.is_empty() {
            return Ok(());
        }
        let name = placed.node.name.as_ref().or(mesh.name.as_ref());
        let object = name.map(ToString::to_string).unwrap_or_default();
        self.model.groups.push(Group { object, name: String::new() });
        let document = self.document;
        let uvs: Result<Vec<_>, ReadErrorKind> = mesh_plan
            .uvs
            .iter()
            .map(|&uvs| document.values(uvs, "TEXCOORD", 2..=2)?.to_vec::<2>(0.0))
            .collect();
        let uvs = uvs?;
        let instance = Instance { placed, mesh, plan: mesh_plan, uvs: &uvs };
        transforms.iter().try_for_each(|transform| self.instance(&instance, transform))
    }

    fn instance(
        &mut self,
        instance: &Instance<'_>,
        transform: &DMat4,
    ) -> Result<(), ReadErrorKind> {
        let Instance { placed, plan, .. } = instance;
        let mut bases = Vec::with_capacity(plan.sets.len());
        let mut normals = Vec::with_capacity(plan.sets.len());
        for set in &plan.sets {
            let path = path_of(placed.mesh, set.primitive);
            bases.push(as_u32(self.vertex));
            let own = self.vertices(set, transform, &path)?;
            if let Some(all) = &mut self.model.vertex_normals {
                match &own {
                    Some(own) => all.extend_from_slice(own),
                    None => all.extend(std::iter::repeat_n([0.0; 3], set.count)),
                }
            }
            normals.push(own);
        }
        for part in &plan.parts {
            let path = path_of(placed.mesh, part.primitive);
            let normals = normals.get(part.set).and_then(Option::as_deref);
            let base = bases.get(part.set).copied().unwrap_or_default();
            self.faces(instance, part, transform, base, normals, &path)?;
        }
        Ok(())
    }

    /// Reads the vertices of a primitive, and returns their normals.
    fn vertices(
        &mut self,
        set: &VertexSet,
        transform: &DMat4,
        path: &str,
    ) -> Result<Option<Vec<[f32; 3]>>, ReadErrorKind> {
        let document = self.document;
        let range = self.vertex..self.vertex + set.count;
        self.vertex = range.end;
        let positions = self.positions.get_mut(range.clone()).unwrap_or_default();
        document.values(set.positions, path, 3..=3)?.each(0.0, |index, p: [f32; 3]| {
            if let Some(position) = positions.get_mut(index) {
                *position = transform.transform_point3(DVec3::from(p.map(f64::from)));
            }
        })?;
        if let (Some(accessor), Some(colors)) = (set.colors, &mut self.model.vertex_colors) {
            let colors = colors.get_mut(range.clone()).unwrap_or_default();
            let values = document.values(accessor, path, 3..=4)?;
            let full = values.full_color()?;
            values.each(full, |index, color: [f32; 4]| {
                if let Some(slot) = colors.get_mut(index) {
                    *slot = color.map(|channel| channel / full);
                }
            })?;
        }
        for scalars in &set.scalars {
            let Some(column) = self.model.vertex_scalars.get_mut(scalars.name as usize) else {
                continue;
            };
            document.values(scalars.accessor, path, 1..=1)?.each_number(|index, value| {
                // The column holds every number of its accessors.
                let _ = column.values.set(range.start + index, value, None);
            })?;
        }
        let Some(accessor) = set.normals else { return Ok(None) };
        let mut normals = document.values(accessor, path, 3..=3)?.to_vec(0.0)?;
        rotate_normals(&mut normals, transform);
        Ok(Some(normals))
    }

    fn faces(
        &mut self,
        instance: &Instance<'_>,
        part: &Part,
        transform: &DMat4,
        base: u32,
        normals: Option<&[[f32; 3]]>,
        path: &str,
    ) -> Result<(), ReadErrorKind> {
        let Some(primitive) = instance.mesh.primitives.get(part.primitive) else { return Ok(()) };
        let count = instance.plan.sets.get(part.set).map_or(0, |set| set.count);
        let indices = vertex_indices(self.document, primitive, count, path)?;
        let uvs = part.uvs.as_ref().and_then(|(place, transform)| {
            Some((instance.uvs.get(*place)?.as_slice(), UvTransform::new(transform)))
        });
        let more_uvs: Vec<Option<&[[f32; 2]]>> = (0..self.plan.more_uvs)
            .map(|set| Some(instance.uvs.get(*part.more_uvs.get(set)?)?.as_slice()))
            .collect();
        let as_it_is = UvTransform::new(&TextureTransform::default());
        let mirrored = DMat3::from_mat4(*transform).determinant() < 0.0;
        let group = as_u32(self.model.groups.len()).wrapping_sub(1);
        let material = primitive.material.unwrap_or(Model::NONE);
        let Model {
            soup,
            corner_uvs,
            more_corner_uvs,
            corner_normals,
            face_groups,
            face_materials,
            ..
        } = &mut self.model;
        each_triangle(primitive.mode, &indices, |mut triangle| {
            if mirrored {
                triangle.swap(1, 2);
            }
            soup.push_face(&triangle.map(|index| base + index))?;
            if let Some(all) = corner_uvs {
                all.extend(triangle.map(|vertex| match &uvs {
                    Some((uvs, transform)) => transform.apply(uvs[vertex as usize]),
                    None => [f32::NAN; 2],
                }));
            }
            for (all, uvs) in more_corner_uvs.iter_mut().zip(&more_uvs) {
                all.extend(triangle.map(|vertex| match uvs {
                    Some(uvs) => as_it_is.apply(uvs[vertex as usize]),
                    None => [f32::NAN; 2],
                }));
            }
            if let Some(all) = corner_normals {
                all.extend(triangle.map(|vertex| match normals {
                    Some(normals) => normals[vertex as usize],
                    None => [f32::NAN; 3],
                }));
            }
            if let Some(all) = face_groups {
                all.push(group);
            }
            if let Some(all) = face_materials {
                all.push(material);
            }
            Ok(())
        })
    }

    fn finish(mut self) -> Model {
        *self.model.soup.positions_mut() = self.positions;
        let named = |group: &Group| !group.object.is_empty();
        if self.model.groups.len() <= 1 && !self.model.groups.iter().any(named) {
            self.model.groups.clear();
            self.model.face_groups = None;
        }
        self.model
    }
}

/// The vertices of a primitive, in the order in which its triangles use them.
pub(super) fn vertex_indices(
    document: &Document,
    primitive: &Primitive,
    count: usize,
    path: &str,
) -> Result<Vec<u32>, ReadErrorKind> {
    let path = format!("{path}.indices");
    let indices = match primitive.indices {
        Some(index) => document.indices(index, &path)?,
        None => (0..as_u32(count)).collect(),
    };
    match indices.iter().find(|&&index| index as usize >= count) {
        Some(&index) => Err(no_such(&path, "vertices", index, count)),
        None => Ok(indices),
    }
}

/// The triangles of a primitive: a list, a strip or a fan.
pub(super) fn each_triangle(
    mode: u32,
    indices: &[u32],
    mut put: impl FnMut([u32; 3]) -> Result<(), ReadErrorKind>,
) -> Result<(), ReadErrorKind> {
    match mode {
        STRIP => {
            for (place, &[a, b, c]) in indices.array_windows::<3>().enumerate() {
                put(if place % 2 == 0 { [a, b, c] } else { [b, a, c] })?;
            }
        }
        FAN => {
            for pair in indices.get(1..).unwrap_or_default().array_windows::<2>() {
                put([indices[0], pair[0], pair[1]])?;
            }
        }
        _ => indices.as_chunks::<3>().0.iter().try_for_each(|&triangle| put(triangle))?,
    }
    Ok(())
}

/// A mesh with the transform of a node.
struct Instance<'d> {
    placed: &'d Placed<'d>,
    mesh: &'d Mesh,
    plan: &'d MeshPlan,
    /// The texture coordinates of the mesh.
    uvs: &'d [Vec<[f32; 2]>],
}

/// The map of texture coordinates of the file to an origin at the lower left.
struct UvTransform {
    u: [f32; 3],
    v: [f32; 3],
}

impl UvTransform {
    /// Scales, rotates counter-clockwise in the picture, and translates, as in the extension `KHR_texture_transform`;
    /// its example shows the direction of rotation.
    fn new(transform: &TextureTransform) -> Self {
        let TextureTransform { offset, rotation, scale, .. } = *transform;
        let (sin, cos) = rotation.sin_cos();
        Self {
            u: [cos * scale[0], sin * scale[1], offset[0]],
            v: [-sin * scale[0], cos * scale[1], offset[1]],
        }
    }

    fn apply(&self, [u, v]: [f32; 2]) -> [f32; 2] {
        let of = |[a, b, c]: [f32; 3]| a * u + b * v + c;
        // In the file, the origin is at the upper left.
        [of(self.u), 1.0 - of(self.v)]
    }
}

/// Normals transform with the inverse transpose. The matrix of cofactors is used instead, because it also exists for
/// singular transforms.
fn rotate_normals(normals: &mut [[f32; 3]], transform: &DMat4) {
    let m = DMat3::from_mat4(*transform);
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
