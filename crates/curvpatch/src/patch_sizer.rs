//! The largest patch that keeps a tolerance.

use mesh_core::FaceId;

use crate::curvature_error::CurvatureError;
use crate::curvature_estimator::CurvatureEstimator;
use crate::disc_curvature::DiscCurvature;
use crate::early_reject::Screening;
use crate::fit_test::FitTest;
use crate::patch_errors::FitLimits;
use crate::patch_fit::PatchFit;
use crate::reusable_sections::ReusableSections;
use crate::shape::Shape;
use crate::size_options::{ErrorTest, OptionError, SizeOptions};
use crate::surface_point::SurfacePoint;

/// The reason why a patch is not larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StopReason {
    /// A larger patch would be out of tolerance.
    Tolerance,
    /// An arc of a larger patch would turn by more than allowed, or its disc closes on itself.
    Angle,
    /// A larger patch would extend beyond the boundary of the mesh.
    Boundary,
    /// The largest radius was reached.
    MaxRadius,
}

/// A patch of automatically chosen size.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SizedPatch {
    /// The patch. Its radius is `fit.curvature.radius`.
    pub fit: PatchFit,
    /// The reason why it is not larger.
    pub stop: StopReason,
    /// The covered faces: all their vertices are over or under the footprint and within tolerance.
    pub faces: Vec<FaceId>,
}

/// The reason why no patch is admissible at a point.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// No tested radius is admissible.
    #[error(
        "no radius from {smallest} on is admissible ({stop:?}); allow a larger tolerance or keep the triangle"
    )]
    NoRadius {
        /// The smallest tested radius.
        smallest: f64,
        /// The condition that the smallest radius violates.
        stop: StopReason,
    },
    /// The curvature at the point is undefined for every radius.
    #[error(transparent)]
    Curvature(#[from] CurvatureError),
}

/// Finds the largest admissible radius for the patches of a mesh.
#[derive(Clone, Debug)]
pub struct PatchSizer<'e, 'a> {
    estimator: &'e CurvatureEstimator<'a>,
    options: SizeOptions,
    max_radius: f64,
    test: FitTest<'a>,
    /// Curvatures at the current point, by radius, in the order of estimation. All shapes share them.
    discs: Vec<(f64, Result<DiscCurvature, CurvatureError>)>,
    /// Sections at the current point in the planes through the face normal.
    sections: ReusableSections,
    /// Whether patches are so large that the early test is faster than the full test.
    is_large: bool,
    /// Largest number of faces of a region, divided by the square of the radius of its patch.
    density: f64,
    /// The patch of the latest full test, if it is admissible.
    accepted: Option<PatchFit>,
    /// The faces of the latest confirmed patch.
    faces: Vec<FaceId>,
    /// The area of these faces.
    area: f64,
}

impl<'e, 'a> PatchSizer<'e, 'a> {
    /// A sizer for patches of the mesh of `estimator`. It owns scratch memory, so use one for many points.
    ///
    /// # Errors
    /// An option out of its range.
    pub fn new(
        estimator: &'e CurvatureEstimator<'a>,
        options: SizeOptions,
    ) -> Result<Self, OptionError> {
        options.check()?;
        let mesh = estimator.mesh();
        let diagonal = || mesh.bounding_box().map_or(0.0, |bounds| bounds.diagonal());
        Ok(Self {
            estimator,
            options,
            max_radius: options.max_radius.unwrap_or_else(diagonal),
            test: FitTest::new(mesh),
            discs: Vec::new(),
            sections: ReusableSections::default(),
            is_large: false,
            density: 0.0,
            accepted: None,
            faces: Vec::new(),
            area: 0.0,
        })
    }

    /// The largest admissible patch of a shape at a point, or at the barycentre of a face.
    ///
    /// Radii increase by factors of `growth`, from just outside the face. Errors can decrease while the
    /// radius grows. The search therefore ends after two failures in a row, and keeps the largest
    /// admissible radius. The curvature is estimated again for every radius. `growth` and `bisections`
    /// determine how close the result is to the largest possible radius.
    ///
    /// # Errors
    /// [`Unfit`] when no radius is admissible.
    pub fn fit(
        &mut self,
        point: impl Into<SurfacePoint>,
        shape: Shape,
    ) -> Result<SizedPatch, Unfit> {
        let point = point.into();
        self.start();
        self.search(point, shape)
    }

