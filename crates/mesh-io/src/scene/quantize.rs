//! Rounds the data of vertices to integers of few bits (`KHR_mesh_quantization`).

use super::document::{Scene, list_mut, push, push_all, root_of};
use super::extensions::unknown;
use super::grids::{Grid, Grids};
use super::influences::rounded;
use super::placement::SceneDraw;
use super::poses::ScenePose;
use super::prune::{Referenced, prune};
use super::references::{Target, each_reference};
use super::replace::drop_unused_names;
use super::vertex_data::VertexData;
use crate::error::{ReadErrorKind, WriteError};
use crate::gltf::accessor::{Bytes, Document, at};
use crate::gltf::schema::{Attributes, Mesh, Primitive};
use crate::scalars::ScalarType;
use crate::text::quote;
use crate::write_options::Quantization;
use glam::{DMat4, DVec3};
use mesh_core::as_u32;
use serde_json::{Value, json};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

const EXTENSION: &str = "KHR_mesh_quantization";
const ARRAY_BUFFER: u32 = 34962;
const UNSIGNED_SHORT: u32 = 5123;
const UNSIGNED_INT: u32 = 5125;

/// A scene with rounded data.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct QuantizedScene {
    /// The scene.
    pub scene: Scene,
    /// The largest distance by which the rounding of positions moves a vertex, in units of the scene, where its mesh is
    /// drawn largest, in any of its [poses](Scene::poses). The rounding of the weights of a skin is not included.
    pub rounding: f64,
    /// What could not be rounded, with the reason.
    pub stayed: Vec<String>,
}

impl Scene {
    /// The scene with positions, normals, tangents, texture coordinates, colours, weights and morph targets as integers
    /// (`KHR_mesh_quantization`), which readers of the file must know.
    ///
    /// Nodes and skins undo the grid of positions; a node with a skin does so as well, for readers that ignore skins. A
    /// node that is animated, or has children or a camera, gets a new node below it for this. Meshes that are drawn in
    /// the same place have the same grid, so borders between them stay closed. What is not a floating-point number already, or out of the range of the integers, stays as it is.
    ///
    /// # Errors
    /// A [`WriteError`]: the options are out of range, or data cannot be read.
    pub fn quantized(&self, options: &Quantization) -> Result<QuantizedScene, WriteError> {
        options.check()?;
        let unknown = unknown(&self.json);
        if let Some(name) = unknown.first() {
            let name = quote(name.as_bytes());
            let stayed =
                vec![format!("all data stay as they are: extension {name} may refer to them")];
            return Ok(QuantizedScene { scene: self.clone(), rounding: 0.0, stayed });
        }
        self.with_integers(options).map_err(|error| WriteError::Scene(error.to_string()))
    }

    /// For each mesh, a bound of the distance by which the rounding of positions in [`Scene::quantized`] moves its
    /// vertices, as [`QuantizedScene::rounding`].
    ///
    /// # Errors
    /// As [`Scene::quantized`].
    pub fn quantization_bounds(&self, options: &Quantization) -> Result<Vec<f64>, WriteError> {
        options.check()?;
        if !unknown(&self.json).is_empty() {
            return Ok(vec![0.0; self.mesh_count()]);
        }
        let of = |error: ReadErrorKind| WriteError::Scene(error.to_string());
        let grids = Grids::of(self, options.positions.into()).map_err(of)?;
        let showings = self.showings().map_err(of)?;
        let meshes = grids.of_meshes.iter().zip(&self.root().meshes).zip(showings);
        let bound = |((grid, mesh), showing): ((&Option<Grid>, &Mesh), Showing)| {
            let targets = mesh.primitives.iter().map(|primitive| primitive.targets.len()).max();
            let bound = grid.map_or(0.0, Grid::bound);
            showing.distance(bound, &vec![bound; targets.unwrap_or(0)])
        };
        Ok(meshes.map(bound).collect())
    }

