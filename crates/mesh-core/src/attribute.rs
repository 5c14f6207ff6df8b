//! Typed, caller-owned data per vertex, edge, half-edge or face.
//!
//! The mesh does not know about attributes and never changes them. After edits that add elements,
//! [`AttributeMap::grow_with`] the mesh; after [`Topology::compact`], carry it over with the `Remap`
//! ([`AttributeMap::compact`]).

use core::fmt;
use core::marker::PhantomData;
use core::ops::{Index, IndexMut};

use crate::edit::compact::{Remap, RemapOf};
use crate::topology::Topology;
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, Handle, VertexId};

/// One value per element of a kind, indexed by that kind's handle.
///
/// ```
/// use mesh_core::{Topology, VertexId};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let topology = Topology::from_triangles(3, &[[0, 1, 2]])?;
/// let mut weight = topology.vertex_map(1.0);
/// weight[VertexId::new(2)] = 0.5;
/// assert_eq!(weight.as_slice(), [1.0, 1.0, 0.5]);
/// let doubled = weight.map(|w| 2.0 * w);
/// assert_eq!(format!("{doubled:?}"), "{v0: 2.0, v1: 2.0, v2: 1.0}");
/// # Ok(())
/// # }
/// ```
#[derive(Clone, PartialEq, Eq)]
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

    /// The value of an element; `None` if the map is too short.
    #[must_use]
    pub fn get(&self, handle: H) -> Option<&T> {
        self.values.get(handle.index())
    }

    /// Mutable access to the value of an element; `None` when the map is too short.
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

    /// The values in order of index, including removed elements.
    #[must_use]
    pub fn as_slice(&self) -> &[T] {
        &self.values
    }

    /// Mutable access to the values in order of index.
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
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (H, &T)> + DoubleEndedIterator + '_ {
        self.values.iter().enumerate().map(|(index, value)| (H::from_index(index), value))
    }

    /// All elements that have a value, removed ones included, with mutable access to the value.
    pub fn iter_mut(
        &mut self,
    ) -> impl ExactSizeIterator<Item = (H, &mut T)> + DoubleEndedIterator + '_ {
        self.values.iter_mut().enumerate().map(|(index, value)| (H::from_index(index), value))
    }

    /// Applies a function to all values.
    #[must_use]
    pub fn map<U>(&self, value: impl FnMut(&T) -> U) -> AttributeMap<H, U> {
        self.values.iter().map(value).collect()
    }

    /// The elements that have a value in both maps, with the two values.
    pub fn zip<'a, U>(
        &'a self,
        other: &'a AttributeMap<H, U>,
    ) -> impl ExactSizeIterator<Item = (H, &'a T, &'a U)> + 'a {
        let both = self.values.iter().zip(&other.values).enumerate();
        both.map(|(index, (a, b))| (H::from_index(index), a, b))
    }

    /// Extends the map to `capacity` values; a longer map stays as it is.
    pub fn grow(&mut self, capacity: usize, value: T)
    where
        T: Clone,
    {
        if self.values.len() < capacity {
            self.values.resize(capacity, value);
        }
    }

    /// Extends the map so that all elements of the mesh have a value.
    pub fn grow_with(&mut self, topology: &Topology, value: T)
    where
        T: Clone,
        H: Element,
    {
        self.grow(H::capacity(topology), value);
    }

    /// Sets the value of an element, and returns the previous value. A map that is too short is extended first, with
    /// default values for the elements in between.
    pub fn insert(&mut self, handle: H, value: T) -> T
    where
        T: Clone + Default,
    {
        self.grow(handle.index() + 1, T::default());
        core::mem::replace(&mut self[handle], value)
    }
}

/// An empty map, for elements of any kind.
impl<H, T> Default for AttributeMap<H, T> {
    fn default() -> Self {
        Self { values: Vec::new(), handle: PhantomData }
    }
}

/// Values in order of index.
impl<H, T> FromIterator<T> for AttributeMap<H, T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Self { values: values.into_iter().collect(), handle: PhantomData }
    }
}

/// Values of the elements that follow.
impl<H, T> Extend<T> for AttributeMap<H, T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, values: I) {
        self.values.extend(values);
    }
}

/// The elements and their values, as in `{v0: 1.0, v1: 0.5}`.
impl<H: Handle, T: fmt::Debug> fmt::Debug for AttributeMap<H, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_map().entries(self.iter()).finish()
    }
}

/// A kind of mesh element that can have attributes.
pub trait Element: Handle {
    /// One more than the largest index of such an element in a mesh.
    fn capacity(topology: &Topology) -> usize;

    /// Whether the element is in the mesh: in range and not removed.
    fn is_in(self, topology: &Topology) -> bool;
}

macro_rules! element {
    ($handle:ty, $capacity:ident, $contains:ident) => {
        impl Element for $handle {
            fn capacity(topology: &Topology) -> usize {
                topology.$capacity()
            }

            fn is_in(self, topology: &Topology) -> bool {
                topology.$contains(self)
            }
        }
    };
}

element!(VertexId, vertex_capacity, contains_vertex);
element!(EdgeId, edge_capacity, contains_edge);
element!(HalfEdgeId, half_edge_capacity, contains_half_edge);
element!(FaceId, face_capacity, contains_face);

impl<H: Element, T> AttributeMap<H, T> {
    /// A map from a function of the elements of a mesh, removed elements included.
    #[must_use]
    pub fn from_fn(topology: &Topology, value: impl FnMut(H) -> T) -> Self {
        (0..H::capacity(topology)).map(H::from_index).map(value).collect()
    }

    /// The elements of the mesh that have a value, without those that were removed.
    pub fn live<'a>(&'a self, topology: &'a Topology) -> impl Iterator<Item = (H, &'a T)> + 'a {
        self.iter().filter(|(handle, _)| handle.is_in(topology))
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
