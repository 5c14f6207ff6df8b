//! The largest patch that keeps a tolerance.

use mesh_core::FaceId;

use crate::curvature::{CurvatureEstimator, DiscCurvature};
use crate::curvature_error::CurvatureError;
use crate::fit::PatchFit;
use crate::probe::{Limits, PatchProbe, TEST_ANGLES, Verdict};
use crate::sections::Sections;
use crate::shape::Shape;
use crate::surface_point::SurfacePoint;

/// Where a patch has to keep its tolerance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum ErrorTest {
    /// At test points halfway out and on the boundary, and at all vertices in the footprint.
    #[default]
    Full,
    /// At the ends of the principal arcs only, as SN10 proposes. Blind to what happens between
    /// them: on an exact cylinder these four points have no error, and those at 45° have
    /// a³/32 of the radius, a = `r_g` κ₁.
    EndPoints,
}

/// How large a patch may become.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SizeOptions {
    /// The largest distance between patch and mesh, in model units. Below the sag of the mesh's
    /// own facets, about h² κ / 8, nothing fits.
    pub tolerance: f64,
    /// Where the tolerance has to be kept.
    pub test: ErrorTest,
    /// At how many angles the full test looks; from 4 on.
    pub test_angles: u32,
    /// Whether a patch may reach over the boundary of the mesh. Test points beyond it are ignored.
    pub overhang: bool,
    /// The largest angle that an arc may turn by, in radians; below π/2.
    pub max_turn: f64,
    /// The largest radius; `None`: the diagonal of the mesh's bounding box.
    pub max_radius: Option<f64>,
    /// The ratio of one radius that is tried to the one before; above 1.
    pub growth: f64,
    /// Bisections between the largest radius that fits and the next one.
    pub bisections: u32,
}

impl SizeOptions {
    /// Defaults for a tolerance: the full test at 16 angles, no overhang, turns up to 1.2 radians, radii in
    /// steps of 1.25 with 5 bisections.
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        Self {
            tolerance,
            test: ErrorTest::Full,
            test_angles: TEST_ANGLES,
            overhang: false,
            max_turn: 1.2,
            max_radius: None,
            growth: 1.25,
            bisections: 5,
        }
    }

    /// Refuses options that describe no search.
    pub(crate) fn check(&self) -> Result<(), OptionError> {
        let max_radius = self.max_radius.unwrap_or(1.0);
        let max_turn = core::f64::consts::FRAC_PI_2;
        let rules = [
            ("the tolerance", self.tolerance, 0.0, f64::INFINITY),
            ("the number of test angles", f64::from(self.test_angles), 3.0, 1e6),
            ("the largest turn", self.max_turn, 0.0, max_turn),
            ("the largest radius", max_radius, 0.0, f64::INFINITY),
            ("the growth of the radius", self.growth, 1.001, 100.0),
        ];
        for (what, value, above, below) in rules {
            if !(value > above && value < below) {
                return Err(OptionError { what, value, above, below });
            }
        }
        Ok(())
    }
}

/// An option out of its range.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{what} is {value}, but it must be above {above} and below {below}")]
pub struct OptionError {
    /// Which option.
    pub what: &'static str,
    /// Its value.
    pub value: f64,
    /// The lower end of the range.
    pub above: f64,
    /// The upper end of the range.
    pub below: f64,
}

/// Why a patch is not larger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum StopReason {
    /// A larger one would be out of tolerance.
    Tolerance,
    /// An arc of a larger one would turn by more than allowed, or its disc closes on itself.
    Angle,
    /// A larger one would reach over the boundary of the mesh.
    Boundary,
    /// The largest radius was reached.
    MaxRadius,
}

/// A patch of automatic size.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct SizedPatch {
    /// The patch; its radius is in the curvature.
    pub fit: PatchFit,
    /// Why it is not larger.
    pub stop: StopReason,
    /// The faces that it covers: those with all vertices in its footprint and within tolerance.
    pub faces: Vec<FaceId>,
}

/// Why no radius fits.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Unfit {
    /// Patches were tried, and the smallest one already failed.
    #[error(
        "no radius from {smallest} on is admissible ({stop:?}); allow a larger tolerance or keep the triangle"
    )]
    NoRadius {
        /// The smallest radius that was tried.
        smallest: f64,
        /// What the smallest one failed by.
        stop: StopReason,
    },
    /// There is no curvature at the point for any radius.
    #[error(transparent)]
    Curvature(#[from] CurvatureError),
}

