//! A constraint that keeps small components.

use glam::DVec3;
use mesh_core::{Remap, TriMesh, VertexMap};

use super::Constraint;
use crate::geometry::edge_patch::{Collapse, EdgePatch};
use crate::policy::{Policy, Scratch};
use crate::rejection::Rejection;

/// Keeps a number of vertices in every connected component.
///
/// No collapse removes the last face of an open component, or the tetrahedron that a closed one ends as. This
/// constraint stops earlier, so that small parts keep a shape.
#[derive(Clone, Debug)]
pub struct ComponentConstraint {
    /// Components keep at least this many vertices. Components with fewer vertices are left alone.
    pub min_vertices: usize,
    of_vertex: VertexMap<Option<u32>>,
    vertices: Vec<usize>,
}

impl ComponentConstraint {
    /// A constraint that keeps this many vertices.
    #[must_use]
    pub fn new(min_vertices: usize) -> Self {
        Self { min_vertices, of_vertex: VertexMap::from_vec(Vec::new()), vertices: Vec::new() }
    }
}

impl Policy for ComponentConstraint {
    fn prepare(&mut self, mesh: &TriMesh) {
        let components = mesh.topology().components();
        self.vertices = vec![0; components.count];
        for component in components.of_vertex.as_slice().iter().flatten() {
            self.vertices[*component as usize] += 1;
        }
        self.of_vertex = components.of_vertex;
    }

    fn collapsed(&mut self, _: &TriMesh, collapse: &Collapse) {
        if let Some(component) = self.of_vertex[collapse.kept] {
            self.vertices[component as usize] -= 1;
        }
    }

    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.of_vertex = self.of_vertex.compact(remap);
    }
}

impl Constraint for ComponentConstraint {
    fn check(&self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        let component = self.of_vertex[patch.kept()];
        match component.and_then(|c| self.vertices.get(c as usize)) {
            Some(&count) if count <= self.min_vertices => Err(Rejection::Component),
            _ => Ok(()),
        }
    }
}
