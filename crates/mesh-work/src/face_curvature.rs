//! The curvature of every face, from normal sections.

use curvpatch::{CurvatureError, CurvatureEstimator, DiscCurvature, Params};
use mesh_core::{FaceMap, TriMesh};

use crate::quantity::{Integrals, Quantity};

/// The curvature of every face; nothing of those that have none: without area, or cut off from
/// their neighbours.
#[derive(Clone, Debug)]
pub struct FaceValues {
    /// Curvatures and frames.
    pub discs: FaceMap<Option<DiscCurvature>>,
    /// How far the sections reach to either side, in model units.
    pub radius: f64,
}

impl FaceValues {
    /// Of a mesh; without a radius it is four mean edges.
    ///
    /// # Errors
    /// A parameter or the radius is out of its range.
    pub fn of(mesh: &TriMesh, params: Params, radius: Option<f64>) -> Result<Self, CurvatureError> {
        let (estimator, radius) = start(mesh, params, radius)?;
        if mesh.topology().face_count() == 0 {
            return Ok(Self::of_discs(Vec::new(), radius));
        }
        Ok(Self::of_discs(estimator.all_faces(radius)?.into_vec(), radius))
    }

    /// As [`FaceValues::of`], until `stops` says so, which is asked before each face by any thread and
    /// stays with its answer; `None` then.
    ///
    /// # Errors
    /// A parameter or the radius is out of its range.
    pub fn of_until(
        mesh: &TriMesh,
        params: Params,
        radius: Option<f64>,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Self>, CurvatureError> {
        let (estimator, radius) = start(mesh, params, radius)?;
        if mesh.topology().face_count() == 0 {
            return Ok(Some(Self::of_discs(Vec::new(), radius)));
        }
        let discs = estimator.all_faces_until(radius, stops)?;
        Ok(discs.map(|discs| Self::of_discs(discs.into_vec(), radius)))
    }

    fn of_discs(discs: Vec<Result<DiscCurvature, CurvatureError>>, radius: f64) -> Self {
        let discs = discs.into_iter().map(Result::ok).collect();
        Self { discs: FaceMap::from_vec(discs), radius }
    }

    /// How many faces have a curvature of which something is true.
    pub fn count(&self, is: impl Fn(&DiscCurvature) -> bool) -> usize {
        self.discs.as_slice().iter().flatten().filter(|&disc| is(disc)).count()
    }

    /// Curvatures of faces times their areas.
    #[must_use]
    pub fn integrals(&self, mesh: &TriMesh) -> Integrals {
        let mut sums = Integrals::default();
        for face in mesh.topology().faces() {
            let Some(disc) = &self.discs[face] else { continue };
            let area = mesh.face_area(face);
            let [k1, k2] = disc.curvatures;
            sums.integral_gaussian += area * disc.gaussian();
            sums.integral_abs_gaussian += area * disc.gaussian().abs();
            sums.integral_mean += area * disc.mean();
            sums.integral_abs_mean += area * disc.mean().abs();
            sums.f1 += area * disc.mean() * disc.mean();
            sums.f3 += area * (k1.abs() + k2.abs());
        }
        Integrals { f2: sums.integral_abs_mean, willmore: sums.f1 - sums.integral_gaussian, ..sums }
    }
}

/// The estimator and the radius. Without faces there is no mean edge, and no curvature either.
fn start(
    mesh: &TriMesh,
    params: Params,
    radius: Option<f64>,
) -> Result<(CurvatureEstimator<'_>, f64), CurvatureError> {
    let estimator = CurvatureEstimator::new(mesh, params)?;
    let radius = radius.unwrap_or_else(|| estimator.suggested_radius());
    Ok((estimator, radius))
}

/// A quantity of a face, pointwise; a face has no Willmore energy of its own.
#[must_use]
pub fn disc_quantity(disc: &DiscCurvature, quantity: Quantity) -> f64 {
    let [k1, k2] = disc.curvatures;
    match quantity {
        Quantity::Gaussian => disc.gaussian(),
        Quantity::Mean => disc.mean(),
        Quantity::AbsMean => disc.mean().abs(),
        Quantity::K1 => k1.max(k2),
        Quantity::K2 => k1.min(k2),
        Quantity::AbsSum => k1.abs() + k2.abs(),
        Quantity::ShapeIndex => (k1 + k2).atan2((k1 - k2).abs()) * core::f64::consts::FRAC_2_PI,
        Quantity::Curvedness => (0.5 * (k1 * k1 + k2 * k2)).sqrt(),
        Quantity::Willmore => f64::NAN,
    }
}
