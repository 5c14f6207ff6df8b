//! The change of the curvature of the vertices around a collapse.
//!
//! An integral over a vertex is a sum over its corners and edges, so a collapse changes only the terms of the faces of
//! its patch. The integrals of the current mesh are kept in tables; [`MergedRing`] computes their values after a
//! collapse. The area of a vertex is a third of its faces, as in KKL02.

pub(super) mod measure;
mod merged_ring;
mod rows;
mod tables;

use glam::DVec3;
use mesh_core::{Remap, TriMesh, VertexId};

use crate::cost::curvature_change::measure::Measure;
use crate::cost::curvature_change::merged_ring::MergedRing;
use crate::cost::curvature_change::tables::Tables;
use crate::geometry::edge_patch::EdgePatch;
use crate::policy::Scratch;

/// A number per vertex derived from its curvature, updated with each collapse, and its sum over a patch before and
/// after a collapse.
#[derive(Clone, Debug)]
pub(super) struct CurvatureChange {
    measure: Measure,
    tables: Tables,
    /// The number of changes of the tables.
    version: u64,
}

/// The sums over the two ends of an edge and their neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    pub(super) before: f64,
    pub(super) after: f64,
}

impl CurvatureChange {
    pub(super) fn new(measure: Measure) -> Self {
        Self { measure, tables: Tables::empty(), version: 0 }
    }

    pub(super) fn prepare(&mut self, mesh: &TriMesh) {
        self.tables = Tables::new(mesh, self.measure);
        self.version += 1;
    }

    pub(super) fn compacted(&mut self, remap: &Remap) {
        self.tables = self.tables.compact(remap);
        self.version += 1;
    }

    /// The sums before and after the collapse with the remaining vertex at `x`.
    pub(super) fn of(&self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) -> Sums {
        let star: &mut MergedRing = scratch.get();
        star.evaluate(&self.tables, (self.measure, self.version), patch, x);
        let measured = |v: VertexId| self.tables.vertices[v].measured;
        let neighbours =
            star.incident_edges().iter().map(|incident_edge| measured(incident_edge.vertex));
        Sums {
            before: measured(patch.removed()) + measured(patch.kept()) + neighbours.sum::<f64>(),
            after: star.center().measured + star.measured().iter().sum::<f64>(),
        }
    }

