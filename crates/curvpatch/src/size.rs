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
    /// The curvatures of the ladder's rungs at the current point, which all shapes share.
    rungs: Vec<Result<DiscCurvature, CurvatureError>>,
    /// The sections of the face's own planes at the current point.
    sections: Sections<'a>,
    /// Whether patches have become so large that a first look is quicker than a full test.
    is_large: bool,
    /// The faces of the best patch so far.
    faces: Vec<FaceId>,
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
            rungs: Vec::new(),
            sections: Sections::default(),
            is_large: false,
            faces: Vec::new(),
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
        self.rungs.clear();
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
        let point = point.into();
        let mesh = self.estimator.mesh();
        self.rungs.clear();
        let mut best: Option<(f64, SizedPatch)> = None;
        let mut failure = None;
        for &shape in shapes {
            match self.climb(point, shape) {
                Ok(sized) => {
                    let area = sized.faces.iter().map(|&face| mesh.face_area(face)).sum();
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
        best.map(|(_, sized)| sized).ok_or(failure.unwrap_or(nothing))
    }

    /// Climbs the ladder of radii, then bisects.
    ///
    /// Once patches are large, radii that are likely to be admissible are passed over until the ladder
    /// ends; then the largest one is looked at closely, and where that fails the next one below.
    fn climb(&mut self, point: SurfacePoint, shape: Shape) -> Result<SizedPatch, Unfit> {
        let smallest = self.smallest_radius(point)?;
        self.is_large = false;
        let mut rungs: Vec<(f64, Result<Tried, StopReason>)> = Vec::new();
        let mut failures = 0;
        for rung in 0.. {
            let radius = smallest * self.options.growth.powi(rung);
            if radius > self.max_radius {
                rungs.push((radius, Err(StopReason::MaxRadius)));
                break;
            }
            let tried = self.try_rung(point, shape, rung as usize, radius);
            failures = if tried.is_err() { failures + 1 } else { 0 };
            rungs.push((radius, tried));
            if failures >= 2 && radius >= 3.0 * smallest {
                break;
            }
        }
        let mut stop = StopReason::MaxRadius;
        while let Some((radius, tried)) = rungs.pop() {
            match tried.and_then(|tried| self.confirm(tried)) {
                Ok(fit) => {
                    let fit = self.bisect(shape, radius, fit);
                    return Ok(SizedPatch { fit, stop, faces: self.faces.clone() });
                }
                Err(reason) => stop = reason,
            }
        }
        Err(self.unfit(smallest, stop))
    }

    /// The smallest radius that is tried: just large enough to reach over the face.
    fn smallest_radius(&self, point: SurfacePoint) -> Result<f64, CurvatureError> {
        let mesh = self.estimator.mesh();
        let face = point.face();
        if !mesh.topology().contains_face(face) {
            return Err(CurvatureError::NotInMesh { face });
        }
        let center = point.position(mesh);
        Ok(mesh.triangle(face).iter().map(|v| 1.05 * v.distance(center)).fold(0.0, f64::max))
    }

    /// What to say about a point without admissible radius.
    fn unfit(&self, smallest: f64, stop: StopReason) -> Unfit {
        match self.rungs.iter().find_map(|rung| rung.err()) {
            Some(error) if self.rungs.iter().all(Result::is_err) => Unfit::Curvature(error),
            _ => Unfit::NoRadius { smallest, stop },
        }
    }

    fn try_rung(
        &mut self,
        point: SurfacePoint,
        shape: Shape,
        rung: usize,
        radius: f64,
    ) -> Result<Tried, StopReason> {
        while self.rungs.len() <= rung {
            self.rungs.push(self.estimator.at_again(&mut self.sections, point, radius));
        }
        let curvature = self.rungs[rung].map_err(|_| StopReason::Boundary)?;
        self.try_curvature(point, shape, curvature)
    }

    /// The patch of a radius, unless a first look tells that it is not admissible.
    fn try_radius(
        &mut self,
        point: SurfacePoint,
        shape: Shape,
        radius: f64,
    ) -> Result<Tried, StopReason> {
        let curvature = self.estimator.at_again(&mut self.sections, point, radius);
        self.try_curvature(point, shape, curvature.map_err(|_| StopReason::Boundary)?)
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
            Verdict::Likely => Ok(Tried { fit, faces: None }),
            Verdict::Fails => Err(StopReason::Tolerance),
            Verdict::Open => {
                let faces = self.faces_of(&fit)?;
                Ok(Tried { fit, faces: Some(faces) })
            }
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

    /// The faces of a patch, when it is admissible.
    fn faces_of(&mut self, fit: &PatchFit) -> Result<Vec<FaceId>, StopReason> {
        let accepted = self.probe.accepts(fit, &self.limits());
        self.is_large |= self.probe.region_size() >= LARGE;
        if !accepted {
            return Err(StopReason::Tolerance);
        }
        Ok(self.probe.covered().collect())
    }

    /// The patch, when it is admissible; its faces are kept then.
    fn confirm(&mut self, tried: Tried) -> Result<PatchFit, StopReason> {
        self.faces = match tried.faces {
            Some(faces) => faces,
            None => self.faces_of(&tried.fit)?,
        };
        Ok(tried.fit)
    }

    /// Narrows the gap between the largest admissible rung and the next: first by what is likely,
    /// and where the end of that is not admissible, step by step.
    fn bisect(&mut self, shape: Shape, radius: f64, fit: PatchFit) -> PatchFit {
        let limit = (radius * self.options.growth).min(self.max_radius);
        let (mut low, mut high) = (radius, limit);
        let mut largest = None;
        for _ in 0..self.options.bisections {
            let middle = (low * high).sqrt();
            match self.try_radius(fit.point, shape, middle) {
                Ok(tried) => (low, largest) = (middle, Some(tried)),
                Err(_) => high = middle,
            }
        }
        let Some(largest) = largest else { return fit };
        if let Ok(fit) = self.confirm(largest) {
            return fit;
        }
        let (mut best, mut low, mut high) = (fit, radius, limit);
        for _ in 0..self.options.bisections {
            let middle = (low * high).sqrt();
            let tried = self.try_radius(fit.point, shape, middle);
            match tried.and_then(|tried| self.confirm(tried)) {
                Ok(fit) => (best, low) = (fit, middle),
                Err(_) => high = middle,
            }
        }
        best
    }
}

/// So many faces under a patch take longer to look at than a few sections over them.
const LARGE: usize = 512;

/// A patch that no first look has refused, with its faces where all of it has been looked at.
#[derive(Clone, Debug)]
struct Tried {
    fit: PatchFit,
    faces: Option<Vec<FaceId>>,
}
