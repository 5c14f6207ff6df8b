//! The grids to which positions are rounded, and the transforms of nodes and skins that undo them.

use super::disjoint::Sets;
use super::document::{Scene, list_mut, push};
use super::extensions::occurs;
use super::references::{Target, each_reference};
use crate::error::ReadErrorKind;
use crate::gltf::scene::{each_node, local};
use crate::gltf::schema::{Attributes, Primitive};
use crate::scalars::ScalarType;
use glam::{DMat4, DVec3};
use mesh_core::as_u32;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, BTreeSet};

const POINTER: &str = "KHR_animation_pointer";
/// Extensions of nodes that do not depend on their transforms.
const WITHOUT_PLACE: [&str; 2] = ["MSFT_lod", "KHR_node_visibility"];

/// A grid with equal steps in all directions: the origin, and the length of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Grid {
    pub(super) origin: DVec3,
    pub(super) step: f64,
}

impl Grid {
    fn transform(self) -> DMat4 {
        DMat4::from_translation(self.origin) * DMat4::from_scale(DVec3::splat(self.step))
    }
}

/// The grids of a scene.
pub(super) struct Grids {
    /// The grid of each mesh whose positions are rounded.
    pub(super) of_meshes: Vec<Option<Grid>>,
    /// The grid of each skin with such meshes.
    of_skins: Vec<Option<Grid>>,
    /// For meshes whose positions stay as they are: the mesh and the reason.
    pub(super) stayed: Vec<(usize, &'static str)>,
}

/// What is known about the positions of a mesh.
#[derive(Clone, Copy)]
struct Extent {
    least: DVec3,
    most: DVec3,
    /// The largest component of the changes of morph targets.
    change: f64,
    /// Why the positions cannot be rounded.
    reason: Option<&'static str>,
    /// Whether there is anything to round.
    has_floats: bool,
}

impl Extent {
    const NONE: Self = Self {
        least: DVec3::INFINITY,
        most: DVec3::NEG_INFINITY,
        change: 0.0,
        reason: None,
        has_floats: false,
    };

    fn union(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
            change: self.change.max(other.change),
            reason: self.reason.or(other.reason),
            has_floats: self.has_floats || other.has_floats,
        }
    }

    /// The grid of integers from 0 to `largest`; `None` if its steps would be no normal numbers.
    #[expect(clippy::cast_possible_truncation, reason = "files hold numbers of this type")]
    fn grid(&self, largest: f64) -> Option<Grid> {
        let extent = (self.most - self.least).max_element();
        let step = (extent / largest).max(self.change / f64::from(i16::MAX)) as f32;
        let step = if step == 0.0 { 1.0 } else { step };
        let origin = self.least.as_vec3().as_dvec3();
        (step.is_normal() && origin.is_finite()).then_some(Grid { origin, step: step.into() })
    }
}

