//! Typed handles for the elements of a mesh.
//!
//! A handle is a `u32` index in a newtype, so that a vertex can never be passed where a face is
//! meant. It is stored complemented in a [`NonZeroU32`], which gives `Option<VertexId>` and its
//! siblings the size of the handle itself (four bytes) and keeps the twin of a half-edge a single
//! `xor`.

use core::cmp::Ordering;
use core::fmt;
use core::hash::Hash;
use core::num::NonZeroU32;

use crate::index::as_u32;

/// What the four handle types have in common: a dense index below [`Handle::LIMIT`].
pub trait Handle: Copy + Eq + Ord + Hash + fmt::Debug + Send + Sync + 'static {
    /// Number of distinct indices: every handle has an index below this.
    const LIMIT: usize = u32::MAX as usize - 1;

    /// The handle of the element with this index.
    ///
    /// # Panics
    /// When `index` is not below [`Handle::LIMIT`]. All functions that build meshes from input refuse so many elements
    /// before they make handles.
    fn from_index(index: usize) -> Self;

    /// The index of the element, for use in arrays.
    fn index(self) -> usize;
}

macro_rules! handle {
    ($(#[$doc:meta])* $name:ident, $letter:literal) => {
        $(#[$doc])*
        #[derive(Clone, Copy, PartialEq, Eq, Hash)]
        #[repr(transparent)]
        pub struct $name(NonZeroU32);

        impl $name {
            /// The handle of the element with this index.
            ///
            /// # Panics
            /// When `index` is `u32::MAX` or one less.
            #[inline]
            #[must_use]
            pub const fn new(index: u32) -> Self {
                // The two largest indices are kept free: the largest is the niche, the one below
                // marks removed elements inside the topology.
                assert!(index < u32::MAX - 1, "element index out of range");
                match NonZeroU32::new(!index) {
                    Some(bits) => Self(bits),
                    None => unreachable!(),
                }
            }

            /// The index as the mesh stores it.
            #[inline]
            #[must_use]
            pub const fn get(self) -> u32 {
                !self.0.get()
            }

            /// The index of the element, for use in arrays.
            #[inline]
            #[must_use]
            pub const fn index(self) -> usize {
                self.get() as usize
            }
        }

        impl Handle for $name {
            #[inline]
            fn from_index(index: usize) -> Self {
                assert!(index < Self::LIMIT, "element index out of range");
                Self::new(as_u32(index))
            }

            #[inline]
            fn index(self) -> usize {
                self.index()
            }
        }

        impl PartialOrd for $name {
            #[inline]
            fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
                Some(self.cmp(other))
            }
        }

        impl Ord for $name {
            #[inline]
            fn cmp(&self, other: &Self) -> Ordering {
                self.get().cmp(&other.get())
            }
        }

        impl fmt::Debug for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!($letter, "{}"), self.get())
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                fmt::Display::fmt(&self.get(), f)
            }
        }
    };
}

handle!(
    /// A vertex.
    VertexId, "v"
);
handle!(
    /// An edge: the pair of half-edges `2e` and `2e + 1`.
    EdgeId, "e"
);
handle!(
    /// A half-edge: one of the two directed sides of an edge.
    HalfEdgeId, "h"
);
handle!(
    /// A triangle.
    FaceId, "f"
);

impl HalfEdgeId {
    /// Marks removed elements inside the topology's arrays; never handed out.
    pub(crate) const REMOVED: Self = match NonZeroU32::new(1) {
        Some(bits) => Self(bits),
        None => unreachable!(),
    };

    /// The other half-edge of the same edge, running the other way.
    #[inline]
    #[must_use]
    pub const fn twin(self) -> Self {
        // Complementing commutes with flipping the lowest bit, and no index is so large that the
        // result would be zero.
        match NonZeroU32::new(self.0.get() ^ 1) {
            Some(bits) => Self(bits),
            None => unreachable!(),
        }
    }

    /// The edge that this half-edge is a side of.
    #[inline]
    #[must_use]
    pub const fn edge(self) -> EdgeId {
        EdgeId::new(self.get() / 2)
    }
}

impl EdgeId {
    /// The first of the edge's two half-edges, `2e`.
    #[inline]
    #[must_use]
    pub const fn half_edge(self) -> HalfEdgeId {
        HalfEdgeId::new(self.get() * 2)
    }

    /// Both half-edges of the edge.
    #[inline]
    #[must_use]
    pub const fn half_edges(self) -> [HalfEdgeId; 2] {
        [self.half_edge(), self.half_edge().twin()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_have_a_niche() {
        assert_eq!(size_of::<Option<VertexId>>(), 4);
        assert_eq!(size_of::<Option<EdgeId>>(), 4);
        assert_eq!(size_of::<Option<HalfEdgeId>>(), 4);
        assert_eq!(size_of::<Option<FaceId>>(), 4);
    }

    #[test]
    fn indices_twins_and_order() {
        for i in [0, 1, 2, 77, u32::MAX - 3] {
            assert_eq!(VertexId::new(i).get(), i);
            assert_eq!(HalfEdgeId::new(i).twin().get(), i ^ 1);
            assert_eq!(HalfEdgeId::new(i).edge().get(), i / 2);
        }
        assert!(FaceId::new(3) < FaceId::new(4));
        assert_eq!(EdgeId::new(5).half_edges(), [HalfEdgeId::new(10), HalfEdgeId::new(11)]);
        assert_eq!(HalfEdgeId::REMOVED.get(), u32::MAX - 1);
    }

    #[test]
    #[should_panic(expected = "out of range")]
    fn reserved_indices_are_refused() {
        let _ = VertexId::from_index(u32::MAX as usize);
    }
}
