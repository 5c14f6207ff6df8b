//! Protected parts of a mesh: boundaries, features, and locked vertices.

use mesh_core::{EdgeId, EdgeMap, FaceMap, Remap, Topology, TriMesh, VertexId, VertexMap};

use crate::constraint::{
    ComponentConstraint, Constraints, FaceLimits, IntersectionConstraint, NormalConstraint,
    ShapeConstraint,
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

/// What a mesh must keep: boundary, locked vertices and edges, feature lines, and the shape of its faces; and how much
/// its parts count.
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
    /// Edges that stay: they are neither flipped nor split, and their ends are locked; see [`Protect::keep_faces`]. A
    /// map shorter than the mesh keeps no edges beyond its end.
    pub kept: Option<EdgeMap<bool>>,
    /// Importance of each vertex, at least 0. A collapse costs as many times more as the more important of its ends
    /// says, and the vertex that remains is as important. Fit and annealing count squared distances as many times more,
    /// on each face of the input by the mean of its corners. The reduction of the largest errors lowers true distances,
    /// and uses the importance only for its collapses. A vertex beyond the end of the map has the mean of its
    /// neighbours, or 1.
    pub importance: Option<VertexMap<f64>>,
    /// Limits on edges, angles and valences of new faces.
    pub limits: FaceLimits,
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
            kept: None,
            importance: None,
            limits: FaceLimits::default(),
            min_cosine: None,
            min_shape: None,
            min_component_vertices: None,
            forbid_intersections: false,
        }
    }

    /// Adds vertices that stay exactly where they are.
    pub fn keep_vertices(&mut self, topology: &Topology, keep: impl Fn(VertexId) -> bool) {
        let locked = self.locked.get_or_insert_with(|| VertexMap::from_vec(Vec::new()));
        locked.grow_with(topology, false);
        topology.vertices().filter(|&v| keep(v)).for_each(|v| locked[v] = true);
    }

    /// Adds faces that stay exactly as they are, with their corners.
    pub fn keep_faces(&mut self, topology: &Topology, keep: &FaceMap<bool>) {
        let mut corners = topology.vertex_map(false);
        let kept = self.kept.get_or_insert_with(|| EdgeMap::from_vec(Vec::new()));
        kept.grow_with(topology, false);
        for (face, _) in keep.live(topology).filter(|(_, keep)| **keep) {
            topology.face_edges(face).into_iter().for_each(|e| kept[e] = true);
            topology.face_vertices(face).into_iter().for_each(|v| corners[v] = true);
        }
        self.keep_vertices(topology, |v| corners[v]);
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
        if self.limits.is_any() {
            constraints.push(self.limits);
        }
        // The most expensive check comes last.
        if self.forbid_intersections {
            constraints.push(IntersectionConstraint::default());
        }
        constraints
    }
}

/// The protected vertices and edges, the importance of vertices and the constraints of a mesh, updated with its
/// collapses.
#[derive(Clone, Debug, Default)]
pub struct Protected {
    /// `None` if there are none.
    pub locked: Option<VertexMap<bool>>,
    /// `None` if none were given.
    pub features: Option<EdgeMap<bool>>,
    /// Edges that stay; `None` if none were given.
    pub kept: Option<EdgeMap<bool>>,
    /// Importance of vertices; `None` if none were given.
    pub importance: Option<VertexMap<f64>>,
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
        let of_mesh = |given: &EdgeMap<bool>| {
            let mut marks = topology.edge_map(false);
            for e in topology.edges() {
                marks[e] = given.get(e).is_some_and(|&mark| mark);
            }
            marks
        };
        Self {
            locked: any_locked.then_some(locked),
            features: protect.features.as_ref().map(of_mesh),
            kept: protect.kept.as_ref().map(of_mesh),
            importance: protect.importance.as_ref().map(|given| importance(topology, given)),
            constraints,
        }
    }

    /// Whether a vertex neither moves nor vanishes.
    pub fn is_locked(&self, v: VertexId) -> bool {
        self.locked.as_ref().is_some_and(|locked| locked[v])
    }

    /// Whether an edge belongs to a feature line.
    pub fn is_feature(&self, e: EdgeId) -> bool {
        self.features.as_ref().is_some_and(|features| features[e])
    }

    /// The factor on the cost of an edge with these ends.
    #[inline]
    pub(crate) fn cost_factor(&self, ends: [VertexId; 2]) -> f64 {
        self.importance.as_ref().map_or(1.0, |map| map[ends[0]].max(map[ends[1]]))
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
        if let Some(importance) = &mut self.importance {
            importance[kept] = importance[kept].max(importance[removed]);
        }
        for marks in [&mut self.features, &mut self.kept].into_iter().flatten() {
            for (gone, stays) in merged.into_iter().flatten() {
                marks[stays] |= marks[gone];
            }
        }
        self.constraints.collapsed(mesh, collapse);
    }

    /// The protected elements of the mesh after its gaps were closed.
    pub fn compact(&self, mesh: &TriMesh, remap: &Remap) -> Self {
        let locked = self.locked.as_ref().map(|map| map.compact(remap));
        let features = self.features.as_ref().map(|map| map.compact(remap));
        let kept = self.kept.as_ref().map(|map| map.compact(remap));
        let importance = self.importance.as_ref().map(|map| map.compact(remap));
        let mut constraints = self.constraints.clone();
        constraints.compacted(mesh, remap);
        Self { locked, features, kept, importance, constraints }
    }
}

/// The importance of all vertices of a mesh from the importance of the first ones.
fn importance(topology: &Topology, given: &VertexMap<f64>) -> VertexMap<f64> {
    VertexMap::from_fn(topology, |v| {
        if let Some(&known) = given.get(v) {
            return known;
        }
        let ring = topology.contains_vertex(v).then(|| topology.one_ring(v)).into_iter().flatten();
        let known = ring.filter_map(|w| given.get(w).copied());
        let (sum, count) = known.fold((0.0, 0), |(sum, count), known| (sum + known, count + 1));
        if count > 0 { sum / f64::from(count) } else { 1.0 }
    })
}