impl Grids {
    /// The grids with integers of this number of bits. Meshes have the same grid if they share positions, a skin, or
    /// the place where a node draws them, so that borders between them stay closed.
    pub(super) fn of(scene: &Scene, bits: u32) -> Result<Self, ReadErrorKind> {
        let root = scene.root();
        let (meshes, skins) = (as_u32(root.meshes.len()), as_u32(root.skins.len()));
        let mut sets = Sets::new(meshes + skins);
        let mut extents = vec![Extent::NONE; root.meshes.len() + root.skins.len()];
        let mut users = BTreeMap::new();
        let obstacles = Obstacles::of(scene);
        let is_only = only_positions(scene);
        for ((index, mesh), extent) in (0..meshes).zip(&root.meshes).zip(&mut extents) {
            for primitive in &mesh.primitives {
                for (accessor, is_change) in positions(primitive) {
                    if !is_only.contains(&(accessor, is_change)) {
                        extent.reason = extent.reason.or(Some("other data are its positions too"));
                    }
                    sets.join(index, *users.entry(accessor).or_insert(index));
                    extent.add(scene, accessor, is_change)?;
                }
            }
            extent.reason = extent.reason.or(obstacles.reason(scene, index as usize));
        }
        let mut is_drawn = vec![false; root.meshes.len()];
        for node in &root.nodes {
            let Some(mesh) = node.mesh.filter(|&mesh| mesh < meshes) else { continue };
            is_drawn[mesh as usize] = true;
            if let Some(skin) = node.skin.filter(|&skin| skin < skins) {
                sets.join(mesh, meshes + skin);
            } else if node.extensions.instancing.is_some() {
                extents[mesh as usize].reason = Some("a node draws instances of it");
            }
        }
        for (is_drawn, extent) in is_drawn.iter().zip(&mut extents) {
            if !is_drawn {
                extent.reason = extent.reason.or(Some("no node draws it"));
            }
        }
        let own: Vec<bool> = extents.iter().map(|extent| extent.has_floats).collect();
        collect(&mut extents, &mut sets);
        let united = extents.clone();
        join_places(scene, &united, &mut sets)?;
        collect(&mut extents, &mut sets);
        let largest = f64::from((1_u32 << bits) - 1);
        let all: Vec<(Extent, Option<Grid>)> = (0..meshes + skins)
            .map(|index| {
                let extent = extents[sets.of(index) as usize];
                let grid = (extent.reason.is_none() && extent.has_floats)
                    .then(|| extent.grid(largest))
                    .flatten();
                (extent, grid)
            })
            .collect();
        let why = |extent: &Extent| extent.reason.unwrap_or("its size is out of range");
        let (of_meshes, of_skins) = all.split_at(root.meshes.len());
        let stayed = of_meshes.iter().zip(own).enumerate().filter_map(|(mesh, (one, own))| {
            let (extent, grid) = one;
            (own && grid.is_none()).then(|| (mesh, why(extent)))
        });
        Ok(Self {
            stayed: stayed.collect(),
            of_meshes: of_meshes.iter().map(|(_, grid)| *grid).collect(),
            of_skins: of_skins.iter().map(|(_, grid)| *grid).collect(),
        })
    }

    /// Lets the nodes and skins undo the grids. The transform of a node with a skin does not count, but readers that show
    /// meshes without their skins, as ours for single meshes does, take it. `push_matrices` stores inverse bind matrices, and returns the accessor.
    pub(super) fn undo(
        &self,
        scene: &Scene,
        json: &mut Value,
        mut push_matrices: impl FnMut(&mut Value, &[DMat4]) -> usize,
    ) -> Result<(), ReadErrorKind> {
        let root = scene.root();
        let moved = moved(scene);
        let mut drawing = BTreeMap::new();
        for (index, node) in root.nodes.iter().enumerate() {
            let grid = node.mesh.and_then(|mesh| self.of_meshes.get(mesh as usize).copied());
            let Some(grid) = grid.flatten() else { continue };
            let Some(object) = list_mut(json, "nodes").get_mut(index) else { continue };
            let Some(object) = object.as_object_mut() else { continue };
            let extensions = object.get("extensions").and_then(Value::as_object);
            let is_plain = !moved[index]
                && node.children.is_empty()
                && !object.contains_key("camera")
                && extensions.into_iter().flat_map(Map::keys).all(|name| is_without_place(name));
            if is_plain {
                place(object, local(node), grid);
                continue;
            }
            let mut below = Map::new();
            for name in ["mesh", "weights", "skin"] {
                if let Some(value) = object.remove(name) {
                    below.insert(name.to_owned(), value);
                }
            }
            place(&mut below, DMat4::IDENTITY, grid);
            let below = push(json, "nodes", below.into());
            drawing.insert(index as u64, below);
            if let Some(object) =
                list_mut(json, "nodes").get_mut(index).and_then(Value::as_object_mut)
            {
                let children = object.entry("children").or_insert_with(|| json!([]));
                if let Some(children) = children.as_array_mut() {
                    // Before the others, so that meshes are drawn in the same order.
                    children.insert(0, below.into());
                }
            }
        }
        for animation in list_mut(json, "animations") {
            for channel in list_mut(animation, "channels") {
                let is_weights = channel.pointer("/target/path") == Some(&json!("weights"));
                let node = channel.pointer_mut("/target/node").filter(|_| is_weights);
                if let Some(node) = node
                    && let Some(below) = node.as_u64().and_then(|node| drawing.get(&node))
                {
                    *node = (*below).into();
                }
            }
        }
        for (index, (skin, grid)) in root.skins.iter().zip(&self.of_skins).enumerate() {
            let Some(grid) = grid else { continue };
            let inverse = super::placement::inverse_binds(&scene.document, skin)?;
            let inverse: Vec<DMat4> =
                inverse.into_iter().map(|matrix| matrix * grid.transform()).collect();
            let accessor = push_matrices(json, &inverse);
            if let Some(skin) = list_mut(json, "skins").get_mut(index) {
                skin["inverseBindMatrices"] = accessor.into();
            }
        }
        Ok(())
    }
}

