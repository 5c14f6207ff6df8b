//! How much a collapse changes the curvature of the vertices round it.
//!
//! What is integrated over a vertex is a sum over the corners and edges at it, so that a collapse
//! changes only the terms of the faces of its patch. The terms of the mesh as it is are kept in
//! tables; those of the mesh as it would be are evaluated. The area of a vertex is a third of its
//! faces, as in KKL02.

use core::cell::RefCell;
use core::f64::consts::PI;

use dcurv::{Area, Integral, VertexCurvature, VertexIntegrals, corner_angle, dihedral_angle};
use glam::DVec3;
use mesh_core::{
    EdgeId, EdgeMap, HalfEdgeId, HalfEdgeMap, Handle, TriMesh, VertexId, VertexMap, parallel,
};

use super::Collapse;
use crate::patch::EdgePatch;

/// A number per vertex that follows from its curvature, kept up to date over collapses, and its
/// sum over a patch before and after a collapse.
#[derive(Clone, Debug)]
pub(super) struct CurvatureChange {
    measure: fn(&VertexCurvature) -> f64,
    vertices: VertexMap<Term>,
    /// Half of the integral of mean curvature over each edge: the share of each end.
    hinges: EdgeMap<f64>,
    /// The angle of each corner, by the half-edge that starts there.
    angles: HalfEdgeMap<f64>,
    scratch: RefCell<Scratch>,
}

/// A vertex as it is.
#[derive(Clone, Copy, Debug, Default)]
struct Term {
    integrals: VertexIntegrals,
    measured: f64,
}

#[derive(Clone, Debug, Default)]
struct Scratch {
    ring: Vec<HalfEdgeId>,
    changes: Vec<Change>,
}

/// What changes at a vertex: the sums of the terms that come less those that go.
#[derive(Clone, Copy, Debug)]
struct Change {
    vertex: VertexId,
    at: DVec3,
    angle: f64,
    mean: f64,
    area: f64,
}

/// The sums over the two ends of an edge and their neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    pub(super) before: f64,
    pub(super) after: f64,
}

impl CurvatureChange {
    pub(super) fn new(measure: fn(&VertexCurvature) -> f64) -> Self {
        Self {
            measure,
            vertices: VertexMap::from_vec(Vec::new()),
            hinges: EdgeMap::from_vec(Vec::new()),
            angles: HalfEdgeMap::from_vec(Vec::new()),
            scratch: RefCell::default(),
        }
    }

    pub(super) fn prepare(&mut self, mesh: &TriMesh) {
        let topology = mesh.topology();
        self.hinges = EdgeMap::from_vec(parallel::collect(topology.edge_capacity(), |i| {
            let e = EdgeId::from_index(i);
            if topology.contains_edge(e) { hinge(mesh, e) } else { 0.0 }
        }));
        self.angles =
            HalfEdgeMap::from_vec(parallel::collect(topology.half_edge_capacity(), |i| {
                let h = HalfEdgeId::from_index(i);
                if topology.contains_half_edge(h) { angle(mesh, h) } else { 0.0 }
            }));
        self.vertices = topology.vertex_map(Term::default());
        for v in topology.vertices() {
            self.vertices[v] = self.term(mesh, v);
        }
    }

    /// The sums before and after the collapse with the remaining vertex at `x`.
    pub(super) fn of(&self, patch: &EdgePatch<'_>, x: DVec3) -> Sums {
        let Scratch { ring, changes } = &mut *self.scratch.borrow_mut();
        let closed = patch.merged_ring(ring);
        let (mesh, origin) = (patch.mesh(), patch.origin());
        let topology = mesh.topology();
        changes.clear();
        changes.extend(ring.iter().map(|&side| {
            let vertex = topology.target(side);
            let at = mesh.position(vertex) - origin;
            // The spoke as it is goes.
            Change { vertex, at, angle: 0.0, mean: -self.hinges[side.edge()], area: 0.0 }
        }));
        self.remove_vanishing(patch, ring, changes);

        let count = ring.len();
        let (mut angle, mut mean, mut area) = (0.0, 0.0, 0.0);
        for j in usize::from(!closed)..count {
            let i = (j + count - 1) % count;
            let link = topology.next(ring[j]);
            let ([p, q], opposite) = ([changes[j].at, changes[i].at], link.twin());
            let share = (p - x).cross(q - x).length() / 6.0;
            let (at_p, at_q) = (corner_angle(p, q, x), corner_angle(q, x, p));
            let old = topology.origin(ring[j]) == patch.removed();
            let end = patch.ends()[usize::from(!old)];
            let change_of_area = share - (p - end).cross(q - end).length() / 6.0;
            let outer = topology.apex(opposite).map(|v| mesh.position(v) - origin);
            let new_hinge = outer.map_or(0.0, |o| hinge_of([p, q], [x, o]));
            let change_of_mean = new_hinge - self.hinges[link.edge()];
            changes[j].add(at_p - self.angles[link], change_of_mean, change_of_area);
            changes[i].add(at_q - self.angles[topology.next(link)], change_of_mean, change_of_area);
            angle += PI - at_p - at_q;
            area += share;
        }
        for j in 0..count {
            if !closed && (j == 0 || j + 1 == count) {
                continue;
            }
            let [i, k] = [(j + count - 1) % count, (j + 1) % count];
            let new_hinge = hinge_of([x, changes[j].at], [changes[i].at, changes[k].at]);
            changes[j].mean += new_hinge;
            mean += new_hinge;
        }
        let full = if closed { 2.0 * PI } else { PI };
        let integrals = VertexIntegrals {
            angle_defect: Integral::new(full - angle),
            mean: Integral::new(mean),
            area: Area::new(area),
            ..VertexIntegrals::default()
        };
        let ends = [patch.removed(), patch.kept()].map(|v| self.vertices[v].measured);
        let mut sums = Sums {
            before: ends[0] + ends[1],
            after: (self.measure)(&VertexCurvature::from_integrals(integrals, !closed)),
        };
        for change in changes.iter() {
            let term = &self.vertices[change.vertex];
            let boundary = topology.is_boundary_vertex(change.vertex);
            let after = change.applied_to(&term.integrals);
            sums.before += term.measured;
            sums.after += (self.measure)(&VertexCurvature::from_integrals(after, boundary));
        }
        sums
    }

