//! Principal curvatures and directions of every vertex: fitted, or averaged over balls.

use dcurv::{
    BallCurvature, CorrectedCurvature, FitScale, FittedCurvature, InvalidRadius, JetFitOptions,
    Pointwise, PrincipalFrame, align_directions, ball_curvatures_until, corrected_curvatures_until,
    default_ball_radius, edge_dihedral_angle, estimate_noise, fitted_curvatures_until,
};
use mesh_core::glam::DVec3;
use mesh_core::{Handle, TriMesh, UnitScale, VertexId, VertexMap, parallel};

use crate::curvature_failure::CurvatureFailure;
use crate::quantity::{Integrals, Quantity};

/// How principal curvatures and directions of vertices are estimated.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum FrameEstimator {
    /// Fitted surfaces whose scale follows the noise: of this standard deviation in model units, or estimated from the
    /// mesh.
    Auto {
        /// The noise.
        noise: Option<f64>,
    },
    /// Fitted surfaces.
    Fit(JetFitOptions),
    /// Averages over balls of this radius in model units, or of [`default_ball_radius`].
    Ball {
        /// The radius.
        radius: Option<f64>,
    },
    /// Averages over balls with interpolated normals.
    Corrected {
        /// The radius, as for `Ball`.
        radius: Option<f64>,
    },
}

impl FrameEstimator {
    /// Fitted surfaces: to this number of rings, within this radius, or at the scale of this noise. The first one that is
    /// given counts; without any, the nearest points decide. Lengths are in model units.
    #[must_use]
    pub fn fit(rings: Option<usize>, radius: Option<f64>, noise: Option<f64>) -> Self {
        let scale = match (rings, radius, noise) {
            (Some(rings), ..) => FitScale::Rings(rings),
            (_, Some(radius), _) => FitScale::Radius(radius),
            (_, _, Some(noise)) => FitScale::Noise(noise),
            _ => FitScale::Nearest,
        };
        Self::Fit(JetFitOptions { scale, ..JetFitOptions::default() })
    }

    /// With a function of all lengths.
    fn with_lengths(self, of: impl Fn(f64) -> f64) -> Self {
        match self {
            Self::Auto { noise } => Self::Auto { noise: noise.map(of) },
            Self::Fit(options) => Self::Fit(with_lengths(options, of)),
            Self::Ball { radius } => Self::Ball { radius: radius.map(of) },
            Self::Corrected { radius } => Self::Corrected { radius: radius.map(of) },
        }
    }
}

/// Options of a fit with a function of their lengths.
fn with_lengths(options: JetFitOptions, of: impl Fn(f64) -> f64) -> JetFitOptions {
    let scale = match options.scale {
        FitScale::Noise(noise) => FitScale::Noise(of(noise)),
        FitScale::Radius(radius) => FitScale::Radius(of(radius)),
        scale => scale,
    };
    JetFitOptions { scale, ..options }
}

/// What is at a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum PointKind {
    /// Two principal curvatures and their directions.
    Regular,
    /// The principal curvatures differ by less than a quarter of their error, about one standard deviation, so there are
    /// no principal directions.
    Umbilic,
    /// The surface has an edge here: the dihedral angle is larger than [`PointKind::CREASE_ANGLE`]. A fitted surface
    /// has no curvature here.
    Crease,
    /// The surface ends here, so the values come from one side.
    Boundary,
    /// The estimator has no value: too few points, or no faces.
    Unknown,
}

impl PointKind {
    /// 75 degrees, in radians.
    pub const CREASE_ANGLE: f64 = 75.0 * core::f64::consts::PI / 180.0;

    /// All kinds.
    pub const ALL: [Self; 5] =
        [Self::Regular, Self::Umbilic, Self::Crease, Self::Boundary, Self::Unknown];

    /// The name, in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Regular => "regular",
            Self::Umbilic => "umbilic",
            Self::Crease => "crease",
            Self::Boundary => "boundary",
            Self::Unknown => "unknown",
        }
    }
}

