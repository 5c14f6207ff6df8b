//! The faces under a patch: those that can be reached from its base face, look to the same side,
//! and are near enough.

use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh, VertexId};

use crate::closest::closest_point;
use crate::patch::Patch;

/// Which elements were met since the last [`Marks::clear`], without clearing any array.
#[derive(Clone, Debug)]
pub(crate) struct Marks {
    round: u32,
    met_in: Vec<u32>,
}

impl Marks {
    pub(crate) fn new(count: usize) -> Self {
        Self { round: 1, met_in: vec![0; count] }
    }

    pub(crate) fn clear(&mut self) {
        self.round = self.round.wrapping_add(1);
        if self.round == 0 {
            self.met_in.fill(0);
            self.round = 1;
        }
    }

    /// Marks an element and says whether it was new.
    #[inline]
    pub(crate) fn insert(&mut self, index: usize) -> bool {
        let slot = &mut self.met_in[index];
        let new = *slot != self.round;
        *slot = self.round;
        new
    }

    #[inline]
    pub(crate) fn contains(&self, index: usize) -> bool {
        self.met_in[index] == self.round
    }
}

/// Grows regions; holds the memory for it, so that many regions cost nothing but their faces.
#[derive(Clone, Debug)]
pub(crate) struct Region {
    faces: Vec<FaceId>,
    face_marks: Marks,
    vertex_marks: Marks,
}

impl Region {
    pub(crate) fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        Self {
            faces: Vec::new(),
            face_marks: Marks::new(topology.face_capacity()),
            vertex_marks: Marks::new(topology.vertex_capacity()),
        }
    }

    /// The faces of the region that was grown last, breadth first from its base.
    pub(crate) fn faces(&self) -> &[FaceId] {
        &self.faces
    }

    /// Collects the faces that are reached from `base` over edges and faces whose normals make an
    /// angle below 90° with the patch's and that come closer than `reach` to its origin. Shows
    /// every vertex of the region to `visit` when it is first met, and stops when that breaks.
    pub(crate) fn grow(
        &mut self,
        mesh: &TriMesh,
        base: FaceId,
        patch: &Patch,
        reach: f64,
        mut visit: impl FnMut(VertexId) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        self.faces.clear();
        self.face_marks.clear();
        self.vertex_marks.clear();
        let topology = mesh.topology();
        let normal = patch.frame()[2];
        let belongs = |face: FaceId| {
            let corners = mesh.triangle(face);
            let [a, b, c] = corners;
            (b - a).cross(c - a).dot(normal) > 0.0 && is_within(patch.origin(), corners, reach)
        };
        self.face_marks.insert(base.index());
        self.faces.push(base);
        let mut next = 0;
        while let Some(&face) = self.faces.get(next) {
            next += 1;
            for h in topology.face_half_edges(face) {
                let vertex = topology.target(h);
                if self.vertex_marks.insert(vertex.index()) {
                    visit(vertex)?;
                }
                let Some(neighbour) = topology.face(h.twin()) else { continue };
                if self.face_marks.insert(neighbour.index()) && belongs(neighbour) {
                    self.faces.push(neighbour);
                }
            }
        }
        ControlFlow::Continue(())
    }
}

/// Whether a triangle has a point within this distance.
fn is_within(point: DVec3, corners: [DVec3; 3], distance: f64) -> bool {
    let square = distance * distance;
    corners.iter().any(|corner| corner.distance_squared(point) <= square)
        || closest_point(point, corners).0.distance_squared(point) <= square
}
