//! Measuring patches against the mesh: errors, and the faces that a patch may stand for.

use core::f64::consts::{FRAC_PI_6, TAU};
use core::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::closest::{Feature, closest_point};
use crate::fit::PatchFit;
use crate::patch::Patch;
use crate::region::{Marks, Region};
use crate::section::{SectionPlane, SectionWalk};

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
    /// A test point is not within tolerance of what is straight under it, which says nothing yet.
    Open,
}

/// Angles of the full test, unless asked for otherwise.
pub(crate) const TEST_ANGLES: u32 = 16;

/// A test point and what is known about its distance from the mesh.
#[derive(Clone, Copy, Debug)]
struct TestPoint {
    at: DVec3,
    distance: f64,
    nearest_on_boundary: bool,
}

impl TestPoint {
    fn new(at: DVec3) -> Self {
        Self { at, distance: f64::INFINITY, nearest_on_boundary: false }
    }

    fn error(&self, overhang: bool) -> f64 {
        if overhang && self.nearest_on_boundary { 0.0 } else { self.distance }
    }
}

/// Measures patches against a mesh. Holds memory for it, so make one and use it often.
///
/// Distances are taken from the *region* of a patch: the faces that can be reached from its base
/// face without turning away from its normal and that come within its reach. A fold of the surface
/// that happens to pass by does not count.
#[derive(Clone, Debug)]
pub struct PatchProbe<'a> {
    mesh: &'a TriMesh,
    region: Region,
    /// The vertices in the footprint that are within tolerance.
    fitted: Marks,
    pending: Vec<TestPoint>,
    turns: Turns,
}

impl<'a> PatchProbe<'a> {
    /// A probe for patches of this mesh.
    #[must_use]
    pub fn new(mesh: &'a TriMesh) -> Self {
        let fitted = Marks::new(mesh.topology().vertex_capacity());
        Self {
            mesh,
            region: Region::new(mesh),
            fitted,
            pending: Vec::new(),
            turns: Turns::default(),
        }
    }

    /// The distances of four boundary points from the mesh, at φ = 0°, 30°, 60° and 90°: the
    /// errors that SN10 prints for its Fig. 10, there divided by the radius.
    pub fn quarter_errors(&mut self, fit: &PatchFit) -> [f64; 4] {
        let angles = [0.0, 1.0, 2.0, 3.0].map(|j| j * FRAC_PI_6);
        let mut points = angles.map(|phi| TestPoint::new(fit.patch.point(1.0, phi)));
        let [l1, l2] = fit.patch.arcs();
        self.grow_whole(fit, 0.5 * l1.max(l2));
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
        let heights = self.grow_whole(fit, 2.0 * tolerance);
        self.measure(&mut points);
        let points = points.iter().map(|point| point.error(overhang)).fold(0.0, f64::max);
        PatchErrors { points, heights }
    }

    /// The faces under a patch, whatever their distance from it: those of its region that have all
    /// vertices in its footprint.
    pub fn faces_under(&mut self, fit: &PatchFit) -> Vec<FaceId> {
        let [l1, l2] = fit.patch.arcs();
        self.grow_whole(fit, 0.5 * l1.max(l2));
        let in_footprint = |corner: &DVec3| {
            let local = fit.patch.to_local(*corner);
            fit.patch.contains(local.x, local.y)
        };
        let faces = self.region.faces().iter().copied();
        faces.filter(|&face| self.mesh.triangle(face).iter().all(in_footprint)).collect()
    }