impl Extent {
    fn add(&mut self, scene: &Scene, accessor: u32, is_change: bool) -> Result<(), ReadErrorKind> {
        let values = scene.document.values(accessor, "positions", 1..=3)?;
        if values.component() != ScalarType::F32 {
            self.reason = self.reason.or(Some("some of its positions are integers already"));
            return Ok(());
        }
        if values.is_nothing() {
            self.reason = self.reason.or(Some("the file does not hold its positions"));
        }
        self.has_floats |= !is_change;
        let mut is_finite = true;
        for value in values.to_vec::<3>(0.0)? {
            let value = DVec3::from_array(value.map(f64::from));
            is_finite &= value.is_finite();
            if is_change {
                self.change = self.change.max(value.abs().max_element());
            } else {
                self.least = self.least.min(value);
                self.most = self.most.max(value);
            }
        }
        if !is_finite {
            self.reason = self.reason.or(Some("some of its positions are not finite"));
        }
        Ok(())
    }
}

/// Collects the extents of each set at the index that stands for it.
fn collect(extents: &mut [Extent], sets: &mut Sets) {
    for index in 0..as_u32(extents.len()) {
        let top = sets.of(index) as usize;
        if top != index as usize {
            extents[top] = extents[top].union(extents[index as usize]);
        }
    }
}

/// Joins the meshes that nodes of the default scene draw in the same place, as far as their positions can be rounded.
fn join_places(scene: &Scene, extents: &[Extent], sets: &mut Sets) -> Result<(), ReadErrorKind> {
    let root = scene.root();
    let mut at: BTreeMap<[u64; 16], u32> = BTreeMap::new();
    each_node(root, |_, node, world| {
        let is_skinned = node.skin.is_some_and(|skin| (skin as usize) < root.skins.len());
        let mesh = node.mesh.filter(|&mesh| !is_skinned && (mesh as usize) < root.meshes.len());
        let Some(mesh) = mesh else { return Ok(()) };
        let extent = extents[sets.of(mesh) as usize];
        if extent.reason.is_none() && extent.has_floats {
            // Zeros have one sign.
            let place = world.to_cols_array().map(|number| (number + 0.0).to_bits());
            sets.join(mesh, *at.entry(place).or_insert(mesh));
        }
        Ok(())
    })
}

/// Whether each node is a joint, or an animation moves it.
fn moved(scene: &Scene) -> Vec<bool> {
    let root = scene.root();
    let mut moved = vec![occurs(&scene.json, POINTER); root.nodes.len()];
    let mut mark = |node: usize| {
        if let Some(slot) = moved.get_mut(node) {
            *slot = true;
        }
    };
    root.skins.iter().flat_map(|skin| &skin.joints).for_each(|&joint| mark(joint as usize));
    let list = |value: &Value, name: &str| value.get(name).and_then(Value::as_array).cloned();
    for animation in list(&scene.json, "animations").into_iter().flatten() {
        for channel in list(&animation, "channels").into_iter().flatten() {
            let node = channel.pointer("/target/node").and_then(Value::as_u64);
            if channel.pointer("/target/path") != Some(&json!("weights")) {
                node.into_iter().for_each(|node| mark(node as usize));
            }
        }
    }
    moved
}

