//! Measuring patches against the mesh: errors, and the faces that a patch may stand for.

use core::f64::consts::{FRAC_PI_6, TAU};
use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::closest::{Feature, closest_point};
use crate::fit::PatchFit;
use crate::height_bracket::HeightBracket;
use crate::patch::Patch;
use crate::region::Region;
use crate::section::{SectionPlane, SectionWalk, WalkEnd};

/// How far a patch and the mesh are apart, in model units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchErrors {
    /// The largest distance of a test point of the patch from the mesh, over 16 angles halfway out
    /// and on the boundary.
    pub points: f64,
    /// The largest height of a mesh vertex over or under the patch, measured along the patch's
    /// normal, over the vertices in its footprint.
    pub heights: f64,
}

impl PatchErrors {
    /// The larger of the two.
    #[must_use]
    pub fn max(&self) -> f64 {
        self.points.max(self.heights)
    }
}

/// What a patch has to keep to be accepted.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Limits {
    pub(crate) tolerance: f64,
    /// Whether test points that lie beyond the boundary of the mesh are ignored.
    pub(crate) overhang: bool,
    /// At how many angles the full test looks.
    pub(crate) angles: u32,
    /// Whether only the ends of the two principal arcs are tested, and vertices are not.
    pub(crate) ends_only: bool,
}

/// What a look at a patch along some sections tells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Verdict {
    /// It does not keep its limits.
    Fails,
    /// All that was looked at is within tolerance.
    Likely,
    /// A test point is not within tolerance of what is straight under it, which says nothing yet. One
    /// beyond the boundary, where that is allowed, does not count.
    Open,
}

/// Angles of the full test, unless asked for otherwise.
pub(crate) const TEST_ANGLES: u32 = 16;

/// A test point and what is known about its distance from the mesh.
#[derive(Clone, Copy, Debug)]
struct TestPoint {
    at: DVec3,
    distance: f64,
    /// The distance of the nearest face that is nearest on the boundary of the mesh.
    to_boundary: f64,
}

impl TestPoint {
    fn new(at: DVec3) -> Self {
        Self { at, distance: f64::INFINITY, to_boundary: f64::INFINITY }
    }

    /// A point that is as near to the boundary as to anything is beyond it, in whatever order the faces were
    /// measured: the boundary may lie on another sheet of the surface.
    fn error(&self, overhang: bool) -> f64 {
        let is_beyond = self.to_boundary <= AS_NEAR * self.distance;
        if overhang && is_beyond { 0.0 } else { self.distance }
    }
}

/// Measures patches against a mesh. Holds memory for it, so make one and use it often.
///
/// Heights and distances are those of the *region* of a patch: the faces that can be reached from its
/// base face over others that do not turn away from its normal and have a point over or under its
/// footprint; for distances also those that can be reached from there and come within its reach. A fold
/// of the surface that happens to pass by does not count.
#[derive(Clone, Debug)]
pub struct PatchProbe<'a> {
    mesh: &'a TriMesh,
    /// Of its vertices, those in the footprint that are within tolerance are picked.
    region: Region,
    pending: Vec<TestPoint>,
    turns: Turns,
    /// The directions that [`PatchProbe::scout`] looks in.
    scouts: Turns,
    /// Vertices that were out of tolerance of patches at the same point, the last one last.
    witnesses: Vec<DVec3>,
    /// Some of the vertices of the largest region that was grown for patches at the same point.
    sample: Vec<DVec3>,
}

impl<'a> PatchProbe<'a> {
    /// A probe for patches of this mesh.
    #[must_use]
    pub fn new(mesh: &'a TriMesh) -> Self {
        Self {
            mesh,
            region: Region::new(mesh),
            pending: Vec::new(),
            turns: Turns::default(),
            scouts: Turns::new(SCOUTS),
            witnesses: Vec::new(),
            sample: Vec::new(),
        }
    }

    /// The distances of four boundary points from the mesh, at φ = 0°, 30°, 60° and 90°: the
    /// errors that SN10 prints for its Fig. 10, there divided by the radius.
    pub fn quarter_errors(&mut self, fit: &PatchFit) -> [f64; 4] {
        let angles = [0.0, 1.0, 2.0, 3.0].map(|j| j * FRAC_PI_6);
        let mut points = angles.map(|phi| TestPoint::new(fit.patch.point(1.0, phi)));
        let [l1, l2] = fit.patch.arcs();
        self.grow_whole(fit);
        self.region.widen(&fit.patch, 1.5 * l1.max(l2));
        self.measure(&mut points);
        points.map(|point| point.distance)
    }

