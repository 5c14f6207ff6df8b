//! How much a collapse changes the curvature of the vertices round it.
//!
//! What is integrated over a vertex is a sum over the corners and edges at it, so that a collapse
//! changes only the terms of the faces of its patch. The integrals of the mesh as it is are kept in
//! tables; what a collapse adds to them is evaluated in one turn round the ring of its patch. The
//! area of a vertex is a third of its faces, as in KKL02.

use core::cell::RefCell;
use core::f64::consts::PI;

use dcurv::{
    AngleSum, Area, Integral, VertexArea, VertexCurvature, VertexIntegrals, corner_direction,
    dihedral_angle, hinge_angle, unit_scaled, vertex_curvature,
};
use glam::{DVec2, DVec3};
use mesh_core::{EdgeId, EdgeMap, HalfEdgeId, Handle, TriMesh, VertexId, VertexMap, parallel};

use crate::patch::EdgePatch;

/// A number per vertex that follows from its curvature, kept up to date over collapses, and its
/// sum over a patch before and after a collapse.
#[derive(Clone, Debug)]
pub(super) struct CurvatureChange {
    measure: Measure,
    vertices: VertexMap<Term>,
    /// Half of the integral of mean curvature over each edge: the share of each end.
    hinges: EdgeMap<f64>,
    turn: RefCell<Turn>,
}

/// The number per vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    /// |k1| + |k2| at the vertex.
    AbsSum,
    /// k1² + k2² at the vertex.
    SquaredSum,
    /// |k1| + |k2| integrated over the area of the vertex.
    AbsIntegral,
}

impl Measure {
    #[inline]
    fn of(self, integrals: VertexIntegrals, boundary: bool) -> f64 {
        let area = integrals.area;
        let curvature = VertexCurvature::from_integrals(integrals, boundary);
        match self {
            Self::AbsSum => curvature.abs_principal_sum().value(),
            Self::SquaredSum => curvature.squared_principal_sum().value(),
            Self::AbsIntegral => (curvature.abs_principal_sum() * area).value(),
        }
    }
}

/// A vertex as it is.
#[derive(Clone, Copy, Debug, Default)]
struct Term {
    integrals: VertexIntegrals,
    measured: f64,
    boundary: bool,
}

impl Term {
    #[inline]
    fn new(integrals: VertexIntegrals, boundary: bool, measure: Measure) -> Self {
        Self { integrals, measured: measure.of(integrals, boundary), boundary }
    }
}

/// One turn round the ring of a patch, for one place of the vertex that remains.
#[derive(Clone, Debug, Default)]
struct Turn {
    half_edges: Vec<HalfEdgeId>,
    spokes: Vec<Spoke>,
    /// The vertex that remains, as it would be.
    center: Term,
    closed: bool,
}

/// A neighbour of the vertex that remains, and what changes there: the sums of the terms that come
/// less those that go.
#[derive(Clone, Copy, Debug)]
struct Spoke {
    /// The vertex.
    vertex: VertexId,
    /// From the vertex that remains to this one.
    along: DVec3,
    /// The normal of the face between this spoke and the one before, times its doubled area.
    normal: DVec3,
    /// The new share of mean curvature of the spoke.
    hinge: f64,
    /// The edge from this vertex to the one before, and its new share of mean curvature.
    link: EdgeId,
    link_hinge: f64,
    angle: AngleSum,
    mean: f64,
    area: f64,
    /// The vertex as it would be.
    after: Term,
}

/// The sums over the two ends of an edge and their neighbours.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sums {
    pub(super) before: f64,
    pub(super) after: f64,
}

impl CurvatureChange {
    pub(super) fn new(measure: Measure) -> Self {
        Self {
            measure,
            vertices: VertexMap::from_vec(Vec::new()),
            hinges: EdgeMap::from_vec(Vec::new()),
            turn: RefCell::default(),
        }
    }

    pub(super) fn prepare(&mut self, mesh: &TriMesh) {
        let topology = mesh.topology();
        self.hinges = EdgeMap::from_vec(parallel::collect(topology.edge_capacity(), |i| {
            let e = EdgeId::from_index(i);
            if topology.contains_edge(e) { hinge(mesh, e) } else { 0.0 }
        }));
        let measure = self.measure;
        self.vertices = VertexMap::from_vec(parallel::collect(topology.vertex_capacity(), |i| {
            let v = VertexId::from_index(i);
            if !topology.contains_vertex(v) {
                return Term::default();
            }
            let curvature = vertex_curvature(mesh, v, VertexArea::Barycentric);
            Term::new(*curvature.integrals(), curvature.is_boundary(), measure)
        }));
    }

