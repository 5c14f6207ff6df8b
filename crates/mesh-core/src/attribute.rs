//! Typed, caller-owned data per vertex, edge, half-edge or face.
//!
//! The mesh does not know about attributes and never changes them. After edits that add elements,
//! [`AttributeMap::grow`] the map; after [`Topology::compact`], carry it over with the `Remap`.

use core::marker::PhantomData;
use core::ops::{Index, IndexMut};

use crate::compact::{Remap, RemapOf};
use crate::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};
use crate::topology::Topology;

/// One value per element of a kind, indexed by that kind's handle.
///
/// ```
/// use mesh_core::{Topology, VertexId};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let topology = Topology::from_triangles(3, &[[0, 1, 2]])?;
/// let mut weight = topology.vertex_map(1.0);
/// weight[VertexId::new(2)] = 0.5;
/// assert_eq!(weight.as_slice(), [1.0, 1.0, 0.5]);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttributeMap<H, T> {
    values: Vec<T>,
    handle: PhantomData<fn(H)>,
}

/// One value per vertex.
pub type VertexMap<T> = AttributeMap<VertexId, T>;
/// One value per edge.
pub type EdgeMap<T> = AttributeMap<EdgeId, T>;
/// One value per half-edge. Data of a face corner belongs to the half-edge that starts there.
pub type HalfEdgeMap<T> = AttributeMap<HalfEdgeId, T>;
/// One value per face.
pub type FaceMap<T> = AttributeMap<FaceId, T>;

impl<H: Handle, T> AttributeMap<H, T> {
    /// A map with these values, the first belonging to the element of index 0.
    #[must_use]
    pub fn from_vec(values: Vec<T>) -> Self {
        Self { values, handle: PhantomData }
    }

    /// The value of an element, or `None` when the map is too short to have one.
    #[must_use]
    pub fn get(&self, handle: H) -> Option<&T> {
        self.values.get(handle.index())
    }

    /// The value of an element to be changed, or `None` when the map is too short to have one.
    #[must_use]
    pub fn get_mut(&mut self, handle: H) -> Option<&mut T> {
        self.values.get_mut(handle.index())
    }

    /// The number of values.
    #[must_use]
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// Whether the map has no values.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// The values in order of index, those of removed elements included.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.values
    }

    /// The values in order of index, to be changed.
    #[must_use]
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// The values in order of index.
    #[must_use]
    pub fn into_vec(self) -> Vec<T> {
        self.values
    }

    /// All elements that have a value, removed ones included, with the value.
    pub fn iter(&self) -> impl Iterator<Item = (H, &T)> + '_ {
        self.values.iter().enumerate().map(|(index, value)| (H::from_index(index), value))
    }

    /// Lengthens the map to `capacity` values; a longer map stays as it is.
    pub fn grow(&mut self, capacity: usize, value: T)
    where
        T: Clone,
    {
        if self.values.len() < capacity {
            self.values.resize(capacity, value);
        }
    }
}

impl<H: Handle, T: Clone> AttributeMap<H, T> {
    /// The map for the compacted mesh: values of removed elements are gone.
    #[must_use]
    pub fn compact(&self, remap: &Remap) -> Self
    where
        Remap: RemapOf<H>,
    {
        let kept = self.iter().filter(|(handle, _)| remap.new_handle(*handle).is_some());
        Self::from_vec(kept.map(|(_, value)| value.clone()).collect())
    }
}

impl<H: Handle, T> Index<H> for AttributeMap<H, T> {
    type Output = T;

    #[inline]
    fn index(&self, handle: H) -> &T {
        &self.values[handle.index()]
    }
}

impl<H: Handle, T> IndexMut<H> for AttributeMap<H, T> {
    #[inline]
    fn index_mut(&mut self, handle: H) -> &mut T {
        &mut self.values[handle.index()]
    }
}

/// Attribute maps that fit this mesh.
impl Topology {
    /// A map with one value per vertex.
    #[must_use]
    pub fn vertex_map<T: Clone>(&self, value: T) -> VertexMap<T> {
        VertexMap::from_vec(vec![value; self.vertex_capacity()])
    }

    /// A map with one value per edge.
    #[must_use]
    pub fn edge_map<T: Clone>(&self, value: T) -> EdgeMap<T> {
        EdgeMap::from_vec(vec![value; self.edge_capacity()])
    }

    /// A map with one value per half-edge.
    #[must_use]
    pub fn half_edge_map<T: Clone>(&self, value: T) -> HalfEdgeMap<T> {
        HalfEdgeMap::from_vec(vec![value; self.half_edge_capacity()])
    }

    /// A map with one value per face.
    #[must_use]
    pub fn face_map<T: Clone>(&self, value: T) -> FaceMap<T> {
        FaceMap::from_vec(vec![value; self.face_capacity()])
    }
}