    /// Updates the tables for a collapse that is about to be carried out.
    pub(super) fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3, scratch: &mut Scratch) {
        let star: &mut MergedRing = scratch.get();
        star.evaluate(&self.tables, (self.measure, self.version), patch, x);
        self.version += 1;
        let Tables { vertices, hinges, corners, thirds } = &mut self.tables;
        let topology = patch.mesh().topology();
        vertices[patch.kept()] = *star.center();
        for (i, incident_edge) in star.incident_edges().iter().enumerate() {
            vertices[incident_edge.vertex] = star.neighbour(i);
            hinges[incident_edge.side.edge()] = star.incident_hinge(i);
            let (Some(face), Some(f)) = (star.face(i), topology.face(incident_edge.side)) else {
                continue;
            };
            let link = topology.next(incident_edge.side);
            hinges[link.edge()] = face.link_hinge;
            let sides = [incident_edge.side, link, topology.next(link)];
            sides.into_iter().zip(face.angles).for_each(|(side, angle)| corners[side] = angle);
            thirds[f] = face.third;
        }
        // The star contains only one of the two incident edges to the apex of a vanishing face. Either may stay, with
        // one half-edge taking the place of the twin of the other.
        for side in [patch.half_edge(), patch.half_edge().twin()] {
            if topology.is_exterior(side) {
                continue;
            }
            let second = topology.next(side);
            let third = topology.next(second);
            let apex = topology.target(second);
            let Some(i) = star.incident_edges().iter().position(|s| s.vertex == apex) else {
                continue;
            };
            for (this, other) in [(second, third), (third, second)] {
                hinges[this.edge()] = star.incident_hinge(i);
                corners[this] = corners[other.twin()];
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use dcurv::{VertexArea, vertex_curvature};
    use mesh_shapes::{Plane, Sphere};

    /// A closed mesh, the hull of `points` random points, and a mesh with a boundary, both bent.
    pub(super) fn bent_meshes(points: usize, seed: u64, cells: usize) -> [TriMesh; 2] {
        let plane = Plane { half_width: 1.0 }.mesh(cells, Default::default()).unwrap();
        [Sphere { radius: 1.0 }.random_hull(points, seed).unwrap(), plane].map(|soup| {
            let mut mesh = TriMesh::from_soup(&soup).unwrap();
            for (i, p) in mesh.positions_mut().iter_mut().enumerate() {
                p.z += 0.05 * (i as f64).sin();
            }
            mesh
        })
    }

    /// The tables of unsigned angles: every edge gives a quarter of |e| |beta| to each end, and a
    /// collapse leads to the tables of the collapsed mesh.
    #[test]
    fn unsigned_angles_add_up_without_cancelling() {
        for mesh in bent_meshes(60, 5, 4) {
            let measure = Measure::UnsignedAbsSum;
            let topology = mesh.topology();
            let edges = dcurv::edge_mean_curvatures(&mesh);
            let tables = Tables::new(&mesh, measure);
            let mut cancels = false;
            for v in topology.vertices() {
                let of_edges = topology.outgoing(v).filter_map(|h| edges[h.edge()]);
                let [signed, unsigned] = of_edges.fold([0.0, 0.0], |[s, u], mean| {
                    [s + 0.5 * mean.value(), u + 0.5 * mean.value().abs()]
                });
                cancels |= unsigned > 1.1 * signed.abs();
                assert!((tables.vertices[v].integrals.mean.value() - unsigned).abs() < 1e-12);
            }
            assert!(cancels, "no edge is concave: the test is void");
            let mut change = CurvatureChange::new(measure);
            change.prepare(&mesh);
            let scratch = &mut Scratch::default();
            let mut faces = Vec::new();
            let sum = |tables: &Tables, mesh: &TriMesh| -> f64 {
                mesh.topology().vertices().map(|v| tables.vertices[v].measured).sum()
            };
            let before = sum(&tables, &mesh);
            for h in topology.half_edges() {
                let Ok(legal) = topology.check_collapse(h) else { continue };
                let patch = EdgePatch::gather(&mesh, h, &mut faces);
                let x = DVec3::new(0.01, 0.02, 0.03);
                let sums = change.of(&patch, x, scratch);
                let position = patch.origin() + x;
                let mut collapsed = mesh.clone();
                collapsed.collapse(legal, position);
                let after = sum(&Tables::new(&collapsed, measure), &collapsed);
                let error = (after - before) - (sums.after - sums.before);
                assert!(error.abs() < 1e-9 * before, "{h:?}: {error}");
            }
        }
    }

    /// What is foretold is what comes about, inside and on the boundary.
    #[test]
    fn sums_are_those_of_the_collapsed_mesh() {
        for mut mesh in bent_meshes(60, 5, 4) {
            let mut change = CurvatureChange::new(Measure::AbsSum);
            change.prepare(&mesh);
            let scratch = &mut Scratch::default();
            let total = |mesh: &TriMesh| {
                let all = mesh.topology().vertices();
                all.map(|v| {
                    vertex_curvature(mesh, v, VertexArea::Barycentric).abs_principal_sum().value()
                })
                .sum()
            };
            // The tables follow the mesh, so predictions stay correct over several collapses.
            for round in 0..10 {
                let before: f64 = total(&mesh);
                let mut chosen = None;
                for (i, h) in mesh.topology().half_edges().enumerate() {
                    let Ok(legal) = mesh.topology().check_collapse(h) else { continue };
                    let mut faces = Vec::new();
                    let patch = EdgePatch::gather(&mesh, h, &mut faces);
                    let x = DVec3::new(0.01, 0.02, 0.03);
                    let sums = change.of(&patch, x, scratch);
                    let position = patch.origin() + x;
                    let mut collapsed = mesh.clone();
                    collapsed.collapse(legal, position);
                    let after: f64 = total(&collapsed);
                    let error = (after - before) - (sums.after - sums.before);
                    assert!(error.abs() < 1e-9 * before, "{round} {h:?}: {error}");
                    if i % 11 == round || chosen.is_none() {
                        chosen = Some((h, collapsed));
                    }
                }
                let Some((h, collapsed)) = chosen else { break };
                let mut faces = Vec::new();
                let patch = EdgePatch::gather(&mesh, h, &mut faces);
                change.collapsing(&patch, DVec3::new(0.01, 0.02, 0.03), scratch);
                mesh = collapsed;
            }
        }
    }
}
