//! Constraints of a fit.

use std::sync::Arc;

use mesh_core::{EdgeId, EdgeMap, Topology, VertexId, VertexMap};

use crate::curve::Curve;
use mesh_collapse::{Constraints, FaceLimits};

/// Constraints of a fit.
#[derive(Clone, Debug, Default)]
pub struct FitConstraints {
    /// Vertices that do not move.
    pub fixed: Option<VertexMap<bool>>,
    /// Edges of feature lines. They are not flipped.
    pub features: Option<EdgeMap<bool>>,
    /// The boundary of the original. Boundary vertices move along it and keep their distance to it; the vertices
    /// closest to its corners do not move. Without it, no boundary vertex moves.
    pub boundary_curve: Option<Arc<Curve>>,
    /// The feature lines of the original. Vertices of the edges in `features` move along them in the same way.
    pub feature_curve: Option<Arc<Curve>>,
    /// Edges that are neither flipped nor split.
    pub kept: Option<EdgeMap<bool>>,
    /// Limits on edges, angles and valences of new faces.
    pub limits: FaceLimits,
    /// Importance of the vertices in collapses; see [`Protect::importance`](mesh_collapse::Protect::importance).
    pub importance: Option<VertexMap<f64>>,
    /// Factor on the squared distances at each triangle of the original.
    pub original_importance: Option<Arc<[f64]>>,
    /// Constraints that follow the mesh. They apply to the collapses of annealing and of the reduction of the largest
    /// errors.
    pub constraints: Constraints,
}

impl FitConstraints {
    /// Whether an edge belongs to a feature line.
    pub fn is_feature(&self, e: EdgeId) -> bool {
        self.features.as_ref().and_then(|map| map.get(e)).is_some_and(|&feature| feature)
    }

    /// Whether an edge is neither flipped nor split.
    pub fn is_held(&self, e: EdgeId) -> bool {
        self.is_feature(e) || self.kept.as_ref().and_then(|map| map.get(e)) == Some(&true)
    }

    /// Whether a vertex does not move at all.
    pub fn is_fixed(&self, topology: &Topology, v: VertexId) -> bool {
        let by_name = self.fixed.as_ref().and_then(|map| map.get(v)).is_some_and(|&fixed| fixed);
        by_name || (self.boundary_curve.is_none() && topology.is_boundary_vertex(v))
    }
}
