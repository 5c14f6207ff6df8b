//! Discrete curvature of every vertex, from angles and dihedral angles.

use dcurv::{
    CurvatureOptions, Curvatures, ExtrinsicCurvature, VertexArea, VertexCurvature,
    extrinsic_curvatures,
};
use mesh_core::{TriMesh, VertexMap};

use crate::quantity::{Integrals, Quantity};

/// The discrete curvature of every vertex.
#[derive(Clone, Debug)]
pub struct VertexValues {
    /// Curvatures with their integrals.
    pub curvatures: Curvatures,
    /// The Willmore energy of each vertex.
    pub willmore: VertexMap<f64>,
    /// The extrinsic curvature of each vertex.
    pub extrinsic: VertexMap<ExtrinsicCurvature>,
    /// Whether each vertex has faces. A vertex without faces has no curvature.
    pub is_used: VertexMap<bool>,
}

impl VertexValues {
    /// Of a mesh; `area` is the area of a vertex.
    #[must_use]
    pub fn of(mesh: &TriMesh, area: VertexArea) -> Self {
        let (curvatures, willmore) =
            Curvatures::with_willmore_energies(mesh, &CurvatureOptions { area });
        let topology = mesh.topology();
        let mut is_used = topology.vertex_map(false);
        topology.vertices().for_each(|v| is_used[v] = !topology.is_isolated_vertex(v));
        Self { curvatures, willmore, extrinsic: extrinsic_curvatures(mesh), is_used }
    }

    /// One quantity; NaN for vertices without faces. [Quantities of stars](Quantity::is_of_star) are per
    /// vertex, the others pointwise.
    #[must_use]
    pub fn of_quantity(&self, quantity: Quantity) -> VertexMap<f64> {
        let mut values = self.with_unused(quantity);
        for (value, &is_used) in values.as_mut_slice().iter_mut().zip(self.is_used.as_slice()) {
            *value = if is_used { *value } else { f64::NAN };
        }
        values
    }

    /// One quantity; unspecified for vertices without faces.
    fn with_unused(&self, quantity: Quantity) -> VertexMap<f64> {
        let map = |value: fn(&VertexCurvature) -> f64| self.curvatures.map(value);
        match quantity {
            Quantity::Gaussian => map(|c| c.gaussian().value()),
            Quantity::Mean => map(|c| c.mean().value()),
            Quantity::AbsMean => map(|c| c.abs_mean().value()),
            Quantity::AbsDihedral => map(|c| c.abs_dihedral().value()),
            Quantity::K1 => map(|c| c.principal()[0].value()),
            Quantity::K2 => map(|c| c.principal()[1].value()),
            Quantity::AbsSum => map(|c| c.abs_principal_sum().value()),
            Quantity::Willmore => self.willmore.clone(),
            Quantity::KPlus => self.extrinsic.map(|e| e.positive.value()),
            Quantity::KMinus => self.extrinsic.map(|e| e.negative.value()),
            Quantity::ShapeIndex => map(VertexCurvature::shape_index),
            Quantity::Curvedness => map(|c| c.curvedness().value()),
        }
    }

    /// The total absolute extrinsic curvature, in radians.
    #[must_use]
    pub fn total_extrinsic(&self) -> f64 {
        self.extrinsic.as_slice().iter().map(|e| e.absolute().value()).sum()
    }

    /// The sums over the mesh.
    #[must_use]
    pub fn integrals(&self) -> Integrals {
        Integrals::new(&self.curvatures.totals(), self.willmore.as_slice().iter().sum())
    }
}