    fn with_integers(&self, options: &Quantization) -> Result<QuantizedScene, ReadErrorKind> {
        let grids = Grids::of(self, options.positions.into())?;
        let mut json = self.json.clone();
        let before = Referenced::of(&mut json);
        let mut made = Made {
            scene: self,
            options: *options,
            buffer: self.document.buffers.len(),
            views: list_mut(&mut json, "bufferViews").to_vec(),
            bytes: Vec::new(),
            kinds: BTreeMap::new(),
            needs_extension: false,
            stayed: Vec::new(),
        };
        for (mesh, why) in &grids.stayed {
            made.stayed.push(format!("{}: positions stay as they are: {why}", self.title(*mesh)));
        }
        let rounding = made.all(&mut json, &grids)?;
        grids.undo(self, &mut json, |json, matrices| made.matrices(json, matrices))?;
        let Made { views, bytes, needs_extension, mut stayed, .. } = made.finish(&mut json);
        if bytes.is_empty() {
            return Ok(QuantizedScene { scene: self.clone(), rounding: 0.0, stayed });
        }
        if let Some(document) = json.as_object_mut() {
            document.insert("bufferViews".to_owned(), views.into());
        }
        push_all(&mut json, "buffers", [json!({ "byteLength": bytes.len() })]);
        let mut buffers = self.document.buffers.clone();
        buffers.push(Bytes { length: bytes.len(), all: Arc::new(bytes) });
        prune(&mut json, &mut buffers, &before);
        drop_unused_names(&mut json, &self.json);
        for list in ["extensionsUsed", "extensionsRequired"] {
            let names = json.get(list).and_then(Value::as_array);
            if needs_extension && !names.is_some_and(|names| names.contains(&json!(EXTENSION))) {
                push_all(&mut json, list, [json!(EXTENSION)]);
            }
        }
        stayed.dedup();
        let root = root_of(&json).map_err(|error| {
            ReadErrorKind::malformed(at("the scene"), "a document", error.to_string())
        })?;
        let scene = self.with(json, Document { root, buffers });
        Ok(QuantizedScene { scene, rounding, stayed })
    }

    fn title(&self, mesh: usize) -> String {
        match self.mesh_name(mesh) {
            Some(name) => format!("mesh {mesh} {}", quote(name.as_bytes())),
            None => format!("mesh {mesh}"),
        }
    }

    /// How each mesh is drawn.
    fn showings(&self) -> Result<Vec<Showing>, ReadErrorKind> {
        let mut all = vec![Showing::default(); self.mesh_count()];
        let draws = self.draws().map_err(|error| error.kind)?;
        let poses = self.poses(&draws).map_err(|error| error.kind)?;
        for (draw, poses) in draws.into_iter().zip(poses) {
            let Some(showing) = all.get_mut(draw.mesh) else { continue };
            let mut scale = draw.scale();
            for ScenePose { joints, weights } in poses {
                if !joints.is_empty() {
                    scale = scale.max(SceneDraw { transforms: joints, ..draw.clone() }.scale());
                }
                showing.weights.push(weights);
            }
            showing.scale = Some(showing.scale.unwrap_or(0.0).max(scale));
        }
        Ok(all)
    }
}

/// How a mesh is drawn by the default scene.
#[derive(Clone, Debug, Default)]
struct Showing {
    /// The largest factor by which its lengths grow, over all poses of its skin.
    scale: Option<f64>,
    /// The weights of morph targets in all poses.
    weights: Vec<Vec<f64>>,
}

impl Showing {
    /// A distance in units of the scene: the one of the vertices, and those of each morph target.
    fn distance(&self, own: f64, of_targets: &[f64]) -> f64 {
        let sum = |weights: &Vec<f64>| -> f64 {
            weights.iter().zip(of_targets).map(|(weight, distance)| weight.abs() * distance).sum()
        };
        let most = self.weights.iter().map(sum).fold(0.0, f64::max);
        (own + most) * self.scale.unwrap_or(1.0)
    }
}

impl Grid {
    /// The largest distance to the nearest point of the grid.
    fn bound(self) -> f64 {
        0.5 * 3.0_f64.sqrt() * self.step
    }
}

/// What an accessor holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Position,
    /// The change of positions by a morph target.
    Shift,
    /// Normals, tangents, and their changes.
    Direction,
    Coordinates,
    Color,
    /// Something that is not rounded, or several things.
    Other,
}

impl Role {
    fn of(name: &str, is_change: bool) -> Self {
        let is_set = |prefix: &str| name.starts_with(prefix) && !is_change;
        match name {
            "POSITION" if is_change => Self::Shift,
            "POSITION" => Self::Position,
            "NORMAL" | "TANGENT" => Self::Direction,
            _ if is_set("TEXCOORD_") => Self::Coordinates,
            _ if is_set("COLOR_") => Self::Color,
            _ => Self::Other,
        }
    }
}

/// Values of one size that go into one view.
#[derive(Default)]
struct Kind {
    bytes: Vec<u8>,
    /// Accessors and their offsets.
    places: Vec<(u32, usize)>,
}

struct Made<'s> {
    scene: &'s Scene,
    options: Quantization,
    /// The new buffer.
    buffer: usize,
    /// All views, old and new.
    views: Vec<Value>,
    bytes: Vec<u8>,
    /// By the bytes of a value.
    kinds: BTreeMap<usize, Kind>,
    needs_extension: bool,
    stayed: Vec<String>,
}