    /// Takes the faces that vanish away from their apexes, with the second spoke to each.
    fn remove_vanishing(&self, patch: &EdgePatch<'_>, ring: &[HalfEdgeId], changes: &mut [Change]) {
        let topology = patch.mesh().topology();
        let ends = patch.ends();
        for side in [patch.half_edge(), patch.half_edge().twin()] {
            let Some(apex) = topology.apex(side) else { continue };
            let Some(place) = changes.iter().position(|c| c.vertex == apex) else { continue };
            let second = topology.next(side);
            let third = topology.next(second);
            let known = ring[place].edge();
            let other = if second.edge() == known { third } else { second };
            let change = &mut changes[place];
            let area = (ends[0] - change.at).cross(ends[1] - change.at).length() / 6.0;
            change.add(-self.angles[third], -self.hinges[other.edge()], -area);
        }
    }

    pub(super) fn collapsed(&mut self, mesh: &TriMesh, collapse: &Collapse) {
        let topology = mesh.topology();
        let kept = collapse.kept;
        for spoke in topology.outgoing(kept) {
            self.hinges[spoke.edge()] = hinge(mesh, spoke.edge());
            if topology.is_exterior(spoke) {
                continue;
            }
            let link = topology.next(spoke);
            self.hinges[link.edge()] = hinge(mesh, link.edge());
            for side in [spoke, link, topology.next(link)] {
                self.angles[side] = angle(mesh, side);
            }
        }
        self.vertices[kept] = self.term(mesh, kept);
        for v in topology.one_ring(kept) {
            self.vertices[v] = self.term(mesh, v);
        }
    }

    /// The integrals over a vertex as sums of what is in the tables.
    fn term(&self, mesh: &TriMesh, v: VertexId) -> Term {
        let topology = mesh.topology();
        let (mut angle, mut mean, mut area) = (0.0, 0.0, 0.0);
        for h in topology.outgoing(v) {
            mean += self.hinges[h.edge()];
            if let Some(face) = topology.face(h) {
                angle += self.angles[h];
                area += mesh.face_area(face) / 3.0;
            }
        }
        let boundary = topology.is_boundary_vertex(v);
        let full = if boundary { PI } else { 2.0 * PI };
        let integrals = VertexIntegrals {
            angle_defect: Integral::new(full - angle),
            mean: Integral::new(mean),
            area: Area::new(area),
            ..VertexIntegrals::default()
        };
        let measured = (self.measure)(&VertexCurvature::from_integrals(integrals, boundary));
        Term { integrals, measured }
    }
}

impl Change {
    #[inline]
    fn add(&mut self, angle: f64, mean: f64, area: f64) {
        self.angle += angle;
        self.mean += mean;
        self.area += area;
    }

    fn applied_to(&self, integrals: &VertexIntegrals) -> VertexIntegrals {
        VertexIntegrals {
            angle_defect: Integral::new(integrals.angle_defect.value() - self.angle),
            mean: Integral::new(integrals.mean.value() + self.mean),
            area: Area::new((integrals.area.value() + self.area).max(0.0)),
            ..*integrals
        }
    }
}

/// The share of mean curvature that an edge gives to each of its ends.
fn hinge(mesh: &TriMesh, e: EdgeId) -> f64 {
    let topology = mesh.topology();
    let [h, twin] = e.half_edges();
    let (Some(c), Some(d)) = (topology.apex(h), topology.apex(twin)) else { return 0.0 };
    let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v));
    hinge_of([a, b], [mesh.position(c), mesh.position(d)])
}

/// A quarter of length times dihedral angle of the edge (a, b) between the faces to its left and
/// right with these apexes (KKL02 sec. 3.1).
#[inline]
fn hinge_of([a, b]: [DVec3; 2], [left, right]: [DVec3; 2]) -> f64 {
    0.25 * a.distance(b) * dihedral_angle(a, b, left, right)
}

/// The angle of the corner where a half-edge starts; 0 for an exterior one.
fn angle(mesh: &TriMesh, h: HalfEdgeId) -> f64 {
    let topology = mesh.topology();
    let Some(apex) = topology.apex(h) else { return 0.0 };
    let [a, b] = [topology.origin(h), topology.target(h)].map(|v| mesh.position(v));
    corner_angle(a, b, mesh.position(apex))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dcurv::{VertexArea, vertex_curvature};
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
                all.map(|v| {
                    vertex_curvature(mesh, v, VertexArea::Barycentric).abs_principal_sum().value()
                })
                .sum()
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
