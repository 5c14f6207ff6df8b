//! Early decisions about a patch, without a visit to all faces under it.

use glam::DVec3;

use crate::height_test::HeightTest;
use crate::patch_errors::FitLimits;
use crate::patch_fit::PatchFit;
use crate::point_tracer::{Under, VertexCheck, distance_to_face, trace_points};
use crate::soa_mesh::SoaMesh;
use crate::test_points::TestAngles;

/// The result of an early test.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Screening {
    /// The patch is not admissible.
    Rejected,
    /// Everything tested is within tolerance.
    Likely,
    /// A test point is not within tolerance of the face straight under it. A nearer face may exist. Test
    /// points beyond the boundary do not count where overhang is allowed.
    Undecided,
}

/// Results of earlier patches at the same point.
#[derive(Clone, Debug)]
pub(crate) struct EarlyReject {
    /// The directions of [`EarlyReject::rejects`].
    directions: TestAngles,
    /// Vertices out of tolerance of earlier patches, the latest last.
    violating_vertices: Vec<DVec3>,
    /// A sample of the vertices of the largest region so far.
    pub(crate) sample: Vec<DVec3>,
}

/// Number of directions in which a large patch is tested before its region is grown.
const DIRECTIONS: u32 = 64;

/// Number of violating vertices that are kept.
const MAX_VIOLATING: usize = 8;

impl EarlyReject {
    pub(crate) fn new() -> Self {
        Self {
            directions: TestAngles::new(DIRECTIONS),
            violating_vertices: Vec::new(),
            sample: Vec::new(),
        }
    }

    /// Forgets the patches at the previous point.
    pub(crate) fn clear(&mut self) {
        self.violating_vertices.clear();
        self.sample.clear();
    }

    /// Tests a patch at the given angles only.
    ///
    /// Tested are the violating vertices of earlier patches, the vertices along sections to the boundary
    /// points, the faces straight under these points, and a sample of the vertices of earlier regions.
    pub(crate) fn screen(
        &mut self,
        soa: &SoaMesh,
        angles: &TestAngles,
        fit: &PatchFit,
        limits: &FitLimits,
    ) -> Screening {
        if limits.ends_only {
            return Screening::Undecided;
        }
        if self.violates_known_vertex(fit, limits) {
            return Screening::Rejected;
        }
        let patch = &fit.patch;
        let test = HeightTest::new(patch, limits.tolerance);
        let points: Vec<DVec3> = angles.ring(patch, 1.0).collect();
        let traced = trace_points(soa, fit, &points, VertexCheck::Any(&test));
        if traced.violation.is_some() {
            return Screening::Rejected;
        }
        let is_within = |(&local, under): (&DVec3, Under)| match under {
            Under::Face(face) => {
                distance_to_face(patch.to_world(local), soa, face) <= limits.tolerance
            }
            Under::Beyond(_) => limits.overhang,
            Under::Unknown => false,
        };
        let is_likely = points.iter().zip(traced.under).all(is_within);
        if let Some(&vertex) = self.sample.iter().find(|&&at| test.is_violated_by(at)) {
            self.record_violation(vertex);
            return Screening::Rejected;
        }
        if is_likely { Screening::Likely } else { Screening::Undecided }
    }

    /// Whether a vertex along one of 64 sections is out of tolerance. Cheaper than growing a large
    /// region up to that vertex.
    pub(crate) fn rejects(&mut self, soa: &SoaMesh, fit: &PatchFit, limits: &FitLimits) -> bool {
        if limits.ends_only {
            return false;
        }
        let test = HeightTest::new(&fit.patch, limits.tolerance);
        let points: Vec<DVec3> = self.directions.ring(&fit.patch, 1.0).collect();
        let traced = trace_points(soa, fit, &points, VertexCheck::First(&test));
        let violation = traced.violation.map(|(_, apex)| fit.patch.origin() + apex);
        if let Some(vertex) = violation {
            self.record_violation(vertex);
        }
        violation.is_some()
    }

    /// Stores a vertex that is out of tolerance of a patch.
    pub(crate) fn record_violation(&mut self, vertex: DVec3) {
        if self.violating_vertices.len() == MAX_VIOLATING {
            self.violating_vertices.remove(0);
        }
        self.violating_vertices.push(vertex);
    }

    /// Whether a violating vertex of an earlier patch is out of tolerance of this one, too.
    pub(crate) fn violates_known_vertex(&self, fit: &PatchFit, limits: &FitLimits) -> bool {
        let test = HeightTest::new(&fit.patch, limits.tolerance);
        self.violating_vertices.iter().rev().any(|&at| test.is_violated_by(at))
    }
}