/// The joints and weights of the sets of a primitive.
type Influences = Vec<[u32; 2]>;

impl Made<'_> {
    /// Rounds all data, and returns the largest distance by which a vertex moves.
    fn all(&mut self, json: &mut Value, grids: &Grids) -> Result<f64, ReadErrorKind> {
        let root = self.scene.root();
        let mut roles: BTreeMap<u32, (Role, usize)> = BTreeMap::new();
        let mut influences: BTreeSet<Influences> = BTreeSet::new();
        let mut uses = vec![0_usize; root.accessors.len()];
        each_reference(json, Target::Accessor, &mut |index| {
            let slot = index.as_u64().and_then(|index| uses.get_mut(index as usize));
            if let Some(slot) = slot {
                *slot += 1;
            }
        });
        let mut found = vec![0_usize; root.accessors.len()];
        for (mesh, content) in root.meshes.iter().enumerate() {
            for primitive in &content.primitives {
                for (name, accessor, is_change) in attributes(primitive) {
                    let role = match primitive.extensions.draco {
                        Some(_) => Role::Other,
                        None => Role::of(name, is_change),
                    };
                    let entry = roles.entry(accessor).or_insert((role, mesh));
                    if entry.0 != role {
                        entry.0 = Role::Other;
                    }
                    if let Some(slot) = found.get_mut(accessor as usize) {
                        *slot += 1;
                    }
                }
                if primitive.extensions.draco.is_none() {
                    influences.insert(influences_of(primitive));
                }
            }
        }
        let is_free = |accessor: u32| {
            let accessor = accessor as usize;
            uses.get(accessor).zip(found.get(accessor)).is_some_and(|(uses, found)| uses == found)
        };
        let mut moved = BTreeMap::new();
        for (&accessor, &(role, mesh)) in &roles {
            if role != Role::Other && is_free(accessor) {
                let grid = grids.of_meshes.get(mesh).copied().flatten();
                moved.insert(accessor, self.accessor(json, accessor, role, mesh, grid)?);
            }
        }
        let mut users: BTreeMap<u32, usize> = BTreeMap::new();
        for &accessor in influences.iter().flat_map(|sets| sets.as_flattened()) {
            *users.entry(accessor).or_default() += 1;
        }
        for sets in &influences {
            let is_own = |accessor: &u32| users.get(accessor) == Some(&1) && is_free(*accessor);
            if sets.as_flattened().iter().all(is_own) {
                self.weights(json, sets)?;
            }
        }
        let distance = |attributes: &Attributes| {
            let accessor = attributes.get("POSITION");
            accessor.and_then(|accessor| moved.get(&accessor)).copied().unwrap_or(0.0)
        };
        let mut most = 0.0_f64;
        for (mesh, showing) in root.meshes.iter().zip(self.scene.showings()?) {
            for primitive in &mesh.primitives {
                let of_targets: Vec<f64> = primitive.targets.iter().map(distance).collect();
                most = most.max(showing.distance(distance(&primitive.attributes), &of_targets));
            }
        }
        Ok(most)
    }

    /// Rounds the values of an accessor, and returns the largest distance by which positions move.
    fn accessor(
        &mut self,
        json: &mut Value,
        accessor: u32,
        role: Role,
        mesh: usize,
        grid: Option<Grid>,
    ) -> Result<f64, ReadErrorKind> {
        let document = &*self.scene.document;
        let path = format!("accessors[{accessor}]");
        let values = document.values(accessor, &path, 1..=4)?;
        let width = document.width(accessor, &path)?;
        if values.component() != ScalarType::F32 || values.is_nothing() || values.count() == 0 {
            return Ok(0.0);
        }
        let all = values.to_vec::<4>(0.0)?;
        let [least, most] = range(&all, width);
        let Form { name, component, bits, limits } = role.form(self.options, least);
        let grid = match role {
            Role::Position | Role::Shift => {
                let Some(grid) = grid else { return Ok(0.0) };
                Some(if role == Role::Shift { Grid { origin: DVec3::ZERO, ..grid } } else { grid })
            }
            _ => None,
        };
        if grid.is_none() && !(limits[0] <= least && most <= limits[1]) {
            let (title, [from, to]) = (self.scene.title(mesh), limits);
            let stayed =
                format!("{title}: {name} stay as they are: some are not in {from} to {to}");
            self.stayed.push(stayed);
            return Ok(0.0);
        }
        let normalized = grid.is_none();
        let form = VertexData { name: String::new(), component, width, normalized, bytes: vec![] };
        // Fewer bits are the upper ones, so that the largest number still stands for 1.
        let unit = f64::from(1_u32 << (8 * as_u32(component.bytes()) - bits).min(31));
        let (one, mut bytes, mut farthest) = (form.one(), Vec::new(), 0.0_f64);
        for value in all {
            let mut distance = 0.0;
            for (axis, number) in value.into_iter().take(width).map(f64::from).enumerate() {
                let Some(Grid { origin, step }) = grid else {
                    form.encode((number * one / unit).round() * unit, &mut bytes);
                    continue;
                };
                let origin = origin.to_array().get(axis).copied().unwrap_or(0.0);
                let whole = ((number - origin) / step).round();
                distance += (origin + whole * step - number).powi(2);
                form.encode(whole, &mut bytes);
            }
            farthest = farthest.max(distance);
        }
        // Colours, and positive coordinates, may be integers in every file.
        self.needs_extension |=
            !matches!(role, Role::Color) && component != ScalarType::U16 || role == Role::Position;
        self.replace(json, accessor, &VertexData { bytes, ..form }, role != Role::Position);
        Ok(farthest.sqrt())
    }

    /// Rounds the weights of the sets of a skin.
    fn weights(&mut self, json: &mut Value, sets: &[[u32; 2]]) -> Result<(), ReadErrorKind> {
        let data = |accessor: u32| -> Result<Option<VertexData>, ReadErrorKind> {
            let path = format!("accessors[{accessor}]");
            let values = self.scene.document.values(accessor, &path, 1..=4)?;
            if values.is_nothing() {
                return Ok(None);
            }
            Ok(Some(VertexData {
                name: path.clone(),
                component: values.component(),
                width: self.scene.document.width(accessor, &path)?,
                normalized: values.is_normalized(),
                bytes: values.packed()?,
            }))
        };
        let mut all = Vec::with_capacity(sets.len());
        for &[joints, weights] in sets {
            let [Some(joints), Some(weights)] = [data(joints)?, data(weights)?] else {
                return Ok(());
            };
            all.push([joints, weights]);
        }
        match rounded(&all) {
            Ok(rounded) => {
                let rounded = rounded.into_iter().flatten().flatten();
                for (&accessor, data) in sets.as_flattened().iter().zip(rounded) {
                    self.replace(json, accessor, &data, false);
                }
            }
            Err(why) => self.stayed.push(format!("weights of skins stay as they are: {why}")),
        }
        Ok(())
    }

    /// Gives an accessor other values. A sparse one stays sparse if `may_be_sparse`.
    fn replace(&mut self, json: &mut Value, accessor: u32, data: &VertexData, may_be_sparse: bool) {
        let Some(object) = list_mut(json, "accessors").get_mut(accessor as usize) else { return };
        let Some(members) = object.as_object_mut() else { return };
        let is_sparse = members.remove("sparse").is_some() && !members.contains_key("bufferView");
        for (name, values) in ["min", "max"].into_iter().zip(data.bounds().unwrap_or_default()) {
            if members.contains_key(name) {
                let whole: Vec<i64> = values.iter().map(|&value| value as i64).collect();
                members.insert(name.to_owned(), json!(whole));
            }
        }
        members.insert("componentType".to_owned(), data.code().into());
        members.remove("normalized");
        if data.normalized {
            members.insert("normalized".to_owned(), true.into());
        }
        let is_other = |&vertex: &usize| data.value(vertex).iter().any(|&byte| byte != 0);
        let others: Vec<usize> = (0..data.count()).filter(is_other).collect();
        if is_sparse && may_be_sparse && !others.is_empty() {
            let sparse = self.sparse(data, &others);
            members.insert("sparse".to_owned(), sparse);
            return;
        }
        let stride = data.size().next_multiple_of(4);
        let kind = self.kinds.entry(stride).or_default();
        members.insert("byteOffset".to_owned(), kind.bytes.len().into());
        kind.places.push((accessor, kind.bytes.len()));
        for vertex in 0..data.count() {
            kind.bytes.extend_from_slice(data.value(vertex));
            kind.bytes.resize(kind.bytes.len().next_multiple_of(4), 0);
        }
    }

    /// Stores the values of some vertices.
    fn sparse(&mut self, data: &VertexData, vertices: &[usize]) -> Value {
        let is_short = data.count() <= usize::from(u16::MAX);
        let size = if is_short { 2 } else { 4 };
        let indices =
            vertices.iter().flat_map(|&vertex| as_u32(vertex).to_le_bytes().into_iter().take(size));
        let indices = self.view(indices.collect());
        let values = vertices.iter().flat_map(|&vertex| data.value(vertex)).copied();
        let values = self.view(values.collect());
        let kind = if is_short { UNSIGNED_SHORT } else { UNSIGNED_INT };
        json!({
            "count": vertices.len(), "indices": { "bufferView": indices, "componentType": kind },
            "values": { "bufferView": values },
        })
    }

    /// Stores inverse bind matrices.
    #[expect(clippy::cast_possible_truncation, reason = "files hold numbers of this type")]
    fn matrices(&mut self, json: &mut Value, matrices: &[DMat4]) -> usize {
        let numbers = matrices.iter().flat_map(DMat4::to_cols_array);
        let view = self.view(numbers.flat_map(|number| (number as f32).to_le_bytes()).collect());
        let accessor = json!({
            "bufferView": view, "componentType": 5126, "count": matrices.len(), "type": "MAT4",
        });
        push(json, "accessors", accessor)
    }

    /// Appends a view.
    fn view(&mut self, bytes: Vec<u8>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.push(json!({
            "buffer": self.buffer, "byteOffset": self.bytes.len(), "byteLength": bytes.len(),
        }));
        self.bytes.extend(bytes);
        self.views.len() - 1
    }

    /// Stores the attributes of vertices: one view for each size of values.
    fn finish(mut self, json: &mut Value) -> Self {
        for (stride, kind) in std::mem::take(&mut self.kinds) {
            let view = self.view(kind.bytes);
            if let Some(view) = self.views.last_mut() {
                view["target"] = ARRAY_BUFFER.into();
                view["byteStride"] = stride.into();
            }
            for (accessor, offset) in kind.places {
                let accessor = list_mut(json, "accessors").get_mut(accessor as usize);
                if let Some(accessor) = accessor {
                    accessor["bufferView"] = view.into();
                    accessor["byteOffset"] = offset.into();
                }
            }
        }
        self
    }
}

