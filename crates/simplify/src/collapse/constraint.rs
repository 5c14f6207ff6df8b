//! What must stay where it is: boundaries, features, and locked vertices.

use mesh_core::{EdgeId, EdgeMap, Remap, TriMesh, VertexId, VertexMap};

use crate::collapse::guard::Guards;
use crate::collapse::patch::Collapse;
use crate::collapse::policy::Policy;

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

/// What must stay; see [`crate::simplify`].
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Constraints {
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
pub(crate) struct Marks {
    /// `None` when there are none.
    pub(crate) locked: Option<VertexMap<bool>>,
    /// `None` when none were given.
    pub(crate) features: Option<EdgeMap<bool>>,
    /// They have been prepared for the mesh.
    pub(crate) guards: Guards,
}

impl Marks {
    pub(crate) fn new(mesh: &TriMesh, constraints: &Constraints, guards: Guards) -> Self {
        let topology = mesh.topology();
        let given = constraints.locked.as_ref();
        let is_locked = |v: VertexId| {
            let by_boundary =
                constraints.boundary == Boundary::Lock && topology.is_boundary_vertex(v);
            by_boundary || given.and_then(|map| map.get(v)).is_some_and(|&locked| locked)
        };
        let mut locked = topology.vertex_map(false);
        let mut any_locked = false;
        for v in topology.vertices().filter(|&v| is_locked(v)) {
            locked[v] = true;
            any_locked = true;
        }
        let features = constraints.features.as_ref().map(|given| {
            let mut features = topology.edge_map(false);
            for e in topology.edges() {
                features[e] = given.get(e).is_some_and(|&feature| feature);
            }
            features
        });
        Self { locked: any_locked.then_some(locked), features, guards }
    }

    pub(crate) fn is_locked(&self, v: VertexId) -> bool {
        self.locked.as_ref().is_some_and(|locked| locked[v])
    }

    pub(crate) fn is_feature(&self, e: EdgeId) -> bool {
        self.features.as_ref().is_some_and(|features| features[e])
    }

    /// Follows a collapse; `merged` are the edges that it has glued together, those that are gone
    /// first.
    pub(crate) fn collapsed(
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
        self.guards.collapsed(mesh, collapse);
    }

    /// The marks of the mesh without gaps, as it is now.
    pub(crate) fn compact(&self, mesh: &TriMesh, remap: &Remap) -> Self {
        let locked = self.locked.as_ref().map(|map| map.compact(remap));
        let features = self.features.as_ref().map(|map| map.compact(remap));
        let mut guards = self.guards.clone();
        guards.compacted(mesh, remap);
        Self { locked, features, guards }
    }
}
