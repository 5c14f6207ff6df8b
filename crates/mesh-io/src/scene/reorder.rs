//! Puts triangles and vertices into an order that caches and compression like.

use super::disjoint::Sets;
use super::document::{Scene, list_mut, push_all, root_of};
use super::extensions::unknown;
use super::prune::{Referenced, prune};
use super::references::{Target, each_reference};
use super::replace::drop_unused_names;
use crate::error::{ReadErrorKind, WriteError};
use crate::gltf::accessor::{Bytes, Document};
use crate::gltf::schema::{Attributes, Primitive, Root};
use crate::scalars::ScalarType;
use crate::vertex_cache::cache_order;
use mesh_core::as_u32;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::sync::Arc;

const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;
const UNSIGNED_SHORT: u32 = 5123;
const TRIANGLES: u32 = 4;

/// Accessors that belong together: primitives use them with the same vertices.
#[derive(Default)]
struct Family {
    attributes: Vec<u32>,
    indices: Vec<u32>,
    /// Whether something forbids another order.
    is_fixed: bool,
}

impl Scene {
    /// The scene with the triangles of every list in an order that shares vertices, and the vertices in the order in
    /// which triangles use them. Values do not change, and the accessors keep their numbers; each kind of values gets a
    /// view without gaps.
    ///
    /// Meshes stay as they are if anything else may refer to their vertices, if they are compressed by Draco, or have
    /// other primitives than lists of triangles with indices. So does a document with unknown extensions.
    pub(super) fn reordered(&self) -> Result<Self, WriteError> {
        let mut json = self.json.clone();
        if !unknown(&json).is_empty() {
            return Ok(self.clone());
        }
        let mut made = Made { scene: self, kinds: BTreeMap::new() };
        for family in families(&mut json, self.root()) {
            made.family(&family).map_err(|error| WriteError::Scene(error.to_string()))?;
        }
        let Made { kinds, .. } = made;
        if kinds.is_empty() {
            return Ok(self.clone());
        }
        let before = Referenced::of(&mut json);
        let buffer = self.document.buffers.len();
        let first = list_mut(&mut json, "bufferViews").len();
        let (mut bytes, mut views) = (Vec::new(), Vec::new());
        for (view, ((is_index, stride), kind)) in (first..).zip(kinds) {
            let start = bytes.len();
            bytes.extend(kind.bytes);
            let mut object =
                json!({ "buffer": buffer, "byteOffset": start, "byteLength": bytes.len() - start });
            bytes.resize(bytes.len().next_multiple_of(4), 0);
            if is_index {
                object["target"] = ELEMENT_ARRAY_BUFFER.into();
            } else {
                object["target"] = ARRAY_BUFFER.into();
                object["byteStride"] = stride.into();
            }
            views.push(object);
            for place in kind.places {
                place.apply(&mut json, view);
            }
        }
        push_all(&mut json, "bufferViews", views);
        push_all(&mut json, "buffers", [json!({ "byteLength": bytes.len() })]);
        let mut buffers = self.document.buffers.clone();
        buffers.push(Bytes { length: bytes.len(), all: Arc::new(bytes) });
        prune(&mut json, &mut buffers, &before);
        drop_unused_names(&mut json, &self.json);
        let root = root_of(&json).map_err(|error| WriteError::Scene(error.to_string()))?;
        Ok(self.with(json, Document { root, buffers }))
    }
}

/// Values of one size that go into one view.
#[derive(Default)]
struct Kind {
    bytes: Vec<u8>,
    places: Vec<Place>,
}

/// The new place of the values of an accessor.
struct Place {
    accessor: u32,
    offset: usize,
    /// The least and the largest index, for indices.
    range: Option<[u32; 2]>,
}

impl Place {
    fn apply(&self, json: &mut Value, view: usize) {
        let accessor = list_mut(json, "accessors").get_mut(self.accessor as usize);
        let Some(members) = accessor.and_then(Value::as_object_mut) else { return };
        members.insert("bufferView".to_owned(), view.into());
        members.insert("byteOffset".to_owned(), self.offset.into());
        if let Some(range) = self.range {
            // Bytes become short integers, which can be compressed.
            if members.get("componentType") == Some(&json!(5121)) {
                members.insert("componentType".to_owned(), UNSIGNED_SHORT.into());
            }
            for (name, value) in ["min", "max"].into_iter().zip(range) {
                if members.contains_key(name) {
                    members.insert(name.to_owned(), json!([value]));
                }
            }
        }
    }
}

struct Made<'s> {
    scene: &'s Scene,
    /// By whether they are indices, and by the bytes of a value.
    kinds: BTreeMap<(bool, usize), Kind>,
}