    /// The full error of a patch: test points halfway out and on the boundary, and the heights of
    /// the vertices in the footprint.
    ///
    /// The region reaches twice the `tolerance` (model units) farther from the centre than the
    /// arcs: errors up to there are exact, and what lies beyond is another part of the surface.
    /// With `overhang`, test points whose nearest point of the mesh is on its boundary are ignored.
    pub fn full_error(&mut self, fit: &PatchFit, tolerance: f64, overhang: bool) -> PatchErrors {
        self.turns.set(TEST_ANGLES);
        let mut points: Vec<TestPoint> = self
            .turns
            .full_test(&fit.patch)
            .map(|local| TestPoint::new(fit.patch.to_world(local)))
            .collect();
        let heights = self.grow_whole(fit);
        self.region.widen(&fit.patch, reach(&fit.patch, tolerance));
        self.measure(&mut points);
        let points = points.iter().map(|point| point.error(overhang)).fold(0.0, f64::max);
        PatchErrors { points, heights }
    }

    /// The faces under a patch, whatever their distance from it: those of its region that have all
    /// vertices in its footprint.
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

    /// Forgets what it knows about patches at another point.
    pub(crate) fn start(&mut self) {
        self.witnesses.clear();
        self.sample.clear();
    }

    /// What can be told of a patch without looking at all of the faces under it: it fails when a
    /// vertex that another patch at the point has failed by is out of tolerance of this one, too, or a
    /// vertex along a section to a test point on its boundary, if the section leads there through faces
    /// of the region, or one of a sample of the regions so far.
    pub(crate) fn screen(&mut self, fit: &PatchFit, limits: &Limits) -> Verdict {
        if limits.ends_only {
            return Verdict::Open;
        }
        if self.is_ruled_out(fit, limits) {
            return Verdict::Fails;
        }
        let Self { mesh, turns, .. } = self;
        let patch = &fit.patch;
        let heights = Heights::new(patch, limits.tolerance);
        turns.set(limits.angles);
        let mut verdict = Verdict::Likely;
        for local in turns.ring(patch, 1.0) {
            let mut in_region = true;
            let mut is_bad = false;
            let under = follow(mesh, fit, local, |walk, is_upward| {
                in_region &= is_upward;
                is_bad = in_region && heights.place_of(walk.apex()) == Place::Beyond;
                !is_bad
            });
            if is_bad {
                return Verdict::Fails;
            }
            let is_fine = match under {
                Under::Face(face) => {
                    distance(patch.to_world(local), mesh, face) <= limits.tolerance
                }
                Under::Beyond(_) => limits.overhang,
                Under::Unknown => false,
            };
            if !is_fine {
                verdict = Verdict::Open;
            }
        }
        let is_bad = |at: &&DVec3| heights.place(**at) == Place::Beyond;
        if let Some(&witness) = self.sample.iter().find(is_bad) {
            self.testify(witness);
            return Verdict::Fails;
        }
        verdict
    }

    /// Whether a vertex along one of many sections is out of tolerance of a patch, which takes less than
    /// growing a large region to there.
    pub(crate) fn scout(&mut self, fit: &PatchFit, limits: &Limits) -> bool {
        if limits.ends_only {
            return false;
        }
        let heights = Heights::new(&fit.patch, limits.tolerance);
        let witness = self.scouts.ring(&fit.patch, 1.0).find_map(|local| {
            let mut witness = None;
            follow(self.mesh, fit, local, |walk, is_upward| {
                if is_upward && heights.place_of(walk.apex()) == Place::Beyond {
                    witness = Some(fit.patch.origin() + walk.apex());
                }
                is_upward && witness.is_none()
            });
            witness
        });
        if let Some(witness) = witness {
            self.testify(witness);
        }
        witness.is_some()
    }

    /// Notes a vertex that is out of tolerance of a patch.
    fn testify(&mut self, witness: DVec3) {
        if self.witnesses.len() == WITNESSES {
            self.witnesses.remove(0);
        }
        self.witnesses.push(witness);
    }

    /// Whether a vertex that another patch at the point has failed by is out of tolerance of this
    /// one, too.
    pub(crate) fn is_ruled_out(&self, fit: &PatchFit, limits: &Limits) -> bool {
        let heights = Heights::new(&fit.patch, limits.tolerance);
        let mut newest_first = self.witnesses.iter().rev();
        newest_first.any(|&at| heights.place(at) == Place::Beyond)
    }

