//! The content and memory need of a scene, before any of it is read.

use super::accessor::{Document, Values, at, item, no_such};
use super::scene::{INSTANCE, Placed, each_placed, instance_count};
use super::schema::{Attributes, Mesh, Node, Primitive, Root, TextureInfo, TextureTransform};
use crate::Group;
use crate::error::ReadErrorKind;
use crate::lost::Lost;
use crate::notes::Notes;
use crate::numbering::Numbering;
use crate::scalars::{ScalarType, ScalarValues, Scalars};
use glam::DMat4;
use std::collections::HashMap;
use std::collections::btree_map::{BTreeMap, Entry};

/// The meshes of a scene, and the size of the resulting model.
pub(crate) struct Plan {
    /// The meshes that are drawn, by index.
    pub meshes: BTreeMap<u32, MeshPlan>,
    /// The names of the named numbers of vertices.
    pub scalars: Numbering,
    pub vertices: u64,
    pub faces: u64,
    pub has_colors: bool,
    pub has_normals: bool,
    pub has_uvs: bool,
    /// The number of sets of texture coordinates, without the first.
    pub more_uvs: usize,
    pub has_materials: bool,
    /// The bytes of the groups; `passing` are bytes that are needed only temporarily.
    groups: u64,
    passing: u64,
    /// Whether points are vertices without faces.
    pub has_points: bool,
}

/// The parts of a mesh that are read.
#[derive(Default)]
pub(crate) struct MeshPlan {
    /// Primitives that have the same attributes share their vertices.
    pub sets: Vec<VertexSet>,
    pub parts: Vec<Part>,
    /// The accessors of the texture coordinates.
    pub uvs: Vec<u32>,
    vertices: u64,
    faces: u64,
    passing: u64,
    has_colors: bool,
    has_normals: bool,
    has_materials: bool,
}

/// Vertices, given by the accessors of their attributes.
pub(crate) struct VertexSet {
    /// A primitive that uses them.
    pub primitive: usize,
    pub count: usize,
    pub positions: u32,
    pub normals: Option<u32>,
    pub colors: Option<u32>,
    /// The columns of named numbers.
    pub scalars: Vec<NamedAccessor>,
}

/// The accessor of a column of named numbers.
pub(crate) struct NamedAccessor {
    /// The number of the name.
    pub name: u32,
    pub accessor: u32,
    pub kind: ScalarType,
}

/// The triangles of a primitive.
pub(crate) struct Part {
    pub primitive: usize,
    pub set: usize,
    pub faces: usize,
    /// The index of the texture coordinates of the mesh, and their transform.
    pub uvs: Option<(usize, TextureTransform)>,
    /// The indices of the texture coordinates for the further sets.
    pub more_uvs: Vec<usize>,
}

pub(crate) const STRIP: u32 = 5;
pub(crate) const FAN: u32 = 6;

pub(crate) const POINTS: u32 = 0;

/// Whether points are read as vertices without faces: if a document has no faces.
pub(crate) fn has_points(root: &Root) -> bool {
    let mut primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    !primitives.any(|primitive| is_surface(primitive.mode))
}

/// Whether primitives of this mode are triangles, not points or lines.
pub(crate) fn is_surface(mode: u32) -> bool {
    (4..=FAN).contains(&mode)
}

/// The path of a primitive in the document.
pub(crate) fn path_of(mesh: u32, primitive: usize) -> String {
    format!("meshes[{mesh}].primitives[{primitive}]")
}

impl Plan {
    /// Examines everything that the scene draws. Points are vertices without faces, if the document has no faces.
    /// `textures` is, for every material, the texture that its texture coordinates belong to.
    pub(crate) fn of(
        document: &Document,
        textures: &[Option<TextureInfo>],
        notes: &mut Notes,
    ) -> Result<Self, ReadErrorKind> {
        let mut plan = Self::empty();
        plan.has_points = has_points(&document.root);
        each_placed(&document.root, |placed| plan.place(document, placed, textures, notes))?;
        Ok(plan)
    }

    /// Examines one mesh, drawn once.
    pub(crate) fn of_mesh(
        document: &Document,
        textures: &[Option<TextureInfo>],
        mesh: u32,
        notes: &mut Notes,
    ) -> Result<Self, ReadErrorKind> {
        let mut plan = Self::empty();
        let node = Node::default();
        let placed = Placed { index: 0, node: &node, mesh, transform: DMat4::IDENTITY };
        plan.place(document, &placed, textures, notes)?;
        Ok(plan)
    }

    fn empty() -> Self {
        Self {
            meshes: BTreeMap::new(),
            scalars: Numbering::default(),
            vertices: 0,
            faces: 0,
            has_colors: false,
            has_normals: false,
            has_uvs: false,
            more_uvs: 0,
            has_materials: false,
            groups: 0,
            passing: 0,
            has_points: false,
        }
    }

