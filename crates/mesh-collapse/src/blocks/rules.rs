//! The options of a run in blocks, as rules for each block.

use mesh_core::TriMesh;

/// Rules of collapses in blocks.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Rules {
    /// Whether errors already made are subtracted; see [`GarlandHeckbert`](crate::GarlandHeckbert).
    pub marginal: bool,
    /// Whether positions must keep the volume; see [`Optimal`](crate::Optimal).
    pub keep_volume: bool,
    /// Whether boundary edges have quadrics; see [`Boundary`](crate::Boundary).
    pub border: bool,
    /// See [`NormalConstraint`](crate::NormalConstraint).
    pub min_cosine: Option<f64>,
    /// See [`ShapeConstraint`](crate::ShapeConstraint).
    pub min_shape: Option<f64>,
    /// Whether collapses are recorded.
    pub record: bool,
    /// The reciprocal of the fourth power of the size of the mesh, which is the unit of costs.
    pub scale: f64,
}

impl Rules {
    /// The rules of the preset `draft` of the crate `simplify` for a mesh.
    #[must_use]
    pub fn new(mesh: &TriMesh) -> Self {
        Self::of_size(mesh.bounding_box().map_or(0.0, |bounds| bounds.diagonal()))
    }

    /// The rules of [`Rules::new`] for a mesh of this size, which is the diagonal of its bounding box.
    #[must_use]
    pub fn of_size(size: f64) -> Self {
        let scale = size.powi(4).recip();
        Self {
            marginal: true,
            keep_volume: false,
            border: true,
            min_cosine: Some(0.2),
            min_shape: Some(0.01),
            record: false,
            scale: if scale.is_finite() { scale } else { 1.0 },
        }
    }
}
