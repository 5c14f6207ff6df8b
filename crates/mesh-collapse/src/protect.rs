//! Protected parts of a mesh: boundaries, features, and locked vertices.

use mesh_core::{EdgeId, EdgeMap, Remap, TriMesh, VertexId, VertexMap};

use crate::constraint::{
    ComponentConstraint, Constraints, IntersectionConstraint, NormalConstraint, ShapeConstraint,
};
use crate::geometry::edge_patch::Collapse;
use crate::policy::Policy;

/// How the boundary of an open mesh is treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Boundary {
    /// Boundary edges have their own quadrics, which keep the boundary close to its old position. Each edge has a plane
    /// through it, perpendicular to its face, with half the squared edge length as the weight at each end.
    #[default]
    Quadrics,
    /// Boundary vertices neither move nor vanish.
    Lock,
    /// The boundary is not treated specially.
    Free,
}

/// What a mesh must keep: boundary, locked vertices, feature lines, and the shape of its faces.
///
/// Every stage obeys the same set. [`Protect::default`] rejects collapses that fold the surface or make slivers;
/// [`Protect::nothing`] rejects nothing.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Protect {
    /// How the boundary of an open mesh is treated.
    pub boundary: Boundary,
    /// Vertices that neither move nor vanish. A map shorter than the mesh locks nothing beyond its end.
    pub locked: Option<VertexMap<bool>>,
    /// Edges of feature lines. A vertex on a line may only merge with another vertex of the same line, close to the
    /// line; ends, forks and crossings of lines are locked. A map shorter than the mesh has no features beyond its
    /// end.
    pub features: Option<EdgeMap<bool>>,
    /// Smallest cosine between the normals of a face before and after a collapse; `None` allows any turn. See
    /// [`NormalConstraint`].
    pub min_cosine: Option<f64>,
    /// Shape below which faces must not get worse; `None` allows any shape. See [`ShapeConstraint`].
    pub min_shape: Option<f64>,
    /// Number of vertices that every component keeps; `None` for no limit. See [`ComponentConstraint`].
    pub min_component_vertices: Option<usize>,
    /// Whether faces must not intersect if they did not before. See [`IntersectionConstraint`].
    pub forbid_intersections: bool,
}

impl Default for Protect {
    fn default() -> Self {
        Self {
            min_cosine: Some(NormalConstraint::default().min_cosine),
            min_shape: Some(ShapeConstraint::default().min_shape),
            boundary: Boundary::default(),
            ..Self::nothing()
        }
    }
}

impl Protect {
    /// Nothing is protected, not even the boundary.
    #[must_use]
    pub fn nothing() -> Self {
        Self {
            boundary: Boundary::Free,
            locked: None,
            features: None,
            min_cosine: None,
            min_shape: None,
            min_component_vertices: None,
            forbid_intersections: false,
        }
    }

    /// The constraints on collapses that follow from the limits on faces and components.
    #[must_use]
    pub fn constraints(&self) -> Constraints {
        let mut constraints = Constraints::default();
        if let Some(min_vertices) = self.min_component_vertices {
            constraints.push(ComponentConstraint::new(min_vertices));
        }
        if let Some(min_cosine) = self.min_cosine {
            constraints.push(NormalConstraint { min_cosine });
        }
        if let Some(min_shape) = self.min_shape {
            constraints.push(ShapeConstraint { min_shape });
        }
        // The most expensive check comes last.
        if self.forbid_intersections {
            constraints.push(IntersectionConstraint::default());
        }
        constraints
    }
}

/// The locked vertices, the feature edges and the constraints of a mesh, updated with its collapses.
#[derive(Clone, Debug, Default)]
pub struct Protected {
    /// `None` if there are none.
    pub locked: Option<VertexMap<bool>>,
    /// `None` if none were given.
    pub features: Option<EdgeMap<bool>>,
    /// The constraints, already prepared for the mesh.
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

    /// Updates the data after a collapse; `merged` are pairs of edges that were merged, the removed edge first.
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

    /// The protected elements of the mesh after its gaps were closed.
    pub fn compact(&self, mesh: &TriMesh, remap: &Remap) -> Self {
        let locked = self.locked.as_ref().map(|map| map.compact(remap));
        let features = self.features.as_ref().map(|map| map.compact(remap));
        let mut constraints = self.constraints.clone();
        constraints.compacted(mesh, remap);
        Self { locked, features, constraints }
    }
}