    /// How many faces the patch that was tested last has in its region.
    pub(crate) fn region_size(&self) -> usize {
        self.region.len()
    }

    /// Whether a patch keeps its limits; if so, [`PatchProbe::covered`] has its faces.
    pub(crate) fn accepts(&mut self, fit: &PatchFit, limits: &Limits) -> bool {
        if let ControlFlow::Break(witness) = self.grow_within(fit, limits) {
            self.testify(witness);
            return false;
        }
        self.look_under_test_points(fit, limits);
        self.settle(fit, limits)
    }

    /// The faces whose vertices all lie in the footprint of the patch that was accepted last and
    /// within tolerance of it. The footprint is convex, so it has the whole of these faces.
    pub(crate) fn covered(&self) -> impl Iterator<Item = FaceId> + '_ {
        self.region.picked_faces()
    }

    /// Leaves in `pending` the test points that are not within tolerance of the face that the section in
    /// their direction leads to, straight under them or at the boundary, if that is of the region. The
    /// nearest face is not farther than their distance is then.
    fn look_under_test_points(&mut self, fit: &PatchFit, limits: &Limits) {
        let Self { mesh, pending, turns, region, .. } = self;
        pending.clear();
        let patch = &fit.patch;
        let test = |local: DVec3| {
            let at = patch.to_world(local);
            let mut point = TestPoint::new(at);
            if let Under::Face(face) | Under::Beyond(face) = follow(mesh, fit, local, |_, _| true)
                && region.contains(face)
            {
                // Only what is nearer needs a look, and this face itself.
                point.distance = 1.000_001 * distance(at, mesh, face);
            }
            if point.distance > 1.000_001 * limits.tolerance {
                pending.push(point);
            }
        };
        if limits.ends_only {
            arc_ends(patch).for_each(test);
        } else {
            turns.set(limits.angles);
            turns.full_test(patch).for_each(test);
        }
    }

    /// Whether all pending points are within tolerance of the region, or beyond the boundary where
    /// that is allowed. Only where no face over or under the footprint is near enough does the region
    /// have to be widened.
    fn settle(&mut self, fit: &PatchFit, limits: &Limits) -> bool {
        let measured = self.region.len();
        self.drop_settled(measured, limits);
        if self.pending.is_empty() {
            return true;
        }
        self.region.widen(&fit.patch, reach(&fit.patch, limits.tolerance));
        self.drop_settled(self.region.len() - measured, limits);
        self.pending.iter().all(|point| point.error(limits.overhang) <= limits.tolerance)
    }

    /// Measures the pending points from so many faces of the region, the last ones, and drops those that
    /// are within tolerance.
    fn drop_settled(&mut self, faces: usize, limits: &Limits) {
        for (face, corners) in self.region.triangles().take(faces) {
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

    /// Grows the region and picks the vertices of the footprint; breaks at the first one that is
    /// out of tolerance.
    fn grow_within(&mut self, fit: &PatchFit, limits: &Limits) -> ControlFlow<DVec3> {
        let patch = &fit.patch;
        let heights = Heights::new(patch, limits.tolerance);
        let Self { region, sample, .. } = self;
        let mut met = 0;
        region.grow(fit.point.face(), patch, |local| {
            met += 1;
            // Regions at one point begin with nearly the same vertices.
            if met / SAMPLED > sample.len() {
                sample.push(patch.to_world(local));
            }
            match heights.place_of_local(local) {
                Place::Within => ControlFlow::Continue(true),
                Place::Beyond if !limits.ends_only => ControlFlow::Break(()),
                Place::Beyond | Place::Outside => ControlFlow::Continue(false),
            }
        })
    }

    /// Grows the region and returns the largest height error.
    fn grow_whole(&mut self, fit: &PatchFit) -> f64 {
        let patch = &fit.patch;
        let mut heights = 0.0_f64;
        let _ = self.region.grow(fit.point.face(), patch, |local| {
            heights = heights.max(height_error(patch, local).unwrap_or(0.0));
            ControlFlow::Continue(false)
        });
        heights
    }

    /// The exact distances of points from the faces of the region.
    fn measure(&self, points: &mut [TestPoint]) {
        for (face, corners) in self.region.triangles() {
            let measured = MeasuredFace::new(self.mesh, face, corners);
            for point in &mut *points {
                measured.measure(point);
            }
        }
    }
}

/// A face that distances are measured from.
struct MeasuredFace<'a> {
    mesh: &'a TriMesh,
    face: FaceId,
    corners: [DVec3; 3],
    /// The square of how far the other corners are from the first at most.
    square_size: f64,
}

