//! Curvature summed over a mesh: the costs of DHKL01 and the norms of KKL02.

use mesh_core::{VertexId, parallel};

use crate::curvatures::Curvatures;
use crate::quantity::{Area, Integral};
use crate::vertex::VertexCurvature;

/// Sums over the vertices of a mesh. Names with a paper's symbol keep it; bars are integrals.
///
/// At boundary vertices the Gaussian curvature is taken as 0, except in `gaussian`; see
/// [`VertexCurvature`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Totals {
    /// The sum of all angle defects, those of the boundary included: `2 pi` times the Euler
    /// characteristic of the part of the mesh that has faces.
    pub gaussian: Integral,
    /// The sum of `|K̄|`, as of Alboul and van Damme.
    pub abs_gaussian: Integral,
    /// The sum of `H̄`.
    pub mean: Integral,
    /// The sum of `|H̄|`, which is F2 of DHKL01.
    pub abs_mean: Integral,
    /// F1 of DHKL01: the sum of `|H̄|² / S`, which is the integral of H². No unit. Vertices without
    /// area add nothing.
    pub f1: f64,
    /// F3 of DHKL01: the sum of `S (|k1| + |k2|)`, which is `2 |H̄|` where `K̄` is not negative, else
    /// `2 sqrt(|H̄|² - S K̄)`. In model units.
    pub f3: f64,
    /// KKL02 eq. 1: the sum of the pointwise `|k1| + |k2|`. Per model unit; the paper has
    /// barycentric areas.
    pub norm_l1: f64,
    /// KKL02 eq. 2: the sum of the pointwise `k1² + k2²`. Per square of the model unit; the paper
    /// has barycentric areas.
    pub norm_l2_squared: f64,
    /// The sum of the vertex areas, which is the area of the mesh.
    pub area: Area,
    /// How many vertices had H² < K, so that their principal curvatures were clamped.
    pub clamped: usize,
    /// How many vertices lie on the boundary.
    pub boundary: usize,
    /// How many vertices have no area, isolated ones included; their pointwise values are 0.
    pub without_area: usize,
}

impl Totals {
    /// F2 of DHKL01: another name for [`Totals::abs_mean`]. In model units.
    #[must_use]
    pub fn f2(&self) -> f64 {
        self.abs_mean.value()
    }

    fn of_vertex(curvature: &VertexCurvature) -> Self {
        let integrals = curvature.integrals();
        let (h, s) = (integrals.abs_mean.value(), integrals.area.value());
        let defect = integrals.angle_defect;
        let k = if curvature.is_boundary() { Integral::default() } else { defect };
        Self {
            gaussian: defect,
            abs_gaussian: k.abs(),
            mean: integrals.mean,
            abs_mean: integrals.abs_mean,
            f1: h * curvature.abs_mean().value(),
            f3: 2.0 * (h * h - s * k.value().min(0.0)).sqrt(),
            norm_l1: curvature.abs_principal_sum().value(),
            norm_l2_squared: curvature.squared_principal_sum().value(),
            area: integrals.area,
            clamped: usize::from(curvature.is_clamped()),
            boundary: usize::from(curvature.is_boundary()),
            without_area: usize::from(s == 0.0),
        }
    }

    /// The sums over the vertices of two parts, none of which is in both.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            gaussian: self.gaussian + other.gaussian,
            abs_gaussian: self.abs_gaussian + other.abs_gaussian,
            mean: self.mean + other.mean,
            abs_mean: self.abs_mean + other.abs_mean,
            f1: self.f1 + other.f1,
            f3: self.f3 + other.f3,
            norm_l1: self.norm_l1 + other.norm_l1,
            norm_l2_squared: self.norm_l2_squared + other.norm_l2_squared,
            area: self.area + other.area,
            clamped: self.clamped + other.clamped,
            boundary: self.boundary + other.boundary,
            without_area: self.without_area + other.without_area,
        }
    }
}

impl Curvatures {
    /// The sums over all vertices.
    #[must_use]
    pub fn totals(&self) -> Totals {
        self.totals_where(|_| true)
    }

    /// The sums over the vertices that do not lie on the boundary.
    #[must_use]
    pub fn interior_totals(&self) -> Totals {
        self.totals_where(|curvature| !curvature.is_boundary())
    }

    /// The sums over some vertices.
    ///
    /// # Panics
    /// One of them is not there.
    #[must_use]
    pub fn totals_of(&self, vertices: &[VertexId]) -> Totals {
        let of_index = |index: usize| Totals::of_vertex(&self.vertices()[vertices[index]]);
        parallel::fold(vertices.len(), Totals::default(), of_index, Totals::plus)
    }

    /// The sums over the vertices that are chosen.
    pub fn totals_where(&self, chosen: impl Fn(&VertexCurvature) -> bool + Sync) -> Totals {
        let all = self.vertices().as_slice();
        let of_index = |index: usize| {
            let curvature = &all[index];
            if chosen(curvature) { Totals::of_vertex(curvature) } else { Totals::default() }
        };
        parallel::fold(all.len(), Totals::default(), of_index, Totals::plus)
    }
}
