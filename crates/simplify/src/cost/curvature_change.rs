//! How much a collapse changes the curvature of the vertices round it.

use core::cell::RefCell;

use dcurv::{VertexArea, VertexCurvature, VertexStar, vertex_curvature};
use glam::DVec3;
use mesh_core::{Handle, TriMesh, VertexId, VertexMap, parallel};

use super::Collapse;
use crate::patch::EdgePatch;

/// A number per vertex that follows from its curvature, kept up to date over collapses, and its
/// sum over a patch before and after a collapse.
#[derive(Clone, Debug)]
pub(super) struct CurvatureChange {
    measure: fn(&VertexCurvature) -> f64,
    now: VertexMap<f64>,
    scratch: RefCell<Scratch>,
}

#[derive(Clone, Debug, Default)]
struct Scratch {
    ring: Vec<VertexId>,
    star: Vec<DVec3>,
}

/// The sums over the two ends of an edge and their neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    pub(super) before: f64,
    pub(super) after: f64,
}

/// KKL02 takes a third of the faces as the area of a vertex.
const AREA: VertexArea = VertexArea::Barycentric;

impl CurvatureChange {
    pub(super) fn new(measure: fn(&VertexCurvature) -> f64) -> Self {
        Self { measure, now: VertexMap::from_vec(Vec::new()), scratch: RefCell::default() }
    }

    pub(super) fn prepare(&mut self, mesh: &TriMesh) {
        let (topology, measure) = (mesh.topology(), self.measure);
        self.now = VertexMap::from_vec(parallel::collect(topology.vertex_capacity(), |index| {
            let v = VertexId::from_index(index);
            let is_used = topology.contains_vertex(v);
            if is_used { measure(&vertex_curvature(mesh, v, AREA)) } else { 0.0 }
        }));
    }

    /// The sums before and after the collapse with the remaining vertex at `x`.
    pub(super) fn of(&self, patch: &EdgePatch<'_>, x: DVec3) -> Sums {
        let Scratch { ring, star } = &mut *self.scratch.borrow_mut();
        let closed = patch.merged_ring(ring);
        let (mesh, origin) = (patch.mesh(), patch.origin());
        let ends = [patch.removed(), patch.kept()];
        star.clear();
        star.extend(ring.iter().map(|&v| mesh.position(v) - origin));
        let mut before = self.now[ends[0]] + self.now[ends[1]];
        let mut after = self.measure(x, star, closed);
        for &v in ring.iter() {
            before += self.now[v];
            star.clear();
            let is_end = |w: VertexId| w == ends[0] || w == ends[1];
            let mut last_is_end = false;
            for w in mesh.topology().one_ring(v) {
                // The two ends, one after the other, become one neighbour.
                if !(last_is_end && is_end(w)) {
                    star.push(if is_end(w) { x } else { mesh.position(w) - origin });
                }
                last_is_end = is_end(w);
            }
            let closed = !mesh.topology().is_boundary_vertex(v);
            if closed && star.first() == Some(&x) && star.last() == Some(&x) {
                star.pop();
            }
            after += self.measure(mesh.position(v) - origin, star, closed);
        }
        Sums { before, after }
    }

    fn measure(&self, center: DVec3, ring: &[DVec3], closed: bool) -> f64 {
        let integrals = VertexStar { center, ring, closed }.integrals(AREA);
        (self.measure)(&VertexCurvature::from_integrals(integrals, !closed))
    }

    pub(super) fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let kept = collapse.kept;
        self.now[kept] = (self.measure)(&vertex_curvature(mesh, kept, AREA));
        for v in mesh.topology().one_ring(kept) {
            self.now[v] = (self.measure)(&vertex_curvature(mesh, v, AREA));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::shapes::{Plane, Sphere};

    /// What is foretold is what comes about, inside and on the boundary.
    #[test]
    fn sums_are_those_of_the_collapsed_mesh() {
        let plane = Plane { half_width: 1.0 }.mesh(4, Default::default()).unwrap();
        for soup in [Sphere { radius: 1.0 }.random_hull(60, 5).unwrap(), plane] {
            let triangles: Vec<[u32; 3]> = soup.faces().map(|f| f.try_into().unwrap()).collect();
            let mut mesh = TriMesh::from_triangles(soup.positions(), &triangles).unwrap();
            for (i, p) in mesh.positions_mut().iter_mut().enumerate() {
                p.z += 0.05 * (i as f64).sin();
            }
            let mut change = CurvatureChange::new(|c| c.abs_principal_sum().value());
            change.prepare(&mesh);
            let total = |mesh: &TriMesh| {
                let all = mesh.topology().vertices();
                all.map(|v| vertex_curvature(mesh, v, AREA).abs_principal_sum().value()).sum()
            };
            let before: f64 = total(&mesh);
            for h in mesh.topology().half_edges() {
                let Ok(legal) = mesh.topology().check_collapse(h) else { continue };
                let mut faces = Vec::new();
                let patch = EdgePatch::gather(&mesh, h, &mut faces);
                let x = DVec3::new(0.01, 0.02, 0.03);
                let sums = change.of(&patch, x);
                let position = patch.origin() + x;
                let mut collapsed = mesh.clone();
                collapsed.collapse(legal, position);
                let after: f64 = total(&collapsed);
                let error = (after - before) - (sums.after - sums.before);
                assert!(error.abs() < 1e-9 * before, "{h:?}: {error}");
            }
        }
    }
}