impl<'a> MeasuredFace<'a> {
    fn new(mesh: &'a TriMesh, face: FaceId, corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let square_size = a.distance_squared(b).max(a.distance_squared(c));
        Self { mesh, face, corners, square_size }
    }

    /// Notes in the point how far it is from here, if nothing nearer has been measured.
    #[inline]
    fn measure(&self, point: &mut TestPoint) {
        // The square of a sum is at most twice the sum of the squares; and a bit for rounding, and for
        // a boundary that is as near.
        let square_reach = 2.000_001 * (point.distance * point.distance + self.square_size);
        if point.at.distance_squared(self.corners[0]) > square_reach {
            return;
        }
        let (closest, feature) = closest_point(point.at, self.corners);
        let distance = closest.distance(point.at);
        point.distance = point.distance.min(distance);
        if distance < point.to_boundary && self.is_on_boundary(feature) {
            point.to_boundary = distance;
        }
    }

    fn is_on_boundary(&self, feature: Feature) -> bool {
        let (topology, face) = (self.mesh.topology(), self.face);
        match feature {
            Feature::Corner(i) => topology.is_boundary_vertex(topology.face_vertices(face)[i]),
            Feature::Side(i) => topology.is_boundary_edge(topology.face_half_edges(face)[i].edge()),
            Feature::Inside => false,
        }
    }
}

/// A boundary is as near as the surface up to rounding.
const AS_NEAR: f64 = 1.0 + 1e-12;

/// In how many directions a large patch is looked over before its region is grown.
const SCOUTS: u32 = 64;

/// How many vertices that patches have failed by are asked again.
const WITNESSES: usize = 8;

/// One in so many vertices of a region is asked again by a first look.
const SAMPLED: usize = 16;

/// How far a section may come back in a fold, as a share of its length.
const DEEPEST_FOLD: f64 = 0.1;

/// How far the widened region of a patch goes: test points are not farther out than the arcs are long,
/// and beyond twice the tolerance from there is another part of the surface.
fn reach(patch: &Patch, tolerance: f64) -> f64 {
    let [l1, l2] = patch.arcs();
    l1.max(l2) + 2.0 * tolerance
}

/// Where a point is, as seen from a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Not over or under the footprint.
    Outside,
    /// Within tolerance of the patch.
    Within,
    /// Farther over or under it.
    Beyond,
}

/// The heights of a patch, for looking at many points.
struct Heights<'p> {
    patch: &'p Patch,
    bracket: Option<HeightBracket>,
    tolerance: f64,
}

impl<'p> Heights<'p> {
    fn new(patch: &'p Patch, tolerance: f64) -> Self {
        Self { patch, bracket: HeightBracket::new(patch), tolerance }
    }

    #[inline]
    fn place(&self, point: DVec3) -> Place {
        self.place_of(point - self.patch.origin())
    }

    /// The place of a point that is given relative to the origin of the patch.
    #[inline]
    fn place_of(&self, offset: DVec3) -> Place {
        self.place_of_local(self.patch.turn_to_local(offset))
    }

    /// The place of a point that is given in the frame of the patch.
    #[inline]
    fn place_of_local(&self, local: DVec3) -> Place {
        if !self.patch.contains(local.x, local.y) {
            return Place::Outside;
        }
        let quick = self.bracket.and_then(|bracket| bracket.is_within(local, self.tolerance));
        let is_within = quick.unwrap_or_else(|| {
            height_error(self.patch, local).is_none_or(|error| error <= self.tolerance)
        });
        if is_within { Place::Within } else { Place::Beyond }
    }
}

/// The height of a point over or under the patch, given in its frame; `None` outside the footprint.
fn height_error(patch: &Patch, local: DVec3) -> Option<f64> {
    patch.height_in_footprint(local.x, local.y).map(|z| (local.z - z).abs())
}

/// Sines and cosines of evenly spaced angles.
#[derive(Clone, Debug, Default)]
struct Turns(Vec<[f64; 2]>);

impl Turns {
    /// So many.
    fn new(angles: u32) -> Self {
        let angle = |j: u32| TAU * f64::from(j) / f64::from(angles);
        Self((0..angles).map(|j| angle(j).sin_cos().into()).collect())
    }