/// The form of rounded values.
struct Form {
    /// What they are, for people.
    name: &'static str,
    component: ScalarType,
    bits: u32,
    /// The least and the largest number that the integers can stand for, if they have no grid.
    limits: [f64; 2],
}

impl Role {
    fn form(self, options: Quantization, least: f64) -> Form {
        let Quantization { texture_coordinates, normals, .. } = options;
        let (name, component, bits) = match self {
            Self::Shift => ("morph targets", ScalarType::I16, u16::BITS),
            Self::Direction if u32::from(normals) > u8::BITS => {
                ("normals, tangents or their changes", ScalarType::I16, normals.into())
            }
            Self::Direction => {
                ("normals, tangents or their changes", ScalarType::I8, normals.into())
            }
            Self::Coordinates if least < 0.0 => {
                ("texture coordinates", ScalarType::I16, texture_coordinates.into())
            }
            Self::Coordinates => {
                ("texture coordinates", ScalarType::U16, texture_coordinates.into())
            }
            Self::Color => ("colours", ScalarType::U8, u8::BITS),
            Self::Position | Self::Other => ("positions", ScalarType::U16, u16::BITS),
        };
        let is_signed = matches!(component, ScalarType::I8 | ScalarType::I16);
        Form { name, component, bits, limits: [if is_signed { -1.0 } else { 0.0 }, 1.0] }
    }
}