    /// The sums before and after the collapse with the remaining vertex at `x`.
    pub(super) fn of(&self, patch: &EdgePatch<'_>, x: DVec3) -> Sums {
        let turn = &mut *self.turn.borrow_mut();
        self.go_round(turn, patch, x);
        let ends = [patch.removed(), patch.kept()].map(|v| self.vertices[v].measured);
        let mut sums = Sums { before: ends[0] + ends[1], after: turn.center.measured };
        for spoke in &turn.spokes {
            sums.before += self.vertices[spoke.vertex].measured;
            sums.after += spoke.after.measured;
        }
        sums
    }

    /// Evaluates everything that the collapse changes.
    fn go_round(&self, turn: &mut Turn, patch: &EdgePatch<'_>, x: DVec3) {
        turn.closed = patch.merged_ring(&mut turn.half_edges);
        let (mesh, origin) = (patch.mesh(), patch.origin());
        let topology = mesh.topology();
        turn.spokes.clear();
        turn.spokes.extend(turn.half_edges.iter().map(|&side| {
            let vertex = topology.target(side);
            let link = topology.next(side).edge();
            // The spoke as it is goes.
            Spoke::new(vertex, link, mesh.position(vertex) - origin - x, -self.hinges[side.edge()])
        }));
        self.remove_vanishing(patch, turn, x);
        let (angle, area) = self.turn_faces(turn, patch, x);
        let mean = turn.add_spoke_hinges();
        let full = if turn.closed { 2.0 * PI } else { PI };
        let integrals = VertexIntegrals {
            angle_defect: Integral::new(full - angle),
            mean: Integral::new(mean),
            area: Area::new(area),
            ..VertexIntegrals::default()
        };
        turn.center = Term::new(integrals, !turn.closed, self.measure);
        for spoke in &mut turn.spokes {
            let Term { integrals, boundary, .. } = self.vertices[spoke.vertex];
            spoke.after = Term::new(spoke.applied_to(&integrals), boundary, self.measure);
        }
    }

    /// Exchanges the faces that remain for those with a corner at `x`. Returns their angle there
    /// and a third of their area.
    fn turn_faces(&self, turn: &mut Turn, patch: &EdgePatch<'_>, x: DVec3) -> (f64, f64) {
        let (mesh, origin) = (patch.mesh(), patch.origin());
        let topology = mesh.topology();
        let (mut angle, mut doubled) = (AngleSum::ZERO, 0.0);
        let count = turn.spokes.len();
        for j in usize::from(!turn.closed)..count {
            let i = if j == 0 { count - 1 } else { j - 1 };
            let (from, to) = (turn.spokes[j].along, turn.spokes[i].along);
            let link = topology.next(turn.half_edges[j]);
            let along = to - from;
            let normal = from.cross(to);
            let size = normal.length();

            let end =
                patch.ends()[usize::from(topology.origin(turn.half_edges[j]) != patch.removed())];
            let (old_from, old_to) = (from + (x - end), to + (x - end));
            let old_size = old_from.cross(old_to).length();

            let outer =
                topology.apex(link.twin()).map_or(DVec3::ZERO, |v| mesh.position(v) - origin - x);
            let right = outer - from;
            let length = along.length();
            let link_hinge = match topology.is_exterior(link.twin()) {
                true => 0.0,
                false => 0.25 * length * hinge_angle(length, normal, right.cross(along), right),
            };
            let change_of_mean = link_hinge - self.hinges[link.edge()];
            let change_of_area = (size - old_size) / 6.0;

            let spoke = &mut turn.spokes[j];
            (spoke.normal, spoke.link_hinge) = (normal, link_hinge);
            spoke.angle.add(direction(along, -from, size));
            spoke.angle.subtract(direction(along, -old_from, old_size));
            spoke.mean += change_of_mean;
            spoke.area += change_of_area;
            let before = &mut turn.spokes[i];
            before.angle.add(direction(-to, -along, size));
            before.angle.subtract(direction(-old_to, -along, old_size));
            before.mean += change_of_mean;
            before.area += change_of_area;
            angle.add(direction(from, to, size));
            doubled += size;
        }
        (angle.radians(), doubled / 6.0)
    }

    /// Takes the faces that vanish away from their apexes, with the second spoke to each.
    fn remove_vanishing(&self, patch: &EdgePatch<'_>, turn: &mut Turn, x: DVec3) {
        let topology = patch.mesh().topology();
        for side in [patch.half_edge(), patch.half_edge().twin()] {
            let Some(apex) = topology.apex(side) else { continue };
            let Some(place) = turn.spokes.iter().position(|s| s.vertex == apex) else { continue };
            let second = topology.next(side);
            let third = topology.next(second);
            let known = turn.half_edges[place].edge();
            let other = if second.edge() == known { third } else { second };
            let spoke = &mut turn.spokes[place];
            let [a, b] = patch.ends().map(|end| end - x - spoke.along);
            let size = a.cross(b).length();
            spoke.angle.subtract(direction(a, b, size));
            spoke.mean -= self.hinges[other.edge()];
            spoke.area -= size / 6.0;
        }
    }