    /// The bytes of the model, and of the reader in addition.
    pub(crate) fn bytes(&self) -> u64 {
        let of = |there: bool, bytes: u64| if there { bytes } else { 0 };
        let scalars = 8 * self.scalars.names().len() as u64;
        let vertex = 24 + of(self.has_colors, 16) + scalars;
        let corner = 4 + of(self.has_uvs, 8) + 8 * self.more_uvs as u64 + of(self.has_normals, 12);
        let face = 3 * corner + 4 + 4 + of(self.has_materials, 4);
        let model =
            self.vertices.saturating_mul(vertex).saturating_add(self.faces.saturating_mul(face));
        model.saturating_add(self.groups).saturating_add(self.passing)
    }

    /// Columns for the named numbers of all vertices, in a type that holds the numbers of every mesh. Vertices without
    /// a number get NaN, which needs floating point.
    pub(crate) fn columns(&self, vertices: usize) -> Vec<Scalars> {
        let mut kinds = vec![Kinds::default(); self.scalars.names().len()];
        let mut sets = 0;
        for set in self.meshes.values().flat_map(|mesh| &mesh.sets) {
            sets += 1;
            for scalars in &set.scalars {
                if let Some(kinds) = kinds.get_mut(scalars.name as usize) {
                    kinds.add(scalars.kind, sets);
                }
            }
        }
        let column = |(name, kinds): (&String, Kinds)| {
            let first = kinds.first.unwrap_or(ScalarType::F32);
            let integers = first.is_integer() && !kinds.has_fractions;
            let values = match (kinds.sets == sets, kinds.has_others, integers) {
                (true, false, _) => ScalarValues::zeros(first, vertices),
                (true, true, true) => ScalarValues::zeros(ScalarType::I64, vertices),
                _ => vec![f64::NAN; vertices].into(),
            };
            Scalars { is_label: integers, ..Scalars::new(name, values) }
        };
        self.scalars.names().iter().zip(kinds).map(column).collect()
    }

    fn place(
        &mut self,
        document: &Document,
        placed: &Placed<'_>,
        textures: &[Option<TextureInfo>],
        notes: &mut Notes,
    ) -> Result<(), ReadErrorKind> {
        let path = format!("nodes[{}].mesh", placed.index);
        let mesh = item(&document.root.meshes, placed.mesh, "meshes", &path)?;
        let mesh_plan = match self.meshes.entry(placed.mesh) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(slot) => {
                let mut planner = Planner {
                    document,
                    textures,
                    notes,
                    scalars: &mut self.scalars,
                    mesh: placed.mesh,
                    has_points: self.has_points,
                };
                slot.insert(planner.mesh(mesh)?)
            }
        };
        let times = instance_count(document, placed)?;
        if mesh_plan.sets.is_empty() || times == 0 {
            return Ok(());
        }
        self.vertices = self.vertices.saturating_add(mesh_plan.vertices.saturating_mul(times));
        self.faces = self.faces.saturating_add(mesh_plan.faces.saturating_mul(times));
        self.has_colors |= mesh_plan.has_colors;
        self.has_normals |= mesh_plan.has_normals;
        for part in &mesh_plan.parts {
            self.has_uvs |= part.uvs.is_some();
            self.more_uvs = self.more_uvs.max(part.more_uvs.len());
        }
        self.has_materials |= mesh_plan.has_materials;
        let name = placed.node.name.as_ref().or(mesh.name.as_ref()).map_or(0, |name| name.len());
        self.groups = self.groups.saturating_add((size_of::<Group>() + name + 16) as u64 * 2);
        let passing = mesh_plan.passing.saturating_add(times.saturating_mul(INSTANCE));
        self.passing = self.passing.max(passing);
        Ok(())
    }
}

/// The types of the named numbers of one name.
#[derive(Clone, Copy, Default)]
struct Kinds {
    /// The type in the first vertex set that has them.
    first: Option<ScalarType>,
    has_others: bool,
    has_fractions: bool,
    /// The number of vertex sets that have them.
    sets: usize,
    /// The last vertex set that has them.
    last: usize,
}

impl Kinds {
    /// Adds the numbers of a set. Only the first of several columns with one name counts.
    fn add(&mut self, kind: ScalarType, set: usize) {
        if self.last == set {
            return;
        }
        self.last = set;
        self.sets += 1;
        self.has_others |= *self.first.get_or_insert(kind) != kind;
        self.has_fractions |= !kind.is_integer();
    }
}

