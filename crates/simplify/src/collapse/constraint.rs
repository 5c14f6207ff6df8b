//! What must stay where it is: boundaries, features, and locked vertices.

use mesh_core::{EdgeId, EdgeMap, Topology, TriMesh, VertexId, VertexMap};

use crate::collapse::cost::Collapse;
use crate::collapse::guard::Refusal;
use crate::collapse::patch::{EdgePatch, Place};
use crate::collapse::quadric::Quadric;

/// How the boundary of an open mesh is treated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
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

/// The constraints during a run, kept up to date.
#[derive(Clone, Debug)]
pub(crate) struct Fixed {
    locked: Option<VertexMap<bool>>,
    features: Option<EdgeMap<bool>>,
    /// The quadrics of border edges at each vertex, about its position. Empty when nothing has
    /// one.
    borders: Vec<Quadric>,
}

impl Fixed {
    pub(crate) fn new(mesh: &TriMesh, constraints: &Constraints) -> Self {
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
        let mut fixed =
            Self { locked: any_locked.then_some(locked), features, borders: Vec::new() };
        fixed.borders = fixed.border_quadrics(mesh, constraints.boundary != Boundary::Free);
        fixed
    }

    /// The locked vertices and the feature edges, as they are by now.
    pub(crate) fn into_maps(self) -> (Option<VertexMap<bool>>, Option<EdgeMap<bool>>) {
        (self.locked, self.features)
    }

    fn is_locked(&self, v: VertexId) -> bool {
        self.locked.as_ref().is_some_and(|locked| locked[v])
    }

    fn is_feature(&self, e: EdgeId) -> bool {
        self.features.as_ref().is_some_and(|features| features[e])
    }

    fn border_quadrics(&self, mesh: &TriMesh, with_boundary: bool) -> Vec<Quadric> {
        let topology = mesh.topology();
        let mut quadrics = Vec::new();
        let is_border =
            |&e: &EdgeId| self.is_feature(e) || (with_boundary && topology.is_boundary_edge(e));
        for e in topology.edges().filter(is_border) {
            if quadrics.is_empty() {
                quadrics = vec![Quadric::default(); topology.vertex_capacity()];
            }
            let [from, to] = topology.edge_vertices(e);
            let along = mesh.position(to) - mesh.position(from);
            for face in topology.edge_faces(e).into_iter().flatten() {
                // Unit length times the length of the edge, so that the weight is one half.
                let across = along.cross(mesh.face_normal(face));
                for v in [from, to] {
                    quadrics[v.index()] += Quadric::plane(across, 0.0, 0.5);
                }
            }
        }
        quadrics
    }

    /// The quadric of the border edges at both ends, about the midpoint of the edge.
    #[inline]
    pub(crate) fn border(&self, patch: &EdgePatch<'_>) -> Quadric {
        if self.borders.is_empty() {
            return Quadric::default();
        }
        let [a, b] = patch.ends();
        self.borders[patch.removed().index()].moved_by(-a)
            + self.borders[patch.kept().index()].moved_by(-b)
    }

    /// Where the vertex has to go: `None` when it is free, or why the edge must stay.
    #[inline]
    pub(crate) fn place(&self, patch: &EdgePatch<'_>) -> Result<Option<Place>, Refusal> {
        if self.locked.is_none() && self.features.is_none() {
            return Ok(None);
        }
        let ends = [patch.removed(), patch.kept()];
        let locked = match ends.map(|v| self.is_locked(v)) {
            [true, true] => return Err(Refusal::Locked),
            [true, false] => Some(Place::Removed),
            [false, true] => Some(Place::Kept),
            [false, false] => None,
        };
        let on_line = self.place_on_line(patch, ends)?;
        match (locked, on_line) {
            (Some(a), Some(b)) if a != b => Err(Refusal::Feature),
            (locked, on_line) => Ok(locked.or(on_line)),
        }
    }

    fn place_on_line(
        &self,
        patch: &EdgePatch<'_>,
        ends: [VertexId; 2],
    ) -> Result<Option<Place>, Refusal> {
        if self.features.is_none() {
            return Ok(None);
        }
        let topology = patch.mesh().topology();
        let [removed, kept] = ends.map(|v| self.line_edges(topology, v));
        let along = self.is_feature(patch.half_edge().edge());
        if self.merges_lines(topology, patch) {
            return Err(Refusal::Feature);
        }
        match (along, removed, kept) {
            (false, 0, 0) | (true, 2, 2) => Ok(None),
            (false, 0, _) | (true, 2, _) => Ok(Some(Place::Kept)),
            (false, _, 0) | (true, _, 2) => Ok(Some(Place::Removed)),
            _ => Err(Refusal::Feature),
        }
    }

    /// The number of feature edges at a vertex.
    fn line_edges(&self, topology: &Topology, v: VertexId) -> usize {
        topology.edges_of_vertex(v).filter(|&e| self.is_feature(e)).count()
    }

    /// Whether a face that vanishes has feature lines on both of its other sides.
    fn merges_lines(&self, topology: &Topology, patch: &EdgePatch<'_>) -> bool {
        [patch.half_edge(), patch.half_edge().twin()].into_iter().any(|side| {
            let second = topology.next(side);
            let third = topology.next(second);
            let both = self.is_feature(second.edge()) && self.is_feature(third.edge());
            both && !topology.is_exterior(side)
        })
    }

    pub(crate) fn collapsed(&mut self, collapse: &Collapse, merged: [Option<(EdgeId, EdgeId)>; 2]) {
        let Collapse { removed, kept, removed_from, kept_from, position } = *collapse;
        if !self.borders.is_empty() {
            self.borders[kept.index()] = self.borders[kept.index()].moved_by(position - kept_from)
                + self.borders[removed.index()].moved_by(position - removed_from);
        }
        if let Some(locked) = &mut self.locked {
            locked[kept] |= locked[removed];
        }
        if let Some(features) = &mut self.features {
            for (gone, stays) in merged.into_iter().flatten() {
                features[stays] |= features[gone];
            }
        }
    }
}