/// Finds the largest admissible radius for the patches of a mesh.
#[derive(Clone, Debug)]
pub struct PatchSizer<'e, 'a> {
    estimator: &'e CurvatureEstimator<'a>,
    options: SizeOptions,
    max_radius: f64,
    probe: PatchProbe<'a>,
    /// The curvatures at the current point by radius, in the order in which they were asked for; all
    /// shapes share them.
    discs: Vec<(f64, Result<DiscCurvature, CurvatureError>)>,
    /// The sections of the face's own planes at the current point.
    sections: Sections,
    /// Whether patches have become so large that a first look is quicker than a full test.
    is_large: bool,
    /// Faces of a region by the square of its patch's radius, the most so far.
    density: f64,
    /// The patch that the probe looked at last, if it is admissible.
    accepted: Option<PatchFit>,
    /// The faces of the patch that was confirmed last.
    faces: Vec<FaceId>,
    /// Their area.
    area: f64,
}

impl<'e, 'a> PatchSizer<'e, 'a> {
    /// A sizer for patches of the estimator's mesh. Holds memory, so make one and use it often.
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
            probe: PatchProbe::new(mesh),
            discs: Vec::new(),
            sections: Sections::default(),
            is_large: false,
            density: 0.0,
            accepted: None,
            faces: Vec::new(),
            area: 0.0,
        })
    }

    /// The largest admissible patch of a shape at a point, or at the barycentre of a face.
    ///
    /// Radii go up from just outside the face in steps of `growth`; errors need not grow with the
    /// radius, so the largest admissible one is kept and the search ends two failures after it.
    /// Curvature is estimated anew for every radius. `growth` and `bisections` decide how close to
    /// the limit the result is.
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
        self.climb(point, shape)
    }

    /// The patch of the shape that covers the largest area, the first of equal ones.
    ///
    /// # Errors
    /// [`Unfit`], that of the first shape, when none of them fits.
    pub fn fit_best(
        &mut self,
        point: impl Into<SurfacePoint>,
        shapes: &[Shape],
    ) -> Result<SizedPatch, Unfit> {
        self.fit_largest(point.into(), shapes).map(|(_, sized)| sized)
    }

    /// As [`PatchSizer::fit_best`], with the area of the faces that it covers.
    pub(crate) fn fit_largest(
        &mut self,
        point: SurfacePoint,
        shapes: &[Shape],
    ) -> Result<(f64, SizedPatch), Unfit> {
        self.start();
        let mut best: Option<(f64, SizedPatch)> = None;
        let mut failure = None;
        for &shape in shapes {
            match self.climb(point, shape) {
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

    /// Forgets what is known about another point.
    fn start(&mut self) {
        self.discs.clear();
        self.accepted = None;
        self.probe.start();
    }

    /// Climbs the ladder of radii, then narrows the gap above the largest admissible one.
    ///
    /// Once patches are large, the ladder is taken some rungs at a time, and radii that are likely to
    /// be admissible are passed over until it ends; then the largest one is looked at closely, and
    /// where that fails the next one below.
    fn climb(&mut self, point: SurfacePoint, shape: Shape) -> Result<SizedPatch, Unfit> {
        let smallest = self.smallest_radius(point)?;
        self.is_large = false;
        self.density = 0.0;
        // None where one is passed over.
        let mut rungs: Vec<Option<Result<Tried, StopReason>>> = Vec::new();
        let mut failures = 0;
        loop {
            let rung = rungs.len();
            let tried = self.try_rung(point, shape, smallest, rung);
            failures = if tried.is_err() { failures + 1 } else { 0 };
            let is_end = matches!(tried, Err(StopReason::MaxRadius))
                || failures >= 2 && self.radius_of(smallest, rung) >= self.least_end(smallest);
            rungs.push(Some(tried));
            if is_end {
                break;
            }
            if failures == 0 && self.is_large {
                rungs.extend((1..STRIDE).map(|_| None));
            }
        }
        let mut stop = StopReason::MaxRadius;
        while let Some(tried) = rungs.pop() {
            let rung = rungs.len();
            let tried = tried.unwrap_or_else(|| self.try_rung(point, shape, smallest, rung));
            match tried.and_then(|tried| self.widest(shape, tried)) {
                Ok(fit) => return Ok(SizedPatch { fit, stop, faces: self.faces.clone() }),
                Err(reason) => stop = reason,
            }
        }
        Err(self.unfit(smallest, stop))
    }

    /// The radius that the ladder goes up to whatever fails: beyond the first ring, and to where patches
    /// are large enough to be out of tolerance. Smaller ones fail by the roughness of the mesh, which says
    /// nothing of larger ones.
    fn least_end(&self, smallest: f64) -> f64 {
        (3.0 * smallest).max(4.0 * self.options.tolerance)
    }

    /// The radius of a rung of the ladder.
    fn radius_of(&self, smallest: f64, rung: usize) -> f64 {
        smallest * self.options.growth.powi(rung as i32)
    }

    /// The smallest radius that is tried: just large enough to reach over the face.
    fn smallest_radius(&self, point: SurfacePoint) -> Result<f64, CurvatureError> {
        let mesh = self.estimator.mesh();
        let face = point.face();
        if !mesh.topology().contains_face(face) {
            return Err(CurvatureError::NotInMesh { face });
        }
        let center = point.position(mesh);
        let radius =
            mesh.triangle(face).iter().map(|v| 1.05 * v.distance(center)).fold(0.0, f64::max);
        // From zero no ladder leads up.
        if radius > 0.0 { Ok(radius) } else { Err(CurvatureError::DegenerateFace { face }) }
    }

    /// What to say about a point without admissible radius.
    fn unfit(&self, smallest: f64, stop: StopReason) -> Unfit {
        match self.discs.first() {
            Some(&(_, Err(error))) if self.discs.iter().all(|(_, disc)| disc.is_err()) => {
                Unfit::Curvature(error)
            }
            _ => Unfit::NoRadius { smallest, stop },
        }
    }

    /// The patch of a rung, unless it is above the largest radius or not admissible.
    fn try_rung(
        &mut self,
        point: SurfacePoint,
        shape: Shape,
        smallest: f64,
        rung: usize,
    ) -> Result<Tried, StopReason> {
        let radius = self.radius_of(smallest, rung);
        if radius > self.max_radius {
            return Err(StopReason::MaxRadius);
        }
        self.try_radius(point, shape, radius)
    }

    /// The patch of a radius, unless a first look tells that it is not admissible.
    fn try_radius(
        &mut self,
        point: SurfacePoint,
        shape: Shape,
        radius: f64,
    ) -> Result<Tried, StopReason> {
        let curvature = self.curvature(point, radius).map_err(|_| StopReason::Boundary)?;
        self.try_curvature(point, shape, curvature)
    }

    /// The curvature of a disc round the current point.
    fn curvature(
        &mut self,
        point: SurfacePoint,
        radius: f64,
    ) -> Result<DiscCurvature, CurvatureError> {
        let known = self.discs.iter().find(|(known, _)| *known == radius);
        if let Some((_, disc)) = known {
            return *disc;
        }
        let terrain = self.probe.terrain();
        let disc = self.estimator.at_again(terrain, &mut self.sections, point, radius);
        self.discs.push((radius, disc));
        disc
    }

    fn try_curvature(
        &mut self,
        point: SurfacePoint,
        shape: Shape,
        curvature: DiscCurvature,
    ) -> Result<Tried, StopReason> {
        if curvature.truncated && !self.options.overhang {
            return Err(StopReason::Boundary);
        }
        let fit =
            self.estimator.patch_of(point, curvature, shape).map_err(|_| StopReason::Angle)?;
        if curvature.wrapped || fit.patch.turn() > self.options.max_turn {
            return Err(StopReason::Angle);
        }
        let limits = self.limits();
        let verdict = if self.is_large { self.probe.screen(&fit, &limits) } else { Verdict::Open };
        match verdict {
            Verdict::Likely => Ok(Tried { fit, is_certain: false }),
            Verdict::Fails => Err(StopReason::Tolerance),
            Verdict::Open => self.look_at(&fit).map(|()| Tried { fit, is_certain: true }),
        }
    }

    fn limits(&self) -> Limits {
        Limits {
            tolerance: self.options.tolerance,
            overhang: self.options.overhang,
            angles: self.options.test_angles,
            ends_only: self.options.test == ErrorTest::EndPoints,
        }
    }

    /// Looks at all of a patch; an error when it is not admissible.
    fn look_at(&mut self, fit: &PatchFit) -> Result<(), StopReason> {
        let limits = self.limits();
        let square = fit.curvature.radius * fit.curvature.radius;
        let is_vast = self.density * square >= VAST;
        if is_vast && self.probe.scout(fit, &limits) {
            self.accepted = None;
            return Err(StopReason::Tolerance);
        }
        let is_accepted = self.probe.accepts(fit, &limits);
        let faces = self.probe.region_size();
        self.is_large |= faces >= LARGE;
        self.density = self.density.max(faces as f64 / square);
        self.accepted = is_accepted.then_some(*fit);
        if is_accepted { Ok(()) } else { Err(StopReason::Tolerance) }
    }

    /// The patch, when it is admissible; its faces are kept then.
    fn confirm(&mut self, tried: &Tried) -> Result<PatchFit, StopReason> {
        if self.accepted != Some(tried.fit) {
            self.look_at(&tried.fit)?;
        }
        let Self { faces, probe, .. } = self;
        faces.clear();
        let covered = probe.covered().map(|(face, area)| {
            faces.push(face);
            area
        });
        self.area = covered.sum();
        Ok(tried.fit)
    }

    /// The largest admissible patch from a rung up to the next one; an error when not even that of
    /// the rung is admissible.
    ///
    /// To look closely takes long, so that is done to the largest one that is likely to be admissible.
    /// What it fails by rules out others quickly, and then the largest one that is likely now is next;
    /// after some failures the next one below that was likely before.
    fn widest(&mut self, shape: Shape, rung: Tried) -> Result<PatchFit, StopReason> {
        let radius = rung.fit.curvature.radius;
        let mut limit = (radius * self.options.growth).min(self.max_radius);
        let mut likely = vec![rung];
        let mut failures = 0;
        let mut reason = StopReason::Tolerance;
        loop {
            while failures < PATIENCE
                && let Some(low) = likely.last()
                && let Some(middle) = self.between(low.fit.curvature.radius, limit)
            {
                match self.try_radius(low.fit.point, shape, middle) {
                    Ok(tried) => likely.push(tried),
                    Err(_) => limit = middle,
                }
            }
            let Some(tried) = likely.pop() else { return Err(reason) };
            match self.confirm(&tried) {
                Ok(fit) => return Ok(self.bisect(shape, fit, limit)),
                Err(other) => (reason, limit) = (other, tried.fit.curvature.radius),
            }
            failures += 1;
            let limits = self.limits();
            while let Some(tried) = likely.last()
                && !tried.is_certain
                && self.probe.is_ruled_out(&tried.fit, &limits)
            {
                limit = tried.fit.curvature.radius;
                likely.pop();
            }
        }
    }

    /// Narrows the gap between an admissible radius and one that is not as far as the options ask
    /// for, looking closely at each step.
    fn bisect(&mut self, shape: Shape, fit: PatchFit, limit: f64) -> PatchFit {
        let (mut best, mut high) = (fit, limit);
        while let Some(middle) = self.between(best.curvature.radius, high) {
            let tried = self.try_radius(fit.point, shape, middle);
            match tried.and_then(|tried| self.confirm(&tried)) {
                Ok(fit) => best = fit,
                Err(_) => high = middle,
            }
        }
        best
    }

    /// The radius to try next between one that is admissible and one that is not; `None` when they
    /// are as close as the options ask for.
    fn between(&self, low: f64, high: f64) -> Option<f64> {
        // A step of the ladder, halved so many times, and not once more.
        let halvings = f64::from(1_u32 << self.options.bisections.min(31));
        let is_wide = high > low * self.options.growth.powf(1.5 / halvings);
        is_wide.then(|| (low * high).sqrt())
    }
}

/// So many faces under a patch take longer to look at than a few sections over them.
const LARGE: usize = 128;

/// To grow a region of so many faces takes longer than to follow many sections over it.
const VAST: f64 = 4096.0;

/// After so many patches that were likely to be admissible and are not, no others are looked for.
const PATIENCE: usize = 4;

/// Of the ladder's rungs, every so many-th is tried on the way up once patches are large.
const STRIDE: usize = 3;

/// A patch that no first look has refused.
#[derive(Clone, Debug)]
struct Tried {
    fit: PatchFit,
    /// Whether all of it has been looked at.
    is_certain: bool,
}
