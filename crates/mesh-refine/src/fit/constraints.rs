//! What a fit must leave alone.

use std::sync::Arc;

use mesh_core::{EdgeId, EdgeMap, Topology, VertexId, VertexMap};

use crate::curve::Curve;
use mesh_collapse::Constraints;

/// What a fit must leave alone.
#[derive(Clone, Debug, Default)]
pub struct FitConstraints {
    /// Vertices that do not move.
    pub fixed: Option<VertexMap<bool>>,
    /// Edges that are not flipped.
    pub features: Option<EdgeMap<bool>>,
    /// The boundary of the original. Boundary vertices slide along it and stay as far from it as
    /// they are; those closest to its corners do not move. Without it no boundary vertex moves.
    pub boundary_curve: Option<Arc<Curve>>,
    /// The feature lines of the original, for the vertices of the edges in `features`, in the same
    /// way.
    pub feature_curve: Option<Arc<Curve>>,
    /// Constraints that follow the mesh; they are asked about the collapses that annealing and cutting of
    /// largest errors make.
    pub constraints: Constraints,
}

impl FitConstraints {
    /// Whether an edge belongs to a feature line.
    pub fn is_feature(&self, e: EdgeId) -> bool {
        self.features.as_ref().and_then(|map| map.get(e)).is_some_and(|&feature| feature)
    }

    /// Whether a vertex does not move at all.
    pub fn is_fixed(&self, topology: &Topology, v: VertexId) -> bool {
        let by_name = self.fixed.as_ref().and_then(|map| map.get(v)).is_some_and(|&fixed| fixed);
        by_name || (self.boundary_curve.is_none() && topology.is_boundary_vertex(v))
    }
}
