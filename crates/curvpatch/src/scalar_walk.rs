//! Walk along one normal section: the polygon in which a plane through a point cuts the mesh.
//!
//! Each vertex is on one side of the plane; a vertex *in* the plane counts as above it. A triangle with
//! vertices on both sides then has exactly two crossed edges. The walk needs no special cases: a vertex
//! in the plane costs some steps of length zero through its fan.

use glam::DVec3;
use mesh_core::{FaceId, HalfEdgeId, TriMesh, VertexId};

use crate::section_arc::{SectionArc, WalkEnd, max_steps};
use crate::section_plane::{SectionPlane, SignedVertex};

/// A walk in a face, with the edge through which the section leaves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ScalarWalk<'a> {
    mesh: &'a TriMesh,
    plane: SectionPlane,
    start: FaceId,
    face: FaceId,
    /// The half-edge of `face` through which the section leaves.
    exit: HalfEdgeId,
    from: SignedVertex,
    to: SignedVertex,
    steps_left: usize,
}

impl<'a> ScalarWalk<'a> {
    /// The walks along both halves of a section, forward first.
    ///
    /// `None` when rounding puts all three vertices on one side of the plane. This needs a triangle of
    /// nearly zero height.
    pub(crate) fn both_ways(
        mesh: &'a TriMesh,
        start: FaceId,
        plane: &SectionPlane,
    ) -> Option<[Self; 2]> {
        let topology = mesh.topology();
        let half_edges = topology.face_half_edges(start);
        let signed = half_edges.map(|h| signed_vertex(mesh, plane, topology.origin(h)));
        let mut exits = (0..3).filter_map(|i| {
            let (from, to) = (signed[i], signed[(i + 1) % 3]);
            (from.is_above() != to.is_above()).then(|| Self {
                mesh,
                plane: *plane,
                start,
                face: start,
                exit: half_edges[i],
                from,
                to,
                steps_left: max_steps(topology.face_count()),
            })
        });
        let (first, second) = (exits.next()?, exits.next()?);
        let ahead = |walk: &Self| walk.crossing().dot(plane.tangent);
        Some(if ahead(&first) >= ahead(&second) { [first, second] } else { [second, first] })
    }

    /// The current face.
    pub(crate) fn face(&self) -> FaceId {
        self.face
    }

    /// The point where the section leaves the face, relative to the origin of the section.
    #[inline]
    pub(crate) fn crossing(&self) -> DVec3 {
        SignedVertex::crossing(&self.from, &self.to)
    }

    /// Moves to the next face.
    #[inline]
    pub(crate) fn step(&mut self) -> Result<(), WalkEnd> {
        let topology = self.mesh.topology();
        let entry = self.exit.twin();
        let Some(face) = topology.face(entry) else { return Err(WalkEnd::Boundary) };
        if face == self.start {
            return Err(WalkEnd::Returned);
        }
        if self.steps_left == 0 {
            return Err(WalkEnd::StepLimit);
        }
        self.steps_left -= 1;
        self.face = face;
        // The old face has the edge as `from` - `to`. The new face has it reversed, followed by
        // `from` - `apex` and `apex` - `to`.
        let second = topology.next(entry);
        let apex = signed_vertex(self.mesh, &self.plane, topology.target(second));
        if apex.is_above() == self.from.is_above() {
            self.exit = topology.next(second);
            self.from = apex;
        } else {
            self.exit = second;
            self.to = apex;
        }
        Ok(())
    }

    /// Follows the section for a length.
    #[inline]
    pub(crate) fn arc(mut self, length: f64) -> SectionArc {
        let mut walked = 0.0;
        let mut last = DVec3::ZERO;
        loop {
            let ahead = self.crossing() - last;
            let step = ahead.length();
            if walked + step >= length {
                return SectionArc::full(length, walked, last, ahead, step);
            }
            walked += step;
            last += ahead;
            if let Err(cause) = self.step() {
                return SectionArc { end: last, length: walked, cut_short: Some(cause) };
            }
        }
    }
}

#[inline]
fn signed_vertex(mesh: &TriMesh, plane: &SectionPlane, vertex: VertexId) -> SignedVertex {
    SignedVertex::new(mesh.position(vertex), plane.origin, plane.across)
}
