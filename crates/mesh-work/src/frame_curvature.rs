//! Principal curvatures and directions of every vertex, from fitted quadratic surfaces or averaged
//! over balls.

use dcurv::{
    BallCurvature, FitOptions, InvalidRadius, PrincipalFrame, ball_curvatures,
    ball_curvatures_until, default_ball_radius, fitted_frames, fitted_frames_until,
};
use mesh_core::{TriMesh, VertexMap};

use crate::quantity::{Integrals, Quantity};

/// The curvature of a vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameValue {
    /// Principal curvatures and directions.
    pub frame: PrincipalFrame,
    /// K, per square of the model unit.
    pub gaussian: f64,
    /// H, per model unit.
    pub mean: f64,
}

/// Principal curvatures and directions of every vertex; `None` for vertices that have none.
#[derive(Clone, Debug)]
pub struct FrameValues {
    /// By vertex.
    pub of_vertex: VertexMap<Option<FrameValue>>,
    /// The radius of the balls, in model units.
    pub radius: Option<f64>,
    /// Whether the default radius was reduced because balls contain very many faces; see
    /// [`default_ball_radius`].
    pub radius_reduced: bool,
    /// How the surfaces were fitted.
    pub fit: Option<FitOptions>,
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
    /// From quadratic surfaces fitted to this number of rings of neighbours.
    #[must_use]
    pub fn fitted(mesh: &TriMesh, rings: usize) -> Self {
        let options = FitOptions { rings, ..FitOptions::default() };
        Self::of_fits(&fitted_frames(mesh, &options), options)
    }

    /// As [`FrameValues::fitted`], until `stops` returns true; then `None`. Any thread calls `stops` before each
    /// vertex. Once true, it must stay true.
    #[must_use]
    pub fn fitted_until(
        mesh: &TriMesh,
        rings: usize,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Option<Self> {
        let options = FitOptions { rings, ..FitOptions::default() };
        Some(Self::of_fits(&fitted_frames_until(mesh, &options, stops)?, options))
    }

    fn of_fits(frames: &VertexMap<Option<PrincipalFrame>>, options: FitOptions) -> Self {
        let of_vertex = frames.map(|frame| frame.map(FrameValue::of_fit));
        Self { of_vertex, radius: None, radius_reduced: false, fit: Some(options) }
    }

    /// Averaged over balls. Without a radius, it is [`default_ball_radius`].
    ///
    /// # Errors
    /// The radius is not positive.
    pub fn averaged(mesh: &TriMesh, radius: Option<f64>) -> Result<Self, InvalidRadius> {
        let size = BallRadius::of(mesh, radius);
        Ok(Self::of_balls(&ball_curvatures(mesh, size.radius)?, size))
    }

    /// As [`FrameValues::averaged`], until `stops` returns true; then `None`. Any thread calls `stops` before each
    /// vertex. Once true, it must stay true.
    ///
    /// # Errors
    /// The radius is not positive.
    pub fn averaged_until(
        mesh: &TriMesh,
        radius: Option<f64>,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Self>, InvalidRadius> {
        let size = BallRadius::of(mesh, radius);
        let balls = ball_curvatures_until(mesh, size.radius, stops)?;
        Ok(balls.map(|balls| Self::of_balls(&balls, size)))
    }

    fn of_balls(balls: &VertexMap<BallCurvature>, size: BallRadius) -> Self {
        let of_vertex = balls.map(|ball| Some(FrameValue::of_ball(ball, ball.principal()?)));
        let BallRadius { radius, reduced } = size;
        Self { of_vertex, radius: Some(radius), radius_reduced: reduced, fit: None }
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
}

impl FrameValue {
    fn of_fit(frame: PrincipalFrame) -> Self {
        let (gaussian, mean) = (frame.gaussian().value(), frame.mean().value());
        Self { frame, gaussian, mean }
    }

    fn of_ball(ball: &BallCurvature, frame: PrincipalFrame) -> Self {
        let (gaussian, mean) = (ball.gaussian().value(), ball.mean().value());
        Self { frame, gaussian, mean }
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
