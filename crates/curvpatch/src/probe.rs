//! Measuring patches against the mesh: errors, and the faces that a patch may stand for.

use core::f64::consts::{FRAC_PI_6, TAU};
use core::ops::ControlFlow;

use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f64x8};
use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::closest::{Feature, closest_point};
use crate::fit::PatchFit;
use crate::height_bracket::HeightBracket;
use crate::march::{Party, Strides, Walker, march};
use crate::patch::Patch;
use crate::region::{Picker, Region};
use crate::section::{SectionPlane, WalkEnd};
use crate::terrain::Terrain;
use crate::wide::{Columns, LANES, LanesOf, Wide, put};

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
        let points: Vec<DVec3> = self.turns.full_test(&fit.patch).collect();
        let heights = self.grow_whole(fit);
        // What lies straight under the points is near, so that most faces need no closer look.
        let mut points: Vec<TestPoint> = looked_under(&self.region, fit, &points).collect();
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
        let Self { region, turns, .. } = self;
        let terrain = region.terrain();
        let patch = &fit.patch;
        let heights = Heights::new(patch, limits.tolerance);
        turns.set(limits.angles);
        let points: Vec<DVec3> = turns.ring(patch, 1.0).collect();
        let trails = follow(terrain, fit, &points, Watch::Any(&heights));
        if trails.witness.is_some() {
            return Verdict::Fails;
        }
        let is_fine = |(&local, under): (&DVec3, Under)| match under {
            Under::Face(face) => distance(patch.to_world(local), terrain, face) <= limits.tolerance,
            Under::Beyond(_) => limits.overhang,
            Under::Unknown => false,
        };
        let is_likely = points.iter().zip(trails.under).all(is_fine);
        let is_bad = |at: &&DVec3| heights.place(**at) == Place::Beyond;
        if let Some(&witness) = self.sample.iter().find(is_bad) {
            self.testify(witness);
            return Verdict::Fails;
        }
        if is_likely { Verdict::Likely } else { Verdict::Open }
    }

    /// Whether a vertex along one of many sections is out of tolerance of a patch, which takes less than
    /// growing a large region to there.
    pub(crate) fn scout(&mut self, fit: &PatchFit, limits: &Limits) -> bool {
        if limits.ends_only {
            return false;
        }
        let heights = Heights::new(&fit.patch, limits.tolerance);
        let terrain = self.region.terrain();
        let points: Vec<DVec3> = self.scouts.ring(&fit.patch, 1.0).collect();
        let trails = follow(terrain, fit, &points, Watch::First(&heights));
        let witness = trails.witness.map(|(_, apex)| fit.patch.origin() + apex);
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

    /// What sections walk on.
    pub(crate) fn terrain(&self) -> &Terrain {
        self.region.terrain()
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
    /// within tolerance of it, with their areas. The footprint is convex, so it has the whole of these
    /// faces.
    pub(crate) fn covered(&self) -> impl Iterator<Item = (FaceId, f64)> + '_ {
        self.region.picked_faces()
    }

    /// Leaves in `pending` the test points that are not within tolerance of the face that the section in
    /// their direction leads to, straight under them or at the boundary, if that is of the region. The
    /// nearest face is not farther than their distance is then.
    fn look_under_test_points(&mut self, fit: &PatchFit, limits: &Limits) {
        let Self { pending, turns, region, .. } = self;
        pending.clear();
        let patch = &fit.patch;
        let points: Vec<DVec3> = if limits.ends_only {
            arc_ends(patch).collect()
        } else {
            turns.set(limits.angles);
            turns.full_test(patch).collect()
        };
        pending.extend(looked_under(region, fit, &points));
        pending.retain(|point| point.distance > 1.000_001 * limits.tolerance);
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
        let mut vetting = Vetting { heights, ends_only: limits.ends_only, met: 0, sample };
        region.grow(fit.point.face(), patch, &mut vetting)
    }

    /// Grows the region and returns the largest height error.
    fn grow_whole(&mut self, fit: &PatchFit) -> f64 {
        let mut measuring = Measuring { patch: &fit.patch, largest: 0.0 };
        let _ = self.region.grow(fit.point.face(), &fit.patch, &mut measuring);
        measuring.largest
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

/// Picks the vertices that are within tolerance of a patch.
struct Vetting<'p> {
    heights: Heights<'p>,
    /// Whether those beyond do not matter.
    ends_only: bool,
    met: usize,
    sample: &'p mut Vec<DVec3>,
}

impl Picker for Vetting<'_> {
    #[inline(always)]
    fn look<S: Simd>(&mut self, simd: S, met: &Wide<S>, count: usize) -> (u64, Option<usize>) {
        let [within, beyond] = self.heights.places(simd, met, (1 << count) - 1);
        let last = if self.ends_only { None } else { LanesOf(beyond).next() };
        let count = last.map_or(count, |last| last + 1);
        // Regions at one point begin with nearly the same vertices.
        while (self.met + count) / SAMPLED > self.sample.len() {
            let place = (self.sample.len() + 1) * SAMPLED - 1;
            self.sample.push(self.heights.patch.to_world(met.at(place - self.met)));
        }
        self.met += count;
        (within, last)
    }
}