    /// What can be told of a patch without looking at all of the faces under it: it fails when a
    /// vertex of a face straight under a test point is out of tolerance and the section leads there
    /// through faces of the region.
    pub(crate) fn screen(&mut self, fit: &PatchFit, limits: &Limits) -> Verdict {
        if limits.ends_only {
            return Verdict::Open;
        }
        let (mesh, patch) = (self.mesh, &fit.patch);
        let [l1, l2] = patch.arcs();
        let reach = l1.max(l2) + 2.0 * limits.tolerance;
        let is_bad = |face: FaceId| {
            mesh.topology().face_vertices(face).into_iter().any(|vertex| {
                height_error(patch, mesh.position(vertex))
                    .is_some_and(|error| error > limits.tolerance)
            })
        };
        self.turns.set(limits.angles);
        self.pending.clear();
        for local in self.turns.full_test(patch) {
            let mut in_region = true;
            let under = follow(mesh, fit, local, |walk| {
                in_region &= walk.crossing().length_squared() <= reach * reach
                    && mesh.face_cross(walk.face()).dot(patch.frame()[2]) > 0.0;
            });
            let at = patch.to_world(local);
            let near = under.is_some_and(|face| is_near(mesh, face, at, limits.tolerance));
            if !near {
                return Verdict::Open;
            }
            if in_region && under.is_some_and(is_bad) {
                return Verdict::Fails;
            }
        }
        Verdict::Likely
    }

    /// How many faces the patch that was tested last has in its region.
    pub(crate) fn region_size(&self) -> usize {
        self.region.faces().len()
    }

    /// Whether a patch keeps its limits; if so, [`PatchProbe::covered`] has its faces.
    pub(crate) fn accepts(&mut self, fit: &PatchFit, limits: &Limits) -> bool {
        self.test_over_sections(fit, limits);
        if self.grow_within(fit, limits).is_break() {
            return false;
        }
        let mut pending = core::mem::take(&mut self.pending);
        self.measure(&mut pending);
        let kept = pending.iter().all(|p| p.error(limits.overhang) <= limits.tolerance);
        self.pending = pending;
        kept
    }

    /// The faces whose vertices all lie in the footprint of the patch that was accepted last and
    /// within tolerance of it. The footprint is convex, so it has the whole of these faces.
    pub(crate) fn covered(&self) -> impl Iterator<Item = FaceId> + '_ {
        let topology = self.mesh.topology();
        let fitted = move |&face: &FaceId| {
            topology.face_vertices(face).iter().all(|v| self.fitted.contains(v.index()))
        };
        self.region.faces().iter().copied().filter(fitted)
    }

    /// Leaves in `pending` the test points that are not within tolerance of the face that lies
    /// straight under them, which the section in their direction leads to.
    fn test_over_sections(&mut self, fit: &PatchFit, limits: &Limits) {
        let Self { mesh, pending, turns, .. } = self;
        pending.clear();
        let patch = &fit.patch;
        let test = |local: DVec3| {
            let at = patch.to_world(local);
            let under = follow(mesh, fit, local, |_| {});
            if !under.is_some_and(|face| is_near(mesh, face, at, limits.tolerance)) {
                pending.push(TestPoint::new(at));
            }
        };
        if limits.ends_only {
            arc_ends(patch).for_each(test);
        } else {
            turns.set(limits.angles);
            turns.full_test(patch).for_each(test);
        }
    }

    /// Grows the region and marks the vertices of the footprint; breaks at the first one that is
    /// out of tolerance.
    fn grow_within(&mut self, fit: &PatchFit, limits: &Limits) -> ControlFlow<()> {
        let Self { mesh, region, fitted, .. } = self;
        let patch = &fit.patch;
        let [l1, l2] = patch.arcs();
        let reach = l1.max(l2) + 2.0 * limits.tolerance;
        fitted.clear();
        region.grow(mesh, fit.point.face(), patch, reach, |vertex| {
            match height_error(patch, mesh.position(vertex)) {
                Some(error) if error <= limits.tolerance => {
                    fitted.insert(vertex.index());
                }
                Some(_) if !limits.ends_only => return ControlFlow::Break(()),
                _ => {}
            }
            ControlFlow::Continue(())
        })
    }

    /// Grows the region and returns the largest height error.
    fn grow_whole(&mut self, fit: &PatchFit, margin: f64) -> f64 {
        let Self { mesh, region, .. } = self;
        let patch = &fit.patch;
        let [l1, l2] = patch.arcs();
        let reach = l1.max(l2) + margin;
        let mut heights = 0.0_f64;
        let _ = region.grow(mesh, fit.point.face(), patch, reach, |vertex| {
            heights = heights.max(height_error(patch, mesh.position(vertex)).unwrap_or(0.0));
            ControlFlow::Continue(())
        });
        heights
    }

    /// The exact distances of points from the faces of the region.
    fn measure(&self, points: &mut [TestPoint]) {
        if points.is_empty() {
            return;
        }
        for &face in self.region.faces() {
            let corners = self.mesh.triangle(face);
            let [a, b, c] = corners;
            let size = a.distance_squared(b).max(a.distance_squared(c)).sqrt();
            for point in &mut *points {
                let reach = point.distance + size;
                if point.at.distance_squared(a) > reach * reach {
                    continue;
                }
                let (closest, feature) = closest_point(point.at, corners);
                let distance = closest.distance(point.at);
                if distance < point.distance {
                    point.distance = distance;
                    point.nearest_on_boundary = self.is_on_boundary(face, feature);
                }
            }
        }
    }

    fn is_on_boundary(&self, face: FaceId, feature: Feature) -> bool {
        let topology = self.mesh.topology();
        match feature {
            Feature::Corner(i) => topology.is_boundary_vertex(topology.face_vertices(face)[i]),
            Feature::Side(i) => topology.is_boundary_edge(topology.face_half_edges(face)[i].edge()),
            Feature::Inside => false,
        }
    }
}