    /// Takes over what a collapse that is about to be carried out changes.
    pub(super) fn collapsing(&mut self, patch: &EdgePatch<'_>, x: DVec3) {
        let mut turn = self.turn.take();
        self.go_round(&mut turn, patch, x);
        self.vertices[patch.kept()] = turn.center;
        for (spoke, &side) in turn.spokes.iter().zip(&turn.half_edges) {
            self.vertices[spoke.vertex] = spoke.after;
            self.hinges[side.edge()] = spoke.hinge;
            self.hinges[spoke.link] = spoke.link_hinge;
        }
        // Of the two spokes to the apex of a face that vanishes, only one was met.
        let topology = patch.mesh().topology();
        for side in [patch.half_edge(), patch.half_edge().twin()] {
            let Some(apex) = topology.apex(side) else { continue };
            let Some(spoke) = turn.spokes.iter().find(|s| s.vertex == apex) else { continue };
            let second = topology.next(side);
            for either in [second, topology.next(second)] {
                self.hinges[either.edge()] = spoke.hinge;
            }
        }
        self.turn = RefCell::new(turn);
    }
}

impl Turn {
    /// Adds the new spokes to the mean curvature of their outer ends; returns their sum.
    fn add_spoke_hinges(&mut self) -> f64 {
        let count = self.spokes.len();
        let mut sum = 0.0;
        for j in 0..count {
            if !self.closed && (j == 0 || j + 1 == count) {
                continue;
            }
            let k = if j + 1 == count { 0 } else { j + 1 };
            let right = &self.spokes[k];
            let (right_normal, right_along) = (right.normal, right.along);
            let spoke = &mut self.spokes[j];
            let length = spoke.along.length();
            spoke.hinge =
                0.25 * length * hinge_angle(length, spoke.normal, right_normal, right_along);
            spoke.mean += spoke.hinge;
            sum += spoke.hinge;
        }
        sum
    }
}

impl Spoke {
    #[inline]
    fn new(vertex: VertexId, link: EdgeId, along: DVec3, mean: f64) -> Self {
        Self {
            vertex,
            along,
            normal: DVec3::ZERO,
            hinge: 0.0,
            link,
            link_hinge: 0.0,
            angle: AngleSum::ZERO,
            mean,
            area: 0.0,
            after: Term::default(),
        }
    }

    #[inline]
    fn applied_to(&self, integrals: &VertexIntegrals) -> VertexIntegrals {
        VertexIntegrals {
            angle_defect: Integral::new(integrals.angle_defect.value() - self.angle.radians()),
            mean: Integral::new(integrals.mean.value() + self.mean),
            area: Area::new((integrals.area.value() + self.area).max(0.0)),
            ..*integrals
        }
    }
}

/// The direction of the angle between `u` and `w`, for [`AngleSum`].
#[inline]
fn direction(u: DVec3, w: DVec3, cross: f64) -> DVec2 {
    unit_scaled(corner_direction(u, w, cross))
}

/// The share of mean curvature that an edge gives to each of its ends: a quarter of length times
/// dihedral angle (KKL02 sec. 3.1).
fn hinge(mesh: &TriMesh, e: EdgeId) -> f64 {
    let topology = mesh.topology();
    let [h, twin] = e.half_edges();
    let (Some(c), Some(d)) = (topology.apex(h), topology.apex(twin)) else { return 0.0 };
    let [a, b] = topology.edge_vertices(e).map(|v| mesh.position(v));
    0.25 * a.distance(b) * dihedral_angle(a, b, mesh.position(c), mesh.position(d))
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
            let mut change = CurvatureChange::new(Measure::AbsSum);
            change.prepare(&mesh);
            let total = |mesh: &TriMesh| {
                let all = mesh.topology().vertices();
                all.map(|v| {
                    vertex_curvature(mesh, v, VertexArea::Barycentric).abs_principal_sum().value()
                })
                .sum()
            };
            // The tables follow the mesh: what is foretold stays right from collapse to collapse.
            for round in 0..10 {
                let before: f64 = total(&mesh);
                let mut chosen = None;
                for (i, h) in mesh.topology().half_edges().enumerate() {
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
                    assert!(error.abs() < 1e-9 * before, "{round} {h:?}: {error}");
                    if i % 11 == round || chosen.is_none() {
                        chosen = Some((h, collapsed));
                    }
                }
                let Some((h, collapsed)) = chosen else { break };
                let mut faces = Vec::new();
                let patch = EdgePatch::gather(&mesh, h, &mut faces);
                change.collapsing(&patch, DVec3::new(0.01, 0.02, 0.03));
                mesh = collapsed;
            }
        }
    }
}
