//! The faces that a collapse changes: all faces around the two ends of an edge.
//!
//! ```text
//!        o-----c-----o
//!       /  \  / \  /  \        a: the vertex that goes
//!      /    \/   \/    \       b: the vertex that stays, at a new place
//!     o-----a--h--b-----o      h: the half-edge from a to b
//!      \    /\   /\    /       (a, b, c), (b, a, d): the faces that vanish
//!       \  /  \ /  \  /        all others: the faces that remain, with a moved corner
//!        o-----d-----o
//! ```

use glam::DVec3;
use mesh_core::edit::LegalCollapse;
use mesh_core::{HalfEdgeId, TriMesh, VertexId};

use crate::geometry::quadric::Quadric;

/// The faces around both ends of an edge, each once, measured from the midpoint of the edge.
///
/// Costs, placements and constraints use it to evaluate a collapse.
#[derive(Clone, Copy, Debug)]
pub struct EdgePatch<'a> {
    mesh: &'a TriMesh,
    half_edge: HalfEdgeId,
    origin: DVec3,
    half: DVec3,
    faces: &'a [PatchFace],
    remaining: usize,
    border: Quadric,
    sum: Option<PatchSum>,
}

/// A face of a patch.
#[derive(Clone, Copy, Debug)]
pub struct PatchFace {
    /// The half-edge of the face from its first to its second corner.
    pub side: HalfEdgeId,
    /// The corners, counter-clockwise, relative to the midpoint of the edge. The first one is an
    /// end of the edge.
    pub corners: [DVec3; 3],
    /// The vector area, doubled.
    pub cross: DVec3,
}

/// Sums over the faces of a patch, about the midpoint of its edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PatchSum {
    /// The memoryless quadric.
    pub(crate) quadric: Quadric,
    /// The sum of the doubled vector areas.
    pub(crate) cross: DVec3,
    /// The sum of the dot products of each with a corner of its face.
    pub(crate) offset: f64,
    /// The sum of the squares of their lengths.
    pub(crate) squares: f64,
}

/// The position of the remaining vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Place {
    /// The position of the vertex that would be removed. That vertex then stays, and the other one is removed.
    Removed,
    /// The position of the vertex that would remain: it does not move.
    Kept,
    /// To this point, relative to the midpoint of the edge.
    At(DVec3),
}

/// A collapse that has been carried out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collapse {
    /// The removed vertex.
    pub removed: VertexId,
    /// The vertex that remains.
    pub kept: VertexId,
    /// The old position of the removed vertex.
    pub removed_from: DVec3,
    /// The old position of the remaining vertex.
    pub kept_from: DVec3,
    /// The new position of the remaining vertex.
    pub position: DVec3,
}

impl Collapse {
    /// The effect of a collapse that has not been carried out yet.
    pub(crate) fn new(mesh: &TriMesh, legal: &LegalCollapse, position: DVec3) -> Self {
        let (removed, kept) = (legal.removed(), legal.kept());
        let [removed_from, kept_from] = [removed, kept].map(|v| mesh.position(v));
        Self { removed, kept, removed_from, kept_from, position }
    }
}

impl PatchFace {
    /// The doubled vector area once the first corner has moved to `x`.
    #[inline]
    #[must_use]
    pub fn cross_with(&self, x: DVec3) -> DVec3 {
        (self.corners[1] - x).cross(self.corners[2] - x)
    }
}

impl<'a> EdgePatch<'a> {
    /// The patch of the edge of `half_edge`, with its faces.
    pub fn gather(
        mesh: &'a TriMesh,
        half_edge: HalfEdgeId,
        scratch: &'a mut Vec<PatchFace>,
    ) -> Self {
        Self::without_faces(mesh, half_edge).with_faces(scratch)
    }

