//! The quadrilateral around an edge.

use mesh_core::{EdgeId, HalfEdgeId, Topology, VertexId};

/// An interior edge and the quadrilateral of its two triangles.
///
/// ```text
///            c
///          / ^ \
///    [1] v   |   ^ [0]        the edge runs from a to b, half-edge 2e;
///      a ----+---> b          flipped, it joins c and d.
///    [2] v   |   ^ [3]        sides[0..4]: b->c, c->a, a->d, d->b
///          \   /
///            d
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Quad {
    /// The edge.
    pub edge: EdgeId,
    /// `[a, b, c, d]`: the edge runs from `a` to `b`; `c` is the left apex, `d` the right apex.
    pub corners: [VertexId; 4],
    /// The other half-edges of the two triangles: `b -> c`, `c -> a`, `a -> d`, `d -> b`.
    pub sides: [HalfEdgeId; 4],
}

impl Quad {
    /// The quadrilateral around an edge; `None` for a boundary edge.
    #[inline]
    #[must_use]
    pub fn around(topology: &Topology, edge: EdgeId) -> Option<Self> {
        let [h, twin] = edge.half_edges();
        if topology.is_exterior(h) || topology.is_exterior(twin) {
            return None;
        }
        let (bc, ad) = (topology.next(h), topology.next(twin));
        let (ca, db) = (topology.next(bc), topology.next(ad));
        let [a, b] = [topology.target(twin), topology.target(h)];
        let corners = [a, b, topology.target(bc), topology.target(ad)];
        Some(Self { edge, corners, sides: [bc, ca, ad, db] })
    }

    /// The two triangles before the flip.
    #[inline]
    #[must_use]
    pub fn triangles(&self) -> [[VertexId; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[a, b, c], [b, a, d]]
    }

    /// The two triangles after the flip.
    #[inline]
    #[must_use]
    pub fn flipped_triangles(&self) -> [[VertexId; 3]; 2] {
        let [a, b, c, d] = self.corners;
        [[a, d, c], [d, b, c]]
    }
}
