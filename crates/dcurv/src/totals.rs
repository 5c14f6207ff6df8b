//! Sums of curvature over a mesh: the costs of DHKL01 and the norms of KKL02.

use mesh_core::{VertexId, parallel};

use crate::curvatures::Curvatures;
use crate::quantity::{Area, Integral};
use crate::vertex::VertexCurvature;

/// Sums over the vertices of a mesh. The symbols are taken from the papers; a bar denotes an integral.
///
/// The Gaussian curvature of boundary vertices is 0, except in `gaussian`; see [`VertexCurvature`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Totals {
    /// Sum of all angle defects, including the boundary: `2 pi` times the Euler characteristic of the
    /// vertices, edges and faces that belong to faces.
    pub gaussian: Integral,
    /// Sum of `|K̄|`. This is not the total absolute curvature of Alboul and van Damme, which is
    /// [`total_extrinsic_curvature`](crate::total_extrinsic_curvature).
    pub abs_gaussian: Integral,
    /// Sum of `H̄`.
    pub mean: Integral,
    /// Sum of the absolute values of `H̄`.
    pub abs_mean: Integral,
    /// Sum of `1/4 sum of |e| |beta|`, which is F2 of DHKL01.
    pub abs_dihedral: Integral,
    /// F1 of DHKL01: sum of `|H̄|² / S`, the integral of H². No unit. Vertices without area add nothing.
    pub f1: f64,
    /// F3 of DHKL01: sum of `S (|k1| + |k2|)`, which is `2 |H̄|` where `K̄` is not negative, else
    /// `2 sqrt(|H̄|² - S K̄)`. In model units.
    pub f3: f64,
    /// KKL02 eq. 1: sum of the pointwise `|k1| + |k2|`. Per model unit. The paper uses barycentric areas.
    pub norm_l1: f64,
    /// KKL02 eq. 2: sum of the pointwise `k1² + k2²`. Per square of the model unit. The paper uses
    /// barycentric areas.
    pub norm_l2_squared: f64,
    /// Sum of the vertex areas: the area of the mesh.
    pub area: Area,
    /// Number of vertices with H² < K, where principal curvatures use H² = K.
    pub clamped: usize,
    /// Number of boundary vertices.
    pub boundary: usize,
    /// Number of vertices without area, including isolated ones. Their pointwise values are 0.
    pub without_area: usize,
}

impl Totals {
    /// F2 of DHKL01, equal to [`Totals::abs_dihedral`]. In model units.
    #[must_use]
    pub fn f2(&self) -> f64 {
        self.abs_dihedral.value()
    }

    /// Thin-plate energy of DHKL01 sec. 3: `4 a` times the integral of H² plus `2 (1 - a - b)` times the
    /// integral of K.
    ///
    /// The integral of H² is F1. The integral of K is [`Totals::gaussian`], which is `2 pi` times the
    /// Euler characteristic. Flips do not change it, so they lower this energy exactly if they lower F1
    /// (for `a > 0`). No unit.
    #[must_use]
    pub fn thin_plate_energy(&self, a: f64, b: f64) -> f64 {
        4.0 * a * self.f1 + 2.0 * (1.0 - a - b) * self.gaussian.value()
    }

    fn of_vertex(curvature: &VertexCurvature) -> Self {
        let integrals = curvature.integrals();
        let (h, s) = (integrals.abs_dihedral.value(), integrals.area.value());
        let defect = integrals.angle_defect;
        let k = if curvature.is_boundary() { Integral::default() } else { defect };
        Self {
            gaussian: defect,
            abs_gaussian: k.abs(),
            mean: integrals.mean,
            abs_mean: integrals.mean.abs(),
            abs_dihedral: integrals.abs_dihedral,
            f1: h * curvature.abs_dihedral().value(),
            f3: 2.0 * (h * h - s * k.value().min(0.0)).sqrt(),
            norm_l1: curvature.abs_principal_sum().value(),
            norm_l2_squared: curvature.squared_principal_sum().value(),
            area: integrals.area,
            clamped: usize::from(curvature.is_clamped()),
            boundary: usize::from(curvature.is_boundary()),
            without_area: usize::from(s == 0.0),
        }
    }

    /// The sums over two disjoint sets of vertices.
    #[must_use]
    pub fn plus(self, other: Self) -> Self {
        Self {
            gaussian: self.gaussian + other.gaussian,
            abs_gaussian: self.abs_gaussian + other.abs_gaussian,
            mean: self.mean + other.mean,
            abs_mean: self.abs_mean + other.abs_mean,
            abs_dihedral: self.abs_dihedral + other.abs_dihedral,
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

    /// The sums over the interior vertices.
    #[must_use]
    pub fn interior_totals(&self) -> Totals {
        self.totals_where(|curvature| !curvature.is_boundary())
    }

    /// The sums over some vertices.
    ///
    /// # Panics
    /// When a vertex is out of range.
    #[must_use]
    pub fn totals_of(&self, vertices: &[VertexId]) -> Totals {
        let of_index = |index: usize| Totals::of_vertex(&self.vertices()[vertices[index]]);
        parallel::fold(vertices.len(), Totals::default(), of_index, Totals::plus)
    }

    /// The sums over the chosen vertices.
    pub fn totals_where(&self, chosen: impl Fn(&VertexCurvature) -> bool + Sync) -> Totals {
        let all = self.vertices().as_slice();
        let of_index = |index: usize| {
            let curvature = &all[index];
            if chosen(curvature) { Totals::of_vertex(curvature) } else { Totals::default() }
        };
        parallel::fold(all.len(), Totals::default(), of_index, Totals::plus)
    }
}
