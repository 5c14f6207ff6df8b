//! Closes a whole boundary loop, with triangles between its vertices or around a new vertex.

use crate::edit::links::NoRoom;
use crate::index::as_u32;
use crate::topology::Topology;
use crate::topology::handle::{FaceId, HalfEdgeId, VertexId};

/// A boundary loop that is being closed.
pub(crate) struct Ring {
    /// From each remaining vertex, the half-edge to the next one; indexed by place in the loop.
    sides: Vec<HalfEdgeId>,
    order: RingOrder,
}

impl Ring {
    /// The ring of a boundary loop of at least three half-edges.
    pub(crate) fn new(sides: Vec<HalfEdgeId>) -> Self {
        Self { order: RingOrder::new(sides.len()), sides }
    }
}

/// The vertices that remain of a loop, by place in the loop.
pub(crate) struct RingOrder {
    previous: Vec<u32>,
    next: Vec<u32>,
    left: usize,
    /// The first remaining vertex.
    first: u32,
}

impl RingOrder {
    /// A loop of at least three vertices.
    pub(crate) fn new(vertices: usize) -> Self {
        let n = as_u32(vertices);
        Self {
            previous: (0..n).map(|i| if i == 0 { n - 1 } else { i - 1 }).collect(),
            next: (0..n).map(|i| if i + 1 == n { 0 } else { i + 1 }).collect(),
            left: vertices,
            first: 0,
        }
    }

    /// The remaining places, in order.
    pub(crate) fn places(&self) -> impl Iterator<Item = u32> {
        let following = |&place: &u32| Some(self.next[place as usize]);
        core::iter::successors(Some(self.first), following).take(self.left)
    }

    /// The number of remaining vertices: at least three, or none when the loop is closed.
    pub(crate) fn left(&self) -> usize {
        self.left
    }

    /// The places before and after a remaining one.
    pub(crate) fn neighbours(&self, place: u32) -> [u32; 2] {
        [self.previous[place as usize], self.next[place as usize]]
    }

    /// Removes a vertex; of three, all.
    pub(crate) fn cut(&mut self, place: u32) {
        if self.left == 3 {
            self.left = 0;
            return;
        }
        let [before, after] = self.neighbours(place);
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
        self.first = before;
        self.left -= 1;
    }
}

impl Topology {
    /// Refuses a loop if 32-bit indices do not suffice for the elements that close it.
    pub(crate) fn check_ring(&self, vertices: usize) -> Result<(), NoRoom> {
        self.check_room(1, 2 * vertices, vertices)
    }

    /// Cuts a vertex off the ring with a triangle. The edge between its neighbours must not exist,
    /// and there must be [room](Self::check_ring).
    pub(crate) fn cut_off(&mut self, ring: &mut Ring, place: u32) -> FaceId {
        self.revision.advance();
        let [before, after] = ring.order.neighbours(place);
        let [first, second] = [before, place].map(|i| ring.sides[i as usize]);
        let third = if ring.order.left() == 3 {
            ring.sides[after as usize]
        } else {
            let third = self.push_edge(self.target(second), self.origin(first));
            ring.sides[before as usize] = third.twin();
            third
        };
        ring.order.cut(place);
        self.push_circuit([first, second, third])
    }

    /// Closes the remaining ring with a new vertex: one triangle per side.
    pub(crate) fn close_with_fan(&mut self, ring: &mut Ring) -> (VertexId, Vec<FaceId>) {
        self.revision.advance();
        let centre = self.push_vertex();
        let sides: Vec<HalfEdgeId> = ring.order.places().map(|i| ring.sides[i as usize]).collect();
        let incident_edges: Vec<HalfEdgeId> =
            sides.iter().map(|&side| self.push_edge(centre, self.origin(side))).collect();
        let faces = (0..sides.len())
            .map(|i| {
                let following = incident_edges[(i + 1) % incident_edges.len()];
                self.push_circuit([sides[i], following.twin(), incident_edges[i]])
            })
            .collect();
        self.vertex_half_edge[centre.index()] = incident_edges.first().copied();
        ring.order.left = 0;
        (centre, faces)
    }
}