struct Planner<'p> {
    document: &'p Document,
    textures: &'p [Option<TextureInfo>],
    notes: &'p mut Notes,
    scalars: &'p mut Numbering,
    mesh: u32,
    /// Whether points are vertices without faces.
    has_points: bool,
}

impl Planner<'_> {
    fn mesh(&mut self, mesh: &Mesh) -> Result<MeshPlan, ReadErrorKind> {
        let mut plan = MeshPlan::default();
        let mut sets: HashMap<&Attributes, usize> = HashMap::new();
        let mut uvs: HashMap<u32, usize> = HashMap::new();
        let mut most_indices = 0;
        for (index, primitive) in mesh.primitives.iter().enumerate() {
            let path = path_of(self.mesh, index);
            let is_points = self.has_points && primitive.mode == POINTS;
            if !is_surface(primitive.mode) && !is_points {
                let why = "a model holds faces only";
                self.notes.lose(Lost::new(format!("{path}: points or lines"), why));
                continue;
            }
            let set = match sets.get(&primitive.attributes) {
                Some(&set) => set,
                None => {
                    let set = self.vertices(index, primitive, &path)?;
                    let normals = if set.normals.is_some() { 12 } else { 0 };
                    plan.vertices = plan.vertices.saturating_add(set.count as u64);
                    plan.passing =
                        plan.passing.saturating_add((set.count as u64).saturating_mul(normals));
                    plan.has_colors |= set.colors.is_some();
                    plan.has_normals |= set.normals.is_some();
                    plan.sets.push(set);
                    sets.insert(&primitive.attributes, plan.sets.len() - 1);
                    plan.sets.len() - 1
                }
            };
            if is_points {
                continue;
            }
            let count = plan.sets[set].count as u64;
            let indices = self.indices(primitive, count, &path)?;
            let faces = match primitive.mode {
                STRIP | FAN => indices.saturating_sub(2),
                _ => indices / 3,
            };
            let rest = match (primitive.mode, faces) {
                (STRIP | FAN, 1..) => 0,
                (_, faces) => indices - 3 * faces,
            };
            let what = format!("{path}: corners after the last triangle");
            self.notes.lose_some(what, rest, "a triangle needs three");
            if faces == 0 {
                continue;
            }
            let own_uvs = self.uvs(primitive, count, &path)?;
            let mut place_of = |accessor| {
                *uvs.entry(accessor).or_insert_with(|| {
                    plan.passing = plan.passing.saturating_add(count.saturating_mul(8));
                    plan.uvs.push(accessor);
                    plan.uvs.len() - 1
                })
            };
            let more_uvs =
                self.more_uvs(primitive, own_uvs.map(|(accessor, _)| accessor), count, &path)?;
            let more_uvs = more_uvs.into_iter().map(&mut place_of).collect();
            let uvs = own_uvs.map(|(accessor, transform)| (place_of(accessor), transform));
            plan.has_materials |= primitive.material.is_some();
            plan.faces = plan.faces.saturating_add(faces);
            most_indices = most_indices.max(indices);
            let faces = faces as usize;
            plan.parts.push(Part { primitive: index, set, faces, uvs, more_uvs });
        }
        plan.sets.shrink_to_fit();
        plan.parts.shrink_to_fit();
        plan.passing = plan.passing.saturating_add(most_indices.saturating_mul(4));
        // A mesh without vertices needs no work for its nodes.
        if plan.vertices == 0 {
            plan = MeshPlan::default();
        }
        Ok(plan)
    }

    /// Checks the accessor of an attribute: its values exist, have a suitable width, and match the number of positions.
    /// Returns their number, and whether any buffer defines them.
    fn attribute(
        &self,
        primitive: &Primitive,
        accessor: u32,
        name: &str,
        widths: std::ops::RangeInclusive<usize>,
        count: Option<usize>,
        path: &str,
    ) -> Result<(usize, bool), ReadErrorKind> {
        let path = format!("{path}.attributes.{name}");
        let values = self.document.values(accessor, &path, widths)?;
        not_draco(primitive, name, &values, &path)?;
        match count {
            Some(count) if values.count() != count => {
                let found = values.count().to_string();
                Err(ReadErrorKind::malformed(at(&path), format!("{count} values"), found))
            }
            _ => Ok((values.count(), !values.is_nothing())),
        }
    }

    fn vertices(
        &mut self,
        index: usize,
        primitive: &Primitive,
        path: &str,
    ) -> Result<VertexSet, ReadErrorKind> {
        let attributes = &primitive.attributes;
        let positions = attributes.get("POSITION").ok_or_else(|| {
            let path = format!("{path}.attributes.POSITION");
            ReadErrorKind::malformed(at(&path), "an accessor", "nothing")
        })?;
        let (count, is_given) =
            self.attribute(primitive, positions, "POSITION", 3..=3, None, path)?;
        if !is_given && count > 0 {
            self.notes.add(format!("{path}: no buffer gives the positions, so that all are zero"));
        }
        let all = Some(count);
        let normals = attributes.get("NORMAL");
        if let Some(accessor) = normals {
            self.attribute(primitive, accessor, "NORMAL", 3..=3, all, path)?;
        }
        let colors = attributes.get("COLOR_0");
        if let Some(accessor) = colors {
            self.attribute(primitive, accessor, "COLOR_0", 3..=4, all, path)?;
            if self.document.values(accessor, path, 3..=4)?.is_whole() {
                let note = "COLOR_0 holds whole numbers that are not marked as normalized: divided";
                self.notes.add(format!("{path}.attributes.{note}"));
            }
        }
        let mut scalars = Vec::new();
        for (name, accessor) in attributes.iter() {
            let Some(own_name) = name.strip_prefix('_') else { continue };
            self.attribute(primitive, accessor, name, 1..=16, all, path)?;
            if self.document.width(accessor, path)? == 1 {
                let kind = self.document.values(accessor, path, 1..=1)?.scalar_type();
                let name = self.scalars.number(&own_name.to_lowercase()).0;
                scalars.push(NamedAccessor { name, accessor, kind });
            }
        }
        scalars.shrink_to_fit();
        Ok(VertexSet { primitive: index, count, positions, normals, colors, scalars })
    }

    /// The number of indices of a primitive: the count of its accessor, or one per vertex.
    fn indices(
        &self,
        primitive: &Primitive,
        vertices: u64,
        path: &str,
    ) -> Result<u64, ReadErrorKind> {
        if let Some(material) = primitive.material
            && material as usize >= self.textures.len()
        {
            let path = format!("{path}.material");
            return Err(no_such(&path, "materials", material, self.textures.len()));
        }
        let Some(accessor) = primitive.indices else { return Ok(vertices) };
        let path = format!("{path}.indices");
        let values = self.document.values(accessor, &path, 1..=1)?;
        not_draco(primitive, INDICES, &values, &path)?;
        Ok(values.count() as u64)
    }

    /// The texture coordinates for the texture of the material; the first ones if there is no texture.
    fn uvs(
        &mut self,
        primitive: &Primitive,
        count: u64,
        path: &str,
    ) -> Result<Option<(u32, TextureTransform)>, ReadErrorKind> {
        let material = primitive.material.and_then(|material| self.textures.get(material as usize));
        let texture = material.and_then(Option::as_ref);
        let transform = texture.and_then(|info| info.extensions.transform).unwrap_or_default();
        let own = texture.map_or(0, |info| info.tex_coord);
        let name = format!("TEXCOORD_{}", transform.tex_coord.unwrap_or(own));
        let Some(accessor) = primitive.attributes.get(&name) else {
            if texture.is_some() {
                self.notes.add(format!("{path}: its texture needs {name}, which is not there"));
            }
            return Ok(None);
        };
        self.attribute(primitive, accessor, &name, 2..=2, Some(count as usize), path)?;
        Ok(Some((accessor, transform)))
    }
}