/// The least and the largest component. A number that is not finite makes both infinite.
fn range(values: &[[f32; 4]], width: usize) -> [f64; 2] {
    let mut range = [f64::INFINITY, f64::NEG_INFINITY];
    for number in values.iter().flat_map(|value| value.iter().take(width)) {
        let [least, most] = if number.is_finite() {
            [f64::from(*number); 2]
        } else {
            [f64::NEG_INFINITY, f64::INFINITY]
        };
        range = [range[0].min(least), range[1].max(most)];
    }
    range
}

/// All attributes with their accessors, and whether they are changes of a morph target.
fn attributes(primitive: &Primitive) -> impl Iterator<Item = (&str, u32, bool)> {
    let own = primitive.attributes.iter().map(|(name, accessor)| (name, accessor, false));
    let changes = primitive.targets.iter().flat_map(Attributes::iter);
    own.chain(changes.map(|(name, accessor)| (name, accessor, true)))
}

/// The joints and weights of a primitive, set by set; empty if a set is incomplete.
fn influences_of(primitive: &Primitive) -> Influences {
    let set = |set: u32| {
        let of = |name: &str| primitive.attributes.get(&format!("{name}_{set}"));
        Some([of("JOINTS")?, of("WEIGHTS")?])
    };
    (0..).map_while(set).collect()
}