    /// The patch with the largest covered area among several shapes; the first of equal ones.
    ///
    /// # Errors
    /// The [`Unfit`] of the first shape, when no shape is admissible.
    pub fn fit_best(
        &mut self,
        point: impl Into<SurfacePoint>,
        shapes: &[Shape],
    ) -> Result<SizedPatch, Unfit> {
        self.fit_largest(point.into(), shapes).map(|(_, sized)| sized)
    }

    /// As [`PatchSizer::fit_best`], with the area of the covered faces.
    pub(crate) fn fit_largest(
        &mut self,
        point: SurfacePoint,
        shapes: &[Shape],
    ) -> Result<(f64, SizedPatch), Unfit> {
        self.start();
        let mut best: Option<(f64, SizedPatch)> = None;
        let mut failure = None;
        for &shape in shapes {
            match self.search(point, shape) {
                Ok(sized) => {
                    let area = self.area;
                    if best.as_ref().is_none_or(|(best, _)| area > *best) {
                        best = Some((area, sized));
                    }
                }
                Err(unfit) => {
                    failure.get_or_insert(unfit);
                }
            }
        }
        let nothing = Unfit::NoRadius { smallest: 0.0, stop: StopReason::MaxRadius };
        best.ok_or(failure.unwrap_or(nothing))
    }

    /// Forgets the results for the previous point.
    fn start(&mut self) {
        self.discs.clear();
        self.accepted = None;
        self.test.start();
    }

    /// Tests radii smallest · growthⁱ upward, then narrows the gap above the largest admissible one.
    ///
    /// For large patches, only every third radius is tested, with the early test alone. At the end, the
    /// largest radius gets the full test, and if that fails, the next smaller one.
    fn search(&mut self, point: SurfacePoint, shape: Shape) -> Result<SizedPatch, Unfit> {
        let smallest = self.smallest_radius(point)?;
        self.is_large = false;
        self.density = 0.0;
        // `None` for a skipped radius.
        let mut results: Vec<Option<Result<Candidate, StopReason>>> = Vec::new();
        let mut failures = 0;
        loop {
            let step = results.len();
            let candidate = self.try_step(point, shape, smallest, step);
            failures = if candidate.is_err() { failures + 1 } else { 0 };
            let is_end = matches!(candidate, Err(StopReason::MaxRadius))
                || failures >= 2
                    && self.radius_of(smallest, step) >= self.min_last_radius(smallest);
            results.push(Some(candidate));
            if is_end {
                break;
            }
            if failures == 0 && self.is_large {
                results.extend((1..STRIDE).map(|_| None));
            }
        }
        let mut stop = StopReason::MaxRadius;
        while let Some(candidate) = results.pop() {
            let step = results.len();
            let candidate =
                candidate.unwrap_or_else(|| self.try_step(point, shape, smallest, step));
            match candidate.and_then(|candidate| self.enlarge(shape, candidate)) {
                Ok(fit) => return Ok(SizedPatch { fit, stop, faces: self.faces.clone() }),
                Err(reason) => stop = reason,
            }
        }
        Err(self.unfit(smallest, stop))
    }

    /// The radius below which failures do not end the search.
    ///
    /// It is beyond the first ring of faces and large compared with the tolerance. Smaller patches can fail
    /// because of the roughness of the mesh, which does not affect larger ones.
    fn min_last_radius(&self, smallest: f64) -> f64 {
        (3.0 * smallest).max(4.0 * self.options.tolerance)
    }

    /// The radius of a step of the search.
    ///
    /// Radii grow by the factor `growth` up to [`EVEN_RANGE`] times the smallest radius. Beyond, the exponent
    /// doubles with each step, so that the number of steps is bounded on meshes with coordinates of very
    /// different magnitudes.
    fn radius_of(&self, smallest: f64, step: usize) -> f64 {
        let growth = self.options.growth;
        let even = (EVEN_RANGE.ln() / growth.ln()).ceil() as usize;
        let exponent = match step.checked_sub(even) {
            None => step,
            Some(excess) => even + (1 << excess.min(20)) - 1,
        };
        smallest * growth.powi(i32::try_from(exponent).unwrap_or(i32::MAX))
    }

