//! The curvature of every face from normal sections.

use curvpatch::{CurvatureError, CurvatureEstimator, DiscCurvature, DiscSize, Params};
use mesh_core::{FaceMap, TriMesh, UnitScale};

use crate::curvature_failure::CurvatureFailure;
use crate::quantity::{Integrals, Quantity};

/// The curvature of every face, and the faces where it is unknown or uncertain.
#[derive(Clone, Debug)]
pub struct FaceValues {
    /// Curvatures and frames. `None` for a face whose curvature is unknown: it has no area, its sections
    /// do not leave it, or they close on themselves.
    pub discs: FaceMap<Option<DiscCurvature>>,
    /// Faces whose sections close on themselves: the radius is too large there.
    pub closed: FaceMap<bool>,
    /// The size of the discs.
    pub size: DiscSize,
    /// The radius of the discs in model units; the median radius for [`DiscSize::Local`].
    pub radius: f64,
}

impl FaceValues {
    /// The curvature of all faces. Without a radius, the size of the discs is
    /// [`CurvatureEstimator::default_size`].
    ///
    /// # Errors
    /// A parameter, the radius or the size of the mesh is out of its range.
    pub fn of(
        mesh: &TriMesh,
        params: Params,
        radius: Option<f64>,
    ) -> Result<Self, CurvatureFailure> {
        Self::of_observed(mesh, params, radius, &|| {})
    }

    /// As [`FaceValues::of`]. Any thread calls `starts` before each face.
    ///
    /// # Errors
    /// As [`FaceValues::of`].
    pub fn of_observed(
        mesh: &TriMesh,
        params: Params,
        radius: Option<f64>,
        starts: &(dyn Fn() + Sync),
    ) -> Result<Self, CurvatureFailure> {
        let goes_on = || {
            starts();
            false
        };
        let found = Self::of_until(mesh, params, radius, &goes_on)?;
        Ok(found.unwrap_or_else(|| Self::of_discs(Vec::new(), DiscSize::Local)))
    }

    /// As [`FaceValues::of`], until `stops` returns true; then `None`. Any thread calls `stops` before
    /// each face. Once true, it must stay true.
    ///
    /// # Errors
    /// A parameter, the radius or the size of the mesh is out of its range.
    pub fn of_until(
        mesh: &TriMesh,
        params: Params,
        radius: Option<f64>,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Self>, CurvatureFailure> {
        let Some(scale) = UnitScale::with_areas(mesh)? else {
            return Ok(Self::of_ordinary_size(mesh, params, radius, stops)?);
        };
        let radius = radius.map(|radius| scale.length(radius));
        let found = Self::of_ordinary_size(&scale.mesh(mesh)?, params, radius, stops)?;
        Ok(found.map(|found| found.restored(scale)))
    }

    /// The values of a scaled mesh at the size of the original.
    fn restored(self, scale: UnitScale) -> Self {
        Self {
            discs: self
                .discs
                .map(|of_face| of_face.as_ref().map(|disc| restored_disc(disc, scale))),
            size: match self.size {
                DiscSize::Radius(radius) => DiscSize::Radius(scale.original_length(radius)),
                size => size,
            },
            radius: scale.original_length(self.radius),
            ..self
        }
    }

    fn of_ordinary_size(
        mesh: &TriMesh,
        params: Params,
        radius: Option<f64>,
        stops: &(dyn Fn() -> bool + Sync),
    ) -> Result<Option<Self>, CurvatureError> {
        let estimator = CurvatureEstimator::new(mesh, params)?;
        let size = radius.map_or_else(|| estimator.default_size(), DiscSize::Radius);
        // Without faces there is no mean edge length.
        if mesh.topology().face_count() == 0 {
            return Ok(Some(Self::of_discs(Vec::new(), size)));
        }
        let discs = estimator.all_faces_until(size, stops)?;
        Ok(discs.map(|discs| Self::of_discs(discs.into_vec(), size)))
    }

    fn of_discs(found: Vec<Result<DiscCurvature, CurvatureError>>, size: DiscSize) -> Self {
        let is_closed = |disc: &Result<DiscCurvature, _>| {
            disc.as_ref().is_ok_and(|disc: &DiscCurvature| disc.wrapped)
        };
        let closed = FaceMap::from_vec(found.iter().map(is_closed).collect());
        let known = |disc: Result<DiscCurvature, _>| disc.ok().filter(|disc| !disc.wrapped);
        let discs: Vec<Option<DiscCurvature>> = found.into_iter().map(known).collect();
        let radius = match size {
            DiscSize::Radius(radius) => radius,
            _ => median(discs.iter().flatten().map(|disc| disc.radius).collect()),
        };
        Self { discs: FaceMap::from_vec(discs), closed, size, radius }
    }

    /// Number of faces with known curvature that satisfy a condition.
    pub fn count(&self, is: impl Fn(&DiscCurvature) -> bool) -> usize {
        self.discs.as_slice().iter().flatten().filter(|&disc| is(disc)).count()
    }

    /// Number of faces whose sections close on themselves.
    #[must_use]
    pub fn closed_count(&self) -> usize {
        self.closed.as_slice().iter().filter(|&&closed| closed).count()
    }

    /// Integrals over the faces with known curvature: sums of curvature times area.
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

/// A disc of a scaled mesh at the size of the original.
pub(crate) fn restored_disc(disc: &DiscCurvature, scale: UnitScale) -> DiscCurvature {
    DiscCurvature {
        center: scale.original_point(disc.center),
        curvatures: disc.curvatures.map(|curvature| scale.original_power(curvature, -1)),
        radius: scale.original_length(disc.radius),
        ..*disc
    }
}

/// The median of radii; 0 without any.
fn median(mut radii: Vec<f64>) -> f64 {
    radii.sort_by(f64::total_cmp);
    radii.get(radii.len() / 2).copied().unwrap_or(0.0)
}

/// A pointwise quantity of a face. The Willmore energy of a face is undefined (NaN).
#[must_use]
pub fn disc_quantity(disc: &DiscCurvature, quantity: Quantity) -> f64 {
    let [k1, k2] = disc.curvatures;
    match quantity {
        Quantity::Gaussian => disc.gaussian(),
        Quantity::Mean => disc.mean(),
        Quantity::AbsMean => disc.mean().abs(),
        Quantity::K1 => k1,
        Quantity::K2 => k2,
        Quantity::AbsSum => k1.abs() + k2.abs(),
        Quantity::ShapeIndex => (k1 + k2).atan2(k1 - k2) * core::f64::consts::FRAC_2_PI,
        Quantity::Curvedness => (0.5 * (k1 * k1 + k2 * k2)).sqrt(),
        Quantity::AbsDihedral | Quantity::Willmore | Quantity::KPlus | Quantity::KMinus => f64::NAN,
    }
}