    /// Makes them so many.
    fn set(&mut self, angles: u32) {
        if self.0.len() != angles as usize {
            *self = Self::new(angles);
        }
    }

    /// The points of the full test, in the frame of the patch.
    fn full_test<'t>(&'t self, patch: &'t Patch) -> impl Iterator<Item = DVec3> + 't {
        self.ring(patch, 1.0).chain(self.ring(patch, 0.5))
    }

    /// Those of them with this u.
    fn ring<'t>(&'t self, patch: &'t Patch, u: f64) -> impl Iterator<Item = DVec3> + 't {
        let arms = patch.arms(u);
        self.0.iter().map(move |&[sin, cos]| patch.point_of_arms(arms, sin, cos))
    }
}

/// The distance of a point from a face.
fn distance(at: DVec3, mesh: &TriMesh, face: FaceId) -> f64 {
    closest_point(at, mesh.triangle(face)).0.distance(at)
}

/// What lies straight under a point of a patch.
enum Under {
    /// This face.
    Face(FaceId),
    /// Nothing: the section comes to the boundary of the mesh before, in this face.
    Beyond(FaceId),
    /// The section turns back or goes round, or the visitor has ended it.
    Unknown,
}

/// Follows the section to what is straight under a point of the patch. In every face but the first,
/// `visit` is shown the walker and whether the face looks to the side of the patch's normal, as long as
/// it wants to see more.
#[inline]
fn follow<'a>(
    mesh: &'a TriMesh,
    fit: &PatchFit,
    local: DVec3,
    mut visit: impl FnMut(&SectionWalk<'a>, bool) -> bool,
) -> Under {
    let [e1, e2, e3] = fit.patch.frame();
    let distance = local.truncate().length();
    let tangent = (local.x * e1 + local.y * e2) / distance;
    let plane = SectionPlane::new(fit.patch.origin(), e3, tangent);
    let walks = SectionWalk::both_ways(mesh, fit.point.face(), &plane);
    let Some([mut walk, _]) = walks else { return Under::Unknown };
    let mut ahead = walk.crossing().dot(tangent);
    let mut farthest = ahead;
    while ahead < distance {
        match walk.step() {
            Ok(()) => {}
            Err(WalkEnd::Boundary) => return Under::Beyond(walk.face()),
            Err(WalkEnd::Returned | WalkEnd::Lost) => return Under::Unknown,
        }
        let entered = ahead;
        ahead = walk.crossing().dot(tangent);
        farthest = farthest.max(ahead);
        // Sections run forward through faces that look to the side of the normal. Where one comes back
        // for more than a small fold, nothing may be straight under.
        if !visit(&walk, ahead >= entered) || ahead < farthest - DEEPEST_FOLD * distance {
            return Under::Unknown;
        }
    }
    Under::Face(walk.face())
}

/// The ends of both principal arcs, where SN10 measures the error that a size is chosen by.
fn arc_ends(patch: &Patch) -> impl Iterator<Item = DVec3> + '_ {
    (0..4).map(|j| patch.local_point(1.0, 0.25 * TAU * f64::from(j)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face at the boundary, and a ridge of two faces in the same place.
    #[test]
    fn a_boundary_that_lies_on_another_sheet_counts_in_any_order() {
        let points: [[f64; 3]; 7] = [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.5, 1.0, 0.0],
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.5, 1.0, -2.0],
            [0.5, -1.0, -2.0],
        ];
        let mesh = TriMesh::from_triangles(&points, &[[0, 1, 2], [3, 4, 5], [4, 3, 6]]).unwrap();
        let mut faces: Vec<FaceId> = mesh.topology().faces().collect();
        let measured = |faces: &[FaceId], at: DVec3| {
            let mut point = TestPoint::new(at);
            for &face in faces {
                MeasuredFace::new(&mesh, face, mesh.triangle(face)).measure(&mut point);
            }
            point
        };
        for _ in 0..2 {
            let point = measured(&faces, DVec3::new(0.5, -0.1, 0.5));
            let distance = 0.26_f64.sqrt();
            assert!((point.error(false) - distance).abs() < 1e-15, "{point:?}");
            assert_eq!(point.error(true), 0.0, "{point:?}");
            faces.reverse();
        }
        // Nearer to the other sheet, it is not beyond the boundary.
        let point = measured(&faces, DVec3::new(0.5, -0.5, 0.0));
        assert!(point.error(true) > 0.2, "{point:?}");
    }
}