/// Finds out how far vertices are from a patch at most.
struct Measuring<'p> {
    patch: &'p Patch,
    largest: f64,
}

impl Picker for Measuring<'_> {
    #[inline(always)]
    fn look<S: Simd>(&mut self, _: S, met: &Wide<S>, count: usize) -> (u64, Option<usize>) {
        for lane in 0..count {
            let error = height_error(self.patch, met.at(lane));
            self.largest = self.largest.max(error.unwrap_or(0.0));
        }
        (0, None)
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
        self.place_of_local(self.patch.to_local(point))
    }

    /// Which of eight points that are given relative to the origin of the patch are beyond, by bits, as
    /// far as someone has asked for them.
    #[inline(always)]
    fn beyond<S: Simd>(&self, simd: S, offsets: &Wide<S>, asked: u64) -> u64 {
        if asked == 0 {
            return 0;
        }
        let [e1, e2, e3] = self.patch.frame();
        let x = Wide::splat(simd, e1).dot(*offsets);
        let y = Wide::splat(simd, e2).dot(*offsets);
        let z = Wide::splat(simd, e3).dot(*offsets);
        let [_, beyond] = self.places(simd, &Wide { x, y, z }, asked);
        beyond
    }

    /// Which of eight points that are given in the frame of the patch are within tolerance, and which are
    /// beyond, by bits, as far as someone has asked for them.
    #[inline(always)]
    fn places<S: Simd>(&self, simd: S, local: &Wide<S>, asked: u64) -> [u64; 2] {
        let [semi_x, semi_y] = self.patch.semi_axes();
        let share_x = local.x / f64x8::splat(simd, semi_x);
        let share_y = local.y / f64x8::splat(simd, semi_y);
        let square = share_x * share_x + share_y * share_y;
        let asked = asked & square.simd_le(f64x8::splat(simd, 1.0)).to_bitmask();
        let [mut within, mut beyond] = match &self.bracket {
            Some(bracket) => bracket.are_within(simd, local, self.tolerance, asked),
            None => [0; 2],
        };
        for lane in LanesOf(asked & !(within | beyond)) {
            match self.place_in_footprint(local.at(lane)) {
                Place::Beyond => beyond |= 1 << lane,
                Place::Within | Place::Outside => within |= 1 << lane,
            }
        }
        [within, beyond]
    }

    /// The place of a point that is given in the frame of the patch.
    #[inline]
    fn place_of_local(&self, local: DVec3) -> Place {
        if !self.patch.contains(local.x, local.y) {
            return Place::Outside;
        }
        let quick = self.bracket.and_then(|bracket| bracket.is_within(local, self.tolerance));
        match quick {
            Some(true) => Place::Within,
            Some(false) => Place::Beyond,
            None => self.place_in_footprint(local),
        }
    }

    /// As [`Heights::place_of_local`], the long way.
    fn place_in_footprint(&self, local: DVec3) -> Place {
        let error = height_error(self.patch, local);
        if error.is_none_or(|error| error <= self.tolerance) {
            Place::Within
        } else {
            Place::Beyond
        }
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

/// The distance of a point from the face at a place.
fn distance(at: DVec3, terrain: &Terrain, face: u32) -> f64 {
    let corners = terrain.triangle(terrain.links[face as usize].corners);
    closest_point(at, corners).0.distance(at)
}

/// Test points at these places of a patch, with the distance that they are at most at: that of the face
/// which the section in their direction leads to, straight under them or at the boundary, if that is of
/// the region.
fn looked_under<'p>(
    region: &'p Region,
    fit: &'p PatchFit,
    points: &'p [DVec3],
) -> impl Iterator<Item = TestPoint> + 'p {
    let terrain = region.terrain();
    let under = follow(terrain, fit, points, Watch::Nothing).under;
    points.iter().zip(under).map(|(&local, under)| {
        let mut point = TestPoint::new(fit.patch.to_world(local));
        if let Under::Face(face) | Under::Beyond(face) = under
            && region.contains(face)
        {
            // Only what is nearer needs a look, and this face itself.
            point.distance = 1.000_001 * distance(point.at, terrain, face);
        }
        point
    })
}