impl Planner<'_> {
    /// The accessors of the texture coordinates other than the first set, in the order of their names.
    fn more_uvs(
        &self,
        primitive: &Primitive,
        first: Option<u32>,
        count: u64,
        path: &str,
    ) -> Result<Vec<u32>, ReadErrorKind> {
        let mut accessors = Vec::new();
        for (name, accessor) in primitive.attributes.iter() {
            if name.starts_with("TEXCOORD_") && Some(accessor) != first {
                self.attribute(primitive, accessor, name, 2..=2, Some(count as usize), path)?;
                accessors.push(accessor);
            }
        }
        Ok(accessors)
    }
}

/// How to get rid of a compression by Draco.
pub(crate) const UNDRACO: &str =
    "remove the compression, for example with `gltf-transform copy IN OUT`";

/// The indices, which every compressed primitive contains.
const INDICES: &str = "indices";

/// Rejects values that exist only in compressed data. Values that these do not contain either are zero.
pub(crate) fn not_draco(
    primitive: &Primitive,
    name: &str,
    values: &Values<'_>,
    path: &str,
) -> Result<(), ReadErrorKind> {
    let draco = primitive.extensions.draco.as_deref();
    let is_compressed =
        draco.is_some_and(|draco| name == INDICES || draco.attributes.get(name).is_some());
    if !is_compressed || !values.is_nothing() {
        return Ok(());
    }
    Err(ReadErrorKind::Unsupported {
        at: at(path),
        what: "the extension KHR_draco_mesh_compression without other data".to_owned(),
        cure: UNDRACO,
    })
}
