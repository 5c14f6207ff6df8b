//! Circulators: iterators around a vertex and along a boundary loop.

use crate::topology::Topology;
use crate::topology::handle::{EdgeId, FaceId, HalfEdgeId, VertexId};

/// The half-edges that start at a vertex, clockwise seen from outside; made by
/// [`Topology::outgoing`].
#[derive(Clone, Debug)]
pub struct Outgoing<'a> {
    topology: &'a Topology,
    first: Option<HalfEdgeId>,
    coming: Option<HalfEdgeId>,
}

impl Iterator for Outgoing<'_> {
    type Item = HalfEdgeId;

    #[inline]
    fn next(&mut self) -> Option<HalfEdgeId> {
        let current = self.coming?;
        let following = self.topology.next(current.twin());
        self.coming = Some(following).filter(|_| Some(following) != self.first);
        Some(current)
    }
}

/// The half-edges of a boundary loop; made by [`Topology::boundary_loop`].
#[derive(Clone, Debug)]
pub struct BoundaryLoop<'a> {
    topology: &'a Topology,
    first: HalfEdgeId,
    coming: Option<HalfEdgeId>,
}

impl Iterator for BoundaryLoop<'_> {
    type Item = HalfEdgeId;

    #[inline]
    fn next(&mut self) -> Option<HalfEdgeId> {
        let current = self.coming?;
        let following = self.topology.next(current);
        self.coming = Some(following).filter(|&h| h != self.first);
        Some(current)
    }
}

/// Circulation around a vertex and along the boundary.
impl Topology {
    /// The half-edges that start at the vertex, clockwise seen from outside.
    ///
    /// At a boundary vertex the first one is the exterior half-edge, so that consecutive half-edges share a
    /// face.
    #[inline]
    #[must_use]
    pub fn outgoing(&self, vertex: VertexId) -> Outgoing<'_> {
        let first = self.half_edge_of_vertex(vertex);
        Outgoing { topology: self, first, coming: first }
    }

    /// The neighbours of the vertex, clockwise: its one-ring.
    #[inline]
    pub fn one_ring(&self, vertex: VertexId) -> impl Iterator<Item = VertexId> + Clone + '_ {
        self.outgoing(vertex).map(|h| self.target(h))
    }

    /// The edges at the vertex, clockwise.
    #[inline]
    pub fn edges_of_vertex(&self, vertex: VertexId) -> impl Iterator<Item = EdgeId> + Clone + '_ {
        self.outgoing(vertex).map(HalfEdgeId::edge)
    }

    /// The faces at the vertex, clockwise.
    #[inline]
    pub fn faces_of_vertex(&self, vertex: VertexId) -> impl Iterator<Item = FaceId> + Clone + '_ {
        self.outgoing(vertex).filter_map(|h| self.face(h))
    }

    /// The half-edges of the boundary loop that `exterior` runs along, beginning with it. The hole
    /// lies to their left. For a half-edge with a face, this is the circuit of that face.
    #[must_use]
    pub fn boundary_loop(&self, exterior: HalfEdgeId) -> BoundaryLoop<'_> {
        BoundaryLoop { topology: self, first: exterior, coming: Some(exterior) }
    }

    /// The boundary loops, each as its half-edges, with the hole to their left. They begin at the half-edges that
    /// [`boundary_loops`](Self::boundary_loops) lists.
    ///
    /// ```
    /// # use mesh_core::Topology;
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let square = Topology::from_triangles(4, &[[0, 1, 2], [0, 2, 3]])?;
    /// let lengths: Vec<usize> = square.boundaries().map(Iterator::count).collect();
    /// assert_eq!(lengths, [4]);
    /// # Ok(())
    /// # }
    /// ```
    pub fn boundaries(&self) -> impl Iterator<Item = BoundaryLoop<'_>> {
        self.boundary_loops().into_iter().map(|start| self.boundary_loop(start))
    }

    /// One exterior half-edge of every boundary loop: the one with the smallest index.
    #[must_use]
    pub fn boundary_loops(&self) -> Vec<HalfEdgeId> {
        let mut seen = vec![false; self.half_edge_capacity()];
        let mut loops = Vec::new();
        for start in self.half_edges() {
            if !self.is_exterior(start) || seen[start.index()] {
                continue;
            }
            loops.push(start);
            for h in self.boundary_loop(start) {
                seen[h.index()] = true;
            }
        }
        loops
    }
}
