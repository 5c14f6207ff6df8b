//! What must stay where it is: boundaries, features, and locked vertices.

use mesh_core::{EdgeId, EdgeMap, Remap, TriMesh, VertexId, VertexMap};

use crate::constraint::Constraints;
use crate::geometry::edge_patch::Collapse;
use crate::policy::Policy;

/// How the boundary of an open mesh is treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Boundary {
    /// Boundary edges have quadrics of their own that keep the boundary close to where it was:
    /// for each the plane through the edge, perpendicular to its face, with half the squared
    /// length of the edge as weight at each end.
    #[default]
    Quadrics,
    /// Boundary vertices do not move and do not go.
    Lock,
    /// The boundary is not treated specially.
    Free,
}

/// Vertices and edges that must stay.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Protect {
    /// How the boundary is treated.
    pub boundary: Boundary,
    /// Vertices that neither move nor go. A map shorter than the mesh locks nothing beyond its
    /// end.
    pub locked: Option<VertexMap<bool>>,
    /// Edges of feature lines. A vertex on a line may only move to another vertex of the same
    /// line, close to the line; ends, forks and crossings of lines are locked. A map shorter than
    /// the mesh has no features beyond its end.
    pub features: Option<EdgeMap<bool>>,
}

/// The locked vertices, the feature edges and the guards of a mesh, to follow it through its
/// collapses.
#[derive(Clone, Debug, Default)]
pub struct Protected {
    /// `None` when there are none.
    pub locked: Option<VertexMap<bool>>,
    /// `None` when none were given.
    pub features: Option<EdgeMap<bool>>,
    /// They have been prepared for the mesh.
    pub constraints: Constraints,
}

impl Protected {
    /// The protected elements of a mesh. `constraints` must be prepared for the mesh already.
    pub fn new(mesh: &TriMesh, protect: &Protect, constraints: Constraints) -> Self {
        let topology = mesh.topology();
        let given = protect.locked.as_ref();
        let is_locked = |v: VertexId| {
            let by_boundary = protect.boundary == Boundary::Lock && topology.is_boundary_vertex(v);
            by_boundary || given.and_then(|map| map.get(v)).is_some_and(|&locked| locked)
        };
        let mut locked = topology.vertex_map(false);
        let mut any_locked = false;
        for v in topology.vertices().filter(|&v| is_locked(v)) {
            locked[v] = true;
            any_locked = true;
        }
        let features = protect.features.as_ref().map(|given| {
            let mut features = topology.edge_map(false);
            for e in topology.edges() {
                features[e] = given.get(e).is_some_and(|&feature| feature);
            }
            features
        });
        Self { locked: any_locked.then_some(locked), features, constraints }
    }

    /// Whether a vertex neither moves nor vanishes.
    pub fn is_locked(&self, v: VertexId) -> bool {
        self.locked.as_ref().is_some_and(|locked| locked[v])
    }

    /// Whether an edge belongs to a feature line.
    pub fn is_feature(&self, e: EdgeId) -> bool {
        self.features.as_ref().is_some_and(|features| features[e])
    }

    /// Follows a collapse; `merged` are the edges that it has glued together, those that are gone
    /// first.
    pub fn collapsed(
        &mut self,
        mesh: &TriMesh,
        collapse: &Collapse,
        merged: [Option<(EdgeId, EdgeId)>; 2],
    ) {
        let Collapse { removed, kept, .. } = *collapse;
        if let Some(locked) = &mut self.locked {
            locked[kept] |= locked[removed];
        }
        if let Some(features) = &mut self.features {
            for (gone, stays) in merged.into_iter().flatten() {
                features[stays] |= features[gone];
            }
        }
        self.constraints.collapsed(mesh, collapse);
    }

    /// The marks of the mesh without gaps, as it is now.
    pub fn compact(&self, mesh: &TriMesh, remap: &Remap) -> Self {
        let locked = self.locked.as_ref().map(|map| map.compact(remap));
        let features = self.features.as_ref().map(|map| map.compact(remap));
        let mut constraints = self.constraints.clone();
        constraints.compacted(mesh, remap);
        Self { locked, features, constraints }
    }
}