    /// The smallest radius: the disc just contains the face.
    fn smallest_radius(&self, point: SurfacePoint) -> Result<f64, CurvatureError> {
        let mesh = self.estimator.mesh();
        let face = point.face();
        if !mesh.topology().contains_face(face) {
            return Err(CurvatureError::NotInMesh { face });
        }
        let center = point.position(mesh);
        let radius =
            mesh.triangle(face).iter().map(|v| 1.05 * v.distance(center)).fold(0.0, f64::max);
        // The search multiplies radii, so it cannot start at zero.
        if radius > 0.0 { Ok(radius) } else { Err(CurvatureError::DegenerateFace { face }) }
    }

    /// The error for a point without admissible radius.
    fn unfit(&self, smallest: f64, stop: StopReason) -> Unfit {
        match self.discs.first() {
            Some(&(_, Err(error))) if self.discs.iter().all(|(_, disc)| disc.is_err()) => {
                Unfit::Curvature(error)
            }
            _ => Unfit::NoRadius { smallest, stop },
        }
    }

    /// The patch of a step, unless its radius is too large or the early test rejects it.
    fn try_step(
        &mut self,
        point: SurfacePoint,
        shape: Shape,
        smallest: f64,
        step: usize,
    ) -> Result<Candidate, StopReason> {
        let radius = self.radius_of(smallest, step);
        if radius > self.max_radius {
            return Err(StopReason::MaxRadius);
        }
        self.try_radius(point, shape, radius)
    }

    /// The patch of a radius, unless the early test rejects it.
    fn try_radius(
        &mut self,
        point: SurfacePoint,
        shape: Shape,
        radius: f64,
    ) -> Result<Candidate, StopReason> {
        let curvature = self.curvature(point, radius).map_err(|_| StopReason::Boundary)?;
        self.try_curvature(point, shape, curvature)
    }

    /// The curvature of a disc around the current point.
    fn curvature(
        &mut self,
        point: SurfacePoint,
        radius: f64,
    ) -> Result<DiscCurvature, CurvatureError> {
        let known = self.discs.iter().find(|(known, _)| *known == radius);
        if let Some((_, disc)) = known {
            return *disc;
        }
        let soa = self.test.soa();
        let disc = self.estimator.at_again(soa, &mut self.sections, point, radius);
        self.discs.push((radius, disc));
        disc
    }

    fn try_curvature(
        &mut self,
        point: SurfacePoint,
        shape: Shape,
        curvature: DiscCurvature,
    ) -> Result<Candidate, StopReason> {
        if curvature.truncated && !self.options.overhang {
            return Err(StopReason::Boundary);
        }
        let fit =
            self.estimator.patch_of(point, curvature, shape).map_err(|_| StopReason::Angle)?;
        if curvature.wrapped || fit.patch.turn() > self.options.max_turn {
            return Err(StopReason::Angle);
        }
        let limits = self.limits();
        let screening =
            if self.is_large { self.test.screen(&fit, &limits) } else { Screening::Undecided };
        match screening {
            Screening::Likely => Ok(Candidate { fit, is_tested: false }),
            Screening::Rejected => Err(StopReason::Tolerance),
            Screening::Undecided => {
                self.test_fully(&fit).map(|()| Candidate { fit, is_tested: true })
            }
        }
    }

    fn limits(&self) -> FitLimits {
        FitLimits {
            tolerance: self.options.tolerance,
            overhang: self.options.overhang,
            angles: self.options.test_angles,
            ends_only: self.options.test == ErrorTest::EndPoints,
        }
    }

    /// The full test of a patch; an error when it is not admissible.
    fn test_fully(&mut self, fit: &PatchFit) -> Result<(), StopReason> {
        let limits = self.limits();
        let square = fit.curvature.radius * fit.curvature.radius;
        let is_very_large = self.density * square >= VERY_LARGE;
        if is_very_large && self.test.rejects_early(fit, &limits) {
            self.accepted = None;
            return Err(StopReason::Tolerance);
        }
        let is_accepted = self.test.accepts(fit, &limits);
        let faces = self.test.region_size();
        self.is_large |= faces >= LARGE;
        self.density = self.density.max(faces as f64 / square);
        self.accepted = is_accepted.then_some(*fit);
        if is_accepted { Ok(()) } else { Err(StopReason::Tolerance) }
    }

    /// The patch, when it is admissible. Then its faces are stored.
    fn confirm(&mut self, candidate: &Candidate) -> Result<PatchFit, StopReason> {
        if self.accepted != Some(candidate.fit) {
            self.test_fully(&candidate.fit)?;
        }
        let Self { faces, test, .. } = self;
        faces.clear();
        let covered = test.covered().map(|(face, area)| {
            faces.push(face);
            area
        });
        self.area = covered.sum();
        Ok(candidate.fit)
    }