    /// The same patch with its faces, which are collected into `scratch`.
    #[inline]
    fn with_faces(self, scratch: &'a mut Vec<PatchFace>) -> Self {
        let Self { mesh, half_edge, origin, half, .. } = self;
        let (topology, twin) = (mesh.topology(), half_edge.twin());
        scratch.clear();
        for (along, end) in [(half_edge, -half), (twin, half)] {
            // The vanishing faces: left of the edge, and left of the next edge clockwise.
            let vanishing = [along, topology.next(along.twin())];
            gather_fan(mesh, along, vanishing, origin, end, scratch);
        }
        let remaining = scratch.len();
        scratch.extend(self.vanishing_faces().into_iter().flatten());
        Self { faces: scratch, remaining, ..self }
    }

    /// The vanishing faces, whether or not the patch has its faces.
    #[inline]
    pub(crate) fn vanishing_faces(&self) -> [Option<PatchFace>; 2] {
        let Self { mesh, half_edge, origin, half, .. } = *self;
        [(half_edge, -half), (half_edge.twin(), half)].map(|(side, end)| {
            let apex = mesh.position(mesh.topology().apex(side)?) - origin;
            Some(PatchFace::new(side, [end, -end, apex]))
        })
    }

    /// The patch with only the edge and its ends.
    #[inline]
    pub(crate) fn without_faces(mesh: &'a TriMesh, half_edge: HalfEdgeId) -> Self {
        let topology = mesh.topology();
        let from = mesh.position(topology.origin(half_edge));
        let to = mesh.position(topology.target(half_edge));
        let half = 0.5 * (to - from);
        let origin = from + half;
        let border = Quadric::default();
        Self { mesh, half_edge, origin, half, faces: &[], remaining: 0, border, sum: None }
    }

    /// The same patch, with the ends of the edge exchanged.
    #[inline]
    pub fn reversed(self) -> Self {
        Self { half_edge: self.half_edge.twin(), half: -self.half, ..self }
    }

    #[inline]
    pub(crate) fn with_border(self, border: Quadric) -> Self {
        Self { border, ..self }
    }

    /// The same patch, with the sums over its faces.
    #[inline]
    pub(crate) fn with_sum(self, sum: PatchSum) -> Self {
        Self { sum: Some(sum), ..self }
    }