impl Made<'_> {
    fn family(&mut self, family: &Family) -> Result<(), ReadErrorKind> {
        let document = &*self.scene.document;
        let Some(&first) = family.attributes.first().filter(|_| !family.is_fixed) else {
            return Ok(());
        };
        let count = document.count(first, "a mesh")? as usize;
        let mut lists = Vec::with_capacity(family.indices.len());
        for &accessor in &family.indices {
            let indices = document.indices(accessor, "indices")?;
            lists.push(cache_order(indices.as_chunks().0, count));
        }
        let order = use_order(&lists, count);
        for (&accessor, triangles) in family.indices.iter().zip(&lists) {
            let place = |&vertex: &u32| order.get(vertex as usize).copied().unwrap_or_default();
            let corners: Vec<u32> = triangles.as_flattened().iter().map(place).collect();
            self.indices(accessor, &corners)?;
        }
        for &accessor in &family.attributes {
            self.values(accessor, &order)?;
        }
        Ok(())
    }

    fn indices(&mut self, accessor: u32, corners: &[u32]) -> Result<(), ReadErrorKind> {
        let values = self.scene.document.values(accessor, "indices", 1..=1)?;
        let stride = if values.component() == ScalarType::U32 { 4 } else { 2 };
        let kind = self.kinds.entry((true, stride)).or_default();
        let range = corners.iter().min().zip(corners.iter().max());
        let range = Some(range.map_or([0, 0], |(&least, &most)| [least, most]));
        kind.places.push(Place { accessor, offset: kind.bytes.len(), range });
        let bytes = corners.iter().map(|corner| corner.to_le_bytes());
        kind.bytes.extend(bytes.flat_map(|bytes| bytes.into_iter().take(stride)));
        Ok(())
    }

    fn values(&mut self, accessor: u32, order: &[u32]) -> Result<(), ReadErrorKind> {
        let values = self.scene.document.values(accessor, "an attribute", 1..=16)?;
        if values.is_nothing() {
            return Ok(());
        }
        let size =
            self.scene.document.width(accessor, "an attribute")? * values.component().bytes();
        let stride = size.next_multiple_of(4);
        let kind = self.kinds.entry((false, stride)).or_default();
        let offset = kind.bytes.len();
        kind.places.push(Place { accessor, offset, range: None });
        kind.bytes.resize(offset + order.len() * stride, 0);
        for (value, &place) in values.packed()?.chunks_exact(size.max(1)).zip(order) {
            let start = offset + place as usize * stride;
            if let Some(slot) = kind.bytes.get_mut(start..start + size) {
                slot.copy_from_slice(value);
            }
        }
        Ok(())
    }
}

/// For each vertex, its place in the order in which triangles use them. Unused vertices come last.
fn use_order(lists: &[Vec<[u32; 3]>], count: usize) -> Vec<u32> {
    let mut order: Vec<Option<u32>> = vec![None; count];
    let mut next = 0..as_u32(count);
    for &vertex in lists.iter().flatten().flatten() {
        if let Some(slot) = order.get_mut(vertex as usize)
            && slot.is_none()
        {
            *slot = next.next();
        }
    }
    order.into_iter().map(|place| place.or_else(|| next.next()).unwrap_or_default()).collect()
}

/// The families of all accessors of primitives.
fn families(json: &mut Value, root: &Root) -> Vec<Family> {
    let mut uses = vec![0_usize; root.accessors.len()];
    each_reference(json, Target::Accessor, &mut |index| {
        let slot = index.as_u64().and_then(|index| uses.get_mut(index as usize));
        if let Some(slot) = slot {
            *slot += 1;
        }
    });
    let mut sets = Sets::new(as_u32(root.accessors.len()));
    for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let mut all = attributes(primitive).chain(primitive.indices);
        if let Some(first) = all.next() {
            all.for_each(|other| sets.join(first, other));
        }
    }
    let mut families: BTreeMap<u32, Family> = BTreeMap::new();
    for primitive in root.meshes.iter().flat_map(|mesh| &mesh.primitives) {
        let Some(first) = attributes(primitive).next() else { continue };
        let family = families.entry(sets.of(first)).or_default();
        family.attributes.extend(attributes(primitive));
        family.indices.extend(primitive.indices);
        family.is_fixed |= primitive.mode != TRIANGLES
            || primitive.indices.is_none()
            || primitive.extensions.draco.is_some();
    }
    for family in families.values_mut() {
        let all = family.attributes.iter().chain(&family.indices);
        for &accessor in all {
            if let Some(slot) = uses.get_mut(accessor as usize) {
                *slot = slot.saturating_sub(1);
            }
        }
        for list in [&mut family.attributes, &mut family.indices] {
            list.sort_unstable();
            list.dedup();
        }
        let is_fixed = |&accessor: &u32| {
            // Something else uses it.
            uses.get(accessor as usize).is_none_or(|&uses| uses > 0)
                || root
                    .accessors
                    .get(accessor as usize)
                    .is_none_or(|accessor| accessor.sparse.is_some() || accessor.shape.is_matrix())
        };
        let is_list = |&accessor: &u32| {
            let accessor = root.accessors.get(accessor as usize);
            accessor.is_some_and(|accessor| {
                accessor.count.is_multiple_of(3) && accessor.buffer_view.is_some()
            })
        };
        let count = |&accessor: &u32| root.accessors.get(accessor as usize).map(|a| a.count);
        let first = family.attributes.first().and_then(count);
        let mut all = family.attributes.iter().chain(&family.indices);
        family.is_fixed |= all.any(is_fixed)
            || !family.attributes.iter().all(|accessor| count(accessor) == first)
            || !family.indices.iter().all(is_list)
            || family.attributes.iter().any(|other| family.indices.binary_search(other).is_ok());
    }
    families.into_values().collect()
}

/// The accessors of all attributes and morph targets.
fn attributes(primitive: &Primitive) -> impl Iterator<Item = u32> {
    let targets = primitive.targets.iter().flat_map(Attributes::iter);
    primitive.attributes.iter().chain(targets).map(|(_, accessor)| accessor)
}
