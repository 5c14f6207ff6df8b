//! The positions that the protections of a run allow for a vertex.

use mesh_core::{EdgeId, Topology, TriMesh, VertexId};

use crate::constraint::Constraints;
use crate::geometry::edge_patch::{Collapse, EdgePatch, Place};
use crate::geometry::quadric::Quadric;
use crate::protect::{Boundary, Protect, Protected};
use crate::rejection::Rejection;

/// The protections during a run, kept up to date.
#[derive(Clone, Debug)]
pub(crate) struct VertexFreedom {
    protected: Protected,
    /// The quadrics of border edges at each vertex, about its position. Empty if there are none.
    borders: Vec<Quadric>,
}

impl VertexFreedom {
    /// The constraints must follow the mesh already. The quadrics of border edges are computed from the current mesh
    /// unless others are given.
    pub(crate) fn new(
        mesh: &TriMesh,
        protect: &Protect,
        constraints: Constraints,
        borders: Option<Vec<Quadric>>,
    ) -> Self {
        let protected = Protected::new(mesh, protect, constraints);
        let mut fixed = Self { protected, borders: Vec::new() };
        let with_boundary = protect.boundary != Boundary::Free;
        fixed.borders = borders.unwrap_or_else(|| fixed.border_quadrics(mesh, with_boundary));
        fixed
    }

    /// For each vertex, the accumulated quadric of border edges, about its position; empty if no vertex has one.
    pub(crate) fn borders(&self) -> &[Quadric] {
        &self.borders
    }

    /// The constraints that followed the mesh before the run.
    pub(crate) fn constraints(&self) -> &Constraints {
        &self.protected.constraints
    }

    /// The protected elements and the constraints, in their current state.
    pub(crate) fn into_marks(self) -> Protected {
        self.protected
    }

    fn border_quadrics(&self, mesh: &TriMesh, with_boundary: bool) -> Vec<Quadric> {
        let topology = mesh.topology();
        let mut quadrics = Vec::new();
        let is_border = |&e: &EdgeId| {
            self.protected.is_feature(e) || (with_boundary && topology.is_boundary_edge(e))
        };
        for e in topology.edges().filter(is_border) {
            if quadrics.is_empty() {
                quadrics = vec![Quadric::default(); topology.vertex_capacity()];
            }
            let [from, to] = topology.edge_vertices(e);
            let along = mesh.position(to) - mesh.position(from);
            for face in topology.edge_faces(e).into_iter().flatten() {
                // The length of the edge times a unit vector, so the weight is one half.
                let across = along.cross(mesh.face_normal(face));
                for v in [from, to] {
                    quadrics[v.index()] += Quadric::plane(across, 0.0, 0.5);
                }
            }
        }
        quadrics
    }

    /// The factor on the cost of an edge, from the importance of its ends.
    #[inline]
    pub(crate) fn cost_factor(&self, patch: &EdgePatch<'_>) -> f64 {
        self.protected.cost_factor([patch.removed(), patch.kept()])
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

    /// The position that the vertex must take: `None` if it is free; an error if the edge must stay.
    #[inline]
    pub(crate) fn place(&self, patch: &EdgePatch<'_>) -> Result<Option<Place>, Rejection> {
        if self.protected.locked.is_none() && self.protected.features.is_none() {
            return Ok(None);
        }
        let ends = [patch.removed(), patch.kept()];
        let locked = match ends.map(|v| self.protected.is_locked(v)) {
            [true, true] => return Err(Rejection::Locked),
            [true, false] => Some(Place::Removed),
            [false, true] => Some(Place::Kept),
            [false, false] => None,
        };
        let on_line = self.place_on_line(patch, ends)?;
        match (locked, on_line) {
            (Some(a), Some(b)) if a != b => Err(Rejection::Feature),
            (locked, on_line) => Ok(locked.or(on_line)),
        }
    }

    fn place_on_line(
        &self,
        patch: &EdgePatch<'_>,
        ends: [VertexId; 2],
    ) -> Result<Option<Place>, Rejection> {
        if self.protected.features.is_none() {
            return Ok(None);
        }
        let topology = patch.mesh().topology();
        let [removed, kept] = ends.map(|v| self.line_edges(topology, v));
        let along = self.protected.is_feature(patch.half_edge().edge());
        if self.merges_lines(topology, patch) {
            return Err(Rejection::Feature);
        }
        match (along, removed, kept) {
            (false, 0, 0) | (true, 2, 2) => Ok(None),
            (false, 0, _) | (true, 2, _) => Ok(Some(Place::Kept)),
            (false, _, 0) | (true, _, 2) => Ok(Some(Place::Removed)),
            _ => Err(Rejection::Feature),
        }
    }

    /// The number of feature edges at a vertex.
    fn line_edges(&self, topology: &Topology, v: VertexId) -> usize {
        topology.edges_of_vertex(v).filter(|&e| self.protected.is_feature(e)).count()
    }

    /// Whether a vanishing face has feature lines on both of its other sides.
    fn merges_lines(&self, topology: &Topology, patch: &EdgePatch<'_>) -> bool {
        [patch.half_edge(), patch.half_edge().twin()].into_iter().any(|side| {
            let second = topology.next(side);
            let third = topology.next(second);
            let both =
                self.protected.is_feature(second.edge()) && self.protected.is_feature(third.edge());
            both && !topology.is_exterior(side)
        })
    }

    /// Updates the data after a collapse has been carried out.
    pub(crate) fn collapsed(
        &mut self,
        mesh: &TriMesh,
        collapse: &Collapse,
        merged: [Option<(EdgeId, EdgeId)>; 2],
    ) {
        let Collapse { removed, kept, removed_from, kept_from, position } = *collapse;
        if !self.borders.is_empty() {
            self.borders[kept.index()] = self.borders[kept.index()].moved_by(position - kept_from)
                + self.borders[removed.index()].moved_by(position - removed_from);
        }
        self.protected.collapsed(mesh, collapse, merged);
    }
}