    /// The mesh before the collapse.
    #[must_use]
    pub fn mesh(&self) -> &'a TriMesh {
        self.mesh
    }

    /// The half-edge from the removed vertex to the remaining vertex.
    #[must_use]
    pub fn half_edge(&self) -> HalfEdgeId {
        self.half_edge
    }

    /// The vertex that the collapse removes.
    #[must_use]
    pub fn removed(&self) -> VertexId {
        self.mesh.topology().origin(self.half_edge)
    }

    /// The vertex that remains.
    #[must_use]
    pub fn kept(&self) -> VertexId {
        self.mesh.topology().target(self.half_edge)
    }

    /// The midpoint of the edge: the origin of all positions in the patch.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The two ends of the edge relative to its midpoint: the removed one, then the remaining one.
    #[inline]
    #[must_use]
    pub fn ends(&self) -> [DVec3; 2] {
        [-self.half, self.half]
    }

    /// The squared length of the edge.
    #[inline]
    #[must_use]
    pub fn squared_length(&self) -> f64 {
        4.0 * self.half.length_squared()
    }

    /// All faces of the patch; the one or two vanishing faces come last.
    #[inline]
    #[must_use]
    pub fn faces(&self) -> &'a [PatchFace] {
        self.faces
    }

    /// The remaining faces, whose first corner moves.
    #[inline]
    #[must_use]
    pub fn remaining_faces(&self) -> &'a [PatchFace] {
        &self.faces[..self.remaining]
    }

    /// The quadric of the boundary and feature edges at the two vertices, taken from the original mesh and accumulated
    /// over collapses.
    #[inline]
    #[must_use]
    pub fn border(&self) -> &Quadric {
        &self.border
    }

    /// Fills `ring` with half-edges from the ends of the edge to the neighbours of the remaining vertex, clockwise, in
    /// the order after the collapse. The left face of each half-edge except the first joins it to the one before.
    /// Returns whether the ring is closed. If not, the remaining vertex lies on the boundary, and the first half-edge
    /// has no left face.
    #[cfg(feature = "curvature")]
    pub(crate) fn merged_ring(&self, ring: &mut Vec<HalfEdgeId>) -> bool {
        let topology = self.mesh.topology();
        let (h, twin) = (self.half_edge, self.half_edge.twin());
        ring.clear();
        // From the faces of one end to the faces of the other. The common apex has been visited when the edge itself is
        // reached.
        let past_apex = |side: HalfEdgeId| topology.next(topology.next(side).twin());
        let exterior = [topology.origin(h), topology.target(h)]
            .map(|v| topology.half_edge_of_vertex(v).filter(|&e| topology.is_exterior(e)));
        let start = match exterior {
            _ if topology.is_exterior(h) => topology.next(h),
            _ if topology.is_exterior(twin) => topology.next(twin),
            [Some(first), _] | [None, Some(first)] => first,
            [None, None] => past_apex(twin),
        };
        let mut side = start;
        loop {
            ring.push(side);
            side = topology.next(side.twin());
            if (side == h || side == twin) && !topology.is_exterior(side) {
                side = past_apex(side);
            }
            if side == start || topology.is_exterior(side) {
                return exterior == [None; 2];
            }
        }
    }

    /// The area of the patch.
    #[must_use]
    pub fn area(&self) -> f64 {
        0.5 * self.faces.iter().map(|f| f.cross.length()).sum::<f64>()
    }

    /// The *memoryless* quadric (Lindstrom and Turk 1998): the sum over the faces of the patch of the area times the
    /// squared distance to the plane of the face.
    #[inline]
    #[must_use]
    pub fn face_quadric(&self) -> Quadric {
        if let Some(sum) = &self.sum {
            return sum.quadric;
        }
        let mut sum = Quadric::default();
        for face in self.faces {
            let double_area = face.cross.length();
            if double_area > 0.0 {
                let offset = face.cross.dot(face.corners[0]);
                sum += Quadric::plane(face.cross, offset, 0.5 / double_area);
            }
        }
        sum
    }

    /// The plane of all positions of the vertex that keep the volume under the patch (Lindstrom and Turk 1998), as `(g,
    /// h)` with `g·x = h`. On it, the sum over the faces of the dot products of the doubled vector area and the vector
    /// from a corner to x is zero. `None` if the vector areas of a crumpled patch cancel.
    #[inline]
    #[must_use]
    pub fn volume_plane(&self) -> Option<(DVec3, f64)> {
        let (mut cross, mut offset, mut squares) = (DVec3::ZERO, 0.0, 0.0);
        if let Some(sum) = self.sum {
            (cross, offset, squares) = (sum.cross, sum.offset, sum.squares);
        } else {
            for face in self.faces {
                cross += face.cross;
                offset += face.cross.dot(face.corners[0]);
                squares += face.cross.length_squared();
            }
        }
        (cross.length_squared() > 1e-6 * squares).then_some((cross, offset))
    }

    /// A position relative to the midpoint of the edge.
    #[inline]
    #[must_use]
    pub fn offset(&self, place: Place) -> DVec3 {
        match place {
            Place::Removed => -self.half,
            Place::Kept => self.half,
            Place::At(x) => x,
        }
    }

    /// A position in the coordinates of the mesh.
    #[inline]
    #[must_use]
    pub fn position(&self, place: Place) -> DVec3 {
        match place {
            Place::Removed => self.mesh.position(self.removed()),
            Place::Kept => self.mesh.position(self.kept()),
            Place::At(x) => self.origin + x,
        }
    }
}

/// A patch whose faces are collected on demand.
#[derive(Debug)]
pub(crate) struct LazyPatch<'a> {
    patch: EdgePatch<'a>,
    /// The buffer for the faces; `None` once they are collected.
    scratch: Option<&'a mut Vec<PatchFace>>,
}

impl<'a> LazyPatch<'a> {
    pub(crate) fn new(patch: EdgePatch<'a>, scratch: &'a mut Vec<PatchFace>) -> Self {
        Self { patch, scratch: Some(scratch) }
    }