/// The height of a point over or under the patch; `None` outside the footprint.
#[inline]
fn height_error(patch: &Patch, point: DVec3) -> Option<f64> {
    let local = patch.to_local(point);
    patch.height_in_footprint(local.x, local.y).map(|z| (local.z - z).abs())
}

/// Sines and cosines of evenly spaced angles.
#[derive(Clone, Debug, Default)]
struct Turns(Vec<[f64; 2]>);

impl Turns {
    /// Makes them so many.
    fn set(&mut self, angles: u32) {
        if self.0.len() != angles as usize {
            let angle = |j: u32| TAU * f64::from(j) / f64::from(angles);
            self.0 = (0..angles).map(|j| angle(j).sin_cos().into()).collect();
        }
    }

    /// The points of the full test, in the frame of the patch.
    fn full_test<'t>(&'t self, patch: &'t Patch) -> impl Iterator<Item = DVec3> + 't {
        let ring = |u: f64| {
            let arms = patch.arms(u);
            self.0.iter().map(move |&[sin, cos]| patch.point_of_arms(arms, sin, cos))
        };
        ring(1.0).chain(ring(0.5))
    }
}

/// Whether a face is within a distance of a point.
fn is_near(mesh: &TriMesh, face: FaceId, at: DVec3, distance: f64) -> bool {
    closest_point(at, mesh.triangle(face)).0.distance(at) <= distance
}

/// The face straight under a point of the patch, if the section leads there; the walker is shown in
/// every face but the first.
fn follow(
    mesh: &TriMesh,
    fit: &PatchFit,
    local: DVec3,
    mut visit: impl FnMut(&SectionWalk<'_>),
) -> Option<FaceId> {
    let [e1, e2, e3] = fit.patch.frame();
    let distance = local.truncate().length();
    let tangent = (local.x * e1 + local.y * e2) / distance;
    let plane = SectionPlane::new(fit.patch.origin(), e3, tangent);
    let [mut walk, _] = SectionWalk::both_ways(mesh, fit.point.face(), &plane)?;
    let mut last = 0.0;
    loop {
        let ahead = walk.crossing().dot(tangent);
        if ahead >= distance {
            return Some(walk.face());
        }
        // Where the section turns back, the mesh folds over and nothing is straight under.
        if ahead < last {
            return None;
        }
        last = ahead;
        walk.step().ok()?;
        visit(&walk);
    }
}

/// The ends of both principal arcs, where SN10 measures the error that a size is chosen by.
fn arc_ends(patch: &Patch) -> impl Iterator<Item = DVec3> + '_ {
    (0..4).map(|j| patch.local_point(1.0, 0.25 * TAU * f64::from(j)))
}