fn is_without_place(name: &str) -> bool {
    WITHOUT_PLACE.contains(&name)
}

/// Lets a node with this transform draw integers of a grid.
fn place(object: &mut Map<String, Value>, transform: DMat4, grid: Grid) {
    if object.contains_key("matrix") {
        let matrix = transform * grid.transform();
        object.insert("matrix".to_owned(), json!(matrix.to_cols_array()));
        return;
    }
    let origin = transform.transform_point3(grid.origin);
    let scale = |axis: usize| {
        let own = object.get("scale").and_then(|scale| scale.get(axis)).and_then(Value::as_f64);
        own.unwrap_or(1.0) * grid.step
    };
    let scale = [0, 1, 2].map(scale);
    object.insert("translation".to_owned(), json!(origin.to_array()));
    object.insert("scale".to_owned(), json!(scale));
}

/// The accessors of positions, and of their changes by morph targets.
fn positions(primitive: &Primitive) -> impl Iterator<Item = (u32, bool)> {
    let of = |attributes: &Attributes| attributes.get("POSITION");
    let changes = primitive.targets.iter().filter_map(of).map(|accessor| (accessor, true));
    of(&primitive.attributes).map(|accessor| (accessor, false)).into_iter().chain(changes)
}

/// The accessors that are used as positions only, or as changes of positions only.
fn only_positions(scene: &Scene) -> BTreeSet<(u32, bool)> {
    let mut uses: BTreeMap<u64, usize> = BTreeMap::new();
    each_reference(&mut scene.json.clone(), Target::Accessor, &mut |index| {
        *uses.entry(index.as_u64().unwrap_or(u64::MAX)).or_default() += 1;
    });
    let mut found: BTreeMap<(u32, bool), usize> = BTreeMap::new();
    for primitive in scene.root().meshes.iter().flat_map(|mesh| &mesh.primitives) {
        for use_as in positions(primitive) {
            *found.entry(use_as).or_default() += 1;
        }
    }
    let is_only = |((accessor, _), count): &((u32, bool), usize)| {
        uses.get(&u64::from(*accessor)) == Some(count)
    };
    found.into_iter().filter(is_only).map(|(use_as, _)| use_as).collect()
}

/// What the document says about meshes whose positions cannot be rounded.
struct Obstacles {
    has_pointers: bool,
    /// For each material, whether it has a thickness.
    is_thick: Vec<bool>,
}

impl Obstacles {
    fn of(scene: &Scene) -> Self {
        let materials = scene.json.get("materials").and_then(Value::as_array);
        let is_thick = |material: &Value| {
            let factor = material.pointer("/extensions/KHR_materials_volume/thicknessFactor");
            factor.and_then(Value::as_f64).is_some_and(|factor| factor > 0.0)
        };
        Self {
            has_pointers: occurs(&scene.json, POINTER),
            is_thick: materials.into_iter().flatten().map(is_thick).collect(),
        }
    }

    fn reason(&self, scene: &Scene, mesh: usize) -> Option<&'static str> {
        let primitives = &scene.root().meshes.get(mesh)?.primitives;
        if primitives.iter().any(|primitive| primitive.extensions.draco.is_some()) {
            return Some("it is compressed by Draco");
        }
        if self.has_pointers && primitives.iter().any(|primitive| !primitive.targets.is_empty()) {
            return Some("animations may point to its morph targets");
        }
        let is_thick = |material: &Value| {
            let material = material.as_u64().and_then(|index| self.is_thick.get(index as usize));
            material.copied().unwrap_or(false)
        };
        let content = scene.json.get("meshes")?.get(mesh)?;
        let has_thickness = content.get("primitives")?.as_array()?.iter().any(|primitive| {
            let mappings = primitive.pointer("/extensions/KHR_materials_variants/mappings");
            let others = mappings.and_then(Value::as_array).into_iter().flatten();
            let others = others.filter_map(|mapping| mapping.get("material"));
            primitive.get("material").into_iter().chain(others).any(is_thick)
        });
        has_thickness.then_some("the thickness of its material is a length of the mesh")
    }
}