    /// The patch in its current state.
    #[inline]
    pub(crate) fn as_is(&self) -> EdgePatch<'a> {
        self.patch
    }

    /// The patch with its faces.
    #[inline]
    pub(crate) fn with_faces(&mut self) -> EdgePatch<'a> {
        if let Some(scratch) = self.scratch.take() {
            self.patch = self.patch.with_faces(scratch);
        }
        self.patch
    }
}

impl PatchFace {
    #[inline]
    fn new(side: HalfEdgeId, corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        Self { side, corners, cross: (b - a).cross(c - a) }
    }
}

/// Collects the faces at the origin of `along`, whose position is `end`, except the faces of `vanishing`.
///
/// Every neighbour is looked up once: clockwise, the second corner of one face is the third corner of the next.
#[inline]
fn gather_fan(
    mesh: &TriMesh,
    along: HalfEdgeId,
    vanishing: [HalfEdgeId; 2],
    origin: DVec3,
    end: DVec3,
    scratch: &mut Vec<PatchFace>,
) {
    let topology = mesh.topology();
    let Some(first) = topology.half_edge_of_vertex(topology.origin(along)) else { return };
    let at = |v: VertexId| mesh.position(v) - origin;
    // Only at a boundary vertex does the first half-edge have no face.
    let (mut side, mut third) = match topology.apex(first) {
        Some(apex) => (first, at(apex)),
        None => (topology.next(first.twin()), at(topology.target(first))),
    };
    loop {
        let second = at(topology.target(side));
        if !vanishing.contains(&side) {
            scratch.push(PatchFace::new(side, [end, second, third]));
        }
        third = second;
        side = topology.next(side.twin());
        if side == first {
            break;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::{Irregular, Sphere};

    #[test]
    fn a_place_on_the_volume_plane_keeps_the_volume() {
        let soup =
            Sphere { radius: 1.0 }.irregular_icosphere(2, Irregular { jitter: 0.2, seed: 3 });
        let mesh = TriMesh::from_soup(&soup.unwrap()).unwrap();
        let volume = mesh.volume();
        let mut faces = Vec::new();
        for edge in mesh.topology().edges().step_by(7) {
            let patch = EdgePatch::gather(&mesh, edge.half_edge(), &mut faces);
            let (normal, offset) = patch.volume_plane().unwrap();
            let foot = offset / normal.length_squared() * normal;
            let length = patch.squared_length().sqrt();
            for along in [DVec3::ZERO, length * normal.normalize().any_orthonormal_vector()] {
                let place = patch.position(Place::At(foot + along));
                let mut collapsed = mesh.clone();
                let legal = collapsed.topology().check_collapse(patch.half_edge()).unwrap();
                collapsed.collapse(legal, place);
                assert!((collapsed.volume() - volume).abs() < 1e-12, "{edge:?}");
            }
        }
    }

    /// Two pyramids on one square. Around a side of it the doubled areas have the sum (2h, 2h, 0), and their squares
    /// the sum 6 (1 + 2h²).
    #[test]
    fn a_patch_whose_areas_cancel_has_no_volume_plane() {
        let has_plane = |h: f64| {
            let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, h]);
            let points = [x, y, z].map(|p| [p, p.map(|c| -c)]).concat();
            let upper = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4]];
            let lower = upper.map(|[a, b, _]| [b, a, 5]);
            let mesh = TriMesh::from_triangles(&points, &[upper, lower].concat()).unwrap();
            let [a, b] = [0, 2].map(VertexId::new);
            let mut edges = mesh.topology().edges_of_vertex(a);
            let side = edges.find(|&e| mesh.topology().edge_vertices(e).contains(&b)).unwrap();
            EdgePatch::gather(&mesh, side.half_edge(), &mut Vec::new()).volume_plane().is_some()
        };
        assert!(has_plane(1.0) && has_plane(0.9e-3));
        assert!(!has_plane(0.8e-3) && !has_plane(1e-9));
    }
}
