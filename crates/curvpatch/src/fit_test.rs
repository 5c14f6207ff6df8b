//! Errors of patches against the mesh, and the faces that a patch covers.

use core::f64::consts::{FRAC_PI_2, FRAC_PI_6};
use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::early_reject::{EarlyReject, Screening};
use crate::height_test::{HeightTest, MaxHeight, SelectWithin};
use crate::patch::Patch;
use crate::patch_errors::{FitLimits, PatchErrors};
use crate::patch_fit::PatchFit;
use crate::patch_region::PatchRegion;
use crate::point_tracer::bounded_test_points;
use crate::soa_mesh::SoaMesh;
use crate::test_points::{MeasuredFace, TEST_ANGLES, TestAngles, TestPoint, arc_ends};

/// Measures patches against a mesh. It owns scratch memory, so use one for many patches.
///
/// Errors refer to the *region* of a patch: the faces that are connected to its base face through faces
/// whose normals make an angle below 90° with the normal of the patch and that have a point over or
/// under its footprint. For distances, the region is extended by faces near the patch. A sheet of the
/// surface that is near in space but not connected in this way does not count.
#[derive(Clone, Debug)]
pub struct FitTest<'a> {
    mesh: &'a TriMesh,
    /// The region of the latest patch. Its vertices in the footprint within tolerance are selected.
    region: PatchRegion,
    /// Test points that are not within tolerance of any measured face.
    pending: Vec<TestPoint>,
    angles: TestAngles,
    early: EarlyReject,
}

impl<'a> FitTest<'a> {
    /// A test for patches of this mesh.
    #[must_use]
    pub fn new(mesh: &'a TriMesh) -> Self {
        Self {
            mesh,
            region: PatchRegion::new(mesh),
            pending: Vec::new(),
            angles: TestAngles::default(),
            early: EarlyReject::new(),
        }
    }

    /// The distances of the boundary points φ = 0°, 30°, 60° and 90° from the mesh, in model units.
    ///
    /// SN10 prints these errors, divided by the radius, for its Fig. 10. As in SN10, the angle φ is measured
    /// from the principal direction whose curvature has the larger absolute value.
    pub fn quarter_errors(&mut self, fit: &PatchFit) -> [f64; 4] {
        let [k1, k2] = fit.patch.curvatures().map(f64::abs);
        let start = if k1 >= k2 { 0.0 } else { FRAC_PI_2 };
        let angles = [0.0, 1.0, 2.0, 3.0].map(|j| start + j * FRAC_PI_6);
        let mut points = angles.map(|phi| TestPoint::new(fit.patch.point(1.0, phi)));
        let [l1, l2] = fit.patch.arcs();
        self.grow_whole(fit);
        self.region.widen(&fit.patch, 1.5 * l1.max(l2));
        self.measure(&mut points);
        points.map(|point| point.distance)
    }

    /// The full error of a patch: distances of 32 test points, and heights of the vertices in the
    /// footprint.
    ///
    /// The region extends twice the `tolerance` (model units) beyond the arcs. Errors up to that size
    /// are exact; larger ones may refer to another part of the surface. With `overhang`, test points
    /// whose closest point is on the boundary of the mesh are ignored; see [`PatchErrors::overhang`].
    pub fn full_error(&mut self, fit: &PatchFit, tolerance: f64, overhang: bool) -> PatchErrors {
        self.angles.set_count(TEST_ANGLES);
        let points: Vec<DVec3> = self.angles.full_test(&fit.patch).collect();
        let heights = self.grow_whole(fit);
        // The faces straight under the points give bounds that exclude most other faces.
        let mut points: Vec<TestPoint> = bounded_test_points(&self.region, fit, &points).collect();
        self.region.widen(&fit.patch, reach(&fit.patch, tolerance));
        self.measure(&mut points);
        let error = points.iter().map(|point| point.error(overhang)).fold(0.0, f64::max);
        let ignored = points.iter().filter(|point| point.error(overhang) < point.distance);
        let overhang = ignored.map(|point| point.distance).fold(0.0, f64::max);
        PatchErrors { points: error, heights, overhang }
    }

    /// The faces under a patch, at any distance: the faces of its region with all vertices over or under its
    /// footprint.
    pub fn faces_under(&mut self, fit: &PatchFit) -> Vec<FaceId> {
        self.grow_whole(fit);
        let in_footprint = |corner: &DVec3| {
            let local = fit.patch.to_local(*corner);
            fit.patch.contains(local.x, local.y)
        };
        let under = self.region.triangles().filter(|(_, corners)| corners.iter().all(in_footprint));
        let mut faces: Vec<FaceId> = under.map(|(face, _)| face).collect();
        faces.reverse();
        faces
    }