/// The curvature of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameValue {
    /// Principal curvatures and directions. At umbilics the directions are NaN.
    pub frame: PrincipalFrame,
    /// K, per square of the model unit.
    pub gaussian: f64,
    /// H, per model unit.
    pub mean: f64,
    /// The predicted error of the principal curvatures, per model unit. NaN if it is unknown, as for averages over
    /// balls.
    pub error: f64,
}

/// Principal curvatures and directions of every vertex.
#[derive(Clone, Debug)]
pub struct FrameValues {
    /// By vertex; `None` for vertices without curvature.
    pub of_vertex: VertexMap<Option<FrameValue>>,
    /// What is at each vertex.
    pub kinds: VertexMap<PointKind>,
    /// The radius of the balls, in model units.
    pub radius: Option<f64>,
    /// Whether the default radius was reduced because balls contain very many faces; see
    /// [`default_ball_radius`].
    pub radius_reduced: bool,
    /// How surfaces were fitted. With [`FrameEstimator::Auto`], the noise is in it.
    pub fit: Option<JetFitOptions>,
}

/// The radius of balls.
#[derive(Clone, Copy, Debug)]
struct BallRadius {
    radius: f64,
    /// Whether it is less than four mean edge lengths, to limit the time.
    reduced: bool,
}

impl BallRadius {
    /// The given radius, or the default. 1 for a mesh without edges, which has no balls.
    fn of(mesh: &TriMesh, given: Option<f64>) -> Self {
        if let Some(radius) = given {
            return Self { radius, reduced: false };
        }
        let radius = default_ball_radius(mesh);
        let reduced = radius < 4.0 * mesh.mean_edge_length().unwrap_or(0.0);
        Self { radius: if radius > 0.0 { radius } else { 1.0 }, reduced }
    }
}

impl FrameValues {
    /// Of all vertices.
    ///
    /// # Errors
    /// A radius is not positive, or the size of the mesh is out of its range.
    pub fn of(mesh: &TriMesh, estimator: FrameEstimator) -> Result<Self, CurvatureFailure> {
        Self::of_observed(mesh, estimator, &|| {})
    }

    /// As [`FrameValues::of`]. Any thread calls `starts` before each vertex.
    ///
    /// # Errors
    /// As [`FrameValues::of`].
    pub fn of_observed(
        mesh: &TriMesh,
        estimator: FrameEstimator,
        starts: &(dyn Fn() + Sync),
    ) -> Result<Self, CurvatureFailure> {
        let goes_on = || {
            starts();
            false
        };
        let found = Self::of_until(mesh, estimator, &goes_on)?;
        Ok(found.unwrap_or_else(|| Self::new(mesh, VertexMap::from_vec(Vec::new()))))
    }

