//! What keeps collapses within a distance of the original, as far as points tell.
//!
//! Every vertex of the original belongs to a face of the mesh that is close enough to it. A collapse
//! is allowed when the points of the faces that it changes find close enough ones among these faces
//! again, and when these faces, at a few points, are close enough to the original.

use core::cell::Cell;

use glam::DVec3;
use mesh_core::TriMesh;
use mesh_metric::{CertifyOptions, Surface, SurfaceError, closest_on_triangle, one_sided_bounds};

use crate::collapse::patch::{Collapse, EdgePatch, Place};
use crate::collapse::placement::{Optimal, Placement};
use crate::collapse::policy::{Policy, Scratch};
use crate::collapse::quadric::Quadric;
use crate::collapse::refusal::Refusal;
use crate::finish::face_lists::FaceLists;

/// The points and where they belong.
pub(crate) struct Tether<'a> {
    original: &'a Surface,
    points: &'a [DVec3],
    limit: f64,
    /// The points of each face.
    lists: FaceLists,
    /// The points of the patch that is about to be collapsed.
    loose: Vec<u32>,
}

/// The pieces of faces to look at before a collapse counts as too far.
const MAX_PIECES: usize = 3000;

impl<'a> Tether<'a> {
    pub(crate) fn new(
        mesh: &TriMesh,
        original: &'a Surface,
        points: &'a [DVec3],
        limit: f64,
    ) -> Result<Self, SurfaceError> {
        let mut lists = FaceLists::new(mesh.topology().face_capacity());
        for (point, closest) in Surface::new(mesh)?.closest_points(points).iter().enumerate() {
            lists.push(closest.face, point as u32);
        }
        Ok(Self { original, points, limit, lists, loose: Vec::new() })
    }

    /// Whether everything stays within the limit when the edge is collapsed to `x`, relative to its
    /// midpoint.
    fn holds(&self, patch: &EdgePatch<'_>, x: DVec3) -> bool {
        let topology = patch.mesh().topology();
        let squared = self.limit * self.limit;
        let remaining = patch.remaining_faces();
        let triangles = || remaining.iter().map(|face| [x, face.corners[1], face.corners[2]]);
        // Points of the same face are often close to the same triangle.
        let last = Cell::new([x; 3]);
        let is_close = |point: u32| {
            let at = self.points[point as usize] - patch.origin();
            let reaches = |t: &[DVec3; 3]| closest_on_triangle(at, t).length_squared() <= squared;
            reaches(&last.get())
                || triangles().any(|t| {
                    reaches(&t) && {
                        last.set(t);
                        true
                    }
                })
        };
        let mut faces = patch.faces().iter().filter_map(|face| topology.face(face.side));
        if !faces.all(|face| self.lists.of_face(face).all(is_close)) {
            return false;
        }
        if self.original.distance(patch.origin() + x) > self.limit {
            return false;
        }
        let inner = triangles().flat_map(|[x, a, b]| [0.5 * (x + a), (x + a + b) / 3.0]);
        let inner: Vec<DVec3> = inner.map(|at| patch.origin() + at).collect();
        self.original.distances(&inner).into_iter().all(|distance| distance <= self.limit)
    }
}

impl Tether<'_> {
    /// Whether no point of the faces that remain is beyond the limit.
    fn is_proved(&self, patch: &EdgePatch<'_>, x: DVec3) -> bool {
        let mut places = vec![patch.origin() + x];
        let mut triangles = Vec::new();
        for face in patch.remaining_faces() {
            let [_, a, b] = face.corners.map(|corner| patch.origin() + corner);
            places.extend([a, b]);
            let last = places.len() as u32 - 1;
            triangles.push([0, last - 1, last]);
        }
        let Ok(surface) = Surface::from_triangles(&places, &triangles) else { return false };
        let options = CertifyOptions {
            limit: Some(self.limit),
            max_pieces: MAX_PIECES,
            ..CertifyOptions::default()
        };
        one_sided_bounds(&surface, self.original, &options).upper <= self.limit
    }
}

impl Policy for Tether<'_> {
    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let faces = || mesh.topology().faces_of_vertex(collapse.kept);
        faces().for_each(|face| self.lists.clear(face));
        for &point in &self.loose {
            let at = self.points[point as usize];
            let squared = |f| closest_on_triangle(at, &mesh.triangle(f)).length_squared();
            if let Some((_, face)) =
                faces().map(|f| (squared(f), f)).min_by(|p, q| p.0.total_cmp(&q.0))
            {
                self.lists.push(face, point);
            }
        }
    }
}

impl Placement for Tether<'_> {
    /// The first of several places that holds; the best by the quadric when none does.
    fn place(
        &self,
        patch: &EdgePatch<'_>,
        quadric: Option<&Quadric>,
        cost: &mut dyn FnMut(DVec3) -> f64,
    ) -> Place {
        let best = Optimal { keep_volume: true }.place(patch, quadric, cost);
        let places = [best, Place::Kept, Place::Removed];
        places.into_iter().find(|&place| self.holds(patch, patch.offset(place))).unwrap_or(best)
    }

    fn check(&self, patch: &EdgePatch<'_>, x: DVec3) -> Result<(), Refusal> {
        let is_tied = self.holds(patch, x) && self.is_proved(patch, x);
        if is_tied { Ok(()) } else { Err(Refusal::Distance) }
    }

    fn collapsing(&mut self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) {
        let topology = patch.mesh().topology();
        self.loose.clear();
        for face in patch.faces().iter().filter_map(|face| topology.face(face.side)) {
            self.loose.extend(self.lists.of_face(face));
        }
    }
}