/// What lies straight under a point of a patch.
#[derive(Clone, Copy, Debug)]
enum Under {
    /// The face at this place.
    Face(u32),
    /// Nothing: the section comes to the boundary of the mesh before, in this face.
    Beyond(u32),
    /// The section turns back or goes round, or the visitor has ended it.
    Unknown,
}

/// What sections that are followed look for on their way.
#[derive(Clone, Copy)]
enum Watch<'h> {
    Nothing,
    /// Any vertex that is out of tolerance; nothing else is of interest once there is one.
    Any(&'h Heights<'h>),
    /// The first one of the section that is first among those that come to one.
    First(&'h Heights<'h>),
}

/// Sections on the way to what is straight under points of a patch.
struct Trails<'p> {
    terrain: &'p Terrain,
    patch: &'p Patch,
    start: u32,
    points: core::iter::Enumerate<core::slice::Iter<'p, DVec3>>,
    watch: Watch<'p>,
    /// What is straight under each point.
    under: Vec<Under>,
    /// The number of a section and a vertex that is out of tolerance, relative to the origin.
    witness: Option<(usize, DVec3)>,
    numbers: [usize; LANES],
    tangents: Columns,
    /// How far ahead the points are.
    distances: [f64; LANES],
    /// How far the sections have come, and at most.
    ahead: [f64; LANES],
    farthest: [f64; LANES],
    faces: [u32; LANES],
    /// The sections that have only come through faces that look to the side of the patch's normal, save
    /// for the first face.
    in_region: u64,
}

impl Trails<'_> {
    fn find(&mut self, number: usize, under: Under) {
        if let Some(place) = self.under.get_mut(number) {
            *place = under;
        }
    }

    /// Whether a section can have nothing to tell.
    fn is_idle(&self, number: usize) -> bool {
        matches!(self.watch, Watch::First(_))
            && self.witness.is_some_and(|(first, _)| first < number)
    }
}