    /// The largest admissible patch between a step of the search and the next one; an error when the
    /// patch of the step itself is not admissible.
    ///
    /// The full test is expensive, so the early test bisects first. The full test then starts with the
    /// largest likely patch. A vertex that violates its tolerance often rejects other patches quickly.
    /// After [`MAX_FAILURES`] failures, only patches that were likely before are tested, in descending
    /// order.
    fn enlarge(&mut self, shape: Shape, step: Candidate) -> Result<PatchFit, StopReason> {
        let radius = step.fit.curvature.radius;
        let mut limit = (radius * self.options.growth).min(self.max_radius);
        let mut likely = vec![step];
        let mut failures = 0;
        let mut reason = StopReason::Tolerance;
        loop {
            while failures < MAX_FAILURES
                && let Some(low) = likely.last()
                && let Some(middle) = self.between(low.fit.curvature.radius, limit)
            {
                match self.try_radius(low.fit.point, shape, middle) {
                    Ok(candidate) => likely.push(candidate),
                    Err(_) => limit = middle,
                }
            }
            let Some(candidate) = likely.pop() else { return Err(reason) };
            match self.confirm(&candidate) {
                Ok(fit) => return Ok(self.bisect(shape, fit, limit)),
                Err(other) => (reason, limit) = (other, candidate.fit.curvature.radius),
            }
            failures += 1;
            let limits = self.limits();
            while let Some(candidate) = likely.last()
                && !candidate.is_tested
                && self.test.violates_known_vertex(&candidate.fit, &limits)
            {
                limit = candidate.fit.curvature.radius;
                likely.pop();
            }
        }
    }

    /// Narrows the gap between an admissible radius and an inadmissible one, with the full test at each
    /// step.
    fn bisect(&mut self, shape: Shape, fit: PatchFit, limit: f64) -> PatchFit {
        let (mut best, mut high) = (fit, limit);
        while let Some(middle) = self.between(best.curvature.radius, high) {
            let candidate = self.try_radius(fit.point, shape, middle);
            match candidate.and_then(|candidate| self.confirm(&candidate)) {
                Ok(fit) => best = fit,
                Err(_) => high = middle,
            }
        }
        best
    }

    /// The next radius between an admissible one and an inadmissible one. `None` when they are as close
    /// as the options request.
    fn between(&self, low: f64, high: f64) -> Option<f64> {
        // One step of the search, halved `bisections` times; 1.5 keeps rounding from adding another.
        let halvings = f64::from(1_u32 << self.options.bisections.min(31));
        let is_wide = high > low * self.options.growth.powf(1.5 / halvings);
        is_wide.then(|| (low * high).sqrt())
    }
}

/// The ratio of radii up to which steps of the search are even.
const EVEN_RANGE: f64 = 65_536.0;

/// Number of faces from which the early test is faster than the full test.
const LARGE: usize = 128;

/// Number of faces from which 64 sections are faster than growing the region.
const VERY_LARGE: f64 = 4096.0;

/// Number of failed full tests after which no further candidates are searched.
const MAX_FAILURES: usize = 4;

/// For large patches, one step in this many is tested on the way up.
const STRIDE: usize = 3;

/// A patch that the early test has not rejected.
#[derive(Clone, Debug)]
struct Candidate {
    fit: PatchFit,
    /// Whether it has passed the full test.
    is_tested: bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::Params;
    use mesh_core::TriMesh;
    use mesh_shapes::Sphere;

    /// Corrupted coordinates make the ratio of the largest to the smallest radius arbitrary.
    #[test]
    fn the_number_of_steps_is_bounded_for_any_range_of_radii() {
        let mesh = TriMesh::from_soup(&Sphere::UNIT.icosphere(0).unwrap()).unwrap();
        let estimator = CurvatureEstimator::new(&mesh, Params::robust()).unwrap();
        let sizer = PatchSizer::new(&estimator, SizeOptions::new(0.1)).unwrap();
        let smallest = 1e-150;
        let steps = (0..).take_while(|&step| sizer.radius_of(smallest, step) < 1e150).count();
        assert!(steps < 70, "{steps}");
        for step in 0..40 {
            assert_eq!(sizer.radius_of(smallest, step), smallest * 1.25_f64.powi(step as i32));
        }
    }
}
