//! The normal equations of one step of a fit, and their solution.

use glam::DVec3;
use mesh_core::{EdgeId, FaceId, TriMesh, VertexId};

use crate::collapse::symmetric::{Factors, Symmetric3};
use crate::finish::fit::constraints::FitConstraints;
use crate::finish::fit::freedom::Freedom;
use crate::finish::fit::pairs::Target;

/// How much a pair counts.
#[derive(Clone, Copy)]
pub(super) struct Weighting {
    pub(super) pull: f64,
    pub(super) tail: f64,
    /// The largest squared distance of a pair.
    pub(super) largest: f64,
}

impl Weighting {
    fn of(&self, squared: f64) -> f64 {
        let ratio = if self.largest > 0.0 { squared / self.largest } else { 0.0 };
        1.0 + self.tail * ratio.powi(6)
    }
}

/// The normal equations of the Gauss-Newton step, in blocks of three by three: one per vertex and
/// one per edge.
pub(super) struct System {
    of_vertex: Vec<Symmetric3>,
    of_edge: Vec<Symmetric3>,
    /// Minus the gradient where the vertices are.
    residual: Vec<DVec3>,
}

impl System {
    pub(super) fn new(mesh: &TriMesh) -> Self {
        let topology = mesh.topology();
        Self {
            of_vertex: vec![Symmetric3::default(); topology.vertex_capacity()],
            of_edge: vec![Symmetric3::default(); topology.edge_capacity()],
            residual: vec![DVec3::ZERO; topology.vertex_capacity()],
        }
    }

    /// Adds a pair: the point of `face` with these weights and its target. Returns the squared
    /// distance of the two.
    pub(super) fn add(
        &mut self,
        mesh: &TriMesh,
        face: FaceId,
        weights: DVec3,
        target: Target,
        weighting: Weighting,
    ) -> f64 {
        let sides = mesh.topology().face_half_edges(face);
        let corners = mesh.topology().face_vertices(face);
        let [a, b, c] = corners.map(|v| mesh.position(v) - target.point);
        let gap = a * weights.x + b * weights.y + c * weights.z;
        let squared = gap.length_squared();
        let weight = weighting.of(squared);
        let mut matrix = Symmetric3::square(target.normal, weight);
        matrix.diagonal += weight * weighting.pull;
        let force = matrix.times(gap);
        for i in 0..3 {
            self.of_vertex[corners[i].index()] += weights[i] * weights[i] * matrix;
            self.of_edge[sides[i].edge().index()] += weights[i] * weights[(i + 1) % 3] * matrix;
            self.residual[corners[i].index()] -= weights[i] * force;
        }
        squared
    }

    /// Adds a pair of the point that is `along` an edge, as a part of its length, and its target.
    pub(super) fn add_to_edge(&mut self, mesh: &TriMesh, edge: EdgeId, along: f64, target: DVec3) {
        let ends = mesh.topology().edge_vertices(edge);
        let [a, b] = ends.map(|v| mesh.position(v) - target);
        let weights = [1.0 - along, along];
        let force = weights[0] * a + weights[1] * b;
        let unit = Symmetric3 { diagonal: DVec3::ONE, mixed: DVec3::ZERO };
        for (v, weight) in ends.into_iter().zip(weights) {
            self.of_vertex[v.index()] += weight * weight * unit;
            self.residual[v.index()] -= weight * force;
        }
        self.of_edge[edge.index()] += weights[0] * weights[1] * unit;
    }

    /// The displacement of each vertex, by conjugate gradients preconditioned with the blocks of
    /// the vertices.
    pub(super) fn solve(
        &self,
        mesh: &TriMesh,
        freedoms: &[Freedom],
        constraints: &FitConstraints,
    ) -> Vec<DVec3> {
        let inverses: Vec<Inverse> = freedoms
            .iter()
            .zip(&self.of_vertex)
            .zip(mesh.positions())
            .map(|((&freedom, block), &at)| match (freedom, freedom.curve(constraints)) {
                (Freedom::Free, _) => Inverse::of(block),
                (_, Some(curve)) => Inverse::along(block, curve.direction(at)),
                _ => Inverse::Zero,
            })
            .collect();
        let precondition = |r: &[DVec3]| -> Vec<DVec3> {
            r.iter().zip(&inverses).map(|(r, inverse)| inverse.times(*r)).collect()
        };
        let dot =
            |p: &[DVec3], q: &[DVec3]| -> f64 { p.iter().zip(q).map(|(a, b)| a.dot(*b)).sum() };
        let mut x = vec![DVec3::ZERO; freedoms.len()];
        let mut r = self.residual.clone();
        let mut z = precondition(&r);
        let mut p = z.clone();
        let mut rz = dot(&r, &z);
        let enough = TOLERANCE * TOLERANCE * rz;
        for _ in 0..ITERATIONS {
            if rz <= enough {
                break;
            }
            let ap = self.times(mesh, &p);
            let step = rz / dot(&p, &ap);
            if !step.is_finite() {
                break;
            }
            for v in 0..freedoms.len() {
                x[v] += step * p[v];
                r[v] -= step * ap[v];
            }
            z = precondition(&r);
            let following = dot(&r, &z);
            let keep = following / rz;
            rz = following;
            for v in 0..freedoms.len() {
                p[v] = z[v] + keep * p[v];
            }
        }
        x
    }

    fn times(&self, mesh: &TriMesh, p: &[DVec3]) -> Vec<DVec3> {
        let topology = mesh.topology();
        let mut out: Vec<DVec3> =
            p.iter().zip(&self.of_vertex).map(|(p, block)| block.times(*p)).collect();
        for e in topology.edges() {
            let [a, b] = topology.edge_vertices(e).map(VertexId::index);
            out[a] += self.of_edge[e.index()].times(p[b]);
            out[b] += self.of_edge[e.index()].times(p[a]);
        }
        out
    }
}

/// The inverse of the block of a vertex among the directions in which it may go. What it gives has
/// no part in the others, so that conjugate gradients stay among these directions.
enum Inverse {
    Zero,
    Full(Factors),
    Along(DVec3),
}

impl Inverse {
    fn of(block: &Symmetric3) -> Self {
        block.factors(DAMPING).map_or(Self::Zero, Self::Full)
    }

    fn along(block: &Symmetric3, direction: DVec3) -> Self {
        let scale = direction.dot(block.times(direction)).sqrt().recip();
        if scale.is_finite() { Self::Along(scale * direction) } else { Self::Zero }
    }

    fn times(&self, r: DVec3) -> DVec3 {
        match self {
            Self::Zero => DVec3::ZERO,
            Self::Full(factors) => factors.solve(r),
            Self::Along(direction) => direction.dot(r) * *direction,
        }
    }
}

/// Relative to the trace of a block.
const DAMPING: f64 = 1e-9;
const TOLERANCE: f64 = 1e-4;
const ITERATIONS: usize = 60;
