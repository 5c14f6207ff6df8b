//! A constraint against intersections of faces.

use glam::DVec3;
use mesh_core::{Remap, TriMesh};

use super::Constraint;
use crate::geometry::edge_patch::{Collapse, EdgePatch};
use crate::geometry::new_intersections::{ChangedFace, NewIntersections};
use crate::policy::{Policy, Scratch};
use crate::rejection::Rejection;

/// Rejects collapses after which faces cross, or touch away from common vertices and edges, if they did not before. The
/// test is exact and has no tolerance.
///
/// Parts of an assembly may have vertices at equal positions at the start, and may then continue to touch there.
/// Vertices of different parts at the same position count as one vertex. Faces at a seam or wall shared by two parts
/// may touch or overlap, provided that all edges that meet the other part start at the seam. Everything else counts as
/// crossing, so parts cannot pass through each other.
#[derive(Clone, Debug, Default)]
pub struct IntersectionConstraint {
    found: Option<NewIntersections>,
}

impl Policy for IntersectionConstraint {
    fn prepare(&mut self, mesh: &TriMesh) {
        self.found = Some(NewIntersections::new(mesh));
    }

    fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        if let Some(found) = &mut self.found {
            found.collapsed(mesh, collapse.removed, collapse.kept);
        }
    }

    fn compacted(&mut self, mesh: &TriMesh, _: &Remap) {
        self.prepare(mesh);
    }
}

impl Constraint for IntersectionConstraint {
    fn check(
        &self,
        patch: &EdgePatch<'_>,
        x: DVec3,
        scratch: &mut Scratch,
    ) -> Result<(), Rejection> {
        let Some(found) = &self.found else { return Ok(()) };
        let (mesh, removed, kept) = (patch.mesh(), patch.removed(), patch.kept());
        let topology = mesh.topology();
        let place = patch.origin() + x;
        let merged = found.merged(removed, kept);
        let is_end = |v| v == removed || v == kept;
        let changed: &mut Vec<ChangedFace> = scratch.get();
        changed.clear();
        changed.extend(patch.remaining_faces().iter().filter_map(|face| {
            let face = topology.face(face.side)?;
            let vertices = topology.face_vertices(face);
            let corners = vertices.map(|v| if is_end(v) { place } else { mesh.position(v) });
            let vertices = vertices.map(|v| if is_end(v) { merged } else { v });
            Some(ChangedFace { face, triangle: (vertices, corners) })
        }));
        let sides = [patch.half_edge(), patch.half_edge().twin()];
        let gone: Vec<_> = sides.into_iter().filter_map(|side| topology.face(side)).collect();
        if found.would_arise(mesh, changed, &gone) { Err(Rejection::Intersection) } else { Ok(()) }
    }
}