    /// As [`FrameValues::of`], until `stops` returns true; then `None`. Any thread calls `stops` before each vertex.
    /// Once true, it must stay true.
    ///
    /// # Errors
    /// As [`FrameValues::of`].
    pub fn of_until(
        mesh: &TriMesh,
        estimator: FrameEstimator,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Self>, CurvatureFailure> {
        let Some(scale) = UnitScale::with_areas(mesh)? else {
            return Ok(Self::of_ordinary_size(mesh, estimator, stops)?);
        };
        let estimator = estimator.with_lengths(|length| scale.length(length));
        let found = Self::of_ordinary_size(&scale.mesh(mesh)?, estimator, stops)?;
        Ok(found.map(|found| found.restored(scale)))
    }

    /// The values of a scaled mesh at the size of the original.
    fn restored(self, scale: UnitScale) -> Self {
        let curvature = |k: Pointwise| Pointwise::new(scale.original_power(k.value(), -1));
        let value = |value: &FrameValue| FrameValue {
            frame: PrincipalFrame {
                k_max: curvature(value.frame.k_max),
                k_min: curvature(value.frame.k_min),
                ..value.frame
            },
            gaussian: scale.original_power(value.gaussian, -2),
            mean: scale.original_power(value.mean, -1),
            error: scale.original_power(value.error, -1),
        };
        let length = |length: f64| scale.original_length(length);
        Self {
            of_vertex: self.of_vertex.map(|of_vertex| of_vertex.as_ref().map(value)),
            radius: self.radius.map(length),
            fit: self.fit.map(|fit| with_lengths(fit, length)),
            ..self
        }
    }

    fn of_ordinary_size(
        mesh: &TriMesh,
        estimator: FrameEstimator,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Self>, InvalidRadius> {
        let fit = |options| {
            let fits = fitted_curvatures_until(mesh, &options, stops)?;
            Some(Self { fit: Some(options), ..Self::of_fits(mesh, &fits) })
        };
        let balls = |size: BallRadius, of_vertex: VertexMap<Option<FrameValue>>| Self {
            radius: Some(size.radius),
            radius_reduced: size.reduced,
            ..Self::new(mesh, of_vertex)
        };
        Ok(match estimator {
            FrameEstimator::Auto { noise } => {
                let noise = noise.unwrap_or_else(|| estimate_noise(mesh));
                fit(JetFitOptions { scale: FitScale::Noise(noise), ..JetFitOptions::default() })
            }
            FrameEstimator::Fit(options) => {
                if let FitScale::Radius(radius) = options.scale
                    && !(radius > 0.0 && radius.is_finite())
                {
                    return Err(InvalidRadius(radius));
                }
                fit(options)
            }
            FrameEstimator::Ball { radius } => {
                let size = BallRadius::of(mesh, radius);
                let found = ball_curvatures_until(mesh, size.radius, stops)?;
                found.map(|found| balls(size, found.map(FrameValue::of_ball)))
            }
            FrameEstimator::Corrected { radius } => {
                let size = BallRadius::of(mesh, radius);
                let found = corrected_curvatures_until(mesh, size.radius, stops)?;
                found.map(|found| balls(size, found.map(FrameValue::of_corrected)))
            }
        })
    }

    /// Values of fitted surfaces, which have none at creases.
    fn of_fits(mesh: &TriMesh, fits: &VertexMap<Option<FittedCurvature>>) -> Self {
        let mut values = Self::new(mesh, fits.map(|fit| fit.as_ref().map(FrameValue::of_fit)));
        let kinds = values.kinds.as_slice().iter();
        for (value, &kind) in values.of_vertex.as_mut_slice().iter_mut().zip(kinds) {
            if kind == PointKind::Crease {
                *value = None;
            }
        }
        values
    }

    /// Aligns directions, and finds the kinds of vertices.
    fn new(mesh: &TriMesh, mut of_vertex: VertexMap<Option<FrameValue>>) -> Self {
        let mut frames = of_vertex.map(|value| value.map(|value| value.frame));
        align_directions(mesh, &mut frames);
        let kinds = parallel::collect(of_vertex.len(), |index| {
            let vertex = VertexId::from_index(index);
            kind(mesh, vertex, of_vertex[vertex].as_ref())
        });
        let kinds = VertexMap::from_vec(kinds);
        for (vertex, frame) in frames.iter() {
            let Some((value, frame)) = of_vertex[vertex].as_mut().zip(*frame) else { continue };
            value.frame = frame;
            if kinds[vertex] == PointKind::Umbilic {
                let none = DVec3::NAN;
                value.frame.direction_max = none;
                value.frame.direction_min = none;
            }
        }
        Self { of_vertex, kinds, radius: None, radius_reduced: false, fit: None }
    }

    /// Curvatures of vertices times a third of the areas of their faces.
    #[must_use]
    pub fn integrals(&self, mesh: &TriMesh) -> Integrals {
        let mut sums = Integrals::default();
        for face in mesh.topology().faces() {
            let third = mesh.face_area(face) / 3.0;
            for vertex in mesh.topology().face_vertices(face) {
                let Some(value) = &self.of_vertex[vertex] else { continue };
                let [k1, k2] = value.principal();
                sums.integral_gaussian += third * value.gaussian;
                sums.integral_abs_gaussian += third * value.gaussian.abs();
                sums.integral_mean += third * value.mean;
                sums.integral_abs_mean += third * value.mean.abs();
                sums.f1 += third * value.mean * value.mean;
                sums.f3 += third * (k1.abs() + k2.abs());
            }
        }
        Integrals { f2: sums.integral_abs_mean, willmore: sums.f1 - sums.integral_gaussian, ..sums }
    }

    /// The standard deviation of noise that the scale follows.
    #[must_use]
    pub fn noise(&self) -> Option<f64> {
        match self.fit?.scale {
            FitScale::Noise(noise) => Some(noise),
            _ => None,
        }
    }

    /// One quantity, pointwise; NaN for vertices without curvature.
    #[must_use]
    pub fn of_quantity(&self, quantity: Quantity) -> VertexMap<f64> {
        self.of_vertex.map(|value| value.map_or(f64::NAN, |value| value.quantity(quantity)))
    }

    /// Number of vertices of a kind.
    #[must_use]
    pub fn count(&self, mesh: &TriMesh, kind: PointKind) -> usize {
        mesh.topology().vertices().filter(|&v| self.kinds[v] == kind).count()
    }
}

/// What is at a vertex with this value.
fn kind(mesh: &TriMesh, vertex: VertexId, value: Option<&FrameValue>) -> PointKind {
    let topology = mesh.topology();
    if !topology.contains_vertex(vertex) || topology.is_isolated_vertex(vertex) {
        return PointKind::Unknown;
    }
    let is_crease = topology.outgoing(vertex).any(|h| {
        let angle = edge_dihedral_angle(mesh, h.edge());
        angle.is_some_and(|angle| angle.abs() > PointKind::CREASE_ANGLE)
    });
    let Some(value) = value else {
        return if is_crease { PointKind::Crease } else { PointKind::Unknown };
    };
    let [k1, k2] = value.principal();
    if is_crease {
        PointKind::Crease
    } else if topology.is_boundary_vertex(vertex) {
        PointKind::Boundary
    } else if k1 - k2 <= 0.25 * value.error {
        PointKind::Umbilic
    } else {
        PointKind::Regular
    }
}

impl FrameValue {
    fn of_fit(fit: &FittedCurvature) -> Self {
        let frame = fit.frame;
        let (gaussian, mean) = (frame.gaussian().value(), frame.mean().value());
        Self { frame, gaussian, mean, error: fit.error.value() }
    }

    fn of_ball(ball: &BallCurvature) -> Option<Self> {
        let (gaussian, mean) = (ball.gaussian().value(), ball.mean().value());
        Some(Self { frame: ball.principal()?, gaussian, mean, error: f64::NAN })
    }

    fn of_corrected(ball: &CorrectedCurvature) -> Option<Self> {
        let (gaussian, mean) = (ball.gaussian().value(), ball.mean().value());
        Some(Self { frame: ball.principal()?, gaussian, mean, error: f64::NAN })
    }

    /// The principal curvatures, the larger one first.
    #[must_use]
    pub fn principal(&self) -> [f64; 2] {
        [self.frame.k_max.value(), self.frame.k_min.value()]
    }

    /// A quantity, pointwise; there is no Willmore energy of a fitted surface at a point.
    #[must_use]
    pub fn quantity(&self, quantity: Quantity) -> f64 {
        let [k1, k2] = self.principal();
        match quantity {
            Quantity::Gaussian => self.gaussian,
            Quantity::Mean => self.mean,
            Quantity::AbsMean => self.mean.abs(),
            Quantity::K1 => k1,
            Quantity::K2 => k2,
            Quantity::AbsSum => k1.abs() + k2.abs(),
            Quantity::ShapeIndex => (k1 + k2).atan2(k1 - k2) * core::f64::consts::FRAC_2_PI,
            Quantity::Curvedness => (0.5 * (k1 * k1 + k2 * k2)).sqrt(),
            Quantity::AbsDihedral | Quantity::Willmore | Quantity::KPlus | Quantity::KMinus => {
                f64::NAN
            }
        }
    }
}
