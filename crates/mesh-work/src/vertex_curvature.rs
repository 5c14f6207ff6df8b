//! Discrete curvature of every vertex, from angles and dihedral angles.

use dcurv::{CurvatureOptions, Curvatures, VertexArea, VertexCurvature};
use mesh_core::{TriMesh, VertexMap};

use crate::quantity::{Integrals, Quantity};

/// The discrete curvature of every vertex.
#[derive(Clone, Debug)]
pub struct VertexValues {
    /// Curvatures with their integrals.
    pub curvatures: Curvatures,
    /// The Willmore energy of each vertex.
    pub willmore: VertexMap<f64>,
}

impl VertexValues {
    /// Of a mesh; `area` is what belongs to a vertex.
    #[must_use]
    pub fn of(mesh: &TriMesh, area: VertexArea) -> Self {
        let (curvatures, willmore) =
            Curvatures::with_willmore_energies(mesh, &CurvatureOptions { area });
        Self { curvatures, willmore }
    }

    /// One quantity, pointwise but for the Willmore energy.
    #[must_use]
    pub fn of_quantity(&self, quantity: Quantity) -> VertexMap<f64> {
        let map = |value: fn(&VertexCurvature) -> f64| self.curvatures.map(value);
        match quantity {
            Quantity::Gaussian => map(|c| c.gaussian().value()),
            Quantity::Mean => map(|c| c.mean().value()),
            Quantity::AbsMean => map(|c| c.abs_mean().value()),
            Quantity::K1 => map(|c| c.principal()[0].value()),
            Quantity::K2 => map(|c| c.principal()[1].value()),
            Quantity::AbsSum => map(|c| c.abs_principal_sum().value()),
            Quantity::Willmore => self.willmore.clone(),
            Quantity::ShapeIndex => map(VertexCurvature::shape_index),
            Quantity::Curvedness => map(|c| c.curvedness().value()),
        }
    }

    /// The sums over the mesh.
    #[must_use]
    pub fn integrals(&self) -> Integrals {
        Integrals::new(&self.curvatures.totals(), self.willmore.as_slice().iter().sum())
    }
}