impl<S: Simd> Party<S> for Trails<'_> {
    #[inline(always)]
    fn set_out(&mut self, lane: usize) -> Option<Walker> {
        let [e1, e2, e3] = self.patch.frame();
        while let Some((number, local)) = self.points.next() {
            if self.is_idle(number) {
                return None;
            }
            let distance = local.truncate().length();
            let tangent = (local.x * e1 + local.y * e2) / distance;
            let plane = SectionPlane::new(self.patch.origin(), e3, tangent);
            let walkers = Walker::both_ways(self.terrain, self.start, &plane);
            let Some([walker, _]) = walkers else { continue };
            let ahead = walker.crossing().dot(tangent);
            if ahead < distance {
                self.numbers[lane] = number;
                put(&mut self.tangents, lane, tangent);
                self.distances[lane] = distance;
                self.ahead[lane] = ahead;
                self.farthest[lane] = ahead;
                self.faces[lane] = self.start;
                self.in_region |= 1 << lane;
                return Some(walker);
            }
            self.find(number, Under::Face(self.start));
        }
        None
    }

    #[inline(always)]
    fn stride(&mut self, simd: S, strides: &Strides<S>) -> u64 {
        self.faces = strides.faces;
        let entered: f64x8<S> = self.ahead.simd_into(simd);
        let distances: f64x8<S> = self.distances.simd_into(simd);
        let farthest: f64x8<S> = self.farthest.simd_into(simd);
        let ahead = strides.crossings.dot(Wide::load(simd, &self.tangents));
        let farthest = ahead.simd_gt(farthest).select(ahead, farthest);
        ahead.store_slice(&mut self.ahead);
        farthest.store_slice(&mut self.farthest);
        // Sections run forward through faces that look to the side of the normal. Where one comes
        // back for more than a small fold, nothing may be straight under.
        self.in_region &= ahead.simd_ge(entered).to_bitmask();
        let folds = f64x8::splat(simd, DEEPEST_FOLD) * distances;
        let mut lost = ahead.simd_lt(farthest - folds).to_bitmask();
        let asked = self.in_region & strides.lanes;
        match self.watch {
            Watch::Nothing => {}
            Watch::Any(heights) => {
                let beyond = heights.beyond(simd, &strides.apexes, asked);
                if let Some(lane) = LanesOf(beyond).next() {
                    self.witness = Some((self.numbers[lane], strides.apexes.at(lane)));
                }
            }
            Watch::First(heights) => {
                lost |= !asked;
                let beyond = heights.beyond(simd, &strides.apexes, asked);
                for lane in LanesOf(beyond) {
                    let number = self.numbers[lane];
                    if self.witness.is_none_or(|(first, _)| number < first) {
                        self.witness = Some((number, strides.apexes.at(lane)));
                    }
                }
                lost |= beyond;
                if self.witness.is_some() {
                    for lane in LanesOf(strides.lanes) {
                        lost |= u64::from(self.is_idle(self.numbers[lane])) << lane;
                    }
                }
            }
        }
        let arrived = !ahead.simd_lt(distances).to_bitmask();
        for lane in LanesOf(arrived & !lost & strides.lanes) {
            self.find(self.numbers[lane], Under::Face(strides.faces[lane]));
        }
        arrived | lost
    }

    #[inline(always)]
    fn end(&mut self, lane: usize, cause: WalkEnd) {
        if cause == WalkEnd::Boundary {
            self.find(self.numbers[lane], Under::Beyond(self.faces[lane]));
        }
    }

    #[inline(always)]
    fn is_over(&self) -> bool {
        matches!(self.watch, Watch::Any(_)) && self.witness.is_some()
    }
}

/// Follows the sections to what is straight under points of the patch, side by side.
fn follow<'p>(
    terrain: &'p Terrain,
    fit: &'p PatchFit,
    points: &'p [DVec3],
    watch: Watch<'p>,
) -> Trails<'p> {
    let (patch, start) = (&fit.patch, terrain.place(fit.point.face()));
    let mut trails = Trails {
        terrain,
        patch,
        start,
        points: points.iter().enumerate(),
        watch,
        under: vec![Under::Unknown; points.len()],
        witness: None,
        numbers: [0; LANES],
        tangents: [[0.0; LANES]; 3],
        distances: [0.0; LANES],
        ahead: [0.0; LANES],
        farthest: [0.0; LANES],
        faces: [start; LANES],
        in_region: 0,
    };
    dispatch!(terrain.simd, simd => march(simd, terrain, patch.origin(), start, &mut trails));
    trails
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