    /// Forgets the patches at the previous point.
    pub(crate) fn start(&mut self) {
        self.early.clear();
    }

    /// The early test of a patch; see [`EarlyReject::screen`].
    pub(crate) fn screen(&mut self, fit: &PatchFit, limits: &FitLimits) -> Screening {
        self.angles.set_count(limits.angles);
        self.early.screen(self.region.soa(), &self.angles, fit, limits)
    }

    /// See [`EarlyReject::rejects`].
    pub(crate) fn rejects_early(&mut self, fit: &PatchFit, limits: &FitLimits) -> bool {
        self.early.rejects(self.region.soa(), fit, limits)
    }

    /// See [`EarlyReject::violates_known_vertex`].
    pub(crate) fn violates_known_vertex(&self, fit: &PatchFit, limits: &FitLimits) -> bool {
        self.early.violates_known_vertex(fit, limits)
    }

    /// The mesh that sections walk on.
    pub(crate) fn soa(&self) -> &SoaMesh {
        self.region.soa()
    }

    /// Number of faces in the region of the latest patch.
    pub(crate) fn region_size(&self) -> usize {
        self.region.len()
    }

    /// Whether a patch is admissible. If so, [`FitTest::covered`] has its faces.
    pub(crate) fn accepts(&mut self, fit: &PatchFit, limits: &FitLimits) -> bool {
        let patch = &fit.patch;
        let heights = HeightTest::new(patch, limits.tolerance);
        let mut filter = SelectWithin::new(heights, limits.ends_only, &mut self.early.sample);
        let grown = self.region.grow(fit.point.face(), patch, &mut filter);
        if let ControlFlow::Break(vertex) = grown {
            self.early.record_violation(vertex);
            return false;
        }
        self.find_pending_points(fit, limits);
        self.resolve_pending_points(fit, limits)
    }

    /// The faces covered by the latest accepted patch, with their areas.
    ///
    /// All their vertices are in the footprint and within tolerance. The footprint is convex, so it
    /// contains these faces entirely.
    pub(crate) fn covered(&self) -> impl Iterator<Item = (FaceId, f64)> + '_ {
        self.region.selected_faces()
    }

    /// Collects the test points that are not within tolerance of the face straight under them.
    fn find_pending_points(&mut self, fit: &PatchFit, limits: &FitLimits) {
        let Self { pending, angles, region, .. } = self;
        pending.clear();
        let patch = &fit.patch;
        let points: Vec<DVec3> = if limits.ends_only {
            arc_ends(patch).collect()
        } else {
            angles.set_count(limits.angles);
            angles.full_test(patch).collect()
        };
        pending.extend(bounded_test_points(region, fit, &points));
        pending.retain(|point| point.distance > 1.000_001 * limits.tolerance);
    }

    /// Whether all pending points are within tolerance of the region, or are ignored overhang.
    ///
    /// The region is widened only if no face under the footprint is near enough.
    fn resolve_pending_points(&mut self, fit: &PatchFit, limits: &FitLimits) -> bool {
        let measured = self.region.len();
        self.measure_pending_points(measured, limits);
        if self.pending.is_empty() {
            return true;
        }
        self.region.widen(&fit.patch, reach(&fit.patch, limits.tolerance));
        self.measure_pending_points(self.region.len() - measured, limits);
        self.pending.iter().all(|point| point.error(limits.overhang) <= limits.tolerance)
    }

    /// Measures the pending points from the `count` faces added last, and drops those within tolerance.
    fn measure_pending_points(&mut self, count: usize, limits: &FitLimits) {
        for (face, corners) in self.region.triangles().take(count) {
            if self.pending.is_empty() {
                break;
            }
            let measured = MeasuredFace::new(self.mesh, face, corners);
            self.pending.retain_mut(|point| {
                measured.measure(point);
                point.distance > limits.tolerance
            });
        }
    }

    /// Grows the region and returns the largest height error.
    fn grow_whole(&mut self, fit: &PatchFit) -> f64 {
        let mut heights = MaxHeight::new(&fit.patch);
        let _ = self.region.grow(fit.point.face(), &fit.patch, &mut heights);
        heights.largest
    }

    /// Measures the exact distances of points from the faces of the region.
    fn measure(&self, points: &mut [TestPoint]) {
        for (face, corners) in self.region.triangles() {
            let measured = MeasuredFace::new(self.mesh, face, corners);
            for point in &mut *points {
                measured.measure(point);
            }
        }
    }
}

/// The radius of the widened region: test points are at most an arc away from the centre, and faces
/// farther than twice the tolerance from there belong to another part of the surface.
fn reach(patch: &Patch, tolerance: f64) -> f64 {
    let [l1, l2] = patch.arcs();
    l1.max(l2) + 2.0 * tolerance
}
