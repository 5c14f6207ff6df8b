//! Curvature of one vertex.

use core::f64::consts::FRAC_2_PI;

use mesh_core::{TriMesh, VertexId};

use crate::area::VertexArea;
use crate::atan2::atan2;
use crate::quantity::Pointwise;
use crate::star::{VertexIntegrals, vertex_integrals};

/// Curvature of a vertex: integrals and pointwise values.
///
/// **Boundary.** At a boundary vertex the angle defect is the geodesic curvature of the boundary, not a
/// curvature of the surface. It stays in [`integrals`](Self::integrals), so that sums over the mesh
/// satisfy the Gauss-Bonnet theorem. All other values use a Gaussian curvature of 0 there. The mean
/// curvature is the sum over interior edges.
///
/// **Degenerate cases.** If the area is 0, all pointwise values are 0. An isolated vertex has no
/// curvature and no area. No value is NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct VertexCurvature {
    integrals: VertexIntegrals,
    principal: [Pointwise; 2],
    boundary: bool,
    clamped: bool,
}

/// The curvature of a vertex of a mesh.
///
/// # Panics
/// When the vertex is out of range for this mesh.
#[inline]
#[must_use]
pub fn vertex_curvature(mesh: &TriMesh, vertex: VertexId, area: VertexArea) -> VertexCurvature {
    let boundary = mesh.topology().is_boundary_vertex(vertex);
    VertexCurvature::from_integrals(vertex_integrals(mesh, vertex, area), boundary)
}

impl VertexCurvature {
    /// The curvature from integrals, for example of a [`VertexStar`](crate::VertexStar).
    #[inline(always)]
    #[must_use]
    pub fn from_integrals(integrals: VertexIntegrals, boundary: bool) -> Self {
        let gaussian = if boundary { Pointwise::default() } else { gaussian(&integrals) };
        let mean = integrals.mean / integrals.area;
        let (h, k) = (mean.value(), gaussian.value());
        let discriminant = h * h - k;
        let clamped = discriminant < 0.0;
        let root = discriminant.max(0.0).sqrt();
        let principal = [h + root, h - root].map(Pointwise::new);
        Self { integrals, principal, boundary, clamped }
    }

    /// The integrals over the area of the vertex.
    #[inline]
    #[must_use]
    pub fn integrals(&self) -> &VertexIntegrals {
        &self.integrals
    }

    /// Whether the vertex lies on the boundary, so that its angle defect is geodesic curvature.
    #[inline]
    #[must_use]
    pub fn is_boundary(&self) -> bool {
        self.boundary
    }

    /// Whether H² < K, which is impossible on a smooth surface. The principal curvatures then use H² = K.
    #[inline]
    #[must_use]
    pub fn is_clamped(&self) -> bool {
        self.clamped
    }

    /// The Gaussian curvature K, per square of the model unit; 0 at boundary vertices.
    #[inline(always)]
    #[must_use]
    pub fn gaussian(&self) -> Pointwise {
        if self.boundary { Pointwise::default() } else { gaussian(&self.integrals) }
    }

    /// The mean curvature H, positive where convex, per model unit.
    #[inline(always)]
    #[must_use]
    pub fn mean(&self) -> Pointwise {
        self.integrals.mean / self.integrals.area
    }

    /// The absolute mean curvature |H|, per model unit.
    #[inline]
    #[must_use]
    pub fn abs_mean(&self) -> Pointwise {
        self.mean().abs()
    }

    /// `1/4 sum of |e| |beta|` per area, per model unit: the |H| of DHKL01. At least
    /// [`abs_mean`](Self::abs_mean), and larger where convex and concave edges meet, as at a saddle.
    #[inline]
    #[must_use]
    pub fn abs_dihedral(&self) -> Pointwise {
        self.integrals.abs_dihedral / self.integrals.area
    }

    /// The principal curvatures `k1 >= k2 = H ± sqrt(max(H² - K, 0))` (KKL02 sec. 3.1), per model
    /// unit.
    #[inline]
    #[must_use]
    pub fn principal(&self) -> [Pointwise; 2] {
        self.principal
    }

    /// `|k1| + |k2|`: `2 |H|` where K is not negative, else `2 sqrt(H² - K)` (KKL02 sec. 3.1), per
    /// model unit. H is the signed mean curvature.
    #[inline(always)]
    #[must_use]
    pub fn abs_principal_sum(&self) -> Pointwise {
        let (h, k) = (self.mean().value(), self.gaussian().value());
        Pointwise::new(2.0 * (h * h - k.min(0.0)).sqrt())
    }

    /// `k1² + k2² = 4 H² - 2 K` (KKL02 eq. 2), per square of the model unit. Less than 0 only where
    /// [clamped](Self::is_clamped).
    #[inline(always)]
    #[must_use]
    pub fn squared_principal_sum(&self) -> Pointwise {
        let (h, k) = (self.mean().value(), self.gaussian().value());
        Pointwise::new(4.0 * h * h - 2.0 * k)
    }

    /// The shape index of Koenderink and van Doorn 1992, `2/pi atan((k1 + k2) / (k1 - k2))`: 1 for
    /// a spherical cap, 1/2 for a ridge, 0 for a saddle, -1/2 for a rut, -1 for a cup. 0 at a
    /// flat vertex, where the shape is undefined.
    #[must_use]
    pub fn shape_index(&self) -> f64 {
        let [k1, k2] = self.principal.map(Pointwise::value);
        FRAC_2_PI * atan2(k1 + k2, k1 - k2)
    }

    /// The curvedness of Koenderink and van Doorn 1992, `sqrt((k1² + k2²) / 2)`, per model unit.
    #[must_use]
    pub fn curvedness(&self) -> Pointwise {
        let [k1, k2] = self.principal.map(Pointwise::value);
        Pointwise::new((0.5 * (k1 * k1 + k2 * k2)).sqrt())
    }
}

#[inline(always)]
fn gaussian(integrals: &VertexIntegrals) -> Pointwise {
    integrals.angle_defect / integrals.area
}
